//! Aligned time lines: fires, positions, pressure, flow, and bars for what was broken and reported.

use core::fmt::Write as _;

use lafet_texts::{Lang, Words, sim as text};

use super::canvas::{
    Anchor, CAUSE, Canvas, FAINT, FIRES, GRID, INK, MONITORS, SOFT, TOLD, Type, tick, width_of,
    wrapped,
};
use crate::exercise::log::Kind;
use crate::exercise::recording::{BarKind, Recording, Sample};
use crate::exercise::report::clock;
use crate::exercise::run::Outcome;

/// Space for the names and numbers on the left.
const LEFT: f64 = 140.0;
const RIGHT: f64 = 14.0;
const PANEL: f64 = 66.0;
const GAP: f64 = 12.0;
const BAR: f64 = 15.0;
/// Most events below the time lines.
const EVENTS: usize = 20;

struct Time {
    x: f64,
    width: f64,
    duration_ms: f64,
}

impl Time {
    fn at(&self, ms: f64) -> f64 {
        self.x + self.width * (ms / self.duration_ms).min(1.0)
    }
}

/// A time line of one quantity.
struct Panel<'a> {
    title: &'a str,
    unit: &'a str,
    /// The least range that is shown.
    range: (f64, f64),
    series: Vec<Series>,
}

struct Series {
    style: (&'static str, &'static str),
    values: Vec<f64>,
}

/// Draws all; the place below.
pub fn draw(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64), width: f64) -> f64 {
    let time = Time {
        x: at.0 + LEFT,
        width: width - LEFT - RIGHT,
        duration_ms: outcome.exercise.duration_ms as f64,
    };
    let top = at.1 + 26.0;
    let panels = panels(outcome, lang);
    let bars_y = top + panels.len() as f64 * (PANEL + GAP);
    let rows = outcome.recording.bars.len();
    let bottom = bars_y + if rows == 0 { 0.0 } else { bar_rows(outcome) as f64 * BAR + 6.0 };
    time_axis(canvas, &time, top, bottom, lang);
    let events = events(outcome, lang);
    let (mut last_x, mut raised) = (f64::NEG_INFINITY, 0.0);
    for (number, (at_ms, _)) in (1..).zip(&events) {
        let x = time.at(*at_ms as f64);
        canvas.line((x, top), (x, bottom), &format!("stroke=\"{SOFT}\" stroke-dasharray=\"2 3\""));
        let small = Type::new(10.0, SOFT).at(Anchor::Middle);
        // Numbers that would stand on each other go up in steps.
        raised = if x - last_x < 14.0 { raised + 10.0 } else { 0.0 };
        last_x = x;
        canvas.text((x, top - 4.0 - raised), small, &number.to_string());
    }
    let step_ms = outcome.recording.step_ms as f64;
    for (index, panel) in panels.iter().enumerate() {
        let y = top + index as f64 * (PANEL + GAP);
        draw_panel(canvas, panel, &time, step_ms, at.0, y);
    }
    bars(canvas, outcome, lang, &time, at.0, bars_y);
    list(canvas, &events, (at.0, bottom + 42.0), width)
}

fn panels<'a>(outcome: &Outcome, lang: Lang) -> Vec<Panel<'a>> {
    let recording = &outcome.recording;
    let mut panels = vec![
        fires(outcome, lang),
        Panel {
            title: text::Azimuth.str(lang),
            unit: "°",
            range: (-10.0, 10.0),
            series: of_monitors(recording, |sample| sample.azimuth_deg),
        },
        Panel {
            title: text::ChartElevation.str(lang),
            unit: "°",
            range: (-5.0, 10.0),
            series: of_monitors(recording, |sample| sample.elevation_deg),
        },
        Panel {
            title: text::Pressure.str(lang),
            unit: text::UnitAtm.str(lang),
            range: (0.0, 8.0),
            series: of_monitors(recording, |sample| sample.pressure_atm),
        },
        Panel {
            title: text::Flow.str(lang),
            unit: text::UnitLps.str(lang),
            range: (0.0, 20.0),
            series: of_monitors(recording, |sample| sample.flow_lps),
        },
    ];
    add_what_moves(&mut panels, recording, lang);
    panels
}

fn fires<'a>(outcome: &Outcome, lang: Lang) -> Panel<'a> {
    let fires = outcome.recording.fires.iter().enumerate().map(|(index, samples)| Series {
        style: FIRES[index % FIRES.len()],
        values: samples
            .iter()
            .map(|(heat, size_m)| {
                let spec = &outcome.exercise.site.fires[index].spec;
                let area_m2 = core::f64::consts::FRAC_PI_4 * size_m * size_m;
                spec.kw_m2 * area_m2 * heat / 1000.0
            })
            .collect(),
    });
    Panel {
        title: text::Heat.str(lang),
        unit: text::UnitMw.str(lang),
        range: (0.0, 0.1),
        series: fires.collect(),
    }
}

