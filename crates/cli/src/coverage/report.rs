//! A coverage as text and as JSON.

use lafet_place::coverage::{Coverage, InWind, Rule};
use lafet_place::site::Wind;
use serde_json::{Value, json};

use super::file::Plan;
use crate::lang::pick;
use crate::out::columns;

/// The coverage as text.
pub fn text(plan: &Plan, coverage: &Coverage) -> String {
    let summary = &coverage.summary;
    let mut lines = vec![head(plan, coverage), String::new()];
    lines.push(
        pick(
            "Share of the cells with one jet / with two, and the fewest jets on a cell (90 %):",
            "Доля ячеек с одной струёй / с двумя и наименьшее число струй на ячейку (90 %):",
        )
        .into(),
    );
    let titles = [
        pick("wind", "ветер"),
        pick("reached", "достигается"),
        pick("90 % of the throw", "90 % дальности"),
        pick("75 % of that in still air", "75 % дальности в штиль"),
        pick("fewest", "наименьшее"),
    ];
    let mut rows = vec![titles.map(String::from).to_vec()];
    rows.extend(summary.winds.iter().map(row));
    lines.extend([columns(&rows), String::new()]);
    lines.push(pick("Weakest points (90 %):", "Слабейшие точки (90 %):").into());
    let weak = summary.weakest.iter().map(|weak| {
        let [east, north] = weak.at;
        let (fewest, still) = (weak.fewest, weak.still);
        vec![
            format!("{east:.1}, {north:.1}"),
            pick(
                format!("{fewest} jet(s) in the worst wind"),
                format!("струй при худшем ветре: {fewest}"),
            ),
            pick(format!("{still} in still air"), format!("в штиль: {still}")),
        ]
    });
    lines.extend([columns(&weak.collect::<Vec<_>>()), String::new()]);
    lines.push(
        pick(
            "What a lost monitor costs (90 %, worst wind):",
            "Цена потери ствола (90 %, худший ветер):",
        )
        .into(),
    );
    let lost = summary.lost.iter().map(|lost| {
        let (none, one) = (percent(lost.none_left), percent(lost.one_left));
        vec![
            lost.monitor.clone(),
            pick(format!("{none} without a jet"), format!("без струи {none}")),
            pick(format!("{one} left with one"), format!("с одной вместо двух {one}")),
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
    pick(
        format!(
            "{name}: {east} × {north} m, cells of {cell} m, {protected} of them to protect; {count} \
             monitor(s), {flowing} flow together at {pressure:.2} MPa"
        ),
        comma(format!(
            "{name}: {east} × {north} м, ячейки {cell} м, под защитой {protected}; стволов: {count}, \
             одновременно работают {flowing} при {pressure:.2} МПа"
        )),
    )
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
        return pick("still air", "штиль").into();
    }
    pick(format!("from {from:.0}°, {speed} m/s"), comma(format!("с {from:.0}°, {speed} м/с")))
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    pick(format!("{percent:.1} %"), comma(format!("{percent:.1} %")))
}

/// Decimals with a comma.
pub fn comma(text: String) -> String {
    let mut before = ' ';
    let mut result = String::new();
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_decimal = letter == '.'
            && before.is_ascii_digit()
            && letters.peek().is_some_and(char::is_ascii_digit);
        result.push(if is_decimal { ',' } else { letter });
        before = letter;
    }
    result
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
