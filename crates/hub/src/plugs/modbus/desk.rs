//! The session of a master with a unit: registers in, registers and orders out. No I/O, no clock of its own.
//!
//! ```text
//!            heartbeat changes in time for 0.5 s        not changed in time
//!   Silent ────────────────────────────────▶ Live ──────────────────────────▶ Silent
//!   Stop, Close, Lockout, Release            take, go to, jog, open …         motions end, keys and number
//!   are taken                                                                 change, authority is lost
//! ```
//!
//! A command is a block that is written whole; each is answered in the results under its sequence number.
//! What moves or opens needs the session number of this connection since the latest loss, a live heartbeat and
//! authority; an opening needs the key that is offered for this monitor at this moment as well.

use std::collections::VecDeque;
use std::time::Duration;

use lafet_client::Toward;

pub use super::orders::{Act, Command, Stops, What};

use super::heart::{Heart, Pulse};
use super::layout::{
    COMMAND, COMMAND_LEN, END, HEARTBEAT, JOG, JOG_LEN, JOG_RESULT, JOG_RESULT_LEN, KEY_LEN, KEYS,
    MONITORS, RESULT_LEN, RESULTS, RESULTS_KEPT, SESSION, SUMMARY, halves, key_words,
};
use super::pdu::Exception;
use super::refusal::{Failed, Refusal};
use super::sight::{Holder, Sight};
use crate::plugs::orders::is_earlier;
use crate::words::MotionWord;

/// A moment: time since any fixed one.
pub type Now = Duration;

/// Least and greatest target of a drive: 0.1° of the axes, mm of the nozzle.
pub const TARGETS: [(i16, i16); 3] = [(-3600, 3600), (-900, 1800), (0, 1000)];

/// A Stop that is not written again for this time is released: the next one is another, if it looks the same or not.
const HELD: Duration = Duration::from_secs(2);
/// Words that a master may write: heartbeat, motions by hand, commands.
const WRITTEN: usize = 1 + JOG_LEN + COMMAND_LEN;

/// Terms of a session, from the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// The heartbeat of the master changes within this time.
    pub heartbeat: Duration,
    /// A command has a result within this time.
    pub answer: Duration,
    /// The valves that the session has opened close when its heartbeat is lost.
    pub closes: bool,
}

/// What surrounds a request.
pub struct Around<'a> {
    /// The time.
    pub now: Now,
    /// The master may command.
    pub operates: bool,
    /// To all units of a line: it is not answered.
    pub broadcast: bool,
    /// More than the master may ask: only Stop, Close and Lockout are taken, and it is no sign of life.
    pub surplus: bool,
    /// The monitors.
    pub sight: &'a Sight,
    /// Random numbers; `None`: there are none, and nothing opens.
    pub random: &'a mut dyn FnMut() -> Option<u64>,
}

/// A result in the registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Entry {
    sequence: u16,
    state: u16,
    refusal: u16,
    command: u16,
    monitor: u16,
    status: u16,
    /// While it is waited for: its ticket, and until when. Of a Stop that is done already: that of a repetition.
    waits: Option<(u32, Now)>,
    /// It is one that any master may send.
    urgent: bool,
    /// The valve that opens or closes; 0: all.
    valve: u16,
    /// The session had opened it before: with this ticket.
    was_open: Option<u32>,
}

const ACCEPTED: u16 = 1;
const DONE: u16 = 2;
const REFUSED: u16 = 3;
const TIMEOUT: u16 = 4;

/// States of a drive that is moved by hand.
mod motion {
    pub const NONE: u16 = 0;
    pub const ARMED: u16 = 1;
    pub const MOVING: u16 = 2;
    pub const REFUSED: u16 = 3;
    pub const ENDED: u16 = 4;
}

/// A motion by hand.
#[derive(Clone, Copy, Debug, Default)]
struct Jog {
    block: [u16; JOG_LEN],
    monitor: usize,
    toward: [Option<Toward>; 3],
    states: [u16; 3],
    refusal: u16,
}

