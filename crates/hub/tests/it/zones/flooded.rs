//! A client says a no over many connections, as fast as it is answered and faster.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use super::*;

/// Name of the threads of the hub in this test: other tests have theirs in the same process.
const NAME: &str = "zones-flooded";
const CONNECTIONS: usize = 100;
const FLOODED: Duration = Duration::from_secs(4);
/// Threads that may come to those at rest: for the disk, and for what waits for the machine of the zones.
const THREADS: usize = 6;
/// Everything runs on two threads here, clients and monitors included, and not optimized: `cargo xtask hub-load` has
/// the bounds of the hub.
const MOST: Duration = Duration::from_secs(5);

/// The threads of the hub.
fn threads() -> usize {
    let all = fs::read_dir("/proc/self/task").unwrap().flatten();
    let named = |it: &fs::DirEntry| {
        fs::read_to_string(it.path().join("comm")).is_ok_and(|name| name.trim() == NAME)
    };
    all.filter(named).count()
}

/// Sends a no and does not wait for its answer to send the next one; counts what is answered.
async fn says(address: SocketAddr, request: Arc<String>, answered: Arc<AtomicUsize>) {
    let stream = TcpStream::connect(address).await.unwrap();
    let (mut from, mut to) = stream.into_split();
    let writes = async { while to.write_all(request.as_bytes()).await.is_ok() {} };
    let reads = async {
        let mut buffer = vec![0; 1 << 14];
        while let Ok(len @ 1..) = from.read(&mut buffer).await {
            let done = String::from_utf8_lossy(&buffer[..len]).matches("HTTP/1.1 200").count();
            answered.fetch_add(done, Ordering::Relaxed);
        }
    };
    tokio::join!(writes, reads);
}

#[test]
fn noes_over_many_connections_take_few_threads_and_hold_up_no_other() {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name(NAME)
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async { tokio::spawn(flooded()).await.unwrap() });
}

async fn flooded() {
    let zones = hall(3, "");
    let site = Site::with(3, |config| config.zones = Some(zones)).await;
    let (flooder, other) = (site.token(Role::Observer), site.token(Role::Operator));
    let at_rest = threads();
    for path in ["/api/zones/hall/abort", "/api/zones/lock"] {
        let answered = Arc::new(AtomicUsize::new(0));
        let request = Arc::new(format!(
            "POST {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {flooder}\r\n\
             Content-Length: 2\r\n\r\n{{}}"
        ));
        let says = |_| tokio::spawn(says(site.address, request.clone(), answered.clone()));
        let floods: Vec<_> = (0..CONNECTIONS).map(says).collect();
        until("it is a flood", || answered.load(Ordering::Relaxed) >= CONNECTIONS).await;
        let ask = async |path: &str| {
            let asked = Instant::now();
            let reply = site.post(&other, path, json!({})).await;
            assert!(matches!(reply.status, 200 | 202), "{reply:?}");
            asked.elapsed()
        };
        // The first of its client.
        let mut took = vec![ask(path).await];
        let (began, mut most) = (Instant::now(), 0);
        while began.elapsed() < FLOODED {
            took.push(ask("/api/monitors/M1/stop").await);
            most = most.max(threads());
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        floods.iter().for_each(tokio::task::JoinHandle::abort);
        let slowest = took.iter().max().copied().unwrap_or_default();
        println!(
            "{path}: {} answered; {} of another: {slowest:?} at most; {most} threads, {at_rest} at rest",
            answered.load(Ordering::Relaxed),
            took.len(),
        );
        assert!(most <= at_rest + THREADS, "{path}: {most} threads, {at_rest} at rest");
        assert!(slowest < MOST, "{path}: {slowest:?}");
    }
    let reply = site.get(&other, "/api/zones").await;
    assert_eq!(reply.body["state"]["lockout"], true, "{reply:?}");
}
