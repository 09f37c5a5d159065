//! Detectors, contacts, outputs and pumps on Modbus, end to end: a server that is not ours, and servers that answer anything else.

#[cfg(target_os = "linux")]
mod foreign;
mod outputs;
mod panel;

use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::support::{Site, stays, until};
use lafet_device::composition::Composition;
use lafet_hub::{Clock, Config, ManualTime, Overrides};
use lafet_proto::SubsystemId;
use panel::{Bad, Panel};
use rmodbus::server::context::ModbusContext;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep};

/// The configuration of one zone with a monitor.
fn config(buses: &[(&str, String)], sources: &[String], votes: &str, keys: &str) -> Config {
    let text = text(buses, sources, votes, keys);
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    read.unwrap_or_else(|problems| panic!("{problems:#?}"))
}

/// The same as `hub.toml` has it.
fn text(buses: &[(&str, String)], sources: &[String], votes: &str, keys: &str) -> String {
    let mut text = String::from(
        "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n\
         [[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n",
    );
    text += &format!(
        "[[zone]]\nid = \"hall\"\nvotes = \"{votes}\"\nwater_max_s = 600\nmonitors = [\"M1\"]\n{keys}\n"
    );
    for (name, url) in buses {
        text += &format!(
            "[[modbus]]\nname = \"{name}\"\nurl = \"{url}\"\npoll_ms = 100\ntimeout_ms = 200\nsettle_s = 0\n"
        );
    }
    for (number, source) in (1..).zip(sources) {
        let id = format!("F{number}");
        text += &format!(
            "[[detector]]\nid = \"{id}\"\nkind = \"flame\"\nzones = [\"hall\"]\nsource = {{ {source} }}\n"
        );
    }
    text
}

async fn site_of(read: Config, clock: Clock) -> Site {
    Site::of((1, Composition::REMOTE), clock, |config| {
        (config.login, config.zones, config.modbus) = (false, read.zones, read.modbus);
    })
    .await
}

/// Two detectors on discrete inputs 0 and 1 of a panel, each with a contact that opens at a fault.
fn two() -> [String; 2] {
    [0, 1].map(|bit| {
        let (unit, fault) = (bit + 1, bit + 10);
        format!(
            "modbus = \"panel\", unit = {unit}, alarm = \"discrete:{bit}\", fault = \"!discrete:{fault}\""
        )
    })
}

