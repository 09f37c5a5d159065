//! The hub as a service: what systemd hears of it, and what a log costs that is not read.

use std::fs::File;
use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::io::ioctl_fionread;
use rustix::pipe::fcntl_setpipe_size;
use serde_json::Value;

use crate::support::{Running, Sim, lafet};

const PATIENCE: Duration = Duration::from_secs(30);

struct Site {
    folder: PathBuf,
    _sim: Sim,
}

impl Site {
    fn new(name: &str) -> Self {
        let sim = Sim::start(&[]);
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"tcp://{}?addr=1\"\n",
            sim.place()
        );
        std::fs::write(folder.join("hub.toml"), text).unwrap();
        Self { folder, _sim: sim }
    }

    fn command(&self) -> Command {
        let mut command = lafet();
        command.args(["--json", "serve", "--no-browser", "--config"]);
        command.arg(self.folder.join("hub.toml"));
        command.stdin(Stdio::null());
        command
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn url(line: &str) -> String {
    let line: Value = serde_json::from_str(line).expect("its address");
    line["listening"].as_str().expect("its address").to_owned()
}

fn stop(url: &str) -> bool {
    post(&format!("{url}/api/stop"), "")
}

fn post(place: &str, body: &str) -> bool {
    let status = Command::new("curl")
        .args(["-s", "-f", "-o", "/dev/null", "--max-time", "20"])
        .args(["-H", "content-type: application/json", "-d", body, place])
        .status();
    status.is_ok_and(|it| it.success())
}

/// systemd and a terminal that closes send the same signal; a service has no terminal.
#[test]
fn a_hangup_ends_no_service() {
    let site = Site::new("hangup");
    let mut command = site.command();
    command.stderr(Stdio::null());
    let mut hub = Running::stdout(&mut command);
    let url = url(&hub.line());
    hub.signal("HUP");
    assert!(stop(&url));
    hub.signal("HUP");
    assert!(stop(&url), "it goes on");
    hub.signal("TERM");
    assert_eq!(hub.code(), Some(0));
}

#[test]
fn systemd_hears_that_it_is_ready_and_that_it_goes_on() {
    let site = Site::new("notify");
    let path = site.folder.join("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut command = site.command();
    command.env("NOTIFY_SOCKET", &path).env("WATCHDOG_USEC", "2000000").stderr(Stdio::null());
    let mut hub = Running::stdout(&mut command);
    let said = || {
        let mut buffer = [0; 256];
        let len = socket.recv(&mut buffer).expect("a sign of life");
        String::from_utf8_lossy(&buffer[..len]).trim().to_owned()
    };
    assert_eq!([said(), said(), said()], ["READY=1", "WATCHDOG=1", "WATCHDOG=1"]);
    hub.signal("TERM");
    assert_eq!(hub.code(), Some(0));
}

struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// As with a terminal after Ctrl-S: more lines than a pipe holds, and nothing reads them.
#[test]
fn a_log_that_is_not_read_delays_no_stop() {
    let site = Site::new("log");
    let out = site.folder.join("out");
    let mut command = site.command();
    command.stderr(Stdio::piped());
    command.stdout(File::create(&out).unwrap());
    let hub = Killed(command.spawn().unwrap());
    let began = Instant::now();
    let line = loop {
        let said = std::fs::read_to_string(&out).unwrap();
        if said.ends_with('\n') {
            break said;
        }
        assert!(began.elapsed() < PATIENCE, "it does not start");
        std::thread::park_timeout(Duration::from_millis(20));
    };
    let url = url(&line);
    let log = hub.0.stderr.as_ref().unwrap();
    // The least that a pipe holds, less a line that finds no room. Each command is a line of the log.
    let room = fcntl_setpipe_size(log, 4096).unwrap() - 512;
    let began = Instant::now();
    let command =
        || post(&format!("{url}/api/monitors/M1/requests"), r#"{"request":"GetStatus Valve1"}"#);
    while (ioctl_fionread(log).unwrap() as usize) < room {
        assert!(command());
        assert!(began.elapsed() < PATIENCE, "the log does not fill");
    }
    for _ in 0..10 {
        assert!(command(), "a line of the log holds up the hub");
        assert!(stop(&url), "a line of the log holds up the hub");
    }
}
