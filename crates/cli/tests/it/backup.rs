//! `lafet param backup|diff|restore` on simulated monitors.

use std::path::PathBuf;

use crate::between::{Fate, between};
use crate::support::{Run, Running, Sim, lafet};
use lafet_proto::RequestId;
use serde_json::json;

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn set(sim: &Sim, who: &str, name: &str, value: &str) {
    sim.done(&["param", "set", who, name, value]);
}

#[test]
fn what_was_backed_up_comes_back_and_only_that_is_written() {
    let sim = Sim::start(&["--speed", "20"]);
    let folder = folder("backup-back");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    sim.done(&["program", "set", "3", "--centre", "30deg,-2deg", "--distance", "25"]);
    let kept = sim.value(&["param", "backup", file, "--firmware", "2.4"]);
    assert!(kept["parameters"].as_u64().unwrap() > 70, "{kept}");
    let text = std::fs::read_to_string(file).unwrap();
    for line in
        ["profile = \"full\"", "firmware = \"2.4\"", "[Vertical]", "Program3 = [1800, -120,"]
    {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert!(!text.contains("FaultInfo ="), "{text}");
    assert_eq!(sim.run(&["param", "backup", file]).code, 2, "the file already exists");
    assert!(sim.done(&["param", "diff", file]).out.contains("No differences"));

    set(&sim, "vertical", "Speed", "3");
    set(&sim, "general", "Address", "9");
    sim.done(&["program", "clear", "3"]);
    let run = sim.run(&["param", "diff", file]);
    assert!(run.code == 1 && run.out.contains("12 °/s"), "{run:?}");
    assert_eq!(run.out.lines().count(), 4, "{run:?}");
    let run = sim.done(&["param", "restore", file, "--dry-run", "--force"]);
    assert!(run.out.contains("Vertical.Speed") && run.out.contains('→'), "{run:?}");
    assert_eq!(sim.value(&["param", "get", "vertical", "Speed"])["values"], json!([3]));

    let some = ["param", "restore", file, "--force", "--except", "Control.Program3"];
    let restored = sim.value(&some);
    let written = restored["written"].as_array().unwrap();
    let names: Vec<&str> = written.iter().map(|one| one["parameter"].as_str().unwrap()).collect();
    assert_eq!(names, ["Vertical.Speed", "General.Address"], "the change of address comes last");
    assert!(written.iter().all(|one| one["result"] == "stored"), "{restored}");
    assert_eq!(restored["restart"], json!(["General.Address"]));
    let run = sim.done(&["--lang", "ru", "param", "restore", file]);
    assert!(run.out.contains("Control.Program3") && run.out.contains("сохранено"), "{run:?}");
    assert!(sim.done(&["param", "restore", file]).out.contains("nothing to write"));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "the journal is removed");
}

/// §3.19: everything is unset; §2 IncompleteConfig until a subsystem's last value is set.
#[test]
fn an_erased_monitor_is_restored() {
    let sim = Sim::start(&["--speed", "40"]);
    let folder = folder("backup-erased");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    set(&sim, "vertical", "Speed", "7");
    sim.done(&["param", "backup", file]);
    sim.done(&["send", "CleanFlash General"]);
    let invalid = || sim.run(&["status", "vertical"]).out.contains("ConfigInvalid");
    assert!((0..200).any(|_| invalid()), "it restarts without parameters");
    let diff = sim.run(&["param", "diff", file]);
    assert!(diff.code == 1 && diff.out.contains("Vertical.Speed"), "{diff:?}");
    let restored = sim.value(&["param", "restore", file]);
    let written = restored["written"].as_array().unwrap();
    assert!(written.len() > 40 && written.iter().all(|one| one["done"] == true), "{restored}");
    assert!(!invalid());
    assert!(sim.done(&["param", "diff", file]).out.contains("No differences"));
}

