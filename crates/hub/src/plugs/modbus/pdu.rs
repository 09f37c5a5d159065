//! Requests of a master, and answers to them: the part of a frame that both framings share.
//!
//! Ours, as `rmodbus` takes the length of a write from the frame without looking whether it is there, answers
//! unknown functions on a serial line before it has looked at the checksum, and refuses the longest
//! legal writes. What is not exactly a request of the standard is refused by its exception.

/// Most registers of one reading.
pub const READ_MAX: u16 = 125;
/// Most registers of one write.
pub const WRITE_MAX: u16 = 123;

/// Function that reads holding registers.
pub const READ_HOLDING: u8 = 3;
/// Function that reads input registers: the same ones here.
pub const READ_INPUT: u8 = 4;
/// Function that writes a register.
pub const WRITE_ONE: u8 = 6;
/// Function that writes registers.
pub const WRITE_MANY: u8 = 16;

/// Why a request is not carried out, as the standard has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exception {
    /// The function is not supported.
    Function,
    /// There are no such registers, or the master may not use them.
    Address,
    /// The request contradicts itself, or writes a part of a block.
    Value,
    /// Too many requests: to be sent again later.
    Busy,
    /// There is no such unit here.
    NoPath,
}

impl Exception {
    /// The number on the wire.
    pub const fn code(self) -> u8 {
        match self {
            Self::Function => 1,
            Self::Address => 2,
            Self::Value => 3,
            Self::Busy => 6,
            Self::NoPath => 10,
        }
    }
}

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Function 3 or 4.
    Read {
        /// Address of the first register, from 0.
        first: u16,
        /// How many, 1…125.
        count: u16,
    },
    /// Function 6 or 16.
    Write {
        /// Address of the first register, from 0.
        first: u16,
        /// Their new values, 1…123.
        words: Vec<u16>,
    },
}

/// Reads a request: the function and what follows it.
///
/// # Errors
///
/// The exception that answers it.
pub fn parse(pdu: &[u8]) -> Result<Ask, Exception> {
    match *pdu {
        [READ_HOLDING | READ_INPUT, a, b, c, d] => {
            let (first, count) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
            if !(1..=READ_MAX).contains(&count) {
                return Err(Exception::Value);
            }
            Ok(Ask::Read { first, count })
        }
        [WRITE_ONE, a, b, c, d] => {
            let (first, word) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
            Ok(Ask::Write { first, words: vec![word] })
        }
        [WRITE_MANY, a, b, c, d, len, ref data @ ..] => {
            let (first, count) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
            let whole = usize::from(len) == data.len() && data.len() == 2 * usize::from(count);
            if !whole || !(1..=WRITE_MAX).contains(&count) {
                return Err(Exception::Value);
            }
            let words = data.chunks_exact(2).filter_map(|it| <[u8; 2]>::try_from(it).ok());
            Ok(Ask::Write { first, words: words.map(u16::from_be_bytes).collect() })
        }
        [READ_HOLDING | READ_INPUT | WRITE_ONE | WRITE_MANY, ..] => Err(Exception::Value),
        _ => Err(Exception::Function),
    }
}

/// The answer to a reading.
pub fn read_answer(function: u8, words: &[u16]) -> Vec<u8> {
    let len = u8::try_from(2 * words.len()).unwrap_or(0);
    let mut pdu = vec![function, len];
    pdu.extend(words.iter().flat_map(|it| it.to_be_bytes()));
    pdu
}

/// The answer to a write: its function, address, and value or count.
pub fn write_answer(pdu: &[u8]) -> Vec<u8> {
    pdu.get(..5).unwrap_or(pdu).to_vec()
}

/// The answer that refuses.
pub fn refusal(pdu: &[u8], why: Exception) -> Vec<u8> {
    vec![pdu.first().copied().unwrap_or_default() | 1 << 7, why.code()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_of_the_standard_are_read() {
        assert_eq!(parse(&[3, 0, 0x6B, 0, 3]), Ok(Ask::Read { first: 0x6B, count: 3 }));
        assert_eq!(parse(&[4, 0, 8, 0, 1]), Ok(Ask::Read { first: 8, count: 1 }));
        assert_eq!(parse(&[6, 0, 1, 0, 3]), Ok(Ask::Write { first: 1, words: vec![3] }));
        let many = parse(&[16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2]);
        assert_eq!(many, Ok(Ask::Write { first: 1, words: vec![10, 258] }));
        let mut longest = vec![16, 0, 0, 0, 123, 246];
        longest.extend([0; 246]);
        assert!(matches!(parse(&longest), Ok(Ask::Write { words, .. }) if words.len() == 123));
    }

    #[test]
    fn what_contradicts_itself_is_refused() {
        for pdu in [
            &[3, 0, 0, 0, 0][..],
            &[3, 0, 0, 0, 126],
            &[3, 0, 0, 0],
            &[3, 0, 0, 0, 1, 0],
            &[6, 0, 0, 0],
            &[16, 0, 0, 0, 2, 2, 0, 1],
            &[16, 0, 0, 0, 1, 4, 0, 1, 0, 2],
            &[16, 0, 0, 0, 1, 250, 0, 1],
            &[16, 0, 0, 0, 0, 0],
            &[16, 0, 0],
        ] {
            assert_eq!(parse(pdu), Err(Exception::Value), "{pdu:?}");
        }
        for pdu in [&[][..], &[1, 0, 0, 0, 1], &[5, 0, 0, 0xFF, 0], &[43, 14, 1, 0], &[0x83, 2]] {
            assert_eq!(parse(pdu), Err(Exception::Function), "{pdu:?}");
        }
    }

    #[test]
    fn answers_are_as_the_standard_has_them() {
        assert_eq!(read_answer(3, &[555, 0, 100]), [3, 6, 2, 43, 0, 0, 0, 100]);
        assert_eq!(write_answer(&[16, 0, 1, 0, 2, 4, 0, 10, 1, 2]), [16, 0, 1, 0, 2]);
        assert_eq!(refusal(&[3, 0, 0], Exception::Address), [0x83, 2]);
        assert_eq!(refusal(&[], Exception::Function), [0x80, 1]);
    }
}
