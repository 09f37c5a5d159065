//! §3.3 «GetStatus», §3.7, §3.20, §3.21: the structures that answers carry.
//!
//! All are packed and little-endian; each has `SIZE`, `LAYOUT`, `from_bytes` and `to_bytes`. A
//! state (§3.3) is in the file of its flags, the others are in that of their request.

pub(crate) mod s3_03_01_common_flags;
pub(crate) mod s3_03_02_general;
pub(crate) mod s3_03_03_climatics;
pub(crate) mod s3_03_04_drives;
pub(crate) mod s3_03_05_valves;
pub(crate) mod s3_03_06_control;
pub(crate) mod s3_03_07_detector;
pub(crate) mod s3_03_08_deployer;
pub(crate) mod s3_03_09_connections;
pub(crate) mod s3_03_10_buttons;
pub(crate) mod structure;

pub use crate::request::s3_07_retrieve_limits::Limits;
pub use crate::request::s3_20_crash_data::{FaultArch, FaultInfo};
pub use crate::request::s3_21_hotbeds::Hotbed;
pub use s3_03_02_general::GeneralStatus;
pub use s3_03_03_climatics::ThermoStatus;
pub use s3_03_04_drives::DriveStatus;
pub use s3_03_05_valves::ValveStatus;
pub use s3_03_06_control::ControlStatus;
pub use s3_03_07_detector::DetectorStatus;
pub use s3_03_08_deployer::DeployerStatus;
pub use s3_03_09_connections::ConnStatus;
pub use s3_03_10_buttons::ButtonsStatus;

pub(crate) use structure::structure;