#[test]
fn an_interrupted_restore_goes_on() {
    let sim = Sim::start(&[]);
    let folder = folder("backup-interrupted");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    sim.done(&["param", "backup", file]);
    for who in ["vertical", "horizontal", "nozzle", "deployer"] {
        set(&sim, who, "Speed", "2");
        set(&sim, who, "MaxCurrent", "77");
    }
    let mut command = lafet();
    command.args(["-c", sim.url(), "param", "restore", file]);
    let mut running = Running::stderr(&mut command);
    while !running.line().contains("writing Horizontal") {}
    running.signal("INT");
    assert_eq!(running.code(), Some(130));
    let journal = std::fs::read_to_string(format!("{file}.restoring")).unwrap();
    assert!(journal.contains("started Horizontal."), "{journal}");
    let done = journal.lines().filter(|line| line.starts_with("stored ")).count();
    let restored = sim.value(&["param", "restore", file]);
    assert_eq!(restored["written"].as_array().unwrap().len(), 8 - done, "{journal} {restored}");
    assert!(sim.done(&["param", "diff", file]).out.contains("No differences"));
    // A write that began and is not known to be stored is repeated, although the value reads back
    // correctly.
    let url = format!("{}?addr=1", sim.url());
    let journal = format!("monitor {url}\nstarted Nozzle.Speed\n");
    std::fs::write(format!("{file}.restoring"), journal).unwrap();
    let restored = sim.value(&["param", "restore", file]);
    assert_eq!(restored["written"][0]["parameter"], "Nozzle.Speed", "{restored}");
}

#[test]
fn refusals_and_other_monitors() {
    let sim = Sim::start(&[]);
    let mini = Sim::start(&["--profile", "mini"]);
    let folder = folder("backup-refusals");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (full, small, bad) = (path("full.toml"), path("small.toml"), path("bad.toml"));
    sim.done(&["param", "backup", &full]);
    mini.done(&["param", "backup", &small]);
    let run = Run::of(&["param", "diff", &full, &small]);
    assert!(run.code == 1 && run.out.contains("General.Chain") && run.out.contains('—'), "{run:?}");
    let run = mini.run(&["param", "restore", &full, "--dry-run"]);
    assert!(run.out.contains("Skipped") && run.out.contains("Deployer.Speed"), "{run:?}");
    assert!(run.code == 2 && run.err.contains("--except General.Chain"), "{run:?}");
    let run = mini.run(&["param", "restore", &full]);
    assert!(run.code == 2 && run.err.contains("--except General.Chain"), "{run:?}");
    mini.done(&["param", "restore", &full, "--except", "General.Chain"]);
    for (text, word) in [
        ("", "format = 2"),
        ("format = 1\n[Vertical]\nSpeed = 999\n", "Vertical.Speed"),
        ("format = 1\n[Vertical]\nSped = 9\n", "Vertical.Sped"),
    ] {
        std::fs::write(&bad, text).unwrap();
        let run = sim.run(&["param", "restore", &bad]);
        assert!(run.code == 2 && run.err.contains(word), "{run:?}");
    }
    // §3.17: while limits are off, only the present position is accepted as a limit, so this one is
    // refused.
    sim.done(&["limits", "off", "vertical"]);
    std::fs::write(&bad, "format = 1\n[Vertical]\nMaxLimit = 3333\nSpeed = 5\n").unwrap();
    let run = sim.run(&["param", "restore", &bad]);
    assert!(run.code == 1 && run.out.contains("InvalidValue"), "{run:?}");
    assert_eq!(sim.value(&["param", "get", "vertical", "Speed"])["values"], json!([5]));
    assert_eq!(sim.run(&["param", "restore", "/nowhere/x.toml"]).code, 2);
}

