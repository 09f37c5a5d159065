//! §D/9 (ours) Tuning a drive: how late it follows its command (StopLag), and below which speed it does
//! not turn (MinSpeed).
//!
//! ```text
//! StopLag = MinSpeed = 0 ─▶ short moves: MinSpeedSeen ─▶ stops at speed: StopLagSeen ─▶ four arrivals
//!                           the greatest counts          the middle one counts          the error
//! ```
//!
//! The procedure is here; how a request is sent, watched and broken off is the [`Bench`]'s. Nothing moves
//! unless every valve is closed and no water flows, and that is looked at as often as the position.

pub mod kept;

use std::fmt;
use std::future::Future;

use lafet_proto::answer::Reply;
use lafet_proto::flags::{DriveFlags, ValveFlags};
use lafet_proto::request::Body;
use lafet_proto::status::Limits;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Argument, Decimal, Lang, Shown, Text, client as text};

use crate::answers::AnswerBuf;
use kept::Kept;

/// The drives that can be tuned.
pub const DRIVES: [SubsystemId; 3] =
    [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
/// The parameters that are set.
pub const STOP_LAG: &str = "StopLag";
/// See [`STOP_LAG`].
pub const MIN_SPEED: &str = "MinSpeed";

/// How far it moves to either side, arc-minutes and mm.
const SPAN: i32 = 300;
const SPAN_MM: i32 = 12;
/// A move so short begins slowly, arc-minutes and mm.
const SHORT: i32 = 10;
const SHORT_MM: i32 = 2;
/// Moves of each kind.
const MOVES: usize = 5;
/// Arrivals with the new values.
const ARRIVALS: usize = 4;
/// All moves: to the centre, short ones, back and forth, arrivals.
const STEPS: usize = 1 + MOVES + 2 * MOVES + ARRIVALS;
/// Looks in a row at the same position after which a drive rests.
const STILL: usize = 8;
/// From this flow on water flows, l/s; less may be the rounding of a meter.
const FLOWING_LPS: u16 = 2;
/// InputFaults: a drive could not come to rest at its target; that of Vertical, the others follow.
const MISSED: i32 = 1 << 12;
/// Drives in the order of these bits.
const MISSED_OF: [SubsystemId; 3] =
    [SubsystemId::VERTICAL, SubsystemId::HORIZONTAL, SubsystemId::NOZZLE];

/// StopLag and MinSpeed of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pair {
    /// StopLag, ms.
    pub lag_ms: i32,
    /// MinSpeed, in tenths of its unit.
    pub min_tenths: i32,
}

/// What the moves of a drive have shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tuned {
    /// The drive.
    pub drive: SubsystemId,
    /// The values before.
    pub before: Pair,
    /// The values measured.
    pub found: Pair,
    /// Distances from the target at rest with the measured values, arc-minutes and mm.
    pub errors: Vec<i32>,
}

/// What is known of the drive and of the water at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Position, arc-minutes and mm.
    pub position: i32,
    /// Whether the drive moves.
    pub moves: bool,
    /// Why nothing may move.
    pub trouble: Option<Trouble>,
}

/// What a look means for the request that is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// It is carried out.
    Running,
    /// It has not started, or has ended before its target.
    Idle(Trouble),
    /// It has reached what was wanted.
    Done,
    /// It must not go on.
    Ended(Trouble),
}

/// Why a drive cannot be tuned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trouble {
    /// This valve is not closed.
    NotClosed(SubsystemId),
    /// Water flows.
    Water,
    /// The drive reports no position.
    NoPosition(SubsystemId),
    /// Its limits are off, or it is not homed: a Move goes on until something stops it (§3.1/8).
    LimitsOff(SubsystemId),
    /// The limits leave less than this, arc-minutes and mm.
    LittleRoom(SubsystemId, i32),
    /// It has stopped here, before its target.
    Stopped(SubsystemId, i32),
    /// It does not come to rest at its target with any value.
    NeverArrives(SubsystemId),
}

