//! What a poll costs in allocations, which do not depend on how busy the machine is: the hub, its
//! client and the fake monitor together.

mod support;

use std::alloc::System;
use std::sync::atomic::Ordering;
use std::time::Duration;

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use support::{Site, until};
use tokio::time::sleep;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Monitors, each polled every 50 ms.
const MONITORS: u8 = 8;
/// Allocations of a poll with its share of what happens each second: 74 when this was written.
const ALLOCATIONS_MAX: f64 = 90.0;

#[tokio::test]
async fn a_poll_allocates_no_more_than_it_did() {
    let site = Site::with(MONITORS, |_| {}).await;
    let polls = || site.hub.counts().polls.load(Ordering::Relaxed);
    until("every monitor has been polled", || polls() > 20 * u64::from(MONITORS)).await;
    let (before, region) = (polls(), Region::new(ALLOCATOR));
    sleep(Duration::from_secs(2)).await;
    let (count, change) = ((polls() - before) as f64, region.change());
    assert!(count > 100.0, "{count} polls in 2 s");
    let each = change.allocations as f64 / count;
    println!("{count} polls: {each:.1} allocations each");
    assert!(each < ALLOCATIONS_MAX, "{each:.1} allocations a poll");
}
