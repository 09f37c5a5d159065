//! The sender of an update against a model of a monitor, behind a line that loses requests and answers.

mod images;
mod line;
mod model;
mod words;

use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use lafet_client::transport::memory::pair;
use lafet_client::update::{
    Before, Change, Image, Pace, Stage, Trial, Unready, UpdateError, Updated, digest_of, is_over,
};
use lafet_client::{Client, Config, Error, Monitor};
use lafet_proto::flags::{DetectorFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::link::Decoder;
use lafet_proto::update::{DIGEST_LEN, PART_MAX, Phase};
use lafet_proto::{RequestId, Status, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Instant, sleep};

use model::{
    ABANDON, BEGIN, CHAIN, COMMIT, CONFIRM, DATA, Dice, Fate, Model, NEW, OLD, STATE, STEP, TRIAL,
    VERIFY, WORD, file, payload,
};

fn image(version: [u16; 4], slot: u8, len: usize) -> Image {
    Image::read(&file(version, slot, &payload(len))).unwrap()
}

/// The new version, for slot B.
fn new() -> Image {
    image(NEW, 2, 2000)
}

type Shared = Arc<Mutex<Model>>;

/// Serves the model; an exchange takes `delay`.
async fn serve(mut stream: DuplexStream, model: Shared, delay: Duration) {
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 2048];
    while let Ok(len @ 1..) = stream.read(&mut buffer).await {
        let mut replies = Vec::new();
        for byte in &buffer[..len] {
            if let Some(asked) = decoder.push(*byte) {
                replies.extend(model.lock().unwrap().answer(asked.payload));
            }
        }
        sleep(delay).await;
        if stream.write_all(&replies).await.is_err() {
            return;
        }
    }
}

fn start_slow(model: Model, delay: Duration) -> (Monitor, Shared) {
    let shared = Arc::new(Mutex::new(model));
    let (ours, theirs) = pair();
    tokio::spawn(serve(theirs, shared.clone(), delay));
    (Monitor::new(Client::over("test", ours, Config::default())), shared)
}

fn start(model: Model) -> (Monitor, Shared) {
    start_slow(model, Duration::from_millis(1))
}

async fn update(monitor: &Monitor, image: Image) -> Result<Updated, UpdateError> {
    monitor.update(&[image], &WORD, Pace::FULL, |_| {}).await
}

/// The new version is kept, as it was sent, and was committed and confirmed once.
#[track_caller]
fn is_updated(model: &MutexGuard<'_, Model>, image: &Image) {
    assert_eq!((model.slot, model.trial, model.version()), (2, false, NEW));
    assert!(model.bytes == image.payload(), "other bytes arrived");
    assert_eq!((model.commits, model.confirms), (1, 1), "{:?}", model.orders);
}

/// From the beginning to the end: nothing is asked but orders and states, and each stage is reported.
#[tokio::test(start_paused = true)]
async fn an_update() {
    let (monitor, model) = start(Model::new());
    assert_eq!(monitor.software().await.unwrap().version, OLD);
    let mut stages = Vec::new();
    let images = [image(NEW, 1, 800), new()];
    let updated = monitor.update(&images, &WORD, Pace::FULL, |stage| stages.push(stage)).await;
    assert_eq!(updated.unwrap(), Updated { from: OLD, to: NEW });
    let model = model.lock().unwrap();
    is_updated(&model, &images[1]);
    let allowed = [RequestId::UPDATE, RequestId::GET_STATUS, RequestId::GET_PARAM];
    assert!(model.requests.iter().all(|id| allowed.contains(id)), "{:?}", model.requests);
    let offsets: Vec<u32> = (0..2000).step_by(PART_MAX).map(|at| at as u32).collect();
    assert_eq!(model.offsets, offsets, "each part once");
    assert_eq!(stages[0], Stage::Sending { done: 0, size: 2000, left: None });
    let sent = |stage: &Stage| matches!(stage, Stage::Sending { done: 2000, size: 2000, .. });
    assert!(stages.iter().any(sent));
    let rest: Vec<_> =
        stages.into_iter().filter(|stage| !matches!(stage, Stage::Sending { .. })).collect();
    let wanted = [
        Stage::Verifying,
        Stage::Committing,
        Stage::Committed,
        Stage::Restarting,
        Stage::OnTrial,
        Stage::Confirming,
        Stage::Confirmed,
    ];
    assert_eq!(rest, wanted);
}

