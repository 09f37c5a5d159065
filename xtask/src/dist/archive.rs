//! The archive for systems without dpkg: the program and what belongs to it, in folders as they are installed.

use std::path::{Path, PathBuf};

use super::files::{self, CONFIG, File, lay};
use super::{Built, tools, work, write};
use crate::run::{self, output};

/// Makes it in a folder; returns its path.
pub fn make(built: &Built, folder: &Path) -> Result<PathBuf, String> {
    let name = format!("lafet-{}-linux-{}", built.version, built.arch.name);
    let root = work(&format!("archive-{}", built.arch.name))?;
    let config = File { path: "etc/lafet/hub.toml".into(), bytes: CONFIG.into(), mode: 0o640 };
    let mut files = files::all(built)?;
    files.push(config);
    lay(&files, &root.join(&name))?;
    for file in ["LICENSE-APACHE", "LICENSE-MIT", "docs/install.md", "docs/install.ru.md"] {
        let short = file.rsplit('/').next().unwrap_or(file);
        write(&root.join(&name).join(short), run::read(file)?)?;
    }
    let path = folder.join(format!("{name}.tar.gz"));
    pack(&root, &name, &path, &built.epoch)?;
    println!("   {}", path.display());
    Ok(path)
}

/// Packs a folder or file, the same each time; packed by gzip if the name says so.
pub fn pack(root: &Path, what: &str, to: &Path, epoch: &str) -> run::StepResult {
    let plain = to.with_extension("");
    let gzip = to.extension().is_some_and(|it| it == "gz");
    let tar = if gzip { plain.as_path() } else { to };
    let mut command = tools::command("tar", "tar")?;
    command.args(["--sort=name", "--format=gnu", "--owner=0", "--group=0", "--numeric-owner"]);
    command.arg(format!("--mtime=@{epoch}")).arg("-cf").arg(tar).arg("-C").arg(root).arg(what);
    output(&mut command)?;
    if gzip {
        output(tools::command("gzip", "gzip")?.args(["-9nf"]).arg(&plain))?;
    }
    Ok(())
}
