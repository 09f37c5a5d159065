//! The test outlet of a zone: people set the mode, hold test sources, abort and put back; the program looks and asks.
//! It orders nothing. In the mode of the test votes open no monitor, and no automatic water is to be had, so it is
//! tried a zone at a time, and what is left in that mode is said.

use lafet_texts::{Shown, Text as _, Words, acceptance as text};

use super::motion::tenths;
use super::watch::{Seen, Trial};
use super::{End, Run, Step};
use crate::check::{self, Check};
use crate::facts::{ConfiguredZone, InstalledZone, Zones};
use crate::judge::{names, wrapped_deg};
use crate::order::part;
use crate::plan;
use crate::wire::{Answer, Asks, Person, Wire};

/// A mode is set within, and a zone is put back within, ms.
const MODE_MS: u64 = 15_000;
const BACK_MS: u64 = 60_000;
/// A detector confirms a source within, ms; what else reports it, does so soon after.
const CONFIRM_MS: u64 = 30_000;
const OTHERS_MS: u64 = 1000;
/// A source that was taken away is not seen any more within, ms.
const GONE_MS: u64 = 60_000;
/// Its bearing is right within, degrees.
const BEARING_DEG: f64 = 3.0;
/// Both sources are held within, and outputs started within so long of the condition, ms.
const BOTH_MS: u64 = 60_000;
const STARTED_MS: u64 = 3000;
/// Times agree within, ms: that of a look, and of a line.
const AGREE_MS: u64 = 1500;
/// A valve opens or closes, and a pump is reported, within, ms.
const ACTS_MS: u64 = 10_000;

/// What hangs on a release.
const OF_RELEASE: [&Check; 8] = [
    &check::RELEASE,
    &check::PUMP_ORDER,
    &check::PUMP_RUNS,
    &check::OUTLET,
    &check::OUTLET_WATER,
    &check::OUTLET_PRESSURE,
    &check::NO_WATER,
    &check::ABORT,
];

/// A zone with a test outlet, as it is there.
struct Zone {
    planned: plan::Zone,
    configured: ConfiguredZone,
    installed: InstalledZone,
}

impl Zone {
    fn id(&self) -> &str {
        &self.planned.id
    }

    fn question(&self, what: &str) -> String {
        format!("outlet/{}/{what}", part(self.id()))
    }
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Each zone of the plan with a test outlet, one after another.
    pub(super) async fn outlets(&mut self) -> Step {
        let planned: Vec<plan::Zone> =
            self.plan.zones.iter().filter(|it| it.test_outlet.is_some()).cloned().collect();
        for zone in planned {
            match self.there(&zone) {
                Some(zone) => self.outlet(&zone).await?,
                None => self.none_tried(&OF_RELEASE, &zone.id, &text::NoOutlet.words()),
            }
        }
        Ok(())
    }

    fn there(&self, planned: &plan::Zone) -> Option<Zone> {
        let mut configured = self.facts.configured.as_ref()?.zones.iter();
        let mut installed = self.facts.installation.as_ref()?.zones.iter();
        Some(Zone {
            planned: planned.clone(),
            configured: configured.find(|it| it.zone == planned.id)?.clone(),
            installed: installed
                .find(|it| it.zone == planned.id && it.test_outlet.is_some())?
                .clone(),
        })
    }

    async fn outlet(&mut self, zone: &Zone) -> Step {
        if let Some(why) = self.enters(zone).await? {
            self.none_tried(&OF_RELEASE, zone.id(), &why);
            return Ok(());
        }
        let mut responding = Vec::new();
        for detector in &zone.configured.detectors {
            if self.source(zone, detector).await? {
                responding.push(detector.clone());
            }
        }
        self.release(zone, &responding).await?;
        self.puts_back(zone).await
    }

    /// Asks for the mode of the test, and waits until it is there. `Some`: why the zone is not tried.
    async fn enters(&mut self, zone: &Zone) -> Step<Option<Words>> {
        let along = self.along(zone);
        let (zones, outlet) =
            (names(&along), zone.installed.test_outlet.clone().unwrap_or_default());
        let words = text::AskOutlet { zone: zone.id(), zones, outlet: &outlet }.words();
        if !self.agrees(zone.question("go"), words).await? {
            return Ok(Some(text::NoGo.words()));
        }
        let mode = self.mode_before(zone);
        self.trial = Some(Trial {
            zone: zone.id().to_owned(),
            detectors: zone.configured.detectors.clone(),
            valve: zone.installed.valve.clone(),
            outlet,
            mode,
            seen: Seen::default(),
        });
        let id = zone.id();
        let tested = |all: &Zones, one: &String| {
            all.zone(one).is_some_and(|it| match one == id {
                true => it.mode == "test_outlet",
                false => it.mode.starts_with("test_"),
            })
        };
        let entered = self
            .watched(MODE_MS, |all, _| along.iter().all(|it| tested(all, it)).then_some(()))
            .await?;
        match entered {
            Some(_) => Ok(None),
            None => {
                self.leave_trial().await;
                Ok(Some(text::NotInTest { zone: id }.words()))
            }
        }
    }

