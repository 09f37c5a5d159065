//! Outputs and pumps on Modbus: what a server that is not ours has in its memory, and what came to it.

use std::sync::atomic::{AtomicBool, Ordering};

use lafet_proto::RequestId;
use lafet_proto::record::Records;

use super::panel::Mischief;
use super::*;

const SOON: Duration = Duration::from_millis(100);
const VALVE: u16 = 3;
const PUMP: u16 = 5;
const HORN: u16 = 6;
const LAMP: u16 = 7;
const BEAT: u16 = 15;

/// A zone with a valve, a sounder, a lamp and a pump on the panel of its detectors.
fn tables() -> String {
    let target = |set: u16, more: &str| {
        format!("target = {{ modbus = \"panel\", unit = 1, set = \"coil:{set}\"{more} }}\n")
    };
    let output = |id: &str, kind: &str, set: u16, more: &str| {
        format!("[[output]]\nid = \"{id}\"\nkind = \"{kind}\"\n{}", target(set, more))
    };
    [
        "coincidence_s = 0\nvalve = \"V\"\n".to_owned(),
        output("V", "valve", VALVE, ", on = \"discrete:40\""),
        output("horn", "sounder", HORN, ""),
        output("lamp", "trouble_lamp", LAMP, ""),
        "[[input]]\nid = \"gauge\"\nkind = \"pressure\"\n".to_owned(),
        "source = { modbus = \"panel\", unit = 1, on = \"discrete:41\" }\n".to_owned(),
        "[[pump]]\nid = \"P\"\npressure = \"gauge\"\n".to_owned(),
        target(PUMP, ""),
    ]
    .concat()
}

