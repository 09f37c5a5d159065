//! Every request: all 2^24 combinations of (request, device, data_size), with arbitrary data, in
//! many states, against rules written down here once more from the document's tables.

#[path = "../common/mod.rs"]
mod common;
mod rules;
mod states;
mod tables;
mod way;

use common::{ROOM, Rig};
use lafet_device::image::{Axis, Outputs};
use lafet_device::{Composition, Device, Source};
use lafet_proto::Answer;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};
use rules::expected;
use states::{Gate, State, states};
use tables::*;

/// Arbitrary but reproducible.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }
}

/// What is checked of a state, and with what.
struct Check<'a> {
    state: &'a State,
    device: Device,
    noise: Noise,
    bytes: Vec<u8>,
    executed: u64,
    refused: u64,
    sampled: u64,
    /// Outputs of the next steps when nothing has been asked.
    quiet: [Outputs; 3],
}

impl<'a> Check<'a> {
    fn of(state: &'a State, seed: u64) -> Self {
        let mut noise = Noise(seed);
        let bytes = (0..8192).flat_map(|_| noise.next().to_le_bytes()).collect();
        let device = state.rig.device.clone();
        let quiet = next_outputs(&state.rig, &device);
        Self { state, device, noise, bytes, executed: 0, refused: 0, sampled: 0, quiet }
    }

    /// Asks with arbitrary data; in a share of the cases with a key or parameter that there is.
    fn ask(&mut self, request: u8, device: u8, size: u8) {
        let random = self.noise.next();
        let at = (random >> 8) as usize % (self.bytes.len() - 256);
        let mut payload = [0; 4 + 255];
        payload[..4].copy_from_slice(&[request, device, random as u8, size]);
        let data = &mut payload[4..4 + usize::from(size)];
        data.copy_from_slice(&self.bytes[at..at + usize::from(size)]);
        if KNOWN.contains(&request) && random >> 40 & 1 == 0 {
            suit(request, device, data, random >> 41);
        }
        let len = 4 + usize::from(size);
        self.judge(&payload[..len], random >> 32 & 0xFFF == 0);
    }

    fn judge(&mut self, payload: &[u8], sample: bool) {
        let mut out = [0; ROOM];
        let now_ms = self.state.rig.now_ms;
        let record = Records::new(payload).flatten().next().expect("a whole record");
        let way = self.device.way(&record);
        let len = self.device.handle(now_ms, Source::Radio, payload, &mut out);
        let answer = &out[..len];
        let (request, device) = (payload[0], payload[1]);
        let name = self.state.name;
        let led = way::leads_to(way, device, answer);
        assert!(led, "{name}: {payload:02x?} → {answer:02x?}, not by {way:?}");
        if !KNOWN.contains(&request) {
            let status = match self.state.gate {
                Gate::Open => 7,
                Gate::Locked => 3,
                Gate::Restarting => 6,
            };
            assert_eq!(
                answer,
                [request, GENERAL, status, 0],
                "{}: {payload:02x?}",
                self.state.name
            );
            self.refused += 1;
        } else {
            let changed = self.compare(payload, answer);
            if changed && !READS.contains(&request) {
                let safe = rules::is_safe(request, &payload[4..]);
                let may = safe || self.state.gate != Gate::Restarting;
                assert!(may, "{name}: {payload:02x?} while a reset is awaited");
                self.executed += 1;
                self.device = self.state.rig.device.clone();
                return;
            }
            self.refused += u64::from(!changed);
        }
        if sample {
            self.sampled += 1;
            let outputs = next_outputs(&self.state.rig, &self.device);
            let name = self.state.name;
            assert!(outputs == self.quiet, "{name}: {request:#04x} to {device:#04x} was refused");
        }
    }

