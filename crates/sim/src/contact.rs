//! Contacts that do not close cleanly: they bounce when they change, and blip in between.
//!
//! A contact with such a fault changes to and fro for 30 ms after each change, and shows the opposite of
//! what is the case for 10, 20 or 30 ms several times a second, at moments of its own. A remote unit
//! judges its contacts itself, and lets through a blip that only one poll sees. Figures ours.

use lafet_device::image::{AXES, Axis, Inputs, UNITS, VALVES, ValveNo};
use lafet_proto::flags::Button;

use crate::fault::{ButtonFault, DriveFault, Fault, Faults, Post, ValveFault};
use crate::world::STEP_MS;

/// A contact bounces for so long after it has changed, ms.
const BOUNCE_MS: u64 = 30;
/// The first contact blips this often; each further one a little less, so that they do not keep step.
const PERIOD_MS: u64 = 230;
const PERIOD_MORE_MS: u64 = 30;

/// How a part has been sensed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freshness {
    /// Not in this step: it is as it was.
    Old,
    /// A remote unit, which is asked every 20 ms: a blip is never seen twice.
    Polled,
    /// In this step, as in each.
    Sensed,
}

/// What the faulty contacts were, and when they changed.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    changed: Vec<(Fault, bool, u64)>,
}

impl Contacts {
    /// Shakes the contacts of what has just been sensed, by [`Unit`], that have such a fault.
    pub fn shake(
        &mut self,
        now_ms: u64,
        fresh: [Freshness; UNITS],
        inputs: &mut Inputs,
        faults: &Faults,
    ) {
        self.changed.retain(|(fault, ..)| faults.has(*fault));
        for (place, fault) in (0..).zip(all()) {
            let part = match fault {
                Fault::Valve(valve, _) => valve.unit(),
                Fault::Drive(axis, _) => axis.unit(),
                _ => continue,
            };
            let longest = match fresh[part as usize] {
                Freshness::Old => continue,
                Freshness::Polled => 2,
                Freshness::Sensed => 3,
            };
            if faults.has(fault) {
                let contact = contact(fault, inputs);
                let bounces = self.bounces(now_ms, fault, *contact);
                *contact ^= bounces || blips(now_ms, place, longest);
            }
        }
    }

    /// Whether a button is pressed, as its contact shows it.
    pub fn shake_button(
        &mut self,
        now_ms: u64,
        (post, button): (Post, Button),
        pressed: bool,
        faults: &Faults,
    ) -> bool {
        let fault = Fault::Button(post, button, ButtonFault::Bounce);
        if !faults.has(fault) {
            return pressed;
        }
        let place = 2 * AXES + 3 * VALVES + Button::ALL.len() * post as usize + button as usize;
        pressed ^ (self.bounces(now_ms, fault, pressed) || blips(now_ms, place as u64, 3))
    }

    /// Whether it is the other way round in a bounce.
    fn bounces(&mut self, now_ms: u64, fault: Fault, is: bool) -> bool {
        let Some((_, was, at_ms)) = self.changed.iter_mut().find(|(known, ..)| *known == fault)
        else {
            self.changed.push((fault, is, now_ms.saturating_sub(BOUNCE_MS)));
            return false;
        };
        if *was != is {
            (*was, *at_ms) = (is, now_ms);
        }
        let ms = now_ms.saturating_sub(*at_ms);
        ms < BOUNCE_MS && (ms / STEP_MS) % 2 == 1
    }
}

/// Whether any contact is shaken: what is sensed changes by itself then.
pub fn any(faults: &Faults) -> bool {
    let button = |fault: &Fault| matches!(fault, Fault::Button(.., ButtonFault::Bounce));
    faults.active().iter().any(button) || all().any(|fault| faults.has(fault))
}

fn blips(now_ms: u64, place: u64, longest: u64) -> bool {
    let period_ms = PERIOD_MS + PERIOD_MORE_MS * place;
    let (turn, ms) = (now_ms / period_ms, now_ms % period_ms);
    ms < STEP_MS * (1 + turn % longest)
}

