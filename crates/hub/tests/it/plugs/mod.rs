//! The Modbus server, end to end: masters whose frames are not ours, and what such masters do wrong.

mod bounds;
#[cfg(target_os = "linux")]
mod foreign;
mod master;
mod mqtt;
mod opcua;

use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use crate::support::{Site, stays, until};
use lafet_device::composition::Composition;
use lafet_hub::access::Role;
use lafet_hub::{Clock, Config, ManualTime, Overrides};
use lafet_proto::SubsystemId;
use master::{COMMAND, HEARTBEAT, JOG_RESULT, KEYS, Master, SESSION};
use serde_json::{Value, json};
use tokio::time::Instant;

const HORIZONTAL: usize = 1;
/// So often is measured how soon a drive stops: a pause of the machine is in one of them, not in all.
const MEASURED: usize = 4;

/// A port of this machine that is free.
fn free() -> SocketAddr {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap()
}

/// Servers as hub.toml has them, for so many monitors.
fn servers(monitors: u8, text: &str) -> Config {
    let each = (1..=monitors)
        .map(|it| format!("[[monitor]]\nid = \"M{it}\"\nurl = \"tcp://h?addr={it}\"\n"));
    let text = each.collect::<String>() + text;
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    read.unwrap_or_else(|problems| panic!("{problems:#?}"))
}

async fn site_at(monitors: u8, clock: Clock, text: &str) -> Site {
    let read = servers(monitors, text);
    Site::of((monitors, Composition::REMOTE), clock, |config| {
        (config.login, config.modbus_servers) = (false, read.modbus_servers);
    })
    .await
}

/// A server on a port of its own, with further keys.
async fn site(monitors: u8, keys: &str) -> (Site, SocketAddr) {
    let address = free();
    let text = format!(
        "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\nrole = \"operator\"\n{keys}\n"
    );
    (site_at(monitors, Clock::System, &text).await, address)
}

/// A heartbeat that a busy machine does not lose.
const PATIENT: &str = "heartbeat_ms = 5000";

fn opening(site: &Site) -> f64 {
    site.bus.lock()[0].world().valves[0].opening
}

/// Until a condition on the registers holds.
async fn until_read(
    master: &Master,
    what: &str,
    at: u16,
    count: u16,
    wanted: impl Fn(&[u16]) -> bool,
) {
    let began = Instant::now();
    loop {
        let words = master.read(at, count).await;
        if wanted(&words) {
            return;
        }
        assert!(began.elapsed() < crate::support::PATIENCE, "{what}: {words:?}");
    }
}

#[tokio::test]
async fn one_reading_shows_eight_monitors_and_how_old_they_are() {
    let (site, address) = site(8, PATIENT).await;
    site.bus.lock()[2].world_mut().drives[HORIZONTAL].position = 234.0;
    let master = Master::connect(address).await;
    until_read(&master, "it is polled", 5 + 2 * 15 + 4, 1, |words| words[0] == 39).await;
    let all = master.read(0, 125).await;
    assert_eq!((all[3], all[5..].chunks(15).count()), (8, 8));
    for (number, monitor) in (1..).zip(all[5..].chunks(15)) {
        assert_eq!(monitor[0] & 0b1111, 1, "M{number} is good: {monitor:?}");
        assert!(monitor[1] < 2000, "its age: {monitor:?}");
        assert_eq!((monitor[3], monitor[9] & 0x4F), (0, 0x42), "free, closed: {monitor:?}");
    }
    let own = site.hub.station("M3").unwrap().status();
    assert_eq!(own.position(SubsystemId::HORIZONTAL), Some(234));
    // The hub changes its own heartbeat.
    until_read(&master, "a sign of life", 2, 1, |words| words[0] != all[2]).await;
    site.bus.silence(2);
    until_read(&master, "M2 is stale", 20, 15, |words| words[0] & 3 == 2).await;
    let silent = master.read(20, 15).await;
    assert_eq!((silent[4], silent[8], silent[9]), (0x8000, 0xFFFF, 0xC0), "{silent:?}");
    until_read(&master, "its age grows", 21, 1, |words| words[0] > 2000).await;
    assert_eq!(master.read(5, 1).await[0] & 3, 1, "the others are good");
    let ids = master.read(320, 8).await;
    assert_eq!(ids[0].to_be_bytes(), *b"M1");
    assert_eq!(master.read(512, 125).await.len(), 125);
    assert_eq!(master.try_read(671, 2).await, Err(2));
}

