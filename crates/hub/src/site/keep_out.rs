//! Sectors that are kept clear of water, as the drives of a barrel count: arc-minutes, positive left and up.

use lafet_place::wrapped;
use lafet_proto::SubsystemId;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Place;

/// A barrel is not where it was heard to be to the minute: a sector counts as wider by this on each side.
const MARGIN: f64 = 60.0;
/// A motion by hand ends farther from it, so that what is asked next is not refused for where it has ended.
const MARGIN_BY_HAND: f64 = 90.0;
const TURN: f64 = 21_600.0;
/// Positions of a drive are 16 bits: sectors repeat within three turns.
const TURNS: std::ops::RangeInclusive<i8> = -3..=3;

/// A sector that no water goes into.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct KeepOut {
    /// Its name.
    pub name: String,
    /// What is kept clear.
    #[serde(rename = "for")]
    pub of: KeptFor,
    /// The monitor; null: all that have a place.
    #[schema(required)]
    pub monitor: Option<String>,
    /// From and to which bearing, clockwise from north, degrees.
    #[schema(min_items = 2, max_items = 2)]
    pub bearings: [f64; 2],
    /// From and to which elevation of the barrel, degrees.
    #[schema(min_items = 2, max_items = 2)]
    pub elevations: [f64; 2],
}

/// For whom a sector is kept clear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum KeptFor {
    /// People.
    People,
    /// Detectors.
    Detectors,
    /// Other equipment.
    Equipment,
}

/// Positions from and to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The least one.
    pub least: f64,
    /// The greatest one.
    pub most: f64,
}

/// Where a barrel points or comes to point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swept {
    /// Positions of Horizontal.
    pub horizontal: Span,
    /// Positions of Vertical.
    pub vertical: Span,
}

impl Span {
    /// Every position.
    pub const WHOLE: Self = Self { least: -TURN, most: TURN };

    /// One position.
    pub const fn at(position: f64) -> Self {
        Self { least: position, most: position }
    }

    /// So much to both sides of a position.
    pub const fn around(middle: f64, half: f64) -> Self {
        Self { least: middle - half, most: middle + half }
    }

    /// Both, and what lies between.
    pub const fn with(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    fn meets(self, other: Self) -> bool {
        self.least <= other.most && other.least <= self.most
    }
}

impl Swept {
    /// Every direction.
    pub const WHOLE: Self = Self { horizontal: Span::WHOLE, vertical: Span::WHOLE };

    /// The same and the way of a drive to a position; `None` of a drive that does not point the barrel.
    pub fn widened(self, drive: SubsystemId, to: f64) -> Option<Self> {
        let to = Span::at(to);
        match drive {
            SubsystemId::HORIZONTAL => Some(Self { horizontal: self.horizontal.with(to), ..self }),
            SubsystemId::VERTICAL => Some(Self { vertical: self.vertical.with(to), ..self }),
            _ => None,
        }
    }

    /// Both, and what lies between.
    pub const fn with(self, other: Self) -> Self {
        Self {
            horizontal: self.horizontal.with(other.horizontal),
            vertical: self.vertical.with(other.vertical),
        }
    }
}

impl KeepOut {
    /// Whether it concerns this monitor.
    pub fn is_of(&self, monitor: &str) -> bool {
        self.monitor.as_deref().is_none_or(|it| it == monitor)
    }

    /// Its bearings and elevations as they count, degrees; a whole turn stays one.
    pub fn with_margin(&self) -> ([f64; 2], [f64; 2]) {
        let margin = MARGIN / 60.0;
        let [from, to] = self.bearings;
        let wide = if to - from >= 360.0 { 360.0 } else { (to - from).rem_euclid(360.0) };
        let wide = wide + 2.0 * margin;
        // Within a turn of north, as the planner has them.
        let turned = |bearing: f64| wrapped(bearing.to_radians()).to_degrees();
        let bearings = match wide >= 360.0 {
            true => [0.0, 360.0],
            false => [turned(from - margin), turned(from - margin + wide)],
        };
        let [lower, upper] = self.elevations;
        (bearings, [lower - margin, upper + margin])
    }

    /// Whether a barrel of a monitor that is mounted so points or comes to point into it.
    pub fn meets(&self, place: &Place, swept: Swept) -> bool {
        self.meets_by(place, swept, MARGIN)
    }

    /// Whether it points there for certain: without the margin.
    pub fn has(&self, place: &Place, swept: Swept) -> bool {
        self.meets_by(place, swept, 0.0)
    }

    fn meets_by(&self, place: &Place, swept: Swept, margin: f64) -> bool {
        self.elevations(margin).meets(swept.vertical)
            && self.azimuths(place, margin).any(|it| it.meets(swept.horizontal))
    }

    /// The position of Horizontal at which it begins ahead of another one, for a barrel with these positions
    /// of Vertical.
    pub fn ahead_horizontally(
        &self,
        place: &Place,
        from: f64,
        left: bool,
        vertical: Span,
    ) -> Option<f64> {
        let borders = self.azimuths(place, MARGIN_BY_HAND).filter_map(|it| ahead(it, from, left));
        let nearest = |a: f64, b: f64| if (a < b) == left { a } else { b };
        self.elevations(MARGIN_BY_HAND).meets(vertical).then(|| borders.reduce(nearest)).flatten()
    }

