//! §3.12, §3.18, §D: restart and lockout.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::{bits, le};
use crate::bench::{Bench, list, param_data};
use crate::raw::Rec;
use crate::safety::{RESET_MS, Undo, VALVES};
use crate::verdict::{Halt, Step, must, not_applicable};

fn lockout(b: &mut Bench<'_>, code: u16) -> Step<Vec<Rec>> {
    if code == key::ENABLE {
        b.locks_out()?;
    }
    let request = Rec::new(R::LOCKOUT, S::ALL, &code.to_le_bytes());
    match [key::ENABLE, key::DISABLE].contains(&code) {
        true => b.frame(&request.bytes()),
        false => bad(b, &request),
    }
}

/// A Lockout that must be refused. One that is taken for a good one is undone; otherwise a lockout is
/// not the tester's.
fn bad(b: &mut Bench<'_>, request: &Rec) -> Step<Vec<Rec>> {
    let records = b.frame(&request.bytes())?;
    if records.iter().any(|rec| rec.status.is_success()) {
        b.undo.push(Undo::Lockout);
    }
    Ok(records)
}

/// Locks out, and waits until it is.
pub fn locked(b: &mut Bench<'_>) -> Step {
    lockout(b, key::ENABLE)?;
    b.until_flags(S::GENERAL, bits::LOCKED_OUT, 0, 2000)
}

/// The same, until a loss of power would not end it.
pub fn locked_and_stored(b: &mut Bench<'_>) -> Step {
    locked(b)?;
    b.until(10_000, text::OkFromGeneral, |b| {
        let records = lockout(b, key::ENABLE)?;
        Ok(records.last().is_some_and(|rec| rec.device == S::GENERAL && rec.status == Status::OK))
    })
}

/// Releases, and waits until it is.
pub fn released(b: &mut Bench<'_>) -> Step {
    lockout(b, key::DISABLE)?;
    is_off(b)
}

/// Waits until it is released. From then on a lockout is not the tester's.
fn is_off(b: &mut Bench<'_>) -> Step {
    b.until_flags(S::GENERAL, 0, bits::LOCKED_OUT, 2000)?;
    b.undo.retain(|undo| !matches!(undo, Undo::Lockout));
    Ok(())
}

fn whole_chain(b: &Bench<'_>, records: &[Rec]) -> Step {
    let from: Vec<S> = records.iter().map(|rec| rec.device).collect();
    must(
        from == b.found.present && records.iter().all(|rec| rec.status.is_success()),
        text::OkFromAll,
        list(records),
    )
}

/// §3.18/5
pub fn lockout_key(b: &mut Bench<'_>) -> Step {
    for wrong in [0, key::ENABLE ^ 1, key::ENABLE.swap_bytes(), key::OPEN] {
        let records = lockout(b, wrong)?;
        let refused = records.iter().all(|rec| rec.status == Status::INVALID_VALUE);
        must(refused && !records.is_empty(), Shown("InvalidValue"), list(&records))?;
    }
    let flags = b.flags(S::GENERAL)?;
    must(flags & bits::LOCKED_OUT == 0, text::NotLockedOut, format!("{flags:#010x}"))
}

/// §3.18
pub fn lockout_layout(b: &mut Bench<'_>) -> Step {
    for wrong in [&[][..], &[0xFA], &[0xFA, 0x2F, 0]] {
        let records = bad(b, &Rec::new(R::LOCKOUT, S::ALL, wrong))?;
        let refused = records.iter().all(|rec| rec.status == Status::WRONG_DATA);
        must(refused && !records.is_empty(), Shown("WrongData"), list(&records))?;
    }
    let records = bad(b, &Rec::new(R::LOCKOUT, S::GENERAL, &key::ENABLE.to_le_bytes()))?;
    let refused = matches!(
        &records[..],
        [rec] if rec.device == S::GENERAL && rec.status == Status::WRONG_REQUEST
    );
    must(refused, Shown("WrongRequest"), list(&records))?;
    let flags = b.flags(S::GENERAL)?;
    must(flags & bits::LOCKED_OUT == 0, text::NotLockedOut, format!("{flags:#010x}"))
}

/// §3.18/1
pub fn lockout_on(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    let moving = [S::HORIZONTAL, S::VERTICAL].into_iter().find(|id| b.has(*id));
    if let Some(id) = moving {
        b.moves(&[id]);
        let (sign, _) = super::motion::room(b, id)?;
        b.done(R::MOVE, id, &le(sign * super::motion::FAR))?;
        b.wait(400)?;
    }
    let records = lockout(b, key::ENABLE)?;
    whole_chain(b, &records)?;
    b.until_flags(S::GENERAL, bits::LOCKED_OUT, 0, 1000)?;
    if let Some(id) = moving {
        b.until_flags(id, 0, bits::MOVE, 3000)?;
    }
    Ok(())
}

