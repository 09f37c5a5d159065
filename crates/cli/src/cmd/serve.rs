//! `lafet serve`: the hub, which owns the links to the monitors of a site.

use std::io::{self, BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use lafet_hub::store::{StateFile, newer};
use lafet_hub::{Config, EXAMPLES, Overrides, UNIT};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::hub::{Running, browse, log};
use crate::interrupt::{Caught, Interrupt};
use crate::lang::{Lang, current};
use crate::out::Out;

/// Where the configuration is looked for, in this order.
pub const FILES: [&str; 2] = ["hub.toml", "/etc/lafet/hub.toml"];

/// How often the hub is asked whether there is water or a fire.
const LOOK_EACH: Duration = Duration::from_secs(1);

/// Arguments of `lafet serve`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet serve --example > hub.toml\n  \
                        lafet serve --config hub.toml --check\n  \
                        lafet serve --config hub.toml\n  \
                        lafet serve --unit > /etc/systemd/system/lafet-hub.service")]
pub struct ServeArgs {
    #[arg(long, value_name = "FILE", env = "LAFET_HUB_CONFIG")]
    config: Option<PathBuf>,
    #[arg(long)]
    example: bool,
    #[arg(long)]
    check: bool,
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    #[arg(long)]
    no_browser: bool,
    #[arg(long, value_name = "FILE")]
    verify_audit: Option<PathBuf>,
    #[arg(long, value_name = "FILES", value_delimiter = ',', value_parser = state_file)]
    accept_lost: Vec<StateFile>,
    #[arg(long)]
    unit: bool,
}

/// Parses the name of a state file: `hub`, `audit`.
fn state_file(word: &str) -> Result<StateFile, String> {
    let known = StateFile::ALL.into_iter().find(|it| it.word() == word);
    let words = StateFile::ALL.map(StateFile::word).join(", ");
    known.ok_or_else(|| text::OneOfWords { words }.of(current()))
}

/// Runs the hub until SIGINT or SIGTERM.
pub async fn run(args: ServeArgs, out: &mut Out) -> Outcome {
    if args.example {
        let example = match current() {
            Lang::En => EXAMPLES[0],
            Lang::Ru => EXAMPLES[1],
        };
        return out.show(example.trim_end(), || json!({ "example": example }));
    }
    if args.unit {
        return out.show(UNIT.trim_end(), || json!({ "unit": UNIT }));
    }
    if let Some(file) = &args.verify_audit {
        return verify(file, out);
    }
    let mut interrupt = Interrupt::catch()?;
    let (file, mut config) = read(&args)?;
    config.accept_lost.clone_from(&args.accept_lost);
    if args.check {
        refuse_newer(&config)?;
        let count = config.monitors.len();
        let text =
            text::ConfigGood { file: &file, count, listen: Shown(config.listen) }.of(current());
        let warnings: Vec<String> =
            config.warnings.iter().map(|it| it.localized(current())).collect();
        let text =
            [text].into_iter().chain(warnings.iter().cloned()).collect::<Vec<_>>().join("\n");
        return out.show(
            text,
            || json!({ "file": file, "warnings": warnings, "monitors": count, "listen": config.listen.to_string() }),
        );
    }
    let _log = log(out.json(), "info")?;
    let login = config.login;
    let mut running = Running::start(config).await?;
    // A full disk or a closed pipe must not keep the hub from its work.
    running.announce(&mut out.aside()?, login)?;
    if !args.no_browser {
        browse(running.url());
    }
    let mut busy = Busy::of_environment();
    let mut looks = tokio::time::interval(LOOK_EACH);
    loop {
        let caught = tokio::select! {
            caught = interrupt.next() => caught,
            failure = running.failed() => return Err(failure),
            _ = looks.tick() => {
                busy.says(running.hub().is_busy());
                continue;
            }
        };
        // A service has no terminal that could be gone.
        if caught != Caught::Hangup || has_terminal() {
            break;
        }
        tracing::info!("SIGHUP: the hub goes on as it is; restart it to read its configuration");
    }
    running.end().await;
    Ok(())
}

/// The file that is there while the hub had better not be restarted: an upgrade looks for it.
struct Busy {
    file: Option<PathBuf>,
    said: Option<bool>,
}

impl Busy {
    /// In the folder that systemd has made for that.
    fn of_environment() -> Self {
        let folder = std::env::var_os("RUNTIME_DIRECTORY").filter(|it| !it.is_empty());
        Self { file: folder.map(|folder| Path::new(&folder).join("busy")), said: None }
    }

    fn says(&mut self, busy: bool) {
        let Some(file) = self.file.as_ref().filter(|_| self.said != Some(busy)) else { return };
        self.said = Some(busy);
        let said = if busy { std::fs::write(file, "") } else { std::fs::remove_file(file) };
        if let Err(error) = said
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(%error, file = %file.display(), "it is not said whether there is water");
        }
    }
}

fn has_terminal() -> bool {
    io::stdin().is_terminal() || io::stdout().is_terminal() || io::stderr().is_terminal()
}

fn read(args: &ServeArgs) -> Result<(String, Config), Failure> {
    let usual = || FILES.iter().map(PathBuf::from).find(|path| path.is_file());
    let Some(path) = args.config.clone().or_else(usual) else {
        return Err(Failure::Usage(
            text::NoConfig { first: FILES[0], second: FILES[1] }.of(current()),
        ));
    };
    let environment = Overrides::of_environment(|name| std::env::var(name).ok());
    let overrides = Overrides { port: args.port, ..environment };
    Ok((path.display().to_string(), config(&path, &overrides)?))
}

/// A state that a later program wrote is refused by the check as well: an upgrade asks it before it restarts a hub.
fn refuse_newer(config: &Config) -> Outcome {
    // What this user may not look into is seen at the start.
    let newer = config.data.as_deref().and_then(|folder| newer(folder).ok().flatten());
    newer.map_or(Ok(()), |newer| Err(Failure::Usage(newer.words().of(current()).to_owned())))
}

/// Reads the file of a hub.
pub fn config(path: &Path, overrides: &Overrides) -> Result<Config, Failure> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::io(text::CannotReadConfig { file: &file }.of(current()), error)
    })?;
    let folder = path.parent().unwrap_or(Path::new("."));
    Config::parse(&file, &text, folder, overrides).map_err(|problems| {
        let lines: Vec<String> = problems.iter().map(|it| it.localized(current())).collect();
        Failure::Usage(lines.join("\n"))
    })
}

fn verify(file: &Path, out: &mut Out) -> Outcome {
    let shown = file.display();
    let open = std::fs::File::open(file).map_err(|error| {
        Failure::io(text::CannotReadSite { shown: Shown(shown) }.of(current()), error)
    })?;
    let verified = lafet_hub::store::verify_lines(io::BufReader::new(open).lines());
    let value = || json!(verified);
    match verified.bad {
        None => out.show(
            text::AuditGood { entries: verified.entries, head: &verified.head }.of(current()),
            value,
        ),
        Some(bad) => {
            if out.json() {
                out.value(&value())?;
            }
            Err(Failure::Ended(text::AuditChanged { bad }.of(current())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upgrade_sees_whether_there_is_water() {
        let folder = std::env::temp_dir().join(format!("lafet-busy-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("busy");
        let mut busy = Busy { file: Some(file.clone()), said: None };
        for (water, there) in [(false, false), (true, true), (true, true), (false, false)] {
            busy.says(water);
            assert_eq!(file.exists(), there);
        }
        std::fs::remove_dir_all(&folder).unwrap();
        Busy { file: None, said: None }.says(true);
    }
}
