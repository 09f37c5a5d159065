//! What the console's pages look up: programs, links, parameters, logs, who is signed in.

use crate::support::{self, PASSWORD, Site, hold_until};
use lafet_hub::access::Role;
use serde_json::{Value, json};
use tokio::time::Instant;

const QUENCH: &str = "StartQuench Control centre=0,0 nozzle=60 sector=600,300 step=2 distance=25";

fn request(text: &str) -> Value {
    json!({ "type": "request", "monitor": "M1", "request": text })
}

#[tokio::test]
async fn what_was_expected_is_told_in_both_languages() {
    let site = Site::open(1).await;
    let wrong = json!({ "request": "Opne Valve1" });
    let error = site.post("", "/api/monitors/M1/requests", wrong).await.body["error"].clone();
    assert_eq!((&error["column"], &error["suggestion"]), (&json!(0), &json!("Open")));
    let (en, ru) = (error["en"].as_str().unwrap(), error["ru"].as_str().unwrap());
    assert!(en.contains("expected a request") && en.contains("did you mean `Open`?"), "{en}");
    assert!(ru.contains("ожидается запрос") && ru.contains("может быть, `Open`?"), "{ru}");
}

#[tokio::test]
async fn a_program_is_known_to_every_page_and_when_it_goes_on() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    let mut other = site.ws("").await;
    operator.authority("M1", "take").await;
    let accepted = operator.ask(request(QUENCH)).await;
    assert_eq!(accepted["result"]["ok"], true, "{accepted}");
    let program = "monitors/M1/program";
    let told = other.next_where(|it| it["set"][program]["request"].is_string()).await;
    assert_eq!(told["set"][program]["request"], QUENCH);
    assert_eq!(told["set"][program]["by"], "demo");
    let quenches = |it: &Value| {
        it["set"]["monitors/M1/status"]["subsystems"]["Control"]["flags"]
            .to_string()
            .contains("Quench")
    };
    let status = other.next_where(quenches).await;
    assert_eq!(status["set"]["monitors/M1/status"]["resumes_ms"], Value::Null);
    let before_ms = site.hub.clock().now_ms();
    operator.ask(request("Move Vertical 60")).await;
    let resumes = |it: &Value| it["set"]["monitors/M1/status"]["resumes_ms"].as_u64();
    let paused = other.next_where(|it| resumes(it).is_some()).await;
    let in_ms = resumes(&paused).unwrap() - before_ms;
    assert!((3000..4000).contains(&in_ms), "{in_ms} ms after the Move");
    assert_eq!(site.get("", "/api/monitors/M1").await.body["program"]["by"], "demo");
    operator.ask(json!({ "type": "stop", "monitor": "M1", "of": "Control" })).await;
    other.next_where(|it| it["set"].get(program) == Some(&Value::Null)).await;
}

#[tokio::test]
async fn on_a_shared_line_each_monitor_has_figures_of_its_own() {
    let site = Site::open(3).await;
    let mut socket = site.ws("").await;
    let link = |it: &Value| it["set"]["monitors/M2/link"].clone();
    let told = socket.next_where(|it| link(it)["last"]["sent"].as_u64() > Some(5)).await;
    let link = link(&told);
    let count = |name: &str| link[name].as_u64().unwrap();
    assert!(count("sent").abs_diff(count("received")) <= 3, "{link}");
    assert!(link["line"]["sent"].as_u64().unwrap() > 2 * count("sent"), "{link}");
    let path = "/api/history?monitor=M2&series=Link.sent,Link.rtt_ms";
    let began = Instant::now();
    loop {
        let body = site.get("", path).await.body;
        let filled = |name: &str| body["series"][name].as_array().is_some_and(|it| !it.is_empty());
        if filled("Link.sent") && filled("Link.rtt_ms") {
            break;
        }
        assert!(began.elapsed() < support::PATIENCE, "{body}");
        socket.next().await;
    }
    let listed = site.get("", "/api/history/series?monitor=M2").await.text;
    assert!(listed.contains("Link.timeouts"), "{listed}");
    let played = site.get("", "/api/history/changes?monitor=M2").await.text;
    assert!(!played.contains("Link."), "figures are no subsystem");
}

