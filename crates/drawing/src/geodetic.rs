//! Places on the Earth: WGS 84, and metres around a zero.

use lafet_texts::drawing as text;

use crate::Problem;

/// Half the larger axis of the ellipsoid, m.
const A: f64 = 6_378_137.0;
/// Its eccentricity, squared.
const E2: f64 = F * (2.0 - F);
const F: f64 = 1.0 / 298.257_223_563;
/// The plane that touches the Earth is a map for so far, m: lengths are 0.0001 % short there.
pub const FARTHEST_M: f64 = 20_000.0;

/// Latitude and longitude, degrees of WGS 84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// North of the equator.
    pub latitude: f64,
    /// East of Greenwich.
    pub longitude: f64,
}

impl Geodetic {
    /// A place on the Earth.
    ///
    /// # Errors
    ///
    /// Where there is no such place.
    pub fn new(latitude: f64, longitude: f64) -> Result<Self, Problem> {
        let here = (-90.0..=90.0).contains(&latitude) && (-180.0..=180.0).contains(&longitude);
        if here {
            return Ok(Self { latitude, longitude });
        }
        Err(Problem::new(text::NoPlaceOnEarth { latitude, longitude }, text::NoPlaceOnEarthRemedy))
    }

    /// From the middle of the Earth, on the ellipsoid, m.
    fn in_space(self) -> [f64; 3] {
        let (sin, cos) = self.latitude.to_radians().sin_cos();
        let (sin_east, cos_east) = self.longitude.to_radians().sin_cos();
        let normal = A / (1.0 - E2 * sin * sin).sqrt();
        [normal * cos * cos_east, normal * cos * sin_east, normal * (1.0 - E2) * sin]
    }

    /// East and north of `zero` on the plane that touches the ellipsoid there, m.
    ///
    /// # Errors
    ///
    /// Too far away for a plane.
    pub fn east_north(self, zero: Self) -> Result<[f64; 2], Problem> {
        let (at, origin) = (self.in_space(), zero.in_space());
        let [x, y, z] = [0, 1, 2].map(|n| at[n] - origin[n]);
        let (sin, cos) = zero.latitude.to_radians().sin_cos();
        let (sin_east, cos_east) = zero.longitude.to_radians().sin_cos();
        let east = cos_east * y - sin_east * x;
        let north = cos * z - sin * (cos_east * x + sin_east * y);
        if x.hypot(y).hypot(z) <= FARTHEST_M {
            return Ok([east, north]);
        }
        let km = text_km(x.hypot(y).hypot(z));
        let Self { latitude, longitude } = self;
        Err(Problem::new(text::TooFarFromZero { latitude, longitude, km }, text::TooFarRemedy))
    }
}

fn text_km(metres: f64) -> lafet_texts::Decimal {
    lafet_texts::Decimal(metres / 1000.0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A degree on the ellipsoid as tables have it: 111.412 km along the parallel of 45° is 78.847 km.
    #[test]
    fn degrees_have_the_length_of_the_tables() {
        let zero = Geodetic::new(45.0, 30.0).unwrap();
        let [east, _] = Geodetic::new(45.0, 30.1).unwrap().east_north(zero).unwrap();
        assert!((east - 7884.6).abs() < 1.0, "{east}");
        let [_, north] = Geodetic::new(45.1, 30.0).unwrap().east_north(zero).unwrap();
        assert!((north - 11_113.2).abs() < 1.0, "{north}");
    }

    #[test]
    fn across_the_date_line_and_what_is_no_place() {
        let zero = Geodetic::new(0.0, 179.999).unwrap();
        let [east, north] = Geodetic::new(0.0, -179.999).unwrap().east_north(zero).unwrap();
        assert!((east - 222.64).abs() < 0.01 && north.abs() < 1e-6, "{east}");
        assert!(Geodetic::new(91.0, 0.0).is_err() && Geodetic::new(0.0, f64::NAN).is_err());
        assert!(Geodetic::new(0.0, 0.0).unwrap().east_north(zero).is_err());
    }
}
