//! The valves: water and foam.
//!
//! State: opening s, 0 closed … 1 open. The motor moves it by dt/travel_time per step, and it stays
//! where it is when the motor is off. Free area as a part of the full one: f(s) = sin²(π·s/2), a
//! ball valve. Motor current: 1.5 A running, 3 A while leaving the seat (s < 0.05), 8 A against the
//! end or jammed (its own end switch cuts it when its relay is welded), with a lag of 50 ms. The switches close in the last 0.5 % of the travel. Figures
//! ours.

use lafet_device::image::{ValveInput, ValveNo, ValveOutput};

use crate::drive::LEAST_A;
use crate::fault::{Faults, ValveFault};

const SWITCH_ZONE: f64 = 0.005;
const RUN_A: f64 = 1.5;
const SEAT_A: f64 = 3.0;
const STALL_A: f64 = 8.0;
const CURRENT_LAG_S: f64 = 0.05;

/// A valve.
#[derive(Clone, Debug, PartialEq)]
pub struct Valve {
    /// Which one.
    pub number: ValveNo,
    /// Opening, 0 closed … 1 open.
    pub opening: f64,
    /// Time from closed to open, s.
    pub travel_s: f64,
    /// Motor current, A.
    pub current_a: f64,
}

impl Valve {
    /// A closed valve that takes `travel_s` from end to end.
    pub const fn new(number: ValveNo, travel_s: f64) -> Self {
        Self { number, opening: 0.0, travel_s, current_a: 0.0 }
    }

    /// Runs the motor for `dt_s`.
    pub fn step(&mut self, command: ValveOutput, dt_s: f64, faults: &Faults) {
        let dead = faults.valve(self.number, ValveFault::MotorOpen)
            || faults.valve(self.number, ValveFault::Blocked);
        let welded = faults.valve(self.number, ValveFault::OpenRelay);
        let direction = match command {
            _ if welded && !dead => 1.0,
            ValveOutput::Opening if !dead => 1.0,
            ValveOutput::Closing if !dead => -1.0,
            _ => 0.0,
        };
        let jam = faults.valve(self.number, ValveFault::Jam);
        let at_end =
            (direction > 0.0 && self.opening >= 1.0) || (direction < 0.0 && self.opening <= 0.0);
        let aim = if direction == 0.0 || welded && self.opening >= 1.0 {
            0.0
        } else if jam || at_end {
            STALL_A
        } else if self.opening < 0.05 {
            SEAT_A
        } else {
            RUN_A
        };
        if !jam {
            self.opening = (self.opening + direction * dt_s / self.travel_s).clamp(0.0, 1.0);
        }
        self.current_a += (aim - self.current_a) * (dt_s / CURRENT_LAG_S).min(1.0);
        if aim == 0.0 && self.current_a < LEAST_A {
            self.current_a = 0.0;
        }
    }

    /// Free area as a part of the full one.
    pub fn free_area(&self) -> f64 {
        // The seat covers the bore of the ball as long as the switch says closed.
        if self.opening <= SWITCH_ZONE {
            return 0.0;
        }
        let sine = libm::sin(core::f64::consts::FRAC_PI_2 * self.opening);
        sine * sine
    }

    /// What its switches and its motor say.
    pub fn sense(&self, faults: &Faults) -> ValveInput {
        let open_fault = faults.valve(self.number, ValveFault::OpenSwitch);
        let close_fault = faults.valve(self.number, ValveFault::CloseSwitch);
        let closed =
            self.opening <= SWITCH_ZONE || faults.valve(self.number, ValveFault::CloseStuck);
        let mut input = ValveInput::default();
        input.open_switch = !open_fault && self.opening >= 1.0 - SWITCH_ZONE;
        input.close_switch = !close_fault && closed;
        input.open_sensor_fault = open_fault;
        input.close_sensor_fault = close_fault;
        input.current_da = libm::round(self.current_a * 10.0) as u16;
        input.blocked = faults.valve(self.number, ValveFault::Blocked);
        input
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    fn run(valve: &mut Valve, command: ValveOutput, steps: u32, faults: &Faults) {
        for _ in 0..steps {
            valve.step(command, 0.01, faults);
        }
    }

    #[test]
    fn travels_in_its_time_and_stays_without_power() {
        let faults = Faults::default();
        let mut valve = Valve::new(ValveNo::Valve1, 4.0);
        assert!(valve.sense(&faults).close_switch);
        run(&mut valve, ValveOutput::Opening, 200, &faults);
        assert!((valve.opening - 0.5).abs() < 1e-6 && (valve.free_area() - 0.5).abs() < 1e-6);
        assert_eq!(valve.sense(&faults).current_da, 15);
        run(&mut valve, ValveOutput::Off, 1000, &faults);
        assert!((valve.opening - 0.5).abs() < 1e-6);
        let sensed = valve.sense(&faults);
        assert!(!sensed.open_switch && !sensed.close_switch);
        run(&mut valve, ValveOutput::Opening, 240, &faults);
        assert!(valve.sense(&faults).open_switch);
        assert_eq!(valve.sense(&faults).current_da, 80);
    }

    /// Two valves that have stopped at their switches let nothing through.
    #[test]
    fn closed_by_its_switch_is_tight() {
        let faults = Faults::default();
        let mut valve = Valve::new(ValveNo::Valve1, 4.0);
        run(&mut valve, ValveOutput::Opening, 400, &faults);
        while !valve.sense(&faults).close_switch {
            valve.step(ValveOutput::Closing, 0.01, &faults);
        }
        assert!(valve.opening > 0.0 && valve.free_area() == 0.0, "{}", valve.opening);
    }

    #[test]
    fn faults_hold_it() {
        for fault in [ValveFault::Jam, ValveFault::Blocked, ValveFault::MotorOpen] {
            let mut faults = Faults::default();
            let mut valve = Valve::new(ValveNo::Valve2, 4.0);
            faults.inject(Fault::Valve(ValveNo::Valve2, fault));
            run(&mut valve, ValveOutput::Opening, 500, &faults);
            assert!(valve.opening == 0.0, "{fault:?}");
            let sensed = valve.sense(&faults);
            assert_eq!(sensed.current_da == 80, fault == ValveFault::Jam);
            assert_eq!(sensed.blocked, fault == ValveFault::Blocked);
        }
        let mut faults = Faults::default();
        faults.inject(Fault::Valve(ValveNo::Valve1, ValveFault::OpenRelay));
        let mut welded = Valve::new(ValveNo::Valve1, 4.0);
        run(&mut welded, ValveOutput::Off, 500, &faults);
        assert!(welded.opening == 1.0 && welded.current_a == 0.0, "{welded:?}");
        run(&mut welded, ValveOutput::Closing, 500, &faults);
        assert!(welded.opening == 1.0 && welded.current_a == 0.0, "{welded:?}");
        let mut faults = Faults::default();
        faults.inject(Fault::Valve(ValveNo::Valve1, ValveFault::CloseSwitch));
        let sensed = Valve::new(ValveNo::Valve1, 4.0).sense(&faults);
        assert!(sensed.close_sensor_fault && !sensed.close_switch);
    }
}
