//! `cargo xtask size`: what the firmware takes of a chip, by crate; docs/footprint.md has the table.

use std::path::Path;
use std::process::ExitCode;

use crate::run::{self, StepResult};
use crate::{TaskResult, firmware, flag};

const PAGE: &str = "docs/footprint.md";

/// What no build may exceed: the goal where it is met, else what was reached and a little more.
struct Limit {
    what: &'static str,
    board: &'static str,
    /// Names that a symbol's crate or module may have; none: the whole program.
    of: &'static [&'static str],
    goal: Option<u64>,
    limit: u64,
}

const LIMITS: [Limit; 3] = [
    Limit {
        what: "whole monitor, flash",
        board: "stm32f103",
        of: &[],
        goal: Some(48 * 1024),
        limit: 50_200,
    },
    Limit {
        what: "codec and chain, flash",
        board: "stm32f103",
        of: &["lafet_proto", "lafet_device..chain", "lafet_device5chain"],
        goal: Some(12 * 1024),
        limit: 12 * 1024,
    },
    Limit {
        what: "with the emulator's plant and semihosting, flash",
        board: firmware::EMULATED,
        of: &[],
        goal: None,
        limit: 54_000,
    },
];

/// Crates as their symbols name them; what belongs to none is constants and what the linker adds.
const CRATES: [(&str, &str); 7] = [
    ("lafet_firmware", "the board: `firmware`"),
    ("lafet_device", "`lafet-device`"),
    ("lafet_proto", "`lafet-proto`"),
    ("lafet_plant", "`lafet-plant`: the emulator's plant"),
    ("cortex_m", "`cortex-m`, `cortex-m-rt`, semihosting"),
    ("compiler_builtins", "arithmetic of the compiler: single precision"),
    ("4core", "`core`"),
];

