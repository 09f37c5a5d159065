//! §3.3 Flags that the tests use.

use lafet_proto::flags::{
    ClimaticsFlags, CommonFlags, ControlFlags, DeployerFlags, DetectorFlags, DriveFlags,
    GeneralFlags, ValveFlags,
};

pub const CONFIG_INVALID: u32 = CommonFlags::CONFIG_INVALID.bits();
pub const CONN_LOST: u32 = CommonFlags::CONN_LOST.bits();
pub const BAD_POWER: u32 = CommonFlags::BAD_POWER.bits();
pub const RESTARTING: u32 = CommonFlags::RESTARTING.bits();
pub const RESERVED: u32 = CommonFlags::RESERVED.bits();
pub const LOCKED_OUT: u32 = GeneralFlags::LOCKED_OUT.bits();
pub const BOX_HEAT: u32 = ClimaticsFlags::BOX_HEAT.bits();
pub const MOVE: u32 = DriveFlags::MOVE.bits();
pub const OVERLOAD: u32 = DriveFlags::AMPERAGE_OVERLOAD.bits();
pub const LIMITLESS: u32 = DriveFlags::LIMITLESS.bits();
pub const MIN_LIMIT: u32 = DriveFlags::MIN_LIMIT_REACHED.bits();
pub const MAX_LIMIT: u32 = DriveFlags::MAX_LIMIT_REACHED.bits();
pub const OPENING: u32 = ValveFlags::OPENING.bits();
pub const CLOSING: u32 = ValveFlags::CLOSING.bits();
pub const OPEN: u32 = ValveFlags::OPEN.bits();
pub const CLOSED: u32 = ValveFlags::CLOSED.bits();
pub const QUENCH: u32 = ControlFlags::QUENCH.bits();
pub const OUTSIDE: u32 = ControlFlags::OUTSIDE_LIMITS.bits();
pub const MODE_FAULT: u32 = ControlFlags::MODE_FAULT.bits();
pub const PAUSED: u32 = ControlFlags::PAUSED.bits();
pub const TRAJECTORY: u32 = ControlFlags::TRAJECTORY.bits();
pub const BALLISTICS: u32 = ControlFlags::TRAJECTORY_RANGE_FAULT.bits()
    | ControlFlags::TRAJECTORY_ANGLE_FAULT.bits()
    | ControlFlags::TRAJECTORY_CRC_FAULT.bits();
pub const SEARCHING: u32 = DetectorFlags::SEARCHING.bits();
pub const FOUND: u32 = DetectorFlags::FOUND.bits();
pub const DEVICE_FAULT: u32 = DetectorFlags::DEVICE_FAULT.bits();
pub const CANCELED: u32 = DetectorFlags::CANCELED.bits();
pub const BAD_SECTOR: u32 = DetectorFlags::BAD_SECTOR.bits();
pub const JUSTIFYING: u32 = DetectorFlags::JUSTIFYING.bits();
pub const JUSTIFIED: u32 = DetectorFlags::JUSTIFIED.bits();
pub const DEPLOYED: u32 = DeployerFlags::DEPLOYED.bits();
pub const DEPLOYING: u32 = DeployerFlags::DEPLOYING.bits();
pub const WRAPPED: u32 = DeployerFlags::WRAPPED.bits();
pub const WRAPPING: u32 = DeployerFlags::WRAPPING.bits();
/// The four state flags of Deployer.
pub const FOLD: u32 = DEPLOYED | DEPLOYING | WRAPPED | WRAPPING;
