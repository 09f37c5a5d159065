//! Compiles the catalogues, a folder a language, into Rust.

mod catalogue;
mod rust;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs};

use catalogue::{Catalogue, Source};

fn main() -> ExitCode {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let root = root.join("catalogues");
    let into = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("texts.rs");
    println!("cargo::rerun-if-changed={}", root.display());
    match compile(&root, &into) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problems) => {
            for problem in problems {
                println!("cargo::error={problem}");
            }
            ExitCode::FAILURE
        }
    }
}

fn compile(root: &Path, into: &Path) -> Result<(), Vec<String>> {
    let sources = sources(root).map_err(|problem| vec![problem])?;
    let catalogue = Catalogue::read(&sources)?;
    fs::write(into, rust::module(&catalogue)).map_err(|e| vec![format!("{}: {e}", into.display())])
}

/// Every file of every folder.
fn sources(root: &Path) -> Result<Vec<Source>, String> {
    let mut sources = Vec::new();
    for folder in paths(root)?.into_iter().filter(|path| path.is_dir()) {
        for path in paths(&folder)? {
            if path.extension().is_some_and(|it| it == "ftl") {
                let text = fs::read_to_string(&path);
                sources.push(Source {
                    language: name(&folder),
                    area: name(&path),
                    text: text.map_err(|e| format!("{}: {e}", path.display()))?,
                });
            }
        }
    }
    Ok(sources)
}

fn paths(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}

/// Without the extension.
fn name(path: &Path) -> String {
    path.file_stem().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default()
}
