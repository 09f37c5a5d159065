//! What must always hold, whatever is requested and whatever fails.

use crate::interlock::Broken;
use std::fmt;

/// Defines the laws: the enumeration, the texts and the list of all.
macro_rules! laws {
    ($($law:ident $text:literal;)*) => {
        /// A law of the interlock.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Law { $(#[doc = $text] $law,)* }

        impl Law {
            /// All laws.
            pub const ALL: &[Self] = &[$(Self::$law,)*];

            /// Statement of the law.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$law => $text,)* }
            }
        }
    };
}

laws! {
    WaterOnlyDeployed "no water while wrapped or between the positions";
    NoOpeningWhereForbidden "no valve opens while wrapped, between, turning, searching, blocked or locked out";
    NoAimingUnlessDeployed "nothing aims unless deployed";
    NoFoldingWithWater "the barrel is not folded with water on";
    LockedOutIsStill "nothing moves or opens when locked out, and open valves close";
    LockoutStays "the lockout holds until it is switched off, over resets and power loss";
    WithinLimits "no motion beyond the limits while they are on";
    NothingUnasked "nothing starts that was not asked for since it last ended or was stopped";
    OneAnswer "every request is answered, by the one or the ones it concerns";
    DeniedWhereDue "what the state forbids is Denied, by the subsystem whose state it is";
    OnePosition "wrapped, deploying, deployed and wrapping exclude each other, and the switches agree";
    StopStops "a cycle after Stop All or Lockout no drive turns and no valve opens";
}

/// The set of broken laws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Laws(u16);

impl Laws {
    /// Adds the law if it does not hold.
    pub fn judge(&mut self, law: Law, holds: bool) {
        if !holds {
            self.0 |= 1 << law as u8;
        }
    }

    /// Adds the laws that a broken rule of the interlock concerns.
    pub fn add(&mut self, rule: Broken) {
        let laws: &[Law] = match rule {
            Broken::Flooded => &[Law::WaterOnlyDeployed],
            Broken::OpensStowed(_) | Broken::OpensBlocked(_) => &[Law::NoOpeningWhereForbidden],
            Broken::OpensLockedOut(_) => &[Law::NoOpeningWhereForbidden, Law::LockedOutIsStill],
            Broken::MovesLockedOut(_) | Broken::LeftOpenLockedOut(_) => &[Law::LockedOutIsStill],
            Broken::MovesStopped(_) | Broken::OpensStopped(_) => &[Law::StopStops],
            Broken::AimsStowed(_) => &[Law::NoAimingUnlessDeployed],
            Broken::StowsWithWater(_) => &[Law::NoFoldingWithWater],
            Broken::LeavesLimits(..) | Broken::IntoEndSwitch(_) => &[Law::WithinLimits],
            Broken::DrivenBeforeSettled => &[Law::NothingUnasked],
        };
        laws.iter().for_each(|law| self.judge(*law, false));
    }

    /// Whether the law is in the set.
    pub const fn contains(self, law: Law) -> bool {
        self.0 >> law as u8 & 1 == 1
    }

    /// Whether no law is broken.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Laws {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let broken = Law::ALL.iter().filter(|law| self.contains(**law));
        broken
            .enumerate()
            .try_for_each(|(i, law)| write!(f, "{}{}", if i > 0 { "; " } else { "" }, law.text()))
    }
}
