//! The controlling side of robotic fire monitors.
//!
//! ```text
//! Monitor::move_to ─▶ Client::request ─▶ Session (no I/O, no clock) ─▶ transport::Link ─▶ the wire
//! ```
//!
//! [`Monitor`] has a method for each request, typed. [`Client`] sends any request, several in a
//! frame if wanted, and runs a [`session::Session`] on a task of its own. The session decides what
//! is sent when and which answer is believed: it can be driven on virtual time, or by another
//! runtime.
//!
//! ```no_run
//! # async fn example() -> Result<(), lafet_client::Error> {
//! use lafet_client::Monitor;
//! use lafet_proto::SubsystemId;
//!
//! let monitor = Monitor::connect(&"tcp://192.168.1.50?addr=1".parse()?).await?;
//! monitor.move_to(SubsystemId::HORIZONTAL, 1200).await?;
//! println!("{:?}", monitor.status_all().await?.horizontal);
//! # Ok(())
//! # }
//! ```

mod answers;
mod client;
mod error;
mod monitor;
mod plan;
mod saving;
pub mod session;
mod task;
pub mod transport;
pub mod url;

pub use answers::{AnswerBuf, Answers, RequestBuf};
pub use client::Client;
pub use error::{Cause, Error, Lang};
pub use monitor::{Monitor, MonitorStatus};
pub use saving::Saved;
pub use session::{Config, Direction, Stats, Traced, Verdict};
pub use url::{Addresses, Endpoint, Framing, UrlError};
