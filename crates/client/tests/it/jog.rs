//! Jog, the dead-man: whatever happens to caller, line and answers, the drive stops soon.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::fake::plant::{Fate, Plant, SOON, Shared, plant, serve};
use lafet_client::session::Now;
use lafet_client::session::jog::JogCore;
use lafet_client::{
    Cause, Client, Config, Error, Hold, JogEnd, LinkEvent, Monitor, Reason, Toward,
};
use lafet_proto::{RequestId, SubsystemId};
use tokio::time::{Instant, advance, sleep_until};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;
const HORIZONTAL: SubsystemId = SubsystemId::HORIZONTAL;
const MS: Duration = Duration::from_millis(1);
const LEASE: Duration = Duration::from_millis(300);

fn start(plant: &Shared) -> Monitor {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(serve(theirs, plant.clone()));
    Monitor::new(Client::over("sim:", ours, Config::default()))
}

/// Waits on virtual time.
async fn pass(time: Duration) {
    sleep_until(Instant::now() + time).await;
}

fn look<T>(plant: &Shared, look: impl FnOnce(&mut Plant) -> T) -> T {
    look(&mut plant.lock().unwrap())
}

fn reason(end: &JogEnd) -> Option<Reason> {
    match end {
        JogEnd::Stopped { reason, .. } => Some(*reason),
        _ => None,
    }
}

#[tokio::test(start_paused = true)]
async fn it_moves_as_long_as_it_is_renewed_and_stops_when_let_go() {
    let plant = plant();
    let monitor = start(&plant);
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    for _ in 0..30 {
        pass(100 * MS).await;
        assert!(jog.renew() && look(&plant, |plant| plant.is_moving(VERTICAL)));
    }
    // Renewed, and set in motion once.
    assert!(look(&plant, |plant| plant.count(RequestId::SET_PARAM)) >= 20);
    assert_eq!(look(&plant, |plant| plant.count(RequestId::MOVE)), 1);
    let let_go = Instant::now();
    let end = jog.release().await;
    assert_eq!(reason(&end), Some(Reason::Released), "{end:?}");
    assert!(end.stands());
    let stopped = look(&plant, |plant| plant.stopped_at.unwrap());
    assert!(stopped <= let_go + 10 * MS, "{:?}", stopped - let_go);
    assert!(look(&plant, |plant| plant.position(VERTICAL)) > 800);
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
}

#[tokio::test(start_paused = true)]
async fn it_stops_when_nobody_renews_it_and_when_it_is_dropped() {
    let plant = plant();
    let monitor = start(&plant);
    let began = Instant::now();
    let mut jog = monitor.vertical().jog(Toward::DOWN).unwrap();
    assert_eq!(reason(&jog.ended().await), Some(Reason::Lapsed));
    let stopped = look(&plant, |plant| plant.stopped_at.unwrap());
    assert!(stopped - began >= LEASE && stopped - began < LEASE + 20 * MS);
    assert!(!jog.renew() && !jog.is_held(), "what has lapsed stays so");

    drop(monitor.vertical().jog(Toward::DOWN).unwrap());
    let jog = monitor.vertical().jog(Toward::DOWN).unwrap();
    pass(50 * MS).await;
    assert!(look(&plant, |plant| plant.is_moving(VERTICAL)));
    // Nothing else is left of the client either.
    drop((jog, monitor));
    pass(20 * MS).await;
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
}

/// Renewals that come too late do not count, whatever the program was busy with.
#[tokio::test(start_paused = true)]
async fn a_program_that_stands_still_renews_too_late() {
    let plant = plant();
    let monitor = start(&plant);
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(100 * MS).await;
    assert!(jog.renew());
    advance(Duration::from_secs(2)).await;
    assert!(!jog.renew());
    let end = jog.release().await;
    assert_eq!(reason(&end), Some(Reason::Lapsed), "{end:?}");

    // It is at rest before the first Move has gone out: that is not sent any more.
    let moves = look(&plant, |plant| plant.count(RequestId::MOVE));
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    advance(Duration::from_secs(2)).await;
    let end = jog.release().await;
    assert_eq!(reason(&end), Some(Reason::Lapsed), "{end:?}");
    assert_eq!(look(&plant, |plant| plant.count(RequestId::MOVE)), moves);
}

