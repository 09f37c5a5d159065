//! The process image as bytes (ours): a chip whose sensors, drives, clock and power are those of a
//! simulated plant.
//!
//! The plant sends an [`Order`], the chip answers with [`Report`]s; the last one of a step is
//! [`Report::Done`], or [`Report::Started`] when the program was reset. Each goes in a link frame of
//! the monitor's own protocol, with the addresses 0, over a serial line of its own.

#![no_std]
#[cfg(test)]
extern crate std;

mod pass;

use lafet_device::image::{Inputs, Outputs};
use lafet_proto::link::{self, Check, Frame};
use pass::{Reader, Writer, inputs, number, outputs};

/// Bytes of the greatest message.
pub const MESSAGE_MAX: usize = 320;
/// Instructions against which the chip's timer is held.
pub const GAUGE: u32 = 50_000;
/// Bytes of the greatest report, which a chip writes on its stack.
const REPORT_MAX: usize = 80;
/// Bytes of the greatest message on the line, escapes included.
pub const WIRE_MAX: usize = 2 * MESSAGE_MAX + 16;

/// Reads messages from the line.
pub type Decoder = link::Decoder<{ MESSAGE_MAX + 8 }, ()>;

/// What the plant tells the chip. `I` is what is sensed: the plant has it as [`Inputs`], the chip as an
/// [`Image`] that it reads to where it belongs.
#[derive(Clone, Debug, PartialEq)]
pub enum Order<I> {
    /// One step of the monitor.
    Step {
        /// The monitor's clock, ms.
        now_ms: u32,
        /// What it senses.
        inputs: I,
    },
    /// Leave the factory: parameters of a composition, by its place in `Composition::ALL`.
    Provision {
        /// Which composition.
        composition: u8,
        /// The monitor's address.
        address: u8,
    },
    /// The clock and the composition with which the program starts, at once and after each reset.
    Start {
        /// The monitor's clock, ms.
        now_ms: u32,
        /// Which composition.
        composition: u8,
        /// The address it has while its memory says none.
        address: u8,
    },
    /// Something that must not happen to a program, to see what becomes of it.
    Fail(Failure),
    /// How deep has the stack been?
    MeasureStack,
    /// How long have steps and answers taken since this was asked last?
    MeasureTime,
}

/// How a program fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// It jumps to where no program can be.
    Astray,
    /// It executes what is no instruction.
    UndefinedInstruction,
    /// It goes round for ever.
    Hang,
}

/// What the chip tells the plant.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// The program has begun, and waits for [`Order::Start`].
    Started {
        /// After a fault that it has recorded.
        after_fault: bool,
    },
    /// Outputs are driven.
    Driven(Outputs),
    /// The order has been carried out.
    Done,
    /// The order was not possible: the memory failed.
    Failed,
    /// Bytes of the stack that have been used since the start.
    Stack(u32),
    /// Ticks of the chip's timer, without what the board itself does.
    Time {
        /// In steps.
        steps: u32,
        /// From a request's bytes to those of its answer.
        answers: u32,
        /// In [`GAUGE`] instructions.
        gauge: u32,
    },
}

/// A message that is none of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown;

/// What is sensed, as it has come over the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image<'a>(&'a [u8]);

impl Image<'_> {
    /// Puts it where it belongs.
    pub fn read(self, image: &mut Inputs) -> Result<(), Unknown> {
        let mut reader = Reader::new(self.0);
        inputs(&mut reader, image);
        if reader.is_whole() { Ok(()) } else { Err(Unknown) }
    }
}

impl Order<&Inputs> {
    /// The frame for the line; how many bytes of `wire` it takes.
    pub fn encode(&self, wire: &mut [u8; WIRE_MAX]) -> Option<usize> {
        let mut places = wire.iter_mut();
        let mut len = Some(0_usize);
        let mut put = |byte| {
            len = places.next().and_then(|place| {
                *place = byte;
                Some(len? + 1)
            });
        };
        framed::<MESSAGE_MAX>(&mut put, |writer| match self {
            Self::Step { now_ms, inputs: image } => {
                writer.put(0);
                number(writer, &mut { *now_ms });
                inputs(writer, &mut Inputs::clone(image));
            }
            Self::Provision { composition, address } => {
                writer.put(1);
                writer.put(*composition);
                writer.put(*address);
            }
            Self::Start { now_ms, composition, address } => {
                writer.put(2);
                number(writer, &mut { *now_ms });
                writer.put(*composition);
                writer.put(*address);
            }
            Self::Fail(failure) => {
                writer.put(3);
                writer.put(*failure as u8);
            }
            Self::MeasureStack => writer.put(4),
            Self::MeasureTime => writer.put(5),
        })?;
        len
    }
}

