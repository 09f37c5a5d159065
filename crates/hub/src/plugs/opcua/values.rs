//! What the variables of a monitor are, and their values. No I/O, no clock.

use lafet_ballistics::DATM_MPA;
use lafet_proto::SubsystemId;
use opcua::types::{StatusCode, Variant};

use crate::clock::ms;
use crate::plugs::orders::AXES;
use crate::plugs::sight::{Known, is_faulty, mode};

/// A unit of measurement: its code of UN/CEFACT recommendation 20, and its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The code.
    pub code: &'static str,
    /// The sign.
    pub sign: &'static str,
}

impl Unit {
    /// The number of the unit in OPC UA: the characters of its code.
    pub fn number(self) -> i32 {
        self.code.bytes().fold(0, |number, byte| (number << 8) | i32::from(byte))
    }
}

const DEGREE: Unit = Unit { code: "DD", sign: "°" };
const MILLIMETRE: Unit = Unit { code: "MMT", sign: "mm" };
const MEGAPASCAL: Unit = Unit { code: "MPA", sign: "MPa" };
const LITRE_PER_S: Unit = Unit { code: "G51", sign: "l/s" };
const VOLT: Unit = Unit { code: "VLT", sign: "V" };
const MILLISECOND: Unit = Unit { code: "C26", sign: "ms" };
/// What a byte of the protocol reaches.
const BYTE: f64 = 255.0;
/// The age is shown in steps of this, ms.
const AGE_STEP_MS: u64 = 100;

/// What a variable shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// What the monitor does, in a word.
    Mode,
    /// It can do its work.
    Ready,
    /// There is a connection to it.
    Connected,
    /// Age of its state.
    Age,
    /// It is locked out.
    LockedOut,
    /// Who has authority; empty: no client.
    Holder,
    /// Alarms that are not normal.
    Alarms,
    /// Of these, those that are not acknowledged.
    Waiting,
    /// Where a drive is, by its place in [`AXES`].
    Position(usize),
    /// Whether it moves.
    Moving(usize),
    /// A flag of a valve.
    Valve(u16, &'static str),
    /// Whether a valve reports that it is not well.
    ValveFault(u16),
    /// Pressure of the water.
    Pressure,
    /// Flow of the water.
    Flow,
    /// Water flows, or it is not certain that it does not.
    Water,
    /// Voltage of the supply.
    Voltage,
    /// The detector sees a fire.
    Fire,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Yes or no.
    Bool,
    /// A number of things.
    Count,
    /// A word.
    Text,
    /// A measured value: its unit, and the range of the instrument.
    Measure(Unit, (f64, f64)),
}

/// A variable.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Its name.
    pub name: &'static str,
    /// The type of its value.
    pub kind: Kind,
    /// What it shows.
    pub of: Of,
    /// The series of the history that has it, and what its values are multiplied by.
    pub series: Option<(&'static str, f64)>,
}

/// A part of a monitor.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Its name; empty: the monitor itself.
    pub name: &'static str,
    /// The name of its type.
    pub class: &'static str,
    /// Its variables.
    pub all: &'static [Spec],
}

const fn flag(name: &'static str, of: Of) -> Spec {
    Spec { name, kind: Kind::Bool, of, series: None }
}

