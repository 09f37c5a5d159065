//! Real processes, one after another, on a serial line whose frames are late, lost, doubled, swapped or
//! cut, both ways. The monitor has no feature of ours. No process believes what was answered to
//! another, and none reports a command as done that was not executed for it.
//!
//! `LAFET_LATE_PROCESSES=1000 cargo test -p lafet --test it late::` runs so many processes on each line.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Write};
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{Run, lafet, terminal};
use lafet_proto::answer::Reply;
use lafet_proto::flags::GeneralFlags;
use lafet_proto::link::{self, Decoder, Frame};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::GeneralStatus;
use lafet_proto::{Answer, Ints, Request, RequestId, Status, SubsystemId};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Processes on each line, if nothing else is said.
const PROCESSES: i32 = 8;
/// Longest delay of a frame, ms: a process ends before that.
const LATE_MS: u64 = 2500;

/// What is under way, by its time; the number keeps those of one time apart.
type Flight = BTreeMap<(Instant, u64), Event>;

enum Event {
    /// A frame to the monitor: its sender and payload.
    Request(u8, Vec<u8>),
    /// Bytes to the program.
    Answer(Vec<u8>),
}

/// A monitor behind an adversarial line.
struct Monitor {
    port: File,
    /// The number of the process that runs: what it reads.
    process: Arc<AtomicI32>,
    /// What was executed, and while which process ran.
    executed: Executed,
    random: u64,
    count: u64,
    flight: Flight,
}

impl Monitor {
    /// A number below `bound`.
    fn random(&mut self, bound: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random % bound
    }

    /// When the copies of a frame arrive: none, one or two, a third of them late. A late one is
    /// overtaken by those behind it.
    fn fates(&mut self) -> Vec<Instant> {
        let copies = match self.random(100) {
            0..8 => 0,
            8..20 => 2,
            _ => 1,
        };
        let mut delay = || match self.random(10) {
            0..3 => self.random(LATE_MS),
            _ => 1,
        };
        let delays: Vec<u64> = (0..copies).map(|_| delay()).collect();
        let now = Instant::now();
        delays.into_iter().map(|ms| now + Duration::from_millis(ms)).collect()
    }

    fn send_off(&mut self, event: impl Fn() -> Event) {
        for due in self.fates() {
            self.count += 1;
            self.flight.insert((due, self.count), event());
        }
    }

