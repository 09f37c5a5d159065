//! The rules that the harnesses share: what each fact forbids, and what it does not.

use lafet_device::image::{Axis, Outputs, VALVES, ValveNo, ValveOutput};
use lafet_verify::interlock::{Broken, Drive, Moment, Travel, Valve};

/// Everything is driven: the drives up, the valves open.
fn driven() -> Outputs {
    let mut outputs = Outputs::default();
    for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
        outputs.drives[axis as usize].speed_tenths = 50;
    }
    outputs.valves = [ValveOutput::Opening; VALVES];
    outputs
}

fn aiming(what: fn(Axis) -> Broken) -> Vec<Broken> {
    [Axis::Vertical, Axis::Horizontal, Axis::Nozzle].map(what).to_vec()
}

fn valves(what: fn(ValveNo) -> Broken) -> Vec<Broken> {
    ValveNo::ALL.map(what).to_vec()
}

#[test]
fn what_is_not_known_forbids_nothing() {
    assert_eq!(Moment::new(&driven()).judge(), []);
}

#[test]
fn each_fact_forbids_what_it_must() {
    let outputs = driven();
    let free = Moment::new(&outputs);
    let settling = Moment { settling: true, ..free.clone() };
    assert_eq!(settling.judge(), [Broken::DrivenBeforeSettled]);
    let flooded = Moment { flooded: true, ..free.clone() };
    assert_eq!(flooded.judge(), [Broken::Flooded]);
    let locked = Moment { locked: true, ..free.clone() };
    let expected = [aiming(Broken::MovesLockedOut), valves(Broken::OpensLockedOut)];
    assert_eq!(locked.judge(), expected.concat());
    let stopped = Moment { stopped: true, ..free.clone() };
    let expected = [aiming(Broken::MovesStopped), valves(Broken::OpensStopped)];
    assert_eq!(stopped.judge(), expected.concat());
    let stowed = Moment { stowed: true, ..free.clone() };
    let expected = [aiming(Broken::AimsStowed), valves(Broken::OpensStowed)].concat();
    assert_eq!(stowed.judge(), expected);
    let blocked = Valve { blocked: true, ..Valve::default() };
    let blocked = Moment { valves: [blocked; VALVES], ..free };
    assert_eq!(blocked.judge(), valves(Broken::OpensBlocked));
    let mut deploying = driven();
    deploying.drives[Axis::Deployer as usize].speed_tenths = 1;
    assert_eq!(Moment::new(&deploying).judge(), expected);
}

/// Without an output every situation is in order but one: what is to be closed under lockout.
#[test]
fn nothing_driven_breaks_nothing() {
    let still = Outputs::default();
    let open = Valve { open: true, blocked: true, must_close: true };
    let moment = Moment {
        settling: true,
        stopped: true,
        stowed: true,
        valves: [open; VALVES],
        ..Moment::new(&still)
    };
    assert_eq!(moment.judge(), []);
    let locked = Moment { locked: true, ..moment.clone() };
    assert_eq!(locked.judge(), valves(Broken::LeftOpenLockedOut));
    let mut closing = still;
    closing.valves = [ValveOutput::Closing; VALVES];
    let closing = Moment { settling: false, outputs: &closing, ..locked };
    assert_eq!(closing.judge(), []);
}

#[test]
fn water_forbids_stowing_alone() {
    let open = Valve { open: true, ..Valve::default() };
    let mut outputs = Outputs::default();
    for (speed, expected) in [(1, vec![]), (-1, valves(Broken::StowsWithWater))] {
        outputs.drives[Axis::Deployer as usize].speed_tenths = speed;
        let moment = Moment { valves: [open; VALVES], ..Moment::new(&outputs) };
        assert_eq!(moment.judge(), expected);
    }
}

#[test]
fn outwards_alone_is_forbidden() {
    let mut outputs = Outputs::default();
    let mut judge = |at: f64, ends: (bool, bool), speed: i16| {
        outputs.drives[Axis::Vertical as usize].speed_tenths = speed;
        let travel = Travel { at, min: -10.0, max: 20.0, allowance: 2.0 };
        let mut moment = Moment::new(&outputs);
        moment.drives[Axis::Vertical as usize] = Drive { travel: Some(travel), ends };
        moment.judge().len()
    };
    for (at, ends, up, down) in [
        (0.0, (false, false), 0, 0),
        (22.0, (false, false), 0, 0),
        (22.5, (false, false), 1, 0),
        (-12.0, (false, false), 0, 0),
        (-12.5, (false, false), 0, 1),
        (0.0, (true, false), 0, 1),
        (0.0, (false, true), 1, 0),
    ] {
        assert_eq!((judge(at, ends, 1), judge(at, ends, -1)), (up, down), "{at} {ends:?}");
    }
}
