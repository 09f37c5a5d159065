//! Update of the software (ours; docs/update.md): who may, when, and what is answered.
//!
//! `handle` keeps one order, `step` has the board carry it out: a request never touches the flash.

use crate::answers::Answers;
use crate::device::Device;
use crate::hal::Hal;
use crate::image::ValveNo;
use crate::params::VALUES_MAX;
use crate::subsystem::general::Reset;
use crate::time::Millis;
use lafet_proto::answer::Reply;
use lafet_proto::param::Param;
use lafet_proto::update::{KEY, ORDER_MAX, Order, Phase, Report};
use lafet_proto::{Answer, Expected, Record, Status, SubsystemId};

/// How long an image on trial waits to be confirmed before it restarts, which leads back to the old
/// one, ms.
pub const TRIAL_MS: u32 = 180_000;
/// An image on trial is not confirmed before it has run for so long, ms: one that crashes soon after its
/// start must not be the active one by then.
pub const PROVEN_MS: u32 = 10_000;

/// What the monitor knows of the update of its software.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Updating {
    /// As of the last step; `None` without a board that updates.
    report: Option<Report>,
    /// Of what is running, as at the start.
    hash: [u8; 32],
    /// The order that the next step carries out.
    held: [u8; ORDER_MAX],
    held_len: u8,
    /// The last order was not carried out, as the monitor was no longer in a state for it.
    dropped: bool,
    on_trial_ms: u32,
}

impl Default for Updating {
    fn default() -> Self {
        Self {
            report: None,
            hash: [0; 32],
            held: [0; ORDER_MAX],
            held_len: 0,
            dropped: false,
            on_trial_ms: 0,
        }
    }
}

/// §U/9 A parameter that a monitor without the update does not have.
pub(crate) const fn is_of_it(param: Param) -> bool {
    matches!(
        param,
        Param::GeneralSoftwareVersion | Param::GeneralSoftwareSlot | Param::GeneralSoftwareHash
    )
}

impl Updating {
    pub(crate) const fn is_present(&self) -> bool {
        self.report.is_some()
    }

    pub(crate) fn is_on_trial(&self) -> bool {
        self.report.is_some_and(|report| report.trial)
    }

    /// Before it is confirmed, what is on trial may not move anything; nor may a monitor that a later
    /// start would put on trial.
    pub(crate) fn keeps_locked(&self) -> bool {
        self.report.is_some_and(|report| report.trial || report.pending)
    }

    fn report(&self) -> Report {
        let report = Report { waits: self.held_len > 0, ..self.report.unwrap_or_default() };
        let reason = if self.dropped { Report::NOT_READY } else { report.reason };
        Report { reason, ..report }
    }

    /// §U/9 The values of one of its parameters; `None` without a board that updates.
    pub(crate) fn read<'b>(
        &self,
        param: Param,
        buffer: &'b mut [i32; VALUES_MAX],
    ) -> Option<&'b [i32]> {
        let report = self.report?;
        let mut put = |values: &mut dyn Iterator<Item = i32>| {
            buffer.iter_mut().zip(values).fold(0, |len, (place, value)| {
                *place = value;
                len + 1
            })
        };
        let len = match param {
            Param::GeneralSoftwareVersion => put(&mut report.version.into_iter().map(i32::from)),
            Param::GeneralSoftwareHash => {
                put(&mut self.hash.as_chunks().0.iter().copied().map(i32::from_be_bytes))
            }
            _ => put(&mut core::iter::once(report.slot.into())),
        };
        buffer.get(..len)
    }

    fn hold(&mut self, data: &[u8]) {
        if data.len() > self.held.len() {
            return;
        }
        // `copy_from_slice` may be linked with a panic, where it is not inlined.
        for (to, from) in self.held.iter_mut().zip(data) {
            *to = *from;
        }
        self.held_len = data.len() as u8;
    }
}

impl Device {
    /// Standby, locked out and so at the next start, everything closed and at rest, on a good supply.
    fn may_update(&self) -> bool {
        let stowed = !self.has(SubsystemId::DEPLOYER) || self.deployer.is_wrapped();
        let mut valves = self.valves.iter().zip(&ValveNo::ALL);
        let closed = valves.all(|(valve, no)| !self.has(no.id()) || valve.is_closed());
        // What turns though it is not fed would turn again after the restart, which ends the cut.
        let turns = self.drives.iter().any(|drive| drive.is_moving() || drive.output().cut);
        let rests = self.outputs().is_still() && !turns && !self.general.has_bad_power();
        let stored = self.params.lockout() && self.params.lockout_is_stored();
        self.general.is_locked() && stored && stowed && closed && rests
    }

