//! §3.20 Meaning of the fault registers of `fault_info`, bit by bit.
//!
//! Bits are those of the ARMv7-M architecture (Cortex-M3: hfsr, cfsr, psr) and of the ARM7TDMI
//! (cpsr, spsr); their texts are ours.

use crate::dictionary::{Key, key};
use crate::status::{FaultArch, FaultInfo};

/// A bit of a fault register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FaultBit {
    /// Name of the register, one of `FaultInfo::NAMES`.
    pub register: &'static str,
    /// Number of the bit, from 0.
    pub bit: u8,
    /// Name of the bit in the architecture's manual.
    pub name: &'static str,
    /// What has happened.
    pub meaning: Key,
    /// What to do.
    pub remedy: Key,
}

macro_rules! bits {
    ($($register:literal $bit:literal $name:literal;)+) => {
        /// Every bit of hfsr and cfsr that the architecture defines.
        pub const FAULT_BITS: [FaultBit; [$($bit),+].len()] = [$(FaultBit {
            register: $register,
            bit: $bit,
            name: $name,
            meaning: key!("fault-", $name, "-meaning"),
            remedy: key!("fault-", $name, "-remedy"),
        }),+];
    };
}

bits! {
    "hfsr" 1 "VECTTBL";
    "hfsr" 30 "FORCED";
    "hfsr" 31 "DEBUGEVT";
    "cfsr" 0 "IACCVIOL";
    "cfsr" 1 "DACCVIOL";
    "cfsr" 3 "MUNSTKERR";
    "cfsr" 4 "MSTKERR";
    "cfsr" 5 "MLSPERR";
    "cfsr" 7 "MMARVALID";
    "cfsr" 8 "IBUSERR";
    "cfsr" 9 "PRECISERR";
    "cfsr" 10 "IMPRECISERR";
    "cfsr" 11 "UNSTKERR";
    "cfsr" 12 "STKERR";
    "cfsr" 13 "LSPERR";
    "cfsr" 15 "BFARVALID";
    "cfsr" 16 "UNDEFINSTR";
    "cfsr" 17 "INVSTATE";
    "cfsr" 18 "INVPC";
    "cfsr" 19 "NOCP";
    "cfsr" 20 "STKOF";
    "cfsr" 24 "UNALIGNED";
    "cfsr" 25 "DIVBYZERO";
}

/// The first registers, which all processors have.
const COMMON: usize = 10;

impl FaultInfo {
    /// The registers by name: the common ones, then those of the processor.
    pub fn registers(&self) -> impl Iterator<Item = (&'static str, u32)> + use<> {
        let own: &[&str] = match self.arch {
            FaultArch::CortexM3(_) => Self::NAMES.get(COMMON..).unwrap_or_default(),
            FaultArch::Arm7Tdmi(_) => &Self::NAMES_ARM7TDMI,
        };
        Self::NAMES.iter().take(COMMON).chain(own).copied().zip(self.to_words())
    }

    /// A remark on a register's value where the name does not explain it.
    pub fn note(&self, register: &str) -> Option<Key> {
        let stale = |valid| {
            (!self.bits().any(|bit| bit.name == valid)).then_some(key!("fault-address-not-valid"))
        };
        match register {
            "pc" => Some(key!("fault-pc")),
            "lr" => Some(key!("fault-lr")),
            "mmfar" => stale("MMARVALID"),
            "bfar" => stale("BFARVALID"),
            _ => None,
        }
    }

    /// A summary of a record in which no known bit is set.
    pub fn summary(&self) -> Option<Key> {
        let cortex = matches!(self.arch, FaultArch::CortexM3(_));
        (cortex && *self != Self::NONE && self.bits().next().is_none())
            .then_some(key!("fault-none-known"))
    }

