//! Frames, or the history, back to what the topics of the WebSocket were.

use std::collections::BTreeMap;

use lafet_capture::{Captured, Direction, Note, Piece};
use lafet_client::AnswerBuf;
use lafet_proto::RequestId;
use lafet_proto::answer::Reply;
use lafet_proto::bus::MONITORS;
use lafet_proto::link::{Decoder, Frame};
use lafet_proto::record::Records;
use serde::Serialize;
use serde_json::Value;

use super::{SCENE, Whose};
use crate::alarms::{Alarms, Conditions};
use crate::api::show_frame;
use crate::monitor::status::{self, Status, Subsystems};
use crate::monitor::view::{Bounds, Hotbeds, Info};
use crate::publish::messages::ShownFrame;
use crate::text::Both;
use crate::words::{LinkWord, VerdictWord};

/// An unchanged state is repeated this often.
const RENEW_MS: u64 = 1000;
/// A monitor whose state is older than this is shown as not heard.
const STALE_MS: u64 = 2500;

/// Plays a recording back as topics.
#[derive(Debug, Default)]
pub struct Player {
    /// Also play the frames.
    pub frames: bool,
    /// A value holds until another one comes, however long that takes.
    pub values_hold: bool,
    whose: Whose,
    names: BTreeMap<String, Both>,
    monitors: BTreeMap<String, Heard>,
    alarms: Alarms,
    /// Every topic and its value.
    all: BTreeMap<String, Value>,
    line: Line,
}

/// What is known of a monitor.
#[derive(Debug, Default)]
struct Heard {
    status: Status,
    told_ms: u64,
    limits: BTreeMap<String, Bounds>,
}

/// A line that is being made.
#[derive(Debug, Default)]
struct Line {
    at_ms: u64,
    set: BTreeMap<String, Value>,
    gone: Vec<String>,
    frames: Vec<ShownFrame>,
}

/// What a recording has of a link.
#[derive(Serialize)]
struct HeardLink {
    state: LinkWord,
}

/// A line as it is written.
#[derive(Serialize)]
struct Written<'a> {
    at_ms: u64,
    set: &'a BTreeMap<String, Value>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    gone: &'a [String],
    /// Of a recording that is shown frame by frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<&'a [ShownFrame]>,
}

impl Written<'_> {
    fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }
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
            && let Ok(scene) = serde_json::from_str::<Value>(&note.json)
        {
            self.set(SCENE, &scene);
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
                let verdict = if out { VerdictWord::Sent } else { VerdictWord::Heard };
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
                Reply::Limits(limits) => Some((it.from().to_string(), Bounds::from(limits))),
                _ => None,
            });
        let limits: Vec<(String, Bounds)> = limits.collect();
        if !limits.is_empty() {
            let heard = self.monitors.entry(monitor.to_owned()).or_default();
            heard.limits.extend(limits);
            let limits = heard.limits.clone();
            self.set(&format!("monitors/{monitor}/limits"), &limits);
        }
        for answer in answers.iter().filter(|it| it.status().is_success()) {
            let hotbeds = answer.decode().ok().and_then(|it| Some(it.hotbeds()?.collect()));
            if let Some::<Vec<_>>(hotbeds) = hotbeds {
                let value = Hotbeds::new(at_ms, &hotbeds);
                self.set(&format!("monitors/{monitor}/hotbeds"), &value);
            }
        }
        let states = status::subsystems(told(RequestId::GET_STATUS), &Subsystems::new());
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
            let name = self.names.get(monitor).cloned().unwrap_or_else(|| Both::same(monitor));
            let info = Info { id: monitor.to_owned(), name, address };
            self.set(&topic("info"), &info);
        }
        self.set(&topic("status"), &status);
        let up = !status.stale;
        self.set(
            &topic("link"),
            &HeardLink { state: if up { LinkWord::Up } else { LinkWord::Down } },
        );
        self.set(&topic("readiness"), &status::readiness(&status, up, false));
        let changes = self.alarms.observe(at_ms, monitor, &status, true);
        self.alarms_changed(changes);
    }

    fn alarms_changed(&mut self, changes: Vec<crate::alarms::Change>) {
        for change in changes {
            let topic = format!("alarms/{}", change.id);
            match self.alarms.get(&change.id) {
                Some(alarm) => {
                    let alarm = alarm.clone();
                    self.set(&topic, &alarm);
                }
                None => {
                    self.all.remove(&topic);
                    self.line.set.remove(&topic);
                    self.line.gone.push(topic);
                }
            }
        }
    }

    fn set(&mut self, topic: &str, value: &impl Serialize) {
        let value = serde_json::to_value(value).unwrap_or_default();
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
        let frames = self.frames.then_some(&*line.frames);
        let (set, gone) = (&line.set, &*line.gone);
        Some(Written { at_ms: line.at_ms, set, gone, frames }.text())
    }

    /// Everything as it is now, as the first line; what was being made is part of it.
    pub fn everything(&mut self, at_ms: u64) -> String {
        let frames = std::mem::take(&mut self.line).frames;
        self.line.at_ms = at_ms;
        let frames = self.frames.then_some(&*frames);
        Written { at_ms, set: &self.all, gone: &[], frames }.text()
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
