//! The output of `--json` is exactly what docs/schema/cli-1.json describes.

use std::collections::BTreeSet;
use std::sync::Mutex;

use crate::support::{Run, Running, Sim, commands, lafet};
use serde_json::{Value, json};

const SCHEMA: &str = include_str!("../../../../docs/schema/cli-1.json");
const PAGE: &str = include_str!("../../../../docs/json.md");

/// The shape of a command's output lines, closed: a field that is not described fails.
struct Shapes {
    root: Value,
    seen: Mutex<BTreeSet<String>>,
}

impl Shapes {
    fn new() -> Self {
        let mut root: Value = serde_json::from_str(SCHEMA).expect("the schema is JSON");
        close(&mut root);
        Self { root, seen: Mutex::default() }
    }

    fn check(&self, shape: &str, value: &Value, what: &str) {
        assert!(self.root["$defs"].get(shape).is_some(), "{shape} is not described");
        let mut schema = self.root.clone();
        schema["$ref"] = json!(format!("#/$defs/{shape}"));
        let validator = jsonschema::validator_for(&schema).expect("a sound schema");
        let wrong: Vec<String> =
            validator.iter_errors(value).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(wrong.is_empty(), "{what}: {shape}: {wrong:?}\n{value}");
        self.seen.lock().unwrap().insert(shape.to_owned());
    }

    /// Checks each output line of a run.
    fn lines(&self, shape: &str, run: &Run, what: &[&str]) {
        let lines = run.json();
        assert!(!lines.is_empty(), "{what:?}: {run:?}");
        for line in &lines {
            self.check(shape, line, &what.join(" "));
        }
    }
}

/// Closes objects with listed fields: no other field is allowed.
fn close(value: &mut Value) {
    match value {
        Value::Object(object) => {
            if object.contains_key("properties") && !object.contains_key("additionalProperties") {
                object.insert("additionalProperties".into(), json!(false));
            }
            object.values_mut().for_each(close);
        }
        Value::Array(array) => array.iter_mut().for_each(close),
        _ => {}
    }
}

/// Fails unless a line has this shape.
pub fn has_shape(shape: &str, line: &str) {
    let value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
    Shapes::new().check(shape, &value, line);
}

fn of(words: &[&str]) -> Run {
    let mut all = vec!["--json"];
    all.extend(words);
    Run::of(&all)
}

/// Commands for a simulated monitor, in an order in which each can be done, and the shapes of what
/// they print.
fn on_monitor<'a>(
    url: &'a str,
    backup: &'a str,
    recording: &'a str,
) -> Vec<(&'static str, Vec<&'a str>)> {
    vec![
        ("status", vec!["status"]),
        ("watch", vec!["watch", "--count", "2", "--interval", "0.05"]),
        ("top", vec!["top", url, "--once"]),
        ("done", vec!["deploy"]),
        ("done", vec!["move", "vertical", "5deg"]),
        ("exchange", vec!["move", "horizontal", "2deg", "--no-wait"]),
        ("exchange", vec!["stop"]),
        ("exchange", vec!["send", "GetStatus All", "GetParam Vertical Speed"]),
        ("hotbeds", vec!["seek", "--from-az", "-9", "--to-az", "9"]),
        ("hotbeds", vec!["hotbeds"]),
        ("justify", vec!["justify"]),
        ("done", vec!["open"]),
        ("done", vec!["close"]),
        ("limits", vec!["limits"]),
        ("param", vec!["param", "get", "vertical", "MaxLimit"]),
        ("param", vec!["param", "set", "vertical", "Speed", "8"]),
        ("params", vec!["param", "list"]),
        ("backup", vec!["param", "backup", backup]),
        ("diff", vec!["param", "diff", backup]),
        ("program", vec!["program", "set", "3", "--centre", "5deg,0", "--distance", "25"]),
        ("program", vec!["program", "set", "1", "--point", "5deg,0,25,10"]),
        ("program", vec!["program", "show", "3"]),
        ("programs", vec!["program", "list"]),
        ("exchange", vec!["program", "run", "3"]),
        ("exchange", vec!["stop", "control"]),
        ("crash", vec!["crash"]),
        ("doctor", vec!["doctor"]),
        ("record", vec!["record", recording, "--for", "0.5"]),
        ("calibrate", vec!["calibrate", "--outlet", "28", "--dry-run"]),
        ("tune", vec!["tune", "horizontal", "--dry-run"]),
        ("restore", vec!["param", "restore", backup, "--dry-run"]),
        ("param", vec!["param", "set", "vertical", "Speed", "9"]),
        ("restore", vec!["param", "restore", backup]),
        ("limits-teach", vec!["limits", "teach", "--here", "left"]),
        ("exchange", vec!["lockout", "on"]),
        ("exchange", vec!["lockout", "off"]),
        ("scan", vec!["scan", "--addresses", "1-2"]),
        ("exchange", vec!["restart"]),
    ]
}

