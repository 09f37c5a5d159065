//! With GStreamer's RTSP server (`cargo xtask plugs`): what a camera may do, and what is said of it.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::proxy::{Proxy, Spoil};
use super::site::{Camera, Site, Viewer, children_of, pause, signal, until};

/// A picture that is dead or frozen is said to be so within this time.
const SAID: Duration = Duration::from_secs(2);
/// What a busy machine takes for a request, beside that.
const BUSY: Duration = Duration::from_millis(700);

/// Pictures of High profile with B-frames reach a viewer as they are, the first with what a decoder needs.
#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn a_camera_is_seen() {
    let camera = Camera::start("high", "-");
    let site = Site::open("seen", Some(&camera.place()), "");
    println!("plays after {:?}", site.comes_to("playing"));
    let began = Instant::now();
    let mut viewer = Viewer::open(&site);
    let first = viewer.next();
    println!("first picture of a viewer after {:?}", began.elapsed());
    assert!(first.key && first.codec.starts_with("avc1.64") && first.size == (640, 360));
    assert_eq!((&first.data[..4], first.data[4] & 0x1F), (&[0, 0, 0, 1][..], 7), "its sets first");
    let mut all = vec![first];
    while all.len() < 150 {
        all.push(viewer.next());
    }
    assert!(all.windows(2).all(|it| it[1].number == it[0].number + 1), "without a gap");
    let back = all.windows(2).filter(|it| it[1].shown_us < it[0].shown_us).count();
    assert!(back > 20, "B-frames are sent after what they depend on: {back}");
    assert!(all.iter().filter(|it| it.key).count() >= 4);
    let last = all.last().unwrap();
    let rate = 149e6 / (last.shown_us - all[0].shown_us) as f64;
    assert!((rate - 25.0).abs() < 2.0, "{rate} pictures a second");
    // The camera's clock is that of this machine.
    #[expect(clippy::disallowed_methods, reason = "the date of a picture")]
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis() as i64;
    let captured = (last.captured_us.expect("a sender report") / 1000) as i64;
    println!("captured {} ms ago, came {} ms ago", now - captured, now - last.at_ms as i64);
    assert!((now - captured).abs() < 3000 && (now - last.at_ms as i64).abs() < 3000);
}

#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn a_wrong_password_is_said_and_no_answer_has_one() {
    let camera = Camera::start("baseline", "viewer:geheim-1");
    let wrong =
        Site::open("wrong", Some(&camera.place()), "user = \"viewer\"\npassword = \"geheim-2\"\n");
    wrong.comes_to("failed");
    let seen = wrong.camera();
    assert!(seen["why"]["en"].as_str().unwrap().contains("refuses user or password"), "{seen}");
    let right =
        Site::open("right", Some(&camera.place()), "user = \"viewer\"\npassword = \"geheim-1\"\n");
    right.comes_to("playing");
    for (site, path) in
        [(&wrong, "/api/cameras"), (&right, "/api/cameras"), (&right, "/api/hub/state")]
    {
        let (_, body, _) = site.ask("GET", path);
        assert!(!body.contains("geheim") && !body.contains("rtsp:"), "{body}");
    }
    // Nor do other users of the machine see it.
    let process = right.process().expect("it runs");
    for file in ["cmdline", "environ"] {
        let text = std::fs::read(format!("/proc/{process}/{file}")).unwrap();
        assert!(!String::from_utf8_lossy(&text).contains("geheim"), "{file}");
    }
}

/// The camera stalls, goes on, ends, and is there again.
#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn a_camera_that_stalls_or_ends_is_said_and_comes_back() {
    let camera = Camera::start("baseline", "-");
    let port = camera.port();
    let site = Site::open("back", Some(&camera.place()), "");
    site.comes_to("playing");
    camera.signal("STOP");
    let frozen = site.comes_to("frozen");
    println!("frozen is said after {frozen:?}");
    assert!(frozen < SAID + BUSY, "{frozen:?}");
    camera.signal("CONT");
    println!("plays again after {:?}", site.comes_to("playing"));
    drop(camera);
    let gone = site.comes_to("failed");
    println!("the end is said after {gone:?}");
    assert!(gone < SAID + BUSY, "{gone:?}");
    let camera = Camera::at(port, "baseline", "-");
    println!("plays {:?} after the restart", site.comes_to("playing"));
    drop(camera);
}

