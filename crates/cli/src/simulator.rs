//! Options common to all commands that start a simulator.

use lafet_device::Composition;
use lafet_sim::fault::Fault;
use lafet_sim::fire::FireSpec;
use lafet_sim::sim::{Config, Sim};
use lafet_texts::{Text as _, cli as text};

use crate::lang::current;
use crate::surroundings;

/// Highest speed of simulated time, times real time.
const SPEED_MAX: f64 = 10_000.0;

/// Simulated time before the first request, in which the monitor reads its sensors, ms.
const POWER_UP_MS: u64 = 200;

/// A simulated monitor that has just started.
pub fn power_up(config: Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.advance_ms(POWER_UP_MS);
    sim
}

/// Names of the profiles: `full|remote|mini|ex|limit-switch`.
pub fn profiles() -> String {
    Composition::ALL.map(|profile| profile.name).join("|")
}

/// Parses a speed factor.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if speed > 0.0 && speed <= SPEED_MAX => Ok(speed),
        _ => Err(text::SpeedExpected { speed_max: SPEED_MAX }.of(current())),
    }
}

/// Parses a speed factor, or 0 for as fast as possible.
pub fn speed_or_zero(text: &str) -> Result<f64, String> {
    if text.parse() == Ok(0.0) { Ok(0.0) } else { speed(text) }
}

/// Parses the name of a profile.
pub fn profile(name: &str) -> Result<Composition, String> {
    Composition::by_name(name).copied().ok_or_else(|| {
        let known = profiles();
        text::ProfileExpected { known }.of(current())
    })
}

/// Parses the name of a fault: `horizontal-lag`.
pub fn fault(name: &str) -> Result<Fault, String> {
    Fault::from_name(name).ok_or_else(|| {
        let part = name.split('-').next().unwrap_or(name);
        let near: Vec<String> =
            Fault::all().map(Fault::name).filter(|known| known.starts_with(part)).collect();
        match near.is_empty() {
            true => text::NoSuchFault.of(current()),
            false => text::NoSuchFaultBut { known: near.join(", ") }.of(current()),
        }
    })
}

/// Parses a fire: `az=30,range=25,size=1.5`.
pub fn fire(text: &str) -> Result<FireSpec, String> {
    text.parse().map_err(|error| surroundings::told(error, text::FireExpected))
}

#[cfg(test)]
mod tests {
    use lafet_texts::Lang;

    use super::*;

    /// A fire that is given wrongly is answered with all that a fire can have.
    #[test]
    fn what_a_fire_can_have_is_named() {
        for (name, value) in [
            ("az", "30"),
            ("range", "25"),
            ("size", "2"),
            ("growth", "0.01"),
            ("reignites", "1"),
            ("lit", "0"),
            ("class", "hydrocarbon"),
        ] {
            let given = format!("az=0,range=20,{name}={value}");
            assert!(given.parse::<FireSpec>().is_ok(), "{given}");
            for lang in Lang::ALL {
                let named = text::FireExpected.str(lang).contains(&format!("{name}="));
                assert!(named, "{name} in {}", lang.code());
            }
        }
    }
}
