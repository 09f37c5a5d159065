//! The monitor itself, and a medium on which it is asked.

use core::ffi::c_void;

use ::lafet_device::guard::Passed;
use ::lafet_device::hal::{Hal, Key, Storage, StorageError};
use ::lafet_device::image::Inputs;
use ::lafet_device::port::Port;
use ::lafet_device::{Composition, Device, Source};

use crate::image::{drive, lafet_inputs, lafet_outputs, sense};
use crate::{bytes, room};

/// A fire monitor.
#[repr(C)]
pub struct lafet_device {
    /// For lafet alone.
    pub opaque: [u64; 664],
}
const _: () = assert!(size_of::<lafet_device>() >= size_of::<Kept>());
const _: () = assert!(align_of::<lafet_device>() >= align_of::<Kept>());

/// What is kept of a monitor between two calls.
struct Kept {
    device: Device,
    /// As the program wrote it last: it need not write what has not changed.
    sensed: lafet_inputs,
}

/// A medium on which a monitor is asked.
#[repr(C)]
pub struct lafet_port {
    /// For lafet alone.
    pub opaque: [u64; 84],
}
const _: () = assert!(size_of::<lafet_port>() >= size_of::<Port>());
const _: () = assert!(align_of::<lafet_port>() >= align_of::<Port>());

/// Composition: everything.
pub const LAFET_FULL: u8 = 0;
/// Composition: without Deployer, Detector and Valve2.
pub const LAFET_REMOTE: u8 = 1;
/// Composition: without Deployer, Valve2, Climatics and the second button post.
pub const LAFET_MINI: u8 = 2;
/// Composition: everything, drives with limit switches.
pub const LAFET_LIMIT_SWITCH: u8 = 3;

/// The hardware under the monitor, and its memory. `context` comes back in each call. Only
/// `lafet_device_init`, `lafet_device_provision` and `lafet_device_step` call them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_hal {
    /// Yours.
    pub context: *mut c_void,
    /// Samples everything the monitor senses. `inputs` has what it was given last time, so what has not
    /// changed may be left; at the first time after `lafet_device_init` everything is 0 or false.
    pub read: Option<unsafe extern "C" fn(*mut c_void, *mut lafet_inputs)>,
    /// Drives everything the monitor drives.
    pub write: Option<unsafe extern "C" fn(*mut c_void, *const lafet_outputs)>,
    /// Resets the program: call `lafet_device_init` before the next step.
    pub reset: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Reads a stored value into `buffer`; its size, 0 when there is none, -1 when it cannot be read.
    pub load: Option<unsafe extern "C" fn(*mut c_void, u16, *mut u8, usize) -> isize>,
    /// Stores a value, as a whole or not at all even if power fails; false when it failed.
    pub store: Option<unsafe extern "C" fn(*mut c_void, u16, *const u8, usize) -> bool>,
    /// Erases all values; false when it failed.
    pub erase: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
}

struct Board<'s> {
    hal: lafet_hal,
    sensed: &'s mut lafet_inputs,
}

/// What is sensed before the first sample.
const fn nothing() -> lafet_inputs {
    // SAFETY: plain numbers and bools, for which zero is a value.
    unsafe { core::mem::zeroed() }
}

impl Storage for Board<'_> {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let load = self.hal.load.ok_or(StorageError::Read)?;
        // SAFETY: the buffer has the given length; the function is one of `lafet_hal::load`.
        let size = unsafe { load(self.hal.context, key.0, buffer.as_mut_ptr(), buffer.len()) };
        match usize::try_from(size) {
            Ok(0) => Ok(None),
            Ok(size) => buffer.get(..size).map(Some).ok_or(StorageError::Read),
            Err(_) => Err(StorageError::Read),
        }
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        let store = self.hal.store.ok_or(StorageError::Write)?;
        // SAFETY: the value has the given length; the function is one of `lafet_hal::store`.
        let stored = unsafe { store(self.hal.context, key.0, value.as_ptr(), value.len()) };
        if stored { Ok(()) } else { Err(StorageError::Write) }
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        let erase = self.hal.erase.ok_or(StorageError::Write)?;
        // SAFETY: the function is one of `lafet_hal::erase`.
        if unsafe { erase(self.hal.context) } { Ok(()) } else { Err(StorageError::Write) }
    }
}

impl Hal for Board<'_> {
    fn read(&mut self, inputs: &mut Inputs) {
        if let Some(read) = self.hal.read {
            // SAFETY: `sensed` is writable; the function is one of `lafet_hal::read`.
            unsafe { read(self.hal.context, &raw mut *self.sensed) };
            sense(self.sensed, inputs);
        }
    }

    fn write(&mut self, outputs: &Passed) {
        if let Some(write) = self.hal.write {
            let driven = drive(outputs);
            // SAFETY: `driven` is readable; the function is one of `lafet_hal::write`.
            unsafe { write(self.hal.context, &raw const driven) };
        }
    }

    fn reset(&mut self) {
        if let Some(reset) = self.hal.reset {
            // SAFETY: the function is one of `lafet_hal::reset`.
            unsafe { reset(self.hal.context) };
        }
    }
}

