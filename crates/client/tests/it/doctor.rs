//! The doctor on lines with one fault each, and the scan, on virtual time.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use crate::fake::answer;
use lafet_client::doctor::{Evidence, Finding, Options, Severity, examine, findings};
use lafet_client::overhear::{CONTROLLER_PAUSE, GLANCE, Overheard, Times, overhear};
use lafet_client::scan::{ScanOptions, scan};
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_client::{Endpoint, Lang, PortError};
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::{Check, Decoder, Frame, WIRE_MAX, encode_with};
use rmodbus::ModbusProto;
use rmodbus::client::ModbusRequest;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::time::{Instant, sleep, sleep_until};

/// A line, and what is on it.
#[derive(Clone, Default)]
struct Plant {
    /// Addresses of the monitors.
    monitors: Vec<u8>,
    /// They take frames with a CRC-32C only.
    crc32c_only: bool,
    /// They speak bare records.
    records: bool,
    /// Everything that is sent comes back.
    echo: bool,
    /// The speed at which bytes are bytes.
    baud: Option<u32>,
    /// Bytes that come by themselves every 20 ms.
    hum: &'static [u8],
    /// Only so many times, if not 0.
    hum_ticks: usize,
    /// Frames that come by themselves every 200 ms, from and to.
    chatter: &'static [(u8, u8)],
    /// The speed at which what comes by itself can be read; without it, at every one.
    chatter_baud: Option<u32>,
    /// They come every 20 ms.
    often: bool,
    /// They come every 2.5 s, and so do the bytes.
    seldom: bool,
    /// At a wrong speed what others say is not heard at all.
    mute: bool,
    /// Requests are answered with these records.
    odd: Option<&'static [u8]>,
    /// What others have asked from our address is answered before each answer to us.
    shared: bool,
    /// An answer takes so long.
    delay: Duration,
    /// Bytes that were sent to it.
    sent: Arc<AtomicUsize>,
    /// Every so many answers one is spoiled.
    spoil: usize,
    /// Every so many answers one is lost.
    lose: usize,
    /// Probes alone are answered.
    probes_only: bool,
    /// What is answered to anything.
    banner: &'static [u8],
}

fn monitors(addresses: &[u8]) -> Plant {
    Plant { monitors: addresses.to_vec(), ..Plant::default() }
}

impl Plant {
    /// A new way onto the line.
    fn link(&self, endpoint: &Endpoint) -> Link {
        let (ours, theirs) = lafet_client::transport::memory::pair();
        let at = match endpoint {
            Endpoint::Serial { line, .. } => Some(line.baud),
            _ => None,
        };
        let garbled = at.is_some() && self.baud.is_some() && at != self.baud;
        let mut plant = self.clone();
        if at.is_some() && plant.chatter_baud.is_some() && at != plant.chatter_baud {
            plant.hum =
                if plant.mute || plant.chatter.is_empty() { &[] } else { &[0x13, 0x80, 0xE7] };
            plant.chatter = &[];
        }
        tokio::spawn(plant.serve(theirs, garbled));
        Link::Memory(Memory::new(ours))
    }

