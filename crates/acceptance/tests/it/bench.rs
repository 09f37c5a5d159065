//! An installation in one process: a hub with its file, simulated monitors, a panel, detectors, pumps, outlets.
//!
//! [`Site`] describes it. A wrong installation is a good one with one field, or one line of the file, changed.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::Path;
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
/// What is on the panel.
pub const HEAT: u16 = 2;
pub const ABORT: u16 = 20;
pub const STATION: u16 = 21;
const RUNS: [u16; 2] = [30, 31];
const GAUGES: [u16; 2] = [32, 33];
const OPEN: [u16; 2] = [34, 35];
const PUMPS: [u16; 2] = [1, 2];
const OUTLETS: [u16; 2] = [3, 4];
pub const HORN: u16 = 5;

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
    /// Each flame detector: its bearing as it reports it of the true one; and whether it reports at all.
    pub bearing: [fn(f64) -> f64; 2],
    pub mute: [bool; 2],
    /// The name under which each flame detector reports.
    pub reports_as: [&'static str; 2],
    /// Condition that flame detectors report.
    pub condition: [&'static str; 2],
    /// Discrete input that the heat detector, the abort and the release station close.
    pub wired: [Option<u16>; 3],
    /// Which pump a coil starts, which gauge a pump moves, which outlet a coil opens.
    pub pumps: [usize; 2],
    pub gauges: [Option<usize>; 2],
    pub outlets: [Option<usize>; 2],
    /// Contacts that are stuck on.
    pub stuck: Vec<u16>,
    pub horn: bool,
    /// People answer the alarm of a drill.
    pub answers_drill: bool,
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
            bearing: [|it| it; 2],
            mute: [false; 2],
            reports_as: ["flame-west", "flame-east"],
            condition: ["ready"; 2],
            wired: [Some(HEAT), Some(ABORT), Some(STATION)],
            pumps: [0, 1],
            gauges: [Some(0), Some(1)],
            outlets: [Some(0), Some(1)],
            stuck: Vec::new(),
            horn: true,
            answers_drill: true,
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

/// What is really there.
pub struct World {
    pub sims: Mutex<Vec<Sim>>,
    pub panel: Panel,
    pub site: Site,
    /// A test source is held to each flame detector.
    pub sources: Mutex<[bool; 2]>,
}

impl World {
    pub fn sims(&self) -> MutexGuard<'_, Vec<Sim>> {
        self.sims.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn sources(&self) -> MutexGuard<'_, [bool; 2]> {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where the monitor at a place really looks: bearing, degrees.
    pub fn bearing(&self, monitor: usize) -> f64 {
        let at = self.sims()[monitor].world().drives[1].position;
        self.site.headings[monitor] - at / 60.0
    }

    pub fn runs(&self, pump: usize) -> bool {
        (0..2).any(|coil| self.site.pumps[coil] == pump && self.panel.coil(PUMPS[coil]))
    }

    /// The outlet from which water runs.
    pub fn outlet(&self) -> Option<usize> {
        let wet = |coil: &usize| self.panel.coil(OUTLETS[*coil]);
        (0..2).find(wet).and_then(|coil| self.site.outlets[coil])
    }

    fn wire(&self) {
        let set = |at: u16, on: bool| self.panel.set(at, on || self.site.stuck.contains(&at));
        for (pump, at) in RUNS.into_iter().enumerate() {
            let runs = self.runs(pump);
            set(at, runs);
            if let Some(gauge) = self.site.gauges[pump] {
                set(GAUGES[gauge], runs);
            }
        }
        for (coil, at) in OPEN.into_iter().enumerate() {
            let open = self.panel.coil(OUTLETS[coil]) && self.site.outlets[coil].is_some();
            set(at, open);
        }
        self.site.stuck.iter().for_each(|at| self.panel.set(*at, true));
    }
}

/// A hub that runs.
pub struct Running {
    pub world: Arc<World>,
    pub hub: Hub,
    pub token: String,
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
            let each = each.filter(|(index, _)| world.site.silent != Some(*index));
            each.flat_map(|(_, (sim, port))| sim.receive(port, &buffer[..len])).collect()
        };
        if stream.write_all(&answers).await.is_err() {
            return;
        }
    }
}

/// What flame detectors report, twice a second and at each change.
async fn detect(world: Arc<World>, address: SocketAddr, token: String) {
    let plan = world.site.planned();
    let target = plan.targets[0].at;
    let mut ticks = interval(Duration::from_millis(200));
    loop {
        ticks.tick().await;
        for (index, id) in ["flame-west", "flame-east"].into_iter().enumerate() {
            if world.site.mute[index] {
                continue;
            }
            let at = plan.detector(id).unwrap().at.unwrap();
            let bearing = (target[0] - at[0]).atan2(target[1] - at[1]).to_degrees();
            let bearing = (world.site.bearing[index])(bearing).rem_euclid(360.0);
            let mut report = json!({ "signal": "quiet", "condition": world.site.condition[index] });
            if world.sources()[index] {
                report["signal"] = json!("alarm");
                report["bearing_deg"] = json!(bearing);
            }
            let path = format!("/api/detectors/{}", world.site.reports_as[index]);
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
                own.sims().iter_mut().for_each(|sim| (0..FASTER).for_each(|_| sim.tick()));
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
        let token = |role: Role| hub.access().add_token(1, role.name(), role).unwrap().1;
        tokio::spawn(detect(world.clone(), address, token(Role::Operator)));
        let running = Self { token: token(Role::Engineer), world, hub, address, _end: end };
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
            if up && ready {
                break;
            }
            sleep(Duration::from_millis(100)).await;
        }
        // Troubles of the start are no findings.
        http(self.address, &self.token, "POST", "/api/zones/reset", "{}").await.unwrap();
    }

    /// Tests it.
    pub async fn test(&self, stages: &[Stage]) -> Outcome {
        let mut person = Beside::of(self.world.clone());
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
        }
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
            return Err(Failed::Refused { code, text: Words { en: text("en"), ru: text("ru") } });
        }
        for (of, pointer, other) in &self.answers {
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

    async fn post(&mut self, posting: &Posting) -> Result<Value, Failed> {
        self.sent.push(posting.clone());
        if self.is_lost() {
            return Err(Failed::Lost(Words::same("lost")));
        }
        self.ask("POST", posting.path(), &posting.body().to_string()).await
    }

    async fn pause(&mut self, ms: u64) -> Result<(), Stopped> {
        if self.stop_after.is_some_and(|count| self.sent.len() >= count) {
            return Err(Stopped);
        }
        sleep(Duration::from_millis(ms)).await;
        Ok(())
    }

    async fn settle(&mut self, ms: u64) {
        sleep(Duration::from_millis(ms)).await;
    }

    fn now_ms(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_millis()).unwrap()
    }

    fn date_ms(&self) -> Option<u64> {
        Some(Clock::System.now_ms().saturating_add_signed(self.date_off_ms))
    }
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
