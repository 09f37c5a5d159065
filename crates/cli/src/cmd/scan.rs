//! `lafet scan`: finds the devices on a bus or a network.

use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use lafet_client::overhear::CONTROLLER_PAUSE;
use lafet_client::scan::{Place, Present, Scan, ScanOptions, Told, hosts, scan, scan_network};
use lafet_client::transport::Link;
use lafet_client::{Behaviour, Endpoint, Error, Framing};
use lafet_proto::bus;
use lafet_proto::link::Check;
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};
use tokio::time::{Instant, interval};

use crate::cli::Global;
use crate::connect::{
    Connection, THOROUGH, can_be_overheard, disturbs, giving_way, link, listened, url_of,
};
use crate::failure::{Failure, Outcome};
use crate::lang::{current, decimal};
use crate::out::{Out, columns};

/// How long a probe may take over a network, ms.
const NETWORK_WAIT_MS: u64 = 100;

/// Interval at which the elapsed time is shown.
const TICK: Duration = Duration::from_secs(1);
/// Addresses per line of progress.
const BLOCK: u8 = 16;

/// Arguments of `lafet scan`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c serial:///dev/ttyUSB0?baud=19200 scan\n  \
                        lafet -c tcp://192.168.1.50:4001 scan --addresses 1-16\n  \
                        lafet scan 192.168.1.0/24\n  \
                        lafet scan 192.168.1.10-40 --port 10485,10486,4001 --addresses 1-8")]
pub struct ScanArgs {
    #[arg(value_name = "HOSTS", value_parser = a_range)]
    hosts: Vec<Hosts>,
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_values_t = [bus::PORT_EXTERNAL_CONN, bus::PORT_RADIO],
        value_parser = clap::value_parser!(u16).range(1..),
        requires = "hosts"
    )]
    port: Vec<u16>,
    #[arg(long, requires = "hosts")]
    udp: bool,
    #[arg(long, value_name = "RANGE", default_value = "1-127", value_parser = addresses)]
    addresses: RangeInclusive<u8>,
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    wait: Option<u64>,
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=10))]
    tries: u32,
    #[arg(long)]
    brief: bool,
}

/// The hosts given by one argument.
#[derive(Clone, Debug)]
pub struct Hosts(Vec<String>);

fn a_range(text: &str) -> Result<Hosts, String> {
    hosts(text).map(Hosts).ok_or_else(|| text::HostsExpected.str(current()).into())
}

fn addresses(text: &str) -> Result<RangeInclusive<u8>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let known = 1..=*bus::CONSOLES.end();
    match (first.parse::<u8>(), last.parse::<u8>()) {
        (Ok(first), Ok(last))
            if first <= last && known.contains(&first) && known.contains(&last) =>
        {
            Ok(first..=last)
        }
        _ => Err(text::ScanAddressesExpected.str(current()).into()),
    }
}

/// Runs `lafet scan`.
pub async fn run(args: ScanArgs, global: &Global, out: &mut Out) -> Outcome {
    if args.hosts.is_empty() {
        scan_bus(&args, global, out).await
    } else {
        network(&args, global, out).await
    }
}

async fn scan_bus(args: &ScanArgs, global: &Global, out: &mut Out) -> Outcome {
    let url = url_of(global)?;
    let endpoint = Endpoint::from_str(url).map_err(Error::from)?;
    if endpoint.framing() == Framing::Records {
        return Err(Failure::Usage(text::NothingToScan.str(current()).into()));
    }
    let usual = match endpoint {
        Endpoint::Serial { .. } | Endpoint::Sim { .. } => bus::PROBE_TIMEOUT_MS.into(),
        _ => NETWORK_WAIT_MS,
    };
    // It listens before, at every speed.
    let options = options(args, usual, false);
    let probing = text::ProbingAddresses.str(current());
    let source = endpoint.addresses().source;
    let lost = |source: std::io::Error| Error::Link { endpoint: url.into(), source: source.into() };
    let shown = RefCell::new(&mut *out);
    let tell = |address: u8| {
        // Where progress lines stay on the screen, one per address would be too many.
        if address % BLOCK == 1 || address == *args.addresses.start() {
            let last = address.saturating_add(BLOCK - 1).min(*args.addresses.end());
            shown.borrow_mut().progress(format!("{probing} {address}…{last}"));
        }
    };
    let (place, how) = (&endpoint, &options);
    let scan = giving_way(url, place, options.wait, || async move {
        let link = quiet(url, place, global).await?;
        Ok::<Scan, Failure>(scan(link, source, how, tell).await.map_err(lost)?)
    });
    let scan = scan.await??;
    let mut rows = Vec::new();
    let mut devices = Vec::new();
    for present in &scan.present {
        let at = at_address(&endpoint, present.address);
        let consists = consists(args, global, &at, present).await;
        rows.push(row(&at, present, &consists));
        devices.push(device_json(&at, present, &consists));
    }
    if scan.present.is_empty() {
        out.say(nobody(&args.addresses))?;
    }
    let mut text = columns(&rows);
    for remark in remarks(&scan) {
        text.push_str(if text.is_empty() { "" } else { "\n" });
        text.push_str(&remark);
    }
    let json = || {
        json!({
            "devices": devices,
            "speakers": scan.speakers,
            "echo": scan.echo,
            "broken_frames": scan.broken,
        })
    };
    if !text.is_empty() || out.json() {
        out.show(text, json)?;
    }
    found(!scan.present.is_empty())
}

