//! `lafet doctor --install`: whether the hub of this machine can work as it is installed.
//!
//! It opens nothing that the hub uses: no serial port, no database.

mod config;
mod listen;
mod people;
mod ports;
mod service;
mod state;

use std::path::{Path, PathBuf};

use lafet_client::doctor::Severity;
use lafet_hub::{Config, Overrides};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::cmd::serve::{FILES, config as read_config};
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;
use people::User;
pub use state::keep_off;

/// What the package calls the hub's user.
const USER: &str = "lafet";
/// Where the unit has the state, unless the configuration names a folder.
const STATE: &str = "/var/lib/lafet";

/// Something about the installation.
#[derive(Debug)]
pub struct Finding {
    /// Name for programs.
    name: &'static str,
    severity: Severity,
    seen: String,
    /// What to do; nothing where all is well.
    remedy: Option<String>,
}

impl Finding {
    fn good(name: &'static str, seen: String) -> Self {
        Self { name, severity: Severity::Good, seen, remedy: None }
    }

    fn warning(name: &'static str, seen: String, remedy: String) -> Self {
        Self { name, severity: Severity::Warning, seen, remedy: Some(remedy) }
    }

    fn fault(name: &'static str, seen: String, remedy: String) -> Self {
        Self { name, severity: Severity::Fault, seen, remedy: Some(remedy) }
    }

    fn line(&self) -> String {
        let mark = match self.severity {
            Severity::Good => text::SeverityGood.str(current()),
            Severity::Warning => text::SeverityWarning.str(current()),
            Severity::Fault => text::SeverityFault.str(current()),
        };
        let width = text::SeverityFault.str(current()).chars().count();
        let width = width.max(text::SeverityWarning.str(current()).chars().count());
        let seen = format!("{mark:width$}  {}", self.seen);
        match &self.remedy {
            Some(remedy) => format!("{seen}\n{:width$}→ {remedy}", ""),
            None => seen,
        }
    }

    fn json(&self) -> Value {
        let severity = match self.severity {
            Severity::Good => "good",
            Severity::Warning => "warning",
            Severity::Fault => "fault",
        };
        let (finding, seen) = (self.name, &self.seen);
        json!({ "finding": finding, "severity": severity, "seen": seen, "remedy": self.remedy })
    }
}

/// Examines the installation and prints the findings.
pub fn run(file: Option<&Path>, user: Option<&str>, out: &mut Out) -> Outcome {
    let usual = || FILES.iter().map(PathBuf::from).find(|path| path.is_file());
    let file = file.map(Path::to_owned).or_else(usual).unwrap_or_else(|| FILES[1].into());
    let (user, found) = match User::of_hub(user, USER) {
        Ok(user) => (user, Vec::new()),
        Err(unknown) => (User::current(), vec![unknown]),
    };
    let mut findings = found;
    findings.extend(examine(&file, &user));
    let name = file.display().to_string();
    let mut lines = vec![text::InstallHead { file: &name, user: &user.name }.of(current())];
    lines.extend(findings.iter().map(Finding::line));
    let all = || findings.iter().map(Finding::json).collect::<Vec<_>>();
    out.show(lines.join("\n"), || json!({ "config": name, "user": user.name, "findings": all() }))?;
    match findings.iter().map(|it| it.severity).max() {
        Some(Severity::Fault) => Err(Failure::Ended(String::new())),
        _ => Ok(()),
    }
}

/// What a hub takes instead of what is in this file: the environment's, and for the file of the package what its unit
/// sets.
pub fn overrides(file: &Path) -> Overrides {
    let mut overrides = Overrides::of_environment(|name| std::env::var(name).ok());
    let whole = file.canonicalize();
    if whole.as_deref().unwrap_or(file) == Path::new(FILES[1]) {
        overrides.state.get_or_insert_with(|| STATE.into());
    }
    overrides
}

fn examine(file: &Path, user: &User) -> Vec<Finding> {
    let mut findings = config::of_file(file, user);
    let config: Option<Config> = match read_config(file, &overrides(file)) {
        Ok(config) => Some(config),
        // A file that cannot be read has been reported.
        Err(Failure::Io { .. }) => None,
        Err(wrong) => {
            findings.push(config::wrong(file, &wrong.message()));
            None
        }
    };
    if let Some(config) = config {
        findings.extend(config::read(file, &config));
        findings.extend(config::of_named(&config, user));
        let state = config.data.clone().unwrap_or_default();
        let running = state::is_running(&state);
        findings.extend(state::examine(&state, user));
        findings.extend(ports::examine(&config, user, running));
        findings.extend(listen::examine(config.listen, running));
    }
    findings.extend(service::examine());
    findings
}
