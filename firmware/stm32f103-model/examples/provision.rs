//! Makes the flash image of a new board: `cargo xtask firmware provision`.
//!
//! `provision [--composition NAME] [--address N] [--record FILE] --out FILE`, or `provision --print` for a
//! file to start from.

use std::process::ExitCode;

use lafet_device::Composition;
use lafet_stm32f103::record::{Record, START};
use lafet_stm32f103_model::{image, settings};

fn main() -> ExitCode {
    match run(std::env::args().skip(1)) {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("provision: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(mut arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let (mut composition, mut address) = (&Composition::FULL, 1);
    let (mut record, mut out) = (None, None);
    while let Some(name) = arguments.next() {
        if name == "--print" {
            return Ok(settings::write(&Record::NOMINAL));
        }
        let value = arguments.next().ok_or_else(|| format!("{name} needs a value"))?;
        match name.as_str() {
            "--composition" => {
                let known = Composition::by_name(&value);
                composition = known.ok_or_else(|| format!("{value} is no composition"))?;
            }
            "--address" => {
                let number: u8 = value.parse().unwrap_or_default();
                address = number;
                if !(1..=127).contains(&number) {
                    return Err(format!("{value} is no address of a monitor, 1 to 127"));
                }
            }
            "--record" => {
                let text = std::fs::read_to_string(&value).map_err(|e| format!("{value}: {e}"))?;
                record = Some(settings::read(&text).map_err(|e| format!("{value}: {e}"))?);
            }
            "--out" => out = Some(value),
            _ => return Err(format!("{name} is unknown")),
        }
    }
    let out = out.ok_or("--out FILE, or --print")?;
    let record = record.ok_or("--record FILE; --print gives one to start from")?;
    let image = image::provision(&record, composition, address)?;
    std::fs::write(&out, &image).map_err(|error| format!("{out}: {error}"))?;
    Ok(format!("{out}: {} bytes, to be written to {START:#010x}\n", image.len()))
}