pub fn size(arguments: &[String]) -> TaskResult {
    let check_only = flag(arguments, Some("--check"))?;
    let (table, limits, problems) = measure()?;
    println!("{table}\n{limits}");
    run::verdict("the firmware is within its limits", &problems)?;
    if !check_only {
        write(&table, &limits)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Fails over a limit.
pub fn check() -> StepResult {
    let (_, limits, problems) = measure()?;
    println!("{limits}");
    run::verdict("the firmware is within its limits", &problems)
}

/// The tables, and which limits are exceeded.
fn measure() -> Result<(String, String, Vec<String>), String> {
    let mut table = String::from("| board | what | flash | RAM |\n|---|---|---:|---:|\n");
    let mut limits = String::from("| what | goal | measured | |\n|---|---:|---:|---|\n");
    let mut problems = Vec::new();
    for board in firmware::BOARDS {
        let program = firmware::build(board)?;
        let (flash, ram) = firmware::memory(&program)?;
        let symbols = symbols(&program)?;
        let mut rest = (flash, ram);
        for (name, shown) in CRATES {
            let own = symbols.iter().filter(|symbol| crate_of(&symbol.name) == Some(name));
            let sums = own.fold((0, 0), |(flash, ram), symbol| match symbol.in_ram {
                true => (flash, ram + symbol.size),
                false => (flash + symbol.size, ram),
            });
            if sums != (0, 0) {
                table += &format!("| {board} | {shown} | {} | {} |\n", sums.0, sums.1);
            }
            rest = (rest.0.saturating_sub(sums.0), rest.1.saturating_sub(sums.1));
        }
        table +=
            &format!("| {board} | constants, vectors, the linker's | {} | {} |\n", rest.0, rest.1);
        table += &format!("| {board} | **all**, beside the stack | **{flash}** | **{ram}** |\n");
        for limit in LIMITS.iter().filter(|limit| limit.board == board) {
            let is_its = |symbol: &&Symbol| limit.of.iter().any(|of| symbol.name.contains(of));
            let got = match limit.of {
                [] => flash,
                _ => symbols.iter().filter(is_its).map(|symbol| symbol.size).sum(),
            };
            let (goal, word) = match limit.goal {
                Some(goal) if got <= goal => (goal.to_string(), "met"),
                Some(goal) => (goal.to_string(), "**missed**"),
                None => ("–".into(), ""),
            };
            limits += &format!("| {} ({board}) | {goal} | {got} | {word} |\n", limit.what);
            if got > limit.limit {
                problems.push(format!("{board}, {}: {got} > {}", limit.what, limit.limit));
            }
        }
    }
    Ok((table, limits, problems))
}

fn write(table: &str, limits: &str) -> StepResult {
    let mut page = run::read(PAGE)?;
    for (name, block) in [("size", table), ("goals", limits)] {
        let (begin, end) = (format!("<!-- {name}:begin -->\n"), format!("<!-- {name}:end -->"));
        let missing = || format!("{PAGE} has no place for {name}");
        let from = page.find(&begin).ok_or_else(missing)? + begin.len();
        let to = page.find(&end).ok_or_else(missing)?;
        page.replace_range(from..to, block);
    }
    std::fs::write(run::root().join(PAGE), page).map_err(|e| format!("{PAGE}: {e}"))
}

struct Symbol {
    name: String,
    size: u64,
    in_ram: bool,
}

/// The crate whose name comes first: that of the function, or of the type whose function it is.
fn crate_of(symbol: &str) -> Option<&'static str> {
    let places = CRATES.iter().filter_map(|(name, _)| Some((symbol.find(name)?, *name)));
    places.min().map(|(_, name)| name).or_else(|| {
        // The compiler asks for these by names of its own.
        symbol.starts_with("__aeabi").then_some("compiler_builtins")
    })
}

/// Functions and variables of an ELF file; several names for one place count once.
fn symbols(program: &Path) -> Result<Vec<Symbol>, String> {
    let elf = std::fs::read(program).map_err(|e| format!("{}: {e}", program.display()))?;
    let damaged = || format!("{}: its symbols cannot be read", program.display());
    let mut found = table_of_symbols(&elf).ok_or_else(damaged)?;
    found.sort_by_key(|(place, _)| *place);
    found.dedup_by_key(|(place, _)| *place);
    Ok(found.into_iter().map(|(_, symbol)| symbol).collect())
}

fn table_of_symbols(elf: &[u8]) -> Option<Vec<(u32, Symbol)>> {
    const SYMBOLS: u32 = 2;
    const RAM: u32 = 0x2000_0000;
    const OBJECT: u8 = 1;
    const FUNCTION: u8 = 2;
    let word = |at: usize| Some(u32::from_le_bytes(*elf.get(at..)?.first_chunk()?));
    let half = |at: usize| Some(u16::from_le_bytes(*elf.get(at..)?.first_chunk()?));
    let (table, size, count) = (word(32)? as usize, usize::from(half(46)?), usize::from(half(48)?));
    let section = |index: usize| table + index * size;
    let symbols = (0..count).map(section).find(|at| word(at + 4) == Some(SYMBOLS))?;
    let names = word(section(word(symbols + 24)? as usize) + 16)? as usize;
    let (from, len) = (word(symbols + 16)? as usize, word(symbols + 20)? as usize);
    let mut found = Vec::new();
    for at in (from..from + len).step_by(16) {
        let (value, size, kind) = (word(at + 4)?, word(at + 8)?, elf.get(at + 12)? & 0xF);
        let place = names + word(at)? as usize;
        let name = elf.get(place..)?.split(|byte| *byte == 0).next()?;
        if size > 0 && (kind == OBJECT || kind == FUNCTION) {
            let name = String::from_utf8_lossy(name).into_owned();
            let in_ram = (RAM..RAM + 0x1000_0000).contains(&value);
            found.push((value, Symbol { name, size: size.into(), in_ram }));
        }
    }
    Some(found)
}