impl<'a> Order<Image<'a>> {
    /// From the payload of a frame.
    pub fn decode(payload: &'a [u8]) -> Result<Self, Unknown> {
        let mut reader = Reader::new(payload);
        let order = match reader.take() {
            0 => {
                let mut now_ms = 0;
                number(&mut reader, &mut now_ms);
                let inputs = Image(reader.rest());
                return if reader.is_bad() {
                    Err(Unknown)
                } else {
                    Ok(Self::Step { now_ms, inputs })
                };
            }
            1 => Self::Provision { composition: reader.take(), address: reader.take() },
            2 => {
                let mut now_ms = 0;
                number(&mut reader, &mut now_ms);
                Self::Start { now_ms, composition: reader.take(), address: reader.take() }
            }
            3 => Self::Fail(match reader.take() {
                0 => Failure::Astray,
                1 => Failure::UndefinedInstruction,
                2 => Failure::Hang,
                _ => return Err(Unknown),
            }),
            4 => Self::MeasureStack,
            5 => Self::MeasureTime,
            _ => return Err(Unknown),
        };
        if reader.is_whole() { Ok(order) } else { Err(Unknown) }
    }
}

impl Report {
    /// Hands over the frame for the line, byte by byte.
    pub fn send(&self, put: &mut dyn FnMut(u8)) {
        // The greatest one fits.
        let _ = framed::<REPORT_MAX>(put, |writer| match self {
            Self::Started { after_fault } => {
                writer.put(0);
                writer.put(u8::from(*after_fault));
            }
            Self::Driven(image) => {
                writer.put(1);
                outputs(writer, &mut { *image });
            }
            Self::Done => writer.put(2),
            Self::Failed => writer.put(3),
            Self::Stack(bytes) => {
                writer.put(4);
                number(writer, &mut { *bytes });
            }
            Self::Time { steps, answers, gauge } => {
                writer.put(5);
                [*steps, *answers, *gauge].iter_mut().for_each(|ticks| number(writer, ticks));
            }
        });
    }

    /// From the payload of a frame.
    pub fn decode(payload: &[u8]) -> Result<Self, Unknown> {
        let mut reader = Reader::new(payload);
        let report = match reader.take() {
            0 => Self::Started { after_fault: reader.take() != 0 },
            1 => {
                let mut image = Outputs::default();
                outputs(&mut reader, &mut image);
                Self::Driven(image)
            }
            2 => Self::Done,
            3 => Self::Failed,
            4 => {
                let mut bytes = 0;
                number(&mut reader, &mut bytes);
                Self::Stack(bytes)
            }
            5 => {
                let [mut steps, mut answers, mut gauge] = [0; 3];
                [&mut steps, &mut answers, &mut gauge]
                    .into_iter()
                    .for_each(|ticks| number(&mut reader, ticks));
                Self::Time { steps, answers, gauge }
            }
            _ => return Err(Unknown),
        };
        if reader.is_whole() { Ok(report) } else { Err(Unknown) }
    }
}

/// Writes a message and hands over its frame: `None` when it is longer than `N`.
fn framed<const N: usize>(
    put: &mut dyn FnMut(u8),
    write: impl FnOnce(&mut Writer<'_>),
) -> Option<()> {
    let mut message = [0; N];
    let mut writer = Writer::new(&mut message);
    write(&mut writer);
    let frame = Frame { dst: 0, src: 0, payload: writer.written()? };
    // As the chip sends everything else: no second way of making a frame takes flash.
    link::send(Check::Crc16, &frame, put);
    Some(())
}

#[cfg(test)]
mod tests;

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
