//! Prerequisites of the tasks: whatever is missing is installed, or named with its command.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::{metadata, run};

/// Fails unless the compiler is new enough for the workspace.
pub fn rust() -> Result<(), String> {
    let have = run::output(Command::new("rustc").arg("--version").current_dir(run::root()))?;
    let packages = metadata::workspace()?;
    let Some(need) = packages.iter().filter_map(|p| p.rust_version.as_deref()).max() else {
        return Ok(());
    };
    let word = have.split_whitespace().nth(1).unwrap_or_default();
    if version(word) >= version(need) {
        return Ok(());
    }
    Err(format!(
        "Rust {need} or newer is needed, this is {word}.\n\
         With rustup:   rustup toolchain install   (reads rust-toolchain.toml)\n\
         Without it:    install it from https://rustup.rs, or on Debian: \
         apt-get install rustc-web cargo-web"
    ))
}

/// Ensures that a toolchain component such as rustfmt is installed.
pub fn component(name: &str, subcommand: &str) -> Result<(), String> {
    if run::output(&mut run::cargo(&[subcommand, "--version"])).is_ok() {
        return Ok(());
    }
    println!("   {name} is missing: adding it");
    run::show(Command::new("rustup").args(["component", "add", name]).current_dir(run::root()))
        .map_err(|e| format!("{e}\n{name} is needed: rustup component add {name}"))
}

/// Ensures that the toolchain has the library for a target.
pub fn target(name: &str) -> Result<(), String> {
    let rustup = |arguments: &[&str]| {
        run::output(Command::new("rustup").args(arguments).current_dir(run::root()))
    };
    let installed = rustup(&["target", "list", "--installed"]);
    if installed.is_ok_and(|all| all.lines().any(|line| line.trim() == name)) {
        return Ok(());
    }
    println!("   the library for {name} is missing: adding it");
    rustup(&["target", "add", name])
        .map(|_| ())
        .map_err(|e| format!("{e}\n{name} is needed: rustup target add {name}"))
}

/// Ensures that a program of a Debian package is installed.
pub fn program(name: &str, package: &str) -> Result<(), String> {
    let version = match name {
        "openssl" => "version",
        "mbpoll" => "-V",
        _ => "--version",
    };
    if run::output(Command::new(name).arg(version)).is_ok() {
        return Ok(());
    }
    println!("   {name} is missing: installing it");
    debian(&[package])
}

/// Ensures that there is a PostgreSQL server to start in tests.
pub fn postgres() -> Result<(), String> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").into_iter().flatten().flatten();
    let mut programs = versions.map(|it| it.path().join("bin/initdb"));
    if programs.any(|it| it.is_file()) || std::env::var_os("LAFET_NO_POSTGRES").is_some() {
        return Ok(());
    }
    println!("   PostgreSQL is missing: installing it (not wanted: LAFET_NO_POSTGRES=1)");
    debian(&["postgresql"])
}

/// Installs the package of a program that has no option which succeeds without work, if it is missing.
pub fn found(name: &str, package: &str) -> Result<(), String> {
    if Command::new(name).arg("--help").output().is_ok() {
        return Ok(());
    }
    println!("   {name} is missing: installing it");
    debian(&[package])
}

/// A program of cargo's registry in this version, installed below target if it is missing; returns its path.
/// Compiled without optimization where it runs for a moment only.
pub fn tool(name: &str, version: &str, debug: bool) -> Result<PathBuf, String> {
    let tools = run::target().join("tools");
    let installed = std::fs::read_to_string(tools.join(".crates.toml")).unwrap_or_default();
    if !installed.contains(&format!("\"{name} {version} ")) {
        println!("   installing {name} {version} in {}", tools.display());
        let mut install =
            run::cargo(&["install", "--quiet", "--locked", name, "--version", version]);
        install.args(debug.then_some("--debug")).arg("--root").arg(&tools);
        run::show(&mut install)?;
    }
    Ok(tools.join("bin").join(name))
}

