//! `lafet tune`: measures how a drive answers its motor, and sets StopLag and MinSpeed (ours, §D/9).

use clap::Args;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{DriveFlags, ValveFlags};
use lafet_proto::request::Body;
use lafet_proto::status::Limits;
use lafet_proto::{Request, SubsystemId};
use serde_json::{Value, json};

use crate::angle;
use crate::cli::{Global, drive};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::follow::{Follow, Step};
use crate::lang::pick;
use crate::out::{Out, columns};
use crate::undo::{States, Undo};

const DRIVES: [SubsystemId; 3] =
    [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
const VALVES: [SubsystemId; 2] = [SubsystemId::VALVE1, SubsystemId::VALVE2];
/// How far it moves to either side, arc-minutes and mm.
const SPAN: i32 = 300;
const SPAN_MM: i32 = 12;
/// A move so short begins slowly, arc-minutes and mm.
const SHORT: i32 = 10;
const SHORT_MM: i32 = 2;
/// Moves of each kind: the greatest MinSpeed and the middle StopLag count.
const MOVES: usize = 5;
/// InputFaults: a drive could not come to rest at its target; that of Vertical, the others follow.
const MISSED: i32 = 1 << 12;

/// Arguments of `lafet tune`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 tune\n  \
                        lafet -c tcp://127.0.0.1:10485 tune horizontal --dry-run")]
pub struct TuneArgs {
    /// The drive; without it Horizontal, Vertical and Nozzle in turn
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: Option<SubsystemId>,
    /// Measure and show, then set the parameters as they were
    #[arg(long)]
    dry_run: bool,
}

/// A parameter pair of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pair {
    lag_ms: i32,
    min_tenths: i32,
}

/// What the moves of one drive have shown.
struct Tuned {
    drive: SubsystemId,
    before: Pair,
    found: Pair,
    /// Distances from the target at rest, with the new values.
    errors: Vec<i32>,
}

/// Runs `lafet tune`: moves each drive with the valves closed, and sets what was measured.
pub async fn run(args: TuneArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    if args.drive == Some(SubsystemId::DEPLOYER) {
        return Err(Failure::Usage(
            pick(
                "Deployer goes from switch to switch: there is nothing to tune.",
                "Deployer движется между датчиками крайних положений: настраивать нечего.",
            )
            .into(),
        ));
    }
    let present = connection.monitor.limits_all().await?;
    let wanted = |drive: &SubsystemId| args.drive.is_none_or(|one| one == *drive);
    let mut all = Vec::new();
    for drive in DRIVES.into_iter().filter(wanted) {
        let Some((_, limits)) = present.iter().find(|(id, _)| *id == drive) else {
            if args.drive.is_some() {
                // Its own refusal says why it has no limits.
                connection.monitor.limits(drive).await?;
            }
            continue;
        };
        let tuning = Tuning { connection: &connection, drive };
        all.push(tuning.run(*limits, args.dry_run, out).await?);
    }
    out.show(table(&all, args.dry_run), || {
        let drives: Vec<Value> = all.iter().map(Tuned::json).collect();
        json!({ "drives": drives, "written": !args.dry_run })
    })
}

/// The tuning of one drive.
struct Tuning<'a> {
    connection: &'a Connection,
    drive: SubsystemId,
}

