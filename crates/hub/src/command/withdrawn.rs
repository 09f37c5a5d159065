//! What a Stop, Close or Lockout undoes that was accepted before it and is not sent yet.
//!
//! A command waits for its entry in the audit log before it goes to the client of its monitor; an urgent
//! request does not. What arrives meanwhile is counted here, and compared right before the command is sent.

use std::collections::BTreeMap;
use std::sync::Mutex;

use lafet_client::RequestBuf;
use lafet_proto::RequestId;
use tokio::time::Instant;

use super::request::MonitorRequest;
use crate::monitor::program::begins;
use crate::monitor::station::Station;
use crate::monitor::view::UrgentCounts;
use crate::sync::lock;

/// Urgent requests to a monitor so far, by their bytes, and when each came last: few, as they are the names of
/// its subsystems.
#[derive(Debug, Default)]
pub struct Withdrawn(Mutex<BTreeMap<RequestBuf, (u64, Instant)>>);

/// A request was accepted after so many urgent ones that undo its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accepted(pub(crate) u64);

impl Station {
    /// To be noted when a request is read, before anything is waited for.
    pub fn accepts(&self, request: &MonitorRequest) -> Accepted {
        let all = lock(&self.withdrawn.0);
        let undo = all.iter().filter(|(urgent, _)| undoes(urgent, request.buf()));
        Accepted(undo.map(|(_, (count, _))| count).sum())
    }

    /// The same of a motion by hand, which any of them ends.
    pub fn accepts_motion(&self) -> Accepted {
        Accepted(self.urgent_count())
    }

    /// Urgent requests so far, of any kind and from anywhere.
    pub fn urgent_count(&self) -> u64 {
        lock(&self.withdrawn.0).values().map(|(count, _)| count).sum()
    }

    /// The same by kind.
    pub fn urgent_counts(&self) -> UrgentCounts {
        let mut counts = UrgentCounts::default();
        for (urgent, (count, _)) in lock(&self.withdrawn.0).iter() {
            match urgent.id() {
                RequestId::CLOSE => counts.close += count,
                RequestId::LOCKOUT => counts.lockout += count,
                _ => counts.stop += count,
            }
        }
        counts
    }

    /// Whether something that undoes a request has come since this moment: a request that was under way then
    /// is older, whenever it arrives.
    pub fn is_undone_since(&self, request: &MonitorRequest, since: Instant) -> bool {
        let all = lock(&self.withdrawn.0);
        all.iter().any(|(urgent, (_, at))| *at >= since && undoes(urgent, request.buf()))
    }

    /// Whether nothing has come since that undoes it. Asked while [`Station::sending`] is held.
    pub(super) fn still_accepts(&self, request: &MonitorRequest, accepted: Accepted) -> bool {
        self.accepts(request) == accepted
    }

    /// An urgent request has come. What is not in the queue of the client from here on never gets
    /// there; what is in it is taken out by the client.
    pub(super) fn withdraw(&self, urgent: &MonitorRequest) {
        self.withdraw_if(urgent, || true);
    }

    /// The same, if it is still to come: what is let pass later gets to the line later, so nothing can begin between the
    /// question and the request.
    pub(super) fn withdraw_if(
        &self,
        urgent: &MonitorRequest,
        comes: impl FnOnce() -> bool,
    ) -> bool {
        let _one = lock(&self.sending);
        if !comes() {
            return false;
        }
        let now = Instant::now();
        let mut all = lock(&self.withdrawn.0);
        let (count, at) = all.entry(urgent.buf().clone()).or_insert((0, now));
        (*count, *at) = (*count + 1, now);
        true
    }
}

/// As the client has it; besides, a program opens the valve by itself after a Close.
fn undoes(urgent: &RequestBuf, other: &RequestBuf) -> bool {
    urgent.supersedes(other) || (urgent.id() == RequestId::CLOSE && begins(other.id()))
}

