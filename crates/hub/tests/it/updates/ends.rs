//! Monitors that are not updated, and why.

use super::*;

/// The run ends at the first monitor that fails, and what is missing is named; nothing was locked out for it.
#[tokio::test]
async fn a_monitor_that_is_not_in_standby() {
    let mut full = monitor(1);
    full.composition = Composition::FULL;
    let site =
        at(Bus::of([full, monitor(2)].into_iter()).await, |config| config.login = false).await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    let command = async |request: &str| {
        site.post("", "/api/monitors/M1/authority", json!({ "action": "take" })).await;
        let body = json!({ "request": request });
        let reply = site.post("", "/api/monitors/M1/requests", body).await;
        assert_eq!(reply.status, 200, "{reply:?}");
        site.post("", "/api/monitors/M1/authority", json!({ "action": "release" })).await;
    };
    command("Deploy Deployer").await;
    let is_set = |flag| {
        let status = site.hub.station("M1").unwrap().status();
        status.is_set(SubsystemId::DEPLOYER, flag)
    };
    until("it is deployed", || is_set("Deployed")).await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("standby") && text(&run).contains("M1"), "{run:#}");
    assert!(!is_locked(&site, "M1") && runs(&site, 0).0 == OLD);
    // The other one by itself.
    let reply = start(&site, json!({ "images": [digest], "monitors": ["M2"] })).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    assert_eq!(states(&ended(&site).await), ["done"]);
    command("Open Valve1").await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    let why = text(&run["monitors"][0]);
    assert!(why.contains("Valve1") && why.contains("standby"), "{why}");
    let water = site.hub.station("M1").unwrap();
    until("its water is not shut off for an update", || water.status().flows()).await;
    command("Close Valve1").await;
    until("it is closed", || !water.status().flows()).await;
    command("Wrap Deployer").await;
    until("it is stowed", || is_set("Wrapped")).await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["done", "same"], "{run:#}");
}

/// It knows no update, or does not answer.
#[tokio::test]
async fn a_monitor_that_cannot_be_updated() {
    let plain = SimConfig { software: None, ..monitor(1) };
    let site =
        at(Bus::of([plain, monitor(2)].into_iter()).await, |config| config.login = false).await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("cannot be updated over its link"), "{run:#}");
    assert!(!is_locked(&site, "M1"));
    site.bus.silence(2);
    let reply = start(&site, json!({ "images": [digest], "monitors": ["M2"] })).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("answer"), "{run:#}");
}

/// The new program does not answer on trial: the old one runs again, locked out, and the run ends there.
#[tokio::test]
async fn an_image_that_does_not_work_goes_no_further() {
    let dead = SimConfig { software: Some(software(Trial::DeadLink)), ..monitor(1) };
    let site =
        at(Bus::of([dead, monitor(2)].into_iter()).await, |config| config.login = false).await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    begin(&site, &digest).await;
    until("it is on trial", || site.bus.lock()[0].running().is_some_and(|it| it.trial)).await;
    // Its 180 s pass.
    until("it goes back", || {
        let mut sims = site.bus.lock();
        sims[0].advance_ms(1_000);
        sims[0].running().is_some_and(|it| !it.trial)
    })
    .await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    let why = text(&run["monitors"][0]);
    assert!(why.contains("not kept") && why.contains("lockout"), "{why}");
    assert_eq!((runs(&site, 0), runs(&site, 1)), ((OLD, false), (OLD, false)));
    until("it is heard", || site.hub.station("M1").unwrap().health() == "up").await;
    assert!(is_locked(&site, "M1") && !is_locked(&site, "M2"));
    let log = acts(&site).await;
    let failed = ("update_monitor".to_owned(), "M1".to_owned(), "failed".to_owned());
    assert!(log.contains(&failed), "{log:?}");
}

/// What confirms an update cannot be noted: nothing is sent.
#[tokio::test]
async fn a_disk_that_takes_no_note() {
    let data = std::env::temp_dir().join(format!("lafet-no-note-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&data);
    let own = data.clone();
    let site = with(1, |config| (config.login, config.data) = (false, Some(own))).await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    std::fs::write(data.join("updates/words"), b"a file where the folder should be").unwrap();
    begin(&site, &digest).await;
    let run = ended(&site).await;
    let why = text(&run["monitors"][0]);
    assert!(why.contains("cannot be noted") && why.contains("lockout"), "{why}");
    assert!(run["monitors"][0]["stage"].is_null() && runs(&site, 0).0 == OLD, "{run:#}");
    // The image rots on the disk.
    std::fs::remove_file(data.join("updates/words")).unwrap();
    let file = data.join(format!("updates/images/{digest}.image"));
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[500] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    let reply = start(&site, json!({ "images": [digest] })).await;
    assert_eq!((reply.status, reply.code()), (400, "bad_request"), "{reply:?}");
    assert!(reply.text.contains("Remove it"), "{reply:?}");
    drop(site);
    _ = std::fs::remove_dir_all(&data);
}
