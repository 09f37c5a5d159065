//! The check can fail: causes that are false, outputs that are tampered with between device and
//! world, a ledger that lacks what happened.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Causes, Program, Rule};
use lafet_device::composition::{ChainSet, Composition};
use lafet_device::image::{AXES, Axis, Outputs, Unit, VALVES, ValveNo, ValveOutput};
use lafet_proto::flags::{Button, DriveFlags};
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_proto::{RequestId, SubsystemId};
use lafet_sim::fault::{DriveFault, Fault, Post, UnitFault, ValveFault};
use lafet_sim::sim::{Config, Sim};

use super::{Attribution, Told, View, Violation};

#[derive(Clone)]
struct Bench {
    sim: Sim,
    check: Attribution,
}

/// What is between the device and the check.
type Tamper<'t> = &'t dyn Fn(&mut Outputs, &mut Causes);

impl Bench {
    fn new() -> Self {
        Self::of(Config::default())
    }

    fn of(config: Config) -> Self {
        let sim = Sim::new(config);
        let check = Attribution::new(sim.now_ms());
        let mut bench = Self { sim, check };
        bench.is_fine(300);
        bench
    }

    fn deployed() -> Self {
        let mut bench = Self::new();
        bench.ask("Deploy Deployer");
        bench.is_fine(12_000);
        assert!(bench.sim.world().deployed());
        bench
    }

    fn request(&mut self, request: &str, told: bool) {
        let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
        let mut writer = Writer::new(&mut record);
        text::parse(request, &mut buffer).unwrap().encode(&mut writer).unwrap();
        let answer = self.sim.request(Source::Radio, writer.written());
        if told {
            let now_ms = self.sim.now_ms();
            self.check.delivered(now_ms, Source::Radio, writer.written(), &answer);
        }
    }

    fn ask(&mut self, request: &str) {
        self.request(request, true);
    }

    /// Steps; what the check finds.
    fn run(&mut self, ms: u64, tamper: Tamper<'_>) -> Vec<Violation> {
        let mut found = Vec::new();
        for _ in 0..ms / 10 {
            self.sim.tick();
            let mut outputs = *self.sim.world().outputs();
            let mut causes = *self.sim.device().causes();
            tamper(&mut outputs, &mut causes);
            self.sim.world_mut().drive(outputs);
            let told = Told::ask(&mut self.sim);
            let view = View { causes: &causes, ..View::of(&self.sim, told) };
            found.extend(match self.sim.stood_still() {
                true => self.check.stand_still(&view),
                false => self.check.check(&view),
            });
        }
        found
    }

    #[track_caller]
    fn is_fine(&mut self, ms: u64) {
        assert_eq!(self.run(ms, &|_, _| ()), []);
    }

    #[track_caller]
    fn is_caught(&mut self, ms: u64, tamper: Tamper<'_>, words: &str) {
        let found = self.run(ms, tamper);
        assert!(found.iter().any(|v| v.text.contains(words)), "{words}: {found:?}");
    }
}

const MOVE: Asked =
    Asked { request: RequestId::MOVE, to: SubsystemId::HORIZONTAL, source: Source::Radio };

fn claim(cause: Cause) -> impl Fn(&mut Outputs, &mut Causes) {
    move |_, causes| causes.drives[Axis::Horizontal as usize] = cause
}

/// Water flows though both valves say closed: reported it is fine, not reported it is found.
#[test]
fn untold_water_is_found() {
    let mut bench = Bench::deployed();
    let stuck = Fault::Valve(ValveNo::Valve1, ValveFault::CloseStuck);
    bench.sim.world_mut().inject(stuck);
    bench.ask("Open Valve1");
    bench.is_fine(10_000);
    let told = Told { valves: [0; VALVES], ..Told::ask(&mut bench.sim) };
    bench.sim.tick();
    let found = bench.check.check(&View::of(&bench.sim, told));
    assert!(found.iter().any(|it| it.text.contains("reports nothing of water")), "{found:?}");
}

