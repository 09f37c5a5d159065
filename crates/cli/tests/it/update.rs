//! `lafet image` and `lafet update` on simulated monitors: from a key to a new version, by commands alone.

mod all;
#[cfg(target_os = "linux")]
mod line;
mod ways;

use std::fs;
use std::path::PathBuf;

use crate::between::{Asked, Fate, between};
use crate::json::has_shape;
use crate::support::{Run, Running, Sim, lafet};
use lafet_proto::RequestId;
use serde_json::{Value, json};

/// Bytes of a header.
const HEADER: usize = 160;
/// The order that confirms.
const CONFIRM: u8 = 5;

/// Who makes images for the board `bench`, with key 0.
struct Maker {
    folder: PathBuf,
}

impl Maker {
    fn new(name: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let maker = Self { folder };
        done(&["image", "key", &maker.path("key0")]);
        done(&["image", "public", "0", &maker.path("key0"), &maker.path("key0.pub")]);
        maker
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).to_str().unwrap().to_owned()
    }

    /// The image of a program of so many bytes.
    fn image(&self, version: &str, size: usize) -> String {
        self.signed(version, size, "bench", "0")
    }

    fn signed(&self, version: &str, size: usize, board: &str, key: &str) -> String {
        let image = self.path(&format!("{version}-{board}-{key}.image"));
        let program = self.path("program");
        fs::write(&program, version.bytes().cycle().take(size).collect::<Vec<u8>>()).unwrap();
        let key = format!("{key}={}", self.path("key0"));
        done(&[
            "image",
            "sign",
            "--key",
            &key,
            "--board",
            board,
            "--version",
            version,
            "--layouts",
            "1-1",
            &program,
            &image,
        ]);
        image
    }

    /// A monitor that takes these images.
    fn monitor(&self, more: &[&str]) -> Sim {
        let key = format!("0={}", self.path("key0.pub"));
        Sim::start(&[&["--board", "bench", "--update-key", &key], more].concat())
    }
}

fn done(words: &[&str]) -> Run {
    let run = Run::of(words);
    assert_eq!(run.code, 0, "{words:?}: {run:?}");
    run
}

/// What the monitor reports of itself.
fn state(sim: &Sim) -> Value {
    let state = sim.value(&["update", "--state"]);
    has_shape("update-state", &state.to_string());
    state
}

/// The note with the word of the monitor at this URL.
fn note(url: &str) -> PathBuf {
    let command = lafet();
    let mut set = command.get_envs();
    let folder = set.find_map(|(name, value)| value.filter(|_| name == "XDG_STATE_HOME"));
    let (_, place) = url.split_once("://").unwrap();
    let place = place.split('?').next().unwrap().replace(':', "-");
    PathBuf::from(folder.unwrap()).join(format!("lafet/update/tcp-{place}-1.word"))
}

#[test]
fn from_a_key_to_a_new_version() {
    let maker = Maker::new("update-walk");
    let image = maker.image("1.1", 3000);
    let public = format!("0={}", maker.path("key0.pub"));
    let shown = done(&["image", "show", &image, "--public", &public]);
    for word in ["bench", "1.1.0.0", "3000", "either", "right"] {
        assert!(shown.out.contains(word), "{word}: {shown:?}");
    }
    let sim = maker.monitor(&["--speed", "10"]);
    sim.done(&["deploy"]);
    sim.done(&["wrap"]);
    sim.done(&["lockout", "on"]);
    let before = state(&sim);
    assert_eq!((&before["version"], &before["slot"]), (&json!("1.0.0.0"), &json!("A")));
    let run = sim.done(&["update", &image, "--watch", "5"]);
    assert!(run.out.contains("1.0.0.0 → 1.1.0.0, confirmed."), "{run:?}");
    assert!(run.out.contains("lafet lockout off"), "{run:?}");
    assert!(run.err.contains("sending: ") && run.err.contains("on trial"), "{run:?}");
    let after = state(&sim);
    assert_eq!((&after["version"], &after["slot"]), (&json!("1.1.0.0"), &json!("B")));
    assert_eq!((&after["on_trial"], &after["last_trial_failed"]), (&json!(false), &json!(false)));
    let hash = done(&["--json", "image", "show", &image]).json()[0]["sha256"].clone();
    assert_eq!(after["image"], hash.as_str().unwrap()[..8], "what runs is known by its hash");
    assert!(sim.flags("general").contains(&"LockedOut".to_owned()));
    assert!(!note(sim.url()).exists(), "the word is of no use any more");
    sim.done(&["lockout", "off"]);
    sim.done(&["deploy"]);
    // The same once more says so, in whatever state the monitor is.
    let again = sim.done(&["update", &image, "--watch", "5"]);
    assert!(again.out.contains("1.1.0.0"), "{again:?}");
    assert_eq!(sim.value(&["update", &image, "--watch", "5"])["stage"], "running-already");
}

