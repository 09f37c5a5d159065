//! A simulated monitor, what was done with it, and what came of it.

use std::collections::VecDeque;

use lafet_device::Source;
use lafet_proto::link::{self, BODY_MAX, Check, Frame, PAYLOAD_MAX, WIRE_MAX};
use lafet_proto::record::Writer;
use lafet_proto::text as request_text;
use lafet_sim::fault::Fault;
use lafet_sim::fire::{Class, FireSpec};
use lafet_sim::sim::{Config, Sim};
use lafet_texts::{Lang, Text as _, Undecodable, Words, parse_error_text, play as text};

use crate::anatomy::{Way, same};
use crate::fault::fault_words;
use crate::scene::states;
use crate::session::{Action, RANGE, STEPS_MAX, Session, Setup};
use crate::view::{Act, Anatomy, Entry, Input, Link, Scene, View};
use crate::walk::walks;

/// Characters of a typed text at most.
pub const TEXT_MAX: usize = 4_096;
/// Requests of a frame at most.
pub const REQUESTS_MAX: usize = 32;
/// Time that passes in one call at most, ms.
pub const ADVANCE_MAX_MS: u32 = 2_000;

const STEP_MS: u32 = 10;
/// How often the state goes into the hash, steps.
const FOLD_STEPS: u32 = 10;
/// Addresses of the two clients; the monitor's is 1.
const CLIENTS: [u8; 2] = [201, 202];

/// FNV-1a, 64 bits.
#[derive(Clone, Copy, Debug)]
struct Hash(u64);

impl Hash {
    const START: Self = Self(0xCBF2_9CE4_8422_2325);

    fn fold(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }
}

/// A simulated monitor and its session.
#[derive(Debug)]
pub struct Playground {
    sim: Sim,
    session: Session,
    /// What is still to be repeated of a session that was opened, and how long that lasts.
    pending: VecDeque<(u32, Action)>,
    replay: Option<u32>,
    entries: Vec<Entry>,
    hash: Hash,
}

impl Default for Playground {
    fn default() -> Self {
        Self::new(Setup::default())
    }
}

impl Playground {
    /// A new monitor.
    pub fn new(setup: Setup) -> Self {
        let mut config = Config { seed: setup.seed.into(), ..Config::default() };
        // A setup has no other profiles than those there are.
        _ = config.profile(setup.profile);
        config.wind = (setup.wind[0].into(), setup.wind[1].into());
        Self {
            sim: Sim::new(config),
            session: Session { setup, ..Session::default() },
            pending: VecDeque::new(),
            replay: None,
            entries: Vec::new(),
            hash: Hash::START,
        }
    }

    /// A session from the fragment of a URL: its actions are repeated as time passes.
    ///
    /// # Errors
    ///
    /// What is wrong with the fragment.
    pub fn open(fragment: &str) -> Result<Self, Words> {
        let session = Session::from_fragment(fragment)?;
        let mut playground = Self::new(session.setup);
        playground.pending = session.actions.into();
        playground.replay = Some(session.steps);
        playground.repeat();
        Ok(playground)
    }

    /// The session until now.
    pub fn session(&self) -> Session {
        Session { steps: self.step().min(STEPS_MAX), ..self.session.clone() }
    }

    /// Of everything that has happened.
    pub fn hash(&self) -> u64 {
        self.hash.0
    }

    /// Whether recorded actions are still to come.
    pub fn is_repeating(&self) -> bool {
        self.replay.is_some()
    }

    fn step(&self) -> u32 {
        // Half an hour at most, and what a request waits for the flash.
        (self.sim.now_ms() / u64::from(STEP_MS)) as u32
    }

    fn is_over(&self) -> bool {
        self.step() >= STEPS_MAX
    }