/// Who carries the tuning out.
pub trait Bench: Send {
    /// Why a step was not done.
    type Error: From<Trouble> + Send;

    /// Reads a parameter of the drive.
    fn param(
        &mut self,
        drive: SubsystemId,
        name: &'static str,
    ) -> impl Future<Output = Result<i32, Self::Error>> + Send;

    /// Sets a parameter of the drive. One that the monitor could not store should be an error: the next reset
    /// brings the value before back.
    fn set_param(
        &mut self,
        drive: SubsystemId,
        name: &'static str,
        value: i32,
    ) -> impl Future<Output = Result<(), Self::Error>> + Send;

    /// Reads the subsystems of [`watched`]; [`Look::of`] says what they mean.
    fn look(
        &mut self,
        drive: SubsystemId,
    ) -> impl Future<Output = Result<Look, Self::Error>> + Send;

    /// Sends a request, and looks until `judge` says that it is over; returns the last look. Unless that is
    /// [`Judged::Done`], everything that the request has started must be stopped.
    fn follow(
        &mut self,
        drive: SubsystemId,
        request: Request<'static>,
        judge: impl FnMut(&Look) -> Judged + Send,
    ) -> impl Future<Output = Result<Look, Self::Error>> + Send;

    /// Puts it on the disk, before anything of it is set: see [`kept`].
    fn keep(&mut self, kept: &Kept) -> impl Future<Output = Result<(), Self::Error>> + Send;

    /// So many of the moves are done.
    fn progress(&mut self, _done: usize, _of: usize) {}
}

/// The subsystems whose states make a look.
pub const fn watched(drive: SubsystemId) -> [SubsystemId; 4] {
    [drive, SubsystemId::VALVE1, SubsystemId::VALVE2, SubsystemId::GENERAL]
}

impl Look {
    /// Reads the states of [`watched`]; those that the monitor does not have may be missing.
    ///
    /// # Errors
    ///
    /// [`Trouble::NoPosition`] without a state of the drive.
    pub fn of<'a>(
        drive: SubsystemId,
        states: impl Iterator<Item = &'a AnswerBuf>,
    ) -> Result<Self, Trouble> {
        let (mut at, mut trouble, mut limitless) = (None, None, None);
        for state in states.filter(|state| state.status().is_success()) {
            let Ok(answer) = state.decode() else { continue };
            match answer.data {
                Reply::Drive(status) if state.from() == drive => {
                    let moves = status.flags.contains(DriveFlags::MOVE);
                    at = Some((i32::from(status.position), moves));
                    let off = status.flags.contains(DriveFlags::LIMITLESS);
                    limitless = off.then_some(Trouble::LimitsOff(drive));
                }
                Reply::Valve(status) => {
                    let (flags, closed) = (status.flags, ValveFlags::CLOSED);
                    if !flags.contains(closed) || flags.contains(ValveFlags::OPENING) {
                        trouble = Some(Trouble::NotClosed(state.from()));
                    }
                }
                Reply::General(status) if status.flowrate >= FLOWING_LPS => {
                    trouble = trouble.or(Some(Trouble::Water));
                }
                _ => {}
            }
        }
        let (position, moves) = at.ok_or(Trouble::NoPosition(drive))?;
        Ok(Self { position, moves, trouble: trouble.or(limitless) })
    }

    /// Nothing may move while water flows or may flow, or without limits.
    fn safe(self) -> Result<Self, Trouble> {
        self.trouble.map_or(Ok(self), Err)
    }
}

/// The tuning of one drive.
#[derive(Debug)]
pub struct Tuning {
    drive: SubsystemId,
    centre: i32,
    before: Pair,
    done: usize,
}

