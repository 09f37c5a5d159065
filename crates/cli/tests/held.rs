//! A motion held through the hub's WebSocket ends by itself when the hub is killed or stopped, or
//! its cable is cut: with real processes and the monitor's default parameters.
#![cfg(unix)]

mod support;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use lafet_client::blocking::Monitor;
use lafet_proto::flags::{ControlFlags, DriveFlags};
use serde_json::{Value, json};
use support::{Running, Sim};

/// Distance of the traverse at 20 °/s in 500 ms of the simulator's time, arc-minutes, counted from where
/// the simulator has it when the blow has fallen: how long a busy machine takes for the blow is not in it.
/// Without MoveHold the monitor's own watch on the line ends a motion after 930.
const WAY_MAX: i32 = 600;
/// Interval of the heartbeats that hold the motion.
const BEAT: Duration = Duration::from_millis(50);

/// A cable that can be cut: both ends stay open, nothing passes.
struct Cable {
    place: String,
    cut: Arc<AtomicBool>,
}

impl Cable {
    fn to(target: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let (cut, target) = (Arc::new(AtomicBool::new(false)), target.to_owned());
        let is_cut = cut.clone();
        std::thread::spawn(move || {
            while let Ok((near, _)) = listener.accept() {
                let Ok(far) = TcpStream::connect(&target) else { return };
                for (from, to) in
                    [(near.try_clone().unwrap(), far.try_clone().unwrap()), (far, near)]
                {
                    let cut = is_cut.clone();
                    std::thread::spawn(move || copy(from, to, &cut));
                }
            }
        });
        Self { place, cut }
    }
}

fn copy(mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
    let mut buffer = [0; 1024];
    while let Ok(len @ 1..) = from.read(&mut buffer) {
        if !cut.load(Ordering::SeqCst) && to.write_all(&buffer[..len]).is_err() {
            return;
        }
    }
}

/// Sends a text message as a client, masked with zeros.
fn send(socket: &mut TcpStream, message: &Value) {
    let text = message.to_string();
    let mut frame = vec![0x81, 0x80 | u8::try_from(text.len()).expect("short"), 0, 0, 0, 0];
    frame.extend(text.as_bytes());
    // The hub may have been killed.
    let _ = socket.write_all(&frame);
}

/// Opens a WebSocket to the hub, and discards its messages.
fn connect(url: &str) -> TcpStream {
    let host = url.split_once("://").expect("a URL").1.trim_end_matches('/');
    let mut socket = TcpStream::connect(host).unwrap();
    let request = format!(
        "GET /api/ws HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    socket.write_all(request.as_bytes()).unwrap();
    let mut answer = [0; 12];
    socket.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 101");
    let mut rest = socket.try_clone().unwrap();
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        while let Ok(1..) = rest.read(&mut buffer) {}
    });
    socket
}

struct Site {
    sim: Sim,
    cable: Cable,
    hub: Running,
    folder: PathBuf,
    socket: TcpStream,
}

