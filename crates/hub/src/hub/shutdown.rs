//! The end of the hub, as its tasks wait for it.

use tokio::sync::watch;

/// Waits for the end of the hub.
#[derive(Clone, Debug)]
pub struct Shutdown(watch::Receiver<bool>);

impl Shutdown {
    pub(super) fn new(of: watch::Receiver<bool>) -> Self {
        Self(of)
    }

    /// Returns when the hub ends. Cancel safe.
    pub async fn requested(&mut self) {
        _ = self.0.wait_for(|requested| *requested).await;
    }
}
