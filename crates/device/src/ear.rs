//! §L/8 Which frames on a line are requests to this monitor (ours).
//!
//! The answer to a presence probe is itself an empty frame, and the answer to Stop is a Stop: to the
//! monitor it reaches they are requests. On one line with several monitors that happens when a device
//! asks one of them in the name of another. Each answer would be answered, for ever.

use lafet_proto::bus::{CONTROLLER, MONITORS, ProbeLimit};
use lafet_proto::link::Frame;

/// An answer comes within this time, ms.
const ANSWER_MS: u32 = 1000;

/// What a monitor hears on its line.
#[derive(Clone, Debug)]
pub(crate) struct Ear {
    /// How often others have asked each monitor in this one's name without its answer, 0…3: four
    /// addresses in a byte.
    asked: [u8; 32],
    /// When the last of them was asked.
    asked_ms: u32,
    /// Whom this monitor has answered, until the next frame; 0: none.
    answered: u8,
    /// The transceiver hears what it sends.
    hears_itself: bool,
    probes: Probes,
}

/// How many probes are answered: at addresses of monitors, and at those of consoles.
#[derive(Clone, Debug)]
pub struct Probes([ProbeLimit; 2]);

impl Ear {
    pub const fn new() -> Self {
        Self {
            asked: [0; 32],
            asked_ms: 0,
            answered: 0,
            hears_itself: false,
            probes: Probes::new(),
        }
    }

    /// Whether a frame on the line is to be answered by the monitor at the address `own`: §L/5, §L/6,
    /// §1/10 every frame to it is, once, but for §L/8.
    pub fn admits(&mut self, now_ms: u32, own: u8, frame: &Frame<'_>) -> bool {
        let Frame { dst, src, .. } = *frame;
        let answered = core::mem::take(&mut self.answered);
        if answered >= CONTROLLER {
            // No other device answers a console in this name, so the next frame shows it.
            self.hears_itself = (src, dst) == (own, answered);
        }
        if src == own {
            let echo = self.hears_itself && dst == answered;
            if !echo && MONITORS.contains(&dst) {
                self.note_asked(now_ms, dst);
            }
            return false;
        }
        if dst != own || self.is_answer(now_ms, src) || !self.probes.admit(now_ms, frame) {
            return false;
        }
        self.answered = src;
        true
    }

    fn note_asked(&mut self, now_ms: u32, address: u8) {
        if now_ms.wrapping_sub(self.asked_ms) >= ANSWER_MS {
            self.asked = [0; 32];
        }
        self.asked_ms = now_ms;
        if let Some((byte, one)) = self.asked_at(address)
            && *byte & (3 * one) != 3 * one
        {
            *byte += one;
        }
    }

    /// Where an address is counted, and what one counts there.
    fn asked_at(&mut self, address: u8) -> Option<(&mut u8, u8)> {
        Some((self.asked.get_mut(usize::from(address / 4))?, 1 << (2 * (address % 4))))
    }

    /// Whether a frame from this address answers one that was sent in this monitor's name: one frame
    /// for each.
    fn is_answer(&mut self, now_ms: u32, address: u8) -> bool {
        let recent = now_ms.wrapping_sub(self.asked_ms) < ANSWER_MS;
        let asked = self.asked_at(address).filter(|(byte, one)| recent && **byte & (3 * one) != 0);
        asked.map(|(byte, one)| *byte -= one).is_some()
    }
}

impl Probes {
    /// All of them are answered for now.
    pub const fn new() -> Self {
        Self([ProbeLimit::new(), ProbeLimit::new()])
    }

    /// Whether a frame is answered as far as this limit goes. The controller's probes are: a
    /// controller that answered answers would not end with any device of its bus.
    pub(crate) fn admit(&mut self, now_ms: u32, frame: &Frame<'_>) -> bool {
        if !frame.payload.is_empty() || frame.src == CONTROLLER {
            return true;
        }
        let [monitors, consoles] = &mut self.0;
        if MONITORS.contains(&frame.src) { monitors } else { consoles }.allows(now_ms)
    }
}

impl Default for Probes {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: u8 = 1;

    fn hears(ear: &mut Ear, now_ms: u32, dst: u8, src: u8) -> bool {
        ear.admits(now_ms, OWN, &Frame { dst, src, payload: &[] })
    }

    /// §L/8 Another device asks 2 and 3 in the name of 1: what they answer is no request.
    #[test]
    fn an_answer_to_another_in_this_name_is_no_request() {
        let mut ear = Ear::new();
        for now_ms in [0, u32::MAX - 3] {
            assert!(!hears(&mut ear, now_ms, 2, OWN) && !hears(&mut ear, now_ms, 3, OWN));
            let later = now_ms.wrapping_add(900);
            assert!(!hears(&mut ear, later, OWN, 3) && !hears(&mut ear, later, OWN, 2));
            // Each answers as often as it was asked; what comes next from that address is a probe.
            assert!(hears(&mut ear, later, OWN, 2) && hears(&mut ear, later, OWN, 3));
        }
        for _ in 0..5 {
            assert!(!hears(&mut ear, 0, 7, OWN));
        }
        let answers = (0..5).filter(|_| !hears(&mut ear, 0, OWN, 7)).count();
        assert_eq!(answers, 3, "a prober tries three times");
        // Not for ever: 4 was not there, or its answer was lost.
        assert!(!hears(&mut ear, 0, 4, OWN));
        assert!(hears(&mut ear, 1000, OWN, 4));
        assert!(hears(&mut ear, 1000, OWN, 129), "and a console is not concerned");
    }

    /// What it hears of itself is no request in its name.
    #[test]
    fn an_echo_is_not_somebody_else() {
        let mut ear = Ear::new();
        assert!(hears(&mut ear, 0, OWN, 129));
        assert!(!hears(&mut ear, 0, 129, OWN), "its own answer");
        for _ in 0..3 {
            assert!(hears(&mut ear, 0, OWN, 2));
            assert!(!hears(&mut ear, 0, 2, OWN));
        }
        // Without an echo the same bytes are another device's.
        assert!(hears(&mut ear, 0, OWN, 129) && hears(&mut ear, 0, OWN, 129));
        assert!(hears(&mut ear, 0, OWN, 2));
        assert!(!hears(&mut ear, 0, 2, OWN));
        assert!(!hears(&mut ear, 0, OWN, 2));
    }

    /// §L/8 Neither monitors' nor consoles' addresses are answered without end; the controller is.
    #[test]
    fn probes_are_limited_by_kind_of_address() {
        let mut ear = Ear::new();
        let mut count = |address| (0..600).filter(|_| hears(&mut ear, 5, OWN, address)).count();
        assert_eq!([2, 3, 129, 130, 128].map(&mut count), [255, 0, 255, 0, 600]);
        let frame = Frame { dst: OWN, src: 2, payload: &[0x46, 0x5D, 0, 0] };
        assert!(ear.admits(5, OWN, &frame), "a request is no probe");
        assert!(hears(&mut ear, 5 + 512, OWN, 2) && !hears(&mut ear, 5 + 513, OWN, 2));
    }
}
