//! §3.5, §3.3.1/4, §3.3.3/1: parameters are changed, take effect, and are restored.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::{bits, le};
use crate::bench::{Bench, param_data};
use crate::raw;
use crate::safety::Undo;
use crate::verdict::{Step, must, not_applicable};

/// A parameter of ours that moves nothing, in order of preference.
fn spare(b: &mut Bench<'_>) -> Step<(S, &'static str, i32)> {
    for (of, name) in
        [(S::DETECTOR, "Threshold"), (S::CONTROL, "Height"), (S::GENERAL, "MainVoltageMax")]
    {
        if b.has(of)
            && let Some([value, ..]) = b.get(of, name)?.as_deref()
        {
            return Ok((of, name, *value));
        }
    }
    not_applicable(text::OwnParametersUnknown)
}

/// §3.5, §3.5/1
pub fn set_and_read(b: &mut Bench<'_>) -> Step {
    let (of, name, value) = spare(b)?;
    b.set(of, name, value + 1)?;
    let read = b.param(of, name)?;
    must(read == value + 1, text::ReadBackAtOnce, format!("{read}"))?;
    b.wait(1500)?;
    let read = b.param(of, name)?;
    must(read == value + 1, text::ReadBackLater, format!("{read}"))
}

/// §3.5/1: negative and large values keep their sign and their four bytes.
pub fn wide_values(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    for value in [-9_999, 9_998, -1] {
        b.set(S::CONTROL, "Height", value)?;
        let read = b.param(S::CONTROL, "Height")?;
        must(read == value, text::ValueAsSet, format!("{value}: {read}"))?;
    }
    Ok(())
}

/// §3.5/1: an array.
pub fn arrays(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    let Some(old) = b.get(S::CONTROL, "Program7")? else {
        return not_applicable(text::NoStoredPrograms);
    };
    if old.is_empty() {
        return not_applicable(text::NoStoredPrograms);
    }
    let new = [10, 20, 30, 40, 50, 6, 7];
    b.undo.push(Undo::Values(S::CONTROL, "Program7", old));
    let rec = b.try_set(S::CONTROL, "Program7", &new)?;
    let read = b.get(S::CONTROL, "Program7")?;
    must(rec.status.is_success(), Shown("Accepted"), rec.words(true))?;
    must(
        read.as_deref() == Some(&new),
        text::AllValuesOfArray,
        raw::several(read.as_deref().unwrap_or_default()),
    )
}

/// §3.5: the answer carries the id.
pub fn answer_id(b: &mut Bench<'_>) -> Step {
    let (of, name, value) = spare(b)?;
    let data = param_data(name, &[value]);
    let rec = b.ask(R::SET_PARAM, of, &data)?;
    must(rec.status.is_success() && rec.data == data[..2], text::AcceptedWithId, rec.words(true))
}

/// §3.5/2
pub fn unknown_id(b: &mut Bench<'_>) -> Step {
    for to in b.found.present.clone() {
        b.refused(R::SET_PARAM, to, &[0x01, 0x00, 0, 0, 0, 0], to, Status::INVALID_ID)?;
    }
    for id in S::CHAIN.into_iter().chain([S(0)]) {
        if !b.has(id) {
            b.refused(R::SET_PARAM, id, &[1, 0, 0, 0, 0, 0], id, Status::MODULE_NOT_EXIST)?;
        }
    }
    Ok(())
}

/// §3.5/3
pub fn out_of_range(b: &mut Bench<'_>) -> Step {
    let old = b.param(S::GENERAL, "MoveTimeout")?;
    b.undo.push(Undo::Param(S::GENERAL, "MoveTimeout", old));
    for value in [-1, 60_001, i32::MAX, i32::MIN] {
        let rec = b.try_set(S::GENERAL, "MoveTimeout", &[value])?;
        must(rec.status == Status::INVALID_VALUE, Shown("InvalidValue"), rec.words(true))?;
    }
    let read = b.param(S::GENERAL, "MoveTimeout")?;
    must(read == old, text::NothingChanges, format!("{read}"))
}

