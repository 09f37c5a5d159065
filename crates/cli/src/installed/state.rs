//! The folder of the state: whose it is, who else may look into it, and which program wrote it.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

use lafet_client::doctor::Severity;
use lafet_client::os_text;
use lafet_hub::store::{StateFile, newer};
use lafet_texts::{Text as _, cli as text};

use super::Finding;
use super::people::{User, WRITE, is_open};
use crate::lang::current;

/// Whether a hub uses the folder now.
pub fn is_running(folder: &Path) -> bool {
    keep_off(folder).is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock)
}

/// Keeps the hub of this folder from its start, as long as the file is open; `None`: no hub has used it yet.
///
/// # Errors
///
/// `WouldBlock` while a hub uses the folder; a folder that this user may not look into.
pub fn keep_off(folder: &Path) -> io::Result<Option<File>> {
    let file = match File::open(folder.join("lock")) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        file => file?,
    };
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(io::ErrorKind::WouldBlock.into()),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Whether the hub's user, and no other, can use the folder.
pub fn examine(folder: &Path, user: &User) -> Vec<Finding> {
    let shown = folder.display().to_string();
    if !folder.exists() {
        return vec![of_new(folder, &shown, user)];
    }
    if let Err(error) = std::fs::read_dir(folder) {
        return vec![hidden(&shown, &error)];
    }
    let mut findings = Vec::new();
    let names = StateFile::ALL.map(StateFile::name);
    let mut paths = names.iter().map(|name| folder.join(name)).chain([folder.to_owned()]);
    if let Some(path) = paths.find(|path| user.is_foreign(path)) {
        let path = path.display().to_string();
        findings.push(Finding::fault(
            "state-owner",
            text::InstallStateOwner { path: &path, user: &user.name }.of(current()),
            format!("chown -R {0}: {shown}", user.name),
        ));
    }
    if is_open(folder) {
        findings.push(Finding::warning(
            "state-open",
            text::InstallStateOpen { folder: &shown }.of(current()),
            format!("chmod 0700 {shown}"),
        ));
    }
    match newer(folder) {
        Ok(None) => {}
        Ok(Some(newer)) => findings.push(Finding::fault(
            "state-newer",
            newer.words().of(current()).to_owned(),
            text::InstallStateNewerRemedy.str(current()).into(),
        )),
        Err(error) => findings.push(Finding {
            name: "state-unreadable",
            severity: Severity::Fault,
            ..hidden(&shown, &error)
        }),
    }
    if findings.is_empty() {
        findings.push(Finding::good("state", text::InstallState { folder: &shown }.of(current())));
    }
    findings
}

/// What this user may not look at; the hub's user may.
fn hidden(path: &str, error: &io::Error) -> Finding {
    let seen = format!("{path}: {}", os_text(error, current()));
    Finding::warning("state-hidden", seen, text::InstallAsRoot.str(current()).into())
}

/// A folder that the first start makes.
fn of_new(folder: &Path, shown: &str, user: &User) -> Finding {
    let above = folder.ancestors().skip(1).find(|it| it.exists());
    if above.is_some_and(|above| user.may(above, WRITE)) {
        return Finding::good("state", text::InstallStateNew { folder: shown }.of(current()));
    }
    Finding::fault(
        "state-denied",
        text::InstallStateDenied { folder: shown, user: &user.name }.of(current()),
        format!("install -d -m 0700 -o {} {shown}", user.name),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Root, which runs tests, may look into every folder.
    #[test]
    fn a_folder_that_this_user_cannot_look_into_is_no_fault() {
        let finding = hidden("/var/lib/lafet", &io::ErrorKind::PermissionDenied.into());
        assert_eq!((finding.name, finding.severity), ("state-hidden", Severity::Warning));
        assert!(finding.seen.starts_with("/var/lib/lafet: ") && finding.remedy.is_some());
    }

    /// A folder where a file should be cannot be read by any user.
    #[test]
    fn a_file_that_cannot_be_read_is_reported() {
        let folder = std::env::temp_dir().join(format!("lafet-state-odd-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("hub.db")).unwrap();
        let found = examine(&folder, &User::current());
        assert!(found.iter().any(|it| it.name == "state-unreadable"), "{found:#?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
