//! §3.10, §3.11, and the requests that Deployer intercepts.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, conform as text};

use super::{bits, le};
use crate::bench::Bench;
use crate::raw::Rec;
use crate::safety::{AIMING, FOLD_MS, VALVES};
use crate::verdict::{Step, must, not_applicable};

fn state(b: &mut Bench<'_>) -> Step<u32> {
    let state = b.flags(S::DEPLOYER)? & bits::FOLD;
    must(state.count_ones() <= 1, text::OneStateOfDeployer, format!("{state:#010x}"))?;
    Ok(state)
}

fn reaches(b: &mut Bench<'_>, wanted: u32) -> Step {
    b.folds();
    b.until(FOLD_MS, text::PositionAskedFor, |b| Ok(state(b)? == wanted))
}

fn denied_aiming(b: &mut Bench<'_>) -> Step {
    for id in AIMING {
        if b.has(id) {
            b.refused(R::MOVE, id, &le(120), S::DEPLOYER, Status::DENIED)?;
        }
    }
    Ok(())
}

/// §3.1/1, §1/2
pub fn move_wrapped(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    denied_aiming(b)?;
    b.refused(R::MOVE, S::DEPLOYER, &le(120), S::DEPLOYER, Status::DENIED)?;
    b.wait(500)?;
    b.watch()?;
    must(state(b)? == bits::WRAPPED, text::StaysWrapped, "")
}

/// §1/11: interception comes before the check of the size.
pub fn size_after_interceptor(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    let id = b.one_of(&AIMING)?;
    b.refused(R::MOVE, id, &[1], S::DEPLOYER, Status::DENIED)
}

/// §3.9/6
pub fn close_wrapped(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    let valve = b.one_of(&VALVES)?;
    b.done(R::CLOSE, valve, &key::CLOSE.to_le_bytes())
}

/// §3.2/1: Stop All in standby is not an error and changes nothing.
pub fn stop_wrapped(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    let records = b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    must(
        records.iter().all(|rec| rec.status.is_success()),
        text::OkOrAcceptedFromAll,
        crate::bench::list(&records),
    )?;
    must(state(b)? == bits::WRAPPED, text::StaysWrapped, "")
}

/// §3.11/2
pub fn wrap_wrapped(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.want(R::WRAP, S::DEPLOYER, &[], S::DEPLOYER, &[Status::OK])?;
    b.wait(500)?;
    must(state(b)? == bits::WRAPPED, text::NothingIsDone, "")
}

