//! Barrels come to rest where they are sent, whatever lies between the voltage and the barrel (§3.1): motors that
//! answer late and that stick, gears with play. What is read back of the outputs is judged as without.

use lafet_device::image::Axis;
use lafet_proto::flags::{DriveFlags, ValveFlags};
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, SubsystemId};
use lafet_sim::drive::Stage;

use super::{
    MS_NS, deployed, drive_flags, ensure, flags, inputs, is_live, near, position_of, request,
    sound, truth,
};
use crate::plant::{LEAST_DUTY, MOTOR_LIVE, RELAYS};
use crate::rig::{Parts, Rig, Wrong};

const AIMING: [Axis; 3] = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];
/// From its target a barrel rests no farther than this, beside the play between it and its encoder, ' and mm: of the
/// nozzle a whole mm, which counts as near, and the half of one that it is rounded by.
const NEAR: f64 = 3.0;
const NEAR_NOZZLE: f64 = 1.5;
/// It goes no farther beyond its target, ' and mm.
const BEYOND: f64 = 30.0;
const BEYOND_NOZZLE: f64 = 3.0;
/// From its first moment so near until it does not turn any more, ms.
const SETTLED_MS: u64 = 8_000;
/// Reversals of a motor's voltage on the way.
const TURNS: u32 = 4;
/// A motion of 20° is over in this time, ms.
const PATIENCE_MS: u64 = 20_000;
const POLL_MS: u64 = 100;
/// A motor that is not fed any more runs out in this time, ms, and stays where it is for that one.
const RUN_OUT_MS: u64 = 1_000;
const REST_MS: u64 = 500;
/// Positions differ by no more where nothing moves, ' and mm.
const STILL: f64 = 0.01;
/// A position is rounded to the nearest ' or mm, and its encoder to a count.
const ROUNDED: f64 = 0.65;
/// Where the barrels are sent: far, a little farther, which may lie within the play, and back.
const GOALS: [[i16; 3]; 3] = [[605, -1_195, 40], [612, -1_188, 43], [10, 5, 20]];
const FAULTS: DriveFlags = DriveFlags::INTERNAL_FAULT
    .union(DriveFlags::POS_ENCODER_FAULT)
    .union(DriveFlags::SPEED_ENCODER_FAULT)
    .union(DriveFlags::POSITION_WAY_FAULT)
    .union(DriveFlags::SPEED_WAY_FAULT)
    .union(DriveFlags::MOTOR_BROKEN)
    .union(DriveFlags::AMPERAGE_OVERLOAD);

/// What lies between the voltage of a motor and its barrel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Iron {
    /// Time constant with which the speed follows the voltage, ms.
    pub lag_ms: u32,
    /// Slower than this the motor does not turn, 0.1 °/s or 0.1 mm/s.
    pub sticks_tenths: u32,
    /// Play of the gear, ', of the nozzle 1/12 mm.
    pub play: u32,
    /// The encoder is on the motor, not on the barrel.
    pub on_motor: bool,
}

/// The corners, for each run of the checks.
const CORNERS: [Iron; 6] = [
    Iron { lag_ms: 0, sticks_tenths: 10, play: 0, on_motor: false },
    Iron { lag_ms: 300, sticks_tenths: 0, play: 0, on_motor: false },
    Iron { lag_ms: 0, sticks_tenths: 0, play: 12, on_motor: false },
    Iron { lag_ms: 100, sticks_tenths: 6, play: 4, on_motor: true },
    Iron { lag_ms: 300, sticks_tenths: 10, play: 12, on_motor: true },
    WORST,
];
const WORST: Iron = Iron { lag_ms: 300, sticks_tenths: 10, play: 12, on_motor: false };

