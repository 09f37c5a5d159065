//! `lafet record`: records the traffic of a line to a file.

use std::fs::File;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::Args;
use lafet_capture::{Captured, Direction, Format, Recorder, Splitter};
use lafet_client::transport::Link;
use lafet_client::{Cause, Client, Config, Endpoint, Error, Framing, Role, SystemError};
use lafet_proto::link::WIRE_MAX;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, MissedTickBehavior, interval, sleep, timeout};

use crate::cli::{Global, seconds};
use crate::connect::{link, undisturbed, url_of};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, complain};

/// Interval at which the file is flushed: the most that a power cut can lose.
const FLUSH: Duration = Duration::from_secs(1);
/// Pause before a lost link is opened again.
const REDIAL: Duration = Duration::from_secs(1);
/// Capacity of a pipe to the client in this process, bytes.
const PIPE: usize = 4096;
/// A program that does not take answers for this long is disconnected: its requests would wait.
const SIDE_WRITE: Duration = Duration::from_secs(3);
/// Pause after a failed accept, for example when no file descriptor is left.
const ACCEPT_REST: Duration = Duration::from_millis(100);
/// How long the line is listened to before the first request.
const LISTEN: Duration = Duration::from_millis(100);

/// Arguments of `lafet record`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 record recording.mcap\n  lafet \
                        -c serial:///dev/ttyUSB0?baud=19200 record line.pcapng --listen\n  lafet \
                        -c tcp://192.168.1.50:10485 record tapped.mcap --tap 127.0.0.1:10500"
)]
pub struct RecordArgs {
    #[arg(value_name = "FILE", value_parser = recording)]
    file: PathBuf,
    #[arg(long)]
    force: bool,
    #[arg(long, conflicts_with = "tap")]
    listen: bool,
    #[arg(long, value_name = "ADDRESS")]
    tap: Option<SocketAddr>,
    #[arg(long, value_name = "SECONDS", default_value_t = 0.1, value_parser = every)]
    interval: f64,
    #[arg(long = "for", value_name = "SECONDS", value_parser = every)]
    duration: Option<f64>,
}

fn every(text: &str) -> Result<f64, String> {
    seconds(text, 0.02)
}

fn recording(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match Format::of_path(&path) {
        Some(_) => Ok(path),
        None => Err(text::RecordingExtension.str(current()).into()),
    }
}

/// Records until it is interrupted or `--for` has passed.
pub async fn run(args: RecordArgs, global: &Global, out: &mut Out) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    if !args.force && args.file.exists() {
        let name = args.file.display();
        return Err(Failure::Usage(text::FileExists { name: Shown(name) }.of(current())));
    }
    let url = url_of(global)?;
    let endpoint = &Endpoint::from_str(url).map_err(Error::from)?;
    let mut tape = Tape::new(&args.file, endpoint.framing())?;
    // Standard output and error must not hold up what a tap passes on.
    let mut aside = out.aside()?;
    let duration = args.duration.map_or(Duration::MAX, Duration::from_secs_f64);
    let recording = async {
        match args.tap {
            Some(address) => tap(address, (url, endpoint), global, &mut tape, &mut aside).await,
            None if args.listen => listen((url, endpoint), &mut tape, &mut aside).await,
            None => poll(args.interval, (url, endpoint), global, &mut tape, &mut aside).await,
        }
    };
    let ended = tokio::select! {
        ended = recording => ended,
        () = sleep(duration) => Ok(()),
        () = interrupt.wait() => Ok(()),
    };
    let rest = tape.rest(&mut aside);
    drop(aside);
    let (frames, bytes) = (tape.frames, tape.bytes);
    let finished = tape.finish();
    let name = args.file.display().to_string();
    ended.and(rest).and(finished)?;
    out.show(
        text::Recorded { name: &name, frames, bytes }.of(current()),
        || json!({ "file": name, "frames": frames, "bytes": bytes }),
    )
}

