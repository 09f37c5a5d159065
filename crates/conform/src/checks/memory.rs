//! §3.19: erases the memory and restores it from a copy.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use lafet_client::backup::{About, Backup};
use lafet_proto::id::key;
use lafet_proto::param::{Access, Param, Storage};
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::link::SILENCE_MS;
use super::{bits, le};
use crate::bench::{Bench, param_data};
use crate::raw::{Rec, several};
use crate::safety::Undo;
use crate::verdict::{Halt, Note, Step, fail, must, not_applicable};

/// How many times the copy is written and the monitor restarted.
const ROUNDS: u32 = 4;
/// Most files of earlier copies that were not written back, in one folder.
const FILES_MAX: u32 = 1000;

/// Observations while the memory was erased.
#[derive(Clone, Debug, Default)]
pub struct Erased {
    answer: Option<Rec>,
    flags: u32,
    read: Option<Rec>,
    moved: Option<Rec>,
    first_set: Option<Rec>,
    last_set: Option<Rec>,
}

/// A copy of the stored parameters, in memory and in a file: the tester may end before it is written back.
#[derive(Clone, Debug)]
pub struct Kept {
    values: Vec<(Param, Vec<i32>)>,
    file: PathBuf,
}

/// Before anything that may erase the memory: what it holds is copied, and written back after the test.
/// §3.19/3: the monitor may be erased to any address, so it must be alone on its line to be found again.
fn keep(b: &mut Bench<'_>) -> Step<Kept> {
    let values = copy(b)?;
    let own = b.options.monitor;
    let at_own = |(param, values): &(Param, Vec<i32>)| {
        *param != Param::GeneralAddress || *values == [i32::from(own)]
    };
    if b.is_framed() && !values.iter().all(at_own) {
        return not_applicable(text::ParametersNotSaved);
    }
    if b.is_framed() && !b.alone {
        for address in (1..=127).filter(|address| *address != own) {
            super::link::is_free(b, address)?;
        }
        b.alone = true;
    }
    let Ok(file) = save(b, &values) else { return not_applicable(text::ParametersNotSaved) };
    let kept = Kept { values, file };
    b.undo.push(Undo::Memory(kept.clone()));
    Ok(kept)
}

