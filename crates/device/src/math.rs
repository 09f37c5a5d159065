//! What the drives need of mathematics (ours), in little flash.

/// Square root of a whole number, rounded down.
pub(crate) const fn isqrt(number: u32) -> u32 {
    let (mut rest, mut root, mut bit) = (number, 0, 1 << 30);
    while bit > 0 {
        let more = root + bit;
        root >>= 1;
        if rest >= more {
            rest -= more;
            root += bit;
        }
        bit >>= 2;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots() {
        for number in (0..u32::MAX - 9973).step_by(9973) {
            assert_eq!(isqrt(number), number.isqrt());
        }
        assert_eq!((isqrt(u32::MAX), isqrt(15), isqrt(16)), (65_535, 3, 4));
    }
}
