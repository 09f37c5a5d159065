//! The person at the terminal: questions, answers, and `q` or Ctrl-C at any moment.

use std::io::IsTerminal;
use std::rc::Rc;

use lafet_acceptance::{Answer, Asks, Person, Question};
use lafet_texts::{Text as _, Words, cli as text};
use tokio::sync::{Mutex, mpsc};

use super::Answers;
use crate::failure::Failure;
use crate::input;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::complain;

/// What comes from the keyboard.
pub struct Console {
    interrupt: Interrupt,
    /// `None`: there is no terminal, and no person to ask.
    lines: Option<mpsc::UnboundedReceiver<String>>,
}

/// Shared by who asks and who waits, one at a time.
pub type Shared = Rc<Mutex<Console>>;

impl Console {
    /// Listens to the keyboard, if there is one.
    pub fn listen() -> Result<Shared, Failure> {
        let lines = std::io::stdin().is_terminal().then(input::lines);
        Ok(Rc::new(Mutex::new(Self { interrupt: Interrupt::catch()?, lines })))
    }

    /// Waits until the person stops the test: by `q` and Enter, or a signal.
    pub async fn stopped(&mut self) {
        loop {
            let Some(line) = self.line().await else { return };
            if is_stop(&line) {
                return;
            }
        }
    }

    /// The next line; `None` after a signal.
    async fn line(&mut self) -> Option<String> {
        let line = async {
            match &mut self.lines {
                Some(lines) => match lines.recv().await {
                    Some(line) => line,
                    None => std::future::pending().await,
                },
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.next() => None,
            line = line => Some(line),
        }
    }
}

fn is_stop(line: &str) -> bool {
    matches!(line.trim().to_lowercase().as_str(), "q" | "quit" | "стоп" | "stop" | "й")
}

/// The person at the terminal, and a file of answers.
pub struct AtTerminal {
    pub console: Shared,
    pub answers: Answers,
    /// Nothing is said: the output is for a program.
    pub silent: bool,
}

impl AtTerminal {
    fn say(&self, line: &str) {
        if !self.silent {
            complain(line);
        }
    }
}

impl Person for AtTerminal {
    fn hear(&mut self, what: &Words) {
        self.say(what.of(current()));
    }

    async fn answer(&mut self, question: &Question) -> Answer {
        let lang = current();
        if let Some(answer) = self.answers.to(question) {
            let shown = shown(&answer);
            self.say(
                &text::SiteAnswered { question: question.text.of(lang), answer: &shown }.of(lang),
            );
            return answer;
        }
        let mut console = self.console.lock().await;
        if console.lines.is_none() {
            return Answer::Skip;
        }
        loop {
            let hint = hint(&question.asks);
            // Asked even with --json: without the question there is no answer.
            complain(format_args!("\n{} {hint}", question.text.of(lang)));
            let Some(line) = console.line().await else { return Answer::Stop };
            if is_stop(&line) {
                return Answer::Stop;
            }
            if let Some(answer) = read(&line, &question.asks) {
                return answer;
            }
        }
    }
}

fn hint(asks: &Asks) -> String {
    let lang = current();
    match asks {
        Asks::Go | Asks::YesNo => text::SiteHintYesNo.str(lang).to_owned(),
        Asks::Water => text::SiteHintWater.str(lang).to_owned(),
        Asks::Act => text::SiteHintAct.str(lang).to_owned(),
        Asks::Degrees => text::SiteHintDegrees.str(lang).to_owned(),
        Asks::Name(names) => text::SiteHintName { names: names.join(", ") }.of(lang),
    }
}

/// The answer in a line; `None`: it is none.
fn read(line: &str, asks: &Asks) -> Option<Answer> {
    let line = line.trim();
    let word = line.to_lowercase();
    if matches!(word.as_str(), "s" | "skip" | "пропустить" | "п") {
        return Some(Answer::Skip);
    }
    let yes = matches!(word.as_str(), "y" | "yes" | "да" | "д");
    let no = matches!(word.as_str(), "n" | "no" | "нет" | "н");
    match asks {
        Asks::Go | Asks::YesNo if yes => Some(Answer::Yes),
        Asks::Go | Asks::YesNo | Asks::Water | Asks::Name(_) if no => Some(Answer::No),
        // A whole word, so that no slip of a finger opens a valve.
        Asks::Water if matches!(word.as_str(), "water" | "вода") => Some(Answer::Yes),
        Asks::Act if line.is_empty() || yes => Some(Answer::Yes),
        Asks::Act if no => Some(Answer::Skip),
        Asks::Degrees => {
            let value: f64 = line.replace(',', ".").parse().ok()?;
            value.is_finite().then_some(Answer::Number(value))
        }
        Asks::Name(names) => {
            let named = names.iter().find(|it| it.to_lowercase() == word)?;
            Some(Answer::Name(named.clone()))
        }
        _ => None,
    }
}

fn shown(answer: &Answer) -> String {
    match answer {
        Answer::Yes => "yes".into(),
        Answer::No => "no".into(),
        Answer::Number(value) => value.to_string(),
        Answer::Name(name) => name.clone(),
        Answer::Skip | Answer::Stop => "–".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read_in_both_languages_and_water_needs_its_word() {
        let names = Asks::Name(vec!["M1".into()]);
        for (line, asks, answer) in [
            ("y", Asks::Go, Some(Answer::Yes)),
            (" ДА ", Asks::Go, Some(Answer::Yes)),
            ("нет", Asks::YesNo, Some(Answer::No)),
            ("", Asks::Go, None),
            ("", Asks::Act, Some(Answer::Yes)),
            ("y", Asks::Water, None),
            ("", Asks::Water, None),
            ("water", Asks::Water, Some(Answer::Yes)),
            ("вода", Asks::Water, Some(Answer::Yes)),
            ("-0,5", Asks::Degrees, Some(Answer::Number(-0.5))),
            ("NaN", Asks::Degrees, None),
            ("much", Asks::Degrees, None),
            ("m1", names.clone(), Some(Answer::Name("M1".into()))),
            ("n", names.clone(), Some(Answer::No)),
            ("M2", names, None),
            ("s", Asks::Water, Some(Answer::Skip)),
        ] {
            assert_eq!(read(line, &asks), answer, "{line:?} {asks:?}");
        }
        assert!(is_stop(" Q ") && is_stop("стоп") && !is_stop(""));
    }
}
