//! Why an update has ended: each message says what, where and what to do.

use std::sync::Arc;
use std::{fmt, io};

use lafet_proto::flags::{DeployerFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_texts::{Argument, Fixed, Lang, Shown, Text, client as text};

use crate::error::Error;
use crate::os_text::SystemError;
use crate::status::MonitorStatus;

/// The software of a monitor was not updated, or it is not known whether it was.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum UpdateError {
    /// A request failed, or the line was dead for longer than [`super::PATIENCE`].
    Client(Error),
    /// The monitor cannot be updated over the link.
    NoUpdate(Status),
    /// The new program has no update: it can be neither confirmed nor taken back over the link.
    Deaf(Status),
    /// None of the images is for the slot that may be written.
    NoImage {
        /// That slot: 1 A, 2 B.
        slot: u8,
    },
    /// It runs this version, confirmed: nothing was changed.
    AlreadyRunning([u16; 4]),
    /// The monitor is not in a state to be updated. Never empty.
    NotReady(Vec<Unready>),
    /// The monitor could not carry an order out: the reason of its report.
    Refused(u8),
    /// Another sender has started another image meanwhile.
    OtherSender,
    /// Answered, but nothing goes on.
    Stalled {
        /// Bytes of the payload that are there.
        done: u32,
        /// Bytes of the payload.
        size: u32,
    },
    /// It was restarted with the new image, and does not answer.
    Silent(Error),
    /// What the monitor was before could not be kept, so nothing was committed.
    Note(Arc<io::Error>),
    /// The new image was tried, and the old one is running again.
    WentBack {
        /// The version that was tried.
        wanted: [u16; 4],
        /// The version that is running.
        running: [u16; 4],
        /// It has answered on trial.
        lived: bool,
    },
    /// On trial the monitor is not as before, so the image was not confirmed.
    Changed {
        /// What is different. Never empty.
        what: Vec<Change>,
        /// The version that is running again; `None`: it has not gone back yet, or does not answer.
        back: Option<[u16; 4]>,
    },
}

/// What keeps a monitor from being updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unready {
    /// It is not locked out.
    NotLockedOut,
    /// It is not in standby.
    NotStowed,
    /// A valve is not closed.
    ValveOpen(SubsystemId),
    /// A drive moves.
    Moves(SubsystemId),
    /// The supply is bad.
    BadSupply,
    /// A parameter takes effect at the next start, which moves it to another address or changes what it has.
    WaitsForRestart {
        /// Its name in the document; of General.
        param: &'static str,
    },
    /// The status does not show it.
    Hidden,
}

/// What is not as it was before the restart.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Change {
    /// A subsystem does not answer with its state.
    Absent(SubsystemId),
    /// A flag that was not set.
    Fault {
        /// Whose.
        who: SubsystemId,
        /// Its name in the document.
        flag: &'static str,
    },
    /// The state cannot be read.
    Unreadable(Error),
}

impl Unready {
    /// All that a state shows; [`Self::Hidden`] if it shows nothing.
    pub(super) fn of(status: &MonitorStatus) -> Vec<Self> {
        let all = Self::seen(status);
        if all.is_empty() { vec![Self::Hidden] } else { all }
    }

    /// All that a state shows: whether a lockout is stored, it does not.
    pub fn seen(status: &MonitorStatus) -> Vec<Self> {
        let mut all = Vec::new();
        let general = status.general.map(|it| it.flags);
        if general.is_some_and(|flags| !flags.contains(GeneralFlags::LOCKED_OUT)) {
            all.push(Self::NotLockedOut);
        }
        if status.deployer.is_some_and(|it| !it.flags.contains(DeployerFlags::WRAPPED)) {
            all.push(Self::NotStowed);
        }
        let open = |id: &SubsystemId| {
            status.valve(*id).is_some_and(|it| {
                !it.flags.contains(ValveFlags::CLOSED) || it.flags.contains(ValveFlags::OPENING)
            })
        };
        let valves = [SubsystemId::VALVE1, SubsystemId::VALVE2];
        all.extend(valves.into_iter().filter(open).map(Self::ValveOpen));
        let moves = |id: &SubsystemId| {
            status.drive(*id).is_some_and(|it| it.flags.contains(DriveFlags::MOVE))
        };
        let drives = [SubsystemId::VERTICAL, SubsystemId::HORIZONTAL, SubsystemId::NOZZLE];
        all.extend(drives.into_iter().filter(moves).map(Self::Moves));
        if general.is_some_and(|flags| flags.contains(GeneralFlags::BAD_POWER)) {
            all.push(Self::BadSupply);
        }
        all
    }
}

