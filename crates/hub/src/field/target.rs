//! What an output writes, as the configuration writes it: `coil:12`, `!coil:12`, `holding:100.3`,
//! `holding:100=1/0`, `holding:100&0x00FF=0x0012/0`.

use std::fmt;

use lafet_texts::{Text as _, hub as text};

use super::point::{self, Point};
use super::wire::Table;
use crate::text::Both;

/// A coil, or bits of a holding register, with their values for on and off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Where it is.
    pub table: Table,
    /// Its address, from 0.
    pub address: u16,
    /// The bits that are written.
    pub mask: u16,
    on: u16,
    off: u16,
}

impl Target {
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
        let no_target = || text::CheckTarget { text }.words();
        let (name, place) = rest.split_once(':').ok_or_else(no_target)?;
        let table = Table::ALL.iter().find(|(it, _)| *it == name).ok_or_else(no_target)?.1;
        if !table.is_written() {
            return Err(text::CheckTargetTable { text }.words());
        }
        let digits = place.find(['.', '&', '=']).unwrap_or(place.len());
        let (address, values) = place.split_at(digits);
        let address = point::address_of(address, text)?;
        let (mask, on, off) = match (table.is_bits(), values) {
            (true, "") => (1, 1, 0),
            (true, _) => return Err(text::CheckPointOneBit { text }.words()),
            (false, "") => return Err(text::CheckTargetNoValue { text }.words()),
            (false, values) => values_of(values, text)?,
        };
        let (on, off) = if inverted { (off, on) } else { (on, off) };
        Ok(Self { table, address, mask, on, off })
    }

    /// The value that is written where there is another one.
    pub const fn value(&self, on: bool, before: u16) -> u16 {
        before & !self.mask | if on { self.on } else { self.off }
    }

    /// What a value that was read says; `None`: neither.
    pub const fn state(&self, value: u16) -> Option<bool> {
        match value & self.mask {
            bits if bits == self.on => Some(true),
            bits if bits == self.off => Some(false),
            _ => None,
        }
    }

    /// The rest of its register belongs to others, and is written as it was read.
    pub const fn is_part(&self) -> bool {
        !self.table.is_bits() && self.mask != u16::MAX
    }

    /// Whether two write the same bit.
    pub fn meets(&self, other: &Self) -> bool {
        self.table == other.table && self.address == other.address && self.mask & other.mask != 0
    }

    /// Whether it writes a bit that is read as something else.
    pub fn is_read_by(&self, point: &Point) -> bool {
        self.table == point.table && self.address == point.address && self.mask & point.mask != 0
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Table::ALL.iter().find(|(_, it)| *it == self.table).map_or("", |(name, _)| name);
        write!(f, "{name}:{}", self.address)
    }
}

/// What a target looks like.
pub fn remedy() -> Both {
    text::CheckTargetRemedy.words()
}

/// `.3`, `=1/0`, or `&0x00FF=0x0012/0`: mask, on, off.
fn values_of(values: &str, whole: &str) -> Result<(u16, u16, u16), Both> {
    let no_target = || text::CheckTarget { text: whole }.words();
    if values.starts_with('.') {
        let (mask, on) = point::bits_of(values, whole)?;
        return Ok((mask, on, 0));
    }
    let (mask, pair) = match values.strip_prefix('&') {
        Some(rest) => {
            let (mask, pair) = rest.split_once('=').ok_or_else(no_target)?;
            (point::number(mask).ok_or_else(no_target)?, pair)
        }
        None => (u16::MAX, values.strip_prefix('=').ok_or_else(no_target)?),
    };
    let pair = pair.split_once('/');
    let pair = pair.and_then(|(on, off)| Some((point::number(on)?, point::number(off)?)));
    let (on, off) = pair.ok_or_else(no_target)?;
    if mask == 0 || (on | off) & !mask != 0 {
        return Err(text::CheckPointMask { whole }.words());
    }
    if on == off {
        return Err(text::CheckTargetSame { text: whole }.words());
    }
    Ok((mask, on, off))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_read_and_leave_what_is_not_theirs() {
        for (text, before, on, off) in [
            ("coil:12", 0, 1, 0),
            ("!coil:12", 0, 0, 1),
            ("holding:100.3", 0xFFF7, 0xFFFF, 0xFFF7),
            ("!holding:100.15", 0x1234, 0x1234, 0x9234),
            ("holding:100=1/0", 0xABCD, 1, 0),
            ("holding:100=0/0x00FF", 7, 0, 0xFF),
            ("holding:7&0x00F0=0x0020/0x0010", 0xFFFF, 0xFF2F, 0xFF1F),
        ] {
            let target = Target::parse(text).unwrap_or_else(|what| panic!("{text}: {what:?}"));
            assert_eq!(
                (target.value(true, before), target.value(false, before)),
                (on, off),
                "{text}"
            );
            assert_eq!((target.state(on), target.state(off)), (Some(true), Some(false)), "{text}");
        }
        let value = Target::parse("holding:100=1/0").unwrap();
        assert_eq!((value.state(7), value.is_part()), (None, false));
        assert!(Target::parse("holding:100.3").unwrap().is_part());
    }

    #[test]
    fn what_is_no_target_is_refused_in_both_languages() {
        for (text, en, ru) in [
            ("coil", "says nothing that can be written", "не указывает, что писать"),
            ("relay:1", "says nothing that can be written", "не указывает, что писать"),
            ("discrete:1", "are only read", "только читаются"),
            ("input:1.3", "are only read", "только читаются"),
            ("coil:65536", "not 0…65535", "не 0…65535"),
            ("coil:1=1/0", "one bit", "один бит"),
            ("holding:1", "which bit or values", "какой бит"),
            ("holding:1.16", "not 0…15", "не 0…15"),
            ("holding:1=1", "says nothing that can be written", "не указывает, что писать"),
            ("holding:1=5/5", "on and off are the same", "одинаковы"),
            ("holding:1&0x0F=0x10/0", "bits that the mask has not", "вне маски"),
            ("holding:1&0xF", "says nothing that can be written", "не указывает, что писать"),
        ] {
            let what = Target::parse(text).unwrap_err();
            assert!(what.en.contains(en) && what.ru.contains(ru), "{text}: {what:?}");
        }
    }

    #[test]
    fn targets_meet_in_a_bit() {
        let target = |text| Target::parse(text).unwrap();
        assert!(target("holding:1.3").meets(&target("holding:1=1/0")));
        assert!(!target("holding:1.3").meets(&target("holding:1.4")));
        assert!(!target("coil:1").meets(&target("coil:2")));
        assert!(target("coil:1").is_read_by(&Point::parse("!coil:1").unwrap()));
        assert!(!target("coil:1").is_read_by(&Point::parse("discrete:1").unwrap()));
    }
}
