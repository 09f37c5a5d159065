//! Dry, a zone at a time, in its test mode: detectors with a test source, votes, delay, monitors, abort, stations.

use std::collections::BTreeSet;

use lafet_texts::{Shown, Text as _, Words, acceptance as text};

use super::motion::{degrees, tenths, toward};
use super::{End, PERSON_MS, Run, Step, Under};
use crate::check;
use crate::facts::{AuditLog, ConfiguredZone, Zones};
use crate::judge::{COINCIDENCE_S, DETECT_S, REACTION_S, names, wrapped_deg};
use crate::order::{Dry, Former, Safe};
use crate::wire::{Asks, Person, Wire};

/// A test mode lasts so long, s, and is renewed when less is left, ms.
pub(super) const TEST_S: u32 = 900;
const RENEW_LEFT_MS: u64 = 300_000;
/// One vote is watched for so long, ms.
const ONE_MS: u64 = 2000;
/// What follows an order of the zone follows within, ms.
pub(super) const FOLLOWS_MS: u64 = 10_000;
/// A button that was not seen is pressed so often in all.
pub(super) const PRESSES: usize = 2;
/// Monitors turn within, ms, and to so near, degrees.
const AIM_MS: u64 = 60_000;
const AIM_DEG: f64 = 5.0;
/// Times that are seen from outside may differ by, s.
const SEEN_S: f64 = 0.5;
/// A time that is known no better than this is not known, s.
const VAGUE_S: f64 = 2.0;
/// The bearing of a detector may be wrong by, degrees, if the plan does not say.
const BEARING_DEG: f64 = 3.0;

/// The test of a zone.
pub(super) enum Test<'a> {
    /// Switched off: nothing releases.
    Off,
    /// Votes turn monitors.
    Dry,
    /// Votes start pumps and open the outlet.
    Outlet(&'a crate::order::OutletPermit),
}

