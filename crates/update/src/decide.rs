//! Which slot is started: a function of the record and of what verifies.

use crate::image::Header;
use crate::record::{Other, Record, Recorded, Slot};
use crate::refusal::Refusal;

/// An image that verifies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verified {
    /// Its header.
    pub header: Header,
    /// It has been confirmed, or did not come over the link.
    pub trusted: bool,
}

/// What a start does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The slot to start, and its header; `None` when no image may be started.
    pub start: Option<(Slot, Header)>,
    /// The image is on trial: the next start goes back unless it has been confirmed.
    pub trial: bool,
    /// What has to be stored.
    pub record: Option<Record>,
}

/// Decides what to start. `noted`: the committed image has been stored as [`Other::Tried`] by now,
/// so it may be looked at. `image` verifies the image of a slot, with keys revoked as it is given.
pub fn decide(
    recorded: &Recorded,
    noted: bool,
    mut image: impl FnMut(Slot, u16) -> Result<Verified, Refusal>,
) -> Decision {
    let record = match recorded {
        Recorded::Known(record) => *record,
        Recorded::Fresh | Recorded::Lost => return without_record(image),
    };
    let spare = record.active.other();
    match record.other {
        Other::Committed if noted => match image(spare, record.revoked) {
            Ok(Verified { header, .. }) if record.admits(&header) => {
                Decision { start: Some((spare, header)), trial: true, record: None }
            }
            _ => go_back(&record, image),
        },
        Other::Tried => go_back(&record, image),
        Other::Committed | Other::Empty | Other::Kept | Other::Failed => keep_on(&record, image),
    }
}

/// The trial is over.
fn go_back(record: &Record, image: impl FnMut(Slot, u16) -> Result<Verified, Refusal>) -> Decision {
    let record = Record { other: Other::Failed, ..*record };
    keep_on(&record, image).with(Some(record))
}

/// The active image, or what is next best.
fn keep_on(
    record: &Record,
    mut image: impl FnMut(Slot, u16) -> Result<Verified, Refusal>,
) -> Decision {
    let slot = record.active;
    if let Ok(Verified { header, .. }) = image(slot, record.revoked) {
        return Decision { start: Some((slot, header)), trial: false, record: None };
    }
    let spare = slot.other();
    match (record.other, image(spare, record.revoked)) {
        // It was confirmed once.
        (Other::Kept, Ok(Verified { header, .. })) if header.layouts.reads(record.layout) => {
            let record = Record { active: spare, other: Other::Failed, ..*record };
            Decision { start: Some((spare, header)), trial: false, record: Some(record) }
        }
        // Better once more on trial than nothing.
        (Other::Kept | Other::Failed, Ok(Verified { header, .. })) => {
            let record = Record { other: Other::Tried, ..*record };
            Decision { start: Some((spare, header)), trial: true, record: Some(record) }
        }
        // So is a trial that could not be noted.
        (Other::Committed, Ok(Verified { header, .. })) if record.admits(&header) => {
            Decision { start: Some((spare, header)), trial: true, record: None }
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

/// The newest image that is trusted. One that is not, where there is no other, is on trial: it may
/// be one that was never committed, or that has failed.
fn without_record(mut image: impl FnMut(Slot, u16) -> Result<Verified, Refusal>) -> Decision {
    let images = Slot::BOTH.map(|slot| image(slot, 0).ok().map(|image| (slot, image)));
    let rank = |image: &Verified| (image.trusted, image.header.version);
    let best = match images {
        [Some(a), Some(b)] => Some(if rank(&b.1) > rank(&a.1) { b } else { a }),
        [a, b] => a.or(b),
    };
    Decision {
        start: best.map(|(slot, image)| (slot, image.header)),
        trial: best.is_some_and(|(_, image)| !image.trusted),
        record: None,
    }
}
