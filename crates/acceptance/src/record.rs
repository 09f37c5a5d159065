//! The acceptance record: what was tried with what result, in both languages, as JSON of a versioned schema
//! (docs/schema/site-test-1.json).

use lafet_texts::Words;
use serde::Serialize;
use sha2::{Digest, Sha256};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::check::{self, Stage};
use crate::finding::Verdict;
use crate::run::{Answered, Did, Outcome};
use crate::sign::digits;

/// Name and version of the schema.
pub const SCHEMA: &str = "lafet-site-test/1";

/// Where and when a run took place.
#[derive(Clone, Debug, Default)]
pub struct Occasion {
    /// URL of the hub.
    pub hub: String,
    /// When it began, ms since 1970.
    pub began_ms: u64,
    /// Who tested; empty: not said.
    pub by: String,
    /// The plan as it was read.
    pub plan: Vec<u8>,
    /// Version of the tester.
    pub version: String,
}

/// The record.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Name of the site.
    pub site: String,
    /// URL of the hub.
    pub hub: String,
    /// Version of the hub.
    pub hub_version: String,
    /// Version of the tester.
    pub version: String,
    /// Monitors were simulated: no acceptance of a real site.
    pub simulation: bool,
    /// When it began, UTC.
    pub began: String,
    /// It lasted so long, ms.
    pub took_ms: u64,
    /// Who tested.
    pub by: String,
    /// SHA-256 of the plan.
    pub plan_sha256: String,
    /// Steps that were asked for.
    pub stages: Vec<&'static str>,
    /// How many results have each verdict.
    pub counts: Counts,
    /// Why it ended early.
    pub ended: Option<Words>,
    /// What could not be put back.
    pub left: Vec<Words>,
    /// The results.
    pub results: Vec<Row>,
    /// Questions and answers.
    pub answers: Vec<Answered>,
    /// What was ordered that moves.
    pub ordered: Vec<Did>,
}

/// Counts of verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// As limited.
    pub pass: usize,
    /// Not as limited.
    pub fail: usize,
    /// Not tried.
    pub not_tried: usize,
}

/// A result.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Id of the check.
    pub check: &'static str,
    /// Its step.
    pub stage: &'static str,
    /// Of what; empty: the site.
    pub subject: String,
    /// What is checked.
    pub title: Words,
    /// Its requirement; none: ours.
    pub requirement: Option<&'static str>,
    /// Where that was found; none: ours.
    pub source: Option<&'static str>,
    /// The verdict.
    pub verdict: Verdict,
    /// What it has to be.
    pub limit: Option<Words>,
    /// What it is.
    pub measured: Option<Words>,
    /// Why it was not tried.
    pub why: Option<Words>,
}

impl Record {
    /// The record of a run.
    pub fn new(site: &str, occasion: &Occasion, stages: &[Stage], outcome: Outcome) -> Self {
        let findings = outcome.findings;
        let count = |verdict| findings.count(verdict);
        let counts = Counts {
            pass: count(Verdict::Pass),
            fail: count(Verdict::Fail),
            not_tried: count(Verdict::NotTried),
        };
        let some = |text: &'static str| Some(text).filter(|it| !it.is_empty());
        let results = findings.0.into_iter().map(|it| Row {
            check: it.check.id,
            stage: it.check.stage.name(),
            subject: it.subject,
            title: Words::each(|lang| it.check.title.str(lang).to_owned()),
            requirement: some(it.check.requirement),
            source: some(it.check.source),
            verdict: it.verdict,
            limit: it.limit,
            measured: it.measured,
            why: it.why,
        });
        Self {
            schema: SCHEMA,
            site: site.to_owned(),
            hub: occasion.hub.clone(),
            hub_version: outcome.version,
            version: occasion.version.clone(),
            simulation: outcome.simulation,
            began: date(occasion.began_ms),
            took_ms: outcome.took_ms,
            by: occasion.by.clone(),
            plan_sha256: sha256(&occasion.plan),
            stages: stages.iter().map(|it| it.name()).collect(),
            counts,
            ended: outcome.ended.map(|it| it.words()),
            left: outcome.left,
            results: results.collect(),
            answers: outcome.answers,
            ordered: outcome.did,
        }
    }

    /// As JSON, to be kept: what is signed are these bytes.
    pub fn json(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }

    /// Nothing has failed, was left or ended early.
    pub fn is_good(&self) -> bool {
        self.counts.fail == 0 && self.left.is_empty() && self.ended.is_none()
    }
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    digits(&Sha256::digest(bytes))
}

/// A date in UTC, to the second.
pub fn date(ms: u64) -> String {
    let seconds = i64::try_from(ms / 1000).unwrap_or(0);
    let date = OffsetDateTime::from_unix_timestamp(seconds).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    date.format(&Rfc3339).unwrap_or_default()
}

/// The checks as they are listed in the documentation: id, step, requirement, source.
pub fn table() -> impl Iterator<Item = (&'static str, &'static str, &'static str, &'static str)> {
    check::ALL.iter().map(|it| (it.id, it.stage.name(), it.requirement, it.source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_digests_are_as_others_write_them() {
        assert_eq!(date(1_763_712_000_999), "2025-11-21T08:00:00Z");
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(sha256(b""), empty);
    }
}
