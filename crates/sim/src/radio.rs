//! A radio channel with modems on it: half duplex, slow, late, and not everything arrives.
//!
//! A modem takes bytes, waits until it hears no carrier, keys up and sends them as one packet. All
//! others get it whole after its time on the air and the latency, or not at all. Two that key up at
//! the same moment do not hear each other, and both packets are lost. Times are microseconds of the
//! channel's own virtual time. The model and its figures are ours: no modem is named by the
//! document.

use std::collections::{BTreeMap, VecDeque};
use std::str::FromStr;

use crate::line::Noise;
use crate::rng::Rng;

/// Bits of a byte on the air, with what frames it.
const BITS: u64 = 10;
/// Bytes of a packet.
const PACKET_MAX: usize = 1200;
/// Bytes that a modem keeps; what comes on top of them is lost.
const KEPT_MAX: usize = 4096;
/// From keying up until the others hear the carrier, and the first byte goes out.
const KEY_UP_US: u64 = 3_000;
/// After a carrier a modem waits for up to so many times of keying up, by chance.
const BACK_OFF: u64 = 8;

/// How a channel behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadioConfig {
    /// Bits a second on the air.
    pub rate_bps: u32,
    /// Time in the two modems, from the end of a packet to its bytes at the other end, ms.
    pub latency_ms: u32,
    /// Chance of a packet not to arrive at a receiver.
    pub loss: f64,
    /// Chance of each bit to be turned round.
    pub bit_error_rate: f64,
}

impl Default for RadioConfig {
    fn default() -> Self {
        Self { rate_bps: 9_600, latency_ms: 40, loss: 0.0, bit_error_rate: 0.0 }
    }
}

impl FromStr for RadioConfig {
    type Err = String;

    /// `rate=9600,latency=40,loss=0.05,errors=1e-5`, each of which may be left out.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut config = Self::default();
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            let share = || value.parse().ok().filter(|share| (0.0..=1.0).contains(share));
            let whole = |max: u32| value.parse().ok().filter(|number| *number <= max);
            let set = match name {
                "rate" => {
                    let rate = whole(10_000_000).filter(|rate| *rate >= 300);
                    rate.map(|rate| config.rate_bps = rate)
                }
                "latency" => whole(10_000).map(|latency| config.latency_ms = latency),
                "loss" => share().map(|loss| config.loss = loss),
                "errors" => share().map(|errors| config.bit_error_rate = errors),
                _ => None,
            };
            set.ok_or_else(|| part.to_owned())?;
        }
        Ok(config)
    }
}

/// A modem on the channel.
pub type Station = u32;

/// What was on the air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadioStats {
    /// Packets sent.
    pub packets: u64,
    /// Of these, those that met others and were lost.
    pub collided: u64,
    /// Receptions that failed by chance.
    pub lost: u64,
    /// Bytes that found no room in their modem.
    pub dropped: u64,
}

#[derive(Clone, Debug, Default)]
struct Modem {
    queue: VecDeque<u8>,
    /// When it looks whether the channel is free.
    tries_us: Option<u64>,
    sends: Option<Packet>,
}

#[derive(Clone, Debug)]
struct Packet {
    bytes: Vec<u8>,
    begins_us: u64,
    ends_us: u64,
    collided: bool,
}

/// A channel.
#[derive(Clone, Debug)]
pub struct Radio {
    config: RadioConfig,
    rng: Rng,
    modems: BTreeMap<Station, Modem>,
    joined: Station,
    /// What arrives, by its time and the order in which it was sent.
    arriving: BTreeMap<(u64, u64), (Station, Vec<u8>)>,
    order: u64,
    stats: RadioStats,
}

impl Radio {
    /// A silent channel.
    pub const fn new(config: RadioConfig, seed: u64) -> Self {
        Self {
            config,
            rng: Rng::new(seed),
            modems: BTreeMap::new(),
            joined: 0,
            arriving: BTreeMap::new(),
            order: 0,
            stats: RadioStats { packets: 0, collided: 0, lost: 0, dropped: 0 },
        }
    }

    /// A new modem.
    pub fn join(&mut self) -> Station {
        self.joined += 1;
        self.modems.insert(self.joined, Modem::default());
        self.joined
    }

