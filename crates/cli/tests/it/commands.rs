//! Every command on a simulated monitor.

use std::net::TcpListener;

use crate::support::{Run, Sim};
use serde_json::json;

const FAST: &[&str] = &["--speed", "40"];

/// §3.1/1: the barrel is stowed, so Deployer refuses: exit code 1, who refused and why, what to
/// try.
#[test]
fn a_refusal_says_who_why_and_what_to_do() {
    let sim = Sim::start(FAST);
    let run = sim.run(&["move", "vertical", "10deg"]);
    assert_eq!(run.code, 1, "{run:?}");
    for word in [
        "Move Vertical 600: Deployer answers Denied.",
        "[4d 0d 00 02 58 02]",
        "[4d a2 03 00]",
        "Why: The barrel is not deployed",
        "(§3.1/1)",
        "Try: lafet deploy",
    ] {
        assert!(run.err.contains(word), "{word}: {run:?}");
    }
    let run = sim.run(&["--json", "move", "vertical", "10deg"]);
    let error = &run.json()[0]["error"];
    assert_eq!(
        (run.code, &error["status"], &error["by"]),
        (1, &json!("Denied"), &json!("Deployer"))
    );
    assert_eq!(
        (&error["scenario"], &error["received"], &error["try"]),
        (&json!("§3.1/1"), &json!("4d a2 03 00"), &json!("lafet deploy"))
    );
    let run = sim.run(&["--lang", "ru", "move", "vertical", "10deg"]);
    assert!(run.err.contains("отвечает Denied") && run.err.contains("Попробуйте"), "{run:?}");
}

#[test]
fn no_answer() {
    // A port that has just been closed, and one whose owner sends nothing.
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let run = Run::of(&["-c", &format!("tcp://{closed}"), "status"]);
    assert_eq!(run.code, 3, "{run:?}");
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}", silent.local_addr().unwrap());
    let run = Run::of(&["-c", &url, "--timeout", "0.05", "--json", "status"]);
    assert_eq!((run.code, &run.json()[0]["error"]["kind"]), (3, &json!("no-answer")), "{run:?}");
    assert!(run.err.contains("addr="), "{run:?}");
}

