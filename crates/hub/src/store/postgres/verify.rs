//! Whether a server is who it should be, as libpq decides it: by who has signed it
//! (`verify-ca`), and by its name as well (`verify-full`).

use std::path::Path;
use std::sync::Arc;

use lafet_texts::{Text as _, hub as text};
use rustls_pki_types::{CertificateDer, ServerName, UnixTime};
use tokio_rustls::rustls::client::danger::{
    HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
};
use tokio_rustls::rustls::client::{verify_server_cert_signed_by_trust_anchor, verify_server_name};
use tokio_rustls::rustls::crypto::{
    CryptoProvider, verify_tls12_signature, verify_tls13_signature,
};
use tokio_rustls::rustls::server::ParsedCertificate;
use tokio_rustls::rustls::{
    CertificateError, ClientConfig, DigitallySignedStruct, Error, RootCertStore, SignatureScheme,
};
use x509_parser::prelude::X509Certificate;

use crate::server::tls::{self, FileError};
use crate::text::Both;

/// Which certificates are accepted.
#[derive(Debug)]
pub enum Trust {
    /// Any certificate: the connection is encrypted, but the server is not identified.
    Anybody,
    /// Who is signed by one of these, or is one of them.
    Signed {
        /// Certificates of the authorities.
        roots: RootCertStore,
        /// As they are in the file.
        listed: Vec<CertificateDer<'static>>,
        /// Whether the name has to be right as well.
        names: bool,
    },
}

impl Trust {
    /// What a PEM file says.
    pub fn of_file(path: &Path, names: bool) -> Result<Self, FileError> {
        let (roots, listed) = tls::roots(path)?;
        Ok(Self::Signed { roots, listed, names })
    }

    /// The authorities that this machine trusts.
    pub fn of_system() -> Result<Self, Both> {
        let mut roots = RootCertStore::empty();
        let found = rustls_native_certs::load_native_certs();
        if roots.add_parsable_certificates(found.certs).0 == 0 {
            return Err(text::PostgresNoAuthority.words());
        }
        Ok(Self::Signed { roots, listed: Vec::new(), names: true })
    }
}

/// A client that believes so, with a certificate of its own.
pub fn client(trust: Trust, own: Option<(&Path, &Path)>) -> Result<ClientConfig, Both> {
    let provider = tls::provider();
    let said = |error: Error| Both::same(format!("TLS: {error}."));
    let builder = ClientConfig::builder_with_provider(provider.clone())
        .with_safe_default_protocol_versions()
        .map_err(said)?
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(Verifier { trust, provider }));
    match own {
        None => Ok(builder.with_no_client_auth()),
        Some((cert, key)) => {
            let chain = tls::chain(cert).map_err(|it| it.both())?;
            let key = tls::key(key).map_err(|it| it.both())?;
            builder.with_client_auth_cert(chain, key).map_err(said)
        }
    }
}

#[derive(Debug)]
struct Verifier {
    trust: Trust,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Verifier {
    fn verify_server_cert(
        &self,
        certificate: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        name: &ServerName<'_>,
        _: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        let Trust::Signed { roots, listed, names } = &self.trust else {
            return Ok(ServerCertVerified::assertion());
        };
        let parsed = ParsedCertificate::try_from(certificate)?;
        // One that signs itself, as `openssl req -x509` makes it, may not sign others for webpki.
        if listed.contains(certificate) {
            in_time(certificate, now)?;
        } else {
            let by = self.provider.signature_verification_algorithms.all;
            verify_server_cert_signed_by_trust_anchor(&parsed, roots, intermediates, now, by)?;
        }
        if *names {
            verify_server_name(&parsed, name)
                .or_else(|error| by_common_name(certificate, name).ok_or(error))?;
        }
        Ok(ServerCertVerified::assertion())
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let by = &self.provider.signature_verification_algorithms;
        verify_tls12_signature(message, certificate, signed, by)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let by = &self.provider.signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signed, by)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}

fn parsed<'a>(certificate: &'a CertificateDer<'_>) -> Option<X509Certificate<'a>> {
    x509_parser::parse_x509_certificate(certificate).ok().map(|(_, parsed)| parsed)
}

fn in_time(certificate: &CertificateDer<'_>, now: UnixTime) -> Result<(), Error> {
    let now = i64::try_from(now.as_secs()).unwrap_or(i64::MAX);
    let parsed = parsed(certificate).ok_or(CertificateError::BadEncoding)?;
    let times = parsed.validity();
    if now < times.not_before.timestamp() {
        return Err(CertificateError::NotValidYet.into());
    }
    if now > times.not_after.timestamp() {
        return Err(CertificateError::Expired.into());
    }
    Ok(())
}

/// As libpq: where a certificate says no other names, its common name counts.
fn by_common_name(certificate: &CertificateDer<'_>, name: &ServerName<'_>) -> Option<()> {
    let certificate = parsed(certificate)?;
    if !matches!(certificate.subject_alternative_name(), Ok(None)) {
        return None;
    }
    let common = certificate.subject().iter_common_name().next()?.as_str().ok()?;
    let wanted = name.to_str();
    let one_label = common.strip_prefix("*.").zip(wanted.split_once('.'));
    let fits = one_label.is_some_and(|(common, (_, rest))| common.eq_ignore_ascii_case(rest));
    (fits || common.eq_ignore_ascii_case(&wanted)).then_some(())
}
