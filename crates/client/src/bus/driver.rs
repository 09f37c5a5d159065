//! A bus controller on real links: moves bytes between [`Controller`], [`Gateway`], the lines and
//! the connected programs, and reopens a lost line.

use std::future::{Future, pending};
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::link::WIRE_MAX;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until, timeout};

use super::{Change, Controller, ControllerConfig, Entry, Gateway, Port, Ports};
use crate::ports::Adapters;
use crate::session::Now;
use crate::session::echo::EchoFilter;
use crate::transport::Link;
use crate::url::{Echo, Endpoint};

/// Pause before a lost line is reopened.
const REDIAL: Duration = Duration::from_secs(1);
/// A peer that does not accept a frame within this time counts as lost.
const SEND_TIMEOUT: Duration = Duration::from_secs(1);
/// A TCP connection without received bytes for this long may be half open.
const HALF_OPEN: Duration = Duration::from_secs(20);
/// Most answers waiting for a program that does not read; more are dropped.
const UNREAD_MAX: usize = 64;
/// Most messages of programs waiting for the controller.
const INBOX: usize = 64;

/// Configuration of a driver: controller and connections.
#[derive(Debug)]
pub struct DriverConfig {
    /// Configuration of the controller; its `ports` are set according to `consoles`.
    pub controller: ControllerConfig,
    /// The line of the monitors, and of the consoles unless they have a separate one.
    pub monitors: Endpoint,
    /// A separate line of the consoles.
    pub consoles: Option<Endpoint>,
    /// Listener for connections of programs.
    pub programs: Option<TcpListener>,
}

/// Event of a bus.
#[derive(Clone, Debug)]
pub enum Event {
    /// A line is open.
    Up(Port),
    /// A line was lost or cannot be opened; it is tried again each second.
    Down(Port, Arc<io::Error>),
    /// A device has appeared or was dropped.
    Change(Change),
    /// A control request was sent on the bus.
    Asked(Entry),
    /// A program has connected: its origin, and the address assigned to it.
    Program(String, u8),
    /// The program with this address has disconnected.
    ProgramGone(u8),
}

/// A controller with its lines and programs.
#[derive(Debug)]
pub struct Driver {
    controller: Controller,
    gateway: Gateway,
    lines: Vec<Wire>,
    programs: Option<TcpListener>,
    /// Channels to the programs, with the address assigned to each.
    connected: Vec<(u8, mpsc::Sender<Vec<u8>>)>,
    said: mpsc::Sender<Said>,
    heard: mpsc::Receiver<Said>,
    noted: u64,
    start: Instant,
}

/// Bytes of a program; none: it has disconnected.
#[derive(Debug)]
struct Said {
    program: u8,
    bytes: Vec<u8>,
}

type Dialing = Pin<Box<dyn Future<Output = io::Result<Link>> + Send>>;
/// Opens a line.
type Open = Arc<dyn Fn(Endpoint) -> Dialing + Send + Sync>;

/// One of the lines.
struct Wire {
    port: Port,
    endpoint: Endpoint,
    open: Open,
    link: Option<Link>,
    dialing: Option<Dialing>,
    echo: EchoFilter,
    heard: Now,
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Wire").field("endpoint", &self.endpoint).field("link", &self.link).finish()
    }
}

enum Happened {
    Read(usize, io::Result<usize>),
    Dialed(usize, io::Result<Link>),
    Came(io::Result<TcpStream>),
    Said(Said),
    Time,
}

impl Driver {
    /// A controller whose lines are not open yet.
    pub fn new(config: DriverConfig) -> Self {
        let adapters = Arc::new(Adapters::default());
        Self::opening(config, move |endpoint| {
            let adapters = adapters.clone();
            // Each Stop of its consoles goes through it.
            async move { Link::open_same(&endpoint, &adapters, true).await }
        })
    }

    /// A controller on links of the caller's: a test, a tunnel. `open` is called again for a lost
    /// line.
    pub fn opening<F>(
        config: DriverConfig,
        open: impl Fn(Endpoint) -> F + Send + Sync + 'static,
    ) -> Self
    where
        F: Future<Output = io::Result<Link>> + Send + 'static,
    {
        let open: Open = Arc::new(move |endpoint| Box::pin(open(endpoint)));
        let DriverConfig { mut controller, monitors, consoles, programs } = config;
        controller.ports = if consoles.is_some() { Ports::Two } else { Ports::One };
        let pauses = std::iter::once(&monitors).chain(&consoles).map(turnaround);
        controller.turnaround = pauses.fold(controller.turnaround, Duration::max);
        let mut lines = vec![Wire::new(Port::Monitors, monitors, open.clone())];
        lines.extend(consoles.map(|endpoint| Wire::new(Port::Consoles, endpoint, open)));
        let (said, heard) = mpsc::channel(INBOX);
        Self {
            controller: Controller::new(controller),
            gateway: Gateway::default(),
            lines,
            programs,
            connected: Vec::new(),
            said,
            heard,
            noted: 0,
            start: Instant::now(),
        }
    }