impl Tuning {
    /// Looks whether the drive can be tuned, and reads its present values. Nothing moves.
    ///
    /// # Errors
    ///
    /// An open valve, water, limits that are off or leave no room, and those of the bench.
    pub async fn new<B: Bench>(
        bench: &mut B,
        drive: SubsystemId,
        limits: Limits,
    ) -> Result<Self, B::Error> {
        let look = bench.look(drive).await?.safe()?;
        let (span, short) = distances(drive);
        let (low, high) = (limits.min + span + short, limits.max - span - short);
        if low > high {
            return Err(Trouble::LittleRoom(drive, 2 * (span + short)).into());
        }
        let before = Pair {
            lag_ms: bench.param(drive, STOP_LAG).await?,
            min_tenths: bench.param(drive, MIN_SPEED).await?,
        };
        Ok(Self { drive, centre: look.position.clamp(low, high), before, done: 0 })
    }

    /// The values before, which are to be written back unless those measured are kept.
    pub const fn before(&self) -> Pair {
        self.before
    }

    /// Moves the drive. Afterwards the measured values are in force; after an error it is not known which.
    ///
    /// # Errors
    ///
    /// Water, limits that are off, a drive that stops before its target or never rests at it, and those of the
    /// bench.
    pub async fn measure<B: Bench>(&mut self, bench: &mut B) -> Result<Tuned, B::Error> {
        let Self { drive, centre, before, .. } = *self;
        let (span, short) = distances(drive);
        let mut found = Pair::default();
        let mut kept = Kept { drive, before, set: Vec::new() };
        keep_and_write(bench, &mut kept, found).await?;
        self.go(bench, centre).await?;
        for number in 0..MOVES {
            self.go(bench, centre + if number % 2 == 0 { short } else { 0 }).await?;
            found.min_tenths = found.min_tenths.max(bench.param(drive, "MinSpeedSeen").await?);
        }
        keep_and_write(bench, &mut kept, found).await?;
        let mut lags = Vec::new();
        for number in 0..MOVES {
            let side = if number % 2 == 0 { span } else { -span };
            self.go(bench, centre - side).await?;
            self.stop_at_speed(bench, centre - side, centre + side).await?;
            lags.push(bench.param(drive, "StopLagSeen").await?);
        }
        lags.sort_unstable();
        found.lag_ms = lags.get(MOVES / 2).copied().unwrap_or_default();
        keep_and_write(bench, &mut kept, found).await?;
        let mut errors = Vec::new();
        for target in [centre + span, centre + span - short, centre - span, centre] {
            errors.push((self.go(bench, target).await? - target).abs());
        }
        let faults = bench.param(SubsystemId::GENERAL, "InputFaults").await?;
        if faults & missed(drive) != 0 {
            return Err(Trouble::NeverArrives(drive).into());
        }
        Ok(Tuned { drive, before, found, errors })
    }

    /// Moves to a target and returns where it has come to rest.
    async fn go<B: Bench>(&mut self, bench: &mut B, target: i32) -> Result<i32, B::Error> {
        let drive = self.drive;
        let near = distances(drive).1;
        let look = bench.follow(drive, to(drive, target), move |look| match look.safe() {
            Err(trouble) => Judged::Ended(trouble),
            Ok(_) if look.moves => Judged::Running,
            Ok(_) if (look.position - target).abs() <= near => Judged::Done,
            Ok(_) => Judged::Idle(Trouble::Stopped(drive, look.position)),
        });
        let look = look.await?;
        self.is_done(bench);
        Ok(look.position)
    }

    /// Stops it after a third of the way, at speed, and waits until it has run out.
    async fn stop_at_speed<B: Bench>(
        &mut self,
        bench: &mut B,
        from: i32,
        target: i32,
    ) -> Result<(), B::Error> {
        let drive = self.drive;
        let third = (target - from).abs() / 3;
        let passing = bench.follow(drive, to(drive, target), move |look| match look.safe() {
            Err(trouble) => Judged::Ended(trouble),
            Ok(_) if (look.position - from).abs() >= third => Judged::Done,
            Ok(_) if look.moves => Judged::Running,
            Ok(_) => Judged::Idle(Trouble::Stopped(drive, look.position)),
        });
        passing.await?;
        let stop = Request::new(drive, Body::Stop);
        // What it runs out is measured once it has been at rest for a moment.
        let (mut still, mut last) = (0, None);
        let rest = bench.follow(drive, stop, move |look| {
            let rests = !look.moves && last.replace(look.position) == Some(look.position);
            still = if rests { still + 1 } else { 0 };
            if still >= STILL { Judged::Done } else { Judged::Running }
        });
        rest.await?;
        self.is_done(bench);
        Ok(())
    }

