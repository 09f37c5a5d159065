//! lafet: records, link frames, and the device that answers them.

use std::collections::BTreeMap;

use lafet_device::guard::Passed;
use lafet_device::{Composition, Device};

use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::Inputs;
use lafet_device::port::Port;
use lafet_device::subsystem::conn::Source;
use lafet_proto::answer::Reply;
use lafet_proto::flags::*;
use lafet_proto::link::{self, Check, Decoder, Frame};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::{Body, Request};
use lafet_proto::status::*;
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

use crate::case;
use crate::case::Case;
use crate::client;
use crate::values::{Drive, ROOM, Whole};

const GET_STATUS: RequestId = RequestId::GET_STATUS;
const MONITOR: u8 = 1;
const CONSOLE: u8 = 129;

/// Cases of the codec, of the device and of the client.
pub fn cases() -> Vec<Case> {
    let drive = payload(&[drive_answer(&Drive::SAMPLE)]);
    let whole = payload(&whole_answers(&Whole::SAMPLE));
    let eleven = payload(&eleven_answers());
    let (drive_size, whole_size, eleven_size) = (drive.len(), whole.len(), eleven.len());
    assert_eq!((drive_size, whole_size, eleven_size), (Drive::SIZE, Whole::SIZE, 142));
    let framed = |payload: &[u8]| {
        let mut bytes = [0; ROOM];
        let frame = Frame { dst: CONSOLE, src: MONITOR, payload };
        let len = link::encode(&frame, &mut bytes).expect("room");
        bytes[..len].to_vec()
    };
    let (drive_frame, whole_frame) = (framed(&drive), framed(&whole));
    let (drive_wire, whole_wire) = (drive_frame.len(), whole_frame.len());
    let seen_drive = |state: &State| state.drive == Drive::SAMPLE;
    let seen_whole = |state: &State| state.whole == Whole::SAMPLE;
    let made = |state: &State| state.out[..state.len] == state.input[..];
    let answered = |state: &Asked| state.answer == Drive::SIZE;
    let framed_answer = |state: &Asked| state.answer == Drive::SIZE + 7;
    let all_answered = |state: &Asked| state.answer == Whole::SIZE;
    let mut cases = vec![
        case!(lafet::drive_decode, drive_size, State::blank(&drive), seen_drive),
        case!(lafet::drive_encode, drive_size, State::new(&drive), made),
        case!(lafet::whole_decode, whole_size, State::blank(&whole), seen_whole),
        case!(lafet::whole_encode, whole_size, State::new(&whole), made),
        case!(lafet::eleven_decode, eleven_size, State::new(&eleven), |s| s.sum == 11),
        case!(lafet::drive_receive, drive_wire, State::blank(&drive_frame), seen_drive),
        case!(lafet::drive_send, drive_wire, State::new(&drive_frame), made),
        case!(lafet::whole_receive, whole_wire, State::blank(&whole_frame), seen_whole),
        case!(lafet::whole_send, whole_wire, State::new(&whole_frame), made),
        case!(lafet::answer_core, 4, Asked::new(SubsystemId::VERTICAL), answered),
        case!(lafet::answer_framed, 11, Asked::new(SubsystemId::VERTICAL), framed_answer),
        case!(lafet::answer_whole, 4, Asked::new(SubsystemId::ALL), all_answered),
    ];
    cases.extend(client::cases(&drive_frame));
    cases
}

struct State {
    input: Vec<u8>,
    out: [u8; ROOM],
    len: usize,
    drive: Drive,
    whole: Whole,
    sum: u32,
    decoder: Decoder,
}

impl State {
    fn new(input: &[u8]) -> Self {
        Self {
            input: input.to_vec(),
            out: [0; ROOM],
            len: 0,
            drive: Drive::SAMPLE,
            whole: Whole::SAMPLE,
            sum: 0,
            decoder: Decoder::new(),
        }
    }

    /// One that has seen nothing yet.
    fn blank(input: &[u8]) -> Self {
        Self { drive: Drive::default(), whole: Whole::default(), ..Self::new(input) }
    }
}

