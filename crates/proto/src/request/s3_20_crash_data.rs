//! §3.20 GetCrashData: the registers saved at the last hardware fault. No data.

use super::{Body, none};
use crate::dictionary::layouts::{Layout, fields, names};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::GET_CRASH_DATA,
    name: "GetCrashData",
    section: "3.20",
    origin: Origin::Read,
    addressees: &[SubsystemId::GENERAL, SubsystemId::ALL],
    title: key!("request-GetCrashData-title"),
    meaning: key!("request-GetCrashData-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::GetCrashData)
}

/// Registers saved at a hardware fault (§3.20): 20 words, 80 bytes on Cortex-M3.
///
/// Ten common words, then those of the architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultInfo {
    /// Marks the block as filled; 0 when there was no fault.
    pub signature: u32,
    /// Architecture; selects the variant of `arch`.
    pub archtype: u32,
    /// Stack pointer in the fault exception.
    pub spcr: u32,
    /// Stacked r0.
    pub r0: u32,
    /// Stacked r1.
    pub r1: u32,
    /// Stacked r2.
    pub r2: u32,
    /// Stacked r3.
    pub r3: u32,
    /// Stacked r12.
    pub r12: u32,
    /// Stacked link register.
    pub lr: u32,
    /// Stacked program counter.
    pub pc: u32,
    /// Registers of the architecture.
    pub arch: FaultArch,
}

/// The part of [`FaultInfo`] that differs with the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultArch {
    /// Ten words: tim2 cnt, tim3 cnt, tim4 cnt, tim5 cnt, hfsr, bfar, mmfar, cfsr, tcb, psr.
    CortexM3([u32; 10]),
    /// Two words: cpsr, spsr.
    Arm7Tdmi([u32; 2]),
}

impl FaultInfo {
    /// Bytes on the wire from a Cortex-M3.
    pub const SIZE: usize = 80;
    /// Bytes on the wire from an ARM7TDMI that does not pad the union.
    pub const SIZE_ARM7TDMI: usize = 48;
    /// Names of the common words, then of the Cortex-M3 ones.
    pub const NAMES: [&'static str; 20] = names(CORTEX_M3.fields);
    /// Names of the ARM7TDMI's words.
    pub const NAMES_ARM7TDMI: [&'static str; 2] = names(ARM7TDMI.repeated);

    /// No fault recorded.
    pub const NONE: Self = Self::from_words([0; 20]);

    /// The block of a Cortex-M3 from its words.
    #[inline(never)]
    pub const fn from_words(words: [u32; 20]) -> Self {
        let [signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, a, b, c, d, e, f, g, h, i, j] =
            words;
        Self {
            signature,
            archtype,
            spcr,
            r0,
            r1,
            r2,
            r3,
            r12,
            lr,
            pc,
            arch: FaultArch::CortexM3([a, b, c, d, e, f, g, h, i, j]),
        }
    }

    /// The words of the block; those that an ARM7TDMI does not have are 0.
    #[inline(never)]
    pub const fn to_words(self) -> [u32; 20] {
        let [a, b, c, d, e, f, g, h, i, j] = match self.arch {
            FaultArch::CortexM3(words) => words,
            FaultArch::Arm7Tdmi([cpsr, spsr]) => [cpsr, spsr, 0, 0, 0, 0, 0, 0, 0, 0],
        };
        let Self { signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, .. } = self;
        [signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, a, b, c, d, e, f, g, h, i, j]
    }

    /// Reads 80 bytes (Cortex-M3) or 48 (ARM7TDMI); `None` for any other size.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != Self::SIZE && bytes.len() != Self::SIZE_ARM7TDMI {
            return None;
        }
        let mut words = [0; 20];
        for (word, chunk) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_le_bytes(*chunk);
        }
        let mut info = Self::from_words(words);
        if let (Self::SIZE_ARM7TDMI, FaultArch::CortexM3([cpsr, spsr, ..])) =
            (bytes.len(), info.arch)
        {
            info.arch = FaultArch::Arm7Tdmi([cpsr, spsr]);
        }
        Some(info)
    }
}

pub(crate) const CORTEX_M3: Layout = Layout::plain(
    "FaultInfo",
    fields! { FaultInfo:
        signature U32 Bits;
        archtype U32 Bits;
        spcr U32 Bits;
        r0 U32 Bits;
        r1 U32 Bits;
        r2 U32 Bits;
        r3 U32 Bits;
        r12 U32 Bits;
        lr U32 Bits;
        pc U32 Bits;
        tim2_cnt U32 None;
        tim3_cnt U32 None;
        tim4_cnt U32 None;
        tim5_cnt U32 None;
        hfsr U32 Bits;
        bfar U32 Bits;
        mmfar U32 Bits;
        cfsr U32 Bits;
        tcb U32 Bits;
        psr U32 Bits;
    },
);
pub(crate) const ARM7TDMI: Layout = Layout {
    name: "FaultInfoArm7tdmi",
    fields: CORTEX_M3.fields.split_at(10).0,
    repeated: fields! { FaultInfo:
        cpsr U32 Bits;
        spsr U32 Bits;
    },
    times: (1, 1),
    prefix: &[],
};
