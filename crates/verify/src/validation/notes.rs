//! Notes 1–5 of §3.3.6, each in a situation of its own: the flags, and where the barrel aims.

use lafet_device::image::Axis;
use lafet_proto::SubsystemId;
use lafet_proto::request::Body;
use lafet_sim::fault::{DriveFault, Fault};
use lafet_sim::sim::Config;

use super::Table;
use super::bench::Bench;

/// Line of sight to the fires here, arc-minutes, and the nozzle that is asked for, mm.
const SIGHT: i32 = 300;
const NOZZLE_MM: i32 = 50;
/// Time in which aim and flags have come to rest, ms.
const REST_MS: u64 = 12_000;

/// A situation: what precedes, and the program.
struct Situation {
    note: &'static str,
    name: &'static str,
    before: &'static [&'static str],
    open: bool,
    /// A drive fails while it runs.
    fault: Option<Fault>,
    /// The value of the memory that is damaged.
    damage: Option<u16>,
    distance_m: u8,
    /// Flags of Control that are expected.
    expected: &'static str,
    /// The barrel is raised above the line of sight.
    raised: bool,
    /// The nozzle, mm.
    nozzle_mm: i32,
}

const GOOD: Situation = Situation {
    note: "—",
    name: "ballistics on, water, in reach",
    before: &[],
    open: true,
    fault: None,
    damage: None,
    distance_m: 25,
    expected: "Quench",
    raised: true,
    nozzle_mm: NOZZLE_MM,
};

const SITUATIONS: &[Situation] = &[
    GOOD,
    Situation {
        note: "1",
        name: "a drive fails: the program ends",
        fault: Some(Fault::Drive(Axis::Horizontal, DriveFault::MotorOpen)),
        expected: "InternalFault",
        ..GOOD
    },
    Situation {
        note: "2, 5",
        name: "ballistics off, far out of reach",
        before: &["SetParam Control Ballistics 0"],
        distance_m: 120,
        raised: false,
        nozzle_mm: 60,
        ..GOOD
    },
    Situation {
        note: "2, 5",
        name: "ballistics off, table damaged, no distance",
        before: &[TABLE, "SetParam Control Ballistics 0"],
        expected: "ConfigFault, Quench",
        damage: Some(DAMAGED),
        distance_m: 0,
        raised: false,
        ..GOOD
    },
    Situation {
        note: "3",
        name: "the sector lies partly outside the limits: what is inside",
        before: &["SetParam Horizontal MaxLimit 300"],
        expected: "Quench, OutsideLimits",
        ..GOOD
    },
    Situation {
        note: "4, 5",
        name: "no water: until the pressure comes",
        open: false,
        expected: "Quench, TrajectoryPressureFault",
        raised: false,
        nozzle_mm: 60,
        ..GOOD
    },
    Situation {
        note: "4, 5",
        name: "too far: until the next start",
        distance_m: 120,
        expected: "Quench, TrajectoryRangeFault",
        raised: false,
        nozzle_mm: 60,
        ..GOOD
    },
    Situation {
        note: "4, 5",
        name: "above the limit of Vertical: until the next start",
        before: &["SetParam Vertical MaxLimit 320"],
        expected: "Quench, TrajectoryAngleFault",
        raised: false,
        nozzle_mm: 60,
        ..GOOD
    },
    Situation {
        note: "4",
        name: "table damaged, no distance: until the next start",
        before: &[TABLE],
        damage: Some(DAMAGED),
        distance_m: 0,
        expected: "ConfigFault, Quench, TrajectoryCRCFault",
        raised: false,
        ..GOOD
    },
];

const TABLE: &str = "SetupCorrectionTable Control first=70 corrections=1,1,1,1,1,1,1,1,1,1,1,1";
/// Where the memory keeps the correction table.
const DAMAGED: u16 = 31;

/// What came of it: flags, elevation in arc-minutes, nozzle in mm.
fn outcome(situation: &Situation) -> Option<(String, f64, f64)> {
    let mut bench = Bench::deployed(Config::default());
    situation.before.iter().for_each(|request| bench.send(request));
    bench.0.advance_ms(500);
    if let Some(key) = situation.damage {
        bench.0.world_mut().flash.damage(lafet_device::hal::Key(key));
        bench.0.power_cycle();
        bench.0.advance_ms(1_000);
    }
    if situation.open {
        bench.send("Open Valve1");
        bench.until("General pressure >= 77", 30_000)?;
    }
    let Situation { distance_m, .. } = situation;
    bench.send(&format!(
        "StartQuench Control centre=300,{SIGHT} nozzle={NOZZLE_MM} sector=120,0 step=0 \
         distance={distance_m}"
    ));
    if let Some(fault) = situation.fault {
        bench.0.advance_ms(1_000);
        bench.0.world_mut().inject(fault);
    }
    bench.0.advance_ms(REST_MS);
    let mut flags = String::new();
    bench.0.ask(SubsystemId::CONTROL, Body::GetStatus, |answer| flags = answer.to_string());
    let flags = flags.split_once('[')?.1.trim_end_matches(']').to_owned();
    let at = |axis: Axis| bench.0.world().drives[axis as usize].position;
    Some((flags, at(Axis::Vertical), at(Axis::Nozzle)))
}

/// Whether an outcome is what the note says.
fn holds(situation: &Situation, (flags, elevation, nozzle): &(String, f64, f64)) -> bool {
    let raised = elevation - f64::from(SIGHT);
    let aims = if situation.raised { raised > 60.0 } else { raised.abs() < 3.0 };
    let narrow = (nozzle - f64::from(situation.nozzle_mm)).abs() < 1.0;
    // A program that has ended aims nowhere.
    flags == situation.expected && (situation.fault.is_some() || (aims && narrow))
}

/// Flags and aim in each situation.
pub fn table() -> String {
    let titles =
        ["note", "situation", "flags of Control", "elevation", "nozzle, mm", "as the note says"];
    let mut table = Table::new(&titles);
    for situation in SITUATIONS {
        let found = outcome(situation);
        let right = found.as_ref().is_some_and(|found| holds(situation, found));
        let cells = match found {
            Some((flags, elevation, nozzle)) => {
                [flags, format!("{elevation:.0}′"), format!("{nozzle:.0}")]
            }
            None => ["—", "—", "—"].map(str::to_owned),
        };
        let head = [situation.note.to_owned(), situation.name.to_owned()];
        let tail = [if right { "yes" } else { "no" }.to_owned()];
        table.row(&head.into_iter().chain(cells).chain(tail).collect::<Vec<_>>());
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §3.3.6/1–5: the flags that the notes name and no others; the line of sight with the
    /// narrowest jet where they ask for it, else raised with the nozzle as requested.
    #[test]
    fn as_the_notes_say() {
        for situation in SITUATIONS {
            let found = outcome(situation).expect(situation.name);
            assert!(holds(situation, &found), "{}: {found:?}", situation.name);
        }
    }
}
