//! What an owner does.

use lafet_device::image::Axis;
use lafet_proto::answer::Reply;
use lafet_proto::flags::DetectorFlags;
use lafet_proto::status::Hotbed;
use lafet_proto::text;
use lafet_proto::{Status, SubsystemId};
use lafet_sim::fault::{DriveFault, Fault, SingleFault, ValveFault};
use lafet_sim::fire::FireSpec;

use super::Years;
use lafet_device::image::ValveNo;

/// Where a barrel comes to rest and a nozzle is after its tests, ' or mm.
const HOME: [(Axis, i32); 3] = [(Axis::Vertical, 0), (Axis::Horizontal, 0), (Axis::Nozzle, 60)];
/// Limits of the drives as the factory sets them, ' or mm.
const LIMITS: [(Axis, i32, i32); 3] =
    [(Axis::Vertical, -900, 4_500), (Axis::Horizontal, -10_800, 10_800), (Axis::Nozzle, 0, 60)];
const TICK_MS: u64 = 10;

/// Faults that come and go; what they leave behind must go with them.
const FAULTS: [Fault; 10] = [
    Fault::Drive(Axis::Vertical, DriveFault::Jam),
    Fault::Drive(Axis::Horizontal, DriveFault::MotorOpen),
    Fault::Drive(Axis::Nozzle, DriveFault::EncoderFault),
    Fault::Drive(Axis::Horizontal, DriveFault::SpeedFault),
    Fault::Valve(ValveNo::Valve1, ValveFault::CloseSwitch),
    Fault::Valve(ValveNo::Valve2, ValveFault::Blocked),
    Fault::Single(SingleFault::PressureBreak),
    Fault::Single(SingleFault::VoltageLow),
    Fault::Single(SingleFault::Humidity),
    Fault::Single(SingleFault::DetectorDead),
];

impl Years {
    /// Says a request; the answer must be this.
    pub(super) fn say(&mut self, request: &str, expected: &[Status]) -> Result<(), String> {
        let mut buffer = [0; text::BUFFER_SIZE];
        let parsed = text::parse(request, &mut buffer).map_err(|error| error.to_string())?;
        let mut answered = None;
        self.sim.ask(parsed.to, parsed.body, |answer| answered = Some(answer.status));
        match answered {
            Some(status) if expected.contains(&status) => Ok(()),
            other => Err(format!("{request}: {other:?}, not {expected:?}")),
        }
    }

    pub(super) fn accepted(&mut self, request: &str) -> Result<(), String> {
        self.say(request, &[Status::OK, Status::ACCEPTED])
    }

    /// Steps until it holds, and counts water and way.
    pub(super) fn until(
        &mut self,
        what: &str,
        within_s: u64,
        mut holds: impl FnMut(&mut Self) -> bool,
    ) -> Result<u64, String> {
        for tick in 0..within_s * 1_000 / TICK_MS {
            if holds(self) {
                return Ok(tick * TICK_MS);
            }
            let before = self.sim.world().drives.each_ref().map(|drive| drive.position);
            self.sim.tick();
            let world = self.sim.world();
            self.report.water_m3 += world.water.jet_lps() * TICK_MS as f64 / 1e6;
            for (index, way) in self.report.ways.iter_mut().enumerate() {
                let per_unit = if index == Axis::Nozzle as usize { 1.0 } else { 60.0 };
                *way += (world.drives[index].position - before[index]).abs() / per_unit;
            }
            self.never()?;
        }
        Err(format!("{what}: not within {within_s} s"))
    }

    fn wait(&mut self, seconds: u64) -> Result<(), String> {
        let end_ms = self.sim.now_ms() + seconds * 1_000;
        self.until("time", seconds + 1, |years| years.sim.now_ms() >= end_ms).map(|_| ())
    }

    fn goes(&mut self, axis: Axis, target: i32) -> Result<(), String> {
        self.accepted(&format!("Move {} {target}", axis.id()))?;
        self.until(&format!("{axis:?} to {target}"), 60, |years| years.has_stopped(axis))?;
        self.stands_at(axis, target)
    }

    fn deploys(&mut self) -> Result<(), String> {
        self.accepted("Deploy")?;
        self.until("deployed", 30, |years| years.sim.device().inputs().drives[3].max_switch)?;
        self.wait(1)
    }

    fn wraps_up(&mut self) -> Result<(), String> {
        self.accepted("Wrap")?;
        self.until("wrapped", 90, |years| years.sim.device().inputs().drives[3].min_switch)?;
        self.wait(1)
    }

    fn closes(&mut self) -> Result<(), String> {
        self.accepted("Close Valve1")?;
        self.until("closed", 15, |years| years.sim.device().inputs().valves[0].close_switch)?;
        self.wait(1)
    }

    /// Deploy, both limits of every drive, a little water, home, wrap.
    pub(super) fn weekly_test(&mut self) -> Result<(), String> {
        self.deploys()?;
        for (axis, min, max) in LIMITS {
            self.goes(axis, min)?;
            self.goes(axis, max)?;
        }
        for (axis, home) in HOME {
            self.goes(axis, home)?;
        }
        self.accepted("Open Valve1")?;
        self.wait(15)?;
        let flow_lps = self.sim.world().water.jet_lps();
        if flow_lps < 15.0 {
            return Err(format!("water: {flow_lps} l/s"));
        }
        self.closes()?;
        self.wraps_up()?;
        self.report.tests += 1;
        self.is_clean("after the test")
    }

