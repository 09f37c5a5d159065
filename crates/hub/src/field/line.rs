//! The lines of buses: how the configuration names them, and exchanges over them.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::time::Duration;

use lafet_client::transport::port::Claim;
use lafet_client::{Lang, os_text};
use lafet_texts::{Text as _, hub as text};
use serial2_tokio::{CharSize, FlowControl, Parity, SerialPort, Settings, StopBits};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::wire::{Asks, Codec, Failure, Framing};
use crate::text::Both;

/// Port of Modbus over TCP.
const PORT: u16 = 502;
/// Longest time for opening a connection.
const CONNECT: Duration = Duration::from_secs(3);
/// Bits of a character on a serial line, start, parity and stop included.
const CHARACTER_BITS: u64 = 11;
/// Silence between frames: three and a half characters, at higher speeds a fixed time.
const SILENCE_BITS: u64 = 39;
const SILENCE: Duration = Duration::from_micros(1750);
/// Silence is waited for so long at most; a line that is never silent has a fault.
const NOISE_MAX: Duration = Duration::from_millis(100);

/// The line of a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// `tcp://…`, or `rtu+tcp://…`: frames of a serial line over TCP.
    Tcp {
        /// Name or address.
        host: String,
        /// Port.
        port: u16,
        /// Frames on it.
        framing: Framing,
    },
    /// `serial:///…`: RTU.
    Serial {
        /// The device.
        path: PathBuf,
        /// Speed, baud.
        baud: u32,
        /// Parity.
        parity: Parity,
        /// Stop bits.
        stop: StopBits,
    },
}

impl Line {
    /// The device of a serial line.
    pub fn device(&self) -> Option<&PathBuf> {
        match self {
            Self::Serial { path, .. } => Some(path),
            Self::Tcp { .. } => None,
        }
    }

    /// Reads a URL of the configuration.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub fn parse(url: &str) -> Result<Self, Both> {
        let no_line = || text::CheckLine { url }.words();
        let (scheme, rest) = url.split_once("://").ok_or_else(no_line)?;
        let (place, query) = rest.split_once('?').unwrap_or((rest, ""));
        let options: Vec<(&str, &str)> = query
            .split('&')
            .filter(|it| !it.is_empty())
            .map(|it| it.split_once('=').unwrap_or((it, "")))
            .collect();
        match scheme {
            "tcp" | "rtu+tcp" => {
                if let Some((name, _)) = options.first() {
                    return Err(no_option(url, name));
                }
                let framing = if scheme == "tcp" { Framing::Tcp } else { Framing::Rtu };
                let (host, port) = host_and_port(place).ok_or_else(no_line)?;
                Ok(Self::Tcp { host, port, framing })
            }
            "serial" if place.starts_with('/') && place.len() > 1 => serial(url, place, &options),
            _ => Err(no_line()),
        }
    }

    /// Frames on it.
    pub const fn framing(&self) -> Framing {
        match self {
            Self::Tcp { framing, .. } => *framing,
            Self::Serial { .. } => Framing::Rtu,
        }
    }

    /// Time that so many bytes take on it, the silence between frames not included.
    pub fn takes(&self, bytes: usize) -> Duration {
        match self {
            Self::Tcp { .. } => Duration::ZERO,
            Self::Serial { baud, .. } => bits(CHARACTER_BITS * bytes as u64, *baud),
        }
    }

    /// Opens a serial line, and keeps other programs out of it.
    ///
    /// # Errors
    ///
    /// Why it cannot be opened.
    pub fn open_port(&self) -> Result<(SerialPort, Claim), Both> {
        let Self::Serial { path, baud, parity, stop } = self else {
            return Err(remedy());
        };
        let mut claim = Claim::lock(path, false).map_err(|error| said(&error))?;
        let settings = |mut settings: Settings| {
            settings.set_raw();
            settings.set_baud_rate(*baud)?;
            settings.set_char_size(CharSize::Bits8);
            settings.set_stop_bits(*stop);
            settings.set_parity(*parity);
            settings.set_flow_control(FlowControl::None);
            Ok(settings)
        };
        let port = SerialPort::open(path, settings).map_err(|error| said(&error))?;
        claim.keep_others_out().map_err(|error| said(&error))?;
        port.discard_buffers().map_err(|error| said(&error))?;
        Ok((port, claim))
    }

    /// Silence between frames.
    pub fn silence(&self) -> Duration {
        match self {
            Self::Tcp { framing: Framing::Tcp, .. } => Duration::ZERO,
            Self::Tcp { .. } => SILENCE,
            Self::Serial { baud, .. } => bits(SILENCE_BITS, *baud).max(SILENCE),
        }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp { host, port, framing } => {
                let scheme = if *framing == Framing::Tcp { "tcp" } else { "rtu+tcp" };
                match host.contains(':') {
                    true => write!(f, "{scheme}://[{host}]:{port}"),
                    false => write!(f, "{scheme}://{host}:{port}"),
                }
            }
            Self::Serial { path, baud, .. } => write!(f, "serial://{}?baud={baud}", path.display()),
        }
    }
}

