//! Changes of authority over a monitor, and what they mean for others.

use std::sync::Arc;

use lafet_texts::{Text as _, hub as text};
use serde::Serialize;

use super::{Caller, Hub};
use crate::access::Role;
use crate::control::authority::{Notice, REASON_MAX, Refusal};
use crate::error::ApiError;
use crate::monitor::station::Station;
use crate::monitor::view::Control;
use crate::publish::messages::Message;
use crate::store::Act;
use crate::sync::lock;
use crate::words::LossWord;

impl Hub {
    /// Changes the authority over a monitor, as a client asks.
    ///
    /// # Errors
    ///
    /// 403 without the role, 409 while another client holds the monitor or its software is updated, 400 for an unknown action or
    /// a reason that is too long.
    pub fn change_authority(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        action: &str,
        reason: Option<&str>,
    ) -> Result<Control, ApiError> {
        let needs = if action == "force" { Role::Engineer } else { Role::Operator };
        if caller.principal.role < needs || !caller.principal.is_good() {
            return Err(ApiError::role(needs));
        }
        self.count_request(&caller.principal)?;
        if reason.is_some_and(|reason| reason.chars().count() > REASON_MAX) {
            return Err(ApiError::bad_request(
                text::ReasonTooLong { reason_max: REASON_MAX }.words(),
            ));
        }
        if matches!(action, "take" | "request" | "force") {
            station.refuse_while_updated(caller)?;
        }
        let (now, seat, id) = (self.now(), caller.seat.clone(), station.id());
        let result = {
            let mut authority = lock(&station.authority);
            match action {
                "take" => authority.take(now, seat),
                "release" => authority.release(now, &seat.seat),
                "request" => authority.ask(now, seat),
                "grant" => authority.grant(now, &seat.seat),
                "deny" => authority.deny(&seat.seat),
                "force" => authority.force(now, seat, reason.unwrap_or_default()),
                _ => {
                    let action = crate::error::shown(action);
                    let list = "take, release, request, grant, deny, force";
                    return Err(ApiError::bad_request(
                        text::ActionUnknown { action, list }.words(),
                    ));
                }
            }
        };
        let outcome = match &result {
            Ok(_) => "Ok",
            Err(Refusal::Held(_) | Refusal::NotHolder(_)) => "held",
            Err(_) => "refused",
        };
        let act = Act::Authority { action: action.into(), reason: reason.map(str::to_owned) };
        let record = self.record(caller, id, &format!("authority {action}"), outcome);
        let record = match reason {
            Some(reason) => record.with(&Forced { reason }),
            None => record,
        };
        drop(self.audit().note(record.about(&act)));
        let notices = result.map_err(|refusal| ApiError::authority(id, refusal))?;
        self.notices(station, notices);
        Ok(station.control(self))
    }

    /// Carries out the consequences of a change of authority: motions end, clients are notified.
    pub fn notices(&self, station: &Arc<Station>, notices: Vec<Notice>) {
        for notice in notices {
            let monitor = station.id().to_owned();
            match notice {
                Notice::Asked { holder, by } => {
                    let until_ms = self.clock().now_ms() + 10_000;
                    self.send_to(&holder.seat, &Message::Asked { monitor, by, until_ms });
                }
                Notice::Lost { seat, how, by, reason } => {
                    station.let_go(&seat.seat);
                    self.forget_seat(&seat.seat);
                    if how == LossWord::Expired {
                        let user = &seat.user;
                        let text = text::ControlExpired { monitor: station.id(), user }.words();
                        self.event(Some(station.id()), &text);
                    }
                    if how != LossWord::Released {
                        let message = Message::AuthorityLost { monitor, how, by, reason };
                        self.send_to(&seat.seat, &message);
                    }
                }
                Notice::Granted(seat) => {
                    self.send_to(&seat.seat, &Message::AuthorityGranted { monitor });
                }
                Notice::Denied(seat) => {
                    self.send_to(&seat.seat, &Message::AuthorityDenied { monitor });
                }
            }
        }
        station.publish_authority(self);
    }

    /// Releases monitors whose holder is gone, hands over those that were requested.
    pub fn handle_timeouts(&self) {
        let now = self.now();
        for station in self.stations() {
            // Before the next holder has the monitor: none of these Stops ends what that one begins.
            let lost = lock(&station.authority).expired(now).cloned();
            if let Some(lost) = lost {
                self.halt_for_lost(&station, &lost);
            }
            let notices = lock(&station.authority).handle_timeout(now);
            if !notices.is_empty() {
                self.notices(&station, notices);
            }
        }
    }
}

/// Details of the entry of a change of authority.
#[derive(Debug, Serialize)]
struct Forced<'a> {
    reason: &'a str,
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::control::authority::Seat;

    #[tokio::test(start_paused = true)]
    async fn the_drives_of_a_lost_holder_are_stopped_before_the_next_one_commands() {
        let (hub, station) = Hub::of_one(None);
        let holder = hub.connect(&Caller::hub().principal, "", None);
        let seat = Seat { seat: holder.seat.clone(), ..Caller::hub().seat };
        lock(&station.authority).take(hub.now(), seat).unwrap();
        lock(&station.authority).ask(hub.now(), Caller::hub().seat).unwrap();
        hub.disconnect(&holder);
        hub.handle_timeouts();
        assert_eq!(station.urgent_count(), 0, "it may come back");
        tokio::time::advance(Duration::from_millis(hub.config().lost_ms)).await;
        hub.handle_timeouts();
        let next = lock(&station.authority).holder().map(|(seat, _)| seat.seat.clone());
        // Nothing else has had its turn meanwhile.
        assert_eq!((next.as_deref(), station.urgent_count()), (Some("hub"), 3));
    }

    /// Assumed: the link to the monitor is lost together with its holder, as with a switch that starts again.
    #[tokio::test(start_paused = true)]
    async fn drives_are_stopped_until_the_monitor_answers_or_another_holds_it() {
        let (hub, station) = Hub::of_one(None);
        let holder = hub.connect(&Caller::hub().principal, "", None);
        let seat = Seat { seat: holder.seat.clone(), ..Caller::hub().seat };
        lock(&station.authority).take(hub.now(), seat.clone()).unwrap();
        hub.disconnect(&holder);
        tokio::time::advance(Duration::from_millis(hub.config().lost_ms)).await;
        hub.handle_timeouts();
        assert!(lock(&station.authority).holder().is_none());
        let stops = async |seconds| {
            let before = station.urgent_counts().stop;
            tokio::time::sleep(Duration::from_secs(seconds)).await;
            station.urgent_counts().stop - before
        };
        assert!(
            (21..=33).contains(&stops(10).await),
            "each of three drives, once more each second"
        );
        lock(&station.authority).take(hub.now(), Seat { seat: "next".into(), ..seat }).unwrap();
        stops(2).await;
        assert_eq!(stops(60).await, 0, "they are another's drives now");
    }
}
