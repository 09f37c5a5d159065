//! The two sides of a run: the hub and the person beside the installation.

use std::future::Future;

use lafet_texts::Words;
use serde_json::Value;

use crate::order::Posting;

/// Why the hub has not done what it was asked.
#[derive(Clone, Debug, PartialEq)]
pub enum Failed {
    /// It refuses.
    Refused {
        /// `code` of its answer.
        code: String,
        /// Why, in words.
        text: Words,
    },
    /// It was not reached, or what it answers cannot be read.
    Lost(Words),
}

impl Failed {
    /// In words.
    pub const fn words(&self) -> &Words {
        match self {
            Self::Refused { text, .. } | Self::Lost(text) => text,
        }
    }
}

/// The person has stopped the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// The hub, and the time.
pub trait Wire {
    /// The answer to a GET.
    fn get(&mut self, path: &str) -> impl Future<Output = Result<Value, Failed>>;

    /// Sends an order.
    fn post(&mut self, posting: &Posting) -> impl Future<Output = Result<Value, Failed>>;

    /// Lets time pass; ends as soon as the person stops the run.
    fn pause(&mut self, ms: u64) -> impl Future<Output = Result<(), Stopped>>;

    /// Lets time pass whatever the person does: what was started is being ended.
    fn settle(&mut self, ms: u64) -> impl Future<Output = ()>;

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
    /// Whether a step may begin. Only a yes begins it.
    Go,
    /// The same for water: the answer has to come from a person at this moment, never from a file.
    Water,
    /// To do something now; yes: it is being done.
    Act,
    /// Yes or no.
    YesNo,
    /// A number of degrees.
    Degrees,
    /// One of these names, or none of them.
    Name(Vec<String>),
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Yes; it is done.
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

    /// Answers.
    fn answer(&mut self, question: &Question) -> impl Future<Output = Answer>;
}
