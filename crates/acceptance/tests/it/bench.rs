//! An installation in one process: a hub with its file, simulated monitors, a panel, detectors.
//!
//! [`Site`] describes it. A wrong installation is a good one with one field, or one line of the file, changed.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lafet_acceptance::order::Posting;
use lafet_acceptance::{Failed, Outcome, Plan, Run, Stage, Stopped, Wire};
use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_device::port::Port;
use lafet_hub::access::Role;
use lafet_hub::{Clock, Config, Hub, Overrides, Server};
use lafet_proto::Ints;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_sim::fault::Fault;
use lafet_sim::sim::{Config as SimConfig, Sim};
use lafet_texts::Words;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::time::{Instant, interval, sleep, timeout};

use crate::panel::Panel;
use crate::person::Beside;

/// A simulated monitor passes so many times the time of the hub.
const FASTER: usize = 3;
/// Flame detectors of the site.
pub const FLAMES: [&str; 2] = ["flame-west", "flame-east"];
/// What is on the panel.
pub const HEAT: u16 = 2;
pub const ABORT: u16 = 20;
pub const STATION: u16 = 21;
/// Longer than a contact of the good site takes to come to rest.
const RESTS: Duration = Duration::from_millis(300);

/// The plan of the good site: it never changes.
pub const PLAN: &str = include_str!("plan.toml");
/// The file of its hub.
pub const HUB: &str = include_str!("hub.toml");

