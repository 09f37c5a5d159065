//! A monitor on a PC: the program of a monitor in a simulated world, over TCP, in real time.
//!
//! ```sh
//! cargo run -p lafet-sim --example monitor -- 127.0.0.1:10485
//! ```
//!
//! Any number of clients may connect. Try it with `lafet -c tcp://127.0.0.1:10485 status`, or with
//! the console of `lafet-client`.

use std::collections::HashMap;
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use lafet_device::Source;
use lafet_device::port::Port;
use lafet_sim::sim::{Config, Sim};

/// How long the world waits for bytes before it goes on.
const PACE: Duration = Duration::from_millis(10);

/// What has come over a connection; its number, and no bytes when it has ended.
struct Heard {
    connection: usize,
    stream: TcpStream,
    bytes: Vec<u8>,
}

fn main() -> io::Result<()> {
    let place = std::env::args().nth(1).unwrap_or("127.0.0.1:10485".into());
    let listener = TcpListener::bind(place)?;
    println!("tcp://{}", listener.local_addr()?);
    let fire = "az=30,range=25".parse().map_err(io::Error::other)?;
    let sim = Sim::new(Config { fires: vec![fire], ..Config::default() });
    live(sim, &listen(listener));
    Ok(())
}

/// Takes connections, each on a thread of its own, and hands on what comes.
fn listen(listener: TcpListener) -> Receiver<Heard> {
    let (heard, all) = channel();
    thread::spawn(move || {
        for (connection, stream) in listener.incoming().flatten().enumerate() {
            let heard = heard.clone();
            thread::spawn(move || read(connection, &stream, &heard));
        }
    });
    all
}

fn read(connection: usize, mut stream: &TcpStream, heard: &Sender<Heard>) {
    let mut buffer = [0; 2048];
    loop {
        let len = stream.read(&mut buffer).unwrap_or(0);
        let Ok(own) = stream.try_clone() else { return };
        let bytes = buffer[..len].to_vec();
        if heard.send(Heard { connection, stream: own, bytes }).is_err() || len == 0 {
            return;
        }
    }
}

/// The monitor's life: time passes, and what is heard is answered. It ends with the listener.
fn live(mut sim: Sim, all: &Receiver<Heard>) {
    let start = Instant::now();
    // Frames of one connection must not be cut by bytes of another.
    let mut ports: HashMap<usize, Port> = HashMap::new();
    loop {
        let heard = all.recv_timeout(PACE);
        let now_ms = start.elapsed().as_millis() as u64;
        sim.advance_ms(now_ms.saturating_sub(sim.now_ms()));
        match heard {
            Ok(Heard { connection, bytes, .. }) if bytes.is_empty() => {
                ports.remove(&connection);
            }
            Ok(Heard { connection, mut stream, bytes }) => {
                let port =
                    ports.entry(connection).or_insert_with(|| Port::new(Source::ExternalConn));
                let answer = sim.receive(port, &bytes);
                if stream.write_all(&answer).is_err() {
                    ports.remove(&connection);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use lafet_proto::link::{Frame, WIRE_MAX, encode};

    use super::*;

    #[test]
    fn each_connection_is_answered() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let place = listener.local_addr().expect("its address");
        let all = listen(listener);
        thread::spawn(move || live(Sim::new(Config::default()), &all));
        let probe = |dst, src| {
            let mut wire = [0; WIRE_MAX];
            let len = encode(&Frame { dst, src, payload: &[] }, &mut wire).expect("room");
            wire[..len].to_vec()
        };
        let connect = || TcpStream::connect(place).expect("a connection");
        let (mut first, mut second) = (connect(), connect());
        // A frame that is cut in two, with one of another connection in between.
        let mut begin = probe(1, 129);
        let end = begin.split_off(3);
        first.write_all(&begin).expect("sent");
        for (stream, bytes, src) in [(&mut second, probe(1, 130), 130), (&mut first, end, 129)] {
            stream.write_all(&bytes).expect("sent");
            let mut answer = vec![0; probe(src, 1).len()];
            stream.read_exact(&mut answer).expect("an answer");
            assert_eq!(answer, probe(src, 1));
        }
    }
}