/// The session of a master with a unit.
#[derive(Debug)]
pub struct Desk {
    terms: Terms,
    session: u32,
    keys: [Option<u64>; MONITORS],
    heart: Heart,
    jog: Jog,
    /// What was written last.
    image: [u16; WRITTEN],
    /// The latest command that was taken.
    last: Option<[u16; COMMAND_LEN]>,
    /// When Stop, Close or Lockout was written last.
    pressed: Now,
    /// The greatest sequence numbers of commands and motions so far.
    newest: [Option<u16>; 2],
    results: VecDeque<Entry>,
    /// The tickets with which drives were sent somewhere and valves opened last.
    sent: [[Option<u32>; 3]; MONITORS],
    opened: [[Option<u32>; 2]; MONITORS],
    tickets: u32,
    /// Counts what makes commands void that are not sent yet.
    voids: u32,
    /// Urgent requests to each monitor, as they were counted last.
    stops: [Stops; MONITORS],
}

impl Desk {
    /// A new session with this number.
    pub fn new(
        terms: Terms,
        session: u32,
        now: Now,
        random: &mut dyn FnMut() -> Option<u64>,
    ) -> Self {
        let mut desk = Self {
            terms,
            session,
            keys: [None; MONITORS],
            heart: Heart::new(terms.heartbeat, now),
            jog: Jog::default(),
            image: [0; WRITTEN],
            last: None,
            pressed: now,
            newest: [None; 2],
            results: VecDeque::with_capacity(RESULTS_KEPT),
            sent: [[None; 3]; MONITORS],
            opened: [[None; 2]; MONITORS],
            tickets: 0,
            voids: 0,
            stops: [Stops::default(); MONITORS],
        };
        desk.renew_keys(random);
        desk
    }

    /// What a command is valid with: it is not sent any more once this is another, or none.
    pub fn generation(&self) -> Option<u32> {
        self.heart.live.then_some(self.voids)
    }

    /// Of each monitor how often it was stopped, closed or locked out so far, from wherever. An opening that was
    /// on its way meanwhile has a key from before; a motion by hand that was asked for before does not begin.
    pub fn stopped(
        &mut self,
        counts: &[Stops],
        random: &mut dyn FnMut() -> Option<u64>,
    ) -> Vec<Act> {
        let mut acts = Vec::new();
        for (at, count) in counts.iter().take(MONITORS).enumerate() {
            let before = std::mem::replace(&mut self.stops[at], *count);
            if before.all != count.all {
                self.keys[at] = random().filter(|it| *it != 0);
            }
            if before.motion != count.motion && at == self.jog.monitor {
                self.end_drives(Some(Refusal::Ended), |state| state == motion::ARMED, &mut acts);
            }
        }
        acts
    }

    /// The values of registers.
    ///
    /// # Errors
    ///
    /// Some of them are behind the end of the map.
    pub fn read(
        &self,
        operates: bool,
        sight: &Sight,
        first: u16,
        count: u16,
    ) -> Result<Vec<u16>, Exception> {
        let end = first.checked_add(count).filter(|end| *end <= END).ok_or(Exception::Address)?;
        let mut all = vec![0_u16; usize::from(END)];
        let mut put = |at: u16, words: &[u16]| {
            let at = usize::from(at);
            if let Some(place) = all.get_mut(at..at + words.len()) {
                place.copy_from_slice(words);
            }
        };
        put(0, &sight.header);
        put(SUMMARY, &sight.row(|it| it.words));
        put(super::layout::NAMES, &sight.row(|it| it.name));
        put(super::layout::DETAIL, &sight.row(|it| it.detail));
        let [high, low] = halves(self.session);
        let limit = u16::try_from(self.terms.heartbeat.as_millis()).unwrap_or(u16::MAX);
        let (live, losses) = (u16::from(self.heart.live), self.heart.losses);
        let beat = self.heart.value.unwrap_or_default();
        put(SESSION, &[high, low, u16::from(operates) + 1, live, limit, losses, beat, 1]);
        for (at, entry) in (0..).zip(&self.results) {
            let Entry { sequence, state, refusal, command, monitor, status, .. } = *entry;
            put(
                RESULTS + at * RESULT_LEN as u16,
                &[sequence, state, refusal, command, monitor, status],
            );
        }
        put(JOG_RESULT, &self.jog_words());
        for (at, key) in (0..).zip(self.keys) {
            put(KEYS + at * KEY_LEN as u16, &key_words(key.unwrap_or_default()));
        }
        put(HEARTBEAT, &self.image);
        Ok(all.get(usize::from(first)..usize::from(end)).unwrap_or_default().to_vec())
    }

