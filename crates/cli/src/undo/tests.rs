//! Cuts the line in each phase of each command that moves or opens, in two ways, on virtual time;
//! the commands are the real ones, the monitor is simulated.

use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use clap::FromArgMatches;
use lafet_client::{Client, Config, Monitor};
use lafet_device::Source;
use lafet_proto::flags::DriveFlags;
use lafet_proto::link::{Decoder, Frame, WIRE_MAX, encode};
use lafet_proto::record::{HEADER_SIZE, Records};
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use lafet_sim::sim;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::sync::watch;
use tokio::time::{Instant, sleep, sleep_until};

use super::{Because, REACH, States, Undo};
use crate::cli::Cli;
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::follow::{Follow, Step};
use crate::interrupt::Interrupt;
use crate::interrupt::tests::press;
use crate::out::{Out, tests::warned};
use crate::serve::{Habits, Shared, Wire, pace, serve_stream};
use crate::{dispatch, help};

const URL: &str = "tcp://monitor.example:10485";
/// For how long a line that comes back is cut: longer than the repetitions of a read take.
const AWAY: Duration = Duration::from_secs(6);
/// Longer than any test takes, in virtual time.
const NEVER: Duration = Duration::from_secs(3600);

/// How the line is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    /// The stream ends.
    End,
    /// Nothing passes any more, and no error is reported.
    Silence,
}

/// When the line is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The request was sent and does not arrive.
    BeforeArrival,
    /// The request has arrived, its answer does not.
    BeforeAnswer,
    /// This many answers have arrived.
    After(u32),
    /// What was started is at rest again, unseen by the command.
    AtTheEnd,
}

/// A command, and the preparation of the monitor.
struct Case {
    words: &'static [&'static str],
    before: &'static [Body<'static>],
    /// The warning shown to the user.
    risk: &'static str,
    /// Number of exchanges before the request that starts something.
    reads: u32,
    /// Whether the command ends with the answer.
    brief: bool,
    /// Whether it continues until it is stopped, or has nothing to find here.
    endless: bool,
}

const DEPLOYED: &[Body<'static>] = &[Body::Deploy];

const fn case(words: &'static [&'static str], risk: &'static str) -> Case {
    Case { words, before: DEPLOYED, risk, reads: 0, brief: false, endless: false }
}

const FOLLOWED: [&str; 10] = [
    "quench",
    "--centre",
    "30deg,0",
    "--sector",
    "6deg,2deg",
    "--step",
    "1",
    "--distance",
    "25",
    "--follow",
];

const PATH: [&str; 6] =
    ["trajectory", "--point", "20deg,-2deg,25,50", "--point", "40deg,-2deg,25,50", "--follow"];

fn cases() -> Vec<Case> {
    let (follow, [quench @ .., _]) = (&FOLLOWED, &FOLLOWED);
    let (followed, [path @ .., _]) = (&PATH, &PATH);
    vec![
        Case { before: &[], ..case(&["deploy"], "Deployer may still move") },
        case(&["wrap"], "Deployer may still move"),
        case(&["move", "vertical", "20deg"], "Vertical may still move"),
        case(&["move", "horizontal", "-60deg"], "Horizontal may still move"),
        case(&["move", "nozzle", "0"], "Nozzle may still move"),
        case(&["open"], "Valve1 may be open, and water may flow"),
        case(&["open", "valve2"], "Valve2 may be open, and water may flow"),
        Case {
            before: &[Body::Deploy, Body::Open { key: lafet_proto::id::key::OPEN }],
            ..case(&["close"], "Valve1 may be open, and water may flow")
        },
        case(
            &["seek", "--from-az", "-9", "--to-az", "9", "--from-el", "0", "--to-el", "2"],
            "The barrel may still move",
        ),
        Case { endless: true, ..case(&["justify"], "The barrel may still move") },
        Case { endless: true, ..case(follow, "The extinguishing program may still run") },
        Case { endless: true, ..case(followed, "The extinguishing program may still run") },
        Case {
            reads: 1,
            endless: true,
            ..case(&["program", "run", "3", "--follow"], "The extinguishing program may still run")
        },
        Case { brief: true, ..case(&["move", "vertical", "20deg", "--no-wait"], "Vertical may") },
        Case { brief: true, ..case(&["open", "--no-wait"], "Valve1 may be open") },
        Case { brief: true, ..case(quench, "The extinguishing program may") },
        Case { brief: true, ..case(path, "The extinguishing program may") },
        Case { reads: 1, brief: true, ..case(&["program", "run", "3"], "The extinguishing pr") },
        Case {
            // A state, the limits, a state; then limits are switched off, taken and switched on.
            reads: 3,
            brief: true,
            ..case(&["limits", "teach", "--here", "left"], "limits of Horizontal may still be off")
        },
        Case {
            reads: 6,
            brief: true,
            ..case(&["limits", "teach", "--here", "left"], "limits of Horizontal may still be off")
        },
        Case { brief: true, ..case(&["send", "Move Vertical 1200"], "Vertical may still move") },
        Case { brief: true, ..case(&["send", "Stop All"], "The barrel may still move") },
        Case {
            brief: true,
            before: &[Body::Deploy, Body::Open { key: lafet_proto::id::key::OPEN }],
            ..case(&["send", "Close Valve1"], "Valve1 may be open, and water may flow")
        },
        Case {
            brief: true,
            ..case(
                &["send", "Open Valve1", "Move Nozzle 0"],
                "Nozzle may still move; Valve1 may be",
            )
        },
    ]
}