#[tokio::test]
async fn the_end_of_a_jog_names_its_beginning() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    hold_until(&mut operator, "Vertical", "max", || site.bus.commanded(0, 0) > 0).await;
    operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
    operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    let began = Instant::now();
    let ended = loop {
        let log = site.hub.audit().latest(None, 100, None, None).await.unwrap();
        let jogs: Vec<_> =
            log.into_iter().filter(|it| it.record.what == "jog Vertical max").collect();
        if let [ended, asked] = &jogs[..] {
            assert_eq!(asked.record.outcome, "asked");
            assert_eq!(ended.record.details["asked"], asked.n);
            break ended.clone();
        }
        assert!(began.elapsed() < support::PATIENCE, "{jogs:?}");
        operator.next().await;
    };
    assert_eq!(ended.record.outcome, "stopped");
}

#[tokio::test]
async fn parameters_are_read_once_and_waited_for_until_stored() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Engineer);
    let read = "/api/monitors/M1/params/read";
    let (one, two) =
        tokio::join!(site.post(&token, read, json!({})), site.post(&token, read, json!({})));
    for reply in [&one, &two] {
        assert_eq!(reply.body["reading"], false, "{reply:?}");
        assert!(reply.body["values"]["Vertical"]["Speed"]["values"].is_array(), "{reply:?}");
    }
    assert_eq!(one.body["at_ms"], two.body["at_ms"], "the second waits for the first");
    let progress = || {
        let topic = site.hub.topics().get("monitors/M1/params_progress").unwrap();
        serde_json::from_str::<Value>(topic.get()).unwrap()
    };
    let mut version = site.hub.topics().version();
    let mut seen = Vec::new();
    let reading = site.post(&token, read, json!({}));
    tokio::pin!(reading);
    loop {
        tokio::select! {
            _ = version.changed() => seen.push(progress()),
            _ = &mut reading => break,
        }
    }
    assert!(seen.iter().any(|it| it["total"].as_u64() > Some(50)), "{seen:?}");
    assert_eq!(progress(), Value::Null, "no client reads");

    let take = json!({ "action": "take" });
    assert_eq!(site.post(&token, "/api/monitors/M1/authority", take).await.status, 200);
    let authorization = format!("Bearer {token}");
    let headers = [("Authorization", authorization.as_str())];
    let path = "/api/monitors/M1/params/Vertical/Speed";
    let reply = site.http("PUT", path, &headers, r#"{"values":[5]}"#).await;
    assert_eq!((reply.status, &reply.body["saved"]), (200, &json!("stored")), "{reply:?}");
    let get = json!({ "request": "GetParam Vertical Speed" });
    let value = site.post(&token, "/api/monitors/M1/requests", get).await;
    assert_eq!(value.body["answers"][0]["values"]["values"], json!([5]), "{value:?}");
    let log = site.get(&token, "/api/audit?text=setparam%20vertical%20speed").await.body;
    let entries = log["entries"].as_array().unwrap();
    let answered: Vec<_> = entries.iter().filter(|it| it["details"]["saved"] == "stored").collect();
    assert_eq!(answered.len(), 1, "{log}");
    let reply = site.http("PUT", path, &headers, r#"{"values":[9999]}"#).await;
    assert_eq!((reply.status, reply.code()), (422, "refused"), "{reply:?}");
    assert!(reply.body["error"]["answers"][0]["status"].is_string());
}

#[tokio::test]
async fn a_parameter_is_stored_from_a_seat() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Engineer);
    let mut engineer = site.ws(&token).await;
    let set = json!({
        "type": "request", "monitor": "M1", "request": "SetParam Vertical Speed 5", "save": true,
    });
    let refused = engineer.ask(set.clone()).await;
    assert_eq!(refused["error"]["code"], "no_authority", "{refused}");
    engineer.authority("M1", "take").await;
    let set = engineer.ask(set).await;
    assert_eq!(set["result"]["saved"], "stored", "{set}");
    let log = site.get(&token, "/api/audit?text=setparam%20vertical%20speed").await.body;
    let entries = log["entries"].as_array().unwrap();
    let answered = |it: &&Value| it["details"]["saved"] == "stored";
    assert_eq!(entries.iter().filter(answered).count(), 1, "{log}");
    let moving = json!({
        "type": "request", "monitor": "M1", "request": "Move Vertical 600", "save": true,
    });
    let answer = engineer.ask(moving).await;
    assert_eq!(answer["error"]["code"], "bad_request", "what moves is not repeated: {answer}");
    assert_eq!(site.bus.commanded(0, 0), 0);
}