#[inline(never)]
fn drive_decode(state: &mut State) {
    read_drive(&state.input, &mut state.drive);
}

#[inline(never)]
fn drive_encode(state: &mut State) {
    let mut writer = Writer::new(&mut state.out);
    if drive_answer(&state.drive).encode(&mut writer).is_ok() {
        state.len = writer.len();
    }
}

#[inline(never)]
fn whole_decode(state: &mut State) {
    read_whole(&state.input, &mut state.whole);
}

#[inline(never)]
fn whole_encode(state: &mut State) {
    let mut writer = Writer::new(&mut state.out);
    for answer in &whole_answers(&state.whole) {
        if answer.encode(&mut writer).is_err() {
            return;
        }
    }
    state.len = writer.len();
}

/// 11 records, 142 bytes; of each the number that a display would show first.
#[inline(never)]
fn eleven_decode(state: &mut State) {
    let mut sum = 0;
    for record in Records::new(&state.input) {
        let Ok(answer) = record.and_then(|record| Answer::decode(&record)) else { return };
        match answer.data {
            Reply::General(status) => sum += u32::from(status.main_voltage / 24),
            Reply::Thermo(status) => sum += u32::from(status.humidity / 41),
            Reply::Drive(status) => sum += u32::from(status.speed / 9),
            Reply::Deployer(status) => sum += u32::from(status.speed + 1),
            Reply::Limits(limits) => sum += (limits.max - limits.min) as u32,
            _ => return,
        }
    }
    state.sum = sum;
}

#[inline(never)]
fn drive_receive(state: &mut State) {
    let (_, frame) = state.decoder.push_slice(&state.input);
    if let Some(frame) = frame {
        read_drive(frame.payload, &mut state.drive);
    }
}

#[inline(never)]
fn drive_send(state: &mut State) {
    let answer = drive_answer(&state.drive);
    state.len = send(&mut state.out, &[answer]);
}

#[inline(never)]
fn whole_receive(state: &mut State) {
    let (_, frame) = state.decoder.push_slice(&state.input);
    if let Some(frame) = frame {
        read_whole(frame.payload, &mut state.whole);
    }
}

#[inline(never)]
fn whole_send(state: &mut State) {
    let answers = whole_answers(&state.whole);
    state.len = send(&mut state.out, &answers);
}

#[inline(always)]
fn send(out: &mut [u8], answers: &[Answer<'_>]) -> usize {
    let len = link::compose(Check::Crc16, CONSOLE, MONITOR, out, |place| {
        let mut writer = Writer::new(place);
        answers.iter().try_for_each(|answer| answer.encode(&mut writer)).ok()?;
        Some(writer.len())
    });
    len.unwrap_or(0)
}

#[inline(always)]
fn read_drive(payload: &[u8], seen: &mut Drive) {
    let Some(Ok(record)) = Records::new(payload).next() else { return };
    let Ok(answer) = Answer::decode(&record) else { return };
    if let Reply::Drive(DriveStatus { flags, position, current, speed }) = answer.data {
        *seen = Drive {
            request: answer.request.0,
            device: answer.from.0,
            status: answer.status.0,
            flags: flags.bits(),
            position,
            current,
            speed,
        };
    }
}

#[inline(always)]
fn read_whole(payload: &[u8], seen: &mut Whole) {
    let ([mut drives, mut flags], mut whole) = ([0; 2], Whole::default());
    for record in Records::new(payload) {
        let Ok(record) = record else { return };
        let Ok(answer) = Answer::decode(&record) else { return };
        let bits = match answer.data {
            Reply::General(status) => {
                whole.general_flags = status.flags.bits();
                whole.general = [status.main_voltage, status.pressure, status.flowrate];
                continue;
            }
            Reply::Thermo(s) => {
                whole.climatics_flags = s.flags.bits();
                let humidity = s.humidity as i16;
                whole.climatics =
                    [s.horizontal, s.vertical, s.nozzle, s.deployer, s.housing, humidity];
                continue;
            }
            Reply::Drive(s) => {
                let Some(place) = whole.drives.get_mut(drives) else { return };
                *place = (s.flags.bits(), s.position, s.current, s.speed);
                drives += 1;
                continue;
            }
            Reply::Deployer(s) => {
                let Some(place) = whole.drives.get_mut(drives) else { return };
                *place = (s.flags.bits(), s.position, s.current, s.speed);
                drives += 1;
                continue;
            }
            Reply::Valve(status) => status.flags.bits(),
            Reply::Control(status) => status.flags.bits(),
            Reply::Detector(status) => status.flags.bits(),
            Reply::Conn(status) => status.flags.bits(),
            Reply::Buttons(status) => status.flags.bits(),
            _ => return,
        };
        let Some(place) = whole.flags.get_mut(flags) else { return };
        *place = bits;
        flags += 1;
    }
    *seen = whole;
}

#[inline(always)]
fn drive_answer(drive: &Drive) -> Answer<'static> {
    let flags = DriveFlags::from_bits_retain(drive.flags);
    let &Drive { position, current, speed, .. } = drive;
    Answer {
        from: SubsystemId(drive.device),
        request: RequestId(drive.request),
        status: Status(drive.status),
        data: Reply::Drive(DriveStatus { flags, position, current, speed }),
    }
}

