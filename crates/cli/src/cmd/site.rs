//! `lafet site`: an installation as a whole, behind its hub.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use lafet_acceptance::calendar;
use lafet_acceptance::record::{Occasion, Record};
use lafet_acceptance::sign::{Key, Signed};
use lafet_acceptance::{Plan, Run, Stage};
use lafet_texts::{Shown, Text as _, cli as text};
use serde::de::DeserializeOwned;
use tokio::time::Instant;

use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::{Out, complain};
use crate::site::{Access, Answers, AtTerminal, Console, Hub, lines, short};
use crate::site::{Keeping, dates, dates_json, kept, read, signature_of};

/// Subcommands of `lafet site`.
#[derive(Debug, Subcommand)]
pub enum SiteCommand {
    /// Tests it.
    #[command(
        after_help = "Examples:\n  lafet site test plan.toml --hub http://127.0.0.1:8480 --only read\n  \
                      lafet site test plan.toml --hub https://hub.site:8480 --token-file token\n  \
                      lafet --json site test plan.toml --only read,dry --answers answers.toml\n  \
                      lafet site test plan.toml --only outlet --page record.html"
    )]
    Test(Box<TestArgs>),
    /// When each step was last tried, and is due.
    #[command(
        after_help = "Examples:\n  lafet site calendar plan.toml --records /var/lib/lafet/site-tests\n  \
                      lafet --json site calendar plan.toml --records /var/lib/lafet/site-tests"
    )]
    Calendar(CalendarArgs),
    /// Whether a record is as it was signed.
    #[command(after_help = "Examples:\n  lafet site verify record.json\n  \
                      lafet site verify record.json --public 3d4017c3…")]
    Verify(VerifyArgs),
}

/// Arguments of `lafet site calendar`.
#[derive(Debug, Args)]
pub struct CalendarArgs {
    #[arg(value_name = "FILE")]
    plan: PathBuf,
    #[arg(long, value_name = "FOLDER")]
    records: PathBuf,
}

/// Arguments of `lafet site verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[arg(value_name = "FILE")]
    record: PathBuf,
    #[arg(long, value_name = "KEY")]
    public: Option<String>,
}

/// Arguments of `lafet site test`.
#[derive(Debug, Args)]
pub struct TestArgs {
    #[arg(value_name = "FILE")]
    plan: PathBuf,
    #[arg(long, value_name = "ADDRESS", default_value = "http://127.0.0.1:8480")]
    hub: String,
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    ca: Option<PathBuf>,
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    only: Vec<Step>,
    #[arg(long, value_name = "FILE")]
    answers: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    #[arg(long, value_name = "FOLDER")]
    records: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    #[arg(long, value_name = "NAME", default_value = "")]
    by: String,
}

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Step {
    Read,
    Dry,
    Outlet,
}

impl From<Step> for Stage {
    fn from(step: Step) -> Self {
        match step {
            Step::Read => Self::Read,
            Step::Dry => Self::Dry,
            Step::Outlet => Self::Outlet,
        }
    }
}

/// Runs `lafet site`.
pub async fn run(command: SiteCommand, out: &mut Out) -> Outcome {
    match command {
        SiteCommand::Test(args) => test(&args, out).await,
        SiteCommand::Calendar(args) => calendar(&args, out),
        SiteCommand::Verify(args) => verify(&args, out),
    }
}

fn calendar(args: &CalendarArgs, out: &mut Out) -> Outcome {
    let plan = plan_of(&args.plan, &read(&args.plan)?)?;
    let records = kept(&args.records)?;
    let due = calendar::of(&plan, &records, lafet_hub::Clock::System.now_ms());
    if due.is_empty() {
        return Err(Failure::Usage(text::SiteNoCalendar.str(current()).into()));
    }
    out.show(dates(&due, &records), || dates_json(&due, &records))?;
    match due.iter().all(calendar::Due::is_good) {
        true => Ok(()),
        false => Err(Failure::Told(1)),
    }
}

