//! Safety of the tests: what may move, what is restored, when to stop everything.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Fixed, Text as _, conform as text};

use crate::Level;
use crate::bench::{Bench, Exchange};
use crate::checks::{self, bits};
use crate::raw::{self, Rec};
use crate::verdict::{Halt, Note, Step, fail, must};

/// Drives that aim.
pub const AIMING: [S; 3] = [S::HORIZONTAL, S::VERTICAL, S::NOZZLE];
/// All drives.
pub const DRIVES: [S; 4] = [S::DEPLOYER, S::NOZZLE, S::HORIZONTAL, S::VERTICAL];
/// Valves.
pub const VALVES: [S; 2] = [S::VALVE1, S::VALVE2];
/// Highest speed of a drive with --motion, ° or mm per second.
const SLOW: i32 = 5;
/// Longest times for a monitor to come to rest, to deploy or stow, and to reset, ms.
pub const REST_MS: u64 = 60_000;
pub const FOLD_MS: u64 = 90_000;
pub const RESET_MS: u64 = 30_000;
/// How many times an undo is tried, and how late an answer may come before that, ms.
const UNDO_TRIES: u32 = 4;
const LATE_MS: u64 = 500;
/// Change of a position that is jitter of the sensor, not motion.
const JITTER: i32 = 12;
/// Distance from the initial position that is not moved back, arc-minutes or mm.
const AT_HOME: u32 = 2;
/// Longest time for a unit that is busy to switch its limits on, ms.
const LIMITS_MS: u64 = 5000;

/// State of the monitor at the start.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Subsystems of the monitor, in the order of the chain.
    pub present: Vec<S>,
    /// It was stowed.
    pub wrapped: bool,
    /// It was locked out: only reads are tested.
    pub locked_out: bool,
    /// Positions of the drives at the start.
    pub positions: Vec<(S, i32)>,
    /// Positions last seen.
    pub seen: Vec<(S, i32)>,
    /// The answers of all subsystems fit into one frame.
    pub fits: bool,
}

