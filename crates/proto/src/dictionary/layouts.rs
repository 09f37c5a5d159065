//! §3 Layout of the data of requests and answers, for tools that read bytes without this crate's
//! types, such as dissectors, recorders and bindings.

use super::Key;
use crate::id::{RequestId, SubsystemId};
use crate::param::Unit;
use crate::request::{
    bus, s3_01_move, s3_03_getstatus, s3_04_getparam, s3_05_setparam, s3_06_correction_table,
    s3_08_open, s3_09_close, s3_14_quench, s3_15_trajectory, s3_16_seek, s3_17_switch_limits,
    s3_18_lockout, s3_19_clean_flash, s3_20_crash_data, s3_21_hotbeds,
};
use crate::status::Limits;

/// Type of a field; all are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// Unsigned, 1 byte.
    U8,
    /// Signed, 1 byte.
    I8,
    /// Unsigned, 2 bytes.
    U16,
    /// Signed, 2 bytes.
    I16,
    /// Unsigned, 4 bytes.
    U32,
    /// Signed, 4 bytes.
    I32,
    /// The status word of the answering subsystem, 4 bytes: see [`crate::flags::flags_of`].
    Flags,
    /// Identifier of a parameter, 2 bytes.
    ParamId,
    /// Confirms a dangerous request, 2 bytes: see [`crate::id::key`].
    Key,
}

impl Kind {
    /// Bytes on the wire.
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::ParamId | Self::Key => 2,
            Self::U32 | Self::I32 | Self::Flags => 4,
        }
    }

    fn read(self, bytes: &[u8]) -> Option<i64> {
        let word = bytes.get(..self.size())?;
        let unsigned = word.iter().rev().fold(0, |value, byte| value << 8 | i64::from(*byte));
        Some(match self {
            Self::I8 => i64::from(unsigned as i8),
            Self::I16 => i64::from(unsigned as i16),
            Self::I32 => i64::from(unsigned as i32),
            _ => unsigned,
        })
    }
}

/// A field of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Type of the field.
    pub kind: Kind,
    /// Unit of the value.
    pub unit: Unit,
    /// Meaning of the value.
    pub text: Key,
}

/// The structure of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Layout {
    /// Name of the structure.
    pub name: &'static str,
    /// The fields in order.
    pub fields: &'static [Field],
    /// Fields that repeat until the data end.
    pub repeated: &'static [Field],
    /// Least and greatest number of repetitions.
    pub times: (usize, usize),
    /// First bytes of the data, which select this structure among those of equal size.
    pub prefix: &'static [u8],
}

impl Layout {
    /// A structure in which nothing repeats.
    pub const fn plain(name: &'static str, fields: &'static [Field]) -> Self {
        Self { name, fields, repeated: &[], times: (0, 0), prefix: &[] }
    }

    /// Bytes without the repeated fields.
    pub const fn size(&self) -> usize {
        size(self.fields)
    }

    /// Whether data can have this structure.
    pub fn fits(&self, data: &[u8]) -> bool {
        let Some(rest) = data.len().checked_sub(self.size()) else { return false };
        let (least, most) = self.times;
        let whole = match size(self.repeated) {
            0 => rest == 0,
            step => rest % step == 0 && (least..=most).contains(&(rest / step)),
        };
        whole && data.starts_with(self.prefix)
    }

    /// The fields of the data: offset, field, value.
    pub fn values<'d>(
        &self,
        data: &'d [u8],
    ) -> impl Iterator<Item = (usize, &'static Field, i64)> + use<'d> {
        let (fields, repeated) = (self.fields, self.repeated);
        // A repetition has at least one byte, so there are at most as many as bytes.
        let rounds = if repeated.is_empty() { 0 } else { data.len() };
        let all = fields.iter().chain((0..rounds).flat_map(move |_| repeated));
        let mut at = 0usize;
        all.map_while(move |field| {
            let (from, value) = (at, field.kind.read(data.get(at..)?)?);
            at = from.saturating_add(field.kind.size());
            Some((from, field, value))
        })
    }
}

const fn size(mut fields: &[Field]) -> usize {
    let mut size = 0;
    while let [first, rest @ ..] = fields {
        (size, fields) = (size + first.kind.size(), rest);
    }
    size
}

/// Names of the first fields; empty after the last.
pub(crate) const fn names<const N: usize>(mut fields: &[Field]) -> [&'static str; N] {
    let mut names = [""; N];
    let mut places: &mut [&'static str] = &mut names;
    while let ([first, rest @ ..], [place, others @ ..]) = (fields, places) {
        *place = first.name;
        (fields, places) = (rest, others);
    }
    names
}

/// Structures that the data of a request can have: the first that fits applies.
pub const fn of_request(request: RequestId) -> &'static [Layout] {
    match request {
        RequestId::MOVE => s3_01_move::LAYOUTS,
        RequestId::GET_PARAM => s3_04_getparam::LAYOUTS,
        RequestId::SET_PARAM => s3_05_setparam::LAYOUTS,
        RequestId::SETUP_CORRECTION_TABLE => s3_06_correction_table::LAYOUTS,
        RequestId::OPEN => s3_08_open::LAYOUTS,
        RequestId::CLOSE => s3_09_close::LAYOUTS,
        RequestId::START_QUENCH => s3_14_quench::LAYOUTS,
        RequestId::START_TRAJECTORY => s3_15_trajectory::LAYOUTS,
        RequestId::START_SEEK => s3_16_seek::LAYOUTS,
        RequestId::SWITCH_LIMITS => s3_17_switch_limits::LAYOUTS,
        RequestId::LOCKOUT => s3_18_lockout::LAYOUTS,
        RequestId::CLEAN_FLASH => s3_19_clean_flash::LAYOUTS,
        RequestId::GET_LOG => &[bus::LOG_RANGE],
        _ => &[EMPTY],
    }
}

/// Structures that the data of an answer can have, unless they are empty: the first that fits
/// applies.
pub const fn of_answer(request: RequestId, from: SubsystemId) -> &'static [Layout] {
    match request {
        RequestId::GET_STATUS => s3_03_getstatus::of_status(from),
        RequestId::GET_PARAM | RequestId::SET_PARAM | RequestId::GET_HOTBED => {
            &[s3_21_hotbeds::HOTBEDS, s3_05_setparam::PARAM]
        }
        RequestId::RETRIEVE_LIMITS => &[Limits::LAYOUT],
        RequestId::GET_CRASH_DATA => &[s3_20_crash_data::CORTEX_M3, s3_20_crash_data::ARM7TDMI],
        RequestId::GET_NETWORK_STATUS => &[bus::NETWORK],
        RequestId::GET_LOG => &[bus::LOG],
        _ => &[],
    }
}

macro_rules! fields {
    ($group:ident: $($field:ident $kind:ident $unit:ident;)*) => {
        &[$($crate::dictionary::layouts::Field {
            name: stringify!($field),
            kind: $crate::dictionary::layouts::Kind::$kind,
            unit: $crate::param::Unit::$unit,
            text: $crate::dictionary::key!("field-", stringify!($group), "-", stringify!($field)),
        }),*]
    };
}

pub(crate) use fields;

const EMPTY: Layout = Layout::plain("Empty", &[]);

/// The data of the four requests that a key confirms.
pub(crate) const KEY: Layout = Layout::plain("Key", fields! { Request: key Key Bits; });