/// How an installation is built.
#[derive(Clone)]
pub struct Site {
    pub plan: String,
    pub file: String,
    /// Address on the line of each monitor, by its place.
    pub addresses: [u8; 2],
    /// Where the zero of each really looks, degrees.
    pub headings: [f64; 2],
    /// Parameters that are set besides the good ones.
    pub params: Vec<(usize, Param, Vec<i32>)>,
    pub faults: Vec<(usize, &'static str)>,
    /// This monitor answers nothing.
    pub silent: Option<usize>,
    /// A flame detector that reports nothing.
    pub mute: [bool; 2],
    /// Condition that flame detectors report.
    pub condition: [&'static str; 2],
    /// Contacts that are stuck on.
    pub stuck: Vec<u16>,
    /// What is wired or built wrong in the field; nothing of it shows at rest.
    pub field: Field,
    /// Date of the tester minus that of the hub, ms.
    pub date_off_ms: i64,
    /// Requests that are made before the test: path, body.
    pub before: Vec<(&'static str, Value)>,
    /// Answers of the hub that are other ones: path, pointer, value.
    pub answers: Vec<(&'static str, &'static str, Value)>,
    pub login: bool,
}

impl Site {
    pub fn good() -> Self {
        Self {
            plan: PLAN.into(),
            file: HUB.into(),
            addresses: [1, 2],
            headings: [0.0, 0.0],
            params: Vec::new(),
            faults: Vec::new(),
            silent: None,
            mute: [false; 2],
            condition: ["ready"; 2],
            stuck: Vec::new(),
            field: Field::Right,
            date_off_ms: 0,
            before: Vec::new(),
            answers: Vec::new(),
            login: true,
        }
    }

    /// With a part of the file of the hub changed.
    pub fn file(mut self, from: &str, to: &str) -> Self {
        assert!(self.file.contains(from), "{from} is not in the file");
        self.file = self.file.replacen(from, to, 1);
        self
    }

    /// The same of file and plan.
    pub fn both(mut self, from: &str, to: &str) -> Self {
        assert!(self.plan.contains(from), "{from} is not in the plan");
        self.plan = self.plan.replacen(from, to, 1);
        self.file(from, to)
    }

    pub fn planned(&self) -> Plan {
        let plan: Plan = toml::from_str(&self.plan).unwrap();
        assert_eq!(plan.check(), Vec::<Words>::new());
        plan
    }
}

/// The field of an installation: as it should be, or with one thing wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Right,
    /// Each flame detector is where the other should be.
    DetectorsSwapped,
    /// The picture of the western flame detector is mirrored; it is turned by 20°.
    DetectorMirrored,
    DetectorTurned,
    /// Dirt that is not noticed: it sees nothing.
    DetectorBlind,
    /// Its wire is on another input of the panel.
    HeatUnwired,
    /// A flame detector that sees the whole hall: it reports the sources of the other, too.
    DetectorTooWide,
    /// The relay of a pump starts the other one.
    PumpsSwapped,
    PumpDead,
    /// The second pump hangs on the relay of the first.
    PumpsTogether,
    /// The contact of its pressure never closes.
    GaugeDead,
    /// A closed valve behind the second pump.
    PumpShutOff,
    /// The relay of the outlet opens the zone valve.
    ValvesSwapped,
    OutletJammed,
    /// It opens, and its pipe is shut off by hand.
    OutletShutOff,
    OutletThrottled,
    /// It stays open.
    OutletStays,
    AbortCut,
    PumpStays,
}

/// What is really there.
pub struct World {
    pub sims: Mutex<Vec<Sim>>,
    pub panel: Panel,
    pub site: Site,
    /// In front of each flame detector is fire, or a test source.
    pub sources: Mutex<[bool; 2]>,
    /// In front of the heat detector is a test source.
    pub heat: AtomicBool,
    /// The outlet was open, and the second pump on.
    pub acted: [AtomicBool; 2],
    /// Water has left a monitor, since the start.
    pub wet: AtomicBool,
    /// Nothing answers on the line of the monitors any more.
    pub silent: AtomicBool,
}

impl World {
    pub fn sims(&self) -> MutexGuard<'_, Vec<Sim>> {
        self.sims.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn sources(&self) -> MutexGuard<'_, [bool; 2]> {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether water has left a monitor since the start.
    pub fn was_wet(&self) -> bool {
        self.wet.load(Ordering::Relaxed)
    }

    pub fn silence(&self) {
        self.silent.store(true, Ordering::Relaxed);
    }

    /// Bearing from the place of a monitor to the target, degrees.
    pub fn wanted(&self, monitor: usize) -> f64 {
        let plan = self.site.planned();
        let (target, at) = (plan.targets[0].at, plan.monitors[monitor].at.unwrap());
        (target[0] - at[0]).atan2(target[1] - at[1]).to_degrees()
    }

    /// Where the monitor at a place really looks: bearing, degrees.
    pub fn bearing(&self, monitor: usize) -> f64 {
        let at = self.sims()[monitor].world().drives[1].position;
        self.site.headings[monitor] - at / 60.0
    }

    /// Which pump runs.
    fn pumps(&self) -> [bool; 2] {
        let coils = [self.panel.coil(1), self.panel.coil(2)];
        if coils[1] {
            self.acted[1].store(true, Ordering::Relaxed);
        }
        match self.site.field {
            Field::PumpsSwapped => [coils[1], coils[0]],
            Field::PumpDead => [coils[0], false],
            Field::PumpsTogether => [coils[0], coils[0]],
            Field::PumpStays => [coils[0], coils[1] || self.acted[1].load(Ordering::Relaxed)],
            _ => coils,
        }
    }

    /// What the test outlet does: it is open.
    fn outlet(&self) -> bool {
        let coil = self.panel.coil(3);
        if coil {
            self.acted[0].store(true, Ordering::Relaxed);
        }
        match self.site.field {
            Field::OutletJammed => false,
            Field::OutletStays => coil || self.acted[0].load(Ordering::Relaxed),
            _ => coil,
        }
    }

    /// A person at the outlet sees water run from it, and from nowhere else.
    pub fn is_running(&self) -> bool {
        let shut = matches!(self.site.field, Field::ValvesSwapped | Field::OutletShutOff);
        self.outlet() && !shut && self.pumps().contains(&true)
    }

    /// What the gauge of the outlet shows, 0.1 atm.
    pub fn gauge(&self) -> f64 {
        if self.site.field == Field::OutletThrottled { 31.0 } else { 82.0 }
    }

    /// What a flame detector sees: fire, and its bearing by its own measure.
    fn sight(&self, index: usize) -> (bool, f64) {
        let (sources, field) = (*self.sources(), self.site.field);
        let seen = match field {
            Field::DetectorsSwapped => sources[1 - index],
            Field::DetectorBlind => sources[index] && index == 1,
            Field::DetectorTooWide => sources[index] || index == 1 && sources[0],
            _ => sources[index],
        };
        let plan = self.site.planned();
        let at = plan.detectors.iter().find(|it| it.id == FLAMES[index]).and_then(|it| it.at);
        let (at, target) = (at.unwrap_or_default(), plan.targets[0].at);
        let bearing = (target[0] - at[0]).atan2(target[1] - at[1]).to_degrees();
        let off = match field {
            Field::DetectorMirrored if index == 0 => -bearing,
            Field::DetectorTurned if index == 0 => bearing + 20.0,
            _ => bearing,
        };
        (seen, off.rem_euclid(360.0))
    }

    /// Pumps and the outlet report what they do; some contacts are stuck.
    fn wire(&self) {
        let (pumps, field) = (self.pumps(), self.site.field);
        let heat = self.heat.load(Ordering::Relaxed) && field != Field::HeatUnwired;
        let contacts = [
            (30, pumps[0]),
            (31, pumps[1]),
            (32, pumps[0] && field != Field::GaugeDead),
            (33, pumps[1] && field != Field::PumpShutOff),
            (34, self.outlet()),
            (HEAT, heat),
        ];
        let moves = contacts.into_iter().filter(|(at, _)| !self.site.stuck.contains(at));
        moves.for_each(|(at, on)| self.panel.set(at, on));
        self.site.stuck.iter().for_each(|at| self.panel.set(*at, true));
    }
}

/// A hub that runs.
pub struct Running {
    pub world: Arc<World>,
    pub hub: Hub,
    pub token: String,
    /// That of another client.
    pub other: String,
    pub address: SocketAddr,
    _end: oneshot::Sender<()>,
}

fn monitors(site: &Site) -> Vec<Sim> {
    let sim = |index: usize| {
        let address = site.addresses[index];
        let composition = Composition::REMOTE;
        let mut sim = Sim::new(SimConfig { composition, address, ..SimConfig::default() });
        sim.advance_ms(500);
        let good =
            [(Param::GeneralWaterTimeout, vec![600]), (Param::ControlNozzleDiameter, vec![280])];
        let more = site.params.iter().filter(|it| it.0 == index);
        let more = more.map(|(_, param, values)| (*param, values.clone()));
        for (param, values) in good.into_iter().chain(more) {
            let spec = param.spec();
            sim.ask(
                spec.subsystem,
                Body::SetParam { id: spec.id, values: Ints::Values(&values) },
                |_| {},
            );
            sim.advance_ms(300);
        }
        for (_, name) in site.faults.iter().filter(|it| it.0 == index) {
            sim.world_mut().inject(Fault::from_name(name).expect("a fault"));
        }
        sim.advance_ms(1000);
        sim
    };
    (0..2).map(sim).collect()
}

/// The line of the monitors: both hear everything.
async fn serve(world: Arc<World>, mut stream: TcpStream) {
    let mut ports: Vec<Port> = (0..2).map(|_| Port::new(Source::ExternalConn)).collect();
    let mut buffer = [0; 2048];
    while let Ok(len @ 1..) = stream.read(&mut buffer).await {
        let answers: Vec<u8> = {
            let mut sims = world.sims();
            let each = sims.iter_mut().zip(&mut ports).enumerate();
            let each = each.filter(|(index, _)| {
                world.site.silent != Some(*index) && !world.silent.load(Ordering::Relaxed)
            });
            each.flat_map(|(_, (sim, port))| sim.receive(port, &buffer[..len])).collect()
        };
        if stream.write_all(&answers).await.is_err() {
            return;
        }
    }
}

/// What flame detectors report, five times a second.
async fn detect(world: Arc<World>, address: SocketAddr, token: String) {
    let mut ticks = interval(Duration::from_millis(200));
    loop {
        ticks.tick().await;
        for (index, id) in FLAMES.into_iter().enumerate() {
            if world.site.mute[index] {
                continue;
            }
            let (seen, bearing) = world.sight(index);
            let signal = if seen { "alarm" } else { "quiet" };
            let mut report = json!({ "signal": signal, "condition": world.site.condition[index] });
            if seen {
                report["bearing_deg"] = json!(bearing);
            }
            let path = format!("/api/detectors/{id}");
            _ = http(address, &token, "POST", &path, &report.to_string()).await;
        }
    }
}

impl Running {
    pub async fn start(site: Site) -> Self {
        let (panel, bus) = Panel::listen().await;
        panel.set(12, true);
        let world = Arc::new(World {
            sims: Mutex::new(monitors(&site)),
            panel,
            site: site.clone(),
            sources: Mutex::new([false; 2]),
            heat: AtomicBool::new(false),
            acted: [AtomicBool::new(false), AtomicBool::new(false)],
            wet: AtomicBool::new(false),
            silent: AtomicBool::new(false),
        });
        world.wire();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let line = listener.local_addr().unwrap();
        let own = world.clone();
        tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                tokio::spawn(serve(own.clone(), stream));
            }
        });
        let own = world.clone();
        tokio::spawn(async move {
            let mut ticks = interval(Duration::from_millis(10));
            loop {
                ticks.tick().await;
                for sim in own.sims().iter_mut() {
                    (0..FASTER).for_each(|_| sim.tick());
                    if sim.world().inputs().flow_lps > 0 {
                        own.wet.store(true, Ordering::Relaxed);
                    }
                }
                own.wire();
            }
        });
        let text = site.file.replace("LINE", &line.to_string()).replace("BUS", &bus.to_string());
        let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
        let mut config = read.unwrap_or_else(|problems| panic!("{problems:#?}"));
        config.data = None;
        config.login = site.login;
        config.listen = SocketAddr::from(([127, 0, 0, 1], 0));
        let hub = Hub::new(config, Clock::System, json!({})).unwrap();
        let server = Server::bind(hub.clone()).await.unwrap();
        let address = server.address().unwrap();
        let (end, ending) = oneshot::channel::<()>();
        tokio::spawn(server.serve(async { _ = ending.await }));
        let token = |name: &str, role: Role| hub.access().add_token(1, name, role).unwrap().1;
        tokio::spawn(detect(world.clone(), address, token("detectors", Role::Operator)));
        let (own, other) = (token("tester", Role::Engineer), token("other", Role::Engineer));
        let running = Self { token: own, other, world, hub, address, _end: end };
        running.settle().await;
        for (path, body) in &running.world.site.before {
            http(address, &running.token, "POST", path, &body.to_string()).await.unwrap();
            sleep(Duration::from_millis(700)).await;
        }
        running
    }

    /// Until it has come to rest: all is read, or nothing changes any more.
    async fn settle(&self) {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(8) {
            let up = self.hub.stations().iter().all(|it| it.health() == "up");
            let zones = http(self.address, &self.token, "GET", "/api/zones", "").await.unwrap().1;
            let ready = zones["state"]["zones"]
                .as_array()
                .unwrap()
                .iter()
                .all(|it| it["ready"] == true && it["unable"] == json!([]));
            let buses = http(self.address, &self.token, "GET", "/api/modbus", "").await.unwrap().1;
            let read = !buses.to_string().contains("\"waiting\"");
            if up && ready && read {
                break;
            }
            sleep(Duration::from_millis(100)).await;
        }
        // Contacts count once they have come to rest.
        sleep(RESTS).await;
        // Troubles of the start are no findings.
        http(self.address, &self.token, "POST", "/api/zones/reset", "{}").await.unwrap();
    }

    /// Tests it.
    pub async fn test(&self, stages: &[Stage]) -> Outcome {
        let mut person = Beside::of(self);
        let mut wire = self.wire();
        let plan = self.world.site.planned();
        let stages = stages.iter().copied().collect();
        Run::all(&mut wire, &mut person, &plan, &stages).await
    }

    pub fn wire(&self) -> Http {
        Http {
            address: self.address,
            token: self.token.clone(),
            began: Instant::now(),
            date_off_ms: self.world.site.date_off_ms,
            answers: self.world.site.answers.clone(),
            sent: Vec::new(),
            stop_after: None,
            lost_after: None,
            unheard: None,
            slow: false,
            answers_later: None,
        }
    }

    /// Where the drives of the barrels are, arc-minutes.
    pub fn positions(&self) -> [[f64; 2]; 2] {
        let sims = self.world.sims();
        [0, 1].map(|sim| [0, 1].map(|drive| sims[sim].world().drives[drive].position))
    }

    pub fn rests_at(&self, at: [[f64; 2]; 2]) -> bool {
        let now = self.positions();
        let both = at.as_flattened().iter().zip(now.as_flattened());
        both.into_iter().all(|(at, now)| (at - now).abs() < 6.0)
    }

    /// What the hub answers.
    pub async fn ask(&self, path: &str) -> Value {
        http(self.address, &self.token, "GET", path, "").await.unwrap().1
    }
}

