//! Parse errors of a request's text in the language of the user; lafet-proto has them in English
//! only.

use lafet_proto::dictionary::{self, REQUESTS, SUBSYSTEMS};
use lafet_proto::param::Param;
use lafet_proto::text::{ParseError, Wanted};

use crate::Lang;

/// The position of the error, what was expected there, and the word that may have been meant.
pub fn parse_error_text(text: &str, error: &ParseError, lang: Lang) -> String {
    if lang == Lang::En {
        return error.to_string();
    }
    let column = text.get(..error.column).map_or(error.column, |before| before.chars().count());
    let meant = error.suggestion.map(|name| format!("; может быть, `{name}`?"));
    let meant = meant.unwrap_or_default();
    format!("позиция {}: {}{meant}", column + 1, wanted_ru(&error.expected))
}

fn wanted_ru(wanted: &Wanted) -> String {
    match *wanted {
        Wanted::Request => {
            let names = list(REQUESTS.iter().map(|info| info.name));
            format!("ожидается запрос (0x и две цифры либо одно из: {names})")
        }
        Wanted::Addressee(request) => {
            let names = match dictionary::request(request) {
                Some(info) if !info.addressees.is_empty() => {
                    list(info.addressees.iter().filter_map(|id| id.name()))
                }
                _ => list(SUBSYSTEMS.iter().map(|info| info.name)),
            };
            format!("ожидается подсистема (0x и две цифры либо одна из: {names})")
        }
        Wanted::Param(subsystem) => {
            let names = list(Param::of(subsystem).map(Param::name));
            let names =
                if names.is_empty() { names } else { format!(" либо один из: {names}") };
            format!("ожидается параметр {subsystem} (0x и четыре цифры, @ЛюбоеИмя{names})")
        }
        Wanted::Word(words) => format!("ожидается {}", words.join(" или ")),
        Wanted::Number { what, min, max } => {
            format!("ожидается {}: число от {min} до {max}", what_ru(what))
        }
        Wanted::Numbers { what, count } => {
            format!("ожидается {}: чисел через запятую — {count}", what_ru(what))
        }
        Wanted::Missing(what) => format!("не хватает: {}", what_ru(what)),
        Wanted::Once => "задано дважды".into(),
        Wanted::NotTogether(one, other) => {
            format!("{one} и {other} относятся к разным вариантам запроса")
        }
        Wanted::Hex => "ожидаются байты в шестнадцатеричном виде, например `de ad be`".into(),
        Wanted::End => "здесь запрос должен закончиться".into(),
        Wanted::FewerData => "слишком много данных: запрос вмещает не более 255 байт".into(),
        // A later version of lafet-proto may have more variants.
        _ => "запрос записан неверно".into(),
    }
}

/// What a number means; keys such as `step=` are not translated.
fn what_ru(what: &'static str) -> &'static str {
    match what {
        "destination" => "точка назначения",
        "start, horizontal" => "начало сектора по горизонтали",
        "end, horizontal" => "конец сектора по горизонтали",
        "start, vertical" => "начало сектора по вертикали",
        "end, vertical" => "конец сектора по вертикали",
        "value" => "значение",
        "key" => "ключ",
        "program" => "номер программы",
        "nozzle" => "положение насадка",
        "step" => "шаг",
        "distance" => "расстояние",
        "dwell" => "выдержка",
        "horizontal" => "горизонталь",
        "vertical" => "вертикаль",
        "correction" => "поправка",
        "corrections" => "поправки",
        "trajectory" => "номер траектории",
        "first" => "первый номер",
        "count" => "количество",
        "analyse" => "признак анализа",
        "centre h,v" => "центр по горизонтали и вертикали",
        "sector width,height" => "ширина и высота сектора",
        "point h,v,distance,dwell" => "точка: горизонталь, вертикаль, расстояние, выдержка",
        "distance= or corrections=" => "distance= или corrections=",
        "point= or stored=" => "point= или stored=",
        other => other,
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
