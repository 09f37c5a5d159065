//! What keeps a test from harm: who may move, what is put back, when to stop everything.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};

use crate::Level;
use crate::bench::Bench;
use crate::checks::bits;
use crate::raw::{self, Rec};
use crate::verdict::{Halt, Note, Step, fail};

/// Drives that aim.
pub const AIMING: [S; 3] = [S::HORIZONTAL, S::VERTICAL, S::NOZZLE];
/// All drives.
pub const DRIVES: [S; 4] = [S::DEPLOYER, S::NOZZLE, S::HORIZONTAL, S::VERTICAL];
/// Valves.
pub const VALVES: [S; 2] = [S::VALVE1, S::VALVE2];
/// With --motion a drive goes no faster, ° or mm per second.
const SLOW: i32 = 5;
/// How long a monitor may need to come to rest, to fold, to reset.
pub const REST_MS: u64 = 60_000;
pub const FOLD_MS: u64 = 90_000;
pub const RESET_MS: u64 = 30_000;
/// How often it is tried to undo something, and how late an answer may come before that.
const UNDO_TRIES: u32 = 4;
const LATE_MS: u64 = 500;
/// A sensor's last digit is no motion.
const JITTER: i32 = 12;

/// What was found at the start.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Subsystems of the monitor, in the order of the chain.
    pub present: Vec<S>,
    /// Wrapped when it was found.
    pub wrapped: bool,
    /// Locked out when it was found: only reads are tested.
    pub locked_out: bool,
    /// Where the drives stood.
    pub positions: Vec<(S, i32)>,
    /// Where they were seen last.
    pub seen: Vec<(S, i32)>,
    /// All of the subsystems answer in one frame.
    pub fits: bool,
}

/// What a test has changed.
#[derive(Clone, Copy, Debug)]
pub enum Undo {
    /// A parameter had this value.
    Param(S, &'static str, i32),
    /// The lockout was off.
    Lockout,
    /// Limits were on.
    Limits,
    /// A valve was closed.
    Valve(S),
}

impl Bench<'_> {
    /// Looks who is there, without changing anything.
    pub fn look(&mut self) -> Step {
        self.found.present.clear();
        for id in S::CHAIN {
            let rec = self.ask(R::GET_STATUS, id, &[])?;
            if rec.status != Status::MODULE_NOT_EXIST {
                self.found.present.push(id);
            }
        }
        let answers = self.frame(&Rec::new(R::GET_STATUS, S::ALL, &[]).bytes())?;
        self.found.fits = answers.iter().all(|rec| rec.status != Status::NO_ROOM);
        for id in DRIVES {
            if self.has(id) {
                let (_, position) = self.drive(id)?;
                self.found.positions.push((id, position));
            }
        }
        self.found.seen.clone_from(&self.found.positions);
        self.found.locked_out = self.flags(S::GENERAL)? & bits::LOCKED_OUT != 0;
        if self.has(S::DEPLOYER) {
            self.found.wrapped = self.flags(S::DEPLOYER)? & bits::WRAPPED != 0;
        }
        Ok(())
    }

    /// A monitor at work is not tested at all; one to be moved must be ready for it.
    pub fn is_ready(&mut self) -> Step {
        let not = |en: &str, ru: &str| Err(Halt::Abort(Note::new(en, ru)));
        if self.moving()?.is_some() {
            return not(
                "the monitor is at work (something moves): it is not tested now",
                "ствол работает (что-то движется): сейчас он не проверяется",
            );
        }
        for (id, busy) in [
            (S::CONTROL, bits::QUENCH | bits::TRAJECTORY),
            (S::DETECTOR, bits::SEARCHING | bits::JUSTIFYING),
        ] {
            if self.has(id) && self.flags(id)? & busy != 0 {
                return not(
                    "a program or a search runs: the monitor is not tested now",
                    "идёт программа или поиск: ствол сейчас не проверяется",
                );
            }
        }
        if self.options.level == Level::ReadOnly {
            return Ok(());
        }
        if self.found.locked_out {
            return not(
                "the monitor is locked out; whoever did it had a reason. Only --read-only is possible",
                "ствол заблокирован; у того, кто это сделал, была причина. Возможен только --read-only",
            );
        }
        for valve in VALVES {
            if self.has(valve) && self.flags(valve)? & bits::CLOSED == 0 {
                return not(
                    "a valve is not closed: close it first",
                    "затвор не закрыт: сначала закройте его",
                );
            }
        }
        Ok(())
    }

    /// With --motion everything goes slowly, where the monitor knows the parameter.
    pub fn slow_down(&mut self) -> Step<Vec<Undo>> {
        let mut undo = Vec::new();
        if self.options.level != Level::Motion {
            return Ok(undo);
        }
        for id in AIMING {
            if !self.has(id) {
                continue;
            }
            if let Some([speed, ..]) = self.get(id, "Speed")?.as_deref()
                && *speed > SLOW
            {
                undo.push(Undo::Param(id, "Speed", *speed));
                // A monitor that refuses stays as fast as it was.
                self.try_set(id, "Speed", &[SLOW])?;
            }
        }
        Ok(undo)
    }

    /// The states of all subsystems, however many frames it takes.
    pub fn states(&mut self) -> Step<Vec<Rec>> {
        if self.found.fits {
            return self.frame(&Rec::new(R::GET_STATUS, S::ALL, &[]).bytes());
        }
        let present = self.found.present.clone();
        present.into_iter().map(|id| self.ask(R::GET_STATUS, id, &[])).collect()
    }

