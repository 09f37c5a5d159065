//! §3.3, §3.4, §3.7, §3.20, §3.21, §P: what can be read.

use lafet_proto::param::{Param, Storage};
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::bits;
use crate::bench::Bench;
use crate::raw::{Rec, name, several};
use crate::verdict::{Step, must, not_applicable};

const HOTBED: usize = 20;

fn size_of(id: S) -> usize {
    match id {
        S::GENERAL => 10,
        S::CLIMATICS => 16,
        id if id.is_drive() => 8,
        _ => 4,
    }
}

/// §3.3
pub fn sizes(b: &mut Bench<'_>) -> Step {
    for id in b.found.present.clone() {
        let rec = b.read(R::GET_STATUS, id, &[])?;
        let size = size_of(id);
        let from = name(id.name(), id.0);
        must(rec.data.len() == size, text::BytesFrom { size, from }, rec.words(true))?;
    }
    Ok(())
}

/// §3.3/1 GetStatus All returns what each subsystem returns alone.
pub fn same_as_alone(b: &mut Bench<'_>) -> Step {
    let records = b.frame(&Rec::new(R::GET_STATUS, S::ALL, &[]).bytes())?;
    for rec in records {
        if rec.status == Status::NO_ROOM {
            return not_applicable(text::AnswersDoNotFit);
        }
        must(
            rec.data.len() == size_of(rec.device) && rec.status == Status::OK,
            text::OkWithStructures,
            rec.words(true),
        )?;
        let alone = b.read(R::GET_STATUS, rec.device, &[])?;
        let same = |flags: Option<u32>| flags.map(|flags| flags & !bits::CONN_LOST);
        must(
            same(alone.flags()) == same(rec.flags())
                && alone.i16_at(4).is_some() == rec.i16_at(4).is_some(),
            text::SameFlagsAsSubsystemAlone,
            alone.words(true),
        )?;
    }
    Ok(())
}

/// §3.3.1 to §3.3.9: unused bits are 0.
fn unused(b: &mut Bench<'_>, ids: &[S], used: u32) -> Step {
    let mut any = false;
    for id in ids.iter().copied() {
        if !b.has(id) {
            continue;
        }
        any = true;
        let flags = b.flags(id)?;
        must(
            flags & !used == 0,
            text::UnusedFlagsAre0,
            format!("{}: {flags:#010x}", name(id.name(), id.0)),
        )?;
    }
    if any { Ok(()) } else { not_applicable(text::NoSuchSubsystem) }
}

pub fn common_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &S::CHAIN, !bits::RESERVED)
}

pub fn general_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::GENERAL], 0x0007_7FFF)?;
    let rec = b.read(R::GET_STATUS, S::GENERAL, &[])?;
    let volts = rec.i16_at(4).unwrap_or(0);
    must(volts > 0, text::SupplyVoltageInV, rec.words(true))
}

pub fn drive_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::VERTICAL, S::HORIZONTAL, S::NOZZLE], 0x3FFF_7FFF)
}

pub fn valve_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::VALVE1, S::VALVE2], 0x00FF_7FFF)?;
    for id in [S::VALVE1, S::VALVE2] {
        if b.has(id) {
            let flags = b.flags(id)?;
            let both = bits::OPEN | bits::CLOSED;
            must(flags & both != both, text::NotOpenAndClosed, format!("{flags:#010x}"))?;
        }
    }
    Ok(())
}

pub fn control_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::CONTROL], 0x01FF_7FFF)
}

pub fn detector_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::DETECTOR], 0x00FF_7FFF)
}

pub fn climatics_flags(b: &mut Bench<'_>) -> Step {
    b.needs(S::CLIMATICS)?;
    let rec = b.read(R::GET_STATUS, S::CLIMATICS, &[])?;
    let humidity = rec.i16_at(14).unwrap_or(-1);
    let sane = |at: usize| rec.i16_at(at).is_some_and(|temp| (-1000..=2000).contains(&temp));
    must(
        (0..=100).contains(&humidity) && [4, 6, 8, 10, 12].into_iter().all(sane),
        text::TemperaturesAndHumidity,
        rec.words(true),
    )
}

pub fn deployer_flags(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    let flags = b.flags(S::DEPLOYER)?;
    must((flags & bits::FOLD).count_ones() <= 1, text::OneStateAtMost, format!("{flags:#010x}"))
}

pub fn conn_flags(b: &mut Bench<'_>) -> Step {
    unused(b, &[S::EXTERNAL_CONN, S::RADIO], 0x0000_7FFF)
}

pub fn button_flags(b: &mut Bench<'_>) -> Step {
    b.one_of(&[S::BUTTONS, S::EXT_BUTTONS])?;
    for id in [S::BUTTONS, S::EXT_BUTTONS] {
        if b.has(id) {
            let flags = b.flags(id)?;
            let stuck = (0..8).any(|n| flags >> (16 + 2 * n) & 3 == 1);
            must(!stuck, text::NoButtonIsPressed, format!("{flags:#010x}"))?;
        }
    }
    Ok(())
}

