//! `lafet shell`: commands without the URL, one after another, on one connection.
//!
//! At a terminal it prompts for commands; otherwise standard input is a script. `stop` is always
//! accepted, and Ctrl-C stops whatever moves before it does anything else.

use std::collections::VecDeque;
use std::io::{self, IsTerminal};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use clap::parser::ValueSource;
use clap::{Args, FromArgMatches};
use lafet_client::Endpoint;
use lafet_texts::{Text as _, cli as text};
use tokio::join;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Instant, interval, timeout};

use super::program::ProgramCommand;
use crate::cli::{Cli, Command, Global};
use crate::connect::{Connection, url_of};
use crate::failure::{Failure, Outcome};
use crate::help;
use crate::input;
use crate::interrupt::{Caught, Interrupt};
use crate::lang::current;
use crate::out::{Out, complain};
use crate::shell::ahead::Ahead;
use crate::shell::complete::FIXED;
use crate::shell::editor::{Editor, Input, Notices};
use crate::shell::opening::{Lines, Opening, drop_lines, open, stop_all};
use crate::shell::words::{is_stop, words};
use crate::top::feed::Feed;
use crate::top::scene::Seen;
use crate::top::silence;
use crate::undo::{Because, Undo, is_anything_active};

/// Interval at which the shell polls the state while it waits.
const POLL: Duration = Duration::from_millis(500);
/// A state that is newer than a command by less than this may not yet show what the command
/// started.
const SHOWS_IN: Duration = Duration::from_millis(300);
/// A command interrupted by Ctrl-C has this long to end by itself before it is dropped.
const GRACE: Duration = Duration::from_secs(3);

/// Arguments of `lafet shell`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet shell tcp://127.0.0.1:10485\n  lafet shell sim: < \
                        commands.txt\n  printf 'deploy\\nmove vertical 20deg\\n' | lafet shell \
                        tcp://127.0.0.1:10485")]
pub struct ShellArgs {
    #[arg(value_name = "URL")]
    monitor: Option<String>,
    #[arg(short, long)]
    keep_going: bool,
    #[arg(long)]
    no_history: bool,
}

/// Runs commands until there are no more.
pub async fn run(args: ShellArgs, global: &Global) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    let mut global = global.clone();
    if let Some(url) = args.monitor {
        global.connect = Some(url);
    }
    let talks = io::stdin().is_terminal() && io::stderr().is_terminal();
    let mut lines = match talks {
        true => Lines::Typed(Ahead::listen(true)),
        false => Lines::Script(input::lines(), false),
    };
    let opening = open(&global, &mut interrupt, &mut lines).await?;
    let Opening { connection, ahead, interrupted } = opening;
    let url = url_of(&global)?.to_owned();
    global.open = Some((url, connection.clone()));
    let mut shell =
        Shell { global, connection, interrupt, feed: None, acted: None, ahead, ending: false };
    if interrupted {
        return Err(shell.bring_to_rest().await);
    }
    match lines {
        Lines::Typed(_) => shell.converse(!args.no_history).await,
        Lines::Script(lines, _) => shell.script(lines, args.keep_going).await,
    }
}

struct Shell {
    global: Global,
    connection: Connection,
    interrupt: Interrupt,
    /// State of the monitor, kept up to date at a terminal only.
    feed: Option<Arc<Feed>>,
    /// When the last command ended that may have moved something.
    acted: Option<Instant>,
    /// Lines typed while a command ran.
    ahead: VecDeque<String>,
    /// Set when the shell is to end.
    ending: bool,
}

/// What a line asks the shell to do.
enum Wish {
    Nothing,
    Leave,
    Run(Box<Command>, bool),
    /// Nothing more: an error or an answer was printed. The exit code.
    Told(u8),
}

/// Result of a line.
enum Ended {
    /// The command ended with this exit code.
    Code(u8),
    Leave,
}

impl Shell {
    async fn converse(&mut self, remember: bool) -> Outcome {
        let feed = Arc::new(Feed::over(&self.connection, POLL)?);
        self.feed = Some(feed.clone());
        let mut editor = Editor::start(feed.clone(), remember);
        let changes = tokio::spawn(tell_changes(feed, editor.notices()));
        complain(greeting());
        loop {
            let line = match self.ahead.pop_front() {
                Some(line) => line,
                None => match self.ask(&mut editor).await? {
                    Some(line) => line,
                    None => break,
                },
            };
            if matches!(self.line(&line).await, Ended::Leave) {
                break;
            }
            if self.ending {
                return Err(Failure::Interrupted);
            }
        }
        changes.abort();
        if self.moves() {
            complain(text::MotionContinues.str(current()));
        }
        Ok(())
    }

