//! Link frames (observed): `FF C0 | dst src records… crcLo crcHi | C0`, on every medium (ours).
//!
//! Between the two C0 the bytes are escaped: C0 → DB DC, DB → DB DD. The CRC is
//! CRC-16/MODBUS over the unescaped dst, src and records. A frame of dst, src and CRC alone is a
//! presence probe.
//!
//! §L/7 (ours) Where both sides support it, a frame can end with a CRC-32C instead: `FF C0 DB DE |
//! dst src records… crc32c | C0`. For any other receiver `DB DE` is a wrong escape, so that it
//! drops the frame at its start, whatever follows. Each frame is answered in the form in which it
//! came; a client finds out with a probe of this form.

use crate::crc::{Crc16, Crc32c};
use crate::{DecodeError, Expected};

/// Greatest payload, bytes, that every monitor and client accepts (ours).
pub const PAYLOAD_MAX: usize = 512;
/// Unescaped bytes of the longest frame: dst, src, payload, the longer CRC.
pub const BODY_MAX: usize = 2 + PAYLOAD_MAX + Check::Crc32c.size();
/// Bytes on the wire of the longest frame, each body byte escaped.
pub const WIRE_MAX: usize = wire_max(PAYLOAD_MAX);

const SYNC: u8 = 0xFF;
const END: u8 = 0xC0;
const ESCAPE: u8 = 0xDB;
const ESCAPED_END: u8 = 0xDC;
const ESCAPED_ESCAPE: u8 = 0xDD;
/// Bytes that are compared at once.
const WORD: usize = size_of::<usize>();
/// Follows DB at the start of a frame that ends with a CRC-32C.
const MARK_CRC32C: u8 = 0xDE;
/// CRC-16 and CRC-32C over bytes that include their own checksum.
const RESIDUE_CRC16: u16 = 0;
const RESIDUE_CRC32C: u32 = 0x4867_4BC7;

/// The checksum at the end of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Check {
    /// §L/2 CRC-16/MODBUS (observed).
    #[default]
    Crc16,
    /// §L/7 CRC-32C (ours), for peers that both have it.
    Crc32c,
}

impl Check {
    /// Bytes of the checksum.
    pub const fn size(self) -> usize {
        match self {
            Self::Crc16 => 2,
            Self::Crc32c => 4,
        }
    }

    /// Whether the bytes end with the right checksum: the checksum over data and checksum together
    /// is a constant.
    fn holds(self, body: &[u8]) -> bool {
        match self {
            Self::Crc16 => crc16(body) == RESIDUE_CRC16,
            Self::Crc32c => crc32c(body) == RESIDUE_CRC32C,
        }
    }

    /// Bytes on the wire before dst.
    pub const fn start(self) -> usize {
        match self {
            Self::Crc16 => 2,
            Self::Crc32c => 4,
        }
    }

    /// dst, src and the check: the shortest frame.
    const fn overhead(self) -> usize {
        2 + self.size()
    }
}

/// §L/2 CRC-16/MODBUS: reflected 0x8005, start 0xFFFF.
pub fn crc16(bytes: &[u8]) -> u16 {
    let mut crc = Crc16::new();
    crc.update(bytes);
    crc.finish()
}

fn crc32c(bytes: &[u8]) -> u32 {
    let mut crc = Crc32c::new();
    crc.update(bytes);
    crc.finish()
}

/// Most bytes on the wire of a frame with a payload of this many bytes.
pub const fn wire_max(payload: usize) -> usize {
    5 + 2 * (Check::Crc32c.overhead() + payload)
}

/// Bytes that a byte of a frame takes on the wire: two where it is escaped.
pub const fn size_on_wire(byte: u8) -> usize {
    if matches!(byte, END | ESCAPE) { 2 } else { 1 }
}

/// A frame received without errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Receiver.
    pub dst: u8,
    /// Sender.
    pub src: u8,
    /// Records; empty in a presence probe and its answer.
    pub payload: &'a [u8],
}

impl Frame<'_> {
    /// Whether the frame is a presence probe or the answer to one.
    pub const fn is_probe(&self) -> bool {
        self.payload.is_empty()
    }
}

/// §L/1 Writes a frame as it goes on the wire and returns its length; `None` if `out` is too short
/// ([`wire_max`] always suffices).
pub fn encode(frame: &Frame<'_>, out: &mut [u8]) -> Option<usize> {
    encode_with(Check::Crc16, frame, out)
}

