//! `lafet site`: an installation as a whole, behind its hub.

use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use lafet_acceptance::html::html;
use lafet_acceptance::record::{Occasion, Record};
use lafet_acceptance::{Plan, Run, Stage};
use lafet_texts::{Shown, Text as _, cli as text};
use serde::de::DeserializeOwned;

use super::exercise::write;
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;
use crate::site::{Access, Answers, AtTerminal, Console, Hub, short, told};

/// Longest file that is read, bytes.
const FILE_MAX: u64 = 1 << 20;

/// Subcommands of `lafet site`.
#[derive(Debug, Subcommand)]
pub enum SiteCommand {
    /// Tests it.
    #[command(
        after_help = "Examples:\n  lafet site test plan.toml --hub http://127.0.0.1:8480 --only read\n  \
                      lafet site test plan.toml --hub https://hub.site:8480 --token-file token\n  \
                      lafet --json site test plan.toml --only read,dry --answers answers.toml\n  \
                      lafet site test plan.toml --only water --water --record water.json"
    )]
    Test(Box<TestArgs>),
}

/// Arguments of `lafet site test`.
#[derive(Debug, Args)]
pub struct TestArgs {
    #[arg(value_name = "FILE")]
    plan: PathBuf,
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8480")]
    hub: String,
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    ca: Option<PathBuf>,
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    only: Vec<Step>,
    #[arg(long)]
    water: bool,
    #[arg(long, value_name = "FILE")]
    answers: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    #[arg(long, value_name = "NAME", default_value = "")]
    by: String,
}

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Step {
    Read,
    Dry,
    Outlet,
    Water,
}

impl From<Step> for Stage {
    fn from(step: Step) -> Self {
        match step {
            Step::Read => Self::Read,
            Step::Dry => Self::Dry,
            Step::Outlet => Self::Outlet,
            Step::Water => Self::Water,
        }
    }
}

/// Runs `lafet site`.
pub async fn run(command: SiteCommand, out: &mut Out) -> Outcome {
    let SiteCommand::Test(args) = command;
    test(&args, out).await
}

async fn test(args: &TestArgs, out: &mut Out) -> Outcome {
    let stages = stages(args)?;
    let bytes = read(&args.plan)?;
    let plan: Plan = parse(&args.plan, &bytes)?;
    let wrong = plan.check();
    if !wrong.is_empty() {
        let lines: Vec<&str> = wrong.iter().map(|it| it.of(current())).collect();
        return Err(Failure::Usage(lines.join("\n")));
    }
    let answers: Answers = match &args.answers {
        Some(path) => parse(path, &read(path)?)?,
        None => Answers::default(),
    };
    let token = match &args.token_file {
        Some(path) => Some(String::from_utf8_lossy(&read(path)?).trim().to_owned()),
        None => None,
    };
    let access = Access { url: args.hub.clone(), token, ca: args.ca.clone() };
    let console = Console::listen()?;
    let usage = |words: lafet_texts::Words| Failure::Usage(words.of(current()).to_owned());
    let mut hub = Hub::new(&access, console.clone()).map_err(usage)?;
    let mut person = AtTerminal { console, answers, silent: out.json() };
    let began_ms = lafet_hub::Clock::System.now_ms();
    let outcome = Run::all(&mut hub, &mut person, &plan, &stages).await;
    let code = short(&outcome);
    let occasion = Occasion {
        hub: args.hub.clone(),
        began_ms,
        by: args.by.clone(),
        plan: bytes,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let stages: Vec<Stage> = stages.into_iter().collect();
    let record = Record::new(&plan.name, &occasion, &stages, outcome);
    if let Some(path) = &args.record {
        write(path, &String::from_utf8_lossy(&record.json()))?;
    }
    if let Some(path) = &args.page {
        write(path, &html(&record, current()))?;
    }
    out.show(told(&record), || serde_json::to_value(&record).unwrap_or_default())?;
    if code == 0 { Ok(()) } else { Err(Failure::Told(code)) }
}

/// The steps that are asked for: without any, those in which nothing gets wet.
fn stages(args: &TestArgs) -> Result<BTreeSet<Stage>, Failure> {
    let mut stages: BTreeSet<Stage> = args.only.iter().map(|it| (*it).into()).collect();
    if stages.is_empty() {
        stages.extend([Stage::Read, Stage::Dry]);
    }
    if stages.contains(&Stage::Water) != args.water {
        return Err(Failure::Usage(text::SiteWaterTwice.str(current()).into()));
    }
    Ok(stages)
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    let failed = |error| {
        let what = text::CannotReadSite { shown: Shown(&shown) }.of(current());
        Failure::io(what, error)
    };
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(FILE_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 <= FILE_MAX {
        return Ok(bytes);
    }
    Err(Failure::Usage(text::SiteTooLong { shown: Shown(shown) }.of(current())))
}

fn parse<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, Failure> {
    let text = String::from_utf8_lossy(bytes);
    toml::from_str(&text).map_err(|error: toml::de::Error| {
        let at = error.span().map_or(0, |span| span.start);
        let line = text.get(..at).map_or(1, |before| before.lines().count().max(1));
        let words = lafet_hub::config::said(error.message().trim_end());
        Failure::Usage(format!("{}:{line}: {}", path.display(), words.of(current())))
    })
}