impl Argument for Unready {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::NotLockedOut => text::UpdateNotLockedOut.write(lang, out),
            Self::NotStowed => text::UpdateNotStowed.write(lang, out),
            Self::ValveOpen(valve) => {
                text::UpdateValveOpen { valve: Shown(valve) }.write(lang, out)
            }
            Self::Moves(drive) => text::UpdateDriveMoves { drive: Shown(drive) }.write(lang, out),
            Self::BadSupply => text::UpdateBadSupply.write(lang, out),
            Self::WaitsForRestart { param } => {
                text::UpdateWaitsForRestart { param: *param }.write(lang, out)
            }
            Self::Hidden => text::UpdateNotReadyHidden.write(lang, out),
        }
    }
}

impl Text for Unready {}

impl Argument for Change {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Absent(subsystem) => {
                text::UpdateAbsent { subsystem: Shown(subsystem) }.write(lang, out)
            }
            Self::Fault { who, flag } => {
                text::UpdateNewFault { who: Shown(who), flag: *flag }.write(lang, out)
            }
            Self::Unreadable(error) => text::UpdateUnreadable { error }.write(lang, out),
        }
    }
}

impl Text for Change {}

/// Several texts, one behind the other.
struct Joined<'a, T>(&'a [T]);

impl<T: Argument> Argument for Joined<'_, T> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        for (index, one) in self.0.iter().enumerate() {
            if index > 0 {
                out.write_str(" ")?;
            }
            one.write(lang, out)?;
        }
        Ok(())
    }
}

/// A version as people write it: `1.2.0.7`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dotted(pub [u16; 4]);

impl fmt::Display for Dotted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, patch, build] = self.0;
        write!(f, "{major}.{minor}.{patch}.{build}")
    }
}

/// What a reason of a report means, and what to do (docs/update.md); `None` for a number that is not in the list.
fn reason(number: u8) -> Option<Fixed> {
    Some(match number {
        1 => text::UpdateReasonNoImage.fixed(),
        2 => text::UpdateReasonFormat.fixed(),
        3 => text::UpdateReasonField.fixed(),
        4 => text::UpdateReasonBoard.fixed(),
        5 => text::UpdateReasonPlace.fixed(),
        6 => text::UpdateReasonSize.fixed(),
        7 => text::UpdateReasonUnknownKey.fixed(),
        8 => text::UpdateReasonRevokedKey.fixed(),
        9 => text::UpdateReasonRevokesItself.fixed(),
        10 => text::UpdateReasonSignature.fixed(),
        11 => text::UpdateReasonNotNewer.fixed(),
        12 => text::UpdateReasonLayout.fixed(),
        13 => text::UpdateReasonNothingStarted.fixed(),
        14 => text::UpdateReasonMisplaced.fixed(),
        15 => text::UpdateReasonIncomplete.fixed(),
        16 => text::UpdateReasonDigest.fixed(),
        17 => text::UpdateReasonNotVerified.fixed(),
        18 => text::UpdateReasonTrialFirst.fixed(),
        19 => text::UpdateReasonNoTrial.fixed(),
        20 => text::UpdateReasonWord.fixed(),
        21 => text::UpdateReasonFlash.fixed(),
        255 => text::UpdateReasonNotReady.fixed(),
        _ => return None,
    })
}

