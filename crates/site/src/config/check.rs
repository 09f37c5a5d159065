//! What a configuration may say. Each problem says where, what and what to do.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::{Config, ContactKind, OutputKind, Reduced, Zone};
use crate::text::{Both, both};

/// Most things of one sort.
const MOST: usize = 1024;
/// Longest id, in characters.
const ID_MAX: usize = 64;

/// What is wrong with a configuration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Problem {
    /// Where: `zone hall`.
    pub place: String,
    /// What is wrong.
    pub what: Both,
    /// What to do.
    pub remedy: Both,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} {}", self.place, self.what.en, self.remedy.en)
    }
}

impl Config {
    /// All problems; none if the site can run by it.
    pub fn check(&self) -> Vec<Problem> {
        let mut check = Check { config: self, problems: Vec::new() };
        check.ids();
        check.range("site", "run_on_s", self.run_on_s, 0..=3600);
        check.detectors();
        for zone in &self.zones {
            check.zone(zone);
        }
        check.contacts();
        check.outputs();
        check.pumps();
        check.problems
    }
}

struct Check<'a> {
    config: &'a Config,
    problems: Vec<Problem>,
}

impl Check<'_> {
    fn say(&mut self, place: impl Into<String>, what: Both, remedy: Both) {
        self.problems.push(Problem { place: place.into(), what, remedy });
    }

    fn range(&mut self, place: &str, key: &str, value: u32, range: RangeInclusive<u32>) {
        if !range.contains(&value) {
            let (least, most) = (range.start(), range.end());
            self.say(
                place,
                both(
                    format!("{key} = {value} is out of range."),
                    format!("{key} = {value} вне диапазона."),
                ),
                both(format!("Write {least} to {most}."), format!("Укажите от {least} до {most}.")),
            );
        }
    }

    /// A name that has to be one of a list.
    fn known<'i>(
        &mut self,
        place: &str,
        key: &str,
        name: &str,
        mut list: impl Iterator<Item = &'i str>,
    ) {
        if !list.any(|known| known == name) {
            self.say(
                place,
                both(
                    format!("{key} names `{name}`, which is not configured."),
                    format!("{key}: `{name}` не описан."),
                ),
                both("Correct the name or add it.", "Исправьте имя или добавьте описание."),
            );
        }
    }

    /// Names of a list that has to be of known and different names.
    fn list<'i>(
        &mut self,
        place: &str,
        key: &str,
        names: &[String],
        list: impl Iterator<Item = &'i str> + Clone,
    ) {
        let mut seen = BTreeSet::new();
        for name in names {
            self.known(place, key, name, list.clone());
            if !seen.insert(name) {
                self.say(
                    place,
                    both(
                        format!("{key} names `{name}` twice."),
                        format!("{key}: `{name}` указан дважды."),
                    ),
                    both("Name it once.", "Укажите его один раз."),
                );
            }
        }
    }

    fn ids(&mut self) {
        let config = self.config;
        let sorts: [(&str, Vec<&str>); 7] = [
            ("monitors", config.monitors.iter().map(String::as_str).collect()),
            ("detector", config.detectors.iter().map(|it| it.id.as_str()).collect()),
            ("zone", config.zones.iter().map(|it| it.id.as_str()).collect()),
            ("input", config.contacts.iter().map(|it| it.id.as_str()).collect()),
            ("output", config.outputs.iter().map(|it| it.id.as_str()).collect()),
            ("pump", config.pumps.iter().map(|it| it.id.as_str()).collect()),
            ("paths", config.paths.iter().map(String::as_str).collect()),
        ];
        // A fault of a path is reported by the id of an input, an output or a further path.
        let mut paths = BTreeMap::new();
        for (sort, ids) in &sorts {
            let mut seen = BTreeSet::new();
            let path = matches!(*sort, "input" | "output" | "paths");
            for id in ids {
                if id.is_empty() || id.chars().count() > ID_MAX {
                    self.say(
                        *sort,
                        both(
                            format!("The id `{id}` is empty or too long."),
                            format!("Имя `{id}` пустое или слишком длинное."),
                        ),
                        both(
                            format!("Write 1 to {ID_MAX} characters."),
                            format!("Укажите от 1 до {ID_MAX} символов."),
                        ),
                    );
                }
                let twice = !seen.insert(*id) || (path && paths.insert(*id, *sort).is_some());
                if twice {
                    self.say(
                        format!("{sort} {id}"),
                        both("The id is used twice.", "Имя использовано дважды."),
                        both("Give each its own id.", "Дайте каждому своё имя."),
                    );
                }
            }
            if ids.len() > MOST {
                self.say(
                    *sort,
                    both(
                        format!("{} are too many.", ids.len()),
                        format!("{} — слишком много.", ids.len()),
                    ),
                    both(
                        format!("{MOST} at most; divide the site."),
                        format!("Не более {MOST}; разделите объект."),
                    ),
                );
            }
        }
    }

    fn detectors(&mut self) {
        let config = self.config;
        for detector in &config.detectors {
            let place = format!("detector {}", detector.id);
            self.range(&place, "silent_after_s", detector.silent_after_s, 1..=3600);
            self.range(&place, "self_test_max_s", detector.self_test_max_s, 1..=3600);
            self.list(
                &place,
                "zones",
                &detector.zones,
                config.zones.iter().map(|it| it.id.as_str()),
            );
            if detector.zones.is_empty() {
                self.say(
                    place,
                    both(
                        "It has no zone, so its alarm would show nowhere.",
                        "Не указана зона: тревога нигде не будет показана.",
                    ),
                    both("Name its zone in `zones`.", "Укажите зону в `zones`."),
                );
            }
        }
    }

    fn zone(&mut self, zone: &Zone) {
        let place = format!("zone {}", zone.id);
        self.range(&place, "coincidence_s", zone.coincidence_s, 0..=60);
        self.range(&place, "delay_s", zone.delay_s, 0..=60);
        self.range(&place, "hold_max_s", zone.hold_max_s, 1..=600);
        self.range(&place, "water_max_s", zone.water_max_s, 1..=7200);
        self.range(&place, "act_within_s", zone.act_within_s, 1..=300);
        if let Some(value) = zone.quiet_ends_s {
            self.range(&place, "quiet_ends_s", value, 1..=3600);
        }
        if let Some(value) = zone.return_after_s {
            self.range(&place, "return_after_s", value, 1..=604_800);
        }
        if zone.mode.is_test() {
            self.say(
                place.clone(),
                both(
                    "A zone cannot start in a test.",
                    "Зона не может начинать работу с испытания.",
                ),
                both("Write automatic, manual or off.", "Укажите automatic, manual или off."),
            );
        }
        self.votes(&place, zone);
        self.reduced(&place, zone);
        self.serving(&place, zone);
    }

    fn votes(&mut self, place: &str, zone: &Zone) {
        let detectors = self.config.detectors.iter().filter(|it| it.zones.contains(&zone.id));
        let kinds: BTreeSet<_> = detectors.clone().map(|it| it.kind).collect();
        let count = detectors.count();
        let votes = zone.votes;
        if votes.need == 0 || votes.need > votes.of {
            self.say(
                place,
                both(
                    format!("votes = {votes} needs no vote, or more than there are."),
                    format!("votes = {votes}: голосов не нужно или нужно больше, чем есть."),
                ),
                both("Write, for example, 2oo3.", "Укажите, например, 2oo3."),
            );
        }
        if usize::from(votes.of) != count {
            self.say(
                place,
                both(
                    format!("votes = {votes}, but the zone has {count} detectors."),
                    format!("votes = {votes}, но в зоне извещателей: {count}."),
                ),
                both(
                    format!("Write …oo{count}, or correct `zones` of the detectors."),
                    format!("Укажите …oo{count} или исправьте `zones` извещателей."),
                ),
            );
        }
        if votes.need == 1 && !zone.one_detector_releases {
            self.say(
                place,
                both(
                    "One detector would release water by itself.",
                    "Один извещатель сам подал бы воду.",
                ),
                both(
                    "Require two votes, or write one_detector_releases = true.",
                    "Потребуйте два голоса или укажите one_detector_releases = true.",
                ),
            );
        }
        let needed = usize::from(zone.kinds);
        if zone.kinds == 0 || zone.kinds > votes.need || needed > kinds.len() {
            self.say(
                place,
                both(
                    format!("kinds = {needed} can never be met: {votes}, {} kinds.", kinds.len()),
                    format!("kinds = {needed} невыполнимо: {votes}, видов: {}.", kinds.len()),
                ),
                both(
                    "Write 1 to the number of votes and of kinds in the zone.",
                    "Укажите от 1 до числа голосов и видов в зоне.",
                ),
            );
        }
    }

    fn reduced(&mut self, place: &str, zone: &Zone) {
        for (index, reduced) in zone.when_failed.iter().enumerate() {
            let Reduced::Votes(votes) = *reduced else { continue };
            let failed = index + 1;
            let left = usize::from(zone.votes.of).saturating_sub(failed);
            let wrong = votes.need == 0 || votes.need > votes.of || usize::from(votes.of) != left;
            if wrong || votes.need < zone.kinds {
                self.say(
                    place,
                    both(
                        format!(
                            "when_failed: {votes} does not fit {failed} failed of {}.",
                            zone.votes.of
                        ),
                        format!(
                            "when_failed: {votes} не подходит к {failed} отказавшим из {}.",
                            zone.votes.of
                        ),
                    ),
                    both(
                        format!(
                            "Write …oo{left} with at least {} votes, or \"alarm\".",
                            zone.kinds.max(1)
                        ),
                        format!(
                            "Укажите …oo{left} не менее чем с {} голосами или \"alarm\".",
                            zone.kinds.max(1)
                        ),
                    ),
                );
            } else if votes.need == 1 && !zone.one_detector_releases {
                self.say(
                    place,
                    both(
                        format!(
                            "when_failed: with {failed} failed, one detector would release water."
                        ),
                        format!(
                            "when_failed: при {failed} отказавших воду подал бы один извещатель."
                        ),
                    ),
                    both(
                        "Write \"alarm\", or one_detector_releases = true.",
                        "Укажите \"alarm\" или one_detector_releases = true.",
                    ),
                );
            }
        }
    }

    fn serving(&mut self, place: &str, zone: &Zone) {
        let config = self.config;
        self.list(place, "monitors", &zone.monitors, config.monitors.iter().map(String::as_str));
        if zone.monitors.is_empty() {
            self.say(
                place,
                both("No monitor serves it.", "Зону не обслуживает ни один ствол."),
                both("Name its monitors in `monitors`.", "Укажите стволы в `monitors`."),
            );
        }
        if let Some(jets) = zone.jets
            && (jets == 0 || usize::from(jets) > zone.monitors.len())
        {
            self.say(
                place,
                both(
                    format!("jets = {jets}, but {} monitors serve it.", zone.monitors.len()),
                    format!("jets = {jets}, а стволов: {}.", zone.monitors.len()),
                ),
                both("Write 1 to the number of its monitors.", "Укажите от 1 до числа её стволов."),
            );
        }
        let valves = || {
            let valves = config.outputs.iter().filter(|it| it.kind == OutputKind::Valve);
            valves.map(|it| it.id.as_str())
        };
        for (key, output) in [("valve", &zone.valve), ("test_outlet", &zone.test_outlet)] {
            if let Some(output) = output {
                self.known(place, key, output, valves());
            }
        }
        let users = |output: &str| {
            let named = config.zones.iter().flat_map(|it| [&it.valve, &it.test_outlet]);
            named.flatten().filter(|it| *it == output).count()
        };
        for output in [&zone.valve, &zone.test_outlet].into_iter().flatten() {
            if users(output) > 1 {
                self.say(
                    place,
                    both(
                        format!("The valve `{output}` is used more than once."),
                        format!("Клапан `{output}` использован несколько раз."),
                    ),
                    both(
                        "Give each zone and test outlet its own valve.",
                        "Дайте каждой зоне и каждому испытательному выпуску свой клапан.",
                    ),
                );
            }
        }
    }

    fn contacts(&mut self) {
        let config = self.config;
        for contact in &config.contacts {
            let place = format!("input {}", contact.id);
            self.range(&place, "debounce_ms", contact.debounce_ms, 0..=1000);
            self.list(
                &place,
                "zones",
                &contact.zones,
                config.zones.iter().map(|it| it.id.as_str()),
            );
            let whole = matches!(contact.kind, ContactKind::Lockout | ContactKind::Pressure);
            if whole && !contact.zones.is_empty() {
                self.say(
                    place.clone(),
                    both(
                        "Lockout and pressure are for the whole site.",
                        "Блокировка и давление относятся ко всему объекту.",
                    ),
                    both("Remove `zones`.", "Удалите `zones`."),
                );
            }
            if contact.kind == ContactKind::Release && contact.zones.is_empty() {
                self.say(
                    place,
                    both(
                        "A release station without zones would start the whole site.",
                        "Пост пуска без зон пустил бы весь объект.",
                    ),
                    both("Name its zones.", "Укажите его зоны."),
                );
            }
        }
    }

    fn outputs(&mut self) {
        let config = self.config;
        for output in &config.outputs {
            let place = format!("output {}", output.id);
            if let Some(zone) = &output.zone {
                self.known(&place, "zone", zone, config.zones.iter().map(|it| it.id.as_str()));
            }
            let named = config.zones.iter().flat_map(|it| [&it.valve, &it.test_outlet]);
            let used = named.flatten().any(|it| *it == output.id);
            if output.kind == OutputKind::Valve && !used {
                self.say(
                    place,
                    both("No zone uses this valve.", "Этот клапан не использует ни одна зона."),
                    both(
                        "Name it in `valve` or `test_outlet` of a zone.",
                        "Укажите его в `valve` или `test_outlet` зоны.",
                    ),
                );
            }
        }
    }

    fn pumps(&mut self) {
        let config = self.config;
        for pump in &config.pumps {
            let place = format!("pump {}", pump.id);
            self.range(&place, "start_delay_s", pump.start_delay_s, 0..=120);
            self.range(&place, "start_timeout_s", pump.start_timeout_s, 1..=300);
            let gauges = config.contacts.iter().filter(|it| it.kind == ContactKind::Pressure);
            if let Some(pressure) = &pump.pressure {
                self.known(&place, "pressure", pressure, gauges.map(|it| it.id.as_str()));
            }
        }
        if !config.pumps.is_empty() && config.pumps.iter().all(|pump| pump.standby) {
            self.say(
                "pump",
                both(
                    "All pumps are on standby, so none would ever start.",
                    "Все насосы резервные: ни один не запустился бы.",
                ),
                both("Remove `standby` from one of them.", "Уберите `standby` у одного из них."),
            );
        }
    }
}
