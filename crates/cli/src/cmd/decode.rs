//! `lafet decode`: captured bytes as text.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_capture::Format;

use super::replay::pieces;
use lafet_proto::link::{PAYLOAD_MAX, decode_datagram};
use lafet_texts::{Shown, Text as _, cli as text};

use crate::decode::{Form, Unhex, Writer};
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;
use crate::texts;

/// Byte before a frame, `FF C0 … C0` (§L).
const SYNC: u8 = 0xFF;
/// Byte that begins and ends a frame.
const END: u8 = 0xC0;
/// Bytes read at a time.
const CHUNK: usize = 64 * 1024;

/// Arguments of `lafet decode`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet decode \"ff c0 01 81 9d c8 00 02 fe 23 4d 2b c0\"\n  \
                        lafet decode 9dc80002fe23\n  \
                        lafet decode capture.bin --json\n  \
                        nc 127.0.0.1 10485 | lafet decode")]
pub struct DecodeArgs {
    #[arg(value_name = "HEX|FILE")]
    input: Vec<String>,
    #[arg(short, long, value_name = "FILE", conflicts_with = "input")]
    file: Option<PathBuf>,
    #[arg(long)]
    raw: bool,
    #[arg(short, long)]
    quiet: bool,
}

/// Runs `lafet decode`.
pub fn run(args: &DecodeArgs, out: &mut Out) -> Outcome {
    let stdout = io::stdout().lock();
    let form = match () {
        () if args.quiet => Form::Nothing,
        () if out.json() => Form::Json,
        () => Form::Text,
    };
    let mut writer = Writer::new(BufWriter::with_capacity(CHUNK, stdout), form);
    if let Some(bytes) = bytes_given(&args.input)? {
        let mut trial = Writer::new(io::sink(), Form::Nothing);
        trial.feed(&bytes)?;
        if trial.frames() > 0 {
            writer.feed(&bytes)?;
        } else if !writer.bare_records(&bytes)? {
            return Err(broken_frame(&bytes).unwrap_or_else(no_frame));
        }
    } else {
        let path = args.file.clone().or_else(|| args.input.first().map(PathBuf::from));
        if let Some(path) = path.as_ref().filter(|path| is_recording(path)) {
            for piece in pieces(path)? {
                writer.feed(&piece.bytes)?;
            }
            return end(writer, out);
        }
        let live = path.is_none() && !io::stdin().is_terminal();
        let mut input: Box<dyn Read> = match &path {
            Some(path) => Box::new(File::open(path).map_err(|error| cannot_read(path, error))?),
            None => Box::new(io::stdin().lock()),
        };
        stream(&mut input, &mut writer, args.raw, live)?;
        if writer.bytes() > 0 && writer.frames() == 0 {
            writer.flush()?;
            return Err(no_frame());
        }
    }
    end(writer, out)
}

fn end(writer: Writer<impl Write>, out: &mut Out) -> Outcome {
    let summary = writer.finish()?;
    if out.json() { out.value(&summary.json()) } else { tell(&summary.text()) }
}

/// Whether a file is a recording of `lafet record`.
fn is_recording(path: &Path) -> bool {
    let mut first = [0; 5];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    read.is_ok() && Format::of_bytes(&first).is_some()
}

/// Prints the counters to standard error: they are about the output, not part of it.
fn tell(summary: &str) -> Outcome {
    writeln!(io::stderr(), "{summary}")?;
    Ok(())
}

/// The bytes that the arguments spell; `None` when they name a file, or there are none.
fn bytes_given(input: &[String]) -> Result<Option<Vec<u8>>, Failure> {
    if input.is_empty() || input == ["-"] {
        return Ok(None);
    }
    let text = input.join(" ");
    let mut bytes = Vec::new();
    let mut unhex = Unhex::default();
    match unhex.feed(text.as_bytes(), &mut bytes).and_then(|()| unhex.finish()) {
        Ok(()) => Ok(Some(bytes)),
        Err(_) if input.len() == 1 && PathBuf::from(&text).exists() => Ok(None),
        Err(_) => Err(Failure::Usage(text::NeitherHexNorFile { text }.of(current()))),
    }
}

fn stream(input: &mut dyn Read, writer: &mut Writer<impl Write>, raw: bool, live: bool) -> Outcome {
    let mut chunk = vec![0; CHUNK];
    let mut bytes = Vec::new();
    let mut unhex = None;
    let mut first = true;
    loop {
        let count = input.read(&mut chunk)?;
        let part = &chunk[..count];
        if count == 0 {
            break;
        }
        if std::mem::take(&mut first) && !raw && Unhex::looks_like(part) {
            unhex = Some(Unhex::default());
        }
        match &mut unhex {
            None => writer.feed(part)?,
            Some(unhex) => {
                bytes.clear();
                unhex.feed(part, &mut bytes).map_err(not_hex)?;
                writer.feed(&bytes)?;
            }
        }
        if live {
            // The input may be a live line with a user watching.
            writer.flush()?;
        }
    }
    match unhex {
        Some(unhex) => unhex.finish().map_err(not_hex),
        None => Ok(()),
    }
}

fn not_hex(offset: u64) -> Failure {
    Failure::Usage(text::HexEnds { offset }.of(current()))
}

fn cannot_read(path: &std::path::Path, error: io::Error) -> Failure {
    let path = path.display();
    Failure::io(text::CannotRead { path: Shown(path) }.of(current()), error)
}

/// What is wrong with the first frame in these bytes, if they contain the outline of one.
fn broken_frame(bytes: &[u8]) -> Option<Failure> {
    let is_end = |at: &usize| bytes[*at] == END;
    let from = (0..bytes.len()).find(is_end)?;
    let to = (from + 1..bytes.len()).find(is_end)?;
    let datagram: Vec<u8> = [SYNC].iter().chain(&bytes[from..=to]).copied().collect();
    let error = decode_datagram(&datagram, &mut [0; PAYLOAD_MAX + 8]).err()?;
    let offset = from.saturating_sub(1);
    let why = texts::decode_error(&error);
    Some(Failure::Usage(text::FrameBroken { offset, why }.of(current())))
}

fn no_frame() -> Failure {
    Failure::Usage(text::NoFrame.str(current()).into())
}
