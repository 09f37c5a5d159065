//! Decides when two states of the device are equal, from its `Debug` text, hashed while it is
//! written.
//!
//! The text contains every field of every part, so a field added to the device counts until it is
//! named below. Times are taken relative to now.

use lafet_device::Device;
use lafet_device::params::Params;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt::{self, Debug, Write};
use std::hash::{DefaultHasher, Hasher};

/// Fields, wherever they occur, that have no effect visible to the model; and the parameters, which
/// are hashed separately because they are long and rarely change.
///
/// The composition and the clock of the last step are the same in all states of a run; the
/// interfaces only store the time of the last request (§3.3.9); climate is not modelled; the plant
/// has no speeds, only directions; the time for which a motion has been watched, or has got no further, affects
/// when it ends, not whether; that there was a request since the last step has no effect.
const IGNORED: &[&str] = &[
    "chain",
    "address",
    "outputs",
    "causes",
    "params",
    "climatics",
    "external_conn",
    "radio",
    "last_step",
    "disturbed",
    "crash",
    "watch",
    "nearest",
    "speed_cap_tenths",
];

/// Numbers of which only the sign has an effect.
const SIGNS: &[&str] = &["speed_milli", "speed_tenths"];

/// Further fields to leave out, by part.
const PARTS: &[Part] = &[
    // Whether a request, a button or a program moves it has an effect; which request does not.
    Part { name: "Asked", rest: None, never: &["request", "to", "source"], dormant: &[] },
    Part {
        name: "Drive",
        rest: Some(("goal", "Hold")),
        never: &["driven", "missed", "seen", "fault_ms"],
        dormant: &["cause", "arrival"],
    },
    // Drives of the model stop where they are: how long one takes to rest has no effect.
    Part {
        name: "Arrival",
        rest: None,
        never: &[
            "smooth_milli",
            "still_ms",
            "held_ms",
            "left_ms",
            "rest_ms",
            "waited_ms",
            "kick",
            "kicked",
            "corrections",
            "from",
            "pulsed",
        ],
        dormant: &[],
    },
    // Nothing of it is kept over a reset: when it was last at its open switch has no effect.
    Part { name: "Valve", rest: None, never: &["cause", "apart_ms"], dormant: &[] },
    // Its cause follows from where it is moving.
    Part { name: "Deployer", rest: None, never: &["cause"], dormant: &[] },
    // Flags of the last program or search, which are only reported.
    Part {
        name: "Control",
        rest: Some(("state", "Idle")),
        never: &["latched"],
        dormant: &[
            "task",
            "cause",
            "data",
            "nozzle",
            "nozzle_kept",
            "nozzle_goal",
            "elevation",
            "approach",
        ],
    },
    Part {
        name: "Detector",
        rest: Some(("state", "Idle")),
        never: &["latched"],
        dormant: &["cause", "hotbeds", "approach", "silence"],
    },
];

/// Times count by how far they lie ahead, in classes that double: a timer has just started, is half
/// over, nearly over. The device looks back in time only for steady pressure (§3.3.6).
const CLASSES_MS: &[i32] = &[0, 100, 200, 400, 800, 1600, 3200];

/// Fields in `never` never have an effect, and those in `dormant` have none while the named field
/// says that the part is at rest: they are set again before they are next read.
struct Part {
    name: &'static str,
    rest: Option<(&'static str, &'static str)>,
    never: &'static [&'static str],
    dormant: &'static [&'static str],
}

/// Most hashes of sets of parameters that are cached.
const PARAMS_KEPT: usize = 16;

/// Most hashes of devices that are cached: many actions from a state change nothing in the device.
const DEVICES_KEPT: usize = 8;

thread_local! {
    static PARAMS: RefCell<Vec<(Params, u64)>> = const { RefCell::new(Vec::new()) };
    static DEVICES: RefCell<VecDeque<(Device, u32, u64)>> = const { RefCell::new(VecDeque::new()) };
}

/// Hash of everything in a device that affects its further behaviour.
pub fn of(device: &Device, now_ms: u32) -> u64 {
    DEVICES.with_borrow_mut(|kept| {
        let same = |(known, at, _): &&(Device, u32, u64)| *at == now_ms && known == device;
        if let Some((_, _, hash)) = kept.iter().find(same) {
            return *hash;
        }
        let hash = of_new(device, now_ms);
        kept.truncate(DEVICES_KEPT - 1);
        kept.push_front((device.clone(), now_ms, hash));
        hash
    })
}

fn of_new(device: &Device, now_ms: u32) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(&Reader::read(device, now_ms).kept);
    hasher.write_u64(of_params(device.params(), now_ms));
    hasher.finish()
}

fn of_params(params: &Params, now_ms: u32) -> u64 {
    PARAMS.with_borrow_mut(|kept| {
        if let Some((_, hash)) = kept.iter().find(|(known, _)| known == params) {
            return *hash;
        }
        let reader = Reader::read(params, now_ms);
        let mut hasher = DefaultHasher::new();
        hasher.write(&reader.kept);
        let hash = hasher.finish();
        // Times in them are nearer or further off the next time.
        if !reader.any_moment && kept.len() < PARAMS_KEPT {
            kept.push((params.clone(), hash));
        }
        hash
    })
}

