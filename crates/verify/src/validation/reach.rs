//! Middle and greatest reach beside published figures: which rows the law is fitted to, and which test it.

use lafet_sim::jet::Jet;
use lafet_sim::nozzle::{Family, MAKERS, SMOOTH_BORE};
use lafet_sim::throw::{MONITOR_GREATEST, SMOOTH_GREATEST, SMOOTH_MIDDLE, SMOOTH_TOP};

use super::measured::{self, Measured};
use super::{Table, percent};

const PSI_MPA: f64 = 0.006_894_757;
const INCH_MM: f64 = 25.4;
const FOOT_M: f64 = 0.3048;
const ELEVATION_DEG: f64 = 30.0;
/// Heights of nozzles that no source states: in hand, of a monitor, of the roof of a vehicle, m.
const HAND_M: f64 = 1.0;
const MONITOR_M: f64 = 1.5;
const ROOF_M: f64 = 3.5;
/// Reach grows with about this power of the size of the lumps; steps of a fit.
const GROWTH: f64 = 0.45;
const FIT_STEPS: usize = 12;
const TENTH: f64 = 0.1;

/// What a published figure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Is {
    /// The middle of the wetted ground.
    Middle,
    /// The outermost water.
    Greatest,
    /// The outermost water lands at this distance or beyond.
    AtLeast,
}

/// A published reach.
#[derive(Clone, Copy, Debug)]
struct Row {
    source: &'static str,
    jet: Jet,
    metres: f64,
    is: Is,
}

impl Row {
    /// The figure of the model with a size of the lumps, m.
    fn with(&self, lump: f64) -> f64 {
        let jet = Jet { family: Family { lump, ..self.jet.family }, ..self.jet };
        if self.is == Is::Middle { jet.landing().range_m() } else { jet.reach_m() }
    }

    fn model(&self) -> f64 {
        self.with(self.jet.family.lump)
    }

    fn error(&self) -> f64 {
        self.model() / self.metres - 1.0
    }
}

fn jet(family: Family, nozzle_mm: f64, pressure_mpa: f64, height_m: f64) -> Jet {
    let solid = Jet::solid(pressure_mpa, nozzle_mm, ELEVATION_DEG.to_radians());
    Jet { family, height_m, ..solid }
}

/// Smooth bores in hand, whose throws are the middle.
fn hand() -> Vec<Row> {
    let given = |nozzle_mm: f64, lps: f64, metres: f64| {
        let pressure_mpa = SMOOTH_BORE.pressure_mpa(nozzle_mm, lps);
        let jet = jet(SMOOTH_BORE, nozzle_mm, pressure_mpa, HAND_M);
        Row { source: "hand nozzle [given]", jet, metres, is: Is::Middle }
    };
    let hague = jet(SMOOTH_BORE, 1.125 * INCH_MM, 45.0 * PSI_MPA, HAND_M);
    vec![
        given(16.0, 5.5, 33.0),
        given(12.0, 3.6, 28.0),
        given(19.0, 7.4, 32.0),
        Row { source: "hand nozzle [Hague]", jet: hague, metres: 120.0 * FOOT_M, is: Is::Middle },
    ]
}

fn flowing(
    source: &'static str,
    family: Family,
    (lps, pressure_mpa): (f64, f64),
    height_m: f64,
    metres: f64,
) -> Row {
    let nozzle_mm = family.outlet_mm(lps, pressure_mpa);
    Row { source, jet: jet(family, nozzle_mm, pressure_mpa, height_m), metres, is: Is::Greatest }
}

/// Monitors of makers, by their sources.
fn makers() -> Vec<Row> {
    let row =
        |source, lps, mpa, height, metres| flowing(source, MAKERS, (lps, mpa), height, metres);
    vec![
        row("monitor [given]", 20.0, 0.8, MONITOR_M, 42.0),
        row("monitor [given]", 20.0, 0.9, MONITOR_M, 42.0),
        row("monitor [given]", 20.0, 1.0, MONITOR_M, 42.0),
        row("RM15C [Linz]", 25.0, 1.0, MONITOR_M, 45.0),
        row("RM60C [Linz]", 100.0, 1.0, ROOF_M, 80.0),
        row("RM80 [Dresden]", 100.0, 1.4, ROOF_M, 85.0),
        row("RM35C [RM]", 3500.0 / 60.0, 1.0, ROOF_M, 70.0),
        row("RM35 [RM]", 4750.0 / 60.0, 1.0, ROOF_M, 85.0),
        row("RM80 [RM]", 150.0, 1.0, ROOF_M, 100.0),
    ]
}