impl Iron {
    /// Each combination of lags of 0 to 300 ms, stiction of 0 to 1 °/s, play of 0 to 12′ and the place of the
    /// encoder; without play the place makes no difference. In steps that a run of CI has time for, or in fine ones.
    pub fn grid(is_fine: bool) -> Vec<Self> {
        let (lags, frictions, plays): (Vec<u32>, Vec<u32>, Vec<u32>) = match is_fine {
            true => {
                ((0..=12).map(|n| 25 * n).collect(), (0..=10).collect(), vec![2, 4, 6, 8, 10, 12])
            }
            false => (vec![0, 50, 100, 200, 300], vec![0, 3, 6, 10], vec![4, 12]),
        };
        let mut gears = vec![(0, false)];
        gears.extend(plays.into_iter().flat_map(|play| [(play, false), (play, true)]));
        let mut all = Vec::new();
        for lag_ms in lags {
            for sticks_tenths in &frictions {
                for (play, on_motor) in &gears {
                    let (sticks_tenths, play, on_motor) = (*sticks_tenths, *play, *on_motor);
                    all.push(Self { lag_ms, sticks_tenths, play, on_motor });
                }
            }
        }
        all
    }

    /// The same for the simulator's drive.
    pub fn stage(&self, axis: Axis) -> Stage {
        let sticks = f64::from(self.sticks_tenths) / 10.0 * unit(axis);
        Stage {
            lag_s: f64::from(self.lag_ms) / 1_000.0,
            stiction: sticks,
            dead_band: sticks,
            backlash: self.play(axis),
            sensor_on_motor: self.on_motor,
            ..Stage::default()
        }
    }

    fn play(&self, axis: Axis) -> f64 {
        let play = f64::from(self.play);
        if axis == Axis::Nozzle { play / 12.0 } else { play }
    }
}

/// Position units in a degree, or in a millimetre.
fn unit(axis: Axis) -> f64 {
    if axis == Axis::Nozzle { 1.0 } else { 60.0 }
}

/// The worst of many motions: how far from the target, the play before the encoder left out, and beyond it, by
/// degrees and for the nozzle; how long until they were at rest, and how often a motor was reversed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    /// Motions of one drive.
    pub motions: u32,
    /// ', and mm.
    pub error: [f64; 2],
    /// ', and mm.
    pub beyond: [f64; 2],
    /// ms
    pub settled_ms: u64,
    /// Of a motion.
    pub turns: u32,
}

/// One drive on its way.
struct Track {
    axis: Axis,
    goal: f64,
    from: f64,
    play: f64,
    near_ns: Option<u64>,
    turned_ns: u64,
    fed_ns: u64,
    beyond: f64,
    fed: f64,
    turns: u32,
}

impl Track {
    fn new(rig: &Rig, axis: Axis, goal: i16, iron: &Iron) -> Self {
        Self {
            axis,
            goal: goal.into(),
            from: truth(rig, axis),
            play: if iron.on_motor { iron.play(axis) } else { 0.0 },
            near_ns: None,
            turned_ns: 0,
            fed_ns: 0,
            beyond: 0.0,
            fed: 0.0,
            turns: 0,
        }
    }

    fn allowed(&self) -> f64 {
        self.play + if self.axis == Axis::Nozzle { NEAR_NOZZLE } else { NEAR }
    }

    fn look(&mut self, parts: &Parts) {
        let now_ns = parts.chip.now_ns;
        let drive = &parts.plant.world.drives[self.axis as usize];
        let off = drive.position - self.goal;
        self.beyond = self.beyond.max(off * (self.goal - self.from).signum());
        if off.abs() <= self.allowed() {
            self.near_ns.get_or_insert(now_ns);
        }
        if drive.speed.abs() > drive.spec.unit_per_tenth {
            self.turned_ns = now_ns;
        }
        let fed = parts.plant.voltages(&parts.chip)[self.axis as usize];
        if fed != 0.0 {
            self.turns += u32::from(self.fed * fed < 0.0);
            (self.fed, self.fed_ns) = (fed, now_ns);
        }
    }

