//! Updating: images, the decision of the start, receiving, power cuts, what fails once.

mod bench;
#[path = "../../../device/tests/common/mod.rs"]
mod common;
mod cuts;
mod decision;
#[allow(dead_code, reason = "the flash of the store's tests, of which these need a part")]
#[path = "../../../device/tests/store/flash.rs"]
mod flash;
mod images;
mod monitor;
mod once;
mod orders;
mod receiving;
