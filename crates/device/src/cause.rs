//! Why each output is as it is (ours): a request, a step of a program, a button, or a rule.
//!
//! What starts or ends a motion keeps its cause: the drive, the valve. Heaters follow rules alone.
//! Where `guard` takes something away it puts its rule in the place of the cause, so
//! [`Causes`] shows for every output, in every step, why it has this value.

use crate::image::{AXES, PLACES, VALVES};
use crate::subsystem::conn::Source;
use lafet_proto::{RequestId, SubsystemId};

/// A request as it was delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// What was asked for.
    pub request: RequestId,
    /// Of whom; All and Motors too.
    pub to: SubsystemId,
    /// Through which interface.
    pub source: Source,
}

/// What moves drives by itself once a request has started it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// §3.14 Extinguishing of a sector.
    Quench,
    /// §3.15 Extinguishing along trajectories.
    Trajectory,
    /// §3.16 The search for fire.
    Seek,
    /// §3.13 Alignment of detector and barrel.
    Justify,
    /// §3.10 Deployment, also for a program or search that needs it.
    Deploy,
    /// §3.11 Wrapping: the barrel goes to its rest and is folded.
    Wrap,
}

impl Program {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Quench, Self::Trajectory, Self::Seek, Self::Justify, Self::Deploy, Self::Wrap];
}

/// A rule that acts without being asked. On drives and valves it takes away or closes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// §D/1 After power-up, before the sensors have settled, and before a reset: all is off.
    Inert,
    /// §D/1 Valves close after power-up.
    PowerUp,
    /// §3.18 Nothing moves, valves close.
    Lockout,
    /// §D/5 Aiming and water need the working position.
    NotDeployed,
    /// §D/5 A barrel with water in it is not folded.
    Water,
    /// The hardware block of the valve is on.
    Blocked,
    /// §D/8 No client has confirmed for WaterTimeout that the water is wanted.
    Unconfirmed,
    /// §D/5 The position is at or beyond a limit.
    Limit,
    /// The end switch is closed.
    EndSwitch,
    /// §3.3.4 More than MaxCurrent for longer than a start takes.
    Overload,
    /// §D/5 More than any motor may draw, at once.
    CutOff,
    /// MoveTimeout, MoveHold, or the TravelTime of a valve or of Deployer, is over.
    Timeout,
    /// A fault of motor, sensor or configuration, sensed or found by watching.
    Fault,
    /// The remote unit does not answer.
    ConnLost,
    /// It is where it was to go.
    Arrived,
    /// The program that moved it has ended by itself.
    ProgramEnd,
    /// §3.1/3 The operator corrects the aim: the program waits.
    Paused,
    /// The button was released, or contradicted by the opposite one.
    Released,
    /// §3.3.10/1 The state forbids what the button still asks for.
    Refused,
    /// §3.3.3 Colder than HeatOn: the only rule that switches something on, a heater.
    Cold,
    /// §3.3.3 Warm enough.
    Warm,
    /// §3.3.3/1 Without a temperature nothing is heated.
    NoTemperature,
    /// §3.3.3 The heater is faulty.
    HeaterFault,
    /// The subsystem is not part of the monitor.
    Absent,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 24] = [
        Self::Inert,
        Self::PowerUp,
        Self::Lockout,
        Self::NotDeployed,
        Self::Water,
        Self::Blocked,
        Self::Unconfirmed,
        Self::Limit,
        Self::EndSwitch,
        Self::Overload,
        Self::CutOff,
        Self::Timeout,
        Self::Fault,
        Self::ConnLost,
        Self::Arrived,
        Self::ProgramEnd,
        Self::Paused,
        Self::Released,
        Self::Refused,
        Self::Cold,
        Self::Warm,
        Self::NoTemperature,
        Self::HeaterFault,
        Self::Absent,
    ];
}

/// Why an output is as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A request asked for just this.
    Request(Asked),
    /// A step of a program, and the request that started it.
    Program(Program, Asked),
    /// A button of this post.
    Button(SubsystemId),
    /// No request: a rule.
    Rule(Rule),
}

impl Cause {
    /// Whether it is a step of one of these programs.
    pub fn is_of(self, programs: &[Program]) -> bool {
        matches!(self, Self::Program(program, _) if programs.contains(&program))
    }
}

// Eleven outputs keep one each, and so does what moves them: four drives two, two valves, Control, Detector
// and Deployer one.
const _: () = assert!(size_of::<Cause>() == 4 && size_of::<Causes>() == 44);

/// The cause of every output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Causes {
    /// Drives, by [`crate::image::Axis`].
    pub drives: [Cause; AXES],
    /// Valves, by [`crate::image::ValveNo`].
    pub valves: [Cause; VALVES],
    /// Heaters, by [`crate::image::Place`].
    pub heaters: [Cause; PLACES],
}

impl Causes {
    /// The same rule for everything.
    #[inline(never)]
    pub const fn all(rule: Rule) -> Self {
        let cause = Cause::Rule(rule);
        Self { drives: [cause; AXES], valves: [cause; VALVES], heaters: [cause; PLACES] }
    }
}
