//! What systemd says of the unit and the clock.

use std::process::{Command, Stdio};

use lafet_texts::{Text as _, cli as text};

use super::Finding;
use crate::lang::current;

/// The unit that `lafet serve --unit` prints and the package installs.
pub const UNIT: &str = "lafet-hub.service";

/// Nothing where systemd does not run: then something else starts the hub.
pub fn examine() -> Vec<Finding> {
    let Some(system) = said("systemctl", &["is-system-running"]) else { return Vec::new() };
    if system.is_empty() || system == "offline" {
        return Vec::new();
    }
    let properties = ["show", UNIT, "-p", "LoadState,UnitFileState,ActiveState,MainPID"];
    let shown = said("systemctl", &properties).unwrap_or_default();
    let mut findings = unit(&shown);
    // Other programs than systemd's may set the clock; they report to the kernel, as this asks.
    let clock = said("timedatectl", &["show", "-p", "NTPSynchronized", "--value"]);
    if clock.as_deref() == Some("no") {
        findings.push(Finding::warning(
            "clock",
            text::InstallClock.str(current()).into(),
            text::InstallClockRemedy.str(current()).into(),
        ));
    }
    findings
}

fn unit(shown: &str) -> Vec<Finding> {
    let property = |name: &str| {
        let of = |line: &'_ str| Some(line.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        shown.lines().find_map(of).unwrap_or_default()
    };
    if property("LoadState") == "masked" {
        return vec![Finding::warning(
            "unit-masked",
            text::InstallUnitMasked { unit: UNIT }.of(current()),
            format!("systemctl unmask {UNIT}"),
        )];
    }
    if property("LoadState") != "loaded" {
        return vec![Finding::warning(
            "unit-missing",
            text::InstallUnitMissing { unit: UNIT }.of(current()),
            format!("lafet serve --unit > /etc/systemd/system/{UNIT} && systemctl daemon-reload"),
        )];
    }
    let mut findings = Vec::new();
    if property("UnitFileState") != "enabled" {
        findings.push(Finding::warning(
            "unit-disabled",
            text::InstallUnitDisabled { unit: UNIT }.of(current()),
            format!("systemctl enable {UNIT}"),
        ));
    }
    match property("ActiveState").as_str() {
        "failed" => findings.push(Finding::fault(
            "unit-failed",
            text::InstallUnitFailed { unit: UNIT }.of(current()),
            format!("journalctl -u {UNIT} -n 20; systemctl restart {UNIT}"),
        )),
        "active" | "reloading" => {
            let seen = text::InstallUnitActive { unit: UNIT }.of(current());
            findings.push(match is_replaced(&property("MainPID")) {
                true => Finding::warning(
                    "program-old",
                    text::InstallProgramOld { unit: UNIT }.of(current()),
                    format!("systemctl restart {UNIT}"),
                ),
                false => Finding::good("unit", seen),
            });
        }
        _ => findings.push(Finding::warning(
            "unit-stopped",
            text::InstallUnitStopped { unit: UNIT }.of(current()),
            format!("systemctl start {UNIT}"),
        )),
    }
    findings
}

/// Whether the program of a process is not the file of its name any more.
fn is_replaced(process: &str) -> bool {
    let program = std::fs::read_link(format!("/proc/{process}/exe"));
    program.is_ok_and(|it| it.as_os_str().as_encoded_bytes().ends_with(b" (deleted)"))
}

/// The first output of a program, without the blanks around it; whatever its exit code.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new(program);
    let output = command.args(arguments).stdin(Stdio::null()).output().ok()?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
