//! Values that are kept up to date, through silence and reconnections; the link's figures.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::fake::plant::{Fate, SOON, plant, serve};
use crate::fake::{self, Log, answer, frame};
use lafet_client::{Client, Config, Error, LinkEvent, Monitor, StatusUpdate, UPDATES_MAX, Update};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use tokio::time::{Instant, sleep};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;
const PERIOD: Duration = Duration::from_millis(200);

fn read() -> Request<'static> {
    Request::new(VERTICAL, Body::GetStatus)
}

fn well() -> (Client, Log) {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let log = Log::default();
    tokio::spawn(fake::serve(theirs, log.clone(), |payload| frame(&answer(payload))));
    (Client::over("sim:", ours, Config::default()), log)
}

#[tokio::test(start_paused = true)]
async fn the_latest_value_with_its_age_for_several() {
    let (client, log) = well();
    let monitor = Monitor::new(client.clone());
    let mut quick = monitor.watch(PERIOD).unwrap();
    let mut slow = monitor.watch(10 * PERIOD).unwrap();
    assert!(quick.latest().is_none());
    let StatusUpdate::Value(first) = quick.next().await else { panic!("a value") };
    assert_eq!(first.status.vertical.unwrap().position, 300);
    assert!(!first.stale);
    sleep(PERIOD / 2).await;
    let latest = slow.latest().unwrap();
    assert!(latest.age >= PERIOD / 2 - Duration::from_millis(5) && latest.age < PERIOD);
    sleep(10 * PERIOD).await;
    assert!(matches!(slow.next().await, StatusUpdate::Value(_)));
    // One poll serves both, as often as the quicker wants.
    let polls = log.lock().unwrap().len();
    assert!((10..=13).contains(&polls), "{polls}");
    drop(quick);
    log.lock().unwrap().clear();
    sleep(20 * PERIOD).await;
    assert!(log.lock().unwrap().len() <= 4, "only the slow one is left");
    drop(slow);
    sleep(20 * PERIOD).await;
    log.lock().unwrap().clear();
    sleep(100 * PERIOD).await;
    assert!(log.lock().unwrap().is_empty(), "none is left");
    let stop = Request::new(SubsystemId::ALL, Body::Stop);
    assert!(matches!(client.subscribe(&stop, PERIOD), Err(Error::NotARead { .. })));
}

#[tokio::test(start_paused = true)]
async fn who_is_slow_misses_updates_and_holds_up_nobody() {
    let (client, log) = well();
    let mut slow = client.subscribe(&read(), PERIOD).unwrap();
    let mut quick = client.subscribe(&read(), PERIOD).unwrap();
    for _ in 0..UPDATES_MAX + 20 {
        assert!(matches!(quick.next().await, Update::Value(_)));
    }
    assert_eq!(log.lock().unwrap().len(), UPDATES_MAX + 20);
    assert!(matches!(slow.next().await, Update::Missed(20)));
    let Update::Value(oldest) = slow.next().await else { panic!("a value") };
    assert!(oldest.age() > PERIOD * (UPDATES_MAX as u32 - 2));
    assert!(slow.latest().unwrap().age() < PERIOD, "the latest is not in the queue");
}

