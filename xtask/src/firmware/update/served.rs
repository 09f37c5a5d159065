//! A hub that sends the update, asked as the console asks it.

use std::io::{BufRead, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::run::{self, StepResult};

/// The hub has heard of its monitor within this time.
const HEARS: Duration = Duration::from_secs(60);
/// How often the hub is asked.
pub const LOOK: Duration = Duration::from_millis(50);
/// An answer of the hub takes no longer.
const ANSWERS: Duration = Duration::from_secs(20);

/// `lafet serve`, for as long as this lives.
pub struct Hub {
    process: Child,
    /// Host and port.
    place: String,
}

impl Hub {
    /// Starts it in this folder, with the monitor at this URL.
    pub fn start(mut lafet: Command, folder: &Path, url: &str) -> Result<Self, String> {
        let failed = |e: std::io::Error| format!("the hub: {e}");
        std::fs::create_dir_all(folder).map_err(failed)?;
        let config = folder.join("hub.toml");
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"{url}\"\n"
        );
        std::fs::write(&config, text).map_err(failed)?;
        for name in ["LAFET_HUB_CONFIG", "LAFET_HUB_LISTEN", "LAFET_HUB_DATA"] {
            lafet.env_remove(name);
        }
        lafet.args(["--json", "serve", "--no-browser", "--config"]).arg(&config);
        // What it logs is looked at after a failure.
        let log = std::fs::File::create(folder.join("log")).map_err(failed)?;
        let mut process = lafet.stdout(Stdio::piped()).stderr(log).spawn().map_err(failed)?;
        let said = process.stdout.take().map(BufReader::new);
        let mut hub = Self { process, place: String::new() };
        let mut line = String::new();
        if let Some(mut said) = said {
            said.read_line(&mut line).map_err(failed)?;
        }
        let said: Value = serde_json::from_str(&line).unwrap_or_default();
        let url = said["listening"].as_str().ok_or("the hub does not start")?;
        hub.place = url.trim_start_matches("http://").trim_end_matches('/').to_owned();
        hub.hears()?;
        Ok(hub)
    }

    /// Waits until its monitor has answered.
    fn hears(&self) -> StepResult {
        let end = Instant::now() + HEARS;
        loop {
            let monitor = self.ask("GET", "/api/monitors/M1", &[])?;
            let status = &monitor["status"];
            if status["stale"] == false && status["at_ms"].is_u64() {
                return Ok(());
            }
            if Instant::now() > end {
                return Err(format!("the hub hears nothing of its monitor: {status}"));
            }
            thread::park_timeout(LOOK);
        }
    }

    /// Stores an image; its digest.
    pub fn store(&self, image: &Path) -> Result<String, String> {
        let bytes = std::fs::read(image).map_err(|e| format!("{}: {e}", image.display()))?;
        let stored = self.ask("POST", "/api/updates/images", &bytes)?;
        let digest = stored["digest"].as_str().map(str::to_owned);
        digest.ok_or_else(|| format!("the hub has not stored {}: {stored}", image.display()))
    }

    /// What it answers to a request.
    pub fn ask(&self, method: &str, path: &str, body: &[u8]) -> Result<Value, String> {
        let failed = |e: std::io::Error| format!("{method} {path}: {e}");
        let mut stream = TcpStream::connect(&self.place).map_err(failed)?;
        stream.set_read_timeout(Some(ANSWERS)).map_err(failed)?;
        let kind =
            if body.starts_with(b"{") { "application/json" } else { "application/octet-stream" };
        let (place, len) = (&self.place, body.len());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\
             Content-Type: {kind}\r\nContent-Length: {len}\r\n\r\n"
        );
        stream.write_all(&[head.as_bytes(), body].concat()).map_err(failed)?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).map_err(failed)?;
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        match head.split(' ').nth(1) {
            Some(status) if status.starts_with('2') => {
                serde_json::from_str(body).map_err(|e| format!("{method} {path}: {e}: {body}"))
            }
            _ => Err(format!("{method} {path}: {answer}")),
        }
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        run::end(&mut self.process);
    }
}
