//! rmodbus: the same values in registers. RTU with its CRC, and without (as over TCP) for the device.

use rmodbus::client::ModbusRequest;
use rmodbus::server::ModbusFrame;
use rmodbus::server::storage::ModbusStorageSmall;
use rmodbus::{ModbusProto, server::context::ModbusContext};

use crate::case;
use crate::case::Case;

/// A drive's status and that of a whole monitor, in registers.
const DRIVE: u16 = 4;
const WHOLE: u16 = 45;
const UNIT: u8 = 1;

pub fn cases() -> Vec<Case> {
    let drive = || State::new(ModbusProto::Rtu, DRIVE);
    let whole = || State::new(ModbusProto::Rtu, WHOLE);
    let tcp = || State::new(ModbusProto::TcpUdp, DRIVE);
    let seen: fn(&State) -> bool = |state| state.registers.last() == Some(&state.last());
    let made: fn(&State) -> bool = |state| state.out == state.answer;
    vec![
        case!(rmodbus::drive_receive, drive().answer.len(), drive(), seen),
        case!(rmodbus::whole_receive, whole().answer.len(), whole(), seen),
        case!(rmodbus::answer_framed, drive().request_len, drive(), made),
        case!(rmodbus::answer_core, tcp().request_len, tcp(), made),
        case!(
            rmodbus::answer_whole,
            tcp().request_len,
            State::new(ModbusProto::TcpUdp, WHOLE),
            made
        ),
    ]
}

struct State {
    storage: Box<ModbusStorageSmall>,
    asked: ModbusRequest,
    proto: ModbusProto,
    count: u16,
    request: [u8; 256],
    request_len: usize,
    answer: Vec<u8>,
    out: Vec<u8>,
    registers: Vec<u16>,
}

impl State {
    fn new(proto: ModbusProto, count: u16) -> Self {
        let mut storage = Box::new(ModbusStorageSmall::new());
        for register in 0..count {
            storage.set_holding(register, 0x4100 + register).expect("a register");
        }
        let mut asked = ModbusRequest::new(UNIT, proto);
        let mut bytes = Vec::new();
        asked.generate_get_holdings(0, count, &mut bytes).expect("room");
        let mut request = [0; 256];
        request[..bytes.len()].copy_from_slice(&bytes);
        let request_len = bytes.len();
        let (out, registers) = (Vec::with_capacity(256), Vec::with_capacity(128));
        let answer = Vec::new();
        let mut state =
            Self { storage, asked, proto, count, request, request_len, answer, out, registers };
        serve(&mut state);
        state.answer = state.out.clone();
        state
    }

    fn last(&self) -> u16 {
        0x4100 + self.count - 1
    }
}

#[inline(always)]
fn serve(state: &mut State) {
    state.out.clear();
    let mut frame = ModbusFrame::new(UNIT, &state.request, state.proto, &mut state.out);
    let read = frame.parse().and_then(|()| frame.process_read(state.storage.as_ref()));
    // What fails leaves an answer that is not the expected one.
    let _ = read.and_then(|()| frame.finalize_response());
}

#[inline(never)]
fn answer_framed(state: &mut State) {
    serve(state);
}

#[inline(never)]
fn answer_core(state: &mut State) {
    serve(state);
    state.registers.clear();
}

#[inline(never)]
fn answer_whole(state: &mut State) {
    serve(state);
    state.count = WHOLE;
}

#[inline(always)]
fn parse(state: &mut State) {
    state.registers.clear();
    let _ = state.asked.parse_u16(&state.answer, &mut state.registers);
}

#[inline(never)]
fn drive_receive(state: &mut State) {
    parse(state);
}

#[inline(never)]
fn whole_receive(state: &mut State) {
    parse(state);
    state.count = WHOLE;
}
