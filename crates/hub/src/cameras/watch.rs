//! The process of a camera: it is started, judged by what it says, ended, and started again.

use std::io;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_eyes::wire::{Fault, FaultKind, Frame, Login, Said, Settings};
use lafet_texts::{Text as _, hub as text};
use tokio::io::{AsyncWriteExt, BufReader};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};
use tokio::time::{Instant, sleep, timeout};

use super::view::CameraWord;
use super::{Camera, Counts, message, waited};
use crate::hub::{Hub, resident};
use crate::text::Both;

/// A process that says nothing for so long hangs: it says twice a second that it runs.
const HANGS: Duration = Duration::from_secs(3);
/// No new picture for so long: it is frozen. With the time between two signs of life less than 2 s.
const FROZEN: Duration = Duration::from_millis(1200);
/// Pauses before a process is started again: doubled each time.
const PAUSE_FIRST: Duration = Duration::from_millis(500);
const PAUSE_LAST: Duration = Duration::from_secs(15);
/// Cameras lock a user out who has tried a wrong password too often.
const PAUSE_LOGIN: Duration = Duration::from_secs(30);
const PAUSE_LOGIN_LAST: Duration = Duration::from_secs(300);
/// After so long a picture, a fault is a new one.
const PLAYED: Duration = Duration::from_secs(10);
/// Memory that a process may take, and how often it is looked at.
const MEMORY_MAX: u64 = 160 * 1024 * 1024;
const LOOK: Duration = Duration::from_secs(1);
/// What a camera may send, bytes a second (48 Mbit/s), and at once.
const RATE_MAX: f64 = 6e6;
const BURST_MAX: f64 = 24e6;
/// Each message counts as so many bytes at least: 600 a second.
const MESSAGE_LEAST: f64 = 10e3;
/// How a stream is decoded is published this often at most, however often it changes.
const NEWS: Duration = Duration::from_secs(1);
/// How long the end of a process is waited for.
const ENDS: Duration = Duration::from_secs(2);
const BUFFER: usize = 64 * 1024;

/// Why a process has ended, or was ended.
#[derive(Debug)]
struct Ended {
    why: Both,
    /// For the log.
    detail: String,
    login: bool,
}

impl Ended {
    fn new(why: Both, detail: impl ToString) -> Self {
        Self { why, detail: detail.to_string(), login: false }
    }

    fn of(fault: Fault) -> Self {
        let why = match fault.kind {
            FaultKind::Unreachable => text::CameraUnreachable.words(),
            FaultKind::Login => text::CameraLogin.words(),
            FaultKind::Missing => text::CameraMissing.words(),
            FaultKind::Codec => text::CameraCodec.words(),
            FaultKind::Broken => text::CameraBroken.words(),
            FaultKind::Ended => text::CameraEnded.words(),
            FaultKind::Silent => text::CameraSilent.words(),
            FaultKind::Large => text::CameraLarge.words(),
        };
        Self { why, detail: fault.detail, login: fault.kind == FaultKind::Login }
    }
}

/// Watches a camera until the hub ends.
pub async fn watch(hub: Hub, camera: Arc<Camera>) {
    let mut shutdown = hub.shutdown();
    tokio::select! {
        () = again_and_again(&hub, &camera) => {}
        () = shutdown.requested() => {}
    }
}

async fn again_and_again(hub: &Hub, camera: &Camera) {
    let mut pauses = Pauses::default();
    loop {
        let began = Instant::now();
        Counts::add(&camera.counts.starts, 1);
        let ended = match start(hub, camera).await {
            Ok(mut process) => {
                let ended = process.heed(hub, camera).await;
                process.end().await;
                ended
            }
            Err(ended) => ended,
        };
        camera.feed.clear();
        if camera.set(hub, CameraWord::Failed, Some(ended.why.clone())).is_some() {
            let (camera, why, detail) = (camera.id(), &ended.why.en, &ended.detail);
            tracing::warn!(camera, why, detail, "no picture of a camera");
        }
        sleep(pauses.next(began.elapsed(), ended.login)).await;
    }
}

/// How long to wait before the next start.
#[derive(Debug, Default)]
struct Pauses {
    last: Option<Duration>,
}

impl Pauses {
    /// After a process that has run for so long.
    fn next(&mut self, ran: Duration, login: bool) -> Duration {
        let (first, most) = match login {
            true => (PAUSE_LOGIN, PAUSE_LOGIN_LAST),
            false => (PAUSE_FIRST, PAUSE_LAST),
        };
        let last = self.last.filter(|_| ran < PLAYED);
        let pause = last.map_or(first, |last| (last * 2).clamp(first, most));
        self.last = Some(pause);
        pause
    }
}

/// A process that runs. It ends with its input, whose end this is.
struct Process {
    child: Child,
    from: BufReader<ChildStdout>,
    #[expect(dead_code, reason = "held: its end is the end of the process")]
    to: ChildStdin,
}

