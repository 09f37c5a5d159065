//! The word that confirms an update (docs/update.md), on disk before the monitor gets its digest. A command
//! that is killed in the middle of an update leaves it to the next one.

use std::io;

use lafet_client::note::{self, Noted};
use lafet_client::update::Word;
use lafet_texts::cli as text;

use crate::failure::Failure;
use crate::lang::current;

/// The first line of a note.
const HEAD: &str = "lafet update 1";

/// A word, and the SHA-256 of the payload of each image that it was made for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// What confirms the image.
    pub word: Word,
    /// The images: one for either slot, or one for each.
    pub images: Vec<[u8; 32]>,
}

/// The note of one monitor in a folder.
pub type Note = note::Note<Kept>;

impl Noted for Kept {
    const ENDING: &'static str = "word";
    const SECRET: bool = true;

    fn text(&self) -> String {
        let images: String =
            self.images.iter().map(|image| format!("image {}\n", hex(image))).collect();
        format!("{HEAD}\nword {}\n{images}end\n", hex(&self.word))
    }

    fn parse(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let head = lines.next()? == HEAD;
        let word = unhex(lines.next()?.strip_prefix("word ")?)?;
        let mut images: Vec<&str> = lines.collect();
        let whole = images.pop()? == "end" && head && !images.is_empty();
        let image = |line: &str| unhex(line.strip_prefix("image ")?);
        let images = images.into_iter().map(image).collect::<Option<_>>()?;
        whole.then_some(Self { word, images })
    }
}

/// Random bytes of the system, good for keys.
pub fn random<const N: usize>() -> Result<[u8; N], Failure> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| {
        let error = io::Error::other(error.to_string());
        Failure::io(text::NoRandomBytes.str(current()), error)
    })?;
    Ok(bytes)
}

/// Two digits for each byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// So many bytes of two digits each, with nothing between and around them.
pub fn unhex<const N: usize>(text: &str) -> Option<[u8; N]> {
    if text.len() != 2 * N || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let mut bytes = [0; N];
    for (index, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * index..2 * index + 2)?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_note_is_read_as_written_or_not_at_all() {
        let kept = Kept { word: [0xA5; 16], images: vec![[1; 32], [0xFE; 32]] };
        let text = kept.text();
        assert_eq!(Kept::parse(&text), Some(kept.clone()));
        for end in 0..text.len() - 1 {
            assert_eq!(Kept::parse(&text[..end]), None, "{end}");
        }
        assert_eq!(Kept::parse(&text.replace("a5a5", "a5+5")), None);
        let folder = std::env::temp_dir().join(format!("lafet-word-{}", std::process::id()));
        let note = Note::new(&folder, "tcp-::1-10485-1/..");
        assert_eq!(note.file().parent(), Some(folder.as_path()));
        assert_eq!(note.read().unwrap(), None);
        note.write(&kept).unwrap();
        assert_eq!(note.read().unwrap(), Some(kept));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            let mode = fs::metadata(note.file()).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
        fs::write(note.file(), "lafet update 2\n").unwrap();
        assert_eq!(note.read().unwrap_err().kind(), io::ErrorKind::InvalidData);
        note.remove().unwrap();
        note.remove().unwrap();
        assert_eq!(note.read().unwrap(), None);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn words_differ() {
        assert_ne!(random::<16>().unwrap(), random::<16>().unwrap());
    }
}
