//! Least squares: a circle through points, a turn between two sets of points.

/// The circle nearest to points: centre and radius.
pub fn circle(points: &[[f64; 2]]) -> Option<([f64; 2], f64)> {
    let middle = mean(points)?;
    // x² + y² = 2ax + 2by + c about the middle, where sums of x and of y are 0.
    let (mut xx, mut xy, mut yy, mut xz, mut yz, mut z) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for at in points {
        let (x, y) = (at[0] - middle[0], at[1] - middle[1]);
        let square = x * x + y * y;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xz += x * square;
        yz += y * square;
        z += square;
    }
    let determinant = 4.0 * (xx * yy - xy * xy);
    if determinant.is_nan() || determinant <= 1e-12 * (xx + yy) * (xx + yy) {
        return None;
    }
    let a = 2.0 * (xz * yy - yz * xy) / determinant;
    let b = 2.0 * (yz * xx - xz * xy) / determinant;
    let radius = (a * a + b * b + z / points.len() as f64).sqrt();
    let centre = [middle[0] + a, middle[1] + b];
    (radius.is_finite() && centre.iter().all(|it| it.is_finite())).then_some((centre, radius))
}

pub fn mean(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    (count > 0.0).then(|| [0, 1].map(|k| points.iter().map(|it| it[k]).sum::<f64>() / count))
}

/// How points are turned and scaled onto others, both about their middles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    pub angle: f64,
    pub scale: f64,
    /// Mean distance of the points to their middle, squared.
    pub spread: f64,
}

/// The turn of pairs of points; none if the first of them are one place.
pub fn turn(pairs: &[([f64; 2], [f64; 2])]) -> Option<Turn> {
    let drawn: Vec<[f64; 2]> = pairs.iter().map(|it| it.0).collect();
    let site: Vec<[f64; 2]> = pairs.iter().map(|it| it.1).collect();
    let (from, to) = (mean(&drawn)?, mean(&site)?);
    let (mut real, mut imaginary, mut square, mut known) = (0.0, 0.0, 0.0, 0.0);
    for (p, q) in pairs {
        let (px, py) = (p[0] - from[0], p[1] - from[1]);
        let (qx, qy) = (q[0] - to[0], q[1] - to[1]);
        real += px * qx + py * qy;
        imaginary += px * qy - py * qx;
        square += px * px + py * py;
        known += qx * qx + qy * qy;
    }
    let length = f64::hypot(real, imaginary);
    let found = Turn {
        angle: imaginary.atan2(real),
        // By how far they are spread: that of points which no turn fits is right as well, as of mirrored ones.
        scale: f64::sqrt(known / square),
        spread: square / pairs.len() as f64,
    };
    (square > 0.0 && length > 0.0 && found.scale.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_far_east_north_is_found() {
        let at = |n: i32| {
            let angle = f64::from(n) * 0.7;
            [4e8 + 6000.0 * angle.cos(), 6e9 + 6000.0 * angle.sin()]
        };
        let (centre, radius) = circle(&(0..9).map(at).collect::<Vec<_>>()).unwrap();
        assert!((centre[0] - 4e8).hypot(centre[1] - 6e9) < 0.01 && (radius - 6000.0).abs() < 0.01);
        assert_eq!(circle(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), None);
    }

    #[test]
    fn a_turn_is_found() {
        let pairs = [([0.0, 0.0], [5.0, 5.0]), ([100.0, 0.0], [5.0, 205.0])];
        let turn = turn(&pairs).unwrap();
        assert!((turn.angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((turn.scale - 2.0).abs() < 1e-12);
        assert_eq!(super::turn(&[([1.0, 1.0], [0.0, 0.0]), ([1.0, 1.0], [1.0, 0.0])]), None);
    }
}
