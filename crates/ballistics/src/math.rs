//! What the ballistics need of mathematics (ours), in single precision and little flash: the
//! functions of a library are made for every argument there is, and bring double precision along.

use core::f32::consts::{FRAC_PI_2, LN_2, PI};

const ARCMIN_PER_TURN: i32 = 21_600;
const ARCMIN_PER_QUADRANT: i32 = ARCMIN_PER_TURN / 4;

/// Sine and cosine of an angle in arc-minutes.
pub(crate) fn sin_cos(arcmin: i32) -> (f32, f32) {
    let arcmin = arcmin % ARCMIN_PER_TURN;
    // Whole quadrants are taken off in whole numbers, so nothing is lost however far it turns.
    let quadrant = (arcmin + ARCMIN_PER_QUADRANT / 2).div_euclid(ARCMIN_PER_QUADRANT);
    let rest = arcmin - quadrant * ARCMIN_PER_QUADRANT;
    let angle = rest as f32 * (FRAC_PI_2 / ARCMIN_PER_QUADRANT as f32);
    let square = angle * angle;
    let sin =
        angle * series(square, &[1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0]);
    let cos = series(square, &[1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0]);
    match quadrant & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Arc-minutes of the angle with this tangent, to the nearest.
pub(crate) fn atan_arcmin(tangent: f32) -> i32 {
    // A quarter of the angle has a small tangent, for which the series is short.
    let half = tangent / (1.0 + sqrt(1.0 + tangent * tangent));
    let quarter = half / (1.0 + sqrt(1.0 + half * half));
    let square = quarter * quarter;
    const TERMS: [f32; 7] =
        [1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0];
    let arcmin = quarter * series(square, &TERMS) * (4.0 * ARCMIN_PER_TURN as f32 / (2.0 * PI));
    rounded(arcmin)
}

/// `base` to the power of `exponent`, for a base above zero that is not subnormal.
pub(crate) fn pow(base: f32, exponent: f32) -> f32 {
    const MANTISSA: u32 = 0x007F_FFFF;
    // base = m · 2ⁿ with m from ⅔ to 4/3: its logarithm is a short series of (m − 1) / (m + 1).
    let bits = base.to_bits();
    let upper = u32::from(bits & MANTISSA > 0x2A_AAAA);
    let n = (bits >> 23) + upper;
    let m = f32::from_bits(bits & MANTISSA | (127 - upper) << 23);
    let s = (m - 1.0) / (m + 1.0);
    let log = s * series(s * s, &[2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0]);
    let power = exponent * (n.cast_signed() - 127) as f32 + exponent * log * (1.0 / LN_2);
    // And back: a whole power of two, and what is left of it.
    let whole = rounded(power).clamp(-126, 127);
    let rest = (power - whole as f32) * LN_2;
    const TERMS: [f32; 7] = [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0];
    series(rest, &TERMS) * f32::from_bits((whole + 127).cast_unsigned() << 23)
}

/// Square root to the last bit, of a number from 1 up; of anything else that number.
pub(crate) fn sqrt(x: f32) -> f32 {
    // Numbers from 1 up are in the order of their bits; behind them are infinity, those below zero, and none.
    let bits = x.to_bits();
    if !(1.0_f32.to_bits()..=f32::MAX.to_bits()).contains(&bits) {
        return x;
    }
    let exponent = (bits >> 23) - 127;
    let mantissa = bits & 0x007F_FFFF | 0x0080_0000;
    // A mantissa whose exponent is even, from 2³⁰ to 2³²; its root makes the upper 16 of 25 bits: one more than
    // there is room for rounds.
    let square = mantissa << (7 + (exponent & 1));
    // From the middle, Newton's steps come within 9 %, 0.4 %, 6·10⁻⁶, less than one.
    let mut near = 0xC000;
    for _ in 0..4 {
        near |= 1;
        near = (near + square / near) / 2;
    }
    let mut rest = square.wrapping_sub(near.wrapping_mul(near)).cast_signed();
    if rest < 0 {
        near -= 1;
        rest += (2 * near + 1).cast_signed();
    }
    // What is left, by twice that root, makes the other 9 bits, or one more.
    let rest = rest.cast_unsigned() << 9;
    let lower = rest.checked_div(2 * near).unwrap_or(0);
    let over = (rest - lower * 2 * near) << 9 < lower * lower;
    let mut root = (near << 9) + lower - u32::from(over);
    // Never just between two: an odd root has an odd square.
    root += root & 1;
    f32::from_bits((root >> 1) + ((126 + exponent / 2) << 23))
}

/// Square root from a value near it, which must be above zero; two steps of Newton's.
pub(crate) fn sqrt_near(x: f32, near: f32) -> f32 {
    let root = 0.5 * (near + x / near);
    0.5 * (root + x / root)
}

/// The greater of two numbers; the second where the first is none.
pub(crate) fn at_least(x: f32, least: f32) -> f32 {
    if x > least { x } else { least }
}

/// The lesser of two numbers; the second where the first is none.
pub(crate) fn at_most(x: f32, most: f32) -> f32 {
    if most > x { x } else { most }
}

/// The nearest whole number.
#[inline(never)]
fn rounded(x: f32) -> i32 {
    (x + if x < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// c₀ + c₁·x + c₂·x² + …
fn series(x: f32, terms: &[f32]) -> f32 {
    terms.iter().rev().fold(0.0, |sum, term| sum * x + term)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles() {
        for arcmin in -40_000..=40_000 {
            let (sin, cos) = sin_cos(arcmin);
            let (sine, cosine) = (f64::from(arcmin) / 10_800.0 * std::f64::consts::PI).sin_cos();
            let error = (f64::from(sin) - sine).abs().max((f64::from(cos) - cosine).abs());
            assert!(error < 1.5e-7, "{arcmin}: {error}");
        }
        // As many turns as there is room for: 11,647' and −11,648' beyond the last.
        for (turned, arcmin) in [(i32::MAX, 11_647), (i32::MIN, -11_648)] {
            assert_eq!(sin_cos(turned), sin_cos(arcmin));
        }
        for tenth in -810_000..=810_000 {
            let tangent = tenth as f32 / 10_000.0;
            let exact = f64::from(tangent).atan() * 10_800.0 / std::f64::consts::PI;
            let error = (f64::from(atan_arcmin(tangent)) - exact).abs();
            assert!(error < 0.504, "{tangent}: {error}");
        }
    }

    #[test]
    fn powers() {
        for (exponent, step) in [(0.32, 7), (1.192, 11), (-0.315, 13), (0.0, 997), (1.0, 101)] {
            for thousandth in (1..100_000).step_by(step) {
                let base = thousandth as f32 / 1000.0;
                let exact = f64::from(base).powf(f64::from(exponent));
                let error = (f64::from(pow(base, exponent)) / exact - 1.0).abs();
                assert!(error < 1e-6, "{base}^{exponent}: {error}");
            }
        }
    }

    #[test]
    fn roots() {
        let mut bits = 1.0f32.to_bits();
        while bits < f32::MAX.to_bits() {
            let x = f32::from_bits(bits);
            assert_eq!(sqrt(x), x.sqrt(), "{x}");
            bits += 1013;
        }
        assert_eq!(sqrt(f32::INFINITY), f32::INFINITY);
        assert!(sqrt(f32::NAN).is_nan());
    }
}
