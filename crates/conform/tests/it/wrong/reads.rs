//! Wrong answers to reads.

use lafet_proto::flags::ValveFlags;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};

use super::Rule::{Answer, Frame, Request};
use super::{Wrong, each, in_profile, pass, reflag, restate, says, wrong};

pub const WRONG: &[Wrong] = &[
    wrong(
        "§3.3",
        "the status of General lacks the flow",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::GENERAL {
                    rec.data.truncate(8);
                }
            });
        }),
    ),
    wrong(
        "§3.3",
        "the status of a drive has an attribute byte",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device.is_drive() {
                    rec.data.push(0);
                }
            });
        }),
    ),
    wrong(
        "§3.3",
        "the status of a valve has 8 bytes",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device.is_valve() {
                    rec.data.extend([0; 4]);
                }
            });
        }),
    ),
    wrong(
        "§3.3",
        "Buttons do not answer GetStatus",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::BUTTONS {
                    *rec = says(&rec.clone(), S::BUTTONS, Status::UNIMPLEMENTED);
                }
            });
        }),
    ),
    wrong(
        "§3.3/1",
        "to All the flags are the common ones only",
        Answer(|_, asked, answers| {
            if asked[0].device == S::ALL {
                for id in S::CHAIN {
                    reflag(answers, id, |flags| flags & 0xFFFF);
                }
            }
        }),
    ),
    wrong(
        "§3.3.1",
        "the flags are sent high byte first",
        Answer(|_, _, answers| {
            for id in S::CHAIN {
                reflag(answers, id, u32::swap_bytes);
            }
        }),
    ),
    wrong(
        "§3.3.1",
        "the reserved bit is set",
        Answer(|_, _, answers| {
            reflag(answers, S::CONTROL, |flags| flags | 0x8000);
        }),
    ),
    wrong(
        "§3.3.2",
        "General sets bit 19",
        Answer(|_, _, answers| {
            reflag(answers, S::GENERAL, |flags| flags | 1 << 19);
        }),
    ),
    wrong(
        "§3.3.2",
        "the supply is reported as 0 V",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::GENERAL {
                    rec.data[4..6].fill(0);
                }
            });
        }),
    ),
    wrong(
        "§3.3.3",
        "humidity in 0.1 %",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::CLIMATICS {
                    rec.data[14..16].copy_from_slice(&450_u16.to_le_bytes());
                }
            });
        }),
    ),
    wrong(
        "§3.3.4",
        "a drive sets bit 31",
        Answer(|_, _, answers| {
            reflag(answers, S::VERTICAL, |flags| flags | 1 << 31);
        }),
    ),
    wrong(
        "§3.3.4/2",
        "the speed at rest is the speed of the parameter",
        Answer(|_, _, answers| {
            each(answers, R::GET_STATUS, |rec| {
                if rec.device == S::NOZZLE {
                    rec.data[7] = 10;
                }
            });
        }),
    ),
    wrong(
        "§3.3.5",
        "a closed valve is open too",
        Answer(|_, _, answers| {
            reflag(answers, S::VALVE2, |flags| flags | ValveFlags::OPEN.bits());
        }),
    ),
    wrong(
        "§3.3.7",
        "Detector sets bit 24",
        Answer(|_, _, answers| {
            reflag(answers, S::DETECTOR, |flags| flags | 1 << 24);
        }),
    ),
    wrong(
        "§3.3.8",
        "wrapped is reported as deployed too",
        Answer(|_, _, answers| {
            reflag(answers, S::DEPLOYER, |flags| flags | 1 << 28);
        }),
    ),
    wrong(
        "§3.3.9",
        "ConnLost is never set",
        Answer(|_, _, answers| {
            for id in [S::RADIO, S::EXTERNAL_CONN] {
                reflag(answers, id, |flags| flags & !8);
            }
        }),
    ),
    wrong(
        "§3.3.9",
        "ConnLost is always set",
        Answer(|_, _, answers| {
            for id in [S::RADIO, S::EXTERNAL_CONN] {
                reflag(answers, id, |flags| flags | 8);
            }
        }),
    ),
    wrong(
        "§3.3.9/1",
        "a status poll counts as control",
        Frame(|memory, sim, asked| {
            let mut answers = pass(sim, asked);
            if asked.iter().any(|rec| rec.device == S::GENERAL) {
                memory.on = true;
            }
            if memory.on {
                reflag(&mut answers, S::EXTERNAL_CONN, |flags| flags & !8);
            }
            answers
        }),
    ),
    wrong(
        "§3.3.10",
        "the buttons are reported in single bits",
        Answer(|_, _, answers| {
            reflag(answers, S::BUTTONS, |flags| flags | 0x0055_0000);
        }),
    ),
    wrong(
        "§3.4",
        "the answer of GetParam lacks the id",
        Answer(|_, _, answers| {
            each(answers, R::GET_PARAM, |rec| {
                if rec.status == Status::OK {
                    rec.data.drain(..2);
                }
            });
        }),
    ),
    wrong(
        "§3.4",
        "values of parameters are int16",
        Answer(|_, _, answers| {
            each(answers, R::GET_PARAM, |rec| {
                if rec.data.len() == 6 {
                    rec.data.truncate(4);
                }
            });
        }),
    ),
    wrong(
        "§3.4/1",
        "an unknown parameter is InvalidValue",
        Answer(|_, _, answers| {
            restate(answers, R::GET_PARAM, Status::INVALID_ID, Status::INVALID_VALUE);
        }),
    ),
    wrong(
        "§3.4/1",
        "an unknown parameter reads as 0",
        Answer(|_, _, answers| {
            each(answers, R::GET_PARAM, |rec| {
                if rec.status == Status::INVALID_ID {
                    rec.status = Status::OK;
                    rec.data.extend([0; 4]);
                }
            });
        }),
    ),
    wrong(
        "§3.4/1",
        "InvalidId comes without the id",
        Answer(|_, _, answers| {
            each(answers, R::GET_PARAM, |rec| {
                if rec.status == Status::INVALID_ID {
                    rec.data.clear();
                }
            });
        }),
    ),
    in_profile(
        "ex",
        wrong(
            "§3.4/2",
            "a remote parameter is never fetched",
            Answer(|_, asked, answers| {
                let speed = lafet_proto::ParamId::of("Speed").0.to_le_bytes();
                if asked[0].request == R::GET_PARAM && asked[0].data == speed {
                    each(answers, R::GET_PARAM, |rec| {
                        rec.status = Status::NOT_CACHED;
                        rec.data.truncate(2);
                    });
                }
            }),
        ),
    ),
    wrong(
        "§P/1",
        "the parameter Height is missing",
        Answer(|_, asked, answers| {
            let height = lafet_proto::ParamId::of("Height").0.to_le_bytes();
            if asked[0].data.starts_with(&height) {
                each(answers, R::GET_PARAM, |rec| {
                    rec.status = Status::INVALID_ID;
                    rec.data.truncate(2);
                });
            }
        }),
    ),
    wrong(
        "§3.7",
        "limits are int16",
        Answer(|_, _, answers| {
            each(answers, R::RETRIEVE_LIMITS, |rec| rec.data.truncate(4));
        }),
    ),
    wrong(
        "§3.7",
        "max comes before min",
        Answer(|_, _, answers| {
            each(answers, R::RETRIEVE_LIMITS, |rec| {
                if rec.data.len() == 8 {
                    rec.data.rotate_left(4);
                }
            });
        }),
    ),
    wrong(
        "§3.7/1",
        "RetrieveLimits All leaves Deployer out",
        Answer(|_, asked, answers| {
            if asked[0].device == S::ALL {
                answers
                    .retain(|rec| rec.request != R::RETRIEVE_LIMITS || rec.device != S::DEPLOYER);
            }
        }),
    ),
    wrong(
        "§3.20",
        "the crash data lacks its union",
        Answer(|_, _, answers| {
            each(answers, R::GET_CRASH_DATA, |rec| rec.data.truncate(40));
        }),
    ),
    wrong(
        "§3.20/1",
        "GetCrashData differs from FaultInfo",
        Answer(|_, _, answers| {
            each(answers, R::GET_CRASH_DATA, |rec| {
                if let Some(byte) = rec.data.first_mut() {
                    *byte ^= 1;
                }
            });
        }),
    ),
    wrong(
        "§3.21",
        "hotbeds have 16 bytes",
        Answer(|_, asked, answers| {
            if asked[0].data == [0xFE, 0x23] {
                each(answers, R::GET_PARAM, |rec| rec.data.extend([0; 16]));
            }
        }),
    ),
    wrong(
        "§3.21",
        "there are five hotbeds",
        Answer(|_, asked, answers| {
            if asked[0].data == [0xFE, 0x23] {
                each(answers, R::GET_PARAM, |rec| rec.data.extend([0; 100]));
            }
        }),
    ),
    wrong(
        "§3.21/2",
        "GetHotbed is an unknown request",
        Answer(|_, asked, answers| {
            if asked[0].request == R::GET_HOTBED {
                answers[0] = says(&asked[0], S::GENERAL, Status::WRONG_REQUEST);
            }
        }),
    ),
    wrong(
        "§3.3/2",
        "RetrieveLimits is Denied while wrapped",
        Answer(|_, asked, answers| {
            if asked[0].request == R::RETRIEVE_LIMITS {
                answers.iter_mut().for_each(|rec| *rec = says(rec, S::DEPLOYER, Status::DENIED));
            }
        }),
    ),
    wrong(
        "§3.2",
        "Stop takes data",
        Request(|_, rec| {
            if rec.request == R::STOP {
                rec.data.clear();
            }
        }),
    ),
    wrong(
        "§3.2",
        "the answer to Stop has a byte of data",
        Answer(|_, _, answers| {
            each(answers, R::STOP, |rec| rec.data.push(0));
        }),
    ),
    wrong(
        "§3.2/1",
        "Stop All is answered by drives alone",
        Answer(|_, asked, answers| {
            if asked[0].request == R::STOP && asked[0].device == S::ALL {
                answers.retain(|rec| rec.device.is_drive());
            }
        }),
    ),
    wrong(
        "§3.2/6",
        "General answers Stop with Ok",
        Answer(|_, _, answers| {
            restate(answers, R::STOP, Status::WRONG_REQUEST, Status::OK);
        }),
    ),
    wrong(
        "§1/8",
        "several requests have one answer",
        Answer(|_, asked, answers| {
            for rec in answers.iter_mut() {
                rec.request = asked[0].request;
            }
            if asked.len() > 1 {
                answers.truncate(1);
            }
        }),
    ),
];
