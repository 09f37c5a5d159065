//! Modbus RTU on the same simulated line: a master that reads all registers of each device by turns.

use std::time::Duration;

use lafet_sim::line::{Line, Noise};
use rmodbus::client::ModbusRequest;
use rmodbus::server::ModbusFrame;
use rmodbus::server::context::ModbusContext;
use rmodbus::server::storage::ModbusStorageSmall;
use rmodbus::{ModbusFrameBuf, ModbusProto};

/// Silence that ends a frame above 19200 baud (Modbus over serial line V1.02, 2.5.1.1).
const SILENCE_NS: u64 = 1_750_000;
const MASTER: usize = 0;

/// What was seen of some rounds.
pub struct Seen {
    pub cycle: Duration,
    pub registers: usize,
    /// Share of the line's time in which it is busy.
    pub share: f64,
}

/// Polls devices that have so many registers each; every answer is parsed and compared.
pub fn poll(baud: u32, devices: u8, registers: u16, rounds: u32) -> Seen {
    let mut line = Line::new(baud, 1 + usize::from(devices), Noise::default(), 7);
    let memories: Vec<_> = (1..=devices).map(|unit| memory(unit, registers)).collect();
    let mut read = 0;
    for _ in 0..rounds {
        for (unit, memory) in (1..=devices).zip(&memories) {
            let mut request = ModbusRequest::new(unit, ModbusProto::Rtu);
            let mut frame = Vec::new();
            request.generate_get_holdings(0, registers, &mut frame).expect("it fits");
            let heard = send(&mut line, MASTER, &frame, unit.into());
            let answer = send(&mut line, unit.into(), &serve(unit, &heard, memory), MASTER);
            let mut values: Vec<u16> = Vec::new();
            request.parse_u16(&answer, &mut values).expect("a sound answer");
            assert!(values.iter().all(|value| *value == u16::from(unit)), "unit {unit}");
            read += values.len();
        }
    }
    let time = Duration::from_nanos(line.now_ns());
    let share = line.busy_ns() as f64 / line.now_ns() as f64;
    Seen { cycle: time / rounds, registers: read / rounds as usize, share }
}

fn memory(unit: u8, registers: u16) -> ModbusStorageSmall {
    let mut memory = ModbusStorageSmall::default();
    for register in 0..registers {
        memory.set_holding(register, unit.into()).expect("there is room");
    }
    memory
}

/// The silence that ends the frame before, then this one; what a station hears of it.
fn send(line: &mut Line, from: usize, bytes: &[u8], to: usize) -> Vec<u8> {
    line.send(from, line.now_ns() + SILENCE_NS, bytes);
    let mut heard = Vec::new();
    while line.step(|station, byte| {
        if station == to {
            heard.push(byte.byte);
        }
    }) {}
    heard
}

fn serve(unit: u8, request: &[u8], memory: &ModbusStorageSmall) -> Vec<u8> {
    let mut buffer: ModbusFrameBuf = [0; 256];
    buffer[..request.len()].copy_from_slice(request);
    let mut answer = Vec::new();
    let mut frame = ModbusFrame::new(unit, &buffer, ModbusProto::Rtu, &mut answer);
    frame.parse().expect("a sound request");
    frame.process_read(memory).expect("registers that exist");
    frame.finalize_response().expect("it fits");
    answer
}
