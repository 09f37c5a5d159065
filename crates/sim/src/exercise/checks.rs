//! Expectations, looked at as time goes on.

use lafet_texts::{Text as _, Words, sim as text};

use super::director::Director;
use super::plan::{Exercise, Expectation, Moment, Rule};

/// What became of an expectation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// Line of the file.
    pub line: usize,
    /// It is the answer to a request of the operator's.
    pub is_answer: bool,
    /// What was expected.
    pub text: Words,
    /// Whether it is so.
    pub passed: bool,
    /// When that was clear, ms.
    pub at_ms: u64,
    /// What there was instead, or what made it so.
    pub came: Words,
}

/// The expectations of a run.
#[derive(Clone, Debug)]
pub struct Checks {
    /// Those that are decided, in the order of the file.
    decided: Vec<Option<Check>>,
    /// A rule with a beginning has started.
    begun: Vec<bool>,
}

enum Verdict {
    Open,
    Passed(Words),
    Failed(Words),
}

impl Checks {
    /// Nothing is decided.
    pub fn new(exercise: &Exercise) -> Self {
        let count = exercise.expectations.len();
        Self { decided: vec![None; count], begun: vec![false; count] }
    }

    /// Looks at everything that is not decided.
    pub fn look(&mut self, director: &mut Director, at_end: bool) {
        let exercise = director.exercise().clone();
        for (index, expectation) in exercise.expectations.iter().enumerate() {
            if self.decided[index].is_some() {
                continue;
            }
            let verdict = self.judge(index, expectation, director, at_end);
            let (passed, came) = match verdict {
                Verdict::Open => continue,
                Verdict::Passed(came) => (true, came),
                Verdict::Failed(came) => (false, came),
            };
            self.decided[index] = Some(Check {
                line: expectation.line,
                is_answer: false,
                text: expectation.text.clone(),
                passed,
                at_ms: director.now_ms(),
                came,
            });
        }
    }

    /// What became of each so far, in the order of the file.
    pub fn decided(&self) -> &[Option<Check>] {
        &self.decided
    }

    /// What became of all.
    pub fn finish(self) -> Vec<Check> {
        self.decided.into_iter().flatten().collect()
    }

    fn judge(
        &mut self,
        index: usize,
        expectation: &Expectation,
        director: &mut Director,
        at_end: bool,
    ) -> Verdict {
        let now_ms = director.now_ms();
        let moment = |moment: Moment| match moment {
            Moment::At(ms) => Some(ms),
            Moment::Mark(mark) => director.passed(mark),
        };
        let passed =
            |at: Option<Moment>| at.is_some_and(|at| moment(at).is_some_and(|ms| now_ms >= ms));
        match expectation.rule {
            Rule::End if at_end => holds(expectation, director),
            Rule::At(at) if passed(Some(at)) => holds(expectation, director),
            Rule::End | Rule::At(_) if at_end => Verdict::Failed(never_came()),
            Rule::End | Rule::At(_) => Verdict::Open,
            Rule::By { after, within_ms, by } => {
                let from_ms = after.map_or(Some(0), moment).filter(|from_ms| now_ms >= *from_ms);
                let Some(from_ms) = from_ms else {
                    return if at_end { Verdict::Failed(never_came()) } else { Verdict::Open };
                };
                let within = within_ms.is_some_and(|ms| now_ms > from_ms + ms);
                let late = by.is_some_and(|by| moment(by).is_some_and(|ms| now_ms > ms));
                match holds(expectation, director) {
                    Verdict::Failed(came) if within || late || at_end => Verdict::Failed(came),
                    Verdict::Failed(_) => Verdict::Open,
                    _ if within || late => Verdict::Failed(text::TooLate.words()),
                    verdict => verdict,
                }
            }
            Rule::Always(from, until) | Rule::Never(from, until) => {
                let is_on = from.is_none() || passed(from);
                if passed(until) && !self.begun[index] && is_on {
                    return Verdict::Failed(never_came());
                }
                if is_on && !passed(until) {
                    self.begun[index] = true;
                    let never = matches!(expectation.rule, Rule::Never(..));
                    match (holds(expectation, director), never) {
                        (Verdict::Passed(came), true) => return Verdict::Failed(came),
                        (Verdict::Failed(came), false) => return Verdict::Failed(came),
                        _ => {}
                    }
                }
                match (at_end, self.begun[index]) {
                    (false, _) => Verdict::Open,
                    (true, true) => Verdict::Passed(Words::default()),
                    (true, false) => Verdict::Failed(never_came()),
                }
            }
        }
    }
}

fn holds(expectation: &Expectation, director: &mut Director) -> Verdict {
    match expectation.that.holds(&mut director.site) {
        Ok((true, came)) => Verdict::Passed(came),
        Ok((false, came)) => Verdict::Failed(came),
        Err(error) => Verdict::Failed(error),
    }
}

fn never_came() -> Words {
    text::NeverCame.words()
}
