//! The software of the board mps2: its bootloader, and signed images of its program for both slots.

use std::path::{Path, PathBuf};
use std::process::Command;

use object::LittleEndian;
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader as _, ProgramHeader as _};

use crate::no_std;
use crate::run::{self, StepResult, root, show};

/// The feature of the program.
pub const FEATURE: &str = "mps2";
/// The board, in the headers of images.
const BOARD: &str = "lafet-mps2";
/// The key that the board has while nothing else is put into its list; its secret is for all to read.
const TEST_KEY: (&str, &str) = ("15", "firmware/mps2/test.key");
/// Layouts of the stored parameters that the program reads, and writes.
const LAYOUTS: &str = "1-1";
const SLOTS: [&str; 2] = ["a", "b"];
/// The further feature of the program that is linked for slot B.
pub const SLOT_B: &str = "slot-b";

/// `cargo xtask firmware images VERSION FOLDER [--key N=FILE]`.
pub fn images(arguments: &[String]) -> StepResult {
    let (version, folder, key) = match arguments {
        [version, folder] => (version, folder, test_key()),
        [version, folder, option, key] if option == "--key" => (version, folder, key.clone()),
        _ => return Err("firmware images VERSION FOLDER [--key N=FILE]".into()),
    };
    let folder = std::path::absolute(folder).map_err(|e| format!("{folder}: {e}"))?;
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let lafet = run::program("lafet")?;
    let boot = folder.join("boot.elf");
    std::fs::copy(boot_program(&[])?, &boot).map_err(|e| format!("{}: {e}", boot.display()))?;
    let [a, b] = Programs::link(&folder, "program", &[])?.sign(&lafet, version, &key)?;
    let [boot, a, b] = [boot, a, b].map(|path| path.display().to_string());
    println!("   lafet sim --on qemu --boot {boot} --firmware {a} --flash FILE   (a new board)");
    println!("   lafet update {a} {b}   (one that runs an older version)");
    Ok(())
}

/// The board's test key, as `lafet image sign` takes it.
pub fn test_key() -> String {
    let (number, file) = TEST_KEY;
    format!("{number}={}", root().join(file).display())
}

/// Builds the bootloader with these features; returns the path of the ELF file.
pub fn boot_program(features: &[&str]) -> Result<PathBuf, String> {
    // With the program, so that what both need is built once.
    let folder = no_std::target().join("firmware").join(FEATURE);
    let mut build = no_std::build(Some(&folder))?;
    build.current_dir(root().join("firmware")).args(BOOT);
    if !features.is_empty() {
        build.args(["--features", &features.join(",")]);
    }
    show(&mut build)?;
    Ok(folder.join(no_std::TARGET).join("release/lafet-boot"))
}

/// What selects the bootloader.
pub const BOOT: [&str; 4] = ["--release", "--locked", "--package", "lafet-boot"];

/// The program as it lies in each slot.
pub struct Programs {
    folder: PathBuf,
    files: [PathBuf; 2],
}

impl Programs {
    /// Links the program for both slots, with further features; the files have this name.
    pub fn link(folder: &Path, name: &str, features: &[&str]) -> Result<Self, String> {
        let mut files = SLOTS.map(|slot| folder.join(format!("{name}.{slot}.bin")));
        for (file, more) in files.iter_mut().zip([&[][..], &[SLOT_B]]) {
            let features = [&[FEATURE][..], more, features].concat().join(",");
            let program = super::build(&features)?;
            let failed =
                |what: &Path, error: &dyn std::fmt::Display| format!("{}: {error}", what.display());
            let elf = std::fs::read(&program).map_err(|e| failed(&program, &e))?;
            let bytes = flat(&elf).map_err(|e| failed(&program, &e))?;
            std::fs::write(&*file, bytes).map_err(|e| failed(file, &e))?;
        }
        Ok(Self { folder: folder.into(), files })
    }

    /// Signs them in a version; returns the images for the slots A and B.
    pub fn sign(&self, lafet: &Path, version: &str, key: &str) -> Result<[PathBuf; 2], String> {
        let images = SLOTS.map(|slot| self.folder.join(format!("{version}.{slot}.image")));
        for ((slot, program), image) in SLOTS.iter().zip(&self.files).zip(&images) {
            let mut sign = Command::new(lafet);
            sign.args(["image", "sign", "--key", key, "--board", BOARD, "--version", version]);
            show(sign.args(["--layouts", LAYOUTS, "--slot", slot]).arg(program).arg(image))?;
        }
        Ok(images)
    }
}

/// What an ELF file puts into the flash, from its first byte to its last.
fn flat(file: &[u8]) -> Result<Vec<u8>, object::Error> {
    let little = LittleEndian;
    let header = FileHeader32::<LittleEndian>::parse(file)?;
    let mut parts = Vec::new();
    for part in header.program_headers(little, file)? {
        let bytes = part.data(little, file).unwrap_or_default();
        if part.p_type(little) == PT_LOAD && !bytes.is_empty() {
            parts.push((part.p_paddr(little) as usize, bytes));
        }
    }
    parts.sort_by_key(|(at, _)| *at);
    let start = parts.first().map_or(0, |(at, _)| *at);
    let mut all = Vec::new();
    for (at, bytes) in parts {
        // Between two parts it stays erased.
        all.resize(at - start, 0xFF);
        all.extend_from_slice(bytes);
    }
    Ok(all)
}
