//! Frames of a bus controller received on a line (observed): its grants, and that they are needed.
//!
//! In the role `active` one frame is sent for each grant, or an empty frame to the controller if
//! nothing is to be sent; in the role `direct` a received grant means that a controller manages the
//! line, and transmitting would disturb the others.

use std::time::Duration;

use lafet_proto::bus::{CONTROLLER, ProbeLimit};

use super::input::Incoming;
use super::line::Line;
use super::medium::{Framing, Role};
use super::{Now, Outcome};
use crate::bus::{Word, nothing_from, wanted};

/// Time for which a grant is valid: the controller waits 30 ms for a frame to start (observed).
const GRANT_LIFE: Duration = Duration::from_millis(25);
/// A controller that was not received for this long counts as absent.
const CONTROLLER_SILENT: Duration = Duration::from_secs(3);
/// With a controller on the bus, a grant is awaited for longer: the controller probes new consoles
/// one address after the other.
const GRANT_WAIT: Duration = Duration::from_secs(30);

/// State of the bus controller as received.
#[derive(Debug, Default)]
pub struct BusAccess {
    /// What the controller waits for from this side, with the time.
    word: Option<(Word, Now)>,
    /// Time of its last frame.
    controller: Option<Now>,
    /// Time of its last grant to any console.
    granting: Option<Now>,
    /// §L/8 Limits which of its probes are answered.
    probes: ProbeLimit,
    /// Start of the wait for a grant.
    waiting: Option<Now>,
}

impl BusAccess {
    /// Whether neither the controller nor this side waits for the other.
    pub const fn rests(&self) -> bool {
        self.word.is_none() && self.waiting.is_none()
    }
}

impl Line {
    /// Takes a frame of the controller; returns whether it was one to this side.
    pub(super) fn heard_controller(&mut self, now: Now, frame: &Incoming) -> bool {
        let own = self.config.addresses.source;
        // Any frame after a grant means that the turn is over.
        if self.bus.word.take().is_some() {
            self.granted = false;
        }
        let Some((dst, CONTROLLER)) = frame.addresses else { return false };
        if own == CONTROLLER || self.config.framing == Framing::Records {
            return false;
        }
        let word = wanted(&frame.payload);
        self.bus.controller = Some(now);
        if word == Some(Word::Granted) {
            self.bus.granting = Some(now);
        }
        if dst != own || self.config.role != Role::Active {
            return false;
        }
        match word {
            // The answer to a probe is empty as well, so two that answer each other need a limit.
            Some(Word::Probed) if !self.bus.probes.allows(now.as_millis() as u32) => true,
            Some(word) => {
                self.bus.word = Some((word, now));
                true
            }
            None => false,
        }
    }

    /// What the controller waits for, unless it is too late.
    pub(super) fn word(&mut self, now: Now) -> Option<Word> {
        let (word, since) = self.bus.word?;
        if now > since + GRANT_LIFE {
            self.bus.word = None;
            return None;
        }
        Some(word)
    }

    /// Replaces the contents of `wire` by our frame for the controller's grant or probe, or by the
    /// empty one.
    pub(super) fn answer_controller(&mut self, now: Now, word: Word, wire: &mut Vec<u8>) -> bool {
        if self.word_due().is_some_and(|until| now < until) {
            return false;
        }
        self.bus.word = None;
        let mut ours = false;
        if word == Word::Granted {
            self.bus.waiting = None;
            self.granted = true;
            ours = self.transmit_sessions(now, wire);
            self.granted = false;
        }
        if !ours {
            *wire = nothing_from(self.config.addresses.source);
            self.echo_sent(wire);
        }
        true
    }

    /// When the controller's grant or probe is answered. Other bytes after it hold back nothing
    /// urgent.
    fn word_due(&self) -> Option<Now> {
        let since = match self.bus.word {
            Some((_, since)) if self.is_urgent() => Some(since),
            _ => self.heard,
        };
        since.map(|since| since + self.config.turnaround)
    }

    /// Ends operations that wait for a grant in vain.
    pub(super) fn end_vain_waits(&mut self, now: Now) {
        match self.config.role {
            Role::Direct => {
                let outcome = if self.is_ordered(now) {
                    Outcome::ControllerPresent
                } else if self.noise.as_ref().is_some_and(|noise| noise.is_unreadable(now)) {
                    Outcome::Unreadable
                } else {
                    return;
                };
                self.sessions.iter_mut().for_each(|s| s.refuse_waiting(&outcome, false));
            }
            Role::Active => {
                if !self.sessions.iter().any(|session| session.wants(now).is_some()) {
                    self.bus.waiting = None;
                    return;
                }
                self.bus.waiting.get_or_insert(now);
                let Some(until) = self.patience_until() else { return };
                if now >= until {
                    self.bus.waiting = None;
                    let controller =
                        self.bus.controller.is_some_and(|heard| now < heard + CONTROLLER_SILENT);
                    let outcome = Outcome::NoGrant { controller };
                    self.sessions.iter_mut().for_each(|s| s.refuse_waiting(&outcome, true));
                }
            }
        }
    }

    /// Whether a controller grants access to others on this line, or may do so: one that has no console yet
    /// only probes.
    fn is_ordered(&self, now: Now) -> bool {
        // Where a monitor has answered, one that only probes is beside us, not before us.
        let heard = if self.is_guest() { self.bus.controller } else { self.bus.granting };
        heard.is_some_and(|heard| now < heard + CONTROLLER_SILENT)
    }

    /// Time until which a grant is awaited.
    fn patience_until(&self) -> Option<Now> {
        let since = self.bus.waiting?;
        let silent = since.max(self.bus.controller.unwrap_or_default()) + CONTROLLER_SILENT;
        Some(silent.min(since + GRANT_WAIT))
    }

    /// Time of the next call of [`Line::end_vain_waits`] or answer to the controller.
    pub(super) fn bus_timeout(&self, now: Now) -> Option<Now> {
        let word = self.bus.word.map(|_| self.word_due().unwrap_or(now).max(now));
        word.into_iter().chain(self.patience_until()).min()
    }
}
