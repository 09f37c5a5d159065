//! §3.3.10 «Флаги состояния Buttons, ExtButtons».

use super::s3_03_01_common_flags as common_flags;
use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of Buttons or ExtButtons (§3.3, §3.3.10), 4 bytes.
    ButtonsStatus [flags: ButtonsFlags] {}
}

flag_class! {
    /// §3.3.10 Buttons, ExtButtons: a [`ButtonState`] of two bits for each button.
    ButtonsFlags "3.3.10", ConnLost Alarm common_flags::CONN_LOST, width 2;
    LEFT_BUTTON_STATE = 16 "LeftButtonState" Warning LEFT;
    RIGHT_BUTTON_STATE = 18 "RightButtonState" Warning RIGHT;
    UP_BUTTON_STATE = 20 "UpButtonState" Warning UP;
    DOWN_BUTTON_STATE = 22 "DownButtonState" Warning DOWN;
    WIDE_BUTTON_STATE = 24 "WideButtonState" Warning WIDE;
    NARROW_BUTTON_STATE = 26 "NarrowButtonState" Warning NARROW;
    OPEN_BUTTON_STATE = 28 "OpenButtonState" Warning OPEN;
    CLOSE_BUTTON_STATE = 30 "CloseButtonState" Warning CLOSE;
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

const fn button(meaning: [&'static str; 2]) -> Words {
    words(
        meaning,
        [
            "Pressed: the button is held. Short: water or a pinched cable. Open: a broken \
            wire, a missing end resistor, no post connected.",
            "Нажата: кнопку удерживают. КЗ: вода или пережатый кабель. Обрыв: обрыв провода, нет \
            оконечного резистора, пост не подключён.",
        ],
        [
            "Pressed without a hand: free or replace the button. Short or open: measure the line \
            at the post's terminals, then at the monitor.",
            "Нажата без руки: освободите или замените кнопку. КЗ или обрыв: измерьте линию на \
            клеммах поста, затем у ствола.",
        ],
    )
}

const LEFT: Words = button(["State of the button that turns left.", "Состояние кнопки «влево»."]);
const RIGHT: Words =
    button(["State of the button that turns right.", "Состояние кнопки «вправо»."]);
const UP: Words = button(["State of the button that raises.", "Состояние кнопки «вверх»."]);
const DOWN: Words = button(["State of the button that lowers.", "Состояние кнопки «вниз»."]);
const WIDE: Words =
    button(["State of the button that widens the spray.", "Состояние кнопки «шире»."]);
const NARROW: Words =
    button(["State of the button that narrows the jet.", "Состояние кнопки «уже»."]);
const OPEN: Words =
    button(["State of the button that opens the valve.", "Состояние кнопки «открыть»."]);
const CLOSE: Words =
    button(["State of the button that closes the valve.", "Состояние кнопки «закрыть»."]);
