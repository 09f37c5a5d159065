//! What `lafet --version` says of the build: commit, target, profile. The same for the same commit and
//! options, whenever and wherever it is built.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=LAFET_COMMIT");
    let given = env::var("LAFET_COMMIT").ok().filter(|it| is_commit(it));
    let commit = given.or_else(last_commit).unwrap_or_default();
    println!("cargo:rustc-env=LAFET_COMMIT={commit}");
    println!("cargo:rustc-env=LAFET_TARGET={}", env::var("TARGET").unwrap_or_default());
    println!("cargo:rustc-env=LAFET_PROFILE={}", profile().unwrap_or_default());
}

/// The last commit of the folder that this is built in, if git knows it.
fn last_commit() -> Option<String> {
    // It changes with every commit; where it is missing, cargo would build again each time.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).is_file() {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["rev-parse", "HEAD"]).filter(|it| is_commit(it))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn is_commit(text: &str) -> bool {
    (7..=64).contains(&text.len()) && text.bytes().all(|it| it.is_ascii_hexdigit())
}

/// The name of the profile: `PROFILE` only says whether it is like release.
fn profile() -> Option<String> {
    // target/[TARGET/]PROFILE/build/lafet-HASH/out
    let out = PathBuf::from(env::var_os("OUT_DIR")?);
    Some(out.ancestors().nth(3)?.file_name()?.to_str()?.to_owned())
}