/// A hub with these tables, whose detectors are quiet, and the panel, whose valve and pump work.
async fn plant(keys: &str) -> (Site, Panel) {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    let keys = format!("{}{keys}", tables());
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", &keys);
    works(&panel);
    let site = site_of(config, Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    (site, panel)
}

/// The valve follows its coil, and the pump gives pressure.
fn works(panel: &Panel) {
    let own = panel.clone();
    tokio::spawn(async move {
        loop {
            for (coil, contact) in [(VALVE, 40), (PUMP, 41)] {
                let on = own.coil(coil);
                own.memory().set_discrete(contact, on).unwrap();
            }
            sleep(Duration::from_millis(20)).await;
        }
    });
}

async fn shown(site: &Site, id: &str) -> Value {
    let bus = buses(site).await[0].clone();
    let all = bus["outputs"].as_array().unwrap();
    all.iter().find(|it| it["id"] == id).unwrap_or_else(|| panic!("{bus:#}")).clone()
}

async fn until_shown(site: &Site, id: &str, what: &str, wanted: impl Fn(&Value) -> bool) {
    let began = Instant::now();
    loop {
        let it = shown(site, id).await;
        if wanted(&it) {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(20), "{id} {what}: {it:#}");
        sleep(Duration::from_millis(20)).await;
    }
}

async fn abort(site: &Site) {
    assert_eq!(site.post("", "/api/zones/hall/abort", json!({})).await.status, 200);
}

async fn troubles(site: &Site) -> String {
    site.get("", "/api/zones").await.body["state"]["troubles"].to_string()
}

/// What was written after a moment: values only.
fn since(panel: &Panel, address: u16, from: Instant) -> Vec<u16> {
    panel.written(address).into_iter().filter(|(at, _)| *at >= from).map(|it| it.1).collect()
}

#[tokio::test]
async fn votes_open_the_valve_and_start_the_pump_and_an_abort_closes_them() {
    let (site, panel) = plant("").await;
    assert!(panel.written(VALVE).is_empty() && panel.written(PUMP).is_empty(), "a start is inert");
    fire(&panel, &[0, 1], true);
    until("all is on", || panel.coil(VALVE) && panel.coil(PUMP) && panel.coil(HORN)).await;
    until("the monitor opens", || is_open(&site)).await;
    for id in ["V", "P"] {
        until_shown(&site, id, "is on", |it| {
            let on = json!(true);
            [&it["wanted"], &it["written"], &it["read_back"]] == [&on; 3] && it["trouble"].is_null()
        })
        .await;
    }
    assert_eq!(shown(&site, "V").await["feedback"], true);
    let state = site.get("", "/api/zones").await.body["state"].clone();
    assert_eq!(state["outputs"][0], json!({ "output": "V", "on": true, "reported": true }));
    assert_eq!(state["pumps"][0]["pressure"], true, "{state:#}");
    // Confirmed: not written again.
    let now = Instant::now();
    sleep(Duration::from_millis(1500)).await;
    assert!(since(&panel, VALVE, now).is_empty() && since(&panel, PUMP, now).is_empty());
    abort(&site).await;
    until("all is off", || !panel.coil(VALVE) && !panel.coil(PUMP)).await;
    assert!(panel.coil(HORN), "the detectors still see it");
    until_shown(&site, "V", "is off", |it| it["feedback"] == false).await;
    assert!(!troubles(&site).await.contains("overdue"), "{}", troubles(&site).await);
}

/// A pump runs by hand without water and stays off by hand with it; a reset gives it back.
#[tokio::test]
async fn a_pump_is_run_by_hand_until_a_reset() {
    let (site, panel) = plant("").await;
    let hand = async |on: bool| site.post("", "/api/pumps/P", json!({ "on": on })).await;
    let state = async || site.get("", "/api/zones").await.body["state"].clone();
    let reset = async || site.post("", "/api/zones/reset", json!({})).await.status;
    assert_eq!(site.post("", "/api/pumps/Q", json!({ "on": true })).await.status, 404);
    assert_eq!(hand(true).await.status, 200);
    until("it runs", || panel.coil(PUMP)).await;
    assert_eq!(state().await["pumps"][0]["hand"], true);
    assert!(!panel.coil(VALVE), "no water comes of it");
    assert_eq!(hand(false).await.status, 200);
    until("it stops", || !panel.coil(PUMP)).await;
    let now = state().await;
    assert_eq!(now["disablements"], json!([{ "pump": { "pump": "P" } }]), "{now:#}");
    fire(&panel, &[0, 1], true);
    until("water is on", || panel.coil(VALVE)).await;
    sleep(Duration::from_millis(500)).await;
    assert!(!panel.coil(PUMP), "a hand has stopped it");
    assert_eq!(reset().await, 409, "not while water is on");
    assert_eq!(hand(true).await.status, 200);
    until("it runs for the water", || panel.coil(PUMP)).await;
    fire(&panel, &[0, 1], false);
    abort(&site).await;
    until("water is off", || !panel.coil(VALVE)).await;
    // Not at the same time as the abort any more.
    sleep(Duration::from_millis(2100)).await;
    assert!(panel.coil(PUMP), "a hand has started it");
    assert_eq!(reset().await, 200);
    until("it stops with the reset", || !panel.coil(PUMP)).await;
    let now = state().await;
    assert_eq!((&now["pumps"][0]["hand"], &now["disablements"]), (&json!(null), &json!([])));
    let locked = site.post("", "/api/zones/lock", json!({})).await.status;
    assert_eq!((locked, hand(true).await.code()), (200, "zone_refused"));
}

/// Two monitors, three detectors, a valve, a pump: the best of some tries, as the machine of the tests has
/// other work too.
#[tokio::test]
async fn an_abort_closes_everything_on_the_wire_within_100_ms() {
    let (panel, address) = Panel::listen().await;
    [10, 11, 12].into_iter().for_each(|bit| panel.memory().set_discrete(bit, true).unwrap());
    works(&panel);
    let mut sources: Vec<String> = two().into();
    sources.push(sources[0].replace("discrete:0", "discrete:2").replace(":10", ":12"));
    let url = format!("tcp://{address}");
    let text = text(&[("panel", url)], &sources, "2oo3", &tables());
    let second = "[[monitor]]\nid = \"M2\"\nurl = \"tcp://h?addr=2\"\n[[aim]]\nzone = \"hall\"\n\
                  monitor = \"M2\"\nhorizontal = -600\nvertical = 300\nnozzle = 60\n";
    let text = format!("{second}{}", text.replace("[\"M1\"]", "[\"M1\", \"M2\"]"));
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let read = read.unwrap_or_else(|problems| panic!("{problems:#?}"));
    let site = Site::of((2, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.zones, config.modbus) = (false, read.zones, read.modbus);
    })
    .await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    let open =
        |id: &str| site.hub.station(id).unwrap().status().is_set(SubsystemId::VALVE1, "Open");
    let mut best = Duration::MAX;
    for _ in 0..5 {
        fire(&panel, &[0, 2], true);
        until("all is open", || panel.coil(VALVE) && panel.coil(PUMP)).await;
        until("the monitors open", || open("M1") && open("M2")).await;
        let mut frames =
            ["M1", "M2"].map(|id| site.hub.station(id).unwrap().client().unwrap().trace());
        let began = Instant::now();
        abort(&site).await;
        let mut last = began;
        for (number, frames) in (1..).zip(&mut frames) {
            loop {
                let Ok(frame) = frames.recv().await else { continue };
                let mut records = Records::new(&frame.payload).map_while(Result::ok);
                if frame.dst == number && records.any(|it| it.request == RequestId::CLOSE) {
                    last = last.max(Instant::now());
                    break;
                }
            }
        }
        for coil in [VALVE, PUMP] {
            until("it was written", || since(&panel, coil, began).contains(&0)).await;
            let off = panel.written(coil).into_iter().find(|(at, on)| *at >= began && *on == 0);
            last = last.max(off.unwrap().0);
        }
        best = best.min(last - began);
        if best <= SOON {
            break;
        }
        fire(&panel, &[0, 2], false);
        let closed =
            |id: &str| site.hub.station(id).unwrap().status().is_set(SubsystemId::VALVE1, "Closed");
        until("they close", || closed("M1") && closed("M2")).await;
        sleep(Duration::from_millis(2100)).await;
        assert_eq!(site.post("", "/api/zones/reset", json!({})).await.status, 200);
    }
    assert!(best <= SOON, "{best:?}");
}

