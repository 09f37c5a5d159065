//! §3 «Перечень поддерживаемых запросов»: the table of requests, and the bus controller's services.

use super::Key;
use crate::id::{RequestId, SubsystemId};
use crate::request::{
    bus, s3_01_move, s3_02_stop, s3_03_getstatus, s3_04_getparam, s3_05_setparam,
    s3_06_correction_table, s3_07_retrieve_limits, s3_08_open, s3_09_close, s3_10_deploy,
    s3_11_wrap, s3_12_restart, s3_13_justify, s3_14_quench, s3_15_trajectory, s3_16_seek,
    s3_17_switch_limits, s3_18_lockout, s3_19_clean_flash, s3_20_crash_data, s3_21_hotbeds,
};

/// Source of what is known about a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Origin {
    /// Follows from the document.
    Read,
    /// Seen in a public bus adapter for the same family of devices.
    Observed,
    /// Named by the document, but its data are our own design.
    Ours,
}

/// Description of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RequestInfo {
    /// Its identifier.
    pub id: RequestId,
    /// The document's name.
    pub name: &'static str,
    /// The document's section that describes it.
    pub section: &'static str,
    /// Source of the description.
    pub origin: Origin,
    /// Possible addressees; empty when every subsystem is one.
    pub addressees: &'static [SubsystemId],
    /// A short title.
    pub title: Key,
    /// What the request does.
    pub meaning: Key,
}

/// Every request of §3, in the order of its sections, then the bus controller's services.
pub static REQUESTS: [RequestInfo; 24] = [
    s3_01_move::INFO,
    s3_02_stop::INFO,
    s3_03_getstatus::INFO,
    s3_04_getparam::INFO,
    s3_05_setparam::INFO,
    s3_06_correction_table::INFO,
    s3_07_retrieve_limits::INFO,
    s3_08_open::INFO,
    s3_09_close::INFO,
    s3_10_deploy::INFO,
    s3_11_wrap::INFO,
    s3_12_restart::INFO,
    s3_13_justify::INFO,
    s3_14_quench::INFO,
    s3_15_trajectory::INFO,
    s3_16_seek::INFO,
    s3_17_switch_limits::INFO,
    s3_18_lockout::INFO,
    s3_19_clean_flash::INFO,
    s3_20_crash_data::INFO,
    s3_21_hotbeds::INFO,
    bus::ACCESS_GRANTED,
    bus::GET_NETWORK_STATUS,
    bus::GET_LOG,
];
