//! Simulated monitors, each on a port of its own, that tell when they are asked and when they stop.

use std::net::SocketAddr;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_device::port::Port;
use lafet_proto::{RequestId, SubsystemId};
use lafet_sim::sim::{Config, Sim};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{MissedTickBehavior, interval};

/// `Nice` of the hub's unit.
pub const NICE: &str = "-10";
/// The drive that is moved: Horizontal, as outputs are numbered.
const DRIVE: usize = 1;

/// A monitor, and what is known of it outside.
pub struct Monitor {
    sim: Sim,
    last_poll: Option<Instant>,
    /// Times between two polls of its state, ms.
    pub polls: Vec<f64>,
    /// Since when the drive has been commanded to stand.
    pub still_since: Option<Instant>,
}

/// All monitors.
#[derive(Clone)]
pub struct Site {
    monitors: Arc<Vec<Mutex<Monitor>>>,
    places: Arc<Vec<SocketAddr>>,
}

impl Site {
    /// Starts monitors on a thread of their own, before those that flood the hub: they are on no machine of the site.
    pub fn start(count: usize) -> Self {
        let (ready, site) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            first_thread();
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            runtime.expect("a runtime").block_on(async move {
                let mut listeners = Vec::new();
                for _ in 0..count {
                    listeners.push(TcpListener::bind("127.0.0.1:0").await.expect("a free port"));
                }
                let places = listeners.iter().map(|it| it.local_addr().expect("its address"));
                let monitors = (0..count).map(|_| Mutex::new(Monitor::new()));
                let site = Self {
                    places: Arc::new(places.collect()),
                    monitors: Arc::new(monitors.collect()),
                };
                ready.send(site.clone()).expect("a waiter");
                for (number, listener) in listeners.into_iter().enumerate() {
                    tokio::spawn(site.clone().listen(number, listener));
                }
                site.tick().await;
            });
        });
        site.recv().expect("the monitors start")
    }

    /// A monitor.
    pub fn monitor(&self, number: usize) -> MutexGuard<'_, Monitor> {
        self.monitors[number].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The configuration of a hub with these monitors.
    pub fn config(&self, poll_ms: u64) -> String {
        let mut text = String::from(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\nconnections_max = 4000\n\
             [recording]\nalarms = false\n",
        );
        for (number, place) in self.places.iter().enumerate() {
            let id = number + 1;
            text += &format!(
                "[[monitor]]\nid = \"M{id}\"\nurl = \"tcp://{place}?addr=1\"\npoll_ms = {poll_ms}\n"
            );
        }
        text
    }

    /// Times between polls of all monitors since the last call, ms.
    pub fn take_polls(&self) -> Vec<f64> {
        let all = 0..self.monitors.len();
        all.flat_map(|number| std::mem::take(&mut self.monitor(number).polls)).collect()
    }

    async fn tick(&self) {
        let mut ticks = interval(Duration::from_millis(10));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Burst);
        loop {
            ticks.tick().await;
            (0..self.monitors.len()).for_each(|number| self.monitor(number).step());
        }
    }

    async fn listen(self, number: usize, listener: TcpListener) {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(self.clone().serve(number, stream));
        }
    }

    async fn serve(self, number: usize, mut stream: TcpStream) {
        _ = stream.set_nodelay(true);
        let (mut port, mut buffer) = (Port::new(Source::ExternalConn), [0; 2048]);
        while let Ok(len @ 1..) = stream.read(&mut buffer).await {
            let answers = self.monitor(number).receive(&mut port, &buffer[..len]);
            if stream.write_all(&answers).await.is_err() {
                return;
            }
        }
    }
}

/// Gives the thread that calls this the priority of the hub, if that is permitted (Linux).
fn first_thread() {
    // `PID/task/ID`
    let thread = std::fs::read_link("/proc/thread-self").unwrap_or_default();
    let Some(id) = thread.file_name() else { return };
    let mut command = Command::new("renice");
    command.args(["-n", NICE, "-p"]).arg(id).stdout(Stdio::null()).stderr(Stdio::null());
    _ = command.status();
}

impl Monitor {
    fn new() -> Self {
        let mut sim = Sim::new(Config { composition: Composition::REMOTE, ..Config::default() });
        sim.advance_ms(200);
        Self { sim, last_poll: None, polls: Vec::new(), still_since: Some(Instant::now()) }
    }

    fn step(&mut self) {
        self.sim.tick();
        match self.sim.world().outputs().drives[DRIVE].speed_tenths {
            0 => _ = self.still_since.get_or_insert_with(Instant::now),
            _ => self.still_since = None,
        }
    }

    fn receive(&mut self, port: &mut Port, bytes: &[u8]) -> Vec<u8> {
        let poll = [RequestId::GET_STATUS.0, SubsystemId::ALL.0, 0, 0];
        if bytes.windows(poll.len()).any(|it| it == poll) {
            let now = Instant::now();
            if let Some(last) = self.last_poll.replace(now) {
                self.polls.push((now - last).as_secs_f64() * 1000.0);
            }
        }
        self.sim.receive(port, bytes)
    }
}