/// A subscription outlives connections: stale is said once, and the next value comes by itself.
#[tokio::test(start_paused = true)]
async fn a_subscription_goes_on_after_a_reconnection() {
    let plant = plant();
    let (up, dials) = (Arc::new(Mutex::new(true)), Arc::new(Mutex::new(Vec::new())));
    let servers = Arc::new(Mutex::new(Vec::<tokio::task::JoinHandle<()>>::new()));
    let (to_serve, is_up, list) = (plant.clone(), up.clone(), servers.clone());
    let times = dials.clone();
    let dial = move || {
        times.lock().unwrap().push(Instant::now());
        let (ours, theirs) = lafet_client::transport::memory::pair();
        let up = *is_up.lock().unwrap();
        if up {
            list.lock().unwrap().push(tokio::spawn(serve(theirs, to_serve.clone())));
        }
        async move { if up { Ok(ours) } else { Err(std::io::ErrorKind::ConnectionRefused.into()) } }
    };
    let client = Client::dial("sim:", dial, Config::default()).await.unwrap();
    let mut watch = client.subscribe(&read(), PERIOD).unwrap();
    assert!(matches!(watch.next().await, Update::Value(_)));
    *up.lock().unwrap() = false;
    servers.lock().unwrap().drain(..).for_each(|server| server.abort());
    let Update::Stale(error) = loop_until_stale(&mut watch).await else { panic!("stale") };
    assert!(matches!(error, Error::Link { .. }), "{error}");
    let latest = watch.latest().unwrap();
    assert!(latest.is_stale() && watch.error().is_some());
    sleep(Duration::from_secs(10)).await;
    assert!(watch.latest().unwrap().age() > Duration::from_secs(10));
    *up.lock().unwrap() = true;
    let again = Instant::now();
    assert!(matches!(watch.next().await, Update::Value(_)), "said once, then a value");
    // The longest pause between two attempts is 2 s, and nothing is waited for after it.
    assert!(again.elapsed() < Duration::from_millis(2100), "{:?}", again.elapsed());
    assert!(!watch.latest().unwrap().is_stale() && watch.error().is_none());
    // Backed off: each pause is twice as long as the one before, up to 2 s.
    let dials = dials.lock().unwrap();
    let pauses: Vec<u128> =
        dials.windows(2).map(|pair| (pair[1] - pair[0]).as_millis()).skip(1).collect();
    assert!(
        pauses.is_sorted() && pauses[0] <= 110 && *pauses.last().unwrap() >= 2000,
        "{pauses:?}"
    );
    assert!(dials.len() < 14, "{}", dials.len());
}

/// A period that no clock can add is a long one.
#[tokio::test(start_paused = true)]
async fn the_longest_period_and_the_longest_waits_are_long_ones() {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(fake::serve(theirs, Log::default(), |payload| frame(&answer(payload))));
    let most = Duration::MAX;
    let config = Config {
        timeout: most,
        patience: most,
        late_bound: most,
        drain_bound: most,
        resume: most,
        ..Config::default()
    };
    let client = Client::over("sim:", ours, config);
    let mut slow = client.subscribe(&read(), most).unwrap();
    assert!(matches!(slow.next().await, Update::Value(_)));
    assert!(!slow.latest().unwrap().is_stale());
    // Another of the same value still has its own period.
    let mut quick = client.subscribe(&read(), PERIOD).unwrap();
    for _ in 0..3 {
        assert!(matches!(quick.next().await, Update::Value(_)));
    }
    drop(quick);
    sleep(10 * PERIOD).await;
    assert!(!slow.latest().unwrap().is_stale());
    assert!(client.request(&read()).await.is_ok());
    let batch = client.complete(&[read()], |_| {}).await;
    assert!(batch.iter().all(Result::is_ok), "{batch:?}");
}

async fn loop_until_stale(watch: &mut lafet_client::Subscription) -> Update {
    loop {
        match watch.next().await {
            Update::Value(_) => {}
            other => return other,
        }
    }
}

/// Figures each second, like Klipper's; they cost nothing without a listener.
#[tokio::test(start_paused = true)]
async fn the_link_tells_its_figures_each_second() {
    let plant = plant();
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(serve(theirs, plant.clone()));
    let client = Client::over("sim:", ours, Config::default());
    sleep(Duration::from_secs(3)).await;
    let mut events = client.events();
    let polls = client.subscribe(&read(), PERIOD).unwrap();
    let LinkEvent::Statistics(first) = events.recv().await.unwrap() else { panic!("figures") };
    assert_eq!(first.over, Duration::from_secs(1));
    assert!((5..=6).contains(&first.last.frames_sent), "{first}");
    assert_eq!((first.last.loss_permille(), first.last.errors()), (0, 0));
    assert!(first.last.rtt_last.unwrap() >= Duration::from_millis(5), "{first}");
    plant.lock().unwrap().fate = Box::new(|_| Fate::LoseAnswer);
    for _ in 0..3 {
        events.recv().await.unwrap();
    }
    plant.lock().unwrap().fate = Box::new(|_| SOON);
    let LinkEvent::Statistics(bad) = events.recv().await.unwrap() else { panic!("figures") };
    assert!(bad.total.timeouts >= 3 && bad.total.retries >= 2, "{bad}");
    assert!(bad.total.loss_permille() > 100, "{bad}");
    drop(polls);
}