/// §3.3.4/2 at rest
pub fn at_rest(b: &mut Bench<'_>) -> Step {
    for id in b.found.present.clone() {
        if id.is_drive() {
            let rec = b.read(R::GET_STATUS, id, &[])?;
            must(rec.data.get(7) == Some(&0), text::Speed0AtRest, rec.words(true))?;
        }
    }
    Ok(())
}

/// §3.3.9, §3.3.9/1: Stop counts as control, reads do not.
fn lost(b: &mut Bench<'_>) -> Step<Vec<S>> {
    let mut lost = Vec::new();
    for id in [S::EXTERNAL_CONN, S::RADIO] {
        if b.has(id) && b.flags(id)? & bits::CONN_LOST != 0 {
            lost.push(id);
        }
    }
    Ok(lost)
}

fn timeout_ms(b: &mut Bench<'_>) -> Step<u64> {
    let mut longest = 3000;
    for id in [S::EXTERNAL_CONN, S::RADIO] {
        if b.has(id)
            && let Some([ms, ..]) = b.get(id, "Timeout")?.as_deref()
        {
            longest = longest.max(u64::try_from(*ms).unwrap_or(3000));
        }
    }
    Ok(longest)
}

pub fn conn_lost(b: &mut Bench<'_>) -> Step {
    b.one_of(&[S::EXTERNAL_CONN, S::RADIO])?;
    let timeout_ms = timeout_ms(b)?;
    let asked_ms = b.now_ms();
    b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    let ids = [S::EXTERNAL_CONN, S::RADIO].into_iter().filter(|id| b.has(*id)).count();
    let now = lost(b)?;
    must(now.len() < ids, text::NoConnLostAfterRequest, several(&now))?;
    b.wait(timeout_ms / 2)?;
    let before = lost(b)?.len();
    // A slow or stalling line proves nothing.
    let in_time = b.now_ms() - asked_ms < timeout_ms;
    must(before < ids || !in_time, text::NoConnLostEarly, "ConnLost")?;
    b.wait(timeout_ms / 2 + 700)?;
    let later = lost(b)?.len();
    must(later == ids, text::ConnLostAfterSilence, "")
}

pub fn conn_lost_reads(b: &mut Bench<'_>) -> Step {
    b.one_of(&[S::EXTERNAL_CONN, S::RADIO])?;
    let ms = timeout_ms(b)? + 500;
    b.wait(ms)?;
    let before = lost(b)?;
    let ids = [S::EXTERNAL_CONN, S::RADIO].into_iter().filter(|id| b.has(*id)).count();
    must(before.len() == ids, text::ConnLostWithoutControl, several(&before))?;
    for _ in 0..5 {
        b.read(R::GET_STATUS, S::GENERAL, &[])?;
    }
    let after = lost(b)?;
    must(before == after && !after.is_empty(), text::ReadsAreNoControl, several(&after))
}

/// §3.4
pub fn get_param(b: &mut Bench<'_>) -> Step {
    let mut any = false;
    for id in b.found.present.clone() {
        for param in Param::of(id).take(3) {
            let Some(values) = b.get(id, param.name())? else { continue };
            any = true;
            must(
                param.spec().allows_len(values.len()),
                text::ValuesOfParameter,
                format!("{}: {}", param.name(), several(&values)),
            )?;
        }
    }
    if any { Ok(()) } else { not_applicable(text::OwnParametersUnknown) }
}

/// §3.4/1
pub fn unknown_param(b: &mut Bench<'_>) -> Step {
    for to in b.found.present.clone() {
        b.refused(R::GET_PARAM, to, &[0x01, 0x00], to, Status::INVALID_ID)?;
    }
    Ok(())
}

/// §3.4/1; "with the id" is ours.
pub fn unknown_param_id(b: &mut Bench<'_>) -> Step {
    let rec = b.ask(R::GET_PARAM, S::GENERAL, &[0x34, 0x12])?;
    must(rec.data == [0x34, 0x12], text::IdComesBack, rec.words(true))
}

/// §3.4/2
pub fn remote_param(b: &mut Bench<'_>) -> Step {
    for id in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE] {
        if b.has(id) && matches!(b.get(id, "DriveType")?.as_deref(), Some([1])) {
            let speed = b.get(id, "Speed")?;
            return must(
                speed.is_some(),
                text::OkOnceFetched,
                several(speed.as_deref().unwrap_or_default()),
            );
        }
    }
    not_applicable(text::NoRemoteDrive)
}

