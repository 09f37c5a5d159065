//! The checks of a diagnosis, in the order in which they are made.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::bus;
use lafet_proto::link::Check;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Answer, Request, SubsystemId};
use lafet_texts::{Fixed, client as text};
use tokio::time::Instant;

use super::finding::speaks_text;
use super::{Evidence, Exchange, Speed};
use crate::overhear::{self, CONTROLLER_PAUSE};
use crate::prober::{Heard, HeardFrame, Prober};
use crate::scan::{ScanOptions, is_answer, question, scan};
use crate::transport::Link;
use crate::url::{Addresses, Endpoint, Framing, Role};
use crate::{Client, Config, Error};

/// Probes to the monitor's address.
const PROBES: u32 = 3;
/// Probes of both forms, whose answers may come late.
const LATE_PROBES: u32 = PROBES + 1;

/// Durations and number of requests of a diagnosis.
#[derive(Clone, Debug)]
pub struct Options {
    /// Time to listen before anything is sent: [`CONTROLLER_PAUSE`].
    pub quiet: Duration,
    /// Longest wait for an answer.
    pub wait: Duration,
    /// Longest wait for an answer at other addresses and speeds.
    pub probe_wait: Duration,
    /// Requests sent to measure losses.
    pub requests: u32,
    /// Send even if other devices transmit on the line: the probes may collide with their frames,
    /// possibly with a Stop.
    pub insist: bool,
}

impl Options {
    /// Options for this kind of link: answers on a serial line come at once, those of a network
    /// later.
    pub fn of(endpoint: &Endpoint) -> Self {
        let (wait, probe_wait) = match endpoint {
            Endpoint::Serial { .. } | Endpoint::Sim { .. } => {
                (bus::REPLY_TIMEOUT_MS, bus::PROBE_TIMEOUT_MS)
            }
            _ => (500, 80),
        };
        Self {
            quiet: CONTROLLER_PAUSE,
            wait: Duration::from_millis(wait.into()),
            probe_wait: Duration::from_millis(probe_wait.into()),
            requests: 30,
            insist: false,
        }
    }
}

/// Examines a link. `dial` opens it; a serial line also at other speeds. `progress` is called with
/// each step, in English and Russian.
pub async fn examine(
    endpoint: &Endpoint,
    options: &Options,
    mut dial: impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
    mut progress: impl FnMut(Fixed),
) -> Evidence {
    let mut evidence = Evidence::new(endpoint);
    let looked = look(&mut evidence, options, &mut dial, &mut progress).await;
    if let Err(error) = looked {
        evidence.lost = Some(Arc::new(error));
    }
    evidence
}

async fn look(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
    progress: &mut impl FnMut(Fixed),
) -> io::Result<()> {
    let endpoint = evidence.endpoint.clone();
    let Addresses { monitor, source } = endpoint.addresses();
    progress(text::DoingOpen.fixed());
    let mut prober = Prober::new(dial(&endpoint).await?, source);
    progress(text::DoingListen.fixed());
    let unreadable = listen(evidence, options, &mut prober).await?;
    // A monitor's frame to our address may be a late answer to another program.
    let unasked = |frame: &HeardFrame| frame.dst != source || !bus::MONITORS.contains(&frame.src);
    evidence.held_back = !options.insist && evidence.quiet.frames.iter().any(unasked);
    if evidence.held_back && endpoint.behaviour().role == Role::Direct {
        return Ok(());
    }
    if endpoint.behaviour().role == Role::Active {
        drop(prober);
        evidence.held_back = false;
        progress(text::DoingWaitForAccess.fixed());
        return as_console(evidence, options, dial).await;
    }
    if matches!(endpoint, Endpoint::Serial { .. }) && evidence.quiet.frames.is_empty() {
        drop(prober);
        progress(text::DoingListenAtSpeeds.fixed());
        let time = if unreadable { options.quiet } else { options.wait };
        listen_elsewhere(evidence, time, dial).await?;
        if evidence.speeds.iter().any(Speed::has_others) {
            // Frames at a wrong speed reach no device and disturb those of others.
            evidence.held_back = true;
            return Ok(());
        }
        prober = Prober::new(dial(&endpoint).await?, source);
    }
    if unreadable && !options.insist {
        // Devices at a speed that was not tried, or paused while it was.
        evidence.held_back = true;
        return Ok(());
    }
    progress(text::DoingProbe.fixed());
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
        progress(text::DoingAsk.fixed());
        let check = if evidence.crc32c_only { Check::Crc32c } else { Check::Crc16 };
        evidence.exchange =
            Some(exchange(&mut prober, endpoint.addresses(), check, options).await?);
        return Ok(());
    }
    drop(prober);
    if speaks_text(&evidence.probed) {
        return Ok(());
    }
    if matches!(endpoint, Endpoint::Tcp { .. }) {
        // A device that has received link frames may wait for the end of a long record.
        let mut prober = Prober::new(dial(&endpoint).await?, source);
        evidence.other_framing = bare_record(&mut prober, options).await?.1;
        if evidence.other_framing {
            return Ok(());
        }
    }
    look_elsewhere(evidence, options, dial, progress).await
}

