//! Programs that do not extinguish as they were commanded to.

use lafet_conform::raw::Rec;
use lafet_proto::flags::{ControlFlags as C, DeployerFlags, DriveFlags};
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, asks, flags, instead, pass, reflag, restate, says, secretly, wrong};

const RUNS: u32 = C::QUENCH.bits() | C::TRAJECTORY.bits();

fn runs(sim: &mut Sim) -> bool {
    flags(sim, S::CONTROL) & RUNS != 0
}

fn wrapped(sim: &mut Sim) -> bool {
    flags(sim, S::DEPLOYER) & DeployerFlags::WRAPPED.bits() != 0
}

fn hide(answers: &mut [Rec], flag: C) {
    reflag(answers, S::CONTROL, |flags| flags & !flag.bits());
}

/// Changes the data of a full StartQuench.
fn full(rec: &mut Rec, change: impl Fn(&mut Vec<u8>)) {
    if rec.request == R::START_QUENCH && rec.data.len() == 12 {
        change(&mut rec.data);
    }
}

fn is_stop(rec: &Rec, of: S) -> bool {
    rec.request == R::STOP && rec.device == of
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.14",
        "StartQuench of 9 to 11 bytes is taken as the simplified one",
        Request(|_, rec| {
            if rec.request == R::START_QUENCH && (9..12).contains(&rec.data.len()) {
                rec.data.truncate(8);
            }
        }),
    ),
    wrong(
        "§3.14",
        "StartQuench without data runs program 0",
        Request(|_, rec| {
            if rec.request == R::START_QUENCH && rec.data.is_empty() {
                rec.data = vec![0; 8];
            }
        }),
    ),
    wrong(
        "§3.14/4",
        "program 8 is program 0",
        Request(|_, rec| {
            if rec.request == R::START_QUENCH && rec.data.len() == 8 && rec.data[0] == 8 {
                rec.data[0] = 0;
            }
        }),
    ),
    wrong(
        "§3.14/4",
        "a negative width is taken as its size",
        Request(|_, rec| {
            full(rec, |data| {
                let width = i16::from_le_bytes([data[6], data[7]]).saturating_abs();
                data[6..8].copy_from_slice(&width.to_le_bytes());
            });
        }),
    ),
    wrong("§3.14/1", "Quench is not reported", Answer(|_, _, answers| hide(answers, C::QUENCH))),
    wrong(
        "§3.14/1",
        "StartQuench is Accepted and nothing runs",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::START_QUENCH) && answers[0].status.is_success() {
                secretly(sim, R::STOP, S::CONTROL, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.14/1",
        "the jet stays in the centre of the sector",
        Request(|_, rec| {
            full(rec, |data| data[6..11].fill(0));
        }),
    ),
    wrong(
        "§3.14/1",
        "the jet goes over one line only",
        Request(|_, rec| {
            full(rec, |data| data[8..10].fill(0));
        }),
    ),
    wrong(
        "§3.14/1",
        "the sector is twice as wide",
        Request(|_, rec| {
            full(rec, |data| {
                let width = i16::from_le_bytes([data[6], data[7]]).saturating_mul(2);
                data[6..8].copy_from_slice(&width.to_le_bytes());
            });
        }),
    ),
    wrong(
        "§3.14/1",
        "the centre is a degree aside",
        Request(|_, rec| {
            full(rec, |data| {
                let at = i16::from_le_bytes([data[0], data[1]]).saturating_add(60);
                data[..2].copy_from_slice(&at.to_le_bytes());
            });
        }),
    ),
    wrong(
        "§3.14/2",
        "the simplified form is WrongData",
        Answer(|_, asked, answers| {
            if asks(asked, R::START_QUENCH) && asked[0].data.len() == 8 {
                answers[0].status = Status::WRONG_DATA;
            }
        }),
    ),
    wrong(
        "§3.14/3",
        "the table of the request is ignored",
        Request(|_, rec| {
            if rec.request == R::START_QUENCH && rec.data.len() > 12 {
                rec.data[11..].fill(0);
            }
        }),
    ),
    wrong(
        "§3.14/3",
        "the corrections lower the barrel",
        Request(|_, rec| {
            if rec.request == R::START_QUENCH && rec.data.len() > 12 {
                rec.data[11..].iter_mut().for_each(|degrees| *degrees = degrees.wrapping_neg());
            }
        }),
    ),
    wrong(
        "§3.14/5",
        "StartQuench is Denied while wrapped",
        Frame(|_, sim, asked| {
            if wrapped(sim) && asks(asked, R::START_QUENCH) {
                return vec![says(&asked[0], S::DEPLOYER, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.14/5",
        "StartQuench deploys and then does nothing",
        Frame(|memory, sim, asked| {
            memory.on |= wrapped(sim) && asks(asked, R::START_QUENCH);
            if memory.on && flags(sim, S::DEPLOYER) & DeployerFlags::DEPLOYED.bits() != 0 {
                memory.on = false;
                secretly(sim, R::STOP, S::CONTROL, &[]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.14/6",
        "a program while searching is Busy",
        Answer(|_, _, answers| {
            restate(answers, R::START_QUENCH, Status::DENIED, Status::BUSY);
        }),
    ),
    wrong(
        "§3.14/8",
        "a sector wholly outside is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::START_QUENCH, Status::INVALID_VALUE, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.14/8",
        "ModeFault is not reported",
        Answer(|_, _, answers| hide(answers, C::MODE_FAULT)),
    ),
    wrong(
        "§3.3.6/3",
        "OutsideLimits is not reported",
        Answer(|_, _, answers| {
            hide(answers, C::OUTSIDE_LIMITS);
        }),
    ),
    wrong(
        "§3.3.6/4",
        "OutsideLimits clears with the program",
        Frame(|_, sim, asked| {
            let over = !runs(sim);
            let mut answers = pass(sim, asked);
            if over {
                hide(&mut answers, C::OUTSIDE_LIMITS);
            }
            answers
        }),
    ),
    wrong(
        "§3.3.6/4",
        "OutsideLimits stays for good",
        Answer(|memory, _, answers| {
            let outside = C::OUTSIDE_LIMITS.bits();
            memory.on |= answers
                .iter()
                .any(|rec| rec.device == S::CONTROL && rec.flags().unwrap_or(0) & outside != 0);
            if memory.on {
                reflag(answers, S::CONTROL, |flags| flags | outside);
            }
        }),
    ),
    wrong(
        "§3.3.6/2",
        "RangeFault is reported without ballistics",
        Answer(|_, _, answers| {
            reflag(answers, S::CONTROL, |flags| match flags & RUNS {
                0 => flags,
                _ => flags | C::TRAJECTORY_RANGE_FAULT.bits(),
            });
        }),
    ),
    wrong(
        "§3.3.6/5",
        "along a path the nozzle stays",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::START_TRAJECTORY) && answers[0].status.is_success() {
                secretly(sim, R::MOVE, S::NOZZLE, &[5, 0]);
            }
            answers
        }),
    ),
    wrong(
        "§3.14/9",
        "a second StartQuench is Busy",
        Frame(|_, sim, asked| {
            let busy = runs(sim);
            instead(sim, asked, |rec| busy && rec.request == R::START_QUENCH, Status::BUSY)
        }),
    ),
    wrong(
        "§3.14/9",
        "a second StartQuench is Accepted and forgotten",
        Frame(|_, sim, asked| {
            let busy = runs(sim);
            instead(sim, asked, |rec| busy && rec.request == R::START_QUENCH, Status::ACCEPTED)
        }),
    ),
    wrong(
        "§3.14/10",
        "a program goes on when deploying was stopped",
        Answer(|memory, _, answers| {
            let fault = C::MODE_FAULT.bits();
            memory.on |= answers
                .iter()
                .any(|rec| rec.device == S::CONTROL && rec.flags().unwrap_or(0) & fault != 0);
            if memory.on {
                reflag(answers, S::CONTROL, |flags| flags | C::QUENCH.bits());
            }
        }),
    ),
    wrong(
        "§3.1/3",
        "Move is Denied while quenching",
        Frame(|_, sim, asked| {
            if runs(sim) && asks(asked, R::MOVE) {
                return vec![says(&asked[0], S::CONTROL, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/3",
        "Move ends the program",
        Frame(|_, sim, asked| {
            if runs(sim) && asks(asked, R::MOVE) {
                secretly(sim, R::STOP, S::CONTROL, &[]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/3",
        "Move while quenching moves nothing",
        Frame(|_, sim, asked| {
            let busy = runs(sim);
            instead(sim, asked, |rec| busy && rec.request == R::MOVE, Status::ACCEPTED)
        }),
    ),
    wrong(
        "§3.1/3",
        "a paused program does not say so",
        Answer(|_, _, answers| {
            hide(answers, C::PAUSED);
        }),
    ),
    wrong(
        "§3.1/3",
        "a paused program goes on after a second",
        Frame(|memory, sim, asked| {
            if asks(asked, R::MOVE) {
                memory.at_ms = sim.now_ms() + 1000;
            }
            let mut answers = pass(sim, asked);
            if sim.now_ms() > memory.at_ms {
                hide(&mut answers, C::PAUSED);
            }
            answers
        }),
    ),
    wrong(
        "§3.1/3",
        "a paused program does not go on",
        Answer(|memory, _, answers| {
            let paused = C::PAUSED.bits();
            memory.on |= answers
                .iter()
                .any(|rec| rec.device == S::CONTROL && rec.flags().unwrap_or(0) & paused != 0);
            if memory.on {
                reflag(answers, S::CONTROL, |flags| flags | paused);
            }
        }),
    ),
    wrong(
        "§3.1/3",
        "after the pause it goes back to the old sector",
        Frame(|memory, sim, asked| {
            if asks(asked, R::START_QUENCH) {
                memory.kept = Some(asked[0].clone());
            }
            let paused = flags(sim, S::CONTROL) & C::PAUSED.bits() != 0;
            if std::mem::replace(&mut memory.on, paused) && !paused && runs(sim) {
                pass(sim, memory.kept.as_slice());
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.2/4",
        "Stop to a drive stops it while quenching",
        Frame(|_, sim, asked| {
            let busy = runs(sim);
            instead(
                sim,
                asked,
                |rec| busy && rec.request == R::STOP && rec.device.is_drive(),
                Status::OK,
            )
        }),
    ),
    wrong(
        "§3.2/4",
        "Stop Control is Ok and the program goes on",
        Frame(|_, sim, asked| instead(sim, asked, |rec| is_stop(rec, S::CONTROL), Status::OK)),
    ),
    wrong(
        "§3.2/4",
        "Stop Control leaves the drives moving",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if is_stop(&asked[0], S::CONTROL) {
                secretly(sim, R::MOVE, S::HORIZONTAL, &(-21_600_i16).to_le_bytes());
            }
            answers
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All leaves a program running",
        Frame(|memory, sim, asked| {
            if asks(asked, R::START_QUENCH) {
                memory.kept = Some(asked[0].clone());
            }
            let ran = flags(sim, S::CONTROL) & C::QUENCH.bits() != 0;
            let answers = pass(sim, asked);
            if ran && is_stop(&asked[0], S::ALL) {
                pass(sim, memory.kept.as_slice());
            }
            answers
        }),
    ),
    wrong(
        "§3.11/7",
        "Wrap is Denied while quenching",
        Frame(|_, sim, asked| {
            if runs(sim) && asks(asked, R::WRAP) {
                return vec![says(&asked[0], S::CONTROL, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.15",
        "StartTrajectory takes a point less than it counts",
        Request(|_, rec| {
            if rec.request == R::START_TRAJECTORY && rec.data.len() == 9 && rec.data[2] == 2 {
                rec.data[2] = 1;
            }
        }),
    ),
    wrong(
        "§3.15/1",
        "StartTrajectory is an unknown request",
        Answer(|_, asked, answers| {
            if asks(asked, R::START_TRAJECTORY) {
                answers[0] = says(&asked[0], S::GENERAL, Status::WRONG_REQUEST);
            }
        }),
    ),
    wrong(
        "§3.15/1",
        "the points are taken last to first",
        Request(|_, rec| {
            if rec.request == R::START_TRAJECTORY
                && rec.data.first() == Some(&0)
                && rec.data.len() == 15
            {
                rec.data[3..].rotate_left(6);
            }
        }),
    ),
    wrong(
        "§3.15/1",
        "a trajectory does not end",
        Request(|_, rec| {
            if rec.request == R::START_TRAJECTORY && rec.data.len() > 3 {
                rec.data[1] |= 2;
            }
        }),
    ),
    wrong(
        "§3.15/1",
        "a trajectory is not repeated",
        Request(|_, rec| {
            if rec.request == R::START_TRAJECTORY && rec.data.len() > 3 {
                rec.data[1] &= !2;
            }
        }),
    ),
    wrong(
        "§3.15/2",
        "an empty trajectory is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::START_TRAJECTORY, Status::INVALID_ID, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.15/3",
        "an unknown mode is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::START_TRAJECTORY, Status::INVALID_VALUE, Status::ACCEPTED);
            restate(answers, R::START_TRAJECTORY, Status::WRONG_DATA, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.15/4",
        "Move is Denied along a trajectory",
        Frame(|_, sim, asked| {
            let busy = flags(sim, S::CONTROL) & C::TRAJECTORY.bits() != 0;
            if busy && asks(asked, R::MOVE) {
                return vec![says(&asked[0], S::CONTROL, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§D/1",
        "a program continues after a reset",
        Frame(|memory, sim, asked| {
            if asks(asked, R::RESTART) {
                (memory.on, memory.resets) = (true, sim.resets());
            }
            let answers = pass(sim, asked);
            let begun = memory.on && sim.resets() > memory.resets;
            if begun && flags(sim, S::HORIZONTAL) & DriveFlags::MOVE.bits() == 0 {
                secretly(sim, R::MOVE, S::HORIZONTAL, &600_i16.to_le_bytes());
            }
            answers
        }),
    ),
];
