//! Fires: where they burn, how they grow and spread, what puts them out.
//!
//! What burns is on a disc of diameter D on level ground and is as high as it is wide, flame
//! included. It takes the water that would land on its shadow: the disc, drawn out along the jet by
//! D / tan(angle of fall). Its heat i (0 out … 1 full) follows the density of water d, l/(s·m² of
//! the disc):
//! - heat release: Q̇ = 500 kW/m² · π/4·D² · i. A disc that grows at g m/s makes the fire that grows
//!   with t²: α = 500·π/4·g² kW/s², so g = 0.0055 m/s is a medium, 0.011 a fast, 0.022 an ultra-fast
//!   one; it stops at twice the first diameter;
//! - d is the water that reaches it, smoothed with τ = 3 s (it keeps wetting while the jet
//!   is elsewhere), and at most 1.0: more runs off unused. Foam counts 1.5 times;
//! - below the critical density d_c = 0.06 l/(s·m²) the fire recovers: di/dt = (1 − i)/30 s, and
//!   its disc grows;
//! - above it di/dt = −(d − d_c)/10 l/m²: a solid jet on the spot needs about 11 s, a sector swept
//!   with 0.25 l/(s·m²) about 50 s;
//! - at i = 0 it is out. A fire that re-ignites leaves embers: when they have got less than 30 l/m²
//!   in all, it flares up again 20 s after they dried, with i = 0.1;
//! - what is said so far is of solids, and of oil that water cools below its flash point. Light fuel,
//!   a hydrocarbon, gives vapour however cold it is: water alone only lowers its flames, by half
//!   with 1 l/(s·m²), and i follows (1 − c)·(1 − w/2) with τ = 5 s downwards and 30 s upwards, c
//!   being what foam covers (see `foam`), w the density of water without foam. It is out when all
//!   is covered and i < 0.02. One that re-ignites has hot metal in it for 300 s, and burns again
//!   if less than three quarters are covered by then;
//! - spread: a fire radiates q = 0.3·Q̇/(4π·r²) at a distance r (a point source), at most 60 kW/m²
//!   in contact. A thing that does not burn and gets more than 12 kW/m² for ∫(q − 12) dt =
//!   600 kJ/m² catches fire, i = 0.1. It cools in the same way when it gets less. Water that falls
//!   on it takes 400 kJ with each litre, a seventh of what evaporating it would, and foam that
//!   covers half of it keeps the heat off. A fire put out catches again like anything else.
//!
//! Source of d_c: fire brigades' fires put out at 3.5–4.0 l/(m²·min) and not below, 0.058–0.067
//! l/(s·m²) (Särdqvist, Jonsson, Grimwood: Three different fire suppression approaches…, Fire
//! Technology 55, 2019, 837–852). That a surface goes out when water takes more heat than the flame
//! returns is Rasbash (The extinction of fire with plain water, Fire Safety Science 1, 1986,
//! 1145–1163). The other figures are ours: plausible orders of magnitude, not fitted to measured
//! fires. Good for training and tests, not for design.

use core::f64::consts::FRAC_PI_4;

use lafet_texts::{Text as _, Words, sim as text};

use crate::airborne::Portion;
use crate::foam::{Blanket, Falling, Foam};
use crate::jet::Landing;

/// What a fire's fuel is like: what puts it out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Class {
    /// Solids, and liquids with a high flash point: water cools them until they go out.
    #[default]
    Solid,
    /// Light liquid fuel: it goes out when foam covers it. Water alone does not put it out.
    Hydrocarbon,
}

impl Class {
    /// All of them, as files and options call them.
    pub const ALL: [(&'static str, Self); 2] =
        [("solid", Self::Solid), ("hydrocarbon", Self::Hydrocarbon)];
}

/// What a fire is lit with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FireSpec {
    /// Direction, degrees, positive left.
    pub azimuth_deg: f64,
    /// Distance from the monitor on level ground, m.
    pub range_m: f64,
    /// Diameter, m.
    pub size_m: f64,
    /// Growth of the diameter without water, m/s.
    pub growth_mps: f64,
    /// Whether it flares up again unless the embers are drowned.
    pub reignites: bool,
    /// Whether it burns from the start; if not, it is a thing that another fire can light.
    pub lit: bool,
    /// Height of what burns above ground, m: the edge of a tank. Water that falls short of it does
    /// not reach the fire.
    pub base_m: f64,
    /// Heat release of the burning disc, kW/m².
    pub kw_m2: f64,
    /// Density of water below which it does not care, l/(s·m²).
    pub critical: f64,
    /// What puts it out.
    pub class: Class,
    /// What the foam is like that is used on it.
    pub foam: Foam,
}

impl Default for FireSpec {
    fn default() -> Self {
        Self {
            azimuth_deg: 0.0,
            range_m: 20.0,
            size_m: 1.0,
            growth_mps: 0.0,
            reignites: false,
            lit: true,
            base_m: 0.0,
            kw_m2: HEAT_KW_M2,
            critical: CRITICAL_DENSITY,
            class: Class::default(),
            foam: Foam::default(),
        }
    }
}

impl core::str::FromStr for FireSpec {
    type Err = Words;

