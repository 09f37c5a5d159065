//! Services of the bus controller (observed): probes, access, the map of the bus, its log.
//!
//! With a controller on the bus an active device speaks only after AccessGranted.

use crate::record::{NoRoom, Record, Records};
use crate::{DecodeError, Expected, RequestId, Status, SubsystemId};

/// Address of the bus controller.
pub const CONTROLLER: u8 = 128;
/// Addresses of monitors, "passive" devices.
pub const MONITORS: core::ops::RangeInclusive<u8> = 1..=127;
/// Addresses of consoles, "active" devices.
pub const CONSOLES: core::ops::RangeInclusive<u8> = 129..=254;

/// Default speed of the line, 8N1.
pub const BAUD_DEFAULT: u32 = 19_200;
/// Time that the controller waits for an answer, ms.
pub const REPLY_TIMEOUT_MS: u32 = 150;
/// Time that the controller waits for the answer to a presence probe, ms.
pub const PROBE_TIMEOUT_MS: u32 = 30;
/// Transmissions of a frame before its device is dropped; each timeout is twice the one before.
pub const TRIES: u32 = 3;

/// §L/8 Presence probes that are answered without delay (ours).
const PROBES_AT_ONCE: u8 = 255;
/// Time after which one more probe is answered, ms (ours).
const PROBE_AGAIN_MS: u32 = 512;

/// §L/8 Limits how many presence probes are answered (ours): the answer to a probe looks like a
/// probe, so two devices that answer each other would never stop. One frame that is left without an
/// answer stops them.
/// that answer each other would never end without a limit. One frame without an answer ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbeLimit {
    left: u8,
    since_ms: u32,
}

impl ProbeLimit {
    /// A limit with all its probes left.
    pub const fn new() -> Self {
        Self { left: PROBES_AT_ONCE, since_ms: 0 }
    }

    /// Whether one more probe is answered now. The time, ms, may wrap.
    pub fn allows(&mut self, now_ms: u32) -> bool {
        let more = now_ms.wrapping_sub(self.since_ms) / PROBE_AGAIN_MS;
        if more > 0 {
            self.since_ms = now_ms;
            self.left = self.left.saturating_add(more.min(PROBES_AT_ONCE.into()) as u8);
        }
        let allows = self.left > 0;
        self.left = self.left.saturating_sub(1);
        allows
    }
}

impl Default for ProbeLimit {
    fn default() -> Self {
        Self::new()
    }
}

/// §C/2 Default TCP and UDP port of the wired interface (ours).
pub const PORT_EXTERNAL_CONN: u16 = 10_485;
/// Default TCP and UDP port of the radio interface (ours).
pub const PORT_RADIO: u16 = 10_486;

impl RequestId {
    /// Bus (observed): sent by the controller to an active device, addressee General, no data.
    pub const ACCESS_GRANTED: Self = Self(0xE6);
    /// Bus (observed): a 32-byte map of the addresses on the bus.
    pub const GET_NETWORK_STATUS: Self = Self(0x29);
    /// Bus (observed): lines of the controller's log.
    pub const GET_LOG: Self = Self(0x0E);

    /// §B/1 The controller's services, which a monitor does not support.
    pub const BUS: &'static [(Self, &'static str)] = &[
        (Self::ACCESS_GRANTED, "AccessGranted"),
        (Self::GET_NETWORK_STATUS, "GetNetworkStatus"),
        (Self::GET_LOG, "GetLog"),
    ];

    /// Whether the request only reads: it changes nothing, and its success carries the data asked
    /// for.
    pub const fn is_read(self) -> bool {
        matches!(
            self,
            Self::GET_STATUS
                | Self::GET_PARAM
                | Self::RETRIEVE_LIMITS
                | Self::GET_HOTBED
                | Self::GET_CRASH_DATA
                | Self::GET_NETWORK_STATUS
                | Self::GET_LOG
        )
    }
}

const _: () = {
    use crate::hash::{conv8, fnv1a32};
    assert!(conv8(fnv1a32("AccessGranted")) == RequestId::ACCESS_GRANTED.0);
    assert!(conv8(fnv1a32("GetNetworkStatus")) == RequestId::GET_NETWORK_STATUS.0);
    assert!(conv8(fnv1a32("GetLog")) == RequestId::GET_LOG.0);
};

/// Answer to GetNetworkStatus: bit (a − 1) is address a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NetworkStatus(pub [u8; 32]);

impl NetworkStatus {
    /// Whether a device answers at this address; 0 is no address.
    pub fn contains(&self, address: u8) -> bool {
        let Some(bit) = address.checked_sub(1) else { return false };
        self.0.get(usize::from(bit / 8)).is_some_and(|byte| byte & (1 << (bit % 8)) != 0)
    }

