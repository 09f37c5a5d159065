//! The monitor as a whole: the device with its requests, the bootloader, a flash that loses power.

mod layouts;
mod parameters;
mod replays;
mod trials;

use crate::bench::{Chip, Image, KEYS, WORD, factory, fields, image, payload, signed, start};
use crate::common::{ADDRESS, Plant};
use crate::flash::{Cut, Torn};
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Software, Storage, StorageError};
use lafet_device::image::{Axis, Inputs, Outputs};
use lafet_device::{Composition, Device, Source};
use lafet_proto::flags::GeneralFlags;
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::GeneralStatus;
use lafet_proto::update::{DIGEST_LEN, Order, PART_MAX, Phase, Report, WORD_LEN};
use lafet_proto::{Ints, Record, Request, RequestId, Status, SubsystemId};
use lafet_update::{Hash, Header, Receiver, Refusal, SigningKey, Slot};
use std::sync::LazyLock;

type App = Receiver<'static, Chip<8, 256>>;

const STEP_MS: u32 = 10;
/// The word of these updates.
const LONG_WORD: &[u8; WORD_LEN] = b"sixteen letters.";
/// Its digest.
static DIGEST: LazyLock<[u8; DIGEST_LEN]> = LazyLock::new(|| Hash::of(LONG_WORD).0);
/// `lafet_device` restarts an image that is not confirmed after this long.
const TRIAL_MS: u32 = 180_000;
/// It confirms none earlier after its start.
const PROVEN_MS: u32 = 10_000;

fn begin(image: &Image) -> Order<'_> {
    Order::Begin { header: &image.raw, digest: &DIGEST }
}

/// The plant of the device's tests, with a receiver.
struct Board {
    plant: Plant,
    app: Option<App>,
}

impl Storage for Board {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.plant.load(key, buffer)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.plant.store(key, value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.plant.erase()
    }
}

impl Hal for Board {
    fn read(&mut self, inputs: &mut Inputs) {
        self.plant.read(inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        self.plant.write(outputs);
    }

    fn reset(&mut self) {
        self.plant.reset();
    }

    fn software(&mut self) -> Option<&mut dyn Software> {
        self.app.as_mut().map(|app| app as &mut dyn Software)
    }
}

/// A monitor whose software can be updated, and the clock.
struct Site {
    device: Device,
    board: Board,
    composition: Composition,
    now_ms: u32,
    starts: u32,
}

impl Site {
    fn with(composition: Composition, app: Option<App>) -> Self {
        let mut plant = Plant::of(&composition);
        Device::provision(&mut plant, &composition, ADDRESS).unwrap();
        let mut board = Board { plant, app };
        let device = Device::power_up(0, &composition, ADDRESS, None, &mut board);
        let mut site = Self { device, board, composition, now_ms: 0, starts: 0 };
        site.run(200);
        site
    }

    /// Version 1 is running in slot A.
    fn new(composition: Composition) -> Self {
        Self::with(composition, start(factory(&image(1, 512), 7)).ok())
    }

    /// The same, locked out.
    fn locked() -> Self {
        let mut site = Self::new(Composition::FULL);
        site.lock();
        site
    }

