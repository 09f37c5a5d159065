//! Which monitor on which fire, end to end.

use lafet_hub::site::keep_out::{KeepOut, KeptFor};
use lafet_place::supply::Supply;

use super::*;

/// Detectors that see the fires A and B from three places each, and monitors in a row.
struct Yard {
    monitors: &'static [[f64; 2]],
    keep_outs: Vec<KeepOut>,
    keys: &'static str,
    /// The pump: flow, l/min, and pressure, MPa; where none is given it is as the monitors measure.
    pump: &'static [[f64; 2]],
}

const FIRE_A: [f64; 2] = [-14.0, 24.0];
const FIRE_B: [f64; 2] = [16.0, 26.0];
const STATIONS: [[f64; 3]; 3] = [[-40.0, 0.0, 6.0], [40.0, -3.0, 6.0], [2.0, 60.0, 6.0]];

impl Yard {
    fn zones(&self) -> ZonesConfig {
        let mut text = String::new();
        let ids: Vec<String> = (1..=self.monitors.len()).map(|it| format!("\"M{it}\"")).collect();
        for (number, id) in (1..).zip(&ids) {
            text += &format!("[[monitor]]\nid = {id}\nurl = \"tcp://h?addr={number}\"\n");
            text += &format!("[[aim]]\nzone = \"yard\"\nmonitor = {id}\n");
            text += "horizontal = 6000\nvertical = 300\nnozzle = 60\n";
        }
        for (number, fire) in (0..3).flat_map(|number| [(number, "A"), (number, "B")]) {
            let [east, north, up] = STATIONS[number];
            text += &format!("[[detector]]\nid = \"{fire}{number}\"\nkind = \"flame\"\n");
            text +=
                &format!("zones = [\"yard\"]\nsilent_after_s = 60\nat = [{east}, {north}, {up}]\n");
        }
        let (ids, keys) = (ids.join(", "), self.keys);
        text += "[[zone]]\nid = \"yard\"\nvotes = \"2oo6\"\nwater_max_s = 600\n";
        text += &format!("monitors = [{ids}]\n{keys}\n");
        let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
        read.unwrap_or_else(|problems| panic!("{problems:#?}")).zones.expect("zones")
    }

    /// The hub, quiet and ready.
    async fn open(self) -> Site {
        let zones = self.zones();
        let place = |at: &[f64; 2]| Place { at: *at, heading: 0.0, height: 2.0 };
        let monitors = (1..).zip(self.monitors).map(|(n, at)| (format!("M{n}"), place(at)));
        let (monitors, keep_outs) = (monitors.collect(), self.keep_outs);
        let map = lafet_hub::site::Site { monitors, keep_outs, ..Default::default() };
        let count = u8::try_from(self.monitors.len()).unwrap();
        let site = Site::of((count, Composition::REMOTE), Clock::System, |config| {
            (config.login, config.zones, config.site) = (false, Some(zones), Some(map));
            config.plan.supply = Supply::curve(self.pump).ok();
        })
        .await;
        for number in 0..3 {
            for fire in ["A", "B"] {
                assert_eq!(sees(&site, &format!("{fire}{number}"), "quiet").await.status, 204);
            }
        }
        until_state(&site, "it is ready", |zone| zone["ready"] == true).await;
        site
    }
}

/// Its three detectors see a fire.
async fn burns(site: &Site, fire: &str, at: [f64; 2]) {
    for (number, [east, north, _]) in STATIONS.iter().enumerate() {
        let bearing = (at[0] - east).atan2(at[1] - north).to_degrees().rem_euclid(360.0);
        sees_at(site, &format!("{fire}{number}"), bearing).await;
    }
}

/// Which of the two fires each monitor is assigned to.
async fn assigned(site: &Site) -> Vec<(String, char)> {
    let assigned = site.get("", "/api/zones").await.body["assigned"].clone();
    let of = |it: &Value| {
        let fire = if it["at"][0].as_f64().unwrap() < 0.0 { 'A' } else { 'B' };
        (it["monitor"].as_str().unwrap().to_owned(), fire)
    };
    assigned.as_array().unwrap().iter().map(of).collect()
}