/// A value of each monitor.
fn of_monitors(recording: &Recording, value: fn(&Sample) -> f64) -> Vec<Series> {
    let series = recording.monitors.iter().enumerate().map(|(index, samples)| Series {
        style: MONITORS[index % MONITORS.len()],
        values: samples.iter().map(value).collect(),
    });
    series.collect()
}

/// Panels of what often stays as it is: shown where it does not.
fn add_what_moves(panels: &mut Vec<Panel<'_>>, recording: &Recording, lang: Lang) {
    let moves = |value: fn(&Sample) -> f64, least: f64| {
        recording.monitors.iter().any(|samples| {
            let values = || samples.iter().map(value);
            let low = values().fold(f64::INFINITY, f64::min);
            values().fold(f64::NEG_INFINITY, f64::max) - low > least
        })
    };
    if moves(|sample| sample.nozzle_mm, 1.0) {
        panels.insert(
            3,
            Panel {
                title: text::ChartNozzle.str(lang),
                unit: text::UnitMm.str(lang),
                range: (0.0, 60.0),
                series: of_monitors(recording, |sample| sample.nozzle_mm),
            },
        );
    }
    if moves(|sample| sample.deployer_deg, 1.0) {
        panels.insert(
            1,
            Panel {
                title: text::Deployer.str(lang),
                unit: "°",
                range: (0.0, 90.0),
                series: of_monitors(recording, |sample| sample.deployer_deg),
            },
        );
    }
    if moves(|sample| sample.drive_c, 3.0) {
        panels.push(Panel {
            title: text::VerticalDrive.str(lang),
            unit: "°C",
            range: (-5.0, 5.0),
            series: of_monitors(recording, |sample| sample.drive_c),
        });
    }
}

fn time_axis(canvas: &mut Canvas, time: &Time, top: f64, bottom: f64, lang: Lang) {
    let step_s = [5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0]
        .into_iter()
        .find(|step| time.duration_ms / 1000.0 / step <= 16.0)
        .unwrap_or(1800.0);
    let small = Type::new(11.0, SOFT).at(Anchor::Middle);
    let mut at_s = 0.0;
    while at_s * 1000.0 <= time.duration_ms {
        let x = time.at(at_s * 1000.0);
        canvas.line((x, top), (x, bottom + 4.0), &format!("stroke=\"{GRID}\""));
        let (minutes, seconds) = (libm::floor(at_s / 60.0), at_s % 60.0);
        canvas.text((x, bottom + 17.0), small, &format!("{minutes:.0}:{seconds:02.0}"));
        at_s += step_s;
    }
    let end = Type::new(11.0, SOFT).at(Anchor::End);
    canvas.text((time.x - 14.0, bottom + 17.0), end, text::TimeAxis.str(lang));
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel<'_>, time: &Time, step_ms: f64, x: f64, y: f64) {
    let all = || panel.series.iter().flat_map(|series| &series.values);
    let low = all().copied().fold(panel.range.0, f64::min);
    let high = all().copied().fold(panel.range.1, f64::max);
    let step = tick(high - low, 3.0);
    let (low, high) = (libm::floor(low / step) * step, libm::ceil(high / step) * step);
    let to_y = |value: f64| y + PANEL - (value - low) / (high - low) * PANEL;
    let mut value = low;
    while value < high + step / 2.0 {
        let at = to_y(value);
        canvas.line((time.x, at), (time.x + time.width, at), &format!("stroke=\"{GRID}\""));
        let text = if step < 1.0 { format!("{value:.1}") } else { format!("{value:.0}") };
        canvas.text((time.x - 6.0, at + 3.5), Type::new(10.0, SOFT).at(Anchor::End), &text);
        value += step;
    }
    canvas.line(
        (time.x, y + PANEL),
        (time.x + time.width, y + PANEL),
        &format!("stroke=\"{FAINT}\""),
    );
    let mut title_y = y + 14.0;
    for line in wrapped(panel.title, LEFT - 40.0, 12.0) {
        canvas.text((x, title_y), Type::new(12.0, INK).bold(), &line);
        title_y += 15.0;
    }
    canvas.text((x, title_y), Type::new(11.0, SOFT), panel.unit);
    for series in &panel.series {
        let (colour, dash) = series.style;
        let data = polyline(&series.values, |index| time.at(index as f64 * step_ms), to_y);
        let style = format!(
            "fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.7\" stroke-dasharray=\"{dash}\" \
             stroke-linejoin=\"round\""
        );
        canvas.path(&data, &style);
    }
}

