//! A condition on one value of a device, as the configuration writes it:
//! `discrete:12`, `!coil:3`, `holding:100.4`, `input:7&0x00F0=0x0020`.

use std::fmt;

use lafet_texts::{Text as _, hub as text};

use super::wire::Table;
use crate::text::Both;

/// A condition on a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Point {
    /// Where the value is.
    pub table: Table,
    /// Its address, from 0.
    pub address: u16,
    /// The bits that count.
    pub mask: u16,
    /// What they are if the condition is met.
    value: u16,
    /// It is met if they are something else.
    inverted: bool,
}

impl Point {
    /// A bit of a holding register.
    pub const fn holding(address: u16, bit: u16) -> Self {
        let mask = 1 << bit;
        Self { table: Table::Holding, address, mask, value: mask, inverted: false }
    }

    /// Reads what the configuration says.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, Both> {
        let (inverted, rest) = match text.strip_prefix('!') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let (name, place) = rest.split_once(':').ok_or_else(|| no_point(text))?;
        let table = Table::ALL.iter().find(|(it, _)| *it == name).ok_or_else(|| no_point(text))?.1;
        let digits = place.find(['.', '&']).unwrap_or(place.len());
        let (address, condition) = place.split_at(digits);
        let address = address_of(address, text)?;
        let (mask, value) = match (table.is_bits(), condition) {
            (true, "") => (1, 1),
            (true, _) => {
                return Err(text::CheckPointOneBit { text }.words());
            }
            (false, "") => {
                return Err(text::CheckPointNoBit { text }.words());
            }
            (false, condition) => bits_of(condition, text)?,
        };
        Ok(Self { table, address, mask, value, inverted })
    }

    /// Whether the condition is met by a value.
    pub const fn is_met(&self, value: u16) -> bool {
        (value & self.mask == self.value) != self.inverted
    }

    /// Whether two conditions look at the same bit.
    pub fn meets(&self, other: &Self) -> bool {
        self.table == other.table && self.address == other.address && self.mask & other.mask != 0
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Table::ALL.iter().find(|(_, it)| *it == self.table).map_or("", |(name, _)| name);
        write!(f, "{name}:{}", self.address)
    }
}

/// What a point looks like.
pub fn remedy() -> Both {
    text::CheckPointRemedy.words()
}

fn no_point(text: &str) -> Both {
    text::CheckPoint { text }.words()
}

pub(super) fn address_of(text: &str, whole: &str) -> Result<u16, Both> {
    let is_number = !text.is_empty() && text.bytes().all(|it| it.is_ascii_digit());
    text.parse().ok().filter(|_| is_number).ok_or_else(|| text::CheckPointAddress { whole }.words())
}

/// `.3`, or `&0x00F0=0x0020`: mask and value.
pub(super) fn bits_of(condition: &str, whole: &str) -> Result<(u16, u16), Both> {
    if let Some(bit) = condition.strip_prefix('.') {
        let bit = bit
            .parse::<u16>()
            .ok()
            .filter(|it| *it <= 15)
            .ok_or_else(|| text::CheckPointBit { whole }.words())?;
        return Ok((1 << bit, 1 << bit));
    }
    let pair = condition.strip_prefix('&').and_then(|it| it.split_once('='));
    let pair = pair.and_then(|(mask, value)| Some((number(mask)?, number(value)?)));
    let (mask, value) = pair.ok_or_else(|| no_point(whole))?;
    if mask == 0 || value & !mask != 0 {
        return Err(text::CheckPointMask { whole }.words());
    }
    Ok((mask, value))
}

pub(super) fn number(text: &str) -> Option<u16> {
    match text.strip_prefix("0x") {
        Some(digits) => u16::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_and_met() {
        for (text, value, met) in [
            ("discrete:12", 1, true),
            ("!discrete:12", 1, false),
            ("!coil:65535", 0, true),
            ("holding:100.15", 0x8000, true),
            ("holding:100.15", 0x7FFF, false),
            ("!input:0.0", 0xFFFE, true),
            ("input:7&0x00F0=0x0020", 0xFF2F, true),
            ("input:7&0x00F0=0x0020", 0xFF3F, false),
            ("input:7&255=5", 5, true),
            ("holding:9&0x0001=0", 0, true),
        ] {
            let point = Point::parse(text).unwrap_or_else(|what| panic!("{text}: {what:?}"));
            assert_eq!(point.is_met(value), met, "{text} {value:#x}");
        }
    }

    #[test]
    fn what_is_no_point_is_refused_in_both_languages() {
        for (text, en, ru) in [
            ("discrete", "names no bit", "не называет"),
            ("relay:1", "names no bit", "не называет"),
            ("discrete:65536", "not 0…65535", "не 0…65535"),
            ("discrete:-1", "not 0…65535", "не 0…65535"),
            ("discrete:+1", "not 0…65535", "не 0…65535"),
            ("discrete:1.3", "one bit", "один бит"),
            ("holding:1", "which bit", "не указан бит"),
            ("holding:1.16", "not 0…15", "не 0…15"),
            ("holding:1&0x0F=0x10", "bits that the mask has not", "вне маски"),
            ("holding:1&0=0", "the mask has none", "маска пуста"),
            ("holding:1&0xF", "names no bit", "не называет"),
            ("", "names no bit", "не называет"),
        ] {
            let what = Point::parse(text).unwrap_err();
            assert!(what.en.contains(en) && what.ru.contains(ru), "{text}: {what:?}");
        }
    }

    #[test]
    fn two_points_meet_in_a_bit() {
        let point = |text| Point::parse(text).unwrap();
        assert!(point("holding:1.3").meets(&point("!holding:1&0x0F=0x08")));
        assert!(!point("holding:1.3").meets(&point("holding:1.4")));
        assert!(!point("holding:1.3").meets(&point("input:1.3")));
        assert_eq!(Point::holding(8, 13), point("holding:8.13"));
    }
}
