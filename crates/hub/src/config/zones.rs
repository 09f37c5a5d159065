//! The zones of a file: detectors, zones, and how each monitor aims at a zone.

use std::collections::{BTreeMap, BTreeSet};

use lafet_proto::request::{Body, Quench, Sector};
use lafet_proto::{Request, SubsystemId};
use lafet_site::config::Zone;
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;

use super::check::Check;
use super::file::File;
use super::places::values;
use crate::command::request::MonitorRequest;
use crate::error::ApiError;

/// A monitor of a zone is polled at least so often: a report that it is closed counts for a second.
const POLL_MS_MAX: u64 = 500;
/// Allowed errors of bearings, degrees, and that of who gives none.
const ERRORS_DEG: std::ops::RangeInclusive<f64> = 0.05..=10.0;
const ERROR_USUAL_DEG: f64 = 0.5;
/// Most detectors of a zone with a place: all crossings of so many lines are gone through at once.
const STATIONS_MAX: usize = 16;
/// Greatest angle, arc-minutes.
const ANGLE_MAX: i16 = 21_600;

/// The zones and what they consist of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ZonesConfig {
    /// Detectors, zones, and the monitors that serve them.
    pub site: lafet_site::Config,
    /// How a monitor aims at a zone, by zone and monitor.
    pub aims: BTreeMap<(String, String), Aim>,
    /// Detectors whose bearings show where a fire is.
    pub stations: BTreeMap<String, Station>,
}

/// A detector with a place: its bearings count from north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// East, north and up, m.
    pub at: [f64; 3],
    /// Standard error of its bearings, mounting included, rad.
    pub sigma: f64,
}

impl Station {
    /// As it is computed with.
    pub const fn mounted(&self) -> lafet_place::station::Station {
        lafet_place::station::Station::level(self.at)
    }
}

/// How a monitor aims at a zone: a stored program (§3.14), moved to a centre, and the valve of its water.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aim {
    /// The zone.
    pub zone: String,
    /// The monitor.
    pub monitor: String,
    /// Stored program, 0–7.
    #[serde(default)]
    pub program: i16,
    /// Centre, arc-minutes, positive to the left.
    pub horizontal: i16,
    /// Centre, arc-minutes, positive up.
    pub vertical: i16,
    /// Nozzle, mm.
    pub nozzle: i16,
    /// Valve of the water.
    #[serde(default)]
    pub valve: Outlet,
}

/// What the jet scans to hit a fire whose place is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Around the line of sight to it.
    pub sector: Sector,
    /// How far it is along that line, m: the monitor computes the elevation.
    pub distance: i8,
}

/// A valve of a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Outlet {
    /// `Valve1`.
    #[default]
    Valve1,
    /// `Valve2`.
    Valve2,
}

impl Aim {
    /// The request that extinguishes at a fire whose place is known, else as aimed; it deploys the monitor
    /// first, and changes no valve.
    pub fn quench(&self, fire: Option<Target>) -> Result<MonitorRequest, ApiError> {
        let quench = match fire {
            None => Quench::Program {
                program: self.program,
                centre_h: self.horizontal,
                centre_v: self.vertical,
                nozzle: self.nozzle,
            },
            Some(Target { sector, distance }) => {
                Quench::Full { sector: Sector { nozzle: self.nozzle, ..sector }, distance }
            }
        };
        MonitorRequest::new(&Request::new(SubsystemId::CONTROL, Body::StartQuench(quench)))
    }

    /// The requests that turn there without water, for a monitor that is deployed.
    pub fn turn(&self, fire: Option<Target>) -> [Result<MonitorRequest, ApiError>; 3] {
        let horizontal = fire.map_or(self.horizontal, |it| it.sector.centre_h);
        [
            (SubsystemId::HORIZONTAL, horizontal),
            (SubsystemId::VERTICAL, self.vertical),
            (SubsystemId::NOZZLE, self.nozzle),
        ]
        .map(|(drive, destination)| {
            MonitorRequest::new(&Request::new(drive, Body::Move { destination }))
        })
    }

    /// The request that opens the water.
    pub fn open(&self) -> Result<MonitorRequest, ApiError> {
        MonitorRequest::new(&Request::open(self.outlet()))
    }

    /// The valve of the water.
    pub const fn outlet(&self) -> SubsystemId {
        match self.valve {
            Outlet::Valve1 => SubsystemId::VALVE1,
            Outlet::Valve2 => SubsystemId::VALVE2,
        }
    }
}

