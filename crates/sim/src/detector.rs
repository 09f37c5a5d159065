//! The fire detector on the barrel.
//!
//! It looks along the barrel, off by a mounting misalignment (h, v) that justification has to find:
//! optical axis = barrel axis + misalignment. A fire is a box of its diameter, standing on the
//! ground, its middle at elevation −atan((h_m − D/2)/r). A spot is reported when the middle lies in
//! the square field of view (900' across by default); its box is cut at the edges, and what is cut
//! off gives no light.
//!
//! Brightness = 1000 · power_kW / r², times 0.1 behind a dirty glass: about 1400 for a fire of
//! 1.5 m at 25 m, 157 for one of 1 m at 50 m. Noise from the world's seed: ±3' (standard deviation
//! 1') on the box, 2 % on the brightness. It makes a picture every 20 ms and keeps the four
//! brightest spots. It sees nothing while the barrel is folded.
//!
//! False sources ([`Glare`]: the sun, a hot machine) are spots like fires. Walls ([`Wall`]) hide the
//! fires behind them whose middle lies below their edge. Smoke and the jet do not hide anything.

use lafet_device::image::{DetectorInput, Spot};
use lafet_texts::{Text as _, Words, sim as text};

use crate::fault::{Faults, SingleFault};
use crate::fire::Fire;
use crate::obstacle::Obstacle;
use crate::rng::Rng;

/// Time between two pictures, ms.
pub const PICTURE_MS: u64 = 20;

/// A false source: something bright that is no fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Direction, degrees, positive left.
    pub azimuth_deg: f64,
    /// Direction, degrees, positive up.
    pub elevation_deg: f64,
    /// Angle across, degrees.
    pub size_deg: f64,
    /// How bright the detector sees it, in its own units; a fire of 1.5 m at 25 m has 1400.
    pub brightness: f64,
}

/// A wall around the monitor, over a sector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Right end, degrees, positive left.
    pub from_deg: f64,
    /// Left end, degrees.
    pub to_deg: f64,
    /// Distance from the monitor, m.
    pub range_m: f64,
    /// Height above ground, m.
    pub height_m: f64,
}

impl core::str::FromStr for Glare {
    type Err = Words;

    /// Reads `az=30,el=5,size=0.5,brightness=2000`.
    fn from_str(text: &str) -> Result<Self, Words> {
        let [azimuth_deg, elevation_deg, size_deg, brightness] =
            numbers(text, ["az", "el", "size", "brightness"])?;
        within("az", azimuth_deg, -360.0, 360.0)?;
        within("el", elevation_deg, -90.0, 90.0)?;
        within("size", size_deg, 0.01, 90.0)?;
        within("brightness", brightness, 1.0, 1e6)?;
        Ok(Self { azimuth_deg, elevation_deg, size_deg, brightness })
    }
}

impl core::str::FromStr for Wall {
    type Err = Words;

    /// Reads `from=-10,to=10,range=15,height=3`.
    fn from_str(text: &str) -> Result<Self, Words> {
        let [from_deg, to_deg, range_m, height_m] =
            numbers(text, ["from", "to", "range", "height"])?;
        within("from", from_deg, -180.0, 180.0)?;
        within("to", to_deg, from_deg, 180.0)?;
        within("range", range_m, 0.1, 1e4)?;
        within("height", height_m, 0.01, 1e4)?;
        Ok(Self { from_deg, to_deg, range_m, height_m })
    }
}

fn within(name: &str, value: f64, least: f64, most: f64) -> Result<(), Words> {
    match (least..=most).contains(&value) {
        true => Ok(()),
        false => Err(text::GivenOutside { name, value, least, most }.words()),
    }
}

/// The numbers of `a=1,b=2`, each name once, in the order of the names.
fn numbers<const N: usize>(text: &str, names: [&str; N]) -> Result<[f64; N], Words> {
    let mut values = [None; N];
    for field in text.split(',') {
        let (name, value) =
            field.split_once('=').ok_or_else(|| text::GivenUnnamed { field }.words())?;
        let index = names.iter().position(|known| *known == name.trim());
        let index =
            index.ok_or_else(|| text::GivenUnknown { name, known: names.join(", ") }.words())?;
        let number = value.trim().parse().ok().filter(|number: &f64| number.is_finite());
        values[index] = Some(number.ok_or_else(|| text::GivenNoNumber { field, value }.words())?);
    }
    let mut all = [0.0; N];
    for ((slot, value), name) in all.iter_mut().zip(values).zip(names) {
        *slot = value.ok_or_else(|| text::GivenNeeded { name }.words())?;
    }
    Ok(all)
}

