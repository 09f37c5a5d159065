//! The files of an installation, each with its place, for the package and the archive.

use std::path::Path;

use super::{Built, binary, copyright, read, tools, work, write};
use crate::run::{self, output};

/// The configuration that is installed: safe, and good for a look at a simulated monitor.
pub const CONFIG: &str = include_str!("debian/hub.toml");
const RULES: &str = include_str!("debian/61-lafet.rules");
const UNIT: &str = "crates/hub/lafet-hub.service";
/// Shells, and where each looks for what it completes.
const SHELLS: [(&str, &str); 3] = [
    ("bash", "usr/share/bash-completion/completions/lafet"),
    ("zsh", "usr/share/zsh/vendor-completions/_lafet"),
    ("fish", "usr/share/fish/vendor_completions.d/lafet.fish"),
];

/// A file that is installed.
pub struct File {
    /// Its path, without the slash at the start.
    pub path: String,
    pub bytes: Vec<u8>,
    pub mode: u32,
}

impl File {
    fn new(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { path: path.into(), bytes: bytes.into(), mode: 0o644 }
    }
}

/// All of them but the configuration, ordered by path.
pub fn all(built: &Built) -> Result<Vec<File>, String> {
    let mut files = vec![
        File { mode: 0o755, ..File::new("usr/bin/lafet", read(&built.program)?) },
        File::new("usr/lib/systemd/system/lafet-hub.service", run::read(UNIT)?),
        File::new("usr/lib/udev/rules.d/61-lafet.rules", RULES),
    ];
    for (shell, path) in SHELLS {
        let script = output(binary::command(built)?.args(["completions", shell]))?;
        files.push(File::new(path, script));
    }
    for name in ["hub.example.toml", "hub.example.ru.toml"] {
        let text = run::read(&format!("crates/hub/{name}"))?;
        files.push(File::new(format!("usr/share/doc/lafet/examples/{name}"), text));
    }
    files.extend(pages(built)?);
    let shipped = copyright::shipped()?;
    files.push(File::new("usr/share/doc/lafet/copyright", copyright::debian(&shipped)));
    let texts = packed(copyright::texts(&shipped)?.as_bytes(), "texts")?;
    files.push(File::new("usr/share/doc/lafet/licences.txt.gz", texts));
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

/// The manual pages, in both languages.
fn pages(built: &Built) -> Result<Vec<File>, String> {
    let mut files = Vec::new();
    for (lang, folder) in [("en", "usr/share/man/man1"), ("ru", "usr/share/man/ru/man1")] {
        let at = work(&format!("man-{}-{lang}", built.arch.name))?;
        output(binary::command(built)?.args(["--lang", lang, "man", "--out"]).arg(&at))?;
        let entries = std::fs::read_dir(&at).map_err(|e| format!("{}: {e}", at.display()))?;
        for path in entries.flatten().map(|it| it.path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let bytes = packed(&read(&path)?, "page")?;
            files.push(File::new(format!("{folder}/{name}.gz"), bytes));
        }
    }
    Ok(files)
}

/// Packed by gzip, without name and time.
pub fn packed(bytes: &[u8], name: &str) -> Result<Vec<u8>, String> {
    let file = work("gzip")?.join(name.replace('.', "-"));
    write(&file, bytes)?;
    output(tools::command("gzip", "gzip")?.args(["-9n"]).arg(&file))?;
    read(&file.with_extension("gz"))
}

/// Writes files below a folder.
pub fn lay(files: &[File], root: &Path) -> run::StepResult {
    for file in files {
        let path = root.join(&file.path);
        write(&path, &file.bytes)?;
        mode(&path, file.mode)?;
    }
    Ok(())
}

/// Sets the mode of a file or folder.
pub fn mode(path: &Path, mode: u32) -> run::StepResult {
    let mode = std::os::unix::fs::PermissionsExt::from_mode(mode);
    std::fs::set_permissions(path, mode).map_err(|e| format!("{}: {e}", path.display()))
}
