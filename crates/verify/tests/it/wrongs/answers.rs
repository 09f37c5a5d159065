//! Answers that are missing or false, and acts without a request.

use lafet_device::Source;
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use lafet_verify::swarm::Wrong;

use super::Seeded;

pub const ALL: &[Seeded] = &[
    ("a frame is not answered", silent, &["a frame is not answered", "a request is not answered"]),
    ("an answer is cut short", cuts, &["an answer is cut short", "a request is not answered"]),
    ("the last of several answers is missing", drops_last, &["not answered", "not all have"]),
    ("the first of several answers is missing", drops_first, &["not answered", "not all have"]),
    ("an answer is given twice", twice, &["an answer to no request", "not all have"]),
    ("Denied is said of what is done", denies, &["no such Move is in force"]),
    (
        "Ok is said of a lockout that is not taken",
        refuses_lockout,
        &["LockedOut is reported as false"],
    ),
    ("a drive is moved without a request", moves, &["is not explained"]),
    ("a valve is opened without a request", opens, &["is not explained"]),
    ("a program is started without a request", quenches, &["is not explained"]),
    ("a lockout is lifted without a request", lifts, &["LockedOut is reported as false"]),
    ("the monitor locks itself out", locks, &["LockedOut is reported as true", "is not explained"]),
    ("limits are switched off without a request", unlimited, &["out of its limits"]),
];

struct Answers<F>(F);

impl<F: FnMut(&[u8], &mut Vec<u8>)> Wrong for Answers<F> {
    fn answers(&mut self, payload: &[u8], answer: &mut Vec<u8>) {
        (self.0)(payload, answer);
    }
}

fn answers(act: impl FnMut(&[u8], &mut Vec<u8>) + 'static) -> Box<dyn Wrong> {
    Box::new(Answers(act))
}

/// Has every fourth frame preceded by a request that no client has sent.
struct Asks<F>(F, u32);

impl<F: FnMut() -> Vec<u8>> Wrong for Asks<F> {
    fn asks(&mut self, _: Source, _: &[u8]) -> Vec<Vec<u8>> {
        self.1 += 1;
        if self.1.is_multiple_of(4) { vec![(self.0)()] } else { Vec::new() }
    }
}

fn asks(request: fn() -> Request<'static>) -> Box<dyn Wrong> {
    Box::new(Asks(move || payload(&request()), 0))
}

fn payload(request: &Request<'_>) -> Vec<u8> {
    let mut buffer = [0; 260];
    let mut writer = Writer::new(&mut buffer);
    request.encode(&mut writer).unwrap();
    writer.written().to_vec()
}

/// The answer record by record.
fn split(answer: &[u8]) -> Vec<Vec<u8>> {
    let bytes = |record: Record<'_>| {
        let header = [record.request.0, record.device.0, record.status.0, record.data.len() as u8];
        [&header, record.data].concat()
    };
    Records::new(answer).flatten().map(bytes).collect()
}

fn silent() -> Box<dyn Wrong> {
    answers(|_, answer| answer.clear())
}

fn cuts() -> Box<dyn Wrong> {
    answers(|_, answer| {
        answer.pop();
    })
}

fn drops_last() -> Box<dyn Wrong> {
    answers(|payload, answer| {
        let mut records = split(answer);
        if Records::new(payload).count() > 1 && records.len() > 1 {
            records.pop();
            *answer = records.concat();
        }
    })
}

fn drops_first() -> Box<dyn Wrong> {
    answers(|_, answer| {
        let mut records = split(answer);
        if records.len() > 1 {
            records.remove(0);
            *answer = records.concat();
        }
    })
}

fn twice() -> Box<dyn Wrong> {
    answers(|_, answer| {
        let mut records = split(answer);
        if let Some(last) = records.last().cloned() {
            records.push(last);
            *answer = records.concat();
        }
    })
}

fn denies() -> Box<dyn Wrong> {
    answers(|_, answer| {
        let mut records = split(answer);
        for record in &mut records {
            if let [request, _, status, ..] = record.as_mut_slice()
                && *request == RequestId::MOVE.0
            {
                *status = Status::DENIED.0;
            }
        }
        *answer = records.concat();
    })
}

/// Locked out by what is reported, and released at once.
fn refuses_lockout() -> Box<dyn Wrong> {
    struct Refuses(bool);
    impl Wrong for Refuses {
        fn asks(&mut self, _: Source, _: &[u8]) -> Vec<Vec<u8>> {
            match std::mem::take(&mut self.0) {
                true => vec![payload(&Request::lockout(false))],
                false => Vec::new(),
            }
        }

        fn answers(&mut self, _: &[u8], answer: &mut Vec<u8>) {
            self.0 = Records::new(answer).flatten().any(|r| r.request == RequestId::LOCKOUT);
        }
    }
    Box::new(Refuses(false))
}

fn moves() -> Box<dyn Wrong> {
    asks(|| Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: 21_600 }))
}

fn opens() -> Box<dyn Wrong> {
    asks(|| Request::open(SubsystemId::VALVE1))
}

fn quenches() -> Box<dyn Wrong> {
    use lafet_proto::request::{Quench, Sector};
    asks(|| {
        let sector =
            Sector { centre_h: 600, centre_v: 0, nozzle: 30, width: 0, height: 0, step: 0 };
        let quench = Quench::Full { sector, distance: 0 };
        Request::new(SubsystemId::CONTROL, Body::StartQuench(quench))
    })
}

fn lifts() -> Box<dyn Wrong> {
    asks(|| Request::lockout(false))
}

fn locks() -> Box<dyn Wrong> {
    asks(|| Request::lockout(true))
}

fn unlimited() -> Box<dyn Wrong> {
    asks(|| Request::new(SubsystemId::ALL, Body::SwitchLimits { new_state: 0 }))
}