/// §3.3.1/3, §D/6 A unit that is silent or not understood is lost: as the monitor reports it and stops its drive it is fine, any
/// other way it is found.
#[test]
fn a_lost_unit_is_reported_and_not_driven() {
    let horizontal = Axis::Horizontal as usize;
    for fault in [UnitFault::Protocol, UnitFault::Offline] {
        let start = [0.0, 0.0, 60.0, 5_400.0];
        let config = Config { composition: Composition::EX, start, ..Config::default() };
        let mut bench = Bench::of(config);
        bench.ask("Move Horizontal 9000");
        bench.is_fine(1_000);
        let heard = bench.clone();
        bench.sim.world_mut().inject(Fault::Unit(Unit::Horizontal, fault));
        bench.is_fine(3_000);
        let lost = DriveFlags::CONN_LOST.bits();
        let finds = |mut bench: Bench, told: [u32; AXES], words: &str| {
            let told = Told { drives: told, ..Told::ask(&mut bench.sim) };
            bench.sim.tick();
            let found = bench.check.check(&View::of(&bench.sim, told));
            assert!(found.iter().any(|it| it.text.contains(words)), "{words}: {found:?}");
        };
        finds(bench.clone(), [0; AXES], "Horizontal does not report that its unit is lost");
        finds(heard, [lost; AXES], "reports a unit as lost that is heard");
        let drives = |outputs: &mut Outputs, _: &mut Causes| {
            outputs.drives[horizontal].speed_tenths = 50;
        };
        bench.is_caught(20, &drives, "Horizontal is driven, and its unit is lost");
    }
}

/// §3.3.4 A position that jumps at rest is fine when it is reported, and found when it is not; one that is back at once is none.
#[test]
fn an_untold_jump_is_found() {
    for axis in Axis::ALL {
        let jump = Fault::Drive(axis, DriveFault::EncoderJump);
        let mut bench = Bench::new();
        bench.is_fine(1_000);
        let mut blips = bench.clone();
        bench.sim.world_mut().inject(jump);
        bench.is_fine(2_000);
        let told = Told { drives: [0; AXES], ..Told::ask(&mut bench.sim) };
        bench.sim.tick();
        let found = bench.check.check(&View::of(&bench.sim, told));
        assert!(found.iter().any(|it| it.text.contains("jumped at rest")), "{axis:?}: {found:?}");
        blips.sim.world_mut().inject(jump);
        blips.is_fine(80);
        blips.sim.world_mut().clear(jump);
        blips.is_fine(2_000);
        let flags = Told::ask(&mut blips.sim).drives[axis as usize];
        assert_eq!(flags & DriveFlags::POS_ENCODER_FAULT.bits(), 0, "{axis:?}");
    }
}

/// §D/6 A valve whose unit is lost while it opens is not closed for its last picture.
#[test]
fn a_valve_that_is_lost_while_it_opens() {
    let start = [0.0, 0.0, 60.0, 5_400.0];
    let mut bench = Bench::of(Config { composition: Composition::EX, start, ..Config::default() });
    bench.ask("SetParam General WaterTimeout 10");
    bench.ask("Open Valve1");
    bench.is_fine(20);
    bench.sim.world_mut().inject(Fault::Unit(Unit::Valve1, UnitFault::Protocol));
    bench.is_fine(300);
    bench.ask("Stop All");
    bench.is_fine(1_000);
    bench.ask("Wrap Deployer");
    bench.is_fine(30_000);
    assert!(bench.sim.world().deployed());
    bench.sim.world_mut().clear_all();
    bench.is_fine(30_000);
    assert!(bench.sim.world().inputs().valves[0].close_switch);
}

/// §D/6 A valve that was taken out of the chain while it stood open lets water past the one that is closed,
/// whose switch is not believed then: that one is driven towards closed for all its time.
#[test]
fn water_past_a_valve_that_is_not_in_the_chain() {
    let mut bench = Bench::deployed();
    bench.ask("Open Valve2");
    bench.is_fine(12_000);
    let chain = ChainSet::ALL.without(&[SubsystemId::VALVE2]).bits();
    bench.ask(&format!("SetParam General Chain {chain}"));
    bench.is_fine(2_000);
    bench.sim.power_cycle();
    bench.check.powered_up(bench.sim.now_ms(), bench.sim.device().params(), true);
    bench.is_fine(5_000);
    assert!(!bench.sim.device().has(SubsystemId::VALVE2));
    assert!(bench.sim.world().inputs().flow_lps > 2, "the water runs");
    bench.ask("Close Valve1");
    bench.is_fine(100);
    assert_eq!(bench.sim.world().outputs().valves[0], ValveOutput::Closing, "it is not believed");
    bench.is_fine(20_000);
    assert_eq!(bench.sim.world().outputs().valves[0], ValveOutput::Off, "its time is over");
}

