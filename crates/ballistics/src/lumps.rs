//! The jet as water that breaks into lumps of several sizes: where it lands, and on how much ground.
//!
//! - **Core.** The jet leaves with v₀ (see `nozzle`) and holds together over a path of
//!   L_b = 3.15·d·We^0.32·(1 − w)², We = ρ·v₀²·d/σ; gravity alone bends it, neither drag nor wind.
//! - **Lumps.** It breaks into lumps of five sizes of equal mass, q = 0.65 … 1.35 times
//!   D = k·d·√(d/28 mm)·We^(−0.2) / (1 + 9·w²). Small ones leave the core early, after
//!   0.75·L_b, big ones late, after 1.17·L_b. D is an effective size: clusters of drops that
//!   shelter each other, so it is larger than a drop.
//! - **Drag.** dv/dt = g − |r|·r/ℓ, ℓ = (4/3)·(ρ/ρ_air)·q·D/C_D, C_D = 0.6, r = (1 − α)·(v − u), u = wind
//!   at the height z of the water, u₁₀·(z/10 m)^(1/7).
//! - **Entrained air** moves with the water: a part α = 0.75·e^(−s/Λ) of its speed over the wind,
//!   s = path since break-up, Λ = 200·d·(1 − w)² (at least 0.2 m).
//! - Each size lands at z = 0; midpoint rule, 20 ms, last step cut linearly.
//!
//! The landing is the mean over the sizes. Footprint: an ellipse of uniform density; half-axes
//! √((2σ)² + b²) from the scatter σ of the sizes along and across the fall and from the cone,
//! b = 0.3 m + s·tan δ across and b / sin(angle of fall) along.
//!
//! The shape of the model (core without drag, then drops in air that they carry along) is known
//! from the literature; its constants are ours, fitted to the published throws that
//! docs/physics.md lists. They cover 0.2–2 MPa and 12–73 mm; w > 0 is more uncertain.

use crate::nozzle::{self, DENSITY, Family};

/// Acceleration of gravity, m/s².
pub const GRAVITY: f64 = 9.806_65;

/// Sizes of the lumps over the middle one, and where they leave the core over its length.
const LUMPS: [(f64, f64); 5] = [(0.65, 0.75), (0.85, 0.9), MIDDLE, (1.15, 1.08), BIGGEST];
const MIDDLE: (f64, f64) = (1.0, 1.0);
const BIGGEST: (f64, f64) = (1.35, 1.17);
const CORE_DIAMETERS: f64 = 3.15;
const CORE_WEBER_EXPONENT: f64 = 0.32;
const ENTRAINED: f64 = 0.75;
const ENTRAINED_DIAMETERS: f64 = 200.0;
const ENTRAINED_LEAST_M: f64 = 0.2;
const WEBER_EXPONENT: f64 = -0.2;
const REFERENCE_M: f64 = 0.028;
const SPRAY_LUMPS: f64 = 9.0;
const LUMP_DRAG: f64 = 0.6;
const SURFACE_TENSION: f64 = 0.072_8;
const AIR_DENSITY: f64 = 1.2;
const WIND_M: f64 = 10.0;
const WIND_LEAST_M: f64 = 0.1;
const WIND_EXPONENT: f64 = 1.0 / 7.0;
const STEP_S: f64 = 0.02;
const FLIGHT_MAX_S: f64 = 15.0;

/// A jet as it leaves the nozzle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Family of the nozzle.
    pub family: Family,
    /// Pressure at the nozzle, MPa.
    pub pressure_mpa: f64,
    /// Diameter of the outlet, mm.
    pub nozzle_mm: f64,
    /// Position of the nozzle, mm: 0 widest … 60 narrowest.
    pub spray_mm: f64,
    /// Direction, radians, positive left.
    pub azimuth: f64,
    /// Direction, radians, positive up.
    pub elevation: f64,
    /// Height of the nozzle above ground, m.
    pub height_m: f64,
    /// Wind 10 m above ground, m/s: forward (azimuth 0) and left.
    pub wind: (f64, f64),
}

/// Where a jet lands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Place, m: forward (azimuth 0) and left.
    pub at: (f64, f64),
    /// Time of flight, s.
    pub flight_s: f64,
    /// Half-axis of the footprint along the jet, m.
    pub along_m: f64,
    /// Half-axis across, m.
    pub across_m: f64,
    /// Direction of the long axis, radians.
    pub heading: f64,
    /// Tangent of the angle of fall.
    pub slope: f64,
}

impl Landing {
    /// Distance from the monitor, m.
    pub fn range_m(&self) -> f64 {
        libm::hypot(self.at.0, self.at.1)
    }

    /// Area of the footprint, m².
    pub fn area_m2(&self) -> f64 {
        core::f64::consts::PI * self.along_m * self.across_m
    }

