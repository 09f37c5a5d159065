//! Curves as points, and back.

use std::f64::consts::TAU;

use crate::fit;

/// An arc has a point at least every 2.5°: its chords are within 0.03 % of the radius.
const STEP: f64 = TAU / 144.0;
/// Points of a Bézier curve.
const BEZIER: usize = 24;
/// A closed line of fewer points is not taken for a circle.
const ROUND_POINTS: usize = 8;
/// Farthest from its circle, as a part of the radius.
const ROUND: f64 = 0.01;

/// Angles from one to another, both included.
pub fn angles(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let span = (to - from).clamp(-TAU, TAU);
    let count = (span.abs() / STEP).ceil().max(1.0) as usize;
    (0..=count).map(move |n| from + span * n as f64 / count as f64)
}

/// Adds what follows after `from` on the way to `to`; `bulge` is the tangent of a quarter of the arc's angle.
pub fn bulge(points: &mut Vec<[f64; 2]>, from: [f64; 2], to: [f64; 2], bulge: f64) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    if bulge.abs() < 1e-9 || dx.hypot(dy) == 0.0 {
        points.push(to);
        return;
    }
    let aside = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = [0.5 * (from[0] + to[0]) - aside * dy, 0.5 * (from[1] + to[1]) + aside * dx];
    let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
    let start = (from[1] - centre[1]).atan2(from[0] - centre[0]);
    let on = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin]
    };
    points.extend(angles(start, start + 4.0 * bulge.atan()).skip(1).map(on));
    if let Some(last) = points.last_mut() {
        *last = to;
    }
}

/// Adds what follows after the first of four points of a Bézier curve.
pub fn bezier(points: &mut Vec<[f64; 2]>, [a, b, c, d]: [[f64; 2]; 4]) {
    points.extend((1..=BEZIER).map(|n| {
        let t = n as f64 / BEZIER as f64;
        let s = 1.0 - t;
        [0, 1].map(|k| {
            s * s * s * a[k] + 3.0 * s * s * t * b[k] + 3.0 * s * t * t * c[k] + t * t * t * d[k]
        })
    }));
}

/// The circle that a closed line goes around: centre and radius.
pub fn round(points: &[[f64; 2]]) -> Option<([f64; 2], f64)> {
    let closed_twice = points.len() > 1 && points.first() == points.last();
    let points = if closed_twice { &points[1..] } else { points };
    if points.len() < ROUND_POINTS {
        return None;
    }
    let (centre, radius) = fit::circle(points)?;
    let off = |it: &[f64; 2]| ((it[0] - centre[0]).hypot(it[1] - centre[1]) - radius).abs();
    if !points.iter().all(|it| off(it) <= ROUND * radius) {
        return None;
    }
    // Once around, without a gap.
    let mut around = 0.0;
    let mut before = points[points.len() - 1];
    for at in points {
        let (a, b) = ([0, 1].map(|k| before[k] - centre[k]), [0, 1].map(|k| at[k] - centre[k]));
        let turn = (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
        if turn.abs() > TAU / 6.0 {
            return None;
        }
        around += turn;
        before = *at;
    }
    ((around.abs() - TAU).abs() < 0.1).then_some((centre, radius))
}

/// Leaves out points that are within `tolerance` of the line through their neighbours.
pub fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let mut rest = points.iter().copied();
    let Some(mut anchor) = rest.next() else { return kept };
    kept.push(anchor);
    // From the anchor, the directions that pass near all points since: a middle and a half width.
    let mut open: Option<(f64, f64, f64)> = None;
    let mut last = anchor;
    let mut farthest = 0.0;
    for at in rest {
        let seen = Seen::from(anchor, at);
        let goes_on = match (&seen, open) {
            (None, _) => farthest <= tolerance,
            (Some(_), None) => true,
            (Some(seen), Some((middle, right, left))) => {
                let turn = wrapped(seen.direction - middle);
                (right..=left).contains(&turn) && seen.distance >= farthest - tolerance
            }
        };
        if !goes_on {
            kept.push(last);
            (anchor, open, farthest) = (last, None, 0.0);
        }
        if let Some(seen) = Seen::from(anchor, at) {
            open = Some(seen.within(open, tolerance));
            farthest = seen.distance.max(farthest);
        }
        last = at;
    }
    if kept.len() == 1 || kept.last() != Some(&last) {
        kept.push(last);
    }
    kept
}

