//! What a check lets through: requests over a noisy line, and frames that were never sent.

use std::collections::VecDeque;

use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::{Check, Decoder, Frame, WIRE_MAX, encode_with};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::{Body, Request};
use lafet_proto::{Ints, ParamId, SubsystemId};

use super::Noise;
use crate::rng::Rng;

/// A frame may be heard while this many later ones are sent: the decoder holds one back at most.
const BEHIND: usize = 2;
/// Monitors on the bus.
const MONITORS: u8 = 32;

/// What a receiver takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// Frames with either check.
    Both,
    /// Frames with the check of the sender.
    Only,
}

/// What came of the frames that were sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exposure {
    /// Frames sent.
    pub sent: u64,
    /// Frames that the receiver took for good.
    pub accepted: u64,
    /// Frames among them that were never sent.
    pub wrong: u64,
    /// Frames among those that a monitor at addresses 1 to 32 would have executed.
    pub executed: u64,
    /// Frames that met at least one error.
    pub hit: u64,
}

/// Sends requests of every kind over a noisy line to a decoder.
///
/// Frames without an error that follow a receiver at rest are counted without being decoded:
/// what the decoder makes of them is known.
pub fn expose(check: Check, takes: Takes, noise: Noise, frames: u64, seed: u64) -> Exposure {
    let mut rng = Rng::new(seed);
    let wires = wires(check);
    let mut errors = Errors::new(noise, &mut rng);
    let mut decoder: Box<Decoder> = Box::default();
    let mut sent: VecDeque<usize> = VecDeque::new();
    let mut result = Exposure::default();
    let mut at_rest = true;
    let mut heard = Vec::new();
    while result.sent < frames {
        let which = rng.bits() as usize % wires.len();
        let (wire, _) = &wires[which];
        result.sent += 1;
        let clean = errors.pass(wire, &mut rng, &mut heard);
        if clean && at_rest {
            result.accepted += 1;
            continue;
        }
        result.hit += u64::from(!clean);
        sent.push_back(which);
        if sent.len() > BEHIND {
            sent.pop_front();
        }
        at_rest = clean;
        let mut rest = &heard[..];
        while !rest.is_empty() {
            let (taken, frame) = decoder.push_slice(rest);
            rest = &rest[taken..];
            let found = frame.map(|frame| (frame.dst, frame.src, frame.payload.to_vec()));
            let taken = takes == Takes::Both || decoder.check() == check;
            if let Some((dst, src, payload)) = found.filter(|_| taken) {
                let body = (dst, src, &payload[..]);
                let genuine = sent.iter().position(|which| same(&wires[*which].1, body));
                result.accepted += 1;
                match genuine {
                    // A frame is heard once: the same again would be one more that was not sent.
                    Some(index) => _ = sent.drain(..=index),
                    None => {
                        result.wrong += 1;
                        result.executed += u64::from(is_executed(body));
                    }
                }
            }
        }
        // After a frame heard whole the decoder waits for the next one, as at the beginning.
        at_rest &= sent.is_empty();
    }
    result
}

/// Whether a monitor of the bus would do something: its address, and a request that it understands.
fn is_executed((dst, _, payload): (u8, u8, &[u8])) -> bool {
    let first = Records::new(payload).next();
    (1..=MONITORS).contains(&dst)
        && matches!(first, Some(Ok(record)) if Request::decode(&record).is_ok_and(
            |request| !matches!(request.body, Body::Unknown { .. })
        ))
}

type Body3 = (u8, u8, Vec<u8>);

fn same(body: &Body3, (dst, src, payload): (u8, u8, &[u8])) -> bool {
    (body.0, body.1, &body.2[..]) == (dst, src, payload)
}

/// Requests of different lengths, some with bytes that are escaped, and their frames.
fn wires(check: Check) -> Vec<(Vec<u8>, Body3)> {
    let long: Vec<i32> = (0..20).map(|value| value * 0x00C0_DB01).collect();
    let bodies = [
        (SubsystemId::VERTICAL, Body::Move { destination: 600 }),
        (SubsystemId::HORIZONTAL, Body::Move { destination: -0x2440 }),
        (SubsystemId::ALL, Body::Stop),
        (SubsystemId::ALL, Body::GetStatus),
        (SubsystemId::VALVE1, Body::Open { key: lafet_proto::id::key::OPEN }),
        (SubsystemId::VALVE1, Body::Close { key: lafet_proto::id::key::CLOSE }),
        (SubsystemId::DEPLOYER, Body::Deploy),
        (
            SubsystemId::CONTROL,
            Body::SetParam { id: ParamId::of("Speed"), values: Ints::Values(&long) },
        ),
    ];
    let mut all = Vec::new();
    for (dst, (to, body)) in (1_u8..).zip(bodies) {
        let (mut record, mut out) = ([0; 260], [0; WIRE_MAX]);
        let mut writer = Writer::new(&mut record);
        let fits = Request::new(to, body).encode(&mut writer);
        debug_assert!(fits.is_ok());
        let payload = writer.written();
        let frame = Frame { dst, src: CONTROLLER, payload };
        let len = encode_with(check, &frame, &mut out).unwrap_or(0);
        all.push((out[..len].to_vec(), (dst, CONTROLLER, payload.to_vec())));
    }
    all
}

