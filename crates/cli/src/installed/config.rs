//! The configuration: whether it is there, can be read, is right, and is safe from other users.

use std::io;
use std::path::{Path, PathBuf};

use lafet_client::os_text;
use lafet_hub::Config;
use lafet_texts::{Shown, Text as _, cli as text};

use super::Finding;
use super::people::{READ, User, WRITE};
use crate::lang::current;

/// What can be said of the file without its contents.
pub fn of_file(file: &Path, user: &User) -> Vec<Finding> {
    let shown = file.display().to_string();
    if let Err(error) = std::fs::File::open(file) {
        return vec![closed(&shown, &error)];
    }
    let mut findings = Vec::new();
    if !user.may(file, READ) {
        findings.push(Finding::fault(
            "config-denied",
            text::InstallConfigDenied { user: &user.name, file: &shown }.of(current()),
            text::InstallConfigDeniedRemedy { user: &user.name, file: &shown }.of(current()),
        ));
    }
    if user.is_changed_by_others(file) {
        findings.push(Finding::fault(
            "config-writable",
            text::InstallConfigWritable { file: &shown }.of(current()),
            format!("chown root {shown} && chmod go-w {shown}"),
        ));
    }
    findings
}

fn closed(file: &str, error: &io::Error) -> Finding {
    if error.kind() == io::ErrorKind::NotFound {
        return Finding::fault(
            "config-missing",
            text::InstallConfigMissing { file }.of(current()),
            text::InstallConfigMissingRemedy { file }.of(current()),
        );
    }
    let seen = format!("{file}: {}", os_text(error, current()));
    Finding::fault("config-unreadable", seen, text::InstallAsRoot.str(current()).into())
}

/// The file contains errors.
pub fn wrong(file: &Path, errors: &str) -> Finding {
    let remedy = text::InstallConfigWrongRemedy { file: Shown(file.display()) };
    Finding::fault("config-wrong", errors.to_owned(), remedy.of(current()))
}

/// The file has no errors; its warnings.
pub fn read(file: &Path, config: &Config) -> Vec<Finding> {
    let (file, count) = (file.display().to_string(), config.monitors.len());
    let good = text::ConfigGood { file: &file, count, listen: Shown(config.listen) };
    let mut findings = vec![Finding::good("config", good.of(current()))];
    findings.extend(config.warnings.iter().map(|it| {
        let seen = format!("{}: {}", it.place, it.what.of(current()));
        Finding::warning("config-warning", seen, it.remedy.of(current()).into())
    }));
    findings
}

/// What the configuration names and the hub's user may not read or write; who asks may be another one.
pub fn of_named(config: &Config, user: &User) -> Vec<Finding> {
    let tls = config.tls.iter().flat_map(|tls| {
        [Some(&tls.cert), Some(&tls.key), tls.client_ca.as_ref()].into_iter().flatten()
    });
    let closed = |path: &&PathBuf| path.exists() && !user.may(path, READ);
    let files = tls.filter(closed).map(|path| {
        let file = path.display().to_string();
        Finding::fault(
            "file-denied",
            text::InstallConfigDenied { user: &user.name, file: &file }.of(current()),
            text::InstallConfigDeniedRemedy { user: &user.name, file: &file }.of(current()),
        )
    });
    let folder = config.recording.folder.iter().filter(|it| it.exists());
    let folders = folder.filter(|it| !user.may(it, READ | WRITE)).map(|path| {
        let folder = path.display().to_string();
        Finding::fault(
            "recordings-denied",
            text::InstallRecordingsDenied { user: &user.name, folder: &folder }.of(current()),
            format!("chown {} {folder}", user.name),
        )
    });
    files.chain(folders).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Root, which runs tests, may read every file.
    #[test]
    fn a_file_that_cannot_be_read_is_another_matter_than_one_that_is_missing() {
        let finding = closed("hub.toml", &io::ErrorKind::PermissionDenied.into());
        assert_eq!(finding.name, "config-unreadable");
        assert!(finding.seen.starts_with("hub.toml: ") && finding.remedy.is_some());
        let finding = closed("hub.toml", &io::ErrorKind::NotFound.into());
        assert_eq!(finding.name, "config-missing");
    }
}
