//! Everything that can be broken on purpose, by name.
//!
//! `Fault::all()` lists them; scenarios (`inject fault vertical-jam`) and the command line use the
//! names. A fault is in force from `inject` to `clear`; what it does is described where the part is.

use lafet_device::image::{Axis, Place, Unit, ValveNo};
use lafet_proto::flags::Button;

/// A fault of the world around the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A drive: `vertical-jam`.
    Drive(Axis, DriveFault),
    /// A valve: `valve1-blocked`.
    Valve(ValveNo, ValveFault),
    /// A temperature sensor answers nothing: `vertical-temperature`.
    Temperature(Place),
    /// It shows what it showed when the fault came: `vertical-temperature-frozen`.
    TemperatureFrozen(Place),
    /// It shows 0.1 °C more each second: `vertical-temperature-drift`.
    TemperatureDrift(Place),
    /// A heater's circuit is broken: `box-heater`.
    Heater(Place),
    /// A remote unit on the internal bus: `nozzle-unit-offline`.
    Unit(Unit, UnitFault),
    /// A button of a post: `buttons-left-short`.
    Button(Post, Button, ButtonFault),
    /// What exists once: `pump-off`.
    Single(SingleFault),
}

macro_rules! named {
    ($(#[$doc:meta])* $type:ident { $($(#[$item:meta])* $variant:ident $name:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type { $($(#[$item])* $variant,)+ }

        impl $type {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// The name, as fault names use it.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }
        }
    };
}

named! {
    /// What can break in a drive.
    DriveFault {
        /// The motor circuit is open: no torque, and the power stage notices.
        MotorOpen "motor-open",
        /// Something blocks it: it is at rest and draws the stall current.
        Jam "jam",
        /// The power stage is dead: the motor gets no voltage, and nothing diagnoses it.
        PowerStage "power-stage",
        /// The power stage is shorted: it turns up or left (the nozzle wider) at full speed, fed or
        /// not, until its supply is cut.
        Runaway "runaway",
        /// Friction grown twelvefold: it moves, but draws more than it may.
        Friction "friction",
        /// As friction, but the current drops out of the readings for 10 ms of every 100.
        Flicker "flicker",
        /// The speed follows its command with a time constant of 300 ms.
        Lag "lag",
        /// Below 1 °/s or 1 mm/s the motor does not turn.
        DeadBand "dead-band",
        /// The stage holds no speed: each A of load takes 0.4 °/s or 0.4 mm/s of it.
        Droop "droop",
        /// The gear has a play of 12' or 1 mm.
        Backlash "backlash",
        /// Thick grease: it moves, and draws more than usual, but not more than it may.
        Stiff "stiff",
        /// The position does not change in the readings though the drive moves.
        EncoderDead "encoder-dead",
        /// The position counts the wrong way.
        EncoderReversed "encoder-reversed",
        /// The position counts four times what it should.
        EncoderFast "encoder-fast",
        /// The position has jumped, by 20 ° or 15 mm.
        EncoderJump "encoder-jump",
        /// Each reading of the position is off by up to 2' or 1 mm, at random.
        EncoderNoise "encoder-noise",
        /// The position sensor diagnoses itself as faulty.
        EncoderFault "encoder-fault",
        /// The speed sensor reads nought.
        SpeedDead "speed-dead",
        /// The speed sensor has the wrong sign.
        SpeedReversed "speed-reversed",
        /// The speed sensor diagnoses itself as faulty.
        SpeedFault "speed-fault",
        /// The switch at the lower / right / wider / wrapped end is stuck on.
        MinSwitch "min-switch",
        /// The switch at the upper / left / narrower / deployed end is stuck on.
        MaxSwitch "max-switch",
        /// The switch at the lower / right / wider / wrapped end bounces and blips.
        MinBounce "min-bounce",
        /// The switch at the upper / left / narrower / deployed end bounces and blips.
        MaxBounce "max-bounce",
    }
}

/// How far a noisy encoder (`encoder-noise`) is off at most, arc-minutes or mm.
pub const fn noise_counts(axis: Axis) -> i32 {
    match axis {
        Axis::Nozzle => 1,
        Axis::Vertical | Axis::Horizontal | Axis::Deployer => 2,
    }
}

named! {
    /// What can break in a valve.
    ValveFault {
        /// The motor circuit is open: it stays where it is and draws nothing.
        MotorOpen "motor-open",
        /// The relay that opens is welded: it opens, whatever is driven, until its own end switch cuts it.
        OpenRelay "open-relay",
        /// The plug is stuck: it stays where it is and draws the stall current.
        Jam "jam",
        /// The circuit of the switch "open" is broken or shorted.
        OpenSwitch "open-switch",
        /// The circuit of the switch "closed" is broken or shorted.
        CloseSwitch "close-switch",
        /// The switch "closed" is stuck on, and its circuit is sound.
        CloseStuck "close-stuck",
        /// The hardware block is on: the motor gets no power.
        Blocked "blocked",
        /// The switch "open" bounces and blips.
        OpenBounce "open-bounce",
        /// The switch "closed" bounces and blips.
        CloseBounce "close-bounce",
        /// The contact of the hardware block bounces and blips.
        BlockedBounce "blocked-bounce",
    }
}

named! {
    /// What can break in a remote unit or on its bus.
    UnitFault {
        /// Nothing comes back.
        Offline "offline",
        /// Half of the exchanges are lost.
        Lossy "lossy",
        /// Answers break the protocol of the internal bus.
        Protocol "protocol",
        /// The unit has been reset by its watchdog.
        Watchdog "watchdog",
        /// Accesses to parameters are never answered.
        ParamSilent "param-silent",
        /// Accesses to parameters end in RemotePaIncomplete.
        ParamIncomplete "param-incomplete",
        /// Accesses to parameters end in RemotePaBadId.
        ParamBadId "param-bad-id",
        /// Accesses to parameters end in RemotePaBadVal.
        ParamBadValue "param-bad-value",
        /// Accesses to parameters end in RemotePaError.
        ParamError "param-error",
    }
}

named! {
    /// The two button posts, as they index the process image.
    Post {
        /// The button post.
        Buttons "buttons",
        /// The remote button post.
        ExtButtons "ext-buttons",
    }
}

named! {
    /// What can break in the line of a button (§3.3.10).
    ButtonFault {
        /// Short circuit.
        Short "short",
        /// Broken wire.
        Break "break",
        /// The contact bounces when it changes, and blips: pressed for up to 30 ms without a hand.
        Bounce "bounce",
    }
}

named! {
    /// What exists once.
    SingleFault {
        /// The loop of the pressure sensor is broken: 0 mA.
        PressureBreak "pressure-break",
        /// The loop of the pressure sensor is shorted: 28 mA.
        PressureShort "pressure-short",
        /// The loop of the pressure sensor stays at what it was.
        PressureFrozen "pressure-frozen",
        /// The loop of the pressure sensor loses 20 µA each second.
        PressureDrift "pressure-drift",
        /// The flow meter stays at what it was.
        FlowFrozen "flow-frozen",
        /// The flow meter shows 1 l/s more each five seconds.
        FlowDrift "flow-drift",
        /// The pump gives nothing.
        PumpOff "pump-off",
        /// The pump gives a quarter of its pressure.
        PumpWeak "pump-weak",
        /// The supply voltage is a third too low.
        VoltageLow "voltage-low",
        /// The supply voltage is a third too high.
        VoltageHigh "voltage-high",
        /// The supply gives way for 200 ms when a motor starts.
        SupplyDip "supply-dip",
        /// The supply gives way as long as a motor runs.
        SupplySag "supply-sag",
        /// The humidity sensor answers nothing.
        Humidity "humidity",
        /// The fire detector does not answer.
        DetectorDead "detector-dead",
        /// The fire detector is saturated: four spots as wide as its field of view, wherever it looks.
        DetectorSaturated "detector-saturated",
        /// The detector's glass is dirty: a tenth of the light comes through.
        DirtyLens "dirty-lens",
        /// The memory cannot be read.
        FlashRead "flash-read",
        /// The memory cannot be written.
        FlashWrite "flash-write",
    }
}

impl Fault {
    /// Every fault, in the order of the enum.
    pub fn all() -> impl Iterator<Item = Self> {
        let drives =
            Axis::ALL.iter().flat_map(|&a| DriveFault::ALL.iter().map(move |&f| Self::Drive(a, f)));
        let valves = ValveNo::ALL
            .iter()
            .flat_map(|&v| ValveFault::ALL.iter().map(move |&f| Self::Valve(v, f)));
        let places = Place::ALL.iter().flat_map(|&place| {
            [
                Self::Temperature(place),
                Self::TemperatureFrozen(place),
                Self::TemperatureDrift(place),
                Self::Heater(place),
            ]
        });
        let units =
            UNITS.iter().flat_map(|&u| UnitFault::ALL.iter().map(move |&f| Self::Unit(u, f)));
        let buttons = Post::ALL.iter().flat_map(|&post| {
            Button::ALL.iter().flat_map(move |&button| {
                ButtonFault::ALL.iter().map(move |&fault| Self::Button(post, button, fault))
            })
        });
        let singles = SingleFault::ALL.iter().map(|&fault| Self::Single(fault));
        drives.chain(valves).chain(places).chain(units).chain(buttons).chain(singles)
    }

    /// The name that scenarios and the command line use.
    pub fn name(self) -> String {
        match self {
            Self::Drive(axis, fault) => format!("{}-{}", axis_name(axis), fault.name()),
            Self::Valve(valve, fault) => format!("{}-{}", valve_name(valve), fault.name()),
            Self::Temperature(place) => format!("{}-temperature", place_name(place)),
            Self::TemperatureFrozen(place) => format!("{}-temperature-frozen", place_name(place)),
            Self::TemperatureDrift(place) => format!("{}-temperature-drift", place_name(place)),
            Self::Heater(place) => format!("{}-heater", place_name(place)),
            Self::Unit(unit, fault) => format!("{}-unit-{}", unit_name(unit), fault.name()),
            Self::Button(post, button, fault) => {
                format!("{}-{}-{}", post.name(), button_name(button), fault.name())
            }
            Self::Single(fault) => fault.name().to_owned(),
        }
    }

    /// The fault of an exact name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|fault| fault.name() == name)
    }
}

