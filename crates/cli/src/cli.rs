//! The command line as clap parses it. Its help is in `help.ftl` of `lafet-texts`, by command and
//! argument.

use clap::{Args, Parser, Subcommand};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::SUBSYSTEMS;
use lafet_texts::{Text as _, cli as text};

use crate::cmd;
use crate::connect::Connection;
use crate::lang::{Lang, current};

/// The command line.
#[derive(Debug, Parser)]
#[command(
    name = "lafet",
    version,
    disable_help_subcommand = true,
    after_help = "Examples:\n  lafet demo\n  lafet sim --fire az=30,range=25\n  \
                  lafet -c tcp://127.0.0.1:10485 status"
)]
pub struct Cli {
    /// Options that every command has.
    #[command(flatten)]
    pub global: Global,
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Heading in the help for [`Global`] options.
pub const GENERAL: &str = "General options";

/// How long an answer may take unless the user says it, seconds.
pub const TIMEOUT_S: f64 = 1.0;

/// Options of every command.
#[derive(Clone, Debug, Args)]
pub struct Global {
    #[arg(short, long, global = true, help_heading = GENERAL, value_name = "URL", env = "LAFET_CONNECT")]
    pub connect: Option<String>,
    #[arg(long, global = true, help_heading = GENERAL)]
    pub json: bool,
    #[arg(long, global = true, help_heading = GENERAL, value_name = "LANG", value_parser = Lang::ALL.map(Lang::code))]
    pub lang: Option<String>,
    #[arg(
        long,
        global = true, help_heading = GENERAL,
        value_name = "SECONDS",
        default_value_t = TIMEOUT_S,
        value_parser = timeout
    )]
    pub timeout: f64,
    #[arg(long, global = true, help_heading = GENERAL)]
    pub insist: bool,
    /// The connection that `lafet shell` shares between its commands, and its URL.
    #[arg(skip)]
    pub open: Option<(String, Connection)>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    Sim(Box<cmd::sim::SimArgs>),
    Serve(cmd::serve::ServeArgs),
    Demo(cmd::demo::DemoArgs),
    Ports(cmd::ports::PortsArgs),
    Scan(cmd::scan::ScanArgs),
    Doctor(cmd::doctor::DoctorArgs),
    Conform(Box<cmd::conform::ConformArgs>),
    Coverage(cmd::coverage::CoverageArgs),
    Throw(cmd::throw::ThrowArgs),
    #[command(
        subcommand,
        after_help = "Examples:\n  lafet map modbus hub.toml > map.csv\n  lafet map modbus hub.toml --form markdown"
    )]
    Map(cmd::map::MapCommand),
    #[command(
        subcommand,
        after_help = "Examples:\n  lafet site test plan.toml --hub http://127.0.0.1:8480 --only read\n  \
                      lafet site test plan.toml --hub http://127.0.0.1:8480 --page record.html"
    )]
    Site(cmd::site::SiteCommand),
    #[command(subcommand)]
    Plan(cmd::plan::PlanCommand),
    Status(cmd::status::StatusArgs),
    Watch(cmd::watch::WatchArgs),
    Top(cmd::top::TopArgs),
    Shell(cmd::shell::ShellArgs),
    Move(cmd::motion::MoveArgs),
    Jog(cmd::jog::JogArgs),
    Stop(cmd::motion::StopArgs),
    Open(cmd::motion::OpenArgs),
    Close(cmd::motion::CloseArgs),
    Deploy(cmd::motion::DeployArgs),
    Wrap(cmd::motion::WrapArgs),
    Seek(cmd::seek::SeekArgs),
    Hotbeds(cmd::seek::HotbedsArgs),
    Justify(cmd::seek::JustifyArgs),
    Quench(cmd::quench::QuenchArgs),
    Trajectory(cmd::quench::TrajectoryArgs),
    #[command(subcommand)]
    Program(cmd::program::ProgramCommand),
    Calibrate(cmd::calibrate::CalibrateArgs),
    Tune(cmd::tune::TuneArgs),
    Limits(cmd::limits::LimitsArgs),
    #[command(subcommand)]
    Param(cmd::param::ParamCommand),
    Lockout(cmd::service::LockoutArgs),
    Restart(cmd::service::RestartArgs),
    Crash(cmd::service::CrashArgs),
    Update(cmd::update::UpdateArgs),
    #[command(subcommand)]
    Image(cmd::image::ImageCommand),
    Send(cmd::send::SendArgs),
    Decode(cmd::decode::DecodeArgs),
    Bus(Box<cmd::bus::BusArgs>),
    Record(cmd::record::RecordArgs),
    Replay(cmd::replay::ReplayArgs),
    Dissector(cmd::dissector::DissectorArgs),
    Completions(cmd::install::CompletionsArgs),
    Man(cmd::install::ManArgs),
    Schema(cmd::schema::SchemaArgs),
}

/// Parses the name of a subsystem, in any case, or its number.
pub fn subsystem(text: &str) -> Result<SubsystemId, String> {
    let named = SUBSYSTEMS.iter().find(|info| info.name.eq_ignore_ascii_case(text));
    let number = || u8::from_str_radix(text.strip_prefix("0x")?, 16).ok().map(SubsystemId);
    named
        .map(|info| info.id)
        .or_else(number)
        .ok_or_else(|| one_of(SUBSYSTEMS.iter().map(|info| info.name)))
}

/// Parses the name of a drive, in any case, or its number.
pub fn drive(text: &str) -> Result<SubsystemId, String> {
    among(text, SubsystemId::is_drive)
}

/// Parses the name of a valve, in any case, or its number.
pub fn valve(text: &str) -> Result<SubsystemId, String> {
    among(text, SubsystemId::is_valve)
}

fn among(text: &str, allowed: impl Fn(SubsystemId) -> bool) -> Result<SubsystemId, String> {
    let all = SUBSYSTEMS.iter().filter(|info| allowed(info.id));
    let found = all.clone().find(|info| info.name.eq_ignore_ascii_case(text));
    found.map(|info| info.id).ok_or_else(|| one_of(all.map(|info| info.name)))
}

fn one_of(names: impl Iterator<Item = &'static str>) -> String {
    let names = names.collect::<Vec<_>>().join(", ");
    text::OneOfNames { names }.of(current())
}

fn timeout(text: &str) -> Result<f64, String> {
    seconds(text, 0.001)
}

/// Parses a time in seconds, `least`…3600.
pub fn seconds(text: &str, least: f64) -> Result<f64, String> {
    // Texts of the other language have a comma.
    match text.replace(',', ".").parse::<f64>() {
        Ok(seconds) if (least..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(text::SecondsFrom { least }.of(current())),
    }
}
