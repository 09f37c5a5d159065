//! With mosquitto and its clients, and with paho-mqtt: `cargo xtask plugs` installs them.

mod lost;
mod sparkplug;

use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tokio::time::Instant;

use super::super::{HORIZONTAL, MEASURED, opening};
use super::broker::{Broker, Running};
use super::{plug, says, site_with, table, until_plug};
use crate::support::{Site, stays, until};

/// Stops that are measured under a flood.
const FLOODED: usize = 20;
/// What two clients of the flood send in a second at most: each pauses for 10 ms after 50.
const OF_A_SECOND: u64 = 10_000;
const OPERATOR: &str = "role = \"operator\"\nalive_ms = 5000";

/// A hub at a broker without a login.
async fn open(monitors: u8, more: &str) -> (Site, Broker) {
    let broker = Broker::open().await;
    let site = site_with(monitors, &table(broker.address, more)).await;
    until_plug(&site, "it is connected", |it| it["error"].is_null()).await;
    (site, broker)
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_default()
}

fn moving(site: &Site) -> bool {
    site.bus.commanded(0, HORIZONTAL) != 0
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn states_are_there_and_null_when_they_are_not_known() {
    let (site, broker) = open(2, "").await;
    site.bus.lock()[1].world_mut().drives[HORIZONTAL].position = 234.0;
    let hub = broker.until_retained("lafet/hub", |it| json_of(it)["online"] == true).await;
    assert!(json_of(&hub)["session"].as_str().is_some_and(|it| it.len() == 16), "{hub}");
    let good = |it: &str| json_of(it)["quality"] == "good" && json_of(it)["traverse"] == 3.9;
    let state = json_of(&broker.until_retained("lafet/M2/state", good).await);
    for (key, value) in [("holder", json!("free")), ("water", json!(false)), ("fire", json!(false))]
    {
        assert_eq!(state[key], value, "{state:#}");
    }
    assert_eq!(state["valves"]["valve1"]["closed"], true, "{state:#}");
    assert!(state["age_ms"].as_u64().is_some_and(|it| it < 2000), "{state:#}");
    assert_eq!(broker.until_retained("lafet/M2/available", |_| true).await, "online");
    assert!(json_of(&broker.until_retained("lafet/alarms", |_| true).await)["alarms"].is_array());
    let listener = broker.listen("lafet/#").await;
    site.bus.silence(2);
    broker.until_retained("lafet/M2/available", |it| it == "offline").await;
    let state =
        broker.until_retained("lafet/M2/state", |it| json_of(it)["quality"] == "stale").await;
    let state = json_of(&state);
    for key in ["traverse", "elevation", "pressure_mpa", "flow_lps", "mode", "fire", "motion"] {
        assert!(state[key].is_null(), "{key}: {state:#}");
    }
    assert_eq!(state["water"], true, "{state:#}");
    assert_eq!(broker.until_retained("lafet/M1/available", |_| true).await, "online");
    // The alarm of its silence, and the tickets: one a second, each another one, none kept.
    listener.until("an alarm", |it| it.starts_with("lafet/alarms ") && it.contains("M2/")).await;
    let tickets = listener.of("lafet/ticket");
    assert!(tickets.len() >= 2 && tickets.windows(2).all(|it| it[0] != it[1]), "{tickets:?}");
    assert!(broker.retained("lafet/ticket").await.is_empty());
    // One state in a second, and those that could not wait.
    let states = listener.of("lafet/M1/state").len();
    let seconds = listener.of("lafet/ticket").len();
    assert!(states <= seconds + 3, "{states} states in {seconds} s");
}

/// One opening is noted, and one that was refused: that of the old key.
async fn opened_once(site: &Site) -> Value {
    let noted = site.get("", "/api/audit?limit=1000").await.body;
    let entries = noted["entries"].as_array().unwrap();
    let opened = |it: &&Value| it["what"] == "Open Valve1" && it["outcome"] == "asked";
    assert_eq!(entries.iter().filter(opened).count(), 1, "{noted:#}");
    let refused = |it: &&Value| it["what"] == "Open Valve1" && it["outcome"] == "not allowed";
    let refused = entries.iter().find(refused).expect("the old key is noted");
    assert_eq!((&refused["kind"], &refused["user"]), (&json!("mqtt"), &json!("mqtt site")));
    assert_eq!(refused["details"]["code"], 9);
    refused.clone()
}

#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn paho_takes_turns_opens_once_and_closes() {
    let (site, broker) = open(1, OPERATOR).await;
    let client = Running::paho(&broker, &["session"]);
    client.until("it is done", |it| it == "done").await;
    let expected = [
        "early 8",
        "take ok",
        "goto ok",
        "arrived",
        "open ok",
        "opened",
        "again True",
        "old key 9",
        "stow 12",
        "close ok",
        "stop ok",
        "release ok",
        "done",
    ];
    assert_eq!(client.lines(), expected);
    let refused = opened_once(&site).await;
    let from = refused["from"].as_str().unwrap();
    assert!(from.contains(&broker.address.to_string()) && from.contains("id paho-"), "{from}");
}

