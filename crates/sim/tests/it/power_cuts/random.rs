//! Random requests and random power cuts, up to three in a row: `LAFET_MONITOR_CUTS` of them,
//! `LAFET_MONITOR_SEED` is the first seed and replays a failure. `cargo xtask cuts` runs any number.

use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};
use lafet_sim::flash::{Cut, Torn};
use lafet_sim::rng::Rng;
use lafet_sim::sim::Sim;

use super::held::{ask, is_locked, monitor, set, settle, starts};

/// Power cuts in the life of one monitor.
const CUTS_OF_A_LIFE: u64 = 200;

const NUMBERS: [Param; 6] = [
    Param::VerticalSpeed,
    Param::VerticalMaxLimit,
    Param::HorizontalSpeed,
    Param::ControlHeight,
    Param::RadioTimeout,
    Param::DetectorThreshold,
];
const PROGRAMS: [Param; 2] = [Param::ControlProgram0, Param::ControlProgram7];

/// A value as a client knows it: what the monitor has said to be stored, and what it has been asked
/// to store since.
#[derive(Clone, Debug)]
struct Known {
    stored: i32,
    since: Vec<i32>,
}

impl Known {
    fn asked(&mut self, value: i32, status: Status) {
        match status {
            Status::OK => (self.stored, self.since) = (value, Vec::new()),
            Status::ACCEPTED => self.since.push(value),
            other => panic!("{other}"),
        }
    }

    /// What is found after a start is what counts from then on.
    fn found(&mut self, value: i32, what: &dyn Fn() -> String) -> bool {
        let is_new = self.since.contains(&value);
        assert!(is_new || value == self.stored, "{}: {value}, not {self:?}", what());
        (self.stored, self.since) = (value, Vec::new());
        is_new
    }
}

#[derive(Debug, Default)]
struct Count {
    cuts: u64,
    confirmed: u64,
    taken_over: u64,
}

struct Life {
    sim: Sim,
    rng: Rng,
    known: Vec<Known>,
    locked: Known,
    count: Count,
}

fn value(sim: &Sim, index: usize) -> i32 {
    match NUMBERS.get(index) {
        Some(param) => sim.device().params().get(*param),
        None => {
            let number = if index == NUMBERS.len() { 0 } else { 7 };
            let program = sim.device().params().program(number).unwrap();
            assert!(program.iter().all(|value| *value == program[0]), "torn: {program:?}");
            program[0].into()
        }
    }
}

impl Life {
    fn new(seed: u64) -> Self {
        let sim = monitor(seed);
        let known = (0..NUMBERS.len() + PROGRAMS.len())
            .map(|index| Known { stored: value(&sim, index), since: Vec::new() })
            .collect();
        let locked = Known { stored: 0, since: Vec::new() };
        Self { sim, rng: Rng::new(seed), known, locked, count: Count::default() }
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.rng.bits() % limit
    }

    fn request(&mut self) {
        if self.below(6) == 0 {
            let on = self.below(2) as i32;
            let key = if on == 1 { key::ENABLE } else { key::DISABLE };
            let status = ask(&mut self.sim, SubsystemId::ALL, Body::Lockout { key });
            self.count.confirmed += u64::from(status == Status::OK);
            return self.locked.asked(on, status);
        }
        let index = self.below(self.known.len() as u64) as usize;
        // Often what it was asked before: then the answer says whether it is stored.
        let again = self.known[index].since.last().copied().filter(|_| self.below(3) > 0);
        let new = 10 + self.below(90) as i32;
        let (param, values): (Param, &[i32]) = match NUMBERS.get(index) {
            Some(param) if *param == Param::RadioTimeout => {
                (*param, &[again.unwrap_or(1000 + new)])
            }
            Some(param) => (*param, &[again.unwrap_or(new)]),
            None => (PROGRAMS[index - NUMBERS.len()], &[again.unwrap_or(new); 7]),
        };
        let status = set(&mut self.sim, param, values);
        self.count.confirmed += u64::from(status == Status::OK);
        self.known[index].asked(values[0], status);
    }

    fn cut(&mut self) {
        let cuts: Vec<Cut> = (0..=self.below(3))
            .map(|index| Cut {
                step: self.below(if index == 0 { 60 } else { 160 }),
                torn: Torn::ALL[self.below(5) as usize],
            })
            .collect();
        self.sim.cut_power_at(&cuts);
    }

    /// A few requests and steps; then what a start has found, if there was one.
    fn round(&mut self, what: &dyn Fn() -> String) {
        if self.below(2) == 0 {
            self.cut();
        }
        starts(&mut self.sim);
        let mut started = 0;
        for _ in 0..1 + self.below(4) {
            self.request();
            for _ in 0..self.below(4) {
                self.sim.tick();
            }
            started = starts(&mut self.sim);
            if started > 0 {
                break;
            }
        }
        if started == 0 && self.below(8) == 0 {
            // In time, not in a word: perhaps while the flash is busy.
            self.sim.power_cycle();
            started = starts(&mut self.sim);
        }
        if started == 0 {
            return;
        }
        self.sim.cut_power_at(&[]);
        self.count.cuts += started as u64;
        for id in SubsystemId::TABLE {
            let params = self.sim.device().params();
            assert!(!params.has_read_fault(id) && !params.is_incomplete(id), "{}: {id}", what());
        }
        let mut new = 0;
        for index in 0..self.known.len() {
            let found = value(&self.sim, index);
            new += u64::from(self.known[index].found(found, what));
        }
        let locked = i32::from(is_locked(&mut self.sim));
        new += u64::from(self.locked.found(locked, &|| format!("{}: lockout", what())));
        self.count.taken_over += new;
        if self.below(16) == 0 {
            self.sim.advance_ms(200);
            settle(&mut self.sim);
        }
    }
}

fn life(seed: u64) -> Count {
    let mut life = Life::new(seed);
    while life.count.cuts < CUTS_OF_A_LIFE {
        let cuts = life.count.cuts;
        life.round(&|| format!("seed {seed}, after {cuts} cuts"));
    }
    life.count
}

#[test]
fn random_cuts() {
    let number = |name, default: u64| {
        std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let wanted = number("LAFET_MONITOR_CUTS", 50_000);
    let first = number("LAFET_MONITOR_SEED", 1);
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let run = |thread: u64| {
        let mut count = Count::default();
        let mut seed = first + thread;
        while count.cuts < wanted.div_ceil(threads) {
            let Count { cuts, confirmed, taken_over } = life(seed);
            count.cuts += cuts;
            count.confirmed += confirmed;
            count.taken_over += taken_over;
            seed += threads;
        }
        count
    };
    let mut count = Count::default();
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..threads).map(|thread| scope.spawn(move || run(thread))).collect();
        for thread in runs {
            let Count { cuts, confirmed, taken_over } = thread.join().unwrap();
            count.cuts += cuts;
            count.confirmed += confirmed;
            count.taken_over += taken_over;
        }
    });
    println!("{count:?}");
    // Things were stored, said to be stored, and taken over by cuts that came late enough.
    assert!(count.cuts >= wanted && count.confirmed * 4 > count.cuts, "{count:?}");
    assert!(count.taken_over * 20 > count.cuts, "{count:?}");
}