    /// Known bits that are set in the fault registers, in the order of [`FAULT_BITS`].
    pub fn bits(&self) -> impl Iterator<Item = &'static FaultBit> + use<> {
        let words = self.fault_words();
        FAULT_BITS.iter().filter(move |known| {
            let word = words.iter().find(|(register, _)| *register == known.register);
            word.is_some_and(|(_, word)| word >> known.bit & 1 != 0)
        })
    }

    /// Bits that are set in hfsr and cfsr and have no entry in [`FAULT_BITS`].
    pub fn unknown_bits(&self) -> [(&'static str, u32); 2] {
        self.fault_words().map(|(register, word)| {
            let known = FAULT_BITS.iter().filter(|bit| bit.register == register);
            (register, word & !known.fold(0, |mask, bit| mask | 1 << bit.bit))
        })
    }

    fn fault_words(&self) -> [(&'static str, u32); 2] {
        match self.arch {
            FaultArch::CortexM3([_, _, _, _, hfsr, _, _, cfsr, _, _]) => {
                [("hfsr", hfsr), ("cfsr", cfsr)]
            }
            FaultArch::Arm7Tdmi(_) => [("hfsr", 0), ("cfsr", 0)],
        }
    }

    /// What the processor was executing when the fault occurred.
    pub fn context(&self) -> Context {
        match self.arch {
            FaultArch::CortexM3([.., psr]) => match (psr & 0x1FF) as u16 {
                0 => Context::Program,
                2 => Context::Handler("NMI"),
                3 => Context::Handler("HardFault"),
                4 => Context::Handler("MemManage"),
                5 => Context::Handler("BusFault"),
                6 => Context::Handler("UsageFault"),
                11 => Context::Handler("SVCall"),
                12 => Context::Handler("DebugMonitor"),
                14 => Context::Handler("PendSV"),
                15 => Context::Handler("SysTick"),
                number @ 16.. => Context::Interrupt(number - 16),
                number => Context::Reserved(number),
            },
            FaultArch::Arm7Tdmi([_, spsr]) => match spsr & 0x1F {
                0x10 => Context::Handler("User"),
                0x11 => Context::Handler("FIQ"),
                0x12 => Context::Handler("IRQ"),
                0x13 => Context::Handler("Supervisor"),
                0x17 => Context::Handler("Abort"),
                0x1B => Context::Handler("Undefined"),
                0x1F => Context::Handler("System"),
                mode => Context::Reserved(mode as u16),
            },
        }
    }
}

/// What the processor was executing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Context {
    /// The program itself, not an interrupt.
    Program,
    /// An exception of the processor, or a mode of the ARM7TDMI.
    Handler(&'static str),
    /// An interrupt of this number.
    Interrupt(u16),
    /// A number that the architecture does not use.
    Reserved(u16),
}

impl Context {
    /// Its name where the architecture gives one.
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::Handler(name) => Some(name),
            Self::Program | Self::Interrupt(_) | Self::Reserved(_) => None,
        }
    }

    /// Its description where it has no name; for an interrupt and a reserved number the number
    /// follows.
    pub const fn text(self) -> Option<Key> {
        match self {
            Self::Program => Some(key!("fault-in-program")),
            Self::Handler(_) => None,
            Self::Interrupt(_) => Some(key!("fault-in-interrupt")),
            Self::Reserved(_) => Some(key!("fault-in-unknown")),
        }
    }

    /// Number of the exception, unless the name says it all.
    pub const fn number(self) -> Option<u16> {
        match self {
            Self::Interrupt(number) | Self::Reserved(number) => Some(number),
            Self::Program | Self::Handler(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn cortex(hfsr: u32, cfsr: u32, psr: u32) -> FaultInfo {
        let mut words = [1; 20];
        (words[14], words[17], words[19]) = (hfsr, cfsr, psr);
        FaultInfo::from_words(words)
    }

    /// §3.20
    #[test]
    fn registers_in_words() {
        let info = cortex(1 << 30, 1 << 1 | 1 << 7, 0x0100_0000);
        let names: Vec<_> = info.bits().map(|bit| (bit.register, bit.name)).collect();
        assert_eq!(names, [("hfsr", "FORCED"), ("cfsr", "DACCVIOL"), ("cfsr", "MMARVALID")]);
        assert_eq!(info.context(), Context::Program);
        assert_eq!(info.unknown_bits(), [("hfsr", 0), ("cfsr", 0)]);
        let info = cortex(5, 1 << 25 | 1 << 30, 0x0100_0025);
        assert_eq!(info.bits().map(|bit| bit.name).collect::<Vec<_>>(), ["DIVBYZERO"]);
        assert_eq!(info.unknown_bits(), [("hfsr", 5), ("cfsr", 1 << 30)]);
        assert_eq!((info.context(), info.context().number()), (Context::Interrupt(21), Some(21)));
        assert_eq!(cortex(0, 0, 3).context(), Context::Handler("HardFault"));
    }

    #[test]
    fn words_have_names_and_notes() {
        let info = cortex(1 << 30, 1 << 15, 9);
        let words: Vec<_> = info.registers().collect();
        assert_eq!(words.len(), 20);
        assert_eq!(
            (words[0], words[14], words[19]),
            (("signature", 1), ("hfsr", 1 << 30), ("psr", 9))
        );
        let note = |register| info.note(register).map(Key::name);
        assert_eq!((note("mmfar"), note("bfar")), (Some("fault-address-not-valid"), None));
        assert!(note("pc").is_some() && note("r0").is_none());
        assert_eq!(info.summary(), None);
        assert!(cortex(0, 0, 9).summary().is_some_and(|text| text.name() == "fault-none-known"));
        assert_eq!(FaultInfo::NONE.summary(), None);
    }

    #[test]
    fn an_arm7tdmi_has_modes() {
        let mut info = cortex(0xFFFF_FFFF, 0, 0);
        info.arch = FaultArch::Arm7Tdmi([0xD7, 0x12]);
        assert_eq!(info.bits().count(), 0);
        assert_eq!(info.context(), Context::Handler("IRQ"));
        assert_eq!(info.registers().skip(10).collect::<Vec<_>>(), [("cpsr", 0xD7), ("spsr", 0x12)]);
        assert_eq!(info.summary(), None);
    }

    #[test]
    fn each_bit_is_named_once() {
        for (index, bit) in FAULT_BITS.iter().enumerate() {
            let same = |other: &&FaultBit| {
                other.name == bit.name || (other.register, other.bit) == (bit.register, bit.bit)
            };
            assert_eq!(FAULT_BITS.iter().position(|other| same(&other)), Some(index));
        }
    }
}