/// Each of the first Stops is lost, or its answer, or the answer is late.
#[tokio::test(start_paused = true)]
async fn lost_stops_are_sent_again_at_once() {
    for (fate, bound) in [
        (Fate::LoseRequest, 2100 * MS),
        (Fate::LoseAnswer, 20 * MS),
        (Fate::After(400 * MS), 20 * MS),
    ] {
        let plant = plant();
        let monitor = start(&plant);
        let jog = monitor.vertical().jog(Toward::UP).unwrap();
        pass(250 * MS).await;
        let mut spoiled = 4;
        look(&plant, |plant| {
            plant.fate = Box::new(move |request| match request {
                RequestId::STOP if spoiled > 0 => {
                    spoiled -= 1;
                    fate
                }
                _ => SOON,
            });
        });
        let let_go = Instant::now();
        let end = jog.release().await;
        assert_eq!(reason(&end), Some(Reason::Released), "{fate:?}: {end:?}");
        let stopped = look(&plant, |plant| plant.stopped_at.unwrap());
        assert!(stopped - let_go < bound, "{fate:?}: {:?}", stopped - let_go);
        assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
    }
}

/// A quarter of all frames and answers lost, a quarter late: it stops, and stays so.
#[tokio::test(start_paused = true)]
async fn a_bad_line_delays_the_end_but_does_not_prevent_it() {
    let mut late = 0;
    for seed in 0..60u64 {
        let plant = plant();
        let monitor = start(&plant);
        let mut state = seed;
        look(&plant, |plant| {
            plant.fate = Box::new(move |_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                match (state >> 33) % 8 {
                    0 => Fate::LoseRequest,
                    1 => Fate::LoseAnswer,
                    2 | 3 => Fate::After(Duration::from_millis((state >> 40) % 900)),
                    _ => SOON,
                }
            });
        });
        let jog = monitor.vertical().jog(Toward::UP).unwrap();
        for _ in 0..seed % 10 {
            pass(100 * MS).await;
            jog.renew();
        }
        let end = jog.release().await;
        assert!(end.stands(), "{seed}: {end:?}");
        pass(Duration::from_secs(3)).await;
        assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)), "seed {seed}");
        late += monitor.client().stats().late;
    }
    assert!(late > 5, "{late}");
}

/// Assumed: no Stop arrives, and meanwhile others send the drive somewhere.
#[tokio::test(start_paused = true)]
async fn what_others_have_begun_is_not_stopped_for_a_motion_that_has_ended() {
    for denied in [false, true] {
        let plant = plant();
        let monitor = start(&plant);
        let jog = monitor.vertical().jog(Toward::UP).unwrap();
        pass(250 * MS).await;
        look(&plant, |plant| {
            plant.denies_move = denied.then_some(SubsystemId::CONTROL);
            plant.fate = Box::new(|request| match request {
                RequestId::STOP => Fate::LoseRequest,
                _ => SOON,
            });
        });
        let released = tokio::spawn(jog.release());
        pass(500 * MS).await;
        let moved = monitor.vertical().move_to(-1000).await;
        assert_eq!(moved.is_err(), denied, "{moved:?}");
        look(&plant, |plant| plant.fate = Box::new(|_| SOON));
        let end = released.await.unwrap();
        pass(Duration::from_secs(20)).await;
        let stops = look(&plant, |plant| plant.count(RequestId::STOP));
        if denied {
            assert!(end.stands() && stops > 0, "nothing has replaced it: {end:?}");
        } else {
            assert!(matches!(end, JogEnd::Replaced), "{end:?}");
            assert_eq!((stops, look(&plant, |plant| plant.position(VERTICAL))), (0, -1000));
        }
    }
}

/// The hand is off the control after the drive was sent somewhere, by whomever: it stops.
#[tokio::test(start_paused = true)]
async fn what_was_begun_before_the_release_is_stopped_with_it() {
    let plant = plant();
    let monitor = start(&plant);
    for answered in [true, false] {
        let jog = monitor.vertical().jog(Toward::UP).unwrap();
        pass(100 * MS).await;
        look(&plant, |plant| {
            plant.fate = Box::new(move |request| match request {
                RequestId::MOVE if !answered => Fate::After(50 * MS),
                _ => SOON,
            });
        });
        let own = monitor.clone();
        let moved = tokio::spawn(async move { own.vertical().move_to(-1000).await });
        pass(if answered { 50 * MS } else { 10 * MS }).await;
        let end = jog.release().await;
        assert!(end.stands(), "{end:?}");
        pass(Duration::from_secs(1)).await;
        assert!(moved.is_finished() && !look(&plant, |plant| plant.is_moving(VERTICAL)));
    }
}

