//! Who is on a line: presence probes to every address (§L/5, observed).

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

/// What is looked for, and how patiently.
#[derive(Clone, Debug)]
pub struct ScanOptions {
    /// The addresses that are probed.
    pub addresses: RangeInclusive<u8>,
    /// How long each probe may take (observed on a bus: 30 ms; a network needs more).
    pub wait: Duration,
    /// How often an address that is silent is probed.
    pub tries: u32,
    /// Whether those that take a CRC-32C only (§L/7) are looked for too, in a second round.
    pub crc32c: bool,
    /// How long to hear before the first probe. When somebody else speaks meanwhile, nothing is
    /// probed: a probe would collide with what they say, be it a Stop.
    pub listen: Duration,
    /// Whether the first answer shortens the wait for the others, which are as far away: to
    /// [`ADAPTED`] and four times its round trip.
    pub adapt: bool,
}

/// The least wait where it adapts: as long as a bus takes for an answer.
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
    /// Its address.
    pub address: u8,
    /// It answers frames with this check; Crc32c: with nothing else (§L/7).
    pub check: Check,
    /// How long its answer took.
    pub rtt: Duration,
    /// More than one device answered a probe: two have the same address.
    pub doubled: bool,
}

/// What a scan has come to.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// Who answered, by address.
    pub present: Vec<Present>,
    /// Addresses that speak without being asked by us: consoles, a bus controller.
    pub speakers: Vec<u8>,
    /// The line hears itself.
    pub echo: bool,
    /// Frames that came broken.
    pub broken: u64,
    /// Bytes came unasked that are no frames: noise, or others at another speed.
    pub garbage: bool,
    /// Nothing was probed, because others speak: see [`ScanOptions::listen`].
    pub held_back: bool,
}

/// Probes one address after the other; `progress` is told which.
///
/// On a bus with a controller or another console nobody else may speak unasked.
/// [`Scan::speakers`] tells whether there was one.
///
/// # Errors
///
/// That of the link when it is lost: what was found until then is lost too.
pub async fn scan(
    link: Link,
    source: u8,
    options: &ScanOptions,
    mut progress: impl FnMut(u8),
) -> io::Result<Scan> {
    let mut prober = Prober::new(link, source);
    let mut scan = Scan::default();
    let heard = prober.listen(options.listen).await?;
    // Bytes that are no frames may be those of others at another speed.
    scan.garbage = heard.is_garbage();
    scan.note(heard, source, &[0; 256]);
    if !scan.speakers.is_empty() || scan.garbage {
        scan.held_back = true;
        return Ok(scan);
    }
    let mut sent = [0; 256];
    // Who has set Check = 1 is rare, so that the second round is a short one.
    let rounds = [(Check::Crc16, options.tries.max(1)), (Check::Crc32c, options.crc32c.into())];
    for (check, tries) in rounds.into_iter().filter(|(_, tries)| *tries > 0) {
        for address in options.addresses.clone().filter(|address| *address != source) {
            if scan.present.iter().any(|present| present.address == address) {
                continue;
            }
            progress(address);
            for _ in 0..tries {
                let heard = prober.ask(address, &[], check, scan.wait(options)).await?;
                sent[usize::from(address)] += 1;
                if scan.note(heard, source, &sent) {
                    break;
                }
            }
        }
    }
    // What came too late for its probe is there all the same.
    let late = prober.listen(options.wait).await?;
    scan.note(late, source, &sent);
    scan.present.sort_by_key(|present| present.address);
    Ok(scan)
}

impl Scan {
    /// How long the next probe may take.
    fn wait(&self, options: &ScanOptions) -> Duration {
        let slowest = self.present.iter().map(|present| present.rtt).max();
        match slowest.filter(|_| options.adapt) {
            Some(slowest) => (ADAPTED + slowest * 4).min(options.wait),
            None => options.wait,
        }
    }

    /// Keeps what was heard; whether somebody answered. `sent`: probes to each address.
    fn note(&mut self, heard: Heard, source: u8, sent: &[u32; 256]) -> bool {
        self.echo |= heard.echoes > 0;
        self.broken += heard.broken;
        let mut answered = false;
        for frame in heard.frames {
            if frame.dst != source {
                // A device that answers somebody else was asked by somebody else.
                let speaker =
                    if bus::MONITORS.contains(&frame.src) { frame.dst } else { frame.src };
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
