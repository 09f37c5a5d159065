//! With asyncua: `cargo xtask plugs` installs it.

use std::net::SocketAddr;
use std::process::Command;
use std::time::Duration;

use serde_json::json;
use tokio::time::Instant;

use super::super::mqtt::broker::Running;
use super::super::{HORIZONTAL, opening};
use super::{Folder, free, listening_for, open, site_with, table};
use crate::support::{PASSWORD, Site, until};
use lafet_hub::access::Role;

const OPERATOR: &str = "role = \"operator\"\nanonymous = \"operator\"";

/// The script with asyncua.
fn asyncua(address: SocketAddr, arguments: &[&str]) -> Running {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/opcua/client.py");
    let mut command = Command::new("python3");
    command.arg(script).arg(format!("opc.tcp://{address}/")).args(arguments);
    Running::start(command)
}

/// The script with node-opcua, in a folder with its key.
fn node_opcua(address: SocketAddr, folder: &Folder, arguments: &[&str]) -> Running {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/opcua/client.cjs");
    let mut command = Command::new("node");
    command.arg(script).arg(format!("opc.tcp://{address}/")).arg(&folder.0).args(arguments);
    Running::start(command)
}

/// An administrator trusts the certificate that was rejected.
fn trust(folder: &Folder) {
    let mut rejected = std::fs::read_dir(folder.0.join("rejected")).unwrap();
    let rejected = rejected.next().unwrap().unwrap();
    std::fs::rename(rejected.path(), folder.0.join("trusted").join(rejected.file_name())).unwrap();
}

async fn ended(mut client: Running, last: &str) -> Vec<String> {
    client.until(last, |it| it.starts_with(last)).await;
    client.close();
    client.lines()
}

fn moving(site: &Site) -> bool {
    site.bus.commanded(0, HORIZONTAL) != 0
}

