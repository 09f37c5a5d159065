//! The session with a broker: messages in, orders and results out. No I/O, no clock of its own.
//!
//! ```text
//!            a ticket of the last seconds            none in time
//!   Silent ────────────────────────────────▶ Live ─────────────────▶ Silent
//!   Stop, Close, Lockout                     take, go to, open …     motions end, keys change,
//!   are taken                                                        authority is lost
//! ```
//!
//! A ticket is a random number that is published each second: who sends it has seen it, and the message is no
//! older: it is void after a Stop, Close or Lockout that came later than its ticket, from wherever, and undoes it.
//! What moves or opens needs one, and authority; an opening needs the key that is offered for this
//! monitor at this moment as well.

use std::collections::VecDeque;
use std::time::Duration;

use super::message::Asked;
use crate::access::Bucket;
use crate::plugs::orders::{Command, What, is_earlier};
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::sight::Holder;

/// A moment: time since any fixed one.
pub type Now = Duration;

/// A ticket is published this often …
pub const TICKET_EACH: Duration = Duration::from_secs(1);
/// … after a Stop, Close or Lockout, this long after the one before …
pub const TICKET_SOON: Duration = Duration::from_millis(100);
/// … and taken for this time.
pub const TICKET_LASTS: Duration = Duration::from_secs(3);
/// Commands at once and per second that are looked at; beyond that only Stop, Close and Lockout.
pub const COMMANDS: (f64, f64) = (50.0, 50.0);
/// Ids that are known again. In the life of a ticket fewer commands are looked at.
pub const KNOWN_MAX: usize = 256;
/// Stop, Close and Lockout whose results are waited for at the same time.
const URGENT_MAX: usize = 64;
/// Results that are waited for at the same time.
const WAITS_MAX: usize = 512;
/// Repetitions of a command that are answered with it.
const COPIES_MAX: u16 = 256;

/// Terms of a session, from the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// The clients show within this time that they are alive.
    pub alive: Duration,
    /// The valves that the session has opened close when its clients are silent.
    pub closes: bool,
    /// The clients may command.
    pub operates: bool,
}

/// What surrounds a message.
pub struct Around<'a> {
    /// The time.
    pub now: Now,
    /// Who has authority over a monitor.
    pub holder: &'a dyn Fn(usize) -> Holder,
    /// Random numbers; `None`: there are none, and nothing opens.
    pub random: &'a mut dyn FnMut() -> Option<u64>,
}

/// How a command has come.
#[derive(Clone, Copy, Debug)]
pub struct Heard {
    /// The monitor; `None`: all.
    pub monitor: Option<usize>,
    /// It was sent to be kept by the broker.
    pub retained: bool,
}

/// What the hub is to do. Monitors are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// A command; its result comes to [`Desk::answered`] with the number.
    Do {
        /// Number of the command within the session; 0: nothing waits for its result.
        number: u32,
        /// The monitor; `None`: all.
        monitor: Option<usize>,
        /// What is asked for.
        what: What,
        /// The client's name for it.
        id: Option<String>,
        /// When the ticket was published with which it came: it was sent later.
        since: Option<Now>,
    },
    /// A drive that was sent somewhere stops, if the session holds the monitor still.
    Halt {
        /// The monitor.
        monitor: usize,
        /// 0 traverse, 1 elevation, 2 nozzle.
        axis: usize,
    },
    /// A valve that the session has opened closes, unless another client holds the monitor.
    Shut {
        /// The monitor.
        monitor: usize,
        /// Valve 1 or 2.
        valve: u16,
    },
    /// An opening was refused here, without a question to the monitor: it is noted.
    Refused {
        /// The monitor.
        monitor: usize,
        /// Valve 1 or 2.
        valve: u16,
        /// Why.
        why: Refusal,
        /// The client's name for it.
        id: Option<String>,
    },
    /// The clients are silent: authority is lost, unless they come back in time.
    Lost,
    /// The clients are back.
    Back,
    /// There is a new ticket.
    Ticket(u64),
    /// The key of a monitor is another one.
    Key(usize),
    /// A result is published.
    Say(Reply),
}

