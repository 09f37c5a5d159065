//! When two states of the device are one: its `Debug` text, read while it is written.
//!
//! The text names every field of every part, so nothing that is added to the device can be forgotten
//! here: it counts until it is named below. Moments are taken relative to now.

use std::fmt::{self, Debug, Write};
use std::hash::{DefaultHasher, Hasher};

/// Fields that decide nothing, wherever they stand.
///
/// The composition and the clock of the last step are the same in all states of a run. The
/// interfaces keep only when somebody last asked (§3.3.9), and climate is not modelled.
const IGNORED: &[&str] =
    &["chain", "address", "outputs", "climatics", "external_conn", "radio", "last_step", "crash"];

/// Fields that are set anew before they are next looked at, while their part is at rest.
const DORMANT: &[Dormant] = &[
    Dormant { part: "Drive", field: "goal", at_rest: "Hold", ignored: &["cause", "speed_cap_tenths"] },
    Dormant {
        part: "Control",
        field: "state",
        at_rest: "Idle",
        ignored: &[
            "task",
            "data",
            "nozzle",
            "nozzle_kept",
            "nozzle_goal",
            "approach",
            "aim",
            "basis",
            "solver",
            "interval",
            "unsuited",
            "rising",
        ],
    },
    Dormant { part: "Detector", field: "state", at_rest: "Idle", ignored: &["approach", "silence"] },
];

/// Nothing in the device looks further back than this, ms (§3.3.6: steady pressure).
const PAST_MS: i32 = 2000;

/// While `field` of `part` says `at_rest`, `ignored` decide nothing.
struct Dormant {
    part: &'static str,
    field: &'static str,
    at_rest: &'static str,
    ignored: &'static [&'static str],
}

/// What in a device decides how it goes on.
pub fn of(device: &impl Debug, now_ms: u32) -> u64 {
    let mut reader = Reader::new(now_ms);
    write!(reader, "{device:?}").expect("the reader takes everything");
    let mut hasher = DefaultHasher::new();
    hasher.write(&reader.kept);
    hasher.finish()
}

/// The text that is kept, for those who look for the difference between two states.
pub fn text(device: &impl Debug, now_ms: u32) -> String {
    let mut reader = Reader::new(now_ms);
    write!(reader, "{device:?}").expect("the reader takes everything");
    String::from_utf8_lossy(&reader.kept).into_owned()
}

/// Follows derived `Debug` text: `Part { field: value, … }`, `Variant(value)`, `[value, …]`.
struct Reader {
    now_ms: u32,
    kept: Vec<u8>,
    /// What may turn out to be the name of a field or a part.
    word: String,
    open: Vec<Level>,
    /// The next number is a moment.
    moment: bool,
    /// Nothing counts until the field at this depth ends.
    mute: Option<usize>,
}

/// What has been opened: a brace, a parenthesis or a bracket.
#[derive(Default)]
struct Level {
    braces: bool,
    dormant: Option<&'static Dormant>,
    /// The value that is read says whether it is at rest.
    telling: bool,
    asleep: bool,
}

impl Reader {
    fn new(now_ms: u32) -> Self {
        Self {
            now_ms,
            kept: Vec::with_capacity(16 * 1024),
            word: String::new(),
            open: Vec::with_capacity(16),
            moment: false,
            mute: None,
        }
    }

    fn is_ignored(&self, field: &str) -> bool {
        let asleep = |level: &Level| {
            level.asleep && level.dormant.is_some_and(|dormant| dormant.ignored.contains(&field))
        };
        IGNORED.contains(&field) || self.open.iter().any(asleep)
    }

    /// The last word was the name of a field.
    fn begin_field(&mut self) {
        if self.mute.is_none() && self.is_ignored(&self.word) {
            self.mute = Some(self.open.len());
        }
        if let Some(level) = self.open.last_mut() {
            level.telling = level.dormant.is_some_and(|dormant| dormant.field == self.word);
        }
        self.word.clear();
    }

    /// The last word was a value, or the name of a part.
    fn flush(&mut self) {
        if self.mute.is_none() {
            self.kept.extend_from_slice(self.word.as_bytes());
        }
        self.word.clear();
    }