/// A point as seen from another.
struct Seen {
    direction: f64,
    distance: f64,
}

impl Seen {
    fn from(anchor: [f64; 2], at: [f64; 2]) -> Option<Self> {
        let (x, y) = (at[0] - anchor[0], at[1] - anchor[1]);
        let distance = x.hypot(y);
        (distance > 0.0).then(|| Self { direction: y.atan2(x), distance })
    }

    fn within(&self, open: Option<(f64, f64, f64)>, tolerance: f64) -> (f64, f64, f64) {
        let half =
            if self.distance > tolerance { (tolerance / self.distance).asin() } else { TAU / 4.0 };
        match open {
            None => (self.direction, -half, half),
            Some((middle, right, left)) => {
                let turn = wrapped(self.direction - middle);
                (middle, right.max(turn - half), left.min(turn + half))
            }
        }
    }
}

fn wrapped(angle: f64) -> f64 {
    let turn = angle.rem_euclid(TAU);
    if turn > 0.5 * TAU { turn - TAU } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bulge_of_1_is_a_half_circle_to_the_right_of_its_chord() {
        let mut points = vec![[0.0, 0.0]];
        bulge(&mut points, [0.0, 0.0], [10.0, 0.0], 1.0);
        assert_eq!(points.last(), Some(&[10.0, 0.0]));
        // Counter-clockwise from west to east passes below.
        let lowest = points.iter().map(|it| it[1]).fold(0.0, f64::min);
        assert!((lowest + 5.0).abs() < 1e-3, "{lowest}");
        bulge(&mut points, [10.0, 0.0], [0.0, 0.0], 1.0);
        let (centre, radius) = round(&points).unwrap();
        assert!((centre[0] - 5.0).hypot(centre[1]) < 1e-9 && (radius - 5.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_round_and_what_is_not() {
        let circle = |count: usize, from: f64, to: f64, high: f64| -> Vec<[f64; 2]> {
            let step = (to - from) / count as f64;
            let angles = (0..count).map(|n| from + step * n as f64);
            angles.map(|it| [100.0 + 4.0 * it.cos(), 7.0 + high * it.sin()]).collect()
        };
        assert!(round(&circle(12, 0.0, TAU, 4.0)).is_some());
        assert!(round(&circle(36, 0.0, TAU, 4.2)).is_none(), "an ellipse");
        assert!(round(&circle(36, 0.0, 4.0, 4.0)).is_none(), "a part of a circle");
        assert!(round(&circle(36, 0.0, 2.0 * TAU, 4.0)).is_none(), "twice around");
        assert!(round(&circle(7, 0.0, TAU, 4.0)).is_none(), "seven corners");
        assert!(round(&[[1.0, 1.0]; 20]).is_none(), "a point");
    }

    #[test]
    fn corners_stay_and_straight_runs_go() {
        let line: Vec<[f64; 2]> =
            [0.0, 1.0, 2.0, 5.0, 10.0].map(|x| [x, if x == 2.0 { 0.01 } else { 0.0 }]).to_vec();
        assert_eq!(simplified(&line, 0.02), [[0.0, 0.0], [10.0, 0.0]]);
        assert_eq!(simplified(&line, 0.001).len(), 5);
        let corner = [[0.0, 0.0], [5.0, 0.0], [5.0, 0.0], [5.0, 8.0]];
        assert_eq!(simplified(&corner, 0.02), [[0.0, 0.0], [5.0, 0.0], [5.0, 8.0]]);
        let there_and_back = [[0.0, 0.0], [9.0, 0.0], [3.0, 0.0]];
        assert_eq!(simplified(&there_and_back, 0.02), there_and_back);
        assert_eq!(simplified(&[[1.0, 1.0]], 0.02), [[1.0, 1.0], [1.0, 1.0]]);
        let arc: Vec<[f64; 2]> =
            angles(0.0, TAU).map(|it| [10.0 * it.cos(), 10.0 * it.sin()]).collect();
        let fewer = simplified(&arc, 0.02);
        assert!((30..80).contains(&fewer.len()), "{}", fewer.len());
        for it in &fewer {
            assert!((it[0].hypot(it[1]) - 10.0).abs() < 1e-9);
        }
    }
}
