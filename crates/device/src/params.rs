//! §3.4 «GetParam», §3.5 «SetParam»: the parameters' values, and what of them must be stored.
//!
//! Values stand in RAM; `handle` changes them there and marks their group, `step` writes one
//! marked group at a time. A group is stored as one value, so it is replaced as a whole. Accepted
//! says that it will be written, Ok that it is in the memory already (§3.5/9).

mod group;

use crate::composition::{ChainSet, Composition, table_index};
use crate::hal::{Storage, StorageError, VALUE_MAX};
use crate::image::Axis;
use crate::time::{Millis, Timer};
use group::Group;
use lafet_proto::link::crc16;
use lafet_proto::param::{self, DriveParam, Param};
use lafet_proto::request::TrajectoryPoint;
use lafet_proto::{Bytes, Ints, Status, SubsystemId};

/// Numbers that a parameter can hold at most.
pub const VALUES_MAX: usize = 63;
const PROGRAMS: usize = group::PROGRAMS as usize;
const TRAJECTORIES: usize = group::TRAJECTORIES as usize;
const POINTS: usize = 15;
const WORDS: usize = Param::COUNT.div_ceil(32);
/// What could not be stored is tried again after this time (ours).
const RETRY_MS: u32 = 60_000;

/// A stored trajectory.
#[derive(Clone, Copy, PartialEq)]
struct Stored {
    points: [TrajectoryPoint; POINTS],
    len: u8,
}

impl Stored {
    const BLANK: Self = {
        let point = TrajectoryPoint { horizontal: 0, vertical: 0, distance: 0, dwell: 0 };
        Self { points: [point; POINTS], len: 0 }
    };
}

/// The number of points: what is behind them means nothing.
impl core::fmt::Debug for Stored {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_list().entries(self.points.iter().take(self.len.into())).finish()
    }
}

/// Every parameter's value.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    values: [i32; Param::COUNT],
    set: [u32; WORDS],
    programs: [[i16; 7]; PROGRAMS],
    trajectories: [Stored; TRAJECTORIES],
    correction: [i8; 256],
    correction_damaged: bool,
    lockout: bool,
    /// Groups by index: to be stored, never stored, that could not be read, nor be stored.
    dirty: u32,
    absent: u32,
    unread: u32,
    unwritten: u32,
    retry_in: Timer,
    incomplete: u16,
    /// Address and composition with which a start that has lost General's set goes on.
    stand_in: Option<(u8, ChainSet)>,
}

impl Params {
    /// Reads everything that is stored.
    #[cfg(test)]
    pub(crate) fn load(storage: &mut impl Storage) -> Self {
        let mut params = Self::BLANK;
        params.restore(storage);
        params
    }

    /// Reads everything that is stored, into parameters that are blank.
    #[inline(never)]
    pub(crate) fn restore(&mut self, storage: &mut impl Storage) {
        for (value, param) in self.values.iter_mut().zip(&Param::ALL) {
            *value = param.default();
        }
        for index in 0..Group::COUNT {
            let group = Group::from_index(index);
            let mut buffer = [0; VALUE_MAX];
            let read = match storage.load(group.key(), &mut buffer) {
                Ok(None) => {
                    // A monitor that was never locked out has nothing to store.
                    if group != Group::Lockout {
                        self.absent |= group.bit();
                    }
                    continue;
                }
                Ok(Some(value)) => self.decode(group, value),
                Err(_) => None,
            };
            if read.is_none() {
                self.unread |= group.bit();
                // §3.6/3
                if group == Group::Correction {
                    self.correction_damaged = true;
                }
                // §3.18/6 A monitor that cannot tell whether it was locked out stays locked out.
                if group == Group::Lockout {
                    self.lockout = true;
                }
            }
        }
        self.update_incomplete();
    }

    /// Stores the factory's values of a composition: what a new monitor leaves the factory with.
    ///
    /// # Errors
    ///
    /// [`StorageError`] of the first group of values that the memory does not take.
    pub fn provision(
        storage: &mut impl Storage,
        composition: &Composition,
        address: u8,
    ) -> Result<(), StorageError> {
        let mut params = Self::unset();
        for param in Param::ALL {
            if is_number(param) {
                let value = match param {
                    Param::GeneralAddress => i32::from(address),
                    param => composition.factory_value(param),
                };
                params.put(param, value);
            }
        }
        for index in 0..group::SUBSYSTEMS {
            params.store(Group::Subsystem(index), storage)?;
        }
        Ok(())
    }