    fn end_field(&mut self) {
        let depth = self.open.len();
        if self.open.last().is_some_and(|level| level.braces) && self.mute == Some(depth) {
            self.mute = None;
        }
    }

    fn open(&mut self, braces: bool) {
        let part = self.word.as_str();
        let dormant = DORMANT.iter().find(|dormant| braces && dormant.part == part);
        self.open.push(Level { braces, dormant, ..Level::default() });
        self.flush();
    }

    fn value(&mut self, text: &str) {
        if let Some(level) = self.open.last_mut()
            && level.telling
        {
            level.asleep = level.dormant.is_some_and(|dormant| dormant.at_rest == text);
            level.telling = false;
        }
        self.flush();
        self.word.push_str(text);
    }

    /// Names of fields are the same in every state, so they are left out.
    fn keep(&mut self, text: &str) {
        if self.mute.is_none() {
            self.kept.extend_from_slice(text.as_bytes());
        }
    }

    fn number_of_moment(&mut self, text: &str) -> fmt::Result {
        self.moment = false;
        let moment: u32 = text.parse().map_err(|_| fmt::Error)?;
        let ahead_ms = moment.wrapping_sub(self.now_ms).cast_signed().max(-PAST_MS);
        self.keep(&ahead_ms.to_string());
        Ok(())
    }
}

impl Write for Reader {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        match text.as_bytes() {
            b": " => {
                self.begin_field();
                return Ok(());
            }
            b", " => {
                self.flush();
                self.end_field();
            }
            b" }" | b")" | b"]" => {
                self.flush();
                self.end_field();
                self.open.pop();
            }
            b"(" | b"[" => self.open(false),
            b" { " => self.open(true),
            b"Millis" => {
                self.flush();
                self.moment = true;
            }
            _ if self.moment => return self.number_of_moment(text),
            _ => {
                self.value(text);
                return Ok(());
            }
        }
        self.keep(text);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{ADDRESS, Plant};
    use lafet_device::{Composition, Device, Source};
    use lafet_proto::record::Writer;
    use lafet_proto::request::Body;
    use lafet_proto::{Request, SubsystemId};

    fn device_at(now_ms: u32) -> (Device, Plant) {
        let mut plant = Plant::new(&Composition::FULL);
        let device = Device::power_up(now_ms, &Composition::FULL, ADDRESS, None, &mut plant);
        (device, plant)
    }

    fn ask(device: &mut Device, now_ms: u32, to: SubsystemId, body: Body<'_>) {
        let mut payload = [0; 64];
        let mut writer = Writer::new(&mut payload);
        Request::new(to, body).encode(&mut writer).unwrap();
        let len = writer.len();
        device.handle(now_ms, Source::ExternalConn, &payload[..len], &mut [0; 512]);
    }

    #[test]
    fn every_name_is_a_field() {
        let (device, _) = device_at(0);
        let text = format!("{device:?}");
        let all = DORMANT.iter().flat_map(|d| d.ignored.iter().chain([&d.field]));
        for field in IGNORED.iter().chain(all) {
            assert!(text.contains(&format!(" {field}: ")), "no field is called {field}");
        }
        for Dormant { part, at_rest, field, .. } in DORMANT {
            assert!(text.contains(&format!("{part} {{ ")), "no part is called {part}");
            assert!(text.contains(&format!("{field}: {at_rest}, ")), "{field} is never {at_rest}");
        }
    }

    #[test]
    fn the_clock_does_not_count_and_what_runs_does() {
        let ((mut early, mut plant), (mut late, _)) = (device_at(0), device_at(u32::MAX - 50));
        assert_eq!(of(&early, 0), of(&late, u32::MAX - 50));
        assert!(text(&early, 0).contains("Timer { Some(Millis(100)) }"), "{}", text(&early, 0));
        for (ms, device) in [(100, &mut early), (49, &mut late)] {
            device.step(ms, &mut plant);
        }
        assert_eq!(of(&early, 100), of(&late, 49));
        assert_ne!(of(&early, 100), of(&late, 50));
        let before = of(&early, 100);
        ask(&mut early, 100, SubsystemId::ALL, Body::GetStatus);
        assert_eq!(of(&early, 100), before);
        ask(&mut early, 100, SubsystemId::DEPLOYER, Body::Deploy);
        assert_ne!(of(&early, 100), before);
    }
}
