//! Requests and answers that own their bytes.

use lafet_proto::id::key;
use lafet_proto::record::{HEADER_SIZE, Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{
    Answer, Asked, DecodeError, ParamId, Record, Request, RequestId, Status, SubsystemId,
};
use smallvec::SmallVec;

use crate::error::Error;
use crate::session::jog::MOVE_HOLD;

/// Bytes of the longest record.
const RECORD_MAX: usize = HEADER_SIZE + lafet_proto::record::DATA_MAX;

// Up to these sizes nothing is allocated.
/// Bytes of most requests.
const REQUEST_USUAL: usize = 16;
/// Bytes of data of most answers.
const DATA_USUAL: usize = 24;
/// Records of most frames to one subsystem: an answer, and the four of a number.
const RECORDS_USUAL: usize = 6;

/// Requests of one frame: usually one.
pub type Requests = SmallVec<[RequestBuf; 1]>;

/// An encoded request, with the properties that a session needs.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RequestBuf {
    bytes: SmallVec<[u8; REQUEST_USUAL]>,
    to: SubsystemId,
    id: RequestId,
    param: Option<ParamId>,
    locks: bool,
}

impl Clone for RequestBuf {
    fn clone(&self) -> Self {
        // The collection's own clone copies byte by byte.
        Self { bytes: SmallVec::from_slice(&self.bytes), ..*self }
    }
}

impl RequestBuf {
    /// Encodes a request.
    ///
    /// # Errors
    ///
    /// [`Error::Unsendable`] for more than 255 bytes of data (63 values of a parameter).
    pub fn new(request: &Request<'_>) -> Result<Self, Error> {
        let mut buffer = [0; RECORD_MAX];
        let mut writer = Writer::new(&mut buffer);
        let (to, id) = (request.to, request.body.id());
        request.encode(&mut writer).map_err(|_| Error::Unsendable { request: id, to })?;
        let param = match request.body {
            Body::GetParam { id } | Body::SetParam { id, .. } => Some(id),
            Body::GetHotbed => Some(ParamId::HOTBEDS),
            _ => None,
        };
        let locks = request.body == Body::Lockout { key: key::ENABLE };
        Ok(Self { bytes: SmallVec::from_slice(writer.written()), to, id, param, locks })
    }

    /// The bytes of the record.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The decoded request; data that are invalid for it are kept as
    /// [`Body::Unknown`](lafet_proto::request::Body::Unknown).
    pub fn request(&self) -> Request<'_> {
        let data = self.bytes.get(HEADER_SIZE..).unwrap_or_default();
        let record = Record { request: self.id, device: self.to, status: Status::OK, data };
        let unknown = Body::Unknown { request: self.id, data };
        Request::decode(&record).unwrap_or(Request::new(self.to, unknown))
    }

    /// The addressee.
    pub const fn to(&self) -> SubsystemId {
        self.to
    }

    /// The identifier of the request.
    pub const fn id(&self) -> RequestId {
        self.id
    }

    /// What its answers have to fit.
    pub const fn asked(&self) -> Asked {
        Asked { request: self.id, to: self.to, param: self.param }
    }

    /// The parameter that is read or set.
    pub const fn param(&self) -> Option<ParamId> {
        self.param
    }

    /// Whether it goes to All or Motors: every subsystem that supports the request answers (§1).
    pub fn is_group(&self) -> bool {
        self.to.is_group()
    }

    /// Whether it changes nothing in the monitor.
    pub fn is_read(&self) -> bool {
        self.id.is_read()
    }

    /// Whether it is Stop, Close or Lockout on: these are sent before waiting requests, and may be
    /// repeated.
    pub fn is_urgent(&self) -> bool {
        matches!(self.id, RequestId::STOP | RequestId::CLOSE) || self.locks
    }

    /// Whether executing it twice has the same effect as once.
    pub fn is_repeatable(&self) -> bool {
        let renews = self.id == RequestId::SET_PARAM && self.param == Some(MOVE_HOLD);
        self.is_read() || self.is_urgent() || renews
    }

    /// Whether it starts a motion, or allows one.
    pub fn sets_in_motion(&self) -> bool {
        matches!(
            self.id,
            RequestId::MOVE
                | RequestId::OPEN
                | RequestId::DEPLOY
                | RequestId::WRAP
                | RequestId::START_JUSTIFY
                | RequestId::START_QUENCH
                | RequestId::START_TRAJECTORY
                | RequestId::START_SEEK
        ) || (self.id == RequestId::LOCKOUT && !self.locks)
    }

    /// Whether `other`, submitted before this urgent request but not yet sent, must not be sent any
    /// more, because it would reverse the effect of this one.
    pub fn supersedes(&self, other: &Self) -> bool {
        other.sets_in_motion()
            && match self.id {
                RequestId::CLOSE => other.id == RequestId::OPEN && other.to == self.to,
                RequestId::STOP => match self.to {
                    SubsystemId::ALL => other.id != RequestId::LOCKOUT,
                    SubsystemId::MOTORS => other.to.is_drive() || other.to == SubsystemId::MOTORS,
                    to => other.to == to,
                },
                _ => self.locks,
            }
    }
}

