//! How long 200 parameters take over a serial line: several in a frame, and one at a time.
//!
//! ```sh
//! cargo run --release -p lafet-client --example batching
//! ```
//!
//! On virtual time, with a loss that does not depend on a frame's length: the figures are those of the line, not of this computer.

#[path = "../tests/fake/mod.rs"]
mod fake;

use fake::slow_line::{SlowLine, read_all};

const COUNT: usize = 200;
const SEEDS: u64 = 20;

fn main() {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    let runtime = builder.enable_time().start_paused(true).build().expect("a runtime");
    println!(
        "{COUNT} parameters, mean of {SEEDS} runs      several in a frame           one at a time"
    );
    for baud in [19_200, 57_600, 115_200] {
        for loss_permille in [0, 10, 50] {
            let figures = |several| {
                let mut sum = [0.0; 3];
                for seed in 0..SEEDS {
                    let line = SlowLine { seed, ..SlowLine::new(baud, loss_permille) };
                    let reading = runtime.block_on(read_all(line, COUNT, several));
                    let frames = f64::from(reading.traffic.frames);
                    let one = [reading.took.as_secs_f64(), frames, reading.right as f64];
                    sum.iter_mut().zip(one).for_each(|(sum, one)| *sum += one / SEEDS as f64);
                }
                format!("{:6.2} s {:4.0} frames {:5.1} read", sum[0], sum[1], sum[2])
            };
            println!(
                "{baud:>6} baud {:>4.1} % of frames lost  {}  {}",
                f64::from(loss_permille as u32) / 10.0,
                figures(true),
                figures(false)
            );
        }
    }
}