/// What is missing is named in the language of the user, and nothing is changed.
#[test]
fn a_monitor_that_is_not_ready() {
    let maker = Maker::new("update-not-ready");
    let image = maker.image("1.1", 400);
    let sim = maker.monitor(&["--speed", "10"]);
    let run = sim.run(&["update", &image, "--watch", "5"]);
    assert!(run.code == 1 && run.err.contains("lafet lockout on"), "{run:?}");
    let run = sim.run(&["--lang", "ru", "update", &image, "--watch", "5"]);
    assert!(run.code == 1 && run.err.contains("lafet lockout on"), "{run:?}");
    assert!(run.err.chars().any(|c| ('а'..='я').contains(&c)), "{run:?}");
    let state = state(&sim);
    assert_eq!((&state["version"], &state["phase"]), (&json!("1.0.0.0"), &json!("idle")));
    assert!(!sim.flags("general").contains(&"LockedOut".to_owned()));
    let run = sim.done(&["--lang", "ru", "update", "--state"]);
    assert!(run.out.contains("версия") && run.out.contains("1.0.0.0"), "{run:?}");
    // A monitor without an update says that it has none.
    let plain = Sim::start(&[]);
    for words in [&["update", &image, "--watch", "5"] as &[&str], &["update", "--state"]] {
        let run = plain.run(words);
        assert!(run.code == 1 && run.err.contains("cannot be updated"), "{words:?}: {run:?}");
    }
}

