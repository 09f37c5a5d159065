//! What of the parameters is stored together.

use crate::composition::table_index;
use crate::hal::Key;
use lafet_proto::SubsystemId;
use lafet_proto::param::Param;

/// Subsystems, programs and trajectories: as many groups of each kind.
pub(super) const SUBSYSTEMS: u8 = SubsystemId::TABLE.len() as u8;
pub(super) const PROGRAMS: u8 = 8;
pub(super) const TRAJECTORIES: u8 = 8;

/// What is stored as one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// The single numbers of a subsystem, by its place in the table of §1.
    Subsystem(u8),
    /// A program of Control.
    Program(u8),
    /// A trajectory of Control.
    Trajectory(u8),
    /// The correction table (§3.6).
    Correction,
    /// Whether the monitor is locked out (§3.18).
    Lockout,
}

// Sets of groups are words.
const _: () = assert!(Group::COUNT <= 32);

impl Group {
    pub(super) const COUNT: u8 = SUBSYSTEMS + PROGRAMS + TRAJECTORIES + 2;

    pub(super) const fn index(self) -> u8 {
        match self {
            Self::Subsystem(index) => index,
            Self::Program(index) => SUBSYSTEMS + index,
            Self::Trajectory(index) => SUBSYSTEMS + PROGRAMS + index,
            Self::Correction => Self::COUNT - 2,
            Self::Lockout => Self::COUNT - 1,
        }
    }

    pub(super) const fn from_index(index: u8) -> Self {
        const TRAJECTORY: u8 = SUBSYSTEMS + PROGRAMS;
        const CORRECTION: u8 = Group::COUNT - 2;
        match index {
            0..SUBSYSTEMS => Self::Subsystem(index),
            SUBSYSTEMS..TRAJECTORY => Self::Program(index - SUBSYSTEMS),
            TRAJECTORY..CORRECTION => Self::Trajectory(index - TRAJECTORY),
            CORRECTION => Self::Correction,
            _ => Self::Lockout,
        }
    }

    pub(super) const fn bit(self) -> u32 {
        1 << self.index()
    }

    pub(super) const fn key(self) -> Key {
        Key(1 + self.index() as u16)
    }

    /// The subsystem whose flags tell when this group cannot be read or written.
    pub(super) fn owner(self) -> SubsystemId {
        match self {
            Self::Subsystem(index) => {
                SubsystemId::TABLE.get(usize::from(index)).copied().unwrap_or(SubsystemId::GENERAL)
            }
            Self::Program(_) | Self::Trajectory(_) | Self::Correction => SubsystemId::CONTROL,
            Self::Lockout => SubsystemId::GENERAL,
        }
    }

    /// The bits of the groups that a subsystem owns.
    pub(super) const fn owned_by(id: SubsystemId) -> u32 {
        let Some(index) = table_index(id) else { return 0 };
        let own = Self::Subsystem(index).bit();
        match id {
            SubsystemId::GENERAL => own | Self::Lockout.bit(),
            // Programs, trajectories and the correction table follow each other.
            SubsystemId::CONTROL => own | (Self::Lockout.bit() - Self::Program(0).bit()),
            _ => own,
        }
    }

    pub(super) fn of(param: Param) -> Self {
        let offset = |first: Param| (param as u8).wrapping_sub(first as u8);
        if offset(Param::ControlProgram0) < PROGRAMS {
            Self::Program(offset(Param::ControlProgram0))
        } else if offset(Param::ControlTrajectory0) < TRAJECTORIES {
            Self::Trajectory(offset(Param::ControlTrajectory0))
        } else {
            Self::Subsystem(table_index(param.subsystem()).unwrap_or(0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §3.3.1/1: what is reported to a group's owner is what is looked for on its behalf.
    #[test]
    fn groups_and_their_owners_agree() {
        for id in SubsystemId::TABLE {
            let groups = (0..Group::COUNT).map(Group::from_index);
            let own = groups.filter(|group| group.owner() == id);
            assert_eq!(Group::owned_by(id), own.fold(0, |bits, group| bits | group.bit()), "{id}");
        }
        assert_eq!(Group::owned_by(SubsystemId::ALL), 0);
    }
}
