//! Frames of requests in what a master sends, and the frames of answers. No I/O, no clock.

use crate::field::wire::{FRAME_MAX, Framing, crc};

/// Header of a frame over TCP: number, protocol, length, unit.
const HEADER: usize = 7;
/// Shortest frame on a serial line: unit, function, checksum.
const RTU_MIN: usize = 4;

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The unit that it is to.
    pub unit: u8,
    /// The function and what follows it.
    pub pdu: Vec<u8>,
    /// Number and protocol, over TCP.
    number: [u8; 4],
    /// Nothing unreadable was on the line before it: its beginning is certain.
    pub certain: bool,
}

/// What is found next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next {
    /// A request.
    Frame(Frame),
    /// More bytes are needed.
    More,
    /// No frame, and where the next one begins is not known: the connection is closed.
    Broken,
}

/// Finds the requests.
#[derive(Debug)]
pub struct Splitter {
    framing: Framing,
    buffer: Vec<u8>,
    /// The line has had what is no frame since it was last silent.
    noise: bool,
    /// What was sent last: an adapter on two wires returns it.
    echo: Vec<u8>,
    malformed: u64,
}

impl Splitter {
    /// One for a new connection.
    pub const fn new(framing: Framing) -> Self {
        Self { framing, buffer: Vec::new(), noise: false, echo: Vec::new(), malformed: 0 }
    }