/// A site whose two detectors are read from a server that listens; they see nothing.
async fn quiet(keys: &str) -> (Site, Panel) {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", keys);
    let site = site_of(config, Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    (site, panel)
}

fn well(panel: &Panel) {
    for bit in [10, 11] {
        panel.set(bit, true);
    }
}

fn fire(panel: &Panel, bits: &[u16], on: bool) {
    for bit in bits {
        panel.set(*bit, on);
    }
}

async fn zone(site: &Site) -> Value {
    site.get("", "/api/zones").await.body["state"]["zones"][0].clone()
}

async fn until_zone(site: &Site, what: &str, wanted: impl Fn(&Value) -> bool) {
    let began = Instant::now();
    loop {
        let zone = zone(site).await;
        if wanted(&zone) {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(30), "{what}: {zone:#}");
        sleep(Duration::from_millis(20)).await;
    }
}

/// What was reported last of a detector.
async fn reported(site: &Site, id: &str) -> Value {
    site.get("", "/api/zones").await.body["reported"][id].clone()
}

async fn until_reported(site: &Site, id: &str, signal: &str, condition: &str) {
    let began = Instant::now();
    loop {
        let last = reported(site, id).await;
        if last["signal"] == signal && last["condition"] == condition {
            return;
        }
        assert!(
            began.elapsed() < Duration::from_secs(30),
            "{id} {signal} {condition}: {last:#} {:#}",
            buses(site).await
        );
        sleep(Duration::from_millis(20)).await;
    }
}

async fn buses(site: &Site) -> Value {
    site.get("", "/api/modbus").await.body["buses"].clone()
}

fn is_set(site: &Site, flag: &str) -> bool {
    site.hub.station("M1").unwrap().status().is_set(SubsystemId::VALVE1, flag)
}

fn is_open(site: &Site) -> bool {
    is_set(site, "Open")
}

fn is_closed(site: &Site) -> bool {
    is_set(site, "Closed")
}

async fn events(site: &Site) -> String {
    site.get("", "/api/events").await.body.to_string()
}

#[tokio::test]
async fn two_detectors_on_a_panel_release_water_and_one_does_not() {
    let (site, panel) = quiet("coincidence_s = 1").await;
    fire(&panel, &[0], true);
    until_reported(&site, "F1", "alarm", "ready").await;
    assert_eq!(reported(&site, "F1").await["by"], "modbus panel unit 1");
    assert!(stays(Duration::from_millis(1500), || is_closed(&site)).await, "one vote of two");
    assert_eq!(zone(&site).await["phase"], "alarm");
    fire(&panel, &[1], true);
    until("the valve opens", || is_open(&site)).await;
    let bus = buses(&site).await[0].clone();
    assert_eq!((&bus["name"], &bus["connected"]), (&json!("panel"), &json!(true)), "{bus:#}");
    assert!(bus["answers"].as_u64() > Some(10) && bus["answered_ms_ago"].is_u64(), "{bus:#}");
    assert_eq!(bus["detectors"][1]["reading"], "good", "{bus:#}");
    let events = events(&site).await;
    for text in ["Detector F1: alarm (modbus panel unit 1).", "Modbus panel: the line is open."] {
        assert!(events.contains(text), "{text}: {events}");
    }
    // What a device says of a detector no other client says.
    let other = site.post("", "/api/detectors/F1", json!({ "signal": "quiet" })).await;
    assert_eq!((other.status, other.code()), (409, "detector_on_bus"), "{other:?}");
}

#[tokio::test]
async fn a_fault_contact_takes_the_vote_and_so_does_an_address_that_is_not_there() {
    let (site, panel) = quiet("coincidence_s = 0").await;
    fire(&panel, &[11], false);
    until_reported(&site, "F2", "quiet", "fault").await;
    fire(&panel, &[0, 1], true);
    until_reported(&site, "F2", "alarm", "fault").await;
    assert!(stays(Duration::from_secs(1), || is_closed(&site)).await);
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let [first, _] = two();
    let beyond = first.replace("discrete:0", "discrete:60000").replace("unit = 1", "unit = 2");
    let sources = [first, beyond];
    let config = config(&[("panel", format!("tcp://{address}"))], &sources, "2oo2", "");
    let site = site_of(config, Clock::System).await;
    until_reported(&site, "F1", "quiet", "ready").await;
    assert_eq!(reported(&site, "F2").await, Value::Null, "nothing was read of it");
    let bus = buses(&site).await[0].clone();
    assert!(bus["errors"]["exception"].as_u64() > Some(0), "{bus:#}");
    let what = bus["last_error"]["what"].clone();
    assert!(what["en"].as_str().unwrap().contains("Exception 2"), "{bus:#}");
    assert!(what["ru"].as_str().unwrap().contains("Исключение 2"), "{bus:#}");
}

/// A fire burns through the line while the delay runs: the vote is over, the alarm is shown.
#[tokio::test]
async fn a_detector_that_falls_silent_in_the_countdown_does_not_release() {
    let (site, panel) = quiet("coincidence_s = 0\ndelay_s = 4").await;
    fire(&panel, &[0, 1], true);
    until_zone(&site, "the countdown", |zone| zone["phase"] == "countdown").await;
    panel.answers.store(false, Ordering::SeqCst);
    until_reported(&site, "F1", "alarm", "fault").await;
    until_reported(&site, "F2", "alarm", "fault").await;
    assert!(stays(Duration::from_secs(5), || is_closed(&site)).await, "{:#}", zone(&site).await);
    assert!(zone(&site).await["phase"] != "countdown");
    assert!(events(&site).await.contains("F1 (modbus panel unit 1): no valid answer"));
    panel.answers.store(true, Ordering::SeqCst);
    until("votes that are there again release", || is_open(&site)).await;
}

#[tokio::test]
async fn whatever_a_server_answers_wrongly_is_no_signal_and_no_vote() {
    let mut servers = Vec::new();
    for (number, (bad, _)) in Bad::ALL.into_iter().enumerate() {
        servers.push((format!("bus{number}"), format!("tcp://{}", bad.listen().await)));
    }
    let lines: Vec<(&str, String)> =
        servers.iter().map(|(name, url)| (name.as_str(), url.clone())).collect();
    let sources: Vec<String> = servers
        .iter()
        .map(|(name, _)| format!("modbus = \"{name}\", unit = 1, alarm = \"discrete:0\""))
        .collect();
    let votes = format!("2oo{}", sources.len());
    let site = site_of(config(&lines, &sources, &votes, "coincidence_s = 0"), Clock::System).await;
    assert!(stays(Duration::from_secs(4), || is_closed(&site)).await);
    let body = site.get("", "/api/zones").await.body;
    assert_eq!(body["reported"], json!({}), "none was heard");
    assert_eq!(body["state"]["zones"][0]["phase"], "quiet");
    for (bus, (bad, kind)) in buses(&site).await.as_array().unwrap().iter().zip(Bad::ALL) {
        assert!(bus["errors"][kind].as_u64() > Some(0), "{bad:?} {kind}: {bus:#}");
        assert_eq!(bus["answers"], 0, "{bad:?}: {bus:#}");
        assert_eq!(bus["detectors"][0]["reading"], "waiting", "{bad:?}: {bus:#}");
        // A server that fails at once is not asked without end.
        assert!(bus["requests"].as_u64() < Some(60), "{bad:?}: {bus:#}");
    }
}

/// Nothing listens at first; then a panel does.
#[tokio::test]
async fn a_refused_line_is_tried_again_ever_more_seldom() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address: SocketAddr = listener.local_addr().unwrap();
    drop(listener);
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", "");
    let site = site_of(config, Clock::System).await;
    sleep(Duration::from_secs(3)).await;
    let bus = buses(&site).await[0].clone();
    let tried = bus["errors"]["open"].as_u64().unwrap();
    assert!((2..=6).contains(&tried) && bus["connected"] == false, "{bus:#}");
    assert!(bus["last_error"]["what"]["ru"].as_str().unwrap().contains("отказано"), "{bus:#}");
    let panel = Panel::new();
    well(&panel);
    let listener = TcpListener::bind(address).await.unwrap();
    let own = panel.clone();
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        own.serve(stream, rmodbus::ModbusProto::TcpUdp).await;
    });
    until_zone(&site, "it is read", |zone| zone["ready"] == true).await;
}

