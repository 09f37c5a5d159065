//! A monitor over time: frames, bytes, buttons, sensors with any values, a clock that jumps and
//! wraps, a memory that fails. Answers must be whole, outputs legal, and nothing may panic.

mod board;
mod rules;

use crate::fuzz::feed::Feed;
use crate::interlock::Moment;
use board::Board;
use lafet_device::image::{AXES, Axis, Outputs};
use lafet_device::port::{Port, Probes, RecordPort};
use lafet_device::{Composition, Device, Source};
use lafet_proto::answer::Reply;
use lafet_proto::dictionary::{REQUESTS, SUBSYSTEMS};
use lafet_proto::flags::{DriveFlags, GeneralFlags};
use lafet_proto::link::{self, Frame, PAYLOAD_MAX, WIRE_MAX};
use lafet_proto::record::{DATA_MAX, HEADER_SIZE, Record, Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::FaultInfo;
use lafet_proto::{Answer, Request, RequestId, Status, SubsystemId, text};
use rules::Said;

const ADDRESS: u8 = 1;
const CLIENT: u8 = 200;
/// Most steps of an input.
const STEPS: u32 = 1_000;
/// Earliest end of power-up, ms.
const SETTLE_MS: u64 = 100;

/// Nothing is driven; a supply that was cut stays so, for a shorted stage turns its drive without being driven.
fn inert(before: &Outputs) -> Outputs {
    let mut inert = Outputs::default();
    for (drive, before) in inert.drives.iter_mut().zip(&before.drives) {
        drive.cut = before.cut;
    }
    inert
}

/// Requests that are accepted in some state; other requests come from the bytes of the input.
const USUAL: [&str; 40] = [
    "Deploy",
    "Wrap",
    "Move Vertical 900",
    "Move Vertical -21600",
    "Move Horizontal 21600",
    "Move Nozzle 20",
    "Move Deployer 2700",
    "Stop All",
    "Stop Motors",
    "Stop Deployer",
    "Stop Detector",
    "Stop Control",
    "Open Valve1",
    "Open Valve2",
    "Close Valve1",
    "Close Valve2",
    "StartJustify",
    "StartSeek -600 600 -100 300",
    "StartSeek -600 600 -100 300 analyse",
    "StartQuench program=0 centre=600,-100 nozzle=60",
    "StartQuench centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25",
    "StartQuench centre=0,0 nozzle=60 sector=24000,6000 step=0 distance=0",
    "StartQuench centre=0,0 nozzle=60 sector=60,60 step=1 corrections=0,1,2,3",
    "StartTrajectory ballistics repeat point=0,0,20,10 point=600,0,25,10",
    "StartTrajectory stored=0,7",
    "SwitchLimits Motors off",
    "SwitchLimits Motors on",
    "SwitchLimits All reject",
    "Lockout on",
    "Lockout off",
    "Restart",
    "CleanFlash",
    "GetCrashData General",
    "GetHotbed",
    "SetParam General MoveTimeout 500",
    "SetParam General ResetValves 1",
    "SetParam Control Program0 0 0 60 600 300 1 25",
    "SetParam Control Trajectory0 0 0 20 10 600 0 25 10",
    "SetParam Horizontal Speed 90",
    "SetupCorrectionTable first=0 corrections=0,0,1,1,2",
];

pub fn run(input: &[u8]) -> u64 {
    let mut feed = Feed::new(input);
    let mut run = Run::new(&mut feed);
    while !feed.is_empty() && run.steps < STEPS {
        run.act(&mut feed);
    }
    run.step(10);
    run.board.calls
}

struct Run {
    device: Device,
    board: Board,
    composition: Composition,
    now_ms: u32,
    /// Clock of the last step, ms.
    stepped_ms: u32,
    /// Time since power-up as the steps see it, ms; a jump of the clock lengthens it.
    powered_ms: u64,
    steps: u32,
    ports: [Port; 2],
    records: RecordPort,
}

impl Run {
    fn new(feed: &mut Feed<'_>) -> Self {
        let composition = Composition::ALL[feed.below(Composition::ALL.len())];
        let start = feed.u8();
        let now_ms = if start & 1 == 0 { 0 } else { feed.u32() };
        let mut board = Board::new(&composition, start & 2 != 0);
        if start & 4 == 0 {
            Device::provision(&mut board, &composition, ADDRESS).expect("the memory takes all");
        }
        let device = Device::power_up(now_ms, &composition, ADDRESS, None, &mut board);
        let ports = [Port::new(Source::ExternalConn), Port::new(Source::Radio)];
        let records = RecordPort::new(Source::Radio);
        let mut run = Self {
            device,
            board,
            composition,
            now_ms,
            stepped_ms: now_ms,
            powered_ms: 0,
            steps: 0,
            ports,
            records,
        };
        if start & 8 == 0 {
            run.steps(20, 10);
        }
        run
    }

    fn act(&mut self, feed: &mut Feed<'_>) {
        match feed.u8() % 20 {
            0..=2 => {
                let count = 1 + feed.below(60);
                let dt_ms = [1, 10, 10, 50, 100, 300][feed.below(6)];
                self.steps(count, dt_ms);
            }
            3..=6 => self.request(feed),
            7 => self.frame(feed),
            8 => self.wire(feed),
            9 => self.bytes(feed),
            10..=14 => self.board.disturb(feed),
            15 => self.board.disturb_memory(feed),
            16 => self.now_ms = self.now_ms.wrapping_add(feed.u32()),
            17 => {
                self.step(feed.u32());
            }
            18 => self.stop_all(),
            _ => self.power_cycle(feed),
        }
    }

    fn steps(&mut self, count: usize, dt_ms: u32) {
        for _ in 0..count {
            self.step(dt_ms);
        }
    }

    /// Runs one step, and checks everything that can be checked after it.
    fn step(&mut self, dt_ms: u32) -> Outputs {
        if self.steps >= STEPS {
            return Outputs::default();
        }
        self.steps += 1;
        self.now_ms = self.now_ms.wrapping_add(dt_ms);
        self.powered_ms += u64::from(self.now_ms.wrapping_sub(self.stepped_ms));
        self.stepped_ms = self.now_ms;
        self.board.advance(dt_ms.min(60_000));
        self.device.step(self.now_ms, &mut self.board);
        let said = self.said();
        let is_settled = self.powered_ms >= SETTLE_MS;
        let written = core::mem::take(&mut self.board.written);
        let Some(outputs) = written.first() else { panic!("nothing was driven") };
        rules::check(&self.device, &said, is_settled, &self.board.sampled, outputs);
        let inert = [inert(outputs)];
        if core::mem::take(&mut self.board.reset) {
            assert_eq!(written[1..], inert, "§D/1: not inert before a reset");
            self.start(None);
        } else if core::mem::take(&mut self.board.erase_failed) {
            // Outputs were inert during the erase; the reset itself does not follow.
            assert_eq!(written[1..], inert, "not inert before an erase");
        } else {
            assert_eq!(written.len(), 1, "driven more than once");
        }
        *outputs
    }

    /// What the monitor reports about itself; checks that two reads agree and are valid.
    fn said(&mut self) -> Said {
        const QUESTIONS: [u8; 8] = [
            RequestId::GET_STATUS.0,
            SubsystemId::ALL.0,
            0,
            0,
            RequestId::RETRIEVE_LIMITS.0,
            SubsystemId::ALL.0,
            0,
            0,
        ];
        let (mut first, mut second) = ([0; PAYLOAD_MAX], [0; PAYLOAD_MAX]);
        let len = self.device.handle(self.now_ms, Source::Radio, &QUESTIONS, &mut first);
        let again = self.device.handle(self.now_ms, Source::Radio, &QUESTIONS, &mut second);
        assert_eq!(first[..len], second[..again], "a read has changed something");
        let mut said = Said::default();
        let mut limitless = [false; AXES];
        for record in Records::new(&first[..len]) {
            let record = record.expect("whole records");
            let answer = Answer::decode(&record).expect("a valid answer");
            let axis = Axis::ALL.into_iter().find(|axis| axis.id() == answer.from);
            match (answer.data, axis) {
                (Reply::General(status), _) => {
                    said.is_locked = status.flags.contains(GeneralFlags::LOCKED_OUT);
                }
                (Reply::Drive(status), Some(axis)) => {
                    limitless[axis as usize] = status.flags.contains(DriveFlags::LIMITLESS);
                }
                (Reply::Limits(limits), Some(axis)) if !limitless[axis as usize] => {
                    said.limits[axis as usize] = Some(limits);
                }
                _ => {}
            }
        }
        said
    }

    /// A request from [`USUAL`], or any header with any data.
    fn record(feed: &mut Feed<'_>, payload: &mut Vec<u8>) {
        let choice = usize::from(feed.u8());
        let mut buffer = [0; text::BUFFER_SIZE];
        let body = match choice {
            _ if choice < 160 => {
                let text = USUAL[choice % USUAL.len()];
                let request = text::parse(text, &mut buffer).expect("a request");
                return push(payload, &request);
            }
            160..=199 => {
                let destination = feed.number().clamp(i16::MIN.into(), i16::MAX.into()) as i16;
                let body = Body::Move { destination };
                return push(payload, &Request::new(Axis::ALL[feed.below(AXES)].id(), body));
            }
            200..=229 => {
                let param = rules::param(usize::from(feed.u8()));
                let values = [feed.number()];
                let body = if feed.chance() {
                    Body::SetParam {
                        id: param.spec().id,
                        values: lafet_proto::Ints::Values(&values),
                    }
                } else {
                    Body::GetParam { id: param.spec().id }
                };
                return push(payload, &Request::new(param.spec().subsystem, body));
            }
            _ => feed.take(4),
        };
        let [request, device, status, len] =
            [0, 1, 2, 3].map(|index| body.get(index).copied().unwrap_or(0));
        let request = REQUESTS.get(usize::from(request)).map_or(request, |info| info.id.0);
        let device = SUBSYSTEMS.get(usize::from(device)).map_or(device, |info| info.id.0);
        payload.extend([request, device, status, len]);
        payload.extend_from_slice(feed.take(len.into()));
    }

    fn request(&mut self, feed: &mut Feed<'_>) {
        let mut payload = Vec::new();
        Self::record(feed, &mut payload);
        self.handle(&payload, PAYLOAD_MAX, Source::ExternalConn);
    }

    /// Several records, possibly cut short, and a smaller buffer for the answers.
    fn frame(&mut self, feed: &mut Feed<'_>) {
        let mut payload = Vec::new();
        let count = feed.below(12);
        (0..count).for_each(|_| Self::record(feed, &mut payload));
        let cut = usize::from(feed.u8() & 3);
        payload.truncate((payload.len() - cut.min(payload.len())).min(PAYLOAD_MAX));
        let room = if feed.chance() { PAYLOAD_MAX } else { 8 + usize::from(feed.u8()) };
        let source = if feed.chance() { Source::Radio } else { Source::ExternalConn };
        self.handle(&payload, room, source);
    }

    fn handle(&mut self, payload: &[u8], room: usize, source: Source) {
        let mut out = [0; PAYLOAD_MAX];
        let len = self.device.handle(self.now_ms, source, payload, &mut out[..room]);
        assert!(len <= room, "{len} bytes in room for {room}");
        whole_answer(payload, &out[..len]);
        assert!(self.board.written.is_empty(), "an answer drives nothing");
    }

    /// A frame on the wire, sometimes for another monitor, sometimes cut or damaged.
    fn wire(&mut self, feed: &mut Feed<'_>) {
        let mut payload = Vec::new();
        let count = feed.below(4);
        (0..count).for_each(|_| Self::record(feed, &mut payload));
        payload.truncate(PAYLOAD_MAX);
        let dst = if feed.below(8) == 0 { feed.u8() } else { self.device.address() };
        let frame = Frame { dst, src: CLIENT, payload: &payload };
        let mut wire = [0; WIRE_MAX];
        let len = link::encode(&frame, &mut wire).expect("room for the longest frame");
        let is_whole = feed.below(8) != 0;
        if !is_whole {
            wire[usize::from(feed.u16()) % len] ^= 1 + feed.u8() % 255;
        }
        let mut out = [0; WIRE_MAX];
        let expects = is_whole && dst == self.device.address() && dst != CLIENT;
        let now_ms = self.now_ms;
        let answer = lafet_device::port::datagram(
            now_ms,
            Source::Radio,
            &mut Probes::new(),
            &mut self.device,
            &wire[..len],
            &mut out,
        );
        assert!(answer.is_some() || !expects, "a frame without errors stays without an answer");
        if let (Some(len), true) = (answer, expects) {
            let mut body = [0; link::BODY_MAX];
            let answer = link::decode_datagram(&out[..len], &mut body).expect("a frame");
            assert_eq!((answer.dst, answer.src), (CLIENT, dst));
            whole_answer(&payload, answer.payload);
        }
        self.stream(feed.below(3), &wire[..len]);
    }

    fn bytes(&mut self, feed: &mut Feed<'_>) {
        let (port, len) = (feed.below(3), feed.below(64));
        let bytes = feed.take(len);
        self.stream(port, bytes);
    }

    /// Bytes of a connection: each answer to link frames is one frame.
    fn stream(&mut self, port: usize, mut bytes: &[u8]) {
        let mut out = [0; WIRE_MAX];
        while !bytes.is_empty() {
            let now_ms = self.now_ms;
            let (taken, len) = match self.ports.get_mut(port) {
                Some(port) => port.receive(now_ms, &mut self.device, bytes, &mut out),
                None => self.records.receive(now_ms, &mut self.device, bytes, &mut out),
            };
            assert!(taken > 0 && taken <= bytes.len(), "{taken} bytes taken");
            if port < self.ports.len() && len > 0 {
                let mut body = [0; link::BODY_MAX];
                let frame = link::decode_datagram(&out[..len], &mut body).expect("a frame");
                assert_eq!(frame.src, self.device.address());
            }
            bytes = &bytes[taken..];
        }
    }

    /// §3.2/1 After Stop All nothing is driven in the very next step, whatever was going on.
    fn stop_all(&mut self) {
        let mut payload = Vec::new();
        push(&mut payload, &Request::new(SubsystemId::ALL, Body::Stop));
        // A button pressed since the last step is a new command, not yet sampled when Stop is
        // answered.
        let is_same = self.board.inputs.buttons == self.board.sampled.buttons;
        self.handle(&payload, PAYLOAD_MAX, Source::ExternalConn);
        if self.steps >= STEPS {
            return;
        }
        let outputs = self.step(10);
        let broken = Moment { stopped: is_same, ..Moment::new(&outputs) }.judge();
        assert!(broken.is_empty(), "{broken:?}: {outputs:?}");
    }

    fn power_cycle(&mut self, feed: &mut Feed<'_>) {
        if feed.chance() {
            self.now_ms = feed.u32();
        }
        let crash = feed.chance().then(|| FaultInfo::from_words([feed.u32(); 20]));
        self.start(crash);
    }

    fn start(&mut self, crash: Option<FaultInfo>) {
        (self.powered_ms, self.stepped_ms) = (0, self.now_ms);
        let Self { device, board, composition, now_ms, .. } = self;
        *device = Device::power_up(*now_ms, composition, ADDRESS, crash, board);
        self.board.written.clear();
    }
}

fn push(payload: &mut Vec<u8>, request: &Request<'_>) {
    let mut buffer = [0; HEADER_SIZE + DATA_MAX];
    let mut writer = Writer::new(&mut buffer);
    request.encode(&mut writer).expect("room for the longest record");
    payload.extend_from_slice(writer.written());
}

/// §1/10 Everything is answered, in whole and valid records.
fn whole_answer(payload: &[u8], answer: &[u8]) {
    assert_eq!(payload.is_empty(), answer.is_empty(), "§1/10: {payload:02x?} → {answer:02x?}");
    for record in Records::new(answer) {
        let Record { request, device, status, data } = record.expect("§1/10: half an answer");
        let record = Record { request, device, status, data };
        assert!(Answer::decode(&record).is_ok(), "{record:02x?}");
        assert!(status.0 <= Status::NOT_SUPPORTED.0, "{record:02x?}");
    }
}