#[test]
fn wrong_usage() {
    for (arguments, word) in [
        (&["status"][..], "-c"),
        (&["fly"], "fly"),
        (&["-c", "sim:", "move", "up", "3"], "Vertical"),
        (&["-c", "sim:", "move", "vertical", "far"], "20deg"),
        (&["-c", "sim:", "send", "Opn Valve1"], "did you mean `Open`"),
        (&["-c", "sim:?profile=huge", "status"], "limit-switch"),
        (&["-c", "http://h", "status"], "http"),
        (&["sim", "--listen", "tcp://nowhere"], "port 0"),
        (&["sim", "--fire", "az=1"], "range="),
        (&["quench", "-c", "sim:", "--centre", "0,0", "--corrections", "1"], "3.14"),
        (&["limits", "-c", "sim:", "vertical", "nozzle"], "off|on|reject"),
        (&["decode", "xyz"], "hexadecimal"),
        (&["decode", "ff c0 01 81 00 00 c0"], "frame"),
    ] {
        let run = Run::of(arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {run:?}");
        assert!(run.err.contains(word), "{arguments:?}: {run:?}");
        let run = Run::of(&[&["--lang", "ru"], arguments].concat());
        assert_eq!(run.code, 2, "{arguments:?}: {run:?}");
        assert!(run.err.chars().any(|c| ('а'..='я').contains(&c)), "{arguments:?}: {run:?}");
    }
}

#[test]
fn deploy_move_wrap() {
    let sim = Sim::start(FAST);
    let run = sim.done(&["deploy"]);
    assert!(run.out.contains("Deployed") && run.err.contains("Deploying"), "{run:?}");
    sim.done(&["move", "vertical", "10deg"]);
    sim.done(&["move", "horizontal", "-30deg"]);
    let done = sim.value(&["move", "nozzle", "30mm"]);
    assert_eq!(done["state"]["position_mm"], 30);
    let status = sim.value(&["status"]);
    let near = |who: &str, expected: i64| {
        let position = status[who]["position_arcmin"].as_i64().unwrap();
        assert!((position - expected).abs() <= 2, "{who}: {position}");
    };
    near("Vertical", 600);
    near("Horizontal", -1800);
    // §3.1: a target beyond the limit moves to the limit.
    let limit = sim.value(&["move", "vertical", "-21600"]);
    assert_eq!(limit["state"]["position_arcmin"], -900);
    let run = sim.done(&["wrap"]);
    assert!(run.out.contains("Wrapped"), "{run:?}");
    let quick = sim.done(&["deploy", "--no-wait"]);
    assert!(quick.out.contains("Deployer Deploy → Accepted"), "{quick:?}");
    assert!(sim.done(&["stop"]).out.contains("Deployer Stop →"));
}

/// §3.8/1, §3.9, §3.11: no water in a stowed barrel, no stowing with open valves.
#[test]
fn valves() {
    let sim = Sim::start(FAST);
    assert_eq!(sim.run(&["open"]).code, 1);
    sim.done(&["deploy"]);
    assert!(sim.done(&["open"]).out.contains("Open]"));
    let run = sim.run(&["wrap"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("Valve1") && run.err.contains("lafet close valve1"), "{run:?}");
    let done = sim.value(&["close", "valve1"]);
    assert_eq!(done["state"]["flags"], json!(["Closed"]));
}

/// The sun is detected as a fire spot beside the fire; a fire behind a wall is not detected.
#[test]
fn glare_and_walls_of_a_simulator() {
    let sim = Sim::start(&[
        "--speed",
        "50",
        "--fire=az=20,range=25,size=1.5",
        "--fire=az=-5,range=25,size=1.5",
        "--glare=az=-20,el=2,size=0.5,brightness=3000",
        "--wall=from=-10,to=5,range=15,height=3",
        "--wind=-5,0",
        "--gusts=0.15",
    ]);
    sim.done(&["deploy"]);
    let found = sim.value(&["seek", "--from-az", "-40", "--to-az", "40"]);
    let hotbeds = found["hotbeds"].as_array().unwrap();
    assert_eq!(hotbeds.len(), 2, "{found}");
    let run = Run::of(&["sim", "--gusts", "7"]);
    assert!(run.code == 2 && run.err.contains("0 to 0.5"), "{run:?}");
    let run = Run::of(&["--lang", "ru", "sim", "--wall", "from=1"]);
    assert!(run.code == 2 && run.err.contains("from=ГРАДУСЫ"), "{run:?}");
}

#[test]
fn a_fire_is_found_and_extinguished() {
    let sim = Sim::start(&["--speed", "40", "--fire", "az=30,range=25,size=1.5"]);
    let found = sim.value(&["seek", "--from-az", "0", "--to-az", "60", "--analyse"]);
    let hotbeds = found["hotbeds"].as_array().unwrap();
    assert_eq!(hotbeds.len(), 1, "{found}");
    let edge = |name: &str| hotbeds[0][name].as_i64().unwrap();
    let azimuth = (edge("left_arcmin") + edge("right_arcmin")) / 2;
    assert!((azimuth - 1800).abs() < 60, "{found}");
    assert_eq!(sim.value(&["hotbeds"]), found);
    assert!(sim.done(&["hotbeds"]).out.contains("30."));
    let run = sim.done(&["quench", "--centre", "30deg,-2deg", "--distance", "25"]);
    assert!(run.out.contains("Control StartQuench → Accepted"), "{run:?}");
    assert!(sim.flags("control").contains(&"Quench".to_owned()));
    sim.done(&["stop", "control"]);
    sim.done(&[
        "trajectory",
        "--point",
        "20deg,2deg,25,1",
        "--point",
        "24deg,2deg,25,1",
        "--follow",
    ]);
    sim.done(&["param", "set", "control", "Program3", "-600", "120", "40", "60", "60", "1", "20"]);
    let run = sim.done(&["quench", "--program", "3"]);
    assert!(run.out.contains("Accepted"), "{run:?}");
    sim.done(&["stop", "control"]);
}

#[test]
fn parameters() {
    let sim = Sim::start(FAST);
    let speed = sim.value(&["param", "get", "vertical", "speed"]);
    assert_eq!((&speed["name"], &speed["values"]), (&json!("Speed"), &json!([12])));
    let set = sim.value(&["param", "set", "vertical", "Speed", "8"]);
    assert_eq!((&set["acts"], &set["saved"]), (&json!("at-once"), &json!("stored")));
    assert!(
        sim.done(&["param", "get", "Vertical", "Speed"]).out.starts_with("Vertical Speed = 8 °/s")
    );
    let later = sim.done(&["param", "set", "general", "Address", "5"]);
    assert!(later.out.contains("lafet restart"), "{later:?}");
    let bad = sim.run(&["param", "set", "vertical", "Speed", "0"]);
    assert_eq!(bad.code, 1);
    assert!(bad.err.contains("InvalidValue") && bad.err.contains("1…255"), "{bad:?}");
    let unknown = sim.run(&["param", "get", "vertical", "Nonsense"]);
    assert_eq!(unknown.code, 1);
    assert!(unknown.err.contains("InvalidId"), "{unknown:?}");
    let denied = sim.run(&["param", "set", "general", "FaultInfo", "-1"]);
    assert_eq!(denied.code, 1, "{denied:?}");
    let list = sim.value(&["param", "list"]);
    assert_eq!(list.as_array().unwrap().len(), lafet_proto::param::Param::COUNT);
    assert!(sim.done(&["param", "list", "valve1"]).out.lines().count() == 3);
}

#[test]
fn limits() {
    let sim = Sim::start(FAST);
    assert!(sim.done(&["limits"]).out.contains("Vertical"));
    let vertical = sim.value(&["limits", "vertical"]);
    assert_eq!(vertical["Vertical"], json!({ "min": -900, "max": 4500, "unit": "arcmin" }));
    sim.done(&["deploy"]);
    sim.done(&["limits", "off", "vertical"]);
    assert!(sim.flags("vertical").contains(&"Limitless".to_owned()));
    sim.done(&["limits", "reject"]);
    assert!(!sim.flags("vertical").contains(&"Limitless".to_owned()));
}

/// §3.18, §3.12, §3.20.
#[test]
fn service() {
    let sim = Sim::start(FAST);
    assert!(sim.done(&["lockout", "on"]).out.contains("The lockout is stored: "));
    assert!(sim.flags("general").contains(&"LockedOut".to_owned()));
    let run = sim.run(&["deploy"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("General") && run.err.contains("lafet lockout off"), "{run:?}");
    let run = sim.done(&["lockout", "off"]);
    assert!(run.out.contains("The monitor is released. It stores that within a moment"), "{run:?}");
    let run = sim.done(&["--lang", "ru", "lockout", "off"]);
    assert!(run.out.contains("Снятие записано"), "{run:?}");
    sim.done(&["restart"]);
    assert_eq!(sim.value(&["crash"]), json!({ "fault": null }));
    assert!(!sim.flags("general").contains(&"LockedOut".to_owned()));
}

#[test]
fn status_and_watch() {
    let sim = Sim::start(FAST);
    let run = sim.done(&["status"]);
    assert!(run.out.contains("Wrapped [info]: The monitor is in the standby position."), "{run:?}");
    let run = sim.done(&["--lang=ru", "status", "deployer"]);
    assert!(run.out.contains("Wrapped [норма]"), "{run:?}");
    let run = sim.done(&["watch", "general", "--interval", "0.05", "--count", "3"]);
    assert_eq!(run.out.lines().count(), 3, "{run:?}");
    let run = sim.done(&["watch", "--json", "--interval", "0.05", "--count", "2"]);
    let looks = run.json();
    assert_eq!(looks.len(), 2);
    assert!(looks[1]["t_s"].as_f64() > looks[0]["t_s"].as_f64());
    assert_eq!(looks[0]["Valve1"]["flags_raw"], 0x0080_0000);
    let remote = Sim::start(&["--profile", "remote"]);
    assert_eq!(remote.run(&["status", "deployer"]).code, 1);
    assert_eq!(remote.value(&["status"])["Deployer"], json!(null));
}

#[test]
fn any_requests_can_be_sent() {
    let sim = Sim::start(FAST);
    let run = sim.done(&["send", "getstatus", "valve1"]);
    assert_eq!(run.out, "Valve1 GetStatus → Ok: [Closed]\n");
    // §3.21.
    let run = sim.done(&["send", "9d c8 00 02 fe 23"]);
    assert_eq!(run.out, "Detector GetParam → Ok: Hotbeds 0\n");
    let run = sim.run(&["send", "Move Vertical 1200", "GetStatus Valve2", "Stop Nozzle"]);
    assert_eq!(run.code, 1);
    assert!(run.out.contains("Vertical Move → Denied (Deployer)"), "{run:?}");
    assert!(run.out.contains("Valve2 GetStatus → Ok"), "{run:?}");
    let run = sim.run(&["--json", "send", "Open Valve1 key=0x1234"]);
    assert_eq!(run.json()[0]["bytes"], "21 a6 00 02 34 12");
    let run = Run::fed(&["-c", sim.url(), "send", "-"], b"# two\nGetStatus Valve1\nStop All\n");
    assert_eq!(run.out.lines().next(), Some("Valve1 GetStatus → Ok: [Closed]"), "{run:?}");
    let unknown = sim.run(&["send", "0x12 General de ad"]);
    assert!(unknown.code == 1 && unknown.err.contains("WrongRequest"), "{unknown:?}");
}

#[test]
fn a_simulator_inside_the_command() {
    let run = Run::of(&["-c", "sim:?profile=mini&seed=3&addr=9", "--json", "status"]);
    assert_eq!(run.code, 0, "{run:?}");
    let status = &run.json()[0];
    assert_eq!(status["ExtButtons"], json!(null));
    assert_eq!(status["Nozzle"]["position_mm"], 60);
    let run = Run::of(&["-c", "sim:?speed=50", "deploy"]);
    assert_eq!(run.code, 0, "{run:?}");
}

#[test]
fn schema() {
    let run = Run::of(&["schema"]);
    let schema = &run.json()[0];
    assert_eq!(schema["requests"][0]["name"], "Move");
    assert_eq!(schema["statuses"][3]["name"], "Denied");
    assert!(schema["subsystems"][0]["ru"].is_string());
    let pretty = Run::of(&["schema", "--pretty"]).out;
    assert_eq!(&serde_json::from_str::<serde_json::Value>(&pretty).unwrap(), schema);
}

#[test]
fn every_command_has_help_with_an_example() {
    let root = Run::of(&["--help"]);
    assert_eq!(root.code, 0);
    let listed = root.out.lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands: Vec<&str> = listed
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.len() >= 22, "{commands:?}");
    for command in commands {
        let english = Run::of(&[command, "--help"]);
        assert!(english.code == 0 && english.out.contains("Examples:\n  "), "{english:?}");
        let russian = Run::of(&["--lang", "ru", command, "--help"]);
        assert!(russian.code == 0 && russian.out.contains("Примеры:\n  "), "{russian:?}");
    }
}

/// A negative number is a value that is out of range, not an option.
#[test]
fn a_negative_time_is_told_its_range() {
    for (lang, least) in [("en", "0.001"), ("ru", "0,001")] {
        let run = Run::of(&["--lang", lang, "-c", "sim:", "--timeout", "-1", "status"]);
        assert!(run.code == 2 && run.err.contains(least) && run.err.contains("-1"), "{run:?}");
        assert_eq!(Run::of(&["-c", "sim:", "--timeout", "0,5", "status"]).code, 0);
        assert!(!run.err.contains("unexpected argument"), "{run:?}");
    }
}

/// In a pipe, progress that is soon superseded is written now and then, not at each step.
#[test]
fn progress_in_a_pipe_is_bounded() {
    let sim = Sim::start(&["--fire", "az=5,range=25"]);
    sim.done(&["deploy"]);
    let began = std::time::Instant::now();
    let run = sim.done(&["seek", "--from-az", "-30", "--to-az", "30"]);
    // A line at the start, then one each 5 s.
    let most = 2 + began.elapsed().as_secs() as usize / 5;
    let lines = run.err.lines().count();
    assert!((1..=most).contains(&lines), "{lines} of {most}: {run:?}");
    let began = std::time::Instant::now();
    let run = Run::of(&["scan", "127.0.0.1-40", "--port", "1", "--brief"]);
    let most = 2 + began.elapsed().as_secs() as usize / 5;
    let lines = run.err.lines().filter(|line| line.contains("ports examined: ")).count();
    assert!((1..=most).contains(&lines), "{lines} of {most}: {run:?}");
    assert!(run.err.lines().count() <= most + 1, "{run:?}");
}
