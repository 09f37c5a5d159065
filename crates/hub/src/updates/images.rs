//! The images that the hub stores: files in the folder of the data, or without one in memory.
//!
//! An image is checked when it comes and when it is used. At the start of the hub its header alone is read.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use lafet_client::update::{FILE_MAX, Image, ImageError, unhex};
use lafet_proto::update::{HEADER_LEN, ImageHeader};
use lafet_texts::{Argument, Lang};

use super::view::StoredImage;
use crate::hub::room;
use crate::store::replace;
use crate::store::reserve::RESERVE_BYTES;
use crate::sync::lock;

/// Images that are stored at a time.
pub const IMAGES_MAX: usize = 8;
/// Folder of the images, in that of the data.
const FOLDER: &str = "updates/images";
/// Endings of an image, of what is known of it, and of one that is not whole yet.
const IMAGE: &str = "image";
const ABOUT: &str = "json";
const NEW: &str = "new";
/// What is known of an image is no longer, bytes.
const ABOUT_MAX: u64 = 4096;

/// The stored images.
#[derive(Debug)]
pub struct Images {
    folder: Option<PathBuf>,
    all: Mutex<Vec<Held>>,
}

/// An image.
#[derive(Clone, Debug)]
struct Held {
    about: StoredImage,
    header: [u8; HEADER_LEN],
    /// Itself, where there is no folder.
    image: Option<Arc<Image>>,
}

/// What became of an image that came.
#[derive(Debug)]
pub enum Put {
    /// It is stored.
    New(StoredImage),
    /// It was stored already.
    Known(StoredImage),
    /// Its payload is that of this one, whose header differs.
    Differs(StoredImage),
    /// There are [`IMAGES_MAX`].
    Full,
}

/// Why a stored image cannot be used.
#[derive(Debug)]
pub enum Unusable {
    /// The disk.
    Io(io::Error),
    /// What it has become.
    Image(ImageError),
}

impl Argument for Unusable {
    fn write(&self, lang: Lang, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        match self {
            Self::Io(error) => {
                lafet_client::SystemError(error).write(lang, out)?;
                out.write_char('.')
            }
            Self::Image(error) => error.write(lang, out),
        }
    }
}

impl Images {
    /// Those of a folder of data; a folder that cannot be read has none.
    pub fn open(data: Option<&Path>) -> Self {
        let folder = data.map(|data| data.join(FOLDER));
        let mut all = folder.as_deref().map(read_all).unwrap_or_default();
        all.sort_by_key(|it| it.about.at_ms);
        Self { folder, all: Mutex::new(all) }
    }

    /// All, in the order in which they came.
    pub fn list(&self) -> Vec<StoredImage> {
        lock(&self.all).iter().map(|it| it.about.clone()).collect()
    }

    /// The one with this digest.
    fn held(&self, digest: &str) -> Option<Held> {
        lock(&self.all).iter().find(|it| it.about.digest == digest).cloned()
    }

    /// The image with this digest, as it was when it came; `None`: there is none. Waits for the disk.
    ///
    /// # Errors
    ///
    /// [`Unusable`].
    pub fn load(&self, digest: &str) -> Result<Option<Image>, Unusable> {
        let Some(held) = self.held(digest) else { return Ok(None) };
        let (None, Some(folder)) = (&held.image, &self.folder) else {
            return Ok(held.image.map(Arc::unwrap_or_clone));
        };
        let file = File::open(path(folder, digest, IMAGE)).map_err(Unusable::Io)?;
        let mut bytes = Vec::new();
        file.take(FILE_MAX as u64 + 1).read_to_end(&mut bytes).map_err(Unusable::Io)?;
        let image = Image::read(&bytes).map_err(Unusable::Image)?;
        match *image.header() == held.header {
            true => Ok(Some(image)),
            false => Err(Unusable::Image(ImageError::Digest)),
        }
    }

    /// Stores an image, as long as there is place for it. Waits for the disk; of two calls at once the second has to
    /// wait for the first.
    ///
    /// # Errors
    ///
    /// A disk that takes nothing, or has no room but for what the hub itself has to write.
    pub fn put(&self, image: Image, by: &str, at_ms: u64) -> io::Result<Put> {
        let about = StoredImage::of(image.says(), by.to_owned(), at_ms);
        if let Some(held) = self.held(&about.digest) {
            let same = held.header == *image.header();
            return Ok(if same { Put::Known(held.about) } else { Put::Differs(held.about) });
        }
        if lock(&self.all).len() >= IMAGES_MAX {
            return Ok(Put::Full);
        }
        let header = *image.header();
        let image = match &self.folder {
            None => Some(Arc::new(image)),
            Some(folder) => {
                write(folder, &about, &image)?;
                None
            }
        };
        lock(&self.all).push(Held { about: about.clone(), header, image });
        Ok(Put::New(about))
    }

