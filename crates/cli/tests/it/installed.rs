//! `lafet doctor --install` finds each fault that is made on purpose, and `lafet --version` what was built.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{Run, Running, lafet};
use serde_json::{Value, json};

/// A user of every Unix system, in no group that may use serial ports.
const STRANGER: &str = "nobody";

/// A configuration in a folder of its own; what systemd is said to say.
struct Place {
    folder: PathBuf,
}

impl Place {
    /// With this URL of the monitor, and a port that is free.
    fn new(name: &str, url: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("lafet-installed-{name}-{}", std::process::id()));
        _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).unwrap();
        mode(&folder, 0o755);
        let place = Self { folder };
        place.write(&format!(
            "[server]\nlisten = \"127.0.0.1:{}\"\n[[monitor]]\nid = \"M1\"\nurl = \"{url}\"\n",
            free()
        ));
        place.systemd("offline", "", "yes");
        place
    }

    fn config(&self) -> PathBuf {
        self.folder.join("hub.toml")
    }

    fn state(&self) -> PathBuf {
        self.folder.join("lafet-data")
    }

    fn write(&self, text: &str) {
        fs::write(self.config(), text).unwrap();
        mode(&self.config(), 0o644);
    }

    /// Programs that answer as those of systemd do.
    fn systemd(&self, system: &str, unit: &str, synchronized: &str) {
        let bin = self.folder.join("bin");
        fs::create_dir_all(&bin).unwrap();
        let systemctl = format!(
            "#!/bin/sh\nif [ \"$1\" = is-system-running ]; then echo {system}; exit 1; fi\nprintf '%b' '{unit}'\n"
        );
        for (name, script) in
            [("systemctl", systemctl), ("timedatectl", format!("#!/bin/sh\necho {synchronized}\n"))]
        {
            fs::write(bin.join(name), script).unwrap();
            mode(&bin.join(name), 0o755);
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let path = std::env::var("PATH").unwrap();
        let mut command = lafet();
        command.env("PATH", format!("{}:{path}", self.folder.join("bin").display()));
        command.env_remove("LAFET_HUB_DATA").env_remove("LAFET_HUB_LISTEN");
        command.args(["doctor", "--install", "--config"]).arg(self.config()).args(arguments);
        command
    }

    /// Code and findings.
    fn examine(&self, arguments: &[&str]) -> (i32, Vec<Value>) {
        let run = Run::of_command(self.command(arguments).arg("--json"));
        let [report] = &run.json()[..] else { panic!("{run:?}") };
        (run.code, report["findings"].as_array().unwrap().clone())
    }

    /// The finding of this name is there, with a remedy in both languages, and decides the exit code.
    #[track_caller]
    fn finds(&self, name: &str, arguments: &[&str]) {
        let (code, findings) = self.examine(arguments);
        let of_name = findings.iter().find(|it| it["finding"] == name);
        let finding = of_name.unwrap_or_else(|| panic!("no {name}: {findings:#?}"));
        assert!(finding["remedy"].as_str().is_some_and(|it| !it.is_empty()), "{finding}");
        let faults = findings.iter().any(|it| it["severity"] == "fault");
        assert_eq!(code, i32::from(faults), "{findings:#?}");
        let text = |lang| Run::of_command(self.command(arguments).args(["--lang", lang])).out;
        let (en, ru) = (text("en"), text("ru"));
        assert!(en.contains(finding["seen"].as_str().unwrap()), "{en}");
        assert!(ru.contains('→') && ru != en, "{ru}");
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        _ = fs::remove_dir_all(&self.folder);
    }
}

fn mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