    /// The controller, for present devices and counters.
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The gateway, for requests of programs that were dropped.
    pub const fn gateway(&self) -> &Gateway {
        &self.gateway
    }

    /// Runs until the future is dropped; calls `tell` for each event.
    pub async fn run(&mut self, mut tell: impl FnMut(Event)) {
        let mut buffers = [[0; 2 * WIRE_MAX], [0; 2 * WIRE_MAX]];
        loop {
            self.transmit(&mut tell).await;
            self.report(&mut tell);
            self.lines.iter_mut().for_each(Wire::dial);
            let accepts_from = self.gateway.accepts_from(self.start.elapsed());
            let due = self.poll_timeout().into_iter().chain(accepts_from).min();
            let [first, second] = &mut buffers;
            let (monitors, consoles) = self.lines.split_at_mut(1);
            let happened = tokio::select! {
                event = monitors[0].event(0, first) => event,
                event = other(consoles, second) => event,
                stream = accepted(&mut self.programs), if accepts_from.is_none() => Happened::Came(stream),
                Some(said) = self.heard.recv() => Happened::Said(said),
                () = until(due.map(|due| self.start + due)) => Happened::Time,
            };
            let now = self.start.elapsed();
            match happened {
                Happened::Read(line, Ok(len)) => self.received(now, line, &buffers[line][..len]),
                Happened::Read(line, Err(error)) => self.lost(line, error, &mut tell),
                Happened::Dialed(line, Ok(link)) => {
                    let line = &mut self.lines[line];
                    line.link = Some(link);
                    line.heard = now;
                    line.echo.reset();
                    tell(Event::Up(line.port));
                }
                Happened::Dialed(line, Err(error)) => {
                    tell(Event::Down(self.lines[line].port, Arc::new(error)));
                }
                Happened::Came(Ok(stream)) => self.came(stream, &mut tell),
                // No file descriptor is left: wait before the next attempt.
                Happened::Came(Err(_)) => sleep(Duration::from_millis(100)).await,
                Happened::Said(said) => self.said(now, &said, &mut tell),
                Happened::Time => self.half_open(now, &mut tell),
            }
        }
    }

    /// The line of the monitors is open. Without that of the consoles, programs still reach them.
    fn is_up(&self) -> bool {
        self.lines.first().is_some_and(|line| line.link.is_some())
    }

    fn poll_timeout(&self) -> Option<Now> {
        if !self.is_up() {
            return None;
        }
        let now = self.start.elapsed();
        let own = self.controller.own_from(now).filter(|_| self.gateway.waits());
        let due = self.controller.poll_timeout(now).into_iter().chain(own).min();
        let silent = self.lines.iter().filter_map(Wire::half_open_at);
        due.into_iter().chain(silent).min()
    }

    async fn transmit(&mut self, tell: &mut impl FnMut(Event)) {
        while self.is_up() {
            let now = self.start.elapsed();
            self.controller.set_urgent(self.gateway.is_urgent());
            let gateway = &mut self.gateway;
            let transmit = self.controller.poll_transmit(now, || gateway.poll_transmit(now));
            let Some(transmit) = transmit else { return };
            let index = if transmit.port == Port::Consoles { self.lines.len() - 1 } else { 0 };
            let line = &mut self.lines[index];
            // What is for consoles whose line is lost gets no answer, like one that is switched off.
            let Some(link) = &mut line.link else { continue };
            line.echo.sent(&transmit.bytes);
            let sent = timeout(SEND_TIMEOUT, link.send(&transmit.bytes)).await;
            if let Err(error) = sent.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())) {
                self.lost(index, error, tell);
            }
        }
    }

    fn received(&mut self, now: Now, index: usize, bytes: &[u8]) {
        let line = &mut self.lines[index];
        line.heard = now;
        let bytes = line.echo.received(bytes);
        self.controller.handle_bytes(now, line.port, &bytes);
        if line.port == Port::Monitors {
            for (program, answer) in self.gateway.handle_line(&bytes) {
                self.answer(program, answer);
            }
        }
    }

    fn answer(&self, program: u8, bytes: Vec<u8>) {
        let to = self.connected.iter().find(|(address, _)| *address == program);
        if let Some((_, to)) = to {
            // A program that does not read loses answers, and delays no other.
            _ = to.try_send(bytes);
        }
    }

    fn came(&mut self, stream: TcpStream, tell: &mut impl FnMut(Event)) {
        let now = self.start.elapsed();
        let program = self.gateway.connect(now).or_else(|| {
            if let Some(quiet) = self.gateway.quietest(now) {
                self.let_go(quiet);
                return self.gateway.connect(now);
            }
            // What stops must not wait until one of them is quiet.
            self.gateway.connect_guest(now).or_else(|| {
                let quiet = self.gateway.quietest_guest(now)?;
                self.let_go(quiet);
                self.gateway.connect_guest(now)
            })
        });
        let Some(program) = program else { return };
        let from = stream.peer_addr().map_or_else(|_| String::new(), |place| place.to_string());
        let (answers, waiting) = mpsc::channel(UNREAD_MAX);
        self.connected.push((program, answers));
        tokio::spawn(serve(stream, program, self.said.clone(), waiting));
        tell(Event::Program(from, program));
    }

    fn said(&mut self, now: Now, said: &Said, tell: &mut impl FnMut(Event)) {
        if said.bytes.is_empty() {
            // Another connection may have the address by now.
            let is_there =
                |(address, to): &(u8, mpsc::Sender<_>)| *address == said.program && !to.is_closed();
            if !self.connected.iter().any(is_there) {
                self.let_go(said.program);
            }
            tell(Event::ProgramGone(said.program));
            return;
        }
        let answers = self.gateway.handle_program(now, said.program, &said.bytes, &self.controller);
        if !answers.is_empty() {
            self.answer(said.program, answers);
        }
        if self.gateway.is_refused(said.program) {
            self.let_go(said.program);
        }
    }

    /// Its connection is closed if it is still open.
    fn let_go(&mut self, program: u8) {
        self.connected.retain(|(address, _)| *address != program);
        self.gateway.disconnect(program);
    }

    fn lost(&mut self, index: usize, error: io::Error, tell: &mut impl FnMut(Event)) {
        let line = &mut self.lines[index];
        line.link = None;
        self.controller.line_lost();
        tell(Event::Down(line.port, Arc::new(error)));
    }

    fn half_open(&mut self, now: Now, tell: &mut impl FnMut(Event)) {
        for index in 0..self.lines.len() {
            if self.lines[index].half_open_at().is_some_and(|at| now >= at) {
                self.lost(index, io::ErrorKind::TimedOut.into(), tell);
            }
        }
        self.controller.handle_timeout(now);
    }

    fn report(&mut self, tell: &mut impl FnMut(Event)) {
        while let Some(change) = self.controller.poll_change() {
            tell(Event::Change(change));
        }
        let journal = self.controller.journal();
        let dropped = journal.dropped();
        let told = self.noted.saturating_sub(dropped);
        for entry in journal.lines().skip(told as usize) {
            tell(Event::Asked(entry.clone()));
        }
        self.noted = dropped + journal.lines().count() as u64;
    }
}

