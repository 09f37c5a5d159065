//! A file that allows motions in tests that are repeated: `"dry/M1/go" = true`. TOML.

use std::collections::BTreeMap;

use lafet_acceptance::{Answer, Asks, Question};
use serde::Deserialize;

/// The answers, by the id of the question; `*` is any part of it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Answers(BTreeMap<String, bool>);

impl Answers {
    /// The answer to a question, if there is one that fits it: whether a monitor may turn, and no more, for all else
    /// is true of the moment at which it is asked. A no wins.
    pub fn to(&self, question: &Question) -> Option<Answer> {
        if question.asks != Asks::Go || !fits("dry/*/go", &question.id) {
            return None;
        }
        let fitting = self.0.iter().filter(|(pattern, _)| fits(pattern, &question.id));
        let yes = fitting.map(|(_, yes)| *yes).reduce(|one, other| one && other)?;
        Some(if yes { Answer::Yes } else { Answer::No })
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
    fn a_file_allows_the_motion_of_a_monitor_and_nothing_else() {
        let text = "\"*/*/*\" = true\n\"dry/M2/go\" = false\n";
        let answers: Answers = toml::from_str(text).unwrap();
        assert_eq!(to(&answers, "dry/M1/go", Asks::Go), Some(Answer::Yes));
        assert_eq!(to(&answers, "dry/M2/go", Asks::Go), Some(Answer::No), "a no wins");
        for (id, asks) in [
            ("dry/M1/back", Asks::Go),
            ("dry/M1/heading", Asks::Degrees),
            ("dry/M1/which", Asks::Name(vec!["M1".into()])),
            ("outlet/hall/go", Asks::Go),
            ("outlet/hall/votes", Asks::Go),
        ] {
            assert_eq!(to(&answers, id, asks), None, "{id}");
        }
        assert_eq!(to(&Answers::default(), "dry/M1/go", Asks::Go), None);
        assert!(toml::from_str::<Answers>("\"a\" = 1").is_err());
    }
}
