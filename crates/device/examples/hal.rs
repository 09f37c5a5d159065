//! A board for the monitor's program: everything that [`Hal`] asks for, on a plant of a few lines.
//!
//! ```sh
//! cargo run -p lafet-device --example hal
//! ```
//!
//! On a real board `read` samples encoders, switches and currents, `write` feeds power stages,
//! `Storage` is flash memory (`lafet_device::store::Store` makes one of any NOR flash), and a timer
//! calls `step` every few milliseconds.

use std::collections::BTreeMap;

use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{AXES, Axis, Inputs, Outputs, ValveOutput};
use lafet_device::port::Port;
use lafet_device::{Composition, Device, Source};
use lafet_proto::link::{Frame, WIRE_MAX, decode_datagram, encode};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, Status, SubsystemId};

const MONITOR: u8 = 1;
const CONSOLE: u8 = 129;
const STEP_MS: u32 = 10;
/// What a drive travels in a millisecond at a speed of 1: a thousandth of 6 ' (0.1 °) or of 0.1 mm.
const ANGLE_PER_MS: i64 = 6;
const NOZZLE_PER_MS: i64 = 1;

/// What is on a real board wires, and here numbers.
#[derive(Default)]
struct Board {
    /// Where the drives are, thousandths of an arc-minute; of the nozzle ten-thousandths of a mm.
    positions: [i64; AXES],
    driven: Outputs,
    memory: BTreeMap<Key, Vec<u8>>,
    reset: bool,
}

impl Hal for Board {
    fn read(&mut self, inputs: &mut Inputs) {
        for (index, input) in inputs.drives.iter_mut().enumerate() {
            let unit = if index == Axis::Nozzle as usize { 10_000 } else { 1000 };
            input.position = (self.positions[index] / unit) as i32;
            input.speed_tenths = self.driven.drives[index].speed_tenths;
            input.current_da = if input.speed_tenths == 0 { 0 } else { 20 };
        }
        for (input, output) in inputs.valves.iter_mut().zip(&self.driven.valves) {
            input.open_switch = *output == ValveOutput::Opening;
            input.close_switch = !input.open_switch;
        }
        inputs.places.iter_mut().for_each(|place| place.temperature_dc = Some(200));
        inputs.humidity_percent = Some(40);
        inputs.main_voltage_dv = 240;
        inputs.pressure_ua = 4000;
    }

    fn write(&mut self, outputs: &Passed) {
        self.driven = *outputs.outputs();
    }

    fn reset(&mut self) {
        self.reset = true;
    }
}

impl Storage for Board {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let Some(value) = self.memory.get(&key) else { return Ok(None) };
        let place = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        place.copy_from_slice(value);
        Ok(Some(place))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.memory.insert(key, value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.memory.clear();
        Ok(())
    }
}

/// A monitor without deployment on this board, with its clock.
struct Monitor {
    board: Board,
    device: Device,
    line: Port,
    now_ms: u32,
}

impl Monitor {
    fn new() -> Self {
        let mut board = Board::default();
        Device::provision(&mut board, &Composition::REMOTE, MONITOR).expect("an empty memory");
        let device = Device::power_up(0, &Composition::REMOTE, MONITOR, None, &mut board);
        Self { board, device, line: Port::new(Source::ExternalConn), now_ms: 0 }
    }

    fn step(&mut self) {
        self.now_ms += STEP_MS;
        for (index, drive) in self.board.driven.drives.iter().enumerate() {
            let nozzle = index == Axis::Nozzle as usize;
            let per_ms = if nozzle { NOZZLE_PER_MS } else { ANGLE_PER_MS };
            let travel = i64::from(drive.speed_tenths) * per_ms * i64::from(STEP_MS);
            self.board.positions[index] += travel;
        }
        self.device.step(self.now_ms, &mut self.board);
        if std::mem::take(&mut self.board.reset) {
            let (now, board) = (self.now_ms, &mut self.board);
            self.device = Device::power_up(now, &Composition::REMOTE, MONITOR, None, board);
        }
    }

    /// The status that a request is answered with, as a console on the line sees it.
    fn ask(&mut self, request: &Request<'_>) -> Option<Status> {
        let (mut payload, mut wire, mut answer) = ([0; 64], [0; WIRE_MAX], [0; WIRE_MAX]);
        let mut records = Writer::new(&mut payload);
        request.encode(&mut records).ok()?;
        let frame = Frame { dst: MONITOR, src: CONSOLE, payload: records.written() };
        let len = encode(&frame, &mut wire)?;
        let (_, len) = self.line.receive(self.now_ms, &mut self.device, &wire[..len], &mut answer);
        let mut body = [0; WIRE_MAX];
        let frame = decode_datagram(&answer[..len], &mut body).ok()?;
        Records::new(frame.payload).next()?.ok().map(|record| record.status)
    }

    /// Moves elevation, and returns where it came to rest, '.
    fn elevate(&mut self, destination: i16) -> (Option<Status>, i32) {
        let status = self.ask(&Request::new(SubsystemId::VERTICAL, Body::Move { destination }));
        self.step();
        while !self.device.outputs().is_still() {
            self.step();
        }
        (status, self.device.inputs().drives[Axis::Vertical as usize].position)
    }
}

fn main() {
    let mut monitor = Monitor::new();
    while monitor.now_ms < 1000 {
        monitor.step();
    }
    let (status, position) = monitor.elevate(600);
    let status = status.expect("an answer");
    println!("Move Vertical 600: {status}; at {position}' after {} ms", monitor.now_ms);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drive_arrives_and_stays() {
        let mut monitor = Monitor::new();
        while monitor.now_ms < 1000 {
            monitor.step();
            assert!(monitor.board.driven.is_still(), "inert until it is asked");
        }
        let (status, position) = monitor.elevate(600);
        assert!(status.is_some_and(Status::is_success), "{status:?}");
        assert!((598..=602).contains(&position), "{position}");
        for _ in 0..100 {
            monitor.step();
            assert!(monitor.board.driven.is_still());
        }
        assert!(monitor.ask(&Request::open(SubsystemId::VERTICAL)) == Some(Status::WRONG_REQUEST));
    }
}