/// Requests and answers are lost, answers come twice: the same image arrives, and is committed once.
#[tokio::test(start_paused = true)]
async fn losses() {
    for seed in 0..60 {
        let mut dice = Dice(seed);
        let (monitor, model) = start(Model::hooked(move |model, _| match dice.roll() % 12 {
            // Nothing is repeated for long before it is known that the monitor is there.
            _ if model.count(BEGIN) == 0 => Fate::Fine,
            0 => Fate::LoseRequest,
            1 => Fate::LoseAnswer,
            2 => Fate::Doubled,
            _ => Fate::Fine,
        }));
        let updated = update(&monitor, new()).await;
        assert_eq!(updated.unwrap(), Updated { from: OLD, to: NEW }, "seed {seed}");
        let model = model.lock().unwrap();
        assert!(model.bytes == new().payload(), "seed {seed}");
        assert_eq!((model.slot, model.trial, model.commits), (2, false, 1), "seed {seed}");
    }
}

/// The answer to each kind of order is lost once, and the request once.
#[tokio::test(start_paused = true)]
async fn each_order_is_lost_once() {
    for lost in 0..=CONFIRM {
        for fate in [Fate::LoseRequest, Fate::LoseAnswer] {
            let mut left = true;
            let (monitor, model) = start(Model::hooked(move |_, kind| {
                let hits = kind == lost && std::mem::take(&mut left);
                if hits { fate } else { Fate::Fine }
            }));
            update(&monitor, new()).await.unwrap();
            is_updated(&model.lock().unwrap(), &new());
        }
    }
}

/// A model whose cable is pulled at its fifth order of data.
fn pulled(time: Duration) -> Model {
    Model::hooked(move |model, kind| {
        if kind == DATA && model.count(DATA) == 5 {
            model.dead_until = Some(Instant::now() + time);
        }
        Fate::Fine
    })
}

/// A cable that is pulled for half a minute costs that time; one that stays away ends it with the client's
/// error, and another run goes on behind what has arrived.
#[tokio::test(start_paused = true)]
async fn a_cable_is_pulled() {
    let (monitor, model) = start(pulled(Duration::from_secs(30)));
    update(&monitor, new()).await.unwrap();
    is_updated(&model.lock().unwrap(), &new());

    let (monitor, model) = start(pulled(Duration::from_secs(600)));
    let started = Instant::now();
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(&error, UpdateError::Client(error) if error.is_no_answer()), "{error}");
    let waited = started.elapsed();
    assert!(waited > Duration::from_secs(60) && waited < Duration::from_secs(90), "{waited:?}");
    sleep(Duration::from_secs(600)).await;
    update(&monitor, new()).await.unwrap();
    let model = model.lock().unwrap();
    is_updated(&model, &new());
    let again = model.offsets.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    assert_eq!(again, 0, "{:?}", model.offsets);
}

/// Nothing answers from the start: the usual patience, not that for a cable.
#[tokio::test(start_paused = true)]
async fn a_dead_line() {
    let (monitor, model) = start(pulled(Duration::ZERO));
    model.lock().unwrap().dead_until = Some(Instant::now() + Duration::from_secs(3600));
    let started = Instant::now();
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(&error, UpdateError::Client(error) if error.is_no_answer()), "{error}");
    assert!(started.elapsed() < Duration::from_secs(30), "{:?}", started.elapsed());
}

/// Power is lost in the middle of the data: it goes on behind the last page that is complete.
#[tokio::test(start_paused = true)]
async fn a_restart_amid_the_data() {
    let (monitor, model) = start(Model::hooked(|model, kind| {
        if kind == DATA && model.count(DATA) % 10 == 7 && model.count(BEGIN) < 4 {
            model.restart(Instant::now());
        }
        Fate::Fine
    }));
    update(&monitor, new()).await.unwrap();
    let model = model.lock().unwrap();
    is_updated(&model, &new());
    assert!(model.count(BEGIN) > 1);
    let back = model.offsets.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(back > 0, "{:?}", model.offsets);
    assert!(model.offsets.iter().filter(|at| **at == 0).count() == 1, "{:?}", model.offsets);
}

