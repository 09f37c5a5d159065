//! A monitor that answers contrary to the protocol: no command that moves or opens reports success,
//! or blames a Stop of another client.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;

use crate::support::{Run, lafet};
use lafet_proto::link::{self, Decoder, Frame};
use lafet_proto::record::Records;
use lafet_proto::{RequestId, Status, SubsystemId};

/// How the answers to reads are wrong; commands are accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Odd {
    /// Success without data.
    Empty,
    /// Success with three bytes.
    Short,
    /// A status that does not exist.
    Status,
    /// Success from this sender, without data.
    Sender(SubsystemId),
    /// Success for another request.
    Request,
}

fn is_read(request: RequestId) -> bool {
    [
        RequestId::GET_STATUS,
        RequestId::GET_PARAM,
        RequestId::RETRIEVE_LIMITS,
        RequestId::GET_HOTBED,
        RequestId::GET_CRASH_DATA,
    ]
    .contains(&request)
}

/// The answer to a record, as bytes. A parameter is read as it should be: it is asked before anything
/// begins.
fn answer(odd: Odd, request: RequestId, device: u8, data: &[u8]) -> Vec<u8> {
    let plain = |status: Status, data: &[u8]| {
        let mut bytes = vec![request.0, device, status.0, data.len() as u8];
        bytes.extend_from_slice(data);
        bytes
    };
    if !is_read(request) {
        return plain(Status::ACCEPTED, &[]);
    }
    if request == RequestId::GET_PARAM {
        let values = [1800_i32, 0, 60, 360, 120, 1, 25].map(i32::to_le_bytes);
        return plain(Status::OK, &[data, &values.concat()].concat());
    }
    match odd {
        Odd::Empty => plain(Status::OK, &[]),
        Odd::Short => plain(Status::OK, &[1, 2, 3]),
        Odd::Status => plain(Status(0xC8), &[]),
        Odd::Sender(sender) => vec![request.0, sender.0, Status::OK.0, 0],
        Odd::Request => vec![RequestId::STOP.0, device, Status::OK.0, 0],
    }
}

fn serve(odd: Odd) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}", listener.local_addr().unwrap());
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            thread::spawn(move || talk(odd, stream));
        }
    });
    url
}

fn talk(odd: Odd, mut stream: TcpStream) {
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 512];
    while let Ok(count @ 1..) = stream.read(&mut buffer) {
        for byte in &buffer[..count] {
            let Some(frame) = decoder.push(*byte) else { continue };
            let records = Records::new(frame.payload).flatten();
            let payload: Vec<u8> =
                records.flat_map(|r| answer(odd, r.request, r.device.0, r.data)).collect();
            let mut wire = vec![0; link::wire_max(payload.len())];
            let back = Frame { dst: frame.src, src: frame.dst, payload: &payload };
            let len = link::encode(&back, &mut wire).unwrap();
            if stream.write_all(&wire[..len]).is_err() {
                return;
            }
        }
    }
}

/// Late answers are not waited for: the monitor does not answer frame numbers, and no other client
/// uses this connection.
fn run(url: &str, words: &[&str]) -> Run {
    run_at(&format!("{url}?late=0"), words)
}

fn run_at(url: &str, words: &[&str]) -> Run {
    let mut command = lafet();
    command.args(["-c", url, "--timeout", "0.2", "--lang", "en"]).args(words);
    Run::of_command(&mut command)
}

const MOTIONS: [&[&str]; 10] = [
    &["move", "vertical", "100"],
    &["deploy"],
    &["wrap"],
    &["open"],
    &["close"],
    &["justify"],
    &["trajectory", "--point", "0,0,25,10", "--follow"],
    &["quench", "--centre", "30deg,0", "--distance", "25", "--follow"],
    &["program", "run", "3", "--follow"],
    &["seek", "--from-az", "-9", "--to-az", "9"],
];

/// What was started cannot be followed: it is stopped, and the emergency stop is named.
#[test]
fn a_motion_that_cannot_be_followed_is_stopped_and_not_called_done() {
    thread::scope(|scope| {
        for odd in [Odd::Empty, Odd::Short, Odd::Status] {
            scope.spawn(move || {
                let url = serve(odd);
                for words in MOTIONS {
                    let run = run(&url, words);
                    let what = format!("{odd:?} {words:?}: {run:?}");
                    assert_eq!(run.code, 4, "{what}");
                    assert!(run.err.contains("what the protocol says"), "{what}");
                    assert!(run.err.contains("Use the emergency stop"), "{what}");
                    assert!(!run.err.contains("Another client"), "{what}");
                }
            });
        }
    });
}

/// What was received is described, not taken for a state or for silence.
#[test]
fn a_state_of_all_that_is_none_says_what_came() {
    for (odd, words) in [
        (Odd::Sender(SubsystemId::ALL), "its sender, All, is no subsystem"),
        (Odd::Sender(SubsystemId(0)), "its sender, 0x00, is no subsystem"),
        (Odd::Empty, "its sender, All, is no subsystem"),
        (Odd::Request, "it answers Stop"),
    ] {
        let run = run(&serve(odd), &["status"]);
        assert_eq!(run.code, 3, "{odd:?}: {run:?}");
        assert!(run.err.contains(words) && run.out.is_empty(), "{odd:?}: {run:?}");
    }
    // In doubt, the answer may be for another program.
    let run = run_at(&serve(Odd::Request), &["status"]);
    assert!(run.code == 3 && run.err.contains("answers Stop, which was not asked"), "{run:?}");
}
