//! §3.4 GetParam.

use super::drive_param;
use super::s3_21_hotbeds::hotbed_values;
use crate::answers::Answers;
use crate::device::Device;
use crate::params::VALUES_MAX;
use crate::subsystem::of_axis;
use lafet_proto::answer::Reply;
use lafet_proto::param::{Access, Param, Placement};
use lafet_proto::{Answer, Ints, ParamId, RequestId, Status, SubsystemId};

/// What the monitor measures, by where it is read.
enum Measured {
    FaultInfo,
    InputFaults,
    Hotbeds,
    Drive,
    #[cfg(feature = "update")]
    Software,
}

const fn measured(param: Param) -> Option<Measured> {
    match param {
        Param::GeneralFaultInfo => Some(Measured::FaultInfo),
        Param::GeneralInputFaults => Some(Measured::InputFaults),
        Param::DetectorHotbeds => Some(Measured::Hotbeds),
        Param::VerticalStopLagSeen
        | Param::VerticalMinSpeedSeen
        | Param::HorizontalStopLagSeen
        | Param::HorizontalMinSpeedSeen
        | Param::NozzleStopLagSeen
        | Param::NozzleMinSpeedSeen
        | Param::DeployerStopLagSeen
        | Param::DeployerMinSpeedSeen => Some(Measured::Drive),
        #[cfg(feature = "update")]
        Param::GeneralSoftwareVersion | Param::GeneralSoftwareSlot | Param::GeneralSoftwareHash => {
            Some(Measured::Software)
        }
        _ => None,
    }
}

// A measured parameter without an arm above would be answered with its default.
const _: () = {
    let mut rest: &[Param] = &Param::ALL;
    while let [param, others @ ..] = rest {
        let is_measured = matches!(param.spec().access, Access::ReadOnly);
        assert!(is_measured == measured(*param).is_some(), "a measured parameter is not read");
        rest = others;
    }
};

impl Device {
    // Apart: the values must not lie on top of what other requests need.
    #[inline(never)]
    pub(super) fn tell_param(
        &mut self,
        from: SubsystemId,
        request: RequestId,
        id: ParamId,
        answers: &mut Answers<'_>,
    ) {
        let mut buffer = [0; VALUES_MAX];
        let (status, values) = match self.read_param(from, id, &mut buffer) {
            Ok(values) => (Status::OK, values),
            Err(status) => (status, [].as_slice()),
        };
        let data = Reply::Param { id, values: Ints::Values(values) };
        answers.push(&Answer { from, request, status, data });
    }

    /// §3.4
    #[inline(never)]
    fn read_param<'b>(
        &mut self,
        id: SubsystemId,
        param: ParamId,
        buffer: &'b mut [i32; VALUES_MAX],
    ) -> Result<&'b [i32], Status> {
        // §3.4/1
        let param = Param::find(id, param).ok_or(Status::INVALID_ID)?;
        match measured(param) {
            Some(Measured::FaultInfo) => return Ok(self.crash_values(buffer)),
            Some(Measured::InputFaults) => {
                let [first, ..] = buffer;
                *first = self.input_faults();
                return Ok(core::slice::from_ref(first));
            }
            // §3.21/1
            Some(Measured::Hotbeds) => return Ok(hotbed_values(self.detector.hotbeds(), buffer)),
            #[cfg(feature = "update")]
            Some(Measured::Software) => {
                return self.software.read(param, buffer).ok_or(Status::INVALID_ID);
            }
            // A drive reports it as one of its parameters.
            Some(Measured::Drive) | None => {}
        }
        let staged = drive_param(param)
            .and_then(|(axis, which)| of_axis(&self.drives, axis).staged_param(which));
        let value = match (staged, self.remote_link(id)) {
            (Some(value), _) => Some(value),
            // §3.4/2
            (None, Some(link)) if param.kind().placement == Placement::Unit => {
                Some(link.read(param.id()).ok_or(Status::NOT_CACHED)?)
            }
            (None, _) => None,
        };
        match (value, buffer) {
            (Some(value), [first, ..]) => {
                *first = value;
                Ok(core::slice::from_ref(first))
            }
            (None, buffer) => self.params.read(param, buffer),
        }
    }
}
