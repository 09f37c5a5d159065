//! §L/7 Frames with a CRC-32C where the monitor has it, on virtual time: found out, never insisted on
//! without need, and given up when the monitor is replaced.

use std::time::Duration;

use crate::fake::answer;
use lafet_client::session::line::Line;
use lafet_client::session::{Now, Outcome, Terms, Ticket};
use lafet_client::{CheckMode, Config, RequestBuf};
use lafet_proto::link::{Check, Decoder, Frame, encode_with, wire_max};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

const MS: Duration = Duration::from_millis(1);
const SECOND: Duration = Duration::from_secs(1);

/// A monitor written from the observed frame alone: it knows nothing of other checks, and nothing
/// here is shared with the library but the records.
struct Plain {
    body: Vec<u8>,
    inside: bool,
    escaped: bool,
    spoilt: bool,
}

fn modbus_crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc: u16, _| match crc & 1 {
            0 => crc >> 1,
            _ => crc >> 1 ^ 0xA001,
        })
    })
}

impl Plain {
    const fn new() -> Self {
        Self { body: Vec::new(), inside: false, escaped: false, spoilt: false }
    }

    fn hears(&mut self, byte: u8) -> Option<(u8, u8, Vec<u8>)> {
        if byte == 0xC0 {
            let body = std::mem::take(&mut self.body);
            let good = self.inside && !self.escaped && !self.spoilt && body.len() >= 4 && {
                let (head, crc) = body.split_at(body.len() - 2);
                modbus_crc(head).to_le_bytes() == crc
            };
            (self.inside, self.escaped, self.spoilt) = (!good, false, false);
            return good.then(|| (body[0], body[1], body[2..body.len() - 2].to_vec()));
        }
        if self.inside {
            match (std::mem::take(&mut self.escaped), byte) {
                (true, 0xDC) => self.body.push(0xC0),
                (true, 0xDD) => self.body.push(0xDB),
                (true, _) => self.spoilt = true,
                (false, 0xDB) => self.escaped = true,
                (false, byte) => self.body.push(byte),
            }
        }
        None
    }

    fn says(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
        let mut body = [&[dst, src], payload].concat();
        body.extend(modbus_crc(&body).to_le_bytes());
        let escaped = body.into_iter().flat_map(|byte| match byte {
            0xC0 => vec![0xDB, 0xDC],
            0xDB => vec![0xDB, 0xDD],
            byte => vec![byte],
        });
        [0xFF, 0xC0].into_iter().chain(escaped).chain([0xC0]).collect()
    }
}

/// Who is at the other end.
enum Peer {
    Plain(Plain),
    /// Takes both checks, or the CRC-32C alone, and answers as it was asked.
    Both(Box<Decoder>),
    Long(Box<Decoder>),
    Nobody,
}

impl Peer {
    fn plain() -> Self {
        Self::Plain(Plain::new())
    }

    fn both() -> Self {
        Self::Both(Box::default())
    }

    fn long() -> Self {
        Self::Long(Box::default())
    }

    /// What it answers, and in which form.
    fn answers(&mut self, bytes: &[u8], address: u8) -> Option<(Vec<u8>, Vec<u8>, Check)> {
        let alone = matches!(self, Self::Long(_));
        match self {
            Self::Nobody => None,
            Self::Plain(plain) => {
                let heard = bytes.iter().filter_map(|byte| plain.hears(*byte)).last();
                let (dst, src, payload) = heard.filter(|(dst, ..)| *dst == address)?;
                Some((Plain::says(src, dst, &answer(&payload)), payload, Check::Crc16))
            }
            Self::Both(decoder) | Self::Long(decoder) => {
                let Frame { dst, src, payload } = decoder.push_slice(bytes).1?;
                let payload = payload.to_vec();
                let check = decoder.check();
                if dst != address || (alone && check == Check::Crc16) {
                    return None;
                }
                let reply = answer(&payload);
                let mut wire = vec![0; wire_max(reply.len())];
                let frame = Frame { dst: src, src: dst, payload: &reply };
                let len = encode_with(check, &frame, &mut wire).expect("room");
                wire.truncate(len);
                Some((wire, payload, check))
            }
        }
    }
}

/// A client and the monitors 1 and 2 on a line.
struct World {
    now: Now,
    line: Line,
    peers: [Peer; 2],
    /// What the monitors have understood: address, records, check.
    understood: Vec<(u8, Vec<u8>, Check)>,
    frames: u32,
}

