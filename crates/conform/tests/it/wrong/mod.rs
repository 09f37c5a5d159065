//! Wrong monitors: the correct one with one rule broken each.

mod fold;
mod link;
mod motion;
mod params;
mod programs;
mod reads;
mod records;
mod seeks;
mod service;
mod update;
mod water;

use lafet_conform::raw::{self, Rec};
use lafet_device::Source;
use lafet_device::port::Port;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use crate::support::{Between, Frames, ask};
pub use link::Loose;

/// State of a wrong monitor.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    /// A latch.
    pub on: bool,
    /// A time, ms.
    pub at_ms: u64,
    /// A request kept for later.
    pub kept: Option<Rec>,
    /// Number of resets at that time.
    pub resets: u32,
}

/// How a rule is broken.
#[derive(Clone, Copy)]
pub enum Rule {
    /// In the link.
    Link(Loose),
    /// A request is changed before the monitor receives it.
    Request(fn(&mut Memory, &mut Rec)),
    /// The answers are changed.
    Answer(fn(&mut Memory, &[Rec], &mut Vec<Rec>)),
    /// The whole frame is handled differently.
    Frame(fn(&mut Memory, &mut Sim, &[Rec]) -> Vec<Rec>),
    /// The bytes are changed before the monitor's own port receives them.
    Port(fn(&[u8]) -> Vec<u8>),
    /// The payload is handled differently.
    Raw(fn(&mut Memory, &mut Sim, &[u8]) -> Vec<u8>),
}

/// A wrong monitor.
#[derive(Clone, Copy)]
pub struct Wrong {
    /// What it does wrong.
    pub name: &'static str,
    /// Item that it violates.
    pub item: &'static str,
    /// Profile of the monitor.
    pub profile: &'static str,
    pub rule: Rule,
}

/// A wrong monitor of the profile `full`.
pub const fn wrong(item: &'static str, name: &'static str, rule: Rule) -> Wrong {
    Wrong { name, item, profile: "full", rule }
}

/// A wrong monitor of another profile.
pub const fn in_profile(profile: &'static str, wrong: Wrong) -> Wrong {
    Wrong { profile, ..wrong }
}

/// All wrong monitors.
pub fn all() -> Vec<Wrong> {
    [
        link::WRONG,
        records::WRONG,
        reads::WRONG,
        motion::WRONG,
        fold::WRONG,
        water::WRONG,
        params::WRONG,
        programs::WRONG,
        seeks::WRONG,
        service::WRONG,
        update::WRONG,
    ]
    .concat()
}

/// Passes records to the monitor; returns its answers.
pub fn pass(sim: &mut Sim, asked: &[Rec]) -> Vec<Rec> {
    let payload: Vec<u8> = asked.iter().flat_map(Rec::bytes).collect();
    Rec::all(&ask(sim, &payload)).unwrap_or_default()
}

/// Sends the monitor a request that the tester does not see.
pub fn secretly(sim: &mut Sim, request: R, to: S, data: &[u8]) -> Vec<Rec> {
    pass(sim, &[Rec::new(request, to, data)])
}

/// Answers the wanted request like this without executing it; executes the others.
pub fn instead(
    sim: &mut Sim,
    asked: &[Rec],
    wanted: impl Fn(&Rec) -> bool,
    status: Status,
) -> Vec<Rec> {
    match asked {
        [rec] if wanted(rec) => vec![says(rec, rec.device, status)],
        _ => pass(sim, asked),
    }
}

/// Position of a drive.
pub fn position(sim: &mut Sim, of: S) -> i32 {
    let answers = secretly(sim, R::GET_STATUS, of, &[]);
    answers.first().and_then(|rec| rec.i16_at(4)).unwrap_or(0).into()
}

/// Limits of a drive.
pub fn limits(sim: &mut Sim, of: S) -> (i32, i32) {
    let answers = secretly(sim, R::RETRIEVE_LIMITS, of, &[]);
    let at = |at| answers.first().and_then(|rec| rec.i32_at(at)).unwrap_or(0);
    (at(0), at(4))
}