    fn run(mut self, frames: &Receiver<(u8, Vec<u8>)>) {
        loop {
            let next = self.flight.keys().next().map(|(due, _)| *due);
            let wait = next.map_or(Duration::from_secs(60), |due| {
                due.saturating_duration_since(Instant::now())
            });
            match frames.recv_timeout(wait) {
                Ok((from, payload)) => {
                    self.send_off(|| Event::Request(from, payload.clone()));
                }
                Err(RecvTimeoutError::Timeout) => match self.flight.pop_first() {
                    Some((_, Event::Request(from, payload))) => self.answer(from, &payload),
                    Some((_, Event::Answer(bytes))) => self.port.write_all(&bytes).unwrap(),
                    None => {}
                },
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    fn answer(&mut self, to: u8, payload: &[u8]) {
        let mut buffer = [0; 512];
        let mut out = Writer::new(&mut buffer);
        for record in Records::new(payload).flatten() {
            let process = self.process.load(Ordering::SeqCst);
            self.executed.lock().unwrap().push((process, record.request));
            let values = [process];
            let request = Request::decode(&record);
            let ok = |data| Answer {
                from: record.device,
                request: record.request,
                status: Status::OK,
                data,
            };
            let answer = match (record.device, request.map(|request| request.body)) {
                (SubsystemId::GENERAL, Ok(Body::GetParam { id })) => {
                    ok(Reply::Param { id, values: Ints::Values(&values) })
                }
                (SubsystemId::GENERAL, Ok(Body::GetStatus)) => ok(Reply::General(GeneralStatus {
                    flags: GeneralFlags::empty(),
                    main_voltage: u16::try_from(process % 100).unwrap(),
                    pressure: 0,
                    flowrate: 0,
                })),
                (SubsystemId::HORIZONTAL, Ok(Body::Move { .. })) => {
                    Answer::bare(record.device, record.request, Status::ACCEPTED)
                }
                (SubsystemId::ALL, Ok(Body::Stop)) => {
                    Answer::bare(SubsystemId::HORIZONTAL, record.request, Status::OK)
                }
                _ => Answer::bare(record.device, record.request, Status::MODULE_NOT_EXIST),
            };
            answer.encode(&mut out).unwrap();
        }
        let payload = out.written().to_vec();
        let mut wire = vec![0; link::wire_max(payload.len())];
        let len = link::encode(&Frame { dst: to, src: 1, payload: &payload }, &mut wire).unwrap();
        wire.truncate(len);
        match self.random(20) {
            // Cut short.
            0 => wire.truncate(len / 2),
            // Noise before it.
            1 => wire.splice(0..0, [0x55, 0xDB, 0x00]).for_each(drop),
            _ => {}
        }
        self.send_off(|| Event::Answer(wire.clone()));
    }
}

/// Which process has made the monitor execute what.
type Executed = Arc<Mutex<Vec<(i32, RequestId)>>>;

/// A line; returns its URL, and what the monitor notes.
fn line(seed: u64) -> (String, Arc<AtomicI32>, Executed) {
    let (ours, path) = terminal();
    let kept = File::options().read(true).write(true).open(&path).unwrap();
    let mut settings = tcgetattr(&kept).unwrap();
    settings.make_raw();
    tcsetattr(&kept, OptionalActions::Now, &settings).unwrap();
    let (process, executed) = (Arc::<AtomicI32>::default(), Executed::default());
    let mut reader = ours.try_clone().unwrap();
    let monitor = Monitor {
        port: ours,
        process: process.clone(),
        executed: executed.clone(),
        random: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
        count: 0,
        flight: Flight::new(),
    };
    let (sender, frames) = channel();
    thread::spawn(move || monitor.run(&frames));
    thread::spawn(move || {
        let _kept = kept;
        let mut decoder: Decoder = Decoder::new();
        let mut buffer = [0; 512];
        while let Ok(count @ 1..) = reader.read(&mut buffer) {
            for byte in &buffer[..count] {
                let Some(frame) = decoder.push(*byte) else { continue };
                let back = (frame.src, frame.payload.to_vec());
                if frame.dst == 1 && sender.send(back).is_err() {
                    return;
                }
            }
        }
    });
    (format!("serial://{path}?addr=1&baud=115200"), process, executed)
}

/// What each process in turn does.
const COMMANDS: [&[&str]; 4] = [
    &["param", "get", "general", "MoveTimeout"],
    &["status", "general"],
    &["move", "horizontal", "600", "--no-wait"],
    &["stop"],
];

fn asked(url: &str, words: &[&str]) -> Run {
    let mut command = lafet();
    command.args(["--json", "-c", url, "--timeout", "0.5"]).args(words);
    Run::of_command(&mut command)
}

#[test]
fn no_process_believes_an_answer_to_another() {
    let processes = std::env::var("LAFET_LATE_PROCESSES").ok().and_then(|n| n.parse().ok());
    let processes: i32 = processes.unwrap_or(PROCESSES);
    let done = Mutex::new([0; COMMANDS.len()]);
    thread::scope(|scope| {
        for seed in 1..=6 {
            let done = &done;
            scope.spawn(move || {
                let (url, process, executed) = line(seed);
                for number in 1..=processes {
                    process.store(number, Ordering::SeqCst);
                    let which = usize::try_from(number).unwrap() % COMMANDS.len();
                    let words = COMMANDS[which];
                    let run = asked(&url, words);
                    let what = format!("seed {seed}, process {number}, {words:?}: {run:?}");
                    if run.code != 0 {
                        assert!(matches!(run.code, 1 | 3 | 4), "{what}");
                        continue;
                    }
                    done.lock().unwrap()[which] += 1;
                    let value = &run.json()[0];
                    let own = |id| executed.lock().unwrap().contains(&(number, id));
                    match which {
                        0 => assert_eq!(value["values"][0], number, "{what}"),
                        1 => assert_eq!(value["General"]["main_voltage_v"], number % 100, "{what}"),
                        2 => assert!(own(RequestId::MOVE), "{what}"),
                        _ => assert!(own(RequestId::STOP), "{what}"),
                    }
                }
            });
        }
    });
    let done = done.into_inner().unwrap();
    println!("done, of {} processes: {done:?} of {COMMANDS:?}", 6 * processes);
    assert!(done.iter().all(|count| *count > 0), "{done:?}");
}
