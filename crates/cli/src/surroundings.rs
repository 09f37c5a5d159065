//! Options for the surroundings of a simulated monitor, besides its fires: wind, and what misleads
//! or blinds the detector.

use core::fmt::Display;

use clap::Args;
use lafet_sim::detector::{Glare, Wall};
use lafet_sim::sim::Config;

use crate::lang::pick;

/// Strongest mean wind, m/s; a hurricane reaches 33.
const WIND_MAX_MPS: f64 = 50.0;
/// Strongest gusts: beyond this intensity the wind has no meaningful direction.
const GUSTS_MAX: f64 = 0.5;

/// Wind, false sources and walls.
#[derive(Clone, Debug, Args)]
pub struct Surroundings {
    /// Mean wind 10 m above ground: metres per second forward (as the barrel looks at 0°) and to
    /// the left; -5,0 is a head wind (default 0,0)
    #[arg(long, value_name = "F,L", default_value = "0,0", allow_hyphen_values = true, value_parser = wind)]
    wind: (f64, f64),
    /// Gusts: standard deviation of the wind's speed over its mean, 0 to 0.5; 0.15 is open country,
    /// 0.3 among buildings; none without --wind (default 0)
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = gusts)]
    gusts: f64,
    /// The sun or a hot machine, which the detector takes for a fire:
    /// az=DEGREES,el=DEGREES,size=DEGREES,brightness=N; a fire of 1.5 m at 25 m has 1400. May be
    /// repeated
    #[arg(long, value_name = "GLARE", value_parser = glare)]
    glare: Vec<Glare>,
    /// A wall that hides fires from the detector, not from the water:
    /// from=DEGREES,to=DEGREES,range=METRES,height=METRES. May be repeated
    #[arg(long, value_name = "WALL", value_parser = wall)]
    wall: Vec<Wall>,
}

impl Surroundings {
    /// A default configuration with these surroundings.
    pub fn config(self) -> Config {
        let Self { wind, gusts, glare, wall } = self;
        Config { wind, gusts, glares: glare, walls: wall, ..Config::default() }
    }
}

/// Parses a wind, m/s forward and left: `-5,2.5`.
fn wind(text: &str) -> Result<(f64, f64), String> {
    let speed =
        |text: &str| text.trim().parse().ok().filter(|speed: &f64| speed.abs() <= WIND_MAX_MPS);
    text.split_once(',')
        .and_then(|(forward, left)| Some((speed(forward)?, speed(left)?)))
        .ok_or_else(|| {
            pick(
                format!(
                    "expected metres per second forward and left, each at most {WIND_MAX_MPS}: \
                     -5,0 is a head wind"
                ),
                format!(
                    "ожидаются метры в секунду вперёд и влево, не более {WIND_MAX_MPS}: -5,0 — \
                     встречный ветер"
                ),
            )
        })
}

/// Parses an intensity of gusts.
fn gusts(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|share| (0.0..=GUSTS_MAX).contains(share)).ok_or_else(|| {
        pick(
            format!("expected a share of the mean wind, 0 to {GUSTS_MAX}; 0.15 is open country"),
            format!("ожидается доля среднего ветра, от 0 до {GUSTS_MAX}; 0.15 — открытое место"),
        )
    })
}

/// Parses a false source: `az=30,el=5,size=0.5,brightness=2000`.
fn glare(text: &str) -> Result<Glare, String> {
    text.parse().map_err(|error| {
        told(
            error,
            "az=DEGREES (left is positive, -360 to 360), el=DEGREES (-90 to 90), size=DEGREES \
             (above 0, to 90) and brightness=N (1 to 1000000): \
             az=30,el=5,size=0.5,brightness=2000",
            "az=ГРАДУСЫ (влево положительно, от -360 до 360), el=ГРАДУСЫ (от -90 до 90), \
             size=ГРАДУСЫ (больше 0, до 90) и brightness=N (от 1 до 1000000): \
             az=30,el=5,size=0.5,brightness=2000",
        )
    })
}

/// Parses a wall: `from=-10,to=10,range=15,height=3`.
fn wall(text: &str) -> Result<Wall, String> {
    text.parse().map_err(|error| {
        told(
            error,
            "from=DEGREES and to=DEGREES (its right and left end, -180 to 180), range=METRES and \
             height=METRES (above 0): from=-10,to=10,range=15,height=3",
            "from=ГРАДУСЫ и to=ГРАДУСЫ (правый и левый край, от -180 до 180), range=МЕТРЫ и \
             height=МЕТРЫ (больше 0): from=-10,to=10,range=15,height=3",
        )
    })
}

/// An error message: what is wrong, and what to write.
fn told(error: impl Display, english: &str, russian: &str) -> String {
    pick(format!("{error}; write {english}"), format!("пишите {russian}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surroundings_are_read() {
        assert_eq!(wind("-5, 2.5"), Ok((-5.0, 2.5)));
        assert_eq!(gusts("0.3"), Ok(0.3));
        assert_eq!(glare("el=5,az=30,size=0.5,brightness=2000").unwrap().azimuth_deg, 30.0);
        assert_eq!(wall("from=-10,to=10,range=15,height=3").unwrap().height_m, 3.0);
        for bad in ["", "5", "5,x", "51,0", "NaN,0"] {
            assert!(wind(bad).is_err(), "{bad}");
        }
        for bad in ["", "-0.1", "0.6", "NaN", "15%"] {
            assert!(gusts(bad).is_err(), "{bad}");
        }
        for bad in ["az=30", "az=30,el=95,size=1,brightness=9", "az=30,el=5,size=0,brightness=9"] {
            assert!(glare(bad).is_err(), "{bad}");
        }
        for bad in ["from=10,to=-10,range=15,height=3", "from=-10,to=10,range=0,height=3"] {
            assert!(wall(bad).is_err(), "{bad}");
        }
    }
}
