//! A session, and its compact form in the fragment of a URL.
//!
//! The fragment is `1.` and Base64 (URL alphabet, no padding) of: seed, profile, wind, duration, actions,
//! CRC-16. Numbers are LEB128; a time is the number of 10 ms steps since the action before. It is
//! hostile input: whatever it holds, what comes out is within the bounds below.

use lafet_device::Composition;
use lafet_proto::link::{self, PAYLOAD_MAX, WIRE_MAX};
use lafet_sim::fault::Fault;
use lafet_texts::{Text as _, Words, play as text};

use crate::view::Link;

/// Characters of a fragment at most.
pub const FRAGMENT_MAX: usize = 8_000;
/// Actions of a session at most.
pub const ACTIONS_MAX: usize = 200;
/// Duration of a session at most, steps of 10 ms: half an hour.
pub const STEPS_MAX: u32 = 180_000;
/// Fires of a session at most.
pub const FIRES_MAX: usize = 8;
/// Wind at most, m/s.
pub const WIND_MAX: i8 = 20;
/// Range of a fire, m.
pub const RANGE: core::ops::RangeInclusive<u8> = 1..=80;

/// Version of the form; another one is refused.
const VERSION: &str = "1.";
const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
const NAME_MAX: usize = 40;
/// Set in each byte of a number but its last.
const MORE: u8 = 1 << 7;

/// What a session starts from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Everything random comes from this.
    pub seed: u32,
    /// What the monitor is built of.
    pub profile: &'static str,
    /// Wind, m/s: forward and left.
    pub wind: [i8; 2],
}

impl Setup {
    /// The setup of these values, if they are within bounds.
    pub fn new(seed: u32, profile: &str, wind: [i8; 2]) -> Result<Self, Words> {
        let known = Composition::by_name(profile).ok_or_else(|| text::NoProfile.words())?;
        if wind.iter().any(|it| it.unsigned_abs() > WIND_MAX.unsigned_abs()) {
            return Err(text::WindAtMost { most: WIND_MAX }.words());
        }
        Ok(Self { seed, profile: known.name, wind })
    }
}

impl Default for Setup {
    fn default() -> Self {
        Self { seed: 1, profile: Composition::FULL.name, wind: [0; 2] }
    }
}

/// Something done to the monitor or to its world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Records, which are sent in a frame.
    Send(Link, Vec<u8>),
    /// Bytes, which are sent as they are.
    Wire(Link, Vec<u8>),
    /// A fault comes.
    Break(Fault),
    /// A fault is repaired.
    Repair(Fault),
    /// A fire: degrees to the left, metres, light fuel.
    Light(i16, u8, bool),
    /// All fires are cleared away.
    Sweep,
    /// The supply is off for half a second.
    Power,
}

/// A session: what it starts from, what was done when, how long it lasted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Session {
    /// What it starts from.
    pub setup: Setup,
    /// Step and action, in order.
    pub actions: Vec<(u32, Action)>,
    /// Duration, steps.
    pub steps: u32,
}

/// An action that cannot be added at this step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepsError;

impl Session {
    /// Adds an action; steps never go back.
    pub fn push(&mut self, step: u32, action: Action) -> Result<(), StepsError> {
        let last = self.actions.last().map_or(0, |(at, _)| *at);
        if step < last || step > STEPS_MAX {
            return Err(StepsError);
        }
        self.actions.push((step, action));
        self.steps = self.steps.max(step);
        Ok(())
    }

    /// Whether one more action of this kind keeps it within its bounds.
    pub fn has_room(&self, action: &Action) -> bool {
        let fires = |it: &&(u32, Action)| matches!(it.1, Action::Light(..));
        let lit = matches!(action, Action::Light(..));
        if self.actions.len() >= ACTIONS_MAX
            || lit && self.actions.iter().filter(fires).count() >= FIRES_MAX
        {
            return false;
        }
        let mut longer = self.clone();
        longer.actions.push((longer.steps, action.clone()));
        longer.steps = STEPS_MAX;
        longer.fragment().len() <= FRAGMENT_MAX
    }

    /// As the fragment of a URL, without `#`.
    pub fn fragment(&self) -> String {
        let mut out = Vec::new();
        put(&mut out, self.setup.seed);
        put_bytes(&mut out, self.setup.profile.as_bytes());
        out.extend(self.setup.wind.map(i8::cast_unsigned));
        put(&mut out, self.steps);
        put(&mut out, self.actions.len() as u32);
        let mut last = 0;
        for (step, action) in &self.actions {
            put(&mut out, step - last);
            last = *step;
            put_action(&mut out, action);
        }
        let crc = link::crc16(&out);
        out.extend(crc.to_le_bytes());
        VERSION.to_owned() + &base64(&out)
    }