    /// Takes what a master writes: whole blocks.
    ///
    /// # Errors
    ///
    /// It is a part of a block, or something that cannot be written. Then nothing is taken.
    pub fn write(
        &mut self,
        around: &mut Around<'_>,
        first: u16,
        words: &[u16],
    ) -> Result<Vec<Act>, Exception> {
        let from = first.checked_sub(HEARTBEAT).map(usize::from).ok_or(Exception::Address)?;
        let to = from + words.len();
        if to > WRITTEN {
            return Err(Exception::Address);
        }
        let (jog, command) = (usize::from(JOG - HEARTBEAT), usize::from(COMMAND - HEARTBEAT));
        if ![0, jog, command].contains(&from) || ![jog, command, WRITTEN].contains(&to) {
            return Err(Exception::Value);
        }
        let mut acts = self.tick(around.now, around.random);
        let mut beats = false;
        // A broadcast is heard by all units, and answered by none; what is too much may be old, or of a master that
        // has gone wild: both move nothing and hold nothing.
        if !around.broadcast && !around.surplus {
            if let Some(place) = self.image.get_mut(from..to) {
                place.copy_from_slice(words);
            }
            if from == 0 {
                let value = words.first().copied().unwrap_or_default();
                beats = self.beat(around.now, value, &mut acts);
            }
            if from <= jog && to > jog {
                let at = jog - from;
                let block = words.get(at..at + JOG_LEN).and_then(|it| it.try_into().ok());
                self.jog(around, block.unwrap_or_default(), &mut acts);
            }
        }
        if to == WRITTEN {
            let block = words.last_chunk::<COMMAND_LEN>().copied().unwrap_or_default();
            self.command(around, block, &mut acts);
        }
        // Last: what is released or stopped in the same write is not moved once more.
        for (axis, toward) in self.jog.toward.into_iter().enumerate().filter(|_| beats) {
            let monitor = self.jog.monitor;
            acts.extend(toward.map(|toward| Act::Beat { monitor, axis, toward }));
        }
        Ok(acts)
    }

    /// When [`Desk::tick`] is to be called.
    pub fn timeout(&self) -> Option<Now> {
        let waits = self.results.iter().filter_map(|it| it.waits.map(|(_, until)| until));
        waits.chain(self.heart.deadline()).min()
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Now, random: &mut dyn FnMut() -> Option<u64>) -> Vec<Act> {
        let mut acts = Vec::new();
        if self.heart.deadline().is_some_and(|at| now >= at) {
            self.lose(random, &mut acts);
        }
        for entry in &mut self.results {
            if entry.waits.is_some_and(|(_, until)| now >= until) {
                entry.waits = None;
                (entry.state, entry.refusal) = (TIMEOUT, Refusal::Late.number());
            }
        }
        acts
    }

    /// The connection has ended: what the session has started ends as with its heartbeat.
    pub fn end(&mut self, random: &mut dyn FnMut() -> Option<u64>) -> Vec<Act> {
        let mut acts = Vec::new();
        self.lose(random, &mut acts);
        acts
    }

    /// The result of a command.
    pub fn answered(&mut self, ticket: u32, result: Result<(), Failed>) {
        let is_it = |it: &&mut Entry| it.waits.is_some_and(|(own, _)| own == ticket);
        let Some(entry) = self.results.iter_mut().find(is_it) else { return };
        entry.waits = None;
        match result {
            Ok(()) => {
                entry.state = DONE;
                let entry = *entry;
                self.carried_out(&entry, ticket);
            }
            Err(Failed { why, status }) => {
                (entry.state, entry.refusal, entry.status) = (REFUSED, why.number(), status);
                if entry.command == Command::Open.number() && !why.may_be_done() {
                    let at = usize::from(entry.monitor).wrapping_sub(1);
                    let valve = usize::from(entry.valve == 2);
                    let opened = self.opened.get_mut(at).map(|it| &mut it[valve]);
                    // Unless it was closed meanwhile.
                    let opened = opened.filter(|it| **it == Some(ticket));
                    opened.into_iter().for_each(|it| *it = entry.was_open);
                }
            }
        }
    }

