//! `lafet serve` on a disk that is full, read-only or not there: it says so in words, leaves nothing that keeps
//! the next start from its work, and forgets nothing that was revoked.
//!
//! Disks of a few kilobytes are tmpfs in a mount namespace, where the system allows one without rights.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{Run, Running, lafet};
use serde_json::{Value, json};

/// The hub, in a script.
const SERVE: &str = "\"$0\" --json serve --no-browser --config \"$1/hub.toml\"";

const PASSWORD: &str = "correct horse battery staple";

/// The configuration of a hub whose state is in `data` beside it.
struct Place(PathBuf);

impl Place {
    fn new(name: &str, login: bool) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-room-{name}-{}", std::process::id()));
        _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = {login}\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1?addr=1\"\n"
        );
        fs::write(folder.join("hub.toml"), text).unwrap();
        Self(folder)
    }

    fn data(&self) -> PathBuf {
        self.0.join("data")
    }

    /// `sh` with this script, behind these words.
    fn script(&self, before: &[&str], script: &str) -> Command {
        let program = lafet();
        let (first, rest) = before.split_first().map_or(("sh", &[][..]), |(it, rest)| (*it, rest));
        let mut command = Command::new(first);
        command.args(rest).args(if before.is_empty() { &[][..] } else { &["sh"] });
        command.args(["-c", script]).arg(program.get_program()).arg(&self.0);
        for (name, value) in program.get_envs() {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        command
    }

    /// The hub starts as in a new folder, and ends.
    fn starts(&self) {
        let mut hub = Running::stdout(&mut self.script(&[], &format!("exec {SERVE}")));
        let said: Value = serde_json::from_str(&hub.line()).expect("its address");
        assert!(said["listening"].is_string(), "{said}");
        hub.signal("TERM");
        assert_eq!(hub.code(), Some(0));
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        _ = fs::remove_dir_all(&self.0);
    }
}

/// What makes a namespace with mounts of its own; `None`: the system does not let it.
const MOUNTS: [&str; 2] = ["unshare", "-rm"];

fn can_mount() -> bool {
    let mut command = Command::new(MOUNTS[0]);
    command.args(&MOUNTS[1..]).args(["mount", "-t", "tmpfs", "none", "/mnt"]);
    command.stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Files that may not grow are a full disk, except that the system says so by other words.
#[test]
fn a_first_start_without_room_begins_nothing() {
    let place = Place::new("limit", false);
    let run = Run::of_command(
        &mut place.script(&[], &format!("trap '' XFSZ; ulimit -f 1; exec {SERVE}")),
    );
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.err.contains("nothing can be written in") && run.err.contains("40 MB"), "{run:?}");
    place.starts();
}

/// However little the disk takes, the next start needs no option when there is room.
#[test]
fn a_full_disk_at_the_first_start() {
    if !can_mount() {
        return;
    }
    std::thread::scope(|scope| {
        for size in ["16k", "600k", "1028k", "1060k", "1100k", "1200k"] {
            scope.spawn(move || {
                let place = Place::new(size, false);
                fs::create_dir(place.data()).unwrap();
                let script = format!(
                    "mount -t tmpfs -o mode=700,size={size} none \"$1/data\"; \
                     timeout -s KILL 3 {SERVE} 2>\"$1/said\" >\"$1/listens\"; echo $? >\"$1/code\"; \
                     mount -o remount,size=64m \"$1/data\"; exec {SERVE}"
                );
                let mut hub = Running::stdout(&mut place.script(&MOUNTS, &script));
                let said: Value = serde_json::from_str(&hub.line()).expect("its address");
                let url = said["listening"].as_str().expect("its address");
                let health = asked(&[&format!("{url}/health")]);
                assert_eq!(health["state_lost"], json!([]), "{size}: {health}");
                let first = fs::read_to_string(place.0.join("said")).unwrap();
                let listened = fs::metadata(place.0.join("listens")).unwrap().len() > 0;
                let code = fs::read_to_string(place.0.join("code")).unwrap();
                let named = first.contains("data") && !first.contains("panicked");
                assert!(listened || named && code == "2\n", "{size}: {code} {first}");
                if matches!(size, "16k" | "600k") {
                    assert!(first.contains("nothing can be written in"), "{size}: {first}");
                }
                hub.signal("TERM");
                assert_eq!(hub.code(), Some(0), "{size}");
            });
        }
    });
}

/// A folder that cannot be had: the words name it, and the next start is a first one.
#[test]
fn a_state_folder_that_cannot_be_used() {
    let place = Place::new("file", false);
    fs::write(place.data(), "a file where the folder should be").unwrap();
    for (lang, word) in [("en", "storage"), ("ru", "хранилище")] {
        let run = Run::of_command(&mut place.script(&[], &format!("{SERVE} --lang {lang}")));
        assert!(run.err.contains(word) && run.err.contains("data"), "{run:?}");
        assert_eq!(run.code, 2, "{run:?}");
    }
    fs::remove_file(place.data()).unwrap();
    place.starts();
    if can_mount() {
        let place = Place::new("read-only", false);
        fs::create_dir(place.data()).unwrap();
        let script = format!("mount -t tmpfs -o ro none \"$1/data\"; exec {SERVE}");
        let run = Run::of_command(&mut place.script(&MOUNTS, &script));
        assert!(run.err.contains("data") && run.err.contains("Read-only"), "{run:?}");
        assert_eq!(run.code, 2, "{run:?}");
        place.starts();
    }
}

