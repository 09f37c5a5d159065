//! What happens when a broker, the line to it, its clients or the hub are lost.

use std::net::SocketAddr;

use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;

use super::*;
use crate::support::Site;

fn holder(site: &Site) -> Option<String> {
    let station = site.hub.station("M1").unwrap();
    let authority = station.authority.lock().unwrap();
    authority.holder().map(|it| it.0.seat.clone())
}

/// From the end of the broker to the drive of the simulator.
#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn a_broker_that_is_killed_stops_the_barrel_and_closes_the_valve() {
    let mut quickest = [Duration::MAX; 2];
    for round in 0..2 * MEASURED {
        let (site, mut broker) = open(1, OPERATOR).await;
        let water = round % 2 == 1;
        let client = Running::paho(&broker, &["hold", if water { "open" } else { "170" }]);
        if water {
            until("it opens", || opening(&site) > 0.9).await;
        } else {
            until("it moves", || moving(&site)).await;
        }
        broker.kill();
        let began = Instant::now();
        if water {
            until("it closes", || opening(&site) < 0.9).await;
        } else {
            until("it stops", || !moving(&site)).await;
        }
        quickest[usize::from(water)] = quickest[usize::from(water)].min(began.elapsed());
        if water {
            until("it is closed", || opening(&site) < 0.01).await;
        } else {
            assert!(stays(Duration::from_millis(300), || !moving(&site)).await);
        }
        until("authority is free", || holder(&site).is_none()).await;
        until_plug(&site, "it is reported", |it| it["error"]["ru"].is_string()).await;
        drop(client);
    }
    println!(
        "broker killed: stops after {:?}, begins to close after {:?}",
        quickest[0], quickest[1]
    );
    assert!(quickest.iter().all(|it| *it <= Duration::from_millis(500)), "{quickest:?}");
}

#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn clients_that_fall_silent_lose_authority_motion_and_water() {
    for (what, closes) in [("170", true), ("open", true), ("open", false)] {
        let terms = format!("role = \"operator\"\nalive_ms = 2000\nclose_when_lost = {closes}");
        let (site, broker) = open(1, &terms).await;
        let listener = broker.listen("lafet/#").await;
        let mut client = Running::paho(&broker, &["hold", what]);
        if what == "open" {
            until("it opens", || opening(&site) > 0.9).await;
        } else {
            until("it moves", || moving(&site)).await;
        }
        let keys = listener.of("lafet/M1/key").len();
        client.tell("silent");
        until("authority is free", || holder(&site).is_none()).await;
        match (what, closes) {
            ("open", true) => until("it closes", || opening(&site) < 0.01).await,
            ("open", false) => {
                assert!(stays(Duration::from_secs(2), || opening(&site) > 0.9).await);
            }
            _ => until("it stops", || !moving(&site)).await,
        }
        listener
            .until("an event", |it| it.starts_with("lafet/event ") && it.contains("silent"))
            .await;
        assert!(listener.of("lafet/M1/key").len() > keys, "the key is another one");
    }
}

/// A line to the broker that can be cut.
struct Cable {
    address: SocketAddr,
    task: JoinHandle<()>,
}

impl Cable {
    async fn lay(at: SocketAddr, to: SocketAddr) -> Self {
        let listener = TcpListener::bind(at).await.unwrap();
        let address = listener.local_addr().unwrap();
        let task = tokio::spawn(async move {
            while let Ok((mut near, _)) = listener.accept().await {
                let Ok(mut far) = TcpStream::connect(to).await else { continue };
                _ = copy_bidirectional(&mut near, &mut far).await;
            }
        });
        Self { address, task }
    }
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn the_broker_says_that_the_hub_is_gone_and_the_hub_that_it_is_back() {
    let broker = Broker::open().await;
    let cable = Cable::lay(super::super::free(), broker.address).await;
    let site = site_with(1, &table(cable.address, "")).await;
    let online = |wanted: bool| move |it: &str| json_of(it)["online"] == wanted;
    let first = json_of(&broker.until_retained("lafet/hub", online(true)).await);
    broker.until_retained("lafet/M1/available", |it| it == "online").await;
    // The line is cut: the broker publishes the will.
    let address = cable.address;
    cable.task.abort();
    broker.until_retained("lafet/hub", online(false)).await;
    until("the port is free", || std::net::TcpListener::bind(address).is_ok()).await;
    let cable = Cable::lay(address, broker.address).await;
    let second = json_of(&broker.until_retained("lafet/hub", online(true)).await);
    assert_ne!(first["session"], second["session"]);
    broker.until_retained("lafet/M1/state", |it| json_of(it)["quality"] == "good").await;
    // An orderly end: the hub says so itself.
    drop(site);
    broker.until_retained("lafet/hub", online(false)).await;
    broker.until_retained("lafet/M1/available", |it| it == "offline").await;
    broker.until_retained("lafet/M1/key", |it| json_of(it)["key"].is_null()).await;
    let _again = site_with(1, &table(broker.address, "")).await;
    broker.until_retained("lafet/hub", online(true)).await;
    broker.until_retained("lafet/M1/available", |it| it == "online").await;
    drop(cable);
}

/// A broker that has lost everything: what is kept is there again.
#[tokio::test]
#[ignore = "needs mosquitto"]
async fn a_broker_that_restarts_has_everything_again() {
    let (site, mut broker) = open(1, "homeassistant = \"homeassistant\"").await;
    let address = broker.address;
    broker.until_retained("lafet/M1/state", |_| true).await;
    broker.kill();
    until_plug(&site, "it is reported", |it| it["error"].is_object()).await;
    let broker = Broker::at(address).await;
    for topic in [
        "lafet/hub",
        "lafet/alarms",
        "lafet/M1/state",
        "lafet/M1/available",
        "lafet/M1/key",
        "homeassistant/device/lafet_M1/config",
    ] {
        broker.until_retained(topic, |_| true).await;
    }
    until_plug(&site, "it is connected", |it| it["error"].is_null()).await;
}
