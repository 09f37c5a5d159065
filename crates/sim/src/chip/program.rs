//! What a chip runs: the machine of QEMU for it, and the file that its flash is in.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use std::process::{Command, Stdio};

use lafet_plant::flash;
use lafet_update::{HEADER_LEN, Memory, Partition, Slot};

use super::{FLASH, LOG, Line, QEMU};
use crate::flash::Chip as Words;

/// The flash of the board lm3s6965, bytes.
const LM3S6965_FLASH: usize = 8 * 1024;

/// What the chip runs, and so which of the boards it is on.
#[derive(Clone, Copy, Debug)]
pub enum Program<'a> {
    /// An ELF file for the board lm3s6965: a program that stays as it is.
    Fixed(&'a Path),
    /// The board mps2, whose software can be updated over the link.
    InSlots {
        /// Its bootloader, an ELF file.
        boot: &'a Path,
        /// The image that a new flash has in slot A: header and payload, as they were signed. Where there is
        /// a flash, it is left as it is.
        first: &'a [u8],
    },
}

impl Program<'_> {
    /// Makes the file of a new flash: erased, and with the first image in its slot, as a programmer leaves it.
    ///
    /// # Errors
    ///
    /// Of `InvalidInput` for an image that no slot can take; otherwise those of the file.
    pub fn make_flash(self, path: &Path) -> io::Result<()> {
        let first = match self {
            Self::Fixed(_) => return std::fs::write(path, vec![0xFF; LM3S6965_FLASH]),
            Self::InSlots { first, .. } => first,
        };
        std::fs::write(path, programmed(first)?)?;
        // The length comes last: a file whose making was cut off has another one.
        File::options().write(true).open(path)?.set_len(flash::FILE_LEN)
    }

    /// Whether nothing has been stored yet in this flash.
    ///
    /// # Errors
    ///
    /// Of `InvalidData` for a file that is no flash of this board.
    pub(super) fn is_new(self, path: &Path) -> io::Result<bool> {
        let (len, params) = match self {
            Self::Fixed(_) => (LM3S6965_FLASH as u64, LM3S6965_FLASH),
            Self::InSlots { .. } => {
                (flash::FILE_LEN, usize::from(flash::PARAMS_PAGES) * flash::PAGE)
            }
        };
        let file = File::open(path)?;
        let is = file.metadata()?.len();
        if is != len {
            let why = format!("{} has {is} bytes, not {len}", path.display());
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        let mut bytes = Vec::new();
        file.take(params as u64).read_to_end(&mut bytes)?;
        Ok(bytes.iter().all(|byte| *byte == 0xFF))
    }

    /// QEMU with it, in a folder that has the flash.
    pub(super) fn emulator(self, folder: &Path, line: &Line) -> io::Result<Command> {
        let device = match line {
            Line::Tcp { host, port } => {
                format!("socket,id=line,host={host},port={port},server=on,wait=off,nodelay=on")
            }
            Line::Here => "socket,id=line,path=line".into(),
        };
        let mut command = Command::new(QEMU);
        command.args(["-display", "none", "-monitor", "none"]);
        // An instruction takes 16 ns of the chip's time, as many as on a real one: however busy the machine is,
        // the watchdog does not run out meanwhile. It makes the instructions countable, too.
        command.args(["-icount", "shift=4"]);
        command.args(["-chardev", &device, "-serial", "chardev:line"]);
        command.args(["-chardev", "socket,id=plant,path=plant", "-serial", "chardev:plant"]);
        let kernel = match self {
            Self::Fixed(program) => {
                command.args(["-M", "lm3s6965evb"]);
                command.args(["-semihosting-config", "enable=on,target=native"]);
                program
            }
            Self::InSlots { boot, .. } => {
                // What the machine has as its memory, this file keeps.
                let memory = "memory-backend-file,id=flash,share=on";
                let size = flash::FILE_LEN;
                command.args(["-M", "mps2-an385,memory-backend=flash"]);
                command.arg("-object").arg(format!("{memory},size={size},mem-path={FLASH}"));
                boot
            }
        };
        command.arg("-kernel").arg(std::fs::canonicalize(kernel)?);
        command.current_dir(folder).stdin(Stdio::null());
        // Of a board that it does not know to the last detail, QEMU says more than is of use.
        command.stderr(File::create(folder.join(LOG))?);
        Ok(command)
    }
}

