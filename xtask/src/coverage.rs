//! `cargo xtask coverage`: the lines and branches of the device that its own tests reach.
//!
//! Uses the compiler's instrumentation with branches, which is unstable; the counters are read by
//! LLVM tools of the same version: rustup's llvm-tools, or Debian's package.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{
    TestProgram, cargo, output, root, show, target as target_directory, test_programs,
};
use crate::{TaskResult, flag, setup};

/// Measured sources: folder, and prefix of their files in the table.
const SOURCES: [(&str, &str); 2] =
    [("crates/device/src/", ""), ("crates/ballistics/src/", "ballistics/")];
/// The last filter and the chain of handlers: every line and branch must be reached.
const WHOLE: [&str; 2] = ["guard.rs", "chain.rs"];
/// Files of tests beside the code.
const TESTS: [&str; 2] = ["tests.rs", "bench.rs"];
/// Long tests, with the filter for the part that reaches everything.
const SHORTENED: [(&str, &str); 1] = [("store", "behaviour")];
/// A test that only repeats, at length, what others reach.
const LEFT_OUT: &str = "stops";

pub fn coverage(arguments: &[String]) -> TaskResult {
    let check = flag(arguments, Some("--check"))?;
    let llvm = Llvm::find()?;
    let target = target_directory().join("coverage");
    let profiles = target.join("profiles");
    // Counters of another build would be mixed in.
    let _ = std::fs::remove_dir_all(&profiles);
    let tests = build(&target)?;
    for test in &tests {
        let mut command = Command::new(&test.path);
        let filter = SHORTENED.iter().find(|(name, _)| *name == test.name).map(|(_, part)| part);
        command.arg("-q").args(filter).current_dir(root().join("crates/device"));
        show(command.env("LLVM_PROFILE_FILE", profiles.join("%p-%m.profraw")))?;
    }
    let merged = profiles.join("all.profdata");
    show(
        Command::new(&llvm.profdata)
            .args(["merge", "--sparse", "--output"])
            .arg(&merged)
            .args(files(&profiles, "profraw")?),
    )?;
    let mut export = Command::new(&llvm.cov);
    export.args(["export", "--format=lcov", "--instr-profile"]).arg(&merged);
    for test in &tests {
        export.arg("--object").arg(&test.path);
    }
    let files = measured(&output(&mut export)?);
    println!("\n{}", table(&files));
    let holes: Vec<String> = files.iter().filter_map(File::hole).collect();
    if check && !holes.is_empty() {
        return Err(format!("not reached:\n  {}", holes.join("\n  ")));
    }
    Ok(ExitCode::SUCCESS)
}

/// The two programs that read the compiler's counters.
struct Llvm {
    profdata: PathBuf,
    cov: PathBuf,
}

impl Llvm {
    fn find() -> Result<Self, String> {
        let version = output(Command::new("rustc").arg("-vV").current_dir(root()))?;
        let field = |name: &str| {
            version.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default().trim()
        };
        let major = field("LLVM version:").split('.').next().unwrap_or_default();
        let sysroot = output(Command::new("rustc").args(["--print", "sysroot"]))?;
        let tools = Path::new(sysroot.trim()).join("lib/rustlib").join(field("host:")).join("bin");
        let of_rustup = || Self::at(tools.join("llvm-profdata"), tools.join("llvm-cov"));
        let name = |tool: &str| PathBuf::from(format!("/usr/bin/llvm-{tool}-{major}"));
        let of_debian = || Self::at(name("profdata"), name("cov"));
        if let Some(found) = of_rustup().or_else(of_debian) {
            return Ok(found);
        }
        println!("   llvm-tools are missing: adding them");
        let mut add = Command::new("rustup");
        add.args(["component", "add", "llvm-tools"]).current_dir(root());
        if show(&mut add).is_ok()
            && let Some(found) = of_rustup()
        {
            return Ok(found);
        }
        let package = format!("llvm-{major}");
        setup::debian(&[&package])?;
        of_debian().ok_or_else(|| format!("{package} has no llvm-cov"))
    }

    fn at(profdata: PathBuf, cov: PathBuf) -> Option<Self> {
        (profdata.exists() && cov.exists()).then_some(Self { profdata, cov })
    }
}

