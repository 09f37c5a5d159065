//! `lafet throw`: how far a jet reaches, with its band of uncertainty.

use clap::{ArgGroup, Args};
use lafet_sim::throw::{Figure, Kind, PRESSURE_MPA, Refusal, Shot, Size, Throw, noted, refused};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::lang::{current, decimals};
use crate::out::{Out, columns};

/// Most lines of a table.
const LINES_MAX: usize = 200;
/// Least step of a table, degrees.
const STEP_LEAST: f64 = 0.1;

/// Arguments of `lafet throw`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("size").required(true).args(["flow", "outlet"]),
    after_help = "Examples:\n  lafet throw --flow 20 --pressure 0.8 --elevation 30\n  \
                  lafet throw --flow 1200l/min --pressure 8bar --elevation 10..75 --step 5\n  \
                  lafet throw --kind smooth --outlet 19 --pressure 4.8bar --elevation 35 --wind 5"
)]
pub struct ThrowArgs {
    #[arg(long, value_name = "FLOW", value_parser = flow)]
    flow: Option<f64>,
    #[arg(long, value_name = "MM")]
    outlet: Option<f64>,
    #[arg(long, value_name = "PRESSURE", value_parser = pressure)]
    pressure: f64,
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = elevations)]
    elevation: Elevations,
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0)]
    step: f64,
    #[arg(long, value_name = "KIND", default_value = "monitor", value_parser = kind)]
    kind: Kind,
    #[arg(long, value_name = "MM", default_value_t = 60.0)]
    nozzle: f64,
    #[arg(long, value_name = "SPEED", default_value_t = 0.0)]
    wind: f64,
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0)]
    wind_from: f64,
    #[arg(long, value_name = "METRES", default_value_t = 1.5)]
    height: f64,
}

/// Elevations to compute, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Elevations {
    from: f64,
    to: f64,
}

/// Computes and shows the throw.
pub fn run(args: &ThrowArgs, out: &mut Out) -> Outcome {
    let shots = shots(args)?;
    let throws: Result<Vec<Throw>, Refusal> = shots.iter().map(Shot::throw).collect();
    let throws =
        throws.map_err(|problem| Failure::Usage(refused(&problem).of(current()).to_owned()))?;
    let simulator = simulator(&shots);
    out.show(text(&shots, &throws, &simulator), || as_json(&shots, &throws, &simulator))
}

/// The shots of the table, lowest elevation first.
fn shots(args: &ThrowArgs) -> Result<Vec<Shot>, Failure> {
    let Elevations { from, to } = args.elevation;
    let step = if args.step.is_finite() { args.step } else { 0.0 };
    let lines = if from < to { ((to - from) / step + 1e-9).floor() + 1.0 } else { 1.0 };
    if from < to && step < STEP_LEAST || lines > LINES_MAX as f64 {
        return Err(Failure::Usage(
            text::ThrowStep { step_least: STEP_LEAST, lines_max: LINES_MAX }.of(current()),
        ));
    }
    let size = match (args.outlet, args.flow) {
        (Some(outlet_mm), _) => Size::Outlet(outlet_mm),
        (None, flow_lps) => Size::Flow(flow_lps.unwrap_or_default()),
    };
    let shot = |line: usize| Shot {
        kind: args.kind,
        size,
        pressure_mpa: args.pressure,
        nozzle_mm: args.nozzle,
        elevation_deg: from + line as f64 * step,
        height_m: args.height,
        wind_mps: args.wind,
        wind_from_deg: args.wind_from,
    };
    Ok((0..lines as usize).map(shot).collect())
}

/// For a monitor: where the jet of the simulator and of `lafet coverage` has its middle, m.
fn simulator(shots: &[Shot]) -> Vec<Option<f64>> {
    let of = |shot: &Shot| match shot.kind {
        Kind::Monitor => shot.simulator_m().ok(),
        Kind::Smooth => None,
    };
    shots.iter().map(of).collect()
}