    /// A modem is switched off; what it sends ends there.
    pub fn leave(&mut self, station: Station) {
        self.modems.remove(&station);
    }

    /// What was on the air.
    pub const fn stats(&self) -> RadioStats {
        self.stats
    }

    /// A modem gets bytes to send.
    pub fn send(&mut self, station: Station, now_us: u64, bytes: &[u8]) {
        self.advance(now_us);
        let Some(modem) = self.modems.get_mut(&station) else { return };
        let room = KEPT_MAX.saturating_sub(modem.queue.len()).min(bytes.len());
        self.stats.dropped += (bytes.len() - room) as u64;
        modem.queue.extend(&bytes[..room]);
        if modem.sends.is_none() && !modem.queue.is_empty() {
            modem.tries_us.get_or_insert(now_us);
        }
    }

    /// When [`Radio::poll`] is to be called.
    pub fn next_us(&self) -> Option<u64> {
        let arrives = self.arriving.keys().next().map(|(at, _)| *at);
        self.next_event().map(|(at, _)| at).into_iter().chain(arrives).min()
    }

    /// What has arrived by now, and where.
    pub fn poll(&mut self, now_us: u64) -> Option<(Station, Vec<u8>)> {
        self.advance(now_us);
        let first = self.arriving.first_entry()?;
        (first.key().0 <= now_us).then(|| first.remove())
    }

    /// What happens next on the air, and to whom.
    fn next_event(&self) -> Option<(u64, Station)> {
        let event = |(station, modem): (&Station, &Modem)| {
            let at = modem.sends.as_ref().map(|packet| packet.ends_us).or(modem.tries_us)?;
            Some((at, *station))
        };
        self.modems.iter().filter_map(event).min()
    }

    fn advance(&mut self, now_us: u64) {
        while let Some((at_us, station)) = self.next_event().filter(|(at, _)| *at <= now_us) {
            let Some(modem) = self.modems.get_mut(&station) else { return };
            match modem.sends.take() {
                Some(packet) => self.ended(station, packet),
                None => self.tried(station, at_us),
            }
        }
    }

    /// A modem listens, and keys up if it hears nothing.
    fn tried(&mut self, station: Station, now_us: u64) {
        let sending = self.modems.values().filter_map(|modem| modem.sends.as_ref());
        let heard = sending.filter(|packet| packet.begins_us + KEY_UP_US <= now_us);
        let free_us = heard.map(|packet| packet.ends_us).max();
        let back_off_us = KEY_UP_US * (1 + self.rng.bits() % BACK_OFF);
        let mut met = false;
        if free_us.is_none() {
            for packet in self.modems.values_mut().filter_map(|modem| modem.sends.as_mut()) {
                (packet.collided, met) = (true, true);
            }
        }
        let byte_us = BITS * 1_000_000 / u64::from(self.config.rate_bps.max(1));
        let Some(modem) = self.modems.get_mut(&station) else { return };
        if let Some(free_us) = free_us {
            modem.tries_us = Some(free_us + back_off_us);
            return;
        }
        modem.tries_us = None;
        let bytes: Vec<u8> = modem.queue.drain(..modem.queue.len().min(PACKET_MAX)).collect();
        let ends_us = now_us + KEY_UP_US + byte_us * bytes.len() as u64;
        modem.sends = Some(Packet { bytes, begins_us: now_us, ends_us, collided: met });
    }

