//! What a client sees of the monitor: the status words of its subsystems (§3.3).

use crate::model::monitor::Monitor;
use lafet_device::image::{Axis, ValveNo};
use lafet_proto::flags::{
    ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, GeneralFlags, ValveFlags,
};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, Status, SubsystemId};

/// Largest frame of answers, bytes.
const ROOM: usize = 512;

/// One answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// The subsystem that answers.
    pub from: SubsystemId,
    /// Status of the answer.
    pub status: Status,
}

/// The answers to a request: whole records, the last of which may be cut off.
pub struct Replies {
    bytes: [u8; ROOM],
    len: usize,
}

impl Replies {
    /// Sends the monitor a request.
    pub fn ask(monitor: &mut impl Monitor, now_ms: u32, request: &Request<'_>) -> Self {
        let mut payload = [0; ROOM];
        let mut writer = Writer::new(&mut payload);
        request.encode(&mut writer).expect("requests of the model fit");
        let len = writer.len();
        let mut bytes = [0; ROOM];
        let len = monitor.handle(now_ms, &payload[..len], &mut bytes);
        Self { bytes, len }
    }

    /// Senders and statuses of the answers.
    pub fn iter(&self) -> impl Iterator<Item = Reply> {
        let records = Records::new(&self.bytes[..self.len]).flatten();
        records.map(|record| Reply { from: record.device, status: record.status })
    }

    /// The answer, if there is exactly one.
    pub fn only(&self) -> Option<Reply> {
        let mut all = self.iter();
        all.next().filter(|_| all.next().is_none())
    }

    fn words(&self) -> impl Iterator<Item = (SubsystemId, u32)> {
        Records::new(&self.bytes[..self.len]).flatten().filter_map(|record| {
            Some((record.device, u32::from_le_bytes(*record.data.first_chunk()?)))
        })
    }
}

/// The status words that concern the interlock; 0 for an absent subsystem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct View {
    general: u32,
    control: u32,
    detector: u32,
    deployer: u32,
    drives: [u32; 3],
    valves: [u32; 2],
    has_deployer: bool,
    has_valves: [bool; 2],
}

impl View {
    /// Reads the status words with GetStatus, which changes nothing.
    pub fn of(monitor: &mut impl Monitor, now_ms: u32) -> Self {
        let request = Request::new(SubsystemId::ALL, Body::GetStatus);
        let mut view = Self::default();
        for (from, word) in Replies::ask(monitor, now_ms, &request).words() {
            match from {
                SubsystemId::GENERAL => view.general = word,
                SubsystemId::CONTROL => view.control = word,
                SubsystemId::DETECTOR => view.detector = word,
                SubsystemId::DEPLOYER => (view.deployer, view.has_deployer) = (word, true),
                SubsystemId::VERTICAL => view.drives[0] = word,
                SubsystemId::HORIZONTAL => view.drives[1] = word,
                SubsystemId::NOZZLE => view.drives[2] = word,
                SubsystemId::VALVE1 => (view.valves[0], view.has_valves[0]) = (word, true),
                SubsystemId::VALVE2 => (view.valves[1], view.has_valves[1]) = (word, true),
                _ => {}
            }
        }
        view
    }

    /// Flags of General.
    pub fn general(&self) -> GeneralFlags {
        GeneralFlags::from_bits_retain(self.general)
    }

    /// Flags of Control.
    pub fn control(&self) -> ControlFlags {
        ControlFlags::from_bits_retain(self.control)
    }

    /// Flags of Detector.
    pub fn detector(&self) -> DetectorFlags {
        DetectorFlags::from_bits_retain(self.detector)
    }

    /// Flags of Deployer.
    pub fn deployer(&self) -> DeployerFlags {
        DeployerFlags::from_bits_retain(self.deployer)
    }

    /// Flags of a drive; for Deployer, those that it shares with drives.
    pub fn drive(&self, axis: Axis) -> DriveFlags {
        let [vertical, horizontal, nozzle] = self.drives;
        DriveFlags::from_bits_retain(match axis {
            Axis::Vertical => vertical,
            Axis::Horizontal => horizontal,
            Axis::Nozzle => nozzle,
            Axis::Deployer => self.deployer,
        })
    }

    /// Flags of a valve.
    pub fn valve(&self, valve: ValveNo) -> ValveFlags {
        ValveFlags::from_bits_retain(self.valves[valve as usize])
    }

    /// Whether the monitor has this valve.
    pub fn has_valve(&self, valve: ValveNo) -> bool {
        self.has_valves[valve as usize]
    }

    /// Whether the monitor has a Deployer.
    pub fn has_deployer(&self) -> bool {
        self.has_deployer
    }

    /// Whether it is in working position, or always in it.
    pub fn is_deployed(&self) -> bool {
        !self.has_deployer || self.deployer().contains(DeployerFlags::DEPLOYED)
    }

    /// Whether it is deploying or stowing.
    pub fn is_on_the_way(&self) -> bool {
        self.deployer().intersects(DeployerFlags::DEPLOYING | DeployerFlags::WRAPPING)
    }

    /// Whether a program runs, is paused, or waits for the deployment.
    pub fn is_quenching(&self) -> bool {
        self.control().contains(ControlFlags::QUENCH)
    }

    /// Whether a search runs, or waits for the deployment.
    pub fn is_searching(&self) -> bool {
        self.detector().contains(DetectorFlags::SEARCHING)
    }

    /// Whether detector and barrel are being aligned.
    pub fn is_justifying(&self) -> bool {
        self.detector().contains(DetectorFlags::JUSTIFYING)
    }

    /// Whether the limits of any drive are off.
    pub fn is_limitless(&self) -> bool {
        Axis::ALL.into_iter().any(|axis| self.drive(axis).contains(DriveFlags::LIMITLESS))
    }
}