    /// From the fragment of a URL, without `#`.
    ///
    /// # Errors
    ///
    /// What is wrong with it, and what to do.
    pub fn from_fragment(fragment: &str) -> Result<Self, Words> {
        if fragment.len() > FRAGMENT_MAX {
            return Err(text::LinkTooLong { most: FRAGMENT_MAX }.words());
        }
        let Some(packed) = fragment.strip_prefix(VERSION) else {
            return Err(text::LinkVersion.words());
        };
        let damaged = || text::LinkDamaged.words();
        let bytes = unbase64(packed).ok_or_else(damaged)?;
        let (bytes, crc) = bytes.split_last_chunk().ok_or_else(damaged)?;
        if link::crc16(bytes).to_le_bytes() != *crc {
            return Err(damaged());
        }
        Self::read(&mut Reader(bytes)).ok_or_else(|| text::LinkBounds.words())
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let seed = reader.number()?;
        let profile = core::str::from_utf8(reader.bytes(NAME_MAX)?).ok()?;
        let wind = [reader.byte()?.cast_signed(), reader.byte()?.cast_signed()];
        let setup = Setup::new(seed, profile, wind).ok()?;
        let steps = reader.number().filter(|steps| *steps <= STEPS_MAX)?;
        let count = reader.number().filter(|count| *count as usize <= ACTIONS_MAX)?;
        let mut session = Self { setup, ..Self::default() };
        let mut at = 0u32;
        for _ in 0..count {
            at = at.checked_add(reader.number()?).filter(|at| *at <= steps)?;
            let action = read_action(reader)?;
            if !session.has_room(&action) {
                return None;
            }
            session.push(at, action).ok()?;
        }
        session.steps = steps;
        reader.0.is_empty().then_some(session)
    }
}

const SEND: u8 = 0;
const WIRE: u8 = 1;
const BREAK: u8 = 2;
const REPAIR: u8 = 3;
const LIGHT: u8 = 4;
const SWEEP: u8 = 5;
const POWER: u8 = 6;

fn put_action(out: &mut Vec<u8>, action: &Action) {
    match action {
        Action::Send(link, bytes) => {
            out.extend([SEND, u8::from(*link == Link::Radio)]);
            put_bytes(out, bytes);
        }
        Action::Wire(link, bytes) => {
            out.extend([WIRE, u8::from(*link == Link::Radio)]);
            put_bytes(out, bytes);
        }
        Action::Break(fault) => {
            out.push(BREAK);
            put_bytes(out, fault.name().as_bytes());
        }
        Action::Repair(fault) => {
            out.push(REPAIR);
            put_bytes(out, fault.name().as_bytes());
        }
        Action::Light(azimuth, range, fuel) => {
            let [low, high] = azimuth.to_le_bytes();
            out.extend([LIGHT, low, high, *range, u8::from(*fuel)]);
        }
        Action::Sweep => out.push(SWEEP),
        Action::Power => out.push(POWER),
    }
}

fn read_action(reader: &mut Reader<'_>) -> Option<Action> {
    Some(match reader.byte()? {
        SEND => Action::Send(reader.link()?, reader.bytes(PAYLOAD_MAX)?.to_vec()),
        WIRE => Action::Wire(reader.link()?, reader.bytes(WIRE_MAX)?.to_vec()),
        BREAK => Action::Break(reader.fault()?),
        REPAIR => Action::Repair(reader.fault()?),
        LIGHT => {
            let azimuth = i16::from_le_bytes([reader.byte()?, reader.byte()?]);
            let range = reader.byte().filter(|it| RANGE.contains(it))?;
            let azimuth = Some(azimuth).filter(|it| (-180..=180).contains(it))?;
            Action::Light(azimuth, range, reader.flag()?)
        }
        SWEEP => Action::Sweep,
        POWER => Action::Power,
        _ => return None,
    })
}

fn put(out: &mut Vec<u8>, mut number: u32) {
    while number > 0x7F {
        out.push(number as u8 | MORE);
        number >>= 7;
    }
    out.push(number as u8);
}

fn put_bytes(out: &mut Vec<u8>, bytes: &[u8]) {
    put(out, bytes.len() as u32);
    out.extend(bytes);
}

struct Reader<'b>(&'b [u8]);