/// An answer that owns its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerBuf {
    request: RequestId,
    from: SubsystemId,
    status: Status,
    data: SmallVec<[u8; DATA_USUAL]>,
}

impl AnswerBuf {
    /// Copies a record.
    pub fn new(record: &Record<'_>) -> Self {
        let Record { request, device, status, data } = *record;
        Self { request, from: device, status, data: SmallVec::from_slice(data) }
    }

    /// The identifier of the request that is answered.
    pub const fn request(&self) -> RequestId {
        self.request
    }

    /// The subsystem that answers: the addressee, or one that intercepted the request (§1).
    pub const fn from(&self) -> SubsystemId {
        self.from
    }

    /// The result (§2).
    pub const fn status(&self) -> Status {
        self.status
    }

    /// The data, not decoded.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// The answer as a record.
    pub fn record(&self) -> Record<'_> {
        Record { request: self.request, device: self.from, status: self.status, data: &self.data }
    }

    /// The decoded answer.
    ///
    /// # Errors
    ///
    /// [`DecodeError`] when the data have a size that an answer of this subsystem to this request
    /// cannot have.
    pub fn decode(&self) -> Result<Answer<'_>, DecodeError> {
        Answer::decode(&self.record())
    }
}

/// The answers to one request: one, or several when it went to All or Motors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answers {
    to: SubsystemId,
    /// Never empty.
    all: SmallVec<[AnswerBuf; 1]>,
}

impl Answers {
    /// The answers to a request to `to`; `None` if there are none.
    pub fn new(to: SubsystemId, all: impl IntoIterator<Item = AnswerBuf>) -> Option<Self> {
        let all: SmallVec<_> = all.into_iter().collect();
        if all.is_empty() { None } else { Some(Self { to, all }) }
    }

    /// The answer to a request to one subsystem.
    pub(crate) fn one(to: SubsystemId, answer: AnswerBuf) -> Self {
        Self { to, all: SmallVec::from_buf([answer]) }
    }

    /// The addressee of the request.
    pub const fn to(&self) -> SubsystemId {
        self.to
    }

    /// The first answer.
    pub fn first(&self) -> &AnswerBuf {
        &self.all[0]
    }

    /// The first refusal among the answers.
    pub fn refusal(&self) -> Option<&AnswerBuf> {
        self.all.iter().find(|answer| !answer.status().is_success())
    }

    /// The answers, if none of them refuses.
    ///
    /// # Errors
    ///
    /// [`Error::Refused`] with the status and the sender of the first answer that refuses.
    pub fn accepted(self) -> Result<Self, Error> {
        match self.refusal() {
            None => Ok(self),
            Some(refusal) => Err(self.refused(refusal)),
        }
    }

