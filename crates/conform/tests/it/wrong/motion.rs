//! Drives that do not do what they were commanded to.

use lafet_conform::raw::Rec;
use lafet_proto::flags::DriveFlags as D;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Raw, Request};
use super::{
    Wrong, destination, each, flags, in_profile, instead, limits, pass, position, reflag, restate,
    says, secretly, wrong,
};
use crate::support::ask;

const MOVE: u32 = D::MOVE.bits();
const MIN: u32 = D::MIN_LIMIT_REACHED.bits();
const MAX: u32 = D::MAX_LIMIT_REACHED.bits();
const OVERLOAD: u32 = D::AMPERAGE_OVERLOAD.bits();
const LIMITLESS: u32 = D::LIMITLESS.bits();

fn all_drives(answers: &mut [Rec], change: impl Fn(u32) -> u32 + Copy) {
    for id in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE] {
        reflag(answers, id, change);
    }
}

fn is_param(rec: &Rec, name: &str) -> bool {
    rec.request == R::SET_PARAM && rec.data.starts_with(&ParamId::of(name).0.to_le_bytes())
}

fn to_drive(rec: &Rec, request: R) -> bool {
    rec.request == request && rec.device.is_drive() && rec.device != S::DEPLOYER
}

/// Executes the frame with this destination instead.
fn sent_to(sim: &mut Sim, rec: &Rec, to: i32) -> Vec<Rec> {
    let to = i16::try_from(to).unwrap_or(0).to_le_bytes();
    pass(sim, &[Rec { data: to.to_vec(), ..rec.clone() }])
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.1",
        "Move takes a third byte",
        Request(|_, rec| {
            if rec.request == R::MOVE {
                rec.data.truncate(2);
            }
        }),
    ),
    wrong(
        "§3.1",
        "the answer to Move has the destination in it",
        Answer(|_, asked, answers| {
            if asked[0].request == R::MOVE && answers[0].status.is_success() {
                answers[0].data = asked[0].data.clone();
            }
        }),
    ),
    wrong(
        "§3.1/4",
        "Move is Accepted and nothing moves",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if to_drive(&asked[0], R::MOVE) && answers[0].status.is_success() {
                secretly(sim, R::STOP, asked[0].device, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.1/4",
        "a drive goes a degree too far",
        Request(|_, rec| {
            if let Some(to) = destination(rec) {
                rec.data = (to.saturating_add(60)).to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.1/4",
        "Move is relative",
        Frame(|_, sim, asked| match destination(&asked[0]) {
            Some(to) if to_drive(&asked[0], R::MOVE) => {
                let at = position(sim, asked[0].device);
                sent_to(sim, &asked[0], at + i32::from(to))
            }
            _ => pass(sim, asked),
        }),
    ),
    wrong(
        "§3.1/4",
        "a Move while it moves is Busy",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            if to_drive(rec, R::MOVE) && flags(sim, rec.device) & MOVE != 0 {
                return vec![says(rec, rec.device, Status::BUSY)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/4",
        "a Move while it moves is Accepted and forgotten",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            if to_drive(rec, R::MOVE) && flags(sim, rec.device) & MOVE != 0 {
                return vec![says(rec, rec.device, Status::ACCEPTED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/4",
        "Move Vertical moves the nozzle",
        Frame(|_, sim, asked| {
            if asked[0].request == R::MOVE && asked[0].device == S::VERTICAL {
                secretly(sim, R::MOVE, S::NOZZLE, &asked[0].data);
                return vec![says(&asked[0], S::VERTICAL, Status::ACCEPTED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/5",
        "Move to what is no drive is NotSupported",
        Answer(|_, _, answers| {
            restate(answers, R::MOVE, Status::WRONG_REQUEST, Status::NOT_SUPPORTED);
        }),
    ),
    wrong(
        "§3.1/5",
        "Move Control moves Horizontal",
        Request(|_, rec| {
            if rec.request == R::MOVE && rec.device == S::CONTROL {
                rec.device = S::HORIZONTAL;
            }
        }),
    ),
    wrong(
        "§3.1/7",
        "left and right are exchanged",
        Request(|_, rec| {
            if let Some(to) = destination(rec).filter(|_| rec.device == S::HORIZONTAL) {
                rec.data = to.saturating_neg().to_le_bytes().to_vec();
            }
        }),
    ),
    wrong(
        "§3.1/7",
        "a destination beyond the limits is InvalidValue",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            if let Some(to) = destination(rec).filter(|_| to_drive(rec, R::MOVE)) {
                let (min, max) = limits(sim, rec.device);
                if i32::from(to) < min || i32::from(to) > max {
                    return vec![says(rec, rec.device, Status::INVALID_VALUE)];
                }
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/7",
        "a drive stops a degree before its limit",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            match destination(rec).map(i32::from) {
                Some(to) if to_drive(rec, R::MOVE) => {
                    let (min, max) = limits(sim, rec.device);
                    sent_to(sim, rec, to.clamp(min + 60, max - 60))
                }
                _ => pass(sim, asked),
            }
        }),
    ),
    wrong(
        "§3.1/7",
        "a destination is taken as unsigned",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            match destination(rec) {
                Some(to) if to_drive(rec, R::MOVE) && to < 0 => sent_to(sim, rec, 32_767),
                _ => pass(sim, asked),
            }
        }),
    ),
    wrong(
        "§3.1/8",
        "limits off: a drive stops at them anyway",
        Frame(|memory, sim, asked| {
            let rec = &asked[0];
            let answers = pass(sim, asked);
            if to_drive(rec, R::MOVE) && flags(sim, rec.device) & LIMITLESS != 0 {
                (memory.kept, memory.at_ms) = (Some(rec.clone()), sim.now_ms() + 200);
            }
            if let Some(kept) = memory.kept.take_if(|_| sim.now_ms() > memory.at_ms) {
                secretly(sim, R::STOP, kept.device, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.3.4/2",
        "the flag Move is never set",
        Answer(|_, _, answers| {
            all_drives(answers, |flags| flags & !MOVE);
        }),
    ),
    wrong(
        "§3.3.4/2",
        "the speed is always 0",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device.is_drive() && rec.data.len() == 8 {
                    rec.data[7] = 0;
                }
            });
        }),
    ),
    wrong(
        "§3.3.4/2",
        "MinLimitReached and MaxLimitReached are exchanged",
        Answer(|_, _, answers| {
            all_drives(answers, |flags| {
                let rest = flags & !(MIN | MAX);
                rest | if flags & MIN != 0 { MAX } else { 0 }
                    | if flags & MAX != 0 { MIN } else { 0 }
            });
        }),
    ),
    wrong(
        "§3.3.4/2",
        "MaxLimitReached stays",
        Answer(|memory, _, answers| {
            for rec in answers.iter().filter(|rec| rec.request == R::GET_STATUS) {
                memory.on |= rec.device == S::HORIZONTAL && rec.flags().unwrap_or(0) & MAX != 0;
            }
            if memory.on {
                reflag(answers, S::HORIZONTAL, |flags| flags | MAX);
            }
        }),
    ),
    wrong(
        "§3.2/5",
        "Stop to a drive is Ok and it moves on",
        Frame(|_, sim, asked| instead(sim, asked, |rec| to_drive(rec, R::STOP), Status::OK)),
    ),
    wrong(
        "§3.2/5",
        "Stop to one drive stops the others too",
        Frame(|_, sim, asked| {
            if to_drive(&asked[0], R::STOP) {
                secretly(sim, R::STOP, S::ALL, &[]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.2/5",
        "a drive goes on a moment after Stop",
        Frame(|memory, sim, asked| {
            let answers = pass(sim, asked);
            if to_drive(&asked[0], R::STOP) {
                (memory.kept, memory.at_ms) = (Some(asked[0].clone()), sim.now_ms() + 250);
            }
            if let Some(kept) = memory.kept.take_if(|_| sim.now_ms() > memory.at_ms) {
                let to = position(sim, kept.device) + 120;
                sent_to(sim, &Rec::new(R::MOVE, kept.device, &[]), to);
            }
            answers
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All leaves Vertical moving",
        Frame(|memory, sim, asked| {
            if asked[0].request == R::MOVE && asked[0].device == S::VERTICAL {
                memory.kept = Some(asked[0].clone());
            }
            let moving = flags(sim, S::VERTICAL) & MOVE != 0;
            let answers = pass(sim, asked);
            if asked[0].request == R::STOP && asked[0].device == S::ALL && moving {
                pass(sim, memory.kept.as_slice());
            }
            answers
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All is answered and does nothing",
        Frame(|_, sim, asked| {
            if asked[0].request == R::STOP && asked[0].device == S::ALL {
                let chain = secretly(sim, R::GET_STATUS, S::ALL, &[]);
                let stops = |id: S| {
                    id.is_drive() || id.is_valve() || [S::CONTROL, S::DETECTOR].contains(&id)
                };
                let stopped = chain.iter().filter(|rec| stops(rec.device));
                return stopped.map(|rec| says(&asked[0], rec.device, Status::OK)).collect();
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§1/6",
        "Stop Motors does nothing",
        Frame(|_, sim, asked| {
            instead(sim, asked, |rec| rec.request == R::STOP && rec.device == S::MOTORS, Status::OK)
        }),
    ),
    wrong(
        "§2/2",
        "a record cut short is filled up with zeros",
        Raw(|_, sim, payload| {
            let mut whole = payload.to_vec();
            while Rec::all(&whole).is_none() && whole.len() < 512 {
                whole.push(0);
            }
            ask(sim, &whole)
        }),
    ),
    wrong(
        "§2/2",
        "the records before a cut record are not executed",
        Raw(|_, sim, payload| match Rec::all(payload) {
            Some(_) => ask(sim, payload),
            None => says(&Rec::new(R(payload[0]), S::GENERAL, &[]), S::GENERAL, Status::WRONG_DATA)
                .bytes(),
        }),
    ),
    wrong(
        "§2/2",
        "a record cut short is left out",
        Raw(|_, sim, payload| {
            let mut len = payload.len();
            while len > 0 && Rec::all(&payload[..len]).is_none() {
                len -= 1;
            }
            ask(sim, &payload[..len])
        }),
    ),
    wrong(
        "§2/4",
        "SwitchLimits 3 is taken for On",
        Request(|_, rec| {
            if rec.request == R::SWITCH_LIMITS && rec.data == [3, 0] {
                rec.data[0] = 1;
            }
        }),
    ),
    wrong(
        "§3.17",
        "SwitchLimits takes one byte",
        Request(|_, rec| {
            if rec.request == R::SWITCH_LIMITS && rec.data.len() == 1 {
                rec.data.push(0);
            }
        }),
    ),
    wrong(
        "§3.17/1",
        "Off is Ok and the limits stay on",
        Frame(|_, sim, asked| {
            let off = |rec: &Rec| rec.request == R::SWITCH_LIMITS && rec.data == [0, 0];
            instead(sim, asked, off, Status::OK)
        }),
    ),
    wrong(
        "§3.17/1",
        "Off: the limits are reported as ±32767",
        Frame(|_, sim, asked| {
            let mut answers = pass(sim, asked);
            if asked[0].request == R::RETRIEVE_LIMITS
                && flags(sim, asked[0].device) & LIMITLESS != 0
            {
                answers[0].data = [(-32_767_i32).to_le_bytes(), 32_767_i32.to_le_bytes()].concat();
            }
            answers
        }),
    ),
    wrong(
        "§3.17/1",
        "Limitless is not reported",
        Answer(|_, _, answers| {
            all_drives(answers, |flags| flags & !LIMITLESS);
        }),
    ),
    wrong(
        "§3.17/2",
        "On forgets the limit taken",
        Request(|_, rec| {
            if rec.request == R::SWITCH_LIMITS && rec.data == [1, 0] {
                rec.data[0] = 2;
            }
        }),
    ),
    wrong(
        "§3.17/3",
        "Reject keeps the limit taken",
        Request(|_, rec| {
            if rec.request == R::SWITCH_LIMITS && rec.data == [2, 0] {
                rec.data[0] = 1;
            }
        }),
    ),
    in_profile(
        "limit-switch",
        wrong(
            "§3.17/4",
            "a drive with limit switches switches its limits",
            Answer(|_, _, answers| {
                restate(answers, R::SWITCH_LIMITS, Status::NOT_SUPPORTED, Status::OK);
            }),
        ),
    ),
    wrong(
        "§3.17/5",
        "limits off: any value is taken for a limit",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| is_param(rec, "MinLimit") || is_param(rec, "MaxLimit")) {
                restate(answers, R::SET_PARAM, Status::INVALID_VALUE, Status::ACCEPTED);
            }
        }),
    ),
    wrong(
        "§D/4",
        "MoveTimeout is ignored",
        Request(|_, rec| {
            if is_param(rec, "MoveTimeout") && rec.data.len() == 6 {
                rec.data[2..].fill(0);
            }
        }),
    ),
    wrong(
        "§D/4",
        "MoveTimeout counts from the first Move",
        Frame(|memory, sim, asked| {
            let rec = &asked[0];
            let again = memory.kept.as_ref() == Some(rec) && flags(sim, rec.device) & MOVE != 0;
            if rec.request == R::MOVE {
                memory.kept = Some(rec.clone());
            }
            if again { vec![says(rec, rec.device, Status::ACCEPTED)] } else { pass(sim, asked) }
        }),
    ),
    wrong(
        "§D/4",
        "MoveHold is ignored",
        Request(|_, rec| {
            if is_param(rec, "MoveHold") && rec.data.len() == 6 {
                rec.data[2..].fill(0);
            }
        }),
    ),
    wrong(
        "§D/4",
        "MoveHold lasts once and is not renewed",
        Frame(|_, sim, asked| match asked {
            [rec] if is_param(rec, "MoveHold") => {
                vec![Rec { status: Status::OK, data: rec.data[..2].to_vec(), ..rec.clone() }]
            }
            _ => pass(sim, asked),
        }),
    ),
    wrong(
        "§D/4",
        "a renewed MoveHold sets a drive at rest in motion",
        Frame(|memory, sim, asked| {
            if let [_, rec] = asked
                && rec.request == R::MOVE
            {
                memory.kept = Some(rec.clone());
            }
            let kept =
                memory.kept.clone().filter(|_| matches!(asked, [rec] if is_param(rec, "MoveHold")));
            let answers = pass(sim, asked);
            if let Some(far) = kept.filter(|far| flags(sim, far.device) & MOVE == 0) {
                pass(sim, &[far]);
            }
            answers
        }),
    ),
    wrong(
        "§3.3.4/1",
        "AmperageOverload is not reported",
        Answer(|_, _, answers| {
            all_drives(answers, |flags| flags & !OVERLOAD);
        }),
    ),
    wrong(
        "§3.3.4/1",
        "AmperageOverload clears after half a second",
        Frame(|memory, sim, asked| {
            let mut answers = pass(sim, asked);
            for id in [S::HORIZONTAL, S::VERTICAL] {
                if flags(sim, id) & OVERLOAD == 0 {
                    continue;
                }
                if !std::mem::replace(&mut memory.on, true) {
                    memory.at_ms = sim.now_ms();
                }
                if sim.now_ms() > memory.at_ms + 500 {
                    reflag(&mut answers, id, |flags| flags & !OVERLOAD);
                }
            }
            answers
        }),
    ),
    wrong(
        "§3.3.4/1",
        "after an overload the same direction is taken",
        Answer(|_, _, answers| {
            restate(answers, R::MOVE, Status::MODULE_FAULT, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.3.4/1",
        "MaxCurrent is ignored",
        Request(|_, rec| {
            if is_param(rec, "MaxCurrent") && rec.data.len() == 6 {
                rec.data[2..].copy_from_slice(&200_i32.to_le_bytes());
            }
        }),
    ),
];
