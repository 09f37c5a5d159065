//! Updating: images, the decision of the start, receiving, power cuts.

mod bench;
mod cuts;
mod decision;
#[allow(dead_code, reason = "the flash of the store's tests, of which these need a part")]
#[path = "../../../device/tests/store/flash.rs"]
mod flash;
mod images;
mod orders;
mod receiving;
