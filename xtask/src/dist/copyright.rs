//! What is shipped inside of the program, and under which licences: Rust packages, packages of the
//! console, and the C libraries that they bring.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{ARCHES, Arch, read};
use crate::run::{self, cargo, output};

/// Longest licence file; the longest of a package has 50 kB.
const TEXT_MAX: u64 = 256 << 10;
/// How names of files with licences begin.
const TEXTS: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE", "COPYRIGHT"];

/// Where a package is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    Cargo,
    Npm,
    /// A library in C, inside of a Rust package or of the compiler.
    Native,
}

/// Something inside of the program.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shipped {
    pub source: Source,
    pub name: String,
    pub version: String,
    /// SPDX expression.
    pub licence: String,
    /// Where its licence files are.
    folder: Option<PathBuf>,
    /// Digest that its registry has: algorithm of CycloneDX, hexadecimal.
    pub digest: Option<(&'static str, String)>,
}

/// Libraries in C: name, licence, the Rust package that brings it, its licence files there, and where its
/// version is: a file and what is before it.
const NATIVE: [(&str, &str, &str, &str, &str, &str); 3] = [
    ("sqlite", "blessing", "libsqlite3-sys", "", "sqlite3/sqlite3.h", "#define SQLITE_VERSION "),
    ("zstd", "BSD-3-Clause", "zstd-sys", "zstd", "zstd/lib/zstd.h", ""),
    ("jemalloc", "BSD-2-Clause", "tikv-jemalloc-sys", "jemalloc", "", ""),
];
/// Part of every program that the compiler makes for these systems.
const OF_COMPILER: [(&str, &str); 2] = [("rust-std", "Apache-2.0 OR MIT"), ("musl", "MIT")];

/// Everything inside of the program, ordered.
pub fn shipped() -> Result<Vec<Shipped>, String> {
    let packages = packages()?;
    let used = used()?;
    let mut all: Vec<Shipped> = packages
        .iter()
        .filter(|it| used.contains(&(it.name.clone(), it.version.clone())))
        .cloned()
        .collect();
    let native: Vec<Shipped> = all.iter().filter_map(native).collect();
    all.extend(native);
    let compiler = output(std::process::Command::new("rustc").arg("--version"))?;
    let compiler = compiler.split_whitespace().nth(1).unwrap_or_default().to_owned();
    all.extend(OF_COMPILER.map(|(name, licence)| Shipped {
        source: Source::Native,
        name: name.into(),
        version: compiler.clone(),
        licence: licence.into(),
        folder: None,
        digest: None,
    }));
    all.extend(console()?);
    all.sort();
    all.dedup();
    Ok(all)
}

/// The packages that are linked into the program on any of its systems.
fn used() -> Result<BTreeSet<(String, String)>, String> {
    let mut all = BTreeSet::new();
    for Arch { triple, .. } in &ARCHES {
        let tree = ["tree", "--locked", "-p", "lafet", "-e", "normal,no-proc-macro"];
        let form = ["--target", triple, "--prefix", "none", "--format", "{p}"];
        all.extend(output(cargo(&tree).args(form))?.lines().filter_map(package));
    }
    if all.is_empty() { Err("cargo tree names no package".into()) } else { Ok(all) }
}

/// `serde v1.0.228 (proc-macro)` by name and version.
fn package(line: &str) -> Option<(String, String)> {
    let mut words = line.split_whitespace();
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    Some((name.to_owned(), version.to_owned()))
}

