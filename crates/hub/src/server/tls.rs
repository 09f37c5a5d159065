//! Certificates: those of the hub, of its clients, and of PostgreSQL.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use lafet_client::SystemError;
use lafet_texts::{Text, hub as text};
use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::{self, CryptoProvider};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};

use crate::config::TlsConfig;
use crate::sync::lock;
use crate::text::Both;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}", path.display(), what.en)]
pub struct FileError {
    path: PathBuf,
    what: Both,
}

impl FileError {
    fn new(path: &Path, what: &dyn Text) -> Self {
        Self { path: path.to_owned(), what: what.words() }
    }

    fn pem(path: &Path, error: &rustls_pki_types::pem::Error, none: &dyn Text) -> Self {
        use rustls_pki_types::pem::Error;
        match error {
            Error::NoItemsFound => Self::new(path, none),
            Error::Io(error) => {
                Self::new(path, &text::FileUnreadable { error: SystemError(error) })
            }
            other => Self::new(path, &text::FileNoPem { error: other.to_string() }),
        }
    }

    fn tls(path: &Path, error: &rustls::Error) -> Self {
        Self::new(path, &text::FileUseless { error: error.to_string() })
    }

    /// The file, and what is wrong with it.
    pub fn both(&self) -> Both {
        let path = self.path.display();
        text::FileWrong { path: format_args!("{path}"), what: &self.what }.words()
    }
}

/// What everything of TLS is computed by.
pub fn provider() -> Arc<CryptoProvider> {
    Arc::new(crypto::ring::default_provider())
}

/// The certificates of a PEM file: one at least.
pub fn chain(path: &Path) -> Result<Vec<CertificateDer<'static>>, FileError> {
    let none = &text::FileNoCertificate;
    let read = CertificateDer::pem_file_iter(path).and_then(Iterator::collect);
    let chain: Vec<_> = read.map_err(|error| FileError::pem(path, &error, none))?;
    if chain.is_empty() {
        return Err(FileError::pem(path, &rustls_pki_types::pem::Error::NoItemsFound, none));
    }
    Ok(chain)
}

/// The private key of a PEM file.
pub fn key(path: &Path) -> Result<PrivateKeyDer<'static>, FileError> {
    PrivateKeyDer::from_pem_file(path)
        .map_err(|error| FileError::pem(path, &error, &text::FileNoKey))
}

/// The certificates of a PEM file, and the same as those that sign others.
pub fn roots(path: &Path) -> Result<(RootCertStore, Vec<CertificateDer<'static>>), FileError> {
    let (mut roots, listed) = (RootCertStore::empty(), chain(path)?);
    for certificate in &listed {
        roots.add(certificate.clone()).map_err(|error| FileError::tls(path, &error))?;
    }
    Ok((roots, listed))
}

/// Everything that is wrong with the files.
pub fn problems(config: &TlsConfig) -> Vec<Both> {
    let files = [
        chain(&config.cert).err(),
        key(&config.key).err(),
        config.client_ca.as_ref().and_then(|path| roots(path).err()),
    ];
    let of_files: Vec<Both> = files.iter().flatten().map(FileError::both).collect();
    if of_files.is_empty() {
        acceptor(config).err().iter().map(FileError::both).collect()
    } else {
        of_files
    }
}

/// What takes connections with TLS.
pub fn acceptor(config: &TlsConfig) -> Result<TlsAcceptor, FileError> {
    let of_cert = |error: rustls::Error| FileError::tls(&config.cert, &error);
    let provider = provider();
    let builder = ServerConfig::builder_with_provider(provider.clone())
        .with_safe_default_protocol_versions()
        .map_err(of_cert)?;
    let builder = match &config.client_ca {
        None => builder.with_no_client_auth(),
        Some(path) => {
            let roots = Arc::new(roots(path)?.0);
            let verifier = WebPkiClientVerifier::builder_with_provider(roots, provider).build();
            builder.with_client_cert_verifier(verifier.map_err(|error| {
                FileError::new(path, &text::FileUseless { error: error.to_string() })
            })?)
        }
    };
    let (chain, key) = (chain(&config.cert)?, key(&config.key)?);
    let mut server = builder.with_single_cert(chain, key).map_err(of_cert)?;
    server.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(TlsAcceptor::from(Arc::new(server)))
}

/// The files as they were read: times of their last change, and sizes.
type Stamp = Vec<Option<(SystemTime, u64)>>;

