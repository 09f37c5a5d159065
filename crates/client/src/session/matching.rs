//! Assignment of answers to requests (§1, §2); answers that do not match are rejected.

use lafet_proto::{Record, Status, SubsystemId};
use smallvec::SmallVec;

use crate::answers::{AnswerBuf, Answers, RequestBuf};

/// The answer of a frame to one request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Slot {
    /// It was answered.
    Answered(Answers),
    /// Not executed: the output buffer was full before its turn came (§1).
    NotExecuted,
}

/// What became of the requests of a frame: one slot for each.
pub type Slots = SmallVec<[Slot; 1]>;

/// Assigns the answers of a frame to its requests, in order (§1); `None` if the frame cannot answer
/// these requests.
pub fn deal(requests: &[RequestBuf], records: &[Record<'_>]) -> Option<Slots> {
    if let ([request], [record]) = (requests, records)
        && !request.is_group()
    {
        single(request, records)?;
        let answer = Answers::one(request.to(), AnswerBuf::new(record));
        let slots = Slots::from_buf([Slot::Answered(answer)]);
        debug_assert_eq!(deal_out(requests, records).as_ref(), Some(&slots));
        return Some(slots);
    }
    deal_out(requests, records)
}

fn deal_out(requests: &[RequestBuf], records: &[Record<'_>]) -> Option<Slots> {
    let mut rest = records;
    let mut full = false;
    let mut slots = Slots::with_capacity(requests.len());
    for request in requests {
        if full {
            slots.push(Slot::NotExecuted);
            continue;
        }
        // General's last record instead of an answer: no request from here on was executed. If it
        // is the only record, it remains an answer, because sending the same again would not help.
        if let [last] = rest
            && last.is_full()
            && !slots.is_empty()
            && !(last.request == request.id() && request.to() == SubsystemId::GENERAL)
            && requests.iter().any(|other| other.id() == last.request)
        {
            rest = &[];
            full = true;
            slots.push(Slot::NotExecuted);
            continue;
        }
        let count = if request.is_group() { group(request, rest)? } else { single(request, rest)? };
        let (answers, others) = rest.split_at(count);
        slots.push(Slot::Answered(Answers::new(request.to(), answers.iter().map(AnswerBuf::new))?));
        rest = others;
        // A subsystem without room reports it, and General adds that the others were not executed
        // (§1, note).
        let lacks_room = answers.last().is_some_and(|record| record.status == Status::NO_ROOM);
        if lacks_room && matches!(rest, [] | [_]) && rest.iter().all(Record::is_full) {
            rest = &[];
            full = true;
        }
    }
    rest.is_empty().then_some(slots)
}

/// Number of records that answer a request to one subsystem: one.
fn single(request: &RequestBuf, records: &[Record<'_>]) -> Option<usize> {
    records.first().is_some_and(|record| request.asked().is_answered_by(record)).then_some(1)
}

/// Number of records that answer a request to All or Motors: each subsystem answers once.
fn group(request: &RequestBuf, records: &[Record<'_>]) -> Option<usize> {
    let mut seen = [false; 256];
    let count = records
        .iter()
        .take_while(|record| {
            let double = &mut seen[usize::from(record.device.0)];
            request.asked().is_answered_by(record) && !std::mem::replace(double, true)
        })
        .count();
    // Unknown subsystems may be among them, but no monitor consists only of those.
    records[..count].iter().any(|record| record.device.name().is_some()).then_some(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::request::Body;
    use lafet_proto::{ParamId, Request, RequestId};

    fn buf(to: SubsystemId, body: Body<'_>) -> RequestBuf {
        RequestBuf::new(&Request::new(to, body)).expect("fits a record")
    }

    fn record(request: RequestId, device: SubsystemId, status: Status) -> Record<'static> {
        Record { request, device, status, data: &[] }
    }

    fn believed(request: &RequestBuf, records: &[Record<'_>]) -> bool {
        deal(std::slice::from_ref(request), records).is_some()
    }

    /// §3.1/1, /2, /6: the subsystems that may answer in the addressee's stead, with their answers.
    #[test]
    fn interceptors_may_only_refuse() {
        let moving = buf(SubsystemId::VERTICAL, Body::Move { destination: 1 });
        let from = |who, status| believed(&moving, &[record(RequestId::MOVE, who, status)]);
        assert!(from(SubsystemId::VERTICAL, Status::ACCEPTED));
        assert!(from(SubsystemId::VERTICAL, Status::MODULE_NOT_EXIST));
        assert!(from(SubsystemId::DEPLOYER, Status::DENIED));
        assert!(from(SubsystemId::DETECTOR, Status::DENIED));
        assert!(from(SubsystemId::GENERAL, Status::DENIED));
        for who in [SubsystemId::DEPLOYER, SubsystemId::HORIZONTAL, SubsystemId::GENERAL] {
            assert!(!from(who, Status::OK), "{who} cannot do it for Vertical");
        }
        assert!(!from(SubsystemId::HORIZONTAL, Status::DENIED));
        assert!(!from(SubsystemId::VALVE1, Status::DENIED));
        assert!(!believed(&moving, &[record(RequestId::STOP, SubsystemId::VERTICAL, Status::OK)]));
        assert!(!believed(&moving, &[]));

        let wrap = buf(SubsystemId::DEPLOYER, Body::Wrap);
        assert!(believed(&wrap, &[record(RequestId::WRAP, SubsystemId::VALVE1, Status::DENIED)]));
        // §3.4: only the addressee handles the request.
        let reading = buf(SubsystemId::VERTICAL, Body::GetStatus);
        let denied = record(RequestId::GET_STATUS, SubsystemId::DEPLOYER, Status::DENIED);
        assert!(!believed(&reading, &[denied]));
    }

    #[test]
    fn one_request_has_one_answer() {
        let moving = buf(SubsystemId::VERTICAL, Body::Move { destination: 1 });
        let answer = record(RequestId::MOVE, SubsystemId::VERTICAL, Status::OK);
        assert!(!believed(&moving, &[answer, answer]));
    }

    /// §3.4, §3.21: the parameter's id is repeated.
    #[test]
    fn another_parameter_is_not_believed() {
        let request = buf(SubsystemId::DETECTOR, Body::GetParam { id: ParamId::HOTBEDS });
        let answer = |status, data| {
            let (request, device) = (RequestId::GET_PARAM, SubsystemId::DETECTOR);
            [Record { request, device, status, data }]
        };
        assert!(believed(&request, &answer(Status::OK, &[0xFE, 0x23])));
        assert!(!believed(&request, &answer(Status::OK, &[0xFE, 0x24, 0, 0, 0, 0])));
        assert!(!believed(&request, &answer(Status::OK, &[])));
        assert!(!believed(&request, &answer(Status::OK, &[0xFE])));
        assert!(believed(&request, &answer(Status::INVALID_ID, &[])));
        assert!(!believed(&request, &answer(Status::INVALID_ID, &[1, 2])));
    }

    /// §1: answers to All are adjacent, followed by those to the next request.
    #[test]
    fn answers_are_dealt_out_in_order() {
        let requests = [
            buf(SubsystemId::ALL, Body::Stop),
            buf(SubsystemId::VERTICAL, Body::GetStatus),
            buf(SubsystemId::VERTICAL, Body::GetStatus),
        ];
        let stop = |who| record(RequestId::STOP, who, Status::OK);
        let status = record(RequestId::GET_STATUS, SubsystemId::VERTICAL, Status::OK);
        let answers = [stop(SubsystemId::CONTROL), stop(SubsystemId::NOZZLE), status, status];
        let slots = deal(&requests, &answers).expect("they match");
        let counts: Vec<_> = slots
            .iter()
            .map(|slot| match slot {
                Slot::Answered(answers) => answers.len(),
                Slot::NotExecuted => 0,
            })
            .collect();
        assert_eq!(counts, [2, 1, 1]);
        assert_eq!(deal(&requests, &answers[..3]), None, "one too few");
        assert_eq!(deal(&requests[..2], &answers), None, "one too many");
        let double = [stop(SubsystemId::CONTROL), stop(SubsystemId::CONTROL), status, status];
        assert_eq!(deal(&requests, &double), None, "no subsystem answers twice");
    }

    /// §1, §2 NoRoom: the subsystem without room reports it, General adds one record for all that
    /// follow.
    #[test]
    fn no_room_tells_what_was_not_executed() {
        let requests = [
            buf(SubsystemId::VERTICAL, Body::GetStatus),
            buf(SubsystemId::ALL, Body::GetStatus),
            buf(SubsystemId::VERTICAL, Body::Move { destination: 1 }),
        ];
        let status = |who, status| record(RequestId::GET_STATUS, who, status);
        let vertical = status(SubsystemId::VERTICAL, Status::OK);
        let partly = [
            vertical,
            status(SubsystemId::DEPLOYER, Status::OK),
            status(SubsystemId::CONTROL, Status::NO_ROOM),
        ];
        for last in [RequestId::MOVE, RequestId::GET_STATUS] {
            let mut answers = partly.to_vec();
            answers.push(record(last, SubsystemId::GENERAL, Status::NO_ROOM));
            let slots = deal(&requests, &answers).expect("they match");
            assert!(matches!(&slots[0], Slot::Answered(one) if !one.lacks_room()));
            assert!(matches!(&slots[1], Slot::Answered(all) if all.lacks_room()));
            assert_eq!(slots[2], Slot::NotExecuted);
        }
        // Only General answers for the rest.
        let answers = [vertical, status(SubsystemId::GENERAL, Status::NO_ROOM)];
        let requests = [requests[0].clone(), requests[0].clone(), requests[2].clone()];
        let slots = deal(&requests, &answers).expect("they match");
        assert_eq!(slots[1..], [Slot::NotExecuted, Slot::NotExecuted]);
        // Nothing fits: that is an answer.
        let alone = [status(SubsystemId::GENERAL, Status::NO_ROOM)];
        let slots = deal(&requests[..1], &alone).expect("it matches");
        assert!(matches!(&slots[0], Slot::Answered(one) if one.lacks_room()));
        // No record may follow.
        assert_eq!(deal(&requests, &[vertical, alone[0], vertical]), None);
    }
}
