//! No water into a keep-out, for any client.
//!
//! A request is not sent if water could go there by it: an opening while the barrel points or moves there, a
//! motion or a program that leads there or through it while water may flow. Where the barrel is, is known from
//! the last poll, and where it goes from what this hub has sent. What moves it otherwise (a hand at the
//! monitor, another program) is seen by the next poll: water that goes into a keep-out is shut off, and the
//! barrel stops.

use std::sync::Arc;
use std::time::Duration;

use lafet_client::Toward;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Quench, Sector, Trajectory, TrajectoryPoint};
use lafet_proto::{Request, RequestId, SubsystemId};

use super::request::MonitorRequest;
use crate::control::authority::Now;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::{ParamValue, Station};
use crate::monitor::status::Status;
use crate::site::keep_out::{KeepOut, Span, Swept};
use crate::sync::lock;
use crate::zones::orders::closing;

/// What was sent shows in the state that is heard after this time, or after so many polls.
const SHOWS: Duration = Duration::from_secs(1);
const SHOWS_POLLS: u32 = 3;
/// A motion by hand begins no nearer to a keep-out: of a barrel at rest, and of one that moves, arc-minutes.
const NEAR: f64 = 30.0;
const NEAR_MOVING: f64 = 600.0;

/// What this hub has sent to the barrel of a monitor, as far as the state does not show it.
#[derive(Debug, Default)]
pub struct Barrel {
    horizontal: Option<Sent>,
    vertical: Option<Sent>,
    opened: Option<Now>,
    /// The program that was sent last, and what it sweeps.
    program: Option<(String, Swept)>,
    /// Water goes into this keep-out: it was ordered shut at this time.
    inside: Option<(String, Now)>,
}

/// Where a drive was sent.
#[derive(Clone, Copy, Debug)]
struct Sent {
    to: Span,
    at: Now,
}

/// What is known of a barrel.
struct Known {
    horizontal: Axis,
    vertical: Axis,
    /// Water flows, or may.
    flows: bool,
    /// What the program sweeps that runs; `None`: none does. Of another client's nothing is known.
    program: Option<Swept>,
}

#[derive(Clone, Copy)]
struct Axis {
    /// `None`: not known.
    position: Option<f64>,
    /// Where it may come to, if it moves.
    moves: Option<Span>,
}

impl Axis {
    fn span(self) -> Span {
        let Some(position) = self.position.map(Span::at) else { return Span::WHOLE };
        self.moves.map_or(position, |to| position.with(to))
    }
}

impl Known {
    fn swept(&self) -> Swept {
        let own = Swept { horizontal: self.horizontal.span(), vertical: self.vertical.span() };
        self.program.map_or(own, |program| own.with(program))
    }

    const fn is_located(&self) -> bool {
        self.horizontal.position.is_some() && self.vertical.position.is_some()
    }
}

impl Hub {
    /// Refuses a request by which water could go into a keep-out; of any other it is noted where the barrel
    /// goes by it, so that of two requests at the same time the second one knows of the first.
    pub(super) fn pass_keep_outs(
        &self,
        station: &Station,
        request: &MonitorRequest,
    ) -> Result<(), ApiError> {
        let Some((place, keep_outs)) = self.keep_outs(station.id()) else { return Ok(()) };
        let sent = request.buf().request();
        let program = program(station, &sent).map(|it| it.unwrap_or(Swept::WHOLE));
        let mut barrel = lock(&station.barrel);
        let known = self.known(station, &barrel);
        let swept = match (sent.body, program) {
            // The way to it counts while water flows; an opening on the way is checked by itself.
            (_, Some(program)) if !known.flows => Some(program),
            (_, Some(program)) => Some(known.swept().with(program)),
            (Body::Move { destination }, _) if known.flows => {
                known.swept().widened(sent.to, destination.into())
            }
            _ => (request.id() == RequestId::OPEN).then(|| known.swept()),
        };
        let met = swept.and_then(|swept| keep_outs.iter().find(|it| it.meets(&place, swept)));
        if let Some(met) = met {
            return Err(ApiError::keep_out(&met.name, known.is_located()));
        }
        match (sent.body, program) {
            (_, Some(program)) => barrel.program = Some((request.text().to_owned(), program)),
            (Body::Move { destination }, _) => {
                barrel.sent(sent.to, Span::at(destination.into()), self.now());
            }
            _ if request.id() == RequestId::OPEN => barrel.opened = Some(self.now()),
            _ => {}
        }
        Ok(())
    }

