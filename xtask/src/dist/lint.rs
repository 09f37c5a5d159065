//! What Debian and systemd say of the packages.

use std::path::Path;

use super::root::Machine;
use super::tools;
use crate::run::{StepResult, show};

/// The highest exposure that `systemd-analyze security` may report, in tenths; it counts from 0 to 10.
const EXPOSURE_MAX: &str = "17";

/// lintian over every package in a folder.
pub fn packages(folder: &Path) -> StepResult {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let paths = entries.flatten().map(|it| it.path());
    for path in paths.filter(|path| path.extension().is_some_and(|it| it == "deb")) {
        let mut lintian = tools::command("lintian", "lintian")?;
        lintian.args(["--allow-root", "--fail-on", "error,warning", "--tag-display-limit", "0"]);
        show(lintian.arg(&path))?;
    }
    Ok(())
}

/// The unit, where it is installed: every line is understood, and little of the system is exposed.
pub fn unit(machine: &Machine) -> StepResult {
    machine.said(&["systemd-analyze", "verify", "--man=no", "lafet-hub.service"])?;
    let security = ["systemd-analyze", "security", "--no-pager", "--threshold", EXPOSURE_MAX];
    let said = machine.said(&[&security[..], &["lafet-hub.service"]].concat())?;
    let last = said.lines().rfind(|line| line.contains("Overall")).unwrap_or_default();
    println!("   {}", last.trim());
    Ok(())
}