/// Polls the state of all subsystems, as a console would.
async fn poll(
    every_s: f64,
    (url, endpoint): (&str, &Endpoint),
    global: &Global,
    tape: &mut Tape,
    out: &mut Out,
) -> Outcome {
    let answer = Duration::from_secs_f64(global.timeout);
    // Other clients may use this bus, behind a serial server too: listen first.
    let config = Config { timeout: answer, listen: LISTEN, ..Config::default() }.of(endpoint);
    let (mut link, heard) = undisturbed(url, endpoint, global).await?;
    if heard.has_controller() && endpoint.behaviour().role == Role::Direct {
        complain(controller_present());
        return bridge_again::<DuplexStream>(url, endpoint, &mut link, None, tape, out).await;
    }
    let (ours, theirs) = tokio::io::duplex(PIPE);
    let client = Client::over(url, ours, config);
    let held_back = Arc::new(AtomicBool::new(false));
    let told = held_back.clone();
    let asking = async {
        let mut looks = interval(Duration::from_secs_f64(every_s));
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            looks.tick().await;
            // A monitor that does not answer for a while is part of the recording.
            let asked = client.request(&Request::new(SubsystemId::ALL, Body::GetStatus)).await;
            if matches!(asked, Err(Error::NotSent { cause: Cause::ControllerPresent, .. }))
                && !told.swap(true, Ordering::Relaxed)
            {
                complain(controller_present());
            }
        }
    };
    tokio::select! {
        never = asking => never,
        ended = bridge_again(url, endpoint, &mut link, Some(theirs), tape, out) => ended,
    }
}

fn controller_present() -> &'static str {
    text::PollsWithheld.str(current())
}

async fn listen((url, endpoint): (&str, &Endpoint), tape: &mut Tape, out: &mut Out) -> Outcome {
    let mut link = link(url, endpoint).await?;
    bridge_again::<DuplexStream>(url, endpoint, &mut link, None, tape, out).await
}

/// Serves programs, one after another. A further one is disconnected at once: what it sent would
/// wait, and reach the monitor when its sender expects it no more.
async fn tap(
    address: SocketAddr,
    (url, endpoint): (&str, &Endpoint),
    global: &Global,
    tape: &mut Tape,
    out: &mut Out,
) -> Outcome {
    let framing = endpoint.framing();
    let what = || text::CannotListenTap { address: Shown(address) }.of(current());
    let listener = TcpListener::bind(address).await.map_err(|error| Failure::io(what(), error))?;
    // A program that comes meanwhile is disconnected, too: what it asks would be late.
    let (mut link, _) = tokio::select! {
        heard = undisturbed(url, endpoint, global) => heard?,
        never = turn_away(&listener) => never,
    };
    let bound = listener.local_addr()?;
    out.show(
        text::ConnectTap { bound: Shown(bound), url }.of(current()),
        || json!({ "url": format!("tcp://{bound}"), "to": url }),
    )?;
    tape.passes_on = true;
    loop {
        // Late answers to one program are not for the next: the line is read between them.
        let side = tokio::select! {
            biased;
            ended = bridge::<TcpStream>(&mut link, None, framing, tape, out) => Err(ended?),
            stream = accepted(&listener) => Ok(stream),
        };
        // Without a link the program is disconnected: what it sends would be passed on later.
        let ended = match side {
            Ok(mut stream) => tokio::select! {
                biased;
                ended = bridge(&mut link, Some(&mut stream), framing, tape, out) => ended?,
                never = turn_away(&listener) => never,
            },
            Err(ended) => ended,
        };
        if let Ended::Link(error) = ended {
            out.progress(text::Reconnecting { url, error: SystemError(&error) }.of(current()));
            link = tokio::select! {
                biased;
                again = redial(url, endpoint) => again,
                never = turn_away(&listener) => never,
            };
        }
    }
}

/// The next program.
async fn accepted(listener: &TcpListener) -> TcpStream {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                // Only slower without.
                let _ = stream.set_nodelay(true);
                return stream;
            }
            Err(_) => sleep(ACCEPT_REST).await,
        }
    }
}

