//! Brokers of MQTT: what a file may say of them.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

use lafet_texts::{Shown, Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;

use super::check::{Check, is_name};
use super::file::File;
use crate::plugs::mqtt::desk::Terms;
use crate::plugs::mqtt::{BrokerConfig, Files, Login, NodeConfig, Secret};

/// Most brokers.
const BROKERS_MAX: usize = 8;
/// Most monitors of a broker.
const MONITORS_MAX: usize = 256;
/// Longest prefix, client id and host, characters.
const TEXT_MAX: usize = 64;
const HOST_MAX: usize = 253;
/// Allowed times between two states of a monitor, ms.
const INTERVAL_MS: RangeInclusive<u64> = 250..=60_000;
const INTERVAL_USUAL_MS: u64 = 1000;
/// Allowed times without a sign of life of the clients, ms.
const ALIVE_MS: RangeInclusive<u64> = 1000..=60_000;
const ALIVE_USUAL_MS: u64 = 3000;
/// Allowed numbers of values that wait for a host, and times for which they do, s.
const HISTORY: RangeInclusive<u64> = 0..=100_000;
const HISTORY_USUAL: u64 = 10_000;
const HISTORY_S: RangeInclusive<u64> = 1..=86_400;
const HISTORY_USUAL_S: u64 = 3600;

/// What the clients of a broker may do, as written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Role {
    /// Stop, Close and Lockout alone.
    #[default]
    Observer,
    /// All commands.
    Operator,
}

/// A broker as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mqtt {
    name: Spanned<String>,
    url: Spanned<String>,
    #[serde(default)]
    plain: bool,
    user: Option<Spanned<String>>,
    password: Option<Spanned<String>>,
    password_file: Option<Spanned<PathBuf>>,
    ca: Option<Spanned<PathBuf>>,
    cert: Option<Spanned<PathBuf>>,
    key: Option<Spanned<PathBuf>>,
    client_id: Option<Spanned<String>>,
    prefix: Option<Spanned<String>>,
    monitors: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    role: Role,
    interval_ms: Option<Spanned<u64>>,
    alive_ms: Option<Spanned<u64>>,
    #[serde(default = "yes")]
    close_when_lost: bool,
    homeassistant: Option<Spanned<String>>,
    sparkplug: Option<Sparkplug>,
}

/// An edge node as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sparkplug {
    group: Spanned<String>,
    node: Spanned<String>,
    primary_host: Option<Spanned<String>>,
    history: Option<Spanned<u64>>,
    history_s: Option<Spanned<u64>>,
}

/// A user and a password as written.
pub(super) struct WrittenLogin<'a> {
    pub user: Option<&'a Spanned<String>>,
    pub password: Option<&'a Spanned<String>>,
    pub file: Option<&'a Spanned<PathBuf>>,
}

const fn yes() -> bool {
    true
}

/// Where a broker is.
struct Place {
    host: String,
    port: u16,
    tls: bool,
}

/// `mqtt://HOST:PORT` or `mqtts://HOST:PORT`; the port may be left out.
fn place(url: &str) -> Option<Place> {
    let (tls, rest) = match url.split_once("://")? {
        ("mqtt", rest) => (false, rest),
        ("mqtts", rest) => (true, rest),
        _ => return None,
    };
    let rest = rest.strip_suffix('/').unwrap_or(rest);
    let (host, port) = match rest.strip_prefix('[') {
        Some(rest) => {
            let (host, port) = rest.split_once(']')?;
            host.parse::<std::net::Ipv6Addr>().ok()?;
            (host, port.strip_prefix(':').or_else(|| port.is_empty().then_some("")))
        }
        None => match rest.split_once(':') {
            Some((host, port)) => (host, Some(port).filter(|it| !it.is_empty())),
            None => (rest, Some("")),
        },
    };
    let usual = if tls { 8883 } else { 1883 };
    let port = match port? {
        "" => usual,
        port => port.parse().ok().filter(|it| *it != 0)?,
    };
    let fine = |c: char| c.is_ascii_alphanumeric() || "-._:".contains(c);
    let is_host = !host.is_empty() && host.len() <= HOST_MAX && host.chars().all(fine);
    is_host.then(|| Place { host: host.to_owned(), port, tls })
}

/// Whether topics may begin with it.
fn is_prefix(text: &str) -> bool {
    let length = text.chars().count();
    let fine = |c: char| !c.is_control() && !"+#$".contains(c);
    (1..=TEXT_MAX).contains(&length)
        && text.chars().all(fine)
        && text.split('/').all(|level| !level.is_empty())
}

/// Whether a part of topics of Sparkplug can be so.
fn is_part(text: &str) -> bool {
    let fine = |c: char| !c.is_control() && !"/+#".contains(c);
    (1..=TEXT_MAX).contains(&text.chars().count()) && text.chars().all(fine)
}

fn value<T: Copy>(written: Option<&Spanned<T>>, usual: T) -> T {
    written.map_or(usual, |it| *it.get_ref())
}

