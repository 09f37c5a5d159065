//! Words of a text, their numbers, and the buffer for data.

use super::error::{ParseError, Wanted};

/// A word and its offset in the text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token<'t> {
    pub(crate) text: &'t str,
    pub(crate) column: usize,
}

/// The words of a text without its comment.
pub(crate) struct Tokens<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Tokens<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        let text = text.split('#').next().unwrap_or_default();
        Self { text: text.trim_end(), at: 0 }
    }

    pub(crate) fn peek(&self) -> Option<Token<'t>> {
        let rest = self.text.get(self.at..)?;
        let word = rest.split_whitespace().next()?;
        let space = rest.len() - rest.trim_start().len();
        Some(Token { text: word, column: self.at.saturating_add(space) })
    }

    pub(crate) fn next(&mut self) -> Option<Token<'t>> {
        let token = self.peek()?;
        self.at = token.column.saturating_add(token.text.len());
        Some(token)
    }

    /// The next word; an error if there is none.
    pub(crate) fn need(&mut self, expected: Wanted) -> Result<Token<'t>, ParseError> {
        self.next().ok_or(self.at_end(expected))
    }

    pub(crate) fn missing(&self, what: &'static str) -> ParseError {
        self.at_end(Wanted::Missing(what))
    }

    fn at_end(&self, expected: Wanted) -> ParseError {
        ParseError { column: self.text.len(), len: 0, expected, suggestion: None }
    }
}

impl<'t> Token<'t> {
    pub(crate) const fn error(self, expected: Wanted) -> ParseError {
        ParseError { column: self.column, len: self.text.len(), expected, suggestion: None }
    }

    /// Splits `key=value`.
    pub(crate) fn pair(self) -> Option<(&'t str, Token<'t>)> {
        let (key, value) = self.text.split_once('=')?;
        let column = self.column.saturating_add(key.len() + 1);
        Some((key, Token { text: value, column }))
    }

    /// The parts between commas.
    pub(crate) fn items(self) -> impl Iterator<Item = Token<'t>> {
        let mut column = self.column;
        self.text.split(',').map(move |text| {
            let token = Token { text, column };
            column = column.saturating_add(text.len() + 1);
            token
        })
    }

    /// A number within a range, decimal or hexadecimal.
    pub(crate) fn number<T: TryFrom<i64>>(
        self,
        what: &'static str,
        (min, max): (i64, i64),
    ) -> Result<T, ParseError> {
        integer(self.text)
            .filter(|value| (min..=max).contains(value))
            .and_then(|value| T::try_from(value).ok())
            .ok_or(self.error(Wanted::Number { what, min, max }))
    }

    /// A parameter's value; hexadecimal also as a pattern of 32 bits.
    pub(crate) fn int32(self, what: &'static str) -> Result<i32, ParseError> {
        match hex(self.text) {
            Some(bits) => Ok(bits.cast_signed()),
            None => self.number(what, (i64::from(i32::MIN), i64::from(i32::MAX))),
        }
    }

    /// Exactly N parts between commas.
    pub(crate) fn split<const N: usize>(
        self,
        what: &'static str,
    ) -> Result<[Token<'t>; N], ParseError> {
        let mut items = self.items();
        let mut split = [self; N];
        for place in &mut split {
            *place = items.next().ok_or(self.error(Wanted::Numbers { what, count: N }))?;
        }
        match items.next() {
            Some(_) => Err(self.error(Wanted::Numbers { what, count: N })),
            None => Ok(split),
        }
    }

    /// Exactly N numbers between commas.
    pub(crate) fn numbers<const N: usize>(
        self,
        what: &'static str,
        range: (i64, i64),
    ) -> Result<[i16; N], ParseError> {
        let mut numbers = [0; N];
        for (number, token) in numbers.iter_mut().zip(self.split::<N>(what)?) {
            *number = token.number(what, range)?;
        }
        Ok(numbers)
    }

    /// Stores a value with its place; the same key twice is an error.
    pub(crate) fn set<T>(
        self,
        slot: &mut Option<(T, Token<'t>)>,
        value: T,
    ) -> Result<(), ParseError> {
        match slot.replace((value, self)) {
            Some(_) => Err(self.error(Wanted::Once)),
            None => Ok(()),
        }
    }
}

impl ParseError {
    pub(crate) const fn or_suggest(self, suggestion: Option<&'static str>) -> Self {
        Self { suggestion, ..self }
    }
}

fn integer(word: &str) -> Option<i64> {
    hex(word).map(i64::from).or_else(|| word.parse().ok())
}

/// `0x` and up to eight digits.
pub(crate) fn hex(word: &str) -> Option<u32> {
    let digits = word.strip_prefix("0x").or(word.strip_prefix("0X"))?;
    // The standard library would also accept a sign.
    let all = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    u32::from_str_radix(digits, 16).ok().filter(|_| all)
}

/// The data of a request while they are read.
pub(crate) struct Buffer<'b> {
    bytes: &'b mut [u8],
    len: usize,
    limit: usize,
}

impl<'b> Buffer<'b> {
    pub(crate) const fn new(bytes: &'b mut [u8], limit: usize) -> Self {
        Self { bytes, len: 0, limit }
    }

    /// Appends the bytes of a word.
    pub(crate) fn push(&mut self, bytes: &[u8], token: Token<'_>) -> Result<(), ParseError> {
        let end = self.len.saturating_add(bytes.len());
        match self.bytes.get_mut(self.len..end) {
            Some(place) if end <= self.limit => place.copy_from_slice(bytes),
            _ => return Err(token.error(Wanted::FewerData)),
        }
        self.len = end;
        Ok(())
    }

    pub(crate) fn finish(self) -> &'b [u8] {
        let bytes: &'b [u8] = self.bytes;
        bytes.get(..self.len).unwrap_or_default()
    }
}
