//! `lafet tune` on a simulated monitor whose drive follows late and does not turn slowly.

use crate::support::{Running, Sim, lafet};

/// The fault `lag` is 300 ms, `dead-band` 1 °/s.
#[test]
fn a_poor_drive_is_measured() {
    let sim = Sim::start(&[
        "--speed",
        "20",
        "--fault",
        "horizontal-lag",
        "--fault",
        "horizontal-dead-band",
    ]);
    let run = sim.run(&["deploy"]);
    assert_eq!(run.code, 0, "{run:?}");
    let run = sim.run(&["--json", "tune", "horizontal"]);
    assert_eq!(run.code, 0, "{run:?}");
    let found = &run.json()[0]["drives"][0];
    let lag = found["found"]["StopLag"].as_i64().unwrap();
    let least = found["found"]["MinSpeed"].as_i64().unwrap();
    assert!((240..=360).contains(&lag), "{run:?}");
    assert!((10..=16).contains(&least), "{run:?}");
    let errors = found["errors"].as_array().unwrap();
    assert!(
        errors.len() == 4 && errors.iter().all(|error| error.as_i64().unwrap() <= 2),
        "{run:?}"
    );
    let run = sim.run(&["--json", "param", "get", "horizontal", "StopLag"]);
    assert_eq!(run.json()[0]["values"][0].as_i64(), Some(lag), "{run:?}");
}

#[test]
fn nothing_moves_with_an_open_valve_and_a_dry_run_changes_nothing() {
    let sim = Sim::start(&["--speed", "20"]);
    assert_eq!(sim.run(&["deploy"]).code, 0);
    let run = sim.run(&["tune", "vertical", "--dry-run"]);
    assert!(run.code == 0 && run.out.contains("Nothing was written"), "{run:?}");
    assert_eq!(sim.run(&["open"]).code, 0);
    let run = sim.run(&["tune", "vertical"]);
    assert!(run.code != 0 && run.err.contains("Valve1 is not closed"), "{run:?}");
    let run = sim.run(&["tune", "deployer"]);
    assert!(run.code == 2 && run.err.contains("nothing to tune"), "{run:?}");
}

/// Killed while it measures, it leaves values of its own in the monitor; the next start puts those before back.
#[test]
fn what_kill_9_leaves_is_put_back() {
    let sim = Sim::start(&["--speed", "20"]);
    assert_eq!(sim.run(&["deploy"]).code, 0);
    let of = |name| {
        let run = sim.run(&["--json", "param", "get", "horizontal", name]);
        run.json()[0]["values"][0].as_i64().unwrap()
    };
    for (name, value) in [("StopLag", "321"), ("MinSpeed", "9")] {
        sim.done(&["param", "set", "horizontal", name, value]);
    }
    let mut command = lafet();
    command.args(["-c", sim.url(), "tune", "horizontal"]);
    let mut tuning = Running::stdout(&mut command);
    for _ in 0..400 {
        if of("StopLag") == 0 && of("MinSpeed") == 0 {
            break;
        }
    }
    tuning.signal("KILL");
    assert_eq!(tuning.code(), None, "it was ended by a signal");
    assert_eq!(of("StopLag"), 0, "killed in the middle");
    let run = sim.run(&["tune", "horizontal", "--dry-run"]);
    assert_eq!(run.code, 0, "{run:?}");
    for words in ["StopLag 0 → 321", "MinSpeed 0 → 9"] {
        assert!(run.err.contains(words), "{run:?}");
    }
    assert_eq!((of("StopLag"), of("MinSpeed")), (321, 9));
    let run = sim.run(&["tune", "horizontal", "--dry-run"]);
    assert!(run.code == 0 && !run.err.contains("→ 321"), "it is said once: {run:?}");
}

/// Ctrl-C between two motions keeps the next one from starting.
#[cfg(unix)]
#[test]
fn a_signal_between_two_motions_is_not_lost() {
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};
    use std::sync::mpsc::channel;

    use lafet_proto::RequestId;
    use lafet_proto::link::Decoder;
    use lafet_proto::record::Records;

    let sim = Sim::start(&["--speed", "20"]);
    sim.done(&["deploy"]);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}?addr=1", listener.local_addr().unwrap());
    let (held, holds) = channel();
    let (go, may) = channel::<()>();
    let place = sim.place().to_owned();
    std::thread::spawn(move || {
        let (mut near, _) = listener.accept().unwrap();
        let mut far = TcpStream::connect(place).unwrap();
        let (mut back, mut there) = (far.try_clone().unwrap(), near.try_clone().unwrap());
        std::thread::spawn(move || std::io::copy(&mut back, &mut there));
        let mut decoder: Decoder = Decoder::new();
        let (mut buffer, mut sets) = ([0; 1024], 0);
        while let Ok(len @ 1..) = near.read(&mut buffer) {
            for byte in &buffer[..len] {
                let Some(frame) = decoder.push(*byte) else { continue };
                let mut records = Records::new(frame.payload).flatten();
                let writes = records.any(|record| record.request == RequestId::SET_PARAM);
                sets += u32::from(writes);
                // The first two are set before anything moves.
                if writes && sets == 3 {
                    held.send(()).unwrap();
                    may.recv().unwrap();
                }
            }
            if far.write_all(&buffer[..len]).is_err() {
                return;
            }
        }
    });
    let mut command = lafet();
    command.args(["-c", &url, "--lang", "en", "--timeout", "30", "tune", "horizontal"]);
    let mut tuning = Running::stderr(&mut command);
    holds.recv().unwrap();
    tuning.signal("INT");
    go.send(()).unwrap();
    assert_eq!(tuning.code(), Some(130));
}
