//! What a monitor was before it was restarted with a new image, and what is different on trial.

use lafet_proto::SubsystemId;
use lafet_proto::flags::{DetectorFlags, SetFlag, Severity, set_flags};

use super::error::Change;
use crate::status::MonitorStatus;

/// No monitor has more subsystems.
const MOST: usize = 32;

/// What a monitor was before it was restarted with a new image: the subsystems that answered with their state, and
/// the flags of each that say that something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Before {
    all: Vec<(SubsystemId, u32)>,
}

impl Before {
    /// What it is now.
    pub fn new(status: &MonitorStatus) -> Self {
        let bits = |id| wrong(id, status).fold(0, |bits, flag| bits | flag.info.mask());
        Self { all: status.present().map(|id| (id, bits(id))).collect() }
    }

    /// Without what it was: these have to answer, with any flags.
    pub(super) fn unknown(present: impl IntoIterator<Item = SubsystemId>) -> Self {
        Self { all: present.into_iter().map(|id| (id, u32::MAX)).collect() }
    }

    /// As a line: `c2:00040000 0d:00000000`, the numbers of the subsystems and their flags in hexadecimal digits.
    pub fn to_text(&self) -> String {
        let all: Vec<String> =
            self.all.iter().map(|(id, bits)| format!("{:02x}:{bits:08x}", id.0)).collect();
        all.join(" ")
    }

    /// Reads such a line; `None` if it is anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let digits = |text: &str, len| {
            let whole = text.len() == len && text.bytes().all(|digit| digit.is_ascii_hexdigit());
            whole.then(|| u32::from_str_radix(text, 16).ok()).flatten()
        };
        let one = |text: &str| {
            let (id, bits) = text.split_once(':')?;
            Some((SubsystemId(digits(id, 2)?.try_into().ok()?), digits(bits, 8)?))
        };
        let all: Vec<_> = text.split(' ').take(MOST + 1).map(one).collect::<Option<_>>()?;
        (all.len() <= MOST).then_some(Self { all })
    }

    /// Subsystems that are missing, and faults that are new.
    pub(super) fn changes(&self, status: &MonitorStatus) -> Vec<Change> {
        let mut changes = Vec::new();
        for (id, before) in &self.all {
            if status.flags(*id).is_none() {
                changes.push(Change::Absent(*id));
            }
            let new = wrong(*id, status).filter(|flag| flag.info.mask() & before == 0);
            changes.extend(new.map(|flag| Change::Fault { who: *id, flag: flag.info.name }));
        }
        changes
    }
}

/// The flags of a subsystem that say that something is wrong. Of General all from Warning up. Of the others those of
/// a function that is lost: what is less comes with a start (Limitless) or from outside (a button that is held), and
/// a fire is no fault.
fn wrong(id: SubsystemId, status: &MonitorStatus) -> impl Iterator<Item = SetFlag> {
    let least = if id == SubsystemId::GENERAL { Severity::Warning } else { Severity::Alarm };
    let fire = if id == SubsystemId::DETECTOR { DetectorFlags::FOUND.bits() } else { 0 };
    set_flags(id, status.flags(id).unwrap_or(0))
        .filter(move |flag| flag.severity() >= least && flag.info.mask() & fire == 0)
}
