//! Monitors that fold and unfold wrongly.

use lafet_conform::raw::Rec;
use lafet_proto::flags::DeployerFlags as F;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, asks, each, flags, instead, pass, reflag, restate, says, secretly, wrong};

const FOUR: u32 = F::DEPLOYED.bits() | F::DEPLOYING.bits() | F::WRAPPED.bits() | F::WRAPPING.bits();

fn is(sim: &mut Sim, state: F) -> bool {
    flags(sim, S::DEPLOYER) & FOUR == state.bits()
}

fn to(request: R) -> impl Fn(&Rec) -> bool {
    move |rec| rec.request == request && rec.device == S::DEPLOYER
}

pub const WRONG: &[Wrong] = &[
    wrong(
        "§1/2",
        "an interceptor refuses in the name of the addressee",
        Answer(|_, asked, answers| {
            if asked[0].request == R::MOVE && answers[0].status == Status::DENIED {
                answers[0].device = asked[0].device;
            }
        }),
    ),
    wrong(
        "§3.1/1",
        "Move is Accepted while wrapped",
        Answer(|_, asked, answers| {
            if asked[0].request == R::MOVE && answers[0].status == Status::DENIED {
                answers[0] = says(&asked[0], asked[0].device, Status::ACCEPTED);
            }
        }),
    ),
    wrong(
        "§3.1/1",
        "Move is Busy while wrapped",
        Answer(|_, _, answers| {
            restate(answers, R::MOVE, Status::DENIED, Status::BUSY);
        }),
    ),
    wrong(
        "§3.1/1",
        "Move is remembered while wrapped",
        Frame(|memory, sim, asked| {
            let answers = pass(sim, asked);
            if asks(asked, R::MOVE)
                && asked[0].device == S::HORIZONTAL
                && answers[0].status == Status::DENIED
            {
                memory.kept = Some(asked[0].clone());
            }
            if is(sim, F::DEPLOYED) {
                pass(sim, memory.kept.take().as_slice());
            }
            answers
        }),
    ),
    wrong(
        "§3.1/1",
        "aiming is allowed in between",
        Frame(|_, sim, asked| {
            let between = is(sim, F::empty());
            instead(sim, asked, |rec| between && rec.request == R::MOVE, Status::ACCEPTED)
        }),
    ),
    wrong(
        "§1/11",
        "the size of Move is checked before interception",
        Answer(|_, asked, answers| {
            if asked[0].request == R::MOVE && asked[0].data.len() != 2 {
                answers[0] = says(&asked[0], asked[0].device, Status::WRONG_DATA);
            }
        }),
    ),
    wrong(
        "§3.10",
        "Deploy takes data",
        Request(|_, rec| {
            if rec.request == R::DEPLOY {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§3.10/1",
        "Deploy is Ok at once",
        Answer(|_, _, answers| {
            restate(answers, R::DEPLOY, Status::ACCEPTED, Status::OK);
        }),
    ),
    wrong(
        "§3.10/1",
        "Deploy while deploying is Busy",
        Frame(|_, sim, asked| {
            let busy = is(sim, F::DEPLOYING);
            instead(sim, asked, |rec| busy && to(R::DEPLOY)(rec), Status::BUSY)
        }),
    ),
    wrong(
        "§3.10/1",
        "Deploy is Accepted and nothing happens",
        Frame(|_, sim, asked| {
            let wrapped = is(sim, F::WRAPPED);
            let whole = |rec: &Rec| rec.data.is_empty();
            instead(sim, asked, |rec| wrapped && whole(rec) && to(R::DEPLOY)(rec), Status::ACCEPTED)
        }),
    ),
    wrong(
        "§3.10/1",
        "deploying stops halfway",
        Frame(|memory, sim, asked| {
            if asks(asked, R::DEPLOY) {
                memory.at_ms = sim.now_ms();
            }
            if sim.now_ms() > memory.at_ms + 3000 && is(sim, F::DEPLOYING) {
                secretly(sim, R::STOP, S::DEPLOYER, &[]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.10/1",
        "Deploying is not reported",
        Answer(|_, _, answers| {
            reflag(answers, S::DEPLOYER, |flags| flags & !F::DEPLOYING.bits());
        }),
    ),
    wrong(
        "§3.10/1",
        "Deployed is reported while it deploys",
        Answer(|_, _, answers| {
            reflag(answers, S::DEPLOYER, |flags| match flags & F::DEPLOYING.bits() {
                0 => flags,
                _ => flags & !FOUR | F::DEPLOYED.bits(),
            });
        }),
    ),
    wrong(
        "§3.10/2",
        "Deploy of a deployed monitor is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::DEPLOY, Status::OK, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.10/2",
        "Deploy of a deployed monitor is Denied",
        Answer(|_, _, answers| {
            restate(answers, R::DEPLOY, Status::OK, Status::DENIED);
        }),
    ),
    wrong(
        "§3.10/3",
        "an overloaded Deployer takes Deploy",
        Answer(|_, _, answers| {
            restate(answers, R::DEPLOY, Status::MODULE_FAULT, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.11/3",
        "an overloaded Deployer takes Wrap",
        Answer(|_, _, answers| {
            restate(answers, R::WRAP, Status::MODULE_FAULT, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.10/4",
        "Deploy of a drive deploys",
        Request(|_, rec| {
            if rec.request == R::DEPLOY && rec.device == S::VERTICAL {
                rec.device = S::DEPLOYER;
            }
        }),
    ),
    wrong(
        "§3.11/4",
        "Wrap of a valve is NotSupported",
        Answer(|_, _, answers| {
            restate(answers, R::WRAP, Status::WRONG_REQUEST, Status::NOT_SUPPORTED);
        }),
    ),
    wrong(
        "§3.11",
        "Wrap takes data",
        Request(|_, rec| {
            if rec.request == R::WRAP {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§3.11/1",
        "Wrap while deploying is Denied",
        Frame(|_, sim, asked| {
            let busy = is(sim, F::DEPLOYING);
            instead(sim, asked, |rec| busy && to(R::WRAP)(rec), Status::DENIED)
        }),
    ),
    wrong(
        "§3.11/1",
        "Wrap while deploying is Accepted and it deploys on",
        Frame(|_, sim, asked| {
            let busy = is(sim, F::DEPLOYING);
            instead(sim, asked, |rec| busy && to(R::WRAP)(rec), Status::ACCEPTED)
        }),
    ),
    wrong(
        "§3.11/2",
        "Wrap of a wrapped monitor is Accepted",
        Answer(|_, _, answers| {
            restate(answers, R::WRAP, Status::OK, Status::ACCEPTED);
        }),
    ),
    wrong(
        "§3.2/2",
        "while deploying, Stop to a drive is Ok",
        Frame(|_, sim, asked| {
            let busy = is(sim, F::DEPLOYING);
            instead(
                sim,
                asked,
                |rec| {
                    busy && rec.request == R::STOP
                        && rec.device.is_drive()
                        && rec.device != S::DEPLOYER
                },
                Status::OK,
            )
        }),
    ),
    wrong(
        "§3.2/2",
        "Stop Deployer is Ok and it deploys on",
        Frame(|_, sim, asked| instead(sim, asked, to(R::STOP), Status::OK)),
    ),
    wrong(
        "§3.2/2",
        "stopped in between, it is reported as wrapped",
        Answer(|_, _, answers| {
            reflag(answers, S::DEPLOYER, |flags| match flags & FOUR {
                0 => flags | F::WRAPPED.bits(),
                _ => flags,
            });
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All does not end deploying",
        Frame(|_, sim, asked| {
            let busy = is(sim, F::DEPLOYING);
            let answers = pass(sim, asked);
            if busy && asked[0].request == R::STOP && asked[0].device == S::ALL {
                secretly(sim, R::DEPLOY, S::DEPLOYER, &[]);
            }
            answers
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All is Denied while wrapping",
        Frame(|_, sim, asked| {
            if is(sim, F::WRAPPING) && asked[0].request == R::STOP && asked[0].device == S::ALL {
                return vec![says(&asked[0], S::DEPLOYER, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.3.8/1",
        "Deploying and Wrapping are reported together",
        Answer(|_, _, answers| {
            reflag(answers, S::DEPLOYER, |flags| match flags & F::WRAPPING.bits() {
                0 => flags,
                _ => flags | F::DEPLOYING.bits(),
            });
        }),
    ),
    wrong(
        "§3.9/6",
        "Close is Denied while wrapped",
        Frame(|_, sim, asked| {
            if is(sim, F::WRAPPED) && asks(asked, R::CLOSE) {
                return vec![says(&asked[0], S::DEPLOYER, Status::DENIED)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§3.1/9",
        "Move Deployer is Denied when deployed",
        Frame(|_, sim, asked| instead(sim, asked, to(R::MOVE), Status::DENIED)),
    ),
    wrong(
        "§3.3",
        "Deployer reports no position",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::DEPLOYER {
                    rec.data.truncate(4);
                }
            });
        }),
    ),
];
