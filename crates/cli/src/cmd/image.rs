//! `lafet image key|public|sign|show`: keys and signed images for an update (docs/update.md).

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use lafet_client::update::FILE_MAX;
use lafet_texts::{Fixed, Shown, Text as _, cli as text};
use lafet_update::{
    Board, BoardName, HEADER_LEN, Hash, Header, Layouts, PublicKey, Refusal, SigningKey, Slot,
    UNIT, Version,
};
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::{Out, columns};
use crate::word::{hex, random, unhex};

/// Bytes of a key.
const KEY_LEN: usize = 32;
/// How the line of a public key begins.
const PUBLIC: &str = "lafet public key ";
/// No file of an image is longer, bytes.
const LONGEST: u64 = FILE_MAX as u64;

/// Subcommands of `lafet image`.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  lafet image key key0\n  \
                        lafet image public 0 key0 key0.pub\n  \
                        lafet image show program.b.image --public 0=key0.pub")]
pub enum ImageCommand {
    #[command(after_help = "Examples:\n  lafet image key key0")]
    Key(KeyArgs),
    #[command(after_help = "Examples:\n  lafet image public 0 key0\n  \
                            lafet image public 0 key0 key0.pub")]
    Public(PublicArgs),
    #[command(
        after_help = "Examples:\n  lafet image sign --key 0=key0 --board my-board --version 1.2 \
                      --slot b --layouts 1-1 program.b.bin program.b.image\n  \
                      lafet image sign --key 1=key1 --board my-board --version 1.3 --revokes 0 \
                      --layouts 1-2 program.bin program.image"
    )]
    Sign(SignArgs),
    #[command(after_help = "Examples:\n  lafet image show program.b.image\n  \
                            lafet image show program.b.image --public 0=key0.pub")]
    Show(ShowArgs),
}

/// Arguments of `lafet image key`.
#[derive(Debug, Args)]
pub struct KeyArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Arguments of `lafet image public`.
#[derive(Debug, Args)]
pub struct PublicArgs {
    #[arg(value_name = "N", value_parser = clap::value_parser!(u8).range(0..=15))]
    id: u8,
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(value_name = "OUT")]
    out: Option<PathBuf>,
}

/// Arguments of `lafet image sign`.
#[derive(Debug, Args)]
pub struct SignArgs {
    #[arg(value_name = "PROGRAM")]
    program: PathBuf,
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    #[arg(long, value_name = "N=FILE", value_parser = numbered)]
    key: Numbered,
    #[arg(long, value_name = "BOARD", value_parser = board)]
    board: BoardName,
    #[arg(long, value_name = "VERSION", value_parser = version)]
    version: Version,
    #[arg(long, value_name = "SLOT")]
    slot: Option<Place>,
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=15))]
    revokes: Vec<u8>,
    #[arg(long, value_name = "LAYOUTS", value_parser = layouts)]
    layouts: Layouts,
}

/// Arguments of `lafet image show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    #[arg(long, value_name = "N=FILE", value_parser = numbered)]
    public: Option<Numbered>,
}

/// The slot that a program is linked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Place {
    A,
    B,
}

/// The file of a key, and the number that the board knows it by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbered {
    id: u8,
    file: PathBuf,
}

/// Parses `0=key0`.
pub fn numbered(text: &str) -> Result<Numbered, String> {
    let parts = text.split_once('=').filter(|(_, file)| !file.is_empty());
    let parsed: Option<(u8, PathBuf)> =
        parts.and_then(|(id, file)| Some((id.parse().ok()?, file.into())));
    match parsed {
        Some((id, file)) if id < 16 => Ok(Numbered { id, file }),
        _ => Err(text::NumberedKeyExpected.str(current()).into()),
    }
}

/// Parses the name of a board.
pub fn board(text: &str) -> Result<BoardName, String> {
    BoardName::new(text).ok_or_else(|| text::BoardNameExpected.str(current()).into())
}