    /// The mode that the zone had before, unless that was one of a test already.
    fn mode_before(&self, zone: &Zone) -> String {
        let before =
            self.facts.zones.as_ref().and_then(|it| it.zone(zone.id())).map(|it| it.mode.clone());
        let before = before.filter(|it| !it.starts_with("test_"));
        before.or(zone.planned.mode.clone()).unwrap_or_else(|| "automatic".to_owned())
    }

    /// The zone, and those that share a detector with it.
    fn along(&self, zone: &Zone) -> Vec<String> {
        let of = |it: &&ConfiguredZone| {
            it.zone == zone.id()
                || it.detectors.iter().any(|id| zone.configured.detectors.contains(id))
        };
        let all = self.facts.configured.iter().flat_map(|it| &it.zones);
        all.filter(of).map(|it| it.zone.clone()).collect()
    }

    /// A detector with a test source in front of it; whether it has seen it.
    async fn source(&mut self, zone: &Zone, id: &str) -> Step<bool> {
        let planned = self.plan.detector(id).cloned().unwrap_or_default();
        let target = self.plan.target(planned.target.as_ref()).cloned();
        let words = match &target {
            Some(target) => text::AskSourceAt { detector: id, target: &target.name }.words(),
            None => text::AskSource { detector: id }.words(),
        };
        if !self.agrees(zone.question(&format!("{}/on", part(id))), words).await? {
            let of = [&check::RESPONDS, &check::ALONE, &check::BEARING, &check::ONE_SIGNAL];
            self.none_tried(&of, id, &text::NoGo.words());
            return Ok(false);
        }
        let seen =
            self.watched(CONFIRM_MS, |all, _| (!all.alarms().is_empty()).then_some(())).await?;
        if seen.is_some() {
            self.pause(OTHERS_MS).await?;
        }
        let zones = self.watch().await?;
        let responds = zones.alarms().contains(&id);
        let limit = text::AtMostSeconds { value: CONFIRM_MS / 1000 };
        match seen.filter(|_| responds) {
            Some(((), ms)) => {
                let measured = text::Seconds { value: tenths(ms) };
                self.tried(&check::RESPONDS, id, true, limit, measured);
            }
            None => self.tried(&check::RESPONDS, id, false, limit, text::NoAlarm),
        }
        let alone = zones.alarms() == [id];
        match seen {
            Some(_) => self.tried(&check::ALONE, id, alone, Shown(id), names(&zones.alarms())),
            None => self.not_tried(&check::ALONE, id, text::NoAlarm),
        }
        self.bearing(&planned, target.as_ref(), &zones, responds);
        self.one_signal(zone, id, &zones, alone);
        self.source_gone(zone, id).await?;
        Ok(responds)
    }

    /// The bearing that a detector reports of a source at a surveyed target.
    fn bearing(
        &mut self,
        planned: &plan::Detector,
        target: Option<&plan::Target>,
        zones: &Zones,
        responds: bool,
    ) {
        let (check, id) = (&check::BEARING, planned.id.as_str());
        let (Some(at), Some(target)) = (planned.at, target) else {
            return self.not_tried(check, id, text::NotPlanned);
        };
        if !responds {
            return self.not_tried(check, id, text::NoAlarm);
        }
        let Some(found) = zones.reported.get(id).and_then(|it| it.bearing_deg) else {
            return self.not_tried(check, id, text::NoBearing);
        };
        let wanted =
            (target.at[0] - at[0]).atan2(target.at[1] - at[1]).to_degrees().rem_euclid(360.0);
        let good = wrapped_deg(found - wanted).abs() <= BEARING_DEG;
        let limit = text::BearingLimit { value: format_args!("{wanted:.1}"), most: BEARING_DEG };
        let measured = text::Degrees { value: format_args!("{found:.1}") };
        self.tried(check, id, good, limit, measured);
    }

