//! A camera of a site, watched by a process of its own.
//!
//! ```text
//!  camera ──RTSP, TCP──▶ process: retina ──▶ wire ══pipe══▶ wire ──▶ hub
//!                          ▲                                          │
//!                          └───────────── settings, and the pipe's end ┘
//! ```
//!
//! What a camera sends is parsed in the process alone. The hub starts it, reads bounded messages from it, ends it when
//! it is silent or too large, and starts it again; a stream that breaks the parser ends nothing else.

#[cfg(feature = "camera")]
mod camera;
#[cfg(feature = "camera")]
mod clock;
#[cfg(feature = "camera")]
mod process;
pub mod wire;

#[cfg(feature = "camera")]
pub use process::run;
