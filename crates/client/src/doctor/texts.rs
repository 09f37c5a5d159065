//! Texts of the findings.

use lafet_proto::bus;
use lafet_texts::{Decimal, Fixed, Lang, Text, client as text};

use super::{Evidence, Finding};
use crate::os_text::os_text;
use crate::prober::Heard;
use crate::url::{Endpoint, Framing};

/// What was observed.
pub fn seen(finding: &Finding, evidence: &Evidence, lang: Lang) -> String {
    let Evidence { probes, answered, probed, .. } = evidence;
    let monitor = evidence.endpoint.addresses().monitor;
    let address = evidence.endpoint.addresses().source;
    match finding {
        Finding::Well => text::SeenWell { exchange: exchange(evidence, lang) }.of(lang),
        Finding::NoLink => {
            let link = evidence.endpoint.to_string();
            let error = evidence.lost.as_deref().map(|error| os_text(error, lang));
            text::SeenNoLink { link, error: error.unwrap_or_default() }.of(lang)
        }
        Finding::Nothing => {
            let listened_s = evidence.quiet_for.as_secs_f32();
            text::SeenNothing { listened_s, probes, monitor }.of(lang)
        }
        Finding::Echo { .. } => {
            let later = evidence.exchange.as_ref().map_or(0, |e| e.heard.echoes);
            text::SeenEcho { frames: probed.echoes + later }.of(lang)
        }
        Finding::NoEcho => text::SeenNoEcho.of(lang),
        Finding::WrongSpeed { answers_at } => {
            let sample = sample(evidence, lang);
            match answers_at {
                Some(baud) => text::SeenOtherSpeed { sample, baud }.of(lang),
                None => text::SeenWrongSpeed { bytes: probed.bytes, sample }.of(lang),
            }
        }
        Finding::Noise { .. } => noise(evidence, lang),
        Finding::Loss => {
            text::SeenLoss { answered, probes, exchange: exchange(evidence, lang) }.of(lang)
        }
        Finding::Unanswered => {
            let sent = evidence.exchange.as_ref().map_or(0, |exchange| exchange.sent);
            text::SeenUnanswered { answered, probes, sent }.of(lang)
        }
        Finding::OtherSpeakers { addresses } => speakers(addresses, evidence, lang),
        Finding::OurAddressTaken => text::SeenAddressTaken { address }.of(lang),
        Finding::OddAnswers => text::SeenOddAnswers { odd: odd(evidence, lang) }.of(lang),
        Finding::NoAccess { controller: false } => text::SeenNoController.of(lang),
        Finding::NoAccess { controller: true } => text::SeenNoAccess { address }.of(lang),
        Finding::MonitorSilent => text::SeenMonitorSilent { monitor }.of(lang),
        Finding::WrongAddress { others } => {
            text::SeenWrongAddress { monitor, probes, others: numbers(others) }.of(lang)
        }
        Finding::TwoWithOneAddress => text::SeenTwoWithOneAddress { monitor }.of(lang),
        Finding::Crc32cOnly => text::SeenCrc32cOnly.of(lang),
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => text::SeenRecordsAnswered.of(lang),
            Framing::Records => text::SeenFramesAnswered.of(lang),
        },
        Finding::OtherProtocol { text } => text::SeenOtherProtocol { text }.of(lang),
    }
}

/// What to do.
pub fn remedy(finding: &Finding, evidence: &Evidence, lang: Lang) -> String {
    match finding {
        Finding::WrongSpeed { answers_at: Some(baud) } => text::DoSetBaud { baud }.of(lang),
        Finding::WrongAddress { others } => match others.as_slice() {
            [one] => text::DoSetAddress { one }.of(lang),
            _ => text::DoChooseAddress.of(lang),
        },
        other => fixed_remedy(other, evidence).of(lang),
    }
}

fn fixed_remedy(finding: &Finding, evidence: &Evidence) -> Fixed {
    let serial = matches!(evidence.endpoint, Endpoint::Serial { .. });
    match finding {
        Finding::Well => text::DoNothing.fixed(),
        Finding::NoLink if serial => text::DoCheckPort.fixed(),
        Finding::NoLink => text::DoCheckNetwork.fixed(),
        Finding::Nothing if serial => text::DoCheckPowerSerial.fixed(),
        Finding::Nothing => text::DoCheckPowerNetwork.fixed(),
        Finding::Echo { told: true } => text::DoEchoKnown.fixed(),
        Finding::Echo { told: false } if serial => text::DoEchoSerial.fixed(),
        Finding::Echo { told: false } => text::DoEchoServer.fixed(),
        Finding::NoEcho => text::DoNoEcho.fixed(),
        Finding::WrongSpeed { .. } if serial => text::DoCheckSpeedSerial.fixed(),
        Finding::WrongSpeed { .. } => text::DoCheckSpeedNetwork.fixed(),
        Finding::Noise { .. } => text::DoNoise.fixed(),
        Finding::Loss => text::DoLoss.fixed(),
        Finding::Unanswered => text::DoUnanswered.fixed(),
        Finding::OtherSpeakers { addresses } if addresses.contains(&bus::CONTROLLER) => {
            text::DoUseController.fixed()
        }
        Finding::OtherSpeakers { .. } => text::DoTwoPrograms.fixed(),
        Finding::OurAddressTaken if is_controller(evidence) => text::DoTwoControllers.fixed(),
        Finding::OurAddressTaken => text::DoOwnAddress.fixed(),
        Finding::WrongAddress { .. } => text::DoChooseAddress.fixed(),
        Finding::OddAnswers => text::DoOddAnswers.fixed(),
        Finding::NoAccess { controller: false } => text::DoStartController.fixed(),
        Finding::NoAccess { controller: true } => text::DoNoAccess.fixed(),
        Finding::MonitorSilent => text::DoMonitorSilent.fixed(),
        Finding::TwoWithOneAddress => text::DoChangeAddress.fixed(),
        Finding::Crc32cOnly => text::DoCrc32c.fixed(),
        Finding::OtherFraming => match evidence.endpoint.framing() {
            Framing::Link => text::DoRecords.fixed(),
            Framing::Records => text::DoLinkFrames.fixed(),
        },
        Finding::OtherProtocol { .. } => text::DoOtherService.fixed(),
    }
}