fn verify(args: &VerifyArgs, out: &mut Out) -> Outcome {
    let json = read(&args.record)?;
    let beside = signature_of(&args.record);
    let line = String::from_utf8_lossy(&read(&beside)?).into_owned();
    let Some(signed) = Signed::read(&line) else {
        let shown = beside.display();
        return Err(Failure::Usage(text::SiteNoSignature { shown: Shown(shown) }.of(current())));
    };
    let public = signed.public.as_str();
    let wanted = args.public.as_ref().map(|it| it.trim().to_lowercase());
    let good = signed.is_of(&json) && wanted.is_none_or(|it| it == public);
    let shown = Shown(args.record.display());
    let said = match good {
        true => text::SiteVerified { shown, public }.of(current()),
        false => text::SiteNotVerified { shown, public }.of(current()),
    };
    out.show(said, || serde_json::json!({ "good": good, "public": public }))?;
    if good { Ok(()) } else { Err(Failure::Told(1)) }
}

fn plan_of(path: &Path, bytes: &[u8]) -> Result<Plan, Failure> {
    let plan: Plan = parse(path, bytes)?;
    let wrong = plan.check();
    if wrong.is_empty() {
        return Ok(plan);
    }
    let lines: Vec<&str> = wrong.iter().map(|it| it.of(current())).collect();
    Err(Failure::Usage(lines.join("\n")))
}

/// What is kept, and signed with what.
fn keeping(args: &TestArgs) -> Result<Keeping, Failure> {
    let key = match &args.key {
        None => None,
        Some(_) if args.record.is_none() && args.records.is_none() => {
            return Err(Failure::Usage(text::SiteKeyAlone.str(current()).into()));
        }
        Some(path) => {
            let read = Key::read(&String::from_utf8_lossy(&read(path)?));
            let shown = Shown(path.display());
            let wrong = || Failure::Usage(text::SiteBadKey { shown }.of(current()));
            Some(read.ok_or_else(wrong)?)
        }
    };
    let (record, page) = (args.record.clone(), args.page.clone());
    let keeping = Keeping { record, page, records: args.records.clone(), key };
    keeping.is_possible()?;
    Ok(keeping)
}

async fn test(args: &TestArgs, out: &mut Out) -> Outcome {
    let stages = stages(args);
    let bytes = read(&args.plan)?;
    let plan = plan_of(&args.plan, &bytes)?;
    let keeping = keeping(args)?;
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
    let mut person = AtTerminal { console, answers, screen: out.aside()?, asked: Instant::now() };
    let began_ms = lafet_hub::Clock::System.now_ms();
    let outcome = Run::all(&mut hub, &mut person, &plan, &stages).await;
    let code = short(&outcome, &stages);
    let occasion = Occasion {
        hub: args.hub.clone(),
        began_ms,
        by: args.by.clone(),
        plan: bytes,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let stages: Vec<Stage> = stages.into_iter().collect();
    let record = Record::new(&plan.name, &occasion, &stages, outcome);
    drop(person);
    // What was found is shown even if it cannot be kept.
    let kept = keeping.keep(&record);
    let signed = kept.as_ref().ok().and_then(Option::as_ref);
    out.show(lines(&record, signed), || serde_json::to_value(&record).unwrap_or_default())?;
    match kept {
        Err(failure) if code == 0 => Err(failure),
        Err(failure) => {
            complain(failure.message());
            Err(Failure::Told(code))
        }
        Ok(_) if code == 0 => Ok(()),
        Ok(_) => Err(Failure::Told(code)),
    }
}

/// The steps that are asked for; without any, the usual ones.
fn stages(args: &TestArgs) -> BTreeSet<Stage> {
    match args.only.is_empty() {
        true => Stage::USUAL.into(),
        false => args.only.iter().map(|it| (*it).into()).collect(),
    }
}

fn parse<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, Failure> {
    let text = String::from_utf8_lossy(bytes);
    toml::from_str(&text).map_err(|error: toml::de::Error| {
        let at = error.span().map_or(0, |span| span.start);
        let line = 1 + text.get(..at).map_or(0, |before| before.matches('\n').count());
        let words = lafet_hub::config::said(error.message().trim_end());
        Failure::Usage(format!("{}:{line}: {}", path.display(), words.of(current())))
    })
}
