//! The tables of docs/protocol.md and docs/protocol.ru.md, generated from the protocol dictionary.

use serde_json::Value;

use crate::citation::citations;

/// A page with generated tables.
pub struct Page {
    /// From the root.
    pub path: &'static str,
    lang: Lang,
    /// The tables that the page must have, besides those of flags.
    lists: &'static [&'static str],
}

pub const PAGES: [Page; 2] = [
    Page { path: "docs/protocol.md", lang: Lang::En, lists: &["params"] },
    Page {
        path: "docs/protocol.ru.md",
        lang: Lang::Ru,
        lists: &["subsystems", "statuses", "requests", "params"],
    },
];

#[derive(Clone, Copy, PartialEq)]
enum Lang {
    En,
    Ru,
}

/// Sections with a flag table, and their classes in the dictionary. The common flags are part of
/// every class.
const CLASSES: [(&str, &str); 9] = [
    (COMMON, "GeneralFlags"),
    ("§3.3.2", "GeneralFlags"),
    ("§3.3.3", "ClimaticsFlags"),
    ("§3.3.4", "DriveFlags"),
    ("§3.3.5", "ValveFlags"),
    ("§3.3.6", "ControlFlags"),
    ("§3.3.7", "DetectorFlags"),
    ("§3.3.8", "DeployerFlags"),
    ("§3.3.10", "ButtonsFlags"),
];
const COMMON: &str = "§3.3.1";
const COMMON_BITS: u64 = 16;

/// A column: its title in English and Russian, and the key of its values.
type Column = (&'static str, &'static str, &'static str);

const SUBSYSTEMS: &[Column] = &[
    ("subsystem", "подсистема", "name"),
    ("id", "идентификатор", "byte"),
    ("title", "название", "title"),
    ("meaning", "назначение", "meaning"),
];
const STATUSES: &[Column] = &[
    ("value", "значение", "value"),
    ("status", "код возврата", "name"),
    ("meaning", "смысл", "meaning"),
    ("what to do", "что делать", "remedy"),
];
const REQUESTS: &[Column] = &[
    ("section", "раздел", "section"),
    ("request", "запрос", "name"),
    ("id", "идентификатор", "byte"),
    ("addressees", "адресаты", "addressees"),
    ("title", "название", "title"),
    ("meaning", "действие", "meaning"),
];
const PARAMS: &[Column] = &[
    ("subsystem", "подсистема", "subsystem"),
    ("parameter", "параметр", "name"),
    ("id", "идентификатор", "id"),
    ("values", "значений", "len"),
    ("unit", "единица", "unit"),
    ("min", "не менее", "min"),
    ("max", "не более", "max"),
    ("default", "по умолчанию", "default"),
    ("access", "доступ", "access"),
    ("acts", "действует", "effect"),
    ("kept", "хранится", "placement"),
    ("meaning", "смысл", "text"),
];
const FLAGS: &[Column] = &[
    ("bit", "бит", "shift"),
    ("flag", "флаг", "name"),
    ("severity", "значимость", "severity"),
    ("meaning", "смысл", "meaning"),
    ("likely cause", "вероятная причина", "cause"),
    ("what to do", "что делать", "remedy"),
];

/// Words of the dictionary that it has in English only, in Russian.
const RUSSIAN: [(&str, &str); 6] = [
    ("read-only", "чтение"),
    ("read-write", "чтение и запись"),
    ("at-once", "сразу"),
    ("after-restart", "после Restart"),
    ("local", "в стволе"),
    ("unit", "в удалённом блоке"),
];

impl Lang {
    const fn key(self) -> &'static str {
        match self {
            Self::En => "en",
            Self::Ru => "ru",
        }
    }

    /// A word of the dictionary in this language; an error for one without a translation.
    fn word(self, word: &str) -> Result<String, String> {
        match RUSSIAN.iter().find(|(english, _)| *english == word) {
            _ if self == Self::En => Ok(word.into()),
            Some((_, russian)) => Ok((*russian).into()),
            None => Err(format!("`{word}` has no Russian word in xtask/src/tables.rs")),
        }
    }

    /// The name of a severity in this language.
    fn severity(self, name: &str, schema: &Value) -> Result<String, String> {
        let mut all = schema["severities"].as_array().into_iter().flatten();
        let found = all.find(|texts| texts["en"] == name);
        let texts = found.ok_or_else(|| format!("`lafet schema`: no severity `{name}`"))?;
        Ok(words(texts, self))
    }
}