/// An erased flash with an image in slot A.
fn programmed(image: &[u8]) -> io::Result<Vec<u8>> {
    let memory = Memory::new(
        Words::sized(0, 0),
        Partition {
            slots: flash::SLOTS,
            slot_pages: flash::SLOT_PAGES,
            record: flash::RECORD,
            record_pages: flash::RECORD_PAGES,
        },
    );
    let parts = image.split_at_checked(HEADER_LEN);
    let fits = |payload: &[u8]| u32::try_from(payload.len()).is_ok_and(|size| memory.takes(size));
    let Some((header, payload)) = parts.filter(|(_, payload)| fits(payload)) else {
        let why = format!("{} bytes are no image that a slot can take", image.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    };
    let mut bytes = vec![0xFF; flash::LEN];
    for (at, part) in [(memory.start_of(Slot::A), header), (memory.payload_of(Slot::A), payload)] {
        let places = bytes.iter_mut().skip(at as usize);
        places.zip(part).for_each(|(place, byte)| *place = *byte);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flash::PAGE;

    /// The sizes of a slot are counted by the words and pages of the simulator's flash.
    #[test]
    fn the_emulated_flash_has_words_and_pages_like_the_simulated_one() {
        use embedded_storage::nor_flash::NorFlash;
        assert_eq!((flash::PAGE, flash::WORD), (PAGE, Words::WRITE_SIZE));
    }

    #[test]
    fn a_new_flash_has_its_image_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("lafet-flash-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("flash");
        let image: Vec<u8> = (0..HEADER_LEN + 16).map(|n| n as u8 & 0x7F).collect();
        let program = Program::InSlots { boot: Path::new("boot"), first: &image };
        program.make_flash(&path).unwrap();
        assert!(program.is_new(&path).unwrap());
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len() as u64, flash::FILE_LEN);
        let written: Vec<usize> = (0..flash::LEN).filter(|at| bytes[*at] != 0xFF).collect();
        let (start, payload) = (flash::SLOTS[0] as usize, flash::SLOTS[0] as usize + flash::PAGE);
        assert_eq!(written[..HEADER_LEN], (start..start + HEADER_LEN).collect::<Vec<_>>());
        assert_eq!(written[HEADER_LEN..], (payload..payload + 16).collect::<Vec<_>>());
        // What was cut off while it was made, or is of the other board, is no flash.
        File::options().write(true).open(&path).unwrap().set_len(flash::LEN as u64).unwrap();
        assert_eq!(program.is_new(&path).unwrap_err().kind(), io::ErrorKind::InvalidData);
        let fixed = Program::Fixed(Path::new("program"));
        fixed.make_flash(&path).unwrap();
        assert!(fixed.is_new(&path).unwrap());
        assert_eq!(program.is_new(&path).unwrap_err().kind(), io::ErrorKind::InvalidData);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn an_image_that_no_slot_can_take_makes_no_flash() {
        let most = (usize::from(flash::SLOT_PAGES) - 1) * flash::PAGE;
        for (len, fits) in [(0, false), (HEADER_LEN, false), (HEADER_LEN + most, true)] {
            assert_eq!(programmed(&vec![0; len]).is_ok(), fits, "{len}");
        }
        assert!(programmed(&vec![0; HEADER_LEN + most + 8]).is_err());
        assert!(programmed(&[0; HEADER_LEN + 12]).is_err());
    }
}
