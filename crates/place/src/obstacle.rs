//! What is in the way of a jet, and what must be kept clear of it.

use lafet_texts::place as text;
use serde::{Deserialize, Serialize};

use crate::linear::{Vector, along, minus};
use crate::text::{Problem, within};
use crate::{FARTHEST_M, Place};

/// A body on the ground or above it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// A box, turned about the vertical.
    Box {
        /// Centre in plan, m.
        at: [f64; 2],
        /// Length and width, m.
        size: [f64; 2],
        /// Bearing of its length, rad.
        heading: f64,
        /// From and to which height, m.
        heights: [f64; 2],
    },
    /// An upright cylinder.
    Cylinder {
        /// Centre in plan, m.
        at: [f64; 2],
        /// Radius, m.
        radius_m: f64,
        /// From and to which height, m.
        heights: [f64; 2],
    },
}

impl Body {
    /// Refuses what is no number or has no size.
    pub fn check(&self) -> Result<(), Problem> {
        let (at, sizes, heights) = match *self {
            Self::Box { at, size, heights, heading } => {
                let turn = -std::f64::consts::TAU..=std::f64::consts::TAU;
                within(&text::BoxHeading, heading, turn)?;
                (at, size, heights)
            }
            Self::Cylinder { at, radius_m, heights } => (at, [radius_m, radius_m], heights),
        };
        for value in at.into_iter().chain(heights) {
            let what = &text::BodyCoordinate;
            within(what, value, -FARTHEST_M..=FARTHEST_M)?;
        }
        for value in sizes {
            within(&text::BodySize, value, 0.01..=2000.0)?;
        }
        let what = &text::BodyHeight;
        within(what, heights[1] - heights[0], 0.01..=1000.0)
    }

    /// Centre in plan, and the radius of a circle around it that holds the body, m.
    pub fn circle(&self) -> ([f64; 2], f64) {
        match *self {
            Self::Box { at, size, .. } => (at, 0.5 * size[0].hypot(size[1])),
            Self::Cylinder { at, radius_m, .. } => (at, radius_m),
        }
    }

    /// Its top, m.
    pub const fn top_m(&self) -> f64 {
        match *self {
            Self::Box { heights, .. } | Self::Cylinder { heights, .. } => heights[1],
        }
    }

    /// Whether a place lies inside.
    pub fn holds(&self, place: Place) -> bool {
        self.is_met(place, place)
    }

    /// Whether the straight line between two places meets it.
    pub fn is_met(&self, from: Place, to: Place) -> bool {
        let way = minus(to, from);
        match *self {
            Self::Box { at, size, heading, heights } => {
                let (sin, cos) = heading.sin_cos();
                let turned = |[x, y, z]: Vector| [x * sin + y * cos, x * cos - y * sin, z];
                let start = turned(minus(from, [at[0], at[1], 0.0]));
                let way = turned(way);
                let least = [-0.5 * size[0], -0.5 * size[1], heights[0]];
                let most = [0.5 * size[0], 0.5 * size[1], heights[1]];
                (0..3)
                    .try_fold((0.0, 1.0), |part, axis| {
                        clipped(part, start[axis], way[axis], (least[axis], most[axis]))
                    })
                    .is_some()
            }
            Self::Cylinder { at, radius_m, heights } => {
                let Some((enter, leave)) =
                    clipped((0.0, 1.0), from[2], way[2], (heights[0], heights[1]))
                else {
                    return false;
                };
                let nearest = nearest(from, way, at).clamp(enter, leave);
                let [x, y, _] = along(from, way, nearest);
                (x - at[0]).hypot(y - at[1]) <= radius_m
            }
        }
    }
}

/// The part of a line along which one coordinate is inside its bounds.
fn clipped(
    (enter, leave): (f64, f64),
    start: f64,
    way: f64,
    (least, most): (f64, f64),
) -> Option<(f64, f64)> {
    if way.abs() < 1e-12 {
        return (least..=most).contains(&start).then_some((enter, leave));
    }
    let (a, b) = ((least - start) / way, (most - start) / way);
    let (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    (enter <= leave).then_some((enter, leave))
}

/// Where along a line it comes nearest to a point in plan.
fn nearest(from: Place, way: Vector, at: [f64; 2]) -> f64 {
    let square = way[0] * way[0] + way[1] * way[1];
    if square < 1e-12 {
        return 0.0;
    }
    ((at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1]) / square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_and_cylinders_are_met() {
        let wall =
            Body::Box { at: [10.0, 0.0], size: [8.0, 1.0], heading: 0.0, heights: [0.0, 3.0] };
        // Its length runs north: 8 m from south to north, 1 m from west to east.
        assert!(wall.is_met([0.0, 3.9, 1.0], [20.0, 3.9, 1.0]));
        assert!(!wall.is_met([0.0, 4.1, 1.0], [20.0, 4.1, 1.0]));
        assert!(!wall.is_met([0.0, 0.0, 3.1], [20.0, 0.0, 3.1]));
        assert!(wall.is_met([0.0, 0.0, 6.0], [20.0, 0.0, -0.5]));
        assert!(!wall.is_met([0.0, 0.0, 1.0], [9.0, 0.0, 1.0]));
        assert!(wall.holds([10.2, 1.0, 1.0]) && !wall.holds([10.6, 1.0, 1.0]));
        let tank = Body::Cylinder { at: [0.0, 20.0], radius_m: 5.0, heights: [0.0, 8.0] };
        assert!(tank.is_met([4.9, 0.0, 4.0], [4.9, 40.0, 4.0]));
        assert!(!tank.is_met([5.1, 0.0, 4.0], [5.1, 40.0, 4.0]));
        assert!(tank.is_met([0.0, 20.0, 20.0], [0.0, 20.0, 0.0]));
        assert!(!tank.is_met([0.0, 0.0, 9.0], [0.0, 40.0, 8.1]));
        // Over the near edge and down into the roof.
        assert!(tank.is_met([0.0, 14.0, 9.0], [0.0, 22.0, 7.0]));
        assert_eq!((tank.circle(), tank.top_m()), (([0.0, 20.0], 5.0), 8.0));
    }

    #[test]
    fn what_is_no_body_is_refused() {
        let good = Body::Cylinder { at: [0.0, 0.0], radius_m: 5.0, heights: [0.0, 8.0] };
        assert_eq!(good.check(), Ok(()));
        for wrong in [
            Body::Cylinder { at: [f64::NAN, 0.0], radius_m: 5.0, heights: [0.0, 8.0] },
            Body::Cylinder { at: [0.0, 0.0], radius_m: 0.0, heights: [0.0, 8.0] },
            Body::Cylinder { at: [0.0, 0.0], radius_m: 5.0, heights: [8.0, 8.0] },
            Body::Box {
                at: [0.0; 2],
                size: [1.0, f64::INFINITY],
                heading: 0.0,
                heights: [0.0, 1.0],
            },
            Body::Box { at: [0.0; 2], size: [1.0; 2], heading: f64::NAN, heights: [0.0, 1.0] },
        ] {
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
    }
}
