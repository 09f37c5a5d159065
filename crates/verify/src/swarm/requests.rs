//! Requests of the swarm: over the whole dictionary, with sound, extreme and senseless data.

use lafet_proto::dictionary::{REQUESTS, RequestInfo, SUBSYSTEMS};
use lafet_proto::id::key;
use lafet_proto::param::{Access, Param};
use lafet_proto::record::{DATA_MAX, Writer};
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Seek, Trajectory, TrajectoryPoint};
use lafet_proto::{Bytes, Ints, ParamId, Request, RequestId, SubsystemId};
use lafet_sim::rng::Rng;

/// Most records in a frame of the swarm.
const RECORDS_MAX: u64 = 12;
/// Most bytes of a frame's payload.
const PAYLOAD_MAX: usize = 512;

/// One of several.
pub(super) fn pick<T: Copy>(rng: &mut Rng, from: &[T]) -> T {
    from[(rng.bits() % from.len() as u64) as usize]
}

/// A number of this range, often one of its ends or zero.
pub(super) fn number(rng: &mut Rng, min: i32, max: i32) -> i32 {
    let span = (i64::from(max) - i64::from(min) + 1).unsigned_abs();
    let any = (i64::from(min) + (rng.bits() % span) as i64) as i32;
    match rng.bits() % 8 {
        0 => min,
        1 => max,
        2 => 0.clamp(min, max),
        _ => any,
    }
}

/// Records of a request as a client writes it.
pub(super) fn payload(request: &Request<'_>) -> Vec<u8> {
    let mut buffer = [0; DATA_MAX + 4];
    let mut writer = Writer::new(&mut buffer);
    // What is built here fits a record.
    match request.encode(&mut writer) {
        Ok(()) => writer.written().to_vec(),
        Err(_) => Vec::new(),
    }
}

/// A frame of random records.
pub fn frame(rng: &mut Rng) -> Vec<u8> {
    let count = match rng.bits() % 4 {
        0 => 1 + rng.bits() % RECORDS_MAX,
        _ => 1,
    };
    let mut bytes = Vec::new();
    for _ in 0..count {
        let record = record(rng);
        if bytes.len() + record.len() <= PAYLOAD_MAX {
            bytes.extend_from_slice(&record);
        }
    }
    // Cut short by the end of the frame.
    if rng.chance(0.02) {
        bytes.truncate((rng.bits() % (bytes.len() as u64 + 1)) as usize);
    }
    bytes
}

/// A random record: usually sound, sometimes to another addressee or with other data.
fn record(rng: &mut Rng) -> Vec<u8> {
    if rng.chance(0.03) {
        let len = rng.bits() % 20;
        let data: Vec<u8> = (0..len).map(|_| rng.bits() as u8).collect();
        let mut record = vec![rng.bits() as u8, rng.bits() as u8, rng.bits() as u8, len as u8];
        record.extend_from_slice(&data);
        return record;
    }
    let info = request(rng);
    let to = if rng.chance(0.1) || info.addressees.is_empty() {
        SUBSYSTEMS[(rng.bits() % SUBSYSTEMS.len() as u64) as usize].id
    } else {
        pick(rng, info.addressees)
    };
    let mut record = sound(rng, info.id, to);
    if rng.chance(0.05) {
        // Another size than the request has.
        let size = (rng.bits() % 40) as u8;
        record.truncate(4);
        record[3] = size;
        record.extend((0..size).map(|_| rng.bits() as u8));
    }
    record
}

/// Requests that undo much come seldom.
fn request(rng: &mut Rng) -> &'static RequestInfo {
    loop {
        let info = &REQUESTS[(rng.bits() % REQUESTS.len() as u64) as usize];
        let rare = match info.id {
            RequestId::CLEAN_FLASH => 0.05,
            RequestId::RESTART | RequestId::LOCKOUT => 0.15,
            RequestId::SET_PARAM | RequestId::SWITCH_LIMITS => 0.4,
            _ => 1.0,
        };
        if rng.chance(rare) {
            return info;
        }
    }
}