/// A lower bound, which is no figure to fit to.
fn bound() -> Row {
    let row = flowing("monitor [given]", MAKERS, (40.0, 0.8), MONITOR_M, 60.0);
    Row { is: Is::AtLeast, ..row }
}

/// Water cannons of the police, up to 2 MPa.
fn cannons() -> Vec<Row> {
    let row = |source, lps, mpa| flowing(source, SMOOTH_BORE, (lps, mpa), ROOF_M, 65.0);
    vec![row("PSV 900 [AT5], [NH]", 1100.0 / 60.0, 1.5), row("WaWe 10 000 [AT5], [taz]", 20.0, 2.0)]
}

/// Measured reaches.
fn theobald() -> Vec<Row> {
    let row = |it: &Measured| Row {
        source: "[Theobald]",
        jet: it.jet(),
        metres: it.metres,
        is: Is::Greatest,
    };
    measured::reaches().iter().map(row).collect()
}

/// The size of the lumps with which the mean of the logarithmic errors is zero.
fn fitted<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> f64 {
    let count = rows.clone().count() as f64;
    let mut lump = SMOOTH_BORE.lump;
    for _ in 0..FIT_STEPS {
        let errors = rows.clone().map(|row| libm::log(row.metres / row.with(lump)));
        lump *= libm::exp(errors.sum::<f64>() / count / GROWTH);
    }
    lump
}

/// A row that was left out of a fit: the constant of the others, and the error of this one.
struct LeftOut {
    lump: f64,
    error: f64,
}

/// Leaves out, of each row, those that `together` puts with it.
fn left_out(rows: &[Row], together: impl Fn(usize, usize) -> bool) -> Vec<LeftOut> {
    let of = |(index, row): (usize, &Row)| {
        let kept = rows.iter().enumerate().filter(|(other, _)| !together(index, *other));
        let lump = fitted(kept.map(|(_, row)| row));
        LeftOut { lump, error: row.with(lump) / row.metres - 1.0 }
    };
    rows.iter().enumerate().map(of).collect()
}

fn one_by_one(rows: &[Row]) -> Vec<LeftOut> {
    left_out(rows, |one, other| one == other)
}

fn by_source(rows: &[Row]) -> Vec<LeftOut> {
    let of = |index: usize| rows[index].source.split_once('[').map(|(_, source)| source);
    left_out(rows, |one, other| of(one) == of(other))
}

fn errors(left_out: &[LeftOut]) -> Vec<f64> {
    left_out.iter().map(|it| it.error).collect()
}

/// Number within a tenth, root of the mean square, and the error farthest from zero.
fn summed_up(errors: &[f64]) -> (usize, f64, f64) {
    let within = errors.iter().filter(|error| error.abs() <= TENTH).count();
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let worst = errors.iter().fold(0.0, |w: f64, e| if e.abs() > w.abs() { *e } else { w });
    (within, libm::sqrt(squares / errors.len().max(1) as f64), worst)
}

fn cells(errors: &[f64]) -> [String; 4] {
    let (within, rms, worst) = summed_up(errors);
    [
        errors.len().to_string(),
        within.to_string(),
        format!("{:.1} %", rms * 100.0),
        format!("{:+.1} %", worst * 100.0),
    ]
}

/// Published figures row by row.
pub fn rows() -> String {
    let mut table = Table::new(&[
        "source",
        "outlet, mm",
        "pressure, MPa",
        "flow, l/s",
        "published, m",
        "which is the",
        "middle, m",
        "greatest, m",
        "error",
    ]);
    let all = [hand(), makers(), vec![bound()], cannons()].concat();
    for row in &all {
        let Row { jet, metres, is, .. } = row;
        let (sign, what) = match is {
            Is::Middle => ("", "middle"),
            Is::Greatest => ("", "greatest"),
            Is::AtLeast => ("≥ ", "greatest"),
        };
        table.row(&[
            row.source.to_owned(),
            format!("{:.1}", jet.nozzle_mm),
            format!("{:.2}", jet.pressure_mpa),
            format!("{:.1}", jet.family.flow_lps(jet.nozzle_mm, jet.pressure_mpa)),
            format!("{sign}{metres:.1}"),
            what.to_owned(),
            format!("{:.1}", jet.landing().range_m()),
            format!("{:.1}", jet.reach_m()),
            percent(row.model(), *metres),
        ]);
    }
    table.0
}

