//! Signs of life for systemd: `WatchdogSec` of the unit ends and restarts a hub that hangs.

use std::io;
use std::time::Duration;

use lafet_hub::Hub;

/// Reports that the hub is ready, and from then on that it works, if systemd asks for it: that is, as long as
/// its threads do work, its clock goes on, and its zone controller, if it has one, is at work.
///
/// # Errors
///
/// No thread can be started.
#[cfg(target_os = "linux")]
pub fn start(runtime: &tokio::runtime::Handle, hub: &Hub) -> io::Result<()> {
    use sd_notify::NotifyState;

    /// Signs of life within the time in which systemd expects one.
    const SIGNS: u32 = 4;
    const LEAST: Duration = Duration::from_millis(50);

    // Without systemd there is nothing to report to.
    _ = sd_notify::notify(&[NotifyState::Ready]);
    let Some(limit) = sd_notify::watchdog_enabled() else { return Ok(()) };
    let (runtime, hub, pause) = (runtime.clone(), hub.clone(), (limit / SIGNS).max(LEAST));
    let thread = std::thread::Builder::new().name("lafet-watchdog".into());
    let run = move || {
        let mut before = hub.ticks();
        loop {
            std::thread::park_timeout(pause);
            // A hub that ends does its last work without the clock.
            let ticks = hub.ticks();
            let goes_on = std::mem::replace(&mut before, ticks) != ticks || hub.ends();
            let zones = hub.zones_work() || hub.ends();
            if works(&runtime, limit) && goes_on && zones {
                _ = sd_notify::notify(&[NotifyState::Watchdog]);
            } else {
                tracing::error!("the hub does not go on: no sign of life is given");
            }
        }
    };
    thread.spawn(run).map(drop)
}

/// Whether the threads of the hub do what they are asked to within this time.
#[cfg(target_os = "linux")]
fn works(runtime: &tokio::runtime::Handle, within: Duration) -> bool {
    let (done, works) = std::sync::mpsc::sync_channel(1);
    runtime.spawn(async move { _ = done.send(()) });
    works.recv_timeout(within).is_ok()
}

/// Other systems have no systemd.
#[cfg(not(target_os = "linux"))]
pub fn start(_: &tokio::runtime::Handle, _: &Hub) -> io::Result<()> {
    Ok(())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn threads_that_all_hang_give_no_sign_of_life() {
        let mut builder = tokio::runtime::Builder::new_multi_thread();
        let runtime = builder.worker_threads(2).build().unwrap();
        assert!(works(runtime.handle(), Duration::from_secs(30)));
        let mut hang = Vec::new();
        let (hangs, hung) = channel();
        for _ in 0..2 {
            let (go, wait) = channel::<()>();
            hang.push(go);
            let hangs = hangs.clone();
            runtime.spawn(async move {
                _ = hangs.send(());
                _ = wait.recv();
            });
            hung.recv().unwrap();
        }
        assert!(!works(runtime.handle(), Duration::from_millis(100)));
        drop(hang);
        assert!(works(runtime.handle(), Duration::from_secs(30)));
    }
}
