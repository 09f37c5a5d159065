//! Who only listens on a port gives it to what stops: real processes on pseudo-terminals.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{park_timeout, scope, spawn};
use std::time::{Duration, Instant};

use lafet_client::blocking::Direct;
use lafet_client::transport::door::VISITS_MAX;
use lafet_client::transport::port::user_of;
use lafet_client::{Config, Endpoint};
use lafet_proto::link::{Decoder, Frame, WIRE_MAX, encode};
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Gid, Uid, geteuid};
use rustix::thread::{set_thread_groups, set_thread_res_gid, set_thread_res_uid};

use crate::support::{Run, Running, Sim, lafet, serial_line, terminal};

/// From the start of a Stop's process to its frame. Who listens does so for 3 s at least.
const SOON: Duration = Duration::from_millis(2800);
/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);
const STEP: Duration = Duration::from_millis(5);

/// A serial line with nothing on it, or with monitors that answer probes after a time.
struct Wire {
    path: String,
    state: Arc<State>,
}

#[derive(Default)]
struct State {
    frames: Mutex<Vec<Heard>>,
    answers: Mutex<Vec<Instant>>,
    cut: AtomicBool,
}

#[derive(Clone, Copy, Debug)]
struct Heard {
    at: Instant,
    stops: bool,
    probes: bool,
}

impl Wire {
    fn quiet() -> Self {
        Self::answering(None)
    }

    fn answering(after: Option<Duration>) -> Self {
        let (ours, kept, path) = serial_line();
        let state = Arc::new(State::default());
        let shared = state.clone();
        spawn(move || {
            let _kept = kept;
            shared.serve(&ours, after);
        });
        Self { path, state }
    }

    fn url(&self) -> String {
        url(&self.path)
    }

    fn frames(&self) -> Vec<Heard> {
        self.state.frames.lock().unwrap().clone()
    }

    /// Waits for a Stop; the time.
    fn stopped(&self, within: Duration) -> Option<Instant> {
        let stops = || self.frames().iter().find(|frame| frame.stops).map(|frame| frame.at);
        within_time(within, || stops().is_some());
        stops()
    }

    /// The line hangs up.
    fn cut(&self) {
        self.state.cut.store(true, Ordering::SeqCst);
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        self.cut();
    }
}

impl State {
    fn serve(self: Arc<Self>, mut ours: &File, after: Option<Duration>) {
        let (mut decoder, mut buffer) =
            (Decoder::<{ lafet_proto::link::BODY_MAX }>::new(), [0; 256]);
        let tick = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };
        while !self.cut.load(Ordering::SeqCst) {
            if poll(&mut [PollFd::new(ours, PollFlags::IN)], Some(&tick)) == Ok(0) {
                continue;
            }
            let Ok(len @ 1..) = ours.read(&mut buffer) else { return };
            for byte in &buffer[..len] {
                let Some(frame) = decoder.push(*byte) else { continue };
                let mut records = Records::new(frame.payload).flatten();
                let stops = records.any(|record| record.request == RequestId::STOP);
                let probes = frame.payload.is_empty();
                self.frames.lock().unwrap().push(Heard { at: Instant::now(), stops, probes });
                if let Some(after) = after.filter(|_| probes) {
                    let (dst, src) = (frame.src, frame.dst);
                    let (state, line) = (self.clone(), ours.try_clone().unwrap());
                    spawn(move || state.answer(line, Frame { dst, src, payload: &[] }, after));
                }
            }
        }
    }

    fn answer(&self, mut line: File, frame: Frame<'_>, after: Duration) {
        let due = Instant::now() + after;
        while Instant::now() < due {
            park_timeout(due - Instant::now());
        }
        let mut wire = [0; WIRE_MAX];
        let len = encode(&frame, &mut wire).unwrap();
        self.answers.lock().unwrap().push(Instant::now());
        line.write_all(&wire[..len]).unwrap();
    }
}

fn url(path: &str) -> String {
    format!("serial://{path}?addr=5&baud=57600&late=0")
}

fn within_time(time: Duration, mut is: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    loop {
        if is() {
            return true;
        }
        if start.elapsed() > time {
            return false;
        }
        park_timeout(STEP);
    }
}

