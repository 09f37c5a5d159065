//! What goes to the page and comes from it, as JSON. The page's types are made of these: a test
//! compares them with `playground/src/wire.ts`.

use lafet_texts::{Fixed, Words};
use serde::{Deserialize, Serialize};

#[cfg(test)]
use ts_rs::TS;

/// A text in every language.
pub fn words(fixed: Fixed) -> Words {
    Words::each(|lang| fixed.str(lang).to_owned())
}

macro_rules! shapes {
    ($($(#[$meta:meta])* $kind:ident $name:ident $body:tt)+) => {
        $($(#[$meta])*
        #[cfg_attr(test, derive(TS))]
        pub $kind $name $body)+

        /// The declarations of all, in TypeScript.
        #[cfg(test)]
        pub fn declarations() -> Vec<String> {
            let config = ts_rs::Config::default();
            vec![$($name::decl(&config)),+]
        }
    };
}

shapes! {
    /// The interface that a frame comes in by.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Link {
        /// The wired one.
        Wired,
        /// The radio.
        Radio,
    }

    /// What was typed.
    #[derive(Clone, Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Input {
        /// Hexadecimal bytes, not the text form of requests.
        pub bytes: bool,
        pub text: String,
    }

    /// What can be done with the monitor and its world.
    #[derive(Clone, Debug, Deserialize)]
    #[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
    enum Act {
        Send { link: Link, input: Input },
        /// Two clients send in the same step; the frame of `first` is the first to be complete.
        Race { first: Link, wired: Input, radio: Input },
        Break { fault: String },
        Repair { fault: String },
        /// Degrees, positive left; metres.
        Light { azimuth: i16, range: u8, fuel: bool },
        Sweep {},
        Power {},
    }

    /// What the page asks for.
    #[derive(Clone, Debug, Deserialize)]
    #[serde(tag = "op", rename_all = "lowercase", deny_unknown_fields)]
    enum Command {
        Describe {},
        Start { seed: u32, profile: String, wind: [i8; 2] },
        Open { fragment: String },
        /// Entries from number `since` come with the answer.
        Advance { ms: u32, since: usize },
        Read { input: Input },
        Act { act: Act },
        Share {},
    }

    /// A field of a frame: bytes `at` … `at + len` of it.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Part {
        pub at: usize,
        pub len: usize,
        /// Number of the record that it belongs to; none for what belongs to the link.
        pub record: Option<usize>,
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub value: Words,
        #[cfg_attr(test, ts(type = "Words"))]
        pub meaning: Words,
        pub flags: Vec<Flag>,
    }

    /// A flag that is set.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Flag {
        pub name: String,
        /// info, notice, warning, alarm.
        pub severity: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub meaning: Words,
        #[cfg_attr(test, ts(type = "Words"))]
        pub remedy: Words,
    }

    /// The bytes of a frame, all of them named.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Anatomy {
        pub bytes: Vec<u8>,
        pub parts: Vec<Part>,
        /// Each record as text.
        pub text: Vec<String>,
    }

    /// What a subsystem of the chain had to do with a request.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "lowercase")]
    enum Mark {
        /// It refused, for another one or for itself.
        Refused,
        /// It executed the request.
        Answered,
        /// It had no objection.
        Passed,
        /// Nothing is known: the way had ended before.
        Unasked,
        /// It is not part of this monitor.
        Absent,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Station {
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub title: Words,
        pub mark: Mark,
        pub addressed: bool,
    }

    /// An answer in short.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Verdict {
        pub from: String,
        pub status: String,
        pub success: bool,
        #[cfg_attr(test, ts(type = "Words"))]
        pub meaning: Words,
        #[cfg_attr(test, ts(type = "Words"))]
        pub remedy: Words,
    }

    /// The way of one request through the chain.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Walk {
        pub request: String,
        pub stations: Vec<Station>,
        /// Where it ended, and why there.
        #[cfg_attr(test, ts(type = "Words"))]
        pub end: Words,
        /// Flags of the subsystem that refused, as they were then.
        pub because: Vec<Flag>,
        pub verdicts: Vec<Verdict>,
    }

    /// What has been done, and what came of it.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Entry {
        pub index: usize,
        pub at_ms: u32,
        /// Through which interface, if it is a frame.
        pub link: Option<Link>,
        #[cfg_attr(test, ts(type = "Words"))]
        pub title: Words,
        pub request: Option<Anatomy>,
        pub answer: Option<Anatomy>,
        pub walks: Vec<Walk>,
        /// Why there is no answer.
        #[cfg_attr(test, ts(type = "Words | null"))]
        pub silence: Option<Words>,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Value {
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub value: Words,
        #[cfg_attr(test, ts(type = "Words"))]
        pub meaning: Words,
        /// A flag says that it is not to be relied on.
        pub invalid: bool,
    }

    /// A subsystem, as GetStatus shows it.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct State {
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub title: Words,
        pub severity: String,
        pub values: Vec<Value>,
        pub flags: Vec<Flag>,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Burning {
        /// Metres forward and left.
        pub at: [f64; 2],
        pub size_m: f64,
        /// 0 out … 1.
        pub heat: f64,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Water {
        /// Distance on the ground and height, m.
        pub arc: Vec<[f64; 2]>,
        /// Where it lands, metres forward and left, and the half-axes of the footprint.
        pub at: [f64; 2],
        pub along_m: f64,
        pub across_m: f64,
        /// Radians.
        pub heading: f64,
    }

    /// The monitor and what is around it, as they truly are.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Scene {
        /// Degrees; left and up are positive.
        pub azimuth: f64,
        pub elevation: f64,
        pub nozzle_mm: f64,
        /// 0 stowed … 1 deployed.
        pub deployment: f64,
        pub deployed: bool,
        /// True speeds of elevation, traverse, nozzle, deployment: sign only.
        pub motion: [i8; 4],
        /// 0 closed … 1 open.
        pub valves: [f64; 2],
        pub pressure_atm: f64,
        pub flow_lps: f64,
        /// Of traverse and elevation, degrees: what RetrieveLimits answers.
        pub limits: Option<[f64; 4]>,
        pub height_m: f64,
        pub water: Option<Water>,
        pub fires: Vec<Burning>,
        pub wind: [f64; 2],
    }

    /// The present state.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct View {
        pub at_ms: u32,
        /// Of everything that has happened.
        pub hash: String,
        /// Until when recorded actions are repeated, ms.
        pub replay_ms: Option<u32>,
        /// The longest time of a session is over.
        pub over: bool,
        pub profile: String,
        pub scene: Scene,
        pub states: Vec<State>,
        pub faults: Vec<String>,
        pub entries: Vec<Entry>,
        pub count: usize,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct RequestInfo {
        pub name: String,
        pub section: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub title: Words,
        #[cfg_attr(test, ts(type = "Words"))]
        pub meaning: Words,
        /// None: every subsystem.
        pub addressees: Vec<String>,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct SubsystemInfo {
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub title: Words,
        pub parameters: Vec<String>,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct FaultInfo {
        pub name: String,
        #[cfg_attr(test, ts(type = "Words"))]
        pub words: Words,
    }

    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct ExampleInfo {
        pub key: String,
        pub fragment: String,
    }

    /// What the page lists.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Description {
        pub requests: Vec<RequestInfo>,
        pub subsystems: Vec<SubsystemInfo>,
        pub faults: Vec<FaultInfo>,
        pub profiles: Vec<String>,
        pub examples: Vec<ExampleInfo>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "../../playground/src/wire.ts";
    const HEAD: &str = "// Made of crates/play/src/view.rs: LAFET_WRITE=1 cargo test -p lafet-play wire\n\n\
                        export type Words = { en: string; ru: string };\n";

    /// The page's types are those of this module.
    #[test]
    fn wire_types_are_those_of_the_page() {
        let mut text = HEAD.to_owned();
        for declaration in declarations() {
            text += &format!("export {}\n", declaration.replace(" \n", "\n"));
        }
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
        if std::env::var_os("LAFET_WRITE").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}
