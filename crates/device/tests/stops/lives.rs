//! Monitors in the middle of something.

use crate::common::{Rig, STEP_MS};
use crate::flood::Random;
use lafet_device::Composition;
use lafet_device::image::Axis;
use lafet_proto::flags::{ButtonState, DeployerFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Seek, Trajectory, TrajectoryPoint};
use lafet_proto::{Request, SubsystemId};

/// Moments of an activity that are kept.
const PHASES: u64 = 8;

/// A monitor that is doing something.
pub struct Life {
    pub activity: usize,
    pub rig: Rig,
}

/// What a monitor may be doing.
pub struct Activity {
    pub name: &'static str,
    /// How long it lasts at least, so that every phase of it is still in it, ms.
    pub lasts_ms: u64,
    needs: &'static [SubsystemId],
    begin: fn(&mut Rig),
}

const SECTOR: Sector =
    Sector { centre_h: 300, centre_v: 600, nozzle: 30, width: 900, height: 600, step: 1 };
const SEEK: Seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 1 };
const UP: usize = 2;
const LEFT: usize = 0;
const NARROW: usize = 5;

pub const ACTIVITIES: [Activity; 24] = [
    Activity::new("at rest", 100, &[], |_| {}),
    Activity::new("at rest with water", 100, &[], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
    }),
    Activity::new("deploying", 3000, &[SubsystemId::DEPLOYER], |rig| {
        wrap(rig);
        rig.accepts(SubsystemId::DEPLOYER, Body::Deploy);
    }),
    Activity::new("wrapping", 4000, &[SubsystemId::DEPLOYER], |rig| {
        rig.plant.place(Axis::Horizontal, 500);
        rig.pause();
        rig.run(100);
        rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    }),
    Activity::new("moving", 4000, &[], moving),
    Activity::new("moving without limits", 4000, &[], |rig| {
        rig.ask(SubsystemId::MOTORS, Body::SwitchLimits { new_state: 0 });
        moving(rig);
    }),
    Activity::new("moving Deployer", 2000, &[SubsystemId::DEPLOYER], |rig| {
        rig.accepts(SubsystemId::DEPLOYER, Body::Move { destination: 2000 });
    }),
    Activity::new("searching", 4000, &[SubsystemId::DETECTOR], |rig| {
        rig.accepts(SubsystemId::DETECTOR, Body::StartSeek(SEEK));
    }),
    Activity::new(
        "deploying for a search",
        3000,
        &[SubsystemId::DETECTOR, SubsystemId::DEPLOYER],
        |rig| {
            wrap(rig);
            rig.accepts(SubsystemId::DETECTOR, Body::StartSeek(SEEK));
        },
    ),
    Activity::new("justifying", 2000, &[SubsystemId::DETECTOR], |rig| {
        rig.plant.place(Axis::Horizontal, 3000);
        rig.pause();
        rig.run(100);
        rig.accepts(SubsystemId::DETECTOR, Body::StartJustify);
    }),
    Activity::new("quenching", 4000, &[SubsystemId::CONTROL], quenching),
    Activity::new("quenching with water", 4000, &[SubsystemId::CONTROL], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
        quenching(rig);
    }),
    Activity::new("quenching, paused", 2000, &[SubsystemId::CONTROL], |rig| {
        quenching(rig);
        rig.run(500);
        moving(rig);
    }),
    Activity::new("on a trajectory", 4000, &[SubsystemId::CONTROL], |rig| {
        let point =
            |horizontal| TrajectoryPoint { horizontal, vertical: 400, distance: 0, dwell: 1 };
        let points = [point(-900), point(900)];
        let path = Path::Points(Points::Values(&points));
        let trajectory = Trajectory { ballistics: false, repeat: true, path };
        rig.accepts(SubsystemId::CONTROL, Body::StartTrajectory(trajectory));
    }),
    Activity::new("opening", 3500, &[], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    }),
    Activity::new("opening both", 3500, &[SubsystemId::VALVE2], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.accepts(SubsystemId::VALVE2, Body::Open { key: key::OPEN });
    }),
    Activity::new("closing", 3000, &[], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
        rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    }),
    Activity::new("buttons held", 4000, &[SubsystemId::BUTTONS], |rig| {
        for button in [UP, LEFT, NARROW] {
            rig.plant.inputs.buttons[0][button] = ButtonState::Pressed;
        }
    }),
    Activity::new("remote buttons held", 4000, &[SubsystemId::EXT_BUTTONS], |rig| {
        for button in [UP, LEFT, NARROW] {
            rig.plant.inputs.buttons[1][button] = ButtonState::Pressed;
        }
    }),
    Activity::new("everything at once", 3500, &[], |rig| {
        moving(rig);
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.set(Param::ClimaticsHeatOn, 15);
    }),
    Activity::new("moving under MoveTimeout", 1500, &[], |rig| {
        rig.set(Param::GeneralMoveTimeout, 2000);
        moving(rig);
    }),
    Activity::new("reset with water, closing", 2000, &[], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
        rig.power_cycle();
    }),
    Activity::new("reset with water that goes on, moving", 3000, &[], |rig| {
        rig.set(Param::GeneralResetValves, 1);
        rig.run(100);
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
        rig.power_cycle_and_settle();
        moving(rig);
    }),
    Activity::new("locked out", 3000, &[], |rig| {
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run(5000);
        let lockout = Request::lockout(true);
        rig.all_accept(lockout.body);
    }),
];

impl Activity {
    const fn new(
        name: &'static str,
        lasts_ms: u64,
        needs: &'static [SubsystemId],
        begin: fn(&mut Rig),
    ) -> Self {
        Self { name, lasts_ms, needs, begin }
    }
}

/// Every activity of every profile, in random phases.
pub fn lives(random: &mut Random) -> Vec<Life> {
    let mut lives = Vec::new();
    for composition in Composition::ALL {
        let mut ready = Rig::at(composition, random.next() as u32);
        if ready.device.has(SubsystemId::DEPLOYER) {
            ready.deploy();
        }
        for (number, activity) in ACTIVITIES.iter().enumerate() {
            if !activity.needs.iter().all(|id| ready.device.has(*id)) {
                continue;
            }
            let mut rig = ready.clone();
            (activity.begin)(&mut rig);
            for _ in 0..PHASES {
                let steps = 1 + random.below(activity.lasts_ms / PHASES / u64::from(STEP_MS));
                rig.run(steps as u32 * STEP_MS);
                lives.push(Life { activity: number, rig: rig.clone() });
            }
        }
    }
    lives
}

fn wrap(rig: &mut Rig) {
    rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    rig.run_until(30_000, |rig| rig.deployer().contains(DeployerFlags::WRAPPED));
}

fn moving(rig: &mut Rig) {
    for (drive, destination) in
        [(SubsystemId::HORIZONTAL, 5000), (SubsystemId::VERTICAL, 4000), (SubsystemId::NOZZLE, 60)]
    {
        rig.accepts(drive, Body::Move { destination });
    }
}

fn quenching(rig: &mut Rig) {
    let quench = Quench::Full { sector: SECTOR, distance: 0 };
    rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
}
