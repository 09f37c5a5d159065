//! The person at the terminal: questions, answers, and `q` or Ctrl-C at any moment.

use std::collections::VecDeque;
use std::io::IsTerminal;
use std::rc::Rc;
use std::time::Duration;

use lafet_acceptance::{Answer, Asks, Person, Question};
use lafet_texts::{Text as _, Words, cli as text};
use tokio::sync::{Mutex, mpsc};
use tokio::time::{Instant, timeout};

use super::Answers;
use crate::failure::Failure;
use crate::input;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;

/// What comes from the keyboard.
pub struct Console {
    interrupt: Interrupt,
    /// `None`: there is no terminal, and no person to ask.
    lines: Option<mpsc::UnboundedReceiver<String>>,
    /// What was typed while the hub was asked, and when: it may be the answer to the question that waits.
    typed: VecDeque<(Instant, String)>,
    /// The person has stopped the test.
    stopped: bool,
    /// When a signal was last caught.
    since: Option<Instant>,
    /// Ctrl-Z is caught and does nothing: a test that is stopped so would leave what it has started.
    #[cfg(unix)]
    _frozen: tokio::signal::unix::Signal,
}

/// Most lines that are kept while the hub is asked.
const TYPED: usize = 8;

/// A line that is there so soon after a question was typed before it: a key was pressed twice.
const TOO_SOON: Duration = Duration::from_millis(300);

/// Shared by who asks and who waits, one at a time.
pub type Shared = Rc<Mutex<Console>>;

impl Console {
    /// Listens to the keyboard, if there is one.
    pub fn listen() -> Result<Shared, Failure> {
        #[cfg(unix)]
        let frozen = {
            use tokio::signal::unix::{SignalKind, signal};
            let kind = SignalKind::from_raw(rustix::process::Signal::TSTP.as_raw());
            let what = || text::CannotCatchSignals.str(current());
            signal(kind).map_err(|error| Failure::io(what(), error))?
        };
        let lines = std::io::stdin().is_terminal().then(input::lines);
        Ok(Rc::new(Mutex::new(Self {
            interrupt: Interrupt::catch()?,
            lines,
            typed: VecDeque::new(),
            stopped: false,
            since: None,
            #[cfg(unix)]
            _frozen: frozen,
        })))
    }

    /// Waits until the person stops the test: by `q` and Enter, or a signal.
    pub async fn stopped(&mut self) {
        while !self.stopped {
            match self.next().await {
                Some(line) if !is_stop(&line) => {
                    self.typed.truncate(TYPED - 1);
                    self.typed.push_back((Instant::now(), line));
                }
                _ => self.stopped = true,
            }
        }
    }

    /// What was typed before a question is no answer to it.
    fn forget(&mut self) {
        self.typed.clear();
        let Some(lines) = &mut self.lines else { return };
        while let Ok(line) = lines.try_recv() {
            self.stopped |= is_stop(&line);
        }
    }

    /// The next line and when it was typed; `None` after a signal, and at the end of the terminal.
    async fn line(&mut self) -> Option<(Instant, String)> {
        match self.typed.pop_front() {
            Some(typed) => Some(typed),
            None => self.next().await.map(|line| (Instant::now(), line)),
        }
    }

    async fn next(&mut self) -> Option<String> {
        let line = async {
            match &mut self.lines {
                Some(lines) => lines.recv().await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.next() => {
                self.since = Some(Instant::now());
                None
            }
            line = line => line,
        }
    }

    /// Waits for a Ctrl-C that is meant to give up what is being ended.
    pub async fn gives_up(&mut self) {
        self.interrupt.give_up(self.since).await;
    }
}

fn is_stop(line: &str) -> bool {
    matches!(line.trim().to_lowercase().as_str(), "q" | "quit" | "стоп" | "stop" | "й")
}

/// The person at the terminal, and a file of answers.
pub struct AtTerminal {
    pub console: Shared,
    pub answers: Answers,
    /// Standard error, for which nothing waits: a terminal that is held still holds up no Stop.
    pub screen: Out,
    /// When the last question was asked.
    pub asked: Instant,
}

impl AtTerminal {
    fn put(&mut self, question: &Question) {
        let lang = current();
        let line = format!("\n{} {}", question.text.of(lang), hint(&question.asks));
        self.screen.warn(&line);
    }
}

impl Person for AtTerminal {
    fn hear(&mut self, what: &Words) {
        self.screen.warn(what.of(current()));
    }

    fn ask(&mut self, question: &Question) {
        let lang = current();
        if let Some(answer) = self.answers.to(question) {
            let (question, answer) = (question.text.of(lang), shown(&answer));
            self.screen.warn(&text::SiteAnswered { question, answer }.of(lang));
            return;
        }
        let asked = match self.console.try_lock() {
            Ok(mut console) => {
                console.forget();
                console.lines.is_some()
            }
            Err(_) => false,
        };
        self.asked = Instant::now();
        if asked {
            self.put(question);
        }
    }

    async fn answer(&mut self, question: &Question, ms: u64) -> Option<Answer> {
        if let Some(answer) = self.answers.to(question) {
            return Some(answer);
        }
        let line = {
            let mut console = self.console.lock().await;
            if console.stopped {
                return Some(Answer::Stop);
            }
            if console.lines.is_none() {
                return Some(Answer::Skip);
            }
            timeout(Duration::from_millis(ms), console.line()).await
        };
        let Ok(line) = line else { return None };
        let Some((at, line)) = line.filter(|(_, line)| !is_stop(line)) else {
            return Some(Answer::Stop);
        };
        let soon = at.saturating_duration_since(self.asked) < TOO_SOON;
        let answer = read(&line, &question.asks).filter(|_| !soon);
        if answer.is_none() {
            self.put(question);
        }
        answer
    }
}

fn hint(asks: &Asks) -> String {
    let lang = current();
    match asks {
        Asks::Go => text::SiteHintYesNo.str(lang).to_owned(),
        Asks::Degrees => text::SiteHintDegrees.str(lang).to_owned(),
        Asks::Pressure => text::SiteHintPressure.str(lang).to_owned(),
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
        Asks::Go if yes => Some(Answer::Yes),
        Asks::Go | Asks::Name(_) if no => Some(Answer::No),
        Asks::Degrees | Asks::Pressure => {
            let value: f64 = line.replace(',', ".").parse().ok()?;
            value.is_finite().then_some(Answer::Number(value))
        }
        Asks::Name(names) => {
            let named = names.iter().find(|it| it.to_lowercase() == word)?;
            Some(Answer::Name(named.clone()))
        }
        Asks::Go => None,
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
    fn answers_are_read_in_both_languages() {
        let names = Asks::Name(vec!["M1".into()]);
        for (line, asks, answer) in [
            ("y", Asks::Go, Some(Answer::Yes)),
            (" ДА ", Asks::Go, Some(Answer::Yes)),
            ("нет", Asks::Go, Some(Answer::No)),
            ("", Asks::Go, None),
            ("-0,5", Asks::Degrees, Some(Answer::Number(-0.5))),
            ("NaN", Asks::Degrees, None),
            ("much", Asks::Degrees, None),
            ("82,5", Asks::Pressure, Some(Answer::Number(82.5))),
            ("m1", names.clone(), Some(Answer::Name("M1".into()))),
            ("n", names.clone(), Some(Answer::No)),
            ("M2", names, None),
            ("s", Asks::Go, Some(Answer::Skip)),
        ] {
            assert_eq!(read(line, &asks), answer, "{line:?} {asks:?}");
        }
        assert!(is_stop(" Q ") && is_stop("стоп") && !is_stop(""));
    }
}
