//! What happens in the world, for summaries and checks.

use std::collections::VecDeque;

/// Events kept at most: the oldest go first.
const EVENTS_MAX: usize = 256;

/// An event, with the time at which it happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Virtual time, ms.
    pub at_ms: u64,
    /// What happened.
    pub what: What,
}

/// What can happen in the world. Fires are numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// The monitor has power and its program starts.
    PoweredUp,
    /// The program was reset.
    Reset,
    /// The program failed and starts again.
    Crashed,
    /// A fire was lit.
    FireLit(usize),
    /// Water reached a fire for the first time.
    FireHit(usize),
    /// A fire is out.
    FireOut(usize),
    /// A fire flared up again.
    FireReignited(usize),
    /// The nozzle has water.
    JetOn,
    /// The nozzle has no more water.
    JetOff,
    /// Water flows into a folded barrel, which destroys it.
    FoldedBarrelFlooded,
}

/// Events that are not taken yet.
#[derive(Clone, Debug, Default)]
pub struct Events(VecDeque<Event>);

impl Events {
    /// Adds an event.
    pub fn note(&mut self, at_ms: u64, what: What) {
        if self.0.len() == EVENTS_MAX {
            self.0.pop_front();
        }
        self.0.push_back(Event { at_ms, what });
    }

    /// Takes all, oldest first.
    pub fn take(&mut self) -> Vec<Event> {
        self.0.drain(..).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept() {
        let mut events = Events::default();
        (0..1000).for_each(|at_ms| events.note(at_ms, What::Reset));
        let taken = events.take();
        assert_eq!((taken.len(), taken[0].at_ms, taken[255].at_ms), (256, 744, 999));
        assert!(events.take().is_empty());
    }
}