/// Writes a frame with the given checksum; otherwise as [`encode`].
pub fn encode_with(check: Check, frame: &Frame<'_>, out: &mut [u8]) -> Option<usize> {
    compose(check, frame.dst, frame.src, out, |place| {
        place.get_mut(..frame.payload.len())?.copy_from_slice(frame.payload);
        Some(frame.payload.len())
    })
}

/// Writes a frame whose payload is built in place: `fill` gets the free part of `out` and returns
/// the length of the payload. No second buffer is needed.
#[inline]
pub fn compose(
    check: Check,
    dst: u8,
    src: u8,
    out: &mut [u8],
    fill: impl FnOnce(&mut [u8]) -> Option<usize>,
) -> Option<usize> {
    let start = check.start();
    let last = out.len().checked_sub(check.size() + 1)?;
    let [first, second, place @ ..] = out.get_mut(start..last)? else { return None };
    [*first, *second] = [dst, src];
    let size = fill(place)?;
    seal(check, start + 2 + size, out)
}

/// §L/1, §L/7 Passes the bytes of a frame to `put` in the order of transmission, so that a chip can
/// send a frame without storing it.
pub fn send(check: Check, frame: &Frame<'_>, put: &mut dyn FnMut(u8)) {
    let addresses = [frame.dst, frame.src];
    let (start, crc): (&[u8], u32) = match check {
        Check::Crc16 => {
            let mut crc = Crc16::new();
            crc.update(&addresses);
            crc.update(frame.payload);
            (&[SYNC, END], crc.finish().into())
        }
        Check::Crc32c => {
            let mut crc = Crc32c::new();
            crc.update(&addresses);
            crc.update(frame.payload);
            (&[SYNC, END, ESCAPE, MARK_CRC32C], crc.finish())
        }
    };
    start.iter().for_each(|byte| put(*byte));
    let crc = crc.to_le_bytes();
    for part in [addresses.as_slice(), frame.payload, crc.get(..check.size()).unwrap_or_default()] {
        for byte in part {
            match *byte {
                END => [ESCAPE, ESCAPED_END].into_iter().for_each(&mut *put),
                ESCAPE => [ESCAPE, ESCAPED_ESCAPE].into_iter().for_each(&mut *put),
                plain => put(plain),
            }
        }
    }
    put(END);
}

/// Completes the frame whose addresses and payload end at `end`: checksum, escapes, frame marks.
fn seal(check: Check, mut end: usize, out: &mut [u8]) -> Option<usize> {
    let start = check.start();
    let body = out.get(start..end)?;
    match check {
        Check::Crc16 => {
            let crc = crc16(body).to_le_bytes();
            *out.first_chunk_mut()? = [SYNC, END];
            *out.get_mut(end..)?.first_chunk_mut()? = crc;
        }
        // §L/7
        Check::Crc32c => {
            let crc = crc32c(body).to_le_bytes();
            *out.first_chunk_mut()? = [SYNC, END, ESCAPE, MARK_CRC32C];
            *out.get_mut(end..)?.first_chunk_mut()? = crc;
        }
    }
    end += check.size();
    let plain = plain(out.get(start..end)?);
    if start + plain < end {
        end = escape(start + plain, end, out)?;
    }
    *out.get_mut(end)? = END;
    Some(end + 1)
}

/// Escapes the bytes from `start` to `end` in place; they grow towards the end of the buffer.
/// Returns their new end.
fn escape(start: usize, end: usize, out: &mut [u8]) -> Option<usize> {
    let (mut escaped, mut at) = (end, start);
    while at < end {
        at += plain(out.get(at..end)?);
        escaped += usize::from(at < end);
        at += 1;
    }
    let (mut from, mut to) = (end, escaped);
    // From the back: the bytes before the first that is escaped do not move.
    while from < to {
        let before = out.get(start..from)?;
        if let Some(word) = before.last_chunk().copied() {
            from -= WORD;
            if first_special(&word).is_none() {
                to -= WORD;
                *out.get_mut(to..)?.first_chunk_mut()? = word;
            } else {
                to = word.iter().rev().try_fold(to, |to, byte| put_before(to, *byte, out))?;
            }
        } else {
            let byte = *before.last()?;
            from -= 1;
            to = put_before(to, byte, out)?;
        }
    }
    Some(escaped)
}