/// The result of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// The monitor; `None`: all.
    pub monitor: Option<usize>,
    /// The client's name for the command.
    pub id: Option<String>,
    /// The command, if there is one of this name.
    pub command: Option<Command>,
    /// What has come of it.
    pub result: Result<(), Failed>,
    /// The message was sent to be kept by the broker.
    pub retained: bool,
    /// The result of a command of this id that came before.
    pub repeated: bool,
}

impl Reply {
    /// Refused because there were too many: what is lost first.
    pub fn is_of_flood(&self) -> bool {
        self.result.is_err_and(|it| it.why == Refusal::TooFast)
    }
}

/// A command whose result is waited for.
#[derive(Debug)]
struct Wait {
    number: u32,
    until: Now,
    /// Its result, once it has come.
    reply: Reply,
    what: What,
    /// The valve was opened by the session before: by the command of this number.
    was_open: Option<u32>,
    copies: u16,
}

/// A command whose id was used.
#[derive(Debug)]
struct Known {
    id: String,
    monitor: Option<usize>,
    command: Option<Command>,
    what: Result<What, Refusal>,
    number: u32,
    /// `None`: it is waited for.
    reply: Option<Reply>,
}

/// The session with a broker.
#[derive(Debug)]
pub struct Desk {
    terms: Terms,
    tickets: VecDeque<(u64, Now)>,
    next_ticket: Now,
    /// When the last one was published.
    ticketed: Now,
    keys: Vec<Option<u64>>,
    live: bool,
    heard: Now,
    waits: Vec<Wait>,
    known: VecDeque<Known>,
    /// The numbers of the commands that have sent drives somewhere and opened valves last.
    sent: Vec<[Option<u32>; 3]>,
    opened: Vec<[Option<u32>; 2]>,
    /// Count what makes commands void that are not sent yet, for each monitor.
    voids: Vec<u32>,
    numbers: u32,
    bucket: Bucket,
}

impl Desk {
    /// A new session with so many monitors.
    pub fn new(
        terms: Terms,
        monitors: usize,
        now: Now,
        random: &mut dyn FnMut() -> Option<u64>,
    ) -> Self {
        Self {
            terms,
            tickets: VecDeque::new(),
            next_ticket: now,
            ticketed: now,
            keys: (0..monitors).map(|_| fresh(random)).collect(),
            live: false,
            heard: now,
            waits: Vec::new(),
            known: VecDeque::new(),
            sent: vec![[None; 3]; monitors],
            opened: vec![[None; 2]; monitors],
            voids: vec![0; monitors],
            numbers: 0,
            bucket: Bucket::new(now, COMMANDS.0, COMMANDS.1),
        }
    }

    /// What a command is valid with: it is not sent any more once this is another, or none.
    pub fn generation(&self, monitor: usize) -> Option<u32> {
        self.voids.get(monitor).copied().filter(|_| self.live)
    }

    /// The key with which the next opening at a monitor is taken.
    pub fn key(&self, monitor: usize) -> Option<u64> {
        self.keys.get(monitor).copied().flatten()
    }

    /// The ticket that was published last.
    pub fn ticket(&self) -> Option<u64> {
        self.tickets.back().map(|(ticket, _)| *ticket)
    }

    /// Whether the clients have shown in time that they are alive.
    pub const fn is_live(&self) -> bool {
        self.live
    }

    /// When [`Desk::tick`] is to be called.
    pub fn timeout(&self) -> Now {
        let life = self.live.then(|| self.heard + self.terms.alive);
        let waits = self.waits.iter().map(|it| it.until);
        waits.chain(life).fold(self.next_ticket, Now::min)
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Now, random: &mut dyn FnMut() -> Option<u64>) -> Vec<Act> {
        let mut acts = Vec::new();
        if self.live && now >= self.heard + self.terms.alive {
            self.lose(random, &mut acts);
        }
        let waits = std::mem::take(&mut self.waits).into_iter();
        let (late, waits): (Vec<_>, Vec<_>) = waits.partition(|it| now >= it.until);
        self.waits = waits;
        for wait in late {
            self.say(wait, Err(Failed::from(Refusal::Late)), &mut acts);
        }
        self.tickets.retain(|(_, since)| now < *since + TICKET_LASTS);
        if now >= self.next_ticket {
            (self.next_ticket, self.ticketed) = (now + TICKET_EACH, now);
            if let Some(ticket) = fresh(random) {
                self.tickets.push_back((ticket, now));
                acts.push(Act::Ticket(ticket));
            }
        }
        acts
    }

