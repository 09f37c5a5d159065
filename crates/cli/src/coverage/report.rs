//! A coverage as text and as JSON.

use lafet_place::coverage::{Coverage, InWind, Rule};
use lafet_place::site::Wind;
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use super::file::Plan;
use crate::lang::{current, decimals};
use crate::out::columns;

/// The coverage as text.
pub fn text(plan: &Plan, coverage: &Coverage) -> String {
    let summary = &coverage.summary;
    let mut lines = vec![head(plan, coverage), String::new()];
    lines.push(text::CoverageShares.str(current()).into());
    let titles = [
        text::CoverageWind.str(current()),
        text::CoverageReached.str(current()),
        text::Coverage90.str(current()),
        text::Coverage75.str(current()),
        text::CoverageFewest.str(current()),
    ];
    let mut rows = vec![titles.map(String::from).to_vec()];
    rows.extend(summary.winds.iter().map(row));
    lines.extend([columns(&rows), String::new()]);
    lines.push(text::WeakestPoints.str(current()).into());
    let weak = summary.weakest.iter().map(|weak| {
        let [east, north] = weak.at;
        let (fewest, still) = (weak.fewest, weak.still);
        vec![
            format!("{east:.1}, {north:.1}"),
            text::WeakestFewest { fewest }.of(current()),
            text::WeakestStill { still }.of(current()),
        ]
    });
    lines.extend([columns(&weak.collect::<Vec<_>>()), String::new()]);
    lines.push(text::LostMonitorCosts.str(current()).into());
    let lost = summary.lost.iter().map(|lost| {
        let (none, one) = (percent(lost.none_left), percent(lost.one_left));
        vec![
            lost.monitor.clone(),
            text::CellsWithoutJet { none }.of(current()),
            text::CellsWithOne { one }.of(current()),
        ]
    });
    lines.push(columns(&lost.collect::<Vec<_>>()));
    lines.join("\n")
}

/// Site, area and pressure in one line.
pub fn head(plan: &Plan, coverage: &Coverage) -> String {
    let [east, north] = plan.area.size;
    let (cell, flowing) = (plan.area.cell_m, plan.area.flowing);
    let (name, count) = (&plan.name, plan.site.monitors.len());
    let pressure = coverage.pressure_mpa;
    let protected = coverage.summary.protected;
    let head = text::CoverageHead {
        name,
        east,
        north,
        cell,
        protected,
        count,
        flowing,
        pressure: format_args!("{pressure:.2}"),
    };
    decimals(head.of(current()))
}

fn row(in_wind: &InWind) -> Vec<String> {
    let share =
        |rule: usize| format!("{} / {}", percent(in_wind.one[rule]), percent(in_wind.two[rule]));
    let fewest = in_wind.fewest[Rule::Within90 as usize].to_string();
    vec![wind(in_wind.wind), share(0), share(1), share(2), fewest]
}

/// A wind in words.
pub fn wind(wind: Wind) -> String {
    let (from, speed) = (wind.from.to_degrees().rem_euclid(360.0), wind.speed_mps);
    if speed == 0.0 {
        return text::StillAir.str(current()).into();
    }
    let from = format_args!("{from:.0}");
    decimals(text::CoverageWindFrom { from, speed }.of(current()))
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    decimals(format!("{percent:.1} %"))
}

/// The coverage as JSON; the counts of every cell only if asked for.
pub fn json(plan: &Plan, coverage: &Coverage, grid: bool) -> Value {
    let summary = &coverage.summary;
    let shares = |shares: [f64; 3]| json!({ "reached": shares[0], "within_90": shares[1], "within_75": shares[2] });
    let winds = summary.winds.iter().map(|it| {
        json!({
            "from_deg": it.wind.from.to_degrees().rem_euclid(360.0),
            "speed_mps": it.wind.speed_mps,
            "one": shares(it.one),
            "two": shares(it.two),
            "fewest_within_90": it.fewest[Rule::Within90 as usize],
        })
    });
    let mut value = json!({
        "site": plan.name,
        "corner_m": plan.area.corner,
        "cell_m": plan.area.cell_m,
        "cells": coverage.cells,
        "protected": summary.protected,
        "flowing": plan.area.flowing,
        "pressure_mpa": coverage.pressure_mpa,
        "winds": winds.collect::<Vec<_>>(),
        "weakest": summary.weakest,
        "lost": summary.lost,
    });
    if grid {
        let counts = (0..summary.winds.len()).map(|wind| {
            let [reached, within_90, within_75] = Rule::ALL.map(|rule| coverage.counts(wind, rule));
            json!({ "reached": reached, "within_90": within_90, "within_75": within_75 })
        });
        value["grid"] = counts.collect();
    }
    value
}