    async fn serve(self, mut stream: tokio::io::DuplexStream, garbled: bool) {
        let mut decoder: Decoder = Decoder::new();
        let mut buffer = [0; WIRE_MAX];
        let mut ticks = 0usize;
        let mut count = 0;
        let tick = Duration::from_millis(20);
        let mut next = Instant::now() + tick;
        loop {
            let mut out = Vec::new();
            tokio::select! {
                () = sleep_until(next) => {
                    next += tick;
                    ticks += 1;
                    let due = !self.seldom || ticks.is_multiple_of(125);
                    if due && (self.hum_ticks == 0 || ticks <= self.hum_ticks) {
                        out.extend(self.hum);
                    }
                    if due && (self.often || self.seldom || ticks.is_multiple_of(10)) {
                        for (src, dst) in self.chatter {
                            out.extend(encoded(Check::Crc16, *dst, *src, &[]));
                        }
                    }
                }
                read = stream.read(&mut buffer) => {
                    let Ok(len @ 1..) = read else { return };
                    self.sent.fetch_add(len, Ordering::Relaxed);
                    sleep(self.delay).await;
                    if self.echo {
                        out.extend(&buffer[..len]);
                    }
                    out.extend(self.banner);
                    if garbled && !self.monitors.is_empty() {
                        // Another speed: a device hears nonsense, and so do we.
                        out.extend([0x00, 0xF8, 0x80, 0x1C]);
                    } else if self.records && buffer[0] != 0xFF {
                        out.extend(answer(&buffer[..len]));
                    } else if !self.records && !garbled {
                        out.extend(self.answers(&mut decoder, &buffer[..len], &mut count));
                    }
                }
            }
            if garbled {
                out.iter_mut().for_each(|byte| *byte = (*byte & 0x3F).wrapping_mul(2));
            }
            if stream.write_all(&out).await.is_err() {
                return;
            }
        }
    }

    fn answers(&self, decoder: &mut Decoder, bytes: &[u8], count: &mut usize) -> Vec<u8> {
        let mut out = Vec::new();
        for byte in bytes {
            let Some(Frame { dst, src, payload }) = decoder.push(*byte) else { continue };
            let payload = match self.odd {
                _ if payload.is_empty() => Vec::new(),
                Some(odd) => odd.to_vec(),
                None => answer(payload),
            };
            let check = decoder.check();
            if self.crc32c_only && check != Check::Crc32c {
                continue;
            }
            if self.probes_only && !payload.is_empty() {
                continue;
            }
            for _ in self.monitors.iter().filter(|monitor| **monitor == dst) {
                *count += 1;
                if self.shared {
                    out.extend(encoded(check, src, dst, &[0xD4, 0xA6, 0, 0]));
                }
                let mut answer = encoded(check, src, dst, &payload);
                if self.lose > 0 && count.is_multiple_of(self.lose) {
                    continue;
                }
                if self.spoil > 0 && count.is_multiple_of(self.spoil) {
                    answer[4] ^= 0x10;
                }
                out.extend(answer);
            }
        }
        out
    }
}

fn encoded(check: Check, dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = [0; WIRE_MAX];
    let len = encode_with(check, &Frame { dst, src, payload }, &mut wire).unwrap();
    wire[..len].to_vec()
}

async fn evidence(url: &str, plant: &Plant) -> Evidence {
    let endpoint: Endpoint = url.parse().unwrap();
    let dial = async |at: &Endpoint| Ok(plant.link(at));
    let options = Options { insist: true, ..Options::of(&endpoint) };
    examine(&endpoint, &options, dial, |_| {}).await
}

/// What the doctor finds; every text is there in both languages.
async fn found(url: &str, plant: &Plant) -> Vec<Finding> {
    let evidence = evidence(url, plant).await;
    let all = findings(&evidence);
    assert!(!all.is_empty(), "{evidence:?}");
    for finding in &all {
        for text in [finding.seen(&evidence, Lang::En), finding.remedy(&evidence, Lang::En)] {
            assert!(text.ends_with(['.', '`']) && !text.contains("  "), "{text}");
        }
        for text in [finding.seen(&evidence, Lang::Ru), finding.remedy(&evidence, Lang::Ru)] {
            assert!(text.chars().any(|c| ('а'..='я').contains(&c)), "{text}");
        }
    }
    all
}

const SERIAL: &str = "serial:///dev/x?baud=19200&addr=5";
const TCP: &str = "tcp://h:1?addr=5";

#[tokio::test(start_paused = true)]
async fn a_good_line_is_called_good() {
    for url in [SERIAL, TCP] {
        assert_eq!(found(url, &monitors(&[5])).await, [Finding::Well]);
    }
    let records = Plant { records: true, ..monitors(&[5]) };
    assert_eq!(found("tcp://h:1?framing=records", &records).await, [Finding::Well]);
    let seen = evidence(SERIAL, &monitors(&[5])).await;
    assert!(Finding::Well.seen(&seen, Lang::En).contains("30 of 30 requests"));
}

