//! Tests of the program as a user runs it, in one program: it is linked once.
//!
//! Programs of their own are `cut`, which starts dozens of processes at a time, and `held`, which
//! measures how far the barrel turns until a motion ends.

#[path = "../support/mod.rs"]
mod support;

mod backup;
mod between;
#[cfg(unix)]
mod bus;
mod calibrate;
#[cfg(target_os = "linux")]
mod cameras;
#[cfg(unix)]
mod clients;
mod commands;
mod conform;
mod coverage;
mod decode;
mod demo;
#[cfg(target_os = "linux")]
mod door;
mod exercise;
mod insist;
mod install;
mod installed;
#[cfg(unix)]
mod jog;
mod json;
mod kill;
#[cfg(unix)]
mod late;
#[cfg(unix)]
mod listening;
mod odd;
mod plan;
#[cfg(target_os = "linux")]
mod port;
mod processes;
mod program;
mod record;
#[cfg(target_os = "linux")]
mod room;
mod scan;
mod server;
#[cfg(target_os = "linux")]
mod service;
mod shell;
mod site;
mod teach;
mod throw;
mod top;
mod try_next;
mod tune;
#[cfg(unix)]
mod tutorial;
mod update;
