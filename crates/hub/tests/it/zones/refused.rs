//! A no that stays, and a no that is none of a zone's business.

use lafet_client::{Client, Endpoint};
use lafet_proto::Request;
use lafet_proto::request::Body;

use super::*;
use crate::support::stand_for_people;

/// The hall's monitor, with a stand for people beside its aim.
async fn hall_beside_people() -> Site {
    let zones = hall(1, "");
    let map = stand_for_people();
    Site::of((1, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.zones, config.site) = (false, Some(zones), Some(map));
    })
    .await
}

/// Water that another client turns into a keep-out is shut off, and the zone does not open it again.
#[tokio::test]
async fn what_a_keep_out_has_shut_off_stays_closed_until_a_reset() {
    let site = hall_beside_people().await;
    let released = order(&site, "hall/release", json!({ "confirm": "hall" })).await;
    assert_eq!(released.status, 200, "{released:?}");
    until("the valve opens", || is_open(&site, "M1")).await;
    let endpoint: Endpoint = site.hub.config().monitors[0].endpoint.clone();
    let other = Client::connect(&endpoint).await.unwrap();
    for turn in [
        Request::new(SubsystemId::CONTROL, Body::Stop),
        Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: -2700 }),
    ] {
        other.request(&turn).await.unwrap().accepted().unwrap();
    }
    until("it is shut", || is_closed(&site, "M1")).await;
    assert!(
        stays(Duration::from_secs(3), || is_closed(&site, "M1")).await,
        "the zone opens it again"
    );
    let acts = acts(&site).await;
    let engages = acts.iter().filter(|act| act["order"]["engage"].is_object()).count();
    assert_eq!(engages, 1, "{acts:#?}");
    let no = acts.iter().find(|act| act["entry"]["no"].is_object()).expect("the no is noted");
    assert_eq!(no["entry"]["no"]["scope"]["monitor"], "M1", "{no:#}");
    assert_eq!(no["cause"][0]["hand"]["by"], "keep-outs", "{no:#}");
}

/// All parameters of a monitor take longer to read than an order to open is valid; the keep-outs need one of them.
#[tokio::test]
async fn a_release_right_after_the_start_opens_past_keep_outs_on_a_slow_line() {
    let site = hall_beside_people().await;
    site.bus.slow(Duration::from_millis(60));
    let released = order(&site, "hall/release", json!({ "confirm": "hall" })).await;
    assert_eq!(released.status, 200, "{released:?}");
    until("the valve opens", || is_open(&site, "M1")).await;
}

/// Its head has come at once, and its body after the network was dead for a while.
#[tokio::test]
async fn an_order_whose_body_comes_late_is_refused() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let site = quiet(1, "").await;
    let body = json!({ "confirm": "hall" }).to_string();
    let head = format!(
        "POST /api/zones/hall/release?up_ms={} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
         Content-Length: {}\r\n\r\n",
        site.hub.up_ms(),
        body.len()
    );
    let mut stream = tokio::net::TcpStream::connect(site.address).await.unwrap();
    stream.write_all(head.as_bytes()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(2500)).await;
    stream.write_all(body.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 409 ") && answer.contains("\"late\""), "{answer}");
    assert_eq!(state(&site).await["zones"][0]["phase"], "quiet");
    assert!(is_closed(&site, "M1"));
}

/// Two zones that share a monitor and their detectors.
async fn hall_and_store() -> Site {
    let mut zones = hall(1, "");
    let mut store = zones.site.zones[0].clone();
    store.id = "store".into();
    zones.site.zones.push(store);
    let aim = zones.aims[&("hall".to_owned(), "M1".to_owned())].clone();
    zones.aims.insert(("store".to_owned(), "M1".to_owned()), aim);
    for detector in &mut zones.site.detectors {
        detector.zones.push("store".into());
    }
    Site::with(1, |config| {
        (config.login, config.zones) = (false, Some(zones));
    })
    .await
}

/// `hall` is aborted while `store`, which shares its monitor, is opening it.
#[tokio::test]
async fn the_abort_of_one_zone_does_not_stop_the_water_of_another() {
    let site = hall_and_store().await;
    site.bus.keep_back(RequestId::START_QUENCH);
    let released = order(&site, "store/release", json!({ "confirm": "store" })).await;
    assert_eq!(released.status, 200, "{released:?}");
    until("it is being ordered", || site.bus.waits()).await;
    assert_eq!(order(&site, "hall/abort", json!({})).await.status, 200);
    site.bus.let_through();
    until("it opens for the other zone", || is_open(&site, "M1")).await;
    let zone = state(&site).await["zones"][1].clone();
    assert_eq!(zone["phase"]["released"]["wet"], true, "{zone:#}");
}