    /// What moves or flows though nobody has asked for it.
    fn moving(&mut self) -> Step<Option<String>> {
        let mut found = None;
        for rec in self.states()? {
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
        Ok(found)
    }

    /// Remembers where a drive is; how far it is from where it was.
    fn see(&mut self, id: S, position: i32) -> u32 {
        match self.found.seen.iter_mut().find(|(seen, _)| *seen == id) {
            Some((_, last)) => std::mem::replace(last, position).abs_diff(position),
            None => {
                self.found.seen.push((id, position));
                0
            }
        }
    }

    /// Something that moves unasked ends everything.
    pub fn watch(&mut self) -> Step {
        if self.restoring {
            return Ok(());
        }
        match self.moving()? {
            None => Ok(()),
            Some(name) => Err(Halt::Abort(Note::new(
                format!(
                    "{name} moves or opens although nothing has asked it to: Stop All was sent"
                ),
                format!("{name} движется или открывается без запроса: послан Stop All"),
            ))),
        }
    }

    /// These may move now.
    pub fn moves(&mut self, ids: &[S]) {
        let before = std::mem::replace(&mut self.movers, ids.to_vec());
        // What has just been allowed to move stands a little further than it was seen last.
        self.found.seen.retain(|(id, _)| !before.contains(id));
    }

    /// Everything that folds and unfolds may.
    pub fn folds(&mut self) {
        self.moves(&[S::DEPLOYER, S::HORIZONTAL, S::VERTICAL]);
    }

    /// In working position.
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

    /// In standby position; not applicable without Deployer.
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

    /// Until nothing moves.
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
        fail(
            Note::new("§3.2/1: Stop All stops everything", "§3.2/1: Stop All останавливает всё"),
            Note::new("something still moves", "что-то ещё движется"),
        )
    }

    /// Undoes what a test has done. Every step is tried, whatever the one before came to.
    pub fn put_back(&mut self) -> Step {
        self.restoring = true;
        let mut worst = Ok(());
        let mut note = |step: Step| {
            if worst.is_ok() {
                worst = step;
            }
        };
        if std::mem::take(&mut self.dirty) {
            note(self.surely(|b| b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes()).map(|_| ())));
            self.water = true;
            note(self.surely(Self::rest));
        }
        for undo in std::mem::take(&mut self.undo).into_iter().rev() {
            note(self.surely(|b| b.take_back(undo)));
        }
        self.moves(&[]);
        self.water = false;
        self.restoring = false;
        worst
    }

    /// Putting back must not fail for a frame that was lost or came late.
    fn surely(&mut self, mut step: impl FnMut(&mut Self) -> Step) -> Step {
        let mut tries = 1;
        loop {
            let done = step(self);
            if done.is_ok() || tries >= UNDO_TRIES {
                return done;
            }
            // What is still under way arrives, and is forgotten. Where nothing does, a new connection
            // may reach the monitor, which may still move.
            let late = self.line.recv(LATE_MS);
            let lost =
                late.is_err() || (self.silent && matches!(late, Ok(bytes) if bytes.is_empty()));
            let renewed = lost && self.line.renew().map_err(Halt::Link)?;
            tries += u32::from(!renewed);
        }
    }

    fn take_back(&mut self, undo: Undo) -> Step {
        match undo {
            Undo::Param(of, name, value) => self.put(of, name, value),
            Undo::Lockout => {
                if self.flags(S::GENERAL)? & bits::LOCKED_OUT == 0 {
                    return Ok(());
                }
                self.frame(&Rec::new(R::LOCKOUT, S::ALL, &key::DISABLE.to_le_bytes()).bytes())?;
                self.until_flags(S::GENERAL, 0, bits::LOCKED_OUT, 5000)
            }
            Undo::Limits => {
                let mut limitless = false;
                for id in DRIVES {
                    limitless |= self.has(id) && self.flags(id)? & bits::LIMITLESS != 0;
                }
                if limitless {
                    self.frame(&Rec::new(R::SWITCH_LIMITS, S::ALL, &[2, 0]).bytes())?;
                }
                Ok(())
            }
            Undo::Valve(valve) => {
                if self.flags(valve)? & bits::CLOSED != 0 {
                    return Ok(());
                }
                self.want(
                    R::CLOSE,
                    valve,
                    &key::CLOSE.to_le_bytes(),
                    valve,
                    &[Status::OK, Status::ACCEPTED],
                )?;
                self.until_flags(valve, bits::CLOSED, bits::CLOSING, REST_MS)
            }
        }
    }

    /// Brings the barrel back to where it was found.
    pub fn return_home(&mut self) -> Step {
        self.restoring = true;
        let home = self.surely(Self::go_home);
        self.restoring = false;
        home
    }

    fn go_home(&mut self) -> Step {
        let now_wrapped = self.has(S::DEPLOYER) && self.flags(S::DEPLOYER)? & bits::WRAPPED != 0;
        if self.found.wrapped {
            return if now_wrapped { Ok(()) } else { self.wrapped() };
        }
        self.deployed()?;
        for (id, position) in self.found.positions.clone() {
            if !AIMING.contains(&id) || self.drive(id)?.1.abs_diff(position) <= 2 {
                continue;
            }
            let wire = i16::try_from(position).unwrap_or(0).to_le_bytes();
            self.done(R::MOVE, id, &wire)?;
            self.until_flags(id, 0, bits::MOVE, REST_MS)?;
        }
        Ok(())
    }
}
