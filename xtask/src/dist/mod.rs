//! `cargo xtask dist`: what users install, and the test that they can.
//!
//! ```text
//! binary (zig, musl) ─▶ files ─┬▶ deb ───┐
//!                              ├▶ archive ├▶ sums, signatures
//! bill, copyright ─────────────┼▶ image ──┘
//!                              └▶ trial: install, use, upgrade, remove in a bare Debian
//! ```
//!
//! Everything that is written depends on the commit alone: times are the commit's, names are sorted.

mod archive;
mod bill;
mod binary;
mod copyright;
mod deb;
mod files;
mod http;
mod image;
mod lint;
mod root;
mod state;
mod sums;
mod tools;
mod trial;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::run::{self, StepResult, output};
use crate::{TaskResult, console, demo, metadata};

/// A processor that packages are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arch {
    /// As Debian and OCI name it.
    name: &'static str,
    /// As Rust names it.
    triple: &'static str,
    /// What runs its programs on another processor: a program and its Debian package.
    emulator: &'static str,
}

static ARCHES: [Arch; 2] = [
    Arch { name: "amd64", triple: "x86_64-unknown-linux-musl", emulator: "qemu-x86_64-static" },
    Arch { name: "arm64", triple: "aarch64-unknown-linux-musl", emulator: "qemu-aarch64-static" },
];
/// The program as it is shipped; for a try, another.
const PROFILE: &str = "dist";

/// What was asked for.
#[derive(Debug, Default, PartialEq, Eq)]
struct Wanted {
    arches: Vec<&'static Arch>,
    profile: Option<String>,
    key: Option<PathBuf>,
    task: What,
}

#[derive(Debug, Default, PartialEq, Eq)]
enum What {
    /// All files.
    #[default]
    Files,
    /// The same, from a clean commit, with the test.
    Release,
    /// The test alone, with what was built.
    Test,
    /// The test with the program of the other steps of CI.
    Quick,
    /// Two builds in two folders, compared.
    Twice,
    /// What a hub of this program leaves, for the tests of later versions.
    State(PathBuf),
}

pub fn dist(arguments: &[String]) -> TaskResult {
    let wanted = parse(arguments)?;
    let profile = wanted.profile.as_deref().unwrap_or(PROFILE);
    let arches = if wanted.arches.is_empty() { ARCHES.iter().collect() } else { wanted.arches };
    match wanted.task {
        What::Files => files(&arches, profile, wanted.key.as_deref())?,
        What::Release => release(&arches, profile, wanted.key.as_deref())?,
        What::Test => trial::run(&out()?, &arches)?,
        What::Quick => check()?,
        What::Twice => binary::twice(&arches, profile)?,
        What::State(program) => state::pack(&program)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn parse(arguments: &[String]) -> Result<Wanted, String> {
    let mut wanted = Wanted::default();
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let mut value = || words.next().cloned().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--arch" => wanted.arches.push(arch(&value()?)?),
            "--profile" => wanted.profile = Some(value()?),
            "--key" => wanted.key = Some(value()?.into()),
            "--release" => wanted.task = What::Release,
            "--test" => wanted.task = What::Test,
            "--quick" => wanted.task = What::Quick,
            "--twice" => wanted.task = What::Twice,
            "--state" => wanted.task = What::State(value()?.into()),
            other => return Err(format!("unexpected argument `{other}`: cargo xtask dist --help")),
        }
    }
    Ok(wanted)
}

fn arch(name: &str) -> Result<&'static Arch, String> {
    let names = || ARCHES.map(|it| it.name).join(", ");
    ARCHES.iter().find(|it| it.name == name).ok_or_else(|| format!("--arch is one of {}", names()))
}

/// A step of CI: the package with the program that other steps use, installed, upgraded and purged.
pub fn check() -> StepResult {
    let program = demo::program()?;
    let arch = &ARCHES[0];
    let (folder, built) = (work("quick")?, built(&program, arch, false)?);
    let stripped = folder.join("lafet");
    copy(&program, &stripped)?;
    output(tools::command("strip", "binutils")?.arg(&stripped))?;
    let built = Built { program: stripped, ..built };
    for version in [built.version.clone(), trial::next(&built.version)] {
        deb::make(&Built { version, ..built.clone() }, &folder)?;
    }
    bill::make(&folder, &built)?;
    sums::trial()?;
    trial::start(&folder, &built)
}