impl<'b> Reader<'b> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn number(&mut self) -> Option<u32> {
        let mut number = 0u64;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7F) << shift;
            if byte & MORE == 0 {
                return u32::try_from(number).ok();
            }
        }
        None
    }

    fn bytes(&mut self, most: usize) -> Option<&'b [u8]> {
        let len = self.number()? as usize;
        let (bytes, rest) = self.0.split_at_checked(len).filter(|_| len <= most)?;
        self.0 = rest;
        Some(bytes)
    }

    fn flag(&mut self) -> Option<bool> {
        self.byte().filter(|it| *it < 2).map(|it| it == 1)
    }

    fn link(&mut self) -> Option<Link> {
        Some(if self.flag()? { Link::Radio } else { Link::Wired })
    }

    fn fault(&mut self) -> Option<Fault> {
        Fault::from_name(core::str::from_utf8(self.bytes(NAME_MAX)?).ok()?)
    }
}

fn base64(bytes: &[u8]) -> String {
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0u32, |word, byte| word << 8 | u32::from(*byte));
        let word = word << (8 * (3 - chunk.len()));
        for place in 0..=chunk.len() {
            out.push(char::from(ALPHABET[(word >> (18 - 6 * place)) as usize & 0x3F]));
        }
    }
    out
}

/// `None` unless this is just what [`base64`] makes of some bytes.
fn unbase64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    for chunk in text.as_bytes().chunks(4) {
        let mut word = 0u32;
        for letter in chunk {
            word = word << 6 | ALPHABET.iter().position(|it| it == letter)? as u32;
        }
        let (bytes, unused) = match chunk.len() {
            4 => (3, 0),
            3 => (2, 2),
            2 => (1, 4),
            _ => return None,
        };
        if word & ((1 << unused) - 1) != 0 {
            return None;
        }
        word >>= unused;
        out.extend(word.to_be_bytes().get(4 - bytes..)?);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session() -> Session {
        let mut session =
            Session { setup: Setup::new(7, "ex", [3, -2]).unwrap(), ..Session::default() };
        let fault = Fault::from_name("vertical-max-switch").unwrap();
        for (step, action) in [
            (0, Action::Send(Link::Wired, vec![1, 2, 3, 0])),
            (200, Action::Wire(Link::Radio, vec![0xC0; 20])),
            (200, Action::Break(fault)),
            (201, Action::Light(-30, 25, true)),
            (70_000, Action::Repair(fault)),
            (70_000, Action::Sweep),
            (70_001, Action::Power),
        ] {
            session.push(step, action).unwrap();
        }
        session.steps = 80_000;
        session
    }

    #[test]
    fn a_fragment_leads_back() {
        let fragment = session().fragment();
        assert_eq!(Session::from_fragment(&fragment), Ok(session()));
        assert!(fragment.len() < 160, "{} characters", fragment.len());
        let letters = |it: char| it.is_ascii_alphanumeric() || "-_.".contains(it);
        assert!(fragment.chars().all(letters), "{fragment}");
    }

    /// A letter that is changed, left out or added is noticed, wherever it is.
    #[test]
    fn damage_is_noticed() {
        let whole = session().fragment();
        for at in 0..whole.len() {
            let without = whole[..at].to_owned() + &whole[at + 1..];
            assert!(Session::from_fragment(&without).is_err(), "without letter {at}");
            let letter = if whole.as_bytes()[at] == b'A' { "B" } else { "A" };
            let changed = whole[..at].to_owned() + letter + &whole[at + 1..];
            assert!(Session::from_fragment(&changed).is_err(), "letter {at} changed");
        }
        assert!(Session::from_fragment(&(whole + "A")).is_err());
    }

    #[test]
    fn what_is_too_long_is_refused() {
        let long = "1.".to_owned() + &"A".repeat(FRAGMENT_MAX);
        let error = Session::from_fragment(&long).unwrap_err();
        assert!(error.en.contains("8000"), "{}", error.en);
        assert_eq!(Session::from_fragment("2.AAAA").unwrap_err(), text::LinkVersion.words());
        let mut full = Session::default();
        let big = Action::Wire(Link::Wired, vec![0x55; 1000]);
        let mut added = 0;
        while full.has_room(&big) {
            full.push(0, big.clone()).unwrap();
            added += 1;
        }
        assert_eq!(added, 5);
        assert!(full.fragment().len() <= FRAGMENT_MAX);
        let mut many = Session::default();
        while many.has_room(&Action::Sweep) {
            many.push(0, Action::Sweep).unwrap();
        }
        assert_eq!(many.actions.len(), ACTIONS_MAX);
        let mut burning = Session::default();
        while burning.has_room(&Action::Light(0, 20, false)) {
            burning.push(0, Action::Light(0, 20, false)).unwrap();
        }
        assert_eq!(burning.actions.len(), FIRES_MAX);
    }

    #[test]
    fn time_does_not_go_back() {
        let mut session = session();
        assert_eq!(session.push(69_999, Action::Sweep), Err(StepsError));
        assert_eq!(session.push(STEPS_MAX + 1, Action::Sweep), Err(StepsError));
    }
}
