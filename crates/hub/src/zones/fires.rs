//! Where fires are, by the bearings of detectors, and how monitors aim at them.
//!
//! A zone has the bearings of those of its detectors that report fire and have a place. Where two or more
//! cross there is a place, and [`lafet_place::fires`] says what it is worth. Only a sure one is aimed at;
//! without one, and where a monitor has no place, cannot point there or is too far, it aims as its
//! `[[aim]]` says.

use std::collections::BTreeMap;
use std::time::Duration;

use lafet_place::fires::{Candidate, Standing};
use lafet_place::station::{self, AGE_MAX_MS, Bearing, Kind as Sense, QUALITY_MIN};
use lafet_place::wrapped;
use lafet_proto::param::Param;
use lafet_proto::request::Sector;
use lafet_site::config::Kind;
use lafet_site::{Condition, Signal};
use serde::Serialize;
use utoipa::ToSchema;

use super::view::Reported;
use crate::config::{Target, ZonesConfig};
use crate::control::authority::Now;
use crate::hub::Hub;
use crate::monitor::station::Station;
use crate::site::keep_out::Span;
use crate::site::{Place, jet};

/// The ellipse of a place holds the fire with this probability.
const PROBABILITY: f64 = 0.95;
/// Two bearings of a detector that differ by no more standard errors are of the same fire.
const SAME_SIGHT: f64 = 3.0;
/// Width and height of what a jet scans around a place, arc-minutes, and the step between its lines, degrees.
const SCAN_MIN: f64 = 240.0;
const SCAN_MAX: f64 = 1200.0;
const STEP_DEG: i8 = 1;
/// Distances that `StartQuench` can name, m.
const DISTANCE_M: std::ops::RangeInclusive<f64> = 2.0..=127.0;
/// Of two monitors that both reach a fire the nearer one is preferred; by steps, so that no breath of an
/// error swaps them, m.
const STEP_M: f64 = 5.0;

/// A place where bearings of detectors cross.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FirePlace {
    /// The zone whose detectors report fire.
    pub zone: String,
    /// What it is worth.
    pub standing: FireStanding,
    /// East and north of the origin of the site, m.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// Height above the ground, m; null: no detector measures it.
    #[schema(required)]
    pub height_m: Option<f64>,
    /// Half of the long axis of the ellipse in which the fire is with 95 %, m.
    pub major_m: f64,
    /// Half of its short axis, m.
    pub minor_m: f64,
    /// Bearing of its long axis, 0 to 180 degrees.
    pub direction_deg: f64,
    /// Detectors whose bearings it follows from.
    pub detectors: Vec<String>,
}

/// What a place is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FireStanding {
    /// A fire: every explanation of the bearings has it.
    Sure,
    /// A fire or a ghost: a third detector or an elevation decides.
    Doubtful,
    /// Lines of sight that cross without a fire.
    Ghost,
}

/// The bearings of a zone that count as sights of fire.
#[derive(Clone, Debug, Default)]
pub struct Sights {
    zone: String,
    /// The detector of each bearing, and where it is.
    ids: Vec<String>,
    stations: Vec<station::Station>,
    bearings: Vec<Bearing>,
}

impl Sights {
    /// What the detectors of a zone show now.
    pub fn now(
        config: &ZonesConfig,
        zone: &str,
        reported: &BTreeMap<String, Reported>,
        now: Now,
    ) -> Self {
        let mut sights = Self { zone: zone.to_owned(), ..Self::default() };
        let of_zone = |it: &&lafet_site::config::Detector| it.zones.iter().any(|id| id == zone);
        for detector in config.site.detectors.iter().filter(of_zone) {
            let heard = reported.get(&detector.id);
            let (Some(station), Some(report)) = (config.stations.get(&detector.id), heard) else {
                continue;
            };
            let silent_after = Duration::from_secs(detector.silent_after_s.into());
            let age = now.saturating_sub(report.heard);
            let shown = report.bearing_deg.filter(|_| age < silent_after);
            let Some(bearing) = shown.and_then(|it| bearing(report, detector.kind, it, age)) else {
                continue;
            };
            let (station, sigma) = (station.mounted(), station.sigma);
            sights.bearings.push(Bearing { station: sights.stations.len(), sigma, ..bearing });
            sights.stations.push(station);
            sights.ids.push(detector.id.clone());
        }
        sights
    }