/// What is made of one program.
#[derive(Clone, Debug)]
pub struct Built {
    arch: &'static Arch,
    program: PathBuf,
    version: String,
    /// It needs no library of the system.
    is_static: bool,
    /// When the commit was made, s since 1970.
    epoch: String,
}

fn built(program: &Path, arch: &'static Arch, is_static: bool) -> Result<Built, String> {
    let (version, epoch) = (version()?, epoch()?);
    Ok(Built { arch, program: program.to_owned(), version, is_static, epoch })
}

fn files(arches: &[&'static Arch], profile: &str, key: Option<&Path>) -> StepResult {
    console::build()?;
    let out = out()?;
    clear(&out)?;
    for (arch, program) in arches.iter().zip(binary::build(arches, profile)?) {
        let built = built(&program, arch, true)?;
        let plain = out.join(format!("lafet-{}-linux-{}", built.version, arch.name));
        copy(&program, &plain)?;
        deb::make(&built, &out)?;
        archive::make(&built, &out)?;
        image::make(&built, &out)?;
        bill::make(&out, &built)?;
    }
    lint::packages(&out)?;
    sums::make(&out, key)?;
    println!("   {}", out.display());
    Ok(())
}

/// From a commit without changes, with a changelog, tested.
fn release(arches: &[&'static Arch], profile: &str, key: Option<&Path>) -> StepResult {
    without_changes()?;
    let (version, changes) = (version()?, run::read("CHANGELOG.md")?);
    if !changes.lines().any(|line| line.starts_with(&format!("## {version}"))) {
        return Err(format!("CHANGELOG.md has no section `## {version}`"));
    }
    files(arches, profile, key)?;
    trial::run(&out()?, arches)?;
    println!("   to publish: git tag v{version}, then the files of {}", out()?.display());
    Ok(())
}

/// What is built is the last commit.
fn without_changes() -> StepResult {
    let changed = output(run::git().args(["status", "--porcelain"]))?;
    match changed.trim() {
        "" => Ok(()),
        _ => Err(format!("these files are not committed:\n{changed}")),
    }
}

/// The version of the workspace.
fn version() -> Result<String, String> {
    let packages = metadata::workspace()?;
    let lafet = packages.into_iter().find(|it| it.name == "lafet");
    lafet.map(|it| it.version).ok_or_else(|| "the workspace has no package lafet".to_owned())
}

/// When the last commit was made; all times in what is shipped.
fn epoch() -> Result<String, String> {
    let time = output(run::git().args(["log", "-1", "--format=%ct"]))?;
    Ok(time.trim().to_owned())
}

/// The folder of all that is made.
fn out() -> Result<PathBuf, String> {
    let out = run::target().join("dist-files").join(version()?);
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    Ok(out)
}

/// An empty folder for what is only needed on the way.
fn work(name: &str) -> Result<PathBuf, String> {
    let folder = run::target().join("dist-work").join(name);
    clear(&folder)?;
    Ok(folder)
}

fn clear(folder: &Path) -> StepResult {
    let failed = |e| format!("{}: {e}", folder.display());
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(failed)?;
    }
    std::fs::create_dir_all(folder).map_err(failed)
}

fn copy(from: &Path, to: &Path) -> StepResult {
    std::fs::copy(from, to).map(drop).map_err(|e| format!("{}: {e}", to.display()))
}

fn write(path: &Path, text: impl AsRef<[u8]>) -> StepResult {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn arguments_are_read_strictly() {
        let wanted = parse(&words("--release --arch arm64 --key k --profile demo")).unwrap();
        assert_eq!((wanted.task, wanted.arches), (What::Release, vec![&ARCHES[1]]));
        assert_eq!((wanted.key, wanted.profile), (Some("k".into()), Some("demo".into())));
        assert_eq!(parse(&[]).unwrap(), Wanted::default());
        for wrong in ["--arch", "--arch mips", "--relaese", "amd64"] {
            assert!(parse(&words(wrong)).is_err(), "{wrong}");
        }
    }
}
