//! Wrong records.

use lafet_conform::raw::Rec;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, asks, each, in_profile, pass, restate, says, wrong};

pub const WRONG: &[Wrong] = &[
    wrong(
        "§1",
        "Climatics answers under the id 0x63",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.device == S::ALL) {
                each(answers, R::GET_STATUS, |rec| {
                    if rec.device == S::CLIMATICS {
                        rec.device = S(0x63);
                    }
                });
            }
        }),
    ),
    wrong(
        "§1/1",
        "answers to All come in the order of the table",
        Answer(|_, _, answers| {
            answers.reverse();
        }),
    ),
    wrong(
        "§1/1",
        "General answers to All first",
        Answer(|_, asked, answers| {
            if asked.len() == 1 && answers.len() > 2 {
                answers.rotate_right(1);
            }
        }),
    ),
    wrong(
        "§1/1",
        "Valve1 comes before Valve2",
        Answer(|_, _, answers| {
            let place = |id| answers.iter().position(|rec: &Rec| rec.device == id);
            if let (Some(one), Some(two)) = (place(S::VALVE1), place(S::VALVE2)) {
                answers.swap(one, two);
            }
        }),
    ),
    wrong(
        "§1/3",
        "an unknown device id is answered by General as itself",
        Answer(|_, _, answers| {
            for rec in answers {
                if rec.status == Status::MODULE_NOT_EXIST {
                    rec.device = S::GENERAL;
                }
            }
        }),
    ),
    in_profile(
        "remote",
        wrong(
            "§1/3",
            "an absent subsystem answers WrongRequest",
            Answer(|_, asked, answers| {
                for rec in answers {
                    // Its GetStatus still reports that it is absent.
                    if rec.status == Status::MODULE_NOT_EXIST && !asks(asked, R::GET_STATUS) {
                        rec.status = Status::WRONG_REQUEST;
                    }
                }
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.2/7",
            "Stop to an absent subsystem is Ok",
            Answer(|_, _, answers| {
                restate(answers, R::STOP, Status::MODULE_NOT_EXIST, Status::OK);
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.1/6",
            "Move to an absent drive is Denied",
            Answer(|_, _, answers| {
                restate(answers, R::MOVE, Status::MODULE_NOT_EXIST, Status::DENIED);
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.10/5",
            "Deploy without Deployer is Ok",
            Answer(|_, _, answers| {
                restate(answers, R::DEPLOY, Status::MODULE_NOT_EXIST, Status::OK);
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.11/5",
            "Wrap without Deployer is Ok",
            Answer(|_, _, answers| {
                restate(answers, R::WRAP, Status::MODULE_NOT_EXIST, Status::OK);
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.8/5",
            "Open of an absent valve is WrongRequest",
            Answer(|_, _, answers| {
                restate(answers, R::OPEN, Status::MODULE_NOT_EXIST, Status::WRONG_REQUEST);
            }),
        ),
    ),
    in_profile(
        "remote",
        wrong(
            "§3.9/4",
            "Close of an absent valve is Accepted",
            Answer(|_, _, answers| {
                restate(answers, R::CLOSE, Status::MODULE_NOT_EXIST, Status::ACCEPTED);
            }),
        ),
    ),
    wrong(
        "§1/4",
        "an unknown request is answered by its addressee",
        Answer(|_, asked, answers| {
            for (rec, asked) in answers.iter_mut().zip(asked) {
                if rec.status == Status::WRONG_REQUEST
                    && asked.request.name().is_none()
                    && asked.device != S::ALL
                {
                    rec.device = asked.device;
                }
            }
        }),
    ),
    wrong(
        "§1/4",
        "an unknown request is answered Unimplemented",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.request.name().is_none()) {
                answers.iter_mut().for_each(|rec| rec.status = Status::UNIMPLEMENTED);
            }
        }),
    ),
    wrong(
        "§1/4",
        "an unknown request is answered Ok",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.request.name().is_none()) {
                answers.iter_mut().for_each(|rec| rec.status = Status::OK);
            }
        }),
    ),
    wrong(
        "§1/5",
        "Radio does not answer to All",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.device == S::ALL) {
                answers.retain(|rec| rec.device != S::RADIO);
            }
        }),
    ),
    wrong(
        "§1/5",
        "Horizontal answers to All twice",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.device == S::ALL)
                && let Some(at) = answers.iter().position(|rec| rec.device == S::HORIZONTAL)
            {
                let again = answers[at].clone();
                answers.insert(at, again);
            }
        }),
    ),
    wrong(
        "§1/5",
        "All is answered by General alone",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.device == S::ALL) {
                answers.retain(|rec| rec.device == S::GENERAL);
            }
        }),
    ),
    wrong(
        "§1/6",
        "Motors leaves Deployer out",
        Answer(|_, asked, answers| {
            if asked.iter().any(|rec| rec.device == S::MOTORS) {
                answers.retain(|rec| rec.device != S::DEPLOYER);
            }
        }),
    ),
    wrong(
        "§1/6",
        "Motors is an unknown device",
        Frame(|_, sim, asked| {
            if asked.iter().any(|rec| rec.device == S::MOTORS) {
                return vec![says(&asked[0], S::MOTORS, Status::MODULE_NOT_EXIST)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§1/7",
        "GetParam All is answered by General as its own",
        Request(|_, rec| {
            if rec.request == R::GET_PARAM && rec.device == S::ALL {
                rec.device = S::GENERAL;
            }
        }),
    ),
    wrong(
        "§1/7",
        "Move All moves Horizontal",
        Frame(|_, sim, asked| {
            if asked[0].request == R::MOVE && asked[0].device == S::ALL {
                pass(sim, &[Rec::new(R::MOVE, S::HORIZONTAL, &[0, 0x10])]);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§1/8",
        "only the first of several requests is executed",
        Frame(|_, sim, asked| pass(sim, &asked[..1])),
    ),
    wrong(
        "§1/8",
        "several requests are executed last to first",
        Frame(|_, sim, asked| {
            let mut turned = asked.to_vec();
            turned.reverse();
            let mut answers = pass(sim, &turned);
            if asked.len() < 10 {
                answers.reverse();
            }
            answers
        }),
    ),
    wrong(
        "§1/9",
        "answers without room are left out, without NoRoom",
        Answer(|_, _, answers| {
            answers.retain(|rec| rec.status != Status::NO_ROOM);
        }),
    ),
    wrong(
        "§1/9",
        "the subsystem says NoRoom, General does not",
        Answer(|_, _, answers| {
            if answers.last().is_some_and(|rec| rec.status == Status::NO_ROOM) {
                answers.pop();
            }
        }),
    ),
    wrong(
        "§1/9",
        "NoRoom once for every request left",
        Answer(|_, _, answers| {
            if let Some(last) = answers.last().filter(|rec| rec.status == Status::NO_ROOM).cloned()
            {
                answers.push(last);
            }
        }),
    ),
    wrong(
        "§1/9",
        "requests without room are executed",
        Frame(|_, sim, asked| {
            let answers = pass(sim, asked);
            if answers.iter().any(|rec| rec.status == Status::NO_ROOM) {
                for rec in asked.iter().filter(|rec| rec.request == R::MOVE) {
                    pass(sim, std::slice::from_ref(rec));
                }
            }
            answers
        }),
    ),
    wrong(
        "§1/9",
        "Stop All after NoRoom is not executed",
        Frame(|_, sim, asked| {
            if asked.len() > 50 {
                let without: Vec<Rec> =
                    asked.iter().filter(|rec| rec.request != R::STOP).cloned().collect();
                return pass(sim, &without);
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§1/11",
        "the size is checked before the addressee",
        Answer(|_, asked, answers| {
            if asked[0].request == R::GET_HOTBED && !asked[0].data.is_empty() {
                answers.iter_mut().for_each(|rec| rec.status = Status::WRONG_DATA);
            }
        }),
    ),
    wrong(
        "§1/11",
        "the addressee is checked before the request",
        Answer(|_, asked, answers| {
            if asked[0].request.name().is_none() && asked[0].device == S(0) {
                answers[0] = says(&asked[0], S(0), Status::MODULE_NOT_EXIST);
            }
        }),
    ),
    wrong(
        "§1/12",
        "a wrong addressee answers NotSupported",
        Answer(|_, asked, answers| {
            if asked[0].request == R::GET_CRASH_DATA {
                restate(answers, R::GET_CRASH_DATA, Status::WRONG_REQUEST, Status::NOT_SUPPORTED);
            }
        }),
    ),
    wrong(
        "§2",
        "the request id of an answer has bit 7 set",
        Answer(|_, _, answers| {
            answers.iter_mut().for_each(|rec| rec.request.0 |= 0x80);
        }),
    ),
    wrong(
        "§2/1",
        "a request whose status is not 0 is refused",
        Frame(|_, sim, asked| {
            if asked[0].status != Status::OK {
                return vec![says(&asked[0], S::GENERAL, Status::WRONG_DATA)];
            }
            pass(sim, asked)
        }),
    ),
    wrong(
        "§2/1",
        "the status of the request comes back",
        Answer(|_, asked, answers| {
            if asked[0].status != Status::OK {
                answers[0].status = asked[0].status;
            }
        }),
    ),
    wrong(
        "§2/3",
        "data too long is cut",
        Request(|_, rec| {
            if rec.request == R::GET_STATUS {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§2/3",
        "GetParam takes a third byte",
        Request(|_, rec| {
            if rec.request == R::GET_PARAM {
                rec.data.truncate(2);
            }
        }),
    ),
    wrong(
        "§2/3",
        "a wrong size is InvalidValue",
        Answer(|_, _, answers| {
            for rec in answers {
                if rec.status == Status::WRONG_DATA {
                    rec.status = Status::INVALID_VALUE;
                }
            }
        }),
    ),
    wrong(
        "§2/5",
        "refusals have statuses over 18",
        Answer(|_, _, answers| {
            for rec in answers {
                if rec.status == Status::WRONG_REQUEST {
                    rec.status = Status(0x87);
                }
            }
        }),
    ),
];