    /// Whether there are enough of them for a place.
    pub fn may_cross(&self) -> bool {
        self.bearings.len() >= 2
    }

    /// The places that they give. The search takes long where many of them contradict each other.
    pub fn places(&self) -> Vec<FirePlace> {
        if !self.may_cross() {
            return Vec::new();
        }
        let zone = &self.zone;
        let found = lafet_place::fires::fires(&self.stations, &self.bearings, 0.0, None);
        let found =
            found.inspect_err(|error| tracing::warn!(zone, %error, "bearings of detectors"));
        let place = |candidate: Candidate| {
            let ellipse = candidate.fix.ellipse(PROBABILITY).ok()?;
            let used = candidate.fix.used.iter();
            Some(FirePlace {
                zone: zone.clone(),
                standing: match candidate.standing {
                    Standing::Sure => FireStanding::Sure,
                    Standing::Doubtful => FireStanding::Doubtful,
                    Standing::Ghost => FireStanding::Ghost,
                },
                at: candidate.fix.at,
                height_m: candidate.fix.height_m,
                major_m: ellipse.major_m,
                minor_m: ellipse.minor_m,
                direction_deg: ellipse.direction.to_degrees(),
                detectors: used.map(|bearing| self.ids[*bearing].clone()).collect(),
            })
        };
        found.unwrap_or_default().into_iter().filter_map(place).collect()
    }

    /// Whether they are the same bearings, however old.
    pub fn are_those_of(&self, other: &Self) -> bool {
        let ageless = |it: &Bearing| Bearing { age_ms: 0, ..*it };
        self.ids == other.ids
            && self.bearings.iter().map(ageless).eq(other.bearings.iter().map(ageless))
    }

    /// Whether every detector of a place that was found by other ones sees it there still, as far as its error
    /// lets one know.
    pub fn still_show(&self, place: &FirePlace, other: &Self) -> bool {
        let of = |sights: &Self, id: &String| {
            let at = sights.ids.iter().position(|it| it == id)?;
            sights.bearings.get(at).copied()
        };
        place.detectors.iter().all(|id| {
            let (now, then) = (of(self, id), of(other, id));
            now.zip(then).is_some_and(|(now, then)| {
                wrapped(now.azimuth - then.azimuth).abs() <= SAME_SIGHT * then.sigma
            })
        })
    }
}

/// The bearing of a report; none unless it counts as a sight of fire.
fn bearing(report: &Reported, kind: Kind, bearing_deg: f64, age: Duration) -> Option<Bearing> {
    let sees = matches!(report.condition, Condition::Ready | Condition::Dirty);
    let age_ms = u32::try_from(age.as_millis()).ok().filter(|age_ms| *age_ms <= AGE_MAX_MS)?;
    (sees && report.signal == Signal::Alarm).then(|| Bearing {
        station: 0,
        // An azimuth is positive to the left, a bearing to the right.
        azimuth: wrapped(-bearing_deg.to_radians()),
        elevation: report.elevation_deg.map(f64::to_radians),
        sigma: 0.0,
        quality: report.quality.unwrap_or(1.0).clamp(QUALITY_MIN, 1.0),
        kind: match kind {
            Kind::Flame => Sense::Flame,
            Kind::Heat | Kind::LineHeat => Sense::Heat,
            _ => Sense::Picture,
        },
        age_ms,
    })
}

impl FirePlace {
    pub(super) fn is_sure(&self) -> bool {
        self.standing == FireStanding::Sure
    }

    /// Level distance from a monitor, m.
    pub(super) fn distance_m(&self, monitor: &Place) -> f64 {
        (self.at[0] - monitor.at[0]).hypot(self.at[1] - monitor.at[1])
    }

    /// Azimuth at which a monitor sees it, arc-minutes, positive to the left of its zero.
    pub(super) fn azimuth_arcmin(&self, monitor: &Place) -> f64 {
        let bearing = (self.at[0] - monitor.at[0]).atan2(self.at[1] - monitor.at[1]);
        wrapped(monitor.heading.to_radians() - bearing).to_degrees() * 60.0
    }

