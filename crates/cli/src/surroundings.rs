//! Options for the surroundings of a simulated monitor, besides its fires: wind, and what misleads
//! or blinds the detector.

use clap::Args;
use lafet_sim::detector::{Glare, Wall};
use lafet_sim::sim::Config;
use lafet_texts::{Text, Words, cli as text};

use crate::lang::current;

/// Strongest mean wind, m/s; a hurricane reaches 33.
const WIND_MAX_MPS: f64 = 50.0;
/// Strongest gusts: beyond this intensity the wind has no meaningful direction.
const GUSTS_MAX: f64 = 0.5;

/// Wind, false sources and walls.
#[derive(Clone, Debug, Args)]
pub struct Surroundings {
    #[arg(long, value_name = "F,L", default_value = "0,0", allow_hyphen_values = true, value_parser = wind)]
    wind: (f64, f64),
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = gusts)]
    gusts: f64,
    #[arg(long, value_name = "GLARE", value_parser = glare)]
    glare: Vec<Glare>,
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
        .ok_or_else(|| text::WindExpected { wind_max_mps: WIND_MAX_MPS }.of(current()))
}

/// Parses an intensity of gusts.
fn gusts(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|share| (0.0..=GUSTS_MAX).contains(share))
        .ok_or_else(|| text::GustsExpected { gusts_max: GUSTS_MAX }.of(current()))
}

/// Parses a false source: `az=30,el=5,size=0.5,brightness=2000`.
fn glare(text: &str) -> Result<Glare, String> {
    text.parse().map_err(|error| told(error, text::GlareExpected))
}

/// Parses a wall: `from=-10,to=10,range=15,height=3`.
fn wall(text: &str) -> Result<Wall, String> {
    text.parse().map_err(|error| told(error, text::WallExpected))
}

/// An error message: what is wrong, and what to write.
pub fn told(error: Words, form: impl Text) -> String {
    format!("{}; {}", error.of(current()), text::WriteInstead { form }.of(current()))
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
