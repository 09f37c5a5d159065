//! DXF as pairs of code and value, from text and from binary files.

use lafet_texts::drawing as text;

use crate::Problem;

/// What a binary file begins with.
const BINARY: &[u8] = b"AutoCAD Binary DXF\r\n\x1a\0";

/// A pair.
#[derive(Clone, Copy, Debug)]
pub struct Tag<'a> {
    pub code: i32,
    value: Value<'a>,
    /// Line of the value; in a binary file, the number of the pair.
    pub line: usize,
}

#[derive(Clone, Copy, Debug)]
enum Value<'a> {
    Text(&'a [u8]),
    Real(f64),
    Whole(i64),
}

impl<'a> Tag<'a> {
    /// The bytes of a text; empty for numbers of a binary file.
    pub fn bytes(&self) -> &'a [u8] {
        match self.value {
            Value::Text(bytes) => bytes,
            Value::Real(_) | Value::Whole(_) => b"",
        }
    }

    /// Whether it is this name or this keyword.
    pub fn is(&self, code: i32, word: &str) -> bool {
        self.code == code && self.bytes().trim_ascii().eq_ignore_ascii_case(word.as_bytes())
    }

    /// A finite number.
    pub fn real(&self) -> Result<f64, Problem> {
        let value = match self.value {
            Value::Real(value) => Some(value),
            Value::Whole(value) => Some(value as f64),
            Value::Text(bytes) => {
                std::str::from_utf8(bytes.trim_ascii()).ok().and_then(|it| it.parse().ok())
            }
        };
        value.filter(|it| it.is_finite()).ok_or_else(|| self.wrong())
    }

    pub fn whole(&self) -> Result<i64, Problem> {
        let value = match self.value {
            Value::Whole(value) => Some(value),
            Value::Real(_) => None,
            Value::Text(bytes) => {
                std::str::from_utf8(bytes.trim_ascii()).ok().and_then(|it| it.parse().ok())
            }
        };
        value.ok_or_else(|| self.wrong())
    }

    fn wrong(&self) -> Problem {
        let shown = crate::shape::name(&String::from_utf8_lossy(self.bytes()));
        let code = self.code;
        Problem::at(self.line, text::NoNumber { code, shown }, text::BrokenRemedy)
    }
}

/// The pairs of a file.
pub struct Tags<'a> {
    rest: &'a [u8],
    /// Bytes of a code in a binary file; none in a text file.
    binary: Option<usize>,
    line: usize,
    again: Option<Tag<'a>>,
}

impl<'a> Tags<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        match rest.strip_prefix(BINARY) {
            // Before release 13 a code had one byte: 0 and then the name of the first section.
            Some(rest) => {
                let width = if rest.get(1) == Some(&0) { 2 } else { 1 };
                Self { rest, binary: Some(width), line: 0, again: None }
            }
            None => Self { rest, binary: None, line: 0, again: None },
        }
    }

    /// Gives a pair back, to be read again.
    pub fn back(&mut self, tag: Tag<'a>) {
        self.again = Some(tag);
    }

    /// The next pair. The end of a drawing is a pair of its own, so the end of the file is an error.
    pub fn next(&mut self) -> Result<Tag<'a>, Problem> {
        if let Some(tag) = self.again.take() {
            return Ok(tag);
        }
        loop {
            let tag = match self.binary {
                Some(width) => self.binary_tag(width)?,
                None => self.text_tag()?,
            };
            // A comment.
            if tag.code != 999 {
                return Ok(tag);
            }
        }
    }

    fn text_tag(&mut self) -> Result<Tag<'a>, Problem> {
        let code = self.text_line()?;
        let known = std::str::from_utf8(code.trim_ascii()).ok().and_then(|it| it.parse().ok());
        let code: i32 = known.ok_or_else(|| {
            let shown = crate::shape::name(&String::from_utf8_lossy(code));
            Problem::at(self.line, text::NoCode { shown }, text::BrokenRemedy)
        })?;
        let value = Value::Text(self.text_line()?);
        Ok(Tag { code, value, line: self.line })
    }

    fn text_line(&mut self) -> Result<&'a [u8], Problem> {
        if self.rest.is_empty() {
            return Err(self.cut());
        }
        let end = self.rest.iter().position(|it| *it == b'\n');
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.get(1..).unwrap_or_default();
        self.line += 1;
        Ok(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn cut(&self) -> Problem {
        Problem::at(self.line.max(1), text::Cut, text::CutRemedy)
    }

    fn binary_tag(&mut self, width: usize) -> Result<Tag<'a>, Problem> {
        self.line += 1;
        let mut code = if width == 2 {
            i32::from(u16::from_le_bytes(self.array()?))
        } else {
            i32::from(u8::from_le_bytes(self.array()?))
        };
        if width == 1 && code == 255 {
            code = i32::from(u16::from_le_bytes(self.array()?));
        }
        let value = self.binary_value(code)?;
        Ok(Tag { code, value, line: self.line })
    }

    fn binary_value(&mut self, code: i32) -> Result<Value<'a>, Problem> {
        Ok(match code {
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => {
                Value::Real(f64::from_le_bytes(self.array()?))
            }
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => {
                Value::Whole(i16::from_le_bytes(self.array()?).into())
            }
            90..=99 | 420..=429 | 440..=459 | 1071 => {
                Value::Whole(i32::from_le_bytes(self.array()?).into())
            }
            160..=169 => Value::Whole(i64::from_le_bytes(self.array()?)),
            290..=299 => Value::Whole(u8::from_le_bytes(self.array()?).into()),
            310..=319 | 1004 => {
                let length = usize::from(u8::from_le_bytes(self.array()?));
                Value::Text(self.take(length)?)
            }
            0..=9
            | 100..=109
            | 300..=369
            | 390..=399
            | 410..=419
            | 430..=439
            | 470..=481
            | 999..=1009 => {
                let end = self.rest.iter().position(|it| *it == 0).ok_or_else(|| self.cut())?;
                let text = self.take(end)?;
                self.take(1)?;
                Value::Text(text)
            }
            _ => {
                let shown = code;
                return Err(Problem::at(self.line, text::NoCode { shown }, text::BrokenRemedy));
            }
        })
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Problem> {
        let bytes = self.take(N)?;
        bytes.try_into().map_err(|_| self.cut())
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Problem> {
        let taken = self.rest.get(..count).ok_or_else(|| self.cut())?;
        self.rest = &self.rest[count..];
        Ok(taken)
    }
}
