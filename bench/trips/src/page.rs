//! Who is measured, and the tables.

use std::path::Path;

use lafet_bench_report::{Bars, Goals, Table, number, section};

use crate::ask::STATE;
use crate::contender::{Contender, Figures, compile, own};
use crate::serve::ANSWER;

/// How often everything is measured, one contender after the other, so that what else the machine
/// does meets all of them.
const ROUNDS: usize = 9;
const SECONDS: &str = "1";
/// Connections and requests outstanding on each, beside its own client.
const LOADS: [(usize, usize, &str); 2] =
    [(64, 1, "64 connections"), (1, 32, "32 outstanding on one connection")];
/// Columns: its own client, and the loads.
const COLUMNS: usize = 1 + LOADS.len();

/// What a contender did in each round, by column.
type Rounds = [Vec<Option<Figures>>; COLUMNS];

/// Measures everything and prints it.
pub fn report(lafet: &Path, folder: &Path) -> Result<(), String> {
    let contenders = contenders(lafet, folder)?;
    let mut rounds: Vec<Rounds> = contenders.iter().map(|_| Rounds::default()).collect();
    for _ in 0..ROUNDS {
        for (contender, rounds) in contenders.iter().zip(&mut rounds) {
            let running = contender.start()?;
            rounds[0].push(running.ask(SECONDS)?);
            for ((connections, outstanding, _), rounds) in LOADS.iter().zip(&mut rounds[1..]) {
                rounds.push(running.load(*connections, *outstanding, SECONDS)?);
            }
        }
    }
    let names: Vec<&str> = contenders.iter().map(|contender| contender.name).collect();
    let [echo, ..] = &rounds[..] else { return Err("nothing was measured".into()) };
    let summary: Vec<_> = rounds.iter().map(|rounds| summary(rounds, echo)).collect();
    print(&names, &summary);
    Ok(())
}

/// The medians of a column.
#[derive(Clone, Copy)]
struct Summary {
    /// Exchanges a second of processor time.
    rate: f64,
    /// The share of the echo's in the same round.
    share: f64,
    /// The 99th percentile, µs.
    p99: f64,
}

/// None where a round was not answered.
fn summary(rounds: &Rounds, echo: &Rounds) -> [Option<Summary>; COLUMNS] {
    std::array::from_fn(|column| {
        let pairs: Option<Vec<(Figures, Figures)>> =
            rounds[column].iter().zip(&echo[column]).map(|(own, echo)| (*own).zip(*echo)).collect();
        let pairs = pairs?;
        Some(Summary {
            rate: median(pairs.iter().map(|(own, _)| own.0))?,
            share: median(pairs.iter().map(|(own, echo)| own.0 / echo.0))?,
            p99: median(pairs.iter().map(|(own, _)| own.1))?,
        })
    })
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn contenders(lafet: &Path, folder: &Path) -> Result<Vec<Contender>, String> {
    const MODBUS: (&str, usize) = ("000100000006010300000004", 17);
    let own = own()?.display().to_string();
    let native = compile(&folder.join("libmodbus.c"))?.display().to_string();
    let python = folder.join("pymodbus_peer.py").display().to_string();
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let pair = |name, serve: &[&str], ask: &[&str], bytes| Contender {
        name,
        serve: words(serve),
        ask: words(ask),
        bytes,
    };
    let lafet = lafet.display().to_string();
    let sim = [&lafet, "sim", "--listen", "tcp://127.0.0.1:PORT"];
    let echo = [&own[..], "serve", "echo", "PORT"];
    let lafet_bytes = Some((STATE, ANSWER));
    Ok(vec![
        pair("bare echo", &echo, &[&own, "ask", "echo"], lafet_bytes),
        pair("lafet", &sim, &[&own, "ask", "lafet"], lafet_bytes),
        pair("lafet, blocking", &sim, &[&own, "ask", "lafet-blocking"], None),
        pair("the same, just connected", &sim, &[&own, "ask", "lafet-blocking-new"], None),
        pair("bare bytes, asking lafet", &sim, &[&own, "ask", "bytes"], None),
        pair("lafet, asking the echo", &echo, &[&own, "ask", "lafet"], None),
        pair("lafet, blocking, asking the echo", &echo, &[&own, "ask", "lafet-blocking"], None),
        pair(
            "tokio-modbus",
            &[&own, "serve", "tokio-modbus", "PORT"],
            &[&own, "ask", "tokio-modbus"],
            Some(MODBUS),
        ),
        pair("libmodbus", &[&native, "serve", "PORT"], &[&native, "ask"], Some(MODBUS)),
        pair(
            "pymodbus",
            &["python3", &python, "serve", "PORT"],
            &["python3", &python, "ask"],
            Some(MODBUS),
        ),
    ])
}

fn print(names: &[&str], all: &[[Option<Summary>; COLUMNS]]) {
    let titles = ["one outstanding, its own client", LOADS[0].2, LOADS[1].2];
    let mut columns = vec![String::new()];
    columns.extend(titles.map(String::from));
    let mut table = Table::new(&columns);
    let mut late = Table::new(&columns);
    let as_above =
        |name: &str| ["blocking", "the same", "asking"].iter().any(|part| name.contains(part));
    let missing = |name: &str| if as_above(name) { "as above" } else { "not all answered" };
    for (name, figures) in names.iter().zip(all) {
        let cell = |i: usize, text: &dyn Fn(Summary) -> String| {
            figures[i].map_or_else(|| missing(name).to_owned(), text)
        };
        let rate = |one: Summary| format!("{} ({})", number(one.rate), number(one.share));
        table.row(&[(*name).to_owned(), cell(0, &rate), cell(1, &rate), cell(2, &rate)]);
        let p99 = |one: Summary| number(one.p99);
        late.row(&[(*name).to_owned(), cell(0, &p99), cell(1, &p99), cell(2, &p99)]);
    }
    section("roundtrip", table.text());
    section("roundtrip-p99", late.text());
    let share = |contender: usize, column: usize| {
        all.get(contender).and_then(|one| one[column]).map_or(f64::NAN, |one| one.share)
    };
    let mut goals = Goals::default();
    goals.at_least("blocking, share of the echo", 0.93, share(2, 0), "");
    goals.at_least("one outstanding, share of the echo", 0.90, share(1, 0), "");
    goals.at_least("64 connections, share of the echo", 0.93, share(1, 1), "");
    goals.at_least("32 outstanding, share of the echo", 0.8, share(1, 2), "");
    section("roundtrip-goals", goals.text());
    let mut bars =
        Bars::new("exchanges a second of processor time, 32 outstanding on one connection");
    for (name, figures) in names.iter().zip(all) {
        if let Some(figures) = figures[2] {
            bars.bar(name, figures.rate);
        }
    }
    section("roundtrip.svg", &bars.svg());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_the_same_round() {
        let column = |rates: [f64; 3]| rates.map(|rate| Some((rate, 1.0))).to_vec();
        let echo: Rounds = [column([100.0, 50.0, 10.0]), column([1.0; 3]), column([1.0; 3])];
        let mut own: Rounds = [column([90.0, 45.0, 9.0]), column([1.0; 3]), column([1.0; 3])];
        own[2][1] = None;
        let summary = summary(&own, &echo);
        let first = summary[0].expect("every round was answered");
        assert!((first.share - 0.9).abs() < 1e-9 && (first.rate - 45.0).abs() < 1e-9);
        assert!(summary[2].is_none(), "a round without answers");
    }
}