/// Takes connections with TLS, with the certificates as they are in their files now.
pub struct Reloading {
    config: TlsConfig,
    now: Mutex<(Stamp, TlsAcceptor)>,
    /// What was looked at last and could not be used: it is reported once.
    useless: Mutex<Stamp>,
}

impl std::fmt::Debug for Reloading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reloading").field("config", &self.config).finish_non_exhaustive()
    }
}

impl Reloading {
    /// Reads the files.
    pub fn new(config: &TlsConfig) -> Result<Self, FileError> {
        let now = Mutex::new((stamp(config), acceptor(config)?));
        Ok(Self { config: config.clone(), now, useless: Mutex::default() })
    }

    /// The files.
    pub const fn config(&self) -> &TlsConfig {
        &self.config
    }

    /// What takes the next connection. Open ones go on with what they began with.
    pub fn acceptor(&self) -> TlsAcceptor {
        lock(&self.now).1.clone()
    }

    /// Reads the files again if they have changed, and says so. Of files that cannot be used, as while one of
    /// two is written, the old ones stay. Waits for the disk.
    pub fn look(&self) -> Option<Both> {
        let stamp = stamp(&self.config);
        if lock(&self.now).0 == stamp {
            return None;
        }
        match acceptor(&self.config) {
            Ok(acceptor) => {
                *lock(&self.now) = (stamp, acceptor);
                Some(text::CertificatesRead.words())
            }
            Err(error) => {
                let before = std::mem::replace(&mut *lock(&self.useless), stamp.clone());
                let what = error.both();
                (before != stamp).then(|| text::CertificatesUseless { what: &what }.words())
            }
        }
    }
}

fn stamp(config: &TlsConfig) -> Stamp {
    let files = [Some(&config.cert), Some(&config.key), config.client_ca.as_ref()];
    let of = |path: Option<&PathBuf>| {
        let file = std::fs::metadata(path?).ok()?;
        Some((file.modified().ok()?, file.len()))
    };
    files.into_iter().map(of).collect()
}

/// When a certificate ends, ms since 1970.
pub fn end_ms(certificate: &CertificateDer<'_>) -> Option<u64> {
    let (_, certificate) = x509_parser::parse_x509_certificate(certificate).ok()?;
    let ends_s = certificate.validity().not_after.timestamp();
    u64::try_from(ends_s).ok()?.checked_mul(1000)
}

/// When the first certificate of the hub's chain ends, ms since 1970.
pub fn ends_ms(config: &TlsConfig) -> Option<u64> {
    chain(&config.cert).ok()?.iter().filter_map(end_ms).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A certificate with its key that ends in this year.
    fn write(folder: &Path, year: i32) -> TlsConfig {
        let mut params = rcgen::CertificateParams::new(vec!["hub".to_owned()]).unwrap();
        params.not_after = rcgen::date_time_ymd(year, 1, 1);
        let key = rcgen::KeyPair::generate().unwrap();
        let (cert, key_file) = (folder.join("cert.pem"), folder.join("key.pem"));
        std::fs::write(&cert, params.self_signed(&key).unwrap().pem()).unwrap();
        std::fs::write(&key_file, key.serialize_pem()).unwrap();
        TlsConfig { cert, key: key_file, ..TlsConfig::default() }
    }

    #[test]
    fn a_certificate_that_was_replaced_is_read() {
        let folder = std::env::temp_dir().join(format!("lafet-tls-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let config = write(&folder, 2030);
        assert_eq!(ends_ms(&config), Some(1_893_456_000_000), "2030-01-01");
        let reloading = Reloading::new(&config).unwrap();
        assert_eq!(reloading.look(), None, "nothing has changed");
        // The certificate is there before its key.
        let key = std::fs::read(&config.key).unwrap();
        write(&folder, 2031);
        let new_key = std::fs::read(&config.key).unwrap();
        std::fs::write(&config.key, [&key[..], b"\n"].concat()).unwrap();
        let useless = reloading.look().unwrap();
        assert!(useless.en.contains("the old ones stay"), "{useless:?}");
        assert_eq!(reloading.look(), None, "it is said once");
        std::fs::write(&config.key, new_key).unwrap();
        assert!(reloading.look().unwrap().en.contains("read again"));
        assert_eq!((reloading.look(), ends_ms(&config)), (None, Some(1_924_992_000_000)));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
