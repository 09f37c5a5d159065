//! The guard: everything that must not pass, and beside each thing one that must.

use lafet_device::cause::{Cause, Causes, Rule};
use lafet_device::guard::{self, Rules};
use lafet_device::image::{AXES, Axis, DriveOutput, Inputs, Outputs, Place, UnitOp, ValveOutput};

const VALVE_OUTPUTS: [ValveOutput; 3] =
    [ValveOutput::Off, ValveOutput::Opening, ValveOutput::Closing];

/// A settled monitor of all subsystems.
const RULES: Rules = Rules {
    settled: true,
    locked: false,
    deployer: true,
    valves: [true; 2],
    spent: [false; 2],
    limits: [Some((-900, 4500)), Some((-10_800, 10_800)), Some((0, 60)), None],
    current_da: [160; AXES],
};

/// Deployed and dry.
fn deployed() -> Inputs {
    let mut inputs = Inputs::default();
    inputs.drives[Axis::Deployer as usize].max_switch = true;
    inputs.valves[0].close_switch = true;
    inputs.valves[1].close_switch = true;
    inputs
}

fn wrapped() -> Inputs {
    let mut inputs = deployed();
    inputs.drives[Axis::Deployer as usize].max_switch = false;
    inputs.drives[Axis::Deployer as usize].min_switch = true;
    inputs
}

fn between() -> Inputs {
    let mut inputs = wrapped();
    inputs.drives[Axis::Deployer as usize].min_switch = false;
    inputs
}

fn both_switches() -> Inputs {
    let mut inputs = wrapped();
    inputs.drives[Axis::Deployer as usize].max_switch = true;
    inputs
}

/// Everything wanted at once, Deployer apart: it contradicts the others.
fn all_wanted(speed_tenths: i16, valve: ValveOutput) -> Outputs {
    let drive = DriveOutput { speed_tenths, ..DriveOutput::default() };
    let mut wanted = Outputs::default();
    wanted.drives = [drive; AXES];
    wanted.valves = [valve; 2];
    wanted.heaters = [true; 5];
    wanted.units = [Some(UnitOp { seq: 1, param: 2, write: None }); 6];
    wanted.drives[Axis::Deployer as usize].speed_tenths = 0;
    wanted
}

fn drive_wanted(axis: Axis, speed_tenths: i16) -> Outputs {
    let mut wanted = Outputs::default();
    wanted.drives[axis as usize].speed_tenths = speed_tenths;
    wanted
}

/// What passes. The cause of an output is replaced just where the output is.
fn filter(rules: &Rules, inputs: &Inputs, wanted: &Outputs) -> Outputs {
    let before = Causes::all(Rule::Arrived);
    let mut causes = before;
    let allowed = *guard::filter(rules, inputs, wanted, &mut causes);
    for axis in 0..AXES {
        assert_eq!(
            allowed.drives[axis] == wanted.drives[axis],
            causes.drives[axis] == before.drives[axis]
        );
    }
    for valve in 0..2 {
        assert_eq!(
            allowed.valves[valve] == wanted.valves[valve],
            causes.valves[valve] == before.valves[valve]
        );
    }
    for place in 0..5 {
        assert_eq!(
            allowed.heaters[place] == wanted.heaters[place],
            causes.heaters[place] == before.heaters[place]
        );
    }
    allowed
}

/// The rule that takes this speed away.
fn rule(rules: &Rules, inputs: &Inputs, axis: Axis, speed_tenths: i16) -> Option<Rule> {
    let mut causes = Causes::all(Rule::Arrived);
    guard::filter(rules, inputs, &drive_wanted(axis, speed_tenths), &mut causes);
    match causes.drives[axis as usize] {
        Cause::Rule(Rule::Arrived) => None,
        Cause::Rule(rule) => Some(rule),
        other => panic!("{other:?}"),
    }
}

/// What of this speed passes.
fn passes(rules: &Rules, inputs: &Inputs, axis: Axis, speed_tenths: i16) -> i16 {
    filter(rules, inputs, &drive_wanted(axis, speed_tenths)).drives[axis as usize].speed_tenths
}

/// Whether this valve command passes, and what comes instead.
fn valve_passes(rules: &Rules, inputs: &Inputs, wanted: ValveOutput) -> [ValveOutput; 2] {
    filter(rules, inputs, &valves_wanted(wanted)).valves
}

fn valves_wanted(wanted: ValveOutput) -> Outputs {
    let mut outputs = Outputs::default();
    outputs.valves = [wanted; 2];
    outputs
}