/// Starts a command, and waits until it has the port.
fn listener(path: &str, words: &[&str]) -> Running {
    let mut command = lafet();
    command.args(["--lang", "en", "-c", &url(path)]).args(words).stdin(Stdio::null());
    let running = Running::stderr(&mut command);
    waits_for(path, &running);
    running
}

fn waits_for(path: &str, running: &Running) {
    waits_for_process(path, running.child.id());
}

fn waits_for_process(path: &str, pid: u32) {
    let has = || user_of(Path::new(path)).is_some_and(|by| by.pid == pid);
    assert!(within_time(PATIENCE, has), "it has not opened the port");
}

fn stop(path: &str) -> (Instant, Running) {
    let started = Instant::now();
    (started, Running::stderr(&mut stopping(path)))
}

/// A Stop without root's right to open any port.
fn stopping(path: &str) -> Command {
    let lafet = lafet();
    let mut command = Command::new(lafet.get_program());
    if geteuid().is_root() {
        command = Command::new("setpriv");
        command.args(["--bounding-set=-all", "--inh-caps=-all"]).arg(lafet.get_program());
    }
    for (name, value) in lafet.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command.args(["--lang", "en", "-c", &url(path), "stop"]);
    command
}

/// Reads lines of standard error until one has these words.
fn says(running: &Running, words: &str) -> String {
    loop {
        let line = running.line();
        if line.contains(words) {
            return line;
        }
    }
}

/// What the name of the door of a process begins with.
fn name(path: &str, pid: u32) -> String {
    let port = fs::metadata(path).unwrap();
    format!("lafet-port-{:x}-{:x}-{pid}", port.rdev(), port.ino())
}

/// The door of a process.
fn door(path: &str, running: &Running) -> SocketAddr {
    let start = format!("@{}-", name(path, running.child.id()));
    let sockets = fs::read_to_string("/proc/net/unix").unwrap();
    let mut names = sockets.lines().filter_map(|line| line.split(' ').next_back());
    let name = names.find(|name| name.starts_with(&start)).expect("it has a door");
    SocketAddr::from_abstract_name(&name[1..]).unwrap()
}

fn knock(path: &str, running: &Running) -> UnixStream {
    UnixStream::connect_addr(&door(path, running)).unwrap()
}

fn is_closed_within(time: Duration, stream: &mut UnixStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    within_time(time, || matches!(stream.read(&mut [0]), Ok(0)))
}

const COMMANDS: [&[&str]; 16] = [
    &["status"],
    &["watch", "--count", "1"],
    &["bus", "who"],
    &["bus", "log"],
    &["bus"],
    &["scan"],
    &["doctor"],
    &["conform"],
    &["param", "list", "general"],
    &["move", "vertical", "10deg"],
    &["open"],
    &["lockout", "off"],
    &["limits", "teach", "vertical"],
    &["tune", "vertical"],
    &["send", "GetStatus All", "Stop All"],
    &["shell"],
];

/// A Stop is on the line long before the other command would have ended, and before any frame of that.
#[test]
fn each_command_that_listens_gives_way() {
    let folder = env!("CARGO_TARGET_TMPDIR");
    let recording = format!("{folder}/door.mcap");
    let tapped = format!("{folder}/door-tap.mcap");
    let record: [&[&str]; 2] = [
        &["record", &recording, "--force", "--for", "20"],
        &["record", &tapped, "--force", "--for", "20", "--tap", "127.0.0.1:0"],
    ];
    let all: Vec<&[&str]> = COMMANDS.into_iter().chain(record).collect();
    for some in all.chunks(3) {
        scope(|scope| {
            for words in some {
                scope.spawn(move || gives_way(words));
            }
        });
    }
}

fn gives_way(words: &[&str]) {
    let wire = Wire::quiet();
    let mut running = listener(&wire.path, words);
    let (started, visitor) = stop(&wire.path);
    let at = wire.stopped(PATIENCE).expect("a Stop");
    assert!(at - started < SOON, "{words:?}: {:?}", at - started);
    assert!(wire.frames()[0].stops, "{words:?}: it has sent something");
    let who = format!("lafet ({})", visitor.child.id());
    assert!(says(&running, "send at once").contains(&who), "{words:?}");
    if !matches!(words[0], "scan" | "doctor") {
        assert_eq!(running.code(), Some(3), "{words:?}");
    }
}

