//! Who may connect, and who may do what: addresses, units, registers. No I/O.

use std::net::IpAddr;
use std::ops::RangeInclusive;

use serde::Deserialize;

/// What a master may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing.
    None,
    /// It reads; Stop, Close and Lockout are taken from it.
    #[default]
    Observer,
    /// It commands as well.
    Operator,
}

/// A network, or one address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Net {
    address: IpAddr,
    prefix: u8,
}

impl Net {
    /// Reads `10.0.0.7` or `10.0.0.0/24`.
    pub fn parse(text: &str) -> Option<Self> {
        let (address, prefix) = match text.split_once('/') {
            Some((address, prefix)) => (address, Some(prefix)),
            None => (text, None),
        };
        let address = address.parse::<IpAddr>().ok()?.to_canonical();
        let bits = if address.is_ipv4() { 32 } else { 128 };
        let digits = |it: &&str| !it.is_empty() && it.bytes().all(|byte| byte.is_ascii_digit());
        let prefix = match prefix {
            Some(text) => Some(text).filter(digits)?.parse().ok().filter(|it| *it <= bits)?,
            None => bits,
        };
        Some(Self { address, prefix })
    }

    /// Whether an address is in it.
    pub fn has(&self, other: IpAddr) -> bool {
        match (self.address, other.to_canonical()) {
            (IpAddr::V4(own), IpAddr::V4(other)) => {
                let differs = u32::from(own) ^ u32::from(other);
                differs.checked_shr(32 - u32::from(self.prefix)).unwrap_or(0) == 0
            }
            (IpAddr::V6(own), IpAddr::V6(other)) => {
                let differs = u128::from(own) ^ u128::from(other);
                differs.checked_shr(128 - u32::from(self.prefix)).unwrap_or(0) == 0
            }
            _ => false,
        }
    }
}

/// What some masters may do with some registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// The name of the masters, in logs.
    pub name: String,
    /// Their addresses; none: all, and the master of a serial line.
    pub from: Vec<Net>,
    /// The units; none: all.
    pub units: Vec<u8>,
    /// The registers.
    pub registers: RangeInclusive<u16>,
    /// What they may do.
    pub level: Level,
}

impl Grant {
    /// Whether it is of masters at an address; `None`: on a serial line.
    fn is_of(&self, from: Option<IpAddr>) -> bool {
        self.from.is_empty() || from.is_some_and(|from| self.from.iter().any(|it| it.has(from)))
    }
}

/// What a master may do with registers of a unit: the least of what it may do with each of them. Of each the
/// first grant that fits counts, so that a wider request does not pass by a narrow grant.
pub fn level(grants: &[Grant], from: Option<IpAddr>, unit: u8, first: u16, last: u16) -> Level {
    let of_unit = |it: &&Grant| it.is_of(from) && (it.units.is_empty() || it.units.contains(&unit));
    let own: Vec<&Grant> = grants.iter().filter(of_unit).collect();
    let of = |register: u16| {
        let found = own.iter().find(|it| it.registers.contains(&register));
        found.map_or(Level::None, |it| it.level)
    };
    (first..=last).map(of).min().unwrap_or(Level::None)
}

/// The name of a master: that of the first grant for its address.
pub fn name_of(grants: &[Grant], from: Option<IpAddr>) -> Option<&str> {
    grants.iter().find(|it| it.is_of(from)).map(|it| it.name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ip(text: &str) -> IpAddr {
        text.parse().unwrap()
    }

    #[test]
    fn networks_have_their_addresses() {
        let has = |net: &str, address: &str| Net::parse(net).unwrap().has(ip(address));
        assert!(has("10.0.0.0/24", "10.0.0.255") && !has("10.0.0.0/24", "10.0.1.0"));
        assert!(has("10.0.0.7", "10.0.0.7") && !has("10.0.0.7", "10.0.0.6"));
        assert!(has("0.0.0.0/0", "192.0.2.1") && !has("0.0.0.0/0", "::1"));
        assert!(has("fd00::/8", "fd12::1") && !has("fd00::/8", "fe80::1"));
        // An IPv4 client of a socket that listens on both.
        assert!(has("10.0.0.0/8", "::ffff:10.1.2.3") && has("::/0", "2001:db8::1"));
        for text in ["", "10.0.0", "10.0.0.0/33", "10.0.0.0/", "10.0.0.0/+8", "::/129", "plc", "/8"]
        {
            assert_eq!(Net::parse(text), None, "{text}");
        }
    }

    #[test]
    fn the_first_grant_that_fits_counts() {
        let grant = |name: &str, from: &str, units: &[u8], registers, level| Grant {
            name: name.into(),
            from: Net::parse(from).into_iter().collect(),
            units: units.to_vec(),
            registers,
            level,
        };
        let grants = [
            grant("plc", "10.0.0.7", &[1], 0..=300, Level::Operator),
            grant("plc", "10.0.0.7", &[], 0..=300, Level::Observer),
            grant("others", "", &[2], 0..=124, Level::Observer),
        ];
        let of = |from: &str, unit, first, last| level(&grants, Some(ip(from)), unit, first, last);
        assert_eq!(of("10.0.0.7", 1, 264, 276), Level::Operator);
        assert_eq!(of("10.0.0.7", 2, 264, 276), Level::Observer);
        assert_eq!(of("10.0.0.7", 1, 264, 301), Level::None, "a part of it is not granted");
        assert_eq!(of("10.0.0.8", 2, 0, 124), Level::Observer);
        assert_eq!(of("10.0.0.8", 1, 0, 124), Level::None);
        let narrow = [
            grant("plc", "", &[], 264..=276, Level::Observer),
            grant("plc", "", &[], 0..=671, Level::Operator),
        ];
        let wide = |first, last| level(&narrow, None, 1, first, last);
        assert_eq!((wide(264, 276), wide(257, 276)), (Level::Observer, Level::Observer));
        assert_eq!((wide(256, 263), wide(600, 700)), (Level::Operator, Level::None));
        assert_eq!(level(&grants, None, 2, 0, 1), Level::Observer, "a serial line");
        assert_eq!(name_of(&grants, Some(ip("10.0.0.7"))), Some("plc"));
        assert_eq!(name_of(&grants[..2], Some(ip("10.0.0.8"))), None);
    }
}