fn holder(site: &Site) -> Option<String> {
    let station = site.hub.station("M1").unwrap();
    let authority = station.authority.lock().unwrap();
    authority.holder().map(|(seat, _)| seat.user.clone())
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn it_is_browsed_and_read_with_units_and_types() {
    let (site, address, _folder) = open(2, "anonymous = \"observer\"").await;
    site.bus.lock()[0].world_mut().drives[HORIZONTAL].position = 234.0;
    until("it is heard", || {
        let status = site.hub.station("M1").unwrap().status();
        status.position(lafet_proto::SubsystemId::HORIZONTAL) == Some(234)
    })
    .await;
    let lines = ended(asyncua(address, &["browse"]), "write").await;
    assert_eq!(
        lines,
        [
            "site Lafet",
            "children Alive CloseAll LockoutAll M1 M2 StopAll",
            "found M1",
            "type DriveType",
            "unit 17476 ° -360.0 360.0",
            "inputs Ticket Traverse Elevation Nozzle",
            "position Good 3.9",
            "absent BadNotSupported",
            "stamped True",
            "write BadServiceUnsupported",
        ]
    );
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn a_silent_monitor_has_a_bad_status_and_water_may_flow() {
    let (site, address, _folder) = open(1, "anonymous = \"observer\"").await;
    let client = asyncua(address, &["subscribe"]);
    client.until("it listens", |it| it == "subscribed").await;
    site.bus.silence(1);
    let lines = ended(client, "water").await;
    assert_eq!(lines, ["subscribed", "stale BadNoCommunication True", "water may flow"]);
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn a_client_takes_its_turn_opens_once_and_closes() {
    let (site, address, _folder) = open(1, OPERATOR).await;
    let lines = ended(asyncua(address, &["session"]), "done").await;
    assert_eq!(
        lines,
        [
            "early 23 BadInvalidTimestamp hub",
            "Move 8 BadInvalidState hub",
            "Take ok",
            "Move ok",
            "arrived",
            "Open 9 BadUserAccessDenied hub",
            "Open ok",
            "opened",
            "Open 9 BadUserAccessDenied hub",
            "Stow 12 BadRequestNotAllowed M1",
            "Close ok",
            "Stop ok",
            "Move 18 BadOperationAbandoned hub",
            "Move ok",
            "Release ok",
            "done",
        ]
    );
    let noted = site.get("", "/api/audit?limit=1000").await.body;
    let entries = noted["entries"].as_array().unwrap();
    let of = |outcome: &str| {
        let is_it =
            |it: &&serde_json::Value| it["what"] == "Open Valve1" && it["outcome"] == outcome;
        entries.iter().filter(is_it).collect::<Vec<_>>()
    };
    assert_eq!(of("asked").len(), 1, "{noted:#}");
    let refused = of("not allowed");
    assert_eq!((&refused[0]["kind"], &refused[0]["user"]), (&json!("opcua"), &json!("opcua site")));
    assert_eq!((&refused[0]["via"], &refused[0]["details"]["code"]), (&json!("opcua"), &json!(9)));
    assert!(refused[0]["from"].as_str().unwrap().starts_with("127.0.0.1:"), "{noted:#}");
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn who_may_only_read_stops_and_locks_out_but_opens_nothing() {
    let (site, address, _folder) = open(1, "anonymous = \"observer\"").await;
    let lines = ended(asyncua(address, &["refused"]), "done").await;
    assert_eq!(
        lines,
        [
            "Take 6 BadUserAccessDenied hub",
            "Move 6 BadUserAccessDenied hub",
            "Open 6 BadUserAccessDenied hub",
            "Stop ok",
            "Lockout ok",
            "GetKey BadUserAccessDenied",
            "done",
        ]
    );
    assert!(opening(&site) < 0.01);
}

/// Killed, and alive but silent.
#[tokio::test]
#[ignore = "needs asyncua"]
async fn a_lost_client_stops_the_barrel_closes_the_valve_and_loses_authority() {
    for (how, most) in [("die", 1500), ("silent", 4500)] {
        let (site, address, _folder) = open(1, OPERATOR).await;
        let mut client = asyncua(address, &["hold", "170", "open"]);
        client.until("it moves", |it| it == "moving").await;
        until("it moves", || moving(&site)).await;
        assert!(opening(&site) > 0.5);
        assert_eq!(holder(&site).as_deref(), Some("opcua site"));
        let began = Instant::now();
        client.tell(how);
        until("it stops", || !moving(&site)).await;
        let took = began.elapsed();
        println!("{how}: stopped after {took:?}");
        assert!(took < Duration::from_millis(most), "{how}: {took:?}");
        until("it closes", || opening(&site) < 0.01).await;
        until("authority is free", || holder(&site).is_none()).await;
        drop(client);
    }
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn alarms_are_acknowledged_commented_and_shelved() {
    let (site, address, _folder) = open(2, OPERATOR).await;
    let mut client = asyncua(address, &["alarms"]);
    client.until("it listens", |it| it == "listening").await;
    site.bus.silence(2);
    client.tell("go");
    let lines = ended(client, "unshelve").await;
    let took = lines.iter().find_map(|it| it.strip_prefix("took ")).unwrap().to_owned();
    println!("acknowledged, and seen, after ms: {took}");
    let most = took.split(' ').map(|it| it.parse::<u32>().unwrap()).max();
    assert!(most <= Some(200), "{took} ms");
    let lines: Vec<&str> =
        lines.iter().map(String::as_str).filter(|it| !it.starts_with("took")).collect();
    assert_eq!(
        lines,
        [
            "listening",
            "alarm M2/Link/Stale False True True",
            "wrong BadEventIdUnknown",
            "acknowledge Good seen by asyncua",
            "again BadConditionBranchAlreadyAcked",
            "refresh Good True True True",
            "shelve Good",
            "unshelve Good",
        ]
    );
    let noted = site.get("", "/api/audit?limit=1000").await.body;
    let entries = noted["entries"].as_array().unwrap();
    let acked = entries.iter().find(|it| it["what"] == "acknowledge M2/Link/Stale").unwrap();
    assert_eq!(
        (&acked["via"], &acked["details"]["comment"]),
        (&json!("opcua"), &json!("seen by asyncua"))
    );
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn the_history_of_a_position_is_read() {
    let (_site, address, _folder) = open(1, OPERATOR).await;
    let lines = ended(asyncua(address, &["history"]), "two").await;
    assert_eq!(lines, ["Take ok", "Move ok", "history True True True", "two 2"]);
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn users_log_in_over_encrypted_channels_with_trusted_certificates() {
    let (address, folder) = (free(), Folder::new());
    let site = site_with(1, &table(address, &folder, "role = \"operator\""), true).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let token = site.token(Role::Administrator);
    listening_for(&site, &token).await;
    let own = Folder::new();
    let path = own.0.display().to_string();
    let login = |password: &str| ["secure", &path, "anna", password, "session"].map(str::to_owned);
    let run = async |password: &str, last: &str| {
        let arguments = login(password);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        ended(asyncua(address, &arguments), last).await
    };
    assert_eq!(run(PASSWORD, "refused").await, ["refused BadCertificateUntrusted"]);
    trust(&folder);
    assert_eq!(run("wrong password", "refused").await, ["refused BadIdentityTokenRejected"]);
    let lines = run(PASSWORD, "done").await;
    assert_eq!(lines.last().map(String::as_str), Some("done"));
    assert!(lines.contains(&"Open ok".to_owned()), "{lines:#?}");
    // Without security there is no door.
    let plain = ended(asyncua(address, &["tries", "anna", PASSWORD]), "refused").await;
    assert_eq!(plain.len(), 1, "{plain:#?}");
}

#[tokio::test]
#[ignore = "needs asyncua"]
async fn many_values_come_and_a_stop_is_quick_meanwhile() {
    let (site, address, _folder) = open(1, "anonymous = \"observer\"").await;
    // The age of the state of a monitor that is silent grows in steps of 100 ms.
    site.bus.silence(1);
    let lines = ended(asyncua(address, &["flood", "1100", "5"]), "values").await;
    println!("{lines:?}");
    let numbers: Vec<u32> = lines[0].split(' ').filter_map(|it| it.parse().ok()).collect();
    let [values, stop] = numbers[..] else { panic!("{lines:?}") };
    assert!(values > 5000, "{values} values a second");
    assert!(stop < 500, "{stop} ms");
}

#[tokio::test]
#[ignore = "needs node-opcua"]
async fn node_opcua_browses_subscribes_acknowledges_and_stops() {
    let (address, folder) = (free(), Folder::new());
    let site = site_with(2, &table(address, &folder, "role = \"operator\""), true).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    listening_for(&site, &site.token(Role::Administrator)).await;
    let own = Folder::new();
    let run = || node_opcua(address, &own, &["anna", PASSWORD]);
    assert_eq!(ended(run(), "refused").await, ["refused BadCertificateUntrusted"]);
    trust(&folder);
    let mut client = run();
    client.until("it listens", |it| it == "listening").await;
    site.bus.silence(2);
    client.tell("go");
    assert_eq!(
        ended(client, "done").await,
        [
            "objects true",
            "position Good Double",
            "subscribed",
            "listening",
            "alarm M2 M2/Link/Stale",
            "acknowledge Good seen by node-opcua",
            "Take BadInvalidTimestamp hub",
            "Stop Good -",
            "Close Good -",
            "done",
        ]
    );
}
