//! Small vectors and matrices.

pub(crate) type Vector = [f64; 3];
pub(crate) type Matrix = [[f64; 3]; 3];

pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + t·b
pub(crate) fn along(a: Vector, b: Vector, t: f64) -> Vector {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The inverse of a symmetric matrix; none where it is singular for what doubles can tell.
pub(crate) fn inverse(m: Matrix) -> Option<Matrix> {
    let [a, b, c] = m;
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let det = dot(a, rows[0]);
    let scale = length(a) * length(b) * length(c);
    if !det.is_finite() || det.abs() <= 1e-12 * scale || scale == 0.0 {
        return None;
    }
    // The columns of the inverse are these cross products; of a symmetric matrix they are its rows too.
    Some(rows.map(|row| row.map(|x| x / det)))
}

pub(crate) fn times(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| dot(row, v))
}

/// Adds w·v·vᵀ.
pub(crate) fn add_outer(m: &mut Matrix, v: Vector, w: f64) {
    for (row, x) in m.iter_mut().zip(v) {
        for (cell, y) in row.iter_mut().zip(v) {
            *cell += w * x * y;
        }
    }
}

/// An angle in −π…π.
pub fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses() {
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]];
        let i = inverse(m).unwrap();
        for (row, axis) in m.iter().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
            for (a, b) in times(&i, *row).into_iter().zip(axis) {
                assert!((a - b).abs() < 1e-12, "{i:?}");
            }
        }
        assert_eq!(inverse([[1.0, 2.0, 0.0], [2.0, 4.0, 0.0], [0.0, 0.0, 1.0]]), None);
        assert_eq!(inverse([[0.0; 3]; 3]), None);
    }

    #[test]
    fn angles_wrap() {
        assert!((wrapped(7.0) - (7.0 - std::f64::consts::TAU)).abs() < 1e-12);
        assert!((wrapped(-3.5) - (std::f64::consts::TAU - 3.5)).abs() < 1e-12);
    }
}