    fn is_done<B: Bench>(&mut self, bench: &mut B) {
        self.done += 1;
        bench.progress(self.done, STEPS);
    }
}

/// What is set is noted first, so that a program killed in between finds it.
async fn keep_and_write<B: Bench>(
    bench: &mut B,
    kept: &mut Kept,
    pair: Pair,
) -> Result<(), B::Error> {
    kept.set.push(pair);
    bench.keep(kept).await?;
    write(bench, kept.drive, pair).await
}

/// Sets both values, the second even if the first fails.
///
/// # Errors
///
/// The first of the bench.
pub async fn write<B: Bench>(
    bench: &mut B,
    drive: SubsystemId,
    pair: Pair,
) -> Result<(), B::Error> {
    let lag = bench.set_param(drive, STOP_LAG, pair.lag_ms).await;
    let min = bench.set_param(drive, MIN_SPEED, pair.min_tenths).await;
    lag.and(min)
}

/// To either side, and of a short move.
const fn distances(drive: SubsystemId) -> (i32, i32) {
    match drive {
        SubsystemId::NOZZLE => (SPAN_MM, SHORT_MM),
        _ => (SPAN, SHORT),
    }
}

fn to(drive: SubsystemId, target: i32) -> Request<'static> {
    let destination = target.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
    Request::new(drive, Body::Move { destination })
}

fn missed(drive: SubsystemId) -> i32 {
    MISSED << MISSED_OF.iter().position(|one| *one == drive).unwrap_or_default()
}

/// What it is, and what to do.
impl Argument for Trouble {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match *self {
            Self::NotClosed(valve) => text::TuneValveOpen { valve: Shown(valve) }.write(lang, out),
            Self::Water => text::TuneWater.write(lang, out),
            Self::NoPosition(drive) => {
                text::TuneNoPosition { drive: Shown(drive) }.write(lang, out)
            }
            Self::LimitsOff(drive) => text::TuneLimitsOff { drive: Shown(drive) }.write(lang, out),
            Self::LittleRoom(drive, room) => {
                let room = distance(drive, room, lang);
                text::TuneTooLittleRoom { drive: Shown(drive), room }.write(lang, out)
            }
            Self::Stopped(drive, at) => {
                text::TuneStopped { drive: Shown(drive), at: distance(drive, at, lang) }
                    .write(lang, out)
            }
            Self::NeverArrives(drive) => text::TuneNoValue { drive: Shown(drive) }.write(lang, out),
        }
    }
}

impl Text for Trouble {}

/// `5.2°`, `12 mm`.
fn distance(drive: SubsystemId, value: i32, lang: Lang) -> String {
    if drive == SubsystemId::NOZZLE {
        return text::TuneMm { distance: value }.of(lang);
    }
    text::TuneDegrees { distance: Decimal(f64::from(value) / 60.0, 1) }.of(lang)
}

#[cfg(test)]
mod tests {
    use lafet_proto::{Record, RequestId, Status};

    use super::*;

    /// A drive that is where it was sent, until a step at which something happens.
    #[derive(Default)]
    struct Fake {
        position: i32,
        moves: usize,
        wet_after: Option<usize>,
        written: Vec<(&'static str, i32)>,
        kept: Vec<Kept>,
        value: Option<i32>,
        fails: bool,
        sent: Vec<String>,
        faults: i32,
        progress: (usize, usize),
    }

    impl Fake {
        fn seen(&self) -> Look {
            let wet = self.wet_after.is_some_and(|after| self.moves > after);
            Look { position: self.position, moves: false, trouble: wet.then_some(Trouble::Water) }
        }
    }

    impl Bench for Fake {
        type Error = Trouble;