impl Tuning<'_> {
    /// Sets the parameters back when the tuning does not come to its end.
    async fn run(&self, limits: Limits, dry_run: bool, out: &mut Out) -> Result<Tuned, Failure> {
        self.dry().await?;
        let centre = self.centre(limits).await?;
        let before =
            Pair { lag_ms: self.read("StopLag").await?, min_tenths: self.read("MinSpeed").await? };
        let tuned = self.measure(centre, before, out).await;
        if dry_run || tuned.is_err() {
            let back = self.write(before).await;
            if let (Ok(_), Err(failure)) = (&tuned, back) {
                return Err(failure);
            }
        }
        tuned
    }

    async fn measure(&self, centre: i32, before: Pair, out: &mut Out) -> Result<Tuned, Failure> {
        let (span, short) = self.ways();
        let mut found = Pair { lag_ms: 0, min_tenths: 0 };
        self.write(found).await?;
        self.go(centre, out).await?;
        for number in 0..MOVES {
            self.go(centre + if number % 2 == 0 { short } else { 0 }, out).await?;
            found.min_tenths = found.min_tenths.max(self.read("MinSpeedSeen").await?);
        }
        self.write(found).await?;
        let mut lags = Vec::new();
        for number in 0..MOVES {
            let side = if number % 2 == 0 { span } else { -span };
            self.go(centre - side, out).await?;
            self.stop_on_the_way(centre - side, centre + side, out).await?;
            lags.push(self.read("StopLagSeen").await?);
        }
        lags.sort_unstable();
        found.lag_ms = lags.get(MOVES / 2).copied().unwrap_or_default();
        self.write(found).await?;
        let mut errors = Vec::new();
        for target in [centre + span, centre + span - short, centre - span, centre] {
            let at = self.go(target, out).await?;
            errors.push((at - target).abs());
        }
        self.check_arrivals().await?;
        Ok(Tuned { drive: self.drive, before, found, errors })
    }

    const fn ways(&self) -> (i32, i32) {
        match self.drive {
            SubsystemId::NOZZLE => (SPAN_MM, SHORT_MM),
            _ => (SPAN, SHORT),
        }
    }

    /// No valve may be open: the barrel swings.
    async fn dry(&self) -> Outcome {
        let states = States::read(self.connection, &VALVES).await?;
        for valve in VALVES {
            if states.of(valve).is_none() {
                continue;
            }
            let flags = ValveFlags::from_bits_retain(states.flags(valve));
            if !flags.contains(ValveFlags::CLOSED) || flags.contains(ValveFlags::OPENING) {
                return Err(Failure::Ended(pick(
                    format!(
                        "{valve} is not closed. Close it first: a drive is tuned without water."
                    ),
                    format!(
                        "{valve} не закрыт. Сначала закройте его: привод настраивают без воды."
                    ),
                )));
            }
        }
        Ok(())
    }

    /// The position nearest to the present one with room to both sides.
    async fn centre(&self, limits: Limits) -> Result<i32, Failure> {
        let (span, short) = self.ways();
        let (low, high) = (limits.min + span + short, limits.max - span - short);
        if low > high {
            let room = angle::show(self.drive, 2 * (span + short));
            return Err(Failure::Ended(pick(
                format!(
                    "The limits of {} leave less than {room}: too little to tune it.",
                    self.drive
                ),
                format!("Пределы {} оставляют меньше {room}: для настройки мало.", self.drive),
            )));
        }
        let states = States::read(self.connection, &[self.drive]).await?;
        Ok(position(&states, self.drive).unwrap_or(low).clamp(low, high))
    }

    async fn read(&self, name: &str) -> Result<i32, Failure> {
        let values = self.connection.monitor.param(self.drive, name).await?;
        Ok(values.first().copied().unwrap_or_default())
    }

    async fn write(&self, pair: Pair) -> Outcome {
        let monitor = &self.connection.monitor;
        monitor.set_param(self.drive, "StopLag", &[pair.lag_ms]).await?;
        monitor.set_param(self.drive, "MinSpeed", &[pair.min_tenths]).await?;
        Ok(())
    }

    /// Moves to a target and returns where it has come to rest.
    async fn go(&self, target: i32, out: &mut Out) -> Result<i32, Failure> {
        let drive = self.drive;
        let states = self.follow(target, out, |at, moves| match moves {
            true => Step::Running(progress(drive, at, target)),
            false if (at - target).abs() <= self.ways().1 => Step::Done,
            false => Step::Idle(pick(
                format!("{drive} stopped at {}.", angle::show(drive, at)),
                format!("{drive} остановился в {}.", angle::show(drive, at)),
            )),
        });
        let states = states.await?;
        Ok(position(&states, drive).unwrap_or(target))
    }

    /// Stops it at a third of the way, at speed, and waits until it has run out.
    async fn stop_on_the_way(&self, from: i32, target: i32, out: &mut Out) -> Outcome {
        let drive = self.drive;
        let third = (target - from).abs() / 3;
        let passing = self.follow(target, out, |at, moves| match moves {
            _ if (at - from).abs() >= third => Step::Done,
            true => Step::Running(progress(drive, at, target)),
            false => Step::Idle(super::motion::stopped(drive, 0)),
        });
        passing.await?;
        let rest =
            Follow { connection: self.connection, watch: &[drive], undo: Undo::everything() };
        let stop = Request::new(drive, Body::Stop);
        let judge = |states: &States| match moves(states, drive) {
            true => {
                Step::Running(progress(drive, position(states, drive).unwrap_or(target), target))
            }
            false => Step::Done,
        };
        rest.run(out, self.connection.send(&stop), judge).await?;
        Ok(())
    }

    async fn follow(
        &self,
        target: i32,
        out: &mut Out,
        mut judge: impl FnMut(i32, bool) -> Step,
    ) -> Result<States, Failure> {
        let drive = self.drive;
        let destination = target.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        let request = Request::new(drive, Body::Move { destination });
        let undo = Undo::of(&request).unwrap_or_default();
        let follow = Follow { connection: self.connection, watch: &[drive], undo };
        let judge = |states: &States| match position(states, drive) {
            Some(at) => judge(at, moves(states, drive)),
            None => Step::Ended(super::motion::stopped(drive, 0)),
        };
        follow.run(out, self.connection.send(&request), judge).await
    }

    async fn check_arrivals(&self) -> Outcome {
        let values = self.connection.monitor.param(SubsystemId::GENERAL, "InputFaults").await?;
        let axis = DRIVES_BY_BIT.iter().position(|drive| *drive == self.drive).unwrap_or_default();
        if values.first().copied().unwrap_or_default() & MISSED << axis == 0 {
            return Ok(());
        }
        Err(Failure::Ended(pick(
            format!(
                "{} does not come to rest at its target with any value. Check its gear for play and \
                 its motor for friction; the parameters are as they were.",
                self.drive
            ),
            format!(
                "{} не останавливается в заданном положении ни при каком значении. Проверьте люфт \
                 редуктора и трение; параметры прежние.",
                self.drive
            ),
        )))
    }
}

