//! `lafet scan` and `lafet doctor` on simulated monitors over TCP.

use std::io::{Read, Write};
use std::net::TcpListener;

use crate::support::{Run, Sim};
use serde_json::json;

/// A peer that answers anything with these bytes, until the test ends.
fn peer(answer: &'static [u8]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            std::thread::spawn(move || {
                let mut stream = stream;
                let mut buffer = [0; 512];
                while let Ok(1..) = stream.read(&mut buffer) {
                    if stream.write_all(answer).is_err() {
                        return;
                    }
                }
            });
        }
    });
    url
}

#[test]
fn a_bus_is_scanned() {
    let sim = Sim::start(&["--addr", "7"]);
    let quick = ["scan", "--addresses", "5-9", "--wait", "50"];
    let found = sim.value(&quick);
    let devices = found["devices"].as_array().unwrap();
    assert_eq!(devices.len(), 1, "{found}");
    assert_eq!((&devices[0]["address"], &devices[0]["doubled"]), (&json!(7), &json!(false)));
    assert!(devices[0]["subsystems"].as_array().unwrap().contains(&json!("Deployer")));
    let url = devices[0]["url"].as_str().unwrap();
    assert_eq!(Run::of(&["-c", url, "status", "general"]).code, 0, "{url}");
    let run = sim.done(&quick);
    assert!(run.out.contains("addr=7") && run.out.contains("monitor"), "{run:?}");
    let run = sim.run(&["scan", "--addresses", "1-3", "--wait", "20"]);
    assert!(run.code == 1 && run.out.contains("lafet doctor"), "{run:?}");
    assert_eq!(sim.run(&["scan", "--addresses", "0-3"]).code, 2);
    let records = format!("{}?framing=records", sim.url());
    assert_eq!(Run::of(&["-c", &records, "scan"]).code, 2);
}

#[test]
fn a_network_is_scanned() {
    let places = ["tcp://127.0.0.1:0", "tcp://127.0.0.1:0?framing=records", "udp://127.0.0.1:0"];
    let sim = Sim::listening(&places, &[]);
    let port = |url: &str| {
        let place = url.split('?').next().unwrap();
        place.rsplit(':').next().unwrap().to_owned()
    };
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let silent = port(&peer(b""));
    let ports = format!("{},{},{closed},{silent}", port(sim.url()), port(&sim.urls[1]));
    let scan = ["--json", "scan", "127.0.0.1-1", "--addresses", "1-2", "--wait", "60", "--port"];
    let run = Run::of(&[&scan[..], &[&ports]].concat());
    let all = run.json()[0].as_array().unwrap().clone();
    assert_eq!((run.code, all.len()), (0, 3), "{run:?}");
    assert!(all.iter().any(|one| one["address"] == 1), "{run:?}");
    assert!(all.iter().any(|one| one["framing"] == "records"), "{run:?}");
    assert!(all.iter().any(|one| one["silent"] == true), "{run:?}");
    let run = Run::of(&[&scan[..], &[&port(&sim.urls[2]), "--udp"]].concat());
    assert!(run.out.contains("udp://127.0.0.1"), "{run:?}");
    let run = Run::of(&["scan", "127.0.0.1", "--port", &closed.to_string()]);
    assert!(run.code == 1 && run.out.contains("No open port"), "{run:?}");
    for wrong in ["10.0.0.0/8", "a b"] {
        assert_eq!(Run::of(&["scan", wrong]).code, 2, "{wrong}");
    }
}

const QUICK: &[&str] = &["--listen", "0.1", "--requests", "5", "--wait", "30"];

fn doctor(url: &str) -> (i32, serde_json::Value) {
    let run = Run::of(&[&["--json", "doctor", url][..], QUICK].concat());
    (run.code, run.json().swap_remove(0))
}

