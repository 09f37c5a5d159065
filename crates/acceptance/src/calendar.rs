//! The calendar of the tests: how often the plan wants each step, and when each was last tried.

use serde::Deserialize;
use serde_json::Value;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::check::Stage;
use crate::plan::Plan;
use crate::record::SCHEMA;

/// A day, ms.
const DAY_MS: u64 = 86_400_000;

/// A record that was kept, as far as the calendar needs it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Kept {
    schema: String,
    /// Name of the site.
    pub site: String,
    /// When it began, UTC.
    pub began: String,
    /// Steps that were asked for.
    pub stages: Vec<String>,
    results: Vec<Result>,
    ended: Option<Value>,
    left: Vec<Value>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Result {
    stage: String,
    verdict: String,
}

impl Kept {
    /// Out of the JSON of a record; `None`: it is none, or of another version.
    pub fn read(json: &[u8]) -> Option<Self> {
        let kept: Self = serde_json::from_slice(json).ok()?;
        (kept.schema == SCHEMA && kept.began_ms().is_some()).then_some(kept)
    }

    /// When it began, ms since 1970.
    pub fn began_ms(&self) -> Option<u64> {
        let date = OffsetDateTime::parse(&self.began, &Rfc3339).ok()?;
        u64::try_from(date.unix_timestamp()).ok()?.checked_mul(1000)
    }

    /// How many results of a step have this verdict; without a step, of all.
    pub fn count(&self, stage: Option<Stage>, verdict: &str) -> usize {
        let of = |it: &&Result| {
            stage.is_none_or(|stage| it.stage == stage.name()) && it.verdict == verdict
        };
        self.results.iter().filter(of).count()
    }

    /// A step was tried.
    fn has_tried(&self, stage: Stage) -> bool {
        self.stages.iter().any(|it| it == stage.name())
            && self.count(Some(stage), "pass") + self.count(Some(stage), "fail") > 0
    }

    /// It went to its end, and nothing was left.
    pub fn is_whole(&self) -> bool {
        self.ended.is_none() && self.left.is_empty()
    }

    fn is_good(&self, stage: Stage) -> bool {
        self.is_whole() && self.count(Some(stage), "fail") == 0
    }
}

/// A step in the calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Due {
    /// The step.
    pub stage: Stage,
    /// It is wanted every so many days.
    pub every_days: u32,
    /// When it was last tried, ms since 1970, and whether it was good.
    pub last: Option<(u64, bool)>,
    /// When it is due, ms since 1970; none: now, it was never tried.
    pub next_ms: Option<u64>,
    /// It is due.
    pub overdue: bool,
}

impl Due {
    /// It is not due, and was good.
    pub fn is_good(&self) -> bool {
        !self.overdue && self.last.is_some_and(|(_, good)| good)
    }
}

/// The steps that the plan wants, with what was kept of its site.
pub fn of(plan: &Plan, kept: &[Kept], now_ms: u64) -> Vec<Due> {
    let wanted = Stage::ALL.into_iter().filter_map(|stage| Some((stage, plan.every(stage)?)));
    let due = |(stage, every_days): (Stage, u32)| {
        let of = kept.iter().filter(|it| it.site == plan.name && it.has_tried(stage));
        // A record of the future is one of a wrong clock.
        let dated = of.filter_map(|it| Some((it.began_ms()?, it.is_good(stage))));
        let last = dated.filter(|(at, _)| *at <= now_ms.saturating_add(DAY_MS)).max();
        let next_ms = last.map(|(at, _)| at.saturating_add(u64::from(every_days) * DAY_MS));
        let overdue = next_ms.is_none_or(|next| next <= now_ms);
        Due { stage, every_days, last, next_ms, overdue }
    };
    wanted.map(due).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(began: &str, stage: &str, verdict: &str) -> Kept {
        let text = format!(
            "{{\"schema\":\"{SCHEMA}\",\"site\":\"Hall\",\"began\":\"{began}\",\"stages\":[\"{stage}\"],\
             \"results\":[{{\"stage\":\"{stage}\",\"verdict\":\"{verdict}\"}}],\"ended\":null,\"left\":[]}}"
        );
        Kept::read(text.as_bytes()).unwrap()
    }

    #[test]
    fn a_step_is_due_when_its_days_have_passed_since_it_was_tried() {
        let plan = Plan {
            name: "Hall".into(),
            calendar: crate::plan::Calendar {
                read_days: Some(1),
                dry_days: Some(7),
                outlet_days: None,
            },
            ..Plan::default()
        };
        let all = [
            kept("2025-11-21T08:00:00Z", "read", "pass"),
            kept("2025-11-20T08:00:00Z", "read", "fail"),
            kept("2025-11-14T08:00:00Z", "dry", "fail"),
            kept("2025-11-21T08:00:00Z", "dry", "not_tried"),
        ];
        let at = all[0].began_ms().unwrap();
        let [read, dry] = of(&plan, &all, at + DAY_MS - 1)[..] else { panic!("two steps") };
        assert_eq!((read.last, read.overdue), (Some((at, true)), false));
        assert!(read.is_good() && !dry.is_good());
        assert_eq!(dry.last, Some((at - 7 * DAY_MS, false)), "what was not tried does not count");
        assert!(dry.overdue && of(&plan, &all, at + DAY_MS)[0].overdue);
        let wrong_clock = [kept("2035-01-01T00:00:00Z", "read", "pass")];
        assert!(of(&plan, &wrong_clock, at)[0].overdue, "a test of the future is none");
        // Another site, and none at all.
        let other = Plan { name: "Store".into(), ..plan.clone() };
        let never = of(&other, &all, at);
        assert!(never.iter().all(|it| it.overdue && it.last.is_none() && it.next_ms.is_none()));
        assert!(of(&Plan::default(), &all, at).is_empty());
        for text in ["", "{}", "{\"schema\":\"lafet-site-test/2\"}"] {
            assert!(Kept::read(text.as_bytes()).is_none(), "{text}");
        }
    }
}
