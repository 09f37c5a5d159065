//! Client over real sockets and a pseudo-terminal.

use std::time::Duration;

use crate::fake::{Log, answer, frame, serve};
use lafet_client::{Client, Config, Endpoint, Error, Monitor};
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, UdpSocket};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;

async fn listen() -> (TcpListener, Endpoint) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    (listener, format!("tcp://127.0.0.1:{port}?addr=1").parse().unwrap())
}

/// Short enough for a test that needs silence on a real socket.
fn quick() -> Config {
    Config { timeout: Duration::from_millis(100), ..Config::default() }
}

#[tokio::test]
async fn tcp() {
    let (listener, endpoint) = listen().await;
    let server = tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        serve(stream, Log::default(), |payload| frame(&answer(payload))).await;
    });
    let monitor = Monitor::connect(&endpoint).await.unwrap();
    for _ in 0..100 {
        assert_eq!(monitor.status_all().await.unwrap().vertical.unwrap().position, 300);
    }
    let stats = monitor.client().stats();
    assert_eq!((stats.believed, stats.strays(), stats.reconnects), (100, 0, 0));
    assert!(stats.rtt_min.is_some());
    drop(monitor);
    server.await.unwrap();
}

/// §C/3 Bare records over TCP: no frames, no addresses.
#[tokio::test]
async fn tcp_with_bare_records() {
    let (listener, endpoint) = listen().await;
    let endpoint: Endpoint = format!("{endpoint}&framing=records").parse().unwrap();
    tokio::spawn(async move {
        let (mut stream, _) = listener.accept().await.unwrap();
        let mut bytes = Vec::new();
        while stream.read_buf(&mut bytes).await.unwrap() > 0 {
            let mut records = Records::new(&bytes);
            while let Some(Ok(_)) = records.next() {}
            let whole = bytes.len() - records.rest().len();
            stream.write_all(&answer(&bytes[..whole])).await.unwrap();
            bytes.drain(..whole);
        }
    });
    let monitor = Monitor::connect(&endpoint).await.unwrap();
    assert_eq!(monitor.stop(SubsystemId::ALL).await.unwrap().len(), 5);
    assert_eq!(monitor.status_all().await.unwrap().horizontal.unwrap().position, -1200);
    let requests =
        [Request::new(SubsystemId::ALL, Body::GetStatus), Request::new(VERTICAL, Body::GetStatus)];
    let results = monitor.client().batch(&requests).await;
    assert_eq!(results[0].as_ref().unwrap().len(), 6);
    assert_eq!(results[1].as_ref().unwrap().len(), 1);
    monitor.client().probe().await.unwrap();
}

/// The first connection is half open: it takes frames and never answers. A read survives it.
#[tokio::test]
async fn a_half_open_connection_is_made_anew() {
    let (listener, endpoint) = listen().await;
    tokio::spawn(async move {
        let (_half_open, _) = listener.accept().await.unwrap();
        let (stream, _) = listener.accept().await.unwrap();
        serve(stream, Log::default(), |payload| frame(&answer(payload))).await;
    });
    let client = Client::connect_with(&endpoint, quick()).await.unwrap();
    let answers = client.request(&Request::new(VERTICAL, Body::GetStatus)).await.unwrap();
    assert_eq!(answers.first().from(), VERTICAL);
    assert_eq!(client.stats().reconnects, 1);
}

/// The same with a Stop: it goes out over the next connection, and what the first one still holds is
/// not delivered any more.
#[tokio::test]
async fn a_stop_survives_a_half_open_connection() {
    let (listener, endpoint) = listen().await;
    let first = tokio::spawn(async move {
        let (mut half_open, _) = listener.accept().await.unwrap();
        let (stream, _) = listener.accept().await.unwrap();
        tokio::spawn(serve(stream, Log::default(), |payload| frame(&answer(payload))));
        let mut buffer = [0; 256];
        loop {
            match half_open.read(&mut buffer).await {
                Ok(0) => return None,
                Ok(_) => {}
                Err(error) => return Some(error.kind()),
            }
        }
    });
    let client = Client::connect_with(&endpoint, quick()).await.unwrap();
    client.request(&Request::new(SubsystemId::ALL, Body::Stop)).await.unwrap();
    assert_eq!(client.stats().reconnects, 1);
    assert_eq!(first.await.unwrap(), Some(std::io::ErrorKind::ConnectionReset));
}

