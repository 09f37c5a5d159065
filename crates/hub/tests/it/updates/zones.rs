//! Monitors that a zone needs.

use lafet_hub::{Overrides, ZonesConfig};

use super::*;

/// A zone with two monitors and one detector.
fn hall() -> ZonesConfig {
    let mut text = String::new();
    for number in 1..=2 {
        text += &format!("[[monitor]]\nid = \"M{number}\"\nurl = \"tcp://h?addr={number}\"\n");
        text += &format!(
            "[[aim]]\nzone = \"hall\"\nmonitor = \"M{number}\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n"
        );
    }
    text += "[[detector]]\nid = \"flame\"\nkind = \"flame\"\nzones = [\"hall\"]\nsilent_after_s = 3600\n\
             [[zone]]\nid = \"hall\"\nvotes = \"1oo1\"\none_detector_releases = true\nwater_max_s = 600\nmonitors = [\"M1\", \"M2\"]\ndelay_s = 60\n";
    let read = Config::parse("hub.toml", &text, std::path::Path::new("/"), &Overrides::default());
    read.unwrap_or_else(|problems| panic!("{problems:#?}")).zones.expect("zones")
}

async fn quiet() -> Site {
    let site = with(2, |config| (config.login, config.zones) = (false, Some(hall()))).await;
    sees(&site, "quiet").await;
    site
}

async fn sees(site: &Site, signal: &str) {
    let reply = site.post("", "/api/detectors/flame", json!({ "signal": signal })).await;
    assert_eq!(reply.status, 204, "{reply:?}");
}

async fn phase(site: &Site) -> Value {
    site.get("", "/api/zones").await.body["state"]["zones"][0]["phase"].clone()
}

/// One of two monitors of a zone is out of service: the other one is not updated.
#[tokio::test]
async fn a_zone_keeps_a_monitor() {
    let site = quiet().await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    site.post("", "/api/monitors/M2/lockout", json!({})).await;
    until("it is locked out", || is_locked(&site, "M2")).await;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    let why = text(&run["monitors"][0]);
    assert!(why.contains("M2 is locked out") && why.contains("hall"), "{why}");
    assert!(!is_locked(&site, "M1") && runs(&site, 0).0 == OLD);
    // The one that is out of service anyway may be, but its lockout stays: so does the first one as it is.
    let reply =
        start(&site, json!({ "images": [digest], "monitors": ["M2", "M1"], "pace": 100 })).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let run = ended(&site).await;
    assert_eq!(states(&run), ["done", "failed"], "{run:#}");
    assert_eq!((runs(&site, 0).0, runs(&site, 1).0), (OLD, NEW));
    release(&site, "M2").await;
    site.bus.silence(2);
    until("it is missed", || site.hub.station("M2").unwrap().health() != "up").await;
    let reply = start(&site, json!({ "images": [digest], "monitors": ["M1"] })).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let run = ended(&site).await;
    assert!(text(&run["monitors"][0]).contains("M2 does not answer"), "{run:#}");
}

/// Both are updated, never both at once; the zone is quiet all the while.
#[tokio::test]
async fn both_monitors_of_a_zone_one_after_the_other() {
    let site = quiet().await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    begin(&site, &digest).await;
    let mut seen = Vec::new();
    let run = loop {
        seen.push([is_locked(&site, "M1"), is_locked(&site, "M2")]);
        let run = run_now(&site).await;
        if run["state"] != "running" {
            break run;
        }
        sleep(Duration::from_millis(5)).await;
    };
    assert_eq!(states(&run), ["done", "done"], "{run:#}");
    assert!(!seen.contains(&[true, true]), "{seen:?}");
    assert!(seen.contains(&[true, false]) && seen.contains(&[false, true]), "{seen:?}");
    assert_eq!(phase(&site).await, "quiet", "a lockout of the run is no order to the zone");
}

/// A detector alarms before the run, and in the middle of it.
#[tokio::test]
async fn an_alarm_comes_first() {
    let site = quiet().await;
    let digest = store(&site, &image(NEW, LARGE)).await;
    begin(&site, &digest).await;
    run_until(&site, "it sends", sends).await;
    sees(&site, "alarm").await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    assert!(text(&run).contains("hall"), "{run:#}");
    let why = text(&run["monitors"][0]);
    assert!(why.contains("goes on with it") && why.contains("release it"), "{why}");
    assert!(is_locked(&site, "M1"));
    // It can be released at once, for the fire: then the zone has it.
    release(&site, "M1").await;
    let began = Instant::now();
    loop {
        let authority = site.get("", "/api/monitors/M1").await.body["authority"].clone();
        if authority["holder"]["seat"] == "zones" {
            break;
        }
        assert!(began.elapsed() < Duration::from_secs(20), "{authority:#}");
        sleep(Duration::from_millis(20)).await;
    }
    let reply = start(&site, json!({ "images": [digest] })).await;
    assert_eq!((reply.status, reply.code()), (409, "held"), "{reply:?}");
    assert!(!is_locked(&site, "M1"));
}

/// A detector alarms in a zone that is in manual: it takes no monitor, and none is updated.
#[tokio::test]
async fn a_zone_that_is_not_quiet() {
    let site = quiet().await;
    let digest = store(&site, &image(NEW, SMALL)).await;
    let manual = json!({ "mode": "manual" });
    assert_eq!(site.post("", "/api/zones/hall/mode", manual).await.status, 200);
    sees(&site, "alarm").await;
    assert_eq!(phase(&site).await, "alarm");
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed", "skipped"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("not quiet"), "{run:#}");
    assert!(!is_locked(&site, "M1") && runs(&site, 0).0 == OLD);
}
