//! The controller between two lines: every request is passed exactly once, whatever the turnaround,
//! the loss and the speed, and none after its console has stopped waiting. The driver is the real
//! one, on lines of which each takes the time of its bytes; time is virtual.

use std::collections::BTreeMap;
use std::future::poll_fn;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::Endpoint;
use lafet_client::bus::{BusStats, ControllerConfig, Driver, DriverConfig, Repeat};
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_proto::RequestId;
use lafet_proto::bus::CONTROLLER;
use lafet_sim::rng::Rng;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, timeout};

use super::medium::{Medium, Program, Station, frames};

/// How long a console waits for its answer: see docs/bus.md.
const CONSOLE_WAITS: Duration = Duration::from_millis(1200);
/// A run ends within this time for each request of a console, on the slowest and worst of these lines too.
const LONGEST: Duration = Duration::from_secs(10);
/// Requests of the form that is always run; `LAFET_BUS_REQUESTS` asks for more.
const REQUESTS: u32 = 10_000;
const MONITORS: [u8; 2] = [1, 2];
const CONSOLES: [u8; 2] = [129, 130];

/// A pair of lines.
#[derive(Clone, Debug)]
struct Setup {
    baud: u32,
    loss_permille: u64,
    echo: bool,
    turnaround_ms: u64,
    /// A fifth of the answers come late, some after the controller has stopped waiting.
    late: bool,
    repeat: Repeat,
    /// What each console asks.
    requests: u16,
    seed: u64,
}

/// A request of a console.
#[derive(Clone, Copy, Debug)]
struct Asked {
    /// When its console stopped waiting.
    until: Instant,
    answered: bool,
}

#[derive(Debug, Default)]
struct Seen {
    asked: BTreeMap<Vec<u8>, Asked>,
    executed: BTreeMap<Vec<u8>, u32>,
}

impl Seen {
    /// How many were asked, and how many of these answered.
    fn progress(&self) -> (usize, usize) {
        (self.asked.len(), self.asked.values().filter(|asked| asked.answered).count())
    }
}

/// What came of a run.
#[derive(Debug)]
struct Outcome {
    asked: usize,
    answered: usize,
    /// Requests that must not be executed twice, and were.
    twice: usize,
    /// Requests that must not be passed twice, and were.
    passed_twice: usize,
    late: usize,
    /// Different requests that went to the monitors.
    passed: u64,
    stats: BusStats,
}

/// A fifth is repeatable by nature; each has a number of its own.
fn request(console: u8, number: u16) -> Vec<u8> {
    let [low, high] = number.to_le_bytes();
    let request = match number % 5 {
        0 => RequestId::GET_PARAM,
        _ => RequestId::MOVE,
    };
    vec![request.0, console, 0, 2, low, high]
}

fn is_repeatable(payload: &[u8]) -> bool {
    payload.first() == Some(&RequestId::GET_PARAM.0)
}

/// A console as simple as can be: one request for each grant, as long as none waits for its answer.
async fn console(
    own: u8,
    station: Station,
    setup: Setup,
    seen: Arc<Mutex<Seen>>,
    done: mpsc::Sender<u8>,
) {
    let mut line = Program::simple(station);
    let mut waiting: Option<(Vec<u8>, Instant)> = None;
    let mut number = 0;
    loop {
        if number == setup.requests && waiting.is_none() {
            // It stays on the line, and has nothing more to say.
            _ = done.try_send(own);
        }
        let until = waiting.as_ref().map(|(_, until)| *until);
        let Some((dst, src, payload)) = line.frame(until).await else {
            waiting = None;
            continue;
        };
        if dst != own {
            continue;
        }
        if src != CONTROLLER {
            if let Some((asked, _)) = waiting.take_if(|(asked, _)| asked[..2] == payload[..2]) {
                seen.lock().unwrap().asked.get_mut(&asked).unwrap().answered = true;
            }
        } else if payload.first() == Some(&RequestId::ACCESS_GRANTED.0)
            && waiting.is_none()
            && number < setup.requests
        {
            let asked = request(own, number);
            number += 1;
            let until = Instant::now() + CONSOLE_WAITS;
            let entry = Asked { until, answered: false };
            seen.lock().unwrap().asked.insert(asked.clone(), entry);
            line.say(MONITORS[usize::from(number % 2)], own, &asked).await;
            waiting = Some((asked, until));
        } else {
            line.say(CONTROLLER, own, &[]).await;
        }
    }
}

