//! People: what they order, and who wins.
//!
//! A no (lockout, Stop, Close, abort) ends what it is for in the same call and lasts until a reset, or until a
//! later release by hand. A release by hand, a reset, the end of lockout or the start of a pump that comes within
//! [`no_holds_ms`](crate::rules::Rules) after a no counts as simultaneous, and the no wins.

use super::water::Pump;
use super::zone::Ended;
use super::{Site, ms};
use crate::config::{ContactKind, Mode};
use crate::event::{Bypass, Hand, Scope};
use crate::output::{Cause, Entry, Refusal, Why};

/// A test returns after this time unless another is given, and after the longest at the latest, s.
const TEST_S: u32 = 900;
const TEST_MAX_S: u32 = 3600;
/// Longest time for which a mode can be set, s.
const MODE_MAX_S: u32 = 604_800;

impl Site {
    pub(super) fn hand(&mut self, by: &str, order: &Hand) {
        let cause = vec![Cause::Hand { by: by.to_owned() }];
        if let Err(why) = self.obey(by, order, &cause) {
            self.record(Entry::Refused { order: order.clone(), why }, cause);
        }
    }

    fn obey(&mut self, by: &str, order: &Hand, cause: &[Cause]) -> Result<(), Refusal> {
        match order {
            Hand::Mode { zone, mode, for_s } => {
                let zone = self.named_zone(zone)?;
                self.order_mode(zone, *mode, *for_s, cause)
            }
            Hand::Hold { zone, on } => {
                let zone = self.named_zone(zone)?;
                self.order_hold(zone, on.then_some(by))
            }
            Hand::Abort { zone } => {
                self.named_zone(zone)?;
                self.no(&Scope::Zone(zone.clone()), Why::Abort, cause);
                Ok(())
            }
            Hand::Release { zone } => {
                let zone = self.named_zone(zone)?;
                self.release_by_hand(zone, cause.to_vec())
            }
            Hand::Close(scope) => self.order_no(scope, Why::Close, cause),
            Hand::Stop(scope) => self.order_no(scope, Why::Stop, cause),
            Hand::Reset(scope) => self.reset(scope, cause),
            Hand::Lockout { on } => self.order_lockout(*on, cause),
            Hand::Bypass { detector, bypass } => {
                let index = self.plan.detector(detector).ok_or(Refusal::Unknown)?;
                self.bypass(index, *bypass, cause);
                Ok(())
            }
            Hand::Silence => {
                self.silenced = true;
                self.record(Entry::Silenced, cause.to_vec());
                Ok(())
            }
            Hand::Pump { pump, on } => {
                let pump = self.plan.pump(pump).ok_or(Refusal::Unknown)?;
                self.order_pump(pump, *on, cause)
            }
        }
    }

    /// What came at this time counts as simultaneous with what comes now.
    fn is_simultaneous(&self, at: u64) -> bool {
        self.now < at.saturating_add(self.rules.no_holds_ms)
    }

    /// A person's no came at the same time.
    fn is_just_said(&self, ended: Option<&Ended>) -> bool {
        ended.is_some_and(|it| it.said && self.is_simultaneous(it.at))
    }

    fn order_lockout(&mut self, on: bool, cause: &[Cause]) -> Result<(), Refusal> {
        let just = self.locked_at.is_some_and(|at| self.is_simultaneous(at));
        if !on && self.lockout && just {
            return Err(Refusal::JustRefused);
        }
        let was = self.is_locked();
        self.lockout = on;
        self.out.persist = true;
        self.record(Entry::Lockout { on: self.is_locked() }, cause.to_vec());
        if on {
            self.no(&Scope::Site, Why::Lockout, cause);
        } else if was {
            self.after_lockout();
        }
        Ok(())
    }

    fn order_pump(&mut self, pump: usize, on: bool, cause: &[Cause]) -> Result<(), Refusal> {
        if on && self.is_locked() {
            return Err(Refusal::Lockout);
        }
        if on && self.is_stopped() {
            return Err(Refusal::StillPressed);
        }
        if on && self.cut_at.is_some_and(|at| self.is_simultaneous(at)) {
            return Err(Refusal::JustRefused);
        }
        self.pump_by_hand(pump, on, cause);
        Ok(())
    }

    fn named_zone(&self, id: &str) -> Result<usize, Refusal> {
        self.plan.zone(id).ok_or(Refusal::Unknown)
    }

    fn order_no(&mut self, scope: &Scope, why: Why, cause: &[Cause]) -> Result<(), Refusal> {
        self.zones_of(scope)?;
        self.no(scope, why, cause);
        Ok(())
    }