    /// The position at which a motion by hand that begins now has to end; refused at a keep-out that is too
    /// near.
    pub fn bound_by_keep_outs(
        &self,
        station: &Station,
        drive: SubsystemId,
        toward: Toward,
    ) -> Result<Option<i16>, ApiError> {
        let Some((place, keep_outs)) = self.keep_outs(station.id()) else { return Ok(None) };
        let mut barrel = lock(&station.barrel);
        let known = self.known(station, &barrel);
        let up = toward == Toward::Max;
        let axis = match drive {
            SubsystemId::HORIZONTAL => known.horizontal,
            SubsystemId::VERTICAL => known.vertical,
            _ => return Ok(None),
        };
        let far = if up { Span::WHOLE.most } else { Span::WHOLE.least };
        if !known.flows {
            barrel.sent(drive, Span::at(far), self.now());
            return Ok(None);
        }
        let swept = known.swept();
        let mut bound: Option<(f64, &KeepOut)> = None;
        for it in &keep_outs {
            let Some(from) = axis.position else {
                return Err(ApiError::keep_out(&it.name, false));
            };
            let ahead = match drive {
                SubsystemId::HORIZONTAL => it.ahead_horizontally(&place, from, up, swept.vertical),
                _ => it.ahead_vertically(&place, from, up, swept.horizontal),
            };
            let Some(ahead) = ahead else { continue };
            if bound.is_none_or(|(nearest, _)| (ahead < nearest) == up) {
                bound = Some((ahead, it));
            }
        }
        let near = if axis.moves.is_some() { NEAR_MOVING } else { NEAR };
        if let Some((ahead, nearest)) = bound
            && axis.position.is_none_or(|from| (ahead - from).abs() < near)
        {
            return Err(ApiError::keep_out(&nearest.name, true));
        }
        let to = bound.map(|(ahead, _)| ahead);
        barrel.sent(drive, Span::at(to.unwrap_or(far)), self.now());
        // Within the range of a drive: what is farther is none of its positions.
        Ok(to.filter(|to| to.abs() < Span::WHOLE.most).map(|to| to as i16))
    }

    /// Looks at a new state: shuts water off that goes into a keep-out.
    pub fn watch_keep_outs(&self, station: &Arc<Station>) {
        let (status, now) = (station.status(), self.now());
        if status.stale {
            return;
        }
        let into = status.flows().then(|| self.kept_out(station.id(), &status)).flatten();
        let (orders, news) = {
            let mut barrel = lock(&station.barrel);
            barrel.settle(&status, now, shows(station));
            let before = barrel.inside.take();
            let lately = before.as_ref().map(|it| it.1);
            let lately = lately.filter(|at| now.saturating_sub(*at) < SHOWS);
            barrel.inside = into.clone().map(|name| (name, lately.unwrap_or(now)));
            (into.is_some() && lately.is_none(), before.map(|it| it.0) != into)
        };
        if news {
            self.alarms().set_kept_out(station.id(), into);
            self.observe(station);
        }
        if orders {
            // Stop of All would end the closing too.
            let stops = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL].map(MonitorRequest::stop);
            for request in closing(station).into_iter().chain(stops).flatten() {
                match news {
                    true => drop(self.overtake(&Caller::hub(), station, &request)),
                    false => self.overtake_again(station, &request),
                }
            }
        }
    }

    /// The keep-out that the barrel of a monitor points into in this state.
    fn kept_out(&self, monitor: &str, status: &Status) -> Option<String> {
        let position = |drive| status.position(drive).map(|it| Span::at(it as f64));
        let horizontal = position(SubsystemId::HORIZONTAL)?;
        let swept = Swept { horizontal, vertical: position(SubsystemId::VERTICAL)? };
        let (place, keep_outs) = self.keep_outs(monitor)?;
        keep_outs.into_iter().find(|it| it.has(&place, swept)).map(|it| it.name)
    }

    /// Whether a monitor may throw water there at every elevation.
    pub fn is_clear(&self, monitor: &str, horizontal: Span) -> bool {
        let Some((place, keep_outs)) = self.keep_outs(monitor) else { return true };
        let swept = Swept { horizontal, ..Swept::WHOLE };
        !keep_outs.iter().any(|it| it.meets(&place, swept))
    }

    fn known(&self, station: &Station, barrel: &Barrel) -> Known {
        let (status, now) = (station.status(), self.now());
        let recent = |at: &Now| now.saturating_sub(*at) < shows(station);
        let axis = |drive, sent: Option<Sent>| {
            let begun = sent.is_some_and(|sent| recent(&sent.at));
            let moves = begun || status.is_set(drive, "Move");
            Axis {
                position: status.position(drive).map(|it| it as f64),
                moves: moves.then(|| sent.map_or(Span::WHOLE, |sent| sent.to)),
            }
        };
        let runs = lock(&station.programs).current().cloned();
        let mut known = Known {
            horizontal: axis(SubsystemId::HORIZONTAL, barrel.horizontal),
            vertical: axis(SubsystemId::VERTICAL, barrel.vertical),
            flows: status.stale || status.flows() || barrel.opened.as_ref().is_some_and(recent),
            program: None,
        };
        if let Some(program) = runs {
            let ours = barrel.program.as_ref().filter(|it| Some(&it.0) == program.request.as_ref());
            known.program = Some(ours.map_or(Swept::WHOLE, |it| it.1));
            // The program moves the drives: where they were sent before does not count.
            if ours.is_some() {
                for axis in [&mut known.horizontal, &mut known.vertical] {
                    axis.moves = axis.moves.filter(|to| *to != Span::WHOLE);
                }
            }
        }
        known
    }
}

