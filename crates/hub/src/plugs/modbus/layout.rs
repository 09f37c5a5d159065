//! Where the registers of a unit are: the same addresses for functions 3 and 4, from 0.

use lafet_proto::SubsystemId;

/// Monitors of a unit: so many fit into one reading.
pub const MONITORS: usize = 8;

/// Version of the map, sign of life of the hub, number of monitors, state of the site.
pub const HEADER: u16 = 0;
/// Words of the header.
pub const HEADER_LEN: usize = 5;
/// The summaries of the monitors.
pub const SUMMARY: u16 = 5;
/// Words of a summary.
pub const SUMMARY_LEN: usize = 15;
/// The session of this connection.
pub const SESSION: u16 = 128;
/// Words of the session.
pub const SESSION_LEN: usize = 8;
/// The results of commands, the latest first.
pub const RESULTS: u16 = 136;
/// Results that are kept.
pub const RESULTS_KEPT: usize = 4;
/// Words of a result.
pub const RESULT_LEN: usize = 6;
/// The result of a motion by hand.
pub const JOG_RESULT: u16 = 160;
/// Words of the result of a motion by hand.
pub const JOG_RESULT_LEN: usize = 8;
/// The keys for openings, of each monitor.
pub const KEYS: u16 = 168;
/// Words of a key.
pub const KEY_LEN: usize = 4;
/// The heartbeat of the master.
pub const HEARTBEAT: u16 = 256;
/// The block of motions by hand.
pub const JOG: u16 = 257;
/// Words of that block.
pub const JOG_LEN: usize = 7;
/// The block of commands.
pub const COMMAND: u16 = 264;
/// Words of that block.
pub const COMMAND_LEN: usize = 13;
/// Its last register.
pub const COMMAND_LAST: u16 = COMMAND + COMMAND_LEN as u16 - 1;
/// The ids of the monitors, two characters in a word.
pub const NAMES: u16 = 320;
/// Words of an id.
pub const NAME_LEN: usize = 8;
/// The state of each monitor bit by bit, as the protocol has it.
pub const DETAIL: u16 = 512;
/// Words of it.
pub const DETAIL_LEN: usize = 2 + 2 * DETAILED.len();
/// The first address behind the map.
pub const END: u16 = DETAIL + (MONITORS * DETAIL_LEN) as u16;

/// The subsystems whose status words are in the map.
pub const DETAILED: [SubsystemId; 9] = [
    SubsystemId::GENERAL,
    SubsystemId::HORIZONTAL,
    SubsystemId::VERTICAL,
    SubsystemId::NOZZLE,
    SubsystemId::VALVE1,
    SubsystemId::VALVE2,
    SubsystemId::CONTROL,
    SubsystemId::DETECTOR,
    SubsystemId::DEPLOYER,
];

/// The drives in the order of the blocks.
pub use crate::plugs::orders::AXES;

/// What a signed value is when it is not known.
pub const UNKNOWN_SIGNED: u16 = 0x8000;
/// What an unsigned value is when it is not known.
pub const UNKNOWN: u16 = 0xFFFF;

/// A number as words, the high one first.
pub const fn halves(value: u32) -> [u16; 2] {
    [(value >> 16) as u16, (value & 0xFFFF) as u16]
}

/// A key as words, the highest first.
pub fn key_words(key: u64) -> [u16; KEY_LEN] {
    [48, 32, 16, 0].map(|shift| (key >> shift & 0xFFFF) as u16)
}

/// The text of an id in words; what does not fit is left out.
pub fn name_words(id: &str) -> [u16; NAME_LEN] {
    let mut bytes = id.bytes().chain(std::iter::repeat(0));
    let mut next = || bytes.next().unwrap_or_default();
    std::array::from_fn(|_| u16::from_be_bytes([next(), next()]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_reading_has_eight_monitors_and_no_block_lies_on_another() {
        let block = |first: u16, len: usize, count: usize| (first, first + (len * count) as u16);
        let blocks = [
            block(HEADER, HEADER_LEN, 1),
            block(SUMMARY, SUMMARY_LEN, MONITORS),
            block(SESSION, SESSION_LEN, 1),
            block(RESULTS, RESULT_LEN, RESULTS_KEPT),
            block(JOG_RESULT, JOG_RESULT_LEN, 1),
            block(KEYS, KEY_LEN, MONITORS),
            block(HEARTBEAT, 1, 1),
            block(JOG, JOG_LEN, 1),
            block(COMMAND, COMMAND_LEN, 1),
            block(NAMES, NAME_LEN, MONITORS),
            block(DETAIL, DETAIL_LEN, MONITORS),
        ];
        assert_eq!((blocks[0].0, blocks[1].1), (0, super::super::pdu::READ_MAX));
        assert!(blocks.is_sorted_by(|one, next| one.1 <= next.0), "{blocks:?}");
        assert_eq!((blocks[10].1, JOG + JOG_LEN as u16), (END, COMMAND));
        // A master may write all three blocks at once.
        assert_eq!(JOG, HEARTBEAT + 1);
    }

    #[test]
    fn words_have_the_high_part_first() {
        assert_eq!(halves(0x0102_0304), [0x0102, 0x0304]);
        assert_eq!(key_words(0x0001_0002_0003_0004), [1, 2, 3, 4]);
        assert_eq!(name_words("M1")[..2], [u16::from_be_bytes(*b"M1"), 0]);
        assert_eq!(name_words("north-hangar-door")[7], u16::from_be_bytes(*b"oo"));
    }
}
