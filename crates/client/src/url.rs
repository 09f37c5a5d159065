//! The endpoint of a monitor: `tcp://host:port?addr=1`, `udp://…`,
//! `serial:///dev/ttyUSB0?baud=19200`, `sim:`.
//!
//! The schemes and their options are ours; the addresses and the speed of the line are those of the
//! bus (observed).

mod behaviour;
mod config;
mod serial;

use std::collections::HashSet;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use lafet_proto::bus;
use lafet_texts::{Fixed, client as text};
use percent_encoding::{AsciiSet, CONTROLS, percent_decode_str, utf8_percent_encode};
use url::{Host, Url};

#[cfg(test)]
use crate::error::Lang;
pub use crate::session::medium::{Addresses, Echo, Framing, Role};
pub use crate::url_error::UrlError;
pub use behaviour::Behaviour;
pub use serial::{Rs485, SerialLine};

/// A monitor and the connection to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// A monitor's own port, or a transparent serial server.
    Tcp {
        /// Name or address; IPv6 without its brackets.
        host: String,
        /// Port.
        port: u16,
        /// Contents of the stream.
        framing: Framing,
        /// Addresses of both sides.
        addresses: Addresses,
        /// Behaviour of this side.
        behaviour: Behaviour,
    },
    /// One datagram = one link frame.
    Udp {
        /// Name or address; IPv6 without its brackets.
        host: String,
        /// Port.
        port: u16,
        /// Addresses of both sides.
        addresses: Addresses,
        /// Behaviour of this side.
        behaviour: Behaviour,
    },
    /// RS-485 or RS-232, 8N1.
    Serial {
        /// The device.
        path: PathBuf,
        /// Speed, direction and echo of the line.
        line: SerialLine,
        /// Addresses of both sides.
        addresses: Addresses,
        /// Behaviour of this side.
        behaviour: Behaviour,
    },
    /// A simulated monitor in the same process, provided by the caller: see `Client::over`.
    Sim {
        /// Options for the simulator, in order.
        query: Vec<(String, String)>,
        /// Addresses of both sides.
        addresses: Addresses,
        /// Behaviour of this side.
        behaviour: Behaviour,
    },
}

impl Endpoint {
    /// Addresses of both sides.
    pub const fn addresses(&self) -> Addresses {
        match self {
            Self::Tcp { addresses, .. }
            | Self::Udp { addresses, .. }
            | Self::Serial { addresses, .. }
            | Self::Sim { addresses, .. } => *addresses,
        }
    }

    /// The same line to another monitor on it.
    #[must_use]
    pub fn to(mut self, monitor: u8) -> Self {
        match &mut self {
            Self::Tcp { addresses, .. }
            | Self::Udp { addresses, .. }
            | Self::Serial { addresses, .. }
            | Self::Sim { addresses, .. } => addresses.monitor = monitor,
        }
        self
    }

    /// Behaviour of this side.
    pub const fn behaviour(&self) -> Behaviour {
        match self {
            Self::Tcp { behaviour, .. }
            | Self::Udp { behaviour, .. }
            | Self::Serial { behaviour, .. }
            | Self::Sim { behaviour, .. } => *behaviour,
        }
    }

    /// Framing: link frames, except for `tcp://…?framing=records`.
    pub const fn framing(&self) -> Framing {
        match self {
            Self::Tcp { framing, .. } => *framing,
            _ => Framing::Link,
        }
    }
}

impl FromStr for Endpoint {
    type Err = UrlError;

    fn from_str(text: &str) -> Result<Self, UrlError> {
        let url = Url::parse(text).map_err(|error| syntax(text, error))?;
        if let Some(fragment) = url.fragment() {
            return Err(UrlError::Part { url: text.into(), part: format!("#{fragment}") });
        }
        let mut options = Options::read(&url)?;
        match url.scheme() {
            "tcp" => {
                let (host, port) = host_and_port(text, &url, "tcp")?;
                let framing = options.framing()?;
                let addresses = options.addresses()?;
                let behaviour = match framing {
                    Framing::Link => Behaviour::read(&mut options, addresses)?,
                    Framing::Records => Behaviour { late: options.late()?, ..Behaviour::default() },
                };
                options.finish(&["addr", "src", "framing", "check", "role", "late"])?;
                Ok(Self::Tcp { host, port, framing, addresses, behaviour })
            }
            "udp" => {
                let (host, port) = host_and_port(text, &url, "udp")?;
                let addresses = options.addresses()?;
                let (check, late) = (options.check()?, options.late()?);
                let behaviour = Behaviour { check, late, ..Behaviour::default() };
                options.finish(&["addr", "src", "check", "late"])?;
                Ok(Self::Udp { host, port, addresses, behaviour })
            }
            "serial" => {
                let path = device(text, &url)?;
                let line = SerialLine::read(&mut options)?;
                let addresses = options.addresses()?;
                let behaviour = Behaviour::read(&mut options, addresses)?;
                options.finish(&serial::OPTIONS)?;
                Ok(Self::Serial { path, line, addresses, behaviour })
            }
            "sim" => {
                let rest = format!("{}{}", url.host_str().unwrap_or(""), url.path());
                if !rest.is_empty() {
                    return Err(UrlError::Part { url: text.into(), part: rest });
                }
                let addresses = options.addresses()?;
                let behaviour = Behaviour { check: options.check()?, ..Behaviour::default() };
                Ok(Self::Sim { query: options.rest, addresses, behaviour })
            }
            scheme => Err(UrlError::Scheme { url: text.into(), scheme: scheme.into() }),
        }
    }
}

