//! §3.19: erases the memory and restores it from a copy.

use lafet_proto::id::key;
use lafet_proto::param::{Access, Param, Storage};
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::{bits, le};
use crate::bench::{Bench, param_data};
use crate::raw::{Rec, several};
use crate::verdict::{Step, must, not_applicable};

/// Observations while the memory was erased.
#[derive(Clone, Debug, Default)]
pub struct Erased {
    answer: Option<Rec>,
    flags: u32,
    read: Option<Rec>,
    moved: Option<Rec>,
    first_set: Option<Rec>,
    last_set: Option<Rec>,
    restored: Option<String>,
}

type Copy = Vec<(Param, Vec<i32>)>;

fn copy(b: &mut Bench<'_>) -> Step<Copy> {
    let mut copy = Vec::new();
    for param in Param::ALL {
        let spec = param.spec();
        let kept = spec.storage == Storage::Stored && spec.access == Access::ReadWrite;
        if kept && b.has(spec.subsystem) {
            match b.get(spec.subsystem, param.name())? {
                Some(values) => copy.push((param, values)),
                None if !spec.required => {}
                None => {
                    return not_applicable(text::ParametersNotSaved);
                }
            }
        }
    }
    Ok(copy)
}

/// §3.19/2
pub fn wrong_key(b: &mut Bench<'_>) -> Step {
    for wrong in [0, key::CLEAN_FLASH ^ 1, key::CLEAN_FLASH.swap_bytes()] {
        b.refused(
            R::CLEAN_FLASH,
            S::GENERAL,
            &wrong.to_le_bytes(),
            S::GENERAL,
            Status::NEED_CONFIRM,
        )?;
    }
    b.wait(1500)?;
    let flags = b.flags(S::GENERAL)?;
    must(flags & bits::CONFIG_INVALID == 0, text::NothingIsErased, format!("{flags:#010x}"))
}

/// §3.19
pub fn layout(b: &mut Bench<'_>) -> Step {
    b.refused(R::CLEAN_FLASH, S::GENERAL, &[0xF6], S::GENERAL, Status::WRONG_DATA)?;
    for id in b.found.present.clone() {
        if id != S::GENERAL {
            b.refused(
                R::CLEAN_FLASH,
                id,
                &key::CLEAN_FLASH.to_le_bytes(),
                id,
                Status::WRONG_REQUEST,
            )?;
        }
    }
    Ok(())
}

/// §3.19/1: erases, observes, restores, verifies.
pub fn erase(b: &mut Bench<'_>) -> Step {
    let copy = copy(b)?;
    let mut erased = Erased::default();
    let answer = b.ask(R::CLEAN_FLASH, S::GENERAL, &key::CLEAN_FLASH.to_le_bytes())?;
    let done = answer.status.is_success();
    erased.answer = Some(answer.clone());
    let seen = if done { look(b, &copy, &mut erased) } else { Ok(()) };
    // The copy is restored, whatever was observed.
    b.restoring = true;
    let back = write_back(b, &copy, &mut erased);
    b.restoring = false;
    b.erased = Some(erased);
    back?;
    seen?;
    must(done, Shown("Ok"), answer.words(true))
}

fn look(b: &mut Bench<'_>, copy: &Copy, erased: &mut Erased) -> Step {
    super::service::back(b)?;
    erased.flags = b.flags(S::GENERAL)?;
    erased.read = Some(b.ask(R::GET_PARAM, S::GENERAL, &param_data("MainVoltageMin", &[])[..2])?);
    if b.has(S::HORIZONTAL) && !b.has(S::DEPLOYER) {
        erased.moved = Some(b.ask(R::MOVE, S::HORIZONTAL, &le(0))?);
    }
    if b.has(S::VALVE1) && !b.has(S::DEPLOYER) {
        erased.moved = Some(b.ask(R::MOVE, S::HORIZONTAL, &le(0))?);
    }
    let required =
        copy.iter().filter(|(p, _)| p.spec().subsystem == S::GENERAL && p.spec().required);
    let mut required = required.collect::<Vec<_>>();
    let Some((last, last_values)) = required.pop() else { return Ok(()) };
    for (param, values) in required {
        let rec = b.ask(R::SET_PARAM, S::GENERAL, &param_data(param.name(), values))?;
        erased.first_set.get_or_insert(rec);
    }
    erased.last_set =
        Some(b.ask(R::SET_PARAM, S::GENERAL, &param_data(last.name(), last_values))?);
    Ok(())
}

