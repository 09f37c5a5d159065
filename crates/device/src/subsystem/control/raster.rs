//! Horizontal lines over a sector, to and fro: for the jet (§3.14/1) and for the search (§3.16).

use super::approach::Direction;
use lafet_proto::status::Limits;

/// A sector, arc-minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Area {
    pub right: i32,
    pub left: i32,
    pub bottom: i32,
    pub top: i32,
}

impl Area {
    /// A sector by its centre and size.
    pub(crate) fn around(centre: Direction, width: i32, height: i32) -> Self {
        Self {
            right: centre.horizontal.saturating_sub(width / 2),
            left: centre.horizontal.saturating_add(width / 2),
            bottom: centre.vertical.saturating_sub(height / 2),
            top: centre.vertical.saturating_add(height / 2),
        }
    }

    /// The part inside the limits; `None` when there is none.
    pub(crate) fn clip(self, horizontal: Option<Limits>, vertical: Option<Limits>) -> Option<Self> {
        let (right, left) = clip(self.right, self.left, horizontal)?;
        let (bottom, top) = clip(self.bottom, self.top, vertical)?;
        Some(Self { right, left, bottom, top })
    }

    /// The area without a margin, but at least its middle.
    pub(crate) fn without_sides(self, margin: i32) -> Self {
        let margin = margin.min(self.left.saturating_sub(self.right) / 2).max(0);
        Self {
            right: self.right.saturating_add(margin),
            left: self.left.saturating_sub(margin),
            ..self
        }
    }

    fn height(&self) -> i32 {
        self.top.saturating_sub(self.bottom).max(0)
    }

    fn middle(&self) -> i32 {
        self.bottom.saturating_add(self.height() / 2)
    }
}

fn clip(low: i32, high: i32, limits: Option<Limits>) -> Option<(i32, i32)> {
    let Some(Limits { min, max }) = limits else { return Some((low, high)) };
    (low <= max && high >= min).then_some((low.max(min), high.min(max)))
}

/// Ends of lines, one after another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Raster {
    area: Area,
    lowest: i32,
    spacing: i32,
    last: i32,
    line: i32,
    to_left: bool,
    upwards: bool,
    /// The next point ends a line that has been started.
    on_line: bool,
}

impl Raster {
    /// Lines at most this far apart, the edges half of that from the outer lines or nearer, from
    /// the corner nearest to where the barrel points.
    pub(crate) fn covering(area: Area, spacing: i32, from: Direction) -> Self {
        let lines = area.height().saturating_add(spacing.max(1) - 1) / spacing.max(1);
        let lines = lines.max(1);
        Self::new(area, area.height().saturating_add(lines - 1) / lines, lines, from)
    }

    /// Lines exactly this far apart, as many as fit, in the middle of the area.
    pub(crate) fn stepping(area: Area, step: i32, from: Direction) -> Self {
        let step = step.max(1);
        Self::new(area, step, area.height() / step + 1, from)
    }

    fn new(area: Area, spacing: i32, lines: i32, from: Direction) -> Self {
        let last = lines.saturating_sub(1).max(0);
        let to_left = from.horizontal < area.right.saturating_add(area.left) / 2;
        let upwards = from.vertical < area.middle();
        Self {
            area,
            lowest: area.middle().saturating_sub(last.saturating_mul(spacing) / 2),
            spacing,
            last,
            line: if upwards { 0 } else { last },
            to_left,
            upwards,
            on_line: false,
        }
    }

    /// Where to go now.
    pub(crate) fn point(&self) -> Direction {
        let side = self.to_left == self.on_line;
        Direction {
            horizontal: if side { self.area.left } else { self.area.right },
            vertical: self.lowest.saturating_add(self.line.saturating_mul(self.spacing)),
        }
    }

    /// Whether the way to the point is a line, not the way to its beginning.
    pub(crate) fn on_line(&self) -> bool {
        self.on_line
    }

    /// The point is reached: on to the next; false when that was the last line, and the way back
    /// begins.
    pub(crate) fn advance(&mut self) -> bool {
        if !self.on_line {
            self.on_line = true;
            return true;
        }
        self.to_left = !self.to_left;
        let more = if self.upwards { self.line < self.last } else { self.line > 0 };
        if !more {
            self.upwards = !self.upwards;
        }
        if self.last > 0 {
            self.line += if self.upwards { 1 } else { -1 };
            self.on_line = false;
        }
        more
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const AREA: Area = Area { right: -300, left: 300, bottom: -150, top: 150 };

    fn points(mut raster: Raster, count: usize) -> Vec<(i32, i32)> {
        (0..count)
            .map(|_| {
                let Direction { horizontal, vertical } = raster.point();
                raster.advance();
                (horizontal, vertical)
            })
            .collect()
    }

    /// §3.14/1 Line by line, to and fro, up and down again.
    #[test]
    fn to_and_fro() {
        let raster = Raster::stepping(AREA, 120, Direction { horizontal: -500, vertical: -500 });
        let expected = [
            (-300, -120),
            (300, -120),
            (300, 0),
            (-300, 0),
            (-300, 120),
            (300, 120),
            (300, 0),
            (-300, 0),
            (-300, -120),
        ];
        assert_eq!(points(raster, 9), expected);
    }

    #[test]
    fn nearest_corner_and_single_line() {
        let from = Direction { horizontal: 900, vertical: 900 };
        let raster = Raster::stepping(AREA, 120, from);
        assert_eq!(points(raster, 3), [(300, 120), (-300, 120), (-300, 0)]);
        let line = Raster::stepping(AREA, 600, from);
        assert_eq!(points(line, 4), [(300, 0), (-300, 0), (300, 0), (-300, 0)]);
    }

    /// §3.16 Every part of the sector comes within half a spacing of a line, once.
    #[test]
    fn covers() {
        for height in [0, 1, 599, 600, 601, 1200, 5400] {
            let area = Area { bottom: -900, top: height - 900, ..AREA };
            let mut raster = Raster::covering(area, 600, Direction::default());
            let mut lines: Vec<i32> = Vec::new();
            loop {
                lines.push(raster.point().vertical);
                assert!(raster.advance() && raster.on_line());
                if !raster.advance() {
                    break;
                }
            }
            lines.sort_unstable();
            assert_eq!(lines.len() as i32, ((height + 599) / 600).max(1));
            assert!(lines[0] - area.bottom <= 300 && area.top - lines[lines.len() - 1] <= 300);
            assert!(lines.windows(2).all(|pair| pair[1] - pair[0] <= 600), "{lines:?}");
        }
    }

    #[test]
    fn clipping() {
        let limits = |min, max| Some(Limits { min, max });
        assert_eq!(AREA.clip(None, None), Some(AREA));
        assert_eq!(AREA.clip(limits(-300, 300), limits(-150, 150)), Some(AREA));
        let half = AREA.clip(limits(0, 900), limits(-900, 0));
        assert_eq!(half, Some(Area { right: 0, left: 300, bottom: -150, top: 0 }));
        assert_eq!(AREA.clip(limits(301, 900), None), None);
        assert_eq!(AREA.clip(None, limits(-900, -151)), None);
        assert_eq!(AREA.without_sides(100), Area { right: -200, left: 200, ..AREA });
        assert_eq!(AREA.without_sides(450), Area { right: 0, left: 0, ..AREA });
    }
}
