//! §3.3.10 «Флаги состояния Buttons, ExtButtons».

use super::{Words, words};

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

pub const LEFT: Words =
    button(["State of the button that turns left.", "Состояние кнопки «влево»."]);
pub const RIGHT: Words =
    button(["State of the button that turns right.", "Состояние кнопки «вправо»."]);
pub const UP: Words = button(["State of the button that raises.", "Состояние кнопки «вверх»."]);
pub const DOWN: Words = button(["State of the button that lowers.", "Состояние кнопки «вниз»."]);
pub const WIDE: Words =
    button(["State of the button that widens the spray.", "Состояние кнопки «шире»."]);
pub const NARROW: Words =
    button(["State of the button that narrows the jet.", "Состояние кнопки «уже»."]);
pub const OPEN: Words =
    button(["State of the button that opens the valve.", "Состояние кнопки «открыть»."]);
pub const CLOSE: Words =
    button(["State of the button that closes the valve.", "Состояние кнопки «закрыть»."]);