    fn unset() -> Self {
        let mut params = Self::BLANK;
        params.values = Param::ALL.map(Param::default);
        params
    }

    /// Before anything is known of them, the defaults not either.
    pub(crate) const BLANK: Self = Self {
        values: [0; Param::COUNT],
        set: [0; WORDS],
        programs: [[0; 7]; PROGRAMS],
        trajectories: [Stored::BLANK; TRAJECTORIES],
        correction: [0; 256],
        correction_damaged: false,
        lockout: false,
        dirty: 0,
        absent: 0,
        unread: 0,
        unwritten: 0,
        retry_in: Timer::STOPPED,
        incomplete: 0,
        stand_in: None,
    };

    /// A parameter that holds one number; its default while it is unset.
    pub fn get(&self, param: Param) -> i32 {
        self.values.get(param as usize).copied().unwrap_or_default()
    }

    /// A parameter of a drive.
    pub fn drive(&self, axis: Axis, param: DriveParam) -> i32 {
        Param::of_drive(axis.id(), param).map_or(0, |param| self.get(param))
    }

    /// A stored program; all zero when it was never set (§3.14).
    pub fn program(&self, number: usize) -> Option<[i16; 7]> {
        self.programs.get(number).copied()
    }

    /// The points of a stored trajectory; none when it was never set (§3.15).
    pub fn trajectory(&self, number: usize) -> &[TrajectoryPoint] {
        let Some(stored) = self.trajectories.get(number) else { return &[] };
        stored.points.get(..usize::from(stored.len)).unwrap_or_default()
    }

    /// §3.3.1/1 A program or a trajectory whose stored values could not be read, and were not set since.
    pub(crate) fn is_lost(&self, param: Param) -> bool {
        let bit = Group::of(param).bit();
        self.unread & !(self.dirty | self.unwritten) & bit != 0
    }

    /// §3.6 Degrees to add to the elevation at a pressure; `None` when the table is damaged.
    pub fn correction(&self, pressure_datm: u16) -> Option<i8> {
        let last = self.correction.len() - 1;
        let index = usize::from(pressure_datm).min(last);
        self.correction.get(index).copied().filter(|_| !self.correction_damaged)
    }

    /// §3.6 The correction table is whole.
    pub const fn correction_valid(&self) -> bool {
        !self.correction_damaged
    }

    /// §3.6/1 Changes entries of the correction table, which is stored as a whole.
    pub(crate) fn set_corrections(&mut self, first: u8, corrections: Bytes<'_>) -> Status {
        let first = usize::from(first);
        let Some(entries) = self.correction.get_mut(first..first + corrections.0.len()) else {
            // §3.6/2
            return Status::INVALID_VALUE;
        };
        let mut changed = false;
        for (entry, correction) in entries.iter_mut().zip(corrections.iter()) {
            changed |= core::mem::replace(entry, correction) != correction;
        }
        self.correction_damaged = false;
        self.keep(Group::Correction, changed)
    }

    /// §3.13 Stores what the alignment of detector and barrel has found.
    pub(crate) fn set_justify(&mut self, horizontal_arcmin: i32, vertical_arcmin: i32) {
        self.put(Param::DetectorJustifyHorizontal, horizontal_arcmin);
        self.put(Param::DetectorJustifyVertical, vertical_arcmin);
        self.mark(Group::of(Param::DetectorJustifyHorizontal));
    }

    /// §3.18 Whether the monitor was locked out when this was stored.
    pub(crate) const fn lockout(&self) -> bool {
        self.lockout
    }

    /// §3.18/6 Keeps the lockout over Restart and power loss.
    pub(crate) fn set_lockout(&mut self, on: bool) {
        let changed = core::mem::replace(&mut self.lockout, on) != on;
        self.keep(Group::Lockout, changed);
    }

    /// §3.18/8 A start would find the lockout, or its release, as it is now.
    pub(crate) const fn lockout_is_stored(&self) -> bool {
        self.is_kept(Group::Lockout)
    }

