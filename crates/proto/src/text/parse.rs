//! Parsing of the text form of requests.

use super::error::{ParseError, Wanted, nearest};
use super::fields::{Buffer, Token, Tokens, hex};
use crate::dictionary::{self, REQUESTS, SUBSYSTEMS};
use crate::id::{ParamId, RequestId, SubsystemId, key};
use crate::param::Param;
use crate::record::DATA_MAX;
use crate::request::{
    Body, Path, Points, Quench, Request, Sector, Seek, Trajectory, TrajectoryPoint,
};
use crate::{Bytes, Ints};

type Result<T> = core::result::Result<T, ParseError>;

const I16: (i64, i64) = (i16::MIN as i64, i16::MAX as i64);
const I8: (i64, i64) = (i8::MIN as i64, i8::MAX as i64);
const U8: (i64, i64) = (0, u8::MAX as i64);
const U16: (i64, i64) = (0, u16::MAX as i64);

/// Reads the text form of a request. Its data are stored in `buf`, which needs at most
/// [`super::BUFFER_SIZE`] bytes.
///
/// ```
/// use lafet_proto::{Request, SubsystemId, text};
///
/// let mut buf = [0; text::BUFFER_SIZE];
/// assert_eq!(text::parse("open valve1", &mut buf), Ok(Request::open(SubsystemId::VALVE1)));
///
/// let error = text::parse("Opn Valve1", &mut buf).unwrap_err();
/// assert_eq!((error.column, error.suggestion), (0, Some("Open")));
/// ```
///
/// # Errors
///
/// [`ParseError`](super::ParseError): the byte offset of the error, what was expected there, and
/// the name that may have been meant.
pub fn parse<'b>(text: &str, buf: &'b mut [u8]) -> Result<Request<'b>> {
    let mut tokens = Tokens::new(text);
    let name = tokens.need(Wanted::Request)?;
    let known = REQUESTS.iter().find(|info| info.name.eq_ignore_ascii_case(name.text));
    let request = match known {
        Some(info) => {
            let to = addressee(&mut tokens, info.id)?;
            Request::new(to, body(&mut tokens, info.id, to, buf)?)
        }
        None => {
            let id = hex_id(name.text).map(RequestId).ok_or_else(|| {
                let names = REQUESTS.iter().map(|info| info.name);
                name.error(Wanted::Request).or_suggest(nearest(name.text, names))
            })?;
            let to = tokens.need(Wanted::Addressee(id))?;
            Request::new(subsystem(to, id)?, raw(&mut tokens, id, buf)?)
        }
    };
    match tokens.next() {
        Some(extra) => Err(extra.error(Wanted::End)),
        None => Ok(request),
    }
}

/// The addressee; it may be left out where only one is possible.
fn addressee(tokens: &mut Tokens<'_>, id: RequestId) -> Result<SubsystemId> {
    let only = match dictionary::request(id).map(|info| info.addressees) {
        Some([only]) => Some(*only),
        _ => None,
    };
    let data = |word: &str| {
        !word.starts_with(|c: char| c.is_ascii_alphabetic())
            || word.contains('=')
            || ["on", "off", "ballistics", "repeat"].iter().any(|w| w.eq_ignore_ascii_case(word))
    };
    match (only, tokens.peek()) {
        (Some(only), None) => Ok(only),
        (Some(only), Some(word)) if hex_id(word.text).is_none() && data(word.text) => Ok(only),
        _ => subsystem(tokens.need(Wanted::Addressee(id))?, id),
    }
}

fn subsystem(token: Token<'_>, request: RequestId) -> Result<SubsystemId> {
    SUBSYSTEMS
        .iter()
        .find(|info| info.name.eq_ignore_ascii_case(token.text))
        .map(|info| info.id)
        .or_else(|| hex_id(token.text).map(SubsystemId))
        .ok_or_else(|| {
            let names = SUBSYSTEMS.iter().map(|info| info.name);
            token.error(Wanted::Addressee(request)).or_suggest(nearest(token.text, names))
        })
}

/// `0x` and a value of one byte.
fn hex_id(word: &str) -> Option<u8> {
    hex(word).and_then(|id| u8::try_from(id).ok())
}

