//! pcapng: one interface of link type USER0 (147), a packet for each piece.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Read, Write};
use std::time::Duration;

use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::pcapng::{Block, PcapNgReader, PcapNgWriter};
use pcap_file::{DataLink, PcapError};

use crate::read::ReadError;
use crate::whole::{End, Medium, Whole};
use crate::{Captured, Direction};

/// Timestamps are in nanoseconds: a negative power of ten.
const NANOSECONDS: u8 = 9;
/// Lowest two bits of a packet's flags: its direction.
const DIRECTION: u32 = 0b11;
const INBOUND: u32 = 0b01;
const OUTBOUND: u32 = 0b10;

/// Blocks are written at this many bytes, or when the recorder flushes.
const PART: usize = 64 * 1024;

/// Writes pcapng.
pub struct Writer<W: Medium>(PcapNgWriter<Whole<W>>);

impl<W: Medium> Writer<W> {
    pub fn new(out: W) -> io::Result<Self> {
        let mut writer = PcapNgWriter::new(Whole::new(out, End::Anywhere)).map_err(to_io)?;
        let interface = InterfaceDescriptionBlock {
            linktype: DataLink::USER0,
            snaplen: 0,
            options: vec![
                InterfaceDescriptionOption::IfName(Cow::Borrowed("lafet")),
                InterfaceDescriptionOption::IfTsResol(NANOSECONDS),
            ],
        };
        writer.write_pcapng_block(interface).map_err(to_io)?;
        Ok(Self(writer))
    }

    pub fn write(&mut self, captured: &Captured) -> io::Result<()> {
        let flags = match captured.direction {
            Direction::ToMonitor => OUTBOUND,
            Direction::FromMonitor => INBOUND,
            Direction::Heard => 0,
        };
        let packet = EnhancedPacketBlock {
            interface_id: 0,
            timestamp: Duration::from_nanos(captured.at_ns),
            original_len: captured.bytes.len() as u32,
            data: Cow::Borrowed(&captured.bytes),
            options: vec![EnhancedPacketOption::Flags(flags)],
        };
        self.0.write_pcapng_block(packet).map_err(to_io)?;
        if self.0.get_mut().waiting() > PART { self.flush() } else { Ok(()) }
    }

    pub fn flush(&mut self) -> io::Result<()> {
        self.0.get_mut().flush()
    }
}

/// Reads the packets of pcapng that are pieces of a line, one at a time; `take` returns whether to
/// continue.
pub fn read(file: impl Read, mut take: impl FnMut(Captured) -> bool) -> Result<(), ReadError> {
    let mut reader = PcapNgReader::new(Blocks::of(file)).map_err(damaged)?;
    let mut others = 0;
    let mut taken = 0;
    loop {
        let block = match reader.next_block().map(|block| block.map(Block::into_owned)) {
            None => break,
            Some(Ok(block)) => block,
            // A recording cut short by the end of the recorder is read up to the last complete
            // packet. The library has the same error for a block that is damaged, or too long for it.
            Some(Err(PcapError::IoError(error))) if is_end(&error) && reader.get_ref().is_cut() => {
                break;
            }
            Some(Err(error)) => return Err(damaged(error)),
        };
        let Block::EnhancedPacket(packet) = block else { continue };
        let interface = reader.interfaces().get(packet.interface_id as usize);
        if interface.is_none_or(|interface| interface.linktype != DataLink::USER0) {
            others += 1;
            continue;
        }
        let flags = packet.options.iter().find_map(|option| match option {
            EnhancedPacketOption::Flags(flags) => Some(flags & DIRECTION),
            _ => None,
        });
        let direction = match flags {
            Some(OUTBOUND) => Direction::ToMonitor,
            Some(INBOUND) => Direction::FromMonitor,
            _ => Direction::Heard,
        };
        taken += 1;
        let goes_on = take(Captured {
            // u64 nanoseconds last until 2554.
            at_ns: packet.timestamp.as_nanos() as u64,
            direction,
            bytes: packet.data.into_owned(),
        });
        if !goes_on {
            return Ok(());
        }
    }
    if taken == 0 && others > 0 { Err(ReadError::NoLine) } else { Ok(()) }
}

/// Bytes with which every block begins: type, length; in a section header, the mark of its byte order.
const HEAD: usize = 12;
/// Type of a section header, the same in either order.
const SECTION: [u8; 4] = *b"\n\r\r\n";
/// The mark of the byte order, as a number.
const MARK: u32 = 0x1A2B_3C4D;

/// A file that knows whether it ends within a block.
struct Blocks<R> {
    file: R,
    head: Vec<u8>,
    /// Bytes until the end of a block.
    left: u64,
    is_big: bool,
    has_ended: bool,
}

impl<R> Blocks<R> {
    const fn of(file: R) -> Self {
        Self { file, head: Vec::new(), left: 0, is_big: false, has_ended: false }
    }

    const fn is_cut(&self) -> bool {
        self.has_ended && (self.left > 0 || !self.head.is_empty())
    }

    fn follow(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            if self.left > 0 {
                let passed = usize::try_from(self.left).unwrap_or(usize::MAX).min(bytes.len());
                bytes = &bytes[passed..];
                self.left -= passed as u64;
                continue;
            }
            let (head, rest) = bytes.split_at(bytes.len().min(HEAD - self.head.len()));
            bytes = rest;
            self.head.extend(head);
            let Ok(head) = <[u8; HEAD]>::try_from(self.head.as_slice()) else { return };
            let [a, b, c, d, e, f, g, h, mark @ ..] = head;
            if [a, b, c, d] == SECTION {
                self.is_big = u32::from_be_bytes(mark) == MARK;
            }
            let number = if self.is_big { u32::from_be_bytes } else { u32::from_le_bytes };
            self.left = u64::from(number([e, f, g, h])).saturating_sub(HEAD as u64);
            self.head.clear();
        }
    }
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer)?;
        self.has_ended |= read == 0 && !buffer.is_empty();
        self.follow(buffer.get(..read).unwrap_or_default());
        Ok(read)
    }
}

fn is_end(error: &io::Error) -> bool {
    error.kind() == ErrorKind::UnexpectedEof
}

fn damaged(error: PcapError) -> ReadError {
    match error {
        PcapError::IoError(error) if !is_end(&error) => ReadError::Io(error),
        other => ReadError::Damaged(other.to_string()),
    }
}

fn to_io(error: PcapError) -> io::Error {
    match error {
        PcapError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
