//! §2 «Формат заголовка запроса/ответа»: records, many in one frame.

use crate::{DecodeError, Expected, RequestId, Status, SubsystemId};

/// Bytes in the header of a record.
pub const HEADER_SIZE: usize = 4;
/// Most data bytes in a record: data_size is one byte.
pub const DATA_MAX: usize = 255;

/// One request or answer in a frame (§2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// Identifier of the request.
    pub request: RequestId,
    /// In a request the addressee, in an answer the subsystem that answers.
    pub device: SubsystemId,
    /// Result; in a request 0, without meaning.
    pub status: Status,
    /// Data of the request or answer, at most [`DATA_MAX`] bytes.
    pub data: &'a [u8],
}

impl Record<'_> {
    /// General's report that its buffer for answers is full (§1, note).
    pub fn is_full(&self) -> bool {
        self.device == SubsystemId::GENERAL && self.status == Status::NO_ROOM
    }

    /// Bytes on the wire.
    pub const fn size(&self) -> usize {
        HEADER_SIZE + self.data.len()
    }
}

/// Splits a frame's payload into records.
///
/// Iteration ends after an error: if one record is cut short, the start of the next is unknown.
#[derive(Clone, Debug)]
pub struct Records<'a> {
    rest: &'a [u8],
    offset: usize,
}

impl<'a> Records<'a> {
    /// The records of a payload: the bytes between the addresses and the CRC.
    pub const fn new(payload: &'a [u8]) -> Self {
        Self { rest: payload, offset: 0 }
    }

    /// Offset of the next record in the payload.
    pub const fn offset(&self) -> usize {
        self.offset
    }

    /// Bytes not yet split.
    pub const fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, DecodeError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let offset = self.offset;
        let Some((&[request, device, status, data_size], data)) = self.rest.split_first_chunk()
        else {
            let got = self.rest.len();
            self.rest = &[];
            return Some(Err(DecodeError { offset, expected: Expected::Header, got }));
        };
        let size = usize::from(data_size);
        let Some((data, rest)) = data.split_at_checked(size) else {
            let got = data.len();
            self.rest = &[];
            let offset = offset + HEADER_SIZE;
            return Some(Err(DecodeError { offset, expected: Expected::Data(size), got }));
        };
        self.rest = rest;
        self.offset = offset + HEADER_SIZE + size;
        Some(Ok(Record {
            request: RequestId(request),
            device: SubsystemId(device),
            status: Status(status),
            data,
        }))
    }
}

/// A record did not fit its buffer, or its data are longer than [`DATA_MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoRoom;

impl core::fmt::Display for NoRoom {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the record does not fit: 255 data bytes at most, and no more than the buffer")
    }
}

impl core::error::Error for NoRoom {}

/// Appends records to a buffer; never writes part of a record.
#[derive(Debug)]
pub struct Writer<'a> {
    buffer: &'a mut [u8],
    len: usize,
    /// Where the reserved bytes start.
    limit: usize,
}

impl<'a> Writer<'a> {
    /// Writes from the start of `buffer`.
    pub const fn new(buffer: &'a mut [u8]) -> Self {
        let limit = buffer.len();
        Self { buffer, len: 0, limit }
    }

    /// Reserves this many bytes at the end from now on; 0 releases them.
    pub const fn reserve(&mut self, bytes: usize) {
        self.limit = self.buffer.len().saturating_sub(bytes);
    }

    /// Bytes written so far.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether nothing is written yet.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bytes still free, without those reserved.
    pub const fn room(&self) -> usize {
        self.limit.saturating_sub(self.len)
    }

    /// The bytes written so far.
    pub fn written(&self) -> &[u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }

    /// Writes a whole record, or nothing.
    ///
    /// # Errors
    ///
    /// [`NoRoom`], and nothing is written, for more than 255 bytes of data or more than the buffer
    /// has room for.
    #[inline]
    pub fn push(&mut self, record: &Record<'_>) -> Result<(), NoRoom> {
        self.push_bytes(record.request, record.device, record.status, record.data)
    }

    /// Writes a whole record with these data, or nothing.
    #[inline]
    pub(crate) fn push_bytes(
        &mut self,
        request: RequestId,
        device: SubsystemId,
        status: Status,
        data: &[u8],
    ) -> Result<(), NoRoom> {
        let size = u8::try_from(data.len()).map_err(|_| NoRoom)?;
        let free = self.buffer.get_mut(self.len..self.limit).ok_or(NoRoom)?;
        let place = free.get_mut(..HEADER_SIZE + data.len()).ok_or(NoRoom)?;
        let (header, place) = place.split_first_chunk_mut::<HEADER_SIZE>().ok_or(NoRoom)?;
        *header = [request.0, device.0, status.0, size];
        // `copy_from_slice` may be linked with a panic, where it is not inlined.
        for (to, from) in place.iter_mut().zip(data) {
            *to = *from;
        }
        self.len += HEADER_SIZE + data.len();
        Ok(())
    }