/// Listens before anything is sent; returns whether bytes keep coming that are no frames.
async fn listen(
    evidence: &mut Evidence,
    options: &Options,
    prober: &mut Prober,
) -> io::Result<bool> {
    evidence.quiet = prober.listen(options.quiet).await?;
    evidence.quiet_for = options.quiet;
    if !evidence.quiet.is_garbage() || options.insist {
        return Ok(evidence.quiet.is_garbage());
    }
    evidence.quiet_for += options.quiet;
    prober.listen_on(&mut evidence.quiet, options.quiet).await
}

/// Examines the other addresses and, on a serial line, other speeds.
async fn look_elsewhere(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
    progress: &mut impl FnMut(Fixed),
) -> io::Result<()> {
    let endpoint = evidence.endpoint.clone();
    let Addresses { monitor, source } = endpoint.addresses();
    progress(text::DoingAddresses.fixed());
    let addresses =
        ScanOptions { wait: options.probe_wait, tries: 1, crc32c: false, ..ScanOptions::default() };
    let found = scan(dial(&endpoint).await?, source, &addresses, |_| {}).await?;
    evidence.others = found.present.iter().map(|present| present.address).collect();
    // A monitor whose answer was only late is not another one.
    if evidence.others.contains(&monitor) {
        evidence.answered += 1;
        evidence.others.retain(|address| *address != monitor);
        let mut prober = Prober::new(dial(&endpoint).await?, source);
        evidence.exchange =
            Some(exchange(&mut prober, endpoint.addresses(), Check::Crc16, options).await?);
    } else if evidence.others.is_empty() {
        progress(text::DoingSpeeds.fixed());
        speeds(evidence, options, dial).await?;
    }
    Ok(())
}

