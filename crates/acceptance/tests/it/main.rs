//! The tester against installations behind a real hub: good ones, and ones with exactly one thing wrong.

mod bench;
mod good;
mod outlet;
#[path = "../../../hub/tests/it/modbus/panel.rs"]
#[expect(dead_code, reason = "the tests of the hub use the rest")]
mod panel;
mod people;
mod person;
mod records;
mod stopped;
mod wrong;
