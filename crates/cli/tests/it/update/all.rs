//! `lafet update --all`: the monitors of a hub's configuration, one after another.

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use lafet_proto::RequestId;
use serde_json::{Value, json};

use super::{Maker, note, state};
use crate::between::{Fate, between};
use crate::json::has_shape;
use crate::support::{Run, Running, Sim, hub, lafet};

/// A fast clock, of which the 180 s of a trial are 36 s here: it is watched for 5 s, and this machine may be busy.
const FAST: [&str; 2] = ["--speed", "5"];
/// No program listens there.
const SILENT: &str = "tcp://127.0.0.1:1";

/// Monitors as `M1`, `M2`, …, and zones with those that serve them.
fn site(maker: &Maker, urls: &[&str], zones: &[(&str, &[&str])]) -> String {
    let mut text =
        "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n".to_owned();
    for (number, url) in (1..).zip(urls) {
        text += &format!("[[monitor]]\nid = \"M{number}\"\nurl = \"{url}\"\n");
    }
    let quoted = |ids: &[&str]| ids.iter().map(|id| format!("\"{id}\"")).collect::<Vec<_>>();
    for (zone, monitors) in zones {
        for monitor in *monitors {
            text += &format!(
                "[[aim]]\nzone = \"{zone}\"\nmonitor = \"{monitor}\"\nhorizontal = 600\n\
                 vertical = 300\nnozzle = 60\n"
            );
        }
        text += &format!(
            "[[zone]]\nid = \"{zone}\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [{}]\n",
            quoted(monitors).join(", ")
        );
    }
    let ids: Vec<&str> = zones.iter().map(|(zone, _)| *zone).collect();
    for kind in ["flame", "heat"].iter().filter(|_| !ids.is_empty()) {
        text += &format!(
            "[[detector]]\nid = \"{kind}\"\nkind = \"{kind}\"\nzones = [{}]\nsilent_after_s = 3600\n",
            quoted(&ids).join(", ")
        );
    }
    let file = maker.path("hub.toml");
    fs::write(&file, text).unwrap();
    file
}

/// The command, with its output as JSON.
fn command(site: &str, image: &str, more: &[&str]) -> std::process::Command {
    let mut command = lafet();
    command.args([
        "--json",
        "--lang",
        "en",
        "--timeout",
        "0.5",
        "update",
        image,
        "--watch",
        "5",
        "--all",
        site,
    ]);
    command.args(more);
    command
}

/// Its exit code and lines, of which each has its shape; what it says on standard error.
fn update(site: &str, image: &str, more: &[&str]) -> (i32, Vec<Value>, String) {
    let run = Run::of_command(&mut command(site, image, more));
    let lines = run.json();
    for line in &lines {
        let shape = if line.get("error").is_some() { "error" } else { "update-all" };
        has_shape(shape, &line.to_string());
    }
    (run.code, lines, run.err)
}

/// Monitors and states in the order in which they were printed, each once.
fn course(lines: &[Value]) -> Vec<String> {
    let of =
        |line: &Value| Some(format!("{} {}", line["monitor"].as_str()?, line["state"].as_str()?));
    let mut course: Vec<String> = lines.iter().filter_map(of).collect();
    course.dedup();
    course
}

fn find<'a>(lines: &'a [Value], monitor: &str, state: &str) -> &'a Value {
    let found = lines.iter().find(|line| line["monitor"] == monitor && line["state"] == state);
    found.unwrap_or_else(|| panic!("{monitor} {state}: {lines:?}"))
}

fn is_locked(sim: &Sim) -> bool {
    sim.flags("general").contains(&"LockedOut".to_owned())
}

/// It runs this version and is locked out or not.
#[track_caller]
fn runs(sim: &Sim, version: &str, locked_out: bool) {
    let state = state(sim);
    assert_eq!((&state["version"], &state["on_trial"]), (&json!(version), &json!(false)));
    assert_eq!(is_locked(sim), locked_out);
}