/// Disconnects every program that comes.
async fn turn_away<T>(listener: &TcpListener) -> T {
    loop {
        drop(accepted(listener).await);
    }
}

/// Bridges, reopening a lost link; ends when the other side disconnects.
async fn bridge_again<S: AsyncRead + AsyncWrite + Unpin>(
    url: &str,
    endpoint: &Endpoint,
    on: &mut Link,
    mut side: Option<S>,
    tape: &mut Tape,
    out: &mut Out,
) -> Outcome {
    loop {
        let error = match bridge(on, side.as_mut(), endpoint.framing(), tape, out).await? {
            Ended::Side => return Ok(()),
            Ended::Link(error) => error,
        };
        out.progress(text::Reconnecting { url, error: SystemError(&error) }.of(current()));
        *on = tokio::select! {
            again = redial(url, endpoint) => again,
            () = discard(side.as_mut()) => return Ok(()),
        };
    }
}

/// Opens a lost link again.
async fn redial(url: &str, endpoint: &Endpoint) -> Link {
    loop {
        sleep(REDIAL).await;
        if let Ok(again) = link(url, endpoint).await {
            return again;
        }
    }
}

/// Reads what a side sends without a link, until it ends: it would be stale with the next one.
async fn discard<S: AsyncRead + Unpin>(mut side: Option<&mut S>) {
    let mut buffer = [0; WIRE_MAX];
    while let Ok(1..) = read_side(&mut side, &mut buffer).await {}
}

/// Which end of a bridge was lost.
enum Ended {
    Side,
    Link(io::Error),
}

/// Cuts a stream into the pieces that are passed on and recorded.
enum Cutter {
    /// Each ends with a link frame.
    Frames(Splitter),
    /// As they were received: nothing in bare records shows where a request ends.
    AsReceived,
}

impl Cutter {
    fn new(framing: Framing) -> Self {
        match framing {
            Framing::Records => Self::AsReceived,
            _ => Self::Frames(Splitter::new()),
        }
    }

    fn push(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        match self {
            Self::Frames(splitter) => splitter.push(bytes),
            Self::AsReceived => vec![bytes.to_vec()],
        }
    }

    /// What ends with no frame.
    fn rest(&mut self) -> Option<Vec<u8>> {
        match self {
            Self::Frames(splitter) => splitter.rest(),
            Self::AsReceived => None,
        }
    }
}

/// Passes bytes on between a link and a stream, and records them.
async fn bridge<S: AsyncRead + AsyncWrite + Unpin>(
    link: &mut Link,
    mut side: Option<&mut S>,
    framing: Framing,
    tape: &mut Tape,
    out: &mut Out,
) -> Result<Ended, Failure> {
    let mut from_link = [0; 2 * WIRE_MAX];
    let mut from_side = [0; 2 * WIRE_MAX];
    let heard = if side.is_some() { Direction::FromMonitor } else { Direction::Heard };
    let mut requests = Cutter::new(framing);
    let mut flush = interval(FLUSH);
    flush.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            read = link.recv(&mut from_link) => {
                let bytes = match read {
                    Ok(len) => &from_link[..len],
                    Err(error) => {
                        tape.rest(out)?;
                        return Ok(Ended::Link(error));
                    }
                };
                tape.hear(heard, bytes, out)?;
                if let Some(side) = &mut side
                    && !matches!(timeout(SIDE_WRITE, side.write_all(bytes)).await, Ok(Ok(())))
                {
                    return Ok(Ended::Side);
                }
            }
            read = read_side(&mut side, &mut from_side) => {
                let len = match read {
                    Ok(0) | Err(_) => return Ok(Ended::Side),
                    Ok(len) => len,
                };
                for piece in requests.push(&from_side[..len]) {
                    if let Err(error) = link.send(&piece).await {
                        return Ok(Ended::Link(error));
                    }
                    tape.frame(Direction::ToMonitor, piece, out)?;
                }
            }
            _ = flush.tick() => tape.flush(out)?,
        }
    }
}

