//! How clients come to the machine, however many they are: few threads wait for it.
//!
//! ```text
//!  a Stop, a client's first no ──┬─▶ the machine, if it is free
//!                                └─▶ noes that wait ─▶ the next turn, which comes at once
//!  a no that is repeated ──────────▶ an equal one that waits ─▶ the next look at the monitors
//!  everything else ────────────────▶ one after the other; noes that wait go before it
//! ```
//!
//! A no makes orders void before any of that. One that joins an equal one is carried out by what is done after it
//! has come, as an urgent request joins a frame that is not sent yet.

use std::sync::Mutex;

use lafet_site::{Entry, Event, Hand};
use tokio::sync::{Semaphore, SemaphorePermit, watch};

use super::no::No;
use super::view::ZonesView;
use super::{Machine, Zones};
use crate::control::authority::HTTP_LOST;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::sync::{lock, lock_if_free};

/// Noes that wait at the same time, so that a Stop waits among them; of more, a Stop waits for the machine.
const WAITING_MAX: usize = 1024;

/// What waits for the machine.
#[derive(Debug)]
pub(super) struct Waiting {
    nos: Mutex<Vec<Waits>>,
    /// Held by the client that is at the machine.
    turn: Semaphore,
}

/// A no that waits.
#[derive(Debug)]
struct Waits {
    caller: Caller,
    order: Hand,
    /// It repeats nothing.
    first: bool,
    no: No,
    outcome: watch::Sender<Option<Outcome>>,
}

type Outcome = Result<ZonesView, ApiError>;

impl Default for Waiting {
    fn default() -> Self {
        Self { nos: Mutex::default(), turn: Semaphore::new(1) }
    }
}

impl Waiting {
    /// Puts a no among those that wait; a repetition joins one that is equal, of any client.
    fn join(&self, waits: Waits) -> watch::Receiver<Option<Outcome>> {
        let mut nos = lock(&self.nos);
        let equal = nos.iter().find(|it| !waits.first && it.order == waits.order);
        if let Some(equal) = equal {
            let outcome = equal.outcome.subscribe();
            // The equal one is under way still: what is kept is ordered again behind it.
            drop(waits);
            return outcome;
        }
        let outcome = waits.outcome.subscribe();
        nos.push(waits);
        outcome
    }

    /// Takes those that wait; not `all`: without repetitions.
    fn take(&self, all: bool) -> Vec<Waits> {
        let mut nos = lock(&self.nos);
        let (taken, left) = std::mem::take(&mut *nos).into_iter().partition(|it| all || it.first);
        *nos = left;
        taken
    }

    fn len(&self) -> usize {
        lock(&self.nos).len()
    }
}

impl Waits {
    fn new(caller: &Caller, order: &Hand, first: bool, no: No) -> Self {
        let outcome = watch::Sender::new(None);
        Self { caller: caller.clone(), order: order.clone(), first, no, outcome }
    }
}

impl Zones {
    /// Whether an order is a no of this site. What a stranger invents is none.
    fn is_no(&self, order: &Hand) -> bool {
        match order {
            Hand::Abort { zone } => self.config.site.zones.iter().any(|it| it.id == *zone),
            Hand::Lockout { on } => *on,
            _ => false,
        }
    }
}

