//! §3.3.10 «Флаги состояния Buttons, ExtButtons»: a post of eight buttons.
//!
//! A held direction button moves its drive until it is released; a held button takes precedence
//! over Move for the same drive (ours). A button that was held at power-up, while the posts were
//! locked, or when its drive was stopped by a request, acts only after it has been released; so does Open
//! that has acted. A release counts for that when it has lasted: a contact that is shaken blips.

use crate::image::Axis;
use crate::inputs::outlasts;
use lafet_proto::SubsystemId;
use lafet_proto::flags::{Button, ButtonState, ButtonsFlags};
use lafet_proto::status::ButtonsStatus;

/// A button that may act.
const ARMED: u8 = u8::MAX;

/// A button post.
#[derive(Clone, Debug, PartialEq)]
pub struct ButtonPost {
    states: [ButtonState; 8],
    /// [`ARMED`] since a release that has lasted; before, for how long each has been released, and 1; ms.
    released_ms: [u8; 8],
}

/// What a post asks of the monitor in this step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Demand {
    /// Vertical, Horizontal, Nozzle: whether up/left/narrower and down/right/wider are held.
    pub held: [(bool, bool); 3],
    /// Pressed in this step.
    pub open: bool,
    /// Pressed in this step.
    pub close: bool,
}

impl Default for ButtonPost {
    fn default() -> Self {
        Self { states: [ButtonState::Released; 8], released_ms: [0; 8] }
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
        let [.., close_before] = self.pressed();
        self.states = *states;
        for (number, (released_ms, state)) in self.released_ms.iter_mut().zip(states).enumerate() {
            // Closing is the safe direction: any release arms it.
            let closes = number == Button::Close as usize;
            *released_ms = match (*state, *released_ms) {
                _ if restarting && !closes => 0,
                (ButtonState::Released, before) => released(before, dt_ms, closes),
                (ButtonState::Pressed, ARMED) if !locked => ARMED,
                _ => 0,
            };
        }
        let [left, right, up, down, wide, narrow, open, close] = self.pressed();
        if open {
            // It acts once, also where it is refused: what it stays held for must not become water later.
            let [.., opens, _] = &mut self.released_ms;
            *opens = 0;
        }
        Demand {
            held: [(up, down), (left, right), (narrow, wide)],
            open: open && !close,
            close: close && !close_before,
        }
    }

    /// §3.2/1, §3.2/5 A stop holds although a button of this drive is held.
    pub(crate) fn disarm(&mut self, axis: Axis) {
        let [left, right, up, down, wide, narrow, ..] = &mut self.released_ms;
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
        let [left, right, up, down, wide, narrow, ..] = self.pressed();
        match axis {
            Axis::Vertical => up || down,
            Axis::Horizontal => left || right,
            Axis::Nozzle => wide || narrow,
            Axis::Deployer => false,
        }
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

    #[inline(never)]
    fn pressed(&self) -> [bool; 8] {
        let mut pressed = [false; 8];
        let states = self.states.iter().zip(&self.released_ms);
        for (pressed, (state, released_ms)) in pressed.iter_mut().zip(states) {
            *pressed = *state == ButtonState::Pressed && *released_ms == ARMED;
        }
        pressed
    }
}

/// A step in which a button is released; it counts when it has lasted (§D/6).
const fn released(before_ms: u8, dt_ms: u32, at_once: bool) -> u8 {
    let mut ms = before_ms;
    if at_once || before_ms == ARMED || outlasts(&mut ms, dt_ms) { ARMED } else { ms }
}

/// By which post up/left/narrower and down/right/wider are held.
pub(crate) type Held = (Option<SubsystemId>, Option<SubsystemId>);

/// Up/left/narrower (true) or the other way, and by which post; opposite buttons at a time ask for
/// nothing.
pub(crate) const fn direction(held: Held) -> Option<(bool, SubsystemId)> {
    match held {
        (Some(post), None) => Some((true, post)),
        (None, Some(post)) => Some((false, post)),
        _ => None,
    }
}
