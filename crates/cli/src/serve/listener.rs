//! Listeners of a simulated monitor: `--listen tcp://…`, `udp://…`, `pty`, `radio+tcp://…`.

use std::fmt;
use std::io;
use std::str::FromStr;
use std::time::Duration;

use lafet_device::Source;
use lafet_texts::cli as text;
use tokio::net::{TcpListener, TcpStream, UdpSocket};

use super::Air;
use super::Bus;
use super::connections::Connections;
use super::datagram::serve_datagrams;
use super::stream::{Habits, Wire, serve_stream};
use crate::lang::current;

/// Query of a listener URL that selects bare records.
const RECORDS: &str = "?framing=records";
/// Pause after a failed accept, for example when no file descriptor is left.
const ACCEPT_REST: Duration = Duration::from_millis(100);
/// An answer that is not read from a pseudo-terminal is discarded after this time.
const PTY_WRITE: Duration = Duration::from_millis(500);

/// A parsed `--listen` argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen {
    radio: bool,
    medium: Medium,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Medium {
    Tcp { place: String, records: bool },
    Udp(String),
    Pty,
}

/// An open listener.
pub struct Listening {
    source: Source,
    socket: Socket,
    url: String,
}

enum Socket {
    Tcp {
        listener: TcpListener,
        records: bool,
    },
    Udp(UdpSocket),
    #[cfg(unix)]
    Pty(super::pty::Pty),
}

impl Listen {
    /// A TCP listener of the wired interface.
    pub fn tcp(place: impl Into<String>) -> Self {
        Self { radio: false, medium: Medium::Tcp { place: place.into(), records: false } }
    }

    /// A TCP listener of the radio interface.
    pub fn radio(place: impl Into<String>) -> Self {
        Self { radio: true, ..Self::tcp(place) }
    }

    /// Whether it belongs to the radio interface.
    pub const fn is_radio(&self) -> bool {
        self.radio
    }

    /// Whether it carries bare records, which no modem transmits.
    pub const fn has_records(&self) -> bool {
        matches!(self.medium, Medium::Tcp { records: true, .. })
    }

    /// Host and port, if it carries frames over TCP on the wired interface.
    #[cfg(unix)]
    pub fn tcp_place(&self) -> Option<&str> {
        match &self.medium {
            Medium::Tcp { place, records: false } if !self.radio => Some(place),
            _ => None,
        }
    }

    /// Opens the listener.
    pub async fn open(&self) -> io::Result<Listening> {
        let source = if self.radio { Source::Radio } else { Source::ExternalConn };
        let (socket, url) = match &self.medium {
            Medium::Tcp { place, records } => {
                let listener = TcpListener::bind(place).await?;
                let framing = if *records { RECORDS } else { "" };
                let url = format!("tcp://{}{framing}", listener.local_addr()?);
                (Socket::Tcp { listener, records: *records }, url)
            }
            Medium::Udp(place) => {
                let socket = UdpSocket::bind(place).await?;
                let url = format!("udp://{}", socket.local_addr()?);
                (Socket::Udp(socket), url)
            }
            Medium::Pty => pty()?,
        };
        Ok(Listening { source, socket, url })
    }
}

#[cfg(unix)]
fn pty() -> io::Result<(Socket, String)> {
    let (pty, path) = super::pty::Pty::open()?;
    Ok((Socket::Pty(pty), format!("serial://{path}")))
}

#[cfg(not(unix))]
fn pty() -> io::Result<(Socket, String)> {
    Err(io::ErrorKind::Unsupported.into())
}

impl Listening {
    /// The URL that clients connect to.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Serves clients until the end of the program; those of the radio interface over `air`, if
    /// given.
    pub async fn serve_over(self, air: Option<Air>, bus: impl Bus) -> io::Result<()> {
        let Some(air) = air.filter(|_| self.source == Source::Radio) else {
            return self.serve(bus).await;
        };
        match self.socket {
            Socket::Tcp { listener, .. } => accept_by_radio(listener, air).await,
            Socket::Udp(socket) => air.serve_datagrams(socket).await,
            #[cfg(unix)]
            Socket::Pty(pty) => {
                let (line, _open) = pty.split();
                air.serve_stream(line).await
            }
        }
    }

