//! Lockouts that do not lock, restarts that do not restart.

use lafet_conform::raw::Rec;
use lafet_proto::flags::{CommonFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{Memory, Wrong, asks, flags, instead, pass, reflag, restate, says, secretly, wrong};

fn locked(sim: &mut Sim) -> bool {
    flags(sim, S::GENERAL) & GeneralFlags::LOCKED_OUT.bits() != 0
}

fn is_on(asked: &[Rec]) -> bool {
    asks(asked, R::LOCKOUT)
        && asked[0].device == S::ALL
        && asked[0].data == key::ENABLE.to_le_bytes()
}

fn is_off(asked: &[Rec]) -> bool {
    asks(asked, R::LOCKOUT)
        && asked[0].device == S::ALL
        && asked[0].data == key::DISABLE.to_le_bytes()
}

/// All subsystems answer Ok, nothing is executed.
fn chain_says_ok(sim: &mut Sim, to: &Rec) -> Vec<Rec> {
    let chain = secretly(sim, R::GET_STATUS, S::ALL, &[]);
    chain.iter().map(|rec| says(to, rec.device, Status::OK)).collect()
}

/// Under lockout this request gets this answer.
fn locked_says(sim: &mut Sim, asked: &[Rec], request: R, from: S, status: Status) -> Vec<Rec> {
    if locked(sim) && asks(asked, request) {
        return vec![says(&asked[0], from, status)];
    }
    pass(sim, asked)
}

/// The lockout is reported, but not in force.
fn for_show(memory: &mut Memory, sim: &mut Sim, asked: &[Rec]) -> Vec<Rec> {
    if is_on(asked) || is_off(asked) {
        memory.on = is_on(asked);
        return chain_says_ok(sim, &asked[0]);
    }
    let mut answers = pass(sim, asked);
    if memory.on {
        reflag(&mut answers, S::GENERAL, |flags| flags | GeneralFlags::LOCKED_OUT.bits());
    }
    answers
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.18",
        "Lockout takes a third byte",
        Request(|_, rec| {
            if rec.request == R::LOCKOUT {
                rec.data.truncate(2);
            }
        }),
    ),
    wrong(
        "§3.18",
        "Lockout may be sent to General",
        Request(|_, rec| {
            if rec.request == R::LOCKOUT {
                rec.device = S::ALL;
            }
        }),
    ),
    wrong(
        "§3.18/1",
        "Lockout is answered by General alone",
        Answer(|_, asked, answers| {
            if asks(asked, R::LOCKOUT) {
                answers.retain(|rec| rec.device == S::GENERAL);
            }
        }),
    ),
    wrong("§3.18/1", "Lockout stops nothing", Frame(for_show)),
    wrong(
        "§3.18/1",
        "Lockout leaves the valve open",
        Frame(|memory, sim, asked| {
            let open = flags(sim, S::VALVE1) & ValveFlags::OPEN.bits() != 0;
            if is_on(asked) && open || memory.on {
                return for_show(memory, sim, asked);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.18/1",
        "LockedOut is not reported",
        Answer(|_, _, answers| {
            reflag(answers, S::GENERAL, |flags| flags & !GeneralFlags::LOCKED_OUT.bits());
        }),
    ),
    wrong("§3.18/2", "locked out in name only", Frame(for_show)),
    wrong(
        "§3.18/2",
        "locked out, Stop All is Ok",
        Frame(|_, sim, asked| locked_says(sim, asked, R::STOP, S::DEPLOYER, Status::OK)),
    ),
    wrong(
        "§3.18/2",
        "locked out, the addressee refuses",
        Answer(|_, asked, answers| {
            if asked[0].device != S::ALL && answers[0].status == Status::DENIED {
                answers[0].device = asked[0].device;
            }
        }),
    ),
    wrong(
        "§3.18/2",
        "locked out, Move is Busy",
        Frame(|_, sim, asked| locked_says(sim, asked, R::MOVE, S::GENERAL, Status::BUSY)),
    ),
    wrong(
        "§3.18/2",
        "locked out, Wrap is Accepted",
        Frame(|_, sim, asked| locked_says(sim, asked, R::WRAP, S::DEPLOYER, Status::ACCEPTED)),
    ),
    wrong(
        "§3.18/2",
        "locked out, Restart is Ok",
        Frame(|_, sim, asked| locked_says(sim, asked, R::RESTART, S::GENERAL, Status::OK)),
    ),
    wrong(
        "§1/11",
        "locked out, an unknown request is WrongRequest",
        Frame(|_, sim, asked| locked_says(sim, asked, R(0), S::GENERAL, Status::WRONG_REQUEST)),
    ),
    wrong(
        "§3.18/3",
        "locked out, SetParam is Denied",
        Frame(|_, sim, asked| locked_says(sim, asked, R::SET_PARAM, S::GENERAL, Status::DENIED)),
    ),
    wrong(
        "§3.18/3",
        "locked out, GetParam is Denied",
        Frame(|_, sim, asked| locked_says(sim, asked, R::GET_PARAM, S::GENERAL, Status::DENIED)),
    ),
    wrong(
        "§3.3/2",
        "locked out, GetHotbed is Denied",
        Frame(|_, sim, asked| locked_says(sim, asked, R::GET_HOTBED, S::GENERAL, Status::DENIED)),
    ),
    wrong(
        "§3.18/4",
        "the release lets a motion go on",
        Frame(|memory, sim, asked| {
            if asks(asked, R::MOVE) && !locked(sim) {
                memory.kept = Some(asked[0].clone());
            }
            let answers = pass(sim, asked);
            if is_off(asked) {
                pass(sim, memory.kept.as_slice());
            }
            answers
        }),
    ),
    wrong(
        "§3.18/4",
        "the release is Ok and it stays locked out",
        Frame(|memory, sim, asked| {
            let moving = flags(sim, S::HORIZONTAL) & DriveFlags::MOVE.bits() != 0;
            if is_off(asked) && memory.at_ms < 3 {
                memory.at_ms += 1;
                return chain_says_ok(sim, &asked[0]);
            }
            let _ = moving;
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.18/4",
        "the release is answered by General alone",
        Answer(|_, asked, answers| {
            if is_off(asked) {
                answers.retain(|rec| rec.device == S::GENERAL);
            }
        }),
    ),
    wrong(
        "§3.18/5",
        "any key locks",
        Request(|_, rec| {
            if rec.request == R::LOCKOUT
                && rec.data.len() == 2
                && rec.data != key::DISABLE.to_le_bytes()
            {
                rec.data = key::ENABLE.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.18/5",
        "a wrong key is NeedConfirm",
        Answer(|_, _, answers| {
            restate(answers, R::LOCKOUT, Status::INVALID_VALUE, Status::NEED_CONFIRM);
        }),
    ),
    wrong(
        "§3.18/8",
        "General is Ok before the lockout is stored",
        Answer(|_, _, answers| {
            restate(answers, R::LOCKOUT, Status::ACCEPTED, Status::OK);
        }),
    ),
    wrong(
        "§3.18/8",
        "General stays Accepted",
        Answer(|_, asked, answers| {
            if asks(asked, R::LOCKOUT)
                && let Some(last) = answers.last_mut()
                && last.status == Status::OK
            {
                last.status = Status::ACCEPTED;
            }
        }),
    ),
    wrong(
        "§3.12",
        "Restart takes data",
        Request(|_, rec| {
            if rec.request == R::RESTART {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§3.12/1",
        "Restart is answered by General alone",
        Answer(|_, asked, answers| {
            if asks(asked, R::RESTART) && answers.len() > 1 {
                answers.retain(|rec| rec.device == S::GENERAL);
            }
        }),
    ),
    wrong(
        "§3.12/2",
        "Restart is Ok and it does not restart",
        Frame(|_, sim, asked| {
            if asks(asked, R::RESTART) && asked[0].device == S::ALL && asked[0].data.is_empty() {
                return chain_says_ok(sim, &asked[0]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.12/2",
        "Restarting is not reported",
        Answer(|_, _, answers| {
            reflag(answers, S::GENERAL, |flags| flags & !CommonFlags::RESTARTING.bits());
        }),
    ),
    wrong(
        "§3.12/2",
        "restarting, Move is Accepted",
        Answer(|_, asked, answers| {
            if asks(asked, R::MOVE) && answers[0].status == Status::BUSY {
                answers[0] = says(&asked[0], asked[0].device, Status::ACCEPTED);
            }
        }),
    ),
    wrong(
        "§3.12/3",
        "General restarts alone",
        Frame(|_, sim, asked| {
            instead(
                sim,
                asked,
                |rec| rec.request == R::RESTART && rec.device == S::GENERAL,
                Status::OK,
            )
        }),
    ),
    wrong(
        "§3.12/3",
        "a drive answers Restart with NotSupported",
        Answer(|_, _, answers| {
            restate(answers, R::RESTART, Status::WRONG_REQUEST, Status::NOT_SUPPORTED);
        }),
    ),
    wrong(
        "§3.12/4",
        "a restart loses what was accepted",
        Frame(|memory, sim, asked| {
            let rec = &asked[0];
            let max = ParamId::of("MainVoltageMax").0.to_le_bytes();
            if rec.request == R::SET_PARAM && rec.data.starts_with(&max) {
                memory.kept = secretly(sim, R::GET_PARAM, S::GENERAL, &max).pop();
            }
            if asks(asked, R::RESTART)
                && let Some(old) = memory.kept.take()
            {
                secretly(sim, R::SET_PARAM, S::GENERAL, &old.data);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§D/1",
        "a motion continues after a reset",
        Frame(|memory, sim, asked| {
            if asks(asked, R::MOVE) {
                memory.kept = Some(asked[0].clone());
            }
            if asks(asked, R::RESTART) {
                (memory.on, memory.resets) = (true, sim.resets());
            }
            let answers = pass(sim, asked);
            if memory.on && sim.resets() > memory.resets {
                memory.on = false;
                pass(sim, memory.kept.as_slice());
            }
            answers
        }),
    ),
];
