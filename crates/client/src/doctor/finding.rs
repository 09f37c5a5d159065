//! Conclusions from the evidence.

use lafet_proto::bus;

use super::{Evidence, Exchange};
use crate::error::Cause;
use crate::error::Lang;
use crate::prober::{Heard, HeardFrame};
use crate::url::{Echo, Endpoint, Framing, Role};

/// Share of printable bytes above which bytes count as text, percent.
const TEXT_PERCENT: usize = 80;
/// Fewest bytes that can count as text.
const TEXT_MIN: usize = 6;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be.
    Good,
    /// Works, but not well.
    Warning,
    /// Does not work.
    Fault,
}

/// A finding about a link.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Finding {
    /// The monitor answers, and all requests were answered.
    Well,
    /// The link cannot be opened, or was lost.
    NoLink,
    /// Nothing is received.
    Nothing,
    /// The line echoes what is sent.
    Echo {
        /// The URL declares it (`echo=`).
        told: bool,
    },
    /// The URL declares an echo, and there is none.
    NoEcho,
    /// The received bytes are not frames: the speed is wrong.
    WrongSpeed {
        /// The speed at which the monitor answers.
        answers_at: Option<u32>,
    },
    /// Bytes outside frames, or frames with errors.
    Noise {
        /// The monitor answers all the same.
        answered: bool,
    },
    /// Requests or answers are lost, and nothing else is received.
    Loss,
    /// Presence probes are answered, and not one request is.
    Unanswered,
    /// Other devices transmit without being asked.
    OtherSpeakers {
        /// Their addresses.
        addresses: Vec<u8>,
    },
    /// Another device uses our address.
    OurAddressTaken,
    /// The monitor's address does not answer, others do.
    WrongAddress {
        /// The addresses that answer.
        others: Vec<u8>,
    },
    /// The answers of the monitor break the protocol.
    OddAnswers,
    /// The URL has `role=active`, and no access is granted.
    NoAccess {
        /// Whether there is a controller.
        controller: bool,
    },
    /// Other devices are received on the bus, and the monitor does not answer.
    MonitorSilent,
    /// Two devices answer at the monitor's address.
    TwoWithOneAddress,
    /// The monitor accepts frames with a CRC-32C only (§L/7).
    Crc32cOnly,
    /// The device uses bare records instead of link frames, or link frames instead of bare records
    /// (§C/3).
    OtherFraming,
    /// The device uses another protocol.
    OtherProtocol {
        /// The text received.
        text: String,
    },
}

/// All findings that follow from the evidence, the most severe first.
pub fn findings(evidence: &Evidence) -> Vec<Finding> {
    let mut all = Vec::new();
    if evidence.lost.is_some() {
        all.push(Finding::NoLink);
    }
    silence(evidence, &mut all);
    speakers(evidence, &mut all);
    echo(evidence, &mut all);
    quality(evidence, &mut all);
    if evidence.exchange.as_ref().is_some_and(|exchange| exchange.odd > 0) {
        all.push(Finding::OddAnswers);
    }
    if evidence.doubled {
        all.push(Finding::TwoWithOneAddress);
    }
    let bad = |finding: &Finding| finding.severity() > Severity::Good;
    if evidence.is_answered() && !all.iter().any(bad) {
        all.insert(0, Finding::Well);
    }
    all.sort_by_key(|finding| std::cmp::Reverse(finding.severity()));
    all
}

impl Finding {
    /// Severity of the finding.
    pub const fn severity(&self) -> Severity {
        match self {
            Self::Well | Self::Echo { told: true } => Severity::Good,
            Self::Crc32cOnly | Self::Loss | Self::NoEcho => Severity::Warning,
            Self::Noise { answered: true } | Self::Echo { told: false } => Severity::Warning,
            _ => Severity::Fault,
        }
    }

    /// Name for scripts and JSON.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Well => "well",
            Self::NoLink => "no-link",
            Self::Nothing => "nothing",
            Self::Echo { .. } => "echo",
            Self::NoEcho => "no-echo",
            Self::WrongSpeed { .. } => "wrong-speed",
            Self::Noise { .. } => "noise",
            Self::Loss => "loss",
            Self::Unanswered => "unanswered",
            Self::OtherSpeakers { .. } => "other-speakers",
            Self::OurAddressTaken => "our-address-taken",
            Self::WrongAddress { .. } => "wrong-address",
            Self::OddAnswers => "odd-answers",
            Self::NoAccess { .. } => "no-access",
            Self::MonitorSilent => "monitor-silent",
            Self::TwoWithOneAddress => "two-with-one-address",
            Self::Crc32cOnly => "crc32c-only",
            Self::OtherFraming => "other-framing",
            Self::OtherProtocol { .. } => "other-protocol",
        }
    }

    /// What was observed.
    pub fn seen(&self, evidence: &Evidence, lang: Lang) -> String {
        super::texts::seen(self, evidence, lang)
    }

    /// What to do.
    pub fn remedy(&self, evidence: &Evidence, lang: Lang) -> String {
        super::texts::remedy(self, evidence, lang)
    }
}

