//! One file per subcommand, or per family of them.

pub mod calibrate;
pub mod decode;
pub mod demo;
pub mod dissector;
pub mod exercise;
pub mod install;
pub mod jog;
pub mod life;
pub mod limits;
pub mod motion;
pub mod param;
pub mod quench;
pub mod record;
pub mod replay;
pub mod schema;
pub mod seek;
pub mod send;
pub mod serve;
pub mod service;
pub mod sim;
pub mod status;
pub mod watch;
