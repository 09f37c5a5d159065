//! Reaches and heights that C. Theobald measured (Fire Safety Journal 4, 1981), as kept in the repository
//! `firemodels/exp` on GitHub.
//!
//! Smooth nozzles 6, 7, 9 and 10 of that paper. The validation of FDS, which uses the same data, puts the ground 3 m
//! below the nozzle; so do we.

use lafet_sim::jet::Jet;
use lafet_sim::nozzle::SMOOTH_BORE;

const HEIGHT_M: f64 = 3.0;
/// Elevation of single reaches and of all heights, degrees.
const HIGH_DEG: f64 = 35.0;

/// A nozzle, its outlet in mm, bar, and a figure in m.
type Single = (u8, f64, f64, f64);

/// A nozzle, its outlet in mm, bar, and the greatest reaches in m at [`ELEVATIONS_DEG`].
const BY_ELEVATION: &[(u8, f64, f64, [f64; 6])] = &[
    (7, 13.0, 2.1, [21.2, 21.9, 23.3, 24.4, 25.3, 23.4]),
    (7, 13.0, 4.1, [32.0, 32.5, 34.8, 34.4, 34.0, 31.7]),
    (7, 19.0, 2.8, [30.5, 32.2, 34.8, 35.1, 36.3, 34.9]),
    (7, 19.0, 4.8, [42.0, 43.3, 44.1, 45.4, 45.6, 44.8]),
    (7, 25.4, 4.1, [44.3, 46.3, 48.0, 48.8, 48.2, 46.7]),
    (7, 25.4, 6.2, [54.3, 55.6, 56.5, 56.4, 56.3, 54.7]),
    (9, 13.0, 2.1, [21.6, 23.0, 24.3, 24.4, 25.5, 24.8]),
    (9, 13.0, 4.1, [30.4, 31.0, 32.1, 33.5, 33.2, 32.3]),
    (9, 19.0, 2.8, [29.4, 30.7, 31.7, 34.1, 32.0, 30.9]),
    (9, 19.0, 4.8, [38.0, 38.6, 40.4, 40.8, 41.0, 40.6]),
    (9, 25.4, 4.1, [40.9, 41.4, 42.1, 44.2, 41.6, 40.7]),
    (9, 25.4, 6.2, [49.1, 50.2, 51.1, 51.8, 49.9, 47.4]),
];
const ELEVATIONS_DEG: [f64; 6] = [20.0, 25.0, 30.0, 35.0, 40.0, 45.0];

/// Greatest reaches at [`HIGH_DEG`] alone.
const REACHES: &[Single] = &[
    (7, 13.0, 2.8, 28.7),
    (7, 13.0, 6.2, 36.6),
    (7, 19.0, 2.1, 32.0),
    (7, 19.0, 4.1, 44.2),
    (7, 19.0, 6.2, 50.3),
    (7, 25.4, 2.1, 32.0),
    (7, 25.4, 2.8, 38.1),
    (9, 13.0, 2.8, 27.7),
    (9, 13.0, 6.2, 35.0),
    (9, 19.0, 2.1, 29.0),
    (9, 19.0, 4.1, 38.1),
    (9, 19.0, 6.2, 42.7),
    (9, 25.4, 2.1, 30.5),
    (9, 25.4, 2.8, 36.0),
    (10, 13.5, 2.1, 26.4),
    (10, 13.5, 2.8, 28.8),
    (10, 13.5, 4.1, 34.7),
    (6, 13.5, 2.1, 21.2),
];

/// Greatest heights at [`HIGH_DEG`].
const HEIGHTS: &[Single] = &[
    (7, 13.0, 2.1, 8.8),
    (7, 13.0, 2.8, 10.1),
    (7, 13.0, 4.1, 12.5),
    (7, 13.0, 6.2, 13.4),
    (7, 19.0, 2.1, 9.1),
    (7, 19.0, 2.8, 10.4),
    (7, 19.0, 4.1, 13.4),
    (7, 19.0, 6.2, 14.6),
    (7, 25.4, 2.1, 9.7),
    (7, 25.4, 4.1, 14.6),
    (7, 25.4, 6.2, 17.7),
    (9, 13.0, 2.1, 8.5),
    (9, 13.0, 2.8, 9.4),
    (9, 13.0, 4.1, 11.6),
    (9, 13.0, 6.2, 12.5),
    (9, 19.0, 2.8, 10.0),
    (9, 19.0, 4.1, 12.8),
    (9, 25.4, 2.1, 9.4),
    (9, 25.4, 4.1, 13.7),
    (9, 25.4, 6.2, 16.4),
];

/// Nozzles and outlets, in the order of the table.
pub const GROUPS: [(u8, f64); 8] =
    [(7, 13.0), (7, 19.0), (7, 25.4), (10, 13.5), (9, 13.0), (9, 19.0), (9, 25.4), (6, 13.5)];

/// A measured figure of a jet.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Number of the nozzle in the paper.
    nozzle: u8,
    outlet_mm: f64,
    /// Pressure, bar.
    pub bar: f64,
    /// Elevation, degrees.
    pub elevation_deg: f64,
    /// Reach or height, m.
    pub metres: f64,
}

impl Measured {
    /// The jet, with the constants of smooth bores.
    pub fn jet(&self) -> Jet {
        let solid = Jet::solid(self.bar / 10.0, self.outlet_mm, self.elevation_deg.to_radians());
        Jet { family: SMOOTH_BORE, height_m: HEIGHT_M, ..solid }
    }

    /// Whether it is of a nozzle and outlet.
    pub fn is_of(&self, (nozzle, outlet_mm): (u8, f64)) -> bool {
        (self.nozzle, self.outlet_mm) == (nozzle, outlet_mm)
    }
}

fn single(&(nozzle, outlet_mm, bar, metres): &Single) -> Measured {
    Measured { nozzle, outlet_mm, bar, elevation_deg: HIGH_DEG, metres }
}

/// Greatest reaches.
pub fn reaches() -> Vec<Measured> {
    let series = |&(nozzle, outlet_mm, bar, reaches): &(u8, f64, f64, [f64; 6])| {
        let points = ELEVATIONS_DEG.into_iter().zip(reaches);
        points.map(move |(elevation_deg, metres)| Measured {
            nozzle,
            outlet_mm,
            bar,
            elevation_deg,
            metres,
        })
    };
    BY_ELEVATION.iter().flat_map(series).chain(REACHES.iter().map(single)).collect()
}

/// Greatest heights.
pub fn heights() -> Vec<Measured> {
    HEIGHTS.iter().map(single).collect()
}
