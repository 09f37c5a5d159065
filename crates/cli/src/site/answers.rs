//! Answers of a file, for tests that are repeated: `"dry/M1/go" = true`, `"dry/*/heading" = 0.2`. TOML.

use std::collections::BTreeMap;

use lafet_acceptance::{Answer, Asks, Question};
use serde::Deserialize;

/// An answer as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "true, false, a number or a name")]
enum Written {
    Yes(bool),
    Number(f64),
    Name(String),
}

/// The answers, by the id of the question; `*` is any part of it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Answers(BTreeMap<String, Written>);

impl Answers {
    /// The answer to a question, if there is one that fits it. That to water never comes from a file.
    pub fn to(&self, question: &Question) -> Option<Answer> {
        let fits = |(pattern, _): &(&String, &Written)| fits(pattern, &question.id);
        let written =
            self.0.get(&question.id).or_else(|| self.0.iter().find(fits).map(|it| it.1))?;
        match (&question.asks, written) {
            (Asks::Water, _) => None,
            (Asks::Go | Asks::Act | Asks::YesNo, Written::Yes(true)) => Some(Answer::Yes),
            (Asks::Go | Asks::Act | Asks::YesNo | Asks::Name(_), Written::Yes(false)) => {
                Some(Answer::No)
            }
            (Asks::Degrees, Written::Number(value)) => Some(Answer::Number(*value)),
            (Asks::Name(names), Written::Name(name)) if names.contains(name) => {
                Some(Answer::Name(name.clone()))
            }
            _ => None,
        }
    }
}

fn fits(pattern: &str, id: &str) -> bool {
    let (mut pattern, mut id) = (pattern.split('/'), id.split('/'));
    loop {
        match (pattern.next(), id.next()) {
            (None, None) => return true,
            (Some(wanted), Some(part)) if wanted == "*" || wanted == part => {}
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use lafet_texts::Words;

    use super::*;

    fn to(answers: &Answers, id: &str, asks: Asks) -> Option<Answer> {
        answers.to(&Question { id: id.into(), text: Words::default(), asks })
    }

    #[test]
    fn answers_fit_by_name_and_kind_and_water_has_none() {
        let text = "\"dry/*/go\" = true\n\"dry/M2/go\" = false\n\"dry/M1/heading\" = -0.3\n\
                    \"dry/M1/which\" = \"M1\"\n\"water/M1/go\" = true\n\"*\" = true\n";
        let answers: Answers = toml::from_str(text).unwrap();
        assert_eq!(to(&answers, "dry/M1/go", Asks::Go), Some(Answer::Yes));
        assert_eq!(to(&answers, "dry/M2/go", Asks::Go), Some(Answer::No));
        assert_eq!(to(&answers, "dry/M1/heading", Asks::Degrees), Some(Answer::Number(-0.3)));
        let names = || Asks::Name(vec!["M1".into()]);
        assert_eq!(to(&answers, "dry/M1/which", names()), Some(Answer::Name("M1".into())));
        assert_eq!(to(&answers, "dry/M1/which", Asks::Name(vec!["M2".into()])), None);
        assert_eq!(to(&answers, "water/M1/go", Asks::Water), None);
        assert_eq!(to(&answers, "dry/hall/detector/heat", Asks::Act), None);
        assert!(toml::from_str::<Answers>("\"a\" = [1]").is_err());
    }
}
