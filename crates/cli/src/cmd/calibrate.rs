//! `lafet calibrate`: fits the monitor's ballistics to its jet, and fills the correction table.

use clap::{ArgGroup, Args};
use lafet_proto::request::Body;
use lafet_proto::{Bytes, Ints, ParamId, SubsystemId};
use lafet_sim::calibration::{self, Fit, Shot, TABLE_LEN};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::cli::Global;
use crate::connect::Connection;
use crate::describe::tenths;
use crate::failure::{Failure, Outcome};
use crate::lang::{current, decimal, decimals};
use crate::out::{Out, columns};

/// Height of the nozzle assumed without a monitor, m.
const HEIGHT_M: f64 = 1.5;
/// First entries of the two requests that carry the table: the size of a request is one byte, so it
/// does not fit into one.
const PARTS: [u8; 2] = [0, 128];
/// A fit that misses a shot by more than this is not fit to aim with, m.
const WORST_M: f64 = 3.0;

/// Arguments of `lafet calibrate`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("shots").required(true).args(["shot", "outlet"]),
    after_help = "Examples:\n  \
        lafet -c tcp://127.0.0.1:10485 calibrate --shot 7.9,5,29 --shot 7.9,15,39 \
        --shot 5.9,10,32\n  \
        lafet calibrate --outlet 28 --distance 35"
)]
pub struct CalibrateArgs {
    #[arg(long, value_name = "P,DEG,M", allow_hyphen_values = true, value_parser = shot)]
    shot: Vec<Shot>,
    #[arg(long, value_name = "MM", value_parser = outlet)]
    outlet: Option<f64>,
    #[arg(long, value_name = "METRES", default_value_t = 30)]
    distance: u8,
    #[arg(long)]
    dry_run: bool,
}

/// Runs `lafet calibrate`: fits the ballistics, shows the result and writes it to the monitor.
pub async fn run(args: CalibrateArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = match &global.connect {
        Some(_) => Some(Connection::open(global).await?),
        None => None,
    };
    let height_cm = match &connection {
        Some(connection) => {
            let values = connection.monitor.param(SubsystemId::CONTROL, "Height").await?;
            values.first().copied().unwrap_or_default()
        }
        None => (HEIGHT_M * 100.0) as i32,
    };
    let height_m = f64::from(height_cm) / 100.0;
    let shots = match args.outlet {
        Some(outlet_mm) => calibration::shoot(outlet_mm, height_m),
        None => args.shot,
    };
    let fit = calibration::fit(&shots, height_m).filter(|fit| fit.worst_m <= WORST_M);
    let fit = fit.ok_or_else(|| Failure::Ended(no_fit(&shots, height_m)))?;
    let table = calibration::table(fit.diameter_dmm, height_cm, args.distance)
        .ok_or_else(|| Failure::Ended(out_of_reach(args.distance)))?;
    let written = match connection {
        Some(connection) if !args.dry_run => {
            write(&connection, fit.diameter_dmm, &table).await?;
            true
        }
        _ => false,
    };
    let text = told(&shots, &fit, height_m, &table, args.distance, written);
    out.show(text, || {
        json!({
            "nozzle_diameter_mm": f64::from(fit.diameter_dmm) / 10.0,
            "height_m": height_m,
            "rms_m": rounded(fit.rms_m),
            "worst_m": rounded(fit.worst_m),
            "shots": shots.iter().map(|shot| shot_json(shot, &fit, height_m)).collect::<Vec<_>>(),
            "distance_m": args.distance,
            "corrections": table.to_vec(),
            "written": written,
        })
    })
}

/// Sets the parameter NozzleDiameter and the correction table; the monitor stores both.
async fn write(
    connection: &Connection,
    diameter_dmm: i32,
    table: &[i8; TABLE_LEN],
) -> Result<(), Failure> {
    let id = ParamId::of("NozzleDiameter");
    let values = [diameter_dmm];
    let body = Body::SetParam { id, values: Ints::Values(&values) };
    connection.ask(SubsystemId::CONTROL, body).await?;
    for (first, part) in PARTS.into_iter().zip(table.chunks(TABLE_LEN / PARTS.len())) {
        let bytes: Vec<u8> = part.iter().map(|degrees| degrees.to_le_bytes()[0]).collect();
        let body = Body::SetupCorrectionTable { first, corrections: Bytes(&bytes) };
        connection.ask(SubsystemId::CONTROL, body).await?;
    }
    Ok(())
}

