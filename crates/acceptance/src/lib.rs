//! Tests an installation of fire monitors against its plan: what `lafet site test` does, without I/O and clock (ours).
//!
//! ```text
//! plan (what was designed) ─┐
//! Wire (API of the hub) ────┼─▶ run: read ─▶ dry ─▶ Finding, one for each check and subject
//! Person (answers) ─────────┘        │          └▶ record: JSON, HTML
//!                                    └▶ judge: what was read, against plan and limit; pure
//! ```
//!
//! It depends on neither hub nor simulator: the answers of the API and what people say are all that it knows.
//! [`order`] has all that may be sent: nothing of it opens a valve, starts a pump, or touches a zone.
//! No compliance with any standard is claimed: a source is where a requirement was found.

pub mod calendar;
pub mod check;
pub mod facts;
pub mod finding;
pub mod html;
pub mod judge;
pub mod order;
pub mod plan;
pub mod record;
pub mod run;
pub mod sign;
pub mod wire;

pub use check::{Check, Stage};
pub use finding::{Finding, Findings, Verdict};
pub use plan::Plan;
pub use record::Record;
pub use run::{End, Outcome, Run};
pub use wire::{Answer, Asks, Failed, Person, Question, Stopped, Wire};
