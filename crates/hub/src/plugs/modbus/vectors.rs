//! Frames of a whole conversation, for those who write a master: made by the desk itself, with numbers that
//! are fixed here.

use std::time::Duration;

use lafet_texts::{Lang, Text as _, hub as text};
use serde::Serialize;

use super::desk::{Around, Desk, Terms};
use super::frames::{Next, Splitter};
use super::layout::{
    COMMAND, COMMAND_LEN, DETAIL_LEN, HEARTBEAT, KEYS, RESULT_LEN, RESULTS, SESSION, SUMMARY,
    SUMMARY_LEN, halves, name_words,
};
use super::map;
use super::pdu::{self, Ask, Exception};
use super::sight::{Holder, Seen, Sight};
use crate::field::wire::{Framing, crc};
use crate::text::Both;

/// A request and its answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Vector {
    /// What happens.
    pub what: Both,
    /// The request over TCP, hexadecimal.
    pub tcp_request: String,
    /// The answer over TCP.
    pub tcp_answer: String,
    /// The request on a serial line.
    pub rtu_request: String,
    /// The answer on a serial line.
    pub rtu_answer: String,
}

/// The numbers that are random on a real hub.
const SESSION_NUMBER: u32 = 0x1234_5678;
const FIRST_KEY: u64 = 0x0102_0304_0506_0708;

/// A conversation.
struct Talk {
    unit: u8,
    desk: Desk,
    sight: Sight,
    now: Duration,
    key: u64,
    number: u16,
    vectors: Vec<Vector>,
}

/// The frames of a conversation with the first monitor of a unit.
pub fn vectors(unit: u8, monitors: &[String]) -> Vec<Vector> {
    let terms = Terms {
        heartbeat: Duration::from_millis(150),
        answer: Duration::from_secs(5),
        closes: false,
    };
    let mut key = FIRST_KEY;
    let desk = Desk::new(terms, SESSION_NUMBER, Duration::ZERO, &mut || next(&mut key));
    let [high, low] = halves(map::version(unit, monitors));
    let count = u16::try_from(monitors.len()).unwrap_or_default();
    let sight = Sight {
        header: [high, low, 7, count, 0],
        monitors: monitors.iter().map(|id| seen(id)).collect(),
    };
    let mut talk =
        Talk { unit, desk, sight, now: Duration::ZERO, key, number: 0, vectors: Vec::new() };
    talk.converse();
    talk.vectors
}

fn next(key: &mut u64) -> Option<u64> {
    let own = *key;
    *key = key.wrapping_add(0x0101_0101_0101_0101);
    Some(own)
}

fn seen(id: &str) -> Seen {
    let words = [1, 40, 4, 1, 0xFF9B, 201, 60, 80, 0, 1 << 1 | 1 << 6, 0, 0, 1, 0, 24];
    Seen { holder: Holder::Mine, words, detail: [0; DETAIL_LEN], name: name_words(id) }
}

impl Talk {
    fn converse(&mut self) {
        self.read(text::VectorReadHeader.words(), 0, 5);
        self.read(text::VectorReadSummary.words(), SUMMARY, SUMMARY_LEN as u16);
        self.read(text::VectorReadSession.words(), SESSION, 2);
        // Until the heartbeat is alive.
        for beat in 1..=6 {
            self.now += Duration::from_millis(140);
            self.write(text::VectorBeat.words(), HEARTBEAT, &[beat]);
        }
        self.write(text::VectorTake.words(), COMMAND, &command(1, 1, 0, 0));
        self.desk.answered(1, Ok(()));
        self.read(text::VectorReadKey.words(), KEYS, 4);
        self.write(text::VectorOpen.words(), COMMAND, &command(2, 5, 1, FIRST_KEY));
        self.desk.answered(2, Ok(()));
        self.read(text::VectorReadResult.words(), RESULTS, RESULT_LEN as u16);
        self.write(text::VectorReplay.words(), COMMAND, &command(3, 5, 1, FIRST_KEY));
        self.read(text::VectorReadResult.words(), RESULTS, RESULT_LEN as u16);
        self.write(text::VectorStop.words(), COMMAND, &command(4, 7, 0, 0));
        self.write(text::VectorPart.words(), COMMAND, &[5]);
        self.read(text::VectorBeyond.words(), u16::MAX, 1);
    }

