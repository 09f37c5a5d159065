//! Updates that take what they must refuse, and reports that are wrong.

use lafet_conform::raw::Rec;
use lafet_proto::flags::{CommonFlags, DeployerFlags, GeneralFlags};
use lafet_proto::update::KEY;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{
    Memory, Rule, Wrong, asks, each, flags, in_profile, pass, reflag, restate, says, wrong,
};
use crate::support::UPDATED;

/// Where a report has the phase, the slot and the reason.
const PHASE: usize = 0;
const SLOT: usize = 1;
const REASON: usize = 3;
const REPORT: usize = 24;

/// A wrong monitor whose software can be updated.
const fn updated(item: &'static str, name: &'static str, rule: Rule) -> Wrong {
    in_profile(UPDATED, wrong(item, name, rule))
}

/// The number of the order.
fn order(asked: &[Rec]) -> Option<u8> {
    let mut updates = asked.iter().filter(|rec| rec.request == R::UPDATE);
    updates.next()?.data.first().copied()
}

fn locked(sim: &mut Sim) -> bool {
    flags(sim, S::GENERAL) & GeneralFlags::LOCKED_OUT.bits() != 0
}

fn deployed(sim: &mut Sim) -> bool {
    flags(sim, S::DEPLOYER) & DeployerFlags::DEPLOYED.bits() != 0
}

/// Changes every report.
fn reports(answers: &mut [Rec], change: impl Fn(&mut [u8])) {
    each(answers, R::UPDATE, |rec| {
        if rec.data.len() == REPORT {
            change(&mut rec.data);
        }
    });
}

/// Changes the values of one of its parameters.
fn of_software(name: &str, answers: &mut [Rec], change: impl Fn(&mut [u8])) {
    let id = ParamId::of(name).0.to_le_bytes();
    each(answers, R::GET_PARAM, |rec| {
        if rec.status == Status::OK && rec.data.starts_with(&id) {
            change(&mut rec.data[2..]);
        }
    });
}

/// The report is changed from the first order of this number on that is accepted.
fn since(
    memory: &mut Memory,
    asked: &[Rec],
    answers: &mut [Rec],
    kind: u8,
    change: impl Fn(&mut [u8]),
) {
    let accepted = answers.iter().any(|rec| rec.status == Status::ACCEPTED);
    memory.on |= order(asked) == Some(kind) && accepted;
    if memory.on {
        reports(answers, change);
    }
}

/// The answers to an order of this number.
fn of_order(asked: &[Rec], answers: &mut [Rec], kind: u8, from: Status, to: Status) {
    if order(asked) == Some(kind) {
        restate(answers, R::UPDATE, from, to);
    }
}

/// Without their reports.
fn bare(answers: &mut [Rec], status: Status) {
    each(answers, R::UPDATE, |rec| {
        if rec.status == status {
            rec.data.clear();
        }
    });
}

