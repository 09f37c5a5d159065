//! What a detector's registers mean.
//!
//! | map | registers |
//! |---|---|
//! | `fv300` | Tyco FV300: its block of registers from `register` on (function 3): overall status, four clusters |
//! | `notifier` | Notifier MODBUS-GW: one register a point (function 3) |
//! | none | bits that the configuration names |
//!
//! What contradicts itself, or says that there is nothing, is a fault: never "no fire".

use std::collections::BTreeMap;
use std::time::Duration;

use lafet_site::{Condition, Signal};

use super::point::Point;
use super::wire::Table;

/// Values by table and address.
pub type Image = BTreeMap<(Table, u16), u16>;

/// Registers of an FV300 that are read, from the first of its block.
const FV300_READ: std::ops::RangeInclusive<u16> = 8..=21;
/// Clusters of an FV300, and the first one's registers: state, centre, size.
const FV300_CLUSTERS: [u16; 4] = [10, 13, 16, 19];
/// Its heartbeat changes every 16 s: one that does not change for two of these is frozen.
const FV300_BEAT: Duration = Duration::from_secs(32);

/// Where the registers of a detector are, and what they mean.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Map {
    /// Tyco FV300.
    Fv300 {
        /// First register of its block.
        base: u16,
        /// How it is mounted, if its bearings are wanted.
        view: Option<View>,
    },
    /// A point of a Notifier MODBUS-GW.
    Notifier {
        /// Its register.
        register: u16,
    },
    /// Bits as configured.
    Bits(Box<Bits>),
}

/// How a detector is mounted, tenths of a degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Bearing of its axis, clockwise from north.
    pub bearing: i32,
    /// Elevation of its axis.
    pub elevation: i32,
    /// Width of its field of view.
    pub width: i32,
    /// Height of its field of view.
    pub height: i32,
}

/// Bits of a detector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    /// Fire.
    pub alarm: Point,
    /// Something; no vote.
    pub pre_alarm: Option<Point>,
    /// Conditions, the worst first.
    pub conditions: Vec<(Point, Condition)>,
    /// A bit that changes as long as the device works, and how long it may stand still.
    pub heartbeat: Option<(Point, Duration)>,
}

/// What a detector says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// What it sees.
    pub signal: Signal,
    /// Whether it can see.
    pub condition: Condition,
    /// Its heartbeat, if it has one.
    pub beat: Option<bool>,
    /// Bearing of what it sees, degrees clockwise from north.
    pub bearing_deg: Option<f64>,
    /// Elevation of what it sees, degrees.
    pub elevation_deg: Option<f64>,
}

impl Map {
    /// What has to be read.
    pub fn addresses(&self) -> Vec<(Table, u16)> {
        match self {
            Self::Fv300 { base, .. } => {
                FV300_READ.map(|it| (Table::Holding, base.saturating_add(it))).collect()
            }
            Self::Notifier { register } => vec![(Table::Holding, *register)],
            Self::Bits(bits) => bits.points().map(|it| (it.table, it.address)).collect(),
        }
    }

    /// The bit that alarms.
    pub fn alarm(&self) -> Point {
        match self {
            Self::Fv300 { base, .. } => fv300(*base, 13),
            Self::Notifier { register } => Point::holding(*register, 11),
            Self::Bits(bits) => bits.alarm,
        }
    }

    /// How long the heartbeat may stand still.
    pub fn beats_within(&self) -> Option<Duration> {
        match self {
            Self::Fv300 { .. } => Some(FV300_BEAT),
            Self::Notifier { .. } => None,
            Self::Bits(bits) => bits.heartbeat.map(|(_, within)| within),
        }
    }

    /// What the detector says; `None`: not all of it was read.
    pub fn seen(&self, image: &Image) -> Option<Seen> {
        match self {
            Self::Fv300 { base, view } => seen_of_fv300(*base, *view, image),
            Self::Notifier { register } => {
                image.get(&(Table::Holding, *register)).map(|word| seen_of_notifier(*word))
            }
            Self::Bits(bits) => bits.seen(image),
        }
    }
}

impl Bits {
    /// All points.
    pub fn points(&self) -> impl Iterator<Item = Point> {
        let conditions = self.conditions.iter().map(|(point, _)| *point);
        let beat = self.heartbeat.map(|(point, _)| point);
        [self.alarm].into_iter().chain(self.pre_alarm).chain(conditions).chain(beat)
    }