/// Data in hexadecimal; data valid for the request become that request.
fn raw<'b>(tokens: &mut Tokens<'_>, request: RequestId, buf: &'b mut [u8]) -> Result<Body<'b>> {
    let mut buffer = Buffer::new(buf, DATA_MAX);
    while let Some(token) = tokens.next() {
        let (pairs, []) = token.text.as_bytes().as_chunks::<2>() else {
            return Err(token.error(Wanted::Hex));
        };
        for pair in pairs {
            let digits = core::str::from_utf8(pair).ok().filter(|d| !d.contains('+'));
            let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
            buffer.push(&[byte.ok_or(token.error(Wanted::Hex))?], token)?;
        }
    }
    let data = buffer.finish();
    Ok(Body::decode(request, data).unwrap_or(Body::Unknown { request, data }))
}

fn body<'b>(
    tokens: &mut Tokens<'_>,
    id: RequestId,
    to: SubsystemId,
    buf: &'b mut [u8],
) -> Result<Body<'b>> {
    Ok(match id {
        RequestId::MOVE => Body::Move { destination: word_i16(tokens, "destination")? },
        RequestId::GET_PARAM => Body::GetParam { id: param(tokens, to)? },
        RequestId::SET_PARAM => {
            let id = param(tokens, to)?;
            Body::SetParam { id, values: values(tokens, buf)? }
        }
        RequestId::OPEN => Body::Open { key: key(tokens, key::OPEN)? },
        RequestId::CLOSE => Body::Close { key: key(tokens, key::CLOSE)? },
        RequestId::CLEAN_FLASH => Body::CleanFlash { key: key(tokens, key::CLEAN_FLASH)? },
        RequestId::LOCKOUT => Body::Lockout {
            key: switch(tokens, &["on", "off", "key="], &[key::ENABLE, key::DISABLE])?,
        },
        RequestId::SWITCH_LIMITS => Body::SwitchLimits {
            new_state: switch(tokens, &["off", "on", "reject", "state="], &[0, 1, 2])?,
        },
        RequestId::START_SEEK => Body::StartSeek(seek(tokens)?),
        RequestId::START_QUENCH => Body::StartQuench(quench(tokens, buf)?),
        RequestId::START_TRAJECTORY => Body::StartTrajectory(trajectory(tokens, buf)?),
        RequestId::SETUP_CORRECTION_TABLE => correction_table(tokens, buf)?,
        RequestId::GET_LOG => log(tokens)?,
        // The other requests have no data.
        id => Body::decode(id, &[]).map_err(|_| tokens.missing("data"))?,
    })
}

fn word_i16(tokens: &mut Tokens<'_>, what: &'static str) -> Result<i16> {
    let (min, max) = I16;
    let token = tokens.need(Wanted::Number { what, min, max })?;
    token.number(what, I16)
}

fn param(tokens: &mut Tokens<'_>, to: SubsystemId) -> Result<ParamId> {
    let token = tokens.need(Wanted::Param(to))?;
    let word = token.text;
    if let Some(name) = word.strip_prefix('@').filter(|name| !name.is_empty()) {
        return Ok(ParamId::of(name));
    }
    let named = Param::by_name(to, word)
        .or_else(|| Param::ALL.into_iter().find(|p| p.name().eq_ignore_ascii_case(word)));
    let number = || hex(word).and_then(|id| u16::try_from(id).ok()).map(ParamId);
    named.map(|param| param.spec().id).or_else(number).ok_or_else(|| {
        let nearest = nearest(word, Param::of(to).map(Param::name))
            .or_else(|| nearest(word, Param::ALL.into_iter().map(Param::name)));
        token.error(Wanted::Param(to)).or_suggest(nearest)
    })
}

fn values<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Result<Ints<'b>> {
    let mut buffer = Buffer::new(buf, DATA_MAX - 2);
    while let Some(token) = tokens.next() {
        buffer.push(&token.int32("value")?.to_le_bytes(), token)?;
    }
    Ok(Ints::Wire(buffer.finish()))
}

fn key(tokens: &mut Tokens<'_>, implied: u16) -> Result<u16> {
    let Some(token) = tokens.next() else { return Ok(implied) };
    match token.pair() {
        Some(("key", value)) => value.number("key", U16),
        _ => Err(token.error(Wanted::Word(&["key="]))),
    }
}

