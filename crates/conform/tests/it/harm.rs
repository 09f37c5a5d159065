//! What the tester must not do or leave behind: when others use the monitor, when answers are lost, and
//! when the monitor takes what it must refuse.

use std::fs;
use std::io::Write;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lafet_client::backup::Backup;
use lafet_client::transport::Link;
use lafet_client::url::Endpoint;
use lafet_conform::line::{Line, LinkLine};
use lafet_conform::raw::{self, Rec};
use lafet_conform::{Level, Options, Report, run};
use lafet_proto::flags::{DriveFlags, GeneralFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use crate::support::{BOARD, Between, Frames, SimLine, ask, monitor};
use crate::wrong::{asks, flags, pass, reflag, says, secretly};

const LIMITLESS: u32 = DriveFlags::LIMITLESS.bits();
/// Requests that move something.
const MOTIONS: [R; 4] = [R::MOVE, R::DEPLOY, R::WRAP, R::OPEN];

/// A monitor whose frames pass through a function, which answers them; `None` loses the answer.
struct Layer<F> {
    frames: Frames,
    handle: F,
}

impl<F: FnMut(&mut Sim, &[Rec]) -> Option<Vec<Rec>>> Between for Layer<F> {
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        for (src, payload) in self.frames.take(sim, bytes) {
            let address = sim.address();
            let asked = Rec::all(&payload).unwrap_or_default();
            let answer: Option<Vec<u8>> = match asked.is_empty() {
                true => Some(ask(sim, &payload)),
                false => (self.handle)(sim, &asked)
                    .map(|answers| answers.iter().flat_map(Rec::bytes).collect()),
            };
            if let Some(answer) = answer {
                out.extend(raw::frame(src, address, &answer));
            }
        }
        out
    }
}

/// Tests a monitor through a function, with the tests of one item; returns the monitor as it is left.
pub fn tested(
    sim: Sim,
    level: Level,
    only: &str,
    handle: impl FnMut(&mut Sim, &[Rec]) -> Option<Vec<Rec>>,
) -> (Report, Sim) {
    tested_in(&std::env::temp_dir(), sim, level, only, handle)
}

/// With the folder for the copy of an erased memory.
fn tested_in(
    folder: &Path,
    sim: Sim,
    level: Level,
    only: &str,
    handle: impl FnMut(&mut Sim, &[Rec]) -> Option<Vec<Rec>>,
) -> (Report, Sim) {
    let (monitor, keep_in) = (sim.address(), folder.to_owned());
    let mut line = SimLine::new(sim, Layer { frames: Frames::default(), handle });
    let only = vec![only.to_owned()];
    let board = Some(BOARD.to_owned());
    let options =
        Options { level, only, monitor, keep_in, board, strict: true, ..Options::default() };
    let report = run(&mut line, &options, &mut |_| {});
    (report, line.sim)
}

/// An empty folder of this name.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder");
    path
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let all = fs::read_dir(folder).expect("a folder");
    all.map(|entry| entry.expect("an entry").path()).collect()
}

fn id(name: &str) -> [u8; 2] {
    ParamId::of(name).0.to_le_bytes()
}

/// Whether it sets this parameter.
fn sets(rec: &Rec, name: &str) -> bool {
    rec.request == R::SET_PARAM && rec.data.starts_with(&id(name))
}

/// A parameter as GetParam reads it.
fn read(sim: &mut Sim, of: S, name: &str) -> Vec<u8> {
    let rec = secretly(sim, R::GET_PARAM, of, &id(name)).pop().expect("an answer");
    assert_eq!(rec.status, Status::OK, "{name}");
    rec.data
}

fn moves(rec: &Rec) -> bool {
    MOTIONS.contains(&rec.request)
}