/// When and how the relay cuts the line.
#[derive(Clone, Copy, Debug)]
struct Plan {
    cut: Cut,
    phase: Phase,
    reads: u32,
    away: Duration,
}

/// What else goes wrong on the line.
#[derive(Clone, Copy, Default)]
struct Tricks {
    /// Frames with this request are lost.
    swallows: Option<RequestId>,
    /// Until Stop is sent, the answers show a drive at rest: a remote unit reports late.
    veils: bool,
}

/// The line between program and monitor, cut once.
struct Line {
    shared: Shared,
    plan: Option<Plan>,
    tricks: Tricks,
    answers: u32,
    since: Option<Instant>,
    cut: watch::Sender<bool>,
}

type Wired = Arc<Mutex<Line>>;

fn with<T>(line: &Wired, change: impl FnOnce(&mut Line) -> T) -> T {
    change(&mut line.lock().unwrap_or_else(PoisonError::into_inner))
}

impl Line {
    /// Whether nothing passes now.
    fn is_cut(&self) -> bool {
        let away = self.plan.map_or(Duration::ZERO, |plan| plan.away);
        self.since.is_some_and(|since| since.elapsed() < away)
    }

    fn cut_now(&mut self) {
        if self.since.is_none() {
            self.since = Some(Instant::now());
            self.cut.send_replace(true);
        }
    }

    /// A frame of the program has arrived; returns whether to pass it on.
    fn asked(&mut self, bytes: &[u8]) -> bool {
        let asks = |id| requests(bytes).contains(&id);
        self.tricks.veils &= !asks(RequestId::STOP);
        if self.tricks.swallows.is_some_and(asks) {
            return false;
        }
        if let Some(Plan { phase: Phase::BeforeArrival, reads, .. }) = self.plan
            && self.answers == reads
        {
            self.cut_now();
        }
        !self.is_cut()
    }

    /// The monitor has answered; returns whether to pass the answer on.
    fn answered(&mut self) -> bool {
        match self.plan {
            Some(Plan { phase: Phase::BeforeAnswer, reads, .. }) if self.answers == reads => {
                self.cut_now();
            }
            Some(Plan { phase: Phase::After(count), reads, .. })
                if self.answers == reads + count =>
            {
                self.cut_now();
            }
            Some(Plan { phase: Phase::AtTheEnd, reads, .. })
                if self.answers > reads + 3 && is_at_rest(&self.shared) =>
            {
                self.cut_now();
            }
            _ => {}
        }
        self.answers += 1;
        !self.is_cut()
    }
}

/// Whether no drive turns and no valve's motor runs.
fn is_at_rest(shared: &Shared) -> bool {
    shared.lock().world().outputs().is_still()
}

/// The requests of a frame.
fn requests(bytes: &[u8]) -> Vec<RequestId> {
    let mut decoder: Decoder = Decoder::new();
    let mut all = Vec::new();
    for byte in bytes {
        let Some(frame) = decoder.push(*byte) else { continue };
        all.extend(Records::new(frame.payload).flatten().map(|record| record.request));
    }
    all
}