/// How many messages of others are taken from the start of mosquitto_pub until its Stop is carried out: a machine that does other
/// things delays all of them alike. A hub that takes commands no faster than it carries them out has tens of thousands before it,
/// which sockets and broker keep.
#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn stop_overtakes_a_flood_of_commands() {
    let (site, broker) = open(1, OPERATOR).await;
    let holder = Running::paho(&broker, &["hold", "170"]);
    holder.until("it holds", |it| it == "goto ok").await;
    let _floods = [0, 1].map(|_| Running::paho(&broker, &["flood"]));
    until_plug(&site, "it is flooded", |it| it["requests"].as_u64() > Some(2000)).await;
    let mut console = site.ws("").await;
    console.authority("M1", "force").await;
    let taken = async || plug(&site).await["requests"].as_u64().unwrap();
    let stops = || site.hub.station("M1").unwrap().urgent_count();
    let (mut times, mut before_it) = (Vec::new(), Vec::new());
    for round in 0..FLOODED {
        let target = if round % 2 == 0 { 9000 } else { -9000 };
        let text = format!("Move Horizontal {target}");
        let turn = json!({ "type": "request", "monitor": "M1", "request": text });
        let answer = console.ask(turn).await;
        assert!(answer["error"].is_null(), "{answer:#}");
        until("it moves", || moving(&site)).await;
        let (began, before, carried_out) = (Instant::now(), taken().await, stops());
        let stop = async {
            broker.publish("lafet/M1/command", r#"{"command":"stop"}"#, &[]).await;
        };
        let heard = async {
            until("it is carried out", || stops() > carried_out).await;
            taken().await - before
        };
        let ((), messages) = tokio::join!(stop, heard);
        until("it stops", || !moving(&site)).await;
        times.push(began.elapsed());
        before_it.push(messages);
    }
    times.sort_unstable();
    before_it.sort_unstable();
    let all = taken().await;
    println!("Stops under flood: {times:?}, behind {before_it:?} of {all} messages");
    assert!(all > 20_000, "{all} messages are no flood");
    // Half of them, and all but the one in which the machine did something else.
    assert!(before_it[before_it.len() / 2] <= OF_A_SECOND / 4, "{before_it:?}");
    assert!(before_it[before_it.len() - 2] <= OF_A_SECOND, "{before_it:?}");
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn retained_messages_command_nothing_and_do_not_come_back() {
    let (site, broker) = open(1, OPERATOR).await;
    let listener = broker.listen("lafet/#").await;
    let ticket =
        || json_of(&listener.of("lafet/ticket").pop().unwrap_or_default())["ticket"].clone();
    let key = json_of(&broker.until_retained("lafet/M1/key", |_| true).await)["key"].clone();
    listener.until("a ticket", |it| it.starts_with("lafet/ticket ")).await;
    for (id, command) in [("r1", "take"), ("r2", "open")] {
        let mut text = json!({ "id": id, "command": command, "ticket": ticket() });
        if command == "open" {
            (text["valve"], text["key"]) = (json!(1), key.clone());
        }
        broker.publish("lafet/M1/command", &text.to_string(), &["-r"]).await;
        let result = listener.result("lafet/M1", id).await;
        assert_eq!((&result["refusal"], &result["retained"]), (&json!(24), &json!(true)));
        assert!(result["text"]["ru"].is_string());
    }
    // Stop is carried out, once, and its result says how it came.
    let stop = r#"{"id":"r3","command":"stop"}"#;
    broker.publish("lafet/M1/command", stop, &["-r"]).await;
    let result = listener.result("lafet/M1", "r3").await;
    assert_eq!((&result["ok"], &result["retained"]), (&json!(true), &json!(true)));
    drop(site);
    broker.until_retained("lafet/hub", |it| json_of(it)["online"] == false).await;
    // The broker keeps it: a hub that connects later does not hear of it.
    let again = site_with(1, &table(broker.address, OPERATOR)).await;
    broker.until_retained("lafet/hub", |it| json_of(it)["online"] == true).await;
    assert!(stays(Duration::from_secs(1), || opening(&again) < 0.01).await);
    assert_eq!(plug(&again).await["requests"], 0);
}

/// All that was said in a session, sent again in the next one.
#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn a_recorded_session_opens_nothing_in_the_next_one() {
    let (site, broker) = open(1, OPERATOR).await;
    let listener = broker.listen("lafet/#").await;
    let client = Running::paho(&broker, &["session"]);
    client.until("it is done", |it| it == "done").await;
    drop(client);
    let recorded = listener.of("lafet/M1/command");
    assert!(recorded.iter().any(|it| json_of(it)["command"] == "open"), "{recorded:#?}");
    let replay = async || {
        for text in &recorded {
            broker.publish("lafet/M1/command", text, &[]).await;
        }
    };
    replay().await;
    assert!(stays(Duration::from_millis(500), || opening(&site) < 0.01).await, "in its session");
    drop(site);
    broker.until_retained("lafet/hub", |it| json_of(it)["online"] == false).await;
    let again = site_with(1, &table(broker.address, OPERATOR)).await;
    broker.until_retained("lafet/hub", |it| json_of(it)["online"] == true).await;
    replay().await;
    assert!(stays(Duration::from_millis(500), || opening(&again) < 0.01).await, "in the next one");
    until_plug(&again, "it has heard them", |it| it["requests"].as_u64() >= Some(9)).await;
    let noted = again.get("", "/api/audit?text=open%20valve1&limit=1000").await.body;
    let outcomes = noted["entries"].as_array().unwrap().iter().map(|it| &it["outcome"]);
    assert_eq!(outcomes.collect::<Vec<_>>(), [&json!("not allowed")], "{noted:#}");
}