/// The answer to a request, or an object with its status where there is none in JSON.
fn asked(arguments: &[&str]) -> Value {
    let mut curl = Command::new("curl");
    curl.args(["-s", "--max-time", "30", "-w", "\n%{http_code}"]).args(arguments);
    let output = String::from_utf8(curl.output().unwrap().stdout).unwrap();
    let (body, status) = output.rsplit_once('\n').unwrap();
    let body: Value = serde_json::from_str(body).unwrap_or_default();
    if body.is_null() { json!({ "status": status.parse::<u16>().unwrap() }) } else { body }
}

fn posted(place: &str, session: &[&str], body: &Value) -> Value {
    let body = body.to_string();
    let what = ["-H", "Content-Type: application/json", "-d", &body, place];
    asked(&[session, &what[..]].concat())
}

/// What a user sends along: the cookie and the token against forged requests.
fn logged_in(url: &str, jar: &Path, path: &str, body: &Value) -> Vec<String> {
    let jar = jar.to_str().unwrap();
    let session = posted(&format!("{url}{path}"), &["-c", jar], body);
    let csrf = session["csrf"].as_str().unwrap_or_else(|| panic!("{session}"));
    vec!["-b".into(), jar.into(), "-H".into(), format!("X-CSRF-Token: {csrf}")]
}

/// Until the disk takes no byte more.
fn fill(folder: &Path) {
    let mut file = fs::File::create(folder.join("filler")).unwrap();
    for piece in [1 << 20, 4096, 1] {
        while file.write_all(&vec![1; piece]).is_ok() {}
    }
    let full = fs::write(folder.join("probe"), "1").unwrap_err();
    assert_eq!(full.kind(), std::io::ErrorKind::StorageFull);
}

/// A hub that is killed at the end of this, also when a test fails: its shell would not take it along.
struct First(String);

impl Drop for First {
    fn drop(&mut self) {
        let killed = Command::new("kill").args(["-KILL", &self.0]).status();
        assert!(killed.is_ok_and(|it| it.success()) || std::thread::panicking());
    }
}

/// A user is removed on a full disk, and the hub is killed: the user is gone at once, and after a start on the
/// disk that is still full.
#[test]
fn what_is_revoked_on_a_full_disk_stays_revoked() {
    if can_mount() {
        std::thread::scope(|scope| {
            scope.spawn(|| remove_on_a_full_disk("revoked", None));
            // A file of earlier versions has room for one list.
            scope.spawn(|| remove_on_a_full_disk("revoked-earlier", Some(32 * 1024)));
        });
    }
}

/// `room`: what the file of revocations has.
fn remove_on_a_full_disk(name: &str, room: Option<u64>) {
    let place = Place::new(name, true);
    fs::create_dir(place.data()).unwrap();
    let script = format!(
        "mount -t tmpfs -o mode=700,size=48m none \"$1/data\"; \
         head -c 33554432 /dev/zero >\"$1/data/reserve\"; \
         {SERVE} & echo $! >\"$1/first\"; wait; exec {SERVE}"
    );
    let mut hub = Running::stdout(&mut place.script(&MOUNTS, &script));
    let said: Value = serde_json::from_str(&hub.line()).unwrap();
    let first = First(fs::read_to_string(place.0.join("first")).unwrap().trim().to_owned());
    let url = said["listening"].as_str().unwrap();
    let (_, token) = said["setup"].as_str().unwrap().split_once('#').unwrap();
    let login = |user: &str| json!({ "user": user, "password": PASSWORD });
    let setup = json!({ "token": token, "user": "root", "password": PASSWORD });
    let root = logged_in(url, &place.0.join("root"), "/api/setup", &setup);
    let root: Vec<&str> = root.iter().map(String::as_str).collect();
    let anna = json!({ "user": "anna", "role": "operator", "password": PASSWORD });
    posted(&format!("{url}/api/users"), &root, &anna);
    let anna = logged_in(url, &place.0.join("anna"), "/api/login", &login("anna"));
    let anna: Vec<&str> = anna.iter().map(String::as_str).collect();
    let session = |url: &str| asked(&[&anna[..], &[&format!("{url}/api/session")]].concat());
    assert_eq!(session(url)["user"], "anna");
    // The mounts of the hub, from outside of them.
    let data = format!("/proc/{}/root{}", hub.child.id(), place.data().display());
    if let Some(room) = room {
        let file = fs::File::options().write(true).open(format!("{data}/revoked")).unwrap();
        file.set_len(room).unwrap();
    }
    fill(Path::new(&data));
    let user = format!("{url}/api/users/anna");
    let removed = [&["-X", "DELETE"][..], &root, &[&user]].concat();
    assert_eq!(asked(&removed), json!({ "status": 204 }));
    assert_ne!(session(url)["user"], "anna");
    let start = Instant::now();
    loop {
        let alarms = asked(&[&format!("{url}/api/alarms"), root[0], root[1]]);
        if alarms.as_array().unwrap().iter().any(|it| it["id"] == "hub/Revocations") {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "it is not reported: {alarms}");
        std::thread::park_timeout(Duration::from_millis(50));
    }
    drop(first);
    let said: Value = serde_json::from_str(&hub.line()).unwrap();
    let url = said["listening"].as_str().unwrap();
    assert_ne!(session(url)["user"], "anna");
    let refused = posted(&format!("{url}/api/login"), &[], &login("anna"));
    assert!(refused["csrf"].is_null(), "{refused}");
    let own = posted(&format!("{url}/api/login"), &[], &login("root"));
    assert_eq!(own["user"], "root", "{own}");
    hub.signal("TERM");
    assert_eq!(hub.code(), Some(0));
}