    /// Serves clients until the end of the program; an error is returned if the listener fails for
    /// good.
    pub async fn serve(self, bus: impl Bus) -> io::Result<()> {
        match self.socket {
            Socket::Tcp { listener, records } => {
                let wire = if records { Wire::records } else { Wire::link };
                accept(listener, || wire(self.source), bus).await
            }
            Socket::Udp(socket) => serve_datagrams(socket, self.source, bus).await,
            #[cfg(unix)]
            Socket::Pty(pty) => {
                let habits = Habits { write_timeout: PTY_WRITE, drop_slow: false };
                let (line, _open) = pty.split();
                serve_stream(line, Wire::link(self.source), &bus, habits, || {}).await
            }
        }
    }
}

async fn accept_by_radio(listener: TcpListener, air: Air) -> io::Result<()> {
    let mut connections = Connections::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_REST).await;
            continue;
        };
        let _ = stream.set_nodelay(true);
        let heard = connections.heard();
        let task = tokio::spawn(air.clone().serve_stream(stream));
        connections.add(heard, task.abort_handle());
    }
}

async fn accept(listener: TcpListener, wire: impl Fn() -> Wire, bus: impl Bus) -> io::Result<()> {
    let mut connections = Connections::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_REST).await;
            continue;
        };
        let heard = connections.heard();
        let task = tokio::spawn(serve_client(stream, wire(), bus.clone(), {
            let heard = heard.clone();
            move || heard.now()
        }));
        connections.add(heard, task.abort_handle());
    }
}

async fn serve_client(stream: TcpStream, wire: Wire, bus: impl Bus, heard: impl FnMut()) {
    // Answers are small and a client waits for each of them. A connection that breaks affects only
    // its client.
    let _ = stream.set_nodelay(true);
    let _ = serve_stream(stream, wire, &bus, Habits::default(), heard).await;
}

impl FromStr for Listen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (radio, rest) = match text.strip_prefix("radio+") {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let place = |place: &str| {
            let place = place.trim_end_matches('/');
            let port = place.rsplit_once(':').filter(|(host, _)| !host.is_empty());
            port.filter(|(_, port)| port.parse::<u16>().is_ok()).map(|_| place.to_owned())
        };
        let medium = match rest.split_once("://") {
            Some(("tcp", rest)) => {
                let (rest, records) = match rest.strip_suffix(RECORDS) {
                    Some(rest) => (rest, true),
                    None => (rest, false),
                };
                place(rest).map(|place| Medium::Tcp { place, records })
            }
            Some(("udp", rest)) => place(rest).map(Medium::Udp),
            None if rest == "pty" => Some(Medium::Pty),
            _ => None,
        };
        medium
            .map(|medium| Self { radio, medium })
            .ok_or_else(|| text::ListenerExpected.str(current()).to_owned())
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let radio = if self.radio { "radio+" } else { "" };
        match &self.medium {
            Medium::Tcp { place, records } => {
                let framing = if *records { RECORDS } else { "" };
                write!(f, "{radio}tcp://{place}{framing}")
            }
            Medium::Udp(place) => write!(f, "{radio}udp://{place}"),
            Medium::Pty => write!(f, "{radio}pty"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_to_listen() {
        for text in [
            "tcp://127.0.0.1:0",
            "tcp://127.0.0.1:0?framing=records",
            "udp://[::1]:10485",
            "pty",
            "radio+tcp://0.0.0.0:10486",
            "radio+udp://localhost:1",
            "radio+pty",
        ] {
            assert_eq!(text.parse::<Listen>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "tcp://",
            "tcp://127.0.0.1",
            "tcp://:1",
            "udp://h:x",
            "tty",
            "radio+",
            "http://h:1",
        ] {
            assert!(text.parse::<Listen>().is_err(), "{text}");
        }
    }
}
