//! Questions. While a monitor is held, or a test outlet is tried, the site is looked at until the answer is there, and
//! each wait has an end.

use lafet_texts::Words;

use super::{Answered, End, Run, Step};
use crate::wire::{Answer, Asks, Person, Question, Wire};

/// Between two looks while a person thinks, ms.
const THINK_MS: u64 = 200;
/// An answer is waited for so long, ms: with nothing started, while a monitor is held, and while a zone is tried.
const AT_REST_MS: u64 = 1_800_000;
const HELD_MS: u64 = 300_000;
const TRIAL_MS: u64 = 600_000;

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Asks, and notes the answer. Without one in time it is [`Answer::Skip`].
    pub(super) async fn ask(&mut self, id: String, words: Words, asks: Asks) -> Step<Answer> {
        let question = Question { id, text: words, asks };
        self.person.ask(&question);
        let start = self.wire.now_ms();
        let answer = loop {
            let answer = self.person.answer(&question, THINK_MS).await;
            if answer == Some(Answer::Stop) {
                return Err(End::Stopped);
            }
            if self.held.is_some() {
                // What was answered counts for the site as it is now.
                self.look().await?;
            } else if self.trial.is_some() {
                self.watch().await?;
            }
            if let Some(answer) = answer {
                break answer;
            }
            let most_ms = match (&self.held, &self.trial) {
                (Some(_), _) => HELD_MS,
                (None, Some(_)) => TRIAL_MS,
                (None, None) => AT_REST_MS,
            };
            if self.wire.now_ms().saturating_sub(start) >= most_ms {
                break Answer::Skip;
            }
        };
        let noted = match &answer {
            Answer::Yes => Some("yes".to_owned()),
            Answer::No => Some("no".to_owned()),
            Answer::Number(value) => Some(value.to_string()),
            Answer::Name(name) => Some(name.clone()),
            Answer::Skip | Answer::Stop => None,
        };
        let Question { id, text, .. } = question;
        self.out.answers.push(Answered { question: id, text, answer: noted });
        Ok(answer)
    }

    /// Whether the person says yes.
    pub(super) async fn agrees(&mut self, id: String, words: Words) -> Step<bool> {
        Ok(self.ask(id, words, Asks::Go).await? == Answer::Yes)
    }
}
