//! The user as which the hub runs, and what that user may do with a file.

use std::path::Path;

use lafet_texts::{Text as _, cli as text};

use super::Finding;
use crate::lang::current;

/// Bits of a mode, as of other users.
pub const READ: u32 = 0o4;
pub const WRITE: u32 = 0o2;
const ENTER: u32 = 0o1;

/// A user of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct User {
    /// Name, or number where it has none.
    pub name: String,
    id: u32,
    groups: Vec<u32>,
}

impl User {
    /// The user that was named, else that of the package if root asks, else the one who asks.
    pub fn of_hub(named: Option<&str>, usual: &str) -> Result<Self, Finding> {
        let asks = Self::current();
        match named {
            Some(name) => Self::by_name(name).ok_or_else(|| {
                Finding::fault(
                    "user-missing",
                    text::InstallUserMissing { user: name }.of(current()),
                    text::InstallUserMissingRemedy { user: name }.of(current()),
                )
            }),
            None if asks.id == 0 => Ok(Self::by_name(usual).unwrap_or(asks)),
            None => Ok(asks),
        }
    }

    /// Whether this user may do with a path, a file or a folder, what the bits say.
    pub fn may(&self, path: &Path, bits: u32) -> bool {
        let Ok(path) = std::fs::canonicalize(path) else { return false };
        path.ancestors().skip(1).all(|folder| self.may_here(folder, ENTER))
            && self.may_here(&path, bits)
    }

    /// Whether everything is permitted.
    pub const fn is_root(&self) -> bool {
        self.id == 0
    }

    /// Whether a member of this group.
    pub fn is_in(&self, group: u32) -> bool {
        self.groups.contains(&group)
    }
}

#[cfg(unix)]
mod unix {
    use std::fs::{File, Metadata, metadata};
    use std::io::Read;
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    use super::User;

    /// Larger files are not those of a machine with a hub.
    const FILE_MAX: u64 = 8 << 20;

    impl User {
        /// The user of this process.
        pub fn current() -> Self {
            let id = rustix::process::geteuid().as_raw();
            let group = rustix::process::getegid().as_raw();
            let (users, groups) = (read("/etc/passwd"), read("/etc/group"));
            let name = users.lines().find_map(|line| named(line, 2, id));
            match name.and_then(|name| Self::parse(&users, &groups, &name)) {
                Some(user) => user,
                None => Self { name: id.to_string(), id, groups: vec![group] },
            }
        }

        /// A user by name, in the files of this machine.
        pub fn by_name(name: &str) -> Option<Self> {
            Self::parse(&read("/etc/passwd"), &read("/etc/group"), name)
        }

        pub(super) fn parse(users: &str, groups: &str, name: &str) -> Option<Self> {
            let line = users.lines().find(|line| line.split(':').next() == Some(name))?;
            let number = |at: usize| line.split(':').nth(at)?.parse::<u32>().ok();
            let (id, own) = (number(2)?, number(3)?);
            let is_member = |line: &&str| {
                line.split(':').nth(3).is_some_and(|all| all.split(',').any(|it| it == name))
            };
            let others = groups.lines().filter(is_member);
            let others = others.filter_map(|line| line.split(':').nth(2)?.parse().ok());
            Some(Self {
                name: name.to_owned(),
                id,
                groups: [own].into_iter().chain(others).collect(),
            })
        }

        pub(super) fn may_here(&self, path: &Path, bits: u32) -> bool {
            metadata(path).is_ok_and(|it| self.id == 0 || self.bits(&it) & bits == bits)
        }

        fn bits(&self, file: &Metadata) -> u32 {
            match () {
                () if file.uid() == self.id => file.mode() >> 6,
                () if self.is_in(file.gid()) => file.mode() >> 3,
                () => file.mode(),
            }
        }

        /// Whether users other than this one and root may change a file.
        pub fn is_changed_by_others(&self, path: &Path) -> bool {
            metadata(path).is_ok_and(|it| {
                let others = if it.gid() == 0 { 0o002 } else { 0o022 };
                it.mode() & others != 0 || ![0, self.id].contains(&it.uid())
            })
        }

        /// Whether a path belongs to another user.
        pub fn is_foreign(&self, path: &Path) -> bool {
            metadata(path).is_ok_and(|it| it.uid() != self.id)
        }
    }

