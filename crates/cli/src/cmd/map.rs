//! `lafet map`: the register maps of the hub's servers, for those who program a master.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use lafet_hub::Overrides;
use lafet_hub::modbus_server::{ServerConfig, map, vectors};
use lafet_texts::{Text as _, cli as text};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// The protocols.
#[derive(Debug, Subcommand)]
pub enum MapCommand {
    /// Modbus.
    Modbus(MapArgs),
}

/// Arguments of `lafet map modbus`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  lafet map modbus hub.toml > map.csv\n  lafet map modbus hub.toml --form markdown\n  \
                  lafet --lang ru map modbus hub.toml --form vectors --server plc"
)]
pub struct MapArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long, value_name = "NAME")]
    server: Option<String>,
    #[arg(long, value_name = "FORM", value_enum, default_value_t = Form::Csv)]
    form: Form,
}

/// In which form the map is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    /// A table with both languages, status words bit by bit.
    Csv,
    /// A table for people.
    Markdown,
    /// Frames of a conversation.
    Vectors,
}

/// Prints the map of a server.
pub fn run(command: &MapCommand, out: &mut Out) -> Outcome {
    let MapCommand::Modbus(args) = command;
    let server = server(args)?;
    let lang = current();
    let units = server.units();
    let (unit, monitors) = units.first().copied().unwrap_or((server.unit, &[]));
    let printed = match args.form {
        Form::Csv => map::csv(&server),
        Form::Markdown => map::markdown(&server, lang),
        Form::Vectors => vectors::shown(&vectors::vectors(unit, monitors), lang),
    };
    out.show(printed.trim_end(), || {
        let unit = |(unit, ids): &(u8, &[String])| {
            json!({ "unit": unit, "version": map::version(*unit, ids), "registers": map::rows(*unit, ids) })
        };
        json!({
            "server": server.name,
            "units": units.iter().map(unit).collect::<Vec<_>>(),
            "vectors": vectors::vectors(server.unit, monitors),
        })
    })
}

/// The server of that name; without one, the first.
fn server(args: &MapArgs) -> Result<ServerConfig, Failure> {
    let file = args.file.display().to_string();
    let config = super::serve::config(&args.file, &Overrides::default())?;
    let wanted = |it: &ServerConfig| args.server.as_ref().is_none_or(|name| *name == it.name);
    let found = config.modbus_servers.into_iter().find(wanted);
    found.ok_or_else(|| Failure::Usage(text::MapNoServer { file: &file }.of(current())))
}