/// §D/5 The witness: deployed, everything that is wanted passes as it is.
#[test]
fn deployed_everything_passes() {
    for valve in VALVE_OUTPUTS {
        for speed in [-300, -1, 0, 1, 300] {
            let wanted = all_wanted(speed, valve);
            assert_eq!(filter(&RULES, &deployed(), &wanted), wanted);
        }
    }
}

/// §D/1 Before it has settled nothing passes, not even the lockout's closing or a heater.
#[test]
fn nothing_before_it_has_settled() {
    for locked in [false, true] {
        let rules = Rules { settled: false, locked, ..RULES };
        for inputs in [deployed(), wrapped(), between(), Inputs::default()] {
            for valve in VALVE_OUTPUTS {
                for speed in [-100, 100] {
                    let mut wanted = all_wanted(speed, valve);
                    wanted.drives[Axis::Deployer as usize].speed_tenths = speed;
                    let allowed = filter(&rules, &inputs, &wanted);
                    // Parameters of remote units move nothing.
                    let mut inert = Outputs::default();
                    inert.units = wanted.units;
                    assert_eq!(allowed, inert);
                }
            }
        }
    }
}

/// §D/5 Folded, in between, or with sensors that contradict each other: no aiming, no water.
#[test]
fn no_aiming_and_no_water_unless_deployed() {
    for inputs in [wrapped(), between(), both_switches()] {
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            for speed in [-1, 1, -300, 300] {
                assert_eq!(passes(&RULES, &inputs, axis, speed), 0, "{axis:?} {speed}");
            }
        }
        assert_eq!(valve_passes(&RULES, &inputs, ValveOutput::Opening), [ValveOutput::Off; 2]);
        // Closing is the safe direction, and heating moves nothing.
        assert_eq!(valve_passes(&RULES, &inputs, ValveOutput::Closing), [ValveOutput::Closing; 2]);
        assert_eq!(filter(&RULES, &inputs, &all_wanted(1, ValveOutput::Off)).heaters, [true; 5]);
    }
}

/// §D/5 While the unit is driven it does not stand in the working position, whatever its switch says.
#[test]
fn no_aiming_and_no_water_while_deployer_runs() {
    for folding in [-50, 50] {
        let mut wanted = all_wanted(100, ValveOutput::Opening);
        wanted.drives[Axis::Deployer as usize].speed_tenths = folding;
        let allowed = filter(&RULES, &deployed(), &wanted);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            assert_eq!(allowed.drives[axis as usize].speed_tenths, 0);
        }
        assert_eq!(allowed.valves, [ValveOutput::Off; 2]);
    }
    // At its end switch it cannot go on, away from it it can.
    assert_eq!(passes(&RULES, &deployed(), Axis::Deployer, -50), -50);
    assert_eq!(passes(&RULES, &deployed(), Axis::Deployer, 50), 0);
    assert_eq!(passes(&RULES, &wrapped(), Axis::Deployer, 50), 50);
    assert_eq!(passes(&RULES, &wrapped(), Axis::Deployer, -50), 0);
    assert_eq!(passes(&RULES, &between(), Axis::Deployer, -50), -50);
}

/// §D/5 Without a Deployer there is nothing to wait for.
#[test]
fn without_deployer_it_always_works() {
    let rules = Rules { deployer: false, ..RULES };
    for inputs in [wrapped(), between(), both_switches()] {
        assert_eq!(passes(&rules, &inputs, Axis::Vertical, 100), 100);
        assert_eq!(valve_passes(&rules, &inputs, ValveOutput::Opening), [ValveOutput::Opening; 2]);
    }
}

/// §3.18/1, §D/5 Locked out nothing turns, and every valve that is not closed closes.
#[test]
fn locked_out() {
    let rules = Rules { locked: true, ..RULES };
    let mut wet = deployed();
    wet.valves[0].close_switch = false;
    for (inputs, first) in [(deployed(), None), (wet.clone(), Some(ValveOutput::Closing))] {
        for valve in VALVE_OUTPUTS {
            for speed in [-200, 200] {
                let mut wanted = all_wanted(speed, valve);
                wanted.drives[Axis::Deployer as usize].speed_tenths = -speed;
                let allowed = filter(&rules, &inputs, &wanted);
                assert_eq!(allowed.drives, Outputs::default().drives);
                assert_ne!(allowed.valves[1], ValveOutput::Opening);
                assert!(first.is_none_or(|first| allowed.valves[0] == first));
                // Heating protects and moves nothing.
                assert_eq!(allowed.heaters, [true; 5]);
            }
        }
    }
    // What was driven for all its time is driven no more, and opens no more either.
    let spent = Rules { spent: [true, false], ..rules };
    for (wanted, passes) in [(0, 0), (1, 0), (2, 2)] {
        let output = valve_passes(&spent, &wet, VALVE_OUTPUTS[wanted])[0];
        assert_eq!(output, VALVE_OUTPUTS[passes]);
    }
    let absent = Rules { valves: [false, true], ..rules };
    assert_eq!(valve_passes(&absent, &wet, ValveOutput::Closing)[0], ValveOutput::Off);
}