/// Adds the reasons for which the monitor does not answer.
fn silence(evidence: &Evidence, all: &mut Vec<Finding>) {
    if evidence.crc32c_only {
        all.push(Finding::Crc32cOnly);
    }
    if evidence.is_answered() || evidence.lost.is_some() {
        return;
    }
    if evidence.held_back {
        let text = printable(&evidence.quiet.sample);
        all.extend(match frames_elsewhere(evidence) {
            Some(baud) => Some(Finding::WrongSpeed { answers_at: Some(baud) }),
            None if !evidence.quiet.is_garbage() => None,
            None => Some(match text {
                Some(text) => Finding::OtherProtocol { text },
                None => Finding::Noise { answered: false },
            }),
        });
        return;
    }
    if evidence.endpoint.behaviour().role == Role::Active && !evidence.quiet.is_garbage() {
        all.push(match evidence.no_access {
            Some(Cause::NoController) => Finding::NoAccess { controller: false },
            Some(_) => Finding::NoAccess { controller: true },
            None => Finding::MonitorSilent,
        });
        return;
    }
    let Evidence { quiet, probed, .. } = evidence;
    let speed = evidence.speeds.iter().find(|speed| speed.answered);
    let sample = if quiet.is_garbage() { &quiet.sample } else { &probed.sample };
    let garbage = quiet.is_garbage() || probed.is_garbage();
    let text = garbage.then(|| printable(sample)).flatten();
    all.push(if evidence.other_framing {
        Finding::OtherFraming
    } else if !evidence.others.is_empty() {
        Finding::WrongAddress { others: evidence.others.clone() }
    } else if let Some(speed) = speed {
        Finding::WrongSpeed { answers_at: Some(speed.baud) }
    } else if let Some(text) = text {
        Finding::OtherProtocol { text }
    } else if probed.is_garbage() && !quiet.is_garbage() {
        Finding::WrongSpeed { answers_at: None }
    } else if quiet.is_garbage() {
        // Received before and after: from devices at another speed, or noise.
        match evidence.endpoint {
            Endpoint::Serial { .. } if frames_elsewhere(evidence).is_some() => {
                Finding::WrongSpeed { answers_at: frames_elsewhere(evidence) }
            }
            _ => Finding::Noise { answered: false },
        }
    } else {
        Finding::Nothing
    });
}

/// A speed at which frames of other devices are received.
fn frames_elsewhere(evidence: &Evidence) -> Option<u32> {
    evidence.speeds.iter().find(|speed| !speed.heard.frames.is_empty()).map(|speed| speed.baud)
}

fn speakers(evidence: &Evidence, all: &mut Vec<Finding>) {
    let own = evidence.endpoint.addresses();
    let exchange = evidence.exchange.iter().map(|exchange| &exchange.heard);
    let heard = [&evidence.quiet, &evidence.probed].into_iter().chain(exchange);
    let mut addresses = Vec::new();
    let elsewhere = evidence.speeds.iter().filter(|speed| speed.has_others());
    let heard = heard.chain(elsewhere.map(|speed| &speed.heard));
    // On a bus with a controller, its frames and those of other consoles are normal.
    let active = evidence.endpoint.behaviour().role == Role::Active;
    for frame in heard.flat_map(|heard| &heard.frames) {
        let speaker = frame.speaker();
        if speaker != own.source && !addresses.contains(&speaker) {
            addresses.push(speaker);
        }
    }
    addresses.sort_unstable();
    if !addresses.is_empty() && !active {
        all.push(Finding::OtherSpeakers { addresses });
    }
    let before_us = &evidence.quiet.frames;
    let of_us = |frame: &HeardFrame| {
        // The controller probes each address, and grants access to a console that has answered.
        let called = frame.dst == own.source
            && frame.src == bus::CONTROLLER
            && (active || frame.payload.is_empty());
        (frame.src == own.source || frame.dst == own.source) && !called
    };
    if evidence.address_taken || before_us.iter().any(of_us) {
        all.push(Finding::OurAddressTaken);
    }
}

fn echo(evidence: &Evidence, all: &mut Vec<Finding>) {
    let asked = evidence.exchange.as_ref().map_or(0, |exchange| exchange.heard.echoes);
    let echoes = evidence.probed.echoes + asked;
    let told = match &evidence.endpoint {
        Endpoint::Serial { line, .. } => line.echo != Echo::Off,
        _ => false,
    };
    // Frames of another device with our address look like an echo.
    let own = evidence.endpoint.addresses().source;
    let taken = evidence.quiet.frames.iter().any(|frame| frame.src == own);
    if echoes > 0 && !taken {
        all.push(Finding::Echo { told });
    } else if told && evidence.is_answered() {
        all.push(Finding::NoEcho);
    }
}

/// Adds findings about the quality of a link on which the monitor answers.
fn quality(evidence: &Evidence, all: &mut Vec<Finding>) {
    if !evidence.is_answered() || evidence.endpoint.framing() == Framing::Records {
        return;
    }
    let nothing = Exchange::default();
    let exchange = evidence.exchange.as_ref().unwrap_or(&nothing);
    let heard = [&evidence.quiet, &evidence.probed, &exchange.heard];
    let spoiled = heard.iter().any(|heard| heard.broken > 0 || heard.stray_bytes > 0);
    let lost = exchange.answered < exchange.sent
        || !evidence.crc32c_only && evidence.answered < evidence.probes;
    let unanswered = exchange.sent > 0 && exchange.answered == 0 && evidence.lost.is_none();
    if unanswered {
        all.push(Finding::Unanswered);
    }
    if spoiled {
        all.push(Finding::Noise { answered: true });
    } else if lost && !unanswered {
        all.push(Finding::Loss);
    }
}

/// Whether the received bytes are text: another protocol.
pub(super) fn speaks_text(heard: &Heard) -> bool {
    heard.is_garbage() && printable(&heard.sample).is_some()
}

/// The first line of bytes that look like text.
fn printable(sample: &[u8]) -> Option<String> {
    let is_text = |byte: &&u8| (b' '..=b'~').contains(*byte) || matches!(**byte, b'\r' | b'\n');
    let count = sample.iter().filter(is_text).count();
    if sample.len() < TEXT_MIN || count * 100 < sample.len() * TEXT_PERCENT {
        return None;
    }
    let text: String = sample.iter().filter(is_text).map(|byte| char::from(*byte)).collect();
    text.lines().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned)
}
