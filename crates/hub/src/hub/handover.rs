//! Changes of authority over a monitor, and what they mean for others.

use std::sync::Arc;

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, hub as text};
use serde::Serialize;

use super::{Caller, Hub};
use crate::access::Role;
use crate::command::request::MonitorRequest;
use crate::control::authority::{Notice, REASON_MAX, Refusal, Seat};
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
    /// 403 without the role, 409 while another client holds the monitor, 400 for an unknown action or
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
                        self.expired(station, &seat);
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

    /// The holder did not come back: drives moved by hand are stopped. Programs, search and
    /// deployment refuse that Stop and go on (§3.2).
    fn expired(&self, station: &Arc<Station>, seat: &Seat) {
        let text = text::ControlExpired { monitor: station.id(), user: &seat.user }.words();
        self.event(Some(station.id()), &text);
        let hub = self.clone();
        let (station, caller) = (station.clone(), Caller::hub());
        tokio::spawn(async move {
            for drive in [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE] {
                if let Ok(request) = MonitorRequest::stop(drive) {
                    _ = hub.urgent(&caller, &station, &request).result().await;
                }
            }
        });
    }

    /// Releases monitors whose holder is gone, hands over those that were requested.
    pub fn handle_timeouts(&self) {
        let now = self.now();
        for station in self.stations() {
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