#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn observers_stop_close_and_lock_out_and_no_more() {
    let (site, broker) = open(2, "").await;
    let listener = broker.listen("lafet/#").await;
    listener.until("a ticket", |it| it.starts_with("lafet/ticket ")).await;
    let ticket = json_of(&listener.of("lafet/ticket").pop().unwrap())["ticket"].clone();
    let take = json!({ "id": "o1", "command": "take", "ticket": ticket }).to_string();
    broker.publish("lafet/M1/command", &take, &[]).await;
    assert_eq!(listener.result("lafet/M1", "o1").await["refusal"], 6);
    let mut console = site.ws("").await;
    console.authority("M1", "take").await;
    let turn = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 9000" });
    console.ask(turn).await;
    until("it moves", || moving(&site)).await;
    broker.publish("lafet/command", r#"{"id":"o2","command":"stop"}"#, &[]).await;
    until("it stops", || !moving(&site)).await;
    assert_eq!(listener.result("lafet", "o2").await["ok"], true);
    broker.publish("lafet/M2/command", r#"{"id":"o3","command":"lockout"}"#, &[]).await;
    assert_eq!(listener.result("lafet/M2", "o3").await["ok"], true);
    broker.until_retained("lafet/M2/state", |it| json_of(it)["locked_out"] == true).await;
    broker.publish("lafet/M1/command", "nonsense", &[]).await;
    let unreadable = |it: &str| it.starts_with("lafet/M1/result ") && it.contains("\"id\":null");
    assert!(listener.until("a result", unreadable).await.contains("\"refusal\":25"));
}

/// A monitor is removed from hub.toml: the broker keeps nothing of it, and its Stop has a result.
#[tokio::test]
#[ignore = "needs mosquitto"]
async fn what_is_kept_of_a_monitor_that_has_gone_is_cleared() {
    let (first, broker) = open(2, "homeassistant = \"homeassistant\"").await;
    let of_second = ["state", "available", "key"].map(|part| format!("lafet/M2/{part}"));
    let discovered = "homeassistant/device/lafet_M2/config".to_owned();
    for topic in of_second.iter().chain([&discovered]) {
        broker.until_retained(topic, |_| true).await;
    }
    // What another device keeps there is none of the hub's business.
    broker.publish("lafet/pump/available", "online", &["-r"]).await;
    broker.publish("lafet/pump/key", "red", &["-r"]).await;
    drop(first);
    broker.until_retained("lafet/hub", |it| json_of(it)["online"] == false).await;
    let text = table(broker.address, "homeassistant = \"homeassistant\"");
    let site = site_with(1, &text).await;
    until_plug(&site, "it is connected", |it| it["error"].is_null()).await;
    let began = Instant::now();
    for topic in of_second.iter().chain([&discovered]) {
        while !broker.retained(topic).await.is_empty() {
            assert!(began.elapsed() < crate::support::PATIENCE, "{topic}");
        }
    }
    for topic in ["lafet/M1/key", "lafet/M1/state", "lafet/pump/available", "lafet/pump/key"] {
        broker.until_retained(topic, |_| true).await;
    }
    let listener = broker.listen("lafet/#").await;
    for command in ["stop", "take"] {
        let text = json!({ "id": command, "command": command }).to_string();
        broker.publish("lafet/M2/command", &text, &[]).await;
        let result = listener.result("lafet/M2", command).await;
        assert_eq!((&result["ok"], &result["refusal"]), (&json!(false), &json!(2)));
        assert!(result["text"]["ru"].is_string(), "{result:#}");
    }
    let text = json!({ "id": "here", "command": "stop" }).to_string();
    broker.publish("lafet/M1/command", &text, &[]).await;
    assert_eq!(listener.result("lafet/M1", "here").await["ok"], true);
}

#[tokio::test]
#[ignore = "needs mosquitto, voluptuous and Jinja"]
async fn home_assistant_finds_values_and_two_buttons() {
    let (site, broker) = open(1, "homeassistant = \"homeassistant\"").await;
    let config = broker.until_retained("homeassistant/device/lafet_M1/config", |_| true).await;
    let good = |it: &str| json_of(it)["quality"] == "good";
    let state = broker.until_retained("lafet/M1/state", good).await;
    site.bus.silence(1);
    let stale = |it: &str| json_of(it)["quality"] == "stale";
    let stale = broker.until_retained("lafet/M1/state", stale).await;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/mqtt/homeassistant.py");
    let mut command = Command::new("python3");
    command.arg(script);
    let mut program = Running::start(command);
    for line in [&config, &state, &stale] {
        program.tell(line);
    }
    program.close();
    program.until("it is checked", |it| it == "hub offline").await;
    let lines = program.lines();
    for line in [
        "component stop button",
        "component close button",
        "component connection binary_sensor",
        "value good traverse 0.0",
        "value good mode by_hand",
        "value good fire OFF",
        "value good water OFF",
        "value stale traverse None",
        "value stale pressure None",
        "value stale mode None",
        "value stale fire None",
        "value stale water ON",
        "hub online",
    ] {
        assert!(lines.iter().any(|it| it == line), "{line}: {lines:#?}");
    }
    assert_eq!(lines.iter().filter(|it| it.ends_with("button")).count(), 2, "{lines:#?}");
}

/// A certificate authority, and a certificate of the broker's for a name.
fn certificates(folder: &std::path::Path, name: &str) {
    use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair};
    let mut authority = CertificateParams::new(Vec::new()).unwrap();
    authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let key = KeyPair::generate().unwrap();
    std::fs::write(folder.join("ca.pem"), authority.self_signed(&key).unwrap().pem()).unwrap();
    let issuer = Issuer::new(authority, key);
    let own = KeyPair::generate().unwrap();
    let server = CertificateParams::new(vec![name.to_owned()]).unwrap();
    let server = server.signed_by(&own, &issuer).unwrap();
    std::fs::write(folder.join("server.pem"), server.pem()).unwrap();
    std::fs::write(folder.join("server.key"), own.serialize_pem()).unwrap();
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn a_broker_with_a_wrong_certificate_is_refused_in_words() {
    let make = |name: &'static str| {
        move |folder: &std::path::Path| {
            certificates(folder, name);
            let path = |file: &str| folder.join(file).display().to_string();
            format!(
                "certfile {}\nkeyfile {}\nallow_anonymous true\n",
                path("server.pem"),
                path("server.key")
            )
        }
    };
    let broker = Broker::with(super::free(), make("localhost")).await;
    let other = Broker::with(super::free(), make("broker.site")).await;
    let port = |broker: &Broker| broker.address.port();
    let table = |port: u16, ca: String| {
        format!("[[mqtt]]\nname = \"site\"\nurl = \"mqtts://localhost:{port}\"\nca = \"{ca}\"\n")
    };
    for (port, ca, said) in [
        (port(&broker), broker.file("ca.pem"), None),
        (port(&broker), other.file("ca.pem"), Some("authority that is not trusted")),
        (port(&other), other.file("ca.pem"), Some("is not for localhost")),
    ] {
        let site = site_with(1, &table(port, ca)).await;
        match said {
            None => until_plug(&site, "it is connected", |it| it["error"].is_null()).await,
            Some(said) => until_plug(&site, said, |it| says(it, said)).await,
        }
    }
}