    /// Reads `az=30,range=25,size=1.5,growth=0.01,reignites=1,lit=0,class=hydrocarbon`; az and range
    /// are needed.
    fn from_str(text: &str) -> Result<Self, Words> {
        let mut spec = Self::default();
        let (mut azimuth, mut range) = (false, false);
        for field in text.split(',') {
            let (name, value) =
                field.split_once('=').ok_or_else(|| text::GivenUnnamed { field }.words())?;
            if name.trim() == "class" {
                let known = Class::ALL.into_iter().find(|(class, _)| *class == value.trim());
                spec.class = known.ok_or_else(|| text::GivenClass { field }.words())?.1;
                continue;
            }
            let number: f64 = value
                .trim()
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite())
                .ok_or_else(|| text::GivenNoNumber { field, value }.words())?;
            let positive = |least: f64| {
                if number >= least {
                    Ok(number)
                } else {
                    Err(text::GivenTooLittle { field, least }.words())
                }
            };
            match name.trim() {
                "az" if number.abs() <= 360.0 => (spec.azimuth_deg, azimuth) = (number, true),
                "az" => return Err(text::GivenDirection { field }.words()),
                "range" => (spec.range_m, range) = (positive(0.5)?, true),
                "size" => spec.size_m = positive(0.05)?,
                "growth" => spec.growth_mps = positive(0.0)?,
                "reignites" => spec.reignites = number != 0.0,
                "lit" => spec.lit = number != 0.0,
                _ => {
                    let known = "az, range, size, growth, reignites, lit, class";
                    return Err(text::GivenUnknown { name, known }.words());
                }
            }
        }
        if azimuth && range { Ok(spec) } else { Err(text::GivenNoPlace.words()) }
    }
}

/// Density below which a fire does not care, l/(s·m²).
pub const CRITICAL_DENSITY: f64 = 0.06;

const USEFUL_DENSITY: f64 = 1.0;
const DOSE_OUT: f64 = 10.0;
const DOSE_EMBERS: f64 = 30.0;
const FOAM_FACTOR: f64 = 1.5;
const WETTING_S: f64 = 3.0;
const RECOVERY_S: f64 = 30.0;
const REIGNITE_S: f64 = 20.0;
const HEAT_KW_M2: f64 = 500.0;
const CATCHES: f64 = 0.1;
const RADIATED: f64 = 0.3;
const CONTACT_KW_M2: f64 = 60.0;
const IGNITION_KW_M2: f64 = 12.0;
const IGNITION_KJ_M2: f64 = 600.0;
/// Heat that a litre of water takes from what it cools, kJ.
const COOLING_KJ_L: f64 = 400.0;
/// Foam that covers so much of a thing keeps heat and flames off.
const SHIELDED: f64 = 0.5;
/// Part of the flames of light fuel that much water takes.
const LOWERED: f64 = 0.5;
const SMOTHERED_S: f64 = 5.0;
/// Flames smaller than this are none.
const LAST_FLAMES: f64 = 0.02;
/// Metal in a pool lights it again for so long, unless foam covers so much.
const HOT_METAL_S: f64 = 300.0;
const SEALED: f64 = 0.75;

/// A fire.
#[derive(Clone, Debug)]
pub struct Fire {
    /// What it was lit with.
    pub spec: FireSpec,
    /// Place, m: forward (azimuth 0) and left.
    pub at: (f64, f64),
    /// Diameter now, m.
    pub size_m: f64,
    /// Heat, 0 out … 1 full.
    pub heat: f64,
    /// Density of the water on it, l/(s·m²).
    pub density: f64,
    landed_l: f64,
    /// Of it, foam and plain water, l.
    landed_parts: [f64; 2],
    /// Density of water without foam, l/(s·m²).
    plain: f64,
    blanket: Blanket,
    /// Time since light fuel went out, s; `None`: it has not burned.
    out_s: Option<f64>,
    dose: f64,
    dry_s: f64,
    /// Heat that it has taken up on its way to catching fire, kJ/m².
    warmed: f64,
}