    /// Compares the answer with the rules; true when anything may have been executed.
    fn compare(&self, payload: &[u8], answer: &[u8]) -> bool {
        let name = self.state.name;
        let (request, data) = (payload[0], &payload[4..]);
        let expected = expected(self.state, request, payload[1], data);
        let records: Vec<_> = Records::new(answer).collect();
        assert_eq!(records.len(), expected.len(), "{name}: {payload:02x?} → {answer:02x?}");
        let mut changed = false;
        for (record, expected) in records.iter().zip(&expected) {
            let record = record.expect("whole records");
            let decoded = Answer::decode(&record);
            assert!(decoded.is_ok(), "{name}: {payload:02x?} → {answer:02x?}: {decoded:?}");
            let same = record.request.0 == request
                && record.device.0 == expected.from
                && expected.statuses.contains(&record.status.0)
                && record.data.len() == expected.size;
            assert!(
                same,
                "{name}: {payload:02x?} → {record:?}, not {:#04x} {:?} with {} bytes",
                expected.from, expected.statuses, expected.size
            );
            // §3.14/8, §3.16/2: a sector outside the limits shows in the flags; §3.2/5: what is
            // faulty stops all the same.
            changed |= match record.status {
                Status::OK | Status::ACCEPTED | Status::INCOMPLETE_CONFIG => true,
                Status::INVALID_VALUE => matches!(request, START_QUENCH | START_SEEK),
                Status::MODULE_FAULT => request == STOP,
                _ => false,
            };
        }
        changed
    }
}

fn next_outputs(rig: &Rig, device: &Device) -> [Outputs; 3] {
    let mut rig = Rig { device: device.clone(), ..rig.clone() };
    [(); 3].map(|()| {
        rig.step(10);
        rig.plant.outputs
    })
}

/// Makes the start of the data a key, a parameter or numbers that are likely to be right.
fn suit(request: u8, device: u8, data: &mut [u8], random: u64) {
    let put = |data: &mut [u8], at: usize, value: u16| {
        if let Some(place) = data.get_mut(at..at + 2) {
            place.copy_from_slice(&value.to_le_bytes());
        }
    };
    let keys = [0x4C70, 0x7456, 0xA4F6, 0x2FFA, 0x7353, 0, 1, 2];
    match request {
        GET_PARAM | SET_PARAM => {
            let known: Vec<u16> = names(device).map(|name| hash16(&name)).collect();
            let any = known.get(random as usize % known.len().max(1)).copied().unwrap_or(0x23FE);
            put(data, 0, any);
            // Mostly small values, which are in range more often.
            data.iter_mut()
                .skip(2)
                .for_each(|byte| *byte &= if random >> 8 & 1 == 0 { 3 } else { 0xFF });
            if random >> 9 & 1 == 0 {
                data.iter_mut()
                    .skip(2)
                    .enumerate()
                    .filter(|(at, _)| at % 4 != 0)
                    .for_each(|(_, byte)| *byte = 0);
            }
        }
        START_QUENCH => {
            put(data, 0, random as u16 & 7);
            for at in [2, 4, 6, 8] {
                put(data, at, (random >> at) as u16 & 63);
            }
            data.iter_mut().skip(10).take(2).for_each(|byte| *byte &= 0x7F);
        }
        START_TRAJECTORY if data.len() >= 4 => {
            let rest = data.len() - 3;
            let mode = u8::from(!rest.is_multiple_of(6));
            let count = if mode == 0 { rest / 6 } else { rest };
            data[..3].copy_from_slice(&[mode, random as u8 & 3, count as u8]);
            data[3..].iter_mut().for_each(|byte| *byte &= 7);
        }
        START_SEEK => {
            for at in [0, 2, 4, 6] {
                put(data, at, (random >> at) as u16 & 255);
            }
            put(data, 8, (random >> 9) as u16 & 1);
        }
        _ => put(data, 0, keys[random as usize % keys.len()]),
    }
}

fn all_combinations(state: &State, requests: std::ops::RangeInclusive<u8>) -> (u64, u64, u64) {
    let mut check = Check::of(state, u64::from(*requests.start()) + 1);
    for request in requests {
        for device in 0..=255 {
            for size in 0..=255 {
                check.ask(request, device, size);
            }
        }
        if KNOWN.contains(&request) {
            // Once more with other data, where the data matter.
            for (device, _) in CHAIN.into_iter().chain([(ALL, 0), (MOTORS, 0)]) {
                for size in (0..=255).chain([0, 2, 6, 8, 10, 12, 30].repeat(64)) {
                    check.ask(request, device, size);
                }
            }
        }
    }
    (check.executed, check.refused, check.sampled)
}