#[test]
fn every_output_is_as_described() {
    let shapes = Shapes::new();
    let folder = std::env::temp_dir().join(format!("lafet-json-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name).display().to_string();
    let sim = Sim::start(&["--speed", "50", "--fire", "az=5,range=25"]);
    let (backup, recording) = (file("one.toml"), file("one.mcap"));
    let on_monitor = on_monitor(sim.url(), &backup, &recording);
    for (shape, words) in &on_monitor {
        let mut all = vec!["-c", sim.url()];
        all.extend(words);
        let run = of(&all);
        assert_eq!(run.code, 0, "{words:?}: {run:?}");
        shapes.lines(shape, &run, words);
    }
    let site = file("hub.toml");
    let config = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1\"\n\
                  [[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://127.0.0.1:15020\"\n";
    std::fs::write(&site, config).unwrap();
    let (_, port) = sim.place().rsplit_once(':').unwrap();
    let (key, image) = (file("key0"), file("program.image"));
    let numbered = format!("0={key}");
    let signed = ["--board=bench", "--version=1.2", "--layouts=1-1", "--revokes=1"];
    let alone: Vec<(&str, Vec<&str>)> = vec![
        ("decode", vec!["decode", &recording]),
        ("decode", vec!["decode", "ff c0 01 81 4d 0d 00 02 a0 ab aa ac c0"]),
        ("decode", vec!["replay", &recording, "--speed", "0"]),
        ("calibrate", vec!["calibrate", "--outlet", "28"]),
        ("throw", vec!["throw", "--flow", "20", "--pressure", "0.8", "--elevation", "30"]),
        (
            "throw",
            vec!["throw", "--kind=smooth", "--outlet=19", "--pressure=4bar", "--elevation=5..9"],
        ),
        ("map", vec!["map", "modbus", &site]),
        ("image-key", vec!["image", "key", &key]),
        ("image-public", vec!["image", "public", "0", &key]),
        ("image", [&["image", "sign", "--key", &numbered, &site, &image], &signed[..]].concat()),
        ("image", vec!["image", "show", &image]),
        ("tests", vec!["conform", "--list"]),
        ("script", vec!["completions", "bash"]),
        ("page", vec!["man"]),
        ("schema", vec!["schema"]),
        ("version", vec!["--version"]),
        ("scan", vec!["scan", "127.0.0.1", "--port", port, "--addresses", "1-2"]),
    ];
    for (shape, words) in &alone {
        let run = of(words);
        assert_eq!(run.code, 0, "{words:?}: {run:?}");
        shapes.lines(shape, &run, words);
    }
    let place = ["sim", "--listen", "tcp://127.0.0.1:0"];
    let listening = Running::stdout(lafet().arg("--json").args(place));
    shapes.check("listening", &serde_json::from_str(&listening.line()).unwrap(), "sim");
    // Its faults are no failure of the command, but its exit code reports them.
    let nowhere = ["doctor", "--install", "--config", "/nothing/of/this/name"];
    shapes.lines("doctor-install", &of(&nowhere), &nowhere);
    // Every kind of failure.
    for (code, words) in [
        (1, vec!["-c", "sim:", "move", "vertical", "1"]),
        (2, vec!["status"]),
        (2, vec!["-c", "sim:", "move", "vertical"]),
        (3, vec!["-c", "tcp://127.0.0.1:1", "--timeout", "0.1", "status"]),
        (2, vec!["-c", "sim:", "program", "run", "5"]),
    ] {
        let run = of(&words);
        assert_eq!(run.code, code, "{words:?}: {run:?}");
        shapes.lines("error", &run, &words);
    }
    std::fs::remove_dir_all(&folder).unwrap();
    every_shape_is_seen(shapes);
}

/// And named on the page.
fn every_shape_is_seen(shapes: Shapes) {
    let seen = shapes.seen.into_inner().unwrap();
    for shape in shapes.root["$defs"].as_object().unwrap().keys() {
        assert!(PAGE.contains(&format!("`{shape}`")), "docs/json.md does not name `{shape}`");
        let part = ["hex", "state", "states", "device", "frame", "noise", "summary", "figure"];
        // The tests of `ports`, `bus` and `update` check theirs; `jog` needs a terminal.
        let elsewhere = ["port", "jog", "bus", "bus-who", "bus-log", "bus-totals"];
        let updates = ["update", "update-all", "update-state"];
        let known = seen.contains(shape)
            || part.contains(&shape.as_str())
            || elsewhere.contains(&shape.as_str())
            || updates.contains(&shape.as_str());
        assert!(known, "no command prints `{shape}`");
    }
}

/// The page has each command in its table, or among those whose output is not described.
#[test]
fn every_command_is_on_the_page() {
    let quoted: Vec<&str> = PAGE.split('`').skip(1).step_by(2).collect();
    for command in commands() {
        let with_more = format!("{command} ");
        let named = |words: &&&str| **words == command || words.starts_with(&with_more);
        assert!(quoted.iter().any(|words| named(&words)), "docs/json.md does not name {command}");
    }
}
