//! The looks, from the least to the most.

use std::io;
use std::time::Duration;

use lafet_proto::bus;
use lafet_proto::link::Check;
use lafet_proto::record::Records;

use super::finding::speaks_text;
use super::{Evidence, Exchange, Speed};
use crate::prober::{Heard, HeardFrame, Prober};
use crate::scan::{ScanOptions, is_answer, question, scan};
use crate::transport::Link;
use crate::url::{Addresses, Endpoint, Framing};

/// Probes to the address of the URL.
const PROBES: u32 = 3;
/// Speeds in use: those of the bus (observed) and others that adapters are left at.
const SPEEDS: [u32; 7] = [19_200, 57_600, 115_200, 9_600, 38_400, 4_800, 2_400];

/// How long, and how much.
#[derive(Clone, Debug)]
pub struct Options {
    /// How long to hear before anything is asked. A bus controller speaks at least once a second.
    pub quiet: Duration,
    /// How long an answer may take.
    pub wait: Duration,
    /// How long an answer may take when other addresses and speeds are tried.
    pub probe_wait: Duration,
    /// Requests that tell how many are lost.
    pub requests: u32,
    /// Ask even when others speak on the line: what is asked may collide with what they say, be it
    /// a Stop.
    pub insist: bool,
}

impl Options {
    /// What a line of this kind needs: serial answers come at once, those of a network later.
    pub fn of(endpoint: &Endpoint) -> Self {
        let (wait, probe_wait) = match endpoint {
            Endpoint::Serial { .. } | Endpoint::Sim { .. } => {
                (bus::REPLY_TIMEOUT_MS, bus::PROBE_TIMEOUT_MS)
            }
            _ => (500, 80),
        };
        Self {
            quiet: Duration::from_millis(1500),
            wait: Duration::from_millis(wait.into()),
            probe_wait: Duration::from_millis(probe_wait.into()),
            requests: 30,
            insist: false,
        }
    }
}

/// Looks at a link. `dial` opens it: for a serial line also at other speeds. `progress` is told
/// what is looked at, in English and Russian.
pub async fn examine(
    endpoint: &Endpoint,
    options: &Options,
    mut dial: impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
    mut progress: impl FnMut(&'static str, &'static str),
) -> Evidence {
    let mut evidence = Evidence::new(endpoint);
    let looked = look(&mut evidence, options, &mut dial, &mut progress).await;
    if let Err(error) = looked {
        evidence.lost = Some(error.to_string());
    }
    evidence
}

async fn look(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
    progress: &mut impl FnMut(&'static str, &'static str),
) -> io::Result<()> {
    let endpoint = evidence.endpoint.clone();
    let Addresses { monitor, source } = endpoint.addresses();
    progress("opening the link", "открываю линию");
    let mut prober = Prober::new(dial(&endpoint).await?, source);
    progress("listening", "слушаю");
    evidence.quiet = prober.listen(options.quiet).await?;
    evidence.quiet_for = options.quiet;
    let others = |frame: &HeardFrame| frame.src != source && frame.dst != source;
    evidence.held_back = !options.insist && evidence.quiet.frames.iter().any(others);
    if evidence.held_back {
        return Ok(());
    }
    progress("probing", "вызываю ствол");
    if endpoint.framing() == Framing::Records {
        look_at_records(evidence, options, &mut prober).await?;
        if !evidence.is_answered() {
            let mut prober = Prober::new(dial(&endpoint).await?, source);
            let heard = prober.ask(monitor, &[], Check::Crc16, options.wait).await?;
            evidence.other_framing = heard.frames.iter().any(|frame| frame.dst == source);
        }
        return Ok(());
    }
    probe(evidence, options, &mut prober).await?;
    if evidence.is_answered() {
        progress("asking", "спрашиваю");
        let check = if evidence.crc32c_only { Check::Crc32c } else { Check::Crc16 };
        evidence.exchange = Some(exchange(&mut prober, monitor, check, options).await?);
        return Ok(());
    }
    drop(prober);
    if speaks_text(&evidence.probed) {
        return Ok(());
    }
    if matches!(endpoint, Endpoint::Tcp { .. }) {
        // What has heard link frames may wait for the end of a long record.
        let mut prober = Prober::new(dial(&endpoint).await?, source);
        evidence.other_framing = bare_record(&mut prober, options).await?.1;
        if evidence.other_framing {
            return Ok(());
        }
    }
    progress("trying the other addresses", "пробую другие адреса");
    let addresses =
        ScanOptions { wait: options.probe_wait, tries: 1, crc32c: false, ..ScanOptions::default() };
    let found = scan(dial(&endpoint).await?, source, &addresses, |_| {}).await?;
    evidence.others = found.present.iter().map(|present| present.address).collect();
    // A monitor that was only late is no other one.
    if evidence.others.contains(&monitor) {
        evidence.answered += 1;
        evidence.others.retain(|address| *address != monitor);
        let mut prober = Prober::new(dial(&endpoint).await?, source);
        evidence.exchange = Some(exchange(&mut prober, monitor, Check::Crc16, options).await?);
    } else if evidence.others.is_empty() {
        progress("trying other speeds", "пробую другие скорости");
        speeds(evidence, options, dial).await?;
    }
    Ok(())
}