#[inline(always)]
fn whole_answers(whole: &Whole) -> [Answer<'static>; 14] {
    let [main_voltage, pressure, flowrate] = whole.general;
    let [horizontal, vertical, nozzle, deployer, housing, humidity] = whole.climatics;
    let [v, h, n, d] = whole.drives;
    let [valve1, valve2, control, detector, external, radio, buttons, second] = whole.flags;
    let drive = |(flags, position, current, speed)| {
        let flags = DriveFlags::from_bits_retain(flags);
        Reply::Drive(DriveStatus { flags, position, current, speed })
    };
    let valve = |bits| Reply::Valve(ValveStatus { flags: ValveFlags::from_bits_retain(bits) });
    let conn = |bits| Reply::Conn(ConnStatus { flags: ConnFlags::from_bits_retain(bits) });
    let post = |bits| Reply::Buttons(ButtonsStatus { flags: ButtonsFlags::from_bits_retain(bits) });
    let folding = DeployerStatus {
        flags: DeployerFlags::from_bits_retain(d.0),
        position: d.1,
        current: d.2,
        speed: d.3,
    };
    let climate = ThermoStatus {
        flags: ClimaticsFlags::from_bits_retain(whole.climatics_flags),
        horizontal,
        vertical,
        nozzle,
        deployer,
        housing,
        humidity: humidity as u16,
    };
    let general = GeneralStatus {
        flags: GeneralFlags::from_bits_retain(whole.general_flags),
        main_voltage,
        pressure,
        flowrate,
    };
    let control = ControlStatus { flags: ControlFlags::from_bits_retain(control) };
    let detector = DetectorStatus { flags: DetectorFlags::from_bits_retain(detector) };
    [
        ok(SubsystemId::GENERAL, GET_STATUS, Reply::General(general)),
        ok(SubsystemId::CLIMATICS, GET_STATUS, Reply::Thermo(climate)),
        ok(SubsystemId::VERTICAL, GET_STATUS, drive(v)),
        ok(SubsystemId::HORIZONTAL, GET_STATUS, drive(h)),
        ok(SubsystemId::NOZZLE, GET_STATUS, drive(n)),
        ok(SubsystemId::DEPLOYER, GET_STATUS, Reply::Deployer(folding)),
        ok(SubsystemId::VALVE1, GET_STATUS, valve(valve1)),
        ok(SubsystemId::VALVE2, GET_STATUS, valve(valve2)),
        ok(SubsystemId::CONTROL, GET_STATUS, Reply::Control(control)),
        ok(SubsystemId::DETECTOR, GET_STATUS, Reply::Detector(detector)),
        ok(SubsystemId::EXTERNAL_CONN, GET_STATUS, conn(external)),
        ok(SubsystemId::RADIO, GET_STATUS, conn(radio)),
        ok(SubsystemId::BUTTONS, GET_STATUS, post(buttons)),
        ok(SubsystemId::EXT_BUTTONS, GET_STATUS, post(second)),
    ]
}