    /// §3.4 The values of a parameter that is stored; IncompleteConfig while it is unset.
    pub(crate) fn read<'b>(
        &self,
        param: Param,
        buffer: &'b mut [i32; VALUES_MAX],
    ) -> Result<&'b [i32], Status> {
        let len = match Group::of(param) {
            Group::Program(number) => {
                let program = self.programs.get(usize::from(number)).ok_or(Status::INVALID_ID)?;
                for (value, stored) in buffer.iter_mut().zip(program) {
                    *value = i32::from(*stored);
                }
                program.len()
            }
            Group::Trajectory(number) => {
                let points = self.trajectory(usize::from(number));
                let (chunks, _) = buffer.as_chunks_mut::<4>();
                for (values, point) in chunks.iter_mut().zip(points) {
                    let TrajectoryPoint { horizontal, vertical, distance, dwell } = *point;
                    *values = [horizontal.into(), vertical.into(), distance.into(), dwell.into()];
                }
                points.len() * 4
            }
            // §3.4/3
            _ if param.kind().required && !self.is_set(param) => {
                return Err(Status::INCOMPLETE_CONFIG);
            }
            _ => {
                if let Some(value) = buffer.first_mut() {
                    *value = self.get(param);
                }
                1
            }
        };
        Ok(buffer.get(..len).unwrap_or_default())
    }

    /// §3.5 Takes the values of a parameter whose access and range have been checked.
    ///
    /// Accepted when they will be stored, Ok when they are; IncompleteConfig when the subsystem's
    /// set still misses others: then nothing of it is stored yet.
    pub(crate) fn write(&mut self, param: Param, values: Ints<'_>) -> Status {
        let group = Group::of(param);
        let mut changed = false;
        match group {
            Group::Program(number) => {
                if let Some(program) = self.programs.get_mut(usize::from(number)) {
                    for (stored, value) in program.iter_mut().zip(values.iter().map(saturate)) {
                        changed |= core::mem::replace(stored, value) != value;
                    }
                }
            }
            Group::Trajectory(number) => {
                if let Some(stored) = self.trajectories.get_mut(usize::from(number)) {
                    let points = stored_points(values);
                    changed = *stored != points;
                    *stored = points;
                }
            }
            _ => {
                if let Some(value) = values.get(0) {
                    changed = !self.is_set(param) || self.get(param) != value;
                    self.put(param, value);
                }
            }
        }
        let owner = param.subsystem();
        self.update_incomplete();
        self.end_stand_in();
        // §3.5/6
        if self.is_incomplete(owner) {
            return Status::INCOMPLETE_CONFIG;
        }
        // A value with effect after Restart is looked at when the program starts (§3.5/8).
        self.keep(group, changed)
    }

    /// §3.5/1 Queues a group; §3.5/9 unless it is in the memory already.
    fn keep(&mut self, group: Group, changed: bool) -> Status {
        if !changed && self.is_kept(group) {
            return Status::OK;
        }
        self.mark(group);
        Status::ACCEPTED
    }

    const fn is_kept(&self, group: Group) -> bool {
        let never_read = self.absent | self.unread;
        (self.dirty | never_read | self.unwritten) & group.bit() == 0
    }

    /// Every set is complete, and the memory was read and written without errors.
    pub(crate) const fn is_sound(&self) -> bool {
        self.incomplete == 0 && self.unread | self.unwritten == 0
    }

    /// §3.3.1/2 General's set is missing, and the memory is not blank: it was damaged, or erased in part. What is
    /// blank has its default address on purpose (§3.19/3).
    pub(crate) fn has_lost_general(&self) -> bool {
        const ALL: u32 = u32::MAX >> (u32::BITS - Group::COUNT as u32);
        // A lockout may be stored before any set.
        let is_blank = self.absent | Group::Lockout.bit() == ALL;
        self.is_incomplete(SubsystemId::GENERAL) && !is_blank
    }

    /// §3.3.1 ConfigInvalid: parameters of this subsystem are still unset.
    pub fn is_incomplete(&self, id: SubsystemId) -> bool {
        self.incomplete & owner_bit(id) != 0
    }

    /// §3.3.1/2 General's set is lost at the start: address and composition are those that are compiled in, which
    /// may be another monitor's.
    pub(crate) const fn stand_in(&mut self, address: u8, chain: ChainSet) {
        self.stand_in = Some((address, chain));
    }

    /// §3.3.1/2 Whether address and composition in force may be another monitor's: until General's set is
    /// complete, and says the same or has taken effect.
    pub const fn is_stand_in(&self) -> bool {
        self.stand_in.is_some()
    }

    fn end_stand_in(&mut self) {
        let [address, chain] = [Param::GeneralAddress, Param::GeneralChain].map(|it| self.get(it));
        let said = (address as u8, ChainSet::from_bits(chain as u16));
        if !self.is_incomplete(SubsystemId::GENERAL) && self.stand_in == Some(said) {
            self.stand_in = None;
        }
    }

    /// §3.3.1/2 Values are checked one by one; those that contradict each other show here.
    pub fn is_contradictory(&self, id: SubsystemId) -> bool {
        let exceeds = |low, high| self.get(low) > self.get(high);
        match id {
            SubsystemId::GENERAL => {
                exceeds(Param::GeneralMainVoltageMin, Param::GeneralMainVoltageMax)
            }
            SubsystemId::CLIMATICS => exceeds(Param::ClimaticsHeatOn, Param::ClimaticsHeatOff),
            _ => false,
        }
    }

    /// §3.3.1 ConfigFault: stored parameters of this subsystem could not be read.
    pub fn has_read_fault(&self, id: SubsystemId) -> bool {
        self.unread & Group::owned_by(id) != 0
    }

    /// §3.3.1 ConfigWriteFault: parameters of this subsystem could not be stored.
    pub fn has_write_fault(&self, id: SubsystemId) -> bool {
        self.unwritten & Group::owned_by(id) != 0
    }

    /// Whether everything accepted has been stored, or tried in vain.
    pub const fn is_stored(&self) -> bool {
        self.dirty == 0
    }

    /// §3.3.1/4 Stores the lockout alone, or its release, if that has changed.
    pub(crate) fn flush_lockout(&mut self, now: Millis, storage: &mut impl Storage) {
        if self.dirty & Group::Lockout.bit() != 0 {
            // It is the first.
            self.flush(now, storage);
        }
    }

    /// §3.12/4 Before a Restart what failed is tried once more.
    pub(crate) fn flush_all(&mut self, now: Millis, storage: &mut impl Storage) {
        self.dirty |= self.unwritten;
        while !self.is_stored() {
            self.flush(now, storage);
        }
    }

    /// §3.3.1/1 What could not be stored is tried again a minute later, once.
    pub(crate) fn poll_retry(&mut self, now: Millis) {
        if self.retry_in.poll(now) {
            self.dirty |= self.unwritten;
        }
    }

    /// Stores one changed group: the lockout first, the numbers of a subsystem behind its programs
    /// and trajectories, so that a set which was interrupted (§3.5/6) is still incomplete.
    pub(crate) fn flush(&mut self, now: Millis, storage: &mut impl Storage) {
        let Some(index) = self.dirty.checked_ilog2() else { return };
        let group = Group::from_index(index as u8);
        self.dirty &= !group.bit();
        match self.store(group, storage) {
            Ok(()) => {
                self.unwritten &= !group.bit();
                self.unread &= !group.bit();
                self.absent &= !group.bit();
            }
            // §3.3.1/1
            Err(_) => {
                self.unwritten |= group.bit();
                self.retry_in.start(now, RETRY_MS);
            }
        }
    }

    fn store(&self, group: Group, storage: &mut impl Storage) -> Result<(), StorageError> {
        let mut buffer = [0; VALUE_MAX];
        let len = self.encode(group, &mut buffer).ok_or(StorageError::Write)?;
        storage.store(group.key(), buffer.get(..len).unwrap_or_default())
    }

    /// Bytes of a group, CRC-16 at the end.
    #[inline(never)]
    fn encode(&self, group: Group, buffer: &mut [u8; VALUE_MAX]) -> Option<usize> {
        let mut out = Sink { buffer, len: 0 };
        match group {
            Group::Subsystem(_) => {
                for param in Param::of(group.owner()).filter(|param| is_number(*param)) {
                    if self.is_set(param) {
                        out.put(&param.id().0.to_le_bytes())?;
                        out.put(&self.get(param).to_le_bytes())?;
                    }
                }
            }
            Group::Program(number) => {
                for value in self.programs.get(usize::from(number))? {
                    out.put(&value.to_le_bytes())?;
                }
            }
            Group::Trajectory(number) => {
                for point in self.trajectory(usize::from(number)) {
                    out.put(&point.to_bytes())?;
                }
            }
            Group::Correction => {
                for correction in self.correction {
                    out.put(&correction.to_le_bytes())?;
                }
            }
            Group::Lockout => out.put(&[u8::from(self.lockout)])?,
        }
        let crc = crc16(out.written());
        out.put(&crc.to_le_bytes())?;
        Some(out.len)
    }

    #[inline(never)]
    fn decode(&mut self, group: Group, value: &[u8]) -> Option<()> {
        let (bytes, crc) = value.split_last_chunk()?;
        if crc16(bytes) != u16::from_le_bytes(*crc) {
            return None;
        }
        match group {
            Group::Subsystem(_) => {
                for [i0, i1, v0, v1, v2, v3] in bytes.as_chunks().0 {
                    let id = lafet_proto::ParamId(u16::from_le_bytes([*i0, *i1]));
                    let value = i32::from_le_bytes([*v0, *v1, *v2, *v3]);
                    if let Some(param) = Param::find(group.owner(), id)
                        && param.kind().check(Ints::Values(&[value]).iter()).is_ok()
                    {
                        self.put(param, value);
                    }
                }
            }
            Group::Program(number) => {
                let program = self.programs.get_mut(usize::from(number))?;
                for (stored, bytes) in program.iter_mut().zip(bytes.as_chunks().0) {
                    *stored = i16::from_le_bytes(*bytes);
                }
            }
            Group::Trajectory(number) => {
                let stored = self.trajectories.get_mut(usize::from(number))?;
                let (points, _) = bytes.as_chunks();
                for (point, bytes) in stored.points.iter_mut().zip(points) {
                    *point = TrajectoryPoint::from_bytes(*bytes);
                }
                stored.len = points.len().min(POINTS) as u8;
            }
            Group::Correction => {
                for (correction, byte) in self.correction.iter_mut().zip(bytes) {
                    *correction = i8::from_le_bytes([*byte]);
                }
            }
            Group::Lockout => self.lockout = bytes != [0],
        }
        Some(())
    }

    fn put(&mut self, param: Param, value: i32) {
        if let Some(place) = self.values.get_mut(param as usize) {
            *place = value;
        }
        if let Some(word) = self.set.get_mut(param as usize / 32) {
            *word |= 1 << (param as usize % 32);
        }
    }

    fn is_set(&self, param: Param) -> bool {
        let word = self.set.get(param as usize / 32).copied().unwrap_or_default();
        word >> (param as usize % 32) & 1 != 0
    }

    fn mark(&mut self, group: Group) {
        self.dirty |= group.bit();
    }

    /// Finds the subsystems whose set is not complete; those that become so are marked with all
    /// they own.
    fn update_incomplete(&mut self) {
        let before = self.incomplete;
        self.incomplete = 0;
        for param in Param::ALL {
            if param.kind().required && !self.is_set(param) {
                self.incomplete |= owner_bit(param.subsystem());
            }
        }
        // §3.5/6
        let completed = before & !self.incomplete;
        for index in 0..Group::COUNT {
            let group = Group::from_index(index);
            let holds = matches!(group, Group::Subsystem(_) | Group::Program(_))
                || matches!(group, Group::Trajectory(_));
            if holds && completed & owner_bit(group.owner()) != 0 {
                self.mark(group);
            }
        }
    }
}

