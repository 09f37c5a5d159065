//! The bench on which a monitor is tested: one frame, one answer, and a log of the exchanges.

use lafet_client::Framing;
use lafet_proto::id::key;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Shown, Text, conform as text};

use crate::checks::Erased;
use crate::line::Line;
use crate::raw::{self, Incoming, Rec, Splitter};
use crate::safety::{Found, Undo, VALVES};
use crate::verdict::{Halt, Step, fail, must, not_applicable};
use crate::{Level, Options};

/// §3.18/3: requests that a monitor executes under lockout.
const WORKS_LOCKED_OUT: [R; 7] = [
    R::GET_STATUS,
    R::GET_PARAM,
    R::SET_PARAM,
    R::RETRIEVE_LIMITS,
    R::GET_CRASH_DATA,
    R::GET_HOTBED,
    R::LOCKOUT,
];
/// How many times a read is sent, as a radio link may lose it. Tests that count answers do not
/// repeat.
const TRIES: u32 = 3;
/// How many times a parameter of a remote unit is read, and the pause between two reads.
const FETCHES: u32 = 40;
const FETCH_MS: u64 = 100;
/// Most exchanges kept of one test: the first ones and the last.
const LOG_MAX: usize = 60;
/// Pause between two polls of a state, ms.
const POLL_MS: u64 = 100;

/// Bytes sent, and bytes received for them.
#[derive(Clone, Debug)]
pub struct Exchange {
    /// Time since the start, ms.
    pub at_ms: u64,
    /// Bytes sent.
    pub sent: Vec<u8>,
    /// Bytes received.
    pub received: Vec<u8>,
    /// Both as text.
    pub words: String,
}

/// The bench: the connection to the monitor, and what is known about it.
pub struct Bench<'a> {
    pub line: &'a mut dyn Line,
    pub options: &'a Options,
    /// Address at which the monitor answers now: the one in the options but while its memory is erased.
    pub monitor: u8,
    /// No other monitor answers on the line, as a look at all addresses has shown.
    pub alone: bool,
    pub log: Vec<Exchange>,
    /// Number of frames sent since the start, and of those repeated.
    pub frames: u64,
    pub repeats: u64,
    /// The last frame was not answered.
    pub silent: bool,
    /// At least one frame was answered.
    pub was_answered: bool,
    /// State of the monitor at the start.
    pub found: Found,
    pub undo: Vec<Undo>,
    /// Something other than a read was sent, and not restored since.
    pub dirty: bool,
    /// The same since the start.
    pub acted: bool,
    /// Subsystems that may move now.
    pub movers: Vec<S>,
    pub water: bool,
    /// The monitor is being restored, and an interrupt does not stop that.
    pub restoring: bool,
    /// The states of the monitor cannot be read: only reads are tested.
    pub blind: bool,
    /// Something moved unasked, the run was ended from outside, or something could not be undone: the
    /// tester moves nothing any more.
    pub no_motion: bool,
    /// Observations while the memory was erased.
    pub erased: Option<Erased>,
    splitter: Splitter,
    records_in: Vec<u8>,
    started_ms: u64,
}

impl<'a> Bench<'a> {
    pub fn new(line: &'a mut dyn Line, options: &'a Options) -> Self {
        let started_ms = line.now_ms();
        Self {
            line,
            options,
            monitor: options.monitor,
            alone: false,
            log: Vec::new(),
            frames: 0,
            repeats: 0,
            silent: false,
            was_answered: false,
            found: Found::default(),
            undo: Vec::new(),
            dirty: false,
            acted: false,
            movers: Vec::new(),
            water: false,
            restoring: false,
            blind: false,
            no_motion: false,
            erased: None,
            splitter: Splitter::default(),
            records_in: Vec::new(),
            started_ms,
        }
    }

    pub fn now_ms(&self) -> u64 {
        self.line.now_ms().saturating_sub(self.started_ms)
    }

    pub const fn is_framed(&self) -> bool {
        matches!(self.options.framing, Framing::Link)
    }

    /// Not applicable unless the connection carries link frames.
    pub fn framed(&self) -> Step {
        if self.is_framed() {
            return Ok(());
        }
        not_applicable(text::RecordsCarried)
    }

    /// Not applicable over a connection of bare records, which answers each record by itself.
    pub fn several(&self) -> Step {
        self.framed()
    }