/// A port that no program listens on.
fn free() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// The user who runs the tests.
fn me() -> String {
    let output = Command::new("id").arg("-un").output().unwrap();
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

const TCP: &str = "tcp://127.0.0.1:10485";

#[test]
fn a_good_installation_has_no_fault() {
    let place = Place::new("good", TCP);
    let unit = "LoadState=loaded\\nUnitFileState=enabled\\nActiveState=active\\n";
    place.systemd("running", unit, "yes");
    let (code, findings) = place.examine(&["--user", &me()]);
    let names: Vec<&str> = findings.iter().map(|it| it["finding"].as_str().unwrap()).collect();
    assert_eq!((code, &names[..]), (0, &["config", "state", "unit"][..]), "{findings:#?}");
    assert!(findings.iter().all(|it| it["severity"] == "good" && it["remedy"] == Value::Null));
    assert!(!place.state().exists(), "it makes nothing");
}

#[test]
fn the_configuration() {
    let place = Place::new("config", TCP);
    let mine = me();
    let mine = ["--user", &mine[..]];
    place.write("[server]\nlisen = 1\n");
    place.finds("config-wrong", &mine);
    place.write("[server]\n[[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1\"\n[history]\nurl = \"postgres://a:secret@127.0.0.1/l?sslmode=disable\"\n");
    let postgres = Run::of(&["--version"]).out.contains("postgres");
    place.finds(if postgres { "config-warning" } else { "config-wrong" }, &mine);
    mode(&place.config(), 0o666);
    place.finds("config-writable", &mine);
    mode(&place.config(), 0o600);
    place.finds("config-denied", &["--user", STRANGER]);
    place.finds("user-missing", &["--user", "lafet-of-no-machine"]);
    let recordings = place.folder.join("recordings");
    fs::create_dir(&recordings).unwrap();
    mode(&recordings, 0o755);
    place.write(&format!(
        "[[monitor]]\nid = \"M1\"\nurl = \"{TCP}\"\n[recording]\nfolder = \"{}\"\n",
        recordings.display()
    ));
    place.finds("recordings-denied", &["--user", STRANGER]);
    let key = place.folder.join("key.pem");
    let cert = place.folder.join("cert.pem");
    let made = Command::new("openssl")
        .args([
            "req",
            "-x509",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-subj",
            "/CN=localhost",
            "-keyout",
        ])
        .arg(&key)
        .arg("-out")
        .arg(&cert)
        .output()
        .expect("openssl is there");
    assert!(made.status.success(), "{made:?}");
    mode(&key, 0o600);
    place.write(&format!(
        "[tls]\ncert = \"cert.pem\"\nkey = \"key.pem\"\n[[monitor]]\nid = \"M1\"\nurl = \"{TCP}\"\n"
    ));
    place.finds("file-denied", &["--user", STRANGER]);
    fs::remove_file(place.config()).unwrap();
    place.finds("config-missing", &mine);
}

#[test]
fn the_state() {
    let place = Place::new("state", TCP);
    let mine = me();
    let mine = ["--user", &mine[..]];
    place.finds("state-denied", &["--user", STRANGER]);
    fs::create_dir(place.state()).unwrap();
    mode(&place.state(), 0o755);
    place.finds("state-open", &mine);
    mode(&place.state(), 0o700);
    place.finds("state-owner", &["--user", STRANGER]);
    fs::write(place.state().join("site.json"), r#"{"version": 9, "program": "9.9.9"}"#).unwrap();
    place.finds("state-newer", &mine);
}

#[test]
fn a_later_state_is_refused_in_words() {
    let place = Place::new("later", TCP);
    fs::create_dir(place.state()).unwrap();
    let site = place.state().join("site.json");
    fs::write(&site, r#"{"version": 9, "program": "9.9.9"}"#).unwrap();
    for (lang, word) in [("en", "Install lafet 9.9.9"), ("ru", "Установите снова lafet 9.9.9")]
    {
        // An upgrade asks the check before it ends the hub that runs.
        for what in ["--no-browser", "--check"] {
            let run = Run::of_command(
                lafet().args(["--lang", lang, "serve", what, "--config"]).arg(place.config()),
            );
            let own = env!("CARGO_PKG_VERSION");
            assert!(run.code == 2 && run.err.contains(word) && run.err.contains(own), "{run:?}");
        }
    }
    let names: Vec<_> = fs::read_dir(place.state()).unwrap().map(|it| it.unwrap().path()).collect();
    assert_eq!(names, [site], "nothing was written");
}

#[test]
fn the_ports() {
    let place = Place::new("ports", "serial:///dev/lafet-of-no-machine?baud=19200");
    let mine = me();
    let mine = ["--user", &mine[..]];
    place.finds("port-missing", &mine);
    if fs::read_to_string("/etc/group").is_ok_and(|it| it.contains("\ndialout:")) {
        place.finds("group", &["--user", STRANGER]);
    }
    // A terminal that a program has open, as another would a serial port.
    let mut holder = Running::stdout(Command::new("python3").args([
        "-c",
        // Who has its other end is the line, not a user of it.
        "import os, pty, sys\na, b = pty.openpty()\nos.fchmod(b, 0o600)\nname = os.ttyname(b)\nchild = os.fork()\nos.close(b if child else a)\nif not child: print(name, flush=True)\nsys.stdin.read()\nif child: os.wait()",
    ]).stdin(std::process::Stdio::piped()));
    let port = holder.line();
    let place = Place::new("ports-pty", &format!("serial://{port}?baud=19200"));
    place.finds("port-busy", &mine);
    place.finds("port-denied", &["--user", STRANGER]);
    drop(holder.child.stdin.take());
    assert_eq!(holder.code(), Some(0));
}

#[test]
fn the_address() {
    let place = Place::new("address", TCP);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = |address: &str| {
        place.write(&format!("[server]\nlisten = \"{address}\"\nplain_http = true\n[[monitor]]\nid = \"M1\"\nurl = \"{TCP}\"\n"));
    };
    listen(&taken.local_addr().unwrap().to_string());
    let mine = me();
    place.finds("listen-taken", &["--user", &mine]);
    // An address for documentation, which no machine has.
    listen("192.0.2.1:8480");
    place.finds("listen-wrong", &["--user", &mine]);
}

#[test]
fn a_hub_that_runs_has_its_address_and_state() {
    let place = Place::new("running", TCP);
    let mut serve = lafet();
    serve.args(["--json", "serve", "--no-browser", "--config"]).arg(place.config());
    let hub = Running::stdout(&mut serve);
    let said: Value = serde_json::from_str(&hub.line()).unwrap();
    assert!(said["setup"].is_string(), "{said}");
    let (code, findings) = place.examine(&["--user", &me()]);
    assert_eq!(code, 0, "{findings:#?}");
    assert!(findings.iter().any(|it| it["finding"] == "running"), "{findings:#?}");
    hub.signal("TERM");
}

#[test]
fn the_unit_and_the_clock() {
    let place = Place::new("unit", TCP);
    let mine = me();
    let mine = ["--user", &mine[..]];
    for (finding, unit) in [
        ("unit-missing", "LoadState=not-found\\n"),
        ("unit-masked", "LoadState=masked\\nUnitFileState=masked\\nActiveState=inactive\\n"),
        ("unit-disabled", "LoadState=loaded\\nUnitFileState=disabled\\nActiveState=active\\n"),
        ("unit-failed", "LoadState=loaded\\nUnitFileState=enabled\\nActiveState=failed\\n"),
        ("unit-stopped", "LoadState=loaded\\nUnitFileState=enabled\\nActiveState=inactive\\n"),
    ] {
        place.systemd("degraded", unit, "yes");
        place.finds(finding, &mine);
        let (_, findings) = place.examine(&mine);
        assert!(findings.iter().all(|it| it["finding"] != "clock"), "{findings:#?}");
    }
    // The program of this process was replaced, as by an upgrade that did not restart the hub.
    let old = place.folder.join("old");
    fs::copy("/bin/sleep", &old).unwrap();
    let mut running = Command::new(&old).arg("60").spawn().unwrap();
    let active = format!(
        "LoadState=loaded\\nUnitFileState=enabled\\nActiveState=active\\nMainPID={}\\n",
        running.id()
    );
    place.systemd("running", &active, "yes");
    let (_, findings) = place.examine(&mine);
    assert!(findings.iter().any(|it| it["finding"] == "unit"), "{findings:#?}");
    fs::remove_file(&old).unwrap();
    place.finds("program-old", &mine);
    running.kill().unwrap();
    running.wait().unwrap();
    place.systemd("running", "LoadState=loaded\\n", "no");
    place.finds("clock", &mine);
    // Without systemd something else starts the hub.
    place.systemd("offline", "LoadState=not-found\\n", "no");
    let (_, findings) = place.examine(&mine);
    assert!(!findings.iter().any(|it| it["finding"].as_str().unwrap().starts_with("unit")));
}

#[test]
fn the_arguments_of_a_link_do_not_go_with_it() {
    for words in [&["doctor", "--install", TCP][..], &["doctor", "--user", "root"]] {
        let run = Run::of(words);
        assert_eq!(run.code, 2, "{words:?}: {run:?}");
    }
}

#[test]
fn the_version_says_what_was_built() {
    let short = Run::of(&["-V"]);
    assert_eq!(short.out.trim(), format!("lafet {}", env!("CARGO_PKG_VERSION")));
    let [json] = &Run::of(&["--version", "--json"]).json()[..] else { panic!("one line") };
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["profile"], if cfg!(debug_assertions) { "debug" } else { "release" });
    assert!(json["target"].as_str().unwrap().starts_with(std::env::consts::ARCH), "{json}");
    for (lang, word) in [("en", "built for: "), ("ru", "платформа: ")] {
        let long = Run::of(&["--lang", lang, "--version"]).out;
        assert!(long.contains(word) && long.contains(json["target"].as_str().unwrap()), "{long}");
    }
    let head = Command::new("git").args(["rev-parse", "HEAD"]).output().unwrap();
    let head = String::from_utf8(head.stdout).unwrap();
    // A copy without git has no commit.
    let commit = if head.is_empty() { json!(null) } else { json!(head.trim()) };
    assert_eq!(json["commit"], commit);
}
