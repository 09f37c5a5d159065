//! A shared serial line (RS-485): bytes take their time, and who talks at the same time garbles.
//!
//! Every station hears what the others send, and itself too if its transceiver echoes. Noise is
//! bit errors at a rate, bursts of them, and bytes lost or doubled by slips of a receiver's clock.
//! Times are nanoseconds of the line's own virtual time. Figures ours.

pub mod exposure;

use std::collections::VecDeque;

use crate::rng::Rng;

/// Bits of a byte on the line: start, eight, stop (8N1, observed).
const BITS: u64 = 10;

/// What spoils bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Chance of each bit to be turned round.
    pub bit_error_rate: f64,
    /// Chance of each byte to begin a burst.
    pub burst_rate: f64,
    /// Bytes that a burst garbles.
    pub burst_bytes: u32,
    /// Chance of each byte to be lost.
    pub loss_rate: f64,
    /// Chance of each byte to be heard twice.
    pub double_rate: f64,
}

impl Noise {
    /// Whether it never spoils anything.
    fn is_silent(&self) -> bool {
        *self == Self { burst_bytes: self.burst_bytes, ..Self::default() }
    }

    /// What is heard of bytes that were sent, as [`Line`] does it, without its times.
    pub fn spoil(&self, bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
        let mut burst = 0;
        let mut heard = Vec::with_capacity(bytes.len());
        for byte in bytes {
            self.byte(*byte, &mut burst, rng, |byte| heard.push(byte));
        }
        heard
    }

    fn byte(&self, byte: u8, burst: &mut u32, rng: &mut Rng, mut hear: impl FnMut(u8)) {
        if self.is_silent() {
            hear(byte);
            return;
        }
        if rng.chance(self.burst_rate) {
            *burst = self.burst_bytes;
        }
        let mut byte = byte;
        if *burst > 0 {
            *burst -= 1;
            byte = rng.bits() as u8;
        } else if self.bit_error_rate > 0.0 {
            for bit in 0..8 {
                byte ^= u8::from(rng.chance(self.bit_error_rate)) << bit;
            }
        }
        if rng.chance(self.loss_rate) {
            return;
        }
        hear(byte);
        if rng.chance(self.double_rate) {
            hear(byte);
        }
    }
}

/// Who is connected to a line.
pub type Station = usize;

/// A byte that a station hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// When its last bit was there, ns.
    pub at_ns: u64,
    /// Who sent it.
    pub from: Station,
    /// What came of it.
    pub byte: u8,
}

#[derive(Clone, Debug, Default)]
struct Sender {
    queue: VecDeque<u8>,
    /// When the byte in front begins.
    begins_ns: u64,
    echo: bool,
    garbled: bool,
}

/// A line.
#[derive(Clone, Debug)]
pub struct Line {
    bit_ns: f64,
    noise: Noise,
    rng: Rng,
    now_ns: u64,
    burst: u32,
    senders: Vec<Sender>,
    busy_ns: u64,
    collisions: u64,
}

impl Line {
    /// A silent line at a speed, with so many stations.
    pub fn new(baud: u32, stations: usize, noise: Noise, seed: u64) -> Self {
        Self {
            bit_ns: 1e9 / f64::from(baud.max(1)),
            noise,
            rng: Rng::new(seed),
            now_ns: 0,
            burst: 0,
            senders: vec![Sender::default(); stations],
            busy_ns: 0,
            collisions: 0,
        }
    }

    /// A station's transceiver lets it hear itself.
    pub fn set_echo(&mut self, station: Station, echo: bool) {
        if let Some(sender) = self.senders.get_mut(station) {
            sender.echo = echo;
        }
    }

    /// What time it is on the line, ns.
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Time that a byte takes, ns.
    pub fn byte_ns(&self) -> u64 {
        (self.bit_ns * BITS as f64) as u64
    }

    /// Time in which the line was busy, ns.
    pub const fn busy_ns(&self) -> u64 {
        self.busy_ns
    }

    /// Bytes that met others on the line.
    pub const fn collisions(&self) -> u64 {
        self.collisions
    }

    /// A station sends bytes, from a time on or after what it is sending.
    pub fn send(&mut self, station: Station, from_ns: u64, bytes: &[u8]) {
        let now_ns = self.now_ns;
        let Some(sender) = self.senders.get_mut(station) else { return };
        if sender.queue.is_empty() {
            sender.begins_ns = from_ns.max(now_ns);
            sender.garbled = false;
        }
        sender.queue.extend(bytes);
    }

    /// Whether a station still sends.
    pub fn sends(&self, station: Station) -> bool {
        self.senders.get(station).is_some_and(|sender| !sender.queue.is_empty())
    }

    /// When the next byte ends, ns; `None` when no sender is active.
    pub fn next_ns(&self) -> Option<u64> {
        let byte_ns = self.byte_ns();
        let sending = self.senders.iter().filter(|sender| !sender.queue.is_empty());
        sending.map(|sender| sender.begins_ns + byte_ns).min()
    }