/// §3.18/1
pub fn lockout_closes(b: &mut Bench<'_>) -> Step {
    let valve = super::water::opened(b)?;
    locked(b)?;
    b.until_flags(valve, bits::CLOSED, bits::OPEN, 60_000)?;
    super::water::stays_closed(b, valve)
}

/// §3.18/2
pub fn lockout_denies(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    locked(b)?;
    let open = key::OPEN.to_le_bytes();
    for (request, to, data) in [
        (R::MOVE, S::HORIZONTAL, &[0, 1][..]),
        (R::STOP, S::HORIZONTAL, &[]),
        (R::STOP, S::ALL, &[]),
        (R::OPEN, S::VALVE1, &open),
        (R::DEPLOY, S::DEPLOYER, &[]),
        (R::WRAP, S::DEPLOYER, &[]),
        (R::SWITCH_LIMITS, S::HORIZONTAL, &[1, 0]),
        (R::START_SEEK, S::DETECTOR, &[0; 10]),
        (R::START_QUENCH, S::CONTROL, &[0; 12]),
        (R::RESTART, S::ALL, &[]),
    ] {
        b.refused(request, to, data, S::GENERAL, Status::DENIED)?;
    }
    b.wait(500)?;
    b.watch()
}

/// §1/11 under lockout: refused before anything else is checked.
pub fn lockout_first(b: &mut Bench<'_>) -> Step {
    locked(b)?;
    b.refused(R(0x00), S::GENERAL, &[], S::GENERAL, Status::DENIED)?;
    b.refused(R::MOVE, S(0x00), &[], S::GENERAL, Status::DENIED)
}

/// §3.18/3
pub fn lockout_reads(b: &mut Bench<'_>) -> Step {
    let old = b.get(S::GENERAL, "MoveTimeout")?;
    locked(b)?;
    super::reads::reads_answer(b)?;
    if let Some([value, ..]) = old.as_deref() {
        let rec = b.ask(R::SET_PARAM, S::GENERAL, &param_data("MoveTimeout", &[*value]))?;
        must(rec.status.is_success(), text::SetParamWorks, rec.words(true))?;
        let read = b.ask(R::GET_PARAM, S::GENERAL, &param_data("MoveTimeout", &[]))?;
        must(read.status == Status::OK, text::GetParamWorks, read.words(true))?;
    }
    Ok(())
}

/// §3.3/2
pub fn reads_locked(b: &mut Bench<'_>) -> Step {
    locked(b)?;
    super::reads::reads_answer(b)
}

/// §3.18/4
pub fn lockout_off(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    let id = b.one_of(&[S::HORIZONTAL, S::VERTICAL])?;
    b.moves(&[id]);
    let (sign, at) = super::motion::room(b, id)?;
    b.done(R::MOVE, id, &le(sign * super::motion::FAR))?;
    b.wait(300)?;
    locked(b)?;
    b.until_flags(id, 0, bits::MOVE, 3000)?;
    let records = lockout(b, key::DISABLE)?;
    whole_chain(b, &records)?;
    is_off(b)?;
    b.moves(&[]);
    b.wait(1000)?;
    b.watch()?;
    b.moves(&[id]);
    b.done(R::MOVE, id, &le(at))?;
    b.until_flags(id, 0, bits::MOVE, 60_000)
}

/// §3.18/8
pub fn lockout_stored(b: &mut Bench<'_>) -> Step {
    locked_and_stored(b)?;
    let first = lockout(b, key::DISABLE)?;
    must(
        first.last().is_some_and(|rec| rec.status == Status::ACCEPTED),
        text::AcceptedUntilStored,
        list(&first),
    )?;
    released(b)
}

/// §3.12, §3.12/3
pub fn restart_addressee(b: &mut Bench<'_>) -> Step {
    for id in b.found.present.clone() {
        b.refused(R::RESTART, id, &[], id, Status::WRONG_REQUEST)?;
    }
    b.refused(R::RESTART, S::MOTORS, &[], S::GENERAL, Status::WRONG_REQUEST)?;
    let records = b.frame(&Rec::new(R::RESTART, S::ALL, &[0]).bytes())?;
    must(
        records.iter().all(|rec| rec.status == Status::WRONG_DATA),
        Shown("WrongData"),
        list(&records),
    )?;
    let flags = b.flags(S::GENERAL)?;
    must(flags & bits::RESTARTING == 0, text::DoesNotRestart, format!("{flags:#010x}"))
}

