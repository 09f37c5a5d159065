//! The texts of the command line, `help.ftl` of `lafet-texts`, by names of commands and arguments.

use lafet_texts::Fixed;
use lafet_texts::help::BY_KEY;

/// How keys of values begin.
pub const VALUE: &str = "value-";

/// What `command subcommand` is for; lafet itself has no name.
pub fn command(path: &str) -> Option<Fixed> {
    find(&command_key(path))
}

/// What an argument of a command is for.
pub fn argument(path: &str, id: &str) -> Option<Fixed> {
    find(&argument_key(path, id))
}

/// The name of a value by its English name, for example FILE.
pub fn value(name: &str) -> Option<Fixed> {
    values().find(|text| text.en == name)
}

/// The names of all values that differ between languages.
pub fn values() -> impl Iterator<Item = Fixed> {
    BY_KEY.iter().filter(|(key, _)| key.starts_with(VALUE)).map(|(_, text)| *text)
}

/// `param get` is `param-get`.
pub fn command_key(path: &str) -> String {
    if path.is_empty() { "lafet".to_owned() } else { path.replace(' ', "-") }
}

/// `dry_run` of `tune` is `tune-arg-dry-run`.
pub fn argument_key(path: &str, id: &str) -> String {
    let argument = format!("arg-{}", id.replace('_', "-"));
    if path.is_empty() { argument } else { format!("{}-{argument}", command_key(path)) }
}

fn find(key: &str) -> Option<Fixed> {
    BY_KEY.iter().find(|(known, _)| *known == key).map(|(_, text)| *text)
}
