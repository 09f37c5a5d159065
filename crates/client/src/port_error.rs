//! Errors of a serial port.

use std::fmt;
use std::io;
use std::path::PathBuf;

use lafet_texts::{Argument, Lang, Shown, Text, client as text};

use crate::os_text::SystemError;
use crate::usb::Usb;

/// Why a port cannot be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PortError {
    /// Another program uses the port.
    InUse {
        /// The port.
        path: PathBuf,
        /// The program, if the system shows it.
        by: Option<Holder>,
    },
    /// The user has no permission.
    Permission {
        /// The port.
        path: PathBuf,
        /// The group that has permission.
        group: Option<String>,
    },
    /// There is no such port.
    Missing {
        /// The port.
        path: PathBuf,
    },
    /// It is something else: a file, a folder, another device; or a port without hardware.
    NotSerial {
        /// What was named as a port.
        path: PathBuf,
    },
    /// A Stop of another program could not ask for the port: the system gives no socket for that.
    NoDoor {
        /// The port.
        path: PathBuf,
        /// The error's number in the system.
        code: i32,
    },
    /// Another adapter has the name of the one that was used before.
    OtherAdapter {
        /// The port.
        path: PathBuf,
        /// The adapter that was used.
        was: Box<Usb>,
        /// The one that is there.
        now: Option<Box<Usb>>,
    },
}

/// A program that has a port open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Process id.
    pub pid: u32,
    /// Name of the program.
    pub program: String,
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.program, self.pid)
    }
}

impl PortError {
    /// The port error inside an I/O error of the link.
    pub fn of(error: &io::Error) -> Option<&Self> {
        error.get_ref()?.downcast_ref()
    }

    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for PortError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::InUse { path, by } => {
                let port = Shown(path.display());
                match by {
                    Some(Holder { pid, program }) => {
                        let by = text::ProgramWithId { program, pid };
                        text::PortInUse { port, by }.write(lang, out)
                    }
                    None => text::PortInUse { port, by: text::AnotherProgram }.write(lang, out),
                }
            }
            Self::Permission { path, group } => {
                let port = Shown(path.display());
                match group {
                    Some(group) => text::PortNotPermitted { port, group }.write(lang, out),
                    None => text::PortOfOwner { port }.write(lang, out),
                }
            }
            Self::Missing { path } => {
                text::PortMissing { port: Shown(path.display()) }.write(lang, out)
            }
            Self::NotSerial { path } => {
                text::PortNotSerial { port: Shown(path.display()) }.write(lang, out)
            }
            Self::NoDoor { path, code } => {
                let (port, error) = (Shown(path.display()), io::Error::from_raw_os_error(*code));
                text::PortWithoutDoor { port, error: SystemError(&error) }.write(lang, out)
            }
            Self::OtherAdapter { path, was, now } => {
                let port = Shown(path.display());
                let now = now.as_ref().map_or_else(|| "—".to_owned(), ToString::to_string);
                text::PortOtherAdapter { port, was: Shown(was), now }.write(lang, out)
            }
        }
    }
}

impl Text for PortError {}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
    }
}

impl std::error::Error for PortError {}

impl From<PortError> for io::Error {
    fn from(error: PortError) -> Self {
        let kind = match error {
            PortError::InUse { .. } => io::ErrorKind::ResourceBusy,
            PortError::Permission { .. } => io::ErrorKind::PermissionDenied,
            PortError::Missing { .. } => io::ErrorKind::NotFound,
            PortError::NotSerial { .. } => io::ErrorKind::InvalidInput,
            PortError::NoDoor { code, .. } => Self::from_raw_os_error(code).kind(),
            PortError::OtherAdapter { .. } => io::ErrorKind::NotConnected,
        };
        Self::new(kind, error)
    }
}

/// The driver of the port cannot switch the direction of an RS-485 transceiver.
#[derive(Debug)]
pub struct CannotSwitch(pub(crate) io::Error);

impl fmt::Display for CannotSwitch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for CannotSwitch {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_names_the_port_and_a_remedy_in_both_languages() {
        let path = PathBuf::from("/dev/ttyUSB7");
        let by = Some(Holder { pid: 42, program: "minicom".into() });
        let errors = [
            (PortError::InUse { path: path.clone(), by }, "minicom (42)"),
            (PortError::InUse { path: path.clone(), by: None }, "shared=1"),
            (
                PortError::Permission { path: path.clone(), group: Some("dialout".into()) },
                "usermod -aG dialout",
            ),
            (PortError::Permission { path: path.clone(), group: None }, "/dev/ttyUSB7"),
            (PortError::Missing { path: path.clone() }, "lafet ports"),
            (PortError::NotSerial { path: path.clone() }, "lafet ports"),
            (PortError::NoDoor { path: path.clone(), code: 24 }, "ulimit -n"),
            (PortError::OtherAdapter { path, was: Box::default(), now: None }, "by-id"),
        ];
        for (error, remedy) in errors {
            for lang in [Lang::En, Lang::Ru] {
                let text = error.localized(lang);
                assert!(text.contains("/dev/ttyUSB7"), "{text}");
                let program = remedy.contains("42") && lang == Lang::Ru;
                assert!(program || text.contains(remedy) || remedy.starts_with("/"), "{text}");
            }
            let error = io::Error::from(error);
            assert!(PortError::of(&error).is_some());
        }
    }
}