    fn lock(&mut self) {
        self.ask(SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
        self.run(100);
    }

    fn app(&mut self) -> &mut App {
        self.board.app.as_mut().unwrap()
    }

    /// The bootloader starts what it finds, and that starts the device.
    fn start(&mut self) {
        self.starts += 1;
        if let Some(app) = self.board.app.take() {
            let flash = app.into_memory().into_flash().power_on();
            self.board.app = start(flash).ok();
            assert!(self.board.app.is_some(), "a board always starts");
        }
        self.board.plant.outputs = Outputs::default();
        let Self { now_ms, composition, board, .. } = self;
        self.device = Device::power_up(*now_ms, composition, ADDRESS, None, board);
    }

    /// A step; what resets makes a new device.
    fn step(&mut self) {
        self.now_ms += STEP_MS;
        self.board.plant.advance(STEP_MS);
        self.device.step(self.now_ms, &mut self.board);
        let off = self.board.app.as_ref().is_some_and(|app| app.memory().flash().is_off());
        if std::mem::take(&mut self.board.plant.reset_requested) || off {
            self.start();
        }
    }

    fn run(&mut self, ms: u32) {
        for _ in 0..ms / STEP_MS {
            self.step();
        }
    }

    /// Nothing is driven meanwhile.
    fn run_still(&mut self, ms: u32) {
        for _ in 0..ms / STEP_MS {
            self.step();
            assert!(self.device.outputs().is_still());
        }
    }

    /// The answers to a record: who, and what.
    fn handle(&mut self, record: &Record<'_>) -> Vec<(SubsystemId, Status, Vec<u8>)> {
        let (mut buffer, mut out) = ([0; 512], [0; 512]);
        let mut writer = Writer::new(&mut buffer);
        writer.push(record).unwrap();
        let request = writer.written().to_vec();
        let len = self.device.handle(self.now_ms, Source::ExternalConn, &request, &mut out);
        let answers = Records::new(&out[..len]).map(Result::unwrap);
        answers.map(|it| (it.device, it.status, it.data.to_vec())).collect()
    }

    fn ask(&mut self, to: SubsystemId, body: Body<'_>) -> Vec<(SubsystemId, Status, Vec<u8>)> {
        let mut buffer = [0; 512];
        let mut writer = Writer::new(&mut buffer);
        Request::new(to, body).encode(&mut writer).unwrap();
        let request = writer.written().to_vec();
        let record = Records::new(&request).next().unwrap().unwrap();
        self.handle(&record)
    }

    /// The one answer to the bytes of an order.
    #[track_caller]
    fn raw(&mut self, to: SubsystemId, data: &[u8]) -> (SubsystemId, Status, Vec<u8>) {
        let request = RequestId::UPDATE;
        let record = Record { request, device: to, status: Status::OK, data };
        let answers = self.handle(&record);
        let [answer] = answers.as_slice() else { panic!("{answers:?}") };
        answer.clone()
    }

    /// What is answered to an order.
    #[track_caller]
    fn order(&mut self, order: &Order<'_>) -> (Status, Report) {
        let mut buffer = [0; 256];
        let data = order.encode(&mut buffer).unwrap().to_vec();
        let (from, status, data) = self.raw(SubsystemId::GENERAL, &data);
        assert_eq!(from, SubsystemId::GENERAL);
        (status, Report::decode(&data).unwrap())
    }

    fn report(&mut self) -> Report {
        self.order(&Order::State).1
    }

    /// Has an order accepted and carried out.
    #[track_caller]
    fn accepts(&mut self, order: &Order<'_>) -> Report {
        let (status, report) = self.order(order);
        assert_eq!(status, Status::ACCEPTED, "{order:?}");
        assert!(report.waits);
        self.run_still(STEP_MS);
        self.report()
    }

    /// Sends an image and has it verified; whether it got there.
    fn send(&mut self, image: &Image) -> bool {
        let starts = self.starts;
        let mut report = self.accepts(&begin(image));
        while starts == self.starts && report.reason == 0 && report.phase == Phase::RECEIVING {
            let there = report.received as usize;
            let rest = &image.payload[there..];
            report = match rest.len() {
                0 => self.accepts(&Order::Verify),
                len => {
                    let part = &rest[..len.min(PART_MAX)];
                    self.accepts(&Order::Data { offset: there as u32, part })
                }
            };
        }
        for _ in 0..1000 {
            if self.report().phase != Phase::VERIFYING {
                break;
            }
            self.run_still(STEP_MS);
        }
        self.report().phase == Phase::VERIFIED
    }

    /// Has what was verified restarted.
    fn commit(&mut self) {
        let report = self.accepts(&Order::Commit { digest: &DIGEST });
        assert_eq!((report.phase, report.reason), (Phase::COMMITTED, 0));
        self.run_still(1000);
    }

    fn is_locked(&mut self) -> bool {
        let answers = self.ask(SubsystemId::GENERAL, Body::GetStatus);
        let status = GeneralStatus::from_bytes(answers[0].2.as_slice().try_into().unwrap());
        status.flags.contains(GeneralFlags::LOCKED_OUT)
    }

    fn set_speed(&mut self, value: i32) -> Status {
        let body =
            Body::SetParam { id: Param::HorizontalSpeed.id(), values: Ints::Values(&[value]) };
        self.ask(SubsystemId::HORIZONTAL, body)[0].1
    }

    /// A parameter that an update must keep; that of a remote unit takes a while to be read.
    fn speed(&mut self) -> Vec<u8> {
        let id = Param::HorizontalSpeed.id();
        for _ in 0..50 {
            let [(_, status, data)] = &self.ask(SubsystemId::HORIZONTAL, Body::GetParam { id })[..]
            else {
                break;
            };
            if *status == Status::OK {
                return data.clone();
            }
            self.run(100);
        }
        panic!("the speed cannot be read")
    }
}

/// An update from the first order to the release: it comes back with the new version, its
/// parameters and its lockout, and nothing is driven on the way.
#[test]
fn an_update() {
    for composition in Composition::ALL {
        let mut site = Site::new(composition);
        site.set_speed(7);
        site.run(500);
        let speed = site.speed();
        site.lock();
        // Without a Deployer its valves may still be on their way.
        site.run(10_000);
        assert!(site.send(&image(2, 512)), "{}", composition.name);
        site.commit();
        assert_eq!(site.starts, 1);
        let report = site.report();
        assert_eq!((report.slot, report.trial, report.version), (2, true, [2, 0, 0, 0]));
        assert!(site.is_locked());
        assert_eq!(site.speed(), speed);
        // What is on trial stays locked out.
        for (_, status, _) in site.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE }) {
            assert_eq!(status, Status::DENIED);
        }
        assert!(site.is_locked());
        site.run_still(PROVEN_MS);
        let report = site.accepts(&Order::Confirm { word: LONG_WORD });
        assert_eq!((report.trial, report.reason), (false, 0));
        site.run_still(TRIAL_MS + 1000);
        assert_eq!(site.starts, 1, "what was confirmed stays");
        site.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
        site.run(100);
        assert!(!site.is_locked());
        assert_eq!(site.speed(), speed);
    }
}

