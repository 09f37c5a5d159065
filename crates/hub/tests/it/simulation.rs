//! A simulation behind the hub: who may change it, and that its monitors become the hub's.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::support::{Site, until};
use lafet_hub::MonitorConfig;
use lafet_hub::access::Role;
use lafet_hub::simulation::{Act, Fault, Loaded, Scenario, Simulation, State};
use lafet_hub::text::{Both, both};
use serde_json::{Value, json};

/// Notes what it receives.
#[derive(Clone, Debug)]
struct Fake {
    told: Arc<Mutex<Vec<String>>>,
    monitors: Vec<MonitorConfig>,
}

impl Fake {
    fn note(&self, what: String) {
        self.told.lock().unwrap().push(what);
    }

    fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.told.lock().unwrap())
    }
}

impl Simulation for Fake {
    fn catalogue(&self) -> (Vec<Scenario>, Vec<Fault>) {
        (Vec::new(), Vec::new())
    }

    fn state(&self) -> State {
        State {
            scenario: "one".into(),
            run: 1,
            seed: 0,
            automatic: false,
            t_s: 0.0,
            duration_s: 60.0,
            over: false,
            paused: false,
            speed: 1.0,
            monitors: BTreeMap::new(),
            score: Vec::new().into(),
        }
    }

    fn load(&self, scenario: &str, seed: Option<u64>, automatic: bool) -> Result<Loaded, Both> {
        self.note(format!("{scenario} {seed:?} {automatic}"));
        if scenario != "one" {
            return Err(both("no", "нет"));
        }
        Ok(Loaded { monitors: self.monitors.clone(), site: Some(lafet_hub::site::Site::default()) })
    }

    fn act(&self, act: &Act) -> Result<(), Both> {
        self.note(format!("{act:?}"));
        Ok(())
    }

    fn commanded(&self, monitor: &str, request: &str) {
        self.note(format!("{monitor} {request}"));
    }

    fn report(&self) -> Value {
        json!({ "passed": true })
    }

    fn picture(&self, russian: bool) -> String {
        format!("<svg>{russian}</svg>")
    }
}

/// Two monitors, of which the scenario has only the second.
async fn site() -> (Site, Fake) {
    let site = Site::with(2, |_| {}).await;
    let monitors = vec![site.hub.station("M2").unwrap().config.clone()];
    let fake = Fake { told: Arc::default(), monitors };
    site.hub.simulate(Box::new(fake.clone()));
    (site, fake)
}

const CHANGES: [(&str, &str); 9] = [
    ("scenario", r#"{"id":"one"}"#),
    ("automatic", r#"{"on":true}"#),
    ("pause", ""),
    ("resume", ""),
    ("speed", r#"{"speed":2}"#),
    ("faults", r#"{"monitor":"M2","fault":"vertical-jam","on":true}"#),
    ("fire", r#"{"at":[1,2]}"#),
    ("fire", r#"{"name":"roof-2"}"#),
    ("link", r#"{"monitor":"M2","up":false}"#),
];

#[tokio::test]
async fn without_a_simulation_there_is_nothing() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Administrator);
    let headers = format!("Bearer {token}");
    let headers = [("Authorization", headers.as_str())];
    for (what, body) in CHANGES {
        let reply = site.http("POST", &format!("/api/sim/{what}"), &headers, body).await;
        assert_eq!((reply.status, reply.code()), (404, "not_found"), "{what}");
    }
    for what in ["/api/sim", "/api/sim/report", "/api/sim/report.svg"] {
        assert_eq!(site.get(&token, what).await.status, 404, "{what}");
    }
}

#[tokio::test]
async fn engineers_change_it_and_everybody_sees_it() {
    let (site, fake) = site().await;
    for (role, token) in site.tokens() {
        let headers = format!("Bearer {token}");
        let headers = [("Authorization", headers.as_str())];
        for what in ["/api/sim", "/api/sim/report", "/api/sim/report.svg?lang=ru"] {
            assert_eq!(site.get(&token, what).await.status, 200, "{what} {role:?}");
        }
        fake.take();
        for (what, body) in CHANGES {
            let reply = site.http("POST", &format!("/api/sim/{what}"), &headers, body).await;
            let expected = if role < Role::Engineer { 403 } else { 200 };
            assert_eq!(reply.status, expected, "{what} {role:?} {reply:?}");
        }
        let told = fake.take();
        assert_eq!(told.len(), if role < Role::Engineer { 0 } else { CHANGES.len() }, "{told:?}");
    }
}

#[tokio::test]
async fn what_makes_no_sense_is_refused() {
    let (site, fake) = site().await;
    let token = site.token(Role::Engineer);
    for (what, body, code) in [
        ("scenario", json!({ "id": "nothing" }), "bad_request"),
        ("scenario", json!({}), "bad_request"),
        ("speed", json!({ "speed": 0 }), "bad_request"),
        ("speed", json!({ "speed": 1000 }), "bad_request"),
        ("fire", json!({}), "bad_request"),
        ("fire", json!({ "at": [1e9, 0] }), "bad_request"),
        ("fire", json!({ "at": [0, 0], "size": -1 }), "bad_request"),
        ("faults", json!({ "monitor": "M9", "fault": "vertical-jam", "on": true }), "no_monitor"),
        ("link", json!({ "monitor": "M9", "up": true }), "no_monitor"),
    ] {
        let reply = site.post(&token, &format!("/api/sim/{what}"), body.clone()).await;
        assert_eq!(reply.code(), code, "{what} {body}");
    }
    assert_eq!(fake.take(), ["nothing None false"]);
}

#[tokio::test]
async fn a_scenario_brings_its_own_monitors() {
    let (site, fake) = site().await;
    let token = site.token(Role::Engineer);
    let mut socket = site.ws(&token).await;
    assert_eq!(socket.authority("M2", "take").await["authority"]["state"], "held");
    site.post(&token, "/api/sim/scenario", json!({ "id": "one", "seed": 3 })).await;
    let change = socket.next_where(|it| it["gone"].is_array()).await;
    let gone = change["gone"].as_array().unwrap();
    assert!(gone.contains(&json!("monitors/M1/status")), "{change}");
    assert!(!gone.iter().any(|it| it.as_str().unwrap().contains("M2")), "{change}");
    let empty = json!({ "monitors": {}, "tanks": [], "walls": [], "keep_outs": [] });
    assert_eq!(change["set"]["hub"]["site"], empty);
    assert_eq!(change["set"]["monitors/M2/authority"]["state"], "free", "{change}");
    assert_eq!(site.get(&token, "/api/monitors/M1").await.code(), "no_monitor");
    until("the new monitor answers", || site.hub.station("M2").unwrap().health() == "up").await;
    fake.take();
    socket.authority("M2", "take").await;
    let ask = |request: &str| json!({ "type": "request", "monitor": "M2", "request": request });
    socket.ask(ask("GetStatus All")).await;
    let moved = socket.ask(ask("Open Valve1")).await;
    assert_eq!(moved["result"]["ok"], true, "{moved}");
    let told = fake.take();
    assert!(told.contains(&"M2 Open Valve1".to_owned()), "{told:?}");
}