/// A monitor that notes what it is asked, and accepts it.
async fn monitor(own: u8, station: Station, setup: Setup, seen: Arc<Mutex<Seen>>) {
    let mut line = Program::thorough(station);
    let mut dice = Rng::new(setup.seed ^ u64::from(own));
    loop {
        let Some((dst, src, payload)) = line.frame(None).await else { return };
        if dst != own {
            continue;
        }
        if let [request, console, ..] = payload[..] {
            *seen.lock().unwrap().executed.entry(payload.clone()).or_default() += 1;
            let late = if setup.late && dice.below(5) == 0 { dice.below(400) } else { 0 };
            sleep(Duration::from_millis(late)).await;
            line.say(src, own, &[request, console, 0, 0]).await;
        } else {
            line.say(src, own, &[]).await;
        }
    }
}

/// The driver must not be polled for ever at the same moment: virtual time does not pass meanwhile, and
/// no other bound is ever reached.
async fn while_time_passes(driver: impl Future<Output = ()>) {
    tokio::pin!(driver);
    let (mut at, mut polls) = (Instant::now(), 0);
    poll_fn(|cx| {
        polls = if at == Instant::now() { polls + 1 } else { 0 };
        assert!(polls < 100_000, "the controller waits for a moment that has come");
        at = Instant::now();
        driver.as_mut().poll(cx)
    })
    .await;
}

async fn run(setup: Setup) -> Outcome {
    let line = |salt| Medium::new(setup.baud, setup.loss_permille, setup.seed ^ salt);
    let (monitors, consoles) = (line(1), line(2));
    let echo = if setup.echo { "&echo=strip" } else { "" };
    let url = |name: &str| -> Endpoint {
        let Setup { baud, turnaround_ms, .. } = setup;
        let url = format!("serial:///{name}?baud={baud}&turnaround={turnaround_ms}{echo}");
        url.parse().unwrap()
    };
    let controller = ControllerConfig {
        baud: setup.baud,
        addresses: MONITORS.into_iter().chain(CONSOLES).collect(),
        turnaround: Duration::from_millis(setup.turnaround_ms),
        repeat: setup.repeat,
        ..ControllerConfig::default()
    };
    let (first, second) = (url("monitors"), url("consoles"));
    let config = DriverConfig {
        controller,
        monitors: first,
        consoles: Some(second.clone()),
        programs: None,
    };
    let lines = [monitors.clone(), consoles.clone()];
    let echoes = setup.echo;
    let mut driver = Driver::opening(config, move |endpoint| {
        let line = &lines[usize::from(endpoint == second)];
        let link = Link::Memory(Memory::new(line.station(echoes)));
        async move { Ok(link) }
    });
    let seen: Arc<Mutex<Seen>> = Arc::default();
    let (done, mut finished) = mpsc::channel(CONSOLES.len());
    for own in MONITORS {
        tokio::spawn(monitor(own, monitors.station(false), setup.clone(), seen.clone()));
    }
    for own in CONSOLES {
        let (station, done) = (consoles.station(false), done.clone());
        tokio::spawn(console(own, station, setup.clone(), seen.clone(), done));
    }
    let all = async {
        let mut waited_for = CONSOLES.to_vec();
        while !waited_for.is_empty() {
            let own = finished.recv().await.unwrap();
            waited_for.retain(|other| *other != own);
        }
    };
    let ended = tokio::select! {
        () = while_time_passes(driver.run(|_| ())) => false,
        ended = timeout(LONGEST * u32::from(setup.requests), all) => ended.is_ok(),
    };
    assert!(ended, "the consoles get no turn: {setup:?}: {:?}", seen.lock().unwrap().progress());
    judge(&seen.lock().unwrap(), &monitors, driver.controller().stats())
}

