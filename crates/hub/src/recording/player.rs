//! Frames, or the history, back to what the topics of the WebSocket were.

use std::collections::BTreeMap;

use lafet_capture::{Captured, Direction, Note, Piece};
use lafet_client::AnswerBuf;
use lafet_proto::RequestId;
use lafet_proto::answer::Reply;
use lafet_proto::bus::MONITORS;
use lafet_proto::link::{Decoder, Frame};
use lafet_proto::record::Records;
use serde_json::{Map, Value, json};

use super::{SCENE, Whose};
use crate::alarms::{Alarms, Conditions};
use crate::api::show_frame;
use crate::model::{self, Status, Subsystems};
use crate::text::{Both, both};

/// A state that is as it was is told this often.
const RENEW_MS: u64 = 1000;
/// A monitor that has not told its state for so long is not heard any more.
const STALE_MS: u64 = 2500;

/// Plays a recording.
#[derive(Debug, Default)]
pub struct Player {
    /// Frames are told as well.
    pub frames: bool,
    /// A value holds until another one comes, however long that takes.
    pub values_hold: bool,
    whose: Whose,
    names: BTreeMap<String, Both>,
    monitors: BTreeMap<String, Heard>,
    alarms: Alarms,
    /// Everything as it is.
    all: BTreeMap<String, Value>,
    line: Line,
}

/// What is known of a monitor.
#[derive(Debug, Default)]
struct Heard {
    status: Status,
    told_ms: u64,
    limits: Map<String, Value>,
}

/// A line that is being made.
#[derive(Debug, Default)]
struct Line {
    at_ms: u64,
    set: BTreeMap<String, Value>,
    gone: Vec<String>,
    frames: Vec<Value>,
}

impl Player {
    /// Plays frames of monitors with these addresses and names.
    pub fn new(whose: Whose, names: BTreeMap<String, Both>) -> Self {
        Self { whose, names, ..Self::default() }
    }

    /// A piece of a recording. What is complete before it is returned.
    pub fn piece(&mut self, piece: &Piece) -> Option<String> {
        match piece {
            Piece::Captured(captured) => self.captured(captured),
            Piece::Note(note) => self.note(note),
        }
    }

    fn note(&mut self, note: &Note) -> Option<String> {
        let line = self.time(note.at_ns / 1_000_000);
        if note.topic == SCENE
            && let Ok(scene) = serde_json::from_str(&note.json)
        {
            self.set(SCENE, scene);
        }
        line
    }

    fn captured(&mut self, piece: &Captured) -> Option<String> {
        let at_ms = piece.at_ns / 1_000_000;
        let line = self.time(at_ms);
        let out = piece.direction == Direction::ToMonitor;
        frames(piece, |frame| {
            let Some(address) = monitor_of(frame) else { return };
            let monitor = name_of(&self.whose, address);
            if self.frames {
                let verdict = if out { "sent" } else { "heard" };
                let sent = MONITORS.contains(&frame.dst);
                self.line.frames.push(show_frame(&monitor, at_ms, sent, verdict, frame));
            }
            if MONITORS.contains(&frame.src) {
                self.answers(at_ms, &monitor, address, frame.payload);
            }
        });
        line
    }

    fn answers(&mut self, at_ms: u64, monitor: &str, address: u8, payload: &[u8]) {
        let answers: Vec<AnswerBuf> =
            Records::new(payload).map_while(Result::ok).map(|it| AnswerBuf::new(&it)).collect();
        let told =
            |id| answers.iter().filter(move |it| it.request() == id && it.status().is_success());
        let limits =
            told(RequestId::RETRIEVE_LIMITS).filter_map(|it| match it.decode().ok()?.data {
                Reply::Limits(limits) => {
                    Some((it.from().to_string(), json!({ "min": limits.min, "max": limits.max })))
                }
                _ => None,
            });
        let limits: Vec<(String, Value)> = limits.collect();
        if !limits.is_empty() {
            let heard = self.monitors.entry(monitor.to_owned()).or_default();
            heard.limits.extend(limits);
            let limits = Value::Object(heard.limits.clone());
            self.set(&format!("monitors/{monitor}/limits"), limits);
        }
        for answer in answers.iter().filter(|it| it.status().is_success()) {
            let hotbeds = answer.decode().ok().and_then(|it| Some(it.hotbeds()?.collect()));
            if let Some::<Vec<_>>(hotbeds) = hotbeds {
                let value = model::hotbeds(at_ms, &hotbeds);
                self.set(&format!("monitors/{monitor}/hotbeds"), value);
            }
        }
        let states = model::subsystems(told(RequestId::GET_STATUS), &Subsystems::new());
        if !states.is_empty() {
            let heard = self.monitors.entry(monitor.to_owned()).or_default();
            let mut subsystems = heard.status.subsystems.clone();
            subsystems.extend(states);
            let status = Status { at_ms: Some(at_ms), subsystems, ..Status::default() };
            self.status(at_ms, monitor, Some(address), status);
        }
    }