    /// Answers an order. It passes the lockout, as it requires it.
    #[inline(never)]
    pub(crate) fn update(&mut self, record: &Record<'_>, answers: &mut Answers<'_>) {
        let Record { request, device: to, data, .. } = *record;
        let general = SubsystemId::GENERAL;
        match to {
            SubsystemId::GENERAL => {}
            SubsystemId::ALL | SubsystemId::MOTORS => {
                return answers.bare(general, request, Status::WRONG_REQUEST);
            }
            to if self.has(to) => return answers.bare(to, request, Status::WRONG_REQUEST),
            to => return answers.bare(to, request, Status::MODULE_NOT_EXIST),
        }
        if !answers.has_room(general, request, lafet_proto::update::REPORT_LEN) {
            return;
        }
        let status = match Order::decode(data) {
            Ok((order, key)) => self.take_order(&order, key, data),
            Err(error) if error.expected == Expected::Size => {
                return answers.bare(general, request, Status::WRONG_DATA);
            }
            Err(_) => Status::INVALID_VALUE,
        };
        let bytes = self.software.report().to_bytes();
        answers.push(&Answer { from: general, request, status, data: Reply::Raw(&bytes) });
    }

    fn take_order(&mut self, order: &Order<'_>, key: u16, data: &[u8]) -> Status {
        let report = self.software.report();
        let misplaced = match order {
            Order::State => return Status::OK,
            Order::Data { offset, .. } => {
                report.phase != Phase::RECEIVING || *offset != report.received
            }
            Order::Abandon { .. } => !report.trial,
            _ => false,
        };
        let ends = matches!(order, Order::Abandon { .. });
        let confirms = matches!(order, Order::Confirm { .. });
        let early = confirms && report.trial && self.software.on_trial_ms < PROVEN_MS;
        if key != KEY {
            Status::NEED_CONFIRM
        } else if self.general.is_restarting() || report.waits || early {
            Status::BUSY
        } else if !ends && !self.may_update() {
            Status::DENIED
        } else if misplaced {
            Status::INVALID_VALUE
        } else {
            self.software.hold(data);
            Status::ACCEPTED
        }
    }

    /// What is on trial stays locked out until it is confirmed.
    pub(crate) fn wake_software(&mut self, hal: &mut impl Hal) {
        if let Some(software) = hal.software() {
            self.software.report = Some(software.report());
            self.software.hash = software.hash();
        }
        if self.software.keeps_locked() {
            self.general.set_locked(true);
        }
    }

    /// Carries out what was accepted, and restarts what has been committed or was not confirmed.
    pub(crate) fn step_software(&mut self, now: Millis, dt_ms: u32, hal: &mut impl Hal) {
        let waits = self.software.held_len > 0;
        let restarting = self.general.is_restarting();
        let ready = waits && self.may_update() && !restarting;
        let Updating { report, held, held_len, dropped, on_trial_ms, hash: _ } = &mut self.software;
        let Some(software) = hal.software() else {
            (*report, *held_len) = (None, 0);
            return;
        };
        let order = held.get(..usize::from(*held_len)).unwrap_or_default();
        let order = Order::decode(order).ok().map(|(order, _)| order);
        *held_len = 0;
        let ends = matches!(order, Some(Order::Abandon { .. }));
        if let Some(order) = order {
            // What is wrong with a bad image may be its state.
            *dropped = !(ready || ends && !restarting);
            if !*dropped {
                software.perform(&order);
            }
        }
        let abandoned = ends && !*dropped && software.report().reason == 0;
        software.poll();
        let seen = software.report();
        *on_trial_ms = match seen.trial {
            true if abandoned => TRIAL_MS,
            true => on_trial_ms.saturating_add(dt_ms),
            false => 0,
        };
        let over = seen.phase == Phase::COMMITTED || *on_trial_ms >= TRIAL_MS;
        *report = Some(seen);
        if over && !restarting {
            self.general.schedule(now, Reset::Restart);
        }
    }
}