/// The page with new text between `<!-- NAME:begin -->` and its end, for each table of the page, and
/// for `flags` under each heading of §3.3.1–§3.3.10.
pub fn regenerate(page: &Page, text: &str, schema: &Value) -> Result<String, String> {
    let path = page.path;
    let mut fresh = String::new();
    let mut section = String::new();
    let mut done = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        fresh += line;
        fresh.push('\n');
        if line.starts_with('#') {
            section = citations(line).into_iter().next().unwrap_or_default();
        }
        let mark = line.strip_prefix("<!-- ").and_then(|line| line.strip_suffix(":begin -->"));
        let Some(name) = mark else { continue };
        let table = match name {
            "flags" => flags(page, schema, &section)?,
            name => list(page, schema, name)?,
        };
        let end = format!("<!-- {name}:end -->");
        if !lines.any(|line| line == end) {
            return Err(format!("{path}: `{end}` is missing ({section})"));
        }
        fresh.extend([&table, &end, "\n"]);
        done.push(if name == "flags" { section.clone() } else { name.into() });
    }
    let wanted = CLASSES.iter().map(|(section, _)| section).chain(page.lists);
    let missing: Vec<&str> =
        wanted.filter(|name| !done.iter().any(|d| d == *name)).copied().collect();
    match missing[..] {
        [] => Ok(fresh),
        _ => Err(format!("{path}: no marks for a generated table of {}", missing.join(", "))),
    }
}

/// The table of a list of the dictionary.
fn list(page: &Page, schema: &Value, name: &str) -> Result<String, String> {
    let columns = match name {
        "subsystems" => SUBSYSTEMS,
        "statuses" => STATUSES,
        "requests" => REQUESTS,
        "params" => PARAMS,
        other => return Err(format!("{}: no table is called `{other}`", page.path)),
    };
    table(rows(&schema[name], name)?.iter(), columns, page.lang, schema)
}

fn flags(page: &Page, schema: &Value, section: &str) -> Result<String, String> {
    let Some((_, class)) = CLASSES.iter().find(|(known, _)| *known == section) else {
        return Err(format!("{}: `{section}` has no flags of its own", page.path));
    };
    let rows = rows(&schema["flags"][class], class)?;
    // Every class starts with the common flags, which are listed only in their own section.
    let common = section == COMMON;
    let own = rows.iter().filter(|row| common == (row["shift"].as_u64() < Some(COMMON_BITS)));
    table(own, FLAGS, page.lang, schema)
}

fn rows<'a>(list: &'a Value, name: &str) -> Result<&'a Vec<Value>, String> {
    let rows = list.as_array().filter(|rows| !rows.is_empty());
    rows.ok_or_else(|| format!("`lafet schema`: `{name}` is not a list, or is empty"))
}

fn table<'a>(
    rows: impl Iterator<Item = &'a Value>,
    columns: &[Column],
    lang: Lang,
    schema: &Value,
) -> Result<String, String> {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let title = |(english, russian, _): &Column| match lang {
        Lang::En => (*english).to_owned(),
        Lang::Ru => (*russian).to_owned(),
    };
    let mut text = line(columns.iter().map(title).collect());
    text += &line(columns.iter().map(|_| "---".into()).collect());
    for row in rows {
        let cells: Result<Vec<String>, String> =
            columns.iter().map(|(_, _, key)| cell(row, key, lang, schema)).collect();
        text += &line(cells?);
    }
    Ok(text)
}

