//! Where the server is, and how TLS is wanted: libpq's `sslmode`, `sslrootcert`, `sslcert` and
//! `sslkey` in the URL, with their meanings there.

use std::fmt;
use std::path::{Path, PathBuf};

use lafet_texts::{Text as _, hub as text};
use percent_encoding::percent_decode_str;
use tokio::time::timeout;
use tokio_postgres::config::{Host, SslMode};
use tokio_postgres::{Client, Config};
use tokio_postgres_rustls::MakeRustlsConnect;

use super::super::db::StoreError;
use super::PATIENCE;
use super::verify::{self, Trust};
use crate::text::Both;

/// What is taken out of the URL, for tokio-postgres knows less of it.
const OURS: [&str; 4] = ["sslmode", "sslrootcert", "sslcert", "sslkey"];
/// The authorities that this machine trusts.
const SYSTEM: &str = "system";

/// Where a PostgreSQL server is.
#[derive(Clone)]
pub struct Address {
    config: Config,
    mode: Mode,
    roots: Option<Roots>,
    own: Option<(PathBuf, PathBuf)>,
}

/// libpq's `sslmode`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Disable,
    Allow,
    Prefer,
    Require,
    VerifyCa,
    VerifyFull,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Roots {
    File(PathBuf),
    System,
}

/// What is wrong with an address, and what to do.
pub type Wrong = (Both, Both);

impl fmt::Debug for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Address").field("mode", &self.mode).finish_non_exhaustive()
    }
}

impl Mode {
    fn of(text: &str) -> Result<Self, Wrong> {
        Ok(match text {
            "disable" => Self::Disable,
            "allow" => Self::Allow,
            "prefer" => Self::Prefer,
            "require" => Self::Require,
            "verify-ca" => Self::VerifyCa,
            "verify-full" => Self::VerifyFull,
            other => {
                return Err((
                    text::PostgresSslmode { other }.words(),
                    text::PostgresSslmodeRemedy.words(),
                ));
            }
        })
    }

    /// What to try, one after the other.
    const fn attempts(self) -> &'static [SslMode] {
        match self {
            Self::Disable => &[SslMode::Disable],
            Self::Allow => &[SslMode::Disable, SslMode::Require],
            Self::Prefer => &[SslMode::Prefer, SslMode::Disable],
            Self::Require | Self::VerifyCa | Self::VerifyFull => &[SslMode::Require],
        }
    }
}

fn no_address() -> Wrong {
    (text::PostgresAddress.words(), text::PostgresAddressRemedy.words())
}

impl Address {
    /// Reads a URL; relative paths in it start from `folder`.
    pub fn parse(url: &str, folder: &Path) -> Result<Self, Wrong> {
        if !["postgres://", "postgresql://"].iter().any(|it| url.starts_with(it)) {
            return Err(no_address());
        }
        let (url, options) = take_out(url);
        let config: Config = url.parse().map_err(|_| no_address())?;
        let of = |name| options.iter().rev().find(|(it, _)| it == name).map(|(_, value)| value);
        let path = |name| of(name).map(|path| folder.join(path));
        let roots = of("sslrootcert").map(|value| match value.as_str() {
            SYSTEM => Roots::System,
            path => Roots::File(folder.join(path)),
        });
        let mode = match of("sslmode") {
            Some(text) => Mode::of(text)?,
            None if roots == Some(Roots::System) => Mode::VerifyFull,
            None => Mode::Prefer,
        };
        if roots.is_none() && matches!(mode, Mode::VerifyCa | Mode::VerifyFull) {
            return Err((
                text::PostgresVerifyByWhat.words(),
                text::PostgresVerifyByWhatRemedy.words(),
            ));
        }
        if roots == Some(Roots::System) && mode != Mode::VerifyFull {
            return Err((
                text::PostgresSystemNotFull.words(),
                text::PostgresVerifyFullRemedy.words(),
            ));
        }
        let verifies = matches!(mode, Mode::Require | Mode::VerifyCa | Mode::VerifyFull);
        if roots.is_some() && !verifies {
            // libpq would say nothing, and verify nothing.
            return Err((
                text::PostgresVerifiesNothing.words(),
                text::PostgresVerifyFullRemedy.words(),
            ));
        }
        let own = match (path("sslcert"), path("sslkey")) {
            (None, None) => None,
            (Some(cert), Some(key)) => Some((cert, key)),
            _ => {
                return Err((
                    text::PostgresCertAndKey.words(),
                    text::PostgresCertAndKeyRemedy.words(),
                ));
            }
        };
        // A socket of this machine has no TLS, whatever is asked for.
        let local = |host: &Host| !matches!(host, Host::Tcp(_));
        let mode = if config.get_hosts().iter().all(local) && config.get_hostaddrs().is_empty() {
            Mode::Disable
        } else {
            mode
        };
        Ok(Self { config, mode, roots, own })
    }

