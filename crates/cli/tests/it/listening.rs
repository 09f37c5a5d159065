//! What every command hears on a line before it transmits, on pseudo-terminals that have a speed.

use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::thread::{park, park_timeout, scope, spawn};
use std::time::{Duration, Instant};

use crate::support::{Run, Running, curl, lafet, serial_line, terminal};
use lafet_client::overhear::GLANCE;
use lafet_client::transport::port::user_of;
use lafet_proto::link::{Frame, WIRE_MAX, encode};
use rustix::termios::tcgetattr;

/// Bytes as they arrive at a wrong speed.
const GARBLED: [u8; 5] = [0x00, 0xF8, 0x80, 0x1C, 0xE6];

/// A serial line on which a controller transmits.
struct Line {
    path: String,
    /// Bytes that were sent to it.
    sent: Arc<AtomicUsize>,
    /// The longest time between two transmissions of the controller, ms.
    gap: Arc<AtomicU64>,
}

impl Line {
    /// The controller has this speed, and transmits so often. Speed 0 is never that of the port.
    fn new(baud: u32, every: Duration) -> Self {
        Self::with(baud, Some(every), &GARBLED)
    }

    /// The same where a driver drops what comes at a wrong speed.
    fn mute(baud: u32, every: Duration) -> Self {
        Self::with(baud, Some(every), &[])
    }

    /// A line without another device.
    fn quiet() -> Self {
        Self::with(0, None, &[])
    }

    fn with(baud: u32, every: Option<Duration>, otherwise: &'static [u8]) -> Self {
        let (ours, kept, path) = serial_line();
        let (sent, gap): (Arc<AtomicUsize>, Arc<AtomicU64>) = Default::default();
        let (mut reader, counted, seen) = (ours.try_clone().unwrap(), sent.clone(), gap.clone());
        spawn(move || {
            let mut buffer = [0; 256];
            while let Ok(len @ 1..) = reader.read(&mut buffer) {
                counted.fetch_add(len, Ordering::SeqCst);
            }
        });
        spawn(move || {
            let _kept = kept;
            let (mut writer, mut last) = (ours, Instant::now());
            loop {
                let Some(every) = every else {
                    park();
                    continue;
                };
                // The settings of the other end.
                let speed = tcgetattr(&writer).map_or(0, |settings| settings.output_speed());
                let bytes = if speed == baud { probe() } else { otherwise.to_vec() };
                if writer.write_all(&bytes).is_err() {
                    return;
                }
                let now = Instant::now();
                let gap = (now - std::mem::replace(&mut last, now)).as_millis();
                seen.fetch_max(u64::try_from(gap).unwrap(), Ordering::SeqCst);
                park_timeout(every);
            }
        });
        Self { path, sent, gap }
    }

    /// Whether the controller has kept its pauses, as real ones do. On a machine that is too busy for that, a
    /// speed may be listened to between two of its frames.
    fn was_regular(&self) -> bool {
        Duration::from_millis(self.gap.load(Ordering::SeqCst)) < GLANCE / 2
    }

    fn url(&self, options: &str) -> String {
        format!("serial://{}?addr=5&{options}", self.path)
    }

    fn sent(&self) -> usize {
        self.sent.load(Ordering::SeqCst)
    }

    /// Waits until something was sent.
    fn used(&self) {
        assert!(self.is_used_within(Duration::from_secs(60)), "nothing was sent");
    }

    /// Whether something is sent within this time.
    fn is_used_within(&self, time: Duration) -> bool {
        self.grows_within(0, time)
    }

    /// Whether more than this was sent, within this time.
    fn grows_within(&self, before: usize, time: Duration) -> bool {
        let start = Instant::now();
        while self.sent() == before && start.elapsed() < time {
            park_timeout(Duration::from_millis(10));
        }
        self.sent() > before
    }
}

/// A frame of the controller, which grants access to no device.
fn probe() -> Vec<u8> {
    let mut wire = [0; WIRE_MAX];
    let len = encode(&Frame { dst: 7, src: 128, payload: &[] }, &mut wire).unwrap();
    wire[..len].to_vec()
}

