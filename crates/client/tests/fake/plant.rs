//! A drive that moves in virtual time, behind a line that loses and delays what it is set to.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::link::Decoder;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::DriveStatus;
use lafet_proto::{Answer, Ints, ParamId, Request, RequestId, Status, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Instant, sleep};

use super::frame;

/// Arc-minutes a second.
const SPEED: f64 = 300.0;
/// MoveHold (ours, §D/4).
const MOVE_HOLD: ParamId = ParamId::of("MoveHold");

/// What happens to a frame of requests and to its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// Executed and answered, after a while.
    After(Duration),
    /// Neither.
    LoseRequest,
    /// Executed; the answer is lost.
    LoseAnswer,
}

/// At once, as far as a line can.
pub const SOON: Fate = Fate::After(Duration::from_millis(5));

/// A monitor with drives and a lock, and what was done to it.
pub struct Plant {
    /// Drives that move: since when, from where, whereto.
    moving: Vec<(SubsystemId, Instant, i16, i16)>,
    /// It knows MoveHold.
    pub has_hold: bool,
    /// Limits are off.
    pub limitless: bool,
    /// Until when a drive moves under MoveHold.
    holds: Vec<(SubsystemId, Instant)>,
    /// MoveHold of the frame that is being executed.
    asked_hold: Option<Duration>,
    positions: Vec<(SubsystemId, i16)>,
    /// Who denies Stop to a single drive (§3.2/2–4).
    pub denies_stop: Option<SubsystemId>,
    /// Who denies Move.
    pub denies_move: Option<SubsystemId>,
    /// Every request that was executed, and when.
    pub log: Vec<(Instant, RequestId, SubsystemId)>,
    /// Decides what happens to a frame that begins with this request.
    pub fate: Box<dyn FnMut(RequestId) -> Fate + Send>,
    /// Time with something moving.
    pub stopped_at: Option<Instant>,
}

pub type Shared = Arc<Mutex<Plant>>;

pub fn plant() -> Shared {
    Arc::new(Mutex::new(Plant {
        moving: Vec::new(),
        has_hold: true,
        limitless: false,
        holds: Vec::new(),
        asked_hold: None,
        positions: Vec::new(),
        denies_stop: None,
        denies_move: None,
        log: Vec::new(),
        fate: Box::new(|_| SOON),
        stopped_at: None,
    }))
}

impl Plant {
    pub fn is_moving(&self, drive: SubsystemId) -> bool {
        let over = self.holds.iter().any(|(id, until)| *id == drive && Instant::now() >= *until);
        let on_its_way = |since: Instant, from: i16, to: i16| reached(since, from, to) != to;
        let mut moving = self.moving.iter().filter(|(id, ..)| *id == drive);
        !over && moving.any(|(_, since, from, to)| on_its_way(*since, *from, *to))
    }

    /// What has lasted as long as it may has stopped then.
    fn end_holds(&mut self) {
        let now = Instant::now();
        let over: Vec<_> = self.holds.extract_if(.., |(_, until)| now >= *until).collect();
        for (drive, until) in over {
            if let Some((_, since, from, to)) = self.moving.iter().find(|(id, ..)| *id == drive) {
                let position = place(until.saturating_duration_since(*since), *from, *to);
                self.positions.retain(|(id, _)| *id != drive);
                self.positions.push((drive, position));
                self.stopped_at = Some(until);
            }
            self.moving.retain(|(id, ..)| *id != drive);
        }
    }

    pub fn count(&self, request: RequestId) -> usize {
        self.log.iter().filter(|(_, id, _)| *id == request).count()
    }

    /// Another client stops it, beside the line.
    pub fn stop(&mut self, drive: SubsystemId) {
        self.end_holds();
        let position = self.position(drive);
        self.holds.retain(|(id, _)| *id != drive);
        if self.is_moving(drive) {
            self.stopped_at = Some(Instant::now());
        }
        self.moving.retain(|(id, ..)| *id != drive);
        self.positions.retain(|(id, _)| *id != drive);
        self.positions.push((drive, position));
    }

    pub fn position(&mut self, drive: SubsystemId) -> i16 {
        self.end_holds();
        let moving = self.moving.iter().find(|(id, ..)| *id == drive);
        let standing = self.positions.iter().find(|(id, _)| *id == drive);
        match moving {
            Some((_, since, from, to)) => reached(*since, *from, *to),
            None => standing.map_or(0, |(_, position)| *position),
        }
    }

