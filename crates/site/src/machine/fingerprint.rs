//! What the machine will do depends on this alone: two states with the same fingerprint are one. For the
//! exploration of the states in the tests.

use std::hash::{Hash, Hasher};

use super::Site;
use super::water::Set;
use crate::config::ContactKind;

impl Site {
    /// Feeds everything on which further behaviour depends: times as what is left of them, never names,
    /// numbers or causes.
    #[doc(hidden)]
    pub fn fingerprint(&self, hash: &mut impl Hasher) {
        // What is over for longer than any time of the machine is simply over.
        let age = |at: u64| self.now.saturating_sub(at).min(self.longest());
        let left = |at: u64| at.saturating_sub(self.now);
        let holds = |at: u64| left(at.saturating_add(self.rules.no_holds_ms));
        for it in &self.detectors {
            let testing = !it.stuck && it.condition_since > 0;
            (it.signal, it.condition, it.silent, it.stuck, it.stale, it.bypass).hash(hash);
            (age(it.heard), testing.then(|| age(it.condition_since))).hash(hash);
        }
        for it in &self.contacts {
            let moves = it.raw.is_some_and(|raw| raw != it.level);
            (it.raw, it.level, moves.then(|| age(it.changed))).hash(hash);
            (it.stuck, it.since.map(age)).hash(hash);
        }
        for it in &self.zones {
            (it.mode, it.mode_until.map(left), it.met_since.map(age)).hash(hash);
            (it.counting, it.held_ms, it.held_since.map(age), it.hold_by.is_some()).hash(hash);
            let release = it.release.as_ref().map(|release| {
                let times = (release.until.map(left), release.quiet_since.map(age));
                (release.automatic, release.wet, release.chosen, times, release.voters.clone())
            });
            let ended = it.ended.as_ref().map(|ended| (ended.why, age(ended.at), ended.said));
            let last_alarm = ended.is_some().then(|| age(it.last_alarm));
            (release, ended, it.alarmed, last_alarm, &it.preferred, &it.opens).hash(hash);
            it.alarmed.then(|| age(it.alarm_since)).filter(|_| self.has_holds()).hash(hash);
        }
        for it in &self.monitors {
            let closing = it.closing.as_ref();
            let closing = closing.map(|it| (left(it.next), age(it.since), it.shut, it.yields));
            let engaged = it.engaged.map(|engaged| (engaged, age(it.engaged_at)));
            let refused = it.refused.as_ref().map(|refused| (refused.why, age(refused.at)));
            (it.report, it.seen, it.owner, engaged, it.idle, it.prepared, closing).hash(hash);
            it.lent.map(|(zone, until)| (zone, until.map(left))).hash(hash);
            (it.by_person, it.water_of, it.on_its_way.map(left)).hash(hash);
            (refused, it.found.map(left), it.stored_left.filter(|_| !it.seen)).hash(hash);
        }
        for (index, it) in self.pumps.iter().enumerate() {
            let started = (it.on == Some(true)).then(|| age(it.started));
            let feedback = self.plan.config.pumps[index].feedback;
            (it.reported, feedback.then(|| (left(it.next), age(it.set_at)))).hash(hash);
            (it.on, started, it.seen, it.lost_since.map(age), it.failed, it.hand).hash(hash);
            (it.replaced, it.idle_since.map(age)).hash(hash);
            (it.hand == Some(false)).then(|| holds(it.hand_at)).hash(hash);
        }
        for (index, it) in self.outputs.iter().enumerate() {
            let set = it.set.map(|set| match set {
                Set::On(on) => (on, None),
                Set::Tone(tone) => (true, Some(tone)),
            });
            let feedback = self.plan.config.outputs[index].feedback;
            let times = feedback.then(|| (left(it.next), age(it.set_at)));
            (set, it.known, it.reported, times).hash(hash);
        }
        for (key, known) in &self.troubles {
            (key, known.active).hash(hash);
        }
        let young = age(self.started);
        (self.lockout, self.silenced, young).hash(hash);
        let locked = self.locked_at.filter(|_| self.is_locked());
        (locked.map_or(0, holds), self.cut_at.map_or(0, holds)).hash(hash);
        self.pumps_since.map(age).hash(hash);
    }

    /// Whether the beginning of an alarm matters.
    fn has_holds(&self) -> bool {
        self.plan.contacts(ContactKind::Hold).next().is_some()
    }

    /// The longest time of the configuration and the rules, ms.
    fn longest(&self) -> u64 {
        let config = &self.plan.config;
        let zones = config.zones.iter().map(|it| {
            let times =
                [it.act_within_s, it.return_after_s.unwrap_or(0), it.quiet_ends_s.unwrap_or(0)];
            let counting = it.coincidence_s + it.delay_s + it.hold_max_s;
            times.into_iter().max().unwrap_or(0).max(counting)
        });
        let detectors = config.detectors.iter().map(|it| it.silent_after_s.max(it.self_test_max_s));
        let pumps = config.pumps.iter().map(|it| it.start_delay_s.max(it.start_timeout_s));
        let longest = zones.chain(detectors).chain(pumps).max().unwrap_or(0);
        super::ms(longest.max(config.run_on_s)).max(self.rules.overdue_ms)
    }
}