    /// A connection; what the mode allows is tried one after the other.
    pub async fn client(&self) -> Result<Client, String> {
        let tls = self.connector().map_err(|wrong| wrong.en)?;
        let mut said = String::new();
        for mode in self.mode.attempts() {
            let mut config = self.config.clone();
            config.ssl_mode(*mode);
            said = match timeout(PATIENCE, config.connect(tls.clone())).await {
                Ok(Ok((client, connection))) => {
                    tokio::spawn(connection);
                    return Ok(client);
                }
                Ok(Err(error)) => super::said(&error),
                Err(_) => StoreError::Away.to_string(),
            };
        }
        Err(said)
    }

    /// What makes TLS. The files are read each time: certificates are renewed.
    pub fn connector(&self) -> Result<MakeRustlsConnect, Both> {
        let trust = match (&self.roots, self.mode) {
            // As libpq: with a file `require` verifies as `verify-ca` does.
            (Some(roots), Mode::Require | Mode::VerifyCa | Mode::VerifyFull) => {
                let names = self.mode == Mode::VerifyFull;
                match roots {
                    Roots::File(path) => Trust::of_file(path, names).map_err(|it| it.both())?,
                    Roots::System => Trust::of_system()?,
                }
            }
            _ => Trust::Anybody,
        };
        let own = self.own.as_ref().map(|(cert, key)| (cert.as_path(), key.as_path()));
        Ok(MakeRustlsConnect::new(verify::client(trust, own)?))
    }
}

/// The URL without what is ours, and that.
fn take_out(url: &str) -> (String, Vec<(String, String)>) {
    // A password may have a question mark in it.
    let host = url.find('@').unwrap_or(0);
    let query = url.get(host..).and_then(|rest| rest.find('?')).map(|at| host + at);
    let Some((base, query)) = query.and_then(|at| Some((url.get(..at)?, url.get(at + 1..)?)))
    else {
        return (url.to_owned(), Vec::new());
    };
    let (mut ours, mut others) = (Vec::new(), Vec::new());
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        match pair.split_once('=') {
            Some((name, value)) if OURS.contains(&name) => {
                let value = percent_decode_str(value).decode_utf8_lossy().into_owned();
                ours.push((name.to_owned(), value));
            }
            _ => others.push(pair),
        }
    }
    let mark = if others.is_empty() { "" } else { "?" };
    (format!("{base}{mark}{}", others.join("&")), ours)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(options: &str) -> Result<Address, Wrong> {
        Address::parse(&format!("postgres://u:p%3Fw@db.site/lafet{options}"), Path::new("/etc/l"))
    }

    fn wrong(options: &str) -> String {
        parse(options).unwrap_err().0.en
    }

    #[test]
    fn the_options_have_the_meanings_that_libpq_gives_them() {
        let mode = |options: &str| parse(options).unwrap().mode;
        assert_eq!(mode(""), Mode::Prefer);
        assert_eq!(mode("?sslmode=disable"), Mode::Disable);
        assert_eq!(mode("?sslmode=allow&connect_timeout=3"), Mode::Allow);
        assert_eq!(mode("?sslmode=require"), Mode::Require);
        assert_eq!(mode("?sslrootcert=system"), Mode::VerifyFull);
        let full =
            parse("?application_name=x&sslmode=verify-full&sslrootcert=db%20ca.pem").unwrap();
        assert_eq!(full.roots, Some(Roots::File("/etc/l/db ca.pem".into())));
        assert_eq!(full.config.get_application_name(), Some("x"));
        assert_eq!(full.config.get_password(), Some(&b"p?w"[..]));
        let own = parse("?sslcert=c.pem&sslkey=/k.pem").unwrap().own;
        assert_eq!(own, Some(("/etc/l/c.pem".into(), "/k.pem".into())));
    }

    #[test]
    fn what_contradicts_itself_is_told() {
        assert!(wrong("?sslmode=on").contains("sslmode=on is unknown"));
        assert!(wrong("?sslmode=verify-ca").contains("nothing is given to verify it by"));
        assert!(wrong("?sslmode=require&sslrootcert=system").contains("without verify-full"));
        assert!(wrong("?sslrootcert=ca.pem").contains("verifies nothing"));
        assert!(wrong("?sslkey=k.pem").contains("go together"));
        assert!(wrong("?port=x").contains("no address"));
        let file = parse("?sslmode=verify-ca&sslrootcert=none.pem").unwrap().connector();
        assert!(file.err().unwrap().en.starts_with("/etc/l/none.pem: cannot be read"));
    }

    #[test]
    fn a_socket_of_this_machine_has_no_tls() {
        let socket = "postgres:///lafet?host=/run/postgresql&sslmode=require";
        let address = Address::parse(socket, Path::new("/")).unwrap();
        assert_eq!(address.mode, Mode::Disable);
    }

    #[test]
    fn a_password_with_a_question_mark_is_a_password() {
        let address =
            Address::parse("postgres://u:a?b@h/d?sslmode=disable", Path::new("/")).unwrap();
        assert_eq!(address.config.get_password(), Some(&b"a?b"[..]));
        assert_eq!(address.mode, Mode::Disable);
    }
}