fn cell(row: &Value, key: &str, lang: Lang, schema: &Value) -> Result<String, String> {
    let of = |key: &str| row.get(key).ok_or_else(|| format!("`lafet schema`: no `{key}` in {row}"));
    Ok(match key {
        "name" => format!("`{}`", words(of(key)?, lang)),
        "byte" => format!("0x{:02X}", of("id")?.as_u64().unwrap_or(0)),
        "id" => format!("0x{:04X}", of(key)?.as_u64().unwrap_or(0)),
        "shift" => bits(row, of(key)?),
        "len" => length(of(key)?, lang),
        "min" | "max" | "default" => bound(row, of(key)?, lang),
        "severity" => lang.severity(&words(of(key)?, lang), schema)?,
        "access" | "effect" | "placement" => lang.word(&words(of(key)?, lang))?,
        "section" => section(&words(of(key)?, lang)),
        "addressees" if *of(key)? == Value::Array(Vec::new()) => match lang {
            Lang::En => "any".into(),
            Lang::Ru => "любые".into(),
        },
        // A subsystem has its title in both languages beside the other keys.
        "title" if row.get(key).is_none() => words(of(lang.key())?, lang),
        _ => words(of(key)?, lang),
    })
}

/// Number of a flag's bit, or of its bits.
fn bits(row: &Value, shift: &Value) -> String {
    let (shift, width) = (shift.as_u64().unwrap_or(0), row["width"].as_u64().unwrap_or(1));
    if width > 1 { format!("{shift}…{}", shift + width - 1) } else { shift.to_string() }
}

/// The section of a request; a service of the bus controller is not in the document.
fn section(name: &str) -> String {
    if name == "bus" { "§B".into() } else { format!("§{name}") }
}

/// The number of values of a parameter.
fn length(len: &Value, lang: Lang) -> String {
    let [min, max, step] = ["min", "max", "step"].map(|key| len[key].as_u64().unwrap_or(0));
    let by = if lang == Lang::En { "by" } else { "по" };
    match (min == max, step) {
        (true, _) => max.to_string(),
        (false, 0 | 1) => format!("{min}…{max}"),
        (false, _) => format!("{min}…{max} {by} {step}"),
    }
}

/// A bound or default: empty for measured values, hexadecimal for bit masks, and a list for values
/// with different units.
fn bound(row: &Value, value: &Value, lang: Lang) -> String {
    if row["access"] == "read-only" {
        return String::new();
    }
    match value.as_u64() {
        Some(bits) if row["quantity"] == "Bits" => format!("0x{bits:X}"),
        _ => words(value, lang),
    }
}