    /// A detector alone has released nothing, and nothing is on its way.
    fn one_signal(&mut self, zone: &Zone, id: &str, zones: &Zones, alone: bool) {
        if !alone {
            return self.not_tried(&check::ONE_SIGNAL, id, text::NotAlone);
        }
        let phase = zones.zone(zone.id()).map_or("", |it| it.phase());
        let pump = zones.state.pumps.iter().find(|it| it.on == Some(true));
        let good = phase == "alarm" && pump.is_none();
        let (limit, measured) = (Shown("alarm"), Shown(phase.to_owned()));
        self.tried(&check::ONE_SIGNAL, id, good, limit, measured);
    }

    async fn source_gone(&mut self, zone: &Zone, id: &str) -> Step {
        let words = text::AskSourceGone { detector: id }.words();
        self.agrees(zone.question(&format!("{}/off", part(id))), words).await?;
        let gone = self.watched(GONE_MS, |all, _| all.alarms().is_empty().then_some(())).await?;
        match gone {
            Some(_) => Ok(()),
            None => Err(End::Unsafe(text::StillInAlarm { zone: zone.id() }.words())),
        }
    }

    /// As few detectors as release the zone, of as many kinds as it needs; `None`: there are too few.
    fn voters(&self, zone: &Zone, responding: &[String]) -> Option<Vec<String>> {
        let need = zone.configured.votes.split_once("oo")?.0.parse::<usize>().ok()?;
        let kinds = &self.facts.configured.as_ref()?.detectors;
        let of_kinds = usize::from(zone.configured.kinds);
        let mut chosen: Vec<String> = Vec::new();
        for id in responding {
            let is_new = chosen.iter().all(|it| kinds.get(it) != kinds.get(id));
            if chosen.len() < of_kinds && is_new {
                chosen.push(id.clone());
            }
        }
        if chosen.len() < of_kinds {
            return None;
        }
        for id in responding {
            if chosen.len() < need && !chosen.contains(id) {
                chosen.push(id.clone());
            }
        }
        (chosen.len() >= need).then_some(chosen)
    }

    /// Votes release the zone: times, pumps, outlet, water, and the abort.
    async fn release(&mut self, zone: &Zone, responding: &[String]) -> Step {
        let Some(voters) = self.voters(zone, responding) else {
            self.none_tried(&OF_RELEASE, zone.id(), &text::TooFewVotes.words());
            return Ok(());
        };
        self.trial.iter_mut().for_each(|it| it.seen = Seen::default());
        let (detectors, monitors) = (names(&voters), names(&zone.configured.monitors));
        let words = text::AskVotes { detectors, zone: zone.id(), monitors }.words();
        if !self.agrees(zone.question("votes"), words).await? {
            self.none_tried(&OF_RELEASE, zone.id(), &text::NoGo.words());
            return Ok(());
        }
        let due_ms = due_ms(zone);
        let released =
            self.watched(BOTH_MS + due_ms, |_, seen| seen.released.zip(seen.pending)).await?;
        let limit = text::ReleaseLimit {
            least: tenths(due_ms.saturating_sub(AGREE_MS)),
            most: tenths(due_ms + STARTED_MS),
        };
        let Some(((at, pending), _)) = released else {
            self.tried(&check::RELEASE, zone.id(), false, limit, text::NotReleased);
            self.none_tried(&OF_RELEASE[1..], zone.id(), &text::NotReleased.words());
            return Ok(());
        };
        let took = at.saturating_sub(pending);
        let good = took + AGREE_MS >= due_ms && took <= due_ms + STARTED_MS;
        let measured = text::Seconds { value: tenths(took) };
        self.tried(&check::RELEASE, zone.id(), good, limit, measured);
        self.acts(zone, at).await?;
        self.runs(zone).await?;
        self.abort(zone).await
    }

    /// Pumps and outlet, until they have acted or are late.
    async fn acts(&mut self, zone: &Zone, released: u64) -> Step {
        let wanted = self.pumps_of(zone);
        let most_ms = ACTS_MS + wanted.iter().map(|it| it.late_ms).sum::<u64>();
        self.watched(most_ms, |_, seen| {
            (seen.open.is_some() && wanted.iter().all(|it| it.is_done(seen))).then_some(())
        })
        .await?;
        let Some(trial) = &self.trial else { return Ok(()) };
        let open = trial.seen.open.map(|it| it.saturating_sub(released));
        let limit = text::AtMostSeconds { value: ACTS_MS / 1000 };
        let good = open.is_some_and(|it| it <= ACTS_MS);
        let measured = match open {
            Some(ms) => text::Seconds { value: tenths(ms) }.words(),
            None => text::NotReported.words(),
        };
        self.tried(&check::OUTLET, zone.id(), good, limit, measured);
        self.pumps_acted(zone, &wanted, released);
        Ok(())
    }

