//! §3.3.4 Position sensors that jump while their drives rest.

use lafet_device::image::{AXES, Axis};
use lafet_proto::flags::DriveFlags;
use lafet_sim::world::STEP_MS;

use super::View;
use super::ledger::Ledger;

/// A drive rests for certain when it has not been fed for so long, ms.
const REST_MS: u64 = 500;
/// What is more than this in a step has jumped for certain, ' or mm: 5° or 5 mm, and the noise of a sensor.
const FAR_ARCMIN: u32 = 310;
const FAR_MM: u32 = 8;
/// It is reported within a second, and a step.
const REPORTED_MS: u64 = 1_010;

/// A drive.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    /// For how long it has been at rest, ms.
    ms: u64,
    reading: i32,
    /// Its sensor said that it is faulty.
    faulty: bool,
    /// The reading before it jumped, and for how long it has been another one, ms.
    jumped: Option<(i32, u64)>,
}

/// All drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Jumps {
    rests: [Rest; AXES],
    checked_ms: u64,
}

impl Jumps {
    /// Takes over what is sensed in a step of the program.
    pub fn follow(&mut self, ledger: &Ledger, view: &View<'_>) {
        let passed_ms = view.now_ms - std::mem::replace(&mut self.checked_ms, view.now_ms);
        // What changes while the program is stopped is no jump for it.
        let begins = passed_ms != STEP_MS || view.now_ms - ledger.powered_ms <= STEP_MS;
        for (axis, rest) in Axis::ALL.into_iter().zip(&mut self.rests) {
            let index = axis as usize;
            let turns = view.outputs.drives[index].speed_tenths != 0 || view.speeds[index] != 0.0;
            let lost = ledger.units.is_lost(axis.unit() as usize);
            let far = if axis == Axis::Nozzle { FAR_MM } else { FAR_ARCMIN };
            let reading = view.inputs.drives[index].position;
            let faulty = view.inputs.drives[index].position_sensor_fault;
            // What changes with that flag is set.
            let is_set = std::mem::replace(&mut rest.faulty, faulty) || faulty;
            let has_jumped = reading.abs_diff(rest.reading) >= far;
            *rest = match rest.jumped {
                _ if begins || turns || lost || is_set => {
                    Rest { reading, faulty, ..Rest::default() }
                }
                None if has_jumped && rest.ms >= REST_MS => {
                    Rest { reading, jumped: Some((rest.reading, 0)), ..*rest }
                }
                None if has_jumped => Rest { reading, ..Rest::default() },
                Some((from, _)) if reading.abs_diff(from) < far => {
                    Rest { reading, ..Rest::default() }
                }
                Some((from, ms)) => Rest { reading, jumped: Some((from, ms + STEP_MS)), ..*rest },
                None => Rest { reading, ms: rest.ms + STEP_MS, ..*rest },
            };
        }
    }

    /// A position that has jumped is reported.
    pub fn judge(&self, view: &View<'_>) -> Option<String> {
        let silent = |axis: &Axis| {
            let told = DriveFlags::from_bits_retain(view.told.drives[*axis as usize]);
            let lasts = self.rests[*axis as usize].jumped.is_some_and(|(_, ms)| ms > REPORTED_MS);
            lasts && view.device.has(axis.id()) && !told.contains(DriveFlags::POS_ENCODER_FAULT)
        };
        let axis = Axis::ALL.into_iter().find(silent)?;
        Some(format!("{axis:?} reports nothing of a position that has jumped at rest"))
    }
}