/// What a URL looks like.
pub fn remedy() -> Both {
    text::CheckLineRemedy.words()
}

fn no_option(url: &str, name: &str) -> Both {
    text::CheckLineOption { url, name }.words()
}

fn host_and_port(place: &str) -> Option<(String, u16)> {
    let place = place.strip_suffix('/').unwrap_or(place);
    let (host, port) = match place.strip_prefix('[') {
        Some(rest) => {
            let (host, rest) = rest.split_once(']')?;
            host.parse::<std::net::Ipv6Addr>().ok()?;
            (host, rest.strip_prefix(':').or(rest.is_empty().then_some(""))?)
        }
        None => place.split_once(':').unwrap_or((place, "")),
    };
    let port = if port.is_empty() { PORT } else { port.parse().ok().filter(|it| *it > 0)? };
    let fine = |c: char| c.is_alphanumeric() || "-._:".contains(c);
    (!host.is_empty() && host.chars().all(fine)).then(|| (host.to_owned(), port))
}

fn serial(url: &str, path: &str, options: &[(&str, &str)]) -> Result<Line, Both> {
    let (mut baud, mut parity, mut stop) = (19_200, Parity::Even, None);
    for (name, value) in options {
        match (*name, *value) {
            ("baud", value) => {
                let given = value.parse().ok().filter(|it| (300..=1_000_000).contains(it));
                baud = given.ok_or_else(|| no_option(url, name))?;
            }
            ("parity", "even") => parity = Parity::Even,
            ("parity", "odd") => parity = Parity::Odd,
            ("parity", "none") => parity = Parity::None,
            ("stop", "1") => stop = Some(StopBits::One),
            ("stop", "2") => stop = Some(StopBits::Two),
            _ => return Err(no_option(url, name)),
        }
    }
    // Eleven bits a character, unless something else is asked for.
    let usual = if parity == Parity::None { StopBits::Two } else { StopBits::One };
    Ok(Line::Serial { path: path.into(), baud, parity, stop: stop.unwrap_or(usual) })
}

fn bits(count: u64, baud: u32) -> Duration {
    Duration::from_micros(count * 1_000_000 / u64::from(baud.max(1)))
}

trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}
impl<T: AsyncRead + AsyncWrite + Unpin + Send> Stream for T {}

/// An open line.
pub struct Link {
    line: Line,
    stream: Box<dyn Stream>,
    codec: Codec,
    /// The device that has not answered, and until when its answer may still come.
    owes: Option<(u8, Instant)>,
    /// Keeps others away from a serial port; released after it is closed.
    _claim: Option<Claim>,
}

