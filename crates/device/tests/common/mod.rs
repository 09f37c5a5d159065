//! A monitor on a trivial plant: what is commanded happens at once, exactly and reproducibly.
//!
//! The simulator has the realistic world; here every number can be checked by hand.
#![allow(dead_code, reason = "each test file uses its own part")]

mod plant;

pub use plant::Plant;

use lafet_device::image::{Axis, Outputs, ValveOutput};
use lafet_device::{Composition, Device, Source};
use lafet_proto::flags::{ButtonsFlags, ConnFlags, DeployerFlags, DriveFlags, ValveFlags};
use lafet_proto::param::Param;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::{DriveStatus, GeneralStatus, Limits};
use lafet_proto::{Ints, Request, Status, SubsystemId};

pub const ADDRESS: u8 = 1;
/// The usual step of these tests, ms.
pub const STEP_MS: u32 = 10;
/// As long as a frame of answers may be.
pub const ROOM: usize = 512;

/// One answer as its record says it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    pub from: SubsystemId,
    pub status: Status,
    pub data: Vec<u8>,
}

/// A device, its plant and the clock.
#[derive(Clone)]
pub struct Rig {
    pub device: Device,
    pub plant: Plant,
    pub now_ms: u32,
    pub composition: Composition,
    pub source: Source,
}

impl Rig {
    /// A new monitor of this composition, settled.
    pub fn new(composition: Composition) -> Self {
        Self::at(composition, 0)
    }

    /// The same, with the clock at this moment when it is ready.
    pub fn at(composition: Composition, now_ms: u32) -> Self {
        let mut plant = Plant::of(&composition);
        Device::provision(&mut plant, &composition, ADDRESS).unwrap();
        let mut rig = Self::power_up(composition, plant, now_ms.wrapping_sub(200));
        rig.run(200);
        assert_eq!(rig.now_ms, now_ms);
        rig
    }

    /// A monitor that has just been switched on: no step has been made.
    pub fn power_up(composition: Composition, mut plant: Plant, now_ms: u32) -> Self {
        let device = Device::power_up(now_ms, &composition, ADDRESS, None, &mut plant);
        Self { device, plant, now_ms, composition, source: Source::ExternalConn }
    }

    /// A monitor that can be aimed.
    pub fn deployed() -> Self {
        let mut rig = Self::new(Composition::FULL);
        rig.deploy();
        rig
    }

    pub fn deploy(&mut self) {
        self.accepts(SubsystemId::DEPLOYER, Body::Deploy);
        self.run_until(20_000, |rig| rig.deployer().contains(DeployerFlags::DEPLOYED));
    }

    /// Switched off and on again: what is stored survives.
    pub fn power_cycle(&mut self) {
        self.plant.outputs = Outputs::default();
        let plant = self.plant.clone();
        *self = Self::power_up(self.composition, plant, self.now_ms);
    }

    /// Powers up and waits until the monitor has settled.
    pub fn power_cycle_and_settle(&mut self) {
        self.power_cycle();
        self.run(200);
    }

    /// One step; a reset that the device asks for makes a new device.
    pub fn step(&mut self, dt_ms: u32) {
        self.now_ms = self.now_ms.wrapping_add(dt_ms);
        self.plant.advance(dt_ms);
        self.device.step(self.now_ms, &mut self.plant);
        if std::mem::take(&mut self.plant.reset_requested) {
            self.power_cycle();
        }
    }

    /// A step so long that it says nothing of what has changed in it: drives have been put somewhere else, which is no
    /// jump of their sensors.
    pub fn pause(&mut self) {
        self.now_ms = self.now_ms.wrapping_add(251);
        self.device.step(self.now_ms, &mut self.plant);
    }

    pub fn run(&mut self, ms: u32) {
        for _ in 0..ms / STEP_MS {
            self.step(STEP_MS);
        }
    }

    /// Steps until it holds; returns how long it took.
    #[track_caller]
    pub fn run_until(&mut self, within_ms: u32, holds: impl Fn(&mut Self) -> bool) -> u32 {
        let mut ms = 0;
        while !holds(self) {
            assert!(ms < within_ms, "not within {within_ms} ms: {:?}", self.device.outputs());
            self.step(STEP_MS);
            ms += STEP_MS;
        }
        ms
    }

    /// Steps for a while; it must hold after each.
    #[track_caller]
    pub fn run_while(&mut self, ms: u32, holds: impl Fn(&mut Self) -> bool) {
        for at in (0..ms).step_by(STEP_MS as usize) {
            self.step(STEP_MS);
            assert!(holds(self), "after {at} ms: {:?}", self.device.outputs());
        }
    }

    /// Answers to the bytes of a payload.
    pub fn handle(&mut self, payload: &[u8]) -> Vec<Reply> {
        let mut out = [0; ROOM];
        let len = self.device.handle(self.now_ms, self.source, payload, &mut out);
        replies(&out[..len])
    }

    /// Answers to a request.
    pub fn ask(&mut self, to: SubsystemId, body: Body<'_>) -> Vec<Reply> {
        self.handle(&payload(&[Request::new(to, body)]))
    }

