//! The buses of a file, and what is on them.

use std::time::Duration;

use lafet_client::Endpoint;
use lafet_site::config::ContactKind;
use lafet_texts::{Shown, Text as _, hub as text};
use toml::Spanned;

use super::check::{Check, is_name};
use super::file::File;
use super::written::{Bus, Detector, Named, Source};
use crate::field::line::Line;
use crate::field::maps::{Bits, Map, View};
use crate::field::point::{self, Point};
use crate::field::{BusConfig, Sort, SourceConfig};
use crate::text::Both;

/// Allowed times between two reads of a device, ms.
const POLL_MS: std::ops::RangeInclusive<u64> = 50..=5000;
const POLL_USUAL_MS: u64 = 250;
/// Allowed times for an answer, ms.
const TIMEOUT_MS: std::ops::RangeInclusive<u64> = 20..=5000;
const TIMEOUT_USUAL_MS: u64 = 500;
/// Allowed times for which a detector counts as starting up, s.
const SETTLE_S: std::ops::RangeInclusive<u32> = 0..=600;
const SETTLE_USUAL_S: u32 = 30;
/// Allowed times for which a heartbeat may stand still, s.
const BEAT_S: std::ops::RangeInclusive<u32> = 1..=600;
/// Addresses of devices.
pub(super) const UNITS: std::ops::RangeInclusive<u32> = 1..=247;
/// The greatest first register of an FV300: its block ends within the table.
const FV300_MAX: u32 = 65_535 - 21;

