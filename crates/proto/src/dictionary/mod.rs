//! Texts in English and Russian for everything that a user sees.
//!
//! Statuses, subsystems and requests are here; the texts of flags are in [`crate::flags`], those of
//! parameters in [`crate::param`], the layout of data in [`layouts`]. Consoles, schemas, dissectors
//! and reference documentation are made from these. What a status or request *means* follows the
//! document; what to do about it is ours.

pub mod layouts;
mod requests;
mod statuses;
mod subsystems;
mod validity;

pub use requests::{Origin, REQUESTS, RequestInfo};
pub use statuses::{STATUSES, StatusInfo};
pub use subsystems::{SUBSYSTEMS, SubsystemInfo};
pub use validity::{INVALIDATES, Invalidates, invalid};

use crate::flags::{Button, ButtonState, Severity};
use crate::id::{RequestId, Status, SubsystemId};

/// A text in both languages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Text {
    /// English.
    pub en: &'static str,
    /// Russian.
    pub ru: &'static str,
}

impl Text {
    /// A text in both languages.
    pub const fn new(en: &'static str, ru: &'static str) -> Self {
        Self { en, ru }
    }
}

/// What shows a text of the dictionary.
pub type Key = Text;

/// Description of a status (§2); `None` if unknown.
pub fn status(status: Status) -> Option<&'static StatusInfo> {
    STATUSES.iter().find(|info| info.status == status)
}

/// Description of a subsystem (§1); `None` if unknown.
pub fn subsystem(id: SubsystemId) -> Option<&'static SubsystemInfo> {
    SUBSYSTEMS.iter().find(|info| info.id == id)
}

/// Description of a request (§3) or a service of the bus controller; `None` if unknown.
pub fn request(id: RequestId) -> Option<&'static RequestInfo> {
    REQUESTS.iter().find(|info| info.id == id)
}

impl Severity {
    /// Every severity, the mildest first.
    pub const ALL: [Self; 4] = [Self::Info, Self::Notice, Self::Warning, Self::Alarm];

    /// Name of the severity.
    pub const fn text(self) -> Text {
        match self {
            Self::Info => Text::new("info", "норма"),
            Self::Notice => Text::new("notice", "к сведению"),
            Self::Warning => Text::new("warning", "предупреждение"),
            Self::Alarm => Text::new("alarm", "тревога"),
        }
    }
}

impl ButtonState {
    /// Every state in the order of its value (§3.3.10).
    pub const ALL: [Self; 4] = [Self::Released, Self::Pressed, Self::Short, Self::Open];

    /// Name of the state.
    pub const fn text(self) -> Text {
        match self {
            Self::Released => Text::new("released", "не нажата"),
            Self::Pressed => Text::new("pressed", "нажата"),
            Self::Short => Text::new("short circuit", "КЗ"),
            Self::Open => Text::new("open circuit", "обрыв"),
        }
    }
}

impl Button {
    /// Label of the button (§3.3.10).
    pub const fn text(self) -> Text {
        match self {
            Self::Left => Text::new("left", "влево"),
            Self::Right => Text::new("right", "вправо"),
            Self::Up => Text::new("up", "вверх"),
            Self::Down => Text::new("down", "вниз"),
            Self::Wide => Text::new("wider", "шире"),
            Self::Narrow => Text::new("narrower", "уже"),
            Self::Open => Text::new("open", "открыть"),
            Self::Close => Text::new("close", "закрыть"),
        }
    }
}