    /// The error of one of the answers, which refuses.
    pub(crate) fn refused(&self, refusal: &AnswerBuf) -> Error {
        Error::Refused {
            request: refusal.request(),
            to: self.to,
            status: refusal.status(),
            by: refusal.from(),
        }
    }

    /// Whether one of the answers did not fit the monitor's output buffer (NoRoom, §2).
    pub fn lacks_room(&self) -> bool {
        self.all.iter().any(|answer| answer.status() == Status::NO_ROOM)
    }
}

impl std::ops::Deref for Answers {
    type Target = [AnswerBuf];

    fn deref(&self) -> &[AnswerBuf] {
        &self.all
    }
}

impl IntoIterator for Answers {
    type Item = AnswerBuf;
    type IntoIter = smallvec::IntoIter<[AnswerBuf; 1]>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.into_iter()
    }
}

/// The records of a payload; `None` if it does not consist of whole records.
pub(crate) fn records(payload: &[u8]) -> Option<SmallVec<[Record<'_>; RECORDS_USUAL]>> {
    Records::new(payload).collect::<Result<_, _>>().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn buf(request: Request<'_>) -> RequestBuf {
        RequestBuf::new(&request).expect("fits a record")
    }

    fn to(to: SubsystemId, body: Body<'_>) -> RequestBuf {
        buf(Request::new(to, body))
    }

    #[test]
    fn only_what_may_be_repeated_is() {
        let repeatable = [
            to(SubsystemId::ALL, Body::GetStatus),
            to(SubsystemId::DETECTOR, Body::GetHotbed),
            to(SubsystemId::ALL, Body::Stop),
            buf(Request::close(SubsystemId::VALVE1)),
            buf(Request::lockout(true)),
        ];
        assert!(repeatable.iter().all(RequestBuf::is_repeatable));
        let once = [
            to(SubsystemId::VERTICAL, Body::Move { destination: 1 }),
            buf(Request::open(SubsystemId::VALVE1)),
            buf(Request::lockout(false)),
            to(SubsystemId::ALL, Body::Restart),
            to(SubsystemId::GENERAL, Body::Unknown { request: RequestId(1), data: &[] }),
        ];
        assert!(!once.iter().any(RequestBuf::is_repeatable));
    }

    #[test]
    fn what_a_stop_undoes_is_not_sent_after_it() {
        let moving = to(SubsystemId::VERTICAL, Body::Move { destination: 1 });
        let opening = buf(Request::open(SubsystemId::VALVE1));
        let release = buf(Request::lockout(false));
        let reading = to(SubsystemId::VERTICAL, Body::GetStatus);
        let all = [&moving, &opening, &release, &reading];
        let superseded = |by: RequestBuf| all.map(|other| by.supersedes(other));
        let stop = |who| to(who, Body::Stop);
        assert_eq!(superseded(stop(SubsystemId::ALL)), [true, true, false, false]);
        assert_eq!(superseded(stop(SubsystemId::MOTORS)), [true, false, false, false]);
        assert_eq!(superseded(stop(SubsystemId::VERTICAL)), [true, false, false, false]);
        assert_eq!(superseded(stop(SubsystemId::NOZZLE)), [false; 4]);
        let close = buf(Request::close(SubsystemId::VALVE1));
        assert_eq!(superseded(close), [false, true, false, false]);
        assert_eq!(superseded(buf(Request::lockout(true))), [true, true, true, false]);
    }

    #[test]
    fn a_request_that_fits_no_record_is_refused() {
        let values = [0; 64];
        let body = Body::SetParam { id: ParamId(1), values: lafet_proto::Ints::Values(&values) };
        let result = RequestBuf::new(&Request::new(SubsystemId::GENERAL, body));
        assert!(matches!(result, Err(Error::Unsendable { request: RequestId::SET_PARAM, .. })));
    }
}