/// Power is lost between the commit and its storage: it is verified and committed again.
#[tokio::test(start_paused = true)]
async fn a_commit_that_is_lost() {
    let mut lost = false;
    let (monitor, model) = start(Model::hooked(move |model, kind| {
        if kind == STATE && model.commits == 1 && model.held.is_some() && !lost {
            lost = true;
            model.restart(Instant::now());
        }
        Fate::Fine
    }));
    update(&monitor, new()).await.unwrap();
    let model = model.lock().unwrap();
    assert_eq!((model.slot, model.trial, model.commits), (2, false, 2));
}

/// An image that crashes is committed once, even if the answer to its commit is lost.
#[tokio::test(start_paused = true)]
async fn a_trial_that_goes_back() {
    for lost in [false, true] {
        let hook = move |_: &mut Model, kind: u8| {
            if lost && kind == COMMIT { Fate::LoseAnswer } else { Fate::Fine }
        };
        let (monitor, model) = start(Model { crashes: true, ..Model::hooked(hook) });
        let error = update(&monitor, new()).await.unwrap_err();
        let UpdateError::WentBack { wanted, running, lived } = error else { panic!("{error}") };
        assert_eq!((wanted, running, lived), (NEW, OLD, false));
        let model = model.lock().unwrap();
        assert_eq!((model.count(COMMIT), model.commits, model.confirms), (1, 1, 0));
    }
}

/// The new image does not answer: that is said, and nothing is confirmed.
#[tokio::test(start_paused = true)]
async fn a_trial_that_is_silent() {
    let (monitor, model) = start(Model { mutes: true, ..Model::new() });
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(error, UpdateError::Silent(_)), "{error}");
    assert_eq!(model.lock().unwrap().confirms, 0);
}

/// A subsystem is missing after the restart: not confirmed, and the error comes when the old image runs again; at
/// once where the program on trial knows Abandon or restarts, after the time of a trial where its lockout forbids that.
#[tokio::test(start_paused = true)]
async fn a_trial_without_a_subsystem() {
    for (abandons, restarts) in [(true, false), (false, true), (false, false)] {
        let (monitor, model) =
            start(Model { lacks_valve: true, abandons, restarts, ..Model::new() });
        let started = Instant::now();
        let error = update(&monitor, new()).await.unwrap_err();
        let UpdateError::Changed { what, back } = &error else { panic!("{error}") };
        assert!(matches!(what[..], [Change::Absent(SubsystemId::VALVE1)]), "{error}");
        assert_eq!(*back, Some(OLD));
        let soon = started.elapsed() < TRIAL / 2;
        assert_eq!(soon, abandons || restarts, "{:?}", started.elapsed());
        let model = model.lock().unwrap();
        assert_eq!((model.slot, model.confirms), (1, 0));
    }
}

/// The order that ends a trial, and its answer, are lost: it is given again.
#[tokio::test(start_paused = true)]
async fn an_abandon_that_is_lost() {
    for fate in [Fate::LoseRequest, Fate::LoseAnswer] {
        let mut left = 2;
        let hook = move |_: &mut Model, kind: u8| match kind == ABANDON && left > 0 {
            true => {
                left -= 1;
                fate
            }
            false => Fate::Fine,
        };
        let (monitor, model) = start(Model { lacks_valve: true, ..Model::hooked(hook) });
        let started = Instant::now();
        let error = update(&monitor, new()).await.unwrap_err();
        assert!(matches!(error, UpdateError::Changed { back: Some(OLD), .. }), "{error}");
        assert!(started.elapsed() < TRIAL / 2, "{:?}", started.elapsed());
        assert_eq!(model.lock().unwrap().confirms, 0);
    }
}

