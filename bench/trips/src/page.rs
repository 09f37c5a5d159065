//! Who is measured, and the tables.

use std::path::Path;

use lafet_bench_report::{Bars, Goals, Table, number, section};

use crate::contender::{Contender, Figures, compile, own};
use crate::serve::ANSWER;

/// How often everything is measured; the best counts, as others use the machine too.
const ROUNDS: usize = 5;
const SECONDS: &str = "1";
/// Connections and requests outstanding on each, beside its own client.
const LOADS: [(usize, usize, &str); 2] =
    [(64, 1, "64 connections"), (1, 32, "32 outstanding on one connection")];

/// Measures everything and prints it.
pub fn report(lafet: &Path, folder: &Path) -> Result<(), String> {
    let contenders = contenders(lafet, folder)?;
    let mut best = vec![[(0.0, f64::INFINITY); 3]; contenders.len()];
    for _ in 0..ROUNDS {
        for (contender, best) in contenders.iter().zip(&mut best) {
            let running = contender.start()?;
            keep(&mut best[0], running.ask(SECONDS)?);
            for ((connections, outstanding, _), best) in LOADS.iter().zip(&mut best[1..]) {
                keep(best, running.load(*connections, *outstanding, SECONDS)?);
            }
        }
    }
    let names: Vec<&str> = contenders.iter().map(|contender| contender.name).collect();
    print(&names, &best);
    Ok(())
}

fn keep(best: &mut Figures, now: Option<Figures>) {
    if let Some(now) = now.filter(|now| now.0 > best.0) {
        *best = now;
    }
}

fn contenders(lafet: &Path, folder: &Path) -> Result<Vec<Contender>, String> {
    const MODBUS: (&str, usize) = ("000100000006010300000004", 17);
    let own = own()?.display().to_string();
    let native = compile(&folder.join("libmodbus.c"))?.display().to_string();
    let python = folder.join("pymodbus_peer.py").display().to_string();
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let pair = |name, serve: &[&str], ask: &[&str], bytes, port| Contender {
        name,
        serve: words(serve),
        ask: words(ask),
        bytes,
        port,
    };
    let lafet = lafet.display().to_string();
    let sim = [&lafet, "sim", "--listen", "tcp://127.0.0.1:PORT"];
    Ok(vec![
        pair(
            "bare echo",
            &[&own, "serve", "echo", "PORT"],
            &[&own, "ask", "echo"],
            (STATE, ANSWER),
            20_501,
        ),
        pair("lafet", &sim, &[&own, "ask", "lafet"], (STATE, ANSWER), 20_502),
        pair(
            "tokio-modbus",
            &[&own, "serve", "tokio-modbus", "PORT"],
            &[&own, "ask", "tokio-modbus"],
            MODBUS,
            20_503,
        ),
        pair("libmodbus", &[&native, "serve", "PORT"], &[&native, "ask"], MODBUS, 20_504),
        pair(
            "pymodbus",
            &["python3", &python, "serve", "PORT"],
            &["python3", &python, "ask"],
            MODBUS,
            20_505,
        ),
    ])
}

/// GetStatus Vertical from console 129 to monitor 1.
const STATE: &str = "FFC00181D40D000095E7C0";

fn print(names: &[&str], best: &[[Figures; 3]]) {
    let echo = best[0];
    let titles = ["one outstanding, its own client", LOADS[0].2, LOADS[1].2];
    let mut columns = vec![String::new()];
    columns.extend(titles.map(String::from));
    let mut table = Table::new(&columns);
    let mut late = Table::new(&columns);
    for (name, figures) in names.iter().zip(best) {
        let known = |i: usize, text: String| match figures[i].1.is_finite() {
            true => text,
            false => "not all answered".into(),
        };
        let share = |i: usize| number(figures[i].0 / echo[i].0);
        let cell = |i: usize| known(i, format!("{} ({})", number(figures[i].0), share(i)));
        table.row(&[(*name).to_owned(), cell(0), cell(1), cell(2)]);
        let cell = |i: usize| known(i, number(figures[i].1));
        late.row(&[(*name).to_owned(), cell(0), cell(1), cell(2)]);
    }
    section("roundtrip", table.text());
    section("roundtrip-p99", late.text());
    let ours = best[1];
    let mut goals = Goals::default();
    goals.at_least("one outstanding, share of the echo", 0.93, ours[0].0 / echo[0].0, "");
    goals.at_least("64 connections, share of the echo", 0.93, ours[1].0 / echo[1].0, "");
    goals.at_least("32 outstanding, share of the echo", 0.8, ours[2].0 / echo[2].0, "");
    section("roundtrip-goals", goals.text());
    let mut bars =
        Bars::new("exchanges a second of processor time, 32 outstanding on one connection");
    names.iter().zip(best).for_each(|(name, figures)| bars.bar(name, figures[2].0));
    section("roundtrip.svg", &bars.svg());
}
