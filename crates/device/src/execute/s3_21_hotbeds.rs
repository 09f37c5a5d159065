//! §3.21 Hotbeds: GetHotbed, and the parameter of this name.

use crate::answers::Answers;
use crate::device::Device;
use crate::params::VALUES_MAX;
use lafet_proto::status::Hotbed;
use lafet_proto::{ParamId, RequestId, SubsystemId};

impl Device {
    /// §3.21/2
    #[inline(always)]
    pub(super) fn tell_hotbeds(&mut self, from: SubsystemId, answers: &mut Answers<'_>) {
        self.tell_param(from, RequestId::GET_HOTBED, ParamId::HOTBEDS, answers);
    }
}

/// §3.21 Hotbeds as the values of the parameter.
pub(super) fn hotbed_values<'b>(
    hotbeds: &[Hotbed],
    buffer: &'b mut [i32; VALUES_MAX],
) -> &'b [i32] {
    let (chunks, _) = buffer.as_chunks_mut();
    let mut len = 0;
    for (values, hotbed) in chunks.iter_mut().zip(hotbeds.iter().take(Hotbed::MAX)) {
        *values = hotbed.to_values();
        len += values.len();
    }
    buffer.get(..len).unwrap_or_default()
}
