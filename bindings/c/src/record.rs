//! Records, and the states they carry.

use lafet_proto::answer::Reply;
use lafet_proto::record::{Records, Writer};
use lafet_proto::{Answer, Record, RequestId, Status, SubsystemId};

use crate::{bytes, room};

/// A request or an answer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_record {
    /// What is asked.
    pub request: u8,
    /// In a request the addressee, in an answer the subsystem that answers.
    pub device: u8,
    /// Result; 0 in a request.
    pub status: u8,
    /// Bytes of data.
    pub size: u8,
    /// The data; they lie where the record was read from.
    pub data: *const u8,
}

/// A state (§3.3) of any subsystem; fields that it does not have are 0.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct lafet_state {
    /// The flags of §3.3.1 and of the subsystem.
    pub flags: u32,
    /// Drives and Deployer: position, arc-minutes; of the nozzle, mm.
    pub position: i16,
    /// Drives and Deployer: motor current, 0.1 A.
    pub current: u8,
    /// Drives and Deployer: speed that is set, °/s or mm/s.
    pub speed: u8,
    /// General: supply voltage, V.
    pub main_voltage: u16,
    /// General: pressure, 0.1 atm.
    pub pressure: u16,
    /// General: flow, l/s.
    pub flowrate: u16,
    /// Climatics: horizontal, vertical, nozzle, deployer, housing, 0.1 °C.
    pub temperatures: [i16; 5],
    /// Climatics: relative humidity, %.
    pub humidity: u16,
}

/// Takes the first record off a payload: moves `*payload` and `*size` behind it. False at the end and
/// where a record is cut short; then `*size` says which.
///
/// # Safety
/// `*size` is the size of `*payload`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_record_next(
    payload: *mut *const u8,
    size: *mut usize,
    record: *mut lafet_record,
) -> bool {
    // SAFETY: null or valid, says the caller.
    let (payload, size, out) = unsafe { (payload.as_mut(), size.as_mut(), record.as_mut()) };
    let (Some(payload), Some(size), Some(out)) = (payload, size, out) else { return false };
    // SAFETY: the caller's promise.
    let Some(bytes) = (unsafe { bytes(*payload, *size) }) else { return false };
    let mut records = Records::new(bytes);
    let Some(Ok(record)) = records.next() else { return false };
    *out = plain(&record);
    *payload = records.rest().as_ptr();
    *size = records.rest().len();
    true
}

/// Appends a record to a payload of `*size` bytes. False, and nothing is written, if it does not fit.
///
/// # Safety
/// `payload` has room for `room_size` bytes, `*size` of them written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_record_put(
    payload: *mut u8,
    room_size: usize,
    size: *mut usize,
    record: *const lafet_record,
) -> bool {
    // SAFETY: null or valid, says the caller.
    let (size, record) = unsafe { (size.as_mut(), record.as_ref()) };
    let (Some(size), Some(record)) = (size, record) else { return false };
    // SAFETY: the caller's promise.
    let Some(room) = (unsafe { room(payload, room_size) }) else { return false };
    let Some(free) = room.get_mut(*size..) else { return false };
    let mut writer = Writer::new(free);
    // SAFETY: the record's data have its size, says the caller.
    let Some(record) = (unsafe { typed(record) }) else { return false };
    let fits = writer.push(&record).is_ok();
    *size += writer.len();
    fits
}

/// Reads the state that an answer to GetStatus carries. False if it carries none, or one of a size
/// that its subsystem cannot have.
///
/// # Safety
/// The record is null or its data have its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_state_read(
    record: *const lafet_record,
    state: *mut lafet_state,
) -> bool {
    // SAFETY: null or valid, says the caller.
    let (Some(record), Some(out)) = (unsafe { record.as_ref() }, unsafe { state.as_mut() }) else {
        return false;
    };
    // SAFETY: the record's data have its size, says the caller.
    let Some(record) = (unsafe { typed(record) }) else { return false };
    let Some(state) = Answer::decode(&record).ok().and_then(|answer| state_of(&answer.data)) else {
        return false;
    };
    *out = state;
    true
}

/// Whether the data of an answer are of a size that it can have.
///
/// # Safety
/// The record is null or its data have its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_answer_is_valid(record: *const lafet_record) -> bool {
    // SAFETY: null or valid, says the caller.
    let record = unsafe { record.as_ref().and_then(|record| typed(record)) };
    record.is_some_and(|record| Answer::decode(&record).is_ok())
}

fn state_of(reply: &Reply<'_>) -> Option<lafet_state> {
    let mut state = lafet_state { flags: reply.flags_bits()?, ..lafet_state::default() };
    match reply {
        Reply::General(s) => {
            state.main_voltage = s.main_voltage;
            state.pressure = s.pressure;
            state.flowrate = s.flowrate;
        }
        Reply::Thermo(s) => {
            state.temperatures = [s.horizontal, s.vertical, s.nozzle, s.deployer, s.housing];
            state.humidity = s.humidity;
        }
        Reply::Drive(s) => {
            (state.position, state.current, state.speed) = (s.position, s.current, s.speed);
        }
        Reply::Deployer(s) => {
            (state.position, state.current, state.speed) = (s.position, s.current, s.speed);
        }
        _ => {}
    }
    Some(state)
}

pub(crate) fn plain(record: &Record<'_>) -> lafet_record {
    lafet_record {
        request: record.request.0,
        device: record.device.0,
        status: record.status.0,
        // A record that was read has at most 255.
        size: record.data.len().min(255) as u8,
        data: record.data.as_ptr(),
    }
}

/// `None` for data that are missing.
///
/// # Safety
/// The data are null or have the record's size.
pub(crate) unsafe fn typed(record: &lafet_record) -> Option<Record<'_>> {
    Some(Record {
        request: RequestId(record.request),
        device: SubsystemId(record.device),
        status: Status(record.status),
        // SAFETY: the caller's promise.
        data: unsafe { bytes(record.data, usize::from(record.size)) }?,
    })
}