    /// Writes a record whose data `fill` appends in place, or nothing if they do not fit.
    ///
    /// # Errors
    ///
    /// [`NoRoom`], and nothing is written: the error of `fill`, or a record that does not fit.
    #[inline]
    pub fn push_with(
        &mut self,
        request: RequestId,
        device: SubsystemId,
        status: Status,
        fill: impl FnOnce(&mut Data<'_>) -> Result<(), NoRoom>,
    ) -> Result<(), NoRoom> {
        let free = self.buffer.get_mut(self.len..self.limit).ok_or(NoRoom)?;
        let (header, data) = free.split_first_chunk_mut::<HEADER_SIZE>().ok_or(NoRoom)?;
        let limit = data.len().min(DATA_MAX);
        let mut data = Data { buffer: data.get_mut(..limit).ok_or(NoRoom)?, len: 0 };
        fill(&mut data)?;
        let size = u8::try_from(data.len).map_err(|_| NoRoom)?;
        *header = [request.0, device.0, status.0, size];
        self.len += HEADER_SIZE + usize::from(size);
        Ok(())
    }
}

/// The data part of a record being written.
#[derive(Debug)]
pub struct Data<'a> {
    buffer: &'a mut [u8],
    len: usize,
}

impl Data<'_> {
    /// Appends bytes.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when the record would have more than 255 bytes of data, or the buffer is full.
    #[inline]
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), NoRoom> {
        let end = self.len.checked_add(bytes.len()).ok_or(NoRoom)?;
        let space = self.buffer.get_mut(self.len..end).ok_or(NoRoom)?;
        space.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
        self.len = end;
        Ok(())
    }

    /// Appends a signed 16-bit value.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when the record would have more than 255 bytes of data, or the buffer is full.
    #[inline]
    pub fn put_i16(&mut self, value: i16) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    /// Appends an unsigned 16-bit value.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when the record would have more than 255 bytes of data, or the buffer is full.
    #[inline]
    pub fn put_u16(&mut self, value: u16) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    /// Appends 32-bit values.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when the record would have more than 255 bytes of data, or the buffer is full.
    #[inline]
    pub fn put_ints(&mut self, values: impl Iterator<Item = i32>) -> Result<(), NoRoom> {
        for value in values {
            self.put(&value.to_le_bytes())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §2: what is written is read back; a cut record ends the frame.
    #[test]
    fn write_read_cut() {
        let mut buffer = [0; 32];
        let mut writer = Writer::new(&mut buffer);
        let record = Record {
            request: RequestId::MOVE,
            device: SubsystemId::VERTICAL,
            status: Status::OK,
            data: &[0xA0, 0xAB],
        };
        writer.push(&record).unwrap();
        writer.push(&record).unwrap();
        let bytes = writer.written();
        assert_eq!(bytes[..6], [0x4D, 0x0D, 0, 2, 0xA0, 0xAB]);
        let all: std::vec::Vec<_> = Records::new(bytes).collect();
        assert_eq!(all, [Ok(record), Ok(record)]);

        let cut: std::vec::Vec<_> = Records::new(&bytes[..11]).collect();
        let error = DecodeError { offset: 10, expected: Expected::Data(2), got: 1 };
        assert_eq!(cut, [Ok(record), Err(error)]);
        let header: std::vec::Vec<_> = Records::new(&bytes[..8]).collect();
        assert_eq!(header[1], Err(DecodeError { offset: 6, expected: Expected::Header, got: 2 }));
    }

    #[test]
    fn nothing_is_written_by_halves() {
        let mut buffer = [0xEE; 9];
        let mut writer = Writer::new(&mut buffer);
        let record = Record {
            request: RequestId::MOVE,
            device: SubsystemId::VERTICAL,
            status: Status::OK,
            data: &[1, 2],
        };
        assert_eq!(writer.push(&record), Ok(()));
        assert_eq!(writer.push(&record), Err(NoRoom));
        assert_eq!((writer.len(), writer.room()), (6, 3));
        let long = Record { data: &[0; 256], ..record };
        assert_eq!(Writer::new(&mut [0; 300]).push(&long), Err(NoRoom));
    }
}
