//! What is said of a request's way is what happened.

use lafet_device::{Source, Way};
use lafet_play::Playground;
use lafet_proto::dictionary::{REQUESTS, SUBSYSTEMS};
use lafet_proto::record::Records;
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_sim::fault::Fault;
use lafet_sim::sim::{Config, Sim};
use serde_json::json;

use crate::{later, ok, send};

/// Monitors in states in which requests are intercepted by one or the other.
fn states() -> Vec<(&'static str, Sim)> {
    let stowed = Sim::new(Config::default());
    let mut all = vec![("just powered up", stowed.clone())];
    let after = |sim: &Sim, requests: &str, ms: u64| {
        let mut sim = sim.clone();
        sim.advance_ms(1_000);
        for request in requests.split(';').filter(|it| !it.is_empty()) {
            let mut buffer = [0; 255];
            let request = lafet_proto::text::parse(request, &mut buffer).unwrap();
            let mut out = [0; 300];
            let mut writer = lafet_proto::record::Writer::new(&mut out);
            request.encode(&mut writer).unwrap();
            sim.request(Source::ExternalConn, writer.written());
        }
        sim.advance_ms(ms);
        sim
    };
    all.push(("stowed", after(&stowed, "", 0)));
    all.push(("deploying", after(&stowed, "Deploy", 2_000)));
    let deployed = after(&stowed, "Deploy", 15_000);
    all.push(("open", after(&deployed, "Open Valve1", 6_000)));
    all.push(("seeking", after(&deployed, "StartSeek -600 600 -300 300", 1_000)));
    let quench = "StartQuench centre=0,300 nozzle=60 sector=600,300 step=2 distance=25";
    all.push(("quenching", after(&deployed, quench, 1_000)));
    all.push(("locked out", after(&deployed, "Lockout on", 500)));
    all.push(("restarting", after(&deployed, "Restart", 0)));
    let mut weak = deployed.clone();
    weak.world_mut().inject(Fault::from_name("voltage-low").unwrap());
    all.push(("weak supply", after(&weak, "", 3_000)));
    let remote = Config { composition: lafet_device::Composition::REMOTE, ..Config::default() };
    all.push(("without Deployer", after(&Sim::new(remote), "", 0)));
    all.push(("deployed", deployed));
    all
}

/// Each request to each subsystem, known or not, with data of several sizes, in every state: the way
/// that the device names leads to the answer that it gives.
#[test]
fn every_way_ends_where_the_answer_comes_from() {
    let (mut intercepted, mut reached) = (0, 0);
    for (state, sim) in states() {
        let requests = REQUESTS.iter().map(|it| it.id).chain([RequestId(0), RequestId(0xFF)]);
        for request in requests {
            let devices =
                SUBSYSTEMS.iter().map(|it| it.id).chain([SubsystemId(0), SubsystemId(0xFE)]);
            for device in devices {
                for size in [0usize, 2, 6, 12] {
                    let data = [0; 12];
                    let header = [request.0, device.0, 0, size as u8];
                    let bytes = [&header[..], &data[..size]].concat();
                    let record = Records::new(&bytes).next().unwrap().unwrap();
                    let way = sim.device().way(&record);
                    let mut copy = sim.clone();
                    let answer = copy.handle(Source::Radio, &bytes);
                    let answers: Vec<_> = Records::new(&answer)
                        .flatten()
                        .map(|record| (record.device, record.status))
                        .collect();
                    let case = format!(
                        "{state}: {request} to {device}, {size} bytes: {way:?}, {answers:?}"
                    );
                    let one = |from: SubsystemId, status: Status| {
                        assert_eq!(answers, [(from, status)], "{case}");
                    };
                    match way {
                        Way::Closed(status) => one(SubsystemId::GENERAL, status),
                        Way::Unknown | Way::Nobody => {
                            one(SubsystemId::GENERAL, Status::WRONG_REQUEST)
                        }
                        Way::Absent => one(device, Status::MODULE_NOT_EXIST),
                        Way::NotAddressee => one(device, Status::WRONG_REQUEST),
                        Way::Data(status) => one(device, status),
                        Way::Intercepted(by, status) => {
                            intercepted += 1;
                            one(by, status);
                        }
                        Way::Reached => {
                            reached += 1;
                            assert!(matches!(answers[..], [(from, _)] if from == device), "{case}");
                        }
                        Way::Everyone(handlers) => {
                            let chain = SubsystemId::CHAIN.into_iter();
                            let expected: Vec<_> =
                                chain.filter(|it| handlers.contains(*it)).collect();
                            let from: Vec<_> = answers.iter().map(|(from, _)| *from).collect();
                            assert_eq!(from, expected, "{case}");
                        }
                    }
                }
            }
        }
    }
    assert!(intercepted > 100 && reached > 500, "{intercepted} intercepted, {reached} reached");
}

#[test]
fn a_refusal_is_explained_by_the_state_of_who_refuses() {
    let mut playground = Playground::default();
    later(&mut playground, 1);
    let entry = send(&mut playground, "Open Valve1");
    let walk = &entry["walks"][0];
    assert!(walk["end"]["en"].as_str().unwrap().contains("intercepts"), "{walk}");
    assert_eq!(walk["verdicts"][0]["from"], "Deployer");
    assert!(walk["because"].to_string().contains("Wrapped"), "{}", walk["because"]);
    let marks: Vec<_> = walk["stations"].as_array().unwrap().iter().collect();
    let mark = |name: &str| marks.iter().find(|it| it["name"] == name).unwrap()["mark"].clone();
    assert_eq!((mark("Deployer"), mark("Valve1")), (json!("refused"), json!("unasked")));
}

/// A frame with several requests: each is judged in the state that those before it have left.
#[test]
fn the_second_request_meets_what_the_first_has_done() {
    let mut playground = Playground::default();
    later(&mut playground, 1);
    let entry = send(&mut playground, "Lockout on; Deploy; Lockout off; Deploy");
    let status = |walk: usize| entry["walks"][walk]["verdicts"][0]["status"].clone();
    assert_eq!(status(1), "Denied");
    assert_eq!(status(3), "Accepted");
    // What the walks show is what went over the wire.
    let shown: usize = entry["walks"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["verdicts"].as_array().unwrap().len())
        .sum();
    assert_eq!(shown, entry["answer"]["text"].as_array().unwrap().len());
}

#[test]
fn what_is_no_frame_gets_no_answer_and_the_reason() {
    let mut playground = Playground::default();
    let mut wire = |text: &str| {
        let input = json!({ "bytes": true, "text": text });
        let act = json!({ "kind": "send", "link": "radio", "input": input });
        let mut view = ok(&mut playground, json!({ "op": "act", "act": act }));
        view["entries"][0].take()
    };
    let good = "ff c0 01 81 4d 0d 00 02 a0 ab aa ac c0";
    assert!(wire(good)["answer"].is_object());
    let bad = wire("ff c0 01 81 4d 0d 00 02 a0 ab aa ad c0");
    assert!(
        bad["answer"].is_null() && bad["silence"]["en"].as_str().unwrap().contains("CRC"),
        "{bad}"
    );
    let other = wire("ff c0 02 81 4d 0d 00 02 a0 ab ee ac c0");
    assert!(other["answer"].is_null());
}
