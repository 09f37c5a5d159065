//! §1, §2: the chain and the record, by reads only.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::literal::{GET_CRASH_DATA_GENERAL, GET_STATUS_GENERAL};
use crate::bench::{Bench, list};
use crate::raw::Rec;
use crate::verdict::{Step, must, not_applicable};

/// Ids that are in no table.
pub const UNKNOWN_DEVICES: [S; 4] = [S(0x00), S(0x01), S(0xFE), S(0xFF)];
const UNKNOWN_REQUESTS: [R; 3] = [R(0x00), R(0x01), R(0xFF)];

fn devices(records: &[Rec]) -> Vec<S> {
    records.iter().map(|rec| rec.device).collect()
}

fn group(b: &mut Bench<'_>, request: R, to: S) -> Step<Vec<Rec>> {
    let records = b.frame(&Rec::new(request, to, &[]).bytes())?;
    if records.iter().any(|rec| rec.status == Status::NO_ROOM) {
        return not_applicable(text::AnswersDoNotFit);
    }
    let strange = records.iter().any(|rec| rec.request != request);
    must(!strange, text::AnswersToThisRequest, list(&records))?;
    Ok(records)
}

/// §1 Subsystems that answer All have an id of the table, and answer under it.
pub fn ids(b: &mut Bench<'_>) -> Step {
    let all = group(b, R::GET_STATUS, S::ALL)?;
    let found = devices(&all);
    let known = found.iter().all(|id| S::CHAIN.contains(id));
    must(known, text::IdsOfTable, list(&all))?;
    must(b.has(S::GENERAL), text::GeneralAnswers, "ModuleNotExist")
}

/// §1/1
pub fn chain_order(b: &mut Bench<'_>) -> Step {
    let all = group(b, R::GET_STATUS, S::ALL)?;
    let place = |id: &S| S::CHAIN.iter().position(|known| known == id);
    let found = devices(&all);
    must(found.is_sorted_by(|a, b| place(a) < place(b)), text::GeneralAnswersLast, list(&all))
}

/// §1/3
pub fn absent(b: &mut Bench<'_>) -> Step {
    let absent: Vec<S> = S::CHAIN.into_iter().filter(|id| !b.has(*id)).collect();
    for id in absent {
        b.refused(R::GET_STATUS, id, &[], id, Status::MODULE_NOT_EXIST)?;
        b.refused(R::GET_PARAM, id, &[0xFE, 0x23], id, Status::MODULE_NOT_EXIST)?;
        b.refused(R::STOP, id, &[], id, Status::MODULE_NOT_EXIST)?;
    }
    Ok(())
}

/// §1/3: an id that is in no table (ours).
pub fn unknown_device(b: &mut Bench<'_>) -> Step {
    for id in UNKNOWN_DEVICES {
        b.refused(R::GET_STATUS, id, &[], id, Status::MODULE_NOT_EXIST)?;
    }
    Ok(())
}

/// §1/4
pub fn unknown_request(b: &mut Bench<'_>) -> Step {
    for request in UNKNOWN_REQUESTS {
        for to in [S::GENERAL, S::HORIZONTAL, S::ALL] {
            b.refused(request, to, &[], S::GENERAL, Status::WRONG_REQUEST)?;
        }
    }
    Ok(())
}

/// §1/5
pub fn all(b: &mut Bench<'_>) -> Step {
    let all = group(b, R::GET_STATUS, S::ALL)?;
    let mut present = b.found.present.clone();
    let mut found = devices(&all);
    present.sort();
    found.sort();
    must(present == found, text::EachAnswersToAll, list(&all))?;
    let crash = group(b, R::GET_CRASH_DATA, S::ALL)?;
    must(devices(&crash) == [S::GENERAL], text::GeneralAlone, list(&crash))
}

/// §1/6
pub fn motors(b: &mut Bench<'_>) -> Step {
    for request in [R::GET_STATUS, R::RETRIEVE_LIMITS] {
        let found = group(b, request, S::MOTORS)?;
        let drives: Vec<S> = b.found.present.iter().copied().filter(|id| id.is_drive()).collect();
        if drives.is_empty() {
            must(devices(&found) == [S::GENERAL], Shown("General"), list(&found))?;
            continue;
        }
        must(devices(&found) == drives, text::EveryDriveInOrder, list(&found))?;
    }
    Ok(())
}

