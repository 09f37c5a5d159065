//! What the factory knows of the hardware around the chip (ours): scales, speeds, end positions, baud.
//! It has a page of its own in front of the monitor's parameters, which CleanFlash leaves alone; the
//! program never writes it. `cargo xtask firmware provision` makes its image.

use crate::bus::Bus;
use lafet_proto::link::crc16;

/// Where it is: the last page before those of the parameters.
pub const START: u32 = 0x0803_D800;
/// "LAFB", and the version of the format in the last byte.
const MAGIC: u32 = 0x4C41_4601;
/// Words: magic, general, six for each drive, CRC.
pub const WORDS: usize = 1 + GENERAL + 4 * DRIVE + 1;
/// Where its last word is, the CRC of the others.
pub const CRC: u32 = START + 4 * (WORDS as u32 - 1);
const GENERAL: usize = 5;
const DRIVE: usize = 6;

/// A drive, its motor and encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveRecord {
    /// Counts of the encoder in 100' or 100 mm; negative where it counts down while the drive goes up. Not 0.
    pub counts_per_100: i32,
    /// Speed with full voltage and without load, 0.1 °/s or 0.1 mm/s. Not 0.
    pub full_tenths: u16,
    /// A high direction pin turns it down or right.
    pub is_reversed: bool,
    /// Where the end switches open, ' or mm.
    pub ends: (i32, i32),
    /// Where it is parked, ' or mm.
    pub parked: i32,
}

/// The board's record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Baud of the line: 9,600 to 115,200.
    pub baud: u32,
    /// Counts of the ADC at 1 A: motors and valves.
    pub counts_per_ampere: u32,
    /// 0.1 V at 4,096 counts of the ADC.
    pub supply_full_dv: u32,
    /// µA at 4,096 counts: the loop of the pressure sensor.
    pub loop_full_ua: u32,
    /// Pulses of the flow meter in 10 litres; 0 where there is none.
    pub pulses_per_10_l: u32,
    /// Drives, in the order of the process image.
    pub drives: [DriveRecord; 4],
}

impl Record {
    /// An angle drive of the nominal monitor: four counts a minute of arc, 25 °/s at full voltage.
    const ANGLE: DriveRecord = DriveRecord {
        counts_per_100: 400,
        full_tenths: 250,
        is_reversed: false,
        ends: (0, 0),
        parked: 0,
    };

    /// That of the nominal monitor (`crates/sim`): an example to start from, not a default. The program
    /// drives nothing without a record in the flash.
    pub const NOMINAL: Self = Self {
        baud: 115_200,
        counts_per_ampere: 100,
        supply_full_dv: 363,
        loop_full_ua: 22_000,
        pulses_per_10_l: 100,
        drives: [
            DriveRecord { ends: (-915, 4_515), ..Self::ANGLE },
            DriveRecord { ends: (-10_815, 10_815), ..Self::ANGLE },
            DriveRecord {
                counts_per_100: 4_000,
                full_tenths: 150,
                ends: (0, 60),
                parked: 60,
                ..Self::ANGLE
            },
            DriveRecord { ends: (10, 5_390), ..Self::ANGLE },
        ],
    };

    /// The record in the flash; `None` when there is none that is whole and sensible.
    pub fn read(bus: &impl Bus) -> Option<Self> {
        let mut bytes = [0; 4 * WORDS];
        for (address, byte) in (START..).zip(&mut bytes) {
            *byte = bus.read8(address);
        }
        Self::decode(&bytes)
    }

    /// Its bytes in the flash.
    pub fn encode(&self) -> [u8; 4 * WORDS] {
        let mut bytes = [0; 4 * WORDS];
        let general = [
            MAGIC,
            self.baud,
            self.counts_per_ampere,
            self.supply_full_dv,
            self.loop_full_ua,
            self.pulses_per_10_l,
        ];
        let drives = self.drives.iter().flat_map(|drive| {
            [
                drive.counts_per_100.cast_unsigned(),
                drive.full_tenths.into(),
                drive.is_reversed.into(),
                drive.ends.0.cast_unsigned(),
                drive.ends.1.cast_unsigned(),
                drive.parked.cast_unsigned(),
            ]
        });
        for (place, word) in
            bytes.as_chunks_mut().0.iter_mut().zip(general.into_iter().chain(drives))
        {
            *place = word.to_le_bytes();
        }
        let (body, last) = bytes.split_at_mut(4 * (WORDS - 1));
        for (place, byte) in last.iter_mut().zip(u32::from(crc16(body)).to_le_bytes()) {
            *place = byte;
        }
        bytes
    }

    fn decode(bytes: &[u8; 4 * WORDS]) -> Option<Self> {
        let (words, _) = bytes.as_chunks();
        let mut words = words.iter().map(|word| u32::from_le_bytes(*word));
        let mut next = || words.next();
        if next()? != MAGIC {
            return None;
        }
        let mut record = Self {
            baud: next()?,
            counts_per_ampere: next()?,
            supply_full_dv: next()?,
            loop_full_ua: next()?,
            pulses_per_10_l: next()?,
            drives: [DriveRecord::default(); 4],
        };
        for drive in &mut record.drives {
            *drive = DriveRecord {
                counts_per_100: next()?.cast_signed(),
                full_tenths: next()? as u16,
                is_reversed: next()? != 0,
                ends: (next()?.cast_signed(), next()?.cast_signed()),
                parked: next()?.cast_signed(),
            };
        }
        let crc = u32::from(crc16(bytes.get(..4 * (WORDS - 1))?));
        (next()? == crc && record.is_sensible()).then_some(record)
    }

    /// Every figure is one with which the program can count.
    pub fn is_sensible(&self) -> bool {
        let drives = self.drives.iter().all(|drive| {
            (1..=60_000).contains(&drive.counts_per_100.unsigned_abs())
                && (1..=1_000).contains(&drive.full_tenths)
                && drive.ends.0 < drive.ends.1
                && [drive.ends.0, drive.ends.1, drive.parked].iter().all(|at| at.abs() <= 32_767)
        });
        drives
            && (9_600..=115_200).contains(&self.baud)
            && (10..=1_000).contains(&self.counts_per_ampere)
            && (100..=1_000).contains(&self.supply_full_dv)
            && (20_000..=60_000).contains(&self.loop_full_ua)
            && self.pulses_per_10_l <= 10_000
    }
}
