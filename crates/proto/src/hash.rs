//! §1 «Общие сведения»: identifiers are hashes of names.

/// FNV-1a, 32 bits, over the ASCII name.
pub const fn fnv1a32(name: &str) -> u32 {
    let bytes = name.as_bytes();
    let mut hash: u32 = 0x811C_9DC5;
    let mut rest = bytes;
    while let [byte, tail @ ..] = rest {
        hash = (hash ^ *byte as u32).wrapping_mul(0x0100_0193);
        rest = tail;
    }
    hash
}

/// Conv8 of §1: the four bytes of the hash folded by xor. Subsystem and request ids.
pub const fn conv8(hash: u32) -> u8 {
    ((hash >> 24) ^ (hash >> 16) ^ (hash >> 8) ^ hash) as u8
}

/// The 16-bit fold: parameter ids and the keys of Lockout (§3.18, §3.21).
pub const fn fold16(hash: u32) -> u16 {
    ((hash >> 16) ^ hash) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §1, §3.21, §3.18: the identifiers printed in the document come out of the names.
    #[test]
    fn document_examples() {
        assert_eq!(conv8(fnv1a32("All")), 0x5D);
        assert_eq!(conv8(fnv1a32("Climatics")), 0x62);
        assert_eq!(fold16(fnv1a32("Hotbeds")), 0x23FE);
        assert_eq!(fold16(fnv1a32("Enable")), 0x2FFA);
        assert_eq!(fold16(fnv1a32("Disable")), 0x7353);
        assert_eq!(fold16(fnv1a32("FaultInfo")), 0xE8C1);
    }
}
