//! Parameters that differ from what was set.

use lafet_conform::raw::Rec;
use lafet_proto::flags::{ClimaticsFlags, CommonFlags, DriveFlags};
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};

use super::Rule::{Answer, Frame, Request};
use super::{
    Wrong, asks, each, flags, in_profile, instead, pass, reflag, restate, says, secretly, wrong,
};

fn is(rec: &Rec, request: R, name: &str) -> bool {
    rec.request == request && rec.data.starts_with(&ParamId::of(name).0.to_le_bytes())
}

fn restate_one(asked: &[Rec], answers: &mut [Rec], name: &str, from: Status, to: Status) {
    if is(&asked[0], R::SET_PARAM, name) {
        restate(answers, R::SET_PARAM, from, to);
    }
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.5",
        "the answer to SetParam lacks the id",
        Answer(|_, _, answers| {
            each(answers, R::SET_PARAM, |rec| rec.data.clear());
        }),
    ),
    wrong(
        "§3.5",
        "the answer to SetParam has the value in it",
        Answer(|_, asked, answers| {
            if asked[0].request == R::SET_PARAM && answers[0].status.is_success() {
                answers[0].data = asked[0].data.clone();
            }
        }),
    ),
    wrong(
        "§3.5/1",
        "SetParam is Accepted and forgotten",
        Frame(|_, sim, asked| {
            let mut answers = instead(
                sim,
                asked,
                |rec| rec.request == R::SET_PARAM && rec.data.len() == 6,
                Status::ACCEPTED,
            );
            if asks(asked, R::SET_PARAM) && asked[0].data.len() == 6 {
                answers[0].data = asked[0].data[..2].to_vec();
            }
            answers
        }),
    ),
    wrong(
        "§3.5/1",
        "a value is read back after a second only",
        Frame(|memory, sim, asked| {
            let rec = &asked[0];
            if rec.request == R::SET_PARAM && rec.data.len() == 6 {
                memory.kept = secretly(sim, R::GET_PARAM, rec.device, &rec.data[..2]).pop();
                memory.at_ms = sim.now_ms() + 1000;
            }
            let mut answers = pass(sim, asked);
            if let Some(old) = memory.kept.as_ref().filter(|_| sim.now_ms() < memory.at_ms)
                && rec.request == R::GET_PARAM
                && old.device == rec.device
                && old.data.starts_with(&rec.data)
            {
                answers[0] = old.clone();
            }
            answers
        }),
    ),
    wrong(
        "§3.5/1",
        "a value is lost after a second",
        Frame(|memory, sim, asked| {
            let rec = &asked[0];
            if rec.request == R::SET_PARAM && rec.data.len() == 6 {
                let old = secretly(sim, R::GET_PARAM, rec.device, &rec.data[..2]);
                memory.kept = old.into_iter().find(|old| old.data.len() == 6);
                memory.at_ms = sim.now_ms() + 1000;
            }
            if let Some(old) = memory.kept.take_if(|_| sim.now_ms() > memory.at_ms) {
                secretly(sim, R::SET_PARAM, old.device, &old.data);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.5/1",
        "values have 16 bits",
        Request(|_, rec| {
            if rec.request == R::SET_PARAM && rec.data.len() == 6 {
                rec.data[4..].fill(0);
            }
        }),
    ),
    wrong(
        "§3.5/1",
        "the sign of a value is lost",
        Answer(|_, asked, answers| {
            if asked[0].request == R::GET_PARAM && answers[0].data.len() == 6 {
                answers[0].data[5] &= 0x7F;
            }
        }),
    ),
    wrong(
        "§3.5/1",
        "only the first value of an array is kept",
        Request(|_, rec| {
            if rec.request == R::SET_PARAM && rec.data.len() > 6 {
                rec.data[6..].fill(0);
            }
        }),
    ),
    wrong(
        "§3.5/2",
        "an unknown parameter is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::INVALID_ID, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.5/2",
        "an unknown parameter is WrongData",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::INVALID_ID, Status::WRONG_DATA);
        }),
    ),
    wrong(
        "§3.5/3",
        "a value out of range is Accepted and not taken",
        Answer(|_, asked, answers| {
            restate_one(asked, answers, "MoveTimeout", Status::INVALID_VALUE, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.5/3",
        "a value out of range is clamped",
        Request(|_, rec| {
            if is(rec, R::SET_PARAM, "MoveTimeout") && rec.data.len() == 6 {
                let value = i32::from_le_bytes(rec.data[2..].try_into().unwrap_or_default());
                rec.data[2..].copy_from_slice(&value.clamp(0, 60_000).to_le_bytes());
            }
        }),
    ),
    wrong(
        "§3.5/4",
        "surplus values are left out",
        Request(|_, rec| {
            if rec.request == R::SET_PARAM {
                rec.data.truncate(6);
            }
        }),
    ),
    wrong(
        "§3.5/4",
        "a value cut short is filled up",
        Request(|_, rec| {
            if rec.request == R::SET_PARAM && (3..6).contains(&rec.data.len()) {
                rec.data.resize(6, 0);
            }
        }),
    ),
    wrong(
        "§3.5/5",
        "FaultInfo is InvalidId when set",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::ACCESS_DENIED, Status::INVALID_VALUE);
        }),
    ),
    in_profile(
        "ex",
        wrong(
            "§3.5/7",
            "a parameter of a unit stays Cached",
            Answer(|_, asked, answers| {
                if is(&asked[0], R::SET_PARAM, "Speed") && asked[0].device == S::HORIZONTAL {
                    answers[0].status = Status::CACHED;
                }
            }),
        ),
    ),
    wrong(
        "§3.5/9",
        "a stored value stays Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::OK, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.5/9",
        "a value is Ok before it is stored",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::ACCEPTED, Status::OK);
        }),
    ),
    wrong(
        "§3.5/10",
        "a value is stored while a drive turns",
        Frame(|_, sim, asked| {
            let moving = flags(sim, S::HORIZONTAL) & DriveFlags::MOVE.bits() != 0;
            let mut answers = pass(sim, asked);
            if moving {
                restate(&mut answers, R::SET_PARAM, Status::ACCEPTED, Status::OK);
            }
            answers
        }),
    ),
    wrong(
        "§3.21/3",
        "SetParam Hotbeds is Accepted",
        Answer(|_, asked, answers| {
            restate_one(asked, answers, "Hotbeds", Status::ACCESS_DENIED, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.3.1/4",
        "BadPower is never set",
        Answer(|_, _, answers| {
            reflag(answers, S::GENERAL, |flags| flags & !CommonFlags::BAD_POWER.bits());
        }),
    ),
    wrong(
        "§3.3.1/4",
        "BadPower checks the lower limit only",
        Request(|_, rec| {
            if is(rec, R::SET_PARAM, "MainVoltageMax") && rec.data.len() == 6 {
                rec.data[2..].copy_from_slice(&100_i32.to_le_bytes());
            }
        }),
    ),
    wrong(
        "§3.3.3/1",
        "the box is not heated",
        Answer(|_, _, answers| {
            reflag(answers, S::CLIMATICS, |flags| flags & !ClimaticsFlags::BOX_HEAT.bits());
        }),
    ),
    wrong(
        "§3.3.3/1",
        "the box is heated for good",
        Answer(|memory, _, answers| {
            let heat = ClimaticsFlags::BOX_HEAT.bits();
            memory.on |= answers
                .iter()
                .any(|rec| rec.device == S::CLIMATICS && rec.flags().unwrap_or(0) & heat != 0);
            if memory.on {
                reflag(answers, S::CLIMATICS, |flags| flags | heat);
            }
        }),
    ),
    wrong(
        "§3.6",
        "General takes a correction table",
        Answer(|_, _, answers| {
            restate(answers, R::SETUP_CORRECTION_TABLE, Status::WRONG_REQUEST, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.6/2",
        "a table without entries is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::SETUP_CORRECTION_TABLE, Status::WRONG_DATA, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.6/2",
        "a table beyond its end wraps around",
        Request(|_, rec| {
            if rec.request == R::SETUP_CORRECTION_TABLE && rec.data.len() == 3 {
                rec.data[0] = 0;
            }
        }),
    ),
    wrong(
        "§3.6/1",
        "a table stays Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::SETUP_CORRECTION_TABLE, Status::OK, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.6/1",
        "a table is not supported",
        Answer(|_, asked, answers| {
            if asked[0].request == R::SETUP_CORRECTION_TABLE && asked[0].device == S::CONTROL {
                answers[0] = says(&asked[0], S::CONTROL, Status::NOT_SUPPORTED);
            }
        }),
    ),
    wrong(
        "§3.4/3",
        "an unset parameter reads as 0",
        Answer(|_, _, answers| {
            each(answers, R::GET_PARAM, |rec| {
                if rec.status == Status::INCOMPLETE_CONFIG {
                    rec.status = Status::OK;
                    rec.data.extend([0; 4]);
                }
            });
        }),
    ),
    wrong(
        "§3.5/6",
        "an incomplete set is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::SET_PARAM, Status::INCOMPLETE_CONFIG, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.19",
        "a valve takes CleanFlash",
        Answer(|_, _, answers| {
            restate(answers, R::CLEAN_FLASH, Status::WRONG_REQUEST, Status::OK);
        }),
    ),
    wrong(
        "§3.19",
        "CleanFlash takes one byte",
        Answer(|_, _, answers| {
            restate(answers, R::CLEAN_FLASH, Status::WRONG_DATA, Status::NEED_CONFIRM);
        }),
    ),
    wrong(
        "§3.19/2",
        "any key erases",
        Request(|_, rec| {
            if rec.request == R::CLEAN_FLASH && rec.data.len() == 2 {
                rec.data = lafet_proto::id::key::CLEAN_FLASH.to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.19/3",
        "CleanFlash is Ok and erases nothing",
        Frame(|_, sim, asked| {
            let right = lafet_proto::id::key::CLEAN_FLASH.to_le_bytes();
            instead(
                sim,
                asked,
                |rec| {
                    rec.request == R::CLEAN_FLASH && rec.device == S::GENERAL && rec.data == right
                },
                Status::OK,
            )
        }),
    ),
    wrong(
        "§3.19/3",
        "ConfigInvalid is not reported",
        Answer(|_, _, answers| {
            reflag(answers, S::GENERAL, |flags| flags & !CommonFlags::CONFIG_INVALID.bits());
        }),
    ),
    wrong(
        "§3.19/1",
        "CleanFlash is Denied",
        Answer(|_, _, answers| {
            restate(answers, R::CLEAN_FLASH, Status::OK, Status::DENIED);
        }),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.3.1/2",
            "it moves without a configuration",
            Answer(|_, _, answers| {
                restate(answers, R::MOVE, Status::MODULE_FAULT, Status::ACCEPTED);
            }),
        ),
    ),
];
