//! Long times in which nothing happens, in one go.
//!
//! A world is at rest when one more step would change nothing but the clock, the climate and the
//! noise of the pressure sensor. That is not concluded from flags: each part is stepped, and must
//! be what it was, bit for bit. Then the climate alone is worked out, up to the step before the
//! one in which a sensor would say something else.

use super::{SLOW_MS, STEP_MS, World};
use crate::climate::Climate;
use crate::contact;
use crate::drive::Load;
use crate::power;
use crate::rng::NOISE_DRAWS;
use crate::sensor;
use crate::unit::POLL_MS;
use lafet_device::image::Axis;

/// Steps of the climate worked out before it is looked at.
const STRETCH: u64 = 128;
const SLOW_STEPS: u64 = SLOW_MS / STEP_MS;

impl World {
    /// Whether another step, with the outputs as they are, changes nothing that matters.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.units_rest()
            && ![contact::any, power::any, sensor::any].iter().any(|moves| moves(&self.faults))
            && self.commanded.drives == self.applied.drives
            && self.commanded.valves == self.applied.valves
            && self.commanded.heaters == self.applied.heaters
            && self.fires.is_empty()
            && self.airborne.is_empty()
            && self.air_rests()
            && !self.jet_on
            && !self.flooded
            && self.landing().is_none()
            && self.machines_rest()
            && self.sensors_rest()
    }

    fn air_rests(&self) -> bool {
        let mut gusts = self.gusts.clone();
        gusts.step(self.wind, SLOW_MS as f64 / 1000.0);
        gusts == self.gusts
    }

    /// Remote units that are polled and report what they reported before.
    fn units_rest(&self) -> bool {
        let mut rng = self.rng.clone();
        let units = self.units.iter().zip(self.commanded.units).all(|(unit, op)| {
            unit.as_ref().is_none_or(|unit| unit.rests(op, &mut rng, &self.faults))
        });
        let drives = self.drives.iter().map(|drive| drive.sense(&self.faults));
        let valves = self.valves.iter().map(|valve| valve.sense(&self.faults));
        units && rng == self.rng && drives.eq(self.sensed.drives) && valves.eq(self.sensed.valves)
    }

    fn machines_rest(&self) -> bool {
        let dt_s = STEP_MS as f64 / 1000.0;
        let elevation = self.angle(Axis::Vertical);
        let load = Load { cos_elevation: libm::cos(elevation), flow_lps: self.water.jet_lps() };
        let drives = self.drives.iter().zip(self.applied.drives).all(|(drive, output)| {
            let mut next = drive.clone();
            next.step(output, load, dt_s, &self.faults);
            next == *drive && drive.current_a == 0.0
        });
        let valves = self.valves.iter().zip(self.applied.valves).all(|(valve, output)| {
            let mut next = valve.clone();
            next.step(output, dt_s, &self.faults);
            next == *valve && valve.current_a == 0.0
        });
        let mut water = self.water.clone();
        let areas = [self.valves[0].free_area(), self.valves[1].free_area()];
        water.step(areas, dt_s, &self.faults);
        drives && valves && water == self.water && water.flow_lps == 0.0
    }

    /// The detector sees the same without any noise, and the pressure sensor draws its share.
    fn sensors_rest(&self) -> bool {
        let mut rng = self.rng.clone();
        let picture = self.detector.look(self.aim(), &self.fires, &mut rng, &self.faults);
        let same = picture == self.sensed.detector && rng == self.rng;
        let mut skipped = self.rng.clone();
        skipped.skip(NOISE_DRAWS);
        let _ = self.water.loop_ua(&mut rng, &self.faults);
        same && rng == skipped
    }

    /// For how many steps, at most so many, the inputs stay as they are. Only for a world at rest.
    pub(crate) fn rests_for(&self, steps: u64) -> u64 {
        self.rest_ahead(steps).0
    }

    /// Moves time over at most so many steps, as long as the inputs stay as they are; how many.
    /// Only for a world at rest.
    pub(crate) fn rest(&mut self, steps: u64) -> u64 {
        let (done, climate) = self.rest_ahead(steps);
        if done > 0 {
            self.climate = climate;
            self.now_ms += done * STEP_MS;
            let polled_ms = self.now_ms - self.now_ms % POLL_MS;
            self.units.iter_mut().flatten().for_each(|unit| unit.rest(polled_ms));
            self.rng.skip((done - 1) * NOISE_DRAWS);
            self.sensed.pressure_ua = self.water.loop_ua(&mut self.rng, &self.faults);
        }
        done
    }

    /// The steps through which the inputs stay as they are, and the climate after them.
    fn rest_ahead(&self, steps: u64) -> (u64, Climate) {
        let mut climate = self.climate.clone();
        let (mut done, mut stretch) = (0, STRETCH);
        while done < steps {
            let to_slow = SLOW_STEPS - (self.now_ms + done * STEP_MS) % SLOW_MS / STEP_MS;
            if steps - done < to_slow {
                done = steps;
                break;
            }
            let slow = 1 + (steps - done - to_slow) / SLOW_STEPS;
            let rested = self.rest_climate(&mut climate, slow, &mut stretch);
            if rested == 0 {
                done += to_slow - 1;
                break;
            }
            done += to_slow + (rested - 1) * SLOW_STEPS;
        }
        (done, climate)
    }

    /// Steps the climate at most so many times, as long as its sensors say the same; how many.
    /// The nearer to the change, the shorter the stretches.
    fn rest_climate(&self, climate: &mut Climate, steps: u64, longest: &mut u64) -> u64 {
        while *longest > 0 {
            let stretch = steps.min(*longest);
            let mut next = climate.clone();
            let stays = self.climate_stays(&mut next, stretch);
            if stays && next == *climate {
                return steps;
            }
            if stays {
                *climate = next;
                return stretch;
            }
            *longest = stretch / 2;
        }
        0
    }

    /// Temperatures only go towards the air's or the heater's, so the last of a stretch is enough for
    /// all; humidity may turn back.
    fn climate_stays(&self, climate: &mut Climate, steps: u64) -> bool {
        let dt_s = SLOW_MS as f64 / 1000.0;
        let heaters = self.applied.heaters;
        if !climate.steps(heaters, dt_s, steps, &self.faults) {
            return false;
        }
        climate.sense(heaters, &self.faults) == self.sensed.places
            && climate.humidity_percent(&self.faults) == self.sensed.humidity_percent
            && climate.voltage_dv() == self.sensed.main_voltage_dv
    }
}
