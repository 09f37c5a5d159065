//! Decodes the few Cortex-M3 instructions that affect the stack or the control flow.

/// The effect of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Not relevant.
    None,
    /// Takes this many bytes of the stack.
    Takes(u32),
    /// Jumps to an address.
    Goes(u32),
    /// Calls an address.
    Calls(u32),
    /// Calls or jumps to the address in a register.
    GoesByRegister,
    /// Moves the stack pointer by an unknown amount.
    Unbounded,
}

const SP: u16 = 13;
const PC: u16 = 15;
const LR: u16 = 14;
/// The frame pointer, from which the stack pointer is restored.
const FP: u16 = 7;

/// Whether an instruction with this first half has a second half.
pub const fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// Decodes a two-byte instruction at this address.
pub fn narrow(at: u32, code: u16) -> Effect {
    let (target, source) = (code & 7 | code >> 4 & 8, code >> 3 & 15);
    match code >> 8 {
        // PUSH; bit 8 is the link register.
        0xB4 | 0xB5 => Effect::Takes(4 * (code & 0x1FF).count_ones()),
        // SUB SP; ADD SP has bit 7 clear.
        0xB0 if code & 0x80 != 0 => Effect::Takes(4 * u32::from(code & 0x7F)),
        // BX, BLX.
        0x47 if source != LR => Effect::GoesByRegister,
        // ADD and MOV of any two registers.
        0x44 | 0x46 if target == PC => Effect::GoesByRegister,
        0x44 | 0x46 if target == SP => Effect::Unbounded,
        // B<cond>; 0xDE and 0xDF are UDF and SVC.
        0xD0..=0xDD => Effect::Goes(offset(at, extend(u32::from(code & 0xFF) << 1, 9))),
        0xE0..=0xE7 => Effect::Goes(offset(at, extend(u32::from(code & 0x7FF) << 1, 12))),
        _ => Effect::None,
    }
}

/// Decodes a four-byte instruction at this address.
pub fn wide(at: u32, first: u16, second: u16) -> Effect {
    let (base, target) = (first & 15, second >> 8 & 15);
    match first {
        // STMDB SP!
        0xE92D => Effect::Takes(4 * second.count_ones()),
        // STRD [SP, #-n]!
        0xE96D => Effect::Takes(4 * u32::from(second & 0xFF)),
        // STR [SP, #-n]!
        0xF84D if target == 0b1101 => Effect::Takes(u32::from(second & 0xFF)),
        // LDR to PC or SP, of one word; POP {PC} is the return.
        _ if matches!(first & 0xFFF0, 0xF850 | 0xF8D0) => match second >> 12 {
            PC if base != SP => Effect::GoesByRegister,
            SP => Effect::Unbounded,
            _ => Effect::None,
        },
        _ if first >> 11 == 0b11110 && second & 0x8000 != 0 => branch(at, first, second),
        // SUB of a constant from SP, modified or plain.
        0xF1AD | 0xF5AD if target == SP => Effect::Takes(constant(first, second)),
        0xF2AD | 0xF6AD if target == SP => Effect::Takes(plain(first, second)),
        // ADD to SP, and SP computed from the frame pointer, release stack.
        0xF10D | 0xF50D | 0xF20D | 0xF60D => Effect::None,
        _ if first >> 11 == 0b11110 && target == SP && base != FP => Effect::Unbounded,
        _ if first >> 9 == 0b111_0101 && target == SP => Effect::Unbounded,
        _ => Effect::None,
    }
}

/// Decodes `B`, `B<cond>` and `BL`; other instructions of this form are hints, barriers and special
/// registers.
fn branch(at: u32, first: u16, second: u16) -> Effect {
    let bit = |half: u16, place: u32| u32::from(half >> place & 1);
    let sign = bit(first, 10);
    let low = u32::from(second & 0x7FF) << 1;
    if second & 0x1000 != 0 {
        let [upper, lower] = [bit(second, 13), bit(second, 11)].map(|j| 1 ^ j ^ sign);
        let high = sign << 24 | upper << 23 | lower << 22 | u32::from(first & 0x3FF) << 12;
        let to = offset(at, extend(high | low, 25));
        return if bit(second, 14) == 1 { Effect::Calls(to) } else { Effect::Goes(to) };
    }
    if first >> 6 & 0b1110 == 0b1110 {
        return Effect::None;
    }
    let high = sign << 20 | bit(second, 11) << 19 | bit(second, 13) << 18;
    let high = high | u32::from(first & 0x3F) << 12;
    Effect::Goes(offset(at, extend(high | low, 21)))
}