/// Writes the copy to a new file, down to the disk.
fn save(b: &Bench<'_>, values: &[(Param, Vec<i32>)]) -> io::Result<PathBuf> {
    let about = About {
        subsystems: b.found.present.iter().map(S::to_string).collect(),
        made_by: format!("lafet-conform {}", env!("CARGO_PKG_VERSION")),
        ..About::default()
    };
    let backup = Backup { about, values: values.to_vec(), ..Backup::default() };
    let (folder, address) = (&b.options.keep_in, b.options.monitor);
    for number in 1..=FILES_MAX {
        let path = folder.join(format!("lafet-conform-{address}-{number}.toml"));
        match File::options().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                file.write_all(backup.to_toml().as_bytes())?;
                file.sync_all()?;
                sync(folder);
                return Ok(path);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Not every system can do that to a folder.
fn sync(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

fn copy(b: &mut Bench<'_>) -> Step<Vec<(Param, Vec<i32>)>> {
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
    keep(b)?;
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
    keep(b)?;
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

/// §3.19/1: erases and observes. The copy is written back and verified whatever was observed.
pub fn erase(b: &mut Bench<'_>) -> Step {
    let kept = keep(b)?;
    let mut erased = Erased::default();
    let answer = b.ask(R::CLEAN_FLASH, S::GENERAL, &key::CLEAN_FLASH.to_le_bytes());
    // It may be erased without an answer. An interrupt must not lose it.
    b.restoring = true;
    let back = found_again(b);
    b.restoring = false;
    let answer = answer?;
    back?;
    let done = answer.status.is_success();
    erased.answer = Some(answer.clone());
    let seen = if done { look(b, &kept, &mut erased) } else { Ok(()) };
    b.erased = Some(erased);
    seen?;
    must(done, Shown("Ok"), answer.words(true))
}

/// Waits until the monitor answers: at its own address, or else at the one that its hardware has.
fn found_again(b: &mut Bench<'_>) -> Step {
    b.monitor = b.options.monitor;
    match super::service::back(b) {
        Err(Halt::Fail { .. }) if b.alone => {}
        done => return done,
    }
    for address in 1..=127 {
        b.monitor = address;
        let wire = b.framed_bytes(&Rec::new(R::GET_STATUS, S::GENERAL, &[]).bytes());
        if !b.exchange(&wire, 1, SILENCE_MS)?.is_empty() && b.flags(S::GENERAL).is_ok() {
            return super::service::back(b);
        }
    }
    b.monitor = b.options.monitor;
    fail(text::AnswersAfterRestart, Shown("—"))
}

fn look(b: &mut Bench<'_>, kept: &Kept, erased: &mut Erased) -> Step {
    erased.flags = b.flags(S::GENERAL)?;
    erased.read = Some(b.ask(R::GET_PARAM, S::GENERAL, &param_data("MainVoltageMin", &[])[..2])?);
    if b.has(S::HORIZONTAL) && !b.has(S::DEPLOYER) {
        erased.moved = Some(b.ask(R::MOVE, S::HORIZONTAL, &le(0))?);
    }
    if b.has(S::VALVE1) && !b.has(S::DEPLOYER) {
        erased.moved = Some(b.ask(R::MOVE, S::HORIZONTAL, &le(0))?);
    }
    let required =
        kept.values.iter().filter(|(p, _)| p.spec().subsystem == S::GENERAL && p.spec().required);
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

/// Writes the copy back; a failure names its file.
pub fn write_back(b: &mut Bench<'_>, kept: &Kept) -> Step {
    let file = kept.file.display();
    match written(b, &kept.values) {
        Ok(()) => {
            let _ = fs::remove_file(&kept.file);
            Ok(())
        }
        Err(Halt::Fail { expected, found }) => {
            let found = Note::each(|lang| format!("{file}; {}", found.of(lang)));
            Err(Halt::Fail { expected, found })
        }
        Err(Halt::Link(error)) => {
            Err(Halt::Link(io::Error::new(error.kind(), format!("{file}; {error}"))))
        }
        Err(halt) => Err(halt),
    }
}

/// Writes values and restarts until the monitor has them, at its own address.
fn written(b: &mut Bench<'_>, kept: &[(Param, Vec<i32>)]) -> Step {
    found_again(b)?;
    // Types of drives first: later values may have to go to their remote units.
    for round in 0..ROUNDS {
        let invalid = b.flags(S::GENERAL)? & bits::CONFIG_INVALID != 0;
        let mut differ = Vec::new();
        for (param, values) in kept {
            let of = param.spec().subsystem;
            if b.get(of, param.name())?.as_ref() != Some(values) {
                differ.push(of);
            }
        }
        // All of such a subsystem: an unset parameter may falsely read as its former value.
        for (param, values) in kept {
            let of = param.spec().subsystem;
            if invalid || differ.contains(&of) {
                b.surely(|b| b.try_set(of, param.name(), values).map(|_| ()))?;
            }
        }
        let wrong = b.monitor != b.options.monitor || !differ.is_empty();
        if !wrong && (round > 0 || !invalid) {
            break;
        }
        b.wait(1500)?;
        // Whether it has restarted is seen afterwards: it may answer at another address then.
        match b.frame(&Rec::new(R::RESTART, S::ALL, &[]).bytes()) {
            Ok(_) | Err(Halt::Fail { .. }) => {}
            Err(halt) => return Err(halt),
        }
        found_again(b)?;
    }
    let mut differs = Vec::new();
    for (param, values) in kept {
        let read = b.get(param.spec().subsystem, param.name())?.unwrap_or_default();
        if read != *values {
            differs.push(format!("{}: {}, {}", param.name(), several(values), several(&read)));
        }
    }
    must(
        differs.is_empty() && b.monitor == b.options.monitor,
        text::CopyIsWrittenBack,
        format!("{}; {}", b.monitor, differs.join("; ")),
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
