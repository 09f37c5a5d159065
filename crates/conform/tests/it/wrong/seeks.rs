//! Searches and alignments that go wrong.

use lafet_proto::flags::{ControlFlags, DeployerFlags, DetectorFlags as D};
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, asks, flags, instead, pass, reflag, restate, says, secretly, wrong};
use lafet_conform::raw::Rec;

fn state(sim: &mut Sim) -> D {
    D::from_bits_retain(flags(sim, S::DETECTOR))
}

fn hide(answers: &mut [Rec], flag: D) {
    reflag(answers, S::DETECTOR, |flags| flags & !flag.bits());
}

/// While it searches, Detector does not intercept these: Accepted, and nothing happens.
fn lets(sim: &mut Sim, asked: &[Rec], wanted: fn(&Rec) -> bool) -> Vec<Rec> {
    let busy = state(sim).intersects(D::SEARCHING | D::JUSTIFYING);
    instead(sim, asked, |rec| busy && wanted(rec), Status::ACCEPTED)
}

fn is_wrapped(sim: &mut Sim) -> bool {
    flags(sim, S::DEPLOYER) & DeployerFlags::WRAPPED.bits() != 0
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.16",
        "StartSeek does without analyse",
        Request(|_, rec| {
            if rec.request == R::START_SEEK && rec.data.len() == 8 {
                rec.data.extend([0, 0]);
            }
        }),
    ),
    wrong(
        "§3.16",
        "General searches",
        Request(|_, rec| {
            if rec.request == R::START_SEEK && rec.device == S::GENERAL {
                rec.device = S::DETECTOR;
            }
        }),
    ),
    wrong(
        "§3.16/1",
        "Searching is not reported",
        Answer(|_, _, answers| hide(answers, D::SEARCHING)),
    ),
    wrong(
        "§3.16/1",
        "Found is reported without hotbeds",
        Answer(|_, _, answers| {
            reflag(answers, S::DETECTOR, |flags| flags | D::FOUND.bits());
        }),
    ),
    wrong(
        "§3.16/1",
        "a search starts again and again",
        Frame(|memory, sim, asked| {
            if asks(asked, R::START_SEEK) {
                memory.kept = Some(asked[0].clone());
            }
            if asked[0].request == R::STOP {
                memory.kept = None;
            }
            if !state(sim).contains(D::SEARCHING) {
                pass(sim, memory.kept.as_slice());
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.16/1",
        "a search to its end is reported as Canceled",
        Answer(|memory, _, answers| {
            for rec in answers.iter().filter(|rec| rec.device == S::DETECTOR) {
                memory.on |= rec.flags().unwrap_or(0) & D::SEARCHING.bits() != 0;
            }
            if memory.on {
                reflag(answers, S::DETECTOR, |flags| match flags & D::SEARCHING.bits() {
                    0 => flags | D::CANCELED.bits(),
                    _ => flags,
                });
            }
        }),
    ),
    wrong(
        "§3.16/2",
        "a sector beyond the limits is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::START_SEEK, Status::INVALID_VALUE, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.16/2",
        "BadSector is not reported",
        Answer(|_, _, answers| hide(answers, D::BAD_SECTOR)),
    ),
    wrong(
        "§3.16/2",
        "a turned sector is InvalidValue",
        Frame(|_, sim, asked| {
            let rec = &asked[0];
            let turned =
                asks(asked, R::START_SEEK) && rec.data.len() == 10 && rec.i16_at(0) > rec.i16_at(2);
            instead(sim, asked, |_| turned, Status::INVALID_VALUE)
        }),
    ),
    wrong(
        "§3.16/3",
        "StartSeek is Denied while wrapped",
        Frame(|_, sim, asked| {
            if is_wrapped(sim) && asks(asked, R::START_SEEK) {
                return vec![says(&asked[0], S::DEPLOYER, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.16/4",
        "a search is Accepted while quenching",
        Frame(|_, sim, asked| {
            let busy = flags(sim, S::CONTROL) & ControlFlags::QUENCH.bits() != 0;
            instead(sim, asked, |rec| busy && rec.request == R::START_SEEK, Status::ACCEPTED)
        }),
    ),
    wrong(
        "§3.16/4",
        "a second StartSeek is Busy",
        Frame(|_, sim, asked| {
            let busy = state(sim).contains(D::SEARCHING);
            instead(sim, asked, |rec| busy && rec.request == R::START_SEEK, Status::BUSY)
        }),
    ),
    wrong(
        "§3.16/6",
        "analyse 2 is taken for 1",
        Request(|_, rec| {
            if rec.request == R::START_SEEK && rec.data.len() == 10 && rec.data[8] > 1 {
                rec.data[8..].copy_from_slice(&[1, 0]);
            }
        }),
    ),
    wrong(
        "§3.16/6",
        "only the low byte of analyse is checked",
        Request(|_, rec| {
            if rec.request == R::START_SEEK && rec.data.len() == 10 {
                rec.data[9] = 0;
            }
        }),
    ),
    wrong(
        "§3.16/7",
        "Canceled is not reported",
        Answer(|_, _, answers| hide(answers, D::CANCELED)),
    ),
    wrong(
        "§3.16/7",
        "Canceled stays for good",
        Answer(|memory, _, answers| {
            let canceled = D::CANCELED.bits();
            memory.on |= answers
                .iter()
                .any(|rec| rec.device == S::DETECTOR && rec.flags().unwrap_or(0) & canceled != 0);
            if memory.on {
                reflag(answers, S::DETECTOR, |flags| flags | canceled);
            }
        }),
    ),
    wrong(
        "§3.1/2",
        "Move is Accepted while searching",
        Frame(|_, sim, asked| lets(sim, asked, |rec| rec.request == R::MOVE)),
    ),
    wrong(
        "§3.1/2",
        "Move ends the search",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::MOVE) && answers[0].device == S::DETECTOR {
                secretly(sim, R::STOP, S::DETECTOR, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.2/3",
        "Stop to a drive is Accepted while searching",
        Frame(|_, sim, asked| {
            lets(sim, asked, |rec| rec.request == R::STOP && rec.device.is_drive())
        }),
    ),
    wrong(
        "§3.2/3",
        "Stop Detector is Ok and the search goes on",
        Frame(|_, sim, asked| {
            instead(
                sim,
                asked,
                |rec| rec.request == R::STOP && rec.device == S::DETECTOR,
                Status::OK,
            )
        }),
    ),
    wrong(
        "§3.8/2",
        "Open is Accepted while searching",
        Frame(|_, sim, asked| lets(sim, asked, |rec| rec.request == R::OPEN)),
    ),
    wrong(
        "§3.8/2",
        "Open while searching is Denied from the valve",
        Answer(|_, asked, answers| {
            if asks(asked, R::OPEN) && answers[0].device == S::DETECTOR {
                answers[0].device = asked[0].device;
            }
        }),
    ),
    wrong(
        "§3.9/1",
        "Close is Accepted while searching",
        Frame(|_, sim, asked| lets(sim, asked, |rec| rec.request == R::CLOSE)),
    ),
    wrong(
        "§3.11/7",
        "Wrap is Accepted while searching",
        Frame(|_, sim, asked| lets(sim, asked, |rec| rec.request == R::WRAP)),
    ),
    wrong(
        "§3.13",
        "StartJustify takes data",
        Request(|_, rec| {
            if rec.request == R::START_JUSTIFY {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§3.13/1",
        "Justifying does not end",
        Answer(|memory, asked, answers| {
            memory.on |= asks(asked, R::START_JUSTIFY);
            if memory.on {
                reflag(answers, S::DETECTOR, |flags| flags | D::JUSTIFYING.bits());
            }
        }),
    ),
    wrong(
        "§3.13/1",
        "StartJustify is Accepted and nothing happens",
        Frame(|_, sim, asked| {
            instead(
                sim,
                asked,
                |rec| rec.request == R::START_JUSTIFY && rec.data.is_empty(),
                Status::ACCEPTED,
            )
        }),
    ),
    wrong(
        "§3.13/2",
        "StartJustify deploys",
        Frame(|_, sim, asked| {
            if is_wrapped(sim) && asks(asked, R::START_JUSTIFY) {
                secretly(sim, R::DEPLOY, S::DEPLOYER, &[]);
                return vec![says(&asked[0], S::DETECTOR, Status::ACCEPTED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.13/2",
        "StartJustify while quenching is Denied from Detector",
        Answer(|_, asked, answers| {
            if asks(asked, R::START_JUSTIFY) && answers[0].status == Status::DENIED {
                answers[0].device = S::DETECTOR;
            }
        }),
    ),
    wrong(
        "§3.13/3",
        "Move is Accepted while it aligns itself",
        Frame(|_, sim, asked| {
            let busy = state(sim).contains(D::JUSTIFYING);
            instead(sim, asked, |rec| busy && rec.request == R::MOVE, Status::ACCEPTED)
        }),
    ),
];
