//! Those who go on with their work during a flood: a process of their own, which waits for nothing
//! but the hub and the system.

use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsConnector;
use tokio_tungstenite::tungstenite::Message;

use crate::Fallible;
use crate::figures::Figures;
use crate::hub::first;
use crate::link::{self, Socket};

/// How often they stop, close and lock out.
const EVERY: Duration = Duration::from_millis(20);
/// How often they stop over a new connection: 100 times in a flood, so that one of them may be later than 99 of 100.
const FRESH: Duration = Duration::from_millis(18);
/// Where they are: what the hub counts by address is not that of the floods.
const ADDRESS: &str = "127.0.0.2";
/// Requests of which the figures are some of the hub, not of one pause of the machine.
const ENOUGH: usize = 7;
/// How much longer they work until they have as many.
const MORE: u32 = 10;
/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(60);

/// The process, as its parent has it.
pub struct Others {
    child: Child,
    input: ChildStdin,
    /// `None` while a line of it is waited for.
    output: Option<Lines<BufReader<ChildStdout>>>,
}

/// What they found.
pub struct Found {
    /// Of the WebSocket that is open.
    pub times: Figures,
    /// Of Stops over connections that are made for them.
    pub fresh: Figures,
    /// How often a value was stale.
    pub stale: u64,
}

impl Others {
    /// Starts it; `tls`: the certificate of the hub.
    pub fn start(place: &str, token: &str, tls: Option<&Path>) -> Fallible<Self> {
        let mut command = first(std::env::current_exe()?);
        command.args(["others", place, token]).args(tls);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let input = child.stdin.take().ok_or("no input")?;
        let output = BufReader::new(child.stdout.take().ok_or("no output")?).lines();
        Ok(Self { child, input, output: Some(output) })
    }

    /// Has them work for a time; for up to [`MORE`] of it where answers are so slow that they are few.
    pub async fn work(&mut self, time: Duration) -> Fallible<Found> {
        writeln!(self.input, "{}", time.as_millis())?;
        let mut output = self.output.take().ok_or("they still work")?;
        let reading = tokio::task::spawn_blocking(move || (output.next(), output));
        let (line, output) = timeout(time + 2 * PATIENCE, reading).await??;
        self.output = Some(output);
        let found: Value = serde_json::from_str(&line.ok_or("the others have gone")??)?;
        let times = |name: &str| {
            let all = found[name].as_array().into_iter().flatten();
            Figures::new(all.filter_map(Value::as_f64).collect())
        };
        let stale = found["stale"].as_u64().ok_or_else(|| format!("{}", found["error"]))?;
        Ok(Found { times: times("times"), fresh: times("fresh"), stale })
    }
}

impl Drop for Others {
    fn drop(&mut self) {
        // It may have ended already.
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// The process itself: works for as many milliseconds as each line of its input says.
pub async fn run(place: &str, token: &str, tls: Option<&Path>) -> Fallible<()> {
    let tls = link::connector(tls)?;
    let stream = link::connect_from(ADDRESS, place, tls.as_ref()).await?;
    let mut socket = link::socket(stream, place, token).await?;
    let mut next = 0;
    for line in std::io::stdin().lines() {
        let time = Duration::from_millis(line?.parse()?);
        let open = over_one(&mut socket, &mut next, time);
        let fresh = over_fresh(place, token, tls.as_ref(), time);
        match tokio::try_join!(open, fresh) {
            Ok(((times, stale), fresh)) => {
                println!("{}", json!({ "times": times, "stale": stale, "fresh": fresh }));
            }
            Err(error) => println!("{}", json!({ "error": error.to_string() })),
        }
    }
    Ok(())
}

fn goes_on(began: Instant, time: Duration, count: usize) -> bool {
    began.elapsed() < time || (count < ENOUGH && began.elapsed() < time * MORE)
}

/// Requests over the WebSocket: their times, ms, and how many values were stale.
async fn over_one(
    socket: &mut Socket,
    next: &mut u64,
    time: Duration,
) -> Fallible<(Vec<f64>, u64)> {
    let (began, mut times, mut stale) = (Instant::now(), Vec::new(), 0);
    while goes_on(began, time, times.len()) {
        *next += 1;
        let asked = Instant::now();
        stale += ask(socket, *next).await?;
        times.push(asked.elapsed().as_secs_f64() * 1000.0);
        sleep(EVERY).await;
    }
    Ok((times, stale))
}

/// Stops, each over a connection of its own, that is made in the time measured, ms.
async fn over_fresh(
    place: &str,
    token: &str,
    tls: Option<&TlsConnector>,
    time: Duration,
) -> Fallible<Vec<f64>> {
    let (began, mut times) = (Instant::now(), Vec::new());
    let headers = link::authorization(token);
    while goes_on(began, time, times.len()) {
        let path = format!("/api/monitors/M{}/stop", times.len() % 3 + 1);
        let asked = Instant::now();
        let stream = link::connect_from(ADDRESS, place, tls).await?;
        let (status, _, body) = link::ask(stream, ("POST", &path), &headers, b"").await?;
        times.push(asked.elapsed().as_secs_f64() * 1000.0);
        // 422: a monitor that is locked out denies it, and has been asked.
        if !matches!(status, 200 | 422) {
            return Err(format!("{path}: {status} {}", String::from_utf8_lossy(&body)).into());
        }
        sleep(FRESH).await;
    }
    Ok(times)
}

/// Stops, closes or locks out one of three monitors; how many messages until the answer had a value
/// that was stale. Only the third one is locked out: the others obey the floods.
async fn ask(socket: &mut Socket, id: u64) -> Fallible<u64> {
    let (kind, monitor) = match id % 3 {
        0 => ("stop", id / 3 % 3 + 1),
        1 => ("close", id / 3 % 3 + 1),
        _ => ("lockout", 3),
    };
    let message = json!({ "type": kind, "monitor": format!("M{monitor}"), "id": id });
    socket.send(Message::text(message.to_string())).await?;
    let mut stale = 0;
    loop {
        let message = timeout(PATIENCE, socket.next()).await?;
        let Message::Text(text) = message.ok_or("closed")?? else { continue };
        stale += u64::from(text.contains("\"stale\":true"));
        if text.contains("\"type\":\"answer\"") {
            let answer: Value = serde_json::from_str(&text)?;
            if answer["id"] == id {
                // A monitor that is locked out denies Stop; it has been asked all the same.
                let heard = answer["result"]["ok"] == true || answer["error"]["answers"].is_array();
                return if heard { Ok(stale) } else { Err(format!("{kind}: {answer}").into()) };
            }
        }
    }
}