    /// The connection has ended: what the session has started ends as with the silence of its clients.
    pub fn end(&mut self, random: &mut dyn FnMut() -> Option<u64>) -> Vec<Act> {
        let mut acts = Vec::new();
        self.lose(random, &mut acts);
        acts
    }

    /// A sign of life: a ticket, if it can be read; `false`: it is none.
    pub fn alive(&mut self, around: &mut Around<'_>, ticket: Option<u64>) -> (bool, Vec<Act>) {
        let mut acts = self.tick(around.now, around.random);
        let is_new = ticket.is_some_and(|it| self.since(it).is_some());
        if is_new {
            self.hear(around.now, &mut acts);
        }
        (is_new, acts)
    }

    /// A command.
    pub fn command(&mut self, around: &mut Around<'_>, heard: Heard, asked: Asked) -> Vec<Act> {
        let mut acts = self.tick(around.now, around.random);
        match (asked.command, asked.what) {
            (Some(command), Ok(what)) if command.is_urgent() => {
                self.urgent(around.now, heard, asked, what, &mut acts);
            }
            _ => self.other(around, heard, asked, &mut acts),
        }
        acts
    }

    /// The result of a command.
    pub fn answered(&mut self, number: u32, result: Result<(), Failed>) -> Vec<Act> {
        let mut acts = Vec::new();
        let Some(at) = self.waits.iter().position(|it| it.number == number) else { return acts };
        let wait = self.waits.swap_remove(at);
        match (result, wait.what) {
            (Ok(()), What::Stop | What::Close(_) | What::Lockout) => self.carried_out(&wait),
            (Err(Failed { why, .. }), What::Open(valve)) => {
                let opened = wait.reply.monitor.and_then(|at| self.opened.get_mut(at));
                let opened = opened.map(|it| &mut it[usize::from(valve == 2)]);
                // Unless it was closed meanwhile.
                let opened = opened.filter(|it| **it == Some(number) && !why.may_be_done());
                opened.into_iter().for_each(|it| *it = wait.was_open);
            }
            _ => {}
        }
        self.say(wait, result, &mut acts);
        acts
    }

    /// What was stopped or closed does not have to be stopped or closed any more; what was sent or opened since still
    /// has.
    fn carried_out(&mut self, wait: &Wait) {
        let forget = |mark: &mut Option<u32>| _ = mark.take_if(|it| is_earlier(*it, wait.number));
        for at in self.of(wait.reply.monitor) {
            if let What::Close(valve) = wait.what {
                let opened = (1..).zip(&mut self.opened[at]);
                let shut = opened.filter(|(number, _)| [0, *number].contains(&valve));
                shut.for_each(|(_, opened)| forget(opened));
            } else {
                self.sent[at].iter_mut().for_each(forget);
            }
        }
    }

    /// The places of one monitor, or of all.
    fn of(&self, monitor: Option<usize>) -> std::ops::Range<usize> {
        let all = self.keys.len();
        monitor.map_or(0..all, |at| at.min(all)..(at + 1).min(all))
    }

    /// When a ticket was published; `None`: it is none, or not one of the last seconds.
    fn since(&self, ticket: u64) -> Option<Now> {
        self.tickets.iter().find(|(own, _)| *own == ticket).map(|(_, since)| *since)
    }

    fn hear(&mut self, now: Now, acts: &mut Vec<Act>) {
        self.heard = now;
        if !self.live {
            self.live = true;
            acts.push(Act::Back);
        }
    }

    /// The clients are silent: everything ends that they have held.
    fn lose(&mut self, random: &mut dyn FnMut() -> Option<u64>, acts: &mut Vec<Act>) {
        self.live = false;
        for void in &mut self.voids {
            *void = void.wrapping_add(1);
        }
        for (monitor, sent) in self.sent.iter_mut().enumerate() {
            let axes = (0..).zip(std::mem::take(sent)).filter(|(_, sent)| sent.is_some());
            acts.extend(axes.map(|(axis, _)| Act::Halt { monitor, axis }));
        }
        for (monitor, opened) in self.opened.iter_mut().enumerate().filter(|_| self.terms.closes) {
            let valves = (1..).zip(std::mem::take(opened)).filter(|(_, opened)| opened.is_some());
            acts.extend(valves.map(|(valve, _)| Act::Shut { monitor, valve }));
        }
        for (monitor, key) in self.keys.iter_mut().enumerate() {
            *key = fresh(random);
            acts.push(Act::Key(monitor));
        }
        acts.push(Act::Lost);
    }

