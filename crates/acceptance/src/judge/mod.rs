//! What was read, against plan and limits: pure functions.

mod field;
mod monitors;
mod system;
mod zones;

pub use monitors::wrapped_deg;

use lafet_texts::{Fixed, Text, Words, acceptance as text};

use crate::facts::Facts;
use crate::finding::Findings;
use crate::plan::Plan;

/// The date of the hub may differ by so much, s.
pub const CLOCK_S: f64 = 2.0;
/// Least free room on the disk, bytes.
pub const FREE_BYTES: u64 = 1 << 30;
/// The same of a thousand.
pub const FREE_PERMILLE: u64 = 50;
/// Most lost exchanges of a link, of a thousand.
pub const LOSS_PERMILLE: f64 = 10.0;
/// A detector has to be noticed silent within, s.
pub const SILENT_S: u32 = 60;
/// Least coincidence of votes, s: more than five, in whole seconds at least five.
pub const COINCIDENCE_S: u32 = 5;
/// Greatest delay, s.
pub const DELAY_S: u32 = 60;
/// Greatest `WaterTimeout` of a monitor whose zones end their water sooner, s.
pub const WATER_S: u32 = 3600;
/// Places agree within, m.
pub const PLACE_M: f64 = 0.05;
/// Headings agree within, degrees.
pub const HEADING_DEG: f64 = 0.1;

/// Judges everything that was read.
pub fn read(plan: &Plan, facts: &Facts) -> Findings {
    let mut findings = Findings::default();
    system::judge(plan, facts, &mut findings);
    monitors::judge(plan, facts, &mut findings);
    zones::judge(plan, facts, &mut findings);
    field::judge(plan, facts, &mut findings);
    findings
}

/// Names in a line; a word for none.
pub fn names<T: AsRef<str>>(all: &[T]) -> Words {
    if all.is_empty() {
        return text::Nothing.words();
    }
    Words::same(all.iter().map(AsRef::as_ref).collect::<Vec<&str>>().join(", "))
}

/// Yes or no.
pub const fn yes(it: bool) -> Fixed {
    if it { text::Yes.fixed() } else { text::No.fixed() }
}

/// A value, or a word for an unknown one.
pub fn known(value: Option<impl std::fmt::Display>) -> Words {
    value.map_or_else(|| text::Unknown.words(), |it| Words::same(it.to_string()))
}
