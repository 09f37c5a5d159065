//! Monitors: link, state at rest, parameters, place.

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::{HEADING_DEG, LOSS_PERMILLE, PLACE_M, WATER_S, names};
use crate::check;
use crate::facts::{Facts, KeepOut, Monitor, Params};
use crate::finding::Findings;
use crate::plan::{self, Plan};

pub(super) fn judge(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    let Some(monitors) = &facts.monitors else {
        return findings.not_tried(&check::LINK, "", text::NotAnswered { path: "/api/monitors" });
    };
    for (id, monitor) in monitors {
        let planned = plan.monitors.iter().find(|it| it.id == *id);
        state(id, monitor, findings);
        at_rest(id, monitor, planned, findings);
        let params = facts.params.get(id).and_then(Option::as_ref);
        water_timeout(plan, facts, id, params, findings);
        parameters(id, planned, params, findings);
        place(facts, id, planned, findings);
    }
    keep_outs(plan, facts, findings);
}

fn state(id: &str, monitor: &Monitor, findings: &mut Findings) {
    let link = &monitor.link;
    let up = monitor.is_heard();
    let loss = link.loss_permille;
    let limit = text::LinkLimit { percent: LOSS_PERMILLE / 10.0 };
    let measured = text::LinkIs { state: &link.state, percent: format_args!("{:.1}", loss / 10.0) };
    // Of a few exchanges the share says nothing.
    let lossy = link.sent >= 100 && loss > LOSS_PERMILLE;
    findings.tried(&check::LINK, id, up && !lossy, limit, measured);
    if !up {
        return findings.not_tried(&check::READY, id, text::NoLink);
    }
    let reasons = monitor.readiness.reasons.iter().filter(|it| it.code != "wrapped");
    let found: Vec<String> = reasons
        .map(|it| match (&it.subsystem, &it.flag) {
            (Some(subsystem), Some(flag)) => format!("{subsystem}/{flag}"),
            _ => it.code.clone(),
        })
        .collect();
    findings.tried(&check::READY, id, found.is_empty(), text::Nothing, names(&found));
    let holder = monitor.authority.holder.as_ref().map(|it| it.user.as_str());
    let held: Vec<&str> = holder.into_iter().collect();
    findings.tried(&check::FREE, id, held.is_empty(), text::Nothing, names(&held));
}

fn at_rest(id: &str, monitor: &Monitor, planned: Option<&plan::Monitor>, findings: &mut Findings) {
    if !monitor.is_heard() {
        findings.not_tried(&check::REST, id, text::NoLink);
        return findings.not_tried(&check::PRESSURE_AT_REST, id, text::NoLink);
    }
    let open = monitor.not_closed();
    let flow = monitor.general("flowrate");
    // Without a sensor of the flow the valves alone are looked at.
    let still = flow.is_none_or(|it| it == 0.0);
    let measured = text::RestIs { open: names(&open), flow: super::known(flow) };
    findings.tried(&check::REST, id, open.is_empty() && still, text::RestLimit, measured);
    let Some([least, most]) = planned.and_then(|it| it.rest_datm) else {
        return findings.not_tried(&check::PRESSURE_AT_REST, id, text::NotPlanned);
    };
    let pressure = monitor.general("pressure");
    let good = pressure.is_some_and(|it| (least..=most).contains(&it));
    let limit = text::Pressures { least, most };
    let measured = text::Pressure { value: super::known(pressure) };
    findings.tried(&check::PRESSURE_AT_REST, id, good, limit, measured);
}

/// Between the longest water of its zones and an hour: what a hub that ends leaves running ends by itself.
fn water_timeout(
    plan: &Plan,
    facts: &Facts,
    id: &str,
    params: Option<&Params>,
    findings: &mut Findings,
) {
    let check = &check::WATER_TIMEOUT;
    let value =
        params.and_then(|it| it.values.get("General")?.get("WaterTimeout")?.values.as_ref());
    let Some(value) = value.and_then(|it| it.first()) else {
        return findings.not_tried(check, id, text::NoParameter { name: "General.WaterTimeout" });
    };
    let serves = |monitors: &[String]| monitors.iter().any(|it| it == id);
    let configured = facts.configured.iter().flat_map(|it| &it.zones);
    let configured = configured.filter(|it| serves(&it.monitors)).map(|it| it.water_max_s);
    let planned = plan.zones.iter().filter(|it| serves(&it.monitors));
    let planned = planned.filter_map(|it| it.water_max_s);
    let Some(longest) = planned.chain(configured).max() else {
        return findings.not_tried(check, id, text::NotInAZone);
    };
    let most = longest.max(WATER_S);
    let good = (i64::from(longest)..=i64::from(most)).contains(value);
    let limit = text::SecondsBetween { least: longest, most };
    findings.tried(check, id, good, limit, text::Seconds { value });
}

fn parameters(
    id: &str,
    planned: Option<&plan::Monitor>,
    params: Option<&Params>,
    findings: &mut Findings,
) {
    let check = &check::PARAMETERS;
    let Some(planned) = planned.filter(|it| !it.params.is_empty()) else {
        return findings.not_tried(check, id, text::NotPlanned);
    };
    let Some(params) = params else { return findings.not_tried(check, id, text::NoLink) };
    let mut limit = Vec::new();
    let mut measured = Vec::new();
    let shown =
        |values: &[i64]| values.iter().map(i64::to_string).collect::<Vec<String>>().join(" ");
    for (name, wanted) in &planned.params {
        let (subsystem, parameter) = name.split_once('.').unwrap_or(("", name));
        let found = params.values.get(subsystem).and_then(|it| it.get(parameter));
        let found = found.and_then(|it| it.values.as_ref());
        if found != Some(wanted) {
            limit.push(format!("{name} = {}", shown(wanted)));
            let found = found.map_or_else(|| "?".to_owned(), |it| shown(it));
            measured.push(format!("{name} = {found}"));
        }
    }
    let count = planned.params.len();
    if measured.is_empty() {
        let all = text::ParametersAgree { count };
        return findings.tried(check, id, true, all, all);
    }
    findings.tried(check, id, false, names(&limit), names(&measured));
}

