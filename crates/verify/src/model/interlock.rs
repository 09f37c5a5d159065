//! The model that stateright explores.

use crate::model::configuration::Configuration;
use crate::model::law::Law;
use crate::model::monitor::Monitor;
use crate::model::witness::{COUNT, Witness};
use crate::model::world::{Action, World};
use stateright::{Model, Property};
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A configuration with a monitor.
#[derive(Clone, Debug)]
pub struct Interlock<M> {
    /// What may happen.
    pub configuration: &'static Configuration,
    deadline: Option<Instant>,
    clock: Arc<Clock>,
    monitor: PhantomData<fn() -> M>,
}

impl<M> Interlock<M> {
    /// The model of a configuration. After the deadline no state has a successor: stateright does
    /// not check its own timeout with a single thread.
    pub fn new(configuration: &'static Configuration, deadline: Option<Instant>) -> Self {
        Self { configuration, deadline, clock: Arc::default(), monitor: PhantomData }
    }

    /// The clock, to be stopped after exploration: stateright replays the paths it found.
    pub fn clock(&self) -> Arc<Clock> {
        Arc::clone(&self.clock)
    }

    fn is_late(&self) -> bool {
        let running = !self.clock.stopped.load(Ordering::Relaxed);
        let late = running && self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if late {
            self.clock.cut.store(true, Ordering::Relaxed);
        }
        late
    }
}

/// The deadline, and whether it has cut off any state.
#[derive(Debug, Default)]
pub struct Clock {
    stopped: AtomicBool,
    cut: AtomicBool,
}

impl Clock {
    /// Lifts the deadline.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether the deadline has cut off any state.
    pub fn has_cut(&self) -> bool {
        self.cut.load(Ordering::Relaxed)
    }
}

type Condition<M> = fn(&Interlock<M>, &World<M>) -> bool;

/// One function per number: stateright takes conditions as functions of the state alone.
macro_rules! numbered {
    ($condition:ident: $($number:literal)*) => { [$($condition::<M, $number>,)*] };
}

fn keeps<M, const LAW: usize>(_: &Interlock<M>, world: &World<M>) -> bool {
    !world.broken.contains(Law::ALL[LAW])
}

fn sees<M, const WITNESS: usize>(_: &Interlock<M>, world: &World<M>) -> bool {
    world.happened.contains(WITNESS)
}

impl<M: Monitor> Model for Interlock<M> {
    type State = World<M>;
    type Action = Action;

    fn init_states(&self) -> Vec<Self::State> {
        let Configuration { composition, fire_at, fault_budget, .. } = self.configuration;
        let wrapped = World::new(composition, *fire_at, *fault_budget);
        if !wrapped.view().has_deployer() {
            return vec![wrapped];
        }
        // Starts from the working position too, as most of the behaviour begins there.
        let deployed = wrapped.deployed(composition);
        vec![wrapped, deployed]
    }

    /// No actions after a broken law: the shortest path to it is wanted.
    fn actions(&self, world: &Self::State, actions: &mut Vec<Self::Action>) {
        if world.broken.is_empty() && !self.is_late() {
            self.configuration.actions(world, actions);
        }
    }

    fn next_state(&self, world: &Self::State, action: Self::Action) -> Option<Self::State> {
        Some(world.after(&action, &self.configuration.composition))
    }

    fn properties(&self) -> Vec<Property<Self>> {
        const LAWS: usize = Law::ALL.len();
        let keeps: [Condition<M>; LAWS] = numbered!(keeps: 0 1 2 3 4 5 6 7 8 9 10 11);
        let sees: [Condition<M>; COUNT] = numbered!(sees: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64 65 66 67 68 69 70 71 72 73 74 75 76 77 78 79 80 81 82);
        let laws =
            Law::ALL.iter().zip(keeps).map(|(law, keeps)| Property::always(law.text(), keeps));
        let witness = |witness: Witness| (witness.text(), sees[witness.index()]);
        let witnesses = self.configuration.witnesses.iter().flat_map(|all| all.iter().copied());
        let seen = witnesses.map(witness).map(|(text, sees)| Property::sometimes(text, sees));
        laws.chain(seen).collect()
    }
}