/// The drive goes on, so Stops follow one another; others send it somewhere at any moment between two of them.
#[tokio::test(start_paused = true)]
async fn no_stop_of_a_motion_that_has_ended_comes_behind_what_others_have_begun() {
    let mut accepted = 0;
    for offset in (0..250).step_by(5) {
        let plant = plant();
        let monitor = start(&plant);
        let jog = monitor.vertical().jog(Toward::UP).unwrap();
        pass(250 * MS).await;
        look(&plant, |plant| {
            plant.denies_stop = Some(SubsystemId::GENERAL);
            plant.fate = Box::new(|request| match request {
                RequestId::MOVE => Fate::After(40 * MS),
                RequestId::GET_STATUS => Fate::After(20 * MS),
                _ => SOON,
            });
        });
        let released = tokio::spawn(jog.release());
        pass(offset * MS).await;
        let moved = monitor.vertical().move_to(-1000).await;
        pass(Duration::from_secs(3)).await;
        assert!(released.is_finished(), "{offset}");
        // One that waited behind a Stop is refused by it.
        if moved.is_err() {
            continue;
        }
        accepted += 1;
        let log = look(&plant, |plant| plant.log.clone());
        let begun = log.iter().rposition(|(_, id, _)| *id == RequestId::MOVE).unwrap();
        let stops = log[begun..].iter().filter(|(_, id, _)| *id == RequestId::STOP).count();
        assert_eq!(stops, 0, "{offset}");
    }
    assert!(accepted >= 25, "{accepted} of 50");
}

/// The connection is lost while a motion is held: it ends, and over the next one Stop is sent.
#[tokio::test(start_paused = true)]
async fn after_a_lost_link_stop_is_sent() {
    let plant = plant();
    let server = Arc::new(Mutex::new(None::<tokio::task::JoinHandle<()>>));
    let (to_serve, slot) = (plant.clone(), server.clone());
    let outage = Arc::new(Mutex::new(false));
    let out = outage.clone();
    let dial = move || {
        let (ours, theirs) = lafet_client::transport::memory::pair();
        if !*out.lock().unwrap() {
            *slot.lock().unwrap() = Some(tokio::spawn(serve(theirs, to_serve.clone())));
        }
        let out = *out.lock().unwrap();
        async move { if out { Err(std::io::ErrorKind::ConnectionRefused.into()) } else { Ok(ours) } }
    };
    let client = Client::dial("sim:", dial, Config::default()).await.unwrap();
    let mut events = client.events();
    let jog = Monitor::new(client.clone()).vertical().jog(Toward::UP).unwrap();
    pass(100 * MS).await;
    assert!(jog.renew());
    *outage.lock().unwrap() = true;
    server.lock().unwrap().take().unwrap().abort();
    pass(50 * MS).await;
    assert!(!jog.renew(), "a lost link ends it");
    assert!(look(&plant, |plant| plant.is_moving(VERTICAL)), "it cannot be known yet");
    pass(Duration::from_secs(5)).await;
    *outage.lock().unwrap() = false;
    let mut jog = jog;
    let end = jog.ended().await;
    assert_eq!(reason(&end), Some(Reason::LinkLost), "{end:?}");
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
    assert_eq!(look(&plant, |plant| plant.count(RequestId::MOVE)), 1);
    assert_eq!(client.stats().reconnects, 1);
    let seen: Vec<_> = std::iter::from_fn(|| events.try_recv().ok()).collect();
    assert!(seen.iter().any(|event| matches!(event, LinkEvent::Down(_))));
    assert!(seen.iter().any(|event| matches!(event, LinkEvent::Up)));

    // A stream that cannot be opened again: it says so, at once.
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let monitor = Monitor::new(Client::over("sim:", ours, Config::default()));
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    drop(theirs);
    let end = jog.release().await;
    assert!(matches!(end, JogEnd::Unknown(Error::Link { .. })), "{end:?}");
}

