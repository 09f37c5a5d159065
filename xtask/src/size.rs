//! `cargo xtask size`: flash and RAM of the firmware by crate, and its greatest stack depth, for
//! docs/footprint.md.

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

use crate::elf::{Elf, Symbol};
use crate::run::{self, StepResult};
use crate::stack::{self, Bound};
use crate::{TaskResult, firmware, flag};

const PAGE: &str = "docs/footprint.md";
/// The page says behind this how deep the painted stack has been used.
const PAINTED: &str = "the stack has been used down to **";

/// What a limit applies to.
enum Of {
    /// Flash of symbols whose crate or module has one of these names; all symbols if empty.
    Flash(&'static [&'static str]),
    /// All RAM: static, plus the deepest stack.
    Ram,
}

/// A limit for every build: the goal where it is met, else slightly more than was reached.
struct Limit {
    what: &'static str,
    board: &'static str,
    of: Of,
    goal: Option<u64>,
    limit: u64,
}

const LIMITS: [Limit; 5] = [
    Limit {
        what: "whole monitor, flash",
        board: "stm32f103",
        of: Of::Flash(&[]),
        goal: Some(64 * 1024),
        limit: 64 * 1024,
    },
    Limit {
        what: "whole monitor, RAM with the stack at most",
        board: "stm32f103",
        of: Of::Ram,
        goal: Some(12 * 1024),
        limit: 12 * 1024,
    },
    Limit {
        what: "codec and chain, flash",
        board: "stm32f103",
        of: Of::Flash(&["lafet_proto", "lafet_device..chain", "lafet_device5chain"]),
        goal: Some(12 * 1024),
        limit: 12 * 1024,
    },
    Limit {
        what: "with the emulator's plant and semihosting, flash",
        board: firmware::EMULATED,
        of: Of::Flash(&[]),
        goal: None,
        limit: 64 * 1024,
    },
    Limit {
        what: "with the emulator's plant and semihosting, RAM with the stack at most",
        board: firmware::EMULATED,
        of: Of::Ram,
        goal: Some(10 * 1024),
        limit: 10 * 1024,
    },
];

/// Crates as in symbol names; the rest is constants and the linker's additions.
const CRATES: [(&str, &str); 10] = [
    ("lafet_firmware", "the board: `firmware`"),
    ("lafet_stm32f103", "the board: `firmware/stm32f103`"),
    ("lafet_turn", "the loop: `firmware/turn`"),
    ("lafet_ballistics", "`lafet-ballistics`"),
    ("lafet_device", "`lafet-device`"),
    ("lafet_proto", "`lafet-proto`"),
    ("lafet_plant", "`lafet-plant`: the emulator's plant"),
    ("cortex_m", "`cortex-m`, `cortex-m-rt`, semihosting"),
    ("compiler_builtins", "arithmetic of the compiler: single precision"),
    ("4core", "`core`"),
];

