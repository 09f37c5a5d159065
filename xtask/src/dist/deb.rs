//! The Debian package, made by Debian's own dpkg-deb, which also makes packages for other processors.

use std::path::{Path, PathBuf};

use super::files::{self, File, lay, mode, packed};
use super::{Built, tools, work, write};
use crate::run::{self, StepResult, output};

const POSTINST: &str = include_str!("debian/postinst");
const PRERM: &str = include_str!("debian/prerm");
const POSTRM: &str = include_str!("debian/postrm");
const NEEDRESTART: &str = include_str!("debian/needrestart.conf");
const OVERRIDES: &str = include_str!("debian/lintian-overrides");
/// Characters of a line of the changelog.
const LINE_MAX: usize = 80;
const DESCRIPTION: &str = "hub, tools and simulator for robotic fire monitors
 lafet controls robotic fire monitors (water cannon on two motor axes) over
 serial lines and networks. One program is the hub of a site with its console
 in the browser, the tools of the command line, and a simulator of the monitor.
 .
 The package installs the service lafet-hub, which listens on this machine
 alone until /etc/lafet/hub.toml says otherwise.
";

/// Makes the package in a folder; returns its path.
pub fn make(built: &Built, folder: &Path) -> Result<PathBuf, String> {
    let Built { arch, version, .. } = built;
    let root = work(&format!("deb-{}-{version}", arch.name))?;
    let files = all(built)?;
    lay(&files, &root)?;
    let size: usize = files.iter().map(|it| it.bytes.len().div_ceil(1024).max(1)).sum();
    write(&root.join("DEBIAN/control"), control(built, size)?)?;
    write(&root.join("DEBIAN/conffiles"), "/etc/needrestart/conf.d/lafet.conf\n")?;
    write(&root.join("DEBIAN/md5sums"), sums(&root, &files)?)?;
    for (name, script) in [("postinst", POSTINST), ("prerm", PRERM), ("postrm", POSTRM)] {
        let path = root.join("DEBIAN").join(name);
        write(&path, script)?;
        mode(&path, 0o755)?;
    }
    folders(&root)?;
    let package = folder.join(format!("lafet_{version}_{}.deb", arch.name));
    let mut dpkg = tools::command("dpkg-deb", "dpkg")?;
    // A program for a test is packed quickly.
    dpkg.arg(if built.is_static { "-Zxz" } else { "-Zgzip" });
    dpkg.arg(if built.is_static { "-z9" } else { "-z1" });
    dpkg.args(["--root-owner-group", "--build"]).arg(&root).arg(&package);
    output(dpkg.env("SOURCE_DATE_EPOCH", &built.epoch))?;
    println!("   {}", package.display());
    Ok(package)
}

