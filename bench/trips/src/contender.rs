//! A server that runs on the processor where its client runs, too.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::ask::busy_s;

/// The processor for both ends.
const PROCESSOR: &str = "1";
const START_MAX: Duration = Duration::from_secs(20);
/// What a client may take longer than it is to ask, s.
const ASK_MAX_S: f64 = 30.0;
/// Ports that another process takes between our look and the server's.
const PORTS_MAX: usize = 5;

/// Who is measured.
pub struct Contender {
    /// Its name in the tables.
    pub name: &'static str,
    /// Its server, with PORT in the place of its port.
    pub serve: Vec<String>,
    /// Its client; port and seconds follow.
    pub ask: Vec<String>,
    /// A request in hexadecimal digits, and how many bytes its answer has; none: the server is
    /// another contender's, whose figures show what it does under load.
    pub bytes: Option<(&'static str, usize)>,
}

/// A server that runs.
pub struct Running<'a> {
    contender: &'a Contender,
    child: Child,
    port: u16,
}

/// Exchanges a second of processor time, of both ends together, and the 99th percentile in µs.
pub type Figures = (f64, f64);

impl Contender {
    /// Starts the server on a free port and waits until it listens there.
    pub fn start(&self) -> Result<Running<'_>, String> {
        let mut last = String::new();
        for _ in 0..PORTS_MAX {
            match self.start_on(free_port()?) {
                Ok(running) => return Ok(running),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn start_on(&self, port: u16) -> Result<Running<'_>, String> {
        let number = port.to_string();
        let words = self.serve.iter().map(|word| word.replace("PORT", &number));
        let mut command = pinned(&words.collect::<Vec<_>>());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = command.spawn().map_err(|e| format!("{}: {e}", self.name))?;
        let mut running = Running { contender: self, child, port };
        let start = Instant::now();
        while !listens(running.child.id(), port) {
            if let Ok(Some(status)) = running.child.try_wait() {
                return Err(format!("{}: the server ended ({status})", self.name));
            }
            if start.elapsed() > START_MAX {
                return Err(format!("{} does not listen", self.name));
            }
            std::thread::yield_now();
        }
        Ok(running)
    }
}

/// A port that is free at this moment.
fn free_port() -> Result<u16, String> {
    let listener = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr());
    listener.map(|address| address.port()).map_err(|e| format!("no free port: {e}"))
}

/// Whether it is this process, and no other, that listens on a port of 127.0.0.1 or of all.
fn listens(process: u32, port: u16) -> bool {
    const LISTEN: &str = "0A";
    let table = std::fs::read_to_string("/proc/net/tcp").unwrap_or_default();
    let sockets = table.lines().skip(1).filter_map(|line| {
        let mut fields = line.split_whitespace();
        let (local, state) = (fields.nth(1)?, fields.nth(1)?);
        let inode = fields.nth(5)?;
        let (_, number) = local.rsplit_once(':')?;
        let ours = u16::from_str_radix(number, 16) == Ok(port) && state == LISTEN;
        ours.then(|| format!("socket:[{inode}]"))
    });
    let sockets: Vec<String> = sockets.collect();
    let files = std::fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten().flatten();
    files
        .filter_map(|file| std::fs::read_link(file.path()).ok())
        .any(|target| sockets.iter().any(|socket| target.as_os_str() == socket.as_str()))
}

impl Running<'_> {
    /// One request after the other, by its own client.
    pub fn ask(&self, seconds: &str) -> Result<Option<Figures>, String> {
        let mut words = self.contender.ask.clone();
        words.extend([self.port.to_string(), seconds.to_owned()]);
        self.run(&words, seconds)
    }

    /// Many at once, by bytes made beforehand; none where not all of them are answered.
    pub fn load(
        &self,
        connections: usize,
        outstanding: usize,
        seconds: &str,
    ) -> Result<Option<Figures>, String> {
        let Some((request, answer)) = self.contender.bytes else { return Ok(None) };
        let mut words = vec![own()?.display().to_string(), "load".into(), self.port.to_string()];
        words.extend([request.to_owned(), answer.to_string()]);
        words.extend([connections.to_string(), outstanding.to_string(), seconds.to_owned()]);
        self.run(&words, seconds)
    }

    fn run(&self, words: &[String], seconds: &str) -> Result<Option<Figures>, String> {
        let name = self.contender.name;
        let limit = seconds.parse().unwrap_or(0.0) + ASK_MAX_S;
        let mut asking = Command::new("timeout");
        asking.args(["--kill-after=1", &limit.to_string()]);
        let asks = pinned(words);
        asking.arg(asks.get_program()).args(asks.get_args());
        let server = self.child.id().to_string();
        let before = busy_s(&server);
        let output = asking.output().map_err(|e| format!("{name}: {e}"))?;
        let served = busy_s(&server) - before;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(format!("{name}: its client failed ({}): {said}", output.status));
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        match numbers[..] {
            [exchanges, p99, asked] => Ok(Some((exchanges / (served + asked), p99))),
            [] => Ok(None),
            _ => Err(format!("{name}: its client says {text}")),
        }
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn pinned(words: &[String]) -> Command {
    let mut command = Command::new("taskset");
    command.args(["-c", PROCESSOR]).args(words);
    command
}

/// This program.
pub fn own() -> Result<PathBuf, String> {
    std::env::current_exe().map_err(|e| e.to_string())
}

/// libmodbus' two ends, compiled.
pub fn compile(source: &Path) -> Result<PathBuf, String> {
    let program = own()?.with_file_name("bench-libmodbus");
    let mut cc = Command::new("cc");
    cc.args(["-O2", "-I/usr/include/modbus", "-o"]).arg(&program).arg(source).arg("-lmodbus");
    let status = cc.status().map_err(|e| format!("cc: {e}"))?;
    if status.success() { Ok(program) } else { Err("libmodbus.c does not compile".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A listener of another process is not taken for the child's.
    #[test]
    fn only_the_own_listener_counts() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        assert!(listens(std::process::id(), port));
        let mut other = Command::new("cat").stdin(Stdio::piped()).spawn().unwrap();
        assert!(!listens(other.id(), port));
        drop(other.stdin.take());
        other.wait().unwrap();
        drop(listener);
        assert!(!listens(std::process::id(), port));
    }

    /// A server that ends, or a client that fails, is an error.
    #[test]
    fn failures_of_children_are_errors() {
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        let broken = |serve: &[&str], ask: &[&str]| Contender {
            name: "broken",
            serve: words(serve),
            ask: words(ask),
            bytes: None,
        };
        let error = broken(&["false", "PORT"], &["true"]).start().err().unwrap();
        assert!(error.contains("the server ended"), "{error}");
        let child = Command::new("cat").stdin(Stdio::piped()).spawn().unwrap();
        let contender = broken(&[], &["false"]);
        let running = Running { contender: &contender, child, port: 1 };
        assert!(running.ask("0").unwrap_err().contains("its client failed"));
    }
}
