//! §L/8 A presence probe never starts an exchange that does not end: every pair of addresses, with
//! monitors, consoles and the controller of ours on one line, and several monitors at once.

use std::collections::VecDeque;
use std::time::Duration;

use lafet_client::bus::{Controller, ControllerConfig, Gateway, Port};
use lafet_client::session::line::Line as Client;
use lafet_client::{Addresses, Config, Role};
use lafet_device::Source;
use lafet_device::port::Port as MonitorPort;
use lafet_proto::bus::{CONSOLES, CONTROLLER, MONITORS};
use lafet_sim::sim::{self, Sim};

use super::medium::{encoded, frames};

/// More than any exchange may take: what goes on so long does not end.
const ENDLESS: usize = 3000;
/// A frame on the line, and the turn to the next.
const FRAME: Duration = Duration::from_millis(6);
const STOP: [u8; 4] = [0x46, 0x5D, 0, 0];

enum Device {
    Monitor { sim: Box<Sim>, port: Box<MonitorPort>, echo: bool, deaf: u32 },
    Console(Box<Client>),
    Controller(Box<Controller>),
}

impl Device {
    fn console(source: u8) -> Self {
        Self::client(source, Role::Active)
    }

    fn client(source: u8, role: Role) -> Self {
        let addresses = Addresses { monitor: 1, source };
        let first_number = Some(source.into());
        let config = Config { addresses, role, first_number, ..Config::default() };
        let mut client = Client::new(config);
        client.handle_connected(Duration::ZERO);
        Self::Console(Box::new(client))
    }

    fn controller() -> Self {
        Self::controller_of(Vec::new())
    }

    /// A controller that asks these addresses by itself.
    fn controller_of(addresses: Vec<u8>) -> Self {
        let config = ControllerConfig { addresses, ..ControllerConfig::default() };
        Self::Controller(Box::new(Controller::new(config)))
    }

    fn monitor(sim: Box<Sim>) -> Self {
        let port = Box::new(MonitorPort::new(Source::ExternalConn));
        Self::Monitor { sim, port, echo: false, deaf: 0 }
    }

    fn hears(&mut self, now: Duration, own: bool, bytes: &[u8]) -> Vec<Vec<u8>> {
        match self {
            Self::Monitor { echo: false, .. } if own => Vec::new(),
            Self::Monitor { deaf: deaf @ 1.., .. } => {
                *deaf -= 1;
                Vec::new()
            }
            Self::Monitor { sim, port, .. } => {
                let answer = sim.receive(port, bytes);
                if answer.is_empty() { Vec::new() } else { vec![answer] }
            }
            _ if own => Vec::new(),
            Self::Console(client) => {
                client.handle_bytes(now, bytes);
                std::iter::from_fn(|| client.poll_transmit(now)).collect()
            }
            Self::Controller(controller) => {
                controller.handle_bytes(now, Port::Monitors, bytes);
                let mut all = Vec::new();
                while let Some(transmit) = controller.poll_transmit(now, || None) {
                    all.push(transmit.bytes);
                }
                all
            }
        }
    }
}

impl Device {
    /// When it does something by itself.
    fn due(&self, now: Duration) -> Option<Duration> {
        match self {
            Self::Monitor { .. } => None,
            Self::Console(client) => client.poll_timeout(now),
            Self::Controller(controller) => controller.poll_timeout(now),
        }
    }

    /// What it does by itself.
    fn wakes(&mut self, now: Duration) -> Vec<Vec<u8>> {
        match self {
            Self::Monitor { .. } => Vec::new(),
            Self::Console(client) => {
                client.handle_timeout(now);
                std::iter::from_fn(|| client.poll_transmit(now)).collect()
            }
            Self::Controller(controller) => {
                controller.handle_timeout(now);
                let transmit = || controller.poll_transmit(now, || None).map(|it| it.bytes);
                std::iter::from_fn(transmit).collect()
            }
        }
    }
}

/// One line: all devices hear each frame.
#[derive(Default)]
struct Line {
    devices: Vec<Device>,
    now: Duration,
}

/// What came of some frames.
#[derive(Debug, PartialEq, Eq)]
struct Came {
    /// Frames to the device that asked, from the one it asked.
    answers: usize,
    /// Frames in all.
    frames: usize,
}