/// A word that means a value, or `name=` and any value; `name=` is the last of the words.
fn switch(tokens: &mut Tokens<'_>, words: &'static [&'static str], values: &[u16]) -> Result<u16> {
    let token = tokens.need(Wanted::Word(words))?;
    let named = words.last().and_then(|last| last.strip_suffix('='));
    match token.pair() {
        Some((name, value)) if Some(name) == named => value.number("value", U16),
        _ => words
            .iter()
            .zip(values)
            .find(|(word, _)| word.eq_ignore_ascii_case(token.text))
            .map(|(_, value)| *value)
            .ok_or_else(|| token.error(Wanted::Word(words))),
    }
}

/// StartSeek, §3.16.
fn seek(tokens: &mut Tokens<'_>) -> Result<Seek> {
    let mut seek = Seek {
        start_h: word_i16(tokens, "start, horizontal")?,
        end_h: word_i16(tokens, "end, horizontal")?,
        start_v: word_i16(tokens, "start, vertical")?,
        end_v: word_i16(tokens, "end, vertical")?,
        analyse: 0,
    };
    if let Some(token) = tokens.next() {
        seek.analyse = match token.pair() {
            None if token.text.eq_ignore_ascii_case("analyse") => 1,
            Some(("analyse", value)) => value.number("analyse", I16)?,
            _ => return Err(token.error(Wanted::Word(&["analyse", "analyse="]))),
        };
    }
    Ok(seek)
}

/// StartQuench, §3.14: the keys select the variant.
fn quench<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Result<Quench<'b>> {
    const KEYS: &[&str] =
        &["program=", "centre=", "nozzle=", "sector=", "step=", "distance=", "corrections="];
    let (mut program, mut centre, mut nozzle) = (None, None, None);
    let (mut sector, mut step, mut distance, mut corrections) = (None, None, None, None);
    let mut buffer = Buffer::new(buf, DATA_MAX - 11);
    while let Some(token) = tokens.next() {
        match token.pair() {
            Some(("program", value)) => token.set(&mut program, value.number("program", I16)?)?,
            Some(("centre" | "center", value)) => {
                token.set(&mut centre, value.numbers::<2>("centre h,v", I16)?)?;
            }
            Some(("nozzle", value)) => token.set(&mut nozzle, value.number("nozzle", I16)?)?,
            Some(("sector", value)) => {
                token.set(&mut sector, value.numbers::<2>("sector width,height", I16)?)?;
            }
            Some(("step", value)) => token.set(&mut step, value.number("step", I8)?)?,
            Some(("distance", value)) => token.set(&mut distance, value.number("distance", I8)?)?,
            Some(("corrections", value)) => {
                token.set(&mut corrections, ())?;
                list_i8(&mut buffer, value)?;
            }
            _ => return Err(token.error(Wanted::Word(KEYS))),
        }
    }
    let (Some(([centre_h, centre_v], _)), Some((nozzle, _))) = (centre, nozzle) else {
        return Err(tokens.missing(if centre.is_none() { "centre=" } else { "nozzle=" }));
    };
    if let Some((program, _)) = program {
        let others = [
            ("sector=", sector.map(|(_, t)| t)),
            ("step=", step.map(|(_, t)| t)),
            ("distance=", distance.map(|(_, t)| t)),
            ("corrections=", corrections.map(|(_, t)| t)),
        ];
        return match others.into_iter().find_map(|(name, token)| Some((name, token?))) {
            Some((name, token)) => Err(token.error(Wanted::NotTogether("program=", name))),
            None => Ok(Quench::Program { program, centre_h, centre_v, nozzle }),
        };
    }
    let (Some(([width, height], _)), Some((step, _))) = (sector, step) else {
        return Err(tokens.missing(if sector.is_none() { "sector=" } else { "step=" }));
    };
    let sector = Sector { centre_h, centre_v, nozzle, width, height, step };
    match (distance, corrections) {
        (Some((distance, _)), None) => Ok(Quench::Full { sector, distance }),
        (None, Some((_, token))) => {
            let corrections = Bytes(buffer.finish());
            // A single correction would be read as the distance (§3.14: the size is the variant).
            if corrections.0.len() < 2 {
                return Err(token.error(Wanted::Numbers { what: "corrections", count: 2 }));
            }
            Ok(Quench::Corrected { sector, corrections })
        }
        (Some(_), Some((_, token))) => {
            Err(token.error(Wanted::NotTogether("distance=", "corrections=")))
        }
        (None, None) => Err(tokens.missing("distance= or corrections=")),
    }
}