/// Destination of a Move.
pub fn destination(rec: &Rec) -> Option<i16> {
    rec.i16_at(0).filter(|_| rec.request == R::MOVE && rec.data.len() == 2)
}

/// Flags of a subsystem.
pub fn flags(sim: &mut Sim, of: S) -> u32 {
    secretly(sim, R::GET_STATUS, of, &[]).first().and_then(Rec::flags).unwrap_or(0)
}

/// An answer with this status.
pub fn says(to: &Rec, from: S, status: Status) -> Rec {
    Rec { request: to.request, device: from, status, data: Vec::new() }
}

/// Whether the frame contains this request.
pub fn asks(asked: &[Rec], request: R) -> bool {
    asked.iter().any(|rec| rec.request == request)
}

/// Changes every answer to a request.
pub fn each(answers: &mut [Rec], request: R, mut change: impl FnMut(&mut Rec)) {
    answers.iter_mut().filter(|rec| rec.request == request).for_each(&mut change);
}

/// Changes the status of answers.
pub fn restate(answers: &mut [Rec], request: R, from: Status, to: Status) {
    each(answers, request, |rec| {
        if rec.status == from {
            rec.status = to;
        }
    });
}

/// Changes the flags that a subsystem reports.
pub fn reflag(answers: &mut [Rec], of: S, change: impl Fn(u32) -> u32) {
    each(answers, R::GET_STATUS, |rec| {
        if rec.device == of
            && let Some(flags) = rec.flags()
        {
            rec.data[..4].copy_from_slice(&change(flags).to_le_bytes());
        }
    });
}

/// The line to a wrong monitor.
pub struct Breaking {
    rule: Rule,
    memory: Memory,
    frames: Frames,
    link: link::Receiver,
    port: Port,
    own: bool,
}

impl Breaking {
    pub fn new(rule: Rule) -> Self {
        Self {
            rule,
            memory: Memory::default(),
            frames: Frames::default(),
            link: link::Receiver::default(),
            port: Port::new(Source::ExternalConn),
            own: matches!(rule, Rule::Link(_)),
        }
    }

    fn handle(&mut self, sim: &mut Sim, payload: &[u8]) -> Vec<u8> {
        if let Rule::Raw(raw) = self.rule {
            return raw(&mut self.memory, sim, payload);
        }
        let Some(mut asked) = Rec::all(payload).filter(|asked| !asked.is_empty()) else {
            return ask(sim, payload);
        };
        if let Rule::Frame(frame) = self.rule {
            return frame(&mut self.memory, sim, &asked).iter().flat_map(Rec::bytes).collect();
        }
        // The status of a request is passed on as received.
        let mut bytes = payload.to_vec();
        if let Rule::Request(change) = self.rule {
            asked.iter_mut().for_each(|rec| change(&mut self.memory, rec));
            bytes = asked.iter().flat_map(Rec::bytes).collect();
        }
        let bytes = ask(sim, &bytes);
        let Rule::Answer(change) = self.rule else { return bytes };
        let mut answers = Rec::all(&bytes).unwrap_or_default();
        change(&mut self.memory, &asked, &mut answers);
        answers.iter().flat_map(Rec::bytes).collect()
    }
}

impl Between for Breaking {
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        if let Rule::Link(loose) = self.rule {
            return self.link.receive(loose, sim, bytes);
        }
        if let Rule::Port(change) = self.rule {
            return sim.receive(&mut self.port, &change(bytes));
        }
        let mut out = Vec::new();
        for (src, payload) in self.frames.take(sim, bytes) {
            let answer = self.handle(sim, &payload);
            out.extend(raw::frame(src, sim.address(), &answer));
        }
        out
    }

    fn tick(&mut self, sim: &mut Sim) -> Vec<u8> {
        if self.own { self.link.tick(sim) } else { Vec::new() }
    }
}