impl World {
    fn new(check: CheckMode, peers: [Peer; 2]) -> Self {
        let mut line = Line::new(Config { check, ..Config::default() });
        line.handle_connected(Now::ZERO);
        Self { now: Now::ZERO, line, peers, understood: Vec::new(), frames: 0 }
    }

    fn ask(&mut self, address: u8, body: Body<'_>, to: SubsystemId) -> Ticket {
        let request = RequestBuf::new(&Request::new(to, body)).unwrap();
        self.line.submit(self.now, address, Terms::default(), vec![request]).unwrap()
    }

    /// Runs until an operation has ended; how it ended, and how long it took.
    fn end(&mut self, ticket: Ticket) -> (Outcome, Duration) {
        let began = self.now;
        for _ in 0..1000 {
            while let Some(bytes) = self.line.poll_transmit(self.now) {
                self.frames += 1;
                for address in 1..=2 {
                    let peer = &mut self.peers[usize::from(address) - 1];
                    if let Some((wire, payload, check)) = peer.answers(&bytes, address) {
                        self.understood.push((address, payload, check));
                        self.now += 5 * MS;
                        self.line.handle_bytes(self.now, &wire);
                    }
                }
            }
            while let Some((ended, outcome)) = self.line.poll_outcome() {
                if ended == ticket {
                    return (outcome, self.now - began);
                }
            }
            self.now = self.line.poll_timeout(self.now).expect("it waits").max(self.now);
            self.line.handle_timeout(self.now);
        }
        panic!("it never ended");
    }

    fn read(&mut self, address: u8) -> (bool, Duration) {
        let ticket = self.ask(address, Body::GetStatus, SubsystemId::VERTICAL);
        let (outcome, time) = self.end(ticket);
        (matches!(outcome, Outcome::Answered(_)), time)
    }

    fn last(&self) -> Check {
        self.understood.last().expect("something was understood").2
    }
}

#[test]
fn a_monitor_that_has_it_is_asked_that_way() {
    for peer in [Peer::both, Peer::long] {
        let mut world = World::new(CheckMode::Auto, [peer(), Peer::plain()]);
        for _ in 0..5 {
            assert!(world.read(1).0 && world.read(2).0);
        }
        let check_of = |address| {
            let of = world.understood.iter().filter(move |(who, ..)| *who == address);
            of.map(|(.., check)| *check).collect::<Vec<_>>()
        };
        assert_eq!(check_of(1), [Check::Crc32c; 6], "a probe and five reads");
        assert_eq!(check_of(2), [Check::Crc16; 5], "each monitor for itself");
        let crc32c = |address| world.line.stats(address).crc32c;
        assert_eq!((crc32c(1), crc32c(2), world.line.total().crc32c), (1, 0, 1));
        assert_eq!(world.line.total().timeouts, 0);
    }
}

#[test]
fn by_default_nothing_is_tried() {
    let mut world = World::new(CheckMode::Crc16, [Peer::both(), Peer::plain()]);
    for _ in 0..5 {
        assert!(world.read(1).0 && world.read(2).0);
    }
    assert!(world.understood.iter().all(|(.., check)| *check == Check::Crc16));
    assert_eq!((world.understood.len(), world.frames), (10, 10));
}

/// A plain monitor costs one probe of 150 ms, then shorter ones, ever more rarely.
#[test]
fn a_plain_monitor_loses_little_time() {
    let mut world = World::new(CheckMode::Auto, [Peer::plain(), Peer::Nobody]);
    assert_eq!(world.read(1), (true, 155 * MS));
    assert_eq!(world.read(1), (true, 5 * MS));
    let mut probes = 0;
    for _ in 0..600 {
        world.now += SECOND;
        let (answered, time) = world.read(1);
        assert!(answered && time <= 35 * MS, "{time:?}");
        probes += u32::from(time > 5 * MS);
    }
    assert_eq!(probes, 6, "after 1, 3, 10, 30, 100 and 300 s");
    let stats = world.line.total();
    assert_eq!((stats.timeouts, stats.retries, stats.crc32c), (0, 0, 0));
}

/// No monitor there: the probes add less than half a second to the three tries.
#[test]
fn a_silent_monitor_costs_little_more() {
    let mut world = World::new(CheckMode::Auto, [Peer::Nobody, Peer::Nobody]);
    let (answered, time) = world.read(1);
    assert!(!answered);
    assert!((3 * SECOND..3 * SECOND + 460 * MS).contains(&time), "{time:?}");
    let (_, again) = world.read(1);
    assert!(again <= 3 * SECOND + 310 * MS, "{again:?}");
}