fn syntax(text: &str, error: url::ParseError) -> UrlError {
    match error {
        url::ParseError::InvalidPort => {
            let value = text.rsplit(':').next().unwrap_or_default();
            let value = value.split(['?', '/']).next().unwrap_or_default();
            UrlError::Value {
                key: "port".into(),
                value: value.into(),
                allowed: text::AllowedPort.fixed(),
            }
        }
        error => UrlError::Syntax { url: text.into(), reason: error.to_string() },
    }
}

fn host_and_port(text: &str, url: &Url, scheme: &'static str) -> Result<(String, u16), UrlError> {
    let part = |part: String| UrlError::Part { url: text.into(), part };
    if !url.username().is_empty() || url.password().is_some() {
        return Err(part(format!("{}@", url.username())));
    }
    if !matches!(url.path(), "" | "/") {
        return Err(part(url.path().into()));
    }
    let nowhere = || UrlError::Nowhere { url: text.into(), scheme };
    let host = match url.host().ok_or_else(nowhere)? {
        Host::Domain("") => return Err(nowhere()),
        Host::Domain(name) => percent_decode_str(name).decode_utf8_lossy().into_owned(),
        Host::Ipv4(address) => address.to_string(),
        Host::Ipv6(address) => address.to_string(),
    };
    match url.port() {
        Some(0) => Err(UrlError::Value {
            key: "port".into(),
            value: "0".into(),
            allowed: text::AllowedPort.fixed(),
        }),
        port => Ok((host, port.unwrap_or(bus::PORT_EXTERNAL_CONN))),
    }
}

/// `serial:///dev/ttyUSB0`, or `serial://COM3` and `serial:COM3` where device names are not paths.
fn device(text: &str, url: &Url) -> Result<PathBuf, UrlError> {
    let path = format!("{}{}", url.host_str().unwrap_or(""), url.path());
    let path = percent_decode_str(&path).decode_utf8_lossy().into_owned();
    if matches!(path.as_str(), "" | "/") {
        return Err(UrlError::Nowhere { url: text.into(), scheme: "serial" });
    }
    Ok(PathBuf::from(path))
}

/// The options of a URL that have not been read yet.
struct Options {
    rest: Vec<(String, String)>,
}

impl Options {
    fn read(url: &Url) -> Result<Self, UrlError> {
        let rest: Vec<(String, String)> = url.query_pairs().into_owned().collect();
        // A simulator may have several fires; all other options may be given once.
        let mut seen = HashSet::new();
        let single = |key: &str| url.scheme() != "sim" || matches!(key, "addr" | "src" | "check");
        match rest.iter().find(|(key, _)| single(key) && !seen.insert(key.clone())) {
            Some((key, _)) => Err(UrlError::Twice { key: key.clone() }),
            None => Ok(Self { rest }),
        }
    }

    fn take(&mut self, key: &str) -> Option<String> {
        let index = self.rest.iter().position(|(known, _)| known == key)?;
        Some(self.rest.remove(index).1)
    }

    fn number<T: FromStr + PartialOrd>(
        &mut self,
        key: &str,
        default: T,
        range: std::ops::RangeInclusive<T>,
        allowed: Fixed,
    ) -> Result<T, UrlError> {
        let Some(value) = self.take(key) else { return Ok(default) };
        match value.parse() {
            Ok(number) if range.contains(&number) => Ok(number),
            _ => Err(UrlError::Value { key: key.into(), value, allowed }),
        }
    }