    /// What was stopped or closed does not have to be stopped or closed any more; what was sent or opened since still
    /// has.
    fn carried_out(&mut self, entry: &Entry, ticket: u32) {
        let of = |at: usize| entry.monitor == 0 || usize::from(entry.monitor) == at + 1;
        let monitors = (0..MONITORS).filter(|at| entry.urgent && of(*at));
        let forget = |mark: &mut Option<u32>| _ = mark.take_if(|it| is_earlier(*it, ticket));
        for at in monitors {
            if entry.command == Command::Close.number() {
                let opened = (1..).zip(&mut self.opened[at]);
                let shut = opened.filter(|(number, _)| [0, *number].contains(&entry.valve));
                shut.for_each(|(_, opened)| forget(opened));
            } else {
                self.sent[at].iter_mut().for_each(forget);
            }
        }
    }

    /// What has become of a beat of a motion by hand.
    pub fn jogged(&mut self, monitor: usize, axis: usize, said: Result<MotionWord, Failed>) {
        if monitor != self.jog.monitor || self.jog.toward[axis].is_none() {
            return;
        }
        let (state, failed) = match said {
            Ok(MotionWord::Armed) => (motion::ARMED, None),
            Ok(MotionWord::Moving) => (motion::MOVING, None),
            Ok(MotionWord::Stopping | MotionWord::Ended) => (motion::ENDED, Some(Refusal::Ended)),
            Err(failed) => (motion::REFUSED, Some(failed.why)),
        };
        self.jog.states[axis] = state;
        if state == motion::MOVING {
            // The hand has the drive now: what it was sent to is over.
            self.sent[monitor][axis] = None;
        }
        if let Some(why) = failed {
            self.jog.refusal = why.number();
            // A motion that others have ended does not start again by itself.
            self.jog.toward[axis] = None;
        }
    }

    /// A request was not taken: a key that is in its bytes is used up. Who forwards the request could correct it.
    pub fn refused(&mut self, bytes: &[u8], random: &mut dyn FnMut() -> Option<u64>) {
        for shown in bytes.windows(2 * KEY_LEN) {
            let shown = shown.first_chunk().map(|it| u64::from_be_bytes(*it));
            self.use_up_shown(shown, random);
        }
    }

    fn use_up_shown(&mut self, shown: Option<u64>, random: &mut dyn FnMut() -> Option<u64>) {
        let mut keys = self.keys.iter_mut();
        if let Some(key) = keys.find(|it| it.is_some() && **it == shown) {
            *key = random().filter(|it| *it != 0);
        }
    }

    /// An opening was refused, or a command that is none: the key of its monitor is used up, and so is one of another
    /// monitor that it has shown. Corrected, it opens nothing.
    fn use_up(&mut self, around: &mut Around<'_>, block: [u16; COMMAND_LEN]) {
        let [.., number, monitor, _, _, _, _, a, b, c, d] = block;
        if Command::by_number(number).is_none_or(|it| it == Command::Open)
            && let Some(at) = self.monitor(around, monitor)
        {
            self.keys[at] = (around.random)().filter(|it| *it != 0);
        }
        let shown = [a, b, c, d].into_iter().fold(0, |key, word| key << 16 | u64::from(word));
        self.use_up_shown(Some(shown), around.random);
    }

    fn renew_keys(&mut self, random: &mut dyn FnMut() -> Option<u64>) {
        self.keys.iter_mut().for_each(|key| *key = random().filter(|it| *it != 0));
    }

    /// Whether the motions by hand go on.
    fn beat(&mut self, now: Now, value: u16, acts: &mut Vec<Act>) -> bool {
        let pulse = self.heart.beat(now, value);
        if pulse == Pulse::Back {
            acts.push(Act::Back);
        }
        pulse != Pulse::Nothing
    }

    /// The heartbeat is lost: everything ends that it has held.
    fn lose(&mut self, random: &mut dyn FnMut() -> Option<u64>, acts: &mut Vec<Act>) {
        let was_live = self.heart.lose();
        self.voids = self.voids.wrapping_add(1);
        self.end_jog(Some(Refusal::Heartbeat), acts);
        for (monitor, sent) in std::mem::take(&mut self.sent).into_iter().enumerate() {
            let axes = (0..).zip(sent).filter(|(_, sent)| sent.is_some());
            acts.extend(axes.map(|(axis, _)| Act::Halt { monitor, axis }));
        }
        if self.terms.closes {
            for (monitor, opened) in std::mem::take(&mut self.opened).into_iter().enumerate() {
                let valves = (1..).zip(opened).filter(|(_, opened)| opened.is_some());
                acts.extend(valves.map(|(valve, _)| Act::Shut { monitor, valve }));
            }
        }
        self.renew_keys(random);
        if was_live {
            // What was written before and arrives only now has the number of before.
            self.session = other_number(self.session, random());
            acts.push(Act::Lost);
        }
    }
}

