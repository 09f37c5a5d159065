//! A line between the program and a simulated monitor on which something is lost or held up.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lafet_proto::RequestId;
use lafet_proto::link::Decoder;
use lafet_proto::record::Records;

use crate::support::Sim;

/// A request as it was seen on the line.
pub struct Asked {
    pub request: RequestId,
    pub data: Vec<u8>,
}

/// What becomes of a piece of the stream to the monitor.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    Passed,
    Lost,
    /// It is passed, and what comes back next is lost.
    AnswerLost,
}

/// The URL of such a line, for one connection at a time. `fate` is asked about each piece, with the requests that end in
/// it; the piece waits meanwhile.
pub fn between(sim: &Sim, mut fate: impl FnMut(&[Asked]) -> Fate + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}?addr=1", listener.local_addr().unwrap());
    let place = sim.place().to_owned();
    std::thread::spawn(move || {
        for near in listener.incoming().map_while(Result::ok) {
            if !carry(near, &place, &mut fate) {
                return;
            }
        }
    });
    url
}

/// Carries a connection to its end; `false` when the monitor is gone.
fn carry(mut near: TcpStream, place: &str, fate: &mut impl FnMut(&[Asked]) -> Fate) -> bool {
    let mut far = TcpStream::connect(place).unwrap();
    let deaf = Arc::new(AtomicBool::new(false));
    let (back, there) = (far.try_clone().unwrap(), near.try_clone().unwrap());
    let hears_not = deaf.clone();
    std::thread::spawn(move || answers(back, there, &hears_not));
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 1024];
    while let Ok(len @ 1..) = near.read(&mut buffer) {
        let piece = &buffer[..len];
        let mut asked = Vec::new();
        for byte in piece {
            let Some(frame) = decoder.push(*byte) else { continue };
            asked.extend(
                Records::new(frame.payload)
                    .flatten()
                    .map(|record| Asked { request: record.request, data: record.data.to_vec() }),
            );
        }
        let fate = fate(&asked);
        deaf.store(fate == Fate::AnswerLost, Ordering::SeqCst);
        if fate != Fate::Lost && far.write_all(piece).is_err() {
            return false;
        }
    }
    true
}

fn answers(mut back: TcpStream, mut there: TcpStream, hears_not: &AtomicBool) {
    let mut buffer = [0; 1024];
    while let Ok(len @ 1..) = back.read(&mut buffer) {
        let lost = hears_not.swap(false, Ordering::SeqCst);
        if !lost && there.write_all(&buffer[..len]).is_err() {
            return;
        }
    }
}
