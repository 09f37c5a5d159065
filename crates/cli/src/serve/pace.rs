//! Keeps simulated time in step with the monotonic clock.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_device::Source;
use tokio::time::{Instant, sleep};

use super::{Bus, Wire};

/// Interval at which simulated time is advanced.
const PERIOD: Duration = Duration::from_millis(5);
/// The same where frames advance it as well: it only limits how much there is to catch up.
const PERIOD_PACED: Duration = Duration::from_millis(50);
/// Step of the simulation, ms.
const STEP_MS: u64 = lafet_sim::world::STEP_MS;
/// Steps between yields to other tasks.
const STEPS_AT_ONCE: u64 = 20;
/// Most real time that the simulation catches up after the clock jumps ahead, as after the computer
/// was suspended, ms.
const LAG_MAX_MS: f64 = 500.0;

/// Advances simulated time at `speed` times real time, for ever.
pub async fn pace(bus: impl Bus, speed: f64) {
    Paced::new(bus, speed).run_every(PERIOD).await;
}

/// A simulation at `speed` times real time. Each frame is handled at the moment at which it comes.
#[derive(Clone)]
pub struct Paced<B> {
    bus: B,
    speed: f64,
    clock: Arc<Mutex<Clock>>,
}

#[derive(Debug)]
struct Clock {
    last: Instant,
    /// Simulated time that is due, ms.
    due_ms: f64,
}

impl<B: Bus> Paced<B> {
    /// A simulation that goes on from now.
    pub fn new(bus: B, speed: f64) -> Self {
        let clock = Clock { last: Instant::now(), due_ms: 0.0 };
        Self { bus, speed, clock: Arc::new(Mutex::new(clock)) }
    }

    /// Advances simulated time between frames, for ever.
    pub async fn run(self) {
        let period = PERIOD_PACED.div_f64(self.speed.max(1.0));
        self.run_every(period.max(PERIOD)).await;
    }

    async fn run_every(&self, period: Duration) {
        loop {
            sleep(period).await;
            while self.catch_up() {
                tokio::task::yield_now().await;
            }
        }
    }

    /// Makes some of the steps that are due; returns whether there are more.
    fn catch_up(&self) -> bool {
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let elapsed_ms = now.duration_since(clock.last).as_secs_f64() * 1000.0;
        clock.last = now;
        clock.due_ms += elapsed_ms.min(LAG_MAX_MS) * self.speed;
        let due = (clock.due_ms / STEP_MS as f64) as u64;
        let steps = due.min(STEPS_AT_ONCE);
        clock.due_ms -= (steps * STEP_MS) as f64;
        if steps > 0 {
            self.bus.advance_ms(steps * STEP_MS);
        }
        due > steps
    }
}

impl<B: Bus> Bus for Paced<B> {
    fn receive(&self, wire: &mut Wire, bytes: &[u8]) -> Vec<u8> {
        self.catch_up();
        self.bus.receive(wire, bytes)
    }

    fn datagram(&self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        self.catch_up();
        self.bus.datagram(source, bytes)
    }

    fn advance_ms(&self, ms: u64) {
        self.bus.advance_ms(ms);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use tokio::time::advance;

    use super::*;

    /// Answers what has passed, ms.
    #[derive(Clone, Default)]
    struct Passed(Arc<AtomicU64>);

    impl Bus for Passed {
        fn receive(&self, _: &mut Wire, _: &[u8]) -> Vec<u8> {
            self.0.load(Ordering::Relaxed).to_le_bytes().to_vec()
        }

        fn datagram(&self, _: Source, _: &[u8]) -> Option<Vec<u8>> {
            Some(self.0.load(Ordering::Relaxed).to_le_bytes().to_vec())
        }

        fn advance_ms(&self, ms: u64) {
            self.0.fetch_add(ms, Ordering::Relaxed);
        }
    }

    /// Whole steps of 10 ms, however often frames come.
    #[tokio::test(start_paused = true)]
    async fn a_frame_is_handled_at_the_moment_at_which_it_comes() {
        for (speed, expected) in [(1.0, [30, 70, 110]), (2.0, [70, 140, 220]), (0.0, [0; 3])] {
            let paced = Paced::new(Passed::default(), speed);
            let mut wire = Wire::link(Source::Radio);
            for expected in expected {
                advance(Duration::from_millis(37)).await;
                assert_eq!(paced.receive(&mut wire, &[]), u64::to_le_bytes(expected));
                assert_eq!(paced.datagram(Source::Radio, &[]).unwrap(), u64::to_le_bytes(expected));
            }
        }
    }

    /// Without frames time passes all the same.
    #[tokio::test(start_paused = true)]
    async fn time_passes_between_frames() {
        for (speed, expected) in [(1.0, 1000), (50.0, 50_000)] {
            let bus = Passed::default();
            let running = tokio::spawn(Paced::new(bus.clone(), speed).run());
            sleep(Duration::from_millis(1001)).await;
            let passed = bus.0.load(Ordering::Relaxed);
            assert!(expected * 9 / 10 <= passed && passed <= expected, "{passed}");
            running.abort();
        }
    }
}