async fn start(hub: &Hub, camera: &Camera) -> Result<Process, Ended> {
    let config = &camera.config;
    let login = config.login.as_ref().map(|login| -> Result<Login, Ended> {
        let password = login.password().map_err(|why| Ended::new(why, ""))?;
        Ok(Login { user: login.user.clone(), password: password.unwrap_or_default() })
    });
    let settings = Settings { url: config.url.clone(), login: login.transpose()? };
    let cannot = |error: io::Error| Ended::new(text::CameraNoProcess.words(), error);
    let settings = settings.written().map_err(cannot)?;
    let [program, arguments @ ..] = &hub.config().camera_program[..] else {
        return Err(Ended::new(text::CameraNoProgram.words(), ""));
    };
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    // What parses a stranger's bytes needs none of the hub's secrets. Windows cannot connect without its own.
    #[cfg(unix)]
    command.env_clear().arg0("lafet-camera");
    let mut child = command.kill_on_drop(true).spawn().map_err(cannot)?;
    let (Some(mut to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
        return Err(Ended::new(text::CameraNoProcess.words(), "without pipes"));
    };
    match timeout(HANGS, to.write_all(&settings)).await {
        Ok(Ok(())) => Ok(Process { child, from: BufReader::with_capacity(BUFFER, from), to }),
        Ok(Err(error)) => Err(cannot(error)),
        Err(_) => Err(Ended::new(text::CameraHangs.words(), "it takes no settings")),
    }
}

/// What is known of a stream.
struct Stream {
    /// When its last new picture came.
    last: Instant,
    shown_us: Option<i64>,
    /// Packets were lost since its last key frame.
    damaged: bool,
    rate: Rate,
    looked: Instant,
    /// How it is decoded has changed, and is not published yet.
    news: bool,
    published: Option<Instant>,
}

impl Process {
    /// Passes on what it says, until it has to be ended.
    async fn heed(&mut self, hub: &Hub, camera: &Camera) -> Ended {
        let now = Instant::now();
        let mut stream = Stream::new(now);
        loop {
            let said = match timeout(HANGS, Said::read(&mut self.from)).await {
                Ok(Ok(Some(said))) => said,
                Ok(Ok(None)) => return self.died().await,
                Ok(Err(error)) => return Ended::new(text::CameraDied.words(), error),
                Err(_) => return Ended::new(text::CameraHangs.words(), "nothing is said"),
            };
            let now = Instant::now();
            let bytes = if let Said::Frame(frame) = &said { frame.data.len() } else { 0 };
            if !stream.rate.allows(now, bytes) {
                return Ended::new(text::CameraFlood.words(), "");
            }
            match said {
                Said::Alive => {}
                Said::Fault(fault) => return Ended::of(fault),
                Said::Frame(frame) => stream.came(hub, camera, &frame, now),
            }
            stream.publish(hub, camera, now);
            if stream.shown_us.is_some() && waited(Some(stream.last), now, FROZEN) {
                camera.set(hub, CameraWord::Frozen, Some(text::CameraFrozen.words()));
            }
            if waited(Some(stream.looked), now, LOOK) {
                stream.looked = now;
                let taken = self.child.id().and_then(memory_of);
                if let Some(taken) = taken.filter(|it| *it > MEMORY_MAX) {
                    return Ended::new(text::CameraHeavy.words(), taken);
                }
            }
        }
    }

    /// It has ended by itself, without a word.
    async fn died(&mut self) -> Ended {
        let status = timeout(ENDS, self.child.wait()).await;
        let status = status.map(|it| it.map(|it| it.to_string()));
        let detail = status.map_or("still running".to_owned(), |it| it.unwrap_or_default());
        Ended::new(text::CameraDied.words(), detail)
    }

    async fn end(mut self) {
        _ = self.child.start_kill();
        _ = timeout(ENDS, self.child.wait()).await;
    }
}

impl Stream {
    fn new(now: Instant) -> Self {
        Self {
            last: now,
            shown_us: None,
            damaged: false,
            rate: Rate::new(now),
            looked: now,
            news: false,
            published: None,
        }
    }

    /// Publishes how it is decoded, if that is news and not too soon.
    fn publish(&mut self, hub: &Hub, camera: &Camera, now: Instant) {
        let soon = self.published.is_some() && !waited(self.published, now, NEWS);
        if self.news && !soon {
            (self.news, self.published) = (false, Some(now));
            camera.publish(hub);
        }
    }

    fn came(&mut self, hub: &Hub, camera: &Camera, frame: &Frame, now: Instant) {
        let counts = &camera.counts;
        Counts::add(&counts.frames, 1);
        Counts::add(&counts.bytes, frame.data.len());
        counts.lost.fetch_add(u64::from(frame.lost), Ordering::Relaxed);
        self.damaged = frame.lost > 0 || (self.damaged && frame.key.is_none());
        // A camera that sends one picture again and again is frozen, however busy it is.
        if self.shown_us != Some(frame.shown_us) {
            (self.last, self.shown_us) = (now, Some(frame.shown_us));
            // One with few pictures a second is frozen between them, again and again.
            let before = camera.set(hub, CameraWord::Playing, None);
            if before.is_some_and(|it| it != CameraWord::Frozen) {
                tracing::info!(camera = camera.id(), "a camera plays");
            }
        }
        if let Some(picture) = &frame.key {
            self.news |= camera.shows(picture);
        }
        let (at_ms, damaged) = (hub.clock().now_ms(), self.damaged);
        camera.feed.push(frame.key.is_some(), |number| message::of(frame, number, at_ms, damaged));
    }
}

/// What a camera may still send at once.
struct Rate {
    left: f64,
    at: Instant,
}

impl Rate {
    fn new(now: Instant) -> Self {
        Self { left: BURST_MAX, at: now }
    }

    fn allows(&mut self, now: Instant, bytes: usize) -> bool {
        let passed = now.saturating_duration_since(self.at).as_secs_f64();
        self.at = now;
        let taken = (bytes as f64).max(MESSAGE_LEAST);
        self.left = (self.left + passed * RATE_MAX).min(BURST_MAX) - taken;
        self.left >= 0.0
    }
}

/// Memory of a process, bytes, where Linux reports it.
fn memory_of(process: u32) -> Option<u64> {
    resident(&process.to_string())
}

#[cfg(test)]
#[path = "watch_tests.rs"]
mod tests;
