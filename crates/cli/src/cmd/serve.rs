//! `lafet serve`: the hub, which owns the links to the monitors of a site.

use std::io::{self, BufRead};
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_hub::store::StateFile;
use lafet_hub::{Config, EXAMPLES, Overrides, UNIT};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::hub::{Running, browse, log};
use crate::interrupt::Interrupt;
use crate::lang::{current, pick};
use crate::out::Out;

/// Where the configuration is looked for, in this order.
const FILES: [&str; 2] = ["hub.toml", "/etc/lafet/hub.toml"];

/// Arguments of `lafet serve`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet serve --example > hub.toml\n  \
                        lafet serve --config hub.toml --check\n  \
                        lafet serve --config hub.toml\n  \
                        lafet serve --unit > /etc/systemd/system/lafet-hub.service")]
pub struct ServeArgs {
    /// Configuration (default: hub.toml here, then /etc/lafet/hub.toml)
    #[arg(long, value_name = "FILE", env = "LAFET_HUB_CONFIG")]
    config: Option<PathBuf>,
    /// Print an example configuration
    #[arg(long)]
    example: bool,
    /// Only report errors in the configuration
    #[arg(long)]
    check: bool,
    /// Port to listen on, instead of the configured one; 0 takes a free one
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Do not open a browser
    #[arg(long)]
    no_browser: bool,
    /// Check an exported audit log for changed or removed entries
    #[arg(long, value_name = "FILE")]
    verify_audit: Option<PathBuf>,
    /// Continue although state files are lost or changed: hub (users), audit
    #[arg(long, value_name = "FILES", value_delimiter = ',', value_parser = state_file)]
    accept_lost: Vec<StateFile>,
    /// Print the unit file for systemd
    #[arg(long)]
    unit: bool,
}

/// Parses the name of a state file: `hub`, `audit`.
fn state_file(word: &str) -> Result<StateFile, String> {
    let known = StateFile::ALL.into_iter().find(|it| it.word() == word);
    let words = StateFile::ALL.map(StateFile::word).join(", ");
    known.ok_or_else(|| pick(format!("one of {words}"), format!("одно из: {words}")))
}

/// Runs the hub until SIGINT or SIGTERM.
pub async fn run(args: ServeArgs, out: &mut Out) -> Outcome {
    if args.example {
        let example = pick(EXAMPLES[0], EXAMPLES[1]);
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
        let count = config.monitors.len();
        let text = pick(
            format!("{file}: no errors; monitors: {count}; listens on {}", config.listen),
            format!("{file}: ошибок нет; стволов: {count}; адрес {}", config.listen),
        );
        let warnings: Vec<String> =
            config.warnings.iter().map(|it| it.localized(current())).collect();
        let text =
            [text].into_iter().chain(warnings.iter().cloned()).collect::<Vec<_>>().join("\n");
        return out.show(
            text,
            || json!({ "file": file, "warnings": warnings, "monitors": count, "listen": config.listen.to_string() }),
        );
    }
    log(out.json(), "info");
    let login = config.login;
    let running = Running::start(config).await?;
    running.announce(out, login)?;
    if !args.no_browser {
        browse(running.url());
    }
    interrupt.wait().await;
    running.end().await;
    Ok(())
}

fn read(args: &ServeArgs) -> Result<(String, Config), Failure> {
    let usual = || FILES.iter().map(PathBuf::from).find(|path| path.is_file());
    let Some(path) = args.config.clone().or_else(usual) else {
        return Err(Failure::Usage(pick(
            format!(
                "There is no configuration: neither {} nor {} exists. To create one: \
                 lafet serve --example > hub.toml. To try it without monitors: lafet demo.",
                FILES[0], FILES[1]
            ),
            format!(
                "Нет конфигурации: ни {}, ни {} не существует. С чего начать: \
                 lafet serve --example > hub.toml. Посмотреть без стволов: lafet demo.",
                FILES[0], FILES[1]
            ),
        )));
    };
    let file = path.display().to_string();
    let text = std::fs::read_to_string(&path).map_err(|error| {
        Failure::io(pick(format!("cannot read {file}"), format!("не читается {file}")), error)
    })?;
    let environment = Overrides::of_environment(|name| std::env::var(name).ok());
    let overrides = Overrides { port: args.port, ..environment };
    let folder = path.parent().unwrap_or(Path::new("."));
    let config = Config::parse(&file, &text, folder, &overrides).map_err(|problems| {
        let lines: Vec<String> = problems.iter().map(|it| it.localized(current())).collect();
        Failure::Usage(lines.join("\n"))
    })?;
    Ok((file, config))
}

fn verify(file: &Path, out: &mut Out) -> Outcome {
    let shown = file.display();
    let open = std::fs::File::open(file).map_err(|error| {
        Failure::io(pick(format!("cannot read {shown}"), format!("не читается {shown}")), error)
    })?;
    let verified = lafet_hub::store::verify_lines(io::BufReader::new(open).lines());
    let value = || json!(verified);
    match verified.bad {
        None => out.show(
            pick(
                format!(
                    "{} entries, none changed, none missing up to the last one, whose hash is {}",
                    verified.entries, verified.head
                ),
                format!(
                    "записей: {}, до последней ничего не изменено и не удалено; её хэш {}",
                    verified.entries, verified.head
                ),
            ),
            value,
        ),
        Some(bad) => {
            if out.json() {
                out.value(&value())?;
            }
            Err(Failure::Ended(pick(
                format!(
                    "Entry {bad} is not as written: it was changed, or an entry before it was \
                     removed."
                ),
                format!(
                    "Запись {bad} — не та, что была сделана: изменена либо удалена предыдущая."
                ),
            )))
        }
    }
}