/// §3.5/4
pub fn wrong_count(b: &mut Bench<'_>) -> Step {
    let (of, name, value) = spare(b)?;
    b.undo.push(Undo::Param(of, name, value));
    let whole = param_data(name, &[value, value]);
    for len in [10, 9, 5, 3, 2] {
        let rec = b.ask(R::SET_PARAM, of, &whole[..len])?;
        must(
            rec.status == Status::WRONG_DATA && rec.device == of,
            Shown("WrongData"),
            rec.words(true),
        )?;
    }
    let read = b.param(of, name)?;
    must(read == value, text::NothingChanges, format!("{read}"))
}

/// §3.5/5
pub fn read_only(b: &mut Bench<'_>) -> Step {
    let rec = b.try_set(S::GENERAL, "FaultInfo", &[0; 20])?;
    if rec.status == Status::INVALID_ID {
        return not_applicable(text::OwnParametersMissing);
    }
    must(rec.status == Status::ACCESS_DENIED, Shown("AccessDenied"), rec.words(true))
}

/// §3.21/3
pub fn hotbeds_read_only(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    let rec = b.try_set(S::DETECTOR, "Hotbeds", &[0; 5])?;
    must(rec.status == Status::ACCESS_DENIED, Shown("AccessDenied"), rec.words(true))
}

/// §3.5/7
pub fn remote(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for id in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE] {
        if !b.has(id) || b.param(id, "DriveType")? != 1 {
            continue;
        }
        let old = b.param(id, "Speed")?;
        let new = if old > 2 { old - 1 } else { old + 1 };
        b.undo.push(Undo::Param(id, "Speed", old));
        let first = b.ask(R::SET_PARAM, id, &param_data("Speed", &[new]))?;
        let known = [Status::CACHED, Status::ACCEPTED, Status::OK].contains(&first.status);
        must(known, text::CachedThenAccepted, first.words(true))?;
        b.put(id, "Speed", new)?;
        let read = b.param(id, "Speed")?;
        return must(read == new, text::UnitsNewValue, format!("{read}"));
    }
    not_applicable(text::NoRemoteDrive)
}

/// §3.5/8
pub fn after_restart(b: &mut Bench<'_>) -> Step {
    let address = b.param(S::GENERAL, "Address")?;
    let taken = [i32::from(b.options.monitor), address];
    // Should it lose its power before the address is restored, no other monitor may have the same.
    let other = (1_u8..=127).rev().find(|it| !taken.contains(&i32::from(*it))).unwrap_or(127);
    if b.is_framed() {
        super::link::is_free(b, other)?;
    }
    b.set(S::GENERAL, "Address", other.into())?;
    let read = b.param(S::GENERAL, "Address")?;
    must(read == i32::from(other), text::NewValueIsRead, format!("{read}"))
}

/// §3.5/9
pub fn stored_already(b: &mut Bench<'_>) -> Step {
    let (of, name, value) = spare(b)?;
    b.put(of, name, value)?;
    b.until(10_000, text::OkOnceValueStored, |b| {
        Ok(b.try_set(of, name, &[value])?.status == Status::OK)
    })?;
    b.set(of, name, value + 1)?;
    let stored = b.try_set(of, name, &[value + 1])?;
    must(stored.status.is_success(), text::AcceptedThenOk, stored.words(true))?;
    b.until(10_000, text::OkOnceValueStored, |b| {
        Ok(b.try_set(of, name, &[value + 1])?.status == Status::OK)
    })
}

/// §3.5/9: a new value is Accepted first.
pub fn accepted_first(b: &mut Bench<'_>) -> Step {
    let (of, name, value) = spare(b)?;
    b.undo.push(Undo::Param(of, name, value));
    let rec = b.try_set(of, name, &[value + 2])?;
    must(rec.status == Status::ACCEPTED, text::AcceptedForNewValue, rec.words(true))
}