/// A device behind a gateway that does not answer costs neither the connection nor the others' time.
#[tokio::test]
async fn one_device_that_is_gone_leaves_the_others_as_they_are() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let [first, second] = two();
    let gone = second.replace("unit = 2", "unit = 99");
    let sources = [first, second, gone];
    let config = config(
        &[("panel", format!("tcp://{address}"))],
        &sources,
        "2oo3",
        "coincidence_s = 0\nwhen_failed = [\"2oo2\"]",
    );
    let site = site_of(config, Clock::System).await;
    until_reported(&site, "F1", "quiet", "ready").await;
    until_reported(&site, "F2", "quiet", "ready").await;
    let good = async || {
        let bus = buses(&site).await[0].clone();
        bus["detectors"][0]["reading"] == "good" && bus["detectors"][1]["reading"] == "good"
    };
    sleep(Duration::from_secs(3)).await;
    for _ in 0..50 {
        assert!(good().await, "{:#}", buses(&site).await);
        sleep(Duration::from_millis(40)).await;
    }
    let bus = buses(&site).await[0].clone();
    assert!((3..=9).contains(&bus["errors"]["timeout"].as_u64().unwrap()), "{bus:#}");
    assert_eq!(panel.connections.load(Ordering::SeqCst), 1, "{bus:#}");
    fire(&panel, &[0, 1], true);
    until("two of the two that are left release", || is_open(&site)).await;
}

