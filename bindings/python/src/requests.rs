//! The requests of the document (§3).

use lafet_client::{RequestBuf, parse_error_text};
use lafet_proto::request::{Body, LimitsState, Path, Points, Quench, Sector, Seek};
use lafet_proto::request::{Trajectory, TrajectoryPoint};
use lafet_proto::{Bytes, RequestId, SubsystemId, text};
use lafet_texts::{Lang, Shown, Text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::failures::{Failure, language};
use crate::texts::say;

/// A request to a subsystem, encoded.
#[pyclass(frozen, module = "lafet._native")]
#[derive(Clone)]
pub struct Request(pub RequestBuf);

/// The subsystem of this name.
pub fn subsystem(name: &str) -> PyResult<SubsystemId> {
    SubsystemId::from_name(name).ok_or_else(|| {
        let all: Vec<&str> = SubsystemId::TABLE.into_iter().filter_map(SubsystemId::name).collect();
        let all = all.join(", ");
        PyValueError::new_err(say("no-subsystem", &[("name", &name), ("all", &all)]))
    })
}

fn request(to: SubsystemId, body: Body<'_>) -> PyResult<Request> {
    let encoded = RequestBuf::new(&lafet_proto::Request::new(to, body));
    encoded.map(Request).map_err(|error| Python::attach(|py| Failure::from(error).raise(py)))
}

#[pymethods]
impl Request {
    /// A request in the words of `lafet send`.
    #[staticmethod]
    fn parse(words: &str) -> PyResult<Self> {
        let mut buffer = [0; 256];
        match text::parse(words, &mut buffer) {
            Ok(parsed) => request(parsed.to, parsed.body),
            Err(error) => Err(PyValueError::new_err(parse_error_text(words, &error, language()))),
        }
    }

    #[staticmethod]
    fn move_to(drive: &str, position: i16) -> PyResult<Self> {
        request(subsystem(drive)?, Body::Move { destination: position })
    }

    #[staticmethod]
    fn stop(whose: &str) -> PyResult<Self> {
        request(subsystem(whose)?, Body::Stop)
    }

    #[staticmethod]
    fn get_status(whose: &str) -> PyResult<Self> {
        request(subsystem(whose)?, Body::GetStatus)
    }

    #[staticmethod]
    fn get_limits(drive: &str) -> PyResult<Self> {
        request(subsystem(drive)?, Body::RetrieveLimits)
    }

    #[staticmethod]
    fn open(valve: &str) -> PyResult<Self> {
        let to = subsystem(valve)?;
        request(to, lafet_proto::Request::open(to).body)
    }

    #[staticmethod]
    fn close(valve: &str) -> PyResult<Self> {
        let to = subsystem(valve)?;
        request(to, lafet_proto::Request::close(to).body)
    }

    #[staticmethod]
    fn deploy() -> PyResult<Self> {
        request(SubsystemId::DEPLOYER, Body::Deploy)
    }

    #[staticmethod]
    fn wrap() -> PyResult<Self> {
        request(SubsystemId::DEPLOYER, Body::Wrap)
    }

    #[staticmethod]
    fn restart() -> PyResult<Self> {
        request(SubsystemId::ALL, Body::Restart)
    }

    #[staticmethod]
    fn justify() -> PyResult<Self> {
        request(SubsystemId::DETECTOR, Body::StartJustify)
    }

    #[staticmethod]
    fn quench_program(program: i16, centre: (i16, i16), nozzle: i16) -> PyResult<Self> {
        let quench = Quench::Program { program, centre_h: centre.0, centre_v: centre.1, nozzle };
        request(SubsystemId::CONTROL, Body::StartQuench(quench))
    }

    #[staticmethod]
    fn quench(
        centre: (i16, i16),
        size: (i16, i16),
        nozzle: i16,
        step: i8,
        distance: i8,
    ) -> PyResult<Self> {
        let sector = sector(centre, size, nozzle, step);
        request(SubsystemId::CONTROL, Body::StartQuench(Quench::Full { sector, distance }))
    }

    #[staticmethod]
    fn quench_corrected(
        centre: (i16, i16),
        size: (i16, i16),
        nozzle: i16,
        step: i8,
        corrections: Vec<i8>,
    ) -> PyResult<Self> {
        let sector = sector(centre, size, nozzle, step);
        let bytes: Vec<u8> = corrections.iter().map(|value| value.to_le_bytes()[0]).collect();
        let quench = Quench::Corrected { sector, corrections: Bytes(&bytes) };
        request(SubsystemId::CONTROL, Body::StartQuench(quench))
    }

    /// Points: horizontal, vertical, distance, dwell in 0.1 s.
    #[staticmethod]
    fn trajectory(
        points: Vec<(i16, i16, u8, u8)>,
        ballistics: bool,
        repeat: bool,
    ) -> PyResult<Self> {
        let point = |(horizontal, vertical, distance, dwell)| TrajectoryPoint {
            horizontal,
            vertical,
            distance,
            dwell,
        };
        let points: Vec<TrajectoryPoint> = points.into_iter().map(point).collect();
        let path = Path::Points(Points::Values(&points));
        let trajectory = Trajectory { ballistics, repeat, path };
        request(SubsystemId::CONTROL, Body::StartTrajectory(trajectory))
    }

    #[staticmethod]
    fn trajectory_stored(numbers: Vec<u8>, ballistics: bool, repeat: bool) -> PyResult<Self> {
        let trajectory = Trajectory { ballistics, repeat, path: Path::Stored(&numbers) };
        request(SubsystemId::CONTROL, Body::StartTrajectory(trajectory))
    }

    #[staticmethod]
    fn seek(horizontal: (i16, i16), vertical: (i16, i16), analyse: bool) -> PyResult<Self> {
        let seek = Seek {
            start_h: horizontal.0,
            end_h: horizontal.1,
            start_v: vertical.0,
            end_v: vertical.1,
            analyse: analyse.into(),
        };
        request(SubsystemId::DETECTOR, Body::StartSeek(seek))
    }

    #[staticmethod]
    fn switch_limits(whose: &str, state: &str) -> PyResult<Self> {
        let known =
            [("off", LimitsState::Off), ("on", LimitsState::On), ("reject", LimitsState::Reject)];
        let found = known.into_iter().find(|(name, _)| *name == state);
        let Some((_, state)) = found else {
            return Err(PyValueError::new_err(say("limits-state", &[("state", &state)])));
        };
        request(subsystem(whose)?, Body::SwitchLimits { new_state: state as u16 })
    }

    #[staticmethod]
    fn lockout(on: bool) -> PyResult<Self> {
        let lockout = lafet_proto::Request::lockout(on);
        request(lockout.to, lockout.body)
    }

    #[staticmethod]
    fn clean_flash() -> PyResult<Self> {
        let key = lafet_proto::id::key::CLEAN_FLASH;
        request(SubsystemId::GENERAL, Body::CleanFlash { key })
    }

    #[staticmethod]
    fn get_crash_data() -> PyResult<Self> {
        request(SubsystemId::GENERAL, Body::GetCrashData)
    }

    /// Any request, by number.
    #[staticmethod]
    fn raw(whose: &str, number: u8, data: &[u8]) -> PyResult<Self> {
        request(subsystem(whose)?, Body::Unknown { request: RequestId(number), data })
    }

    /// The request, by its name.
    #[getter]
    fn name(&self) -> String {
        Shown(&self.0.request().body.id()).of(Lang::En)
    }

    /// The addressee.
    #[getter]
    fn to(&self) -> String {
        Shown(&self.0.request().to).of(Lang::En)
    }

    fn __bytes__(&self) -> &[u8] {
        self.0.bytes()
    }

    fn __repr__(&self) -> String {
        format!("<{} to {}>", self.name(), self.to())
    }
}

const fn sector(centre: (i16, i16), size: (i16, i16), nozzle: i16, step: i8) -> Sector {
    Sector { centre_h: centre.0, centre_v: centre.1, nozzle, width: size.0, height: size.1, step }
}