const fn measure(
    name: &'static str,
    (unit, range): (Unit, (f64, f64)),
    of: Of,
    series: Option<(&'static str, f64)>,
) -> Spec {
    Spec { name, kind: Kind::Measure(unit, range), of, series }
}

const ARC_MINUTES: f64 = 1.0 / 60.0;

macro_rules! valve {
    ($number:literal) => {
        &[
            flag("Open", Of::Valve($number, "Open")),
            flag("Closed", Of::Valve($number, "Closed")),
            flag("Opening", Of::Valve($number, "Opening")),
            flag("Closing", Of::Valve($number, "Closing")),
            flag("Blocked", Of::Valve($number, "Blocked")),
            flag("Fault", Of::ValveFault($number)),
        ]
    };
}

/// The parts of a monitor.
pub const PARTS: [Part; 10] = [
    Part {
        name: "",
        class: "MonitorType",
        all: &[
            Spec { name: "Mode", kind: Kind::Text, of: Of::Mode, series: None },
            flag("Ready", Of::Ready),
            flag("Connected", Of::Connected),
            measure("Age", (MILLISECOND, (0.0, 86_400_000.0)), Of::Age, None),
            flag("LockedOut", Of::LockedOut),
        ],
    },
    Part {
        name: "Authority",
        class: "AuthorityType",
        all: &[Spec { name: "Holder", kind: Kind::Text, of: Of::Holder, series: None }],
    },
    Part {
        name: "Alarms",
        class: "AlarmCountsType",
        all: &[
            Spec { name: "Count", kind: Kind::Count, of: Of::Alarms, series: None },
            Spec { name: "Waiting", kind: Kind::Count, of: Of::Waiting, series: None },
        ],
    },
    Part {
        name: "Traverse",
        class: "DriveType",
        all: &[
            measure(
                "Position",
                (DEGREE, (-360.0, 360.0)),
                Of::Position(0),
                Some(("Horizontal.position", ARC_MINUTES)),
            ),
            flag("Moving", Of::Moving(0)),
        ],
    },
    Part {
        name: "Elevation",
        class: "DriveType",
        all: &[
            measure(
                "Position",
                (DEGREE, (-90.0, 180.0)),
                Of::Position(1),
                Some(("Vertical.position", ARC_MINUTES)),
            ),
            flag("Moving", Of::Moving(1)),
        ],
    },
    Part {
        name: "Nozzle",
        class: "NozzleType",
        all: &[
            measure(
                "Position",
                (MILLIMETRE, (0.0, 1000.0)),
                Of::Position(2),
                Some(("Nozzle.position", 1.0)),
            ),
            flag("Moving", Of::Moving(2)),
        ],
    },
    Part { name: "Valve1", class: "ValveType", all: valve!(1) },
    Part { name: "Valve2", class: "ValveType", all: valve!(2) },
    Part {
        name: "Water",
        class: "WaterType",
        all: &[
            measure(
                "Pressure",
                (MEGAPASCAL, (0.0, BYTE * DATM_MPA)),
                Of::Pressure,
                Some(("General.pressure", DATM_MPA)),
            ),
            measure("Flow", (LITRE_PER_S, (0.0, BYTE)), Of::Flow, Some(("General.flowrate", 1.0))),
            flag("Flowing", Of::Water),
            measure(
                "SupplyVoltage",
                (VOLT, (0.0, BYTE)),
                Of::Voltage,
                Some(("General.main_voltage", 1.0)),
            ),
        ],
    },
    Part { name: "Detector", class: "DetectorType", all: &[flag("Fire", Of::Fire)] },
];

/// All variables of a monitor, in their order.
pub fn all() -> impl Iterator<Item = (&'static Part, &'static Spec)> {
    PARTS.iter().flat_map(|part| part.all.iter().map(move |spec| (part, spec)))
}

/// A value and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The value; [`Variant::Empty`]: not known.
    pub value: Variant,
    /// How good it is.
    pub status: StatusCode,
    /// It is what the hub knows itself, now.
    pub own: bool,
}

impl Of {
    /// The value of a variable.
    pub fn seen(self, known: &Known<'_>, holder: &str) -> Seen {
        if let Some(value) = self.of_hub(known, holder) {
            return Seen { value, status: StatusCode::Good, own: true };
        }
        let fresh = fresh(known);
        match (self, fresh) {
            // Not: no water.
            (Self::Water, Err(_)) => Seen {
                value: true.into(),
                status: StatusCode::UncertainNoCommunicationLastUsableValue,
                own: false,
            },
            (_, Err(status)) => Seen { value: Variant::Empty, status, own: false },
            (_, Ok(())) => match self.of_monitor(known) {
                Ok(value) => Seen { value, status: StatusCode::Good, own: false },
                Err(status) => Seen { value: Variant::Empty, status, own: false },
            },
        }
    }

    fn of_hub(self, known: &Known<'_>, holder: &str) -> Option<Variant> {
        match self {
            Self::Connected => Some(known.up.into()),
            Self::Ready => Some((known.is_fresh() && known.ready).into()),
            Self::Age => {
                let age = ms(known.age?) / AGE_STEP_MS * AGE_STEP_MS;
                Some((age as f64).into())
            }
            Self::Holder => Some(holder.into()),
            Self::Alarms => Some(known.alarms.count.into()),
            Self::Waiting => Some(known.alarms.waiting.into()),
            _ => None,
        }
    }

