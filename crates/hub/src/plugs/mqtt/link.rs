//! The connection to a broker: how it is made, and why it is not, in words.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use rumqttc::{
    ConnectReturnCode, ConnectionError, IncomingPacketSizeLimit, LastWill, MqttOptions,
    NetworkOptions, StateError, TlsConfiguration, Transport,
};
use tokio_rustls::rustls::{CertificateError, ClientConfig, Error as TlsError, RootCertStore};

use super::message::PAYLOAD_MAX;
use super::{BrokerConfig, Login, Secret, reason};
use crate::server::tls;
use crate::text::Both;

/// The broker answers within this time.
pub const ANSWERS: Duration = Duration::from_secs(5);
/// A connection on which nothing is said is asked this often, s.
const KEEP_ALIVE_S: u16 = 5;
/// Largest packet that the broker is to send: a message, its topic and properties.
const PACKET_MAX: u32 = 2 * PAYLOAD_MAX as u32;
/// Largest packet that is read of a broker that sends larger ones.
const PACKET_READ_MAX: u32 = 256 * 1024;
/// Messages to the broker that wait in the library, behind those of the outbox.
pub const AHEAD: usize = 8;
/// Longest file of a password, bytes.
const PASSWORD_MAX: usize = 4096;

/// Certificates for a broker.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files {
    /// Who signs the broker's certificate; `None`: whom this machine trusts.
    pub ca: Option<PathBuf>,
    /// Certificate and key of the hub.
    pub own: Option<(PathBuf, PathBuf)>,
}

impl Files {
    /// Everything that is wrong with them.
    pub fn problems(&self) -> Vec<Both> {
        self.client().err().into_iter().collect()
    }

    /// What makes TLS. The files are read each time: certificates are renewed.
    fn client(&self) -> Result<ClientConfig, Both> {
        let said = |error: TlsError| text::MqttTls { error: error.to_string() }.words();
        let roots = match &self.ca {
            Some(path) => tls::roots(path).map_err(|it| it.both())?.0,
            None => {
                let mut roots = RootCertStore::empty();
                let found = rustls_native_certs::load_native_certs();
                if roots.add_parsable_certificates(found.certs).0 == 0 {
                    return Err(text::MqttNoAuthority.words());
                }
                roots
            }
        };
        let builder = ClientConfig::builder_with_provider(tls::provider())
            .with_safe_default_protocol_versions()
            .map_err(said)?
            .with_root_certificates(roots);
        let Some((cert, key)) = &self.own else { return Ok(builder.with_no_client_auth()) };
        let chain = tls::chain(cert).map_err(|it| it.both())?;
        let key = tls::key(key).map_err(|it| it.both())?;
        builder.with_client_auth_cert(chain, key).map_err(said)
    }
}

impl Login {
    /// The password; that of a file is read each time.
    ///
    /// # Errors
    ///
    /// The file cannot be read.
    pub(crate) fn password(&self) -> Result<Option<String>, Both> {
        match &self.secret {
            None => Ok(None),
            Some(Secret::Here(password)) => Ok(Some(password.clone())),
            Some(Secret::File(path)) => {
                let read = std::fs::read_to_string(path).map_err(|error| {
                    let why = crate::field::line::said(&error);
                    let path = path.display();
                    text::CheckPasswordFile { path: lafet_texts::Shown(path), why: &why }.words()
                })?;
                let first = read.lines().next().unwrap_or_default();
                Ok(Some(first.chars().take(PASSWORD_MAX).collect()))
            }
        }
    }
}

/// Whether a connection has reached its broker.
pub type Reached = Arc<AtomicBool>;

