//! `lafet`: control, simulate and inspect robotic fire monitors from the terminal.
//!
//! ```text
//! main ─▶ cli (clap) ─▶ cmd::* ─▶ connect ─▶ lafet-client ─▶ the wire
//!                          └────▶ serve ──▶ lafet-sim (the real lafet-device inside)
//! ```
//!
//! The language is chosen first ([`lang`]), because help and errors need it; every command then
//! returns an [`failure::Outcome`], from which `main` derives the exit code.
// `println!` and `eprintln!` panic where the reader is gone, in the middle of a motion.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod angle;
mod aside;
mod cli;
mod cmd;
mod connect;
mod coverage;
mod decode;
mod demo;
mod describe;
mod exchange;
mod failure;
mod follow;
mod help;
mod hub;
mod input;
mod insist;
mod installed;
mod interrupt;
mod keyboard;
mod lang;
mod out;
mod quiet;
mod serve;
mod shell;
mod simulator;
mod site;
mod state;
mod surroundings;
mod texts;
mod top;
mod undo;
mod version;
mod whole;
mod word;

use std::process::ExitCode;
use std::time::Duration;

use clap::FromArgMatches;
use cli::{Cli, Command, Global};
use failure::{Failure, Outcome};
use out::{Out, complain};
use tokio::runtime::{Builder, Runtime};

/// How long the end of the program waits for the system, which may look up a name meanwhile.
const LAST: Duration = Duration::from_secs(1);

/// A hub runs for months beside short floods of requests. The allocator of glibc keeps what such a
/// flood has freed in the arenas of its threads; this one gives it back to the system within
/// seconds.
#[cfg(all(
    feature = "jemalloc",
    target_os = "linux",
    any(target_env = "gnu", target_env = "musl"),
    target_arch = "x86_64"
))]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

fn main() -> ExitCode {
    // The hub starts this program so: what a camera sends is parsed before and beside everything else.
    if hub::cameras::is_wanted(std::env::args_os()) {
        return lafet_eyes::run();
    }
    let arguments: Vec<String> =
        std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect();
    lang::choose(&arguments);
    let parsed = help::command().try_get_matches_from(std::env::args_os());
    let cli = match parsed.and_then(|mut matches| Cli::from_arg_matches_mut(&mut matches)) {
        Ok(cli) => cli,
        Err(error) => return help::show(&error),
    };
    let mut out = Out::new(cli.global.json);
    // No command needs more than this thread.
    let runtime = match Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return report(&error.into(), &mut out),
    };
    let code = match runtime.block_on(dispatch(cli.command, &cli.global, &mut out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure, &mut out),
    };
    drop(out);
    end(runtime);
    code
}

/// Ends what is left of a command.
fn end(runtime: Runtime) {
    runtime.shutdown_timeout(LAST);
}

/// Reports a failure: as text on standard error, as JSON on standard output.
fn report(failure: &Failure, out: &mut Out) -> ExitCode {
    let message = failure.message();
    // Ctrl-C ends a command, whether or not what it prints is read.
    if matches!(failure, Failure::Interrupted)
        && let Ok(mut aside) = out.aside()
    {
        if !message.is_empty() {
            aside.warn(&message);
            if aside.json() {
                let _ = aside.value(&failure.json());
            }
        }
        return ExitCode::from(failure.exit_code());
    }
    out.end_progress();
    if !message.is_empty() {
        // If standard error is closed, the exit code still reports the failure.
        complain(&message);
        if out.json() {
            let _ = out.value(&failure.json());
        }
    }
    ExitCode::from(failure.exit_code())
}

async fn dispatch(command: Command, global: &Global, out: &mut Out) -> Outcome {
    match command {
        Command::Decode(args) => cmd::decode::run(&args, out),
        Command::Bus(args) => cmd::bus::run(*args, global, out).await,
        Command::Record(args) => cmd::record::run(args, global, out).await,
        Command::Replay(args) => cmd::replay::run(args, out).await,
        Command::Dissector(args) => cmd::dissector::run(&args, out),
        Command::Completions(args) => cmd::install::run_completions(&args, out),
        Command::Man(args) => cmd::install::run_man(&args, out),
        Command::Schema(args) => cmd::schema::run(&args, out),
        Command::Coverage(args) => cmd::coverage::run(&args, out),
        Command::Throw(args) => cmd::throw::run(&args, out),
        Command::Map(command) => cmd::map::run(&command, out),
        Command::Site(command) => cmd::site::run(command, out).await,
        Command::Plan(command) => cmd::plan::run(&command, out),
        Command::Sim(args) => cmd::sim::run(*args, out).await,
        Command::Serve(args) => cmd::serve::run(args, out).await,
        Command::Demo(args) => cmd::demo::run(args, out).await,
        Command::Ports(args) => cmd::ports::run(&args, out),
        Command::Scan(args) => cmd::scan::run(args, global, out).await,
        Command::Doctor(args) => cmd::doctor::run(args, global, out).await,
        Command::Conform(args) => cmd::conform::run(*args, global, out).await,
        Command::Status(args) => cmd::status::run(args, global, out).await,
        Command::Top(args) => cmd::top::run(args, global, out).await,
        Command::Shell(args) => cmd::shell::run(args, global).await,
        Command::Watch(args) => cmd::watch::run(args, global, out).await,
        Command::Move(args) => cmd::motion::run_move(args, global, out).await,
        Command::Jog(args) => cmd::jog::run(args, global, out).await,
        Command::Stop(args) => cmd::motion::run_stop(args, global, out).await,
        Command::Open(args) => cmd::motion::run_open(args, global, out).await,
        Command::Close(args) => cmd::motion::run_close(args, global, out).await,
        Command::Deploy(args) => cmd::motion::run_deploy(args, global, out).await,
        Command::Wrap(args) => cmd::motion::run_wrap(args, global, out).await,
        Command::Seek(args) => cmd::seek::run_seek(args, global, out).await,
        Command::Hotbeds(_) => cmd::seek::run_hotbeds(global, out).await,
        Command::Justify(args) => cmd::seek::run_justify(args, global, out).await,
        Command::Quench(args) => cmd::quench::run_quench(args, global, out).await,
        Command::Trajectory(args) => cmd::quench::run_trajectory(args, global, out).await,
        Command::Program(command) => cmd::program::run(command, global, out).await,
        Command::Tune(args) => cmd::tune::run(args, global, out).await,
        Command::Calibrate(args) => cmd::calibrate::run(args, global, out).await,
        Command::Limits(args) => cmd::limits::run(args, global, out).await,
        Command::Param(command) => cmd::param::run(command, global, out).await,
        Command::Lockout(args) => cmd::service::run_lockout(args, global, out).await,
        Command::Restart(_) => cmd::service::run_restart(global, out).await,
        Command::Crash(_) => cmd::service::run_crash(global, out).await,
        Command::Update(args) => cmd::update::run(args, global, out).await,
        Command::Image(command) => cmd::image::run(&command, out),
        Command::Send(args) => cmd::send::run(args, global, out).await,
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    /// A lookup of a name goes on for half a minute where no server of names answers.
    #[test]
    fn a_call_of_the_system_that_hangs_does_not_hold_up_the_end() {
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        let began = Instant::now();
        runtime.block_on(async {
            tokio::task::spawn_blocking(|| std::thread::park_timeout(Duration::from_secs(600)));
        });
        end(runtime);
        assert!(began.elapsed() < Duration::from_secs(300), "{:?}", began.elapsed());
    }
}
