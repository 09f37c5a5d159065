//! The client without a thread, over TCP to a small monitor.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::fake::{answer, frame};
use lafet_client::blocking::Direct;
use lafet_client::{Config, Endpoint, Error};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;

/// Serves one connection after the other; `behave` says what is written for a payload, and ends the
/// connection with `None`.
fn monitor(mut behave: impl FnMut(&[u8]) -> Option<Vec<u8>> + Send + 'static) -> Endpoint {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            serve(stream, &mut behave);
        }
    });
    format!("tcp://{place}?addr=1").parse().unwrap()
}

fn serve(mut stream: TcpStream, behave: &mut impl FnMut(&[u8]) -> Option<Vec<u8>>) {
    let mut decoder: Decoder = Decoder::new();
    let mut byte = [0];
    while let Ok(1) = stream.read(&mut byte) {
        let Some(asked) = decoder.push(byte[0]) else { continue };
        let Some(bytes) = behave(asked.payload) else { break };
        stream.write_all(&bytes).unwrap();
    }
}

fn config(timeout: Duration) -> Config {
    Config { timeout, ..Config::default() }
}

/// Longer than anything here takes on a busy machine.
const PATIENT: Duration = Duration::from_secs(20);

fn reading() -> Request<'static> {
    Request::new(VERTICAL, Body::GetStatus)
}

fn moving() -> Request<'static> {
    Request::new(VERTICAL, Body::Move { destination: 1200 })
}

#[test]
fn requests_are_answered() {
    let endpoint = monitor(|payload| Some(frame(&answer(payload))));
    let mut client = Direct::connect_with(&endpoint, config(PATIENT)).unwrap();
    for _ in 0..20 {
        assert_eq!(client.request(&reading()).unwrap().first().from(), VERTICAL);
    }
    client.request(&moving()).unwrap();
    client.request(&Request::new(SubsystemId::ALL, Body::Stop)).unwrap();
    client.probe().unwrap();
    let stats = client.stats();
    assert_eq!((stats.believed, stats.strays()), (23, 0), "{stats:?}");
}

/// A connection that ends between two requests, or under one, is made again for a read; a command
/// that may have been executed is not sent again.
#[test]
fn a_lost_connection_is_made_again() {
    let (mut reads, mut moves) = (0, 0);
    let endpoint = monitor(move |payload| {
        let is_move = payload.chunks(4).any(|record| record[0] == RequestId::MOVE.0);
        reads += u32::from(!is_move);
        moves += u32::from(is_move);
        assert!(moves <= 1, "a command is sent once");
        (!is_move && !reads.is_multiple_of(4)).then(|| frame(&answer(payload)))
    });
    let mut client = Direct::connect_with(&endpoint, config(PATIENT)).unwrap();
    for _ in 0..10 {
        client.request(&reading()).unwrap();
    }
    assert!(client.stats().reconnects >= 2, "{:?}", client.stats());
    let error = client.request(&moving()).unwrap_err();
    assert!(matches!(error, Error::OutcomeUnknown { .. }), "{error}");
    client.request(&reading()).unwrap();
}

#[test]
fn silence_ends() {
    let endpoint = monitor(|_| Some(vec![]));
    let mut client = Direct::connect_with(&endpoint, config(Duration::from_millis(20))).unwrap();
    let error = client.request(&reading()).unwrap_err();
    assert!(matches!(error, Error::NoAnswer { tries: 3, .. } | Error::Link { .. }), "{error}");
    // Nothing answers, so a command is not even sent.
    let error = client.request(&moving()).unwrap_err();
    assert!(matches!(error, Error::NotSent { .. } | Error::OutcomeUnknown { .. }), "{error}");
    let serial = "serial:///dev/null".parse().unwrap();
    assert!(matches!(Direct::connect(&serial), Err(Error::Link { .. })));
}

/// The first connection takes frames and never answers: a Stop goes out over the next one.
#[test]
fn a_stop_survives_a_half_open_connection() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp://{}?addr=1", listener.local_addr().unwrap()).parse().unwrap();
    thread::spawn(move || {
        let (_half_open, _) = listener.accept().unwrap();
        let (stream, _) = listener.accept().unwrap();
        serve(stream, &mut |payload| Some(frame(&answer(payload))));
    });
    let mut client = Direct::connect_with(&endpoint, config(Duration::from_millis(100))).unwrap();
    client.request(&Request::new(SubsystemId::ALL, Body::Stop)).unwrap();
    assert_eq!(client.stats().reconnects, 1);
}

/// What is answered late is not believed for the next request.
#[test]
fn late_answers_are_not_believed() {
    let mut before: Option<Vec<u8>> = None;
    let endpoint = monitor(move |payload| {
        // Every answer comes behind the next request, with that one's own behind it.
        let late = before.replace(frame(&answer(payload))).unwrap_or_default();
        Some([late, frame(&answer(payload))].concat())
    });
    let mut client = Direct::connect_with(&endpoint, config(PATIENT)).unwrap();
    for _ in 0..10 {
        client.request(&reading()).unwrap();
    }
    let stats = client.stats();
    assert_eq!(stats.believed, 10);
    assert!(stats.strays() >= 9, "{stats:?}");
}

/// A peer that sends without a pause, faster than it is read: requests end in their time all the same.
#[test]
#[expect(clippy::disallowed_methods, reason = "a real connection has been idle for real time")]
fn a_peer_that_is_never_quiet() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp://{}?addr=1", listener.local_addr().unwrap()).parse().unwrap();
    for _ in 0..2 {
        let listener = listener.try_clone().unwrap();
        thread::spawn(move || {
            for mut stream in listener.incoming().map_while(Result::ok) {
                while stream.write_all(&[0xFF, 0xC0].repeat(4096)).is_ok() {}
            }
        });
    }
    let (told, outcome) = mpsc::channel();
    thread::spawn(move || {
        let mut client =
            Direct::connect_with(&endpoint, config(Duration::from_millis(20))).unwrap();
        for _ in 0..3 {
            thread::sleep(Duration::from_millis(50));
            told.send(client.request(&reading())).unwrap();
        }
    });
    for _ in 0..3 {
        let ended = outcome.recv_timeout(PATIENT).expect("it ends");
        assert!(matches!(ended, Err(Error::NoAnswer { .. })), "{ended:?}");
    }
}
