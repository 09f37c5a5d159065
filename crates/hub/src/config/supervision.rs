//! Whether what is read of a device differs from what a faulty one would say.

use std::collections::BTreeMap;

use lafet_site::Condition;
use lafet_texts::{Shown, Text as _, hub as text};
use toml::Spanned;

use super::check::Check;
use super::file::File;
use crate::field::drive::Drives;
use crate::field::maps::Map;
use crate::field::point::Point;
use crate::field::{BusConfig, OutputConfig, Sort, SourceConfig};

impl Check<'_> {
    /// Each contact, and each report of an output, has a bit of its own; of two detectors it is said elsewhere.
    pub(super) fn readings(&mut self, read: &File, bus: &BusConfig) {
        let source =
            |it: &SourceConfig| (it.unit, it.map.alarm(), it.id.clone(), it.sort == Sort::Detector);
        let output = |it: &OutputConfig| Some((it.unit, it.on?, it.id.clone(), false));
        let all: Vec<(u8, Point, String, bool)> =
            bus.sources.iter().map(source).chain(bus.outputs.iter().filter_map(output)).collect();
        for (index, (unit, point, id, detector)) in all.iter().enumerate() {
            let same = |it: &&(u8, Point, String, bool)| {
                it.0 == *unit && it.1.meets(point) && !(it.3 && *detector)
            };
            if let Some((.., other, _)) = all.iter().take(index).find(same) {
                let (bus, bit) = (&bus.name, Shown(*point));
                let what = text::CheckSameReading { id, other, bit, unit: *unit, bus }.words();
                self.say(written(read, id), what, text::CheckSameReadingRemedy.words());
            }
        }
    }

    /// A zone is warned of that one device can release, if nothing would show its fault.
    pub(super) fn supervised(&mut self, read: &File, buses: &[(usize, BusConfig)]) {
        for zone in &read.zone {
            let (id, need) = (&zone.get_ref().id, usize::from(zone.get_ref().votes.need));
            let serves = |source: &SourceConfig| {
                let mut all = read.detector.iter().map(Spanned::get_ref);
                all.any(|it| it.id == source.id && it.zones.contains(id))
            };
            for (_, bus) in buses {
                let mut of_unit: BTreeMap<u8, usize> = BTreeMap::new();
                let blind = bus.sources.iter().filter(|it| is_blind(&it.map) && serves(it));
                blind.for_each(|it| *of_unit.entry(it.unit).or_default() += 1);
                let alone = of_unit.into_iter().find(|(_, count)| *count >= need.max(1));
                if let Some((unit, _)) = alone {
                    let what = text::CheckOneUnit { zone: id, unit, bus: &bus.name }.words();
                    self.warn(zone.span().start, what, text::CheckOneUnitRemedy.words());
                }
            }
        }
    }

    /// A valve or a pump is warned of that reports nothing.
    pub(super) fn confirmed(&mut self, at: usize, output: &OutputConfig) {
        if matches!(output.drives, Drives::Valve | Drives::Pump) && !output.reports() {
            let what = text::CheckUnconfirmed { id: &output.id }.words();
            self.warn(at, what, text::CheckUnconfirmedRemedy.words());
        }
    }
}

/// A detector that shows neither its own fault nor that its device works.
fn is_blind(map: &Map) -> bool {
    let Map::Bits(bits) = map else { return false };
    let fault = bits.conditions.iter().any(|(_, condition)| *condition == Condition::Fault);
    bits.heartbeat.is_none() && !fault
}

