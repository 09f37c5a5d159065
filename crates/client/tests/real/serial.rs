//! Serial ports: pseudo-terminals with echo, noise, lost bytes and several monitors.

use std::fs::File;
use std::io::{Read, Write};
use std::time::Duration;

use crate::fake::{answer, encode};
use lafet_client::{Client, Config, Endpoint, Error, Lang, Monitor, PortError, Toward, blocking};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;

/// What the line does to bytes.
#[derive(Clone, Copy, Default)]
struct Line {
    /// What is sent comes back.
    echo: bool,
    /// Each so many echoes are garbled, as when two speak at once.
    garbled_every: usize,
    /// Each so many answers lose a byte in the middle.
    lossy_every: usize,
    /// Bytes of noise before each answer.
    noise: bool,
}

/// Opens a pseudo-terminal and serves the monitors 1 to 3 on it; returns its path.
fn start(behaves: Line) -> String {
    let line = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    // A program that is started has no end of the line.
    fcntl_setfd(&line, FdFlags::CLOEXEC).unwrap();
    grantpt(&line).unwrap();
    unlockpt(&line).unwrap();
    let path = ptsname(&line, Vec::new()).unwrap().into_string().unwrap();
    // Kept open, so that the line does not hang up before the client comes.
    let ours = rustix::fs::open(path.as_str(), rustix::fs::OFlags::RDWR, rustix::fs::Mode::empty());
    let ours = ours.unwrap();
    std::thread::spawn(move || {
        let _ours = ours;
        serve(File::from(line), behaves);
    });
    path
}

fn serve(mut line: File, behaves: Line) {
    let mut decoder: Decoder = Decoder::new();
    let (mut byte, mut echo, mut count) = ([0], Vec::new(), 0);
    while let Ok(1) = line.read(&mut byte) {
        echo.push(byte[0]);
        let Some(asked) = decoder.push(byte[0]) else { continue };
        count += 1;
        let every = |n: usize| n > 0 && count % n == 0;
        let mut reply = encode(asked.src, asked.dst, &answer(asked.payload));
        let present = (1..=3).contains(&asked.dst);
        if every(behaves.garbled_every) {
            let middle = echo.len() / 2;
            echo[middle] ^= 0x11;
        }
        if behaves.echo {
            line.write_all(&echo).unwrap();
        }
        echo.clear();
        if behaves.noise {
            line.write_all(&[0x00, 0xC0, 0x55, 0xDB, 0xF0]).unwrap();
        }
        if every(behaves.lossy_every) {
            reply.remove(reply.len() / 2);
        }
        if present {
            line.write_all(&reply).unwrap();
        }
    }
}

async fn monitor(path: &str, options: &str) -> Monitor {
    let endpoint: Endpoint = format!("serial://{path}?addr=1&{options}").parse().unwrap();
    let config = Config { timeout: Duration::from_millis(150), ..Config::default() };
    Monitor::new(Client::connect_with(&endpoint, config).await.unwrap())
}

#[tokio::test]
async fn a_quiet_line() {
    let monitor = monitor(&start(Line::default()), "baud=57600").await;
    assert_eq!(monitor.status_all().await.unwrap().vertical.unwrap().position, 300);
    monitor.vertical().move_to(1200).await.unwrap();
    assert_eq!(monitor.client().stats().strays(), 0);
}

/// The client without a runtime opens and uses a port like the others.
#[test]
fn without_a_thread() {
    let path = start(Line { echo: true, noise: true, ..Line::default() });
    let endpoint: Endpoint = format!("serial://{path}?addr=2&echo=strip").parse().unwrap();
    let config = Config { timeout: Duration::from_secs(5), ..Config::default() };
    let mut client = blocking::Direct::connect_with(&endpoint, config.clone()).unwrap();
    let reading = Request::new(VERTICAL, Body::GetStatus);
    for _ in 0..5 {
        assert_eq!(client.request(&reading).unwrap().first().from(), VERTICAL);
        // After a pause, what has come meanwhile is looked at first.
        std::thread::park_timeout(Duration::from_millis(15));
    }
    client.request(&Request::new(VERTICAL, Body::Move { destination: 1200 })).unwrap();
    let stats = client.stats();
    assert_eq!((stats.strays(), stats.reconnects), (0, 0), "{stats:?}");
    let second = blocking::Direct::connect_with(&endpoint, config).unwrap_err();
    let Error::Link { source, .. } = second else { panic!("{second}") };
    let in_use = source.get_ref().and_then(|error| error.downcast_ref());
    assert!(matches!(in_use, Some(PortError::InUse { .. })), "{source}");
}