    fn answer(&mut self, request: &Request<'_>) -> Answer<'static> {
        let (to, id) = (request.to, request.body.id());
        self.log.push((Instant::now(), id, to));
        let bare = |from, status| Answer::bare(from, id, status);
        match request.body {
            Body::Move { destination } => {
                if let Some(by) = self.denies_move {
                    return bare(by, Status::DENIED);
                }
                let from = self.position(to);
                let stopped_at = self.stopped_at;
                self.stop(to);
                self.stopped_at = stopped_at;
                let destination = match self.limitless {
                    true => destination.signum() * 21_600,
                    false => destination.clamp(-5400, 5400),
                };
                self.moving.push((to, Instant::now(), from, destination));
                if let Some(hold) = self.asked_hold {
                    self.holds.push((to, Instant::now() + hold));
                }
                bare(to, Status::ACCEPTED)
            }
            Body::Stop => match self.denies_stop {
                Some(by) if to != SubsystemId::ALL => bare(by, Status::DENIED),
                _ => {
                    let drives: Vec<_> = self.moving.iter().map(|(id, ..)| *id).collect();
                    let concerned = |id: &&SubsystemId| to == SubsystemId::ALL || **id == to;
                    drives.iter().filter(concerned).for_each(|id| self.stop(*id));
                    bare(
                        if to == SubsystemId::ALL { SubsystemId::VERTICAL } else { to },
                        Status::OK,
                    )
                }
            },
            Body::SetParam { id, values } if id == MOVE_HOLD && self.has_hold => {
                self.end_holds();
                let hold = Duration::from_millis(values.get(0).unwrap_or(0).unsigned_abs().into());
                self.asked_hold = Some(hold);
                let held = self.holds.iter_mut().filter(|(drive, _)| *drive == to);
                held.for_each(|(_, until)| *until = Instant::now() + hold);
                param(to, request.body.id(), id, &[])
            }
            Body::GetParam { id } if id == MOVE_HOLD && self.has_hold => {
                param(to, request.body.id(), id, &[0])
            }
            Body::GetParam { id } if to == SubsystemId::GENERAL => {
                param(to, request.body.id(), id, &[0])
            }
            Body::GetStatus if to.is_drive() => {
                let mut flags = DriveFlags::empty();
                flags.set(DriveFlags::MOVE, self.is_moving(to));
                flags.set(DriveFlags::LIMITLESS, self.limitless);
                let position = self.position(to);
                let status = DriveStatus { flags, position, current: 0, speed: 5 };
                Answer { from: to, request: id, status: Status::OK, data: Reply::Drive(status) }
            }
            _ => bare(to, Status::MODULE_NOT_EXIST),
        }
    }
}

/// An answer about a parameter.
fn param(
    from: SubsystemId,
    request: RequestId,
    id: ParamId,
    values: &'static [i32],
) -> Answer<'static> {
    let data = Reply::Param { id, values: Ints::Values(values) };
    Answer { from, request, status: Status::OK, data }
}

/// A drive at constant speed.
fn reached(since: Instant, from: i16, to: i16) -> i16 {
    place(since.elapsed(), from, to)
}

fn place(time: Duration, from: i16, to: i16) -> i16 {
    let all = f64::from(to) - f64::from(from);
    let way = (time.as_secs_f64() * SPEED).min(all.abs());
    if all > 0.0 { from + way as i16 } else { from - way as i16 }
}

/// Serves a stream until it ends.
pub async fn serve(stream: DuplexStream, plant: Shared) {
    let (mut read, write) = tokio::io::split(stream);
    let write = Arc::new(tokio::sync::Mutex::new(write));
    let mut decoder: Decoder = Decoder::new();
    while let Ok(byte) = read.read_u8().await {
        let Some(asked) = decoder.push(byte) else { continue };
        let requests: Vec<_> = Records::new(asked.payload).map(|record| record.unwrap()).collect();
        let first = requests.iter().find(|record| record.device.name().is_some());
        let fate = match first {
            Some(record) => (plant.lock().unwrap().fate)(record.request),
            None => SOON,
        };
        if fate == Fate::LoseRequest {
            continue;
        }
        let mut buffer = [0; 512];
        let mut out = Writer::new(&mut buffer);
        for record in &requests {
            let request = Request::decode(record).unwrap();
            plant.lock().unwrap().answer(&request).encode(&mut out).unwrap();
        }
        plant.lock().unwrap().asked_hold = None;
        let Fate::After(delay) = fate else { continue };
        let (bytes, write) = (frame(out.written()), write.clone());
        tokio::spawn(async move {
            sleep(delay).await;
            // The other side may be gone.
            _ = write.lock().await.write_all(&bytes).await;
        });
    }
}
