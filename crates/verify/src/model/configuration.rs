//! Configurations of the checker: what may happen, on which monitor, and what must be seen.

use crate::model::ask::{self, Ask};
use crate::model::plant::Fault;
use crate::model::witness::{Activity, Disturbance, Event, Witness};
use crate::model::world::{Action, World};
use lafet_device::Composition;
use lafet_device::composition::{ChainSet, DriveKind};
use lafet_device::image::{AXES, Axis, Unit, ValveNo};
use lafet_proto::SubsystemId;
use lafet_proto::flags::Button;
use lafet_proto::param::Param;

/// A run of the checker.
#[derive(Debug)]
pub struct Configuration {
    /// Name on the command line.
    pub name: &'static str,
    /// Purpose of the run.
    pub about: &'static str,
    /// Configuration of the monitor.
    pub composition: Composition,
    /// Direction of the fire, arc-minutes to the left.
    pub fire_at: i32,
    /// Requests that may be sent at any time.
    pub asks: &'static [&'static [Ask]],
    /// Buttons that may be pressed.
    pub buttons: &'static [Button],
    /// Faults that may occur, one at a time.
    pub faults: &'static [Fault],
    /// Most faults in one run.
    pub fault_budget: u8,
    /// Whether a fire may start and go out.
    pub fires: bool,
    /// Whether the pressure may come and go.
    pub pressures: bool,
    /// Whether the power may fail.
    pub power_loss: bool,
    /// Number of states after which every witness has been seen.
    pub quick_states: usize,
    /// Events that must be seen.
    pub witnesses: &'static [&'static [Witness]],
}

impl Configuration {
    /// Appends the actions possible in a state.
    pub fn actions<M>(&self, world: &World<M>, actions: &mut Vec<Action>) {
        actions.push(Action::Wait);
        actions.extend(self.asks.iter().copied().flatten().map(|ask| Action::Ask(*ask)));
        match world.plant.held {
            Some(_) => actions.push(Action::Release),
            None => actions.extend(self.buttons.iter().map(|button| Action::Press(*button))),
        }
        match world.plant.fault {
            Some(_) => actions.push(Action::Mend),
            None if world.faults_left > 0 => {
                actions.extend(self.faults.iter().map(|fault| Action::Break(*fault)));
            }
            None => {}
        }
        if self.fires {
            actions.push(Action::Fire(!world.plant.fire));
        }
        if self.pressures {
            actions.push(Action::Pressure(!world.plant.pressure));
        }
        if self.power_loss {
            actions.push(Action::PowerLoss);
        }
    }

    /// A run by its name.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|configuration| configuration.name == name)
    }
}

/// Short travels, for a small number of positions.
const SETTINGS: &[(Param, i32)] = &SETTING;
/// Elevation is not corrected, so no timer runs while a program runs.
const STRAIGHT: &[(Param, i32)] = &{
    let [a, b, c, d, e, f, g, h, i] = SETTING;
    [a, b, c, d, e, f, g, h, i, (Param::ControlBallistics, 0)]
};
const SETTING: [(Param, i32); 9] = [
    (Param::HorizontalMinLimit, -300),
    (Param::HorizontalMaxLimit, 300),
    (Param::VerticalMinLimit, 0),
    (Param::VerticalMaxLimit, 300),
    (Param::DeployerMaxLimit, 1200),
    (Param::DeployerTravelTime, 3000),
    (Param::Valve1TravelTime, 3000),
    (Param::Valve2TravelTime, 3000),
    (Param::DetectorFieldOfView, 1200),
];

const FULL: Composition = Composition { settings: SETTINGS, ..Composition::FULL };
/// Without the foam valve: for the interlock it is the same as the water valve.
const SINGLE: Composition = Composition {
    chain: ChainSet::ALL.without(&[
        SubsystemId::VALVE2,
        SubsystemId::CLIMATICS,
        SubsystemId::RADIO,
        SubsystemId::EXT_BUTTONS,
    ]),
    settings: STRAIGHT,
    ..FULL
};
const REMOTE: Composition = Composition { settings: SETTINGS, ..Composition::REMOTE };
const MINI: Composition = Composition { settings: STRAIGHT, ..Composition::MINI };
const EX: Composition =
    Composition { drives: [DriveKind::Remote; AXES], remote_valves: [true; 2], ..SINGLE };
