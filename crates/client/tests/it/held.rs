//! A motion by hand ends by itself when whatever held it is gone, on a simulated monitor and on
//! virtual time: each moment, each line, and the motion as smooth as one Move to the limit.

use std::time::Duration;

use lafet_client::session::jog::JogCore;
use lafet_client::session::line::Line;
use lafet_client::session::{Outcome, Slot, Terms, Ticket};
use lafet_client::{Config, Error, Hold, RequestBuf, Toward};
use lafet_device::Source;
use lafet_device::image::Axis;
use lafet_proto::link::{Decoder, Frame, encode, wire_max};
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Ints, Request, SubsystemId};
use lafet_sim::sim::{self, Sim};

const MS: Duration = Duration::from_millis(1);
const DRIVE: SubsystemId = SubsystemId::HORIZONTAL;
/// The hub looks at all subsystems so often.
const POLL_MS: u64 = 200;
/// Moments at which the holder vanishes, on each line, in the ordinary test.
const MOMENTS: u32 = 300;

/// A line between client and monitor.
#[derive(Clone, Copy, Debug)]
struct Wire {
    baud: u64,
    latency_ms: u64,
    loss_permille: u64,
    /// The monitor knows MoveHold.
    has_hold: bool,
    /// Everything is at rest so long after the holder has vanished, ms.
    bound_ms: u64,
    /// And not further from where the drive was then, arc-minutes.
    way_max: i32,
}

const TCP: Wire = Wire {
    baud: 100_000_000,
    latency_ms: 1,
    loss_permille: 0,
    has_hold: true,
    bound_ms: 500,
    way_max: 500,
};
const FAST: Wire = Wire { baud: 57_600, ..TCP };
const USUAL: Wire = Wire { baud: 19_200, ..TCP };
/// In flight 440 ms, MoveHold of two and a half round trips, and the Stop of the drive.
const RADIO: Wire = Wire { latency_ms: 400, bound_ms: 3000, way_max: 3300, ..USUAL };
const LOSSY: Wire = Wire { loss_permille: 20, ..FAST };
/// Its own braking, which is not hurried: 20 °/s at 22 °/s² and the approach.
const WITHOUT: Wire = Wire { has_hold: false, bound_ms: 2200, way_max: 1000, ..TCP };

struct World {
    wire: Wire,
    now: u64,
    sim: Sim,
    line: Line,
    core: Option<JogCore>,
    pending: Option<(Ticket, Vec<RequestBuf>)>,
    poll: Option<Ticket>,
    decoder: Decoder,
    /// Both directions: when, and what arrives.
    down: Vec<(u64, Vec<u8>)>,
    up: Vec<(u64, Vec<u8>)>,
    /// Until when the line carries bytes, µs.
    busy_us: u64,
    seed: u64,
    speeds: Vec<i16>,
}

/// A monitor that has deployed and is at rest.
fn deployed() -> Sim {
    let mut sim = Sim::new(sim::Config::default());
    sim.advance_ms(200);
    sim.ask(SubsystemId::DEPLOYER, Body::Deploy, |answer| assert!(answer.status.is_success()));
    sim.advance_ms(20_000);
    sim
}

impl World {
    fn new(wire: Wire, sim: &Sim, seed: u64) -> Self {
        let timeout = MS * (1000 + 3 * wire.latency_ms as u32);
        let first_number = Some(seed as u32);
        let mut line = Line::new(Config { timeout, first_number, ..Config::default() });
        line.handle_connected(Duration::ZERO);
        let (down, up, speeds) = (Vec::new(), Vec::new(), Vec::new());
        let (core, pending, poll, decoder) = (None, None, None, Decoder::new());
        let (now, busy_us, sim) = (0, 0, sim.clone());
        Self { wire, now, sim, line, core, pending, poll, decoder, down, up, busy_us, seed, speeds }
    }

    fn chance(&mut self) -> u64 {
        self.seed = self.seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.seed >> 33
    }

    fn time(&self) -> Duration {
        MS * self.now as u32
    }

    /// When bytes that are sent now have arrived; `None`: they are lost.
    fn carry(&mut self, len: usize) -> Option<u64> {
        let start = self.busy_us.max(self.now * 1000);
        self.busy_us = start + len as u64 * 10_000_000 / self.wire.baud;
        let lost = self.chance() % 1000 < self.wire.loss_permille;
        (!lost).then_some(self.busy_us.div_ceil(1000) + self.wire.latency_ms)
    }