/// Motions by hand.
impl Desk {
    fn jog(&mut self, around: &Around<'_>, block: [u16; JOG_LEN], acts: &mut Vec<Act>) {
        // A master that writes its image again and again repeats the block: that says nothing new.
        if block == self.jog.block {
            return;
        }
        self.end_jog(None, acts);
        self.jog = Jog { block, ..Jog::default() };
        let [sequence, high, low, monitor, directions @ ..] = block;
        if directions == [0; 3] {
            return;
        }
        let toward = directions.map(|it| match it.cast_signed() {
            0 => Some(None),
            1 => Some(Some(Toward::Max)),
            -1 => Some(Some(Toward::Min)),
            _ => None,
        });
        let at = self.monitor(around, monitor);
        let refusal = if let Err(why) = self.may_move(around, [high, low]) {
            Some(why)
        } else if !is_newer(sequence, &mut self.newest[1]) {
            Some(Refusal::Sequence)
        } else if at.is_none() {
            Some(Refusal::Monitor)
        } else if toward.contains(&None) {
            Some(Refusal::Argument)
        } else {
            at.and_then(|at| not_held(around, at))
        };
        if let Some(why) = refusal {
            self.jog.refusal = why.number();
            self.jog.states = directions.map(|it| match it {
                0 => motion::NONE,
                _ => motion::REFUSED,
            });
            return;
        }
        self.jog.monitor = at.unwrap_or_default();
        self.jog.toward = toward.map(Option::flatten);
        for (axis, toward) in self.jog.toward.into_iter().enumerate() {
            if toward.is_some() {
                self.jog.states[axis] = motion::ARMED;
            }
        }
    }

    fn end_jog(&mut self, why: Option<Refusal>, acts: &mut Vec<Act>) {
        self.end_drives(why, |_| true, acts);
    }

    /// Ends the motions of the drives that are in such a state.
    fn end_drives(
        &mut self,
        why: Option<Refusal>,
        ends: impl Fn(u16) -> bool,
        acts: &mut Vec<Act>,
    ) {
        let Jog { monitor, toward, states, refusal, .. } = &mut self.jog;
        for (axis, (toward, state)) in toward.iter_mut().zip(states).enumerate() {
            if ends(*state) && toward.take().is_some() {
                acts.push(Act::Release { monitor: *monitor, axis });
                *state = motion::ENDED;
                *refusal = why.map_or(*refusal, Refusal::number);
            }
        }
    }

    fn jog_words(&self) -> [u16; JOG_RESULT_LEN] {
        let Jog { block: [sequence, _, _, monitor, ..], states, refusal, .. } = self.jog;
        let any = |state| states.contains(&state);
        // The worst of the drives, in short.
        let state = [motion::REFUSED, motion::ENDED, motion::MOVING, motion::ARMED];
        let state = state.into_iter().find(|state| any(*state)).unwrap_or(motion::NONE);
        let [traverse, elevation, nozzle] = states;
        [sequence, state, refusal, monitor, traverse, elevation, nozzle, 0]
    }
}

/// Commands.
impl Desk {
    fn command(&mut self, around: &mut Around<'_>, block: [u16; COMMAND_LEN], acts: &mut Vec<Act>) {
        let [sequence, high, low, number, monitor, first, second, third, fourth, key @ ..] = block;
        if number == 0 {
            // A Stop that was held is released: the next one is another, even if it looks the same.
            self.last.take_if(|last| is_urgent(last[3]));
            return;
        }
        let command = Command::by_number(number);
        if around.surplus && !is_urgent(number) {
            return;
        }
        if around.broadcast && !matches!(command, Some(Command::Stop | Command::Close)) {
            return;
        }
        let mut same = self.last == Some(block);
        let entry = Entry { sequence, command: number, monitor, ..Entry::default() };
        if let Some(command) = command.filter(|it| it.is_urgent()) {
            let pressed = std::mem::replace(&mut self.pressed, around.now);
            same &= around.now < pressed + HELD;
            self.last = Some(block);
            return self.urgent(around, command, first, (entry, same), acts);
        }
        if same {
            return;
        }
        self.last = Some(block);
        if !is_newer(sequence, &mut self.newest[0]) {
            self.use_up(around, block);
            return self.refuse(entry, Refusal::Sequence);
        }
        let arguments = [first, second, third, fourth];
        match self.checked(around, command, [high, low], monitor, arguments, key) {
            Ok((at, what)) => {
                let mut entry = entry;
                let ticket = self.tickets.wrapping_add(1);
                if let What::GoTo(targets) = what {
                    let sent = self.sent[at].iter_mut().zip(targets);
                    let sent = sent.filter(|(_, target)| target.is_some());
                    sent.for_each(|(sent, _)| *sent = Some(ticket));
                }
                if let What::Open(valve) = what {
                    let opened = &mut self.opened[at][usize::from(valve == 2)];
                    entry.was_open = opened.replace(ticket);
                    entry.valve = valve;
                }
                self.accept(around.now, entry, Some(at), what, acts);
            }
            Err(why) => {
                self.use_up(around, block);
                let (open, valve) = (command == Some(Command::Open), arguments[0]);
                let named =
                    self.monitor(around, monitor).filter(|_| open && (1..=2).contains(&valve));
                acts.extend(named.map(|monitor| Act::Refused { monitor, valve, why }));
                self.refuse(entry, why);
            }
        }
    }