/// §D/5 Limits in the encoder's own coordinates: never further out, always back.
#[test]
fn limits() {
    for (axis, min, max) in
        [(Axis::Vertical, -900, 4500), (Axis::Horizontal, -10_800, 10_800), (Axis::Nozzle, 0, 60)]
    {
        let at = |position: i32| {
            let mut inputs = deployed();
            inputs.drives[axis as usize].position = position;
            inputs
        };
        for inside in [min, (min + max) / 2, max] {
            assert_eq!(passes(&RULES, &at(inside), axis, 70), 70);
            assert_eq!(passes(&RULES, &at(inside), axis, -70), -70);
        }
        for far in [1, 5000, i32::MAX - 11_000] {
            assert_eq!(passes(&RULES, &at(max + far), axis, 70), 0);
            assert_eq!(passes(&RULES, &at(max + far), axis, -70), -70);
            assert_eq!(passes(&RULES, &at(min - far), axis, -70), 0);
            assert_eq!(passes(&RULES, &at(min - far), axis, 70), 70);
        }
        let off = Rules { limits: [None; AXES], ..RULES };
        assert_eq!(passes(&off, &at(max + 5000), axis, 70), 70);
    }
}

/// §D/5, §3.3.4/2 An end switch holds with limits and without.
#[test]
fn end_switches() {
    for limits in [RULES.limits, [None; AXES]] {
        let rules = Rules { limits, ..RULES };
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            let mut inputs = deployed();
            inputs.drives[axis as usize].max_switch = true;
            assert_eq!(passes(&rules, &inputs, axis, 30), 0);
            assert_eq!(passes(&rules, &inputs, axis, -30), -30);
            inputs.drives[axis as usize].min_switch = true;
            assert_eq!(passes(&rules, &inputs, axis, -30), 0);
            inputs.drives[axis as usize].max_switch = false;
            assert_eq!(passes(&rules, &inputs, axis, 30), 30);
        }
    }
}

/// §D/5 A drive that draws far too much is cut off, in both directions, and no other.
#[test]
fn overcurrent() {
    for axis in Axis::ALL {
        let mut inputs = between();
        if axis != Axis::Deployer {
            inputs = deployed();
        }
        inputs.drives[axis as usize].current_da = 160;
        assert_eq!(passes(&RULES, &inputs, axis, -30), -30);
        inputs.drives[axis as usize].current_da = 161;
        assert_eq!(passes(&RULES, &inputs, axis, -30), 0);
        assert_eq!(passes(&RULES, &inputs, axis, 30), 0);
        if axis != Axis::Deployer {
            let other = if axis == Axis::Nozzle { Axis::Vertical } else { Axis::Nozzle };
            assert_eq!(passes(&RULES, &inputs, other, 30), 30);
        }
    }
}

/// §D/5, §3.11/6 Water in the barrel: no folding; unfolding is free. Only valves that are there count.
#[test]
fn no_folding_with_water() {
    for valve in 0..2 {
        for base in [deployed(), between()] {
            let mut inputs = base;
            inputs.valves[valve].close_switch = false;
            assert_eq!(passes(&RULES, &inputs, Axis::Deployer, -50), 0);
            if !inputs.drives[Axis::Deployer as usize].max_switch {
                assert_eq!(passes(&RULES, &inputs, Axis::Deployer, 50), 50);
            }
            let mut valves = [true; 2];
            valves[valve] = false;
            let absent = Rules { valves, ..RULES };
            assert_eq!(passes(&absent, &inputs, Axis::Deployer, -50), -50);
        }
    }
}

/// §3.3.5/1 A valve that is blocked is not opened; it may be closed.
#[test]
fn blocked_valve() {
    let mut inputs = deployed();
    inputs.valves[0].blocked = true;
    let [first, second] = valve_passes(&RULES, &inputs, ValveOutput::Opening);
    assert_eq!((first, second), (ValveOutput::Off, ValveOutput::Opening));
    assert_eq!(valve_passes(&RULES, &inputs, ValveOutput::Closing)[0], ValveOutput::Closing);
}

