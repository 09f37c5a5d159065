//! A server that runs on the processor where its client runs, too.

use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::ask::busy_s;

/// The processor for both ends.
const PROCESSOR: &str = "1";
const START_MAX: Duration = Duration::from_secs(20);

/// Who is measured.
pub struct Contender {
    /// Its name in the tables.
    pub name: &'static str,
    /// Its server; the port follows.
    pub serve: Vec<String>,
    /// Its client; port and seconds follow.
    pub ask: Vec<String>,
    /// A request in hexadecimal digits, and how many bytes its answer has.
    pub bytes: (&'static str, usize),
    /// Where the port is put in `serve`: appended, or in place of this.
    pub port: u16,
}

/// A server that runs.
pub struct Running<'a> {
    contender: &'a Contender,
    child: Child,
}

/// Exchanges a second of processor time, of both ends together, and the 99th percentile in µs.
pub type Figures = (f64, f64);

impl Contender {
    /// Starts the server and waits until it listens.
    pub fn start(&self) -> Result<Running<'_>, String> {
        let port = self.port.to_string();
        let words = self.serve.iter().map(|word| word.replace("PORT", &port));
        let mut command = pinned(&words.collect::<Vec<_>>());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = command.spawn().map_err(|e| format!("{}: {e}", self.name))?;
        let running = Running { contender: self, child };
        let start = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            if start.elapsed() > START_MAX {
                return Err(format!("{} does not listen", self.name));
            }
            std::thread::yield_now();
        }
        Ok(running)
    }
}

impl Running<'_> {
    /// One request after the other, by its own client.
    pub fn ask(&self, seconds: &str) -> Result<Option<Figures>, String> {
        let Contender { ask, port, .. } = self.contender;
        let mut words = ask.clone();
        words.extend([port.to_string(), seconds.to_owned()]);
        self.run(&words)
    }

    /// Many at once, by bytes made beforehand; none where not all of them are answered.
    pub fn load(
        &self,
        connections: usize,
        outstanding: usize,
        seconds: &str,
    ) -> Result<Option<Figures>, String> {
        let Contender { bytes, port, .. } = self.contender;
        let mut words = vec![own()?.display().to_string(), "load".into(), port.to_string()];
        words.extend([bytes.0.to_owned(), bytes.1.to_string()]);
        words.extend([connections.to_string(), outstanding.to_string(), seconds.to_owned()]);
        self.run(&words)
    }

    fn run(&self, words: &[String]) -> Result<Option<Figures>, String> {
        let name = self.contender.name;
        let server = self.child.id().to_string();
        let before = busy_s(&server);
        let output = pinned(words).output().map_err(|e| format!("{name}: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let served = busy_s(&server) - before;
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        match numbers[..] {
            [exchanges, p99, asked] => Ok(Some((exchanges / (served + asked), p99))),
            [] if output.status.success() => Ok(None),
            _ => Err(format!("{name}: {}", String::from_utf8_lossy(&output.stderr))),
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
