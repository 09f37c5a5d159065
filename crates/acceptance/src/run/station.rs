//! With water: a release station starts all monitors of its zone, on a person's yes and by a person's hand.

use std::collections::BTreeSet;

use lafet_texts::{Text as _, acceptance as text};

use super::{PERSON_MS, Run, Step};
use crate::check;
use crate::judge::names;
use crate::order::Safe;
use crate::plan::Input;
use crate::wire::{Asks, Person, Wire};

/// All monitors are open within, ms: they deploy and turn before.
const OPEN_MS: u64 = 60_000;
/// And closed within, ms.
const CLOSED_MS: u64 = 20_000;

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn stations(&mut self) -> Step {
        let inputs = self.plan.inputs.iter().filter(|it| it.kind == "release");
        let inputs: Vec<Input> = inputs.cloned().collect();
        for input in &inputs {
            self.station(input).await?;
        }
        Ok(())
    }

    async fn station(&mut self, input: &Input) -> Step {
        let id = input.id.as_str();
        let (zones, monitors) = self.of_station(input);
        if let Some(monitor) = monitors.iter().find(|it| !self.ends_by_itself(it)) {
            self.not_tried(&check::STATION, id, text::NoWaterTimeoutOf { monitor });
            return Ok(());
        }
        let list: Vec<&String> = monitors.iter().collect();
        let words = text::AskStation { input: id, monitors: names(&list) }.words();
        if !self.agrees(format!("water/{id}/go"), words, Asks::Water).await? {
            self.not_tried(&check::STATION, id, text::NoGo);
            return Ok(());
        }
        let (now, _) = self.look().await?;
        let rests = |zone: &&String| {
            let it = now.zone(zone).filter(|it| it.phase() == "quiet" && !now.state.lockout);
            it.is_none_or(|it| !matches!(it.mode.as_str(), "automatic" | "manual"))
        };
        if let Some(zone) = zones.iter().find(rests) {
            self.not_tried(&check::STATION, id, text::ZoneNotQuiet { zone });
            return Ok(());
        }
        let refused = zones.iter().find_map(|zone| self.refused(&now, zone));
        if let Some(monitor) = refused {
            self.not_tried(&check::STATION, id, text::MonitorRefused { monitor: &monitor });
            return Ok(());
        }
        self.announce(text::WillStation { input: id, monitors: names(&list) }.words());
        self.begun.released.clone_from(&zones);
        self.begun.water.clone_from(&monitors);
        let press = text::AskPressStation { input: id }.words();
        if self.agrees(format!("water/{id}/press"), press, Asks::Act).await? {
            self.station_opens(id, &zones, &monitors).await?;
        } else {
            self.not_tried(&check::STATION, id, text::NoAnswer);
        }
        self.station_ends(&zones, &monitors).await
    }

    /// The zones of a station, and the monitors that it starts: with `jets` the first of them.
    fn of_station(&self, input: &Input) -> (BTreeSet<String>, BTreeSet<String>) {
        let configured = self.facts.configured.clone().unwrap_or_default().zones;
        let of = configured.into_iter();
        let of = of.filter(|it| input.zones.is_empty() || input.zones.contains(&it.zone));
        let (mut zones, mut monitors) = (BTreeSet::new(), BTreeSet::new());
        for zone in of {
            let planned = self.plan.zones.iter().find(|it| it.id == zone.zone);
            let all = planned.map(|it| &it.monitors).filter(|it| !it.is_empty());
            let jets = planned.and_then(|it| it.jets).map_or(usize::MAX, usize::from);
            monitors.extend(all.unwrap_or(&zone.monitors).iter().take(jets).cloned());
            zones.insert(zone.zone);
        }
        (zones, monitors)
    }

    async fn station_opens(
        &mut self,
        id: &str,
        zones: &BTreeSet<String>,
        monitors: &BTreeSet<String>,
    ) -> Step {
        let by_hand = |zones: &crate::facts::Zones, id: &String| {
            zones.zone(id).is_some_and(|it| it.released("automatic") == Some(false))
        };
        let released = self
            .until(PERSON_MS, |now, _| zones.iter().all(|it| by_hand(now, it)).then_some(()))
            .await?;
        let list: Vec<&String> = monitors.iter().collect();
        let limit = text::StationLimit { monitors: names(&list) };
        if released.is_none() {
            self.tried(&check::STATION, id, false, limit, text::NotReleased);
            return Ok(());
        }
        let mut open = BTreeSet::new();
        let all = self
            .until(OPEN_MS, |_, now| {
                let opens = |it: &&String| {
                    let it = now.get(*it);
                    it.is_some_and(|it| it.has("Valve1", "Open") || it.has("Valve2", "Open"))
                };
                open = monitors.iter().filter(opens).cloned().collect();
                (open == *monitors).then_some(())
            })
            .await?;
        let open: Vec<&String> = open.iter().collect();
        self.tried(&check::STATION, id, all.is_some(), limit, names(&open));
        Ok(())
    }

    /// Ends the release: aborted, closed, and the abort withdrawn.
    async fn station_ends(
        &mut self,
        zones: &BTreeSet<String>,
        monitors: &BTreeSet<String>,
    ) -> Step {
        for zone in zones {
            self.send(&Safe::Abort { zone: zone.clone() }.posting()).await?;
        }
        let closed = self
            .until(CLOSED_MS, |_, now| {
                let shut = |it: &String| now.get(it).is_some_and(|it| it.not_closed().is_empty());
                monitors.iter().all(shut).then_some(())
            })
            .await?;
        if closed.is_some() {
            self.begun.water.clear();
            for zone in zones {
                self.withdraw(zone).await?;
            }
            self.begun.released.clear();
        }
        Ok(())
    }
}
