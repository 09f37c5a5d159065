//! Which slot is started: a function of the record and of what verifies.

use crate::image::Header;
use crate::record::{Other, Record, Recorded, Slot};
use crate::refusal::Refusal;

/// What a start does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The slot to start, and its header; `None` when no image may be started.
    pub start: Option<(Slot, Header)>,
    /// The image is on trial: the next start goes back unless it has been confirmed.
    pub trial: bool,
    /// What has to be stored before. A trial does not begin when it cannot be.
    pub record: Option<Record>,
}

/// Decides what to start. `image` verifies the image of a slot, with keys revoked as it is given;
/// it is asked for no slot that is not about to be started.
pub fn decide(
    recorded: &Recorded,
    mut image: impl FnMut(Slot, u16) -> Result<Header, Refusal>,
) -> Decision {
    let record = match recorded {
        Recorded::Known(record) => *record,
        Recorded::Fresh | Recorded::Lost => return newest(image),
    };
    let active = (record.active, record.active.other());
    match record.other {
        Other::Committed => match image(active.1, record.revoked) {
            Ok(header) if header.version > record.floor || record.allowed => {
                let record = Record { other: Other::Tried, ..record };
                Decision { start: Some((active.1, header)), trial: true, record: Some(record) }
            }
            _ => go_back(&record, image),
        },
        Other::Tried => go_back(&record, image),
        Other::Empty | Other::Kept | Other::Failed => keep_on(&record, image).with(None),
    }
}

/// The trial is over.
fn go_back(record: &Record, image: impl FnMut(Slot, u16) -> Result<Header, Refusal>) -> Decision {
    let record = Record { other: Other::Failed, ..*record };
    keep_on(&record, image).with(Some(record))
}

/// The active image, or what is next best.
fn keep_on(
    record: &Record,
    mut image: impl FnMut(Slot, u16) -> Result<Header, Refusal>,
) -> Decision {
    let slot = record.active;
    if let Ok(header) = image(slot, record.revoked) {
        return Decision { start: Some((slot, header)), trial: false, record: None };
    }
    let spare = slot.other();
    match (record.other, image(spare, record.revoked)) {
        // It was confirmed once.
        (Other::Kept, Ok(header)) => {
            let record = Record { active: spare, other: Other::Failed, ..*record };
            Decision { start: Some((spare, header)), trial: false, record: Some(record) }
        }
        // Better once more on trial than nothing.
        (Other::Failed, Ok(header)) => {
            let record = Record { other: Other::Tried, ..*record };
            Decision { start: Some((spare, header)), trial: true, record: Some(record) }
        }
        _ => Decision { start: None, trial: false, record: None },
    }
}

impl Decision {
    /// What is stored if the start itself does not ask for more.
    fn with(self, record: Option<Record>) -> Self {
        Self { record: self.record.or(record), ..self }
    }
}

/// Without a record: the newest image that verifies.
fn newest(mut image: impl FnMut(Slot, u16) -> Result<Header, Refusal>) -> Decision {
    let images = Slot::BOTH.map(|slot| image(slot, 0).ok().map(|header| (slot, header)));
    let start = match images {
        [Some(a), Some(b)] => Some(if b.1.version > a.1.version { b } else { a }),
        [a, b] => a.or(b),
    };
    Decision { start, trial: false, record: None }
}
