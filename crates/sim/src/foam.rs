//! Foam on burning fuel: what it is like, and the blanket that it makes.
//!
//! A blanket holds b litres of solution on each m² of the pool, b·E mm thick (E: expansion). It
//! flows over the surface: from 15 mm on it covers everything, c = min(1, b·E/15 mm) of it before.
//! While r l/(s·m²) of solution arrive and the fire has the heat i,
//! db/dt = max(r − 0.03·i, 0) − 0.0135·i·c − k·b − 0.5·w·c:
//! - flames destroy what falls on the open fuel, up to 0.03 l/(s·m²): the critical rate, under
//!   which nothing stays;
//! - their radiation, 35 kW/m² over the 2600 kJ/l that evaporating takes, eats the edge of the
//!   blanket: burn-back;
//! - it drains: k = ln(4/3)/t, t being the time in which a quarter of the solution has left it;
//! - water that falls on it, w l/(s·m²), washes half as much away.
//!
//! The blanket is one for the whole pool: foam is known to flow over 30 m. The figures are ours;
//! docs/physics.md compares what follows from them with published rates and times.

/// What the foam of a site is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foam {
    /// Litres of foam out of a litre of solution.
    pub expansion: f64,
    /// Until a quarter of the solution has drained out of it, s.
    pub quarter_s: f64,
}

impl Foam {
    /// A film-forming foam out of the nozzle of a monitor.
    pub const FILM: Self = Self { expansion: 6.0, quarter_s: 180.0 };
}

impl Default for Foam {
    fn default() -> Self {
        Self::FILM
    }
}

/// What reaches a pool in a step, and how it burns.
#[derive(Clone, Copy, Debug)]
pub struct Falling {
    /// Solution, l/(s·m²).
    pub solution: f64,
    /// Water without foam, l/(s·m²).
    pub water: f64,
    /// Heat of the fire, 0 out … 1 full.
    pub heat: f64,
}

/// Foam on a pool.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blanket {
    /// Solution in it, l/m².
    solution_l_m2: f64,
}

/// From here on it covers everything, mm.
const LAYER_MM: f64 = 15.0;
/// What a fire destroys of the foam that arrives, l/(s·m²).
pub const DESTROYED: f64 = 0.03;
const FLAME_KW_M2: f64 = 35.0;
const EVAPORATION_KJ_L: f64 = 2600.0;
const WASHED: f64 = 0.5;

impl Blanket {
    /// Part of the pool that it covers, 0 … 1.
    pub fn covered(&self, foam: &Foam) -> f64 {
        (self.thickness_mm(foam) / LAYER_MM).min(1.0)
    }

    /// How thick it is on the mean of the pool, mm.
    pub fn thickness_mm(&self, foam: &Foam) -> f64 {
        self.solution_l_m2 * foam.expansion
    }

    /// The pool has grown: the same foam on more of it.
    pub fn stretch(&mut self, part: f64) {
        self.solution_l_m2 *= part;
    }

    /// Foam arrives, drains, burns away; for `dt_s`.
    pub fn step(&mut self, foam: &Foam, falling: Falling, dt_s: f64) {
        let Falling { solution, water, heat } = falling;
        let covered = self.covered(foam);
        let stays = (solution - DESTROYED * heat).max(0.0);
        let eaten = FLAME_KW_M2 / EVAPORATION_KJ_L * heat * covered;
        let drained = libm::log(4.0 / 3.0) / foam.quarter_s * self.solution_l_m2;
        let washed = WASHED * water * covered;
        let change = stays - eaten - drained - washed;
        self.solution_l_m2 = (self.solution_l_m2 + change * dt_s).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOAM: Foam = Foam { expansion: 6.0, quarter_s: 180.0 };

    fn step(blanket: &mut Blanket, falling: (f64, f64, f64), seconds: u32) {
        let (solution, water, heat) = falling;
        for _ in 0..seconds * 10 {
            blanket.step(&FOAM, Falling { solution, water, heat }, 0.1);
        }
    }

    /// A quarter of the solution has left it after the time that says so; none is left for ever.
    #[test]
    fn drains() {
        let mut blanket = Blanket { solution_l_m2: 10.0 };
        step(&mut blanket, (0.0, 0.0, 0.0), 180);
        assert!((blanket.solution_l_m2 - 7.5).abs() < 0.01, "{blanket:?}");
        assert!((blanket.thickness_mm(&FOAM) - 45.0).abs() < 0.1 && blanket.covered(&FOAM) == 1.0);
        step(&mut blanket, (0.0, 0.0, 0.0), 1800);
        assert!((0.1..0.3).contains(&blanket.covered(&FOAM)), "{blanket:?}");
    }

    /// More expansion covers more with the same solution.
    #[test]
    fn expands() {
        let blanket = Blanket { solution_l_m2: 1.0 };
        assert!((blanket.covered(&FOAM) - 0.4).abs() < 1e-9);
        assert!((blanket.covered(&Foam { expansion: 9.0, ..FOAM }) - 0.6).abs() < 1e-9);
    }

    /// Flames destroy all foam up to the critical rate, and what water washes off is gone.
    #[test]
    fn is_destroyed() {
        let mut blanket = Blanket::default();
        step(&mut blanket, (0.03, 0.0, 1.0), 600);
        assert_eq!(blanket.solution_l_m2, 0.0);
        let (mut burnt, mut washed) =
            (Blanket { solution_l_m2: 3.0 }, Blanket { solution_l_m2: 3.0 });
        step(&mut burnt, (0.0, 0.0, 1.0), 60);
        step(&mut washed, (0.0, 0.1, 0.0), 60);
        let mut drained = Blanket { solution_l_m2: 3.0 };
        step(&mut drained, (0.0, 0.0, 0.0), 60);
        assert!(burnt.solution_l_m2 < drained.solution_l_m2 - 0.5, "{burnt:?} {drained:?}");
        assert!(washed.solution_l_m2 < drained.solution_l_m2 - 1.5, "{washed:?} {drained:?}");
    }
}