impl Test<'_> {
    const fn mode(&self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Dry => "test_dry",
            Self::Outlet(_) => "test_outlet",
        }
    }
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn zones_dry(&mut self) -> Step {
        let zones = self.facts.configured.clone().unwrap_or_default().zones;
        for zone in &zones {
            let go = text::AskZone { zone: &zone.zone }.words();
            if !self.agrees(format!("dry/{}/go", zone.zone), go, Asks::Go).await? {
                self.zone_not_tried(&zone.zone, text::NoGo.words());
                continue;
            }
            if let Some(why) = self.enter(&zone.zone, Test::Dry).await? {
                self.zone_not_tried(&zone.zone, why);
                continue;
            }
            self.expected = zone.detectors.iter().cloned().collect();
            let stowed = self.stowed(zone).await?;
            self.release(zone).await?;
            self.leave(&zone.zone).await?;
            self.expected.clear();
            for monitor in &stowed {
                self.stow_again(monitor).await?;
            }
        }
        Ok(())
    }

    fn zone_not_tried(&mut self, zone: &str, why: Words) {
        let checks = [&check::ONE_SIGNAL, &check::COINCIDES, &check::DELAYS, &check::REACTION];
        let more = [&check::ENGAGED, &check::AIMED, &check::ABORT];
        checks.into_iter().chain(more).for_each(|it| self.not_tried(it, zone, why.clone()));
    }

    /// Puts a zone into a test. `Some`: why it is not.
    pub(super) async fn enter(&mut self, zone: &str, test: Test<'_>) -> Step<Option<Words>> {
        let (zones, _) = self.look().await?;
        let state = zones.zone(zone).filter(|it| it.phase() == "quiet" && !zones.state.lockout);
        let Some(state) = state else {
            return Ok(Some(text::ZoneNotQuiet { zone }.words()));
        };
        // The end of the test resets the zone, which would withdraw this no.
        if let Some(monitor) = self.refused(&zones, zone) {
            return Ok(Some(text::MonitorRefused { monitor: &monitor }.words()));
        }
        let former = Former {
            mode: state.mode.clone(),
            for_s: state.returns_in_ms.and_then(|ms| u32::try_from(ms.div_ceil(1000)).ok()),
        };
        let refused = match &test {
            Test::Off => self.order(Dry::Off { zone: zone.to_owned(), for_s: TEST_S }).await?,
            Test::Dry => self.order(Dry::Test { zone: zone.to_owned(), for_s: TEST_S }).await?,
            Test::Outlet(permit) => {
                self.announce(text::WillTestOutlet { zone }.words());
                let order = crate::order::Outlet::Test { zone: zone.to_owned(), for_s: TEST_S };
                self.send(&order.posting(permit)).await?
            }
        };
        if refused.is_none() {
            let sources = !matches!(test, Test::Off);
            let under = Under { former, mode: test.mode(), sources };
            self.begun.zones.insert(zone.to_owned(), under);
        }
        Ok(refused)
    }

    /// A monitor of a zone that a person has closed or stopped.
    pub(super) fn refused(&self, zones: &Zones, id: &str) -> Option<String> {
        let configured = self.facts.configured.as_ref()?;
        let of = configured.zones.iter().find(|it| it.zone == id)?;
        let refused = |it: &&crate::facts::ZoneMonitor| {
            let by_person = !self.begun.closed.contains(&it.monitor);
            it.withheld.as_deref() == Some("refused")
                && by_person
                && of.monitors.contains(&it.monitor)
        };
        zones.state.monitors.iter().find(refused).map(|it| it.monitor.clone())
    }

    /// A long test keeps its mode.
    pub(super) async fn keep_testing(&mut self, id: &str) -> Step {
        let (zones, _) = self.look().await?;
        let left = zones.zone(id).and_then(|it| it.returns_in_ms);
        if left.is_none_or(|it| it < RENEW_LEFT_MS) {
            let (zone, for_s) = (id.to_owned(), TEST_S);
            let order = match self.begun.zones.get(id).map(|it| it.mode) {
                Some("test_dry") => Dry::Test { zone, for_s },
                Some("off") => Dry::Off { zone, for_s },
                _ => return Ok(()),
            };
            self.send(&order.posting()).await?;
        }
        Ok(())
    }

    /// Detectors one by one, until the votes release; then what the release does.
    async fn release(&mut self, zone: &ConfiguredZone) -> Step {
        let order = self.in_order(zone);
        self.phases.remove(&zone.zone);
        let before = self.last_entry().await?;
        let need = zone.votes.split_once("oo").and_then(|(need, _)| need.parse::<usize>().ok());
        let need = need.unwrap_or(usize::MAX).max(usize::from(zone.kinds));
        let mut seen = 0;
        let mut released = false;
        for detector in &order {
            self.keep_testing(&zone.zone).await?;
            if !self.detector(zone, detector).await? {
                continue;
            }
            seen += 1;
            if seen == 1 {
                self.one_signal(zone).await?;
            }
            if seen == need && !released {
                released = self.votes_release(zone).await?;
            }
        }
        if released {
            let engaged = self.engaged(zone, &check::ENGAGED, before).await?;
            self.aimed(zone, engaged).await?;
            self.sounder(zone).await?;
        } else {
            let why =
                if seen < need { text::TooFewSeen.words() } else { text::NotReleased.words() };
            if seen < need {
                self.zone_not_tried(&zone.zone, why);
            } else {
                let checks = [&check::REACTION, &check::ENGAGED, &check::AIMED];
                checks.into_iter().for_each(|it| self.not_tried(it, &zone.zone, why.clone()));
            }
        }
        if released {
            self.aborts(zone).await?;
        }
        self.clear(zone).await
    }

    /// Detectors of a zone, those of different kinds first.
    fn in_order(&self, zone: &ConfiguredZone) -> Vec<String> {
        let kinds = self.facts.configured.as_ref().map(|it| &it.detectors);
        let mut had = BTreeSet::new();
        let (mut first, mut rest) = (Vec::new(), Vec::new());
        for id in &zone.detectors {
            let kind = kinds.and_then(|it| it.get(id));
            if had.insert(kind) { first.push(id.clone()) } else { rest.push(id.clone()) }
        }
        first.append(&mut rest);
        first
    }

    /// A test source at a detector; whether it was reported.
    async fn detector(&mut self, zone: &ConfiguredZone, id: &str) -> Step<bool> {
        let planned = self.plan.detector(id).cloned().unwrap_or_default();
        let target = self.plan.target(planned.target.as_ref()).cloned();
        let (before, _) = self.look().await?;
        let before: BTreeSet<String> = before.alarms().into_iter().map(str::to_owned).collect();
        let words = match &target {
            Some(target) => text::AskSourceAt { detector: id, target: &target.name }.words(),
            None => text::AskSource { detector: id }.words(),
        };
        if !self.agrees(format!("dry/{}/detector/{id}", zone.zone), words, Asks::Act).await? {
            self.not_tried(&check::TEST_SOURCE, id, text::NoAnswer);
            self.not_tried(&check::BEARING, id, text::NoAnswer);
            return Ok(false);
        }
        let within_s = planned.within_s.unwrap_or(DETECT_S);
        let new = |zones: &Zones| -> Vec<String> {
            let all = zones.alarms().into_iter().filter(|it| !before.contains(*it));
            all.map(str::to_owned).collect()
        };
        let seen = self
            .until((within_s * 1000.0) as u64, |zones, _| {
                Some(new(zones)).filter(|it| !it.is_empty())
            })
            .await?;
        let limit = text::SourceLimit { detector: id, value: within_s };
        let Some((found, took)) = seen else {
            self.tried(&check::TEST_SOURCE, id, false, limit, text::Nothing);
            self.not_tried(&check::BEARING, id, text::NotReported);
            return Ok(false);
        };
        let good = found == [id.to_owned()];
        let measured = text::SourceIs { detectors: names(&found), value: tenths(took) };
        self.tried(&check::TEST_SOURCE, id, good, limit, measured);
        if good {
            self.bearing(id, &planned, target.as_ref()).await?;
        } else {
            self.not_tried(&check::BEARING, id, text::OtherDetector);
        }
        Ok(true)
    }

    async fn bearing(
        &mut self,
        id: &str,
        planned: &crate::plan::Detector,
        target: Option<&crate::plan::Target>,
    ) -> Step {
        let (Some(at), Some(target)) = (planned.at, target) else {
            self.not_tried(&check::BEARING, id, text::NotPlanned);
            return Ok(());
        };
        let (zones, _) = self.look().await?;
        let most = planned.bearing_error_deg.unwrap_or(BEARING_DEG);
        let wanted =
            (target.at[0] - at[0]).atan2(target.at[1] - at[1]).to_degrees().rem_euclid(360.0);
        let limit = text::BearingLimit { bearing: format!("{wanted:.1}"), value: most };
        let found = zones.reported.get(id).and_then(|it| it.bearing_deg);
        let good = found.is_some_and(|it| wrapped_deg(it - wanted).abs() <= most);
        let measured = found.map_or_else(|| text::NoBearing.words(), degrees);
        self.tried(&check::BEARING, id, good, limit, measured);
        Ok(())
    }

    /// With one detector in alarm nothing comes of it.
    async fn one_signal(&mut self, zone: &ConfiguredZone) -> Step {
        let id = zone.zone.as_str();
        let more = self
            .until(ONE_MS, |zones, _| {
                let phase = zones.zone(id)?.phase();
                (!matches!(phase, "alarm" | "quiet")).then(|| phase.to_owned())
            })
            .await?;
        let measured = more.as_ref().map_or_else(|| "alarm".to_owned(), |(phase, _)| phase.clone());
        self.tried(&check::ONE_SIGNAL, id, more.is_none(), Shown("alarm"), Shown(measured));
        Ok(())
    }

    /// Enough votes: coincidence, delay, release, each as long as planned; whether it is released.
    async fn votes_release(&mut self, zone: &ConfiguredZone) -> Step<bool> {
        let id = zone.zone.as_str();
        let planned = self.plan.zones.iter().find(|it| it.id == id);
        let coincidence_s = planned.and_then(|it| it.coincidence_s).unwrap_or(COINCIDENCE_S);
        let planned_delay = planned.and_then(|it| it.delay_s);
        let most_s =
            zone.coincidence_s.max(coincidence_s) + zone.delay_s.max(planned_delay.unwrap_or(0));
        let phase = |zones: &Zones, of: &[&str]| {
            zones.zone(id).filter(|it| of.contains(&it.phase())).map(drop)
        };
        let after = ["coincidence", "countdown", "held", "released"];
        let wait_ms = u64::from(most_s) * 1000 + FOLLOWS_MS;
        let met = self.until(FOLLOWS_MS, |zones, _| phase(zones, &after)).await?;
        let released = match met {
            Some(_) => self.until(wait_ms, |zones, _| phase(zones, &after[3..])).await?,
            None => None,
        };
        // A phase that was passed between two looks began with the next one.
        let seen = self.phases.get(id).map(|it| it.1.clone()).unwrap_or_default();
        let began = |of: &[&str]| of.iter().find_map(|it| seen.get(*it)).copied();
        let times = (began(&after), began(&after[1..]), began(&after[3..]));
        let (Some(met_at), Some(counts_at), Some(released_at), true) =
            (times.0, times.1, times.2, released.is_some())
        else {
            let (limit, measured) = (text::ReleasedLimit, text::NotReleased);
            self.tried(&check::COINCIDES, id, false, limit, measured);
            self.not_tried(&check::DELAYS, id, text::NotReleased);
            return Ok(false);
        };
        let least = f64::from(coincidence_s.max(COINCIDENCE_S));
        let coincided = Span::between(met_at, counts_at);
        let limit = text::AboutSeconds { value: least, off: SEEN_S };
        let good = coincided.may_be(f64::from(coincidence_s)) && coincided.most_s >= least - SEEN_S;
        self.timed(&check::COINCIDES, id, coincided, good, limit);
        let delayed = Span::between(counts_at, released_at);
        match planned_delay {
            None => self.not_tried(&check::DELAYS, id, text::NotPlanned),
            Some(value) => {
                let limit = text::AboutSeconds { value, off: SEEN_S };
                let good = delayed.may_be(f64::from(value));
                self.timed(&check::DELAYS, id, delayed, good, limit);
            }
        }
        self.reaction(id).await?;
        Ok(true)
    }

    /// Notes a time, if the looks were close enough together to know it.
    fn timed(
        &mut self,
        check: &'static check::Check,
        id: &str,
        span: Span,
        good: bool,
        limit: impl lafet_texts::Text,
    ) {
        if good && span.most_s - span.least_s > VAGUE_S {
            self.not_tried(check, id, text::TooSeldom);
        } else {
            self.tried(check, id, good, limit, span.words());
        }
    }

    async fn reaction(&mut self, id: &str) -> Step {
        let (zones, _) = self.look().await?;
        let limit = text::AtMostSeconds { value: REACTION_S };
        match zones.zone(id).and_then(|it| it.reacted_in_ms) {
            None => self.tried(&check::REACTION, id, false, limit, text::Unknown),
            Some(ms) => {
                let good = ms as f64 <= REACTION_S * 1000.0;
                let measured = text::Seconds { value: format!("{:.3}", ms as f64 / 1000.0) };
                self.tried(&check::REACTION, id, good, limit, measured);
            }
        }
        Ok(())
    }

    /// The latest entry of the audit log.
    pub(super) async fn last_entry(&mut self) -> Step<u64> {
        let log = self.get::<AuditLog>("/api/audit?limit=1").await?.unwrap_or_default();
        Ok(log.entries.first().map_or(0, |it| it.n))
    }

    /// All planned monitors are ordered to the fire of the zone after an entry of the audit log: in a test each
    /// of them turns, `jets` limits the water alone.
    async fn engaged(
        &mut self,
        zone: &ConfiguredZone,
        check: &'static check::Check,
        after: u64,
    ) -> Step<Vec<String>> {
        let id = zone.zone.as_str();
        let planned = self.plan.zones.iter().find(|it| it.id == id);
        let monitors = planned.map(|it| &it.monitors).filter(|it| !it.is_empty());
        let wanted: BTreeSet<String> = monitors.unwrap_or(&zone.monitors).iter().cloned().collect();
        let began = self.wire.now_ms();
        let found: BTreeSet<String> = loop {
            let log = self.get::<AuditLog>("/api/audit?limit=200").await?.unwrap_or_default();
            let new = log.entries.iter().filter(|it| it.n > after);
            let found: BTreeSet<String> = new.filter_map(|it| it.ordered(id)).collect();
            let late = self.wire.now_ms().saturating_sub(began) > FOLLOWS_MS;
            if found == wanted || late {
                break found;
            }
            self.look().await?;
            self.pause(super::POLL_MS).await?;
        };
        let list = |all: &BTreeSet<String>| all.iter().cloned().collect::<Vec<String>>();
        let limit = text::EngagedLimit { count: wanted.len(), monitors: names(&list(&wanted)) };
        self.tried(check, id, found == wanted, limit, names(&list(&found)));
        Ok(list(&found))
    }

    /// The engaged monitors turn to where the plan aims, or to the test source.
    async fn aimed(&mut self, zone: &ConfiguredZone, engaged: Vec<String>) -> Step {
        let (_, monitors) = self.look().await?;
        for id in engaged {
            let mut wanted: Vec<f64> = Vec::new();
            let aims = self.plan.aims.iter();
            let aim = aims.filter(|it| it.zone == zone.zone && it.monitor == id);
            wanted.extend(aim.map(|it| f64::from(it.horizontal)));
            let limits = monitors.get(&id).and_then(|it| it.limits.as_ref()?.get("Horizontal"));
            let span = limits.map_or([-10_800.0, 10_800.0], |it| [it.min, it.max]);
            let planned = self.plan.monitors.iter().find(|it| it.id == id);
            let detectors = zone.detectors.iter().filter_map(|it| self.plan.detector(it));
            let targets = detectors.filter_map(|it| self.plan.target(it.target.as_ref()));
            let of_targets = targets.filter_map(|it| toward(planned?, it, span)).map(|it| it[0]);
            wanted.extend(of_targets);
            let subject = format!("{} {id}", zone.zone);
            if wanted.is_empty() {
                self.not_tried(&check::AIMED, &subject, text::NotPlanned);
                continue;
            }
            let near = |at: f64| wanted.iter().any(|it| (it - at).abs() <= AIM_DEG * 60.0);
            let seen = self
                .until(AIM_MS, |_, all| all.get(&id)?.position("Horizontal").filter(|at| near(*at)))
                .await?;
            let (_, monitors) = self.look().await?;
            let at = monitors.get(&id).and_then(|it| it.position("Horizontal"));
            let list: Vec<String> = wanted.iter().map(|it| format!("{:.0}°", it / 60.0)).collect();
            let limit = text::AimLimit { at: names(&list), value: AIM_DEG };
            let measured = at.map_or_else(|| text::Unknown.words(), |at| degrees(at / 60.0));
            self.tried(&check::AIMED, &subject, seen.is_some(), limit, measured);
        }
        Ok(())
    }

    async fn sounder(&mut self, zone: &ConfiguredZone) -> Step {
        let id = zone.zone.as_str();
        let mut sounders = self.plan.outputs.iter().filter(|it| it.kind == "sounder");
        if !sounders.any(|it| it.zone.as_ref().is_none_or(|of| of == id)) {
            self.not_tried(&check::SOUNDER, id, text::NotPlanned);
            return Ok(());
        }
        let words = text::AskSounder { zone: id }.words();
        let answer = self.ask(format!("dry/{id}/sounder"), words, Asks::YesNo).await?;
        self.heard(&check::SOUNDER, id, &answer);
        Ok(())
    }

    /// Notes a yes or no.
    pub(super) fn heard(
        &mut self,
        check: &'static check::Check,
        subject: &str,
        answer: &crate::wire::Answer,
    ) {
        use crate::wire::Answer;
        let yes = crate::judge::yes(true);
        match answer {
            Answer::Yes => self.tried(check, subject, true, yes, yes),
            Answer::No => self.tried(check, subject, false, yes, crate::judge::yes(false)),
            _ => self.not_tried(check, subject, text::NoAnswer),
        }
    }

    /// Each abort and stop contact of the plan ends the release; without any, the abort of the hub.
    async fn aborts(&mut self, zone: &ConfiguredZone) -> Step {
        let id = zone.zone.as_str();
        let inputs = self.plan.inputs_of(id, &["abort", "stop"]);
        let inputs: Vec<String> = inputs.map(|it| it.id.clone()).collect();
        let ended = |zones: &Zones| {
            zones.zone(id)?.ended().filter(|it| matches!(*it, "abort" | "stop")).map(str::to_owned)
        };
        if inputs.is_empty() {
            self.send(&Safe::Abort { zone: id.to_owned() }.posting()).await?;
            let seen = self.until(FOLLOWS_MS, |zones, _| ended(zones)).await?;
            self.tried(&check::ABORT, id, seen.is_some(), text::AbortLimit, seen_phase(seen));
            return Ok(());
        }
        for (number, input) in inputs.iter().enumerate() {
            self.keep_testing(id).await?;
            // What does not arrive as a no may arrive as a release, which ends the test.
            if !self.has_passed(&check::CONTACT, input) {
                self.not_tried(&check::ABORT, input, text::ContactUnsure);
                continue;
            }
            if number > 0 && !self.again(id).await? {
                self.not_tried(&check::ABORT, input, text::NotReleased);
                continue;
            }
            let words = text::AskAbort { input }.words();
            let mut seen = None;
            let mut done = false;
            for _ in 0..PRESSES {
                let (words, question) = (words.clone(), format!("dry/{id}/input/{input}"));
                done = self.agrees(question, words, Asks::Act).await?;
                if done && seen.is_none() {
                    seen = self.until(FOLLOWS_MS, |zones, _| ended(zones)).await?;
                }
                if !done || seen.is_some() {
                    break;
                }
            }
            if !done {
                self.not_tried(&check::ABORT, input, text::NoAnswer);
                continue;
            }
            self.tried(&check::ABORT, input, seen.is_some(), text::AbortLimit, seen_phase(seen));
        }
        self.send(&Safe::Abort { zone: id.to_owned() }.posting()).await?;
        Ok(())
    }

    /// The votes that stand count once more; whether they do.
    async fn again(&mut self, id: &str) -> Step<bool> {
        self.withdraw(id).await?;
        let counts = ["coincidence", "countdown", "held", "released"];
        let seen = self
            .until(FOLLOWS_MS, |zones, _| {
                zones.zone(id).filter(|it| counts.contains(&it.phase())).map(drop)
            })
            .await?;
        Ok(seen.is_some())
    }

    /// Withdraws the abort of a zone under test, as soon as its contacts are released.
    pub(super) async fn withdraw(&mut self, id: &str) -> Step {
        let began = self.wire.now_ms();
        loop {
            let (zones, _) = self.look().await?;
            if let Some(monitor) = self.refused(&zones, id) {
                return Err(End::Unsafe(text::MonitorRefused { monitor: &monitor }.words()));
            }
            let refused = match zones.zone(id).is_some_and(|it| it.ended().is_some()) {
                true => self.send(&Safe::Reset { zone: id.to_owned() }.posting()).await?,
                false => None,
            };
            if refused.is_none() || self.wire.now_ms().saturating_sub(began) > PERSON_MS {
                return Ok(());
            }
            self.pause(500).await?;
        }
    }

    /// The test sources are taken away.
    pub(super) async fn clear(&mut self, zone: &ConfiguredZone) -> Step {
        let id = zone.zone.as_str();
        let (zones, _) = self.look().await?;
        if zones.alarms().is_empty() {
            return Ok(());
        }
        let words = text::AskClear { zone: id }.words();
        self.ask(format!("dry/{id}/clear"), words, Asks::Act).await?;
        let quiet =
            self.until(2 * PERSON_MS, |zones, _| zones.alarms().is_empty().then_some(())).await?;
        match quiet {
            Some(_) => Ok(()),
            None => Err(End::Unsafe(text::StillAlarms { zone: id }.words())),
        }
    }
}

