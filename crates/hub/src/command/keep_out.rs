//! No water into a keep-out, for any client.
//!
//! A request is not sent if water could go there by it: an opening while the barrel points or moves there, a
//! motion or a program that leads there or through it while water may flow. Where the barrel is, is known from
//! the last poll, and where it goes from what this hub has sent. What has been let pass counts from then on
//! ([`Passed`]): the monitor may have started it although its answer is not here yet. What moves the barrel
//! otherwise (a hand at the monitor, another program) is seen by the next poll: water that goes into a keep-out
//! is shut off, and the barrel stops.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use lafet_client::{Answers, JogEnd, Toward};
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Quench, Sector, Trajectory, TrajectoryPoint};
use lafet_proto::{Request, RequestId, Status, SubsystemId};

use super::request::MonitorRequest;
use crate::control::authority::Now;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::program::begins;
use crate::monitor::station::Station;
use crate::monitor::status::Status as State;
use crate::site::keep_out::{KeepOut, Span, Swept};
use crate::sync::lock;
use crate::zones::orders::closing;

/// What was sent shows in the state that is heard after this time, or after so many polls.
const SHOWS: Duration = Duration::from_secs(1);
const SHOWS_POLLS: u32 = 3;
/// What was not answered may still be on its way to the monitor for this time: a line is repeated on, opened
/// again, or kept by a serial server.
const ARRIVES: Duration = Duration::from_secs(10);
/// A motion by hand begins no nearer to a keep-out: of a barrel at rest, and of one that moves, arc-minutes.
const NEAR: f64 = 30.0;
const NEAR_MOVING: f64 = 600.0;

/// What this hub has sent to the barrel of a monitor, as far as the state does not show it.
#[derive(Debug, Default)]
pub struct Barrel {
    /// What has been let pass and is not over, by number: one for each request and motion under way.
    underway: BTreeMap<u64, Goes>,
    passed: u64,
    horizontal: Way,
    vertical: Way,
    /// Until when an opening counts whatever the state shows.
    opened: Option<Now>,
    /// The program that was accepted last, and what it sweeps.
    program: Option<(String, Swept)>,
    /// What programs sweep whose answer did not come, and since when.
    unanswered: Option<(Swept, Now)>,
    /// Water goes into this keep-out: it was ordered shut at this time.
    inside: Option<(String, Now)>,
}

/// What becomes of a barrel.
#[derive(Clone, Copy, Debug)]
enum Goes {
    /// A drive moves there.
    To(SubsystemId, Span),
    /// A program sweeps this.
    Program(Swept),
    /// Water comes.
    Opens,
}

/// How a request or a motion by hand was over.
#[derive(Debug)]
enum End {
    /// Nothing has started.
    Refused,
    /// The drive is at rest.
    Rests,
    /// This request was accepted.
    Accepted(String),
    /// It is over, and what it has started the state shows.
    Over,
    /// Whether it has started, or will, is not known.
    Unknown,
}

/// A request or a motion by hand that was let pass. It counts as started until this is dropped.
#[derive(Debug)]
pub struct Passed {
    hub: Hub,
    station: Arc<Station>,
    number: u64,
    end: End,
}

/// Where a drive may go.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    /// Where it was sent last.
    sent: Option<Sent>,
    /// Where requests without an answer take it, if they arrive, and when the last one was over.
    lost: Option<(Span, Now)>,
}

/// Where a drive was sent.
#[derive(Clone, Copy, Debug)]
struct Sent {
    to: Span,
    at: Now,
    number: u64,
}

