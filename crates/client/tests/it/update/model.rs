//! A small model of a monitor that can be updated: two slots, orders that wait for the next step, restarts and
//! trials; and the image files that it is sent.

use std::time::Duration;

use lafet_client::update::digest_of;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{DetectorFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::param::Param;
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::status::{DetectorStatus, DriveStatus, GeneralStatus, ValveStatus};
use lafet_proto::update::{DIGEST_LEN, HEADER_LEN, KEY, Order, Phase, Report};
use lafet_proto::{Answer, Ints, ParamId, RequestId, Status, SubsystemId};
use sha2::{Digest as _, Sha256};
use tokio::time::Instant;

use crate::fake::frame;

pub const STEP: Duration = Duration::from_millis(10);
pub const DOWN: Duration = Duration::from_secs(3);
pub const TRIAL: Duration = Duration::from_secs(180);
/// Bytes of a page: of one that is not complete nothing is left by a restart.
pub const PAGE: usize = 256;
pub const WORD: [u8; 16] = *b"sixteen letters.";
pub const OLD: [u16; 4] = [1, 0, 0, 0];
pub const NEW: [u16; 4] = [2, 1, 0, 7];

// The kinds of orders.
pub const STATE: u8 = 0;
pub const BEGIN: u8 = 1;
pub const DATA: u8 = 2;
pub const VERIFY: u8 = 3;
pub const COMMIT: u8 = 4;
pub const CONFIRM: u8 = 5;
pub const ABANDON: u8 = 6;

/// General, Vertical, Valve1 and Detector, as in the parameter Chain.
pub const CHAIN: i32 = 1 | 1 << 2 | 1 << 5 | 1 << 8;

/// What becomes of an order.
#[derive(Clone, Copy, PartialEq)]
pub enum Fate {
    Fine,
    LoseRequest,
    LoseAnswer,
    Doubled,
}

pub type Hook = Box<dyn FnMut(&mut Model, u8) -> Fate + Send>;

/// A monitor that can be updated.
pub struct Model {
    pub slot: u8,
    pub versions: [[u16; 4]; 2],
    pub trial: bool,
    pub failed: bool,
    pub phase: Phase,
    pub reason: u8,
    /// Header and digest of the word, since this start.
    pub target: Option<([u8; HEADER_LEN], [u8; DIGEST_LEN])>,
    /// What is in the other slot.
    pub stored: Option<[u8; HEADER_LEN]>,
    pub bytes: Vec<u8>,
    /// The digest of the word that was committed.
    pub word: [u8; DIGEST_LEN],
    pub committed: bool,
    pub held: Option<(Instant, Vec<u8>)>,
    pub verified_at: Option<Instant>,
    pub restart_at: Option<Instant>,
    /// Until then it restarts.
    pub up_at: Option<Instant>,
    pub trial_ends: Option<Instant>,
    /// Until then nothing passes the cable.
    pub dead_until: Option<Instant>,
    /// It answers so to Update, without a report.
    pub without_update: Option<Status>,
    /// The program on trial answers so, too.
    pub trial_without_update: Option<Status>,
    /// The next begins are refused for these reasons.
    pub refusals: Vec<u8>,
    /// The new image crashes.
    pub crashes: bool,
    /// The new image does not answer.
    pub mutes: bool,
    /// On trial without its valve.
    pub lacks_valve: bool,
    /// It restarts so long after its start on trial.
    pub lives: Option<Duration>,
    /// Nothing is confirmed for so long after its start on trial.
    pub young: Duration,
    pub trial_since: Option<Instant>,
    /// Flags of General on trial, so long after its start.
    pub trial_flags: GeneralFlags,
    pub trial_after: Duration,
    /// Flags of Vertical and Detector on trial.
    pub trial_drive: DriveFlags,
    pub trial_detector: DetectorFlags,
    /// It knows Abandon.
    pub abandons: bool,
    /// The image on trial has nothing to go back to.
    pub has_no_other: bool,
    /// The parameters of General that take effect with a restart.
    pub address: Option<i32>,
    pub chain: Option<i32>,
    pub flags: GeneralFlags,
    pub valve: ValveFlags,
    pub drive: DriveFlags,
    /// Restart is carried out.
    pub restarts: bool,
    pub hook: Option<Hook>,
    /// The kinds of all orders that arrived.
    pub orders: Vec<u8>,
    /// The offsets of all data that were accepted.
    pub offsets: Vec<u32>,
    /// All requests that arrived.
    pub requests: Vec<RequestId>,
    /// Commits and confirmations that were accepted.
    pub commits: u32,
    pub confirms: u32,
    pub stopped_at: Option<Instant>,
}

impl Model {
    pub fn new() -> Self {
        Self {
            slot: 1,
            versions: [OLD, [0; 4]],
            trial: false,
            failed: false,
            phase: Phase::IDLE,
            reason: 0,
            target: None,
            stored: None,
            bytes: Vec::new(),
            word: [0; DIGEST_LEN],
            committed: false,
            held: None,
            verified_at: None,
            restart_at: None,
            up_at: None,
            trial_ends: None,
            dead_until: None,
            without_update: None,
            trial_without_update: None,
            refusals: Vec::new(),
            crashes: false,
            mutes: false,
            lacks_valve: false,
            lives: None,
            young: Duration::ZERO,
            trial_since: None,
            trial_flags: GeneralFlags::empty(),
            trial_after: Duration::ZERO,
            trial_drive: DriveFlags::empty(),
            trial_detector: DetectorFlags::empty(),
            abandons: true,
            has_no_other: false,
            address: Some(1),
            chain: Some(CHAIN),
            flags: GeneralFlags::LOCKED_OUT,
            valve: ValveFlags::CLOSED,
            drive: DriveFlags::empty(),
            restarts: false,
            hook: None,
            orders: Vec::new(),
            offsets: Vec::new(),
            requests: Vec::new(),
            commits: 0,
            confirms: 0,
            stopped_at: None,
        }
    }

    pub fn hooked(hook: impl FnMut(&mut Self, u8) -> Fate + Send + 'static) -> Self {
        Self { hook: Some(Box::new(hook)), ..Self::new() }
    }

    /// On trial, as another run of the sender has left it.
    pub fn tried() -> Self {
        let now = Instant::now();
        let (trial_since, trial_ends) = (Some(now), Some(now + TRIAL));
        let (word, versions) = (digest_of(&WORD), [OLD, NEW]);
        Self { slot: 2, trial: true, versions, word, trial_since, trial_ends, ..Self::new() }
    }

    fn other(&self) -> u8 {
        3 - self.slot
    }

    pub fn version(&self) -> [u16; 4] {
        self.versions[usize::from(self.slot) - 1]
    }

    fn size(&self) -> u32 {
        let size = |(header, _): ([u8; HEADER_LEN], _)| {
            u32::from_le_bytes(header[12..16].try_into().unwrap())
        };
        self.target.map_or(0, size)
    }

    fn report(&self) -> Report {
        Report {
            phase: self.phase,
            slot: self.slot,
            trial: self.trial,
            failed: self.failed,
            waits: self.held.is_some(),
            pending: false,
            lost: false,
            reason: self.reason,
            received: if self.target.is_some() { self.bytes.len() as u32 } else { 0 },
            size: self.size(),
            version: self.version(),
            image: self.target.map_or([0; 4], |(it, _)| it[64..68].try_into().unwrap()),
        }
    }

    /// What is due by now.
    fn advance(&mut self, now: Instant) {
        let is_due = |at: Option<Instant>| at.is_some_and(|at| now >= at);
        if is_due(self.up_at) {
            self.up_at = None;
            self.boot(now);
        }
        if self.up_at.is_some() {
            return;
        }
        if is_due(self.held.as_ref().map(|(at, _)| *at))
            && let Some((_, data)) = self.held.take()
        {
            self.perform(now, &data);
        }
        if is_due(self.verified_at) {
            (self.verified_at, self.phase) = (None, Phase::VERIFIED);
        }
        if is_due(self.restart_at) || is_due(self.trial_ends) {
            self.restart(now);
        }
    }

    pub fn restart(&mut self, now: Instant) {
        self.up_at = Some(now + DOWN);
        (self.held, self.verified_at, self.restart_at, self.trial_ends) = (None, None, None, None);
        if (self.bytes.len() as u32) < self.size() {
            self.bytes.truncate(self.bytes.len() / PAGE * PAGE);
        }
        (self.target, self.phase, self.reason) = (None, Phase::IDLE, 0);
    }

    fn boot(&mut self, now: Instant) {
        let committed = std::mem::take(&mut self.committed);
        if committed && !self.crashes {
            (self.trial, self.slot) = (true, self.other());
            self.trial_ends = Some(now + self.lives.unwrap_or(TRIAL));
            self.trial_since = Some(now);
        } else if committed {
            self.failed = true;
        } else if self.trial {
            (self.trial, self.slot, self.failed) = (false, self.other(), true);
        }
    }

    /// Another sender, or an earlier one, starts this image.
    pub fn begin(&mut self, header: &[u8; HEADER_LEN], digest: &[u8; DIGEST_LEN]) {
        if self.target.is_none_or(|(known, _)| known != *header) {
            if self.stored != Some(*header) {
                self.bytes.clear();
            }
            self.phase = Phase::RECEIVING;
        }
        self.stored = Some(*header);
        self.target = Some((*header, *digest));
        self.failed = false;
        let other = usize::from(self.other()) - 1;
        self.versions[other] =
            [16, 18, 20, 22].map(|at| u16::from_le_bytes([header[at], header[at + 1]]));
    }

    fn perform(&mut self, now: Instant, data: &[u8]) {
        let (order, _) = Order::decode(data).unwrap();
        self.reason = 0;
        match order {
            Order::State => {}
            Order::Begin { .. } if self.trial && !self.has_no_other => self.reason = 18,
            Order::Begin { .. } if !self.refusals.is_empty() => {
                self.reason = self.refusals.remove(0);
            }
            Order::Begin { header, digest } => self.begin(header, digest),
            Order::Data { part, .. } => self.bytes.extend_from_slice(part),
            Order::Verify => self.verify(now),
            Order::Commit { .. } if self.phase != Phase::VERIFIED => self.reason = 17,
            Order::Commit { digest } => match self.target {
                Some((_, known)) if known == *digest => {
                    (self.phase, self.word, self.committed) = (Phase::COMMITTED, known, true);
                    self.restart_at = Some(now + 5 * STEP);
                }
                _ => self.reason = 20,
            },
            Order::Abandon { digest } if *digest == self.word => {
                self.restart_at = Some(now + 5 * STEP);
            }
            Order::Abandon { .. } => self.reason = 20,
            Order::Confirm { .. } if !self.trial => self.reason = 19,
            Order::Confirm { word } if digest_of(word) != self.word => self.reason = 20,
            Order::Confirm { .. } => (self.trial, self.trial_ends) = (false, None),
        }
    }

    fn verify(&mut self, now: Instant) {
        let Some((header, _)) = self.target else {
            self.reason = 13;
            return;
        };
        if (self.bytes.len() as u32) < self.size() {
            self.reason = 15;
        } else if sha(&self.bytes)[..] != header[64..96] {
            (self.target, self.stored, self.phase, self.reason) = (None, None, Phase::IDLE, 16);
            self.bytes.clear();
        } else if self.phase == Phase::RECEIVING {
            (self.phase, self.verified_at) = (Phase::VERIFYING, Some(now + 30 * STEP));
        }
    }

    /// The status that an order is answered.
    fn take_order(&mut self, now: Instant, data: &[u8]) -> Status {
        let (order, key) = Order::decode(data).unwrap();
        let misplaced = match order {
            Order::State => return Status::OK,
            Order::Data { offset, .. } => {
                self.phase != Phase::RECEIVING || offset != self.bytes.len() as u32
            }
            Order::Abandon { .. } => !self.trial,
            _ => false,
        };
        let ready = self.flags.contains(GeneralFlags::LOCKED_OUT)
            && !self.flags.contains(GeneralFlags::BAD_POWER)
            && self.valve.contains(ValveFlags::CLOSED)
            && !self.drive.contains(DriveFlags::MOVE);
        assert_eq!(key, KEY);
        let young = self.trial_since.is_some_and(|since| now - since < self.young);
        let early = self.trial && young && matches!(order, Order::Confirm { .. });
        if self.held.is_some() || self.restart_at.is_some() || early {
            return Status::BUSY;
        }
        if !ready && !matches!(order, Order::Abandon { .. }) {
            return Status::DENIED;
        }
        if misplaced {
            return Status::INVALID_VALUE;
        }
        if let Order::Data { offset, .. } = order {
            self.offsets.push(offset);
        }
        self.commits += u32::from(matches!(order, Order::Commit { .. }));
        self.confirms += u32::from(matches!(order, Order::Confirm { .. }));
        self.held = Some((now + STEP, data.to_vec()));
        Status::ACCEPTED
    }

    fn states(&self, now: Instant) -> Vec<Answer<'static>> {
        let late = self.trial_since.is_some_and(|since| now - since >= self.trial_after);
        let flags = if self.trial && late { self.flags | self.trial_flags } else { self.flags };
        let (moves, found) = match self.trial {
            true => (self.drive | self.trial_drive, self.trial_detector),
            false => (self.drive, DetectorFlags::empty()),
        };
        let general = GeneralStatus { flags, main_voltage: 24, pressure: 0, flowrate: 0 };
        let drive = DriveStatus { flags: moves, position: 0, current: 0, speed: 0 };
        let mut all = vec![
            (SubsystemId::VALVE1, Reply::Valve(ValveStatus { flags: self.valve })),
            (SubsystemId::DETECTOR, Reply::Detector(DetectorStatus { flags: found })),
            (SubsystemId::VERTICAL, Reply::Drive(drive)),
            (SubsystemId::GENERAL, Reply::General(general)),
        ];
        if self.trial && self.lacks_valve {
            all.remove(0);
        }
        let answer = |(from, data)| Answer {
            from,
            request: RequestId::GET_STATUS,
            status: Status::OK,
            data,
        };
        all.into_iter().map(answer).collect()
    }

    fn is_without_update(&self) -> Option<Status> {
        let tried = self.trial_without_update.filter(|_| self.trial);
        self.without_update.or(tried)
    }

    fn param(&self, data: &[u8]) -> Answer<'_> {
        let id = ParamId(u16::from_le_bytes([data[0], data[1]]));
        let value = match Param::find(SubsystemId::GENERAL, id) {
            Some(Param::GeneralAddress) => &self.address,
            Some(Param::GeneralChain) => &self.chain,
            _ => &None,
        };
        let values = Ints::Values(value.as_slice());
        let status = if value.is_some() { Status::OK } else { Status::INVALID_ID };
        let (from, request) = (SubsystemId::GENERAL, RequestId::GET_PARAM);
        Answer { from, request, status, data: Reply::Param { id, values } }
    }

    /// Answers the records of a frame.
    fn records(&mut self, now: Instant, payload: &[u8]) -> Vec<u8> {
        let mut buffer = [0; 512];
        let mut out = Writer::new(&mut buffer);
        for Record { request, device, data, .. } in Records::new(payload).map_while(Result::ok) {
            let mut push = |device, status, data: &[u8]| {
                out.push(&Record { request, device, status, data }).expect("room");
            };
            match request {
                RequestId::UPDATE => match self.is_without_update() {
                    Some(status) => push(device, status, &[]),
                    None if data.first() == Some(&ABANDON) && !self.abandons => {
                        push(device, Status::INVALID_VALUE, &[]);
                    }
                    None => {
                        let status = self.take_order(now, data);
                        push(device, status, &self.report().to_bytes());
                    }
                },
                RequestId::GET_STATUS if device == SubsystemId::ALL => {
                    self.states(now).iter().for_each(|it| it.encode(&mut out).expect("room"));
                }
                RequestId::GET_STATUS => push(device, Status::MODULE_NOT_EXIST, &[]),
                RequestId::GET_PARAM => self.param(data).encode(&mut out).expect("room"),
                RequestId::STOP => {
                    self.stopped_at = Some(now);
                    push(SubsystemId::VERTICAL, Status::OK, &[]);
                }
                RequestId::RESTART if self.restarts => {
                    self.restart_at = Some(now);
                    push(SubsystemId::GENERAL, Status::ACCEPTED, &[]);
                }
                _ => push(SubsystemId::GENERAL, Status::DENIED, &[]),
            }
        }
        out.written().to_vec()
    }

    /// The bytes that come back for the payload of a frame.
    pub fn answer(&mut self, payload: &[u8]) -> Vec<u8> {
        let now = Instant::now();
        self.advance(now);
        let mut kind = None;
        for record in Records::new(payload).map_while(Result::ok) {
            self.requests.push(record.request);
            if record.request == RequestId::UPDATE {
                kind = record.data.first().copied();
            }
        }
        let mut fate = Fate::Fine;
        if let Some(kind) = kind {
            self.orders.push(kind);
            if let Some(mut hook) = self.hook.take() {
                fate = hook(self, kind);
                self.hook = Some(hook);
            }
        }
        let dead = self.dead_until.is_some_and(|until| now < until);
        let mute = self.trial && self.mutes;
        if self.up_at.is_some() || dead || mute || fate == Fate::LoseRequest {
            return Vec::new();
        }
        let bytes = frame(&self.records(now, payload));
        match fate {
            Fate::LoseAnswer => Vec::new(),
            Fate::Doubled => [bytes.clone(), bytes].concat(),
            _ => bytes,
        }
    }

    /// How many orders of this kind have arrived.
    pub fn count(&self, kind: u8) -> usize {
        self.orders.iter().filter(|order| **order == kind).count()
    }
}

pub fn sha(bytes: &[u8]) -> [u8; DIGEST_LEN] {
    Sha256::digest(bytes).into()
}

/// Numbers that look random.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        self.0 >> 33
    }
}

pub fn payload(len: usize) -> Vec<u8> {
    let mut dice = Dice(len as u64);
    (0..len).map(|_| dice.roll() as u8).collect()
}

/// An image file; its signature is no concern of the sender.
pub fn file(version: [u16; 4], slot: u8, payload: &[u8]) -> Vec<u8> {
    let mut header = [0; HEADER_LEN];
    header[..8].copy_from_slice(b"LAFETIMG");
    header[8] = 1;
    header[12..16].copy_from_slice(&(payload.len() as u32).to_le_bytes());
    for (place, number) in header[16..24].chunks_exact_mut(2).zip(version) {
        place.copy_from_slice(&number.to_le_bytes());
    }
    header[24..29].copy_from_slice(b"board");
    header[40..42].copy_from_slice(&[slot, 3]);
    header[44..48].copy_from_slice(&[1, 0, 2, 0]);
    header[64..96].copy_from_slice(&sha(payload));
    header[96..].fill(0xA5);
    [&header[..], payload].concat()
}
