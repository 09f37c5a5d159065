//! Keeps simulated time in step with the monotonic clock.

use std::time::Duration;

use tokio::time::{Instant, MissedTickBehavior, interval};

use super::Bus;

/// Interval at which simulated time is advanced.
const PERIOD: Duration = Duration::from_millis(5);
/// Step of the simulation, ms.
const STEP_MS: u64 = lafet_sim::world::STEP_MS;
/// Steps between yields to other tasks.
const STEPS_AT_ONCE: u64 = 20;
/// Most real time that the simulation catches up after the clock jumps ahead, as after the computer
/// was suspended, ms.
const LAG_MAX_MS: f64 = 500.0;

/// Advances simulated time at `speed` times real time, for ever.
pub async fn pace(bus: impl Bus, speed: f64) {
    let mut ticks = interval(PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut last = Instant::now();
    let mut due_ms = 0.0;
    loop {
        ticks.tick().await;
        let now = Instant::now();
        let elapsed_ms = now.duration_since(last).as_secs_f64() * 1000.0;
        last = now;
        due_ms += elapsed_ms.min(LAG_MAX_MS) * speed;
        let mut steps = (due_ms / STEP_MS as f64) as u64;
        due_ms -= (steps * STEP_MS) as f64;
        while steps > 0 {
            let now = steps.min(STEPS_AT_ONCE);
            bus.advance_ms(now * STEP_MS);
            steps -= now;
            tokio::task::yield_now().await;
        }
    }
}
