//! Every kind of message as fast as loopback takes it, and what becomes of Stop, Close and Lockout
//! of others, of the monitors' values and of the memory meanwhile.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{sleep, timeout};

use crate::Fallible;
use crate::client::get_json;
use crate::flood::{self, MANNERS, Manner, Target};
use crate::hub::Hub;
use crate::kinds::{self, Kind};
use crate::link;
use crate::others::Others;
use crate::site::Site;

const MONITORS: usize = 3;
/// How often the monitors are polled, ms.
const POLL_MS: u64 = 100;
/// Memory above that at rest, KiB.
const MEMORY_KIB: f64 = 64.0 * 1024.0;
/// What a flood leaves is gone after this time.
const REST: Duration = Duration::from_secs(20);
const PASSWORD: &str = "correct horse battery";

/// How much, for how long, and within which bounds.
pub struct Size {
    /// Connections of a flood, and for how long.
    connections: &'static [(usize, Duration)],
    /// Each manner by itself (read, unread, known, stranger), or all at the same time.
    apart: bool,
    p99_ms: f64,
    most_ms: f64,
}

pub const WHOLE: Size = Size {
    connections: &[(1, Duration::from_secs(4)), (200, Duration::from_secs(10))],
    apart: false,
    p99_ms: 50.0,
    most_ms: 250.0,
};
/// Of a few kinds.
pub const LONG: Size = Size {
    connections: &[(1, Duration::from_secs(60)), (200, Duration::from_secs(60))],
    apart: true,
    ..WHOLE
};
/// On a machine that does other things, too, and with few requests of others: generous in time, strict
/// in what grows.
pub const QUICK: Size = Size {
    connections: &[(48, Duration::from_millis(400))],
    apart: false,
    p99_ms: 5000.0,
    most_ms: 5000.0,
};

/// Floods a hub with the kinds whose names hold `only`, first in the clear, then over TLS.
pub async fn run(lafet: &Path, folder: &Path, size: &Size, only: &str) -> Fallible<()> {
    let of = |kinds: Vec<Kind>| -> Vec<Kind> {
        kinds.into_iter().filter(|kind| kind.name.contains(only)).collect()
    };
    let (plain, tls) = (of(kinds::all()?), of(kinds::of_tls()));
    if plain.is_empty() && tls.is_empty() {
        return Err(format!("no kind of message is called `{only}`").into());
    }
    std::fs::create_dir_all(folder)?;
    println!(
        "| flood | connections | requests of others | p50, ms | p99 | most | processor, % | memory \
         above rest, MiB |\n|---|---:|---:|---:|---:|---:|---:|---:|"
    );
    let site = Site::start(MONITORS);
    let (config, certificate) = (folder.join("hub.toml"), folder.join("cert.pem"));
    let text = site.config(POLL_MS).replace("login = false\n", "");
    std::fs::write(&config, &text)?;
    let (hub, setup) = Hub::with_users(lafet, &config)?;
    let secret = setup.as_deref().and_then(|link| link.split_once('#')).ok_or("no link")?.1;
    let [token, other] = tokens(&hub.place, secret).await?;
    while get_json(&hub.place, "/health").await?["monitors"]["M1"] != "up" {
        sleep(Duration::from_millis(50)).await;
    }
    let mut failed = floods(hub, (&token, &other), None, &plain, size).await?;
    if !tls.is_empty() {
        let own = rcgen::generate_simple_self_signed(["localhost".to_owned()])?;
        std::fs::write(&certificate, own.cert.pem())?;
        std::fs::write(folder.join("key.pem"), own.signing_key.serialize_pem())?;
        let tables = text
            .replace("[recording]", "[tls]\ncert = \"cert.pem\"\nkey = \"key.pem\"\n[recording]");
        std::fs::write(&config, tables)?;
        let (hub, _) = Hub::with_users(lafet, &config)?;
        failed.extend(floods(hub, (&token, &other), Some(certificate), &tls, size).await?);
    }
    println!("{} kinds of messages", plain.len() + tls.len());
    std::fs::remove_dir_all(folder)?;
    if failed.is_empty() {
        Ok(())
    } else {
        Err(format!("out of bounds: {}", failed.join("; ")).into())
    }
}