/// §3.10, §3.10/1, §3.3.8/1
pub fn deploy(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.refused(R::DEPLOY, S::DEPLOYER, &[0], S::DEPLOYER, Status::WRONG_DATA)?;
    must(state(b)? == bits::WRAPPED, text::StaysWrapped, "")?;
    b.folds();
    b.want(R::DEPLOY, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    b.until(2000, Shown("Deploying"), |b| Ok(state(b)? == bits::DEPLOYING))?;
    b.want(R::DEPLOY, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    b.until(FOLD_MS, text::DeployingThenDeployed, |b| {
        let state = state(b)?;
        must(
            state == bits::DEPLOYING || state == bits::DEPLOYED,
            text::DeployingUntilDeployed,
            format!("{state:#010x}"),
        )?;
        Ok(state == bits::DEPLOYED)
    })
}

/// §3.1/1, §3.2/2 while it deploys.
pub fn while_deploying(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.folds();
    b.done(R::DEPLOY, S::DEPLOYER, &[])?;
    b.until(2000, Shown("Deploying"), |b| Ok(state(b)? == bits::DEPLOYING))?;
    denied_aiming(b)?;
    must(state(b)? == bits::DEPLOYING, text::GoesOnDeploying, "")?;
    reaches(b, bits::DEPLOYED)?;
    // A denied request is not executed later.
    b.moves(&[]);
    b.wait(500)?;
    b.watch()
}

/// §3.2/2
pub fn stop_while_deploying(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.folds();
    b.done(R::DEPLOY, S::DEPLOYER, &[])?;
    b.until(2000, Shown("Deploying"), |b| Ok(state(b)? == bits::DEPLOYING))?;
    for id in [S::HORIZONTAL, S::NOZZLE, S::CONTROL, S::VALVE1] {
        if b.has(id) {
            b.refused(R::STOP, id, &[], S::DEPLOYER, Status::DENIED)?;
        }
    }
    must(state(b)? == bits::DEPLOYING, text::GoesOnDeploying, "")?;
    b.wait(1000)?;
    b.done(R::STOP, S::DEPLOYER, &[])?;
    b.until(3000, text::BetweenTheStates, |b| Ok(state(b)? == 0))?;
    b.until_flags(S::DEPLOYER, 0, bits::MOVE, 3000)
}

/// §3.1/1 in between; §3.10/1 and §3.11/1 from there.
pub fn in_between(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.folds();
    b.done(R::DEPLOY, S::DEPLOYER, &[])?;
    b.wait(1500)?;
    b.done(R::STOP, S::DEPLOYER, &[])?;
    b.until_flags(S::DEPLOYER, 0, bits::MOVE, 3000)?;
    if state(b)? != 0 {
        return not_applicable(text::NoPlaceInBetween);
    }
    b.moves(&[]);
    denied_aiming(b)?;
    b.wait(300)?;
    b.watch()?;
    b.folds();
    b.want(R::WRAP, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    reaches(b, bits::WRAPPED)
}

/// §3.2/1: Stop All ends deploying and stowing in every state.
pub fn stop_all_while_folding(b: &mut Bench<'_>) -> Step {
    for (start, request, moving) in
        [(bits::WRAPPED, R::DEPLOY, bits::DEPLOYING), (bits::DEPLOYED, R::WRAP, bits::WRAPPING)]
    {
        if start == bits::WRAPPED {
            b.wrapped()?
        } else {
            b.deployed()?
        }
        b.folds();
        b.done(request, S::DEPLOYER, &[])?;
        b.until(3000, text::UnderWay, |b| Ok(state(b)? == moving))?;
        b.wait(1000)?;
        let records = b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
        must(
            records.iter().all(|rec| rec.status.is_success()),
            text::OkOrAcceptedFromAll,
            crate::bench::list(&records),
        )?;
        b.until(3000, text::Stops, |b| Ok(state(b)? & moving == 0))?;
        b.until_flags(S::DEPLOYER, 0, bits::MOVE, 3000)?;
        b.moves(&[]);
        b.wait(500)?;
        b.watch()?;
    }
    b.deployed()
}

/// §3.10/2
pub fn deploy_deployed(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    b.deployed()?;
    b.refused(R::DEPLOY, S::DEPLOYER, &[0], S::DEPLOYER, Status::WRONG_DATA)?;
    let rec = b.want(R::DEPLOY, S::DEPLOYER, &[], S::DEPLOYER, &[Status::OK])?;
    must(rec.data.is_empty(), text::AnswerWithoutData, rec.words(true))?;
    b.wait(500)?;
    must(state(b)? == bits::DEPLOYED, text::NothingIsDone, "")
}

/// §3.11, §3.11/1
pub fn wrap(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    b.deployed()?;
    b.refused(R::WRAP, S::DEPLOYER, &[0], S::DEPLOYER, Status::WRONG_DATA)?;
    must(state(b)? == bits::DEPLOYED, text::StaysDeployed, "")?;
    b.folds();
    b.want(R::WRAP, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    b.until(3000, Shown("Wrapping"), |b| Ok(state(b)? == bits::WRAPPING))?;
    denied_aiming(b)?;
    b.want(R::WRAP, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    reaches(b, bits::WRAPPED)
}

/// §3.10/3, §3.11/3: with MaxCurrent so low that Deployer cannot start.
fn faulty(b: &mut Bench<'_>, request: R) -> Step {
    b.set(S::DEPLOYER, "MaxCurrent", 1)?;
    b.folds();
    b.done(request, S::DEPLOYER, &[])?;
    let mut over = false;
    for _ in 0..200 {
        over = b.flags(S::DEPLOYER)? & bits::OVERLOAD != 0;
        if over {
            break;
        }
        b.wait(100)?;
    }
    if !over {
        return not_applicable(text::DeployerDrawsTooLittle);
    }
    b.refused(request, S::DEPLOYER, &[], S::DEPLOYER, Status::MODULE_FAULT)?;
    b.until_flags(S::DEPLOYER, 0, bits::OVERLOAD, 6000)
}

pub fn deploy_faulty(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    let step = faulty(b, R::DEPLOY);
    super::service::clean(b).and(step)
}

pub fn wrap_faulty(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    b.deployed()?;
    let step = faulty(b, R::WRAP);
    super::service::clean(b).and(step)
}

/// §3.11/1, §3.10/1: each request reverses the other.
pub fn turn_round(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    b.folds();
    b.done(R::DEPLOY, S::DEPLOYER, &[])?;
    b.wait(1500)?;
    b.want(R::WRAP, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    b.until(3000, Shown("Wrapping"), |b| Ok(state(b)? == bits::WRAPPING))?;
    b.want(R::DEPLOY, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED])?;
    b.until(3000, Shown("Deploying"), |b| Ok(state(b)? == bits::DEPLOYING))?;
    reaches(b, bits::DEPLOYED)
}

fn not_for_others(b: &mut Bench<'_>, request: R) -> Step {
    for id in b.found.present.clone() {
        if id != S::DEPLOYER {
            b.refused(request, id, &[], id, Status::WRONG_REQUEST)?;
        }
    }
    Ok(())
}

pub fn deploy_wrong_addressee(b: &mut Bench<'_>) -> Step {
    not_for_others(b, R::DEPLOY)
}

pub fn wrap_wrong_addressee(b: &mut Bench<'_>) -> Step {
    not_for_others(b, R::WRAP)
}

fn absent(b: &mut Bench<'_>, request: R) -> Step {
    if b.has(S::DEPLOYER) {
        return b.refused(request, S(0), &[], S(0), Status::MODULE_NOT_EXIST);
    }
    b.refused(request, S::DEPLOYER, &[], S::DEPLOYER, Status::MODULE_NOT_EXIST)
}

pub fn deploy_absent(b: &mut Bench<'_>) -> Step {
    absent(b, R::DEPLOY)
}

pub fn wrap_absent(b: &mut Bench<'_>) -> Step {
    absent(b, R::WRAP)
}

/// §3.1/9
pub fn move_deployer(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    b.deployed()?;
    let (_, at) = b.drive(S::DEPLOYER)?;
    let (min, max) = super::motion::limits(b, S::DEPLOYER)?;
    let middle = (min + max) / 2;
    b.folds();
    b.done(R::MOVE, S::DEPLOYER, &le(at + (middle - at) / 4))?;
    b.until_flags(S::DEPLOYER, 0, bits::MOVE, 30_000)?;
    b.wait(500)?;
    must(state(b)? & bits::WRAPPED == 0, text::NotWrapped, "")?;
    b.want(R::DEPLOY, S::DEPLOYER, &[], S::DEPLOYER, &[Status::ACCEPTED, Status::OK])?;
    reaches(b, bits::DEPLOYED)
}