impl Check<'_> {
    /// The brokers.
    pub fn mqtt(&mut self, read: &File) -> Vec<BrokerConfig> {
        let mut brokers: Vec<BrokerConfig> = Vec::new();
        for written in &read.mqtt {
            if brokers.len() >= BROKERS_MAX {
                let at = written.span().start;
                self.say(at, text::CheckBrokers.words(), text::CheckBrokersRemedy.words());
                break;
            }
            if let Some(broker) = self.broker(read, written.get_ref(), &brokers) {
                brokers.push(broker);
            }
        }
        brokers
    }

    fn broker(
        &mut self,
        read: &File,
        written: &Mqtt,
        others: &[BrokerConfig],
    ) -> Option<BrokerConfig> {
        let (name, at) = (written.name.get_ref(), written.name.span().start);
        if !is_name(name) {
            let what = text::CheckBrokerName { name }.words();
            self.say(at, what, text::CheckBusNameRemedy.words());
        } else if others.iter().any(|other| other.name == *name) {
            let what = text::CheckBusTwice { name }.words();
            self.say(at, what, text::CheckBrokerTwiceRemedy.words());
        }
        let place = self.broker_place(written);
        let login = self.login(&WrittenLogin {
            user: written.user.as_ref(),
            password: written.password.as_ref(),
            file: written.password_file.as_ref(),
        });
        let files = self.files(written, place.as_ref());
        if let Some(interval) = &written.interval_ms {
            self.range(interval, INTERVAL_MS, "interval_ms");
        }
        if let Some(alive) = &written.alive_ms {
            self.range(alive, ALIVE_MS, "alive_ms");
        }
        let monitors = self.broker_monitors(read, written);
        let sparkplug = self.edge_node(written);
        let prefix = match &sparkplug {
            Some(node) => node.prefix(),
            None => self.topic(written.prefix.as_ref(), "prefix").unwrap_or("lafet".to_owned()),
        };
        let homeassistant = self.topic(written.homeassistant.as_ref(), "homeassistant");
        let usual = format!("lafet-{name}");
        let client_id = written.client_id.as_ref().map_or(&usual, |it| it.get_ref()).clone();
        if let Some(written) = &written.client_id {
            let fine = |c: char| c.is_ascii_graphic();
            let length = written.get_ref().len();
            if !(1..=TEXT_MAX).contains(&length) || !written.get_ref().chars().all(fine) {
                let what = text::CheckClientId { text: written.get_ref() }.words();
                self.say(written.span().start, what, text::CheckClientIdRemedy.words());
            }
        }
        let place = place?;
        let same_place = |it: &&BrokerConfig| (&it.host, it.port) == (&place.host, place.port);
        let clash = |it: &&BrokerConfig| it.client_id == client_id || it.prefix == prefix;
        if let Some(other) = others.iter().filter(same_place).find(clash) {
            let what = text::CheckBrokerSame { name: &other.name }.words();
            self.say(at, what, text::CheckBrokerSameRemedy.words());
        }
        Some(BrokerConfig {
            name: name.clone(),
            host: place.host,
            port: place.port,
            tls: place.tls.then_some(files),
            login,
            client_id,
            prefix,
            monitors,
            interval: Duration::from_millis(value(written.interval_ms.as_ref(), INTERVAL_USUAL_MS)),
            terms: Terms {
                alive: Duration::from_millis(value(written.alive_ms.as_ref(), ALIVE_USUAL_MS)),
                closes: written.close_when_lost,
                operates: written.role == Role::Operator,
            },
            homeassistant,
            sparkplug,
        })
    }

    fn edge_node(&mut self, written: &Mqtt) -> Option<NodeConfig> {
        let node = written.sparkplug.as_ref()?;
        for (key, given) in [("prefix", &written.prefix), ("homeassistant", &written.homeassistant)]
        {
            if let Some(given) = given {
                let what = text::CheckSparkplugAlone { key }.words();
                self.say(given.span().start, what, text::CheckSparkplugAloneRemedy.words());
            }
        }
        let host = node.primary_host.as_ref();
        let names =
            [("group", Some(&node.group)), ("node", Some(&node.node)), ("primary_host", host)];
        for (key, name) in names.into_iter().filter_map(|(key, name)| Some((key, name?))) {
            let text = name.get_ref();
            if !is_part(text) || key == "group" && text == "STATE" {
                let what = text::CheckSparkplugName { key, text }.words();
                self.say(name.span().start, what, text::CheckSparkplugNameRemedy.words());
            }
        }
        if let Some(history) = &node.history {
            self.range(history, HISTORY, "history");
        }
        if let Some(history_s) = &node.history_s {
            self.range(history_s, HISTORY_S, "history_s");
        }
        let history = value(node.history.as_ref(), HISTORY_USUAL);
        Some(NodeConfig {
            group: node.group.get_ref().clone(),
            node: node.node.get_ref().clone(),
            host: host.map(|it| it.get_ref().clone()),
            history: usize::try_from(history).unwrap_or(usize::MAX),
            history_age: Duration::from_secs(value(node.history_s.as_ref(), HISTORY_USUAL_S)),
        })
    }

    fn broker_place(&mut self, written: &Mqtt) -> Option<Place> {
        let (url, at) = (written.url.get_ref(), written.url.span().start);
        let Some(place) = place(url) else {
            let what = text::CheckBrokerUrl { text: url }.words();
            self.say(at, what, text::CheckBrokerUrlRemedy.words());
            return None;
        };
        let is_loopback = place.host == "localhost"
            || place.host.parse::<std::net::IpAddr>().is_ok_and(|it| it.is_loopback());
        if !place.tls && !is_loopback && !written.plain {
            let what = text::CheckBrokerPlain { host: &place.host }.words();
            self.say(at, what, text::CheckBrokerPlainRemedy.words());
        }
        Some(place)
    }

    /// A user and a password, here or in a file.
    pub(super) fn login(&mut self, written: &WrittenLogin<'_>) -> Option<Login> {
        let user = written.user;
        let secret = match (written.password, written.file) {
            (Some(_), Some(file)) => {
                let what = text::CheckTwoPasswords.words();
                self.say(file.span().start, what, text::CheckTwoPasswordsRemedy.words());
                None
            }
            (Some(password), None) => {
                let own = self.folder.join(self.file_name());
                self.secret(password.span().start, &own);
                Some(Secret::Here(password.get_ref().clone()))
            }
            (None, Some(file)) => {
                let path = self.folder.join(file.get_ref());
                self.secret(file.span().start, &path);
                if let Err(error) = std::fs::File::open(&path) {
                    let why = crate::field::line::said(&error);
                    let shown = path.display();
                    let what = text::CheckPasswordFile { path: Shown(shown), why: &why }.words();
                    self.say(file.span().start, what, text::CheckPasswordFileRemedy.words());
                }
                Some(Secret::File(path))
            }
            (None, None) => None,
        };
        let at =
            [written.password.map(|it| it.span().start), written.file.map(|it| it.span().start)];
        if let (None, Some(at)) = (user, at.into_iter().flatten().next()) {
            let what = text::CheckPasswordAlone.words();
            self.say(at, what, text::CheckPasswordAloneRemedy.words());
        }
        Some(Login { user: user?.get_ref().clone(), secret })
    }

    fn files(&mut self, written: &Mqtt, place: Option<&Place>) -> Files {
        let folder = self.folder;
        let path = |it: &Option<Spanned<PathBuf>>| it.as_ref().map(|it| folder.join(it.get_ref()));
        let [ca, cert, key] = [&written.ca, &written.cert, &written.key].map(path);
        let given = [&written.ca, &written.cert, &written.key].into_iter().flatten().next();
        if let (Some(given), Some(Place { tls: false, .. })) = (given, place) {
            let at = given.span().start;
            self.say(at, text::CheckTlsUnused.words(), text::CheckTlsUnusedRemedy.words());
        }
        let own = match (cert, key) {
            (Some(cert), Some(key)) => Some((cert, key)),
            (None, None) => None,
            _ => {
                let at = given.map_or(0, |it| it.span().start);
                let what = text::CheckCertAndKey.words();
                self.say(at, what, text::CheckCertAndKeyRemedy.words());
                None
            }
        };
        if let (Some((_, path)), Some(written)) = (&own, &written.key) {
            self.secret(written.span().start, path);
        }
        let files = Files { ca, own };
        if let Some(at) = given.map(|it| it.span().start) {
            for what in files.problems() {
                self.say(at, what, text::CheckPemRemedy.words());
            }
        }
        files
    }

    fn topic(&mut self, written: Option<&Spanned<String>>, key: &str) -> Option<String> {
        let written = written?;
        if !is_prefix(written.get_ref()) {
            let what = text::CheckPrefix { key, text: written.get_ref() }.words();
            self.say(written.span().start, what, text::CheckPrefixRemedy.words());
        }
        Some(written.get_ref().clone())
    }

    fn broker_monitors(&mut self, read: &File, written: &Mqtt) -> Vec<String> {
        let at = written.name.span().start;
        let ids = self.plug_monitors(read, &written.name, written.monitors.as_deref());
        if ids.len() > MONITORS_MAX {
            self.say(
                at,
                text::CheckBrokerMonitors.words(),
                text::CheckBrokerMonitorsRemedy.words(),
            );
        }
        let plain = written.sparkplug.is_none();
        for id in ids.iter().filter(|id| plain && TAKEN.contains(&id.as_str())) {
            let what = text::CheckTopicTaken { id }.words();
            self.say(at, what, text::CheckTopicTakenRemedy.words());
        }
        ids
    }
}

/// Topics of the hub itself, which no monitor can have.
const TAKEN: [&str; 7] = ["hub", "alarms", "event", "ticket", "command", "alive", "result"];

#[cfg(test)]
#[path = "mqtt_tests.rs"]
mod tests;