impl Wall {
    /// Whether it hides what is at a place, at a height, from a height at the origin.
    fn hides(&self, azimuth_deg: f64, range_m: f64, top_m: f64, eye_m: f64) -> bool {
        let inside = (self.from_deg..=self.to_deg).contains(&azimuth_deg);
        let line_m = eye_m + (top_m - eye_m) * self.range_m / range_m;
        inside && range_m > self.range_m && line_m < self.height_m
    }
}

/// What the detector could see, before its field of view: angles and half-width in arc-minutes.
#[derive(Clone, Copy, Debug)]
struct Source {
    azimuth: f64,
    elevation: f64,
    half: f64,
    brightness: f64,
}

/// The detector.
#[derive(Clone, Debug)]
pub struct Detector {
    /// Full width of the square field of view, arc-minutes.
    pub field_arcmin: f64,
    /// Optical axis minus barrel axis, arc-minutes: left, up.
    pub misalignment: (f64, f64),
    /// What shines without burning.
    pub glares: Vec<Glare>,
    /// What is in its way.
    pub walls: Vec<Wall>,
    /// What is in its way on a site.
    pub obstacles: Vec<Obstacle>,
}

impl Default for Detector {
    fn default() -> Self {
        Self {
            field_arcmin: 900.0,
            misalignment: (0.0, 0.0),
            glares: Vec::new(),
            walls: Vec::new(),
            obstacles: Vec::new(),
        }
    }
}

/// Where the barrel looks, and whether it can.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Traverse, arc-minutes.
    pub azimuth: f64,
    /// Elevation, arc-minutes.
    pub elevation: f64,
    /// Height above ground, m.
    pub height_m: f64,
    /// The barrel is in its working position.
    pub deployed: bool,
}

impl Detector {
    /// Makes a picture.
    pub fn look(&self, aim: Aim, fires: &[Fire], rng: &mut Rng, faults: &Faults) -> DetectorInput {
        let dirty_lens = faults.single(SingleFault::DirtyLens);
        if faults.single(SingleFault::DetectorDead) {
            return DetectorInput::default();
        }
        let mut picture = DetectorInput::default();
        (picture.ready, picture.dirty_lens) = (true, dirty_lens);
        if faults.single(SingleFault::DetectorSaturated) {
            let edge = libm::ceil(self.field_arcmin / 2.0) as i16;
            let spot =
                Spot { left: edge, right: -edge, bottom: -edge, top: edge, brightness: 4000 };
            picture.spots.fill(Some(spot));
            return picture;
        }
        if !aim.deployed {
            return picture;
        }
        let glass = if dirty_lens { 0.1 } else { 1.0 };
        let mut seen: Vec<Spot> = fires
            .iter()
            .filter(|fire| fire.burns() && !self.is_hidden(fire, aim.height_m))
            .map(|fire| Source::of_fire(fire, aim.height_m))
            .chain(self.glares.iter().map(Source::of_glare))
            .filter_map(|source| self.spot(aim, source, glass, rng))
            .collect();
        seen.sort_by_key(|spot| core::cmp::Reverse(spot.brightness));
        for (slot, spot) in picture.spots.iter_mut().zip(seen) {
            *slot = Some(spot);
        }
        picture
    }

    fn is_hidden(&self, fire: &Fire, eye_m: f64) -> bool {
        let azimuth_deg = libm::atan2(fire.at.1, fire.at.0).to_degrees();
        let range_m = libm::hypot(fire.at.0, fire.at.1);
        let middle_m = fire.spec.base_m + fire.size_m / 2.0;
        let eye = (0.0, 0.0, eye_m);
        self.walls.iter().any(|wall| wall.hides(azimuth_deg, range_m, middle_m, eye_m))
            || self.obstacles.iter().any(|it| it.hides(eye, (fire.at.0, fire.at.1, middle_m)))
    }

