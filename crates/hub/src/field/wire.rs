//! Frames of Modbus, as far as this hub needs them: requests, and what is an answer to one.
//!
//! A master needs so little that it is our own: what is not exactly the answer to what was
//! asked is a failure of a kind that is counted, and a late answer is known by its number instead of
//! costing the connection.

use lafet_proto::crc::Crc16;
use lafet_texts::{Text, hub as text};

use crate::text::Both;

/// Longest frame of either framing, bytes.
pub const FRAME_MAX: usize = 260;
/// Header of a frame over TCP: number, protocol, length, unit.
const HEADER: usize = 7;
/// Late answers that are passed over while one is waited for; a stream of more is none of answers.
const LATE_MAX: u64 = 16;
/// Bytes of a serial line that are kept while an answer is looked for in them.
const KEPT_MAX: usize = 2 * FRAME_MAX;

/// A table of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Table {
    /// Coils, function 1.
    Coil,
    /// Discrete inputs, function 2.
    Discrete,
    /// Holding registers, function 3.
    Holding,
    /// Input registers, function 4.
    Input,
}

impl Table {
    /// All, by their names in the configuration.
    pub const ALL: [(&'static str, Self); 4] = [
        ("coil", Self::Coil),
        ("discrete", Self::Discrete),
        ("holding", Self::Holding),
        ("input", Self::Input),
    ];

    /// Function that reads it.
    const fn function(self) -> u8 {
        match self {
            Self::Coil => 1,
            Self::Discrete => 2,
            Self::Holding => 3,
            Self::Input => 4,
        }
    }

    /// Its values are bits.
    pub const fn is_bits(self) -> bool {
        matches!(self, Self::Coil | Self::Discrete)
    }

    /// Its values can be written.
    pub const fn is_written(self) -> bool {
        matches!(self, Self::Coil | Self::Holding)
    }

    /// Most values of one request.
    pub const fn most(self) -> u16 {
        if self.is_bits() { 2000 } else { 125 }
    }
}

/// Values to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Address of the device, 1–247.
    pub unit: u8,
    /// Where they are.
    pub table: Table,
    /// Address of the first one, from 0.
    pub first: u16,
    /// How many, 1 to [`Table::most`].
    pub count: u16,
}

/// A request, and which answer belongs to it.
pub trait Asks: Sync {
    /// Address of the device.
    fn unit(&self) -> u8;

    /// The function.
    fn function(&self) -> u8;

    /// The function and what follows it.
    fn pdu(&self) -> Vec<u8>;

    /// Bytes of the answer, the function included.
    fn answer_len(&self) -> usize;

    /// The answer is the same as the request.
    fn is_echoed(&self) -> bool;

    /// The values of an answer of the right function and length.
    ///
    /// # Errors
    ///
    /// It is another one.
    fn decoded(&self, answer: &[u8]) -> Result<Vec<u16>, Failure>;

    /// Bytes of request and answer on a serial line.
    fn serial_len(&self) -> usize {
        3 + self.pdu().len() + 3 + self.answer_len()
    }

    /// The values of an answer, if it is the one to this request.
    ///
    /// # Errors
    ///
    /// What it is instead.
    fn values(&self, unit: u8, pdu: &[u8]) -> Result<Vec<u16>, Failure> {
        if unit != self.unit() {
            return Err(Failure::WrongUnit(unit));
        }
        let function = self.function();
        match pdu {
            [exception, code] if *exception == exception_of(function) => {
                Err(Failure::Exception(*code))
            }
            [other, ..] if *other != function => Err(Failure::WrongFunction(*other)),
            _ if pdu.len() == self.answer_len() => self.decoded(pdu),
            _ => Err(Failure::WrongLength),
        }
    }
}

impl Request {
    /// Bytes of values in the answer.
    fn data_len(&self) -> usize {
        let count = usize::from(self.count);
        if self.table.is_bits() { count.div_ceil(8) } else { 2 * count }
    }

    fn values_of(&self, data: &[u8]) -> Vec<u16> {
        let count = usize::from(self.count);
        if self.table.is_bits() {
            let bits =
                data.iter().flat_map(|byte| (0..8).map(move |bit| u16::from(byte >> bit & 1)));
            return bits.take(count).collect();
        }
        let words = data.chunks_exact(2).filter_map(|word| <[u8; 2]>::try_from(word).ok());
        words.map(u16::from_be_bytes).collect()
    }
}

impl Asks for Request {
    fn unit(&self) -> u8 {
        self.unit
    }

    fn function(&self) -> u8 {
        self.table.function()
    }

    fn pdu(&self) -> Vec<u8> {
        let [first_high, first_low] = self.first.to_be_bytes();
        let [count_high, count_low] = self.count.to_be_bytes();
        vec![self.table.function(), first_high, first_low, count_high, count_low]
    }

