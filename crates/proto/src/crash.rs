//! §3.20 Meaning of the fault registers of `fault_info`, bit by bit, in English and Russian.
//!
//! Bits are those of the ARMv7-M architecture (Cortex-M3: hfsr, cfsr, psr) and of the ARM7TDMI
//! (cpsr, spsr); their texts are ours.

use crate::dictionary::Text;
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
    pub meaning: Text,
    /// What to do.
    pub remedy: Text,
}

const fn bit(
    register: &'static str,
    bit: u8,
    name: &'static str,
    [meaning_en, meaning_ru]: [&'static str; 2],
    [remedy_en, remedy_ru]: [&'static str; 2],
) -> FaultBit {
    let meaning = Text::new(meaning_en, meaning_ru);
    FaultBit { register, bit, name, meaning, remedy: Text::new(remedy_en, remedy_ru) }
}

const PROGRAM: [&str; 2] = [
    "Look up pc and lr in the program's listing; send both with the version to its maker.",
    "Найдите pc и lr в листинге программы; сообщите их и версию изготовителю.",
];
const STACK: [&str; 2] = [
    "The stack is too small or its pointer was overwritten: compare spcr with the stack's bounds.",
    "Стек мал либо указатель испорчен: сравните spcr с границами стека.",
];
const MEMORY: [&str; 2] = [
    "Compare the address with the memory map; if it is in the flash or RAM, check the supply and \
     replace the board.",
    "Сравните адрес с картой памяти; если он во Flash или ОЗУ, проверьте питание и замените плату.",
];
const ADDRESS: [&str; 2] = [
    "Read that address together with the adjacent bits.",
    "Рассматривайте этот адрес вместе с соседними битами.",
];

/// Every bit of hfsr and cfsr that the architecture defines.
pub const FAULT_BITS: [FaultBit; 23] = [
    bit(
        "hfsr",
        1,
        "VECTTBL",
        [
            "The vector table could not be read when an exception began.",
            "При входе в исключение не удалось прочитать таблицу векторов.",
        ],
        [
            "The program in the flash is damaged or its vector table misplaced: write it again.",
            "Программа во Flash повреждена или таблица векторов не на месте: запишите её заново.",
        ],
    ),
    bit(
        "hfsr",
        30,
        "FORCED",
        [
            "Another fault could not be handled as such and became a hard fault; cfsr says which.",
            "Другой отказ не мог быть обработан и стал тяжёлым; какой — говорит cfsr.",
        ],
        ["See the bits of cfsr.", "Смотрите биты cfsr."],
    ),
    bit(
        "hfsr",
        31,
        "DEBUGEVT",
        [
            "A debug event, such as a breakpoint, without a debugger.",
            "Событие отладки, например точка останова, без отладчика.",
        ],
        [
            "A test build is installed, or the program stopped itself: install a release build.",
            "Установлена отладочная сборка либо программа остановила себя сама: поставьте рабочую.",
        ],
    ),
    bit(
        "cfsr",
        0,
        "IACCVIOL",
        [
            "The program went on at an address where nothing may be executed.",
            "Программа перешла по адресу, где исполнение запрещено.",
        ],
        PROGRAM,
    ),
    bit(
        "cfsr",
        1,
        "DACCVIOL",
        [
            "The program read or wrote an address that it may not.",
            "Программа обратилась к запрещённому адресу.",
        ],
        PROGRAM,
    ),
    bit(
        "cfsr",
        3,
        "MUNSTKERR",
        [
            "Protected memory was hit while the registers were taken back from the stack.",
            "Защищённая память при возврате регистров из стека.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        4,
        "MSTKERR",
        [
            "Protected memory was hit while the registers were put on the stack.",
            "Защищённая память при сохранении регистров в стек.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        5,
        "MLSPERR",
        [
            "Protected memory was hit while the floating-point registers were saved.",
            "Защищённая память при сохранении регистров с плавающей точкой.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        7,
        "MMARVALID",
        ["mmfar holds the address that was hit.", "mmfar содержит адрес обращения."],
        ADDRESS,
    ),
    bit(
        "cfsr",
        8,
        "IBUSERR",
        ["An instruction could not be fetched.", "Не удалось выбрать команду из памяти."],
        MEMORY,
    ),
    bit(
        "cfsr",
        9,
        "PRECISERR",
        [
            "A read or write failed on the bus; pc is the instruction that did it.",
            "Ошибка обращения к данным (BusFault); pc указывает на команду.",
        ],
        MEMORY,
    ),
    bit(
        "cfsr",
        10,
        "IMPRECISERR",
        [
            "A write failed on the bus some time before pc.",
            "Ошибка записи (BusFault), случившаяся несколько раньше pc.",
        ],
        MEMORY,
    ),
    bit(
        "cfsr",
        11,
        "UNSTKERR",
        [
            "The bus failed while the registers were taken back from the stack.",
            "Ошибка обращения (BusFault) при возврате регистров из стека.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        12,
        "STKERR",
        [
            "The bus failed while the registers were put on the stack.",
            "Ошибка обращения (BusFault) при сохранении регистров в стек.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        13,
        "LSPERR",
        [
            "The bus failed while the floating-point registers were saved.",
            "Ошибка обращения (BusFault) при сохранении регистров с плавающей точкой.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        15,
        "BFARVALID",
        ["bfar holds the address that was hit.", "bfar содержит адрес обращения."],
        ADDRESS,
    ),
    bit(
        "cfsr",
        16,
        "UNDEFINSTR",
        [
            "An instruction that does not exist; also how a panic can end a program.",
            "Несуществующая команда; так же программа может завершать себя сама.",
        ],
        PROGRAM,
    ),
    bit(
        "cfsr",
        17,
        "INVSTATE",
        [
            "A jump to an even address, which would leave the Thumb state.",
            "Переход по чётному адресу, то есть выход из режима Thumb.",
        ],
        PROGRAM,
    ),
    bit(
        "cfsr",
        18,
        "INVPC",
        [
            "A return from an exception with a wrong value.",
            "Возврат из исключения с неверным значением.",
        ],
        STACK,
    ),
    bit(
        "cfsr",
        19,
        "NOCP",
        [
            "A coprocessor or floating-point unit that is absent or off.",
            "Обращение к отсутствующему или выключенному сопроцессору.",
        ],
        [
            "The program was built for another processor: install the one for this board.",
            "Программа собрана для другого процессора: установите сборку для этой платы.",
        ],
    ),
    bit(
        "cfsr",
        20,
        "STKOF",
        ["The stack has overflowed (ARMv8-M only).", "Переполнение стека (только ARMv8-M)."],
        STACK,
    ),
    bit(
        "cfsr",
        24,
        "UNALIGNED",
        [
            "An access to an address that is not a multiple of its size.",
            "Обращение по невыровненному адресу.",
        ],
        PROGRAM,
    ),
    bit("cfsr", 25, "DIVBYZERO", ["A division by zero.", "Деление на ноль."], PROGRAM),
];

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
    pub fn note(&self, register: &str) -> Option<Text> {
        let stale = |valid| {
            let text = Text::new("no address: not valid", "адрес недействителен");
            (!self.bits().any(|bit| bit.name == valid)).then_some(text)
        };
        match register {
            "pc" => {
                Some(Text::new("the instruction that failed", "команда, на которой случился отказ"))
            }
            "lr" => Some(Text::new("where it was called from", "откуда она была вызвана")),
            "mmfar" => stale("MMARVALID"),
            "bfar" => stale("BFARVALID"),
            _ => None,
        }
    }

    /// A summary of a record in which no known bit is set.
    pub fn summary(&self) -> Option<Text> {
        let cortex = matches!(self.arch, FaultArch::CortexM3(_));
        (cortex && *self != Self::NONE && self.bits().next().is_none()).then_some(Text::new(
            "No known bit of hfsr or cfsr is set: the processor found no fault. The program \
             stopped itself or the watchdog did; pc and lr say where.",
            "Известные биты hfsr и cfsr не установлены: процессор отказа не нашёл. Программа \
             остановила себя сама либо сработал сторожевой таймер; где — скажут pc и lr.",
        ))
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
    pub const fn text(self) -> Option<Text> {
        match self {
            Self::Program => {
                Some(Text::new("the program, no interrupt", "программа, не прерывание"))
            }
            Self::Handler(_) => None,
            Self::Interrupt(_) => Some(Text::new("interrupt", "прерывание")),
            Self::Reserved(_) => Some(Text::new("unknown number", "неизвестный номер")),
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
        let note = |register| info.note(register).map(|text| text.en);
        assert_eq!((note("mmfar"), note("bfar")), (Some("no address: not valid"), None));
        assert!(note("pc").is_some() && note("r0").is_none());
        assert_eq!(info.summary(), None);
        assert!(cortex(0, 0, 9).summary().is_some_and(|text| text.en.contains("watchdog")));
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
    fn each_bit_is_named_once_and_in_both_languages() {
        for (index, bit) in FAULT_BITS.iter().enumerate() {
            let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
            assert!(cyrillic(bit.meaning.ru) && cyrillic(bit.remedy.ru), "{}", bit.name);
            assert!(!cyrillic(bit.meaning.en) && !cyrillic(bit.remedy.en), "{}", bit.name);
            let same = |other: &&FaultBit| {
                other.name == bit.name || (other.register, other.bit) == (bit.register, bit.bit)
            };
            assert_eq!(FAULT_BITS.iter().position(|other| same(&other)), Some(index));
        }
    }
}
