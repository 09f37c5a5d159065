//! Receiving an image into the slot that is not running, and confirming one that is on trial.

use crate::hash::{Hash, Hasher};
use crate::image::{Board, HEADER_LEN, Header, UNIT, Version};
use crate::memory::Memory;
use crate::record::{Other, Record, Recorded, Slot};
use crate::refusal::Refusal;
use embedded_storage::nor_flash::NorFlash;

/// Bytes that [`Receiver::poll`] hashes at most: a fraction of a millisecond on a Cortex-M3.
pub const HASHED_PER_POLL: u32 = 512;
/// A commit that could not be taken back is tried again after so many calls of [`Receiver::poll`].
const TAKE_BACK_POLLS: u16 = 1024;

/// What the bootloader has started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Started {
    /// The slot.
    pub slot: Slot,
    /// Its version.
    pub version: Version,
    /// It is on trial.
    pub trial: bool,
}

/// How far an update is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// None has been started since the start of the program.
    Idle,
    /// Data are awaited.
    Receiving,
    /// The data are being hashed.
    Verifying,
    /// The image may be committed.
    Verified,
    /// The next start tries the image.
    Committed,
}

/// What there is to say about the software.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// What is running.
    pub started: Started,
    /// How far an update is.
    pub phase: Phase,
    /// Bytes of the payload that are there.
    pub received: u32,
    /// Bytes of the payload; 0 in `Idle`.
    pub size: u32,
    /// The beginning of its hash, by which senders know their images; in `Idle` that of what is running.
    pub image: [u8; 4],
    /// The last trial was not confirmed, or its image no longer verified.
    pub failed: bool,
    /// An image that was committed is not on trial, and a later start may still try it.
    pub pending: bool,
    /// An older image runs than the one that was confirmed last, which does not verify any more.
    pub lost: bool,
}

#[derive(Clone)]
enum State {
    Idle,
    Receiving,
    Verifying { hashed: u32, hasher: Hasher },
    Verified,
    Committed,
}

/// The image that is received.
#[derive(Clone, Copy)]
struct Image {
    header: Header,
    raw: [u8; HEADER_LEN],
    /// The digest of the word that will confirm it.
    word: Hash,
}

/// The receiving side, in the running program.
#[derive(Clone)]
pub struct Receiver<'a, F> {
    memory: Memory<F>,
    board: Board<'a>,
    started: Started,
    /// The hash of what is running; zeros if that could not be read.
    pub(crate) running: Hash,
    /// Layout of the stored parameters.
    layout: u16,
    state: State,
    /// As it was read at the start, or stored since: one that is known is not read again.
    recorded: Recorded,
    /// From `begin` on.
    image: Option<Image>,
    received: u32,
    failed: bool,
    on_trial: bool,
    /// The last image was rejected, and its marks could not be erased.
    rejected: bool,
    /// Calls of `poll` until a commit is taken back; `None` without such a one.
    pending: Option<u16>,
    /// A press at the board is in force.
    pub(crate) pressed: bool,
    /// Feeds a watchdog.
    feed: fn(),
    /// Why the last order was refused; 0 after one that was not.
    pub(crate) reason: u8,
}

impl<'a, F: NorFlash> Receiver<'a, F> {
    /// The receiving side of a program that [`crate::boot()`] has started; `layout` is that in which
    /// its parameters are stored.
    ///
    /// A commit whose trial has not been started is taken back: it would be at a later start, when
    /// it is not expected any more.
    pub fn new(mut memory: Memory<F>, board: Board<'a>, started: Started, layout: u16) -> Self {
        let recorded = memory.record();
        let (other, active) = match recorded {
            Recorded::Known(record) => (record.other, record.active),
            Recorded::Fresh | Recorded::Lost => (Other::Empty, started.slot),
        };
        // What the board passes may be wrong: the record says which slot has been tried.
        let on_trial = started.trial || (other == Other::Tried && active != started.slot);
        let raw = memory.header(started.slot);
        let running =
            raw.and_then(|raw| Header::parse(&raw)).map_or(Hash([0; 32]), |header| header.hash);
        let mut receiver = Self {
            memory,
            board,
            started,
            running,
            layout,
            state: State::Idle,
            recorded,
            image: None,
            received: 0,
            failed: other == Other::Failed,
            on_trial,
            rejected: false,
            pending: (other == Other::Committed && !on_trial).then_some(0),
            pressed: false,
            feed: || {},
            reason: 0,
        };
        receiver.take_back();
        receiver
    }

