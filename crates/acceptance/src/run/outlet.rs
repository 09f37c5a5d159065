//! With the test outlet: votes start pumps and open the outlet of the zone; monitors stay closed.

use std::collections::BTreeMap;

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::motion::tenths;
use super::zone::{Span, Test};
use super::{PERSON_MS, Run, Step};
use crate::check;
use crate::facts::{ConfiguredZone, InstalledPump};
use crate::judge::names;
use crate::order::{OutletPermit, Safe};
use crate::wire::{Answer, Asks, Person, Wire};

/// Delays between pumps may differ by, s.
const SEEN_S: f64 = 1.5;
/// An outlet is reported open or closed within, ms.
const VALVE_MS: u64 = 15_000;

/// The looks between which a pump began to run and to give pressure, ms.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    runs: Option<[u64; 2]>,
    pressure: Option<[u64; 2]>,
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn outlets(&mut self) -> Step {
        let zones = self.facts.configured.clone().unwrap_or_default().zones;
        for zone in &zones {
            let id = zone.zone.as_str();
            let Some(outlet) = self.outlet_of(id) else {
                self.not_tried(&check::OUTLET_OPENS, id, text::NoOutlet);
                continue;
            };
            let go = text::AskOutlet { zone: id, outlet: &outlet }.words();
            if !self.agrees(format!("outlet/{id}/go"), go, Asks::Go).await? {
                self.not_tried(&check::OUTLET_OPENS, id, text::NoGo);
                continue;
            }
            let permit = OutletPermit(());
            if let Some(why) = self.enter(id, Test::Outlet(&permit)).await? {
                self.not_tried(&check::OUTLET_OPENS, id, why);
                continue;
            }
            self.expected = zone.detectors.iter().cloned().collect();
            self.outlet(zone, &outlet).await?;
            self.send(&Safe::Abort { zone: id.to_owned() }.posting()).await?;
            self.off(zone, &outlet).await?;
            self.clear(zone).await?;
            self.leave(id).await?;
            self.expected.clear();
        }
        Ok(())
    }

    fn outlet_of(&self, zone: &str) -> Option<String> {
        let installed = self.facts.installation.as_ref()?;
        installed.zones.iter().find(|it| it.zone == zone)?.test_outlet.clone()
    }

    fn pumps_in_order(&self) -> Vec<InstalledPump> {
        let installed = self.facts.installation.iter().flat_map(|it| &it.pumps);
        let installed: Vec<InstalledPump> = installed.filter(|it| !it.standby).cloned().collect();
        if self.plan.pumps.is_empty() {
            return installed;
        }
        let planned = self.plan.pumps.iter().filter(|it| !it.standby);
        let of = |it: &crate::plan::Pump| {
            let known = installed.iter().find(|pump| pump.pump == it.id).cloned();
            let known = known.unwrap_or_default();
            InstalledPump { pump: it.id.clone(), start_delay_s: it.start_delay_s, ..known }
        };
        planned.map(of).collect()
    }

    async fn outlet(&mut self, zone: &ConfiguredZone, outlet: &str) -> Step {
        let id = zone.zone.as_str();
        let words = text::AskSources { zone: id, votes: &zone.votes }.words();
        if !self.agrees(format!("outlet/{id}/sources"), words, Asks::Act).await? {
            self.not_tried(&check::OUTLET_OPENS, id, text::NoAnswer);
            return Ok(());
        }
        let most_ms = PERSON_MS + u64::from(zone.coincidence_s + zone.delay_s) * 1000;
        let released = self
            .until(most_ms, |zones, _| {
                zones.zone(id).filter(|it| it.phase() == "released").map(drop)
            })
            .await?;
        if released.is_none() {
            self.tried(&check::OUTLET_OPENS, id, false, text::ReleasedLimit, text::NotReleased);
            return Ok(());
        }
        let released_at = self.looked;
        self.pumps_start(released_at).await?;
        let open = self
            .until(VALVE_MS, |zones, _| {
                let it = zones.state.outputs.iter().find(|it| it.output == outlet)?;
                (it.reported.or(it.on) == Some(true)).then_some(())
            })
            .await?;
        let measured = match open {
            Some(_) => text::OutletOpen { outlet }.words(),
            None => text::Nothing.words(),
        };
        let limit = text::OutletOpen { outlet };
        self.tried(&check::OUTLET_OPENS, id, open.is_some(), limit, measured);
        let names: Vec<String> = self.plan.zones.iter().map(|it| it.id.clone()).collect();
        let words = text::AskWhere.words();
        let answer = self.ask(format!("outlet/{id}/where"), words, Asks::Name(names)).await?;
        match &answer {
            Answer::Name(name) => {
                self.tried(&check::OUTLET_WATER, id, name == id, Shown(id), Shown(name));
            }
            Answer::No => self.tried(&check::OUTLET_WATER, id, false, Shown(id), text::Nothing),
            _ => self.not_tried(&check::OUTLET_WATER, id, text::NoAnswer),
        }
        Ok(())
    }

    /// Watches the pumps until each gives pressure or its time is over.
    async fn pumps_start(&mut self, released_at: [u64; 2]) -> Step {
        let pumps = self.pumps_in_order();
        if pumps.is_empty() {
            self.not_tried(&check::PUMP_ORDER, "", text::NoPumps);
            self.not_tried(&check::PRESSURE, "", text::NoPumps);
            return Ok(());
        }
        let timeout = pumps.iter().map(|it| u64::from(it.start_timeout_s)).max().unwrap_or(0);
        let delays: u64 = pumps.iter().map(|it| u64::from(it.start_delay_s)).sum();
        let most_ms = (delays + timeout + 5) * 1000;
        let mut seen: BTreeMap<String, Seen> = BTreeMap::new();
        let began = self.wire.now_ms();
        loop {
            let (zones, _) = self.look().await?;
            let now = self.wire.now_ms();
            for pump in &zones.state.pumps {
                let it = seen.entry(pump.pump.clone()).or_default();
                if pump.runs.or(pump.on) == Some(true) {
                    it.runs.get_or_insert(self.looked);
                }
                if pump.pressure == Some(true) {
                    it.pressure.get_or_insert(self.looked);
                }
            }
            let gauged = |it: &InstalledPump| it.pressure.is_some();
            let done = pumps.iter().all(|it| {
                let seen = seen.get(&it.pump).copied().unwrap_or_default();
                seen.runs.is_some() && (!gauged(it) || seen.pressure.is_some())
            });
            if done || now.saturating_sub(began) > most_ms {
                break;
            }
            self.pause(super::POLL_MS).await?;
        }
        self.pump_order(&pumps, &seen, released_at);
        self.pressures(&pumps, &seen);
        Ok(())
    }

    fn pump_order(
        &mut self,
        pumps: &[InstalledPump],
        seen: &BTreeMap<String, Seen>,
        released_at: [u64; 2],
    ) {
        let mut at: Vec<([u64; 2], &str)> = Vec::new();
        for (id, seen) in seen {
            at.extend(seen.runs.map(|ms| (ms, id.as_str())));
        }
        // Of pumps that one look has seen the planned order is as good as any.
        let place = |id: &str| pumps.iter().position(|it| it.pump == id);
        at.sort_unstable_by_key(|(ms, id)| (*ms, place(id)));
        let shown = |gap: f64, id: &str| format!("{id} +{gap:.0} s");
        let wanted = pumps.iter().map(|it| shown(f64::from(it.start_delay_s), &it.pump));
        let wanted: Vec<String> = wanted.collect();
        let mut last = released_at;
        let mut good = at.len() == pumps.len();
        let mut found = Vec::new();
        for ((ms, id), planned) in at.iter().zip(pumps) {
            let gap = Span::between(last, *ms);
            let wait = f64::from(planned.start_delay_s);
            let fits = (gap.least_s - SEEN_S..=gap.most_s + SEEN_S).contains(&wait);
            good &= *id == planned.pump && fits;
            last = *ms;
        }
        last = released_at;
        for (ms, id) in &at {
            found.push(shown(ms[1].saturating_sub(last[1]) as f64 / 1000.0, id));
            last = *ms;
        }
        self.tried(&check::PUMP_ORDER, "", good, names(&wanted), names(&found));
    }

    fn pressures(&mut self, pumps: &[InstalledPump], seen: &BTreeMap<String, Seen>) {
        for pump in pumps {
            if pump.pressure.is_none() {
                self.not_tried(&check::PRESSURE, &pump.pump, text::NoGauge);
                continue;
            }
            let it = seen.get(&pump.pump).copied().unwrap_or_default();
            let span = it.runs.zip(it.pressure);
            let took = span.map(|(from, to)| to[1].saturating_sub(from[1]));
            let limit = text::AtMostSeconds { value: pump.start_timeout_s };
            // Pressure before the pump runs is that of another one.
            let early = span.is_some_and(|(from, to)| Span::between(to, from).least_s > SEEN_S);
            let good =
                took.is_some_and(|it| it <= u64::from(pump.start_timeout_s) * 1000) && !early;
            let measured = match took {
                _ if early => text::PressureEarly.words(),
                Some(ms) => text::Seconds { value: tenths(ms) }.words(),
                None => text::Nothing.words(),
            };
            self.tried(&check::PRESSURE, &pump.pump, good, limit, measured);
        }
    }

    /// Afterwards all of it is off.
    async fn off(&mut self, zone: &ConfiguredZone, outlet: &str) -> Step {
        let run_on = self.facts.installation.as_ref().map_or(0, |it| it.run_on_s);
        let most_ms = VALVE_MS + u64::from(run_on) * 1000;
        let off = self
            .until(most_ms, |zones, _| {
                let it = zones.state.outputs.iter().find(|it| it.output == outlet)?;
                let closed = it.reported.or(it.on) != Some(true);
                let still = zones.state.pumps.iter().all(|it| it.runs.or(it.on) != Some(true));
                (closed && still).then_some(())
            })
            .await?;
        let measured = match off {
            Some(((), ms)) => text::Seconds { value: tenths(ms) }.words(),
            None => text::StillOn.words(),
        };
        let limit = text::AtMostSeconds { value: most_ms / 1000 };
        self.tried(&check::OUTLET_OFF, &zone.zone, off.is_some(), limit, measured);
        Ok(())
    }
}
