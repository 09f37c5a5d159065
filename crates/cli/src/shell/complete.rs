//! Completions at the cursor: commands, subsystems, names of parameters, flags.

use clap::{Arg, Command, CommandFactory};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::{REQUESTS, SUBSYSTEMS};
use lafet_proto::param::Param;
use lafet_texts::cli as text;
use reedline::{Completer, CompletionResult, Span, Suggestion};

use super::words::{Word, split};
use crate::cli::{Cli, subsystem};
use crate::help;
use crate::lang::{current, of};

/// Options that apply to the whole shell and are set at its start.
pub const FIXED: [&str; 3] = ["connect", "lang", "timeout"];

/// A completion and its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Text to insert.
    pub text: String,
    /// One line that explains it.
    pub meaning: String,
}

/// Completes lines by the same clap description that parses them.
pub struct Grammar {
    /// With value names as in the code.
    plain: Command,
    /// With texts in the user's language.
    told: Command,
}

impl Grammar {
    /// The grammar of the command line.
    pub fn new() -> Self {
        let (mut plain, mut told) = (Cli::command(), help::command());
        plain.build();
        told.build();
        Self { plain, told }
    }

    /// Completions for the end of this text, and the byte offset from which it is replaced.
    pub fn candidates(&self, text: &str) -> (usize, Vec<Candidate>) {
        let mut words = split(text);
        let end = words.last().map_or(0, |word| word.span.end);
        if text[end..].contains('#') {
            // A comment.
            return (text.len(), Vec::new());
        }
        let apart = words.last().is_none_or(|word| !word.open && word.span.end < text.len());
        let part = if apart { None } else { words.pop() };
        let start = part.as_ref().map_or(text.len(), |word| word.span.start);
        let part = part.map_or_else(String::new, |word| word.text);
        let mut all = self.all(&words, &part);
        let wanted = part.to_lowercase();
        all.retain(|candidate| candidate.text.to_lowercase().starts_with(&wanted));
        (start, all)
    }

    fn all(&self, before: &[Word], part: &str) -> Vec<Candidate> {
        let place = Place::of(&self.plain, &self.told, before);
        if let Some(option) = place.option {
            return place.values(option);
        }
        if part.starts_with('-') {
            return place.flags();
        }
        let mut all = Vec::new();
        if place.is_root {
            let leave = text::LeaveShell.str(current());
            let explain = text::ExplainCommand.str(current());
            all.extend([candidate("help", explain), candidate("exit", leave)]);
        }
        if place.positionals == 0 {
            let subcommands = place.told.get_subcommands();
            all.extend(
                subcommands
                    .filter(|sub| sub.get_name() != "shell" && sub.get_name() != "help")
                    .map(|sub| candidate(sub.get_name(), &styled(sub.get_about()))),
            );
        }
        let last = place.plain.get_positionals().last();
        let many = last.filter(|arg| arg.get_num_args().is_some_and(|n| n.max_values() > 1));
        if let Some(arg) = place.plain.get_positionals().nth(place.positionals).or(many) {
            all.extend(place.values(arg));
        }
        all
    }
}

/// Position of the cursor in the grammar.
struct Place<'a> {
    plain: &'a Command,
    told: &'a Command,
    is_root: bool,
    /// Number of positional arguments before it.
    positionals: usize,
    /// The option whose value comes next.
    option: Option<&'a Arg>,
    before: &'a [Word],
}

impl<'a> Place<'a> {
    fn of(plain: &'a Command, told: &'a Command, before: &'a [Word]) -> Self {
        let mut place = Self { plain, told, is_root: true, positionals: 0, option: None, before };
        for (index, Word { text, .. }) in before.iter().enumerate() {
            let long = text.strip_prefix("--");
            if place.option.take().is_some() || (index == 0 && text == "help") {
                place.is_root = false;
                continue;
            }
            if let Some(long) = long {
                let arg = place.plain.get_arguments().find(|arg| arg.get_long() == Some(long));
                place.option = arg.filter(|arg| arg.get_action().takes_values());
                continue;
            }
            let sub = place.plain.find_subcommand(text).filter(|_| place.positionals == 0);
            match (sub, place.told.find_subcommand(text)) {
                (Some(plain), Some(told)) => (place.plain, place.told) = (plain, told),
                _ => place.positionals += 1,
            }
            place.is_root = false;
        }
        place
    }

    fn flags(&self) -> Vec<Candidate> {
        let args = self.told.get_arguments();
        let args = args.filter(|arg| !FIXED.contains(&arg.get_id().as_str()));
        let flag =
            |arg: &Arg| Some(candidate(&format!("--{}", arg.get_long()?), &styled(arg.get_help())));
        args.filter_map(flag).collect()
    }

    /// Possible values of an argument.
    fn values(&self, arg: &Arg) -> Vec<Candidate> {
        let possible = arg.get_possible_values();
        if !possible.is_empty() {
            return possible.iter().map(|value| candidate(value.get_name(), "")).collect();
        }
        let name = arg.get_value_names().unwrap_or_default().first();
        match name.map(|name| name.as_str()) {
            Some("SUBSYSTEM") => subsystems(|_| true),
            Some("DRIVE") => subsystems(SubsystemId::is_drive),
            Some("VALVE") => subsystems(SubsystemId::is_valve),
            Some("DRIVE|off|on|reject") => {
                let words = ["off", "on", "reject"].map(|word| candidate(word, ""));
                words.into_iter().chain(subsystems(SubsystemId::is_drive)).collect()
            }
            Some("NAME") => self.params(),
            Some("REQUEST") => self.request(),
            _ => Vec::new(),
        }
    }