    /// The flash and the record.
    pub const fn memory(&self) -> &Memory<F> {
        &self.memory
    }

    /// The flash, for settings of its own.
    pub const fn memory_mut(&mut self) -> &mut Memory<F> {
        &mut self.memory
    }

    /// Ends it.
    pub fn into_memory(self) -> Memory<F> {
        self.memory
    }

    /// Whether a press at the board is in force, which allows an image that is not newer to be
    /// started by an order. The board says so, for as long as a person beside it would expect.
    pub const fn set_pressed(&mut self, pressed: bool) {
        self.pressed = pressed;
    }

    /// What feeds the watchdog: it is called before each signature, and for each 64 bytes of a slot that is
    /// hashed whole. An order on trial verifies up to four signatures and hashes a slot three times.
    pub const fn set_feed(&mut self, feed: fn()) {
        self.feed = feed;
    }

    /// The slot that is being written.
    pub const fn target(&self) -> Slot {
        self.started.slot.other()
    }

    /// How far it is.
    pub fn report(&self) -> Report {
        let phase = match self.state {
            State::Idle => Phase::Idle,
            State::Receiving => Phase::Receiving,
            State::Verifying { .. } => Phase::Verifying,
            State::Verified => Phase::Verified,
            State::Committed => Phase::Committed,
        };
        let size = self.image.map_or(0, |image| image.header.size);
        let started = Started { trial: self.on_trial, ..self.started };
        Report {
            started,
            phase,
            received: self.received,
            size,
            image: beginning(self.image.map_or(self.running, |image| image.header.hash)),
            failed: self.failed,
            pending: self.pending.is_some(),
            lost: self.is_lost(),
        }
    }

    /// Begins to receive an image, or goes on with it: returns how many bytes are there already.
    /// `word` is the digest of what will confirm it. `pressed`: a press at the board allows an image
    /// that is not newer.
    ///
    /// On trial, the other slot is written only when there is nothing in it to go back to, or
    /// nothing that could confirm the trial. What is running is the active image from then on.
    ///
    /// # Errors
    ///
    /// Those of [`Header::check`], [`Refusal::OnTrial`], [`Refusal::Place`], [`Refusal::Size`],
    /// [`Refusal::Layout`], [`Refusal::NotNewer`]: then nothing has changed. [`Refusal::Flash`].
    pub fn begin(
        &mut self,
        raw: &[u8; HEADER_LEN],
        word: Hash,
        pressed: bool,
    ) -> Result<u32, Refusal> {
        let record = self.record()?;
        let header = self.check(raw, &record, pressed)?;
        let (slot, running) = (self.target(), self.started.slot);
        let mut feed = self.feed;
        if self.on_trial
            && self.awaits_word(&record)
            && self.memory.verify(slot, &self.board, record.revoked, &mut feed).is_ok()
        {
            return Err(Refusal::OnTrial);
        }
        let image = Image { header, raw: *raw, word };
        if self.image.is_some_and(|begun| begun.raw == *raw) {
            self.image = Some(image);
            return Ok(self.received);
        }
        // The old image of this slot is given up before anything of it is erased.
        self.drop_image();
        self.keep(&Record {
            // Another one was active whose image no longer verifies.
            active: running,
            other: Other::Empty,
            allowed: header.version <= record.floor,
            ..record
        })?;
        self.failed = false;
        if !self.on_trial {
            let _ = self.memory.trust(running);
        }
        let there = !self.rejected && self.memory.header(slot) == Ok(*raw);
        let marked = if there { self.memory.marked(slot) } else { 0 };
        self.memory.begin(slot, raw, marked)?;
        self.rejected = false;
        self.received = (marked * F::ERASE_SIZE).min(header.size as usize) as u32;
        self.image = Some(image);
        self.state = State::Receiving;
        Ok(self.received)
    }