    /// Whether the footprint covers a place.
    pub fn covers(&self, place: (f64, f64)) -> bool {
        let (dx, dy) = (place.0 - self.at.0, place.1 - self.at.1);
        let (sin, cos) = (libm::sin(self.heading), libm::cos(self.heading));
        let along = (dx * cos + dy * sin) / self.along_m;
        let across = (dy * cos - dx * sin) / self.across_m;
        along * along + across * across <= 1.0
    }
}

/// Water under way: place and velocity.
#[derive(Clone, Copy, Debug)]
struct Motion {
    at: [f64; 3],
    v: [f64; 3],
    time_s: f64,
}

/// What happens to the lumps of one size after break-up.
#[derive(Clone, Copy, Debug)]
struct Lump {
    /// Path to the break-up, m.
    core_m: f64,
    /// 1 / ℓ, 1/m.
    drag: f64,
    /// 1 / Λ, 1/m.
    sheltered: f64,
    /// 10 m above ground.
    wind: [f64; 3],
}

impl Jet {
    /// A solid jet of a monitor in still air, straight ahead, from 1.5 m above ground.
    pub const fn solid(pressure_mpa: f64, nozzle_mm: f64, elevation: f64) -> Self {
        Self {
            family: nozzle::MONITOR,
            pressure_mpa,
            nozzle_mm,
            spray_mm: nozzle::NOZZLE_TRAVEL_MM,
            azimuth: 0.0,
            elevation,
            height_m: 1.5,
            wind: (0.0, 0.0),
        }
    }

    /// Exit speed, m/s.
    pub fn exit_mps(&self) -> f64 {
        self.family.exit_mps(self.pressure_mpa)
    }

    /// Effective size D of the middle lumps, m.
    pub fn lump_m(&self) -> f64 {
        let (d, width) = (self.nozzle_mm / 1000.0, nozzle::width(self.spray_mm));
        let weber = libm::pow(self.weber(), WEBER_EXPONENT);
        self.family.lump * d * libm::sqrt(d / REFERENCE_M) * weber
            / (1.0 + SPRAY_LUMPS * width * width)
    }

    /// Path L_b over which the jet holds together, m.
    pub fn core_m(&self) -> f64 {
        let together = 1.0 - nozzle::width(self.spray_mm);
        let weber = libm::pow(self.weber(), CORE_WEBER_EXPONENT);
        CORE_DIAMETERS * self.nozzle_mm / 1000.0 * weber * together * together
    }

    /// Weber number ρ·v₀²·d/σ.
    pub fn weber(&self) -> f64 {
        let speed = self.exit_mps();
        (DENSITY * speed * speed * self.nozzle_mm / 1000.0 / SURFACE_TENSION).max(1.0)
    }

    /// Follows the water to the ground.
    pub fn landing(&self) -> Landing {
        let landed = LUMPS.map(|size| self.fall(size));
        let n = LUMPS.len() as f64;
        let mean = |of: &dyn Fn(&Motion) -> f64| landed.iter().map(of).sum::<f64>() / n;
        let at = (mean(&|m| m.at[0]), mean(&|m| m.at[1]));
        let [_, _, Motion { v, .. }, ..] = landed;
        let heading = libm::atan2(v[1], v[0]);
        let (sin, cos) = (libm::sin(heading), libm::cos(heading));
        let scatter = |x: f64, y: f64| {
            let square = |m: &Motion| {
                let off = (m.at[0] - at.0) * x + (m.at[1] - at.1) * y;
                off * off
            };
            4.0 * mean(&square)
        };
        let away = libm::hypot(libm::hypot(at.0, at.1), self.height_m);
        let cone_m = 0.3 + away * libm::tan(nozzle::half_angle(self.spray_mm));
        let fall = (-v[2] / length(v).max(1e-9)).max(0.05);
        let long_m = (cone_m / fall).min((libm::hypot(at.0, at.1) / 2.0).max(cone_m));
        Landing {
            at,
            flight_s: mean(&|m| m.time_s),
            along_m: libm::sqrt(long_m * long_m + scatter(cos, sin)),
            across_m: libm::sqrt(cone_m * cone_m + scatter(-sin, cos)),
            heading,
            slope: (-v[2] / libm::hypot(v[0], v[1]).max(1e-9)).max(0.05),
        }
    }

    /// How far the big lumps go, m: where the outermost water lands.
    pub fn reach_m(&self) -> f64 {
        let at = self.fall(BIGGEST).at;
        libm::hypot(at[0], at[1])
    }

