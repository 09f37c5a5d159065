//! The tables and the plot of docs/performance.md.

use std::collections::BTreeMap;

use lafet_bench_report::{Bars, Goals, Table, number, section};

/// Instructions, nanoseconds and bytes of a case.
pub type Figures = BTreeMap<&'static str, (f64, f64, usize)>;

const PEERS: [&str; 7] = ["memcpy", "zerocopy", "deku", "postcard", "prost", "mavlink", "rmodbus"];
const ROWS: [(&str, &str); 13] = [
    ("drive_decode", "state of a drive, decode"),
    ("drive_encode", "the same, encode"),
    ("whole_decode", "state of 14 subsystems, decode"),
    ("whole_encode", "the same, encode"),
    ("drive_receive", "state of a drive, receive: frame, CRC, decode"),
    ("drive_send", "the same, send"),
    ("whole_receive", "state of 14 subsystems, receive"),
    ("whole_send", "the same, send"),
    ("eleven_decode", "11 records of 142 bytes, decode"),
    ("answer_core", "a device answers what state a drive is in: from request to answer"),
    ("answer_framed", "the same with frames and CRC on both sides"),
    ("answer_whole", "a device answers what state it is in, 14 subsystems"),
    ("exchange", "an exchange of a client's session, from request to answer, without I/O"),
];

/// Prints all of it.
pub fn print(figures: &Figures) {
    section("codec", &table(figures, |figure| figure.0));
    section("codec-ns", &table(figures, |figure| figure.1));
    section("codec-bytes", &table(figures, |figure| figure.2 as f64));
    section("codec-goals", goals(figures).text());
    section("codec.svg", &plot(figures));
}

fn table(figures: &Figures, of: fn(&(f64, f64, usize)) -> f64) -> String {
    let mut columns = vec!["", "lafet"];
    columns.extend(PEERS);
    let mut table = Table::new(&columns);
    for (what, words) in ROWS {
        let Some(ours) = find(figures, "lafet", what).map(of) else { continue };
        let mut cells = vec![words.to_owned(), number(ours)];
        for peer in PEERS {
            let figure = find(figures, peer, what).map(of);
            let cell = |v: f64| {
                format!("{} ({} ×)", number(v), number((v / ours * 100.0).round() / 100.0))
            };
            cells.push(figure.map_or(String::new(), cell));
        }
        table.row(&cells);
    }
    table.text().to_owned()
}

/// memcpy goes both ways; 11 messages of mavlink are read with their frames.
fn find<'a>(figures: &'a Figures, peer: &str, what: &str) -> Option<&'a (f64, f64, usize)> {
    let what = match (peer, what) {
        ("memcpy", "drive_decode" | "drive_encode") => "drive_copy",
        ("memcpy", "whole_decode" | "whole_encode") => "whole_copy",
        ("mavlink", "eleven_decode") => "eleven_receive",
        _ => what,
    };
    figures.get(format!("{peer}::{what}").as_str())
}

fn goals(figures: &Figures) -> Goals {
    let mut goals = Goals::default();
    let count = |peer, what| find(figures, peer, what).map_or(f64::NAN, |figure| figure.0);
    let unit = "instructions";
    goals.at_most("header and DriveStatus, decode", 60.0, count("lafet", "drive_decode"), unit);
    goals.at_most("header and DriveStatus, encode", 77.0, count("lafet", "drive_encode"), unit);
    goals.at_most("11 records of 142 bytes, decode", 720.0, count("lafet", "eleven_decode"), unit);
    let ratio = count("mavlink", "eleven_decode") / count("lafet", "eleven_decode");
    goals.at_least("mavlink's reader, 11 messages, against that", 6.0, ratio, "×");
    let answer = count("lafet", "answer_core");
    goals.at_most("request → answer in the device core", 334.0, answer, unit);
    let modbus = count("rmodbus", "answer_core") / answer;
    goals.at_least("rmodbus' reading of four registers, against that", 1.0, modbus, "×");
    goals
}

fn plot(figures: &Figures) -> String {
    let mut bars = Bars::new("instructions to decode header and state of a drive, without CRC");
    for peer in ["lafet", "memcpy", "zerocopy", "postcard", "deku", "prost"] {
        if let Some(figure) = find(figures, peer, "drive_decode") {
            bars.bar(peer, figure.0);
        }
    }
    for (peer, name) in [
        ("lafet", "lafet, frame and CRC"),
        ("mavlink", "mavlink, frame and CRC"),
        ("postcard", "postcard, COBS and CRC"),
        ("rmodbus", "rmodbus, RTU"),
    ] {
        if let Some(figure) = find(figures, peer, "drive_receive") {
            bars.bar(name, figure.0);
        }
    }
    bars.svg()
}