/// What is named as a port and is none is not opened: bytes would go into a file.
#[test]
fn a_file_is_not_a_port() {
    for path in ["/dev/null", "/dev"] {
        let endpoint: Endpoint = format!("serial://{path}?addr=2").parse().unwrap();
        let refused = blocking::Direct::connect_with(&endpoint, Config::default()).unwrap_err();
        let Error::Link { source, .. } = refused else { panic!("{refused}") };
        let why = source.get_ref().and_then(|error| error.downcast_ref());
        assert!(matches!(why, Some(PortError::NotSerial { .. })), "{path}: {source}");
    }
}

/// A monitor that is off is reported, over a port that stays open.
#[test]
fn without_a_thread_and_without_a_monitor() {
    let endpoint: Endpoint =
        format!("serial://{}?addr=9&late=0", start(Line::default())).parse().unwrap();
    let config = Config { timeout: Duration::from_millis(30), ..Config::default() };
    let mut client = blocking::Direct::connect_with(&endpoint, config).unwrap();
    for _ in 0..2 {
        let error = client.request(&Request::new(VERTICAL, Body::GetStatus)).unwrap_err();
        assert!(matches!(error, Error::NoAnswer { tries: 3, .. }), "{error}");
    }
    assert_eq!(client.stats().reconnects, 0);
}

#[tokio::test]
async fn several_monitors_on_one_port() {
    let first = monitor(&start(Line::default()), "baud=115200").await;
    let (second, third) = (first.at(2).unwrap(), first.at(3).unwrap());
    for _ in 0..10 {
        let (a, b, c) = tokio::join!(first.status_all(), second.status_all(), third.status_all());
        assert!(a.is_ok() && b.is_ok() && c.is_ok());
    }
    let nobody = first.at(4).unwrap();
    let asking = nobody.client().probe();
    let (answered, silent) = tokio::join!(second.limits(VERTICAL), asking);
    assert!(answered.is_ok() && matches!(silent, Err(Error::Absent { .. })));
    assert_eq!(second.client().stats().believed, 11);
    assert_eq!(first.client().link_stats().believed, 31);
    assert!(first.at(129).is_err() && first.at(0).is_err());
}

/// `echo=`: what comes back is taken away, compared, or at least never believed.
#[tokio::test]
async fn echo_is_never_taken_for_an_answer() {
    for (options, echoes) in [("echo=strip", true), ("echo=verify", true), ("echo=off", true)] {
        let line = Line { echo: echoes, ..Line::default() };
        let monitor = monitor(&start(line), options).await;
        for _ in 0..20 {
            assert_eq!(monitor.vertical().status().await.unwrap().position, 300);
            monitor.client().probe().await.unwrap();
        }
        let stats = monitor.client().stats();
        assert_eq!((stats.believed, stats.timeouts, stats.collisions), (40, 0, 0), "{options}");
        let foreign = if options == "echo=off" { 40 } else { 0 };
        assert_eq!((stats.foreign, stats.echoes_missing), (foreign, 0), "{options}: {stats:?}");
    }
}