/// All packages that cargo knows of, with their licences.
fn packages() -> Result<Vec<Shipped>, String> {
    let text = output(&mut cargo(&["metadata", "--locked", "--format-version=1"]))?;
    let json: Value = serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
    let digests = digests(&run::read("Cargo.lock")?)?;
    let of = |json: &Value| {
        let text = |key: &str| json[key].as_str().map(str::to_owned);
        let (name, version) = (text("name")?, text("version")?);
        let manifest = text("manifest_path")?;
        let digest = digests.get(&(name.clone(), version.clone())).cloned();
        Some(Shipped {
            source: Source::Cargo,
            licence: expression(&text("license").unwrap_or_default()),
            folder: Path::new(&manifest).parent().map(Path::to_owned),
            digest: digest.map(|it| ("SHA-256", it)),
            name,
            version,
        })
    };
    Ok(json["packages"].as_array().into_iter().flatten().filter_map(of).collect())
}

/// The old form with a slash, as SPDX has it now.
fn expression(text: &str) -> String {
    text.replace(" / ", " OR ").replace('/', " OR ")
}

/// What the lock file has of each package.
fn digests(lock: &str) -> Result<BTreeMap<(String, String), String>, String> {
    let lock: toml::Table = lock.parse().map_err(|e| format!("Cargo.lock: {e}"))?;
    let packages = lock.get("package").and_then(toml::Value::as_array).into_iter().flatten();
    let of = |it: &toml::Value| {
        let text = |key: &str| it.get(key)?.as_str().map(str::to_owned);
        Some(((text("name")?, text("version")?), text("checksum")?))
    };
    Ok(packages.filter_map(of).collect())
}

/// The library in C that a package brings.
fn native(of: &Shipped) -> Option<Shipped> {
    let (name, licence, _, texts, file, before) =
        NATIVE.into_iter().find(|(_, _, package, ..)| *package == of.name)?;
    let folder = of.folder.as_ref()?;
    let header = std::fs::read_to_string(folder.join(file)).unwrap_or_default();
    let defined = header.lines().find_map(|line| line.strip_prefix(before));
    // Packages of libraries have its version behind their own.
    let behind = || of.version.split_once('+').map(|(_, it)| it.trim_start_matches("zstd."));
    let version = match (before, defined) {
        ("", _) | (_, None) => behind().unwrap_or(&of.version).to_owned(),
        (_, Some(defined)) => defined.trim().trim_matches('"').to_owned(),
    };
    Some(Shipped {
        source: Source::Native,
        name: name.into(),
        version,
        licence: licence.into(),
        folder: (!texts.is_empty()).then(|| folder.join(texts)),
        digest: None,
    })
}

/// The packages that are in the console.
fn console() -> Result<Vec<Shipped>, String> {
    let path = "console/package-lock.json";
    let lock: Value =
        serde_json::from_str(&run::read(path)?).map_err(|e| format!("{path}: {e}"))?;
    let packages = lock["packages"].as_object().into_iter().flatten();
    let of = |(place, it): (&String, &Value)| {
        let (_, name) = place.rsplit_once("node_modules/")?;
        if it["dev"] == true {
            return None;
        }
        Some(Shipped {
            source: Source::Npm,
            name: name.to_owned(),
            version: it["version"].as_str()?.to_owned(),
            licence: it["license"].as_str().unwrap_or_default().to_owned(),
            folder: Some(run::root().join("console").join(place)),
            digest: it["integrity"].as_str().and_then(integrity),
        })
    };
    let all: Vec<Shipped> = packages.filter_map(of).collect();
    if all.is_empty() { Err(format!("{path} names no package")) } else { Ok(all) }
}

/// `sha512-…` in base64, as hexadecimal.
fn integrity(text: &str) -> Option<(&'static str, String)> {
    let mut hex = String::new();
    let (mut bits, mut count) = (0_u32, 0);
    for letter in text.strip_prefix("sha512-")?.trim_end_matches('=').bytes() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            hex += &format!("{:02x}", (bits >> count) & 0xff);
            bits &= (1 << count) - 1;
        }
    }
    (hex.len() == 128).then_some(("SHA-512", hex))
}