/// A parameter that is stored as one number.
fn is_number(param: Param) -> bool {
    let spec = param.kind();
    spec.storage == param::Storage::Stored && spec.max_len == 1
}

fn owner_bit(id: SubsystemId) -> u16 {
    table_index(id).map_or(0, |index| 1 << index)
}

fn saturate(value: i32) -> i16 {
    value.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

fn stored_points(values: Ints<'_>) -> Stored {
    let mut stored = Stored::BLANK;
    let mut values = values.iter();
    for point in &mut stored.points {
        let (Some(horizontal), Some(vertical), Some(distance), Some(dwell)) =
            (values.next(), values.next(), values.next(), values.next())
        else {
            break;
        };
        *point = TrajectoryPoint {
            horizontal: saturate(horizontal),
            vertical: saturate(vertical),
            distance: u8::try_from(distance).unwrap_or(u8::MAX),
            dwell: u8::try_from(dwell).unwrap_or(u8::MAX),
        };
        stored.len += 1;
    }
    stored
}

struct Sink<'a> {
    buffer: &'a mut [u8; VALUE_MAX],
    len: usize,
}

impl Sink<'_> {
    fn put(&mut self, bytes: &[u8]) -> Option<()> {
        let end = self.len + bytes.len();
        let space = self.buffer.get_mut(self.len..end)?;
        space.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
        self.len = end;
        Some(())
    }

    fn written(&self) -> &[u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_shows_the_points_it_has() {
        let shown = std::format!("{:?}", stored_points(Ints::Values(&[70, -8, 40_000, 3])));
        let point = TrajectoryPoint { horizontal: 70, vertical: -8, distance: 255, dwell: 3 };
        assert_eq!(shown, std::format!("[{point:?}]"));
    }
}
