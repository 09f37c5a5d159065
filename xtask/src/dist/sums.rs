//! Digests of all files, and the signature of the list.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{tools, work, write};
use crate::run::{StepResult, output, show};

/// The list, as `sha256sum --check` reads it.
const LIST: &str = "SHA256SUMS";

/// Writes the list, and signs it where a key is given. The list names every file, so its signature is for all.
pub fn make(folder: &Path, key: Option<&Path>) -> StepResult {
    let names = names(folder)?;
    let list = output(Command::new("sha256sum").args(&names).current_dir(folder))?;
    write(&folder.join(LIST), list)?;
    println!("   {}: {} files", folder.join(LIST).display(), names.len());
    let Some(key) = key else {
        println!("   not signed: --key FILE takes a secret key of minisign");
        return Ok(());
    };
    sign(folder, key)
}

/// Signs the list; minisign asks for the password of the key, if it has one.
fn sign(folder: &Path, key: &Path) -> StepResult {
    let mut minisign = tools::command("minisign", "minisign")?;
    minisign.args(["-S", "-s"]).arg(key).arg("-m").arg(folder.join(LIST));
    show(&mut minisign)
}

/// The digest of a file.
pub fn of(path: &Path) -> Result<String, String> {
    let line = output(Command::new("sha256sum").arg(path))?;
    Ok(line.split_whitespace().next().unwrap_or_default().to_owned())
}

fn names(folder: &Path) -> Result<Vec<String>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let files = entries.flatten().filter(|it| it.path().is_file());
    let names = files.map(|it| it.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|it| !it.starts_with(LIST)).collect();
    names.sort();
    if names.is_empty() { Err(format!("{} is empty", folder.display())) } else { Ok(names) }
}

/// Signs with a key made for it, and lets Debian's minisign check: as users do, and with what was changed.
pub fn trial() -> StepResult {
    let folder = work("signed")?;
    let (secret, public) = (folder.join("key"), folder.join("key.pub"));
    let mut make = tools::command("minisign", "minisign")?;
    make.args(["-G", "-W", "-f", "-s"]).arg(&secret).arg("-p").arg(&public);
    output(&mut make)?;
    let files = folder.join("files");
    write(&files.join("lafet"), "a program")?;
    self::make(&files, Some(&secret))?;
    let verify = |list: PathBuf| {
        output(Command::new("minisign").args(["-V", "-p"]).arg(&public).arg("-m").arg(list))
    };
    verify(files.join(LIST))?;
    output(Command::new("sha256sum").args(["--check", "--strict", LIST]).current_dir(&files))?;
    write(&files.join("lafet"), "another one")?;
    let check = ["--check", "--strict", LIST];
    if output(Command::new("sha256sum").args(check).current_dir(&files)).is_ok() {
        return Err("a changed file was not noticed".into());
    }
    write(&files.join(LIST), "0000  lafet\n")?;
    if verify(files.join(LIST)).is_ok() {
        return Err("minisign accepts a changed list".into());
    }
    Ok(())
}
