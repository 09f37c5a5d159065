//! Every word and erase of every operation, and every one of the start that follows.

use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Bytes, Status, SubsystemId};
use lafet_sim::flash::{Cut, Torn};
use lafet_sim::sim::Sim;

use super::held::{Held, ask, is_locked, monitor, set, settle, starts};

const CONTROL: SubsystemId = SubsystemId::CONTROL;

/// What is written: started by requests, carried out by the steps that follow.
struct Operation {
    name: &'static str,
    begin: fn(&mut Sim),
    /// Steps of 10 ms after which everything has been written.
    ticks: u32,
    /// Groups written one after the other, so there are states in between.
    in_pieces: bool,
}

const fn operation(name: &'static str, begin: fn(&mut Sim)) -> Operation {
    Operation { name, begin, ticks: 12, in_pieces: false }
}

const OPERATIONS: [Operation; 9] = [
    operation("number", |sim| taken(set(sim, Param::VerticalSpeed, &[9]))),
    operation("program", |sim| {
        taken(set(sim, Param::ControlProgram3, &[-600, 90, 40, 9, 9, 1, 20]))
    }),
    operation("trajectory", |sim| taken(set(sim, Param::ControlTrajectory5, &[70; 60]))),
    operation("correction table", |sim| {
        let corrections: Vec<u8> = (1..=128).collect();
        let body = Body::SetupCorrectionTable { first: 64, corrections: Bytes(&corrections) };
        taken(ask(sim, CONTROL, body));
    }),
    operation("limit", |sim| {
        let switch = |sim: &mut Sim, new_state| {
            assert!(
                ask(sim, SubsystemId::HORIZONTAL, Body::SwitchLimits { new_state }).is_success()
            );
        };
        switch(sim, 0);
        taken(set(sim, Param::HorizontalMinLimit, &[0]));
        switch(sim, 1);
    }),
    operation("lockout", |sim| lockout(sim, key::ENABLE)),
    operation("release", |sim| lockout(sim, key::DISABLE)),
    Operation {
        ticks: 32,
        ..operation("CleanFlash", |sim| {
            let body = Body::CleanFlash { key: key::CLEAN_FLASH };
            assert_eq!(ask(sim, SubsystemId::GENERAL, body), Status::OK);
        })
    },
    Operation {
        ticks: 45,
        in_pieces: true,
        ..operation("Restart", |sim| {
            taken(set(sim, Param::NozzleSpeed, &[3]));
            taken(set(sim, Param::ControlProgram0, &[5; 7]));
            assert!(ask(sim, SubsystemId::ALL, Body::Restart).is_success());
        })
    },
];

fn taken(status: Status) {
    assert_eq!(status, Status::ACCEPTED);
}

fn lockout(sim: &mut Sim, key: u16) {
    assert_eq!(ask(sim, SubsystemId::ALL, Body::Lockout { key }), Status::ACCEPTED);
}

#[derive(Debug, Default)]
struct Count {
    cuts: u64,
    cuts_in_starts: u64,
    new: u64,
}

/// How a word of the start is left, once a word of the operation has been left in one way.
#[derive(Clone, Copy, PartialEq)]
enum Second {
    /// The start is not cut.
    None,
    /// In one way, each time the next.
    InTurn,
    /// In every way.
    Each,
}

impl Second {
    fn ways(self, turn: u64) -> Vec<Torn> {
        match self {
            Self::None => Vec::new(),
            Self::InTurn => vec![Torn::ALL[turn as usize % Torn::ALL.len()]],
            Self::Each => Torn::ALL.to_vec(),
        }
    }
}

