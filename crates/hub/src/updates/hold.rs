//! A monitor that a run holds: no other client commands it meanwhile, and its authority is free again whatever ends
//! the run.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::control::authority::Seat;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::store::Act;
use crate::sync::lock;

/// Session under which a run holds a monitor, and the source of its requests in the audit log.
pub const UPDATE: &str = "update";

/// The user who has started a run, at the monitors that it updates.
pub fn caller(by: &Caller) -> Caller {
    let seat = Seat { seat: UPDATE.to_owned(), live: true, ..by.seat.clone() };
    Caller { seat, via: UPDATE, ..by.clone() }
}

/// A monitor that is held.
#[derive(Debug)]
pub struct Hold<'a> {
    hub: &'a Hub,
    caller: &'a Caller,
    station: &'a Arc<Station>,
}

impl<'a> Hold<'a> {
    /// Takes a monitor that is free.
    ///
    /// # Errors
    ///
    /// 409: another client holds it.
    pub fn take(
        hub: &'a Hub,
        caller: &'a Caller,
        station: &'a Arc<Station>,
    ) -> Result<Self, ApiError> {
        hub.change_authority(caller, station, "take", None)?;
        station.updated.store(true, Ordering::SeqCst);
        Ok(Self { hub, caller, station })
    }
}

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        let Self { hub, caller, station } = self;
        let released = lock(&station.authority).release(hub.now(), &caller.seat.seat);
        station.updated.store(false, Ordering::SeqCst);
        // Not as a client asks for it: no limit of requests keeps a monitor held.
        let outcome = if released.is_ok() { "Ok" } else { "held" };
        let act = Act::Authority { action: "release".into(), reason: None };
        let record = hub.record(caller, station.id(), "authority release", outcome);
        drop(hub.audit().note(record.about(&act)));
        hub.notices(station, released.unwrap_or_default());
        // Its version and what it was set to on trial.
        station.reread.notify_one();
    }
}

impl Station {
    /// Whether its software is being updated.
    pub fn is_updated(&self) -> bool {
        self.updated.load(Ordering::SeqCst)
    }

    /// Refuses what is ordered while its software is updated, but for the orders of the update.
    ///
    /// # Errors
    ///
    /// 409, `updating`.
    pub fn refuse_while_updated(&self, caller: &Caller) -> Result<(), ApiError> {
        match self.is_updated() && caller.via != UPDATE {
            true => Err(ApiError::updating(self.id())),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::request::MonitorRequest;
    use crate::control::authority::Refusal;
    use crate::words::ControlWord;

    fn state(station: &Station) -> ControlWord {
        lock(&station.authority).state()
    }

    /// What a client asks for while a run holds the monitor, and after it.
    #[tokio::test]
    async fn others_have_stop_and_nothing_else() {
        let (hub, station) = Hub::of_one(None);
        let client = Caller { via: "ws", ..Caller::hub() };
        let run = caller(&client);
        let hold = Hold::take(&hub, &run, &station).unwrap();
        let request = |text: &str| MonitorRequest::parse(text).unwrap();
        for what in
            ["Move Vertical 10", "Open Valve1", "SetParam Vertical Speed 5", "Lockout All off"]
        {
            let refused = hub.command(&client, &station, request(what), Some("M1")).await;
            assert_eq!(refused.unwrap_err().code, "updating", "{what}");
        }
        for action in ["take", "request", "force"] {
            let refused = hub.change_authority(&client, &station, action, Some("for a test"));
            assert_eq!(refused.unwrap_err().code, "updating", "{action}");
        }
        assert_eq!(hub.may_jog(&client, &station).unwrap_err().code, "updating");
        assert_eq!(hub.tune(&client, &station, "Vertical").unwrap_err().code, "updating");
        // Nothing is connected: what is let through says so.
        for what in ["Stop All", "Close Valve1", "Lockout All on", "GetStatus All"] {
            let sent = hub.command(&client, &station, request(what), None).await;
            assert_eq!(sent.unwrap_err().code, "not_connected", "{what}");
        }
        let own = hub.command(&run, &station, request("Lockout All off"), Some("M1")).await;
        assert_eq!(own.unwrap_err().code, "not_connected");
        assert_eq!(state(&station), ControlWord::Held);
        drop(hold);
        assert_eq!((state(&station), station.is_updated()), (ControlWord::Free, false));
        hub.change_authority(&client, &station, "take", None).unwrap();
        let error = Hold::take(&hub, &run, &station).unwrap_err();
        assert_eq!(error.code, ApiError::authority("M1", Refusal::Held(client.seat)).code);
        assert!(!station.is_updated());
    }

    /// A task that ends by a panic does not keep its monitor.
    #[tokio::test]
    async fn whatever_ends_a_run_its_monitor_is_free() {
        let (hub, station) = Hub::of_one(None);
        let (own, held) = (hub.clone(), station.clone());
        let ended = tokio::spawn(async move {
            let run = caller(&Caller::hub());
            let _hold = Hold::take(&own, &run, &held).unwrap();
            panic!("as a test");
        });
        assert!(ended.await.is_err());
        assert_eq!((state(&station), station.is_updated()), (ControlWord::Free, false));
    }
}
