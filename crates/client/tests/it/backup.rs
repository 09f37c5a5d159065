//! A restore over a connection that breaks again and again, to the simulated monitor.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use lafet_client::backup::{Restored, Step};
use lafet_client::transport::memory::pair;
use lafet_client::{Client, Config, Monitor};
use lafet_device::Source;
use lafet_device::port::Port;
use lafet_proto::param::Param;
use lafet_sim::sim::{self, Sim};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Duration, Instant, interval};

type Shared = Arc<Mutex<Sim>>;

/// Serves the monitor until it has answered `answers` times.
async fn serve(mut stream: DuplexStream, sim: Shared, answers: usize) {
    let mut port = Port::new(Source::ExternalConn);
    let mut buffer = [0; 512];
    for _ in 0..answers {
        let Ok(len @ 1..) = stream.read(&mut buffer).await else { return };
        let answer = sim.lock().unwrap().receive(&mut port, &buffer[..len]);
        if stream.write_all(&answer).await.is_err() {
            return;
        }
    }
}

/// A monitor whose time passes.
fn running() -> Shared {
    let sim: Shared = Arc::new(Mutex::new(Sim::new(sim::Config::default())));
    let clock = sim.clone();
    tokio::spawn(async move {
        let mut tick = interval(Duration::from_millis(10));
        loop {
            tick.tick().await;
            clock.lock().unwrap().advance_ms(10);
        }
    });
    sim
}

async fn monitor(answers: usize) -> (Monitor, Arc<Mutex<u32>>) {
    let sim = running();
    let dials = Arc::new(Mutex::new(0));
    let counted = dials.clone();
    let dial = move || {
        *counted.lock().unwrap() += 1;
        let (ours, theirs) = pair();
        tokio::spawn(serve(theirs, sim.clone(), answers));
        async move { Ok::<_, io::Error>(ours) }
    };
    (Monitor::new(Client::dial("test", dial, Config::default()).await.unwrap()), dials)
}

#[tokio::test(start_paused = true)]
async fn a_broken_connection_loses_nothing() {
    let (monitor, dials) = monitor(7).await;
    let backup = monitor.backup(|_| {}).await.unwrap();
    let mut wanted = backup.values.clone();
    let changed = [
        Param::VerticalSpeed,
        Param::HorizontalSpeed,
        Param::NozzleSpeed,
        Param::DetectorThreshold,
    ];
    for (param, values) in &mut wanted {
        if changed.contains(param) {
            values[0] += 1;
        }
    }
    let mut steps = Vec::new();
    let restored = loop {
        // What is lost while the plan is made is no harm: the caller asks again.
        if let Ok(restored) = monitor.restore(&wanted, &[], |step| steps.push(step)).await {
            break restored;
        }
    };
    assert!(restored.iter().all(Restored::is_done), "{restored:?}");
    assert!(*dials.lock().unwrap() > 1, "it broke");
    let begun = |param: Param| steps.contains(&Step::Begun(param));
    assert!(changed.into_iter().all(begun) && !begun(Param::GeneralAddress), "{steps:?}");
    let now = monitor.backup(|_| {}).await.unwrap();
    assert_eq!(now.values, wanted);
    assert_eq!(backup.differences(&now).len(), changed.len());
}

/// A line that is cut ends a restore at once: it does not wait for each parameter that is left.
#[tokio::test(start_paused = true)]
async fn a_dead_line_ends_a_restore() {
    let (sim, cut) = (running(), Arc::new(AtomicBool::new(false)));
    let (ours, mut theirs) = pair();
    let is_cut = cut.clone();
    tokio::spawn(async move {
        let mut port = Port::new(Source::ExternalConn);
        let mut buffer = [0; 512];
        while let Ok(len @ 1..) = theirs.read(&mut buffer).await {
            if is_cut.load(Ordering::SeqCst) {
                continue;
            }
            let answer = sim.lock().unwrap().receive(&mut port, &buffer[..len]);
            if theirs.write_all(&answer).await.is_err() {
                return;
            }
        }
    });
    let monitor = Monitor::new(Client::over("test", ours, Config::default()));
    let mut wanted = monitor.backup(|_| {}).await.unwrap().values;
    wanted.retain(|(param, _)| param.name() == "Speed");
    wanted.iter_mut().for_each(|(_, values)| values[0] += 1);
    let (mut steps, began) = (Vec::new(), Instant::now());
    let restored = monitor.restore(&wanted, &[], |step| {
        cut.fetch_or(matches!(step, Step::Plan(_)), Ordering::SeqCst);
        steps.push(step);
    });
    let error = restored.await.unwrap_err();
    assert!(error.is_no_answer(), "{error}");
    let begun = steps.iter().filter(|step| matches!(step, Step::Begun(_))).count();
    assert!(wanted.len() > 1 && begun == 1, "{steps:?}");
    assert!(began.elapsed() < Duration::from_secs(120), "{:?}", began.elapsed());
}