#[tokio::test]
async fn logs_are_searched_and_the_hub_tells_how_it_is() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    for number in 1..=3 {
        let what = lafet_hub::text::both(format!("Fire {number}"), format!("Пожар {number}"));
        site.hub.event(Some("M1"), &what);
    }
    let page = site.get("", "/api/events?text=%D0%BF%D0%BE%D0%B6%D0%B0%D1%80&limit=2").await.body;
    let texts: Vec<_> =
        page["events"].as_array().unwrap().iter().map(|it| &it["what"]["en"]).collect();
    assert_eq!(texts, [&json!("Fire 3"), &json!("Fire 2")]);
    let next = page["next"].as_u64().unwrap();
    let rest = site.get("", &format!("/api/events?text=fire&before={next}")).await.body;
    assert_eq!(
        (&rest["events"][0]["what"]["ru"], &rest["next"]),
        (&json!("Пожар 1"), &Value::Null)
    );
    assert_eq!(site.get("", "/api/events?limit=x").await.code(), "bad_request");

    socket.ask(json!({ "type": "stop" })).await;
    let found = site.get("", "/api/audit?text=STOP%20all&limit=1").await.body;
    assert_eq!(found["entries"][0]["what"], "Stop All", "{found}");
    assert!(found["next"].is_u64(), "{found}");
    let none = site.get("", "/api/audit?text=stop&to_ms=5").await.body;
    assert_eq!(none["entries"], json!([]));

    let crash = site.get("", "/api/monitors/M1/crash").await.body;
    assert_eq!((&crash["filled"], &crash["bits"]), (&json!(false), &json!([])), "{crash}");
    let state = site.get("", "/api/hub/state").await.body;
    assert_eq!(state["clients"]["websockets"], 1, "{state}");
    assert!(state["audit"]["entries"].as_u64().unwrap() >= 2, "{state}");
    assert_eq!(state["disk"]["audit_bytes"], Value::Null, "it is kept in memory");
    let began = Instant::now();
    while site.get("", "/api/hub/state").await.body["rates"]["polls_per_s"].as_f64() < Some(1.0) {
        assert!(began.elapsed() < support::PATIENCE);
        socket.next().await;
    }
}

#[tokio::test]
async fn who_is_signed_in_is_listed_and_can_be_signed_out() {
    let site = Site::with(1, |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let login = json!({ "user": "anna", "password": PASSWORD });
    let reply = site.post("", "/api/login", login).await;
    let cookie = reply.header("set-cookie").unwrap().split(';').next().unwrap().to_owned();
    let mut socket = site.ws_as(&[("Cookie", &cookie)]).await;
    let token = site.token(Role::Administrator);
    let mut machine = site.ws(&token).await;
    let list = site.get(&token, "/api/sessions").await.body;
    let of = |kind: &str| {
        list.as_array().unwrap().iter().find(|it| it["kind"] == kind).cloned().unwrap()
    };
    let anna = of("session");
    assert_eq!((&anna["user"], &anna["seats"][0]["from"]), (&json!("anna"), &json!("127.0.0.1")));
    assert!(anna["expires_ms"].as_u64() > anna["created_ms"].as_u64(), "{anna}");
    assert_eq!(
        (&of("token")["user"], &of("token")["own"]),
        (&json!("administrator"), &json!(true))
    );
    let authorization = format!("Bearer {token}");
    let headers = [("Authorization", authorization.as_str())];
    let place = format!("/api/sessions/{}", anna["id"].as_str().unwrap());
    assert_eq!(site.http("DELETE", &place, &headers, "").await.status, 204);
    assert_eq!(site.http("DELETE", &place, &headers, "").await.status, 404);
    let closed = socket.next_of("closed").await;
    assert_eq!(closed["code"], 4401);
    assert_eq!(site.http("GET", "/api/session", &[("Cookie", &cookie)], "").await.status, 401);
    machine.next_of("change").await;
    let operator = site.token(Role::Operator);
    assert_eq!(site.get(&operator, "/api/sessions").await.code(), "role");
}
