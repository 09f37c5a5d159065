//! The drives: elevation, traverse, nozzle, deployment.
//!
//! State: position x (arc-minutes or mm), speed v (units/s), motor current I (A). Per step dt:
//! - the power stage runs the speed loop: v moves towards the commanded speed, at most `accel`
//!   when it grows and `brake` when it falls (worm gears stop at once and hold without current);
//!   a [`Stage`] that is not ideal follows with a lag, and not at all below its dead band; one that only
//!   gives a voltage loses speed to its load;
//! - the motor moves by v·dt, the barrel with it as far as the play of the gear leaves it; x is cut
//!   at the mechanical stops, where v = 0;
//! - motoring current I∞ = (friction + 1.0·|v|/v_max + 1.5·|dv/dt|/accel + weight + thrust) A, with
//!   weight = 1.0·cos(elevation) A when lifting and thrust = 0.5·Q/20 l/s A; at a stop or jammed
//!   the stall current of 15 A; I follows with a time constant of 40 ms.
//!
//! The figures are ours, plausible for a monitor of 20 l/s on 24 V, not measured on one. Valid
//! for worm-geared drives; elasticity is left out.

use lafet_device::image::{Axis, DriveInput, DriveOutput};

use crate::fault::{DriveFault, Faults};

/// Current against a stop or a jam, A.
pub const STALL_A: f64 = 15.0;

const CURRENT_LAG_S: f64 = 0.04;
/// A stage that droops loses this part of 1 °/s or 1 mm/s to each A.
const DROOP: f64 = 0.4;
/// The jet's reaction loads a drive with so much at this flow.
const REACTION_A: f64 = 0.5;
const REACTION_LPS: f64 = 20.0;

/// What lies between the commanded speed and the barrel. The default is ideal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stage {
    /// Time constant with which the speed follows its command, s; 0: `accel` and `brake` alone.
    pub lag_s: f64,
    /// A motor at rest does not start below this speed, units/s …
    pub stiction: f64,
    /// … and a turning one stops below this one, units/s.
    pub dead_band: f64,
    /// Speed lost to each A of load, units/s: a stage that gives a voltage and holds no speed. Friction
    /// slows a motion whichever way it goes; weight and the jet's reaction, which pull a barrel down,
    /// slow its rise and speed up its fall.
    pub droop: f64,
    /// Play between motor and barrel, position units.
    pub backlash: f64,
    /// The position sensor sits on the motor, not on the barrel.
    pub sensor_on_motor: bool,
}

/// Geometry and strength of a drive; positions in arc-minutes or mm.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSpec {
    /// Position units per 0.1 °/s or 0.1 mm/s and second: 6 or 0.1.
    pub unit_per_tenth: f64,
    /// Mechanical stops.
    pub stops: (f64, f64),
    /// The end switches close at or beyond these positions.
    pub switches: (f64, f64),
    /// Fastest speed of the motor, units/s.
    pub max_speed: f64,
    /// Speeding up, units/s².
    pub accel: f64,
    /// Slowing down, units/s².
    pub brake: f64,
    /// Friction current, A.
    pub friction_a: f64,
    /// Current for lifting at the horizontal, A.
    pub weight_a: f64,
    /// Position that the encoder calls 0.
    pub encoder_zero: f64,
    /// The encoder counts from where the program has started: [`Drive::start_encoder`].
    pub relative: bool,
    /// Power stage and gear.
    pub stage: Stage,
}

impl DriveSpec {
    /// The drive of an axis of the nominal monitor: elevation −15…75°, traverse ±180°, nozzle
    /// 0–60 mm, deployment 0–90°. The switches stand a quarter of a degree (1/2 mm) beyond the
    /// working range, except the deployer's, which close in the last sixth of a degree of it.
    pub fn nominal(axis: Axis) -> Self {
        let angle = Self {
            unit_per_tenth: 6.0,
            stops: (-930.0, 4530.0),
            switches: (-915.0, 4515.0),
            max_speed: 25.0 * 60.0,
            accel: 40.0 * 60.0,
            brake: 200.0 * 60.0,
            friction_a: 1.0,
            weight_a: 0.0,
            encoder_zero: 0.0,
            stage: Stage::default(),
            relative: false,
        };
        match axis {
            Axis::Vertical => Self { weight_a: 1.0, ..angle },
            Axis::Horizontal => {
                Self { stops: (-10_830.0, 10_830.0), switches: (-10_815.0, 10_815.0), ..angle }
            }
            Axis::Nozzle => Self {
                unit_per_tenth: 0.1,
                stops: (-1.0, 61.0),
                switches: (-0.5, 60.5),
                max_speed: 15.0,
                accel: 40.0,
                brake: 200.0,
                friction_a: 0.8,
                ..angle
            },
            Axis::Deployer => {
                Self { stops: (-20.0, 5_420.0), switches: (10.0, 5_390.0), weight_a: 1.0, ..angle }
            }
        }
    }
}

