//! Deviations of an answer from the protocol; they are reported as such, not as a missing answer.

use std::fmt;

use lafet_proto::{DecodeError, ParamId, Record, RequestId, Status, SubsystemId};
use lafet_texts::{Argument, Lang, Shown, Text, Undecodable, client as text};

use crate::answers::{AnswerBuf, RequestBuf};
use crate::session::matching::deal;

/// A deviation of an answer from the protocol.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Deviation {
    /// Its data have the wrong size or form for this request and subsystem.
    Shape(DecodeError),
    /// It reports success without the data that the request asks for.
    NoData,
    /// Its status is not one of §2.
    UnknownStatus(Status),
    /// It repeats the id of another parameter (§3.4, §3.5).
    OtherParameter {
        /// The parameter asked for.
        asked: ParamId,
        /// The parameter of the answer.
        answered: ParamId,
    },
    /// It answers another request.
    OtherRequest {
        /// The request in the answer.
        answered: RequestId,
    },
    /// It comes from a subsystem that is not the addressee and may not answer for it (§1).
    OtherSubsystem {
        /// The addressee.
        asked: SubsystemId,
        /// The subsystem in the answer.
        answered: SubsystemId,
    },
    /// Its sender is not a subsystem of a monitor.
    NoSubsystem {
        /// The sender in the answer.
        answered: SubsystemId,
    },
    /// The number of answers differs from the number of requests (§1).
    Count {
        /// Records of the frame.
        answered: usize,
        /// Requests of the frame.
        asked: usize,
    },
}

impl Deviation {
    /// The message in a language: a clause without a full stop.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for Deviation {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Shape(error) => text::OddShape { error: Undecodable(error) }.write(lang, out),
            Self::NoData => text::OddNoData.write(lang, out),
            Self::UnknownStatus(status) => {
                text::OddStatus { status: Shown(status) }.write(lang, out)
            }
            Self::OtherParameter { asked, answered } => {
                text::OddOtherParameter { asked: Shown(asked), answered: Shown(answered) }
                    .write(lang, out)
            }
            Self::OtherRequest { answered } => {
                text::OddOtherRequest { answered: Shown(answered) }.write(lang, out)
            }
            Self::OtherSubsystem { asked, answered } => {
                text::OddOtherSubsystem { asked: Shown(asked), answered: Shown(answered) }
                    .write(lang, out)
            }
            Self::NoSubsystem { answered } => {
                text::OddNoSubsystem { answered: Shown(answered) }.write(lang, out)
            }
            Self::Count { answered, asked } => text::OddCount { answered, asked }.write(lang, out),
        }
    }
}

impl Text for Deviation {}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
    }
}

impl AnswerBuf {
    /// The deviation of this answer, if any: data of a wrong form, a success without the data asked
    /// for, or a status that is not in §2.
    pub fn deviation(&self) -> Option<Deviation> {
        if let Err(error) = self.decode() {
            return Some(Deviation::Shape(error));
        }
        if self.status().name().is_none() {
            return Some(Deviation::UnknownStatus(self.status()));
        }
        // A subsystem that is not in the document may have a state without data.
        let known = self.from().name().is_some();
        let empty = self.request().is_read()
            && known
            && self.status().is_success()
            && self.data().is_empty();
        empty.then_some(Deviation::NoData)
    }
}