fn told(
    shots: &[Shot],
    fit: &Fit,
    height_m: f64,
    table: &[i8; TABLE_LEN],
    distance_m: u8,
    written: bool,
) -> String {
    let diameter_mm = f64::from(fit.diameter_dmm) / 10.0;
    let (rms, worst, count) = (fit.rms_m, fit.worst_m, shots.len());
    let head = text::FittedDiameter {
        diameter_mm: decimal(diameter_mm, 1),
        count,
        rms: decimal(rms, 2),
        worst: decimal(worst, 2),
    }
    .of(current());
    let titles = [
        text::UnitAtm.fixed(),
        text::ThrowElevation.fixed(),
        text::ShotRange.fixed(),
        text::ShotMiss.fixed(),
    ];
    let mut rows = vec![titles.map(|title| title.of(current())).to_vec()];
    rows.extend(shots.iter().map(|shot| {
        let miss = calibration::miss_m(shot, fit.diameter_dmm, height_m);
        vec![
            tenths(shot.pressure_datm.into()),
            format!("{}°", decimal(shot.elevation_deg, 1)),
            decimal(shot.range_m, 1),
            miss.map_or("—".to_owned(), |miss| decimals(format!("{miss:+.2}"))),
        ]
    }));
    let degrees: Vec<String> = [30_usize, 40, 50, 60, 70, 80, 90, 100, 120]
        .iter()
        .map(|pressure| format!("{} → {}°", pressure / 10, table[*pressure]))
        .collect();
    let degrees = degrees.join(", ");
    let tail = text::FittedTable { distance_m, degrees }.of(current());
    let end = match written {
        true => text::WrittenToMonitor.str(current()),
        false => text::NothingWritten.str(current()),
    };
    format!("{head}\n{}\n{tail}\n{end}", columns(&rows))
}

fn shot_json(shot: &Shot, fit: &Fit, height_m: f64) -> Value {
    json!({
        "pressure_atm": f64::from(shot.pressure_datm) / 10.0,
        "elevation_deg": shot.elevation_deg,
        "range_m": rounded(shot.range_m),
        "miss_m": calibration::miss_m(shot, fit.diameter_dmm, height_m).map(rounded),
    })
}

fn rounded(metres: f64) -> f64 {
    (metres * 1000.0).round() / 1000.0
}

fn no_fit(shots: &[Shot], height_m: f64) -> String {
    let best = calibration::fit(shots, height_m);
    let worst = best.map_or_else(|| "—".to_owned(), |fit| decimal(fit.worst_m, 1));
    text::NoDiameterFits { worst }.of(current())
}

fn out_of_reach(distance_m: u8) -> String {
    text::JetTooShort { distance_m }.of(current())
}

/// Parses a shot, `pressure,elevation,range`: `7.9,15,39`.
fn shot(text: &str) -> Result<Shot, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [atm, elevation_deg, range_m]
            if text.split(',').count() == 3
                && (1.0..=25.0).contains(&atm)
                && (-15.0..=75.0).contains(&elevation_deg)
                && (1.0..=200.0).contains(&range_m) =>
        {
            let pressure_datm = (atm * 10.0).round() as u16;
            Ok(Shot { pressure_datm, elevation_deg, range_m })
        }
        _ => Err(text::ShotExpected.of(current())),
    }
}

/// Parses the diameter of an outlet, mm.
fn outlet(text: &str) -> Result<f64, String> {
    let known = calibration::DIAMETER_DMM;
    let (least, most) = (known.start() / 10, known.end() / 10);
    match text.parse::<f64>() {
        Ok(mm) if (f64::from(least)..=f64::from(most)).contains(&mm) => Ok(mm),
        _ => Err(text::MillimetresExpected { least, most }.of(current())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_are_read() {
        let read = shot("7.9, 15,39.5").unwrap();
        assert_eq!((read.pressure_datm, read.elevation_deg, read.range_m), (79, 15.0, 39.5));
        for bad in ["", "7.9,15", "7.9,15,x", "7.9,15,39,1", "0.1,15,39", "7.9,95,39", "79,15,0"] {
            assert!(shot(bad).is_err(), "{bad}");
        }
        assert_eq!(outlet("28"), Ok(28.0));
        assert!(outlet("5").is_err() && outlet("wide").is_err());
    }
}
