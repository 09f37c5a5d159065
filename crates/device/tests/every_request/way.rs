//! Where [`lafet_device::Way`] says that a request ends, the answer comes from.

use lafet_device::Way;
use lafet_proto::record::Records;
use lafet_proto::{Record, Status, SubsystemId};

/// Whether the answer is what the way leads to.
pub fn leads_to(way: Way, to: u8, answer: &[u8]) -> bool {
    let mut records = Records::new(answer).flatten();
    let mut one = |from: SubsystemId, status: Option<Status>| {
        let answered = |it: Record<'_>| it.device == from && status.is_none_or(|s| it.status == s);
        records.next().is_some_and(answered) && records.next().is_none()
    };
    let to = SubsystemId(to);
    match way {
        Way::Closed(status) => one(SubsystemId::GENERAL, Some(status)),
        Way::Unknown | Way::Nobody => one(SubsystemId::GENERAL, Some(Status::WRONG_REQUEST)),
        Way::Absent => one(to, Some(Status::MODULE_NOT_EXIST)),
        Way::NotAddressee => one(to, Some(Status::WRONG_REQUEST)),
        Way::Intercepted(by, status) => one(by, Some(status)),
        Way::Data(status) => one(to, Some(status)),
        Way::Reached => one(to, None),
        Way::Everyone(handlers) => SubsystemId::CHAIN
            .into_iter()
            .filter(|id| handlers.contains(*id))
            .eq(records.map(|record| record.device)),
    }
}