fn text(shots: &[Shot], throws: &[Throw], simulator: &[Option<f64>]) -> String {
    let (Some(shot), Some(throw)) = (shots.first(), throws.first()) else { return String::new() };
    let in_wind = shot.wind_mps > 0.0;
    let mut titles = vec![
        text::ThrowElevation.str(current()),
        text::ThrowMiddle.str(current()),
        text::ThrowGreatest.str(current()),
        text::ThrowTop.str(current()),
        text::ThrowFlight.str(current()),
    ];
    if in_wind {
        titles.push(text::ThrowAside.str(current()));
    }
    if simulator.iter().any(Option::is_some) {
        titles.push(text::ThrowSimulator.str(current()));
    }
    let mut rows = vec![titles.into_iter().map(str::to_owned).collect()];
    for ((shot, throw), simulator) in shots.iter().zip(throws).zip(simulator) {
        let figures = [throw.middle_m, throw.greatest_m, throw.top_m, throw.flight_s];
        let mut row = vec![format!("{}°", shot.elevation_deg)];
        row.extend(figures.map(banded));
        if in_wind {
            row.push(aside(throw.left_m.value));
        }
        row.extend(simulator.map(|middle_m| format!("{middle_m:.1}")));
        rows.push(row);
    }
    let mut lines = vec![head(shot, throw), String::new(), columns(&rows), String::new()];
    lines.push(text::ThrowLegend.str(current()).to_owned());
    lines.extend(notes(throws));
    if simulator.iter().any(Option::is_some) {
        lines.push(text::ThrowSimulatorLegend.str(current()).to_owned());
    }
    let text = lines.join("\n");
    decimals(text)
}

fn head(shot: &Shot, throw: &Throw) -> String {
    let kind = match shot.kind {
        Kind::Monitor => text::NozzleOfMonitor.str(current()),
        Kind::Smooth => text::SmoothBore.str(current()),
    };
    let (flow, outlet) = (throw.flow_lps, throw.outlet_mm);
    let Shot { pressure_mpa, nozzle_mm, height_m, wind_mps, wind_from_deg, .. } = *shot;
    let wind = if wind_mps > 0.0 {
        text::WindFrom { wind_mps, wind_from_deg }.of(current())
    } else {
        text::StillAir.str(current()).to_owned()
    };
    text::ThrowConditions {
        kind,
        flow: format_args!("{flow:.1}"),
        pressure_mpa: format_args!("{pressure_mpa:.2}"),
        outlet: format_args!("{outlet:.1}"),
        nozzle_mm,
        height_m,
        wind,
    }
    .of(current())
}

/// A figure with its band: `34.7 (28.4…41.6)`.
fn banded(figure: Figure) -> String {
    let Figure { value, low, high } = figure;
    format!("{value:.1} ({low:.1}…{high:.1})")
}

fn aside(left_m: f64) -> String {
    let way = left_m.abs();
    let side =
        if left_m > 0.0 { text::WindLeft.str(current()) } else { text::WindRight.str(current()) };
    if way < 0.05 { "0.0".to_owned() } else { format!("{way:.1} {side}") }
}

/// What the bands do not cover, each once.
fn notes(throws: &[Throw]) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    for note in throws.iter().flat_map(|throw| throw.notes).flatten() {
        let note = noted(note);
        let note = note.of(current());
        if !notes.iter().any(|known| known == note) {
            notes.push(note.to_owned());
        }
    }
    notes
}

fn as_json(shots: &[Shot], throws: &[Throw], simulator: &[Option<f64>]) -> Value {
    let (Some(shot), Some(throw)) = (shots.first(), throws.first()) else { return Value::Null };
    let banded = |it: Figure| json!({ "value": rounded(it.value), "low": rounded(it.low), "high": rounded(it.high) });
    let lines = shots.iter().zip(throws).zip(simulator).map(|((shot, throw), simulator)| {
        json!({
            "elevation_deg": rounded(shot.elevation_deg),
            "middle_m": banded(throw.middle_m),
            "greatest_m": banded(throw.greatest_m),
            "top_m": banded(throw.top_m),
            "flight_s": banded(throw.flight_s),
            "left_m": rounded(throw.left_m.value),
            "simulator_middle_m": simulator.map(rounded),
        })
    });
    json!({
        "kind": match shot.kind {
            Kind::Monitor => "monitor",
            Kind::Smooth => "smooth",
        },
        "flow_lps": rounded(throw.flow_lps),
        "pressure_mpa": shot.pressure_mpa,
        "outlet_mm": rounded(throw.outlet_mm),
        "nozzle_mm": shot.nozzle_mm,
        "height_m": shot.height_m,
        "wind_mps": shot.wind_mps,
        "wind_from_deg": shot.wind_from_deg,
        "throws": lines.collect::<Vec<_>>(),
        "notes": notes(throws),
    })
}