    fn seen(&self, image: &Image) -> Option<Seen> {
        let met = |point: &Point| {
            image.get(&(point.table, point.address)).map(|value| point.is_met(*value))
        };
        let alarm = met(&self.alarm)?;
        let pre_alarm = self.pre_alarm.as_ref().map_or(Some(false), met)?;
        let beat = self.heartbeat.as_ref().map(|(point, _)| met(point));
        let mut condition = Condition::Ready;
        for (point, worse) in self.conditions.iter().rev() {
            if met(point)? {
                condition = *worse;
            }
        }
        Some(Seen {
            signal: signal(alarm, pre_alarm),
            condition,
            beat: beat.map_or(Some(None), |beat| beat.map(Some))?,
            bearing_deg: None,
            elevation_deg: None,
        })
    }
}

const fn signal(alarm: bool, pre_alarm: bool) -> Signal {
    match (alarm, pre_alarm) {
        (true, _) => Signal::Alarm,
        (false, true) => Signal::PreAlarm,
        (false, false) => Signal::Quiet,
    }
}

/// A bit of the overall status.
const fn fv300(base: u16, bit: u16) -> Point {
    Point::holding(base.saturating_add(8), bit)
}

fn seen_of_fv300(base: u16, view: Option<View>, image: &Image) -> Option<Seen> {
    let register = |at: u16| image.get(&(Table::Holding, base.saturating_add(at))).copied();
    let status = register(8)?;
    let is = |bit: u16| status >> bit & 1 != 0;
    let signal = signal(is(13), is(12));
    let condition = match () {
        () if is(10) || is(9) => Condition::Fault,
        () if is(3) => Condition::Masked,
        () if is(5) || is(4) => Condition::SelfTest,
        () if is(8) => Condition::Dirty,
        () => Condition::Ready,
    };
    let mut place = None;
    // Alarm before pre-alarm before active.
    for wanted in [5, 3, 1] {
        for first in FV300_CLUSTERS {
            if register(first)? & 0xFF == wanted && place.is_none() {
                place = Some(register(first + 1)?);
            }
        }
    }
    let place = place.filter(|_| signal != Signal::Quiet).zip(view);
    Some(Seen {
        signal,
        condition,
        beat: Some(is(0)),
        bearing_deg: place.map(|(centre, view)| view.bearing_of(centre >> 8)),
        elevation_deg: place.map(|(centre, view)| view.elevation_of(centre & 0xFF)),
    })
}

impl View {
    /// Columns count from the right as the detector looks.
    fn bearing_of(self, column: u16) -> f64 {
        let bearing = f64::from(self.bearing) + f64::from(self.width) * off_axis(column);
        (bearing / 10.0).rem_euclid(360.0)
    }

    /// Rows count from the top.
    fn elevation_of(self, row: u16) -> f64 {
        let elevation = f64::from(self.elevation) + f64::from(self.height) * off_axis(row);
        (elevation / 10.0).clamp(-90.0, 90.0)
    }
}

/// Where the middle of a column or row is, as a share of the field, from its middle to where they
/// count from.
fn off_axis(number: u16) -> f64 {
    0.5 - (f64::from(number) + 0.5) / 256.0
}

