//! Outlines of paths: lines, Bézier curves and arcs as points.

use svgtypes::{PathParser, PathSegment};

use crate::curve;

/// A line through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    pub points: Vec<[f64; 2]>,
    pub closed: bool,
}

pub fn rectangle([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Outline {
    let points = vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
    Outline { points, closed: true }
}

/// The outlines of a path, or what of it is not understood. What follows after so many points is left out.
pub fn of_path(d: &str, most: usize) -> Result<Vec<Outline>, String> {
    let mut pen = Pen::default();
    for segment in PathParser::from(d) {
        let segment = segment.map_err(|error| crate::shape::name(&error.to_string()))?;
        pen.draw(segment);
        // Such a path is refused by the builder, which counts points.
        if pen.lifted + pen.points.len() > most {
            break;
        }
    }
    pen.lift(false);
    Ok(pen.outlines)
}

#[derive(Default)]
struct Pen {
    outlines: Vec<Outline>,
    points: Vec<[f64; 2]>,
    /// Points of the outlines.
    lifted: usize,
    at: [f64; 2],
    start: [f64; 2],
    /// The second control point of the curve before, cubic or quadratic.
    cubic: Option<[f64; 2]>,
    quadratic: Option<[f64; 2]>,
}

impl Pen {
    fn lift(&mut self, closed: bool) {
        let mut points = std::mem::take(&mut self.points);
        let twice = closed && points.len() > 1 && points.first() == points.last();
        if twice {
            points.pop();
        }
        if points.len() > 1 {
            self.lifted += points.len();
            self.outlines.push(Outline { points, closed });
        }
    }

    /// A place as written: from the pen if it is relative.
    fn place(&self, abs: bool, x: f64, y: f64) -> [f64; 2] {
        if abs { [x, y] } else { [self.at[0] + x, self.at[1] + y] }
    }

    fn begin(&mut self) {
        if self.points.is_empty() {
            self.points.push(self.at);
        }
    }

    fn line(&mut self, to: [f64; 2]) {
        self.begin();
        self.points.push(to);
        self.at = to;
    }

    fn curve(&mut self, first: [f64; 2], second: [f64; 2], to: [f64; 2]) {
        self.begin();
        curve::bezier(&mut self.points, [self.at, first, second, to]);
        self.at = to;
    }

    fn bend(&mut self, control: [f64; 2], to: [f64; 2]) {
        let toward = |end: [f64; 2]| [0, 1].map(|k| end[k] + (control[k] - end[k]) * (2.0 / 3.0));
        self.curve(toward(self.at), toward(to), to);
    }

    fn mirrored(&self, control: Option<[f64; 2]>) -> [f64; 2] {
        control.map_or(self.at, |it| [0, 1].map(|k| 2.0 * self.at[k] - it[k]))
    }

    fn draw(&mut self, segment: PathSegment) {
        let (before, cubic, quadratic) = (self.at, self.cubic.take(), self.quadratic.take());
        match segment {
            PathSegment::MoveTo { abs, x, y } => {
                let to = self.place(abs, x, y);
                self.lift(false);
                (self.at, self.start) = (to, to);
            }
            PathSegment::LineTo { abs, x, y } => self.line(self.place(abs, x, y)),
            PathSegment::HorizontalLineTo { abs, x } => {
                self.line([if abs { x } else { before[0] + x }, before[1]]);
            }
            PathSegment::VerticalLineTo { abs, y } => {
                self.line([before[0], if abs { y } else { before[1] + y }]);
            }
            PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                let (first, second) = (self.place(abs, x1, y1), self.place(abs, x2, y2));
                self.curve(first, second, self.place(abs, x, y));
                self.cubic = Some(second);
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                let (first, second) = (self.mirrored(cubic), self.place(abs, x2, y2));
                self.curve(first, second, self.place(abs, x, y));
                self.cubic = Some(second);
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                let control = self.place(abs, x1, y1);
                self.bend(control, self.place(abs, x, y));
                self.quadratic = Some(control);
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                let control = self.mirrored(quadratic);
                self.bend(control, self.place(abs, x, y));
                self.quadratic = Some(control);
            }
            PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                let to = self.place(abs, x, y);
                let turn = (x_axis_rotation % 360.0).to_radians();
                self.begin();
                arc(&mut self.points, before, to, [rx.abs(), ry.abs()], turn, large_arc, sweep);
                self.at = to;
            }
            PathSegment::ClosePath { .. } => {
                self.lift(true);
                self.at = self.start;
            }
        }
    }
}