/// A board without the update does not know the request, in any state.
#[test]
fn absent() {
    let mut site = Site::with(Composition::FULL, None);
    let mut buffer = [0; 256];
    for order in [Order::State, Order::Verify, begin(&image(2, 8))] {
        let data = order.encode(&mut buffer).unwrap().to_vec();
        let answer = site.raw(SubsystemId::GENERAL, &data);
        assert_eq!(answer, (SubsystemId::GENERAL, Status::WRONG_REQUEST, vec![]));
    }
    site.lock();
    let answer = site.raw(SubsystemId::GENERAL, &[0]);
    assert_eq!(answer, (SubsystemId::GENERAL, Status::DENIED, vec![]));
}

/// What is not well-formed, without the key or to another addressee.
#[test]
fn refused_by_form() {
    let mut site = Site::locked();
    let mut buffer = [0; 256];
    let new = image(2, 8);
    let mut data = begin(&new).encode(&mut buffer).unwrap().to_vec();
    let general = SubsystemId::GENERAL;
    assert_eq!(site.raw(general, &data[..162]).1, Status::WRONG_DATA);
    assert_eq!(site.raw(general, &[]).1, Status::WRONG_DATA);
    let report = site.report().to_bytes().to_vec();
    let unknown = site.raw(general, &[7, 0xB7, 0x60]);
    assert_eq!(unknown, (general, Status::INVALID_VALUE, report));
    assert_eq!(site.raw(general, &[6, 0xB7, 0x60]).1, Status::WRONG_DATA);
    for to in [SubsystemId::ALL, SubsystemId::MOTORS] {
        assert_eq!(site.raw(to, &data), (general, Status::WRONG_REQUEST, vec![]));
    }
    let control = SubsystemId::CONTROL;
    assert_eq!(site.raw(control, &data), (control, Status::WRONG_REQUEST, vec![]));
    let unknown = SubsystemId(0x77);
    assert_eq!(site.raw(unknown, &data), (unknown, Status::MODULE_NOT_EXIST, vec![]));
    data[1] ^= 1;
    assert_eq!(site.raw(general, &data).1, Status::NEED_CONFIRM);
    site.run(1000);
    assert_eq!(site.report().phase, Phase::IDLE);
}