/// The dashboard, which goes on.
#[test]
fn the_dashboard_gives_way() {
    let wire = Wire::quiet();
    let (mut ours, end) = terminal();
    let end = || File::options().read(true).write(true).open(&end).unwrap();
    let mut command = lafet();
    command.args(["top", &wire.url()]).env("TERM", "xterm");
    let mut top = command.stdin(end()).stdout(end()).stderr(end()).spawn().unwrap();
    spawn(move || while let Ok(1..) = ours.read(&mut [0; 4096]) {});
    waits_for_process(&wire.path, top.id());
    let (started, _visitor) = stop(&wire.path);
    let at = wire.stopped(PATIENCE).expect("a Stop");
    top.kill().unwrap();
    top.wait().unwrap();
    assert!(at - started < SOON && wire.frames()[0].stops, "{:?}", at - started);
}

/// Both are answered, and the scan finds the monitor afterwards.
#[test]
fn two_stops_at_once() {
    let sim = Sim::listening(&["pty"], &[]);
    let path = sim.port();
    let url = format!("serial://{path}?addr=1&late=0");
    let mut command = lafet();
    command.args(["--lang", "en", "-c", &url, "scan", "--addresses", "1-3"]);
    let mut scan = Running::stderr(&mut command);
    waits_for(path, &scan);
    let started = Instant::now();
    let stop = || Running::stderr(lafet().args(["-c", &url, "stop"]));
    let mut both = [stop(), stop()];
    assert_eq!(both.each_mut().map(Running::code), [Some(0); 2]);
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
    says(&scan, "starts again");
    assert_eq!(scan.code(), Some(0));
}

/// A probe that is on the line when a Stop comes is answered first: its answer is not the Stop's.
#[test]
fn no_answer_to_a_probe_comes_to_a_stop() {
    let wire = Wire::answering(Some(Duration::from_millis(20)));
    let words = ["scan", "--insist", "--wait", "130", "--addresses", "1-126"];
    let _scan = listener(&wire.path, &words);
    assert!(within_time(PATIENCE, || wire.frames().len() > 3), "it probes");
    let (started, _visitor) = stop(&wire.path);
    let at = wire.stopped(PATIENCE).expect("a Stop");
    assert!(at - started < SOON, "{:?}", at - started);
    let probes = wire.frames().iter().filter(|it| it.at < at && it.probes).count();
    let answers = wire.state.answers.lock().unwrap().iter().filter(|it| **it < at).count();
    assert_eq!(answers, probes, "an answer is on its way");
}

/// Many who knock and have no use for the port keep it from no Stop. Run by root they are strangers, who may
/// not open it, and are not let in at all (the client's `who_may_open_a_port_may_ask_for_it` needs no root).
#[test]
fn a_stranger_is_not_heard() {
    let strangers = geteuid().is_root();
    let wire = Wire::quiet();
    let mut scan = listener(&wire.path, &["scan", "--addresses", "1-3"]);
    let (path, place) = (&wire.path, door(&wire.path, &scan));
    scope(|scope| {
        let knocks = scope.spawn(|| {
            if strangers {
                // Of this thread alone.
                let (user, group) = (Uid::from_raw(65_534), Gid::from_raw(65_534));
                set_thread_groups(&[]).unwrap();
                set_thread_res_gid(group, group, group).unwrap();
                set_thread_res_uid(user, user, user).unwrap();
            }
            let mut held: Vec<_> =
                (0..20).map(|_| UnixStream::connect_addr(&place).unwrap()).collect();
            assert!(!strangers || is_closed_within(SOON, &mut held[19]), "it is let in");
            held
        });
        let _held = knocks.join().unwrap();
        let (started, mut visitor) = stop(path);
        let at = wire.stopped(PATIENCE).expect("a Stop");
        assert!(at - started < SOON && wire.frames()[0].stops, "{:?}", at - started);
        let said = says(&scan, "send at once");
        let by = if strangers { visitor.child.id() } else { std::process::id() };
        assert!(said.contains(&format!("({by})")), "{said}");
        visitor.signal("KILL");
        visitor.code();
    });
    assert_eq!(scan.code(), Some(1));
}

