//! A monitor with a typed method for each request of §3.

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, LimitsState, Quench, Seek, Trajectory};
use lafet_proto::status::{FaultInfo, Hotbed, Limits};
use lafet_proto::{Bytes, DecodeError, Expected, Ints, ParamId, Request, Status, SubsystemId};

use crate::answers::{AnswerBuf, Answers};
use crate::batch::Progress;
use crate::client::Client;
use crate::deviation::Deviation;
use crate::drive::Drive;
use crate::error::Error;
use crate::status::{MonitorStatus, StatusSubscription};
use crate::url::Endpoint;

/// A monitor. Clones share one connection.
///
/// Every method turns a refusal into [`Error::Refused`]; [`Client::request`] does not.
#[derive(Clone, Debug)]
pub struct Monitor {
    client: Client,
}

impl Monitor {
    /// A monitor on an existing client.
    pub const fn new(client: Client) -> Self {
        Self { client }
    }

    /// Connects: see [`Client::connect`].
    ///
    /// # Errors
    ///
    /// As [`Client::connect`].
    pub async fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Client::connect(endpoint).await.map(Self::new)
    }

    /// The client of this monitor.
    pub const fn client(&self) -> &Client {
        &self.client
    }

    /// Another monitor on the same link: see [`Client::at`].
    ///
    /// # Errors
    ///
    /// As [`Client::at`].
    pub fn at(&self, address: u8) -> Result<Self, Error> {
        self.client.at(address).map(Self::new)
    }

    /// The elevation drive.
    pub fn vertical(&self) -> Drive {
        Drive::new(self.clone(), SubsystemId::VERTICAL)
    }

    /// The traverse drive.
    pub fn horizontal(&self) -> Drive {
        Drive::new(self.clone(), SubsystemId::HORIZONTAL)
    }

    /// The drive of the nozzle.
    pub fn nozzle(&self) -> Drive {
        Drive::new(self.clone(), SubsystemId::NOZZLE)
    }

    /// §3.3 Reads the state of every subsystem each `period`; returns the latest with its age, and
    /// updates. Continues after the connection was lost and restored.
    ///
    /// # Errors
    ///
    /// None in practice: the request is a read and fits a record ([`Error::NotARead`],
    /// [`Error::Unsendable`]). Later errors are updates.
    pub fn watch(&self, period: Duration) -> Result<StatusSubscription, Error> {
        let request = Request::new(SubsystemId::ALL, Body::GetStatus);
        self.client.subscribe(&request, period).map(StatusSubscription::new)
    }

    /// §3.1 Moves a drive to a position, arc-minutes (nozzle: mm), positive up and left. A position
    /// beyond a limit means the limit.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` while the monitor is not deployed
    /// or searches, `MODULE_FAULT` of a faulty drive (§3.1).
    pub async fn move_to(&self, drive: SubsystemId, position: i16) -> Result<Status, Error> {
        self.command(drive, Body::Move { destination: position }).await
    }

    /// §3.2 Stops what a subsystem does; All stops everything that moves.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` for a single subsystem while the
    /// monitor deploys, wraps, searches or extinguishes (§3.2); Stop to All is never refused.
    pub async fn stop(&self, who: SubsystemId) -> Result<Answers, Error> {
        self.ask(who, Body::Stop).await
    }

    /// §3.3 The state of every subsystem of the monitor.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] when General refuses for all. Refusals of single
    /// subsystems are in [`MonitorStatus::others`].
    pub async fn status_all(&self) -> Result<MonitorStatus, Error> {
        let request = Request::new(SubsystemId::ALL, Body::GetStatus);
        MonitorStatus::of_all(self.client.request(&request).await?)
    }

    /// §3.3 The state of one subsystem; its answer is decoded by [`AnswerBuf::decode`].
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `MODULE_NOT_EXIST` when the monitor does not
    /// have the subsystem.
    pub async fn status(&self, who: SubsystemId) -> Result<AnswerBuf, Error> {
        Ok(self.ask(who, Body::GetStatus).await?.first().clone())
    }

    /// §3.4 The values of a parameter by its name, or by its id written as `0x23FE`.
    ///
    /// # Errors
    ///
    /// As [`Monitor::param_id`].
    pub async fn param(&self, who: SubsystemId, name: &str) -> Result<Vec<i32>, Error> {
        self.param_id(who, param_id(name)).await
    }

    /// §3.4 The values of a parameter. While a remote unit has to supply them (NotCached), the
    /// request is repeated for at most `Config::resume`.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_ID` for a parameter that does not
    /// exist, `INCOMPLETE_CONFIG` for one that is not set, `NOT_CACHED` when the remote unit does
    /// not supply it in time (§3.4).
    pub async fn param_id(&self, who: SubsystemId, id: ParamId) -> Result<Vec<i32>, Error> {
        values(self.insist(who, Body::GetParam { id }).await?.first())
    }

    /// §3.4 The values of many parameters of the dictionary, several in a frame.
    pub async fn params(&self, which: &[Param]) -> Vec<Result<Vec<i32>, Error>> {
        self.params_with(which, |_| {}).await
    }

    /// Like [`Monitor::params`], with a callback for the progress: see [`Client::complete`].
    pub async fn params_with(
        &self,
        which: &[Param],
        progress: impl FnMut(Progress),
    ) -> Vec<Result<Vec<i32>, Error>> {
        let requests: Vec<Request<'_>> = which
            .iter()
            .map(|param| {
                let spec = param.spec();
                Request::new(spec.subsystem, Body::GetParam { id: spec.id })
            })
            .collect();
        let results = self.client.complete(&requests, progress).await;
        let one = |result: Result<Answers, Error>| values(result?.accepted()?.first());
        results.into_iter().map(one).collect()
    }

    /// §3.5 Sets a parameter by its name, or by its id written as `0x23FE`. While a remote unit has
    /// not taken it (Cached), the request is repeated for at most `Config::resume`. Accepted does
    /// not mean stored: see [`Monitor::save_param`].
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_ID`, `INVALID_VALUE` (out of
    /// range), `WRONG_DATA` (number of values), `ACCESS_DENIED` (read-only), `INCOMPLETE_CONFIG`
    /// (kept until the set of the subsystem is complete) or `CACHED` (the remote unit has not taken
    /// it) (§3.5).
    pub async fn set_param(
        &self,
        who: SubsystemId,
        name: &str,
        values: &[i32],
    ) -> Result<Status, Error> {
        let values = Ints::Values(values);
        let answers = self.insist(who, Body::SetParam { id: param_id(name), values }).await?;
        Ok(answers.first().status())
    }

    /// §3.6 Stores corrections of the elevation, degrees, one for each 0.1 atm, starting at index
    /// `first` (format: ours). Long tables are sent in pieces; the first refusal ends the transfer.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_VALUE` when `first` and the number
    /// of corrections exceed 256, `WRONG_DATA` without corrections (§3.6). Pieces before the
    /// refusal are stored.
    pub async fn correction_table(&self, first: u8, corrections: &[i8]) -> Result<Status, Error> {
        let bytes: Vec<u8> = corrections.iter().map(|value| value.to_le_bytes()[0]).collect();
        let (mut first, mut rest) = (first, &bytes[..]);
        loop {
            let (piece, others) = rest.split_at(rest.len().min(TABLE_PIECE));
            let body = Body::SetupCorrectionTable { first, corrections: Bytes(piece) };
            let status = self.command(SubsystemId::CONTROL, body).await?;
            if others.is_empty() {
                return Ok(status);
            }
            (first, rest) = (first.saturating_add(TABLE_PIECE as u8), others);
        }
    }

    /// §3.7 The limits of a drive.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `WRONG_REQUEST` of a subsystem that is not a
    /// drive, `MODULE_NOT_EXIST` of one that is absent (§3.7).
    pub async fn limits(&self, drive: SubsystemId) -> Result<Limits, Error> {
        limits(self.ask(drive, Body::RetrieveLimits).await?.first())
    }

    /// §3.7 The limits of every drive that has them.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] when General refuses for all.
    pub async fn limits_all(&self) -> Result<Vec<(SubsystemId, Limits)>, Error> {
        let request = Request::new(SubsystemId::ALL, Body::RetrieveLimits);
        let answers = self.client.request(&request).await?;
        let answers = if answers.len() > 1 { answers } else { answers.accepted()? };
        let fine = answers.iter().filter(|answer| answer.status().is_success());
        fine.map(|answer| Ok((answer.from(), limits(answer)?))).collect()
    }

    /// §3.8 Opens a valve.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` while the monitor is not deployed
    /// or searches, `MODULE_FAULT` of a faulty valve (§3.8).
    pub async fn open(&self, valve: SubsystemId) -> Result<Status, Error> {
        self.command(valve, Body::Open { key: key::OPEN }).await
    }

    /// §3.9 Closes a valve.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` during a search, `MODULE_FAULT` of
    /// a faulty valve (§3.9).
    pub async fn close(&self, valve: SubsystemId) -> Result<Status, Error> {
        self.command(valve, Body::Close { key: key::CLOSE }).await
    }

    /// §3.10 Deploys to the working position. Ok: already there.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `MODULE_FAULT` of a faulty Deployer,
    /// `MODULE_NOT_EXIST` without one (§3.10).
    pub async fn deploy(&self) -> Result<Status, Error> {
        self.command(SubsystemId::DEPLOYER, Body::Deploy).await
    }

    /// §3.11 Stows to the standby position. Ok: already there.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` while a valve is not closed or the
    /// monitor searches, `MODULE_FAULT` of a faulty Deployer, `MODULE_NOT_EXIST` without one
    /// (§3.11).
    pub async fn wrap(&self) -> Result<Status, Error> {
        self.command(SubsystemId::DEPLOYER, Body::Wrap).await
    }

    /// §3.12 Restarts the program; parameters that need a restart take effect.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` under lockout, `BUSY` while it
    /// is already restarting (§3.12).
    pub async fn restart(&self) -> Result<Answers, Error> {
        self.ask(SubsystemId::ALL, Body::Restart).await
    }

    /// §3.13 Starts the alignment of detector and barrel.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` while the monitor is not deployed,
    /// searches or extinguishes (§3.13).
    pub async fn justify(&self) -> Result<Status, Error> {
        self.command(SubsystemId::DETECTOR, Body::StartJustify).await
    }

    /// §3.14 Starts extinguishing. The valves are not changed.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_VALUE` for a program, nozzle or
    /// step out of range and for a sector wholly outside the limits, `DENIED` during a search
    /// (§3.14).
    pub async fn quench(&self, quench: Quench<'_>) -> Result<Status, Error> {
        self.command(SubsystemId::CONTROL, Body::StartQuench(quench)).await
    }

    /// §3.15 Starts extinguishing along trajectories (format: ours).
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_VALUE` for a number out of range,
    /// `INVALID_ID` for a stored trajectory that is empty, `DENIED` during a search (§3.15).
    pub async fn trajectory(&self, trajectory: Trajectory<'_>) -> Result<Status, Error> {
        self.command(SubsystemId::CONTROL, Body::StartTrajectory(trajectory)).await
    }

    /// §3.16 Starts the search for fire in a sector.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `INVALID_VALUE` for a sector that is not
    /// wholly inside the limits, `DENIED` while the monitor extinguishes or a valve is not closed
    /// (§3.16).
    pub async fn seek(&self, seek: Seek) -> Result<Status, Error> {
        self.command(SubsystemId::DETECTOR, Body::StartSeek(seek)).await
    }

    /// §3.17 Switches the control of limits off or on, or rejects their change.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `NOT_SUPPORTED` of a drive with limit
    /// switches, `INVALID_VALUE` when the limits taken cross (§3.17).
    pub async fn switch_limits(
        &self,
        who: SubsystemId,
        state: LimitsState,
    ) -> Result<Answers, Error> {
        let new_state = match state {
            LimitsState::Off => 0,
            LimitsState::On => 1,
            LimitsState::Reject => 2,
        };
        self.ask(who, Body::SwitchLimits { new_state }).await
    }

    /// §3.18 Locks the monitor out (everything stops, valves close), or releases it.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] for the first refusal. No state of the monitor
    /// forbids this request (§3.18).
    pub async fn lockout(&self, on: bool) -> Result<Answers, Error> {
        self.client.request(&Request::lockout(on)).await?.accepted()
    }

    /// §3.19 Erases the non-volatile memory and restarts.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `DENIED` under lockout, `BUSY` during a
    /// restart (§3.19).
    pub async fn clean_flash(&self) -> Result<Status, Error> {
        self.command(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH }).await
    }

    /// §3.20 Registers saved at the last hardware fault.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; no state of the monitor forbids reading (§3.20).
    pub async fn crash_data(&self) -> Result<FaultInfo, Error> {
        let answers = self.ask(SubsystemId::GENERAL, Body::GetCrashData).await?;
        match typed(answers.first())? {
            Reply::Fault(info) => Ok(info),
            _ => Err(wrong_shape(answers.first())),
        }
    }

    /// §3.21 The hotbeds found, the brightest first.
    ///
    /// # Errors
    ///
    /// As [`Client::request`]; [`Error::Refused`] with `MODULE_NOT_EXIST` without a Detector
    /// (§3.21).
    pub async fn hotbeds(&self) -> Result<Vec<Hotbed>, Error> {
        let body = Body::GetParam { id: ParamId::HOTBEDS };
        let answers = self.ask(SubsystemId::DETECTOR, body).await?;
        let answer = answers.first();
        let values = values(answer)?;
        let (hotbeds, rest) = values.as_chunks::<5>();
        if !rest.is_empty() || hotbeds.len() > Hotbed::MAX {
            return Err(wrong_shape(answer));
        }
        Ok(hotbeds.iter().map(|values| Hotbed::from_values(*values)).collect())
    }

    /// The answers to a request; an error if one of them refuses.
    async fn ask(&self, to: SubsystemId, body: Body<'_>) -> Result<Answers, Error> {
        self.client.request(&Request::new(to, body)).await?.accepted()
    }

    /// Like `ask`, repeated while the answer says "later".
    async fn insist(&self, to: SubsystemId, body: Body<'_>) -> Result<Answers, Error> {
        let results = self.client.complete(&[Request::new(to, body)], |_| {}).await;
        results.into_iter().next().unwrap_or(Err(Error::Closed))?.accepted()
    }

    /// Sends a request; returns Ok or Accepted.
    async fn command(&self, to: SubsystemId, body: Body<'_>) -> Result<Status, Error> {
        Ok(self.ask(to, body).await?.first().status())
    }
}

/// Corrections in one SetupCorrectionTable; 256 are sent in two requests.
const TABLE_PIECE: usize = 128;

/// The id of a parameter: `0x23FE`, or the hash of a name (§1, §3.4).
pub(crate) fn param_id(name: &str) -> ParamId {
    let number = name.strip_prefix("0x").and_then(|digits| u16::from_str_radix(digits, 16).ok());
    number.map_or_else(|| ParamId::of(name), ParamId)
}

pub(crate) fn typed(answer: &AnswerBuf) -> Result<Reply<'_>, Error> {
    let (request, from) = (answer.request(), answer.from());
    let decoded = answer.decode().map_err(|source| {
        let what = Deviation::Shape(source);
        Error::Protocol { request, from, what }
    })?;
    Ok(decoded.data)
}

fn values(answer: &AnswerBuf) -> Result<Vec<i32>, Error> {
    match typed(answer)? {
        Reply::Param { values, .. } => Ok(values.iter().collect()),
        _ => Err(wrong_shape(answer)),
    }
}

fn limits(answer: &AnswerBuf) -> Result<Limits, Error> {
    match typed(answer)? {
        Reply::Limits(limits) => Ok(limits),
        _ => Err(wrong_shape(answer)),
    }
}

/// The error for a success without its data.
pub(crate) fn wrong_shape(answer: &AnswerBuf) -> Error {
    let (expected, got) = (Expected::Size, answer.data().len());
    let what = match answer.deviation() {
        Some(what) => what,
        None => Deviation::Shape(DecodeError { offset: 0, expected, got }),
    };
    Error::Protocol { request: answer.request(), from: answer.from(), what }
}