/// Noise whose next event is drawn ahead, so that bytes without errors cost nothing.
struct Errors {
    noise: Noise,
    bit: Countdown,
    burst: Countdown,
    loss: Countdown,
    double: Countdown,
    garbled: u32,
}

impl Errors {
    fn new(noise: Noise, rng: &mut Rng) -> Self {
        Self {
            noise,
            bit: Countdown::new(noise.bit_error_rate, rng),
            burst: Countdown::new(noise.burst_rate, rng),
            loss: Countdown::new(noise.loss_rate, rng),
            double: Countdown::new(noise.double_rate, rng),
            garbled: 0,
        }
    }

    /// What is heard of a frame; whether it is what was sent.
    fn pass(&mut self, wire: &[u8], rng: &mut Rng, heard: &mut Vec<u8>) -> bool {
        let (bytes, bits) = (wire.len() as u64, 8 * wire.len() as u64);
        let quiet = self.garbled == 0
            && self.bit.skip(bits)
            && self.burst.skip(bytes)
            && self.loss.skip(bytes)
            && self.double.skip(bytes);
        heard.clear();
        if quiet {
            for (countdown, count) in [
                (&mut self.bit, bits),
                (&mut self.burst, bytes),
                (&mut self.loss, bytes),
                (&mut self.double, bytes),
            ] {
                countdown.left -= count;
            }
            heard.extend_from_slice(wire);
            return true;
        }
        for byte in wire {
            let mut byte = *byte;
            if self.burst.event(rng) {
                self.garbled = self.noise.burst_bytes;
            }
            for bit in 0..8 {
                byte ^= u8::from(self.bit.event(rng)) << bit;
            }
            if self.garbled > 0 {
                self.garbled -= 1;
                byte = rng.bits() as u8;
            }
            let (lost, doubled) = (self.loss.event(rng), self.double.event(rng));
            if !lost {
                heard.push(byte);
            }
            if doubled {
                heard.push(byte);
            }
        }
        heard == wire
    }
}

/// Trials until the next event of a rate: geometrically distributed.
struct Countdown {
    log: f64,
    left: u64,
}

impl Countdown {
    fn new(rate: f64, rng: &mut Rng) -> Self {
        let mut countdown = Self { log: libm::log1p(-rate), left: u64::MAX };
        countdown.draw(rng);
        countdown
    }

    fn draw(&mut self, rng: &mut Rng) {
        if self.log < 0.0 {
            self.left = (libm::log(1.0 - rng.unit()) / self.log) as u64;
        }
    }

    /// Whether nothing happens in so many trials.
    const fn skip(&self, trials: u64) -> bool {
        self.left >= trials
    }

    fn event(&mut self, rng: &mut Rng) -> bool {
        if self.left > 0 {
            self.left -= 1;
            return false;
        }
        self.draw(rng);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: u64 = 200_000;

    #[test]
    fn without_noise_everything_arrives() {
        let all = expose(Check::Crc16, Takes::Both, Noise::default(), FRAMES, 1);
        let none = Exposure { sent: FRAMES, accepted: FRAMES, ..Exposure::default() };
        assert_eq!(all, none);
    }

    /// The rate of frames with an error is that of the bits: 1 − (1 − p)^n.
    #[test]
    fn frames_are_hit_as_often_as_their_bits_say() {
        let noise = Noise { bit_error_rate: 1e-3, ..Noise::default() };
        let wires = wires(Check::Crc16);
        let expected: f64 = wires
            .iter()
            .map(|(wire, _)| 1.0 - libm::pow(1.0 - 1e-3, 8.0 * wire.len() as f64))
            .sum::<f64>()
            / wires.len() as f64;
        let Exposure { sent, hit, .. } = expose(Check::Crc16, Takes::Both, noise, FRAMES, 2);
        let share = hit as f64 / sent as f64;
        assert!((share / expected - 1.0).abs() < 0.02, "{share} {expected}");
    }

    /// The instrument sees what a check lets through: a line of garbage has frames with a right
    /// CRC-16 about once in 65536.
    #[test]
    fn what_crc16_lets_through_is_seen() {
        let noise = Noise { bit_error_rate: 0.02, ..Noise::default() };
        let short = expose(Check::Crc16, Takes::Both, noise, 4_000_000, 3);
        assert!(short.wrong > 0, "{short:?}");
        assert!((short.wrong as f64) < short.hit as f64 / 20_000.0, "{short:?}");
        let long = expose(Check::Crc32c, Takes::Only, noise, 4_000_000, 3);
        assert_eq!(long.wrong, 0, "{long:?}");
    }
}