/// The witness: all kinds of causes, and nothing to object to.
#[test]
fn a_sound_device_passes() {
    let mut bench = Bench::deployed();
    for request in ["Move Horizontal 600", "Open Valve1", "Move Vertical 21600"] {
        bench.ask(request);
        bench.is_fine(1_000);
    }
    bench.ask("StartQuench Control centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25");
    bench.is_fine(10_000);
    bench.sim.world_mut().press(Post::Buttons, Button::Left, true);
    bench.is_fine(1_000);
    bench.sim.world_mut().press(Post::Buttons, Button::Left, false);
    bench.is_fine(5_000);
    bench.ask("Stop Control");
    bench.ask("Close Valve1");
    bench.is_fine(6_000);
    bench.ask("Wrap Deployer");
    bench.is_fine(25_000);
    bench.ask("Lockout All on");
    bench.is_fine(1_000);
    assert!(!bench.sim.world().deployed() && bench.check.changes() > 500);
}

/// A request that the ledger does not have explains nothing.
#[test]
fn a_delivery_that_never_was() {
    let mut bench = Bench::deployed();
    bench.request("Move Horizontal 3000", false);
    bench.is_caught(200, &|_, _| (), "no such Move is in force");
    let mut bench = Bench::deployed();
    bench.request("Open Valve1", false);
    bench.is_caught(200, &|_, _| (), "no such request is in force");
}

/// The right request through the wrong interface, of another subsystem, of another kind.
#[test]
fn claims_that_are_not_true() {
    let elsewhere = Asked { source: Source::ExternalConn, ..MOVE };
    let vertical = Asked { to: SubsystemId::VERTICAL, ..MOVE };
    let seek = Asked { request: RequestId::START_SEEK, to: SubsystemId::DETECTOR, ..MOVE };
    for (cause, words) in [
        (Cause::Request(elsewhere), "no such Move is in force"),
        (Cause::Request(vertical), "no such Move is in force"),
        (Cause::Program(Program::Seek, seek), "no such program is in force"),
        (Cause::Program(Program::Deploy, MOVE), "no business with this drive"),
        (Cause::Button(SubsystemId::BUTTONS), "no such button is held"),
        (Cause::Rule(Rule::Arrived), "a rule may only take away"),
        (Cause::Rule(Rule::Lockout), "a rule may only take away"),
    ] {
        let mut bench = Bench::deployed();
        bench.ask("Move Horizontal 3000");
        bench.is_caught(200, &claim(cause), words);
    }
}

/// Motion that goes on after a stop, with the claim that was true before.
#[test]
fn motion_after_a_stop() {
    for stop in ["Stop Horizontal", "Stop All", "Stop Motors", "Lockout All on", "Wrap Deployer"] {
        let mut bench = Bench::deployed();
        bench.ask("Move Horizontal 9000");
        bench.is_fine(2_000);
        bench.ask(stop);
        let goes_on = |outputs: &mut Outputs, causes: &mut Causes| {
            outputs.drives[Axis::Horizontal as usize].speed_tenths = 200;
            causes.drives[Axis::Horizontal as usize] = Cause::Request(MOVE);
        };
        bench.is_caught(20, &goes_on, "no such Move is in force");
    }
}

/// A stop for which there was no reason.
#[test]
fn rules_whose_condition_does_not_hold() {
    for rule in [
        Rule::Overload,
        Rule::CutOff,
        Rule::Timeout,
        Rule::Fault,
        Rule::ConnLost,
        Rule::EndSwitch,
        Rule::Limit,
        Rule::Lockout,
        Rule::NotDeployed,
        Rule::Inert,
        Rule::Arrived,
        Rule::ProgramEnd,
        Rule::Paused,
        Rule::Released,
        Rule::Refused,
    ] {
        let mut bench = Bench::deployed();
        bench.ask("Move Horizontal 9000");
        bench.is_fine(2_000);
        let stops = |outputs: &mut Outputs, causes: &mut Causes| {
            outputs.drives[Axis::Horizontal as usize].speed_tenths = 0;
            causes.drives[Axis::Horizontal as usize] = Cause::Rule(rule);
        };
        bench.is_caught(10, &stops, "the condition of the rule does not hold");
    }
}

