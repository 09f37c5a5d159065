//! Link frames.

use lafet_proto::link::{self, BODY_MAX, Decoder, Frame};

use crate::{bytes, room};

/// Bytes on the wire that the greatest frame can need.
pub const LAFET_WIRE_MAX: usize = 1041;
const _: () = assert!(LAFET_WIRE_MAX == link::WIRE_MAX);
/// Payload that every monitor and client can take.
pub const LAFET_PAYLOAD_MAX: usize = 512;
const _: () = assert!(LAFET_PAYLOAD_MAX == link::PAYLOAD_MAX);

/// A frame received without errors. The payload lies in the decoder until more bytes are pushed.
#[repr(C)]
pub struct lafet_frame {
    /// Receiver.
    pub dst: u8,
    /// Sender.
    pub src: u8,
    /// Records; empty in a presence probe and its answer.
    pub payload: *const u8,
    /// Bytes of the payload.
    pub size: usize,
}

/// Finds frames in a stream of bytes.
#[repr(C)]
pub struct lafet_decoder {
    /// For lafet alone.
    pub opaque: [u64; 80],
}
const _: () = assert!(size_of::<lafet_decoder>() >= size_of::<Decoder<BODY_MAX>>());
const _: () = assert!(align_of::<lafet_decoder>() >= align_of::<Decoder<BODY_MAX>>());

/// Writes a frame as it goes on the wire. Returns its length, 0 if `out` is too short.
///
/// # Safety
/// As at the head of this library: `size` and `out_size` are those of `payload` and `out`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_frame_encode(
    dst: u8,
    src: u8,
    payload: *const u8,
    size: usize,
    out: *mut u8,
    out_size: usize,
) -> usize {
    // SAFETY: the caller's promise.
    let (payload, out) = unsafe { (bytes(payload, size), room(out, out_size)) };
    let (Some(payload), Some(out)) = (payload, out) else { return 0 };
    link::encode(&Frame { dst, src, payload }, out).unwrap_or(0)
}

/// Makes a decoder that waits for a frame.
///
/// # Safety
/// `decoder` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_decoder_init(decoder: *mut lafet_decoder) {
    if !decoder.is_null() {
        // SAFETY: large enough and aligned, as asserted above; not null.
        unsafe { decoder.cast::<Decoder>().write(Decoder::new()) }
    }
}

/// Takes bytes until one completes a frame; returns how many were taken. If there is a frame,
/// `*complete` becomes true and `frame` describes it. Call it again with the rest.
///
/// # Safety
/// The decoder was initialised; `size` is that of `data`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_decoder_push(
    decoder: *mut lafet_decoder,
    data: *const u8,
    size: usize,
    frame: *mut lafet_frame,
    complete: *mut bool,
) -> usize {
    // SAFETY: initialised by `lafet_decoder_init`, says the caller.
    let (decoder, data) = unsafe { (decoder.cast::<Decoder>().as_mut(), bytes(data, size)) };
    // SAFETY: null or writable, says the caller.
    let (frame, complete) = unsafe { (frame.as_mut(), complete.as_mut()) };
    let (Some(decoder), Some(data)) = (decoder, data) else { return 0 };
    let (Some(frame), Some(complete)) = (frame, complete) else { return 0 };
    let (taken, found) = decoder.push_slice(data);
    *complete = found.is_some();
    if let Some(Frame { dst, src, payload }) = found {
        *frame = lafet_frame { dst, src, payload: payload.as_ptr(), size: payload.len() };
    }
    taken
}
