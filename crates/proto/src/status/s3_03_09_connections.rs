//! §3.3.9 «Флаги состояния ExternalConn, Radio»: ConnLost has a meaning of its own.

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of ExternalConn or Radio (§3.3, §3.3.9), 4 bytes.
    ConnStatus [flags: ConnFlags] {}
}

flag_class! {
    /// §3.3.9 ExternalConn, Radio: no flags of their own; ConnLost means that no client controls.
    ConnFlags "3.3.9", ConnLost Notice Connection, width 1;
}