impl Line {
    /// A sender that is no device here sends this, several times before any device answers.
    fn ask(&mut self, dst: u8, src: u8, payload: &[u8], times: usize) -> Came {
        let mut line: VecDeque<(usize, Vec<u8>)> =
            (0..times).map(|_| (usize::MAX, encoded(dst, src, payload))).collect();
        let mut came = Came { answers: 0, frames: 0 };
        while let Some((from, bytes)) = line.pop_front() {
            self.now += FRAME;
            came.frames += 1;
            let (to, by, _) = frames(&bytes).remove(0);
            came.answers += usize::from((to, by) == (src, dst) && from != usize::MAX);
            if came.frames == ENDLESS {
                break;
            }
            for (number, device) in self.devices.iter_mut().enumerate() {
                let said = device.hears(self.now, number == from, &bytes);
                line.extend(said.into_iter().map(|bytes| (number, bytes)));
            }
        }
        came
    }
}

impl Line {
    /// Runs for a time, after these frames; returns all frames on the line as destination, source and
    /// whether they are empty.
    fn run(&mut self, time: Duration, first: Vec<Vec<u8>>) -> Vec<(u8, u8, bool)> {
        let mut line: VecDeque<(usize, Vec<u8>)> =
            first.into_iter().map(|bytes| (usize::MAX, bytes)).collect();
        let (mut all, until) = (Vec::new(), self.now + time);
        while self.now < until {
            if let Some((from, bytes)) = line.pop_front() {
                self.now += FRAME;
                let (to, by, payload) = frames(&bytes).remove(0);
                all.push((to, by, payload.is_empty()));
                for (number, device) in self.devices.iter_mut().enumerate() {
                    let said = device.hears(self.now, number == from, &bytes);
                    line.extend(said.into_iter().map(|bytes| (number, bytes)));
                }
                continue;
            }
            let due = self.devices.iter().filter_map(|device| device.due(self.now)).min();
            self.now = due.unwrap_or(until).max(self.now + Duration::from_millis(1));
            for (number, device) in self.devices.iter_mut().enumerate() {
                let said = device.wakes(self.now);
                line.extend(said.into_iter().map(|bytes| (number, bytes)));
            }
        }
        all
    }
}

fn a_sim(address: u8) -> Box<Sim> {
    Box::new(Sim::new(sim::Config { address, ..Default::default() }))
}

#[test]
fn every_pair_of_addresses() {
    let mut sims: Vec<Option<Box<Sim>>> = (0..=127).map(|it| Some(a_sim(it.max(1)))).collect();
    for asked in 1..=254_u8 {
        for asking in 1..=254_u8 {
            let mut line = Line::default();
            let mut both = vec![asked, asking];
            both.dedup();
            for address in &both {
                line.devices.push(match *address {
                    CONTROLLER => Device::controller(),
                    a if CONSOLES.contains(&a) => Device::console(a),
                    a => Device::monitor(sims[usize::from(a)].take().unwrap()),
                });
            }
            let is_monitor = MONITORS.contains(&asked) && asked != asking;
            let answered = is_monitor || (asking == CONTROLLER && CONSOLES.contains(&asked));
            for _ in 0..2 {
                let came = line.ask(asked, asking, &[], 1);
                let expected = usize::from(answered);
                let expected = Came { answers: expected, frames: 1 + expected };
                assert_eq!(came, expected, "{asking} probes {asked}");
            }
            for (address, device) in both.into_iter().zip(line.devices) {
                if let Device::Monitor { sim, .. } = device {
                    sims[usize::from(address)] = Some(sim);
                }
            }
        }
    }
}

fn full_line() -> Line {
    let monitors = MONITORS.map(|address| Device::monitor(a_sim(address)));
    let others = [Device::controller(), Device::console(129), Device::console(254)];
    Line { devices: monitors.chain(others).collect(), now: Duration::ZERO }
}

/// The public controller probes from address 1, which is a monitor's: three tries, whose answers may
/// all come late.
#[test]
fn as_the_public_controller_does_it() {
    let mut line = full_line();
    for asking in [1, 2, 127, 128, 129, 254] {
        for asked in MONITORS.filter(|asked| *asked != asking) {
            let came = line.ask(asked, asking, &[], 3);
            assert_eq!(came, Came { answers: 3, frames: 6 }, "{asking} probes {asked}");
            // And its requests: the answer to Stop is a Stop to the monitor in whose name it was asked.
            let came = line.ask(asked, asking, &STOP, 1);
            assert_eq!(came, Came { answers: 1, frames: 2 }, "{asking} stops {asked}");
        }
    }
}

