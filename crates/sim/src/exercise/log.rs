//! The time line of a run: what was asked and answered, what was reported, what happened.

use lafet_device::Source;
use lafet_proto::flags::Severity;
use lafet_proto::record::Records;
use lafet_texts::{Text as _, Words, sim as text};

use crate::scenario::answers_text;

/// What a line of the time line is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something happens to the site.
    Event,
    /// A request.
    Request,
    /// An answer that agrees.
    Answer,
    /// An answer that refuses.
    Refusal,
    /// No answer came.
    NoAnswer,
    /// A flag is reported.
    Flag(Severity),
    /// It is not reported any more.
    Cleared,
    /// A fire is lit, reached, out.
    Fire,
    /// Water begins or ends, power comes and goes.
    Plant,
    /// A remark of the exercise.
    Note,
}

impl Kind {
    /// The character that marks it.
    pub const fn mark(self) -> char {
        match self {
            Self::Event => '*',
            Self::Request => '>',
            Self::Answer => '<',
            Self::Refusal | Self::NoAnswer => '!',
            Self::Flag(_) => '+',
            Self::Cleared => '-',
            Self::Fire => '#',
            Self::Plant => '~',
            Self::Note => ' ',
        }
    }

    /// Its name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Event => "event",
            Self::Request => "request",
            Self::Answer => "answer",
            Self::Refusal => "refusal",
            Self::NoAnswer => "no-answer",
            Self::Flag(_) => "flag",
            Self::Cleared => "cleared",
            Self::Fire => "fire",
            Self::Plant => "plant",
            Self::Note => "note",
        }
    }
}

/// A line of the time line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// When, ms.
    pub at_ms: u64,
    /// Which monitor; `None` is the site.
    pub monitor: Option<usize>,
    /// What it is about.
    pub kind: Kind,
    /// The text.
    pub text: Words,
}

/// Requests of a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Requests sent, polls left out.
    pub requests: u32,
    /// Answers that agree.
    pub accepted: u32,
    /// Answers that refuse.
    pub refused: u32,
    /// Requests without an answer.
    pub unanswered: u32,
}

/// The time line so far.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// All lines.
    pub lines: Vec<Line>,
    /// Requests, by monitor.
    pub counts: Vec<Counts>,
}

impl Log {
    /// Nothing has happened to so many monitors.
    pub fn new(monitors: usize) -> Self {
        Self { lines: Vec::new(), counts: vec![Counts::default(); monitors] }
    }

    /// Adds a line.
    pub fn add(&mut self, at_ms: u64, monitor: Option<usize>, kind: Kind, text: Words) {
        self.lines.push(Line { at_ms, monitor, kind, text });
    }

    /// Adds a remark.
    pub fn say(&mut self, at_ms: u64, monitor: Option<usize>, text: Words) {
        self.add(at_ms, monitor, Kind::Note, text);
    }

    /// Adds a request and its answers; the texts of the answers.
    pub fn exchange(
        &mut self,
        at_ms: u64,
        monitor: usize,
        over: Source,
        request: &str,
        payload: &[u8],
        answers: Option<&[u8]>,
    ) -> Vec<String> {
        let counts = &mut self.counts[monitor];
        counts.requests += 1;
        let line = match over {
            Source::Radio => text::RequestByRadio { request }.words(),
            Source::ExternalConn => Words::same(request),
        };
        let mut lines = vec![(Kind::Request, line)];
        let mut texts = Vec::new();
        match answers {
            None => {
                counts.unanswered += 1;
                lines.push((Kind::NoAnswer, text::NoAnswer.words()));
            }
            Some(answers) => {
                texts = answers_text(payload, answers);
                for (record, text) in Records::new(answers).flatten().zip(&texts) {
                    let success = record.status.is_success();
                    let count = if success { &mut counts.accepted } else { &mut counts.refused };
                    *count += 1;
                    let kind = if success { Kind::Answer } else { Kind::Refusal };
                    lines.push((kind, Words::same(text.clone())));
                }
            }
        }
        for (kind, text) in lines {
            self.add(at_ms, Some(monitor), kind, text);
        }
        texts
    }
}