/// Measured reaches and heights by nozzle and outlet.
pub fn nozzles() -> String {
    let mut table = Table::new(&[
        "nozzle",
        "outlet, mm",
        "pressures, MPa",
        "elevations",
        "reaches",
        "within ±10 %",
        "rms",
        "worst",
        "heights: number, worst",
    ]);
    for group in measured::GROUPS {
        let rows = measured::reaches().into_iter().filter(|it| it.is_of(group));
        let rows: Vec<Measured> = rows.collect();
        let errors: Vec<f64> = rows.iter().map(|it| it.jet().reach_m() / it.metres - 1.0).collect();
        let heights: Vec<f64> =
            measured::heights().iter().filter(|it| it.is_of(group)).map(height_error).collect();
        let span = |of: &dyn Fn(&Measured) -> f64| {
            let values = rows.iter().map(of);
            (values.clone().fold(f64::MAX, f64::min), values.fold(0.0, f64::max))
        };
        let pressures = match span(&|it| it.bar / 10.0) {
            (least, most) if least < most => format!("{least:.2}–{most:.2}"),
            (least, _) => format!("{least:.2}"),
        };
        let elevations = match span(&|it| it.elevation_deg) {
            (least, most) if least < most => format!("{least:.0}–{most:.0}°"),
            (least, _) => format!("{least:.0}°"),
        };
        let [count, within, rms, worst] = cells(&errors);
        let high = match summed_up(&heights) {
            (_, _, worst) if !heights.is_empty() => {
                format!("{}, {:+.1} %", heights.len(), worst * 100.0)
            }
            _ => "—".to_owned(),
        };
        let (nozzle, outlet_mm) = group;
        table.row(&[
            nozzle.to_string(),
            format!("{outlet_mm}"),
            pressures,
            elevations,
            count,
            within,
            rms,
            worst,
            high,
        ]);
    }
    table.0
}

fn height_error(it: &Measured) -> f64 {
    it.jet().top_m() / it.metres - 1.0
}

/// What the law says of rows that its constant was not fitted to.
pub fn cross() -> String {
    let mut table = Table::new(&[
        "left out",
        "fitted to the rest",
        "k of the lumps",
        "rows left out",
        "within ±10 %",
        "rms",
        "worst",
    ]);
    let mut add = |what: &str, fit: &str, lumps: &[LeftOut], errors: &[f64]| {
        let of =
            |pick: fn(f64, f64) -> f64, start| lumps.iter().map(|it| it.lump).fold(start, pick);
        let lump = match lumps {
            [] => format!("{}", SMOOTH_BORE.lump),
            _ => format!("{:.1}–{:.1}", of(f64::min, f64::MAX), of(f64::max, 0.0)),
        };
        let [count, within, rms, worst] = cells(errors);
        table.row(&[what.to_owned(), fit.to_owned(), lump, count, within, rms, worst]);
    };
    let (hand, makers) = (one_by_one(&hand()), one_by_one(&makers()));
    let sources = by_source(&self::makers());
    add("middle of smooth bores, row by row", "the other 3 rows", &hand, &errors(&hand));
    add("greatest of monitors, row by row", "the other 8 rows", &makers, &errors(&makers));
    add("greatest of monitors, source by source", "the other sources", &sources, &errors(&sources));
    let out = |rows: &[Row]| rows.iter().map(Row::error).collect::<Vec<_>>();
    let none = "the middle of smooth bores only";
    add("greatest of water cannons, 1.5 and 2 MPa", none, &[], &out(&cannons()));
    add("greatest of smooth bores, [Theobald]", none, &[], &out(&theobald()));
    let heights: Vec<f64> = measured::heights().iter().map(height_error).collect();
    add("top of smooth bores, [Theobald]", none, &[], &heights);
    table.0
}