/// The hub over HTTP.
pub struct Http {
    address: SocketAddr,
    token: String,
    began: Instant,
    date_off_ms: i64,
    answers: Vec<(&'static str, &'static str, Value)>,
    /// What was posted.
    pub sent: Vec<Posting>,
    /// The person stops, and the connection is lost, after so many postings.
    pub stop_after: Option<usize>,
    pub lost_after: Option<(usize, usize)>,
    /// The first posting to an address that ends so, with this in its body, is carried out, and its answer lost.
    pub unheard: Option<(&'static str, &'static str)>,
    /// What moves is held up for 3 s.
    pub slow: bool,
    /// An answer that is another one from the first order on: path, pointer, value.
    pub answers_later: Option<(&'static str, &'static str, Value)>,
}

impl Http {
    async fn ask(&self, method: &str, path: &str, body: &str) -> Result<Value, Failed> {
        let lost = |_| Failed::Lost(Words::same("lost"));
        let (status, mut value) =
            http(self.address, &self.token, method, path, body).await.map_err(lost)?;
        if status >= 400 {
            let error = &value["error"];
            let text = |lang: &str| error[lang].as_str().unwrap_or_default().to_owned();
            let code = error["code"].as_str().unwrap_or_default().to_owned();
            if status >= 500 && method == "POST" && !path.ends_with("/params/read") {
                return Err(Failed::Lost(Words { en: text("en"), ru: text("ru") }));
            }
            return Err(Failed::Refused { code, text: Words { en: text("en"), ru: text("ru") } });
        }
        if value["ok"] == false && path != "/health" {
            return Err(Failed::Lost(Words::same("not all is done")));
        }
        let later = self.answers_later.iter().filter(|_| self.sent.len() > 2);
        for (of, pointer, other) in self.answers.iter().chain(later) {
            if *of == path {
                *value.pointer_mut(pointer).expect("a place in the answer") = other.clone();
            }
        }
        Ok(value)
    }

