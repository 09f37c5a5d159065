//! Splits the bytes of a line into pieces that each end with a frame.

use lafet_proto::link::{Decoder, WIRE_MAX};

/// Noise without a frame is returned once there is this much of it, bytes.
const NOISE_MAX: usize = 2 * WIRE_MAX;

/// Splits a stream after each frame. No byte is lost: noise is returned with the frame after it.
#[derive(Debug, Default)]
pub struct Splitter {
    decoder: Box<Decoder>,
    kept: Vec<u8>,
}

impl Splitter {
    /// A splitter that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes bytes; returns the pieces that are now complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut pieces = Vec::new();
        let mut rest = bytes;
        while !rest.is_empty() {
            let (taken, frame) = self.decoder.push_slice(rest);
            let ended = frame.is_some();
            let (piece, tail) = rest.split_at(taken);
            self.kept.extend_from_slice(piece);
            rest = tail;
            if ended || self.kept.len() > NOISE_MAX {
                pieces.push(std::mem::take(&mut self.kept));
            }
        }
        pieces
    }

    /// The bytes after the last frame, when no more are expected.
    pub fn rest(&mut self) -> Option<Vec<u8>> {
        let rest = std::mem::take(&mut self.kept);
        (!rest.is_empty()).then_some(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::link::{Frame, encode};

    fn frame(payload: &[u8]) -> Vec<u8> {
        let mut out = [0; WIRE_MAX];
        let len = encode(&Frame { dst: 1, src: 129, payload }, &mut out).unwrap();
        out[..len].to_vec()
    }

    #[test]
    fn pieces_end_with_frames_however_the_stream_is_cut() {
        let (first, second) = (frame(&[0xC0, 0xDB, 1]), frame(&[]));
        let stream = [&first[..], &[1, 2, 3], &second, &[0xFF, 0xC0, 7]].concat();
        for chunk in 1..stream.len() {
            let mut splitter = Splitter::new();
            let pieces: Vec<_> = stream.chunks(chunk).flat_map(|c| splitter.push(c)).collect();
            assert_eq!(pieces, [first.clone(), [&[1, 2, 3], &second[..]].concat()], "{chunk}");
            assert_eq!(splitter.rest(), Some(vec![0xFF, 0xC0, 7]));
            assert_eq!(splitter.rest(), None);
        }
    }

    #[test]
    fn noise_is_bounded_and_kept() {
        let mut splitter = Splitter::new();
        let noise = vec![0x55; 3 * NOISE_MAX];
        let mut pieces: Vec<_> = noise.chunks(100).flat_map(|c| splitter.push(c)).collect();
        pieces.extend(splitter.rest());
        assert!(pieces.iter().all(|piece| piece.len() <= NOISE_MAX + 100));
        assert_eq!(pieces.concat(), noise);
    }
}
