//! Text form of requests.

use super::{Hex, find_param, write_list, write_param, write_request};
use crate::id::{SubsystemId, key};
use crate::param::Unit;
use crate::record::Record;
use crate::request::{Body, LimitsState, Path, Quench, Request, Sector, Trajectory};
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
        Body::Move { destination } => write!(f, " {destination}"),
        Body::GetParam { id } => write_values(f, to, id, Ints::Values(&[])),
        Body::SetParam { id, values } => write_values(f, to, id, values),
        Body::SetupCorrectionTable { first, corrections } => {
            write!(f, " first={first} corrections=")?;
            write_list(f, ",", corrections.iter())
        }
        Body::Open { key } => write_key(f, key, key::OPEN),
        Body::Close { key } => write_key(f, key, key::CLOSE),
        Body::CleanFlash { key } => write_key(f, key, key::CLEAN_FLASH),
        Body::StartQuench(quench) => write_quench(f, &quench),
        Body::StartTrajectory(trajectory) => write_trajectory(f, &trajectory),
        Body::StartSeek(seek) => {
            write!(f, " {} {} {} {}", seek.start_h, seek.end_h, seek.start_v, seek.end_v)?;
            match seek.analyse {
                0 => Ok(()),
                1 => f.write_str(" analyse"),
                other => write!(f, " analyse={other}"),
            }
        }
        Body::SwitchLimits { new_state } => match LimitsState::from_wire(new_state) {
            Some(LimitsState::Off) => f.write_str(" off"),
            Some(LimitsState::On) => f.write_str(" on"),
            Some(LimitsState::Reject) => f.write_str(" reject"),
            None => write!(f, " state={new_state}"),
        },
        Body::Lockout { key: key::ENABLE } => f.write_str(" on"),
        Body::Lockout { key: key::DISABLE } => f.write_str(" off"),
        Body::Lockout { key } => write!(f, " key={key:#06x}"),
        Body::GetLog { first, count } => write!(f, " first={first} count={count}"),
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
fn write_key(f: &mut fmt::Formatter<'_>, key: u16, implied: u16) -> fmt::Result {
    if key == implied { Ok(()) } else { write!(f, " key={key:#06x}") }
}

fn write_values(
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

fn write_quench(f: &mut fmt::Formatter<'_>, quench: &Quench<'_>) -> fmt::Result {
    match *quench {
        Quench::Program { program, centre_h, centre_v, nozzle } => {
            write!(f, " program={program} centre={centre_h},{centre_v} nozzle={nozzle}")
        }
        Quench::Full { sector, distance } => {
            write_sector(f, &sector)?;
            write!(f, " distance={distance}")
        }
        Quench::Corrected { sector, corrections } => {
            write_sector(f, &sector)?;
            f.write_str(" corrections=")?;
            write_list(f, ",", corrections.iter())
        }
    }
}

fn write_sector(f: &mut fmt::Formatter<'_>, sector: &Sector) -> fmt::Result {
    let Sector { centre_h, centre_v, nozzle, width, height, step } = sector;
    write!(f, " centre={centre_h},{centre_v} nozzle={nozzle} sector={width},{height} step={step}")
}

fn write_trajectory(f: &mut fmt::Formatter<'_>, trajectory: &Trajectory<'_>) -> fmt::Result {
    if trajectory.ballistics {
        f.write_str(" ballistics")?;
    }
    if trajectory.repeat {
        f.write_str(" repeat")?;
    }
    match trajectory.path {
        Path::Stored(numbers) => {
            f.write_str(" stored=")?;
            write_list(f, ",", numbers)
        }
        Path::Points(points) => points.iter().try_for_each(|p| {
            write!(f, " point={},{},{},{}", p.horizontal, p.vertical, p.distance, p.dwell)
        }),
    }
}