/// Others lock the monitor out: it stays locked out, and nothing else is tried.
#[test]
fn a_lockout_by_others_is_left_alone() {
    let (mut locked, mut after) = (false, Vec::new());
    let (report, mut sim) = tested(monitor("full"), Level::Full, "§3.18", |sim, asked| {
        if locked {
            after.extend_from_slice(asked);
        }
        let answers = pass(sim, asked);
        if !locked && asks(asked, R::LOCKOUT) {
            secretly(sim, R::LOCKOUT, S::ALL, &key::ENABLE.to_le_bytes());
            locked = true;
        }
        Some(answers)
    });
    assert!(locked, "no test of the lockout");
    assert_ne!(flags(&mut sim, S::GENERAL) & GeneralFlags::LOCKED_OUT.bits(), 0, "it was released");
    let release = key::DISABLE.to_le_bytes();
    assert!(!after.iter().any(|rec| rec.request == R::LOCKOUT && rec.data == release), "{after:?}");
    assert!(!after.iter().any(moves), "{after:?}");
    let aborted = report.aborted.as_ref().expect("the run ends");
    assert!(aborted.en.contains("locked out"), "{aborted:?}");
}

/// The same while nothing of the test is refused: it is seen between two steps.
#[test]
fn a_lockout_by_others_ends_the_run_between_two_steps() {
    let mut locked = false;
    let (report, mut sim) = tested(monitor("full"), Level::Full, "set-and-read", |sim, asked| {
        let answers = pass(sim, asked);
        if !locked && asks(asked, R::SET_PARAM) {
            secretly(sim, R::LOCKOUT, S::ALL, &key::ENABLE.to_le_bytes());
            locked = true;
        }
        Some(answers)
    });
    assert_ne!(flags(&mut sim, S::GENERAL) & GeneralFlags::LOCKED_OUT.bits(), 0, "it was released");
    let aborted = report.aborted.as_ref().expect("the run ends");
    assert!(aborted.en.contains("locked out"), "{aborted:?}");
}

/// Another program turns a drive: the barrel is left where it is, and the report says where.
#[test]
fn after_an_unasked_motion_nothing_is_moved() {
    let (mut moved, mut after) = (false, Vec::new());
    let (report, _) = tested(monitor("full"), Level::Motion, "moves", |sim, asked| {
        if moved {
            after.extend_from_slice(asked);
        }
        let answers = pass(sim, asked);
        let turns = |rec: &Rec| rec.request == R::MOVE && rec.device == S::HORIZONTAL;
        if !moved && asked.iter().any(turns) {
            secretly(sim, R::MOVE, S::VERTICAL, &600_i16.to_le_bytes());
            moved = true;
        }
        Some(answers)
    });
    let aborted = report.aborted.as_ref().expect("the run ends");
    assert!(aborted.en.contains("Vertical"), "{aborted:?}");
    let stop = |rec: &Rec| rec.request == R::STOP && rec.device == S::ALL;
    let stop = after.iter().position(stop).expect("Stop All");
    assert!(!after[stop..].iter().any(moves), "{:?}", &after[stop..]);
    let left = report.not_restored.as_ref().expect("it is not where it was");
    assert!(left.en.contains("Wrapped"), "{left:?}");
}

/// With --motion the way home is slow too.
#[test]
fn the_barrel_returns_before_the_speed_is_restored() {
    let mut all = Vec::new();
    let (report, _) = tested(monitor("full"), Level::Motion, "moves", |sim, asked| {
        all.extend_from_slice(asked);
        Some(pass(sim, asked))
    });
    assert!(report.is_good(), "{:?} {:?}", report.aborted, report.not_restored);
    let slow = [&id("Speed")[..], &5_i32.to_le_bytes()].concat();
    let fast = |rec: &Rec| sets(rec, "Speed") && rec.data != slow;
    let restored = all.iter().position(fast).expect("a speed is restored");
    let home = all.iter().rposition(moves).expect("a motion");
    assert_eq!(all[home].request, R::WRAP);
    assert!(home < restored, "{home} {restored}");
}