/// Opens a line on which no other device transmits: listens to it, at every speed, unless the user
/// insists.
async fn quiet(url: &str, endpoint: &Endpoint, global: &Global) -> Result<Link, Failure> {
    if global.insist || !can_be_overheard(endpoint) {
        return link(url, endpoint).await;
    }
    let (link, heard) = listened(url, endpoint, THOROUGH).await?;
    let speakers = heard.speakers();
    if heard.elsewhere.is_some()
        && let Some(why) = disturbs(url, endpoint, &heard)
    {
        return Err(Failure::Ended(why));
    }
    match speakers.is_empty() && !heard.unreadable {
        true => Ok(link),
        false => Err(Failure::Ended(why_held_back(&speakers))),
    }
}

/// Why nothing was probed.
fn why_held_back(speakers: &[u8]) -> String {
    if speakers.is_empty() {
        return text::NoiseBeforeScan.str(current()).into();
    }
    let who = speakers.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
    text::OthersBeforeScan { who }.of(current())
}

async fn network(args: &ScanArgs, global: &Global, out: &mut Out) -> Outcome {
    let hosts: Vec<String> = args.hosts.iter().flat_map(|hosts| hosts.0.clone()).collect();
    let options = options(args, NETWORK_WAIT_MS, !args.udp && !global.insist);
    let places = places(&hosts, args, &options, out).await;
    let mut rows = Vec::new();
    let mut all = Vec::new();
    let mut any = false;
    let mut held_back = None;
    for place in &places {
        let endpoint = endpoint(place, args.udp, Framing::Link);
        match &place.told {
            Told::Bus(scan) if scan.held_back => {
                rows.push(vec![endpoint.to_string(), why_held_back(&scan.speakers)]);
                all.push(json!({ "url": endpoint.to_string(), "others": scan.speakers }));
                held_back = Some(why_held_back(&scan.speakers));
            }
            Told::Bus(scan) => {
                for present in &scan.present {
                    let at = at_address(&endpoint, present.address);
                    let consists = consists(args, global, &at, present).await;
                    rows.push(row(&at, present, &consists));
                    all.push(device_json(&at, present, &consists));
                    any = true;
                }
            }
            Told::Records => {
                let at = self::endpoint(place, false, Framing::Records).to_string();
                rows.push(vec![at.clone(), text::AnswersBareRecords.str(current()).into()]);
                all.push(json!({ "url": at, "framing": "records" }));
                any = true;
            }
            Told::Silent => {
                let silent = text::OpenWithoutMonitor.str(current());
                rows.push(vec![format!("tcp://{}:{}", place.host, place.port), silent.into()]);
                all.push(json!({ "url": endpoint.to_string(), "silent": true }));
            }
        }
    }
    if rows.is_empty() {
        let none = text::NoOpenPort.str(current());
        out.show(none, || json!([]))?;
    } else {
        out.show(columns(&rows), || Value::Array(all))?;
    }
    match held_back {
        Some(why) if !any => Err(Failure::Ended(why)),
        _ => found(any),
    }
}

/// Examines each port; shows progress.
async fn places(
    hosts: &[String],
    args: &ScanArgs,
    options: &ScanOptions,
    out: &mut Out,
) -> Vec<Place> {
    let began = Instant::now();
    let tried = Cell::new((0, hosts.len() * args.port.len()));
    let scan = scan_network(hosts, &args.port, args.udp, options, |done, all| {
        tried.set((done, all));
    });
    tokio::pin!(scan);
    let mut ticks = interval(TICK);
    loop {
        tokio::select! {
            places = &mut scan => return places,
            _ = ticks.tick() => {
                let ((done, all), seconds) = (tried.get(), began.elapsed().as_secs());
                out.seldom(text::PortsExamined { done, all, seconds }.of(current()));
            }
        }
    }
}

/// `listen`: others may be on the line, behind a serial server too.
fn options(args: &ScanArgs, usual_ms: u64, listen: bool) -> ScanOptions {
    ScanOptions {
        addresses: args.addresses.clone(),
        wait: Duration::from_millis(args.wait.unwrap_or(usual_ms)),
        tries: args.tries,
        crc32c: true,
        listen: if listen { CONTROLLER_PAUSE } else { Duration::ZERO },
        // A timeout chosen by the user is kept.
        adapt: args.wait.is_none(),
    }
}