/// Sends presence probes, at the end those with a CRC-32C.
async fn probe(evidence: &mut Evidence, options: &Options, prober: &mut Prober) -> io::Result<()> {
    let Addresses { monitor, source } = evidence.endpoint.addresses();
    for _ in 0..PROBES {
        evidence.probes += 1;
        let mut heard = prober.ask(monitor, &[], Check::Crc16, options.wait).await?;
        let answered = heard.from(monitor, source).count() > 0;
        if answered {
            // A second device with this address answers at the same time.
            heard.add(prober.listen(options.probe_wait).await?);
        }
        // An answer with records does not belong to a probe: another program uses our address.
        let (probes, records): (Vec<_>, Vec<_>) =
            heard.from(monitor, source).partition(|frame| frame.payload.is_empty());
        let count = probes.len();
        evidence.address_taken |= !records.is_empty();
        evidence.answered += u32::from(answered);
        // Several answers may be late ones to earlier probes, except after the first probe.
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

/// Bare records have no probes: a request that changes nothing is used instead.
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
    Addresses { monitor, source }: Addresses,
    check: Check,
    options: &Options,
) -> io::Result<Exchange> {
    let mut exchange = Exchange::default();
    let (mut total, mut empty) = (Duration::ZERO, 0);
    for _ in 0..options.requests {
        exchange.sent += 1;
        let heard = prober.ask(monitor, &question(), check, options.wait).await?;
        let to_us = |frame: &&HeardFrame| (frame.src, frame.dst) == (monitor, source);
        if let Some(answer) = heard.frames.iter().rfind(to_us) {
            exchange.answered += 1;
            // At most this many may be late answers to probes.
            empty += u32::from(answer.payload.is_empty());
            if !answer.payload.is_empty() || empty > LATE_PROBES {
                exchange.judge(&answer.payload);
            }
            exchange.rtt_max = exchange.rtt_max.max(answer.after);
            total += answer.after;
        }
        exchange.heard.add(heard);
    }
    exchange.rtt_mean = total / exchange.answered.max(1);
    Ok(exchange)
}

impl Exchange {
    /// Whether the payload answers GetStatus General.
    fn judge(&mut self, payload: &[u8]) {
        let mut records = Records::new(payload);
        let first = records.next().and_then(Result::ok);
        let sound = first.is_some_and(|record| {
            let answer = Answer::decode(&record).map(|answer| answer.data);
            is_answer(&record)
                && record.status.is_success()
                && matches!(answer, Ok(Reply::General(_)))
        });
        if !sound || records.next().is_some() {
            self.odd += 1;
            self.odd_sample.get_or_insert_with(|| payload.to_vec());
        }
    }
}

/// Sends GetStatus General in the turns that a bus controller grants.
async fn as_console(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<()> {
    let endpoint = evidence.endpoint.clone();
    let config = Config { tries: 1, ..Config::default() }.of(&endpoint);
    let client = Client::on_link(&endpoint.to_string(), dial(&endpoint).await?, config);
    let mut exchange = Exchange::default();
    let mut total = Duration::ZERO;
    evidence.probes = 1;
    for _ in 0..options.requests {
        let asked = Instant::now();
        let request = Request::new(SubsystemId::GENERAL, Body::GetStatus);
        exchange.sent += 1;
        match client.request(&request).await {
            Ok(answers) if answers.refusal().is_none() => {
                exchange.answered += 1;
                exchange.rtt_max = exchange.rtt_max.max(asked.elapsed());
                total += asked.elapsed();
            }
            Ok(_) | Err(Error::Protocol { .. }) => {
                exchange.answered += 1;
                exchange.odd += 1;
            }
            Err(Error::NotSent { cause, .. }) => {
                evidence.no_access = Some(cause);
                return Ok(());
            }
            // The first request without answer suffices for a monitor that is off.
            Err(_) if exchange.answered == 0 => return Ok(()),
            Err(_) => {}
        }
    }
    exchange.rtt_mean = total / exchange.answered.max(1);
    evidence.answered = 1;
    evidence.exchange = Some(exchange);
    Ok(())
}

/// Listens at other speeds of a serial line.
async fn listen_elsewhere(
    evidence: &mut Evidence,
    time: Duration,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<()> {
    let heard = overhear::listen_elsewhere(&evidence.endpoint, time, dial).await?;
    evidence.speeds.extend(heard.map(|(baud, heard)| Speed { baud, heard, answered: false }));
    Ok(())
}

/// Probes at other speeds of a serial line.
async fn speeds(
    evidence: &mut Evidence,
    options: &Options,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<()> {
    let addresses = evidence.endpoint.addresses();
    for (baud, at) in overhear::at_other_speeds(&evidence.endpoint) {
        // A port that does not support a speed is skipped.
        let Ok(link) = dial(&at).await else { continue };
        let mut prober = Prober::new(link, addresses.source);
        let mut heard = prober.listen(options.wait).await?;
        let mut answered = false;
        let tries = if heard.frames.is_empty() { 2 } else { 0 };
        for _ in 0..tries {
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