#[tokio::test]
#[ignore = "needs mosquitto"]
async fn a_wrong_password_is_reported_in_words() {
    let make = |folder: &std::path::Path| {
        let file = folder.join("passwords");
        let mut command = Command::new("mosquitto_passwd");
        command.args(["-b", "-c"]).arg(&file).args(["hub", "right"]);
        assert!(command.stderr(Stdio::null()).status().unwrap().success());
        std::fs::write(folder.join("password"), "right\n").unwrap();
        format!("password_file {}\n", file.display())
    };
    let broker = Broker::with(super::free(), make).await;
    let file = broker.file("password");
    let right = format!("user = \"hub\"\npassword_file = \"{file}\"");
    for (login, said) in [
        (right.as_str(), None),
        ("user = \"hub\"\npassword = \"wrong\"", Some("refuses this user and password")),
        ("", Some("refuses this user and password")),
    ] {
        let site = site_with(1, &table(broker.address, login)).await;
        match said {
            None => until_plug(&site, "it is connected", |it| it["error"].is_null()).await,
            Some(said) => until_plug(&site, said, |it| says(it, said)).await,
        }
    }
}

/// The example of docs/mqtt.md, as it is printed there.
#[tokio::test]
#[ignore = "needs mosquitto and paho-mqtt"]
async fn the_example_of_the_documentation_runs() {
    let (site, broker) = open(1, "role = \"operator\"").await;
    let docs = include_str!("../../../../../../../docs/mqtt.md");
    let (_, rest) = docs.split_once("```python\n").expect("an example");
    let (example, _) = rest.split_once("```").expect("its end");
    let russian = include_str!("../../../../../../../docs/mqtt.ru.md");
    assert!(russian.contains("import paho.mqtt.client as mqtt"));
    let mut command = Command::new("python3");
    let port = broker.address.port().to_string();
    command.args(["-c", example, "127.0.0.1", &port]);
    let program = Running::start(command);
    program.until("it is done", |it| it.contains("'command': 'release'")).await;
    let lines = program.lines();
    assert!(lines.iter().all(|it| it.contains("'ok': True")), "{lines:#?}");
    until("it gets there", || (site.bus.position(0, HORIZONTAL) - 600.0).abs() < 30.0).await;
}