    /// A fault comes, what it concerns is tried, it is repaired and tried again.
    pub(super) fn trouble(&mut self) -> Result<(), String> {
        let fault = FAULTS[self.rng.bits() as usize % FAULTS.len()];
        self.sim.world_mut().inject(fault);
        self.wait(2)?;
        self.report.faults += 1;
        self.report.faults_told += u64::from(self.is_clean("").is_err());
        // Whatever is answered: a drive may be faulty, a valve blocked.
        for request in ["Deploy", "Open Valve2"] {
            let any: Vec<Status> = (0..=Status::NOT_SUPPORTED.0).map(Status).collect();
            self.say(request, &any)?;
            self.wait(12)?;
        }
        self.accepted("Stop All")?;
        self.wait(4)?;
        self.sim.world_mut().clear(fault);
        self.wait(1)?;
        for valve in ["Close Valve1", "Close Valve2"] {
            self.accepted(valve)?;
        }
        self.wait(8)?;
        self.deploys()?;
        for (axis, home) in HOME {
            self.goes(axis, home)?;
        }
        self.wraps_up()?;
        self.is_clean(&format!("after {fault:?}"))
    }

    /// A parameter changes and is changed back; both outlive a reset.
    pub(super) fn parameters(&mut self) -> Result<(), String> {
        for value in [8, 10] {
            self.accepted(&format!("SetParam Vertical Speed {value}"))?;
            self.wait(1)?;
            self.restart()?;
            let kept = self
                .sim
                .device()
                .params()
                .drive(Axis::Vertical, lafet_proto::param::DriveParam::Speed);
            if kept != value {
                return Err(format!("Speed is {kept}, {value} was accepted"));
            }
            self.report.parameters += 1;
        }
        Ok(())
    }

    /// The program starts again, or the supply fails.
    pub(super) fn restart(&mut self) -> Result<(), String> {
        if self.rng.chance(0.5) {
            let resets = self.sim.resets();
            self.accepted("Restart")?;
            self.until("the reset", 1, |years| years.sim.resets() > resets)?;
            self.report.restarts += 1;
        } else {
            self.sim.power_cycle();
            self.report.power_cuts += 1;
        }
        self.power_up();
        self.wait(10)
    }

    /// Locked out over everything that resets; released, it works.
    pub(super) fn lockout(&mut self) -> Result<(), String> {
        self.accepted("Lockout on")?;
        self.sim.tick();
        self.locked = true;
        self.wait(10)?;
        for _ in 0..2 {
            self.sim.power_cycle();
            self.power_up();
            self.report.power_cuts += 1;
            self.wait(10)?;
            self.say("Deploy", &[Status::DENIED])?;
        }
        self.locked = false;
        self.accepted("Lockout off")?;
        self.report.lockouts += 1;
        self.wait(10)?;
        self.is_clean("after the lockout")
    }

    /// A fire in the night: searched for, found, put out.
    pub(super) fn fire(&mut self) -> Result<(), String> {
        let azimuth_deg = self.rng.unit() * 80.0 - 40.0;
        let range_m = 22.0 + self.rng.unit() * 10.0;
        let fire = FireSpec { azimuth_deg, range_m, size_m: 1.2, ..FireSpec::default() };
        self.sim.world_mut().light(fire);
        let start_ms = self.sim.now_ms();
        self.accepted("StartSeek -3000 3000 -300 300 analyse")?;
        let found = |years: &mut Self| !years.detector().contains(DetectorFlags::SEARCHING);
        self.until("the search", 600, found)?;
        let Some(hotbed) = self.hotbed() else { return Err("no fire found".into()) };
        let (h, v) = (i32::midpoint(hotbed.x1, hotbed.x2), i32::midpoint(hotbed.y1, hotbed.y2));
        let sector = "nozzle=60 sector=120,60 step=1";
        let distance = libm::round(range_m);
        self.accepted(&format!("StartQuench centre={h},{v} {sector} distance={distance}"))?;
        self.wait(10)?;
        self.accepted("Open Valve1")?;
        self.until("the fire is out", 900, |years| {
            years.sim.world().fires.iter().all(|fire| !fire.burns())
        })?;
        self.report.fire_s_max = self.report.fire_s_max.max((self.sim.now_ms() - start_ms) / 1_000);
        self.accepted("Stop Control")?;
        self.closes()?;
        self.wait(20)?;
        self.wraps_up()?;
        self.sim.world_mut().sweep();
        self.report.fires += 1;
        Ok(())
    }

    fn hotbed(&mut self) -> Option<Hotbed> {
        let mut found = None;
        let mut buffer = [0; text::BUFFER_SIZE];
        let request = text::parse("GetHotbed", &mut buffer).ok()?;
        self.sim.ask(SubsystemId::DETECTOR, request.body, |answer| {
            if let Reply::Param { values, .. } = answer.data {
                found = Hotbed::of_values(values).next();
            }
        });
        found
    }
}