    /// The client's side for a millisecond.
    fn hold(&mut self, held: bool) {
        let now = self.time();
        while let Some((ticket, outcome)) = self.line.poll_outcome() {
            self.poll.take_if(|poll| *poll == ticket);
            if let Some((_, requests)) = self.pending.take_if(|(known, _)| *known == ticket) {
                let core = self.core.as_mut().expect("it has asked");
                core.handle_result(now, results(outcome, &requests));
            }
        }
        if self.now.is_multiple_of(POLL_MS) && self.poll.is_none() {
            let poll = RequestBuf::new(&Request::new(SubsystemId::ALL, Body::GetStatus)).unwrap();
            self.poll = Some(self.line.submit(now, 1, Terms::default(), vec![poll]).unwrap());
        }
        let rtt = self.line.stats(1).rtt_average;
        if let Some(core) = &mut self.core {
            core.set_rtt(rtt);
            if held {
                core.renew(now);
            }
            if self.pending.is_none()
                && let Some(next) = core.poll_next(now)
            {
                let requests = next.requests(DRIVE).unwrap();
                let terms = Terms { expires: next.expires, ..Terms::default() };
                let ticket = self.line.submit(now, 1, terms, requests.clone()).unwrap();
                self.pending = Some((ticket, requests));
            }
        }
        if let Some(bytes) = self.line.poll_transmit(now)
            && let Some(at) = self.carry(bytes.len())
        {
            self.down.push((at, bytes));
        }
    }

    /// The line and the monitor for a millisecond.
    fn pass(&mut self) {
        self.now += 1;
        for bytes in due(&mut self.down, self.now) {
            let mut answers = Vec::new();
            for byte in bytes {
                if let Some(frame) = self.decoder.push(byte) {
                    let payload = rename(frame.payload, self.wire.has_hold);
                    let answer = self.sim.request(Source::ExternalConn, &payload);
                    answers.push(rename(&answer, self.wire.has_hold));
                }
            }
            for payload in answers {
                let mut wire = vec![0; wire_max(payload.len())];
                let frame = Frame { dst: 129, src: 1, payload: &payload };
                let len = encode(&frame, &mut wire).unwrap();
                wire.truncate(len);
                if let Some(at) = self.carry(len) {
                    self.up.push((at, wire));
                }
            }
        }
        let now = self.time();
        for bytes in due(&mut self.up, self.now) {
            self.line.handle_bytes(now, &bytes);
        }
        if self.now.is_multiple_of(10) {
            self.sim.tick();
            self.speeds.push(self.drive().0);
        }
    }

    /// Commanded and true speed, and position.
    fn drive(&self) -> (i16, i16, i32) {
        let device = self.sim.device();
        let axis = Axis::Horizontal as usize;
        let input = &device.inputs().drives[axis];
        (device.outputs().drives[axis].speed_tenths, input.speed_tenths, input.position)
    }

    fn is_at_rest(&self) -> bool {
        let (commanded, speed, _) = self.drive();
        commanded == 0 && speed == 0
    }

    fn start(&mut self, toward: Toward) {
        let now = self.time();
        self.core = Some(JogCore::new(now, DRIVE, toward, Hold::default(), false));
    }

    /// Held for so long, then nothing of the holder is left.
    fn held_for(&mut self, ms: u64) {
        for _ in 0..ms {
            self.hold(true);
            self.pass();
        }
    }
}

/// What is under way and has arrived.
fn due(queue: &mut Vec<(u64, Vec<u8>)>, now: u64) -> Vec<Vec<u8>> {
    queue.extract_if(.., |(at, _)| *at <= now).map(|(_, bytes)| bytes).collect()
}

/// A monitor that does not know MoveHold: its parameter has another id.
fn rename(payload: &[u8], has_hold: bool) -> Vec<u8> {
    let mut bytes = payload.to_vec();
    if has_hold {
        return bytes;
    }
    let id = Param::HorizontalMoveHold.id().0.to_le_bytes();
    let other = (Param::HorizontalMoveHold.id().0 + 1).to_le_bytes();
    for at in 4..bytes.len().saturating_sub(1) {
        if bytes[at..at + 2] == id {
            bytes[at..at + 2].copy_from_slice(&other);
        } else if bytes[at..at + 2] == other {
            bytes[at..at + 2].copy_from_slice(&id);
        }
    }
    bytes
}

fn results(outcome: Outcome, requests: &[RequestBuf]) -> Vec<Result<lafet_client::Answers, Error>> {
    match outcome {
        Outcome::Answered(slots) => slots
            .into_iter()
            .map(|slot| match slot {
                Slot::Answered(answers) => Ok(answers),
                Slot::NotExecuted => Err(silence(&requests[0])),
            })
            .collect(),
        _ => requests.iter().map(|request| Err(silence(request))).collect(),
    }
}

fn silence(request: &RequestBuf) -> Error {
    let (request, to) = (request.id(), request.to());
    Error::NoAnswer { request, to, endpoint: "sim:".into(), tries: 1, stray: None }
}

/// How long after its holder a drive is at rest, and how far away, arc-minutes, at most.
#[derive(Clone, Copy, Debug)]
struct Rest {
    ms: u64,
    way: i32,
}

/// The holder vanishes at many moments: it is at rest within the bounds, and stays so.
fn vanish(wire: Wire, moments: u32) -> Rest {
    vanish_of(wire, moments, &deployed())
}

