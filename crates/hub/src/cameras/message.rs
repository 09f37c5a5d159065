//! A picture as a viewer gets it: a binary message of the WebSocket. docs/cameras.md has its layout.

use bytes::{BufMut, Bytes, BytesMut};
use lafet_eyes::wire::Frame;

/// The layout that this is.
const LAYOUT: u8 = 1;
const KEY: u8 = 1;
const CAPTURED: u8 = 2;
const DAMAGED: u8 = 4;
/// The head without the name of the codec.
pub const HEAD: usize = 36;

/// The message of a picture with this number that came at this date, ms since 1970. `damaged`: packets were lost since
/// the last key frame.
pub fn of(frame: &Frame, number: u64, at_ms: u64, damaged: bool) -> Bytes {
    let codec = frame.key.as_ref().map_or("", |it| it.codec.as_str());
    let size = frame.key.as_ref().map_or((0, 0), |it| (it.width, it.height));
    let flag = |is: bool, flag: u8| if is { flag } else { 0 };
    let mut bytes = BytesMut::with_capacity(HEAD + codec.len() + frame.data.len());
    bytes.put_u8(LAYOUT);
    let captured = flag(frame.captured_us.is_some(), CAPTURED);
    bytes.put_u8(flag(frame.key.is_some(), KEY) | captured | flag(damaged, DAMAGED));
    bytes.put_u16(u16::try_from(codec.len()).unwrap_or(0));
    bytes.put_u32(low(number));
    bytes.put_i64(frame.shown_us);
    bytes.put_u64(at_ms);
    bytes.put_u64(frame.captured_us.unwrap_or(0));
    bytes.put_u16(size.0);
    bytes.put_u16(size.1);
    bytes.put_slice(codec.as_bytes());
    bytes.put_slice(&frame.data);
    bytes.freeze()
}

/// The part of a number that is in the message: viewers say it back.
pub const fn low(number: u64) -> u32 {
    (number & 0xFFFF_FFFF) as u32
}

#[cfg(test)]
mod tests {
    use lafet_eyes::wire::Picture;

    use super::*;

    /// Byte by byte: pages and other programs read it.
    #[test]
    fn the_layout_is_as_documented() {
        let picture = Picture { codec: "avc1.64001f".into(), width: 1280, height: 720 };
        let key = Frame {
            key: Some(picture),
            shown_us: -1,
            captured_us: Some(0x0102),
            lost: 0,
            data: Bytes::from_static(&[0, 0, 0, 1, 0x67]),
        };
        let bytes = of(&key, 0x1_0000_0007, 0x0304, true);
        let head = [
            &[1, 7, 0, 11][..],
            &[0, 0, 0, 7],
            &[0xFF; 8],
            &[0, 0, 0, 0, 0, 0, 3, 4],
            &[0, 0, 0, 0, 0, 0, 1, 2],
            &[5, 0, 2, 0xD0],
        ];
        assert_eq!(&bytes[..HEAD], head.concat());
        assert_eq!(&bytes[HEAD..], [&b"avc1.64001f"[..], &[0, 0, 0, 1, 0x67]].concat());
        let delta = of(&Frame { key: None, captured_us: None, ..key }, 8, 0, false);
        assert_eq!((&delta[..8], delta.len()), (&[1, 0, 0, 0, 0, 0, 0, 8][..], HEAD + 5));
    }
}