    fn interrupted(&self) -> Step {
        use std::sync::atomic::Ordering;
        if !self.restoring && self.options.interrupt.load(Ordering::Relaxed) {
            return Err(Halt::Abort(text::Interrupted.words()));
        }
        if self.line.is_given_up() {
            return Err(Halt::Link(std::io::ErrorKind::Interrupted.into()));
        }
        Ok(())
    }

    /// Stops what may move and closes what may be open, if not everything could be restored because the user
    /// gave up.
    pub fn stop_if_given_up(&mut self) {
        if !self.acted || !self.line.is_given_up() {
            return;
        }
        let stop = Rec::new(R::STOP, S::ALL, &[]).bytes();
        let valves = VALVES.into_iter().filter(|valve| self.has(*valve));
        let close = |valve| Rec::new(R::CLOSE, valve, &key::CLOSE.to_le_bytes()).bytes();
        let closes: Vec<u8> = match self.options.level >= Level::Full {
            true => valves.flat_map(close).collect(),
            false => Vec::new(),
        };
        for payload in [stop, closes].iter().filter(|payload| !payload.is_empty()) {
            let wire = self.framed_bytes(payload);
            // What becomes of it is not waited for.
            let _ = self.line.send_last(&wire);
        }
    }

    fn push_log(&mut self, sent: &[u8], received: &[u8], words: String) {
        if self.log.len() >= LOG_MAX {
            self.log.remove(LOG_MAX / 2);
        }
        let at_ms = self.now_ms();
        self.log.push(Exchange { at_ms, sent: sent.to_vec(), received: received.to_vec(), words });
    }

    /// A link frame to the monitor.
    pub fn framed_bytes(&self, payload: &[u8]) -> Vec<u8> {
        match self.options.framing {
            Framing::Link => raw::frame(self.monitor, self.options.source, payload),
            Framing::Records => payload.to_vec(),
        }
    }

    /// Reads what has come unasked; another answer to an earlier frame is a failure.
    fn drain(&mut self) -> Step {
        let bytes = self.line.recv(0).map_err(Halt::Link)?;
        if bytes.is_empty() {
            return Ok(());
        }
        let mut frames = 0;
        for byte in &bytes {
            frames += usize::from(self.splitter.push(*byte).is_some());
        }
        self.push_log(&[], &bytes, "?".into());
        if self.restoring || frames == 0 && self.is_framed() {
            return Ok(());
        }
        fail(text::OneAnswer, text::AnotherFrameCame)
    }

    /// Sends bytes and receives whole frames (or records), until `wanted` of them have come or the
    /// time is over.
    pub fn exchange(&mut self, sent: &[u8], wanted: usize, wait_ms: u64) -> Step<Vec<Incoming>> {
        self.interrupted()?;
        self.drain()?;
        self.line.send(sent).map_err(Halt::Link)?;
        self.frames += 1;
        self.collect(sent, wanted, wait_ms)
    }

    /// Receives the answers to bytes that were sent.
    pub fn collect(&mut self, sent: &[u8], wanted: usize, wait_ms: u64) -> Step<Vec<Incoming>> {
        let end = self.line.now_ms() + wait_ms;
        let (mut incoming, mut all) = (Vec::new(), Vec::new());
        loop {
            let now = self.line.now_ms();
            if incoming.len() >= wanted || now >= end {
                break;
            }
            // An interrupt does not wait until an answer is given up.
            let bytes = self.line.recv((end - now).min(POLL_MS)).map_err(Halt::Link)?;
            self.interrupted()?;
            self.was_answered |= !bytes.is_empty();
            all.extend_from_slice(&bytes);
            for byte in bytes {
                match self.options.framing {
                    Framing::Link => incoming.extend(self.splitter.push(byte)),
                    Framing::Records => incoming.extend(self.push_record(byte)),
                }
            }
        }
        self.silent = all.is_empty();
        self.push_log(sent, &all, words(sent, &incoming, self.is_framed()));
        Ok(incoming)
    }

    /// §C/3 Without frames, each record counts as a frame.
    fn push_record(&mut self, byte: u8) -> Option<Incoming> {
        self.records_in.push(byte);
        let size = 4 + usize::from(*self.records_in.get(3)?);
        (self.records_in.len() >= size).then(|| Incoming::Frame {
            dst: self.options.source,
            src: self.monitor,
            payload: std::mem::take(&mut self.records_in),
        })
    }