#[tokio::test]
async fn a_garbled_echo_is_a_collision_and_a_missing_one_is_told() {
    let line = Line { echo: true, garbled_every: 4, ..Line::default() };
    let monitor = monitor(&start(line), "echo=verify").await;
    for _ in 0..20 {
        monitor.vertical().status().await.unwrap();
    }
    let stats = monitor.client().stats();
    assert_eq!((stats.collisions, stats.echoes_missing), (5, 0), "{stats:?}");
    let monitor = self::monitor(&start(Line::default()), "echo=verify").await;
    for _ in 0..5 {
        monitor.vertical().status().await.unwrap();
    }
    let stats = monitor.client().stats();
    assert_eq!((stats.collisions, stats.echoes_missing), (0, 5), "{stats:?}");
}

#[tokio::test]
async fn noise_and_lost_bytes_are_survived() {
    let line = Line { echo: true, lossy_every: 5, noise: true, ..Line::default() };
    let monitor = monitor(&start(line), "echo=verify&turnaround=3").await;
    for _ in 0..25 {
        assert_eq!(monitor.vertical().status().await.unwrap().position, 300);
    }
    let stats = monitor.client().stats();
    assert!(stats.errors() >= 10 && stats.retries >= 5, "{stats:?}");
}

/// A pseudo-terminal has no RTS: asked to switch it, the port says so instead of staying silent.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_port_that_cannot_switch_direction_says_so() {
    let path = start(Line::default());
    let endpoint: Endpoint = format!("serial://{path}?rs485=rts&rts_before=1").parse().unwrap();
    let error = Client::connect(&endpoint).await.unwrap_err();
    let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
    assert!(matches!(error, Error::Link { .. }), "{english}");
    assert!(
        english.contains("Leave out rs485=") && russian.contains("Уберите rs485="),
        "{english} {russian}"
    );
}

/// A port that this or another program has open is not opened once more, unless both share it.
#[tokio::test]
async fn a_port_is_for_one_program() {
    let path = start(Line::default());
    let open = |options: &'static str| {
        let endpoint: Endpoint = format!("serial://{path}?{options}").parse().unwrap();
        async move { Client::connect(&endpoint).await }
    };
    let closed = |client: Client| async move {
        let mut state = client.link_state();
        drop(client);
        // The task that has the port ends with the last handle.
        while state.changed().await.is_ok() {}
    };
    let first = open("baud=57600").await.unwrap();
    for options in ["baud=57600", "shared=1"] {
        let error = open(options).await.unwrap_err();
        let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
        assert!(english.contains(&path) && english.contains("is in use by"), "{english}");
        assert!(english.contains("shared=1") && russian.contains("shared=1"), "{russian}");
        assert!(!english.contains("monitor is on"), "{english}");
    }
    closed(first).await;
    let shared = open("shared=1").await.unwrap();
    let second = open("shared=1").await.unwrap();
    assert!(open("baud=57600").await.is_err(), "who shares did not agree to that");
    closed(shared).await;
    closed(second).await;
    let first = open("baud=57600").await.unwrap();
    assert!(first.probe().await.is_ok());
    let missing = "serial:///dev/nope".parse().unwrap();
    let error = Client::connect(&missing).await.unwrap_err();
    assert!(error.to_string().contains("lafet ports"), "{error}");
}

/// The same without async: a thread of its own carries the connection.
#[test]
fn blocking() {
    let path = start(Line { echo: true, ..Line::default() });
    let endpoint: Endpoint = format!("serial://{path}?echo=verify").parse().unwrap();
    let monitor = blocking::Monitor::connect(&endpoint).unwrap();
    assert_eq!(monitor.status_all().unwrap().vertical.unwrap().position, 300);
    monitor.stop(SubsystemId::ALL).unwrap();
    assert_eq!(monitor.at(2).unwrap().limits(VERTICAL).unwrap().max, 5400);
    assert_eq!(monitor.param(VERTICAL, "Speed").unwrap(), [12]);
    let mut watch = monitor.watch(Duration::from_millis(20)).unwrap();
    watch.wait();
    assert!(watch.latest().is_some_and(|latest| latest.status.vertical.is_some()));
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    assert!(jog.renew());
    // This monitor always says that it moves; the Stop is what counts here.
    drop(jog);
    assert!(monitor.client().probe().is_ok());
}
