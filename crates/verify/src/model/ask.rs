//! The requests of the model.

use lafet_device::image::{Axis, ValveNo};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Seek, Trajectory, TrajectoryPoint};
use lafet_proto::{Bytes, Ints, Request, SubsystemId};

/// A request whose data is static.
pub type Ask = Request<'static>;

const fn ask(to: SubsystemId, body: Body<'static>) -> Ask {
    Request { to, body }
}

/// Stop All.
pub const STOP_ALL: Ask = stop(SubsystemId::ALL);
/// Deploy.
pub const DEPLOY: Ask = ask(SubsystemId::DEPLOYER, Body::Deploy);
/// Wrap.
pub const WRAP: Ask = ask(SubsystemId::DEPLOYER, Body::Wrap);
/// Restart.
pub const RESTART: Ask = ask(SubsystemId::ALL, Body::Restart);
/// Lockout on.
pub const LOCK: Ask = ask(SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
/// Lockout off.
pub const UNLOCK: Ask = ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
/// Erase the memory.
pub const CLEAN: Ask = ask(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
/// Align detector and barrel.
pub const JUSTIFY: Ask = ask(SubsystemId::DETECTOR, Body::StartJustify);
/// A search to the right of the barrel's rest.
pub const SEEK: Ask = seek(-300, 0);
/// The same, with a second pass that measures.
pub const ANALYSE: Ask = seek(-300, 1);
/// A search straight ahead.
pub const SEEK_AHEAD: Ask = seek(0, 0);
/// A sector of one line, left and right of the barrel's rest.
pub const QUENCH: Ask =
    ask(SubsystemId::CONTROL, Body::StartQuench(Quench::Full { sector: SECTOR, distance: 0 }));
/// The same sector with a chosen nozzle position, raised by a table when there is pressure.
pub const RAISED: Ask = ask(
    SubsystemId::CONTROL,
    Body::StartQuench(Quench::Corrected {
        sector: Sector { nozzle: 0, ..SECTOR },
        corrections: Bytes(&[0, 5]),
    }),
);
/// A trajectory of two points.
pub const TRAJECTORY: Ask = ask(
    SubsystemId::CONTROL,
    Body::StartTrajectory(Trajectory {
        ballistics: false,
        repeat: false,
        path: Path::Points(Points::Values(&[
            TrajectoryPoint { horizontal: 300, vertical: 0, distance: 0, dwell: 0 },
            TrajectoryPoint { horizontal: -300, vertical: 0, distance: 0, dwell: 0 },
        ])),
    }),
);
/// Limits of all drives off.
pub const LIMITS_OFF: Ask = limits(0);
/// Limits of all drives on.
pub const LIMITS_ON: Ask = limits(1);
/// Reject: limits on, with their old values.
pub const LIMITS_REJECT: Ask = limits(2);
/// Makes 600' the upper limit of Horizontal, if that is its present position.
pub const TAKE_LIMIT: Ask = take(Param::HorizontalMaxLimit, &[600]);

const SECTOR: Sector =
    Sector { centre_h: 0, centre_v: 0, nozzle: 60, width: 600, height: 0, step: 1 };

/// Stop of a subsystem.
pub const fn stop(to: SubsystemId) -> Ask {
    ask(to, Body::Stop)
}

/// Move of a drive; a distant destination moves it to its limit.
pub const fn go(axis: Axis, destination: i16) -> Ask {
    ask(axis.id(), Body::Move { destination })
}

/// Open of a valve.
pub const fn open(valve: ValveNo) -> Ask {
    ask(valve.id(), Body::Open { key: key::OPEN })
}

/// Close of a valve.
pub const fn close(valve: ValveNo) -> Ask {
    ask(valve.id(), Body::Close { key: key::CLOSE })
}

const fn seek(at: i16, analyse: i16) -> Ask {
    let seek = Seek { start_h: at, end_h: at, start_v: 0, end_v: 0, analyse };
    ask(SubsystemId::DETECTOR, Body::StartSeek(seek))
}

const fn limits(new_state: u16) -> Ask {
    ask(SubsystemId::ALL, Body::SwitchLimits { new_state })
}

const fn take(param: Param, value: &'static [i32]) -> Ask {
    let spec = param.spec();
    ask(spec.subsystem, Body::SetParam { id: spec.id, values: Ints::Values(value) })
}
