//! Bytes written in hexadecimal, in the forms found in captures and logs.

/// Parses hexadecimal text piece by piece: pairs of digits with or without blanks, `0x`, commas,
/// colons and dashes between them; `#` starts a comment.
#[derive(Debug, Default)]
pub struct Unhex {
    high: Option<u8>,
    comment: bool,
    offset: u64,
}

impl Unhex {
    /// Whether a text starts like hexadecimal.
    pub fn looks_like(text: &[u8]) -> bool {
        let mut unhex = Self::default();
        let mut bytes = Vec::new();
        unhex.feed(text, &mut bytes).is_ok() && !bytes.is_empty()
    }

    /// Appends the bytes of a piece; the error is the offset of the first invalid character.
    pub fn feed(&mut self, text: &[u8], bytes: &mut Vec<u8>) -> Result<(), u64> {
        for byte in text {
            self.offset += 1;
            if self.comment {
                self.comment = *byte != b'\n';
                continue;
            }
            match (*byte, self.high) {
                (b'x' | b'X', Some(0)) => self.high = None,
                (b'#', None) => self.comment = true,
                (b' ' | b'\t' | b'\r' | b'\n' | b',' | b':' | b'-' | b';', None) => {}
                (digit, high) => {
                    let value = char::from(digit).to_digit(16).ok_or(self.offset)? as u8;
                    match high {
                        None => self.high = Some(value),
                        Some(high) => {
                            bytes.push(high << 4 | value);
                            self.high = None;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Ends the text; an unpaired digit is an error.
    pub fn finish(&self) -> Result<(), u64> {
        if self.high.is_none() { Ok(()) } else { Err(self.offset) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unhex(text: &str) -> Result<Vec<u8>, u64> {
        let mut bytes = Vec::new();
        let mut unhex = Unhex::default();
        // One byte at a time: every possible cut.
        for piece in text.as_bytes().chunks(1) {
            unhex.feed(piece, &mut bytes)?;
        }
        unhex.finish().map(|()| bytes)
    }

    #[test]
    fn reads_what_people_write() {
        for text in
            ["ffc001", "FF C0 01", "0xff,0xC0,0x01", "ff:c0-01\r\n", "ff c0 # comment x\n01"]
        {
            assert_eq!(unhex(text), Ok(vec![0xFF, 0xC0, 1]), "{text}");
        }
        assert_eq!(unhex("ff c"), Err(4));
        assert_eq!(unhex("ff cg"), Err(5));
        assert_eq!(unhex("f f"), Err(2));
        assert_eq!(unhex("1x00"), Err(2));
    }

    #[test]
    fn binary_is_no_text() {
        assert!(!Unhex::looks_like(&[0xFF, 0xC0, 0x01]));
        assert!(!Unhex::looks_like(b"  \n"));
        assert!(Unhex::looks_like(b"ff c0 01"));
    }
}