/// Transceivers that hear themselves.
#[test]
fn monitors_that_hear_themselves() {
    let mut line = full_line();
    for device in &mut line.devices {
        if let Device::Monitor { echo, .. } = device {
            *echo = true;
        }
    }
    // A console's first request shows each monitor that it hears itself.
    for asking in [129, 1, 2, 127, 128, 254] {
        for asked in MONITORS.filter(|asked| *asked != asking) {
            let came = line.ask(asked, asking, &[], 1);
            assert_eq!(came, Came { answers: 1, frames: 2 }, "{asking} probes {asked}");
        }
    }
}

/// A monitor has not heard who asked in its name, so it answers the answer; it ends all the same, and
/// consoles and the controller are answered meanwhile.
#[test]
fn what_noise_has_started_ends() {
    let mut line = full_line();
    let Device::Monitor { deaf, .. } = &mut line.devices[0] else { panic!() };
    *deaf = 1;
    let came = line.ask(2, 1, &[], 1);
    assert!(came.frames > 100 && came.frames < 2 * 256 + 3, "{came:?}");
    for asking in [128, 129, 254] {
        for asked in [1, 2] {
            assert_eq!(line.ask(asked, asking, &[], 1), Came { answers: 1, frames: 2 });
        }
    }
}

/// A second controller, as after `lafet bus --force`, and clients that are no consoles, one of them with
/// the controller's address.
#[test]
fn two_controllers_and_clients_beside_them() {
    let mut line = full_line();
    let direct = |source| Device::client(source, Role::Direct);
    line.devices.extend([Device::controller(), direct(200), direct(CONTROLLER)]);
    let all = [1, 2, 127, CONTROLLER, 129, 200, 254];
    for asking in all {
        for asked in all.into_iter().filter(|asked| *asked != asking) {
            for payload in [&[][..], &STOP] {
                let came = line.ask(asked, asking, payload, 3);
                assert!(came.frames <= 6, "{asking} asks {asked}: {came:?}");
            }
        }
    }
}

/// A controller that probes by itself and grants access, and clients whose times run: a probe in a
/// monitor's name is answered once, and between two monitors nothing else is ever said.
#[test]
fn while_the_controller_asks_and_time_passes() {
    let monitors = [1, 2, 3, 127];
    let addresses = monitors.into_iter().chain([129, 254]).collect();
    let mut devices: Vec<Device> = monitors.map(|it| Device::monitor(a_sim(it))).into();
    devices.extend([Device::controller_of(addresses), Device::console(129), Device::console(254)]);
    let mut line = Line { devices, now: Duration::ZERO };
    let second = Duration::from_secs(1);
    let before = line.run(5 * second, Vec::new());
    let own = before.iter().filter(|(_, by, _)| *by == CONTROLLER).count();
    assert!(own > 20, "the controller asks: {own} frames");
    for asking in monitors {
        for asked in monitors.into_iter().filter(|asked| *asked != asking) {
            let heard = line.run(2 * second, vec![encoded(asked, asking, &[])]);
            let between =
                |(to, by, _): &&(u8, u8, bool)| MONITORS.contains(to) && MONITORS.contains(by);
            let between: Vec<_> = heard.iter().filter(between).collect();
            assert_eq!(between, [&(asked, asking, true), &(asking, asked, true)]);
            assert!(heard.iter().any(|(_, by, _)| *by == CONTROLLER), "it goes on");
        }
    }
}

/// A program that answers the controller's probes, at a controller that answers a program's.
#[test]
fn a_console_at_the_gateway() {
    let controller = Controller::new(ControllerConfig::default());
    let (mut gateway, mut console) = (Gateway::default(), Device::console(129));
    let program = gateway.connect(Duration::ZERO).unwrap();
    let mut said = encoded(CONTROLLER, 129, &[]);
    let mut now = Duration::ZERO;
    for count in 0..ENDLESS {
        now += Duration::from_millis(1);
        let answer = gateway.handle_program(now, program, &said, &controller);
        if answer.is_empty() {
            assert!(count > 0, "a first probe is answered");
            return;
        }
        match console.hears(now, false, &answer).pop() {
            Some(bytes) => said = bytes,
            None => return,
        }
    }
    panic!("it does not end");
}