/// §1/7
pub fn all_unhandled(b: &mut Bench<'_>) -> Step {
    for to in [S::ALL, S::MOTORS] {
        b.refused(R::GET_PARAM, to, &[0xFE, 0x23], S::GENERAL, Status::WRONG_REQUEST)?;
        b.refused(R::GET_HOTBED, to, &[], S::GENERAL, Status::WRONG_REQUEST)?;
    }
    Ok(())
}

/// §1/8
pub fn several(b: &mut Bench<'_>) -> Step {
    b.several()?;
    let asked = [S::GENERAL, S(0x00), S::GENERAL, S(0x01), S(0xFE)];
    let payload: Vec<u8> =
        asked.iter().flat_map(|id| Rec::new(R::GET_STATUS, *id, &[]).bytes()).collect();
    let records = b.frame(&payload)?;
    must(devices(&records) == asked, text::AnswerToEachRequest, list(&records))
}

/// §1/9
pub fn no_room(b: &mut Bench<'_>) -> Step {
    b.several()?;
    let one = Rec::new(R::GET_STATUS, S::ALL, &[]).bytes();
    let payload = one.repeat(60);
    let records = b.frame(&payload)?;
    let full: Vec<&Rec> = records.iter().filter(|rec| rec.status == Status::NO_ROOM).collect();
    if full.is_empty() {
        let answers = records.len() == 60 * b.found.present.len();
        return must(answers, text::AllAnswersOrNoRoom, list(&records));
    }
    must(
        full.len() <= 2 && full.last().is_some_and(|rec| rec.device == S::GENERAL),
        text::TwoNoRooms,
        list(&records[records.len().saturating_sub(4)..]),
    )?;
    let tail = records.iter().skip_while(|rec| rec.status != Status::NO_ROOM);
    must(
        tail.clone().all(|rec| rec.status == Status::NO_ROOM && rec.data.is_empty()),
        text::NothingAfterNoRoom,
        list(&records),
    )?;
    let good = records.iter().take_while(|rec| rec.status == Status::OK).count();
    must(good + full.len() == records.len() && good > 0, text::AnswersThenNoRoom, list(&records))
}

/// §1/11 by reads: an unknown request comes before the addressee, the addressee before the size.
pub fn order_of_checks(b: &mut Bench<'_>) -> Step {
    b.refused(R(0x00), S(0x00), &[], S::GENERAL, Status::WRONG_REQUEST)?;
    b.refused(R::GET_HOTBED, S(0x00), &[1], S(0x00), Status::MODULE_NOT_EXIST)?;
    b.refused(R::GET_HOTBED, S::GENERAL, &[1], S::GENERAL, Status::WRONG_REQUEST)
}

/// §1/12
pub fn wrong_addressee(b: &mut Bench<'_>) -> Step {
    b.refused(R::GET_HOTBED, S::GENERAL, &[], S::GENERAL, Status::WRONG_REQUEST)?;
    b.refused(R::RETRIEVE_LIMITS, S::GENERAL, &[], S::GENERAL, Status::WRONG_REQUEST)?;
    for id in b.found.present.clone() {
        if id != S::GENERAL {
            b.refused(R::GET_CRASH_DATA, id, &[], id, Status::WRONG_REQUEST)?;
        }
    }
    Ok(())
}

/// §2 With literal bytes, not made by any encoder.
pub fn layout(b: &mut Bench<'_>) -> Step {
    for (request, answer) in [
        (GET_STATUS_GENERAL, text::BytesOfStatus.fixed()),
        (GET_CRASH_DATA_GENERAL, text::BytesOfCrashData.fixed()),
    ] {
        let records = b.frame(&request)?;
        let good = matches!(&records[..], [rec] if rec.bytes().starts_with(&request[..3])
            && (request != GET_STATUS_GENERAL || rec.data.len() == 10));
        must(good, answer, list(&records))?;
    }
    Ok(())
}

/// §2/1
pub fn status_ignored(b: &mut Bench<'_>) -> Step {
    for status in [1, 3, 9, 0x7F, 0xFF] {
        let records = b.frame(&[R::GET_STATUS.0, S::GENERAL.0, status, 0])?;
        let good =
            matches!(&records[..], [rec] if rec.status == Status::OK && rec.data.len() == 10);
        must(good, text::AsWithStatus0, list(&records))?;
    }
    Ok(())
}