    fn is_lost(&self) -> bool {
        self.lost_after.is_some_and(|(from, to)| (from..to).contains(&self.sent.len()))
    }
}

impl Wire for Http {
    async fn get(&mut self, path: &str) -> Result<Value, Failed> {
        if self.is_lost() {
            return Err(Failed::Lost(Words::same("lost")));
        }
        self.ask("GET", path, "").await
    }

    fn ends(&mut self) {}

    async fn post(&mut self, posting: &Posting) -> Result<Value, Failed> {
        self.sent.push(posting.clone());
        if self.is_lost() {
            return Err(Failed::Lost(Words::same("lost")));
        }
        let body = posting.body().to_string();
        if self.slow && posting.path().ends_with("/requests") {
            sleep(Duration::from_secs(3)).await;
        }
        let answer = self.ask("POST", posting.path(), &body).await;
        let path = posting.path().split('?').next().unwrap_or_default();
        if self.unheard.is_some_and(|(end, with)| path.ends_with(end) && body.contains(with)) {
            self.unheard = None;
            return Err(Failed::Lost(Words::same("the answer is lost")));
        }
        answer
    }

    async fn pause(&mut self, ms: u64) -> Result<(), Stopped> {
        if self.stop_after.is_some_and(|count| self.sent.len() >= count) {
            return Err(Stopped);
        }
        sleep(Duration::from_millis(ms)).await;
        Ok(())
    }