    /// Takes bytes in.
    pub fn feed(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    /// A frame is not complete, or the line has to be silent.
    pub fn is_within(&self) -> bool {
        !self.buffer.is_empty() || self.noise
    }

    /// What was sent is not returned any more: what looks like it is a request.
    pub fn forget_echo(&mut self) {
        self.echo.clear();
    }

    /// What was no frame since this was asked last.
    pub fn malformed(&mut self) -> u64 {
        std::mem::take(&mut self.malformed)
    }

    /// The next request.
    pub fn next(&mut self) -> Next {
        match self.framing {
            Framing::Tcp => self.next_tcp(),
            Framing::Rtu => self.next_rtu(),
        }
    }

    /// The line is silent: what is not complete will not be. A frame of a function whose length is not
    /// known ends here.
    pub fn silence(&mut self) -> Next {
        self.echo.clear();
        let is_whole = self.buffer.len() <= FRAME_MAX && is_whole(&self.buffer, self.buffer.len());
        if !self.noise && self.buffer.len() >= RTU_MIN && is_whole {
            let frame: Vec<u8> = std::mem::take(&mut self.buffer);
            let pdu = frame.get(1..frame.len() - 2).unwrap_or_default();
            return Next::Frame(Frame::serial(frame[0], pdu, true));
        }
        // A frame that was cut may have another one behind it.
        let cut = !self.buffer.is_empty();
        self.malformed += u64::from(cut && !self.noise);
        self.noise = true;
        let next = if cut { self.next_rtu() } else { Next::More };
        if next == Next::More {
            self.buffer.clear();
            self.noise = false;
        }
        next
    }

    /// The frame of an answer.
    pub fn answer(&mut self, request: &Frame, pdu: &[u8]) -> Vec<u8> {
        let mut frame = Vec::with_capacity(HEADER + pdu.len() + 2);
        match self.framing {
            Framing::Tcp => {
                frame.extend(request.number);
                let len = u16::try_from(1 + pdu.len()).unwrap_or_default();
                frame.extend(len.to_be_bytes());
                frame.push(request.unit);
                frame.extend_from_slice(pdu);
            }
            Framing::Rtu => {
                frame.push(request.unit);
                frame.extend_from_slice(pdu);
                frame.extend(crc(&frame).to_le_bytes());
                self.echo.clone_from(&frame);
            }
        }
        frame
    }

    fn next_tcp(&mut self) -> Next {
        let Some(&[n1, n2, p1, p2, high, low, unit]) = self.buffer.first_chunk::<HEADER>() else {
            return Next::More;
        };
        let len = usize::from(u16::from_be_bytes([high, low]));
        // The unit counts as well, and each request has a function.
        if [p1, p2] != [0, 0] || !(2..=FRAME_MAX - 6).contains(&len) {
            self.malformed += 1;
            return Next::Broken;
        }
        if self.buffer.len() < 6 + len {
            return Next::More;
        }
        let frame: Vec<u8> = self.buffer.drain(..6 + len).collect();
        let pdu = frame.get(HEADER..).unwrap_or_default().to_vec();
        Next::Frame(Frame { unit, pdu, number: [n1, n2, p1, p2], certain: true })
    }

    fn next_rtu(&mut self) -> Next {
        loop {
            if !self.echo.is_empty() && !self.buffer.is_empty() {
                if self.buffer.starts_with(&self.echo) {
                    self.buffer.drain(..self.echo.len());
                    self.echo.clear();
                } else if self.echo.starts_with(&self.buffer) {
                    return Next::More;
                } else {
                    self.echo.clear();
                }
            }
            if self.buffer.len() < RTU_MIN {
                return Next::More;
            }
            let (request, answer) = lengths(&self.buffer);
            if let Some(frame) = self.whole(request) {
                let (unit, pdu) = (frame[0], frame.get(1..frame.len() - 2).unwrap_or_default());
                return Next::Frame(Frame::serial(unit, pdu, !self.noise));
            }
            // The answer of another unit on the line.
            if self.whole(answer).is_some() {
                continue;
            }
            let longest = request.max(answer);
            if !self.noise && longest.is_some_and(|longest| self.buffer.len() < longest) {
                return Next::More;
            }
            // No frame begins here, or none whose length is known: one may begin later.
            let surplus = self.buffer.len().saturating_sub(2 * FRAME_MAX);
            let found = (1..self.buffer.len()).find(|start| self.is_frame(*start));
            let Some(start) = found.or_else(|| Some(surplus).filter(|it| *it > 0)) else {
                return Next::More;
            };
            self.buffer.drain(..start);
            self.malformed += u64::from(!self.noise);
            self.noise = true;
        }
    }

    /// Whether a frame begins there, and its checksum is right.
    fn is_frame(&self, start: usize) -> bool {
        let rest = self.buffer.get(start..).unwrap_or_default();
        let (request, answer) = lengths(rest);
        [request, answer].into_iter().flatten().any(|len| is_whole(rest, len))
    }

    /// Takes out a frame of this length, if its checksum is right.
    fn whole(&mut self, len: Option<usize>) -> Option<Vec<u8>> {
        if !is_whole(&self.buffer, len?) {
            return None;
        }
        Some(self.buffer.drain(..len?).collect())
    }
}

impl Frame {
    fn serial(unit: u8, pdu: &[u8], certain: bool) -> Self {
        Self { unit, pdu: pdu.to_vec(), number: [0; 4], certain }
    }
}

/// Whether a frame of this length is there, with the right checksum.
fn is_whole(bytes: &[u8], len: usize) -> bool {
    let parts = bytes.get(..len).and_then(<[u8]>::split_last_chunk::<2>);
    parts.is_some_and(|(data, sum)| crc(data).to_le_bytes() == *sum)
}

/// Lengths of the frame if it is a request, and if it is an answer; `None`: not known, or not yet.
fn lengths(buffer: &[u8]) -> (Option<usize>, Option<usize>) {
    let byte = |at: usize| buffer.get(at).map(|it| usize::from(*it));
    match buffer.get(1).copied().unwrap_or_default() {
        1..=4 => (Some(8), byte(2).map(|len| 5 + len).filter(|len| *len <= FRAME_MAX)),
        5 | 6 => (Some(8), Some(8)),
        15 | 16 => (byte(6).map(|len| 9 + len).filter(|len| *len <= FRAME_MAX), Some(8)),
        function if function & 1 << 7 != 0 => (None, Some(5)),
        _ => (None, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rtu(bytes: &[u8]) -> Vec<u8> {
        let mut frame = bytes.to_vec();
        frame.extend(crc(bytes).to_le_bytes());
        frame
    }

    fn all(splitter: &mut Splitter, bytes: &[u8]) -> Vec<Frame> {
        let mut found = Vec::new();
        for byte in bytes {
            splitter.feed(&[*byte]);
            while let Next::Frame(frame) = splitter.next() {
                found.push(frame);
            }
        }
        found
    }

    const READ: [u8; 6] = [1, 3, 0, 0, 0, 2];
    const WRITE: [u8; 9] = [1, 16, 1, 0, 0, 1, 2, 0, 7];

    #[test]
    fn frames_over_tcp_are_found_however_they_are_cut() {
        let mut splitter = Splitter::new(Framing::Tcp);
        let bytes = [0, 7, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2, 0, 8, 0, 0, 0, 2, 9, 43];
        let found = all(&mut splitter, &bytes);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].unit, found[0].pdu.as_slice()), (1, &READ[1..]));
        assert_eq!(splitter.answer(&found[0], &[3, 2, 0, 5]), [0, 7, 0, 0, 0, 5, 1, 3, 2, 0, 5]);
        assert_eq!(splitter.answer(&found[1], &[0xAB, 1]), [0, 8, 0, 0, 0, 3, 9, 0xAB, 1]);
        for broken in [
            &b"GET / HTTP/1.1"[..],
            &[0, 1, 0, 0, 0, 1, 1],
            &[0, 1, 0, 0, 0, 255, 1],
            &[0, 1, 0, 1, 0, 6, 1],
        ] {
            let mut splitter = Splitter::new(Framing::Tcp);
            splitter.feed(broken);
            assert_eq!((splitter.next(), splitter.malformed()), (Next::Broken, 1));
        }
    }