    fn judge(&self, rig: &Rig, worst: &mut Worst) -> Result<(), String> {
        let error = (truth(rig, self.axis) - self.goal).abs();
        let near_ns = self.near_ns.unwrap_or(self.turned_ns);
        let settled_ms = self.turned_ns.saturating_sub(near_ns) / MS_NS;
        let farthest = if self.axis == Axis::Nozzle { BEYOND_NOZZLE } else { BEYOND };
        let place = usize::from(self.axis == Axis::Nozzle);
        let about = format!(
            "{:?} from {:.1} to {}: {error:.2} off, {:.1} beyond, settled in {settled_ms} ms, {} reversals",
            self.axis, self.from, self.goal, self.beyond, self.turns
        );
        worst.motions += 1;
        worst.error[place] = worst.error[place].max(error - self.play);
        worst.beyond[place] = worst.beyond[place].max(self.beyond - self.play);
        worst.settled_ms = worst.settled_ms.max(settled_ms);
        worst.turns = worst.turns.max(self.turns);
        ensure(error <= self.allowed(), format!("rests too far off: {about}"))?;
        ensure(self.beyond <= farthest + self.play, format!("goes too far: {about}"))?;
        ensure(settled_ms <= SETTLED_MS, format!("settles too late: {about}"))?;
        ensure(self.turns <= TURNS, format!("chatters: {about}"))
    }
}

/// Lets time pass and looks at each ms of it.
fn watch(rig: &mut Rig, ms: u64, tracks: &mut [Track]) {
    for _ in 0..ms {
        rig.run(1);
        rig.parts(|parts| tracks.iter_mut().for_each(|track| track.look(parts)));
    }
}

/// Whether a drive says that it moves.
fn moves(frame: &[u8]) -> bool {
    Records::new(frame).flatten().any(|record| {
        let bits = record.data.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        DriveFlags::from_bits_retain(bits).contains(DriveFlags::MOVE)
    })
}

fn put(rig: &mut Rig, axis: Axis, name: &str, value: u32) -> Result<(), String> {
    let (id, values) = (ParamId::of(name), [value.cast_signed()]);
    rig.order(axis.id(), Body::SetParam { id, values: Ints::Values(&values) })
}

/// Puts this between all motors and their barrels, and measures the drives: StopLag and MinSpeed are what they are.
fn fit(rig: &mut Rig, iron: &Iron) -> Result<(), String> {
    for axis in Axis::ALL {
        let full = rig.parts(|parts| {
            let spec = &mut parts.plant.world.drives[axis as usize].spec;
            spec.stage = iron.stage(axis);
            spec.max_speed / spec.unit_per_tenth
        });
        // What the power stage makes of the shortest pulse, too.
        let least = ((full * LEAST_DUTY).ceil() as u32).max(iron.sticks_tenths);
        put(rig, axis, "StopLag", iron.lag_ms)?;
        put(rig, axis, "MinSpeed", least)?;
    }
    rig.run(REST_MS);
    Ok(())
}

/// Sends all three to their goals, and waits for them.
fn send(rig: &mut Rig, iron: &Iron, goals: [i16; 3], worst: &mut Worst) -> Result<(), String> {
    let stowed = truth(rig, Axis::Deployer);
    let mut tracks = Vec::new();
    for (axis, goal) in AIMING.into_iter().zip(goals) {
        tracks.push(Track::new(rig, axis, goal, iron));
        rig.order(axis.id(), Body::Move { destination: goal })?;
    }
    let poll = request(SubsystemId::MOTORS, Body::GetStatus)?;
    let ended = (0..PATIENCE_MS / POLL_MS).any(|_| {
        rig.frames();
        rig.send(&poll);
        watch(rig, POLL_MS, &mut tracks);
        let frames = rig.frames();
        !frames.is_empty() && !frames.iter().any(|frame| moves(frame))
    });
    ensure(ended, format!("the motion to {goals:?} does not end"))?;
    let ended_ns = rig.now_ns();
    watch(rig, RUN_OUT_MS, &mut tracks);
    let rest = AIMING.map(|axis| truth(rig, axis));
    watch(rig, REST_MS, &mut tracks);
    for (track, rest) in tracks.iter().zip(rest) {
        let axis = track.axis;
        ensure(track.fed_ns <= ended_ns, format!("{axis:?} is fed behind its motion"))?;
        near(&format!("{axis:?}, at rest"), truth(rig, axis), rest, STILL)?;
        let sensed = rig.parts(|parts| parts.plant.sensed()[axis as usize]);
        near(&format!("{axis:?}, as measured"), position_of(rig, axis), sensed, ROUNDED)?;
        track.judge(rig, worst)?;
        let found = drive_flags(rig, axis)?;
        ensure(!found.intersects(FAULTS), format!("{axis:?} to {}: {found:?}", track.goal))?;
    }
    near("Deployer, unasked", truth(rig, Axis::Deployer), stowed, STILL)
}

