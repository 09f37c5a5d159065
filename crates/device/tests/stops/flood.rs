//! What else is on the line: noise, other requests, frames for others.

use crate::common::ADDRESS;
use lafet_proto::id::key;
use lafet_proto::link::{self, Frame, WIRE_MAX};
use lafet_proto::param::Param;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::{Body, Quench, Sector, Seek};
use lafet_proto::{Ints, Request, RequestId, SubsystemId};

/// Random numbers that a seed repeats (splitmix64).
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    pub fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    pub fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len() as u64) as usize]
    }

    fn i16(&mut self) -> i16 {
        (self.below(14_000) as i16) - 7000
    }
}

/// A frame as it goes on the wire.
pub fn wire(dst: u8, payload: &[u8]) -> Vec<u8> {
    let mut out = vec![0; WIRE_MAX];
    let len = link::encode(&Frame { dst, src: 128, payload }, &mut out).unwrap();
    out.truncate(len);
    out
}

/// Bytes that are no frame, or the beginning of one.
pub fn noise(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..random.below(60) {
        bytes.push(match random.below(6) {
            0 => 0xC0,
            1 => 0xDB,
            2 => 0xFF,
            _ => random.next() as u8,
        });
    }
}

/// Frames of a flood. A Restart or CleanFlash among them would make the answer Busy, and a Lockout
/// or its release would decide the case before it begins.
pub fn frames(random: &mut Random) -> Vec<Vec<u8>> {
    (0..200)
        .map(|_| {
            let dst = if random.one_in(8) { random.next() as u8 & 0x7F } else { ADDRESS };
            loop {
                let payload = if random.one_in(4) { raw(random) } else { requests(random) };
                if harmless(&payload) {
                    return wire(dst, &payload);
                }
            }
        })
        .collect()
}

fn harmless(payload: &[u8]) -> bool {
    const DECISIVE: [RequestId; 3] =
        [RequestId::RESTART, RequestId::CLEAN_FLASH, RequestId::LOCKOUT];
    Records::new(payload)
        .all(|record| record.is_ok_and(|record| !DECISIVE.contains(&record.request)))
}

fn raw(random: &mut Random) -> Vec<u8> {
    let mut payload = Vec::new();
    for _ in 0..random.below(30) {
        let (request, device) = (random.next() as u8, random.of(&SubsystemId::CHAIN).0);
        let size = random.below(9) as u8;
        payload.extend([request, device, random.next() as u8, size]);
        payload.extend((0..size).map(|_| random.next() as u8));
    }
    payload
}

/// As many requests as fit: the answer buffer overflows more often than not.
fn requests(random: &mut Random) -> Vec<u8> {
    let mut buffer = [0; 480];
    let mut writer = Writer::new(&mut buffer);
    for _ in 0..1 + random.below(60) {
        if request(random).encode(&mut writer).is_err() {
            break;
        }
    }
    writer.written().to_vec()
}

fn request(random: &mut Random) -> Request<'static> {
    let to = *random.of(&SubsystemId::CHAIN);
    let (a, b) = (random.i16(), random.i16());
    let sector =
        Sector { centre_h: a / 4, centre_v: 300, nozzle: 30, width: 600, height: 300, step: 1 };
    match random.below(16) {
        0..=2 => Request::new(*random.of(&MOVABLE), Body::Move { destination: a }),
        3 => Request::open(SubsystemId::VALVE1),
        4 => Request::close(SubsystemId::VALVE2),
        5 => Request::new(SubsystemId::DEPLOYER, Body::Deploy),
        6 => Request::new(SubsystemId::DEPLOYER, Body::Wrap),
        7 => Request::new(SubsystemId::DETECTOR, Body::StartSeek(sector_of(a, b))),
        8 => {
            let quench = Quench::Full { sector, distance: 0 };
            Request::new(SubsystemId::CONTROL, Body::StartQuench(quench))
        }
        9 => Request::new(SubsystemId::DETECTOR, Body::StartJustify),
        10 => Request::new(SubsystemId::MOTORS, Body::SwitchLimits { new_state: a as u16 & 3 }),
        11 => set(random),
        12 => Request::new(to, Body::Stop),
        13 => Request::new(SubsystemId::VALVE2, Body::Open { key: key::OPEN }),
        14 => Request::new(SubsystemId::ALL, Body::GetStatus),
        _ => Request::new(to, Body::GetStatus),
    }
}

const MOVABLE: [SubsystemId; 4] =
    [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE, SubsystemId::DEPLOYER];

fn sector_of(a: i16, b: i16) -> Seek {
    Seek { start_h: a / 4, end_h: b / 4, start_v: 0, end_v: 600, analyse: 0 }
}

/// A parameter that has to be stored: the flash gets busy.
pub fn set(random: &mut Random) -> Request<'static> {
    const SETTINGS: [(Param, &[i32]); 8] = [
        (Param::ClimaticsHeatOn, &[20]),
        (Param::VerticalSlowCurrent, &[77]),
        (Param::HorizontalSlowCurrent, &[78]),
        (Param::NozzleSlowCurrent, &[79]),
        (Param::DetectorScanStep, &[33]),
        (Param::ControlHeight, &[3]),
        (Param::ExternalConnTimeout, &[4000]),
        (Param::RadioTimeout, &[5000]),
    ];
    let (param, values) = *random.of(&SETTINGS);
    let spec = param.spec();
    let values = Ints::Values(values);
    Request::new(spec.subsystem, Body::SetParam { id: spec.id, values })
}