    fn answer_len(&self) -> usize {
        2 + self.data_len()
    }

    fn is_echoed(&self) -> bool {
        false
    }

    fn decoded(&self, answer: &[u8]) -> Result<Vec<u16>, Failure> {
        match answer {
            [_, len, data @ ..] if usize::from(*len) == data.len() => Ok(self.values_of(data)),
            _ => Err(Failure::WrongLength),
        }
    }
}

/// Why there are no values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Nothing came in time, or not all of it.
    Timeout,
    /// The device refuses.
    Exception(u8),
    /// Another device has answered.
    WrongUnit(u8),
    /// The answer is to something else.
    WrongFunction(u8),
    /// The answer has other values than were asked for.
    WrongLength,
    /// The answer confirms another value than was written.
    WrongEcho,
    /// The answer was not waited for: something more urgent came.
    GivenUp,
    /// What came is no frame.
    Garbage,
    /// The connection has ended, or the port is gone.
    Closed(Both),
}

impl Failure {
    /// The connection cannot be used any more: where a frame begins is not known over TCP.
    pub const fn ends(&self, framing: Framing) -> bool {
        match self {
            Self::Closed(_) => true,
            Self::Garbage => matches!(framing, Framing::Tcp),
            _ => false,
        }
    }

    /// What it says to people.
    pub fn text(&self) -> Both {
        match self {
            Self::Timeout => text::BusNoAnswer.words(),
            Self::Exception(code) => exception(*code),
            Self::WrongUnit(unit) => text::BusOtherUnit { unit }.words(),
            Self::WrongFunction(function) => text::BusOtherFunction { function }.words(),
            Self::WrongLength => text::BusOtherCount.words(),
            Self::WrongEcho => text::BusOtherValue.words(),
            Self::GivenUp => text::BusGivenUp.words(),
            Self::Garbage => text::BusNoFrame.words(),
            Self::Closed(why) => why.clone(),
        }
    }
}

fn exception(code: u8) -> Both {
    let why: &dyn Text = match code {
        1 => &text::BusFunction,
        2 => &text::BusAddress,
        3 => &text::BusValue,
        4 => &text::BusDevice,
        6 => &text::BusBusy,
        10 => &text::BusNoPath,
        11 => &text::BusBehindGateway,
        _ => &text::BusUnknownCode,
    };
    text::BusException { code, why }.words()
}

/// The function code of an exception to a request of this function: its top bit is set.
const fn exception_of(function: u8) -> u8 {
    function | 1 << 7
}

/// How frames are delimited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Framing {
    /// A header with number and length.
    Tcp,
    /// Checksum and silence.
    Rtu,
}

/// Makes frames, and finds answers in what comes.
#[derive(Debug)]
pub struct Codec {
    framing: Framing,
    /// Number of the latest request.
    number: u16,
    buffer: Vec<u8>,
    /// Answers that came too late.
    late: u64,
}

impl Codec {
    /// A codec for a new connection.
    pub const fn new(framing: Framing) -> Self {
        Self { framing, number: 0, buffer: Vec::new(), late: 0 }
    }

    /// Answers that came too late since this was asked last.
    pub fn late(&mut self) -> u64 {
        std::mem::take(&mut self.late)
    }

    /// The frame of a request.
    pub fn frame(&mut self, request: &dyn Asks) -> Vec<u8> {
        let mut frame = Vec::with_capacity(16);
        let (unit, pdu) = (request.unit(), request.pdu());
        match self.framing {
            Framing::Tcp => {
                self.number = self.number.wrapping_add(1);
                frame.extend(self.number.to_be_bytes());
                let len = u8::try_from(1 + pdu.len()).unwrap_or(u8::MAX);
                frame.extend([0, 0, 0, len, unit]);
                frame.extend(pdu);
            }
            Framing::Rtu => {
                self.buffer.clear();
                frame.push(unit);
                frame.extend(pdu);
                frame.extend(crc(&frame).to_le_bytes());
            }
        }
        frame
    }

    /// Takes bytes in; the answer, as soon as it is there.
    pub fn take(&mut self, bytes: &[u8], request: &dyn Asks) -> Option<Result<Vec<u16>, Failure>> {
        self.buffer.extend_from_slice(bytes);
        match self.framing {
            Framing::Tcp => self.take_tcp(request),
            Framing::Rtu => self.take_rtu(request),
        }
    }

