//! What must never be driven, whatever the cause: the rules of the interlock, once for all harnesses.
//!
//! Written from the document, not from the device's own filter, `guard`, whose failures it must show. A harness
//! fills a [`Moment`] from its own world: what is driven, and what it knows of the situation. What it
//! does not know it leaves out, which forbids nothing; what it allows for (an encoder that lies, a
//! contact that is believed later) is its own business.

use std::fmt;

use lafet_device::image::{AXES, Axis, Outputs, VALVES, ValveNo, ValveOutput};
use lafet_proto::SubsystemId;

/// What is driven, and what is known of the situation.
#[derive(Clone, Debug)]
pub struct Moment<'a> {
    /// What is driven.
    pub outputs: &'a Outputs,
    /// §D/1 The sensors have not settled since power-up.
    pub settling: bool,
    /// §3.18 The monitor is locked out.
    pub locked: bool,
    /// §3.2/1 Everything was stopped, and nothing has been requested since.
    pub stopped: bool,
    /// The monitor has a deployer, and the barrel is not in its working position.
    pub stowed: bool,
    /// Water flows into a barrel that is not in its working position.
    pub flooded: bool,
    /// The drives, by [`Axis`].
    pub drives: [Drive; AXES],
    /// The valves, by [`ValveNo`].
    pub valves: [Valve; VALVES],
}

/// What is known of a drive.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// Where it is, while its limits are on.
    pub travel: Option<Travel>,
    /// Its lower and its upper end switch are closed.
    pub ends: (bool, bool),
}

/// A position and the limits that it must not leave, arc-minutes or mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Position.
    pub at: f64,
    /// Lower limit.
    pub min: f64,
    /// Upper limit.
    pub max: f64,
    /// How far beyond a limit it may be.
    pub allowance: f64,
}

/// What is known of a valve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Valve {
    /// It is not closed.
    pub open: bool,
    /// Its hardware block is on.
    pub blocked: bool,
    /// Under lockout it is to be driven towards closed.
    pub must_close: bool,
}

/// A rule that does not hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Broken {
    /// §D/1
    DrivenBeforeSettled,
    /// §3.18/1
    MovesLockedOut(Axis),
    /// §3.18/1
    OpensLockedOut(ValveNo),
    /// §3.18/1
    LeftOpenLockedOut(ValveNo),
    /// §3.2/1
    MovesStopped(Axis),
    /// §3.2/1
    OpensStopped(ValveNo),
    /// §3.1/1
    AimsStowed(Axis),
    /// §3.8/1
    OpensStowed(ValveNo),
    /// §3.3.5
    OpensBlocked(ValveNo),
    /// §3.11/6
    StowsWithWater(ValveNo),
    /// §3.8/1, §3.11/6
    Flooded,
    /// §3.17, §3.3.4
    LeavesLimits(Axis, Travel),
    /// §3.3.4
    IntoEndSwitch(Axis),
}

impl<'a> Moment<'a> {
    /// Only the outputs are known.
    pub fn new(outputs: &'a Outputs) -> Self {
        Self {
            outputs,
            settling: false,
            locked: false,
            stopped: false,
            stowed: false,
            flooded: false,
            drives: [Drive::default(); AXES],
            valves: [Valve::default(); VALVES],
        }
    }

    /// The rules that do not hold.
    pub fn judge(&self) -> Vec<Broken> {
        let mut broken = Vec::new();
        let mut inert = Outputs::default();
        inert.units = self.outputs.units;
        if self.settling && *self.outputs != inert {
            broken.push(Broken::DrivenBeforeSettled);
        }
        if self.flooded {
            broken.push(Broken::Flooded);
        }
        for axis in Axis::ALL {
            self.drive(axis, &mut broken);
        }
        for valve in ValveNo::ALL {
            self.valve(valve, &mut broken);
        }
        broken
    }

    fn speed(&self, axis: Axis) -> i16 {
        self.outputs.drives[axis as usize].speed_tenths
    }

    /// The barrel is in its working position and stays there.
    fn works(&self) -> bool {
        !self.stowed && self.speed(Axis::Deployer) == 0
    }