    /// Sends a payload; returns the records of its one answer. Every rule of the frame is checked.
    pub fn frame(&mut self, payload: &[u8]) -> Step<Vec<Rec>> {
        let requests = Rec::all(payload).unwrap_or_default();
        let repeatable = requests.iter().all(is_harmless);
        if !repeatable || requests.is_empty() {
            (self.dirty, self.acted) = (true, true);
        }
        let wire = self.framed_bytes(payload);
        let tries = if repeatable { TRIES } else { 1 };
        for attempt in 0..tries {
            self.repeats += u64::from(attempt > 0);
            let incoming = self.exchange(&wire, 1, self.options.timeout_ms)?;
            if let Some(first) = incoming.into_iter().next() {
                let records = self.answer(first)?;
                self.line.heard();
                return Ok(records);
            }
        }
        fail(text::AnswerFrame, text::NothingWithin { ms: self.options.timeout_ms })
    }

    fn answer(&self, incoming: Incoming) -> Step<Vec<Rec>> {
        let (dst, src, payload) = match incoming {
            Incoming::Frame { dst, src, payload } => (dst, src, payload),
            Incoming::Broken(raw) => {
                return fail(text::FrameWithoutErrors, Shown(raw::hex(&raw)));
            }
        };
        let (monitor, source) = (self.monitor, self.options.source);
        must(
            (dst, src) == (source, monitor),
            text::AddressesSwapped,
            format!("dst {dst}, src {src}"),
        )?;
        let Some(records) = Rec::all(&payload) else {
            return fail(text::WholeRecords, Shown(raw::hex(&payload)));
        };
        if let Some(bad) = records.iter().find(|rec| rec.status > Status::NOT_SUPPORTED) {
            return fail(text::StatusKnown, Shown(bad.words(true)));
        }
        Ok(records)
    }

    /// Sends a request that has one answer record.
    pub fn ask(&mut self, request: R, to: S, data: &[u8]) -> Step<Rec> {
        let records = self.frame(&Rec::new(request, to, data).bytes())?;
        let found = list(&records);
        match <[Rec; 1]>::try_from(records) {
            Ok([rec]) if rec.request == request => Ok(rec),
            _ => fail(text::OneAnswerRecord, Shown(found)),
        }
    }

    /// Sends a request whose answer must come from `from` with one of these statuses.
    pub fn want(&mut self, request: R, to: S, data: &[u8], from: S, any: &[Status]) -> Step<Rec> {
        let rec = self.ask(request, to, data)?;
        if rec.device == from && any.contains(&rec.status) {
            return Ok(rec);
        }
        let statuses: Vec<String> =
            any.iter().map(|status| raw::name(status.name(), status.0)).collect();
        let from = raw::name(from.name(), from.0);
        fail(
            Shown(format!("{} ← {from}: {}", name_of(request), statuses.join(" / "))),
            Shown(rec.words(true)),
        )
    }

    /// Sends a request that must be accepted, without data: Ok and Accepted are equal to a client
    /// (§2).
    pub fn done(&mut self, request: R, to: S, data: &[u8]) -> Step {
        let rec = self.want(request, to, data, to, &[Status::OK, Status::ACCEPTED])?;
        must(rec.data.is_empty(), text::AnswerWithoutData, rec.words(true))
    }

    /// Sends a request that must be refused. §3.18/2: under lockout General refuses it first.
    pub fn refused(&mut self, request: R, to: S, data: &[u8], from: S, status: Status) -> Step {
        let denied = self.found.locked_out && !WORKS_LOCKED_OUT.contains(&request);
        let (from, status) = if denied { (S::GENERAL, Status::DENIED) } else { (from, status) };
        self.want(request, to, data, from, &[status]).map(|_| ())
    }

    /// Not applicable to a monitor that was locked out when it was found.
    pub fn needs_release(&self) -> Step {
        match self.found.locked_out {
            true => not_applicable(text::LockedOut),
            false => Ok(()),
        }
    }

    /// Sends a read that must succeed.
    pub fn read(&mut self, request: R, from: S, data: &[u8]) -> Step<Rec> {
        self.want(request, from, data, from, &[Status::OK])
    }

    /// Flags of a subsystem.
    pub fn flags(&mut self, of: S) -> Step<u32> {
        let rec = self.read(R::GET_STATUS, of, &[])?;
        rec.flags().map_or_else(|| fail(text::WordOfFlags, Shown(rec.words(true))), Ok)
    }