fn all(built: &Built) -> Result<Vec<File>, String> {
    let mut files = files::all(built)?;
    let mut file = |path: &str, bytes: Vec<u8>| {
        files.push(File { path: path.into(), bytes, mode: 0o644 });
    };
    // The site's own file is made from it once: one of dpkg's would stop upgrades with questions, and be overwritten by
    // a yes.
    file("usr/share/lafet/hub.toml", files::CONFIG.into());
    file("usr/share/lintian/overrides/lafet", OVERRIDES.into());
    file("etc/needrestart/conf.d/lafet.conf", NEEDRESTART.into());
    let changes = changelog(built)?;
    file("usr/share/doc/lafet/changelog.gz", packed(changes.as_bytes(), "changelog")?);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

/// Its maintainer is the one who made the commit: the addresses of a project are its own affair.
fn control(built: &Built, size: usize) -> Result<String, String> {
    let libraries = if built.is_static { "" } else { "libc6, libgcc-s1, " };
    Ok(format!(
        "Package: lafet\nVersion: {}\nArchitecture: {}\nMaintainer: {}\nInstalled-Size: {size}\n\
         Depends: {libraries}adduser, init-system-helpers (>= 1.52)\nSection: electronics\n\
         Priority: optional\nDescription: {DESCRIPTION}",
        built.version,
        built.arch.name,
        maintainer()?,
    ))
}

fn maintainer() -> Result<String, String> {
    let committer = output(run::git().args(["log", "-1", "--format=%an <%ae>"]))?;
    Ok(committer.trim().to_owned())
}

/// CHANGELOG.md in Debian's form: the newest version with its lines.
fn changelog(built: &Built) -> Result<String, String> {
    let date = ["-u", "-R", "-d", &format!("@{}", built.epoch)];
    let date = output(std::process::Command::new("date").env("LC_ALL", "C").args(date))?;
    let (maintainer, version) = (maintainer()?, &built.version);
    let changes = changes(&run::read("CHANGELOG.md")?);
    if changes.is_empty() {
        return Err("CHANGELOG.md has no section with points".into());
    }
    Ok(format!(
        "lafet ({version}) unstable; urgency=medium\n\n{}\n\n -- {maintainer}  {}\n",
        changes.join("\n"),
        date.trim()
    ))
}

/// The points of the first section, each as a line of Debian's changelog and those that continue it, which has
/// lines of 80 characters at most.
fn changes(text: &str) -> Vec<String> {
    let section = text.split("\n## ").nth(1).unwrap_or_default();
    let mut lines: Vec<String> = Vec::new();
    for line in section.lines().skip(1) {
        match line.strip_prefix("- ") {
            Some(_) => lines.push("  *".to_owned()),
            None if line.starts_with("  ") && !lines.is_empty() => {}
            None => continue,
        }
        for word in line.trim_start_matches("- ").split_whitespace() {
            if lines.last().is_none_or(|last| (last.len() + 1 + word.len()) > LINE_MAX) {
                lines.push("   ".to_owned());
            }
            if let Some(last) = lines.last_mut() {
                *last = format!("{last} {word}");
            }
        }
    }
    lines
}

fn sums(root: &Path, files: &[File]) -> Result<String, String> {
    let paths = files.iter().filter(|it| !it.path.starts_with("etc/")).map(|it| &it.path);
    output(tools::command("md5sum", "coreutils")?.args(paths).current_dir(root))
}

/// Folders have the mode that packages have, whatever this user's is.
fn folders(at: &Path) -> StepResult {
    mode(at, 0o755)?;
    let entries = std::fs::read_dir(at).map_err(|e| format!("{}: {e}", at.display()))?;
    let paths = entries.flatten().map(|it| it.path());
    paths.filter(|path| path.is_dir()).try_for_each(|path| folders(&path))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;

    use super::*;

    #[test]
    fn the_newest_section_becomes_the_changelog() {
        let text = "# Changes\n\nWords.\n\n## 0.2.0\n\nMore words.\n\n- one\n  and its rest\n- two\n\n## 0.1.0\n\n- old\n";
        assert_eq!(changes(text), ["  * one and its rest", "  * two"]);
        assert!(changes("nothing").is_empty());
        let own = changes(&run::read("CHANGELOG.md").unwrap());
        assert!(own.len() > 5 && own.iter().all(|line| line.len() <= LINE_MAX), "{own:#?}");
        assert!(own.iter().all(|line| line.starts_with("  * ") || line.starts_with("    ")));
    }

    /// A machine of stubs, on which the script is run.
    struct Stubs<'a> {
        /// What systemd says of the hub.
        active: &'a str,
        /// The new program takes configuration and state.
        fits: bool,
        busy: bool,
        starts: bool,
        /// The package was removed before.
        removed: bool,
    }

    const GOOD: Stubs<'_> =
        Stubs { active: "active", fits: true, busy: false, starts: true, removed: false };
    const RESTART: &str = "deb-systemd-invoke restart lafet-hub.service";
    const START: &str = "deb-systemd-invoke start lafet-hub.service";

    impl Stubs<'_> {
        /// What was called, and what was said.
        fn run(&self, name: &str, arguments: &[&str]) -> (String, String) {
            let root = format!("lafet-postinst-{name}-{}", std::process::id());
            let root = std::env::temp_dir().join(root);
            _ = fs::remove_dir_all(&root);
            let (bin, calls) = (root.join("bin"), root.join("calls"));
            let units = root.join("etc/systemd/system");
            for folder in [&bin, &units, &root.join("run/systemd/system"), &root.join("run/lafet")]
            {
                fs::create_dir_all(folder).unwrap();
            }
            if self.busy {
                fs::write(root.join("run/lafet/busy"), "").unwrap();
            }
            if self.removed {
                std::os::unix::fs::symlink("/dev/null", units.join("lafet-hub.service")).unwrap();
            }
            let code = |good: bool| i32::from(!good);
            for (name, then) in [
                ("systemctl", format!("case \"$*\" in *ActiveState*) echo {};; esac", self.active)),
                ("runuser", format!("exit {}", code(self.fits))),
                ("deb-systemd-invoke", format!("exit {}", code(self.starts))),
                ("deb-systemd-helper", String::new()),
                ("getent", "echo lafet:x:105:110::/var/lib/lafet:/usr/sbin/nologin".into()),
                ("adduser", String::new()),
                ("install", String::new()),
            ] {
                let (path, calls) = (bin.join(name), calls.display());
                let text = format!("#!/bin/sh\necho {name} \"$@\" >>{calls}\n{then}\n");
                fs::write(&path, text).unwrap();
                fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
            }
            let script = root.join("postinst");
            fs::write(&script, POSTINST).unwrap();
            let mut command = Command::new("/bin/sh");
            command.arg(&script).args(arguments).env("PATH", &bin).env("DPKG_ROOT", &root);
            let output = command.output().unwrap();
            assert!(output.status.success(), "{output:?}");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let called = fs::read_to_string(&calls).unwrap();
            fs::remove_dir_all(&root).unwrap();
            (called, said)
        }

        fn upgrade(&self, name: &str) -> (String, String) {
            self.run(name, &["configure", "1.0"])
        }
    }

    #[test]
    fn an_upgrade_restarts_no_hub_that_would_be_missed() {
        let (called, said) = GOOD.upgrade("good");
        assert!(called.contains(RESTART) && said.is_empty(), "{called}{said}");
        assert!(called.contains("serve --check --config /etc/lafet/hub.toml"), "{called}");
        let refused = "refuses /etc/lafet/hub.toml or the state";
        for (name, fits, busy, why) in
            [("wrong", false, false, refused), ("busy", true, true, "water flows")]
        {
            let (called, said) = Stubs { fits, busy, ..GOOD }.upgrade(name);
            assert!(!called.contains(RESTART), "{called}");
            for words in ["NOT RESTARTED", why, "НЕ ПЕРЕЗАПУЩЕН", "systemctl restart lafet-hub"]
            {
                assert!(said.contains(words), "{said}");
            }
        }
        // One that has failed has nothing to lose.
        let failed = Stubs { active: "failed", fits: false, starts: false, ..GOOD };
        let (called, said) = failed.upgrade("failed");
        assert!(called.contains(RESTART) && said.contains("DOES NOT RUN"), "{called}{said}");
    }

    #[test]
    fn an_upgrade_starts_no_hub_that_a_person_has_stopped() {
        let stopped = Stubs { active: "inactive", ..GOOD };
        let (called, said) = stopped.upgrade("stopped");
        assert!(!called.contains(RESTART) && !called.contains(START), "{called}");
        assert!(said.contains("stays so") && said.contains("остаётся"), "{said}");
        // Removed and installed again, or for the first time.
        let (called, said) = Stubs { removed: true, ..stopped }.upgrade("removed");
        assert!(called.contains(RESTART) && said.is_empty(), "{called}{said}");
        let (called, _) = stopped.run("aborted", &["abort-remove"]);
        assert!(called.contains(START), "{called}");
    }

    /// The disk was full: the old program has run all the while.
    #[test]
    fn an_upgrade_that_fails_leaves_the_hub_alone() {
        let (called, said) = GOOD.run("full", &["abort-upgrade", "2.0"]);
        assert!(!called.contains(RESTART) && !called.contains(START), "{called}");
        assert!(said.is_empty(), "{said}");
    }
}
