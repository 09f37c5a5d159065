//! What a file may say of buses and of the detectors on them.

use std::path::Path;

use crate::config::{Config, Overrides};
use crate::field::{BusConfig, Sort};

const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"serial:///dev/ttyUSB0?addr=1\"\n\
    [[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n\
    [[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [\"M1\"]\n";
const BUS: &str = "[[modbus]]\nname = \"panel\"\nurl = \"tcp://10.0.0.9\"\n";
const BITS: &str = "modbus = \"panel\", unit = 1, alarm = \"discrete:12\"";
const FV300: &str = "modbus = \"panel\", unit = 2, map = \"fv300\"";

fn detector(id: &str, source: &str) -> String {
    let (id, zones) = (format!("id = \"{id}\""), "kind = \"flame\"\nzones = [\"hall\"]");
    format!("[[detector]]\n{id}\n{zones}\nsource = {{ {source} }}\n")
}

/// A site with these buses and two detectors.
fn parse(buses: &str, sources: [&str; 2]) -> Result<Vec<BusConfig>, Vec<[String; 4]>> {
    let detectors = [detector("a", sources[0]), detector("b", sources[1])].concat();
    let text = [SITE, buses, &detectors].concat();
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let texts = |it: super::super::Problem| [it.place, it.what.en, it.what.ru, it.remedy.en];
    read.map(|config| config.modbus).map_err(|all| all.into_iter().map(texts).collect())
}

#[test]
fn buses_are_read_with_their_detectors() {
    let both =
        [BITS, "modbus = \"panel\", unit = 2, map = \"fv300\", axis = [90, -20], field = [90, 80]"];
    let buses = parse(&format!("{BUS}poll_ms = 100\n"), both).unwrap();
    let [bus] = &buses[..] else { panic!("{buses:?}") };
    assert_eq!((bus.name.as_str(), bus.poll_ms, bus.timeout_ms), ("panel", 100, 500));
    let units: Vec<_> = bus.sources.iter().map(|it| (it.id.as_str(), it.unit)).collect();
    assert_eq!(units, [("a", 1), ("b", 2)]);
    let notifier = "modbus = \"panel\", unit = 1, map = \"notifier\", register = 9499";
    let beat = "modbus = \"panel\", unit = 1, alarm = \"holding:1&0xF0=0x50\", fault = \"!coil:0\", \
                dirty = \"coil:1\", heartbeat = \"coil:9\", heartbeat_s = 4";
    assert_eq!(parse(BUS, [notifier, beat]).unwrap()[0].sources.len(), 2);
}

/// Where the first source of a site with one bus is written.
const FIRST: u32 = 22;

/// Mistakes of a source: it, lines after [`FIRST`], what is said.
const SOURCES: &[(&str, u32, &str, &str)] = &[
    (
        "modbus = \"pannel\", unit = 1, alarm = \"coil:1\"",
        0,
        "There is no bus pannel",
        "Линии pannel нет",
    ),
    ("modbus = \"panel\", unit = 0, alarm = \"coil:1\"", 0, "unit = 0 is out", "unit = 0 вне"),
    (
        "modbus = \"panel\", unit = 248, alarm = \"coil:1\"",
        0,
        "unit = 248 is out",
        "unit = 248 вне",
    ),
    ("modbus = \"panel\", unit = 1, alarm = \"coil:65536\"", 0, "not 0…65535", "не 0…65535"),
    ("modbus = \"panel\", unit = 1, alarm = \"input:1.16\"", 0, "not 0…15", "не 0…15"),
    (
        "modbus = \"panel\", unit = 1, alarm = \"coil:1\", fault = \"x\"",
        0,
        "names no bit",
        "не называет бит",
    ),
    ("modbus = \"panel\", unit = 1", 0, "bit that alarms is missing", "Не указан бит тревоги"),
    (
        "modbus = \"panel\", unit = 1, map = \"fv30\"",
        0,
        "`fv30` is not one of",
        "`fv30` здесь недопустимо",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"fv300\", alarm = \"coil:1\"",
        0,
        "alarm has no meaning",
        "alarm здесь не имеет",
    ),
    (
        "modbus = \"panel\", unit = 1, alarm = \"coil:1\", register = 3",
        0,
        "register has no meaning",
        "register здесь",
    ),
    (
        "modbus = \"panel\", unit = 1, alarm = \"coil:1\", heartbeat_s = 3",
        0,
        "heartbeat_s has no",
        "heartbeat_s здесь",
    ),
    (
        "modbus = \"panel\", unit = 1, alarm = \"coil:1\", heartbeat = \"coil:2\"",
        0,
        "heartbeat without",
        "heartbeat без",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"notifier\"",
        0,
        "register is missing",
        "Не хватает register",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"notifier\", register = 65536",
        0,
        "register = 65536 is out",
        "register = 65536 вне",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"fv300\", register = 65515",
        0,
        "register = 65515 is out",
        "register = 65515 вне",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"fv300\", axis = [0, 0]",
        0,
        "belong together",
        "вместе",
    ),
    (
        "modbus = \"panel\", unit = 1, map = \"fv300\", axis = [0, 0], field = [0, 90]",
        0,
        "is mounted so",
        "не установить",
    ),
    (
        "modbus = \"panel\", unit = 2, alarm = \"holding:8.13\"",
        5,
        "same alarm bit",
        "один бит тревоги",
    ),
    ("modbus = \"panel\", alarm = \"coil:1\"", 0, "`unit` is missing", "Не хватает `unit`"),
];

