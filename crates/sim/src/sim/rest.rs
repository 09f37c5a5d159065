//! Time passes over rest: the same as step by step, and much faster.

use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Software, Storage, StorageError};
use lafet_device::image::{Inputs, Outputs};
use lafet_proto::update::{Order, Phase, Report};

use super::Monitor;
use crate::software::Programs;
use crate::world::STEP_MS;

/// Steps made one by one before it is looked again whether all rests: one, then ever more.
const BUSY_STEPS: u64 = 32;
/// How far ahead a monitor is asked whether it rests, in steps: an hour, ten seconds, one.
const SPANS: [u64; 3] = [360_000, 1_000, 100];

impl Monitor {
    /// See [`super::Sim::pass_ms`].
    pub(super) fn pass_ms(&mut self, ms: u64) {
        let (mut left, mut busy) = (ms / STEP_MS, 1);
        while left > 0 {
            let span = self.program_rests_for(left);
            let rested = if span == 0 { 0 } else { self.pass_over(span) };
            left -= rested;
            if rested > 0 {
                busy = 1;
                continue;
            }
            for _ in 0..left.min(busy) {
                self.tick();
                left -= 1;
            }
            busy = BUSY_STEPS.min(busy * 2);
        }
    }

    /// For how many steps it is known to rest, at most so many.
    pub(super) fn rests_for(&self, most: u64) -> u64 {
        let span = self.program_rests_for(most);
        if span == 0 { 0 } else { self.world.rests_for(span) }
    }

    /// Passes over so many steps, through which it rests.
    pub(super) fn rest(&mut self, steps: u64) {
        let passed = self.pass_over(steps);
        (passed..steps).for_each(|_| self.tick());
    }

    /// Passes over at most so many steps; over how many.
    fn pass_over(&mut self, steps: u64) -> u64 {
        let passed = self.world.rest(steps);
        if passed > 0 {
            self.device.step(self.device_ms(), &mut self.world);
        }
        self.passed_over_ms += passed * STEP_MS;
        passed
    }

    /// For how many steps the program will not stir, with the inputs as they are, in a world at
    /// rest.
    fn program_rests_for(&self, most: u64) -> u64 {
        let stops = !self.powered || self.is_hung() || self.world.is_stalled();
        let waits = stops || !self.world.outputs().is_still();
        if waits || self.trace.is_some() || !self.monitor_rests(1) || !self.world.is_at_rest() {
            return 0;
        }
        let mut spans = SPANS.into_iter().map(|span| span.min(most));
        spans.find(|span| self.monitor_rests(*span)).unwrap_or(0)
    }

    /// Whether a step of the monitor so many steps from now leaves all as it is.
    fn monitor_rests(&self, steps: u64) -> bool {
        let mut device = self.device.clone();
        let report = self.world.software.as_deref().and_then(Programs::report);
        let software = report.map(|report| Tried { report, disturbed: false });
        let mut probe =
            Probe { inputs: self.world.inputs(), outputs: None, disturbed: false, software };
        let now_ms = self.device_ms().wrapping_add((steps * STEP_MS) as u32);
        device.step(now_ms, &mut probe);
        let drives_the_same = probe.outputs.as_ref() == Some(self.world.outputs());
        let disturbed = probe.disturbed || probe.software.is_some_and(|tried| tried.disturbed);
        !disturbed && drives_the_same && device.is_same_state(&self.device)
    }
}

/// Hardware on which a step is tried.
struct Probe<'a> {
    inputs: &'a Inputs,
    outputs: Option<Outputs>,
    /// It asked for more than inputs and outputs.
    disturbed: bool,
    software: Option<Tried>,
}

/// Software that can be updated, in a step that is tried: nothing of it may change. While it is on trial,
/// the device counts.
struct Tried {
    report: Report,
    /// It has something to do.
    disturbed: bool,
}

impl Software for Tried {
    fn perform(&mut self, _: &Order<'_>) {
        self.disturbed = true;
    }

    fn poll(&mut self) {
        self.disturbed |= self.report.phase == Phase::VERIFYING || self.report.pending;
    }

    fn report(&self) -> Report {
        self.report
    }

    // A step does not ask for it.
    fn hash(&self) -> [u8; 32] {
        [0; 32]
    }
}

impl Hal for Probe<'_> {
    fn read(&mut self, inputs: &mut Inputs) {
        inputs.clone_from(self.inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        self.outputs = Some(**outputs);
    }

    fn reset(&mut self) {
        self.disturbed = true;
    }

    fn software(&mut self) -> Option<&mut dyn Software> {
        self.software.as_mut().map(|tried| tried as &mut dyn Software)
    }
}

impl Storage for Probe<'_> {
    fn load<'b>(&mut self, _: Key, _: &'b mut [u8]) -> Result<Option<&'b [u8]>, StorageError> {
        self.disturbed = true;
        Err(StorageError::Read)
    }

    fn store(&mut self, _: Key, _: &[u8]) -> Result<(), StorageError> {
        self.disturbed = true;
        Err(StorageError::Write)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.disturbed = true;
        Err(StorageError::Write)
    }
}
