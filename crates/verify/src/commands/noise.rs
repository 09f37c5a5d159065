//! Frames that noise on a line forges: `cargo run --release -p lafet-verify -- noise 1e9`.
//!
//! Requests go over lines with bit errors, bursts and slips; how many frames are accepted that were
//! never sent, with each of the two checks. With words, only the rows that have all of them.

use clap::Args;
use lafet_proto::link::Check;
use lafet_sim::line::Noise;
use lafet_sim::line::exposure::{Exposure, Takes, expose};

#[derive(Args)]
pub struct Options {
    /// Frames for each line and receiver
    #[arg(default_value = "1e7", value_parser = frames)]
    frames: u64,
    /// Only the rows that have all of these words
    words: Vec<String>,
}

fn frames(text: &str) -> Result<u64, &'static str> {
    let frames = text.parse::<f64>().ok().filter(|frames| (1.0..1e18).contains(frames));
    frames.map(|frames| frames as u64).ok_or("expected a number of frames, like 1e9")
}

/// Prints the table.
pub fn run(options: &Options) -> Result<(), String> {
    let Options { frames, words } = options;
    let errors = |bit_error_rate| Noise { bit_error_rate, ..Noise::default() };
    let bursts = Noise { burst_rate: 1e-3, burst_bytes: 8, ..errors(1e-4) };
    let slips = Noise { loss_rate: 1e-3, double_rate: 1e-3, ..errors(1e-4) };
    let lines = [
        ("bit errors 1e-4", errors(1e-4)),
        ("bit errors 1e-3", errors(1e-3)),
        ("bit errors 1e-2", errors(1e-2)),
        ("bursts of 8 bytes, one in 1000 bytes", bursts),
        ("slips, one in 500 bytes", slips),
    ];
    println!("| line | check | accepts | lost | accepted, never sent | executed, never sent |");
    println!("|---|---|---|---|---|---|");
    let receivers =
        [(Check::Crc16, Takes::Both), (Check::Crc32c, Takes::Both), (Check::Crc32c, Takes::Only)];
    for (name, noise) in lines {
        for (check, takes) in receivers {
            let only = if takes == Takes::Both { "both" } else { "this alone" };
            let row = format!("{name} | {check:?} | {only}");
            if !words.iter().all(|word| row.contains(word.as_str())) {
                continue;
            }
            let Exposure { sent, accepted, wrong, executed, .. } =
                expose(check, takes, noise, *frames, 7);
            let lost = 100.0 * (sent - (accepted - wrong)) as f64 / sent as f64;
            println!("| {row} | {lost:.2} % | {wrong} | {executed} |");
        }
    }
    Ok(())
}
