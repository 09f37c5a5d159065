//! The stage: the simulated monitor, the client, simulated time, and the views.

use std::collections::BTreeMap;
use std::time::Duration;

use lafet_client::{AnswerBuf, Answers, Client, Config as ClientConfig, Endpoint, Error};
use lafet_proto::flags::{DetectorFlags, DriveFlags};
use lafet_proto::request::Body;
use lafet_proto::text::{AnswerText, Exchange};
use lafet_proto::{Request, RequestId, SubsystemId};
use lafet_sim::event::What;
use lafet_sim::fire::FireSpec;
use lafet_sim::sim::Config;
use lafet_sim::world::STEP_MS;
use lafet_texts::{Text as _, cli as text};
use tokio::time::{Instant, sleep_until};

use super::Options;
use super::scene::{Kind, Line, Plan, Scene, View};
use super::summary::Summary;
use super::trace::Trace;
use crate::describe::hex;
use crate::exchange;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::serve::{Listen, Shared};
use crate::simulator;

/// Simulated time between two pictures, ms.
const PICTURE_MS: u64 = 50;
/// Simulated time between two polls of the monitor's state, ms.
const LOOK_MS: u64 = 250;
/// The loopback loses nothing, so a slow computer must not make the client repeat a request: the
/// trace would show it.
const ANSWER: Duration = Duration::from_secs(60);

/// A running demonstration.
pub struct Stage {
    sim: Shared,
    client: Client,
    view: Box<dyn View>,
    trace: Trace,
    scene: Scene,
    summary: Summary,
    interrupt: Interrupt,
    speed: f64,
    began: Instant,
    shown: BTreeMap<SubsystemId, u32>,
}

impl Stage {
    /// Starts a monitor that listens on the loopback, and connects to it.
    pub async fn open(
        options: &Options,
        fires: &[FireSpec],
        view: Box<dyn View>,
    ) -> Result<Self, Failure> {
        let interrupt = Interrupt::catch()?;
        let config = Config { seed: options.seed, trace: true, ..Config::default() };
        let sim = Shared::new(simulator::power_up(config));
        let what = || text::NoPortFree.str(current());
        let listening = Listen::tcp("127.0.0.1:0").open().await;
        let listening = listening.map_err(|error| Failure::io(what(), error))?;
        let url = listening.url().to_owned();
        tokio::spawn(listening.serve(sim.clone()));
        let endpoint: Endpoint = url.parse().map_err(Error::from)?;
        let client_config = ClientConfig { timeout: ANSWER, ..ClientConfig::default() };
        let client = Client::connect_with(&endpoint, client_config).await?;
        let mut trace = Trace::open(options.trace.as_deref())?;
        let fires: Vec<String> = fires.iter().map(fire_text).collect();
        trace.add(&format!("# lafet demo, seed {}, fire {}\n", options.seed, fires.join(" ")))?;
        let scene = Scene { url, seed: options.seed, ..Scene::default() };
        let summary = Summary { seed: options.seed, ..Summary::default() };
        Ok(Self {
            sim,
            client,
            view,
            trace,
            scene,
            summary,
            interrupt,
            speed: options.speed,
            began: Instant::now(),
            shown: BTreeMap::new(),
        })
    }

    /// The data shown by the view.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The summary, to be filled by the script.
    pub const fn summary(&mut self) -> &mut Summary {
        &mut self.summary
    }

    /// Sets the fire spots that the monitor reported.
    pub fn set_hotbeds(&mut self, hotbeds: Vec<lafet_proto::status::Hotbed>) {
        self.scene.hotbeds = hotbeds;
    }

    /// Starts the next part of the script.
    pub fn phase(&mut self, phase: &'static str) {
        self.scene.phase = phase;
    }

    /// Logs a remark of the operator.
    pub fn say(&mut self, text: impl Into<String>) -> Result<(), Failure> {
        self.show(Kind::Operator, text.into())
    }

    /// Lights a fire in the simulated world.
    pub fn light(&mut self, fire: FireSpec) -> Result<(), Failure> {
        self.sim.lock().world_mut().light(fire);
        self.summary.fires += 1;
        self.events()
    }

    /// Directions of the burning fires, arc-minutes.
    pub fn burning(&self) -> Vec<f64> {
        let sim = self.sim.lock();
        let burning = sim.world().fires.iter().filter(|fire| fire.burns());
        burning.map(|fire| fire.at.1.atan2(fire.at.0).to_degrees() * 60.0).collect()
    }