#[tokio::test(start_paused = true)]
async fn two_jogs() {
    let plant = plant();
    let monitor = start(&plant);
    // Of two drives, each for itself.
    let up = monitor.vertical().jog(Toward::UP).unwrap();
    let left = monitor.horizontal().jog(Toward::LEFT).unwrap();
    pass(100 * MS).await;
    assert!(up.renew() && left.renew());
    up.release().await;
    let moving = look(&plant, |plant| (plant.is_moving(VERTICAL), plant.is_moving(HORIZONTAL)));
    assert_eq!(moving, (false, true));
    // Of one drive, the later takes over without a stop in between.
    let stops = look(&plant, |plant| plant.count(RequestId::STOP));
    let right = monitor.horizontal().jog(Toward::RIGHT).unwrap();
    let mut left = left;
    assert!(matches!(left.ended().await, JogEnd::Replaced));
    drop(left);
    pass(100 * MS).await;
    assert!(right.renew() && look(&plant, |plant| plant.is_moving(HORIZONTAL)));
    assert_eq!(look(&plant, |plant| plant.count(RequestId::STOP)), stops);
    assert_eq!(reason(&right.release().await), Some(Reason::Released));
}

#[tokio::test(start_paused = true)]
async fn who_else_stops_it_is_obeyed() {
    // A Stop of this client.
    let plant = plant();
    let monitor = start(&plant);
    let mut jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(100 * MS).await;
    monitor.stop(SubsystemId::ALL).await.unwrap();
    assert!(!jog.renew());
    assert_eq!(reason(&jog.ended().await), Some(Reason::StopAsked));
    // Stop to another drive is no concern of it.
    let mut jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(100 * MS).await;
    monitor.horizontal().stop().await.unwrap();
    assert!(jog.renew());
    // Another client stops it: it is not set in motion again.
    pass(100 * MS).await;
    look(&plant, |plant| plant.stop(VERTICAL));
    let moves = look(&plant, |plant| plant.count(RequestId::MOVE));
    let renewing = async {
        loop {
            pass(100 * MS).await;
            if !jog.renew() {
                return;
            }
        }
    };
    renewing.await;
    assert!(matches!(jog.ended().await, JogEnd::Standing(_)));
    assert_eq!(look(&plant, |plant| plant.count(RequestId::MOVE)), moves);
}

/// §3.1/1, §3.2/2–4
#[tokio::test(start_paused = true)]
async fn refusals() {
    let plant = plant();
    let monitor = start(&plant);
    look(&plant, |plant| plant.denies_move = Some(SubsystemId::DEPLOYER));
    let mut jog = monitor.vertical().jog(Toward::UP).unwrap();
    let end = jog.ended().await;
    assert!(matches!(&end, JogEnd::Refused(Error::Refused { .. })), "{end:?}");
    assert_eq!(look(&plant, |plant| plant.count(RequestId::STOP)), 0);

    // During a program Stop to a drive is denied: it is sent where it is.
    look(&plant, |plant| {
        plant.denies_move = None;
        plant.denies_stop = Some(SubsystemId::CONTROL);
    });
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(200 * MS).await;
    let end = jog.release().await;
    assert_eq!(reason(&end), Some(Reason::Released), "{end:?}");
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));

    // A search has taken the drives.
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(200 * MS).await;
    look(&plant, |plant| plant.denies_stop = Some(SubsystemId::DETECTOR));
    let end = jog.release().await;
    assert!(matches!(end, JogEnd::TakenOver { by: SubsystemId::DETECTOR }), "{end:?}");
    // A monitor that answers and does not stop is reported.
    look(&plant, |plant| plant.denies_stop = Some(SubsystemId::GENERAL));
    let jog = monitor.vertical().jog(Toward::DOWN).unwrap();
    pass(10 * MS).await;
    let end = jog.release().await;
    assert!(matches!(end, JogEnd::StillMoving(_) | JogEnd::Stopped { .. }), "{end:?}");
}

/// A controller has appeared on the line: Stop still goes out, and nothing can be read. The caller
/// learns so in 30 s.
#[test]
fn a_drive_that_cannot_be_read_is_given_up() {
    let mut core = JogCore::new(Now::ZERO, VERTICAL, Toward::UP, Hold::default(), true);
    core.stop(Now::ZERO, Reason::Released);
    let mut now = Now::ZERO;
    let end = loop {
        let refused = Error::NotSent {
            request: RequestId::GET_STATUS,
            to: VERTICAL,
            cause: Cause::ControllerPresent,
        };
        if core.poll_next(now).is_some() {
            core.handle_result(now, vec![Err(refused)]);
        }
        if let Some(end) = core.poll_end() {
            break end;
        }
        now = core.poll_timeout().unwrap().max(now + MS);
        assert!(now < 31_000 * MS, "it goes on without end");
    };
    assert!(matches!(end, JogEnd::Unknown(Error::NotSent { .. })), "{end:?}");
    assert!(now >= 30_000 * MS, "{now:?}");
}