#[tokio::test(start_paused = true)]
async fn an_echo() {
    let plant = Plant { echo: true, ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &plant).await, [Finding::Echo { told: false }]);
    let told = found("serial:///dev/x?addr=5&echo=strip", &plant).await;
    assert_eq!(told, [Finding::Well, Finding::Echo { told: true }]);
    let missing = found("serial:///dev/x?addr=5&echo=verify", &monitors(&[5])).await;
    assert_eq!(missing, [Finding::NoEcho]);
    // An echo alone is no answer.
    let alone = found(SERIAL, &Plant { echo: true, ..Plant::default() }).await;
    assert_eq!(alone, [Finding::Nothing, Finding::Echo { told: false }]);
}

#[tokio::test(start_paused = true)]
async fn a_wrong_speed() {
    let plant = Plant { baud: Some(57_600), ..monitors(&[5]) };
    let wrong = |answers_at| [Finding::WrongSpeed { answers_at }];
    assert_eq!(found(SERIAL, &plant).await, wrong(Some(57_600)));
    let odd = Plant { baud: Some(12_345), ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &odd).await, wrong(None));
    // Behind a serial server the speed cannot be tried.
    let server = Plant { banner: &[0x80, 0x1C, 0xF0], ..Plant::default() };
    assert_eq!(found(TCP, &server).await, wrong(None));
}

/// Bytes that come faster than they are read, without a pause.
struct Babble(u32);