/// Where something is written.
fn written(read: &File, id: &str) -> usize {
    let inputs = read.input.iter().map(|it| (&it.get_ref().id, it.span().start));
    let outputs = read.output.iter().map(|it| (&it.get_ref().id, it.span().start));
    let pumps = read.pump.iter().map(|it| (&it.get_ref().id, it.span().start));
    let mut all = inputs.chain(outputs).chain(pumps);
    all.find(|it| it.0 == id).map_or(0, |it| it.1)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::config::{Config, Overrides, Problem};

    const ZONE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n\
        [[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n\
        [[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [\"M1\"]\n\
        [[modbus]]\nname = \"panel\"\nurl = \"tcp://10.0.0.9\"\n";

    fn parse(text: &str) -> Result<Config, Vec<Problem>> {
        Config::parse("hub.toml", text, Path::new("/"), &Overrides::default())
    }

    fn detector(id: &str, source: &str) -> String {
        format!(
            "[[detector]]\nid = \"{id}\"\nkind = \"{id}\"\nzones = [\"hall\"]\n\
             source = {{ modbus = \"panel\", {source} }}\n"
        )
    }

    fn input(id: &str, bit: &str) -> String {
        format!(
            "[[input]]\nid = \"{id}\"\nkind = \"abort\"\n\
             source = {{ modbus = \"panel\", unit = 1, on = \"{bit}\" }}\n"
        )
    }

    #[test]
    fn two_that_read_one_bit_are_refused() {
        let detectors = detector("flame", "unit = 1, alarm = \"coil:1\", fault = \"coil:2\"")
            + &detector("heat", "unit = 2, alarm = \"coil:1\", fault = \"coil:2\"");
        let valve = "[[output]]\nid = \"V\"\nkind = \"sounder\"\n\
            target = { modbus = \"panel\", unit = 1, set = \"coil:30\", on = \"coil:31\" }\n";
        let file = |inputs: &[String]| format!("{ZONE}{detectors}{valve}{}", inputs.concat());
        let (first, second) = (input("A", "coil:10"), input("B", "coil:11"));
        parse(&file(&[first.clone(), second])).unwrap();
        for (twin, other) in [("coil:10", "A"), ("coil:1", "flame"), ("coil:31", "B")] {
            let told = parse(&file(&[first.clone(), input("B", twin)])).unwrap_err();
            assert_eq!(told.len(), 1, "{told:#?}");
            let what = &told[0].what;
            assert!(what.en.contains("read the same bit") && what.ru.contains("один и тот же бит"));
            assert!(what.en.contains("B") && what.en.contains(other), "{what:?}");
        }
    }

    #[test]
    fn votes_that_one_blind_device_can_give_are_warned_of() {
        let warnings = |first: &str, second: &str| {
            let text = format!("{ZONE}{}{}", detector("flame", first), detector("heat", second));
            let warnings = parse(&text).unwrap_or_else(|it| panic!("{it:#?}")).warnings;
            warnings.iter().filter(|it| it.what.en.contains("All votes")).count()
        };
        let (first, second) = ("unit = 1, alarm = \"coil:1\"", "unit = 1, alarm = \"coil:2\"");
        assert_eq!(warnings(first, second), 1);
        assert_eq!(warnings(first, "unit = 2, alarm = \"coil:2\""), 0);
        assert_eq!(warnings(first, &format!("{second}, fault = \"coil:9\"")), 0);
        let beat = ", heartbeat = \"coil:8\", heartbeat_s = 5";
        assert_eq!(warnings(&format!("{first}{beat}"), second), 0);
    }

    #[test]
    fn a_valve_that_reports_nothing_is_warned_of() {
        let detectors = detector("flame", "unit = 1, alarm = \"coil:1\", fault = \"coil:2\"")
            + &detector("heat", "unit = 2, alarm = \"coil:1\", fault = \"coil:2\"");
        let warnings = |kind: &str, keys: &str| {
            let zone = match kind {
                "valve" => ZONE.replace("[\"M1\"]\n", "[\"M1\"]\nvalve = \"V\"\n"),
                _ => ZONE.to_owned(),
            };
            let text = format!(
                "{zone}{detectors}[[output]]\nid = \"V\"\nkind = \"{kind}\"\n\
                 target = {{ modbus = \"panel\", unit = 3, set = \"coil:30\"{keys} }}\n"
            );
            let warnings = parse(&text).unwrap_or_else(|it| panic!("{it:#?}")).warnings;
            warnings.iter().filter(|it| it.what.en.contains("Nothing shows")).count()
        };
        let unread = ", read_back = false";
        assert_eq!(warnings("valve", unread), 1);
        assert_eq!(warnings("valve", ""), 0);
        assert_eq!(warnings("valve", &format!("{unread}, on = \"coil:31\"")), 0);
        assert_eq!(warnings("sounder", unread), 0);
    }
}