/// What is known of a barrel.
struct Known {
    horizontal: Axis,
    vertical: Axis,
    /// Water flows, or may.
    flows: bool,
    /// What the programs sweep that run or are sent; `None`: none is. Of another client's nothing is known.
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
        station: &Arc<Station>,
        request: &MonitorRequest,
    ) -> Result<Option<Passed>, ApiError> {
        let Some((place, keep_outs)) = self.keep_outs(station.id()) else { return Ok(None) };
        let sent = request.buf().request();
        let program = program(station, &sent).map(|it| it.unwrap_or(Swept::WHOLE));
        let searches = program.is_none() && begins(request.id());
        let mut barrel = lock(&station.barrel);
        let known = self.known(station, &barrel);
        let swept = match (sent.body, program) {
            // The way to it counts while water flows; an opening on the way is checked by itself.
            (_, Some(program)) if !known.flows => Some(program),
            (_, Some(program)) => Some(known.swept().with(program)),
            (Body::Move { destination }, _) if known.flows => {
                known.swept().widened(sent.to, destination.into())
            }
            _ if searches => known.flows.then_some(Swept::WHOLE),
            _ => (request.id() == RequestId::OPEN).then(|| known.swept()),
        };
        let met = swept.and_then(|swept| keep_outs.iter().find(|it| it.meets(&place, swept)));
        if let Some(met) = met {
            return Err(ApiError::keep_out(&met.name, known.is_located()));
        }
        let goes = match (sent.body, program) {
            (_, Some(program)) => Goes::Program(program),
            (Body::Move { destination }, _) => Goes::To(sent.to, Span::at(destination.into())),
            _ if searches => Goes::Program(Swept::WHOLE),
            _ if request.id() == RequestId::OPEN => Goes::Opens,
            _ => return Ok(None),
        };
        Ok(Some(self.let_pass(station, &mut barrel, goes)))
    }

    fn let_pass(&self, station: &Arc<Station>, barrel: &mut Barrel, goes: Goes) -> Passed {
        barrel.passed += 1;
        let number = barrel.passed;
        barrel.underway.insert(number, goes);
        Passed { hub: self.clone(), station: station.clone(), number, end: End::Unknown }
    }

    /// The position at which a motion by hand that begins now has to end; refused at a keep-out that is too
    /// near.
    pub fn bound_by_keep_outs(
        &self,
        station: &Arc<Station>,
        drive: SubsystemId,
        toward: Toward,
    ) -> Result<(Option<i16>, Option<Passed>), ApiError> {
        let Some((place, keep_outs)) = self.keep_outs(station.id()) else {
            return Ok((None, None));
        };
        let mut barrel = lock(&station.barrel);
        let known = self.known(station, &barrel);
        let up = toward == Toward::Max;
        let axis = match drive {
            SubsystemId::HORIZONTAL => known.horizontal,
            SubsystemId::VERTICAL => known.vertical,
            _ => return Ok((None, None)),
        };
        let far = if up { Span::WHOLE.most } else { Span::WHOLE.least };
        if !known.flows {
            let passed = self.let_pass(station, &mut barrel, Goes::To(drive, Span::at(far)));
            return Ok((None, Some(passed)));
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
        let goes = Goes::To(drive, Span::at(to.unwrap_or(far)));
        let passed = self.let_pass(station, &mut barrel, goes);
        // Within the range of a drive: what is farther is none of its positions.
        let to = to.filter(|to| to.abs() < Span::WHOLE.most).map(|to| to as i16);
        Ok((to, Some(passed)))
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
            // The zones would open it again.
            self.refuse_by_keep_outs(station, news);
            // Stop of All would end the closing too.
            let stops = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL].map(MonitorRequest::stop);
            for request in closing(station).into_iter().chain(stops).flatten() {
                match news {
                    true => drop(self.overtake(&Caller::hub(), station, &request)),
                    false => drop(self.overtake_again(station, &request)),
                }
            }
        }
    }

    /// The keep-out that the barrel of a monitor points into in this state.
    fn kept_out(&self, monitor: &str, status: &State) -> Option<String> {
        let position = |drive| status.position(drive).map(|it| Span::at(it as f64));
        let horizontal = position(SubsystemId::HORIZONTAL)?;
        let swept = Swept { horizontal, vertical: position(SubsystemId::VERTICAL)? };
        let (place, keep_outs) = self.keep_outs(monitor)?;
        keep_outs.into_iter().find(|it| it.has(&place, swept)).map(|it| it.name)
    }

    /// Whether a monitor may throw water there at every elevation.
    pub fn is_clear(&self, monitor: &str, horizontal: Span) -> bool {
        let Some(map) = self.map() else { return true };
        let Some(place) = map.monitors.get(monitor) else { return true };
        let swept = Swept { horizontal, ..Swept::WHOLE };
        !map.keep_outs.iter().any(|it| it.is_of(monitor) && it.meets(place, swept))
    }

    fn known(&self, station: &Station, barrel: &Barrel) -> Known {
        let (status, now) = (station.status(), self.now());
        let recent = |at: &Now| now.saturating_sub(*at) < shows(station);
        let axis = |drive, way: Way| {
            let moving = status.is_set(drive, "Move");
            let sent = way.sent.filter(|sent| moving || recent(&sent.at)).map(|sent| sent.to);
            let lost = way.lost.filter(|it| arrives(now, it.1)).map(|it| it.0);
            let moves = barrel.going(drive).chain(sent).chain(lost).reduce(Span::with);
            Axis {
                position: status.position(drive).map(|it| it as f64),
                moves: moves.or(moving.then_some(Span::WHOLE)),
            }
        };
        let runs = lock(&station.programs).current().cloned();
        let opens = barrel.underway.values().any(|it| matches!(it, Goes::Opens));
        let opened = opens || barrel.opened.is_some_and(|until| now < until);
        let mut known = Known {
            horizontal: axis(SubsystemId::HORIZONTAL, barrel.horizontal),
            vertical: axis(SubsystemId::VERTICAL, barrel.vertical),
            flows: status.stale || status.flows() || opened,
            program: barrel.sent_programs().reduce(Swept::with),
        };
        if let Some(program) = runs {
            let ours = barrel.program.as_ref().filter(|it| Some(&it.0) == program.request.as_ref());
            let swept = ours.map_or(Swept::WHOLE, |it| it.1);
            known.program = Some(known.program.map_or(swept, |it| it.with(swept)));
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
    /// Where requests and motions under way take a drive.
    fn going(&self, of: SubsystemId) -> impl Iterator<Item = Span> {
        self.underway.values().filter_map(move |it| match it {
            Goes::To(drive, to) if *drive == of => Some(*to),
            _ => None,
        })
    }

    /// What programs sweep that may have started without an answer.
    fn sent_programs(&self) -> impl Iterator<Item = Swept> {
        let underway = self.underway.values().filter_map(|it| match it {
            Goes::Program(swept) => Some(*swept),
            _ => None,
        });
        underway.chain(self.unanswered.map(|it| it.0))
    }

    /// What was let pass is over. What was not refused counts until the state shows it.
    fn over(&mut self, number: u64, end: End, now: Now, shows: Duration) {
        let Some(goes) = self.underway.remove(&number) else { return };
        match (goes, end) {
            (_, End::Refused) => {}
            (Goes::To(drive, to), end) => {
                if let Some(way) = self.way(drive) {
                    way.over((to, number), &end, now);
                }
            }
            (Goes::Opens, end) => {
                let counts = if matches!(end, End::Unknown) { ARRIVES.max(shows) } else { shows };
                self.opened = self.opened.max(Some(now + counts));
            }
            (Goes::Program(swept), End::Accepted(request)) => {
                self.program = Some((request, swept));
            }
            (Goes::Program(swept), _) => {
                let swept = self.unanswered.map_or(swept, |it| it.0.with(swept));
                self.unanswered = Some((swept, now));
            }
        }
    }

    const fn way(&mut self, drive: SubsystemId) -> Option<&mut Way> {
        match drive {
            SubsystemId::HORIZONTAL => Some(&mut self.horizontal),
            SubsystemId::VERTICAL => Some(&mut self.vertical),
            _ => None,
        }
    }

    /// Drives that rest are where they are, not where they were sent; and a program without an answer that
    /// has started shows.
    fn settle(&mut self, status: &State, now: Now, shows: Duration) {
        for drive in [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL] {
            let Some(way) = self.way(drive) else { continue };
            if !status.is_set(drive, "Move") {
                way.sent = way.sent.filter(|sent| now.saturating_sub(sent.at) < shows);
            }
            way.lost = way.lost.filter(|it| arrives(now, it.1));
        }
        // One that deploys first has no flag yet.
        if !status.is_set(SubsystemId::DEPLOYER, "Deploying") {
            self.unanswered = self.unanswered.filter(|it| arrives(now, it.1));
        }
    }
}

impl Way {
    /// A request or a motion that goes there is over. The latest that was accepted counts, whichever answer
    /// comes first; what may not have been carried out ends nothing that was sent before.
    fn over(&mut self, (to, number): (Span, u64), end: &End, at: Now) {
        let newer = self.sent.is_none_or(|it| it.number < number);
        match end {
            End::Refused => {}
            End::Unknown => {
                let to = self.lost.map_or(to, |it| it.0.with(to));
                self.lost = Some((to, at));
            }
            End::Over => {
                let (to, number) =
                    self.sent.map_or((to, number), |it| (it.to.with(to), it.number.max(number)));
                self.sent = Some(Sent { to, at, number });
            }
            End::Accepted(_) if newer => self.sent = Some(Sent { to, at, number }),
            End::Rests if newer => self.sent = None,
            End::Accepted(_) | End::Rests => {}
        }
    }
}

impl Passed {
    /// How the request was answered. What was accepted goes on until this is dropped.
    pub(super) fn answered(mut self, request: &MonitorRequest, answers: &Answers) -> Option<Self> {
        let done = was_done(answers);
        self.end = match done {
            true => End::Accepted(request.text().to_owned()),
            false => End::Refused,
        };
        done.then_some(self)
    }

    /// Nothing was sent.
    pub fn refused(mut self) {
        self.end = End::Refused;
    }

    /// How the motion by hand ended.
    pub fn jogged(mut self, end: &JogEnd) {
        self.end = match end {
            JogEnd::Stopped { .. } | JogEnd::Standing(_) => End::Rests,
            JogEnd::Unbounded(_) => End::Refused,
            // Of a motion in steps it is a later one that was refused: the last one that was not goes on.
            JogEnd::Refused(_)
            | JogEnd::Replaced
            | JogEnd::TakenOver { .. }
            | JogEnd::StillMoving(_) => End::Over,
            _ => End::Unknown,
        };
    }
}

impl Drop for Passed {
    fn drop(&mut self) {
        let end = std::mem::replace(&mut self.end, End::Unknown);
        let (now, shows) = (self.hub.now(), shows(&self.station));
        lock(&self.station.barrel).over(self.number, end, now, shows);
    }
}

/// Whether a monitor has carried a request out: also one whose answer was too long.
pub(super) fn was_done(answers: &Answers) -> bool {
    let done = |status: Status| status.is_success() || status == Status::NO_ROOM;
    answers.iter().any(|it| done(it.status()))
}

/// Whether what was over at this time without an answer may still arrive.
fn arrives(now: Now, over: Now) -> bool {
    now.saturating_sub(over) < ARRIVES
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

/// The stored programs and trajectories that a request starts.
pub(super) fn stored_of(request: &Request<'_>) -> Vec<Param> {
    match request.body {
        Body::StartQuench(Quench::Program { program, .. }) => {
            u8::try_from(program).ok().and_then(|it| named("Program", it)).into_iter().collect()
        }
        Body::StartTrajectory(Trajectory { path: Path::Stored(numbers), .. }) => {
            numbers.iter().filter_map(|it| named("Trajectory", *it)).collect()
        }
        _ => Vec::new(),
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

/// The values of a stored program or trajectory; none if they were not read since they may have changed.
fn stored(station: &Station, of: &str, number: u8) -> Option<Vec<i32>> {
    lock(&station.stored).of(named(of, number)?).map(<[i32]>::to_vec)
}

fn named(of: &str, number: u8) -> Option<Param> {
    Param::by_name(SubsystemId::CONTROL, &format!("{of}{number}"))
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::monitor::status::Subsystem;
    use crate::monitor::stored::may_change;
    use crate::site::keep_out::KeptFor;
    use crate::site::{Place, Site};

    const CLOSED: &[(&str, &str)] = &[("Valve1", "Closed")];
    const QUENCH: &str =
        "StartQuench Control centre=-5400,0 nozzle=60 sector=600,300 step=1 distance=30";

    /// A monitor at rest that looks north, its valve shut; azimuths −30° … −60° are kept clear.
    fn stand() -> (Hub, Arc<Station>) {
        let place = Place { at: [0.0, 0.0], heading: 0.0, height: 2.0 };
        let keep_out = KeepOut {
            name: "stand".into(),
            of: KeptFor::People,
            monitor: None,
            bearings: [30.0, 60.0],
            elevations: [-90.0, 90.0],
        };
        let (monitors, keep_outs) = ([("M1".to_owned(), place)].into(), vec![keep_out]);
        let (hub, station) = Hub::of_one(Some(Site { monitors, keep_outs, ..Site::default() }));
        report(&hub, &station, CLOSED);
        (hub, station)
    }

    /// The monitor reports that it points north, with these flags.
    fn report(hub: &Hub, station: &Station, flags: &[(&'static str, &str)]) {
        let mut state = State { at_ms: Some(1), ..State::default() };
        for name in ["Horizontal", "Vertical", "Valve1", "Control", "Deployer"] {
            let id = SubsystemId::from_name(name).unwrap();
            let of = flags.iter().filter(|it| it.0 == name);
            let bits = of.map(|it| lafet_proto::flags::flags_of(id).by_name(it.1).unwrap().mask());
            let mut subsystem = Subsystem::default();
            subsystem.set_bits(id, bits.sum());
            subsystem.fields = [("position", 0)].into();
            state.subsystems.insert(name, Arc::new(subsystem));
        }
        station.set_status(hub, state);
    }

    fn passes(hub: &Hub, station: &Arc<Station>, request: &str) -> Option<Passed> {
        let request = MonitorRequest::parse(request).unwrap();
        hub.pass_keep_outs(station, &request).expect("it passes")
    }

    fn is_kept_out(hub: &Hub, station: &Arc<Station>, request: &str) -> bool {
        let request = MonitorRequest::parse(request).unwrap();
        let passed = hub.pass_keep_outs(station, &request);
        passed.is_err_and(|error| error.code == "keep_out")
    }

    fn end(passed: Option<Passed>, end: End) {
        passed.expect("it counts").end = end;
    }

    #[tokio::test]
    async fn a_program_counts_from_when_it_is_sent_until_it_is_refused_or_over() {
        let (hub, station) = stand();
        for request in [QUENCH, "StartSeek Detector -1800 1800 -300 900"] {
            let sent = passes(&hub, &station, request);
            assert!(is_kept_out(&hub, &station, "Open Valve1"), "{request}: it may have started");
            end(sent, End::Refused);
            end(passes(&hub, &station, "Open Valve1"), End::Refused);
        }
        let sent = passes(&hub, &station, QUENCH);
        lock(&station.programs).accepted(0, QUENCH, "anna");
        end(sent, End::Accepted(QUENCH.into()));
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "it runs");
    }

    #[tokio::test]
    async fn a_program_without_an_answer_counts_until_the_state_shows_it() {
        let (hub, station) = stand();
        drop(passes(&hub, &station, QUENCH));
        let settle = |after| {
            let (now, shows) = (hub.now() + after, shows(&station));
            lock(&station.barrel).settle(&station.status(), now, shows);
        };
        settle(Duration::ZERO);
        assert!(is_kept_out(&hub, &station, "Open Valve1"));
        report(&hub, &station, &[("Valve1", "Closed"), ("Deployer", "Deploying")]);
        settle(Duration::from_secs(20));
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "it deploys first");
        report(&hub, &station, CLOSED);
        settle(Duration::from_secs(20));
        drop(passes(&hub, &station, "Open Valve1"));
    }

    /// What a stored program sweeps is known until a request may change it, and again when it was read since.
    #[tokio::test]
    async fn a_stored_program_counts_as_it_was_read_since_its_change() {
        const PROGRAM: &str = "StartQuench Control program=1 centre=-5400,0 nozzle=60";
        let (hub, station) = stand();
        assert!(is_kept_out(&hub, &station, PROGRAM), "not read yet");
        let narrow = [0, 0, 60, 60, 0, 1, 25];
        let read = |values: &[i32]| {
            let since = lock(&station.stored).since();
            lock(&station.stored).put(since, Param::ControlProgram1, values);
        };
        read(&narrow);
        end(passes(&hub, &station, PROGRAM), End::Refused);
        for (request, changes) in [
            ("SetParam General WaterTimeout 60", false),
            ("SetParam Control Program2 0 0 60 60 0 1 25", true),
            ("Restart All", true),
        ] {
            let request = MonitorRequest::parse(request).unwrap();
            assert_eq!(may_change(&request.buf().request()), changes, "{}", request.text());
            if changes {
                lock(&station.stored).doubt();
                assert!(is_kept_out(&hub, &station, PROGRAM), "{}", request.text());
                read(&narrow);
            }
            end(passes(&hub, &station, PROGRAM), End::Refused);
        }
        read(&[0, 0, 60, 7200, 0, 1, 25]);
        assert!(is_kept_out(&hub, &station, PROGRAM), "it is wide");
    }

    /// However long the monitor takes to answer.
    #[tokio::test]
    async fn a_move_counts_while_it_is_under_way_and_the_latest_one_afterwards() {
        let (hub, station) = stand();
        let there = passes(&hub, &station, "Move Horizontal -2700");
        lock(&station.barrel).settle(&station.status(), hub.now() + SHOWS * 60, SHOWS);
        assert!(is_kept_out(&hub, &station, "Open Valve1"));
        let back = passes(&hub, &station, "Move Horizontal 600");
        end(back, End::Accepted(String::new()));
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "the first one is under way");
        end(there, End::Accepted(String::new()));
        end(passes(&hub, &station, "Open Valve1"), End::Refused);
        // One that is refused leaves the barrel on its way.
        let there = passes(&hub, &station, "Move Horizontal -2700");
        end(there, End::Accepted(String::new()));
        end(passes(&hub, &station, "Move Horizontal 600"), End::Refused);
        assert!(is_kept_out(&hub, &station, "Open Valve1"));
    }

    #[tokio::test]
    async fn what_begins_while_an_opening_is_under_way_is_bounded() {
        let (hub, station) = stand();
        let first = passes(&hub, &station, "Open Valve1");
        let second = passes(&hub, &station, "Open Valve1");
        end(first, End::Refused);
        assert!(is_kept_out(&hub, &station, "Move Horizontal -2700"));
        assert!(is_kept_out(&hub, &station, "StartSeek Detector -1800 1800 -300 900"));
        let bound = |drive, toward| hub.bound_by_keep_outs(&station, drive, toward).unwrap();
        let (to, motion) = bound(SubsystemId::HORIZONTAL, Toward::Min);
        assert_eq!(to, Some(-1710));
        end(motion, End::Rests);
        end(second, End::Refused);
        let (to, motion) = bound(SubsystemId::HORIZONTAL, Toward::Min);
        assert_eq!(to, None, "no water");
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "it moves");
        end(motion, End::Rests);
        drop(passes(&hub, &station, "Open Valve1"));
    }

    /// A Move that may never have arrived, and a motion by hand that never began, end nothing.
    #[tokio::test]
    async fn what_may_not_have_started_erases_nothing_that_was_accepted() {
        let refused = || JogEnd::Refused(lafet_client::Error::Closed);
        let ends: [(&str, &dyn Fn(Passed)); 5] = [
            ("no answer", &|it| drop(it)),
            ("not started", &Passed::refused),
            ("refused", &|it| it.jogged(&refused())),
            ("replaced", &|it| it.jogged(&JogEnd::Replaced)),
            ("unknown", &|it| it.jogged(&JogEnd::Unknown(lafet_client::Error::Closed))),
        ];
        for (what, over) in ends {
            let (hub, station) = stand();
            let there = passes(&hub, &station, "Move Horizontal -2700");
            end(there, End::Accepted(String::new()));
            over(passes(&hub, &station, "Move Horizontal 600").unwrap());
            assert!(is_kept_out(&hub, &station, "Open Valve1"), "{what}: it moves to the stand");
        }
    }

    /// Without a connection nothing is sent, so nothing moves.
    #[tokio::test]
    async fn what_was_certainly_not_sent_does_not_count() {
        let (hub, station) = stand();
        for request in ["Move Horizontal -2700", QUENCH] {
            let sent = MonitorRequest::parse(request).unwrap();
            let failed = hub.command(&Caller::hub(), &station, sent, None).await.unwrap_err();
            assert_eq!(failed.code, "not_connected");
            end(passes(&hub, &station, "Open Valve1"), End::Refused);
        }
    }

    /// The answer to a step may be a refusal while the step before it is still under way.
    #[tokio::test]
    async fn a_motion_by_hand_that_is_refused_counts_until_the_drive_is_at_rest() {
        let (hub, station) = stand();
        let (_, motion) =
            hub.bound_by_keep_outs(&station, SubsystemId::HORIZONTAL, Toward::Min).unwrap();
        motion.unwrap().jogged(&JogEnd::Refused(lafet_client::Error::Closed));
        let settle = |after| {
            let (now, shows) = (hub.now() + after, shows(&station));
            lock(&station.barrel).settle(&station.status(), now, shows);
        };
        settle(Duration::ZERO);
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "it may move");
        report(&hub, &station, &[("Valve1", "Closed"), ("Horizontal", "Move")]);
        settle(SHOWS * 5);
        assert!(is_kept_out(&hub, &station, "Open Valve1"), "it moves");
        report(&hub, &station, CLOSED);
        settle(SHOWS * 5);
        drop(passes(&hub, &station, "Open Valve1"));
    }

    /// A request without an answer may arrive later than the next polls.
    #[tokio::test]
    async fn what_was_not_answered_counts_as_long_as_it_may_arrive() {
        let (hub, station) = stand();
        drop(passes(&hub, &station, "Move Horizontal -2700"));
        let settle = |after| {
            let (now, shows) = (hub.now() + after, shows(&station));
            lock(&station.barrel).settle(&station.status(), now, shows);
        };
        settle(ARRIVES / 2);
        assert!(is_kept_out(&hub, &station, "Open Valve1"));
        settle(ARRIVES);
        drop(passes(&hub, &station, "Open Valve1"));
        let opened = lock(&station.barrel).opened.unwrap();
        assert!(opened > hub.now() + ARRIVES / 2, "it may open later");
    }
}
