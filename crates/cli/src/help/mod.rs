//! Help and errors of the command line, in English or Russian.
//!
//! clap's texts are English. For Russian, every text of its command tree is replaced from the table
//! in `ru.rs`, and its errors are rewritten; a test finds what the table lacks.

mod errors;
mod ru;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, Str, StyledStr};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, Command, CommandFactory};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::SUBSYSTEMS;
use lafet_proto::param::Param;

use crate::cli::{Cli, GENERAL};
use crate::lang::{Lang, current};

/// The command line in the user's language.
pub fn command() -> Command {
    // Defaults, variables and choices are part of the texts, where they can be translated.
    let plain = |arg: Arg| match arg.get_action().takes_values() {
        // A negative number is a value, possibly out of range, not an option.
        true => arg
            .hide_default_value(true)
            .hide_env(true)
            .hide_possible_values(true)
            .allow_negative_numbers(true),
        false => arg,
    };
    let command = everywhere(Cli::command(), &|command| command.mut_args(plain));
    match current() {
        Lang::En => command,
        Lang::Ru => russian(command),
    }
}

/// The command line for shell completion: with the possible values of arguments.
pub fn completed() -> Command {
    everywhere(command(), &|command| command.mut_args(words_of))
}

/// Adds the possible values to an argument; clap cannot see those of a parser function.
fn words_of(arg: Arg) -> Arg {
    let names = |wanted: fn(SubsystemId) -> bool| {
        let all = SUBSYSTEMS.iter().filter(move |info| wanted(info.id));
        all.map(|info| info.name).collect::<Vec<_>>()
    };
    let shown = arg.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
    let words: Vec<&'static str> = match shown.as_deref() {
        Some("SUBSYSTEM" | "ПОДСИСТЕМА") => names(|_| true),
        Some("DRIVE" | "ПРИВОД") => names(SubsystemId::is_drive),
        Some("VALVE" | "ЗАТВОР") => names(SubsystemId::is_valve),
        Some("DRIVE|off|on|reject" | "ПРИВОД|off|on|reject") => {
            ["off", "on", "reject"].into_iter().chain(names(SubsystemId::is_drive)).collect()
        }
        Some("NAME" | "ИМЯ") if arg.get_id() == "name" => {
            let all: BTreeSet<&str> = Param::ALL.iter().map(|param| param.name()).collect();
            all.into_iter().collect()
        }
        Some("N") if matches!(arg.get_id().as_str(), "number" | "program") => {
            vec!["0", "1", "2", "3", "4", "5", "6", "7"]
        }
        _ => return arg,
    };
    arg.value_parser(PossibleValuesParser::new(words))
}

/// Prints an error in the arguments, or the help that was requested.
pub fn show(error: &clap::Error) -> ExitCode {
    let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    let is_help = asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    // If standard error is closed, the exit code still reports the error.
    let message = match current() {
        Lang::Ru if !is_help => errors::russian(error),
        _ => {
            let _ = error.print();
            error.to_string()
        }
    };
    if current() == Lang::Ru && !is_help {
        let _ = writeln!(io::stderr(), "{message}");
    }
    if asked {
        return ExitCode::SUCCESS;
    }
    if std::env::args_os().any(|argument| argument == "--json") {
        let json = crate::failure::Failure::Usage(message.trim_end().into()).json();
        let _ = writeln!(io::stdout(), "{json}");
    }
    ExitCode::from(2)
}

fn everywhere(command: Command, change: &dyn Fn(Command) -> Command) -> Command {
    let names: Vec<String> =
        command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    let command = change(command);
    names
        .iter()
        .fold(command, |command, name| command.mut_subcommand(name, |sub| everywhere(sub, change)))
}

fn russian(command: Command) -> Command {
    // clap makes usage lines once the tree is built.
    let mut built = command.clone();
    built.build();
    translate(command, "", &mut built).disable_version_flag(true).arg(flag(
        "version",
        'V',
        ArgAction::Version,
        "Показать версию",
    ))
}

fn translate(command: Command, path: &str, built: &mut Command) -> Command {
    let names: Vec<String> =
        command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    let usage = built.render_usage();
    let mut positionals = 0;
    let mut command = command
        .mut_args(|arg| {
            // Under a heading of their own, clap would sort arguments by name.
            positionals += usize::from(arg.is_positional());
            let is_positional = arg.is_positional();
            let arg = translate_arg(arg, path);
            if is_positional { arg.display_order(positionals) } else { arg }
        })
        .disable_help_flag(true)
        .arg(flag("help", 'h', ArgAction::Help, "Показать справку"))
        .subcommand_help_heading("Команды")
        .help_template(
            "{before-help}{about-with-newline}\nИспользование: {usage}\n\n{all-args}{after-help}",
        )
        .override_usage(translate_usage(&usage));
    if let Some(about) = ru::text(path) {
        let short = about.split("\n\n").next().unwrap_or(about).trim_end_matches('.');
        command = command.about(short.to_owned()).long_about(about);
    }
    if let Some(examples) = command.get_after_help().map(StyledStr::to_string) {
        command = command.after_help(examples.replace("Examples:", "Примеры:"));
    }
    names.iter().fold(command, |command, name| {
        let path = if path.is_empty() { name.clone() } else { format!("{path} {name}") };
        let Some(built) = built.find_subcommand_mut(name) else { return command };
        command.mut_subcommand(name, |sub| translate(sub, &path, built))
    })
}