#[test]
fn a_good_link_and_what_the_monitor_itself_reports() {
    let sim = Sim::start(&[]);
    let (code, told) = doctor(sim.url());
    assert_eq!((code, &told["findings"][0]["finding"]), (0, &json!("well")), "{told}");
    let run = sim.done(&[&["--lang", "ru", "doctor"][..], QUICK].concat());
    assert!(run.out.contains("Ствол отвечает") && run.out.contains("5 из 5"), "{run:?}");
    // §3.19: afterwards the parameters are unset, which is not a fault of the link.
    sim.done(&["send", "CleanFlash General"]);
    let told = (0..100)
        .map(|_| doctor(sim.url()).1)
        .find(|told| told["monitor"].as_array().is_some_and(|all| !all.is_empty()));
    let told = told.expect("the monitor restarts and reports it");
    assert!(told.to_string().contains("ConfigInvalid"), "{told}");
}

#[test]
fn a_bad_link_is_reported_with_evidence_and_remedy() {
    let sim = Sim::start(&["--addr", "9"]);
    let (code, told) = doctor(sim.url());
    assert_eq!((code, &told["findings"][0]["finding"]), (1, &json!("wrong-address")), "{told}");
    assert!(told["findings"][0]["remedy"].as_str().unwrap().contains("addr=9"), "{told}");
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (code, told) = doctor(&format!("tcp://{closed}"));
    assert_eq!((code, &told["findings"][0]["finding"]), (1, &json!("no-link")), "{told}");
    let (code, told) = doctor(&peer(b"220 mail.example ESMTP\r\n"));
    assert_eq!((code, &told["findings"][0]["finding"]), (1, &json!("other-protocol")), "{told}");
    assert!(told["findings"][0]["seen"].as_str().unwrap().contains("220 mail"), "{told}");
    assert_eq!(Run::of(&["doctor"]).code, 2);
}

/// §C/3: the framing in the URL is not that of the port.
#[test]
fn a_link_of_another_framing() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0", "tcp://127.0.0.1:0?framing=records"], &[]);
    let bare = sim.urls[1].split('?').next().unwrap();
    let (code, told) = doctor(bare);
    assert_eq!((code, &told["findings"][0]["finding"]), (1, &json!("other-framing")), "{told}");
    assert_eq!(doctor(&sim.urls[1]).1["findings"][0]["finding"], "well");
    let (code, told) = doctor(&format!("{}?framing=records", sim.url()));
    assert_eq!((code, &told["findings"][0]["finding"]), (1, &json!("other-framing")), "{told}");
}

/// Behind a serial server there may be a bus with a controller: the place is listened to before
/// anything is sent.
#[test]
fn a_network_is_listened_to_before_it_is_scanned() {
    use lafet_proto::link::{Frame, WIRE_MAX, encode};
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port().to_string();
    let (heard, hears) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().map_while(Result::ok) {
            let mut wire = [0; WIRE_MAX];
            let payload = &[];
            let len = encode(&Frame { dst: 1, src: 128, payload }, &mut wire).unwrap();
            let (mut talks, heard) = (stream.try_clone().unwrap(), heard.clone());
            std::thread::spawn(move || {
                let mut buffer = [0; 64];
                while let Ok(count @ 1..) = stream.read(&mut buffer) {
                    heard.send(buffer[..count].to_vec()).unwrap();
                }
            });
            std::thread::spawn(move || {
                while talks.write_all(&wire[..len]).is_ok() {
                    std::thread::park_timeout(std::time::Duration::from_millis(100));
                }
            });
        }
    });
    let scan = ["--lang", "en", "scan", "127.0.0.1", "--addresses", "1", "--port", &port];
    let run = Run::of(&scan);
    assert!(run.code == 1 && run.out.contains("Others talk on this line"), "{run:?}");
    assert!(hears.try_recv().is_err(), "it sent something");
    let run = Run::of(&[&scan[..], &["--insist"]].concat());
    assert!(!run.out.contains("Others talk on this line"), "{run:?}");
    assert!(hears.try_recv().is_ok(), "it is made to");
}