/// Cuts an operation everywhere, and then the starts.
fn sweep(base: &Sim, operation: &Operation, second: Second, count: &mut Count) {
    let mut base = base.clone();
    if operation.name == "release" {
        lockout(&mut base, key::ENABLE);
        settle(&mut base);
    }
    let before = Held::by(&mut base, &|| "before".into());
    let steps = base.world().flash.chip().steps();
    (operation.begin)(&mut base);
    let mut whole = base.clone();
    whole.advance_ms(u64::from(operation.ticks) * 10);
    settle(&mut whole);
    let steps = whole.world().flash.chip().steps() - steps;
    assert!(steps > 0, "{}: nothing written", operation.name);
    whole.power_cycle();
    let after = Held::by(&mut whole, &|| "after".into());
    assert_ne!(before, after, "{}", operation.name);
    starts(&mut base);
    for step in 0..steps {
        for torn in Torn::ALL {
            let first = Cut { step, torn };
            let what = || format!("{}, {first:?}", operation.name);
            let (mut sim, seen) = cut(&base, operation, &[first]);
            assert_eq!(seen, 1, "{}", what());
            count.cuts += 1;
            count.new += u64::from(judge(&mut sim, operation, [&before, &after], &what) == after);
            // The start's own words, as many as it writes.
            'start: for step in 0.. {
                let ways = second.ways(count.cuts + step);
                if ways.is_empty() {
                    break;
                }
                for torn in ways {
                    let second = Cut { step, torn };
                    let (mut sim, seen) = cut(&base, operation, &[first, second]);
                    if seen < 2 {
                        break 'start;
                    }
                    count.cuts_in_starts += 1;
                    let what = || format!("{}, {first:?}, {second:?}", operation.name);
                    judge(&mut sim, operation, [&before, &after], &what);
                }
            }
        }
    }
}

/// The monitor after the cuts, and how often it has started.
fn cut(base: &Sim, operation: &Operation, cuts: &[Cut]) -> (Sim, usize) {
    let mut sim = base.clone();
    sim.cut_power_at(cuts);
    let mut seen = 0;
    for _ in 0..operation.ticks {
        sim.tick();
        seen = starts(&mut sim);
        if seen > 0 {
            break;
        }
    }
    sim.cut_power_at(&[]);
    (sim, seen)
}

/// After the cuts: old or new, whole; the same at a later start; and it can be written again.
fn judge(
    sim: &mut Sim,
    operation: &Operation,
    [before, after]: [&Held; 2],
    what: &dyn Fn() -> String,
) -> Held {
    let held = Held::by(sim, what);
    if operation.in_pieces {
        let piece = |old: &dyn Fn(&Held) -> bool| old(before) || old(after);
        let alone = piece(&|one| one.programs == held.programs)
            && piece(&|one| one.numbers == held.numbers)
            && held.corrections == before.corrections
            && held.incomplete == before.incomplete;
        assert!(alone, "{}: {held:?}", what());
    } else {
        assert!(held == *before || held == *after, "{}: {held:?}", what());
    }
    sim.power_cycle();
    assert_eq!(Held::by(sim, what), held, "{}: later", what());
    held
}

/// A monitor whose pages are in use: what is copied when a page is opened is all there can be.
fn full() -> Sim {
    let mut sim = monitor(1);
    let programs = [Param::ControlProgram0, Param::ControlProgram1, Param::ControlProgram7];
    for (value, param) in (1..).zip(programs) {
        set(&mut sim, param, &[value; 7]);
        settle(&mut sim);
    }
    for (value, param) in (1..).zip([Param::ControlTrajectory0, Param::ControlTrajectory7]) {
        set(&mut sim, param, &[value; 60]);
        settle(&mut sim);
    }
    let corrections = [7; 128];
    for first in [0, 128] {
        let body = Body::SetupCorrectionTable { first, corrections: Bytes(&corrections) };
        ask(&mut sim, CONTROL, body);
        settle(&mut sim);
    }
    sim
}

/// After this many more starts and writes the oldest page is another one.
fn aged(mut sim: Sim, starts: i32) -> Sim {
    for start in 0..starts {
        sim.power_cycle();
        sim.advance_ms(300);
        set(&mut sim, Param::NozzleSpeed, &[20 + start]);
        settle(&mut sim);
    }
    sim
}

