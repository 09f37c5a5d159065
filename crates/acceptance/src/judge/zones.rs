//! Zones and their detectors.

use lafet_texts::{Shown, Text as _, acceptance as text};
use serde_json::Value;

use super::{COINCIDENCE_S, DELAY_S, SILENT_S, known, names, yes};
use crate::check;
use crate::facts::{self, ConfiguredZone, Facts, InstalledZone, Zones};
use crate::finding::Findings;
use crate::plan::{self, Plan};

pub(super) fn judge(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    let (Some(zones), Some(configured)) = (&facts.zones, &facts.configured) else {
        let good = plan.zones.is_empty();
        let planned: Vec<&str> = plan.zones.iter().map(|it| it.id.as_str()).collect();
        if good {
            return findings.not_tried(&check::VOTES, "", text::NoZones);
        }
        return findings.tried(&check::VOTES, "", false, names(&planned), text::NoZones);
    };
    for planned in &plan.zones {
        if configured.zones.iter().all(|it| it.zone != planned.id) {
            let (limit, measured) = (text::ZoneIsThere, text::Nothing);
            findings.tried(&check::VOTES, &planned.id, false, limit, measured);
        }
    }
    for zone in &configured.zones {
        let planned = plan.zones.iter().find(|it| it.id == zone.zone);
        let installed = facts.installation.as_ref();
        let installed = installed.and_then(|it| it.zones.iter().find(|it| it.zone == zone.zone));
        modes(zones, zone, planned, findings);
        votes(zone, planned, installed, findings);
        times(zone, planned, findings);
        served(zone, planned, installed, findings);
    }
    site(plan, zones, findings);
    detectors(plan, facts, zones, configured, findings);
    aims(plan, facts, findings);
}

fn modes(
    zones: &Zones,
    zone: &ConfiguredZone,
    planned: Option<&plan::Zone>,
    findings: &mut Findings,
) {
    let Some(state) = zones.zone(&zone.zone) else { return };
    let wanted = planned.and_then(|it| it.mode.as_deref()).unwrap_or("automatic");
    let good = state.mode == wanted;
    findings.tried(&check::MODE, &zone.zone, good, Shown(wanted), Shown(&state.mode));
}

fn votes(
    zone: &ConfiguredZone,
    planned: Option<&plan::Zone>,
    installed: Option<&InstalledZone>,
    findings: &mut Findings,
) {
    let id = zone.zone.as_str();
    let need = zone.votes.split_once("oo").and_then(|(need, _)| need.parse::<u16>().ok());
    let good = need.is_some_and(|it| it >= 2);
    findings.tried(&check::TWO_SIGNALS, id, good, text::VotesLimit, Shown(&zone.votes));
    let shown = |(votes, kinds): &(String, u16)| format!("{votes}, {kinds}");
    let wanted = planned.and_then(|it| Some((it.votes.clone()?, it.kinds.unwrap_or(1))));
    let found = (zone.votes.clone(), zone.kinds);
    findings.planned(&check::VOTES, id, wanted.as_ref(), &found, shown);
    let list = |it: &Vec<String>| it.join(", ");
    match installed {
        Some(installed) => {
            let wanted = planned.and_then(|it| it.when_failed.as_ref());
            findings.planned(&check::WHEN_FAILED, id, wanted, &installed.when_failed, list);
        }
        None => findings.not_tried(&check::WHEN_FAILED, id, text::NotInstalled),
    }
    let sorted = |all: &[String]| {
        let mut all = all.to_vec();
        all.sort();
        all
    };
    let wanted = planned.map(|it| sorted(&it.detectors)).filter(|it| !it.is_empty());
    let found = sorted(&zone.detectors);
    findings.planned(&check::DETECTORS, id, wanted.as_ref(), &found, list);
}

