//! Many requests over a slow, lossy line, seen through: on virtual time.

use std::sync::{Arc, LazyLock, Mutex};
use std::time::Duration;

use crate::fake::slow_line::{SlowLine, Traffic, read_all, reads};
use lafet_client::{Client, Config, Error};
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Ints, Request, Status, SubsystemId};
use tokio::time::Instant;

const ALL: usize = 200;

fn start(line: SlowLine) -> (Client, Arc<Mutex<Traffic>>) {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let traffic = Arc::new(Mutex::new(Traffic::default()));
    tokio::spawn(line.serve(theirs, traffic.clone()));
    (Client::over("sim:", ours, Config::default()), traffic)
}

/// 200 parameters over 19200 baud; one frame in twenty is lost, each way.
#[tokio::test(start_paused = true)]
async fn two_hundred_parameters_over_a_bad_line() {
    for seed in 0..20 {
        let line = SlowLine { seed, ..SlowLine::new(19_200, 50) };
        let reading = read_all(line.clone(), ALL, true).await;
        assert_eq!(reading.right, ALL, "seed {seed}");
        // Progress goes from nothing to all, and never back.
        let done: Vec<usize> = reading.told.iter().map(|progress| progress.done).collect();
        assert!(done.is_sorted() && done[0] == 0 && done.last() == Some(&ALL), "{done:?}");
        assert!(done.len() > 4, "{done:?}");
    }
}

/// However bad a line is, a batch goes on while anything is answered.
#[tokio::test(start_paused = true)]
async fn a_noisy_line_does_not_end_it() {
    for loss_permille in [100, 200] {
        let mut took = Duration::ZERO;
        for seed in 0..300 {
            let line = SlowLine { seed: seed * 7919, ..SlowLine::new(19_200, loss_permille) };
            let reading = read_all(line, ALL, true).await;
            assert_eq!(reading.right, ALL, "{loss_permille} ‰, seed {seed}");
            took += reading.took;
        }
        println!("{loss_permille} ‰ lost: {ALL} reads in {:?}", took / 300);
    }
}

/// Where only short frames pass, the length of those that do not is remembered.
#[tokio::test(start_paused = true)]
async fn long_frames_that_never_pass_are_not_tried_each_time() {
    let line = SlowLine { records_max: 8, ..SlowLine::new(19_200, 0) };
    let reading = read_all(line, ALL, true).await;
    assert_eq!(reading.right, ALL);
    let silent = reading.told.last().unwrap().again;
    println!("{:?}, {} frames, {silent} asked again", reading.took, reading.traffic.frames);
    assert!(reading.took < Duration::from_secs(45), "{:?}", reading.took);
}

/// A request that is never answered costs its own result only; a second one ends the batch.
#[tokio::test(start_paused = true)]
async fn a_request_without_answer_does_not_end_it() {
    static MUTE: LazyLock<[(SubsystemId, u16); 2]> = LazyLock::new(|| {
        [20, 40].map(|index| match reads(ALL)[index] {
            Request { to, body: Body::GetParam { id }, .. } => (to, id.0),
            _ => unreachable!(),
        })
    });
    for count in [1, 2] {
        let (client, _) = start(SlowLine { mute: &MUTE[..count], ..SlowLine::new(19_200, 0) });
        let requests = reads(50);
        let results = client.complete(&requests, |_| {}).await;
        let silent: Vec<_> = (0..50)
            .filter(|index| matches!(results[*index], Err(Error::NoAnswer { .. })))
            .collect();
        let unasked = results.iter().filter(|r| matches!(r, Err(Error::NotSent { .. }))).count();
        assert_eq!((&silent[..], unasked), (&[20, 40][..count], if count == 2 { 9 } else { 0 }));
    }
    // The monitor falls silent after an answer: the next request shows it.
    let (client, traffic) = start(SlowLine::new(19_200, 0));
    let requests = reads(100);
    let complete = client.complete(&requests, |progress| {
        if progress.frames == 1 {
            traffic.lock().unwrap().off = true;
        }
    });
    let start_of = Instant::now();
    let results = complete.await;
    let silent = results.iter().filter(|r| matches!(r, Err(Error::NoAnswer { .. }))).count();
    assert_eq!(silent, 2);
    assert!(start_of.elapsed() < Duration::from_secs(19), "{:?}", start_of.elapsed());
}

