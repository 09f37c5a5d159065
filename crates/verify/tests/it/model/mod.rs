//! The device keeps every law and shows the expected behaviour; a faulty one is found out.

mod broken;

use lafet_device::Device;
use lafet_verify::model::configuration::{self, Configuration};
use lafet_verify::model::interlock::Interlock;
use lafet_verify::model::law::Law;
use lafet_verify::model::monitor::Monitor;
use lafet_verify::model::report::{Effort, Outcome, run};
use lafet_verify::model::world::{Action, World};
use stateright::Model;

/// Waits after which an undisturbed monitor has come to rest.
const SETTLED: usize = 20;

fn small<M: Monitor>(states: usize, until: Option<Law>) -> Outcome {
    let configuration = Configuration::by_name("small").unwrap();
    run::<M>(configuration, Effort { states: Some(states), until, ..Effort::ALL })
}

/// The path to a broken law, which must be this one.
#[track_caller]
fn way_to<M: Monitor>(law: Law) -> Vec<String> {
    let outcome = small::<M>(120_000, Some(law));
    let found = outcome.broken.iter().find(|finding| finding.law == law.text());
    found.unwrap_or_else(|| panic!("not found out:\n{outcome}")).path.clone()
}

#[test]
fn the_device_keeps_the_laws_and_does_what_it_is_for() {
    let outcome = small::<Device>(200_000, None);
    assert!(outcome.is_good(), "{outcome}");
    assert!(outcome.unique > 10_000 && outcome.depth > 8, "{outcome}");
}

/// A field that counts time or requests and enters the fingerprint would make the number of states
/// infinite, and silently reduce the coverage of the check.
#[test]
fn idle_time_adds_no_state() {
    for configuration in configuration::ALL {
        let model = Interlock::<Device>::new(configuration, None);
        for mut world in model.init_states() {
            let wait =
                |world: &World<Device>| world.after(&Action::Wait, &configuration.composition);
            for _ in 0..SETTLED {
                world = wait(&world);
            }
            for _ in 0..SETTLED {
                let next = wait(&world);
                let name = configuration.name;
                assert!(next == world, "{name}: leave counters out of fingerprint.rs");
                world = next;
            }
        }
    }
}

#[test]
fn a_monitor_that_does_nothing_is_found_out() {
    let outcome = small::<broken::Deaf>(5_000, None);
    assert!(outcome.broken.is_empty(), "it does no harm: {outcome}");
    assert_eq!(outcome.unseen.len() + Law::ALL.len(), outcome.properties, "{outcome}");
}

#[test]
fn a_lockout_that_is_not_heeded() {
    let path = way_to::<broken::IgnoresLockout>(Law::LockoutStays);
    assert!(path.iter().any(|line| line.contains("Lockout All on")), "{path:#?}");
}

#[test]
fn a_lockout_that_a_power_loss_lifts() {
    let path = way_to::<broken::ForgetsLockout>(Law::LockoutStays);
    assert!(path.iter().any(|line| line.starts_with("power")), "{path:#?}");
}

#[test]
fn a_motor_that_runs_on_under_lockout() {
    way_to::<broken::RunsOn>(Law::LockedOutIsStill);
}

#[test]
fn a_stop_that_does_not_stop() {
    let path = way_to::<broken::NeverStops>(Law::StopStops);
    assert!(path.iter().any(|line| line.contains("Stop All")), "{path:#?}");
}

#[test]
fn a_position_switch_that_is_not_looked_at() {
    way_to::<broken::AlwaysDeployed>(Law::OnePosition);
}

/// §D/6 A switch that is contradicted by the position is not believed: no law is broken, and nothing works.
#[test]
fn a_position_switch_that_sticks_breaks_no_law() {
    let outcome = small::<broken::SwitchSticks>(120_000, None);
    assert!(outcome.broken.is_empty() && !outcome.is_good(), "{outcome}");
}

#[test]
fn folding_with_water() {
    let path = way_to::<broken::SeesNoWater>(Law::NoFoldingWithWater);
    let line = |what: &str| path.iter().position(|line| line.contains(what)).unwrap();
    assert!(line("Open Valve1") < line("Wrap Deployer"), "{path:#?}");
}

#[test]
fn a_flipped_output() {
    way_to::<broken::OpensUnasked>(Law::NoOpeningWhereForbidden);
}

#[test]
fn limits_that_are_not_heeded() {
    way_to::<broken::Overruns>(Law::WithinLimits);
}

#[test]
fn a_program_that_comes_back() {
    let path = way_to::<broken::Resumes>(Law::NothingUnasked);
    assert!(path.iter().any(|line| line.contains("StartQuench")), "{path:#?}");
}

#[test]
fn a_request_without_answer() {
    way_to::<broken::Silent>(Law::OneAnswer);
}

#[test]
fn an_interlock_left_out() {
    way_to::<broken::OpensInSearch>(Law::DeniedWhereDue);
}