    /// Lets time pass, two seconds at most; not beyond the end of a recorded session.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms.min(ADVANCE_MAX_MS) / STEP_MS {
            let repeating = self.replay.is_some();
            self.repeat();
            // What was recorded ends in the state in which it was shared.
            if self.is_over() || repeating && self.replay.is_none() {
                return;
            }
            self.sim.tick();
            if self.step().is_multiple_of(FOLD_STEPS) {
                self.fold();
            }
        }
        self.repeat();
    }

    /// Does what was recorded for this time.
    fn repeat(&mut self) {
        loop {
            let now = self.step();
            let due = self.pending.pop_front_if(|(at, _)| *at <= now);
            let Some((_, action)) = due else { break };
            self.apply(action);
        }
        if self.pending.is_empty() && self.replay.is_some_and(|end| self.step() >= end) {
            self.replay = None;
        }
    }

    fn fold(&mut self) {
        let world = self.sim.world();
        let mut numbers: Vec<f64> = Vec::new();
        for drive in &world.drives {
            numbers.extend([drive.position, drive.speed, drive.current_a]);
        }
        numbers.extend(world.valves.iter().map(|valve| valve.opening));
        numbers.extend([world.water.pressure_atm(), world.water.flow_lps]);
        numbers.extend(world.fires.iter().flat_map(|fire| [fire.heat, fire.density, fire.size_m]));
        let (rng, line) = (format!("{:?}", world.rng()), self.sim.trace_line());
        for number in numbers {
            self.hash.fold(&number.to_bits().to_le_bytes());
        }
        self.hash.fold(rng.as_bytes());
        self.hash.fold(line.as_bytes());
    }

    /// Does something; the number of its first entry. What was still to be repeated is dropped.
    ///
    /// # Errors
    ///
    /// What is wrong with it, or that the session is full.
    pub fn act(&mut self, act: &Act) -> Result<usize, Words> {
        let first = self.entries.len();
        let actions = self.actions(act)?;
        let mut session = self.session.clone();
        for action in &actions {
            if self.is_over() || !session.has_room(action) {
                return Err(text::SessionFull.words());
            }
            session.actions.push((session.steps, action.clone()));
        }
        self.pending.clear();
        self.replay = None;
        for action in actions {
            self.apply(action);
        }
        Ok(first)
    }

    fn actions(&self, act: &Act) -> Result<Vec<Action>, Words> {
        let fault = |name: &str| {
            Fault::from_name(name).ok_or_else(|| text::NoFault { name: shortened(name) }.words())
        };
        Ok(vec![match act {
            Act::Send { link, input } => self.to_send(*link, input)?,
            Act::Race { first, wired, radio } => {
                let wired = self.to_send(Link::Wired, wired)?;
                let radio = self.to_send(Link::Radio, radio)?;
                return Ok(match first {
                    Link::Wired => vec![wired, radio],
                    Link::Radio => vec![radio, wired],
                });
            }
            Act::Break { fault: name } => Action::Break(fault(name)?),
            Act::Repair { fault: name } => Action::Repair(fault(name)?),
            Act::Light { azimuth, range, fuel } => {
                if !(-180..=180).contains(azimuth) || !RANGE.contains(range) {
                    let (from, to) = (*RANGE.start(), *RANGE.end());
                    return Err(text::FireWhere { from, to }.words());
                }
                Action::Light(*azimuth, *range, *fuel)
            }
            Act::Sweep {} => Action::Sweep,
            Act::Power {} => Action::Power,
        }])
    }

    fn to_send(&self, link: Link, input: &Input) -> Result<Action, Words> {
        if !input.bytes {
            return Ok(Action::Send(link, payload_of(&input.text)?));
        }
        let bytes = bytes_of(&input.text)?;
        // Bytes that begin like a frame go as they are, however wrong the rest of it is.
        let mut mark = Vec::new();
        link::send(Check::Crc16, &Frame { dst: 0, src: 0, payload: &[] }, &mut |it| mark.push(it));
        let begins = bytes.starts_with(&mark[..2]) || bytes.first() == mark.get(1);
        Ok(if begins { Action::Wire(link, bytes) } else { Action::Send(link, in_frame(bytes)?) })
    }

    /// What a text or bytes would be on the wire.
    ///
    /// # Errors
    ///
    /// What is wrong with the text, and where.
    pub fn read(&self, input: &Input) -> Result<Anatomy, Words> {
        let wire = match self.to_send(Link::Wired, input)? {
            Action::Send(link, payload) => self.framed(link, &payload),
            Action::Wire(_, bytes) => bytes,
            _ => Vec::new(),
        };
        Anatomy::of(Way::Request, &wire)
            .map_err(|error| text::NoFrame { what: Undecodable(&error) }.words())
    }

    fn framed(&self, link: Link, payload: &[u8]) -> Vec<u8> {
        let strong = self.sim.device().wants_crc32c(source(link));
        let check = if strong { Check::Crc32c } else { Check::Crc16 };
        let mut wire = Vec::with_capacity(WIRE_MAX);
        let frame = Frame { dst: self.sim.address(), src: CLIENTS[link as usize], payload };
        link::send(check, &frame, &mut |byte| wire.push(byte));
        wire
    }

    fn apply(&mut self, action: Action) {
        let step = self.step().min(STEPS_MAX);
        // Time never goes back.
        let pushed = self.session.push(step, action.clone());
        debug_assert_eq!(pushed, Ok(()));
        let mut entry = self.entry();
        match action {
            Action::Send(link, payload) => {
                let wire = self.framed(link, &payload);
                entry = self.deliver(entry, link, &wire);
            }
            Action::Wire(link, wire) => entry = self.deliver(entry, link, &wire),
            Action::Break(fault) => {
                entry.title = text::DoneBreak { fault: fault_words(fault) }.words();
                self.sim.world_mut().inject(fault);
            }
            Action::Repair(fault) => {
                entry.title = text::DoneRepair { fault: fault_words(fault) }.words();
                self.sim.world_mut().clear(fault);
            }
            Action::Light(azimuth, range, fuel) => {
                entry.title = text::DoneLight { azimuth, range }.words();
                let class = if fuel { Class::Hydrocarbon } else { Class::Solid };
                self.sim.world_mut().light(FireSpec {
                    azimuth_deg: azimuth.into(),
                    range_m: range.into(),
                    size_m: 1.5,
                    class,
                    ..FireSpec::default()
                });
            }
            Action::Sweep => {
                entry.title = text::DoneSweep.words();
                self.sim.world_mut().sweep();
            }
            Action::Power => {
                entry.title = text::DonePower.words();
                self.sim.power_cycle();
            }
        }
        self.hash.fold(entry.title.en.as_bytes());
        self.entries.push(entry);
    }

    fn entry(&self) -> Entry {
        Entry {
            index: self.entries.len(),
            at_ms: self.sim.now_ms() as u32,
            link: None,
            title: Words::default(),
            request: None,
            answer: None,
            walks: Vec::new(),
            silence: None,
        }
    }

    /// A frame comes to the monitor.
    fn deliver(&mut self, mut entry: Entry, link: Link, wire: &[u8]) -> Entry {
        entry.link = Some(link);
        let mut body = [0; BODY_MAX];
        let frame = link::decode_datagram(wire, &mut body);
        let copied = match &frame {
            Ok(frame) if frame.dst == self.sim.address() => {
                walks(&self.sim, source(link), frame.payload)
            }
            _ => Vec::new(),
        };
        let answer = self.sim.datagram(source(link), wire);
        self.hash.fold(wire);
        self.hash.fold(answer.as_deref().unwrap_or_default());
        if answer.is_none() {
            entry.silence = Some(match &frame {
                Err(error) => text::SilenceBroken { what: Undecodable(error) }.words(),
                Ok(frame) if frame.dst != self.sim.address() => {
                    text::SilenceAddress { dst: frame.dst }.words()
                }
                Ok(_) => text::SilenceOther.words(),
            });
        } else {
            entry.walks = copied;
        }
        entry.request = Anatomy::of(Way::Request, wire).ok();
        entry.answer = answer.and_then(|wire| Anatomy::of(Way::Answer, &wire).ok());
        entry.title = match &entry.request {
            Some(anatomy) if anatomy.text.is_empty() => text::DoneProbe.words(),
            Some(anatomy) => Words::same(anatomy.text.join("; ")),
            None => text::DoneBytes { count: wire.len() }.words(),
        };
        entry
    }

    /// The present state, and the entries from this number on.
    pub fn view(&self, since: usize) -> View {
        let world = self.sim.world();
        View {
            at_ms: self.sim.now_ms() as u32,
            hash: format!("{:016x}", self.hash.0),
            replay_ms: self.replay.map(|step| step * STEP_MS),
            over: self.is_over(),
            profile: self.session.setup.profile.to_owned(),
            scene: Scene::of(&self.sim),
            states: states(&self.sim),
            faults: world.faults.active().iter().map(|fault| fault.name()).collect(),
            entries: self.entries.get(since..).unwrap_or_default().to_vec(),
            count: self.entries.len(),
        }
    }
}