/// Writes a byte, escaped where needed, so that it ends at `end`; returns where it starts.
#[inline]
fn put_before(end: usize, byte: u8, out: &mut [u8]) -> Option<usize> {
    let code = match byte {
        END => ESCAPED_END,
        ESCAPE => ESCAPED_ESCAPE,
        plain => {
            *out.get_mut(..end)?.last_mut()? = plain;
            return Some(end - 1);
        }
    };
    *out.get_mut(..end)?.last_chunk_mut()? = [ESCAPE, code];
    Some(end - 2)
}

/// Number of leading bytes that need no escape.
fn plain(bytes: &[u8]) -> usize {
    let words = bytes.as_chunks().0;
    if let Some((index, place)) =
        words.iter().enumerate().find_map(|(index, word)| Some((index, first_special(word)?)))
    {
        return index * WORD + place;
    }
    match bytes.last_chunk().map(first_special) {
        // The first bytes of this word have been checked already.
        Some(place) => bytes.len() - WORD + place.unwrap_or(WORD),
        None => bytes.iter().position(|b| matches!(*b, END | ESCAPE)).unwrap_or(bytes.len()),
    }
}

/// Copies leading bytes that need no escape; returns their number. The place behind them is
/// overwritten.
#[inline]
fn copy_plain(from: &[u8], to: &mut [u8]) -> usize {
    let mut done = 0;
    for (word, place) in from.as_chunks().0.iter().zip(to.as_chunks_mut().0) {
        *place = *word;
        match first_special(word) {
            Some(plain) => return done + plain,
            None => done += WORD,
        }
    }
    let rest = from.get(done..).unwrap_or_default();
    for (byte, place) in rest.iter().zip(to.get_mut(done..).unwrap_or_default()) {
        if matches!(*byte, END | ESCAPE) {
            break;
        }
        *place = *byte;
        done += 1;
    }
    done
}

/// Index in a word of the first byte that needs an escape.
#[inline]
const fn first_special(bytes: &[u8; WORD]) -> Option<usize> {
    const ONES: usize = usize::MAX / 0xFF;
    let word = usize::from_le_bytes(*bytes);
    let (end, escape) = (word ^ (ONES * END as usize), word ^ (ONES * ESCAPE as usize));
    // Such a byte becomes zero and borrows. C0 and DB both have the highest bit set, so it is
    // checked too.
    let found = (end.wrapping_sub(ONES) | escape.wrapping_sub(ONES)) & word & (ONES << 7);
    if found == 0 { None } else { Some(found.trailing_zeros() as usize / 8) }
}

/// Counters of a decoder since it was created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counters {
    /// Frames received without errors.
    pub frames: u64,
    /// Frames dropped because of their CRC.
    pub crc_errors: u64,
    /// Frames dropped because something else than DC or DD followed DB.
    pub escape_errors: u64,
    /// Frames dropped because they were longer than the buffer.
    pub overruns: u64,
    /// Frames dropped before their end: less than 4 bytes between two C0, or a break on the line.
    pub resyncs: u64,
    /// Bytes that belong to no good frame, without sync bytes.
    pub bytes_skipped: u64,
}

/// What a decoder counts: [`Counters`], or nothing, `()`, to save memory.
pub trait Tally {
    /// Nothing counted.
    const NONE: Self;

    /// Counts an event.
    fn count(&mut self, seen: Seen);
}

/// An event in a decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Seen {
    /// A frame without errors.
    Frame,
    /// A frame with a wrong CRC.
    CrcError,
    /// A wrong escape.
    EscapeError,
    /// A frame that is longer than the buffer.
    Overrun,
    /// A frame that was given up before its end.
    Resync,
    /// This many bytes that belong to no good frame.
    Skipped(usize),
}

impl Tally for Counters {
    const NONE: Self = Self {
        frames: 0,
        crc_errors: 0,
        escape_errors: 0,
        overruns: 0,
        resyncs: 0,
        bytes_skipped: 0,
    };

    #[inline]
    fn count(&mut self, seen: Seen) {
        match seen {
            Seen::Frame => self.frames += 1,
            Seen::CrcError => self.crc_errors += 1,
            Seen::EscapeError => self.escape_errors += 1,
            Seen::Overrun => self.overruns += 1,
            Seen::Resync => self.resyncs += 1,
            Seen::Skipped(bytes) => self.bytes_skipped += bytes as u64,
        }
    }
}

impl Tally for () {
    const NONE: Self = ();

    fn count(&mut self, _: Seen) {}
}

