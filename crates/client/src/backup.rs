//! Backup and restore of a monitor's parameters in a file, for commissioning and service.

mod file;
mod restore;

pub use file::FileError;
pub use restore::{Restored, Step, Verdict};

use lafet_proto::param::{Access, Param, Storage};
use lafet_proto::{Status, SubsystemId};

use crate::batch::Progress;
use crate::error::Error;
use crate::monitor::Monitor;

/// The stored parameters of a monitor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Backup {
    /// The monitor and the program that made the backup.
    pub about: About,
    /// Parameters with their values, in the order of the dictionary.
    pub values: Vec<(Param, Vec<i32>)>,
    /// Parameters without a value, with the reason: never set (IncompleteConfig), or unknown to the
    /// monitor (InvalidId).
    pub unread: Vec<(Param, String)>,
    /// Parameters that may have a value that the monitor did not supply, with the reason: a remote
    /// unit that does not answer (NotCached), Busy. Without them the backup is not whole; the file does
    /// not list them.
    pub missed: Vec<(Param, String)>,
}

/// Origin of a backup. The protocol has no request for the version of the monitor's program, so the
/// engineer enters it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// URL of the monitor.
    pub url: String,
    /// Names of the subsystems that the monitor has.
    pub subsystems: Vec<String>,
    /// The profile with exactly these subsystems, if there is one.
    pub profile: Option<String>,
    /// Version of the monitor's program, as entered by the engineer.
    pub firmware: Option<String>,
    /// Name and version of the program that made the file.
    pub made_by: String,
}

/// A parameter whose values differ in two places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The parameter that differs.
    pub param: Param,
    /// Its values in the first place; `None`: not set or not present.
    pub here: Option<Vec<i32>>,
    /// Its values in the second place; `None`: not set or not present.
    pub there: Option<Vec<i32>>,
}

impl Backup {
    /// The values of a parameter; `None` if the backup does not have it.
    pub fn get(&self, param: Param) -> Option<&[i32]> {
        let found = self.values.iter().find(|(known, _)| *known == param);
        found.map(|(_, values)| values.as_slice())
    }

    /// The differences between two backups, in the order of the dictionary. A parameter that only
    /// one of them has is a difference.
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let both = Param::ALL.into_iter().map(|param| (param, self.get(param), other.get(param)));
        both.filter(|(_, here, there)| here != there)
            .map(|(param, here, there)| Difference {
                param,
                here: here.map(<[i32]>::to_vec),
                there: there.map(<[i32]>::to_vec),
            })
            .collect()
    }
}

/// The title of a parameter: `Vertical.Speed`.
pub fn title(param: Param) -> String {
    format!("{}.{}", param.spec().subsystem, param.name())
}

/// The parameter with this title.
pub fn of_title(title: &str) -> Option<Param> {
    let (subsystem, name) = title.split_once('.')?;
    let same = |who: &SubsystemId| who.name().is_some_and(|n| n.eq_ignore_ascii_case(subsystem));
    Param::by_name(SubsystemId::TABLE.into_iter().find(same)?, name)
}

/// Whether a parameter belongs in a backup: it is stored and may be set.
pub fn is_kept(param: Param) -> bool {
    let spec = param.spec();
    spec.storage == Storage::Stored && spec.access == Access::ReadWrite
}

/// Whether a parameter that is refused so has no value.
fn is_without(status: Status) -> bool {
    matches!(status, Status::INCOMPLETE_CONFIG | Status::INVALID_ID | Status::NOT_SUPPORTED)
}

impl Monitor {
    /// §3.4 Reads every stored parameter. Those of subsystems that the monitor does not have are
    /// left out.
    ///
    /// # Errors
    ///
    /// Those of [`Client::request`](crate::Client::request) except refusals: a parameter that is
    /// refused is listed in [`Backup::unread`] or [`Backup::missed`].
    pub async fn backup(&self, progress: impl FnMut(Progress)) -> Result<Backup, Error> {
        let status = self.status_all().await?;
        let present: Vec<SubsystemId> = status.present().collect();
        let params: Vec<Param> = Param::ALL
            .into_iter()
            .filter(|param| is_kept(*param) && present.contains(&param.spec().subsystem))
            .collect();
        let mut backup = Backup::default();
        backup.about.url = self.client().endpoint().to_owned();
        backup.about.subsystems = present.iter().map(SubsystemId::to_string).collect();
        for (param, values) in params.iter().zip(self.params_with(&params, progress).await) {
            match values {
                Ok(values) => backup.values.push((*param, values)),
                Err(Error::Refused { status: Status::MODULE_NOT_EXIST, .. }) => {}
                Err(Error::Refused { status, .. }) => {
                    let list = match is_without(status) {
                        true => &mut backup.unread,
                        false => &mut backup.missed,
                    };
                    list.push((*param, status.to_string()));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(backup)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles() {
        for param in Param::ALL {
            assert_eq!(of_title(&title(param)), Some(param));
        }
        assert_eq!(of_title("vertical.speed"), Some(Param::VerticalSpeed));
        for wrong in ["", "Speed", "Vertical.", "Vertical.Sped", "Up.Speed"] {
            assert_eq!(of_title(wrong), None, "{wrong}");
        }
        assert!(is_kept(Param::VerticalSpeed) && !is_kept(Param::GeneralFaultInfo));
    }

    #[test]
    fn differences_go_both_ways() {
        let one = |speed: i32| Backup {
            values: vec![(Param::VerticalSpeed, vec![speed])],
            ..Backup::default()
        };
        assert!(one(8).differences(&one(8)).is_empty());
        let differences = one(8).differences(&one(9));
        assert_eq!(differences.len(), 1);
        assert_eq!(differences[0].there, Some(vec![9]));
        assert_eq!(Backup::default().differences(&one(9))[0].here, None);
    }
}
