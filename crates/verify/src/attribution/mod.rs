//! Attributable motion: an independent check that every output has a cause that holds (ours).
//!
//! The device says for each output why it is as it is ([`lafet_device::cause`]). This module does
//! not believe it. It keeps a [`ledger::Ledger`] of its own: frames that were really delivered and
//! what was answered, buttons that are really held, time. In every step it asks of every output
//! that moves, and of every output that has changed, whether the claimed cause is in the ledger and
//! justifies it:
//!
//! - a request was delivered through that interface, accepted, and not stopped or replaced since;
//! - a program descends from such a request, and the monitor still says that it runs;
//! - a button of that post is pressed now, and was released since the last stop;
//! - a rule takes away or closes, no more, and its condition holds in what is sensed.
//!
//! Beside it stand the invariants: no water from a folded barrel, no motion under lockout or out of
//! the limits, outputs inert after power-up; these look at the true world, not at the sensors.

mod answers;
mod buttons;
mod closing;
mod grants;
mod homing;
mod invariants;
mod jumps;
pub mod ledger;
mod output;
mod rules;
mod text;
mod units;
mod view;

#[cfg(test)]
mod tests;

pub use output::Output;
pub use text::{cause, program_name, rule, rule_name};
pub use view::{Told, View};

use invariants::Invariants;
use lafet_device::Source;
use lafet_device::cause::Causes;
use lafet_device::image::Outputs;
use lafet_device::params::Params;
use ledger::Ledger;

/// What must never happen, and has happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Virtual time, ms.
    pub at_ms: u64,
    /// Whether an output is not explained; otherwise an invariant does not hold.
    pub unexplained: bool,
    /// What, and why it must not be.
    pub text: String,
}

/// The check over one monitor.
#[derive(Clone, Debug)]
pub struct Attribution {
    ledger: Ledger,
    invariants: Invariants,
    outputs: Outputs,
    causes: Causes,
    changes: u64,
}

impl Attribution {
    /// A check that begins with a power-up at this moment.
    pub fn new(now_ms: u64) -> Self {
        Self {
            ledger: Ledger::new(now_ms),
            invariants: Invariants::default(),
            outputs: Outputs::default(),
            causes: Causes::all(lafet_device::cause::Rule::Inert),
            changes: 0,
        }
    }

    /// A frame was delivered through this interface, and this was answered: something is wrong when
    /// an answer is missing, or there is one to no request.
    pub fn delivered(
        &mut self,
        now_ms: u64,
        source: Source,
        payload: &[u8],
        answer: &[u8],
    ) -> Option<Violation> {
        let text = self.ledger.delivered(now_ms, source, payload, answer).err()?.to_owned();
        Some(Violation { at_ms: now_ms, unexplained: false, text })
    }

    /// The program starts again, with these parameters: after a power cut, a crash or a reset.
    pub fn powered_up(&mut self, now_ms: u64, params: &Params, memory_is_sound: bool) {
        self.ledger.powered_up(now_ms, params, memory_is_sound);
        self.outputs = Outputs::default();
    }

    /// Looks at the monitor after a step in which its program stood still: it can have seen and
    /// done nothing.
    pub fn stand_still(&self, view: &View<'_>) -> Vec<Violation> {
        let changed = |output: &Output| output.value(&self.outputs) != output.value(view.outputs);
        let violation = |output: Output| text::stood_still(view.now_ms, output);
        Output::all().filter(changed).map(violation).collect()
    }

    /// Looks at the monitor after a step of its program.
    pub fn check(&mut self, view: &View<'_>) -> Vec<Violation> {
        let mut found = Vec::new();
        for axis in self.ledger.sense(view) {
            found.push(text::not_homed(view.now_ms, axis));
        }
        let view = &View { offsets: self.ledger.homings.offsets(), ..*view };
        for output in Output::all() {
            let (before, after) = (output.value(&self.outputs), output.value(view.outputs));
            self.changes += u64::from(before != after);
            let step = rules::Step {
                output,
                before,
                after,
                cause: output.cause(view.causes),
                cause_before: output.cause(&self.causes),
            };
            if let Err(why) = rules::explain(&self.ledger, view, &step) {
                found.push(text::unexplained(view.now_ms, &step, why));
            }
            self.ledger.settle(&step, view);
        }
        self.ledger.homings.settle(view);
        self.invariants.check(&self.ledger, view, &mut found);
        self.ledger.forget(view);
        self.outputs = *view.outputs;
        self.causes = *view.causes;
        found
    }

    /// Changes of outputs so far.
    pub const fn changes(&self) -> u64 {
        self.changes
    }

    /// The ledger.
    pub const fn ledger(&self) -> &Ledger {
        &self.ledger
    }
}
