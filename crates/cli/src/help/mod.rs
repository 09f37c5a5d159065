//! Help and errors of the command line, in every language.
//!
//! The texts of commands and arguments are in `help.ftl` of `lafet-texts`; a test finds what it lacks
//! or has too much. Headings and errors are clap's own, which are English; for another language they
//! are replaced.

mod errors;
mod texts;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, Str, StyledStr};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, Command, CommandFactory};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::SUBSYSTEMS;
use lafet_proto::param::Param;
use lafet_texts::{Fixed, cli as text};

use crate::cli::{Cli, GENERAL};
use crate::lang::{Lang, current};
use crate::version;

/// The command line in the user's language.
pub fn command() -> Command {
    in_language(plain(), current())
}

/// The command line for shell completion: with the possible values of arguments.
pub fn completed() -> Command {
    in_language(everywhere(plain(), &|command| command.mut_args(words_of)), current())
}

/// The command line without its texts.
fn plain() -> Command {
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
    everywhere(Cli::command(), &|command| command.mut_args(plain))
}

fn in_language(command: Command, lang: Lang) -> Command {
    let command = described(command, "", lang).long_version(version::words(lang));
    match lang {
        Lang::En => command,
        _ => framed(command, lang),
    }
}

/// Adds the possible values to an argument; clap cannot see those of a parser function.
fn words_of(arg: Arg) -> Arg {
    let names = |wanted: fn(SubsystemId) -> bool| {
        let all = SUBSYSTEMS.iter().filter(move |info| wanted(info.id));
        all.map(|info| info.name).collect::<Vec<_>>()
    };
    let shown = arg.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
    let words: Vec<&'static str> = match shown.as_deref() {
        Some("SUBSYSTEM") => names(|_| true),
        Some("DRIVE") => names(SubsystemId::is_drive),
        Some("VALVE") => names(SubsystemId::is_valve),
        Some("DRIVE|off|on|reject") => {
            ["off", "on", "reject"].into_iter().chain(names(SubsystemId::is_drive)).collect()
        }
        Some("NAME") if arg.get_id() == "name" => {
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
    let wants_json = std::env::args_os().any(|argument| argument == "--json");
    if wants_json && error.kind() == ErrorKind::DisplayVersion {
        let _ = writeln!(io::stdout(), "{}", version::json());
        return ExitCode::SUCCESS;
    }
    let is_help = asked || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    // If standard error is closed, the exit code still reports the error.
    let message = if is_help || current() == Lang::En {
        let _ = error.print();
        error.to_string()
    } else {
        let message = errors::translated(error, current());
        let _ = writeln!(io::stderr(), "{message}");
        message
    };
    if asked {
        return ExitCode::SUCCESS;
    }
    if wants_json {
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

/// Gives each command and argument its text.
fn described(command: Command, path: &str, lang: Lang) -> Command {
    let names: Vec<String> =
        command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    let mut command = command.mut_args(|arg| {
        let id = arg.get_id().to_string();
        match texts::argument(path, &id) {
            Some(text) => arg.help(text.str(lang)),
            None => arg,
        }
    });
    if let Some(text) = texts::command(path) {
        let (short, more) = match text.str(lang).split_once("\n\n") {
            Some((short, _)) => (short.trim_end_matches('.'), Some(text.str(lang))),
            // A long text gives each option lines of its own, which suits longer words.
            None => (text.str(lang), (lang != Lang::En).then(|| text.str(lang))),
        };
        command = command.about(short).long_about(more);
    }
    names.iter().fold(command, |command, name| {
        let path = if path.is_empty() { name.clone() } else { format!("{path} {name}") };
        command.mut_subcommand(name, |sub| described(sub, &path, lang))
    })
}

/// Replaces what clap says around the texts.
fn framed(command: Command, lang: Lang) -> Command {
    // clap makes usage lines once the tree is built.
    let mut built = command.clone();
    built.build();
    frame(command, &mut built, lang).disable_version_flag(true).arg(flag(
        ("version", 'V', ArgAction::Version),
        text::OptionVersion.fixed(),
        lang,
    ))
}

fn frame(command: Command, built: &mut Command, lang: Lang) -> Command {
    let names: Vec<String> =
        command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    let usage = built.render_usage();
    let mut positionals = 0;
    let heading = text::HeadingUsage.str(lang);
    let mut command = command
        .mut_args(|arg| {
            // Under a heading of their own, clap would sort arguments by name.
            positionals += usize::from(arg.is_positional());
            let is_positional = arg.is_positional();
            let arg = frame_arg(arg, lang);
            if is_positional { arg.display_order(positionals) } else { arg }
        })
        .disable_help_flag(true)
        .arg(flag(("help", 'h', ArgAction::Help), text::OptionHelp.fixed(), lang))
        .subcommand_help_heading(text::HeadingCommands.str(lang))
        .help_template(format!(
            "{{before-help}}{{about-with-newline}}\n{heading} {{usage}}\n\n{{all-args}}{{after-help}}"
        ))
        .override_usage(frame_usage(&usage, lang));
    if let Some(examples) = command.get_after_help().map(StyledStr::to_string) {
        let [own, others] = [Lang::En, lang].map(|lang| text::HeadingExamples.str(lang));
        command = command.after_help(examples.replace(own, others));
    }
    names.iter().fold(command, |command, name| {
        let Some(built) = built.find_subcommand_mut(name) else { return command };
        command.mut_subcommand(name, |sub| frame(sub, built, lang))
    })
}

fn frame_arg(arg: Arg, lang: Lang) -> Arg {
    let heading = match arg.get_help_heading() {
        Some(GENERAL) => text::HeadingGeneralOptions.str(lang),
        _ if arg.is_positional() => text::HeadingArguments.str(lang),
        _ => text::HeadingOptions.str(lang),
    };
    let names: Vec<Str> = arg
        .get_value_names()
        .unwrap_or_default()
        .iter()
        .map(|name| texts::value(name).map_or_else(|| name.clone(), |text| text.str(lang).into()))
        .collect();
    let arg = if names.is_empty() { arg } else { arg.value_names(names) };
    arg.help_heading(heading)
}

fn flag(of: (&'static str, char, ArgAction), help: Fixed, lang: Lang) -> Arg {
    let (name, short, action) = of;
    let arg = Arg::new(name).short(short).long(name).action(action);
    arg.help(help.str(lang)).help_heading(text::HeadingOptions.str(lang))
}

fn frame_usage(usage: &StyledStr, lang: Lang) -> String {
    let usage = usage.to_string();
    let mut usage = usage.trim_start_matches(text::HeadingUsage.str(Lang::En)).trim().to_owned();
    let words = [text::UsageOptions.fixed(), text::UsageCommand.fixed()];
    for word in texts::values().chain(words) {
        for (open, close) in [('<', '>'), ('[', ']')] {
            let [own, other] =
                [Lang::En, lang].map(|lang| format!("{open}{}{close}", word.str(lang)));
            usage = usage.replace(&own, &other);
        }
    }
    usage
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(command: &Command, path: &str, all: &mut Vec<String>) {
        all.push(texts::command_key(path));
        for arg in command.get_arguments() {
            all.push(texts::argument_key(path, arg.get_id().as_str()));
        }
        for sub in command.get_subcommands() {
            let name = sub.get_name();
            let path = if path.is_empty() { name.to_owned() } else { format!("{path} {name}") };
            keys(sub, &path, all);
        }
    }

    fn value_names(command: &Command, all: &mut BTreeSet<String>) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
            all.extend(arg.get_value_names().unwrap_or_default().iter().map(ToString::to_string));
        }
        for sub in command.get_subcommands() {
            value_names(sub, all);
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

    /// Where each of these words begins a line of the list of arguments.
    fn listed(help: &str, heading: &str, words: &[String]) -> Vec<usize> {
        let (_, list) = help.split_once(heading).unwrap_or_else(|| panic!("{heading}: {help}"));
        // The list ends at the first empty line that the next heading follows.
        let lines: Vec<&str> = list.lines().skip(1).collect();
        let own = lines.iter().take_while(|line| line.is_empty() || line.starts_with(' '));
        let own: Vec<&str> = own.map(|line| line.trim()).collect();
        let at = |word: &String| own.iter().position(|line| line.starts_with(word.as_str()));
        words.iter().map(|word| at(word).unwrap_or_else(|| panic!("{word}: {help}"))).collect()
    }

    /// Lists the arguments of each command in the order in which they are given.
    fn in_order(command: &mut Command, heading: &str) -> usize {
        let names = |arg: &Arg| arg.get_value_names().unwrap_or_default().to_vec();
        let names: Vec<String> = command
            .get_positionals()
            .filter(|arg| !arg.is_hide_set())
            .filter_map(|arg| names(arg).first().map(|name| (arg.is_required_set(), name.clone())))
            .map(|(needed, name)| if needed { format!("<{name}>") } else { format!("[{name}]") })
            .collect();
        let mut seen = 0;
        if names.len() > 1 {
            let places = listed(&command.render_long_help().to_string(), heading, &names);
            assert!(places.is_sorted(), "{}: {names:?} at {places:?}", command.get_name());
            seen += 1;
        }
        seen + command.get_subcommands_mut().map(|sub| in_order(sub, heading)).sum::<usize>()
    }

    #[test]
    fn help_lists_arguments_in_their_order() {
        for (lang, heading) in [(Lang::En, "\nArguments:"), (Lang::Ru, "\nАргументы:")] {
            let mut command = if lang == Lang::En { command() } else { in_language(plain(), lang) };
            command.build();
            let seen = in_order(&mut command, heading);
            assert!(seen > 3, "{seen} commands with several arguments");
        }
    }

    /// Arguments in their order; the command's own options before the general ones.
    #[test]
    fn help_begins_with_what_is_the_commands_own() {
        for (english, general) in [(true, "General options:"), (false, "Общие параметры:")]
        {
            let mut command = if english { command() } else { in_language(plain(), Lang::Ru) };
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
        in_language(plain(), Lang::Ru).debug_assert();
    }

    /// The catalogue has the same keys in each language, so each text is there in each.
    #[test]
    fn every_command_and_argument_has_its_text_and_no_text_is_left_over() {
        let mut wanted = Vec::new();
        keys(&Cli::command(), "", &mut wanted);
        let of_values = |key: &str| key.starts_with(texts::VALUE);
        let known: BTreeSet<&str> = lafet_texts::help::BY_KEY.iter().map(|(key, _)| *key).collect();
        for key in &wanted {
            assert!(known.contains(key.as_str()), "help.ftl has no `{key}`");
        }
        for key in known.iter().filter(|key| !of_values(key)) {
            assert!(wanted.iter().any(|wanted| wanted == key), "`{key}` is nothing");
        }
        assert_eq!(wanted.iter().collect::<BTreeSet<_>>().len(), wanted.len());
        let mut shown = BTreeSet::new();
        value_names(&Cli::command(), &mut shown);
        for name in texts::values() {
            assert!(shown.contains(name.en), "no argument has a value {}", name.en);
        }
        for name in shown.iter().filter(|name| !["N", "URL", "on|off"].contains(&name.as_str())) {
            assert!(texts::value(name).is_some(), "help.ftl does not name the value {name}");
        }
    }

    #[test]
    fn every_command_has_an_example_in_both_languages() {
        for (english, heading) in [(true, "Examples:"), (false, "Примеры:")] {
            let mut command = in_language(plain(), if english { Lang::En } else { Lang::Ru });
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