impl Link {
    /// Opens a line.
    ///
    /// # Errors
    ///
    /// Why it cannot be opened.
    pub async fn open(line: &Line) -> Result<Self, Both> {
        let (stream, claim): (Box<dyn Stream>, _) = match line {
            Line::Tcp { host, port, .. } => {
                let opened = timeout(CONNECT, TcpStream::connect((host.as_str(), *port))).await;
                let opened = opened.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()));
                let stream = opened.map_err(|error| said(&error))?;
                stream.set_nodelay(true).map_err(|error| said(&error))?;
                (Box::new(stream), None)
            }
            Line::Serial { .. } => {
                let (port, claim) = line.open_port()?;
                (Box::new(port), Some(claim))
            }
        };
        let codec = Codec::new(line.framing());
        Ok(Self { line: line.clone(), stream, codec, owes: None, _claim: claim })
    }

    /// Answers that came too late since this was asked last.
    pub fn late(&mut self) -> u64 {
        self.codec.late()
    }

    /// Asks a device on a line that is [settled](Self::settle), and waits for its answer, over TCP
    /// unless something more urgent comes: a late answer is known by its number there.
    ///
    /// # Errors
    ///
    /// What came instead of it.
    pub async fn exchange(
        &mut self,
        request: &dyn Asks,
        patience: Duration,
        urgent: impl Future<Output = ()>,
    ) -> Result<Vec<u16>, Failure> {
        let frame = self.codec.frame(request);
        let deadline = Instant::now() + patience + self.line.takes(request.serial_len());
        match timeout_at(deadline, self.stream.write_all(&frame)).await {
            Ok(sent) => sent.map_err(closed)?,
            Err(_) => {
                return Err(Failure::Closed(text::BusTakesNothing.words()));
            }
        }
        let gives_up = self.line.framing() == Framing::Tcp;
        tokio::select! {
            biased;
            answer = self.answer(request, deadline, patience) => answer,
            () = urgent, if gives_up => Err(Failure::GivenUp),
        }
    }

    /// Waits for the answer to a request that was sent.
    async fn answer(
        &mut self,
        request: &dyn Asks,
        deadline: Instant,
        patience: Duration,
    ) -> Result<Vec<u16>, Failure> {
        let mut buffer = [0; 512];
        loop {
            let Ok(read) = timeout_at(deadline, self.stream.read(&mut buffer)).await else {
                self.owes = Some((request.unit(), Instant::now() + patience));
                return Err(self.codec.overdue(request));
            };
            let bytes = buffer.get(..some(read)?).unwrap_or_default();
            if let Some(answer) = self.codec.take(bytes, request) {
                return answer;
            }
            // Where bytes come without a pause, no read has to wait until the time is over.
            if Instant::now() >= deadline {
                self.owes = Some((request.unit(), Instant::now() + patience));
                return Err(self.codec.overdue(request));
            }
        }
    }

    /// Waits until a device can be asked. A serial line is silent before a request, and an answer that is
    /// owed has had its time: without numbers it would be taken for the next one.
    ///
    /// # Errors
    ///
    /// The line is never silent, or the connection has ended.
    pub async fn settle(&mut self, unit: u8) -> Result<(), Failure> {
        if self.line.framing() == Framing::Tcp {
            return Ok(());
        }
        if let Some((_, until)) = self.owes.take_if(|(owing, _)| *owing == unit) {
            sleep_until(until).await;
        }
        let (silence, noise) = (self.line.silence(), Instant::now() + NOISE_MAX);
        let mut buffer = [0; 512];
        while let Ok(read) = timeout(silence, self.stream.read(&mut buffer)).await {
            some(read)?;
            if Instant::now() >= noise {
                return Err(Failure::Garbage);
            }
        }
        Ok(())
    }
}

/// Bytes that were read; none at all is the end of the connection.
fn some(read: io::Result<usize>) -> Result<usize, Failure> {
    match read {
        Ok(0) => Err(closed(io::ErrorKind::UnexpectedEof.into())),
        Ok(len) => Ok(len),
        Err(error) => Err(closed(error)),
    }
}

fn closed(error: io::Error) -> Failure {
    Failure::Closed(said(&error))
}

/// An error of the system in words.
pub fn said(error: &io::Error) -> Both {
    let of = |lang| format!("{}.", os_text(error, lang));
    Both { en: of(Lang::En), ru: of(Lang::Ru) }
}

#[cfg(test)]
mod tests {
    use std::pin::Pin;
    use std::task::{Context, Poll};

    use tokio::io::ReadBuf;

    use super::super::wire::{Request, Table};
    use super::*;