/// A change that a test has made.
#[derive(Clone, Debug)]
pub enum Undo {
    /// A parameter had this value.
    Param(S, &'static str, i32),
    /// A parameter had these values.
    Values(S, &'static str, Vec<i32>),
    /// The lockout was seen off just before it was switched on.
    Lockout,
    /// Limits were on.
    Limits,
    /// A valve was closed.
    Valve(S),
    /// The stored parameters had these values.
    Memory(checks::Kept),
}

/// An answer of the first look that breaks the protocol.
#[derive(Debug)]
pub struct Odd {
    /// What the protocol requires.
    pub expected: Note,
    /// What came.
    pub found: Note,
    /// The exchanges before it, the last one with its bytes.
    pub log: Vec<Exchange>,
    /// There was no answer.
    pub silent: bool,
}

impl Bench<'_> {
    /// Finds the subsystems, without changing anything, and fails if the monitor is at work. `odd` takes
    /// the answers that break the protocol, and the look goes on.
    pub fn look(&mut self, odd: &mut Vec<Odd>) -> Step {
        self.found = Found::default();
        for id in S::CHAIN {
            let asked = self.ask(R::GET_STATUS, id, &[]);
            let rec = self.unless_odd(asked, odd)?;
            // What is answered, however badly, is there.
            let there = rec.map_or(!self.silent, |rec| rec.status != Status::MODULE_NOT_EXIST);
            if there {
                self.found.present.push(id);
            }
        }
        let answers = self.frame(&Rec::new(R::GET_STATUS, S::ALL, &[]).bytes());
        let answers = self.unless_odd(answers, odd)?;
        let fits = |all: &Vec<Rec>| all.iter().all(|rec| rec.status != Status::NO_ROOM);
        self.found.fits = answers.as_ref().is_some_and(fits);
        for id in DRIVES {
            if self.has(id) {
                let drive = self.drive(id);
                let drive = self.unless_odd(drive, odd)?;
                self.found.positions.extend(drive.map(|(_, position)| (id, position)));
            }
        }
        self.found.seen.clone_from(&self.found.positions);
        let flags = self.flags(S::GENERAL);
        let flags = self.unless_odd(flags, odd)?.unwrap_or(0);
        self.found.locked_out = flags & bits::LOCKED_OUT != 0;
        if self.has(S::DEPLOYER) {
            let flags = self.flags(S::DEPLOYER);
            let flags = self.unless_odd(flags, odd)?.unwrap_or(0);
            self.found.wrapped = flags & bits::WRAPPED != 0;
        }
        let ready = self.is_ready();
        self.unless_odd(ready, odd)?;
        Ok(())
    }

    /// The result of a step of the first look; `None` if its answer breaks the protocol. A monitor that
    /// has never answered ends the look, and so does a second silence: it takes long.
    fn unless_odd<T>(&mut self, step: Step<T>, odd: &mut Vec<Odd>) -> Step<Option<T>> {
        match step {
            Ok(found) => Ok(Some(found)),
            Err(Halt::Fail { expected, found })
                if self.was_answered && !(self.silent && odd.iter().any(|odd| odd.silent)) =>
            {
                let (log, silent) = (std::mem::take(&mut self.log), self.silent);
                odd.push(Odd { expected, found, log, silent });
                Ok(None)
            }
            Err(halt) => Err(halt),
        }
    }

    /// Fails if the monitor is at work; a monitor to be moved must also be ready for it.
    fn is_ready(&mut self) -> Step {
        let not = |why: Fixed| Err(Halt::Abort(why.words()));
        let states = self.states()?;
        if self.moving(&states).is_some() {
            return not(text::AtWork.fixed());
        }
        for (id, busy) in [
            (S::CONTROL, bits::QUENCH | bits::TRAJECTORY),
            (S::DETECTOR, bits::SEARCHING | bits::JUSTIFYING),
        ] {
            if self.has(id) && self.flags(id)? & busy != 0 {
                return not(text::ProgramOrSearchRuns.fixed());
            }
        }
        if self.options.level == Level::ReadOnly {
            return Ok(());
        }
        if self.found.locked_out {
            return not(text::LockedOutByOthers.fixed());
        }
        for valve in VALVES {
            if self.has(valve) && self.flags(valve)? & bits::CLOSED == 0 {
                return not(text::ValveNotClosed.fixed());
            }
        }
        self.has_limits()
    }

    /// Fails if limits of a drive are off: nothing would stop it before its end, and limits that were
    /// set meanwhile would be lost when the tester switches them on.
    fn has_limits(&mut self) -> Step {
        for id in DRIVES {
            if self.has(id) && self.flags(id)? & bits::LIMITLESS != 0 {
                let found = format!("{}: Limitless", raw::name(id.name(), id.0));
                let expected = text::LimitsStayOn;
                return Err(Halt::Abort(text::ExpectedAndFound { expected, found }.words()));
            }
        }
        Ok(())
    }

    /// With --motion, lowers the speed of drives whose Speed parameter the monitor has; `undo` takes
    /// what has to be restored, also after a failure.
    pub fn slow_down(&mut self, undo: &mut Vec<Undo>) -> Step {
        if self.options.level != Level::Motion {
            return Ok(());
        }
        for id in AIMING {
            if !self.has(id) {
                continue;
            }
            if let Some([speed, ..]) = self.get(id, "Speed")?.as_deref()
                && *speed > SLOW
            {
                undo.push(Undo::Param(id, "Speed", *speed));
                // A monitor that refuses keeps its speed.
                self.try_set(id, "Speed", &[SLOW])?;
            }
        }
        Ok(())
    }

    /// States of all subsystems, in as many frames as needed.
    pub fn states(&mut self) -> Step<Vec<Rec>> {
        if self.found.fits {
            return self.frame(&Rec::new(R::GET_STATUS, S::ALL, &[]).bytes());
        }
        let present = self.found.present.clone();
        present.into_iter().map(|id| self.ask(R::GET_STATUS, id, &[])).collect()
    }

    /// A subsystem that moves or flows although no request asked for it.
    fn moving(&mut self, states: &[Rec]) -> Option<String> {
        let mut found = None;
        for rec in states {
            let Some(flags) = rec.flags() else { continue };
            let id = rec.device;
            let name = raw::name(id.name(), id.0);
            if id.is_drive() && !self.movers.contains(&id) {
                let position = rec.i16_at(4).map_or(0, i32::from);
                let away = self.see(id, position);
                if flags & bits::MOVE != 0 || away > JITTER.unsigned_abs() {
                    found = Some(name);
                }
            } else if id.is_drive() {
                let position = rec.i16_at(4).map_or(0, i32::from);
                self.see(id, position);
            } else if id.is_valve() && !self.water {
                let wet = bits::OPENING
                    | if self.options.level > Level::ReadOnly { bits::OPEN } else { 0 };
                if flags & wet != 0 {
                    found = Some(name);
                }
            }
        }
        found
    }

    /// Records a drive's position; returns the distance from the previous one.
    fn see(&mut self, id: S, position: i32) -> u32 {
        match self.found.seen.iter_mut().find(|(seen, _)| *seen == id) {
            Some((_, last)) => std::mem::replace(last, position).abs_diff(position),
            None => {
                self.found.seen.push((id, position));
                0
            }
        }
    }

    /// Ends everything if something moves unasked, or if others have locked the monitor out.
    pub fn watch(&mut self) -> Step {
        // Where the states cannot be read, nothing is moved.
        if self.restoring || self.blind {
            return Ok(());
        }
        let states = self.states()?;
        if let Some(name) = self.moving(&states) {
            return Err(Halt::Abort(text::MovesUnasked { name }.words()));
        }
        let general = states.iter().find(|rec| rec.device == S::GENERAL);
        self.is_ours(general.and_then(Rec::flags).unwrap_or(0))
    }

    /// Before the monitor is locked out: only what was not locked out is released again. A lockout by
    /// others within the time of one exchange cannot be distinguished.
    pub fn locks_out(&mut self) -> Step {
        if !self.has_locked_out() {
            self.unlocked()?;
            self.undo.push(Undo::Lockout);
        }
        Ok(())
    }

    /// Ends everything if others have locked the monitor out.
    pub fn unlocked(&mut self) -> Step {
        let flags = self.flags(S::GENERAL)?;
        self.is_ours(flags)
    }

    fn has_locked_out(&self) -> bool {
        self.undo.iter().any(|undo| matches!(undo, Undo::Lockout))
    }

    /// A lockout that began during the run and is not the tester's is left alone, and ends a run that
    /// moves the monitor.
    fn is_ours(&self, flags: u32) -> Step {
        let others = flags & bits::LOCKED_OUT != 0 && !self.has_locked_out();
        if others && self.options.level > Level::ReadOnly {
            return Err(Halt::Abort(text::LockedOutByOthers.words()));
        }
        Ok(())
    }

    /// Permits these subsystems to move.
    pub fn moves(&mut self, ids: &[S]) {
        let before = std::mem::replace(&mut self.movers, ids.to_vec());
        // Drives permitted until now have moved since they were last seen.
        self.found.seen.retain(|(id, _)| !before.contains(id));
    }

    /// Permits the motion of everything that moves during deploying and stowing.
    pub fn folds(&mut self) {
        self.moves(&[S::DEPLOYER, S::HORIZONTAL, S::VERTICAL]);
    }

    /// Brings the monitor into working position.
    pub fn deployed(&mut self) -> Step {
        if !self.has(S::DEPLOYER) || self.flags(S::DEPLOYER)? & bits::DEPLOYED != 0 {
            return Ok(());
        }
        let before = self.movers.clone();
        self.folds();
        self.done(R::DEPLOY, S::DEPLOYER, &[])?;
        self.until_flags(S::DEPLOYER, bits::DEPLOYED, bits::DEPLOYING | bits::MOVE, FOLD_MS)?;
        self.moves(&before);
        Ok(())
    }

    /// Brings the monitor into standby position; not applicable without Deployer.
    pub fn wrapped(&mut self) -> Step {
        self.needs(S::DEPLOYER)?;
        if self.flags(S::DEPLOYER)? & bits::WRAPPED != 0 {
            return Ok(());
        }
        let before = self.movers.clone();
        self.folds();
        self.done(R::WRAP, S::DEPLOYER, &[])?;
        self.until_flags(S::DEPLOYER, bits::WRAPPED, bits::WRAPPING | bits::MOVE, FOLD_MS)?;
        self.moves(&before);
        Ok(())
    }

    /// Waits until nothing moves.
    pub fn rest(&mut self) -> Step {
        let movers = std::mem::take(&mut self.movers);
        let end = self.line.now_ms() + REST_MS;
        let still = loop {
            let states = self.states()?;
            let busy = states.iter().any(|rec| {
                let flags = rec.flags().unwrap_or(0);
                (rec.device.is_drive() && flags & bits::MOVE != 0)
                    || (rec.device.is_valve() && flags & (bits::OPENING | bits::CLOSING) != 0)
            });
            if !busy || self.line.now_ms() >= end {
                for rec in &states {
                    let position = rec.i16_at(4).map_or(0, i32::from);
                    if rec.device.is_drive() {
                        self.see(rec.device, position);
                    }
                }
                break !busy;
            }
            let _ = self.line.recv(100).map_err(Halt::Link)?;
        };
        self.movers = movers;
        if still {
            return Ok(());
        }
        fail(text::StopAllStops, text::StillMoves)
    }

    /// Undoes what a test has done. Every step is tried, whatever the outcome of the previous one; what
    /// fails is kept, and tried again at the end of the run.
    pub fn put_back(&mut self) -> Step {
        self.restoring = true;
        let mut worst = Ok(());
        let mut note = |step: Step| {
            if worst.is_ok() {
                worst = step;
            }
        };
        if std::mem::take(&mut self.dirty) {
            let stopped =
                self.surely(|b| b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes()).map(|_| ()));
            self.water = true;
            let rests = self.surely(Self::rest);
            // Nothing was moved, and that answers break the protocol is known.
            let known = |step: &Step| self.blind && matches!(step, Err(Halt::Fail { .. }));
            [stopped, rests].into_iter().filter(|step| !known(step)).for_each(&mut note);
        }
        let (mut kept, mut memory) = (Vec::new(), Ok(()));
        for undo in std::mem::take(&mut self.undo).into_iter().rev() {
            let back = self.surely(|b| b.take_back(&undo));
            let failed = back.is_err();
            match undo {
                // Nothing that failed before is worse.
                Undo::Memory(_) if failed => memory = back,
                _ => note(back),
            }
            if failed {
                kept.insert(0, undo);
            }
        }
        self.undo = kept;
        self.moves(&[]);
        self.water = false;
        self.restoring = false;
        memory.and(worst)
    }

