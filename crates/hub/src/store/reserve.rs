//! Room that is kept on the disk of the state, so that a hub can start when everything else has filled it.
//!
//! A running hub goes on with a full disk; one that starts has to write a little. The reserve is a file; each start that
//! finds the disk full cuts a piece off it, and one that finds room makes it whole again.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// The file beside the databases.
pub const RESERVE: &str = "reserve";
/// Its size, and the pieces that are cut off it, bytes. A start writes less than a piece.
pub const RESERVE_BYTES: u64 = 32 << 20;
const PIECE_BYTES: u64 = 4 << 20;
/// What a start has to be able to write, bytes.
const NEEDED_BYTES: usize = 1 << 20;

/// Whether a start needed the reserve.
#[derive(Debug)]
pub enum Room {
    /// There is room.
    Enough,
    /// There is what was cut off the reserve.
    OfReserve,
    /// There is none, not even a reserve; what the system says.
    None(io::Error),
}

/// Sees to it that the hub can write what it has to at its start.
pub fn take(folder: &Path) -> Room {
    make_room(&folder.join(RESERVE), || probe(folder))
}

/// Makes the reserve whole, as far as there is room for it.
pub fn keep(folder: &Path) -> io::Result<()> {
    let path = folder.join(RESERVE);
    super::private(&path)?;
    let mut file = File::options().write(true).open(&path)?;
    let size = file.metadata()?.len();
    if size >= RESERVE_BYTES {
        return Ok(());
    }
    // Written and not only reserved, of bytes that do not compress: so every file system has the room.
    io::Seek::seek(&mut file, io::SeekFrom::Start(size))?;
    let mut piece = vec![0; 1 << 20];
    let mut noise = Noise::default();
    let mut left = RESERVE_BYTES - size;
    while left > 0 {
        noise.fill(&mut piece);
        let part = piece.get(..usize::try_from(left).unwrap_or(usize::MAX).min(piece.len()));
        let part = part.unwrap_or_default();
        if let Err(error) = file.write_all(part) {
            // What the hub itself could have written is not taken from it.
            file.set_len(size)?;
            return Err(error);
        }
        left -= part.len() as u64;
    }
    file.sync_all()
}

fn make_room(reserve: &Path, mut probe: impl FnMut() -> io::Result<()>) -> Room {
    let mut room = Room::Enough;
    while let Err(error) = probe() {
        let full =
            matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded);
        let file = File::options().write(true).open(reserve);
        let size = file.as_ref().ok().and_then(|it| it.metadata().ok()).map_or(0, |it| it.len());
        let cut = |file: File| file.set_len(size.saturating_sub(PIECE_BYTES)).is_ok();
        if !full || size == 0 || !file.is_ok_and(cut) {
            return Room::None(error);
        }
        tracing::warn!(
            left = size.saturating_sub(PIECE_BYTES),
            "the disk is full: the reserve is used"
        );
        room = Room::OfReserve;
    }
    room
}

/// Writes as much as a start does, and removes it.
fn probe(folder: &Path) -> io::Result<()> {
    try_writing(&folder.join("reserve.probe"), NEEDED_BYTES)
}

/// Writes so many bytes to a file, and removes it: on a full disk an empty one can still be made.
pub fn try_writing(path: &Path, len: usize) -> io::Result<()> {
    let written = File::create(path).and_then(|mut file| {
        let mut bytes = vec![0; len];
        Noise::default().fill(&mut bytes);
        file.write_all(&bytes)?;
        file.sync_data()
    });
    let removed = std::fs::remove_file(path);
    written.and(removed)
}

/// Bytes that do not compress: of zeros some file systems store none. By Marsaglia's xorshift.
#[derive(Debug)]
struct Noise(u64);

impl Default for Noise {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl Noise {
    /// Fills a piece with the next bytes.
    fn fill(&mut self, piece: &mut [u8]) {
        for part in piece.chunks_mut(8) {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            part.iter_mut().zip(self.0.to_le_bytes()).for_each(|(to, byte)| *to = byte);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_full_disk_has_room_for_a_start() {
        let folder = std::env::temp_dir().join(format!("lafet-reserve-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let reserve = folder.join(RESERVE);
        let size = || std::fs::metadata(&reserve).map_or(0, |it| it.len());
        assert!(matches!((take(&folder), size()), (Room::Enough, 0)));
        keep(&folder).unwrap();
        assert!(matches!((take(&folder), size()), (Room::Enough, RESERVE_BYTES)));
        let bytes = std::fs::read(&reserve).unwrap();
        let words: HashSet<&[u8]> = bytes.chunks(512).map(|it| &it[..8]).collect();
        assert_eq!(words.len() as u64, RESERVE_BYTES / 512, "no piece of it is like another");
        // Full until a piece is cut off: each start needs one.
        for start in 1..=RESERVE_BYTES / PIECE_BYTES {
            let before = size();
            let full = || match size() < before {
                true => Ok(()),
                false => Err(io::ErrorKind::StorageFull.into()),
            };
            assert!(matches!(make_room(&reserve, full), Room::OfReserve));
            assert_eq!(size(), RESERVE_BYTES - start * PIECE_BYTES);
        }
        let none = make_room(&reserve, || Err(io::ErrorKind::StorageFull.into()));
        assert!(matches!(none, Room::None(_)));
        keep(&folder).unwrap();
        assert_eq!(size(), RESERVE_BYTES, "there is room again");
        let read_only = || Err(io::ErrorKind::ReadOnlyFilesystem.into());
        let none = make_room(&reserve, read_only);
        assert!(
            matches!(none, Room::None(error) if error.kind() == io::ErrorKind::ReadOnlyFilesystem)
        );
        assert_eq!(size(), RESERVE_BYTES);
        let names = std::fs::read_dir(&folder).unwrap().count();
        assert_eq!(names, 1, "nothing else is left");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
