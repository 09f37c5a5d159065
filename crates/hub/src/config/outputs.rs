//! Outputs and pumps of a file, and what they write on their buses.

use lafet_site::config::OutputKind;
use lafet_texts::{Shown, Text as _, hub as text};
use toml::Spanned;

use super::check::Check;
use super::field::UNITS;
use super::file::File;
use super::written::Target as Written;
use crate::field::drive::Drives;
use crate::field::point::Point;
use crate::field::target::{self, Target};
use crate::field::{BusConfig, OutputConfig, SourceConfig};

/// What is written of a bus so far: bus, device, where, by what.
type Owned = Vec<(String, u8, Target, String)>;

impl Check<'_> {
    /// Puts outputs, pumps and heartbeats on their buses.
    pub(super) fn outputs(&mut self, read: &File, buses: &mut [(usize, BusConfig)], whole: bool) {
        let mut owned = Owned::new();
        let outputs = read.output.iter().map(|it| {
            let drives = match it.get_ref().kind {
                OutputKind::Valve => Drives::Valve,
                _ => Drives::Signal,
            };
            (it.span().start, &it.get_ref().id, &it.get_ref().target, drives)
        });
        let pumps = read
            .pump
            .iter()
            .map(|it| (it.span().start, &it.get_ref().id, &it.get_ref().target, Drives::Pump));
        for (at, id, written, drives) in outputs.chain(pumps) {
            let Some(written) = written else { continue };
            if read.zone.is_empty() && !self.lacks("zone", 0) {
                self.say(at, text::CheckInputNoZone.words(), text::CheckOutputNoZoneRemedy.words());
            }
            let Some(config) = self.output(id, written, drives, buses, whole) else { continue };
            let name = written.get_ref().modbus.get_ref();
            let Some((_, bus)) = buses.iter_mut().find(|(_, bus)| bus.name == *name) else {
                continue;
            };
            self.alone(written.span().start, id, (config.unit, config.target), bus, &mut owned);
            bus.outputs.push(config);
        }
        for written in &read.modbus {
            let bus_name = written.get_ref().name.get_ref();
            let Some((_, bus)) = buses.iter_mut().find(|(_, bus)| bus.name == *bus_name) else {
                continue;
            };
            for beat in &written.get_ref().heartbeat {
                self.range(&beat.unit, UNITS, "unit");
                let Some(target) = self.target(&beat.set) else { continue };
                let unit = u8::try_from(*beat.unit.get_ref()).unwrap_or_default();
                self.alone(beat.set.span().start, "heartbeat", (unit, target), bus, &mut owned);
                bus.heartbeats.push((unit, target));
            }
        }
    }

    fn output(
        &mut self,
        id: &str,
        written: &Spanned<Written>,
        drives: Drives,
        buses: &[(usize, BusConfig)],
        whole: bool,
    ) -> Option<OutputConfig> {
        let at = written.span().start;
        let Written { modbus, unit, set, on, fault, read_back } = written.get_ref();
        let name = modbus.get_ref();
        if whole && !buses.iter().any(|(_, bus)| bus.name == *name) {
            let what = text::CheckBusUnknown { name }.words();
            let remedy = text::CheckBusUnknownRemedy { name }.words();
            self.say(modbus.span().start, what, remedy);
        }
        self.range(unit, UNITS, "unit");
        let unit = u8::try_from(*unit.get_ref()).ok().filter(|it| UNITS.contains(&(*it).into()));
        let target = self.target(set);
        let on = on.as_ref().map(|it| self.point(it));
        let fault = fault.as_ref().map(|it| self.point(it));
        let (unit, target) = (unit?, target?);
        let on = on.map_or(Some(None), |it| it.map(Some))?;
        let fault = fault.map_or(Some(None), |it| it.map(Some))?;
        if target.is_part() && !*read_back {
            let what = text::CheckPartUnread { id }.words();
            self.say(at, what, text::CheckPartUnreadRemedy.words());
        }
        if [on, fault].into_iter().flatten().any(|it: Point| target.is_read_by(&it)) {
            let what = text::CheckOwnFeedback { id, bit: Shown(target) }.words();
            self.say(at, what, text::CheckOwnFeedbackRemedy.words());
        }
        let (id, read_back) = (id.to_owned(), *read_back);
        let output = OutputConfig { id, drives, unit, target, on, fault, read_back };
        self.confirmed(at, &output);
        Some(output)
    }

    fn target(&mut self, written: &Spanned<String>) -> Option<Target> {
        match Target::parse(written.get_ref()) {
            Ok(target) => Some(target),
            Err(what) => {
                self.say(written.span().start, what, target::remedy());
                None
            }
        }
    }

    /// What is written is written by one, and is no detector or contact.
    fn alone(
        &mut self,
        at: usize,
        id: &str,
        (unit, target): (u8, Target),
        bus: &BusConfig,
        owned: &mut Owned,
    ) {
        let same = |it: &&(String, u8, Target, String)| {
            it.0 == bus.name && it.1 == unit && it.2.meets(&target)
        };
        if let Some((.., other)) = owned.iter().find(same) {
            let what = text::CheckSameTarget { id, other, bit: Shown(target) }.words();
            self.say(at, what, text::CheckSameTargetRemedy.words());
        }
        let alarms = |it: &&SourceConfig| it.unit == unit && target.is_read_by(&it.map.alarm());
        if let Some(source) = bus.sources.iter().find(alarms) {
            let what =
                text::CheckTargetAlarms { id, other: &source.id, bit: Shown(target) }.words();
            self.say(at, what, text::CheckTargetAlarmsRemedy.words());
        }
        owned.push((bus.name.clone(), unit, target, id.to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::config::{Config, Overrides};
    use crate::field::drive::Drives;

    const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n\
        [[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n\
        [[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [\"M1\"]\nvalve = \"V\"\n\
        [[detector]]\nid = \"a\"\nkind = \"flame\"\nzones = [\"hall\"]\n\
        source = { modbus = \"panel\", unit = 1, alarm = \"coil:12\" }\n\
        [[detector]]\nid = \"b\"\nkind = \"heat\"\nzones = [\"hall\"]\n\
        [[modbus]]\nname = \"panel\"\nurl = \"tcp://10.0.0.9\"\n";

    fn file(valve: &str, pump: &str) -> String {
        format!(
            "{SITE}[[output]]\nid = \"V\"\nkind = \"valve\"\ntarget = {{ {valve} }}\n\
             [[pump]]\nid = \"P\"\ntarget = {{ {pump} }}\n"
        )
    }

    fn parse(text: &str) -> Result<Config, Vec<[String; 4]>> {
        let read = Config::parse("hub.toml", text, Path::new("/"), &Overrides::default());
        let texts = |it: super::super::Problem| [it.place, it.what.en, it.what.ru, it.remedy.ru];
        read.map_err(|all| all.into_iter().map(texts).collect())
    }

    const VALVE: &str = "modbus = \"panel\", unit = 1, set = \"coil:3\", on = \"discrete:4\"";
    const PUMP: &str = "modbus = \"panel\", unit = 2, set = \"holding:100=1/0\", read_back = false";

    #[test]
    fn outputs_are_read_with_what_they_report() {
        let beats = "heartbeat = [{ unit = 1, set = \"coil:15\" }]\n";
        let text = file(VALVE, PUMP).replace("10.0.0.9\"\n", &format!("10.0.0.9\"\n{beats}"));
        let config = parse(&text).unwrap();
        let [bus] = &config.modbus[..] else { panic!("one bus") };
        let found: Vec<_> = bus.outputs.iter().map(|it| (it.id.as_str(), it.drives)).collect();
        assert_eq!(found, [("V", Drives::Valve), ("P", Drives::Pump)]);
        assert_eq!((bus.outputs[0].places().len(), bus.outputs[1].places().len()), (2, 0));
        assert_eq!(bus.heartbeats.len(), 1);
        // Who reports nothing is commanded once, as the zone controller has it.
        let site = config.zones.unwrap().site;
        assert_eq!((site.outputs[0].feedback, site.pumps[0].feedback), (true, false));
    }

    #[test]
    fn every_mistake_is_said_with_its_line_in_both_languages() {
        for (valve, pump, line, en, ru) in [
            (VALVE, "modbus = \"panel\", unit = 1, set = \"coil:3\"", 34, "both write", "пишут"),
            (
                VALVE,
                "modbus = \"panel\", unit = 1, set = \"coil:12\"",
                34,
                "is read as",
                "читается",
            ),
            (
                VALVE,
                "modbus = \"pannel\", unit = 1, set = \"coil:9\"",
                34,
                "no bus pannel",
                "pannel нет",
            ),
            (
                VALVE,
                "modbus = \"panel\", unit = 0, set = \"coil:9\"",
                34,
                "unit = 0 is",
                "unit = 0 вне",
            ),
            (
                VALVE,
                "modbus = \"panel\", unit = 1, set = \"input:9.1\"",
                34,
                "only read",
                "только чит",
            ),
            (
                VALVE,
                "modbus = \"panel\", unit = 1, set = \"holding:9.1\", read_back = false",
                34,
                "cannot be left",
                "не прочитав",
            ),
            (
                "modbus = \"panel\", unit = 1, set = \"coil:3\", on = \"coil:3\"",
                PUMP,
                31,
                "says what",
                "то, что",
            ),
            (
                "modbus = \"panel\", set = \"coil:3\"",
                PUMP,
                31,
                "`unit` is missing",
                "Не хватает `unit`",
            ),
        ] {
            let said = parse(&file(valve, pump)).unwrap_err();
            let found = |it: &[String; 4]| {
                it[0] == format!("hub.toml:{line}") && it[1].contains(en) && it[2].contains(ru)
            };
            assert!(said.iter().any(found), "{valve} {pump}: {said:#?}");
            assert!(said.iter().all(|it| it[3].len() > 10) && said.len() <= 2, "{said:#?}");
        }
        // The same bits of different devices are different bits.
        let other = "modbus = \"panel\", unit = 2, set = \"coil:3\"";
        assert!(parse(&file(VALVE, other)).is_ok());
        let beat = "heartbeat = [{ unit = 1, set = \"coil:3\" }]\n";
        let text = file(VALVE, PUMP).replace("10.0.0.9\"\n", &format!("10.0.0.9\"\n{beat}"));
        assert!(parse(&text).unwrap_err()[0][1].contains("heartbeat and V both write"));
    }

    #[test]
    fn an_output_of_no_zone_and_one_without_a_target_are_refused() {
        let text = file(VALVE, PUMP);
        let (monitor, bus) =
            (SITE.split("[[aim]]").next().unwrap(), text.find("[[modbus]]").unwrap());
        let said = parse(&format!("{monitor}{}", &text[bus..])).unwrap_err();
        assert!(said.iter().any(|it| it[1] == "There is no zone for it."), "{said:#?}");
        let said = parse(&text.replace(&format!("target = {{ {PUMP} }}\n"), "")).unwrap_err();
        assert!(said[0][1].starts_with("[[pump]]") && said[0][2].contains("драйвера"), "{said:#?}");
    }
}
