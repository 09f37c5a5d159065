//! The folder of certificates: who is trusted, and who was rejected. An administrator moves files between them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::ServerConfig;

/// Rejected certificates that are kept, the latest: strangers could fill the disk with them.
pub const REJECTED_MAX: usize = 32;

/// The folder of trusted certificates.
pub fn trusted(config: &ServerConfig) -> PathBuf {
    config.folder.join("trusted")
}

/// The folder of rejected certificates.
pub fn rejected(config: &ServerConfig) -> PathBuf {
    config.folder.join("rejected")
}

/// Makes the folders. The key is for the hub alone.
pub fn prepare(config: &ServerConfig) -> io::Result<()> {
    for part in ["trusted", "rejected", "own", "private"] {
        fs::create_dir_all(config.folder.join(part))?;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        for folder in [config.folder.clone(), config.folder.join("private")] {
            fs::set_permissions(folder, fs::Permissions::from_mode(0o700))?;
        }
    }
    Ok(())
}

/// Removes the oldest of the rejected certificates.
pub fn prune(folder: &Path) -> io::Result<()> {
    let mut files: Vec<(SystemTime, PathBuf)> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        files.push((entry.metadata()?.modified()?, entry.path()));
    }
    let surplus = files.len().saturating_sub(REJECTED_MAX);
    files.sort();
    files.into_iter().take(surplus).try_for_each(|(_, path)| fs::remove_file(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_do_not_fill_the_disk() {
        let folder = std::env::temp_dir().join(format!("lafet-opcua-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for number in 0..REJECTED_MAX + 9 {
            fs::write(folder.join(format!("{number}.der")), b"x").unwrap();
        }
        prune(&folder).unwrap();
        assert_eq!(fs::read_dir(&folder).unwrap().count(), REJECTED_MAX);
        fs::remove_dir_all(&folder).unwrap();
    }
}