    fn order_mode(
        &mut self,
        zone: usize,
        mode: Mode,
        for_s: Option<u32>,
        cause: &[Cause],
    ) -> Result<(), Refusal> {
        let configured = &self.plan.config.zones[zone];
        let most = if mode.is_test() { TEST_MAX_S } else { MODE_MAX_S };
        let outlet = mode != Mode::TestOutlet || configured.test_outlet.is_some();
        if for_s.is_some_and(|time| time == 0 || time > most) || !outlet {
            return Err(Refusal::Range);
        }
        if mode.is_test() && self.zones[zone].release.as_ref().is_some_and(|it| it.wet) {
            return Err(Refusal::Released);
        }
        let time = match mode {
            Mode::Automatic => None,
            Mode::Manual | Mode::Off => for_s.or(configured.return_after_s),
            Mode::TestDry | Mode::TestOutlet => Some(for_s.unwrap_or(TEST_S)),
        };
        // What counts down as a test does not come to water, nor the other way round.
        if self.zones[zone].mode.is_test() != mode.is_test() {
            self.cancel(zone, Why::Mode);
        }
        self.set_mode(zone, mode, time.map(ms), cause.to_vec());
        Ok(())
    }

    fn order_hold(&mut self, zone: usize, by: Option<&str>) -> Result<(), Refusal> {
        if by.is_some() && !self.plan.config.zones[zone].hold {
            return Err(Refusal::NoHold);
        }
        if by.is_some() && self.zones[zone].release.is_some() {
            return Err(Refusal::TooLate);
        }
        self.zones[zone].hold_by = by.map(str::to_owned);
        Ok(())
    }

    /// A release by a person or a station. It needs no votes, and no automatic mode.
    pub(super) fn release_by_hand(
        &mut self,
        zone: usize,
        cause: Vec<Cause>,
    ) -> Result<(), Refusal> {
        let mode = self.mode(zone);
        if self.is_locked() && self.rules.lockout_before_hand {
            return Err(Refusal::Lockout);
        }
        if mode == Mode::Off || (mode == Mode::Manual && !self.rules.hand_is_free) {
            return Err(Refusal::Off);
        }
        if self.pressed(zone, ContactKind::Abort) && self.rules.abort_before_hand {
            return Err(Refusal::AbortPressed);
        }
        if self.pressed(zone, ContactKind::Stop) {
            return Err(Refusal::StillPressed);
        }
        if self.is_just_said(self.zones[zone].ended.as_ref()) {
            return Err(Refusal::JustRefused);
        }
        // A test keeps votes dry, never a hand: it is over.
        if mode.is_test() && self.rules.hand_ends_test {
            self.set_mode(zone, Mode::Automatic, None, cause.clone());
        }
        let running = self.zones[zone].release.as_ref();
        if running.is_some_and(|release| !release.automatic) {
            return Ok(());
        }
        let chosen = running.is_some_and(|release| release.wet);
        self.zones[zone].ended = None;
        for &monitor in &self.plan.zone_monitors[zone] {
            let state = &mut self.monitors[monitor];
            if state.refused.is_none() && state.owner.is_none() {
                state.closing.iter_mut().for_each(|it| it.yields = Some(zone));
            }
        }
        self.release(zone, false, self.now, cause);
        if let Some(release) = &mut self.zones[zone].release {
            release.chosen = chosen;
        }
        Ok(())
    }

    /// The zones that a no or a reset is for.
    fn zones_of(&self, scope: &Scope) -> Result<Vec<usize>, Refusal> {
        match scope {
            Scope::Site => Ok((0..self.zones.len()).collect()),
            Scope::Zone(id) => Ok(vec![self.named_zone(id)?]),
            Scope::Monitor(id) => {
                self.plan.monitor(id).ok_or(Refusal::Unknown)?;
                Ok(Vec::new())
            }
        }
    }

