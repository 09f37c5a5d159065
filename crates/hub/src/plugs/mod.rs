//! Plugs: other systems that connect to the hub in a protocol of theirs. Each has sessions like a console,
//! and goes through the same authority, commands and audit log.

pub mod modbus;
