//! Real processes, one after another, on a serial server: the answer to one arrives while the next
//! one waits.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{Run, Sim};
use serde_json::json;

/// Delay of every answer: it is waited for once, not by every operation.
const LATE: Duration = Duration::from_millis(2500);
/// Number of processes.
const PROCESSES: i32 = 5;

/// Passes bytes on to one connection to the monitor, and its answers, delayed, to the client then
/// connected.
fn serial_server(monitor: &str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap();
    let mut to_monitor = TcpStream::connect(monitor).unwrap();
    let mut from_monitor = to_monitor.try_clone().unwrap();
    let client: Arc<Mutex<Option<TcpStream>>> = Arc::default();
    let connected = client.clone();
    thread::spawn(move || {
        for mut stream in listener.incoming().map_while(Result::ok) {
            *connected.lock().unwrap() = Some(stream.try_clone().unwrap());
            let mut bytes = [0; 512];
            while let Ok(count @ 1..) = stream.read(&mut bytes) {
                to_monitor.write_all(&bytes[..count]).unwrap();
            }
        }
    });
    let (answers, late) = channel();
    thread::spawn(move || {
        let mut bytes = [0; 512];
        while let Ok(count @ 1..) = from_monitor.read(&mut bytes) {
            if answers.send((Instant::now() + LATE, bytes[..count].to_vec())).is_err() {
                return;
            }
        }
    });
    thread::spawn(move || deliver(&late, &client));
    format!("tcp://{place}?addr=1")
}

fn deliver(late: &Receiver<(Instant, Vec<u8>)>, client: &Mutex<Option<TcpStream>>) {
    // Nothing is ever sent here: receiving only waits.
    let (_open, never) = channel::<()>();
    for (due, bytes) in late {
        let wait = due.saturating_duration_since(Instant::now());
        assert_eq!(never.recv_timeout(wait), Err(RecvTimeoutError::Timeout));
        if let Some(stream) = &mut *client.lock().unwrap() {
            // The process may have ended.
            let _ = stream.write_all(&bytes);
        }
    }
}

#[test]
fn no_process_believes_what_was_answered_to_another() {
    let sim = Sim::start(&[]);
    let url = serial_server(sim.place().split('?').next().unwrap());
    let mut read = 0;
    for value in 1000..1000 + PROCESSES {
        sim.done(&["param", "set", "general", "MoveTimeout", &value.to_string()]);
        let run = Run::of(&[
            "-c",
            &url,
            "--timeout",
            "2",
            "--json",
            "param",
            "get",
            "general",
            "MoveTimeout",
        ]);
        match run.code {
            0 => {
                assert_eq!(run.json()[0]["values"], json!([value]), "{run:?}");
                read += 1;
            }
            // A correct failure, if the machine is so slow that 6 s were not enough.
            code => assert_eq!(code, 3, "{run:?}"),
        }
    }
    assert!(read > 0, "nothing was read at all");
}
