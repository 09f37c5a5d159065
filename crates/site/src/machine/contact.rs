//! Contacts: they bounce, and a stop counts at once.

use super::{Site, ms};
use crate::config::{self, ContactKind};
use crate::event::Scope;
use crate::output::{Cause, Entry, Why};
use crate::state::Trouble;

/// A contact.
#[derive(Clone, Debug, Default)]
pub(super) struct Contact {
    /// As last read; `None`: not read, or its line is at fault.
    pub raw: Option<bool>,
    pub changed: u64,
    /// As it counts.
    pub level: bool,
    /// A hold: pressed since.
    pub since: Option<u64>,
    /// A hold that is pressed for longer than any countdown takes, held as long as it may be.
    pub stuck: bool,
}

impl Site {
    pub(super) fn contact_reports(&mut self, index: usize, pressed: bool) {
        let kind = self.plan.config.contacts[index].kind;
        let contact = &mut self.contacts[index];
        if contact.raw == Some(pressed) {
            return;
        }
        let first = contact.raw.is_none();
        contact.raw = Some(pressed);
        contact.changed = self.now;
        // Its press was not seen.
        if first && pressed && kind == ContactKind::Release {
            contact.level = true;
            self.trouble(Trouble::ContactStuck, index, true);
        }
    }

    /// A contact whose line is at fault keeps its state, but its next reading is no press.
    pub(super) fn path_reports(&mut self, path: usize, fault: bool) {
        if fault && let Some(contact) = self.contacts.get_mut(path) {
            contact.raw = None;
        }
        let known = self.troubles.get(&(Trouble::Path, path));
        if !fault && known.is_some_and(|it| it.active) {
            self.command_again(path);
        }
        self.trouble(Trouble::Path, path, fault);
    }

    pub(super) fn contacts(&mut self) {
        // What stops is looked at before what releases.
        for releases in [false, true] {
            for index in 0..self.contacts.len() {
                let kind = self.plan.config.contacts[index].kind;
                if releases == (kind == ContactKind::Release) {
                    self.contact(index, kind);
                }
                if !releases && kind == ContactKind::Hold {
                    self.hold_sticks(index);
                }
            }
        }
    }

    /// A hold that is pressed for longer than a countdown takes, held as long as it may be, is stuck.
    fn hold_sticks(&mut self, index: usize) {
        let Contact { since: Some(since), stuck, .. } = self.contacts[index] else { return };
        let zones = self.plan.contact_zones[index].iter().map(|it| &self.plan.config.zones[*it]);
        let whole = |it: &config::Zone| ms(it.coincidence_s + it.delay_s + it.hold_max_s);
        let Some(longest) = zones.map(whole).max() else { return };
        if !stuck && self.due(since.saturating_add(longest)) {
            self.contacts[index].stuck = true;
            self.trouble(Trouble::ContactStuck, index, true);
        }
    }

    /// The hold contacts of a zone that are pressed, and whether a person holds by it: since the alarm of the
    /// zone, and not for too long. One that was pressed before is a trouble as soon as it would hold.
    pub(super) fn holds(&self, zone: usize) -> impl Iterator<Item = (usize, bool)> {
        let alarm = self.zones[zone].alarm_since;
        self.plan.contacts_of(zone, ContactKind::Hold).filter_map(move |index| {
            let Contact { since, stuck, .. } = self.contacts[index];
            Some((index, !stuck && since? >= alarm))
        })
    }

    fn contact(&mut self, index: usize, kind: ContactKind) {
        let contact = &self.contacts[index];
        let (raw, changed) = (contact.raw.unwrap_or(contact.level), contact.changed);
        if raw == contact.level {
            return;
        }
        let wait = match raw && kind.acts_at_once() {
            true => 0,
            false => u64::from(self.plan.config.contacts[index].debounce_ms),
        };
        if !self.due(changed.saturating_add(wait)) {
            return;
        }
        self.contacts[index].level = raw;
        self.out.persist |= kind.is_kept();
        self.busy = true;
        let input = self.plan.config.contacts[index].id.clone();
        let cause = vec![Cause::Contact { input: input.clone() }];
        match (kind, raw) {
            (ContactKind::Release, true) => self.station(index, &input),
            (ContactKind::Release, false) => self.trouble(Trouble::ContactStuck, index, false),
            (ContactKind::Hold, pressed) => {
                let contact = &mut self.contacts[index];
                (contact.since, contact.stuck) = (pressed.then_some(self.now), false);
                if !pressed {
                    self.trouble(Trouble::ContactStuck, index, false);
                }
            }
            (ContactKind::Abort, true) => self.no_by_contact(index, Why::Abort, &cause),
            (ContactKind::Stop, true) => self.no_by_contact(index, Why::Stop, &cause),
            (ContactKind::Lockout, true) => {
                self.record(Entry::Lockout { on: true }, cause.clone());
                self.no(&Scope::Site, Why::Lockout, &cause);
            }
            (ContactKind::Lockout, false) => {
                let on = self.is_locked();
                self.record(Entry::Lockout { on }, cause);
                self.after_lockout();
            }
            _ => {}
        }
    }

    fn no_by_contact(&mut self, index: usize, why: Why, cause: &[Cause]) {
        if self.plan.config.contacts[index].zones.is_empty() {
            self.no(&Scope::Site, why, cause);
            return;
        }
        for zone in self.plan.contact_zones[index].clone() {
            let id = self.zone_id(zone);
            self.no(&Scope::Zone(id), why, cause);
        }
    }

    fn station(&mut self, index: usize, input: &str) {
        for zone in self.plan.contact_zones[index].clone() {
            let cause = vec![Cause::Contact { input: input.to_owned() }];
            if let Err(why) = self.release_by_hand(zone, cause.clone()) {
                let entry = Entry::StationRefused {
                    input: input.to_owned(),
                    zone: self.zone_id(zone),
                    why,
                };
                self.record(entry, cause);
            }
        }
    }

    /// A contact of a kind counts as pressed for a zone.
    pub(super) fn pressed(&self, zone: usize, kind: ContactKind) -> bool {
        self.plan.contacts_of(zone, kind).any(|index| self.contacts[index].level)
    }

    /// The no that a contact says, as long as it is pressed.
    pub(super) fn says_no(&self, zone: usize) -> Option<Why> {
        let kinds = [(ContactKind::Stop, Why::Stop), (ContactKind::Abort, Why::Abort)];
        kinds.into_iter().find(|(kind, _)| self.pressed(zone, *kind)).map(|(_, why)| why)
    }

    /// A Stop of the whole site is pressed.
    pub(super) fn is_stopped(&self) -> bool {
        let config = &self.plan.config;
        let whole = |it: &usize| config.contacts[*it].zones.is_empty();
        self.plan.contacts(ContactKind::Stop).filter(whole).any(|it| self.contacts[it].level)
    }

    /// Lockout of the site, by command or key.
    pub fn is_locked(&self) -> bool {
        self.lockout || self.plan.contacts(ContactKind::Lockout).any(|it| self.contacts[it].level)
    }
}