/// What is wrong in a file is said in the language of the user, with its line.
#[test]
fn a_file_that_is_no_toml_is_refused_in_words() {
    let folder = folder("backup-no-toml");
    for (name, text, line, en, ru) in [
        ("a.toml", "format = 1\n[Vertical\n", 2, "unclosed table", "заголовок не закрыт"),
        ("b.toml", "format = 1\nformat = 1\n", 2, "duplicate key", "ключ указан дважды"),
        ("c.toml", "format 1\n", 1, "key with no value", "ключ без значения"),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap();
        for (lang, words) in [("en", [en, "line"]), ("ru", [ru, "строка"])] {
            let run = Run::of(&["--lang", lang, "param", "diff", path, path]);
            assert!(run.code == 2 && words.iter().all(|it| run.err.contains(it)), "{run:?}");
            assert!(run.err.contains(&format!("{} {line}:", words[1])), "{run:?}");
            assert!(lang == "en" || !run.err.contains("expected"), "{run:?}");
        }
    }
}

/// Files beside the backup are not touched, and a backup that fails leaves none.
#[test]
fn files_beside_a_backup_are_kept() {
    let sim = Sim::start(&[]);
    let folder = folder("backup-beside");
    let file = folder.join("one.toml");
    let other = folder.join("one.toml.new");
    std::fs::write(&other, "kept").unwrap();
    sim.done(&["param", "backup", file.to_str().unwrap()]);
    let none = folder.join("none.toml");
    let away = ["-c", "tcp://127.0.0.1:1", "param", "backup", none.to_str().unwrap()];
    assert_eq!(Run::of(&away).code, 3);
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "kept");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
}

/// The journal of a monitor outlives the restore of another from the same backup.
#[test]
fn monitors_share_the_journal_of_a_backup() {
    let (one, two) = (Sim::start(&[]), Sim::start(&[]));
    let folder = folder("backup-shared");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    one.done(&["param", "backup", file]);
    let journal = format!("monitor {}?addr=1\nstarted Nozzle.Speed\n", one.url());
    std::fs::write(format!("{file}.restoring"), journal).unwrap();
    set(&two, "vertical", "Speed", "3");
    two.done(&["param", "restore", file]);
    let restored = one.value(&["param", "restore", file]);
    assert_eq!(restored["written"][0]["parameter"], "Nozzle.Speed", "{restored}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "then the journal is removed");
}

/// A file that cannot be written is an error before the monitor is asked anything.
#[test]
fn a_file_that_cannot_be_written_is_known_before_the_first_request() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let url = format!("tcp://{}", listener.local_addr().unwrap());
    let run = Run::of(&["-c", &url, "param", "backup", "/nothing/of/this/name/one.toml"]);
    assert!(run.code == 2 && run.err.contains("/nothing/of/this/name"), "{run:?}");
    assert!(listener.accept().is_err(), "it connected");
}

/// A monitor's file is not written to its twin: two monitors would have one address after the next restart.
#[test]
fn the_file_of_a_twin_is_refused() {
    let (one, two) = (Sim::start(&[]), Sim::start(&[]));
    let folder = folder("backup-twin");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    one.done(&["param", "backup", file]);
    set(&two, "general", "Address", "2");
    set(&two, "vertical", "Speed", "3");
    let speed = || two.value(&["param", "get", "vertical", "Speed"])["values"][0].clone();
    for words in [&["param", "restore", file] as &[&str], &["param", "restore", file, "--dry-run"]]
    {
        let run = two.run(words);
        assert!(run.code == 2 && run.err.contains("--except General.Address"), "{run:?}");
        assert!(run.err.contains("the address 1") && run.err.contains("has 2"), "{run:?}");
    }
    assert_eq!(speed(), 3);
    two.done(&["param", "restore", file, "--except", "General.Address"]);
    assert_ne!(speed(), 3);
    assert_eq!(two.value(&["param", "get", "general", "Address"])["values"], json!([2]));
    two.done(&["param", "restore", file, "--force"]);
    assert_eq!(two.value(&["param", "get", "general", "Address"])["values"], json!([1]));
}