/// A flag that says that something is wrong is no reason against an image if it was set before.
#[tokio::test(start_paused = true)]
async fn a_trial_with_a_fault() {
    let trial_flags = GeneralFlags::INTERNAL_FAULT;
    let general = (SubsystemId::GENERAL, "InternalFault");
    let vertical = (SubsystemId::VERTICAL, "PosEncoderFault");
    let trial_drive = DriveFlags::POS_ENCODER_FAULT;
    let late = Duration::from_secs(5);
    for (model, wanted) in [
        (Model { trial_flags, ..Model::new() }, general),
        // It shows after the first status of the new image.
        (Model { trial_flags, trial_after: late, ..Model::new() }, general),
        (Model { trial_drive, ..Model::new() }, vertical),
    ] {
        let (monitor, model) = start(model);
        let error = update(&monitor, new()).await.unwrap_err();
        let UpdateError::Changed { what, .. } = &error else { panic!("{error}") };
        let [Change::Fault { who, flag }] = what[..] else { panic!("{error}") };
        assert_eq!((who, flag), wanted);
        assert_eq!(model.lock().unwrap().confirms, 0);
    }
    let flags = GeneralFlags::LOCKED_OUT | trial_flags;
    let fire = DetectorFlags::FOUND;
    for well in [
        Model { trial_flags, flags, ..Model::new() },
        Model { drive: trial_drive, trial_drive, ..Model::new() },
        // What comes with each start, and a fire, are no fault of the image.
        Model { trial_drive: DriveFlags::LIMITLESS, trial_detector: fire, ..Model::new() },
    ] {
        let (monitor, model) = start(well);
        update(&monitor, new()).await.unwrap();
        is_updated(&model.lock().unwrap(), &new());
    }
}

/// An image that answers at first is watched for a while: one that lives for a few seconds is not confirmed.
#[tokio::test(start_paused = true)]
async fn a_trial_that_dies() {
    let lives = Some(Duration::from_secs(3));
    let (monitor, model) = start(Model { lives, ..Model::new() });
    let error = update(&monitor, new()).await.unwrap_err();
    let wanted = UpdateError::WentBack { wanted: NEW, running: OLD, lived: true };
    assert_eq!(error.to_string(), wanted.to_string());
    let model = model.lock().unwrap();
    assert_eq!((model.slot, model.confirms), (1, 0));
}

/// The time for which it is watched counts without a break, and can be chosen.
#[tokio::test(start_paused = true)]
async fn how_long_a_trial_is_watched() {
    let mut times = Vec::new();
    for seconds in [5, 20] {
        let (monitor, model) = start(Model::tried());
        let proven = Duration::from_secs(seconds);
        let trial = Trial { proven, ..Trial::new(&WORD, Pace::FULL) };
        let since = Instant::now();
        monitor.update_with(&[new()], &trial, |_| {}).await.unwrap();
        times.push(since.elapsed());
        assert!(since.elapsed() >= proven, "{times:?}");
        assert_eq!(model.lock().unwrap().confirms, 1);
    }
    assert!(times[0] < Duration::from_secs(8) && times[1] < Duration::from_secs(25), "{times:?}");
    // The monitor itself confirms nothing earlier, whatever the sender does.
    let young = Duration::from_secs(10);
    let (monitor, model) = start(Model { young, ..Model::tried() });
    let trial = Trial { proven: Duration::ZERO, ..Trial::new(&WORD, Pace::FULL) };
    let since = Instant::now();
    monitor.update_with(&[new()], &trial, |_| {}).await.unwrap();
    assert!(since.elapsed() >= young, "{:?}", since.elapsed());
    assert_eq!(model.lock().unwrap().confirms, 1);
    // A cable that is pulled in between starts it again.
    let mut looks = 0;
    let (monitor, model) = start(Model {
        hook: Some(Box::new(move |model, kind| {
            looks += u32::from(kind == STATE);
            if looks == 20 {
                looks += 1;
                model.dead_until = Some(Instant::now() + Duration::from_secs(20));
            }
            Fate::Fine
        })),
        ..Model::tried()
    });
    let since = Instant::now();
    update(&monitor, new()).await.unwrap();
    assert!(since.elapsed() >= Duration::from_secs(40), "{:?}", since.elapsed());
    assert_eq!(model.lock().unwrap().confirms, 1);
}