    /// Nothing was sent up to this time: it passes.
    pub fn wait_until(&mut self, at_ns: u64) {
        self.now_ns = self.now_ns.max(at_ns);
    }

    /// Goes on to the end of the next byte, and passes it to all who can hear it.
    pub fn step(&mut self, mut hear: impl FnMut(Station, Heard)) -> bool {
        let Some(at_ns) = self.next_ns() else { return false };
        let byte_ns = self.byte_ns();
        self.now_ns = self.now_ns.max(at_ns);
        let ends = |sender: &Sender| sender.begins_ns + byte_ns == at_ns;
        let sending = |sender: &&mut Sender| !sender.queue.is_empty();
        // A sender that has started by now garbles what ends now, and is garbled by it.
        let begun = |sender: &&mut Sender| sender.begins_ns < at_ns;
        if self.senders.iter_mut().filter(sending).filter(begun).count() > 1 {
            let met = self.senders.iter_mut().filter(sending).filter(begun);
            met.for_each(|sender| sender.garbled = true);
        }
        self.busy_ns += byte_ns;
        for from in 0..self.senders.len() {
            let sender = &mut self.senders[from];
            if sender.queue.is_empty() || !ends(sender) {
                continue;
            }
            let Some(mut byte) = sender.queue.pop_front() else { continue };
            sender.begins_ns = at_ns;
            if std::mem::take(&mut sender.garbled) {
                self.collisions += 1;
                byte = self.rng.bits() as u8;
            }
            let echo = sender.echo;
            let (noise, rng, burst) = (self.noise, &mut self.rng, &mut self.burst);
            noise.byte(byte, burst, rng, |byte| {
                let heard = Heard { at_ns, from, byte };
                (0..self.senders.len())
                    .filter(|station| *station != from || echo)
                    .for_each(|station| hear(station, heard));
            });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAUD: u32 = 115_200;

    fn run(line: &mut Line) -> Vec<(Station, u8)> {
        let mut all = Vec::new();
        while line.step(|station, heard| all.push((station, heard.byte))) {}
        all
    }

    fn bytes(heard: &[(Station, u8)], station: Station) -> Vec<u8> {
        heard.iter().filter(|(to, _)| *to == station).map(|(_, byte)| *byte).collect()
    }

    #[test]
    fn the_others_hear_it_after_its_time() {
        let mut line = Line::new(BAUD, 3, Noise::default(), 1);
        line.set_echo(2, true);
        line.send(0, 1_000, &[1, 2, 3]);
        let heard = run(&mut line);
        assert!(bytes(&heard, 0).is_empty());
        assert_eq!(bytes(&heard, 1), [1, 2, 3]);
        assert_eq!(line.now_ns(), 1_000 + 3 * line.byte_ns());
        assert_eq!((line.byte_ns(), line.busy_ns()), (86_805, 3 * 86_805));
        line.send(2, 0, &[9]);
        assert_eq!(bytes(&run(&mut line), 2), [9], "an echo");
    }

    #[test]
    fn two_at_a_time_garble_each_other() {
        let mut line = Line::new(BAUD, 3, Noise::default(), 1);
        line.send(0, 0, &[0; 40]);
        line.send(1, 10 * line.byte_ns() + 7, &[0; 10]);
        let heard = bytes(&run(&mut line), 2);
        assert_eq!(heard.len(), 50);
        assert!(line.collisions() >= 20, "{}", line.collisions());
        assert!(heard[..10].iter().all(|byte| *byte == 0), "before the second began");
        assert!(heard[38..].iter().all(|byte| *byte == 0), "after it ended");
        assert!(heard[10..30].iter().any(|byte| *byte != 0));
    }

    #[test]
    fn noise_is_as_frequent_as_it_is_said_to_be() {
        let sent = vec![0; 100_000];
        let rng = &mut Rng::new(5);
        let spoil = |noise: Noise, rng: &mut Rng| noise.spoil(&sent, rng);
        let ones =
            |heard: &[u8]| f64::from(heard.iter().map(|byte| byte.count_ones()).sum::<u32>());
        let wrong = spoil(Noise { bit_error_rate: 1e-3, ..Noise::default() }, rng);
        assert!((ones(&wrong) / 8e5 - 1e-3).abs() < 2e-4);
        let lost = spoil(Noise { loss_rate: 0.01, ..Noise::default() }, rng).len();
        assert!((98_800..99_200).contains(&lost), "{lost}");
        let doubled = spoil(Noise { double_rate: 0.01, ..Noise::default() }, rng).len();
        assert!((100_800..101_200).contains(&doubled), "{doubled}");
        let burst = Noise { burst_rate: 1e-3, burst_bytes: 10, ..Noise::default() };
        let share = ones(&spoil(burst, rng)) / 8e5;
        assert!((0.003..0.007).contains(&share), "{share}: half of the bits of 1 % of the bytes");
        assert_eq!(spoil(Noise::default(), rng), sent);
    }
}
