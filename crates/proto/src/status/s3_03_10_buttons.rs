//! §3.3.10 «Флаги состояния Buttons, ExtButtons».

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of Buttons or ExtButtons (§3.3, §3.3.10), 4 bytes.
    ButtonsStatus [flags: ButtonsFlags] {}
}

flag_class! {
    /// §3.3.10 Buttons, ExtButtons: a [`ButtonState`] of two bits for each button.
    ButtonsFlags "3.3.10", ConnLost Alarm Common, width 2;
    LEFT_BUTTON_STATE = 16 "LeftButtonState" Warning Buttons;
    RIGHT_BUTTON_STATE = 18 "RightButtonState" Warning Buttons;
    UP_BUTTON_STATE = 20 "UpButtonState" Warning Buttons;
    DOWN_BUTTON_STATE = 22 "DownButtonState" Warning Buttons;
    WIDE_BUTTON_STATE = 24 "WideButtonState" Warning Buttons;
    NARROW_BUTTON_STATE = 26 "NarrowButtonState" Warning Buttons;
    OPEN_BUTTON_STATE = 28 "OpenButtonState" Warning Buttons;
    CLOSE_BUTTON_STATE = 30 "CloseButtonState" Warning Buttons;
}

/// State of a button's circuit (§3.3.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum ButtonState {
    /// Not pressed.
    #[default]
    Released,
    /// Pressed.
    Pressed,
    /// Short circuit.
    Short,
    /// Open circuit.
    Open,
}

impl ButtonState {
    /// The state that the two lowest bits encode.
    pub const fn of(bits: u32) -> Self {
        match bits & 0b11 {
            0 => Self::Released,
            1 => Self::Pressed,
            2 => Self::Short,
            _ => Self::Open,
        }
    }
}

/// A button of a post, in the order of the bits (§3.3.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Button {
    /// Turn left.
    Left,
    /// Turn right.
    Right,
    /// Raise.
    Up,
    /// Lower.
    Down,
    /// Wider spray.
    Wide,
    /// Narrower jet.
    Narrow,
    /// Open the valve.
    Open,
    /// Close the valve.
    Close,
}

impl Button {
    /// Every button in the order of the bits.
    pub const ALL: [Self; 8] = [
        Self::Left,
        Self::Right,
        Self::Up,
        Self::Down,
        Self::Wide,
        Self::Narrow,
        Self::Open,
        Self::Close,
    ];

    /// Number of the button's lower bit.
    pub const fn shift(self) -> u32 {
        16 + 2 * self as u32
    }
}

impl ButtonsFlags {
    /// The state of a button.
    pub const fn button(self, button: Button) -> ButtonState {
        ButtonState::of(self.bits() >> button.shift())
    }

    /// The same word with another state of a button.
    pub const fn with_button(self, button: Button, state: ButtonState) -> Self {
        let others = self.bits() & !(0b11 << button.shift());
        Self::from_bits_retain(others | (state as u32) << button.shift())
    }
}
