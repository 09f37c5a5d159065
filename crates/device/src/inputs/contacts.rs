//! Contacts bounce when they change, and blip when they are shaken or their wires are: for up to 30 ms, at
//! power-up too. So at the start every one is off until it has lasted: what is not known to be closed is not.

use super::outlasts;
use crate::image::{AXES, Inputs, VALVES};

/// A contact is believed when it has been in its new state for this long, ms.
pub(crate) const STABLE_MS: u32 = 30;
/// Two end switches of each drive; open, closed and blocked of each valve.
const COUNT: usize = 2 * AXES + 3 * VALVES;
/// End switches of the drives that aim. The two of Deployer come after them, then the valves' contacts.
const ENDS: u16 = 0b11_1111;
/// The upper one of Deployer.
const DEPLOYED: u16 = 1 << (2 * AXES - 1);
/// Those that do not count any more as soon as they open: a valve that is not reported as closed is open,
/// and a drive that has left its end may come back. Of Deployer both states have to last, and of
/// `blocked`: a blip of either must not end an extinguishing.
const OFF_AT_ONCE: u16 = ENDS | 0b01_1011 << (2 * AXES);

/// The valves' "open", and their "closed".
const OPEN: u16 = 0b00_1001 << (2 * AXES);
const CLOSED: u16 = OPEN << 1;

/// The contacts of the process image, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Contacts(u16);

/// What is believed of the contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Debounce {
    judged: Contacts,
    /// For how long each has been sensed otherwise than it is judged, and 1; ms.
    differs_ms: [u8; COUNT],
}

impl Contacts {
    /// As they are in the image.
    #[inline(never)]
    pub fn of(inputs: &mut Inputs) -> Self {
        let mut bits = 0_u16;
        each(inputs, |contact| bits = bits >> 1 | u16::from(*contact) << 15);
        Self(bits >> (16 - COUNT))
    }

    /// Puts them into the image.
    #[inline(never)]
    pub fn put(self, inputs: &mut Inputs) {
        let mut bits = self.0;
        each(inputs, |contact| {
            *contact = bits & 1 != 0;
            bits >>= 1;
        });
    }

    /// Whether all of these valves say closed, if there are any, and whether one says open.
    pub fn of_valves(self, present: [bool; VALVES]) -> (bool, bool) {
        let mask = |all: u16| {
            let mut bit = all & all.wrapping_neg();
            present.iter().fold(0, |mask, is| {
                let of_valve = if *is { bit } else { 0 };
                bit <<= 3;
                mask | of_valve
            })
        };
        let (open, closed) = (mask(OPEN), mask(CLOSED));
        (closed != 0 && self.0 & closed == closed, self.0 & open != 0)
    }

    /// These, with no valve reported as closed.
    pub const fn without_closed(self) -> Self {
        Self(self.0 & !CLOSED)
    }

    /// These, with Deployer not reported as deployed.
    pub const fn without_deployed(self) -> Self {
        Self(self.0 & !DEPLOYED)
    }

    /// These, and the end switches that are sensed as closed.
    pub const fn with_ends_of(self, sensed: Self) -> Self {
        Self(self.0 | sensed.0 & ENDS)
    }
}

impl Debounce {
    /// What is to be believed after a step in which this is sensed. A step that is longer than any
    /// bounce shows none: what is new counts at once.
    #[inline(never)]
    pub fn step(&mut self, dt_ms: u32, sensed: Contacts) -> Contacts {
        let Contacts(sensed) = sensed;
        let mut bit = 1;
        for differs_ms in &mut self.differs_ms {
            let is_new = (self.judged.0 ^ sensed) & bit != 0;
            let at_once = sensed & bit == 0 && OFF_AT_ONCE & bit != 0;
            let counts = is_new && (outlasts(differs_ms, dt_ms) || at_once);
            if counts {
                self.judged.0 ^= bit;
            }
            if counts || !is_new {
                *differs_ms = 0;
            }
            bit <<= 1;
        }
        self.judged
    }
}

