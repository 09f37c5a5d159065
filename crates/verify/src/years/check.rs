//! What must hold.

use lafet_device::Source;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::answer::Reply;
use lafet_proto::flags::{
    ButtonsFlags, ClimaticsFlags, ConnFlags, ControlFlags, DeployerFlags, DetectorFlags,
    DriveFlags, ValveFlags,
};
use lafet_proto::record::Records;
use lafet_proto::{Answer, RequestId, SubsystemId};
use lafet_sim::event::What;

use super::Years;
use crate::interlock::Moment;

/// A drive is this far from where it was sent at most, ' or mm: a count, and what is less.
const POSITION: f64 = 1.5;

impl Years {
    /// In every step: no water in a stowed barrel, nothing driven while locked out.
    pub(super) fn never(&mut self) -> Result<(), String> {
        let world = self.sim.world();
        let moment = Moment {
            locked: self.locked,
            flooded: world.flooded(),
            ..Moment::new(world.outputs())
        };
        moment.judge().first().map_or(Ok(()), |broken| Err(broken.to_string()))
    }

    pub(super) fn has_stopped(&mut self, axis: Axis) -> bool {
        let moving = match self.status(axis.id()) {
            Reply::Drive(status) => status.flags.contains(DriveFlags::MOVE),
            Reply::Deployer(status) => status.flags.contains(DeployerFlags::MOVE),
            _ => false,
        };
        !moving
    }

    pub(super) fn detector(&mut self) -> DetectorFlags {
        match self.status(SubsystemId::DETECTOR) {
            Reply::Detector(status) => status.flags,
            _ => DetectorFlags::empty(),
        }
    }

    fn status(&mut self, of: SubsystemId) -> Reply<'static> {
        let payload = [RequestId::GET_STATUS.0, of.0, 0, 0];
        let bytes = self.sim.request(Source::Radio, &payload);
        let record = Records::new(&bytes).next();
        match record.and_then(Result::ok).and_then(|record| Answer::decode(&record).ok()) {
            Some(Answer { data: Reply::Drive(status), .. }) => Reply::Drive(status),
            Some(Answer { data: Reply::Deployer(status), .. }) => Reply::Deployer(status),
            Some(Answer { data: Reply::Detector(status), .. }) => Reply::Detector(status),
            _ => Reply::None,
        }
    }

    /// Position as it is and as it is reported: both where it was sent, year after year.
    pub(super) fn stands_at(&mut self, axis: Axis, target: i32) -> Result<(), String> {
        let reported = match self.status(axis.id()) {
            Reply::Drive(status) => i32::from(status.position),
            other => return Err(format!("{axis:?} reports {other:?}")),
        };
        let is = self.sim.world().drives[axis as usize].position;
        let error = (is - f64::from(target)).abs();
        self.report.error_max = self.report.error_max.max(error);
        self.report.error_last_year = self.report.error_last_year.max(error);
        if error > POSITION || (is - f64::from(reported)).abs() > POSITION {
            return Err(format!(
                "{axis:?} is at {is:.2}, reports {reported}, was sent to {target}"
            ));
        }
        Ok(())
    }

    /// After an hour without a request: stowed, closed, still, and no flag but what belongs there.
    pub(super) fn stands_still(&mut self) -> Result<(), String> {
        self.never()?;
        let outputs = self.sim.world().outputs();
        let still = outputs.drives.iter().all(|drive| drive.speed_tenths == 0)
            && outputs.valves.iter().all(|valve| *valve == ValveOutput::Off);
        if !still {
            return Err(format!("not still: {outputs:?}"));
        }
        let flooded = |what| what == What::FoldedBarrelFlooded;
        if self.sim.world_mut().take_events().iter().any(|event| flooded(event.what)) {
            return Err("water in a folded barrel".into());
        }
        self.is_clean("standing still")
    }

    /// No flag is set but those of a sound monitor that is wrapped.
    pub(super) fn is_clean(&mut self, when: &str) -> Result<(), String> {
        let payload = [RequestId::GET_STATUS.0, SubsystemId::ALL.0, 0, 0];
        let bytes = self.sim.request(Source::Radio, &payload);
        let mut count = 0;
        for record in Records::new(&bytes) {
            let record = record.map_err(|error| error.to_string())?;
            let answer = Answer::decode(&record).map_err(|error| error.to_string())?;
            let left = unexpected(&answer.data);
            if left != 0 {
                return Err(format!("{when}: {answer} ({left:#010x} should be 0)"));
            }
            count += 1;
        }
        // All 14 subsystems answer, each time.
        if count == 14 { Ok(()) } else { Err(format!("{when}: {count} answers")) }
    }
}

/// The flags that a sound monitor at rest does not have.
fn unexpected(data: &Reply<'_>) -> u32 {
    const ENDS: DriveFlags = DriveFlags::MIN_LIMIT_REACHED
        .union(DriveFlags::MAX_LIMIT_REACHED)
        .union(DriveFlags::ABSOLUTE_MIN_LIMIT_REACHED)
        .union(DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED);
    const WRAPPED: DeployerFlags = DeployerFlags::WRAPPED
        .union(DeployerFlags::MIN_LIMIT_REACHED)
        .union(DeployerFlags::ABSOLUTE_MIN_LIMIT_REACHED);
    const HEATS: ClimaticsFlags = ClimaticsFlags::HORIZONTAL_HEAT
        .union(ClimaticsFlags::VERTICAL_HEAT)
        .union(ClimaticsFlags::NOZZLE_HEAT)
        .union(ClimaticsFlags::DEPLOYER_HEAT)
        .union(ClimaticsFlags::BOX_HEAT);
    match data {
        Reply::General(status) => status.flags.bits(),
        Reply::Thermo(status) => (status.flags - HEATS).bits(),
        Reply::Drive(status) => (status.flags - ENDS).bits(),
        Reply::Deployer(status) => {
            let missing = DeployerFlags::WRAPPED - status.flags;
            ((status.flags - WRAPPED) | missing).bits()
        }
        Reply::Valve(status) => {
            let missing = ValveFlags::CLOSED - status.flags;
            ((status.flags - ValveFlags::CLOSED) | missing).bits()
        }
        // What the last program and the last search came to stays until the next (§3.3.6, §3.16).
        Reply::Control(status) => {
            (status.flags & (ControlFlags::QUENCH | ControlFlags::TRAJECTORY)).bits()
        }
        Reply::Detector(status) => {
            (status.flags - DetectorFlags::FOUND - DetectorFlags::CANCELED).bits()
        }
        Reply::Conn(status) => (status.flags - ConnFlags::CONN_LOST).bits(),
        Reply::Buttons(status) => (status.flags - ButtonsFlags::empty()).bits(),
        _ => 0,
    }
}
