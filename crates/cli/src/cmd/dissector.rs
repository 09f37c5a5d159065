//! `lafet dissector`: the protocol for Wireshark and tshark.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use lafet_capture::dissector::lua;
use lafet_texts::{Text as _, cli as text};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// Where Wireshark looks for a user's plugins, under the home directory.
const PLUGINS: &str = ".local/lib/wireshark/plugins";
const NAME: &str = "lafet.lua";

/// Arguments of `lafet dissector`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet dissector --install\n  \
                        lafet dissector > lafet.lua && \
                        tshark -X lua_script:lafet.lua -r recording.pcapng")]
pub struct DissectorArgs {
    #[arg(long)]
    install: bool,
}

/// Prints or installs the dissector.
pub fn run(args: &DissectorArgs, out: &mut Out) -> Outcome {
    let text = lua(current());
    if !args.install {
        return out.show(text.trim_end(), || json!({ "lua": text }));
    }
    let Some(home) = std::env::var_os("HOME") else {
        return Err(Failure::Usage(text::HomeNotSet.str(current()).into()));
    };
    let folder = PathBuf::from(home).join(PLUGINS);
    let path = folder.join(NAME);
    let shown = path.display().to_string();
    fs::create_dir_all(&folder).and_then(|()| fs::write(&path, text)).map_err(|error| {
        Failure::io(text::CannotWriteDissector { shown: &shown }.of(current()), error)
    })?;
    let told = text::DissectorWritten { shown: &shown }.of(current());
    out.show(told, || json!({ "path": shown }))
}
