//! §3.6 SetupCorrectionTable: stores corrections of the elevation by pressure (data: ours).

use super::{Body, wrong_size};
use crate::dictionary::layouts::{Field, Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{DATA_MAX, Data, NoRoom};
use crate::text::error::Wanted;
use crate::text::fields::{Buffer, Tokens};
use crate::text::parse::{Parsed, U8, list_i8};
use crate::text::write_list;
use crate::{Bytes, DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::SETUP_CORRECTION_TABLE,
    name: "SetupCorrectionTable",
    section: "3.6",
    origin: Origin::Ours,
    addressees: &[SubsystemId::CONTROL],
    title: key!("request-SetupCorrectionTable-title"),
    meaning: key!("request-SetupCorrectionTable-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[Layout {
    name: "Corrections",
    fields: fields! { Corrections: first U8 DeciAtmosphere; },
    repeated: CORRECTION,
    times: (1, usize::MAX),
    prefix: &[],
}];

/// A correction, here and in StartQuench (§3.14).
pub(super) const CORRECTION: &[Field] = fields! { Corrections: correction I8 Degree; };

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    match data {
        [first, corrections @ ..] if !corrections.is_empty() => {
            Ok(Body::SetupCorrectionTable { first: *first, corrections: Bytes(corrections) })
        }
        _ => Err(wrong_size(data)),
    }
}

pub(super) fn encode(first: u8, corrections: Bytes<'_>, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put(&[first])?;
    data.put(corrections.0)
}

pub(crate) fn parse<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Parsed<Body<'b>> {
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

pub(crate) fn write(f: &mut fmt::Formatter<'_>, first: u8, corrections: Bytes<'_>) -> fmt::Result {
    write!(f, " first={first} corrections=")?;
    write_list(f, ",", corrections.iter())
}