/// Parses a version: `1.2`, `1.2.3.4`.
pub fn version(text: &str) -> Result<Version, String> {
    text.parse().map_err(|_| text::ImageVersionExpected.str(current()).into())
}

fn layouts(text: &str) -> Result<Layouts, String> {
    let number = |text: &str| text.parse::<u16>().ok();
    let parts = text.split_once('-');
    let parsed = parts.and_then(|(oldest, newest)| Some((number(oldest)?, number(newest)?)));
    match parsed {
        Some((oldest, newest)) if oldest <= newest => Ok(Layouts { oldest, newest }),
        _ => Err(text::LayoutsExpected.str(current()).into()),
    }
}

/// Runs `lafet image`.
pub fn run(command: &ImageCommand, out: &mut Out) -> Outcome {
    match command {
        ImageCommand::Key(args) => key(args, out),
        ImageCommand::Public(args) => public(args, out),
        ImageCommand::Sign(args) => sign(args, out),
        ImageCommand::Show(args) => show(args, out),
    }
}

fn key(args: &KeyArgs, out: &mut Out) -> Outcome {
    write_new(&args.file, &random::<KEY_LEN>()?, true)?;
    let file = args.file.display().to_string();
    out.show(text::KeyMade { file: &file }.of(current()), || json!({ "file": file }))
}

fn public(args: &PublicArgs, out: &mut Out) -> Outcome {
    let public = signing(args.id, &args.file)?.public();
    let PublicKey { id, bytes } = public;
    let line = format!("{PUBLIC}{id} {}", hex(&bytes));
    // The second line is for the source of the board's programs.
    let text = format!("{line}\nPublicKey {{ id: {id}, bytes: {bytes:?} }},");
    if let Some(file) = &args.out {
        write_new(file, format!("{text}\n").as_bytes(), false)?;
    }
    let file = args.out.as_ref().map(|file| file.display().to_string());
    out.show(text, || json!({ "key": id, "public": hex(&bytes), "file": file }))
}

fn sign(args: &SignArgs, out: &mut Out) -> Outcome {
    let key = signing(args.key.id, &args.key.file)?;
    let mut payload = read(&args.program)?;
    payload.resize(payload.len().next_multiple_of(UNIT), 0xFF);
    let header = Header {
        size: 0,
        version: args.version,
        board: args.board,
        place: args.slot.map(|slot| if slot == Place::A { Slot::A } else { Slot::B }),
        key: 0,
        revokes: args.revokes.iter().fold(0, |bits, key| bits | (1_u16 << *key)),
        layouts: args.layouts,
        hash: Hash::default(),
    };
    let raw = key.sign(&header, &payload).map_err(|why| wrong(&args.program, why))?;
    let header = Header::parse(&raw).map_err(|why| wrong(&args.program, why))?;
    write_new(&args.image, &[raw.as_slice(), payload.as_slice()].concat(), false)?;
    let (payload, signature) = (Payload::Whole, Signature::Right);
    out.show(table(&header, signature), || fields(&args.image, &header, payload, signature))
}

fn show(args: &ShowArgs, out: &mut Out) -> Outcome {
    let bytes = read(&args.image)?;
    let (raw, payload) = bytes
        .split_first_chunk::<HEADER_LEN>()
        .ok_or_else(|| wrong(&args.image, Refusal::NotAnImage))?;
    let header = Header::parse(raw).map_err(|why| wrong(&args.image, why))?;
    let payload = Payload::of(&header, payload);
    let signature = match &args.public {
        None => Signature::Unchecked,
        Some(public) => Signature::of(raw, &header, public_key(public)?),
    };
    out.show(table(&header, signature), || fields(&args.image, &header, payload, signature))?;
    let file = args.image.display().to_string();
    let wrong = match (payload, signature) {
        (Payload::Cut { is }, _) => {
            Some(text::ImageCut { file, is, size: header.size }.of(current()))
        }
        (Payload::Changed, _) => Some(text::ImageChanged { file }.of(current())),
        (_, Signature::Wrong) => {
            Some(text::ImageSignatureWrong { file, key: header.key }.of(current()))
        }
        (_, Signature::OtherKey { given }) => {
            Some(text::ImageOtherKey { file, key: header.key, given }.of(current()))
        }
        _ => None,
    };
    wrong.map_or(Ok(()), |why| Err(Failure::Ended(why)))
}