fn times(zone: &ConfiguredZone, planned: Option<&plan::Zone>, findings: &mut Findings) {
    let id = zone.zone.as_str();
    let found = zone.coincidence_s;
    let wanted = planned.and_then(|it| it.coincidence_s);
    let good = found >= COINCIDENCE_S && wanted.is_none_or(|it| it == found);
    let limit = match wanted.filter(|it| *it >= COINCIDENCE_S) {
        Some(value) => text::Seconds { value }.words(),
        None => text::AtLeastSeconds { value: COINCIDENCE_S }.words(),
    };
    findings.tried(&check::COINCIDENCE, id, good, limit, text::Seconds { value: found });

    let wanted = planned.and_then(|it| Some((it.delay_s?, it.hold_max_s)));
    let hold = zone.hold_max_s.unwrap_or(0);
    let measured = text::DelayIs { delay: zone.delay_s, hold };
    match wanted {
        None => findings.not_tried(&check::DELAY, id, text::NotPlanned),
        Some((delay, wanted_hold)) => {
            let held = wanted_hold.is_none_or(|it| it == hold);
            let good = zone.delay_s == delay && delay <= DELAY_S && held;
            let limit = text::DelayIs { delay, hold: wanted_hold.unwrap_or(hold) };
            findings.tried(&check::DELAY, id, good, limit, measured);
        }
    }
    let seconds = |it: &u32| format!("{it} s");
    let wanted = planned.and_then(|it| it.water_max_s);
    findings.planned(&check::WATER_MAX, id, wanted.as_ref(), &zone.water_max_s, seconds);
    let wanted = planned.and_then(|it| it.return_after_s);
    let good =
        zone.return_after_s.is_some() && wanted.is_none_or(|it| Some(it) == zone.return_after_s);
    let limit = match wanted {
        Some(value) => text::Seconds { value }.words(),
        None => text::ReturnsLimit.words(),
    };
    let measured = match zone.return_after_s {
        Some(value) => text::Seconds { value }.words(),
        None => text::ReturnsNever.words(),
    };
    findings.tried(&check::RETURNS, id, good, limit, measured);
}

fn served(
    zone: &ConfiguredZone,
    planned: Option<&plan::Zone>,
    installed: Option<&InstalledZone>,
    findings: &mut Findings,
) {
    let id = zone.zone.as_str();
    let jets = |it: Option<u16>, of: usize| it.map_or(of, usize::from);
    let found = jets(installed.and_then(|it| it.jets), zone.monitors.len());
    let wanted = planned.filter(|it| !it.monitors.is_empty());
    let as_planned = wanted.is_none_or(|it| {
        let outputs = installed.is_none_or(|installed| {
            installed.valve == it.valve && installed.test_outlet == it.test_outlet
        });
        it.monitors == zone.monitors && jets(it.jets, it.monitors.len()) == found && outputs
    });
    let limit = wanted.map_or_else(
        || text::ServedLimit.words(),
        |it| {
            let count = jets(it.jets, it.monitors.len());
            let valves = shown_valves(it.valve.as_ref(), it.test_outlet.as_ref());
            text::ServedIs { monitors: names(&it.monitors), count, valves: Shown(valves) }.words()
        },
    );
    let valves = installed.map(|it| shown_valves(it.valve.as_ref(), it.test_outlet.as_ref()));
    let valves = Shown(valves.unwrap_or_default());
    let measured = text::ServedIs { monitors: names(&zone.monitors), count: found, valves };
    let good = zone.monitors.len() >= 2 && as_planned;
    findings.tried(&check::SERVED, id, good, limit, measured);
}

fn shown_valves(valve: Option<&String>, outlet: Option<&String>) -> String {
    let shown = |it: Option<&String>| it.map_or("–", String::as_str).to_owned();
    format!("{}, {}", shown(valve), shown(outlet))
}

/// What is wrong with the site as a whole.
fn site(plan: &Plan, zones: &Zones, findings: &mut Findings) {
    let planned = |it: &&Value| {
        let details = it.as_object().and_then(|all| all.iter().next());
        let Some((kind, details)) = details else { return false };
        let zone = details["zone"].as_str().unwrap_or_default();
        let zone = plan.zones.iter().find(|it| it.id == zone);
        match (kind.as_str(), zone) {
            ("delay", Some(zone)) => {
                let wanted = zone.delay_s.map(|it| u64::from(it) * 1000);
                details["delay_ms"].as_u64() == wanted
            }
            ("mode", Some(zone)) => zone.mode.as_deref() == details["mode"].as_str(),
            _ => false,
        }
    };
    let found = zones.state.disablements.iter().filter(|it| !planned(it));
    let found: Vec<String> = found.map(Value::to_string).collect();
    findings.tried(&check::DISABLED, "", found.is_empty(), text::Nothing, names(&found));
    let troubles = zones.state.troubles.iter();
    let found: Vec<String> = troubles.map(|it| format!("{} {}", it.trouble, it.subject)).collect();
    findings.tried(&check::TROUBLES, "", found.is_empty(), text::Nothing, names(&found));
    let alarms = zones.alarms();
    findings.tried(&check::QUIET, "", alarms.is_empty(), text::Nothing, names(&alarms));
}

