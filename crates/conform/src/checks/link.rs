//! §L, §C: the frame and its transport. Bytes only; nothing here can move anything.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Fixed, conform as text};

use crate::bench::Bench;
use crate::raw::{self, Incoming, Rec};
use crate::verdict::{Step, must, not_applicable};

/// Silence after which a frame counts as not answered, ms.
pub const SILENCE_MS: u64 = 400;
/// Frames in a row that must each be answered at the first try.
const IN_A_ROW: usize = 40;
/// §L/6 Largest payload, bytes.
const PAYLOAD_MAX: usize = 512;
/// §L/8 Number of probes answered at once, and the time after which one more is answered, ms.
const PROBES_AT_ONCE: u64 = 255;
const PROBE_AGAIN_MS: u64 = 512;
/// A monitor that answers this many probes never stops.
const PROBES_MAX: u64 = 400;
/// Longest time for an answer to a probe, ms.
const PROBE_MS: u64 = 200;

fn status_of(id: S) -> Vec<u8> {
    Rec::new(R::GET_STATUS, id, &[]).bytes()
}

/// Frames from this monitor: on a shared line, others may answer too.
fn from_monitor(b: &Bench<'_>, incoming: Vec<Incoming>) -> Vec<Incoming> {
    let monitor = b.options.monitor;
    let ours = |i: &Incoming| !matches!(i, Incoming::Frame { src, .. } if *src != monitor);
    incoming.into_iter().filter(ours).collect()
}

fn answered(b: &mut Bench<'_>, wire: &[u8], what: Fixed) -> Step {
    let incoming = b.exchange(wire, 1, b.options.timeout_ms)?;
    let good = matches!(&incoming[..], [Incoming::Frame { .. }]);
    must(good, text::AnAnswerTo { what }, format!("{} frames", incoming.len()))
}

fn silent(b: &mut Bench<'_>, wire: &[u8], what: Fixed) -> Step {
    let incoming = b.exchange(wire, usize::MAX, SILENCE_MS)?;
    let heard = from_monitor(b, incoming).len();
    must(heard == 0, text::NoAnswerTo { what }, format!("{heard} frames"))?;
    let good = b.framed_bytes(&status_of(S::GENERAL));
    answered(b, &good, text::GoodFrameAfter.fixed())
}

/// §L/1 Ids made of C0 and DB are escaped in both directions.
pub fn escapes(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    for id in [raw::END, raw::ESC, 0xDC, 0xDD] {
        if S::CHAIN.contains(&S(id)) || S(id).name().is_some() {
            continue;
        }
        b.refused(R::GET_STATUS, S(id), &[], S(id), Status::MODULE_NOT_EXIST)?;
        let data = [id, raw::END];
        b.refused(R::GET_PARAM, S::GENERAL, &data, S::GENERAL, Status::INVALID_ID)?;
    }
    Ok(())
}

/// §L/2
pub fn checksum(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let good = raw::body(b.options.monitor, b.options.source, &status_of(S::GENERAL));
    let last = good.len() - 1;
    let mut swapped = good.clone();
    swapped.swap(last - 1, last);
    let mut bad = vec![swapped];
    for at in [0, 1, 2, 5, last - 1, last] {
        let mut body = good.clone();
        // Changing the lowest bit of an address would address another monitor.
        body[at] ^= 0x10;
        if at == 0 {
            body[1] ^= 0x10;
            body[0] = good[0];
        }
        bad.push(body);
    }
    for body in bad {
        silent(b, &raw::wire(&body), text::WrongCrc.fixed())?;
    }
    Ok(())
}

/// §L/3
pub fn noise(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    if b.line.is_datagram() {
        return not_applicable(text::DatagramIsOneFrame);
    }
    let good = b.framed_bytes(&status_of(S::GENERAL));
    for noise in
        [&[0xFF; 7][..], &[0x53, 0xAA, 0x01, 0x00, 0x7F], &[0xC0, 0x11, 0x22, 0x33, 0x44, 0x53]]
    {
        let wire = [noise, &good].concat();
        answered(b, &wire, text::FrameAfterNoise.fixed())?;
    }
    Ok(())
}

/// §L/3
pub fn dribble(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    if b.line.is_datagram() {
        return not_applicable(text::DatagramIsOneFrame);
    }
    let good = b.framed_bytes(&status_of(S::GENERAL));
    let (last, first) = good.split_last().unwrap_or((&raw::END, &[]));
    for byte in first {
        b.line.send(&[*byte]).map_err(crate::verdict::Halt::Link)?;
        let early = b.collect(&[*byte], 1, 3)?;
        must(early.is_empty(), text::NoEarlyAnswer, "")?;
    }
    answered(b, &[*last], text::FrameSentByteByByte.fixed())
}

