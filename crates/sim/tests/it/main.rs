//! Tests of the simulator, in one program: it is linked once.

mod arrival;
mod ballistics;
mod bounds;
mod disturbed;
mod flash_use;
mod power_cuts;
mod rest;
mod scenarios;
mod trace;
mod update;
mod waiting;
mod water_hammer;
