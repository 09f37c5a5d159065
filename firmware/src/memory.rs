//! Copying and filling of memory in 200 bytes of flash: those that come with the compiler are unrolled
//! and take 3.5 KiB. By words where both sides are aligned, as nearly everything here is.

use core::arch::naked_asm;

/// Copies from the first byte to the last.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn memcpy(to: *mut u8, from: *const u8, len: usize) -> *mut u8 {
    naked_asm!(
        "mov r12, r0",
        "orr r3, r0, r1",
        "lsls r3, r3, #30",
        "bne 2f",
        "1: subs r2, #4",
        "itt hs",
        "ldrhs r3, [r1], #4",
        "strhs r3, [r12], #4",
        "bhi 1b",
        "it lo",
        "addlo r2, #4",
        "2: subs r2, #1",
        "itt hs",
        "ldrbhs r3, [r1], #1",
        "strbhs r3, [r12], #1",
        "bhi 2b",
        "bx lr",
    )
}

/// Copies from whichever end does not overwrite what is still to be read.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn memmove(to: *mut u8, from: *const u8, len: usize) -> *mut u8 {
    naked_asm!(
        "subs r3, r0, r1",
        "cmp r3, r2",
        "bhs {memcpy}",
        "1: subs r2, #1",
        "itt hs",
        "ldrbhs r3, [r1, r2]",
        "strbhs r3, [r0, r2]",
        "bhi 1b",
        "bx lr",
        memcpy = sym memcpy,
    )
}

/// The difference of the first bytes that differ.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(one: *const u8, other: *const u8, len: usize) -> i32 {
    naked_asm!(
        "mov r12, r0",
        "1: subs r2, #1",
        "blo 2f",
        "ldrb r0, [r12], #1",
        "ldrb r3, [r1], #1",
        "subs r0, r0, r3",
        "beq 1b",
        "bx lr",
        "2: movs r0, #0",
        "bx lr",
    )
}

/// Fills.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn memset(to: *mut u8, byte: i32, len: usize) -> *mut u8 {
    naked_asm!(
        "mov r12, r0",
        "lsls r3, r0, #30",
        "bne 2f",
        "uxtb r1, r1",
        "orr r1, r1, r1, lsl #8",
        "orr r1, r1, r1, lsl #16",
        "1: subs r2, #4",
        "it hs",
        "strhs r1, [r12], #4",
        "bhi 1b",
        "it lo",
        "addlo r2, #4",
        "2: subs r2, #1",
        "it hs",
        "strbhs r1, [r12], #1",
        "bhi 2b",
        "bx lr",
    )
}

/// The names under which the compiler asks for the same.
macro_rules! under {
    ($($name:ident = $of:ident;)+) => {
        $(
            #[unsafe(naked)]
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $name() {
                naked_asm!("b {of}", of = sym $of)
            }
        )+
    };
}

under! {
    __aeabi_memcpy = memcpy;
    __aeabi_memcpy4 = memcpy;
    __aeabi_memcpy8 = memcpy;
    __aeabi_memmove = memmove;
    __aeabi_memmove4 = memmove;
    __aeabi_memmove8 = memmove;
    __aeabi_memset = fill;
    __aeabi_memset4 = fill;
    __aeabi_memset8 = fill;
    __aeabi_memclr = clear;
    __aeabi_memclr4 = clear;
    __aeabi_memclr8 = clear;
}

/// `memset` with length and byte in the other order.
#[unsafe(naked)]
unsafe extern "C" fn fill() {
    naked_asm!("mov r3, r1", "mov r1, r2", "mov r2, r3", "b {memset}", memset = sym memset)
}

#[unsafe(naked)]
unsafe extern "C" fn clear() {
    naked_asm!("mov r2, r1", "movs r1, #0", "b {memset}", memset = sym memset)
}
