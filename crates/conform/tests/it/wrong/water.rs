//! Valves that do not do what they were commanded to.

use lafet_conform::raw::Rec;
use lafet_proto::flags::{DeployerFlags, ValveFlags as F};
use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, asks, flags, instead, pass, reflag, restate, says, secretly, wrong};

fn open(sim: &mut Sim) {
    secretly(sim, R::OPEN, S::VALVE1, &key::OPEN.to_le_bytes());
}

fn both(answers: &mut [Rec], change: impl Fn(u32) -> u32 + Copy) {
    reflag(answers, S::VALVE1, change);
    reflag(answers, S::VALVE2, change);
}

/// A refusal of this request by this subsystem becomes this status of the addressee.
fn lenient(asked: &[Rec], answers: &mut [Rec], request: R, by: fn(S) -> bool) {
    if asked[0].request == request && by(answers[0].device) && answers[0].status == Status::DENIED {
        answers[0] = says(&asked[0], asked[0].device, Status::ACCEPTED);
    }
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.8",
        "Open takes no key",
        Request(|_, rec| {
            if rec.request == R::OPEN && rec.data.is_empty() {
                rec.data = key::OPEN.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.8/1",
        "Open is Accepted while wrapped",
        Answer(|_, asked, answers| {
            lenient(asked, answers, R::OPEN, |id| id == S::DEPLOYER);
        }),
    ),
    wrong(
        "§3.8/1",
        "Open is remembered while wrapped",
        Frame(|memory, sim, asked| {
            let answers = pass(sim, asked);
            memory.on |= asks(asked, R::OPEN) && answers[0].status == Status::DENIED;
            if memory.on && flags(sim, S::DEPLOYER) & DeployerFlags::DEPLOYED.bits() != 0 {
                memory.on = false;
                open(sim);
            }
            answers
        }),
    ),
    wrong(
        "§3.8/3",
        "Open is Accepted and the valve stays",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::OPEN) && answers[0].status.is_success() {
                secretly(sim, R::STOP, asked[0].device, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.8/3",
        "Open Valve1 opens Valve2 too",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::OPEN)
                && asked[0].device == S::VALVE1
                && answers[0].status.is_success()
            {
                secretly(sim, R::OPEN, S::VALVE2, &asked[0].data);
            }
            answers
        }),
    ),
    wrong(
        "§3.8/3",
        "the valves are exchanged",
        Frame(|_, sim, asked| {
            let other = |id| if id == S::VALVE1 { S::VALVE2 } else { S::VALVE1 };
            if [R::OPEN, R::CLOSE].contains(&asked[0].request) && asked[0].device.is_valve() {
                let mut answers =
                    pass(sim, &[Rec { device: other(asked[0].device), ..asked[0].clone() }]);
                if answers[0].device.is_valve() {
                    answers[0].device = asked[0].device;
                }
                return answers;
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.8/4",
        "Open All opens Valve1",
        Frame(|_, sim, asked| {
            if asks(asked, R::OPEN) && asked[0].device == S::ALL {
                open(sim);
                return vec![says(&asked[0], S::VALVE1, Status::ACCEPTED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.8/4",
        "Open of a drive is NotSupported",
        Answer(|_, _, answers| {
            restate(answers, R::OPEN, Status::WRONG_REQUEST, Status::NOT_SUPPORTED);
        }),
    ),
    wrong(
        "§3.8/6",
        "any key opens",
        Request(|_, rec| {
            if rec.request == R::OPEN && rec.data.len() == 2 {
                rec.data = key::OPEN.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.8/6",
        "the key high byte first opens too",
        Request(|_, rec| {
            if rec.request == R::OPEN && rec.data == key::OPEN.to_be_bytes() {
                rec.data.reverse();
            }
        }),
    ),
    wrong(
        "§3.8/6",
        "a wrong key is InvalidValue",
        Answer(|_, _, answers| {
            restate(answers, R::OPEN, Status::NEED_CONFIRM, Status::INVALID_VALUE);
        }),
    ),
    wrong(
        "§3.3.5",
        "Opening is not reported",
        Answer(|_, _, answers| {
            both(answers, |flags| flags & !F::OPENING.bits());
        }),
    ),
    wrong(
        "§3.3.5",
        "Open is reported while it opens",
        Answer(|_, _, answers| {
            both(answers, |flags| match flags & F::OPENING.bits() {
                0 => flags,
                _ => flags & !F::OPENING.bits() | F::OPEN.bits(),
            });
        }),
    ),
    wrong(
        "§3.3.5",
        "Closed stays while the valve is open",
        Answer(|_, _, answers| {
            both(answers, |flags| flags | F::CLOSED.bits());
        }),
    ),
    wrong(
        "§3.9",
        "Close takes a third byte",
        Request(|_, rec| {
            if rec.request == R::CLOSE {
                rec.data.truncate(2);
            }
        }),
    ),
    wrong(
        "§3.9",
        "Close takes a key of one byte",
        Request(|_, rec| {
            if rec.request == R::CLOSE && rec.data.len() == 1 {
                rec.data = key::CLOSE.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.8/3",
        "an open valve does not close",
        Frame(|_, sim, asked| {
            let open = flags(sim, S::VALVE1) & F::OPEN.bits() != 0;
            instead(
                sim,
                asked,
                |rec| open && rec.request == R::CLOSE && rec.device == S::VALVE1,
                Status::ACCEPTED,
            )
        }),
    ),
    wrong(
        "§3.9/2",
        "Close of a closed valve is Denied",
        Answer(|_, _, answers| {
            restate(answers, R::CLOSE, Status::ACCEPTED, Status::DENIED);
            restate(answers, R::CLOSE, Status::OK, Status::DENIED);
        }),
    ),
    wrong(
        "§3.9/3",
        "Close of General is Ok",
        Answer(|_, _, answers| {
            restate(answers, R::CLOSE, Status::WRONG_REQUEST, Status::OK);
        }),
    ),
    wrong(
        "§3.9/5",
        "any key closes",
        Request(|_, rec| {
            if rec.request == R::CLOSE && rec.data.len() == 2 {
                rec.data = key::CLOSE.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.9/5",
        "the key of Open closes an open valve",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::CLOSE) && answers[0].status == Status::NEED_CONFIRM {
                secretly(sim, R::CLOSE, asked[0].device, &key::CLOSE.to_le_bytes());
            }
            answers
        }),
    ),
    wrong(
        "§3.2/5",
        "Stop to a valve is Ok and it opens on",
        Frame(|_, sim, asked| {
            instead(sim, asked, |rec| rec.request == R::STOP && rec.device.is_valve(), Status::OK)
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All leaves the valve opening",
        Frame(|_, sim, asked| {
            let opening = flags(sim, S::VALVE1) & F::OPENING.bits() != 0;
            let answers = pass(sim, asked);
            if opening && asked[0].request == R::STOP && asked[0].device == S::ALL {
                open(sim);
            }
            answers
        }),
    ),
    wrong(
        "§1/6",
        "Stop Motors stops the valves",
        Frame(|_, sim, asked| {
            if asked[0].request == R::STOP && asked[0].device == S::MOTORS {
                secretly(sim, R::STOP, S::VALVE1, &[]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.11/6",
        "Wrap is Accepted with an open valve",
        Answer(|_, asked, answers| {
            lenient(asked, answers, R::WRAP, S::is_valve);
        }),
    ),
    wrong(
        "§3.11/6",
        "Wrap with an open valve is Denied from Deployer",
        Answer(|_, asked, answers| {
            if asked[0].request == R::WRAP && answers[0].device.is_valve() {
                answers[0].device = S::DEPLOYER;
            }
        }),
    ),
    wrong(
        "§3.16/8",
        "a search is Accepted with an open valve",
        Answer(|_, asked, answers| {
            lenient(asked, answers, R::START_SEEK, S::is_valve);
        }),
    ),
    wrong(
        "§3.1/9",
        "Move Deployer is Accepted with an open valve",
        Answer(|_, asked, answers| {
            lenient(asked, answers, R::MOVE, S::is_valve);
        }),
    ),
    wrong(
        "§3.14/7",
        "a program opens the valve",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::START_QUENCH) && answers[0].status.is_success() {
                open(sim);
            }
            answers
        }),
    ),
    wrong(
        "§3.14/7",
        "the end of a program closes the valve",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asked[0].request == R::STOP && asked[0].device == S::CONTROL {
                secretly(sim, R::CLOSE, S::VALVE1, &key::CLOSE.to_le_bytes());
            }
            answers
        }),
    ),
    wrong(
        "§D/2",
        "a reset opens the valve again",
        Frame(|memory, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::RESTART) && asked[0].device == S::ALL {
                (memory.on, memory.resets) = (true, sim.resets());
            }
            if memory.on
                && sim.resets() > memory.resets
                && flags(sim, S::VALVE1) & F::CLOSED.bits() != 0
            {
                memory.on = false;
                open(sim);
            }
            answers
        }),
    ),
];
