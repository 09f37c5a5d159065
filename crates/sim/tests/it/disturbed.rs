//! Sensors that are noisy, stand still or drift: what the monitor makes of them, and what it cannot know.
//! What stays untold here is latent: the safety manual has the proof test that finds it.

use lafet_device::image::Place;
use lafet_sim::condition::Condition;
use lafet_sim::fault::Fault;
use lafet_sim::scenario::Scenario;
use lafet_sim::sim::{Config, Sim};

fn holds(text: &str) {
    let run = Scenario::parse("t.txt", text).and_then(|it| it.run(&mut |_| {}));
    if let Err(failure) = run {
        panic!("{failure}");
    }
}

/// Noise of ±2' or ±1 mm is no fault: each drive comes to rest where it was sent, and stays there.
#[test]
fn a_noisy_encoder_is_lived_with() {
    for profile in ["full", "ex", "limit-switch"] {
        holds(&format!(
            "case a\nprofile {profile}\nstate deployed\n\
             inject fault vertical-encoder-noise\ninject fault horizontal-encoder-noise\n\
             inject fault nozzle-encoder-noise\ninject fault deployer-encoder-noise\n\
             never Vertical flags has PosEncoderFault\nnever Horizontal flags has PosEncoderFault\n\
             never Nozzle flags has PosEncoderFault\nnever Deployer flags has PosEncoderFault\n\
             ! Move Vertical 900 ; Move Horizontal -1500 ; Move Nozzle 20\n\
             after 1s\nuntil output motion = 0 within 30s\nafter 2s\n\
             expect world vertical >= 895\nexpect world vertical <= 905\n\
             expect world horizontal >= -1505\nexpect world horizontal <= -1495\n\
             expect world nozzle >= 18\nexpect world nozzle <= 22\n\
             never output motion != 0\nafter 60s\nend never\n\
             expect Vertical flags = none\nexpect param General InputFaults = 0\n\
             ! Wrap\nuntil Deployer flags has Wrapped within 60s\n"
        ));
    }
}

/// Frozen at 0 it says what is true while the valves are closed, and with water on the pressure speaks for
/// the water: untold. The valve's own contact still forbids to fold.
#[test]
fn a_flow_meter_that_stands_still_at_nought_is_latent() {
    holds(
        "case a\nstate deployed\ninject fault flow-frozen\n! Open Valve1\n\
         until Valve1 flags has Open within 10s\nafter 20s\nexpect world jet on\n\
         expect General flow = 0\nexpect param General InputFaults = 0\n\
         > Wrap\n< Deployer Wrap → Denied (Valve1)\n",
    );
}

/// Frozen with water on it contradicts valves that have closed: their contacts are not believed, and the
/// barrel is not folded.
#[test]
fn a_flow_meter_that_stands_still_with_water_on_is_told() {
    holds(
        "case a\nstate open\nuntil input flow >= 15 within 20s\ninject fault flow-frozen\n\
         ! Close Valve1\nuntil input valve1 closed on within 20s\n\
         until Valve1 flags has CloseSensorFault within 3.1s\n\
         expect param General InputFaults = 1\nnever output deployer != 0\n\
         > Wrap\n< Deployer Wrap → Denied (Valve2)\nafter 1s\nend never\n\
         clear fault flow-frozen\nuntil Valve1 flags lacks CloseSensorFault within 3.1s\n\
         > Wrap\n< Deployer Wrap → Accepted\n",
    );
}

/// What is inside its range is believed: a loop that does not change, and one that drifts until it leaves it.
#[test]
fn a_pressure_that_lies_is_told_when_it_leaves_its_range() {
    holds(
        "case a\nstate deployed\ninject fault pressure-frozen\n! Open Valve1\n\
         until input flow >= 15 within 20s\nafter 20s\nexpect General pressure = 0\n\
         expect General flags lacks PressureSensorBreak PressureSensorShort\n\
         clear fault pressure-frozen\nafter 20ms\nexpect General pressure > 50\n",
    );
    holds(
        "case a\nstate deployed\ninject fault pressure-drift\nafter 15s\n\
         expect General flags lacks PressureSensorBreak\n\
         until input pressure < 3600 within 10s\n\
         until General flags has PressureSensorBreak within 500ms\n",
    );
}

/// A warm reading that does not change keeps the heater off in the cold, one that drifts up switches it off:
/// both are inside the range, and untold.
#[test]
fn a_temperature_that_lies_is_latent() {
    let place = Place::Vertical as usize;
    for fault in [Fault::TemperatureFrozen, Fault::TemperatureDrift] {
        let mut sim = Sim::new(Config::default());
        sim.advance_ms(1_000);
        sim.world_mut().inject(fault(Place::Vertical));
        sim.world_mut().climate.ambient_c = -30.0;
        sim.advance_ms(3_000_000);
        assert!(sim.world().climate.places_c[place] < -25.0);
        assert!(sim.world().inputs().places[place].temperature_dc >= Some(200));
        let heaters = sim.world().outputs().heaters;
        assert!(!heaters[place] && heaters[Place::Horizontal as usize]);
        let untold = "Climatics flags lacks VerticalFault VerticalSensorFault";
        let holds = Condition::parse(untold).and_then(|it| it.holds(&mut sim));
        assert_eq!(holds.map(|(holds, _)| holds), Ok(true));
    }
}