const fn source(link: Link) -> Source {
    match link {
        Link::Wired => Source::ExternalConn,
        Link::Radio => Source::Radio,
    }
}

/// The records of requests in their text form, one a line or between semicolons.
pub fn payload_of(typed: &str) -> Result<Vec<u8>, Words> {
    bounded(typed)?;
    let lines = typed.split(['\n', ';']).map(str::trim);
    let lines: Vec<&str> = lines.filter(|it| !it.is_empty() && !it.starts_with('#')).collect();
    if lines.is_empty() {
        return Err(text::NothingTyped.words());
    }
    if lines.len() > REQUESTS_MAX {
        return Err(text::RequestsAtMost { most: REQUESTS_MAX }.words());
    }
    let mut out = [0; PAYLOAD_MAX];
    let mut writer = Writer::new(&mut out);
    for line in lines {
        let mut buffer = [0; request_text::BUFFER_SIZE];
        let request = request_text::parse(line, &mut buffer).map_err(|error| {
            let says = Words::each(|lang: Lang| parse_error_text(line, &error, lang));
            text::InRequest { line: shortened(line), says }.words()
        })?;
        request
            .encode(&mut writer)
            .map_err(|_| text::PayloadAtMost { most: PAYLOAD_MAX }.words())?;
    }
    Ok(writer.written().to_vec())
}

