//! The program without any library of the system, for each processor, the same wherever it is built.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Arch, Built, epoch, read, tools, work};
use crate::console;
use crate::run::{self, StepResult, output, show};

/// Builds it in this folder, for all processors at the same time.
pub fn build(arches: &[&'static Arch], profile: &str) -> Result<Vec<PathBuf>, String> {
    build_all(&run::root(), &run::target().join("dist-build"), arches, profile)
}

/// Most of a build's time one processor of this machine links.
fn build_all(
    root: &Path,
    target: &Path,
    arches: &[&'static Arch],
    profile: &str,
) -> Result<Vec<PathBuf>, String> {
    let commit = output(run::git().args(["rev-parse", "HEAD"]))?;
    tools::zig()?;
    for arch in arches {
        let add = ["target", "add", arch.triple];
        show(Command::new("rustup").args(add).current_dir(root))?;
    }
    std::thread::scope(|scope| {
        let build = |arch: &'static Arch| {
            let (commit, target) = (commit.trim(), target.join(arch.name));
            scope.spawn(move || build_in(root, &target, commit, (arch, profile)))
        };
        let all: Vec<_> = arches.iter().copied().map(build).collect();
        let joined =
            all.into_iter().map(|it| it.join().map_err(|_| "a build has panicked".to_owned())?);
        joined.collect()
    })
}

fn build_in(
    root: &Path,
    target: &Path,
    commit: &str,
    (arch, profile): (&Arch, &str),
) -> Result<PathBuf, String> {
    let programs = tools::zig()?;
    let mut cargo = Command::new(programs.join("cargo-zigbuild"));
    cargo.args(["zigbuild", "--locked", "--package", "lafet", "--target", arch.triple]);
    cargo.args(["--profile", profile, "--target-dir"]).arg(target).current_dir(root);
    let path = std::env::var("PATH").unwrap_or_default();
    cargo.env("PATH", format!("{}:{path}", programs.display()));
    // Builds at the same time do not write each other's scripts.
    cargo.env("CARGO_ZIGBUILD_CACHE_DIR", target.join("zigbuild"));
    // cargo sets these for us, and they would count as changes for packages.
    for name in ["CARGO_MANIFEST_DIR", "CARGO_TARGET_DIR", "RUSTC_WRAPPER"] {
        cargo.env_remove(name);
    }
    cargo.env("SOURCE_DATE_EPOCH", epoch()?).env("LAFET_COMMIT", commit);
    let [rust, c] = mapped(root, target)?;
    cargo.env("RUSTFLAGS", rust);
    cargo.env(format!("CFLAGS_{}", arch.triple.replace('-', "_")), c);
    show(&mut cargo)?;
    let folder = if profile == "dev" { "debug" } else { profile };
    let program = target.join(arch.triple).join(folder).join("lafet");
    without_paths(&program, &[root, target])?;
    Ok(program)
}

/// Flags that put the same names in place of the folders of this machine, for Rust and for C.
fn mapped(root: &Path, target: &Path) -> Result<[String; 2], String> {
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"]).current_dir(root))?;
    let folders = [
        (target.to_owned(), "/target"),
        (root.to_owned(), "/lafet"),
        (registry()?, "/cargo"),
        (PathBuf::from(sysroot.trim()), "/rust"),
    ];
    // The last one that fits decides; the folder of the build may be in that of the sources.
    let sorted = folders.iter().rev();
    let rust =
        sorted.clone().map(|(it, name)| format!("--remap-path-prefix={}={name}", it.display()));
    let c = sorted.map(|(it, name)| format!("-ffile-prefix-map={}={name}", it.display()));
    Ok([rust.collect::<Vec<_>>().join(" "), c.collect::<Vec<_>>().join(" ")])
}

/// The folder of cargo's packages.
fn registry() -> Result<PathBuf, String> {
    let home = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo"));
    let cargo = std::env::var_os("CARGO_HOME").map(PathBuf::from).or_else(home);
    cargo.ok_or_else(|| "neither CARGO_HOME nor HOME is set".to_owned())
}

/// Fails if a program contains a folder of this machine.
fn without_paths(program: &Path, folders: &[&Path]) -> StepResult {
    let bytes = read(program)?;
    let registry = registry()?;
    for folder in folders.iter().copied().chain([registry.as_path()]) {
        let path = folder.as_os_str().as_encoded_bytes();
        if let Some(at) = bytes.windows(path.len()).position(|it| it == path) {
            let end = bytes.len().min(at + 120);
            let shown = String::from_utf8_lossy(&bytes[at..end]).into_owned();
            return Err(format!("{}: contains a path of this machine: {shown}", program.display()));
        }
    }
    Ok(())
}

/// Builds it again from the last commit in another folder, its console too, and compares with the program of this folder.
pub fn twice(arches: &[&'static Arch], profile: &str) -> StepResult {
    super::without_changes()?;
    console::build()?;
    let first = build(arches, profile)?;
    let folder = work("the-second-folder")?;
    let pack = "git archive HEAD | tar -x -C \"$0\"";
    show(Command::new("sh").args(["-c", pack]).arg(&folder).current_dir(run::root()))?;
    let console = folder.join("console");
    show(Command::new("npm").args(["ci", "--no-audit", "--no-fund"]).current_dir(&console))?;
    show(Command::new("npm").args(["run", "build"]).current_dir(&console))?;
    let second = build_all(&folder, &folder.join("target"), arches, profile)?;
    for (arch, (first, second)) in arches.iter().zip(first.iter().zip(&second)) {
        let sums = [super::sums::of(first)?, super::sums::of(second)?];
        if sums[0] != sums[1] {
            return Err(format!("{}: the two builds differ: {sums:?}", arch.name));
        }
        println!("   {} {}, both times", arch.name, sums[0]);
    }
    Ok(())
}

/// Runs a program that was built, with an emulator where this machine has another processor.
pub fn command(built: &Built) -> Result<Command, String> {
    let own = if std::env::consts::ARCH == "x86_64" { "amd64" } else { "arm64" };
    if built.arch.name == own {
        return Ok(Command::new(&built.program));
    }
    let mut emulator = tools::command(built.arch.emulator, "qemu-user-static")?;
    emulator.arg(&built.program);
    Ok(emulator)
}