impl UpdateError {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for UpdateError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Client(error) => error.write(lang, out),
            Self::NoUpdate(status) => {
                text::UpdateNotSupported { status: Shown(status) }.write(lang, out)
            }
            Self::Deaf(status) => text::UpdateDeaf { status: Shown(status) }.write(lang, out),
            Self::NoImage { slot } => {
                let slot = if *slot == 1 { "A" } else { "B" };
                text::UpdateNoImage { slot }.write(lang, out)
            }
            Self::AlreadyRunning(version) => {
                text::UpdateAlreadyRunning { version: Shown(Dotted(*version)) }.write(lang, out)
            }
            Self::NotReady(why) => text::UpdateNotReady { why: Joined(why) }.write(lang, out),
            Self::Refused(number) => match reason(*number) {
                Some(why) => text::UpdateRefused { why }.write(lang, out),
                None => text::UpdateRefusedUnknown { number: *number }.write(lang, out),
            },
            Self::OtherSender => text::UpdateOtherSender.write(lang, out),
            Self::Stalled { done, size } => {
                text::UpdateStalled { done: *done, size: *size }.write(lang, out)
            }
            Self::Silent(error) => text::UpdateSilent { error }.write(lang, out),
            Self::Note(error) => {
                text::UpdateNotNoted { error: SystemError(error) }.write(lang, out)
            }
            Self::WentBack { wanted, running, lived } => {
                let (wanted, running) = (Shown(Dotted(*wanted)), Shown(Dotted(*running)));
                match lived {
                    true => text::UpdateTrialEnded { wanted, running }.write(lang, out),
                    false => text::UpdateWentBack { wanted, running }.write(lang, out),
                }
            }
            Self::Changed { what, back } => {
                let what = Joined(what);
                match back {
                    Some(version) => {
                        let running = Shown(Dotted(*version));
                        text::UpdateChanged { what, running }.write(lang, out)
                    }
                    None => text::UpdateChangedStill { what }.write(lang, out),
                }
            }
        }
    }
}

impl Text for UpdateError {}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Argument::write(self, Lang::En, f)
    }
}

impl std::error::Error for UpdateError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Client(error) | Self::Silent(error) => Some(error),
            Self::Note(error) => Some(error.as_ref()),
            _ => None,
        }
    }
}

impl From<Error> for UpdateError {
    fn from(error: Error) -> Self {
        match error {
            Error::Refused { request: RequestId::UPDATE, status, .. } => Self::NoUpdate(status),
            error => Self::Client(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<UpdateError> {
        let error = Error::Closed;
        let unready = vec![
            Unready::NotLockedOut,
            Unready::NotStowed,
            Unready::ValveOpen(SubsystemId::VALVE1),
            Unready::Moves(SubsystemId::NOZZLE),
            Unready::BadSupply,
            Unready::WaitsForRestart { param: "Chain" },
            Unready::Hidden,
        ];
        let changes = [
            Change::Absent(SubsystemId::NOZZLE),
            Change::Fault { who: SubsystemId::GENERAL, flag: "InternalFault" },
            Change::Unreadable(error.clone()),
        ];
        let mut all: Vec<_> = (1..=22).chain([255]).map(UpdateError::Refused).collect();
        all.extend(unready.into_iter().map(|one| UpdateError::NotReady(vec![one])));
        for back in [None, Some([1, 2, 3, 4])] {
            let each = changes.iter().cloned();
            all.extend(each.map(|one| UpdateError::Changed { what: vec![one], back }));
        }
        all.extend([
            UpdateError::Client(error.clone()),
            UpdateError::NoUpdate(Status::WRONG_REQUEST),
            UpdateError::Deaf(Status::WRONG_REQUEST),
            UpdateError::NoImage { slot: 2 },
            UpdateError::AlreadyRunning([2, 0, 0, 0]),
            UpdateError::OtherSender,
            UpdateError::Stalled { done: 8, size: 16 },
            UpdateError::Silent(error),
            UpdateError::Note(Arc::new(io::Error::other("no room"))),
            UpdateError::WentBack { wanted: [2, 0, 0, 0], running: [1, 0, 0, 0], lived: false },
            UpdateError::WentBack { wanted: [2, 0, 0, 0], running: [1, 0, 0, 0], lived: true },
        ]);
        all
    }

    #[test]
    fn every_error_is_its_own_in_both_languages_and_ends_its_sentences() {
        let mut seen = Vec::new();
        for error in all() {
            let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
            let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
            assert!(!cyrillic(&english) && cyrillic(&russian), "{english} / {russian}");
            assert!(english.ends_with('.') && russian.ends_with('.'), "{english} / {russian}");
            assert!(!seen.contains(&english), "{english}");
            seen.push(english);
        }
    }

    #[test]
    fn every_reason_of_the_list_has_words() {
        for number in 0..=u8::MAX {
            let listed = matches!(number, 1..=21 | 255);
            assert_eq!(reason(number).is_some(), listed, "{number}");
        }
    }
}