/// The deviation of a frame that does not answer these requests; `None` if it does.
pub(crate) fn mismatch(requests: &[RequestBuf], records: &[Record<'_>]) -> Option<Deviation> {
    if deal(requests, records).is_some() {
        return None;
    }
    let count = Deviation::Count { answered: records.len(), asked: requests.len() };
    // A request to one subsystem has one record: the first pair that does not match.
    let singles = requests.iter().zip(records).take_while(|(request, _)| !request.is_group());
    let mut pairs = singles.filter(|(request, record)| {
        deal(std::slice::from_ref(request), std::slice::from_ref(record)).is_none()
    });
    // The records of a single group request all answer it; with several requests the first record
    // decides.
    let alone = requests.len() == 1;
    let group = requests.first().filter(|request| request.is_group()).and_then(|request| {
        let records = if alone { records } else { records.get(..1).unwrap_or_default() };
        records.iter().find_map(|record| pair(request, record))
    });
    let single = pairs.next().and_then(|(request, record)| pair(request, record));
    Some(single.or(group).unwrap_or(count))
}

fn pair(request: &RequestBuf, record: &Record<'_>) -> Option<Deviation> {
    if record.request != request.id() {
        return Some(Deviation::OtherRequest { answered: record.request });
    }
    if !request.is_group() && record.device != request.to() {
        let (asked, answered) = (request.to(), record.device);
        return Some(Deviation::OtherSubsystem { asked, answered });
    }
    if request.is_group() && (record.device.is_group() || record.device.name().is_none()) {
        return Some(Deviation::NoSubsystem { answered: record.device });
    }
    match (request.param()?, record.data) {
        (asked, [a, b, ..]) => {
            let answered = ParamId(u16::from_le_bytes([*a, *b]));
            (answered != asked).then_some(Deviation::OtherParameter { asked, answered })
        }
        _ => Some(Deviation::NoData),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::Request;
    use lafet_proto::request::Body;

    fn reading(id: u16) -> RequestBuf {
        let body = Body::GetParam { id: ParamId(id) };
        RequestBuf::new(&Request::new(SubsystemId::VERTICAL, body)).expect("fits a record")
    }

    fn answer(request: RequestId, device: SubsystemId, data: &[u8]) -> Record<'_> {
        Record { request, device, status: Status::OK, data }
    }

    #[test]
    fn a_frame_that_answers_something_else_says_what() {
        let (id, to) = (RequestId::GET_PARAM, SubsystemId::VERTICAL);
        let found = |records: &[Record<'_>]| mismatch(&[reading(7)], records);
        assert_eq!(found(&[answer(id, to, &[7, 0, 1, 0, 0, 0])]), None);
        let (asked, answered) = (ParamId(7), ParamId(8));
        let other = Deviation::OtherParameter { asked, answered };
        assert_eq!(found(&[answer(id, to, &[8, 0, 1, 0, 0, 0])]), Some(other));
        assert_eq!(found(&[answer(id, to, &[])]), Some(Deviation::NoData));
        let answered = RequestId::GET_STATUS;
        let other = Deviation::OtherRequest { answered };
        assert_eq!(found(&[answer(answered, to, &[])]), Some(other));
        let (asked, answered) = (to, SubsystemId::NOZZLE);
        let other = Deviation::OtherSubsystem { asked, answered };
        assert_eq!(found(&[answer(id, answered, &[7, 0])]), Some(other));
        assert_eq!(found(&[]), Some(Deviation::Count { answered: 0, asked: 1 }));
        let twice = [answer(id, to, &[7, 0]), answer(id, to, &[7, 0])];
        assert_eq!(found(&twice), Some(Deviation::Count { answered: 2, asked: 1 }));
    }

    #[test]
    fn a_group_is_answered_by_subsystems() {
        let (id, general) = (RequestId::GET_STATUS, SubsystemId::GENERAL);
        let all = RequestBuf::new(&Request::new(SubsystemId::ALL, Body::GetStatus));
        let all = [all.expect("fits a record")];
        let good = answer(id, general, &[0; 8]);
        let future = SubsystemId(0);
        assert_eq!(mismatch(&all, &[good, answer(id, future, &[])]), None);
        for answered in [SubsystemId::ALL, SubsystemId::MOTORS, future] {
            let none = Some(Deviation::NoSubsystem { answered });
            assert_eq!(mismatch(&all, &[answer(id, answered, &[])]), none);
        }
        let answered = SubsystemId::ALL;
        let found = mismatch(&all, &[good, answer(id, answered, &[0; 8])]);
        assert_eq!(found, Some(Deviation::NoSubsystem { answered }));
        let answered = RequestId::STOP;
        let found = mismatch(&all, &[good, answer(answered, general, &[])]);
        assert_eq!(found, Some(Deviation::OtherRequest { answered }));
    }

    #[test]
    fn success_without_data_and_unknown_statuses_are_deviations() {
        let of = |record: Record<'_>| AnswerBuf::new(&record).deviation();
        let (id, to) = (RequestId::GET_STATUS, SubsystemId::VERTICAL);
        assert_eq!(of(answer(id, to, &[])), Some(Deviation::NoData));
        assert_eq!(of(answer(id, to, &[0; 8])), None);
        assert!(matches!(of(answer(id, to, &[0; 7])), Some(Deviation::Shape(_))));
        assert_eq!(of(answer(RequestId::MOVE, to, &[])), None);
        assert_eq!(of(answer(id, SubsystemId(0), &[])), None, "a subsystem of the future");
        let status = Status(0xC8);
        let odd = Record { status, ..answer(id, to, &[]) };
        assert_eq!(of(odd), Some(Deviation::UnknownStatus(status)));
        let busy = Record { status: Status::BUSY, ..answer(id, to, &[]) };
        assert_eq!(of(busy), None, "a refusal needs no data");
    }
}
