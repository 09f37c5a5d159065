//! What may be sent to a hub. A step can only send what is here for it: none of [`Dry`] opens a valve or starts a
//! pump, and no order releases a zone. [`Outlet`] and [`Water`] need a permit that only a person's yes makes.

use std::collections::BTreeMap;

use lafet_texts::{Text as _, Words, acceptance as text};
use serde_json::Value;

/// A request that is ready to be sent. Only the orders of this module make one.
#[derive(Clone, Debug, PartialEq)]
pub struct Posting {
    path: String,
    body: Value,
}

impl Posting {
    /// Where it goes, by POST.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// What it says.
    pub const fn body(&self) -> &Value {
        &self.body
    }

    fn new(path: String, fields: &[(&str, Value)]) -> Self {
        let fields: BTreeMap<&str, &Value> = fields.iter().map(|(key, it)| (*key, it)).collect();
        Self { path, body: serde_json::to_value(fields).unwrap_or_default() }
    }

    fn request(monitor: &str, request: String) -> Self {
        Self::new(
            format!("/api/monitors/{}/requests", part(monitor)),
            &[("request", request.into())],
        )
    }
}

/// A name as a part of a path.
fn part(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte);
    let one = |byte: u8| match plain(byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    };
    name.bytes().map(one).collect()
}

/// A drive of the barrel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// To the sides.
    Horizontal,
    /// Up and down.
    Vertical,
}

impl Drive {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Horizontal, Self::Vertical];

    /// Its name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Horizontal => "Horizontal",
            Self::Vertical => "Vertical",
        }
    }
}

/// What a dry step orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dry {
    /// Reads the parameters of a monitor.
    Read {
        /// The monitor.
        monitor: String,
    },
    /// Takes a monitor.
    Take {
        /// The monitor.
        monitor: String,
    },
    /// Turns a drive, arc-minutes.
    Move {
        /// The monitor.
        monitor: String,
        /// Its drive.
        drive: Drive,
        /// Where to, arc-minutes.
        to: i16,
    },
    /// Deploys a monitor.
    Deploy {
        /// The monitor.
        monitor: String,
    },
    /// Stows a monitor.
    Wrap {
        /// The monitor.
        monitor: String,
    },
    /// Puts a zone into its dry test.
    Test {
        /// The zone.
        zone: String,
        /// It lasts so long, s.
        for_s: u32,
    },
    /// Switches a zone off: neither votes nor stations release it.
    Off {
        /// The zone.
        zone: String,
        /// It lasts so long, s.
        for_s: u32,
    },
}

/// What ends or puts back: allowed in every step, and at its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Safe {
    /// Stops a monitor.
    Stop {
        /// The monitor.
        monitor: String,
    },
    /// Closes all valves of a monitor.
    Close {
        /// The monitor.
        monitor: String,
    },
    /// Gives a monitor back.
    Release {
        /// The monitor.
        monitor: String,
    },
    /// Ends countdown and release of a zone.
    Abort {
        /// The zone.
        zone: String,
    },
    /// Withdraws the abort of a zone. Only of one in a test mode, or that is quiet.
    Reset {
        /// The zone.
        zone: String,
    },
    /// Puts a zone back into the mode that it had.
    Back {
        /// The zone.
        zone: String,
        /// The mode that it had.
        former: Former,
    },
}

/// The mode that a zone had.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Former {
    /// Its mode.
    pub mode: String,
    /// It returned to automatic after so long, s.
    pub for_s: Option<u32>,
}

/// A person's yes to pumps and test outlets.
#[derive(Debug)]
pub struct OutletPermit(pub(crate) ());

/// A person's yes to water.
#[derive(Debug)]
pub struct WaterPermit(pub(crate) ());

/// What a step with the test outlet orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outlet {
    /// Puts a zone into its test with pumps and outlet.
    Test {
        /// The zone.
        zone: String,
        /// It lasts so long, s.
        for_s: u32,
    },
}

/// What a step with water orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Water {
    /// Opens a valve of a monitor.
    Open {
        /// The monitor.
        monitor: String,
        /// The valve.
        valve: String,
    },
}

impl Dry {
    /// As it is sent.
    pub fn posting(&self) -> Posting {
        let of = |monitor: &str, what: &str| format!("/api/monitors/{}/{what}", part(monitor));
        match self {
            Self::Read { monitor } => Posting::new(of(monitor, "params/read"), &[]),
            Self::Take { monitor } => {
                Posting::new(of(monitor, "authority"), &[("action", "take".into())])
            }
            Self::Move { monitor, drive, to } => {
                Posting::request(monitor, format!("Move {} {to}", drive.name()))
            }
            Self::Deploy { monitor } => Posting::request(monitor, "Deploy".to_owned()),
            Self::Wrap { monitor } => Posting::request(monitor, "Wrap".to_owned()),
            Self::Test { zone, for_s } => mode(zone, "test_dry", Some(*for_s)),
            Self::Off { zone, for_s } => mode(zone, "off", Some(*for_s)),
        }
    }