    /// Restoring must not fail because one frame was lost or late.
    pub fn surely(&mut self, mut step: impl FnMut(&mut Self) -> Step) -> Step {
        let (mut tries, mut renewed) = (1, false);
        loop {
            let done = step(self);
            if done.is_ok() || tries >= UNDO_TRIES {
                return done;
            }
            // Late answers are received and discarded. If nothing arrives, a new connection may
            // reach the monitor, which may still move.
            let late = self.line.recv(LATE_MS);
            let silent =
                late.is_err() || (self.silent && matches!(late, Ok(bytes) if bytes.is_empty()));
            // A monitor that answers over the new connection is not lost: it only does not answer this.
            let lost = silent && !(renewed && self.flags(S::GENERAL).is_ok());
            renewed = lost && self.line.renew().map_err(Halt::Link)?;
            tries += u32::from(!renewed);
        }
    }

    fn take_back(&mut self, undo: &Undo) -> Step {
        match *undo {
            Undo::Param(of, name, value) => self.put(of, name, value),
            Undo::Values(of, name, ref values) => self.put_all(of, name, values),
            Undo::Memory(ref kept) => checks::write_back(self, kept),
            Undo::Lockout => {
                if self.flags(S::GENERAL)? & bits::LOCKED_OUT == 0 {
                    return Ok(());
                }
                self.frame(&Rec::new(R::LOCKOUT, S::ALL, &key::DISABLE.to_le_bytes()).bytes())?;
                self.until_flags(S::GENERAL, 0, bits::LOCKED_OUT, 5000)
            }
            // A unit that is busy refuses: what counts is that no drive is left without limits.
            Undo::Limits => self.until(LIMITS_MS, text::LimitsStayOn, |b| {
                let mut limitless = false;
                for id in DRIVES {
                    limitless |= b.has(id) && b.flags(id)? & bits::LIMITLESS != 0;
                }
                if limitless {
                    b.frame(&Rec::new(R::SWITCH_LIMITS, S::ALL, &[2, 0]).bytes())?;
                }
                Ok(!limitless)
            }),
            Undo::Valve(valve) => {
                if self.flags(valve)? & bits::CLOSED != 0 {
                    return Ok(());
                }
                // §3.18/1: a lockout by others closes it, and Close is refused meanwhile.
                if self.flags(S::GENERAL)? & bits::LOCKED_OUT == 0 {
                    self.want(
                        R::CLOSE,
                        valve,
                        &key::CLOSE.to_le_bytes(),
                        valve,
                        &[Status::OK, Status::ACCEPTED],
                    )?;
                }
                self.until_flags(valve, bits::CLOSED, bits::CLOSING, REST_MS)
            }
        }
    }