const SWITCHES: Composition = Composition { drives: [DriveKind::LimitSwitches; AXES], ..SINGLE };

const LEFT: Ask = ask::go(Axis::Horizontal, 21_600);
const RIGHT: Ask = ask::go(Axis::Horizontal, -21_600);
const FOLD: Ask = ask::go(Axis::Deployer, -21_600);
const UNFOLD: Ask = ask::go(Axis::Deployer, 21_600);
const WATER: Ask = ask::open(ValveNo::Valve1);
const NO_WATER: Ask = ask::close(ValveNo::Valve1);
const FOAM: Ask = ask::open(ValveNo::Valve2);
const NO_FOAM: Ask = ask::close(ValveNo::Valve2);

const POSITION: &[Ask] = &[ask::DEPLOY, ask::WRAP];
const EMERGENCY: &[Ask] = &[ask::STOP_ALL, ask::LOCK, ask::UNLOCK];

const fn on(event: Event) -> Witness {
    Witness::event(event)
}

/// A disturbance in the middle of each of these activities.
macro_rules! amid {
    ($disturbance:ident: $($activity:ident)*) => {
        &[$(Witness::disturbed(Disturbance::$disturbance, Activity::$activity),)*]
    };
}

/// All configurations, from the shortest to the longest run.
pub static ALL: &[Configuration] = &[
    Configuration {
        name: "small",
        about: "a little of everything, for the tests",
        composition: SINGLE,
        fire_at: -300,
        asks: &[POSITION, EMERGENCY, &[WATER, LEFT, ask::QUENCH, ask::SEEK]],
        buttons: &[],
        faults: &[],
        fault_budget: 0,
        fires: false,
        pressures: false,
        power_loss: true,
        quick_states: 140_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Wrapped),
                on(Event::WaterOn),
                on(Event::WaterOff),
                on(Event::Aimed),
                on(Event::DeployedForProgram),
                on(Event::DeployedForSearch),
                on(Event::QuenchRuns),
                on(Event::Paused),
                on(Event::Resumed),
                on(Event::Found),
                on(Event::Released),
            ],
            amid!(Lockout: Deploying Wrapping Moving Opening Water Waiting Program Paused Searching),
            amid!(Stop: Deploying Wrapping Moving Opening Water Waiting Program Paused Searching),
            amid!(PowerLoss: Deploying Wrapping Moving Opening Water Waiting Program Paused
                Searching),
        ],
    },
    Configuration {
        name: "water",
        about: "deployment, both valves and every way to stop them",
        composition: FULL,
        fire_at: -300,
        asks: &[
            POSITION,
            EMERGENCY,
            &[
                WATER,
                NO_WATER,
                FOAM,
                NO_FOAM,
                FOLD,
                UNFOLD,
                ask::RESTART,
                ask::stop(SubsystemId::VALVE1),
                ask::stop(SubsystemId::DEPLOYER),
            ],
        ],
        buttons: &[Button::Open],
        faults: &[],
        fault_budget: 0,
        fires: false,
        pressures: false,
        power_loss: true,
        quick_states: 180_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Wrapped),
                on(Event::WaterOn),
                on(Event::FoamOn),
                on(Event::WaterOff),
                on(Event::OpenedByButton),
                on(Event::Released),
                on(Event::Restarted),
            ],
            amid!(Lockout: Deploying Wrapping Opening Water),
            amid!(Stop: Deploying Wrapping Opening Water),
            amid!(PowerLoss: Deploying Wrapping Opening Water),
            amid!(Restart: Deploying Wrapping Opening Water),
        ],
    },
    Configuration {
        name: "programs",
        about: "programs, searches and alignment with deployment, water and manual control",
        composition: SINGLE,
        fire_at: -300,
        asks: &[
            POSITION,
            EMERGENCY,
            &[
                WATER,
                NO_WATER,
                LEFT,
                ask::QUENCH,
                ask::TRAJECTORY,
                ask::SEEK,
                ask::stop(SubsystemId::CONTROL),
                ask::stop(SubsystemId::DETECTOR),
            ],
        ],
        buttons: &[],
        faults: &[],
        fault_budget: 0,
        fires: true,
        pressures: false,
        power_loss: false,
        quick_states: 900_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Wrapped),
                on(Event::WaterOn),
                on(Event::Aimed),
                on(Event::DeployedForProgram),
                on(Event::DeployedForSearch),
                on(Event::QuenchRuns),
                on(Event::TrajectoryFinished),
                on(Event::Paused),
                on(Event::Resumed),
                on(Event::Found),
                on(Event::NothingFound),
                on(Event::Released),
            ],
            amid!(Lockout: Waiting Program Paused Searching),
            amid!(Stop: Waiting Program Paused Searching),
        ],
    },
    Configuration {
        name: "limits",
        about: "limits off, set and on again, with manual aiming and a program",
        composition: SINGLE,
        fire_at: -300,
        asks: &[
            POSITION,
            EMERGENCY,
            &[
                LEFT,
                RIGHT,
                ask::LIMITS_OFF,
                ask::LIMITS_ON,
                ask::LIMITS_REJECT,
                ask::TAKE_LIMIT,
                ask::QUENCH,
            ],
        ],
        buttons: &[Button::Left],
        faults: &[],
        fault_budget: 0,
        fires: false,
        pressures: false,
        power_loss: true,
        quick_states: 180_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Aimed),
                on(Event::AimedByButton),
                on(Event::LimitsOff),
                on(Event::BeyondLimits),
                on(Event::LimitTaken),
                on(Event::LimitsOn),
                on(Event::QuenchRuns),
            ],
            amid!(Lockout: Moving Limitless Program),
            amid!(Stop: Moving Limitless Program),
            amid!(PowerLoss: Moving Limitless Program),
        ],
    },
    Configuration {
        name: "drives-fail",
        about: "faults of drives in the middle of deployment, aiming, programs and searches",
        composition: SINGLE,
        fire_at: -300,
        asks: &[POSITION, &[ask::STOP_ALL, LEFT, ask::QUENCH, ask::ANALYSE]],
        buttons: &[],
        faults: &[
            Fault::Encoder(Axis::Horizontal),
            Fault::Jam(Axis::Horizontal),
            Fault::Motor(Axis::Vertical),
            Fault::Jam(Axis::Deployer),
            Fault::Encoder(Axis::Deployer),
            Fault::Detector,
        ],
        fault_budget: 1,
        fires: false,
        pressures: false,
        power_loss: false,
        quick_states: 140_000,
        witnesses: &[
            &[
                on(Event::ToldFault),
                on(Event::RecoveredDeployed),
                on(Event::RecoveredAimed),
                on(Event::QuenchRuns),
                on(Event::Found),
            ],
            amid!(Fault: Deploying Wrapping Moving Waiting Program Paused Searching),
        ],
    },
    Configuration {
        name: "valve-fails",
        about: "faults of a valve and of the memory, with lockout and loss of power",
        composition: SINGLE,
        fire_at: -300,
        asks: &[POSITION, EMERGENCY, &[WATER, NO_WATER]],
        buttons: &[],
        faults: &[
            Fault::ValveStuck(ValveNo::Valve1),
            Fault::ValveBlocked(ValveNo::Valve1),
            Fault::Flash,
        ],
        fault_budget: 1,
        fires: false,
        pressures: false,
        power_loss: true,
        quick_states: 120_000,
        witnesses: &[
            &[on(Event::ToldFault), on(Event::RecoveredDeployed), on(Event::RecoveredWater)],
            amid!(Fault: Deploying Wrapping Opening Water),
            amid!(Lockout: Deploying Wrapping Opening Water),
        ],
    },
    Configuration {
        name: "ex",
        about: "the explosion-proof variant, whose units may be lost",
        composition: EX,
        fire_at: -300,
        asks: &[
            POSITION,
            &[ask::STOP_ALL, WATER, LEFT, ask::QUENCH, ask::SEEK, ask::LIMITS_OFF, ask::LIMITS_ON],
        ],
        buttons: &[],
        faults: &[
            Fault::Offline(Unit::Horizontal),
            Fault::Offline(Unit::Deployer),
            Fault::Offline(Unit::Valve1),
        ],
        fault_budget: 1,
        fires: false,
        pressures: false,
        power_loss: false,
        quick_states: 1_200_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Wrapped),
                on(Event::WaterOn),
                on(Event::Aimed),
                on(Event::QuenchRuns),
                on(Event::Found),
                on(Event::LimitsOff),
                on(Event::LimitsOn),
                on(Event::ToldFault),
                on(Event::RecoveredDeployed),
            ],
            amid!(Fault: Deploying Wrapping Moving Opening Water Program Searching),
        ],
    },
    Configuration {
        name: "remote",
        about: "a remote-controlled monitor, always deployed",
        composition: REMOTE,
        fire_at: -300,
        asks: &[EMERGENCY, &[WATER, LEFT, ask::RAISED, ask::TRAJECTORY, ask::RESTART]],
        buttons: &[Button::Left],
        faults: &[],
        fault_budget: 0,
        fires: false,
        pressures: true,
        power_loss: false,
        quick_states: 900_000,
        witnesses: &[
            &[
                on(Event::WaterOn),
                on(Event::WaterOff),
                on(Event::Aimed),
                on(Event::AimedByButton),
                on(Event::QuenchRuns),
                on(Event::DirectAim),
                on(Event::TrajectoryFinished),
                on(Event::Paused),
                on(Event::Resumed),
                on(Event::Released),
                on(Event::Restarted),
            ],
            amid!(Lockout: Moving Opening Water Program Paused),
            amid!(Stop: Moving Opening Water Program Paused),
            amid!(Restart: Moving Opening Water Program Paused),
        ],
    },
    Configuration {
        name: "mini",
        about: "a mini robot: no deployment, a detector",
        composition: MINI,
        fire_at: 0,
        asks: &[
            EMERGENCY,
            &[
                WATER,
                NO_WATER,
                LEFT,
                ask::QUENCH,
                ask::SEEK_AHEAD,
                ask::JUSTIFY,
                ask::stop(SubsystemId::DETECTOR),
            ],
        ],
        buttons: &[Button::Right],
        faults: &[Fault::Jam(Axis::Horizontal), Fault::Detector],
        fault_budget: 1,
        fires: false,
        pressures: false,
        power_loss: true,
        quick_states: 150_000,
        witnesses: &[
            &[
                on(Event::WaterOn),
                on(Event::Aimed),
                on(Event::AimedByButton),
                on(Event::QuenchRuns),
                on(Event::Found),
                on(Event::Justified),
                on(Event::RecoveredAimed),
                on(Event::Released),
            ],
            amid!(Lockout: Moving Opening Water Program Paused Searching Justifying),
            amid!(Fault: Moving Opening Water Program Paused Searching Justifying),
            amid!(PowerLoss: Moving Opening Water Program Paused Searching Justifying),
        ],
    },
    Configuration {
        name: "limit-switch",
        about: "drives with limit switches",
        composition: SWITCHES,
        fire_at: -300,
        asks: &[
            POSITION,
            EMERGENCY,
            &[WATER, NO_WATER, LEFT, RIGHT, ask::LIMITS_OFF, ask::QUENCH, ask::SEEK],
        ],
        buttons: &[],
        faults: &[Fault::Jam(Axis::Deployer)],
        fault_budget: 1,
        fires: false,
        pressures: false,
        power_loss: false,
        quick_states: 150_000,
        witnesses: &[
            &[
                on(Event::Deployed),
                on(Event::Wrapped),
                on(Event::WaterOn),
                on(Event::Aimed),
                on(Event::QuenchRuns),
                on(Event::Found),
                on(Event::Released),
            ],
            amid!(Lockout: Deploying Wrapping Moving Opening Water Waiting Program Searching),
            amid!(Fault: Deploying Wrapping),
        ],
    },
];