/// A frame of the monitor whose drives do not seem to move.
fn veiled(bytes: &[u8]) -> Vec<u8> {
    let mut decoder: Decoder = Decoder::new();
    let mut all = Vec::new();
    for byte in bytes {
        let Some(frame) = decoder.push(*byte) else { continue };
        let mut payload = frame.payload.to_vec();
        let mut at = 0;
        for record in Records::new(frame.payload).flatten() {
            let data = at + HEADER_SIZE;
            if record.request == RequestId::GET_STATUS && record.device.is_drive() {
                let moves = DriveFlags::MOVE.bits().to_le_bytes();
                let flags = payload[data..].iter_mut().take(record.data.len());
                flags.zip(moves).for_each(|(byte, mask)| *byte &= !mask);
            }
            at = data + record.data.len();
        }
        let mut wire = [0; WIRE_MAX];
        let frame = Frame { payload: &payload, ..frame };
        let len = encode(&frame, &mut wire).unwrap();
        all.extend(&wire[..len]);
    }
    all
}

/// Passes frames on; both sides write whole frames.
async fn relay(line: Wired, mut ours: DuplexStream, mut monitor: DuplexStream) {
    let mut cut = with(&line, |line| line.cut.subscribe());
    let ends = with(&line, |line| line.plan.is_none_or(|plan| plan.cut == Cut::End));
    let (mut up, mut down) = ([0; 2048], [0; 2048]);
    loop {
        tokio::select! {
            read = ours.read(&mut up) => match read {
                Ok(0) | Err(_) => return,
                Ok(count) => if with(&line, |line| line.asked(&up[..count])) {
                    monitor.write_all(&up[..count]).await.unwrap();
                },
            },
            read = monitor.read(&mut down) => match read {
                Ok(0) | Err(_) => return,
                Ok(count) => {
                    let veils = with(&line, |line| line.tricks.veils);
                    let bytes = if veils { veiled(&down[..count]) } else { down[..count].to_vec() };
                    if with(&line, Line::answered) && ours.write_all(&bytes).await.is_err() {
                        return;
                    }
                }
            },
            _ = cut.changed() => {}
        }
        if ends && with(&line, |line| line.is_cut()) {
            return;
        }
    }
}

/// Connects the program over the line.
async fn connect(line: &Wired) -> Connection {
    let dial = {
        let line = line.clone();
        move || {
            let line = line.clone();
            async move {
                if with(&line, |line| line.is_cut()) {
                    return Err(io::ErrorKind::ConnectionRefused.into());
                }
                let (ours, theirs) = tokio::io::duplex(4096);
                let (monitor, served) = tokio::io::duplex(4096);
                let shared = with(&line, |line| line.shared.clone());
                tokio::spawn(relay(line, theirs, monitor));
                tokio::spawn(async move {
                    let wire = Wire::link(Source::ExternalConn);
                    serve_stream(served, wire, &shared, Habits::default(), || {}).await
                });
                Ok(ours)
            }
        }
    };
    let client = Client::dial(URL, dial, Config::default()).await.unwrap();
    Connection { monitor: Monitor::new(client.clone()), client }
}

