//! A simulated RS-485 line with a controller, monitors and consoles on it, on virtual time.

use std::time::Duration;

use lafet_client::bus::{Controller, ControllerConfig, Port};
use lafet_client::session::line::Line as Client;
use lafet_client::session::{Outcome, Terms};
use lafet_client::{Addresses, Config, RequestBuf, Role};
use lafet_device::Source;
use lafet_device::port::Port as MonitorPort;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::{Request, SubsystemId, request::Body};
use lafet_sim::line::{Line, Noise, Station};
use lafet_sim::sim::{self, Sim};

/// A transceiver turns round, and a program gets its turn: figures ours.
pub const TURNAROUND: Duration = Duration::from_micros(150);
const STEP_NS: u64 = 10_000_000;

/// A monitor on the line.
pub struct Monitor {
    pub sim: Sim,
    port: MonitorPort,
    heard: Vec<u8>,
    stepped_ns: u64,
    pub silent: bool,
}

/// A console on the line: a client that speaks when it is granted.
pub struct Console {
    pub client: Client,
    pub outcomes: Vec<Outcome>,
    pub silent: bool,
}

/// Everything on one line: station 0 is the controller, then monitors, then consoles.
pub struct Bus {
    pub line: Line,
    pub controller: Controller,
    /// The client of the controller's own.
    pub own: Client,
    pub own_outcomes: Vec<Outcome>,
    pub monitors: Vec<Monitor>,
    pub consoles: Vec<Console>,
}

pub fn request(body: Body<'_>, to: SubsystemId) -> RequestBuf {
    RequestBuf::new(&Request::new(to, body)).expect("it fits")
}

pub fn status_of_all() -> RequestBuf {
    request(Body::GetStatus, SubsystemId::ALL)
}

fn client(source: u8, role: Role) -> Client {
    let addresses = Addresses { monitor: 1, source };
    // One try, so that what the controller repeats can be counted.
    let tries = if role == Role::Active { 1 } else { 3 };
    let turnaround = if role == Role::Active { TURNAROUND } else { Duration::ZERO };
    let first_number = Some(source.into());
    let config = Config { addresses, tries, role, turnaround, first_number, ..Config::default() };
    let mut client = Client::new(config);
    client.handle_connected(Duration::ZERO);
    client
}

impl Bus {
    pub fn new(baud: u32, monitors: u8, consoles: u8, noise: Noise) -> Self {
        let stations = 1 + usize::from(monitors) + usize::from(consoles);
        let addresses = (1..=monitors).chain(129..129 + consoles).collect();
        let config =
            ControllerConfig { baud, addresses, turnaround: TURNAROUND, ..Default::default() };
        let monitor = |address| Monitor {
            sim: Sim::new(sim::Config { address, seed: address.into(), ..Default::default() }),
            port: MonitorPort::new(Source::ExternalConn),
            heard: Vec::new(),
            stepped_ns: 0,
            silent: false,
        };
        let console = |address| Console {
            client: client(address, Role::Active),
            outcomes: Vec::new(),
            silent: false,
        };
        Self {
            line: Line::new(baud, stations, noise, 7),
            controller: Controller::new(config),
            own: client(CONTROLLER, Role::Direct),
            own_outcomes: Vec::new(),
            monitors: (1..=monitors).map(monitor).collect(),
            consoles: (129..129 + consoles).map(console).collect(),
        }
    }

    pub fn now(&self) -> Duration {
        Duration::from_nanos(self.line.now_ns())
    }

    /// A console asks a monitor.
    pub fn ask(&mut self, console: usize, monitor: u8, request: RequestBuf) {
        let now = self.now();
        let client = &mut self.consoles[console].client;
        client.submit(now, monitor, Terms::default(), vec![request]).expect("there is room");
    }

    /// The controller's own client asks a monitor.
    pub fn ask_own(&mut self, monitor: u8, request: RequestBuf) {
        let now = self.now();
        self.own.submit(now, monitor, Terms::default(), vec![request]).expect("there is room");
    }

    pub fn run(&mut self, time: Duration, mut each: impl FnMut(&mut Self)) {
        let until = self.line.now_ns() + time.as_nanos() as u64;
        while self.line.now_ns() < until {
            self.transmit();
            self.advance(until);
            each(self);
        }
    }

    /// The controller sends when it is its turn, and a console when it has access.
    fn transmit(&mut self) {
        let now = self.now();
        let own = &mut self.own;
        if !self.line.sends(0)
            && let Some(transmit) = self.controller.poll_transmit(now, || own.poll_transmit(now))
        {
            self.line.send(0, self.line.now_ns(), &transmit.bytes);
        }
        while let Some((_, outcome)) = self.own.poll_outcome() {
            self.own_outcomes.push(outcome);
        }
        for (number, console) in self.consoles.iter_mut().enumerate() {
            let station = 1 + self.monitors.len() + number;
            if let Some(bytes) = console.client.poll_transmit(now)
                && !console.silent
            {
                self.line.send(station, self.line.now_ns(), &bytes);
            }
            while let Some((_, outcome)) = console.client.poll_outcome() {
                console.outcomes.push(outcome);
            }
        }
    }

    /// Goes to the next byte, or to the next time that is waited for.
    fn advance(&mut self, until_ns: u64) {
        let mut heard: Vec<(Station, u8)> = Vec::new();
        if self.line.step(|station, byte| heard.push((station, byte.byte))) {
            for (station, byte) in heard {
                self.hear(station, byte);
            }
            return;
        }
        let now = self.now();
        let timers = [self.controller.poll_timeout(now), self.own.poll_timeout(now)];
        let consoles = self.consoles.iter().map(|console| console.client.poll_timeout(now));
        let next =
            timers.into_iter().chain(consoles).flatten().map(|time| time.as_nanos() as u64).min();
        let next = next.unwrap_or(until_ns).max(self.line.now_ns() + 10_000).min(until_ns);
        self.line.wait_until(next);
        let now = self.now();
        self.controller.handle_timeout(now);
        self.own.handle_timeout(now);
        for console in &mut self.consoles {
            console.client.handle_timeout(now);
            while let Some((_, outcome)) = console.client.poll_outcome() {
                console.outcomes.push(outcome);
            }
        }
    }

    fn hear(&mut self, station: Station, byte: u8) {
        let now = self.now();
        match station {
            0 => {
                self.controller.handle_bytes(now, Port::Monitors, &[byte]);
                self.own.handle_bytes(now, &[byte]);
            }
            station if station <= self.monitors.len() => self.monitor_hears(station, byte),
            station => self.console_hears(station, byte),
        }
    }

    fn monitor_hears(&mut self, station: Station, byte: u8) {
        let now_ns = self.line.now_ns();
        let monitor = &mut self.monitors[station - 1];
        while now_ns - monitor.stepped_ns >= STEP_NS {
            monitor.sim.tick();
            monitor.stepped_ns += STEP_NS;
        }
        monitor.heard.push(byte);
        let heard = std::mem::take(&mut monitor.heard);
        let answer = monitor.sim.receive(&mut monitor.port, &heard);
        if !answer.is_empty() && !monitor.silent {
            self.line.send(station, now_ns + TURNAROUND.as_nanos() as u64, &answer);
        }
    }

    fn console_hears(&mut self, station: Station, byte: u8) {
        let now = self.now();
        let console = &mut self.consoles[station - 1 - self.monitors.len()];
        console.client.handle_bytes(now, &[byte]);
    }
}
