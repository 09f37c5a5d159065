//! Where jets go and how high to aim, as the hub answers over HTTP.

use crate::support::Site;
use lafet_sim::fault::{Fault, SingleFault};
use serde_json::{Value, json};

/// General of the first monitor, as soon as it is as wanted.
async fn general_of(site: &Site, wanted: impl Fn(&Value) -> bool) -> Value {
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    let general = |known: &serde_json::Map<String, Value>| {
        known["monitors/M1/status"]["subsystems"]["General"].clone()
    };
    socket.until("the pressure", |known| wanted(&general(known))).await;
    general(&socket.known)
}

#[tokio::test]
async fn a_jet_is_computed_from_what_is_given_and_what_the_monitor_has() {
    let site = Site::open(1).await;
    let given = json!({ "monitor": "M1", "pressure_datm": 79, "elevation_arcmin": 900 });
    let reply = site.post("", "/api/jets", json!({ "jets": [given, { "monitor": "M1" }] })).await;
    let [given, live] = &reply.body.as_array().expect("answers")[..] else { panic!("{reply:?}") };
    assert_eq!(
        (&given["nozzle_mm"], &given["diameter_dmm"], &given["height_cm"]),
        (&json!(60), &json!(280), &json!(150)),
        "{given}"
    );
    let lands = given["flight"]["lands_m"].as_f64().unwrap();
    assert!((35.0..45.0).contains(&lands), "{given}");
    assert!(given["reach_m"].as_f64().unwrap() >= lands);
    // Beside it, where the water is expected, with its band; the wind is not known.
    let metres = |figure: &str, end: &str| given["throw"][figure][end].as_f64().unwrap();
    let (near, far) = (metres("middle_m", "low"), metres("greatest_m", "high"));
    assert!(near < metres("middle_m", "value") && metres("greatest_m", "value") < far, "{given}");
    assert!(near < lands && lands < far && far - near < lands / 2.0, "{given}");
    assert_eq!((&given["throw"]["wind"], &given["no_throw"]), (&Value::Null, &Value::Null));
    // Nothing flows: the valve is closed.
    assert_eq!((&live["fault"], &live["flight"]), (&json!("pressure"), &Value::Null), "{live}");
    assert_eq!((&live["no_throw"], &live["throw"]), (&json!("pressure"), &Value::Null), "{live}");
    for wrong in [json!({ "jets": [{}] }), json!({ "jets": vec![json!({}); 17] })] {
        assert_eq!(site.post("", "/api/jets", wrong).await.status, 400);
    }
    let unknown = site.post("", "/api/jets", json!({ "jets": [{ "monitor": "M9" }] })).await;
    assert_eq!(unknown.status, 404);
}

/// A pressure that its sensor does not measure is bad wherever it is shown, and nothing is aimed by
/// it; the operator may assume one.
#[tokio::test]
async fn nothing_is_aimed_by_a_broken_sensor() {
    let site = Site::open(1).await;
    let place = json!({ "way_m": 28.0, "rise_m": -1.5 });
    let aim = async |more: Value| {
        let mut body = place.clone();
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        site.post("", "/api/monitors/M1/aim", body).await.body
    };
    assert_eq!(aim(json!({})).await["fault"], "pressure");
    site.bus.lock()[0].world_mut().inject(Fault::Single(SingleFault::PressureBreak));
    let general = general_of(&site, |general| general["bad"]["pressure"].is_string()).await;
    assert_eq!(general["bad"]["pressure"], "PressureSensorBreak");
    let refused = aim(json!({})).await;
    assert_eq!(refused["fault"], "pressure_unknown");
    assert_eq!(refused["elevation_arcmin"], Value::Null);
    let assumed = aim(json!({ "pressure_datm": 79 })).await;
    assert!(assumed["elevation_arcmin"].as_i64().is_some_and(|it| it > 0), "{assumed}");
    assert_eq!(assumed["pressure_datm"], 79);
}