fn judge(seen: &Seen, monitors: &Medium, stats: BusStats) -> Outcome {
    let mut passed: BTreeMap<Vec<u8>, u32> = BTreeMap::new();
    let mut late = 0;
    // Stations that only listen come first or last; whatever a console asked was written by the
    // controller, as no console is on this line.
    for written in monitors.log() {
        let [(dst, _, payload)] = &frames(&written.bytes)[..] else { continue };
        let Some(asked) = seen.asked.get(payload).filter(|_| MONITORS.contains(dst)) else {
            continue;
        };
        *passed.entry(payload.clone()).or_default() += 1;
        late += usize::from(written.at > asked.until);
    }
    let twice = |all: &BTreeMap<Vec<u8>, u32>| {
        all.iter().filter(|(request, count)| **count > 1 && !is_repeatable(request)).count()
    };
    let (asked, answered) = seen.progress();
    Outcome {
        asked,
        answered,
        twice: twice(&seen.executed),
        passed_twice: twice(&passed),
        late,
        passed: passed.len() as u64,
        stats,
    }
}

fn requests() -> u32 {
    let asked = std::env::var("LAFET_BUS_REQUESTS").ok();
    asked.map_or(REQUESTS, |text| text.parse().expect("LAFET_BUS_REQUESTS is a number"))
}

const USUAL: Setup = Setup {
    baud: 19_200,
    loss_permille: 0,
    echo: false,
    turnaround_ms: 1,
    late: false,
    repeat: Repeat::Repeatable,
    requests: 40,
    seed: 1,
};

#[tokio::test(start_paused = true)]
async fn every_request_is_passed_exactly_once() {
    let mut setups = Vec::new();
    for baud in [9_600, 19_200, 57_600, 115_200] {
        for loss_permille in [0, 20, 100] {
            for echo in [false, true] {
                // Longer than the controller waits for an answer, too.
                for turnaround_ms in [0, 1, 20, 170] {
                    setups.push(Setup { baud, loss_permille, echo, turnaround_ms, ..USUAL });
                }
            }
        }
    }
    let each = requests().div_ceil(setups.len() as u32 * CONSOLES.len() as u32);
    let (mut asked, mut answered, mut passed, mut expired) = (0, 0, 0, 0);
    for (index, setup) in setups.into_iter().enumerate() {
        let (mut left, mut seed) = (each, index as u64);
        while left > 0 {
            // A request has 16 bits of a number.
            let requests = left.min(10_000) as u16;
            left -= u32::from(requests);
            seed += 1000;
            let late = setup.loss_permille > 0;
            let setup = Setup { seed, requests, late, ..setup.clone() };
            let of = run(setup.clone()).await;
            let wrong = (of.twice, of.passed_twice, of.late);
            assert_eq!(wrong, (0, 0, 0), "{setup:?}: {of:?}");
            // Whatever the controller took from a console went to the monitor.
            assert_eq!(of.passed, of.stats.requests - of.stats.expired, "{setup:?}: {of:?}");
            if setup.loss_permille == 0 {
                assert_eq!(of.answered, of.asked, "{setup:?}: {of:?}");
                assert_eq!((of.stats.repeated, of.stats.expired), (0, 0), "{setup:?}: {of:?}");
            }
            asked += of.asked;
            answered += of.answered;
            passed += of.passed;
            expired += of.stats.expired;
        }
    }
    let lost = asked as u64 - passed - expired;
    println!(
        "{asked} requests: {passed} passed on, 0 twice, 0 late, {answered} answered; not passed on: \
         {lost} lost on the consoles' line, {expired} expired at the controller"
    );
    assert!(answered * 10 > asked * 7, "{answered} of {asked}");
}

/// The test finds what it looks for: the observed repetition of everything executes some twice.
#[tokio::test(start_paused = true)]
async fn repetition_of_everything_executes_twice() {
    let repeat = Repeat::All;
    let setup = Setup { loss_permille: 100, late: true, requests: 200, repeat, ..USUAL };
    let of = run(setup).await;
    assert!(of.twice > 0 && of.passed_twice >= of.twice, "{of:?}");
    assert_eq!(of.late, 0, "{of:?}");
}
