//! Motions by hand of a monitor: from beats to its drives, and what their clients and the audit log get.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use lafet_client::{Drive, Hold, JogEnd, Monitor, Reason, Toward};
use lafet_proto::SubsystemId;
use lafet_proto::status::DriveStatus;
use lafet_texts::{Shown, Text as _, hub as text};
use serde::Serialize;
use tokio::sync::mpsc;

use super::jogs::{Heard, Turn};
use crate::command::NUMBERED;
use crate::command::keep_out::Passed;
use crate::command::request::MonitorRequest;
use crate::command::withdrawn::Accepted;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::publish::messages::Message;
use crate::store::{Act as Noted, JogEnding};
use crate::sync::lock;
use crate::text::Both;
use crate::words::{MotionEnd, MotionWord};

/// A beat of a motion by hand.
#[derive(Clone, Copy, Debug)]
pub struct Beat {
    /// The drive that moves.
    pub drive: SubsystemId,
    /// The direction.
    pub toward: Toward,
    /// When it was sent.
    pub heard: Heard,
}

impl Station {
    /// Ends all motions of a seat.
    pub fn let_go(&self, seat: &str) {
        lock(&self.jogs).let_go(seat);
    }

    /// Ends a seat's motion of a drive.
    pub fn end_jog(&self, seat: &str, drive: SubsystemId) {
        lock(&self.jogs).end(&(seat.to_owned(), drive));
    }

    /// Takes a beat of a client that may command; returns the state of the motion.
    pub fn beat(
        self: &Arc<Self>,
        hub: &Hub,
        caller: &Caller,
        beat: Beat,
    ) -> Result<MotionWord, ApiError> {
        let accepted = self.accepts_motion();
        let monitor = Monitor::new(self.client()?);
        let drive = match beat.drive {
            SubsystemId::VERTICAL => monitor.vertical(),
            SubsystemId::HORIZONTAL => monitor.horizontal(),
            SubsystemId::NOZZLE => monitor.nozzle(),
            _ => {
                return Err(ApiError::bad_request(text::JogAxes.words()));
            }
        };
        // Asked after `accepted`: what comes between the two is met when the motion starts.
        let armed = self.accepts(&MonitorRequest::moving(beat.drive)?);
        let key = (caller.seat.seat.clone(), beat.drive);
        let turn = lock(&self.jogs).beat(hub.now(), key, beat.toward, beat.heard, armed);
        match turn {
            Turn::Said(state) => Ok(state),
            Turn::Late => Err(ApiError::late_beat()),
            Turn::Start(number, beats) => {
                self.start(hub, caller, &drive, beat, (number, beats, accepted))
            }
        }
    }

    fn start(
        self: &Arc<Self>,
        hub: &Hub,
        caller: &Caller,
        drive: &Drive,
        beat: Beat,
        (number, mut beats, accepted): (u64, mpsc::Receiver<()>, Accepted),
    ) -> Result<MotionWord, ApiError> {
        hub.count_request(&caller.principal)?;
        let speed = hub.simulated().map_or(1.0, |simulation| simulation.speed());
        let sending = lock(&self.sending);
        if self.accepts_motion() != accepted {
            return Err(ApiError::void());
        }
        let (no_farther, passed) = hub.bound_by_keep_outs(self, beat.drive, beat.toward)?;
        let clock_permille = (speed * 1000.0) as u32;
        let hold = Hold { clock_permille, no_farther, ..Hold::default() };
        let mut jog = match drive.jog_with(beat.toward, hold) {
            Ok(jog) => jog,
            Err(error) => {
                passed.into_iter().for_each(Passed::refused);
                return Err(ApiError::from(&error));
            }
        };
        self.begun.moved(beat.drive);
        drop(sending);
        let way = if beat.toward == Toward::Max { "max" } else { "min" };
        let what = format!("jog {} {way}", beat.drive);
        let drive = beat.drive;
        let act = move |end| Noted::Jog { drive: drive.to_string(), toward: way.into(), end };
        let record = hub.record(caller, self.id(), &what, "asked");
        let asked = hub.audit().note(record.about(&act(None)));
        hub.counts().jogs.fetch_add(1, Ordering::Relaxed);
        self.interrupt_tuning(caller);
        hub.other_sent(self);
        let (hub, caller, station) = (hub.clone(), caller.clone(), self.clone());
        tokio::spawn(async move {
            station.tell_jog(&hub, &caller, beat.drive, MotionWord::Moving, None);
            let end = loop {
                let renewed = tokio::select! {
                    beat = beats.recv() => beat,
                    end = jog.ended() => break end,
                };
                if renewed.is_some() {
                    jog.renew();
                } else {
                    station.tell_jog(&hub, &caller, beat.drive, MotionWord::Stopping, None);
                    break jog.release().await;
                }
            };
            passed.into_iter().for_each(|it| it.jogged(&end));
            station.jog_ended(&hub, &caller, beat.drive, number, &end);
            let record = hub.record(&caller, station.id(), &what, end_word(&end).name());
            // Long since stored, unless the disk takes nothing: then it is not waited for.
            let asked = tokio::time::timeout(NUMBERED, asked).await.ok().and_then(Result::ok);
            let record = record.with(&JogDetails { asked });
            drop(hub.audit().note(record.about(&act(Some(ending(&end))))));
        });
        Ok(MotionWord::Moving)
    }

