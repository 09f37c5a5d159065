//! A hub killed at any moment loses no acknowledged audit entry, and the chain of hashes holds.

use std::collections::BTreeSet;

use crate::support::{Running, Sim, curl, hub, lafet};
use serde_json::Value;

/// How many times it is killed, each time after a different number of answers.
const KILLS: usize = 6;

fn asked(arguments: &[&str]) -> Option<Value> {
    serde_json::from_str(&curl(arguments)).ok()
}

/// Sends a Stop that does not repeat the previous one, for those share an entry; returns its
/// number.
fn stop(url: &str, turn: usize) -> Option<u64> {
    const OF: [&str; 8] =
        ["All", "Control", "Horizontal", "Vertical", "Nozzle", "Valve1", "Valve2", "Detector"];
    let body = format!(r#"{{"of":"{}"}}"#, OF[turn % OF.len()]);
    let (json, place) = ("Content-Type: application/json", format!("{url}/api/monitors/M1/stop"));
    asked(&["-X", "POST", "-H", json, "-d", &body, &place])?["audit"].as_u64()
}

#[test]
fn what_was_acknowledged_survives_kill_9() {
    let sim = Sim::start(&[]);
    let folder = std::env::temp_dir().join(format!("lafet-kill-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let config = folder.join("hub.toml");
    let text = format!(
        "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
         [[monitor]]\nid = \"M1\"\nurl = \"tcp://{}?addr=1\"\n",
        sim.place()
    );
    std::fs::write(&config, text).unwrap();
    let mut acknowledged = BTreeSet::new();
    for kill in 0..KILLS {
        let (mut hub, url) = hub(&config);
        let mut answered = 0;
        for turn in 0..1000 {
            if let Some(number) = stop(&url, turn) {
                assert!(acknowledged.insert(number), "{number} was assigned twice");
                answered += 1;
            }
            if answered > 2 + kill {
                break;
            }
        }
        assert!(answered > 2, "the hub answers");
        // Killed while other entries are being written.
        std::thread::scope(|scope| {
            let late =
                scope.spawn(|| (0..20).map_while(|turn| stop(&url, turn)).collect::<Vec<_>>());
            acknowledged.extend(stop(&url, 4));
            hub.signal("KILL");
            acknowledged.extend(late.join().unwrap());
        });
        assert_eq!(hub.code(), None, "it was ended by a signal");
    }
    let (_hub, url) = hub(&config);
    let verified = asked(&[&format!("{url}/api/audit/verify")]).expect("an answer");
    assert_eq!(verified["ok"], true, "{verified}");
    let log = asked(&[&format!("{url}/api/audit?limit=1000")]).expect("the log");
    let stored: BTreeSet<u64> =
        log["entries"].as_array().unwrap().iter().filter_map(|it| it["n"].as_u64()).collect();
    let lost: Vec<_> = acknowledged.difference(&stored).collect();
    assert!(lost.is_empty(), "acknowledged, and lost: {lost:?} of {}", acknowledged.len());
    assert!(acknowledged.len() > 3 * KILLS);
    // A second hub would corrupt the log of the first.
    let second = lafet().args(["serve", "--no-browser", "--config"]).arg(&config).output().unwrap();
    let said = String::from_utf8_lossy(&second.stderr);
    assert!(said.contains("Another hub uses"), "{said}");
    assert_eq!(second.status.code(), Some(2));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The files in the order in which a first start makes them; `reserve` is made when all are there.
const MADE: [&str; 7] =
    ["lock", "site.json", "events.db", "audit.db", "hub.db", "history.db", "reserve"];

/// The next start goes on where a first one was ended, and takes nothing for lost.
#[test]
fn a_first_start_killed_at_any_step_is_made_good() {
    let folder = std::env::temp_dir().join(format!("lafet-kill-first-{}", std::process::id()));
    let (config, data) = (folder.join("hub.toml"), folder.join("data"));
    std::fs::create_dir_all(&folder).unwrap();
    let text = "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
                [[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1?addr=1\"\n";
    std::fs::write(&config, text).unwrap();
    for last in MADE {
        let mut command = lafet();
        command.args(["--json", "serve", "--no-browser", "--config"]).arg(&config);
        let mut first = Running::stdout(&mut command);
        while !data.join(last).exists() {
            assert_eq!(first.child.try_wait().unwrap(), None, "it ends before {last}");
            std::thread::yield_now();
        }
        first.child.kill().unwrap();
        first.code();
        let (mut next, url) = hub(&config);
        let health = asked(&[&format!("{url}/health")]).expect("an answer");
        assert_eq!(health["state_lost"], serde_json::json!([]), "{last}: {health}");
        next.signal("TERM");
        assert_eq!(next.code(), Some(0), "{last}");
        std::fs::remove_dir_all(&data).unwrap();
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
