//! A bare Debian in a folder, booted: packages are installed in it as on a new machine, and systemd
//! starts what they bring.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::tools;
use super::trial::until;
use crate::run::{self, StepResult, output, show};

/// The release that is tested with.
const RELEASE: &str = "bookworm";
/// Beside what every Debian has: what starts services.
const INCLUDED: &str = "systemd,systemd-sysv,udev";
/// What its programs find, and nothing else of this environment.
const CLEAN: [&str; 6] = [
    "/usr/bin/env",
    "-i",
    "PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
    "DEBIAN_FRONTEND=noninteractive",
    "LC_ALL=C.UTF-8",
    "HOME=/root",
];

/// Unpacks it into an empty folder. It is made once, from Debian's mirror, and kept.
pub fn unpack(folder: &Path) -> StepResult {
    let packed = packed()?;
    output(tools::command("tar", "tar")?.arg("-xf").arg(packed).arg("-C").arg(folder)).map(drop)
}

fn packed() -> Result<PathBuf, String> {
    let packed = run::target().join(format!("dist-{RELEASE}.tar"));
    if packed.is_file() {
        return Ok(packed);
    }
    let new = packed.with_extension("new.tar");
    let mut make = tools::command("mmdebstrap", "mmdebstrap")?;
    make.args(["--quiet", "--variant=minbase", "--include", INCLUDED]);
    // Texts in other languages take longest to unpack.
    make.arg("--dpkgopt=path-exclude=/usr/share/locale/*");
    show(make.arg(RELEASE).arg(&new))?;
    std::fs::rename(&new, &packed).map_err(|e| format!("{}: {e}", packed.display()))?;
    Ok(packed)
}

/// A Debian that runs, with a network of its own that reaches nothing.
#[derive(Debug)]
pub struct Machine {
    root: PathBuf,
    nspawn: Child,
    /// Its first process.
    leader: String,
}

impl Machine {
    /// Boots it; what it prints is in `boot.log` beside the folder.
    pub fn boot(root: &Path) -> Result<Self, String> {
        let log = root.with_extension("boot.log");
        let file = std::fs::File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        let errors = file.try_clone().map_err(|e| e.to_string())?;
        let mut nspawn = tools::command("systemd-nspawn", "systemd-container")?;
        nspawn.args(["--quiet", "--boot", "--register=no", "--keep-unit", "--private-network"]);
        nspawn.arg("--directory").arg(root);
        nspawn.stdin(Stdio::null()).stdout(file).stderr(errors);
        let nspawn = nspawn.spawn().map_err(|e| format!("systemd-nspawn: {e}"))?;
        let mut machine = Self { root: root.to_owned(), nspawn, leader: String::new() };
        let up = until("the Debian has booted", || {
            machine.leader = first_child(machine.nspawn.id())?;
            // `degraded` is a machine without some device; the exit code says so, too.
            let asks = "systemctl is-system-running || true";
            let state = machine.said(&["sh", "-c", asks])?;
            Ok(["running", "degraded"].contains(&state.trim()))
        });
        up.map_err(|e| format!("{e}\nsystemd-nspawn needs root; {} has more", log.display()))?;
        Ok(machine)
    }

    /// A command in it, as root.
    pub fn root(&self, words: &[&str]) -> Command {
        let mut command = Command::new("nsenter");
        command.args(["--target", &self.leader, "--mount", "--uts", "--ipc", "--net", "--pid"]);
        command.arg("--").args(CLEAN).args(words);
        command
    }

    /// The output of a command as root.
    pub fn said(&self, words: &[&str]) -> Result<String, String> {
        output(&mut self.root(words))
    }

    /// A program of this machine, in its network.
    pub fn beside(&self) -> Vec<String> {
        ["nsenter", "--target", &self.leader, "--net", "--"].map(str::to_owned).into()
    }

    /// A path in it, from outside.
    pub fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// Whether a path exists in it.
    pub fn has(&self, path: &str) -> bool {
        self.path(path).symlink_metadata().is_ok()
    }

    pub fn read(&self, path: &str) -> Result<String, String> {
        let path = self.path(path);
        std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
    }

    pub fn write(&self, path: &str, text: &str) -> StepResult {
        let path = self.path(path);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // Its first process ends all others with it.
        if !self.leader.is_empty() {
            let _ = output(Command::new("kill").args(["-KILL", &self.leader]));
        } else {
            let _ = self.nspawn.kill();
        }
        let _ = self.nspawn.wait();
    }
}

/// The process that systemd-nspawn has started.
fn first_child(of: u32) -> Result<String, String> {
    let path = format!("/proc/{of}/task/{of}/children");
    let children = std::fs::read_to_string(&path).map_err(|e| format!("{path}: {e}"))?;
    let is_init = |id: &&str| {
        let name = std::fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default();
        ["systemd", "init"].contains(&name.trim())
    };
    let first = children.split_whitespace().find(is_init);
    first.map(str::to_owned).ok_or_else(|| "systemd does not run yet".to_owned())
}