fn write_back(b: &mut Bench<'_>, copy: &Copy, erased: &mut Erased) -> Step {
    // Types of drives first: later values may have to go to their remote units.
    for round in 0..3 {
        let mut wrong = None;
        for (param, values) in copy {
            let of = param.spec().subsystem;
            if b.get(of, param.name())?.as_ref() != Some(values) {
                b.try_set(of, param.name(), values)?;
                wrong = Some(param.name());
            }
        }
        if wrong.is_none() && round > 0 {
            break;
        }
        b.wait(1500)?;
        b.frame(&Rec::new(R::RESTART, S::ALL, &[]).bytes())?;
        super::service::back(b)?;
    }
    for (param, values) in copy {
        let read = b.get(param.spec().subsystem, param.name())?;
        if read.as_ref() != Some(values) {
            erased.restored = Some(format!(
                "{}: {}, {}",
                param.name(),
                several(values),
                several(read.as_deref().unwrap_or_default())
            ));
        }
    }
    must(
        erased.restored.is_none(),
        text::CopyIsWrittenBack,
        erased.restored.clone().unwrap_or_default(),
    )
}

fn facts(b: &Bench<'_>) -> Step<Erased> {
    match &b.erased {
        Some(erased) if erased.answer.as_ref().is_some_and(|rec| rec.status.is_success()) => {
            Ok(erased.clone())
        }
        _ => not_applicable(text::MemoryWasNotErased),
    }
}

fn status(rec: Option<&Rec>, wanted: Status) -> Step {
    let Some(rec) = rec else {
        return not_applicable(text::NothingToAsk);
    };
    let name = wanted.name().unwrap_or_default();
    must(rec.status == wanted, Shown(name), rec.words(true))
}

/// §3.19/3, §3.3.1/2
pub fn invalid(b: &mut Bench<'_>) -> Step {
    let erased = facts(b)?;
    must(
        erased.flags & bits::CONFIG_INVALID != 0,
        Shown("ConfigInvalid"),
        format!("{:#010x}", erased.flags),
    )
}

/// §3.3.1/2
pub fn no_motion(b: &mut Bench<'_>) -> Step {
    invalid(b)?;
    let erased = facts(b)?;
    if erased.moved.is_none() {
        return Ok(());
    }
    status(erased.moved.as_ref(), Status::MODULE_FAULT)
}

/// §3.4/3
pub fn unset(b: &mut Bench<'_>) -> Step {
    status(facts(b)?.read.as_ref(), Status::INCOMPLETE_CONFIG)
}

/// §3.5/6
pub fn incomplete(b: &mut Bench<'_>) -> Step {
    let erased = facts(b)?;
    status(erased.first_set.as_ref(), Status::INCOMPLETE_CONFIG)?;
    status(erased.last_set.as_ref(), Status::ACCEPTED)
}

/// §3.6/1: a table of zeros; the earlier table is lost, as by the erasure.
pub fn table(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    let data = [0, 0, 0, 0];
    b.done(R::SETUP_CORRECTION_TABLE, S::CONTROL, &data)?;
    b.until(10_000, text::OkOnceStored, |b| {
        Ok(b.ask(R::SETUP_CORRECTION_TABLE, S::CONTROL, &data)?.status == Status::OK)
    })
}