/// A device behind the same gateway leaves every read without an answer: over TCP nothing waits for it.
#[tokio::test]
async fn an_order_does_not_wait_for_the_answer_to_a_read() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    works(&panel);
    let gone = "modbus = \"panel\", unit = 99, alarm = \"discrete:0\"".to_owned();
    let sources = [two().to_vec(), vec![gone]].concat();
    let tables = tables().replace("\nvalve", "\nwhen_failed = [\"2oo2\"]\nvalve");
    let text = text(&[("panel", format!("tcp://{address}"))], &sources, "2oo3", &tables);
    let text = text.replace("timeout_ms = 200", "timeout_ms = 3000");
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let site = site_of(read.unwrap_or_else(|what| panic!("{what:#?}")), Clock::System).await;
    for _ in 0..2 {
        let asked = panel.ignored.load(Ordering::SeqCst);
        until("it is asked", || panel.ignored.load(Ordering::SeqCst) > asked).await;
        let began = Instant::now();
        let release = site.post("", "/api/zones/hall/release", json!({ "confirm": "hall" })).await;
        assert_eq!(release.status, 200, "{release:?}");
        until("it opens", || since(&panel, VALVE, began).contains(&1)).await;
        let took = panel.written(VALVE).last().unwrap().0 - began;
        assert!(took < Duration::from_millis(1500), "{took:?}");
        abort(&site).await;
        until("it closes", || since(&panel, VALVE, began).contains(&0)).await;
        sleep(Duration::from_millis(2200)).await;
    }
}

