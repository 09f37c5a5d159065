//! The log of the hub, on standard error.

use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

use crate::aside::Aside;
use crate::failure::Failure;

/// Environment variable of the log filter: `LAFET_LOG=info`, `LAFET_LOG=lafet_hub=debug`.
const LOG: &str = "LAFET_LOG";

/// Logs as text or as JSON, until the result is dropped. Nothing waits for the reader of the log: lines
/// that it does not take are left out, and counted.
pub fn log(json: bool, usual: &str) -> Result<Aside, Failure> {
    let aside = Aside::start()?;
    let queue = aside.queue();
    let wanted = std::env::var(LOG).unwrap_or_else(|_| usual.to_owned());
    let targets = wanted.parse::<Targets>().unwrap_or_default();
    let layer = tracing_subscriber::fmt::layer().with_writer(move || queue.clone());
    let registry = tracing_subscriber::registry();
    // A logger that was set before stays.
    _ = if json {
        registry.with(layer.json().with_filter(targets)).try_init()
    } else {
        registry.with(layer.with_target(false).with_filter(targets)).try_init()
    };
    // A panic writes by itself, and would wait for the reader.
    std::panic::set_hook(Box::new(|panic| tracing::error!("{panic}")));
    Ok(aside)
}