/// §P/1
pub fn dictionary(b: &mut Bench<'_>) -> Step {
    let locked = b.flags(S::GENERAL)? & bits::CONFIG_INVALID != 0;
    if locked {
        return not_applicable(text::ParametersAreUnset);
    }
    for param in Param::ALL {
        let spec = param.spec();
        if !b.has(spec.subsystem) || spec.storage == Storage::Volatile {
            continue;
        }
        let Some(values) = b.get(spec.subsystem, param.name())? else {
            // Parameters such as TrvPosition exist only in monitors that store them.
            return must(!spec.required, text::EveryParameter, param.name());
        };
        must(
            spec.check(values.iter().copied()).is_ok(),
            text::ValuesInRange,
            format!("{}: {}", param.name(), several(&values)),
        )?;
    }
    Ok(())
}

/// §3.7
pub fn limits(b: &mut Bench<'_>) -> Step {
    b.one_of(&crate::safety::DRIVES)?;
    for id in b.found.present.clone() {
        if !id.is_drive() {
            continue;
        }
        let rec = b.read(R::RETRIEVE_LIMITS, id, &[])?;
        let (min, max) = (rec.i32_at(0), rec.i32_at(4));
        must(rec.data.len() == 8 && min <= max, text::LimitsInOrder, rec.words(true))?;
        let known = (b.get(id, "MinLimit")?, b.get(id, "MaxLimit")?);
        if let (Some(low), Some(high)) = known {
            must(
                low.first().copied() == min && high.first().copied() == max,
                text::LimitsOfParameters,
                rec.words(true),
            )?;
        }
    }
    Ok(())
}

/// §3.7/1
pub fn limits_of_all(b: &mut Bench<'_>) -> Step {
    let drives: Vec<S> = b.found.present.iter().copied().filter(|id| id.is_drive()).collect();
    if drives.is_empty() {
        return not_applicable(text::NoDrive);
    }
    for to in [S::ALL, S::MOTORS] {
        let records = b.frame(&Rec::new(R::RETRIEVE_LIMITS, to, &[]).bytes())?;
        let found: Vec<S> = records.iter().map(|rec| rec.device).collect();
        let data = records.iter().all(|rec| rec.data.len() == 8);
        must(found == drives && data, text::EveryDriveInOrder, crate::bench::list(&records))?;
    }
    Ok(())
}

/// §3.20
pub fn crash_data(b: &mut Bench<'_>) -> Step {
    let rec = b.read(R::GET_CRASH_DATA, S::GENERAL, &[])?;
    must([80, 48].contains(&rec.data.len()), text::SizeOfCrashData, rec.words(true))
}

/// §3.20/1
pub fn crash_param(b: &mut Bench<'_>) -> Step {
    let rec = b.read(R::GET_CRASH_DATA, S::GENERAL, &[])?;
    let param = b.read(R::GET_PARAM, S::GENERAL, &ParamId::FAULT_INFO.0.to_le_bytes())?;
    must(param.data.get(2..) == Some(&rec.data[..]), text::WordsOfFaultInfo, param.words(true))
}

/// §3.21, §3.21/1: with the literal bytes of the document.
pub fn hotbeds(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    let records = b.frame(&super::literal::GET_HOTBEDS)?;
    let good = matches!(&records[..], [rec] if rec.status == Status::OK
        && rec.data.starts_with(&[0xFE, 0x23])
        && (rec.data.len() - 2) % HOTBED == 0 && rec.data.len() <= 2 + 4 * HOTBED);
    must(good, text::SizeOfHotbeds, crate::bench::list(&records))
}

/// §3.16/5
pub fn brightest_first(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    let rec = b.read(R::GET_HOTBED, S::DETECTOR, &[])?;
    let beds = rec.data.get(2..).unwrap_or_default().chunks_exact(HOTBED);
    let bright: Vec<i32> = beds
        .filter_map(|bed| Some(i32::from_le_bytes(bed.get(16..20)?.try_into().ok()?)))
        .collect();
    must(
        bright.len() <= 4 && bright.is_sorted_by(|a, b| a >= b),
        text::HotbedsBrightestFirst,
        rec.words(true),
    )
}

/// §3.21/2
pub fn get_hotbed(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    let hotbed = b.read(R::GET_HOTBED, S::DETECTOR, &[])?;
    let param = b.read(R::GET_PARAM, S::DETECTOR, &[0xFE, 0x23])?;
    must(hotbed.data == param.data, text::DataOfHotbeds, hotbed.words(true))
}

/// §3.3/2 at rest: all reads answer Ok.
pub fn reads_answer(b: &mut Bench<'_>) -> Step {
    b.read(R::GET_STATUS, S::GENERAL, &[])?;
    b.read(R::GET_CRASH_DATA, S::GENERAL, &[])?;
    for id in b.found.present.clone() {
        b.read(R::GET_STATUS, id, &[])?;
        if id.is_drive() {
            b.read(R::RETRIEVE_LIMITS, id, &[])?;
        }
    }
    if b.has(S::DETECTOR) {
        b.read(R::GET_HOTBED, S::DETECTOR, &[])?;
    }
    Ok(())
}