/// §2/2
pub fn cut_short(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let status = Rec::new(R::GET_STATUS, S::GENERAL, &[]).bytes();
    let cut: [&[u8]; 4] = [
        &[R::GET_PARAM.0, S::GENERAL.0, 0, 2, 0xFE],
        &[R::GET_PARAM.0, S::GENERAL.0, 0, 2],
        &[R::GET_STATUS.0, S::GENERAL.0, 0],
        &[R::GET_STATUS.0],
    ];
    for cut in cut {
        let records = b.frame(&[&status, cut].concat())?;
        let good = matches!(&records[..], [first, second]
            if first.status == Status::OK && second.status == Status::WRONG_DATA
                && second.device == S::GENERAL);
        must(good, text::CutRecordIsWrongData, list(&records))?;
    }
    Ok(())
}

/// §2/3 by reads.
pub fn wrong_size(b: &mut Bench<'_>) -> Step {
    for (request, to, size) in [
        (R::GET_STATUS, S::GENERAL, 1),
        (R::GET_STATUS, S::GENERAL, 255),
        (R::GET_PARAM, S::GENERAL, 0),
        (R::GET_PARAM, S::GENERAL, 1),
        (R::GET_PARAM, S::GENERAL, 3),
        (R::GET_CRASH_DATA, S::GENERAL, 1),
    ] {
        b.refused(request, to, &vec![0; size], to, Status::WRONG_DATA)?;
    }
    for id in b.found.present.clone() {
        b.refused(R::GET_STATUS, id, &[0], id, Status::WRONG_DATA)?;
        if id.is_drive() {
            b.refused(R::RETRIEVE_LIMITS, id, &[0, 0], id, Status::WRONG_DATA)?;
        }
    }
    Ok(())
}

/// §2/5 All answers are checked; this test covers those most likely to have a wrong status.
pub fn statuses(b: &mut Bench<'_>) -> Step {
    for id in b.found.present.clone() {
        for request in [R::GET_STATUS, R::GET_PARAM, R::RETRIEVE_LIMITS, R::GET_HOTBED] {
            let rec = b.ask(request, id, &[])?;
            must(rec.request == request, text::OwnRequestId, rec.words(true))?;
        }
    }
    Ok(())
}

/// §1/12 Addressees that do not support Stop.
pub fn stop_addressees(b: &mut Bench<'_>) -> Step {
    for id in [S::GENERAL, S::CLIMATICS, S::EXTERNAL_CONN, S::RADIO, S::BUTTONS, S::EXT_BUTTONS] {
        if b.has(id) {
            b.refused(R::STOP, id, &[], id, Status::WRONG_REQUEST)?;
        }
    }
    Ok(())
}

/// §3.2/7
pub fn stop_absent(b: &mut Bench<'_>) -> Step {
    let absent: Vec<S> = S::CHAIN.into_iter().filter(|id| !b.has(*id)).collect();
    for id in absent.into_iter().chain([S(0x00)]) {
        b.refused(R::STOP, id, &[], id, Status::MODULE_NOT_EXIST)?;
    }
    Ok(())
}

/// §3.2
pub fn stop_layout(b: &mut Bench<'_>) -> Step {
    b.needs_release()?;
    let who = [S::HORIZONTAL, S::VERTICAL, S::NOZZLE, S::CONTROL];
    let one = b.one_of(&who)?;
    b.done(R::STOP, one, &[])?;
    b.refused(R::STOP, one, &[0], one, Status::WRONG_DATA)
}

/// §3.2/1 at rest: every subsystem that handles Stop answers, and no other.
pub fn stop_all_at_rest(b: &mut Bench<'_>) -> Step {
    b.needs_release()?;
    let records = b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    let handles =
        |id: &S| id.is_drive() || id.is_valve() || matches!(*id, S::CONTROL | S::DETECTOR);
    let handlers: Vec<S> = b.found.present.iter().copied().filter(handles).collect();
    must(
        devices(&records) == handlers
            && records.iter().all(|rec| rec.status.is_success() && rec.data.is_empty()),
        text::OkFromAllStoppable,
        list(&records),
    )
}