    /// Removes an image; the one that was removed. Waits for the disk.
    ///
    /// # Errors
    ///
    /// A file that cannot be removed: the image stays.
    pub fn remove(&self, digest: &str) -> io::Result<Option<StoredImage>> {
        let Some(held) = self.held(digest) else { return Ok(None) };
        if let Some(folder) = &self.folder {
            match fs::remove_file(path(folder, digest, IMAGE)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
            // Without its image it says nothing.
            _ = fs::remove_file(path(folder, digest, ABOUT));
        }
        lock(&self.all).retain(|it| it.about.digest != digest);
        Ok(Some(held.about))
    }
}

fn path(folder: &Path, digest: &str, ending: &str) -> PathBuf {
    folder.join(format!("{digest}.{ending}"))
}

/// Whether it can be the digest of an image, and nothing else.
fn is_digest(text: &str) -> bool {
    unhex::<32>(text).is_some() && !text.bytes().any(|byte| byte.is_ascii_uppercase())
}

/// Writes an image and what is known of it. There is an image when its own file is whole.
fn write(folder: &Path, about: &StoredImage, image: &Image) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    if room(folder).is_some_and(|(free, _)| !has_room(free, image)) {
        return Err(io::ErrorKind::StorageFull.into());
    }
    let told = serde_json::to_vec(about)?;
    let (beside, about) = (path(folder, &about.digest, NEW), path(folder, &about.digest, ABOUT));
    replace(&about, &beside, &told)?;
    let bytes = [&image.header()[..], image.payload()].concat();
    let written = replace(&about.with_extension(IMAGE), &beside, &bytes);
    if written.is_err() {
        _ = fs::remove_file(about);
    }
    written
}

/// Whether an image leaves the disk what the hub itself has to write.
fn has_room(free: u64, image: &Image) -> bool {
    free >= 2 * RESERVE_BYTES + (HEADER_LEN as u64) + u64::from(image.size())
}

/// The images of a folder; what a hub that was killed has not finished is removed.
fn read_all(folder: &Path) -> Vec<Held> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut all = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        let ending = path.extension().and_then(|it| it.to_str()).unwrap_or_default();
        let digest = path.file_stem().and_then(|it| it.to_str()).unwrap_or_default();
        match ending {
            _ if !is_digest(digest) => {}
            NEW => _ = fs::remove_file(&path),
            IMAGE if all.len() < IMAGES_MAX => match read(&path, digest) {
                Ok(held) => all.push(held),
                Err(error) => {
                    tracing::warn!(file = %path.display(), %error, "an image cannot be used");
                }
            },
            IMAGE => tracing::warn!(file = %path.display(), "there are too many images"),
            _ => {}
        }
    }
    all
}

/// What the header of an image file says, and what was noted of it.
fn read(path: &Path, digest: &str) -> io::Result<Held> {
    let wrong = || io::Error::from(io::ErrorKind::InvalidData);
    let mut file = File::open(path)?;
    let mut header = [0; HEADER_LEN];
    file.read_exact(&mut header)?;
    let says = ImageHeader::parse(&header).map_err(|_| wrong())?;
    let whole = HEADER_LEN as u64 + u64::from(says.size);
    if unhex(digest) != Some(says.digest) || file.metadata()?.len() != whole {
        return Err(wrong());
    }
    let mut told = Vec::new();
    if let Ok(file) = File::open(path.with_extension(ABOUT)) {
        file.take(ABOUT_MAX).read_to_end(&mut told)?;
    }
    let told: Option<StoredImage> = serde_json::from_slice(&told).ok();
    let (by, at_ms) = told.map(|it| (it.by, it.at_ms)).unwrap_or_default();
    Ok(Held { about: StoredImage::of(&says, by, at_ms), header, image: None })
}

#[cfg(test)]
mod tests {
    use super::super::samples;
    use super::*;

    /// A folder of data that goes with the test.
    struct Data(PathBuf);

    impl Data {
        fn new(name: &str) -> Self {
            let name = format!("lafet-images-{}-{name}", std::process::id());
            let folder = std::env::temp_dir().join(name);
            _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
            Self(folder)
        }

        fn open(&self) -> Images {
            Images::open(Some(&self.0))
        }

