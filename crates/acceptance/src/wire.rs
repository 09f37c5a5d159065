//! The two sides of a run: the hub and the person beside the installation.

use std::future::Future;

use lafet_texts::{Text as _, Words, acceptance as text};
use serde_json::Value;

use crate::order::Posting;

/// Why the hub has not done what it was asked.
#[derive(Clone, Debug, PartialEq)]
pub enum Failed {
    /// It refuses, and nothing has happened.
    Refused {
        /// `code` of its answer.
        code: String,
        /// Why, in words.
        text: Words,
    },
    /// It was not reached, or what it answers cannot be read: what it was asked may have happened.
    Lost(Words),
    /// The person has stopped the run before the answer was there: what it was asked may have happened.
    Stopped,
}

impl Failed {
    /// In words.
    pub fn words(&self) -> Words {
        match self {
            Self::Refused { text, .. } | Self::Lost(text) => text.clone(),
            Self::Stopped => text::EndStopped.words(),
        }
    }
}

/// The person has stopped the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// The hub, and the time.
pub trait Wire {
    /// The answer to a GET. A stop of the person is not kept waiting for it.
    fn get(&mut self, path: &str) -> impl Future<Output = Result<Value, Failed>>;

    /// From now on what was started is being ended: no stop cuts a request short.
    fn ends(&mut self);

    /// Sends an order. A stop of the person is not kept waiting for its answer.
    fn post(&mut self, posting: &Posting) -> impl Future<Output = Result<Value, Failed>>;

    /// Lets time pass; ends as soon as the person stops the run.
    fn pause(&mut self, ms: u64) -> impl Future<Output = Result<(), Stopped>>;

    /// Lets time pass: what was started is being ended. Ends early if the person gives that up.
    fn settle(&mut self, ms: u64) -> impl Future<Output = Result<(), Stopped>>;

    /// A steady time, ms.
    fn now_ms(&self) -> u64;

    /// The date of this computer, ms since 1970; `None`: the hub has the same clock.
    fn date_ms(&self) -> Option<u64>;
}

/// What a person is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Its id in a file of answers: `dry/M1/heading`.
    pub id: String,
    /// What is asked.
    pub text: Words,
    /// What answers are possible.
    pub asks: Asks,
}

/// What answers are possible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asks {
    /// Whether something may move, or was done, or is so. Only a yes begins what hangs on it.
    Go,
    /// A number of degrees.
    Degrees,
    /// A pressure, 0.1 atm.
    Pressure,
    /// One of these names, or none of them.
    Name(Vec<String>),
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Yes.
    Yes,
    /// No; none of the names.
    No,
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// There is no answer: what hangs on it is not tried.
    Skip,
    /// The run is to end.
    Stop,
}

/// The person beside the installation.
pub trait Person {
    /// Hears what is about to happen, or what has.
    fn hear(&mut self, what: &Words);

    /// Is asked. [`Person::answer`] has what comes of it.
    fn ask(&mut self, question: &Question);

    /// The answer to the question that was asked last, if it comes within so many ms.
    fn answer(&mut self, question: &Question, ms: u64) -> impl Future<Output = Option<Answer>>;
}