    #[test]
    fn lines_are_read() {
        for (url, shown) in [
            ("tcp://10.0.0.9", "tcp://10.0.0.9:502"),
            ("tcp://panel.site:1502/", "tcp://panel.site:1502"),
            ("rtu+tcp://[fd00::9]:4001", "rtu+tcp://[fd00::9]:4001"),
            ("serial:///dev/ttyUSB1", "serial:///dev/ttyUSB1?baud=19200"),
            ("serial:///dev/ttyS0?baud=9600&parity=none", "serial:///dev/ttyS0?baud=9600"),
        ] {
            assert_eq!(Line::parse(url).unwrap().to_string(), shown);
        }
        let stop = |url| match Line::parse(url).unwrap() {
            Line::Serial { stop, parity, .. } => (stop, parity),
            other => panic!("{other:?}"),
        };
        assert_eq!(stop("serial:///a"), (StopBits::One, Parity::Even));
        assert_eq!(stop("serial:///a?parity=none"), (StopBits::Two, Parity::None));
        assert_eq!(stop("serial:///a?stop=1&parity=none"), (StopBits::One, Parity::None));
    }

    #[test]
    fn what_is_no_line_is_refused_in_both_languages() {
        for url in [
            "",
            "10.0.0.9:502",
            "tcp://",
            "tcp://h:0",
            "tcp://h:70000",
            "tcp://h:502x",
            "tcp://[::1",
            "tcp://[h]",
            "tcp://a b",
            "udp://h",
            "serial://",
            "serial:///",
            "serial://ttyS0",
        ] {
            let what = Line::parse(url).unwrap_err();
            assert!(
                what.en.contains("is no line") && what.ru.contains("не линия"),
                "{url}: {what:?}"
            );
        }
        for (url, name) in [
            ("tcp://h?unit=1", "unit"),
            ("serial:///a?baud=20", "baud"),
            ("serial:///a?baud=fast", "baud"),
            ("serial:///a?parity=mark", "parity"),
            ("serial:///a?bits=7", "bits"),
        ] {
            let what = Line::parse(url).unwrap_err();
            assert!(what.en.contains(&format!("{name} cannot be given")), "{what:?}");
            assert!(what.ru.contains("так указать нельзя"), "{what:?}");
        }
    }

    #[test]
    fn a_slow_line_takes_its_time() {
        let line = Line::parse("serial:///a?baud=9600").unwrap();
        assert_eq!(line.takes(96), Duration::from_millis(110));
        assert!(line.silence() > Duration::from_millis(4));
        let net = Line::parse("tcp://h").unwrap();
        assert_eq!((net.takes(96), net.silence()), (Duration::ZERO, Duration::ZERO));
    }

    /// Bytes that come faster than they are read, without a pause.
    struct Babble(u32);

    impl AsyncRead for Babble {
        fn poll_read(
            mut self: Pin<&mut Self>,
            _: &mut Context<'_>,
            buffer: &mut ReadBuf<'_>,
        ) -> Poll<io::Result<()>> {
            self.0 += 1;
            assert!(self.0 < 1_000_000, "it is read without an end");
            buffer.put_slice(&[0x55; 64]);
            Poll::Ready(Ok(()))
        }
    }

    impl AsyncWrite for Babble {
        fn poll_write(
            mut self: Pin<&mut Self>,
            _: &mut Context<'_>,
            bytes: &[u8],
        ) -> Poll<io::Result<usize>> {
            self.0 = 0;
            Poll::Ready(Ok(bytes.len()))
        }

        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }

        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    /// In real time: such a line leaves virtual time no moment to pass. A server that speaks only while
    /// it is asked is as bad.
    #[tokio::test]
    async fn a_line_that_is_never_quiet_is_garbage() {
        let request = Request { unit: 1, table: Table::Holding, first: 0, count: 1 };
        let patience = Duration::from_millis(20);
        for settles in [false, true] {
            let line = Line::parse("rtu+tcp://h:1").unwrap();
            let codec = Codec::new(line.framing());
            let stream = Box::new(Babble(0));
            let mut link = Link { line, stream, codec, owes: None, _claim: None };
            let failure = match settles {
                true => link.settle(1).await.unwrap_err(),
                false => {
                    link.answer(&request, Instant::now() + patience, patience).await.unwrap_err()
                }
            };
            assert!(matches!(failure, Failure::Garbage), "{failure:?}");
        }
    }
}