/// Whether the payload is what the header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Payload {
    Whole,
    /// It has another size than the header says, bytes.
    Cut {
        is: usize,
    },
    Changed,
}

impl Payload {
    fn of(header: &Header, payload: &[u8]) -> Self {
        let is = payload.len();
        match u32::try_from(is) {
            Ok(size) if size == header.size && Hash::of(payload) == header.hash => Self::Whole,
            Ok(size) if size == header.size => Self::Changed,
            _ => Self::Cut { is },
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Cut { .. } => "cut",
            Self::Changed => "changed",
        }
    }
}

/// What is known of the signature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Signature {
    Unchecked,
    Right,
    Wrong,
    /// The image is signed with a key of another number than the one that was given.
    OtherKey {
        given: u8,
    },
}

impl Signature {
    fn of(raw: &[u8; HEADER_LEN], header: &Header, public: PublicKey) -> Self {
        let board = Board { name: header.board, keys: &[public] };
        match Header::check(raw, &board, 0) {
            Ok(_) => Self::Right,
            Err(Refusal::UnknownKey) => Self::OtherKey { given: public.id },
            Err(_) => Self::Wrong,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Unchecked => "unchecked",
            Self::Right => "right",
            Self::Wrong => "wrong",
            Self::OtherKey { .. } => "other-key",
        }
    }

    const fn words(self) -> Fixed {
        match self {
            Self::Unchecked => text::ImageSignatureUnchecked.fixed(),
            Self::Right => text::ImageSignatureRight.fixed(),
            Self::Wrong => text::ImageSignatureBad.fixed(),
            Self::OtherKey { .. } => text::ImageSignatureOther.fixed(),
        }
    }
}

/// All that a header says.
fn table(header: &Header, signature: Signature) -> String {
    let words = |text: Fixed| text.str(current()).to_owned();
    let slot = match header.place {
        None => words(text::ImageSlotEither.fixed()),
        Some(Slot::A) => "A".to_owned(),
        Some(Slot::B) => "B".to_owned(),
    };
    let revokes: Vec<String> = revoked(header).iter().map(ToString::to_string).collect();
    let revokes = if revokes.is_empty() { "—".to_owned() } else { revokes.join(", ") };
    let Layouts { oldest, newest } = header.layouts;
    let rows = [
        (text::ImageBoard.fixed(), header.board.as_str().to_owned()),
        (text::ImageVersion.fixed(), header.version.to_string()),
        (text::ImageSize.fixed(), header.size.to_string()),
        (text::ImageSlot.fixed(), slot),
        (text::ImageKey.fixed(), header.key.to_string()),
        (text::ImageRevokes.fixed(), revokes),
        (text::ImageLayouts.fixed(), format!("{oldest}-{newest}")),
        (text::ImageHash.fixed(), header.hash.to_string()),
        (text::ImageSignature.fixed(), words(signature.words())),
    ];
    columns(&rows.map(|(title, value)| vec![words(title), value]))
}

fn fields(file: &Path, header: &Header, payload: Payload, signature: Signature) -> Value {
    let slot = header.place.map(|slot| if slot == Slot::A { "A" } else { "B" });
    json!({
        "file": file.display().to_string(),
        "board": header.board.as_str(),
        "version": header.version.to_string(),
        "size": header.size,
        "slot": slot,
        "key": header.key,
        "revokes": revoked(header),
        "layouts": { "oldest": header.layouts.oldest, "newest": header.layouts.newest },
        "sha256": header.hash.to_string(),
        "payload": payload.name(),
        "signature": signature.name(),
    })
}

/// The numbers of the keys that an image revokes.
fn revoked(header: &Header) -> Vec<u8> {
    (0..16).filter(|key| header.revokes & (1 << *key) != 0).collect()
}