fn detectors(
    plan: &Plan,
    facts: &Facts,
    zones: &Zones,
    configured: &facts::Configured,
    findings: &mut Findings,
) {
    for wanted in &plan.detectors {
        if zones.state.detectors.iter().all(|it| it.detector != wanted.id) {
            let limit = Shown(&wanted.id);
            findings.tried(&check::DETECTORS, &wanted.id, false, limit, text::Nothing);
        }
    }
    for it in &zones.state.detectors {
        let id = it.detector.as_str();
        let why = it.unable.as_ref().map(Value::to_string);
        let why = why.or_else(|| it.stale.then(|| "stale".to_owned()));
        let measured = why.as_ref().map_or_else(|| yes(true).words(), |it| known(Some(it)));
        findings.tried(&check::ABLE, id, why.is_none(), yes(true), measured);
        let planned = plan.detector(id);
        if let (Some(wanted), Some(kind)) =
            (planned.and_then(|it| it.kind.as_ref()), configured.detectors.get(id))
        {
            findings.planned(&check::DETECTORS, id, Some(wanted), kind, Clone::clone);
        }
        let Some(installed) = facts.installation.as_ref() else { continue };
        let Some(installed) = installed.detectors.iter().find(|it| it.detector == id) else {
            continue;
        };
        let after = installed.silent_after_s;
        let limit = text::AtMostSeconds { value: SILENT_S };
        findings.tried(
            &check::SILENCE,
            id,
            after <= SILENT_S,
            limit,
            text::Seconds { value: after },
        );
        let place = |at: &[f64; 3]| format!("{} {} {} m", at[0], at[1], at[2]);
        match (planned.and_then(|it| it.at), installed.at) {
            (None, _) => findings.not_tried(&check::DETECTOR_PLACE, id, text::NotPlanned),
            (Some(wanted), None) => {
                let limit = Shown(place(&wanted));
                findings.tried(&check::DETECTOR_PLACE, id, false, limit, text::Nothing);
            }
            (Some(wanted), Some(found)) => {
                let near = wanted.iter().zip(&found).all(|(a, b)| (a - b).abs() <= super::PLACE_M);
                let (limit, measured) = (Shown(place(&wanted)), Shown(place(&found)));
                findings.tried(&check::DETECTOR_PLACE, id, near, limit, measured);
            }
        }
    }
}

fn aims(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    let Some(installation) = &facts.installation else {
        return findings.not_tried(&check::AIMS, "", text::NotInstalled);
    };
    let shown = |it: &plan::Aim| {
        let plan::Aim { program, horizontal, vertical, nozzle, valve, .. } = it;
        format!("program {program}, {horizontal}' {vertical}', {nozzle} mm, {valve}")
    };
    for wanted in &plan.aims {
        let of = |it: &facts::InstalledAim| it.zone == wanted.zone && it.monitor == wanted.monitor;
        if !installation.aims.iter().any(of) {
            let subject = format!("{} {}", wanted.zone, wanted.monitor);
            findings.tried(&check::AIMS, &subject, false, Shown(shown(wanted)), text::Nothing);
        }
    }
    for found in &installation.aims {
        let subject = format!("{} {}", found.zone, found.monitor);
        let wanted =
            plan.aims.iter().find(|it| it.zone == found.zone && it.monitor == found.monitor);
        let found = plan::Aim {
            zone: found.zone.clone(),
            monitor: found.monitor.clone(),
            program: found.program,
            horizontal: found.horizontal,
            vertical: found.vertical,
            nozzle: found.nozzle,
            valve: found.valve.clone(),
        };
        findings.planned(&check::AIMS, &subject, wanted, &found, shown);
    }
}
