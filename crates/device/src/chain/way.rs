//! Where the way of a request through the chain ends (ours): for those who explain an answer. It
//! makes the checks of `serve`, `unicast` and `broadcast` in the same order, and changes nothing.

use super::{addressees, refusal_of_data};
use crate::composition::ChainSet;
use crate::device::Device;
use lafet_proto::request::Body;
use lafet_proto::{Record, Status, SubsystemId};

/// Where the way of a request ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// General looks before any other subsystem, and lets nothing of this kind pass.
    Closed(Status),
    /// The document does not know this request: General answers.
    Unknown,
    /// All or Motors may not be asked for it: General answers.
    Nobody,
    /// Each of these answers, in the order of the chain.
    Everyone(ChainSet),
    /// The addressee is not part of this monitor.
    Absent,
    /// The addressee may not be asked for it.
    NotAddressee,
    /// The state of this subsystem contradicts the request: it answers instead.
    Intercepted(SubsystemId, Status),
    /// The addressee cannot read the data.
    Data(Status),
    /// The addressee executes the request, or refuses it itself.
    Reached,
}

impl Device {
    /// Where the way of this request would end now.
    pub fn way(&self, record: &Record<'_>) -> Way {
        let Record { request, device: to, data, .. } = *record;
        if let Some(status) = self.general_refusal(request, data) {
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