impl Check<'_> {
    /// The buses, with the detectors that are on them.
    pub fn modbus(&mut self, read: &File) -> Vec<BusConfig> {
        let mut buses: Vec<(usize, BusConfig)> = Vec::new();
        for written in &read.modbus {
            if let Some(bus) = self.bus(read, written.get_ref(), &buses) {
                buses.push((written.span().start, bus));
            }
        }
        // What names a table that could not be read, or its mistakes, is no mistake of its own.
        let whole = !self.lacks("modbus", read.modbus.len()) && buses.len() == read.modbus.len();
        let mut alarms: Vec<(String, u8, Point, String)> = Vec::new();
        for written in &read.detector {
            let detector = written.get_ref();
            let Some(source) = &detector.source else { continue };
            let Some(map) = self.source(source, &buses, whole) else { continue };
            let name = source.get_ref().modbus.get_ref();
            let Some((_, bus)) = buses.iter_mut().find(|(_, bus)| bus.name == *name) else {
                continue;
            };
            let unit = u8::try_from(*source.get_ref().unit.get_ref()).unwrap_or_default();
            let alarm = map.alarm();
            let same = |it: &&(String, u8, Point, String)| {
                it.0 == *name && it.1 == unit && it.2.meets(&alarm)
            };
            if let Some((.., other)) = alarms.iter().find(same) {
                self.same_bit(source.span().start, &detector.id, other, alarm);
            }
            alarms.push((name.clone(), unit, alarm, detector.id.clone()));
            self.soon_enough(source, detector, bus);
            let (id, silent_after_s) = (detector.id.clone(), detector.silent_after_s);
            let sort = Sort::Detector;
            bus.sources.push(SourceConfig { id, sort, unit, map, silent_after_s });
        }
        self.contacts(read, &mut buses, whole);
        self.outputs(read, &mut buses, whole);
        buses.iter().for_each(|(_, bus)| self.readings(read, bus));
        let whole = whole
            && !self.lacks("detector", read.detector.len())
            && !self.lacks("input", read.input.len())
            && !self.lacks("output", read.output.len())
            && !self.lacks("pump", read.pump.len());
        for (at, bus) in &buses {
            self.bus_as_a_whole(*at, bus, whole, read);
        }
        self.supervised(read, &buses);
        buses.into_iter().map(|(_, bus)| bus).collect()
    }

    fn contacts(&mut self, read: &File, buses: &mut [(usize, BusConfig)], whole: bool) {
        for written in &read.input {
            let contact = written.get_ref();
            let Some(given) = &contact.source else { continue };
            if read.zone.is_empty() && !self.lacks("zone", 0) {
                let what = text::CheckInputNoZone.words();
                let remedy = text::CheckInputNoZoneRemedy.words();
                self.say(written.span().start, what, remedy);
            }
            let source = Spanned::new(given.span(), Source::from(given.get_ref().clone()));
            let Some(map) = self.source(&source, buses, whole) else { continue };
            let (name, id) = (source.get_ref().modbus.get_ref(), contact.id.clone());
            let Some((_, bus)) = buses.iter_mut().find(|(_, bus)| bus.name == *name) else {
                continue;
            };
            let least = 2 * bus.poll_ms;
            if contact.kind == ContactKind::Release && u64::from(contact.debounce_ms) < least {
                let what = text::CheckSingleReading { id: &id }.words();
                let remedy = text::CheckSingleReadingRemedy { least, name }.words();
                self.say(written.span().start, what, remedy);
            }
            let unit = u8::try_from(*source.get_ref().unit.get_ref()).unwrap_or_default();
            // What counts for a contact are the periods of its bus.
            let silent_after_s = u32::MAX;
            bus.sources.push(SourceConfig { id, sort: Sort::Contact, unit, map, silent_after_s });
        }
    }

    fn bus(
        &mut self,
        read: &File,
        written: &Bus,
        others: &[(usize, BusConfig)],
    ) -> Option<BusConfig> {
        let (name, at) = (written.name.get_ref(), written.name.span().start);
        if !is_name(name) {
            let what = text::CheckBusName { name }.words();
            let remedy = text::CheckBusNameRemedy.words();
            self.say(at, what, remedy);
        } else if others.iter().any(|(_, other)| other.name == *name) {
            let what = text::CheckBusTwice { name }.words();
            let remedy = text::CheckBusTwiceRemedy.words();
            self.say(at, what, remedy);
        }
        for (value, range, key) in [
            (&written.poll_ms, POLL_MS, "poll_ms"),
            (&written.timeout_ms, TIMEOUT_MS, "timeout_ms"),
        ] {
            if let Some(value) = value {
                self.range(value, range, key);
            }
        }
        if let Some(settle) = &written.settle_s {
            self.range(settle, SETTLE_S, "settle_s");
        }
        let line = self.line(&written.url)?;
        self.one_user(written.url.span().start, &line, read, others);
        let or =
            |value: &Option<Spanned<u64>>, usual| value.as_ref().map_or(usual, |it| *it.get_ref());
        Some(BusConfig {
            name: name.clone(),
            line,
            poll_ms: or(&written.poll_ms, POLL_USUAL_MS),
            timeout_ms: or(&written.timeout_ms, TIMEOUT_USUAL_MS),
            settle_s: written.settle_s.as_ref().map_or(SETTLE_USUAL_S, |it| *it.get_ref()),
            sources: Vec::new(),
            outputs: Vec::new(),
            heartbeats: Vec::new(),
        })
    }

    /// A line has one master.
    fn one_user(&mut self, at: usize, line: &Line, read: &File, others: &[(usize, BusConfig)]) {
        let same = |other: &Line| match (line, other) {
            (Line::Serial { path, .. }, Line::Serial { path: other, .. }) => path == other,
            _ => line.to_string() == other.to_string(),
        };
        let urls = read.monitor.iter().map(|it| it.get_ref().url.get_ref());
        let has_port = |endpoint: Endpoint| match (line, endpoint) {
            (Line::Serial { path, .. }, Endpoint::Serial { path: other, .. }) => *path == other,
            (Line::Tcp { host, port, .. }, Endpoint::Tcp { host: other, port: of_other, .. }) => {
                *host == other && *port == of_other
            }
            _ => false,
        };
        if let Some((_, other)) = others.iter().find(|(_, other)| same(&other.line)) {
            let name = &other.name;
            let what = text::CheckBusSameLine { name }.words();
            let remedy = text::CheckBusSameLineRemedy.words();
            self.say(at, what, remedy);
        }
        if urls.into_iter().filter_map(|url| url.parse().ok()).any(has_port) {
            let what = text::CheckBusWithMonitor.words();
            let remedy = text::CheckBusWithMonitorRemedy.words();
            self.say(at, what, remedy);
        }
    }

    /// The map of a detector, if nothing is wrong with it.
    fn source(
        &mut self,
        written: &Spanned<Source>,
        buses: &[(usize, BusConfig)],
        whole: bool,
    ) -> Option<Map> {
        let source = written.get_ref();
        let (name, at) = (source.modbus.get_ref(), source.modbus.span().start);
        if whole && !buses.iter().any(|(_, bus)| bus.name == *name) {
            let what = text::CheckBusUnknown { name }.words();
            let remedy = text::CheckBusUnknownRemedy { name }.words();
            self.say(at, what, remedy);
        }
        let unit_is_fine = UNITS.contains(source.unit.get_ref());
        self.range(&source.unit, UNITS, "unit");
        if let Some((key, at)) = source.stray(source.map) {
            let what = text::CheckKeyMeaningless { key }.words();
            let remedy = text::CheckKeyMeaninglessRemedy.words();
            self.say(at, what, remedy);
            return None;
        }
        let map = match source.map {
            Some(Named::Fv300) => self.fv300(source),
            Some(Named::Notifier) => self.notifier(written),
            None => self.bits(written),
        };
        map.filter(|_| unit_is_fine)
    }

    fn register(&mut self, register: &Spanned<u32>, most: u32) -> Option<u16> {
        self.range(register, 0..=most, "register");
        u16::try_from(*register.get_ref()).ok().filter(|it| u32::from(*it) <= most)
    }

    fn fv300(&mut self, source: &Source) -> Option<Map> {
        let base = match &source.register {
            None => 0,
            Some(register) => self.register(register, FV300_MAX)?,
        };
        let view = match (&source.axis, &source.field) {
            (None, None) => None,
            (Some(axis), Some(field)) => Some(self.view(axis, field)?),
            (axis, field) => {
                let at = axis.as_ref().or(field.as_ref()).map_or(0, |it| it.span().start);
                let what = text::CheckAxisAndField.words();
                self.say(at, what, view_remedy());
                return None;
            }
        };
        Some(Map::Fv300 { base, view })
    }

    fn view(&mut self, axis: &Spanned<[f64; 2]>, field: &Spanned<[f64; 2]>) -> Option<View> {
        let ([bearing, elevation], [width, height]) = (*axis.get_ref(), *field.get_ref());
        let fine = (0.0..=360.0).contains(&bearing)
            && (-90.0..=90.0).contains(&elevation)
            && (1.0..=180.0).contains(&width)
            && (1.0..=180.0).contains(&height);
        if !fine {
            let what = text::CheckView.words();
            self.say(axis.span().start, what, view_remedy());
            return None;
        }
        let [bearing, elevation, width, height] =
            [bearing, elevation, width, height].map(|it| (it * 10.0).round() as i32);
        Some(View { bearing, elevation, width, height })
    }

    fn notifier(&mut self, written: &Spanned<Source>) -> Option<Map> {
        let Some(register) = &written.get_ref().register else {
            let what = text::CheckRegisterMissing.words();
            let remedy = text::CheckRegisterMissingRemedy.words();
            self.say(written.span().start, what, remedy);
            return None;
        };
        Some(Map::Notifier { register: self.register(register, u32::from(u16::MAX))? })
    }

    fn bits(&mut self, written: &Spanned<Source>) -> Option<Map> {
        let source = written.get_ref();
        let Some(alarm) = &source.alarm else {
            let what = text::CheckAlarmBitMissing.words();
            let remedy = text::CheckAlarmBitMissingRemedy.words();
            self.say(written.span().start, what, remedy);
            return None;
        };
        let alarm = self.point(alarm);
        let pre_alarm = source.pre_alarm.as_ref().map(|it| self.point(it));
        let mut conditions = Vec::new();
        for (bit, condition) in source.conditions() {
            if let Some(bit) = bit {
                conditions.push(self.point(bit).map(|point| (point, condition)));
            }
        }
        let heartbeat = source.heartbeat.as_ref().map(|it| self.point(it));
        let beat_s = match &source.heartbeat_s {
            Some(seconds) => {
                self.range(seconds, BEAT_S, "heartbeat_s");
                Some(*seconds.get_ref())
            }
            None => None,
        };
        if let (Some(bit), None) = (&source.heartbeat, beat_s) {
            let what = text::CheckHeartbeat.words();
            let remedy = text::CheckHeartbeatRemedy.words();
            self.say(bit.span().start, what, remedy);
            return None;
        }
        let within = Duration::from_secs(beat_s.unwrap_or_default().into());
        Some(Map::Bits(Box::new(Bits {
            alarm: alarm?,
            pre_alarm: pre_alarm.map_or(Some(None), |it| it.map(Some))?,
            conditions: conditions.into_iter().collect::<Option<_>>()?,
            heartbeat: heartbeat.map_or(Some(None), |it| it.map(|point| Some((point, within))))?,
        })))
    }

    pub(super) fn point(&mut self, written: &Spanned<String>) -> Option<Point> {
        match Point::parse(written.get_ref()) {
            Ok(point) => Some(point),
            Err(what) => {
                self.say(written.span().start, what, point::remedy());
                None
            }
        }
    }

    fn same_bit(&mut self, at: usize, id: &str, other: &str, bit: Point) {
        let what = text::CheckSameBit { id, other, bit: Shown(bit) }.words();
        let remedy = text::CheckSameBitRemedy.words();
        self.say(at, what, remedy);
    }

    /// A value is new often enough for the detector not to be silent.
    fn soon_enough(&mut self, source: &Spanned<Source>, detector: &Detector, bus: &BusConfig) {
        let (own, silent) =
            (2 * (bus.poll_ms + bus.timeout_ms), u64::from(detector.silent_after_s) * 1000);
        if own > silent {
            let (id, name, least) = (&detector.id, &bus.name, own.div_ceil(1000));
            let what = text::CheckSilentTooSoon { id, silent, name, own }.words();
            let remedy = text::CheckSilentTooSoonRemedy { name, least }.words();
            self.say(source.span().start, what, remedy);
        }
    }

    fn bus_as_a_whole(&mut self, at: usize, bus: &BusConfig, whole: bool, read: &File) {
        let name = &bus.name;
        let detectors = read.detector.iter().filter_map(|it| it.get_ref().source.as_ref());
        let inputs = read.input.iter().filter_map(|it| it.get_ref().source.as_ref());
        let named = detectors.map(|it| it.get_ref().modbus.get_ref());
        let named = named.chain(inputs.map(|it| it.get_ref().modbus.get_ref()));
        let outputs = read.output.iter().filter_map(|it| it.get_ref().target.as_ref());
        let pumps = read.pump.iter().filter_map(|it| it.get_ref().target.as_ref());
        let targets = outputs.chain(pumps).map(|it| it.get_ref().modbus.get_ref());
        let mut named = named.chain(targets);
        if whole && !named.any(|it| it == name) {
            let what = text::CheckBusUnused { name }.words();
            let remedy = text::CheckBusUnusedRemedy { name }.words();
            self.say(at, what, remedy);
        }
        let round = u64::try_from(bus.round().as_millis()).unwrap_or(u64::MAX);
        if round > bus.poll_ms {
            let what = text::CheckRoundTooLong { name, round, poll_ms: bus.poll_ms }.words();
            let remedy =
                text::CheckRoundTooLongRemedy { poll_ms: round.next_multiple_of(50) }.words();
            self.say(at, what, remedy);
        }
    }
}

fn view_remedy() -> Both {
    text::CheckViewRemedy.words()
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