/// The public key in a file of `lafet image public`.
pub fn public_key(of: &Numbered) -> Result<PublicKey, Failure> {
    let bytes = read(&of.file)?;
    let text = String::from_utf8_lossy(&bytes);
    let file = of.file.display().to_string();
    let line = text.lines().find_map(|line| line.strip_prefix(PUBLIC)?.split_once(' '));
    let parsed: Option<(u8, [u8; KEY_LEN])> =
        line.and_then(|(id, key)| Some((id.parse().ok()?, unhex(key.trim_end())?)));
    match parsed {
        Some((id, bytes)) if id == of.id => Ok(PublicKey { id, bytes }),
        Some((id, _)) => {
            Err(Failure::Usage(text::PublicKeyOther { file, id, given: of.id }.of(current())))
        }
        None => Err(Failure::Usage(text::PublicKeyNotOne { file }.of(current()))),
    }
}

/// The private key in a file of `lafet image key`.
fn signing(id: u8, file: &Path) -> Result<SigningKey, Failure> {
    let seed: [u8; KEY_LEN] = read(file)?.try_into().map_err(|other: Vec<u8>| {
        let (file, is) = (Shown(file.display()), other.len());
        Failure::Usage(text::KeyNotOne { file, is }.of(current()))
    })?;
    Ok(SigningKey::new(id, seed))
}

/// A whole file, unless it is longer than any image.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let failed = |error| {
        let what = text::CannotRead { path: Shown(path.display()) }.of(current());
        Failure::io(what, error)
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(failed)?;
    match u64::try_from(bytes.len()) {
        Ok(len) if len <= LONGEST => Ok(bytes),
        _ => {
            let (file, mib) = (Shown(path.display()), LONGEST >> 20);
            Err(Failure::Usage(text::ImageTooLong { file, mib }.of(current())))
        }
    }
}

/// Never over a file that exists: a key that is lost that way is lost for ever. What could not be written whole
/// is removed.
fn write_new(path: &Path, bytes: &[u8], secret: bool) -> Outcome {
    let failed = |error: io::Error| {
        let name = path.display().to_string();
        match error.kind() {
            io::ErrorKind::AlreadyExists => {
                Failure::Usage(text::NeverWrittenOver { name }.of(current()))
            }
            _ => Failure::io(text::CannotWriteFile { name }.of(current()), error),
        }
    };
    let mut options = File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if secret {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    #[cfg(not(unix))]
    let _ = secret;
    let mut file = options.open(path).map_err(failed)?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|error| {
        // It is of no use to anyone.
        let _ = fs::remove_file(path);
        failed(error)
    })
}

/// What is wrong with an image or with what it would be made of.
fn wrong(path: &Path, why: Refusal) -> Failure {
    let file = path.display().to_string();
    Failure::Usage(match why {
        Refusal::NotAnImage => text::ImageNotOne { file }.of(current()),
        Refusal::Format => text::ImageOtherFormat { file }.of(current()),
        Refusal::Size => text::ImageEmpty { file }.of(current()),
        Refusal::RevokesItself => text::ImageRevokesItself.str(current()).into(),
        _ => text::ImageMalformed { file }.of(current()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments() {
        assert_eq!(numbered("15=a=b"), Ok(Numbered { id: 15, file: "a=b".into() }));
        for wrong in ["16=a", "=a", "1=", "1", "a=1", "256=a"] {
            assert!(numbered(wrong).is_err(), "{wrong}");
        }
        assert_eq!(layouts("1-2"), Ok(Layouts { oldest: 1, newest: 2 }));
        for wrong in ["1", "2-1", "1-", "1-65536", "1-2-3"] {
            assert!(layouts(wrong).is_err(), "{wrong}");
        }
        assert!(board("my-board").is_ok() && board("").is_err() && board("my board").is_err());
        assert_eq!(version("1.2"), Ok(Version([1, 2, 0, 0])));
        assert!(version("1.2.3.4.5").is_err() && version("1.x").is_err());
    }
}