/// Drives in the order of the bits of InputFaults.
const DRIVES_BY_BIT: [SubsystemId; 3] =
    [SubsystemId::VERTICAL, SubsystemId::HORIZONTAL, SubsystemId::NOZZLE];

fn position(states: &States, drive: SubsystemId) -> Option<i32> {
    match states.of(drive)?.decode().ok()?.data {
        Reply::Drive(status) => Some(i32::from(status.position)),
        _ => None,
    }
}

fn moves(states: &States, drive: SubsystemId) -> bool {
    DriveFlags::from_bits_retain(states.flags(drive)).contains(DriveFlags::MOVE)
}

fn progress(drive: SubsystemId, at: i32, target: i32) -> String {
    format!("{drive} {} → {}", angle::show(drive, at), angle::show(drive, target))
}

fn table(all: &[Tuned], dry_run: bool) -> String {
    let titles = pick(
        ["drive", "StopLag, ms", "MinSpeed, ×0.1", "error at rest"],
        ["привод", "StopLag, мс", "MinSpeed, ×0,1", "ошибка в покое"],
    );
    let mut rows = vec![titles.map(str::to_owned).to_vec()];
    rows.extend(all.iter().map(|tuned| {
        let Tuned { drive, before, found, .. } = tuned;
        vec![
            drive.to_string(),
            format!("{} → {}", before.lag_ms, found.lag_ms),
            format!("{} → {}", before.min_tenths, found.min_tenths),
            angle::show(*drive, tuned.worst()),
        ]
    }));
    let end = match dry_run {
        true => pick("Nothing was written.", "Ничего не записано."),
        false => pick("Written to the monitor.", "Записано в ствол."),
    };
    format!("{}\n{end}", columns(&rows))
}

impl Tuned {
    fn worst(&self) -> i32 {
        self.errors.iter().copied().max().unwrap_or_default()
    }

    fn json(&self) -> Value {
        let pair = |pair: Pair| json!({ "StopLag": pair.lag_ms, "MinSpeed": pair.min_tenths });
        json!({
            "drive": self.drive.to_string(),
            "before": pair(self.before),
            "found": pair(self.found),
            "errors": self.errors,
        })
    }
}
