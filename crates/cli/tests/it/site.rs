//! `lafet site test` as a user runs it: against `lafet serve`, and with what is wrong with its arguments.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{Run, Running, Sim, lafet};

struct Place {
    folder: PathBuf,
}

impl Place {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("site-{name}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Self { folder }
    }

    fn file(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).to_str().unwrap().to_owned()
    }

    /// A hub for a monitor, with zones that need nothing else, and its URL.
    fn hub(&self, sim: &Sim) -> (Running, String) {
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"{}?addr=1\"\npoll_ms = 100\n",
            sim.url()
        );
        let config = self.file("hub.toml", &text);
        let mut command = lafet();
        command.args(["--json", "serve", "--no-browser", "--config", &config]);
        let running = Running::stdout(&mut command);
        let line: Value = serde_json::from_str(&running.line()).unwrap();
        let url = line["listening"].as_str().unwrap().trim_end_matches('/').to_owned();
        until_up(url.trim_start_matches("http://"));
        (running, url)
    }
}

/// Waits until the hub hears its monitor.
fn until_up(place: &str) {
    let began = Instant::now();
    loop {
        let mut stream = TcpStream::connect(place).unwrap();
        let ask = format!("GET /health HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\r\n");
        stream.write_all(ask.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        if answer.contains("\"M1\":\"up\"") {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "{answer}");
    }
}

const PLAN: &str =
    "name = \"One\"\n[[monitor]]\nid = \"M1\"\nparams = { \"Control.NozzleDiameter\" = [280] }\n";

#[test]
fn a_site_is_tested_over_its_hub_and_the_record_is_kept() {
    let place = Place::new("read");
    let sim = Sim::start(&["--profile", "remote"]);
    let (_hub, url) = place.hub(&sim);
    let plan = place.file("plan.toml", PLAN);
    let (record, page) = (place.path("record.json"), place.path("record.html"));
    let mut arguments = vec!["--json", "site", "test", &plan, "--hub", &url, "--only", "read"];
    arguments.extend(["--record", &record, "--page", &page, "--by", "T. Ester"]);
    let run = Run::of(&arguments);
    // A hub without login is a finding.
    assert_eq!(run.code, 1, "{run:?}");
    let value = &run.json()[0];
    let results = value["results"].as_array().unwrap();
    let verdict = |check: &str| {
        let of = results.iter().find(|it| it["check"] == check);
        of.unwrap_or_else(|| panic!("{check}"))["verdict"].as_str().unwrap().to_owned()
    };
    assert_eq!((verdict("link"), verdict("parameters")), ("pass".into(), "pass".into()));
    assert_eq!((verdict("login"), verdict("heading")), ("fail".into(), "not_tried".into()));
    let kept: Value = serde_json::from_slice(&fs::read(&record).unwrap()).unwrap();
    assert_eq!((&kept, kept["by"].as_str()), (value, Some("T. Ester")));
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("Acceptance record") && page.contains("Протокол испытаний"));
    is_signed(&place, &plan, &url);
    let russian =
        Run::of(&["--lang", "ru", "site", "test", &plan, "--hub", &url, "--only", "read"]);
    assert!(russian.out.contains("ОТКАЗ") && russian.out.contains("не проверено"), "{russian:?}");
}

/// A record is kept by its date and signed; what was changed in it shows, and the calendar knows it.
fn is_signed(place: &Place, plan: &str, url: &str) {
    let key = place.file("tester.key", &"1f".repeat(32));
    let folder = place.path("records");
    let test = ["site", "test", plan, "--hub", url, "--only", "read", "--records", &folder];
    let run = Run::of(&[&test[..], &["--key", &key]].concat());
    assert_eq!(run.code, 1, "{run:?}");
    let files = fs::read_dir(&folder).unwrap().map(|it| it.unwrap().path());
    let mut files: Vec<PathBuf> = files.collect();
    files.sort();
    let ends: Vec<&str> =
        files.iter().map(|it| it.extension().unwrap().to_str().unwrap()).collect();
    assert_eq!(ends, ["html", "json", "sig"], "{files:?}");
    let record = files[1].to_str().unwrap();
    let verify = |more: &[&str]| {
        let run = Run::of(&[&["--json", "site", "verify", record], more].concat());
        (run.code, run.json()[0]["public"].as_str().unwrap().to_owned())
    };
    let (code, public) = verify(&[]);
    assert!(code == 0 && run.out.contains(&public), "{run:?}");
    assert_eq!(verify(&["--public", &public.to_uppercase()]).0, 0);
    assert_eq!(verify(&["--public", &"00".repeat(32)]).0, 1);
    assert!(fs::read_to_string(&files[0]).unwrap().contains(&public));
    // The plan wants it daily, and the dry step weekly: that one was never tried.
    let with = |days: &str| place.file("calendar.toml", &format!("{PLAN}[calendar]\n{days}\n"));
    let calendar = |days: &str| {
        let run = Run::of(&["--json", "site", "calendar", &with(days), "--records", &folder]);
        (run.code, run.json().remove(0))
    };
    let (code, value) = calendar("read_days = 1\ndry_days = 7");
    assert_eq!(code, 1, "{value}");
    let (read, dry) = (&value["steps"][0], &value["steps"][1]);
    assert!(read["overdue"] == false && read["good"] == false, "no login is a failure: {value}");
    assert!(dry["overdue"] == true && dry["last"].is_null() && value["records"][0]["fail"] != 0);
    let changed = fs::read_to_string(record).unwrap().replace("\"fail\"", "\"pass\"");
    fs::write(record, changed).unwrap();
    assert_eq!(verify(&[]).0, 1, "it was changed");
    let none = Run::of(&["site", "calendar", plan, "--records", &folder]);
    assert!(none.code == 2 && none.err.contains("no calendar"), "{none:?}");
}

