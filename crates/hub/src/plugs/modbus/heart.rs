//! The heartbeat of a master: whether it is alive. No clock of its own.

use std::time::Duration;

use super::desk::Now;

/// A heartbeat is alive once it has changed in time for this long: changes that a network has held up and delivers
/// together are no sign of life.
pub const SPAN: Duration = Duration::from_millis(500);

/// The heartbeat of a master.
#[derive(Clone, Copy, Debug)]
pub struct Heart {
    /// It changes within this time.
    pub limit: Duration,
    /// As heard last.
    pub value: Option<u16>,
    /// It is alive.
    pub live: bool,
    /// How often it was lost.
    pub losses: u16,
    changed: Now,
    /// Since when it changes in time.
    since: Now,
}

/// What a value of the heartbeat says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pulse {
    /// Nothing: it is the one before, or it is not alive yet.
    Nothing,
    /// It has come alive.
    Back,
    /// It goes on.
    Beats,
}

impl Heart {
    /// One of which nothing was heard yet.
    pub const fn new(limit: Duration, now: Now) -> Self {
        Self { limit, value: None, live: false, losses: 0, changed: now, since: now }
    }

    /// When it is lost, unless it changes before; `None`: it is not alive.
    pub fn deadline(&self) -> Option<Now> {
        self.live.then(|| self.changed + self.limit)
    }

    /// A value was written.
    pub fn beat(&mut self, now: Now, value: u16) -> Pulse {
        if self.value == Some(value) {
            return Pulse::Nothing;
        }
        let in_time = self.value.is_some() && now < self.changed + self.limit;
        if !in_time {
            self.since = now;
        }
        (self.value, self.changed) = (Some(value), now);
        if self.live {
            return Pulse::Beats;
        }
        self.live = in_time && now >= self.since + SPAN;
        if self.live { Pulse::Back } else { Pulse::Nothing }
    }

    /// It is lost; `false`: it was not alive.
    pub fn lose(&mut self) -> bool {
        let was_live = std::mem::replace(&mut self.live, false);
        self.losses = self.losses.wrapping_add(u16::from(was_live));
        was_live
    }
}