    fn drive(&self, axis: Axis, broken: &mut Vec<Broken>) {
        let speed = self.speed(axis);
        if speed == 0 {
            return;
        }
        let Drive { travel, ends: (lower, upper) } = self.drives[axis as usize];
        let leaves = travel.filter(|travel| travel.is_left(speed));
        broken.extend(leaves.map(|travel| Broken::LeavesLimits(axis, travel)));
        let rules = [
            (self.locked, Broken::MovesLockedOut(axis)),
            (self.stopped, Broken::MovesStopped(axis)),
            (axis != Axis::Deployer && !self.works(), Broken::AimsStowed(axis)),
            (speed > 0 && upper || speed < 0 && lower, Broken::IntoEndSwitch(axis)),
        ];
        broken.extend(rules.iter().filter(|(broken, _)| *broken).map(|(_, what)| *what));
    }

    fn valve(&self, valve: ValveNo, broken: &mut Vec<Broken>) {
        let output = self.outputs.valves[valve as usize];
        let opens = output == ValveOutput::Opening;
        let Valve { open, blocked, must_close } = self.valves[valve as usize];
        let left = must_close && output != ValveOutput::Closing;
        let rules = [
            (opens && self.locked, Broken::OpensLockedOut(valve)),
            (left && self.locked, Broken::LeftOpenLockedOut(valve)),
            (opens && self.stopped, Broken::OpensStopped(valve)),
            (opens && !self.works(), Broken::OpensStowed(valve)),
            (opens && blocked, Broken::OpensBlocked(valve)),
            (open && self.speed(Axis::Deployer) < 0, Broken::StowsWithWater(valve)),
        ];
        broken.extend(rules.iter().filter(|(broken, _)| *broken).map(|(_, what)| *what));
    }
}

impl Travel {
    /// Whether a drive with this speed goes further out.
    fn is_left(&self, speed: i16) -> bool {
        let Self { at, min, max, allowance } = *self;
        speed > 0 && at > max + allowance || speed < 0 && at < min - allowance
    }
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::DrivenBeforeSettled => {
                f.write_str("§D/1: an output is on before the sensors have settled")
            }
            Self::MovesLockedOut(it) => write!(f, "§3.18/1: {} moves under lockout", name(it.id())),
            Self::OpensLockedOut(it) => write!(f, "§3.18/1: {} opens under lockout", name(it.id())),
            Self::LeftOpenLockedOut(it) => {
                write!(f, "§3.18/1: {} is not being closed under lockout", name(it.id()))
            }
            Self::MovesStopped(it) => write!(f, "§3.2/1: {} moves after a stop", name(it.id())),
            Self::OpensStopped(it) => write!(f, "§3.2/1: {} opens after a stop", name(it.id())),
            Self::AimsStowed(it) => {
                write!(f, "§3.1/1: {} is driven though the barrel is not deployed", name(it.id()))
            }
            Self::OpensStowed(it) => {
                write!(f, "§3.8/1: {} is opened though the barrel is not deployed", name(it.id()))
            }
            Self::OpensBlocked(it) => write!(f, "§3.3.5: {} opens though blocked", name(it.id())),
            Self::StowsWithWater(it) => {
                write!(f, "§3.11/6: the barrel is stowed though {} is open", name(it.id()))
            }
            Self::Flooded => f.write_str("§3.11/6: water flows into a stowed barrel"),
            Self::LeavesLimits(it, Travel { at, min, max, .. }) => {
                let limits = format_args!("{min:.0}…{max:.0}");
                write!(
                    f,
                    "§3.17: {} at {at:.1} is driven out of its limits {limits}",
                    name(it.id())
                )
            }
            Self::IntoEndSwitch(it) => {
                write!(f, "§3.3.4: {} is driven into its end switch", name(it.id()))
            }
        }
    }
}

/// The name of a subsystem as in texts: `vertical`, `valve1`.
fn name(id: SubsystemId) -> String {
    id.to_string().to_lowercase()
}