pub fn size(arguments: &[String]) -> TaskResult {
    let check_only = flag(arguments, Some("--check"))?;
    let tables = Tables::measure()?;
    println!("{}\n{}\n{}", tables.size, tables.stack, tables.goals);
    run::verdict("the firmware is within its limits", &tables.problems)?;
    if !check_only {
        tables.write()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Fails if a limit is exceeded.
pub fn check() -> StepResult {
    let tables = Tables::measure()?;
    println!("{}", tables.goals);
    run::verdict("the firmware is within its limits", &tables.problems)
}

/// What the page says that the painted stack of a program has been used down to, bytes. It must lie within
/// the bound; a run that uses more fails, so that the page has the figure of the program as it is.
pub fn stack_as_published(program: &Path) -> Result<u32, String> {
    let painted = painted(&run::read(PAGE)?)?;
    let bound = stack::bound(&Elf::read(program)?)?.all();
    if painted > bound {
        return Err(format!("{PAGE}: {painted} bytes of stack used, of {bound} that can be"));
    }
    Ok(painted)
}

fn painted(page: &str) -> Result<u32, String> {
    let figure = page.split_once(PAINTED).and_then(|(_, rest)| rest.split_once(" bytes**"));
    let figure = figure.and_then(|(figure, _)| figure.replace(',', "").parse().ok());
    figure.ok_or_else(|| format!("{PAGE}: no figure behind `{PAINTED}`"))
}

/// The tables of the page, and the limits exceeded.
struct Tables {
    size: String,
    stack: String,
    goals: String,
    problems: Vec<String>,
}

impl Tables {
    fn measure() -> Result<Self, String> {
        let mut tables = Self {
            size: "| board | what | flash | RAM |\n|---|---|---:|---:|\n".into(),
            stack: "| board | on the deepest path | bytes |\n|---|---|---:|\n".into(),
            goals: "| what | goal | measured | |\n|---|---:|---:|---|\n".into(),
            problems: Vec::new(),
        };
        for board in firmware::BOARDS {
            let program = firmware::build(board)?;
            let elf = Elf::read(&program)?;
            let bound = stack::bound(&elf).map_err(|error| format!("{board}: {error}"))?;
            let symbols = elf.symbols();
            tables.add_sizes(board, elf.memory(), &symbols);
            tables.add_stack(board, &bound);
            tables.add_goals(board, elf.memory(), &symbols, &bound);
        }
        Ok(tables)
    }

    fn add_sizes(&mut self, board: &str, (flash, ram): (u64, u64), symbols: &[Symbol]) {
        let mut rest = (flash, ram);
        let mut row = |what: &str, flash: u64, ram: u64| {
            let _ = writeln!(self.size, "| {board} | {what} | {flash} | {ram} |");
        };
        for (name, shown) in CRATES {
            let own = symbols.iter().filter(|symbol| crate_of(&symbol.name) == Some(name));
            let sums = own.fold((0, 0), |(flash, ram), symbol| match symbol.in_ram() {
                true => (flash, ram + symbol.size),
                false => (flash + symbol.size, ram),
            });
            if sums != (0, 0) {
                row(shown, sums.0, sums.1);
            }
            rest = (rest.0.saturating_sub(sums.0), rest.1.saturating_sub(sums.1));
        }
        row("constants, vectors, the linker's", rest.0, rest.1);
        let _ = writeln!(
            self.size,
            "| {board} | **all**, beside the stack | **{flash}** | **{ram}** |"
        );
    }

    fn add_stack(&mut self, board: &str, bound: &Bound) {
        for (name, bytes) in &bound.path {
            let _ = writeln!(self.stack, "| {board} | `{name}` | {bytes} |");
        }
        let _ =
            writeln!(self.stack, "| {board} | an interrupt, and a fault | {} |", bound.exceptions);
        let _ = writeln!(self.stack, "| {board} | **all** | **{}** |", bound.all());
        println!("{board}, calls by register: {}", bound.by_register.join(", "));
        println!("{board}, to where they can go: {}", bound.held.join(", "));
    }

    fn add_goals(
        &mut self,
        board: &str,
        (flash, ram): (u64, u64),
        symbols: &[Symbol],
        bound: &Bound,
    ) {
        for limit in LIMITS.iter().filter(|limit| limit.board == board) {
            let got = match limit.of {
                Of::Flash([]) => flash,
                Of::Flash(names) => {
                    let is_its = |it: &&Symbol| names.iter().any(|name| it.name.contains(name));
                    symbols.iter().filter(is_its).map(|symbol| symbol.size).sum()
                }
                Of::Ram => ram + u64::from(bound.all()),
            };
            let (goal, word) = match limit.goal {
                Some(goal) if got <= goal => (goal.to_string(), "met"),
                Some(goal) => (goal.to_string(), "**missed**"),
                None => ("–".into(), ""),
            };
            let _ = writeln!(self.goals, "| {} ({board}) | {goal} | {got} | {word} |", limit.what);
            if got > limit.limit {
                self.problems.push(format!("{board}, {}: {got} > {}", limit.what, limit.limit));
            }
        }
    }

    fn write(&self) -> StepResult {
        let mut page = run::read(PAGE)?;
        for (name, block) in [("size", &self.size), ("stack", &self.stack), ("goals", &self.goals)]
        {
            page = run::put(PAGE, &page, name, block)?;
        }
        std::fs::write(run::root().join(PAGE), page).map_err(|e| format!("{PAGE}: {e}"))
    }
}

/// The first crate name in a symbol: that of the function, or of the type it belongs to.
fn crate_of(symbol: &str) -> Option<&'static str> {
    let places = CRATES.iter().filter_map(|(name, _)| Some((symbol.find(name)?, *name)));
    places.min().map(|(_, name)| name).or_else(|| {
        // The compiler calls these by special names.
        symbol.starts_with("__aeabi").then_some("compiler_builtins")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_says_how_deep_the_stack_has_been() {
        let page = run::read(PAGE).unwrap();
        assert!(painted(&page).is_ok_and(|bytes| (1_000..10_240).contains(&bytes)));
        assert_eq!(painted(&format!("Painted, {PAINTED}9,216 bytes** on")), Ok(9_216));
        assert!(painted("9,216 bytes").is_err());
    }
}