/// A parameter that waits for a restart would take effect with it, and look like a fault of the image.
#[tokio::test(start_paused = true)]
async fn a_parameter_that_waits_for_a_restart() {
    for (address, chain, param) in
        [(Some(5), Some(CHAIN), "Address"), (Some(1), Some(CHAIN & !(1 << 5)), "Chain")]
    {
        let (monitor, model) = start(Model { address, chain, ..Model::new() });
        let error = update(&monitor, new()).await.unwrap_err();
        let UpdateError::NotReady(why) = &error else { panic!("{error}") };
        assert_eq!(*why, [Unready::WaitsForRestart { param }], "{error}");
        assert_eq!(model.lock().unwrap().count(BEGIN), 0);
    }
    // It is set while data are sent.
    let (monitor, model) = start(Model::hooked(|model, kind| {
        if kind == DATA {
            model.address = Some(5);
        }
        Fate::Fine
    }));
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(error, UpdateError::NotReady(_)), "{error}");
    assert_eq!(model.lock().unwrap().count(COMMIT), 0);
    // Monitors of other makers may not have them.
    let (monitor, model) = start(Model { address: None, chain: None, ..Model::new() });
    update(&monitor, new()).await.unwrap();
    is_updated(&model.lock().unwrap(), &new());
}

/// What the monitor was before is kept before the commit; where it cannot be, nothing is committed.
#[tokio::test(start_paused = true)]
async fn what_it_was_before() {
    let (monitor, model) = start(Model::new());
    let kept = Mutex::new(None);
    let keep = |before: &Before| {
        assert_eq!(model.lock().unwrap().count(COMMIT), 0);
        *kept.lock().unwrap() = Some(before.clone());
        Ok(())
    };
    let trial = Trial { keep: &keep, ..Trial::new(&WORD, Pace::FULL) };
    monitor.update_with(&[new()], &trial, |_| {}).await.unwrap();
    let before = kept.lock().unwrap().clone().unwrap();
    assert_eq!(Before::parse(&before.to_text()), Some(before.clone()));

    let (monitor, model) = start(Model::new());
    let full = |_: &Before| Err(std::io::Error::other("no room"));
    let trial = Trial { keep: &full, ..Trial::new(&WORD, Pace::FULL) };
    let error = monitor.update_with(&[new()], &trial, |_| {}).await.unwrap_err();
    assert!(matches!(error, UpdateError::Note(_)), "{error}");
    assert_eq!(model.lock().unwrap().count(COMMIT), 0);

    // A run that was cut off: the next one compares with it. Without it, with the composition.
    let bad = || Model { lacks_valve: true, ..Model::tried() };
    let faulty = || Model { trial_flags: GeneralFlags::INTERNAL_FAULT, ..Model::tried() };
    let unknown = || Model { chain: None, ..bad() };
    for (model, before, well) in [
        (bad(), Some(&before), false),
        (faulty(), Some(&before), false),
        (Model::tried(), Some(&before), true),
        (bad(), None, false),
        (faulty(), None, true),
        (unknown(), None, true),
        (unknown(), Some(&before), false),
    ] {
        let (monitor, model) = start(model);
        let trial = Trial { before, ..Trial::new(&WORD, Pace::FULL) };
        let ended = monitor.update_with(&[new()], &trial, |_| {}).await;
        assert_eq!(ended.is_ok(), well, "{ended:?}");
        assert_eq!(model.lock().unwrap().confirms, u32::from(well));
    }
}