#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn a_process_that_is_killed_or_hangs_is_started_again_and_none_outlives_the_hub() {
    let camera = Camera::start("baseline", "-");
    let mut site = Site::open("killed", Some(&camera.place()), "");
    site.comes_to("playing");
    let first = site.process().expect("it runs");
    signal(first, "KILL");
    site.comes_to("failed");
    println!("plays {:?} after its process was killed", site.comes_to("playing"));
    let second = site.process().expect("it runs");
    assert_ne!(first, second);
    signal(second, "STOP");
    println!("said after {:?} that its process hangs", site.comes_to("failed"));
    println!("plays again after {:?}", site.comes_to("playing"));
    let third = site.process().expect("it runs");
    assert!(!children_of(site.hub.child.id()).contains(&second), "the one that hung is gone");
    // Without a farewell.
    site.hub.child.kill().unwrap();
    site.hub.child.wait().unwrap();
    let began = Instant::now();
    until("its process ends with the hub", || {
        !std::path::Path::new(&format!("/proc/{third}")).exists()
    });
    println!("its process ends {:?} after the hub", began.elapsed());
}

/// Packets are lost on the way: pictures go on, and the losses are counted.
#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn lost_packets_are_counted_and_the_picture_goes_on() {
    let camera = Camera::start("high", "-");
    let proxy = Proxy::to(&camera.place(), Spoil::Lose);
    let site = Site::open("lost", Some(&proxy.place), "");
    site.comes_to("playing");
    let mut viewer = Viewer::open(&site);
    let mut seen = 0;
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(10) {
        viewer.next();
        seen += 1;
    }
    let camera = site.camera();
    println!("{seen} pictures in 10 s; {camera}");
    assert!(seen > 150 && camera["packets_lost"].as_u64().unwrap() > 0, "{seen} {camera}");
    assert_eq!(camera["starts"], 1, "the process goes on");
}

/// Whatever a camera sends, the hub goes on, Stop is as quick as without a camera, and a sound stream plays again.
#[test]
#[ignore = "needs GStreamer: cargo xtask plugs"]
fn malformed_streams_end_no_hub_and_delay_no_stop() {
    // One after the other, so that both have the same machine.
    let stops = |site: &Site, other: &Site, time: Duration| {
        let (mut all, began) = (Vec::new(), Instant::now());
        while began.elapsed() < time {
            all.push((site.stop(), other.stop()));
            pause(Duration::from_millis(25));
        }
        all
    };
    let p99 = |mut all: Vec<Duration>| {
        all.sort();
        all[(all.len() * 99 / 100).min(all.len() - 1)]
    };
    let camera = Camera::start("baseline", "-");
    let without = Site::open("without", None, "");
    let proxy = Proxy::to(&camera.place(), Spoil::Nothing);
    let site = Site::open("malformed", Some(&proxy.place), "");
    let hub = site.hub.child.id();
    let mut all = Vec::new();
    for spoil in Spoil::MALFORMED {
        proxy.now(Spoil::Nothing);
        let again = site.comes_to("playing");
        proxy.now(spoil);
        // One that began well is corrupted, and one from its beginning.
        all.extend(stops(&site, &without, Duration::from_millis(1500)));
        if let Some(process) = site.process() {
            signal(process, "KILL");
        }
        all.extend(stops(&site, &without, Duration::from_millis(2500)));
        let now = site.camera();
        println!("{spoil:?}: {} {} (played after {again:?})", now["state"], now["why"]["en"]);
        assert!(std::path::Path::new(&format!("/proc/{hub}")).exists());
    }
    proxy.now(Spoil::Nothing);
    site.comes_to("playing");
    let (with, usual): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    let (count, with, usual) = (with.len(), p99(with), p99(usual));
    println!("{count} Stops: p99 {with:?}; without a camera {usual:?}");
    assert!(with < usual * 3 + Duration::from_millis(50), "{with:?}, without a camera {usual:?}");
}
