//! What masters do wrong, by mistake or on purpose: it costs them their connection, and others nothing.

use std::time::Duration;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};

use super::master::{COMMAND, HEARTBEAT, Master};
use super::{HORIZONTAL, PATIENT, site};
use crate::support::{PATIENCE, Site, until};

async fn plug(site: &Site) -> Value {
    site.get("", "/api/hub/state").await.body["plugs"][0].clone()
}

async fn until_plug(site: &Site, what: &str, wanted: impl Fn(&Value) -> bool) {
    let began = Instant::now();
    loop {
        let plug = plug(site).await;
        if wanted(&plug) {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "{what}: {plug:#}");
    }
}

/// Whether the other side has closed the connection.
async fn is_closed(stream: &mut TcpStream) -> bool {
    let mut buffer = [0; 512];
    loop {
        match timeout(PATIENCE, stream.read(&mut buffer)).await {
            Ok(Ok(0) | Err(_)) => return true,
            Ok(Ok(_)) => {}
            Err(_) => return false,
        }
    }
}

/// The answer to a frame.
async fn answer(stream: &mut TcpStream, frame: &[u8]) -> Vec<u8> {
    stream.write_all(frame).await.unwrap();
    let mut buffer = [0; 512];
    let len = timeout(PATIENCE, stream.read(&mut buffer)).await.expect("an answer").unwrap();
    buffer[..len].to_vec()
}

#[tokio::test]
async fn what_is_no_request_is_refused_or_ends_the_connection_and_is_counted() {
    let (site, address) = site(1, PATIENT).await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    for (frame, expected) in [
        (&[0, 1, 0, 0, 0, 2, 1, 43][..], [0, 1, 0, 0, 0, 3, 1, 0xAB, 1]),
        (&[0, 2, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1], [0, 2, 0, 0, 0, 3, 1, 0x81, 1]),
        (&[0, 3, 0, 0, 0, 6, 1, 3, 0, 0, 0, 126], [0, 3, 0, 0, 0, 3, 1, 0x83, 3]),
        (&[0, 4, 0, 0, 0, 6, 1, 3, 0xFF, 0xFF, 0, 1], [0, 4, 0, 0, 0, 3, 1, 0x83, 2]),
        (&[0, 5, 0, 0, 0, 6, 9, 3, 0, 0, 0, 1], [0, 5, 0, 0, 0, 3, 9, 0x83, 10]),
        // A write that has fewer bytes than it says.
        (&[0, 6, 0, 0, 0, 9, 1, 16, 1, 0, 0, 1, 250, 0, 1], [0, 6, 0, 0, 0, 3, 1, 0x90, 3]),
    ] {
        assert_eq!(answer(&mut stream, frame).await, expected, "{frame:?}");
    }
    // Units 0 and 255 are the server itself.
    for unit in [0, 255] {
        let got = answer(&mut stream, &[0, 7, 0, 0, 0, 6, unit, 3, 0, 3, 0, 1]).await;
        assert_eq!(got, [0, 7, 0, 0, 0, 5, unit, 3, 2, 0, 1]);
    }
    for broken in
        [&b"GET / HTTP/1.1\r\n\r\n"[..], &[0, 1, 0, 0, 0xFF, 0xFF, 1, 3], &[0, 1, 0, 0, 0, 1, 1, 3]]
    {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(broken).await.unwrap();
        assert!(is_closed(&mut stream).await, "{broken:?}");
    }
    // A frame that is never completed.
    let mut half = TcpStream::connect(address).await.unwrap();
    half.write_all(&[0, 1, 0, 0, 0, 6, 1]).await.unwrap();
    assert!(is_closed(&mut half).await);
    until_plug(&site, "all are counted", |it| it["malformed"] == 4 && it["exceptions"] == 5).await;
}

