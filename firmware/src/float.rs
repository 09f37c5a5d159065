//! Comparing numbers of single precision in 100 bytes of flash: those that come with the compiler take
//! 330, as each is independent. And their product and sum.

use core::arch::naked_asm;
use lafet_turn::float::{product, sum};

/// First × second.
#[unsafe(no_mangle)]
extern "C" fn __aeabi_fmul(one: f32, other: f32) -> f32 {
    f32::from_bits(product(one.to_bits(), other.to_bits()))
}

/// First + second.
#[unsafe(no_mangle)]
extern "C" fn __aeabi_fadd(one: f32, other: f32) -> f32 {
    f32::from_bits(sum(one.to_bits(), other.to_bits()))
}

/// First − second.
#[unsafe(no_mangle)]
extern "C" fn __aeabi_fsub(one: f32, other: f32) -> f32 {
    __aeabi_fadd(one, f32::from_bits(other.to_bits() ^ 1 << 31))
}

/// Whether `r0` < `r1` (with `r3` = 1) or `r0` ≤ `r1` (with 0), and never where one is no number. A float
/// is sign and magnitude: made a two's complement, whole numbers of that order.
#[unsafe(naked)]
unsafe extern "C" fn compare() {
    naked_asm!(
        "lsl r2, r0, #1",
        "cmp r2, #0xFF000000",
        "bhi 1f",
        "lsl r2, r1, #1",
        "cmp r2, #0xFF000000",
        "bhi 1f",
        "cmp r0, #0",
        "it mi",
        "rsbmi r0, r0, #0x80000000",
        "cmp r1, #0",
        "it mi",
        "rsbmi r1, r1, #0x80000000",
        "add r0, r3",
        "cmp r0, r1",
        "bgt 1f",
        "movs r0, #1",
        "bx lr",
        "1: movs r0, #0",
        "bx lr",
    )
}

/// First < second.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_fcmplt(one: f32, other: f32) -> i32 {
    naked_asm!("movs r3, #1", "b {compare}", compare = sym compare)
}

/// First ≤ second.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_fcmple(one: f32, other: f32) -> i32 {
    naked_asm!("movs r3, #0", "b {compare}", compare = sym compare)
}

/// First > second.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_fcmpgt(one: f32, other: f32) -> i32 {
    naked_asm!("mov r2, r0", "mov r0, r1", "mov r1, r2", "b {less}", less = sym __aeabi_fcmplt)
}

/// First ≥ second.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_fcmpge(one: f32, other: f32) -> i32 {
    naked_asm!("mov r2, r0", "mov r0, r1", "mov r1, r2", "b {most}", most = sym __aeabi_fcmple)
}

/// One is no number.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_fcmpun(one: f32, other: f32) -> i32 {
    naked_asm!(
        "lsls r0, r0, #1",
        "lsls r1, r1, #1",
        "cmp r0, r1",
        "it lo",
        "movlo r0, r1",
        "cmp r0, #0xFF000000",
        "ite hi",
        "movhi r0, #1",
        "movls r0, #0",
        "bx lr",
    )
}
