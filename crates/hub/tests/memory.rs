//! What clients ask for does not grow the hub: its memory, measured.
#![cfg(target_os = "linux")]

mod support;

use std::io::Cursor;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use lafet_capture::{Captured, Direction, Format, Recorder};
use lafet_hub::access::Role;
use lafet_proto::link::{Frame, encode};
use serde_json::json;
use support::{PATIENCE, Site};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::Mutex;
use tokio::time::timeout;

/// Each test looks at the memory of the process: one at a time.
static ALONE: Mutex<()> = Mutex::const_new(());
const MIB: u64 = 1 << 20;

/// What the process has, bytes.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

/// The most memory while something is done, above that before.
async fn most_above<T>(work: impl Future<Output = T>) -> (u64, T) {
    let (before, mut most) = (memory(), 0);
    tokio::pin!(work);
    let mut ticks = tokio::time::interval(Duration::from_millis(2));
    loop {
        tokio::select! {
            done = &mut work => return (most.max(memory()).saturating_sub(before), done),
            _ = ticks.tick() => most = most.max(memory()),
        }
    }
}

/// Waits until the memory no longer grows: what is read ahead has been read, however slow the machine is.
async fn settled() {
    const STILL: Duration = Duration::from_secs(3);
    let (mut most, mut since) = (memory(), Instant::now());
    while since.elapsed() < STILL {
        tokio::time::sleep(STILL / 30).await;
        if memory() > most + MIB / 4 {
            (most, since) = (memory(), Instant::now());
        }
    }
}

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // The hub that ends may still write there.
        _ = std::fs::remove_dir_all(&self.0);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn passwords_are_hashed_in_memory_for_one() {
    let _alone = ALONE.lock().await;
    let site = Site::with(1, |_| {}).await;
    let tries = async {
        let each = (0..8).map(async |client| {
            for number in 0..8 {
                let user = format!("somebody{client}{number}");
                let login = json!({ "user": user, "password": "wrong and long enough" });
                let reply = site.post("", "/api/login", login).await;
                assert_eq!(reply.status, 401, "{reply:?}");
            }
        });
        join_all(each).await;
    };
    let (above, _) = most_above(tries).await;
    // 19 MiB are one hash's.
    assert!((15 * MIB..30 * MIB).contains(&above), "{} KiB", above / 1024);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn downloads_are_read_as_they_are_taken() {
    const SIZE: u64 = 64 * MIB;
    let _alone = ALONE.lock().await;
    let folder = Folder::new("downloads");
    let own = folder.0.clone();
    let site = Site::with(1, |config| {
        config.recording.folder = Some(own);
        // Of a file without a description it is not known how old it is.
        config.recording.keep_days = u32::MAX;
    })
    .await;
    let file = std::fs::File::create(folder.0.join("long.mcap")).unwrap();
    file.set_len(SIZE).unwrap();
    let tokens: Vec<String> = site.tokens().into_iter().map(|(_, token)| token).collect();
    let begin = async |token: &String| {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        let request = format!(
            "GET /api/recordings/long.mcap HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
             Authorization: Bearer {token}\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut head = [0; 12];
        stream.read_exact(&mut head).await.unwrap();
        assert_eq!(&head, b"HTTP/1.1 200");
        stream
    };
    let (above, mut downloads) = most_above(async {
        // As many as one user has turns for, of each user; no client reads on.
        join_all((0..4).flat_map(|_| tokens.iter().map(&begin))).await
    })
    .await;
    assert!(above < 24 * MIB, "{} KiB for {} downloads", above / 1024, downloads.len());
    let mut whole = downloads.pop().unwrap();
    let (above, len) = most_above(async {
        let (mut buffer, mut len) = (vec![0; 1 << 16], 12);
        loop {
            match timeout(PATIENCE, whole.read(&mut buffer)).await.unwrap().unwrap() {
                0 => return len,
                count => len += count as u64,
            }
        }
    })
    .await;
    assert!((SIZE..SIZE + 1024).contains(&len), "{len} bytes");
    assert!(above < 8 * MIB, "{} KiB", above / 1024);
}

/// One file is sent at a time; who breaks off makes room.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_file_is_sent_at_a_time() {
    let _alone = ALONE.lock().await;
    let folder = Folder::new("uploads");
    let own = folder.0.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Operator);
    let mut slow = TcpStream::connect(site.address).await.unwrap();
    let head = format!(
        "POST /api/recordings/upload HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n\
         Content-Length: 100000\r\n\r\nhalf of it"
    );
    slow.write_all(head.as_bytes()).await.unwrap();
    // The folder was tried before with a file of its own.
    let parts = || {
        let all = std::fs::read_dir(&folder.0).unwrap().filter_map(Result::ok);
        all.filter(|it| std::fs::read(it.path()).is_ok_and(|is| is == b"half of it")).count()
    };
    support::until("the first one has started", || parts() == 1).await;
    let second = async || site.post(&token, "/api/recordings/upload", json!("no recording")).await;
    let refused = second().await;
    assert_eq!((refused.status, refused.code()), (429, "slow_down"), "{refused:?}");
    assert!(refused.body["error"]["retry_after_ms"].as_u64() > Some(0));
    drop(slow);
    support::until("what was sent of it is removed", || parts() == 0).await;
    let taken = second().await;
    assert_eq!(taken.status, 400, "it is read, and is no recording: {taken:?}");
}