fn place(facts: &Facts, id: &str, planned: Option<&plan::Monitor>, findings: &mut Findings) {
    let check = &check::PLACE;
    let Some(planned) = planned.filter(|it| it.at.is_some() || it.heading.is_some()) else {
        return findings.not_tried(check, id, text::NotPlanned);
    };
    let map = facts.hub.as_ref().and_then(|it| it.site.as_ref());
    let found = map.and_then(|it| it.monitors.get(id));
    let at = planned.at.unwrap_or_default();
    let (heading, height) =
        (planned.heading.unwrap_or_default(), planned.height.unwrap_or_default());
    let limit = text::PlaceIs { east: at[0], north: at[1], heading, height };
    let Some(found) = found else {
        return findings.tried(check, id, false, limit, text::Unknown);
    };
    let near =
        |plan: Option<f64>, found: f64, most: f64| plan.is_none_or(|it| (it - found).abs() <= most);
    let turn = planned.heading.map(|it| wrapped_deg(it - found.heading));
    let good = near(planned.at.map(|it| it[0]), found.at[0], PLACE_M)
        && near(planned.at.map(|it| it[1]), found.at[1], PLACE_M)
        && near(planned.height, found.height, PLACE_M)
        && turn.is_none_or(|it| it.abs() <= HEADING_DEG);
    let measured = text::PlaceIs {
        east: found.at[0],
        north: found.at[1],
        heading: found.heading,
        height: found.height,
    };
    findings.tried(check, id, good, limit, measured);
}

/// The difference of two directions, −180 to 180°.
pub fn wrapped_deg(degrees: f64) -> f64 {
    let turned = degrees.rem_euclid(360.0);
    if turned > 180.0 { turned - 360.0 } else { turned }
}

fn keep_outs(plan: &Plan, facts: &Facts, findings: &mut Findings) {
    let check = &check::KEEP_OUTS;
    let Some(hub) = &facts.hub else {
        return findings.not_tried(check, "", text::NotAnswered { path: "/api/hub" });
    };
    let found: &[KeepOut] = hub.site.as_ref().map_or(&[], |it| &it.keep_outs);
    for planned in &plan.keep_outs {
        let known = found.iter().find(|it| it.name == planned.name);
        let [least, most] = planned.elevations.unwrap_or([-90.0, 90.0]);
        let limit = sector(planned.monitor.as_ref(), planned.bearings, [least, most]);
        let Some(known) = known else {
            findings.tried(check, &planned.name, false, Shown(limit), text::Nothing);
            continue;
        };
        let measured = sector(known.monitor.as_ref(), known.bearings, known.elevations);
        let good = planned.monitor == known.monitor
            && is_same_sector(planned.bearings, known.bearings)
            && (least - known.elevations[0]).abs() <= HEADING_DEG
            && (most - known.elevations[1]).abs() <= HEADING_DEG;
        findings.tried(check, &planned.name, good, Shown(limit), Shown(measured));
    }
    let more = found.iter().filter(|it| plan.keep_outs.iter().all(|plan| plan.name != it.name));
    for known in more {
        let measured = sector(known.monitor.as_ref(), known.bearings, known.elevations);
        let limit = text::Nothing.words();
        // A plan without any says nothing of them.
        match plan.keep_outs.is_empty() {
            true => findings.not_tried(check, &known.name, text::NotPlanned),
            false => findings.tried(check, &known.name, false, limit, Shown(measured)),
        }
    }
    if plan.keep_outs.is_empty() && found.is_empty() {
        findings.not_tried(check, "", text::NotPlanned);
    }
}

/// From the same direction, and as wide: 350° and −10° are the same.
fn is_same_sector(one: [f64; 2], other: [f64; 2]) -> bool {
    let width = |[from, to]: [f64; 2]| match (to - from).rem_euclid(360.0) {
        0.0 => 360.0,
        width => width,
    };
    wrapped_deg(one[0] - other[0]).abs() <= HEADING_DEG
        && (width(one) - width(other)).abs() <= HEADING_DEG
}

fn sector(monitor: Option<&String>, bearings: [f64; 2], elevations: [f64; 2]) -> String {
    let monitor = monitor.map_or("*", String::as_str);
    let ([from, to], [low, high]) = (bearings, elevations);
    format!("{monitor}: {from}…{to}°, {low}…{high}°")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sectors_are_the_same_however_they_are_written() {
        assert!(is_same_sector([350.0, 20.0], [-10.0, 20.0]));
        assert!(is_same_sector([0.0, 360.0], [0.0, 360.0]));
        for other in [[0.0, 359.0], [0.0, 1.0], [180.0, 180.5]] {
            assert!(!is_same_sector([0.0, 360.0], other), "{other:?}");
        }
        assert!(!is_same_sector([350.0, 20.0], [20.0, 350.0]), "the other way round");
    }

    #[test]
    fn directions_differ_the_short_way() {
        for (degrees, short) in [(0.0, 0.0), (359.0, -1.0), (-181.0, 179.0), (180.0, 180.0)] {
            assert!((wrapped_deg(degrees) - short).abs() < 1e-9, "{degrees}");
        }
    }
}
