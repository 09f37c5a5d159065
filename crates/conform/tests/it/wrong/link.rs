//! Wrong links.

use lafet_conform::raw::{self, END, ESC};
use lafet_sim::sim::Sim;

use super::{Rule, Wrong, wrong};
use crate::support::{Ear, ask};

/// The rule that the link breaks.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Loose {
    CrcUnchecked,
    CrcLowByteOnly,
    CrcSwapped,
    CrcOther,
    NoUnescape,
    BadEscapeTaken,
    AnyAddress,
    Broadcast,
    OwnSource,
    LongTaken,
    NoiseKills,
    ForgetsParts,
    OneFrameARead,
    ShortEndsFrame,
    ProbeSilent,
    ProbeAnsweredTwice,
    ProbeWithRecord,
    Twice,
    TwiceLate,
    SometimesSilent,
    SameFrameOnce,
    Unescaped,
    EscapesSwapped,
    NotSwapped,
    SourceZero,
    CutAnswer,
    Unsolicited,
    AnswersBadCrc,
    AnswersAnswers,
    ProbesWithoutEnd,
}

use Loose as L;

const fn link(item: &'static str, name: &'static str, loose: Loose) -> Wrong {
    wrong(item, name, Rule::Link(loose))
}

pub const WRONG: &[Wrong] = &[
    link("§L/2", "the CRC of a frame is not checked", L::CrcUnchecked),
    link("§L/2", "only the low byte of the CRC is checked", L::CrcLowByteOnly),
    link("§L/2", "the CRC is sent high byte first", L::CrcSwapped),
    link("§L/2", "the CRC starts from 0", L::CrcOther),
    link("§L/1", "escapes in a frame are not undone", L::NoUnescape),
    link("§L/4", "DB 00 is taken for some byte", L::BadEscapeTaken),
    link("§L/6", "frames for other addresses are answered", L::AnyAddress),
    link("§L/6", "address 0 is taken for a broadcast", L::Broadcast),
    link("§L/6", "a frame with the own address as src is answered", L::OwnSource),
    link("§L/6", "a frame over the payload limit is answered", L::LongTaken),
    link("§L/3", "noise before a frame corrupts it", L::NoiseKills),
    link("§L/3", "a frame that comes in parts is forgotten", L::ForgetsParts),
    link("§L/3", "only the first of two frames at once is answered", L::OneFrameARead),
    link("§L/4", "C0 after three bytes does not begin a frame", L::ShortEndsFrame),
    link("§L/5", "a probe is not answered", L::ProbeSilent),
    link("§L/5", "a probe is answered without swapping the addresses", L::ProbeAnsweredTwice),
    link("§L/5", "a probe is answered with a record", L::ProbeWithRecord),
    link("§1/10", "each frame is answered twice", L::Twice),
    link("§1/10", "a second answer comes 150 ms later", L::TwiceLate),
    link("§1/10", "every tenth frame is not answered", L::SometimesSilent),
    link("§1/10", "a repeated frame is not answered", L::SameFrameOnce),
    link("§L/1", "answers are not escaped", L::Unescaped),
    link("§L/1", "DC and DD are exchanged in answers", L::EscapesSwapped),
    link("§L/6", "dst and src of the answer are those of the request", L::NotSwapped),
    link("§L/6", "src of the answer is 0", L::SourceZero),
    link("§2", "the last byte of an answer is missing", L::CutAnswer),
    link("§1/10", "it sends frames unasked", L::Unsolicited),
    link("§L/2", "a frame with a wrong CRC is answered with WrongData", L::AnswersBadCrc),
    link("§L/8", "another monitor's answer is answered", L::AnswersAnswers),
    link("§L/8", "probes are answered without end", L::ProbesWithoutEnd),
    wrong(
        "§L/7",
        "a frame with CRC-32C is answered as a plain one",
        Rule::Port(|bytes| {
            let payload = crc32c_payload(bytes);
            payload.map_or_else(
                || bytes.to_vec(),
                |(dst, src, payload)| raw::frame(dst, src, &payload),
            )
        }),
    ),
    wrong(
        "§L/7",
        "the CRC-32C is not checked",
        Rule::Port(|bytes| {
            let payload = crc32c_payload(bytes);
            payload.map_or_else(
                || bytes.to_vec(),
                |(dst, src, payload)| raw::frame_crc32c(dst, src, &payload, 0),
            )
        }),
    ),
];

/// Payload of a frame with CRC-32C, whatever its CRC; none of these needs an escape.
fn crc32c_payload(bytes: &[u8]) -> Option<(u8, u8, Vec<u8>)> {
    let body = bytes.strip_prefix(&[0xFF, END, ESC, 0xDE])?;
    let [dst, src, payload @ .., _, _, _, _, END] = body else { return None };
    Some((*dst, *src, payload.to_vec()))
}

#[derive(Default)]
pub struct Receiver {
    body: Vec<u8>,
    open: bool,
    noise: bool,
    count: u32,
    last: Vec<u8>,
    late: Option<(u64, Vec<u8>)>,
    ear: Ear,
}

impl Receiver {
    pub fn receive(&mut self, loose: Loose, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        let (mut out, mut frames) = (Vec::new(), 0);
        for byte in bytes {
            if let Some(body) = self.push(loose, *byte)
                && (frames == 0 || loose != L::OneFrameARead)
            {
                let answer = self.answer(loose, sim, &body);
                frames += 1;
                out.extend(answer);
            }
        }
        if loose == L::ForgetsParts {
            self.body.clear();
            self.open = false;
        }
        out
    }