#[tokio::test]
async fn a_silent_connection_ends_and_a_dead_one_gives_way() {
    let (site, address) = site(1, "idle_s = 1").await;
    let mut idle = TcpStream::connect(address).await.unwrap();
    let began = Instant::now();
    assert!(is_closed(&mut idle).await && began.elapsed() >= Duration::from_millis(900));
    drop(site);
    let (site, address) = super::site(1, PATIENT).await;
    // A master that has lost its connections without closing them, and comes back.
    let mut dead = Vec::new();
    for _ in 0..4 {
        dead.push(TcpStream::connect(address).await.unwrap());
    }
    until_plug(&site, "four are there", |it| it["clients"].as_array().map(Vec::len) == Some(4))
        .await;
    let mut fifth = TcpStream::connect(address).await.unwrap();
    assert!(is_closed(&mut fifth).await, "no room for one more");
    let began = Instant::now();
    let alive = loop {
        let mut stream = TcpStream::connect(address).await.unwrap();
        let request = [0, 7, 0, 0, 0, 6, 1, 3, 0, 3, 0, 1];
        let mut buffer = [0; 64];
        if stream.write_all(&request).await.is_ok()
            && matches!(stream.read(&mut buffer).await, Ok(len @ 1..) if len > 9)
        {
            break stream;
        }
        assert!(began.elapsed() < PATIENCE, "it is never let in");
    };
    assert!(began.elapsed() > Duration::from_secs(1), "who is alive keeps its place");
    assert!(is_closed(&mut dead.remove(0)).await, "the oldest has given way");
    until_plug(&site, "they are counted", |it| it["rejected"].as_u64() > Some(0)).await;
    drop(alive);
}

