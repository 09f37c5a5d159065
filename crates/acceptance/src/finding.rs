//! What a check has found of a subject: a monitor, a detector, a zone.

use lafet_texts::{Shown, Text, Words, acceptance as text};
use serde::Serialize;

use crate::check::Check;

/// Verdict of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// As limited.
    Pass,
    /// Not as limited.
    Fail,
    /// Not tried; the finding says why.
    NotTried,
}

impl Verdict {
    /// Its name in the record.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::NotTried => "not_tried",
        }
    }
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The check.
    pub check: &'static Check,
    /// Of what: an id of the hub; empty: the site.
    pub subject: String,
    /// The verdict.
    pub verdict: Verdict,
    /// What it has to be.
    pub limit: Option<Words>,
    /// What it is.
    pub measured: Option<Words>,
    /// Why it was not tried.
    pub why: Option<Words>,
}

/// The findings of a run.
#[derive(Clone, Debug, Default)]
pub struct Findings(pub Vec<Finding>);

impl Findings {
    /// Notes what was measured.
    pub fn tried(
        &mut self,
        check: &'static Check,
        subject: &str,
        good: bool,
        limit: impl Text,
        measured: impl Text,
    ) {
        self.0.push(Finding {
            check,
            subject: subject.to_owned(),
            verdict: if good { Verdict::Pass } else { Verdict::Fail },
            limit: Some(limit.words()),
            measured: Some(measured.words()),
            why: None,
        });
    }

    /// Notes that it was not tried.
    pub fn not_tried(&mut self, check: &'static Check, subject: &str, why: impl Text) {
        self.0.push(Finding {
            check,
            subject: subject.to_owned(),
            verdict: Verdict::NotTried,
            limit: None,
            measured: None,
            why: Some(why.words()),
        });
    }

    /// Compares with the plan: what it leaves out is not tried.
    pub fn planned<T: PartialEq>(
        &mut self,
        check: &'static Check,
        subject: &str,
        plan: Option<&T>,
        found: &T,
        shown: impl Fn(&T) -> String,
    ) {
        match plan {
            None => self.not_tried(check, subject, text::NotPlanned),
            Some(plan) => {
                let (limit, measured) = (Shown(shown(plan)), Shown(shown(found)));
                self.tried(check, subject, plan == found, limit, measured);
            }
        }
    }

    /// How many have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.0.iter().filter(|it| it.verdict == verdict).count()
    }

    /// What was not as limited.
    pub fn failed(&self) -> impl Iterator<Item = &Finding> {
        self.0.iter().filter(|it| it.verdict == Verdict::Fail)
    }
}
