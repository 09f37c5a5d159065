//! The power-safe store on a simulated NOR flash: what it keeps, power cuts at every step of
//! every operation and of every recovery, random ones, what fails once, flipped bits, wear.

mod behaviour;
mod check;
mod cuts;
mod flash;
mod once;
mod random;
mod rot;
mod wear;
