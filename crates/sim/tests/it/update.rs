//! Software that is updated over the link (docs/update.md): by raw requests, from the first order to the
//! release, with losses of power, images that are refused and programs that fail on trial.

use std::sync::LazyLock;

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_proto::flags::{GeneralFlags, Severity, set_flags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::{FaultInfo, GeneralStatus};
use lafet_proto::update::{DIGEST_LEN, ORDER_MAX, Order, PART_MAX, Phase, Report, WORD_LEN};
use lafet_proto::{Ints, Record, Request, RequestId, Status, SubsystemId};
use lafet_sim::event::What;
use lafet_sim::flash::{Cut, Damaged, Flash, PAGE, Torn};
use lafet_sim::sim::{Config, Sim, Software, SoftwareFlash, Trial};
use lafet_update::{
    BoardName, HEADER_LEN, Hash, Header, Layouts, Refusal, SigningKey, Slot, Started, Version,
};

/// The word of these updates.
const WORD: &[u8; WORD_LEN] = b"sixteen letters.";
/// Its digest.
static DIGEST: LazyLock<[u8; DIGEST_LEN]> = LazyLock::new(|| Hash::of(WORD).0);
/// After this long on trial a program restarts by itself.
const TRIAL_MS: u64 = 180_000;
/// None is confirmed earlier after its start.
const PROVEN_MS: u64 = 10_000;
const BOARD: &str = "bench";
const FIRST: Version = Version([1, 0, 0, 0]);
const SECOND: Version = Version([2, 0, 0, 0]);

struct Image {
    raw: [u8; HEADER_LEN],
    payload: Vec<u8>,
}

fn maker() -> SigningKey {
    SigningKey::new(3, [5; 32])
}

fn fields(version: Version) -> Header {
    Header {
        size: 0,
        version,
        board: BoardName::new(BOARD).unwrap(),
        place: None,
        key: 0,
        revokes: 0,
        layouts: Layouts { oldest: 1, newest: 1 },
        hash: Hash::default(),
    }
}

fn signed(key: &SigningKey, header: &Header, len: usize) -> Image {
    let payload: Vec<u8> = (0..len).map(|at| (at % 251) as u8).collect();
    Image { raw: key.sign(header, &payload).unwrap(), payload }
}

fn image(version: Version) -> Image {
    signed(&maker(), &fields(version), 1_000)
}

fn software() -> Software {
    Software { board: BOARD.to_owned(), keys: vec![maker().public()], ..Software::default() }
}

fn config() -> Config {
    Config { software: Some(software()), ..Config::default() }
}

/// A new monitor whose images fail on trial like this.
fn failing(trial: Trial) -> Sim {
    locked(Config { software: Some(Software { trial, ..software() }), ..config() })
}

fn locked(config: Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.advance_ms(1_000);
    lock(&mut sim);
    sim
}

fn lock(sim: &mut Sim) {
    ask(sim, SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
    // Without a Deployer its valves may still be on their way.
    sim.advance_ms(10_000);
}

type Answers = Vec<(SubsystemId, Status, Vec<u8>)>;

fn request(sim: &mut Sim, payload: &[u8]) -> Answers {
    let bytes = sim.request(Source::ExternalConn, payload);
    let records = Records::new(&bytes).map(Result::unwrap);
    records.map(|it| (it.device, it.status, it.data.to_vec())).collect()
}

fn ask(sim: &mut Sim, to: SubsystemId, body: Body<'_>) -> Answers {
    let mut buffer = [0; 512];
    let mut writer = Writer::new(&mut buffer);
    Request::new(to, body).encode(&mut writer).unwrap();
    request(sim, writer.written())
}

fn raw(sim: &mut Sim, order: &Order<'_>) -> Answers {
    let (mut data, mut buffer) = ([0; ORDER_MAX], [0; 512]);
    let data = order.encode(&mut data).unwrap();
    let mut writer = Writer::new(&mut buffer);
    let (request_id, device) = (RequestId::UPDATE, SubsystemId::GENERAL);
    writer.push(&Record { request: request_id, device, status: Status::OK, data }).unwrap();
    request(sim, writer.written())
}

/// What is answered to an order.
#[track_caller]
fn order(sim: &mut Sim, order: &Order<'_>) -> (Status, Report) {
    let answers = raw(sim, order);
    let [(from, status, data)] = answers.as_slice() else { panic!("{order:?}: {answers:?}") };
    assert_eq!(*from, SubsystemId::GENERAL);
    (*status, Report::decode(data).unwrap())
}

#[track_caller]
fn state(sim: &mut Sim) -> Report {
    order(sim, &Order::State).1
}

/// Has an order accepted and carried out.
#[track_caller]
fn accepts(sim: &mut Sim, it: &Order<'_>) -> Report {
    let (status, report) = order(sim, it);
    assert_eq!(status, Status::ACCEPTED, "{it:?}: {report:?}");
    sim.advance_ms(20);
    state(sim)
}

fn begin(image: &Image) -> Order<'_> {
    Order::Begin { header: &image.raw, digest: &DIGEST }
}

/// The order that is next, as a sender finds the monitor.
fn next<'a>(report: &Report, image: &'a Image) -> Order<'a> {
    let rest = image.payload.get(report.received as usize..).unwrap_or_default();
    match report.phase {
        _ if report.trial => Order::Confirm { word: WORD },
        Phase::IDLE => begin(image),
        Phase::RECEIVING if rest.is_empty() => Order::Verify,
        Phase::RECEIVING => {
            Order::Data { offset: report.received, part: &rest[..rest.len().min(PART_MAX)] }
        }
        Phase::VERIFIED => Order::Commit { digest: &DIGEST },
        _ => Order::State,
    }
}

