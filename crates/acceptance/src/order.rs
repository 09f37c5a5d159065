//! What may be sent to a hub: nothing here opens a valve, starts a pump, or touches a zone, a vote or a parameter.

use std::collections::BTreeMap;

use lafet_texts::{Text as _, Words, acceptance as text};
use serde_json::Value;

/// A request that is ready to be sent. Only the orders of this module make one.
#[derive(Clone, Debug, PartialEq)]
pub struct Posting {
    path: String,
    body: Value,
    dated: bool,
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

    /// With the time of the hub, ms since its start, at which it was seen that it may be sent: the hub refuses what
    /// arrives late, and what a Stop undoes that has come since. What ends is sent as it is.
    #[must_use]
    pub fn seen_at(mut self, up_ms: u64) -> Self {
        if let Some(body) = self.body.as_object_mut().filter(|_| self.dated) {
            body.insert("up_ms".to_owned(), up_ms.into());
        }
        self
    }

    fn new(path: String, fields: &[(&str, &str)]) -> Self {
        let fields: BTreeMap<&str, &str> = fields.iter().copied().collect();
        Self { path, body: serde_json::to_value(fields).unwrap_or_default(), dated: false }
    }

    fn request(monitor: &str, request: &str) -> Self {
        let path = format!("/api/monitors/{}/requests", part(monitor));
        Self { dated: true, ..Self::new(path, &[("request", request)]) }
    }
}

/// A name as a part of a path, or of the id of a question.
pub(crate) fn part(name: &str) -> String {
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

/// What is ordered of a monitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Reads its parameters.
    Read,
    /// Takes it.
    Take,
    /// Turns a drive.
    Move {
        /// Its drive.
        drive: Drive,
        /// Where to, arc-minutes.
        to: i16,
    },
    /// Deploys it.
    Deploy,
    /// Stows it.
    Wrap,
    /// Stops it.
    Stop,
    /// Gives it back.
    Release,
}

impl Order {
    /// As it is sent to a monitor.
    pub fn posting(&self, monitor: &str) -> Posting {
        let of = |what: &str| format!("/api/monitors/{}/{what}", part(monitor));
        match self {
            Self::Read => Posting::new(of("params/read"), &[]),
            Self::Take => Posting::new(of("authority"), &[("action", "take")]),
            Self::Move { drive, to } => {
                Posting::request(monitor, &format!("Move {} {to}", drive.name()))
            }
            Self::Deploy => Posting::request(monitor, "Deploy"),
            Self::Wrap => Posting::request(monitor, "Wrap"),
            Self::Stop => Posting::new(of("stop"), &[]),
            Self::Release => Posting::new(of("authority"), &[("action", "release")]),
        }
    }

    /// What moves, for people.
    pub fn words(&self, monitor: &str) -> Option<Words> {
        let words = match self {
            Self::Read | Self::Take | Self::Stop | Self::Release => return None,
            Self::Move { drive, to } => {
                let degrees = format!("{:.1}", f64::from(*to) / 60.0);
                text::WillMove { monitor, drive: drive.name(), degrees }.words()
            }
            Self::Deploy => text::WillDeploy { monitor }.words(),
            Self::Wrap => text::WillWrap { monitor }.words(),
        };
        Some(words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Order; 7] {
        let turn = Order::Move { drive: Drive::Horizontal, to: -60 };
        [Order::Read, Order::Take, turn, Order::Deploy, Order::Wrap, Order::Stop, Order::Release]
    }

    /// Whatever is added to the orders has to be added here: this list is all that a hub can get.
    #[test]
    fn nothing_that_is_sent_opens_starts_releases_or_sets() {
        let sent: Vec<String> = all()
            .iter()
            .map(|it| {
                let posting = it.posting("M1");
                format!("{} {}", posting.path(), posting.body())
            })
            .collect();
        assert_eq!(
            sent,
            [
                "/api/monitors/M1/params/read {}",
                "/api/monitors/M1/authority {\"action\":\"take\"}",
                "/api/monitors/M1/requests {\"request\":\"Move Horizontal -60\"}",
                "/api/monitors/M1/requests {\"request\":\"Deploy\"}",
                "/api/monitors/M1/requests {\"request\":\"Wrap\"}",
                "/api/monitors/M1/stop {}",
                "/api/monitors/M1/authority {\"action\":\"release\"}",
            ]
        );
    }

    #[test]
    fn what_moves_is_dated_and_what_ends_never() {
        for order in all() {
            let posting = order.posting("M1").seen_at(7);
            let moves = order.words("M1").is_some();
            assert_eq!(posting.body()["up_ms"] == 7, moves, "{order:?}");
        }
    }

    #[test]
    fn names_stay_one_part_of_the_path() {
        let path = |monitor: &str| Order::Stop.posting(monitor).path().to_owned();
        assert_eq!(path("a/../b c"), "/api/monitors/a%2F..%2Fb%20c/stop");
        assert_eq!(path("ствол"), "/api/monitors/%D1%81%D1%82%D0%B2%D0%BE%D0%BB/stop");
    }
}