fn in_frame(bytes: Vec<u8>) -> Result<Vec<u8>, Words> {
    if bytes.len() > PAYLOAD_MAX {
        return Err(text::PayloadAtMost { most: PAYLOAD_MAX }.words());
    }
    Ok(bytes)
}

/// Hexadecimal digits, blanks anywhere between them.
fn bytes_of(typed: &str) -> Result<Vec<u8>, Words> {
    bounded(typed)?;
    let digits: Vec<char> = typed.chars().filter(|it| !it.is_whitespace()).collect();
    if digits.is_empty() {
        return Err(text::NothingTyped.words());
    }
    if let Some(wrong) = digits.iter().find(|it| !it.is_ascii_hexdigit()) {
        return Err(text::NoDigit { wrong: *wrong }.words());
    }
    if !digits.len().is_multiple_of(2) {
        return Err(text::HalfByte.words());
    }
    let byte = |pair: &[char]| {
        pair.iter().filter_map(|it| it.to_digit(16)).fold(0, |byte, digit| byte << 4 | digit as u8)
    };
    let bytes: Vec<u8> = digits.chunks(2).map(byte).collect();
    if bytes.len() > WIRE_MAX {
        return Err(text::BytesAtMost { most: WIRE_MAX }.words());
    }
    Ok(bytes)
}

fn bounded(typed: &str) -> Result<(), Words> {
    match typed.len() {
        0..=TEXT_MAX => Ok(()),
        _ => Err(text::TextTooLong { most: TEXT_MAX }.words()),
    }
}

/// What a message quotes of a text.
fn shortened(typed: &str) -> Words {
    same(typed.chars().take(60).collect::<String>())
}