        async fn param(&mut self, _: SubsystemId, name: &'static str) -> Result<i32, Trouble> {
            Ok(match name {
                "MinSpeedSeen" => 12,
                "StopLagSeen" => 280 + self.moves as i32,
                "InputFaults" => self.faults,
                _ => self.value.unwrap_or(7),
            })
        }

        async fn set_param(
            &mut self,
            _: SubsystemId,
            name: &'static str,
            value: i32,
        ) -> Result<(), Trouble> {
            self.written.push((name, value));
            if self.fails { Err(Trouble::Water) } else { Ok(()) }
        }

        async fn keep(&mut self, kept: &Kept) -> Result<(), Trouble> {
            let set = kept.set.len();
            assert_eq!(self.written.len(), 2 * (set - 1), "noted before it is set");
            self.kept.push(kept.clone());
            Ok(())
        }

        async fn look(&mut self, _: SubsystemId) -> Result<Look, Trouble> {
            Ok(self.seen())
        }

        async fn follow(
            &mut self,
            _: SubsystemId,
            request: Request<'static>,
            mut judge: impl FnMut(&Look) -> Judged + Send,
        ) -> Result<Look, Trouble> {
            self.sent.push(request.to_string());
            if let Body::Move { destination } = request.body {
                (self.position, self.moves) = (destination.into(), self.moves + 1);
            }
            let look = self.seen();
            for _ in 0..2 * STILL {
                match judge(&look) {
                    Judged::Done => return Ok(look),
                    Judged::Running => {}
                    Judged::Idle(trouble) | Judged::Ended(trouble) => return Err(trouble),
                }
            }
            panic!("{request:?} has no end");
        }

        fn progress(&mut self, done: usize, of: usize) {
            self.progress = (done, of);
        }
    }

    const DRIVE: SubsystemId = SubsystemId::HORIZONTAL;
    const WIDE: Limits = Limits { min: -5000, max: 5000 };

    fn run<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(future)
    }

    #[test]
    fn all_moves_are_within_the_span_and_the_values_are_those_seen() {
        let mut fake = Fake { position: 4990, ..Fake::default() };
        let mut tuning = run(Tuning::new(&mut fake, DRIVE, WIDE)).unwrap();
        let before = Pair { lag_ms: 7, min_tenths: 7 };
        assert_eq!(tuning.before(), before);
        assert!(
            fake.sent.is_empty() && fake.written.is_empty(),
            "nothing moves before it is started"
        );
        let tuned = run(tuning.measure(&mut fake)).unwrap();
        assert_eq!(tuned.found.min_tenths, 12);
        assert!(tuned.found.lag_ms > 280 && tuned.errors == [0; ARRIVALS], "{tuned:?}");
        assert_eq!(fake.progress, (STEPS, STEPS));
        let moves = fake.sent.iter().filter_map(|text| text.strip_prefix("Move Horizontal "));
        let targets: Vec<i32> = moves.map(|text| text.parse().unwrap()).collect();
        let centre = WIDE.max - SPAN - SHORT;
        assert!(targets.iter().all(|at| (at - centre).abs() <= SPAN), "{targets:?}");
        assert_eq!(fake.written[..2], [(STOP_LAG, 0), (MIN_SPEED, 0)]);
        assert_eq!(fake.written[4..], [(STOP_LAG, tuned.found.lag_ms), (MIN_SPEED, 12)]);
    }