    /// Whether users other than the owner have any right on a path.
    pub fn is_open(path: &Path) -> bool {
        metadata(path).is_ok_and(|it| it.mode() & 0o077 != 0)
    }

    /// The group of a path, by number and name.
    pub fn group_of(path: &Path) -> Option<(u32, String)> {
        let id = metadata(path).ok()?.gid();
        let name = read("/etc/group").lines().find_map(|line| named(line, 2, id));
        Some((id, name.unwrap_or_else(|| id.to_string())))
    }

    /// The number of a group.
    pub fn group(name: &str) -> Option<u32> {
        let groups = read("/etc/group");
        let line = groups.lines().find(|line| line.split(':').next() == Some(name))?;
        line.split(':').nth(2)?.parse().ok()
    }

    /// The name at the start of a line that has this number at a place.
    fn named(line: &str, at: usize, id: u32) -> Option<String> {
        let number: u32 = line.split(':').nth(at)?.parse().ok()?;
        (number == id).then(|| line.split(':').next().unwrap_or_default().to_owned())
    }

    fn read(path: &str) -> String {
        let mut bytes = Vec::new();
        // A file that is missing names no user.
        _ = File::open(path).and_then(|file| file.take(FILE_MAX).read_to_end(&mut bytes));
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

#[cfg(unix)]
pub use unix::{group, group_of, is_open};

#[cfg(not(unix))]
mod elsewhere {
    use std::path::Path;

    use super::User;

    /// Other systems keep rights by other means, which the hub does not set.
    impl User {
        pub fn current() -> Self {
            let name = std::env::var("USERNAME").unwrap_or_default();
            Self { name, id: 1, groups: Vec::new() }
        }

        pub fn by_name(_: &str) -> Option<Self> {
            None
        }

        pub(super) fn may_here(&self, path: &Path, _: u32) -> bool {
            path.exists()
        }

        pub fn is_changed_by_others(&self, _: &Path) -> bool {
            false
        }

        pub fn is_foreign(&self, _: &Path) -> bool {
            false
        }
    }

    pub fn is_open(_: &Path) -> bool {
        false
    }

    pub fn group_of(_: &Path) -> Option<(u32, String)> {
        None
    }

    pub fn group(_: &str) -> Option<u32> {
        None
    }
}

#[cfg(not(unix))]
pub use elsewhere::{group, group_of, is_open};

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const USERS: &str = "root:x:0:0:root:/root:/bin/bash\n\nbroken\nlafet:x:105:110::/var/lib/lafet:/usr/sbin/nologin\n\
                         odd:x:many:0::/:\n";
    const GROUPS: &str = "root:x:0:\ndialout:x:20:other,lafet\ntty:x:5:lafetta\nlafet:x:110:\n";

    #[test]
    fn a_user_has_the_groups_that_name_it() {
        let user = User::parse(USERS, GROUPS, "lafet").unwrap();
        assert_eq!(user, User { name: "lafet".into(), id: 105, groups: vec![110, 20] });
        assert!(user.is_in(20) && !user.is_in(5));
        for name in ["odd", "broken", "nobody", ""] {
            assert_eq!(User::parse(USERS, GROUPS, name), None, "{name}");
        }
    }

    #[test]
    fn rights_are_those_of_owner_group_or_others_alone() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        let file = std::env::temp_dir().join(format!("lafet-rights-{}", std::process::id()));
        std::fs::write(&file, "").unwrap();
        let found = std::fs::metadata(&file).unwrap();
        let user = |id, group| User { name: String::new(), id, groups: vec![group] };
        // Numbers that are neither root's nor the file's.
        let (stranger, strange) = (found.uid() + 1000, found.gid() + 1000);
        let group = user(stranger, found.gid());
        let other = user(stranger, strange);
        for (mode, group_reads, other_reads) in
            [(0o640, true, false), (0o604, false, true), (0o600, false, false)]
        {
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(mode)).unwrap();
            assert_eq!(group.may_here(&file, READ), group_reads, "{mode:o}");
            assert_eq!(other.may_here(&file, READ), other_reads, "{mode:o}");
            assert!(!other.may_here(&file, WRITE) && user(0, 0).may_here(&file, WRITE));
        }
        std::fs::remove_file(&file).unwrap();
        assert!(!user(0, 0).may(&file, READ), "it is gone");
    }
}