    /// What the jet of a monitor scans to hit it at this height; none where the request cannot say it.
    pub fn target(&self, monitor: &Place, up_m: f64) -> Option<Target> {
        let way_m = self.distance_m(monitor);
        let rise_m = up_m - monitor.height;
        let distance_m = way_m.hypot(rise_m);
        if !DISTANCE_M.contains(&distance_m) {
            return None;
        }
        let minutes = |angle: f64| angle.to_degrees() * 60.0;
        let sight = minutes(rise_m.atan2(way_m));
        let scan = |angle: f64| (2.0 * minutes(angle)).clamp(SCAN_MIN, SCAN_MAX) as i16;
        let near = rise_m.atan2((way_m - self.major_m).max(1.0));
        let far = rise_m.atan2(way_m + self.major_m);
        Some(Target {
            sector: Sector {
                centre_h: self.azimuth_arcmin(monitor).round() as i16,
                centre_v: sight.round() as i16,
                nozzle: 0,
                width: scan((self.major_m / way_m.max(1.0)).atan()),
                height: scan((far - near).abs() / 2.0),
                step: STEP_DEG,
            },
            distance: distance_m.round() as i8,
        })
    }
}

impl Hub {
    /// The monitors of a zone that have a place, best ones first; none without a sure fire. The reach of each is
    /// computed: not under the lock of the machine.
    pub(super) fn preferred(&self, monitors: &[String], fires: &[FirePlace]) -> Vec<String> {
        let sure = || fires.iter().filter(|it| it.is_sure());
        if sure().next().is_none() {
            return Vec::new();
        }
        let rank = |id: &String| {
            let station = self.station(id).ok()?;
            let place = self.place_of(id)?;
            let reaches_m = jet::reaches_m(self, &station);
            let of = |fire: &FirePlace| {
                let way_m = fire.distance_m(&place);
                let far = reaches_m.is_some_and(|most| way_m as f32 > most);
                (!self.may_aim(&station, &place, fire), far, (way_m / STEP_M) as u32)
            };
            sure().map(of).min()
        };
        let mut ranked: Vec<_> = monitors.iter().filter_map(|id| Some((rank(id)?, id))).collect();
        // Of the same rank the configured order counts.
        ranked.sort_by_key(|(rank, _)| *rank);
        ranked.into_iter().map(|(_, id)| id.clone()).collect()
    }

    /// Height at which the water comes down, m: on the roof of a tank, else where the fire was measured.
    pub(super) fn height_of(&self, fire: &FirePlace) -> f64 {
        let map = self.map();
        let mut tanks = map.iter().flat_map(|map| &map.tanks);
        let tank = tanks.find(|tank| tank.has(fire.at));
        // Not within it.
        tank.map(|tank| tank.height + 0.1).or(fire.height_m).unwrap_or_default()
    }

    /// Whether a monitor may point at a fire: its limits have it, and no keep-out is in what it scans.
    pub(super) fn may_aim(&self, station: &Station, place: &Place, fire: &FirePlace) -> bool {
        let azimuth = fire.azimuth_arcmin(place);
        let target = fire.target(place, self.height_of(fire));
        let half = target.map_or(0.0, |it| f64::from(it.sector.width) / 2.0);
        let clear = self.is_clear(station.id(), Span::around(azimuth, half));
        points(station, azimuth) && clear
    }
}

/// Whether the limits of a monitor let its barrel point there.
fn points(station: &Station, azimuth_arcmin: f64) -> bool {
    let limit = |param| f64::from(jet::parameter(station, param));
    (limit(Param::HorizontalMinLimit)..=limit(Param::HorizontalMaxLimit)).contains(&azimuth_arcmin)
}

#[cfg(test)]
mod tests {
    use lafet_site::config::Detector;

    use super::*;
    use crate::config::Station as Mounted;

    const NOW: Now = Now::from_secs(100);

    /// Detectors of a hall, and what each reports of fires at these places.
    struct Hall {
        config: ZonesConfig,
        reported: BTreeMap<String, Reported>,
    }