    /// The pumps that the water of a zone starts, in their order.
    fn pumps_of(&self, zone: &Zone) -> Vec<Wanted> {
        let all = self.facts.installation.iter().flat_map(|it| &it.pumps);
        let all = all.filter(|it| zone.installed.pumps && !it.standby);
        all.map(|it| {
            let states = self.facts.zones.iter().flat_map(|it| &it.state.pumps);
            let mut states = states.filter(|state| state.pump == it.pump);
            let planned = self.plan.pumps.iter().find(|plan| plan.id == it.pump);
            Wanted {
                id: it.pump.clone(),
                after_ms: u64::from(planned.map_or(it.start_delay_s, |it| it.start_delay_s)) * 1000,
                late_ms: u64::from(it.start_delay_s + it.start_timeout_s) * 1000,
                reports: states.any(|it| it.runs.is_some()),
                gauge: it.pressure.is_some(),
            }
        })
        .collect()
    }

    fn pumps_acted(&mut self, zone: &Zone, wanted: &[Wanted], released: u64) {
        let Some(trial) = &self.trial else { return };
        let seen = &trial.seen;
        if wanted.is_empty() {
            self.none_tried(
                &[&check::PUMP_ORDER, &check::PUMP_RUNS],
                zone.id(),
                &text::NoPumps.words(),
            );
            return;
        }
        let mut before = released;
        let (mut limit, mut measured, mut good) = (Vec::new(), Vec::new(), true);
        for pump in wanted {
            let due = before + pump.after_ms;
            let at = seen.on.get(&pump.id).copied();
            good &= at.is_some_and(|it| it.abs_diff(due) <= AGREE_MS);
            let after = |at: u64| format!("{} +{} s", pump.id, tenths(at.saturating_sub(released)));
            limit.push(after(due));
            measured.push(at.map_or_else(|| format!("{} –", pump.id), after));
            before = at.unwrap_or(due);
        }
        let acted: Vec<(String, bool, bool, bool)> = wanted
            .iter()
            .map(|it| {
                let ran = seen.runs.contains_key(&it.id);
                let pressed = seen.pressure.contains_key(&it.id);
                let strange = seen.strange.contains(&it.id);
                let good = it.is_done(seen) && !strange && !seen.failed.contains(&it.id);
                (it.id.clone(), good, ran, pressed)
            })
            .collect();
        let (limit, measured) = (names(&limit), names(&measured));
        self.tried(&check::PUMP_ORDER, zone.id(), good, limit, measured);
        for (id, good, ran, pressed) in acted {
            let limit = text::PumpRunsLimit;
            let measured =
                text::PumpIs { runs: crate::judge::yes(ran), pressure: crate::judge::yes(pressed) };
            self.tried(&check::PUMP_RUNS, &id, good, limit, measured);
        }
    }

    /// What only a person sees: the water, and its gauge.
    async fn runs(&mut self, zone: &Zone) -> Step {
        let (id, check) = (zone.id(), &check::OUTLET_WATER);
        let outlet = zone.installed.test_outlet.as_deref().unwrap_or_default();
        let words = text::AskOutletWater { outlet, zone: id }.words();
        match self.ask(zone.question("water"), words, Asks::Go).await? {
            Answer::Yes => self.tried(check, id, true, text::OutletAlone, text::Yes),
            Answer::No => self.tried(check, id, false, text::OutletAlone, text::No),
            _ => self.not_tried(check, id, text::NoAnswer),
        }
        let check = &check::OUTLET_PRESSURE;
        let Some([least, most]) = zone.planned.outlet_datm else {
            self.not_tried(check, id, text::NotPlanned);
            return Ok(());
        };
        let words = text::AskOutletPressure { outlet }.words();
        match self.ask(zone.question("pressure"), words, Asks::Pressure).await? {
            Answer::Number(value) => {
                let good = (least..=most).contains(&value);
                let limit = text::Pressures { least, most };
                self.tried(check, id, good, limit, text::Pressure { value });
            }
            _ => self.not_tried(check, id, text::NoAnswer),
        }
        Ok(())
    }

