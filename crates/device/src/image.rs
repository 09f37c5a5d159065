//! The process image: what the monitor senses (`Inputs`) and what it drives (`Outputs`).
//!
//! `step` reads one from the HAL and writes the other back; between the two is `guard`.
//! Angles are arc-minutes, positive up and left; the nozzle is in millimetres, 0 = widest
//! spray, greater = narrower (§3.3.4: the lower limit of the nozzle is "wider").

use lafet_proto::SubsystemId;
use lafet_proto::flags::ButtonState;

/// The four drives, as they index the process image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Axis {
    /// Elevation.
    Vertical,
    /// Traverse.
    Horizontal,
    /// Nozzle.
    Nozzle,
    /// Deployment: 0 is wrapped, the upper limit deployed.
    Deployer,
}

/// Number of drives.
pub const AXES: usize = 4;

impl Axis {
    /// All drives, in image order.
    pub const ALL: [Self; AXES] = [Self::Vertical, Self::Horizontal, Self::Nozzle, Self::Deployer];

    /// The subsystem of the drive.
    pub const fn id(self) -> SubsystemId {
        match self {
            Self::Vertical => SubsystemId::VERTICAL,
            Self::Horizontal => SubsystemId::HORIZONTAL,
            Self::Nozzle => SubsystemId::NOZZLE,
            Self::Deployer => SubsystemId::DEPLOYER,
        }
    }

    /// The drive's unit on the internal bus.
    pub const fn unit(self) -> Unit {
        match self {
            Self::Vertical => Unit::Vertical,
            Self::Horizontal => Unit::Horizontal,
            Self::Nozzle => Unit::Nozzle,
            Self::Deployer => Unit::Deployer,
        }
    }
}

/// The two valves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ValveNo {
    /// Water.
    Valve1,
    /// Foam.
    Valve2,
}

/// Number of valves.
pub const VALVES: usize = 2;

impl ValveNo {
    /// All valves, in image order.
    pub const ALL: [Self; VALVES] = [Self::Valve1, Self::Valve2];

    /// The subsystem of the valve.
    pub const fn id(self) -> SubsystemId {
        match self {
            Self::Valve1 => SubsystemId::VALVE1,
            Self::Valve2 => SubsystemId::VALVE2,
        }
    }

    /// The valve's unit on the internal bus.
    pub const fn unit(self) -> Unit {
        match self {
            Self::Valve1 => Unit::Valve1,
            Self::Valve2 => Unit::Valve2,
        }
    }
}

/// Places whose temperature is measured and that may be heated, in the order of ThermoStatus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Place {
    /// Horizontal drive.
    Horizontal,
    /// Vertical drive.
    Vertical,
    /// Nozzle drive.
    Nozzle,
    /// Deployment drive.
    Deployer,
    /// Housing or control cabinet.
    Box,
}

/// Number of heated places.
pub const PLACES: usize = 5;

impl Place {
    /// All places, in image order.
    pub const ALL: [Self; PLACES] =
        [Self::Horizontal, Self::Vertical, Self::Nozzle, Self::Deployer, Self::Box];
}

/// Remote units of the explosion-proof execution, on the internal bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Unit {
    /// Elevation drive.
    Vertical,
    /// Traverse drive.
    Horizontal,
    /// Nozzle drive.
    Nozzle,
    /// Deployment drive.
    Deployer,
    /// Water valve.
    Valve1,
    /// Foam valve.
    Valve2,
}

/// Number of remote units at most.
pub const UNITS: usize = 6;

/// Most spots the detector reports at a time.
pub const SPOTS: usize = 4;

/// What the monitor senses.
///
/// A board fills in what it senses now, unfiltered: [the core judges it](crate::hal::Hal::read), and waits for what
/// bounces or blips. What belongs to a remote unit is its last picture: what its last good exchange has brought, and
/// what it was before until there is another.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Inputs {
    /// Drives, by [`Axis`].
    pub drives: [DriveInput; AXES],
    /// Valves, by [`ValveNo`].
    pub valves: [ValveInput; VALVES],
    /// Temperatures, by [`Place`].
    pub places: [PlaceInput; PLACES],
    /// Relative humidity in the housing, %; `None` when its sensor is faulty.
    pub humidity_percent: Option<u8>,
    /// Supply voltage, 0.1 V.
    pub main_voltage_dv: u16,
    /// Current of the pressure sensor's 4–20 mA loop, µA. Below 3.6 mA it is broken, above 21 mA shorted, when
    /// that has lasted for 30 ms.
    pub pressure_ua: u16,
    /// Flow of water or foam, l/s.
    pub flow_lps: u16,
    /// The fire detector on the barrel.
    pub detector: DetectorInput,
    /// Button post and remote button post; buttons in the order of §3.3.10. Those of a post that is not heard are
    /// `Open`.
    pub buttons: [[ButtonState; 8]; 2],
    /// Remote units, by [`Unit`].
    pub units: [UnitInput; UNITS],
}

