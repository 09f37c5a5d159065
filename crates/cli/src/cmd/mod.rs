//! One file per subcommand, or per family of them.

pub mod backup;
pub mod bus;
pub mod bus_ask;
pub mod calibrate;
#[cfg(unix)]
pub mod chip;
pub mod conform;
pub mod coverage;
pub mod decode;
pub mod demo;
pub mod dissector;
pub mod doctor;
pub mod exercise;
pub mod install;
pub mod jog;
pub mod life;
pub mod limits;
pub mod motion;
pub mod param;
pub mod ports;
pub mod program;
pub mod quench;
pub mod record;
pub mod replay;
pub mod scan;
pub mod schema;
pub mod seek;
pub mod send;
pub mod serve;
pub mod service;
pub mod shell;
pub mod sim;
pub mod status;
pub mod teach;
pub mod top;
pub mod watch;