impl Fire {
    /// Lights a fire.
    pub fn new(spec: FireSpec) -> Self {
        let azimuth = spec.azimuth_deg.to_radians();
        let at = (spec.range_m * libm::cos(azimuth), spec.range_m * libm::sin(azimuth));
        Self::at(spec, at)
    }

    /// Lights a fire at a place, m, whatever direction and distance the specification says.
    pub fn at(spec: FireSpec, at: (f64, f64)) -> Self {
        Self {
            spec,
            at,
            size_m: spec.size_m,
            heat: if spec.lit { 1.0 } else { 0.0 },
            density: 0.0,
            landed_l: 0.0,
            landed_parts: [0.0; 2],
            plain: 0.0,
            blanket: Blanket::default(),
            out_s: None,
            dose: 0.0,
            dry_s: 0.0,
            warmed: 0.0,
        }
    }

    /// Whether it burns.
    pub fn burns(&self) -> bool {
        self.heat > 0.0
    }

    /// Part of it that foam covers, 0 … 1; of solids none, which foam only wets.
    pub fn covered(&self) -> f64 {
        self.blanket.covered(&self.spec.foam)
    }

    /// How thick the foam on it is, mm.
    pub fn foam_mm(&self) -> f64 {
        self.blanket.thickness_mm(&self.spec.foam)
    }

    /// How far it has been heated on its way to catching fire, 0 … 1.
    pub fn heated(&self) -> f64 {
        self.warmed / IGNITION_KJ_M2
    }

    /// Area of the disc, m².
    pub fn area_m2(&self) -> f64 {
        FRAC_PI_4 * self.size_m * self.size_m
    }

    /// Heat release, kW.
    pub fn power_kw(&self) -> f64 {
        self.spec.kw_m2 * self.area_m2() * self.heat
    }

    /// What it radiates on a thing at a place, kW/m².
    pub fn flux_kw_m2(&self, place: (f64, f64)) -> f64 {
        let (dx, dy) = (place.0 - self.at.0, place.1 - self.at.1);
        let sphere_m2 = 4.0 * core::f64::consts::PI * (dx * dx + dy * dy);
        RADIATED * self.power_kw() / sphere_m2.max(1e-3)
    }

    /// A portion of water lands: what its footprint has in common with the shadow wets the fire.
    /// Whether it does.
    pub fn catch(&mut self, portion: &Portion) -> bool {
        let Portion { landing, litres, foam, .. } = portion;
        let (base_m, drawn_m) = (self.spec.base_m / landing.slope, self.size_m / landing.slope);
        let (mut points, mut covered) = (0.0, 0.0);
        for (index, point) in (0..).zip(self.points()) {
            // Multiples of the golden ratio spread evenly between 0 and 1.
            let part = f64::from(index) * 0.618_033_988_749_895 % 1.0;
            points += 1.0;
            covered +=
                f64::from(u8::from(landing.covers(along(point, landing, base_m + drawn_m * part))));
        }
        let shadow_m2 = self.area_m2() + self.size_m * drawn_m;
        let (dx, dy) = (landing.at.0 - self.at.0, landing.at.1 - self.at.1);
        let behind_m = dx * libm::cos(landing.heading) + dy * libm::sin(landing.heading);
        let nearest = along(self.at, landing, behind_m.clamp(base_m, base_m + drawn_m));
        let off_m = libm::hypot(nearest.0 - landing.at.0, nearest.1 - landing.at.1);
        // A footprint smaller than the gaps between the points lies wholly in the shadow.
        let inside_m2 = if off_m < self.size_m / 2.0 { landing.area_m2() } else { 0.0 };
        let wetted_m2 = (shadow_m2 * covered / points).max(inside_m2.min(shadow_m2));
        if wetted_m2 > 0.0 {
            self.wet(litres * (wetted_m2 / landing.area_m2()).min(1.0), *foam);
        }
        wetted_m2 > 0.0
    }

    /// Points spread evenly over the disc, for finding how much of it a jet covers.
    fn points(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        const POINTS: u32 = 24;
        // The golden angle spreads points on a spiral evenly over the area.
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let (at, radius) = (self.at, self.size_m / 2.0);
        (0..POINTS).map(move |index| {
            let r = radius * libm::sqrt((f64::from(index) + 0.5) / f64::from(POINTS));
            let angle = GOLDEN * f64::from(index);
            (at.0 + r * libm::cos(angle), at.1 + r * libm::sin(angle))
        })
    }

