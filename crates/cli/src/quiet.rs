//! Serial ports that were listened to lately and on which nothing unreadable was heard: not every command
//! has to wait until a controller that seldom speaks would have been heard.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::state;

/// Longer ago, another device may have been connected.
const LATELY: Duration = Duration::from_secs(600);

/// The kernel's devices by their numbers.
const DEVICES: &str = "/sys/dev/char";
/// What is different each time that the computer is started.
const BOOT: &str = "/proc/sys/kernel/random/boot_id";

/// The folder of the notes, an empty file for each port and speed.
#[derive(Debug)]
pub struct Notes {
    /// `None`: there is no place for them.
    folder: Option<PathBuf>,
    devices: PathBuf,
}

impl Notes {
    /// Those of this user.
    pub fn of_user() -> Self {
        let folder = state::folder().map(|state| state.join("quiet"));
        Self { folder, devices: DEVICES.into() }
    }

    /// Whether this port was quiet lately, or readable, at this speed.
    pub fn has(&self, port: &Path, baud: u32) -> bool {
        let age = || {
            let noted = fs::metadata(self.file(port, baud)?).ok()?.modified().ok()?;
            now().duration_since(noted).ok()
        };
        age().is_some_and(|age| age < LATELY)
    }

    /// Notes that it is so, or that it is not. What cannot be noted is listened to again.
    pub fn set(&self, port: &Path, baud: u32, quiet: bool) {
        let Some(file) = self.file(port, baud) else { return };
        let _ = match (quiet, file.parent()) {
            (true, Some(folder)) => fs::create_dir_all(folder).and_then(|()| fs::write(&file, [])),
            _ => fs::remove_file(&file),
        };
    }

    /// A port that was unplugged and came back is another one: the system has made its file again, and in a
    /// container, where that file stays, the kernel has made the device again.
    #[cfg(unix)]
    fn file(&self, port: &Path, baud: u32) -> Option<PathBuf> {
        use std::os::unix::fs::MetadataExt;
        let it = fs::metadata(port).ok()?;
        let (made_s, made_ns) = (it.ctime(), it.ctime_nsec());
        let numbers = format!("{}:{}", rustix::fs::major(it.rdev()), rustix::fs::minor(it.rdev()));
        // A pseudo-terminal has none.
        let device = fs::metadata(self.devices.join(numbers)).map_or(0, |device| device.ino());
        let boot = fs::read_to_string(BOOT).unwrap_or_default();
        let port = format!("{:x}-{:x}-{made_s:x}-{made_ns:x}", it.rdev(), it.ino());
        Some(self.folder.as_ref()?.join(format!("{port}-{device:x}-{baud}-{}", boot.trim())))
    }

    /// These systems do not show whether a port is the same.
    #[cfg(not(unix))]
    fn file(&self, _: &Path, _: u32) -> Option<PathBuf> {
        None
    }
}

#[expect(clippy::disallowed_methods, reason = "the age of a file")]
fn now() -> SystemTime {
    SystemTime::now()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_port_is_quiet_for_a_while_at_its_speed() {
        let folder = std::env::temp_dir().join(format!("lafet-quiet-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let port = folder.join("port");
        fs::write(&port, "").unwrap();
        let devices = folder.join("devices");
        let notes = Notes { folder: Some(folder.join("notes")), devices: devices.clone() };
        assert!(!notes.has(&port, 19_200));
        notes.set(&port, 19_200, false);
        notes.set(&port, 19_200, true);
        assert!(notes.has(&port, 19_200) && !notes.has(&port, 57_600));
        let file = fs::File::open(notes.file(&port, 19_200).unwrap()).unwrap();
        for age in [LATELY + Duration::from_secs(1), Duration::ZERO] {
            // Of a clock that was put back, nothing is believed either.
            let noted = if age.is_zero() { now() + LATELY } else { now() - age };
            file.set_modified(noted).unwrap();
            assert!(!notes.has(&port, 19_200), "{age:?}");
        }
        notes.set(&port, 19_200, true);
        assert!(notes.has(&port, 19_200));
        notes.set(&port, 19_200, false);
        assert!(!notes.has(&port, 19_200));
        // Another port of that name.
        notes.set(&port, 19_200, true);
        fs::rename(&port, folder.join("before")).unwrap();
        fs::write(&port, "").unwrap();
        assert!(!notes.has(&port, 19_200));
        // Another device behind the same file.
        let device = devices.join("0:0");
        fs::create_dir_all(&device).unwrap();
        notes.set(&port, 19_200, true);
        assert!(notes.has(&port, 19_200));
        fs::rename(&device, devices.join("before")).unwrap();
        assert!(!notes.has(&port, 19_200));
        fs::create_dir_all(&device).unwrap();
        assert!(!notes.has(&port, 19_200));
        assert!(!Notes { folder: None, devices }.has(&port, 19_200));
        fs::remove_dir_all(folder).unwrap();
    }
}