/// Ensures that there is a Python environment below target with these packages; returns the folder of its
/// programs.
pub fn python(name: &str, packages: &[&str]) -> Result<PathBuf, String> {
    let folder = run::target().join(name);
    let (programs, mark) = (folder.join("bin"), folder.join("installed"));
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&mark).is_ok_and(|installed| installed == wanted) {
        return Ok(programs);
    }
    program("python3", "python3")?;
    let make = || {
        let mut make = Command::new("python3");
        make.args(["-m", "venv"]).arg(&folder);
        make
    };
    if run::output(&mut make()).is_err() {
        debian(&["python3-venv"])?;
        run::show(&mut make())?;
    }
    run::show(Command::new(programs.join("pip")).args(["install", "-q"]).args(packages))?;
    std::fs::write(&mark, wanted).map_err(|e| format!("{}: {e}", mark.display()))?;
    Ok(programs)
}

/// Ensures that there is a folder below target with these packages of npm; returns where Node.js finds them.
pub fn node(name: &str, packages: &[&str]) -> Result<PathBuf, String> {
    let folder = run::target().join(name);
    let (modules, mark) = (folder.join("node_modules"), folder.join("installed"));
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&mark).is_ok_and(|installed| installed == wanted) {
        return Ok(modules);
    }
    program("node", "nodejs")?;
    program("npm", "npm")?;
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut install = Command::new("npm");
    install.args(["install", "--no-audit", "--no-fund", "--silent", "--prefix"]);
    run::show(install.arg(&folder).args(packages))?;
    std::fs::write(&mark, wanted).map_err(|e| format!("{}: {e}", mark.display()))?;
    Ok(modules)
}

/// Debian packages that steps of CI need, each with a program that shows whether it is there.
const IN_CI: [(&str, &str); 14] = [
    ("curl", "curl"),
    ("openssl", "openssl"),
    ("psql", "postgresql"),
    ("qemu-system-arm", "qemu-system-arm"),
    ("tshark", "tshark"),
    ("prlimit", "util-linux"),
    ("valgrind", "valgrind"),
    ("arm-none-eabi-gcc", "gcc-arm-none-eabi"),
    ("arm-none-eabi-gcc", "libnewlib-arm-none-eabi"),
    ("chromium", "chromium"),
    ("mbpoll", "mbpoll"),
    ("mmdebstrap", "mmdebstrap"),
    ("minisign", "minisign"),
    ("systemd-nspawn", "systemd-container"),
];
/// The package manager allows one at a time.
static INSTALLING: Mutex<()> = Mutex::new(());

/// Installs what the steps of CI need, in one go and silently, while others compile. A step whose program
/// is still missing then installs it itself, and reports why it cannot.
pub fn ahead() {
    let there = |name: &str| {
        let mut probe = Command::new("sh");
        run::output(probe.args(["-c", "command -v \"$0\"", name])).is_ok()
    };
    let lacking = IN_CI.into_iter().filter(|(name, _)| !there(name));
    let packages: Vec<&str> = lacking.map(|(_, package)| package).collect();
    if packages.is_empty() || !is_root() {
        return;
    }
    let _one = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = run::output(Command::new("apt-get").args(["update", "-q"]));
    let _ = run::output(&mut install(&packages));
}

fn is_root() -> bool {
    run::output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}

fn install(packages: &[&str]) -> Command {
    let mut install = Command::new("apt-get");
    // Another step may be installing.
    install.args(["-o", "DPkg::Lock::Timeout=600"]);
    install.args(["install", "-y", "--no-install-recommends"]).args(packages);
    install.env("DEBIAN_FRONTEND", "noninteractive");
    install
}

/// Installs Debian packages if permitted, else names the command.
pub fn debian(packages: &[&str]) -> Result<(), String> {
    let advice = format!("apt-get install -y --no-install-recommends {}", packages.join(" "));
    if !is_root() {
        return Err(format!("missing; as root: {advice}"));
    }
    let _one = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
    run::show(Command::new("apt-get").args(["update", "-q"]))
        .and_then(|()| run::show(&mut install(packages)))
        .map_err(|e| format!("{e}\nneeded: {advice}"))
}

/// Parses `1.95.0-nightly` into comparable numbers.
fn version(text: &str) -> Vec<u32> {
    let plain = text.split('-').next().unwrap_or_default();
    let mut parts: Vec<u32> = plain.split('.').map(|part| part.parse().unwrap_or(0)).collect();
    parts.resize(3, 0);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_by_number() {
        assert!(version("1.95.0") >= version("1.95"));
        assert!(version("1.100.0") > version("1.95.3"));
        assert!(version("1.94.1-nightly") < version("1.95"));
    }
}