/// The runtime of a motion ends before its handle: a caller that waits for the end gets it.
#[test]
fn a_motion_whose_runtime_is_gone_has_ended() {
    let runtime = || {
        let mut builder = tokio::runtime::Builder::new_current_thread();
        builder.enable_time().build().unwrap()
    };
    for polled in [false, true] {
        let first = runtime();
        let mut jog = first.block_on(async {
            let monitor = start(&plant());
            let jog = monitor.vertical().jog(Toward::UP).unwrap();
            if polled {
                tokio::task::yield_now().await;
            }
            jog
        });
        drop(first);
        let waiting = async { tokio::time::timeout(10_000 * MS, jog.ended()).await };
        let end = runtime().block_on(waiting).expect("it does not wait without end");
        assert!(matches!(end, JogEnd::Unknown(Error::Closed)), "{end:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn the_first_lease_may_be_longer() {
    let plant = plant();
    let monitor = start(&plant);
    let hold = Hold { first_lease: 700 * MS, ..Hold::default() };
    let mut jog = monitor.vertical().jog_with(Toward::UP, hold).unwrap();
    pass(650 * MS).await;
    assert!(jog.renew(), "the keyboard repeats the key");
    let renewed = Instant::now();
    jog.ended().await;
    let stopped = look(&plant, |plant| plant.stopped_at.unwrap());
    assert!(stopped - renewed < LEASE + 20 * MS);
}

/// Times that no clock can add are long ones, with and without MoveHold.
#[tokio::test(start_paused = true)]
async fn the_longest_lease_is_a_long_one() {
    for has_hold in [true, false] {
        let plant = plant();
        look(&plant, |plant| plant.has_hold = has_hold);
        let monitor = start(&plant);
        let most = Duration::MAX;
        let hold = Hold { lease: most, first_lease: most, repeat: most, ..Hold::default() };
        let jog = monitor.vertical().jog_with(Toward::UP, hold).unwrap();
        pass(200 * MS).await;
        // A step ends by itself before the next one is due.
        assert_eq!(look(&plant, |plant| plant.is_moving(VERTICAL)), has_hold);
        assert!(jog.renew() && jog.is_held());
        pass(200 * MS).await;
        assert!(jog.renew());
        let end = jog.release().await;
        assert_eq!(reason(&end), Some(Reason::Released), "{end:?}");
        assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
    }
}

/// Without MoveHold the motion goes on in short steps, and is as far from its end as one of them.
#[tokio::test(start_paused = true)]
async fn a_monitor_without_move_hold_is_moved_in_steps() {
    let plant = plant();
    look(&plant, |plant| plant.has_hold = false);
    let monitor = start(&plant);
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    for _ in 0..40 {
        pass(100 * MS).await;
        assert!(jog.renew());
    }
    let way = look(&plant, |plant| plant.position(VERTICAL));
    assert!(way > 900, "{way}' of 1200' in 4 s");
    // The line is dead from now on: no Stop arrives.
    look(&plant, |plant| plant.fate = Box::new(|_| Fate::LoseRequest));
    pass(500 * MS).await;
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
    drop(jog);
}

/// With limits off a step does not end at its destination (§3.17).
#[tokio::test(start_paused = true)]
async fn what_would_not_end_by_itself_is_not_started() {
    let plant = plant();
    look(&plant, |plant| (plant.has_hold, plant.limitless) = (false, true));
    let monitor = start(&plant);
    let mut jog = monitor.vertical().jog(Toward::UP).unwrap();
    let end = jog.ended().await;
    assert!(matches!(end, JogEnd::Unbounded(_)), "{end:?}");
    assert_eq!(look(&plant, |plant| plant.count(RequestId::MOVE)), 0);
    // With MoveHold it is.
    look(&plant, |plant| plant.has_hold = true);
    let jog = monitor.vertical().jog(Toward::UP).unwrap();
    pass(200 * MS).await;
    assert!(look(&plant, |plant| plant.is_moving(VERTICAL)));
    look(&plant, |plant| plant.fate = Box::new(|_| Fate::LoseRequest));
    pass(500 * MS).await;
    assert!(!look(&plant, |plant| plant.is_moving(VERTICAL)));
    drop(jog);
}
