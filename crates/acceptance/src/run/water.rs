//! With water: a monitor at a time opens its valve for a few seconds, toward its target, on a person's yes.

use std::collections::BTreeSet;

use lafet_texts::{Text as _, acceptance as text};

use super::motion::{tenths, toward};
use super::{PERSON_MS, Run, Step};
use crate::check;
use crate::judge::names;
use crate::order::{Drive, Safe, Water, WaterPermit};
use crate::plan;
use crate::wire::{Asks, Person, Wire};

/// A valve opens and closes within, ms.
const VALVE_MS: u64 = 15_000;
/// Water is watched for so long, ms.
const WATCH_MS: u64 = 5000;
/// A turn takes at most, ms.
const TURN_MS: u64 = 60_000;

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn waters(&mut self) -> Step {
        let planned: Vec<plan::Monitor> = self.plan.monitors.clone();
        for monitor in planned.iter().filter(|it| it.flow_lps.is_some() || it.flow_datm.is_some()) {
            self.water(monitor).await?;
        }
        self.used_again().await?;
        self.stations().await
    }

    fn water_not_tried(&mut self, id: &str, why: impl lafet_texts::Text) {
        let why = why.words();
        let checks = [&check::OPENS, &check::FLOW, &check::FLOW_PRESSURE, &check::CLOSES];
        checks.into_iter().for_each(|it| self.not_tried(it, id, why.clone()));
    }

    /// What a lost connection leaves open has to end by itself.
    pub(super) fn ends_by_itself(&self, id: &str) -> bool {
        let params = self.facts.params.get(id).and_then(Option::as_ref);
        let value =
            params.and_then(|it| it.values.get("General")?.get("WaterTimeout")?.values.clone());
        value.and_then(|it| it.first().copied()).is_some_and(|it| it > 0)
    }

    async fn water(&mut self, monitor: &plan::Monitor) -> Step {
        let id = monitor.id.as_str();
        if !self.ends_by_itself(id) {
            self.water_not_tried(id, text::NoWaterTimeout);
            return Ok(());
        }
        let Some(target) = self.plan.target(monitor.target.as_ref()).cloned() else {
            self.water_not_tried(id, text::NoTarget);
            return Ok(());
        };
        let go = text::AskTurn { monitor: id, target: &target.name }.words();
        if !self.agrees(format!("water/{id}/turn"), go, Asks::Go).await? {
            self.water_not_tried(id, text::NoGo);
            return Ok(());
        }
        if let Some(why) = self.hold(id).await? {
            self.water_not_tried(id, why);
            return Ok(());
        }
        self.watered(monitor, &target).await?;
        self.give_back(id).await
    }

    /// Turns a monitor that is held to its target, and opens it.
    async fn watered(&mut self, monitor: &plan::Monitor, target: &plan::Target) -> Step {
        let id = monitor.id.as_str();
        let span = [-10_800.0, 10_800.0];
        let Some([horizontal, vertical]) = toward(monitor, target, span) else {
            self.water_not_tried(id, text::TargetOutside);
            return Ok(());
        };
        for (drive, to) in [(Drive::Horizontal, horizontal), (Drive::Vertical, vertical)] {
            if let Err(why) = self.turn(id, drive, to, TURN_MS).await? {
                self.water_not_tried(id, why);
                return Ok(());
            }
        }
        let words = text::AskWater { monitor: id, target: &target.name }.words();
        if !self.agrees(format!("water/{id}/go"), words, Asks::Water).await? {
            self.water_not_tried(id, text::NoGo);
            return Ok(());
        }
        // A Close that is still being repeated would shut what is opened now.
        let settled = self
            .until(VALVE_MS, |zones, _| {
                let closing = zones.state.monitors.iter().any(|it| it.monitor == id && it.closing);
                (!closing).then_some(())
            })
            .await?;
        if settled.is_none() {
            self.water_not_tried(id, text::StillOn);
            return Ok(());
        }
        let permit = WaterPermit(());
        self.flows(monitor, &permit).await
    }

    async fn flows(&mut self, monitor: &plan::Monitor, permit: &WaterPermit) -> Step {
        let id = monitor.id.as_str();
        let valve = monitor.valve.clone().unwrap_or_else(|| "Valve1".to_owned());
        self.begun.water.insert(id.to_owned());
        self.announce(text::WillOpen { monitor: id, valve: &valve }.words());
        let open = Water::Open { monitor: id.to_owned(), valve: valve.clone() };
        if let Some(why) = self.send(&open.posting(permit)).await? {
            self.begun.water.remove(id);
            self.water_not_tried(id, why);
            return Ok(());
        }
        let opened = self
            .until(VALVE_MS, |_, all| all.get(id).filter(|it| it.has(&valve, "Open")).map(drop))
            .await?;
        let limit = text::AtMostSeconds { value: VALVE_MS / 1000 };
        let measured = match opened {
            Some(((), ms)) => text::Seconds { value: tenths(ms) }.words(),
            None => text::Nothing.words(),
        };
        self.tried(&check::OPENS, id, opened.is_some(), limit, measured);
        let (mut flow, mut pressure) = (None, None);
        let began = self.wire.now_ms();
        while self.wire.now_ms().saturating_sub(began) < WATCH_MS {
            let (_, monitors) = self.look().await?;
            let it = monitors.get(id);
            flow = it.and_then(|it| it.general("flowrate")).or(flow);
            pressure = it.and_then(|it| it.general("pressure")).or(pressure);
            self.pause(super::POLL_MS).await?;
        }
        self.within(&check::FLOW, id, monitor.flow_lps, flow);
        self.within(&check::FLOW_PRESSURE, id, monitor.flow_datm, pressure);
        let words = text::AskRightWater { monitor: id }.words();
        let answer = self.ask(format!("water/{id}/right"), words, Asks::YesNo).await?;
        self.heard(&check::RIGHT_WATER, id, &answer);
        self.ends(id).await
    }

    fn within(
        &mut self,
        check: &'static check::Check,
        id: &str,
        planned: Option<[f64; 2]>,
        found: Option<f64>,
    ) {
        let Some([least, most]) = planned else {
            return self.not_tried(check, id, text::NotPlanned);
        };
        let good = found.is_some_and(|it| (least..=most).contains(&it));
        let limit = text::Between { least, most };
        self.tried(check, id, good, limit, crate::judge::known(found));
    }

    async fn ends(&mut self, id: &str) -> Step {
        let close = Safe::Close { monitor: id.to_owned() };
        self.begun.closed.insert(id.to_owned());
        self.send(&close.posting()).await?;
        let closed = self
            .until(VALVE_MS.max(PERSON_MS / 4), |_, all| {
                let it = all.get(id)?;
                let still = it.general("flowrate").is_none_or(|flow| flow == 0.0);
                (it.not_closed().is_empty() && still).then_some(())
            })
            .await?;
        let limit = text::AtMostSeconds { value: VALVE_MS / 1000 };
        let measured = match closed {
            Some(((), ms)) => text::Seconds { value: tenths(ms) }.words(),
            None => text::StillOn.words(),
        };
        self.tried(&check::CLOSES, id, closed.is_some(), limit, measured);
        if closed.is_some() {
            self.begun.water.remove(id);
        }
        Ok(())
    }

    /// What was closed is used by the zones again, if the person says so: the Close was a no like any other.
    async fn used_again(&mut self) -> Step {
        let zones = self.zones_of_closed();
        if zones.is_empty() {
            return Ok(());
        }
        let list: Vec<&String> = self.begun.closed.iter().collect();
        let words = text::AskUsedAgain { monitors: names(&list), zones: names(&zones) }.words();
        if !self.agrees("water/again".to_owned(), words, Asks::Go).await? {
            return Ok(());
        }
        let settled = self
            .until(VALVE_MS, |zones, _| {
                zones.state.monitors.iter().all(|it| !it.closing).then_some(())
            })
            .await?;
        for zone in zones.iter().filter(|_| settled.is_some()) {
            let (now, _) = self.look().await?;
            if now.zone(zone).is_some_and(|it| it.phase() == "quiet") {
                self.send(&Safe::Reset { zone: zone.clone() }.posting()).await?;
            }
        }
        let (now, _) = self.look().await?;
        let out = now.state.monitors.iter().filter(|it| it.withheld.as_deref() == Some("refused"));
        let out: BTreeSet<&String> = out.map(|it| &it.monitor).collect();
        self.begun.closed.retain(|it| out.contains(it));
        Ok(())
    }

    /// The zones of monitors that were closed.
    pub(super) fn zones_of_closed(&self) -> Vec<String> {
        let all = self.facts.configured.iter().flat_map(|it| &it.zones);
        let of = all.filter(|it| it.monitors.iter().any(|id| self.begun.closed.contains(id)));
        of.map(|it| it.zone.clone()).collect()
    }
}
