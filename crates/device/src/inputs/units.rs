//! §3.3.1/3 A remote unit whose exchanges all break the protocol of the internal bus answers, and nothing is heard of
//! it: what is sensed of it is old, and what is commanded may not reach it.

use crate::image::{UNITS, UnitInput};

/// For so long exchanges may be broken, ms: as long as a unit may be silent.
const BROKEN_MS: u8 = 100;
/// A longer step counts as so much, ms: one broken exchange is no loss.
const STEP_MS: u32 = 50;
/// What is sensed of a unit may be so old, ms: as old as one may be silent or not understood, an exchange and a step.
const OLD_MS: u8 = 200;

/// For how long nothing has been understood of each unit, ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heard([u8; UNITS]);

impl Heard {
    /// Nothing yet.
    pub const NOTHING: Self = Self([u8::MAX; UNITS]);

    /// Judges which units are online: one that is not understood, or was lost and has not been understood since, is not.
    #[inline(never)]
    pub fn step(&mut self, dt_ms: u32, units: &mut [UnitInput; UNITS]) {
        let dt_ms = dt_ms.min(STEP_MS) as u8;
        for (ms, unit) in self.0.iter_mut().zip(units) {
            *ms = match (unit.online, unit.protocol_fault) {
                (true, false) => 0,
                (true, true) => ms.saturating_add(dt_ms),
                (false, _) => u8::MAX,
            };
            unit.online = *ms < BROKEN_MS;
        }
    }
}

/// For how long what is sensed of a remote unit may still be from before its drive or valve was driven, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Stale(u8);

impl Stale {
    /// It is driven now.
    pub const DRIVEN: Self = Self(OLD_MS);

    /// A step at whose end it is not driven.
    pub fn step(&mut self, dt_ms: u32) {
        self.0 = self.0.saturating_sub(dt_ms.min(STEP_MS) as u8);
    }

    /// What is sensed may not say where the motion has led.
    pub const fn may_be(self) -> bool {
        self.0 > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a unit counts as online after a step in which its bus says this.
    fn is_online(heard: &mut Heard, dt_ms: u32, online: bool, protocol_fault: bool) -> bool {
        let mut units = [UnitInput::default(); UNITS];
        (units[3].online, units[3].protocol_fault) = (online, protocol_fault);
        heard.step(dt_ms, &mut units);
        assert!(units.iter().enumerate().all(|(unit, input)| unit == 3 || !input.online));
        assert_eq!(units[3].protocol_fault, protocol_fault, "it is reported all the same");
        units[3].online
    }

    fn understood() -> Heard {
        let mut heard = Heard::NOTHING;
        assert!(is_online(&mut heard, 10, true, false));
        heard
    }

    /// Lost after 100 ms, whatever the step, and back with the first good exchange.
    #[test]
    fn broken_for_long() {
        for dt_ms in [1, 5, 10, 20, 50] {
            let mut heard = understood();
            for ms in (dt_ms..1000).step_by(dt_ms as usize) {
                assert_eq!(is_online(&mut heard, dt_ms, true, true), ms < 100, "{dt_ms}: {ms}");
            }
            assert!(is_online(&mut heard, dt_ms, true, false));
            assert!(is_online(&mut heard, dt_ms, true, true));
        }
    }

    /// Broken exchanges between good ones change nothing, nor does one in a long step.
    #[test]
    fn broken_for_a_moment() {
        let mut heard = understood();
        for _ in 0..100 {
            assert!((0..9).all(|_| is_online(&mut heard, 10, true, true)));
            assert!(is_online(&mut heard, 10, true, false));
            assert!(is_online(&mut heard, 5000, true, true));
            assert!(is_online(&mut heard, 10, true, false));
        }
    }

    /// A unit that is silent is lost at once, for its bus has waited; an answer that is not understood does not bring it
    /// back, nor does the first one of all.
    #[test]
    fn nothing_good_yet() {
        let mut silent = understood();
        assert!(!is_online(&mut silent, 10, false, false));
        for mut heard in [silent, Heard::NOTHING] {
            assert!((0..50).all(|_| !is_online(&mut heard, 10, true, true)));
            assert!(is_online(&mut heard, 10, true, false));
        }
    }
}
