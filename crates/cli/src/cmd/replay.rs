//! `lafet replay`: shows a recording with its original timing.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use lafet_capture::{Captured, Direction, ReadError, read};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until, timeout};

use crate::decode::{Form, Writer};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;
use crate::simulator::speed_or_zero;

/// Pieces that a listener may lag behind before the replay waits for it.
const LAG: usize = 64;
/// How long the replay waits for a listener that lags.
const PATIENCE: Duration = Duration::from_secs(3);

/// Arguments of `lafet replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet replay recording.mcap\n  \
                        lafet replay recording.pcapng --speed 0\n  \
                        lafet replay recording.mcap --serve 127.0.0.1:10485")]
pub struct ReplayArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = speed_or_zero)]
    speed: f64,
    #[arg(long, value_name = "ADDRESS")]
    serve: Option<SocketAddr>,
}

/// Runs `lafet replay`.
pub async fn run(args: ReplayArgs, out: &mut Out) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    let pieces = pieces(&args.file)?;
    let mut audience = None;
    if let Some(address) = args.serve {
        audience = Some(tokio::select! {
            audience = Audience::gather(address, out) => audience?,
            () = interrupt.wait() => return Ok(()),
        });
    }
    let mut show = Show::new(&pieces, out.json());
    let start = Instant::now();
    for piece in &pieces {
        if args.speed > 0.0 {
            let at = Duration::from_secs_f64(show.seconds(piece) / args.speed);
            tokio::select! {
                () = sleep_until(start + at) => {}
                () = interrupt.wait() => return Ok(()),
            }
        }
        if let (Some(audience), Direction::FromMonitor | Direction::Heard) =
            (&mut audience, piece.direction)
        {
            audience.send(&piece.bytes).await;
        }
        show.piece(piece, out)?;
    }
    if let Some(audience) = audience {
        audience.dismiss().await;
    }
    Ok(())
}

/// Reads the pieces of a recording, or says why it cannot be read.
pub fn pieces(file: &Path) -> Result<Vec<Captured>, Failure> {
    read(file).map_err(|error| {
        let name = file.display();
        match error {
            ReadError::Io(source) => {
                let what = text::CannotReadRecording { name: Shown(&name) }.of(current());
                Failure::io(what, source)
            }
            other => Failure::Usage(format!("{name}: {}", other.of(current()))),
        }
    })
}

/// Programs that listen to a replay.
struct Audience {
    newcomers: mpsc::Receiver<TcpStream>,
    listeners: Vec<mpsc::Sender<Vec<u8>>>,
    feeds: JoinSet<()>,
}

impl Audience {
    /// Waits for the first listener; more may connect later.
    async fn gather(address: SocketAddr, out: &mut Out) -> Result<Self, Failure> {
        let what = || text::CannotListenTap { address: Shown(address) }.of(current());
        let listener =
            TcpListener::bind(address).await.map_err(|error| Failure::io(what(), error))?;
        let bound = listener.local_addr()?;
        out.show(
            text::ReplayWaits { bound: Shown(bound) }.of(current()),
            || json!({ "url": format!("tcp://{bound}") }),
        )?;
        let (first, _) = listener.accept().await?;
        let (arrived, newcomers) = mpsc::channel(LAG);
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                if arrived.send(stream).await.is_err() {
                    return;
                }
            }
        });
        let mut audience = Self { newcomers, listeners: Vec::new(), feeds: JoinSet::new() };
        audience.admit(first);
        Ok(audience)
    }

    fn admit(&mut self, mut stream: TcpStream) {
        let (sender, mut pieces) = mpsc::channel::<Vec<u8>>(LAG);
        self.listeners.push(sender);
        self.feeds.spawn(async move {
            while let Some(bytes) = pieces.recv().await {
                if stream.write_all(&bytes).await.is_err() {
                    return;
                }
            }
        });
    }

    /// Sends to all listeners; waits for those that lag, and drops those that stopped reading.
    async fn send(&mut self, bytes: &[u8]) {
        while let Ok(stream) = self.newcomers.try_recv() {
            self.admit(stream);
        }
        let mut left = Vec::new();
        for listener in self.listeners.drain(..) {
            if matches!(timeout(PATIENCE, listener.send(bytes.to_vec())).await, Ok(Ok(()))) {
                left.push(listener);
            }
        }
        self.listeners = left;
    }

    /// Lets all listeners receive the end.
    async fn dismiss(mut self) {
        self.listeners.clear();
        // Listeners that stopped reading are given up after [`PATIENCE`].
        let _ = timeout(PATIENCE, async { while self.feeds.join_next().await.is_some() {} }).await;
    }
}

/// Prints pieces as text or JSON, each line with its time.
struct Show {
    decoder: Writer<Vec<u8>>,
    start_ns: u64,
    json: bool,
}

impl Show {
    fn new(pieces: &[Captured], json: bool) -> Self {
        let form = if json { Form::Json } else { Form::Text };
        let start_ns = pieces.first().map_or(0, |piece| piece.at_ns);
        Self { decoder: Writer::new(Vec::new(), form), start_ns, json }
    }

    /// Seconds from the start of the recording.
    fn seconds(&self, piece: &Captured) -> f64 {
        piece.at_ns.saturating_sub(self.start_ns) as f64 / 1e9
    }

    fn piece(&mut self, piece: &Captured, out: &mut Out) -> Outcome {
        self.decoder.feed(&piece.bytes)?;
        let at_s = self.seconds(piece);
        let lines = self.decoder.take();
        for line in String::from_utf8_lossy(&lines).lines() {
            if self.json {
                let mut json: Value = serde_json::from_str(line).unwrap_or_default();
                json["t_s"] = json!(at_s);
                out.value(&json)?;
            } else {
                out.say(format!("{at_s:10.3}  {line}"))?;
            }
        }
        Ok(())
    }
}