#[tokio::test]
async fn a_heartbeat_that_stands_still_is_a_fault() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let sources = two().map(|it| format!("{it}, heartbeat = \"holding:9.0\", heartbeat_s = 2"));
    let config =
        config(&[("panel", format!("tcp://{address}"))], &sources, "2oo2", "coincidence_s = 0");
    let site = site_of(config, Clock::System).await;
    until_reported(&site, "F1", "quiet", "starting").await;
    let beat = tokio::spawn({
        let panel = panel.clone();
        async move {
            for value in (0..u16::MAX).cycle() {
                panel.memory().set_holding(9, value).unwrap();
                sleep(Duration::from_millis(500)).await;
            }
        }
    });
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    beat.abort();
    until_reported(&site, "F1", "quiet", "fault").await;
    assert_eq!(buses(&site).await[0]["detectors"][0]["reading"], "frozen");
    fire(&panel, &[0, 1], true);
    until_reported(&site, "F2", "alarm", "fault").await;
    assert!(stays(Duration::from_secs(1), || is_closed(&site)).await);
}

/// Abort and release by contacts: pressed, open again, and on a line that is lost.
#[tokio::test]
async fn contacts_on_a_panel_stop_and_release() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let mut buses_text = String::new();
    for (id, keys, bit) in [
        ("abort", "kind = \"abort\"", 20),
        ("station", "kind = \"release\"\ndebounce_ms = 300", 21),
    ] {
        buses_text += &format!(
            "[[input]]\nid = \"{id}\"\nzones = [\"hall\"]\n{keys}\n\
             source = {{ modbus = \"panel\", unit = 1, on = \"discrete:{bit}\", fault = \"discrete:{}\" }}\n",
            bit + 10
        );
    }
    let keys = format!("coincidence_s = 0\n{buses_text}");
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", &keys);
    let site = site_of(config, Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    assert_eq!(buses(&site).await[0]["inputs"][1]["id"], "station");
    // At fault, and pressed all the same.
    fire(&panel, &[20, 30], true);
    sleep(Duration::from_millis(600)).await;
    fire(&panel, &[0, 1], true);
    until_reported(&site, "F2", "alarm", "ready").await;
    assert!(stays(Duration::from_secs(1), || is_closed(&site)).await, "abort is pressed");
    // Open again, and pressed for a release; a line at fault between is no press.
    fire(&panel, &[0, 1, 20, 30], false);
    until_reported(&site, "F2", "quiet", "ready").await;
    sleep(Duration::from_secs(3)).await;
    fire(&panel, &[31], true);
    sleep(Duration::from_millis(400)).await;
    let troubles = site.get("", "/api/zones").await.body["state"]["troubles"].to_string();
    assert!(troubles.contains("station"), "{troubles}");
    fire(&panel, &[21], true);
    sleep(Duration::from_millis(400)).await;
    fire(&panel, &[31], false);
    assert!(stays(Duration::from_secs(1), || is_closed(&site)).await, "its press was not seen");
    fire(&panel, &[21], false);
    sleep(Duration::from_millis(800)).await;
    fire(&panel, &[21], true);
    until("the station releases", || is_open(&site)).await;
    panel.answers.store(false, Ordering::SeqCst);
    until_reported(&site, "F1", "quiet", "fault").await;
    let troubles = site.get("", "/api/zones").await.body["state"]["troubles"].to_string();
    assert!(troubles.contains("abort"), "{troubles}");
    assert!(stays(Duration::from_millis(500), || is_open(&site)).await, "water by hand goes on");
}

/// A contact that bounces faster than it is read never coincides for the time that it has to.
#[tokio::test]
async fn alarms_that_flap_release_nothing() {
    let (site, panel) = quiet("coincidence_s = 2").await;
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(6) {
        let on = began.elapsed().as_millis() % 400 < 200;
        fire(&panel, &[0, 1], on);
        assert!(is_closed(&site));
        sleep(Duration::from_millis(7)).await;
    }
    fire(&panel, &[0, 1], true);
    until("what stays releases", || is_open(&site)).await;
}

#[tokio::test]
async fn a_clock_that_is_set_changes_no_age() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", "");
    let time = ManualTime::at(1_700_000_000_000);
    let site = site_of(config, Clock::Manual(time.clone())).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    for date in [1_900_000_000_000, 1_000_000_000] {
        time.set_date(date);
        for _ in 0..20 {
            assert_eq!(zone(&site).await["ready"], true);
            let bus = buses(&site).await[0].clone();
            assert!(bus["answered_ms_ago"].as_u64() < Some(2000), "{bus:#}");
            sleep(Duration::from_millis(50)).await;
        }
    }
}