/// Who knocks and does not use the port keeps it for a second or two; the scan ends.
#[test]
fn a_visitor_that_does_not_use_the_port_is_not_waited_for() {
    let wire = Wire::quiet();
    let mut scan = listener(&wire.path, &["scan", "--addresses", "1-3"]);
    let _held = knock(&wire.path, &scan);
    says(&scan, "starts again");
    let given = Instant::now();
    waits_for(&wire.path, &scan);
    assert!(given.elapsed() < Duration::from_secs(4), "{:?}", given.elapsed());
    assert_eq!(scan.code(), Some(1));
    assert!(!wire.frames().is_empty(), "it has probed");
}

/// It is not started again without end.
#[test]
fn a_scan_that_is_always_disturbed_ends() {
    let wire = Wire::quiet();
    let mut scan = listener(&wire.path, &["scan"]);
    for _ in 0..VISITS_MAX {
        let visit = knock(&wire.path, &scan);
        says(&scan, "starts again");
        drop(visit);
    }
    says(&scan, &format!("{VISITS_MAX} times"));
    assert_eq!(scan.code(), Some(3));
    assert!(wire.frames().is_empty());
}

/// Sockets of the door's name, and of names like it, in another process keep no Stop from the door.
#[test]
fn names_that_are_taken() {
    let wire = Wire::quiet();
    let program = env!("CARGO_BIN_EXE_lafet");
    let mut command = Command::new("sh");
    // The name has the number of the process, which is known before it is the program.
    let script = "read _ && exec \"$0\" --lang en -c \"$1\" status";
    command.args(["-c", script, program, &wire.url()]).stdin(Stdio::piped());
    let mut status = Running::stderr(&mut command);
    let start = name(&wire.path, status.child.id());
    let take = |end: String| {
        UnixListener::bind_addr(&SocketAddr::from_abstract_name(start.clone() + &end).unwrap())
    };
    let ends = (0..100).map(|number| format!("-{number:016x}")).chain([String::new()]);
    let _taken: Vec<_> = ends.map(|end| take(end).unwrap()).collect();
    status.child.stdin.take().unwrap().write_all(b"\n").unwrap();
    waits_for(&wire.path, &status);
    let (started, _visitor) = stop(&wire.path);
    let at = wire.stopped(PATIENCE).expect("a Stop");
    assert!(at - started < SOON && wire.frames()[0].stops, "{:?}", at - started);
    assert_eq!(status.code(), Some(3));
}

/// Without a door a line is not listened to: a Stop would wait for it. A program that may open fewer and fewer
/// files has none at some point.
#[test]
fn without_a_door_nothing_is_listened_to() {
    let wire = Wire::quiet();
    let refused = |files: u32| {
        let mut command = Command::new("sh");
        let script = format!("ulimit -n {files} && exec \"$0\" --lang en -c \"$1\" status");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_lafet"), &wire.url()]);
        let began = Instant::now();
        let run = Run::of_command(&mut command);
        assert!(began.elapsed() < SOON || run.code == 3, "{files}: {run:?}");
        run.err.contains("is not listened to")
    };
    assert!((4..24).any(refused));
    assert!(wire.frames().is_empty());
}

/// A reader of standard error that takes nothing holds up no Stop.
#[test]
fn a_stop_does_not_wait_for_standard_error() {
    let wire = Wire::quiet();
    let mut scan = listener(&wire.path, &["scan"]);
    scan.signal("STOP");
    let (_reader, mut writer) = std::io::pipe().unwrap();
    // As much as a pipe holds.
    writer.write_all(&[b' '; 1 << 16]).unwrap();
    let mut stop = stopping(&wire.path).stderr(writer).spawn().unwrap();
    // It has said by then who has the port, or tried to.
    park_timeout(Duration::from_millis(1500));
    let killed = Instant::now();
    scan.signal("KILL");
    scan.code();
    let at = wire.stopped(PATIENCE);
    stop.kill().unwrap();
    stop.wait().unwrap();
    let at = at.expect("a Stop");
    assert!(at - killed < SOON, "{:?}", at - killed);
}