fn endpoint(place: &Place, udp: bool, framing: Framing) -> Endpoint {
    let (host, port, addresses) = (place.host.clone(), place.port, Default::default());
    let behaviour = Behaviour::default();
    match udp {
        true => Endpoint::Udp { host, port, addresses, behaviour },
        false => Endpoint::Tcp { host, port, framing, addresses, behaviour },
    }
}

/// The URL of the device at another address of the same link.
fn at_address(endpoint: &Endpoint, address: u8) -> String {
    let mut endpoint = endpoint.clone();
    match &mut endpoint {
        Endpoint::Tcp { addresses, .. }
        | Endpoint::Udp { addresses, .. }
        | Endpoint::Serial { addresses, .. }
        | Endpoint::Sim { addresses, .. } => addresses.monitor = address,
    }
    endpoint.to_string()
}

/// Names of a monitor's subsystems; empty when it was not asked or did not answer.
async fn consists(args: &ScanArgs, global: &Global, url: &str, present: &Present) -> Vec<String> {
    if args.brief || !bus::MONITORS.contains(&present.address) || present.check != Check::Crc16 {
        return Vec::new();
    }
    let global = Global { connect: Some(url.to_owned()), ..global.clone() };
    let Ok(connection) = Connection::open_heard(&global).await else { return Vec::new() };
    match connection.monitor.status_all().await {
        Ok(status) => status.present().map(|who| who.to_string()).collect(),
        Err(_) => Vec::new(),
    }
}

fn row(url: &str, present: &Present, consists: &[String]) -> Vec<String> {
    let mut what = match present.address {
        bus::CONTROLLER => text::BusController.str(current()).to_owned(),
        address if bus::CONSOLES.contains(&address) => text::Console.str(current()).into(),
        _ => text::HeadingMonitor.str(current()).into(),
    };
    if present.check == Check::Crc32c {
        what.push_str(text::Crc32cOnly.str(current()));
    }
    if present.doubled {
        what.push_str(text::TwoHaveAddress.str(current()));
    }
    let ms = format!(
        "{} {}",
        decimal(present.rtt.as_secs_f64() * 1000.0, 1),
        text::UnitMs.str(current())
    );
    vec![url.to_owned(), what, ms, consists.join(" ")]
}

fn device_json(url: &str, present: &Present, consists: &[String]) -> Value {
    json!({
        "url": url,
        "address": present.address,
        "rtt_ms": present.rtt.as_secs_f64() * 1000.0,
        "crc32c_only": present.check == Check::Crc32c,
        "doubled": present.doubled,
        "subsystems": consists,
    })
}

fn remarks(scan: &Scan) -> Vec<String> {
    let mut all = Vec::new();
    if !scan.speakers.is_empty() {
        let who: Vec<String> = scan.speakers.iter().map(u8::to_string).collect();
        let who = who.join(", ");
        all.push(text::OthersAfterScan { who }.of(current()));
    }
    if scan.broken > 0 {
        let broken = scan.broken;
        all.push(text::BrokenFrames { broken }.of(current()));
    }
    all
}

fn nobody(addresses: &RangeInclusive<u8>) -> String {
    let (first, last) = (addresses.start(), addresses.end());
    text::NobodyAtAddresses { first, last }.of(current())
}

/// Fails if no monitor was found.
fn found(any: bool) -> Outcome {
    if any { Ok(()) } else { Err(Failure::Ended(text::NoMonitorFound.str(current()).into())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_hosts() {
        assert_eq!(addresses("1-127"), Ok(1..=127));
        assert_eq!(addresses("7"), Ok(7..=7));
        for wrong in ["", "0-5", "9-3", "1-255", "x"] {
            assert!(addresses(wrong).is_err(), "{wrong}");
        }
        assert_eq!(a_range("10.0.0.1-3").unwrap().0.len(), 3);
        assert!(a_range("10.0.0.0/8").is_err());
    }

    /// The first answer shortens the waits after it, unless the user has chosen them.
    #[test]
    fn a_wait_adapts_where_none_is_chosen() {
        #[derive(Debug, clap::Parser)]
        struct Line {
            #[command(flatten)]
            args: ScanArgs,
        }
        let adapts = |words: &[&str]| {
            let words = std::iter::once("scan").chain(words.iter().copied());
            let line = <Line as clap::Parser>::try_parse_from(words).unwrap();
            options(&line.args, NETWORK_WAIT_MS, true).adapt
        };
        assert!(adapts(&["10.0.0.1"]));
        assert!(adapts(&[]));
        for chosen in [&["10.0.0.1", "--wait", "100"][..], &["--wait", "100"]] {
            assert!(!adapts(chosen), "{chosen:?}");
        }
    }
}
