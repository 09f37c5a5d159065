//! A bus: its task, and what is known of its devices.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_site::{Condition, PathFault, Signal};
use lafet_texts::{Text, hub as text};
use tokio::sync::Notify;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::drive::{self, Drive, Drives, Urgency};
use super::line::Link;
use super::maps::{Image, Seen};
use super::plan::{self, Turns};
use super::view::{ModbusBus, ModbusErrors, ModbusProblem, ModbusSource};
use super::watch::{Reading, Rules, Watch};
use super::wire::{Failure, Framing, Request};
use super::{BusConfig, OutputConfig, Sort, SourceConfig};
use crate::clock::ms;
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::sync::lock;
use crate::text::Both;
use crate::zones::view::Reported;

/// Pauses between attempts to open the line.
const PAUSE_FIRST: Duration = Duration::from_millis(200);
const PAUSE_LAST: Duration = Duration::from_secs(5);
/// A connection on which so many requests in a row had no answer is opened again.
const UNANSWERED: u32 = 3;
/// Ages are looked at this often.
const LOOK: Duration = Duration::from_millis(100);
/// A value counts for so many periods and timeouts.
const COUNTS_FOR: u32 = 3;
/// What has not changed is reported this often, or more often for a detector that is soon silent.
const REPEAT: Duration = Duration::from_secs(1);
/// The state of the line is an event this often at most.
const NOTES: Duration = Duration::from_secs(10);

/// A bus.
#[derive(Debug)]
pub struct Bus {
    pub config: BusConfig,
    requests: BTreeMap<u8, Vec<Request>>,
    known: Mutex<Known>,
    pub(super) drive: Mutex<Drive>,
    /// An order has come.
    pub(super) wake: Notify,
    /// Whether a device is written with the functions for several values.
    pub(super) many: Mutex<BTreeMap<u8, bool>>,
}

/// What is known of a bus.
#[derive(Debug, Default)]
struct Known {
    connected: bool,
    answered: Option<Now>,
    requests: u64,
    answers: u64,
    errors: ModbusErrors,
    last_error: Option<ModbusProblem>,
    /// Of each detector, and how it was read when that was last an event.
    watches: Vec<(Watch, Reading)>,
    /// The state that was last an event, and when.
    noted: Option<(Now, bool)>,
}

/// What came of asking a device.
pub struct Asked {
    /// It has answered.
    pub answered: bool,
    /// Something at the other end of the line has.
    pub alive: bool,
    /// The connection is of no use any more.
    pub ended: bool,
    /// Something more urgent came before the end: it says nothing of the device.
    pub interrupted: bool,
}

/// Reads a bus until the hub ends.
pub async fn run(hub: Hub, bus: Arc<Bus>) {
    let mut shutdown = hub.shutdown();
    tokio::select! {
        () = bus.talk(&hub) => {}
        () = bus.look(&hub) => {}
        () = shutdown.requested() => {}
    }
}

impl Bus {
    /// A bus of which nothing is known.
    pub fn new(config: BusConfig) -> Self {
        let period = Duration::from_millis(config.poll_ms + config.timeout_ms);
        let watch = |source: &SourceConfig| {
            let silent = Duration::from_secs(source.silent_after_s.into());
            let rules = Rules {
                counts_for: (COUNTS_FOR * period).min(silent),
                repeat: REPEAT.min(silent / 3),
                beats_within: source.map.beats_within(),
                settles_for: match source.sort {
                    Sort::Detector => Duration::from_secs(config.settle_s.into()),
                    Sort::Contact => Duration::ZERO,
                },
            };
            (Watch::new(rules), Reading::Waiting)
        };
        let known =
            Known { watches: config.sources.iter().map(watch).collect(), ..Known::default() };
        let requests = plan::requests(&config.needs());
        // A late answer is known by its number over TCP; on a serial line one more read excludes it.
        let reads = if config.line.framing() == Framing::Tcp { 1 } else { 2 };
        let drive = Drive::new(&config.outputs, &config.heartbeats, COUNTS_FOR * period, reads);
        let (known, drive, wake) = (Mutex::new(known), Mutex::new(drive), Notify::new());
        Self { config, requests, known, drive, wake, many: Mutex::default() }
    }