    /// Marks an address as present or not; 0 is no address and is ignored.
    pub fn set(&mut self, address: u8, present: bool) {
        let Some(bit) = address.checked_sub(1) else { return };
        if let Some(byte) = self.0.get_mut(usize::from(bit / 8)) {
            *byte = *byte & !(1 << (bit % 8)) | u8::from(present) << (bit % 8);
        }
    }

    /// The addresses present, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u8> + '_ {
        (1..=u8::MAX).filter(|address| self.contains(*address))
    }
}

/// Answer to GetLog: the range of lines asked for, and the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Log<'a> {
    /// First line asked for.
    pub first: u16,
    /// Number of lines asked for.
    pub count: u16,
    /// Bytes of the lines.
    pub lines: &'a [u8],
}

/// A line of the controller's log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogLine<'a> {
    /// Unix time, s.
    pub time_s: u32,
    /// Receiver of the logged frame.
    pub dst: u8,
    /// Sender of the logged frame.
    pub src: u8,
    /// The logged request.
    pub record: Record<'a>,
}

impl<'a> Log<'a> {
    pub(crate) fn decode(data: &'a [u8]) -> Result<Self, DecodeError> {
        let Some((&[a, b, c, d], lines)) = data.split_first_chunk() else {
            return Err(DecodeError { offset: 0, expected: Expected::Size, got: data.len() });
        };
        let log =
            Self { first: u16::from_le_bytes([a, b]), count: u16::from_le_bytes([c, d]), lines };
        log.iter().try_for_each(|line| line.map(|_| ()))?;
        Ok(log)
    }

    /// The lines in order; iteration ends after the first error.
    pub fn iter(&self) -> impl Iterator<Item = Result<LogLine<'a>, DecodeError>> + use<'a> {
        let mut rest = self.lines;
        core::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            let (line, tail) = log_line(rest);
            rest = tail;
            Some(line)
        })
    }
}

impl LogLine<'_> {
    /// Appends the line to the data of a GetLog answer.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when the line does not fit what is left of the 255 bytes of a record, or of the
    /// payload.
    pub fn encode(&self, data: &mut crate::record::Data<'_>) -> Result<(), NoRoom> {
        let size = u8::try_from(self.record.data.len()).map_err(|_| NoRoom)?;
        data.put(&self.time_s.to_le_bytes())?;
        data.put(&[self.dst, self.src])?;
        let Record { request, device, status, .. } = self.record;
        data.put(&[request.0, device.0, status.0, size])?;
        data.put(self.record.data)
    }
}

fn log_line(bytes: &[u8]) -> (Result<LogLine<'_>, DecodeError>, &[u8]) {
    let Some((&[a, b, c, d, dst, src], tail)) = bytes.split_first_chunk() else {
        let error = DecodeError { offset: 0, expected: Expected::Header, got: bytes.len() };
        return (Err(error), &[]);
    };
    let mut records = Records::new(tail);
    match records.next() {
        Some(Ok(record)) => {
            let time_s = u32::from_le_bytes([a, b, c, d]);
            (Ok(LogLine { time_s, dst, src, record }), records.rest())
        }
        Some(Err(error)) => (Err(error), &[]),
        None => (Err(DecodeError { offset: 6, expected: Expected::Header, got: 0 }), &[]),
    }
}

/// The record with which the controller lets a console send one frame.
pub const ACCESS_GRANTED: Record<'static> = Record {
    request: RequestId::ACCESS_GRANTED,
    device: SubsystemId::GENERAL,
    status: Status::OK,
    data: &[],
};

#[cfg(test)]
mod tests {
    use super::*;

    /// §B/1
    #[test]
    fn network_status_bits() {
        let mut status = NetworkStatus::default();
        for address in [1, 8, 9, 128, 254, 255] {
            status.set(address, true);
        }
        status.set(9, false);
        status.set(0, true);
        assert_eq!(status.0[0], 0x81);
        assert_eq!(status.0[31], 0x60);
        assert!(status.iter().eq([1, 8, 128, 254, 255]));
    }

    #[test]
    fn log_lines() {
        let bytes = [
            5, 0, 2, 0, 0x78, 0x56, 0x34, 0x12, 1, 129, 0x4D, 0x0D, 0, 2, 0xA0, 0xAB, 1, 0, 0, 0,
            2, 130, 0x46, 0x5D, 0, 0,
        ];
        let log = Log::decode(&bytes).unwrap();
        assert_eq!((log.first, log.count), (5, 2));
        let lines: std::vec::Vec<_> = log.iter().map(|line| line.unwrap()).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!((lines[0].time_s, lines[0].dst, lines[0].src), (0x1234_5678, 1, 129));
        assert_eq!(lines[0].record.data, [0xA0, 0xAB]);
        assert_eq!(lines[1].record.request, RequestId::STOP);
        assert!(Log::decode(&bytes[..25]).is_err());
    }
}
