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
mod batch;
pub mod blocking;
mod client;
mod drive;
mod error;
mod find_out;
mod jog;
mod monitor;
mod plan;
mod saving;
pub mod session;
mod shared;
mod status;
mod subscription;
mod task;
pub mod transport;
pub mod url;

pub use answers::{AnswerBuf, Answers, RequestBuf};
pub use batch::Progress;
pub use client::Client;
pub use drive::Drive;
pub use error::{Cause, Error, Lang};
pub use find_out::find_out;
pub use jog::Jog;
pub use monitor::Monitor;
pub use saving::Saved;
pub use session::jog::{Hold, JogEnd, Reason, Toward};
pub use session::statistics::LinkStatistics;
pub use session::{Config, Direction, Stats, Traced, Verdict};
pub use shared::{LinkEvent, LinkState};
pub use status::{MonitorStatus, StatusSample, StatusSubscription, StatusUpdate};
pub use subscription::{Sample, Subscription, UPDATES_MAX, Update};
pub use url::{Addresses, Echo, Endpoint, Framing, Rs485, SerialLine, UrlError};