/// Without a person nothing moves: neither a terminal nor an answer has allowed it.
#[test]
fn without_a_yes_nothing_moves_and_with_one_of_a_file_it_does() {
    let place = Place::new("dry");
    let sim = Sim::start(&["--profile", "remote", "--speed", "4"]);
    let (_hub, url) = place.hub(&sim);
    let plan = place.file("plan.toml", PLAN);
    let test = |more: &[&str]| {
        let mut arguments = vec!["--json", "site", "test", &plan, "--hub", &url, "--only", "dry"];
        arguments.extend(more);
        let run = Run::of(&arguments);
        let value = run.json().remove(0);
        let of = |check: &str| {
            let results = value["results"].as_array().unwrap();
            results.iter().find(|it| it["check"] == check).unwrap()["verdict"].clone()
        };
        (run.code, of("motion"), value["ordered"].as_array().unwrap().len())
    };
    // Nothing tried is no success.
    assert_eq!(test(&[]), (1, "not_tried".into(), 0));
    let answers = place.file("answers.toml", "\"dry/*/go\" = true\n");
    let (code, motion, ordered) = test(&["--answers", &answers]);
    assert_eq!((code, motion), (0, "pass".into()));
    assert!(ordered >= 5, "{ordered}");
}

/// A hub that does not answer holds up no Ctrl-C.
#[cfg(unix)]
#[test]
fn a_stop_does_not_wait_for_an_answer_of_the_hub() {
    let place = Place::new("hung");
    let plan = place.file("plan.toml", PLAN);
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", silent.local_addr().unwrap());
    let mut command = lafet();
    command.args(["site", "test", &plan, "--hub", &url, "--only", "read"]);
    let mut running = Running::stderr(&mut command);
    let _asked = silent.accept().unwrap();
    running.signal("INT");
    let began = Instant::now();
    assert_eq!(running.code(), Some(130));
    // An answer is waited for 5 s.
    assert!(began.elapsed() < Duration::from_secs(3), "{:?}", began.elapsed());
}

/// A person at the terminal answers one question after another, also while the hub is asked.
#[cfg(unix)]
#[test]
fn a_person_at_the_terminal_answers() {
    let place = Place::new("person");
    let sim = Sim::start(&["--profile", "remote", "--speed", "4"]);
    let (_hub, url) = place.hub(&sim);
    let plan = place.file(
        "plan.toml",
        "name = \"One\"\n[[target]]\nname = \"door\"\nat = [0.0, 20.0, 2.0]\n[[monitor]]\nid = \"M1\"\n\
         at = [0.0, 0.0]\nheading = 0.0\nheight = 2.0\ntarget = \"door\"\n",
    );
    let record = place.path("record.json");
    let (mut keys, path) = crate::support::terminal();
    let mut command = lafet();
    command.args(["site", "test", &plan, "--hub", &url, "--only", "dry", "--record", &record]);
    command.stdin(fs::File::options().read(true).write(true).open(&path).unwrap());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let answers = [
        ("around every other one", "y"),
        ("sees where it points", "y"),
        ("Which monitor has turned", "M1"),
        ("By how many degrees", "-0,5"),
        ("turns back now", "y"),
    ];
    // What is typed right after a question is no answer to it: it is shown again, and answered again.
    for line in BufReader::new(child.stderr.take().unwrap()).lines() {
        let line = line.unwrap();
        let asked = answers.iter().find(|(question, _)| line.contains(question));
        asked.iter().for_each(|(_, answer)| writeln!(keys, "{answer}").unwrap());
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let record: Value = serde_json::from_slice(&fs::read(&record).unwrap()).unwrap();
    let given: Vec<&str> = record["answers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["answer"].as_str().unwrap())
        .collect();
    assert_eq!(given, ["yes", "yes", "M1", "-0.5", "yes"]);
}

#[test]
fn what_is_wrong_with_files_and_arguments_is_said() {
    let place = Place::new("wrong");
    let plan = place.file("plan.toml", PLAN);
    let unknown = place.file("unknown.toml", "[[monitor]]\nid = \"M1\"\nhieght = 2\n");
    let names = place.file("names.toml", "[[zone]]\nid = \"hall\"\nmonitors = [\"M9\"]\n");
    let answers = place.file("answers.toml", "\"dry/M1/go\" = [1]\n");
    let none = place.path("none.toml");
    let key = place.file("short.key", "1f1f");
    let hub = "http://127.0.0.1:1";
    let cases: [(&[&str], i32, &str); 10] = [
        (&[&plan, "--key", &key], 2, "--key signs a record"),
        (&[&plan, "--key", &key, "--record", "r.json"], 2, "64 hexadecimal digits"),
        (&[&plan, "--hub", hub], 3, "is not reached"),
        (&[&plan, "--hub", "127.0.0.1:8480"], 2, "is no address of a hub"),
        (&[&plan, "--hub", "ftp://h"], 2, "is no address of a hub"),
        (&[&unknown], 2, "unknown.toml:3: `hieght` is not known"),
        (&[&names], 2, "The plan names monitor “M9”"),
        (&[&plan, "--answers", &answers], 2, "answers.toml:1"),
        (&[&none], 2, "none.toml"),
        (&[&plan, "--only", "water"], 2, "water"),
    ];
    for (arguments, code, text) in cases {
        let run = Run::of(&[&["site", "test"], arguments].concat());
        assert_eq!(run.code, code, "{arguments:?}: {run:?}");
        assert!(run.err.contains(text) || run.out.contains(text), "{arguments:?}: {run:?}");
    }
}