    /// The bus as clients see it.
    pub fn view(&self, now: Now) -> ModbusBus {
        let outputs = self.outputs_view(now);
        let known = lock(&self.known);
        let age = |at: Now| ms(now.saturating_sub(at));
        let of = |sort: Sort| {
            let all = self.config.sources.iter().zip(&known.watches);
            let of_sort = all.filter(|(source, _)| source.sort == sort);
            let view = |(source, (watch, _)): (&SourceConfig, &(Watch, Reading))| ModbusSource {
                id: source.id.clone(),
                unit: source.unit,
                reading: watch.reading(now),
                read_ms_ago: watch.age(now).map(ms),
            };
            of_sort.map(view).collect()
        };
        ModbusBus {
            name: self.config.name.clone(),
            url: self.config.line.to_string(),
            connected: known.connected,
            answered_ms_ago: known.answered.map(age),
            requests: known.requests,
            answers: known.answers,
            errors: known.errors,
            last_error: known.last_error.clone(),
            detectors: of(Sort::Detector),
            inputs: of(Sort::Contact),
            outputs,
        }
    }

    /// Opens the line and asks its devices, again and again.
    async fn talk(&self, hub: &Hub) {
        let mut pause = PAUSE_FIRST;
        let period = Duration::from_millis(self.config.poll_ms);
        let mut turns = Turns::new(period, self.requests.keys().copied());
        loop {
            match Link::open(&self.config.line).await {
                Ok(mut link) => {
                    self.opened();
                    turns.restart();
                    if self.serve(hub, &mut link, &mut turns).await {
                        pause = PAUSE_FIRST;
                    }
                    lock(&self.known).connected = false;
                    lock(&self.drive).connects(false);
                }
                Err(what) => {
                    let mut known = lock(&self.known);
                    known.errors.open += 1;
                    let at_ms = hub.clock().now_ms();
                    known.last_error = Some(ModbusProblem { at_ms, unit: None, what });
                }
            }
            sleep(pause).await;
            pause = (pause * 2).min(PAUSE_LAST);
        }
    }

    fn opened(&self) {
        let mut known = lock(&self.known);
        known.connected = true;
        known.watches.iter_mut().for_each(|(watch, _)| watch.breaks());
        drop(known);
        lock(&self.drive).connects(true);
    }

    /// Writes what was ordered and asks the devices until the connection is of no use; whether anything
    /// was answered. Orders go before reads; one that has failed before lets a read pass.
    async fn serve(&self, hub: &Hub, link: &mut Link, turns: &mut Turns) -> bool {
        let (mut answered, mut unanswered, mut tried_again) = (false, 0, false);
        loop {
            let now = hub.now();
            let read = turns.next();
            let due = read.filter(|(_, at)| *at <= now);
            let passes = tried_again && due.is_some();
            let job = lock(&self.drive).next(now).filter(|job| !(job.again && passes));
            let asked = match (job, due) {
                (Some(job), _) => {
                    tried_again = job.again;
                    self.write(hub, link, job).await
                }
                (None, Some((unit, _))) => {
                    tried_again = false;
                    let asked = self.ask(hub, link, unit).await;
                    if !asked.interrupted {
                        turns.asked(unit, now, hub.now(), asked.answered);
                    }
                    asked
                }
                (None, None) => {
                    self.wait(hub, read.map(|(_, at)| at)).await;
                    continue;
                }
            };
            self.report(hub);
            answered |= asked.alive;
            unanswered = match (asked.alive, asked.interrupted) {
                (true, _) => 0,
                (false, true) => unanswered,
                (false, false) => unanswered + 1,
            };
            if asked.ended || unanswered >= UNANSWERED {
                break;
            }
        }
        answered
    }

    /// Waits until something has to be read or written.
    async fn wait(&self, hub: &Hub, read: Option<Now>) {
        let now = hub.now();
        let due = lock(&self.drive).due(now);
        let until = read.into_iter().chain(due).min();
        let woken = self.wake.notified();
        match until {
            Some(at) => drop(timeout(at.saturating_sub(now), woken).await),
            None => woken.await,
        }
    }

