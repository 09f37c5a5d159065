//! The way of a request through the chain of handlers, as the monitor itself judges it
//! ([`lafet_device::Way`]), beside what it answered.

use lafet_device::{Source, Way};
use lafet_proto::answer::Reply;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::text::RequestText;
use lafet_proto::{Answer, Record, Request, SubsystemId, dictionary};
use lafet_sim::sim::Sim;
use lafet_texts::{Text, Undecodable, Words, play as text};

use crate::anatomy::flags_of;
use crate::view::{Flag, Mark, Station, Verdict, Walk, words};

/// The walks of all records of a payload, found on a copy of the monitor: each is judged in the state that
/// those before it have left.
pub fn walks(sim: &Sim, source: Source, payload: &[u8]) -> Vec<Walk> {
    let mut copy = sim.clone();
    // A frame that comes while the flash is busy is looked at when the program runs again.
    copy.request(source, &[]);
    let mut walks = Vec::new();
    let mut records = Records::new(payload);
    loop {
        let rest = records.rest();
        let Some(record) = records.next() else { return walks };
        let size = record.map_or(rest.len(), |record| record.size());
        let before = copy.clone();
        let answer = copy.handle(source, rest.get(..size).unwrap_or_default());
        walks.push(match record {
            Ok(record) => walk(&before, &record, &answer),
            Err(error) => Walk {
                request: "?".to_owned(),
                stations: Vec::new(),
                end: text::EndCutShort { what: Undecodable(&error) }.words(),
                because: Vec::new(),
                verdicts: verdicts(&answer),
            },
        });
    }
}

fn walk(before: &Sim, record: &Record<'_>, answer: &[u8]) -> Walk {
    let way = before.device().way(record);
    let by = match way {
        Way::Closed(_) => Some(SubsystemId::GENERAL),
        Way::Intercepted(by, _) => Some(by),
        Way::Reached => {
            let refuses = |record: Record<'_>| !record.status.is_success();
            Records::new(answer).flatten().any(refuses).then_some(record.device)
        }
        _ => None,
    };
    Walk {
        request: RequestText(*record).to_string(),
        stations: stations(before, record.device, way, answer),
        end: end(way, record),
        because: by.map(|by| state_of(before, by)).unwrap_or_default(),
        verdicts: verdicts(answer),
    }
}

fn stations(sim: &Sim, to: SubsystemId, way: Way, answer: &[u8]) -> Vec<Station> {
    let answered = |id| {
        let mut own = Records::new(answer).flatten().filter(|record| record.device == id);
        own.next()
            .map(|record| if record.status.is_success() { Mark::Answered } else { Mark::Refused })
    };
    let station = |id: SubsystemId| {
        let addressed = match way {
            Way::Everyone(handlers) => handlers.contains(id),
            _ => id == to,
        };
        let mark = match way {
            _ if !sim.device().has(id) => Mark::Absent,
            Way::Everyone(_) => answered(id).unwrap_or(Mark::Passed),
            Way::Closed(_) | Way::Unknown | Way::Nobody if id == SubsystemId::GENERAL => {
                Mark::Refused
            }
            Way::Intercepted(by, _) if id == by => Mark::Refused,
            Way::NotAddressee | Way::Data(_) if id == to => Mark::Refused,
            Way::Reached if id == to => answered(id).unwrap_or(Mark::Unasked),
            Way::Reached | Way::Data(_) => Mark::Passed,
            _ => Mark::Unasked,
        };
        let info = dictionary::subsystem(id);
        let title = info.map(|info| info.title.words()).unwrap_or_default();
        Station { name: id.to_string(), title, mark, addressed }
    };
    SubsystemId::CHAIN.into_iter().map(station).collect()
}

fn end(way: Way, record: &Record<'_>) -> Words {
    let to = title(record.device);
    match way {
        Way::Closed(_) => text::EndClosed.words(),
        Way::Unknown => text::EndUnknown.words(),
        Way::Nobody => text::EndNobody { to }.words(),
        Way::Everyone(_) => text::EndEveryone.words(),
        Way::Absent => text::EndAbsent { to }.words(),
        Way::NotAddressee => text::EndNotAddressee { to }.words(),
        Way::Intercepted(by, _) => text::EndIntercepted { by: title(by), to }.words(),
        Way::Data(_) => text::EndData { to }.words(),
        Way::Reached => text::EndReached { to }.words(),
    }
}

fn title(id: SubsystemId) -> Words {
    let known = dictionary::subsystem(id);
    known.map_or_else(|| Words::same(id.to_string()), |info| info.title.words())
}

/// The flags of a subsystem.
fn state_of(sim: &Sim, id: SubsystemId) -> Vec<Flag> {
    let mut buffer = [0; 8];
    let mut writer = Writer::new(&mut buffer);
    if Request::new(id, Body::GetStatus).encode(&mut writer).is_err() {
        return Vec::new();
    }
    let bytes = sim.clone().handle(Source::ExternalConn, writer.written());
    let answer = Records::new(&bytes).flatten().next();
    let answer = answer.and_then(|record| Answer::decode(&record).ok());
    answer.map(|answer| flags_of(id, word(&answer.data))).unwrap_or_default()
}

/// The status word of an answer to GetStatus.
pub fn word(reply: &Reply<'_>) -> u32 {
    match reply {
        Reply::General(it) => it.flags.bits(),
        Reply::Thermo(it) => it.flags.bits(),
        Reply::Drive(it) => it.flags.bits(),
        Reply::Valve(it) => it.flags.bits(),
        Reply::Control(it) => it.flags.bits(),
        Reply::Detector(it) => it.flags.bits(),
        Reply::Deployer(it) => it.flags.bits(),
        Reply::Conn(it) => it.flags.bits(),
        Reply::Buttons(it) => it.flags.bits(),
        _ => 0,
    }
}

fn verdicts(answer: &[u8]) -> Vec<Verdict> {
    let verdict = |record: Record<'_>| {
        let info = dictionary::status(record.status);
        Verdict {
            from: record.device.to_string(),
            status: record.status.to_string(),
            success: record.status.is_success(),
            meaning: info.map(|it| words(lafet_texts::dictionary(it.meaning))).unwrap_or_default(),
            remedy: info.map(|it| words(lafet_texts::dictionary(it.remedy))).unwrap_or_default(),
        }
    };
    Records::new(answer).flatten().map(verdict).collect()
}