    async fn settle(&mut self, ms: u64) -> Result<(), Stopped> {
        sleep(Duration::from_millis(ms)).await;
        Ok(())
    }

    fn now_ms(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_millis()).unwrap()
    }

    fn date_ms(&self) -> Option<u64> {
        Some(Clock::System.now_ms().saturating_add_signed(self.date_off_ms))
    }
}

/// Gives an order; the status of the answer.
pub async fn order(address: SocketAddr, token: &str, path: &str, body: &Value) -> u16 {
    http(address, token, "POST", path, &body.to_string()).await.unwrap().0
}

/// Asks the hub: status and answer.
pub async fn http(
    address: SocketAddr,
    token: &str,
    method: &str,
    path: &str,
    body: &str,
) -> std::io::Result<(u16, Value)> {
    let mut stream = TcpStream::connect(address).await?;
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n\
         Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(head.as_bytes()).await?;
    let mut bytes = Vec::new();
    timeout(Duration::from_secs(20), stream.read_to_end(&mut bytes)).await??;
    let text = String::from_utf8_lossy(&bytes);
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    let status = head.split(' ').nth(1).and_then(|it| it.parse().ok()).unwrap_or(0);
    let body = if head.to_ascii_lowercase().contains("transfer-encoding: chunked") {
        unchunked(body)
    } else {
        body.to_owned()
    };
    Ok((status, serde_json::from_str(&body).unwrap_or_default()))
}

fn unchunked(mut body: &str) -> String {
    let mut whole = String::new();
    while let Some((len, rest)) = body.split_once("\r\n") {
        let len = usize::from_str_radix(len.trim(), 16).unwrap_or(0);
        if len == 0 || rest.len() < len {
            break;
        }
        whole += &rest[..len];
        body = rest[len..].trim_start_matches("\r\n");
    }
    whole
}

/// The checks that have failed, with their subjects.
pub fn failed(outcome: &Outcome) -> Vec<String> {
    outcome.findings.failed().map(|it| format!("{} {}", it.check.id, it.subject)).collect()
}

/// Everything that was found, for messages of tests.
pub fn shown(outcome: &Outcome) -> String {
    let mut by: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for it in &outcome.findings.0 {
        let words =
            |words: &Option<Words>| words.as_ref().map_or("", |it| it.en.as_str()).to_owned();
        by.entry(it.verdict.name()).or_default().push(format!(
            "{} {}: {} | {}{}",
            it.check.id,
            it.subject,
            words(&it.limit),
            words(&it.measured),
            words(&it.why)
        ));
    }
    format!("{:#?} {by:#?} {:#?}", outcome.ended, outcome.left)
}