const OFTEN: Duration = Duration::from_millis(20);
/// A line of which nothing is known is listened to for 3 s.
const BEFORE: Duration = Duration::from_millis(2900);

/// Every command that opens a line and listens to it, with the words after its URL.
const COMMANDS: [&[&str]; 41] = [
    &["status"],
    &["watch", "--count", "1"],
    &["bus", "who"],
    &["bus", "log"],
    &["bus"],
    &["scan"],
    &["conform"],
    &["param", "list", "general"],
    &["param", "get", "vertical", "Speed"],
    &["param", "set", "vertical", "Speed", "8"],
    &["param", "backup", "-"],
    &["param", "restore", BACKUP],
    &["param", "diff", BACKUP],
    &["move", "vertical", "10deg"],
    &["open"],
    &["deploy"],
    &["wrap"],
    &["seek", "--from-az", "-9", "--to-az", "9"],
    &["hotbeds"],
    &["justify"],
    &["quench", "--program", "3"],
    &["trajectory", "--point", "20deg,-2deg,25,50"],
    &["program", "list"],
    &["program", "show", "3"],
    &["program", "set", "3", "--centre", "30deg,-2deg", "--distance", "25"],
    &["program", "clear", "3"],
    &["program", "run", "3"],
    &["calibrate", "--outlet", "28"],
    &["tune"],
    &["limits"],
    &["limits", "on"],
    &["limits", "teach", "--here", "left"],
    &["lockout", "off"],
    &["restart"],
    &["crash"],
    &["update", "--state"],
    &["send", "GetStatus All", "Stop All"],
    &["send", "Restart General"],
    &["shell"],
    &["record", RECORDING, "--force", "--for", "20"],
    &["record", RECORDING, "--force", "--for", "20", "--tap", "127.0.0.1:0"],
];

/// Every other command, and why it is not among them.
const OTHERS: [(&[&str], &str); 8] = [
    (&["stop", "close"], "do not wait: `what_stops_waits_for_nothing`"),
    (&["top"], "goes on trying: `a_stop_at_the_dashboard_does_not_wait`"),
    (&["doctor"], "reports what it hears: crates/client/tests/it/doctor.rs"),
    (&["jog"], "needs a terminal; opens its line as `move` does"),
    (
        &["sim", "sim run", "serve", "demo", "coverage", "throw", "map modbus", "decode", "replay"],
        "open no line to a monitor",
    ),
    (&["site test", "site calendar", "site verify"], "ask a hub, and read files"),
    (
        &["image key", "image public", "image sign", "image show", "plan show", "plan import"],
        "have to do with files alone",
    ),
    (
        &["ports", "dissector", "completions", "man", "schema"],
        "print what this computer or program has",
    ),
];

/// Files of these tests.
const BACKUP: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/listening.toml");
const RECORDING: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/listening.mcap");

/// [`COMMANDS`], as a recording of its own each.
fn commands() -> Vec<Vec<String>> {
    // Its file is read before the line is opened.
    assert_eq!(Run::of(&["-c", "sim:", "param", "backup", "--force", BACKUP]).code, 0);
    let own = |(index, words): (usize, &&[&str])| {
        let name = |word: &&str| match *word {
            RECORDING => RECORDING.replace(".mcap", &format!("-{index}.mcap")),
            word => word.to_owned(),
        };
        words.iter().map(name).collect()
    };
    COMMANDS.iter().enumerate().map(own).collect()
}

#[test]
fn no_command_is_forgotten() {
    for command in crate::support::commands() {
        let words: Vec<&str> = command.split(' ').collect();
        let listens = COMMANDS.iter().any(|one| one.starts_with(&words));
        let other = OTHERS.iter().any(|(names, _)| names.contains(&command.as_str()));
        assert!(listens != other, "{command}: listens {listens}, does not {other}");
    }
}