    fn of_monitor(self, known: &Known<'_>) -> Result<Variant, StatusCode> {
        let status = known.status;
        let has = |id: SubsystemId| status.bits(id).ok_or(StatusCode::BadNotSupported);
        let is_set = |id, flag| has(id).map(|_| Variant::from(status.is_set(id, flag)));
        let general = |field: &str, scale: f64| {
            has(SubsystemId::GENERAL)?;
            let value = status.valid(SubsystemId::GENERAL, field);
            value.map(|it| (it as f64 * scale).into()).ok_or(StatusCode::BadSensorFailure)
        };
        match self {
            Self::Mode => Ok(mode(status).1.into()),
            Self::LockedOut => is_set(SubsystemId::GENERAL, "LockedOut"),
            Self::Position(axis) => {
                let drive = AXES[axis];
                has(drive)?;
                let scale = if axis == 2 { 1.0 } else { ARC_MINUTES };
                let position = status.position(drive).map(|it| (it as f64 * scale).into());
                position.ok_or(StatusCode::BadSensorFailure)
            }
            Self::Moving(axis) => is_set(AXES[axis], "Move"),
            Self::Valve(number, flag) => is_set(crate::plugs::orders::valve_of(number), flag),
            Self::ValveFault(number) => {
                let valve = crate::plugs::orders::valve_of(number);
                has(valve).map(|_| is_faulty(status, valve).into())
            }
            Self::Pressure => general("pressure", DATM_MPA),
            Self::Flow => general("flowrate", 1.0),
            Self::Voltage => general("main_voltage", 1.0),
            Self::Water => Ok(status.flows().into()),
            Self::Fire => is_set(SubsystemId::DETECTOR, "Found"),
            // An age that there is not.
            _ => Err(StatusCode::BadWaitingForInitialData),
        }
    }
}

/// Whether the state is the present one, and why not.
fn fresh(known: &Known<'_>) -> Result<(), StatusCode> {
    match (known.age, known.up) {
        (None, _) => Err(StatusCode::BadWaitingForInitialData),
        (_, false) => Err(StatusCode::BadNotConnected),
        _ if !known.is_fresh() => Err(StatusCode::BadNoCommunication),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::monitor::status::Status;
    use crate::plugs::sight::fixture::status;
    use crate::plugs::sight::{Control, Tally};

    fn seen(of: Of, status: &Status, age: Option<u64>, up: bool) -> Seen {
        let (control, alarms) = (Control::default(), Tally::default());
        let age = age.map(Duration::from_millis);
        of.seen(&Known { status, age, up, ready: true, control, alarms }, "anna")
    }

    #[test]
    fn units_have_the_numbers_of_the_standard() {
        let numbers = [DEGREE, MILLIMETRE, MEGAPASCAL, LITRE_PER_S, VOLT, MILLISECOND];
        let numbers = numbers.map(Unit::number);
        assert_eq!(numbers, [17476, 5_066_068, 5_066_817, 4_666_673, 5_655_636, 4_403_766]);
    }

    #[test]
    fn a_fresh_state_is_in_the_units_that_are_documented() {
        for (of, value) in [
            (Of::Mode, Variant::from("extinguishes")),
            (Of::Position(0), (-605.0 / 60.0).into()),
            (Of::Position(2), 60.0.into()),
            (Of::Pressure, (80.0 * DATM_MPA).into()),
            (Of::Flow, 20.0.into()),
            (Of::Voltage, 24.0.into()),
            (Of::Water, true.into()),
            (Of::Moving(0), true.into()),
            (Of::Moving(1), false.into()),
            (Of::Fire, true.into()),
            (Of::Age, 300.0.into()),
            (Of::Holder, "anna".into()),
        ] {
            let seen = seen(of, &status(), Some(340), true);
            assert_eq!((seen.value, seen.status), (value, StatusCode::Good), "{of:?}");
        }
        let absent = seen(Of::Valve(2, "Open"), &status(), Some(1), true);
        assert_eq!(absent.status, StatusCode::BadNotSupported);
    }

    /// Not the last value as if it were good; and water may flow.
    #[test]
    fn what_is_not_known_has_a_bad_status_and_no_value() {
        let stale = Status { stale: true, ..status() };
        for (status, age, up, why) in [
            (&stale, Some(900), true, StatusCode::BadNoCommunication),
            (&status(), Some(40), false, StatusCode::BadNotConnected),
            (&Status::default(), None, true, StatusCode::BadWaitingForInitialData),
        ] {
            for (_, spec) in all() {
                let seen = seen(spec.of, status, age, up);
                match spec.of {
                    Of::Water => assert!(seen.value == true.into() && seen.status.is_uncertain()),
                    Of::Ready => assert_eq!(seen.value, false.into()),
                    Of::Connected | Of::Holder | Of::Alarms | Of::Waiting => {
                        assert!(seen.status.is_good() && seen.own);
                    }
                    Of::Age if age.is_some() => assert!(seen.status.is_good()),
                    of => assert_eq!((seen.value, seen.status), (Variant::Empty, why), "{of:?}"),
                }
            }
        }
    }

    #[test]
    fn parts_of_one_type_have_the_same_variables() {
        for one in PARTS {
            for other in PARTS.iter().filter(|it| it.class == one.class) {
                let names = |part: &Part| part.all.iter().map(|it| it.name).collect::<Vec<_>>();
                assert_eq!(names(&one), names(other), "{}", one.class);
            }
        }
    }
}
