//! An automatic controller: seeks, extinguishes the brightest hotbed, looks again, wraps.
//!
//! It knows nothing but what the monitor answers over its link. A request without an answer is
//! repeated each second; meanwhile the monitor goes on as it was commanded last.

use lafet_proto::flags::{DetectorFlags, ValveFlags};
use lafet_proto::record::{Record, Records};
use lafet_proto::status::Hotbed;
use lafet_proto::{Answer, SubsystemId};
use lafet_texts::{Text as _, Words, sim as text};

use super::director::{Director, Waiting};
use super::file::payload;
use super::log::Log;
use super::plan::ControllerPlan;

/// It polls this often, ms.
const POLL_MS: u64 = 500;
const RETRY_MS: u64 = 1_000;
const REFUSED_MS: u64 = 3_000;
/// Time that a search, the aiming and the closing have to show in the state, ms.
const SETTLE_MS: u64 = 1_000;
const AIM_MAX_MS: u64 = 30_000;
const CLOSE_MAX_MS: u64 = 12_000;
/// The narrowest jet, mm, and the height of the scan, arc-minutes.
const NARROW_MM: u32 = 60;
const SCAN_HEIGHT: i32 = 60;
/// Distances that an estimate may give, m.
const PLAUSIBLE_M: core::ops::RangeInclusive<f64> = 4.0..=70.0;
/// Searches that find nothing before it is satisfied.
const EMPTY: u32 = 2;
/// A hotbed this near to a known hot thing is that thing, degrees.
const SAME_DEG: f64 = 3.0;

/// A controller at work.
#[derive(Clone, Debug)]
pub struct Controller {
    state: State,
    waiting: Waiting,
    next_ms: u64,
    since_ms: u64,
    empty: u32,
    /// Arc-minutes: where the hotbed under attack is, and half the width of its sector.
    target: (i32, i32),
    unanswered: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Seek,
    Searching,
    Read,
    Aiming,
    Open,
    Throwing,
    Close,
    Closing,
    Stop,
    Wrap,
    Done,
}

/// What came of a request.
enum Came {
    Success(Vec<u8>),
    Refused,
    Nothing,
}

impl Controller {
    /// Not started.
    pub fn new() -> Self {
        Self {
            state: State::Waiting,
            waiting: Waiting::default(),
            next_ms: 0,
            since_ms: 0,
            empty: 0,
            target: (0, 0),
            unanswered: false,
        }
    }

    /// Looks whether there is something to do.
    pub fn step(&mut self, plan: &ControllerPlan, director: &mut Director, log: &mut Log) {
        let now_ms = director.now_ms();
        if self.state == State::Waiting {
            if !director.fires(&plan.trigger, &mut self.waiting) {
                return;
            }
            director.pass(plan.mark);
            self.state = State::Seek;
        }
        if self.state == State::Done || now_ms < self.next_ms {
            return;
        }
        self.next_ms = now_ms + POLL_MS;
        let before = self.state;
        self.act(plan, director, log);
        if self.state != before {
            self.since_ms = now_ms;
        }
    }

    fn act(&mut self, plan: &ControllerPlan, director: &mut Director, log: &mut Log) {
        let waited_ms = director.now_ms().saturating_sub(self.since_ms);
        match self.state {
            State::Waiting | State::Done => {}
            State::Seek => {
                let [from_az, to_az, from_el, to_el] = plan.sector.map(|deg| deg * 60.0);
                let seek =
                    format!("StartSeek Detector {from_az} {to_az} {from_el} {to_el} analyse");
                self.command(&seek, State::Searching, plan, director, log);
            }
            State::Searching => {
                let flags = self.flags(SubsystemId::DETECTOR, plan, director);
                let ended = flags.is_some_and(|bits| {
                    !DetectorFlags::from_bits_retain(bits).contains(DetectorFlags::SEARCHING)
                });
                if ended && waited_ms > SETTLE_MS {
                    self.state = State::Read;
                }
            }
            State::Read => self.read(plan, director, log),
            State::Aiming => {
                let aimed = self.aimed(plan, director);
                if (aimed && waited_ms > SETTLE_MS) || waited_ms > AIM_MAX_MS {
                    self.state = State::Open;
                }
            }
            State::Open => {
                let open = format!("Open {}", plan.valve);
                self.command(&open, State::Throwing, plan, director, log);
            }
            State::Throwing if waited_ms >= plan.quench_ms => self.state = State::Close,
            State::Throwing => {}
            State::Close => {
                let close = format!("Close {}", plan.valve);
                self.command(&close, State::Closing, plan, director, log);
            }
            State::Closing => {
                let valve = SubsystemId::from_name(plan.valve).unwrap_or(SubsystemId::VALVE1);
                let closed = self.flags(valve, plan, director).is_some_and(|bits| {
                    ValveFlags::from_bits_retain(bits).contains(ValveFlags::CLOSED)
                });
                if closed || waited_ms > CLOSE_MAX_MS {
                    self.state = State::Stop;
                }
            }
            State::Stop => self.command("Stop Control", State::Seek, plan, director, log),
            State::Wrap => self.command("Wrap Deployer", State::Done, plan, director, log),
        }
    }

