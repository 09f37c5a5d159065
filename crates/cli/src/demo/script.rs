//! The script: what the operator does, from standby to standby.

use lafet_proto::answer::Reply;
use lafet_proto::flags::{DeployerFlags, DetectorFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::request::{Body, Quench, Sector, Seek};
use lafet_proto::status::Hotbed;
use lafet_proto::{ParamId, SubsystemId};
use lafet_sim::fire::FireSpec;
use lafet_texts::{Fixed, Text as _, cli as text};

use super::stage::Stage;
use crate::angle::degrees;
use crate::failure::Failure;
use crate::lang::current;

/// Sector of the search: the area in front, down to the foot of the monitor, arc-minutes.
const SEARCH: Seek = Seek { start_h: -3600, end_h: 3600, start_v: -600, end_v: 300, analyse: 1 };
/// Nozzle position of the narrowest jet, mm.
const NARROW: i16 = 60;
/// Degrees between the lines of the scan.
const SCAN_STEP: i8 = 1;
/// Height of the scan, arc-minutes: the jet comes down at a flat angle, so its footprint is long
/// already.
const SCAN_HEIGHT: i16 = 60;
/// Margin added to the hotbed on each side, arc-minutes.
const MARGIN: i32 = 30;
/// Plausible distances for an estimate from the elevation, m: farther away the angle says little.
const PLAUSIBLE_M: std::ops::RangeInclusive<f64> = 3.0..=60.0;
/// Most searches: one for each possible fire, and some that see smoke.
const ROUNDS: usize = 8;

const SEARCH_MS: u64 = 180_000;
const MOVE_MS: u64 = 20_000;
const QUENCH_MS: u64 = 180_000;

/// Runs the script.
pub async fn play(stage: &mut Stage, fires: &[FireSpec]) -> Result<(), Failure> {
    stage.phase(text::DemoStandby.str(current()));
    stage.pass(500).await?;
    stage.say(text::DemoStandbyDone.str(current()))?;
    stage.pass(1500).await?;
    for fire in fires {
        stage.light(*fire)?;
    }
    stage.pass(2000).await?;
    for _ in 0..ROUNDS {
        if stage.burning().is_empty() {
            break;
        }
        let Some(target) = search(stage).await? else {
            return Err(ended(text::DemoFoundNothing.fixed()));
        };
        extinguish(stage, &target).await?;
    }
    wrap(stage).await?;
    if stage.summary().is_success() { Ok(()) } else { Err(ended(text::DemoFireBurns.fixed())) }
}

/// Searches, and returns the brightest fire spot.
async fn search(stage: &mut Stage) -> Result<Option<Hotbed>, Failure> {
    stage.phase(text::DemoSearch.str(current()));
    let detector = SubsystemId::DETECTOR;
    stage.ask(detector, Body::StartSeek(SEARCH)).await?;
    let searching = |stage: &Stage| {
        let flags = DetectorFlags::from_bits_retain(stage.scene().flags(detector));
        !flags.contains(DetectorFlags::SEARCHING)
    };
    if !stage.until(SEARCH_MS, searching).await? {
        return Err(ended(text::DemoSearchEndless.fixed()));
    }
    let answers = stage.ask(detector, Body::GetParam { id: ParamId::HOTBEDS }).await?;
    let hotbeds: Vec<Hotbed> = answers
        .first()
        .decode()
        .ok()
        .and_then(|answer| answer.hotbeds().map(Iterator::collect))
        .unwrap_or_default();
    let brightest = hotbeds.iter().copied().max_by_key(|hotbed| hotbed.brightness);
    stage.set_hotbeds(hotbeds);
    Ok(brightest)
}

/// Extinguishes one fire spot.
async fn extinguish(stage: &mut Stage, hotbed: &Hotbed) -> Result<(), Failure> {
    stage.phase(text::DemoQuench.str(current()));
    let distance = distance(stage, hotbed).await?;
    let Hotbed { x1, x2, y1, .. } = *hotbed;
    let clamp = |value: i32| value.clamp(-32_767, 32_767) as i16;
    let sector = Sector {
        centre_h: clamp(i32::midpoint(x1, x2)),
        // The lower edge, at the foot of the flame: water there extinguishes the fire.
        centre_v: clamp(y1),
        nozzle: NARROW,
        width: clamp((x1 - x2).abs() + 2 * MARGIN),
        height: SCAN_HEIGHT,
        step: SCAN_STEP,
    };
    let quench = Quench::Full { sector, distance };
    stage.ask(SubsystemId::CONTROL, Body::StartQuench(quench)).await?;
    let aimed = move |stage: &Stage| {
        let position = stage.scene().position(SubsystemId::HORIZONTAL).unwrap_or(0);
        position.abs_diff(sector.centre_h) < sector.width.unsigned_abs()
    };
    stage.until(MOVE_MS, aimed).await?;
    stage.ask(SubsystemId::VALVE1, Body::Open { key: key::OPEN }).await?;
    let target = f64::from(sector.centre_h);
    let out = move |stage: &Stage| {
        // Counts only fires close to the aim.
        let near = |azimuth: f64| (azimuth - target).abs() < 180.0;
        !stage.burning().into_iter().any(near)
    };
    let is_out = stage.until(QUENCH_MS, out).await?;
    stage.say(match is_out {
        true => text::DemoNoFlames.str(current()),
        false => text::DemoClosing.str(current()),
    })?;
    stage.pass(1000).await?;
    stage.ask(SubsystemId::VALVE1, Body::Close { key: key::CLOSE }).await?;
    let closed = |stage: &Stage| {
        let flags = ValveFlags::from_bits_retain(stage.scene().flags(SubsystemId::VALVE1));
        flags.contains(ValveFlags::CLOSED)
    };
    if !stage.until(MOVE_MS, closed).await? {
        return Err(ended(text::DemoValveOpen.fixed()));
    }
    stage.ask(SubsystemId::CONTROL, Body::Stop).await?;
    match is_out {
        true => Ok(()),
        false => Err(ended(text::DemoNotPutOut.fixed())),
    }
}

/// Distance to a fire spot, m. Its lower edge is where flame and ground meet, and the barrel's
/// height above ground is known: distance = height / tan(angle below the horizon).
async fn distance(stage: &mut Stage, hotbed: &Hotbed) -> Result<i8, Failure> {
    let id = ParamId::of("Height");
    let answers = stage.ask(SubsystemId::CONTROL, Body::GetParam { id }).await?;
    let height_cm = match answers.first().decode().map(|answer| answer.data) {
        Ok(Reply::Param { values, .. }) => values.iter().next().unwrap_or(0),
        _ => 0,
    };
    let height_m = f64::from(height_cm) / 100.0;
    let below = -f64::from(hotbed.y1) / 60.0;
    let estimate_m = height_m / below.to_radians().tan();
    let angle = degrees(hotbed.y1);
    if below > 0.0 && PLAUSIBLE_M.contains(&estimate_m) {
        stage.say(
            text::DemoDistanceSeen {
                angle,
                height_m: format_args!("{height_m:.1}"),
                estimate_m: format_args!("{estimate_m:.0}"),
            }
            .of(current()),
        )?;
        return Ok(estimate_m.round() as i8);
    }
    let told_m = stage.range_of_nearest(f64::from(i32::midpoint(hotbed.x1, hotbed.x2)));
    stage
        .say(text::DemoDistanceTold { angle, told_m: format_args!("{told_m:.0}") }.of(current()))?;
    Ok(told_m.round().clamp(0.0, 127.0) as i8)
}

async fn wrap(stage: &mut Stage) -> Result<(), Failure> {
    stage.phase(text::DemoStowing.str(current()));
    stage.ask(SubsystemId::DEPLOYER, Body::Wrap).await?;
    let wrapped = |stage: &Stage| stage.scene().deployer_is(DeployerFlags::WRAPPED);
    if !stage.until(3 * MOVE_MS, wrapped).await? {
        return Err(ended(text::DemoNotStowed.fixed()));
    }
    stage.phase(text::DemoStandby.str(current()));
    stage.say(text::DemoStandbyAgain.str(current()))?;
    stage.pass(1000).await
}

fn ended(why: Fixed) -> Failure {
    Failure::Ended(why.str(current()).into())
}