/// Such faults, in the order of the process image.
fn all() -> impl Iterator<Item = Fault> {
    let drives = Axis::ALL.into_iter().flat_map(|axis| {
        [DriveFault::MinBounce, DriveFault::MaxBounce].map(|fault| Fault::Drive(axis, fault))
    });
    let valves = ValveNo::ALL.into_iter().flat_map(|valve| {
        [ValveFault::OpenBounce, ValveFault::CloseBounce, ValveFault::BlockedBounce]
            .map(|fault| Fault::Valve(valve, fault))
    });
    drives.chain(valves)
}

fn contact(fault: Fault, inputs: &mut Inputs) -> &mut bool {
    match fault {
        Fault::Drive(axis, DriveFault::MinBounce) => &mut inputs.drives[axis as usize].min_switch,
        Fault::Drive(axis, _) => &mut inputs.drives[axis as usize].max_switch,
        Fault::Valve(valve, ValveFault::OpenBounce) => {
            &mut inputs.valves[valve as usize].open_switch
        }
        Fault::Valve(valve, ValveFault::CloseBounce) => {
            &mut inputs.valves[valve as usize].close_switch
        }
        Fault::Valve(valve, _) => &mut inputs.valves[valve as usize].blocked,
        _ => unreachable!("{fault:?} is no fault of a contact"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSED: [Freshness; UNITS] = [Freshness::Sensed; UNITS];

    /// It blips for 10 to 30 ms, often, and is what it is in between; others stay as they are.
    #[test]
    fn a_shaken_contact() {
        for fault in all() {
            let mut faults = Faults::default();
            faults.inject(fault);
            assert!(any(&faults));
            let mut contacts = Contacts::default();
            let (mut wrong_ms, mut longest_ms, mut blips) = (0, 0, 0);
            for now_ms in (0..10_000).step_by(10) {
                let mut inputs = Inputs::default();
                contacts.shake(now_ms, SENSED, &mut inputs, &faults);
                if *contact(fault, &mut inputs) {
                    blips += u32::from(wrong_ms == 0);
                    wrong_ms += 10;
                    longest_ms = longest_ms.max(wrong_ms);
                    *contact(fault, &mut inputs) = false;
                } else {
                    wrong_ms = 0;
                }
                assert_eq!(inputs, Inputs::default());
            }
            assert!(longest_ms == 30 && blips > 10, "{}: {blips}", fault.name());
        }
        assert!(!any(&Faults::default()));
    }

    /// So does a button, pressed or not; and no other.
    #[test]
    fn a_shaken_button() {
        for (post, button) in
            Post::ALL.iter().flat_map(|post| Button::ALL.map(|button| (*post, button)))
        {
            let mut faults = Faults::default();
            faults.inject(Fault::Button(post, button, ButtonFault::Bounce));
            assert!(any(&faults));
            for pressed in [false, true] {
                let mut contacts = Contacts::default();
                let (mut wrong_ms, mut longest_ms, mut blips) = (0, 0, 0);
                for now_ms in (0..10_000).step_by(10) {
                    let shown = contacts.shake_button(now_ms, (post, button), pressed, &faults);
                    blips += u32::from(shown != pressed && wrong_ms == 0);
                    wrong_ms = if shown == pressed { 0 } else { wrong_ms + 10 };
                    longest_ms = longest_ms.max(wrong_ms);
                }
                assert!(longest_ms == 30 && blips > 5, "{button:?}: {longest_ms} {blips}");
                let other = if button == Button::Left { Button::Right } else { Button::Left };
                assert!(contacts.shake_button(0, (post, other), true, &faults));
            }
        }
    }

    /// When it changes it goes back once more.
    #[test]
    fn a_bouncing_contact() {
        let fault = Fault::Drive(Axis::Vertical, DriveFault::MaxBounce);
        let mut faults = Faults::default();
        faults.inject(fault);
        let mut contacts = Contacts::default();
        // Between two blips.
        let seen: Vec<bool> = (600..700)
            .step_by(10)
            .map(|now_ms| {
                let mut inputs = Inputs::default();
                *contact(fault, &mut inputs) = now_ms >= 640;
                contacts.shake(now_ms, SENSED, &mut inputs, &faults);
                *contact(fault, &mut inputs)
            })
            .collect();
        let expected = [0, 0, 0, 0, 1, 0, 1, 1, 1, 1].map(|on| on == 1);
        assert_eq!(seen, expected);
    }
}