fn seen_of_notifier(word: u16) -> Seen {
    let is = |bit: u16| word >> bit & 1 != 0;
    let (active, inactive, pre_alarm) = (is(11), is(12), is(14));
    let absent = word & 0xFF == 0xFF;
    // A point that is neither, or both, was not read by the gateway.
    let unclear = active == inactive && (active || !pre_alarm);
    let condition = match () {
        () if absent || unclear || is(13) => Condition::Fault,
        () if is(9) => Condition::Masked,
        () => Condition::Ready,
    };
    Seen {
        signal: signal(active && !absent, pre_alarm && !absent),
        condition,
        beat: None,
        bearing_deg: None,
        elevation_deg: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(base: u16, status: u16, clusters: &[(u16, u16)]) -> Image {
        let mut image: Image = FV300_READ.map(|it| ((Table::Holding, base + it), 0)).collect();
        image.insert((Table::Holding, base + 8), status);
        for (first, (state, centre)) in FV300_CLUSTERS.into_iter().zip(clusters) {
            image.insert((Table::Holding, base + first), *state);
            image.insert((Table::Holding, base + first + 1), *centre);
        }
        image
    }

    #[test]
    fn bits_of_an_fv300_are_as_published() {
        let map = Map::Fv300 { base: 100, view: None };
        for (status, signal, condition) in [
            (0, Signal::Quiet, Condition::Ready),
            (1 << 13, Signal::Alarm, Condition::Ready),
            (1 << 12, Signal::PreAlarm, Condition::Ready),
            (3 << 12, Signal::Alarm, Condition::Ready),
            (1 << 10, Signal::Quiet, Condition::Fault),
            (1 << 9, Signal::Quiet, Condition::Fault),
            (1 << 8, Signal::Quiet, Condition::Dirty),
            (1 << 5 | 1 << 13, Signal::Alarm, Condition::SelfTest),
            (1 << 4, Signal::Quiet, Condition::SelfTest),
            (1 << 3 | 1 << 8, Signal::Quiet, Condition::Masked),
            (1 << 3 | 1 << 10, Signal::Quiet, Condition::Fault),
            // Command done, and what is reserved.
            (1 << 1 | 1 << 2 | 1 << 15, Signal::Quiet, Condition::Ready),
        ] {
            let seen = map.seen(&image(100, status, &[])).unwrap();
            assert_eq!((seen.signal, seen.condition), (signal, condition), "{status:#06x}");
            assert_eq!(seen.beat, Some(false));
        }
        assert_eq!(map.seen(&image(100, 1, &[])).unwrap().beat, Some(true));
        assert_eq!(map.alarm(), Point::parse("holding:108.13").unwrap());
        assert_eq!(map.addresses().len(), 14);
        let mut part = image(100, 0, &[]);
        part.remove(&(Table::Holding, 119));
        assert_eq!(map.seen(&part), None, "what was not read whole is not known");
    }

    #[test]
    fn clusters_of_an_fv300_give_a_bearing() {
        let view = View { bearing: 100, elevation: -200, width: 900, height: 800 };
        let map = Map::Fv300 { base: 0, view: Some(view) };
        let seen = |status, clusters: &[(u16, u16)]| map.seen(&image(0, status, clusters)).unwrap();
        // The first is pre-alarm, the third is alarm: at the right edge and at the bottom.
        let alarm = seen(1 << 13, &[(3, 0x8080), (0, 0), (5, 0x00FF)]);
        let [bearing, elevation] = [alarm.bearing_deg.unwrap(), alarm.elevation_deg.unwrap()];
        assert!((bearing - 54.82).abs() < 0.01 && (elevation + 59.84).abs() < 0.01, "{alarm:?}");
        // At the left edge: west of north.
        let left = seen(1 << 13, &[(5, 0xFF80)]);
        assert!((left.bearing_deg.unwrap() - 325.18).abs() < 0.01, "{left:?}");
        assert_eq!(seen(0, &[(1, 0x8080)]).bearing_deg, None, "nothing is seen");
        assert_eq!(seen(1 << 13, &[]).bearing_deg, None, "no cluster says where");
    }

    #[test]
    fn points_of_a_notifier_that_say_nothing_are_at_fault() {
        for (word, signal, condition) in [
            (1 << 12 | 1 << 10, Signal::Quiet, Condition::Ready),
            (1 << 11 | 1 << 10 | 7, Signal::Alarm, Condition::Ready),
            (1 << 14, Signal::PreAlarm, Condition::Ready),
            (1 << 14 | 1 << 12, Signal::PreAlarm, Condition::Ready),
            (1 << 12 | 1 << 13, Signal::Quiet, Condition::Fault),
            (1 << 11 | 1 << 9, Signal::Alarm, Condition::Masked),
            (1 << 11 | 1 << 12, Signal::Alarm, Condition::Fault),
            (0, Signal::Quiet, Condition::Fault),
            (1 << 12 | 0xFF, Signal::Quiet, Condition::Fault),
            (0xFFFF, Signal::Quiet, Condition::Fault),
        ] {
            let seen = seen_of_notifier(word);
            assert_eq!((seen.signal, seen.condition), (signal, condition), "{word:#06x}");
        }
    }

    #[test]
    fn the_worst_of_configured_bits_counts() {
        let point = |text| Point::parse(text).unwrap();
        let bits = Bits {
            alarm: point("discrete:0"),
            pre_alarm: Some(point("discrete:1")),
            conditions: vec![
                (point("!discrete:2"), Condition::Fault),
                (point("discrete:3"), Condition::Dirty),
            ],
            heartbeat: Some((point("holding:9.0"), Duration::from_secs(4))),
        };
        let map = Map::Bits(Box::new(bits));
        let image = |values: [u16; 4]| -> Image {
            let bits = (0..4).zip(values).map(|(at, value)| ((Table::Discrete, at), value));
            bits.chain([((Table::Holding, 9), 1)]).collect()
        };
        let seen = |values| map.seen(&image(values)).unwrap();
        assert_eq!(
            (seen([1, 0, 1, 0]).signal, seen([1, 0, 1, 0]).condition, seen([1, 0, 1, 0]).beat),
            (Signal::Alarm, Condition::Ready, Some(true))
        );
        assert_eq!(seen([0, 1, 0, 1]).condition, Condition::Fault);
        assert_eq!(seen([0, 1, 1, 1]).condition, Condition::Dirty);
        assert_eq!(seen([0, 1, 1, 1]).signal, Signal::PreAlarm);
        for missing in map.addresses() {
            let mut part = image([0, 0, 1, 0]);
            part.remove(&missing);
            assert_eq!(map.seen(&part), None, "{missing:?}");
        }
    }
}
