//! Registers and memory by their address.

use stm32_metapac as pac;
use stm32_metapac::common::{Access, Reg};

/// What leads to the registers and memory of a chip: the chip itself, or a model. A handle: clones lead
/// to the same chip.
pub trait Bus: Clone {
    /// Reads a register, or a word of RAM or flash. The address must be one of the chip's.
    fn read(&self, address: u32) -> u32;

    /// Writes a register.
    fn write(&self, address: u32, value: u32);

    /// Reads a byte of RAM or flash.
    fn read8(&self, address: u32) -> u8;

    /// Writes a byte of RAM.
    fn write8(&self, address: u32, value: u8);

    /// Writes half a word: to RAM, or to the flash where that is unlocked.
    fn write16(&self, address: u32, value: u16);

    /// Resets the chip. On a chip it does not come back.
    fn reset(&self);
}

/// The fields of a register, as the PAC has them, and their bits.
pub trait Fields: Copy {
    /// The fields of these bits.
    fn of(bits: u32) -> Self;

    /// The bits.
    fn bits(self) -> u32;
}

impl Fields for u32 {
    fn of(bits: u32) -> Self {
        bits
    }

    fn bits(self) -> u32 {
        self
    }
}

impl Fields for u16 {
    fn of(bits: u32) -> Self {
        bits as Self
    }

    fn bits(self) -> u32 {
        self.into()
    }
}

macro_rules! fields {
    ($($module:ident: $($name:ident)+;)+) => {
        $($(
            impl Fields for pac::$module::regs::$name {
                fn of(bits: u32) -> Self {
                    Self(bits)
                }

                fn bits(self) -> u32 {
                    self.0
                }
            }
        )+)+
    };
}

fields! {
    adc: Cr1 Cr2 Smpr1 Smpr2 Sqr1 Sqr2 Sqr3;
    afio: Mapr;
    bdma: Cr Isr Ndtr;
    bkp: Dr;
    flash: Acr Ar Cr Sr;
    gpio: Bsrr Cr Idr Odr;
    iwdg: Kr Pr Rlr Sr;
    pwr: Cr Csr;
    rcc: Ahbenr Apb1enr Apb2enr Cfgr Cr Csr;
    timer: ArrCore BdtrAdv CcerAdv CcerGp16 CcmrInput2ch CcmrOutputGp16 Ccr1ch CntCore Cr1Core Cr1Gp16
        Cr2Adv EgrAdv EgrCore RcrAdv SmcrGp16 SrAdv;
    usart: Brr Cr1 Cr3Usart Dr Sr;
}

/// Registers by their fields.
pub trait Registers: Bus {
    /// The register as it is.
    fn get<T: Fields, A: Access>(&self, register: Reg<T, A>) -> T {
        T::of(self.read(address(register)))
    }

    /// Writes the register.
    fn put<T: Fields, A: Access>(&self, register: Reg<T, A>, fields: T) {
        self.write(address(register), fields.bits());
    }

    /// Writes the register with these fields, and 0 in all others.
    fn set<T: Fields, A: Access>(&self, register: Reg<T, A>, fill: impl FnOnce(&mut T)) {
        let mut fields = T::of(0);
        fill(&mut fields);
        self.put(register, fields);
    }

    /// Changes these fields and leaves the others.
    fn change<T: Fields, A: Access>(&self, register: Reg<T, A>, change: impl FnOnce(&mut T)) {
        let mut fields = self.get(register);
        change(&mut fields);
        self.put(register, fields);
    }

    /// Waits until the register is so, for so many looks at most; whether it came.
    fn wait<T: Fields, A: Access>(
        &self,
        register: Reg<T, A>,
        looks: u32,
        is_so: impl Fn(T) -> bool,
    ) -> bool {
        (0..looks).any(|_| is_so(self.get(register)))
    }
}

impl<B: Bus> Registers for B {}

/// Where a register is.
pub fn address<T: Copy, A: Access>(register: Reg<T, A>) -> u32 {
    register.as_ptr() as usize as u32
}