/// General, Climatics, six answers of drives, and the limits of three.
fn eleven_answers() -> Vec<Answer<'static>> {
    let whole = whole_answers(&Whole::SAMPLE);
    let limits =
        |from| ok(from, RequestId::RETRIEVE_LIMITS, Reply::Limits(Limits { min: 7, max: 8 }));
    let [general, climatics, mut vertical, .., _] = whole;
    if let Reply::Drive(status) = &mut vertical.data {
        status.speed = 9;
    }
    let mut answers = vec![general, climatics];
    answers.extend([vertical; 5]);
    answers.push(whole[5]);
    let aiming = [SubsystemId::VERTICAL, SubsystemId::HORIZONTAL, SubsystemId::NOZZLE];
    answers.extend(aiming.map(limits));
    answers
}

#[inline(always)]
const fn ok(from: SubsystemId, request: RequestId, data: Reply<'static>) -> Answer<'static> {
    Answer { from, request, status: Status::OK, data }
}

fn payload(answers: &[Answer<'_>]) -> Vec<u8> {
    let mut bytes = [0; ROOM];
    let mut writer = Writer::new(&mut bytes);
    for answer in answers {
        answer.encode(&mut writer).expect("room");
    }
    writer.written().to_vec()
}

/// A monitor that is asked.
struct Asked {
    device: Device,
    port: Port,
    payload: Vec<u8>,
    frame: Vec<u8>,
    out: [u8; link::WIRE_MAX],
    answer: usize,
}

impl Asked {
    fn new(to: SubsystemId) -> Self {
        let mut board = Board::default();
        Device::provision(&mut board, &Composition::FULL, MONITOR).expect("a store");
        let mut device = Device::power_up(0, &Composition::FULL, MONITOR, None, &mut board);
        (1..100).for_each(|step| device.step(step * 10, &mut board));
        let mut bytes = [0; 16];
        let mut writer = Writer::new(&mut bytes);
        Request { to, body: Body::GetStatus }.encode(&mut writer).expect("room");
        let payload = writer.written().to_vec();
        let mut frame = [0; 32];
        let asking = Frame { dst: MONITOR, src: CONSOLE, payload: &payload };
        let len = link::encode(&asking, &mut frame).expect("room");
        Self {
            device,
            port: Port::new(Source::ExternalConn),
            payload,
            frame: frame[..len].to_vec(),
            out: [0; link::WIRE_MAX],
            answer: 0,
        }
    }
}

#[inline(never)]
fn answer_core(state: &mut Asked) {
    let Asked { device, payload, out, .. } = state;
    state.answer = device.handle(1_000, Source::ExternalConn, payload, out);
}

#[inline(never)]
fn answer_whole(state: &mut Asked) {
    let Asked { device, payload, out, .. } = state;
    state.answer = device.handle(2_000, Source::ExternalConn, payload, out);
}

#[inline(never)]
fn answer_framed(state: &mut Asked) {
    let Asked { device, port, frame, out, .. } = state;
    state.answer = port.receive(1_000, device, frame, out).1;
}

/// No hardware, and a store.
#[derive(Default)]
struct Board {
    store: BTreeMap<u16, Vec<u8>>,
}

impl Storage for Board {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let Some(value) = self.store.get(&key.0) else { return Ok(None) };
        let place = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        place.copy_from_slice(value);
        Ok(Some(place))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.store.insert(key.0, value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.store.clear();
        Ok(())
    }
}

impl Hal for Board {
    fn read(&mut self, _: &mut Inputs) {}
    fn write(&mut self, _: &Passed) {}
    fn reset(&mut self) {}
}