    /// Reads what is needed of a device.
    async fn ask(&self, hub: &Hub, link: &mut Link, unit: u8) -> Asked {
        let mut image = Image::new();
        let mut asked = Asked { answered: true, alive: false, ended: false, interrupted: false };
        for request in self.requests.get(&unit).into_iter().flatten() {
            if self.has_more_urgent(hub, Urgency::Waits) {
                asked.interrupted = true;
                return asked;
            }
            match self.exchange(hub, link, request, Urgency::Waits).await {
                Ok(values) => {
                    asked.alive = true;
                    let places = (request.first..=u16::MAX).map(|address| (request.table, address));
                    let read: Vec<_> = places.zip(values).collect();
                    let (now, mut drive) = (hub.now(), lock(&self.drive));
                    read.iter().for_each(|(place, value)| drive.read(now, unit, *place, *value));
                    image.extend(read);
                }
                Err(Failure::GivenUp) => {
                    asked.interrupted = true;
                    return asked;
                }
                // A gateway answers for a device that does not.
                Err(Failure::Exception(10 | 11)) => {
                    (asked.alive, asked.answered) = (true, false);
                    break;
                }
                Err(Failure::Exception(_)) => asked.alive = true,
                Err(failure) => {
                    asked.answered = false;
                    asked.ended = failure.ends(self.config.line.framing());
                    break;
                }
            }
        }
        if !asked.answered {
            lock(&self.drive).breaks(unit);
        }
        let now = hub.now();
        let mut known = lock(&self.known);
        let watches = self.config.sources.iter().zip(&mut known.watches);
        for (source, (watch, _)) in watches.filter(|(source, _)| source.unit == unit) {
            match source.map.seen(&image) {
                Some(seen) => watch.reads(now, seen),
                None => watch.breaks(),
            }
        }
        asked
    }

    pub(super) fn count(&self, hub: &Hub, unit: u8, failure: Option<&Failure>, late: u64) {
        let mut known = lock(&self.known);
        known.requests += 1;
        known.errors.late += late;
        match failure {
            Some(Failure::GivenUp) => {}
            None => {
                known.answers += 1;
                known.answered = Some(hub.now());
            }
            Some(failure) => {
                known.errors.count(failure);
                let (at_ms, what) = (hub.clock().now_ms(), failure.text());
                known.last_error = Some(ModbusProblem { at_ms, unit: Some(unit), what });
            }
        }
    }

    /// Values grow old while nothing is read.
    async fn look(&self, hub: &Hub) {
        let mut ticks = interval(LOOK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            ticks.tick().await;
            let started = lock(&self.drive).beats(hub.zones_work());
            if started {
                self.wake.notify_one();
            }
            self.report(hub);
            if let Some(text) = self.note(hub.now()) {
                hub.event(None, &text);
            }
        }
    }

    /// Reports to the zones what is due.
    fn report(&self, hub: &Hub) {
        let now = hub.now();
        let mut due: Vec<(usize, Option<Seen>, Reading)> = Vec::new();
        let mut events = Vec::new();
        {
            let mut known = lock(&self.known);
            for (index, (watch, before)) in known.watches.iter_mut().enumerate() {
                let after = watch.reading(now);
                let seen = watch.due(now);
                if seen.is_some() || watch.misses(now) {
                    due.push((index, seen, after));
                }
                let before = std::mem::replace(before, after);
                let source = &self.config.sources[index];
                events.extend(self.words(source, before, after));
            }
        }
        for (index, seen, reading) in due {
            let source = &self.config.sources[index];
            let caller = Caller::modbus(&self.config.name, source.unit);
            match (source.sort, seen) {
                (Sort::Detector, Some(seen)) => report_detector(hub, &caller, &source.id, seen),
                // It is silent after its time.
                (Sort::Detector, None) => {}
                (Sort::Contact, seen) => report_contact(hub, &caller, &source.id, seen, reading),
            }
        }
        events.iter().for_each(|text| hub.event(None, text));
        self.report_outputs(hub);
    }

    /// What people should know of an output.
    pub(super) fn output_words(&self, output: &OutputConfig, trouble: drive::Trouble) -> Both {
        let news: &dyn Text = match trouble {
            drive::Trouble::Lost => &text::BusReadingLost,
            drive::Trouble::Fault => &text::BusOutputFault,
            drive::Trouble::Dropped => &text::BusOutputDropped,
            drive::Trouble::Refused => &text::BusOutputRefused,
        };
        let sort: &dyn Text = match output.drives {
            Drives::Pump => &text::BusPump,
            _ => &text::BusOutput,
        };
        let (id, bus, unit) = (&output.id, &self.config.name, output.unit);
        text::BusReading { sort, id, bus, unit, news }.words()
    }

    /// What people should know of a detector that is read otherwise than before.
    fn words(&self, source: &SourceConfig, before: Reading, after: Reading) -> Option<Both> {
        let failed = |it| matches!(it, Reading::Lost | Reading::Frozen);
        let news: &dyn Text = match after {
            _ if before == after => return None,
            Reading::Lost => &text::BusReadingLost,
            Reading::Frozen => &text::BusReadingFrozen,
            _ if failed(before) => &text::BusReadingBack,
            _ => return None,
        };
        let (id, bus, unit) = (&source.id, &self.config.name, source.unit);
        let sort: &dyn Text = match source.sort {
            Sort::Detector => &text::BusDetector,
            Sort::Contact => &text::BusInput,
        };
        Some(text::BusReading { sort, id, bus, unit, news }.words())
    }