/// How long something lasted, by looks that are some time apart, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub least_s: f64,
    pub most_s: f64,
}

impl Span {
    /// Between two changes, each with the look before it and the look that has seen it.
    pub(super) fn between(from: [u64; 2], to: [u64; 2]) -> Self {
        let seconds = |from: u64, to: u64| to.saturating_sub(from) as f64 / 1000.0;
        Self { least_s: seconds(from[1], to[0]), most_s: seconds(from[0], to[1]) }
    }

    fn may_be(self, value: f64) -> bool {
        self.least_s - SEEN_S <= value && value <= self.most_s + SEEN_S
    }

    fn words(self) -> Words {
        let value = format!("{:.1} … {:.1}", self.least_s, self.most_s);
        text::Seconds { value }.words()
    }
}

fn seen_phase(seen: Option<(String, u64)>) -> Words {
    match seen {
        Some((phase, took)) => text::PhaseAfter { phase, value: tenths(took) }.words(),
        None => text::Nothing.words(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_known_as_well_as_it_was_looked() {
        let span = Span::between([1000, 1100], [6900, 7000]);
        assert!((span.least_s - 5.8).abs() < 1e-9 && (span.most_s - 6.0).abs() < 1e-9);
        assert!(span.may_be(6.0) && !span.may_be(5.0) && !span.may_be(7.0));
        assert!(Span::between([1000, 1100], [1000, 1100]).may_be(0.0));
        assert!(!Span::between([1000, 1100], [1000, 1100]).may_be(1.0));
    }
}