/// Outputs that the device did not give: motion, water, heat.
#[test]
fn outputs_that_are_tampered_with() {
    let mut bench = Bench::deployed();
    let moves = |outputs: &mut Outputs, _: &mut Causes| {
        outputs.drives[Axis::Vertical as usize].speed_tenths = 10;
    };
    bench.is_caught(10, &moves, "vertical 0.0 → 1.0 is not explained");
    let opens = |outputs: &mut Outputs, _: &mut Causes| {
        outputs.valves[0] = ValveOutput::Opening;
    };
    bench.is_caught(10, &opens, "a rule never opens");
    let heats = |outputs: &mut Outputs, causes: &mut Causes| {
        outputs.heaters[0] = true;
        causes.heaters[0] = Cause::Rule(Rule::Cold);
    };
    bench.is_caught(10, &heats, "the condition of the rule does not hold");
    let mut wrapped = Bench::new();
    wrapped.is_caught(100, &opens, "opened though the barrel is not deployed");
    wrapped.is_caught(3_000, &opens, "water flows into a stowed barrel");
    let mut wrapped = Bench::new();
    wrapped.is_caught(10, &moves, "vertical is driven though the barrel is not deployed");
    let mut wet = Bench::deployed();
    wet.ask("Open Valve1");
    wet.is_fine(6_000);
    let folds = |outputs: &mut Outputs, _: &mut Causes| {
        outputs.drives[Axis::Deployer as usize].speed_tenths = -10;
    };
    wet.is_caught(10, &folds, "the barrel is stowed though valve1 is open");
}

/// A button takes a drive over in a step whose output is still that of what has moved it before: of a
/// program that ends in this very step, or of a Move. One step later that is no cause.
#[test]
fn a_button_takes_over_from_what_ends() {
    let mut bench = Bench::deployed();
    bench.ask("StartQuench Control centre=600,900 nozzle=24 sector=0,0 step=0 distance=25");
    bench.is_fine(270);
    // It ends when the fault has lasted for 30 ms, as the press has then (§D/6).
    bench.sim.world_mut().inject(Fault::Drive(Axis::Nozzle, DriveFault::SpeedFault));
    bench.sim.world_mut().press(Post::Buttons, Button::Up, true);
    bench.is_fine(30);
    let speed = |bench: &Bench, axis: Axis| bench.sim.world().outputs().drives[axis as usize];
    let before = speed(&bench, Axis::Vertical).speed_tenths;
    let quench = bench.sim.device().causes().drives[Axis::Vertical as usize];
    assert!(before > 0 && matches!(quench, Cause::Program(Program::Quench, _)), "{quench:?}");
    bench.is_fine(10);
    assert!(speed(&bench, Axis::Vertical).speed_tenths > before, "it is taken over");
    let late = |_: &mut Outputs, causes: &mut Causes| {
        causes.drives[Axis::Vertical as usize] = quench;
    };
    bench.is_caught(10, &late, "no such program is in force");

    let mut bench = Bench::deployed();
    bench.ask("Move Horizontal -9000");
    bench.is_fine(300);
    bench.sim.world_mut().press(Post::Buttons, Button::Left, true);
    bench.is_fine(30);
    let before = speed(&bench, Axis::Horizontal).speed_tenths;
    bench.is_fine(10);
    assert!(speed(&bench, Axis::Horizontal).speed_tenths < before && before < 0, "it goes on");
    bench.is_fine(10);
    bench.is_caught(10, &claim(Cause::Request(MOVE)), "no such Move is in force");
}

