//! The command line as clap parses it. Help is English here, Russian in `help/ru.rs`.

use clap::{Args, Parser, Subcommand};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::SUBSYSTEMS;

use crate::cmd;
use crate::connect::Connection;
use crate::lang::pick;

/// Control, simulate and inspect robotic fire monitors.
///
/// Exit codes: 0 done; 1 refused by the monitor, or not completed; 2 wrong usage; 3 no answer;
/// 4 what was started may still move or flow; 130 interrupted, and at rest.
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

/// Options of every command.
#[derive(Clone, Debug, Args)]
pub struct Global {
    /// The monitor: tcp://HOST:PORT?addr=1, udp://…, serial:///dev/ttyUSB0?baud=19200, or sim: for a
    /// simulated one (sim:?profile=full&seed=7&fire=az=30,range=25). Also in LAFET_CONNECT
    #[arg(short, long, global = true, help_heading = GENERAL, value_name = "URL", env = "LAFET_CONNECT")]
    pub connect: Option<String>,
    /// Print JSON, one object per line
    #[arg(long, global = true, help_heading = GENERAL)]
    pub json: bool,
    /// Language: en or ru; otherwise LC_ALL, LC_MESSAGES or LANG decides
    #[arg(long, global = true, help_heading = GENERAL, value_name = "LANG", value_parser = ["en", "ru"])]
    pub lang: Option<String>,
    /// How long to wait for each answer, seconds (default 1); reads are tried three times
    #[arg(
        long,
        global = true, help_heading = GENERAL,
        value_name = "SECONDS",
        default_value_t = 1.0,
        value_parser = timeout
    )]
    pub timeout: f64,
    /// The connection that `lafet shell` shares between its commands, and its URL.
    #[arg(skip)]
    pub open: Option<(String, Connection)>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a monitor that others can connect to
    Sim(Box<cmd::sim::SimArgs>),
    /// Run the hub: monitors of a site in the browser and over an API
    Serve(cmd::serve::ServeArgs),
    /// Try everything in the browser on a simulated site, or watch a monitor in the terminal
    Demo(cmd::demo::DemoArgs),
    /// List the serial ports of this computer
    Ports(cmd::ports::PortsArgs),
    /// Find the devices on a bus or a network
    Scan(cmd::scan::ScanArgs),
    /// Find out what is wrong with a link and what to do about it
    Doctor(cmd::doctor::DoctorArgs),
    /// Test whether a monitor does what the protocol says
    Conform(Box<cmd::conform::ConformArgs>),
    /// Compute how many jets reach each square metre of a site
    Coverage(cmd::coverage::CoverageArgs),
    /// Compute how far a jet throws, with its band of uncertainty
    Throw(cmd::throw::ThrowArgs),
    /// Show the state of the monitor and what its flags mean
    Status(cmd::status::StatusArgs),
    /// Show the state repeatedly
    Watch(cmd::watch::WatchArgs),
    /// Show several monitors on one screen, live
    Top(cmd::top::TopArgs),
    /// Run commands on one connection, typed or from a script
    Shell(cmd::shell::ShellArgs),
    /// Move a drive, and follow it until it is at rest
    Move(cmd::motion::MoveArgs),
    /// Move drives with the arrow keys while a key is held
    Jog(cmd::jog::JogArgs),
    /// Stop everything, or one subsystem
    Stop(cmd::motion::StopArgs),
    /// Open a valve
    Open(cmd::motion::OpenArgs),
    /// Close a valve
    Close(cmd::motion::CloseArgs),
    /// Deploy the barrel into its working position
    Deploy(cmd::motion::DeployArgs),
    /// Stow the barrel in its standby position
    Wrap(cmd::motion::WrapArgs),
    /// Search a sector for fire
    Seek(cmd::seek::SeekArgs),
    /// Show the fire spots that the last search found
    Hotbeds(cmd::seek::HotbedsArgs),
    /// Align the fire detector with the barrel
    Justify(cmd::seek::JustifyArgs),
    /// Extinguish a sector, or run a stored program
    Quench(cmd::quench::QuenchArgs),
    /// Extinguish along a path
    Trajectory(cmd::quench::TrajectoryArgs),
    /// Show, store, clear or run the programs and trajectories stored in the monitor
    #[command(subcommand)]
    Program(cmd::program::ProgramCommand),
    /// Fit the ballistics to the jet and fill the correction table
    Calibrate(cmd::calibrate::CalibrateArgs),
    /// Measure how a drive answers its motor, and set StopLag and MinSpeed
    Tune(cmd::tune::TuneArgs),
    /// Show the limits of motion, switch them, or set them from the barrel's position
    Limits(cmd::limits::LimitsArgs),
    /// Read and set parameters
    #[command(subcommand)]
    Param(cmd::param::ParamCommand),
    /// Lock the monitor out, or release it
    Lockout(cmd::service::LockoutArgs),
    /// Restart the monitor's program
    Restart(cmd::service::RestartArgs),
    /// Show the record of the last hardware fault
    Crash(cmd::service::CrashArgs),
    /// Send any requests, written as text or in hexadecimal
    Send(cmd::send::SendArgs),
    /// Decode captured bytes into text
    Decode(cmd::decode::DecodeArgs),
    /// Act as the controller of a bus with several monitors and consoles, or query one
    Bus(Box<cmd::bus::BusArgs>),
    /// Record the traffic of a line as MCAP or pcapng
    Record(cmd::record::RecordArgs),
    /// Show a recording with its original timing
    Replay(cmd::replay::ReplayArgs),
    /// Print or install the dissector for Wireshark
    Dissector(cmd::dissector::DissectorArgs),
    /// Print the completion script for a shell
    Completions(cmd::install::CompletionsArgs),
    /// Print or write the manual pages
    Man(cmd::install::ManArgs),
    /// Print the dictionary of the protocol, or the API of the hub, as JSON
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
    pick(format!("expected one of {names}"), format!("ожидается одно из: {names}"))
}

fn timeout(text: &str) -> Result<f64, String> {
    seconds(text, 0.001)
}

/// Parses a time in seconds, `least`…3600.
pub fn seconds(text: &str, least: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (least..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(pick(
            format!("expected seconds, {least}…3600"),
            format!("ожидаются секунды, {least}…3600"),
        )),
    }
}