fn translate_arg(arg: Arg, path: &str) -> Arg {
    let heading = match arg.get_help_heading() {
        Some(GENERAL) => "Общие параметры",
        _ if arg.is_positional() => "Аргументы",
        _ => "Параметры",
    };
    let key = format!("{path}.{}", arg.get_id());
    let names: Vec<Str> = arg
        .get_value_names()
        .unwrap_or_default()
        .iter()
        .map(|name| ru::value_name(name).map_or_else(|| name.clone(), Str::from))
        .collect();
    let arg = if names.is_empty() { arg } else { arg.value_names(names) };
    match ru::text(&key) {
        Some(text) => arg.help(text).help_heading(heading),
        None => arg.help_heading(heading),
    }
}

fn flag(name: &'static str, short: char, action: ArgAction, help: &'static str) -> Arg {
    Arg::new(name).short(short).long(name).action(action).help(help).help_heading("Параметры")
}

fn translate_usage(usage: &StyledStr) -> String {
    let usage = usage.to_string();
    let mut text = usage.trim_start_matches("Usage:").trim().to_owned();
    text = text.replace("[OPTIONS]", "[ПАРАМЕТРЫ]").replace("<COMMAND>", "<КОМАНДА>");
    // The longest names first: DRIVE is a part of another one.
    for (english, russian) in ru::VALUE_NAMES {
        for (open, close) in [('<', '>'), ('[', ']')] {
            text = text
                .replace(&format!("{open}{english}{close}"), &format!("{open}{russian}{close}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(command: &Command, path: &str, all: &mut Vec<String>) {
        all.push(path.to_owned());
        for arg in command.get_arguments() {
            all.push(format!("{path}.{}", arg.get_id()));
        }
        for sub in command.get_subcommands() {
            let name = sub.get_name();
            let path = if path.is_empty() { name.to_owned() } else { format!("{path} {name}") };
            paths(sub, &path, all);
        }
    }

    fn help(command: &mut Command, all: &mut Vec<(String, String)>) {
        all.push((command.get_name().to_owned(), command.render_long_help().to_string()));
        for sub in command.get_subcommands_mut() {
            help(sub, all);
        }
    }

    /// Shell completion offers drives, valves, parameters and programs.
    #[test]
    fn completion_knows_the_words_of_arguments() {
        for (path, id, words) in [
            (&["move"][..], "drive", &["Vertical", "Deployer"][..]),
            (&["open"], "valve", &["Valve2"]),
            (&["status"], "subsystem", &["Detector", "Radio"]),
            (&["limits"], "what", &["reject", "Nozzle"]),
            (&["param", "get"], "name", &["MaxLimit", "Program3"]),
            (&["program", "run"], "number", &["7"]),
            (&["quench"], "program", &["0"]),
        ] {
            let whole = completed();
            let command = path.iter().try_fold(&whole, |at, name| at.find_subcommand(name));
            let command = command.unwrap_or_else(|| panic!("{path:?}"));
            let arg = command.get_arguments().find(|arg| arg.get_id() == id);
            let known = arg.unwrap_or_else(|| panic!("{path:?} {id}")).get_possible_values();
            for word in words {
                assert!(known.iter().any(|value| value.get_name() == *word), "{path:?} {word}");
            }
        }
    }

    /// Arguments in their order; the command's own options before the general ones.
    #[test]
    fn help_begins_with_what_is_the_commands_own() {
        for (english, general) in [(true, "General options:"), (false, "Общие параметры:")]
        {
            let mut command = if english { command() } else { russian(Cli::command()) };
            command.build();
            let limits = command.find_subcommand_mut("limits").unwrap();
            let text = limits.render_long_help().to_string();
            let (own, rest) = text.split_once("reject]").unwrap();
            assert!(own.contains("limits"), "{text}");
            let drive = if english { "[DRIVE]" } else { "[ПРИВОД]" };
            assert!(rest.contains(drive), "{text}");
            let quench = command.find_subcommand_mut("quench").unwrap();
            let text = quench.render_long_help().to_string();
            let at = |word: &str| text.find(word).unwrap_or_else(|| panic!("{word}: {text}"));
            for own in ["--program", "--follow", "--corrections"] {
                assert!(at(own) < at(general), "{own}: {text}");
            }
            assert!(at(general) < at("--timeout") && at(general) < at("--json"), "{text}");
        }
    }

    #[test]
    fn the_command_line_is_sound() {
        everywhere(completed(), &|command| command).debug_assert();
        everywhere(command(), &|command| command).debug_assert();
        russian(Cli::command()).debug_assert();
    }

    #[test]
    fn every_text_has_its_russian_and_no_russian_is_left_over() {
        let mut wanted = Vec::new();
        paths(&Cli::command(), "", &mut wanted);
        for key in &wanted {
            assert!(ru::text(key).is_some(), "`{key}` has no Russian text");
        }
        for (key, text) in ru::TEXTS {
            assert!(wanted.iter().any(|wanted| wanted == key), "`{key}` is nothing");
            assert!(text.chars().any(|c| ('а'..='я').contains(&c)), "`{key}`: {text}");
        }
    }

    #[test]
    fn every_command_has_an_example_in_both_languages() {
        for (english, heading) in [(true, "Examples:"), (false, "Примеры:")] {
            let mut command = if english { Cli::command() } else { russian(Cli::command()) };
            command.build();
            let mut all = Vec::new();
            help(&mut command, &mut all);
            for (name, help) in all {
                assert!(help.contains(heading) && help.contains("\n  "), "{name}: {help}");
                if !english {
                    for word in
                        ["Usage", "Options:", "Arguments:", "Commands:", "OPTIONS", "Print "]
                    {
                        assert!(!help.contains(word), "{name}: `{word}` in {help}");
                    }
                }
            }
        }
    }
}
