//! Errors of decoding: where, what was expected, what was found.

use core::fmt;

/// Bytes that break the protocol. The fault is the sender's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeError {
    /// Offset of the offending byte from the start of what was decoded.
    pub offset: usize,
    /// What was expected there.
    pub expected: Expected,
    /// What was found: a length or a value, depending on `expected`.
    pub got: usize,
}

/// What the decoder expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// The four bytes of a record header (§2).
    Header,
    /// The number of data bytes that the header's data_size gives (§2).
    Data(usize),
    /// A data size that this request or answer can have.
    Size,
    /// A value in the range of this field.
    Value,
    /// A request identifier of the document.
    RequestId,
    /// The sync byte and the start of a link frame.
    FrameStart,
    /// DC or DD after DB.
    Escape,
    /// The CRC of the frame.
    Crc(u16),
    /// The CRC-32C of a frame (§L/7).
    Crc32c(u32),
    /// The end of the link frame.
    FrameEnd,
    /// A payload that fits the buffer.
    Room,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset, got, .. } = *self;
        write!(f, "at byte {offset}: ")?;
        match self.expected {
            Expected::Header => write!(f, "a record header needs 4 bytes, {got} left"),
            Expected::Data(size) => write!(f, "data_size says {size} bytes, {got} left"),
            Expected::Size => write!(f, "{got} data bytes are not a size this record can have"),
            Expected::Value => write!(f, "value {got} is out of range"),
            Expected::RequestId => write!(f, "unknown request {got:#04x}"),
            Expected::FrameStart => write!(f, "a link frame starts with FF C0, got {got:#04x}"),
            Expected::Escape => write!(f, "after DB only DC or DD may follow, got {got:#04x}"),
            Expected::Crc(crc) => write!(f, "CRC should be {crc:#06x}, frame has {got:#06x}"),
            Expected::Crc32c(crc) => {
                write!(f, "CRC-32C should be {crc:#010x}, frame has {got:#010x}")
            }
            Expected::FrameEnd => write!(f, "the link frame does not end with C0"),
            Expected::Room => {
                write!(f, "the frame is longer than the {got} bytes a receiver keeps")
            }
        }
    }
}

impl core::error::Error for DecodeError {}