    /// Parameters of the subsystem given before.
    fn params(&self) -> Vec<Candidate> {
        let named = self.before.iter().rev().find_map(|word| subsystem(&word.text).ok());
        let params = named.into_iter().flat_map(Param::of);
        params.map(|param| candidate(param.name(), of(&param.text()))).collect()
    }

    /// The words of a request as text.
    fn request(&self) -> Vec<Candidate> {
        match self.positionals {
            0 => REQUESTS.iter().map(|info| candidate(info.name, of(&info.title))).collect(),
            1 => {
                let name = &self.before.last().map_or("", |word| word.text.as_str());
                let info = REQUESTS.iter().find(|info| info.name.eq_ignore_ascii_case(name));
                let to = info.map_or(&[][..], |info| info.addressees);
                subsystems(|id| to.is_empty() || to.contains(&id))
            }
            2 => self.params(),
            _ => Vec::new(),
        }
    }
}

fn subsystems(wanted: impl Fn(SubsystemId) -> bool) -> Vec<Candidate> {
    let infos = SUBSYSTEMS.iter().filter(|info| wanted(info.id));
    infos.map(|info| candidate(info.name, of(&info.title))).collect()
}

fn candidate(text: &str, meaning: &str) -> Candidate {
    // One line of a menu, not a paragraph.
    let meaning = meaning.lines().next().unwrap_or_default().to_owned();
    Candidate { text: text.to_owned(), meaning }
}

fn styled(text: Option<&clap::builder::StyledStr>) -> String {
    text.map(ToString::to_string).unwrap_or_default()
}

impl Completer for Grammar {
    fn complete(&mut self, line: &str, pos: usize) -> CompletionResult {
        let (start, all) = self.candidates(line.get(..pos).unwrap_or(line));
        let suggestion = |candidate: Candidate| Suggestion {
            value: candidate.text,
            description: Some(candidate.meaning).filter(|meaning| !meaning.is_empty()),
            span: Span::new(start, pos),
            append_whitespace: true,
            ..Suggestion::default()
        };
        if all.is_empty() {
            // Offer the text itself: reedline's message for an empty menu is English only.
            let value = line.get(start..pos).unwrap_or_default().to_owned();
            let span = Span::new(start, pos);
            return CompletionResult::fresh(vec![Suggestion {
                value,
                span,
                ..Suggestion::default()
            }]);
        }
        CompletionResult::fresh(all.into_iter().map(suggestion).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(line: &str) -> Vec<String> {
        let (_, all) = Grammar::new().candidates(line);
        all.into_iter().map(|candidate| candidate.text).collect()
    }

    #[test]
    fn what_may_follow() {
        for (line, expected) in [
            ("mo", &["move"][..]),
            ("move ", &["Vertical", "Horizontal", "Nozzle", "Deployer"]),
            ("move ver", &["Vertical"]),
            ("MOVE", &["move"]),
            ("open ", &["Valve1", "Valve2"]),
            ("param ", &["get", "set", "list"]),
            ("param get valve1 Tra", &["TravelTime"]),
            ("param get climatics ", &["HeatOn", "HeatOff"]),
            ("move vertical 3 --n", &["--no-wait"]),
            ("lockout ", &["on", "off"]),
            ("limits o", &["off", "on"]),
            ("limits off noz", &["Nozzle"]),
            ("send Dep", &["Deploy"]),
            ("send Deploy ", &["Deployer"]),
            ("send GetParam Valve2 T", &["TravelTime"]),
            ("help mov", &["move"]),
            ("top --page d", &["detail"]),
            ("# mo", &[]),
        ] {
            let all = texts(line);
            for word in expected {
                assert!(all.iter().any(|text| text == word), "{line}: {all:?}");
            }
            let spare = all.iter().filter(|text| !expected.contains(&text.as_str()));
            // Where several commands start alike, further ones are allowed.
            let spare: Vec<_> = spare.filter(|_| !line.starts_with("param ")).collect();
            assert!(spare.is_empty(), "{line}: {spare:?}");
        }
    }

    #[test]
    fn commands_need_no_url_and_flags_of_the_shell_are_fixed() {
        let root = texts("");
        assert!(root.contains(&"stop".into()) && root.contains(&"exit".into()), "{root:?}");
        assert!(!root.contains(&"shell".into()) && !root.contains(&"Vertical".into()), "{root:?}");
        let flags = texts("status --");
        assert!(flags.contains(&"--json".into()), "{flags:?}");
        for fixed in FIXED {
            assert!(!flags.contains(&format!("--{fixed}")), "{flags:?}");
        }
    }

    #[test]
    fn the_word_at_the_cursor_is_replaced() {
        let (start, all) = Grammar::new().candidates("move  ver");
        assert_eq!((start, all[0].text.as_str()), (6, "Vertical"));
        assert!(!all[0].meaning.is_empty());
    }
}