/// Currents below this are none, A.
pub(crate) const LEAST_A: f64 = 1e-3;

/// A drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Which one.
    pub axis: Axis,
    /// Its geometry and strength.
    pub spec: DriveSpec,
    /// True position, arc-minutes or mm.
    pub position: f64,
    /// True speed, units/s.
    pub speed: f64,
    /// Motor current, A.
    pub current_a: f64,
    /// Position of the motor, which differs by the play of the gear.
    motor: f64,
    frozen: Option<f64>,
    /// Where the position has started to count too much.
    fast_from: Option<f64>,
}

/// What loads a drive besides its own friction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// Cosine of the elevation: the weight of the barrel.
    pub cos_elevation: f64,
    /// Flow through the nozzle, l/s: the thrust of the jet.
    pub flow_lps: f64,
}

impl Drive {
    /// A drive at rest.
    pub fn new(axis: Axis, spec: DriveSpec, position: f64) -> Self {
        Self {
            axis,
            spec,
            position,
            speed: 0.0,
            current_a: 0.0,
            motor: position,
            frozen: None,
            fast_from: None,
        }
    }

    /// Runs for `dt_s` as it is commanded.
    pub fn step(&mut self, command: DriveOutput, load: Load, dt_s: f64, faults: &Faults) {
        let spec = &self.spec;
        let wanted = match faults.drive(self.axis, DriveFault::Runaway) {
            // Up or left; the nozzle, which is narrow at first, wider.
            true if self.axis == Axis::Nozzle => -spec.max_speed,
            true => spec.max_speed,
            false => f64::from(command.speed_tenths) * spec.unit_per_tenth,
        };
        let mut target = wanted.clamp(-spec.max_speed, spec.max_speed);
        let open = command.cut
            || faults.drive(self.axis, DriveFault::MotorOpen)
            || faults.drive(self.axis, DriveFault::PowerStage);
        let jam = faults.drive(self.axis, DriveFault::Jam);
        if open {
            target = 0.0;
        }
        let before = self.speed;
        let stage = self.stage(faults);
        target = self.droop(&stage, target, load);
        self.speed = if jam { 0.0 } else { stage.follow(before, target, spec, dt_s) };
        let half = stage.backlash / 2.0;
        // Where the barrel was put elsewhere, the motor was turned too.
        self.motor = self.motor.clamp(self.position - half, self.position + half);
        self.motor += self.speed * dt_s;
        self.position = self.position.clamp(self.motor - half, self.motor + half);
        let (low, high) = spec.stops;
        let stopped =
            (self.position <= low && target < 0.0) || (self.position >= high && target > 0.0);
        if self.position <= low || self.position >= high {
            self.position = self.position.clamp(low, high);
            if stopped {
                self.speed = 0.0;
            }
        }
        let aim = if target == 0.0 {
            0.0
        } else if jam || stopped {
            STALL_A
        } else {
            self.motoring_a(before, load, dt_s, faults)
        };
        self.current_a += (aim - self.current_a) * (dt_s / CURRENT_LAG_S).min(1.0);
        if aim == 0.0 && self.current_a < LEAST_A {
            self.current_a = 0.0;
        }
        self.frozen = match self.frozen {
            _ if !faults.drive(self.axis, DriveFault::EncoderDead) => None,
            None => Some(self.position),
            held => held,
        };
        let fast = faults.drive(self.axis, DriveFault::EncoderFast);
        self.fast_from = fast.then_some(self.fast_from.unwrap_or(self.position));
    }

    /// The speed that is left of a wanted one under load. A gear that locks itself is never driven back.
    fn droop(&self, stage: &Stage, wanted: f64, load: Load) -> f64 {
        let reaction_a = REACTION_A * load.flow_lps / REACTION_LPS;
        let (friction_a, down_a) = match self.axis {
            Axis::Vertical => {
                (self.spec.friction_a, self.spec.weight_a * load.cos_elevation + reaction_a)
            }
            _ => (self.spec.friction_a + reaction_a, 0.0),
        };
        let against_a = friction_a + down_a * wanted.signum();
        wanted.signum() * (wanted.abs() - stage.droop * against_a).max(0.0)
    }

