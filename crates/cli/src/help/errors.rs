//! clap's errors in Russian.

use std::error::Error as _;

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// The error, and where to read more.
pub fn russian(error: &clap::Error) -> String {
    let mut text = format!("Ошибка: {}", what(error));
    let suggestion = [
        ContextKind::SuggestedArg,
        ContextKind::SuggestedSubcommand,
        ContextKind::SuggestedValue,
        ContextKind::SuggestedCommand,
    ]
    .into_iter()
    .find_map(|kind| context(error, kind));
    if let Some(suggestion) = suggestion {
        text.push_str(&format!(". Может быть, `{suggestion}`?"));
    }
    text.push_str("\nПодробнее: lafet --help или lafet КОМАНДА --help");
    text
}

fn what(error: &clap::Error) -> String {
    let get = |kind| context(error, kind).unwrap_or_default();
    let arg = get(ContextKind::InvalidArg);
    let value = get(ContextKind::InvalidValue);
    match error.kind() {
        ErrorKind::InvalidValue if value.is_empty() => format!("для `{arg}` нужно значение"),
        ErrorKind::InvalidValue => {
            let known = get(ContextKind::ValidValue);
            format!("неверное значение `{value}` для `{arg}`; возможны: {known}")
        }
        ErrorKind::ValueValidation => {
            let why = error.source().map_or_else(String::new, |source| format!(": {source}"));
            format!("неверное значение `{value}` для `{arg}`{}", known_reason(&why))
        }
        ErrorKind::UnknownArgument => format!("неизвестный аргумент `{arg}`"),
        ErrorKind::InvalidSubcommand => {
            format!("неизвестная команда `{}`", get(ContextKind::InvalidSubcommand))
        }
        ErrorKind::ArgumentConflict => {
            format!("`{arg}` нельзя указывать вместе с `{}`", get(ContextKind::PriorArg))
        }
        ErrorKind::MissingRequiredArgument => format!("не хватает аргументов: {arg}"),
        ErrorKind::MissingSubcommand => "не указана команда".into(),
        ErrorKind::TooManyValues => format!("лишнее значение `{value}` для `{arg}`"),
        ErrorKind::TooFewValues | ErrorKind::WrongNumberOfValues => {
            format!("неверное число значений для `{arg}`")
        }
        ErrorKind::NoEquals => format!("после `{arg}` нужен знак ="),
        ErrorKind::InvalidUtf8 => "аргумент не в кодировке UTF-8".into(),
        _ => error.to_string().trim_start_matches("error:").trim().to_owned(),
    }
}

/// Translates reasons that come from the standard library and from clap, which are English.
fn known_reason(why: &str) -> String {
    let russian = why.chars().any(|c| ('а'..='я').contains(&c));
    match why {
        _ if russian => why.into(),
        _ if why.contains("is not in") => {
            let range = why.rsplit("is not in").next().unwrap_or_default().trim();
            format!(": допустимо {}", range.replace("..=", "…"))
        }
        _ if why.contains("digit") || why.contains("integer") || why.contains("number") => {
            ": ожидается целое число, в допустимых пределах".into()
        }
        _ if why.contains("float") => ": ожидается число".into(),
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
            let text = russian(&error);
            assert!(text.contains(word), "{arguments}: {text}");
        }
    }
}
