//! Parsing of the text form of requests.

use super::error::{ParseError, Wanted, nearest};
use super::fields::{Buffer, Token, Tokens, hex};
use crate::dictionary::{self, REQUESTS, SUBSYSTEMS};
use crate::id::{ParamId, RequestId, SubsystemId};
use crate::param::Param;
use crate::record::DATA_MAX;
use crate::request::{
    Body, Request, bus, s3_01_move, s3_04_getparam, s3_05_setparam, s3_06_correction_table,
    s3_08_open, s3_09_close, s3_14_quench, s3_15_trajectory, s3_16_seek, s3_17_switch_limits,
    s3_18_lockout, s3_19_clean_flash,
};

/// What is read from a text.
pub(crate) type Parsed<T> = Result<T, ParseError>;

pub(crate) const I16: (i64, i64) = (i16::MIN as i64, i16::MAX as i64);
pub(crate) const I8: (i64, i64) = (i8::MIN as i64, i8::MAX as i64);
pub(crate) const U8: (i64, i64) = (0, u8::MAX as i64);
pub(crate) const U16: (i64, i64) = (0, u16::MAX as i64);

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
pub fn parse<'b>(text: &str, buf: &'b mut [u8]) -> Result<Request<'b>, ParseError> {
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
fn addressee(tokens: &mut Tokens<'_>, id: RequestId) -> Parsed<SubsystemId> {
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

fn subsystem(token: Token<'_>, request: RequestId) -> Parsed<SubsystemId> {
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
fn raw<'b>(tokens: &mut Tokens<'_>, request: RequestId, buf: &'b mut [u8]) -> Parsed<Body<'b>> {
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
) -> Parsed<Body<'b>> {
    Ok(match id {
        RequestId::MOVE => s3_01_move::parse(tokens)?,
        RequestId::GET_PARAM => s3_04_getparam::parse(tokens, to)?,
        RequestId::SET_PARAM => s3_05_setparam::parse(tokens, to, buf)?,
        RequestId::SETUP_CORRECTION_TABLE => s3_06_correction_table::parse(tokens, buf)?,
        RequestId::OPEN => s3_08_open::parse(tokens)?,
        RequestId::CLOSE => s3_09_close::parse(tokens)?,
        RequestId::START_QUENCH => Body::StartQuench(s3_14_quench::parse(tokens, buf)?),
        RequestId::START_TRAJECTORY => Body::StartTrajectory(s3_15_trajectory::parse(tokens, buf)?),
        RequestId::START_SEEK => Body::StartSeek(s3_16_seek::parse(tokens)?),
        RequestId::SWITCH_LIMITS => s3_17_switch_limits::parse(tokens)?,
        RequestId::LOCKOUT => s3_18_lockout::parse(tokens)?,
        RequestId::CLEAN_FLASH => s3_19_clean_flash::parse(tokens)?,
        RequestId::GET_LOG => bus::parse_log(tokens)?,
        // The other requests have no data.
        id => Body::decode(id, &[]).map_err(|_| tokens.missing("data"))?,
    })
}

pub(crate) fn word_i16(tokens: &mut Tokens<'_>, what: &'static str) -> Parsed<i16> {
    let (min, max) = I16;
    let token = tokens.need(Wanted::Number { what, min, max })?;
    token.number(what, I16)
}

pub(crate) fn param(tokens: &mut Tokens<'_>, to: SubsystemId) -> Parsed<ParamId> {
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

/// The key, `key=` and any value; the one of the document may be left out.
pub(crate) fn key(tokens: &mut Tokens<'_>, implied: u16) -> Parsed<u16> {
    let Some(token) = tokens.next() else { return Ok(implied) };
    match token.pair() {
        Some(("key", value)) => value.number("key", U16),
        _ => Err(token.error(Wanted::Word(&["key="]))),
    }
}

/// A word that means a value, or `name=` and any value; `name=` is the last of the words.
pub(crate) fn switch(
    tokens: &mut Tokens<'_>,
    words: &'static [&'static str],
    values: &[u16],
) -> Parsed<u16> {
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

/// Numbers between commas.
pub(crate) fn list_i8(buffer: &mut Buffer<'_>, list: Token<'_>) -> Parsed<()> {
    list.items()
        .try_for_each(|item| buffer.push(&item.number::<i8>("correction", I8)?.to_le_bytes(), item))
}