/// Times are those of the law: TravelTime and half of it, also one that was set in the same moment,
/// after the first Open of a frame and before the second.
#[test]
fn a_valve_has_its_time() {
    let opens = |bench: &mut Bench| {
        for request in ["Open Valve1", "SetParam Valve1 TravelTime 1000", "Open Valve1"] {
            bench.ask(request);
        }
    };
    let mut bench = Bench::deployed();
    opens(&mut bench);
    bench.is_fine(1_490);
    assert_eq!(bench.sim.world().outputs().valves[0], ValveOutput::Opening);
    bench.is_fine(20);
    assert_eq!(bench.sim.world().outputs().valves[0], ValveOutput::Off);
    let mut bench = Bench::deployed();
    opens(&mut bench);
    bench.is_fine(1_400);
    let stops = |outputs: &mut Outputs, causes: &mut Causes| {
        (outputs.valves[0], causes.valves[0]) = (ValveOutput::Off, Cause::Rule(Rule::Timeout));
    };
    bench.is_caught(10, &stops, "the condition of the rule does not hold");
}

/// What the swarm has found: an opening that a lying switch had held back went on when the switch was
/// repaired, and was stopped as faulty because it had not left its switch meanwhile.
#[test]
fn an_opening_that_waits() {
    let lie = Fault::Drive(Axis::Deployer, DriveFault::MinSwitch);
    let open = Cause::Request(Asked { request: RequestId::OPEN, to: SubsystemId::VALVE1, ..MOVE });
    let mut bench = Bench::deployed();
    bench.sim.world_mut().inject(lie);
    bench.ask("Open Valve1");
    bench.is_fine(700);
    bench.sim.world_mut().clear(lie);
    bench.is_fine(100);
    assert_eq!(bench.sim.world().outputs().valves[0], ValveOutput::Off);
    let goes_on = |outputs: &mut Outputs, causes: &mut Causes| {
        (outputs.valves[0], causes.valves[0]) = (ValveOutput::Opening, open);
    };
    bench.is_caught(10, &goes_on, "no such request is in force");
    bench.ask("Open Valve1");
    bench.is_fine(6_000);
    assert!(bench.sim.world().inputs().valves[0].open_switch);
}

/// Lockout, limits and power-up are judged by the world alone.
#[test]
fn invariants_do_not_ask_for_causes() {
    let mut bench = Bench::deployed();
    bench.ask("Lockout All on");
    bench.is_fine(100);
    let moves = |outputs: &mut Outputs, _: &mut Causes| {
        outputs.drives[Axis::Vertical as usize].speed_tenths = 100;
    };
    bench.is_caught(30, &moves, "vertical moves under lockout");
    let mut bench = Bench::deployed();
    bench.ask("Move Vertical 4500");
    bench.is_fine(60_000);
    bench.is_caught(1_000, &moves, "is driven out of its limits -900…4500");
    let mut inert = Bench { sim: Sim::new(Config::default()), check: Attribution::new(0) };
    inert.is_caught(50, &moves, "before the sensors have settled");
    let mut forgets = Bench::new();
    forgets.request("Lockout All on", false);
    forgets.is_caught(20, &|_, _| (), "LockedOut is reported as true");
}

/// A switch of the Deployer that sticks on the way is seen through: no water flows, and nothing of it is a fault of the
/// device.
#[test]
fn a_lie_that_is_seen_through() {
    let mut bench = Bench::new();
    bench.ask("Deploy Deployer");
    bench.is_fine(4_000);
    bench.sim.world_mut().inject(Fault::Drive(Axis::Deployer, DriveFault::MaxSwitch));
    bench.is_fine(1_000);
    bench.ask("Open Valve1");
    bench.is_fine(5_000);
    assert!(!bench.sim.world().flooded());
}

/// §3.5/8, §D/7 Homing that is set before the first step of a program is for its next start: that one has its
/// position to find.
#[test]
fn homing_that_is_set_before_the_first_step() {
    let mut bench = Bench::deployed();
    for known in [true, false] {
        bench.sim.power_cycle();
        bench.check.powered_up(bench.sim.now_ms(), bench.sim.device().params(), true);
        bench.ask("SetParam Vertical Homing 1");
        bench.is_fine(1_000);
        let unknown = bench.sim.device().input_faults() & 1 << (8 + Axis::Vertical as usize);
        assert_eq!(unknown == 0, known);
    }
}