    fn addresses(&mut self) -> Result<Addresses, UrlError> {
        let Addresses { monitor, source } = Addresses::default();
        let sources = bus::CONTROLLER..=*bus::CONSOLES.end();
        Ok(Addresses {
            monitor: self.number(
                "addr",
                monitor,
                bus::MONITORS,
                text::AllowedMonitorAddress.fixed(),
            )?,
            source: self.number("src", source, sources, text::AllowedSourceAddress.fixed())?,
        })
    }

    fn framing(&mut self) -> Result<Framing, UrlError> {
        match self.take("framing") {
            None => Ok(Framing::Link),
            Some(value) if value == "link" => Ok(Framing::Link),
            Some(value) if value == "records" => Ok(Framing::Records),
            Some(value) => Err(UrlError::Value {
                key: "framing".into(),
                value,
                allowed: text::AllowedFraming.fixed(),
            }),
        }
    }

    fn finish(self, known: &'static [&'static str]) -> Result<(), UrlError> {
        match self.rest.into_iter().next() {
            Some((key, _)) => Err(UrlError::Option { key, known }),
            None => Ok(()),
        }
    }
}

/// Characters that a device path may not contain inside a URL.
const PATH: &AsciiSet = &CONTROLS.add(b' ').add(b'?').add(b'#').add(b'%').add(b'"');

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp { host, port, framing, addresses, behaviour } => {
                write!(f, "tcp://{}:{port}?addr={}", Bracketed(host), addresses.monitor)?;
                write_source(f, *addresses)?;
                behaviour.write(f)?;
                if *framing == Framing::Records { f.write_str("&framing=records") } else { Ok(()) }
            }
            Self::Udp { host, port, addresses, behaviour } => {
                write!(f, "udp://{}:{port}?addr={}", Bracketed(host), addresses.monitor)?;
                write_source(f, *addresses)?;
                behaviour.write(f)
            }
            Self::Serial { path, line, addresses, behaviour } => {
                let path = path.to_string_lossy();
                let slashes = if path.starts_with('/') { "//" } else { "" };
                let path = utf8_percent_encode(&path, PATH);
                let SerialLine { baud, .. } = line;
                write!(f, "serial:{slashes}{path}?baud={baud}&addr={}", addresses.monitor)?;
                write_source(f, *addresses)?;
                line.write(f)?;
                behaviour.write(f)
            }
            Self::Sim { query, addresses, behaviour } => {
                write!(f, "sim:?addr={}", addresses.monitor)?;
                write_source(f, *addresses)?;
                behaviour.write(f)?;
                for (key, value) in query {
                    let pair = url::form_urlencoded::Serializer::new(String::new())
                        .append_pair(key, value)
                        .finish();
                    write!(f, "&{pair}")?;
                }
                Ok(())
            }
        }
    }
}

fn write_source(f: &mut fmt::Formatter<'_>, addresses: Addresses) -> fmt::Result {
    if addresses.source == Addresses::default().source {
        return Ok(());
    }
    write!(f, "&src={}", addresses.source)
}

/// An IPv6 address needs brackets before a port.
struct Bracketed<'a>(&'a str);

