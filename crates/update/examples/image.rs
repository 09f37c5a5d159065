//! Makes keys and images: what a maker of monitors needs, in one file.
//!
//! ```text
//! image key FILE                     makes a key: 32 random bytes in a new file for its owner alone
//! image public ID FILE               its public half, as a line of the board's list
//! image sign ID FILE BOARD VERSION SLOT LAYOUTS PROGRAM IMAGE [REVOKES]
//!                                    SLOT: a, b or any; LAYOUTS: OLDEST-NEWEST;
//!                                    REVOKES: numbers of keys with commas between them
//! image show IMAGE                   what its header says
//! ```

use lafet_update::{BoardName, HEADER_LEN, Hash, Header, Layouts, SigningKey, Slot, UNIT};
use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    print!("{}", run(&arguments)?);
    Ok(())
}

/// What a command prints.
fn run(arguments: &[&str]) -> Outcome<String> {
    Ok(match arguments {
        ["key", file] => {
            let mut seed = [0; 32];
            getrandom::fill(&mut seed)?;
            write_new(Path::new(file), &seed, true)?;
            String::new()
        }
        ["public", id, file] => {
            let public = key(id, file)?.public();
            format!("PublicKey {{ id: {}, bytes: {:?} }},\n", public.id, public.bytes)
        }
        ["sign", id, file, board, version, slot, layouts, program, image, revokes @ ..] => {
            let header = Header {
                size: 0,
                version: version.parse()?,
                board: BoardName::new(board).ok_or("a board has 1 to 16 visible characters")?,
                place: place(slot)?,
                key: 0,
                revokes: bits(revokes)?,
                layouts: range(layouts)?,
                hash: Hash::default(),
            };
            let mut payload = fs::read(program)?;
            payload.resize(payload.len().next_multiple_of(UNIT), 0xFF);
            let raw = key(id, file)?.sign(&header, &payload)?;
            write_new(Path::new(image), &[&raw, payload.as_slice()].concat(), false)?;
            describe(&raw)?
        }
        ["show", image] => {
            let bytes = fs::read(image)?;
            describe(bytes.first_chunk().ok_or("shorter than a header")?)?
        }
        _ => return Err("image key | public | sign | show: see the beginning of this file".into()),
    })
}

fn key(id: &str, file: &str) -> Outcome<SigningKey> {
    let id = id.parse().ok().filter(|id| *id < 16).ok_or("a key has a number of 0 to 15")?;
    let seed = fs::read(file)?.try_into().map_err(|_| "a key is a file of 32 bytes")?;
    Ok(SigningKey::new(id, seed))
}

fn place(slot: &str) -> Outcome<Option<Slot>> {
    Ok(match slot {
        "a" => Some(Slot::A),
        "b" => Some(Slot::B),
        "any" => None,
        _ => return Err("a slot is a, b or any".into()),
    })
}

fn range(layouts: &str) -> Outcome<Layouts> {
    let (oldest, newest) = layouts.split_once('-').ok_or("layouts are OLDEST-NEWEST")?;
    Ok(Layouts { oldest: oldest.parse()?, newest: newest.parse()? })
}

fn bits(keys: &[&str]) -> Outcome<u16> {
    let mut bits = 0;
    for key in keys.iter().flat_map(|keys| keys.split(',')) {
        let key: u32 = key.parse()?;
        bits |= 1_u16.checked_shl(key).ok_or("a key has a number of 0 to 15")?;
    }
    Ok(bits)
}

fn describe(raw: &[u8; HEADER_LEN]) -> Outcome<String> {
    let header = Header::parse(raw)?;
    Ok(format!(
        "board {}, version {}, {} bytes, slot {}, key {}, revokes {:#06b}, layouts {}-{}\n{}\n",
        header.board.as_str(),
        header.version,
        header.size,
        header.place.map_or("any", |slot| if slot == Slot::A { "a" } else { "b" }),
        header.key,
        header.revokes,
        header.layouts.oldest,
        header.layouts.newest,
        header.hash,
    ))
}

/// Never over a file that exists: a key that is lost that way is lost for ever.
fn write_new(path: &Path, bytes: &[u8], secret: bool) -> Outcome<()> {
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if secret {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    let mut file = options.open(path)?;
    file.write_all(bytes)?;
    Ok(file.sync_all()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_update::{Board, PublicKey};

    /// What it signs is what a board with the public half takes, and no other board.
    #[test]
    fn a_board_takes_it() {
        let folder =
            std::env::temp_dir().join(format!("lafet-update-image-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = |name: &str| folder.join(name).display().to_string();
        let (secret, program, image) = (path("key"), path("program"), path("image"));
        assert_eq!(run(&["key", &secret]).unwrap(), "");
        assert!(run(&["key", &secret]).is_err(), "a key is never written over");
        fs::write(&program, [1; 13]).unwrap();
        let sign = ["sign", "3", &secret, "bench", "1.2", "b", "1-2", &program, &image, "0,2"];
        let printed = run(&sign).unwrap();
        assert!(printed.starts_with(
            "board bench, version 1.2.0.0, 16 bytes, slot b, key 3, revokes 0b0101, layouts 1-2\n"
        ));
        assert_eq!(run(&["show", &image]).unwrap(), printed);
        let bytes = fs::read(&image).unwrap();
        assert_eq!(bytes.len(), HEADER_LEN + 16);
        let public = key("3", &secret).unwrap().public();
        assert_eq!(
            run(&["public", "3", &secret]).unwrap(),
            format!("PublicKey {{ id: 3, bytes: {:?} }},\n", public.bytes)
        );
        let name = BoardName::new("bench").unwrap();
        let raw = bytes.first_chunk().unwrap();
        assert!(Header::check(raw, &Board { name, keys: &[public] }, 0).is_ok());
        let other = PublicKey { bytes: SigningKey::new(3, [1; 32]).public().bytes, ..public };
        assert!(Header::check(raw, &Board { name, keys: &[other] }, 0).is_err());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            assert_eq!(fs::metadata(&secret).unwrap().permissions().mode() & 0o777, 0o600);
        }
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_is_wrong_is_said() {
        assert!(run(&[]).is_err());
        assert!(key("16", "/dev/null").is_err());
        assert!(place("c").is_err());
        assert!(range("1").is_err());
        assert!(bits(&["16"]).is_err());
        assert_eq!(bits(&["0,15"]).unwrap(), 0x8001);
    }
}