/// Each condition is needed: without one of them alone an order is Denied, and nothing is written.
#[test]
fn refused_by_state() {
    let new = image(2, 512);
    let begin = begin(&new);
    let denied = |site: &mut Site, what: &str| {
        let steps = site.app().memory().flash().steps;
        assert_eq!(site.order(&begin).0, Status::DENIED, "{what}");
        site.run(100);
        assert_eq!(site.app().memory().flash().steps, steps, "{what}");
        assert_eq!(site.order(&Order::State).0, Status::OK, "{what}: it can be asked");
    };
    let mut valves = 0;
    let mut site = Site::new(Composition::FULL);
    denied(&mut site, "not locked out");
    site.ask(SubsystemId::DEPLOYER, Body::Deploy);
    site.run(20_000);
    site.lock();
    denied(&mut site, "deployed");
    let mut site = Site::locked();
    site.board.plant.inputs.main_voltage_dv = 100;
    site.run(1000);
    denied(&mut site, "bad supply");
    let mut site = Site::new(Composition::MINI);
    site.lock();
    assert_eq!(site.order(&begin).0, Status::ACCEPTED, "without a Deployer, at rest");
    for composition in Composition::ALL {
        let mut site = Site::new(composition);
        if !site.device.has(SubsystemId::DEPLOYER) && site.device.has(SubsystemId::VALVE1) {
            site.ask(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
            site.run(10_000);
            site.ask(SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
            site.run(100);
            denied(&mut site, "a valve that is on its way");
            valves += 1;
        }
    }
    assert!(valves > 0, "one of them has no Deployer");
}

/// The compositions without a Deployer, each as a monitor that aims.
fn without_deployer() -> impl Iterator<Item = Site> {
    let all = Composition::ALL.into_iter().map(Site::new);
    all.filter(|site| !site.device.has(SubsystemId::DEPLOYER))
}

/// A valve that never gets to its switch keeps the monitor from being updated, its motor at rest.
#[test]
fn a_valve_that_does_not_close() {
    let mut tried = 0;
    for mut site in without_deployer().filter(|site| site.device.has(SubsystemId::VALVE1)) {
        site.ask(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        site.run(10_000);
        site.board.plant.valves[0].jammed = true;
        site.lock();
        for _ in 0..10_000 {
            site.step();
            if site.device.outputs().is_still() {
                break;
            }
        }
        assert!(site.device.outputs().is_still() && site.is_locked());
        assert_eq!(site.order(&Order::Verify).0, Status::DENIED);
        tried += 1;
    }
    assert!(tried > 0);
}

/// A drive that was moving when the lockout came.
#[test]
fn a_drive_that_moves() {
    let mut tried = 0;
    for mut site in without_deployer() {
        site.ask(SubsystemId::HORIZONTAL, Body::Move { destination: 5000 });
        site.run(1000);
        assert!(!site.device.outputs().is_still());
        site.ask(SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
        assert_eq!(site.order(&Order::Verify).0, Status::DENIED, "in the same moment");
        site.run(10_000);
        assert_eq!(site.order(&Order::Verify).0, Status::ACCEPTED, "at rest");
        tried += 1;
    }
    assert!(tried > 0);
}

/// A drive that turns though it is not fed, and one whose supply is cut for that: after the restart
/// it would turn again.
#[test]
fn a_drive_that_turns_by_itself() {
    let mut tried = 0;
    for mut site in without_deployer() {
        site.lock();
        site.run(10_000);
        assert_ne!(site.order(&Order::Verify).0, Status::DENIED, "at rest");
        site.run(100);
        site.board.plant.drive(Axis::Horizontal).runaway_tenths = 100;
        site.run(20);
        assert!(site.device.outputs().is_still());
        assert_eq!(site.order(&Order::Verify).0, Status::DENIED, "it turns");
        site.run(10_000);
        let [_, horizontal, _, _] = site.device.outputs().drives;
        assert!(
            horizontal.cut && site.device.inputs().drives.iter().all(|it| it.speed_tenths == 0)
        );
        assert_eq!(site.order(&Order::Verify).0, Status::DENIED, "without its supply");
        tried += 1;
    }
    assert!(tried > 0);
}

/// A lockout that a loss of power would release is none: there is no update under it.
#[test]
fn a_lockout_that_is_not_stored() {
    let mut site = Site::new(Composition::FULL);
    site.board.plant.store_fails = true;
    site.lock();
    assert!(site.is_locked());
    assert_eq!(site.order(&begin(&image(2, 512))).0, Status::DENIED);
    site.board.plant.store_fails = false;
    site.lock();
    assert_eq!(site.order(&begin(&image(2, 512))).0, Status::ACCEPTED);
}

/// A monitor that a later start would put on trial is not released before that is taken back.
#[test]
fn a_commit_that_is_pending() {
    let mut site = Site::locked();
    assert!(site.send(&image(2, 512)));
    let record = 10 * 256..14 * 256;
    site.accepts(&Order::Commit { digest: &DIGEST });
    site.app().memory_mut().flash_mut().worn.push(record);
    site.run_still(1000);
    let report = site.report();
    assert_eq!((site.starts, report.slot, report.trial, report.pending), (1, 1, false, true));
    for (_, status, _) in site.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE }) {
        assert_eq!(status, Status::DENIED);
    }
    site.app().memory_mut().flash_mut().worn.clear();
    site.run_still(11_000);
    let report = site.report();
    assert_eq!((site.starts, report.pending, report.failed), (1, false, true));
    site.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
    assert!(!site.is_locked());
    site.start();
    assert!(!site.report().trial, "nothing is tried later");
}

/// What is set on trial is stored when it is confirmed: the old program may not be able to read it.
#[test]
fn what_is_set_on_trial() {
    for confirmed in [false, true] {
        let mut site = Site::locked();
        site.set_speed(7);
        site.run(500);
        let memory = site.board.plant.memory.clone();
        assert!(site.send(&image(2, 512)));
        site.commit();
        assert_eq!(site.set_speed(9), Status::ACCEPTED);
        site.run_still(PROVEN_MS);
        assert_eq!(site.board.plant.memory, memory);
        if confirmed {
            site.accepts(&Order::Confirm { word: LONG_WORD });
            site.run_still(1000);
            assert_ne!(site.board.plant.memory, memory);
        } else {
            site.run_still(TRIAL_MS);
            assert_eq!((site.starts, site.report().slot), (2, 1));
            assert_eq!(site.board.plant.memory, memory, "nor is it by the restart");
        }
    }
}

/// Whose image it is, for two senders that do not know of each other.
#[test]
fn whose_image() {
    let mut site = Site::locked();
    let new = image(2, 512);
    assert!(site.send(&new));
    assert_eq!(site.report().image[..], new.header().hash.0[..4]);
    let report = site.accepts(&Order::Commit { digest: &[7; DIGEST_LEN] });
    assert_eq!((report.phase, report.reason), (Phase::VERIFIED, Refusal::Word.code()));
}

/// What is on trial is locked out even if its memory says nothing of a lockout.
#[test]
fn a_trial_without_parameters() {
    let mut site = Site::locked();
    assert!(site.send(&image(2, 512)));
    let report = site.accepts(&Order::Commit { digest: &DIGEST });
    assert_eq!(report.phase, Phase::COMMITTED);
    site.board.plant.memory.clear();
    site.run_still(1000);
    assert!(site.report().trial && site.is_locked());
}

/// Both answer alike to all that a client may ask of a monitor that is locked out.
#[track_caller]
fn alike(site: &mut Site, twin: &mut Site) {
    let id = Param::HorizontalSpeed.id();
    let bodies = [
        Body::Stop,
        Body::Lockout { key: key::ENABLE },
        Body::GetStatus,
        Body::GetParam { id },
        Body::SetParam { id, values: Ints::Values(&[9]) },
        Body::RetrieveLimits,
        Body::GetCrashData,
        Body::Move { destination: 100 },
        Body::Open { key: key::OPEN },
        Body::Close { key: key::CLOSE },
        Body::Deploy,
        Body::Restart,
    ];
    for body in bodies {
        for to in [SubsystemId::ALL, SubsystemId::HORIZONTAL, SubsystemId::VALVE1] {
            assert_eq!(site.ask(to, body), twin.ask(to, body), "{body:?} to {to}");
        }
    }
}

/// §3.18/3 All that works under lockout works in each phase of an update, and is answered as by a monitor
/// that is not being updated; what does not work is Denied by General as there.
#[test]
fn all_else_goes_on() {
    let new = image(2, 512);
    let mut twin = Site::with(Composition::FULL, None);
    twin.lock();
    let mut site = Site::locked();
    let orders = [
        Order::State,
        begin(&new),
        Order::Data { offset: 0, part: &new.payload[..PART_MAX] },
        Order::Data { offset: 152, part: &new.payload[152..304] },
        Order::Data { offset: 304, part: &new.payload[304..456] },
        Order::Data { offset: 456, part: &new.payload[456..] },
        Order::Verify,
    ];
    for order in orders {
        let (status, _) = site.order(&order);
        assert!(status.is_success(), "{order:?}: {status}");
        // Once while the order waits, once when it has been carried out.
        for _ in 0..2 {
            alike(&mut site, &mut twin);
            site.run_still(STEP_MS);
            twin.run(STEP_MS);
        }
    }
    site.run(100);
    assert_eq!(site.order(&Order::Commit { digest: &DIGEST }).0, Status::ACCEPTED);
    alike(&mut site, &mut twin);
    site.run(1000);
    assert!(site.report().trial);
    twin.start();
    twin.run(1000);
    alike(&mut site, &mut twin);
}

/// Nothing arrives on trial: the monitor goes back by itself, locked out as before.
#[test]
fn a_dead_link() {
    let mut site = Site::locked();
    assert!(site.send(&image(2, 512)));
    site.commit();
    assert!(site.report().trial);
    site.run_still(TRIAL_MS);
    let report = site.report();
    assert_eq!((site.starts, report.slot, report.trial, report.failed), (2, 1, false, true));
    assert_eq!(report.version, [1, 0, 0, 0]);
    assert!(site.is_locked());
    // The data are still there: it is tried again without being sent.
    let report = site.accepts(&begin(&image(2, 512)));
    assert_eq!(report.received, 512);
}

/// A wrong word confirms nothing, however often.
#[test]
fn a_wrong_word() {
    let mut site = Site::locked();
    assert!(site.send(&image(2, 512)));
    site.commit();
    site.run_still(PROVEN_MS);
    for guess in 0..50 {
        let report = site.accepts(&Order::Confirm { word: &[guess; WORD_LEN] });
        assert_eq!((report.trial, report.reason), (true, Refusal::Word.code()));
    }
    assert_ne!(WORD.len(), WORD_LEN, "the word of other tests");
}

/// Why an image is refused is in the report.
#[test]
fn reasons() {
    let mut site = Site::locked();
    let stranger = SigningKey::new(0, [9; 32]);
    let other = Header { board: lafet_update::BoardName::new("other").unwrap(), ..fields(2) };
    let cases = [
        (signed(&stranger, &fields(2), payload(2, 8)), Refusal::Signature),
        (signed(&KEYS[0], &other, payload(2, 8)), Refusal::Board),
        (image(1, 8), Refusal::NotNewer),
        (image(2, 2048), Refusal::Size),
    ];
    for (bad, reason) in cases {
        let report = site.accepts(&begin(&bad));
        assert_eq!((report.phase, report.reason), (Phase::IDLE, reason.code()));
    }
    let mut flipped = image(2, 512);
    flipped.payload[100] ^= 4;
    assert!(!site.send(&flipped));
    let report = site.report();
    assert_eq!((report.phase, report.reason), (Phase::IDLE, Refusal::Hash.code()));
    // A press at the board, and only while it holds.
    site.app().set_pressed(true);
    assert_eq!(site.accepts(&begin(&image(1, 8))).reason, 0);
    site.app().set_pressed(false);
    let report = site.accepts(&begin(&image(1, 16)));
    assert_eq!(report.reason, Refusal::NotNewer.code());
}

/// Data that do not follow the last ones are refused at once, and the answer says what is awaited.
#[test]
fn out_of_order() {
    let mut site = Site::locked();
    let part = &[1; 8];
    assert_eq!(site.order(&Order::Data { offset: 0, part }).0, Status::INVALID_VALUE);
    let new = image(2, 512);
    site.accepts(&begin(&new));
    let first = Order::Data { offset: 0, part: &new.payload[..64] };
    site.accepts(&first);
    for order in [first, Order::Data { offset: 128, part }, Order::Data { offset: u32::MAX, part }]
    {
        let (status, report) = site.order(&order);
        assert_eq!((status, report.received), (Status::INVALID_VALUE, 64));
    }
    // One order at a time.
    assert_eq!(site.order(&Order::Verify).0, Status::ACCEPTED);
    assert_eq!(site.order(&Order::Verify).0, Status::BUSY);
    site.step();
    assert_eq!(site.report().reason, Refusal::Incomplete.code());
}

/// What was accepted is dropped, and that is said, when the monitor may no longer be updated.
#[test]
fn dropped() {
    let mut site = Site::locked();
    let steps = site.app().memory().flash().steps;
    let new = image(2, 8);
    assert_eq!(site.order(&begin(&new)).0, Status::ACCEPTED);
    site.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
    site.run(100);
    let report = site.report();
    assert_eq!((report.phase, report.reason), (Phase::IDLE, Report::NOT_READY));
    assert_eq!(site.app().memory().flash().steps, steps);
    site.lock();
    assert_eq!(site.accepts(&begin(&new)).reason, 0);
}

/// Power fails anywhere in the update, three times: it is gone on with, and ends with the new
/// version, its parameters and its lockout.
#[test]
fn power_cuts() {
    let new = image(2, 768);
    for seed in 0..150 {
        let mut site = Site::locked();
        let speed = site.speed();
        let dice: Chip<8, 256> = Chip::new(1, seed);
        let mut cuts = 3;
        for _ in 0..20 {
            let report = site.report();
            if report.version[0] == 2 && !report.trial {
                break;
            }
            if cuts > 0 {
                let torn = Torn::ALL[dice.random() as usize % 6];
                let step = dice.random() % 160;
                site.app().memory_mut().flash_mut().cut(Cut { step, torn });
                cuts -= 1;
            }
            let starts = site.starts;
            if report.trial {
                site.run_still(PROVEN_MS);
                site.accepts(&Order::Confirm { word: LONG_WORD });
            } else if site.send(&new) && site.starts == starts {
                site.order(&Order::Commit { digest: &DIGEST });
            }
            site.run_still(1000);
        }
        let report = site.report();
        assert_eq!((report.version, report.trial), ([2, 0, 0, 0], false), "seed {seed}");
        assert!(site.is_locked());
        assert_eq!(site.speed(), speed);
    }
}