#[test]
fn each_in_its_turn() {
    let maker = Maker::new("update-all-turn");
    let image = maker.image("1.1", 1000);
    let sims = [(); 3].map(|()| maker.monitor(&FAST));
    let urls: Vec<&str> = sims.iter().map(Sim::url).collect();
    let site = site(&maker, &urls, &[("hall", &["M1", "M2"])]);
    sims[2].done(&["lockout", "on"]);
    let (code, lines, said) = update(&site, &image, &[]);
    assert_eq!((code, said.as_str()), (0, ""), "{lines:?}");
    let expected = [
        "M1 ready",
        "M2 ready",
        "M3 ready",
        "M1 checking",
        "M1 locking",
        "M1 updating",
        "M1 unlocking",
        "M1 done",
        "M2 checking",
        "M2 locking",
        "M2 updating",
        "M2 unlocking",
        "M2 done",
        "M3 checking",
        "M3 updating",
        "M3 done",
    ];
    assert_eq!(course(&lines), expected);
    let done = find(&lines, "M2", "done");
    assert_eq!((&done["from"], &done["to"]), (&json!("1.0.0.0"), &json!("1.1.0.0")));
    for (sim, locked) in sims.iter().zip([false, false, true]) {
        runs(sim, "1.1.0.0", locked);
        assert!(!note(sim.url()).exists());
    }
    // What runs it already is left alone, in whatever state it is.
    sims[0].done(&["deploy"]);
    let (code, lines, _) = update(&site, &image, &["--only", "M1", "--only", "M3"]);
    assert_eq!(code, 0, "{lines:?}");
    let expected = ["M1 ready", "M3 ready", "M1 checking", "M1 same", "M3 checking", "M3 same"];
    assert_eq!(course(&lines), expected);
    let run = Run::of(&["--lang", "ru", "update", &image, "--watch", "5", "--all", &site]);
    assert!(run.code == 0 && run.out.contains("M2: версия 1.1.0.0 уже работает"), "{run:?}");
}

#[test]
fn nothing_is_changed_unless_all_are_ready() {
    let maker = Maker::new("update-all-ready");
    let image = maker.image("1.1", 400);
    let (good, deployed) = (maker.monitor(&FAST), maker.monitor(&FAST));
    let (plain, newer) = (Sim::start(&FAST), maker.monitor(&FAST));
    newer.done(&["lockout", "on"]);
    newer.done(&["update", &maker.image("1.2", 400), "--watch", "5"]);
    deployed.done(&["deploy"]);
    let urls = [good.url(), deployed.url(), plain.url(), newer.url(), SILENT];
    let site = site(&maker, &urls, &[]);
    let (code, lines, said) = update(&site, &image, &[]);
    assert_eq!(code, 1, "{lines:?}");
    let expected = ["M1 ready", "M2 not-ready", "M3 not-ready", "M4 not-ready", "M5 not-ready"];
    assert_eq!(course(&lines), expected);
    for (monitor, word) in [
        ("M2", "not in standby"),
        ("M3", "cannot be updated"),
        ("M4", "1.2.0.0, which is newer"),
        ("M5", "127.0.0.1:1"),
    ] {
        let missing = &find(&lines, monitor, "not-ready")["missing"];
        let line = said.lines().find(|line| line.starts_with(&format!("  {monitor}: ")));
        assert!(line.is_some_and(|line| line.contains(word)), "{monitor}: {said}");
        assert!(missing.to_string().contains(word), "{missing}");
    }
    assert!(said.contains("Nothing was changed"), "{said}");
    runs(&good, "1.0.0.0", false);
    assert_eq!(state(&good)["phase"], "idle");
    runs(&deployed, "1.0.0.0", false);
    // Nothing but an answer is missing.
    let (code, ..) = update(&site, &image, &["--only", "M1", "--only", "M5"]);
    assert_eq!(code, 3);
    // An image for the slot that runs alone.
    let for_a = maker.path("a.image");
    let key = format!("0={}", maker.path("key0"));
    let sign = ["image", "sign", "--slot", "a", "--key", &key, "--board", "bench"];
    let more = ["--version", "1.1", "--layouts", "1-1"];
    super::done(&[&sign[..], &more, &[maker.path("program").as_str(), &for_a]].concat());
    let (code, _, said) = update(&site, &for_a, &["--only", "M1"]);
    assert!(code == 1 && said.contains("slot B"), "{said}");
    runs(&good, "1.0.0.0", false);
}