/// §D/5 The guard only takes away: over every combination of rules and switches no drive runs that
/// was not wanted to, none turns round, and no valve opens that was not driven to.
#[test]
fn it_only_takes_away() {
    let mut moved = 0;
    for bits in 0_u32..1 << 12 {
        let bit = |n: u32| bits >> n & 1 != 0;
        let rules = Rules { settled: bit(0), locked: bit(1), deployer: bit(2), ..RULES };
        let mut inputs = deployed();
        inputs.drives[Axis::Deployer as usize].max_switch = bit(3);
        inputs.drives[Axis::Deployer as usize].min_switch = bit(4);
        inputs.drives[Axis::Vertical as usize].max_switch = bit(5);
        inputs.drives[Axis::Vertical as usize].current_da = if bit(6) { 500 } else { 0 };
        inputs.drives[Axis::Vertical as usize].position = if bit(7) { 9999 } else { 0 };
        inputs.valves[0].close_switch = bit(8);
        inputs.valves[1].blocked = bit(9);
        let mut wanted = all_wanted(if bit(10) { 50 } else { -50 }, ValveOutput::Opening);
        wanted.valves[0] = ValveOutput::Off;
        wanted.drives[Axis::Deployer as usize].speed_tenths = if bit(11) { -20 } else { 0 };
        let allowed = filter(&rules, &inputs, &wanted);
        for (allowed, wanted) in allowed.drives.iter().zip(&wanted.drives) {
            assert!([0, wanted.speed_tenths].contains(&allowed.speed_tenths));
            moved += u32::from(allowed.speed_tenths != 0);
        }
        assert_ne!(allowed.valves[0], ValveOutput::Opening);
        let working = !rules.deployer || bit(3) && !bit(4) && !bit(11);
        let may_open = rules.settled && !rules.locked && working && !bit(9);
        assert_eq!(allowed.valves[1] == ValveOutput::Opening, may_open, "{bits:#b}");
        assert_eq!(allowed.heaters[Place::Box as usize], rules.settled);
    }
    assert!(moved > 400, "{moved}");
}

/// What is taken away says by which rule, and what passes keeps its cause.
#[test]
fn each_rule_is_told() {
    use Rule as R;
    let vertical =
        |inputs: &Inputs, rules: &Rules, speed| rule(rules, inputs, Axis::Vertical, speed);
    assert_eq!(vertical(&deployed(), &RULES, 50), None);
    assert_eq!(vertical(&deployed(), &RULES, 0), None);
    assert_eq!(vertical(&deployed(), &Rules { settled: false, ..RULES }, 50), Some(R::Inert));
    assert_eq!(vertical(&deployed(), &Rules { locked: true, ..RULES }, 50), Some(R::Lockout));
    assert_eq!(vertical(&wrapped(), &RULES, 50), Some(R::NotDeployed));
    let mut inputs = deployed();
    inputs.drives[Axis::Vertical as usize].position = 4501;
    assert_eq!(vertical(&inputs, &RULES, 50), Some(R::Limit));
    assert_eq!(vertical(&inputs, &RULES, -50), None);
    inputs.drives[Axis::Vertical as usize].max_switch = true;
    assert_eq!(vertical(&inputs, &RULES, 50), Some(R::EndSwitch));
    inputs.drives[Axis::Vertical as usize].current_da = 161;
    assert_eq!(vertical(&inputs, &RULES, -50), Some(R::CutOff));
    let mut wet = deployed();
    wet.valves[1].close_switch = false;
    assert_eq!(rule(&RULES, &wet, Axis::Deployer, -50), Some(R::Water));
    let valve = |rules: &Rules, inputs: &Inputs, output: ValveOutput| {
        let mut causes = Causes::all(R::Arrived);
        guard::filter(rules, inputs, &valves_wanted(output), &mut causes);
        causes.valves[1]
    };
    let open = ValveOutput::Opening;
    let locked = Rules { locked: true, ..RULES };
    assert_eq!(valve(&RULES, &deployed(), open), Cause::Rule(R::Arrived));
    assert_eq!(valve(&locked, &deployed(), open), Cause::Rule(R::Lockout));
    assert_eq!(valve(&locked, &wet, ValveOutput::Off), Cause::Rule(R::Lockout));
    assert_eq!(valve(&RULES, &wrapped(), open), Cause::Rule(R::NotDeployed));
    assert_eq!(valve(&Rules { settled: false, ..RULES }, &wet, open), Cause::Rule(R::Inert));
    assert_eq!(
        valve(&Rules { valves: [true, false], ..RULES }, &wet, open),
        Cause::Rule(R::Absent)
    );
    wet.valves[1].blocked = true;
    assert_eq!(valve(&RULES, &wet, open), Cause::Rule(R::Blocked));
    assert_eq!(valve(&RULES, &wet, ValveOutput::Closing), Cause::Rule(R::Arrived));
}