impl Barrel {
    const fn sent(&mut self, drive: SubsystemId, to: Span, at: Now) {
        match drive {
            SubsystemId::HORIZONTAL => self.horizontal = Some(Sent { to, at }),
            SubsystemId::VERTICAL => self.vertical = Some(Sent { to, at }),
            _ => {}
        }
    }

    /// Drives that rest are where they are, not where they were sent.
    fn settle(&mut self, status: &Status, now: Now, shows: Duration) {
        let drives = [
            (SubsystemId::HORIZONTAL, &mut self.horizontal),
            (SubsystemId::VERTICAL, &mut self.vertical),
        ];
        for (drive, sent) in drives {
            if !status.is_set(drive, "Move") {
                *sent = sent.filter(|sent| now.saturating_sub(sent.at) < shows);
            }
        }
    }
}

fn shows(station: &Station) -> Duration {
    SHOWS.max(Duration::from_millis(station.config.poll_ms) * SHOWS_POLLS)
}

/// What a program sweeps with water, by its request and the parameters of the monitor. `None`: it is none;
/// within it: not known.
fn program(station: &Station, request: &Request<'_>) -> Option<Option<Swept>> {
    match request.body {
        Body::StartQuench(quench) => Some(match quench {
            // The elevation follows from the distance and the pressure.
            Quench::Full { sector, .. } | Quench::Corrected { sector, .. } => {
                Some(of_sector(&sector))
            }
            Quench::Program { program, centre_h, .. } => {
                let number = u8::try_from(program).ok();
                let stored = number.and_then(|number| stored(station, "Program", number));
                stored.and_then(|values| Some(of_width(centre_h.into(), *values.get(3)?)))
            }
        }),
        Body::StartTrajectory(Trajectory { path, .. }) => Some(match path {
            Path::Points(points) => {
                of_points(points.iter().map(|it: TrajectoryPoint| it.horizontal.into()))
            }
            Path::Stored(numbers) => {
                let all = numbers.iter().map(|number| {
                    let values = stored(station, "Trajectory", *number)?;
                    of_points(values.chunks(4).filter_map(|it| it.first().copied()))
                });
                all.reduce(|a, b| Some(a?.with(b?))).flatten()
            }
        }),
        _ => None,
    }
}

fn of_sector(sector: &Sector) -> Swept {
    of_width(sector.centre_h.into(), sector.width.into())
}

fn of_width(centre: i32, width: i32) -> Swept {
    let half = f64::from(width.abs()) / 2.0;
    Swept { horizontal: Span::around(centre.into(), half), vertical: Span::WHOLE }
}

fn of_points(points: impl Iterator<Item = i32>) -> Option<Swept> {
    let horizontal = points.map(|it| Span::at(it.into())).reduce(Span::with)?;
    Some(Swept { horizontal, vertical: Span::WHOLE })
}

/// The values of a stored program or trajectory; none if they were not read.
fn stored(station: &Station, of: &str, number: u8) -> Option<Vec<i32>> {
    let params = lock(&station.params);
    match params
        .values
        .get(Param::ControlProgram0.spec().subsystem.name()?)?
        .get(&format!("{of}{number}"))?
    {
        ParamValue::Values(values) => Some(values.clone()),
        ParamValue::Error(_) => None,
    }
}