impl Wire {
    fn new(port: Port, endpoint: Endpoint, open: Open) -> Self {
        let echo = match &endpoint {
            Endpoint::Serial { line, .. } => line.echo,
            _ => Echo::Off,
        };
        let (echo, heard) = (EchoFilter::new(echo), Now::ZERO);
        // The first attempt is immediate.
        let dialing = Some(open(endpoint.clone()));
        Self { port, endpoint, open, link: None, dialing, echo, heard }
    }

    fn dial(&mut self) {
        if self.link.is_none() && self.dialing.is_none() {
            let opening = (self.open)(self.endpoint.clone());
            self.dialing = Some(Box::pin(async move {
                sleep(REDIAL).await;
                opening.await
            }));
        }
    }

    fn half_open_at(&self) -> Option<Now> {
        self.link.as_ref().filter(|link| link.can_be_half_open()).map(|_| self.heard + HALF_OPEN)
    }

    async fn event(&mut self, index: usize, buffer: &mut [u8]) -> Happened {
        if let Some(dialing) = &mut self.dialing {
            let link = dialing.await;
            self.dialing = None;
            return Happened::Dialed(index, link);
        }
        match &mut self.link {
            Some(link) => Happened::Read(index, link.recv(buffer).await),
            None => pending().await,
        }
    }
}

/// Pause of a line between the last received byte and a frame.
fn turnaround(line: &Endpoint) -> Duration {
    match line {
        Endpoint::Serial { line, .. } => line.turnaround,
        _ => Duration::ZERO,
    }
}

async fn other(lines: &mut [Wire], buffer: &mut [u8]) -> Happened {
    match lines {
        [line, ..] => line.event(1, buffer).await,
        [] => pending().await,
    }
}

async fn accepted(listener: &mut Option<TcpListener>) -> io::Result<TcpStream> {
    match listener {
        Some(listener) => listener.accept().await.map(|(stream, _)| stream),
        None => pending().await,
    }
}

async fn until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => pending().await,
    }
}

/// Moves bytes between a program and the controller until the program disconnects.
async fn serve(
    mut stream: TcpStream,
    program: u8,
    said: mpsc::Sender<Said>,
    mut answers: mpsc::Receiver<Vec<u8>>,
) {
    // Answers are small, and a client waits for each.
    _ = stream.set_nodelay(true);
    let mut buffer = [0; WIRE_MAX];
    loop {
        tokio::select! {
            read = stream.read(&mut buffer) => match read {
                Ok(0) | Err(_) => break,
                Ok(len) => {
                    let bytes = buffer[..len].to_vec();
                    if said.send(Said { program, bytes }).await.is_err() {
                        return;
                    }
                }
            },
            answer = answers.recv() => {
                let Some(answer) = answer else { break };
                let sent = timeout(SEND_TIMEOUT, stream.write_all(&answer)).await;
                if !matches!(sent, Ok(Ok(()))) {
                    break;
                }
            }
        }
    }
    drop(answers);
    // An error means that the controller has ended.
    _ = said.send(Said { program, bytes: Vec::new() }).await;
}
