//! §3.3.10 «Флаги состояния Buttons, ExtButtons»: a post of eight buttons.
//!
//! A held direction button moves its drive until it is released; a held button takes precedence
//! over Move for the same drive (ours). A button that was held at power-up, while the posts were
//! locked, or when its drive was stopped by a request, acts only after it has been released; so does Open
//! that has acted. A press begins something when it has lasted, and a release counts as one for the next press
//! when it has: a contact that is shaken blips, and a line that breaks passes through "pressed". What ends something
//! waits for nothing: a release, the opposite button, Close.

use crate::image::Axis;
use crate::inputs::{STABLE_MS, outlasts};
use lafet_proto::SubsystemId;
use lafet_proto::flags::{Button, ButtonState, ButtonsFlags};
use lafet_proto::status::ButtonsStatus;

/// Since a release that has lasted a button may act; above, for how long it has been pressed since, and 1; ms.
const ARMED: u8 = 1 << 7;
/// Pressed for so long that it acts.
const ACTS: u8 = u8::MAX;
const _: () = assert!(STABLE_MS < ARMED as u32 && STABLE_MS + (ARMED as u32) < ACTS as u32);

/// A button post.
#[derive(Clone, Debug, PartialEq)]
pub struct ButtonPost {
    states: [ButtonState; 8],
    /// Below [`ARMED`] for how long each has been released, and 1; ms.
    phases: [u8; 8],
}

/// What a post asks of the monitor in this step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Demand {
    /// Vertical, Horizontal, Nozzle: how far up/left/narrower and down/right/wider have been pressed.
    pub held: [(u8, u8); 3],
    /// Pressed in this step.
    pub open: bool,
    /// Pressed in this step.
    pub close: bool,
}

impl Default for ButtonPost {
    fn default() -> Self {
        Self { states: [ButtonState::Released; 8], phases: [0; 8] }
    }
}

impl ButtonPost {
    /// The states at the start: they are shown, and none acts.
    pub(crate) const fn power_up(&mut self, states: &[ButtonState; 8]) {
        self.states = *states;
    }

    /// Takes the states. A locked post asks for nothing (§3.18/7), and while the monitor waits for its reset only
    /// Close does: with ResetValves the water runs on behind it.
    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        dt_ms: u32,
        states: &[ButtonState; 8],
        locked: bool,
        restarting: bool,
    ) -> Demand {
        let [.., close_before] = self.phases;
        self.states = *states;
        for (number, (phase, state)) in self.phases.iter_mut().zip(states).enumerate() {
            // Closing is the safe direction: it waits for nothing.
            let closes = number == Button::Close as usize;
            *phase = match *state {
                _ if restarting && !closes => 0,
                ButtonState::Pressed if locked => 0,
                state => next(*phase, state, dt_ms, closes),
            };
        }
        let [left, right, up, down, wide, narrow, opens, close] = &mut self.phases;
        let (open, closes) = (*opens == ACTS, *close == ACTS);
        if open {
            // It acts once, also where it is refused: what it stays held for must not become water later.
            *opens = 0;
        }
        Demand {
            held: [(*up, *down), (*left, *right), (*narrow, *wide)],
            open: open && !closes,
            close: closes && close_before != ACTS,
        }
    }

    /// §3.2/1, §3.2/5 A stop holds although a button of this drive is held.
    pub(crate) fn disarm(&mut self, axis: Axis) {
        let [left, right, up, down, wide, narrow, ..] = &mut self.phases;
        let (one, other) = match axis {
            Axis::Vertical => (up, down),
            Axis::Horizontal => (left, right),
            Axis::Nozzle => (wide, narrow),
            Axis::Deployer => return,
        };
        (*one, *other) = (0, 0);
    }

    /// A button of this drive is held: requests for it are answered Denied by the post.
    pub(crate) fn holds(&self, axis: Axis) -> bool {
        let [left, right, up, down, wide, narrow, ..] = self.phases;
        let (one, other) = match axis {
            Axis::Vertical => (up, down),
            Axis::Horizontal => (left, right),
            Axis::Nozzle => (wide, narrow),
            Axis::Deployer => return false,
        };
        one.max(other) == ACTS
    }

    /// §3.3 status of the post, but for the common flags of the configuration.
    pub(crate) fn status(&self) -> ButtonsStatus {
        const BUTTONS: [Button; 8] = [
            Button::Left,
            Button::Right,
            Button::Up,
            Button::Down,
            Button::Wide,
            Button::Narrow,
            Button::Open,
            Button::Close,
        ];
        let mut flags = ButtonsFlags::empty();
        for (button, state) in BUTTONS.iter().zip(&self.states) {
            flags = flags.with_button(*button, *state);
        }
        ButtonsStatus { flags }
    }
}

/// A step of a button. A press or a release that begins something has to last for longer than a contact may blip
/// (§D/6), unless it acts `at_once`; short circuit and break are neither.
const fn next(before: u8, state: ButtonState, dt_ms: u32, at_once: bool) -> u8 {
    let (now, then) = match state {
        ButtonState::Released if before >= ARMED => return ARMED,
        ButtonState::Released => (0, ARMED),
        ButtonState::Pressed if before == ACTS => return ACTS,
        ButtonState::Pressed if before >= ARMED => (ARMED, ACTS),
        _ => return 0,
    };
    let mut ms = before & !ARMED;
    if at_once || outlasts(&mut ms, dt_ms) { then } else { now | ms }
}

/// The two directions of a drive: how far the button of each has been pressed, and at which post.
#[derive(Clone, Copy)]
pub(crate) struct Held {
    /// Up/left/narrower.
    up: (u8, SubsystemId),
    down: (u8, SubsystemId),
}

impl Held {
    /// No button is touched.
    pub(crate) const NONE: Self =
        Self { up: (0, SubsystemId::BUTTONS), down: (0, SubsystemId::BUTTONS) };

    /// What another post asks for. The posts have the same rights.
    pub(crate) fn join(&mut self, post: SubsystemId, (up, down): (u8, u8)) {
        for (held, phase) in [(&mut self.up, up), (&mut self.down, down)] {
            if phase > held.0 {
                *held = (phase, post);
            }
        }
    }

    /// Up/left/narrower (true) or the other way, and by which post. Opposite buttons at a time ask for nothing,
    /// from the first sample on that shows both.
    pub(crate) const fn direction(self) -> Option<(bool, SubsystemId)> {
        match (self.up, self.down) {
            ((ACTS, post), (..=ARMED, _)) => Some((true, post)),
            ((..=ARMED, _), (ACTS, post)) => Some((false, post)),
            _ => None,
        }
    }

    /// A button that may act is pressed, for however short a time.
    pub(crate) const fn is_pressed(self) -> bool {
        self.up.0 > ARMED || self.down.0 > ARMED
    }
}