impl fmt::Display for Bracketed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.contains(':') { write!(f, "[{}]", self.0) } else { f.write_str(self.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Endpoint {
        text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    /// §C/2
    #[test]
    fn what_is_left_out_has_its_default() {
        let addresses = Addresses { monitor: 1, source: 129 };
        let tcp = |host: &str, port| Endpoint::Tcp {
            host: host.into(),
            port,
            framing: Framing::Link,
            addresses,
            behaviour: Behaviour::default(),
        };
        let behaviour = Behaviour::default();
        assert_eq!(parse("tcp://monitor.local"), tcp("monitor.local", 10_485));
        assert_eq!(parse("tcp://10.0.0.7:4001/"), tcp("10.0.0.7", 4001));
        assert_eq!(parse("tcp://[fe80::1]"), tcp("fe80::1", 10_485));
        assert_eq!(parse("tcp://[::1]:9"), tcp("::1", 9));
        let (path, line) = (PathBuf::from("/dev/ttyUSB0"), SerialLine::default());
        assert_eq!(line.baud, 19_200);
        assert_eq!(
            parse("serial:///dev/ttyUSB0"),
            Endpoint::Serial { path, line, addresses, behaviour }
        );
        assert_eq!(parse("sim:"), Endpoint::Sim { query: vec![], addresses, behaviour });
    }

    #[test]
    fn options_are_read() {
        let endpoint = parse("tcp://h?addr=127&src=200&framing=records");
        assert_eq!(endpoint.addresses(), Addresses { monitor: 127, source: 200 });
        assert_eq!(endpoint.framing(), Framing::Records);
        let Endpoint::Sim { query, addresses, .. } =
            parse("sim:?profile=full&fire=az%3D30,range%3D25&addr=3&fire=az=1")
        else {
            panic!("a sim")
        };
        assert_eq!(addresses.monitor, 3);
        let query: Vec<_> = query.iter().map(|(key, value)| (&key[..], &value[..])).collect();
        let fires = [("fire", "az=30,range=25"), ("fire", "az=1")];
        assert_eq!(query, [("profile", "full"), fires[0], fires[1]]);
    }

    #[test]
    fn displayed_and_read_again_it_is_the_same() {
        for text in [
            "tcp://monitor.local",
            "tcp://[::1]:10486?addr=5&src=254&framing=records",
            "udp://10.0.0.7:5?addr=2",
            "udp://[fe80::1]",
            "serial:///dev/ttyUSB0?baud=57600&addr=127",
            "serial:///dev/serial/by-id/a%20b%25?src=130",
            "serial:COM3",
            "serial:///dev/ttyUSB0?src=130&role=active&check=crc32c",
            "tcp://h?check=auto&role=active",
            "udp://h?check=crc32c&late=5",
            "tcp://h?framing=records&late=60",
            "serial:COM3?late=0&shared=1",
            "serial:COM3?insist=1",
            "sim:?check=auto&seed=7",
            "serial:///dev/ttyS1?rs485=rts&rts_before=1&rts_after=2&echo=verify&turnaround=5",
            "serial:///dev/ttyS1?rs485=rts-low&terminate=on&echo=strip",
            "sim:",
            "sim:?seed=7&fire=az%3D30%26,range=25&fire=x&src=128",
        ] {
            let endpoint = parse(text);
            let shown = endpoint.to_string();
            assert_eq!(parse(&shown), endpoint, "{text} is shown as {shown}");
            assert_eq!(parse(&shown).to_string(), shown);
        }
    }

    #[test]
    fn every_mistake_is_named_in_both_languages() {
        for (text, word) in [
            ("", "URL"),
            ("192.168.1.50", "URL"),
            ("localhost:10485", "localhost"),
            ("http://h", "http"),
            ("tcp://", "tcp://"),
            ("tcp:", "tcp:"),
            ("tcp://h:0", "port=0"),
            ("tcp://h:65536?addr=1", "port=65536"),
            ("tcp://h/path", "/path"),
            ("tcp://user@h", "user@"),
            ("tcp://h#x", "#x"),
            ("tcp://h?addr=0", "addr=0"),
            ("tcp://h?addr=128", "addr=128"),
            ("tcp://h?src=127", "src=127"),
            ("tcp://h?src=255", "src=255"),
            ("tcp://h?addr=1&addr=2", "`addr`"),
            ("tcp://h?baud=9600", "`baud`"),
            ("tcp://h?framing=slip", "framing=slip"),
            ("udp://h?framing=records", "`framing`"),
            ("udp://h?role=active", "`role`"),
            ("tcp://h?framing=records&check=auto", "`check`"),
            ("tcp://h?check=32", "check=32"),
            ("serial:///dev/x?role=boss", "role=boss"),
            ("serial:///dev/x?role=active&src=128", "src=128"),
            ("serial://", "serial://"),
            ("serial:///dev/x?baud=fast", "baud=fast"),
            ("serial:///dev/x?echo=loud", "echo=loud"),
            ("serial:///dev/x?rs485=yes", "rs485=yes"),
            ("serial:///dev/x?turnaround=1001", "turnaround=1001"),
            ("serial:///dev/x?rts_before=1", "rts_before"),
            ("serial:///dev/x?rs485=rts&terminate=maybe", "terminate=maybe"),
            ("serial:///dev/x?parity=even", "`parity`"),
            ("sim:x", "`x`"),
        ] {
            let error = text.parse::<Endpoint>().expect_err(text);
            let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
            assert!(english.contains(word), "{text}: {english}");
            assert!(russian.contains(word), "{text}: {russian}");
            assert!(russian.chars().any(|c| ('а'..='я').contains(&c)), "{text}: {russian}");
        }
        for (text, reason) in [
            ("", "нет схемы"),
            ("tcp://[::1", "неверный адрес IPv6"),
            ("tcp://a b", "недопустимый знак в имени узла"),
        ] {
            let russian = text.parse::<Endpoint>().expect_err(text).localized(Lang::Ru);
            assert!(russian.contains(reason), "{text}: {russian}");
        }
    }
}