    /// The result of a command that was waited for, once for each time that it came.
    fn say(&mut self, wait: Wait, result: Result<(), Failed>, acts: &mut Vec<Act>) {
        let reply = Reply { result, ..wait.reply };
        let known = self.known.iter_mut().find(|it| it.number == wait.number);
        if let Some(known) = known {
            known.reply = Some(reply.clone());
        }
        acts.push(Act::Say(reply.clone()));
        for _ in 0..wait.copies {
            acts.push(Act::Say(Reply { repeated: true, ..reply.clone() }));
        }
    }
}

/// Commands.
impl Desk {
    /// Stop, Close and Lockout are taken in every state of the session, each time, from each client.
    fn urgent(&mut self, now: Now, heard: Heard, asked: Asked, what: What, acts: &mut Vec<Act>) {
        // What was asked for before it must not be sent after it.
        for at in self.of(heard.monitor) {
            self.voids[at] = self.voids[at].wrapping_add(1);
        }
        let reply = Reply::to(heard, &asked, Ok(()));
        // A ticket with which the next command is taken comes soon, however often it is stopped.
        self.next_ticket = self.next_ticket.min((self.ticketed + TICKET_SOON).max(now));
        let is_urgent = |it: &&Wait| it.reply.command.is_some_and(Command::is_urgent);
        if self.waits.iter().filter(is_urgent).count() >= URGENT_MAX {
            let (number, since) = (0, None);
            acts.push(Act::Do { number, monitor: heard.monitor, what, id: asked.id, since });
            acts.push(Act::Say(Reply { result: Err(Failed::from(Refusal::Late)), ..reply }));
            return;
        }
        self.accept(now + asked.timeout, reply, (what, None), acts);
    }

    fn other(&mut self, around: &mut Around<'_>, heard: Heard, asked: Asked, acts: &mut Vec<Act>) {
        let is_flood = self.bucket.take(around.now).is_err();
        let early = [(is_flood, Refusal::TooFast), (heard.retained, Refusal::Retained)];
        if let Some((_, why)) = early.into_iter().find(|(is_so, _)| *is_so) {
            self.refuse(around, heard, &asked, why, acts);
            return;
        }
        let Some(id) = asked.id.clone() else {
            self.refuse(around, heard, &asked, Refusal::Form, acts);
            return;
        };
        if let Some(known) = self.known.iter().find(|it| it.id == id) {
            let is_same = (known.monitor, known.command, known.what)
                == (heard.monitor, asked.command, asked.what);
            if !is_same {
                self.refuse(around, heard, &asked, Refusal::Sequence, acts);
                return;
            }
            let wait = self.waits.iter_mut().find(|it| it.number == known.number);
            match (&known.reply, wait) {
                (Some(reply), _) => {
                    acts.push(Act::Say(Reply { repeated: true, ..reply.clone() }));
                }
                (None, Some(wait)) if wait.copies < COPIES_MAX => wait.copies += 1,
                (None, _) => {
                    let busy = Err(Failed::from(Refusal::Busy));
                    acts.push(Act::Say(Reply::to(heard, &asked, busy)));
                }
            }
            return;
        }
        let number = self.numbers.wrapping_add(1).max(1);
        let (monitor, command, what) = (heard.monitor, asked.command, asked.what);
        let mut known = Known { id, monitor, command, what, number, reply: None };
        match self.checked(around, heard, &asked, acts) {
            Ok((_, what)) => {
                let reply = Reply::to(heard, &asked, Ok(()));
                let since = asked.ticket.and_then(|it| self.since(it));
                self.accept(around.now + asked.timeout, reply, (what, since), acts);
            }
            Err(why) => {
                known.number = 0;
                known.reply = Some(self.refuse(around, heard, &asked, why, acts));
            }
        }
        if self.known.len() >= KNOWN_MAX {
            self.known.pop_front();
        }
        self.known.push_back(known);
    }