    /// What moves, for people.
    pub fn words(&self) -> Option<Words> {
        let words = match self {
            Self::Read { .. } | Self::Take { .. } => return None,
            Self::Move { monitor, drive, to } => {
                let degrees = format!("{:.1}", f64::from(*to) / 60.0);
                text::WillMove { monitor, drive: drive.name(), degrees }.words()
            }
            Self::Deploy { monitor } => text::WillDeploy { monitor }.words(),
            Self::Wrap { monitor } => text::WillWrap { monitor }.words(),
            Self::Test { zone, .. } => text::WillTest { zone }.words(),
            Self::Off { zone, .. } => text::WillOff { zone }.words(),
        };
        Some(words)
    }
}

impl Safe {
    /// As it is sent.
    pub fn posting(&self) -> Posting {
        let of = |monitor: &str, what: &str| format!("/api/monitors/{}/{what}", part(monitor));
        let zone_of = |zone: &str, what: &str| format!("/api/zones/{}/{what}", part(zone));
        match self {
            Self::Stop { monitor } => Posting::new(of(monitor, "stop"), &[]),
            Self::Close { monitor } => Posting::new(of(monitor, "close"), &[]),
            Self::Release { monitor } => {
                Posting::new(of(monitor, "authority"), &[("action", "release".into())])
            }
            Self::Abort { zone } => Posting::new(zone_of(zone, "abort"), &[]),
            Self::Reset { zone } => Posting::new(zone_of(zone, "reset"), &[]),
            Self::Back { zone, former } => mode(zone, &former.mode, former.for_s),
        }
    }
}

impl Outlet {
    /// As it is sent.
    pub fn posting(&self, _: &OutletPermit) -> Posting {
        let Self::Test { zone, for_s } = self;
        mode(zone, "test_outlet", Some(*for_s))
    }
}

impl Water {
    /// As it is sent.
    pub fn posting(&self, _: &WaterPermit) -> Posting {
        let Self::Open { monitor, valve } = self;
        Posting::request(monitor, format!("Open {valve}"))
    }
}

fn mode(zone: &str, mode: &str, for_s: Option<u32>) -> Posting {
    let path = format!("/api/zones/{}/mode", part(zone));
    match for_s {
        Some(for_s) => Posting::new(path, &[("mode", mode.into()), ("for_s", for_s.into())]),
        None => Posting::new(path, &[("mode", mode.into())]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every order that needs no permit, with its request as it is sent.
    fn without_permit() -> Vec<Posting> {
        let (monitor, zone) = ("M1".to_owned(), "hall".to_owned());
        let m = || monitor.clone();
        let z = || zone.clone();
        let dry = [
            Dry::Read { monitor: m() },
            Dry::Take { monitor: m() },
            Dry::Move { monitor: m(), drive: Drive::Horizontal, to: -60 },
            Dry::Deploy { monitor: m() },
            Dry::Wrap { monitor: m() },
            Dry::Test { zone: z(), for_s: 60 },
            Dry::Off { zone: z(), for_s: 60 },
        ];
        let former = Former { mode: "automatic".into(), for_s: None };
        let safe = [
            Safe::Stop { monitor: m() },
            Safe::Close { monitor: m() },
            Safe::Release { monitor: m() },
            Safe::Abort { zone: z() },
            Safe::Reset { zone: z() },
            Safe::Back { zone: z(), former },
        ];
        dry.iter().map(Dry::posting).chain(safe.iter().map(Safe::posting)).collect()
    }

    #[test]
    fn without_a_permit_nothing_opens_starts_or_releases() {
        for posting in without_permit() {
            let request = posting.body()["request"].as_str().unwrap_or_default();
            for word in ["Open", "StartQuench", "StartTrajectory", "SetParam", "Lockout"] {
                assert!(!request.starts_with(word), "{posting:?}");
            }
            for path in ["/release", "/pumps", "/bypass", "/unlock", "/detectors"] {
                assert!(!posting.path().contains(path), "{posting:?}");
            }
            assert_ne!(posting.body()["mode"], "test_outlet", "{posting:?}");
        }
    }

    #[test]
    fn names_stay_one_part_of_the_path() {
        let order = Safe::Abort { zone: "a/../b c".into() };
        assert_eq!(order.posting().path(), "/api/zones/a%2F..%2Fb%20c/abort");
        let order = Safe::Abort { zone: "зал".into() };
        assert_eq!(order.posting().path(), "/api/zones/%D0%B7%D0%B0%D0%BB/abort");
    }
}
