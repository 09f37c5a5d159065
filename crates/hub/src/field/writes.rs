//! The half of a bus that writes.

use std::time::Duration;

use super::bus::{Asked, Bus};
use super::drive::{Drives, Job, Order, Report, Urgency};
use super::line::Link;
use super::view::ModbusOutput;
use super::wire::{Asks, Failure, Framing, Request};
use super::write::Write;
use crate::clock::ms;
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::sync::lock;

/// The exception of a device that does not know a function.
const NO_FUNCTION: u8 = 1;

impl Bus {
    /// Takes an order for an output; `false`: it is not on this bus.
    pub fn order(&self, id: &str, order: Order) -> bool {
        let is_here = lock(&self.drive).order(id, order);
        if is_here {
            self.wake.notify_one();
        }
        is_here
    }

    /// Ends when something more urgent has to be written.
    pub(super) async fn more_urgent(&self, hub: &Hub, than: Urgency) {
        while !self.has_more_urgent(hub, than) {
            self.wake.notified().await;
        }
    }

    pub(super) fn has_more_urgent(&self, hub: &Hub, than: Urgency) -> bool {
        let next = lock(&self.drive).next(hub.now());
        next.is_some_and(|job| job.urgency < than && !job.again)
    }

    /// Writes what is due, and reads it back.
    pub(super) async fn write(&self, hub: &Hub, link: &mut Link, job: Job) -> Asked {
        let mut asked = Asked { answered: true, alive: false, ended: false, interrupted: false };
        let outcome = self.write_value(hub, link, &job).await;
        let failure = outcome.as_ref().err();
        let void = matches!(outcome, Ok(false));
        if !void {
            lock(&self.drive).wrote(hub.now(), &job, failure);
        }
        match failure {
            None => asked.alive = !void,
            Some(Failure::Exception(_)) => asked.alive = true,
            Some(failure) => asked.ended = failure.ends(self.config.line.framing()),
        }
        asked.interrupted = void || matches!(failure, Some(Failure::GivenUp));
        if asked.alive && failure.is_none() && lock(&self.drive).is_read_back(&job) {
            self.read_back(hub, link, &job).await;
        }
        asked
    }

    /// Whether it was written: a job that is void by now is not.
    async fn write_value(&self, hub: &Hub, link: &mut Link, job: &Job) -> Result<bool, Failure> {
        let Some(target) = lock(&self.drive).target(job) else { return Ok(false) };
        let (unit, table, address) = (job.unit, target.table, target.address);
        let before = match target.is_part() {
            true => {
                let read = Request { unit, table, first: address, count: 1 };
                let values = self.exchange(hub, link, &read, job.urgency).await?;
                values.first().copied().unwrap_or_default()
            }
            false => 0,
        };
        let value = target.value(job.on, before);
        // The answer to a write of one value is its echo, which an adapter of a serial line makes too.
        let serial = self.config.line.framing() == Framing::Rtu;
        let usual = lock(&self.many).get(&unit).copied().unwrap_or(serial);
        let read_back = lock(&self.drive).is_read_back(job);
        for many in [usual, !usual] {
            link.settle(unit).await?;
            // Time has passed, and orders have come.
            if !lock(&self.drive).is_current(job, hub.now()) {
                return Ok(false);
            }
            let write = Write { unit, table, address, value, many };
            match self.exchange(hub, link, &write, job.urgency).await {
                Err(Failure::Exception(NO_FUNCTION))
                    if many == usual && (!many || read_back || !serial) => {}
                outcome => {
                    if outcome.is_ok() {
                        lock(&self.many).insert(unit, many);
                    }
                    return outcome.map(|_| true);
                }
            }
        }
        Err(Failure::Exception(NO_FUNCTION))
    }

    async fn read_back(&self, hub: &Hub, link: &mut Link, job: &Job) {
        let Some(target) = lock(&self.drive).target(job) else { return };
        let (unit, table, first) = (job.unit, target.table, target.address);
        let read = Request { unit, table, first, count: 1 };
        if let Ok(values) = self.exchange(hub, link, &read, job.urgency).await
            && let Some(value) = values.first()
        {
            lock(&self.drive).read(hub.now(), unit, (table, first), *value);
        }
    }

    /// Asks, and counts what came of it.
    pub(super) async fn exchange(
        &self,
        hub: &Hub,
        link: &mut Link,
        request: &dyn Asks,
        urgency: Urgency,
    ) -> Result<Vec<u16>, Failure> {
        let patience = Duration::from_millis(self.config.timeout_ms);
        let urgent = self.more_urgent(hub, urgency);
        let outcome = match link.settle(request.unit()).await {
            Ok(()) => link.exchange(request, patience, urgent).await,
            Err(failure) => Err(failure),
        };
        self.count(hub, request.unit(), outcome.as_ref().err(), link.late());
        outcome
    }

    /// Reports to the zones what is news of the outputs.
    pub(super) fn report_outputs(&self, hub: &Hub) {
        let reports = lock(&self.drive).reports(hub.now());
        for Report { output, on, trouble } in reports {
            let Some(config) = self.config.outputs.get(output) else { continue };
            let caller = Caller::modbus(&self.config.name, config.unit);
            let is_pump = config.drives == Drives::Pump;
            let fault = trouble.map(|it| it.map(super::drive::Trouble::of_path));
            hub.output_reports(&caller, &config.id, is_pump, on, fault);
            if let Some(Some(trouble)) = trouble {
                hub.event(None, &self.output_words(config, trouble));
            }
        }
    }

    /// The outputs as clients see them.
    pub(super) fn outputs_view(&self, now: Now) -> Vec<ModbusOutput> {
        let drive = lock(&self.drive);
        let age = |at: Now| ms(now.saturating_sub(at));
        let view = |it: &super::drive::Output| ModbusOutput {
            id: it.config.id.clone(),
            drives: it.config.drives,
            unit: it.config.unit,
            wanted: it.wanted.map(|order| order.on),
            written: it.written.map(|(_, on)| on),
            written_ms_ago: it.written.map(|(at, _)| age(at)),
            read_back: it.read_back(),
            feedback: it.feedback(),
            read_ms_ago: it.read_at().map(age),
            trouble: drive.trouble(it, now),
        };
        drive.outputs.iter().map(view).collect()
    }
}