    /// The only answer to a request.
    #[track_caller]
    pub fn one(&mut self, to: SubsystemId, body: Body<'_>) -> (SubsystemId, Status) {
        let replies = self.ask(to, body);
        let [reply] = replies.as_slice() else { panic!("{body:?} to {to}: {replies:?}") };
        (reply.from, reply.status)
    }

    /// The status that the addressee itself answers.
    #[track_caller]
    pub fn status(&mut self, to: SubsystemId, body: Body<'_>) -> Status {
        let (from, status) = self.one(to, body);
        assert_eq!(from, to, "{body:?}: {status}");
        status
    }

    #[track_caller]
    pub fn accepts(&mut self, to: SubsystemId, body: Body<'_>) {
        let (from, status) = self.one(to, body);
        assert!(status.is_success(), "{body:?} to {to}: {status} from {from}");
    }

    /// All of them do it.
    #[track_caller]
    pub fn all_accept(&mut self, body: Body<'_>) {
        for reply in self.ask(SubsystemId::ALL, body) {
            assert!(reply.status.is_success(), "{body:?}: {reply:?}");
        }
    }

    #[track_caller]
    pub fn move_to(&mut self, axis: Axis, destination: i16) {
        self.accepts(axis.id(), Body::Move { destination });
    }

    #[track_caller]
    pub fn set(&mut self, param: Param, value: i32) -> Status {
        let spec = param.spec();
        let values = Ints::Values(&[value]);
        self.status(spec.subsystem, Body::SetParam { id: spec.id, values })
    }

    /// The values of a parameter, or why there are none.
    #[track_caller]
    pub fn get(&mut self, param: Param) -> Result<Vec<i32>, Status> {
        let spec = param.spec();
        let replies = self.ask(spec.subsystem, Body::GetParam { id: spec.id });
        let [reply] = replies.as_slice() else { panic!("{param:?}: {replies:?}") };
        assert_eq!(reply.from, spec.subsystem);
        let (id, values) = reply.data.split_first_chunk().unwrap();
        assert_eq!(u16::from_le_bytes(*id), spec.id.0);
        let values: Vec<i32> =
            values.as_chunks().0.iter().map(|v| i32::from_le_bytes(*v)).collect();
        if reply.status == Status::OK { Ok(values) } else { Err(reply.status) }
    }

    fn status_bytes(&mut self, id: SubsystemId) -> Vec<u8> {
        let replies = self.ask(id, Body::GetStatus);
        let [reply] = replies.as_slice() else { panic!("{id}: {replies:?}") };
        assert_eq!((reply.from, reply.status), (id, Status::OK));
        reply.data.clone()
    }

    /// The first four bytes of any status.
    pub fn flags(&mut self, id: SubsystemId) -> u32 {
        u32::from_le_bytes(*self.status_bytes(id).first_chunk().unwrap())
    }

    pub fn drive(&mut self, axis: Axis) -> DriveStatus {
        DriveStatus::from_bytes(self.status_bytes(axis.id()).try_into().unwrap())
    }

    pub fn drive_flags(&mut self, axis: Axis) -> DriveFlags {
        DriveFlags::from_bits_retain(self.flags(axis.id()))
    }

    pub fn deployer(&mut self) -> DeployerFlags {
        DeployerFlags::from_bits_retain(self.flags(SubsystemId::DEPLOYER))
    }

    pub fn valve(&mut self, id: SubsystemId) -> ValveFlags {
        ValveFlags::from_bits_retain(self.flags(id))
    }

    pub fn conn(&mut self, id: SubsystemId) -> ConnFlags {
        ConnFlags::from_bits_retain(self.flags(id))
    }

    pub fn buttons(&mut self, id: SubsystemId) -> ButtonsFlags {
        ButtonsFlags::from_bits_retain(self.flags(id))
    }

    pub fn general(&mut self) -> GeneralStatus {
        GeneralStatus::from_bytes(self.status_bytes(SubsystemId::GENERAL).try_into().unwrap())
    }

    pub fn limits(&mut self, axis: Axis) -> Limits {
        let replies = self.ask(axis.id(), Body::RetrieveLimits);
        Limits::from_bytes(replies[0].data.as_slice().try_into().unwrap())
    }

    /// Commanded speed, 0.1 °/s or 0.1 mm/s.
    pub fn speed(&self, axis: Axis) -> i16 {
        self.plant.outputs.drives[axis as usize].speed_tenths
    }

    /// Nothing turns.
    pub fn is_still(&self) -> bool {
        self.plant.outputs.drives.iter().all(|drive| drive.speed_tenths == 0)
    }

    pub fn valve_output(&self, valve: usize) -> ValveOutput {
        self.plant.outputs.valves[valve]
    }
}

/// Bytes of these requests.
pub fn payload(requests: &[Request<'_>]) -> Vec<u8> {
    let mut buffer = vec![0; 1024];
    let mut writer = Writer::new(&mut buffer);
    for request in requests {
        request.encode(&mut writer).unwrap();
    }
    let len = writer.len();
    buffer.truncate(len);
    buffer
}

/// The answers in a payload, which must consist of whole records.
pub fn replies(payload: &[u8]) -> Vec<Reply> {
    Records::new(payload)
        .map(|record| {
            let record = record.expect("answers are whole records");
            Reply { from: record.device, status: record.status, data: record.data.to_vec() }
        })
        .collect()
}
