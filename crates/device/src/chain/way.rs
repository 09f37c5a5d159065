//! Where the way of a request through the chain ends (ours): for those who explain an answer. It
//! makes the checks of `serve`, `unicast` and `broadcast` in the same order (§1/11), and changes nothing.

use super::{addressees, refusal_of_data};
use crate::composition::ChainSet;
use crate::device::Device;
use lafet_proto::request::Body;
use lafet_proto::{Record, Status, SubsystemId};

/// Where the way of a request ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// §3.18/2, §3.12/2 General looks before any other subsystem, and lets nothing of this kind pass.
    Closed(Status),
    /// §1/4 The document does not know this request: General answers.
    Unknown,
    /// §1/12 All or Motors may not be asked for it: General answers.
    Nobody,
    /// §1/5 Each of these answers, in the order of the chain.
    Everyone(ChainSet),
    /// §1/3 The addressee is not part of this monitor.
    Absent,
    /// §1/12 The addressee may not be asked for it.
    NotAddressee,
    /// §1/2 The state of this subsystem contradicts the request: it answers instead.
    Intercepted(SubsystemId, Status),
    /// §2/3, §2/4 The addressee cannot read the data.
    Data(Status),
    /// The addressee executes the request, or refuses it itself.
    Reached,
}

impl Device {
    /// Where the way of this request would end now.
    pub fn way(&self, record: &Record<'_>) -> Way {
        let Record { request, device: to, data, .. } = *record;
        if let Some(status) = self.general_refusal(request) {
            return Way::Closed(status);
        }
        let Some(who) = addressees(request) else { return Way::Unknown };
        if matches!(to, SubsystemId::ALL | SubsystemId::MOTORS) {
            let handlers = self.handlers(request, to == SubsystemId::MOTORS, who);
            let nobody = handlers == ChainSet::exactly(0);
            return if nobody { Way::Nobody } else { Way::Everyone(handlers) };
        }
        if !self.has(to) {
            return Way::Absent;
        }
        if !who.subsystems.contains(to) {
            return Way::NotAddressee;
        }
        if let Some((by, status)) = self.intercept(request, to) {
            return Way::Intercepted(by, status);
        }
        match Body::decode(request, data) {
            Ok(_) => Way::Reached,
            Err(error) => Way::Data(refusal_of_data(error.expected)),
        }
    }
}