fn prepared(before: &[Body<'static>]) -> sim::Sim {
    let mut sim = sim::Sim::new(sim::Config::default());
    sim.advance_ms(1000);
    for body in before {
        let to = match body {
            Body::Open { .. } => SubsystemId::VALVE1,
            _ => SubsystemId::DEPLOYER,
        };
        sim.ask(to, *body, |answer| assert!(answer.status.is_success(), "{body:?}"));
        // Wait until it is completed.
        for _ in 0..600 {
            sim.advance_ms(100);
            if sim.world().outputs().is_still() {
                break;
            }
        }
    }
    let values = [1800, 0, 60, 360, 120, 1, 25];
    let id = lafet_proto::ParamId::of("Program3");
    let body = Body::SetParam { id, values: lafet_proto::Ints::Values(&values) };
    sim.ask(SubsystemId::CONTROL, body, |answer| assert!(answer.status.is_success()));
    sim
}

fn parsed(words: &[&str]) -> Cli {
    let mut matches = help::command().no_binary_name(true).try_get_matches_from(words).unwrap();
    Cli::from_arg_matches_mut(&mut matches).unwrap()
}

/// Outcome of a command.
struct Run {
    outcome: Outcome,
    warned: Vec<String>,
    shared: Shared,
    was_cut: bool,
}

impl Run {
    fn code(&self) -> u8 {
        self.outcome.as_ref().err().map_or(0, Failure::exit_code)
    }

    fn message(&self) -> String {
        self.outcome.as_ref().err().map_or_else(String::new, Failure::message)
    }

    /// Whether every valve that this command may have opened is closed, and nothing turns.
    fn is_undone(&self) -> bool {
        let mut closed = true;
        for valve in [SubsystemId::VALVE1, SubsystemId::VALVE2] {
            self.shared.lock().ask(valve, Body::GetStatus, |answer| {
                let bits = answer.data.flags_bits().unwrap();
                closed &= bits & lafet_proto::flags::ValveFlags::CLOSED.bits() != 0;
            });
        }
        closed && is_at_rest(&self.shared)
    }
}

/// Runs a command over a line that is cut, on virtual time; `fingers` presses Ctrl-C.
async fn run_with<F: Future<Output = ()>>(
    case: &Case,
    monitor: &sim::Sim,
    plan: Option<Plan>,
    fingers: impl FnOnce(Wired) -> F,
) -> Run {
    run_on(case, monitor, plan, Tricks::default(), fingers).await
}

async fn run_on<F: Future<Output = ()>>(
    case: &Case,
    monitor: &sim::Sim,
    plan: Option<Plan>,
    tricks: Tricks,
    fingers: impl FnOnce(Wired) -> F,
) -> Run {
    warned();
    let shared = Shared::new(monitor.clone());
    let cut = watch::Sender::new(false);
    let line = Line { shared: shared.clone(), plan, tricks, answers: 0, since: None, cut };
    let line = Arc::new(Mutex::new(line));
    // If the monitor is never seen again, it need not be fast.
    let seen = plan.is_none_or(|plan| plan.away < NEVER);
    tokio::spawn(pace(shared.clone(), if seen { 1.0 } else { 0.02 }));
    let connection = connect(&line).await;
    let Cli { mut global, command } = parsed(case.words);
    global.connect = Some(URL.into());
    global.open = Some((URL.into(), connection));
    let mut out = Out::new(true);
    let work = dispatch(command, &global, &mut out);
    let (outcome, ()) = tokio::join!(work, fingers(line.clone()));
    // No delayed frame sets it in motion again.
    sleep(Duration::from_millis(300)).await;
    let was_cut = with(&line, |line| line.since.is_some());
    Run { outcome, warned: warned(), shared, was_cut }
}

async fn run(case: &Case, monitor: &sim::Sim, plan: Option<Plan>) -> Run {
    run_with(case, monitor, plan, |_| async {}).await
}

fn phases(case: &Case) -> Vec<(Phase, Cut)> {
    let both = |phase| [(phase, Cut::End), (phase, Cut::Silence)];
    let mut phases = both(Phase::BeforeArrival).to_vec();
    phases.extend(both(Phase::BeforeAnswer));
    if !case.brief {
        phases.extend(both(Phase::After(1)));
        phases.extend(both(Phase::After(7)));
    }
    if !case.brief && !case.endless {
        phases.extend(both(Phase::AtTheEnd));
    }
    phases
}

#[tokio::test(start_paused = true)]
async fn over_a_whole_line_every_command_ends() {
    for case in cases().into_iter().filter(|case| !case.endless) {
        let run = run(&case, &prepared(case.before), None).await;
        assert_eq!(run.code(), 0, "{:?}: {}", case.words, run.message());
        assert!(run.warned.is_empty() && !run.was_cut, "{:?} {:?}", case.words, run.warned);
    }
}

#[tokio::test(start_paused = true)]
async fn what_was_started_is_at_rest_when_the_line_returns() {
    let mut cells = 0;
    for case in cases() {
        let monitor = prepared(case.before);
        for (phase, cut) in phases(&case) {
            let plan = Plan { cut, phase, reads: case.reads, away: AWAY };
            let run = run(&case, &monitor, Some(plan)).await;
            let what = format!("{:?} {plan:?}: {} {:?}", case.words, run.message(), run.warned);
            assert!(run.was_cut, "{what}");
            // A repeated Close reaches its own goal.
            let done = case.words == ["close"];
            assert_eq!(run.code(), if done { 0 } else { 1 }, "{what}");
            let warned = run.warned.join("\n");
            assert!(warned.contains(case.risk), "{what}");
            assert!(warned.contains("Ctrl-C gives up"), "{what}");
            assert!(done || run.message().contains("at rest now"), "{what}");
            assert!(run.is_undone(), "{what}");
            cells += 1;
        }
    }
    assert!(cells >= 130, "{cells}");
}

/// In each phase of each command.
fn all_phases(case: &Case) -> Vec<Phase> {
    let mut all: Vec<Phase> = phases(case).into_iter().map(|(phase, _)| phase).collect();
    all.dedup();
    all
}

#[tokio::test(start_paused = true)]
async fn where_the_line_stays_cut_the_emergency_stop_is_named_in_time() {
    stays_cut(|_| vec![Phase::BeforeAnswer]).await;
}

#[tokio::test(start_paused = true)]
#[ignore = "two minutes"]
async fn the_same_in_each_phase() {
    stays_cut(all_phases).await;
}

async fn stays_cut(phases: impl Fn(&Case) -> Vec<Phase>) {
    for (index, case) in cases().into_iter().enumerate() {
        let monitor = prepared(case.before);
        // The kind of cut makes no difference to what follows.
        let cut = [Cut::End, Cut::Silence][index % 2];
        for phase in phases(&case) {
            let plan = Plan { cut, phase, reads: case.reads, away: NEVER };
            let began = Instant::now();
            let run = run(&case, &monitor, Some(plan)).await;
            let what = format!("{:?} {plan:?}: {}", case.words, run.message());
            assert_eq!(run.code(), 4, "{what}");
            assert!(run.message().contains("Use the emergency stop"), "{what}");
            assert!(run.message().contains(case.risk), "{what}");
            assert!(began.elapsed() < REACH * 3, "{what}: {:?}", began.elapsed());
        }
    }
}

/// Waits until the line is cut, plus a pause.
async fn after_the_cut(line: &Wired, pause: Duration) {
    let mut cut = with(line, |line| line.cut.subscribe());
    cut.wait_for(|cut| *cut).await.unwrap();
    sleep(pause).await;
}

#[tokio::test(start_paused = true)]
async fn ctrl_c_with_the_line_cut() {
    let last = |case: &Case| if case.brief { Phase::BeforeAnswer } else { Phase::After(7) };
    ctrl_c_with_the_line_cut_in(|case| vec![last(case)]).await;
}

#[tokio::test(start_paused = true)]
#[ignore = "two minutes"]
async fn ctrl_c_with_the_line_cut_in_each_phase() {
    ctrl_c_with_the_line_cut_in(all_phases).await;
}

async fn ctrl_c_with_the_line_cut_in(phases: impl Fn(&Case) -> Vec<Phase>) {
    let soon = Duration::from_millis(20);
    let cases = cases();
    for (case, phase) in
        cases.iter().flat_map(|case| phases(case).into_iter().map(move |phase| (case, phase)))
    {
        let monitor = prepared(case.before);
        let plan = |away| Plan { cut: Cut::Silence, phase, reads: case.reads, away };
        // The cut is not noticed yet: Stop is sent once the line is back.
        let run = run_with(case, &monitor, Some(plan(AWAY)), |line| async move {
            after_the_cut(&line, soon).await;
            press();
        });
        let run = run.await;
        let what = format!("{:?} {phase:?}: {} {:?}", case.words, run.message(), run.warned);
        assert_eq!(run.code(), 130, "{what}");
        assert!(run.warned.join("\n").contains(case.risk), "{what}");
        assert!(run.is_undone() && run.message().contains("at rest now"), "{what}");
        // Another Ctrl-C gives up at once, and says so.
        let run = run_with(case, &monitor, Some(plan(NEVER)), |line| async move {
            after_the_cut(&line, soon).await;
            press();
            sleep(Duration::from_secs(5)).await;
            press();
            sleep_until(Instant::now() + soon).await;
        });
        let began = Instant::now();
        let run = run.await;
        let what = format!("{:?} {phase:?}: {}", case.words, run.message());
        assert_eq!(run.code(), 4, "{what}");
        assert!(run.message().contains("Gave up"), "{what}");
        assert!(run.message().contains("Use the emergency stop"), "{what}");
        assert!(began.elapsed() < REACH * 3, "{what}");
    }
}

/// A terminal that closes sends several signals, and a key bounces: what belongs to the first gives
/// nothing up.
#[tokio::test(start_paused = true)]
async fn a_second_ctrl_c_at_once_does_not_give_up() {
    let (open, monitor) = (case(&["open"], ""), prepared(DEPLOYED));
    let run = run_with(&open, &monitor, None, |_| async {
        sleep(Duration::from_millis(500)).await;
        press();
        sleep(Duration::from_millis(5)).await;
        press();
    });
    let run = run.await;
    assert_eq!(run.code(), 130, "{}", run.message());
    assert!(run.is_undone() && run.message().contains("at rest now"), "{}", run.message());
}

/// A Stop that is never answered holds up no Close.
#[tokio::test(start_paused = true)]
async fn one_request_that_is_lost_holds_up_no_other() {
    let words = case(&["send", "Move Nozzle 0", "Open Valve1"], "");
    let plan = Plan { cut: Cut::Silence, phase: Phase::BeforeAnswer, reads: 0, away: AWAY };
    let tricks = Tricks { swallows: Some(RequestId::STOP), ..Tricks::default() };
    let monitor = prepared(DEPLOYED);
    let run = run_on(&words, &monitor, Some(plan), tricks, |_| async {}).await;
    assert_eq!(run.code(), 4, "{}", run.message());
    assert!(run.was_cut && run.is_undone(), "{} {:?}", run.message(), run.warned);
}

/// What is not seen to begin is undone: it begins later, where a remote unit is slow.
#[tokio::test(start_paused = true)]
async fn a_motion_that_is_seen_late_is_stopped() {
    let words = case(&["move", "horizontal", "-60deg"], "");
    let tricks = Tricks { veils: true, ..Tricks::default() };
    let run = run_on(&words, &prepared(DEPLOYED), None, tricks, |_| async {}).await;
    assert_eq!(run.code(), 1, "{}", run.message());
    assert!(run.is_undone() && run.message().contains("at rest now"), "{}", run.message());
    assert!(run.message().contains("Horizontal stopped at"), "{}", run.message());
}

/// A signal that came before a motion keeps it from starting.
#[tokio::test(start_paused = true)]
async fn a_motion_does_not_start_after_a_signal() {
    let line = wired(&prepared(DEPLOYED));
    let connection = connect(&line).await;
    let mut interrupt = Interrupt::catch().unwrap();
    press();
    let request = Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: -3600 });
    let follow = Follow {
        connection: &connection,
        watch: &[SubsystemId::HORIZONTAL],
        undo: Undo::of(&request).unwrap(),
    };
    let (mut out, mut sent) = (Out::new(true), false);
    let start = async {
        sent = true;
        connection.send(&request).await
    };
    let idle = |_: &States| Step::Idle(String::new());
    let ended = follow.run_until(&mut interrupt, &mut out, start, idle).await;
    assert_eq!(ended.err().map(|failure| failure.exit_code()), Some(130));
    assert!(!sent);
}

