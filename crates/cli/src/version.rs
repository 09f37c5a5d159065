//! What this program is: version, commit, target, profile and what is built in.

use lafet_hub::store::FORMAT;
use lafet_texts::cli as text;
use serde_json::{Value, json};

use crate::lang::Lang;

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Empty where git was not there.
const COMMIT: &str = env!("LAFET_COMMIT");
const TARGET: &str = env!("LAFET_TARGET");
const PROFILE: &str = env!("LAFET_PROFILE");
/// Optional parts, and whether they are built in.
const FEATURES: [(&str, bool); 2] =
    [("parquet", cfg!(feature = "parquet")), ("postgres", cfg!(feature = "postgres"))];
/// Whether memory is managed by jemalloc; the condition is that of `main.rs`.
const JEMALLOC: bool = cfg!(all(
    feature = "jemalloc",
    target_os = "linux",
    any(target_env = "gnu", target_env = "musl"),
    target_arch = "x86_64"
));

fn features() -> Vec<&'static str> {
    FEATURES.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect()
}

/// The version and what belongs to it, a line each.
pub fn words(lang: Lang) -> String {
    let features = match &features()[..] {
        [] => text::VersionNone.str(lang).to_owned(),
        all => all.join(", "),
    };
    let commit = if COMMIT.is_empty() { text::VersionUnknown.str(lang) } else { COMMIT };
    let memory = if JEMALLOC { "jemalloc" } else { text::VersionSystem.str(lang) };
    let lines = [
        (text::VersionCommit.str(lang), commit),
        (text::VersionTarget.str(lang), TARGET),
        (text::VersionProfile.str(lang), PROFILE),
        (text::VersionFeatures.str(lang), features.as_str()),
        (text::VersionAllocator.str(lang), memory),
    ];
    let lines = lines.map(|(what, value)| format!("  {what}: {value}"));
    format!("{VERSION}\n{}", lines.join("\n"))
}

/// The same for programs.
pub fn json() -> Value {
    json!({
        "version": VERSION,
        "commit": (!COMMIT.is_empty()).then_some(COMMIT),
        "target": TARGET,
        "profile": PROFILE,
        "features": features(),
        "allocator": if JEMALLOC { "jemalloc" } else { "system" },
        "state_format": FORMAT,
    })
}
