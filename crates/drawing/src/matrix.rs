//! Affine maps of space.

/// A place or direction in space.
pub type Vector = [f64; 3];

/// An affine map: the images of the axes, then that of zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix {
    pub axes: [Vector; 3],
    pub zero: Vector,
}

impl Matrix {
    pub const SAME: Self =
        Self { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], zero: [0.0; 3] };

    /// The axes of what is drawn on a plane with this normal, by DXF's rule of the arbitrary axis.
    pub fn of_normal(normal: Vector) -> Self {
        const ALMOST: f64 = 1.0 / 64.0;
        let Some(z) = unit(normal) else { return Self::SAME };
        let up = if z[0].abs() < ALMOST && z[1].abs() < ALMOST {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
        let x = unit(cross(up, z)).unwrap_or([1.0, 0.0, 0.0]);
        Self { axes: [x, cross(z, x), z], zero: [0.0; 3] }
    }

    pub const fn moved(by: Vector) -> Self {
        Self { zero: by, ..Self::SAME }
    }

    /// About the vertical, to the left, rad.
    pub fn turned(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { axes: [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]], zero: [0.0; 3] }
    }

    pub const fn scaled([x, y, z]: Vector) -> Self {
        Self { axes: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]], zero: [0.0; 3] }
    }

    /// A map of the plane as SVG writes it.
    pub const fn plane([a, b, c, d, e, f]: [f64; 6]) -> Self {
        Self { axes: [[a, b, 0.0], [c, d, 0.0], [0.0, 0.0, 1.0]], zero: [e, f, 0.0] }
    }

    /// First the other one, then this.
    pub fn after(&self, first: &Self) -> Self {
        Self { axes: first.axes.map(|axis| self.direction(axis)), zero: self.place(first.zero) }
    }

    pub fn direction(&self, [x, y, z]: Vector) -> Vector {
        let [i, j, k] = &self.axes;
        [0, 1, 2].map(|n| i[n] * x + j[n] * y + k[n] * z)
    }

    pub fn place(&self, place: Vector) -> Vector {
        let turned = self.direction(place);
        [0, 1, 2].map(|n| turned[n] + self.zero[n])
    }

    /// The factor by which lengths in its plane grow, if seen from above a circle stays a circle.
    pub fn round(&self) -> Option<f64> {
        let [[a, b, _], [c, d, _], _] = self.axes;
        let (x, y) = (a.hypot(b), c.hypot(d));
        let same = (x - y).abs() <= 1e-6 * x.max(y);
        (same && (a * c + b * d).abs() <= 1e-6 * x * y).then_some(x)
    }
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// In the same direction, 1 long.
pub fn unit(it: Vector) -> Option<Vector> {
    let length = it[0].hypot(it[1]).hypot(it[2]);
    (length.is_finite() && length > 0.0).then(|| it.map(|part| part / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vector, b: Vector) -> bool {
        (0..3).all(|n| (a[n] - b[n]).abs() < 1e-12)
    }

    #[test]
    fn maps_follow_each_other() {
        let turn = Matrix::turned(std::f64::consts::FRAC_PI_2);
        let both =
            Matrix::moved([10.0, 0.0, 0.0]).after(&turn).after(&Matrix::scaled([2.0, 2.0, 1.0]));
        assert!(near(both.place([1.0, 0.0, 5.0]), [10.0, 2.0, 5.0]));
        assert!((both.round().unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(Matrix::scaled([2.0, 1.0, 1.0]).round(), None);
    }

    /// What is mirrored has a normal that points down: x is then the other way round.
    #[test]
    fn a_normal_that_points_down_mirrors() {
        let down = Matrix::of_normal([0.0, 0.0, -1.0]);
        assert!(near(down.place([3.0, 4.0, 0.0]), [-3.0, 4.0, 0.0]));
        assert_eq!(Matrix::of_normal([0.0, 0.0, 1.0]), Matrix::SAME);
        assert_eq!(Matrix::of_normal([0.0; 3]), Matrix::SAME);
    }
}