    fn read(&mut self, what: Both, first: u16, count: u16) {
        let mut request = vec![pdu::READ_HOLDING];
        request.extend(first.to_be_bytes());
        request.extend(count.to_be_bytes());
        self.ask(what, &request);
    }

    fn write(&mut self, what: Both, first: u16, words: &[u16]) {
        let mut request = vec![pdu::WRITE_MANY];
        request.extend(first.to_be_bytes());
        request.extend(u16::try_from(words.len()).unwrap_or_default().to_be_bytes());
        request.push(u8::try_from(2 * words.len()).unwrap_or_default());
        request.extend(words.iter().flat_map(|it| it.to_be_bytes()));
        self.ask(what, &request);
    }

    fn ask(&mut self, what: Both, request: &[u8]) {
        let answer = self.answer(request).unwrap_or_else(|why| pdu::refusal(request, why));
        self.number += 1;
        let mut serial = vec![self.unit];
        serial.extend_from_slice(request);
        serial.extend(crc(&serial).to_le_bytes());
        let mut tcp = Vec::from(self.number.to_be_bytes());
        tcp.extend([0, 0]);
        tcp.extend(u16::try_from(1 + request.len()).unwrap_or_default().to_be_bytes());
        tcp.push(self.unit);
        tcp.extend_from_slice(request);
        let of = |framing, request: &[u8]| {
            let mut splitter = Splitter::new(framing);
            splitter.feed(request);
            match splitter.next() {
                Next::Frame(frame) => hex(&splitter.answer(&frame, &answer)),
                Next::More | Next::Broken => String::new(),
            }
        };
        self.vectors.push(Vector {
            what,
            tcp_answer: of(Framing::Tcp, &tcp),
            tcp_request: hex(&tcp),
            rtu_answer: of(Framing::Rtu, &serial),
            rtu_request: hex(&serial),
        });
    }

    fn answer(&mut self, request: &[u8]) -> Result<Vec<u8>, Exception> {
        match pdu::parse(request)? {
            Ask::Read { first, count } => {
                let words = self.desk.read(true, &self.sight, first, count)?;
                Ok(pdu::read_answer(request.first().copied().unwrap_or_default(), &words))
            }
            Ask::Write { first, words } => {
                let mut around = Around {
                    now: self.now,
                    operates: true,
                    broadcast: false,
                    surplus: false,
                    sight: &self.sight,
                    random: &mut || next(&mut self.key),
                };
                self.desk.write(&mut around, first, &words)?;
                Ok(pdu::write_answer(request))
            }
        }
    }
}

/// A command for the first monitor; 7 for all.
fn command(sequence: u16, number: u16, argument: u16, key: u64) -> [u16; COMMAND_LEN] {
    let [high, low] = halves(SESSION_NUMBER);
    let monitor = u16::from(number != 7);
    let [k1, k2, k3, k4] = super::layout::key_words(key);
    [sequence, high, low, number, monitor, argument, 0, 0, 0, k1, k2, k3, k4]
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The vectors as lines of text, in a language.
pub fn shown(vectors: &[Vector], lang: Lang) -> String {
    let mut out = String::new();
    for vector in vectors {
        out += &format!("# {}\n", vector.what.of(lang));
        out += &format!("tcp > {}\ntcp < {}\n", vector.tcp_request, vector.tcp_answer);
        out += &format!("rtu > {}\nrtu < {}\n\n", vector.rtu_request, vector.rtu_answer);
    }
    out
}