    fn spot(&self, aim: Aim, source: Source, glass: f64, rng: &mut Rng) -> Option<Spot> {
        let Source { azimuth, elevation, half, brightness } = source;
        let left = wrapped(azimuth - aim.azimuth - self.misalignment.0) + rng.noise();
        let high = elevation - aim.elevation - self.misalignment.1 + rng.noise();
        let brightness = brightness * glass * (1.0 + 0.02 * rng.noise());
        let edge = self.field_arcmin / 2.0;
        if left.abs() > edge || high.abs() > edge {
            return None;
        }
        let shown = |middle: f64| {
            ((middle + half).min(edge) - (middle - half).max(-edge)) / (2.0 * half).max(1e-9)
        };
        let brightness = brightness * shown(left) * shown(high);
        let cut = |value: f64| libm::round(value.clamp(-edge, edge)) as i16;
        Some(Spot {
            left: cut(left + half),
            right: cut(left - half),
            bottom: cut(high - half),
            top: cut(high + half),
            brightness: libm::round(brightness) as i32,
        })
    }
}

impl Source {
    fn of_fire(fire: &Fire, eye_m: f64) -> Self {
        let range = libm::hypot(fire.at.0, fire.at.1);
        Self {
            azimuth: arcmin(libm::atan2(fire.at.1, fire.at.0)),
            elevation: arcmin(libm::atan2(fire.spec.base_m + fire.size_m / 2.0 - eye_m, range)),
            half: arcmin(libm::atan2(fire.size_m / 2.0, range)),
            brightness: 1000.0 * fire.power_kw() / (range * range),
        }
    }

    fn of_glare(glare: &Glare) -> Self {
        Self {
            azimuth: 60.0 * glare.azimuth_deg,
            elevation: 60.0 * glare.elevation_deg,
            half: 30.0 * glare.size_deg,
            brightness: glare.brightness,
        }
    }
}

fn arcmin(radians: f64) -> f64 {
    radians.to_degrees() * 60.0
}