/// Stop All leaves a valve half open: it is named, with what closes it.
#[tokio::test(start_paused = true)]
async fn a_valve_that_stop_all_leaves_open_is_named() {
    let monitor = prepared(DEPLOYED);
    for (valve, named) in [(None, false), (Some(SubsystemId::VALVE1), true)] {
        let line = wired(&monitor);
        let connection = connect(&line).await;
        if let Some(valve) = valve {
            connection.send(&Request::open(valve)).await.unwrap();
            sleep(Duration::from_secs(1)).await;
        }
        let (mut out, mut interrupt) = (Out::new(true), Interrupt::catch().unwrap());
        let stop = Undo::everything();
        let ended = stop.carry_out(&connection, &mut out, &mut interrupt, Because::Interrupted);
        let ended = ended.await;
        assert_eq!(ended.exit_code(), 130, "{}", ended.message());
        let says = ended.message().contains("Valve1 is not closed");
        assert_eq!(says, named, "{}", ended.message());
        assert_eq!(ended.message().contains("lafet close valve1"), named, "{}", ended.message());
    }
}

/// A whole line to a copy of this monitor.
fn wired(monitor: &sim::Sim) -> Wired {
    let shared = Shared::new(monitor.clone());
    tokio::spawn(pace(shared.clone(), 1.0));
    let (cut, tricks) = (watch::Sender::new(false), Tricks::default());
    Arc::new(Mutex::new(Line { shared, plan: None, tricks, answers: 0, since: None, cut }))
}
