//! The program `lafet serve`, as a process of its own.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::Fallible;
use crate::site::NICE;

/// A hub that runs.
pub struct Hub {
    child: Child,
    /// Where it listens: `127.0.0.1:PORT`.
    pub place: String,
}

/// What a process has used so far.
#[derive(Clone, Copy)]
pub struct Used {
    /// Processor time, s.
    pub cpu_s: f64,
    /// Its priority: `nice`.
    pub nice: f64,
    /// Memory, KiB.
    pub memory_kib: f64,
    /// The most memory since [`Hub::forget_peak`], KiB.
    pub peak_kib: f64,
}

impl Hub {
    /// Starts it. A file that may not grow is an error to it, as a full disk is, and no signal.
    pub fn start(lafet: &Path, config: &Path) -> Fallible<Self> {
        let mut command = first("sh");
        command.args(["-c", "trap '' XFSZ; exec \"$0\" --json serve --no-browser --config \"$1\""]);
        Self::of(command.arg(lafet).arg(config))
    }

    /// The same with users; the link to make the first administrator, if there is none.
    pub fn with_users(lafet: &Path, config: &Path) -> Fallible<(Self, Option<String>)> {
        let mut command = first(lafet);
        command.args(["--json", "serve", "--no-browser", "--config"]).arg(config);
        let (hub, said) = Self::said(&mut command)?;
        Ok((hub, said["setup"].as_str().map(str::to_owned)))
    }

    /// Starts the demo.
    pub fn demo(lafet: &Path) -> Fallible<Self> {
        Self::of(first(lafet).args(["--json", "demo", "--no-browser", "--port", "0"]))
    }

    fn of(command: &mut Command) -> Fallible<Self> {
        Ok(Self::said(command)?.0)
    }

    fn said(command: &mut Command) -> Fallible<(Self, Value)> {
        let mut child = command.env("LAFET_LOG", "off").stdout(Stdio::piped()).spawn()?;
        let mut line = String::new();
        BufReader::new(child.stdout.take().ok_or("no output")?).read_line(&mut line)?;
        let said: Value = serde_json::from_str(&line).map_err(|_| format!("it said `{line}`"))?;
        let url = said["listening"].as_str().ok_or("no address")?;
        let place = url.trim_start_matches("http://").trim_start_matches("https://").to_owned();
        Ok((Self { child, place }, said))
    }

    /// Files that it writes may not grow any more, or again.
    pub fn fill_disk(&self, full: bool) -> Fallible<()> {
        let limit = if full { "--fsize=1:unlimited" } else { "--fsize=unlimited:unlimited" };
        let pid = self.child.id().to_string();
        let done = Command::new("prlimit").args(["--pid", &pid, limit]).status()?;
        if done.success() { Ok(()) } else { Err("prlimit does not set the limit".into()) }
    }

    /// Kills it: `kill -9`.
    pub fn kill(mut self) -> Fallible<()> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// What it has used so far (Linux).
    pub fn used(&self) -> Fallible<Used> {
        let folder = PathBuf::from(format!("/proc/{}", self.child.id()));
        let stat = std::fs::read_to_string(folder.join("stat"))?;
        // Behind the name, which may have blanks in it.
        let fields: Vec<&str> =
            stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
        let ticks = |index: usize| fields.get(index).and_then(|it| it.parse::<f64>().ok());
        let nice = ticks(16).unwrap_or(0.0);
        let cpu_s = (ticks(11).unwrap_or(0.0) + ticks(12).unwrap_or(0.0)) / 100.0;
        let status = std::fs::read_to_string(folder.join("status"))?;
        let kib = |name: &str| -> Fallible<f64> {
            let line =
                status.lines().find_map(|line| line.strip_prefix(name)).ok_or("no figure")?;
            Ok(line.split_whitespace().next().ok_or("no figure")?.parse()?)
        };
        Ok(Used { cpu_s, nice, memory_kib: kib("VmRSS:")?, peak_kib: kib("VmHWM:")? })
    }

    /// The most memory counts from now on.
    pub fn forget_peak(&self) -> Fallible<()> {
        Ok(std::fs::write(format!("/proc/{}/clear_refs", self.child.id()), "5")?)
    }
}

/// A program with the priority that the unit gives the hub, before those that flood it: they would be on other machines.
/// If that is not permitted, it runs all the same.
pub fn first(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new("nice");
    command.args(["-n", NICE]).arg(program);
    command
}

impl Drop for Hub {
    fn drop(&mut self) {
        // It may have ended already.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}
