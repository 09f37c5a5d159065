//! `lafet sim run` and `lafet sim --site`, as a trainer uses them.

use crate::support::{Run, Sim};
use serde_json::Value;

#[test]
fn a_shipped_scenario_is_run_and_drawn() {
    let dir = std::env::temp_dir().join(format!("lafet-exercise-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let (svg, trace) = (dir.join("a.svg"), dir.join("a.txt"));
    let paths = (svg.to_str().unwrap(), trace.to_str().unwrap());
    let run = Run::of(&["sim", "run", "jammed-drive", "--svg", paths.0, "--trace", paths.1]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{}", run.out);
    assert!(run.out.contains("a steel rope") && run.out.contains("PASSED"), "{}", run.out);
    let picture = std::fs::read_to_string(&svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("horizontal-jam"));
    assert!(std::fs::read_to_string(&trace).unwrap().starts_with("M1 t=0.00 "));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Exit code 1 when an expectation fails, 2 when the file is not valid; JSON for programs.
#[test]
fn exit_codes_and_json() {
    let dir = std::env::temp_dir().join(format!("lafet-exercise-codes-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let file = dir.join("x.toml");
    let path = file.to_str().unwrap();
    let text = Run::of(&["sim", "run", "radio-loss", "--show"]).out;
    std::fs::write(&file, text.replace("water <= 2500", "water <= 25")).unwrap();
    let run = Run::of(&["sim", "run", path, "--report", "json"]);
    assert_eq!(run.code, 1, "{}", run.err);
    let json: Value = serde_json::from_str(run.out.lines().next().unwrap()).unwrap();
    assert_eq!(json["passed"], false);
    let failed = json["checks"].as_array().unwrap().iter().filter(|check| check["passed"] == false);
    assert_eq!(failed.count(), 1);
    std::fs::write(&file, text.replace("heading = 0", "heding = 0")).unwrap();
    let run = Run::of(&["sim", "run", path, "--lang", "ru"]);
    assert_eq!((run.code, run.out.as_str()), (2, ""));
    assert!(
        run.err.contains("x.toml:23: monitor.heding: ") && run.err.contains("heading"),
        "{}",
        run.err
    );
    assert_eq!(Run::of(&["sim", "run", "nothing"]).code, 2);
    let list = Run::of(&["sim", "run", "--list", "--lang", "ru"]);
    assert!(list.code == 0 && list.out.lines().count() == 8 && list.out.contains("Ангар"));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Three monitors on one bus, each at its address, each with its fires.
#[test]
fn the_monitors_of_a_site_are_served() {
    let sim = Sim::start(&["--site", "tank-farm", "--speed", "50"]);
    let first = sim.url().strip_prefix("M1 ").expect("its name").to_owned();
    for address in ["1", "2", "3"] {
        let url = first.replace("addr=1", &format!("addr={address}"));
        let run = Run::of(&["-c", &url, "--json", "status", "deployer"]);
        assert_eq!(run.code, 0, "{}", run.err);
        assert!(run.out.contains("Wrapped"), "{}", run.out);
    }
    let nobody = first.replace("addr=1", "addr=9");
    assert_eq!(Run::of(&["-c", &nobody, "--timeout", "0.2", "status"]).code, 3);
    let run =
        Run::of(&["-c", &first, "seek", "--from-az", "-30", "--to-az", "30", "--to-el", "15"]);
    assert_eq!(run.code, 0, "{} {}", run.out, run.err);
}