    impl Hall {
        fn new(stations: &[[f64; 3]], sights: &[[f64; 2]]) -> Self {
            let mut hall = Self { config: ZonesConfig::default(), reported: BTreeMap::new() };
            for (number, at) in stations.iter().enumerate() {
                for (seen, fire) in sights.iter().enumerate() {
                    // A detector has one bearing: one of two names for each fire that it sees.
                    let id = format!("D{number}{seen}");
                    let mounted = Mounted { at: *at, sigma: 0.5_f64.to_radians() };
                    hall.config.stations.insert(id.clone(), mounted);
                    hall.config.site.detectors.push(Detector {
                        id: id.clone(),
                        kind: Kind::Flame,
                        zones: vec!["hall".into()],
                        silent_after_s: 10,
                        self_test_max_s: 120,
                        dirty_votes: false,
                    });
                    let bearing = (fire[0] - at[0]).atan2(fire[1] - at[1]).to_degrees();
                    hall.reported.insert(
                        id,
                        Reported {
                            heard: NOW,
                            at_ms: 0,
                            by: String::new(),
                            signal: Signal::Alarm,
                            condition: Condition::Ready,
                            bearing_deg: Some(bearing.rem_euclid(360.0)),
                            elevation_deg: None,
                            quality: None,
                        },
                    );
                }
            }
            hall
        }

        fn places(&self, now: Now) -> Vec<FirePlace> {
            of_zone(&self.config, "hall", &self.reported, now)
        }
    }

    fn of_zone(
        config: &ZonesConfig,
        zone: &str,
        reported: &BTreeMap<String, Reported>,
        now: Now,
    ) -> Vec<FirePlace> {
        Sights::now(config, zone, reported, now).places()
    }