/// One drive as sensed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DriveInput {
    /// Position from the encoder's own zero, arc-minutes or mm.
    pub position: i32,
    /// Measured speed, signed, 0.1 °/s or 0.1 mm/s.
    pub speed_tenths: i16,
    /// Motor current, 0.1 A.
    pub current_da: u16,
    /// End switch at the lower / right / wider / wrapped end.
    pub min_switch: bool,
    /// End switch at the upper / left / narrower / deployed end.
    pub max_switch: bool,
    /// The power stage finds the motor circuit open.
    pub motor_open: bool,
    /// The position sensor's own diagnosis. While it is on, and when it goes, the position may be set to
    /// anything: that is no jump of it.
    pub position_sensor_fault: bool,
    /// The speed sensor's own diagnosis.
    pub speed_sensor_fault: bool,
    /// The position counts, but from where is not known: a fault, unless the drive is homed (§D/7). Counts
    /// at once; when it changes, the position may be set to anything. Of a drive that is homed the board has to
    /// know it from its start on: later on it says nothing there.
    pub unreferenced: bool,
}

/// One valve as sensed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ValveInput {
    /// Limit switch "open".
    pub open_switch: bool,
    /// Limit switch "closed".
    pub close_switch: bool,
    /// Circuit of the "open" switch broken or shorted.
    pub open_sensor_fault: bool,
    /// Circuit of the "closed" switch broken or shorted.
    pub close_sensor_fault: bool,
    /// Motor current, 0.1 A.
    pub current_da: u16,
    /// The hardware block of the valve is on.
    pub blocked: bool,
}

/// One temperature as sensed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PlaceInput {
    /// Temperature, 0.1 °C; `None` when the sensor is faulty.
    pub temperature_dc: Option<i16>,
    /// The heater draws no current when on, or draws it when off.
    pub heater_fault: bool,
}

/// The fire detector as sensed. It looks along the barrel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DetectorInput {
    /// The detector answers, its self-test passes, and `spots` are of its last picture, 0.1 s old at most. While this is
    /// off nothing is looked for, and for 30 ms afterwards.
    pub ready: bool,
    /// The glass is dirty.
    pub dirty_lens: bool,
    /// Hot spots in its field of view now, brightest first.
    pub spots: [Option<Spot>; SPOTS],
}

/// A hot spot in the field of view, offsets from the optical axis in arc-minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spot {
    /// Left edge (positive is left, so left ≥ right).
    pub left: i16,
    /// Right edge.
    pub right: i16,
    /// Lower edge.
    pub bottom: i16,
    /// Upper edge.
    pub top: i16,
    /// Brightness, the detector's units.
    pub brightness: i32,
}

/// A remote unit as its side of the internal bus shows it.
///
/// A board exchanges with each unit every 50 ms at least, and says of the exchanges what these two flags say.
/// For the core a unit is heard from the first step with `online` and without `protocol_fault`; it is lost as soon as `online` is
/// off, and when `protocol_fault` has been on for 0.1 s of steps, of which each counts as 50 ms at most. So the
/// last picture of a unit is at most 0.2 s old when it is lost, and what a command of that time has moved is not in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct UnitInput {
    /// The unit has answered, well or not, in the last 0.1 s. The board waits for so long, the core no longer: a flag
    /// that goes off for one exchange without an answer loses the unit, and ends what its drive or valve does.
    pub online: bool,
    /// The last exchange broke the internal bus protocol (a checksum, an answer to something else): on from that
    /// exchange until the next good one, and never the sum of several. What is sensed of the unit is from before it.
    pub protocol_fault: bool,
    /// The unit reports a reset by its watchdog.
    pub watchdog_reset: bool,
    /// Reply to the [`UnitOp`] of the same `seq`.
    pub reply: Option<UnitReply>,
}

/// Result of an access to a parameter of a remote unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitReply {
    /// Sequence number of the operation that this answers.
    pub seq: u8,
    /// The value read or written, or why not.
    pub result: Result<i32, UnitError>,
}

/// Why a remote unit refused a parameter (§3.3.1 RemotePa*).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnitError {
    /// RemotePaIncomplete.
    Incomplete,
    /// RemotePaBadId.
    BadId,
    /// RemotePaBadVal.
    BadValue,
    /// RemotePaError.
    Internal,
}

/// What the monitor drives. The default is inert: nothing moves, nothing opens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Outputs {
    /// Drives, by [`Axis`].
    pub drives: [DriveOutput; AXES],
    /// Valves, by [`ValveNo`].
    pub valves: [ValveOutput; VALVES],
    /// Heaters, by [`Place`].
    pub heaters: [bool; PLACES],
    /// Operations for the remote units, by [`Unit`]; kept until the reply of the same `seq`.
    pub units: [Option<UnitOp>; UNITS],
}

impl Outputs {
    /// No drive turns and no valve's motor runs.
    pub fn is_still(&self) -> bool {
        self.drives.iter().all(|drive| drive.speed_tenths == 0)
            && self.valves.iter().all(|valve| *valve == ValveOutput::Off)
    }
}

/// Command to a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveOutput {
    /// Speed to run at, signed, 0.1 °/s or 0.1 mm/s; 0 = stopped and held.
    pub speed_tenths: i16,
    /// Its supply is to be cut (ours): it turns though it is not fed. For the enable of its power stage,
    /// or a contactor in front of it; a board that has neither only reports.
    pub cut: bool,
}

/// Command to a valve's motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ValveOutput {
    /// Motor off: the valve stays where it is.
    #[default]
    Off,
    /// Run towards open.
    Opening,
    /// Run towards closed.
    Closing,
}

/// An access to a parameter of a remote unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitOp {
    /// Changes with each operation.
    pub seq: u8,
    /// The parameter's identifier.
    pub param: u16,
    /// The value to write; `None` reads.
    pub write: Option<i32>,
}