/// Restarts it; [`back`] waits until it is there again.
pub fn restart(b: &mut Bench<'_>) -> Step<Vec<Rec>> {
    b.moves(&crate::safety::DRIVES);
    b.frame(&Rec::new(R::RESTART, S::ALL, &[]).bytes())
}

/// Some fault flags of a drive stay until the next start, so a test that provokes one restarts.
pub fn clean(b: &mut Bench<'_>) -> Step {
    b.put_back()?;
    restart(b)?;
    back(b)
}

/// Waits until the monitor is back and everything is at rest.
pub fn back(b: &mut Bench<'_>) -> Step {
    answers_again(b)?;
    b.rest()
}

/// Waits until it was away, or long enough for that, and answers again without Restarting.
fn answers_again(b: &mut Bench<'_>) -> Step {
    let end = b.line.now_ms() + RESET_MS;
    b.line.recv(700).map_err(Halt::Link)?;
    loop {
        let wire = b.framed_bytes(&Rec::new(R::GET_STATUS, S::GENERAL, &[]).bytes());
        let incoming = b.exchange(&wire, 1, 500)?;
        if !incoming.is_empty() && b.flags(S::GENERAL)? & bits::RESTARTING == 0 {
            b.line.recv(300).map_err(Halt::Link)?;
            b.moves(&[]);
            return Ok(());
        }
        let awaited = b.line.now_ms() < end;
        must(awaited, text::AnswersAfterRestart, "—")?;
    }
}

/// §3.12/1
pub fn restart_answers(b: &mut Bench<'_>) -> Step {
    let records = restart(b)?;
    whole_chain(b, &records)?;
    back(b)
}

/// §3.12/2, §3.3/2
pub fn restarting(b: &mut Bench<'_>) -> Step {
    let asked_ms = b.now_ms();
    restart(b)?;
    let flags = b.flags(S::GENERAL)?;
    let busy = b.refused(R::MOVE, S::HORIZONTAL, &le(0), S::GENERAL, Status::BUSY);
    let in_time = b.now_ms() - asked_ms < 200;
    let seen = flags & bits::RESTARTING != 0 && busy.is_ok();
    back(b)?;
    if !seen && !in_time {
        return not_applicable(text::LineTooSlow);
    }
    must(flags & bits::RESTARTING != 0, text::RestartingAndReadable, format!("{flags:#010x}"))?;
    busy
}

/// §3.12/4, §3.5/1
pub fn restart_keeps(b: &mut Bench<'_>) -> Step {
    let old = b.param(S::GENERAL, "MainVoltageMax")?;
    b.set(S::GENERAL, "MainVoltageMax", old + 7)?;
    restart(b)?;
    back(b)?;
    let read = b.param(S::GENERAL, "MainVoltageMax")?;
    must(read == old + 7, text::AcceptedIsKept, format!("{read}"))
}

/// §D/1
pub fn inert(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    let id = b.one_of(&[S::HORIZONTAL, S::VERTICAL])?;
    b.moves(&[id]);
    let (sign, _) = super::motion::room(b, id)?;
    b.done(R::MOVE, id, &le(sign * super::motion::FAR))?;
    b.wait(300)?;
    restart(b)?;
    answers_again(b)?;
    b.stays(1500, text::NothingMovesAfterStart, |b| Ok(b.drive(id)?.0 & bits::MOVE == 0))?;
    for valve in VALVES {
        if b.has(valve) {
            b.until_flags(valve, bits::CLOSED, bits::OPEN, 60_000)?;
        }
    }
    if b.has(S::DEPLOYER) {
        let flags = b.flags(S::DEPLOYER)?;
        must(flags & bits::DEPLOYED != 0, text::SensorsShowDeployed, format!("{flags:#010x}"))?;
    }
    Ok(())
}

/// §D/2
pub fn restart_closes(b: &mut Bench<'_>) -> Step {
    let keeps = matches!(b.get(S::GENERAL, "ResetValves")?.as_deref(), Some([1]));
    let valve = super::water::opened(b)?;
    restart(b)?;
    back(b)?;
    if keeps {
        return Ok(());
    }
    b.until_flags(valve, bits::CLOSED, bits::OPEN, 60_000)?;
    super::water::stays_closed(b, valve)
}
