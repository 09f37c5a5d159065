//! Number of requests in a frame, so that their answers fit the monitor's output buffer.

use lafet_proto::link::PAYLOAD_MAX;
use lafet_proto::param::{MAX_VALUES, Param};
use lafet_proto::record::HEADER_SIZE;
use lafet_proto::status::{FaultInfo, GeneralStatus, Hotbed, Limits, ThermoStatus};
use lafet_proto::{RequestId, SubsystemId};

use crate::answers::RequestBuf;
use crate::session::late_answers::Tag;
use crate::url::Framing;

/// Bytes for requests, or for answers, in a frame, without a tag and the two headers that report a
/// full buffer.
const ROOM: usize = PAYLOAD_MAX - Tag::SIZE - 2 * HEADER_SIZE;

/// Number of these requests that go into the next frame: at least one.
pub fn frame_len(requests: &[RequestBuf], framing: Framing) -> usize {
    // Bare records have no frame: with one request at a time the answer is unambiguous.
    if framing == Framing::Records {
        return requests.len().min(1);
    }
    let (mut asked, mut answered) = (0, 0);
    let mut previous: Option<&RequestBuf> = None;
    let fits = requests.iter().take_while(|request| {
        asked += request.bytes().len();
        answered += answer_max(request);
        // The answers of a group end at another request's answer, so two equal group requests must
        // not be adjacent.
        let apart = previous.is_none_or(|group| !group.is_group() || group.id() != request.id());
        let first = previous.is_none();
        previous = Some(request);
        first || (apart && asked <= ROOM && answered <= ROOM)
    });
    fits.count()
}

/// Most bytes of the answers to a request.
fn answer_max(request: &RequestBuf) -> usize {
    let subsystems = if request.is_group() { SubsystemId::TABLE.len() } else { 1 };
    let data = match request.id() {
        RequestId::GET_STATUS if request.is_group() => return group_status_max(),
        RequestId::GET_STATUS => ThermoStatus::SIZE,
        RequestId::GET_PARAM => 2 + 4 * values_max(request),
        RequestId::GET_HOTBED => 2 + Hotbed::SIZE * Hotbed::MAX,
        RequestId::SET_PARAM => 2,
        RequestId::RETRIEVE_LIMITS => Limits::SIZE,
        RequestId::GET_CRASH_DATA => FaultInfo::SIZE,
        id if id.name().is_some() => 0,
        _ => lafet_proto::record::DATA_MAX,
    };
    subsystems * (HEADER_SIZE + data)
}

/// All fourteen subsystems together: most have at most eight bytes of status.
const fn group_status_max() -> usize {
    SubsystemId::TABLE.len() * (HEADER_SIZE + 8) + ThermoStatus::SIZE + GeneralStatus::SIZE
}

fn values_max(request: &RequestBuf) -> usize {
    let param = request.param().and_then(|id| Param::find(request.to(), id));
    param.map_or(MAX_VALUES, |param| usize::from(param.spec().max_len))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::request::Body;
    use lafet_proto::{ParamId, Request};

    fn buf(to: SubsystemId, body: Body<'_>) -> RequestBuf {
        RequestBuf::new(&Request::new(to, body)).expect("fits a record")
    }

    #[test]
    fn answers_fit_the_buffer() {
        let status = buf(SubsystemId::VERTICAL, Body::GetStatus);
        assert_eq!(frame_len(&vec![status.clone(); 100], Framing::Link), ROOM / 20);
        assert_eq!(frame_len(&[status.clone(), status], Framing::Records), 1);
        let unknown = buf(SubsystemId::CONTROL, Body::GetParam { id: ParamId(1) });
        assert_eq!(frame_len(&[unknown.clone(), unknown], Framing::Link), 1);
        assert_eq!(frame_len(&[], Framing::Link), 0);
    }

    #[test]
    fn nothing_of_a_kind_follows_a_group() {
        let all = buf(SubsystemId::ALL, Body::GetStatus);
        let one = buf(SubsystemId::VERTICAL, Body::GetStatus);
        let stop = buf(SubsystemId::ALL, Body::Stop);
        assert_eq!(frame_len(&[all.clone(), one.clone()], Framing::Link), 1);
        assert_eq!(frame_len(&[one.clone(), all.clone(), stop, one], Framing::Link), 4);
        assert_eq!(frame_len(&[all.clone(), all], Framing::Link), 1);
    }
}