    /// A person aborts: the outlet closes, and the pumps stop.
    async fn abort(&mut self, zone: &Zone) -> Step {
        let stations = self.plan.inputs.iter().filter(|it| it.kind == "abort");
        let stations =
            stations.filter(|it| it.zones.is_empty() || it.zones.iter().any(|at| at == zone.id()));
        let stations: Vec<String> = stations.map(|it| it.id.clone()).collect();
        let words = match stations.is_empty() {
            true => text::AskAbort { zone: zone.id() }.words(),
            false => text::AskAbortAt { zone: zone.id(), stations: names(&stations) }.words(),
        };
        let wet = self.trial.as_ref().is_some_and(|it| it.seen.valve);
        let measured = if wet { text::ZoneValveOpen.words() } else { text::Seen.words() };
        self.tried(&check::NO_WATER, zone.id(), !wet, text::NoWaterLimit, measured);
        if !self.agrees(zone.question("abort"), words).await? {
            self.not_tried(&check::ABORT, zone.id(), text::NoGo);
            return Ok(());
        }
        let run_on = self.facts.installation.as_ref().map_or(0, |it| u64::from(it.run_on_s));
        let outlet = zone.installed.test_outlet.clone().unwrap_or_default();
        let ended = self
            .watched(ACTS_MS + run_on * 1000, |all, _| {
                let shut = all
                    .output(&outlet)
                    .is_some_and(|it| it.on != Some(true) && it.reported != Some(true));
                let off =
                    all.state.pumps.iter().all(|it| it.on != Some(true) && it.runs != Some(true));
                (shut && off).then_some(())
            })
            .await?;
        let limit = text::AtMostSeconds { value: ACTS_MS / 1000 + run_on };
        let measured = match ended {
            Some(((), ms)) => text::Seconds { value: tenths(ms) }.words(),
            None => text::NotEnded.words(),
        };
        self.tried(&check::ABORT, zone.id(), ended.is_some(), limit, measured);
        if ended.is_none() {
            self.person.hear(&text::AbortNow { zone: zone.id() }.words());
        }
        Ok(())
    }

    /// Asks that the zone is put back, and waits until it is.
    async fn puts_back(&mut self, zone: &Zone) -> Step {
        let mode = self.trial.as_ref().map_or_else(String::new, |it| it.mode.clone());
        let monitors = names(&zone.configured.monitors);
        let words = text::AskZoneBack { zone: zone.id(), mode: &mode, monitors }.words();
        self.agrees(zone.question("back"), words).await?;
        let id = zone.id();
        let back = self
            .watched(BACK_MS, |all, _| {
                all.zone(id).filter(|it| it.mode == mode && it.phase() == "quiet").map(drop)
            })
            .await?;
        let measured = if back.is_some() { text::Yes.fixed() } else { text::No.fixed() };
        self.tried(&check::BACK, id, back.is_some(), text::ZoneBackLimit { mode: &mode }, measured);
        if back.is_some() {
            self.trial = None;
        }
        self.leave_trial().await;
        Ok(())
    }

    /// Says of a zone that is left as people have set it, that it is.
    pub(super) async fn leave_trial(&mut self) {
        let Some(Trial { zone, mode, .. }) = self.trial.take() else { return };
        let zones = self.wire.get("/api/zones").await.ok();
        let zones = zones.and_then(|it| serde_json::from_value::<Zones>(it).ok());
        let as_before = |it: &crate::facts::Zone| it.mode == mode && it.phase() == "quiet";
        if !zones.is_some_and(|it| it.zone(&zone).is_some_and(as_before)) {
            self.leave_word(text::LeftZone { zone: &zone, mode: &mode }.words());
        }
    }
}

/// A pump, and what is to be seen of it.
struct Wanted {
    id: String,
    /// It starts so long after the one before.
    after_ms: u64,
    /// It has failed after so long.
    late_ms: u64,
    /// It reports that it runs.
    reports: bool,
    /// It has a contact for its pressure.
    gauge: bool,
}

impl Wanted {
    fn is_done(&self, seen: &Seen) -> bool {
        seen.on.contains_key(&self.id)
            && (!self.reports || seen.runs.contains_key(&self.id))
            && (!self.gauge || seen.pressure.contains_key(&self.id))
    }
}

/// From the votes to the release, ms: by the plan, else as it is configured.
fn due_ms(zone: &Zone) -> u64 {
    let (plan, found) = (&zone.planned, &zone.configured);
    let coincidence = plan.coincidence_s.unwrap_or(found.coincidence_s);
    u64::from(coincidence + plan.delay_s.unwrap_or(found.delay_s)) * 1000
}