#[cfg(test)]
mod tests {
    use std::future::{Future as _, poll_fn};
    use std::pin::pin;
    use std::task::Poll;

    use lafet_proto::SubsystemId;

    use super::*;
    use crate::hub::{Caller, Hub};

    fn request(text: &str) -> MonitorRequest {
        MonitorRequest::parse(text).unwrap()
    }

    /// What was accepted before an urgent request, and what after it.
    #[tokio::test]
    async fn what_is_urgent_makes_void_what_was_accepted_before_it() {
        let quench = "StartQuench Control centre=0,0 nozzle=60 sector=600,300 step=1 distance=30";
        let (open, up) = ("Open Valve1", "Move Vertical 900");
        for (urgent, undone, kept) in [
            ("Stop All", &[open, up, quench][..], &["SetParam Vertical Speed 5"][..]),
            ("Close Valve1", &[open, quench], &[up, "Open Valve2"]),
            ("Stop Vertical", &[up], &[open, "Move Horizontal 900"]),
            ("Lockout on", &[open, up, quench, "Lockout off"], &["GetStatus General"]),
        ] {
            for (what, code) in undone
                .iter()
                .map(|it| (it, "void"))
                .chain(kept.iter().map(|it| (it, "not_connected")))
            {
                let (hub, station) = Hub::of_one(None);
                let accepted = station.accepts(&request(what));
                drop(hub.overtake(&Caller::hub(), &station, &request(urgent)));
                let caller = Caller::hub();
                let sent = |accepted| {
                    hub.command_accepted(&caller, &station, request(what), (None, false), accepted)
                };
                assert_eq!(sent(accepted).await.unwrap_err().code, code, "{what} before {urgent}");
                let later = station.accepts(&request(what));
                let code = sent(later).await.unwrap_err().code;
                assert_eq!(code, "not_connected", "{what} after {urgent}");
            }
        }
    }

    /// What was sent before it and arrives after it.
    #[tokio::test]
    async fn what_was_under_way_is_undone_by_what_came_meanwhile() {
        let (hub, station) = Hub::of_one(None);
        let (open, up) = (request("Open Valve1"), request("Move Vertical 900"));
        let before = Instant::now();
        let undone = |since| [&open, &up].map(|it| station.is_undone_since(it, since));
        assert_eq!(undone(before), [false; 2]);
        drop(hub.overtake(&Caller::hub(), &station, &request("Close Valve1")));
        assert_eq!(undone(before), [true, false]);
        drop(hub.overtake(&Caller::hub(), &station, &request("Stop All")));
        assert_eq!(undone(before), [true; 2]);
        assert_eq!(undone(Instant::now()), [false; 2], "what was sent after it");
    }

    #[tokio::test]
    async fn any_of_them_ends_a_motion_by_hand() {
        let (hub, station) = Hub::of_one(None);
        for urgent in ["Stop Nozzle", "Close Valve1", "Lockout on", "Stop Nozzle"] {
            let before = station.accepts_motion();
            assert_eq!(station.accepts_motion(), before);
            drop(hub.overtake(&Caller::hub(), &station, &request(urgent)));
            assert_ne!(station.accepts_motion(), before, "{urgent}");
        }
    }

    /// It waits for its entry in the audit log when the Stop arrives.
    #[tokio::test]
    async fn a_stop_meets_a_command_that_waits_for_its_entry() {
        let (hub, station) = Hub::of_one(None);
        let (caller, open) = (Caller::hub(), request("Open Valve1"));
        let mut command = pin!(hub.command(&caller, &station, open, None));
        let waits = poll_fn(|context| Poll::Ready(command.as_mut().poll(context).is_pending()));
        assert!(waits.await);
        let stop = MonitorRequest::stop(SubsystemId::ALL).unwrap();
        drop(hub.overtake(&caller, &station, &stop));
        assert_eq!(command.await.unwrap_err().code, "void");
    }
}
