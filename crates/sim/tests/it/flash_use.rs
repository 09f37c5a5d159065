//! What the flash costs the monitor: time in which the program is stopped, and erases.
//!
//! Figures for docs/storage.md: `cargo test -p lafet-sim --test it flash_use:: -- --nocapture`.

use lafet_device::Source;
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_proto::{Bytes, Ints, Request, SubsystemId};
use lafet_sim::flash::{ERASE_US, PAGES};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

fn send(sim: &mut Sim, to: SubsystemId, body: Body<'_>) {
    let mut buffer = [0; 260];
    let mut writer = Writer::new(&mut buffer);
    Request::new(to, body).encode(&mut writer).unwrap();
    assert!(!sim.request(Source::ExternalConn, writer.written()).is_empty());
}

fn set(sim: &mut Sim, param: Param, values: &[i32]) {
    let spec = param.spec();
    send(sim, spec.subsystem, Body::SetParam { id: spec.id, values: Ints::Values(values) });
}

fn lockout(sim: &mut Sim, on: bool) {
    let key = if on { key::ENABLE } else { key::DISABLE };
    send(sim, SubsystemId::ALL, Body::Lockout { key });
}

fn turns(sim: &Sim) -> bool {
    sim.device().outputs().drives.iter().any(|drive| drive.speed_tenths != 0)
}

/// Stop All and Lockout among requests that have to be stored, at any moment, also while the flash
/// is busy: no drive turns longer than one step of 10 ms after the last byte.
#[test]
fn a_stop_never_waits_for_the_flash() {
    let mut rng = Rng::new(5);
    let (mut moving, mut busy, mut longest_ms, mut stalls) = (0, 0, 0, 0);
    let mut deployed = Sim::new(Config::default());
    deployed.advance_ms(500);
    send(&mut deployed, SubsystemId::DEPLOYER, Body::Deploy);
    deployed.advance_ms(20_000);
    assert!(deployed.world().deployed());
    for case in 0..4_000 {
        let mut sim = deployed.clone();
        for _ in 0..1 + rng.bits() % 12 {
            let value = 1 + (rng.bits() % 200) as i32;
            match rng.bits() % 6 {
                0 => set(&mut sim, Param::ControlTrajectory3, &[value; 60]),
                1 => {
                    let bytes = [value as u8; 128];
                    let body = Body::SetupCorrectionTable { first: 0, corrections: Bytes(&bytes) };
                    send(&mut sim, SubsystemId::CONTROL, body);
                }
                2 => set(&mut sim, Param::HorizontalMaxCurrent, &[50 + value]),
                3 => {
                    let destination = if value % 2 == 0 { 9000 } else { -9000 };
                    send(&mut sim, SubsystemId::HORIZONTAL, Body::Move { destination });
                }
                4 => send(&mut sim, SubsystemId::ALL, Body::Stop),
                _ => {}
            }
            for _ in 0..rng.bits() % 6 {
                sim.tick();
                stalls += u32::from(sim.world().is_stalled());
            }
        }
        let asked_ms = sim.now_ms();
        moving += u32::from(turns(&sim));
        busy += u32::from(sim.world().stays_stalled());
        if case % 2 == 0 {
            send(&mut sim, SubsystemId::ALL, Body::Stop);
        } else {
            lockout(&mut sim, true);
        }
        let mut off_ms = asked_ms;
        while turns(&sim) {
            sim.tick();
            off_ms = sim.now_ms();
        }
        longest_ms = longest_ms.max(off_ms - asked_ms);
        for _ in 0..10 {
            sim.tick();
            assert!(!turns(&sim), "case {case}");
        }
    }
    println!(
        "{moving} of 4,000 while moving, {busy} while the flash was busy ({stalls} steps lost): \
         off after {longest_ms} ms at most"
    );
    assert!(moving > 500 && busy > 20, "{moving} {busy}");
    assert!(longest_ms <= 10, "{longest_ms} ms");
}

/// A year: locked out and released for work at the barrel every second day, a drill with a power
/// cycle each week, five numbers and a program changed each month, the correction table each
/// quarter, limits and zero points set again once.
#[test]
fn a_year_of_ordinary_operation() {
    let mut sim = Sim::new(Config::default());
    sim.advance_ms(500);
    let rest = |sim: &mut Sim| sim.advance_ms(300);
    let chip = sim.world().flash.chip();
    let (erases, steps) = (chip.erases().to_vec(), chip.steps());
    let mut longest_us = 0;
    for day in 0..365 {
        if day % 2 == 0 {
            for on in [true, false] {
                lockout(&mut sim, on);
                sim.tick();
                longest_us = longest_us.max(sim.world().flash.chip().busy_us());
                rest(&mut sim);
            }
        }
        if day % 7 == 0 {
            sim.power_cycle();
            rest(&mut sim);
        }
        if day % 30 == 0 {
            for (index, param) in [
                Param::VerticalSpeed,
                Param::ClimaticsHeatOn,
                Param::DetectorThreshold,
                Param::ControlHeight,
                Param::RadioTimeout,
            ]
            .into_iter()
            .enumerate()
            {
                let base = if index == 4 { 2000 } else { 20 };
                set(&mut sim, param, &[base + day / 30]);
                rest(&mut sim);
            }
            set(&mut sim, Param::ControlProgram0, &[day / 30; 7]);
            rest(&mut sim);
        }
        if day % 91 == 0 {
            for first in [0, 128] {
                let bytes = [day as u8 / 4; 128];
                let body = Body::SetupCorrectionTable { first, corrections: Bytes(&bytes) };
                send(&mut sim, SubsystemId::CONTROL, body);
                rest(&mut sim);
            }
        }
        if day == 100 {
            for param in [Param::VerticalMinLimit, Param::HorizontalMaxLimit] {
                set(&mut sim, param, &[-100]);
                rest(&mut sim);
            }
        }
    }
    let chip = sim.world().flash.chip();
    let erased: Vec<u32> = chip.erases().iter().zip(erases).map(|(now, was)| now - was).collect();
    let most = *erased.iter().max().unwrap();
    let words = chip.steps() - steps - u64::from(erased.iter().sum::<u32>());
    println!("a year: erases of each page {erased:?}, {words} words; longest call {longest_us} µs");
    assert_eq!(erased.len(), PAGES);
    // 10,000 erases of a page outlast the monitor many times over.
    assert!((1..100).contains(&most), "{erased:?}");
    assert!(most - erased.iter().min().unwrap() <= 1, "{erased:?}");
    assert!(longest_us < 3 * ERASE_US, "{longest_us}");
}