    /// Flags and position of a drive.
    pub fn drive(&mut self, of: S) -> Step<(u32, i32)> {
        let rec = self.read(R::GET_STATUS, of, &[])?;
        match (rec.flags(), rec.i16_at(4)) {
            (Some(flags), Some(position)) => Ok((flags, i32::from(position))),
            _ => fail(text::BytesOfDrive, Shown(rec.words(true))),
        }
    }

    pub fn has(&self, id: S) -> bool {
        self.found.present.contains(&id)
    }

    /// Not applicable without this subsystem.
    pub fn needs(&self, id: S) -> Step {
        if self.has(id) {
            return Ok(());
        }
        let name = raw::name(id.name(), id.0);
        Err(Halt::NotApplicable(text::SubsystemMissing { name }.words()))
    }

    /// The first of these subsystems that the monitor has.
    pub fn one_of(&self, ids: &[S]) -> Step<S> {
        match ids.iter().find(|id| self.has(**id)) {
            Some(id) => Ok(*id),
            None => not_applicable(text::NoSuchSubsystem),
        }
    }

    /// Lets time pass, and checks that nothing moves unasked.
    pub fn wait(&mut self, ms: u64) -> Step {
        let end = self.line.now_ms() + ms;
        loop {
            self.interrupted()?;
            let now = self.line.now_ms();
            if now >= end {
                return Ok(());
            }
            self.collect_quietly((end - now).min(POLL_MS))?;
            if (end.saturating_sub(self.line.now_ms())) > POLL_MS {
                self.watch()?;
            }
        }
    }

    fn collect_quietly(&mut self, ms: u64) -> Step {
        let end = self.line.now_ms() + ms;
        while self.line.now_ms() < end {
            let left = end - self.line.now_ms();
            let bytes = self.line.recv(left).map_err(Halt::Link)?;
            let mut frames = 0;
            for byte in &bytes {
                frames += usize::from(self.splitter.push(*byte).is_some());
            }
            if frames > 0 && !self.restoring {
                self.push_log(&[], &bytes, "?".into());
                return fail(text::OneAnswer, text::AnotherFrameCame);
            }
        }
        Ok(())
    }

    /// Polls until a condition holds.
    pub fn until(
        &mut self,
        limit_ms: u64,
        what: impl Text,
        mut so: impl FnMut(&mut Self) -> Step<bool>,
    ) -> Step {
        let end = self.line.now_ms() + limit_ms;
        loop {
            if so(self)? {
                return Ok(());
            }
            if self.line.now_ms() >= end {
                let seconds = limit_ms.div_ceil(1000);
                return fail(text::Within { what, seconds }, text::NotSo);
            }
            self.watch()?;
            self.collect_quietly(POLL_MS)?;
        }
    }

    /// Polls until the flags of a subsystem have all of `set` and none of `clear`.
    pub fn until_flags(&mut self, of: S, set: u32, clear: u32, limit_ms: u64) -> Step {
        let name = raw::name(of.name(), of.0);
        let flags = text::FlagsBecome {
            name,
            set: format!("{set:#010x}"),
            clear: format!("{clear:#010x}"),
        };
        self.until(limit_ms, flags, |bench| {
            let flags = bench.flags(of)?;
            Ok(flags & set == set && flags & clear == 0)
        })
    }

    /// Checks that a condition holds for `ms`.
    pub fn stays(
        &mut self,
        ms: u64,
        what: impl Text,
        mut so: impl FnMut(&mut Self) -> Step<bool>,
    ) -> Step {
        let end = self.line.now_ms() + ms;
        while self.line.now_ms() < end {
            must(so(self)?, &what, "")?;
            self.watch()?;
            self.collect_quietly(POLL_MS)?;
        }
        Ok(())
    }

    /// Values of a parameter; `None` when the monitor does not have it: the list is ours.
    pub fn get(&mut self, of: S, name: &str) -> Step<Option<Vec<i32>>> {
        self.get_id(of, ParamId::of(name))
    }