/// At a wrong speed a frame reaches no device and disturbs others: nothing is sent, and where the
/// others can be read is named.
#[test]
fn nothing_is_sent_at_a_wrong_speed() {
    scope(|scope| {
        for (index, words) in commands().into_iter().enumerate() {
            scope.spawn(move || {
                let line = Line::new(57_600, OFTEN);
                let lang = if index % 2 == 0 { "en" } else { "ru" };
                not_at(&line, lang, &words.iter().map(String::as_str).collect::<Vec<_>>());
            });
        }
    });
}

/// The same where the bytes of others make silence at a wrong speed.
#[test]
fn nothing_is_sent_where_a_wrong_speed_makes_silence() {
    let recording = format!("{}/listening-mute.mcap", env!("CARGO_TARGET_TMPDIR"));
    let record = ["record", &recording, "--force", "--for", "20"];
    let commands: [&[&str]; 5] = [&["status"], &["bus"], &["scan"], &["conform"], &record];
    scope(|scope| {
        for words in commands {
            scope.spawn(move || not_at_mute(words));
        }
    });
}

/// How often a controller that did not keep its pauses is tried again.
const ATTEMPTS: u32 = 10;

/// The same on a line where silence is listened to for a glance at each speed.
fn not_at_mute(words: &[&str]) {
    for _ in 0..ATTEMPTS {
        let line = Line::mute(57_600, OFTEN);
        let run = at_19200(&line, "en", words);
        if line.sent() == 0 || line.was_regular() {
            return is_refused(&line, words, &run);
        }
    }
    panic!("the machine is too busy for a controller");
}

/// Runs a command at 19200 baud on a line of 57600.
fn not_at(line: &Line, lang: &str, words: &[&str]) {
    is_refused(line, words, &at_19200(line, lang, words));
}

fn at_19200(line: &Line, lang: &str, words: &[&str]) -> Run {
    Run::of(&[&["--lang", lang, "-c", &line.url("baud=19200")], words].concat())
}

fn is_refused(line: &Line, words: &[&str], run: &Run) {
    assert_eq!(line.sent(), 0, "{words:?}: {run:?}");
    let named = run.err.contains("57600");
    assert!(matches!(run.code, 1 | 3) && named, "{words:?}: {run:?}");
}

/// A controller at the speed of the URL that only probes: nothing is sent either, but what stops.
#[test]
fn a_controller_is_respected_from_the_first_byte() {
    scope(|scope| {
        let transmit = commands().into_iter().filter(|words| words[0] != "record");
        for (index, words) in transmit.enumerate() {
            scope.spawn(move || {
                let line = Line::new(57_600, Duration::from_millis(700));
                let lang = if index % 2 == 0 { "en" } else { "ru" };
                let url = line.url("baud=57600");
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                let run = Run::of(&[&["--lang", lang, "-c", &url], &words[..]].concat());
                assert_eq!(line.sent(), 0, "{words:?}: {run:?}");
                let remedy = match words[0] {
                    "scan" | "conform" => "--insist",
                    _ => "role=active",
                };
                let named = run.err.contains(remedy);
                assert!(matches!(run.code, 1 | 3) && named, "{words:?}: {run:?}");
            });
        }
        scope.spawn(|| {
            let line = Line::new(57_600, Duration::from_millis(100));
            let recording = format!("{}/listening-only.mcap", env!("CARGO_TARGET_TMPDIR"));
            let url = line.url("baud=57600");
            let run = Run::of(&["-c", &url, "record", &recording, "--force", "--for", "5"]);
            assert_eq!((run.code, line.sent()), (0, 0), "{run:?}");
            let frames = Run::of(&["--json", "replay", &recording, "--speed", "0"]).json();
            assert!(!frames.is_empty() && frames.iter().all(|frame| frame["src"] == 128));
        });
        scope.spawn(|| {
            let line = Line::new(57_600, OFTEN);
            let url = line.url("baud=57600");
            let _running = Running::stderr(lafet().args(["-c", &url, "stop"]));
            line.used();
        });
    });
}

