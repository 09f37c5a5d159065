//! The playground: a simulated monitor, and an explanation of every byte that goes to and fro.
//!
//! ```text
//! page ── JSON ── call ── Playground ── lafet_sim::Sim (the real Device in its world)
//!                            ├─ Session ⇄ fragment of a URL
//!                            ├─ Anatomy: bytes ⇄ fields
//!                            ├─ Walk: who of the chain let a request pass, refused or executed it
//!                            └─ Scene: what a picture of the monitor needs
//! ```
//!
//! Everything is a function of the session: the same on every machine, natively and as WebAssembly.
#![forbid(unsafe_code)]

mod anatomy;
mod call;
mod dictionary;
mod examples;
mod fault;
mod playground;
mod scene;
mod session;
mod view;
mod walk;

pub use call::{COMMAND_MAX, call};
pub use examples::{EXAMPLES, Example};
pub use playground::Playground;
pub use session::{Action, FRAGMENT_MAX, Session, Setup, StepsError};
pub use view::Link;
