//! §L/2 CRC-16/MODBUS and §L/7 CRC-32C, computed piece by piece. With feature `crc-slice16`, for
//! hosts, the tables take 24 KiB; without it, for chips, 96 bytes, and a byte takes 11
//! instructions.

#[cfg(feature = "crc-slice16")]
mod engine {
    use crc::{CRC_16_MODBUS, CRC_32_ISCSI, Crc, Digest, Table};

    static CRC16: Crc<u16, Table<16>> = Crc::<u16, Table<16>>::new(&CRC_16_MODBUS);
    static CRC32C: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);

    pub type State16 = Digest<'static, u16, Table<16>>;
    pub type State32 = Digest<'static, u32, Table<16>>;

    #[inline]
    pub fn start16() -> State16 {
        CRC16.digest()
    }

    #[inline]
    pub fn start32() -> State32 {
        CRC32C.digest()
    }

    #[inline]
    pub fn update16(state: &mut State16, bytes: &[u8]) {
        state.update(bytes);
    }

    #[inline]
    pub fn update32(state: &mut State32, bytes: &[u8]) {
        state.update(bytes);
    }

    #[inline]
    pub fn finish16(state: State16) -> u16 {
        state.finalize()
    }

    #[inline]
    pub fn finish32(state: State32) -> u32 {
        state.finalize()
    }
}

#[cfg(not(feature = "crc-slice16"))]
mod engine {
    pub type State16 = u32;
    pub type State32 = u32;

    /// The change of the checksum for each value of four bits.
    const fn table(polynomial: u32) -> [u32; 16] {
        let mut table = [0; 16];
        let mut rest: &mut [u32] = &mut table;
        let mut half = 0;
        while let [entry, tail @ ..] = rest {
            *entry = half;
            let mut bit = 0;
            while bit < 4 {
                *entry = *entry >> 1 ^ if *entry & 1 != 0 { polynomial } else { 0 };
                bit += 1;
            }
            half += 1;
            rest = tail;
        }
        table
    }

    /// The polynomials with their bits reversed.
    static CRC16: [u32; 16] = table(0xA001);
    static CRC32C: [u32; 16] = table(0x82F6_3B78);

    fn update(table: &[u32; 16], state: &mut u32, bytes: &[u8]) {
        // The index is always inside the table.
        let step = |crc: u32| table.get(crc as usize % 16).copied().unwrap_or_default();
        let half = |crc: u32| crc >> 4 ^ step(crc);
        for byte in bytes {
            *state = half(half(*state ^ u32::from(*byte)));
        }
    }

    pub const fn start16() -> u32 {
        0xFFFF
    }

    pub const fn start32() -> u32 {
        !0
    }

    pub fn update16(state: &mut u32, bytes: &[u8]) {
        update(&CRC16, state, bytes);
    }

    pub fn update32(state: &mut u32, bytes: &[u8]) {
        update(&CRC32C, state, bytes);
    }

    pub const fn finish16(state: u32) -> u16 {
        state as u16
    }

    pub const fn finish32(state: u32) -> u32 {
        !state
    }
}

/// CRC-16/MODBUS: reflected 0x8005, start 0xFFFF.
pub struct Crc16(engine::State16);

impl Crc16 {
    /// The checksum of no bytes.
    #[inline]
    #[expect(clippy::new_without_default, reason = "a checksum by default has no use")]
    pub fn new() -> Self {
        Self(engine::start16())
    }

    /// Continues the checksum over these bytes.
    #[inline]
    pub fn update(&mut self, bytes: &[u8]) {
        engine::update16(&mut self.0, bytes);
    }

    /// The checksum of all bytes so far.
    #[inline]
    pub fn finish(self) -> u16 {
        engine::finish16(self.0)
    }
}

/// CRC-32C: reflected 0x1EDC6F41, start and end inverted.
pub struct Crc32c(engine::State32);

impl Crc32c {
    /// The checksum of no bytes.
    #[inline]
    #[expect(clippy::new_without_default, reason = "a checksum by default has no use")]
    pub fn new() -> Self {
        Self(engine::start32())
    }

    /// Continues the checksum over these bytes.
    #[inline]
    pub fn update(&mut self, bytes: &[u8]) {
        engine::update32(&mut self.0, bytes);
    }

    /// The checksum of all bytes so far.
    #[inline]
    pub fn finish(self) -> u32 {
        engine::finish32(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check values of the CRC catalogue, at once and in pieces.
    #[test]
    fn check_values() {
        let digits = b"123456789";
        for cut in 0..=digits.len() {
            let (head, tail) = digits.split_at(cut);
            let (mut crc16, mut crc32c) = (Crc16::new(), Crc32c::new());
            for part in [head, tail] {
                crc16.update(part);
                crc32c.update(part);
            }
            assert_eq!((crc16.finish(), crc32c.finish()), (0x4B37, 0xE306_9283));
        }
    }

    #[test]
    fn every_byte() {
        use crc::{CRC_16_MODBUS, CRC_32_ISCSI, Crc};
        let bytes: std::vec::Vec<u8> = (0..=255).chain(0..=255).collect();
        let (mut crc16, mut crc32c) = (Crc16::new(), Crc32c::new());
        crc16.update(&bytes);
        crc32c.update(&bytes);
        assert_eq!(crc16.finish(), Crc::<u16>::new(&CRC_16_MODBUS).checksum(&bytes));
        assert_eq!(crc32c.finish(), Crc::<u32>::new(&CRC_32_ISCSI).checksum(&bytes));
    }
}