    /// The program starts: an encoder that does not know where it is calls that 0.
    pub fn start_encoder(&mut self) {
        if self.spec.relative {
            self.spec.encoder_zero = libm::round(self.position);
        }
    }

    /// The power stage and the gear as they are now.
    fn stage(&self, faults: &Faults) -> Stage {
        let has = |fault| faults.drive(self.axis, fault);
        let mut stage = self.spec.stage;
        let (slow, play) = if self.axis == Axis::Nozzle { (1.0, 1.0) } else { (60.0, 12.0) };
        if has(DriveFault::Lag) {
            stage.lag_s = 0.3;
        }
        if has(DriveFault::DeadBand) {
            (stage.stiction, stage.dead_band) = (slow, slow);
        }
        if has(DriveFault::Droop) {
            stage.droop = DROOP * slow;
        }
        if has(DriveFault::Backlash) {
            stage.backlash = play;
        }
        stage
    }

    fn motoring_a(&self, before: f64, load: Load, dt_s: f64, faults: &Faults) -> f64 {
        let spec = &self.spec;
        let friction = match () {
            () if faults.drive(self.axis, DriveFault::Friction) => 12.0,
            () if faults.drive(self.axis, DriveFault::Flicker) => 12.0,
            () if faults.drive(self.axis, DriveFault::Stiff) => 5.5,
            () => spec.friction_a,
        };
        let rise = (self.speed.abs() - before.abs()).max(0.0) / dt_s / spec.accel;
        let lifting = if self.speed > 0.0 { spec.weight_a * load.cos_elevation } else { 0.0 };
        friction
            + self.speed.abs() / spec.max_speed
            + 1.5 * rise.min(1.0)
            + lifting
            + REACTION_A * load.flow_lps / REACTION_LPS
    }

    /// What its sensors say.
    pub fn sense(&self, faults: &Faults) -> DriveInput {
        let has = |fault| faults.drive(self.axis, fault);
        let spec = &self.spec;
        let sensed = if spec.stage.sensor_on_motor { self.motor } else { self.position };
        let mut position = self.frozen.unwrap_or(sensed);
        if let Some(from) = self.fast_from {
            position = from + 4.0 * (position - from);
        }
        if has(DriveFault::EncoderJump) {
            position += if self.axis == Axis::Nozzle { -15.0 } else { 1200.0 };
        }
        position -= spec.encoder_zero;
        if has(DriveFault::EncoderReversed) {
            position = -position;
        }
        let mut speed = self.speed / spec.unit_per_tenth;
        if has(DriveFault::SpeedReversed) {
            speed = -speed;
        }
        if has(DriveFault::SpeedDead) {
            speed = 0.0;
        }
        let mut input = DriveInput::default();
        input.position = libm::round(position) as i32;
        input.speed_tenths = libm::round(speed) as i16;
        input.current_da = libm::round(self.current_a * 10.0) as u16;
        input.min_switch = self.position <= spec.switches.0 || has(DriveFault::MinSwitch);
        input.max_switch = self.position >= spec.switches.1 || has(DriveFault::MaxSwitch);
        input.motor_open = has(DriveFault::MotorOpen);
        input.position_sensor_fault = has(DriveFault::EncoderFault);
        input.speed_sensor_fault = has(DriveFault::SpeedFault);
        input
    }
}

impl Stage {
    /// The speed after `dt_s`, units/s.
    fn follow(&self, speed: f64, target: f64, spec: &DriveSpec, dt_s: f64) -> f64 {
        let least = if speed == 0.0 { self.stiction.max(self.dead_band) } else { self.dead_band };
        let target = if target.abs() < least { 0.0 } else { target };
        if self.lag_s <= 0.0 {
            return approach(speed, target, spec, dt_s);
        }
        let speed = target + (speed - target) * libm::exp(-dt_s / self.lag_s);
        // Friction ends what is left of a motion.
        if target == 0.0 && speed.abs() < spec.max_speed / 1000.0 { 0.0 } else { speed }
    }
}

