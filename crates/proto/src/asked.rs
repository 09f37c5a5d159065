//! §1, §2: whether a record can be the answer to a request. Frames have no numbers: who answers, what, and
//! about which parameter is all that says to which request an answer belongs.

use crate::{ParamId, Record, RequestId, Status, SubsystemId};

/// What the answers to a request have to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// The request.
    pub request: RequestId,
    /// The addressee.
    pub to: SubsystemId,
    /// The parameter that is read or set (§3.4, §3.5, §3.21).
    pub param: Option<ParamId>,
}

impl Asked {
    /// That of the record of a request.
    pub fn of(record: &Record<'_>) -> Self {
        let param = match record.request {
            RequestId::GET_PARAM | RequestId::SET_PARAM => param_of(record.data),
            RequestId::GET_HOTBED => Some(ParamId::HOTBEDS),
            _ => None,
        };
        Self { request: record.request, to: record.device, param }
    }

    /// Whether a record can be the answer, or one of those to a request to All or Motors.
    // Each answer goes through it, in other crates.
    #[inline]
    pub fn is_answered_by(&self, answer: &Record<'_>) -> bool {
        answer.request == self.request
            && self.may_come_from(answer.device, answer.status)
            && self.fits_param(answer)
    }

    /// The addressee may answer anything; other subsystems may only refuse in its stead (§1).
    fn may_come_from(&self, from: SubsystemId, status: Status) -> bool {
        if self.to.is_group() {
            return !from.is_group();
        }
        if from == self.to {
            return true;
        }
        if status.is_success() {
            return false;
        }
        match from {
            SubsystemId::GENERAL => true,
            // «Обработчики» of §3.1, §3.2, §3.8–§3.11, §3.14, §3.16.
            SubsystemId::DEPLOYER
            | SubsystemId::DETECTOR
            | SubsystemId::CONTROL
            | SubsystemId::EXTERNAL_CONN
            | SubsystemId::RADIO => is_control(self.request),
            // An open valve forbids folding the barrel (ours).
            SubsystemId::VALVE1 | SubsystemId::VALVE2 => {
                self.request == RequestId::WRAP
                    || (self.request == RequestId::MOVE && self.to == SubsystemId::DEPLOYER)
            }
            _ => false,
        }
    }

    /// Whether an answer repeats the id of the parameter. A refusal may omit it.
    fn fits_param(&self, answer: &Record<'_>) -> bool {
        let omits = answer.data.is_empty() && !answer.status.is_success();
        self.param.is_none() || omits || param_of(answer.data) == self.param
    }
}

/// The parameter with which data begin.
fn param_of(data: &[u8]) -> Option<ParamId> {
    data.first_chunk().map(|id| ParamId(u16::from_le_bytes(*id)))
}

fn is_control(request: RequestId) -> bool {
    matches!(
        request,
        RequestId::MOVE
            | RequestId::STOP
            | RequestId::OPEN
            | RequestId::CLOSE
            | RequestId::DEPLOY
            | RequestId::WRAP
            | RequestId::START_JUSTIFY
            | RequestId::START_QUENCH
            | RequestId::START_TRAJECTORY
            | RequestId::START_SEEK
            | RequestId::SWITCH_LIMITS
    )
}
