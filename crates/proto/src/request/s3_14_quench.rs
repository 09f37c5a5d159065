//! §3.14 StartQuench: the jet scans a sector.

use super::s3_06_correction_table::CORRECTION;
use super::{exact, wrong_size};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{DATA_MAX, Data, NoRoom};
use crate::text::error::Wanted;
use crate::text::fields::{Buffer, Tokens};
use crate::text::parse::{I8, I16, Parsed, list_i8};
use crate::text::write_list;
use crate::{Bytes, DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::START_QUENCH,
    name: "StartQuench",
    section: "3.14",
    origin: Origin::Read,
    addressees: &[SubsystemId::CONTROL],
    title: key!("request-StartQuench-title"),
    meaning: key!("request-StartQuench-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[QUENCH_PROGRAM, QUENCH_FULL, QUENCH_CORRECTED];

const QUENCH_PROGRAM: Layout = Layout::plain(
    "QuenchProgram",
    fields! { Quench:
        program I16 None;
        centre_h I16 Arcmin;
        centre_v I16 Arcmin;
        nozzle I16 Millimetre;
    },
);
const QUENCH_FULL: Layout = Layout::plain(
    "QuenchFull",
    fields! { Quench:
        centre_h I16 Arcmin;
        centre_v I16 Arcmin;
        nozzle I16 Millimetre;
        width I16 Arcmin;
        height I16 Arcmin;
        step I8 Degree;
        distance I8 Metre;
    },
);
const QUENCH_CORRECTED: Layout = Layout {
    name: "QuenchCorrected",
    fields: QUENCH_FULL.fields.split_at(6).0,
    repeated: CORRECTION,
    times: (2, usize::MAX),
    prefix: &[],
};

/// §3.14 StartQuench: data_size selects the variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quench<'a> {
    /// 8 bytes: a stored program, moved to a centre.
    Program {
        /// Number of the program, 0–7.
        program: i16,
        /// Centre, horizontal, arc-minutes.
        centre_h: i16,
        /// Centre, vertical, arc-minutes.
        centre_v: i16,
        /// Nozzle position, mm.
        nozzle: i16,
    },
    /// 12 bytes: all given; the elevation follows from the distance by ballistics.
    Full {
        /// The sector to extinguish.
        sector: Sector,
        /// Distance to the fire, m.
        distance: i8,
    },
    /// 13…255 bytes: with corrections of elevation by pressure from index 0.
    Corrected {
        /// The sector to extinguish.
        sector: Sector,
        /// Degrees, one for each 0.1 atm, at least two.
        corrections: Bytes<'a>,
    },
}

/// The sector that the jet scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sector {
    /// Centre, horizontal, arc-minutes.
    pub centre_h: i16,
    /// Centre, vertical, arc-minutes.
    pub centre_v: i16,
    /// Nozzle position, mm.
    pub nozzle: i16,
    /// Width, arc-minutes.
    pub width: i16,
    /// Height, arc-minutes.
    pub height: i16,
    /// Step between lines, degrees; 0 = aim at the centre.
    pub step: i8,
}

impl<'a> Quench<'a> {
    const FULL_SIZE: usize = 12;

    pub(super) fn decode(data: &'a [u8]) -> Result<Self, DecodeError> {
        if let Ok([p0, p1, h0, h1, v0, v1, n0, n1]) = exact(data) {
            return Ok(Self::Program {
                program: i16::from_le_bytes([p0, p1]),
                centre_h: i16::from_le_bytes([h0, h1]),
                centre_v: i16::from_le_bytes([v0, v1]),
                nozzle: i16::from_le_bytes([n0, n1]),
            });
        }
        let (sector, rest) = data.split_first_chunk().ok_or(wrong_size(data))?;
        let sector = Sector::from_bytes(*sector);
        match rest {
            [] => Err(wrong_size(data)),
            [distance] => Ok(Self::Full { sector, distance: i8::from_le_bytes([*distance]) }),
            corrections => Ok(Self::Corrected { sector, corrections: Bytes(corrections) }),
        }
    }

    pub(super) fn encode(&self, data: &mut Data<'_>) -> Result<(), NoRoom> {
        match self {
            Self::Program { program, centre_h, centre_v, nozzle } => {
                [*program, *centre_h, *centre_v, *nozzle]
                    .into_iter()
                    .try_for_each(|value| data.put_i16(value))
            }
            Self::Full { sector, distance } => {
                data.put(&sector.to_bytes())?;
                data.put(&distance.to_le_bytes())
            }
            Self::Corrected { sector, corrections } => {
                // Fewer than two corrections would be read as another variant.
                if corrections.0.len() + Sector::SIZE <= Self::FULL_SIZE {
                    return Err(NoRoom);
                }
                data.put(&sector.to_bytes())?;
                data.put(corrections.0)
            }
        }
    }
}

impl Sector {
    const SIZE: usize = 11;

