//! What the bootloader passes to the program: in memory that neither uses otherwise.

use crate::register::{read, write};
use lafet_update::{Slot, Started, Version};

/// The end of the RAM, above stacks and data of both.
const PLACE: usize = 0x203F_FF00;
/// Marks it as written (ours).
const MARK: u32 = 0x4C46_4254;
const TRIAL: u32 = 1 << 8;
const WORDS: usize = 5;

/// Leaves word of what is started.
pub fn leave(started: &Started) {
    for (index, word) in words(started).into_iter().enumerate() {
        write(PLACE + 4 * index, word);
    }
}

/// What the bootloader has started; it counts once. `None` without a bootloader.
pub fn take() -> Option<Started> {
    let mut words = [0; WORDS];
    for (index, word) in words.iter_mut().enumerate() {
        *word = read(PLACE + 4 * index);
    }
    write(PLACE, 0);
    started(words)
}

fn words(started: &Started) -> [u32; WORDS] {
    let Started { slot, version: Version([major, minor, patch, build]), trial } = *started;
    let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
    let kind = u32::from(slot.code()) | if trial { TRIAL } else { 0 };
    let (first, second) = (pair(major, minor), pair(patch, build));
    [MARK, kind, first, second, check(kind, first, second)]
}

fn started([mark, kind, first, second, sum]: [u32; WORDS]) -> Option<Started> {
    let slot = Slot::from_code((kind & !TRIAL).try_into().ok()?)?;
    let whole = mark == MARK && sum == check(kind, first, second);
    let halves = |word: u32| [word as u16, (word >> 16) as u16];
    let ([major, minor], [patch, build]) = (halves(first), halves(second));
    let version = Version([major, minor, patch, build]);
    whole.then_some(Started { slot, version, trial: kind & TRIAL != 0 })
}

fn check(kind: u32, first: u32, second: u32) -> u32 {
    !(kind ^ first.rotate_left(8) ^ second.rotate_left(16))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_as_it_was_left() {
        for slot in Slot::BOTH {
            for trial in [false, true] {
                let left = Started { slot, version: Version([1, 2, 65_535, 4]), trial };
                assert_eq!(started(words(&left)), Some(left));
            }
        }
    }

    #[test]
    fn what_was_not_left_is_nothing() {
        let left = Started { slot: Slot::A, version: Version([1, 0, 0, 0]), trial: true };
        for bit in 0..32 * WORDS {
            let mut words = words(&left);
            words[bit / 32] ^= 1 << (bit % 32);
            assert_eq!(started(words), None, "bit {bit}");
        }
        assert_eq!(started([0; WORDS]), None);
        assert_eq!(started([u32::MAX; WORDS]), None);
    }
}
