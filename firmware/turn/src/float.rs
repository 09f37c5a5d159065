//! Product and sum of two numbers of single precision, in half of the flash that the compiler's take and in less time.
//! In whole numbers, so that the host can hold them against its own.

const SIGN: u32 = 1 << 31;
/// The exponent of what is no number, and of what is endless.
const LAST: u32 = 0xFF;
const ENDLESS: u32 = LAST << 23;
const NO_NUMBER: u32 = 0x7FC0_0000;

/// The bits of the product of two numbers of these bits, rounded to the nearest, halves to the even one. Below
/// 2⁻¹²⁶ a number is 0, be it a factor or the product before it is rounded.
#[inline(always)]
pub fn product(one: u32, other: u32) -> u32 {
    let sign = (one ^ other) & SIGN;
    let (first, second) = (one >> 23 & LAST, other >> 23 & LAST);
    if first == 0 || second == 0 || first == LAST || second == LAST {
        return sign | of_odd(one & !SIGN, other & !SIGN);
    }
    let wide = u64::from(one << 8 | SIGN) * u64::from(other << 8 | SIGN);
    let (mut high, mut low) = ((wide >> 32) as u32, wide as u32);
    let mut exponent = (first + second).wrapping_sub(127);
    if high & SIGN == 0 {
        high = high << 1 | low >> 31;
        low <<= 1;
        exponent = exponent.wrapping_sub(1);
    }
    // The leading one adds one to the exponent.
    let kept = (exponent << 23).wrapping_add(high >> 8);
    sign | rounded(exponent, kept, high << 24 | u32::from(low != 0))
}

/// The bits of their sum, in the same way.
#[inline(always)]
pub fn sum(one: u32, other: u32) -> u32 {
    let (more, less) = if one << 1 >= other << 1 { (one, other) } else { (other, one) };
    let (upper, lower) = (more >> 23 & LAST, less >> 23 & LAST);
    let sign = more & SIGN;
    let opposed = (more ^ less) & SIGN != 0;
    if upper == LAST {
        return if more << 1 > ENDLESS << 1 || lower == LAST && opposed { NO_NUMBER } else { more };
    }
    if lower == 0 {
        return if upper == 0 { more & less & SIGN } else { more };
    }
    // Seven bits below the last, and one above the leading one.
    let digits = |bits: u32| (bits << 8 | SIGN) >> 1;
    let (whole, apart) = (digits(less), upper - lower);
    // What is shifted out counts as one bit.
    let part = whole.checked_shr(apart).unwrap_or_default();
    let lost = part.checked_shl(apart).unwrap_or_default() != whole;
    let part = part | u32::from(lost);
    let sum = if opposed { digits(more) - part } else { digits(more) + part };
    if sum == 0 {
        return 0;
    }
    let shift = sum.leading_zeros();
    let (sum, exponent) = (sum << shift, upper.wrapping_sub(shift));
    sign | rounded(exponent, (exponent << 23).wrapping_add(sum >> 8), sum << 24)
}

/// What is kept of a number, whose exponent is one greater than this, rounded by the rest.
#[inline(always)]
fn rounded(exponent: u32, kept: u32, rest: u32) -> u32 {
    match exponent.cast_signed() {
        ..0 => 0,
        254.. => ENDLESS,
        // It may become endless by its rounding, with the same bits.
        _ => kept + u32::from(rest > SIGN || rest == SIGN && kept & 1 != 0),
    }
}

/// Where one of them is 0, endless or no number; without signs.
#[inline(never)]
fn of_odd(one: u32, other: u32) -> u32 {
    let (less, more) = if one < other { (one, other) } else { (other, one) };
    match () {
        () if more > ENDLESS || more == ENDLESS && less >> 23 == 0 => NO_NUMBER,
        () if more == ENDLESS => ENDLESS,
        () => 0,
    }
}