    /// The next line typed; `None` at the end of input.
    async fn ask(&mut self, editor: &mut Editor) -> Result<Option<String>, Failure> {
        editor.ask();
        loop {
            let input = tokio::select! {
                input = editor.next() => input,
                caught = self.interrupt.next() => {
                    editor.give_up().await;
                    match caught {
                        Caught::CtrlC => Input::CtrlC,
                        Caught::End | Caught::Hangup => return Err(Failure::Interrupted),
                    }
                }
            };
            match input {
                Input::Line(line) => return Ok(Some(line)),
                Input::End => return Ok(None),
                Input::Failed(error) => return Err(error.into()),
                Input::CtrlC => {
                    if self.moves() {
                        self.bring_to_rest().await;
                    }
                    editor.ask();
                }
            }
        }
    }

    /// Runs the lines of standard input.
    async fn script(&mut self, mut lines: UnboundedReceiver<String>, keep_going: bool) -> Outcome {
        let mut number = 0_u64;
        let mut first = 0;
        loop {
            let next = async {
                match self.ahead.pop_front() {
                    Some(line) => Some(line),
                    None => lines.recv().await,
                }
            };
            let line = tokio::select! {
                line = next => line,
                _ = self.interrupt.next() => return Err(self.bring_to_rest().await),
            };
            let Some(line) = line else { break };
            number += 1;
            let code = match self.line(&line).await {
                Ended::Leave => break,
                Ended::Code(code) => code,
            };
            if code == 0 {
                continue;
            }
            complain(text::ScriptLine { number, line }.of(current()));
            first = if first == 0 { code } else { first };
            // An interrupt ends the whole script, even with --keep-going.
            if !keep_going || code == Failure::Interrupted.exit_code() {
                break;
            }
        }
        if first == 0 { Ok(()) } else { Err(Failure::Told(first)) }
    }

    async fn line(&mut self, line: &str) -> Ended {
        match self.wish(line) {
            Wish::Nothing => Ended::Code(0),
            Wish::Leave => Ended::Leave,
            // A stop with wrong arguments stops everything.
            Wish::Told(code) if is_stop(line) && code != 0 => {
                self.stop_all().await;
                Ended::Code(code)
            }
            Wish::Told(code) => Ended::Code(code),
            Wish::Run(command, json) => Ended::Code(self.run(*command, json).await),
        }
    }

    /// Parses a line with the grammar of the command line.
    fn wish(&self, line: &str) -> Wish {
        let mut words = match words(line) {
            Ok(words) => words,
            Err(why) => {
                complain(why);
                return Wish::Told(2);
            }
        };
        let Some(first) = words.first_mut() else { return Wish::Nothing };
        if is_stop(line) {
            *first = "stop".into();
        }
        match first.as_str() {
            "exit" | "quit" | "выход" => return Wish::Leave,
            "help" | "?" => {
                words.remove(0);
                words.push("--help".into());
            }
            _ => {}
        }
        let parsed = help::command().no_binary_name(true).try_get_matches_from(&words);
        let mut matches = match parsed {
            Ok(matches) => matches,
            Err(error) => {
                help::show(&error);
                return Wish::Told(u8::try_from(error.exit_code()).unwrap_or(2));
            }
        };
        let given = |name: &&str| matches.value_source(name) == Some(ValueSource::CommandLine);
        if let Some(name) = FIXED.iter().find(|name| given(name)) {
            complain(fixed(name));
            return Wish::Told(2);
        }
        match Cli::from_arg_matches_mut(&mut matches) {
            Ok(Cli { command: Command::Shell(_), .. }) => {
                complain(text::ShellInShell.str(current()));
                Wish::Told(2)
            }
            Ok(cli) if needs_line(&cli.command) && self.is_alone() => {
                complain(taken());
                Wish::Told(2)
            }
            Ok(cli) => Wish::Run(Box::new(cli.command), cli.global.json),
            Err(error) => {
                help::show(&error);
                Wish::Told(2)
            }
        }
    }

    /// Whether the line accepts a single connection only.
    fn is_alone(&self) -> bool {
        let endpoint = self.global.connect.as_deref().and_then(|url| Endpoint::from_str(url).ok());
        matches!(endpoint, Some(Endpoint::Serial { .. } | Endpoint::Sim { .. }))
    }

