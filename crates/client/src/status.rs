//! The typed state of a monitor.

use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::status::{
    ButtonsStatus, ConnStatus, ControlStatus, DeployerStatus, DetectorStatus, DriveStatus,
    GeneralStatus, ThermoStatus, ValveStatus,
};

use crate::answers::{AnswerBuf, Answers};
use crate::error::Error;
use crate::monitor::typed;
use crate::subscription::{Sample, Subscription, Update};

/// The state of a monitor; subsystems that it does not have are `None` (§3.3).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct MonitorStatus {
    /// The monitor as a whole.
    pub general: Option<GeneralStatus>,
    /// Climate.
    pub climatics: Option<ThermoStatus>,
    /// Elevation drive.
    pub vertical: Option<DriveStatus>,
    /// Traverse drive.
    pub horizontal: Option<DriveStatus>,
    /// Drive of the nozzle.
    pub nozzle: Option<DriveStatus>,
    /// Valve 1, water.
    pub valve1: Option<ValveStatus>,
    /// Valve 2, foam.
    pub valve2: Option<ValveStatus>,
    /// Programs of extinguishing.
    pub control: Option<ControlStatus>,
    /// Fire detector.
    pub detector: Option<DetectorStatus>,
    /// Deployment.
    pub deployer: Option<DeployerStatus>,
    /// Wired interface.
    pub external_conn: Option<ConnStatus>,
    /// Radio interface.
    pub radio: Option<ConnStatus>,
    /// Button post.
    pub buttons: Option<ButtonsStatus>,
    /// Remote button post.
    pub ext_buttons: Option<ButtonsStatus>,
    /// Answers without a state: refusals, and subsystems that are not in the document.
    pub others: Vec<AnswerBuf>,
}

impl MonitorStatus {
    fn new(answers: Answers) -> Result<Self, Error> {
        let mut status = Self::default();
        for answer in answers {
            let known = match typed(&answer)? {
                data if answer.status().is_success() => status.put(answer.from(), data),
                _ => false,
            };
            if !known {
                status.others.push(answer);
            }
        }
        Ok(status)
    }

    /// Like `new`, but a refusal of General in the name of all is an error; a refusal of one
    /// subsystem is not.
    pub(crate) fn of_all(answers: Answers) -> Result<Self, Error> {
        Self::new(if answers.len() > 1 { answers } else { answers.accepted()? })
    }

    fn put(&mut self, from: SubsystemId, data: Reply<'_>) -> bool {
        match (from, data) {
            (_, Reply::General(status)) => self.general = Some(status),
            (_, Reply::Thermo(status)) => self.climatics = Some(status),
            (SubsystemId::VERTICAL, Reply::Drive(status)) => self.vertical = Some(status),
            (SubsystemId::HORIZONTAL, Reply::Drive(status)) => self.horizontal = Some(status),
            (SubsystemId::NOZZLE, Reply::Drive(status)) => self.nozzle = Some(status),
            (SubsystemId::VALVE1, Reply::Valve(status)) => self.valve1 = Some(status),
            (SubsystemId::VALVE2, Reply::Valve(status)) => self.valve2 = Some(status),
            (_, Reply::Control(status)) => self.control = Some(status),
            (_, Reply::Detector(status)) => self.detector = Some(status),
            (_, Reply::Deployer(status)) => self.deployer = Some(status),
            (SubsystemId::EXTERNAL_CONN, Reply::Conn(status)) => self.external_conn = Some(status),
            (SubsystemId::RADIO, Reply::Conn(status)) => self.radio = Some(status),
            (SubsystemId::BUTTONS, Reply::Buttons(status)) => self.buttons = Some(status),
            (SubsystemId::EXT_BUTTONS, Reply::Buttons(status)) => self.ext_buttons = Some(status),
            _ => return false,
        }
        true
    }

    /// The state of Vertical, Horizontal or Nozzle.
    pub fn drive(&self, id: SubsystemId) -> Option<DriveStatus> {
        match id {
            SubsystemId::VERTICAL => self.vertical,
            SubsystemId::HORIZONTAL => self.horizontal,
            SubsystemId::NOZZLE => self.nozzle,
            _ => None,
        }
    }

    /// The state of Valve1 or Valve2.
    pub fn valve(&self, id: SubsystemId) -> Option<ValveStatus> {
        match id {
            SubsystemId::VALVE1 => self.valve1,
            SubsystemId::VALVE2 => self.valve2,
            _ => None,
        }
    }

    /// The status word of a subsystem.
    pub fn flags(&self, id: SubsystemId) -> Option<u32> {
        match id {
            SubsystemId::GENERAL => self.general.map(|status| status.flags.bits()),
            SubsystemId::CLIMATICS => self.climatics.map(|status| status.flags.bits()),
            SubsystemId::CONTROL => self.control.map(|status| status.flags.bits()),
            SubsystemId::DETECTOR => self.detector.map(|status| status.flags.bits()),
            SubsystemId::DEPLOYER => self.deployer.map(|status| status.flags.bits()),
            SubsystemId::EXTERNAL_CONN => self.external_conn.map(|status| status.flags.bits()),
            SubsystemId::RADIO => self.radio.map(|status| status.flags.bits()),
            SubsystemId::BUTTONS => self.buttons.map(|status| status.flags.bits()),
            SubsystemId::EXT_BUTTONS => self.ext_buttons.map(|status| status.flags.bits()),
            id if id.is_valve() => self.valve(id).map(|status| status.flags.bits()),
            id => self.drive(id).map(|status| status.flags.bits()),
        }
    }

    /// The subsystems that answered with their state, in the document's order.
    pub fn present(&self) -> impl Iterator<Item = SubsystemId> + '_ {
        SubsystemId::TABLE.into_iter().filter(|id| self.flags(*id).is_some())
    }
}

/// A state that is kept up to date: see [`crate::Monitor::watch`].
#[derive(Debug)]
pub struct StatusSubscription {
    inner: Subscription,
}

/// A state with its age.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StatusSample {
    /// The state.
    pub status: MonitorStatus,
    /// Age at the time of the call.
    pub age: Duration,
    /// Later reads failed: the state may have changed.
    pub stale: bool,
}

/// An update of a state.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum StatusUpdate {
    /// A new state.
    Value(StatusSample),
    /// The state cannot be read, with the reason. Polling continues.
    Stale(Error),
    /// This many updates were missed; the next ones follow.
    Missed(u64),
}

impl StatusSubscription {
    pub(crate) const fn new(inner: Subscription) -> Self {
        Self { inner }
    }

    /// The latest state, with its age; `None` before the first.
    pub fn latest(&self) -> Option<StatusSample> {
        sample(&self.inner.latest()?).ok()
    }

    /// Why the state cannot be read at present.
    pub fn error(&self) -> Option<Error> {
        self.inner.error()
    }

    /// Waits for the next update. Dropping the future loses nothing.
    pub async fn next(&mut self) -> StatusUpdate {
        match self.inner.next().await {
            Update::Value(value) => match sample(&value) {
                Ok(sample) => StatusUpdate::Value(sample),
                Err(error) => StatusUpdate::Stale(error),
            },
            Update::Stale(error) => StatusUpdate::Stale(error),
            Update::Missed(missed) => StatusUpdate::Missed(missed),
        }
    }
}

fn sample(sample: &Sample) -> Result<StatusSample, Error> {
    let status = MonitorStatus::of_all(sample.answers().clone())?;
    Ok(StatusSample { status, age: sample.age(), stale: sample.is_stale() })
}
