//! The process image as bytes (ours): connects a chip to the sensors, drives, clock and power of a
//! simulated plant.
//!
//! The plant sends an [`Order`], the chip answers with [`Report`]s; the last one of a step is
//! [`Report::Done`], or [`Report::Started`] when the program was reset. Each travels in a link
//! frame of the monitor's own protocol, with addresses 0, over a separate serial line.

#![no_std]
#[cfg(test)]
extern crate std;

pub mod flash;
mod pass;

use lafet_device::image::{Inputs, Outputs};
use lafet_proto::link::{self, Check, Frame};
use pass::{Reader, Writer, inputs, number, outputs};

/// Largest message, bytes.
pub const MESSAGE_MAX: usize = 320;
/// Number of instructions in the measurement that calibrates the chip's timer.
pub const GAUGE: u32 = 50_000;
/// Largest report, bytes; a chip builds it on its stack.
const REPORT_MAX: usize = 80;
/// Largest message on the line, bytes, including escapes.
pub const WIRE_MAX: usize = 2 * MESSAGE_MAX + 16;

/// Decodes messages from the line.
pub type Decoder = link::Decoder<{ MESSAGE_MAX + 8 }, ()>;

/// A message from the plant to the chip. `I` is the type of the inputs: [`Inputs`] in the plant,
/// and in the chip an [`Image`] that it decodes in place.
#[derive(Clone, Debug, PartialEq)]
pub enum Order<I> {
    /// One step of the monitor.
    Step {
        /// Clock of the monitor, ms.
        now_ms: u32,
        /// Inputs of the monitor.
        inputs: I,
    },
    /// Writes the parameters of a composition to an empty memory, as at the factory.
    Provision {
        /// Index in `Composition::ALL`.
        composition: u8,
        /// Address of the monitor.
        address: u8,
    },
    /// The clock and the composition with which the program starts, at once and after each reset.
    Start {
        /// Clock of the monitor, ms.
        now_ms: u32,
        /// Index in `Composition::ALL`.
        composition: u8,
        /// Address used while the memory contains none.
        address: u8,
    },
    /// Provokes a crash, to see how the program handles it.
    Fail(Failure),
    /// Requests the greatest stack depth so far.
    MeasureStack,
    /// Requests the time of steps and answers since the last such request.
    MeasureTime,
}

/// A crash to provoke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// A jump to an address without code.
    Astray,
    /// An undefined instruction.
    UndefinedInstruction,
    /// An endless loop.
    Hang,
}

/// A message from the chip to the plant.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// The program has started, and waits for [`Order::Start`].
    Started {
        /// Whether it was reset by a fault that it has recorded.
        after_fault: bool,
    },
    /// Outputs of the step.
    Driven(Outputs),
    /// The order has been executed.
    Done,
    /// The order failed: the memory could not be written.
    Failed,
    /// Bytes of the stack used since the start.
    Stack(u32),
    /// Ticks of the chip's timer, without the board's own work.
    Time {
        /// Ticks in steps.
        steps: u32,
        /// Ticks between a request's bytes and those of its answer.
        answers: u32,
        /// Ticks for [`GAUGE`] instructions.
        gauge: u32,
    },
}

/// A message that is not one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown;

/// Inputs, encoded as received from the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image<'a>(&'a [u8]);

impl Image<'_> {
    /// Decodes the inputs into `image`.
    pub fn read(self, image: &mut Inputs) -> Result<(), Unknown> {
        let mut reader = Reader::new(self.0);
        inputs(&mut reader, image);
        if reader.is_whole() { Ok(()) } else { Err(Unknown) }
    }
}

impl Order<&Inputs> {
    /// Writes the frame; returns its length in `wire`, or `None` if it does not fit.
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
    /// Decodes the payload of a frame.
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
    /// Passes the frame to `put`, byte by byte.
    pub fn send(&self, put: &mut dyn FnMut(u8)) {
        // The largest report fits.
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

    /// Decodes the payload of a frame.
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

/// Builds a message and passes its frame to `put`; `None` when it is longer than `N`.
fn framed<const N: usize>(
    put: &mut dyn FnMut(u8),
    write: impl FnOnce(&mut Writer<'_>),
) -> Option<()> {
    let mut message = [0; N];
    let mut writer = Writer::new(&mut message);
    write(&mut writer);
    let frame = Frame { dst: 0, src: 0, payload: writer.written()? };
    // The chip's other frames use the same function, so this takes no additional flash.
    link::send(Check::Crc16, &frame, put);
    Some(())
}

#[cfg(test)]
mod tests;

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