/// What stops is sent at once, before a controller would have been heard; anything else is not.
#[test]
fn what_stops_waits_for_nothing() {
    let stops: [&[&str]; 6] = [
        &["stop"],
        &["stop", "vertical"],
        &["close"],
        &["lockout", "on"],
        &["send", "Stop All", "Close Valve1", "Lockout All on"],
        &["send", "Close Valve1", "GetStatus Valve1"],
    ];
    scope(|scope| {
        for words in stops {
            scope.spawn(move || {
                let line = Line::quiet();
                let url = line.url("baud=19200&late=0");
                let _running = Running::stderr(lafet().args(["-c", &url]).args(words));
                assert!(line.is_used_within(BEFORE), "{words:?}");
            });
        }
        let waits: [&[&str]; 3] = [
            &["status"],
            &["send", "GetStatus All", "Stop All"],
            &["send", "Stop All", "Move Vertical 600"],
        ];
        for words in waits {
            scope.spawn(move || {
                let line = Line::quiet();
                let url = line.url("baud=19200&late=0");
                let _running = Running::stderr(lafet().args(["-c", &url]).args(words));
                assert!(!line.is_used_within(BEFORE), "{words:?}");
                line.used();
            });
        }
    });
}

/// A shell that still listens sends a Stop at once, and not what is behind another command.
#[test]
fn a_shell_stops_while_it_listens() {
    let shell = |line: &Line, script: &str| {
        let url = line.url("baud=19200&late=0");
        let mut command = lafet();
        command.args(["shell", &url]).stdin(Stdio::piped());
        let mut running = Running::stderr(&mut command);
        running.child.stdin.as_mut().unwrap().write_all(script.as_bytes()).unwrap();
        running
    };
    scope(|scope| {
        for script in ["stop\n", "стоп\n", "stop this\nstatus\n"] {
            scope.spawn(move || {
                let line = Line::quiet();
                let _running = shell(&line, script);
                assert!(line.is_used_within(BEFORE), "{script}");
            });
        }
        scope.spawn(|| {
            let line = Line::quiet();
            let _running = shell(&line, "status\nstop\n");
            assert!(!line.is_used_within(BEFORE));
            line.used();
        });
        // Where it may not transmit at all, it still stops.
        scope.spawn(|| {
            let line = Line::new(0, OFTEN);
            let mut running = shell(&line, "stop\n");
            line.used();
            assert_eq!(running.code(), Some(3));
        });
        // Ctrl-C stops whatever moves.
        scope.spawn(|| {
            let line = Line::quiet();
            let running = shell(&line, "");
            park_timeout(Duration::from_millis(500));
            running.signal("INT");
            assert!(line.is_used_within(BEFORE - Duration::from_millis(500)));
        });
    });
}

/// A controller without a device to ask is heard too: a port that nothing is known of is listened to for
/// longer than it pauses.
#[test]
fn a_controller_that_seldom_speaks_is_heard() {
    scope(|scope| {
        for (baud, remedy) in [("baud=19200", "baud"), ("baud=57600", "role=active")] {
            scope.spawn(move || {
                let line = Line::new(57_600, Duration::from_millis(2500));
                for words in [&["status"], &["bus", "who"][..]] {
                    let run = Run::of(&[&["-c", &line.url(baud)], words].concat());
                    assert!(run.code == 3 && run.err.contains(remedy), "{words:?}: {run:?}");
                    assert_eq!(line.sent(), 0, "{words:?}: {run:?}");
                }
            });
        }
    });
}

