//! §3.3.1/3, §D/6 Which remote units are lost: silent ones, and those that are not understood.

use lafet_device::image::{Axis, UNITS, UnitInput, ValveNo};
use lafet_device::params::Params;
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::{DriveParam, Param, ValveParam};

use super::View;

/// A unit may break the protocol of its bus for less than this, ms.
const BROKEN_MS: u64 = 100;
/// A step of the program counts as so much at most, ms.
const STEP_MS: u64 = 50;

/// All units, by `Unit`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Units {
    /// For how long nothing of a unit has been understood, ms; `None` once it has been silent, and at the start.
    broken_ms: [Option<u64>; UNITS],
    /// What the parameters had as remote when the program started.
    remote: Option<[bool; UNITS]>,
}

impl Units {
    /// The program starts with these parameters.
    pub(super) fn powered_up(params: &Params) -> Self {
        Self { remote: Some(remote(params)), ..Self::default() }
    }

    /// Takes over what is sensed.
    pub(super) fn sense(&mut self, passed_ms: u64, params: &Params, inputs: &[UnitInput; UNITS]) {
        self.remote.get_or_insert_with(|| remote(params));
        for (broken_ms, input) in self.broken_ms.iter_mut().zip(inputs) {
            *broken_ms = match (input.online, input.protocol_fault) {
                (true, false) => Some(0),
                (true, true) => broken_ms.map(|ms| ms + passed_ms.min(STEP_MS)),
                (false, _) => None,
            };
        }
    }

    /// Nothing new is known of this unit, and nothing reaches it.
    pub fn is_lost(&self, unit: usize) -> bool {
        self.broken_ms[unit].is_none_or(|ms| ms >= BROKEN_MS)
    }

    /// A unit that is lost is reported, one that is not is not, and a drive that is lost is not driven.
    pub(super) fn judge(&self, view: &View<'_>) -> Option<String> {
        let remote = self.remote.unwrap_or_default();
        let drives = Axis::ALL.map(|axis| {
            let is_driven = view.outputs.drives[axis as usize].speed_tenths != 0;
            (axis.id(), view.told.drives[axis as usize], is_driven)
        });
        let valves = ValveNo::ALL.map(|no| (no.id(), view.told.valves[no as usize], false));
        let all = drives.into_iter().chain(valves).enumerate();
        let mut known = all.filter(|(unit, (id, ..))| remote[*unit] && view.device.has(*id));
        known.find_map(|(unit, (id, told, is_driven))| {
            let reported = told & DriveFlags::CONN_LOST.bits() != 0;
            let what = match (self.is_lost(unit), reported) {
                (true, false) => "does not report that its unit is lost",
                (false, true) => "reports a unit as lost that is heard",
                (true, true) if is_driven => "is driven, and its unit is lost",
                _ => return None,
            };
            Some(format!("{id} {what}"))
        })
    }
}

/// Which units there are by these parameters.
fn remote(params: &Params) -> [bool; UNITS] {
    let [vertical, horizontal, nozzle, deployer] =
        Axis::ALL.map(|axis| params.drive(axis, DriveParam::DriveType) == 1);
    let [valve1, valve2] = ValveNo::ALL.map(|no| {
        Param::of_valve(no.id(), ValveParam::ValveType).is_some_and(|param| params.get(param) == 1)
    });
    [vertical, horizontal, nozzle, deployer, valve1, valve2]
}
