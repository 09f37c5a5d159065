//! Behaviour of this side on a link: checksum of its frames, role on its bus.

use std::fmt;
use std::time::Duration;

use lafet_proto::bus::CONTROLLER;
use lafet_texts::client as text;

use super::{Addresses, Options, Role, UrlError};
use crate::session::CheckMode;

/// Behaviour of this side on a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Behaviour {
    /// Checksum of frames, `check=`.
    pub check: CheckMode,
    /// Role of this side on its bus, `role=`.
    pub role: Role,
    /// Longest delay of an answer, `late=` s; zero: the connection ends with this program, so there
    /// are no answers to others.
    pub late: Option<Duration>,
}

const CHECK_NAMES: &[(&str, CheckMode)] =
    &[("crc16", CheckMode::Crc16), ("auto", CheckMode::Auto), ("crc32c", CheckMode::Crc32c)];
const ROLE_NAMES: &[(&str, Role)] = &[("direct", Role::Direct), ("active", Role::Active)];

impl Behaviour {
    pub(super) fn read(options: &mut Options, addresses: Addresses) -> Result<Self, UrlError> {
        let check = options.check()?;
        let role =
            options.one_of("role", ROLE_NAMES, text::AllowedRole.fixed())?.unwrap_or_default();
        if role == Role::Active && addresses.source == CONTROLLER {
            let value = CONTROLLER.to_string();
            return Err(UrlError::Value {
                key: "src".into(),
                value,
                allowed: text::AllowedConsoleAddress.fixed(),
            });
        }
        Ok(Self { check, role, late: options.late()? })
    }

    /// Writes the options that differ from the defaults.
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

/// The greatest delay, s; greater values are rejected as errors of the user.
const LATE_S_MAX: u64 = 60;

impl Options {
    pub(super) fn late(&mut self) -> Result<Option<Duration>, UrlError> {
        match self.number("late", u64::MAX, 0..=LATE_S_MAX, text::AllowedLate.fixed())? {
            u64::MAX => Ok(None),
            seconds => Ok(Some(Duration::from_secs(seconds))),
        }
    }

    pub(super) fn check(&mut self) -> Result<CheckMode, UrlError> {
        Ok(self.one_of("check", CHECK_NAMES, text::AllowedCheck.fixed())?.unwrap_or_default())
    }
}
