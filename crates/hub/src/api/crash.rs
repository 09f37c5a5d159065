//! Crash data in words (§3.20).

use lafet_proto::crash::{Context, FaultBit};
use lafet_proto::status::{FaultArch, FaultInfo};
use lafet_texts::Text;
use serde::Serialize;
use utoipa::ToSchema;

use crate::text::Both;

/// What the last hardware fault has left.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Crash {
    /// A fault is stored.
    pub filled: bool,
    /// `Cortex-M3` or `ARM7TDMI`.
    pub processor: &'static str,
    /// Registers: name and value.
    pub words: Vec<(&'static str, u32)>,
    /// Bits of the fault registers that are set.
    pub bits: Vec<CrashBit>,
    /// Bits without a name, by register.
    pub unknown: Vec<UnknownBits>,
    /// What is to be said of a register.
    pub notes: Vec<Note>,
    /// What the processor was at; null: there was no fault.
    #[schema(required)]
    pub running: Option<Running>,
    /// The fault in a sentence.
    #[schema(required)]
    pub summary: Option<Both>,
}

/// A bit of a fault register.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CrashBit {
    /// Name of the register.
    pub register: &'static str,
    /// Number of the bit, from 0.
    pub bit: u8,
    /// Name of the bit.
    pub name: &'static str,
    /// What a set bit means.
    pub meaning: Both,
    /// What to do.
    pub remedy: Both,
}

/// Bits without a name.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct UnknownBits {
    /// Name of the register.
    pub register: &'static str,
    /// Mask of the bits.
    pub bits: u32,
}

/// What is to be said of a register.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Note {
    /// Name of the register.
    pub register: &'static str,
    /// What the value points to.
    pub text: Both,
}

/// What the processor was at.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Running {
    /// Summary in words.
    pub what: Both,
    /// Number of the interrupt, if it was one.
    #[schema(required)]
    pub number: Option<u16>,
}

impl From<&FaultInfo> for Crash {
    fn from(info: &FaultInfo) -> Self {
        let filled = *info != FaultInfo::NONE;
        let words: Vec<_> = info.registers().collect();
        let note = |(register, _): &(&'static str, u32)| {
            Some(Note { register, text: info.note(register)?.words() })
        };
        let unknown = info.unknown_bits().into_iter().filter(|(_, bits)| *bits != 0);
        let context = info.context();
        let cortex = matches!(info.arch, FaultArch::CortexM3(_));
        Self {
            filled,
            processor: if cortex { "Cortex-M3" } else { "ARM7TDMI" },
            bits: info.bits().map(CrashBit::from).collect(),
            unknown: unknown.map(|(register, bits)| UnknownBits { register, bits }).collect(),
            notes: words.iter().filter_map(note).collect(),
            words,
            running: filled.then(|| Running { what: executed(context), number: context.number() }),
            summary: info.summary().map(|it| it.words()),
        }
    }
}

/// What the processor was executing.
fn executed(context: Context) -> Both {
    match context.text() {
        Some(text) => text.words(),
        None => Both::same(context.name().unwrap_or_default()),
    }
}

impl From<&FaultBit> for CrashBit {
    fn from(it: &FaultBit) -> Self {
        Self {
            register: it.register,
            bit: it.bit,
            name: it.name,
            meaning: it.meaning.words(),
            remedy: it.remedy.words(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_named_bit_by_bit_in_both_languages() {
        let mut words = [0x0800_1234; 20];
        (words[14], words[17], words[19]) = (1 << 30, 1 << 9 | 1 << 15, 0x0100_001B);
        let crash = Crash::from(&FaultInfo::from_words(words));
        let names: Vec<&str> = crash.bits.iter().map(|it| it.name).collect();
        assert_eq!(names, ["FORCED", "PRECISERR", "BFARVALID"]);
        assert!(crash.bits[1].meaning.ru.len() > 10, "{crash:?}");
        assert_eq!(crash.running.unwrap().number, Some(11));
        let notes: Vec<&str> = crash.notes.iter().map(|it| it.register).collect();
        assert!(notes.contains(&"mmfar") && !notes.contains(&"bfar"), "{notes:?}");
        assert!(crash.filled && crash.summary.is_none());
        let none = Crash::from(&FaultInfo::NONE);
        assert!(!none.filled && none.running.is_none());
    }
}