#[tokio::test(start_paused = true)]
async fn several_in_a_frame_are_quicker_than_one() {
    for loss_permille in [0, 50] {
        let line = SlowLine::new(19_200, loss_permille);
        let several = read_all(line.clone(), ALL, true).await;
        let one = read_all(line, ALL, false).await;
        assert_eq!(several.right, ALL);
        assert!(several.traffic.frames * 8 < one.traffic.frames, "{:?}", several.traffic);
        assert!(several.took * 2 < one.took, "{:?} {:?}", several.took, one.took);
        // Without loss the wire is busy nearly all the time.
        let wire = Duration::from_micros(several.traffic.bytes as u64 * 10_000_000 / 19_200);
        assert!(loss_permille > 0 || several.took < wire * 5 / 4, "{:?} {wire:?}", several.took);
    }
}

/// §2 Busy, NotCached: asked again item by item, while the others go on.
#[tokio::test(start_paused = true)]
async fn what_is_not_ready_is_asked_again() {
    let line = SlowLine { remote_every: 3, busy_every: 7, ..SlowLine::new(19_200, 50) };
    let reading = read_all(line, ALL, true).await;
    assert_eq!(reading.right, ALL);
    let last = reading.told.last().unwrap();
    assert!(last.again > 20 && last.frames < 60, "{last:?}");
}

/// §3.5 Cached: the same SetParam again, until the unit has taken it.
#[tokio::test(start_paused = true)]
async fn what_a_remote_unit_has_not_taken_is_set_again() {
    let line = SlowLine { remote_every: 1, ..SlowLine::new(19_200, 0) };
    let (client, traffic) = start(line.clone());
    let spec = Param::GeneralMoveTimeout.spec();
    let values = Ints::Values(&[500]);
    let set = Request::new(spec.subsystem, Body::SetParam { id: spec.id, values });
    let plain = client.request(&set).await.unwrap();
    assert_eq!(plain.first().status(), Status::CACHED, "plainly asked, plainly answered");
    let results = client.complete(std::slice::from_ref(&set), |_| {}).await;
    assert_eq!(results[0].as_ref().unwrap().first().status(), Status::ACCEPTED);
    assert_eq!(traffic.lock().unwrap().frames, 3);

    // A unit that is lost: the last answer shows it.
    let config = Config { resume: Duration::ZERO, ..Config::default() };
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(line.serve(theirs, Arc::default()));
    let client = Client::over("sim:", ours, config);
    let results = client.complete(&[set], |_| {}).await;
    assert_eq!(results[0].as_ref().unwrap().first().status(), Status::CACHED);
}

/// No monitor there: it ends, and says which was asked in vain and which was not asked at all.
#[tokio::test(start_paused = true)]
async fn silence_ends_it() {
    let (client, traffic) = start(SlowLine::new(19_200, 1000));
    let start_of = Instant::now();
    let results = client.complete(&reads(ALL), |_| {}).await;
    let asked = results.iter().filter(|r| matches!(r, Err(Error::NoAnswer { .. }))).count();
    let unasked = results.iter().filter(|r| matches!(r, Err(Error::NotSent { .. }))).count();
    assert_eq!((asked, unasked), (1, ALL - 1));
    assert_eq!(traffic.lock().unwrap().frames, 15, "the first frame, one request four times");
    assert_eq!(start_of.elapsed(), Duration::from_secs(15));
    // One request has twice the tries that it would have without a batch.
    let start_of = Instant::now();
    let results = client.complete(&reads(1), |_| {}).await;
    assert!(matches!(results[0], Err(Error::NoAnswer { .. })));
    assert_eq!(start_of.elapsed(), Duration::from_secs(6));
    // Of what changes something, nothing is asked twice, and nothing after it.
    let (client, traffic) = start(SlowLine::new(19_200, 1000));
    let moving = Request::new(SubsystemId::VERTICAL, Body::Move { destination: 1 });
    let results = client.complete(&[moving, moving, reads(1)[0]], |_| {}).await;
    assert!(matches!(results[0], Err(Error::OutcomeUnknown { .. })));
    assert!(matches!(results[2], Err(Error::NotSent { .. })));
    assert_eq!(traffic.lock().unwrap().frames, 1);
}