    pub fn tick(&mut self, sim: &Sim) -> Vec<u8> {
        match &self.late {
            Some((at, _)) if sim.now_ms() >= *at => {
                self.late.take().map(|(_, bytes)| bytes).unwrap_or_default()
            }
            _ => Vec::new(),
        }
    }

    fn push(&mut self, loose: Loose, byte: u8) -> Option<Vec<u8>> {
        if byte != END {
            if self.open {
                self.body.push(byte);
            } else {
                self.noise |= byte != 0xFF;
            }
            return None;
        }
        let raw = std::mem::take(&mut self.body);
        let short = raw.len() < 4;
        if !self.open || (short && (loose != L::ShortEndsFrame || raw.is_empty())) {
            self.open = true;
            return None;
        }
        self.open = loose != L::ShortEndsFrame && !short && unescape(loose, &raw).is_none();
        if std::mem::take(&mut self.noise) && loose == L::NoiseKills {
            return None;
        }
        let body = unescape(loose, &raw)?;
        let bad = !is_right(loose, &body);
        if bad {
            self.open = true;
        }
        (!bad || loose == L::AnswersBadCrc).then_some(body)
    }

    /// §L/8
    fn admits(&mut self, loose: Loose, now_ms: u64, src: u8, payload: &[u8]) -> bool {
        let answer = self.ear.is_answer(src) && loose != L::AnswersAnswers;
        let probe = payload.is_empty() && loose != L::ProbesWithoutEnd;
        !answer && (!probe || self.ear.admits_probe(now_ms))
    }

    fn answer(&mut self, loose: Loose, sim: &mut Sim, body: &[u8]) -> Vec<u8> {
        let [dst, src, rest @ ..] = body else { return Vec::new() };
        let payload = &rest[..rest.len().saturating_sub(2)];
        let own = sim.address();
        let mine = *dst == own || loose == L::AnyAddress || (loose == L::Broadcast && *dst == 0);
        if *src == own && *dst != own {
            self.ear.note_asked(*dst);
        }
        if !mine || (*src == own && loose != L::OwnSource) {
            return Vec::new();
        }
        if payload.len() > 512 && loose != L::LongTaken {
            return Vec::new();
        }
        if !self.admits(loose, sim.now_ms(), *src, payload) {
            return Vec::new();
        }
        self.count += 1;
        let repeated = self.last == body;
        self.last = body.to_vec();
        let mut answer = ask(sim, &payload[..payload.len().min(512)]);
        let probe = payload.is_empty();
        match loose {
            L::SometimesSilent if self.count.is_multiple_of(10) => return Vec::new(),
            L::SameFrameOnce if repeated => return Vec::new(),
            L::ProbeSilent if probe => return Vec::new(),
            L::ProbeWithRecord if probe => answer = vec![0xD4, 0xC2, 0, 0],
            L::ProbeAnsweredTwice if probe => return raw::frame(own, *src, &[]),
            L::CutAnswer => _ = answer.pop(),
            L::AnswersBadCrc if !is_right(L::CrcSwapped, body) && raw_is_wrong(body) => {
                answer = vec![0xD4, 0xC2, 8, 0];
            }
            _ => {}
        }
        let wire = frame(loose, *src, own, &answer);
        match loose {
            L::Twice => [wire.clone(), wire].concat(),
            L::TwiceLate => {
                self.late = Some((sim.now_ms() + 150, wire.clone()));
                wire
            }
            L::Unsolicited => {
                self.late =
                    Some((sim.now_ms() + 260, frame(loose, *src, own, &[0xD4, 0xC2, 6, 0])));
                wire
            }
            _ => wire,
        }
    }
}

fn raw_is_wrong(body: &[u8]) -> bool {
    let (rest, sum) = body.split_at(body.len() - 2);
    raw::crc(rest).to_le_bytes() != sum
}

fn unescape(loose: Loose, raw: &[u8]) -> Option<Vec<u8>> {
    if loose == L::NoUnescape {
        return Some(raw.to_vec());
    }
    let (mut body, mut bytes) = (Vec::new(), raw.iter());
    while let Some(byte) = bytes.next() {
        body.push(match *byte {
            ESC => match *bytes.next()? {
                0xDC => END,
                0xDD => ESC,
                other if loose == L::BadEscapeTaken => other,
                _ => return None,
            },
            byte => byte,
        });
    }
    (body.len() >= 4).then_some(body)
}

fn is_right(loose: Loose, body: &[u8]) -> bool {
    let (rest, sum) = body.split_at(body.len() - 2);
    let crc = raw::crc(rest).to_le_bytes();
    match loose {
        L::CrcUnchecked => true,
        L::CrcLowByteOnly => crc[0] == sum[0],
        _ => crc == sum,
    }
}

fn frame(loose: Loose, dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let (dst, src) = match loose {
        L::NotSwapped => (src, dst),
        L::SourceZero => (dst, 0),
        _ => (dst, src),
    };
    let mut body = raw::body(dst, src, payload);
    let len = body.len();
    match loose {
        L::CrcSwapped => body.swap(len - 2, len - 1),
        L::CrcOther => body[len - 1] ^= 0x55,
        _ => {}
    }
    match loose {
        L::Unescaped => [&[END][..], &body, &[END]].concat(),
        L::EscapesSwapped => raw::wire(&body)
            .iter()
            .map(|byte| match *byte {
                0xDC => 0xDD,
                0xDD => 0xDC,
                byte => byte,
            })
            .collect(),
        _ => raw::wire(&body),
    }
}
