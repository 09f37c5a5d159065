//! §3.20 GetCrashData, and the parameter of General that has the same words.

use crate::device::Device;
use crate::params::VALUES_MAX;
use lafet_proto::answer::Reply;

impl Device {
    /// §3.20/1
    #[inline(always)]
    pub(super) fn crash_data(&self) -> Reply<'static> {
        Reply::Fault(self.general.crash())
    }

    /// The words as the values of a parameter.
    #[inline(always)]
    pub(super) fn crash_values<'b>(&self, buffer: &'b mut [i32; VALUES_MAX]) -> &'b [i32] {
        for (value, word) in buffer.iter_mut().zip(self.general.crash().to_words()) {
            *value = word.cast_signed();
        }
        buffer.get(..20).unwrap_or_default()
    }
}
