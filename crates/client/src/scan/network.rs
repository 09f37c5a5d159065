//! Monitors on a network: open ports of a range of hosts, with probes at each.

use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId, record};
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio::time::timeout;

use super::{Scan, ScanOptions, scan};
use crate::prober::Prober;
use crate::transport::Link;
use crate::url::{Addresses, Behaviour, Endpoint, Framing};

/// Most hosts of one scan: a /20.
pub const HOSTS_MAX: usize = 4096;
/// Connections that are tried at the same time.
const PARALLEL: usize = 64;
/// Open ports that are examined at the same time. Each takes seconds, so they do not keep others from
/// being tried; each has a socket, of which a program may have 1024 by default.
const EXAMINED: usize = 512;
/// Longest time for a connection to a host of a local network.
const CONNECT: Duration = Duration::from_millis(700);

/// A host, by name or address.
pub type Host = String;

/// Result for an open port.
#[derive(Clone, Debug)]
pub struct Place {
    /// The host.
    pub host: Host,
    /// The port.
    pub port: u16,
    /// What was found there.
    pub told: Told,
}

/// What was found at a port.
#[derive(Clone, Debug)]
pub enum Told {
    /// Devices that answer probes, or others that talk, so that nothing was probed.
    Bus(Scan),
    /// A monitor with bare records (§C/3).
    Records,
    /// Open, but no device answers.
    Silent,
}

/// Parses hosts: `192.168.1.0/24`, `192.168.1.10-40`, `192.168.1.7` or a name; `None` if the text
/// is none of these, or for more than [`HOSTS_MAX`].
pub fn hosts(text: &str) -> Option<Vec<Host>> {
    let all = |first: u32, last: u32| {
        let count = last.checked_sub(first)? as usize;
        (count < HOSTS_MAX)
            .then(|| (first..=last).map(|host| Ipv4Addr::from(host).to_string()).collect())
    };
    if let Some((network, bits)) = text.split_once('/') {
        let network = u32::from(network.parse::<Ipv4Addr>().ok()?);
        let bits: u32 = bits.parse().ok().filter(|bits| *bits <= 32)?;
        let mask = u32::MAX.checked_shl(32 - bits).unwrap_or(0);
        let (first, last) = (network & mask, network | !mask);
        // The first and the last address of a network are not hosts.
        let inner = u32::from(bits < 31);
        return all(first + inner, last - inner);
    }
    if let Some((first, last)) = text.split_once('-')
        && let Ok(first) = first.parse::<Ipv4Addr>()
    {
        let start = u32::from(first);
        let last = match last.parse::<u8>() {
            Ok(last) => start & !0xFF | u32::from(last),
            Err(_) => u32::from(last.parse::<Ipv4Addr>().ok()?),
        };
        return all(start, last);
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || "-.:_".contains(c);
    (!text.is_empty() && text.chars().all(plain)).then(|| vec![text.to_owned()])
}

/// Tries every port of every host, many at a time. Closed ports are left out; `progress` is called
/// with the number of ports tried so far.
pub async fn scan_network(
    hosts: &[Host],
    ports: &[u16],
    udp: bool,
    options: &ScanOptions,
    mut progress: impl FnMut(usize, usize),
) -> Vec<Place> {
    let turns = Arc::new((Semaphore::new(PARALLEL), Semaphore::new(EXAMINED)));
    let mut tasks = JoinSet::new();
    for (order, host) in hosts.iter().enumerate() {
        for port in ports {
            let (host, port, turns, options) =
                (host.clone(), *port, turns.clone(), options.clone());
            tasks.spawn(async move {
                let (tried, examined) = &*turns;
                // The semaphores are never closed.
                let _place = examined.acquire().await;
                let turn = tried.acquire().await;
                let (endpoint, link) = reach(&host, port, udp).await?;
                drop(turn);
                let told = look(&endpoint, link, &options).await?;
                Some((order, Place { host, port, told }))
            });
        }
    }
    let (mut tried, all) = (0, tasks.len());
    let mut places = Vec::new();
    while let Some(done) = tasks.join_next().await {
        tried += 1;
        progress(tried, all);
        places.extend(done.ok().flatten());
    }
    places.sort_by_key(|(order, place)| (*order, place.port));
    places.into_iter().map(|(_, place)| place).collect()
}

/// A port and its link; `None` if it is closed.
async fn reach(host: &str, port: u16, udp: bool) -> Option<(Endpoint, Link)> {
    let (addresses, behaviour) = (Addresses::default(), Behaviour::default());
    let host = host.to_owned();
    let endpoint = match udp {
        true => Endpoint::Udp { host, port, addresses, behaviour },
        false => Endpoint::Tcp { host, port, framing: Framing::Link, addresses, behaviour },
    };
    let link = open(&endpoint).await.ok()?;
    Some((endpoint, link))
}

/// The result for an open port; `None` if nothing answers over UDP.
async fn look(endpoint: &Endpoint, link: Link, options: &ScanOptions) -> Option<Told> {
    let scanned = scan(link, endpoint.addresses().source, options, |_| {}).await;
    match scanned {
        // Others talk there: nothing more is sent.
        Ok(scan) if scan.held_back || !scan.present.is_empty() => Some(Told::Bus(scan)),
        _ if matches!(endpoint, Endpoint::Udp { .. }) => None,
        // Open, but without link frames.
        _ => Some(match speaks_records(endpoint, options.wait).await {
            Ok(true) => Told::Records,
            _ => Told::Silent,
        }),
    }
}

async fn open(endpoint: &Endpoint) -> io::Result<Link> {
    timeout(CONNECT, Link::open(endpoint)).await.unwrap_or(Err(io::ErrorKind::TimedOut.into()))
}

async fn speaks_records(endpoint: &Endpoint, wait: Duration) -> io::Result<bool> {
    let mut prober = Prober::new(open(endpoint).await?, endpoint.addresses().source);
    let heard = prober.say(&question(), wait).await?;
    let mut records = record::Records::new(&heard.sample);
    Ok(matches!(records.next(), Some(Ok(record)) if is_answer(&record)))
}

/// GetStatus General as a record: a monitor without link frames answers it.
pub(crate) fn question() -> Vec<u8> {
    let mut buffer = [0; record::HEADER_SIZE];
    let mut writer = record::Writer::new(&mut buffer);
    match Request::new(SubsystemId::GENERAL, Body::GetStatus).encode(&mut writer) {
        Ok(()) => writer.written().to_vec(),
        Err(_) => Vec::new(),
    }
}

/// Whether a record answers [`question`].
pub(crate) fn is_answer(record: &record::Record<'_>) -> bool {
    record.request == RequestId::GET_STATUS && record.device == SubsystemId::GENERAL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_hosts() {
        let all = |text: &str| hosts(text).unwrap_or_default();
        assert_eq!(all("10.0.0.0/30"), ["10.0.0.1", "10.0.0.2"]);
        assert_eq!(all("10.0.0.7/24").len(), 254);
        assert_eq!(all("10.0.0.7/32"), ["10.0.0.7"]);
        assert_eq!(all("10.0.0.7-9"), ["10.0.0.7", "10.0.0.8", "10.0.0.9"]);
        assert_eq!(all("10.0.0.255-10.0.1.1").len(), 3);
        for one in ["10.0.0.7", "monitor-7.local", "::1"] {
            assert_eq!(all(one), [one]);
        }
        for wrong in ["", "10.0.0.0/8", "10.0.0.0/33", "10.0.0.9-7", "a b", "x/24", "0.0.0.0/0"] {
            assert_eq!(hosts(wrong), None, "{wrong}");
        }
    }
}