/// Time for an order to be carried out, or to wait before the next one, ms.
fn pause_ms(status: Status) -> u64 {
    if status == Status::ACCEPTED { 20 } else { 500 }
}

/// Updates to version 2, whatever comes in between.
#[track_caller]
fn update(sim: &mut Sim, image: &Image) {
    for _ in 0..300 {
        let report = state(sim);
        if report.version == SECOND.0 && !report.trial {
            return;
        }
        let (status, _) = order(sim, &next(&report, image));
        sim.advance_ms(pause_ms(status));
    }
    panic!("no end: {:?}", state(sim));
}

/// Sends an image and has it committed.
#[track_caller]
fn commit(sim: &mut Sim, image: &Image) {
    for _ in 0..100 {
        let report = state(sim);
        let it = next(&report, image);
        let (status, _) = order(sim, &it);
        if status == Status::ACCEPTED && matches!(it, Order::Commit { .. }) {
            return;
        }
        sim.advance_ms(pause_ms(status));
    }
    panic!("it is not committed: {:?}", state(sim));
}

/// Sends an image and has it started on trial.
#[track_caller]
fn start_trial(sim: &mut Sim, image: &Image) {
    commit(sim, image);
    sim.advance_ms(1_000);
}

fn is_locked(sim: &mut Sim) -> bool {
    let answers = ask(sim, SubsystemId::GENERAL, Body::GetStatus);
    let status = GeneralStatus::from_bytes(answers[0].2.as_slice().try_into().unwrap());
    status.flags.contains(GeneralFlags::LOCKED_OUT)
}

/// A parameter that an update must keep; that of a remote unit takes a while to be read.
#[track_caller]
fn speed(sim: &mut Sim) -> Vec<u8> {
    let id = Param::HorizontalSpeed.id();
    for _ in 0..50 {
        let answers = ask(sim, SubsystemId::HORIZONTAL, Body::GetParam { id });
        if let [(_, status, data)] = answers.as_slice()
            && *status == Status::OK
        {
            return data.clone();
        }
        sim.advance_ms(100);
    }
    panic!("the speed cannot be read")
}

