//! Text form of requests.

use super::{Hex, find_param, write_param, write_request};
use crate::id::SubsystemId;
use crate::param::Unit;
use crate::record::Record;
use crate::request::{
    Body, Request, bus, s3_01_move, s3_04_getparam, s3_05_setparam, s3_06_correction_table,
    s3_08_open, s3_09_close, s3_14_quench, s3_15_trajectory, s3_16_seek, s3_17_switch_limits,
    s3_18_lockout, s3_19_clean_flash,
};
use crate::{Ints, ParamId};
use core::fmt::{self, Display};

impl Display for Request<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Body::Unknown { request, data } = self.body {
            // The number, not the name: the data are not valid for the named request.
            write!(f, "{:#04x} {}", request.0, self.to)?;
            return if data.is_empty() { Ok(()) } else { write!(f, " {}", Hex(data)) };
        }
        write_request(f, self.body.id())?;
        write!(f, " {}", self.to)?;
        write_data(f, self.to, &self.body)
    }
}

/// A request's record as text; one with invalid data is shown raw, with the reason.
#[derive(Clone, Copy, Debug)]
pub struct RequestText<'a>(pub Record<'a>);

impl Display for RequestText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Record { request, device, data, .. } = self.0;
        match Request::decode(&self.0) {
            Ok(request) => request.fmt(f),
            Err(error) => {
                Request::new(device, Body::Unknown { request, data }).fmt(f)?;
                f.write_str(" # ")?;
                write_request(f, request)?;
                write!(f, ": {error}")
            }
        }
    }
}

fn write_data(f: &mut fmt::Formatter<'_>, to: SubsystemId, body: &Body<'_>) -> fmt::Result {
    match *body {
        Body::Move { destination } => s3_01_move::write(f, destination),
        Body::GetParam { id } => s3_04_getparam::write(f, to, id),
        Body::SetParam { id, values } => s3_05_setparam::write(f, to, id, values),
        Body::SetupCorrectionTable { first, corrections } => {
            s3_06_correction_table::write(f, first, corrections)
        }
        Body::Open { key } => s3_08_open::write(f, key),
        Body::Close { key } => s3_09_close::write(f, key),
        Body::StartQuench(quench) => s3_14_quench::write(f, &quench),
        Body::StartTrajectory(trajectory) => s3_15_trajectory::write(f, &trajectory),
        Body::StartSeek(seek) => s3_16_seek::write(f, &seek),
        Body::SwitchLimits { new_state } => s3_17_switch_limits::write(f, new_state),
        Body::Lockout { key } => s3_18_lockout::write(f, key),
        Body::CleanFlash { key } => s3_19_clean_flash::write(f, key),
        Body::GetLog { first, count } => bus::write_log(f, first, count),
        Body::Unknown { .. }
        | Body::Stop
        | Body::GetStatus
        | Body::RetrieveLimits
        | Body::Deploy
        | Body::Wrap
        | Body::Restart
        | Body::StartJustify
        | Body::GetHotbed
        | Body::GetCrashData
        | Body::AccessGranted
        | Body::GetNetworkStatus => Ok(()),
    }
}

/// The key is left out if it is the one of the document.
pub(crate) fn write_key(f: &mut fmt::Formatter<'_>, key: u16, implied: u16) -> fmt::Result {
    if key == implied { Ok(()) } else { write!(f, " key={key:#06x}") }
}

/// A parameter and its values.
pub(crate) fn write_values(
    f: &mut fmt::Formatter<'_>,
    to: SubsystemId,
    id: ParamId,
    values: Ints<'_>,
) -> fmt::Result {
    f.write_str(" ")?;
    write_param(f, to, id)?;
    let bits = find_param(to, id).is_some_and(|param| param.spec().unit == Unit::Bits);
    values
        .iter()
        .try_for_each(|value| if bits { write!(f, " {value:#x}") } else { write!(f, " {value}") })
}