/// §3.5/10
pub fn not_in_motion(b: &mut Bench<'_>) -> Step {
    let id = super::motion::aimed(b)?;
    let (of, name, value) = spare(b)?;
    let (sign, from) = super::motion::room(b, id)?;
    b.done(R::MOVE, id, &le(from + sign * super::motion::small(id).0 * 4))?;
    b.until_flags(id, bits::MOVE, 0, 1000)?;
    b.undo.push(Undo::Param(of, name, value));
    for _ in 0..4 {
        let rec = b.try_set(of, name, &[value + 3])?;
        let moving = b.drive(id)?.0 & bits::MOVE != 0;
        must(
            !moving || rec.status == Status::ACCEPTED,
            text::AcceptedWhileTurning,
            rec.words(true),
        )?;
    }
    b.until_flags(id, 0, bits::MOVE, 30_000)?;
    b.until(10_000, text::OkAfterMotion, |b| {
        Ok(b.try_set(of, name, &[value + 3])?.status == Status::OK)
    })
}

/// §3.3.1/4: a supply voltage outside the limits set.
pub fn bad_power(b: &mut Bench<'_>) -> Step {
    let rec = b.read(R::GET_STATUS, S::GENERAL, &[])?;
    let volts = i32::from(rec.i16_at(4).unwrap_or(0));
    let was = rec.flags().unwrap_or(0) & bits::BAD_POWER;
    b.set(S::GENERAL, "MainVoltageMax", volts + 30)?;
    b.set(S::GENERAL, "MainVoltageMin", volts + 10)?;
    b.until_flags(S::GENERAL, bits::BAD_POWER, 0, 3000)?;
    b.put(S::GENERAL, "MainVoltageMin", 0)?;
    b.until_flags(S::GENERAL, 0, bits::BAD_POWER, 3000)?;
    b.put(S::GENERAL, "MainVoltageMax", (volts - 5).max(0))?;
    b.until_flags(S::GENERAL, bits::BAD_POWER, 0, 3000)?;
    b.put(S::GENERAL, "MainVoltageMax", volts + 30)?;
    b.until_flags(S::GENERAL, 0, bits::BAD_POWER, 3000)?;
    must(was == 0, text::NoBadPowerBefore, rec.words(true))
}

/// §3.3.3/1
pub fn heating(b: &mut Bench<'_>) -> Step {
    b.needs(S::CLIMATICS)?;
    let rec = b.read(R::GET_STATUS, S::CLIMATICS, &[])?;
    let box_temp = i32::from(rec.i16_at(12).unwrap_or(0));
    if !(-350..=500).contains(&box_temp) {
        return not_applicable(text::BoxTemperature);
    }
    b.set(S::CLIMATICS, "HeatOff", 600)?;
    b.set(S::CLIMATICS, "HeatOn", box_temp + 60)?;
    b.until_flags(S::CLIMATICS, bits::BOX_HEAT, 0, 3000)?;
    b.put(S::CLIMATICS, "HeatOn", box_temp - 49)?;
    b.put(S::CLIMATICS, "HeatOff", box_temp - 40)?;
    b.until_flags(S::CLIMATICS, 0, bits::BOX_HEAT, 3000)
}

/// §3.6, §3.6/2: tables that are refused; a valid one could not be undone.
pub fn correction_table(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.refused(R::SETUP_CORRECTION_TABLE, S::CONTROL, &[], S::CONTROL, Status::WRONG_DATA)?;
    b.refused(R::SETUP_CORRECTION_TABLE, S::CONTROL, &[0], S::CONTROL, Status::WRONG_DATA)?;
    b.refused(
        R::SETUP_CORRECTION_TABLE,
        S::CONTROL,
        &[255, 0, 0],
        S::CONTROL,
        Status::INVALID_VALUE,
    )
}

/// §3.6: an addressee without a table.
pub fn correction_addressee(b: &mut Bench<'_>) -> Step {
    let data = [0, 0];
    b.refused(R::SETUP_CORRECTION_TABLE, S::GENERAL, &data, S::GENERAL, Status::WRONG_REQUEST)?;
    if !b.has(S::CONTROL) {
        return b.refused(
            R::SETUP_CORRECTION_TABLE,
            S::CONTROL,
            &data,
            S::CONTROL,
            Status::MODULE_NOT_EXIST,
        );
    }
    Ok(())
}