/// Mistakes of a bus: it, the line, what is said.
const BUSES: &[(&str, u32, &str, &str)] = &[
    ("[[modbus]]\nname = \"panel\"\nurl = \"tcp://h:99999\"\n", 17, "is no line", "не линия"),
    (
        "[[modbus]]\nname = \"panel\"\nurl = \"serial:///dev/ttyUSB0\"\n",
        17,
        "A monitor is on this line",
        "ствол со своим",
    ),
    (
        "[[modbus]]\nname = \"panel\"\nurl = \"tcp://h\"\npoll_ms = 10\n",
        18,
        "poll_ms = 10 is out",
        "poll_ms = 10 вне",
    ),
    (
        "[[modbus]]\nname = \"panel\"\nurl = \"tcp://h\"\ntimeout_ms = 5000\n",
        23,
        "needs 10500 ms",
        "нужно 10500 мс",
    ),
];

#[test]
fn every_mistake_is_told_with_its_line_in_both_languages() {
    let sources = SOURCES.iter().map(|(it, more, en, ru)| (BUS, *it, FIRST + more, en, ru));
    let buses = BUSES.iter().map(|(it, line, en, ru)| (*it, BITS, *line, en, ru));
    for (buses, source, line, en, ru) in sources.chain(buses) {
        let told = parse(buses, [source, FV300]).unwrap_err();
        let place = format!("hub.toml:{line}");
        let found = |it: &[String; 4]| it[0] == place && it[1].contains(en) && it[2].contains(ru);
        assert!(told.iter().any(found), "{source}: {told:#?}");
        assert!(told.iter().all(|it| it[3].len() > 10), "what to do: {told:#?}");
        assert!(told.len() <= 2, "nothing follows from it: {told:#?}");
    }
}

#[test]
fn buses_are_told_apart() {
    let again = BUS.replace("10.0.0.9", "10.0.0.8");
    let told = |buses: &str| parse(buses, [BITS, FV300]).unwrap_err();
    let has = |told: &[[String; 4]], en: &str| told.iter().any(|it| it[1].contains(en));
    assert!(has(&told(&[BUS, &again].concat()), "panel is given twice"));
    let other = BUS.replace("\"panel\"", "\"other\"");
    let found = told(&[BUS, &other].concat());
    assert!(has(&found, "bus panel is on the same line"), "{found:#?}");
    assert!(has(&found, "Nothing is on the bus other"), "{found:#?}");
    let odd = BUS.replace("\"panel\"", "\"east panel\"");
    assert!(has(&told(&[BUS, &odd].concat()), "is no name of a bus"));
    let rtu = "[[modbus]]\nname = \"panel\"\nurl = \"serial:///dev/ttyS1?baud=1200\"\n";
    assert!(has(&told(rtu), "One round on panel takes"), "{:#?}", told(rtu));
}

/// What a detector has if it is not said is written once more here, for it is read here.
#[test]
fn a_detector_has_the_same_defaults_as_in_the_zone_controller() {
    let text = "id = \"a\"\nkind = \"flame\"\nzones = [\"hall\"]\n";
    let written: crate::config::written::Detector = toml::from_str(text).unwrap();
    let meant: lafet_site::config::Detector = toml::from_str(text).unwrap();
    assert_eq!(lafet_site::config::Detector::from(&written), meant);
    let text = "id = \"a\"\nkind = \"stop\"\n";
    let written: crate::config::written::Contact = toml::from_str(text).unwrap();
    let meant: lafet_site::config::Contact = toml::from_str(text).unwrap();
    assert_eq!(lafet_site::config::Contact::from(&written), meant);
}

#[test]
fn contacts_are_read_too_and_a_release_by_one_reading_is_refused() {
    let input = |keys: &str| {
        let source =
            "source = { modbus = \"panel\", unit = 3, on = \"!coil:4\", fault = \"coil:5\" }";
        format!("{BUS}[[input]]\nid = \"stop\"\n{source}\n{keys}\n")
    };
    let buses = parse(&input("kind = \"stop\""), [BITS, FV300]).unwrap();
    let contact = buses[0].sources.last().unwrap();
    assert_eq!((contact.id.as_str(), contact.sort, contact.unit), ("stop", Sort::Contact, 3));
    let release = "kind = \"release\"\nzones = [\"hall\"]\n";
    let told = parse(&input(release), [BITS, FV300]).unwrap_err();
    assert!(told[0][1].contains("by a single reading"), "{told:#?}");
    assert!(told[0][2].contains("по одному чтению") && told[0][0] == "hub.toml:18", "{told:#?}");
    assert!(parse(&input(&format!("{release}debounce_ms = 500")), [BITS, FV300]).is_ok());
    let told = parse(&input("kind = \"stop\"").replace("unit = 3", "unit = 0"), [BITS, FV300]);
    assert!(told.unwrap_err()[0][1].contains("unit = 0 is out"));
    let monitor = SITE.split("[[aim]]").next().unwrap_or_default();
    let text = format!("{monitor}{}", input("kind = \"stop\""));
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let told = read.unwrap_err();
    assert_eq!(
        (told.len(), told[0].what.en.as_str()),
        (1, "There is no zone for it."),
        "{told:#?}"
    );
}
