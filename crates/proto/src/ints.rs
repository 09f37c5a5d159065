//! Arrays in records: borrowed from the received bytes, or from the caller who encodes them.

/// An array of i32 (§3.4, §3.5): little-endian bytes of a record, or integers to be encoded.
#[derive(Clone, Copy, Debug)]
pub enum Ints<'a> {
    /// Bytes of a record, four for each value.
    Wire(&'a [u8]),
    /// Values to encode.
    Values(&'a [i32]),
}

impl<'a> Ints<'a> {
    /// Number of whole values.
    pub const fn len(self) -> usize {
        match self {
            Self::Wire(bytes) => bytes.len() / 4,
            Self::Values(values) => values.len(),
        }
    }

    /// Whether there is no value.
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The value at this index, from 0.
    pub fn get(self, index: usize) -> Option<i32> {
        match self {
            Self::Wire(bytes) => bytes.as_chunks().0.get(index).map(|b| i32::from_le_bytes(*b)),
            Self::Values(values) => values.get(index).copied(),
        }
    }

    /// The values in order.
    pub fn iter(self) -> impl Iterator<Item = i32> + Clone + 'a {
        (0..self.len()).map_while(move |index| self.get(index))
    }
}

impl PartialEq for Ints<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Eq for Ints<'_> {}

/// An array of i8 as its wire bytes (§3.6, §3.14: corrections in degrees).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    /// The values in order.
    pub fn iter(self) -> impl Iterator<Item = i8> + Clone + 'a {
        self.0.iter().map(|byte| i8::from_le_bytes([*byte]))
    }
}