    pub fn get_id(&mut self, of: S, id: ParamId) -> Step<Option<Vec<i32>>> {
        let id = id.0.to_le_bytes();
        for _ in 0..FETCHES {
            let rec = self.ask(R::GET_PARAM, of, &id)?;
            match rec.status {
                Status::NOT_CACHED => self.collect_quietly(FETCH_MS)?,
                Status::OK => {
                    let (chunks, rest) = rec.data.get(2..).unwrap_or_default().as_chunks::<4>();
                    must(
                        rest.is_empty() && rec.data.starts_with(&id),
                        text::IdAndValues,
                        rec.words(true),
                    )?;
                    return Ok(Some(chunks.iter().map(|c| i32::from_le_bytes(*c)).collect()));
                }
                _ => return Ok(None),
            }
        }
        fail(text::OkOnceAnswered, Shown("NotCached"))
    }

    /// First value of a parameter that the test needs.
    pub fn param(&mut self, of: S, name: &str) -> Step<i32> {
        match self.get(of, name)?.as_deref() {
            Some([value, ..]) => Ok(*value),
            _ => Err(Halt::NotApplicable(text::ParameterMissing { name }.words())),
        }
    }

    /// Sets a parameter, repeating until a remote unit has accepted it; returns the last answer.
    pub fn try_set(&mut self, of: S, name: &str, values: &[i32]) -> Step<Rec> {
        let data = param_data(name, values);
        for _ in 0..FETCHES {
            let rec = self.ask(R::SET_PARAM, of, &data)?;
            if rec.status != Status::CACHED {
                return Ok(rec);
            }
            self.collect_quietly(FETCH_MS)?;
        }
        fail(text::TakenOnceFree, Shown("Cached"))
    }

    /// Sets a parameter; its old value is restored when the test has ended.
    pub fn set(&mut self, of: S, name: &'static str, value: i32) -> Step {
        let old = self.param(of, name)?;
        self.undo.push(Undo::Param(of, name, old));
        self.put(of, name, value)
    }

    /// Sets a parameter; it is not restored.
    pub fn put(&mut self, of: S, name: &str, value: i32) -> Step {
        self.put_all(of, name, &[value])
    }

    /// Sets all values of a parameter; they are not restored.
    pub fn put_all(&mut self, of: S, name: &str, values: &[i32]) -> Step {
        let rec = self.try_set(of, name, values)?;
        must(
            matches!(rec.status, Status::OK | Status::ACCEPTED) && rec.device == of,
            Shown("§3.5: Accepted"),
            rec.words(true),
        )
    }
}

/// Data of SetParam.
pub fn param_data(name: &str, values: &[i32]) -> Vec<u8> {
    let mut data = ParamId::of(name).0.to_le_bytes().to_vec();
    data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    data
}

/// Whether a request is a read or Stop: safe to send to any monitor.
fn is_harmless(rec: &Rec) -> bool {
    const READS: [R; 6] = [
        R::GET_STATUS,
        R::GET_PARAM,
        R::RETRIEVE_LIMITS,
        R::GET_CRASH_DATA,
        R::GET_HOTBED,
        R::STOP,
    ];
    match rec.request {
        // §U Of its orders, the state.
        R::UPDATE => rec.data == [0],
        request => READS.contains(&request) || request.name().is_none(),
    }
}

pub fn name_of(request: R) -> String {
    raw::name(request.name(), request.0)
}

/// Records as text.
pub fn list(records: &[Rec]) -> String {
    if records.is_empty() {
        return "—".into();
    }
    records.iter().map(|rec| rec.words(true)).collect::<Vec<_>>().join("; ")
}

fn words(sent: &[u8], incoming: &[Incoming], framed: bool) -> String {
    let mut splitter = Splitter::default();
    let frame = match framed {
        true => sent.iter().find_map(|byte| splitter.push(*byte)),
        false => Some(Incoming::Frame { dst: 0, src: 0, payload: sent.to_vec() }),
    };
    let text = |incoming: &Incoming, answer: bool| match incoming {
        Incoming::Broken(raw) => format!("? {}", raw::hex(raw)),
        Incoming::Frame { payload, .. } if payload.is_empty() => "probe".into(),
        Incoming::Frame { payload, .. } => match Rec::all(payload) {
            Some(all) => all.iter().map(|rec| rec.words(answer)).collect::<Vec<_>>().join("; "),
            None => format!("? {}", raw::hex(payload)),
        },
    };
    let asked = frame.map_or_else(|| "?".to_owned(), |frame| text(&frame, false));
    let answers: Vec<String> = incoming.iter().map(|incoming| text(incoming, true)).collect();
    format!("{asked} ⇒ {}", if answers.is_empty() { "—".into() } else { answers.join(" | ") })
}