/// Constants, rows, and the bands that follow.
pub fn summary() -> String {
    let mut table = Table::new(&[
        "figure",
        "rows",
        "within ±10 %",
        "worst",
        "constants fitted to them",
        "published over computed, rows left out",
        "band of `lafet throw`",
    ]);
    let band = |[least, most]: [f64; 2]| format!("{least:.2}–{most:.2}");
    let mut add = |figure: &str, errors: &[f64], fitted: &str, out: &[f64], used: [f64; 2]| {
        let [count, within, _, worst] = cells(errors);
        let cells = [figure.to_owned(), count, within, worst, fitted.to_owned()];
        table.row(&[cells.as_slice(), &[band(ratios(out)), band(used)]].concat());
    };
    let of = |rows: &[Row]| rows.iter().map(Row::error).collect::<Vec<_>>();
    let measured = of(&[cannons(), theobald()].concat());
    let heights: Vec<f64> = measured::heights().iter().map(height_error).collect();
    let hand_out = errors(&one_by_one(&hand()));
    let makers_out = errors(&by_source(&makers()));
    add("middle, smooth bores", &of(&hand()), "see the text", &hand_out, SMOOTH_MIDDLE);
    add("greatest, monitors", &of(&makers()), "1", &makers_out, MONITOR_GREATEST);
    add("greatest, smooth bores", &measured, "none", &measured, SMOOTH_GREATEST);
    add("top, smooth bores", &heights, "none", &heights, SMOOTH_TOP);
    table.0
}

/// Least and greatest of published over computed.
fn ratios(errors: &[f64]) -> [f64; 2] {
    let ratios = errors.iter().map(|error| 1.0 / (1.0 + error));
    [ratios.clone().fold(f64::MAX, f64::min), ratios.fold(0.0, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Middle and greatest reach of the published rows, 2 MPa included.
    #[test]
    fn published_rows_within_a_tenth() {
        for row in [hand(), makers(), vec![bound()], cannons()].concat() {
            let (source, error) = (row.source, row.error());
            assert!(error.abs() <= TENTH, "{source} {:.1} m: {error:+.3}", row.metres);
        }
    }

    /// The factor of the monitors is the one that fits them.
    #[test]
    fn the_factor_of_monitors_is_fitted() {
        let lump = fitted(makers().iter());
        assert!((lump - MAKERS.lump).abs() < 0.05, "{lump}");
    }

    /// What docs/physics.md says of the rows that are no part of any fit.
    #[test]
    fn rows_kept_out() {
        let out = |rows: &[Row]| rows.iter().map(Row::error).collect::<Vec<_>>();
        let (within, rms, _) = summed_up(&out(&theobald()));
        assert!(theobald().len() == 90 && within >= 70 && rms < 0.09, "{within} {rms}");
        assert_eq!(summed_up(&out(&cannons())).0, 2);
        let of_groups = |it: &Measured| measured::GROUPS.iter().any(|group| it.is_of(*group));
        assert!(measured::reaches().iter().chain(&measured::heights()).all(of_groups));
        let heights: Vec<f64> = measured::heights().iter().map(height_error).collect();
        let (within, rms, _) = summed_up(&heights);
        assert!(heights.len() == 20 && within >= 19 && rms < 0.05, "{within} {rms}");
        let (_, rms, worst) = summed_up(&errors(&by_source(&makers())));
        assert!(rms < 0.06 && worst.abs() < 0.11, "{rms} {worst}");
    }

    /// The bands that users see hold all rows that were left out, and are not much wider.
    #[test]
    fn bands_are_those_of_the_rows() {
        let heights: Vec<f64> = measured::heights().iter().map(height_error).collect();
        let measured: Vec<f64> = [cannons(), theobald()].concat().iter().map(Row::error).collect();
        for (what, errors, [low, high]) in [
            ("middle", errors(&one_by_one(&hand())), SMOOTH_MIDDLE),
            ("monitors", errors(&by_source(&makers())), MONITOR_GREATEST),
            ("measured", measured, SMOOTH_GREATEST),
            ("top", heights, SMOOTH_TOP),
        ] {
            let [least, most] = ratios(&errors);
            assert!(low <= least && least < low + 0.015, "{what}: {least} {low}");
            assert!(most <= high && high < most + 0.015, "{what}: {most} {high}");
        }
    }
}