/// With a word that is new, what is on trial is replaced if it has nothing to go back to; otherwise the monitor
/// refuses that. A run that was cut off amid that goes on with it.
#[tokio::test(start_paused = true)]
async fn a_trial_without_its_word() {
    let newer = || image(NEW, 0, 2000);
    for has_no_other in [true, false] {
        let (monitor, model) = start(Model { has_no_other, ..Model::tried() });
        let trial = Trial { fresh: true, ..Trial::new(&[1; 16], Pace::FULL) };
        let ended = monitor.update_with(&[newer()], &trial, |_| {}).await;
        let model = model.lock().unwrap();
        match ended {
            Ok(_) => assert!(has_no_other && model.slot == 1 && model.version() == NEW),
            Err(error) => {
                assert!(matches!(error, UpdateError::Refused(18)), "{error}");
                assert!(!has_no_other && model.confirms == 0);
            }
        }
    }
    let mut half = Model { has_no_other: true, ..Model::tried() };
    half.begin(newer().header(), &digest_of(&WORD));
    let (monitor, model) = start(half);
    update(&monitor, newer()).await.unwrap();
    assert_eq!(model.lock().unwrap().slot, 1);
}

/// A program that says at first that it is not on trial is asked once more.
#[tokio::test(start_paused = true)]
async fn a_trial_that_is_said_late() {
    let mut asked = 0;
    let (monitor, model) = start(Model::hooked(move |model, kind| {
        if kind == STATE && model.slot == 2 && asked < 2 {
            asked += 1;
            model.trial = asked == 2;
        }
        Fate::Fine
    }));
    update(&monitor, new()).await.unwrap();
    is_updated(&model.lock().unwrap(), &new());
}

/// A monitor of another maker may answer 24 bytes to this request.
#[tokio::test(start_paused = true)]
async fn reports_that_cannot_be() {
    let (monitor, _) = start(Model { slot: 1, phase: Phase(9), ..Model::new() });
    let error = update(&monitor, new()).await.unwrap_err();
    let odd = matches!(&error, UpdateError::Client(Error::Protocol { .. }));
    assert!(odd, "{error}");
}

/// Another sender starts another image in between: nothing more is sent.
#[tokio::test(start_paused = true)]
async fn another_sender() {
    let foreign = image([3, 0, 0, 0], 2, 800);
    let header = *foreign.header();
    let (monitor, model) = start(Model::hooked(move |model, kind| {
        if kind == DATA && model.count(DATA) == 6 {
            model.held = None;
            model.begin(&header, &[7; DIGEST_LEN]);
        }
        Fate::Fine
    }));
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(error, UpdateError::OtherSender), "{error}");
    let model = model.lock().unwrap();
    assert_eq!((model.count(BEGIN), model.commits), (1, 0));
    assert!(model.bytes.is_empty());
}

/// The same image, with the word of another sender: the commit is refused.
#[tokio::test(start_paused = true)]
async fn another_word() {
    let (monitor, model) = start(Model::hooked(|model, kind| {
        if kind == COMMIT
            && let Some((header, _)) = model.target
        {
            model.begin(&header, &[7; DIGEST_LEN]);
        }
        Fate::Fine
    }));
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(error, UpdateError::Refused(20)), "{error}");
    assert!(!model.lock().unwrap().committed);
}

/// A sender that was killed: what is on trial is checked and confirmed, with its word alone.
#[tokio::test(start_paused = true)]
async fn a_trial_at_the_start() {
    let (monitor, model) = start(Model::tried());
    assert_eq!(update(&monitor, new()).await.unwrap(), Updated { from: NEW, to: NEW });
    {
        let model = model.lock().unwrap();
        assert_eq!((model.trial, model.slot, model.count(BEGIN)), (false, 2, 0));
    }
    let (monitor, model) = start(Model::tried());
    let error = monitor.update(&[new()], &[1; 16], Pace::FULL, |_| {}).await.unwrap_err();
    assert!(matches!(error, UpdateError::Refused(20)), "{error}");
    assert!(model.lock().unwrap().trial);
    // What is on trial is another image.
    let (monitor, model) = start(Model::tried());
    let other = image([3, 0, 0, 0], 0, 800);
    let error = update(&monitor, other).await.unwrap_err();
    assert!(matches!(error, UpdateError::Refused(18)), "{error}");
    assert_eq!(model.lock().unwrap().confirms, 0);
}