/// A line through the values; points within a level stretch are left out.
fn polyline(values: &[f64], x: impl Fn(usize) -> f64, y: impl Fn(f64) -> f64) -> String {
    let mut data = String::new();
    let tenth = |value: f64| libm::round(y(value) * 10.0);
    for (index, value) in values.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|at| values.get(at));
        let neighbours = before.zip(values.get(index + 1));
        let level = |other: &f64| tenth(*other) == tenth(*value);
        if neighbours.is_some_and(|(before, after)| level(before) && level(after)) {
            continue;
        }
        let sign = if data.is_empty() { 'M' } else { 'L' };
        // Writing to a String cannot fail.
        let _ = write!(data, "{sign}{:.1} {:.1}", x(index), y(*value));
    }
    data
}

/// The rows of bars: one for each name of each monitor.
fn rows(outcome: &Outcome) -> Vec<(Option<usize>, BarKind, &Words)> {
    let mut rows: Vec<(Option<usize>, BarKind, &Words)> = Vec::new();
    for bar in &outcome.recording.bars {
        let row = (bar.monitor, bar.kind, &bar.label);
        if bar.until_ms > bar.from_ms + 300 && !rows.contains(&row) {
            rows.push(row);
        }
    }
    rows.sort_by_key(|(monitor, kind, _)| (monitor.map_or(0, |it| it + 1), *kind));
    rows
}

fn bar_rows(outcome: &Outcome) -> usize {
    rows(outcome).len()
}

fn bars(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, time: &Time, x: f64, y: f64) {
    for (index, (monitor, kind, label)) in rows(outcome).into_iter().enumerate() {
        let y = y + index as f64 * BAR;
        let fill = if kind == BarKind::Cause { CAUSE } else { TOLD };
        let name = monitor.map_or("", |index| &outcome.exercise.monitors[index].name);
        let what = match kind {
            BarKind::Cause => text::BarCause.str(lang),
            BarKind::Told => text::BarFlag.str(lang),
        };
        canvas.text((x, y + 10.5), Type::new(10.5, SOFT), &format!("{name} {what}"));
        let bars = outcome.recording.bars.iter();
        let own = bars.filter(|bar| (bar.monitor, bar.kind, &bar.label) == (monitor, kind, label));
        let mut label_x = None;
        let mut end = time.x;
        for bar in own {
            let (from, until) = (time.at(bar.from_ms as f64), time.at(bar.until_ms as f64));
            canvas.rect(
                from,
                y + 2.0,
                (until - from).max(1.5),
                BAR - 4.0,
                &format!("fill=\"{fill}\" rx=\"1.5\""),
            );
            label_x.get_or_insert(from);
            end = until.max(end);
        }
        let text = label.of(lang);
        let wide = width_of(text, 10.5);
        let after = end + 5.0;
        let (at, anchor) = match label_x {
            _ if after + wide < time.x + time.width => (after, Anchor::Start),
            Some(from) if from - 5.0 - wide > time.x => (from - 5.0, Anchor::End),
            _ => (time.x + 6.0, Anchor::Start),
        };
        canvas.label((at, y + 11.0), Type::new(10.5, INK).at(anchor), text);
    }
}

/// What the numbers above the time lines stand for: what happened to the site, and fires.
fn events(outcome: &Outcome, lang: Lang) -> Vec<(u64, String)> {
    let told = outcome.lines.iter().filter(|line| {
        matches!(line.kind, Kind::Event | Kind::Fire)
            || (line.kind == Kind::Plant && line.at_ms > 0)
    });
    let told = told.map(|line| {
        let name = line.monitor.map(|index| format!("{}: ", outcome.exercise.monitors[index].name));
        (line.at_ms, format!("{}{}", name.unwrap_or_default(), line.text.of(lang)))
    });
    told.take(EVENTS).collect()
}

fn list(canvas: &mut Canvas, events: &[(u64, String)], at: (f64, f64), width: f64) -> f64 {
    let columns = 3;
    let each = width / columns as f64;
    let rows = events.len().div_ceil(columns);
    for (index, (at_ms, text)) in events.iter().enumerate() {
        let (column, row) = (index / rows.max(1), index % rows.max(1));
        let place = (at.0 + column as f64 * each, at.1 + row as f64 * 16.0);
        let number = index + 1;
        let mut text = format!("{number}  {}  {text}", clock(*at_ms).trim());
        while width_of(&text, 11.0) > each - 8.0 {
            text.pop();
        }
        canvas.text(place, Type::new(11.0, INK), &text);
    }
    at.1 + rows as f64 * 16.0
}