/// Target of a branch, relative to the program counter.
fn offset(at: u32, by: i32) -> u32 {
    at.wrapping_add(4).wrapping_add_signed(by)
}

/// Sign-extends a number of this many bits.
fn extend(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)).cast_signed() >> (32 - bits)
}

/// Twelve plain bits.
fn plain(first: u16, second: u16) -> u32 {
    u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xFF)
}

/// Twelve bits that encode a rotated or repeated byte.
fn constant(first: u16, second: u16) -> u32 {
    let bits = plain(first, second);
    let byte = bits & 0xFF;
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (byte | 0x80).rotate_right(bits >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected results as disassembled by `objdump`.
    #[test]
    fn what_takes_the_stack() {
        assert_eq!(narrow(0, 0xB5F0), Effect::Takes(20), "push {{r4-r7, lr}}");
        assert_eq!(narrow(0, 0xB40F), Effect::Takes(16), "push {{r0-r3}}");
        assert_eq!(narrow(0, 0xB09E), Effect::Takes(120), "sub sp, #120");
        assert_eq!(narrow(0, 0xB01E), Effect::None, "add sp, #120");
        assert_eq!(narrow(0, 0xBDF0), Effect::None, "pop {{r4-r7, pc}}");
        assert_eq!(wide(0, 0xE92D, 0x0B00), Effect::Takes(12), "stmdb sp!, {{r8, r9, fp}}");
        assert_eq!(wide(0, 0xF84D, 0xBD04), Effect::Takes(4), "str.w fp, [sp, #-4]!");
        assert_eq!(wide(0, 0xF85D, 0xBB04), Effect::None, "ldr.w fp, [sp], #4");
        assert_eq!(wide(0, 0xF5AD, 0x7D36), Effect::Takes(728), "sub.w sp, sp, #728");
        assert_eq!(wide(0, 0xF6AD, 0x3D1C), Effect::Takes(0xB1C), "subw sp, sp, #2844");
        assert_eq!(wide(0, 0xF50D, 0x7D36), Effect::None, "add.w sp, sp, #728");
        assert_eq!(wide(0, 0xF1A7, 0x0D18), Effect::None, "sub.w sp, r7, #24");
        assert_eq!(narrow(0, 0x4685), Effect::Unbounded, "mov sp, r0");
        assert_eq!(wide(0, 0xEBAD, 0x0D00), Effect::Unbounded, "sub.w sp, sp, r0");
    }

    #[test]
    fn where_it_goes() {
        assert_eq!(wide(0x112, 0xF002, 0xFD27), Effect::Calls(0x2B64), "bl 2b64");
        assert_eq!(wide(0x1000, 0xF7FF, 0xFFFE), Effect::Calls(0x1000), "bl 1000");
        assert_eq!(wide(0x1000, 0xF7FF, 0xBFFE), Effect::Goes(0x1000), "b.w 1000");
        assert_eq!(wide(0x1000, 0xF000, 0xB802), Effect::Goes(0x1008), "b.w 1008");
        assert_eq!(wide(0x1000, 0xF040, 0x8002), Effect::Goes(0x1008), "bne.w 1008");
        assert_eq!(wide(0x1000, 0xF3BF, 0x8F4F), Effect::None, "dsb sy");
        assert_eq!(narrow(0x1000, 0xE7FE), Effect::Goes(0x1000), "b.n 1000");
        assert_eq!(narrow(0x1000, 0xD001), Effect::Goes(0x1006), "beq.n 1006");
        assert_eq!(narrow(0, 0xDEFE), Effect::None, "udf");
        assert_eq!(narrow(0, 0x4770), Effect::None, "bx lr");
        assert_eq!(narrow(0, 0x47A0), Effect::GoesByRegister, "blx r4");
        assert_eq!(narrow(0, 0x4710), Effect::GoesByRegister, "bx r2");
        assert_eq!(wide(0, 0xF8D0, 0xF004), Effect::GoesByRegister, "ldr.w pc, [r0, #4]");
    }
}