    /// Whether an image may be received.
    fn check(
        &self,
        raw: &[u8; HEADER_LEN],
        record: &Record,
        pressed: bool,
    ) -> Result<Header, Refusal> {
        (self.feed)();
        let header = Header::check(raw, &self.board, record.revoked)?;
        if header.place.is_some_and(|place| place != self.target()) {
            return Err(Refusal::Place);
        }
        if !self.memory.takes(header.size) {
            return Err(Refusal::Size);
        }
        if !header.layouts.reads(self.layout) {
            return Err(Refusal::Layout);
        }
        // What was confirmed last may be had again when an older image has taken its place.
        let again = header.version == record.floor && self.started.version < record.floor;
        if header.version > record.floor || again || pressed {
            Ok(header)
        } else {
            Err(Refusal::NotNewer)
        }
    }

    /// Writes the next part of the payload; returns how many bytes are there now.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotBegun`]; [`Refusal::Misplaced`], and nothing has changed; [`Refusal::Flash`],
    /// and the image has to be started again.
    pub fn data(&mut self, offset: u32, bytes: &[u8]) -> Result<u32, Refusal> {
        let (State::Receiving, Some(Image { header, .. })) = (&self.state, self.image) else {
            return Err(Refusal::NotBegun);
        };
        let end = (offset as usize).saturating_add(bytes.len());
        let whole = !bytes.is_empty() && bytes.len().is_multiple_of(UNIT);
        if offset != self.received || !whole || end > header.size as usize {
            return Err(Refusal::Misplaced);
        }
        let written = self.write(header.size as usize, bytes);
        if written.is_err() {
            self.drop_image();
        }
        written.map(|()| self.received)
    }

    fn write(&mut self, size: usize, bytes: &[u8]) -> Result<(), Refusal> {
        let slot = self.target();
        let start = self.memory.payload_of(slot);
        let mut rest = bytes;
        while !rest.is_empty() {
            let at = self.received as usize;
            let address = start.saturating_add(self.received);
            let in_page = at % F::ERASE_SIZE;
            if in_page == 0 {
                self.memory.erase(address)?;
            }
            let (head, tail) =
                rest.split_at_checked(F::ERASE_SIZE - in_page).unwrap_or((rest, &[]));
            self.memory.write(address, head)?;
            let end = at + head.len();
            if end.is_multiple_of(F::ERASE_SIZE) || end == size {
                self.memory.set_mark(slot, at / F::ERASE_SIZE)?;
            }
            self.received = end as u32;
            rest = tail;
        }
        Ok(())
    }

    /// Begins to verify what was received; [`Self::poll`] does it.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotBegun`], [`Refusal::Incomplete`].
    pub fn verify(&mut self) -> Result<(), Refusal> {
        let Some(Image { header, .. }) = self.image else { return Err(Refusal::NotBegun) };
        match self.state {
            State::Idle => Err(Refusal::NotBegun),
            State::Receiving if self.received < header.size => Err(Refusal::Incomplete),
            State::Receiving => {
                self.state = State::Verifying { hashed: 0, hasher: Hasher::default() };
                Ok(())
            }
            State::Verifying { .. } | State::Verified | State::Committed => Ok(()),
        }
    }

    /// Hashes a little of what is being verified.
    ///
    /// # Errors
    ///
    /// [`Refusal::Hash`], [`Refusal::Flash`]: the image is no longer there, and has to be started
    /// again.
    pub fn poll(&mut self) -> Result<(), Refusal> {
        self.take_back();
        let slot = self.target();
        let (State::Verifying { hashed, hasher }, Some(Image { header, raw, .. })) =
            (&mut self.state, self.image)
        else {
            return Ok(());
        };
        let end = hashed.saturating_add(HASHED_PER_POLL).min(header.size);
        let read = self.memory.hash(slot, *hashed..end, hasher);
        *hashed = end;
        let verified = match read {
            Ok(()) if end < header.size => return Ok(()),
            Ok(()) if self.memory.header(slot) != Ok(raw) => Err(Refusal::Flash),
            Ok(()) if hasher.clone().finish() != header.hash => Err(Refusal::Hash),
            other => other,
        };
        match verified {
            Ok(()) => self.state = State::Verified,
            Err(refusal) => {
                self.drop_image();
                // What is wrong somewhere is received again from its beginning.
                self.rejected = self.memory.forget(slot).is_err();
                return Err(refusal);
            }
        }
        Ok(())
    }

