//! The table of docs/faults.md in Russian: lines of scenarios stay as they are, texts are looked up.

use crate::run;

/// The Russian texts: see the head of the file.
const TEXTS: &str = "conformance/faults.ru.txt";
const HEADS: [(&str, &str); 2] = [
    (
        "| flag | subsystem | severity | how | shows within |",
        "| флаг | подсистема | значимость | как воспроизвести | виден в пределах |",
    ),
    ("| status | how |", "| код возврата | как воспроизвести |"),
];
const SEVERITIES: [(&str, &str); 4] = [
    ("info", "норма"),
    ("notice", "к сведению"),
    ("warning", "предупреждение"),
    ("alarm", "тревога"),
];

/// The English texts and the Russian ones.
struct Texts(Vec<(String, String)>);

/// The whole table; an error names the text without a translation.
pub fn table(english: &str) -> Result<String, String> {
    translate(english, &Texts::parse(&run::read(TEXTS)?)?)
}

fn translate(english: &str, texts: &Texts) -> Result<String, String> {
    let mut text = String::new();
    for (index, line) in english.lines().enumerate() {
        text += &if index == 0 { summary(line)? } else { texts.line(line)? };
        text.push('\n');
    }
    Ok(text)
}

/// The line with the numbers of rows.
fn summary(line: &str) -> Result<String, String> {
    let words =
        line.split([' ', ',']).filter(|word| word.starts_with(|c: char| c.is_ascii_digit()));
    let numbers: Vec<String> = words.map(|word| word.replace('.', ",")).collect();
    let [rows, holes, reached, never, faults, soon, time, late] = &numbers[..] else {
        return Err(format!("expected eight numbers in `{line}`"));
    };
    Ok(format!(
        "Строк {rows}, без проверки {holes}: воспроизводятся {reached}, по решению не устанавливаются \
         никогда {never}. Из воспроизводимых предупреждений и тревог — {faults}: {soon} видны в \
         пределах {time} с, {late} — позже, по указанной причине."
    ))
}

impl Texts {
    fn parse(text: &str) -> Result<Self, String> {
        let lines: Vec<&str> =
            text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
        let pairs = lines.chunks(2).map(|pair| match pair {
            [english, russian] => Ok(((*english).to_owned(), (*russian).to_owned())),
            _ => Err(format!("{TEXTS}: the last text has no translation")),
        });
        pairs.collect::<Result<_, _>>().map(Self)
    }

    fn of(&self, english: &str) -> Result<&str, String> {
        let found = self.0.iter().find(|(text, _)| text == english);
        let missing = || format!("{TEXTS}: no translation of `{english}`: add it");
        found.map(|(_, russian)| russian.as_str()).ok_or_else(missing)
    }

    fn line(&self, line: &str) -> Result<String, String> {
        if let Some((_, head)) = HEADS.iter().find(|(english, _)| *english == line) {
            return Ok((*head).to_owned());
        }
        if let Some(title) = line.strip_prefix("### ") {
            // A title of names alone is the same in both languages.
            let names = title.split([',', ' ']).all(|word| {
                word.is_empty() || word.starts_with('(') || word.contains(char::is_uppercase)
            });
            return Ok(format!(
                "### {}",
                self.of(title).or_else(|e| if names { Ok(title) } else { Err(e) })?
            ));
        }
        if let Some(item) = line.strip_prefix("- ") {
            // The values of a placeholder are words of scenarios.
            let values = item.starts_with('`') && item.contains("`: ");
            return if values { Ok(line.to_owned()) } else { Ok(format!("- {}", self.of(item)?)) };
        }
        match line.strip_prefix("| ").and_then(|line| line.strip_suffix(" |")) {
            Some(row) if !row.starts_with("---") => self.row(row),
            _ => Ok(line.to_owned()),
        }
    }

    fn row(&self, row: &str) -> Result<String, String> {
        match row.split(" | ").collect::<Vec<_>>()[..] {
            [status, how] => Ok(format!("| {status} | {} |", self.how(how)?)),
            [flag, of, severities, how, time] => Ok(format!(
                "| {flag} | {of} | {} | {} | {} |",
                severities_of(severities)?,
                self.how(how)?,
                time_of(time)?
            )),
            _ => Err(format!("a row with other columns: `{row}`")),
        }
    }

    /// Lines of a scenario with a reason behind them, or a reason alone.
    fn how(&self, how: &str) -> Result<String, String> {
        let is_code = how.starts_with('`') || how.starts_with("**`");
        let Some((code, reason)) = how.rsplit_once(" — ").filter(|_| is_code) else {
            return if is_code { Ok(how.to_owned()) } else { self.of(how).map(str::to_owned) };
        };
        Ok(format!("{code} — {}", self.of(reason)?))
    }
}

fn severities_of(words: &str) -> Result<String, String> {
    let russian = words.split(", ").map(|word| {
        let found = SEVERITIES.iter().find(|(english, _)| *english == word);
        found.map(|(_, russian)| *russian).ok_or_else(|| format!("no severity is called `{word}`"))
    });
    Ok(russian.collect::<Result<Vec<_>, _>>()?.join(", "))
}

fn time_of(time: &str) -> Result<String, String> {
    match time {
        "at once" => Ok("сразу".into()),
        "never" => Ok("никогда".into()),
        time => match time.strip_suffix(" s") {
            Some(seconds) => Ok(format!("{} с", seconds.replace('.', ","))),
            None => Err(format!("`{time}` is not a time")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENGLISH: &str = "\
2 rows, 0 holes: 1 reached, 1 never set, by decision. 1 of those reached are warnings: 1 within 0.85 s, 0 later.

### Pumps (§2)

| flag | subsystem | severity | how | shows within |
| --- | --- | --- | --- | --- |
| `A` | General | warning, alarm | `state x`; **`inject y`** — it is slow. | 1.15 s |
| `B` | General | info | It is slow. | never |
";

    fn texts() -> Texts {
        Texts::parse("# head\n\nPumps (§2)\nНасосы (§2)\n\nit is slow.\nмедленно.\n\nIt is slow.\nМедленно.\n")
            .unwrap()
    }

    #[test]
    fn texts_are_translated_and_lines_of_scenarios_are_not() {
        let russian = translate(ENGLISH, &texts()).unwrap();
        let row = "| `A` | General | предупреждение, тревога | `state x`; **`inject y`** — медленно. | 1,15 с |\n";
        assert!(russian.contains("### Насосы (§2)\n") && russian.contains(row), "{russian}");
        assert!(russian.contains("| `B` | General | норма | Медленно. | никогда |\n"), "{russian}");
        assert!(russian.starts_with("Строк 2, ") && russian.contains("в пределах 0,85 с, 0 —"));
    }

    #[test]
    fn a_text_without_translation_is_an_error() {
        let error = translate(&ENGLISH.replace("It is slow.", "It is old."), &texts()).unwrap_err();
        assert!(error.contains("`It is old.`"), "{error}");
        assert!(translate("some rows\n", &texts()).unwrap_err().contains("eight numbers"));
        assert!(Texts::parse("one\n").is_err());
    }
}