    /// Water that reached it: litres, of which `foam` (0 … 1) is foam.
    pub fn wet(&mut self, litres: f64, foam: f64) {
        // On a solid foam wets better than water; on light fuel it is the blanket that counts.
        let factor = if self.spec.class == Class::Solid { FOAM_FACTOR } else { 1.0 };
        self.landed_l += litres * (1.0 + (factor - 1.0) * foam);
        self.landed_parts[0] += litres * foam;
        self.landed_parts[1] += litres * (1.0 - foam);
    }

    /// Burns for `dt_s`.
    pub fn step(&mut self, dt_s: f64) {
        let falling = self.landed_l / self.area_m2() / dt_s;
        self.landed_l = 0.0;
        self.density += (falling - self.density) * (dt_s / WETTING_S);
        let [foam_l, plain_l] = core::mem::take(&mut self.landed_parts);
        if self.spec.class == Class::Hydrocarbon {
            self.step_pool([foam_l, plain_l], dt_s);
        } else {
            self.step_solid(dt_s);
        }
    }

    fn step_solid(&mut self, dt_s: f64) {
        let useful = self.density.min(USEFUL_DENSITY);
        self.dose += useful * dt_s;
        self.dry_s = if self.density > 0.1 * self.spec.critical { 0.0 } else { self.dry_s + dt_s };
        if !self.burns() {
            let embers = self.spec.reignites && self.dose > 0.0 && self.dose < DOSE_EMBERS;
            if embers && self.dry_s > REIGNITE_S {
                (self.heat, self.dose) = (CATCHES, 0.0);
            }
            return;
        }
        if useful > self.spec.critical {
            self.heat = (self.heat - (useful - self.spec.critical) / DOSE_OUT * dt_s).max(0.0);
        } else {
            self.heat += (1.0 - self.heat) / RECOVERY_S * dt_s;
            self.grow(dt_s);
        }
    }

    fn grow(&mut self, dt_s: f64) {
        let most = 2.0 * self.spec.size_m;
        self.size_m = (self.size_m + self.spec.growth_mps * dt_s).min(most);
    }

    /// Light fuel burns where no foam covers it.
    fn step_pool(&mut self, [foam_l, plain_l]: [f64; 2], dt_s: f64) {
        let area_m2 = self.area_m2();
        self.plain += (plain_l / area_m2 / dt_s - self.plain) * (dt_s / WETTING_S);
        let falling =
            Falling { solution: foam_l / area_m2 / dt_s, water: self.plain, heat: self.heat };
        self.blanket.step(&self.spec.foam, falling, dt_s);
        let open = 1.0 - self.covered();
        if !self.burns() {
            self.out_s = self.out_s.map(|out_s| out_s + dt_s);
            let hot = self.spec.reignites && self.out_s.is_some_and(|out_s| out_s < HOT_METAL_S);
            if hot && open > 1.0 - SEALED {
                self.heat = CATCHES;
            }
            return;
        }
        self.out_s = Some(0.0);
        let aim = open * (1.0 - LOWERED * self.plain.min(USEFUL_DENSITY));
        let within_s = if aim < self.heat { SMOTHERED_S } else { RECOVERY_S };
        self.heat += (aim - self.heat) * (dt_s / within_s);
        if open == 0.0 && self.heat < LAST_FLAMES {
            self.heat = 0.0;
        }
        self.grow(dt_s * open);
        self.blanket.stretch(area_m2 / self.area_m2());
    }
}

/// A place moved along the fall of a jet.
fn along(place: (f64, f64), landing: &Landing, metres: f64) -> (f64, f64) {
    (place.0 + metres * libm::cos(landing.heading), place.1 + metres * libm::sin(landing.heading))
}

/// Fires light what is near them; for `dt_s`.
pub fn spread(fires: &mut [Fire], dt_s: f64) {
    for index in 0..fires.len() {
        let (at, cold) = (fires[index].at, !fires[index].burns());
        if !cold {
            continue;
        }
        let others = fires.iter().filter(|other| other.burns());
        let flux: f64 = others.map(|other| other.flux_kw_m2(at)).sum();
        let fire = &mut fires[index];
        let shielded = fire.covered() >= SHIELDED;
        let taken = if shielded { 0.0 } else { flux.min(CONTACT_KW_M2) };
        let surplus = taken - IGNITION_KW_M2 - COOLING_KJ_L * fire.density;
        fire.warmed = (fire.warmed + surplus * dt_s).max(0.0);
        if fire.warmed >= IGNITION_KJ_M2 {
            (fire.heat, fire.dose, fire.warmed) = (CATCHES, 0.0, 0.0);
        }
    }
}

#[cfg(test)]
mod tests;