    /// What was wrong if time is over.
    pub fn overdue(&self, request: &dyn Asks) -> Failure {
        if self.framing == Framing::Tcp || self.buffer.is_empty() {
            return Failure::Timeout;
        }
        let sound = self
            .buffer
            .split_last_chunk::<2>()
            .filter(|(frame, sum)| crc(frame).to_le_bytes() == **sum);
        match sound.and_then(|(frame, _)| frame.split_first()) {
            Some((unit, pdu)) => request.values(*unit, pdu).err().unwrap_or(Failure::Garbage),
            None => Failure::Garbage,
        }
    }

    fn take_tcp(&mut self, request: &dyn Asks) -> Option<Result<Vec<u16>, Failure>> {
        loop {
            let &[number_high, number_low, p1, p2, len_high, len_low, unit] =
                self.buffer.first_chunk::<HEADER>()?;
            let len = usize::from(u16::from_be_bytes([len_high, len_low]));
            // The unit counts as well, and the shortest of all says at least something.
            if [p1, p2] != [0, 0] || !(2..=FRAME_MAX - 6).contains(&len) {
                return Some(Err(Failure::Garbage));
            }
            if self.buffer.len() < 6 + len {
                return None;
            }
            let frame: Vec<u8> = self.buffer.drain(..6 + len).collect();
            let pdu = frame.get(HEADER..).unwrap_or_default();
            if u16::from_be_bytes([number_high, number_low]) == self.number {
                return Some(request.values(unit, pdu));
            }
            self.late += 1;
            if self.late > LATE_MAX {
                return Some(Err(Failure::Garbage));
            }
        }
    }

    /// The answer wherever it begins: what was on the line before it, an echo too, is passed over.
    fn take_rtu(&mut self, request: &dyn Asks) -> Option<Result<Vec<u16>, Failure>> {
        let surplus = self.buffer.len().saturating_sub(KEPT_MAX);
        self.buffer.drain(..surplus);
        let (unit, function) = (request.unit(), request.function());
        let mut own = vec![unit];
        own.extend(request.pdu());
        for start in 0..self.buffer.len() {
            let rest = &self.buffer[start..];
            let len = match rest {
                [from, got, ..] if *from == unit && *got == function => 1 + request.answer_len(),
                [from, got, ..] if *from == unit && *got == exception_of(function) => 3,
                _ => continue,
            };
            let Some((frame, sum)) = rest.get(..len + 2).and_then(<[u8]>::split_last_chunk::<2>)
            else {
                continue;
            };
            let is_echo = frame == own && !request.is_echoed();
            if crc(frame).to_le_bytes() == *sum && !is_echo {
                return Some(request.values(unit, &frame[1..]));
            }
        }
        None
    }
}