    /// All that was set is in the note; what another client has set since is left alone.
    #[test]
    fn what_was_cut_off_is_put_back() {
        let mut fake = Fake::default();
        let mut tuning = run(Tuning::new(&mut fake, DRIVE, WIDE)).unwrap();
        let tuned = run(tuning.measure(&mut fake)).unwrap();
        let kept = fake.kept.pop().unwrap();
        assert_eq!((kept.drive, kept.before), (DRIVE, tuned.before));
        assert_eq!(
            (kept.set.first(), kept.set.last()),
            (Some(&Pair::default()), Some(&tuned.found))
        );
        let put_back = |value| {
            let mut fake = Fake { value: Some(value), ..Fake::default() };
            run(kept::put_back(&mut fake, &kept)).unwrap();
            fake.written
        };
        assert_eq!(put_back(0), [(STOP_LAG, 7), (MIN_SPEED, 7)]);
        assert_eq!(put_back(12), [(MIN_SPEED, 7)], "12 was never a StopLag of the tuning");
        assert_eq!(put_back(7), [(STOP_LAG, 7), (MIN_SPEED, 7)], "in force, maybe not stored");
        assert!(put_back(99).is_empty());
        // A value that cannot be set does not keep the other from being put back.
        let mut fake = Fake { value: Some(0), fails: true, ..Fake::default() };
        assert_eq!(run(kept::put_back(&mut fake, &kept)), Err(Trouble::Water));
        assert_eq!(fake.written, [(STOP_LAG, 7), (MIN_SPEED, 7)]);
        fake.written.clear();
        let before = Pair { lag_ms: 7, min_tenths: 7 };
        assert_eq!(run(write(&mut fake, DRIVE, before)), Err(Trouble::Water));
        assert_eq!(fake.written, [(STOP_LAG, 7), (MIN_SPEED, 7)]);
    }

    #[test]
    fn water_limits_and_a_drive_that_never_rests_end_it() {
        let mut wet = Fake { wet_after: Some(3), ..Fake::default() };
        let mut tuning = run(Tuning::new(&mut wet, DRIVE, WIDE)).unwrap();
        assert_eq!(run(tuning.measure(&mut wet)).unwrap_err(), Trouble::Water);
        assert_eq!(wet.moves, 4, "no move after it");
        assert_eq!(run(Tuning::new(&mut wet, DRIVE, WIDE)).unwrap_err(), Trouble::Water);
        let narrow = Limits { min: -300, max: 300 };
        let little = run(Tuning::new(&mut Fake::default(), DRIVE, narrow)).unwrap_err();
        assert_eq!(little, Trouble::LittleRoom(DRIVE, 2 * (SPAN + SHORT)));
        assert!(little.of(Lang::Ru).contains("10,3°"), "{}", little.of(Lang::Ru));
        let mut loose = Fake { faults: missed(DRIVE), ..Fake::default() };
        let mut tuning = run(Tuning::new(&mut loose, DRIVE, WIDE)).unwrap();
        assert_eq!(run(tuning.measure(&mut loose)).unwrap_err(), Trouble::NeverArrives(DRIVE));
    }

    /// The answer of a subsystem to GetStatus.
    fn state(from: SubsystemId, flags: u32, rest: &[u8]) -> AnswerBuf {
        let data: Vec<u8> = flags.to_le_bytes().iter().chain(rest).copied().collect();
        let (request, status) = (RequestId::GET_STATUS, Status::OK);
        AnswerBuf::new(&Record { request, device: from, status, data: &data })
    }

    /// §3.1/8 Without limits a Move goes on to the mechanical end.
    #[test]
    fn a_drive_without_limits_does_not_move() {
        let look = |flags: DriveFlags, valve: ValveFlags| {
            let states = [
                state(DRIVE, flags.bits(), &[10, 0, 0, 0]),
                state(SubsystemId::VALVE1, valve.bits(), &[]),
            ];
            Look::of(DRIVE, states.iter()).unwrap()
        };
        let on = look(DriveFlags::empty(), ValveFlags::CLOSED);
        assert_eq!((on.position, on.trouble), (10, None));
        let off = look(DriveFlags::LIMITLESS, ValveFlags::CLOSED);
        assert_eq!(off.trouble, Some(Trouble::LimitsOff(DRIVE)));
        assert_eq!(off.safe(), Err(Trouble::LimitsOff(DRIVE)));
        let open = look(DriveFlags::LIMITLESS, ValveFlags::OPEN);
        assert_eq!(open.trouble, Some(Trouble::NotClosed(SubsystemId::VALVE1)), "it comes first");
        for lang in Lang::ALL {
            assert!(Trouble::LimitsOff(DRIVE).of(lang).contains("Horizontal"));
        }
    }
}
