//! A drill: an alarm that people do not expect, with their zone switched off. Whatever they do, nothing gets wet: a
//! release by hand is refused then, and counts as their answer.

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::motion::tenths;
use super::zone::Test;
use super::{POLL_MS, Run, Step};
use crate::check;
use crate::facts::{AuditLog, ConfiguredZone};
use crate::judge::{ANSWER_S, DETECT_S};
use crate::wire::{Asks, Person, Wire};

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn drills(&mut self) -> Step {
        let zones = self.facts.configured.clone().unwrap_or_default().zones;
        for zone in &zones {
            let id = zone.zone.as_str();
            let go = text::AskDrill { zone: id }.words();
            let mut why = None;
            if !self.agrees(format!("drill/{id}/go"), go, Asks::Go).await? {
                why = Some(text::NoGo.words());
            }
            if why.is_none() {
                why = self.enter(id, Test::Off).await?;
            }
            if let Some(why) = why {
                self.not_tried(&check::DRILL_ALARM, id, why.clone());
                self.not_tried(&check::DRILL_ANSWERED, id, why);
                continue;
            }
            if let Some(under) = self.begun.zones.get_mut(id) {
                under.sources = true;
            }
            self.expected = zone.detectors.iter().cloned().collect();
            self.drill(zone).await?;
            self.clear(zone).await?;
            self.withdraw(id).await?;
            self.leave(id).await?;
            self.expected.clear();
        }
        Ok(())
    }

    async fn drill(&mut self, zone: &ConfiguredZone) -> Step {
        let id = zone.zone.as_str();
        let before = self.last_entry().await?;
        let words = text::AskDrillSource { zone: id }.words();
        if !self.agrees(format!("drill/{id}/source"), words, Asks::Act).await? {
            self.not_tried(&check::DRILL_ALARM, id, text::NoAnswer);
            self.not_tried(&check::DRILL_ANSWERED, id, text::NoAnswer);
            return Ok(());
        }
        let raised = self
            .until((DETECT_S * 1000.0) as u64, |zones, _| {
                let alarmed = zones.zone(id).is_some_and(|it| !it.alarms.is_empty());
                (alarmed && zones.state.tone == "alarm").then_some(())
            })
            .await?;
        let limit = text::AtMostSeconds { value: DETECT_S };
        let Some(((), took)) = raised else {
            self.tried(&check::DRILL_ALARM, id, false, limit, text::Nothing);
            self.not_tried(&check::DRILL_ANSWERED, id, text::NotReported);
            return Ok(());
        };
        let measured = text::Seconds { value: tenths(took) };
        self.tried(&check::DRILL_ALARM, id, true, limit, measured);
        self.answered(id, before).await
    }

    /// Waits for what people do: silence, hold, abort, stop, or a release, which is refused.
    async fn answered(&mut self, id: &str, before: u64) -> Step {
        let planned = self.plan.zones.iter().find(|it| it.id == id);
        let most = planned.and_then(|it| it.answer_s).unwrap_or(ANSWER_S);
        let limit = text::AtMostSeconds { value: most };
        let began = self.wire.now_ms();
        loop {
            self.keep_testing(id).await?;
            let log = self.get::<AuditLog>("/api/audit?limit=200").await?.unwrap_or_default();
            // The latest comes first.
            let mut new = log.entries.iter().rev().filter(|it| it.n > before);
            let first = new.find_map(|it| it.answer()).map(str::to_owned);
            let took = self.wire.now_ms().saturating_sub(began);
            if let Some(phase) = first {
                let measured = text::PhaseAfter { phase: Shown(phase), value: tenths(took) };
                self.tried(&check::DRILL_ANSWERED, id, true, limit, measured);
                return Ok(());
            }
            if took >= u64::from(most) * 1000 {
                self.tried(&check::DRILL_ANSWERED, id, false, limit, text::Nothing);
                return Ok(());
            }
            self.pause(POLL_MS).await?;
        }
    }
}
