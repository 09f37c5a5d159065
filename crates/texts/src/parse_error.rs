//! Parse errors of a request's text in the language of the user; lafet-proto has them in English
//! only.

use std::fmt;

use lafet_proto::dictionary::{self, REQUESTS, SUBSYSTEMS};
use lafet_proto::param::Param;
use lafet_proto::text::{ParseError, Wanted};

use crate::{Argument, Lang, Shown, Text as _, client as text};

/// The position of the error, what was expected there, and the word that may have been meant.
pub fn parse_error_text(text: &str, error: &ParseError, lang: Lang) -> String {
    let column = text.get(..error.column).map_or(error.column, |before| before.chars().count());
    let (column, expected) = (column.saturating_add(1), Expected(&error.expected));
    match error.suggestion {
        Some(name) => text::ParseErrorMeant { column, expected, name }.of(lang),
        None => text::ParseError { column, expected }.of(lang),
    }
}

struct Expected<'a>(&'a Wanted);

impl Argument for Expected<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match *self.0 {
            Wanted::Request => {
                let names = list(REQUESTS.iter().map(|info| info.name));
                text::ExpectedRequest { names }.write(lang, out)
            }
            Wanted::Addressee(request) => {
                let names = match dictionary::request(request) {
                    Some(info) if !info.addressees.is_empty() => {
                        list(info.addressees.iter().filter_map(|id| id.name()))
                    }
                    _ => list(SUBSYSTEMS.iter().map(|info| info.name)),
                };
                text::ExpectedSubsystem { names }.write(lang, out)
            }
            Wanted::Param(subsystem) => {
                let names = list(Param::of(subsystem).map(Param::name));
                let subsystem = Shown(subsystem);
                if names.is_empty() {
                    return text::ExpectedParameter { subsystem }.write(lang, out);
                }
                text::ExpectedParameterOf { subsystem, names }.write(lang, out)
            }
            Wanted::Word(words) => text::ExpectedWord { words: Words(words) }.write(lang, out),
            Wanted::Number { what, min, max } => {
                text::ExpectedNumber { what: Number(what), min, max }.write(lang, out)
            }
            Wanted::Numbers { what, count } => {
                text::ExpectedNumbers { what: Number(what), count }.write(lang, out)
            }
            Wanted::Missing(what) => text::Missing { what: Number(what) }.write(lang, out),
            Wanted::Once => text::GivenTwice.write(lang, out),
            Wanted::NotTogether(one, other) => text::NotTogether { one, other }.write(lang, out),
            Wanted::Hex => text::ExpectedHex.write(lang, out),
            Wanted::End => text::ExpectedEnd.write(lang, out),
            Wanted::FewerData => text::ExpectedFewerData.write(lang, out),
            // A later version of lafet-proto may have more variants.
            _ => text::RequestWrong.write(lang, out),
        }
    }
}

/// Words of which one is expected.
struct Words(&'static [&'static str]);

impl Argument for Words {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self.0 {
            [] => Ok(()),
            [one] => out.write_str(one),
            [before @ .., last] => text::Or { one: Self(before), other: *last }.write(lang, out),
        }
    }
}

/// What a number means.
struct Number(&'static str);

impl Argument for Number {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        let what = match self.0 {
            "destination" => text::NumberDestination.fixed(),
            "start, horizontal" => text::NumberStartHorizontal.fixed(),
            "end, horizontal" => text::NumberEndHorizontal.fixed(),
            "start, vertical" => text::NumberStartVertical.fixed(),
            "end, vertical" => text::NumberEndVertical.fixed(),
            "value" => text::NumberValue.fixed(),
            "key" => text::NumberKey.fixed(),
            "program" => text::NumberProgram.fixed(),
            "nozzle" => text::NumberNozzle.fixed(),
            "step" => text::NumberStep.fixed(),
            "distance" => text::NumberDistance.fixed(),
            "dwell" => text::NumberDwell.fixed(),
            "horizontal" => text::NumberHorizontal.fixed(),
            "vertical" => text::NumberVertical.fixed(),
            "correction" => text::NumberCorrection.fixed(),
            "corrections" => text::NumberCorrections.fixed(),
            "trajectory" => text::NumberTrajectory.fixed(),
            "first" => text::NumberFirst.fixed(),
            "count" => text::NumberCount.fixed(),
            "analyse" => text::NumberAnalyse.fixed(),
            "centre h,v" => text::NumberCentre.fixed(),
            "sector width,height" => text::NumberSector.fixed(),
            "point h,v,distance,dwell" => text::NumberPoint.fixed(),
            "distance= or corrections=" => text::NumberDistanceOrCorrections.fixed(),
            "point= or stored=" => text::NumberPointOrStored.fixed(),
            // Keys such as `step=` are the same in every language.
            other => return out.write_str(other),
        };
        what.write(lang, out)
    }
}

fn list(names: impl Iterator<Item = &'static str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every error in a request is reported in Russian without English words, except those that the
    /// user has to write.
    #[test]
    fn mistakes_are_told_in_russian() {
        let mut buffer = [0; lafet_proto::text::BUFFER_SIZE];
        for (text, word) in [
            ("Opn Valve1", "ожидается запрос"),
            ("Move Vertikal 1", "ожидается подсистема"),
            ("Move Vertical", "точка назначения"),
            ("Move Vertical 99999", "точка назначения"),
            ("GetParam Vertical Sped", "ожидается параметр"),
            ("StartSeek Detector 1 2 3", "конец сектора по вертикали"),
            ("StartQuench Control centre=1", "центр по горизонтали"),
            ("StartTrajectory Control", "point= или stored="),
            ("Stop All now", "закончиться"),
        ] {
            let error = lafet_proto::text::parse(text, &mut buffer).expect_err(text);
            let russian = parse_error_text(text, &error, Lang::Ru);
            assert!(russian.contains(word), "{text}: {russian}");
            assert_eq!(parse_error_text(text, &error, Lang::En), error.to_string());
        }
    }

    #[test]
    fn what_was_meant_is_told() {
        let (text, mut buffer) = ("Moev Vertical 1", [0; lafet_proto::text::BUFFER_SIZE]);
        let error = lafet_proto::text::parse(text, &mut buffer).unwrap_err();
        assert!(
            parse_error_text(text, &error, Lang::Ru).ends_with("может быть, `Move`?"),
            "{error}"
        );
        let error = lafet_proto::text::parse("Opn Valve1", &mut buffer).unwrap_err();
        assert!(parse_error_text("Opn Valve1", &error, Lang::En).ends_with("did you mean `Open`?"));
    }
}