#[tokio::test]
async fn whatever_a_device_does_at_a_write_it_is_on_or_off_in_the_end_and_trouble_meanwhile() {
    let (site, panel) = plant("").await;
    for how in [
        Mischief::Refuses,
        Mischief::Ignores,
        Mischief::Mute,
        Mischief::OtherEcho,
        Mischief::Lies,
        Mischief::Late,
        Mischief::Twice,
        Mischief::ManyOnly,
    ] {
        fire(&panel, &[0, 1], true);
        until("it is open", || panel.coil(VALVE) && panel.coil(PUMP)).await;
        until_shown(&site, "V", "is open", |it| it["read_back"] == true).await;
        panel.misbehaves(Some(how));
        let began = Instant::now();
        abort(&site).await;
        let answers = matches!(how, Mischief::Twice | Mischief::ManyOnly);
        if !answers {
            // Tried again and again, never taken for done.
            until("it is tried again", || since(&panel, VALVE, began).len() > 3).await;
            let it = shown(&site, "V").await;
            assert_eq!(it["wanted"], false, "{how:?}: {it:#}");
            assert!(it["written"] == true || how == Mischief::Lies, "{how:?}: {it:#}");
            panel.misbehaves(None);
        }
        until("it is closed", || !panel.coil(VALVE) && !panel.coil(PUMP)).await;
        until_shown(&site, "V", "is closed", |it| {
            [&it["written"], &it["read_back"]] == [&json!(false); 2] && it["trouble"].is_null()
        })
        .await;
        assert!(!since(&panel, VALVE, began).contains(&1), "{how:?} {:?}", panel.written(VALVE));
        panel.misbehaves(None);
        fire(&panel, &[0, 1], false);
        until_reported(&site, "F2", "quiet", "ready").await;
        sleep(Duration::from_millis(2100)).await;
        assert_eq!(site.post("", "/api/zones/reset", json!({})).await.status, 200);
    }
}

/// The orders of the machine go on meanwhile; what came too late is not written afterwards.
#[tokio::test]
async fn an_opening_that_could_not_be_written_is_not_written_after_an_abort() {
    let (site, panel) = plant("").await;
    panel.misbehaves(Some(Mischief::Ignores));
    fire(&panel, &[0, 1], true);
    until("it is tried", || panel.written(VALVE).len() > 1).await;
    abort(&site).await;
    let began = Instant::now();
    sleep(Duration::from_secs(1)).await;
    panel.misbehaves(None);
    until("it is closed", || since(&panel, VALVE, began).last() == Some(&0)).await;
    sleep(Duration::from_secs(3)).await;
    assert!(!since(&panel, VALVE, began).contains(&1) && !panel.coil(VALVE) && !panel.coil(PUMP));
}

#[tokio::test]
async fn a_device_that_restarts_is_noticed_and_gets_what_is_still_wanted() {
    let (site, panel) = plant("").await;
    fire(&panel, &[0, 1], true);
    until("all is on", || panel.coil(VALVE) && panel.coil(PUMP) && panel.coil(HORN)).await;
    for id in ["V", "P", "horn"] {
        until_shown(&site, id, "is on", |it| it["read_back"] == true).await;
    }
    sleep(Duration::from_millis(300)).await;
    panel.reboots();
    until("all is on again", || panel.coil(VALVE) && panel.coil(PUMP) && panel.coil(HORN)).await;
    until_shown(&site, "P", "is well", |it| it["trouble"].is_null() && it["read_back"] == true)
        .await;
    let events = events(&site).await;
    for text in
        ["Output V (modbus panel unit 1): the device has lost", "Pump P (modbus panel unit 1)"]
    {
        assert!(events.contains(text), "{text}: {events}");
    }
    assert!(troubles(&site).await.contains("\"path\""), "{}", troubles(&site).await);
    // While it is gone an abort comes: it closes as soon as it is back.
    panel.answers.store(false, Ordering::SeqCst);
    until_shown(&site, "V", "is lost", |it| it["trouble"] == "lost").await;
    abort(&site).await;
    let began = Instant::now();
    panel.answers.store(true, Ordering::SeqCst);
    until("all is off", || !panel.coil(VALVE) && !panel.coil(PUMP)).await;
    assert!(!since(&panel, VALVE, began).contains(&1));
}