/// All remote units, in image order.
pub const UNITS: [Unit; 6] =
    [Unit::Vertical, Unit::Horizontal, Unit::Nozzle, Unit::Deployer, Unit::Valve1, Unit::Valve2];

/// Lower-case name of a button.
pub const fn button_name(button: Button) -> &'static str {
    match button {
        Button::Left => "left",
        Button::Right => "right",
        Button::Up => "up",
        Button::Down => "down",
        Button::Wide => "wide",
        Button::Narrow => "narrow",
        Button::Open => "open",
        Button::Close => "close",
    }
}

/// Lower-case name of a drive.
pub const fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::Vertical => "vertical",
        Axis::Horizontal => "horizontal",
        Axis::Nozzle => "nozzle",
        Axis::Deployer => "deployer",
    }
}

/// Lower-case name of a valve.
pub const fn valve_name(valve: ValveNo) -> &'static str {
    match valve {
        ValveNo::Valve1 => "valve1",
        ValveNo::Valve2 => "valve2",
    }
}

/// Lower-case name of a heated place.
pub const fn place_name(place: Place) -> &'static str {
    match place {
        Place::Horizontal => "horizontal",
        Place::Vertical => "vertical",
        Place::Nozzle => "nozzle",
        Place::Deployer => "deployer",
        Place::Box => "box",
    }
}