    /// The state of the line, if it is news.
    fn note(&self, now: Now) -> Option<Both> {
        let mut known = lock(&self.known);
        let (connected, name) = (known.connected, &self.config.name);
        let due = match known.noted {
            Some((at, noted)) => noted != connected && now >= at + NOTES,
            None => connected || known.last_error.is_some(),
        };
        if !due {
            return None;
        }
        known.noted = Some((now, connected));
        if connected {
            return Some(text::BusOpen { name }.words());
        }
        let why = known.last_error.as_ref().map(|it| it.what.clone()).unwrap_or_default();
        Some(text::BusLost { name, why }.words())
    }
}

fn report_detector(hub: &Hub, caller: &Caller, id: &str, seen: Seen) {
    let reported = Reported {
        heard: hub.now(),
        at_ms: hub.clock().now_ms(),
        by: caller.principal.user.clone(),
        signal: seen.signal,
        condition: seen.condition,
        bearing_deg: seen.bearing_deg,
        elevation_deg: seen.elevation_deg,
        quality: None,
    };
    // Detectors are of zones: there are some.
    _ = hub.detector_reports(caller, id, reported);
}

/// A contact whose line or device is at fault stays as it was, for the machine.
fn report_contact(hub: &Hub, caller: &Caller, id: &str, seen: Option<Seen>, reading: Reading) {
    let fault = match (seen, reading) {
        (Some(seen), Reading::Good) if seen.condition == Condition::Ready => None,
        (Some(_), Reading::Good) => Some(PathFault::Open),
        _ => Some(PathFault::Lost),
    };
    // Before its heartbeat was seen to change, and when it changes no longer, only what says no is heard.
    let heard = matches!(reading, Reading::Good | Reading::Unproven | Reading::Frozen);
    let pressed = heard && seen.is_some_and(|seen| seen.signal == Signal::Alarm);
    hub.contact_reports(caller, id, pressed, fault);
}

#[cfg(test)]
mod tests {
    use lafet_site::{Hand, Refusal};
    use serde_json::Value;

    use super::*;
    use crate::Clock;
    use crate::zones::configured;

    const HALL: &str = r#"
        [[monitor]]
        id = "M1"
        url = "tcp://127.0.0.1:1?addr=1"
        [[modbus]]
        name = "panel"
        url = "tcp://127.0.0.1:2"
        [[detector]]
        id = "flame"
        kind = "flame"
        zones = ["hall"]
        [[aim]]
        zone = "hall"
        monitor = "M1"
        horizontal = 600
        vertical = 300
        nozzle = 60
        [[zone]]
        id = "hall"
        votes = "1oo1"
        one_detector_releases = true
        water_max_s = 60
        monitors = ["M1"]
        [[input]]
        id = "abort"
        kind = "abort"
        zones = ["hall"]
        source = { modbus = "panel", unit = 1, on = "discrete:0", heartbeat = "discrete:1", heartbeat_s = 9 }
    "#;

    /// Its program has stopped, and its inputs are read still.
    #[tokio::test]
    async fn what_says_no_is_heard_from_a_device_that_is_frozen_and_the_fault_stays() {
        let pressed = |signal| {
            let (condition, beat) = (Condition::Fault, Some(true));
            Seen { signal, condition, beat, bearing_deg: None, elevation_deg: None }
        };
        for (signal, reading, refused) in [
            (Signal::Alarm, Reading::Frozen, true),
            (Signal::Quiet, Reading::Frozen, false),
            (Signal::Alarm, Reading::Lost, false),
        ] {
            let hub = Hub::new(configured(HALL), Clock::System, Value::Null).unwrap();
            report_contact(&hub, &Caller::hub(), "abort", Some(pressed(signal)), reading);
            let state = hub.zones_view().unwrap().state;
            let troubles = state.troubles.iter().filter(|it| it.subject == "abort" && it.active);
            assert_eq!(troubles.count(), 1, "{reading:?}");
            let order = Hand::Release { zone: "hall".into() };
            let released = hub.order_zones(&Caller::hub(), order);
            let expected = refused.then(|| Refusal::AbortPressed.text().en);
            assert_eq!(released.err().map(|it| it.text.en), expected, "{signal:?} {reading:?}");
        }
    }
}
