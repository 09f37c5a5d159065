//! Parameters as each version has stored them, over an update to this one. A file for each layout: its lines are a key of
//! the memory and its value, or a parameter and what GetParam answers.

use super::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

/// The layouts of all versions, this one included.
const LAYOUTS: [u16; 1] = [1];

fn file(layout: u16) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/monitor/layouts");
    PathBuf::from(folder).join(format!("{layout}.txt"))
}

/// A monitor with parameters that differ from those of the factory, locked out.
fn adjusted() -> Site {
    let mut site = Site::new(Composition::FULL);
    site.set_speed(7);
    let program = [3, 30 * 60, -2 * 60, 6 * 60, 2 * 60, 60, 25];
    let id = Param::ControlProgram3.id();
    let body = Body::SetParam { id, values: Ints::Values(&program) };
    site.ask(SubsystemId::CONTROL, body);
    site.run(2000);
    site.lock();
    site.run(2000);
    site
}

/// What GetParam answers for each parameter that this monitor has, but for what an update changes: what runs.
fn values(site: &mut Site) -> BTreeMap<String, Vec<u8>> {
    let mut values = BTreeMap::new();
    let software = |param: &Param| param.name().starts_with("Software");
    for param in Param::ALL.into_iter().filter(|param| !software(param)) {
        let (to, id) = (param.subsystem(), param.id());
        // That of a remote unit takes a while.
        for _ in 0..20 {
            if let [(_, Status::OK, data)] = &site.ask(to, Body::GetParam { id })[..] {
                values.insert(format!("{to}.{}", param.name()), data.clone());
                break;
            }
            site.run(50);
        }
    }
    values
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

fn unhex(text: &str) -> Vec<u8> {
    let digits = text.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap());
    digits.map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect()
}

/// A monitor that starts with this memory; what its parameters were when the memory was stored.
fn as_stored(text: &str) -> (Site, BTreeMap<String, Vec<u8>>) {
    let (mut memory, mut values) = (BTreeMap::new(), BTreeMap::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["key", key, value] => _ = memory.insert(key.parse().unwrap(), unhex(value)),
            ["param", name, value] => _ = values.insert(name.to_owned(), unhex(value)),
            _ => panic!("{line}"),
        }
    }
    let mut site = Site::new(Composition::FULL);
    site.board.plant.memory = memory;
    site.start();
    site.run(2000);
    (site, values)
}

/// Every parameter and the lockout, as a version has stored them, are there before, on trial and after the
/// confirmation.
#[test]
fn of_each_version() {
    for layout in LAYOUTS {
        let text = std::fs::read_to_string(file(layout)).unwrap();
        let (mut site, stored) = as_stored(&text);
        assert!(stored.len() > 100, "layout {layout}: {} parameters", stored.len());
        assert!(site.is_locked(), "layout {layout}");
        assert_eq!(values(&mut site), stored, "layout {layout}");
        assert!(site.send(&image(2, 512)));
        site.commit();
        assert!(site.report().trial && site.is_locked());
        assert_eq!(values(&mut site), stored, "layout {layout}, on trial");
        site.run(PROVEN_MS);
        assert!(!site.accepts(&Order::Confirm { word: LONG_WORD }).trial);
        site.start();
        site.run(2000);
        assert_eq!(values(&mut site), stored, "layout {layout}, confirmed");
        assert!(site.is_locked(), "layout {layout}");
    }
}

/// What is stored today is the newest layout: whatever changes it needs another one, and a file of its own.
#[test]
fn the_newest_is_that_of_today() {
    let newest = LAYOUTS.last().copied().unwrap();
    assert_eq!(std::fs::read_to_string(file(newest)).unwrap(), text_of(&mut adjusted()));
}

fn text_of(site: &mut Site) -> String {
    let memory = site.board.plant.memory.clone();
    let keys = memory.iter().map(|(key, value)| format!("key {key} {}\n", hex(value)));
    let params = values(site);
    let params = params.iter().map(|(name, value)| format!("param {name} {}\n", hex(value)));
    keys.chain(params).collect()
}

/// Writes the file of the newest layout.
#[test]
#[ignore = "only when there is a new layout"]
fn write_the_newest() {
    let newest = LAYOUTS.last().copied().unwrap();
    std::fs::create_dir_all(file(newest).parent().unwrap()).unwrap();
    std::fs::write(file(newest), text_of(&mut adjusted())).unwrap();
}
