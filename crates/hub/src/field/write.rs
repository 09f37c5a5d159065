//! Requests that write one value, and what confirms them.

use super::wire::{Asks, Failure, Table};

/// What a coil that is on has on the wire.
const COIL_ON: u16 = 0xFF00;

/// A value to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Write {
    /// Address of the device, 1–247.
    pub unit: u8,
    /// [`Table::Coil`] or [`Table::Holding`].
    pub table: Table,
    /// Address of the value, from 0.
    pub address: u16,
    /// The value; of a coil 0 or 1.
    pub value: u16,
    /// With the function for several values, of which there is one.
    pub many: bool,
}

impl Asks for Write {
    fn unit(&self) -> u8 {
        self.unit
    }

    fn function(&self) -> u8 {
        match (self.table.is_bits(), self.many) {
            (true, false) => 5,
            (false, false) => 6,
            (true, true) => 15,
            (false, true) => 16,
        }
    }

    fn pdu(&self) -> Vec<u8> {
        let mut pdu = vec![self.function()];
        pdu.extend(self.address.to_be_bytes());
        let coil = if self.value == 0 { 0 } else { COIL_ON };
        match (self.table.is_bits(), self.many) {
            (true, false) => pdu.extend(coil.to_be_bytes()),
            (false, false) => pdu.extend(self.value.to_be_bytes()),
            (true, true) => pdu.extend([0, 1, 1, u8::from(self.value != 0)]),
            (false, true) => {
                pdu.extend([0, 1, 2]);
                pdu.extend(self.value.to_be_bytes());
            }
        }
        pdu
    }

    fn answer_len(&self) -> usize {
        5
    }

    fn is_echoed(&self) -> bool {
        !self.many
    }

    /// The answer repeats address and value, or how many there are.
    fn decoded(&self, answer: &[u8]) -> Result<Vec<u16>, Failure> {
        let right = self.pdu().get(..self.answer_len()) == Some(answer);
        if right { Ok(Vec::new()) } else { Err(Failure::WrongEcho) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::wire::{Codec, Framing};
    use super::*;

    fn write(table: Table, address: u16, value: u16, many: bool) -> Write {
        Write { unit: 0x11, table, address, value, many }
    }

    /// Frames of the standard's own texts, not of this code.
    #[test]
    fn frames_are_as_others_have_them() {
        for (write, pdu, answer) in [
            (write(Table::Coil, 0xAC, 1, false), &[5, 0, 0xAC, 0xFF, 0][..], [5, 0, 0xAC, 0xFF, 0]),
            (write(Table::Coil, 0xAC, 0, false), &[5, 0, 0xAC, 0, 0], [5, 0, 0xAC, 0, 0]),
            (write(Table::Holding, 1, 3, false), &[6, 0, 1, 0, 3], [6, 0, 1, 0, 3]),
            (write(Table::Coil, 19, 1, true), &[15, 0, 19, 0, 1, 1, 1], [15, 0, 19, 0, 1]),
            (write(Table::Holding, 1, 10, true), &[16, 0, 1, 0, 1, 2, 0, 10], [16, 0, 1, 0, 1]),
        ] {
            assert_eq!(write.pdu(), pdu);
            let mut codec = Codec::new(Framing::Tcp);
            let frame = codec.frame(&write);
            assert_eq!(frame[..7], [0, 1, 0, 0, 0, pdu.len() as u8 + 1, 0x11]);
            let mut heard = vec![0, 1, 0, 0, 0, 6, 0x11];
            heard.extend(answer);
            assert_eq!(codec.take(&heard, &write), Some(Ok(Vec::new())));
            // Another value, another address, an exception, half of it.
            for (at, value, failure) in [
                (11, 9, Failure::WrongEcho),
                (9, 9, Failure::WrongEcho),
                (6, 2, Failure::WrongUnit(2)),
            ] {
                let mut odd = heard.clone();
                odd[at] = value;
                codec = Codec::new(Framing::Tcp);
                codec.frame(&write);
                assert_eq!(codec.take(&odd, &write), Some(Err(failure)), "{write:?}");
            }
            codec = Codec::new(Framing::Tcp);
            codec.frame(&write);
            let refused = [0, 1, 0, 0, 0, 3, 0x11, write.function() | 0x80, 2];
            assert_eq!(codec.take(&refused, &write), Some(Err(Failure::Exception(2))));
        }
        let mut codec = Codec::new(Framing::Rtu);
        let coil = write(Table::Coil, 0xAC, 1, false);
        assert_eq!(codec.frame(&coil), [0x11, 5, 0, 0xAC, 0xFF, 0, 0x4E, 0x8B]);
    }

    /// An adapter that echoes says no more than what was sent.
    #[test]
    fn an_echo_confirms_no_write_of_several_values() {
        let many = write(Table::Coil, 3, 1, true);
        let mut codec = Codec::new(Framing::Rtu);
        let echo = codec.frame(&many);
        assert_eq!(codec.take(&echo, &many), None);
        let mut answer = vec![0x11, 15, 0, 3, 0, 1];
        let mut crc = lafet_proto::crc::Crc16::new();
        crc.update(&answer);
        answer.extend(crc.finish().to_le_bytes());
        assert_eq!(codec.take(&answer, &many), Some(Ok(Vec::new())));
    }
}
