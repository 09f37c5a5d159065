//! What is on the ground between monitors and fires: walls and tanks.
//!
//! They stand upright and are as high everywhere. They hide what lies behind and below their edge
//! from a detector, and stop the water that does not pass over them.

/// Something on the ground. Places in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Its plan.
    pub shape: Shape,
    /// Height above ground, m.
    pub height_m: f64,
}

/// The plan of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight wall from one place to another.
    Wall((f64, f64), (f64, f64)),
    /// A round tank: its middle and its diameter.
    Tank((f64, f64), f64),
}

/// A place, and a height above it.
pub type Point = (f64, f64, f64);

impl Obstacle {
    /// Whether it hides a place from another one.
    pub fn hides(&self, eye: Point, place: Point) -> bool {
        self.crossings((eye.0, eye.1), (place.0, place.1))
            .into_iter()
            .flatten()
            .any(|part| eye.2 + (place.2 - eye.2) * part < self.height_m)
    }

    /// Where a line on the ground crosses it, as parts of the line between 0 and 1, nearest first.
    pub fn crossings(&self, from: (f64, f64), to: (f64, f64)) -> [Option<f64>; 2] {
        let way = (to.0 - from.0, to.1 - from.1);
        match self.shape {
            Shape::Wall(a, b) => {
                let wall = (b.0 - a.0, b.1 - a.1);
                let cross = way.0 * wall.1 - way.1 * wall.0;
                let off = (a.0 - from.0, a.1 - from.1);
                let part = (off.0 * wall.1 - off.1 * wall.0) / cross;
                let along = (off.0 * way.1 - off.1 * way.0) / cross;
                // Parallel lines give infinities or NaN, which lie in no range.
                let meets = (0.0..1.0).contains(&part) && (0.0..=1.0).contains(&along);
                [meets.then_some(part), None]
            }
            Shape::Tank(middle, diameter_m) => {
                let off = (from.0 - middle.0, from.1 - middle.1);
                let square = way.0 * way.0 + way.1 * way.1;
                let half = (off.0 * way.0 + off.1 * way.1) / square;
                let rest = (off.0 * off.0 + off.1 * off.1 - diameter_m * diameter_m / 4.0) / square;
                let root = libm::sqrt(half * half - rest);
                [-half - root, -half + root].map(|p| (0.0..1.0).contains(&p).then_some(p))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_hides_what_is_behind_and_below() {
        let shape = Shape::Wall((10.0, -5.0), (10.0, 5.0));
        let wall = Obstacle { shape, height_m: 3.0 };
        let eye = (0.0, 0.0, 1.5);
        assert!(wall.hides(eye, (20.0, 0.0, 1.0)));
        assert!(!wall.hides(eye, (20.0, 0.0, 6.0)), "above the edge");
        assert!(!wall.hides(eye, (9.0, 0.0, 1.0)), "in front");
        assert!(!wall.hides(eye, (20.0, 12.0, 1.0)), "beside");
        assert!(!wall.hides((10.0, -9.0, 1.0), (10.0, 9.0, 1.0)), "along");
    }

    #[test]
    fn a_tank_hides_its_far_side_but_not_its_roof() {
        let tank = Obstacle { shape: Shape::Tank((20.0, 0.0), 10.0), height_m: 6.0 };
        let eye = (0.0, 0.0, 2.0);
        assert_eq!(tank.crossings((0.0, 0.0), (40.0, 0.0)), [Some(0.375), Some(0.625)]);
        assert!(tank.hides(eye, (30.0, 0.0, 1.0)));
        assert!(!tank.hides(eye, (20.0, 0.0, 9.0)), "a flame on its roof");
        assert!(!tank.hides(eye, (30.0, 9.0, 1.0)));
    }
}
