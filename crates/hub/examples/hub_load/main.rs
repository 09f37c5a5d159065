//! The hub under load, as a process of its own with simulated monitors: `cargo xtask hub-load` and
//! `cargo xtask bench --only hub`.

#![allow(missing_docs, reason = "a program")]

mod answers;
mod bench;
mod bodies;
mod client;
mod figures;
mod flood;
mod floods;
mod hub;
mod kills;
mod kinds;
mod link;
mod others;
mod prepare;
mod robust;
mod site;
mod tally;
mod trouble;
mod watch;

use std::path::PathBuf;
use std::process::ExitCode;

/// What goes wrong is reported, and ends the program.
pub type Fallible<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

const USAGE: &str = "hub_load robust PROGRAM FOLDER [--quick], hub_load floods PROGRAM FOLDER [--quick|--whole|--long|--large|--apart] [KIND], hub_load bench PROGRAM FOLDER";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let runtime = runtime.expect("a runtime");
    let done = match words[..] {
        ["robust", lafet, folder] => {
            runtime.block_on(robust::run(PathBuf::from(lafet), folder.into(), &robust::WHOLE))
        }
        ["robust", lafet, folder, "--quick"] => {
            runtime.block_on(robust::run(PathBuf::from(lafet), folder.into(), &robust::QUICK))
        }
        ["floods", lafet, folder, ref what @ ..] => match floods::Size::named(what) {
            Some((size, only)) => {
                runtime.block_on(floods::run(lafet.as_ref(), folder.as_ref(), size, only))
            }
            None => Err(USAGE.into()),
        },
        ["others", place, token] => runtime.block_on(others::run(place, token, None)),
        ["others", place, token, certificate] => {
            runtime.block_on(others::run(place, token, Some(certificate.as_ref())))
        }
        ["bench", lafet, folder] => runtime.block_on(bench::run(lafet.into(), folder.into())),
        _ => Err(USAGE.into()),
    };
    // Connections that are left are of no use.
    runtime.shutdown_background();
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