fn list_i8(buffer: &mut Buffer<'_>, list: Token<'_>) -> Result<()> {
    list.items()
        .try_for_each(|item| buffer.push(&item.number::<i8>("correction", I8)?.to_le_bytes(), item))
}

/// StartTrajectory, §3.15.
fn trajectory<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Result<Trajectory<'b>> {
    const KEYS: &[&str] = &["ballistics", "repeat", "point=", "stored="];
    let (mut ballistics, mut repeat) = (None, None);
    let (mut first_point, mut stored) = (None, None);
    let mut buffer = Buffer::new(buf, DATA_MAX - 3);
    while let Some(token) = tokens.next() {
        match token.pair() {
            None if token.text.eq_ignore_ascii_case("ballistics") => {
                token.set(&mut ballistics, ())?;
            }
            None if token.text.eq_ignore_ascii_case("repeat") => token.set(&mut repeat, ())?,
            Some(("point", value)) => {
                first_point.get_or_insert(token);
                buffer.push(&point(value)?.to_bytes(), token)?;
            }
            Some(("stored", value)) => {
                token.set(&mut stored, ())?;
                value.items().try_for_each(|item| {
                    buffer.push(&[item.number::<u8>("trajectory", U8)?], item)
                })?;
            }
            _ => return Err(token.error(Wanted::Word(KEYS))),
        }
    }
    let path = match (first_point, stored) {
        (Some(_), Some((_, token))) => {
            return Err(token.error(Wanted::NotTogether("point=", "stored=")));
        }
        (Some(_), None) => Path::Points(Points::Wire(buffer.finish())),
        (None, Some(_)) => Path::Stored(buffer.finish()),
        (None, None) => return Err(tokens.missing("point= or stored=")),
    };
    Ok(Trajectory { ballistics: ballistics.is_some(), repeat: repeat.is_some(), path })
}

fn point(list: Token<'_>) -> Result<TrajectoryPoint> {
    let what = "point h,v,distance,dwell";
    let [horizontal, vertical, distance, dwell] = list.split::<4>(what)?;
    Ok(TrajectoryPoint {
        horizontal: horizontal.number("horizontal", I16)?,
        vertical: vertical.number("vertical", I16)?,
        distance: distance.number("distance", U8)?,
        dwell: dwell.number("dwell", U8)?,
    })
}

/// SetupCorrectionTable, §3.6.
fn correction_table<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Result<Body<'b>> {
    let (mut first, mut corrections) = (None, None);
    let mut buffer = Buffer::new(buf, DATA_MAX - 1);
    while let Some(token) = tokens.next() {
        match token.pair() {
            Some(("first", value)) => token.set(&mut first, value.number("first", U8)?)?,
            Some(("corrections", value)) => {
                token.set(&mut corrections, ())?;
                list_i8(&mut buffer, value)?;
            }
            _ => return Err(token.error(Wanted::Word(&["first=", "corrections="]))),
        }
    }
    let Some((first, _)) = first else { return Err(tokens.missing("first=")) };
    if corrections.is_none() {
        return Err(tokens.missing("corrections="));
    }
    Ok(Body::SetupCorrectionTable { first, corrections: Bytes(buffer.finish()) })
}

/// The bus controller's log (observed).
fn log(tokens: &mut Tokens<'_>) -> Result<Body<'static>> {
    let (mut first, mut count) = (None, None);
    while let Some(token) = tokens.next() {
        match token.pair() {
            Some(("first", value)) => token.set(&mut first, value.number("first", U16)?)?,
            Some(("count", value)) => token.set(&mut count, value.number("count", U16)?)?,
            _ => return Err(token.error(Wanted::Word(&["first=", "count="]))),
        }
    }
    let (Some((first, _)), Some((count, _))) = (first, count) else {
        return Err(tokens.missing(if first.is_none() { "first=" } else { "count=" }));
    };
    Ok(Body::GetLog { first, count })
}
