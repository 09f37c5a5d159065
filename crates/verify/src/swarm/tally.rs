//! What was seen in the swarm: beside what must never happen, what must have happened. A monitor
//! that does nothing breaks no rule.

use lafet_device::Composition;
use lafet_device::cause::{Cause, Program, Rule};
use lafet_proto::dictionary::{self, Origin, REQUESTS};
use lafet_proto::{RequestId, SubsystemId};
use lafet_sim::event::What;
use lafet_sim::fault::Fault;

use crate::attribution::{Output, program_name, rule_name};

/// Counts over one or many seeds.
#[derive(Clone, Debug)]
pub struct Tally {
    /// Seeds.
    pub seeds: u64,
    /// Virtual time, ms.
    pub virtual_ms: u64,
    /// Steps of the monitor's program.
    pub steps: u64,
    /// Frames that were delivered and answered.
    pub frames: u64,
    /// Requests in them.
    pub requests: u64,
    /// Changes of outputs, each of which was explained.
    pub changes: u64,
    /// Changes that were not.
    pub unexplained: u64,
    /// Invariants that did not hold.
    pub violations: u64,
    /// Resets by requests.
    pub resets: u64,
    counts: Vec<Count>,
}

#[derive(Clone, Debug)]
struct Count {
    name: String,
    count: u64,
}

/// What happens in the world, and what is done to the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Seen {
    Deployed,
    WrappedAgain,
    Jet,
    FireHit,
    FireOut,
    LockedOut,
    PowerCut,
    Crash,
    Reset,
    ClockWrap,
    NoRoom,
    Flood,
    Garbage,
    SeveralFaults,
    Homed,
}

const SEEN: [&str; 15] = [
    "deployed",
    "wrapped again",
    "water at the nozzle",
    "fire hit",
    "fire out",
    "locked out",
    "power cut",
    "crash",
    "reset",
    "clock wrapped",
    "answers without room",
    "flood of frames",
    "garbage before a frame",
    "several faults at once",
    "homed at an end switch",
];

impl Tally {
    pub(super) fn new() -> Self {
        let mut names: Vec<String> = SEEN.iter().map(|name| (*name).to_owned()).collect();
        names.extend(
            REQUESTS.iter().filter(|i| !is_of_bus(i.id)).map(|i| format!("accepted {}", i.name)),
        );
        names.extend(Rule::ALL.iter().map(|rule| format!("rule {}", rule_name(*rule))));
        names.extend(Program::ALL.iter().map(|p| format!("program {}", program_name(*p))));
        names.extend(BUTTON_NAMES.iter().map(|name| (*name).to_owned()));
        names.extend(Composition::ALL.iter().map(|profile| format!("profile {}", profile.name)));
        names.extend(Output::all().map(|output| format!("output {}", output.name())));
        names.extend(Fault::all().map(|fault| format!("fault {}", fault.name())));
        let counts = names.into_iter().map(|name| Count { name, count: 0 }).collect();
        Self {
            seeds: 1,
            virtual_ms: 0,
            steps: 0,
            frames: 0,
            requests: 0,
            changes: 0,
            unexplained: 0,
            violations: 0,
            resets: 0,
            counts,
        }
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Self) {
        self.seeds += other.seeds;
        self.virtual_ms += other.virtual_ms;
        self.steps += other.steps;
        self.frames += other.frames;
        self.requests += other.requests;
        self.changes += other.changes;
        self.unexplained += other.unexplained;
        self.violations += other.violations;
        self.resets += other.resets;
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            count.count += more.count;
        }
    }

    /// Names and counts of what is to be witnessed.
    pub fn witnessed(&self) -> impl Iterator<Item = (&str, u64)> {
        self.counts.iter().map(|c| (c.name.as_str(), c.count))
    }

    /// What has never been seen.
    pub fn missing(&self) -> Vec<&str> {
        self.witnessed().filter(|(_, count)| *count == 0).map(|(name, _)| name).collect()
    }

    pub(super) fn see(&mut self, what: Seen) {
        self.counts[what as usize].count += 1;
    }

    pub(super) fn accept(&mut self, request: RequestId) {
        if let Some(info) = dictionary::request(request) {
            self.count(&format!("accepted {}", info.name));
        }
    }

    pub(super) fn profile(&mut self, name: &str) {
        self.count(&format!("profile {name}"));
    }

    pub(super) fn fault(&mut self, fault: Fault) {
        self.count(&format!("fault {}", fault.name()));
    }

    pub(super) fn event(&mut self, what: What) {
        match what {
            What::JetOn => self.see(Seen::Jet),
            What::FireHit(_) => self.see(Seen::FireHit),
            What::FireOut(_) => self.see(Seen::FireOut),
            _ => {}
        }
    }

    pub(super) fn output(&mut self, output: Output, cause: Cause, value: i16) {
        match cause {
            Cause::Rule(rule) => self.count(&format!("rule {}", rule_name(rule))),
            Cause::Program(program, _) => {
                self.count(&format!("program {}", program_name(program)));
            }
            Cause::Button(post) => {
                let own = usize::from(post == SubsystemId::EXT_BUTTONS);
                let valve = matches!(output, Output::Valve(_));
                let closes = valve && value < 0;
                let index = 3 * own + usize::from(valve) + usize::from(closes);
                self.count(BUTTON_NAMES[index]);
            }
            Cause::Request(_) => {}
        }
        self.count(&format!("output {}", output.name()));
    }

    fn count(&mut self, name: &str) {
        if let Some(count) = self.counts.iter_mut().find(|count| count.name == name) {
            count.count += 1;
        }
    }
}

const BUTTON_NAMES: [&str; 6] = [
    "Buttons moves a drive",
    "Buttons opens",
    "Buttons closes",
    "ExtButtons moves a drive",
    "ExtButtons opens",
    "ExtButtons closes",
];

fn is_of_bus(request: RequestId) -> bool {
    dictionary::request(request).is_some_and(|info| info.origin == Origin::Observed)
}
