//! Who commands a monitor, and when a motion by hand ends. All but [`motion`] and [`tuning`] is without I/O and clock.

pub mod authority;
pub mod beats;
pub mod jogs;
pub mod motion;
pub mod tuning;