fn approach(speed: f64, target: f64, spec: &DriveSpec, dt_s: f64) -> f64 {
    let growing = target.abs() > speed.abs() && target * speed >= 0.0;
    let limit = if growing { spec.accel } else { spec.brake } * dt_s;
    // Braking ends at standstill: reversing first stops, then speeds up.
    let target = if target * speed < 0.0 { 0.0 } else { target };
    speed + (target - speed).clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    const DT: f64 = 0.01;

    fn drive(axis: Axis, position: f64) -> Drive {
        Drive::new(axis, DriveSpec::nominal(axis), position)
    }

    fn run(drive: &mut Drive, command: i16, steps: u32, faults: &Faults) {
        let load = Load { cos_elevation: 1.0, flow_lps: 0.0 };
        for _ in 0..steps {
            let command = DriveOutput { speed_tenths: command, cut: false };
            drive.step(command, load, DT, faults);
        }
    }

    /// 10 °/s is reached in 1/4 s at 40 °/s²; from there braking takes 1/4 degree.
    #[test]
    fn speed_ramp_and_braking() {
        let mut drive = drive(Axis::Horizontal, 0.0);
        run(&mut drive, 100, 25, &Faults::default());
        assert_eq!(drive.sense(&Faults::default()).speed_tenths, 100);
        let at = drive.position;
        run(&mut drive, 0, 50, &Faults::default());
        let braking = drive.position - at;
        assert!((10.0..=16.0).contains(&braking), "{braking}'");
        assert_eq!(drive.sense(&Faults::default()).current_da, 0);
    }

    #[test]
    fn running_current_and_stall() {
        let faults = Faults::default();
        let mut up = drive(Axis::Vertical, 0.0);
        run(&mut up, 50, 100, &faults);
        let current = up.sense(&faults).current_da;
        assert!((20..30).contains(&current), "{current}");
        run(&mut up, 100, 1000, &faults);
        assert_eq!((up.position, up.sense(&faults).current_da), (4530.0, 150));
        assert!(up.sense(&faults).max_switch);
        run(&mut up, -100, 20, &faults);
        assert!(!up.sense(&faults).max_switch || up.position < 4530.0);
    }

    #[test]
    fn faults_show_and_clear() {
        let mut faults = Faults::default();
        let mut drive = drive(Axis::Nozzle, 30.0);
        faults.inject(Fault::Drive(Axis::Nozzle, DriveFault::Jam));
        run(&mut drive, 50, 100, &faults);
        assert_eq!((drive.position, drive.sense(&faults).current_da), (30.0, 150));
        faults.clear_all();
        faults.inject(Fault::Drive(Axis::Nozzle, DriveFault::EncoderDead));
        run(&mut drive, 50, 100, &faults);
        assert_eq!(drive.sense(&faults).position, 30);
        assert!(drive.position > 33.0 && drive.sense(&faults).speed_tenths == 50);
        faults.clear_all();
        faults.inject(Fault::Drive(Axis::Nozzle, DriveFault::MotorOpen));
        run(&mut drive, 50, 100, &faults);
        assert!(drive.speed == 0.0 && drive.sense(&faults).motor_open);
        faults.clear_all();
        faults.inject(Fault::Drive(Axis::Nozzle, DriveFault::Friction));
        run(&mut drive, 20, 50, &faults);
        assert!(drive.speed > 0.0 && drive.sense(&faults).current_da > 110);
    }

    /// A stage that gives a voltage: slower under load, uphill more than downhill, never driven back.
    #[test]
    fn droops_under_load() {
        let mut faults = Faults::default();
        faults.inject(Fault::Drive(Axis::Vertical, DriveFault::Droop));
        let speed = |tenths: i16, flow_lps: f64| {
            let mut drive = drive(Axis::Vertical, 0.0);
            let load = Load { cos_elevation: 1.0, flow_lps };
            let command = DriveOutput { speed_tenths: tenths, cut: false };
            (0..100).for_each(|_| drive.step(command, load, DT, &faults));
            drive.speed / 6.0
        };
        // 0.4 °/s for each A: 1 A of friction, 1 A of weight, 0.5 A of the jet.
        for (tenths, flow_lps, left) in
            [(50, 0.0, 42.0), (50, 20.0, 40.0), (-50, 0.0, -50.0), (-50, 20.0, -52.0)]
        {
            let found = speed(tenths, flow_lps);
            assert!((found - left).abs() < 0.01, "{tenths} at {flow_lps}: {found}");
        }
        assert_eq!((speed(8, 0.0), speed(0, 20.0)), (0.0, 0.0));
    }

    #[test]
    fn deployer_ends_switch_inside_the_stops() {
        let faults = Faults::default();
        let mut drive = drive(Axis::Deployer, 0.0);
        assert!(drive.sense(&faults).min_switch);
        run(&mut drive, 100, 880, &faults);
        let ends = drive.sense(&faults);
        assert!(!ends.min_switch && !ends.max_switch, "{}", drive.position);
        run(&mut drive, 100, 40, &faults);
        assert!(drive.sense(&faults).max_switch);
    }
}
