//! What noise lets through: `cargo run --release -p lafet-sim --example noise -- [FRAMES [WORD…]]`.
//!
//! Requests go over lines with bit errors, bursts and slips; how many frames are accepted that were
//! never sent, with each of the two checks. With words, only the rows that have all of them.

use lafet_proto::link::Check;
use lafet_sim::line::Noise;
use lafet_sim::line::exposure::{Exposure, Takes, expose};

fn main() {
    let frames = match std::env::args().nth(1).map(|text| text.parse::<f64>()) {
        None => 10_000_000,
        Some(Ok(frames)) if frames >= 1.0 => frames as u64,
        Some(_) => {
            eprintln!("expected a number of frames, like 1e9");
            std::process::exit(2);
        }
    };
    let words: Vec<String> = std::env::args().skip(2).collect();
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
                expose(check, takes, noise, frames, 7);
            let lost = 100.0 * (sent - (accepted - wrong)) as f64 / sent as f64;
            println!("| {row} | {lost:.2} % | {wrong} | {executed} |");
        }
    }
}