    /// The position of Vertical at which it begins ahead of another one, for a barrel with these positions of
    /// Horizontal.
    pub fn ahead_vertically(
        &self,
        place: &Place,
        from: f64,
        up: bool,
        horizontal: Span,
    ) -> Option<f64> {
        let is_there = self.azimuths(place, MARGIN_BY_HAND).any(|it| it.meets(horizontal));
        is_there.then(|| ahead(self.elevations(MARGIN_BY_HAND), from, up)).flatten()
    }

    fn elevations(&self, margin: f64) -> Span {
        let [from, to] = self.elevations;
        Span { least: from * 60.0 - margin, most: to * 60.0 + margin }
    }

    /// A bearing grows to the right, a position to the left.
    fn azimuths(&self, place: &Place, margin: f64) -> impl Iterator<Item = Span> {
        let [from, to] = self.bearings;
        let width = if to - from >= 360.0 { TURN } else { (to - from).rem_euclid(360.0) * 60.0 };
        let most = (place.heading - from).rem_euclid(360.0) * 60.0;
        TURNS.map(move |turn| {
            let most = most + f64::from(turn) * TURN;
            Span { least: most - width - margin, most: most + margin }
        })
    }
}

/// Where a span begins ahead of a position; at once for one within it, except on its shorter way out.
fn ahead(span: Span, from: f64, up: bool) -> Option<f64> {
    if span.meets(Span::at(from)) {
        let leaves_up = span.most - from <= from - span.least;
        return (up != leaves_up).then_some(from);
    }
    match up {
        true => (span.least > from).then_some(span.least),
        false => (span.most < from).then_some(span.most),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(heading: f64) -> Place {
        Place { at: [0.0, 0.0], heading, height: 2.0 }
    }

    fn sector(bearings: [f64; 2], elevations: [f64; 2]) -> KeepOut {
        let (name, monitor) = ("stand".to_owned(), None);
        KeepOut { name, of: KeptFor::People, monitor, bearings, elevations }
    }

    fn at(horizontal: f64, vertical: f64) -> Swept {
        Swept { horizontal: Span::at(horizontal * 60.0), vertical: Span::at(vertical * 60.0) }
    }

    #[test]
    fn bearings_run_clockwise_and_positions_to_the_left() {
        let north = sector([350.0, 20.0], [-15.0, 30.0]);
        let points = |heading, horizontal| north.has(&place(heading), at(horizontal, 0.0));
        assert!(points(0.0, 0.0) && points(0.0, 10.0) && points(0.0, -20.0));
        assert!(!points(0.0, 10.1) && !points(0.0, -20.1) && !points(0.0, 180.0));
        // A barrel that looks east at 0 sees north at its left.
        assert!(points(90.0, 90.0) && points(90.0, 100.0) && points(90.0, 70.0));
        assert!(!points(90.0, 0.0) && points(90.0, -270.0), "of another turn");
        assert!(!north.has(&place(0.0), at(0.0, 30.1)) && north.has(&place(0.0), at(0.0, -15.0)));
        assert!(
            north.meets(&place(0.0), at(10.9, 30.9)) && !north.meets(&place(0.0), at(11.1, 0.0))
        );
    }

    #[test]
    fn a_whole_turn_is_everywhere() {
        let round = sector([0.0, 360.0], [40.0, 90.0]);
        for horizontal in [-179.0, 0.0, 33.0, 180.0] {
            assert!(round.has(&place(77.0), at(horizontal, 41.0)));
            assert!(!round.has(&place(77.0), at(horizontal, 39.0)));
        }
    }

    #[test]
    fn a_way_through_it_meets_it() {
        let east = sector([80.0, 100.0], [-90.0, 90.0]);
        let way = |from: f64, to: f64| {
            let horizontal = Span::at(from * 60.0).with(Span::at(to * 60.0));
            east.meets(&place(0.0), Swept { horizontal, vertical: Span::at(0.0) })
        };
        assert!(way(-20.0, -150.0) && way(-150.0, -20.0));
        assert!(!way(0.0, 170.0) && !way(-20.0, -78.9));
    }

    #[test]
    fn borders_lie_ahead() {
        let east = sector([80.0, 100.0], [-90.0, 20.0]);
        let flat = Span::at(0.0);
        let ahead = |from: f64, left| {
            east.ahead_horizontally(&place(0.0), from * 60.0, left, flat).map(|it| it / 60.0)
        };
        assert_eq!(ahead(0.0, false), Some(-78.5));
        assert_eq!(ahead(0.0, true), Some(258.5), "a turn to the left");
        assert_eq!(ahead(-150.0, true), Some(-101.5));
        // Where a motion by hand ends, what comes next is judged as clear.
        assert!(!east.meets(&place(0.0), at(-78.5, 0.0)));
        // From within it only the shorter way leads out.
        assert_eq!((ahead(-85.0, true), ahead(-85.0, false)), (Some(258.5), Some(-85.0)));
        assert_eq!((ahead(-79.0, true), ahead(-79.0, false)), (Some(258.5), Some(-79.0)));
        assert_eq!((ahead(-95.0, true), ahead(-95.0, false)), (Some(-95.0), Some(-438.5)));
        assert_eq!(east.ahead_horizontally(&place(0.0), 0.0, false, Span::at(1300.0)), None);
        let vertically = |from: f64, horizontal: f64| {
            let horizontal = Span::at(horizontal * 60.0);
            east.ahead_vertically(&place(0.0), from * 60.0, false, horizontal).map(|it| it / 60.0)
        };
        assert_eq!((vertically(60.0, -90.0), vertically(60.0, 0.0)), (Some(21.5), None));
    }
}