/// A value as a table cell: for a text in two languages, the one of the page.
fn words(value: &Value, lang: Lang) -> String {
    match value {
        Value::Null => String::new(),
        Value::Array(list) => {
            list.iter().map(|value| words(value, lang)).collect::<Vec<_>>().join(", ")
        }
        Value::Object(texts) => {
            texts.get(lang.key()).map(|text| words(text, lang)).unwrap_or_default()
        }
        Value::String(text) => text.replace('|', "\\|").replace('\n', " "),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const ENGLISH: &Page = &PAGES[0];
    const RUSSIAN_PAGE: &Page = &PAGES[1];

    fn flag(name: &str, shift: u32, width: u32) -> Value {
        json!({"name": name, "shift": shift, "width": width, "severity": "info",
               "meaning": {"en": "a | b", "ru": "в"}, "cause": null, "remedy": {"en": "look"}})
    }

    fn schema() -> Value {
        let both = [flag("ConfigFault", 0, 1), flag("Move", 16, 1)];
        let mut flags = json!({"ButtonsFlags": [flag("Left", 16, 2)]});
        for (_, class) in CLASSES.iter().filter(|(_, class)| *class != "ButtonsFlags") {
            flags[class] = json!(both);
        }
        let param = json!({"subsystem": "General", "name": "Address", "id": 4342,
            "len": {"min": 0, "max": 60, "step": 4}, "unit": "", "min": 1, "max": 127, "default": 1,
            "access": "read-write", "effect": "after-restart", "placement": "local",
            "text": {"en": "Address", "ru": "Адрес"}});
        let text = json!({"en": "English", "ru": "по-русски"});
        json!({
            "flags": flags,
            "severities": [{"en": "info", "ru": "норма"}],
            "params": [param],
            "subsystems": [{"name": "All", "id": 93, "en": "All", "ru": "Все", "meaning": text}],
            "statuses": [{"value": 0, "name": "Ok", "meaning": text, "remedy": text}],
            "requests": [{"section": "bus", "name": "GetLog", "id": 14, "addressees": [],
                "title": text, "meaning": text}],
        })
    }

    fn text(page: &Page) -> String {
        let mut text = String::new();
        for (section, class) in CLASSES {
            text +=
                &format!("#### {section} {class}\n<!-- flags:begin -->\nold\n<!-- flags:end -->\n");
        }
        for list in page.lists {
            text += &format!("## {list}\n<!-- {list}:begin -->\n<!-- {list}:end -->\n");
        }
        text + "the end\n"
    }

    #[test]
    fn each_section_gets_its_own_flags() {
        let new = regenerate(ENGLISH, &text(ENGLISH), &schema()).unwrap();
        assert!(!new.contains("old") && new.ends_with("the end\n"), "{new}");
        assert_eq!(new.matches("| 0 | `ConfigFault` |").count(), 1);
        assert_eq!(new.matches("| 16 | `Move` | info | a \\| b |  | look |\n").count(), 7);
        assert_eq!(new.matches("| 16…17 | `Left` |").count(), 1);
        assert_eq!(new.matches("| General | `Address` | 0x10F6 | 0…60 by 4 |").count(), 1);
        assert_eq!(regenerate(ENGLISH, &new, &schema()).unwrap(), new);
    }

    #[test]
    fn the_russian_page_has_russian_words() {
        let new = regenerate(RUSSIAN_PAGE, &text(RUSSIAN_PAGE), &schema()).unwrap();
        assert_eq!(new.matches("| 16 | `Move` | норма | в |  |  |\n").count(), 7);
        let row =
            "0…60 по 4 |  | 1 | 127 | 1 | чтение и запись | после Restart | в стволе | Адрес |";
        assert!(new.contains(row), "{new}");
        assert!(new.contains("| `All` | 0x5D | Все | по-русски |"), "{new}");
        assert!(new.contains("| §B | `GetLog` | 0x0E | любые | по-русски | по-русски |"), "{new}");
        assert!(new.contains("| 0 | `Ok` | по-русски | по-русски |"), "{new}");
        assert!(!new.contains("English"), "{new}");
    }

    #[test]
    fn a_word_without_translation_is_an_error() {
        let mut schema = schema();
        schema["params"][0]["effect"] = json!("tomorrow");
        assert!(regenerate(ENGLISH, &text(ENGLISH), &schema).is_ok());
        let error = regenerate(RUSSIAN_PAGE, &text(RUSSIAN_PAGE), &schema).unwrap_err();
        assert!(error.contains("`tomorrow`"), "{error}");
    }

    #[test]
    fn marks_that_are_missing_or_wrong_are_errors() {
        let error = |text: String| regenerate(ENGLISH, &text, &schema()).unwrap_err();
        let page = text(ENGLISH);
        assert!(error(page.replace("params:end", "params")).contains("is missing"));
        assert!(error(page.replace("§3.3.4", "§3.3.9")).contains("no flags of its own"));
        assert!(error(page.replace("params:begin", "param:begin")).contains("no table is called"));
        assert!(error("# nothing\n".into()).contains("§3.3.1, §3.3.2"));
    }

    #[test]
    fn a_schema_of_another_shape_is_an_error() {
        assert!(flags(ENGLISH, &json!({}), COMMON).is_err());
        assert!(list(ENGLISH, &json!({"params": []}), "params").is_err());
        let schema = json!({"params": [{"subsystem": "General"}]});
        let error = list(ENGLISH, &schema, "params").unwrap_err();
        assert!(error.contains("no `name`"), "{error}");
    }
}