/// How to connect: without a session that outlives the connection; what the broker publishes when it is lost.
///
/// # Errors
///
/// A file cannot be read or used.
pub fn options(
    config: &BrokerConfig,
    will: LastWill,
    reached: Reached,
) -> Result<MqttOptions, Both> {
    let broker = (config.host.clone(), config.port);
    let mut options = MqttOptions::new(config.client_id.clone(), broker);
    options
        .set_clean_start(true)
        .set_session_expiry_interval(Some(0))
        .set_keep_alive(KEEP_ALIVE_S)
        .set_connect_timeout(ANSWERS)
        .set_max_packet_size(Some(PACKET_MAX))
        .set_incoming_packet_size_limit(IncomingPacketSizeLimit::Bytes(PACKET_READ_MAX))
        .set_last_will(will);
    let mut network = NetworkOptions::new();
    network.set_tcp_nodelay(true);
    network.set_connection_timeout(ANSWERS.as_secs());
    options.set_network_options(network);
    // By itself it writes an IPv6 address without brackets.
    let place = config.place();
    options.set_socket_connector(move |_, network| {
        let (place, reached) = (place.clone(), reached.clone());
        async move {
            let socket = rumqttc::default_socket_connect(place, network).await?;
            reached.store(true, Ordering::SeqCst);
            Ok(socket)
        }
    });
    if let Some(login) = &config.login {
        match login.password()? {
            Some(password) => options.set_credentials(login.user.clone(), password),
            None => options.set_username(login.user.clone()),
        };
    }
    if let Some(files) = &config.tls {
        let client = TlsConfiguration::Rustls(Arc::new(files.client()?));
        options.set_transport(Transport::tls_with_config(client));
    }
    Ok(options)
}

/// Why there is no connection.
pub fn said(config: &BrokerConfig, error: &ConnectionError) -> Both {
    if let Some(error) = cause::<TlsError>(error) {
        return of_tls(config, error);
    }
    match error {
        ConnectionError::ConnectionRefused(code)
        | ConnectionError::MqttState(StateError::ConnFail { reason: code }) => refused(*code),
        ConnectionError::Timeout(_) => silent(),
        ConnectionError::MqttState(StateError::AwaitPingResp) => silent(),
        ConnectionError::MqttState(StateError::ServerDisconnect { reason_code, .. }) => {
            text::MqttSentAway { why: reason::of_end(*reason_code) }.words()
        }
        ConnectionError::MqttState(StateError::ConnectionAborted) => text::MqttClosed.words(),
        _ => match cause::<std::io::Error>(error) {
            Some(error) if error.raw_os_error().is_some() => crate::field::line::said(error),
            Some(error) if error.kind() == std::io::ErrorKind::TimedOut => silent(),
            Some(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                text::MqttClosed.words()
            }
            _ => text::MqttFailed { error: error.to_string() }.words(),
        },
    }
}

/// The broker does not answer.
pub fn silent() -> Both {
    text::MqttNoAnswer { s: ANSWERS.as_secs() }.words()
}

fn refused(code: ConnectReturnCode) -> Both {
    match code {
        ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized => {
            text::MqttNotAuthorized.words()
        }
        ConnectReturnCode::UnsupportedProtocolVersion
        | ConnectReturnCode::RefusedProtocolVersion => text::MqttOldVersion.words(),
        code => text::MqttTurnedAway { why: reason::of_refusal(code) }.words(),
    }
}

fn of_tls(config: &BrokerConfig, error: &TlsError) -> Both {
    let host = &config.host;
    match error {
        // The second one: another authority of the same name.
        TlsError::InvalidCertificate(
            CertificateError::UnknownIssuer | CertificateError::BadSignature,
        ) => text::MqttUnknownIssuer.words(),
        TlsError::InvalidCertificate(
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. },
        ) => text::MqttOtherName { host }.words(),
        TlsError::InvalidCertificate(
            CertificateError::Expired
            | CertificateError::ExpiredContext { .. }
            | CertificateError::NotValidYet
            | CertificateError::NotValidYetContext { .. },
        ) => text::MqttNotInTime.words(),
        error => text::MqttTls { error: error.to_string() }.words(),
    }
}

/// The first error of a kind among an error and its causes.
fn cause<'a, E: std::error::Error + 'static>(
    error: &'a (dyn std::error::Error + 'static),
) -> Option<&'a E> {
    let mut next = Some(error);
    while let Some(error) = next {
        if let Some(found) = error.downcast_ref() {
            return Some(found);
        }
        // An error of the system may have another one within, which is not its source.
        let within = error.downcast_ref::<std::io::Error>().and_then(std::io::Error::get_ref);
        let within = within.map(|it| it as &(dyn std::error::Error + 'static));
        if let Some(found) = within.and_then(|it| it.downcast_ref()) {
            return Some(found);
        }
        next = error.source();
    }
    None
}