/// §L/3
pub fn two_at_once(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let absent = b.framed_bytes(&status_of(S(0)));
    let both = [b.framed_bytes(&status_of(S::GENERAL)), absent].concat();
    if b.line.is_datagram() {
        return not_applicable(text::DatagramIsOneFrame);
    }
    let incoming = b.exchange(&both, 2, b.options.timeout_ms)?;
    let devices: Vec<S> = incoming.iter().filter_map(device).collect();
    must(devices == [S::GENERAL, S(0)], text::TwoFramesAtOnce, raw::several(&devices))
}

fn device(incoming: &Incoming) -> Option<S> {
    match incoming {
        Incoming::Frame { payload, .. } => payload.get(1).map(|id| S(*id)),
        Incoming::Broken(_) => None,
    }
}

/// §L/4
pub fn bad_escape(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    // A receiver that takes DB 00 for one of these bytes would find the CRC correct.
    for taken in [0x00, raw::ESC, raw::END] {
        let mut payload = status_of(S::GENERAL);
        payload[2] = taken;
        let body = raw::body(b.options.monitor, b.options.source, &payload);
        let mut wire = vec![raw::END];
        for (index, byte) in body.iter().enumerate() {
            match (index, *byte) {
                (4, _) => wire.extend_from_slice(&[raw::ESC, 0x00]),
                (_, raw::END) => wire.extend_from_slice(&[raw::ESC, 0xDC]),
                (_, raw::ESC) => wire.extend_from_slice(&[raw::ESC, 0xDD]),
                (_, byte) => wire.push(byte),
            }
        }
        wire.push(raw::END);
        silent(b, &wire, text::Db00NoEscape.fixed())?;
    }
    Ok(())
}

/// §L/4
pub fn short_frame(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    if b.line.is_datagram() {
        return not_applicable(text::DatagramIsOneFrame);
    }
    let good = b.framed_bytes(&status_of(S::GENERAL));
    let wire = [&[raw::END, 1, 2, 3][..], &good[1..]].concat();
    answered(b, &wire, text::NewFrameAfterThreeBytes.fixed())
}

/// §L/5
pub fn probe(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let probe = b.framed_bytes(&[]);
    let incoming = b.exchange(&probe, 1, b.options.timeout_ms)?;
    let (dst, src) = (b.options.source, b.options.monitor);
    must(
        incoming == [Incoming::Frame { dst, src, payload: Vec::new() }],
        text::ProbeSwapped,
        raw::frames(&incoming),
    )
}

/// §L/6
pub fn other_address(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let (monitor, source) = (b.options.monitor, b.options.source);
    for dst in [0, 255, monitor ^ 0x40, monitor | 128] {
        if dst == source {
            continue;
        }
        let wire = raw::frame(dst, source, &status_of(S::GENERAL));
        silent(b, &wire, text::FrameForAnother.fixed())?;
    }
    Ok(())
}

/// §L/6
pub fn own_source(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let wire = raw::frame(b.options.monitor, b.options.monitor, &status_of(S::GENERAL));
    silent(b, &wire, text::FrameFromOwnAddress.fixed())
}

/// §L/6
pub fn too_long(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let mut payload = Vec::new();
    while payload.len() <= PAYLOAD_MAX {
        payload.extend_from_slice(&status_of(S::GENERAL));
    }
    let wire = b.framed_bytes(&payload);
    silent(b, &wire, text::FrameTooLong.fixed())
}

/// §L/8 A frame in the monitor's name makes another one answer it; that answer is not a request.
pub fn answer_to_another(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let monitor = b.options.monitor;
    let other = another(monitor);
    is_free(b, other)?;
    let probe = raw::frame(other, monitor, &[]);
    silent(b, &probe, text::FrameFromOwnAddress.fixed())?;
    let answer = raw::frame(monitor, other, &[]);
    silent(b, &answer, text::AnswersInItsName.fixed())
}

/// Not applicable if another monitor answers at this address.
pub fn is_free(b: &mut Bench<'_>, address: u8) -> Step {
    let probe = raw::frame(address, b.options.source, &[]);
    match b.exchange(&probe, 1, SILENCE_MS)?.is_empty() {
        true => Ok(()),
        false => not_applicable(text::AnotherMonitor),
    }
}