/// A monitor that serves a zone with one that is locked out, or does not answer, is not taken out of service.
#[test]
fn two_of_a_zone_are_never_out_of_service() {
    let maker = Maker::new("update-all-zone");
    let image = maker.image("1.1", 400);
    let sims = [(); 3].map(|()| maker.monitor(&FAST));
    let urls: Vec<&str> = sims.iter().map(Sim::url).chain([SILENT]).collect();
    let zones: [(&str, &[&str]); 2] = [("hall", &["M1", "M2"]), ("yard", &["M2", "M3", "M4"])];
    let site = site(&maker, &urls, &zones);
    sims[0].done(&["lockout", "on"]);
    for only in ["M2", "M3"] {
        let (code, lines, said) = update(&site, &image, &["--only", only]);
        assert!(said.contains("Zone yard: M4 serves it too"), "{said}");
        let hall = said.contains("Zone hall: M1 serves it too and is locked out");
        assert_eq!((hall, code), (only == "M2", if hall { 1 } else { 3 }), "{said}");
        assert_eq!(course(&lines), [format!("{only} not-ready")]);
    }
    // It is locked out itself, and M2 is in service.
    let (code, lines, _) = update(&site, &image, &["--only", "M1"]);
    assert_eq!(code, 0, "{lines:?}");
    runs(&sims[0], "1.1.0.0", true);
    runs(&sims[1], "1.0.0.0", false);
    runs(&sims[2], "1.0.0.0", false);
}

/// Another client locks out the other one of the zone at the same time.
#[test]
fn a_lockout_in_between() {
    let maker = Maker::new("update-all-between");
    let image = maker.image("1.1", 400);
    let (one, other) = (maker.monitor(&FAST), maker.monitor(&FAST));
    let there = other.url().to_owned();
    let orders = Arc::new(AtomicUsize::new(0));
    let count = orders.clone();
    let mut locked = false;
    let url = between(&one, move |asked| {
        for one in asked {
            let order = one.request == RequestId::UPDATE && one.data != [0];
            count.fetch_add(usize::from(order), Ordering::SeqCst);
            if one.request == RequestId::LOCKOUT && !std::mem::replace(&mut locked, true) {
                assert_eq!(Run::of(&["-c", &there, "lockout", "on"]).code, 0);
            }
        }
        Fate::Passed
    });
    let site = site(&maker, &[&url, other.url()], &[("hall", &["M1", "M2"])]);
    let (code, lines, said) = update(&site, &image, &[]);
    assert!(code == 1 && said.contains("M1: Zone hall: M2"), "{said}");
    let course = course(&lines);
    let tail: Vec<&str> = course.iter().skip(2).map(String::as_str).collect();
    let expected = ["M1 checking", "M1 locking", "M1 unlocking", "M1 skipped", "M2 skipped"];
    assert_eq!(tail, expected);
    assert_eq!(orders.load(Ordering::SeqCst), 0, "nothing was sent to it");
    runs(&one, "1.0.0.0", false);
    runs(&other, "1.0.0.0", true);
}

/// The board is what a monitor does not say before: it refuses the image, and that ends it.
#[test]
fn it_ends_at_the_first_failure() {
    let maker = Maker::new("update-all-failure");
    let image = maker.image("1.1", 400);
    let key = format!("0={}", maker.path("key0.pub"));
    let odd = ["--board", "other", "--update-key", &key];
    let sims =
        [maker.monitor(&FAST), Sim::start(&[&odd[..], &FAST].concat()), maker.monitor(&FAST)];
    let urls: Vec<&str> = sims.iter().map(Sim::url).collect();
    let site = site(&maker, &urls, &[]);
    let (code, lines, said) = update(&site, &image, &[]);
    assert!(code == 1 && said.contains("M2: ") && said.contains("another board"), "{said}");
    let failed = find(&lines, "M2", "failed");
    let of = |key: &str| failed[key].clone();
    assert_eq!((of("version"), of("locked_out")), (json!("1.0.0.0"), json!(true)));
    assert!(of("text").to_string().contains("--only M2"), "{failed}");
    find(&lines, "M1", "done");
    find(&lines, "M3", "skipped");
    runs(&sims[0], "1.1.0.0", false);
    runs(&sims[1], "1.0.0.0", true);
    runs(&sims[2], "1.0.0.0", false);
    let run = Run::of(&["--lang", "en", "update", &image, "--watch", "5", "--all", &site]);
    assert!(run.code == 1 && run.out.contains("Done: M1. Not touched: M3."), "{run:?}");
    // By now its lockout is one that was there.
    assert!(run.out.contains("M2: version 1.0.0.0") && run.out.contains("as before"), "{run:?}");
}