/// The checksum of a serial line.
pub fn crc(bytes: &[u8]) -> u16 {
    let mut crc = Crc16::new();
    crc.update(bytes);
    crc.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASK: Request = Request { unit: 1, table: Table::Holding, first: 0, count: 2 };

    /// Frames of the standard's own texts, not of this code.
    #[test]
    fn frames_are_as_others_have_them() {
        assert_eq!(
            Codec::new(Framing::Rtu).frame(&ASK),
            [0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xC4, 0x0B]
        );
        let discretes = Request { unit: 4, table: Table::Coil, first: 10, count: 13 };
        let mut codec = Codec::new(Framing::Rtu);
        assert_eq!(codec.frame(&discretes), [0x04, 0x01, 0x00, 0x0A, 0x00, 0x0D, 0xDD, 0x98]);
        let answer = [0x04, 0x01, 0x02, 0x0A, 0x11, 0xB3, 0x50];
        let bits = [0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1];
        assert_eq!(codec.take(&answer, &discretes), Some(Ok(bits.to_vec())));
        let mut codec = Codec::new(Framing::Tcp);
        assert_eq!(codec.frame(&ASK), [0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2]);
        let answer = [0, 1, 0, 0, 0, 7, 1, 3, 4, 0, 6, 0, 5];
        assert_eq!(codec.take(&answer, &ASK), Some(Ok(vec![6, 5])));
    }

    fn over_tcp(pdu: &[u8], unit: u8) -> Option<Result<Vec<u16>, Failure>> {
        let mut codec = Codec::new(Framing::Tcp);
        codec.frame(&ASK);
        let mut frame = vec![0, 1, 0, 0, 0, pdu.len() as u8 + 1, unit];
        frame.extend_from_slice(pdu);
        codec.take(&frame, &ASK)
    }

    #[test]
    fn what_is_not_exactly_the_answer_is_none() {
        for (pdu, unit, failure) in [
            (&[0x83, 2][..], 1, Failure::Exception(2)),
            (&[3, 4, 0, 6, 0, 5], 2, Failure::WrongUnit(2)),
            (&[4, 4, 0, 6, 0, 5], 1, Failure::WrongFunction(4)),
            (&[0x84, 2], 1, Failure::WrongFunction(0x84)),
            (&[3, 4, 0, 6, 0], 1, Failure::WrongLength),
            (&[3, 2, 0, 6], 1, Failure::WrongLength),
            (&[3, 6, 0, 6, 0, 5, 0, 4], 1, Failure::WrongLength),
            (&[3, 4, 0, 6, 0, 5, 0, 4], 1, Failure::WrongLength),
            (&[0x83, 2, 0], 1, Failure::WrongFunction(0x83)),
            (&[3], 1, Failure::WrongLength),
        ] {
            assert_eq!(over_tcp(pdu, unit), Some(Err(failure)), "{pdu:?}");
        }
    }

    #[test]
    fn a_late_answer_is_passed_over_and_a_stream_of_them_is_garbage() {
        let mut codec = Codec::new(Framing::Tcp);
        codec.frame(&ASK);
        codec.frame(&ASK);
        let late = [0, 1, 0, 0, 0, 7, 1, 3, 4, 0, 6, 0, 5];
        // It drips, and its rest comes with the answer that is waited for.
        assert_eq!(codec.take(&late[..9], &ASK), None);
        let mut rest = late[9..].to_vec();
        rest.extend([0, 2, 0, 0, 0, 7, 1, 3, 4, 0, 1, 0, 2]);
        assert_eq!((codec.take(&rest, &ASK), codec.late()), (Some(Ok(vec![1, 2])), 1));
        codec.frame(&ASK);
        assert_eq!(codec.take(&late.repeat(20), &ASK), Some(Err(Failure::Garbage)));
        assert!(Failure::Garbage.ends(Framing::Tcp) && !Failure::Garbage.ends(Framing::Rtu));
    }

    #[test]
    fn headers_that_cannot_be_are_garbage_and_nothing_grows() {
        for frame in [
            &[0, 1, 0, 1, 0, 7, 1, 3, 4, 0, 6, 0, 5][..],
            &[0, 1, 0, 0, 0xFF, 0xFF, 1],
            &[0, 1, 0, 0, 0, 0, 1],
            &[0, 1, 0, 0, 0, 1, 1],
            b"HTTP/1.1 400 Bad Request\r\n",
        ] {
            let mut codec = Codec::new(Framing::Tcp);
            codec.frame(&ASK);
            assert_eq!(codec.take(frame, &ASK), Some(Err(Failure::Garbage)), "{frame:?}");
        }
        let mut codec = Codec::new(Framing::Rtu);
        codec.frame(&ASK);
        for _ in 0..1000 {
            assert_eq!(codec.take(&[1, 3, 9, 7], &ASK), None);
            assert!(codec.buffer.len() <= KEPT_MAX);
        }
        assert_eq!(codec.overdue(&ASK), Failure::Garbage);
    }

    fn rtu(bytes: &[u8]) -> Vec<u8> {
        let mut frame = bytes.to_vec();
        frame.extend(crc(bytes).to_le_bytes());
        frame
    }

    #[test]
    fn an_answer_is_found_behind_noise_and_echo_and_others_are_told_apart() {
        let mut codec = Codec::new(Framing::Rtu);
        let mut heard = vec![0xFF, 1, 3];
        heard.extend(codec.frame(&ASK));
        heard.extend(rtu(&[1, 3, 4, 0, 6, 0, 5]));
        let found: Vec<_> = heard.iter().filter_map(|byte| codec.take(&[*byte], &ASK)).collect();
        assert_eq!(found, [Ok(vec![6, 5])]);
        for (answer, failure) in [
            (rtu(&[2, 3, 4, 0, 6, 0, 5]), Failure::WrongUnit(2)),
            (rtu(&[1, 4, 4, 0, 6, 0, 5]), Failure::WrongFunction(4)),
            (rtu(&[1, 3, 2, 0, 6]), Failure::WrongLength),
            (vec![1, 3, 4, 0, 6, 0, 5, 0, 0], Failure::Garbage),
            (vec![], Failure::Timeout),
        ] {
            codec.frame(&ASK);
            assert_eq!(codec.take(&answer, &ASK), None);
            assert_eq!(codec.overdue(&ASK), failure);
        }
        codec.frame(&ASK);
        assert_eq!(codec.take(&rtu(&[1, 0x83, 4]), &ASK), Some(Err(Failure::Exception(4))));
    }

    /// An adapter that returns what is sent, on a line without a device: the echo of a request whose
    /// address looks like a length is as long as the answer, and its checksum is right.
    #[test]
    fn an_echo_is_no_answer() {
        let ask = Request { unit: 1, table: Table::Discrete, first: 0x0300, count: 24 };
        let mut codec = Codec::new(Framing::Rtu);
        let echo = codec.frame(&ask);
        assert_eq!((echo.len(), codec.take(&echo, &ask)), (8, None));
    }
}
