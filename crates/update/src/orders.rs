//! The orders of a client, as [`lafet_device::Device`] passes them on.

use crate::hash::Hash;
use crate::receive::{Phase, Receiver};
use crate::refusal::Refusal;
use embedded_storage::nor_flash::NorFlash;
use lafet_device::hal::Software;
use lafet_proto::update::{self, Order};

// The wire has the sizes of an image.
const _: () = assert!(update::HEADER_LEN == crate::HEADER_LEN && update::UNIT == crate::UNIT);

impl<F: NorFlash> Receiver<'_, F> {
    fn note(&mut self, result: Result<(), Refusal>) {
        self.reason = result.err().map_or(0, Refusal::code);
    }
}

impl<F: NorFlash> Software for Receiver<'_, F> {
    fn perform(&mut self, order: &Order<'_>) {
        let result = match order {
            Order::Begin { header, digest } => {
                self.begin(header, Hash(**digest), self.pressed).map(drop)
            }
            Order::Data { offset, part } => self.data(*offset, part).map(drop),
            Order::Verify => self.verify(),
            Order::Commit { digest } => self.commit(Hash(**digest)),
            Order::Confirm { word } => self.confirm(word.as_slice()),
            Order::Abandon { digest } => self.abandon(Hash(**digest)),
            Order::State => return,
        };
        self.note(result);
    }

    fn poll(&mut self) {
        if let Err(refusal) = Receiver::poll(self) {
            self.note(Err(refusal));
        }
    }

    fn report(&self) -> update::Report {
        let report = Receiver::report(self);
        update::Report {
            phase: match report.phase {
                Phase::Idle => update::Phase::IDLE,
                Phase::Receiving => update::Phase::RECEIVING,
                Phase::Verifying => update::Phase::VERIFYING,
                Phase::Verified => update::Phase::VERIFIED,
                Phase::Committed => update::Phase::COMMITTED,
            },
            slot: report.started.slot.code(),
            trial: report.started.trial,
            failed: report.failed,
            waits: false,
            pending: report.pending,
            lost: report.lost,
            reason: self.reason,
            received: report.received,
            size: report.size,
            version: report.started.version.0,
            image: report.image,
        }
    }

    fn hash(&self) -> [u8; 32] {
        self.running.0
    }
}