/// Ctrl-C while data are sent; then on, as it says.
#[test]
fn an_end_says_where_each_is() {
    let maker = Maker::new("update-all-ended");
    let image = maker.image("1.1", 64 * 1024);
    let sims = [maker.monitor(&FAST), maker.monitor(&[]), maker.monitor(&FAST)];
    let urls: Vec<&str> = sims.iter().map(Sim::url).collect();
    let site = site(&maker, &urls, &[]);
    let mut running = Running::stdout(&mut command(&site, &image, &[]));
    let parsed = |line: String| serde_json::from_str::<Value>(&line).unwrap();
    loop {
        let line = parsed(running.line());
        has_shape("update-all", &line.to_string());
        if line["monitor"] == "M2" && line["done"].as_u64().is_some_and(|done| done > 3000) {
            break;
        }
    }
    running.signal("INT");
    let mut last: Vec<Value> = Vec::new();
    while last.last().is_none_or(|line| line.get("error").is_none()) {
        last.push(parsed(running.line()));
    }
    assert_eq!(running.code(), Some(130));
    let ended = find(&last, "M2", "ended");
    has_shape("update-all", &ended.to_string());
    let of = |key: &str| ended[key].clone();
    assert_eq!((of("version"), of("phase")), (json!("1.0.0.0"), json!("receiving")));
    assert_eq!((of("locked_out"), of("on_trial")), (json!(true), json!(false)));
    find(&last, "M3", "skipped");
    assert_eq!(last.last().unwrap()["error"]["kind"], "interrupted");
    runs(&sims[0], "1.1.0.0", false);
    runs(&sims[1], "1.0.0.0", true);
    runs(&sims[2], "1.0.0.0", false);
    let (code, lines, _) = update(&site, &image, &["--only", "M2"]);
    assert_eq!(code, 0, "{lines:?}");
    let first = lines.iter().find_map(|line| line["done"].as_u64()).unwrap();
    assert!(first > 3000, "it goes on: {first}");
    runs(&sims[1], "1.1.0.0", true);
    sims[1].done(&["lockout", "off"]);
    let run = Run::of(&["--lang", "en", "update", &image, "--watch", "5", "--all", &site]);
    assert!(run.code == 0 && run.out.contains("M3: 1.0.0.0 → 1.1.0.0, confirmed"), "{run:?}");
    runs(&sims[2], "1.1.0.0", false);
}

/// Ctrl-C before anything was changed.
#[test]
fn an_end_while_all_are_examined() {
    let maker = Maker::new("update-all-early");
    let image = maker.image("1.1", 400);
    let good = maker.monitor(&FAST);
    // It takes the connection and answers nothing.
    let deaf = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}?addr=1", deaf.local_addr().unwrap());
    let site = site(&maker, &[good.url(), &url], &[]);
    let mut command = lafet();
    command.args(["--lang", "en", "update", &image, "--watch", "5", "--all", &site]);
    let mut running = Running::stdout(&mut command);
    let _line = deaf.accept().unwrap();
    running.signal("INT");
    assert_eq!(running.line(), "Ended before anything was changed.");
    assert_eq!(running.code(), Some(130));
    runs(&good, "1.0.0.0", false);
}