/// Finds the frames in a stream of bytes, in pieces of any length.
///
/// `N` is the longest body, bytes: [`BODY_MAX`] accepts every frame of this protocol. `C` holds the
/// counters.
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize = BODY_MAX, C = Counters> {
    body: [u8; N],
    len: usize,
    /// Bytes on the wire since the C0 that started the frame; an escape counts two.
    wire_len: usize,
    state: State,
    check: Check,
    counters: C,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Before the C0 that starts a frame.
    Idle,
    /// Between the two C0.
    Inside,
    /// After DB.
    Escaped,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// A decoder that waits for the start of a frame.
    pub const fn new() -> Self {
        Self::counting()
    }

    /// Counters since the decoder was created.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }
}

impl<const N: usize, C: Tally> Decoder<N, C> {
    /// A decoder that waits for the start of a frame, with counters of any kind.
    pub const fn counting() -> Self {
        Self {
            body: [0; N],
            len: 0,
            wire_len: 0,
            state: State::Idle,
            check: Check::Crc16,
            counters: C::NONE,
        }
    }

    /// The checksum of the last complete frame; an answer to it uses the same.
    pub const fn check(&self) -> Check {
        self.check
    }

    /// Takes one byte; returns the frame that it completes.
    #[inline]
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        if self.take(byte) { self.last() } else { None }
    }

    /// Takes one byte; returns whether it completes a frame.
    #[inline]
    fn take(&mut self, byte: u8) -> bool {
        if self.state != State::Idle && byte != END {
            self.wire_len += 1;
        }
        match (self.state, byte) {
            (State::Idle, END) => self.start(),
            (State::Idle, SYNC) => {}
            (State::Idle, _) => self.counters.count(Seen::Skipped(1)),
            (_, END) => return self.end(),
            (State::Inside, ESCAPE) => self.state = State::Escaped,
            (State::Inside, plain) => self.store(plain),
            (State::Escaped, ESCAPED_END) => self.unescaped(END),
            (State::Escaped, ESCAPED_ESCAPE) => self.unescaped(ESCAPE),
            (State::Escaped, MARK_CRC32C) if self.len == 0 && self.check == Check::Crc16 => {
                self.state = State::Inside;
                self.check = Check::Crc32c;
            }
            (State::Escaped, _) => {
                self.counters.count(Seen::EscapeError);
                self.drop_frame();
            }
        }
        false
    }

    /// §L/3 Takes bytes until one completes a frame; returns that frame and how many were taken.
    ///
    /// Call it again with the rest until it returns no frame: then all were taken.
    pub fn push_slice(&mut self, bytes: &[u8]) -> (usize, Option<Frame<'_>>) {
        let mut taken = 0;
        while let Some(rest) = bytes.get(taken..) {
            if self.state == State::Inside {
                taken += self.store_run(rest);
            }
            // Behind a run is a byte that ends it, or one for which there is no room.
            let Some(byte) = bytes.get(taken) else { break };
            taken += 1;
            if self.take(*byte) {
                return (taken, self.last());
            }
        }
        (bytes.len(), None)
    }

    /// Takes leading bytes that need no unescaping, as far as the buffer has room; returns their
    /// number.
    fn store_run(&mut self, bytes: &[u8]) -> usize {
        let room = self.body.get_mut(self.len..).unwrap_or_default();
        let run = copy_plain(bytes, room);
        self.len += run;
        self.wire_len += run;
        run
    }

    /// Drops an unfinished frame, after a pause or a break on the medium.
    pub fn reset(&mut self) {
        if self.state != State::Idle && self.len > 0 {
            self.counters.count(Seen::Resync);
            self.drop_frame();
        }
        self.state = State::Idle;
        self.len = 0;
    }

    fn start(&mut self) {
        self.state = State::Inside;
        self.check = Check::Crc16;
        self.len = 0;
        self.wire_len = 0;
    }

    #[inline]
    fn store(&mut self, byte: u8) {
        if let Some(place) = self.body.get_mut(self.len) {
            *place = byte;
            self.len += 1;
        } else {
            self.counters.count(Seen::Overrun);
            self.drop_frame();
        }
    }

    fn unescaped(&mut self, byte: u8) {
        self.state = State::Inside;
        self.store(byte);
    }

    /// Drops the frame and counts its bytes as skipped.
    fn drop_frame(&mut self) {
        self.counters.count(Seen::Skipped(1 + self.wire_len));
        self.state = State::Idle;
        self.len = 0;
    }

    /// §L/4 C0 inside a frame ends it. If the bytes collected are not a frame, this C0 may be the
    /// start of the next, after a frame that lost its end: collecting starts again.
    fn end(&mut self) -> bool {
        let body = self.body.get(..self.len).unwrap_or_default();
        if self.state == State::Escaped {
            self.counters.count(Seen::EscapeError);
        } else if self.len < self.check.overhead() {
            if self.len > 0 {
                self.counters.count(Seen::Resync);
            }
        } else if !self.check.holds(body) {
            self.counters.count(Seen::CrcError);
        } else {
            self.counters.count(Seen::Frame);
            self.state = State::Idle;
            return true;
        }
        self.drop_frame();
        self.start();
        false
    }

    /// The last complete frame; valid until more bytes are taken.
    pub fn last(&self) -> Option<Frame<'_>> {
        split(self.check, self.body.get(..self.len)?).map(|(frame, _)| frame)
    }
}

