//! Faults in words.

use lafet_device::image::{Axis, Place, ValveNo};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::{self, Key};
use lafet_sim::fault::{Fault, Post};
use lafet_sim::unit;
use lafet_texts::{Fixed, Text as _, Words, fault as faults, play as text};

/// What is broken, and how.
pub fn fault_words(fault: Fault) -> Words {
    let (part, what) = match fault {
        Fault::Drive(axis, it) => (title(axis.id()), what("drive", it.name())),
        Fault::Valve(valve, it) => (title(of_valve(valve)), what("valve", it.name())),
        Fault::Temperature(place) => (of_place(place), what("place", "temperature")),
        Fault::TemperatureFrozen(place) => (of_place(place), what("place", "temperature-frozen")),
        Fault::TemperatureDrift(place) => (of_place(place), what("place", "temperature-drift")),
        Fault::Heater(place) => (of_place(place), what("place", "heater")),
        Fault::Unit(it, fault) => (title(unit::subsystem(it)), what("unit", fault.name())),
        Fault::Button(post, button, it) => {
            let post = match post {
                Post::Buttons => SubsystemId::BUTTONS,
                Post::ExtButtons => SubsystemId::EXT_BUTTONS,
            };
            let of_post = text::ButtonOf { post: title(post), button: button.text() }.words();
            (of_post, what("button", it.name()))
        }
        Fault::Single(it) => return Words::each(|lang| what("single", it.name()).str(lang).into()),
    };
    text::FaultOf { part, what }.words()
}

fn title(id: SubsystemId) -> Words {
    dictionary::subsystem(id).map(|info| info.title).as_ref().map(Key::words).unwrap_or_default()
}

const fn of_valve(valve: ValveNo) -> SubsystemId {
    match valve {
        ValveNo::Valve1 => SubsystemId::VALVE1,
        ValveNo::Valve2 => SubsystemId::VALVE2,
    }
}

fn of_place(place: Place) -> Words {
    match place {
        Place::Horizontal => title(Axis::Horizontal.id()),
        Place::Vertical => title(Axis::Vertical.id()),
        Place::Nozzle => title(Axis::Nozzle.id()),
        Place::Deployer => title(Axis::Deployer.id()),
        Place::Box => text::Housing.words(),
    }
}

/// Of the catalogue; a name without words is shown as it is.
fn what(kind: &str, name: &'static str) -> Fixed {
    let wanted = format!("{kind}-{name}");
    let known = faults::BY_KEY.iter().find(|(key, _)| *key == wanted);
    known.map_or(Fixed::same(name), |(_, words)| *words)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each fault has words of its own, in both languages, and each row of the catalogue a fault.
    #[test]
    fn every_fault_has_words() {
        let mut seen: Vec<String> = Vec::new();
        for fault in Fault::all() {
            let Words { en, ru } = fault_words(fault);
            assert_ne!(en, ru, "{}", fault.name());
            assert!(en.contains(": ") && ru.contains(": "), "{en}, {ru}");
            seen.push(en);
        }
        let count = seen.len();
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), count);
        for (key, words) in faults::BY_KEY {
            assert!(seen.iter().any(|it| it.ends_with(words.en)), "{key} is no fault");
        }
    }
}