    /// What a command asks for, if the master may ask for it now.
    fn checked(
        &mut self,
        around: &mut Around<'_>,
        command: Option<Command>,
        session: [u16; 2],
        monitor: u16,
        arguments: [u16; 4],
        key: [u16; KEY_LEN],
    ) -> Result<(usize, What), Refusal> {
        let command = command.ok_or(Refusal::Command)?;
        if command == Command::Release {
            // Who has no heartbeat may still release what it holds.
            self.is_own(session)?;
        } else {
            self.may_move(around, session)?;
        }
        let waits = self.results.iter().any(|it| it.waits.is_some() && !it.urgent);
        if waits && command != Command::Release {
            return Err(Refusal::Busy);
        }
        let at = self.monitor(around, monitor).ok_or(Refusal::Monitor)?;
        let what = match command {
            Command::Take | Command::Release | Command::Ask => {
                return Ok((at, What::Authority(command)));
            }
            Command::GoTo => What::GoTo(targets(arguments).ok_or(Refusal::Argument)?),
            Command::Deploy => What::Deploy,
            Command::Stow => What::Stow,
            Command::Open => {
                if !(1..=2).contains(&arguments[0]) {
                    return Err(Refusal::Argument);
                }
                let offered = self.keys[at].take();
                // A key is tried once, whether it is right or not.
                self.keys[at] = (around.random)().filter(|it| *it != 0);
                if offered.is_none_or(|offered| key_words(offered) != key) {
                    return Err(Refusal::Key);
                }
                What::Open(arguments[0])
            }
            Command::Close | Command::Stop | Command::Lockout => return Err(Refusal::Command),
        };
        match not_held(around, at) {
            Some(why) => Err(why),
            None => Ok((at, what)),
        }
    }

    /// Stop, Close and Lockout are taken from every master, in every state of the session.
    fn urgent(
        &mut self,
        around: &Around<'_>,
        command: Command,
        valve: u16,
        (entry, same): (Entry, bool),
        acts: &mut Vec<Act>,
    ) {
        let at = self.monitor(around, entry.monitor);
        let everywhere = entry.monitor == 0 && command != Command::Close;
        if at.is_none() && !everywhere {
            return self.refuse(entry, Refusal::Monitor);
        }
        let what = match command {
            Command::Close if valve <= 2 => What::Close(valve),
            Command::Close => return self.refuse(entry, Refusal::Argument),
            Command::Lockout => What::Lockout,
            _ => What::Stop,
        };
        // What was asked for before it must not be sent after it.
        self.voids = self.voids.wrapping_add(1);
        if command != Command::Close && at.is_none_or(|at| at == self.jog.monitor) {
            self.end_jog(Some(Refusal::Ended), acts);
        }
        // One that is written again and again is one entry, and is carried out each time. Done is what is confirmed:
        // a repetition that fails is not.
        let of = |it: &Entry| (it.urgent, it.sequence, it.command, it.monitor);
        let wanted = (true, entry.sequence, entry.command, entry.monitor);
        let held = self.results.iter_mut().find(|it| same && of(it) == wanted);
        if let Some(held) = held.filter(|it| [ACCEPTED, DONE].contains(&it.state)) {
            let next = (self.tickets.wrapping_add(1), around.now + self.terms.answer);
            let (ticket, _) = *held.waits.get_or_insert(next);
            self.tickets = if ticket == next.0 { ticket } else { self.tickets };
            acts.push(Act::Do { ticket, monitor: at, what });
            return;
        }
        let entry = Entry { urgent: true, valve, ..entry };
        self.accept(around.now, entry, at, what, acts);
    }

