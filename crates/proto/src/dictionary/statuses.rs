//! §2 «Формат заголовка запроса/ответа»: the table of statuses.

use super::{Key, key};
use crate::id::Status;

/// Description of a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StatusInfo {
    /// The status.
    pub status: Status,
    /// The document's name.
    pub name: &'static str,
    /// What the status means (§2).
    pub meaning: Key,
    /// What the sender of the request should do.
    pub remedy: Key,
}

macro_rules! statuses {
    ($($konst:ident $name:literal;)+) => {
        /// Every status of §2, in its order.
        pub static STATUSES: [StatusInfo; [$($name),+].len()] = [$(StatusInfo {
            status: Status::$konst,
            name: $name,
            meaning: key!("status-", $name, "-meaning"),
            remedy: key!("status-", $name, "-remedy"),
        }),+];
    };
}

statuses! {
    OK "Ok";
    ACCEPTED "Accepted";
    NEED_CONFIRM "NeedConfirm";
    DENIED "Denied";
    MODULE_NOT_EXIST "ModuleNotExist";
    MODULE_FAULT "ModuleFault";
    BUSY "Busy";
    WRONG_REQUEST "WrongRequest";
    WRONG_DATA "WrongData";
    NO_ROOM "NoRoom";
    INVALID_ID "InvalidId";
    INVALID_VALUE "InvalidValue";
    ACCESS_DENIED "AccessDenied";
    SYSTEM_FAULT "SystemFault";
    INCOMPLETE_CONFIG "IncompleteConfig";
    NOT_CACHED "NotCached";
    CACHED "Cached";
    UNIMPLEMENTED "Unimplemented";
    NOT_SUPPORTED "NotSupported";
}
