//! A description of everything that a user sees, with a [`Key`] for each text.
//!
//! Statuses, subsystems and requests are here; flags are in [`crate::flags`], parameters in
//! [`crate::param`], the layout of data in [`layouts`]. Consoles, schemas, dissectors and reference
//! documentation are made from these and from the catalogues of texts. What a status or request
//! *means* follows the document; what to do about it is ours.

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

/// Key of a text for people.
///
/// The words in every language are in the catalogues of `lafet-texts`, file `proto.ftl`; a program
/// for a chip that shows none links none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(&'static str);

impl Key {
    pub(crate) const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// As the catalogues have it: `status-Busy-remedy`.
    pub const fn name(self) -> &'static str {
        self.0
    }
}

/// A key put together of literals.
macro_rules! key {
    ($($part:tt)+) => { $crate::dictionary::Key::new(concat!($($part)+)) };
}

pub(crate) use key;

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
    pub const fn text(self) -> Key {
        match self {
            Self::Info => key!("severity-Info"),
            Self::Notice => key!("severity-Notice"),
            Self::Warning => key!("severity-Warning"),
            Self::Alarm => key!("severity-Alarm"),
        }
    }
}

impl ButtonState {
    /// Every state in the order of its value (§3.3.10).
    pub const ALL: [Self; 4] = [Self::Released, Self::Pressed, Self::Short, Self::Open];

    /// Name of the state.
    pub const fn text(self) -> Key {
        match self {
            Self::Released => key!("button-state-Released"),
            Self::Pressed => key!("button-state-Pressed"),
            Self::Short => key!("button-state-Short"),
            Self::Open => key!("button-state-Open"),
        }
    }
}

impl Button {
    /// Label of the button (§3.3.10).
    pub const fn text(self) -> Key {
        match self {
            Self::Left => key!("button-Left"),
            Self::Right => key!("button-Right"),
            Self::Up => key!("button-Up"),
            Self::Down => key!("button-Down"),
            Self::Wide => key!("button-Wide"),
            Self::Narrow => key!("button-Narrow"),
            Self::Open => key!("button-Open"),
            Self::Close => key!("button-Close"),
        }
    }
}
