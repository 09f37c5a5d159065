//! Certificates: those of the hub, of its clients, and of PostgreSQL.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lafet_client::SystemError;
use lafet_texts::{Text, hub as text};
use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::{self, CryptoProvider};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};

use crate::config::TlsConfig;
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
