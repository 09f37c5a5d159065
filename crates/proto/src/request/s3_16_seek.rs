//! §3.16 StartSeek: the detector searches a sector for fires.

use super::exact;
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{Data, NoRoom};
use crate::text::error::Wanted;
use crate::text::fields::Tokens;
use crate::text::parse::{I16, Parsed, word_i16};
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::START_SEEK,
    name: "StartSeek",
    section: "3.16",
    origin: Origin::Read,
    addressees: &[SubsystemId::DETECTOR],
    title: key!("request-StartSeek-title"),
    meaning: key!("request-StartSeek-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[Layout::plain(
    "Seek",
    fields! { Seek:
        start_h I16 Arcmin;
        end_h I16 Arcmin;
        start_v I16 Arcmin;
        end_v I16 Arcmin;
        analyse I16 Choice;
    },
)];

/// §3.16 StartSeek: the sector to search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seek {
    /// One end, horizontal, arc-minutes; may exceed the other.
    pub start_h: i16,
    /// Other end, horizontal, arc-minutes.
    pub end_h: i16,
    /// One end, vertical, arc-minutes.
    pub start_v: i16,
    /// Other end, vertical, arc-minutes.
    pub end_v: i16,
    /// 1: measure each hotbed precisely in a second pass; 0: do not.
    pub analyse: i16,
}

impl Seek {
    pub(super) fn decode(data: &[u8]) -> Result<Self, DecodeError> {
        let [a, b, c, d, e, f, g, h, i, j] = exact(data)?;
        Ok(Self {
            start_h: i16::from_le_bytes([a, b]),
            end_h: i16::from_le_bytes([c, d]),
            start_v: i16::from_le_bytes([e, f]),
            end_v: i16::from_le_bytes([g, h]),
            analyse: i16::from_le_bytes([i, j]),
        })
    }

    pub(super) fn encode(&self, data: &mut Data<'_>) -> Result<(), NoRoom> {
        [self.start_h, self.end_h, self.start_v, self.end_v, self.analyse]
            .into_iter()
            .try_for_each(|value| data.put_i16(value))
    }
}

pub(crate) fn parse(tokens: &mut Tokens<'_>) -> Parsed<Seek> {
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

pub(crate) fn write(f: &mut fmt::Formatter<'_>, seek: &Seek) -> fmt::Result {
    write!(f, " {} {} {} {}", seek.start_h, seek.end_h, seek.start_v, seek.end_v)?;
    match seek.analyse {
        0 => Ok(()),
        1 => f.write_str(" analyse"),
        other => write!(f, " analyse={other}"),
    }
}
