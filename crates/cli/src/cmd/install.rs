//! `lafet completions`, `lafet man`: shell completion and manual pages.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use clap_complete::Shell;
use lafet_texts::{Text as _, cli as text};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::help;
use crate::lang::current;
use crate::out::Out;

/// Arguments of `lafet completions`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
                        lafet completions bash > ~/.local/share/bash-completion/completions/lafet\n  \
                        lafet completions zsh > ~/.zfunc/_lafet")]
pub struct CompletionsArgs {
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Arguments of `lafet man`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet man | man -l -\n  \
                        lafet man --out ~/.local/share/man/man1")]
pub struct ManArgs {
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Prints the completion script for a shell.
pub fn run_completions(args: &CompletionsArgs, out: &mut Out) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut help::completed(), "lafet", &mut script);
    let script = String::from_utf8_lossy(&script);
    out.show(script.trim_end(), || json!({ "shell": args.shell.to_string(), "script": script }))
}

/// Prints the manual page, or writes one page per command.
pub fn run_man(args: &ManArgs, out: &mut Out) -> Outcome {
    let command = help::command();
    let Some(folder) = &args.out else {
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page)?;
        let page = String::from_utf8_lossy(&page);
        return out.show(page.trim_end(), || json!({ "page": page }));
    };
    let shown = folder.display().to_string();
    let count = write_pages(command, folder)
        .map_err(|error| Failure::io(text::CannotWriteTo { shown: &shown }.of(current()), error))?;
    let told = text::PagesWritten { shown: &shown, count }.of(current());
    out.show(told, || json!({ "folder": shown, "pages": count }))
}

/// Writes one page for each command; returns their number.
fn write_pages(command: clap::Command, folder: &Path) -> std::io::Result<usize> {
    fs::create_dir_all(folder)?;
    clap_mangen::generate_to(command, folder)?;
    Ok(fs::read_dir(folder)?.count())
}