fn vanish_of(wire: Wire, moments: u32, sim: &Sim) -> Rest {
    let (mut worst, mut moved) = (Rest { ms: 0, way: 0 }, 0);
    for moment in 0..moments {
        let mut world = World::new(wire, sim, u64::from(moment));
        let held_ms = world.chance() % (1500 + 6 * wire.latency_ms);
        let way = if moment.is_multiple_of(2) { Toward::Max } else { Toward::Min };
        world.start(way);
        world.held_for(held_ms);
        let from = world.drive().2;
        moved += u32::from(from != 0);
        let (mut last_motion, mut way) = (0, 0);
        for ms in 0..wire.bound_ms + 3000 {
            world.pass();
            if !world.is_at_rest() {
                last_motion = ms + 1;
            }
            way = way.max((world.drive().2 - from).abs());
        }
        assert!(
            last_motion <= wire.bound_ms,
            "{wire:?}: held for {held_ms} ms (moment {moment}), at rest {last_motion} ms later"
        );
        worst = Rest { ms: worst.ms.max(last_motion), way: worst.way.max(way) };
    }
    assert!(moved > moments / 2, "it moves: {moved} of {moments}");
    assert!(worst.way <= wire.way_max, "{wire:?}: {worst:?}");
    worst
}

#[test]
fn it_ends_within_half_a_second_of_its_holder() {
    for wire in [TCP, FAST, USUAL, LOSSY] {
        let worst = vanish(wire, MOMENTS);
        println!("{wire:?}: at rest after {} ms and {}' at most", worst.ms, worst.way);
    }
}

#[test]
fn over_a_slow_radio_it_ends_within_the_stated_time() {
    let worst = vanish(RADIO, MOMENTS / 3);
    println!("{RADIO:?}: at rest after {} ms and {}' at most", worst.ms, worst.way);
}

#[test]
fn a_monitor_without_move_hold_arrives_at_the_end_of_its_step() {
    let worst = vanish(WITHOUT, MOMENTS / 3);
    println!("{WITHOUT:?}: at rest after {} ms and {}' at most", worst.ms, worst.way);
}

/// Without MoveHold the drive's own approach is what lasts, at low speeds as well: its last stretch is
/// a quarter of a second to go, again and again, until it creeps.
#[test]
fn without_move_hold_no_useful_speed_ends_within_half_a_second() {
    for (speed, least_ms, bound_ms) in
        [(20, 1500, 2200), (10, 900, 2000), (5, 700, 1900), (2, 500, 1900)]
    {
        let mut sim = deployed();
        let (id, values) = (Param::HorizontalSpeed.id(), [speed]);
        let set = Body::SetParam { id, values: Ints::Values(&values) };
        sim.ask(DRIVE, set, |answer| assert!(answer.status.is_success()));
        let worst = vanish_of(Wire { bound_ms, ..WITHOUT }, MOMENTS / 5, &sim);
        println!("{speed} °/s: at rest after {} ms and {}' at most", worst.ms, worst.way);
        assert!(worst.ms > least_ms, "{speed} °/s: {worst:?}");
    }
}

/// 10,000 moments on each line: takes minutes.
#[test]
#[ignore = "long: cargo test --release -p lafet-client --test it held:: -- --ignored --nocapture"]
fn ten_thousand_moments() {
    for wire in [TCP, FAST, USUAL, LOSSY, RADIO, WITHOUT] {
        let worst = vanish(wire, 10_000);
        println!("{wire:?}: at rest after {} ms and {}' at most", worst.ms, worst.way);
    }
}

/// How far it goes in `ms`, and the share of its speed that it varies by from the second second on.
fn travel(wire: Wire, sim: &Sim, ms: u64, core: bool) -> (i32, f64) {
    let mut world = World::new(wire, sim, 7);
    if core {
        world.start(Toward::Max);
    } else {
        let body = Body::Move { destination: 21_600 };
        world.sim.ask(DRIVE, body, |answer| assert!(answer.status.is_success()));
    }
    let from = world.drive().2;
    world.held_for(ms);
    let steady = &world.speeds[200..];
    let (least, most) = (steady.iter().min().unwrap(), steady.iter().max().unwrap());
    let ripple = f64::from(most - least) / f64::from(*most);
    (world.drive().2 - from, ripple)
}

#[test]
fn it_is_as_smooth_as_one_move_to_the_limit() {
    let sim = deployed();
    let (whole, _) = travel(TCP, &sim, 5000, false);
    for (wire, share, ripple_max) in [
        (TCP, 0.99, 0.0),
        (FAST, 0.98, 0.0),
        (USUAL, 0.97, 0.0),
        (RADIO, 0.60, 0.0),
        (WITHOUT, 0.85, 0.05),
    ] {
        let (way, ripple) = travel(wire, &sim, 5000, true);
        let of = f64::from(way) / f64::from(whole);
        println!("{wire:?}: {way}' of {whole}' in 5 s, {of:.3}, ripple {ripple:.3}");
        assert!(of >= share, "{wire:?}: {way}' of {whole}'");
        assert!(ripple <= ripple_max, "{wire:?}: {ripple}");
    }
}