/// In the order of their bits.
fn each(inputs: &mut Inputs, mut visit: impl FnMut(&mut bool)) {
    for drive in &mut inputs.drives {
        visit(&mut drive.min_switch);
        visit(&mut drive.max_switch);
    }
    for valve in &mut inputs.valves {
        visit(&mut valve.open_switch);
        visit(&mut valve.close_switch);
        visit(&mut valve.blocked);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Axis;
    use std::vec::Vec;

    /// These have been judged.
    fn judged(bits: u16) -> Debounce {
        Debounce { judged: Contacts(bits), ..Debounce::default() }
    }

    /// Every contact, its bit and whether it goes off at once.
    fn all() -> Vec<(u16, bool)> {
        let mut inputs = Inputs::default();
        let mut all = Vec::new();
        for place in 0..COUNT {
            let mut at = 0;
            each(&mut inputs, |contact| {
                *contact = at == place;
                at += 1;
            });
            let deployer = &inputs.drives[Axis::Deployer as usize];
            let lasts = deployer.min_switch
                || deployer.max_switch
                || inputs.valves.iter().any(|valve| valve.blocked);
            let bit = Contacts::of(&mut inputs);
            let mut again = Inputs::default();
            bit.put(&mut again);
            assert_eq!(again, inputs);
            all.push((bit.0, !lasts));
        }
        assert_eq!(all.iter().fold(0, |sum, (bit, _)| sum | bit).count_ones(), COUNT as u32);
        all
    }

    /// A change counts after 30 ms, whatever the step, and not before; what goes off at once does.
    #[test]
    fn what_lasts_counts() {
        for (bit, off_at_once) in all() {
            for step_ms in [1, 5, 10, 30] {
                for on in [true, false] {
                    let (from, to) = if on { (0, bit) } else { (bit, 0) };
                    let mut contacts = judged(from);
                    let mut ms = 0;
                    while contacts.step(step_ms, Contacts(to)).0 != to {
                        ms += step_ms;
                        assert!(ms <= STABLE_MS, "{bit:b}");
                    }
                    let at_once = !on && off_at_once;
                    assert_eq!(ms, if at_once { 0 } else { STABLE_MS }, "{bit:b} {step_ms}");
                    assert_eq!(contacts, judged(to));
                }
            }
            let mut slow = judged(0);
            assert_eq!(slow.step(31, Contacts(bit)).0, bit);
        }
    }

    /// A blip of 1 to 30 ms is none, whenever in the step it comes; nor are many of them.
    #[test]
    fn blips() {
        for (bit, off_at_once) in all() {
            for step_ms in [1_u32, 3, 10] {
                for blip_ms in 1..=30 {
                    for at in [0, bit] {
                        let mut contacts = judged(at);
                        for ms in (0..1000).step_by(step_ms as usize) {
                            let sensed = if ms % 100 < blip_ms { at ^ bit } else { at };
                            let is = contacts.step(step_ms, Contacts(sensed)).0;
                            let off = off_at_once && at == bit;
                            assert!(is == at || off, "{bit:b} {blip_ms} {step_ms}");
                        }
                    }
                }
            }
        }
    }

    /// A contact that bounces for up to 30 ms counts once, and 30 ms after it has come to rest.
    #[test]
    fn bounce() {
        for (bit, _) in all() {
            for bounce_ms in 1..=30_u32 {
                let mut contacts = judged(0);
                let mut changes = Vec::new();
                let mut before = 0;
                for ms in 0..200 {
                    let open = ms < bounce_ms && ms % 2 == 1;
                    let now = contacts.step(1, Contacts(if open { 0 } else { bit })).0;
                    if now != before {
                        changes.push(ms);
                    }
                    before = now;
                }
                let [at] = changes.as_slice() else { panic!("{bit:b} {bounce_ms}: {changes:?}") };
                assert!((30..=61).contains(at), "{bit:b} {bounce_ms}: {at}");
            }
        }
    }

    /// One contact does not wait for another.
    #[test]
    fn each_by_itself() {
        let mut contacts = judged(0);
        for ms in 0..100 {
            let other = if ms % 20 < 10 { 2 } else { 0 };
            let is = contacts.step(1, Contacts(1 | other)).0;
            assert_eq!(is, u16::from(ms >= 30));
        }
    }
}