/// A record with data of the right form.
fn sound(rng: &mut Rng, id: RequestId, to: SubsystemId) -> Vec<u8> {
    let angle = |rng: &mut Rng| number(rng, -12_000, 12_000) as i16;
    let key = |rng: &mut Rng, key: u16| if rng.chance(0.1) { rng.bits() as u16 } else { key };
    let (mut points, mut bytes) = (Vec::new(), Vec::new());
    let values;
    let body = match id {
        RequestId::MOVE => {
            let far = pick(rng, &[21_600, -21_600, i16::MAX, i16::MIN, 0]);
            Body::Move { destination: if rng.chance(0.4) { far } else { angle(rng) } }
        }
        RequestId::STOP => Body::Stop,
        RequestId::GET_STATUS => Body::GetStatus,
        RequestId::GET_PARAM => Body::GetParam { id: param(rng, to).0 },
        RequestId::SET_PARAM => {
            let (id, new) = param(rng, to);
            values = new;
            Body::SetParam { id, values: Ints::Values(&values) }
        }
        RequestId::SETUP_CORRECTION_TABLE => {
            bytes.extend((0..1 + rng.bits() % 60).map(|_| number(rng, -5, 5) as u8));
            let first = number(rng, 0, 255) as u8;
            Body::SetupCorrectionTable { first, corrections: Bytes(&bytes) }
        }
        RequestId::RETRIEVE_LIMITS => Body::RetrieveLimits,
        RequestId::OPEN => Body::Open { key: key(rng, key::OPEN) },
        RequestId::CLOSE => Body::Close { key: key(rng, key::CLOSE) },
        RequestId::DEPLOY => Body::Deploy,
        RequestId::WRAP => Body::Wrap,
        RequestId::RESTART => Body::Restart,
        RequestId::START_JUSTIFY => Body::StartJustify,
        RequestId::START_QUENCH => {
            bytes.extend((0..2 + rng.bits() % 100).map(|_| number(rng, -4, 10) as u8));
            Body::StartQuench(quench(rng, &bytes))
        }
        RequestId::START_TRAJECTORY => {
            bytes.extend((0..1 + rng.bits() % 3).map(|_| number(rng, 0, 8) as u8));
            points.extend((0..1 + rng.bits() % 5).map(|_| TrajectoryPoint {
                horizontal: angle(rng) / 4,
                vertical: angle(rng) / 8,
                distance: number(rng, 0, 60) as u8,
                dwell: number(rng, 0, 20) as u8,
            }));
            let stored = rng.chance(0.3);
            let path =
                if stored { Path::Stored(&bytes) } else { Path::Points(Points::Values(&points)) };
            let (ballistics, repeat) = (rng.chance(0.5), rng.chance(0.5));
            Body::StartTrajectory(Trajectory { ballistics, repeat, path })
        }
        RequestId::START_SEEK => Body::StartSeek(Seek {
            start_h: angle(rng) / 3,
            end_h: angle(rng) / 3,
            start_v: angle(rng) / 16,
            end_v: angle(rng) / 16,
            analyse: number(rng, 0, 2) as i16,
        }),
        RequestId::SWITCH_LIMITS => Body::SwitchLimits { new_state: number(rng, 0, 3) as u16 },
        RequestId::GET_HOTBED => Body::GetHotbed,
        RequestId::LOCKOUT => {
            let known = pick(rng, &[key::ENABLE, key::DISABLE]);
            Body::Lockout { key: key(rng, known) }
        }
        RequestId::CLEAN_FLASH => Body::CleanFlash { key: key(rng, key::CLEAN_FLASH) },
        RequestId::GET_CRASH_DATA => Body::GetCrashData,
        request => {
            bytes.extend((0..rng.bits() % 6).map(|_| rng.bits() as u8));
            Body::Unknown { request, data: &bytes }
        }
    };
    payload(&Request::new(to, body))
}

fn quench<'a>(rng: &mut Rng, corrections: &'a [u8]) -> Quench<'a> {
    let angle = |rng: &mut Rng, most: i32| number(rng, -most, most) as i16;
    let sector = Sector {
        centre_h: angle(rng, 4000),
        centre_v: angle(rng, 600),
        nozzle: number(rng, -5, 70) as i16,
        width: number(rng, -1, 1200) as i16,
        height: number(rng, -1, 600) as i16,
        step: number(rng, -1, 5) as i8,
    };
    match rng.bits() % 3 {
        0 => Quench::Program {
            program: number(rng, -1, 8) as i16,
            centre_h: sector.centre_h,
            centre_v: sector.centre_v,
            nozzle: sector.nozzle,
        },
        1 => Quench::Full { sector, distance: number(rng, -1, 80) as i8 },
        _ => Quench::Corrected { sector, corrections: Bytes(corrections) },
    }
}

/// A parameter of a subsystem with values for it. What the monitor is built of stays: a
/// configuration that denies the hardware is not a fault to be found here.
fn param(rng: &mut Rng, to: SubsystemId) -> (ParamId, Vec<i32>) {
    let all: Vec<Param> = Param::of(to).filter(|param| !describes_hardware(*param)).collect();
    if all.is_empty() || rng.chance(0.05) {
        return (ParamId(rng.bits() as u16), vec![number(rng, i32::MIN, i32::MAX)]);
    }
    let param = pick(rng, &all);
    let spec = param.spec();
    let wild = rng.chance(0.1);
    let len = number(rng, spec.min_len.into(), spec.max_len.into()) as usize;
    let len = if wild { len } else { len - len % usize::from(spec.step_len.max(1)) };
    let values = (0..len).map(|index| {
        let element = spec.element(index);
        match rng.bits() % 4 {
            _ if wild => number(rng, i32::MIN, i32::MAX),
            // Near what it is from the factory, so that the monitor stays of use.
            0 | 1 => {
                let near = spec.default.saturating_add(number(rng, -100, 100));
                near.clamp(element.min, element.max)
            }
            2 => spec.default.clamp(element.min, element.max),
            _ => number(rng, element.min, element.max),
        }
    });
    (spec.id, values.collect())
}

/// Parameters that say what the monitor is built of, and where it is on the bus: also that its position
/// sensors count from where they are switched on, which those of the swarm do not.
pub(super) fn describes_hardware(param: Param) -> bool {
    matches!(
        param,
        Param::GeneralChain
            | Param::VerticalDriveType
            | Param::HorizontalDriveType
            | Param::NozzleDriveType
            | Param::DeployerDriveType
            | Param::Valve1ValveType
            | Param::Valve2ValveType
            | Param::VerticalHoming
            | Param::VerticalHomePosition
            | Param::HorizontalHoming
            | Param::HorizontalHomePosition
            | Param::NozzleHoming
            | Param::NozzleHomePosition
    )
}

/// SetParam of everything that can be set, as the factory has it, a record each.
pub(super) fn factory(composition: &lafet_device::Composition) -> Vec<Vec<u8>> {
    let settable = Param::ALL.into_iter().filter(|p| p.spec().access == Access::ReadWrite);
    settable
        .map(|param| {
            let spec = param.spec();
            let values = vec![composition.factory_value(param); usize::from(spec.min_len)];
            let body = Body::SetParam { id: spec.id, values: Ints::Values(&values) };
            payload(&Request::new(spec.subsystem, body))
        })
        .collect()
}
