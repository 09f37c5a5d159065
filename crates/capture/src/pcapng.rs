//! pcapng: one interface of link type USER0 (147), a packet for each piece.

use std::borrow::Cow;
use std::io::{self, Read, Write};
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
    let mut reader = PcapNgReader::new(file).map_err(damaged)?;
    let mut others = 0;
    let mut taken = 0;
    while let Some(block) = reader.next_block() {
        let Block::EnhancedPacket(packet) = (match block {
            Ok(block) => block.into_owned(),
            // A recording cut short by the end of the recorder is read up to the last complete
            // packet.
            Err(PcapError::IncompleteBuffer) => break,
            Err(error) => return Err(damaged(error)),
        }) else {
            continue;
        };
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

fn damaged(error: PcapError) -> ReadError {
    ReadError::Damaged(error.to_string())
}

fn to_io(error: PcapError) -> io::Error {
    match error {
        PcapError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
