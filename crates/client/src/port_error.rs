//! Errors of a serial port.

use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::error::Lang;

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
        match lang {
            Lang::En => self.english(),
            Lang::Ru => self.russian(),
        }
    }

    fn english(&self) -> String {
        match self {
            Self::InUse { path, by } => {
                let by = by.as_ref().map_or("another program".into(), Holder::to_string);
                format!(
                    "{} is in use by {by}. Close that program, or write shared=1 into the URL of \
                     both: then each may lose answers to the other.",
                    path.display()
                )
            }
            Self::Permission { path, group: Some(group) } => format!(
                "No permission to open {}. Join the group {group} (`sudo usermod -aG {group} \
                 $USER`), then log in again.",
                path.display()
            ),
            Self::Permission { path, group: None } => {
                format!("No permission to open {}: its owner can grant it.", path.display())
            }
            Self::Missing { path } => format!(
                "There is no port {}. Check that the adapter is plugged in; `lafet ports` lists \
                 the ports that there are.",
                path.display()
            ),
        }
    }

    fn russian(&self) -> String {
        match self {
            Self::InUse { path, by } => {
                let by = by.as_ref().map_or("другой программой".into(), |by| {
                    format!("программой {by}")
                });
                format!(
                    "Порт {} занят {by}. Закройте её или укажите shared=1 в URL обеих программ: \
                     тогда каждая может терять ответы из-за другой.",
                    path.display()
                )
            }
            Self::Permission { path, group: Some(group) } => format!(
                "Нет прав на открытие {}. Вступите в группу {group} (`sudo usermod -aG {group} \
                 $USER`) и войдите в систему заново.",
                path.display()
            ),
            Self::Permission { path, group: None } => {
                format!("Нет прав на открытие {}: их может дать владелец.", path.display())
            }
            Self::Missing { path } => format!(
                "Порта {} нет. Проверьте, подключён ли адаптер; `lafet ports` покажет имеющиеся \
                 порты.",
                path.display()
            ),
        }
    }
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.english())
    }
}

impl std::error::Error for PortError {}

impl From<PortError> for io::Error {
    fn from(error: PortError) -> Self {
        let kind = match error {
            PortError::InUse { .. } => io::ErrorKind::ResourceBusy,
            PortError::Permission { .. } => io::ErrorKind::PermissionDenied,
            PortError::Missing { .. } => io::ErrorKind::NotFound,
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
            (PortError::Missing { path }, "lafet ports"),
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
