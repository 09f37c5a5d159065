//! Tests of the client on virtual time, in one program: it is linked once. Those that need a real
//! clock are in `real`, so that these, which take all the time that they can get, do not delay them.

#[path = "../fake/mod.rs"]
mod fake;
#[path = "../fake/numbered.rs"]
mod numbered;

mod backup;
mod batch;
mod bus;
mod cancel;
mod check;
mod doctor;
mod held;
mod jog;
mod lead;
mod line;
mod memory;
mod processes;
mod radio;
mod refusal;
mod saving;
mod silence;
mod stop_beside;
mod subscribe;
mod update;
mod urgent;