pub const WRONG: &[Wrong] = &[
    updated(
        "§U",
        "a report has 23 bytes",
        Answer(|_, _, answers| {
            each(answers, R::UPDATE, |rec| rec.data.truncate(REPORT - 1));
        }),
    ),
    updated(
        "§U",
        "a report names no slot",
        Answer(|_, _, answers| reports(answers, |report| report[SLOT] = 0)),
    ),
    updated(
        "§U",
        "more was received than there is",
        Answer(|_, _, answers| reports(answers, |report| report[4] = 8)),
    ),
    updated(
        "§U/1",
        "deployed, a report is missing",
        Frame(|_, sim, asked| {
            let deployed = deployed(sim);
            let mut answers = pass(sim, asked);
            if deployed {
                bare(&mut answers, Status::OK);
            }
            answers
        }),
    ),
    updated(
        "§U/1",
        "locked out, the state is Denied",
        Frame(|_, sim, asked| match locked(sim) && order(asked) == Some(0) {
            true => vec![says(&asked[0], S::GENERAL, Status::DENIED)],
            false => pass(sim, asked),
        }),
    ),
    updated(
        "§U/1",
        "restarting, the state is Busy",
        Frame(|_, sim, asked| {
            let restarting = flags(sim, S::GENERAL) & CommonFlags::RESTARTING.bits() != 0;
            match restarting && order(asked) == Some(0) {
                true => vec![says(&asked[0], S::GENERAL, Status::BUSY)],
                false => pass(sim, asked),
            }
        }),
    ),
    updated(
        "§U/1",
        "the other slot runs after a restart",
        Frame(|memory, sim, asked| {
            let restarted = asks(asked, R::RESTART) && asked[0].device == S::ALL;
            let mut answers = pass(sim, asked);
            memory.on |= restarted && answers.iter().all(|rec| rec.status.is_success());
            if memory.on {
                reports(&mut answers, |report| report[SLOT] ^= 3);
            }
            answers
        }),
    ),
    updated(
        "§U/2",
        "a wrong size is NeedConfirm",
        Answer(|_, _, answers| {
            restate(answers, R::UPDATE, Status::WRONG_DATA, Status::NEED_CONFIRM);
        }),
    ),
    updated(
        "§U/2",
        "a wrong size has a report",
        Answer(|_, _, answers| {
            each(answers, R::UPDATE, |rec| {
                if rec.status == Status::WRONG_DATA {
                    rec.data = vec![0; REPORT];
                }
            });
        }),
    ),
    updated(
        "§U/2",
        "verify takes a fourth byte",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.data.first() == Some(&3) {
                rec.data.truncate(3);
            }
        }),
    ),
    updated(
        "§U/2",
        "a part may be cut to a multiple of 8 bytes",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.data.first() == Some(&2) && rec.data.len() > 15 {
                let part = rec.data.len() - 7;
                rec.data.truncate(7 + part / 8 * 8);
            }
        }),
    ),
    updated(
        "§U/2",
        "an order that does not exist is WrongData",
        Answer(|_, asked, answers| {
            if order(asked).is_some_and(|kind| kind > 6) {
                restate(answers, R::UPDATE, Status::INVALID_VALUE, Status::WRONG_DATA);
            }
        }),
    ),
    updated(
        "§U/2",
        "an order that does not exist is the state",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.data.first().is_some_and(|kind| *kind > 6) {
                rec.data = vec![0];
            }
        }),
    ),
    updated(
        "§U/3",
        "any key will do",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.data.len() > 2 {
                rec.data[1..3].copy_from_slice(&KEY.to_le_bytes());
            }
        }),
    ),
    updated(
        "§U/3",
        "the key comes high byte first",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.data.len() > 2 {
                rec.data.swap(1, 2);
            }
        }),
    ),
    updated(
        "§U/3",
        "a wrong key is InvalidValue",
        Answer(|_, _, answers| {
            restate(answers, R::UPDATE, Status::NEED_CONFIRM, Status::INVALID_VALUE);
        }),
    ),
    updated(
        "§U/3",
        "NeedConfirm comes without a report",
        Answer(|_, _, answers| bare(answers, Status::NEED_CONFIRM)),
    ),
    updated(
        "§U/4",
        "not locked out, an order is accepted",
        Answer(|_, _, answers| restate(answers, R::UPDATE, Status::DENIED, Status::ACCEPTED)),
    ),
    updated(
        "§U/4",
        "not locked out, an order is Busy",
        Answer(|_, _, answers| restate(answers, R::UPDATE, Status::DENIED, Status::BUSY)),
    ),
    updated(
        "§U/4",
        "Denied comes without a report",
        Answer(|_, _, answers| bare(answers, Status::DENIED)),
    ),
    updated(
        "§U/4",
        "locked out, it is updated in working position too",
        Frame(|_, sim, asked| {
            let both = locked(sim) && deployed(sim);
            let mut answers = pass(sim, asked);
            if both {
                restate(&mut answers, R::UPDATE, Status::DENIED, Status::ACCEPTED);
            }
            answers
        }),
    ),
    updated(
        "§U/5",
        "any header starts an update",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| (report[PHASE], report[REASON]) = (1, 0));
        }),
    ),
    updated(
        "§U/5",
        "every bad header is no image",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| report[REASON] = 1);
        }),
    ),
    updated(
        "§U/5",
        "the signature is checked before the board",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| {
                if report[REASON] == 4 {
                    report[REASON] = 10;
                }
            });
        }),
    ),
    updated(
        "§U/5",
        "no signature is checked",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| {
                if matches!(report[REASON], 7 | 10) {
                    report[REASON] = 0;
                }
            });
        }),
    ),
    updated(
        "§U/5",
        "a bad header changes the version",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| report[12] = 9);
        }),
    ),
    updated(
        "§U/5",
        "a bad header is the image that is received",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 1, |report| report[20] = 0x5A);
        }),
    ),
    updated(
        "§U/5",
        "a bad header is refused at once",
        Answer(|_, asked, answers| {
            of_order(asked, answers, 1, Status::ACCEPTED, Status::INVALID_VALUE);
        }),
    ),
    updated(
        "§U/6",
        "data are accepted with nothing started",
        Answer(|_, asked, answers| {
            of_order(asked, answers, 2, Status::INVALID_VALUE, Status::ACCEPTED);
        }),
    ),
    updated(
        "§U/6",
        "nothing is verified without a reason",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 3, |report| {
                if report[REASON] == 13 {
                    report[REASON] = 0;
                }
            });
        }),
    ),
    updated(
        "§U/6",
        "what was never verified is committed",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 4, |report| report[PHASE] = 4);
        }),
    ),
    updated(
        "§U/6",
        "a commit of nothing restarts it",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 4, |_| {});
            if memory.on {
                reflag(answers, S::GENERAL, |flags| flags | CommonFlags::RESTARTING.bits());
            }
        }),
    ),
    updated(
        "§U/6",
        "any word confirms",
        Answer(|memory, asked, answers| {
            since(memory, asked, answers, 5, |report| report[REASON] = 0);
        }),
    ),
    wrong(
        "§U/7",
        "without it, Update is WrongData",
        Answer(|_, _, answers| {
            restate(answers, R::UPDATE, Status::WRONG_REQUEST, Status::WRONG_DATA);
        }),
    ),
    wrong(
        "§U/7",
        "without it, a drive answers Update itself",
        Answer(|_, asked, answers| {
            each(answers, R::UPDATE, |rec| {
                if asked[0].device == S::HORIZONTAL {
                    rec.device = S::HORIZONTAL;
                }
            });
        }),
    ),
    wrong(
        "§U/7",
        "without it and locked out, Update is WrongRequest",
        Answer(|_, _, answers| restate(answers, R::UPDATE, Status::DENIED, Status::WRONG_REQUEST)),
    ),
    updated(
        "§U/8",
        "a drive is updated as General is",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.device.is_drive() {
                rec.device = S::GENERAL;
            }
        }),
    ),
    updated(
        "§U/8",
        "Update to All is one to General",
        Request(|_, rec| {
            if rec.request == R::UPDATE && rec.device == S::ALL {
                rec.device = S::GENERAL;
            }
        }),
    ),
    updated(
        "§U/8",
        "Update to an unknown device is WrongRequest",
        Answer(|_, _, answers| {
            restate(answers, R::UPDATE, Status::MODULE_NOT_EXIST, Status::WRONG_REQUEST);
        }),
    ),
    updated(
        "§U/9",
        "SoftwareSlot is the other slot",
        Answer(|_, _, answers| {
            of_software("SoftwareSlot", answers, |values| values[0] = 3 - values[0]);
        }),
    ),
    updated(
        "§U/9",
        "SoftwareVersion is read from right to left",
        Answer(|_, _, answers| of_software("SoftwareVersion", answers, <[u8]>::reverse)),
    ),
    updated(
        "§U/9",
        "SoftwareHash is in the order of its bytes in memory",
        Answer(|_, _, answers| {
            of_software("SoftwareHash", answers, |values| {
                values.chunks_mut(4).for_each(<[u8]>::reverse);
            });
        }),
    ),
    updated(
        "§U/9",
        "SetParam SoftwareSlot is Accepted",
        Answer(|_, asked, answers| {
            let slot = ParamId::of("SoftwareSlot").0.to_le_bytes();
            if asked.iter().any(|rec| rec.data.starts_with(&slot)) {
                restate(answers, R::SET_PARAM, Status::ACCESS_DENIED, Status::ACCEPTED);
            }
        }),
    ),
];