    /// The state of a monitor.
    pub fn status(&mut self, at_ms: u64, monitor: &str, address: Option<u8>, status: Status) {
        let heard = self.monitors.entry(monitor.to_owned()).or_default();
        let first = heard.told_ms == 0;
        let same =
            heard.status.subsystems == status.subsystems && heard.status.stale == status.stale;
        let told_ms = heard.told_ms;
        heard.status = status.clone();
        if same && !first && at_ms.saturating_sub(told_ms) < RENEW_MS {
            return;
        }
        heard.told_ms = at_ms;
        let topic = |part: &str| format!("monitors/{monitor}/{part}");
        if first {
            let name = self.names.get(monitor).cloned().unwrap_or_else(|| both(monitor, monitor));
            let info = json!({ "id": monitor, "name": name, "address": address });
            self.set(&topic("info"), info);
        }
        self.set(&topic("status"), json!(status));
        let up = !status.stale;
        self.set(&topic("link"), json!({ "state": if up { "up" } else { "down" } }));
        self.set(&topic("readiness"), json!(model::readiness(&status, up, false)));
        let changes = self.alarms.observe(at_ms, monitor, &status, true);
        self.alarms_changed(changes);
    }

    fn alarms_changed(&mut self, changes: Vec<crate::alarms::Change>) {
        for change in changes {
            let topic = format!("alarms/{}", change.id);
            match self.alarms.get(&change.id) {
                Some(alarm) => {
                    let alarm = json!(alarm);
                    self.set(&topic, alarm);
                }
                None => {
                    self.all.remove(&topic);
                    self.line.set.remove(&topic);
                    self.line.gone.push(topic);
                }
            }
        }
    }

    fn set(&mut self, topic: &str, value: Value) {
        if self.all.get(topic) != Some(&value) {
            self.all.insert(topic.to_owned(), value.clone());
            self.line.gone.retain(|gone| gone != topic);
            self.line.set.insert(topic.to_owned(), value);
        }
    }

    /// Time has passed: what is complete is returned.
    pub fn time(&mut self, at_ms: u64) -> Option<String> {
        if at_ms == self.line.at_ms {
            return None;
        }
        let line = self.take();
        self.line.at_ms = at_ms;
        let silent = |heard: &Heard| {
            let last_ms = heard.status.at_ms.unwrap_or(0);
            !heard.status.stale && at_ms.saturating_sub(last_ms) > STALE_MS
        };
        let silent: Vec<(String, Status)> = self
            .monitors
            .iter()
            .filter(|(_, heard)| !self.values_hold && heard.told_ms > 0 && silent(heard))
            .map(|(name, heard)| (name.clone(), Status { stale: true, ..heard.status.clone() }))
            .collect();
        for (monitor, status) in silent {
            self.status(at_ms, &monitor, None, status);
        }
        let changes = self.alarms.handle_time(at_ms, Conditions::default());
        self.alarms_changed(changes);
        line
    }

    /// The line that was being made, unless it says nothing.
    pub fn take(&mut self) -> Option<String> {
        let line = std::mem::take(&mut self.line);
        self.line.at_ms = line.at_ms;
        if line.set.is_empty() && line.gone.is_empty() && line.frames.is_empty() {
            return None;
        }
        let mut value = json!({ "at_ms": line.at_ms, "set": line.set });
        if !line.gone.is_empty() {
            value["gone"] = json!(line.gone);
        }
        if self.frames {
            value["frames"] = json!(line.frames);
        }
        Some(value.to_string() + "\n")
    }

    /// Everything as it is now, as the first line; what was being made is part of it.
    pub fn everything(&mut self, at_ms: u64) -> String {
        let frames = std::mem::take(&mut self.line).frames;
        self.line.at_ms = at_ms;
        let mut value = json!({ "at_ms": at_ms, "set": self.all });
        if self.frames {
            value["frames"] = json!(frames);
        }
        value.to_string() + "\n"
    }
}

/// The frames of a piece.
pub fn frames(piece: &Captured, mut take: impl FnMut(&Frame<'_>)) {
    let mut decoder: Box<Decoder> = Box::default();
    let mut rest = &piece.bytes[..];
    while !rest.is_empty() {
        let (taken, frame) = decoder.push_slice(rest);
        if let Some(frame) = frame {
            take(&frame);
        }
        rest = rest.get(taken..).unwrap_or_default();
    }
}

/// The monitor that a frame comes from or goes to.
pub fn monitor_of(frame: &Frame<'_>) -> Option<u8> {
    [frame.src, frame.dst].into_iter().find(|address| MONITORS.contains(address))
}

/// What a monitor is called.
pub fn name_of(whose: &Whose, address: u8) -> String {
    whose.get(&address).cloned().unwrap_or_else(|| format!("A{address}"))
}