fn set_speed(sim: &mut Sim, value: i32) {
    let body = Body::SetParam { id: Param::HorizontalSpeed.id(), values: Ints::Values(&[value]) };
    let answers = ask(sim, SubsystemId::HORIZONTAL, body);
    // A remote unit is given it later.
    assert!(matches!(answers[0].1, Status::ACCEPTED | Status::CACHED), "{answers:?}");
    sim.advance_ms(2_000);
}

/// Subsystems, each with its flags of severity Alarm; of General all from Warning up.
fn alarms(sim: &mut Sim) -> Vec<(SubsystemId, Vec<&'static str>)> {
    let answers = ask(sim, SubsystemId::ALL, Body::GetStatus);
    let of = |(id, _, data): (SubsystemId, Status, Vec<u8>)| {
        let bits = u32::from_le_bytes(data[..4].try_into().unwrap());
        let general = id == SubsystemId::GENERAL;
        let least = if general { Severity::Warning } else { Severity::Alarm };
        let wrong = set_flags(id, bits).filter(|flag| flag.severity() >= least);
        (id, wrong.map(|flag| flag.info.name).collect())
    };
    answers.into_iter().map(of).collect()
}

/// Where everything is.
fn places(sim: &Sim) -> (Vec<f64>, Vec<f64>) {
    let world = sim.world();
    let drives = world.drives.iter().map(|drive| drive.position).collect();
    (drives, world.valves.iter().map(|valve| valve.opening).collect())
}

/// Words written and pages erased of the flash of the software.
fn steps(sim: &Sim) -> u64 {
    sim.world().software_chip().unwrap().steps()
}

fn runs(slot: Slot, version: Version, trial: bool) -> Option<Started> {
    Some(Started { slot, version, trial })
}

