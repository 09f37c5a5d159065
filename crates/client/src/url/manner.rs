//! How this side behaves: which check its frames bear, and what it is on its bus.

use std::fmt;
use std::time::Duration;

use lafet_proto::bus::CONTROLLER;

use super::{Addresses, Options, Role, UrlError};
use crate::session::CheckMode;
use crate::url_error::{CHECKS, CONSOLE_ADDRESSES, LATES, ROLES};

/// How this side behaves on a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Manner {
    /// Which check frames bear, `check=`.
    pub check: CheckMode,
    /// What this side is on its bus, `role=`.
    pub role: Role,
    /// How late an answer can come, `late=` s; zero: the way ends with this program, so there are no
    /// answers to others.
    pub late: Option<Duration>,
}

const CHECK_NAMES: &[(&str, CheckMode)] =
    &[("crc16", CheckMode::Crc16), ("auto", CheckMode::Auto), ("crc32c", CheckMode::Crc32c)];
const ROLE_NAMES: &[(&str, Role)] = &[("direct", Role::Direct), ("active", Role::Active)];

impl Manner {
    pub(super) fn read(options: &mut Options, addresses: Addresses) -> Result<Self, UrlError> {
        let check = options.check()?;
        let role = options.one_of("role", ROLE_NAMES, ROLES)?.unwrap_or_default();
        if role == Role::Active && addresses.source == CONTROLLER {
            let value = CONTROLLER.to_string();
            return Err(UrlError::Value { key: "src".into(), value, allowed: CONSOLE_ADDRESSES });
        }
        Ok(Self { check, role, late: options.late()? })
    }

    /// The options that are not as usual.
    pub(super) fn write(self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, check) in CHECK_NAMES {
            if *check == self.check && *check != CheckMode::default() {
                write!(f, "&check={name}")?;
            }
        }
        f.write_str(if self.role == Role::Active { "&role=active" } else { "" })?;
        self.late.map_or(Ok(()), |late| write!(f, "&late={}", late.as_secs()))
    }
}

/// Answers that are later than this are a mistake.
const LATE_S_MAX: u64 = 60;

impl Options {
    pub(super) fn late(&mut self) -> Result<Option<Duration>, UrlError> {
        match self.number("late", u64::MAX, 0..=LATE_S_MAX, LATES)? {
            u64::MAX => Ok(None),
            seconds => Ok(Some(Duration::from_secs(seconds))),
        }
    }

    pub(super) fn check(&mut self) -> Result<CheckMode, UrlError> {
        Ok(self.one_of("check", CHECK_NAMES, CHECKS)?.unwrap_or_default())
    }
}