/// A monitor that goes away and comes back: the client finds it again by itself.
#[tokio::test]
async fn a_lost_connection_is_made_anew() {
    let (listener, endpoint) = listen().await;
    tokio::spawn(async move {
        for _ in 0..2 {
            let (stream, _) = listener.accept().await.unwrap();
            let (mut frames, log) = (0, Log::default());
            let once = |payload: &[u8]| {
                frames += 1;
                if frames == 1 { frame(&answer(payload)) } else { vec![] }
            };
            // Dropped with a request unanswered.
            let serving = serve(stream, log.clone(), once);
            let second = async {
                while log.lock().unwrap().len() < 2 {
                    tokio::task::yield_now().await;
                }
            };
            tokio::select! { () = serving => {}, () = second => {} }
        }
    });
    let client = Client::connect(&endpoint).await.unwrap();
    let read = Request::new(VERTICAL, Body::GetStatus);
    client.request(&read).await.unwrap();
    // The connection ends under this one; it is asked again over the next.
    client.request(&read).await.unwrap();
    assert_eq!(client.stats().reconnects, 1);
    // A command is not sent twice.
    let moving = Request::new(VERTICAL, Body::Move { destination: 1 });
    let error = client.request(&moving).await.unwrap_err();
    assert!(matches!(error, Error::OutcomeUnknown { .. }), "{error}");
}

#[tokio::test]
async fn nobody_there() {
    let (listener, endpoint) = listen().await;
    drop(listener);
    let error = Client::connect(&endpoint).await.unwrap_err();
    assert!(matches!(error, Error::Link { .. }), "{error}");
    assert!(error.to_string().contains(&endpoint.to_string()), "{error}");
    let endpoint: Endpoint = "serial:///dev/no-such-port".parse().unwrap();
    let error = Client::connect(&endpoint).await.unwrap_err();
    assert!(matches!(error, Error::Link { .. }), "{error}");
}

/// One datagram = one frame; the network delivers answers twice.
#[tokio::test]
async fn udp() {
    let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let port = socket.local_addr().unwrap().port();
    tokio::spawn(async move {
        let mut buffer = [0; 2048];
        loop {
            let (len, from) = socket.recv_from(&mut buffer).await.unwrap();
            let mut body = [0; 1024];
            let asked = lafet_proto::link::decode_datagram(&buffer[..len], &mut body).unwrap();
            let reply = frame(&answer(asked.payload));
            socket.send_to(&reply[..reply.len() / 2], from).await.unwrap();
            socket.send_to(&reply, from).await.unwrap();
            socket.send_to(&reply, from).await.unwrap();
        }
    });
    let endpoint: Endpoint = format!("udp://127.0.0.1:{port}").parse().unwrap();
    let monitor = Monitor::connect(&endpoint).await.unwrap();
    for _ in 0..20 {
        assert_eq!(monitor.status(VERTICAL).await.unwrap().data().len(), 8);
        assert_eq!(monitor.limits(VERTICAL).await.unwrap().max, 5400);
    }
    let stats = monitor.client().stats();
    assert_eq!(stats.believed, 40, "{stats:?}");
    assert!(stats.duplicates > 20 && stats.framing_errors > 20, "{stats:?}");
}

/// No server listens yet on the UDP port: that is silence, and no reason to give up.
#[tokio::test]
async fn udp_without_listener() {
    let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let port = socket.local_addr().unwrap().port();
    drop(socket);
    let endpoint: Endpoint = format!("udp://127.0.0.1:{port}").parse().unwrap();
    let client = Client::connect_with(&endpoint, quick()).await.unwrap();
    let error = client.request(&Request::new(VERTICAL, Body::GetStatus)).await.unwrap_err();
    assert!(matches!(error, Error::NoAnswer { tries: 3, .. }), "{error}");
}
