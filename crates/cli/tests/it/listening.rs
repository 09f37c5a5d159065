//! What every command hears on a line before it transmits, on pseudo-terminals that have a speed.

use std::fs::File;
use std::io::{Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{park_timeout, scope, spawn};
use std::time::Duration;

use crate::support::{Run, Running, lafet};
use lafet_proto::link::{Frame, WIRE_MAX, encode};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Bytes as they arrive at a wrong speed.
const GARBLED: [u8; 5] = [0x00, 0xF8, 0x80, 0x1C, 0xE6];

/// A serial line on which a controller transmits.
struct Line {
    path: String,
    /// Bytes that were sent to it.
    sent: Arc<AtomicUsize>,
}

impl Line {
    /// The controller has this speed, and transmits so often. Speed 0 is never that of the port.
    fn new(baud: u32, every: Duration) -> Self {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&ours).unwrap();
        unlockpt(&ours).unwrap();
        let path = ptsname(&ours, Vec::new()).unwrap().into_string().unwrap();
        // Kept open, so that the line does not hang up between two openings.
        let kept = File::options().read(true).write(true).open(&path).unwrap();
        let mut settings = tcgetattr(&kept).unwrap();
        settings.make_raw();
        tcsetattr(&kept, OptionalActions::Now, &settings).unwrap();
        let sent: Arc<AtomicUsize> = Arc::default();
        let (mut reader, counted) = (File::from(ours.try_clone().unwrap()), sent.clone());
        spawn(move || {
            let mut buffer = [0; 256];
            while let Ok(len @ 1..) = reader.read(&mut buffer) {
                counted.fetch_add(len, Ordering::SeqCst);
            }
        });
        spawn(move || {
            let _kept = kept;
            let mut writer = File::from(ours);
            loop {
                // The settings of the other end.
                let speed = tcgetattr(&writer).map_or(0, |settings| settings.output_speed());
                let bytes = if speed == baud { probe() } else { GARBLED.to_vec() };
                if writer.write_all(&bytes).is_err() {
                    return;
                }
                park_timeout(every);
            }
        });
        Self { path, sent }
    }

    fn url(&self, options: &str) -> String {
        format!("serial://{}?addr=5&{options}", self.path)
    }

    fn sent(&self) -> usize {
        self.sent.load(Ordering::SeqCst)
    }

    /// Waits until something was sent.
    fn used(&self) {
        for _ in 0..6000 {
            if self.sent() > 0 {
                return;
            }
            park_timeout(Duration::from_millis(10));
        }
        panic!("nothing was sent");
    }
}

/// A frame of the controller, which grants access to no device.
fn probe() -> Vec<u8> {
    let mut wire = [0; WIRE_MAX];
    let len = encode(&Frame { dst: 7, src: 128, payload: &[] }, &mut wire).unwrap();
    wire[..len].to_vec()
}

const OFTEN: Duration = Duration::from_millis(20);

/// Every command that opens a line, with the words after its URL.
const COMMANDS: [&[&str]; 12] = [
    &["status"],
    &["watch", "--for", "1"],
    &["bus", "who"],
    &["bus", "log"],
    &["bus"],
    &["scan"],
    &["conform"],
    &["param", "list", "general"],
    &["move", "vertical", "10deg"],
    &["lockout", "off"],
    &["send", "GetStatus All", "Stop All"],
    &["shell"],
];

/// At a wrong speed a frame reaches no device and disturbs others: nothing is sent, and where the
/// others can be read is named.
#[test]
fn nothing_is_sent_at_a_wrong_speed() {
    let folder = env!("CARGO_TARGET_TMPDIR");
    let recording = format!("{folder}/listening.mcap");
    let tapped = format!("{folder}/listening-tap.mcap");
    let record: [&[&str]; 2] = [
        &["record", &recording, "--force", "--for", "20"],
        &["record", &tapped, "--force", "--for", "20", "--tap", "127.0.0.1:0"],
    ];
    scope(|scope| {
        for (index, words) in COMMANDS.into_iter().chain(record).enumerate() {
            scope.spawn(move || {
                let line = Line::new(57_600, OFTEN);
                let lang = if index % 2 == 0 { "en" } else { "ru" };
                let url = line.url("baud=19200");
                let run = Run::of(&[&["--lang", lang, "-c", &url], words].concat());
                assert_eq!(line.sent(), 0, "{words:?}: {run:?}");
                // A scan leaves the other speeds to the doctor.
                let named = run.err.contains("57600") || words[0] == "scan";
                assert!(matches!(run.code, 1 | 3) && named, "{words:?}: {run:?}");
            });
        }
    });
}

/// A controller without a device to ask is heard too: a port that nothing is known of is listened to for
/// longer than it pauses.
#[test]
fn a_controller_that_seldom_speaks_is_heard() {
    let line = Line::new(57_600, Duration::from_millis(2500));
    for words in [&["status"], &["bus", "who"][..]] {
        let run = Run::of(&[&["-c", &line.url("baud=19200")], words].concat());
        assert!(run.code == 3 && run.err.contains("baud"), "{words:?}: {run:?}");
        assert_eq!(line.sent(), 0, "{words:?}: {run:?}");
    }
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
