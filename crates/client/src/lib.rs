//! The controlling side of robotic fire monitors.
//!
//! ```text
//! Monitor, Drive, Jog ─▶ Client ─▶ Line ─▶ Session for each address ─▶ transport::Link ─▶ the wire
//! typed                  any       order   which answers are valid
//!                        request   of use  (both: no I/O, no clock)
//! ```
//!
//! [`Monitor`] has a typed method for each request. [`Client`] sends any request, several in a
//! frame if needed; the callers that wait serve the link, and a task while none does. The core ([`session::line::Line`],
//! [`session::Session`]) decides what is sent when and which answers are valid; it can run on
//! virtual time, or in another runtime. [`blocking`] has the same for programs without async.
//!
//! # Features
//!
//! Without features there is only the core ([`session`], and [`bus`] without its driver), which
//! needs `lafet-proto` and the standard library. `client`: everything that does I/O, on Tokio.
//! `backup`: parameters of a monitor as a TOML file. Both are on by default.
//!
//! # A monitor
//!
//! ```no_run
//! # async fn example() -> Result<(), lafet_client::Error> {
//! use lafet_client::Monitor;
//! use lafet_proto::SubsystemId;
//!
//! let monitor = Monitor::connect(&"tcp://192.168.1.50?addr=1".parse()?).await?;
//! monitor.deploy().await?;
//! monitor.horizontal().move_to(1200).await?;
//! println!("{:?}", monitor.status_all().await?.horizontal);
//! println!("{:?}", monitor.param(SubsystemId::VERTICAL, "Speed").await?);
//! println!("{:?}", monitor.hotbeds().await?);
//! # Ok(())
//! # }
//! ```
//!
//! # Several monitors on an RS-485 line, polled
//!
//! ```no_run
//! # async fn example() -> Result<(), lafet_client::Error> {
//! use std::time::Duration;
//! use lafet_client::{LinkEvent, Monitor};
//!
//! let url = "serial:///dev/ttyUSB0?baud=57600&echo=verify&turnaround=2&addr=1";
//! let first = Monitor::connect(&url.parse()?).await?;
//! let second = first.at(2)?;
//! let states = [first.watch(Duration::from_millis(500))?, second.watch(Duration::from_millis(500))?];
//! let mut events = first.client().events();
//! while let Ok(event) = events.recv().await {
//!     if let LinkEvent::Statistics(figures) = event {
//!         println!("{figures}");
//!         for state in states.iter().filter_map(|state| state.latest()) {
//!             println!("{:?}, {:?} old, stale: {}", state.status.general, state.age, state.stale);
//!         }
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # A motion that is held
//!
//! ```no_run
//! # async fn example(monitor: lafet_client::Monitor) -> Result<(), lafet_client::Error> {
//! # async fn still_pressed() -> bool { false }
//! use lafet_client::Toward;
//!
//! let jog = monitor.vertical().jog(Toward::UP)?;
//! while still_pressed().await && jog.renew() {}
//! println!("{:?}", jog.release().await);
//! # Ok(())
//! # }
//! ```
//!
//! # Many parameters over a slow line
//!
//! ```no_run
//! # async fn example(monitor: lafet_client::Monitor) {
//! use lafet_proto::param::Param;
//!
//! let values = monitor
//!     .params_with(&Param::ALL, |progress| eprintln!("{}/{}", progress.done, progress.total))
//!     .await;
//! for (param, values) in Param::ALL.iter().zip(values) {
//!     match values {
//!         Ok(values) => println!("{param:?} {values:?}"),
//!         Err(error) => println!("{param:?}: {error}"),
//!     }
//! }
//! # }
//! ```

#![warn(clippy::missing_errors_doc)]

mod answers;
pub mod bus;
mod deviation;
mod error;
mod os_text;
mod outcome_check;
mod port_error;
pub mod refusal;
pub mod session;
mod url_error;
mod usb;

#[cfg(feature = "backup")]
pub mod backup;
#[cfg(feature = "client")]
mod batch;
#[cfg(feature = "client")]
pub mod blocking;
#[cfg(feature = "client")]
mod client;
#[cfg(feature = "client")]
pub mod doctor;
#[cfg(feature = "client")]
mod drive;
#[cfg(feature = "client")]
mod engine;
#[cfg(feature = "client")]
mod exchange;
#[cfg(feature = "client")]
mod jog;
#[cfg(feature = "client")]
mod lead;
#[cfg(feature = "client")]
mod monitor;
#[cfg(feature = "client")]
pub mod note;
#[cfg(feature = "client")]
pub mod overhear;
#[cfg(feature = "client")]
mod plan;
#[cfg(feature = "client")]
pub mod ports;
#[cfg(feature = "client")]
pub mod prober;
#[cfg(feature = "client")]
mod saving;
#[cfg(feature = "client")]
pub mod scan;
#[cfg(feature = "client")]
mod shared;
#[cfg(feature = "client")]
mod status;
#[cfg(feature = "client")]
mod subscription;
#[cfg(feature = "client")]
mod task;
#[cfg(feature = "client")]
pub mod teach;
#[cfg(feature = "client")]
pub mod transport;
#[cfg(feature = "client")]
pub mod tune;
#[cfg(feature = "client")]
mod turn;
#[cfg(feature = "client")]
pub mod update;
#[cfg(feature = "client")]
pub mod url;

pub use answers::{AnswerBuf, Answers, RequestBuf};
pub use deviation::Deviation;
pub use error::{Cause, Error, Explained, Lang};
pub use lafet_texts::{Undecodable, parse_error_text};
pub use os_text::{SystemError, os_text};
pub use outcome_check::outcome_check;
pub use port_error::{CannotSwitch, Holder, PortError};
pub use session::jog::{Hold, JogEnd, Reason, Toward};
pub use session::medium::{Addresses, Echo, Framing, Role};
pub use session::statistics::LinkStatistics;
pub use session::{CheckMode, Config, Direction, Stats, Traced, Verdict};
pub use url_error::UrlError;
pub use usb::Usb;

#[cfg(feature = "client")]
pub use {
    batch::Progress,
    client::Client,
    drive::Drive,
    jog::Jog,
    monitor::Monitor,
    saving::Saved,
    shared::{LinkEvent, LinkState},
    status::{MonitorStatus, StatusSample, StatusSubscription, StatusUpdate},
    subscription::{Sample, Subscription, UPDATES_MAX, Update},
    url::{Behaviour, Endpoint, Rs485, SerialLine},
};

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