async fn until_assigned(site: &Site, expected: &[(&str, char)]) {
    let expected: Vec<(String, char)> = expected.iter().map(|it| (it.0.into(), it.1)).collect();
    let began = Instant::now();
    loop {
        let found = assigned(site).await;
        if found == expected {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(15), "{found:?}, expected {expected:?}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// The direction of a fire from a monitor that looks north, arc-minutes.
fn azimuth(from: [f64; 2], fire: [f64; 2]) -> i64 {
    ((from[0] - fire[0]).atan2(fire[1] - from[1]).to_degrees() * 60.0).round() as i64
}

async fn until_aimed(site: &Site, monitor: &str, azimuth: i64) {
    let at = || {
        let status = site.hub.station(monitor).unwrap().status();
        status.valid(SubsystemId::HORIZONTAL, "position").unwrap()
    };
    until("it points there", || (at() - azimuth).abs() <= 150).await;
}

const ROW: &[[f64; 2]] = &[[-15.0, 0.0], [15.0, 0.0], [0.0, -4.0]];

/// Two fires, three monitors, one is lost: the third takes its fire, and stays there when it is out.
#[tokio::test]
async fn each_fire_has_its_monitor_and_a_lost_one_is_replaced_at_its_fire() {
    let yard = Yard {
        monitors: ROW,
        keep_outs: vec![],
        keys: "coincidence_s = 0\ndelay_s = 3\njets = 2",
        pump: &[],
    };
    let site = yard.open().await;
    burns(&site, "A", FIRE_A).await;
    burns(&site, "B", FIRE_B).await;
    until_assigned(&site, &[("M1", 'A'), ("M2", 'B')]).await;
    until("both open", || is_open(&site, "M1") && is_open(&site, "M2")).await;
    until_aimed(&site, "M1", azimuth(ROW[0], FIRE_A)).await;
    until_aimed(&site, "M2", azimuth(ROW[1], FIRE_B)).await;
    assert!(is_closed(&site, "M3"), "two jets were asked for");
    let mut frames = site.hub.station("M3").unwrap().client().unwrap().trace();
    let began = Instant::now();
    site.bus.silence(2);
    loop {
        let Ok(frame) = frames.recv().await else { continue };
        let mut records = Records::new(&frame.payload).map_while(Result::ok);
        if frame.dst == 3 && records.any(|it| it.request == RequestId::START_QUENCH) {
            break;
        }
    }
    let took = began.elapsed();
    println!("from the loss to the next command: {took:?}");
    assert!(took <= Duration::from_secs(2), "{took:?}");
    until_assigned(&site, &[("M1", 'A'), ("M3", 'B')]).await;
    until("it opens", || is_open(&site, "M3")).await;
    until_aimed(&site, "M3", azimuth(ROW[2], FIRE_B)).await;
    for number in 0..3 {
        assert_eq!(sees(&site, &format!("B{number}"), "quiet").await.status, 204);
    }
    // Detectors repeat what they see. Its fire is out, and its water stays where it is.
    for _ in 0..40 {
        burns(&site, "A", FIRE_A).await;
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    until_aimed(&site, "M3", azimuth(ROW[2], FIRE_B)).await;
    assert!(is_open(&site, "M1") && is_open(&site, "M3"));
}

/// M2 is nearer to B, but would throw over a stand.
#[tokio::test]
async fn a_monitor_with_a_keep_out_before_the_fire_is_not_chosen() {
    let stand = KeepOut {
        name: "stand".into(),
        of: KeptFor::People,
        monitor: Some("M2".into()),
        bearings: [350.0, 15.0],
        elevations: [-90.0, 90.0],
    };
    let yard = Yard {
        monitors: ROW,
        keep_outs: vec![stand],
        keys: "coincidence_s = 0\ndelay_s = 2\njets = 1",
        pump: &[],
    };
    let site = yard.open().await;
    burns(&site, "B", FIRE_B).await;
    until_assigned(&site, &[("M3", 'B')]).await;
    until("it opens", || is_open(&site, "M3")).await;
    assert!(is_closed(&site, "M2") && is_closed(&site, "M1"));
}

/// The monitor that throws with the wind reaches the fire, the other one does not.
#[tokio::test]
async fn the_wind_chooses_the_monitor() {
    const ACROSS: &[[f64; 2]] = &[[-14.0, -26.0], [-14.0, 74.0]];
    let yard = Yard {
        monitors: ACROSS,
        keep_outs: vec![],
        keys: "coincidence_s = 0\ndelay_s = 60\njets = 1",
        pump: &[],
    };
    let site = yard.open().await;
    for (from_deg, monitor) in [(180, "M1"), (0, "M2"), (180, "M1")] {
        let wind = json!({ "from_deg": from_deg, "speed_mps": 14 });
        assert_eq!(site.post("", "/api/wind", wind).await.status, 204);
        burns(&site, "A", FIRE_A).await;
        until_assigned(&site, &[(monitor, 'A')]).await;
    }
    assert_eq!(site.get("", "/api/zones").await.body["wind"]["speed_mps"], 14.0);
}

/// The pump gives enough for one jet that reaches the fire: votes open one, a hand opens the others too.
#[tokio::test]
async fn votes_open_only_what_the_water_suffices_for() {
    let yard = Yard {
        monitors: ROW,
        keep_outs: vec![],
        keys: "coincidence_s = 0\ndelay_s = 1",
        pump: &[[0.0, 0.85], [1200.0, 0.8], [1210.0, 0.0]],
    };
    let site = yard.open().await;
    burns(&site, "B", [16.0, 34.0]).await;
    until_assigned(&site, &[("M2", 'B')]).await;
    let view = site.get("", "/api/zones").await.body;
    let out = ["M1", "M3"].map(|it| json!({ "zone": "yard", "monitor": it }));
    assert_eq!(view["left_out"], json!(out), "{view:#}");
    until("it opens", || is_open(&site, "M2")).await;
    let shut = || is_closed(&site, "M1") && is_closed(&site, "M3");
    assert!(stays(Duration::from_secs(2), shut).await, "the water does not suffice for them");
    let released = order(&site, "yard/release", json!({ "confirm": "yard" })).await;
    assert_eq!(released.status, 200, "{released:?}");
    until("a hand opens them", || is_open(&site, "M1") && is_open(&site, "M3")).await;
}