    /// Distance of the fire nearest to a direction (arc-minutes), m: what a map of the site would
    /// show.
    pub fn range_of_nearest(&self, direction: f64) -> f64 {
        let sim = self.sim.lock();
        let off = |azimuth_deg: f64| (azimuth_deg * 60.0 - direction).abs();
        let fires = sim.world().fires.iter().map(|fire| fire.spec);
        fires
            .min_by(|a, b| off(a.azimuth_deg).total_cmp(&off(b.azimuth_deg)))
            .map_or(0.0, |fire| fire.range_m)
    }

    /// Sends a request and shows it with its answers. Simulated time does not advance meanwhile.
    pub async fn ask(&mut self, to: SubsystemId, body: Body<'_>) -> Result<Answers, Failure> {
        let request = Request::new(to, body);
        self.show(Kind::Request, request.to_string())?;
        let answers = self.exchange(&request).await?;
        for answer in &*answers {
            let kind = if answer.status().is_success() { Kind::Answer } else { Kind::Refusal };
            self.show(kind, answer_text(to, answer))?;
        }
        Ok(answers.accepted()?)
    }

    /// Reads all states. The trace records all of them; the view shows changes.
    pub async fn look(&mut self) -> Result<(), Failure> {
        let request = Request::new(SubsystemId::ALL, Body::GetStatus);
        let answers = self.exchange(&request).await?;
        self.scene.learn(&answers);
        let detector = DetectorFlags::from_bits_retain(self.scene.flags(SubsystemId::DETECTOR));
        if self.summary.lit_ms.is_some() && detector.contains(DetectorFlags::FOUND) {
            self.summary.detected_ms.get_or_insert(self.now_ms());
        }
        let mut first = true;
        for answer in &*answers {
            let bits = answer.decode().ok().and_then(|answer| answer.data.flags_bits());
            let bits = bits.map(|bits| bits & !ordinary(answer.from()));
            if bits == self.shown.get(&answer.from()).copied() {
                continue;
            }
            if std::mem::take(&mut first) {
                self.show(Kind::Request, request.to_string())?;
            }
            self.shown.insert(answer.from(), bits.unwrap_or(0));
            self.show(Kind::Answer, answer_text(request.to, answer))?;
        }
        Ok(())
    }

    /// Advances simulated time.
    pub async fn pass(&mut self, ms: u64) -> Result<(), Failure> {
        let end_ms = self.now_ms() + ms;
        while self.now_ms() < end_ms {
            for _ in 0..PICTURE_MS / STEP_MS {
                let mut sim = self.sim.lock();
                sim.tick();
                self.summary.water_l += sim.world().water.jet_lps() * STEP_MS as f64 / 1000.0;
            }
            self.events()?;
            if self.now_ms().is_multiple_of(LOOK_MS) {
                self.look().await?;
            }
            self.draw()?;
            self.pace().await?;
        }
        Ok(())
    }