/// The text that is hashed, for finding the difference between two states.
pub fn text(device: &Device, now_ms: u32) -> String {
    let mut kept = Reader::read(device, now_ms).kept;
    kept.extend(Reader::read(device.params(), now_ms).kept);
    String::from_utf8_lossy(&kept).into_owned()
}

/// Parses derived `Debug` text: `Part { field: value, … }`, `Variant(value)`, `[value, …]`.
struct Reader {
    now_ms: u32,
    kept: Vec<u8>,
    /// Text that may be the name of a field or a part.
    word: String,
    open: Vec<Level>,
    /// Whether the next number is a time.
    moment: bool,
    any_moment: bool,
    /// Whether only the sign of the next number counts.
    sign: bool,
    /// Depth of the field that is being skipped.
    mute: Option<usize>,
}

/// An open brace, parenthesis or bracket.
#[derive(Default)]
struct Level {
    braces: bool,
    part: Option<&'static Part>,
    /// Whether the value being read says if the part is at rest.
    telling: bool,
    asleep: bool,
}

impl Reader {
    fn read(part: &impl Debug, now_ms: u32) -> Self {
        let mut reader = Self::new(now_ms);
        write!(reader, "{part:?}").expect("the reader takes everything");
        reader
    }

    fn new(now_ms: u32) -> Self {
        Self {
            now_ms,
            kept: Vec::with_capacity(16 * 1024),
            word: String::new(),
            open: Vec::with_capacity(16),
            moment: false,
            any_moment: false,
            sign: false,
            mute: None,
        }
    }

    fn is_ignored(&self, field: &str) -> bool {
        let innermost = self.open.last().and_then(|level| level.part);
        IGNORED.contains(&field)
            || innermost.is_some_and(|part| part.never.contains(&field))
            || self.open.iter().any(|level| {
                level.asleep && level.part.is_some_and(|part| part.dormant.contains(&field))
            })
    }

    /// Called when the last word was the name of a field.
    fn begin_field(&mut self) {
        if self.mute.is_none() && self.is_ignored(&self.word) {
            self.mute = Some(self.open.len());
        }
        if let Some(level) = self.open.last_mut() {
            level.telling =
                level.part.and_then(|part| part.rest).is_some_and(|(field, _)| field == self.word);
        }
        self.sign = SIGNS.contains(&self.word.as_str());
        self.word.clear();
    }

    /// Called when the last word was a value, or the name of a part.
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
        let part = PARTS.iter().find(|part| braces && part.name == self.word);
        self.open.push(Level { braces, part, ..Level::default() });
        self.flush();
    }

    fn value(&mut self, text: &str) {
        if self.mute.is_some() {
            return;
        }
        if let Some(level) = self.open.last_mut()
            && level.telling
        {
            level.asleep =
                level.part.and_then(|part| part.rest).is_some_and(|(_, at_rest)| at_rest == text);
            level.telling = false;
        }
        self.flush();
        let is_number = text.starts_with(|c: char| c.is_ascii_digit());
        let text = if self.sign && is_number && text != "0" { "n" } else { text };
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
        self.any_moment = true;
        let moment: u32 = text.parse().map_err(|_| fmt::Error)?;
        let ahead_ms = moment.wrapping_sub(self.now_ms).cast_signed();
        let class = CLASSES_MS.iter().filter(|begin| ahead_ms > **begin).count();
        self.keep(&class.to_string());
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
    use crate::model::plant::{ADDRESS, Plant};
    use lafet_device::{Composition, Source};
    use lafet_proto::record::Writer;
    use lafet_proto::request::Body;
    use lafet_proto::{Request, SubsystemId};

    fn device_at(now_ms: u32) -> (Device, Plant) {
        let mut plant = Plant::new(&Composition::FULL, 0);
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
        let (mut device, _) = device_at(0);
        ask(&mut device, 0, SubsystemId::DEPLOYER, Body::Deploy);
        let text = format!("{device:?}");
        let of_parts = PARTS.iter().flat_map(|part| part.never.iter().chain(part.dormant));
        for field in IGNORED.iter().chain(SIGNS).chain(of_parts) {
            assert!(text.contains(&format!(" {field}: ")), "no field is called {field}");
        }
        for Part { name, rest, .. } in PARTS {
            assert!(text.contains(&format!("{name} {{ ")), "no part is called {name}");
            let Some((field, at_rest)) = rest else { continue };
            assert!(text.contains(&format!("{field}: {at_rest}, ")), "{field} is never {at_rest}");
        }
    }

    #[test]
    fn the_clock_does_not_count_and_what_runs_does() {
        let ((mut early, mut plant), (mut late, _)) = (device_at(0), device_at(u32::MAX - 50));
        assert_eq!(of(&early, 0), of(&late, u32::MAX - 50));
        assert!(text(&early, 0).contains("Timer { Some(Millis(1)) }"), "{}", text(&early, 0));
        for (ms, device) in [(100, &mut early), (49, &mut late)] {
            device.step(ms, &mut plant);
        }
        assert_eq!(of(&early, 100), of(&late, 49));
        let before = of(&early, 100);
        ask(&mut early, 100, SubsystemId::ALL, Body::GetStatus);
        assert_eq!(of(&early, 100), before);
        ask(&mut early, 100, SubsystemId::DEPLOYER, Body::Deploy);
        assert_ne!(of(&early, 100), before);
        // Its timeout elapses.
        assert_ne!(of(&early, 100), of(&early, 20_000));
    }
}
