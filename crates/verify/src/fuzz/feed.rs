//! An input, consumed piece by piece.

/// The rest of an input. Past its end everything is 0.
pub struct Feed<'a>(&'a [u8]);

impl<'a> Feed<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn u8(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes([self.u8(), self.u8()])
    }

    pub fn u32(&mut self) -> u32 {
        u32::from(self.u16()) | u32::from(self.u16()) << 16
    }

    /// A number in 0..count.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.u8()) % count
    }

    pub fn chance(&mut self) -> bool {
        self.u8() & 1 != 0
    }

    /// A number; small ones and extremes are more frequent.
    pub fn number(&mut self) -> i32 {
        match self.u8() {
            0 => i32::MIN,
            1 => i32::MAX,
            2 => self.u32() as i32,
            3..=127 => i32::from(self.u16() as i16),
            small => i32::from(small) - 192,
        }
    }

    /// The next `len` bytes, or what is left.
    pub fn take(&mut self, len: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(len.min(self.0.len()));
        self.0 = rest;
        taken
    }
}