#[test]
fn images_that_are_refused() {
    let maker = Maker::new("update-refused");
    let sim = maker.monitor(&["--speed", "10"]);
    sim.done(&["lockout", "on"]);
    let good = maker.image("1.1", 400);
    let flipped = |name: &str, at: usize| {
        let mut bytes = fs::read(&good).unwrap();
        bytes[at] ^= 1;
        let path = maker.path(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let cut = maker.path("cut");
    fs::write(&cut, &fs::read(&good).unwrap()[..HEADER + 8]).unwrap();
    for (image, code, word) in [
        (maker.signed("1.1", 400, "other", "0"), 1, "another board"),
        (maker.signed("1.1", 400, "bench", "1"), 1, "does not know the key"),
        (maker.image("0.9", 400), 1, "not newer"),
        (flipped("signature", HEADER - 1), 1, "signature"),
        (flipped("payload", HEADER + 5), 2, "SHA-256"),
        (cut, 2, "Copy it again"),
        (maker.path("program"), 2, "no image"),
    ] {
        let run = sim.run(&["update", &image, "--watch", "5"]);
        assert!(run.code == code && run.err.contains(word), "{word}: {run:?}");
        let state = state(&sim);
        assert_eq!((&state["version"], &state["phase"]), (&json!("1.0.0.0"), &json!("idle")));
    }
    let two = sim.run(&["update", &good, &maker.image("1.2", 400)]);
    assert!(two.code == 2 && two.err.contains("slot A"), "{two:?}");
    let refused = sim.run(&["update", &maker.image("0.8", 400)]);
    assert_eq!(refused.code, 1, "{refused:?}");
    assert_eq!(state(&sim)["reason"], 11);
    assert!(sim.done(&["update", "--state"]).out.contains("(reason 11)"));
    sim.done(&["update", &good, "--watch", "5"]);
}

/// Killed while data are sent, the next one goes on; two at once do not disturb each other.
#[test]
fn an_update_that_is_ended_goes_on() {
    let maker = Maker::new("update-ended");
    let image = maker.image("1.1", 64 * 1024);
    let sim = maker.monitor(&[]);
    sim.done(&["lockout", "on"]);
    let start = || {
        let mut command = lafet();
        command.args(["-c", sim.url(), "--lang", "en", "--json", "update", &image, "--watch", "5"]);
        Running::stdout(&mut command)
    };
    let sent = |line: &str| {
        has_shape("update", line);
        let value: Value = serde_json::from_str(line).unwrap();
        value["done"].as_u64()
    };
    let mut first = start();
    while sent(&first.line()).is_none_or(|done| done < 3000) {}
    let second = sim.run(&["update", &image, "--watch", "5"]);
    assert!(second.code == 1 && second.err.contains("Another lafet update"), "{second:?}");
    first.signal("KILL");
    assert_eq!(first.code(), None, "it was ended by a signal");
    let there = state(&sim);
    assert_eq!((&there["phase"], &there["version"]), (&json!("receiving"), &json!("1.0.0.0")));
    let there = there["received"].as_u64().unwrap();
    assert!((3000..64 * 1024).contains(&there), "{there}");
    let mut command = lafet();
    command.args(["-c", sim.url(), "--lang", "en", "update", &image, "--watch", "5"]);
    let mut interrupted = Running::stdout(&mut command);
    while state(&sim)["received"].as_u64().unwrap() <= there {}
    interrupted.signal("INT");
    assert_eq!(interrupted.code(), Some(130));
    let said = interrupted.line();
    assert!(said.contains("sending") && said.contains("the same command goes on"), "{said}");
    let mut last = start();
    let on = sent(&last.line()).unwrap();
    assert!(on > there, "{on} {there}");
    while !last.line().contains("\"updated\"") {}
    assert_eq!(last.code(), Some(0));
    assert_eq!(state(&sim)["version"], "1.1.0.0");
}

/// Killed behind the commit, the next one confirms with the word of the first; without that word nothing does.
#[test]
fn a_trial_is_confirmed_by_the_next_one() {
    let maker = Maker::new("update-trial");
    let image = maker.image("1.1", 400);
    let sim = maker.monitor(&[]);
    sim.done(&["lockout", "on"]);
    let confirms =
        |one: &Asked| one.request == RequestId::UPDATE && one.data.first() == Some(&CONFIRM);
    let url = between(&sim, move |asked| match asked.iter().any(confirms) {
        true => Fate::Lost,
        false => Fate::Passed,
    });
    let mut command = lafet();
    command.args(["-c", &url, "--json", "--timeout", "0.3", "update", &image, "--watch", "5"]);
    let mut first = Running::stdout(&mut command);
    while !first.line().contains("\"confirming\"") {}
    first.signal("KILL");
    assert_eq!(first.code(), None, "it was ended by a signal");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = fs::metadata(note(&url)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    let trial = state(&sim);
    assert_eq!((&trial["version"], &trial["on_trial"]), (&json!("1.1.0.0"), &json!(true)));
    let run = sim.done(&["update", "--state"]);
    assert!(run.out.contains("on trial: unless"), "{run:?}");
    let run = sim.run(&["lockout", "off"]);
    assert!(run.code == 1 && run.err.contains("An update keeps the monitor locked out"), "{run:?}");
    // The monitor at the simulator's own URL has no note, then half of one.
    let run = sim.run(&["update", &image, "--watch", "5"]);
    assert!(run.code == 1 && run.err.contains("not sent from here"), "{run:?}");
    assert!(!note(sim.url()).exists(), "a word that nothing waits for is not kept");
    let noted = fs::read_to_string(note(&url)).unwrap();
    assert!(noted.lines().any(|line| line.starts_with("before ") && line.contains(':')), "{noted}");
    fs::write(note(sim.url()), "lafet update 1\nword 00").unwrap();
    let run = sim.run(&["update", &image, "--watch", "5"]);
    assert!(run.code == 1 && run.err.contains("cannot be read from"), "{run:?}");
    fs::rename(note(&url), note(sim.url())).unwrap();
    let run = sim.run(&["update", &maker.image("1.2", 400)]);
    assert!(run.code == 1 && run.err.contains("another image"), "{run:?}");
    let run = sim.done(&["update", &image, "--watch", "5"]);
    assert!(run.out.contains("1.1.0.0 was on trial and is confirmed."), "{run:?}");
    assert!(!note(sim.url()).exists());
    let kept = state(&sim);
    assert_eq!((&kept["version"], &kept["on_trial"]), (&json!("1.1.0.0"), &json!(false)));
}

/// The first answer of each order is lost, then the order itself, then every sixth piece.
#[test]
fn a_line_that_loses() {
    let maker = Maker::new("update-loses");
    let image = maker.image("1.1", 1500);
    let sim = maker.monitor(&["--speed", "5"]);
    sim.done(&["lockout", "on"]);
    let mut seen = [0_u32; 6];
    let url = between(&sim, move |asked| {
        let mut orders = asked.iter().filter(|one| one.request == RequestId::UPDATE);
        let order = orders.find_map(|one| one.data.first()).copied().unwrap_or_default();
        // Asking for the state is repeated a few times alone.
        let Some(count) = seen.get_mut(usize::from(order)).filter(|_| order > 0) else {
            return Fate::Passed;
        };
        *count += 1;
        match *count {
            1 => Fate::AnswerLost,
            2 => Fate::Lost,
            count if count % 6 == 0 => Fate::Lost,
            _ => Fate::Passed,
        }
    });
    let run = Run::of(&[
        "-c",
        &url,
        "--lang",
        "en",
        "--timeout",
        "0.3",
        "update",
        &image,
        "--watch",
        "5",
    ]);
    assert!(run.code == 0 && run.out.contains("1.0.0.0 → 1.1.0.0, confirmed."), "{run:?}");
    assert_eq!(state(&sim)["version"], "1.1.0.0");
    assert!(!note(&url).exists());
}

/// An image that hangs is not kept, and that is no success.
#[test]
fn a_trial_that_fails() {
    let maker = Maker::new("update-hangs");
    let image = maker.image("1.1", 400);
    let sim = maker.monitor(&["--speed", "20", "--bad-trial", "hangs"]);
    sim.done(&["lockout", "on"]);
    let run = sim.run(&["update", &image, "--watch", "5"]);
    assert!(run.code == 1 && run.err.contains("1.0.0.0 is running"), "{run:?}");
    assert!(!note(sim.url()).exists());
    let state = state(&sim);
    assert_eq!(state["version"], "1.0.0.0");
    assert_eq!((&state["on_trial"], &state["last_trial_failed"]), (&json!(false), &json!(true)));
    assert!(sim.flags("general").contains(&"LockedOut".to_owned()));
}

/// The new version is there after the simulator was ended; a note of nothing is replaced.
#[test]
fn the_software_is_kept_with_the_memory() {
    let maker = Maker::new("update-kept");
    let image = maker.image("1.1", 400);
    let memory = maker.path("memory");
    let kept = ["--speed", "10", "--flash", &memory];
    let mut sim = maker.monitor(&kept);
    sim.done(&["lockout", "on"]);
    let note = note(sim.url());
    fs::create_dir_all(note.parent().unwrap()).unwrap();
    fs::write(&note, "half").unwrap();
    let run = sim.done(&["update", &image, "--watch", "5"]);
    assert!(run.err.contains("it is replaced"), "{run:?}");
    assert!(!note.exists());
    sim.running.signal("TERM");
    assert_eq!(sim.running.code(), Some(0));
    let sim = maker.monitor(&kept);
    let state = state(&sim);
    assert_eq!((&state["version"], &state["slot"]), (&json!("1.1.0.0"), &json!("B")));
    assert!(sim.flags("general").contains(&"LockedOut".to_owned()));
}

/// Keys and images are never written over, and a key is for its owner alone.
#[test]
fn files_of_keys_and_images() {
    let maker = Maker::new("update-files");
    let (key, public) = (maker.path("key0"), maker.path("key0.pub"));
    let image = maker.image("1.1", 13);
    let before: Vec<Vec<u8>> = [&key, &public, &image].map(|it| fs::read(it).unwrap()).into();
    assert_eq!((before[0].len(), before[2].len()), (32, HEADER + 16));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        assert_eq!(fs::metadata(&key).unwrap().permissions().mode() & 0o777, 0o600);
    }
    let numbered = format!("0={key}");
    let sign = ["--key", &numbered, "--board", "bench", "--version", "2", "--layouts", "1-1"];
    let program = maker.path("program");
    for words in [
        vec!["image", "key", &key],
        vec!["image", "public", "0", &key, &public],
        [&["image", "sign"], &sign[..], &[program.as_str(), image.as_str()]].concat(),
    ] {
        let run = Run::of(&words);
        assert!(run.code == 2 && run.err.contains("never written over"), "{words:?}: {run:?}");
    }
    let after: Vec<Vec<u8>> = [&key, &public, &image].map(|it| fs::read(it).unwrap()).into();
    assert_eq!(before, after);
    // What is wrong is said.
    let other = maker.path("key1");
    done(&["image", "key", &other]);
    let other_public = maker.path("key1.pub");
    done(&["image", "public", "0", &other, &other_public]);
    let mut damaged = before[2].clone();
    damaged[HEADER + 3] ^= 0x80;
    let damaged_file = maker.path("damaged");
    fs::write(&damaged_file, damaged).unwrap();
    let of = |key: u8, file: &str| format!("{key}={file}");
    let (other_key, no_public, other_number) = (of(0, &other_public), of(0, &key), of(1, &public));
    for (words, code, word) in [
        (vec!["show", &image, "--public", &other_key], 1, "not that of key 0"),
        (vec!["show", &damaged_file], 1, "is not the one that was signed"),
        (vec!["show", &program], 2, "is no image"),
        (vec!["show", &image, "--public", &no_public], 2, "is no public key"),
        (vec!["show", &image, "--public", &other_number], 2, "key 0, not of 1"),
        (vec!["public", "0", &program], 2, "is no key"),
        (vec!["public", "16", &key], 2, "16"),
        (vec!["key", "/nothing/of/this/name"], 2, "/nothing/of/this/name"),
    ] {
        let run = Run::of(&[&["image"], &words[..]].concat());
        assert!(run.code == code && run.err.contains(word), "{words:?}: {run:?}");
    }
    let run = Run::of(&["--lang", "ru", "image", "show", &image]);
    assert!(run.code == 0 && run.out.contains("подпись"), "{run:?}");
}
