//! The buses as clients see them.

use serde::Serialize;
use utoipa::ToSchema;

use super::drive::{Drives, Trouble};
use super::watch::Reading;
use super::wire::Failure;
use crate::text::Both;

/// The buses.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ModbusView {
    /// In the order of the file.
    pub buses: Vec<ModbusBus>,
}

/// A bus.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ModbusBus {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub url: String,
    /// The line is open.
    pub connected: bool,
    /// Age of the latest right answer, ms; left out: none since the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub answered_ms_ago: Option<u64>,
    /// Requests sent.
    pub requests: u64,
    /// Right answers.
    pub answers: u64,
    /// Failures by kind.
    pub errors: ModbusErrors,
    /// The latest failure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last_error: Option<ModbusProblem>,
    /// The detectors on it.
    pub detectors: Vec<ModbusSource>,
    /// The contacts on it.
    pub inputs: Vec<ModbusSource>,
    /// The outputs and pumps on it.
    pub outputs: Vec<ModbusOutput>,
}

/// Failures since the start, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ModbusErrors {
    /// The line could not be opened.
    pub open: u64,
    /// The connection was lost.
    pub closed: u64,
    /// No answer in time.
    pub timeout: u64,
    /// The device has refused.
    pub exception: u64,
    /// An answer of another device, to another function, or with another number of values.
    pub wrong: u64,
    /// What came was no frame.
    pub garbage: u64,
    /// Answers that came after their time, over TCP.
    pub late: u64,
}

impl ModbusErrors {
    /// Counts a failure.
    pub fn count(&mut self, failure: &Failure) {
        let count = match failure {
            Failure::Timeout => &mut self.timeout,
            Failure::Exception(_) => &mut self.exception,
            Failure::WrongUnit(_)
            | Failure::WrongFunction(_)
            | Failure::WrongLength
            | Failure::WrongEcho => &mut self.wrong,
            Failure::GivenUp => return,
            Failure::Garbage => &mut self.garbage,
            Failure::Closed(_) => &mut self.closed,
        };
        *count += 1;
    }
}

/// A failure.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ModbusProblem {
    /// When, ms since 1970.
    pub at_ms: u64,
    /// Address of the device; left out: the line itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<u8>,
    /// What was wrong.
    pub what: Both,
}

/// A detector or a contact on a bus.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ModbusSource {
    /// Its id.
    pub id: String,
    /// Address of its device.
    pub unit: u8,
    /// How it is read.
    pub reading: Reading,
    /// Age of its values, ms; left out: none since the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read_ms_ago: Option<u64>,
}

/// An output or a pump on a bus.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ModbusOutput {
    /// Its id.
    pub id: String,
    /// What it drives.
    pub drives: Drives,
    /// Address of the device.
    pub unit: u8,
    /// As the zone controller ordered it last; left out: no order since the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted: Option<bool>,
    /// The latest write that the device has answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<bool>,
    /// Age of that write, ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written_ms_ago: Option<u64>,
    /// What was read back; left out: nothing, or a value that is neither on nor off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read_back: Option<bool>,
    /// What its feedback says, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedback: Option<bool>,
    /// Age of what was read, ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read_ms_ago: Option<u64>,
    /// What is wrong with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trouble: Option<Trouble>,
}