fn assert_swept(count: &Count, cuts: u64) {
    println!("{count:?}");
    assert!(count.cuts >= cuts && count.new * 100 > count.cuts && count.new < count.cuts);
}

/// Into an open page, and into one that has to be opened first and takes over what lives in the
/// oldest.
#[test]
fn every_word_of_every_operation() {
    let mut count = Count::default();
    for base in [0, 1, 2, 3]
        .map(|starts| aged(full(), starts))
        .into_iter()
        .flat_map(|base| [base.clone(), started(base)])
    {
        for operation in &OPERATIONS {
            sweep(&base, operation, Second::None, &mut count);
        }
    }
    assert_swept(&count, 8_000);
}

/// The next write opens a page.
fn started(mut sim: Sim) -> Sim {
    sim.power_cycle();
    sim.advance_ms(300);
    sim
}

/// `LAFET_MONITOR_DEEP=1` leaves each word of the start in each way.
#[test]
fn every_word_of_every_start_after_it() {
    let mut count = Count::default();
    let deep = std::env::var_os("LAFET_MONITOR_DEEP").is_some();
    let second = if deep { Second::Each } else { Second::InTurn };
    let bases = [full(), aged(full(), 1), aged(monitor(2), 3), monitor(2), started(full())];
    for base in bases {
        for operation in &OPERATIONS {
            sweep(&base, operation, second, &mut count);
        }
    }
    assert_swept(&count, 400);
    assert!(count.cuts_in_starts > if deep { 60_000 } else { 12_000 }, "{count:?}");
}

/// §3.5/6 The set is written in pieces; cut anywhere, it is complete with all of them or not at all.
#[test]
fn a_set_that_becomes_complete() {
    let mut sim = monitor(3);
    ask(&mut sim, SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
    sim.advance_ms(1000);
    assert_eq!(set(&mut sim, Param::ControlProgram2, &[5; 7]), Status::INCOMPLETE_CONFIG);
    set(&mut sim, Param::ControlBallistics, &[1]);
    set(&mut sim, Param::ControlNozzleDiameter, &[300]);
    settle(&mut sim);
    let steps = sim.world().flash.chip().steps();
    let mut whole = sim.clone();
    assert_eq!(set(&mut whole, Param::ControlHeight, &[200]), Status::ACCEPTED);
    settle(&mut whole);
    let (mut complete, mut not) = (0, 0);
    for step in 0..whole.world().flash.chip().steps() - steps {
        for torn in Torn::ALL {
            let mut sim = sim.clone();
            set(&mut sim, Param::ControlHeight, &[200]);
            starts(&mut sim);
            sim.cut_power_at(&[Cut { step, torn }]);
            while starts(&mut sim) == 0 {
                sim.tick();
            }
            let held = Held::by(&mut sim, &|| format!("{step} {torn:?}"));
            if held.incomplete.contains(&CONTROL) {
                not += 1;
            } else {
                complete += 1;
                assert_eq!(held.programs[2], [5; 7], "{step} {torn:?}");
                assert_eq!(sim.device().params().get(Param::ControlNozzleDiameter), 300);
            }
        }
    }
    assert!(complete > 0 && not > 100, "{complete} {not}");
}

/// The power fails in time, not in a word: while the flash is busy and the program is stopped.
#[test]
fn every_millisecond_of_a_page_being_opened() {
    let base = started(full());
    let (mut old, mut new) = (0, 0);
    for seed in 0..20 {
        for ms in 0..8 {
            let mut sim = base.clone();
            sim.advance_ms(seed * 10);
            lockout(&mut sim, key::ENABLE);
            sim.advance_ms(10 * ms);
            sim.power_cycle();
            let what = || format!("{ms} {seed}");
            let held = Held::by(&mut sim, &what);
            assert!(held.incomplete.is_empty());
            *(if is_locked(&mut sim) { &mut new } else { &mut old }) += 1;
        }
    }
    assert!(old > 20 && new > 20, "{old} {new}");
}