/// A part of a file is refused; one of the first format, which has no end, is taken with a warning.
#[test]
fn a_file_that_was_cut_is_refused() {
    let sim = Sim::start(&[]);
    let folder = folder("backup-cut");
    let path = folder.join("one.toml");
    let file = path.to_str().unwrap();
    sim.done(&["param", "backup", file]);
    let text = std::fs::read_to_string(&path).unwrap();
    let cut = text.find("MaxLimit = ").unwrap() + "MaxLimit = 1".len();
    std::fs::write(&path, &text[..cut]).unwrap();
    let run = sim.run(&["param", "restore", file]);
    assert!(run.code == 2 && run.err.contains("`# end`"), "{run:?}");
    std::fs::write(&path, "format = 1\n[Vertical]\nSpeed = 5\n").unwrap();
    let run = sim.done(&["param", "restore", file]);
    assert!(run.err.contains("Make sure that it is whole"), "{run:?}");
}

/// A parameter whose unit does not answer is not "not set": the backup before is kept.
#[test]
fn a_backup_without_some_values_replaces_none() {
    let sim = Sim::start(&["--profile", "ex", "--fault", "vertical-unit-offline"]);
    let folder = folder("backup-missed");
    let path = folder.join("one.toml");
    std::fs::write(&path, "kept").unwrap();
    let run = sim.run(&["param", "backup", "--force", path.to_str().unwrap()]);
    assert!(run.code == 1 && run.err.contains("did not supply"), "{run:?}");
    assert!(run.err.contains("Vertical.") && !run.err.contains("Horizontal."), "{run:?}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "kept");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

/// The URL of a line to the monitor that is dead from the first parameter on.
fn silent(sim: &Sim) -> String {
    let mut cut = false;
    between(sim, move |asked| {
        cut |= asked.iter().any(|one| one.request == RequestId::GET_PARAM);
        if cut { Fate::Lost } else { Fate::Passed }
    })
}

/// Without an answer it is not known what a restore would write.
#[test]
fn a_dry_run_on_a_dead_line_fails() {
    let sim = Sim::start(&[]);
    let folder = folder("backup-dead");
    let file = folder.join("one.toml");
    let file = file.to_str().unwrap();
    sim.done(&["param", "backup", file]);
    let run = Run::of(&["-c", &silent(&sim), "param", "restore", file, "--dry-run", "--force"]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(!run.out.contains('→'), "{run:?}");
}

/// A backup that a signal ends leaves nothing.
#[cfg(unix)]
#[test]
fn an_interrupted_backup_leaves_no_file() {
    let sim = Sim::start(&[]);
    let folder = folder("backup-signal");
    let file = folder.join("one.toml");
    let mut command = lafet();
    command.args(["-c", &silent(&sim), "--timeout", "30", "param", "backup"]).arg(&file);
    let mut running = Running::stderr(&mut command);
    let files = || std::fs::read_dir(&folder).unwrap().count();
    while files() == 0 {
        std::thread::park_timeout(std::time::Duration::from_millis(5));
    }
    running.signal("INT");
    assert_eq!(running.code(), Some(130));
    assert_eq!(files(), 0);
}

/// A link stays one, and what it leads to keeps its permissions.
#[cfg(unix)]
#[test]
fn what_a_link_leads_to_is_replaced() {
    use std::os::unix::fs::{PermissionsExt, symlink};

    let sim = Sim::start(&[]);
    let folder = folder("backup-link");
    let (real, link) = (folder.join("real.toml"), folder.join("link.toml"));
    std::fs::write(&real, "old").unwrap();
    std::fs::set_permissions(&real, PermissionsExt::from_mode(0o600)).unwrap();
    symlink(&real, &link).unwrap();
    sim.done(&["param", "backup", "--force", link.to_str().unwrap()]);
    assert!(link.is_symlink());
    assert!(std::fs::read_to_string(&real).unwrap().contains("[Vertical]"));
    assert_eq!(std::fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o600);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
}