/// Builds the tests with counters.
fn build(target: &Path) -> Result<Vec<TestProgram>, String> {
    let mut build = cargo(&["test", "--no-run", "--message-format=json"]);
    build.args(["-p", "lafet-device", "-p", "lafet-ballistics"]);
    build.env("CARGO_TARGET_DIR", target);
    // Counting branches needs unstable compiler options.
    build.env("RUSTC_BOOTSTRAP", "1");
    build.env("RUSTFLAGS", "-Cinstrument-coverage -Zcoverage-options=branch");
    let messages = output(&mut build)?;
    Ok(test_programs(&messages).filter(|test| test.name != LEFT_OUT).collect())
}

fn files(directory: &Path, extension: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(directory).map_err(|e| e.to_string())?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    Ok(paths.filter(|path| path.extension().is_some_and(|e| e == extension)).collect())
}

/// Coverage of a file.
#[derive(Debug, Default, PartialEq)]
struct File {
    name: String,
    /// Lines reached, of total.
    lines: (usize, usize),
    /// Branches taken, of total; a condition has two.
    branches: (usize, usize),
    /// Lines that were not reached, or have a branch that was not taken.
    holes: BTreeSet<usize>,
}

impl File {
    fn hole(&self) -> Option<String> {
        let whole = WHOLE.contains(&self.name.as_str());
        (whole && !self.holes.is_empty()).then(|| format!("{}: lines {:?}", self.name, self.holes))
    }
}

/// The files of the device in an lcov report: `SF:path`, `DA:line,count`,
/// `BRDA:line,block,branch,taken`.
fn measured(lcov: &str) -> Vec<File> {
    let mut files: Vec<File> = Vec::new();
    let mut wanted = false;
    for line in lcov.lines() {
        let Some((kind, rest)) = line.split_once(':') else { continue };
        if kind == "SF" {
            let of = |(source, prefix): (&str, &str)| {
                rest.split_once(source).map(|(_, name)| format!("{prefix}{name}"))
            };
            let name = SOURCES.into_iter().find_map(of);
            let name = name.filter(|name| !TESTS.iter().any(|test| name.ends_with(test)));
            wanted = name.is_some();
            files.extend(name.map(|name| File { name, ..File::default() }));
        }
        let Some(file) = files.last_mut().filter(|_| wanted) else { continue };
        let mut fields = rest.split(',');
        let number = fields.next().and_then(|field| field.parse().ok()).unwrap_or(0);
        let reached = fields.next_back().is_some_and(|count| !matches!(count, "0" | "-"));
        let counted = match kind {
            "DA" => &mut file.lines,
            "BRDA" => &mut file.branches,
            _ => continue,
        };
        *counted = (counted.0 + usize::from(reached), counted.1 + 1);
        if !reached {
            file.holes.insert(number);
        }
    }
    files
}

fn table(files: &[File]) -> String {
    let percent = |(covered, count): (usize, usize)| match count {
        0 => "-".into(),
        _ => format!("{:.1} %", 100.0 * covered as f64 / count as f64),
    };
    let mut text =
        String::from("| file | lines | | branches | | not reached |\n|---|--:|--:|--:|--:|---|\n");
    let mut sum = [(0, 0); 2];
    let row = |text: &mut String, name: &str, lines, branches, holes: &BTreeSet<usize>| {
        let holes: Vec<String> = holes.iter().take(12).map(usize::to_string).collect();
        let (l, b): ((usize, usize), (usize, usize)) = (lines, branches);
        let _ = writeln!(
            text,
            "| {name} | {}/{} | {} | {}/{} | {} | {} |",
            l.0,
            l.1,
            percent(l),
            b.0,
            b.1,
            percent(b),
            holes.join(" ")
        );
    };
    for file in files {
        row(&mut text, &file.name, file.lines, file.branches, &file.holes);
        for (sum, (covered, count)) in sum.iter_mut().zip([file.lines, file.branches]) {
            *sum = (sum.0 + covered, sum.1 + count);
        }
    }
    let [lines, branches] = sum;
    row(&mut text, "together", lines, branches, &BTreeSet::new());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read() {
        let lcov = "SF:/x/crates/device/src/guard.rs\nDA:1,5\nDA:2,0\nBRDA:1,0,0,3\n\
                    BRDA:1,0,1,-\nLF:2\nend_of_record\nSF:/x/other.rs\nDA:1,0\n";
        let [file] = &measured(lcov)[..] else { panic!("one file") };
        assert_eq!((file.lines, file.branches), ((1, 2), (1, 2)));
        assert_eq!(file.holes, BTreeSet::from([1, 2]));
        assert_eq!(file.hole().as_deref(), Some("guard.rs: lines {1, 2}"));
        assert!(measured("SF:/x/crates/device/src/chain.rs\nDA:1,1\n")[0].hole().is_none());
    }
}