/// Masters that ask as quickly as they can: a Stop of another one goes through at once.
#[tokio::test]
async fn floods_delay_no_stop_of_another() {
    const STOPS: i16 = 20;
    let (site, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    let mut floods = Vec::new();
    for _ in 0..3 {
        let mut stream = TcpStream::connect(address).await.unwrap();
        floods.push(tokio::spawn(async move {
            // Readings and Stops of a monitor that is not there, many in each packet.
            let mut packet = Vec::new();
            for _ in 0..50 {
                packet.extend([0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 125]);
                packet.extend([
                    0, 1, 0, 0, 0, 33, 1, 16, 1, 8, 0, 13, 26, 0, 5, 0, 0, 0, 0, 0, 7, 0, 9,
                ]);
                packet.extend([0; 16]);
            }
            let (mut reader, mut writer) = stream.split();
            let write = async { while writer.write_all(&packet).await.is_ok() {} };
            let mut buffer = [0; 4096];
            let read = async { while matches!(reader.read(&mut buffer).await, Ok(1..)) {} };
            tokio::join!(write, read);
        }));
    }
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    let mut times = Vec::new();
    for round in 0..STOPS {
        let target: i16 = if round % 2 == 0 { 1700 } else { -1700 };
        assert_eq!(master.command(4, 1, [1, target.cast_unsigned(), 0, 0]).await, (2, 0));
        until("it moves", moving).await;
        let began = Instant::now();
        assert_eq!(master.command(7, 1, [0; 4]).await, (2, 0));
        times.push(began.elapsed());
        until("it stops", || !moving()).await;
    }
    times.sort_unstable();
    println!("Stops under flood: {times:?}");
    // Half of them, and all but the one in which the machine did something else.
    assert!(times[times.len() / 2] < Duration::from_millis(250), "{times:?}");
    assert!(times[times.len() - 2] < Duration::from_secs(1), "{times:?}");
    assert!(floods.iter().all(|it| !it.is_finished()), "the floods went on");
    floods.iter().for_each(tokio::task::JoinHandle::abort);
}

/// A frame of a write.
fn write(number: u16, first: u16, words: &[u16]) -> Vec<u8> {
    let (len, count) = (2 * words.len(), words.len() as u16);
    let mut frame = Vec::from(number.to_be_bytes());
    frame.extend([0, 0]);
    frame.extend((7 + len as u16).to_be_bytes());
    frame.extend([1, 16]);
    frame.extend(first.to_be_bytes());
    frame.extend(count.to_be_bytes());
    frame.push(len as u8);
    frame.extend(words.iter().flat_map(|it| it.to_be_bytes()));
    frame
}

/// A master that has asked far more than it may, and then sends Stop, on the same connection.
#[tokio::test]
async fn a_flood_delays_not_its_own_stop() {
    let (site, address) = site(1, PATIENT).await;
    let master = Master::connect(address).await.live().await;
    master.command(1, 1, [0; 4]).await;
    assert_eq!(master.command(4, 1, [1, 1700, 0, 0]).await, (2, 0));
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    until("it moves", moving).await;
    let mut flood = Vec::new();
    for number in 0..3000 {
        flood.extend(write(number, HEARTBEAT, &[number]));
    }
    flood.extend(write(9999, COMMAND, &[9, 0, 0, 7, 1, 0, 0, 0, 0, 0, 0, 0, 0]));
    let mut stream = TcpStream::connect(address).await.unwrap();
    let (mut reader, mut writer) = stream.split();
    let began = Instant::now();
    let answers = async {
        let (mut all, mut buffer) = (Vec::new(), [0; 4096]);
        // The last one is that of the Stop.
        while !all.windows(4).any(|it| it == [0x27, 0x0F, 0, 0]) {
            let read = timeout(PATIENCE, reader.read(&mut buffer)).await.expect("an answer");
            all.extend_from_slice(&buffer[..read.unwrap()]);
        }
        all
    };
    let (sent, all) = tokio::join!(writer.write_all(&flood), answers);
    sent.unwrap();
    until("it stops", || !moving()).await;
    let took = began.elapsed();
    println!("a Stop behind 3000 requests: {took:?}");
    assert!(took < Duration::from_millis(3500), "{took:?}");
    let busy = all.windows(2).filter(|it| *it == [0x90, 6]).count();
    assert!(busy > 500, "{busy} were too many");
}

/// A master whose connections end before they were alive is not reported each time.
#[tokio::test]
async fn connections_that_come_and_go_are_not_reported() {
    let (site, address) = site(1, "heartbeat_ms = 1000").await;
    drop(Master::connect(address).await);
    for _ in 0..20 {
        let mut stream = TcpStream::connect(address).await.unwrap();
        answer(&mut stream, &[0, 7, 0, 0, 0, 6, 1, 3, 0, 3, 0, 1]).await;
    }
    let gone = |it: &Value| it["clients"].as_array().is_some_and(Vec::is_empty);
    until_plug(&site, "they are gone", gone).await;
    let lost = async || {
        site.get("", "/api/events").await.body.to_string().matches("heartbeat of modbus").count()
    };
    assert_eq!(lost().await, 0);
    for _ in 0..3 {
        drop(Master::connect(address).await.live().await);
        until_plug(&site, "it is gone", gone).await;
    }
    assert_eq!(lost().await, 1, "and what is lost again and again seldom");
}

/// A master that never reads its answers loses its connection, and the hub no memory.
#[tokio::test]
async fn a_master_that_does_not_read_is_disconnected() {
    let (site, address) = site(1, PATIENT).await;
    let socket = tokio::net::TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(16 * 1024).unwrap();
    until("it listens", || std::net::TcpStream::connect(address).is_ok()).await;
    let mut stream = socket.connect(address).await.unwrap();
    let packet = [0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 125].repeat(100);
    let began = Instant::now();
    while timeout(Duration::from_secs(5), stream.write_all(&packet))
        .await
        .is_ok_and(|it| it.is_ok())
    {
        assert!(began.elapsed() < 3 * PATIENCE, "it is read for ever");
    }
    until_plug(&site, "it is gone", |it| it["clients"].as_array().is_some_and(Vec::is_empty)).await;
}

#[tokio::test]
async fn who_is_not_allowed_is_not_served() {
    let address = super::free();
    let text = format!(
        "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\nallow = [\"10.0.0.0/8\"]\n"
    );
    let site = super::site_at(1, lafet_hub::Clock::System, &text).await;
    let began = Instant::now();
    let mut stream = loop {
        match TcpStream::connect(address).await {
            Ok(stream) => break stream,
            Err(error) => assert!(began.elapsed() < PATIENCE, "{error}"),
        }
    };
    assert!(is_closed(&mut stream).await);
    until_plug(&site, "it is counted", |it| it["rejected"] == 1 && it["requests"] == 0).await;
}

#[tokio::test]
async fn a_port_that_is_taken_is_reported_and_taken_later() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let text = format!("[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\n");
    let site = super::site_at(1, lafet_hub::Clock::System, &text).await;
    until_plug(&site, "it is an error", |it| it["error"]["ru"].is_string()).await;
    assert!(site.get("", "/api/events").await.body.to_string().contains("does not listen"));
    drop(taken);
    until_plug(&site, "it listens", |it| it["error"].is_null()).await;
    assert_eq!(Master::connect(address).await.read(3, 1).await, [1]);
    assert_eq!(Master::connect(address).await.try_write(COMMAND, &[1, 2]).await, Err(3));
}
