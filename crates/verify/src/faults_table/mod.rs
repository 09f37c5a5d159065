//! How each flag and each status is reached: `conformance/faults.txt`, read, completed and run.
//!
//! A block of the file names flags of subsystems (§3.3), or a status (§2), the lines of a scenario
//! that prepare it, the one that brings it about, and the time within which it must show. Each
//! flag of each subsystem is a row: before the last line the flag must not be set, after it the
//! time is taken until GetStatus shows it. What the device never sets has its reason instead.
//!
//! ```text
//! let far Vertical=21600 Nozzle=-21600      {far} in the lines below, by subsystem or by flag
//! section Drives                            a heading of the page
//! flag PositionWayFault of Vertical Nozzle  {Subsystem}, {subsystem}, {Flag} stand for the row's
//! state deployed                            lines of conformance/scenarios/README.md
//! then ! Move {Subsystem} {far}             the line that brings it about
//! within 1s                                 of virtual time; more needs `because REASON`
//!
//! flag UpButtonState = Short of Buttons     a state of a button: Released, Pressed, Short, Open
//! status Denied                             `then > REQUEST` with its `< ANSWER`
//! never REASON                              instead of the lines: it is not reached, by decision
//! ```

mod detected;
mod page;
mod parse;

use lafet_proto::flags::{ButtonState, FlagInfo, Severity, flags_of};
use lafet_proto::{Status, SubsystemId};
use lafet_sim::fault::Fault;
use lafet_sim::scenario::{Failure, Scenario};

pub use detected::detected;
pub use page::page;

/// A fault is reported within this time, ms; whatever takes longer says why.
pub const TOLD_MS: u64 = 1000;

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A flag of a subsystem.
    Flag(SubsystemId, &'static FlagInfo),
    /// A state of a button of a post.
    Button(SubsystemId, &'static FlagInfo, ButtonState),
    /// A status of an answer.
    Status(Status),
}

/// A row.
#[derive(Clone, Debug)]
pub struct Row {
    /// What it is about.
    pub subject: Subject,
    /// The block of the file that it comes from.
    pub block: usize,
    /// How it is reached, as a scenario with one case; `None` for what the device never sets.
    case: Option<Scenario>,
    /// The faults that it injects.
    faults: Vec<Fault>,
}

/// A table that has run: each row with the time until it shows, ms; `None` for what the device never sets.
#[derive(Debug)]
pub struct Measured<'t> {
    table: &'t Table,
    rows: Vec<(&'t Row, Option<u64>)>,
}

/// A block: the same way for several flags and subsystems.
#[derive(Clone, Debug, Default)]
struct Block {
    line: usize,
    section: String,
    flags: Vec<&'static str>,
    state: Option<ButtonState>,
    of: Vec<SubsystemId>,
    status: Option<Status>,
    /// What prepares, with placeholders.
    lines: Vec<(usize, String)>,
    /// What brings it about, and the answers to it.
    trigger: Vec<(usize, String)>,
    within: Option<(usize, u64)>,
    because: String,
    never: String,
}

/// The whole table.
#[derive(Clone, Debug)]
pub struct Table {
    blocks: Vec<Block>,
    /// The values of the placeholders, as the file has them.
    lets: Vec<(String, Vec<(String, String)>)>,
    /// Its rows, in the order of the file.
    pub rows: Vec<Row>,
}

impl core::fmt::Display for Subject {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let name = |id: &SubsystemId| id.name().unwrap_or("?");
        match self {
            Self::Flag(id, flag) => write!(f, "{} {}", name(id), flag.name),
            Self::Button(id, flag, state) => write!(f, "{} {}={state:?}", name(id), flag.name),
            Self::Status(status) => f.write_str(status.name().unwrap_or("?")),
        }
    }
}

impl Subject {
    /// The flag with its state, as the page writes it; empty for a status.
    fn flag_name(&self) -> String {
        match self {
            Self::Flag(_, flag) => flag.name.to_owned(),
            Self::Button(_, flag, state) => format!("{}={state:?}", flag.name),
            Self::Status(_) => String::new(),
        }
    }

    /// How much it matters; a status is the answer to who asked, no more.
    pub fn severity(&self) -> Option<Severity> {
        match self {
            Self::Flag(_, flag) => Some(flag.severity),
            Self::Button(_, flag, state) => Some(flag.severity_in((*state as u32) << flag.shift)),
            Self::Status(_) => None,
        }
    }

    /// Everything that the table must have: each flag of each subsystem that has it, each state of
    /// each button, each status.
    pub fn all() -> Vec<Self> {
        const STATES: [ButtonState; 4] =
            [ButtonState::Released, ButtonState::Pressed, ButtonState::Short, ButtonState::Open];
        let mut all = Vec::new();
        for id in SubsystemId::TABLE {
            for flag in flags_of(id).flags {
                match flag.width {
                    2 => all.extend(STATES.map(|state| Self::Button(id, flag, state))),
                    _ => all.push(Self::Flag(id, flag)),
                }
            }
        }
        all.extend(Status::KNOWN.iter().map(|(status, _)| Self::Status(*status)));
        all
    }
}

impl Row {
    /// Whether the device sets it at all.
    pub const fn is_reached(&self) -> bool {
        self.case.is_some()
    }

    /// Runs it; the virtual time from what brings it about until it shows, ms. `None` for what
    /// the device never sets.
    pub fn run(&self) -> Result<Option<u64>, Failure> {
        match &self.case {
            None => Ok(None),
            Some(case) => Ok(Some(case.run(&mut |_| {})?.last_wait_ms)),
        }
    }
}

impl Table {
    /// Reads the file.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        parse::table(file, text)
    }

    /// Runs every row; an error is all of those that do not hold.
    pub fn measure(&self) -> Result<Measured<'_>, Vec<Failure>> {
        let mut failures = Vec::new();
        let mut rows = Vec::new();
        for row in &self.rows {
            match row.run() {
                Ok(time) => rows.push((row, time)),
                Err(failure) => failures.push(failure),
            }
        }
        if failures.is_empty() { Ok(Measured { table: self, rows }) } else { Err(failures) }
    }

    /// What is missing, and what is both reached and said to be never set.
    pub fn holes(&self) -> Vec<String> {
        let mut holes = Vec::new();
        for subject in Subject::all() {
            let mut ways = self.rows.iter().filter(|row| row.subject == subject);
            let Some(first) = ways.next() else {
                holes.push(format!("{subject}: no row"));
                continue;
            };
            if ways.any(|row| row.is_reached() != first.is_reached()) {
                holes.push(format!("{subject}: reached and never set"));
            }
        }
        holes
    }
}