/// Serial frames over a pseudo-terminal, and over TCP as serial servers send them.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn detectors_on_a_serial_line_and_behind_a_serial_server() {
    use rmodbus::ModbusProto;

    let (panel, second) = (Panel::new(), Panel::new());
    well(&panel);
    well(&second);
    let (ours, path, _theirs) = pty();
    tokio::spawn(panel.clone().serve(ours, ModbusProto::Rtu));
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let own = second.clone();
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        own.serve(stream, ModbusProto::Rtu).await;
    });
    let [first, other] = two();
    let sources = [first, other.replace("panel", "server")];
    let lines = [
        ("panel", format!("serial://{path}?baud=115200&parity=none")),
        ("server", format!("rtu+tcp://{address}")),
    ];
    let site = site_of(config(&lines, &sources, "2oo2", "coincidence_s = 0"), Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    fire(&panel, &[0], true);
    until_reported(&site, "F1", "alarm", "ready").await;
    fire(&second, &[1], true);
    until("both are heard", || is_open(&site)).await;
    fire(&panel, &[0], false);
    panel.answers.store(false, Ordering::SeqCst);
    until_reported(&site, "F1", "alarm", "fault").await;
    panel.answers.store(true, Ordering::SeqCst);
    until_reported(&site, "F1", "quiet", "ready").await;
    let buses = buses(&site).await;
    for bus in buses.as_array().unwrap() {
        assert_eq!(
            (&bus["errors"]["wrong"], &bus["errors"]["garbage"]),
            (&json!(0), &json!(0)),
            "{bus:#}"
        );
    }
}

/// A pseudo-terminal: one end as a stream, the path of the other, and what keeps it open.
#[cfg(target_os = "linux")]
pub fn pty() -> (
    tokio::io::Join<tokio::net::unix::pipe::Receiver, tokio::net::unix::pipe::Sender>,
    String,
    std::os::fd::OwnedFd,
) {
    use rustix::fs::{Mode, OFlags};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use tokio::net::unix::pipe::{Receiver, Sender};

    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let name = ptsname(&ours, Vec::new()).unwrap();
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let theirs = rustix::fs::open(name.as_c_str(), flags, Mode::empty()).unwrap();
    let mut settings = rustix::termios::tcgetattr(&theirs).unwrap();
    settings.make_raw();
    rustix::termios::tcsetattr(&theirs, rustix::termios::OptionalActions::Now, &settings).unwrap();
    let status = rustix::fs::fcntl_getfl(&ours).unwrap();
    rustix::fs::fcntl_setfl(&ours, status | OFlags::NONBLOCK).unwrap();
    let writer = Sender::from_owned_fd_unchecked(ours.try_clone().unwrap()).unwrap();
    let reader = Receiver::from_owned_fd_unchecked(ours).unwrap();
    (tokio::io::join(reader, writer), name.into_string().unwrap(), theirs)
}

/// The example of the documents, with the rest of the file that it belongs to, passes `--check`.
#[test]
fn the_example_of_the_document_is_right() {
    let documents = [
        include_str!("../../../../../docs/installation.md"),
        include_str!("../../../../../docs/installation.ru.md"),
    ];
    let [english, russian] = documents.map(|text| -> Vec<String> {
        let blocks = text.split("```toml\n").skip(1).take(3);
        blocks.map(|it| it.split("```").next().expect("an end").to_owned()).collect()
    });
    assert_eq!(english, russian);
    let taken = |it: &&str| !(it.contains("\"flame-north\"\n") || it.contains("\"heat\"\n"));
    let rest: Vec<&str> = english[0].split("\n\n").filter(taken).collect();
    let text = format!("{}\n\n{}\n{}", rest.join("\n\n"), english[1], english[2]);
    let text = text.replace("[[zone]]\n", "[[zone]]\nvalve = \"hall-valve\"\n");
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let config = read.unwrap_or_else(|problems| panic!("{problems:#?}"));
    let sources: Vec<usize> = config.modbus.iter().map(|bus| bus.sources.len()).collect();
    assert_eq!(config.modbus[0].outputs.len(), 3);
    assert_eq!((sources, config.zones.unwrap().site.detectors.len()), (vec![2, 1], 3));
}