    /// Sends a command; with its success the next state begins.
    fn command(
        &mut self,
        request: &str,
        next: State,
        plan: &ControllerPlan,
        director: &mut Director,
        log: &mut Log,
    ) {
        if let Came::Success(_) = self.ask(request, plan, director, log) {
            self.state = next;
        }
    }

    fn ask(
        &mut self,
        request: &str,
        plan: &ControllerPlan,
        director: &mut Director,
        log: &mut Log,
    ) -> Came {
        let Ok(payload) = payload(request) else { return Came::Refused };
        let now_ms = director.now_ms();
        let answers = director.request(plan.monitor, plan.over, &payload);
        // Of a lost link the first request and the first that is answered again are logged.
        if answers.is_some() || !self.unanswered {
            log.exchange(now_ms, plan.monitor, plan.over, request, &payload, answers.as_deref());
        }
        self.unanswered = answers.is_none();
        let Some(answers) = answers else {
            self.next_ms = now_ms + RETRY_MS;
            return Came::Nothing;
        };
        let first = Records::new(&answers).flatten().next();
        if first.is_some_and(|record| record.status.is_success()) {
            return Came::Success(answers);
        }
        self.next_ms = now_ms + REFUSED_MS;
        Came::Refused
    }

    /// Takes the hotbeds, and begins with the brightest.
    fn read(&mut self, plan: &ControllerPlan, director: &mut Director, log: &mut Log) {
        let asked = self.ask("GetParam Detector Hotbeds", plan, director, log);
        let Came::Success(answers) = asked else { return };
        let hotbeds = first(&answers).and_then(|record| {
            Some(Answer::decode(&record).ok()?.hotbeds()?.collect::<Vec<Hotbed>>())
        });
        let hotbeds = hotbeds.unwrap_or_default();
        let burning = hotbeds.into_iter().filter(|hotbed| !ignored(plan, hotbed));
        let Some(hotbed) = burning.max_by_key(|hotbed| hotbed.brightness) else {
            self.empty += 1;
            let done = self.empty >= EMPTY;
            log.say(director.now_ms(), Some(plan.monitor), nothing_found(done));
            self.state = match (done, plan.wrap) {
                (false, _) => State::Seek,
                (true, true) => State::Wrap,
                (true, false) => State::Done,
            };
            return;
        };
        self.empty = 0;
        let eye_m = director.site.members[plan.monitor].sim.world().height_m;
        let distance_m = plan.distance_m.or_else(|| estimate_m(&hotbed, eye_m)).unwrap_or(30.0);
        let centre = i32::midpoint(hotbed.x1, hotbed.x2);
        let width = (hotbed.x1 - hotbed.x2).abs() + 2 * libm::round(plan.margin_deg * 60.0) as i32;
        let low = hotbed.y1.min(hotbed.y2);
        let quench = format!(
            "StartQuench Control centre={centre},{low} nozzle={NARROW_MM} \
             sector={width},{SCAN_HEIGHT} step=1 distance={}",
            libm::round(distance_m).clamp(1.0, 127.0)
        );
        self.target = (centre, width);
        self.command(&quench, State::Aiming, plan, director, log);
    }

    fn aimed(&self, plan: &ControllerPlan, director: &mut Director) -> bool {
        let Ok(payload) = payload("GetStatus Horizontal") else { return false };
        let answers = director.request(plan.monitor, plan.over, &payload);
        let position =
            answers.as_deref().and_then(first).and_then(|record| {
                match Answer::decode(&record).ok()?.data {
                    lafet_proto::answer::Reply::Drive(status) => Some(i32::from(status.position)),
                    _ => None,
                }
            });
        position.is_some_and(|position| (position - self.target.0).abs() <= self.target.1)
    }

    fn flags(
        &self,
        who: SubsystemId,
        plan: &ControllerPlan,
        director: &mut Director,
    ) -> Option<u32> {
        let payload = payload(&format!("GetStatus {who}")).ok()?;
        let answers = director.request(plan.monitor, plan.over, &payload)?;
        Answer::decode(&first(&answers)?).ok()?.data.flags_bits()
    }
}

fn first(answers: &[u8]) -> Option<Record<'_>> {
    Records::new(answers).flatten().next()
}

/// The foot of the flame is seen below the horizon: height / tan(angle).
fn estimate_m(hotbed: &Hotbed, eye_m: f64) -> Option<f64> {
    let below = -f64::from(hotbed.y1.min(hotbed.y2)) / 60.0;
    let distance_m = eye_m / libm::tan(below.to_radians());
    Some(distance_m).filter(|distance_m| below > 0.0 && PLAUSIBLE_M.contains(distance_m))
}

fn ignored(plan: &ControllerPlan, hotbed: &Hotbed) -> bool {
    let degrees = |a: i32, b: i32| f64::from(i32::midpoint(a, b)) / 60.0;
    let (azimuth, elevation) = (degrees(hotbed.x1, hotbed.x2), degrees(hotbed.y1, hotbed.y2));
    plan.ignore.iter().any(|known| libm::hypot(azimuth - known.0, elevation - known.1) < SAME_DEG)
}

fn nothing_found(done: bool) -> Words {
    match done {
        false => text::ControllerLooksAgain.words(),
        true => text::ControllerNothingBurns.words(),
    }
}
