//! One file per command.

#[cfg(unix)]
pub mod chip;
pub mod faults;
#[cfg(unix)]
pub mod load;
pub mod model;
pub mod noise;
pub mod pace;
pub mod physics;
pub mod replay;
pub mod swarm;
pub mod years;