    const WEST_EAST: [[f64; 3]; 2] = [[-20.0, 0.0, 6.0], [20.0, 0.0, 6.0]];

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 0.01
    }

    #[test]
    fn two_bearings_that_cross_are_a_place() {
        let hall = Hall::new(&WEST_EAST, &[[10.0, 20.0]]);
        let places = hall.places(NOW);
        let [place] = &places[..] else { panic!("{places:?}") };
        assert!(near(place.at, [10.0, 20.0]) && place.is_sure(), "{place:?}");
        assert_eq!(
            (place.height_m, &place.detectors[..]),
            (None, &["D00".into(), "D10".into()][..])
        );
        // 0.5° at some 30 m are a quarter of a metre, 2.4 times that for 95 %.
        assert!((0.4..1.5).contains(&place.major_m) && place.minor_m <= place.major_m, "{place:?}");
    }

    #[test]
    fn what_does_not_report_fire_now_shows_no_place() {
        let whole = || Hall::new(&WEST_EAST, &[[10.0, 20.0]]);
        let changed = |change: fn(&mut Reported)| {
            let mut hall = whole();
            change(hall.reported.get_mut("D00").unwrap());
            hall.places(NOW)
        };
        assert_eq!(changed(|it| it.signal = Signal::PreAlarm), []);
        assert_eq!(changed(|it| it.condition = Condition::Fault), []);
        assert_eq!(changed(|it| it.condition = Condition::Masked), []);
        assert_eq!(changed(|it| it.bearing_deg = None), []);
        assert_eq!(changed(|it| it.heard = NOW - Duration::from_secs(10)), [], "it is silent");
        assert_eq!(changed(|it| it.condition = Condition::Dirty).len(), 1);
        let mut unplaced = whole();
        unplaced.config.stations.remove("D10");
        assert_eq!(unplaced.places(NOW), []);
        let elsewhere = whole();
        assert_eq!(of_zone(&elsewhere.config, "roof", &elsewhere.reported, NOW), []);
    }

    /// Two fires and two stations: four crossings, none of which may be aimed at. A third station decides.
    #[test]
    fn ghosts_of_two_fires_are_not_sure() {
        let fires = [[-8.0, 25.0], [9.0, 15.0]];
        let two = Hall::new(&WEST_EAST, &fires).places(NOW);
        assert!(two.len() >= 4 && !two.iter().any(FirePlace::is_sure), "{two:#?}");
        let three = Hall::new(&[WEST_EAST[0], WEST_EAST[1], [0.0, 60.0, 6.0]], &fires).places(NOW);
        let sure: Vec<_> = three.iter().filter(|it| it.is_sure()).map(|it| it.at).collect();
        assert_eq!(sure.len(), 2, "{three:#?}");
        assert!(fires.iter().all(|fire| sure.iter().any(|at| near(*at, *fire))), "{sure:?}");
    }

    /// The farthest that a stranger's reports can take the search.
    #[test]
    fn as_many_stations_as_allowed_take_little_time() {
        let around = |n: u32| {
            let angle = f64::from(n) * 0.392;
            [40.0 * angle.sin(), 40.0 * angle.cos(), 6.0]
        };
        let stations: Vec<_> = (0..16).map(around).collect();
        let mut hall = Hall::new(&stations, &[[3.0, 4.0]]);
        for (n, report) in (0_u32..).zip(hall.reported.values_mut()) {
            report.bearing_deg =
                report.bearing_deg.map(|it| (it + f64::from(n % 5)).rem_euclid(360.0));
        }
        let began = std::time::Instant::now();
        hall.places(NOW);
        assert!(began.elapsed() < Duration::from_secs(1), "{:?}", began.elapsed());
    }

    #[test]
    fn a_place_is_shown_while_its_detectors_see_it_there() {
        let hall = Hall::new(&WEST_EAST, &[[10.0, 20.0]]);
        let sights = |hall: &Hall| Sights::now(&hall.config, "hall", &hall.reported, NOW);
        let (before, place) = (sights(&hall), hall.places(NOW).remove(0));
        let shows = |change: &dyn Fn(&mut Reported)| {
            let mut hall = Hall::new(&WEST_EAST, &[[10.0, 20.0]]);
            change(hall.reported.get_mut("D10").unwrap());
            let now = sights(&hall);
            (now.still_show(&place, &before), now.are_those_of(&before))
        };
        let turn = |by: f64| {
            shows(&|it| it.bearing_deg = it.bearing_deg.map(|it| (it + by).rem_euclid(360.0)))
        };
        assert_eq!(shows(&|it| it.heard = NOW - Duration::from_secs(3)), (true, true));
        assert_eq!(turn(1.0), (true, false), "two standard errors");
        assert_eq!(turn(2.0), (false, false));
        assert_eq!(shows(&|it| it.signal = Signal::Quiet), (false, false));
        assert_eq!(shows(&|it| it.heard = NOW - Duration::from_secs(10)), (false, false), "silent");
    }

    #[test]
    fn a_monitor_aims_at_the_line_of_sight() {
        let hall = Hall::new(&WEST_EAST, &[[10.0, 20.0]]);
        let place = hall.places(NOW).remove(0);
        let monitor = |heading| Place { at: [0.0, 0.0], heading, height: 2.0 };
        let ahead = place.target(&monitor(0.0), 0.0).unwrap();
        // East of north: to the right, negative on the wire.
        assert_eq!((ahead.sector.centre_h, ahead.distance), (-1594, 22));
        assert_eq!(ahead.sector.centre_v, -307, "2 m down on 22.4 m");
        assert_eq!((ahead.sector.width, ahead.sector.height), (240, 240));
        let roof = place.target(&monitor(0.0), 12.0).unwrap();
        assert_eq!((roof.sector.centre_v, roof.distance), (1446, 24), "10 m up");
        assert_eq!(place.target(&monitor(90.0), 0.0).unwrap().sector.centre_h, 5400 - 1594);
        assert_eq!(
            place.target(&monitor(-179.0), 0.0).unwrap().sector.centre_h,
            -1594 - 179 * 60 + 21_600
        );
        let far = Place { at: [0.0, -120.0], heading: 0.0, height: 2.0 };
        assert_eq!(place.target(&far, 0.0), None, "the request has 127 m at most");
        let wide = FirePlace { major_m: 10.0, ..place };
        assert_eq!(wide.target(&monitor(0.0), 0.0).unwrap().sector.width, 1200);
    }
}