/// A monitor is replaced by one that has it, has it not, or has nothing else.
#[test]
fn a_replaced_monitor_is_found_again() {
    type New = fn() -> Peer;
    let kinds: [(New, &str); 3] =
        [(Peer::plain, "plain"), (Peer::both, "both"), (Peer::long, "long")];
    for (before, old) in kinds {
        for (after, new) in kinds {
            let mut world = World::new(CheckMode::Auto, [before(), Peer::Nobody]);
            assert!(world.read(1).0);
            world.now += 60 * SECOND;
            world.peers[0] = after();
            let (answered, time) = world.read(1);
            assert!(answered, "{old} → {new}");
            assert!(time <= SECOND + 400 * MS, "{old} → {new}: {time:?}");
            world.now += SECOND;
            // One that has become plain is looked at once more: the probe may have been lost.
            assert!(world.read(1).1 <= 35 * MS, "{old} → {new}");
            assert_eq!(world.read(1), (true, 5 * MS), "{old} → {new}");
        }
    }
}

/// A Stop never waits for a probe, and goes out in both forms by turns.
#[test]
fn a_stop_reaches_whoever_is_there() {
    for mode in [CheckMode::Auto, CheckMode::Crc32c] {
        for peer in [Peer::plain, Peer::both, Peer::long] {
            let mut world = World::new(mode, [peer(), Peer::Nobody]);
            let stop = world.ask(1, Body::Stop, SubsystemId::ALL);
            let (outcome, time) = world.end(stop);
            assert!(matches!(outcome, Outcome::Answered(_)), "{mode:?}");
            assert!(time <= 155 * MS, "{mode:?} {time:?}");
            // Replaced: the next Stop is understood at its second try.
            for next in [Peer::plain, Peer::long] {
                world.peers[0] = next();
                let stop = world.ask(1, Body::Stop, SubsystemId::ALL);
                let (outcome, time) = world.end(stop);
                assert!(matches!(outcome, Outcome::Answered(_)), "{mode:?}");
                assert!(time <= 160 * MS, "{mode:?} {time:?}");
            }
        }
    }
}

/// Insisted on: a plain monitor gets nothing but what stops it, and the caller gets the reason.
#[test]
fn insisting() {
    let mut world = World::new(CheckMode::Crc32c, [Peer::plain(), Peer::both()]);
    assert!(world.read(2).0);
    assert_eq!(world.last(), Check::Crc32c);
    let moving = world.ask(1, Body::Move { destination: 1 }, SubsystemId::VERTICAL);
    let (outcome, time) = world.end(moving);
    assert_eq!(outcome, Outcome::CheckMissing);
    assert!(time <= 350 * MS, "{time:?}");
    let (outcome, time) = {
        let ticket = world.ask(1, Body::GetStatus, SubsystemId::ALL);
        world.end(ticket)
    };
    assert_eq!((outcome, time), (Outcome::CheckMissing, Duration::ZERO), "it is known by now");
    assert!(world.understood.iter().all(|(who, payload, _)| *who == 2 || payload.is_empty()));
    // Replaced by one that has it.
    world.peers[0] = Peer::long();
    world.now += 20 * SECOND;
    assert!(world.read(1).0);
    assert_eq!(world.line.stats(1).crc32c, 1);
    // And back again, in the middle of everything.
    world.now += 20 * SECOND;
    world.peers[0] = Peer::plain();
    let ticket = world.ask(1, Body::GetStatus, SubsystemId::VERTICAL);
    assert_eq!(world.end(ticket).0, Outcome::CheckMissing);
}

/// What was asked with a CRC-32C is not believed with a CRC-16.
#[test]
fn an_answer_comes_in_the_form_of_its_request() {
    let mut world = World::new(CheckMode::Auto, [Peer::long(), Peer::Nobody]);
    assert!(world.read(1).0);
    let ticket = world.ask(1, Body::GetStatus, SubsystemId::VERTICAL);
    let bytes = world.line.poll_transmit(world.now).expect("due");
    let (_, payload, _) = world.peers[0].answers(&bytes, 1).expect("understood");
    world.line.handle_bytes(world.now, &Plain::says(129, 1, &answer(&payload)));
    assert_eq!(world.line.poll_outcome(), None);
    assert_eq!(world.line.stats(1).unmatched + world.line.stats(1).duplicates, 1);
    world.now += SECOND;
    world.line.handle_timeout(world.now);
    assert!(matches!(world.end(ticket).0, Outcome::Answered(_)));
}
