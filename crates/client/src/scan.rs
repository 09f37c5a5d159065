//! Devices on a line: presence probes to every address (§L/5, observed).

mod network;

pub use network::{HOSTS_MAX, Host, Place, Told, hosts, scan_network};
pub(crate) use network::{is_answer, question};

use std::io;
use std::ops::RangeInclusive;
use std::time::Duration;

use lafet_proto::bus;
use lafet_proto::link::Check;

use crate::prober::{Heard, Prober};
use crate::transport::Link;

/// Options of a scan.
#[derive(Clone, Debug)]
pub struct ScanOptions {
    /// Addresses to probe.
    pub addresses: RangeInclusive<u8>,
    /// Longest wait for the answer to a probe (observed on a bus: 30 ms; a network needs more).
    pub wait: Duration,
    /// Number of probes to an address that does not answer.
    pub tries: u32,
    /// Whether to probe also, in a second round, for devices that accept only CRC-32C (§L/7).
    pub crc32c: bool,
    /// Time to listen before the first probe. If another device transmits meanwhile, nothing is
    /// probed: a probe would collide with its frames, possibly with a Stop.
    pub listen: Duration,
    /// Whether the first answer shortens the wait for the others, which have a similar round trip:
    /// to four times that round trip plus [`ADAPTED`]. Until then an address has the whole wait only
    /// once, then [`ADAPTED`]: frames on the line do not meet, and an answer that comes later counts.
    pub adapt: bool,
}

/// The shortest adapted wait: the time that a bus allows for an answer.
pub const ADAPTED: Duration = Duration::from_millis(bus::PROBE_TIMEOUT_MS as u64);

impl Default for ScanOptions {
    fn default() -> Self {
        let wait = Duration::from_millis(bus::PROBE_TIMEOUT_MS.into());
        Self {
            addresses: bus::MONITORS,
            wait,
            tries: 2,
            crc32c: true,
            listen: Duration::ZERO,
            adapt: false,
        }
    }
}

/// A device that answers probes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Present {
    /// Address of the device.
    pub address: u8,
    /// Checksum of the frames that it answers; Crc32c: it answers no others (§L/7).
    pub check: Check,
    /// Round trip of its answer.
    pub rtt: Duration,
    /// More than one answer to a probe: two devices have this address.
    pub doubled: bool,
}

/// Result of a scan.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// Devices that answered, by address.
    pub present: Vec<Present>,
    /// Addresses that transmit without being asked by this scan: consoles, a bus controller.
    pub speakers: Vec<u8>,
    /// The line echoes what is sent.
    pub echo: bool,
    /// Frames received with errors.
    pub broken: u64,
    /// Bytes that are not frames were received before the first probe: noise, or devices at another
    /// speed.
    pub garbage: bool,
    /// Nothing was probed, because other devices transmit: see [`ScanOptions::listen`].
    pub held_back: bool,
}

/// Probes one address after the other; calls `progress` with each address.
///
/// On a bus with a controller or another console no other device may transmit unasked.
/// [`Scan::speakers`] shows whether there was one.
///
/// # Errors
///
/// The error of the link when it is lost; the results so far are lost as well.
pub async fn scan(
    link: Link,
    source: u8,
    options: &ScanOptions,
    mut progress: impl FnMut(u8),
) -> io::Result<Scan> {
    let mut prober = Prober::new(link, source);
    let mut scan = Scan::default();
    let mut heard = prober.listen(options.listen).await?;
    // Bytes that are not frames may come from devices at another speed.
    if heard.is_garbage() {
        scan.garbage = prober.listen_on(&mut heard, options.listen).await?;
    }
    scan.note(heard, source, &[0; 256]);
    let talks = !scan.speakers.is_empty() || scan.garbage;
    if talks && !options.listen.is_zero() {
        scan.held_back = true;
        return Ok(scan);
    }
    let mut sent = [0; 256];
    // Few devices have Check = 1, so the second round is short.
    let rounds = [(Check::Crc16, options.tries.max(1)), (Check::Crc32c, options.crc32c.into())];
    for (check, tries) in rounds.into_iter().filter(|(_, tries)| *tries > 0) {
        for address in options.addresses.clone().filter(|address| *address != source) {
            if scan.present.iter().any(|present| present.address == address) {
                continue;
            }
            progress(address);
            for _ in 0..tries {
                let probes = &mut sent[usize::from(address)];
                let wait = scan.wait(options, *probes > 0);
                let heard = prober.ask(address, &[], check, wait).await?;
                *probes += 1;
                if scan.note(heard, source, &sent) {
                    break;
                }
            }
        }
    }
    // A device whose answer came too late for its probe is present all the same.
    let late = prober.listen(options.wait).await?;
    scan.note(late, source, &sent);
    scan.present.sort_by_key(|present| present.address);
    Ok(scan)
}

impl Scan {
    /// Longest wait for the next probe. `again`: the address was probed before.
    fn wait(&self, options: &ScanOptions, again: bool) -> Duration {
        let slowest = self.present.iter().map(|present| present.rtt).max();
        match slowest {
            _ if !options.adapt => options.wait,
            Some(slowest) => (ADAPTED + slowest * 4).min(options.wait),
            None if again => ADAPTED.min(options.wait),
            None => options.wait,
        }
    }

    /// Evaluates received frames; returns whether a probe was answered. `sent`: probes to each
    /// address.
    fn note(&mut self, heard: Heard, source: u8, sent: &[u32; 256]) -> bool {
        self.echo |= heard.echoes > 0;
        self.broken += heard.broken;
        let mut answered = false;
        for frame in heard.frames {
            if frame.dst != source {
                let speaker = frame.speaker();
                if speaker != source && !self.speakers.contains(&speaker) {
                    self.speakers.push(speaker);
                }
                continue;
            }
            answered = true;
            match self.present.iter_mut().find(|present| present.address == frame.src) {
                Some(present) => present.doubled |= sent[usize::from(frame.src)] == 1,
                None => self.present.push(Present {
                    address: frame.src,
                    check: frame.check,
                    rtt: frame.after,
                    doubled: false,
                }),
            }
        }
        answered
    }
}
