//! §1 «Общие сведения»: the table of subsystems.

use super::{Key, key};
use crate::id::SubsystemId;

/// Description of a subsystem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SubsystemInfo {
    /// Its identifier.
    pub id: SubsystemId,
    /// The document's name.
    pub name: &'static str,
    /// A short title.
    pub title: Key,
    /// What the subsystem is responsible for.
    pub meaning: Key,
}

macro_rules! subsystems {
    ($($konst:ident $name:literal;)+) => {
        /// Every subsystem of §1, in its order, All and Motors first.
        pub static SUBSYSTEMS: [SubsystemInfo; [$($name),+].len()] = [$(SubsystemInfo {
            id: SubsystemId::$konst,
            name: $name,
            title: key!("subsystem-", $name, "-title"),
            meaning: key!("subsystem-", $name, "-meaning"),
        }),+];
    };
}

subsystems! {
    ALL "All";
    MOTORS "Motors";
    GENERAL "General";
    CLIMATICS "Climatics";
    VERTICAL "Vertical";
    HORIZONTAL "Horizontal";
    NOZZLE "Nozzle";
    VALVE1 "Valve1";
    VALVE2 "Valve2";
    CONTROL "Control";
    DETECTOR "Detector";
    DEPLOYER "Deployer";
    EXTERNAL_CONN "ExternalConn";
    RADIO "Radio";
    BUTTONS "Buttons";
    EXT_BUTTONS "ExtButtons";
}