/// The copyright file of the package, in Debian's form.
pub fn debian(shipped: &[Shipped]) -> String {
    let mut text = String::from(
        "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n\
         Upstream-Name: lafet\n\
         Comment:\n The program contains these packages; licences.txt.gz has the text of each licence.\n",
    );
    for it in shipped.iter().filter(|it| !it.name.starts_with("lafet")) {
        text += &format!("  {} {}: {}\n", it.name, it.version, it.licence);
    }
    text += "\nFiles: *\nCopyright: 2026 lafet contributors\nLicense: Apache-2.0 or Expat\n\n\
             License: Apache-2.0\n The text is in /usr/share/common-licenses/Apache-2.0.\n\n\
             License: Expat\n";
    let mit = include_str!("../../../LICENSE-MIT");
    for line in mit.lines().skip_while(|line| !line.starts_with("Permission")) {
        text += if line.trim().is_empty() { " ." } else { " " };
        text += &format!("{}\n", line.trim());
    }
    text
}

/// The texts of all licences, each once, with the packages that it is for.
pub fn texts(shipped: &[Shipped]) -> Result<String, String> {
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut without = Vec::new();
    for it in shipped {
        let name = format!("{} {} ({})", it.name, it.version, it.licence);
        let found = it.folder.as_deref().map(files).transpose()?.unwrap_or_default();
        if found.is_empty() {
            without.push(name.clone());
        }
        for text in found {
            all.entry(text).or_default().push(name.clone());
        }
    }
    let mut text = String::from("Licences of what is inside of lafet.\n");
    for (licence, names) in all {
        let line = "=".repeat(78);
        text += &format!("\n{line}\n{}\n{line}\n\n{}\n", names.join("\n"), licence.trim_end());
    }
    text += "\nWithout a text of their own; the licence is the one in brackets:\n\n";
    text += &format!("{}\n", without.join("\n"));
    Ok(text)
}

/// The licence files at the top of a folder.
fn files(folder: &Path) -> Result<Vec<String>, String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_text = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        let short = path.metadata().is_ok_and(|it| it.is_file() && it.len() <= TEXT_MAX);
        short && TEXTS.iter().any(|start| name.starts_with(start))
    };
    let mut paths: Vec<PathBuf> = entries.map(|it| it.path()).filter(is_text).collect();
    paths.sort();
    let text = |path: &PathBuf| -> Result<String, String> {
        let text = String::from_utf8_lossy(&read(path)?).replace("\r\n", "\n");
        Ok(text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n"))
    };
    paths.iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_registries_say_is_read() {
        assert_eq!(package("a-b v1.2.3+c (/path)"), Some(("a-b".into(), "1.2.3+c".into())));
        assert_eq!(package(""), None);
        assert_eq!(expression("MIT/Apache-2.0"), "MIT OR Apache-2.0");
        let zeros = format!("sha512-{}==", "A".repeat(86));
        assert_eq!(integrity(&zeros), Some(("SHA-512", "0".repeat(128))));
        let ones = format!("sha512-{}w==", "/".repeat(85));
        assert_eq!(integrity(&ones).unwrap().1, "f".repeat(128));
        for wrong in ["sha512-AAAA", "sha1-AAAA", "sha512-!"] {
            assert_eq!(integrity(wrong), None, "{wrong}");
        }
        let lock = "[[package]]\nname = 'a'\nversion = '1'\nchecksum = 'ff'\n";
        let digests = digests(lock).unwrap();
        assert_eq!(digests[&("a".to_owned(), "1".to_owned())], "ff");
    }

    #[test]
    fn the_console_and_its_libraries_are_named() {
        let console = console().unwrap();
        let lit = console.iter().find(|it| it.name == "lit").unwrap();
        assert_eq!(
            (lit.licence.as_str(), lit.digest.as_ref().unwrap().0),
            ("BSD-3-Clause", "SHA-512")
        );
        assert!(console.iter().all(|it| it.name != "vite"), "it builds, and is not shipped");
        let text = debian(&console);
        assert!(text.contains(" lit ") && text.contains(" Permission is hereby granted"), "{text}");
    }
}