/// Noise, or a speed that is not tried: nothing is sent unless the user insists, except what stops.
#[test]
fn unreadable_bytes_hold_back_what_does_not_stop() {
    scope(|scope| {
        scope.spawn(|| {
            let line = Line::new(0, OFTEN);
            let run = Run::of(&["-c", &line.url("baud=19200"), "status"]);
            assert!(run.code == 3 && run.err.contains("--insist"), "{run:?}");
            assert_eq!(line.sent(), 0);
            let run = Run::of(&["-c", &line.url("baud=19200&late=0"), "--insist", "status"]);
            assert!(run.code == 3 && line.sent() > 0, "{run:?}");
        });
        for words in [&["stop"][..], &["close"], &["lockout", "on"], &["send", "Stop All"]] {
            scope.spawn(move || {
                let line = Line::new(0, OFTEN);
                let url = line.url("baud=19200&late=0");
                let _running = Running::stderr(lafet().args(["-c", &url]).args(words));
                line.used();
            });
        }
    });
}

/// The key of the dashboard, too; at a line where nothing else may be sent, again and again.
#[test]
fn a_stop_at_the_dashboard_does_not_wait() {
    for line in [Line::quiet(), Line::new(0, OFTEN)] {
        let (ours, path) = terminal();
        let end = || File::options().read(true).write(true).open(&path).unwrap();
        let mut command = lafet();
        command.args(["--lang", "en", "top", &line.url("baud=19200&late=0")]).env("TERM", "xterm");
        let mut top = command.stdin(end()).stdout(end()).stderr(end()).spawn().unwrap();
        drop(command);
        let (mut screen, mut keys) = (ours.try_clone().unwrap(), ours);
        let (shown, waits) = channel();
        spawn(move || {
            let (mut buffer, mut seen) = ([0; 4096], String::new());
            while let Ok(count @ 1..) = screen.read(&mut buffer) {
                seen.push_str(&String::from_utf8_lossy(&buffer[..count]));
                if seen.contains("STOP ALL") {
                    // The receiver is gone after the first.
                    let _ = shown.send(());
                }
            }
        });
        waits.recv_timeout(Duration::from_secs(60)).expect("a picture");
        for _ in 0..2 {
            let before = line.sent();
            keys.write_all(b"s").unwrap();
            assert!(line.grows_within(before, Duration::from_millis(1500)));
        }
        top.kill().unwrap();
        top.wait().unwrap();
    }
}

/// The bus has a controller already: a second one would transmit in its turns.
#[test]
fn a_second_controller_does_not_start() {
    scope(|scope| {
        for (baud, lang, words) in [
            ("57600", "en", "at 57600 baud (address 128)"),
            ("19200", "ru", "57600 бод (адрес 128)"),
        ] {
            scope.spawn(move || {
                let line = Line::new(57_600, Duration::from_secs(1));
                let url = line.url(&format!("baud={baud}"));
                let run = Run::of(&["--lang", lang, "bus", &url]);
                assert_eq!((run.code, line.sent()), (3, 0), "{run:?}");
                assert!(run.err.contains(words) && run.err.contains("--force"), "{run:?}");
            });
        }
        scope.spawn(|| {
            let line = Line::new(57_600, Duration::from_secs(1));
            let url = line.url("baud=57600");
            let mut bus = Running::stdout(lafet().args(["bus", &url, "--force"]));
            line.used();
            bus.signal("TERM");
            assert_eq!(bus.code(), Some(0));
        });
        // Noise does not leave a bus without its controller.
        scope.spawn(|| {
            let line = Line::new(0, Duration::from_millis(300));
            let mut bus = Running::stderr(lafet().args(["bus", &line.url("baud=19200")]));
            line.used();
            bus.signal("TERM");
            assert_eq!(bus.code(), Some(0));
        });
    });
}

/// A hub with one monitor.
struct Hub {
    url: String,
    _running: Running,
    _folder: Folder,
}

/// A folder that is removed at the end.
struct Folder(std::path::PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Hub {
    fn start(name: &str, monitor: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-heed-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let config = folder.join("hub.toml");
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\n\
             [[monitor]]\nid = \"M1\"\nurl = \"{monitor}\"\n"
        );
        std::fs::write(&config, text).unwrap();
        let (running, url) = crate::support::hub(&config);
        Self { url, _running: running, _folder: Folder(folder) }
    }
}