/// The line is lost with all connections, and comes back with a device that has forgotten everything.
#[tokio::test]
async fn a_lost_line_is_a_trouble_and_restores_lamps_and_closed_valves() {
    let up = std::sync::Arc::new(AtomicBool::new(true));
    let panel = Panel::new();
    well(&panel);
    works(&panel);
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let (own, is_up) = (panel.clone(), up.clone());
    tokio::spawn(async move {
        loop {
            let (stream, _) = listener.accept().await.unwrap();
            let cut = async {
                while is_up.load(Ordering::SeqCst) {
                    sleep(Duration::from_millis(20)).await;
                }
            };
            tokio::select! {
                () = own.clone().serve(stream, rmodbus::ModbusProto::TcpUdp) => {}
                () = cut => {}
            }
        }
    });
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", &tables());
    let site = site_of(config, Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    fire(&panel, &[0, 1], true);
    until("all is on", || panel.coil(VALVE) && panel.coil(PUMP)).await;
    abort(&site).await;
    until("it is closed", || !panel.coil(VALVE)).await;
    up.store(false, Ordering::SeqCst);
    panel.reboots();
    until_shown(&site, "V", "is lost", |it| it["trouble"] == "lost").await;
    let path = "\"subject\":\"P\",\"trouble\":\"path\"";
    let patience = Instant::now();
    while !troubles(&site).await.contains(path) {
        assert!(patience.elapsed() < Duration::from_secs(5), "{}", troubles(&site).await);
    }
    let began = Instant::now();
    up.store(true, Ordering::SeqCst);
    // The trouble lamp is lit, the horn sounds for the alarm, the valve is closed once more.
    until("lamp and horn", || panel.coil(LAMP) && panel.coil(HORN)).await;
    until("the valve", || since(&panel, VALVE, began).contains(&0)).await;
    until_shown(&site, "V", "is well", |it| it["trouble"].is_null()).await;
    assert!(!since(&panel, VALVE, began).contains(&1) && !since(&panel, PUMP, began).contains(&1));
}

#[tokio::test]
async fn a_hub_that_starts_writes_nothing_to_valves_and_pumps_that_it_finds_on() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    for coil in [VALVE, PUMP] {
        panel.memory().set_coil(coil, true).unwrap();
    }
    works(&panel);
    let config = config(&[("panel", format!("tcp://{address}"))], &two(), "2oo2", &tables());
    let site = site_of(config, Clock::System).await;
    until_shown(&site, "V", "is read", |it| it["read_back"] == true).await;
    sleep(Duration::from_secs(1)).await;
    assert!(panel.written(VALVE).is_empty() && panel.written(PUMP).is_empty());
    let state = site.get("", "/api/zones").await.body["state"].clone();
    assert_eq!(state["outputs"][0], json!({ "output": "V", "on": null, "reported": true }));
}

#[tokio::test]
async fn a_heartbeat_changes_every_second_and_registers_keep_their_other_bits() {
    let (panel, address) = Panel::listen().await;
    well(&panel);
    works(&panel);
    panel.memory().set_holding(50, 0xA0F0).unwrap();
    let url = format!("tcp://{address}");
    let text = text(&[("panel", url)], &two(), "2oo2", &tables());
    let beat = format!("timeout_ms = 200\nheartbeat = [{{ unit = 1, set = \"coil:{BEAT}\" }}]");
    let text = text
        .replace("timeout_ms = 200", &beat)
        .replace(&format!("set = \"coil:{HORN}\""), "set = \"holding:50.2\"");
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    let site = site_of(read.unwrap_or_else(|what| panic!("{what:#?}")), Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    fire(&panel, &[0], true);
    until("the horn sounds", || panel.memory().get_holding(50) == Ok(0xA0F4)).await;
    until("it beats", || panel.written(BEAT).len() >= 4).await;
    let beats = panel.written(BEAT);
    for pair in beats.windows(2) {
        let (pause, changed) = (pair[1].0 - pair[0].0, pair[1].1 != pair[0].1);
        assert!(changed && pause >= Duration::from_millis(990), "{beats:?}");
    }
    drop(site);
}
