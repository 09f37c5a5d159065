//! Tasks that run as long as the hub does, and what becomes of it when one does not.

use std::time::Duration;

use tokio::task::{JoinError, JoinHandle, JoinSet};
use tokio::time::sleep;

use super::Hub;

/// Pause before what has ended by a panic is started again.
const AGAIN: Duration = Duration::from_secs(1);

impl Hub {
    /// Runs what the hub cannot be without. If it ends, by a panic, so does the hub: started again it is whole, and
    /// half of it would not end motions in time.
    pub(crate) fn always(
        &self,
        what: &'static str,
        task: impl Future<Output = ()> + Send + 'static,
    ) {
        let (hub, task) = (self.clone(), tokio::spawn(task));
        tokio::spawn(async move {
            let ended = task.await;
            if !hub.ends() && ended.as_ref().err().is_none_or(JoinError::is_panic) {
                tracing::error!(what, "a part of the hub has ended: so does the hub");
                hub.0.failed.send_replace(true);
            }
        });
    }

    /// Runs what talks to others. If it ends by a panic, it is started again: what one device sends must not
    /// end the hub for all others.
    pub(crate) fn again<F: Future<Output = ()> + Send + 'static>(
        &self,
        what: &'static str,
        task: impl Fn() -> F + Send + Sync + 'static,
    ) -> JoinHandle<()> {
        let hub = self.clone();
        tokio::spawn(async move {
            // Dropped, they end.
            let mut tasks = JoinSet::new();
            loop {
                tasks.spawn(task());
                if all_end(&mut tasks).await || hub.ends() {
                    return;
                }
                tracing::error!(what, "it is started again");
                sleep(AGAIN).await;
            }
        })
    }

    /// Waits until something that always runs has ended.
    pub async fn failed(&self) {
        let mut failed = self.0.failed.subscribe();
        _ = failed.wait_for(|failed| *failed).await;
    }
}

/// Waits until all have ended, or one of them by a panic: then `false`, and the others are ended.
pub async fn all_end(tasks: &mut JoinSet<()>) -> bool {
    while let Some(ended) = tasks.join_next().await {
        if ended.is_err_and(|error| error.is_panic()) {
            tasks.abort_all();
            while tasks.join_next().await.is_some() {}
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use std::future::pending;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use tokio::time::timeout;

    use super::*;

    const PATIENCE: Duration = Duration::from_secs(60);

    #[tokio::test(start_paused = true)]
    async fn the_hub_ends_with_what_it_cannot_be_without() {
        let (hub, _) = Hub::of_one(None);
        hub.always("goes on", pending());
        assert!(timeout(PATIENCE, hub.failed()).await.is_err(), "nothing has ended");
        hub.always("fails", async { panic!("as a test") });
        assert!(timeout(PATIENCE, hub.failed()).await.is_ok());
    }

    #[tokio::test(start_paused = true)]
    async fn what_talks_to_others_is_started_again() {
        let (hub, _) = Hub::of_one(None);
        let count = Arc::new(AtomicU32::new(0));
        let own = count.clone();
        let run = hub.again("fails twice", move || {
            let times = own.fetch_add(1, Ordering::Relaxed);
            async move { assert!(times >= 2, "as a test") }
        });
        timeout(PATIENCE, run).await.unwrap().unwrap();
        assert_eq!(count.load(Ordering::Relaxed), 3);
        assert!(timeout(PATIENCE, hub.failed()).await.is_err(), "the hub goes on");
    }

    #[tokio::test]
    async fn one_that_fails_takes_the_others_with_it() {
        let mut tasks = JoinSet::new();
        tasks.spawn(async {});
        assert!(all_end(&mut tasks).await);
        tasks.spawn(pending());
        tasks.spawn(async { panic!("as a test") });
        assert!(!all_end(&mut tasks).await);
        assert!(tasks.is_empty());
    }
}