/// A recording of so many pieces, each of a frame with a state and zeros behind it.
fn recording(pieces: u64, zeros: usize) -> Vec<u8> {
    let mut frame = [0; 64];
    let payload = [0xD4, 0x0D, 0, 8, 1, 0, 2, 0, 0x9C, 0xFF, 15, 9];
    let len = encode(&Frame { dst: 129, src: 1, payload: &payload }, &mut frame).unwrap();
    let bytes = [&frame[..len], &vec![0; zeros]].concat();
    let mut file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(Format::Mcap, &mut file).unwrap();
    let mut piece = Captured { at_ns: 0, direction: Direction::FromMonitor, bytes };
    for number in 0..pieces {
        piece.at_ns = 1_790_000_000_000_000_000 + number * 1_000_000;
        recorder.write(&piece).unwrap();
    }
    recorder.finish().unwrap();
    file.into_inner()
}

/// Sends a file; the status of the answer.
async fn upload(site: &Site, token: &str, name: &str, file: &[u8]) -> u16 {
    let mut stream = TcpStream::connect(site.address).await.unwrap();
    let head = format!(
        "POST /api/recordings/upload?name={name} HTTP/1.1\r\nHost: localhost\r\n\
         Authorization: Bearer {token}\r\nContent-Length: {}\r\n\r\n",
        file.len()
    );
    stream.write_all(&[head.as_bytes(), file].concat()).await.unwrap();
    let mut answer = [0; 12];
    timeout(3 * PATIENCE, stream.read_exact(&mut answer)).await.expect("an answer").unwrap();
    std::str::from_utf8(&answer[9..]).unwrap().parse().unwrap()
}

/// What a small file becomes is read a part at a time, and no further than the bound.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_small_file_that_unpacks_to_much_is_read_in_parts() {
    const ZEROS: usize = 256 << 10;
    let _alone = ALONE.lock().await;
    let folder = Folder::new("unpacked");
    let own = folder.0.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Operator);
    for (mebibytes, expected) in [(64, 201), (260, 400)] {
        let file = recording(mebibytes * MIB / ZEROS as u64, ZEROS);
        let packed = file.len() as u64;
        assert!(packed < MIB, "{packed} bytes for {mebibytes} MiB");
        let (above, status) = most_above(upload(&site, &token, "small", &file)).await;
        println!("{mebibytes} MiB in {packed} bytes: {status}, {} KiB", above / 1024);
        assert_eq!(status, expected, "{mebibytes} MiB");
        assert!(above < 24 * MIB, "{} KiB for {mebibytes} MiB", above / 1024);
    }
}

/// Recordings that are played to clients which read nothing wait, each in a few parts.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn recordings_are_played_as_they_are_taken() {
    const PIECES: u64 = 30_000;
    let _alone = ALONE.lock().await;
    let folder = Folder::new("played");
    let own = folder.0.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Operator);
    assert_eq!(upload(&site, &token, "played", &recording(PIECES, 0)).await, 201);
    let begin = async |token: &String| {
        let socket = tokio::net::TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(16 * 1024).unwrap();
        let mut stream = socket.connect(site.address).await.unwrap();
        let request = format!(
            "GET /api/recordings/played.mcap/changes?frames=true HTTP/1.1\r\nHost: localhost\r\n\
             Connection: close\r\nAuthorization: Bearer {token}\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut head = [0; 12];
        timeout(PATIENCE, stream.read_exact(&mut head)).await.expect("an answer").unwrap();
        assert_eq!(&head, b"HTTP/1.1 200");
        stream
    };
    let tokens: Vec<String> = site.tokens().into_iter().map(|(_, token)| token).collect();
    let (above, mut played) = most_above(async {
        // As many as one user has turns for, of each user; no client reads on.
        let all = join_all((0..4).flat_map(|_| tokens.iter().map(&begin))).await;
        settled().await;
        all
    })
    .await;
    println!("{} unread: {} KiB", played.len(), above / 1024);
    assert_eq!(played.len(), 16);
    assert!(above < 32 * MIB, "{} KiB for {} of them", above / 1024, played.len());
    // Others notice nothing, and who reads on gets all of it.
    let stopped = site.post(&token, "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(stopped.status, 200, "{stopped:?}");
    let mut whole = played.pop().unwrap();
    let mut text = Vec::new();
    timeout(3 * PATIENCE, whole.read_to_end(&mut text)).await.expect("its end").unwrap();
    let lines = text.split(|it| *it == b'\n').filter(|line| line.starts_with(b"{")).count() as u64;
    assert!(lines > PIECES / 2, "{lines} lines of {PIECES} pieces");
    assert!(text.len() as u64 > 4 * MIB, "{} bytes of one", text.len());
}
