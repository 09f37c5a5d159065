//! §3.3.1 «Общие флаги состояния»: bits 0–15, the same for every subsystem.

use crate::flags::flag_class;

flag_class! {
    /// §3.3.1 What the status words of all subsystems have in common.
    CommonFlags "3.3.1";
}
