//! Mosquitto and its clients, each a process of its own.

use std::io::{BufRead, BufReader, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde_json::Value;
use tokio::time::Instant;

use super::super::free;
use crate::support::{PATIENCE, until};

/// A broker.
pub struct Broker {
    child: Child,
    pub address: SocketAddr,
    folder: PathBuf,
}

fn folder() -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("lafet-mqtt-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

impl Broker {
    /// Without a login.
    pub async fn open() -> Self {
        Self::with(free(), |_| "allow_anonymous true\n".to_owned()).await
    }

    pub async fn at(address: SocketAddr) -> Self {
        Self::with(address, |_| "allow_anonymous true\n".to_owned()).await
    }

    /// With further lines of its configuration, made for its folder.
    pub async fn with(address: SocketAddr, more: impl FnOnce(&Path) -> String) -> Self {
        let folder = folder();
        let text = format!(
            "listener {} 127.0.0.1\npersistence false\nuser root\nlog_dest none\n{}",
            address.port(),
            more(&folder)
        );
        let file = folder.join("mosquitto.conf");
        std::fs::write(&file, text).unwrap();
        let mut command = Command::new("mosquitto");
        command.arg("-c").arg(&file).stdout(Stdio::null()).stderr(Stdio::null());
        let child = command.spawn().expect("mosquitto is needed");
        let broker = Self { child, address, folder };
        until("the broker listens", || std::net::TcpStream::connect(address).is_ok()).await;
        broker
    }

    pub fn kill(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }

    /// A file beside its configuration.
    pub fn file(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    fn port(&self) -> String {
        self.address.port().to_string()
    }

    /// mosquitto_pub; returns once it has sent it.
    pub async fn publish(&self, topic: &str, text: &str, more: &[&str]) {
        let mut command = Command::new("mosquitto_pub");
        command.args(["-V", "5", "-p", &self.port(), "-q", "1", "-t", topic, "-m", text]);
        command.args(more).stdout(Stdio::null());
        let status = tokio::task::spawn_blocking(move || command.status()).await.unwrap();
        assert!(status.expect("mosquitto_pub is needed").success());
    }

    /// What the broker keeps.
    pub async fn retained(&self, topic: &str) -> Vec<(String, String)> {
        let mut command = Command::new("mosquitto_sub");
        command.args(["-V", "5", "-p", &self.port(), "-t", topic, "-F", "%t %p"]);
        command.args(["--retained-only", "-W", "1"]).stderr(Stdio::null());
        let done = tokio::task::spawn_blocking(move || command.output()).await.unwrap();
        let text = String::from_utf8(done.expect("mosquitto_sub is needed").stdout).unwrap();
        let one = |line: &str| line.split_once(' ').map(|(t, p)| (t.to_owned(), p.to_owned()));
        text.lines().filter_map(one).collect()
    }

    /// The kept message of a topic, once it is as wanted.
    pub async fn until_retained(&self, topic: &str, wanted: impl Fn(&str) -> bool) -> String {
        let began = Instant::now();
        loop {
            let kept = self.retained(topic).await;
            if let Some((_, text)) = kept.iter().find(|(_, text)| wanted(text)) {
                return text.clone();
            }
            assert!(began.elapsed() < PATIENCE, "{topic}: {kept:?}");
        }
    }

    /// mosquitto_sub, listening.
    pub async fn listen(&self, topic: &str) -> Listener {
        let mut command = Command::new("mosquitto_sub");
        command.args(["-V", "5", "-p", &self.port(), "-t", topic, "-F", "%t %r %p", "-q", "1"]);
        let listener = Listener(Running::start(command));
        // The state of the hub is kept: once it is there, so is what comes.
        listener.until("it listens", |line| line.contains("/hub ")).await;
        listener
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.kill();
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A program whose lines are read.
pub struct Running {
    child: Child,
    lines: Arc<Mutex<Vec<String>>>,
}

impl Running {
    pub fn start(mut command: Command) -> Self {
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let lines: Arc<Mutex<Vec<String>>> = Arc::default();
        let (out, own) = (child.stdout.take().expect("a pipe"), lines.clone());
        std::thread::spawn(move || {
            for line in BufReader::new(out).lines().map_while(Result::ok) {
                own.lock().unwrap().push(line);
            }
        });
        Self { child, lines }
    }

    /// The script with paho-mqtt.
    pub fn paho(broker: &Broker, arguments: &[&str]) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/mqtt/client.py");
        let mut command = Command::new("python3");
        command.arg(script).arg(broker.port()).args(arguments);
        Self::start(command)
    }

    /// The script with pysparkplug, which has an environment of its own: it wants an older paho-mqtt.
    pub fn sparkplug(broker: &Broker, what: &str) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/mqtt/sparkplug_host.py");
        let python = std::env::var_os("LAFET_SPARKPLUG_PYTHON").unwrap_or("python3".into());
        let mut command = Command::new(python);
        command.arg(script).arg(broker.port()).arg(what);
        Self::start(command)
    }

    pub fn tell(&mut self, words: &str) {
        let input = self.child.stdin.as_mut().expect("a pipe");
        writeln!(input, "{words}").expect("it reads");
        input.flush().expect("it reads");
    }

    /// Its input ends.
    pub fn close(&mut self) {
        drop(self.child.stdin.take());
    }

    pub fn lines(&self) -> Vec<String> {
        self.lines.lock().unwrap().clone()
    }

    pub async fn until(&self, what: &str, wanted: impl Fn(&str) -> bool) -> String {
        let found = || self.lines().into_iter().find(|line| wanted(line));
        let began = Instant::now();
        let mut ticks = tokio::time::interval(Duration::from_millis(5));
        loop {
            ticks.tick().await;
            if let Some(line) = found() {
                return line;
            }
            assert!(began.elapsed() < PATIENCE, "{what}: {:#?}", self.lines());
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// What a subscriber has heard.
pub struct Listener(Running);

impl Listener {
    pub async fn until(&self, what: &str, wanted: impl Fn(&str) -> bool) -> String {
        self.0.until(what, wanted).await
    }

    /// The result of a command on a topic.
    pub async fn result(&self, topic: &str, id: &str) -> Value {
        let is_it = |line: &str| {
            let text = line.strip_prefix(topic).and_then(|it| it.strip_prefix("/result 0 "));
            let result: Option<Value> = text.and_then(|it| serde_json::from_str(it).ok());
            result.filter(|it| it["id"] == id)
        };
        let line = self.until("a result", |line| is_it(line).is_some()).await;
        is_it(&line).unwrap_or_default()
    }

    /// The messages of a topic, in their order.
    pub fn of(&self, topic: &str) -> Vec<String> {
        let one = |line: String| {
            let rest = line.strip_prefix(topic)?.strip_prefix(' ')?;
            Some(rest.split_once(' ')?.1.to_owned())
        };
        self.0.lines().into_iter().filter_map(one).collect()
    }
}