/// §1/2, §1/3, §1/4, §1/5, §1/6, §1/7, §1/10, §1/11, §1/12, §2/1, §2/3, §2/4, §3.3/2, §3.12/2,
/// §3.18/2, §3.18/3: each combination gets the one answer that the document's tables give it,
/// and what was refused changes no output.
#[test]
fn every_combination_is_answered_as_the_tables_say() {
    for state in states() {
        let state = &state;
        let halves = std::thread::scope(|scope| {
            let lower = scope.spawn(|| all_combinations(state, 0..=0x7F));
            let upper = scope.spawn(|| all_combinations(state, 0x80..=0xFF));
            [lower, upper].map(|half| half.join().expect("a combination was answered wrongly"))
        });
        let [(e1, r1, s1), (e2, r2, s2)] = halves;
        let (executed, refused, sampled) = (e1 + e2, r1 + r2, s1 + s2);
        assert!(executed + refused > (1 << 24) - 100_000, "{}: {executed} {refused}", state.name);
        assert!(sampled > 3000, "{}: only {sampled} refusals were followed", state.name);
        // Otherwise the rules above prove too little; waiting for the reset, what ends something alone is executed.
        let enough = if state.gate == Gate::Restarting { 1 } else { 100 };
        assert!(executed >= enough, "{}: {executed} executed", state.name);
    }
}

/// §1/8, §1/9, §2/2, §2/5: frames of arbitrary bytes, cut anywhere, into any buffer: no panic, whole
/// records, never more than fits, and after the records that were answered nothing has changed.
#[test]
fn arbitrary_frames() {
    for state in states() {
        let mut noise = Noise(77);
        let known: Vec<u8> = EVERYBODY.iter().copied().chain([ALL, MOTORS]).collect();
        let mut device = state.rig.device.clone();
        for round in 0..60_000_u32 {
            let random = noise.next();
            let len = random as usize % 97;
            let mut payload: Vec<u8> = (0..len).map(|_| (noise.next() >> 13) as u8).collect();
            // Half of them begin like records, so that there are more than one.
            if random >> 20 & 1 == 0 {
                for start in (0..len.saturating_sub(3)).step_by(6) {
                    payload[start] = KNOWN[payload[start] as usize % KNOWN.len()];
                    payload[start + 1] = known[payload[start + 1] as usize % known.len()];
                    payload[start + 3] = 2;
                }
            }
            let room = (random >> 32) as usize % 200;
            let mut out = vec![0xEE; room];
            let written = device.handle(state.rig.now_ms, Source::Radio, &payload, &mut out);
            assert!(written <= room);
            assert!(Records::new(&out[..written]).all(|record| record.is_ok()));
            assert!(out[written..].iter().all(|byte| *byte == 0xEE), "bytes behind the answer");
            assert!(payload.is_empty() == (written == 0) || room < 4, "{payload:02x?} {room}");
            if round % 16 == 0 {
                device = state.rig.device.clone();
            }
        }
    }
}

/// §1/9, §1/10: the answer to the longest broadcast fits the usual buffer with much to spare.
#[test]
fn every_status_fits() {
    for composition in Composition::ALL {
        let mut rig = Rig::new(composition);
        let size: usize =
            rig.ask(SubsystemId::ALL, Body::GetStatus).iter().map(|r| 4 + r.data.len()).sum();
        let present = CHAIN.iter().filter(|(id, _)| rig.device.has(SubsystemId(*id)));
        assert_eq!(size, present.map(|(_, size)| 4 + size).sum::<usize>(), "{}", composition.name);
        assert!(size <= 146);
        assert!(rig.is_still() && rig.drive(Axis::Vertical).speed == 0);
    }
}