    fn ended(&mut self, station: Station, packet: Packet) {
        let Packet { bytes, ends_us, collided, .. } = packet;
        if let Some(modem) = self.modems.get_mut(&station)
            && !modem.queue.is_empty()
        {
            modem.tries_us = Some(ends_us + KEY_UP_US);
        }
        self.stats.packets += 1;
        if collided {
            self.stats.collided += 1;
            return;
        }
        let noise = Noise { bit_error_rate: self.config.bit_error_rate, ..Noise::default() };
        let at_us = ends_us + u64::from(self.config.latency_ms) * 1000;
        for to in self.modems.keys().filter(|to| **to != station) {
            if self.rng.chance(self.config.loss) {
                self.stats.lost += 1;
                continue;
            }
            self.order += 1;
            let heard = noise.spoil(&bytes, &mut self.rng);
            self.arriving.insert((at_us, self.order), (*to, heard));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: RadioConfig =
        RadioConfig { rate_bps: 10_000, latency_ms: 50, loss: 0.0, bit_error_rate: 0.0 };

    fn all(radio: &mut Radio) -> Vec<(u64, Station, Vec<u8>)> {
        let mut heard = Vec::new();
        while let Some(at) = radio.next_us() {
            while let Some((to, bytes)) = radio.poll(at) {
                heard.push((at, to, bytes));
            }
        }
        heard
    }

    #[test]
    fn a_packet_takes_its_time_and_reaches_all_others() {
        let mut radio = Radio::new(PLAIN, 1);
        let (a, b, c) = (radio.join(), radio.join(), radio.join());
        radio.send(a, 1_000, &[1; 20]);
        // Keyed up in 3 ms, 20 ms on the air, 50 ms in the modems.
        let at = 1_000 + KEY_UP_US + 20_000 + 50_000;
        assert_eq!(all(&mut radio), [(at, b, vec![1; 20]), (at, c, vec![1; 20])]);
        radio.leave(c);
        radio.send(b, 200_000, &[2]);
        assert_eq!(all(&mut radio), [(254_000, a, vec![2])]);
        assert_eq!(radio.stats(), RadioStats { packets: 2, ..RadioStats::default() });
    }

    #[test]
    fn who_hears_a_carrier_waits_and_who_does_not_collides() {
        let mut radio = Radio::new(PLAIN, 1);
        let (a, b) = (radio.join(), radio.join());
        radio.send(a, 0, &[1; 20]);
        radio.send(b, 5_000, &[2; 20]);
        let heard = all(&mut radio);
        assert_eq!(heard.iter().map(|(_, to, _)| *to).collect::<Vec<_>>(), [b, a]);
        assert!(heard[1].0 >= heard[0].0 + 20_000);
        assert_eq!(radio.stats().collided, 0);
        radio.send(a, 1_000_000, &[1; 20]);
        radio.send(b, 1_002_000, &[2; 20]);
        assert!(all(&mut radio).is_empty());
        assert_eq!(radio.stats().collided, 2);
        radio.send(a, 2_000_000, &[3]);
        assert_eq!(all(&mut radio).len(), 1, "they are not stuck");
    }

    #[test]
    fn loss_and_errors_are_as_frequent_as_they_are_said_to_be() {
        let config = RadioConfig { loss: 0.1, bit_error_rate: 1e-3, ..PLAIN };
        let mut radio = Radio::new(config, 3);
        let (a, _b) = (radio.join(), radio.join());
        let (mut received, mut wrong) = (0_u64, 0);
        for n in 0..5_000_u64 {
            radio.send(a, n * 1_000_000, &[0; 25]);
            for (_, _, bytes) in all(&mut radio) {
                received += 1;
                wrong += bytes.iter().map(|byte| byte.count_ones()).sum::<u32>();
            }
        }
        assert!((4_400..4_600).contains(&received), "{received}");
        let rate = f64::from(wrong) / (received * 200) as f64;
        assert!((rate - 1e-3).abs() < 1e-4, "{rate}");
        assert_eq!(radio.stats().lost, 5_000 - received);
    }

    #[test]
    fn a_modem_keeps_so_much_and_no_more() {
        let mut radio = Radio::new(PLAIN, 1);
        let (a, _b) = (radio.join(), radio.join());
        radio.send(a, 0, &[0; KEPT_MAX + 100]);
        assert_eq!(radio.stats().dropped, 100);
        let lengths: Vec<usize> = all(&mut radio).iter().map(|(_, _, b)| b.len()).collect();
        assert_eq!(lengths, [1200, 1200, 1200, 496]);
    }

    #[test]
    fn configurations() {
        let parse = |text: &str| text.parse::<RadioConfig>();
        assert_eq!(parse(""), Ok(RadioConfig::default()));
        let all = RadioConfig { rate_bps: 4800, latency_ms: 200, loss: 0.05, bit_error_rate: 1e-5 };
        assert_eq!(parse("rate=4800,latency=200,loss=0.05,errors=1e-5"), Ok(all));
        for wrong in ["rate=1", "loss=2", "loss", "latency=-1", "colour=red", "errors=x"] {
            assert_eq!(parse(wrong), Err(wrong.to_owned()));
        }
    }
}