    /// Runs a command; returns its exit code.
    async fn run(&mut self, command: Command, json: bool) -> u8 {
        let global = Global { json: json || self.global.json, ..self.global.clone() };
        let mut out = Out::new(global.json);
        let (acts, watches) = (acts(&command), matches!(command, Command::Watch(_)));
        let follows = acts && !matches!(command, Command::Calibrate(_));
        let mut ahead = Ahead::listen(self.feed.is_some() && leaves_keyboard(&command));
        let outcome = {
            let mut work = Box::pin(crate::dispatch(command, &global, &mut out));
            loop {
                tokio::select! {
                    // On an interrupt everything is stopped before the command reacts to it: its Close
                    // comes behind this Stop.
                    biased;
                    caught = self.interrupt.next() => {
                        self.ending = caught != Caught::CtrlC;
                        drop_lines(&mut self.ahead);
                        let stop = async {
                            if acts || self.moves() {
                                self.stop_all().await;
                            }
                        };
                        // A command that follows its motion also stops it and reports how that
                        // ended; its own time limits apply, and another Ctrl-C ends it. It does not
                        // wait for the answer to this Stop, which may never come.
                        if follows && self.interrupt.is_shared() {
                            break join!(biased; stop, &mut work).1;
                        }
                        // One that still prepares its motion must not begin it.
                        if follows {
                            stop.await;
                            break Err(Failure::Interrupted);
                        }
                        let rest = timeout(GRACE, &mut work);
                        break join!(biased; stop, rest).1.unwrap_or(Err(Failure::Interrupted));
                    }
                    line = ahead.next() => {
                        if is_stop(&line) {
                            drop_lines(&mut self.ahead);
                            self.stop_all().await;
                        } else if watches {
                            // A line ends the command, and stops nothing.
                            let only_ends = ["", "q", "й"].contains(&line.as_str());
                            self.ahead.extend((!only_ends).then_some(line));
                            break Ok(());
                        } else {
                            self.ahead.push_back(line);
                        }
                    }
                    outcome = &mut work => break outcome,
                }
            }
        };
        if acts {
            self.acted = Some(Instant::now());
        }
        self.interrupt.forget().await;
        out.end_progress();
        match outcome {
            Ok(()) => 0,
            Err(failure) => {
                crate::report(&failure, &mut out);
                failure.exit_code()
            }
        }
    }

    /// Whether anything moves, as far as is known; an unknown state may be moving.
    fn moves(&self) -> bool {
        let Some(feed) = &self.feed else { return true };
        let seen = feed.seen();
        let known = seen.is_known() && !seen.stale;
        let old = self.acted.is_some_and(|acted| seen.age + SHOWS_IN > acted.elapsed());
        !known || old || is_anything_active(&seen.answers)
    }

    /// Stops everything, retrying for as long as it takes, and returns how that ended.
    async fn bring_to_rest(&mut self) -> Failure {
        let mut out = Out::new(self.global.json);
        let Self { connection, interrupt, .. } = self;
        let stop = Undo::everything();
        let failure = stop.carry_out(connection, &mut out, interrupt, Because::Interrupted).await;
        self.interrupt.forget().await;
        if self.feed.is_some() {
            complain(failure.message());
        }
        failure
    }

    /// Sends Stop All once, and shows the outcome.
    async fn stop_all(&self) {
        stop_all(&self.connection, self.feed.is_some()).await;
    }
}

/// Whether a command may move something, or let water flow.
const fn acts(command: &Command) -> bool {
    matches!(
        command,
        Command::Move(_)
            | Command::Jog(_)
            | Command::Open(_)
            | Command::Close(_)
            | Command::Deploy(_)
            | Command::Wrap(_)
            | Command::Seek(_)
            | Command::Justify(_)
            | Command::Quench(_)
            | Command::Trajectory(_)
            | Command::Calibrate(_)
            | Command::Tune(_)
            | Command::Program(ProgramCommand::Run(_))
            | Command::Limits(_)
            | Command::Send(_)
    )
}

/// Whether a command leaves the keyboard to the shell.
const fn leaves_keyboard(command: &Command) -> bool {
    matches!(
        command,
        Command::Watch(_)
            | Command::Record(_)
            | Command::Move(_)
            | Command::Open(_)
            | Command::Close(_)
            | Command::Deploy(_)
            | Command::Wrap(_)
            | Command::Seek(_)
            | Command::Justify(_)
            | Command::Quench(_)
            | Command::Trajectory(_)
            | Command::Tune(_)
            | Command::Program(_)
            | Command::Update(_)
    )
}

/// Whether a command needs the bare line, with no other connection open.
const fn needs_line(command: &Command) -> bool {
    matches!(command, Command::Record(_) | Command::Scan(_) | Command::Doctor(_))
}

/// Reports when the monitor stops answering and when it answers again.
async fn tell_changes(feed: Arc<Feed>, notices: Notices) {
    let mut looks = interval(POLL / 2);
    let (mut lost, mut shown) = (false, "");
    loop {
        looks.tick().await;
        let seen = feed.seen();
        let silence = silence(&seen);
        if silence.is_some() != lost {
            lost = silence.is_some();
            notices.tell(silence.map_or_else(|| back(&seen), |why| gone(&seen, why)));
        }
        if seen.condition() != shown {
            shown = seen.condition();
            notices.repaint();
        }
    }
}

fn gone(seen: &Seen, why: &str) -> String {
    let name = &seen.name;
    let why = if why.is_empty() { String::new() } else { format!(": {why}") };
    text::MonitorLost { name, why }.of(current())
}

fn back(seen: &Seen) -> String {
    let (name, state) = (&seen.name, seen.condition());
    text::MonitorBack { name, state }.of(current())
}

fn greeting() -> &'static str {
    text::ShellHelp.str(current())
}

fn fixed(name: &str) -> String {
    text::OptionAtStartOnly { name }.of(current())
}

fn taken() -> &'static str {
    text::LineHeldByShell.str(current())
}
