//! Pictures: only how large they are. What they show is marked by a person.

use lafet_texts::drawing as text;

use crate::shape::{Builder, Drawing, Format};
use crate::{Limits, Problem};

pub fn read(bytes: &[u8], limits: &Limits) -> Result<Drawing, Problem> {
    let format = Format::of(bytes)?;
    let size = if format == Format::Png { png(bytes) } else { jpeg(bytes) };
    let size = size.filter(|size| size.iter().all(|it| *it > 0));
    let size = size.ok_or_else(|| {
        Problem::new(text::PictureBroken { format: format.name() }, text::PictureBrokenRemedy)
    })?;
    let mut builder = Builder::new(format, limits);
    builder.drawing.pixels = Some(size);
    builder.drawing.y_down = true;
    Ok(builder.drawing)
}

/// Width and height in the first chunk.
fn png(bytes: &[u8]) -> Option<[u32; 2]> {
    let header = bytes.get(8..24)?;
    if header.get(4..8) != Some(&b"IHDR"[..]) {
        return None;
    }
    let number = |at: usize| Some(u32::from_be_bytes(header.get(at..at + 4)?.try_into().ok()?));
    Some([number(8)?, number(12)?])
}

/// Width and height as they are shown: a camera that was held upright says so in its Exif block.
fn jpeg(bytes: &[u8]) -> Option<[u32; 2]> {
    let mut at = 2;
    let mut on_its_side = false;
    loop {
        let [0xff, marker] = *bytes.get(at..at + 2)? else { return None };
        if marker == 0xff {
            at += 1;
            continue;
        }
        let length = usize::from(u16::from_be_bytes(bytes.get(at + 2..at + 4)?.try_into().ok()?));
        let block = bytes.get(at + 4..at + 2 + length.max(2))?;
        match marker {
            // The frame header of any coding; c4, c8 and cc are tables.
            b'\xc0'..=b'\xcf' if !matches!(marker, b'\xc4' | b'\xc8' | b'\xcc') => {
                let number = |at: usize| -> Option<u32> {
                    Some(u32::from(u16::from_be_bytes(block.get(at..at + 2)?.try_into().ok()?)))
                };
                let (height, width) = (number(1)?, number(3)?);
                return Some(if on_its_side { [height, width] } else { [width, height] });
            }
            b'\xe1' => on_its_side |= orientation(block).is_some_and(|it| (5..=8).contains(&it)),
            // The picture itself begins, or the file ends, before a frame header.
            b'\xd9' | b'\xda' => return None,
            _ => {}
        }
        at += 2 + length.max(2);
    }
}

/// The orientation in a block of Exif.
fn orientation(block: &[u8]) -> Option<u16> {
    let tiff = block.strip_prefix(b"Exif\0\0")?;
    let little = match tiff.get(..2)? {
        b"II" => true,
        b"MM" => false,
        _ => return None,
    };
    let short = |at: usize| -> Option<u16> {
        let bytes = tiff.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let long = |at: usize| -> Option<u32> {
        let bytes = tiff.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    };
    let first = usize::try_from(long(4)?).ok()?;
    let count = usize::from(short(first)?);
    (0..count).map_while(|n| first.checked_add(2 + 12 * n)).find_map(|entry| {
        let tag = short(entry)?;
        (tag == 0x0112).then(|| short(entry + 8)).flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first bytes of a photograph, with an orientation.
    fn photograph(orientation: u8) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xe1, 0, 34];
        bytes.extend(b"Exif\0\0MM\0*\0\0\0\x08\0\x01");
        bytes.extend([0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0, 0, 0, 0, 0]);
        bytes.extend([0xff, 0xc0, 0, 11, 8, 0x03, 0x00, 0x04, 0x00, 1, 0, 0, 0]);
        bytes
    }

    #[test]
    fn sizes_of_pictures() {
        let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x07\x80\0\0\x04\x38".to_vec();
        let limits = Limits::default();
        assert_eq!(read(&png, &limits).unwrap().pixels, Some([1920, 1080]));
        png[23] = 0;
        png[22] = 0;
        assert!(read(&png, &limits).is_err());
        assert_eq!(read(&photograph(1), &limits).unwrap().pixels, Some([1024, 768]));
        assert_eq!(read(&photograph(6), &limits).unwrap().pixels, Some([768, 1024]));
        for cut in 3..photograph(6).len() - 6 {
            let cut = &photograph(6)[..cut];
            assert!(read(cut, &limits).is_err(), "{}", cut.len());
        }
    }
}
