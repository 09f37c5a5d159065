//! Help and errors of the command line, in English or Russian.
//!
//! clap speaks English. For Russian every text of its command tree is replaced from the table in
//! `ru.rs`, and its errors are told anew; a test finds what the table lacks.

mod errors;
mod ru;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::builder::{Str, StyledStr};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, Command, CommandFactory};

use crate::cli::Cli;
use crate::lang::{Lang, current};

/// The command line in the language of the user.
pub fn command() -> Command {
    // Defaults, variables and choices stand in the texts, where they can be translated.
    let plain = |arg: Arg| match arg.get_action().takes_values() {
        true => arg.hide_default_value(true).hide_env(true).hide_possible_values(true),
        false => arg,
    };
    let command = everywhere(Cli::command(), &|command| command.mut_args(plain));
    match current() {
        Lang::En => command,
        Lang::Ru => russian(command),
    }
}

/// Tells what is wrong with the arguments, or shows the help that was asked for.
pub fn show(error: &clap::Error) -> ExitCode {
    let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    let is_help = asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    // When nobody reads it, the exit code still tells.
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
    // Usage lines are made by clap once the tree is built.
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
    let mut command = command
        .mut_args(|arg| translate_arg(arg, path))
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
    let heading = if arg.is_positional() { "Аргументы" } else { "Параметры" };
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

    #[test]
    fn the_command_line_is_sound() {
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
