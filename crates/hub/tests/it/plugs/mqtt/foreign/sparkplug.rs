//! Sparkplug B with a host application that is not ours, made with pysparkplug.

use super::*;
use crate::support::PATIENCE;

const NODE: &str = "[mqtt.sparkplug]\ngroup = \"site\"\nnode = \"hub\"\nprimary_host = \"scada\"";

async fn node(monitors: u8) -> (Site, Broker) {
    let broker = Broker::open().await;
    let site = site_with(monitors, &table(broker.address, &format!("{OPERATOR}\n{NODE}"))).await;
    (site, broker)
}

fn no_wrong(host: &Running) {
    let lines = host.lines();
    assert!(!lines.iter().any(|it| it.starts_with("wrong")), "{lines:#?}");
}

async fn waits(site: &Site) {
    until_plug(site, "it waits for its host", |it| says(it, "scada is not there")).await;
}

#[tokio::test]
#[ignore = "needs mosquitto and pysparkplug"]
async fn a_host_takes_turns_opens_once_and_closes() {
    let (site, broker) = node(1).await;
    waits(&site).await;
    let host = Running::sparkplug(&broker, "session");
    host.until("it is done", |it| it.starts_with("done")).await;
    no_wrong(&host);
    let expected = [
        "early 8",
        "take ok",
        "goto ok",
        "arrived",
        "open ok",
        "opened",
        "again True",
        "old key 9",
        "close ok",
        "stop ok",
        "stop all ok",
        "release ok",
        "not here 2",
    ];
    let lines = host.lines();
    let steps: Vec<&str> = lines
        .iter()
        .map(String::as_str)
        .filter(|it| !it.starts_with("born") && !it.starts_with("past") && !it.starts_with("done"))
        .collect();
    assert_eq!(steps, expected, "{lines:#?}");
    until_plug(&site, "it is connected", |it| it["error"].is_null()).await;
    opened_once(&site).await;
    // The broker keeps nothing of the node.
    let kept = broker.retained("spBv1.0/#").await;
    assert!(kept.iter().all(|(topic, _)| topic == "spBv1.0/STATE/scada"), "{kept:?}");
}

/// Its host is killed while the barrel is on its way: the broker says so, and nothing goes on.
#[tokio::test]
#[ignore = "needs mosquitto and pysparkplug"]
async fn a_host_that_is_killed_stops_the_barrel_and_hears_later_what_it_has_missed() {
    let (site, broker) = node(1).await;
    let host = Running::sparkplug(&broker, "hold");
    host.until("it holds", |it| it == "goto ok").await;
    until("it moves", || moving(&site)).await;
    no_wrong(&host);
    drop(host);
    until("it stops", || !moving(&site)).await;
    waits(&site).await;
    assert!(stays(Duration::from_millis(300), || !moving(&site)).await);
    // Meanwhile another client turns it.
    let mut console = site.ws("").await;
    console.authority("M1", "force").await;
    let turn = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 600" });
    console.ask(turn).await;
    until("it gets there", || (site.bus.position(0, HORIZONTAL) - 600.0).abs() < 1.0).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let host = Running::sparkplug(&broker, "watch");
    host.until("a birth", |it| it == "born M1").await;
    host.until("what it has missed", |it| it.starts_with("past M1 Traverse 10.0 ")).await;
    no_wrong(&host);
    let times: Vec<u64> = host
        .lines()
        .iter()
        .filter(|it| it.starts_with("past M1 Traverse "))
        .filter_map(|it| it.rsplit(' ').next()?.parse().ok())
        .collect();
    assert!(times.is_sorted() && !times.is_empty(), "{times:?}");
}

/// The broker is killed, and the barrel turns meanwhile: a host hears it with the time at which it was so.
#[tokio::test]
#[ignore = "needs mosquitto and pysparkplug"]
async fn what_was_so_while_the_broker_was_gone_is_heard_later() {
    let (site, mut broker) = node(1).await;
    let address = broker.address;
    let host = Running::sparkplug(&broker, "watch");
    host.until("a birth", |it| it == "born M1").await;
    drop(host);
    broker.kill();
    until_plug(&site, "it is reported", |it| says(it, "refused")).await;
    let began = site.hub.clock().now_ms();
    let mut console = site.ws("").await;
    assert!(console.authority("M1", "take").await["error"].is_null());
    let turn = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 600" });
    console.ask(turn).await;
    until("it gets there", || (site.bus.position(0, HORIZONTAL) - 600.0).abs() < 1.0).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let ended = site.hub.clock().now_ms();
    let broker = Broker::at(address).await;
    let host = Running::sparkplug(&broker, "watch");
    let past = host.until("what was so", |it| it.starts_with("past M1 Traverse 10.0 ")).await;
    let at: u64 = past.rsplit(' ').next().and_then(|it| it.parse().ok()).unwrap();
    assert!((began..=ended).contains(&at), "{began} {at} {ended}");
    assert!(host.lines().iter().any(|it| it == "born M1"), "after its birth");
    no_wrong(&host);
}

/// A broker that is killed and comes back, and a monitor that is silent.
#[tokio::test]
#[ignore = "needs mosquitto and pysparkplug"]
async fn births_and_deaths_are_those_of_the_specification() {
    let (site, mut broker) = node(2).await;
    let address = broker.address;
    let host = Running::sparkplug(&broker, "watch");
    host.until("a birth", |it| it == "born 0").await;
    for id in ["born M1", "born M2"] {
        host.until(id, |it| it == id).await;
    }
    site.bus.silence(2);
    host.until("M2 is lost", |it| it == "dead M2").await;
    assert!(!host.lines().iter().any(|it| it == "dead M1"), "{:#?}", host.lines());
    no_wrong(&host);
    drop(host);
    broker.kill();
    until_plug(&site, "it is reported", |it| says(it, "refused")).await;
    let broker = Broker::at(address).await;
    let host = Running::sparkplug(&broker, "watch");
    // Attempts that reached no broker have not counted.
    host.until("a birth of the next number", |it| it == "born 1").await;
    host.until("M1 is there", |it| it == "born M1").await;
    assert!(!host.lines().iter().any(|it| it == "born M2"), "{:#?}", host.lines());
    // An orderly end: the node says so itself, and the broker as well.
    let began = Instant::now();
    drop(site);
    host.until("the node is dead", |it| it.starts_with("dead ") && !it.contains('M')).await;
    assert!(began.elapsed() < PATIENCE);
    no_wrong(&host);
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn retained_commands_of_a_host_command_nothing_and_do_not_come_back() {
    let (site, broker) = open(1, &NODE.replace("primary_host = \"scada\"", "")).await;
    // {"command":"stop"} in a metric of the name Command/Text, as mosquitto_pub sends bytes: none of them is zero.
    let bytes = "\u{12}\u{22}\n\u{c}Command/Textz\u{12}{\"command\":\"stop\"}";
    assert_eq!(bytes.len(), 36);
    broker.publish("spBv1.0/site/DCMD/hub/M1", bytes, &["-r"]).await;
    until_plug(&site, "it has heard it", |it| it["requests"] == 1).await;
    drop(site);
    let text = table(broker.address, &NODE.replace("primary_host = \"scada\"", ""));
    let again = site_with(1, &text).await;
    until_plug(&again, "it is connected", |it| it["error"].is_null()).await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert_eq!(plug(&again).await["requests"], 0);
}
