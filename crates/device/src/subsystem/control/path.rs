//! §3.15 «Программа тушения по траекториям»: the points of a trajectory, one after another.

use super::Data;
use crate::params::Params;
use lafet_proto::request::TrajectoryPoint;

/// Stored trajectories.
pub(super) const TRAJECTORIES: u8 = 8;

/// Place in a trajectory whose points, or numbers of stored trajectories, stand in [`Data`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Path {
    stored: bool,
    repeat: bool,
    /// Which of the numbers of stored trajectories.
    part: usize,
    /// Which point: of that stored trajectory, or of the points themselves.
    index: usize,
}

impl Path {
    pub(super) const fn new(stored: bool, repeat: bool) -> Self {
        Self { stored, repeat, part: 0, index: 0 }
    }

    /// The point to go to; on to the next one there is where a stored trajectory has become
    /// shorter meanwhile. `None` at the end.
    pub(super) fn point(&mut self, data: &Data, params: &Params) -> Option<TrajectoryPoint> {
        if !self.stored {
            let (points, _) = data.bytes().as_chunks();
            let count = points.len().max(1);
            if self.repeat {
                self.index %= count;
            }
            return points.get(self.index).copied().map(TrajectoryPoint::from_bytes);
        }
        let parts = data.bytes();
        // Once through all parts and back to the first: any point there is has been met.
        for _ in 0..=parts.len() {
            if self.repeat && self.part >= parts.len() {
                self.part = 0;
            }
            let number = parts.get(self.part)?;
            let points = params.trajectory(usize::from(*number));
            if let Some(point) = points.get(self.index) {
                return Some(*point);
            }
            self.part += 1;
            self.index = 0;
        }
        None
    }

    /// The point is done.
    pub(super) fn advance(&mut self) {
        self.index = self.index.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::Ints;
    use lafet_proto::param::Param;
    use std::vec::Vec;

    fn point(horizontal: i16) -> TrajectoryPoint {
        TrajectoryPoint { horizontal, vertical: 0, distance: 0, dwell: 1 }
    }

    fn walk(mut path: Path, data: &Data, params: &Params, count: usize) -> Vec<i16> {
        (0..count)
            .map_while(|_| {
                let point = path.point(data, params)?;
                path.advance();
                Some(point.horizontal)
            })
            .collect()
    }

    /// §3.15/1
    #[test]
    fn points_in_order() {
        let params = crate::subsystem::control::bench::params();
        let data = Data::of([1, 2, 3].map(|h| point(h).to_bytes()).iter().flatten().copied());
        assert_eq!(walk(Path::new(false, false), &data, &params, 9), [1, 2, 3]);
        assert_eq!(walk(Path::new(false, true), &data, &params, 7), [1, 2, 3, 1, 2, 3, 1]);
    }

    /// §3.15/2
    #[test]
    fn stored_ones_in_order() {
        let mut params = crate::subsystem::control::bench::params();
        let values = [1, 0, 0, 1, 2, 0, 0, 1];
        params.write(Param::ControlTrajectory1, Ints::Values(&values));
        params.write(Param::ControlTrajectory4, Ints::Values(&[5, 0, 0, 1]));
        let data = Data::of([4, 1, 4].into_iter());
        assert_eq!(walk(Path::new(true, false), &data, &params, 9), [5, 1, 2, 5]);
        assert_eq!(walk(Path::new(true, true), &data, &params, 6), [5, 1, 2, 5, 5, 1]);
        params.write(Param::ControlTrajectory1, Ints::Values(&[]));
        params.write(Param::ControlTrajectory4, Ints::Values(&[]));
        assert_eq!(walk(Path::new(true, true), &data, &params, 6), []);
    }
}
