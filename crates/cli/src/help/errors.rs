//! clap's errors in other languages than English, which is its own.

use std::error::Error as _;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use lafet_texts::{Lang, Text as _, cli as text};

/// The error, and where to read more.
pub fn translated(error: &clap::Error, lang: Lang) -> String {
    let what = what(error, lang);
    let suggestion = [
        ContextKind::SuggestedArg,
        ContextKind::SuggestedSubcommand,
        ContextKind::SuggestedValue,
        ContextKind::SuggestedCommand,
    ]
    .into_iter()
    .find_map(|kind| context(error, kind));
    let error = match suggestion {
        Some(meant) => text::UsageErrorMeant { what, meant }.of(lang),
        None => text::UsageError { what }.of(lang),
    };
    format!("{error}\n{}", text::UsageMore.str(lang))
}

fn what(error: &clap::Error, lang: Lang) -> String {
    let get = |kind| context(error, kind).unwrap_or_default();
    let arg = get(ContextKind::InvalidArg);
    let value = get(ContextKind::InvalidValue);
    match error.kind() {
        ErrorKind::InvalidValue if value.is_empty() => text::NeedsValue { arg }.of(lang),
        ErrorKind::InvalidValue => {
            text::ValueNotKnown { value, arg, known: get(ContextKind::ValidValue) }.of(lang)
        }
        ErrorKind::ValueValidation => {
            let why = error.source().map_or_else(String::new, |why| format!(": {why}"));
            text::ValueWrong { value, arg, why: known_reason(&why, lang) }.of(lang)
        }
        ErrorKind::UnknownArgument => text::ArgumentUnknown { arg }.of(lang),
        ErrorKind::InvalidSubcommand => {
            text::CommandUnknown { name: get(ContextKind::InvalidSubcommand) }.of(lang)
        }
        ErrorKind::ArgumentConflict => {
            text::ArgumentsConflict { arg, other: get(ContextKind::PriorArg) }.of(lang)
        }
        ErrorKind::MissingRequiredArgument => text::ArgumentsMissing { arg }.of(lang),
        ErrorKind::MissingSubcommand => text::CommandMissing.of(lang),
        ErrorKind::TooManyValues => text::ValueTooMany { value, arg }.of(lang),
        ErrorKind::TooFewValues | ErrorKind::WrongNumberOfValues => {
            text::ValueCount { arg }.of(lang)
        }
        ErrorKind::NoEquals => text::EqualsMissing { arg }.of(lang),
        ErrorKind::InvalidUtf8 => text::ArgumentNotUtf8.of(lang),
        _ => error.to_string().trim_start_matches("error:").trim().to_owned(),
    }
}

/// Translates reasons that come from the standard library and from clap, which are English.
fn known_reason(why: &str, lang: Lang) -> String {
    match why {
        // It is a text of ours.
        _ if !why.is_ascii() => why.into(),
        _ if why.contains("is not in") => {
            let range = why.rsplit("is not in").next().unwrap_or_default().trim();
            text::ReasonRange { range: range.replace("..=", "…") }.of(lang)
        }
        _ if why.contains("digit") || why.contains("integer") || why.contains("number") => {
            text::ReasonInteger.of(lang)
        }
        _ if why.contains("float") => text::ReasonNumber.of(lang),
        _ => why.into(),
    }
}

fn context(error: &clap::Error, kind: ContextKind) -> Option<String> {
    let text = match error.get(kind)? {
        ContextValue::String(text) => text.clone(),
        ContextValue::Strings(texts) => texts.join(", "),
        ContextValue::StyledStr(text) => text.to_string(),
        ContextValue::Number(number) => number.to_string(),
        _ => return None,
    };
    Some(text).filter(|text| !text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn errors_are_shown_in_russian() {
        for (arguments, word) in [
            ("lafet", "не указана команда"),
            ("lafet fly", "неизвестная команда `fly`"),
            ("lafet statsu", "Может быть, `status`?"),
            ("lafet status --jsom", "Может быть, `--json`?"),
            ("lafet move", "не хватает аргументов"),
            ("lafet lockout maybe", "возможны: on, off"),
            ("lafet sim --addr 128", "допустимо 1…127"),
            ("lafet sim --seed x", "целое число"),
            ("lafet quench --program 1 --distance 5", "нельзя указывать вместе"),
            ("lafet status --connect", "нужно значение"),
            ("lafet status all more", "more"),
        ] {
            let error = Cli::command()
                .subcommand_required(true)
                .arg_required_else_help(false)
                .try_get_matches_from(arguments.split(' '))
                .expect_err(arguments);
            let text = translated(&error, Lang::Ru);
            assert!(text.contains(word), "{arguments}: {text}");
        }
    }
}
