//! Which subsystems a monitor has, and of which kind (§1: configuration decides the chain).

use crate::image::{AXES, Axis, VALVES, ValveNo};
use lafet_proto::SubsystemId;
use lafet_proto::param::Param;

/// A set of subsystems: bit n is entry n of the table of §1, as in the parameter Chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainSet(u16);

impl ChainSet {
    /// All 14.
    pub const ALL: Self = Self(0x3FFF);

    /// The set of these bits; General is always in it.
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits & Self::ALL.0 | 1)
    }

    /// The set of these bits and no others.
    pub(crate) const fn exactly(bits: u16) -> Self {
        Self(bits & Self::ALL.0)
    }

    /// What is in both.
    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Its subsystems in the order of the chain.
    pub(crate) fn in_chain(self) -> impl Iterator<Item = SubsystemId> {
        let places = (0..SubsystemId::CHAIN.len()).rev();
        let chain = SubsystemId::CHAIN.into_iter().zip(places);
        chain.filter(move |(_, place)| self.0 >> place & 1 != 0).map(|(id, _)| id)
    }

    /// This set with one more.
    pub(crate) const fn with(self, id: SubsystemId) -> Self {
        match table_index(id) {
            Some(index) => Self(self.0 | 1 << index),
            None => self,
        }
    }

    /// Its bits.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// This set without some subsystems.
    pub const fn without(self, ids: &[SubsystemId]) -> Self {
        let mut bits = self.0;
        let mut rest = ids;
        while let [id, tail @ ..] = rest {
            if let Some(index) = table_index(*id) {
                bits &= !(1 << index);
            }
            rest = tail;
        }
        Self::from_bits(bits)
    }

    /// Whether a subsystem is in the chain.
    pub const fn contains(self, id: SubsystemId) -> bool {
        match table_index(id) {
            Some(index) => self.0 >> index & 1 != 0,
            None => false,
        }
    }
}

/// Place of a subsystem in the table of §1.
pub(crate) const fn table_index(id: SubsystemId) -> Option<u8> {
    Some(match id {
        SubsystemId::GENERAL => 0,
        SubsystemId::CLIMATICS => 1,
        SubsystemId::VERTICAL => 2,
        SubsystemId::HORIZONTAL => 3,
        SubsystemId::NOZZLE => 4,
        SubsystemId::VALVE1 => 5,
        SubsystemId::VALVE2 => 6,
        SubsystemId::CONTROL => 7,
        SubsystemId::DETECTOR => 8,
        SubsystemId::DEPLOYER => 9,
        SubsystemId::EXTERNAL_CONN => 10,
        SubsystemId::RADIO => 11,
        SubsystemId::BUTTONS => 12,
        SubsystemId::EXT_BUTTONS => 13,
        _ => return None,
    })
}

/// How a drive is connected (parameter DriveType; §3.17 distinguishes the three).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DriveKind {
    /// 0: driven by the control system, with an encoder.
    Encoder,
    /// 1: a remote unit on the internal bus.
    Remote,
    /// 2: with limit switches.
    LimitSwitches,
}

impl DriveKind {
    pub(crate) const fn from_param(value: i32) -> Self {
        match value {
            1 => Self::Remote,
            2 => Self::LimitSwitches,
            _ => Self::Encoder,
        }
    }
}

/// What a monitor is built of, as the factory sets it (ours). Parameters may change it later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Composition {
    /// Name of the profile.
    pub name: &'static str,
    /// The chain.
    pub chain: ChainSet,
    /// Kinds of the drives, by [`Axis`].
    pub drives: [DriveKind; AXES],
    /// Whether the valves are remote units, by [`ValveNo`].
    pub remote_valves: [bool; VALVES],
    /// Factory values that differ from the parameters' defaults.
    pub settings: &'static [(Param, i32)],
}

impl Composition {
    /// Everything: a fire robot with deployment and detector.
    pub const FULL: Self = Self {
        name: "full",
        chain: ChainSet::ALL,
        drives: [DriveKind::Encoder; AXES],
        remote_valves: [false; VALVES],
        settings: &[],
    };

    /// A remote-controlled monitor without Deployer, Detector and Valve2.
    pub const REMOTE: Self = Self {
        name: "remote",
        chain: ChainSet::ALL.without(&[
            SubsystemId::DEPLOYER,
            SubsystemId::DETECTOR,
            SubsystemId::VALVE2,
        ]),
        ..Self::FULL
    };

    /// A mini robot: no deployment, no foam, no climate, one button post; the nozzle has TRV.
    pub const MINI: Self = Self {
        name: "mini",
        chain: ChainSet::ALL.without(&[
            SubsystemId::DEPLOYER,
            SubsystemId::VALVE2,
            SubsystemId::CLIMATICS,
            SubsystemId::EXT_BUTTONS,
        ]),
        settings: &[(Param::NozzleTrvPosition, 5)],
        ..Self::FULL
    };

    /// Explosion-proof execution: drives and valves are remote units.
    pub const EX: Self = Self {
        name: "ex",
        drives: [DriveKind::Remote; AXES],
        remote_valves: [true; VALVES],
        ..Self::FULL
    };

    /// Drives with limit switches.
    pub const LIMIT_SWITCH: Self =
        Self { name: "limit-switch", drives: [DriveKind::LimitSwitches; AXES], ..Self::FULL };

    /// Every profile.
    pub const ALL: [Self; 5] = [Self::FULL, Self::REMOTE, Self::MINI, Self::EX, Self::LIMIT_SWITCH];

    /// The profile of a name.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        const ALL: &[Composition] = &Composition::ALL;
        ALL.iter().find(|profile| profile.name == name)
    }

    /// The factory value of a parameter that holds one number.
    pub fn factory_value(&self, param: Param) -> i32 {
        if let Some((_, value)) = self.settings.iter().find(|(known, _)| *known == param) {
            return *value;
        }
        let drive = |axis: Axis| match self.drives.get(axis as usize) {
            Some(DriveKind::Remote) => 1,
            Some(DriveKind::LimitSwitches) => 2,
            Some(DriveKind::Encoder) | None => 0,
        };
        let valve = |valve: ValveNo| self.remote_valves.get(valve as usize).copied().into_iter();
        match param {
            Param::GeneralChain => i32::from(self.chain.bits()),
            Param::VerticalDriveType => drive(Axis::Vertical),
            Param::HorizontalDriveType => drive(Axis::Horizontal),
            Param::NozzleDriveType => drive(Axis::Nozzle),
            Param::DeployerDriveType => drive(Axis::Deployer),
            Param::Valve1ValveType => valve(ValveNo::Valve1).map(i32::from).sum(),
            Param::Valve2ValveType => valve(ValveNo::Valve2).map(i32::from).sum(),
            other => other.default(),
        }
    }
}