/// The hub has the links while it runs, and does not start before the command has ended.
#[test]
fn the_hub_of_the_configuration() {
    let maker = Maker::new("update-all-hub");
    let image = maker.image("1.1", 64 * 1024);
    let sim = maker.monitor(&[]);
    let site = site(&maker, &[sim.url()], &[]);
    let (mut running, _) = hub(site.as_ref());
    for (lang, word) in [("en", "console"), ("ru", "пульта")] {
        let run = Run::of(&["--lang", lang, "update", &image, "--watch", "5", "--all", &site]);
        assert!(run.code == 1 && run.err.contains(word), "{run:?}");
    }
    runs(&sim, "1.0.0.0", false);
    running.signal("TERM");
    assert_eq!(running.code(), Some(0));
    let mut running = Running::stdout(&mut command(&site, &image, &[]));
    while !running.line().contains("sending") {}
    let run = Run::of(&["--lang", "en", "serve", "--no-browser", "--config", &site]);
    assert!(run.code == 2 && run.err.contains("uses"), "{run:?}");
    let second = Run::of(&["--lang", "en", "update", &image, "--watch", "5", "--all", &site]);
    assert!(second.code == 1 && second.err.contains("update --all"), "{second:?}");
    let alone = sim.run(&["update", &image]);
    assert!(alone.code == 1 && alone.err.contains("Another lafet update"), "{alone:?}");
    running.signal("KILL");
    assert_eq!(running.code(), None, "it was ended by a signal");
}

/// A line to two monitors, each of which hears what is for the other, for one connection at a time, as a serial port
/// is; the number of connections so far.
fn shared_line(sims: &[Sim]) -> (String, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap().to_string();
    let count = Arc::new(AtomicUsize::new(0));
    let (places, counted): (Vec<String>, _) =
        (sims.iter().map(|sim| without_query(sim.place())).collect(), count.clone());
    std::thread::spawn(move || {
        for mut near in listener.incoming().map_while(Result::ok) {
            counted.fetch_add(1, Ordering::SeqCst);
            let back = Arc::new(Mutex::new(near.try_clone().unwrap()));
            let mut far: Vec<TcpStream> =
                places.iter().map(|place| TcpStream::connect(place).unwrap()).collect();
            for line in &far {
                let (mut line, back) = (line.try_clone().unwrap(), back.clone());
                std::thread::spawn(move || {
                    let mut buffer = [0; 1024];
                    while let Ok(len @ 1..) = line.read(&mut buffer) {
                        if back.lock().unwrap().write_all(&buffer[..len]).is_err() {
                            return;
                        }
                    }
                });
            }
            let mut buffer = [0; 1024];
            while let Ok(len @ 1..) = near.read(&mut buffer) {
                for line in &mut far {
                    line.write_all(&buffer[..len]).unwrap();
                }
            }
        }
    });
    (place, count)
}

fn without_query(place: &str) -> String {
    place.split('?').next().unwrap().to_owned()
}

#[test]
fn monitors_of_a_line_share_it() {
    let maker = Maker::new("update-all-line");
    let image = maker.image("1.1", 400);
    let second = [&FAST[..], &["--addr", "2"]].concat();
    let sims = [maker.monitor(&FAST), maker.monitor(&second)];
    let (place, count) = shared_line(&sims);
    let urls = [1, 2].map(|address| format!("tcp://{place}?addr={address}"));
    let zone: [(&str, &[&str]); 1] = [("hall", &["M1", "M2"])];
    let site = site(&maker, &urls.each_ref().map(String::as_str), &zone);
    let (code, lines, said) = update(&site, &image, &[]);
    assert_eq!(code, 0, "{said} {lines:?}");
    // For the look at both, and for the turn of each.
    assert_eq!(count.load(Ordering::SeqCst), 3);
    for url in &urls {
        let of = |words: &[&str]| Run::of(&[&["-c", url, "--json"], words].concat());
        let software = of(&["update", "--state"]);
        assert_eq!(software.json()[0]["version"], "1.1.0.0", "{software:?}");
        let general = of(&["status", "general"]);
        assert!(general.code == 0 && !general.out.contains("LockedOut"), "{general:?}");
    }
}

#[test]
fn wrong_usage() {
    let maker = Maker::new("update-all-usage");
    let image = maker.image("1.1", 400);
    let site = site(&maker, &[SILENT], &[]);
    for (words, word) in [
        (vec!["update", &image, "--only", "M1"], "--all"),
        (vec!["update", "--state", "--all", &site], "--state"),
        (vec!["update", &image, "--all", &site, "--only", "M7"], "M7"),
        (vec!["update", &image, "--all", "/nothing/of/this/name"], "/nothing/of/this/name"),
        (vec!["update", &image, "--all", &image], "update-all-usage"),
    ] {
        let run = Run::of(&[&["--lang", "en"], &words[..]].concat());
        assert!(run.code == 2 && run.err.contains(word), "{words:?}: {run:?}");
    }
}
