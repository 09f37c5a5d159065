//! lafet for C: link frames, records, a client session and the device core, without an allocator.
//!
//! `include/lafet.h` is generated from this file and its modules (`cargo xtask bindings`). All
//! memory is the caller's: structures whose content is opaque are large enough for what is kept in
//! them, which the compiler checks here.
//!
//! Rules for all functions, on which the unsafe code here relies:
//! - a pointer is null or points to what its type says, for as long as the call lasts; null makes the
//!   function do nothing and return 0 or false;
//! - bytes given with a length are readable (or writable) for that length; null is no bytes with the
//!   length 0, and with another length makes the function do nothing and return 0 or false;
//! - a structure with opaque content was initialised by its `_init` function and has not been moved
//!   while something in it points into it: nothing in them does, so they may be copied;
//! - a structure is used by one thread at a time.
#![cfg_attr(target_os = "none", no_std)]
#![expect(non_camel_case_types, reason = "names of C")]

mod device;
mod image;
mod link;
mod record;
mod session;

/// The program is ended by the program that supplies this; nothing in lafet leads here.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// The bytes that C means by a pointer and a length; `None` where there are none of that length. To take them
/// for empty would make a presence probe of a Stop.
///
/// # Safety
/// `data` is null, or `len` bytes there are readable for `'a`.
unsafe fn bytes<'a>(data: *const u8, len: usize) -> Option<&'a [u8]> {
    if len == 0 {
        return Some(&[]);
    }
    if data.is_null() || isize::try_from(len).is_err() {
        return None;
    }
    // SAFETY: not null, no longer than anything is, and the caller says that the bytes are readable.
    Some(unsafe { core::slice::from_raw_parts(data, len) })
}

/// The room that C means by a pointer and a length; `None` where there is none of that length.
///
/// # Safety
/// `data` is null, or `len` bytes there are readable and writable for `'a`, and by no other code.
unsafe fn room<'a>(data: *mut u8, len: usize) -> Option<&'a mut [u8]> {
    if len == 0 {
        return Some(&mut []);
    }
    if data.is_null() || isize::try_from(len).is_err() {
        return None;
    }
    // SAFETY: not null, no longer than anything is, and the caller says that the bytes are writable.
    Some(unsafe { core::slice::from_raw_parts_mut(data, len) })
}
