//! Dry, with all zones switched off: the contacts that people press. A release by hand is refused then, so a line that
//! arrives at the wrong contact opens nothing.

use std::collections::BTreeSet;

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::zone::{FOLLOWS_MS, PRESSES, Test};
use super::{POLL_MS, Run, Step};
use crate::check;
use crate::facts::{AuditLog, Zones};
use crate::plan::Input;
use crate::wire::{Asks, Person, Wire};

/// Contacts that are pressed in this step.
const KINDS: [&str; 3] = ["abort", "stop", "release"];

impl<W: Wire, P: Person> Run<'_, W, P> {
    pub(super) async fn contacts(&mut self) -> Step {
        let inputs = self.plan.inputs.iter().filter(|it| KINDS.contains(&it.kind.as_str()));
        let inputs: Vec<Input> = inputs.cloned().collect();
        let zones = self.facts.configured.clone().unwrap_or_default().zones;
        let zones: Vec<String> = zones.into_iter().map(|it| it.zone).collect();
        if inputs.is_empty() || zones.is_empty() {
            self.not_tried(&check::CONTACT, "", text::NotPlanned);
            return Ok(());
        }
        let go = text::AskContacts.words();
        let mut why = None;
        if !self.agrees("dry/contacts/go".to_owned(), go, Asks::Go).await? {
            why = Some(text::NoGo.words());
        }
        for zone in &zones {
            if why.is_none() {
                why = self.enter(zone, Test::Off).await?;
            }
        }
        match why {
            None => {
                for input in &inputs {
                    self.contact(input, &zones).await?;
                }
            }
            Some(why) => {
                for input in &inputs {
                    self.not_tried(&check::CONTACT, &input.id, why.clone());
                }
            }
        }
        for zone in &zones {
            self.leave(zone).await?;
        }
        Ok(())
    }

    /// A contact is pressed, and arrives as what it is, for its zones.
    async fn contact(&mut self, input: &Input, zones: &[String]) -> Step {
        for zone in zones {
            self.keep_testing(zone).await?;
            self.withdraw(zone).await?;
        }
        let before = self.last_entry().await?;
        let id = input.id.as_str();
        let mut found = BTreeSet::new();
        for _ in 0..PRESSES {
            let words = text::AskPress { input: id, kind: &input.kind }.words();
            if !self.agrees(format!("dry/contacts/input/{id}"), words, Asks::Act).await? {
                self.not_tried(&check::CONTACT, id, text::NoAnswer);
                return Ok(());
            }
            found = self.arrives(before).await?;
            if !found.is_empty() {
                break;
            }
        }
        let of = if input.zones.is_empty() { zones } else { &input.zones };
        let kind = input.kind.as_str();
        let station = if kind == "release" { id } else { "" };
        let wanted: BTreeSet<String> = of.iter().map(|zone| heard(kind, station, zone)).collect();
        let line = |all: &BTreeSet<String>| all.iter().cloned().collect::<Vec<_>>().join(", ");
        let measured = match found.is_empty() {
            true => text::Nothing.words(),
            false => Shown(line(&found)).words(),
        };
        self.tried(&check::CONTACT, id, found == wanted, Shown(line(&wanted)), measured);
        for zone in zones {
            self.withdraw(zone).await?;
        }
        Ok(())
    }

    /// What arrives of a press, by the zones that it has ended and the releases that were refused since an entry.
    async fn arrives(&mut self, before: u64) -> Step<BTreeSet<String>> {
        let began = self.wire.now_ms();
        loop {
            let (now, _) = self.look().await?;
            let mut found = ended(&now);
            let log = self.get::<AuditLog>("/api/audit?limit=200").await?.unwrap_or_default();
            let new = log.entries.iter().filter(|it| it.n > before);
            let refused = new.filter_map(|it| it.refused());
            found.extend(refused.map(|(station, zone)| heard("release", station, zone)));
            let late = self.wire.now_ms().saturating_sub(began) >= FOLLOWS_MS;
            if !found.is_empty() || late {
                return Ok(found);
            }
            self.pause(POLL_MS).await?;
        }
    }
}

/// A contact as it arrives: `abort → hall`, `release station → hall`.
fn heard(kind: &str, station: &str, zone: &str) -> String {
    let blank = if station.is_empty() { "" } else { " " };
    format!("{kind}{blank}{station} → {zone}")
}

/// The zones that a contact has ended.
fn ended(zones: &Zones) -> BTreeSet<String> {
    let all = zones.state.zones.iter();
    all.filter_map(|it| Some(heard(it.ended()?, "", &it.zone))).collect()
}