/// The scan starts again when the visitor is killed in its middle.
#[test]
fn a_visitor_is_killed() {
    let wire = Wire::quiet();
    let mut scan = listener(&wire.path, &["scan", "--addresses", "1-3"]);
    let (_, mut visitor) = stop(&wire.path);
    wire.stopped(PATIENCE).expect("a Stop");
    visitor.signal("KILL");
    visitor.code();
    let before = wire.frames().len();
    says(&scan, "starts again");
    assert_eq!(scan.code(), Some(1), "no device, and no error");
    assert!(wire.frames()[before..].iter().all(|frame| frame.probes));
    assert!(wire.frames().len() > before, "it has probed");
}

/// A line, who listens on it and does not react, and a Stop that says so.
fn hangs(words: &[&str]) -> (Wire, Running, Running) {
    let wire = Wire::quiet();
    let listens = listener(&wire.path, words);
    listens.signal("STOP");
    let (_, visitor) = stop(&wire.path);
    let said = says(&visitor, "in use by lafet");
    assert!(said.contains(&listens.child.id().to_string()), "{said}");
    (wire, listens, visitor)
}

/// One that does not react has the port until it is killed; then the Stop is sent.
#[test]
fn a_listener_is_killed() {
    let (wire, mut scan, _visitor) = hangs(&["scan"]);
    assert!(wire.frames().is_empty());
    let killed = Instant::now();
    scan.signal("KILL");
    scan.code();
    let at = wire.stopped(PATIENCE).expect("a Stop");
    assert!(at - killed < SOON, "{:?}", at - killed);
}

/// A visitor knocks again at who has taken the port after the one that it had knocked at.
#[test]
fn another_has_the_port_meanwhile() {
    let (wire, mut first, visitor) = hangs(&["status"]);
    visitor.signal("STOP");
    first.signal("KILL");
    first.code();
    let second = listener(&wire.path, &["status"]);
    let goes_on = Instant::now();
    visitor.signal("CONT");
    let at = wire.stopped(PATIENCE).expect("a Stop");
    assert!(at - goes_on < SOON, "{:?}", at - goes_on);
    assert!(wire.frames()[0].stops);
    says(&second, "send at once");
}

/// A port whose name leads to one line, and then to another.
struct Moved {
    path: PathBuf,
    lines: [Wire; 2],
}

impl Moved {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        let lines = [Wire::quiet(), Wire::quiet()];
        // It may be left from before.
        let _ = fs::remove_file(&path);
        std::os::unix::fs::symlink(&lines[0].path, &path).unwrap();
        Self { path, lines }
    }

    fn path(&self) -> &str {
        self.path.to_str().unwrap()
    }

    /// A command listens on the second line when the first one hangs up.
    fn moves(&self) -> Running {
        fs::remove_file(&self.path).unwrap();
        std::os::unix::fs::symlink(&self.lines[1].path, &self.path).unwrap();
        let listener = listener(self.path(), &["status"]);
        self.lines[0].cut();
        listener
    }
}

impl Drop for Moved {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// A Stop whose line is lost in its middle knocks when it opens the port again.
#[test]
fn a_stop_that_has_lost_its_line_knocks() {
    let port = Moved::new("door-moved");
    let (_, _visitor) = stop(port.path());
    port.lines[0].stopped(PATIENCE).expect("a Stop");
    let _listener = port.moves();
    let lost = Instant::now();
    let at = port.lines[1].stopped(PATIENCE).expect("a Stop again");
    assert!(at - lost < SOON, "{:?}", at - lost);
    assert!(port.lines[1].frames()[0].stops);
}

/// So does one of a client without a runtime.
#[test]
fn a_stop_without_a_runtime_knocks() {
    let port = Moved::new("door-direct");
    let endpoint: Endpoint = url(port.path()).parse().unwrap();
    let mut client = Direct::connect_with(&endpoint, Config::default()).unwrap();
    scope(|scope| {
        let stop = scope.spawn(|| {
            // Not answered.
            let _ = client.request(&Request::new(SubsystemId::ALL, Body::Stop));
        });
        port.lines[0].stopped(PATIENCE).expect("a Stop");
        let _listener = port.moves();
        let lost = Instant::now();
        let at = port.lines[1].stopped(PATIENCE).expect("a Stop again");
        assert!(at - lost < SOON, "{:?}", at - lost);
        stop.join().unwrap();
    });
}