    /// How high the big lumps go, m above the ground: the top of the outermost water.
    pub fn top_m(&self) -> f64 {
        let size = BIGGEST;
        let core_s = self.lump(size).core_m / self.exit_mps().max(1e-3);
        let apex_s = self.exit_mps() * libm::sin(self.elevation) / GRAVITY;
        let mut top = self.core(apex_s.min(core_s).max(0.0)).at[2];
        self.fly(size, &mut |motion| top = top.max(motion.at[2]));
        top
    }

    /// Where the middle of the water is after a time: way on the ground and height above it, m.
    pub fn after(&self, time_s: f64) -> (f64, f64) {
        let lump = self.lump(MIDDLE);
        let core_s = (lump.core_m / self.exit_mps()).min(time_s);
        let mut motion = self.core(core_s);
        let mut path = 0.0;
        while motion.time_s < time_s {
            let step_s = STEP_S.min(time_s - motion.time_s);
            motion = lump.step(motion, &mut path, step_s);
        }
        (libm::hypot(motion.at[0], motion.at[1]), motion.at[2])
    }

    fn lump(&self, (size, leaves): (f64, f64)) -> Lump {
        let (d, width) = (self.nozzle_mm / 1000.0, nozzle::width(self.spray_mm));
        let together = (1.0 - width) * (1.0 - width);
        let length = 4.0 / 3.0 * DENSITY / AIR_DENSITY * size * self.lump_m() / LUMP_DRAG;
        let sheltered = (ENTRAINED_DIAMETERS * d * together).max(ENTRAINED_LEAST_M);
        Lump {
            core_m: self.core_m() * leaves,
            drag: 1.0 / length,
            sheltered: 1.0 / sheltered,
            wind: [self.wind.0, self.wind.1, 0.0],
        }
    }

    /// The core after a time: a parabola.
    fn core(&self, time_s: f64) -> Motion {
        let speed = self.exit_mps();
        let level = speed * libm::cos(self.elevation);
        let v = [
            level * libm::cos(self.azimuth),
            level * libm::sin(self.azimuth),
            speed * libm::sin(self.elevation),
        ];
        let fallen = 0.5 * GRAVITY * time_s * time_s;
        Motion {
            at: [v[0] * time_s, v[1] * time_s, self.height_m + v[2] * time_s - fallen],
            v: [v[0], v[1], v[2] - GRAVITY * time_s],
            time_s,
        }
    }

    /// The lumps of one size, from the nozzle to the ground.
    fn fall(&self, size: (f64, f64)) -> Motion {
        self.fly(size, &mut |_| ())
    }

    /// The same; what is seen of them after the core, step by step.
    fn fly(&self, size: (f64, f64), see: &mut dyn FnMut(&Motion)) -> Motion {
        let lump = self.lump(size);
        let up = self.exit_mps() * libm::sin(self.elevation);
        let ground_s =
            (up + libm::sqrt((up * up + 2.0 * GRAVITY * self.height_m).max(0.0))) / GRAVITY;
        let core_s = lump.core_m / self.exit_mps().max(1e-3);
        if ground_s <= core_s {
            return self.core(ground_s.max(0.0));
        }
        let mut motion = self.core(core_s);
        let mut path = 0.0;
        while motion.time_s < FLIGHT_MAX_S {
            let next = lump.step(motion, &mut path, STEP_S);
            if next.at[2] <= 0.0 {
                let part = motion.at[2] / (motion.at[2] - next.at[2]);
                let way = [next.at[0] - motion.at[0], next.at[1] - motion.at[1], 0.0];
                let at = add([motion.at[0], motion.at[1], 0.0], way, part);
                return Motion { at, v: next.v, time_s: motion.time_s + STEP_S * part };
            }
            motion = next;
            see(&motion);
        }
        motion
    }
}

impl Lump {
    fn step(&self, from: Motion, path: &mut f64, step_s: f64) -> Motion {
        let half_m = length(from.v) * step_s / 2.0;
        let free = 1.0 - ENTRAINED * libm::exp(-(*path + half_m) * self.sheltered);
        let drag = self.drag * free * free;
        let wind = self.wind_at(from.at[2]);
        let mid = add(from.v, pull(from.v, wind, drag), step_s / 2.0);
        *path += length(mid) * step_s;
        Motion {
            at: add(from.at, mid, step_s),
            v: add(from.v, pull(mid, wind, drag), step_s),
            time_s: from.time_s + step_s,
        }
    }

    fn wind_at(&self, height_m: f64) -> [f64; 3] {
        if self.wind == [0.0; 3] {
            return self.wind;
        }
        let part = libm::pow(height_m.max(WIND_LEAST_M) / WIND_M, WIND_EXPONENT);
        self.wind.map(|speed| part * speed)
    }
}

fn pull(v: [f64; 3], wind: [f64; 3], drag: f64) -> [f64; 3] {
    let air = add(v, wind, -1.0);
    let drag = -drag * length(air);
    [drag * air[0], drag * air[1], drag * air[2] - GRAVITY]
}