impl Hub {
    /// Held by a client while it is at the machine of the zones: the next one waits without a thread.
    pub async fn turn_at_zones(&self) -> Option<SemaphorePermit<'_>> {
        self.zones()?.waiting.turn.acquire().await.ok()
    }

    /// Carries out a person's order, of many that many clients give.
    ///
    /// # Errors
    ///
    /// 404 without zones or for a name that is not configured, 409 with the reason of the machine.
    pub async fn order_zones_in_turn(&self, caller: &Caller, order: Hand) -> Outcome {
        let zones = self.known_zones()?;
        if zones.is_no(&order) {
            return self.say_no(zones, caller, order).await;
        }
        let _turn = self.turn_at_zones().await;
        self.order_zones(caller, order)
    }

    /// Carries out a no: at once, or with an equal one.
    async fn say_no(&self, zones: &Zones, caller: &Caller, order: Hand) -> Outcome {
        let no = zones.void_by_hand(&order);
        let first = !self.is_repeated_no(caller, &order);
        if first && let Some(mut machine) = lock_if_free(&zones.machine) {
            self.carry_nos(zones, &mut machine, false);
            let done = self.carry_hand(zones, &mut machine, caller, &order, first);
            self.no_is_over(zones, &mut machine, no);
            return done.map(|()| machine.view(self.now(), !zones.is_failing()));
        }
        let mut outcome = zones.waiting.join(Waits::new(caller, &order, first, no));
        if first {
            zones.wake.notify_one();
        }
        let mut shutdown = self.shutdown();
        let done = tokio::select! {
            done = outcome.wait_for(Option::is_some) => done.ok().and_then(|it| it.clone()),
            // No turn follows.
            () = shutdown.requested() => None,
        };
        match done {
            Some(outcome) => outcome,
            None => self.order_zones(caller, order),
        }
    }

    /// Gives the machine a no whose sender waits for nothing. A repetition (no `news`) is one only where the one before
    /// does not last any more: a reset may have come between.
    pub(super) fn refuse(&self, zones: &Zones, caller: &Caller, order: Hand, news: bool) {
        let no = zones.void_by_hand(&order);
        let mut machine = match lock_if_free(&zones.machine) {
            Some(machine) => machine,
            None if zones.waiting.len() < WAITING_MAX => {
                drop(zones.waiting.join(Waits::new(caller, &order, news, no)));
                if news {
                    zones.wake.notify_one();
                }
                return;
            }
            None => zones.machine(),
        };
        self.carry_nos(zones, &mut machine, false);
        // The machine refuses no Stop.
        _ = self.carry_hand(zones, &mut machine, caller, &order, news);
        self.no_is_over(zones, &mut machine, no);
    }

    /// Carries out the noes that wait; not `all`: without repetitions.
    pub(super) fn carry_nos(&self, zones: &Zones, machine: &mut Machine, all: bool) {
        for Waits { caller, order, first, no, outcome } in zones.waiting.take(all) {
            let done = self.carry_hand(zones, machine, &caller, &order, first);
            self.no_is_over(zones, machine, no);
            if outcome.receiver_count() > 0 {
                let done = done.map(|()| machine.view(self.now(), !zones.is_failing()));
                outcome.send_replace(Some(done));
            }
        }
    }

    /// Carries out a person's order; a no that is not the `first` repeats one.
    pub(super) fn carry_hand(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        order: &Hand,
        first: bool,
    ) -> Result<(), ApiError> {
        let event = Event::Hand { by: caller.principal.user.clone(), order: order.clone() };
        let records = match order {
            Hand::Stop(scope) | Hand::Close(scope) if !first && machine.site.is_refused(scope) => {
                return Ok(());
            }
            Hand::Abort { .. } | Hand::Lockout { on: true } if !first => {
                self.take_again(zones, machine, caller, &event)
            }
            _ => self.take(zones, machine, caller, &event),
        };
        let refused = records.into_iter().find_map(|record| match record.entry {
            Entry::Refused { why, .. } => Some(why),
            _ => None,
        });
        match (refused, order) {
            (Some(why), _) => return Err(ApiError::zone_refused(why)),
            // Its holder has to come back: one that is gone holds nothing.
            (None, Hand::Hold { zone, on: true }) => {
                machine.holds.insert(zone.clone(), self.now() + HTTP_LOST);
            }
            (None, Hand::Hold { zone, on: false }) => _ = machine.holds.remove(zone),
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use axum::http::StatusCode;
    use futures_util::FutureExt as _;
    use futures_util::future::join_all;
    use lafet_site::Phase;
    use tokio::time::timeout;

    use super::super::hall::{ends, hall};
    use super::*;

    fn anna() -> Caller {
        Caller { via: "http", ..Caller::hub() }
    }

    fn phase(view: &ZonesView) -> Phase {
        view.state.zones[0].phase
    }

    #[tokio::test]
    async fn a_stop_does_not_wait_for_the_machine_and_goes_before_what_follows() {
        let hub = hall();
        let released = hub.order_zones(&anna(), Hand::Release { zone: "hall".into() }).unwrap();
        assert!(matches!(phase(&released), Phase::Released { .. }));
        let zones = hub.zones().unwrap();
        let machine = zones.machine();
        for _ in 0..3 {
            ends(&hub, |hub| hub.refuse_everywhere(&anna(), true));
            ends(&hub, |hub| hub.refuse_everywhere(&anna(), false));
        }
        assert_eq!(zones.waiting.len(), 3, "repetitions join the first");
        drop(machine);
        let view = hub.order_zones(&anna(), Hand::Silence).unwrap();
        assert!(matches!(phase(&view), Phase::Ended(_)), "{:?}", phase(&view));
        assert_eq!(zones.waiting.len(), 0);
    }

    fn abort(zone: &str) -> Hand {
        Hand::Abort { zone: zone.to_owned() }
    }

    #[tokio::test]
    async fn a_first_no_that_waits_is_carried_out_by_the_next_turn() {
        let (hub, anna) = (hall(), anna());
        let zones = hub.zones().unwrap();
        let mut said = Box::pin(hub.order_zones_in_turn(&anna, abort("hall")));
        {
            let _machine = zones.machine();
            assert!((&mut said).now_or_never().is_none(), "the machine is taken");
        }
        timeout(Duration::ZERO, zones.wake.notified()).await.expect("a turn is called for");
        hub.turn(zones);
        assert!(said.now_or_never().expect("it is carried out").is_ok());
    }

    #[tokio::test]
    async fn equal_noes_that_are_repeated_are_carried_out_together() {
        let (hub, anna) = (hall(), anna());
        let zones = hub.zones().unwrap();
        hub.order_zones_in_turn(&anna, abort("hall")).await.unwrap();
        let turns = async {
            assert_eq!(zones.waiting.len(), 1, "they wait together");
            hub.turn(zones);
            assert_eq!(zones.waiting.len(), 1, "they wait for the next look at the monitors");
            zones.machine().hurries = true;
            hub.turn(zones);
        };
        let all = join_all((0..50).map(|_| hub.order_zones_in_turn(&anna, abort("hall"))));
        let both = async { tokio::join!(all, turns) };
        let (all, ()) = timeout(Duration::from_secs(20), both).await.expect("all are answered");
        assert!(all.iter().all(Result::is_ok));
        let refused = hub.order_zones_in_turn(&anna, abort("attic")).await.unwrap_err();
        assert_eq!(refused.status, StatusCode::NOT_FOUND);
        assert_eq!(zones.waiting.len(), 0, "an invented name waits with none");
    }

    #[tokio::test]
    async fn clients_wait_for_each_other_without_a_thread() {
        let (hub, anna) = (hall(), anna());
        let turn = hub.turn_at_zones().await.expect("zones");
        let mut silence = Box::pin(hub.order_zones_in_turn(&anna, Hand::Silence));
        let early = timeout(Duration::from_millis(50), &mut silence).await;
        assert!(early.is_err(), "it is another one's turn");
        let no = hub.order_zones_in_turn(&anna, Hand::Lockout { on: true }).await;
        assert!(no.unwrap().state.lockout, "a no waits for no turn");
        drop(turn);
        assert!(silence.await.is_ok());
    }
}