/// A sender that was killed behind its commit: the restart is awaited, and nothing is committed again.
#[tokio::test(start_paused = true)]
async fn a_commit_at_the_start() {
    for crashes in [false, true] {
        let mut before = Model { crashes, ..Model::new() };
        before.begin(new().header(), &digest_of(&WORD));
        before.bytes = new().payload().to_vec();
        (before.phase, before.word, before.committed) = (Phase::COMMITTED, digest_of(&WORD), true);
        before.restart_at = Some(Instant::now() + 10 * STEP);
        let (monitor, model) = start(before);
        let updated = update(&monitor, new()).await;
        match updated {
            Ok(updated) => assert_eq!((crashes, updated), (false, Updated { from: OLD, to: NEW })),
            Err(error) => {
                assert!(crashes && matches!(error, UpdateError::WentBack { .. }), "{error}");
            }
        }
        let model = model.lock().unwrap();
        assert_eq!((model.count(BEGIN), model.count(COMMIT)), (0, 0));
        assert_eq!(model.slot, if crashes { 1 } else { 2 });
    }
}

/// Nothing is changed where the version runs already, or no image is for the slot that may be written.
#[tokio::test(start_paused = true)]
async fn nothing_to_do() {
    let (monitor, model) = start(Model::new());
    for slot in 0..=2 {
        let error = update(&monitor, image(OLD, slot, 80)).await.unwrap_err();
        assert!(matches!(error, UpdateError::AlreadyRunning(OLD)), "{error}");
    }
    let error = update(&monitor, image(NEW, 1, 80)).await.unwrap_err();
    assert!(matches!(error, UpdateError::NoImage { slot: 2 }), "{error}");
    let model = model.lock().unwrap();
    assert!(model.orders.iter().all(|kind| *kind == STATE), "{:?}", model.orders);
}

/// Which condition is not met is found out from the status.
#[tokio::test(start_paused = true)]
async fn not_ready() {
    let locked = GeneralFlags::LOCKED_OUT;
    let cases = [
        (Model { flags: GeneralFlags::empty(), ..Model::new() }, Unready::NotLockedOut),
        (Model { flags: locked | GeneralFlags::BAD_POWER, ..Model::new() }, Unready::BadSupply),
        (
            Model { valve: ValveFlags::OPENING, ..Model::new() },
            Unready::ValveOpen(SubsystemId::VALVE1),
        ),
        (Model { drive: DriveFlags::MOVE, ..Model::new() }, Unready::Moves(SubsystemId::VERTICAL)),
    ];
    for (model, wanted) in cases {
        let (monitor, model) = start(model);
        let error = update(&monitor, new()).await.unwrap_err();
        let UpdateError::NotReady(why) = &error else { panic!("{error}") };
        assert_eq!(*why, [wanted], "{error}");
        assert_eq!(model.lock().unwrap().phase, Phase::IDLE);
    }
    // It ends amid the data.
    let (monitor, _) = start(Model::hooked(|model, kind| {
        if kind == DATA && model.count(DATA) == 4 {
            model.flags = GeneralFlags::empty();
        }
        Fate::Fine
    }));
    let error = update(&monitor, new()).await.unwrap_err();
    let UpdateError::NotReady(why) = &error else { panic!("{error}") };
    assert_eq!(*why, [Unready::NotLockedOut]);
}

/// What the monitor refuses for good is not tried again; a flash that fails once is.
#[tokio::test(start_paused = true)]
async fn reasons() {
    for reason in 1..=12 {
        let (monitor, model) = start(Model { refusals: vec![reason], ..Model::new() });
        let error = update(&monitor, new()).await.unwrap_err();
        assert!(matches!(error, UpdateError::Refused(got) if got == reason), "{error}");
        assert_eq!(model.lock().unwrap().count(BEGIN), 1);
    }
    let (monitor, model) = start(Model { refusals: vec![21, 21], ..Model::new() });
    update(&monitor, new()).await.unwrap();
    is_updated(&model.lock().unwrap(), &new());
    let (monitor, _) = start(Model { refusals: vec![21; 100], ..Model::new() });
    let error = update(&monitor, new()).await.unwrap_err();
    assert!(matches!(error, UpdateError::Refused(21)), "{error}");
}