#[tokio::test]
async fn a_position_is_reached_and_every_command_is_answered() {
    let (site, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await;
    assert_eq!(master.command(4, 1, [1, 100, 0, 0]).await, (3, 5), "no heartbeat");
    let master = master.live().await;
    assert_eq!(master.command(4, 1, [1, 100, 0, 0]).await, (3, 8), "no client has authority");
    assert_eq!(master.command(1, 1, [0; 4]).await, (2, 0));
    assert_eq!(master.read(8, 1).await, [1], "this master holds it");
    assert_eq!(master.command(4, 1, [3, 100, 50, 0]).await, (2, 0));
    until_read(&master, "it gets there", 9, 2, |it| it == [100, 50]).await;
    let (state, refusal) = master.command(9, 1, [0; 4]).await;
    assert_eq!((state, refusal), (3, 12), "this monitor has no deployer");
    assert_ne!(master.read(141, 1).await, [0], "the result of the monitor is there");
    assert_eq!(master.command(77, 1, [0; 4]).await, (3, 1));
    assert_eq!(master.command(4, 2, [1, 0, 0, 0]).await, (3, 2));
    assert_eq!(master.command(2, 1, [0; 4]).await, (2, 0));
    assert_eq!(master.read(8, 1).await, [0]);
    let noted = site.get("", "/api/audit").await.body.to_string();
    for text in [
        "modbus plc",
        "\"kind\":\"modbus\"",
        "\"via\":\"modbus\"",
        "\"from\":\"127.0.0.1\"",
        "Move Horizontal 600",
    ] {
        assert!(noted.contains(text), "{text}: {noted}");
    }
}

/// The simulator's own output, from the last beat of a master that falls silent.
#[tokio::test]
async fn a_lost_heartbeat_stops_the_barrel_in_half_a_second() {
    let (site, address) = site(1, "").await;
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    let master = Master::connect(address).await.live().await;
    let mut quickest = [Duration::MAX; 2];
    for round in 0..2 * MEASURED {
        // By hand, and on the way to a position.
        let by_hand = round % 2 == 0;
        let direction = if round % 4 < 2 { 1 } else { -1 };
        let began = Instant::now();
        while !moving() {
            assert!(began.elapsed() < crate::support::PATIENCE, "it does not move");
            // A machine that is busy loses a heartbeat: then it begins again.
            if master.read(8, 1).await != [1] {
                master.beat(true);
                master.command(1, 1, [0; 4]).await;
            } else if by_hand {
                master.jog(1, [direction, 0, 0]).await;
                tokio::time::sleep(Duration::from_millis(200)).await;
            } else {
                master.command(4, 1, [1, (1700 * direction).cast_unsigned(), 0, 0]).await;
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        }
        master.beat(false);
        let silent = Instant::now();
        until("it stops", || !moving()).await;
        let kind = &mut quickest[usize::from(!by_hand)];
        *kind = (*kind).min(silent.elapsed());
        assert!(stays(Duration::from_millis(300), || !moving()).await);
        until_read(&master, "the heartbeat is lost", SESSION + 3, 1, |it| it == [0]).await;
        // And once it beats again, nothing moves by itself.
        master.beat(true);
        until_read(&master, "it is back", SESSION + 3, 1, |it| it == [1]).await;
        assert!(stays(Duration::from_millis(300), || !moving()).await);
    }
    println!("by hand {:?}, to a position {:?}", quickest[0], quickest[1]);
    assert!(quickest.iter().all(|it| *it <= Duration::from_millis(500)), "{quickest:?}");
}

#[tokio::test]
async fn authority_goes_back_when_the_heartbeat_does_not_return() {
    let (site, address) = site(1, "heartbeat_ms = 300").await;
    let master = Master::connect(address).await.live().await;
    assert_eq!(master.command(1, 1, [0; 4]).await, (2, 0));
    let mut console = site.ws("").await;
    assert_eq!(console.authority("M1", "take").await["error"]["code"], "held");
    master.beat(false);
    let began = Instant::now();
    // The connection is open all the same.
    until_read(&master, "it is free", 8, 1, |it| it == [0]).await;
    let events = site.get("", "/api/events").await.body.to_string();
    assert!(events.contains("heartbeat of modbus"), "{events}");
    assert!(began.elapsed() >= Duration::from_millis(500), "lost_ms: it may come back");
    assert!(console.authority("M1", "take").await["error"].is_null());
    assert_eq!(master.read(8, 1).await, [2]);
}

#[tokio::test]
async fn a_heartbeat_that_counts_moves_nothing_once_authority_is_gone() {
    let (site, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    master.jog(1, [1, 0, 0]).await;
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    until("it moves", moving).await;
    let mut console = site.ws("").await;
    console.authority("M1", "force").await;
    until("it stops", || !moving()).await;
    until_read(&master, "it is reported", JOG_RESULT, 3, |it| it[1] == 3 && it[2] == 7).await;
    assert!(stays(Duration::from_millis(500), || !moving()).await);
    assert_eq!(master.read(SESSION + 3, 1).await, [1], "the heartbeat is alive");
    assert_eq!(master.command(4, 1, [1, 0, 0, 0]).await, (3, 7));
}

#[tokio::test]
async fn of_two_masters_and_a_console_one_holds_and_all_stop() {
    let (site, address) = site(1, PATIENT).await;
    let (first, second) = (Master::connect(address).await, Master::connect(address).await);
    let (first, second) = (first.live().await, second.live().await);
    let mut console = site.ws("").await;
    assert_eq!(first.command(1, 1, [0; 4]).await, (2, 0));
    assert_eq!(second.command(1, 1, [0; 4]).await, (3, 7));
    assert_eq!((first.read(8, 1).await, second.read(8, 1).await), (vec![1], vec![2]));
    assert_eq!(console.authority("M1", "take").await["error"]["code"], "held");
    assert_eq!(second.command(4, 1, [1, 100, 0, 0]).await, (3, 7));
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    for stop in 0..3 {
        let target: i16 = if stop % 2 == 0 { 1700 } else { -1700 };
        assert_eq!(first.command(4, 1, [1, target.cast_unsigned(), 0, 0]).await, (2, 0));
        until("it moves", moving).await;
        match stop {
            0 => assert_eq!(second.command(7, 1, [0; 4]).await, (2, 0)),
            1 => assert_eq!(second.command(7, 0, [0; 4]).await, (2, 0), "all of the site"),
            _ => assert!(console.ask(json!({ "type": "stop" })).await["results"].is_object()),
        }
        until("it stops", || !moving()).await;
        assert!(stays(Duration::from_millis(300), || !moving()).await);
    }
    // One asks, and the holder grants it; it is never taken by force.
    assert_eq!(second.command(3, 1, [0; 4]).await, (2, 0));
    assert_eq!(first.read(8, 1).await, [1 | 1 << 9]);
    assert_eq!(second.read(8, 1).await, [2 | 1 << 9 | 1 << 10]);
    assert_eq!(first.command(2, 1, [0; 4]).await, (2, 0));
    assert_eq!(second.read(8, 1).await, [1]);
    let state = site.get("", "/api/hub/state").await.body["plugs"][0].clone();
    assert_eq!((&state["protocol"], &state["name"]), (&json!("modbus"), &json!("plc")));
    assert_eq!(state["clients"].as_array().map(Vec::len), Some(2), "{state:#}");
    drop((first, second));
    let gone = async || site.get("", "/api/hub/state").await.body["plugs"][0]["clients"].clone();
    let began = Instant::now();
    while gone().await != Value::Array(vec![]) {
        assert!(began.elapsed() < crate::support::PATIENCE);
    }
}

#[tokio::test]
async fn an_opening_by_the_rules_opens_and_its_recording_does_not() {
    let (site, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    let before = master.read(KEYS, 4).await;
    assert_eq!(master.command(5, 1, [1, 0, 0, 0]).await, (2, 0));
    until("it opens", || opening(&site) > 0.9).await;
    assert_ne!(master.read(KEYS, 4).await, before);
    assert_eq!(master.command(6, 1, [0; 4]).await, (2, 0));
    until("it closes", || opening(&site) < 0.01).await;
    let recorded = master.frames();
    // In the same session: the very frame of the opening, and with a new number.
    let frame = recorded.iter().find(|it| it.len() > 20 && it[13 + 7] == 5).expect("the opening");
    let words: Vec<u16> =
        frame[13..].chunks_exact(2).map(|it| u16::from_be_bytes([it[0], it[1]])).collect();
    for sequence in [words[0], 9001] {
        let mut words = words.clone();
        words[0] = sequence;
        master.write(COMMAND, &words).await;
    }
    assert_eq!(master.result(9001).await.1, 9, "the key is not the one that is offered now");
    drop(master);
    until("authority is free", || holder(&site).is_none()).await;
    // On new connections: the whole recording, its parts, and with the connection cut within.
    for cut in [recorded.len(), recorded.len() / 2, recorded.len() - 1] {
        let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
        for frame in &recorded[..cut] {
            use tokio::io::AsyncWriteExt;
            stream.write_all(frame).await.unwrap();
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
        assert!(stays(Duration::from_millis(300), || opening(&site) < 0.01).await);
    }
    let noted = site.get("", "/api/audit?text=open%20valve1&limit=1000").await.body;
    let asked = |it: &&Value| it["what"] == "Open Valve1" && it["outcome"] == "asked";
    let entries = noted["entries"].as_array().expect("entries");
    assert_eq!(entries.iter().filter(asked).count(), 1, "{noted:#}");
    let wrong_key = |it: &&Value| it["outcome"] == "not allowed" && it["details"]["code"] == 9;
    assert_eq!(entries.iter().filter(wrong_key).count(), 1, "{noted:#}");
}

fn holder(site: &Site) -> Option<String> {
    site.hub.station("M1").unwrap().authority.lock().unwrap().holder().map(|it| it.0.seat.clone())
}

#[tokio::test]
async fn water_goes_on_without_its_master_unless_the_configuration_closes_it() {
    for closes in [false, true] {
        let (site, address) =
            site(1, &format!("heartbeat_ms = 1000\nclose_when_lost = {closes}")).await;
        let master = Master::connect(address).await.live().await;
        master.command(1, 1, [0; 4]).await;
        assert_eq!(master.command(5, 1, [1, 0, 0, 0]).await, (2, 0));
        until("it opens", || opening(&site) > 0.9).await;
        // Its connection ends: the heartbeat with it.
        drop(master);
        until("authority is free", || holder(&site).is_none()).await;
        match closes {
            true => until("it closes", || opening(&site) < 0.01).await,
            false => assert!(stays(Duration::from_secs(2), || opening(&site) > 0.9).await),
        }
    }
}

/// The line to the monitor is lost together with the master, and comes back later.
#[tokio::test]
async fn water_of_a_lost_master_closes_once_its_monitor_is_heard_again() {
    let (site, address) = site(1, "heartbeat_ms = 1000\nclose_when_lost = true").await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    assert_eq!(master.command(5, 1, [1, 0, 0, 0]).await, (2, 0));
    until("it opens", || opening(&site) > 0.9).await;
    site.bus.silence(1);
    drop(master);
    let began = Instant::now();
    while !site.get("", "/api/events").await.body.to_string().contains("repeated each second") {
        assert!(began.elapsed() < crate::support::PATIENCE, "it is not reported");
    }
    until("authority is free", || holder(&site).is_none()).await;
    assert!(opening(&site) > 0.9);
    site.bus.silence(0);
    until("it closes", || opening(&site) < 0.01).await;
    let closes = || site.hub.station("M1").unwrap().urgent_counts().close;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let done = closes();
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert_eq!(closes(), done, "it is confirmed");
}

/// Of a monitor that it has released, the water that it has opened closes as well.
#[tokio::test]
async fn water_of_a_lost_master_closes_unless_another_holds_the_monitor() {
    for other in [false, true] {
        let (site, address) = site(1, "heartbeat_ms = 1000\nclose_when_lost = true").await;
        let master = Master::connect(address).await.live().await;
        master.command(1, 1, [0; 4]).await;
        assert_eq!(master.command(5, 1, [1, 0, 0, 0]).await, (2, 0));
        until("it opens", || opening(&site) > 0.9).await;
        assert_eq!(master.command(2, 1, [0; 4]).await, (2, 0));
        let mut console = site.ws("").await;
        if other {
            assert!(console.authority("M1", "take").await["error"].is_null());
        }
        drop(master);
        match other {
            false => until("it closes", || opening(&site) < 0.01).await,
            true => assert!(stays(Duration::from_secs(2), || opening(&site) > 0.9).await),
        }
    }
}

#[tokio::test]
async fn after_a_restart_of_the_hub_an_old_image_commands_nothing() {
    let (first, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    // In the middle of a command.
    first.bus.keep_back(lafet_proto::RequestId::MOVE);
    let sequence = master.send(4, 1, [1, 900, 0, 0]).await;
    let waits = master.read(136, 2).await;
    assert_eq!(waits, [sequence, 1], "accepted");
    let image = master.read(HEARTBEAT, 21).await;
    let version = master.read(0, 2).await;
    drop((first, master));
    let text = format!(
        "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(1, Clock::System, &text).await;
    let master = Master::connect(address).await.live().await;
    assert_eq!(master.read(0, 2).await, version, "the same map");
    assert_eq!(master.read(136, 2).await, [0, 0], "no result of before");
    for _ in 0..5 {
        master.write(COMMAND, &image[8..]).await;
    }
    assert_eq!(master.result(sequence).await, (3, 4, 0));
    assert_eq!(site.bus.commanded(0, HORIZONTAL), 0);
}

#[tokio::test]
async fn a_date_that_is_set_changes_no_age_and_loses_no_heartbeat() {
    let (time, address) = (ManualTime::at(1_700_000_000_000), free());
    let text = format!(
        "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(1, Clock::Manual(time.clone()), &text).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    for date in [1_000, 4_000_000_000_000, 1_700_000_000_000] {
        time.set_date(date);
        for _ in 0..10 {
            let words = master.read(5, 4).await;
            assert!(words[0] & 1 == 1 && words[1] < 2000 && words[3] == 1, "{words:?}");
        }
        assert_eq!(master.read(SESSION + 3, 3).await, [1, 5000, 0]);
    }
    drop(site);
}

#[tokio::test]
async fn who_may_only_read_reads_and_stops() {
    let address = free();
    let text = format!(
        "[[modbus_server]]\nname = \"panel\"\nlisten = \"tcp://{address}\"\nrole = \"none\"\n{PATIENT}\n\
         [[modbus_server.client]]\nname = \"guard\"\nfrom = [\"127.0.0.0/8\"]\nregisters = [0, 300]\nrole = \"observer\"\n"
    );
    let site = site_at(1, Clock::System, &text).await;
    let mut console = site.ws("").await;
    console.authority("M1", "take").await;
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 9000" });
    assert_eq!(console.ask(asked).await["result"]["ok"], true);
    until("it moves", || site.bus.commanded(0, HORIZONTAL) != 0).await;
    let master = Master::connect(address).await.live().await;
    assert_eq!(master.read(SESSION + 2, 1).await, [1]);
    assert_eq!(master.try_read(320, 8).await, Err(2), "these registers are not granted");
    for command in [1, 3, 4, 5, 9] {
        assert_eq!(master.command(command, 1, [1, 0, 0, 0]).await, (3, 6));
    }
    assert_eq!(master.command(7, 1, [0; 4]).await, (2, 0));
    until("it stops", || site.bus.commanded(0, HORIZONTAL) == 0).await;
    let noted = site.get("", "/api/audit").await.body.to_string();
    assert!(noted.contains("modbus guard") && noted.contains(Role::Observer.name()), "{noted}");
}

#[test]
fn what_is_wrong_in_the_file_is_reported_with_its_line_and_what_to_do() {
    let text = "[[monitor]]\nid = \"M1\"\nurl = \"serial:///dev/ttyS1?addr=1\"\n\
                [[modbus_server]]\nname = \"a b\"\nlisten = \"tcp://0.0.0.0:502\"\nheartbeat_ms = 1\n\
                [[modbus_server]]\nname = \"x\"\nlisten = \"tcp://plc:502\"\nunit = 300\n\
                [[modbus_server]]\nname = \"y\"\nlisten = \"serial:///dev/ttyS1\"\nallow = [\"10.0.0\"]\n\
                [[modbus_server]]\nname = \"z\"\nlisten = \"tcp://127.0.0.1:502\"\nrole = \"none\"\nmonitors = [\"M9\"]\n\
                [[modbus_server]]\nname = \"z\"\nlisten = \"tcp://127.0.0.1:502\"\nidle_s = 0\nansver_ms = 3\n\
                [[modbus_server.client]]\nname = \"c\"\nunits = [9]\nregisters = [5, 4]\nrole = \"boss\"\n\
                [[modbus_server.client]]\nname = \"d\"\nunits = [9]\nregisters = [5, 4]\nrole = \"operator\"\n";
    let read = Config::parse("hub.toml", text, Path::new("/"), &Overrides::default());
    let problems = read.unwrap_err();
    let shown: Vec<String> = problems.iter().map(ToString::to_string).collect();
    for (line, words) in [
        (5, "no name of a Modbus server"),
        (6, "Write allow = ["),
        (7, "50…10000"),
        (10, "no IP address to listen on"),
        (11, "1…247"),
        (14, "used by a monitor or a bus"),
        (15, "no address or network"),
        (15, "Leave allow and from out"),
        (17, "would answer no master"),
        (20, "There is no monitor M9"),
        (22, "is given twice"),
        (23, "listens there already"),
        (24, "1…3600"),
        (25, "Did you mean answer_ms?"),
        (30, "boss"),
        (33, "1…1"),
        (34, "end before they begin"),
    ] {
        let place = format!("hub.toml:{line}: ");
        let found = shown.iter().any(|it| it.starts_with(&place) && it.contains(words));
        assert!(found, "{line} {words}: {shown:#?}");
    }
    let russian = |it: &lafet_hub::Problem| it.what.ru.chars().any(|c| ('а'..='я').contains(&c));
    assert!(problems.iter().all(russian), "{problems:#?}");
    let slow = servers(
        1,
        "[[modbus_server]]\nname = \"x\"\nlisten = \"tcp://127.0.0.1:502\"\nheartbeat_ms = 301\n",
    );
    assert!(slow.warnings[0].to_string().contains("500 ms"), "{:?}", slow.warnings);
}

/// Between the marks of the documents.
fn in_document(text: &str) -> &str {
    let rest = text.split("<!-- map:begin -->\n").nth(1).expect("a beginning");
    rest.split("<!-- map:end -->").next().expect("an end").trim()
}

/// The map of one monitor, without the head that has its version: titles are a level deeper there.
fn printed(lang: lafet_client::Lang) -> String {
    let text = "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://127.0.0.1:502\"\n";
    let config = servers(1, text);
    let printed = lafet_hub::modbus_server::map::markdown(&config.modbus_servers[0], lang);
    printed.replace("## ", "### ").trim().to_owned()
}

#[test]
fn the_documents_have_the_map_that_is_printed_and_their_example_is_right() {
    let documents = [
        (lafet_client::Lang::En, include_str!("../../../../../docs/modbus.md")),
        (lafet_client::Lang::Ru, include_str!("../../../../../docs/modbus.ru.md")),
    ];
    let mut examples = Vec::new();
    for (lang, document) in documents {
        assert_eq!(in_document(document), printed(lang));
        let example = document.split("```toml\n").nth(1).and_then(|it| it.split("```").next());
        let bare = |line: &str| line.split(" #").next().unwrap_or_default().trim().to_owned();
        let lines = example.expect("an example").lines();
        // What is commented out is right as well.
        let lines = lines.map(|it| bare(it.strip_prefix("# ").unwrap_or(it)));
        examples.push(lines.collect::<Vec<_>>().join("\n"));
    }
    assert_eq!(examples[0], examples[1]);
    let config = servers(2, &examples[0]);
    let server = &config.modbus_servers[0];
    assert_eq!((server.monitors.len(), server.grants.len(), server.connections_max), (2, 2, 8));
}

/// The frames that `lafet map` prints are answered so by a hub, as far as nothing in them is random.
#[tokio::test]
async fn the_printed_frames_are_those_of_a_hub() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let (site, address) = site(1, PATIENT).await;
    let vectors = lafet_hub::modbus_server::vectors::vectors(1, &["M1".to_owned()]);
    let bytes = |hex: &str| -> Vec<u8> {
        let pairs = hex.as_bytes().chunks(2).map(|it| std::str::from_utf8(it).unwrap());
        pairs.map(|it| u8::from_str_radix(it, 16).unwrap()).collect()
    };
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let mut same = 0;
    for vector in &vectors {
        stream.write_all(&bytes(&vector.tcp_request)).await.unwrap();
        let mut answer = vec![0; 300];
        let len = stream.read(&mut answer).await.unwrap();
        let printed = bytes(&vector.tcp_answer);
        assert_eq!(len, printed.len(), "{vector:?}");
        same += usize::from(answer[..len] == printed);
    }
    // Of the writes and the exceptions every byte, of the readings their form.
    assert!(same >= 9, "{same} of {}", vectors.len());
    drop(site);
}
