//! Frames of a capture read: `lafet decode`, tshark with and without our dissector, pymavlink.
//!
//! `capture LAFET FOLDER`

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use lafet_bench_host::children_s;
use lafet_bench_report::{Bars, Goals, Table, number, section};
use lafet_proto::link::{self, Frame};

/// For lafet and tshark, so that their start does not count.
const FRAMES: usize = 1_000_000;
/// For pymavlink, which takes longer.
const FEWER: usize = 100_000;
/// How often each is run; the mean counts, as processor time comes in hundredths of a second.
const TRIES: usize = 3;
/// How often our dissector and the one that does nothing are run by turns; medians count.
const PAIRS: usize = 9;
/// What tshark takes to call Lua at all.
const NOTHING: &str = "local nothing = Proto(\"nothing\", \"Nothing\")
function nothing.dissector(tvb) return tvb:len() end
DissectorTable.get(\"wtap_encap\"):add(wtap.USER0, nothing)
";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [lafet, folder] = &words[..] else {
        eprintln!("capture LAFET FOLDER");
        return ExitCode::from(2);
    };
    match report(lafet, folder.as_ref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn report(lafet: &str, folder: &Path) -> Result<(), String> {
    let target = std::env::current_exe().map_err(|e| e.to_string())?;
    let at = |name: &str| target.with_file_name(name).display().to_string();
    let (raw, pcap) = (at("bench.bin"), at("bench.pcap"));
    let (lua, nothing) = (at("bench.lua"), at("bench-nothing.lua"));
    let bytes: Vec<u8> = pair()?.concat().repeat(FRAMES / 2);
    fs::write(&raw, bytes).map_err(|e| format!("{raw}: {e}"))?;
    fs::write(&pcap, packets(&pair()?)).map_err(|e| format!("{pcap}: {e}"))?;
    let dissector = run(&[lafet, "dissector"])?;
    fs::write(&lua, dissector).map_err(|e| format!("{lua}: {e}"))?;
    fs::write(&nothing, NOTHING).map_err(|e| format!("{nothing}: {e}"))?;
    let (ours, nothing) = (format!("lua_script:{lua}"), format!("lua_script:{nothing}"));
    let mavlink = folder.join("pymavlink_read.py").display().to_string();
    let count = FEWER.to_string();
    let mean = |words: &[&str], frames: usize| -> Result<f64, String> {
        let before = children_s();
        (0..TRIES).try_for_each(|_| run_quietly(words))?;
        Ok((children_s() - before) / (TRIES * frames) as f64 * 1e6)
    };
    let counted = mean(&[lafet, "decode", "--quiet", &raw], FRAMES)?;
    let text = mean(&[lafet, "decode", &raw], FRAMES)?;
    let plain = mean(&["tshark", "-r", &pcap], FRAMES)?;
    let tshark =
        [nothing, ours].map(|script| ["tshark", "-X", &script, "-r", &pcap].map(str::to_owned));
    let [empty, ours, ratio] = by_turns(&tshark)?;
    let python: f64 = run(&["python3", &mavlink, &count])?.trim().parse().unwrap_or(f64::NAN);
    let rows = [
        ("lafet decode --quiet", counted),
        ("lafet decode, text", text),
        ("pymavlink, HEARTBEAT", python),
        ("tshark, no dissector", plain),
        ("tshark, a dissector in Lua that does nothing", empty),
        ("tshark, our dissector", ours),
    ];
    let mut table = Table::new(&["", "µs a frame", "frames a second"]);
    let mut bars = Bars::new("microseconds a frame");
    for (name, us) in rows {
        table.row(&[name.to_owned(), number(us), number(1e6 / us)]);
        bars.bar(name, us);
    }
    section("capture", table.text());
    let mut goals = Goals::default();
    goals.at_least("`lafet decode`, frames a second", 5e6, 1e6 / counted, "");
    let what = "tshark with our dissector, against one in Lua that does nothing";
    goals.at_most(what, 1.35, ratio, "×");
    goals.at_least("pymavlink's time, against `lafet decode`", 1.0, python / counted, "×");
    section("capture-goals", goals.text());
    section("capture.svg", &bars.svg());
    Ok(())
}

/// Microseconds a frame of two programs that run by turns, and the second's time over the first's:
/// medians, as others use the machine.
fn by_turns(programs: &[[String; 5]; 2]) -> Result<[f64; 3], String> {
    let mut columns = [const { Vec::new() }; 3];
    for _ in 0..PAIRS {
        let mut us = [0.0; 2];
        for (program, us) in programs.iter().zip(&mut us) {
            let before = children_s();
            run_quietly(&program.each_ref().map(String::as_str))?;
            *us = (children_s() - before) / FRAMES as f64 * 1e6;
        }
        let [first, second] = us;
        columns.iter_mut().zip([first, second, second / first]).for_each(|(all, it)| all.push(it));
    }
    Ok(columns.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[PAIRS / 2]
    }))
}

/// A request for the state of a drive, and its answer.
fn pair() -> Result<[Vec<u8>; 2], String> {
    let request = [0xD4, 0x0D, 0, 0];
    let answer = [0xD4, 0x0D, 0, 8, 0, 0, 0x41, 0, 0xB0, 4, 21, 9];
    let frame = |dst, src, payload: &[u8]| {
        let mut out = [0; 64];
        let len = link::encode(&Frame { dst, src, payload }, &mut out).ok_or("no room")?;
        Ok::<_, String>(out[..len].to_vec())
    };
    Ok([frame(1, 129, &request)?, frame(129, 1, &answer)?])
}

/// A pcap file of link type USER0.
fn packets(pair: &[Vec<u8>; 2]) -> Vec<u8> {
    let mut file = Vec::new();
    for word in [0xA1B2_C3D4u32, 0x0004_0002, 0, 0, 65_535, 147] {
        file.extend(word.to_le_bytes());
    }
    for index in 0..FRAMES {
        let packet = &pair[index % 2];
        let (time, len) = (index as u32, packet.len() as u32);
        for word in [time / 1000, time % 1000 * 1000, len, len] {
            file.extend(word.to_le_bytes());
        }
        file.extend(packet);
    }
    file
}

fn run(words: &[&str]) -> Result<String, String> {
    let output = Command::new(words[0]).args(&words[1..]).output();
    let output = output.map_err(|e| format!("{}: {e}", words[0]))?;
    if !output.status.success() {
        return Err(format!("{words:?}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn run_quietly(words: &[&str]) -> Result<(), String> {
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status().map_err(|e| format!("{}: {e}", words[0]))?;
    if status.success() { Ok(()) } else { Err(format!("{words:?}: {status}")) }
}