/// A parameter that a test sets, and whose answer is lost, has its former value afterwards.
fn restored_though_an_answer_is_lost(level: Level, test: &str, (of, name): (S, &str)) {
    let before = read(&mut monitor("full"), of, name);
    let mut sent = 0;
    let (report, mut sim) = tested(monitor("full"), level, test, |sim, asked| {
        let answers = pass(sim, asked);
        sent += usize::from(sets(&asked[0], name));
        let lost = sent == 1 && asks(asked, R::SET_PARAM);
        (!lost).then_some(answers)
    });
    assert_eq!(report.failures().count(), 1);
    assert!(sent > 1, "{sent}");
    assert_eq!(read(&mut sim, of, name), before);
}

#[test]
fn an_address_is_restored_though_an_answer_is_lost() {
    let address = (S::GENERAL, "Address");
    restored_though_an_answer_is_lost(Level::Full, "address-after-restart", address);
}

#[test]
fn an_array_is_restored_though_an_answer_is_lost() {
    restored_though_an_answer_is_lost(Level::Motion, "arrays", (S::CONTROL, "Program7"));
}

/// A monitor that takes what it must refuse.
#[test]
fn a_value_out_of_range_that_is_taken_is_undone() {
    let before = read(&mut monitor("full"), S::GENERAL, "MoveTimeout");
    let mut taken = false;
    let (report, mut sim) = tested(monitor("full"), Level::Motion, "out-of-range", |sim, asked| {
        let mut answers = pass(sim, asked);
        if sets(&asked[0], "MoveTimeout") && answers[0].status == Status::INVALID_VALUE {
            let other = [&id("MoveTimeout")[..], &777_i32.to_le_bytes()].concat();
            secretly(sim, R::SET_PARAM, S::GENERAL, &other);
            answers[0].status = Status::ACCEPTED;
            taken = true;
        }
        Some(answers)
    });
    assert!(taken && !report.is_good());
    assert_eq!(report.not_restored, None);
    assert_eq!(read(&mut sim, S::GENERAL, "MoveTimeout"), before);
}

/// A unit that is busy when its limits are to be switched on is asked again.
#[test]
fn no_drive_is_left_without_limits() {
    let mut asked_for = 0;
    let only = "present-position-only";
    let (report, mut sim) = tested(monitor("full"), Level::Motion, only, |sim, asked| {
        if asked[0].request == R::SWITCH_LIMITS && asked[0].device == S::ALL {
            asked_for += 1;
            if asked_for == 1 {
                return Some(vec![says(&asked[0], S::HORIZONTAL, Status::BUSY)]);
            }
        }
        Some(pass(sim, asked))
    });
    assert!(asked_for > 1, "{asked_for}");
    for drive in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE] {
        assert_eq!(flags(&mut sim, drive) & LIMITLESS, 0, "{drive:?}");
    }
    assert!(report.is_good(), "{:?} {:?}", report.aborted, report.not_restored);
}

#[test]
fn a_monitor_whose_limits_are_off_is_not_moved() {
    let mut sent = Vec::new();
    let (report, _) = tested(monitor("full"), Level::Motion, "moves", |sim, asked| {
        sent.extend_from_slice(asked);
        let mut answers = pass(sim, asked);
        reflag(&mut answers, S::HORIZONTAL, |flags| flags | LIMITLESS);
        Some(answers)
    });
    let aborted = report.aborted.as_ref().expect("it is not tested");
    assert!(aborted.en.contains("Limitless"), "{aborted:?}");
    assert!(!sent.iter().any(|rec| moves(rec) || rec.request == R::SET_PARAM), "{sent:?}");
}

/// §3.19/3 Without its memory it has the address of its hardware, 1; by its configuration it had 3.
#[test]
fn an_erased_monitor_is_found_at_another_address() {
    let mut sim = monitor("full");
    let address = [&id("Address")[..], &3_i32.to_le_bytes()].concat();
    secretly(&mut sim, R::SET_PARAM, S::GENERAL, &address);
    sim.advance_ms(5000);
    secretly(&mut sim, R::RESTART, S::ALL, &[]);
    sim.advance_ms(10_000);
    assert_eq!(sim.address(), 3);
    let mut fell_back = false;
    let (report, mut sim) = tested(sim, Level::Erase, "clean-flash", |sim, asked| {
        fell_back |= sim.address() == 1;
        Some(pass(sim, asked))
    });
    assert!(fell_back, "it kept its address");
    assert!(report.is_good(), "{:?} {:?}", report.aborted, report.not_restored);
    assert_eq!(sim.address(), 3);
    assert_eq!(read(&mut sim, S::GENERAL, "Address"), address);
}