/// From the first order to the release, in all compositions: the monitor comes back with the new version,
/// its parameters and its lockout, and nothing has moved.
#[test]
fn an_update() {
    for composition in Composition::ALL {
        let name = composition.name;
        let mut sim = Sim::new(Config { composition, ..config() });
        sim.advance_ms(1_000);
        set_speed(&mut sim, 7);
        let speed_before = speed(&mut sim);
        lock(&mut sim);
        let before = places(&sim);
        let alarms_before = alarms(&mut sim);
        assert_eq!(sim.running(), runs(Slot::A, FIRST, false), "{name}");
        start_trial(&mut sim, &image(SECOND));
        assert_eq!((sim.resets(), sim.running()), (1, runs(Slot::B, SECOND, true)), "{name}");
        assert!(is_locked(&mut sim), "{name}");
        assert_eq!(speed(&mut sim), speed_before, "{name}");
        let released = ask(&mut sim, SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
        assert!(
            released.iter().all(|(_, status, _)| *status == Status::DENIED),
            "{name}: on trial"
        );
        assert_eq!(order(&mut sim, &Order::Confirm { word: WORD }).0, Status::BUSY, "{name}");
        sim.advance_ms(PROVEN_MS);
        // A restart by itself adds no flag on which a sender would give the image up.
        assert_eq!(alarms(&mut sim), alarms_before, "{name}");
        let report = accepts(&mut sim, &Order::Confirm { word: WORD });
        assert_eq!((report.trial, report.reason, report.slot), (false, 0, 2), "{name}");
        sim.advance_ms(TRIAL_MS + 1_000);
        assert_eq!((sim.resets(), sim.running()), (1, runs(Slot::B, SECOND, false)), "{name}");
        assert_eq!(places(&sim), before, "{name}: nothing moves");
        ask(&mut sim, SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
        sim.advance_ms(100);
        assert!(!is_locked(&mut sim), "{name}");
        assert_eq!(speed(&mut sim), speed_before, "{name}");
    }
}

/// A monitor without such software does not know the request; nor does one whose board has no name.
#[test]
fn absent() {
    let nameless = Software { board: String::new(), ..software() };
    for software in [None, Some(nameless)] {
        let mut sim = Sim::new(Config { software, ..Config::default() });
        sim.advance_ms(1_000);
        let answers = raw(&mut sim, &Order::State);
        assert_eq!(answers, [(SubsystemId::GENERAL, Status::WRONG_REQUEST, vec![])]);
        assert_eq!((sim.running(), sim.software_flash()), (None, None));
        lock(&mut sim);
        let answers = raw(&mut sim, &Order::State);
        assert_eq!(answers, [(SubsystemId::GENERAL, Status::DENIED, vec![])]);
    }
}

/// Whatever is wrong with an image is in the report, and nothing is written.
#[test]
fn refused() {
    let mut sim = locked(config());
    let (good, maker) = (fields(SECOND), maker());
    let other = Header { board: BoardName::new("other").unwrap(), ..good };
    let later = Header { layouts: Layouts { oldest: 2, newest: 3 }, ..good };
    let cases = [
        (signed(&SigningKey::new(3, [9; 32]), &good, 8), Refusal::Signature),
        (signed(&SigningKey::new(4, [5; 32]), &good, 8), Refusal::UnknownKey),
        (signed(&maker, &other, 8), Refusal::Board),
        (signed(&maker, &fields(FIRST), 8), Refusal::NotNewer),
        (signed(&maker, &Header { place: Some(Slot::A), ..good }, 8), Refusal::Place),
        (signed(&maker, &later, 8), Refusal::Layout),
        (signed(&maker, &good, 128 * 1024), Refusal::Size),
    ];
    let before = steps(&sim);
    for (bad, reason) in &cases {
        let report = accepts(&mut sim, &begin(bad));
        assert_eq!((report.phase, report.reason), (Phase::IDLE, reason.code()), "{reason}");
        assert_eq!(steps(&sim), before, "{reason}");
    }
    // Not what was signed.
    let mut bad = image(SECOND);
    bad.payload[100] ^= 4;
    let mut report = accepts(&mut sim, &begin(&bad));
    while report.phase != Phase::IDLE {
        let (status, _) = order(&mut sim, &next(&report, &bad));
        sim.advance_ms(pause_ms(status));
        report = state(&mut sim);
    }
    assert_eq!(report.reason, Refusal::Hash.code());
    assert_eq!(sim.running(), runs(Slot::A, FIRST, false));
    // The simulator's own key is known to it.
    let own = signed(&Software::factory_key(), &good, 8);
    assert_eq!(accepts(&mut sim, &begin(&own)).reason, 0);
}

/// Only a monitor that is locked out.
#[test]
fn denied() {
    let mut sim = Sim::new(config());
    sim.advance_ms(1_000);
    let before = steps(&sim);
    assert_eq!(order(&mut sim, &begin(&image(SECOND))).0, Status::DENIED);
    sim.advance_ms(1_000);
    assert_eq!((steps(&sim), state(&mut sim).phase), (before, Phase::IDLE));
}

/// The new program answers nothing: it goes back by itself, locked out as before.
#[test]
fn a_dead_link() {
    let mut sim = failing(Trial::DeadLink);
    start_trial(&mut sim, &image(SECOND));
    assert_eq!(sim.running(), runs(Slot::B, SECOND, true));
    sim.advance_ms(TRIAL_MS - 5_000);
    assert_eq!((raw(&mut sim, &Order::State), sim.resets()), (vec![], 1));
    assert!(sim.handle(Source::Radio, &[0xD4, 0x00, 0, 0]).is_empty(), "nor is anything else");
    sim.advance_ms(10_000);
    let report = state(&mut sim);
    assert_eq!((report.slot, report.failed, report.version), (1, true, FIRST.0));
    assert!(is_locked(&mut sim) && sim.resets() == 2);
}

/// The sender ends a trial: the old program is back within seconds, locked out as before.
#[test]
fn a_trial_is_ended() {
    let mut sim = locked(config());
    start_trial(&mut sim, &image(SECOND));
    accepts(&mut sim, &Order::Abandon { digest: &DIGEST });
    sim.advance_ms(2_000);
    let report = state(&mut sim);
    assert_eq!((report.slot, report.trial, report.failed), (1, false, true));
    assert_eq!(sim.running(), runs(Slot::A, FIRST, false));
    assert!(is_locked(&mut sim) && sim.resets() == 2);
}

/// The only image that can be started is one that has failed: the same version is taken once more, into the other
/// slot, and can be confirmed there.
#[test]
fn a_failed_image_is_all_there_is() {
    let (mut sim, new) = (locked(config()), image(SECOND));
    start_trial(&mut sim, &new);
    sim.advance_ms(TRIAL_MS + 5_000);
    assert_eq!(sim.running(), runs(Slot::A, FIRST, false));
    sim.world_mut().software_chip_mut().unwrap().flip(16, 0);
    sim.power_cycle();
    sim.advance_ms(1_000);
    assert_eq!(sim.running(), runs(Slot::B, SECOND, true));
    let mut report = accepts(&mut sim, &begin(&new));
    assert_eq!((report.phase, report.reason), (Phase::RECEIVING, 0));
    while report.phase != Phase::COMMITTED {
        let it = next(&Report { trial: false, ..report }, &new);
        let (status, _) = order(&mut sim, &it);
        sim.advance_ms(pause_ms(status));
        match raw(&mut sim, &Order::State).as_slice() {
            [(_, _, data)] => report = Report::decode(data).unwrap(),
            // It restarts.
            _ => break,
        }
        if report.slot == 1 {
            break;
        }
    }
    sim.advance_ms(PROVEN_MS + 1_000);
    assert_eq!(sim.running(), runs(Slot::A, SECOND, true));
    let report = accepts(&mut sim, &Order::Confirm { word: WORD });
    assert_eq!((report.trial, report.slot, report.reason), (false, 1, 0));
}

/// The new program hangs: its watchdog leads back to the old one.
#[test]
fn an_image_that_hangs() {
    let mut sim = failing(Trial::Hangs);
    start_trial(&mut sim, &image(SECOND));
    assert_eq!((sim.running(), raw(&mut sim, &Order::State)), (None, vec![]));
    assert!(sim.stood_still() && sim.world().outputs().is_still());
    sim.advance_ms(3_000);
    let report = state(&mut sim);
    assert_eq!((report.slot, report.trial, report.failed), (1, false, true));
    assert_eq!(sim.running(), runs(Slot::A, FIRST, false));
    assert!(is_locked(&mut sim) && sim.resets() == 1, "a watchdog is no request");
}

/// A program that fails on trial has failed.
#[test]
fn a_crash_on_trial() {
    let mut sim = locked(config());
    start_trial(&mut sim, &image(SECOND));
    sim.crash(FaultInfo::from_words([0; 20]));
    sim.advance_ms(1_000);
    let report = state(&mut sim);
    assert_eq!((report.slot, report.trial, report.failed), (1, false, true));
    assert!(is_locked(&mut sim));
}

/// Power fails in words and erases of the flash, torn in each way: the update comes to its end.
#[test]
fn power_cuts() {
    let (base, new) = (locked(config()), image(SECOND));
    let mut plain = base.clone();
    update(&mut plain, &new);
    let all = steps(&plain) - steps(&base);
    assert!(all > 150, "{all} words and erases");
    for (index, step) in (0..all).step_by(3).enumerate() {
        let torn = Torn::ALL[index % Torn::ALL.len()];
        let what = format!("step {step}, {torn:?}");
        let mut sim = base.clone();
        sim.world_mut().take_events();
        sim.cut_software_at(&[Cut { step, torn }]);
        update(&mut sim, &new);
        let events = sim.world_mut().take_events();
        assert!(events.iter().any(|event| event.what == What::PoweredUp), "{what}: no cut");
        sim.advance_ms(1_000);
        assert_eq!(sim.running(), runs(Slot::B, SECOND, false), "{what}");
        assert!(is_locked(&mut sim), "{what}");
    }
}

/// Power fails while the flash is busy: what was not done by then was not done.
#[test]
fn power_fails_while_the_flash_is_busy() {
    let (base, new) = (locked(config()), image(SECOND));
    let mut busy = 0;
    for ms in (10..150).step_by(10) {
        let mut sim = base.clone();
        assert_eq!(order(&mut sim, &begin(&new)).0, Status::ACCEPTED);
        sim.advance_ms(ms);
        busy += u32::from(sim.world().stays_stalled());
        sim.power_cycle();
        update(&mut sim, &new);
        assert!(is_locked(&mut sim), "{ms} ms after begin");
    }
    assert!(busy > 0);
    let mut committed = base;
    commit(&mut committed, &new);
    for ms in (10..400).step_by(10) {
        let mut sim = committed.clone();
        sim.advance_ms(ms);
        sim.power_cycle();
        sim.advance_ms(1_000);
        update(&mut sim, &new);
        assert!(is_locked(&mut sim), "{ms} ms after commit");
    }
}

/// Without an image that may be started the monitor is silent, and looks again.
#[test]
fn nothing_to_start() {
    let mut sim = locked(config());
    sim.world_mut().software_chip_mut().unwrap().flip(16, 0);
    sim.power_cycle();
    sim.advance_ms(60_000);
    assert_eq!((sim.running(), raw(&mut sim, &Order::State)), (None, vec![]));
    sim.pass_ms(60_000);
    assert!(sim.stood_still());
    sim.world_mut().software_chip_mut().unwrap().flip(16, 0);
    sim.advance_ms(6_000);
    assert_eq!(sim.running(), runs(Slot::A, FIRST, false));
    assert!(is_locked(&mut sim));
    sim.power_off();
    assert_eq!(sim.running(), None);
}

/// The flash can be kept in a file; the file of another board has nothing for this one.
#[test]
fn it_is_carried_over() {
    let mut sim = locked(config());
    update(&mut sim, &image(SECOND));
    sim.advance_ms(1_000);
    let memory = Flash::from_bytes(&sim.world().flash.to_bytes()).unwrap();
    let bytes = sim.software_flash().unwrap();
    let carried = |board: &str| {
        let flash = Some(SoftwareFlash::from_bytes(&bytes).unwrap());
        let software = Software { flash, board: board.to_owned(), slot_bytes: 0, ..software() };
        let flash = Some(memory.clone());
        Sim::new(Config { flash, software: Some(software), ..Config::default() })
    };
    let mut again = carried(BOARD);
    again.advance_ms(1_000);
    assert_eq!(again.running(), runs(Slot::B, SECOND, false));
    assert!(again.software_flash() == Some(bytes.clone()) && is_locked(&mut again));
    let report = accepts(&mut again, &begin(&image(SECOND)));
    assert_eq!(report.reason, Refusal::NotNewer.code(), "it knows what was confirmed last");
    assert_eq!(carried("other").running(), None);

    let mut flipped = bytes.clone();
    flipped[5_000] ^= 4;
    let wrong = sim.world().flash.to_bytes();
    for damaged in [&bytes[..17], &bytes[..bytes.len() - 1], &flipped, &wrong, b""] {
        assert_eq!(SoftwareFlash::from_bytes(damaged).err(), Some(Damaged));
    }
}

/// Slots have any size that makes sense, and are as large as the nearest of these otherwise.
#[test]
fn sizes_of_slots() {
    for (slot_bytes, pages) in [(0, 4), (8 * 1024 + 1, 5), (u32::MAX, 1024)] {
        let sim =
            Sim::new(Config { software: Some(Software { slot_bytes, ..software() }), ..config() });
        assert_eq!(sim.running(), runs(Slot::A, FIRST, false), "{slot_bytes} bytes");
        let chip = sim.world().software_chip().unwrap();
        assert_eq!(chip.bytes().len(), (2 * pages + 4) * PAGE, "{slot_bytes} bytes");
    }
}

/// Monitors that are updated by the same orders at the same times.
struct Three {
    /// Makes every step.
    stepped: Sim,
    /// Counts steps while it rests, and lets them wait.
    counting: Sim,
    /// Passes over rest.
    passing: Sim,
}

impl Three {
    fn new() -> Self {
        let counting = Sim::new(config());
        // Who keeps a trace makes every step.
        let stepped = Sim::new(Config { trace: true, ..config() });
        Self { stepped, passing: counting.clone(), counting }
    }

    fn advance_ms(&mut self, ms: u64) {
        self.stepped.advance_ms(ms);
        self.counting.advance_ms(ms);
        self.passing.pass_ms(ms);
    }

    /// They are as one.
    #[track_caller]
    fn compare(&self) {
        let Self { stepped, counting, passing } = self;
        for sim in [counting, passing] {
            assert_eq!((sim.now_ms(), sim.running()), (stepped.now_ms(), stepped.running()));
            assert!(sim.software_flash() == stepped.software_flash(), "the flash");
            assert!(stepped.device().is_same_state(sim.device()), "the program");
        }
        assert_eq!(counting.device(), stepped.device(), "to the bit");
    }

    #[track_caller]
    fn each<T: PartialEq + std::fmt::Debug>(&mut self, mut ask: impl FnMut(&mut Sim) -> T) -> T {
        let Self { stepped, counting, passing } = self;
        let [first, second, third] = [stepped, counting, passing].map(&mut ask);
        assert_eq!(first, second);
        assert_eq!(first, third);
        first
    }
}

/// Steps that are counted, wait or are passed over change nothing: each phase, the trial and its end come
/// at the same time as step by step. A monitor at rest that could be updated rests all the same.
#[test]
fn skipped_steps() {
    for looks in [true, false] {
        let (mut three, new) = (Three::new(), image(SECOND));
        three.advance_ms(1_000);
        three.each(|sim| ask(sim, SubsystemId::ALL, Body::Lockout { key: key::ENABLE }));
        three.advance_ms(60_000);
        // A pause after each order, in which all but what is verified rests.
        while !three.each(state).trial {
            let report = three.each(state);
            let it = next(&report, &new);
            let (status, _) = three.each(|sim| order(sim, &it));
            three.advance_ms(pause_ms(status) * 100);
            if looks {
                three.compare();
            }
        }
        three.advance_ms(TRIAL_MS + 10_000);
        three.compare();
        let report = three.each(state);
        assert_eq!((report.slot, report.failed), (1, true));
        let events = three.each(|sim| sim.world_mut().take_events());
        let resets: Vec<u64> = events
            .iter()
            .filter(|event| event.what == What::Reset)
            .map(|event| event.at_ms)
            .collect();
        let [committed, back] = resets[..] else { panic!("{resets:?}") };
        let trial_ms = back - committed;
        assert!((TRIAL_MS..TRIAL_MS + 1_000).contains(&trial_ms), "{trial_ms} ms");

        three.advance_ms(600_000);
        three.compare();
        for sim in [&three.counting, &three.passing] {
            assert!(sim.passed_over_ms() > 300_000, "{} ms", sim.passed_over_ms());
        }
    }
}

/// The same seed and the same orders give the same trace and the same flash, byte for byte.
#[test]
fn same_seed_same_trace() {
    let updated = || {
        let mut sim = locked(Config { seed: 7, trace: true, ..config() });
        sim.cut_software_at(&[40, 60].map(|step| Cut { step, torn: Torn::Mixed }));
        update(&mut sim, &image(SECOND));
        (sim.take_trace(), sim.software_flash())
    };
    let first = updated();
    assert!(first.0.as_deref().is_some_and(|trace| trace.lines().count() > 100));
    assert!(first == updated());
}