/// §L/8 A monitor answers probes from addresses of monitors, but not endlessly.
pub fn probes_end(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let monitor = b.options.monitor;
    let probe = raw::frame(monitor, another(monitor), &[]);
    let began_ms = b.now_ms();
    let (mut answered, mut missed) = (0, 0);
    // One frame may be lost; two in a row count as silence.
    while missed < 2 && answered < PROBES_MAX {
        let heard = !b.exchange(&probe, 1, PROBE_MS)?.is_empty();
        missed = if heard { 0 } else { missed + 1 };
        answered += u64::from(heard);
    }
    let most = PROBES_AT_ONCE + 1 + (b.now_ms() - began_ms) / PROBE_AGAIN_MS;
    must(answered <= most, text::ProbesLimited, answered.to_string())?;
    let good = b.framed_bytes(&status_of(S::GENERAL));
    self::answered(b, &good, text::RequestAfterProbes.fixed())
}

/// The address of another possible monitor.
const fn another(monitor: u8) -> u8 {
    if monitor == 127 { 126 } else { 127 }
}

/// §L/7
pub fn crc32c(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let (monitor, source) = (b.options.monitor, b.options.source);
    let good = raw::frame_crc32c(monitor, source, &status_of(S::GENERAL), 0);
    let incoming = b.exchange(&good, 1, b.options.timeout_ms)?;
    let Some(answer) = incoming.first() else {
        return not_applicable(text::FrameNotKnown);
    };
    let decoded = match answer {
        Incoming::Broken(raw) => raw::decode_crc32c(raw),
        Incoming::Frame { .. } => None,
    };
    let right = |(dst, src, payload): (u8, u8, Vec<u8>)| {
        (dst, src) == (source, monitor)
            && payload.get(..3) == Some(&[R::GET_STATUS.0, S::GENERAL.0, Status::OK.0][..])
    };
    must(decoded.is_some_and(right), text::AnswerWithCrc32c, answer.words())?;
    let spoilt = raw::frame_crc32c(monitor, source, &status_of(S::GENERAL), 1);
    silent(b, &spoilt, text::WrongCrc32c.fixed())
}

/// §1/10
pub fn one_answer_each(b: &mut Bench<'_>) -> Step {
    let mut asked: Vec<S> = b.found.present.clone();
    asked.extend([S(0), S(0x01), S(0xFE)]);
    for index in 0..IN_A_ROW {
        let id = asked[index % asked.len()];
        let wire = b.framed_bytes(&status_of(id));
        let incoming = b.exchange(&wire, 1, b.options.timeout_ms)?;
        must(
            incoming.iter().filter_map(device).eq([id]),
            text::AnsweredAtFirstTry,
            format!("frame {}: {} answers", index + 1, incoming.len()),
        )?;
    }
    let late = b.collect(&[], usize::MAX, SILENCE_MS)?;
    must(late.is_empty(), text::NoSecondAnswer, format!("{} frames", late.len()))
}

/// §1/10 A repeated request is answered each time.
pub fn repeated(b: &mut Bench<'_>) -> Step {
    let wire = b.framed_bytes(&status_of(S::GENERAL));
    for _ in 0..5 {
        answered(b, &wire, text::SameFrameAgain.fixed())?;
    }
    Ok(())
}

/// §C/1
pub fn second_connection(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let Some(mut other) = b.line.another() else {
        return not_applicable(text::OneConnectionOnly);
    };
    let wire = b.framed_bytes(&status_of(S(0)));
    other.send(&wire).map_err(crate::verdict::Halt::Link)?;
    let mine = b.collect(&[], 1, SILENCE_MS)?;
    must(mine.is_empty(), text::AnswerToWhoAsked, "")?;
    let theirs = other.recv(b.options.timeout_ms).map_err(crate::verdict::Halt::Link)?;
    must(!theirs.is_empty(), text::AnswerOnSecondConnection, "")?;
    let good = b.framed_bytes(&status_of(S::GENERAL));
    answered(b, &good, text::OnFirstConnection.fixed())
}

/// §C/3
pub fn bare_records(b: &mut Bench<'_>) -> Step {
    if b.is_framed() {
        return not_applicable(text::LinkFramesCarried);
    }
    let two = [status_of(S::GENERAL), status_of(S(0))].concat();
    let incoming = b.exchange(&two, 2, b.options.timeout_ms)?;
    must(incoming.len() == 2, text::AnswerToEachRecord, "")
}