/// Two decimals; no -0.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0 + 0.0
}

/// A number with one of the units, in the first unit; without one it is in that.
fn measure(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim().to_lowercase();
    let unit = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
    let (number, size) = unit.unwrap_or((&text, 1.0));
    number.trim().parse::<f64>().ok().filter(|value| value.is_finite()).map(|value| value * size)
}

/// Parses a flow, l/s.
fn flow(text: &str) -> Result<f64, String> {
    let minute = 1.0 / 60.0;
    measure(text, &[("l/min", minute), ("л/мин", minute), ("l/s", 1.0), ("л/с", 1.0)])
        .ok_or_else(|| text::FlowExpected.str(current()).into())
}

/// Parses a pressure, MPa.
fn pressure(text: &str) -> Result<f64, String> {
    let [least, most] = PRESSURE_MPA;
    measure(text, &[("mpa", 1.0), ("мпа", 1.0), ("bar", 0.1), ("бар", 0.1)])
        .filter(|mpa| (least..=most + 1e-9).contains(mpa))
        .map(|mpa| mpa.min(most))
        .ok_or_else(|| {
            let (bar_least, bar_most) = (least * 10.0, most * 10.0);
            text::PressureExpected { least, most, bar_least, bar_most }.of(current())
        })
}

/// Parses an elevation, degrees, or two of them: `10..75`.
fn elevations(text: &str) -> Result<Elevations, String> {
    let degrees = |text: &str| measure(text, &[("deg", 1.0), ("°", 1.0), ("град", 1.0)]);
    let found = match text.split_once("..") {
        Some((from, to)) => degrees(from).zip(degrees(to)),
        None => degrees(text).map(|only| (only, only)),
    };
    found
        .filter(|(from, to)| from <= to)
        .map(|(from, to)| Elevations { from, to })
        .ok_or_else(|| text::ElevationExpected.str(current()).into())
}

fn kind(text: &str) -> Result<Kind, String> {
    match text {
        "monitor" => Ok(Kind::Monitor),
        "smooth" => Ok(Kind::Smooth),
        _ => Err(text::NozzleKindExpected.str(current()).into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units() {
        for (text, lps) in
            [("20", 20.0), ("1200l/min", 20.0), ("1200 Л/мин", 20.0), ("20 l/s", 20.0)]
        {
            assert!((flow(text).unwrap() - lps).abs() < 1e-9, "{text}");
        }
        for (text, mpa) in [("0.8", 0.8), ("8bar", 0.8), ("20 бар", 2.0), ("0.8MPa", 0.8)] {
            assert!((pressure(text).unwrap() - mpa).abs() < 1e-9, "{text}");
        }
        for bad in ["", "x", "nan", "inf", "20gpm"] {
            assert!(
                flow(bad).is_err() && pressure(bad).is_err() && elevations(bad).is_err(),
                "{bad}"
            );
        }
        assert!(pressure("8").unwrap_err().contains("8bar") && pressure("0.1").is_err());
    }

    #[test]
    fn elevations_are_one_or_a_table() {
        assert_eq!(elevations("-5"), Ok(Elevations { from: -5.0, to: -5.0 }));
        assert_eq!(elevations("10..75"), Ok(Elevations { from: 10.0, to: 75.0 }));
        assert_eq!(elevations("10°..75°"), Ok(Elevations { from: 10.0, to: 75.0 }));
        assert!(elevations("75..10").is_err() && elevations("10..").is_err());
    }
}