    /// Has the image started on trial by the next start; `word` is the digest that [`Self::begin`]
    /// was given.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotVerified`], [`Refusal::Word`], [`Refusal::Flash`].
    pub fn commit(&mut self, word: Hash) -> Result<(), Refusal> {
        let (State::Verified | State::Committed, Some(image)) = (&self.state, self.image) else {
            return Err(Refusal::NotVerified);
        };
        // Another sender has taken it over.
        if word != image.word {
            return Err(Refusal::Word);
        }
        let record = self.record()?;
        let kept = self.keep(&Record { other: Other::Committed, word, ..record });
        match kept {
            Ok(()) => self.state = State::Committed,
            // It may be in the flash all the same.
            Err(_) => self.pending = Some(0),
        }
        kept
    }

    /// Keeps the image that is on trial: it is what is started from now on. `word` is that whose
    /// digest was committed.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotOnTrial`], [`Refusal::Word`]; those of [`Header::check`] and [`Refusal::Flash`],
    /// and it may be tried again.
    pub fn confirm(&mut self, word: &[u8]) -> Result<(), Refusal> {
        if !self.on_trial {
            return Err(Refusal::NotOnTrial);
        }
        let record = self.record()?;
        if !self.awaits_word(&record) {
            return Err(Refusal::NotOnTrial);
        }
        if Hash::of(word) != record.word {
            return Err(Refusal::Word);
        }
        let slot = self.started.slot;
        (self.feed)();
        // What is never taken back comes from what was signed.
        let header = Header::check(&self.memory.header(slot)?, &self.board, record.revoked)?;
        self.keep(&Record {
            active: slot,
            other: Other::Kept,
            floor: header.version,
            revoked: record.revoked | header.revokes,
            layout: header.layouts.newest,
            allowed: false,
            word: Hash::default(),
        })?;
        // What could not be marked is when the next update begins.
        let _ = self.memory.trust(slot);
        self.on_trial = false;
        Ok(())
    }

    /// Whether the trial that waits for the word of this digest may be ended by a restart now.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotOnTrial`], [`Refusal::Word`]; [`Refusal::Flash`], and it may be tried again.
    pub fn abandon(&mut self, word: Hash) -> Result<(), Refusal> {
        if !self.on_trial {
            return Err(Refusal::NotOnTrial);
        }
        let record = self.record()?;
        match self.awaits_word(&record) {
            true if word == record.word => Ok(()),
            true => Err(Refusal::Word),
            false => Err(Refusal::NotOnTrial),
        }
    }

    /// Whether what was confirmed last does not verify any more, and an older image runs in its place.
    fn is_lost(&self) -> bool {
        let Recorded::Known(record) = self.recorded else { return false };
        !self.on_trial && self.started.version < record.floor
    }

    /// Whether there is a word that confirms what is on trial.
    fn awaits_word(&self, record: &Record) -> bool {
        // The bootloader could not note the trial of one that is still committed.
        let tried = matches!(record.other, Other::Tried | Other::Committed);
        tried && record.active == self.target()
    }

    /// The record, or what it would be on a board that has none yet.
    fn record(&mut self) -> Result<Record, Refusal> {
        if !matches!(self.recorded, Recorded::Known(_)) {
            self.recorded = self.memory.record();
        }
        match self.recorded {
            Recorded::Known(record) => Ok(record),
            Recorded::Fresh | Recorded::Lost => {
                let slot = self.started.slot;
                (self.feed)();
                let header = Header::check(&self.memory.header(slot)?, &self.board, 0)?;
                Ok(Record::starting(slot, &header))
            }
        }
    }

    /// Stores the record; without another word, no commit is pending.
    fn keep(&mut self, record: &Record) -> Result<(), Refusal> {
        self.memory.keep(record)?;
        self.recorded = Recorded::Known(*record);
        self.pending = None;
        Ok(())
    }

    /// Takes back a commit whose trial has not been started, when it is time to.
    fn take_back(&mut self) {
        let (Some(polls), Recorded::Known(record)) = (self.pending, self.recorded) else { return };
        self.pending = polls.checked_sub(1);
        if self.pending.is_none() {
            self.pending = Some(TAKE_BACK_POLLS);
            self.failed = self.keep(&Record { other: Other::Failed, ..record }).is_ok();
        }
    }

    fn drop_image(&mut self) {
        (self.state, self.image, self.received) = (State::Idle, None, 0);
    }
}

/// The beginning of the hash of a payload.
const fn beginning(hash: Hash) -> [u8; 4] {
    let [h0, h1, h2, h3, ..] = hash.0;
    [h0, h1, h2, h3]
}