/// Text for noise.
fn noise(evidence: &Evidence, lang: Lang) -> String {
    let Heard { broken, stray_bytes, .. } = total(evidence);
    let quiet = &evidence.quiet;
    let unasked = if quiet.bytes == 0 || !quiet.frames.is_empty() {
        String::new()
    } else {
        text::NoiseUnasked { bytes: quiet.bytes }.of(lang)
    };
    let exchange = exchange(evidence, lang);
    let asked = !evidence.is_answered() && !evidence.held_back;
    let silent = if asked { text::NoiseSilent.str(lang) } else { "" };
    let held_back = if evidence.held_back { text::NothingSent.str(lang) } else { "" };
    text::SeenNoise { silent, broken, stray_bytes, unasked, exchange, held_back }.of(lang)
}

/// Text for other devices on the line.
fn speakers(addresses: &[u8], evidence: &Evidence, lang: Lang) -> String {
    let who = list(addresses, lang);
    let frames = evidence.quiet.frames.len() + strangers(evidence) + elsewhere(evidence);
    let held_back = if evidence.held_back { text::NothingSent.str(lang) } else { "" };
    text::SeenOtherSpeakers { who, frames, held_back }.of(lang)
}

fn is_controller(evidence: &Evidence) -> bool {
    evidence.endpoint.addresses().source == bus::CONTROLLER
}

/// Text for the result of the requests.
fn exchange(evidence: &Evidence, lang: Lang) -> String {
    let Some(exchange) = &evidence.exchange else { return String::new() };
    let (answered, sent) = (exchange.answered, exchange.sent);
    let ms = |time: std::time::Duration| Decimal(time.as_secs_f64() * 1000.0, 1);
    let (mean, max) = (ms(exchange.rtt_mean), ms(exchange.rtt_max));
    text::ExchangeResult { answered, sent, mean, max }.of(lang)
}

/// Text for answers that break the protocol.
fn odd(evidence: &Evidence, lang: Lang) -> String {
    let Some(exchange) = &evidence.exchange else { return String::new() };
    let (odd, answered) = (exchange.odd, exchange.answered);
    let records = match &exchange.odd_sample {
        Some(bytes) if bytes.is_empty() => text::OddWithoutRecords.of(lang),
        Some(bytes) => {
            let bytes: Vec<String> = bytes.iter().take(16).map(|b| format!("{b:02x}")).collect();
            format!(" ({})", bytes.join(" "))
        }
        None => String::new(),
    };
    text::OddAnswers { odd, answered, records }.of(lang)
}

/// Text with the first bytes that could not be read.
fn sample(evidence: &Evidence, lang: Lang) -> String {
    let heard = if evidence.probed.bytes > 0 { &evidence.probed } else { &evidence.quiet };
    if heard.sample.is_empty() {
        return String::new();
    }
    let bytes: Vec<String> = heard.sample.iter().take(16).map(|b| format!("{b:02x}")).collect();
    text::FirstBytes { bytes: bytes.join(" ") }.of(lang)
}

fn total(evidence: &Evidence) -> Heard {
    let mut total = evidence.quiet.clone();
    total.add(evidence.probed.clone());
    if let Some(exchange) = &evidence.exchange {
        total.add(exchange.heard.clone());
    }
    total
}

/// Number of frames of other devices at another speed.
fn elsewhere(evidence: &Evidence) -> usize {
    let others = evidence.speeds.iter().filter(|speed| speed.has_others());
    others.map(|speed| speed.heard.frames.len()).sum()
}

/// Number of frames of other devices received during the examination.
fn strangers(evidence: &Evidence) -> usize {
    let own = evidence.endpoint.addresses().source;
    let exchange = evidence.exchange.iter().map(|exchange| &exchange.heard);
    let heard = [&evidence.probed].into_iter().chain(exchange);
    heard.flat_map(|heard| &heard.frames).filter(|f| f.src != own && f.dst != own).count()
}

fn numbers(addresses: &[u8]) -> String {
    let all: Vec<String> = addresses.iter().map(u8::to_string).collect();
    all.join(", ")
}

fn list(addresses: &[u8], lang: Lang) -> String {
    let one = |&address: &u8| match address {
        bus::CONTROLLER => text::ControllerAt { address }.of(lang),
        _ if bus::CONSOLES.contains(&address) => text::ConsoleAt { address }.of(lang),
        _ => text::DeviceAt { address }.of(lang),
    };
    addresses.iter().map(one).collect::<Vec<_>>().join("; ")
}