/// Lower-case name of a remote unit.
pub const fn unit_name(unit: Unit) -> &'static str {
    match unit {
        Unit::Vertical => "vertical",
        Unit::Horizontal => "horizontal",
        Unit::Nozzle => "nozzle",
        Unit::Deployer => "deployer",
        Unit::Valve1 => "valve1",
        Unit::Valve2 => "valve2",
    }
}

/// The faults in force.
#[derive(Clone, Debug, Default)]
pub struct Faults(Vec<Fault>);

impl Faults {
    /// Whether a fault is in force.
    pub fn has(&self, fault: Fault) -> bool {
        self.0.contains(&fault)
    }

    /// Whether a fault of a drive is in force.
    pub fn drive(&self, axis: Axis, fault: DriveFault) -> bool {
        self.has(Fault::Drive(axis, fault))
    }

    /// Whether a fault of a valve is in force.
    pub fn valve(&self, valve: ValveNo, fault: ValveFault) -> bool {
        self.has(Fault::Valve(valve, fault))
    }

    /// Whether a fault of what exists once is in force.
    pub fn single(&self, fault: SingleFault) -> bool {
        self.has(Fault::Single(fault))
    }

    /// Puts a fault in force.
    pub fn inject(&mut self, fault: Fault) {
        if !self.has(fault) {
            self.0.push(fault);
        }
    }

    /// Repairs it.
    pub fn clear(&mut self, fault: Fault) {
        self.0.retain(|&active| active != fault);
    }

    /// Repairs everything.
    pub fn clear_all(&mut self) {
        self.0.clear();
    }

    /// What is in force, oldest first.
    pub fn active(&self) -> &[Fault] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_lead_back() {
        let mut names: Vec<String> = Fault::all().map(Fault::name).collect();
        assert_eq!(names.len(), 4 * 24 + 2 * 10 + 5 * 4 + 6 * 9 + 2 * 8 * 3 + 18);
        for fault in Fault::all() {
            assert_eq!(Fault::from_name(&fault.name()), Some(fault));
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), Fault::all().count());
        assert_eq!(Fault::from_name("vertical-teapot"), None);
    }

    #[test]
    fn inject_and_clear() {
        let mut faults = Faults::default();
        let jam = Fault::Drive(Axis::Vertical, DriveFault::Jam);
        faults.inject(jam);
        faults.inject(jam);
        assert!(faults.drive(Axis::Vertical, DriveFault::Jam));
        assert!(!faults.drive(Axis::Horizontal, DriveFault::Jam));
        faults.clear(jam);
        assert!(faults.active().is_empty());
    }
}