const fn composition(which: u8) -> Option<&'static Composition> {
    Some(match which {
        LAFET_FULL => &Composition::FULL,
        LAFET_REMOTE => &Composition::REMOTE,
        LAFET_MINI => &Composition::MINI,
        LAFET_LIMIT_SWITCH => &Composition::LIMIT_SWITCH,
        _ => return None,
    })
}

/// Stores the parameters with which a monitor leaves the factory. False when that failed.
///
/// # Safety
/// `hal` is null or valid, its functions as described there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_device_provision(
    hal: *const lafet_hal,
    which: u8,
    address: u8,
) -> bool {
    // SAFETY: the caller's promise.
    let Some(hal) = (unsafe { hal.as_ref() }) else { return false };
    let Some(composition) = composition(which) else { return false };
    let mut board = Board { hal: *hal, sensed: &mut nothing() };
    Device::provision(&mut board, composition, address).is_ok()
}

/// Starts the monitor: inert, until `lafet_device_step` is called. False for an unknown composition.
///
/// # Safety
/// `device` is null or writable; `hal` is null or valid, its functions as described there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_device_init(
    device: *mut lafet_device,
    now_ms: u32,
    which: u8,
    address: u8,
    hal: *const lafet_hal,
) -> bool {
    // SAFETY: the caller's promise.
    let Some(hal) = (unsafe { hal.as_ref() }).filter(|_| !device.is_null()) else { return false };
    let Some(composition) = composition(which) else { return false };
    let mut sensed = nothing();
    let mut board = Board { hal: *hal, sensed: &mut sensed };
    let new = Device::power_up(now_ms, composition, address, None, &mut board);
    // SAFETY: large enough and aligned, as asserted above; not null.
    unsafe { device.cast::<Kept>().write(Kept { device: new, sensed }) };
    true
}

/// One cycle: senses, decides, drives. Call it every 1 to 10 ms.
///
/// # Safety
/// The device was initialised; `hal` is as for `lafet_device_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_device_step(
    device: *mut lafet_device,
    now_ms: u32,
    hal: *const lafet_hal,
) {
    // SAFETY: the caller's promise.
    let (kept, hal) = unsafe { (device.cast::<Kept>().as_mut(), hal.as_ref()) };
    if let (Some(Kept { device, sensed }), Some(hal)) = (kept, hal) {
        device.step(now_ms, &mut Board { hal: *hal, sensed });
    }
}

/// Answers the records of a payload; returns the size of the answer in `out`
/// (`LAFET_PAYLOAD_MAX` suffices). Touches no hardware.
///
/// # Safety
/// The device was initialised; sizes are those of their buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_device_handle(
    device: *mut lafet_device,
    now_ms: u32,
    payload: *const u8,
    size: usize,
    out: *mut u8,
    out_size: usize,
) -> usize {
    // SAFETY: the caller's promise.
    let kept = unsafe { device.cast::<Kept>().as_mut() };
    // SAFETY: the caller's promise.
    let (payload, out) = unsafe { (bytes(payload, size), room(out, out_size)) };
    let (Some(kept), Some(payload), Some(out)) = (kept, payload, out) else { return 0 };
    kept.device.handle(now_ms, Source::ExternalConn, payload, out)
}

/// Makes a medium; `radio`: the one whose silence is judged by the radio's parameters.
///
/// # Safety
/// `port` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_port_init(port: *mut lafet_port, radio: bool) {
    let source = if radio { Source::Radio } else { Source::ExternalConn };
    if !port.is_null() {
        // SAFETY: large enough and aligned, as asserted above; not null.
        unsafe { port.cast::<Port>().write(Port::new(source)) }
    }
}

/// Takes bytes until a frame for the monitor is complete; returns how many. `*answer` becomes
/// the size of the answer in `out` (`LAFET_WIRE_MAX` suffices), 0 if there is none. Call it
/// again with the rest.
///
/// # Safety
/// Port and device were initialised; sizes are those of their buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_port_receive(
    port: *mut lafet_port,
    now_ms: u32,
    device: *mut lafet_device,
    data: *const u8,
    size: usize,
    out: *mut u8,
    out_size: usize,
    answer: *mut usize,
) -> usize {
    // SAFETY: the caller's promise.
    let (port, kept) = unsafe { (port.cast::<Port>().as_mut(), device.cast::<Kept>().as_mut()) };
    // SAFETY: the caller's promise.
    let (data, out) = unsafe { (bytes(data, size), room(out, out_size)) };
    // SAFETY: null or writable, says the caller.
    let answer = unsafe { answer.as_mut() };
    let (Some(port), Some(kept), Some(answer)) = (port, kept, answer) else { return 0 };
    let (Some(data), Some(out)) = (data, out) else { return 0 };
    let (taken, len) = port.receive(now_ms, &mut kept.device, data, out);
    *answer = len;
    taken
}
