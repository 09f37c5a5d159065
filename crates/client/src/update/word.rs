//! The word that confirms an update: noted on the disk before the monitor gets its digest, so that a sender that is
//! cut off leaves it to the next one; and which word an update has.

use std::io;

use lafet_proto::update::{Phase, Report};

use super::before::Before;
use super::error::UpdateError;
use super::image::Image;
use super::{Updated, Word};
use crate::note::{self, Noted};

/// The reason of a report for a begin while an image is on trial (docs/update.md).
const TRIAL_FIRST: u8 = 18;
/// The first line of a note.
const HEAD: &str = "lafet update 1";

/// A word, and the SHA-256 of the payload of each image that it was made for.
#[derive(Clone, PartialEq, Eq)]
pub struct Kept {
    /// What confirms the image.
    pub word: Word,
    /// The images: one for either slot, or one for each.
    pub images: Vec<[u8; 32]>,
    /// What the monitor was before it was restarted with one of them, from then on.
    pub before: Option<Before>,
}

/// Without the word: it is a secret until the image is confirmed.
impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let images: Vec<String> = self.images.iter().map(|image| hex(image)).collect();
        f.debug_struct("Kept").field("images", &images).finish_non_exhaustive()
    }
}

/// The note of one monitor in a folder.
pub type Note = note::Note<Kept>;

impl Noted for Kept {
    const ENDING: &'static str = "word";
    const SECRET: bool = true;

    fn text(&self) -> String {
        let images: String =
            self.images.iter().map(|image| format!("image {}\n", hex(image))).collect();
        let before = self.before.as_ref().map(|before| format!("before {}\n", before.to_text()));
        let before = before.unwrap_or_default();
        format!("{HEAD}\nword {}\n{before}{images}end\n", hex(&self.word))
    }

    fn parse(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let head = lines.next()? == HEAD;
        let word = unhex(lines.next()?.strip_prefix("word ")?)?;
        let mut lines = lines.peekable();
        let before = match lines.next_if(|line| line.starts_with("before ")) {
            // One that cannot be read is not the same as none.
            Some(line) => Some(Before::parse(line.strip_prefix("before ")?)?),
            None => None,
        };
        let mut images: Vec<&str> = lines.collect();
        let whole = images.pop()? == "end" && head && !images.is_empty();
        let image = |line: &str| unhex(line.strip_prefix("image ")?);
        let images = images.into_iter().map(image).collect::<Option<_>>()?;
        whole.then_some(Self { word, images, before })
    }
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

/// Which word an update has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// That of the update which goes on.
    Noted(Word),
    /// A new one, which has to be noted before anything is sent.
    New {
        /// There is a note that cannot be read, and nothing depends on it.
        damaged: bool,
    },
}

/// Why nothing here confirms what a monitor has committed or on trial. It goes back by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wordless {
    /// It was sent from here, and is none of these images.
    OtherImage,
    /// It was not sent from here.
    Elsewhere,
    /// Its note cannot be read.
    Unreadable,
}

/// Chooses the word for these images, by the monitor's report and by what its note says.
///
/// # Errors
///
/// [`Wordless`]: a new word would confirm nothing, and the note, where there is one, is still needed.
pub fn choose(
    report: &Report,
    images: &[Image],
    noted: &io::Result<Option<Kept>>,
) -> Result<Choice, Wordless> {
    let Report { trial, pending, waits, phase, .. } = *report;
    let goes_to_trial = phase == Phase::COMMITTED || (phase == Phase::VERIFIED && waits);
    let depends = trial || pending || goes_to_trial;
    // A word whose trial has failed was on the line.
    let spent = report.failed && phase == Phase::IDLE && !depends;
    let is_of = |kept: &Kept| images.iter().any(|image| kept.images.contains(&image.digest()));
    match noted {
        Ok(Some(kept)) if is_of(kept) && !spent => Ok(Choice::Noted(kept.word)),
        Ok(Some(_)) if depends => Err(Wordless::OtherImage),
        // A trial that has nothing to go back to takes any image; the monitor knows whether it has.
        Ok(None) if depends && !trial => Err(Wordless::Elsewhere),
        Err(_) if depends => Err(Wordless::Unreadable),
        noted => Ok(Choice::New { damaged: noted.is_err() }),
    }
}

/// Whether an update with a new word was refused as something is on trial that was not sent from here: a trial with
/// nothing to go back to would have been replaced.
pub const fn is_of_others(report: &Report, ended: &Result<Updated, UpdateError>) -> bool {
    report.trial && matches!(ended, Err(UpdateError::Refused(TRIAL_FIRST)))
}

/// Whether nothing depends on the note after this end: the image is confirmed, or the monitor has gone back.
pub const fn is_over(ended: &Result<Updated, UpdateError>) -> bool {
    match ended {
        Ok(_) | Err(UpdateError::AlreadyRunning(_) | UpdateError::WentBack { .. }) => true,
        Err(UpdateError::Changed { back, .. }) => back.is_some(),
        Err(_) => false,
    }
}