    #[test]
    fn requests_on_a_line_with_others_are_found_between_their_answers() {
        let mut splitter = Splitter::new(Framing::Rtu);
        let mut line = rtu(&[2, 3, 0, 0, 0, 2]);
        line.extend(rtu(&[2, 3, 4, 0, 1, 0, 2]));
        line.extend(rtu(&WRITE));
        line.extend(rtu(&[7, 0x83, 2]));
        line.extend(rtu(&[7, 16, 0, 0, 0, 1]));
        line.extend(rtu(&READ));
        let found = all(&mut splitter, &line);
        let units: Vec<(u8, u8)> = found.iter().map(|it| (it.unit, it.pdu[0])).collect();
        assert_eq!(units, [(2, 3), (1, 16), (1, 3)]);
        assert!(found.iter().all(|it| it.certain));
        assert_eq!((splitter.malformed(), splitter.is_within()), (0, false));
    }

    #[test]
    fn what_follows_noise_is_not_certain_until_the_line_was_silent() {
        let mut splitter = Splitter::new(Framing::Rtu);
        let mut line = vec![0x55, 6, 0, 9, 9, 9, 9, 9];
        line.extend(rtu(&WRITE));
        let found = all(&mut splitter, &line);
        assert_eq!((found.len(), found[0].certain, splitter.malformed()), (1, false, 1));
        assert_eq!(splitter.silence(), Next::More);
        assert!(all(&mut splitter, &rtu(&WRITE))[0].certain);
        let mut cut = vec![1, 16, 1, 8, 0, 13, 26];
        cut.extend(rtu(&WRITE));
        assert_eq!(all(&mut splitter, &cut), []);
        let Next::Frame(behind) = splitter.silence() else { panic!("a frame behind a cut one") };
        assert_eq!((behind.pdu[0], behind.certain, splitter.malformed()), (16, false, 1));
        assert!(splitter.is_within(), "the line has to be silent first");
        assert_eq!((splitter.silence(), splitter.is_within()), (Next::More, false));
        assert!(all(&mut splitter, &rtu(&WRITE))[0].certain);
        // A frame that is cut is dropped when the line is silent, and does not spoil the next one.
        assert_eq!(all(&mut splitter, &rtu(&WRITE)[..7]), []);
        assert_eq!((splitter.silence(), splitter.malformed()), (Next::More, 1));
        assert!(all(&mut splitter, &rtu(&READ))[0].certain);
    }

    #[test]
    fn an_echo_is_no_request_and_an_unknown_function_ends_with_silence() {
        let mut splitter = Splitter::new(Framing::Rtu);
        let write = rtu(&[1, 6, 1, 0, 0, 5]);
        let frame = all(&mut splitter, &write).remove(0);
        let answer = splitter.answer(&frame, &frame.pdu.clone());
        assert_eq!(answer, write, "the answer to function 6 looks like its request");
        assert_eq!(all(&mut splitter, &answer), []);
        assert_eq!(all(&mut splitter, &rtu(&[1, 6, 1, 0, 0, 6])).len(), 1);
        assert_eq!(all(&mut splitter, &rtu(&[1, 43, 14, 1, 0])), []);
        let Next::Frame(frame) = splitter.silence() else { panic!("a frame") };
        assert_eq!((frame.unit, frame.pdu[0]), (1, 43));
    }

    #[test]
    fn nothing_grows() {
        for framing in [Framing::Tcp, Framing::Rtu] {
            let mut splitter = Splitter::new(framing);
            for seed in 0..20_000_u32 {
                splitter.feed(&seed.wrapping_mul(2_654_435_761).to_be_bytes());
                while let Next::Frame(_) = splitter.next() {}
                if splitter.next() == Next::Broken {
                    splitter = Splitter::new(framing);
                }
                assert!(splitter.buffer.len() <= 2 * FRAME_MAX + 4);
            }
        }
    }
}
