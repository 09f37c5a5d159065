//! The program's own product and sum of numbers of single precision are those of the host.

use lafet_turn::float::{product, sum};

const EXPONENT: u32 = 0xFF << 23;

/// Below 2⁻¹²⁶ a number is 0.
fn flushed(bits: u32) -> u32 {
    if bits & EXPONENT == 0 { bits & 1 << 31 } else { bits }
}

fn check(one: u32, other: u32) {
    let [x, y] = [one, other].map(|bits| f32::from_bits(flushed(bits)));
    for (what, wanted, got) in [("×", x * y, product(one, other)), ("+", x + y, sum(one, other))] {
        let (bits, is_none) = (wanted.to_bits(), f32::from_bits(got).is_nan());
        // A product that only its rounding brings to the least number is 0.
        let least = bits & !(1 << 31) == 1 << 23 && got & !(1 << 31) == 0;
        let same = if wanted.is_nan() { is_none } else { flushed(bits) == got || least };
        assert!(same, "{one:#x} {what} {other:#x}: {got:#x} instead of {bits:#x}");
    }
}

#[test]
fn product_and_sum_are_those_of_the_host() {
    let odd = [
        0,
        1,
        0x7F_FFFF,
        0x80_0000,
        0x3F7F_FFFF,
        0x3F80_0000,
        0x3F80_0001,
        0x4000_0000,
        0x4B7F_FFFF,
        0x4B80_0000,
        0x7F7F_FFFF,
        EXPONENT,
        0x7FC0_0000,
    ];
    let odd = odd.into_iter().flat_map(|bits| [bits, bits | 1 << 31]);
    for one in odd.clone() {
        odd.clone().for_each(|other| check(one, other));
    }
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 32) as u32, state as u32)
    };
    // Any bits; exponents near each other, where sums cancel and round; few digits, where halves are frequent.
    for (digits, exponents) in [(0x7F_FFFF, 256), (0x7F_FFFF, 56), (0x7F_FFFF, 5), (0x7F_F000, 30)]
    {
        for _ in 0..1_000_000 {
            let ((one, other), (first, second)) = (next(), next());
            let of = |bits: u32, exponent: u32| {
                let exponent = (127 + exponent % exponents).wrapping_sub(exponents / 2) & 0xFF;
                bits & (1 << 31 | digits) | exponent << 23
            };
            check(of(one, first), of(other, second));
        }
    }
}