fn add(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

fn length(v: [f64; 3]) -> f64 {
    libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nozzle::SMOOTH_BORE;

    fn jet(pressure_mpa: f64, degrees: f64) -> Jet {
        Jet::solid(pressure_mpa, 28.0, degrees.to_radians())
    }

    /// The table of docs/physics.md.
    #[test]
    fn throws() {
        for (pressure, elevation, expected) in [
            (0.8, 30.0, 44.44),
            (0.4, 30.0, 36.79),
            (0.8, 0.0, 20.35),
            (0.8, -15.0, 5.24),
            (0.8, 10.0, 36.32),
            (0.8, 45.0, 41.26),
        ] {
            let range = jet(pressure, elevation).landing().range_m();
            assert!((range - expected).abs() < 0.02, "{pressure} {elevation}: {range}");
        }
    }

    /// Within the core the water flies as in a vacuum, whatever the wind.
    #[test]
    fn the_core_flies_freely() {
        let down = Jet { wind: (-10.0, 5.0), ..jet(0.8, -25.0) }.landing();
        let up = 38.80 * (-25_f64).to_radians().sin();
        let time = (up + (up * up + 2.0 * GRAVITY * 1.5).sqrt()) / GRAVITY;
        let range = 38.80 * 25_f64.to_radians().cos() * time;
        assert!((down.range_m() - range).abs() < 0.01 && down.at.1 == 0.0, "{down:?}");
        assert!(jet(0.8, 30.0).landing().range_m() < 0.35 * 38.8 * 38.8 / GRAVITY);
    }

    /// A wider spray falls nearer, on more ground.
    #[test]
    fn spray() {
        let solid = jet(0.8, 10.0).landing();
        let mut before = solid.range_m();
        for spray_mm in [45.0, 30.0, 15.0, 0.0] {
            let landing = Jet { spray_mm, ..jet(0.8, 10.0) }.landing();
            assert!(landing.range_m() < before, "{spray_mm}");
            assert!(landing.across_m > 3.0 * solid.across_m);
            before = landing.range_m();
        }
        assert!((4.0..8.0).contains(&before), "{before}");
    }

    #[test]
    fn wind_and_direction() {
        let still = jet(0.8, 20.0).landing();
        let head = Jet { wind: (-8.0, 0.0), ..jet(0.8, 20.0) }.landing();
        let side = Jet { wind: (0.0, 5.0), ..jet(0.8, 20.0) }.landing();
        assert!(head.range_m() < still.range_m() - 3.0 && side.at.1 > 1.0);
        let left = Jet { azimuth: 90_f64.to_radians(), ..jet(0.8, 20.0) }.landing();
        assert!(left.at.0.abs() < 1e-9 && (left.at.1 - still.at.0).abs() < 1e-9);
        // Big lumps go farther than small ones, and the wind carries them less.
        assert!(jet(0.8, 20.0).reach_m() > still.range_m() + 3.0);
    }

    #[test]
    fn footprint() {
        let landing = jet(0.8, 20.0).landing();
        assert!(landing.covers(landing.at) && !landing.covers((0.0, 0.0)));
        assert!((2.0..50.0).contains(&landing.area_m2()), "{}", landing.area_m2());
        let short = (landing.at.0 - landing.along_m * 1.01, landing.at.1);
        assert!(!landing.covers(short));
        assert!(landing.covers((landing.at.0, landing.at.1 + landing.across_m * 0.99)));
    }

    /// The top: of a parabola while the core holds together, below it once the water has broken up.
    #[test]
    fn top() {
        let short = Jet { height_m: 0.0, ..jet(0.8, 3.0) };
        let up = 38.80 * 3_f64.to_radians().sin();
        assert!((short.top_m() - up * up / 2.0 / GRAVITY).abs() < 0.01, "{}", short.top_m());
        assert_eq!(jet(0.8, -20.0).top_m(), 1.5);
        let steep = jet(0.8, 60.0);
        let free = 1.5 + (38.80 * 60_f64.to_radians().sin()).powi(2) / 2.0 / GRAVITY;
        assert!((0.4 * free..0.8 * free).contains(&steep.top_m()), "{}", steep.top_m());
    }

    /// The way of the middle lumps ends where they land.
    #[test]
    fn on_the_way() {
        let jet = Jet { family: SMOOTH_BORE, ..jet(0.5, 30.0) };
        let landed = jet.fall(MIDDLE);
        let (way, height) = jet.after(landed.time_s);
        assert!((way - landed.at[0]).abs() < 0.05 && height.abs() < 0.1, "{way} {height}");
        assert_eq!(jet.after(0.0), (0.0, 1.5));
    }
}
