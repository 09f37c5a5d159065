//! The statuses of answers over HTTP, from the bytes of a connection.

/// Reads one answer behind the other.
#[derive(Default)]
pub struct Answers {
    /// What has come of a head, or of the line before a chunk.
    head: Vec<u8>,
    part: Part,
}

/// What comes next.
#[derive(Default)]
enum Part {
    #[default]
    Head,
    Body(u64),
    /// The line with the length of a chunk.
    ChunkLine,
    Chunk(u64),
    /// All until the connection ends.
    Rest,
}

impl Answers {
    /// Takes bytes as they come; the statuses of answers that begin in them.
    pub fn take(&mut self, mut bytes: &[u8], mut status: impl FnMut(u16)) {
        while !bytes.is_empty() {
            match self.part {
                Part::Rest => return,
                Part::Body(left) => {
                    let (rest, left) = skip(bytes, left);
                    bytes = rest;
                    self.part = if left == 0 { Part::Head } else { Part::Body(left) };
                }
                Part::Chunk(left) => {
                    let (rest, left) = skip(bytes, left);
                    bytes = rest;
                    self.part = if left == 0 { Part::ChunkLine } else { Part::Chunk(left) };
                }
                Part::ChunkLine => {
                    if let Some(line) = self.until(&mut bytes, b"\r\n") {
                        let length = u64::from_str_radix(line.trim(), 16).unwrap_or(0);
                        // The last one has an empty line behind it.
                        self.part =
                            if length == 0 { Part::Body(2) } else { Part::Chunk(length + 2) };
                    }
                }
                Part::Head => {
                    if let Some(head) = self.until(&mut bytes, b"\r\n\r\n") {
                        let code = head.split(' ').nth(1).and_then(|it| it.parse().ok());
                        status(code.unwrap_or(0));
                        self.part = body_of(&head, code.unwrap_or(0));
                    }
                }
            }
        }
    }

    /// The text up to this end, if it is there.
    fn until(&mut self, bytes: &mut &[u8], end: &[u8]) -> Option<String> {
        let old = self.head.len().saturating_sub(end.len() - 1);
        let from = self.head.len();
        self.head.extend_from_slice(bytes);
        let found = self.head[old..].windows(end.len()).position(|it| it == end);
        let Some(position) = found else {
            *bytes = &[];
            return None;
        };
        let length = old + position + end.len();
        *bytes = &bytes[length - from..];
        self.head.truncate(length);
        Some(String::from_utf8_lossy(&std::mem::take(&mut self.head)).into_owned())
    }
}

fn skip(bytes: &[u8], left: u64) -> (&[u8], u64) {
    let count = bytes.len().min(usize::try_from(left).unwrap_or(usize::MAX));
    (&bytes[count..], left - count as u64)
}

/// What follows a head.
fn body_of(head: &str, status: u16) -> Part {
    let head = head.to_ascii_lowercase();
    let value = |name: &str| head.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
    match (status, value("content-length:"), value("transfer-encoding:")) {
        (204 | 304, ..) => Part::Head,
        (101, ..) => Part::Rest,
        (_, Some(length), _) => match length.parse() {
            Ok(0) => Part::Head,
            Ok(length) => Part::Body(length),
            Err(_) => Part::Rest,
        },
        (.., Some("chunked")) => Part::ChunkLine,
        _ => Part::Rest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_counted_wherever_they_are_cut() {
        let bytes: &[u8] =
            b"HTTP/1.1 200 OK\r\nContent-Length: 12\r\n\r\nHTTP/1.1 500HTTP/1.1 204 \
            No Content\r\n\r\nHTTP/1.1 201 Created\r\nTransfer-Encoding: chunked\r\n\r\n1a\r\n\
            abcdefghijklmnopqrstuvwxyz\r\n0\r\n\r\nHTTP/1.1 401 Unauthorized\r\ncontent-length: \
            0\r\n\r\nHTTP/1.1 101 Switching\r\n\r\nHTTP/1.1 200";
        for size in 1..bytes.len() {
            let (mut answers, mut seen) = (Answers::default(), Vec::new());
            bytes.chunks(size).for_each(|part| answers.take(part, |status| seen.push(status)));
            assert_eq!(seen, [200, 204, 201, 401, 101], "in pieces of {size}");
        }
    }
}