/// Data that are not those that were signed are sent once more, and not again.
#[tokio::test(start_paused = true)]
async fn data_that_change_on_the_way() {
    for (times, well) in [(1, true), (100, false)] {
        let mut left = times;
        let (monitor, model) = start(Model::hooked(move |model, kind| {
            if kind == VERIFY && left > 0 {
                left -= 1;
                model.bytes[77] ^= 4;
            }
            Fate::Fine
        }));
        match update(&monitor, new()).await {
            Ok(_) => {
                assert!(well);
                is_updated(&model.lock().unwrap(), &new());
            }
            Err(error) => {
                assert!(!well && matches!(error, UpdateError::Refused(16)), "{error}");
                assert_eq!(model.lock().unwrap().count(BEGIN), 2);
            }
        }
    }
}

/// A monitor without the update says so in one exchange.
#[tokio::test(start_paused = true)]
async fn a_monitor_without_it() {
    for status in [Status::WRONG_REQUEST, Status::DENIED] {
        let (monitor, model) = start(Model { without_update: Some(status), ..Model::new() });
        assert!(monitor.software().await.unwrap_err().is_refused());
        let error = update(&monitor, new()).await.unwrap_err();
        assert!(matches!(error, UpdateError::NoUpdate(got) if got == status), "{error}");
        assert_eq!(model.lock().unwrap().orders, [STATE, STATE]);
    }
}

/// A new program that was built without it: neither a monitor without the update nor one that is silent.
#[tokio::test(start_paused = true)]
async fn an_image_without_it() {
    for status in [Status::WRONG_REQUEST, Status::DENIED] {
        let (monitor, model) = start(Model { trial_without_update: Some(status), ..Model::new() });
        let error = update(&monitor, new()).await.unwrap_err();
        assert!(matches!(error, UpdateError::Deaf(got) if got == status), "{error}");
        assert!(!is_over(&Err(error)), "its word is kept");
        assert_eq!(model.lock().unwrap().confirms, 0);
    }
}

/// A Stop of the same program passes an order that is not answered, and the pauses.
#[tokio::test(start_paused = true)]
async fn a_stop_passes() {
    let (monitor, model) = start(Model::hooked(|model, kind| match kind {
        DATA if model.count(DATA) >= 4 => Fate::LoseAnswer,
        _ => Fate::Fine,
    }));
    let sender = monitor.clone();
    let sending =
        tokio::spawn(async move { sender.update(&[new()], &WORD, Pace::SHARED, |_| {}).await });
    while model.lock().unwrap().count(DATA) < 4 {
        sleep(Duration::from_millis(1)).await;
    }
    let asked = Instant::now();
    monitor.stop(SubsystemId::ALL).await.unwrap();
    let passed = model.lock().unwrap().stopped_at.unwrap() - asked;
    assert!(passed <= Duration::from_millis(200), "{passed:?}");
    sending.abort();
}

/// The share of the line's time that the data take.
#[tokio::test(start_paused = true)]
async fn the_pace() {
    let delay = Duration::from_millis(50);
    let parts = 2000_u32.div_ceil(PART_MAX as u32);
    let mut times = Vec::new();
    for percent in [100, 50, 20] {
        let (monitor, _) = start_slow(Model::new(), delay);
        let pace = Pace::new(percent).unwrap();
        let (mut first, mut last) = (None, Instant::now());
        let told = |stage| {
            if let Stage::Sending { done, .. } = stage {
                first = first.or((done == 0).then(Instant::now));
                last = Instant::now();
            }
        };
        monitor.update(&[new()], &WORD, pace, told).await.unwrap();
        times.push(last - first.unwrap());
    }
    // The last part is reported before its pause.
    let wanted = |share: u32| delay * (share * (parts - 1) + 1);
    let slack = Duration::from_millis(300);
    for (time, share) in times.iter().zip([1, 2, 5]) {
        assert!(*time >= wanted(share) && *time <= wanted(share) + slack, "{times:?}");
    }
    assert_eq!((Pace::new(0), Pace::new(101)), (None, None));
}