impl AsyncRead for Babble {
    fn poll_read(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.0 += 1;
        assert!(self.0 < 1_000_000, "it is read without an end");
        while buffer.remaining() > 1 {
            buffer.put_slice(&[0xFF, 0xC0]);
        }
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Babble {
    fn poll_write(
        self: Pin<&mut Self>,
        _: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

/// A stuck adapter takes no bytes.
struct Stuck;

impl AsyncRead for Stuck {
    fn poll_read(
        self: Pin<&mut Self>,
        _: &mut Context<'_>,
        _: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Poll::Pending
    }
}

impl AsyncWrite for Stuck {
    fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, _: &[u8]) -> Poll<io::Result<usize>> {
        Poll::Pending
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

#[tokio::test(start_paused = true)]
async fn a_port_that_takes_no_bytes_ends_the_examination() {
    let endpoint: Endpoint = SERIAL.parse().unwrap();
    let dial = async |_: &Endpoint| Ok(Link::Memory(Memory::new(Stuck)));
    let evidence = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    assert_eq!(findings(&evidence), [Finding::NoLink]);
    let seen = Finding::NoLink.seen(&evidence, Lang::Ru);
    assert!(seen.contains("время ожидания вышло"), "{seen}");
}

/// In real time: a line that is never quiet leaves virtual time no moment to pass.
#[tokio::test]
async fn a_line_that_is_never_quiet_is_examined_to_the_end() {
    let ms = Duration::from_millis;
    for url in [SERIAL, TCP] {
        let endpoint: Endpoint = url.parse().unwrap();
        let (quiet, wait, probe_wait) = (ms(20), ms(2), ms(1));
        let options = Options { quiet, wait, probe_wait, ..Options::of(&endpoint) };
        let dial = async |_: &Endpoint| Ok(Link::Memory(Memory::new(Babble(0))));
        let evidence = examine(&endpoint, &options, dial, |_| {}).await;
        assert_eq!(findings(&evidence), [Finding::Noise { answered: false }], "{url}");
    }
}

#[tokio::test(start_paused = true)]
async fn noise_and_loss() {
    let hum = Plant { hum: &[0x13, 0x80, 0xE7], ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &hum).await, [Finding::Noise { answered: true }]);
    let hum_alone = Plant { hum: &[0x13, 0x80, 0xE7], ..Plant::default() };
    let silent = found(SERIAL, &hum_alone).await;
    assert_eq!(silent, [Finding::Noise { answered: false }]);
    assert_eq!(silent[0].severity(), Severity::Fault, "no script may take it for a good line");
    let spoiled = Plant { spoil: 7, ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &spoiled).await, [Finding::Noise { answered: true }]);
    let lost = Plant { lose: 7, ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &lost).await, [Finding::Loss]);
}

#[tokio::test(start_paused = true)]
async fn others_that_speak() {
    let token = Plant { chatter: &[(CONTROLLER, 130)], ..monitors(&[5]) };
    let url = "serial:///dev/x?addr=5&src=128";
    for (url, words) in [(SERIAL, "token"), (url, "Two bus controllers")] {
        let seen = evidence(url, &token).await;
        let speakers = &findings(&seen)[0];
        let ours = url.contains("src=128");
        match speakers {
            Finding::OurAddressTaken => assert!(ours),
            other => assert_eq!(other, &Finding::OtherSpeakers { addresses: vec![CONTROLLER] }),
        }
        let all: Vec<String> =
            findings(&seen).iter().map(|one| one.remedy(&seen, Lang::En)).collect();
        assert!(all.iter().any(|text| text.contains(words)), "{words}: {all:?}");
    }
    let console = Plant { chatter: &[(130, 6), (6, 130)], ..monitors(&[5]) };
    let addresses = vec![130];
    assert_eq!(found(SERIAL, &console).await, [Finding::OtherSpeakers { addresses }]);
    let same = Plant { chatter: &[(129, 5)], ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &same).await, [Finding::OurAddressTaken]);
    assert_eq!(found(SERIAL, &monitors(&[5, 5])).await, [Finding::TwoWithOneAddress]);
}

/// Others are at work: a probe could collide with their Stop, so neither says a word.
#[tokio::test(start_paused = true)]
async fn nobody_is_disturbed() {
    let plant = Plant { chatter: &[(CONTROLLER, 130)], ..monitors(&[5]) };
    let endpoint: Endpoint = SERIAL.parse().unwrap();
    let dial = async |at: &Endpoint| Ok(plant.link(at));
    let seen = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    assert_eq!((seen.probes, seen.held_back), (0, true));
    assert_eq!(findings(&seen), [Finding::OtherSpeakers { addresses: vec![CONTROLLER] }]);
    let listen = Duration::from_secs(1);
    let options = ScanOptions { listen, ..ScanOptions::default() };
    let mut probed = 0;
    let scanned = scan(plant.link(&endpoint), 129, &options, |_| probed += 1).await.unwrap();
    assert_eq!((probed, scanned.held_back, scanned.speakers), (0, true, vec![CONTROLLER]));
}

#[tokio::test(start_paused = true)]
async fn a_wrong_address_and_nobody() {
    let others = vec![6, 9];
    assert_eq!(found(SERIAL, &monitors(&[6, 9])).await, [Finding::WrongAddress { others }]);
    for url in [SERIAL, TCP] {
        assert_eq!(found(url, &Plant::default()).await, [Finding::Nothing]);
    }
}

#[tokio::test(start_paused = true)]
async fn links_of_another_kind() {
    let crc32c = Plant { crc32c_only: true, ..monitors(&[5]) };
    assert_eq!(found(SERIAL, &crc32c).await, [Finding::Crc32cOnly]);
    let records = Plant { records: true, ..monitors(&[5]) };
    assert_eq!(found(TCP, &records).await, [Finding::OtherFraming]);
    let framed = found("tcp://h:1?addr=5&framing=records", &monitors(&[5])).await;
    assert_eq!(framed, [Finding::OtherFraming]);
    let other = Plant { banner: b"SSH-2.0-OpenSSH_9.2\r\n", ..Plant::default() };
    let text = "SSH-2.0-OpenSSH_9.2".into();
    assert_eq!(found(TCP, &other).await, [Finding::OtherProtocol { text }]);
}

#[tokio::test(start_paused = true)]
async fn no_link() {
    let endpoint: Endpoint = TCP.parse().unwrap();
    let dial = async |_: &Endpoint| Err(io::ErrorKind::ConnectionRefused.into());
    let evidence = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    let all = findings(&evidence);
    assert_eq!(all, [Finding::NoLink]);
    assert_eq!(all[0].severity(), Severity::Fault);
    assert!(all[0].seen(&evidence, Lang::En).contains("refused"));
    assert!(all[0].seen(&evidence, Lang::Ru).contains("в соединении отказано"));
    // What a port says has its own full stop.
    let missing = || PortError::Missing { path: "/dev/nope".into() };
    let dial = async |_: &Endpoint| Err(missing().into());
    let evidence = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    for lang in [Lang::En, Lang::Ru] {
        let seen = Finding::NoLink.seen(&evidence, lang);
        assert!(seen.contains(&missing().localized(lang)) && !seen.contains(".."), "{seen}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_scan_finds_each_and_hears_strangers() {
    let plant = Plant { chatter: &[(CONTROLLER, 131)], echo: true, ..monitors(&[1, 5, 5, 127]) };
    let endpoint: Endpoint = SERIAL.parse().unwrap();
    let mut probed = Vec::new();
    let options = ScanOptions::default();
    let scan = scan(plant.link(&endpoint), 129, &options, |address| probed.push(address));
    let scan = scan.await.unwrap();
    let addresses: Vec<(u8, bool)> =
        scan.present.iter().map(|present| (present.address, present.doubled)).collect();
    assert_eq!(addresses, [(1, false), (5, true), (127, false)]);
    assert_eq!((scan.speakers, scan.echo), (vec![CONTROLLER], true));
    assert!(probed.contains(&2) && probed.contains(&126) && !probed.contains(&128));
    let plant = Plant { crc32c_only: true, ..monitors(&[7]) };
    let scan = lafet_client::scan::scan(plant.link(&endpoint), 129, &options, |_| {}).await;
    let present = scan.unwrap().present;
    assert_eq!((present.len(), present[0].check), (1, Check::Crc32c));
}

/// A controller at another speed is heard before the first byte, and not one is sent; whether its
/// bytes come as nonsense or not at all, and whatever the user insists on.
#[tokio::test(start_paused = true)]
async fn a_controller_at_another_speed_is_not_disturbed() {
    for mute in [false, true] {
        let chatter: &[(u8, u8)] = &[(CONTROLLER, 130), (130, CONTROLLER)];
        let plant = Plant { chatter, chatter_baud: Some(57_600), mute, ..monitors(&[5]) };
        // One that speaks more than once in 150 ms is heard where the wrong speed makes silence.
        let plant = Plant { often: mute, ..plant };
        let all = found(SERIAL, &plant).await;
        let expected = [
            Finding::WrongSpeed { answers_at: Some(57_600) },
            Finding::OtherSpeakers { addresses: vec![CONTROLLER, 130] },
        ];
        assert_eq!(all, expected, "mute {mute}");
        assert_eq!(plant.sent.load(Ordering::Relaxed), 0, "mute {mute}");
    }
}

/// Without `--insist`.
async fn quietly(url: &str, plant: &Plant) -> Evidence {
    let endpoint: Endpoint = url.parse().unwrap();
    let dial = async |at: &Endpoint| Ok(plant.link(at));
    examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await
}

/// A controller without a device to ask transmits every 2.5 s: no byte goes onto its line, whatever its
/// speed and whomever it probes.
#[tokio::test(start_paused = true)]
async fn a_controller_that_seldom_speaks_is_not_disturbed() {
    let speakers = Finding::OtherSpeakers { addresses: vec![CONTROLLER] };
    for (chatter, chatter_baud) in [
        (&[(CONTROLLER, 7)], Some(2_400)),
        (&[(CONTROLLER, 7)], None),
        // A probe of our own address is as ordinary as one of any other.
        (&[(CONTROLLER, 129)], None),
    ] {
        let plant = Plant { chatter, chatter_baud, seldom: true, ..monitors(&[5]) };
        let seen = quietly(SERIAL, &plant).await;
        let mut expected = vec![speakers.clone()];
        if let Some(baud) = chatter_baud {
            expected.insert(0, Finding::WrongSpeed { answers_at: Some(baud) });
        }
        assert_eq!(findings(&seen), expected, "{chatter:?} {chatter_baud:?}");
        assert!(seen.held_back, "{chatter:?} {chatter_baud:?}");
        assert_eq!(plant.sent.load(Ordering::Relaxed), 0, "{chatter:?} {chatter_baud:?}");
    }
}

/// Bytes that were not asked for and that no speed makes readable: a probe could disturb what sends
/// them.
#[tokio::test(start_paused = true)]
async fn unreadable_bytes_hold_back() {
    for seldom in [false, true] {
        let plant = Plant { hum: &[0x13, 0x80, 0xE7], seldom, ..monitors(&[5]) };
        for url in [SERIAL, TCP] {
            let seen = quietly(url, &plant).await;
            assert_eq!(findings(&seen), [Finding::Noise { answered: false }], "{url}");
            let text = Finding::Noise { answered: false }.seen(&seen, Lang::En);
            assert!(text.contains("nothing was sent") && !text.contains("answer"), "{text}");
        }
        assert_eq!(plant.sent.load(Ordering::Relaxed), 0);
    }
}

/// The speed of a port that another program uses as well is not changed under it.
#[tokio::test(start_paused = true)]
async fn a_shared_port_keeps_its_speed() {
    let plant = Plant { hum: &[0x13, 0x80, 0xE7], ..monitors(&[5]) };
    let endpoint: Endpoint = "serial:///dev/x?baud=19200&addr=5&shared=1".parse().unwrap();
    let mut opened = Vec::new();
    let dial = async |at: &Endpoint| {
        opened.push(at.clone());
        Ok(plant.link(at))
    };
    examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    assert!(!opened.is_empty() && opened.iter().all(|at| *at == endpoint), "{opened:?}");
}

const TIMES: Times = Times {
    first: Duration::from_millis(100),
    own: CONTROLLER_PAUSE,
    elsewhere: CONTROLLER_PAUSE,
    silent: GLANCE,
};

async fn overheard(plant: &Plant, times: Times) -> Overheard {
    let endpoint: Endpoint = SERIAL.parse().unwrap();
    let dial = async |at: &Endpoint| Ok(plant.link(at));
    let (_, heard) = overhear(&endpoint, times, dial).await.unwrap();
    assert_eq!(plant.sent.load(Ordering::Relaxed), 0);
    heard
}

/// What a client hears before its first byte decides whether it is sent.
#[tokio::test(start_paused = true)]
async fn a_line_is_listened_to_before_it_is_used() {
    let quiet = overheard(&monitors(&[5]), TIMES).await;
    assert!(!quiet.unreadable && quiet.elsewhere.is_none() && quiet.speakers().is_empty());
    // Frames at another speed, often and seldom.
    let chatter: &[(u8, u8)] = &[(CONTROLLER, 130), (130, CONTROLLER)];
    for seldom in [false, true] {
        let plant = Plant { chatter, chatter_baud: Some(57_600), seldom, ..monitors(&[5]) };
        let first = if seldom { CONTROLLER_PAUSE } else { TIMES.first };
        let heard = overheard(&plant, Times { first, ..TIMES }).await;
        assert!(heard.unreadable && heard.has_controller());
        assert_eq!(heard.elsewhere.as_ref().map(|(baud, _)| *baud), Some(57_600));
        assert_eq!(heard.speakers(), [CONTROLLER, 130]);
    }
    // A driver that drops what comes at a wrong speed makes silence of it.
    let plant =
        Plant { chatter, chatter_baud: Some(57_600), mute: true, often: true, ..monitors(&[5]) };
    let heard = overheard(&plant, TIMES).await;
    assert!(!heard.unreadable && heard.has_controller());
    assert_eq!(heard.elsewhere.as_ref().map(|(baud, _)| *baud), Some(57_600));
    let unasked = overheard(&plant, Times { silent: Duration::ZERO, ..TIMES }).await;
    assert!(unasked.elsewhere.is_none());
    // The end of a frame is no noise where the next one can be read, nor is what does not come again.
    let cut = Plant { chatter, hum: &[0x13, 0x80], ..monitors(&[5]) };
    let heard = overheard(&cut, TIMES).await;
    assert!(!heard.unreadable && heard.has_controller());
    let once = Plant { hum: &[0], hum_ticks: 3, ..monitors(&[5]) };
    assert!(!overheard(&once, TIMES).await.unreadable);
    let noise = Plant { hum: &[0x13, 0x80, 0xE7], ..monitors(&[5]) };
    let heard = overheard(&noise, TIMES).await;
    assert!(heard.unreadable && heard.elsewhere.is_none());
}

/// Bytes that cannot be read may be others at another speed: a scan says nothing there either.
#[tokio::test(start_paused = true)]
async fn a_scan_holds_back_from_what_it_cannot_read() {
    let plant = Plant { hum: &[0x13, 0x80, 0xE7], ..monitors(&[5]) };
    let listen = Duration::from_secs(1);
    let options = ScanOptions { listen, ..ScanOptions::default() };
    let scanned = scan(plant.link(&SERIAL.parse().unwrap()), 129, &options, |_| {}).await.unwrap();
    assert!(scanned.held_back && scanned.garbage && scanned.present.is_empty());
    assert_eq!(plant.sent.load(Ordering::Relaxed), 0);
    // What comes once is no traffic.
    let once = Plant { hum: &[0], hum_ticks: 1, ..monitors(&[5]) };
    let scanned = scan(once.link(&SERIAL.parse().unwrap()), 129, &options, |_| {}).await.unwrap();
    assert!(!scanned.held_back && scanned.present.len() == 1, "{scanned:?}");
}

/// A master of Modbus RTU on the line, by a library that is not ours: its bytes are no frames at any
/// speed, and its slaves must not be disturbed.
#[tokio::test(start_paused = true)]
async fn a_modbus_master_is_not_disturbed() {
    let mut asked = Vec::new();
    for unit in [1, 5, 17] {
        let mut request = ModbusRequest::new(unit, ModbusProto::Rtu);
        request.generate_get_holdings(0, 10, &mut asked).expect("it fits");
    }
    let hum = asked.leak();
    for seldom in [false, true] {
        let plant = Plant { hum, seldom, ..monitors(&[5]) };
        for url in [SERIAL, TCP] {
            let seen = quietly(url, &plant).await;
            assert_eq!(findings(&seen), [Finding::Noise { answered: false }], "{url}");
        }
        let first = CONTROLLER_PAUSE;
        assert!(overheard(&plant, Times { first, ..TIMES }).await.unreadable);
        assert_eq!(plant.sent.load(Ordering::Relaxed), 0);
    }
}

/// A monitor that answers something else is not a good one.
#[tokio::test(start_paused = true)]
async fn answers_that_are_none() {
    let odd: [&[u8]; 5] = [
        &[],
        // Cut short, of another subsystem, refused with an unknown status, without data.
        &[0xD4, 0x5D, 0, 10, 1, 2],
        &[0xD4, 0xA6, 0, 0],
        &[0xD4, 0xC2, 0xC8, 0],
        &[0xD4, 0xC2, 0, 0],
    ];
    for odd in odd {
        let plant = Plant { odd: Some(odd), ..monitors(&[5]) };
        for url in [SERIAL, TCP] {
            assert_eq!(found(url, &plant).await, [Finding::OddAnswers], "{odd:02x?}");
        }
    }
}

/// Who answers probes and no request is of no use, whatever else is heard.
#[tokio::test(start_paused = true)]
async fn not_one_request_is_answered() {
    let plant = Plant { probes_only: true, ..monitors(&[5]) };
    for url in [SERIAL, TCP] {
        let all = found(url, &plant).await;
        assert_eq!(all, [Finding::Unanswered]);
        assert_eq!(all[0].severity(), Severity::Fault);
    }
    let noisy = Plant { spoil: 3, probes_only: true, ..monitors(&[5]) };
    assert_eq!(found(TCP, &noisy).await[0], Finding::Unanswered);
}

/// Two programs on one port: the other's answers are not a second monitor.
#[tokio::test(start_paused = true)]
async fn two_programs_with_one_address() {
    let plant = Plant { shared: true, ..monitors(&[5]) };
    let all = found(SERIAL, &plant).await;
    assert!(all.contains(&Finding::OurAddressTaken), "{all:?}");
    assert!(!all.contains(&Finding::TwoWithOneAddress), "{all:?}");
}

/// No false finding on a healthy line; those with a controller are in `bus`.
#[tokio::test(start_paused = true)]
async fn healthy_lines_of_every_kind() {
    let well = [Finding::Well];
    let echo = [Finding::Well, Finding::Echo { told: true }];
    let fast = Plant { baud: Some(57_600), ..monitors(&[5]) };
    let slow = Plant { delay: Duration::from_millis(400), ..monitors(&[5]) };
    let lines: [(&str, &str, Plant, &[Finding]); 10] = [
        ("shared", "serial:///dev/x?addr=5&shared=1", monitors(&[5]), &well),
        (
            "compared with its echo",
            "serial:///dev/x?addr=5&echo=verify",
            Plant { echo: true, ..monitors(&[5]) },
            &echo,
        ),
        ("at a speed of its own", "serial:///dev/x?addr=5&baud=57600", fast, &well),
        ("direct", SERIAL, monitors(&[5]), &well),
        (
            "an echo",
            "serial:///dev/x?addr=5&echo=strip",
            Plant { echo: true, ..monitors(&[5]) },
            &echo,
        ),
        ("several monitors", SERIAL, monitors(&[1, 2, 5, 127]), &well),
        ("a network", TCP, monitors(&[5]), &well),
        ("a serial server with several", TCP, monitors(&[1, 5, 9]), &well),
        ("a radio modem", TCP, slow, &well),
        (
            "bare records",
            "tcp://h:1?framing=records",
            Plant { records: true, ..monitors(&[5]) },
            &well,
        ),
    ];
    for (name, url, plant, expected) in lines {
        assert_eq!(found(url, &plant).await, expected, "{name}");
        let seen = quietly(url, &plant).await;
        assert_eq!(findings(&seen), expected, "{name}, without insisting");
    }
}

/// An adapter that makes a byte when it is opened: the line is examined, and the byte reported.
#[tokio::test(start_paused = true)]
async fn a_byte_of_the_adapter_holds_nothing_back() {
    let plant = Plant { hum: &[0], hum_ticks: 1, ..monitors(&[5]) };
    for url in [SERIAL, TCP] {
        let seen = quietly(url, &plant).await;
        assert!(!seen.held_back && seen.is_answered(), "{url}: {seen:?}");
        assert_eq!(findings(&seen), [Finding::Noise { answered: true }], "{url}");
    }
}

/// Each row of the table of wrong lines has its test.
#[test]
fn each_row_of_the_page_has_its_test() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let read = |path: &str| std::fs::read_to_string(format!("{root}/{path}")).unwrap();
    let sources =
        ["client/tests/it/doctor.rs", "client/tests/it/bus/respect.rs", "cli/tests/it/bus.rs"];
    let sources = sources.map(|path| read(&format!("crates/{path}"))).concat();
    let rows = |page: &str, title: &str| {
        let text = read(page);
        let (_, table) = text.split_once(title).expect("the page has the table");
        let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
        let named: Vec<Vec<String>> = rows
            .map(|row| {
                let tests = row.trim_end_matches('|').rsplit('|').next().unwrap_or_default();
                tests.split('`').skip(1).step_by(2).map(str::to_owned).collect()
            })
            .collect();
        assert!(named.len() > 15 && named.iter().all(|tests| !tests.is_empty()), "{named:?}");
        for test in named.iter().flatten() {
            assert!(sources.contains(&format!("fn {test}(")), "{page}: {test}");
        }
        named
    };
    let english = rows("docs/service.md", "| fault of the line |");
    assert_eq!(english, rows("docs/service.ru.md", "| неисправность линии |"));
}