/// Adds the arc of an ellipse after its start. The equations are those of SVG's notes on implementation.
fn arc(
    points: &mut Vec<[f64; 2]>,
    from: [f64; 2],
    to: [f64; 2],
    [rx, ry]: [f64; 2],
    turn: f64,
    large: bool,
    sweep: bool,
) {
    let (sin, cos) = turn.sin_cos();
    let half = [0, 1].map(|k| 0.5 * (from[k] - to[k]));
    // The start on the axes of the ellipse, as parts of its radii; the end is opposite.
    let x = (cos * half[0] + sin * half[1]) / rx;
    let y = (cos * half[1] - sin * half[0]) / ry;
    let square = x * x + y * y;
    if !(square > 0.0 && square.is_finite()) {
        points.push(to);
        return;
    }
    // Radii that are too short for the way grow until they fit.
    let grown = square.sqrt().max(1.0);
    let (rx, ry, x, y) = (rx * grown, ry * grown, x / grown, y / grown);
    let aside = (1.0 / (x * x + y * y) - 1.0).max(0.0).sqrt();
    let side = if large == sweep { -aside } else { aside };
    let centre = [side * y, -side * x];
    let start = (y - centre[1]).atan2(x - centre[0]);
    let end = (-y - centre[1]).atan2(-x - centre[0]);
    let span = (end - start).rem_euclid(std::f64::consts::TAU);
    let span = if sweep { span } else { span - std::f64::consts::TAU };
    let middle = [0, 1].map(|k| 0.5 * (from[k] + to[k]));
    let on = |angle: f64| {
        let (x, y) = (rx * (centre[0] + angle.cos()), ry * (centre[1] + angle.sin()));
        [middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y]
    };
    points.extend(curve::angles(start, start + span).skip(1).map(on));
    if let Some(last) = points.last_mut() {
        *last = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(d: &str) -> Vec<([f64; 2], [f64; 2], usize, bool)> {
        let outlines = of_path(d, 1000).unwrap();
        let ends = |it: &Outline| (it.points[0], it.points[it.points.len() - 1]);
        outlines.iter().map(|it| (ends(it).0, ends(it).1, it.points.len(), it.closed)).collect()
    }

    #[test]
    fn every_command_moves_the_pen() {
        assert_eq!(ends("M1 2h3v4H0V0z"), [([1.0, 2.0], [0.0, 0.0], 5, true)]);
        assert_eq!(
            ends("m1 2 3 4m5,5l1 1"),
            [([1.0, 2.0], [4.0, 6.0], 2, false), ([9.0, 11.0], [10.0, 12.0], 2, false)]
        );
        assert_eq!(
            ends("M0 0C0 1 1 2 2 2s2 0 2 2q0 1 1 1t1 1"),
            [([0.0, 0.0], [6.0, 6.0], 1 + 4 * 24, false)]
        );
        // After it is closed the pen is where it began.
        assert_eq!(ends("M5 5h1v1zl2 0").get(1), Some(&([5.0, 5.0], [7.0, 5.0], 2, false)));
        assert!(of_path("M0 0 L 1", 1000).is_err() || ends("M0 0 L 1").is_empty());
    }

    #[test]
    fn arcs_go_around_their_centre() {
        // Two halves of a circle around 10, 10, one the other way round.
        for sweep in [0, 1] {
            let d = format!("M6 10a4 4 0 1 {sweep} 8 0a4 4 0 1 {sweep} -8 0z");
            let outlines = of_path(&d, 1000).unwrap();
            let (centre, radius) = curve::round(&outlines[0].points).unwrap();
            assert!((centre[0] - 10.0).hypot(centre[1] - 10.0) < 1e-9);
            assert!((radius - 4.0).abs() < 1e-9);
        }
        let quarter = of_path("M10 0A10 10 0 0 1 0 10", 1000).unwrap();
        for [x, y] in &quarter[0].points {
            assert!((x.hypot(*y) - 10.0).abs() < 1e-9 && *x > -1e-9 && *y > -1e-9);
        }
        let long = of_path("M10 0A10 10 0 1 0 0 10", 1000).unwrap();
        assert!(long[0].points.iter().any(|it| it[1] < -9.9), "by the long way");
        // Turned by 90°, the long axis is upright; radii that are too short grow.
        let upright = of_path("M-5 0A2 1 90 0 1 5 0", 1000).unwrap();
        let high = upright[0].points.iter().map(|it| it[1].abs()).fold(0.0, f64::max);
        assert!((high - 10.0).abs() < 1e-2, "{high}");
        assert_eq!(ends("M0 0A0 5 0 0 1 3 4"), [([0.0, 0.0], [3.0, 4.0], 2, false)]);
        assert_eq!(ends("M0 0A1e300 1e300 0 1 1 3 4").len(), 1);
    }
}