        /// The names of the files.
        fn names(&self) -> Vec<String> {
            let entries = fs::read_dir(self.0.join(FOLDER)).unwrap().flatten();
            let mut names: Vec<String> =
                entries.map(|it| it.file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Data {
        fn drop(&mut self) {
            _ = fs::remove_dir_all(&self.0);
        }
    }

    fn stored(put: io::Result<Put>) -> StoredImage {
        match put {
            Ok(Put::New(about)) => about,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn images_are_there_after_a_restart() {
        let data = Data::new("restart");
        let images = data.open();
        let [one, other] = [samples::image(1, 1), samples::image(1, 2)];
        let about = stored(images.put(one.clone(), "anna", 7));
        stored(images.put(other.clone(), "boris", 8));
        assert_eq!(
            (about.version.as_str(), about.slot),
            ("1.0.0.0", Some(super::super::view::SlotWord::A))
        );
        for images in [images, data.open()] {
            assert_eq!(images.list().iter().map(|it| it.at_ms).collect::<Vec<_>>(), [7, 8]);
            assert_eq!(images.list()[0], about);
            assert_eq!(images.load(&about.digest).unwrap(), Some(one.clone()));
            assert!(matches!(images.put(one.clone(), "eve", 9), Ok(Put::Known(it)) if it == about));
        }
        let images = data.open();
        assert_eq!(images.remove(&about.digest).unwrap(), Some(about.clone()));
        assert_eq!(images.remove(&about.digest).unwrap(), None);
        assert!(images.load(&about.digest).unwrap().is_none());
        assert_eq!((images.list().len(), data.open().list().len()), (1, 1));
    }

    #[test]
    fn without_a_folder_they_are_in_memory() {
        let images = Images::open(None);
        let image = samples::image(1, 0);
        let about = stored(images.put(image.clone(), "anna", 7));
        assert_eq!(images.load(&about.digest).unwrap(), Some(image));
        assert!(images.remove(&about.digest).unwrap().is_some() && images.list().is_empty());
    }

    #[test]
    fn there_are_eight_at_most_and_one_of_a_payload() {
        for data in [None, Some(Data::new("eight"))] {
            let images = Images::open(data.as_ref().map(|it| it.0.as_path()));
            for number in 1..=IMAGES_MAX as u16 {
                stored(images.put(samples::image(number, 0), "anna", 1));
            }
            assert!(matches!(images.put(samples::image(9, 0), "anna", 1), Ok(Put::Full)));
            let renamed = samples::renamed(1);
            assert!(
                matches!(images.put(renamed, "anna", 1), Ok(Put::Differs(it)) if it.version == "1.0.0.0")
            );
            assert_eq!(images.list().len(), IMAGES_MAX);
        }
    }

    /// A disk that is pulled out in the middle of a write, bytes that rot, files of others.
    #[test]
    fn what_is_not_whole_is_not_used() {
        let data = Data::new("rot");
        let images = data.open();
        let about = stored(images.put(samples::image(1, 0), "anna", 7));
        let folder = data.0.join(FOLDER);
        let file = path(&folder, &about.digest, IMAGE);
        let bytes = fs::read(&file).unwrap();
        for (at, name) in [(bytes.len() - 1, "payload"), (100, "signature")] {
            let mut rotten = bytes.clone();
            rotten[at] ^= 1;
            fs::write(&file, rotten).unwrap();
            assert!(matches!(images.load(&about.digest), Err(Unusable::Image(_))), "{name}");
        }
        fs::write(&file, &bytes[..bytes.len() - 8]).unwrap();
        assert!(images.load(&about.digest).is_err() && data.open().list().is_empty());
        fs::remove_file(&file).unwrap();
        assert!(matches!(images.load(&about.digest), Err(Unusable::Io(_))));
        fs::write(&file, &bytes).unwrap();
        // Another image under its name.
        let other = stored(images.put(samples::image(2, 0), "anna", 7));
        fs::copy(&file, path(&folder, &other.digest, IMAGE)).unwrap();
        assert!(images.load(&other.digest).is_err());
        fs::write(path(&folder, &other.digest, NEW), b"half").unwrap();
        fs::write(folder.join("note.txt"), b"a user's own").unwrap();
        // Without what was noted of it, an image is there all the same.
        fs::remove_file(path(&folder, &about.digest, ABOUT)).unwrap();
        let listed = data.open().list();
        assert_eq!(listed, [StoredImage { by: String::new(), at_ms: 0, ..about.clone() }]);
        let names = data.names();
        assert!(!names.iter().any(|it| it.ends_with(NEW)) && names.contains(&"note.txt".into()));
    }

    /// A folder that cannot be written stores nothing, and nothing is left of it.
    #[test]
    fn a_disk_that_takes_nothing() {
        let data = Data::new("disk");
        fs::write(data.0.join("updates"), b"a file where the folder should be").unwrap();
        let images = data.open();
        assert!(images.put(samples::image(1, 0), "anna", 7).is_err());
        assert!(images.list().is_empty());
        let image = samples::image(1, 0);
        let needed = 2 * RESERVE_BYTES + HEADER_LEN as u64 + u64::from(image.size());
        assert!(has_room(needed, &image) && !has_room(needed - 1, &image));
    }

    #[test]
    fn digests_are_names_and_nothing_else_is() {
        assert!(is_digest(&"0f".repeat(32)));
        for odd in ["", "..", "0f", &"0F".repeat(32), &"0g".repeat(32), &"/x".repeat(32)] {
            assert!(!is_digest(odd), "{odd}");
        }
    }
}