/// Sends the barrels to and fro with each of these between them and their motors.
pub fn aimed(wrong: Wrong, irons: &[Iron], worst: &mut Worst) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    let at_rest = rig.save();
    for iron in irons {
        rig.restore(&at_rest);
        fit(&mut rig, iron)?;
        for goals in GOALS {
            send(&mut rig, iron, goals, worst).map_err(|why| format!("{iron:?}: {why}"))?;
        }
        sound(&rig)?;
    }
    Ok(())
}

/// Barrels come to rest where they are sent, and end where they are stopped.
pub(super) fn check(wrong: Wrong) -> Result<(), String> {
    aimed(wrong, &CORNERS, &mut Worst::default())?;
    stopped(wrong)
}

/// A motor that runs out for long is fed by nothing after a Stop, a Restart or a power cut; its position is
/// right, or is lost and said to be.
fn stopped(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    fit(&mut rig, &WORST)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 6_000 })?;
    rig.run(1_500);
    ensure(is_live(&rig), "nothing moves that could be stopped")?;
    let moving = rig.save();
    for end in ["Stop", "Restart", "power cut"] {
        rig.restore(&moving);
        match end {
            "Stop" => rig.order(SubsystemId::ALL, Body::Stop)?,
            "Restart" => rig.order(SubsystemId::ALL, Body::Restart)?,
            _ => rig.cut_power(),
        }
        let mut track = [Track::new(&rig, Axis::Horizontal, 6_000, &WORST)];
        rig.run(20);
        watch(&mut rig, 3 * RUN_OUT_MS, &mut track);
        ensure(track[0].fed_ns == 0, format!("a motor is fed behind {end}"))?;
        let found = drive_flags(&mut rig, Axis::Horizontal)?;
        let off = (position_of(&rig, Axis::Horizontal) - truth(&rig, Axis::Horizontal)).abs();
        let known = !found.contains(DriveFlags::POS_ENCODER_FAULT);
        ensure(!known || off <= 6.0, format!("{end}: {off:.1}' off, and says {found:?}"))?;
        ensure(end != "Stop" || !found.intersects(FAULTS), format!("stopped, and says {found:?}"))?;
        ensure(end != "power cut" || !known, "power was cut in motion, and all is well")?;
    }
    Ok(())
}

/// What is read back of every output is judged as without lag, stiction and play: each motor's voltage, each relay
/// and each heater.
pub(super) fn outputs(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    fit(&mut rig, &WORST)?;
    let at_rest = rig.save();
    for axis in Axis::ALL {
        rig.restore(&at_rest);
        shorted(&mut rig, axis)?;
    }
    for axis in AIMING {
        rig.restore(&at_rest);
        dead(&mut rig, axis)?;
    }
    rig.restore(&at_rest);
    heated(&mut rig)?;
    rig.restore(&at_rest);
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 6_000 })?;
    rig.run(500);
    let moving = rig.save();
    for relay in RELAYS.into_iter().flatten() {
        rig.restore(&moving);
        ensure(is_live(&rig), "nothing moves")?;
        rig.parts(|parts| parts.plant.welded.insert(relay));
        rig.run(300);
        let on = rig.parts(|parts| parts.plant.relays(&parts.chip));
        ensure(on == [[false; 2]; 2], format!("the welded relay {relay:?} keeps its power"))?;
        let found = ValveFlags::from_bits_retain(flags(&mut rig, SubsystemId::VALVE1)?);
        ensure(found.contains(ValveFlags::BLOCKED), format!("{relay:?} welded: {found:?}"))?;
    }
    Ok(())
}