/// Many detectors report over the token of one gateway, and all alarm at once.
#[tokio::test]
async fn a_gateway_is_heard_when_all_of_its_detectors_alarm() {
    let mut zones = hall(1, "");
    let flame = zones.site.detectors[0].clone();
    for number in 0..150 {
        let id = format!("F{number}");
        zones.site.detectors.push(lafet_site::config::Detector { id, ..flame.clone() });
    }
    let count = u16::try_from(zones.site.detectors.len()).unwrap();
    zones.site.zones[0].votes = format!("{count}oo{count}").parse().unwrap();
    let site = Site::with(1, |config| {
        (config.login, config.zones) = (false, Some(zones));
    })
    .await;
    // Twice as many as one token may change at once.
    for number in 0..150 {
        let reply = sees(&site, &format!("F{number}"), "alarm").await;
        assert_eq!(reply.status, 204, "F{number}: {reply:?}");
    }
    let all = (0..60).map(|_| sees(&site, "flame", "alarm"));
    let replies = futures_util::future::join_all(all).await;
    assert!(replies.iter().any(|it| it.status == 429), "one detector has its own limit");
    assert_eq!(sees(&site, "heat", "alarm").await.status, 204, "the others are still heard");
}

/// Another program keeps the file of the state locked.
#[tokio::test]
async fn an_order_that_is_not_on_the_disk_says_so() {
    let folder = std::env::temp_dir().join(format!("lafet-unstored-{}", std::process::id()));
    _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let zones = hall(1, "");
    let own = folder.clone();
    let site = Site::with(1, |config| {
        (config.login, config.zones, config.data) = (false, Some(zones), Some(own));
    })
    .await;
    let mode = |mode: &str| json!({ "mode": mode });
    // A disk that is busy may take longer than an answer waits for it.
    let kept = async || {
        let began = Instant::now();
        loop {
            let kept = order(&site, "hall/mode", mode("manual")).await;
            assert_eq!(kept.status, 200, "{kept:?}");
            if kept.body["stored"] == true {
                break;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "{kept:?}");
        }
    };
    kept().await;
    let other = rusqlite::Connection::open(folder.join("hub.db")).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    let off = order(&site, "hall/mode", mode("off")).await;
    assert_eq!((off.status, &off.body["stored"]), (200, &json!(false)), "{off:?}");
    assert_eq!(off.body["state"]["zones"][0]["mode"], "off", "it is in effect all the same");
    let alarm = || site.hub.alarms().list().iter().any(|it| it.id == "hub/Zones" && it.active);
    until("there is an alarm", alarm).await;
    assert_eq!(site.get("", "/api/zones").await.body["stored"], false);
    other.execute_batch("ROLLBACK").unwrap();
    until("the alarm is over", || !alarm()).await;
    kept().await;
    drop(site);
    _ = fs::remove_dir_all(&folder);
}

/// A client says the same no again and again, and another one opens the valve meanwhile.
#[tokio::test]
async fn a_no_that_is_repeated_is_counted_and_shuts_all_the_same() {
    let site = hall_and_store().await;
    let outcomes = async |zone: &str| {
        let log = site.hub.audit().latest(None, 1000, None, None).await.unwrap();
        let of = |act: &Value| act["entry"]["no"]["scope"]["zone"] == zone;
        let all = log.into_iter().map(|entry| entry.record);
        let all = all.filter(|record| record.act.as_ref().is_some_and(of));
        all.map(|record| (record.outcome, record.details["count"].clone())).collect::<Vec<_>>()
    };
    let abort = async |zone: &str| {
        assert_eq!(order(&site, &format!("{zone}/abort"), json!({})).await.status, 200);
    };
    abort("hall").await;
    abort("store").await;
    let endpoint: Endpoint = site.hub.config().monitors[0].endpoint.clone();
    let other = Client::connect(&endpoint).await.unwrap();
    other.request(&Request::open(SubsystemId::VALVE1)).await.unwrap().accepted().unwrap();
    let (began, mut aborts) = (Instant::now(), 0_u64);
    while !is_closed(&site, "M1") || aborts < 20 {
        abort("hall").await;
        aborts += 1;
        assert!(began.elapsed() < Duration::from_secs(8), "it stays open");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let mut hall = outcomes("hall").await;
    while hall.len() < 2 && began.elapsed() < Duration::from_secs(20) {
        tokio::time::sleep(Duration::from_millis(50)).await;
        hall = outcomes("hall").await;
    }
    assert_eq!(hall, [("repeated".to_owned(), json!(aborts)), ("Ok".to_owned(), Value::Null)]);
    assert_eq!(outcomes("store").await, [("Ok".to_owned(), Value::Null)]);
}