    const fn from_bytes([a, b, c, d, e, f, g, h, i, j, step]: [u8; Self::SIZE]) -> Self {
        Self {
            centre_h: i16::from_le_bytes([a, b]),
            centre_v: i16::from_le_bytes([c, d]),
            nozzle: i16::from_le_bytes([e, f]),
            width: i16::from_le_bytes([g, h]),
            height: i16::from_le_bytes([i, j]),
            step: i8::from_le_bytes([step]),
        }
    }

    const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b] = self.centre_h.to_le_bytes();
        let [c, d] = self.centre_v.to_le_bytes();
        let [e, f] = self.nozzle.to_le_bytes();
        let [g, h] = self.width.to_le_bytes();
        let [i, j] = self.height.to_le_bytes();
        let [step] = self.step.to_le_bytes();
        [a, b, c, d, e, f, g, h, i, j, step]
    }
}

/// The keys select the variant.
pub(crate) fn parse<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Parsed<Quench<'b>> {
    const KEYS: &[&str] =
        &["program=", "centre=", "nozzle=", "sector=", "step=", "distance=", "corrections="];
    let (mut program, mut centre, mut nozzle) = (None, None, None);
    let (mut sector, mut step, mut distance, mut corrections) = (None, None, None, None);
    let mut buffer = Buffer::new(buf, DATA_MAX - 11);
    while let Some(token) = tokens.next() {
        match token.pair() {
            Some(("program", value)) => token.set(&mut program, value.number("program", I16)?)?,
            Some(("centre" | "center", value)) => {
                token.set(&mut centre, value.numbers::<2>("centre h,v", I16)?)?;
            }
            Some(("nozzle", value)) => token.set(&mut nozzle, value.number("nozzle", I16)?)?,
            Some(("sector", value)) => {
                token.set(&mut sector, value.numbers::<2>("sector width,height", I16)?)?;
            }
            Some(("step", value)) => token.set(&mut step, value.number("step", I8)?)?,
            Some(("distance", value)) => token.set(&mut distance, value.number("distance", I8)?)?,
            Some(("corrections", value)) => {
                token.set(&mut corrections, ())?;
                list_i8(&mut buffer, value)?;
            }
            _ => return Err(token.error(Wanted::Word(KEYS))),
        }
    }
    let (Some(([centre_h, centre_v], _)), Some((nozzle, _))) = (centre, nozzle) else {
        return Err(tokens.missing(if centre.is_none() { "centre=" } else { "nozzle=" }));
    };
    if let Some((program, _)) = program {
        let others = [
            ("sector=", sector.map(|(_, t)| t)),
            ("step=", step.map(|(_, t)| t)),
            ("distance=", distance.map(|(_, t)| t)),
            ("corrections=", corrections.map(|(_, t)| t)),
        ];
        return match others.into_iter().find_map(|(name, token)| Some((name, token?))) {
            Some((name, token)) => Err(token.error(Wanted::NotTogether("program=", name))),
            None => Ok(Quench::Program { program, centre_h, centre_v, nozzle }),
        };
    }
    let (Some(([width, height], _)), Some((step, _))) = (sector, step) else {
        return Err(tokens.missing(if sector.is_none() { "sector=" } else { "step=" }));
    };
    let sector = Sector { centre_h, centre_v, nozzle, width, height, step };
    match (distance, corrections) {
        (Some((distance, _)), None) => Ok(Quench::Full { sector, distance }),
        (None, Some((_, token))) => {
            let corrections = Bytes(buffer.finish());
            // A single correction would be read as the distance (§3.14: the size is the variant).
            if corrections.0.len() < 2 {
                return Err(token.error(Wanted::Numbers { what: "corrections", count: 2 }));
            }
            Ok(Quench::Corrected { sector, corrections })
        }
        (Some(_), Some((_, token))) => {
            Err(token.error(Wanted::NotTogether("distance=", "corrections=")))
        }
        (None, None) => Err(tokens.missing("distance= or corrections=")),
    }
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, quench: &Quench<'_>) -> fmt::Result {
    match *quench {
        Quench::Program { program, centre_h, centre_v, nozzle } => {
            write!(f, " program={program} centre={centre_h},{centre_v} nozzle={nozzle}")
        }
        Quench::Full { sector, distance } => {
            write_sector(f, &sector)?;
            write!(f, " distance={distance}")
        }
        Quench::Corrected { sector, corrections } => {
            write_sector(f, &sector)?;
            f.write_str(" corrections=")?;
            write_list(f, ",", corrections.iter())
        }
    }
}

fn write_sector(f: &mut fmt::Formatter<'_>, sector: &Sector) -> fmt::Result {
    let Sector { centre_h, centre_v, nozzle, width, height, step } = sector;
    write!(f, " centre={centre_h},{centre_v} nozzle={nozzle} sector={width},{height} step={step}")
}
