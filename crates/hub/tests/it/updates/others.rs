//! What others ask for while a monitor is updated.

use super::*;

/// Orders by hand are refused in words; Stop, Close and Lockout pass, and a lockout of another client stays.
#[tokio::test]
async fn others_may_stop_it_and_command_nothing() {
    let site = open(1).await;
    let digest = store(&site, &image(NEW, LARGE)).await;
    begin(&site, &digest).await;
    run_until(&site, "it sends", sends).await;
    let mut page = site.ws("").await;
    let second = start(&site, json!({ "images": [digest] })).await;
    assert_eq!((second.status, second.code()), (409, "update_runs"), "{second:?}");
    let removed = site.http("DELETE", &format!("/api/updates/images/{digest}"), &[], "").await;
    assert_eq!((removed.status, removed.code()), (409, "image_in_use"), "{removed:?}");
    for action in ["take", "request", "force"] {
        let answer = page.authority("M1", action).await;
        assert_eq!(answer["error"]["code"], "updating", "{answer}");
    }
    for request in ["Move Vertical 900", "Open Valve1", "SetParam Vertical Speed 5", "Restart All"]
    {
        let body = json!({ "request": request, "confirm": "M1" });
        let reply = site.post("", "/api/monitors/M1/requests", body).await;
        assert_eq!((reply.status, reply.code()), (409, "updating"), "{request}: {reply:?}");
        assert!(reply.body["error"]["en"].as_str().unwrap().contains("software"), "{reply:?}");
    }
    let tune = page.ask(json!({ "type": "tune", "monitor": "M1", "drive": "Vertical" })).await;
    assert_eq!(tune["error"]["code"], "updating", "{tune}");
    let read = json!({ "request": "GetStatus All" });
    assert_eq!(site.post("", "/api/monitors/M1/requests", read).await.status, 200);
    for path in ["stop", "close", "lockout"] {
        let reply = site.post("", &format!("/api/monitors/M1/{path}"), json!({})).await;
        // Under lockout a valve answers Close with Denied.
        assert!([200, 202, 422].contains(&reply.status), "{path}: {reply:?}");
    }
    assert_eq!(run_now(&site).await["state"], "running", "none of them ends it");
    let run = ended(&site).await;
    assert_eq!(states(&run), ["done"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("Another client"), "{run:#}");
    assert!(is_locked(&site, "M1") && is_still(&site), "that lockout is another's");
    assert_eq!(runs(&site, 0), (NEW, false));
    release(&site, "M1").await;
}

/// A lockout that was there before is not the run's.
#[tokio::test]
async fn a_lockout_of_before_stays() {
    let site = open(1).await;
    site.post("", "/api/monitors/M1/lockout", json!({})).await;
    until("it is locked out", || is_locked(&site, "M1")).await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(
        (states(&run), &run["monitors"][0]["text"]),
        (vec!["done"], &Value::Null),
        "{run:#}"
    );
    assert!(is_locked(&site, "M1"));
}

/// A run that is stopped ends before its next order; the next one goes on with what was received.
#[tokio::test]
async fn a_run_that_is_stopped_goes_on_later() {
    let site = open(2).await;
    let digest = store(&site, &image(NEW, LARGE)).await;
    begin(&site, &digest).await;
    let far = |run: &Value| run["monitors"][0]["done"].as_u64() > Some(20_000);
    run_until(&site, "it has sent much", far).await;
    let stopped = site.post("", "/api/updates/stop", json!({})).await;
    assert_eq!(stopped.status, 200, "{stopped:?}");
    let run = ended(&site).await;
    assert_eq!((states(&run), &run["state"]), (vec!["failed", "skipped"], &json!("ended")));
    assert!(text(&run).contains("Stopped by demo"), "{run:#}");
    let why = text(&run["monitors"][0]);
    assert!(why.contains("goes on with it") && why.contains("lockout"), "{why}");
    assert!(is_locked(&site, "M1") && !is_locked(&site, "M2"));
    let sent = run["monitors"][0]["done"].as_u64().unwrap();
    assert!((20_000..LARGE as u64).contains(&sent), "{run:#}");
    let stop = site.post("", "/api/updates/stop", json!({})).await;
    assert_eq!((stop.status, stop.code()), (404, "no_update"), "it has ended: {stop:?}");
    begin(&site, &digest).await;
    let first = run_until(&site, "it sends", |run| !run["monitors"][0]["done"].is_null()).await;
    let goes_on = first["monitors"][0]["done"].as_u64().unwrap();
    assert!(goes_on >= sent, "nothing is sent again: {goes_on} of {sent}");
    let run = ended(&site).await;
    assert_eq!(states(&run), ["done", "done"], "{run:#}");
    // The lockout of the first run was there before the second.
    assert!(is_locked(&site, "M1") && !is_locked(&site, "M2"));
    let log = acts(&site).await;
    assert_eq!(log.iter().filter(|it| it.0 == "stop_update").count(), 1, "{log:?}");
}

/// Who has started it is removed: nothing more is ordered in that name.
#[tokio::test]
async fn rights_that_are_revoked_end_the_run() {
    let site = with(1, |_| {}).await;
    let engineer = site.token(Role::Engineer);
    let digest = send(&site, &engineer, &image(NEW, LARGE)).await.body["digest"].clone();
    let (id, token) = site.hub.access().add_token(1, "late", Role::Engineer).unwrap();
    let body = json!({ "images": [digest], "pace": 100 });
    assert_eq!(site.post(&token, "/api/updates", body.clone()).await.status, 202);
    let now = async || site.get(&engineer, "/api/updates").await.body["run"].clone();
    let wait = async |wanted: &dyn Fn(&Value) -> bool| {
        let began = Instant::now();
        loop {
            let run = now().await;
            if wanted(&run) {
                return run;
            }
            assert!(began.elapsed() < RUN, "{run:#}");
            sleep(Duration::from_millis(20)).await;
        }
    };
    wait(&sends).await;
    site.hub.access().remove_token(id).unwrap();
    let run = wait(&|run| run["state"] != "running").await;
    assert_eq!((states(&run), &run["by"]), (vec!["failed"], &json!("late")), "{run:#}");
    assert!(text(&run).contains("rights of late"), "{run:#}");
    assert!(is_locked(&site, "M1") && runs(&site, 0) == (OLD, false));
    assert_eq!(site.post(&engineer, "/api/updates", body).await.status, 202);
    let run = wait(&|run| run["state"] != "running").await;
    assert_eq!((states(&run), runs(&site, 0)), (vec!["done"], (NEW, false)), "{run:#}");
}