    fn accept(
        &mut self,
        now: Now,
        entry: Entry,
        monitor: Option<usize>,
        what: What,
        acts: &mut Vec<Act>,
    ) {
        self.tickets = self.tickets.wrapping_add(1);
        let ticket = self.tickets;
        let waits = Some((ticket, now + self.terms.answer));
        self.keep(Entry { state: ACCEPTED, waits, ..entry });
        acts.push(Act::Do { ticket, monitor, what });
    }

    fn refuse(&mut self, entry: Entry, why: Refusal) {
        self.keep(Entry { state: REFUSED, refusal: why.number(), ..entry });
    }

    /// Puts a result in front. What gives way is one that has come, the oldest first; of those that are
    /// waited for a Stop, which is carried out all the same.
    fn keep(&mut self, entry: Entry) {
        if self.results.len() >= RESULTS_KEPT {
            let has_come = self.results.iter().rposition(|it| it.waits.is_none());
            let stop = || self.results.iter().rposition(|it| it.urgent);
            let gone = has_come.or_else(stop).unwrap_or(RESULTS_KEPT - 1);
            self.results.remove(gone);
        }
        self.results.push_front(entry);
    }

    fn is_own(&self, session: [u16; 2]) -> Result<(), Refusal> {
        // 0 is what registers have that were never written.
        let own = self.session != 0 && halves(self.session) == session;
        if own { Ok(()) } else { Err(Refusal::Session) }
    }

    /// What everything needs that is not urgent.
    fn may_move(&self, around: &Around<'_>, session: [u16; 2]) -> Result<(), Refusal> {
        if !around.operates {
            return Err(Refusal::Role);
        }
        self.is_own(session)?;
        if self.heart.live { Ok(()) } else { Err(Refusal::Heartbeat) }
    }

    /// The place of a monitor that is counted from 1.
    fn monitor(&self, around: &Around<'_>, number: u16) -> Option<usize> {
        let at = usize::from(number).checked_sub(1)?;
        (at < around.sight.monitors.len().min(MONITORS)).then_some(at)
    }
}

/// Whether a number is one of Stop, Close and Lockout.
fn is_urgent(command: u16) -> bool {
    Command::by_number(command).is_some_and(Command::is_urgent)
}

/// Another number of a session; 0, to which nothing is allowed that is not urgent, without a random one.
fn other_number(number: u32, random: Option<u64>) -> u32 {
    let other = random.map_or(0, |it| ((it & u64::from(u32::MAX)) as u32).max(1));
    if other == number && other != 0 { other.wrapping_add(1).max(1) } else { other }
}

/// Why this session may not command a monitor; `None`: it holds it.
fn not_held(around: &Around<'_>, at: usize) -> Option<Refusal> {
    match around.sight.monitors.get(at).map(|it| it.holder) {
        Some(Holder::Mine) => None,
        Some(Holder::Other) => Some(Refusal::Held),
        Some(Holder::Free) | None => Some(Refusal::NotTaken),
    }
}

/// The targets of the drives whose bits are set in the first argument, arc-minutes or mm.
fn targets([mask, rest @ ..]: [u16; 4]) -> Option<[Option<i16>; 3]> {
    if !(1..=7).contains(&mask) {
        return None;
    }
    let mut targets = [None; 3];
    for (axis, (value, (least, most))) in rest.into_iter().zip(TARGETS).enumerate() {
        let value = value.cast_signed();
        if mask & 1 << axis != 0 {
            let target = Some(value).filter(|it| (least..=most).contains(it))?;
            // Tenths of a degree to arc-minutes; the nozzle is in mm.
            targets[axis] = Some(if axis == 2 { target } else { target * 6 });
        }
    }
    Some(targets)
}

/// Whether a sequence number is newer than those before; if so it is noted.
fn is_newer(sequence: u16, newest: &mut Option<u16>) -> bool {
    let newer = newest.is_none_or(|newest| (1..0x8000).contains(&sequence.wrapping_sub(newest)));
    if newer {
        *newest = Some(sequence);
    }
    newer
}
