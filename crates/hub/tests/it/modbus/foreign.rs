//! The same with pymodbus, over each kind of line: `cargo xtask plugs` installs it.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

use super::{Clock, config, is_open, pty, site_of, until, until_reported, until_zone};

/// A server in a process of its own; it ends with its input.
struct Server {
    child: Child,
    port: u16,
}

impl Server {
    fn start(arguments: &[&str]) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/modbus/server.py");
        let mut command = Command::new("python3");
        command.arg(script).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().expect("python3");
        let mut line = String::new();
        let out = child.stdout.take().expect("a pipe");
        BufReader::new(out).read_line(&mut line).expect("it says its port");
        let port = line.trim().parse().unwrap_or_else(|_| panic!("pymodbus is needed: {line}"));
        Self { child, port }
    }

    fn set(&mut self, words: &str) {
        let input = self.child.stdin.as_mut().expect("a pipe");
        writeln!(input, "{words}").expect("it reads");
        input.flush().expect("it reads");
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// A bus for each server.
fn lines(servers: &[Server; 3], path: &str) -> [(&'static str, String); 3] {
    [
        ("tcp", format!("tcp://127.0.0.1:{}", servers[0].port)),
        ("rtu", format!("rtu+tcp://127.0.0.1:{}", servers[1].port)),
        ("serial", format!("serial://{path}?baud=115200&parity=none")),
    ]
}

#[tokio::test]
#[ignore = "needs pymodbus and pyserial"]
async fn pymodbus_is_read_over_every_line() {
    let (ours, path, _open) = pty();
    let (theirs, server_path, _open_too) = pty();
    tokio::spawn(async move {
        let (mut ours, mut theirs) = (ours, theirs);
        _ = tokio::io::copy_bidirectional(&mut ours, &mut theirs).await;
    });
    let mut servers = [
        Server::start(&["tcp"]),
        Server::start(&["rtu"]),
        Server::start(&["serial", &server_path]),
    ];
    let lines = lines(&servers, &path);
    let sources = lines.clone().map(|(name, _)| {
        format!("modbus = \"{name}\", unit = 3, map = \"notifier\", register = 40")
    });
    let site = site_of(config(&lines, &sources, "3oo3", "coincidence_s = 0"), Clock::System).await;
    for detector in ["F1", "F2", "F3"] {
        until_reported(&site, detector, "quiet", "fault").await;
    }
    servers.iter_mut().for_each(|it| it.set("40=4096"));
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    servers.iter_mut().for_each(|it| it.set("40=2048"));
    until("three votes release", || is_open(&site)).await;
    servers[2].set("40=6144");
    until_reported(&site, "F3", "alarm", "fault").await;
    // A server that ends while water runs, on each line.
    drop(servers);
    for detector in ["F1", "F2", "F3"] {
        until_reported(&site, detector, "alarm", "fault").await;
    }
    for bus in super::buses(&site).await.as_array().expect("a list") {
        assert_eq!(
            (&bus["errors"]["wrong"], &bus["errors"]["garbage"]),
            (&0.into(), &0.into()),
            "{bus:#}"
        );
        assert!(bus["answers"].as_u64() > Some(5), "{bus:#}");
    }
}

#[tokio::test]
#[ignore = "needs pymodbus and pyserial"]
async fn pymodbus_is_written_over_every_line() {
    let (ours, path, _open) = pty();
    let (theirs, server_path, _open_too) = pty();
    tokio::spawn(async move {
        let (mut ours, mut theirs) = (ours, theirs);
        _ = tokio::io::copy_bidirectional(&mut ours, &mut theirs).await;
    });
    let servers = [
        Server::start(&["tcp"]),
        Server::start(&["rtu"]),
        Server::start(&["serial", &server_path]),
    ];
    let lines = lines(&servers, &path);
    let sources = lines
        .clone()
        .map(|(name, _)| format!("modbus = \"{name}\", unit = 3, alarm = \"holding:40.0\""));
    // On each line a pump on a coil with its contact, one on a register and one on a bit of it.
    let mut pumps = "coincidence_s = 0\n".to_owned();
    for (name, _) in &lines {
        for (number, set, on) in [
            (1, "coil:3", "holding:63.0"),
            (2, "holding:50=7/9", "holding:50.1"),
            (3, "holding:51.4", ""),
        ] {
            let on = match on {
                "" | "holding:50.1" => String::new(),
                on => format!(", on = \"{on}\""),
            };
            pumps += &format!(
                "[[pump]]\nid = \"{name}{number}\"\ntarget = {{ modbus = \"{name}\", unit = 4, set = \"{set}\"{on} }}\n"
            );
        }
    }
    let config = config(&lines, &sources, "3oo3", &pumps);
    let site = site_of(config, Clock::System).await;
    until_zone(&site, "it is ready", |zone| zone["ready"] == true).await;
    let all = async |on: bool| {
        let began = tokio::time::Instant::now();
        loop {
            let buses = super::buses(&site).await;
            let outputs = |bus: &serde_json::Value| bus["outputs"].as_array().cloned();
            let all: Vec<_> =
                buses.as_array().into_iter().flatten().filter_map(outputs).flatten().collect();
            let are =
                |key: &str| all.iter().filter(|it| it.get(key).is_some()).all(|it| it[key] == on);
            let well = all.iter().all(|it| it["trouble"].is_null());
            if all.len() == 9
                && well
                && ["wanted", "written", "read_back", "feedback"].map(are) == [true; 4]
            {
                return;
            }
            assert!(began.elapsed() < std::time::Duration::from_secs(20), "{on}: {buses:#}");
            tokio::time::sleep(std::time::Duration::from_millis(50)).await;
        }
    };
    let release = serde_json::json!({ "confirm": "hall" });
    assert_eq!(site.post("", "/api/zones/hall/release", release).await.status, 200);
    until("the monitor opens", || is_open(&site)).await;
    all(true).await;
    assert_eq!(site.post("", "/api/zones/hall/abort", serde_json::json!({})).await.status, 200);
    all(false).await;
    let state = site.get("", "/api/zones").await.body["state"].clone();
    assert!(!state["troubles"].to_string().contains("overdue"), "{state:#}");
    for bus in super::buses(&site).await.as_array().expect("a list") {
        for kind in ["wrong", "garbage", "exception", "timeout"] {
            assert_eq!(bus["errors"][kind], 0, "{kind}: {bus:#}");
        }
    }
}
