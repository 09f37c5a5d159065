//! The hub itself: storage, clock, access, and which monitors it knows.

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::{CLOCK_S, FREE_BYTES, FREE_PERMILLE, names, yes};
use crate::check;
use crate::facts::Facts;
use crate::finding::Findings;
use crate::plan::Plan;

pub(super) fn judge(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    storage(facts, findings);
    disk(facts, findings);
    clock(facts, findings);
    match &facts.hub {
        None => findings.not_tried(&check::LOGIN, "", text::NotAnswered { path: "/api/hub" }),
        Some(hub) => findings.tried(&check::LOGIN, "", hub.login, yes(true), yes(hub.login)),
    }
    monitors(plan, facts, findings);
    alarms(facts, findings);
}

fn storage(facts: &Facts, findings: &mut Findings) {
    let Some(health) = &facts.health else {
        let why = text::NotAnswered { path: "/health" };
        findings.not_tried(&check::STORAGE, "", why);
        findings.not_tried(&check::AUDIT_CHAIN, "", why);
        return;
    };
    let lost = facts.state.as_ref().map_or(0, |it| it.audit.lost);
    let failing = facts.state.as_ref().is_some_and(|it| it.audit.failing);
    let good = health.storage == "ok"
        && health.history == "ok"
        && health.state_lost.is_empty()
        && lost == 0
        && !failing;
    let measured = text::StorageIs {
        storage: &health.storage,
        history: &health.history,
        lost,
        files: health.state_lost.len(),
    };
    findings.tried(&check::STORAGE, "", good, text::StorageLimit, measured);
    let chain = &health.audit_chain;
    if chain.state == "checking" {
        findings.not_tried(&check::AUDIT_CHAIN, "", text::ChainChecking);
        return;
    }
    let measured = text::ChainIs { state: &chain.state, verified: chain.verified };
    findings.tried(&check::AUDIT_CHAIN, "", chain.state == "ok", Shown("ok"), measured);
}

fn disk(facts: &Facts, findings: &mut Findings) {
    let disk = facts.state.as_ref().map(|it| &it.disk);
    let Some(disk) = disk else {
        let why = text::NotAnswered { path: "/api/hub/state" };
        return findings.not_tried(&check::DISK, "", why);
    };
    let (Some(free), Some(total)) = (disk.free_bytes, disk.total_bytes) else {
        return findings.not_tried(&check::DISK, "", text::DiskInMemory);
    };
    let permille = free.saturating_mul(1000).checked_div(total).unwrap_or(0);
    let good = free >= FREE_BYTES && permille >= FREE_PERMILLE;
    let limit = text::DiskLimit { mib: FREE_BYTES >> 20, percent: FREE_PERMILLE / 10 };
    let measured = text::DiskIs { mib: free >> 20, percent: permille / 10 };
    findings.tried(&check::DISK, "", good, limit, measured);
}

fn clock(facts: &Facts, findings: &mut Findings) {
    let Some(hub) = &facts.hub else {
        return findings.not_tried(&check::CLOCK, "", text::NotAnswered { path: "/api/hub" });
    };
    let Some(date_ms) = facts.date_ms else {
        return findings.not_tried(&check::CLOCK, "", text::ClockSame);
    };
    let off_s = (hub.now_ms as f64 - date_ms as f64) / 1000.0;
    let limit = text::AtMostSeconds { value: CLOCK_S };
    let measured = text::Seconds { value: format_args!("{off_s:+.1}") };
    findings.tried(&check::CLOCK, "", off_s.abs() <= CLOCK_S, limit, measured);
}

fn monitors(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    let check = &check::MONITORS_KNOWN;
    let Some(monitors) = &facts.monitors else {
        return findings.not_tried(check, "", text::NotAnswered { path: "/api/monitors" });
    };
    if plan.monitors.is_empty() {
        return findings.not_tried(check, "", text::NotPlanned);
    }
    let mut planned: Vec<&str> = plan.monitors.iter().map(|it| it.id.as_str()).collect();
    planned.sort_unstable();
    let found: Vec<&str> = monitors.keys().map(String::as_str).collect();
    findings.tried(check, "", planned == found, names(&planned), names(&found));
}

fn alarms(facts: &Facts, findings: &mut Findings) {
    let Some(alarms) = &facts.alarms else {
        let why = text::NotAnswered { path: "/api/alarms" };
        return findings.not_tried(&check::ALARMS, "", why);
    };
    let urgent = alarms.iter().filter(|it| matches!(it.priority.as_str(), "fire" | "high"));
    let found: Vec<&str> = urgent.filter(|it| it.active).map(|it| it.id.as_str()).collect();
    findings.tried(&check::ALARMS, "", found.is_empty(), text::Nothing, names(&found).words());
}