/// A shorted stage is cut off before its barrel has gone far.
fn shorted(rig: &mut Rig, axis: Axis) -> Result<(), String> {
    let from = truth(rig, axis);
    rig.parts(|parts| parts.plant.shorted[axis as usize] = true);
    rig.run(200);
    ensure(!is_live(rig), format!("the shorted stage of {axis:?} goes on driving"))?;
    rig.run(2 * RUN_OUT_MS);
    ensure(!is_live(rig), format!("the shorted stage of {axis:?} drives again"))?;
    near(&format!("{axis:?}, shorted"), truth(rig, axis), from, 10.0 * unit(axis))?;
    let found = drive_flags(rig, axis)?;
    let reported = found.contains(DriveFlags::MOTOR_BROKEN);
    ensure(reported, format!("{axis:?} is shorted, and says {found:?}"))
}

/// A motor without voltage is given up and reported; with it, it goes on by a Move alone.
fn dead(rig: &mut Rig, axis: Axis) -> Result<(), String> {
    let destination = match axis {
        Axis::Nozzle if truth(rig, axis) > 30.0 => 5,
        Axis::Nozzle => 55,
        _ => 1_500,
    };
    rig.parts(|parts| parts.plant.broken.insert(MOTOR_LIVE[axis as usize]));
    rig.order(axis.id(), Body::Move { destination })?;
    rig.run(1_000);
    ensure(!is_live(rig), format!("{axis:?} is fed on without voltage"))?;
    let found = drive_flags(rig, axis)?;
    let reported = found.contains(DriveFlags::MOTOR_BROKEN);
    ensure(reported, format!("{axis:?} has no voltage, and says {found:?}"))?;
    rig.parts(|parts| parts.plant.broken.clear());
    rig.run(4_000);
    ensure(!is_live(rig), format!("{axis:?} goes on by itself"))?;
    rig.order(axis.id(), Body::Move { destination })?;
    let off = if axis == Axis::Nozzle { NEAR_NOZZLE } else { NEAR };
    let there = rig.run_until(PATIENCE_MS, |rig| {
        let speed = rig.parts(|parts| parts.plant.world.drives[axis as usize].speed);
        speed == 0.0 && (truth(rig, axis) - f64::from(destination)).abs() <= off
    });
    ensure(there, format!("{axis:?} is at {:.1}, not {destination}", truth(rig, axis)))
}

/// All heaters are on and none is faulty; each without current is reported, and no other.
fn heated(rig: &mut Rig) -> Result<(), String> {
    rig.parts(|parts| parts.plant.world.climate.places_c = [-30.0; 5]);
    rig.run(500);
    let on = rig.parts(|parts| parts.plant.heaters(&parts.chip));
    ensure(on == [true; 5], format!("in the cold heaters are {on:?}"))?;
    let faults = inputs(rig).places.map(|place| place.heater_fault);
    ensure(faults == [false; 5], format!("sound heaters reported as faulty: {faults:?}"))?;
    let cold = rig.save();
    for heater in 0..5 {
        rig.restore(&cold);
        rig.parts(|parts| parts.plant.cold[heater] = true);
        let mut reported = [false; 5];
        for _ in 0..4_000 {
            rig.round();
            for (seen, place) in reported.iter_mut().zip(&rig.device.inputs().places) {
                *seen |= place.heater_fault;
            }
        }
        let alone = [0, 1, 2, 3, 4].map(|it| it == heater);
        ensure(reported == alone, format!("heater {heater} is dead: {reported:?}"))?;
    }
    Ok(())
}
