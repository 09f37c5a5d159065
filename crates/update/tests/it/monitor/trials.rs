//! A trial that is confirmed too early, and one that is ended by its sender.

use super::*;

/// A monitor on trial.
fn tried() -> Site {
    let mut site = Site::locked();
    assert!(site.send(&image(2, 512)));
    site.commit();
    assert!(site.report().trial);
    site
}

/// An image that has just started is not confirmed by any client: it may crash a moment later.
#[test]
fn a_trial_that_is_young() {
    let mut site = tried();
    let confirm = Order::Confirm { word: LONG_WORD };
    // Of its first 10 s one has passed.
    for _ in 0..8 {
        let (status, report) = site.order(&confirm);
        assert_eq!((status, report.trial, report.waits), (Status::BUSY, true, false));
        site.run_still(1000);
    }
    site.run_still(1500);
    assert!(!site.accepts(&confirm).trial);
}

/// A trial that is not to be confirmed is ended at once by its sender alone.
#[test]
fn a_trial_is_ended() {
    let abandon = Order::Abandon { digest: &DIGEST };
    let mut site = Site::locked();
    assert_eq!(site.order(&abandon).0, Status::INVALID_VALUE, "none is on trial");
    let mut site = tried();
    let report = site.accepts(&Order::Abandon { digest: &[7; DIGEST_LEN] });
    assert_eq!((report.trial, report.reason), (true, Refusal::Word.code()));
    site.run_still(1000);
    assert_eq!(site.starts, 1, "the word of another trial");
    assert_eq!(site.order(&abandon).0, Status::ACCEPTED);
    site.run_still(1000);
    let report = site.report();
    assert_eq!((site.starts, report.slot, report.trial, report.failed), (2, 1, false, true));
    assert_eq!(report.version, [1, 0, 0, 0]);
    assert!(site.is_locked());
    assert_eq!(site.order(&abandon).0, Status::INVALID_VALUE, "it has gone back");
    site.run_still(TRIAL_MS);
    assert_eq!(site.starts, 2);
}

/// A bad image may be what keeps the monitor from a state for other orders.
#[test]
fn a_trial_is_ended_in_any_state() {
    let mut site = tried();
    site.board.plant.inputs.main_voltage_dv = 100;
    site.run_still(1000);
    assert_eq!(site.order(&Order::Verify).0, Status::DENIED);
    assert_eq!(site.order(&Order::Abandon { digest: &DIGEST }).0, Status::ACCEPTED);
    site.run_still(1000);
    assert_eq!((site.starts, site.report().slot), (2, 1));
    // Power fails before it is carried out.
    let mut site = tried();
    assert_eq!(site.order(&Order::Abandon { digest: &DIGEST }).0, Status::ACCEPTED);
    site.start();
    let report = site.report();
    assert_eq!((report.slot, report.trial, report.failed), (1, false, true));
    // One order at a time: what has been confirmed is not ended.
    let mut site = tried();
    site.run_still(PROVEN_MS);
    assert_eq!(site.order(&Order::Confirm { word: LONG_WORD }).0, Status::ACCEPTED);
    assert_eq!(site.order(&Order::Abandon { digest: &DIGEST }).0, Status::BUSY);
    site.run_still(1000);
    assert_eq!(site.order(&Order::Abandon { digest: &DIGEST }).0, Status::INVALID_VALUE);
    site.run_still(TRIAL_MS);
    assert_eq!((site.starts, site.report().slot), (1, 2));
}

/// With nothing to go back to it is on trial again, once.
#[test]
fn a_trial_is_ended_with_nothing_else() {
    let mut site = tried();
    let at = site.app().memory().payload_of(Slot::A) as usize;
    site.app().memory_mut().flash_mut().flip(at * 8 + 3);
    assert_eq!(site.order(&Order::Abandon { digest: &DIGEST }).0, Status::ACCEPTED);
    site.run_still(20_000);
    let report = site.report();
    assert_eq!((site.starts, report.slot, report.trial), (2, 2, true));
    assert!(site.is_locked());
}