async fn read_side<S: AsyncRead + Unpin>(
    side: &mut Option<&mut S>,
    buffer: &mut [u8],
) -> io::Result<usize> {
    match side {
        Some(side) => side.read(buffer).await,
        None => std::future::pending().await,
    }
}

/// The recording being written, and what it contains so far.
struct Tape {
    recorder: Recorder<File>,
    name: String,
    start: Instant,
    start_ns: u64,
    /// What the link has brought, and how.
    heard: Cutter,
    direction: Direction,
    frames: u64,
    bytes: u64,
    /// The traffic goes on without the recording.
    passes_on: bool,
    /// Why nothing more is recorded.
    broken: Option<Failure>,
}

impl Tape {
    fn new(file: &PathBuf, framing: Framing) -> Result<Self, Failure> {
        let name = file.display().to_string();
        let format = Format::of_path(file).unwrap_or(Format::Mcap);
        let recorder = File::create(file)
            .and_then(|file| Recorder::new(format, file))
            .map_err(|error| cannot_write(&name, error))?;
        let (start, start_ns) = (Instant::now(), wall_ns());
        let (heard, direction) = (Cutter::new(framing), Direction::Heard);
        let (frames, bytes, passes_on, broken) = (0, 0, false, None);
        Ok(Self {
            recorder,
            name,
            start,
            start_ns,
            heard,
            direction,
            frames,
            bytes,
            passes_on,
            broken,
        })
    }

    /// The link has brought these bytes.
    fn hear(&mut self, direction: Direction, bytes: &[u8], out: &mut Out) -> Outcome {
        if direction != self.direction {
            self.rest(out)?;
            self.direction = direction;
        }
        for frame in self.heard.push(bytes) {
            self.frame(direction, frame, out)?;
        }
        Ok(())
    }

    /// What it has brought after the last frame: no more of that comes.
    fn rest(&mut self, out: &mut Out) -> Outcome {
        let rest = self.heard.rest();
        rest.map_or(Ok(()), |bytes| self.write(self.direction, bytes, out))
    }

    fn frame(&mut self, direction: Direction, bytes: Vec<u8>, out: &mut Out) -> Outcome {
        if self.broken.is_none() {
            self.frames += 1;
        }
        self.write(direction, bytes, out)
    }

    fn write(&mut self, direction: Direction, bytes: Vec<u8>, out: &mut Out) -> Outcome {
        if self.broken.is_some() {
            return Ok(());
        }
        // The wall clock may jump; time within a recording must not.
        let at_ns = self.start_ns + self.start.elapsed().as_nanos() as u64;
        self.bytes += bytes.len() as u64;
        let written = self.recorder.write(&Captured { at_ns, direction, bytes });
        self.after(written, out)
    }

    fn flush(&mut self, out: &mut Out) -> Outcome {
        if self.broken.is_some() {
            return Ok(());
        }
        let written = self.recorder.flush();
        self.after(written, out)
    }

    /// A full disk ends the recording, and not what a tap passes on.
    fn after(&mut self, written: io::Result<()>, out: &mut Out) -> Outcome {
        let failure = match written.map_err(|error| cannot_write(&self.name, error)) {
            Err(failure) if self.passes_on => failure,
            written => return written,
        };
        out.warn(&format!("{} {}", failure.message(), text::TapGoesOn.str(current())));
        self.broken = Some(failure);
        Ok(())
    }

    fn finish(self) -> Outcome {
        let finished = self.recorder.finish().map_err(|error| cannot_write(&self.name, error));
        self.broken.map_or(finished, Err)
    }
}

#[expect(clippy::disallowed_methods, reason = "a recording contains the time it was made")]
fn wall_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64)
}

fn cannot_write(name: &str, error: io::Error) -> Failure {
    Failure::io(text::CannotWriteFile { name }.of(current()), error)
}