/// An angle brought into ±180°, arc-minutes.
fn wrapped(angle: f64) -> f64 {
    angle - 21_600.0 * libm::round(angle / 21_600.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::fire::FireSpec;
    use lafet_device::image::SPOTS;

    fn fire(azimuth_deg: f64, range_m: f64, size_m: f64) -> Fire {
        Fire::new(FireSpec { azimuth_deg, range_m, size_m, ..FireSpec::default() })
    }

    fn aim(azimuth: f64, elevation: f64) -> Aim {
        Aim { azimuth, elevation, height_m: 1.5, deployed: true }
    }

    fn look(detector: &Detector, aim: Aim, fires: &[Fire], faults: &Faults) -> Vec<Spot> {
        let picture = detector.look(aim, fires, &mut Rng::new(5), faults);
        picture.spots.into_iter().flatten().collect()
    }

    /// 1.5 m at 25 m: 206' wide, 103' below the horizon, brightness about 1414.
    #[test]
    fn a_fire_is_where_it_burns() {
        let fires = [fire(30.0, 25.0, 1.5)];
        let spots = look(&Detector::default(), aim(1700.0, 0.0), &fires, &Faults::default());
        let spot = spots[0];
        assert!((spot.left - spot.right - 206).abs() <= 1, "{spot:?}");
        assert!(((spot.left + spot.right) / 2 - 100).abs() <= 4, "{spot:?}");
        assert!(((spot.top + spot.bottom) / 2 + 103).abs() <= 4, "{spot:?}");
        assert!((1300..1530).contains(&spot.brightness), "{spot:?}");
        assert!(
            look(&Detector::default(), aim(1000.0, 0.0), &fires, &Faults::default()).is_empty()
        );
    }

    /// Its middle on the edge of the field of view: half of the box, half of the light.
    #[test]
    fn cut_at_the_edge() {
        let fires = [fire(0.0, 25.0, 1.5)];
        let spots = look(&Detector::default(), aim(-445.0, -103.0), &fires, &Faults::default());
        assert_eq!(spots[0].left, 450);
        assert!((335..350).contains(&spots[0].right), "{spots:?}");
        assert!((650..820).contains(&spots[0].brightness), "{spots:?}");
    }

    #[test]
    fn misalignment_shifts_it() {
        let detector = Detector { misalignment: (60.0, -30.0), ..Detector::default() };
        let spot = look(&detector, aim(0.0, 0.0), &[fire(0.0, 25.0, 1.5)], &Faults::default())[0];
        assert!(((spot.left + spot.right) / 2 + 60).abs() <= 4, "{spot:?}");
        assert!(((spot.top + spot.bottom) / 2 + 73).abs() <= 4, "{spot:?}");
    }

    #[test]
    fn brightest_first_and_four_at_most() {
        let fires: Vec<Fire> =
            (0..6).map(|i| fire(f64::from(i), 20.0 + f64::from(i), 1.0)).collect();
        let spots = look(&Detector::default(), aim(150.0, -100.0), &fires, &Faults::default());
        assert_eq!(spots.len(), SPOTS);
        assert!(spots.is_sorted_by(|a, b| a.brightness >= b.brightness));
    }

    #[test]
    fn blind_when_folded_dead_or_the_fire_is_out() {
        let detector = Detector::default();
        let mut fires = [fire(0.0, 25.0, 1.5)];
        let folded = Aim { deployed: false, ..aim(0.0, 0.0) };
        assert!(look(&detector, folded, &fires, &Faults::default()).is_empty());
        let mut faults = Faults::default();
        faults.inject(Fault::Single(SingleFault::DirtyLens));
        assert!(look(&detector, aim(0.0, 0.0), &fires, &faults)[0].brightness < 160);
        faults.inject(Fault::Single(SingleFault::DetectorDead));
        assert!(!detector.look(aim(0.0, 0.0), &fires, &mut Rng::new(1), &faults).ready);
        fires[0].heat = 0.0;
        assert!(look(&detector, aim(0.0, 0.0), &fires, &Faults::default()).is_empty());
    }

    /// Behind the monitor the angle goes on over ±180°.
    #[test]
    fn across_the_seam() {
        let spots = look(
            &Detector::default(),
            aim(10_780.0, -100.0),
            &[fire(-179.0, 25.0, 1.0)],
            &Faults::default(),
        );
        assert!(((spots[0].left + spots[0].right) / 2 - 80).abs() <= 4, "{spots:?}");
    }

    /// The sun is a spot like a fire; behind a wall the fire is none, above it it is.
    #[test]
    fn glare_and_walls() {
        let fires = [fire(0.0, 25.0, 1.5)];
        let sun = "az=3,el=2,size=0.5,brightness=2000".parse().unwrap();
        let glaring = Detector { glares: vec![sun], ..Detector::default() };
        let spots = look(&glaring, aim(0.0, 0.0), &fires, &Faults::default());
        assert_eq!(spots.len(), 2);
        assert!((spots[0].left + spots[0].right - 2 * 180).abs() <= 8, "{:?}", spots[0]);
        for (wall, seen) in [
            ("from=-10,to=10,range=15,height=3", 0),
            ("from=-10,to=10,range=15,height=0.5", 1),
            ("from=-10,to=10,range=30,height=3", 1),
            ("from=5,to=10,range=15,height=3", 1),
        ] {
            let walled = Detector { walls: vec![wall.parse().unwrap()], ..Detector::default() };
            let spots = look(&walled, aim(0.0, 0.0), &fires, &Faults::default());
            assert_eq!(spots.len(), seen, "{wall}");
        }
        for (bad, russian) in [
            ("az", "`az`: ожидается имя=значение"),
            ("az=1", "нужно el="),
            ("az=x,el=1,size=1,brightness=1", "`az=x`: `x` — не число"),
            ("az=1,el=1,size=1,hue=1", "`hue`: известны az, el, size, brightness"),
            ("az=1,el=1,size=0,brightness=1", "`size=0`: от 0,01 до 90"),
        ] {
            assert_eq!(bad.parse::<Glare>().unwrap_err().ru, russian, "{bad}");
        }
    }
}