/// Splits an unescaped body into a frame and its check.
fn split(check: Check, body: &[u8]) -> Option<(Frame<'_>, &[u8])> {
    let (covered, got) = body.split_at_checked(body.len().checked_sub(check.size())?)?;
    let [dst, src, payload @ ..] = covered else { return None };
    Some((Frame { dst: *dst, src: *src, payload }, got))
}

/// Checks the checksum of an unescaped body and returns its frame.
fn verify(check: Check, body: &[u8]) -> Result<Frame<'_>, DecodeError> {
    let short = DecodeError { offset: 0, expected: Expected::FrameEnd, got: body.len() };
    let (frame, got) = split(check, body).ok_or(short)?;
    let covered = body.get(..body.len() - got.len()).unwrap_or_default();
    let got = got.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
    let (right, expected) = match check {
        Check::Crc16 => {
            let crc = crc16(covered);
            (u32::from(crc) == got, Expected::Crc(crc))
        }
        Check::Crc32c => {
            let crc = crc32c(covered);
            (crc == got, Expected::Crc32c(crc))
        }
    };
    let error = DecodeError { offset: covered.len(), expected, got: got as usize };
    if right { Ok(frame) } else { Err(error) }
}

/// §L/7 The checksum of a datagram that is one frame.
pub fn check_of(datagram: &[u8]) -> Check {
    let start = datagram.iter().position(|byte| *byte != SYNC).unwrap_or(datagram.len());
    match datagram.get(start..) {
        Some([END, ESCAPE, MARK_CRC32C, ..]) => Check::Crc32c,
        _ => Check::Crc16,
    }
}

/// §C/1 Reads a datagram that is one frame (ours: one UDP datagram = one frame); `body` takes the
/// unescaped bytes.
///
/// # Errors
///
/// [`DecodeError`] with the offset in the datagram: no frame start, a wrong escape, no end or bytes
/// after it, a frame longer than `body`. For a wrong check the offset is that of the check in the
/// unescaped bytes.
pub fn decode_datagram<'b>(datagram: &[u8], body: &'b mut [u8]) -> Result<Frame<'b>, DecodeError> {
    let error = |offset, expected, got: u8| DecodeError { offset, expected, got: got.into() };
    let mut bytes = datagram.iter().copied().enumerate().peekable();
    while bytes.next_if(|(_, byte)| *byte == SYNC).is_some() {}
    match bytes.next() {
        Some((_, END)) => {}
        other => {
            let (offset, byte) = other.unwrap_or((datagram.len(), 0));
            return Err(error(offset, Expected::FrameStart, byte));
        }
    }
    let mut len = 0;
    let mut marked = false;
    loop {
        let (offset, mut byte) =
            bytes.next().ok_or(error(datagram.len(), Expected::FrameEnd, 0))?;
        match byte {
            END if bytes.peek().is_none() => break,
            END => return Err(error(offset, Expected::FrameEnd, byte)),
            ESCAPE => {
                byte = match bytes.next() {
                    Some((_, ESCAPED_END)) => END,
                    Some((_, ESCAPED_ESCAPE)) => ESCAPE,
                    Some((_, MARK_CRC32C)) if len == 0 && !marked => {
                        marked = true;
                        continue;
                    }
                    Some((offset, byte)) => return Err(error(offset, Expected::Escape, byte)),
                    None => return Err(error(datagram.len(), Expected::FrameEnd, 0)),
                };
            }
            _ => {}
        }
        let room = body.len();
        let place =
            body.get_mut(len).ok_or(DecodeError { offset, expected: Expected::Room, got: room })?;
        *place = byte;
        len += 1;
    }
    verify(check_of(datagram), body.get(..len).unwrap_or_default())
}
