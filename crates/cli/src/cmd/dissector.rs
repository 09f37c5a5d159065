//! `lafet dissector`: the protocol for Wireshark and tshark.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use lafet_capture::dissector::{Language, lua};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::lang::{Lang, current, pick};
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
    /// Install it where Wireshark looks for your plugins
    #[arg(long)]
    install: bool,
}

/// Prints or installs the dissector.
pub fn run(args: &DissectorArgs, out: &mut Out) -> Outcome {
    let text = lua(match current() {
        Lang::En => Language::En,
        Lang::Ru => Language::Ru,
    });
    if !args.install {
        return out.show(text.trim_end(), || json!({ "lua": text }));
    }
    let Some(home) = std::env::var_os("HOME") else {
        return Err(Failure::Usage(
            pick(
                "HOME is not set: print the dissector into a file of Wireshark's plugin folder",
                "HOME не задан: выведите разборщик в файл папки модулей Wireshark",
            )
            .into(),
        ));
    };
    let folder = PathBuf::from(home).join(PLUGINS);
    let path = folder.join(NAME);
    let shown = path.display().to_string();
    fs::create_dir_all(&folder).and_then(|()| fs::write(&path, text)).map_err(|error| {
        Failure::io(
            pick(format!("cannot write {shown}"), format!("не удаётся записать {shown}")),
            error,
        )
    })?;
    let told = pick(
        format!("{shown}\nWireshark loads it at its next start."),
        format!("{shown}\nWireshark узнает протокол при следующем запуске."),
    );
    out.show(told, || json!({ "path": shown }))
}