impl Check<'_> {
    /// The zones; `None` if there are none.
    pub fn zones(&mut self, read: &File) -> Option<ZonesConfig> {
        self.undriven(read);
        if read.zone.is_empty() && read.detector.is_empty() && read.aim.is_empty() {
            return None;
        }
        // What names a table that could not be read is no mistake of its own.
        if self.lacks("zone", read.zone.len()) || self.lacks("detector", read.detector.len()) {
            return None;
        }
        let named: BTreeSet<&String> =
            read.zone.iter().flat_map(|zone| &zone.get_ref().monitors).collect();
        let known = read.monitor.iter().map(|it| it.get_ref().id.get_ref());
        let monitors: BTreeSet<&String> = known.filter(|id| named.contains(id)).collect();
        let site = lafet_site::Config {
            monitors: monitors.into_iter().cloned().collect(),
            detectors: read.detector.iter().map(|it| it.get_ref().into()).collect(),
            zones: values(&read.zone),
            contacts: read.input.iter().map(|it| it.get_ref().into()).collect(),
            outputs: read.output.iter().map(|it| it.get_ref().into()).collect(),
            pumps: read.pump.iter().map(|it| it.get_ref().into()).collect(),
            ..lafet_site::Config::default()
        };
        let places = places(read);
        for problem in site.check() {
            let at = places.get(&problem.place).copied();
            let what = text::CheckZones { place: problem.place, what: problem.what }.words();
            self.say(at.unwrap_or_else(|| first(read)), what, problem.remedy);
        }
        let whole = !self.lacks("aim", read.aim.len());
        for zone in &read.zone {
            if whole {
                self.aims_of(read, zone);
            }
            self.polls_of(read, zone);
        }
        let aims = self.aims(read);
        let stations = self.stations(read);
        Some(ZonesConfig { site, aims, stations })
    }

    /// Whether a table of the text could not be read.
    pub(super) fn lacks(&self, table: &str, read: usize) -> bool {
        let head = format!("[[{table}]]");
        self.text.lines().filter(|line| line.trim_start().starts_with(&head)).count() > read
    }

    /// What nothing reads or drives yet is not ignored in silence.
    fn undriven(&mut self, read: &File) {
        let inputs = read.input.iter().filter(|it| it.get_ref().source.is_none());
        let inputs = inputs.map(|it| ("input", it.span().start));
        let outputs = read.output.iter().filter(|it| it.get_ref().target.is_none());
        let outputs = outputs.map(|it| ("output", it.span().start));
        let pumps = read.pump.iter().filter(|it| it.get_ref().target.is_none());
        let pumps = pumps.map(|it| ("pump", it.span().start));
        for (table, at) in inputs.chain(outputs).chain(pumps) {
            self.say(at, text::CheckNoDriver { table }.words(), text::CheckNoDriverRemedy.words());
        }
    }

    /// Each monitor of a zone has to know where to aim.
    fn aims_of(&mut self, read: &File, zone: &Spanned<Zone>) {
        let id = &zone.get_ref().id;
        for monitor in &zone.get_ref().monitors {
            let aims = read.aim.iter().map(Spanned::get_ref);
            let count = aims.filter(|aim| aim.zone == *id && aim.monitor == *monitor).count();
            if count != 1 {
                self.say(
                    zone.span().start,
                    text::CheckAims { id, count, monitor }.words(),
                    text::CheckAimsRemedy { id, monitor }.words(),
                );
            }
        }
    }

    fn polls_of(&mut self, read: &File, zone: &Spanned<Zone>) {
        let id = &zone.get_ref().id;
        let named = |it: &&Spanned<super::file::Monitor>| {
            zone.get_ref().monitors.contains(it.get_ref().id.get_ref())
        };
        for monitor in read.monitor.iter().filter(named).map(Spanned::get_ref) {
            let Some(poll_ms) = &monitor.poll_ms else { continue };
            if *poll_ms.get_ref() > POLL_MS_MAX {
                let name = monitor.id.get_ref();
                self.say(
                    poll_ms.span().start,
                    text::CheckPollSeldom { name, id }.words(),
                    text::CheckPollSeldomRemedy { poll_ms_max: POLL_MS_MAX }.words(),
                );
            }
        }
    }

    /// The detectors that have a place.
    fn stations(&mut self, read: &File) -> BTreeMap<String, Station> {
        let mut stations = BTreeMap::new();
        let mut of_zone: BTreeMap<&String, usize> = BTreeMap::new();
        for detector in read.detector.iter().map(Spanned::get_ref) {
            let error = detector.error_deg.as_ref();
            let Some(at) = &detector.at else {
                if let Some(error) = error {
                    let byte = error.span().start;
                    self.say(byte, text::CheckNoPlace.words(), text::CheckNoPlaceRemedy.words());
                }
                continue;
            };
            let error_deg = error.map_or(ERROR_USUAL_DEG, |it| *it.get_ref());
            let sigma = error_deg.to_radians();
            let station = Station { at: *at.get_ref(), sigma };
            if station.mounted().check().is_err() || !ERRORS_DEG.contains(&error_deg) {
                let remedy = text::CheckStationRemedy {
                    least: *ERRORS_DEG.start(),
                    most: *ERRORS_DEG.end(),
                };
                self.say(at.span().start, text::CheckStation.words(), remedy.words());
            }
            for zone in &detector.zones {
                let count = of_zone.entry(zone).or_default();
                *count += 1;
                if *count == STATIONS_MAX + 1 {
                    self.say(
                        at.span().start,
                        text::CheckStationsTooMany { zone, most: STATIONS_MAX }.words(),
                        text::CheckStationsTooManyRemedy.words(),
                    );
                }
            }
            stations.insert(detector.id.clone(), station);
        }
        stations
    }

    fn aims(&mut self, read: &File) -> BTreeMap<(String, String), Aim> {
        let mut aims = BTreeMap::new();
        for spanned in &read.aim {
            let (aim, at) = (spanned.get_ref(), spanned.span().start);
            let zone = read.zone.iter().map(Spanned::get_ref).find(|zone| zone.id == aim.zone);
            let (name, of) = (&aim.monitor, &aim.zone);
            if !zone.is_some_and(|zone| zone.monitors.contains(name)) {
                self.say(
                    at,
                    text::CheckNotServed { name, of }.words(),
                    text::CheckNotServedRemedy.words(),
                );
            }
            let angles = [aim.horizontal, aim.vertical];
            let fine = (0..=7).contains(&aim.program)
                && angles.iter().all(|it| (-ANGLE_MAX..=ANGLE_MAX).contains(it))
                && aim.nozzle >= 0;
            if !fine {
                self.say(at, text::CheckAim.words(), text::CheckAimRemedy.words());
            }
            aims.insert((aim.zone.clone(), aim.monitor.clone()), aim.clone());
        }
        aims
    }
}

