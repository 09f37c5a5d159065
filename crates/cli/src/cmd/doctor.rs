//! `lafet doctor`: what is wrong with a link, and what to do about it.

use std::cell::RefCell;
use std::io;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use lafet_client::doctor::{Evidence, Finding, Options, Severity, examine, findings};
use lafet_client::transport::Link;
use lafet_client::{Endpoint, Error, PortError};
use lafet_proto::SubsystemId;
use lafet_proto::flags::Severity as FlagSeverity;
use lafet_texts::{Fixed, cli as text};
use serde_json::{Value, json};

use crate::cli::{Global, seconds};
use crate::connect::{Connection, giving_way, link, url_of};
use crate::describe::flag_lines;
use crate::failure::{Failure, Outcome};
use crate::installed;
use crate::lang::current;
use crate::out::Out;

/// Arguments of `lafet doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet doctor serial:///dev/ttyUSB0?baud=19200\n  \
                        lafet doctor tcp://192.168.1.50:10485?addr=3\n  \
                        lafet -c tcp://127.0.0.1:10485 doctor --listen 10\n  \
                        sudo lafet doctor --install")]
pub struct DoctorArgs {
    #[arg(value_name = "URL")]
    url: Option<String>,
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, value_parser = listen)]
    listen: f64,
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    requests: u32,
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    wait: Option<u64>,
    #[arg(long, conflicts_with_all = ["url", "listen", "requests", "wait"])]
    install: bool,
    #[arg(long, value_name = "FILE", requires = "install")]
    config: Option<PathBuf>,
    #[arg(long, value_name = "USER", requires = "install")]
    user: Option<String>,
}

fn listen(text: &str) -> Result<f64, String> {
    seconds(text, 0.1)
}

/// Runs `lafet doctor`: examines the link and prints the findings.
pub async fn run(args: DoctorArgs, global: &Global, out: &mut Out) -> Outcome {
    if args.install {
        return installed::run(args.config.as_deref(), args.user.as_deref(), out);
    }
    let global = Global { connect: args.url.or_else(|| global.connect.clone()), ..global.clone() };
    let url = url_of(&global)?.to_owned();
    let endpoint = Endpoint::from_str(&url).map_err(Error::from)?;
    let usual = Options::of(&endpoint);
    let wait = args.wait.map_or(usual.wait, Duration::from_millis);
    let options = Options {
        quiet: Duration::from_secs_f64(args.listen),
        wait,
        probe_wait: usual.probe_wait.min(wait),
        requests: args.requests,
        insist: global.insist,
    };
    let dial = async |at: &Endpoint| -> io::Result<Link> {
        link(&at.to_string(), at).await.map_err(|failure| match failure {
            Failure::Client(Error::Link { source, .. }) => again(&source),
            other => io::Error::other(other.message()),
        })
    };
    let shown = RefCell::new(&mut *out);
    let tell = |doing: Fixed| shown.borrow_mut().progress(format!("{}…", doing.str(current())));
    let evidence =
        giving_way(&url, &endpoint, wait, || examine(&endpoint, &options, dial, tell)).await?;
    let findings = findings(&evidence);
    let faults = match evidence.is_answered() && !evidence.crc32c_only {
        true => faults(&global).await,
        false => Vec::new(),
    };
    show(&evidence, &findings, &faults, out)?;
    match findings.iter().map(Finding::severity).max() {
        Some(Severity::Fault) => Err(Failure::Ended(String::new())),
        _ => Ok(()),
    }
}

/// Faults and warnings that the monitor's subsystems report.
async fn faults(global: &Global) -> Vec<(SubsystemId, String)> {
    let Ok(connection) = Connection::open_heard(global).await else { return Vec::new() };
    let Ok(status) = connection.monitor.status_all().await else { return Vec::new() };
    let lines = |who: SubsystemId| {
        let bits = status.flags(who).unwrap_or(0);
        flag_lines(who, bits, FlagSeverity::Warning).into_iter().map(move |line| (who, line))
    };
    status.present().flat_map(lines).collect()
}

fn show(
    evidence: &Evidence,
    findings: &[Finding],
    faults: &[(SubsystemId, String)],
    out: &mut Out,
) -> Outcome {
    let mut lines = vec![evidence.endpoint.to_string()];
    for finding in findings {
        let mark = match finding.severity() {
            Severity::Good => text::SeverityGood.str(current()),
            Severity::Warning => text::SeverityWarning.str(current()),
            Severity::Fault => text::SeverityFault.str(current()),
        };
        let width = text::SeverityWarning.str(current()).chars().count();
        lines.push(format!("{mark:width$}  {}", finding.seen(evidence, current())));
        lines.push(format!("{:9}→ {}", "", finding.remedy(evidence, current())));
    }
    if !faults.is_empty() {
        lines.push(text::MonitorReports.str(current()).into());
        lines.extend(faults.iter().map(|(who, line)| format!("  {who} {line}")));
    }
    let json = || {
        let all: Vec<Value> =
            findings.iter().map(|finding| finding_json(finding, evidence)).collect();
        let faults: Vec<Value> = faults
            .iter()
            .map(|(who, line)| json!({ "subsystem": who.to_string(), "text": line }))
            .collect();
        json!({
            "url": evidence.endpoint.to_string(),
            "answers": evidence.is_answered(),
            "findings": all,
            "monitor": faults,
        })
    };
    out.show(lines.join("\n"), json)
}

/// An error that is shared, as one of its own with the same words.
fn again(error: &io::Error) -> io::Error {
    match (PortError::of(error), error.raw_os_error()) {
        (Some(port), _) => port.clone().into(),
        (None, Some(number)) => io::Error::from_raw_os_error(number),
        (None, None) => io::Error::new(error.kind(), error.to_string()),
    }
}

fn finding_json(finding: &Finding, evidence: &Evidence) -> Value {
    let severity = match finding.severity() {
        Severity::Good => "good",
        Severity::Warning => "warning",
        Severity::Fault => "fault",
    };
    json!({
        "finding": finding.name(),
        "severity": severity,
        "seen": finding.seen(evidence, current()),
        "remedy": finding.remedy(evidence, current()),
    })
}
