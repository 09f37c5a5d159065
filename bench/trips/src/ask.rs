//! Who asks: each with a library of its own, or with bytes that are made beforehand.

use std::time::{Duration, Instant};

use lafet_client::blocking::Direct;
use lafet_client::{Client, Endpoint};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;
use tokio_modbus::prelude::Reader;

use crate::serve::{ANSWER, REQUEST};

type Outcome = Result<(), String>;

/// One request after the other, by a client of this kind; prints how many, the time that 99 of 100 do
/// not exceed, µs, and the processor time of all, s.
pub async fn ask(who: &str, port: &str, seconds: &str) -> Outcome {
    let mut clock = Clock::new(seconds)?;
    match who {
        "lafet" => {
            let endpoint = endpoint(port, SETTLED)?;
            let client = Client::connect(&endpoint).await.map_err(|e| e.to_string())?;
            let request = Request::new(SubsystemId::VERTICAL, Body::GetStatus);
            while clock.goes_on() {
                client.request(&request).await.map_err(|e| e.to_string())?;
                clock.exchanged(1);
            }
        }
        "lafet-blocking" => return ask_blocking(endpoint(port, SETTLED)?, clock).await,
        "lafet-blocking-new" => return ask_blocking(endpoint(port, NEW)?, clock).await,
        "tokio-modbus" => {
            let address = format!("127.0.0.1:{port}").parse().map_err(|e| format!("{e}"))?;
            let connecting = tokio_modbus::client::tcp::connect(address).await;
            let mut client = connecting.map_err(|e| e.to_string())?;
            while clock.goes_on() {
                let read = client.read_holding_registers(0, 4).await.map_err(|e| e.to_string())?;
                read.map_err(|e| e.to_string())?;
                clock.exchanged(1);
            }
        }
        "echo" | "bytes" => {
            let request = if who == "echo" { vec![0x55; REQUEST] } else { unhex(STATE) };
            let answer = ANSWER;
            let load = Load { request, answer, connections: 1, outstanding: 1 };
            return load.run(port, seconds).await;
        }
        _ => return Err(format!("no contender is called {who}")),
    }
    println!("{}", clock.figures());
    Ok(())
}

/// GetStatus Vertical from console 129 to monitor 1.
pub const STATE: &str = "FFC00181D40D000095E7C0";

/// A connection as it is ten seconds after it was made: no answer to another program can come any more,
/// so no frame has a number.
const SETTLED: &str = "?late=0";
/// A connection as it is before.
const NEW: &str = "?late=60";

fn endpoint(port: &str, options: &str) -> Result<Endpoint, String> {
    format!("tcp://127.0.0.1:{port}{options}").parse().map_err(|e| format!("{e}"))
}

/// The client that waits in its caller's thread, which is one of its own here.
async fn ask_blocking(endpoint: Endpoint, mut clock: Clock) -> Outcome {
    let asking = move || {
        let mut client = Direct::connect(&endpoint).map_err(|e| e.to_string())?;
        let request = Request::new(SubsystemId::VERTICAL, Body::GetStatus);
        while clock.goes_on() {
            client.request(&request).map_err(|e| e.to_string())?;
            clock.exchanged(1);
        }
        println!("{}", clock.figures());
        Ok(())
    };
    tokio::task::spawn_blocking(asking).await.map_err(|e| e.to_string())?
}

/// What a server may take longer than it is asked.
const PATIENCE_S: f64 = 5.0;

/// The same bytes again and again.
pub struct Load {
    /// One request.
    pub request: Vec<u8>,
    /// Bytes of its answer.
    pub answer: usize,
    /// Connections at once.
    pub connections: usize,
    /// Requests that are sent before answers are waited for.
    pub outstanding: usize,
}

impl Load {
    /// Prints what [`ask`] does, of all connections; nothing if the server leaves a request without
    /// an answer.
    pub async fn run(self, port: &str, seconds: &str) -> Outcome {
        let all = Clock::new(seconds)?;
        let limit = all.seconds + Duration::from_secs_f64(PATIENCE_S);
        tokio::time::timeout(limit, self.exchange(all, port, seconds)).await.unwrap_or(Ok(()))
    }

    async fn exchange(self, mut all: Clock, port: &str, seconds: &str) -> Outcome {
        let mut tasks = JoinSet::new();
        for _ in 0..self.connections {
            let connecting = TcpStream::connect(format!("127.0.0.1:{port}")).await;
            let mut stream = connecting.map_err(|e| e.to_string())?;
            stream.set_nodelay(true).map_err(|e| e.to_string())?;
            let requests = self.request.repeat(self.outstanding);
            let mut answers = vec![0; self.answer * self.outstanding];
            let (mut clock, many) = (Clock::new(seconds)?, self.outstanding);
            tasks.spawn(async move {
                while clock.goes_on() {
                    stream.write_all(&requests).await.map_err(|e| e.to_string())?;
                    stream.read_exact(&mut answers).await.map_err(|e| e.to_string())?;
                    clock.exchanged(many);
                }
                Ok::<_, String>(clock)
            });
        }
        while let Some(clock) = tasks.join_next().await {
            all.add(clock.map_err(|e| e.to_string())??);
        }
        println!("{}", all.figures());
        Ok(())
    }
}

/// Counts exchanges, and how long each took.
struct Clock {
    start: Instant,
    last: Instant,
    seconds: Duration,
    exchanges: usize,
    took_us: Vec<f32>,
    /// Processor time of this process at the start, s.
    busy: f64,
}

impl Clock {
    fn new(seconds: &str) -> Result<Self, String> {
        let seconds = seconds.parse().map_err(|_| format!("{seconds}: no number"))?;
        let (start, seconds) = (Instant::now(), Duration::from_secs_f64(seconds));
        let busy = busy_s("self");
        Ok(Self { start, last: start, seconds, exchanges: 0, took_us: Vec::new(), busy })
    }

    fn goes_on(&self) -> bool {
        self.last - self.start < self.seconds
    }

    fn exchanged(&mut self, many: usize) {
        let now = Instant::now();
        self.took_us.push((now - self.last).as_secs_f32() * 1e6);
        self.last = now;
        self.exchanges += many;
    }

    fn add(&mut self, other: Self) {
        self.exchanges += other.exchanges;
        self.took_us.extend(other.took_us);
        self.last = self.last.max(other.last);
    }

    fn figures(&mut self) -> String {
        let busy = busy_s("self") - self.busy;
        self.took_us.sort_by(f32::total_cmp);
        let p99 = self.took_us.get(self.took_us.len() * 99 / 100).copied().unwrap_or(f32::NAN);
        format!("{} {p99:.2} {busy:.6}", self.exchanges)
    }
}

/// Processor time that a process has had, s.
pub fn busy_s(process: &str) -> f64 {
    let tasks = std::fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    let of = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        let ns = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
        ns.unwrap_or(0.0) / 1e9
    };
    tasks.map(of).sum()
}

/// The bytes of hexadecimal digits.
pub fn unhex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.chars().filter_map(|c| Some(c.to_digit(16)? as u8)).collect();
    digits.chunks_exact(2).map(|pair| pair[0] << 4 | pair[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal() {
        assert_eq!(unhex("FFc0 0d"), [0xFF, 0xC0, 0x0D]);
    }

    #[test]
    fn the_slowest_hundredth_is_told() {
        let mut clock = Clock::new("1").unwrap();
        clock.took_us = (0..1000).map(|i| i as f32).collect();
        assert!(clock.figures().contains(" 990.00 "));
    }
}
