//! Receiving an image into the slot that is not running, and confirming one that is on trial.

use crate::hash::{Hash, Hasher};
use crate::image::{Board, HEADER_LEN, Header, UNIT, Version};
use crate::memory::Memory;
use crate::record::{Other, Record, Recorded, Slot};
use crate::refusal::Refusal;
use embedded_storage::nor_flash::NorFlash;

/// Bytes that [`Receiver::poll`] hashes at most: a fraction of a millisecond on a Cortex-M3.
pub const HASHED_PER_POLL: u32 = 512;

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
    /// The last trial was not confirmed, or its image no longer verified.
    pub failed: bool,
}

#[derive(Clone)]
enum State {
    Idle,
    Receiving,
    Verifying { hashed: u32, hasher: Hasher },
    Verified,
    Committed,
}

/// The receiving side, in the running program.
pub struct Receiver<'a, F> {
    memory: Memory<F>,
    board: Board<'a>,
    started: Started,
    /// Layout of the stored parameters.
    layout: u16,
    state: State,
    /// The header of the image, and its bytes, from `begin` on.
    image: Option<(Header, [u8; HEADER_LEN])>,
    received: u32,
    failed: bool,
    on_trial: bool,
    /// A press at the board is in force.
    pub(crate) pressed: bool,
    /// Why the last order was refused; 0 after one that was not.
    pub(crate) reason: u8,
}

impl<'a, F: NorFlash> Receiver<'a, F> {
    /// The receiving side of a program that [`crate::boot()`] has started; `layout` is that in which
    /// its parameters are stored.
    pub fn new(mut memory: Memory<F>, board: Board<'a>, started: Started, layout: u16) -> Self {
        let failed =
            matches!(memory.record(), Recorded::Known(Record { other: Other::Failed, .. }));
        let on_trial = started.trial;
        let (state, image, received) = (State::Idle, None, 0);
        let (pressed, reason) = (false, 0);
        Self {
            memory,
            board,
            started,
            layout,
            state,
            image,
            received,
            failed,
            on_trial,
            pressed,
            reason,
        }
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
        let size = self.image.map_or(0, |(header, _)| header.size);
        let started = Started { trial: self.on_trial, ..self.started };
        Report { started, phase, received: self.received, size, failed: self.failed }
    }

    /// Begins to receive an image, or goes on with it: returns how many bytes are there already.
    /// `pressed`: a press at the board allows an image that is not newer.
    ///
    /// # Errors
    ///
    /// Those of [`Header::check`], [`Refusal::OnTrial`], [`Refusal::Place`], [`Refusal::Size`],
    /// [`Refusal::Layout`], [`Refusal::NotNewer`]: then nothing has changed. [`Refusal::Flash`].
    pub fn begin(&mut self, raw: &[u8; HEADER_LEN], pressed: bool) -> Result<u32, Refusal> {
        if self.on_trial {
            return Err(Refusal::OnTrial);
        }
        let mut record = self.record();
        let header = Header::check(raw, &self.board, record.revoked)?;
        let slot = self.target();
        if header.place.is_some_and(|place| place != slot) {
            return Err(Refusal::Place);
        }
        if !self.memory.takes(header.size) {
            return Err(Refusal::Size);
        }
        if !header.layouts.reads(self.layout) {
            return Err(Refusal::Layout);
        }
        let newer = header.version > record.floor;
        if !newer && !pressed {
            return Err(Refusal::NotNewer);
        }
        if self.image.is_some_and(|(_, begun)| begun == *raw) {
            return Ok(self.received);
        }
        // The old image of this slot is given up before anything of it is erased.
        (record.other, record.allowed) = (Other::Empty, !newer);
        self.drop_image();
        self.memory.keep(&record)?;
        self.failed = false;
        let there = self.memory.header(slot) == Ok(*raw);
        let marked = if there { self.memory.marked(slot) } else { 0 };
        self.memory.begin(slot, raw, marked)?;
        self.received = (marked * F::ERASE_SIZE).min(header.size as usize) as u32;
        self.image = Some((header, *raw));
        self.state = State::Receiving;
        Ok(self.received)
    }

    /// Writes the next part of the payload; returns how many bytes are there now.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotBegun`]; [`Refusal::Misplaced`], and nothing has changed; [`Refusal::Flash`],
    /// and the image has to be started again.
    pub fn data(&mut self, offset: u32, bytes: &[u8]) -> Result<u32, Refusal> {
        let (State::Receiving, Some((header, _))) = (&self.state, self.image) else {
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
        let Some((header, _)) = self.image else { return Err(Refusal::NotBegun) };
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
        let slot = self.target();
        let (State::Verifying { hashed, hasher }, Some((header, raw))) =
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
                let _ = self.memory.forget(slot);
                return Err(refusal);
            }
        }
        Ok(())
    }

    /// Has the image started on trial by the next start; `word` is the digest of what will confirm
    /// it.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotVerified`], [`Refusal::Flash`].
    pub fn commit(&mut self, word: Hash) -> Result<(), Refusal> {
        if !matches!(self.state, State::Verified | State::Committed) {
            return Err(Refusal::NotVerified);
        }
        let record = Record { other: Other::Committed, word, ..self.record() };
        self.memory.keep(&record)?;
        self.state = State::Committed;
        Ok(())
    }

    /// Keeps the image that is on trial: it is what is started from now on. `word` is what was
    /// agreed upon when it was committed.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotOnTrial`], [`Refusal::Word`], [`Refusal::Flash`].
    pub fn confirm(&mut self, word: &[u8]) -> Result<(), Refusal> {
        let Recorded::Known(record) = self.memory.record() else {
            return Err(Refusal::NotOnTrial);
        };
        let tried = record.other == Other::Tried && record.active == self.target();
        if !self.on_trial || !tried {
            return Err(Refusal::NotOnTrial);
        }
        if Hash::of(word) != record.word {
            return Err(Refusal::Word);
        }
        let header = Header::parse(&self.memory.header(self.started.slot)?)?;
        self.memory.keep(&Record {
            active: self.started.slot,
            other: Other::Kept,
            floor: header.version,
            revoked: record.revoked | header.revokes,
            allowed: false,
            word: Hash::default(),
        })?;
        self.on_trial = false;
        Ok(())
    }

    /// The record, or what it would be on a board that has none yet.
    fn record(&mut self) -> Record {
        match self.memory.record() {
            Recorded::Known(record) => record,
            Recorded::Fresh | Recorded::Lost => {
                Record::starting(self.started.slot, self.started.version)
            }
        }
    }

    fn drop_image(&mut self) {
        (self.state, self.image, self.received) = (State::Idle, None, 0);
    }
}