fn stop_by(hub: &str) -> String {
    let json = ["-X", "POST", "-H", "Content-Type: application/json", "-d", r#"{"of":"All"}"#];
    curl(&[&json[..], &[&format!("{hub}/api/monitors/M1/stop")]].concat())
}

/// Waits for an alarm, and returns what the hub says of its alarms.
fn alarm(hub: &str, id: &str) -> String {
    let start = Instant::now();
    loop {
        let said = curl(&[&format!("{hub}/api/alarms")]);
        if said.contains(id) {
            return said;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{said}");
        park_timeout(Duration::from_millis(50));
    }
}

/// The hub polls for as long as it runs, so it must not begin where it would disturb others; what stops
/// it sends all the same.
#[test]
fn a_hub_heeds_the_others_on_its_line() {
    let disturbed = |name, line: &Line, url: &str, id: &str, word: &str| {
        let hub = Hub::start(name, url);
        let said = alarm(&hub.url, id);
        assert!(said.contains(word), "{name}: {said}");
        // Longer than it listens.
        park_timeout(Duration::from_secs(7));
        assert_eq!(line.sent(), 0, "{name}");
        stop_by(&hub.url);
        assert!(line.sent() > 0, "{name}: a Stop was not sent");
    };
    scope(|scope| {
        scope.spawn(|| {
            let line = Line::new(57_600, OFTEN);
            disturbed(
                "speed",
                &line,
                &line.url("baud=19200&late=0"),
                "M1/Link/Unreadable",
                "19200",
            );
        });
        scope.spawn(|| {
            let line = Line::new(57_600, Duration::from_millis(2500));
            let url = line.url("baud=19200&late=0");
            disturbed("seldom", &line, &url, "M1/Link/Unreadable", "19200");
        });
        scope.spawn(|| {
            let line = Line::new(57_600, Duration::from_millis(2500));
            let url = line.url("baud=57600&late=0");
            disturbed("controller", &line, &url, "M1/Link/Controller", "role=active");
        });
        scope.spawn(|| {
            let line = Line::new(0, OFTEN);
            let _hub = Hub::start("insist", &line.url("baud=19200&late=0&insist=1"));
            line.used();
        });
    });
}

/// It has no connection yet because another program listens: a Stop asks that one for the port.
#[test]
fn a_hub_asks_for_the_port_that_its_stop_needs() {
    let line = Line::quiet();
    let url = line.url("baud=19200&late=0");
    let mut listens = Running::stderr(lafet().args(["--lang", "en", "-c", &url, "conform"]));
    let path = std::path::Path::new(&line.path);
    let has = || user_of(path).is_some_and(|by| by.pid == listens.child.id());
    let start = Instant::now();
    while !has() {
        assert!(start.elapsed() < Duration::from_secs(60), "it does not listen");
        park_timeout(Duration::from_millis(5));
    }
    let hub = Hub::start("asks", &url);
    stop_by(&hub.url);
    line.used();
    assert_eq!(listens.code(), Some(3));
    while !listens.line().contains("send at once") {}
}

/// At the right speed it works within seconds, and sends a Stop before.
#[test]
fn a_hub_on_a_healthy_line() {
    let line = Line::quiet();
    let started = Instant::now();
    let hub = Hub::start("quiet", &line.url("baud=19200&late=0"));
    scope(|scope| {
        scope.spawn(|| stop_by(&hub.url));
        assert!(line.is_used_within(BEFORE.saturating_sub(started.elapsed())), "no Stop was sent");
    });
    drop(hub);
    let sim = crate::support::Sim::listening(&["pty"], &[]);
    let hub = Hub::start("healthy", &format!("{}?addr=1", sim.url()));
    let url = &hub.url;
    let start = Instant::now();
    while !curl(&[&format!("{url}/api/monitors/M1")]).contains(r#""stale":false"#) {
        assert!(start.elapsed() < Duration::from_secs(20), "the monitor is not heard");
        park_timeout(Duration::from_millis(50));
    }
    assert!(!curl(&[&format!("{url}/api/alarms")]).contains("M1/Link"), "nothing was amiss");
}