/// Sends each kind to a hub, which is killed then; what was out of bounds.
async fn floods(
    hub: Hub,
    (token, other): (&str, &str),
    tls: Option<PathBuf>,
    kinds: &[Kind],
    size: &Size,
) -> Fallible<Vec<String>> {
    let target = Arc::new(Target {
        place: hub.place.clone(),
        token: token.to_owned(),
        tls: link::connector(tls.as_deref())?,
    });
    let mut others = Others::start(&hub.place, other, tls.as_deref())?;
    others.work(Duration::from_secs(3)).await?;
    let (rest_kib, mut failed) = (hub.used()?.memory_kib, Vec::new());
    for kind in kinds {
        for (count, time, manners, manner) in parts(size) {
            let name = format!("{}{manner}", kind.name);
            let (tasks, before) = (flood::start(&target, kind, count, &manners), hub.used()?);
            let began = Instant::now();
            let found = others.work(time).await.map_err(|error| format!("{name}: {error}"))?;
            let used = hub.used()?;
            let processor = (used.cpu_s - before.cpu_s) / began.elapsed().as_secs_f64() * 100.0;
            let above_kib = used.memory_kib - rest_kib;
            drop(tasks);
            println!(
                "| {name} | {count} | {} | {} | {processor:.0} | {:.1} |",
                found.times.count(),
                found.times.cells(),
                above_kib / 1024.0
            );
            let late =
                found.times.percentile(99) > size.p99_ms || found.times.most() > size.most_ms;
            if late || found.stale > 0 || above_kib > MEMORY_KIB {
                failed.push(format!("{name} × {count} (stale values: {})", found.stale));
            }
        }
    }
    let began = Instant::now();
    while hub.used()?.memory_kib - rest_kib > MEMORY_KIB / 2.0 && began.elapsed() < REST {
        sleep(Duration::from_secs(1)).await;
    }
    let left = (hub.used()?.memory_kib - rest_kib) / 1024.0;
    println!("| at rest again | 0 | | | | | | {left:.1} |");
    if left > MEMORY_KIB / 2048.0 {
        failed.push("what is kept at the end".to_owned());
    }
    hub.kill()?;
    Ok(failed)
}

/// The floods of a kind.
fn parts(size: &Size) -> Vec<(usize, Duration, Vec<Manner>, String)> {
    let mut parts = Vec::new();
    for (count, time) in size.connections {
        if !size.apart {
            parts.push((*count, *time, MANNERS.to_vec(), String::new()));
            continue;
        }
        for manner in MANNERS {
            let reads = if manner.reads { "read" } else { "unread" };
            let known = if manner.known { "known" } else { "stranger" };
            parts.push((*count, *time, vec![manner], format!(", {reads}, {known}")));
        }
    }
    parts
}

/// Makes the first administrator, and tokens: of an administrator and of an operator.
async fn tokens(place: &str, secret: &str) -> Fallible<[String; 2]> {
    let setup = json!({ "token": secret, "user": "anna", "password": PASSWORD });
    let (head, session) = post(place, "/api/setup", "", &setup).await?;
    let cookies = head.lines().filter_map(|line| line.strip_prefix("set-cookie: "));
    let cookie = cookies.filter_map(|it| it.split(';').next()).collect::<Vec<_>>().join("; ");
    let csrf = session["csrf"].as_str().ok_or("no session")?;
    let known = format!("Cookie: {cookie}\r\nX-CSRF-Token: {csrf}\r\n");
    let mut tokens = [String::new(), String::new()];
    for (token, role) in tokens.iter_mut().zip(["administrator", "operator"]) {
        let wanted = json!({ "name": format!("the {role}"), "role": role });
        let made = post(place, "/api/tokens", &known, &wanted).await?.1;
        *token = made["token"].as_str().ok_or_else(|| format!("{made}"))?.to_owned();
    }
    Ok(tokens)
}

/// The head of an answer, and its body.
async fn post(place: &str, path: &str, headers: &str, body: &Value) -> Fallible<(String, Value)> {
    let (mut stream, body) = (link::connect(place, None).await?, body.to_string());
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}Content-Length: \
         {}\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).await?;
    let mut answer = String::new();
    timeout(REST, stream.read_to_string(&mut answer)).await??;
    let (head, body) = answer.split_once("\r\n\r\n").ok_or("no answer")?;
    Ok((head.to_owned(), serde_json::from_str(body)?))
}
