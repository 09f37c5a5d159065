//! How long a scan takes at most: on virtual time, over a line at its real speed.

use std::time::Duration;

use lafet_client::scan::{ADAPTED, Scan, ScanOptions, scan};
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_proto::bus;
use tokio::time::Instant;

use super::medium::{Medium, Program, Station};

const SOURCE: u8 = 129;
/// A probe and its answer at 19200 baud: 2 × 8 bytes of 10 bits, and the pause of the line.
const ON_THE_LINE: Duration = Duration::from_millis(15);

async fn monitor(own: u8, station: Station) {
    let mut line = Program::thorough(station);
    while let Some((dst, src, payload)) = line.frame(None).await {
        if dst == own && payload.is_empty() {
            line.say(src, own, &[]).await;
        }
    }
}

/// Scans a line with these monitors on it, and how long that takes.
async fn scanned(monitors: &[u8], options: &ScanOptions) -> (Scan, Duration, u32) {
    let line = Medium::new(19_200, 0, 1);
    for own in monitors {
        tokio::spawn(monitor(*own, line.station(false)));
    }
    let link = Link::Memory(Memory::new(line.station(false)));
    let (began, mut probed) = (Instant::now(), 0);
    let scan = scan(link, SOURCE, options, |_| probed += 1).await.unwrap();
    (scan, began.elapsed(), probed)
}

/// As `lafet scan` does it on a serial line without a word of how long.
fn usual() -> ScanOptions {
    ScanOptions { listen: Duration::from_millis(1200), ..ScanOptions::default() }
}

/// Two tries and one with the other check for each address, never more than its wait; and the listening.
#[tokio::test(start_paused = true)]
async fn an_empty_line_takes_its_waits_and_no_longer() {
    let options = usual();
    let (scan, took, probed) = scanned(&[], &options).await;
    assert!(scan.present.is_empty() && !scan.held_back);
    assert_eq!(probed, 2 * u32::from(*bus::MONITORS.end()));
    let least = options.listen + options.wait * (3 * 127 + 1);
    assert!(took >= least, "{took:?} of at least {least:?}");
    assert!(took <= least + ON_THE_LINE * (3 * 127), "{took:?} of at least {least:?}");
    assert!(took < Duration::from_secs(20), "{took:?}");
}

/// Who answers is not waited for: a full line is scanned sooner than an empty one.
#[tokio::test(start_paused = true)]
async fn those_that_answer_cost_the_time_of_their_answers() {
    let all: Vec<u8> = bus::MONITORS.collect();
    let options = usual();
    let (scan, took, probed) = scanned(&all, &options).await;
    assert_eq!(scan.present.len(), 127);
    assert_eq!(probed, 127);
    let most = options.listen + options.wait + (ON_THE_LINE * 127);
    assert!(took <= most, "{took:?} of at most {most:?}");
    let (some, longer, _) = scanned(&[1, 64, 127], &options).await;
    let found: Vec<u8> = some.present.iter().map(|present| present.address).collect();
    assert_eq!(found, [1, 64, 127]);
    assert!(longer > took, "{longer:?}");
}

/// The first answer shortens the waits after it, and those alone: to what the round trip allows.
#[tokio::test(start_paused = true)]
async fn the_first_answer_shortens_the_waits_of_a_network() {
    const FIRST: u32 = 10;
    let wait = Duration::from_millis(300);
    let options = ScanOptions { wait, adapt: true, ..ScanOptions::default() };
    let (scan, took, _) = scanned(&[10], &options).await;
    let [first] = &scan.present[..] else { panic!("{scan:?}") };
    assert!(first.rtt <= ON_THE_LINE, "{:?}", first.rtt);
    // The first tries of those before it, and the listening at the end.
    let whole = wait * ((FIRST - 1) + 1);
    // The second round comes after the answer.
    let rest = (FIRST - 1) + 2 * (127 - FIRST) + 126;
    let least = whole + ADAPTED * rest;
    let most = whole + (ADAPTED + first.rtt * 4) * rest + ON_THE_LINE * (3 * 127);
    assert!((least..=most).contains(&took), "{took:?} of {least:?} to {most:?}");
    assert!(most < wait * (3 * 126) / 2, "{most:?}");
    // Where the user has chosen the wait, nothing is shortened.
    let (_, took, _) = scanned(&[10], &ScanOptions { adapt: false, ..options }).await;
    assert!(took >= wait * (3 * 126 + 1), "{took:?}");
}

/// A port that is open and never answers: each address has the whole wait once. An answer that comes
/// later than a shortened wait counts all the same.
#[tokio::test(start_paused = true)]
async fn a_network_port_that_never_answers_has_the_whole_wait_once_for_each_address() {
    let (wait, listen) = (Duration::from_millis(100), Duration::from_secs(3));
    let options = ScanOptions { wait, listen, adapt: true, ..ScanOptions::default() };
    let (scan, took, _) = scanned(&[], &options).await;
    assert!(scan.present.is_empty(), "{scan:?}");
    let least = listen + wait * (127 + 1) + ADAPTED * (2 * 127);
    assert!((least..=least + ON_THE_LINE * (3 * 127)).contains(&took), "{took:?} of {least:?}");
    // The first probe is lost, and the answer to the second one comes after 90 ms.
    let line = Medium::new(19_200, 0, 1);
    let mut station = Program::thorough(line.station(false));
    tokio::spawn(async move {
        let mut probes = 0;
        while let Some((dst, src, _)) = station.frame(None).await {
            probes += u32::from(dst == 5);
            if dst == 5 && probes == 2 {
                tokio::time::sleep(Duration::from_millis(90)).await;
                station.say(src, dst, &[]).await;
            }
        }
    });
    let link = Link::Memory(Memory::new(line.station(false)));
    let found = lafet_client::scan::scan(link, SOURCE, &options, |_| {}).await.unwrap();
    let found: Vec<u8> = found.present.iter().map(|present| present.address).collect();
    assert_eq!(found, [5]);
}

/// A line on which others speak costs the listening alone.
#[tokio::test(start_paused = true)]
async fn a_line_in_use_is_left_alone_at_once() {
    let line = Medium::new(19_200, 0, 1);
    let other = line.station(false);
    tokio::spawn(async move {
        let mut other = Program::thorough(other);
        loop {
            other.say(5, bus::CONTROLLER, &[]).await;
            tokio::time::sleep(Duration::from_millis(900)).await;
        }
    });
    let (options, began) = (usual(), Instant::now());
    let link = Link::Memory(Memory::new(line.station(false)));
    let scan = scan(link, SOURCE, &options, |address| panic!("{address} is probed")).await.unwrap();
    assert!(scan.held_back);
    assert_eq!(scan.speakers, [bus::CONTROLLER]);
    assert!(began.elapsed() <= options.listen + ON_THE_LINE, "{:?}", began.elapsed());
}