#[test]
fn an_erased_memory_is_written_back_though_answers_are_lost() {
    let before = read(&mut monitor("full"), S::CONTROL, "Height");
    let (mut erased, mut lost) = (false, 0);
    let (folder, only) = (folder("written-back"), "clean-flash");
    let (report, mut sim) =
        tested_in(&folder, monitor("full"), Level::Erase, only, |sim, asked| {
            erased |= asks(asked, R::CLEAN_FLASH);
            let answers = pass(sim, asked);
            // Those to General are sent by the test too, which fails without an answer.
            let set = asked[0].request == R::SET_PARAM && asked[0].device != S::GENERAL;
            if erased && set && lost < 2 {
                lost += 1;
                return None;
            }
            Some(answers)
        });
    assert_eq!(lost, 2);
    assert!(report.is_good(), "{:?} {:?}", report.aborted, report.not_restored);
    assert_eq!(read(&mut sim, S::CONTROL, "Height"), before);
    assert!(files(&folder).is_empty(), "the copy is not needed any more");
    fs::remove_dir_all(&folder).expect("an empty folder");
}

/// The monitor never answers again: the copy is in a file, which was there before, and is named.
#[test]
fn the_copy_of_an_erased_memory_stays_in_a_file() {
    let (mut erased, mut kept) = (false, Vec::new());
    let (folder, only) = (folder("kept"), "clean-flash");
    let (report, _) = tested_in(&folder, monitor("full"), Level::Erase, only, |sim, asked| {
        if !erased && asks(asked, R::CLEAN_FLASH) {
            erased = true;
            kept = files(&folder);
        }
        (!erased).then(|| pass(sim, asked))
    });
    assert!(erased);
    assert_eq!(kept.len(), 1, "{kept:?}");
    assert_eq!(files(&folder), kept);
    let text = fs::read_to_string(&kept[0]).expect("a file");
    let backup = Backup::from_toml(&text).expect("a backup");
    assert_eq!(backup.get(Param::GeneralAddress), Some(&[1][..]));
    let left = report.not_restored.as_ref().expect("it is not restored");
    assert!(left.en.contains(&kept[0].display().to_string()), "{left:?}");
    fs::remove_dir_all(&folder).expect("a folder");
}

/// A gateway that greets each connection, while the monitor behind it has no power.
#[test]
fn a_port_that_opens_while_nothing_answers_is_given_up() {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let runtime = runtime.expect("a runtime");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let place = listener.local_addr().expect("its address");
    std::thread::spawn(move || {
        let mut open = Vec::new();
        for mut near in listener.incoming().map_while(Result::ok) {
            let _ = near.write_all(b"ready\r\n");
            open.push(near);
        }
    });
    let endpoint: Endpoint = format!("tcp://{place}?addr=1").parse().expect("an endpoint");
    let link = runtime.block_on(Link::open(&endpoint)).expect("a connection");
    let handle = runtime.handle().clone();
    let reach = Duration::from_secs(1);
    let mut line = LinkLine::new(link, Some(endpoint), handle, 1.0).reach(reach);
    let (began, mut opened) = (Instant::now(), 0);
    while line.renew().is_ok() {
        opened += 1;
        assert_eq!(line.recv(2000).expect("a connection"), b"ready\r\n");
        assert!(began.elapsed() < 20 * reach, "it goes on");
    }
    assert!(opened > 0 && line.is_given_up(), "{opened}");
    assert!(began.elapsed() >= reach, "it is given up too soon");
}
