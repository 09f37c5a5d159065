//! The outputs, each by its name.

use lafet_device::cause::{Cause, Causes};
use lafet_device::image::{Axis, Outputs, Place, ValveNo, ValveOutput};
use lafet_sim::fault::{axis_name, place_name, valve_name};

/// An output of the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// A drive: its speed, signed, 0.1 °/s or 0.1 mm/s.
    Drive(Axis),
    /// A valve: 1 opening, -1 closing, 0 off.
    Valve(ValveNo),
    /// A heater: 1 on, 0 off.
    Heater(Place),
}

impl Output {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        let drives = Axis::ALL.into_iter().map(Self::Drive);
        let valves = ValveNo::ALL.into_iter().map(Self::Valve);
        drives.chain(valves).chain(Place::ALL.into_iter().map(Self::Heater))
    }

    /// Its value as a number.
    pub fn value(self, outputs: &Outputs) -> i16 {
        match self {
            Self::Drive(axis) => outputs.drives[axis as usize].speed_tenths,
            Self::Valve(valve) => match outputs.valves[valve as usize] {
                ValveOutput::Off => 0,
                ValveOutput::Opening => 1,
                ValveOutput::Closing => -1,
            },
            Self::Heater(place) => i16::from(outputs.heaters[place as usize]),
        }
    }

    /// What the device gives as its cause.
    pub const fn cause(self, causes: &Causes) -> Cause {
        match self {
            Self::Drive(axis) => causes.drives[axis as usize],
            Self::Valve(valve) => causes.valves[valve as usize],
            Self::Heater(place) => causes.heaters[place as usize],
        }
    }

    /// Its name: `vertical`, `valve1`, `box heater`.
    pub fn name(self) -> String {
        match self {
            Self::Drive(axis) => axis_name(axis).to_owned(),
            Self::Valve(valve) => valve_name(valve).to_owned(),
            Self::Heater(place) => format!("{} heater", place_name(place)),
        }
    }

    /// A value of it in words: `12.5`, `opening`, `on`.
    pub fn words(self, value: i16) -> String {
        match (self, value) {
            (Self::Drive(_), speed) => format!("{:.1}", f64::from(speed) / 10.0),
            (Self::Valve(_), 1) => "opening".to_owned(),
            (Self::Valve(_), -1) => "closing".to_owned(),
            (Self::Heater(_), 1) => "on".to_owned(),
            (Self::Valve(_) | Self::Heater(_), _) => "off".to_owned(),
        }
    }
}
