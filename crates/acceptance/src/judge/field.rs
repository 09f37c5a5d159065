//! Buses, contacts, outputs, pumps.

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::{names, yes};
use crate::check::{self, Check};
use crate::facts::{Facts, Installation};
use crate::finding::Findings;
use crate::plan::Plan;

pub(super) fn judge(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    buses(facts, findings);
    pumps_at_rest(facts, findings);
    let Some(installation) = &facts.installation else {
        let why = match &facts.zones {
            None => text::NoZones.words(),
            Some(_) => text::NotInstalled.words(),
        };
        for check in [&check::CONTACTS, &check::OUTPUTS, &check::PUMPS] {
            findings.not_tried(check, "", why.clone());
        }
        return;
    };
    contacts(plan, installation, findings);
    outputs(plan, installation, findings);
    pumps(plan, installation, findings);
}

fn buses(facts: &Facts, findings: &mut Findings) {
    let Some(buses) = &facts.buses else {
        return findings.not_tried(&check::BUSES, "", text::NotAnswered { path: "/api/modbus" });
    };
    for bus in &buses.buses {
        let sources = bus.detectors.iter().chain(&bus.inputs);
        let bad = sources.filter(|it| it.reading != "good");
        let mut found: Vec<String> = bad.map(|it| format!("{} {}", it.id, it.reading)).collect();
        let bad = bus.outputs.iter().filter_map(|it| Some((it.id.as_str(), it.trouble.as_ref()?)));
        found.extend(bad.map(|(id, trouble)| format!("{id} {trouble}")));
        if !bus.connected {
            found.insert(0, "not connected".to_owned());
        }
        findings.tried(&check::BUSES, &bus.name, found.is_empty(), text::Nothing, names(&found));
    }
}

fn pumps_at_rest(facts: &Facts, findings: &mut Findings) {
    let pumps = facts.zones.iter().flat_map(|it| &it.state.pumps);
    for pump in pumps {
        let driven = facts.buses.iter().flat_map(|it| &it.buses).flat_map(|it| &it.outputs);
        let driven = driven.filter(|it| it.id == pump.pump);
        let driven = driven.filter_map(|it| it.feedback.or(it.read_back));
        let runs = pump.runs == Some(true) || driven.clone().any(|it| it);
        let pressure = pump.pressure == Some(true);
        let good = !runs && !pressure && !pump.failed;
        let limit = text::PumpIs { runs: yes(false), pressure: yes(false) };
        let measured = text::PumpIs { runs: yes(runs), pressure: yes(pressure) };
        findings.tried(&check::PUMPS_REST, &pump.pump, good, limit, measured);
    }
}

/// A name, and what it is: as it is planned, or as it is installed.
type Listed<'a> = (&'a str, String);

fn contacts(plan: &Plan, installation: &Installation, findings: &mut Findings) {
    let shown = |kind: &str, zones: &[String]| {
        let mut zones = zones.to_vec();
        zones.sort();
        format!("{kind}: {}", zones.join(", "))
    };
    let wanted = plan.inputs.iter().map(|it| (it.id.as_str(), shown(&it.kind, &it.zones)));
    let found = installation.inputs.iter();
    let found = found.map(|it| (it.input.as_str(), shown(&it.kind, &it.zones)));
    compare(&check::CONTACTS, &wanted.collect::<Vec<_>>(), &found.collect::<Vec<_>>(), findings);
}

fn outputs(plan: &Plan, installation: &Installation, findings: &mut Findings) {
    let shown =
        |kind: &str, zone: Option<&String>| format!("{kind}: {}", zone.map_or("", String::as_str));
    let wanted = plan.outputs.iter().map(|it| (it.id.as_str(), shown(&it.kind, it.zone.as_ref())));
    let found = installation.outputs.iter();
    let found = found.map(|it| (it.output.as_str(), shown(&it.kind, it.zone.as_ref())));
    compare(&check::OUTPUTS, &wanted.collect::<Vec<_>>(), &found.collect::<Vec<_>>(), findings);
}

/// What is planned has to be installed so; what is installed besides is not tried.
fn compare(
    check: &'static Check,
    wanted: &[Listed<'_>],
    found: &[Listed<'_>],
    findings: &mut Findings,
) {
    for (id, limit) in wanted {
        let measured = found.iter().find(|(other, _)| other == id).map(|(_, shown)| shown);
        match measured {
            Some(it) => findings.tried(check, id, limit == it, Shown(limit), Shown(it)),
            None => findings.tried(check, id, false, Shown(limit), text::Nothing),
        }
    }
    for (id, _) in found {
        if wanted.iter().all(|(other, _)| other != id) {
            findings.not_tried(check, id, text::NotPlanned);
        }
    }
}

fn pumps(plan: &Plan, installation: &Installation, findings: &mut Findings) {
    if plan.pumps.is_empty() {
        return findings.not_tried(&check::PUMPS, "", text::NotPlanned);
    }
    let shown = |id: &str, delay: u32, standby: bool| {
        format!("{id} +{delay} s{}", if standby { " (standby)" } else { "" })
    };
    let wanted = plan.pumps.iter().map(|it| shown(&it.id, it.start_delay_s, it.standby));
    let wanted: Vec<String> = wanted.collect();
    let found = installation.pumps.iter().map(|it| shown(&it.pump, it.start_delay_s, it.standby));
    let found: Vec<String> = found.collect();
    let (limit, measured) = (names(&wanted).words(), names(&found));
    findings.tried(&check::PUMPS, "", wanted == found, limit, measured);
}