    /// Advances time until a condition holds, by `limit_ms` at most; returns whether it held.
    pub async fn until(
        &mut self,
        limit_ms: u64,
        is_so: impl Fn(&Self) -> bool,
    ) -> Result<bool, Failure> {
        let end_ms = self.now_ms() + limit_ms;
        while self.now_ms() < end_ms {
            self.pass(LOOK_MS).await?;
            if is_so(self) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Ends the demonstration, and flushes the trace.
    pub async fn close(mut self, to_the_end: bool) -> Result<Summary, Failure> {
        self.summary.end_ms = self.now_ms();
        let traced = self.keep_trace().and_then(|()| self.trace.close());
        self.view.close(&self.scene, to_the_end)?;
        traced.map(|()| self.summary)
    }

    fn now_ms(&self) -> u64 {
        self.sim.lock().now_ms()
    }

    async fn exchange(&mut self, request: &Request<'_>) -> Result<Answers, Failure> {
        self.keep_trace()?;
        let at_s = self.now_ms() as f64 / 1000.0;
        let bytes = hex(&exchange::bytes(request));
        self.trace.add(&format!("t={at_s:.2} → {request}  [{bytes}]\n"))?;
        self.summary.requests += 1;
        let answers = self.client.request(request).await?;
        for answer in &*answers {
            self.summary.answers += 1;
            let text = answer_text(request.to, answer);
            self.trace.add(&format!("t={at_s:.2} ← {text}\n"))?;
        }
        Ok(answers)
    }

    fn keep_trace(&mut self) -> Result<(), Failure> {
        let lines = self.sim.lock().take_trace();
        self.trace.add(&lines.unwrap_or_default())
    }

    /// Logs new events of the simulated world.
    fn events(&mut self) -> Result<(), Failure> {
        let events = self.sim.lock().world_mut().take_events();
        for event in events {
            let Some(text) = self.event(event.at_ms, event.what) else { continue };
            self.keep_trace()?;
            self.trace.add(&format!(
                "t={:.2} * {:?}\n",
                event.at_ms as f64 / 1000.0,
                event.what
            ))?;
            self.show(Kind::World, text)?;
        }
        Ok(())
    }

    fn event(&mut self, at_ms: u64, what: What) -> Option<String> {
        let fire = |index: usize| match self.summary.fires {
            0 | 1 => String::new(),
            _ => format!(" {}", index + 1),
        };
        Some(match what {
            What::FireLit(index) => {
                let fire = fire(index);
                self.summary.lit_ms.get_or_insert(at_ms);
                let spec = self.sim.lock().world().fires.get(index)?.spec;
                let (azimuth, range) = (spec.azimuth_deg, spec.range_m);
                text::StageFireBreaksOut { fire, azimuth, range }.of(current())
            }
            What::FireHit(index) => {
                let fire = fire(index);
                self.summary.water_ms.get_or_insert(at_ms);
                text::StageWaterReaches { fire }.of(current())
            }
            What::FireOut(index) => {
                let fire = fire(index);
                self.summary.out += 1;
                self.summary.out_ms = Some(at_ms);
                text::StageFireOut { fire }.of(current())
            }
            What::FireReignited(index) => {
                self.summary.out = self.summary.out.saturating_sub(1);
                text::StageFireAgain { fire: fire(index) }.of(current())
            }
            What::JetOn => text::StageJetBegins.str(current()).into(),
            What::JetOff => text::StageJetEnds.str(current()).into(),
            What::FoldedBarrelFlooded => text::StageWaterInBarrel.str(current()).into(),
            What::PoweredUp | What::Reset | What::Crashed => return None,
        })
    }

    fn show(&mut self, kind: Kind, text: String) -> Result<(), Failure> {
        let line = Line { at_ms: self.now_ms(), kind, text };
        self.view.line(&line)?;
        self.scene.note(line);
        Ok(())
    }

    fn draw(&mut self) -> Result<(), Failure> {
        let sim = self.sim.lock();
        let world = sim.world();
        let horizontal = &world.drives[lafet_device::image::Axis::Horizontal as usize];
        self.scene.now_ms = sim.now_ms();
        self.scene.world = Plan {
            azimuth: (horizontal.position / 60.0).to_radians(),
            deployed: world.deployed(),
            landing: world.landing(),
            fires: world.fires.iter().map(|fire| (fire.at, fire.size_m, fire.heat)).collect(),
        };
        drop(sim);
        self.view.draw(&self.scene)
    }

    /// Waits until real time has caught up with simulated time.
    async fn pace(&mut self) -> Result<(), Failure> {
        if self.view.wants_to_leave() {
            return Err(Failure::Interrupted);
        }
        let due = match self.speed {
            0.0 => self.began,
            speed => self.began + Duration::from_secs_f64(self.now_ms() as f64 / 1000.0 / speed),
        };
        tokio::select! {
            biased;
            () = self.interrupt.wait() => Err(Failure::Interrupted),
            () = sleep_until(due) => Ok(()),
        }
    }
}

/// Flags that change constantly while the barrel scans.
fn ordinary(who: SubsystemId) -> u32 {
    match who {
        SubsystemId::VERTICAL | SubsystemId::HORIZONTAL | SubsystemId::NOZZLE => {
            DriveFlags::MOVE.bits()
        }
        _ => 0,
    }
}

fn answer_text(to: SubsystemId, answer: &AnswerBuf) -> String {
    match answer.decode() {
        Ok(decoded) if answer.request() != RequestId::GET_CRASH_DATA => {
            Exchange { to, answer: decoded }.to_string()
        }
        _ => AnswerText(answer.record()).to_string(),
    }
}

fn fire_text(fire: &FireSpec) -> String {
    format!("az={},range={},size={}", fire.azimuth_deg, fire.range_m, fire.size_m)
}