    /// Returns the barrel to where it was found.
    pub fn return_home(&mut self) -> Step {
        self.restoring = true;
        let home = self.surely(Self::go_home);
        self.restoring = false;
        home
    }

    /// Fails if the barrel is not where it was found. Moves nothing.
    pub fn left(&mut self) -> Step {
        self.restoring = true;
        let found = self.surely(Self::is_home);
        self.restoring = false;
        found
    }

    fn is_home(&mut self) -> Step {
        let wrapped = self.has(S::DEPLOYER) && self.flags(S::DEPLOYER)? & bits::WRAPPED != 0;
        let mut away = Vec::new();
        if wrapped != self.found.wrapped {
            away.push(format!("Wrapped: {} → {wrapped}", self.found.wrapped));
        } else if !wrapped {
            for (id, position) in self.found.positions.clone() {
                let now = if AIMING.contains(&id) { self.drive(id)?.1 } else { position };
                if now.abs_diff(position) > AT_HOME {
                    away.push(format!("{}: {position} → {now}", raw::name(id.name(), id.0)));
                }
            }
        }
        must(away.is_empty(), text::AsBeforeTheTest, away.join(", "))
    }

    fn go_home(&mut self) -> Step {
        let now_wrapped = self.has(S::DEPLOYER) && self.flags(S::DEPLOYER)? & bits::WRAPPED != 0;
        if self.found.wrapped {
            return if now_wrapped { Ok(()) } else { self.wrapped() };
        }
        self.deployed()?;
        for (id, position) in self.found.positions.clone() {
            if !AIMING.contains(&id) || self.drive(id)?.1.abs_diff(position) <= AT_HOME {
                continue;
            }
            let wire = i16::try_from(position).unwrap_or(0).to_le_bytes();
            self.done(R::MOVE, id, &wire)?;
            self.until_flags(id, 0, bits::MOVE, REST_MS)?;
        }
        Ok(())
    }
}