/// Presence probes, and in the end those with a CRC-32C.
async fn probe(evidence: &mut Evidence, options: &Options, prober: &mut Prober) -> io::Result<()> {
    let Addresses { monitor, source } = evidence.endpoint.addresses();
    for _ in 0..PROBES {
        evidence.probes += 1;
        let mut heard = prober.ask(monitor, &[], Check::Crc16, options.wait).await?;
        let answered = heard.from(monitor, source).count() > 0;
        if answered {
            // A second one of this address answers at the same time.
            heard.add(prober.listen(options.probe_wait).await?);
        }
        let count = heard.from(monitor, source).count();
        evidence.answered += u32::from(answered);
        // Answers to earlier probes may come late; to the first there is nothing earlier.
        evidence.doubled |= evidence.probes == 1 && count > 1;
        evidence.probed.add(heard);
    }
    if !evidence.is_answered() {
        let heard = prober.ask(monitor, &[], Check::Crc32c, options.wait).await?;
        evidence.crc32c_only =
            heard.from(monitor, source).any(|frame| frame.check == Check::Crc32c);
        evidence.answered += u32::from(evidence.crc32c_only);
        evidence.probed.add(heard);
    }
    Ok(())
}

/// Bare records have no probes: a request that changes nothing stands for one.
async fn look_at_records(
    evidence: &mut Evidence,
    options: &Options,
    prober: &mut Prober,
) -> io::Result<()> {
    evidence.probes = 1;
    let (heard, answered) = bare_record(prober, options).await?;
    evidence.probed = heard;
    evidence.answered = u32::from(answered);
    Ok(())
}

async fn bare_record(prober: &mut Prober, options: &Options) -> io::Result<(Heard, bool)> {
    let heard = prober.say(&question(), options.wait).await?;
    let mut records = Records::new(&heard.sample);
    let answered = matches!(records.next(), Some(Ok(record)) if is_answer(&record));
    Ok((heard, answered))
}

async fn exchange(
    prober: &mut Prober,
    monitor: u8,
    check: Check,
    options: &Options,
) -> io::Result<Exchange> {
    let mut exchange = Exchange::default();
    let mut total = Duration::ZERO;
    for _ in 0..options.requests {
        exchange.sent += 1;
        let heard = prober.ask(monitor, &question(), check, options.wait).await?;
        if let Some(answer) = heard.frames.iter().rfind(|frame| frame.src == monitor) {
            exchange.answered += 1;
            exchange.rtt_max = exchange.rtt_max.max(answer.after);
            total += answer.after;
        }
        exchange.heard.add(heard);
    }
    exchange.rtt_mean = total / exchange.answered.max(1);
    Ok(exchange)
}

/// A serial line at the speeds that it is not set to.
async fn speeds(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<()> {
    let Endpoint::Serial { path, line, addresses, manner } = evidence.endpoint.clone() else {
        return Ok(());
    };
    for baud in SPEEDS.into_iter().filter(|baud| *baud != line.baud) {
        let line = crate::url::SerialLine { baud, ..line };
        let at = Endpoint::Serial { path: path.clone(), line, addresses, manner };
        // A port that does not know a speed is no use at it.
        let Ok(link) = dial(&at).await else { continue };
        let mut prober = Prober::new(link, addresses.source);
        let mut heard = prober.listen(options.wait).await?;
        let mut answered = false;
        for _ in 0..2 {
            let probed = prober.ask(addresses.monitor, &[], Check::Crc16, options.wait).await?;
            answered |= probed.from(addresses.monitor, addresses.source).count() > 0;
            heard.add(probed);
        }
        evidence.speeds.push(Speed { baud, heard, answered });
        if answered {
            break;
        }
    }
    Ok(())
}
