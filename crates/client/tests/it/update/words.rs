//! Which word an update has, and the note of it.

use std::{fs, io};

use lafet_client::note::Noted as _;
use lafet_client::update::{
    Before, Choice, Image, Kept, Note, UpdateError, Updated, Wordless, choose, is_over,
};
use lafet_proto::update::{Phase, Report};

use super::model::{NEW, OLD, file, payload};

fn image(len: usize) -> Image {
    Image::read(&file(NEW, 0, &payload(len))).unwrap()
}

fn kept(image: &Image) -> Kept {
    Kept { word: [0xA5; 16], images: vec![image.digest()], before: None }
}

#[test]
fn a_note_is_read_as_written_or_not_at_all() {
    let before = Before::parse("00:00040000 12:00000000").unwrap();
    let images = vec![[1; 32], [0xFE; 32]];
    let without = Kept { word: [0xA5; 16], images, before: None };
    let kept = Kept { before: Some(before), ..without.clone() };
    for kept in [&without, &kept] {
        let text = kept.text();
        assert_eq!(Kept::parse(&text).as_ref(), Some(kept));
        for end in 0..text.len() - 1 {
            assert_eq!(Kept::parse(&text[..end]), None, "{end}");
        }
        assert_eq!(Kept::parse(&text.replace("a5a5", "a5+5")), None);
        assert!(!format!("{kept:?}").contains("a5a5"), "a log shows no word");
    }
    // One that is damaged is not the same as none, nor is one in another place.
    for wrong in
        ["before ", "before 00:0004000", "before 00", "before 0:00040000", "before 00:00040000 "]
    {
        let text = kept.text().replace("before 00:00040000 12:00000000", wrong);
        assert_eq!(Kept::parse(&text), None, "{wrong}");
    }
    let behind = format!("{}before 00:00040000\n", without.text());
    assert_eq!(Kept::parse(&behind), None);
    let many = vec!["00:00000000"; 33].join(" ");
    assert_eq!(Before::parse(&many), None, "no monitor has so many");
    assert!(kept.text().len() < 4096);
    let folder = std::env::temp_dir().join(format!("lafet-client-word-{}", std::process::id()));
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

/// In every state of a monitor a word of before is kept if the monitor may need it, and only then.
#[test]
fn the_word_of_an_update_that_goes_on() {
    let (own, other) = (image(800), image(88));
    for bits in 0..2_u8.pow(7) {
        let bit = |at: u8| bits >> at & 1 != 0;
        let phase = Phase(bits >> 4 & 7);
        let version = if bits & 1 != 0 { NEW } else { OLD };
        let (trial, failed, waits, pending) = (bit(1), bit(2), bit(3), bit(0));
        let report =
            Report { phase, trial, failed, waits, pending, version, slot: 1, ..Report::default() };
        let needed = trial || pending || phase == Phase::COMMITTED || (phase.0 == 3 && waits);
        let spent = failed && phase == Phase::IDLE && !needed;
        let chosen =
            |noted: io::Result<Option<Kept>>| choose(&report, std::slice::from_ref(&own), &noted);
        let fresh = Ok(Choice::New { damaged: false });

        let noted = if spent { fresh } else { Ok(Choice::Noted([0xA5; 16])) };
        assert_eq!(chosen(Ok(Some(kept(&own)))), noted, "{report:?}");
        let of_other = if needed { Err(Wordless::OtherImage) } else { fresh };
        assert_eq!(chosen(Ok(Some(kept(&other)))), of_other, "{report:?}");
        // What is on trial with nothing to go back to takes another image: the monitor decides.
        let elsewhere = needed && !trial;
        let none = if elsewhere { Err(Wordless::Elsewhere) } else { fresh };
        assert_eq!(chosen(Ok(None)), none, "{report:?}");
        let damaged = match needed {
            true => Err(Wordless::Unreadable),
            false => Ok(Choice::New { damaged: true }),
        };
        assert_eq!(chosen(Err(io::ErrorKind::InvalidData.into())), damaged, "{report:?}");
    }
}

#[test]
fn a_note_goes_when_nothing_depends_on_it() {
    let went_back = UpdateError::WentBack { wanted: NEW, running: OLD, lived: true };
    for over in [
        Ok(Updated { from: OLD, to: NEW }),
        Err(UpdateError::AlreadyRunning(NEW)),
        Err(went_back),
        Err(UpdateError::Changed { what: Vec::new(), back: Some(OLD) }),
    ] {
        assert!(is_over(&over), "{over:?}");
    }
    for goes_on in [
        UpdateError::Changed { what: Vec::new(), back: None },
        UpdateError::Client(lafet_client::Error::Closed),
        UpdateError::Silent(lafet_client::Error::Closed),
        UpdateError::NotReady(Vec::new()),
        UpdateError::Stalled { done: 8, size: 16 },
        UpdateError::Refused(21),
    ] {
        assert!(!is_over(&Err(goes_on.clone())), "{goes_on:?}");
    }
}