impl Site {
    fn open(name: &str) -> Self {
        // Without a Deployer it is in working position from the start.
        let sim = Sim::start(&["--profile", "remote"]);
        let cable = Cable::to(sim.place());
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let config = folder.join("hub.toml");
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"tcp://{}?addr=1\"\n",
            cable.place
        );
        std::fs::write(&config, text).unwrap();
        let (hub, url) = support::hub(&config);
        let mut socket = connect(&url);
        send(&mut socket, &json!({"type":"authority","id":1,"monitor":"M1","action":"take"}));
        Self { sim, cable, hub, folder, socket }
    }

    /// Holds the traverse to the left until it moves.
    fn hold(&mut self, monitor: &Monitor) {
        for beat in 0..1200 {
            send(
                &mut self.socket,
                &json!({"type":"jog","monitor":"M1","drive":"Horizontal","toward":"max"}),
            );
            let status = monitor.horizontal().status().expect("the simulator answers");
            if status.speed >= 15 {
                return;
            }
            assert!(beat < 1199, "it never moved");
            pause(BEAT);
        }
    }

    /// Starts a program that stays at a place, and waits until it is there.
    fn program(&mut self, monitor: &Monitor) {
        let request = "StartQuench Control centre=0,300 nozzle=60 sector=0,0 step=0 distance=0";
        send(&mut self.socket, &json!({"type":"request","id":2,"monitor":"M1","request":request}));
        for _ in 0..1200 {
            let vertical = monitor.vertical().status().expect("the simulator answers");
            if quenches(monitor) && vertical.position == 300 && vertical.speed == 0 {
                return;
            }
            pause(BEAT);
        }
        panic!("the program does not run");
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Waits in real time: real processes have no other clock.
#[expect(clippy::disallowed_methods, reason = "heartbeats sent to a real process")]
fn pause(time: Duration) {
    std::thread::sleep(time);
}

/// Waits until it is at rest and stays so; returns the distance.
fn rest(monitor: &Monitor, from: i32) -> i32 {
    let (mut still, mut at) = (0, from);
    for _ in 0..600 {
        let status = monitor.horizontal().status().expect("the simulator answers");
        let position = i32::from(status.position);
        let moves = status.flags.contains(DriveFlags::MOVE) || position != at;
        still = if moves { 0 } else { still + 1 };
        at = position;
        // One second without motion.
        if still > 20 {
            return at - from;
        }
        pause(BEAT);
    }
    panic!("it goes on: {}' so far", at - from)
}

fn quenches(monitor: &Monitor) -> bool {
    let status = monitor.status_all().expect("the simulator answers");
    status.control.is_some_and(|it| it.flags.contains(ControlFlags::QUENCH))
}

fn ends(name: &str, strike: impl FnOnce(&Site)) -> (Site, Monitor, i32) {
    ends_after(name, |_, _| (), strike)
}

fn ends_after(
    name: &str,
    before: impl FnOnce(&mut Site, &Monitor),
    strike: impl FnOnce(&Site),
) -> (Site, Monitor, i32) {
    let mut site = Site::open(name);
    let monitor = Monitor::connect(&site.sim.url().parse().unwrap()).unwrap();
    before(&mut site, &monitor);
    site.hold(&monitor);
    strike(&site);
    let status = monitor.horizontal().status().expect("the simulator answers");
    assert!(status.speed >= 15, "{name}: it moves when the blow has fallen: {status:?}");
    let from = i32::from(status.position);
    let way = rest(&monitor, from);
    println!("{name}: {way}' after its end");
    assert!(way < WAY_MAX, "{name}: {way}'");
    (site, monitor, from + way)
}

#[test]
fn the_hub_is_killed() {
    ends("held-kill", |site| site.hub.signal("KILL"));
}

/// What the hand has started ends, and what the program was started for goes on, where the hand has left it.
#[test]
fn the_hub_is_killed_while_a_program_is_corrected() {
    let strike = |site: &Site| site.hub.signal("KILL");
    let (_site, monitor, at) = ends_after("held-program", Site::program, strike);
    assert!(quenches(&monitor), "the program has not ended");
    // Three seconds after the last Move it takes over again.
    pause(Duration::from_secs(4));
    assert_eq!(rest(&monitor, at), 0, "it stays where the hand has left it");
    assert!(quenches(&monitor), "the program goes on");
}

#[test]
fn the_hub_is_stopped_and_goes_on() {
    let (site, monitor, at) = ends("held-stop", |site| site.hub.signal("STOP"));
    site.hub.signal("CONT");
    pause(Duration::from_secs(1));
    assert_eq!(rest(&monitor, at), 0, "it stays at rest");
}

#[test]
fn the_cable_is_cut() {
    ends("held-cut", |site| site.cable.cut.store(true, Ordering::SeqCst));
}