    /// A no: ends releases and countdowns, closes, and lasts.
    pub(super) fn no(&mut self, scope: &Scope, why: Why, cause: &[Cause]) {
        let Ok(zones) = self.zones_of(scope) else { return };
        self.record(Entry::No { scope: scope.clone(), why }, cause.to_vec());
        self.out.persist = true;
        let mut chain = cause.to_vec();
        chain.push(Cause::End(why));
        if why == Why::Lockout {
            self.locked_at = Some(self.now);
        }
        // The end of a release closes its monitors.
        let ended: Vec<usize> = (0..self.monitors.len())
            .filter(|it| self.monitors[*it].owner.is_some_and(|zone| zones.contains(&zone)))
            .collect();
        for &zone in &zones {
            let under_way =
                self.zones[zone].release.is_some() || self.zones[zone].met_since.is_some();
            if self.zones[zone].release.is_some() && !self.rules.no_ends_water {
                continue;
            }
            self.end(zone, why, cause);
            self.cancel(zone, why);
            self.zones[zone].hold_by = None;
            // Lockout lasts by itself; what it ended does not come back with the key.
            if self.rules.no_lasts && (why != Why::Lockout || under_way) {
                self.zones[zone].ended = Some(Ended { why, at: self.now, said: true });
            }
            self.known_valves(zone);
        }
        let meant = self.monitors_of(scope, &zones);
        for monitor in meant.into_iter().filter(|it| !ended.contains(it)) {
            self.shut(monitor, why == Why::Stop || why == Why::Lockout, &chain);
        }
        if let Scope::Monitor(id) = scope
            && let Some(monitor) = self.plan.monitor(id)
            && self.rules.no_lasts
        {
            self.monitors[monitor].refused = Some(Ended { why, at: self.now, said: true });
        }
        if *scope == Scope::Site && matches!(why, Why::Stop | Why::Lockout) {
            self.cut_pumps(&chain);
        }
    }

    /// The monitors that a no closes: not those that work for another zone.
    fn monitors_of(&self, scope: &Scope, zones: &[usize]) -> Vec<usize> {
        if let Scope::Monitor(id) = scope {
            return self.plan.monitor(id).into_iter().collect();
        }
        let all = 0..self.monitors.len();
        let meant = |monitor: &usize| {
            let serves = self.plan.monitor_zones[*monitor].iter().any(|it| zones.contains(it));
            let elsewhere = self.monitors[*monitor].owner.is_some_and(|it| !zones.contains(&it));
            let releasing = |zone: &usize| self.zones[*zone].release.is_some();
            let kept = !self.rules.no_ends_water && zones.iter().any(releasing);
            (*scope == Scope::Site || (serves && !elsewhere)) && !kept
        };
        all.filter(meant).collect()
    }

    fn reset(&mut self, scope: &Scope, cause: &[Cause]) -> Result<(), Refusal> {
        let zones = self.zones_of(scope)?;
        if *scope == Scope::Site && self.is_locked() {
            return Err(Refusal::Lockout);
        }
        if zones.iter().any(|zone| self.zones[*zone].release.is_some()) {
            return Err(Refusal::Released);
        }
        if zones.iter().any(|zone| self.says_no(*zone).is_some()) {
            return Err(Refusal::StillPressed);
        }
        let mut monitors = self.monitors_of(scope, &zones);
        monitors.retain(|it| !self.serves_another(*it, &zones));
        let nos = zones.iter().map(|it| &self.zones[*it].ended);
        let mut nos = nos.chain(monitors.iter().map(|it| &self.monitors[*it].refused));
        let stopped = |pump: &Pump| pump.hand == Some(false) && self.is_simultaneous(pump.hand_at);
        let stopped = *scope == Scope::Site && self.pumps.iter().any(stopped);
        // Of another person, perhaps: who has said it as well says so again.
        if stopped || nos.any(|it| self.is_just_said(it.as_ref())) {
            return Err(Refusal::JustRefused);
        }
        for &zone in &zones {
            self.zones[zone].ended = None;
        }
        for monitor in monitors {
            self.monitors[monitor].refused = None;
        }
        if *scope == Scope::Site {
            self.troubles.retain(|_, known| known.active);
            self.forget_pumps();
        }
        self.out.persist = true;
        self.record(Entry::Reset(scope.clone()), cause.to_vec());
        Ok(())
    }

    /// A zone besides these would open a monitor at once, or soon. For a monitor by its name there are none.
    fn serves_another(&self, monitor: usize, zones: &[usize]) -> bool {
        let mut others = self.plan.monitor_zones[monitor].iter().filter(|it| !zones.contains(it));
        let under_way = |zone: &usize| {
            self.zones[*zone].release.is_some() || self.zones[*zone].met_since.is_some()
        };
        !zones.is_empty() && others.any(under_way)
    }

    fn bypass(&mut self, index: usize, bypass: Bypass, cause: &[Cause]) {
        self.detectors[index].bypass = bypass;
        self.out.persist = true;
        let detector = self.plan.config.detectors[index].id.clone();
        self.record(Entry::Bypass { detector, bypass }, cause.to_vec());
    }
}