/// Where what a problem is about is written, by its place: `zone hall`.
fn places(read: &File) -> BTreeMap<String, usize> {
    let mut places = BTreeMap::new();
    let mut add = |sort: &str, id: &str, at: usize| {
        // What concerns all of a sort is reported at the first of them.
        places.entry(sort.to_owned()).or_insert(at);
        places.insert(format!("{sort} {id}"), at);
    };
    read.detector.iter().for_each(|it| add("detector", &it.get_ref().id, it.span().start));
    read.zone.iter().for_each(|it| add("zone", &it.get_ref().id, it.span().start));
    read.input.iter().for_each(|it| add("input", &it.get_ref().id, it.span().start));
    read.output.iter().for_each(|it| add("output", &it.get_ref().id, it.span().start));
    read.pump.iter().for_each(|it| add("pump", &it.get_ref().id, it.span().start));
    places
}

/// Where the zones begin.
fn first(read: &File) -> usize {
    let zones = read.zone.iter().map(|it| it.span().start);
    let detectors = read.detector.iter().map(|it| it.span().start);
    zones.chain(detectors).min().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::config::{Config, Overrides};

    const MONITOR: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n";
    const FLAME: &str = "[[detector]]\nid = \"flame\"\nkind = \"flame\"\nzones = [\"hall\"]\n";
    const HEAT: &str = "[[detector]]\nid = \"heat\"\nkind = \"heat\"\nzones = [\"hall\"]\n";
    const ZONE: &str =
        "[[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [\"M1\"]\n";
    const AIM: &str = "[[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n";

    fn parse(parts: &[&str]) -> Result<Config, Vec<[String; 3]>> {
        let read =
            Config::parse("hub.toml", &parts.concat(), Path::new("/"), &Overrides::default());
        let texts = |it: super::super::Problem| [it.place, it.what.en, it.what.ru];
        read.map_err(|problems| problems.into_iter().map(texts).collect())
    }

    #[test]
    fn zones_are_read_with_how_monitors_aim_at_them() {
        let config = parse(&[MONITOR, FLAME, HEAT, ZONE, AIM]).unwrap();
        let zones = config.zones.unwrap();
        assert_eq!(
            (zones.site.monitors.as_slice(), zones.site.zones.len()),
            (&["M1".into()][..], 1)
        );
        let aim = &zones.aims[&("hall".to_owned(), "M1".to_owned())];
        let quench = aim.quench(None).unwrap();
        assert_eq!(quench.text(), "StartQuench Control program=0 centre=600,300 nozzle=60");
        assert!(parse(&[MONITOR]).unwrap().zones.is_none());
    }

    #[test]
    fn everything_wrong_with_zones_is_told_at_once_with_its_line() {
        let zone = ZONE.replace("\"M1\"", "\"M1\", \"M9\"").replace("2oo2", "1oo2");
        let odd = AIM.replace("\"M1\"", "\"M2\"").replace("600", "30000");
        let slow = MONITOR.replace("addr=1\"", "addr=1\"\npoll_ms = 2000");
        let told = parse(&[&slow, FLAME, HEAT, &zone, AIM, &odd]).unwrap_err();
        let at = |line: u32, en: &str, ru: &str| {
            let place = format!("hub.toml:{line}");
            told.iter().any(|it| it[0] == place && it[1].contains(en) && it[2].contains(ru))
        };
        assert!(at(13, "`M9`, which is not configured", "`M9` не описан"), "{told:#?}");
        assert!(at(13, "One detector would release", "Один извещатель"), "{told:#?}");
        assert!(at(13, "0 aims of monitor M9", "наведений ствола M9"), "{told:#?}");
        assert!(at(24, "M2 does not serve", "M2 не обслуживает"), "{told:#?}");
        assert!(at(24, "No monitor can aim so", "навести ствол нельзя"), "{told:#?}");
        assert!(at(4, "too seldom", "слишком редко"), "{told:#?}");
        assert_eq!(told.len(), 6, "{told:#?}");
    }

    #[test]
    fn a_detector_has_a_place_or_says_what_is_wrong_with_it() {
        let flame = |keys: &str| format!("{FLAME}{keys}\n");
        let read = parse(&[MONITOR, &flame("at = [1, 2.5, 6]"), HEAT, ZONE, AIM]).unwrap();
        let stations = read.zones.unwrap().stations;
        assert_eq!((stations.len(), stations["flame"].at), (1, [1.0, 2.5, 6.0]));
        assert_eq!(stations["flame"].sigma, 0.5_f64.to_radians());
        for (keys, en, ru) in [
            ("at = [1, 2e5, 6]", "A detector cannot be there", "стоять не может"),
            ("at = [1, 2, nan]", "A detector cannot be there", "стоять не может"),
            ("at = [1, 2, 6]\nerror_deg = 0", "A detector cannot be there", "стоять не может"),
            ("error_deg = 1", "has no place", "место которого не указано"),
        ] {
            let told = parse(&[MONITOR, &flame(keys), HEAT, ZONE, AIM]).unwrap_err();
            assert_eq!(told.len(), 1, "{told:#?}");
            assert!(told[0][1].contains(en) && told[0][2].contains(ru), "{told:#?}");
        }
        let many: String = (0..17)
            .map(|n| {
                format!("{}at = [{n}, 0, 6]\n", FLAME.replace("flame\"\nk", &format!("f{n}\"\nk")))
            })
            .collect();
        let zone = ZONE.replace("2oo2", "2oo17");
        let told = parse(&[MONITOR, &many, &zone, AIM]).unwrap_err();
        assert!(told.iter().any(|it| it[1].contains("more than 16 detectors")), "{told:#?}");
    }

    #[test]
    fn what_has_no_driver_is_refused() {
        let more = "[[input]]\nid = \"stop\"\nkind = \"abort\"\n[[output]]\nid = \"horn\"\nkind = \"sounder\"\n\
                    [[pump]]\nid = \"P1\"\n";
        let told = parse(&[MONITOR, FLAME, HEAT, ZONE, AIM, more]).unwrap_err();
        for table in ["[[input]]", "[[output]]", "[[pump]]"] {
            let found =
                |it: &&[String; 3]| it[1].starts_with(table) && it[2].contains("драйвера нет");
            assert_eq!(told.iter().filter(found).count(), 1, "{told:#?}");
        }
        assert_eq!(told.len(), 3, "{told:#?}");
    }

    #[test]
    fn words_in_zones_are_understood_in_both_languages() {
        for (from, to, en, ru) in [
            ("\"2oo2\"", "\"two\"", "`two` is no vote", "`two` — не число голосов"),
            (
                "water_max_s",
                "water_mx_s",
                "`water_mx_s` is not known",
                "`water_mx_s` здесь неизвестно",
            ),
        ] {
            let told = parse(&[MONITOR, FLAME, HEAT, &ZONE.replace(from, to), AIM]).unwrap_err();
            assert!(told.iter().any(|it| it[1].contains(en) && it[2].contains(ru)), "{told:#?}");
        }
        let told =
            parse(&[MONITOR, FLAME, HEAT, ZONE, &AIM.replace("600", "\"left\"")]).unwrap_err();
        assert!(told[0][1].contains("a whole number is needed"), "{told:#?}");
    }
}