    /// A command is refused. An opening that was refused never opens later, under whatever id it comes: the key that it
    /// has shown is used up.
    fn refuse(
        &mut self,
        around: &mut Around<'_>,
        heard: Heard,
        asked: &Asked,
        why: Refusal,
        acts: &mut Vec<Act>,
    ) -> Reply {
        let shown = asked.key.filter(|_| asked.command == Some(Command::Open));
        let mut keys = self.keys.iter_mut().enumerate();
        if let Some((at, key)) = keys.find(|(_, it)| it.is_some() && **it == shown) {
            *key = fresh(around.random);
            acts.push(Act::Key(at));
        }
        acts.extend(refused_opening(heard, asked, why));
        let reply = Reply::to(heard, asked, Err(Failed::from(why)));
        acts.push(Act::Say(reply.clone()));
        reply
    }

    /// What a command asks for, if it may be asked for now.
    fn checked(
        &mut self,
        around: &mut Around<'_>,
        heard: Heard,
        asked: &Asked,
        acts: &mut Vec<Act>,
    ) -> Result<(usize, What), Refusal> {
        let what = asked.what?;
        // For all monitors at once there are Stop, Close and Lockout.
        let at = heard.monitor.ok_or(Refusal::Command)?;
        if !self.terms.operates {
            return Err(Refusal::Role);
        }
        if asked.ticket.and_then(|it| self.since(it)).is_none() {
            return Err(Refusal::Ticket);
        }
        self.hear(around.now, acts);
        let waits = |it: &Wait| it.reply.monitor == Some(at) && !is_urgent(it.what);
        let is_release = what == What::Authority(Command::Release);
        if self.waits.len() >= WAITS_MAX || self.waits.iter().any(waits) && !is_release {
            return Err(Refusal::Busy);
        }
        if let What::Authority(_) = what {
            return Ok((at, what));
        }
        if let What::Open(_) = what {
            let offered = self.keys.get_mut(at).and_then(Option::take);
            // A key is tried once, whether it is right or not.
            if let Some(key) = self.keys.get_mut(at) {
                *key = fresh(around.random);
            }
            acts.push(Act::Key(at));
            if offered.is_none() || offered != asked.key {
                return Err(Refusal::Key);
            }
        }
        match (around.holder)(at) {
            Holder::Mine => Ok((at, what)),
            Holder::Other => Err(Refusal::Held),
            Holder::Free => Err(Refusal::NotTaken),
        }
    }

    fn accept(
        &mut self,
        until: Now,
        reply: Reply,
        (what, since): (What, Option<Now>),
        acts: &mut Vec<Act>,
    ) {
        self.numbers = self.numbers.wrapping_add(1).max(1);
        let (number, monitor, id) = (self.numbers, reply.monitor, reply.id.clone());
        let mut was_open = None;
        match (what, monitor) {
            (What::GoTo(targets), Some(at)) => {
                let sent = self.sent[at].iter_mut().zip(targets);
                let sent = sent.filter(|(_, target)| target.is_some());
                sent.for_each(|(sent, _)| *sent = Some(number));
            }
            (What::Open(valve), Some(at)) => {
                was_open = self.opened[at][usize::from(valve == 2)].replace(number);
            }
            _ => {}
        }
        self.waits.push(Wait { number, until, reply, what, was_open, copies: 0 });
        acts.push(Act::Do { number, monitor, what, id, since });
    }
}

impl Reply {
    /// What has come of a command.
    pub fn to(heard: Heard, asked: &Asked, result: Result<(), Failed>) -> Self {
        let (monitor, retained) = (heard.monitor, heard.retained);
        let (id, command) = (asked.id.clone(), asked.command);
        Self { monitor, id, command, result, retained, repeated: false }
    }
}

const fn is_urgent(what: What) -> bool {
    matches!(what, What::Stop | What::Close(_) | What::Lockout)
}

/// An opening that is refused here is noted.
fn refused_opening(heard: Heard, asked: &Asked, why: Refusal) -> Option<Act> {
    let (Some(monitor), Ok(What::Open(valve))) = (heard.monitor, asked.what) else { return None };
    Some(Act::Refused { monitor, valve, why, id: asked.id.clone() })
}

/// A number that cannot be guessed: not zero.
fn fresh(random: &mut dyn FnMut() -> Option<u64>) -> Option<u64> {
    random().filter(|it| *it != 0)
}