    fn jog_ended(&self, hub: &Hub, caller: &Caller, drive: SubsystemId, number: u64, end: &JogEnd) {
        let key = (caller.seat.seat.clone(), drive);
        lock(&self.jogs).ended(hub.now(), &key, number);
        self.tell_jog(hub, caller, drive, MotionWord::Ended, Some(end));
    }

    fn tell_jog(
        &self,
        hub: &Hub,
        caller: &Caller,
        drive: SubsystemId,
        state: MotionWord,
        end: Option<&JogEnd>,
    ) {
        let message = Message::Jog {
            monitor: self.id().to_owned(),
            drive: drive.to_string(),
            state,
            end: end.map(end_word),
            text: end.and_then(end_text),
        };
        hub.send_to(&caller.seat.seat, &message);
    }
}

/// Details of the entry of the end of a motion by hand: the number of that of its beginning.
#[derive(Debug, Serialize)]
struct JogDetails {
    asked: Option<u64>,
}

/// How a motion ended, as the audit log has it.
fn ending(end: &JogEnd) -> JogEnding {
    let at = |status: &DriveStatus| status.position;
    match end {
        JogEnd::Stopped { reason, status } => {
            JogEnding::Stopped { reason: why(reason).into(), position: at(status) }
        }
        JogEnd::Standing(status) => JogEnding::Standing { position: at(status) },
        JogEnd::Refused(error) => {
            JogEnding::Refused { error: error.to_string(), text: end_text(end) }
        }
        JogEnd::Replaced => JogEnding::Replaced,
        JogEnd::TakenOver { by } => JogEnding::TakenOver { by: by.to_string() },
        JogEnd::StillMoving(status) => JogEnding::StillMoving { position: at(status) },
        JogEnd::Unknown(error) => {
            JogEnding::Unknown { error: error.to_string(), text: end_text(end) }
        }
        _ => JogEnding::Unknown { error: String::new(), text: end_text(end) },
    }
}

const fn why(reason: &Reason) -> &'static str {
    match reason {
        Reason::Released => "released",
        Reason::Lapsed => "lapsed",
        Reason::LinkLost => "link_lost",
        Reason::Refused => "refused",
        Reason::StopAsked => "stop_asked",
        _ => "unknown",
    }
}

const fn end_word(end: &JogEnd) -> MotionEnd {
    match end {
        JogEnd::Stopped { .. } => MotionEnd::Stopped,
        JogEnd::Standing(_) => MotionEnd::Standing,
        JogEnd::Refused(_) => MotionEnd::Refused,
        JogEnd::Replaced => MotionEnd::Replaced,
        JogEnd::TakenOver { .. } => MotionEnd::TakenOver,
        JogEnd::StillMoving(_) => MotionEnd::StillMoving,
        JogEnd::Unbounded(_) => MotionEnd::Unbounded,
        _ => MotionEnd::Unknown,
    }
}

/// What people have to know of an end; nothing of the usual one.
fn end_text(end: &JogEnd) -> Option<Both> {
    match end {
        JogEnd::Refused(error) | JogEnd::Unknown(error) => Some(error.words()),
        JogEnd::TakenOver { by } => Some(text::JogTakenOver { by: Shown(by) }.words()),
        JogEnd::StillMoving(_) => Some(text::JogStillMoving.words()),
        JogEnd::Unbounded(_) => Some(text::JogUnbounded.words()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use lafet_client::Error;

    use super::*;

    #[test]
    fn an_end_in_the_log_has_its_reason_in_every_language() {
        for end in [JogEnd::Refused(Error::Closed), JogEnd::Unknown(Error::Closed)] {
            let stored = serde_json::to_value(ending(&end)).unwrap();
            let (en, ru) = (stored["text"]["en"].as_str(), stored["text"]["ru"].as_str());
            assert_eq!(en, stored["error"].as_str());
            assert!(ru.is_some_and(|ru| ru.chars().any(|c| ('а'..='я').contains(&c))), "{stored}");
        }
    }
}
