//! OPC UA servers: what a file may say of them.

use std::net::SocketAddr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

use lafet_texts::{Shown, Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;

use super::check::{Check, is_name};
use super::file::File;
use crate::plugs::modbus::access::Level;
use crate::plugs::mqtt::desk::Terms;
use crate::plugs::opcua::{Language, ServerConfig};

/// Most servers.
const SERVERS_MAX: usize = 4;
/// Most monitors of a server.
const MONITORS_MAX: usize = 256;
/// Longest name of a host, characters.
const HOST_MAX: usize = 253;
/// Allowed times without a sign of life of a client, ms.
const ALIVE_MS: RangeInclusive<u64> = 1000..=60_000;
const ALIVE_USUAL_MS: u64 = 3000;
/// Allowed numbers of sessions.
const SESSIONS: RangeInclusive<usize> = 1..=64;
const SESSIONS_USUAL: usize = 16;

/// A server as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Opcua {
    name: Spanned<String>,
    listen: Spanned<String>,
    host: Option<Spanned<String>>,
    #[serde(default)]
    allow: Vec<Spanned<String>>,
    monitors: Option<Vec<Spanned<String>>>,
    #[serde(default = "observer")]
    role: Spanned<Level>,
    #[serde(default = "none")]
    anonymous: Spanned<Level>,
    #[serde(default = "no")]
    plain: Spanned<bool>,
    #[serde(default)]
    language: Language,
    alive_ms: Option<Spanned<u64>>,
    #[serde(default = "yes")]
    close_when_lost: bool,
    sessions_max: Option<Spanned<usize>>,
    cert: Option<Spanned<PathBuf>>,
    key: Option<Spanned<PathBuf>>,
    certificates: Option<PathBuf>,
}

const fn yes() -> bool {
    true
}

fn no() -> Spanned<bool> {
    Spanned::new(0..0, false)
}

fn observer() -> Spanned<Level> {
    Spanned::new(0..0, Level::Observer)
}

fn none() -> Spanned<Level> {
    Spanned::new(0..0, Level::None)
}

impl ServerConfig {
    /// With its certificates in the folder of the hub's data, unless it has a folder of its own.
    #[must_use]
    pub(super) fn in_folder(self, data: &Path) -> Self {
        if !self.folder.as_os_str().is_empty() {
            return self;
        }
        Self { folder: data.join("opcua").join(&self.name), ..self }
    }
}

/// Whether a URL can have it as its host.
fn is_host(text: &str) -> bool {
    let fine = |c: char| c.is_ascii_alphanumeric() || "-._:".contains(c);
    (1..=HOST_MAX).contains(&text.len()) && text.chars().all(fine)
}

impl Check<'_> {
    /// The servers.
    pub fn opcua(&mut self, read: &File) -> Vec<ServerConfig> {
        let mut servers: Vec<ServerConfig> = Vec::new();
        for written in &read.opcua {
            if servers.len() >= SERVERS_MAX {
                let at = written.span().start;
                self.say(at, text::CheckOpcuas.words(), text::CheckOpcuasRemedy.words());
                break;
            }
            if let Some(server) = self.opcua_server(read, written.get_ref(), &servers) {
                servers.push(server);
            }
        }
        servers
    }

    fn opcua_server(
        &mut self,
        read: &File,
        written: &Opcua,
        others: &[ServerConfig],
    ) -> Option<ServerConfig> {
        let (name, at) = (written.name.get_ref(), written.name.span().start);
        if !is_name(name) {
            let what = text::CheckOpcuaName { name }.words();
            self.say(at, what, text::CheckBusNameRemedy.words());
        } else if others.iter().any(|other| other.name == *name) {
            let what = text::CheckBusTwice { name }.words();
            self.say(at, what, text::CheckServerTwiceRemedy.words());
        }
        let allow = self.nets(&written.allow);
        let listen = self.opcua_listen(written, others);
        let host = self.opcua_host(written, listen);
        let monitors = self.plug_monitors(read, &written.name, written.monitors.as_deref());
        if monitors.len() > MONITORS_MAX {
            let (what, remedy) = (text::CheckOpcuaMonitors, text::CheckBrokerMonitorsRemedy);
            self.say(at, what.words(), remedy.words());
        }
        if let Some(alive) = &written.alive_ms {
            self.range(alive, ALIVE_MS, "alive_ms");
        }
        if let Some(most) = &written.sessions_max {
            self.range(most, SESSIONS, "sessions_max");
        }
        let own = self.opcua_own(written);
        let alive = written.alive_ms.as_ref().map_or(ALIVE_USUAL_MS, |it| *it.get_ref());
        let most = written.sessions_max.as_ref().map_or(SESSIONS_USUAL, |it| *it.get_ref());
        let role = *written.role.get_ref();
        let folder = written.certificates.as_ref().map(|it| self.folder.join(it));
        Some(ServerConfig {
            name: name.clone(),
            listen: listen?,
            host,
            allow,
            monitors,
            role,
            anonymous: *written.anonymous.get_ref(),
            plain: *written.plain.get_ref(),
            language: written.language,
            terms: Terms {
                alive: Duration::from_millis(alive),
                closes: written.close_when_lost,
                operates: role == Level::Operator,
            },
            sessions_max: most,
            own,
            folder: folder.unwrap_or_default(),
        })
    }

    fn opcua_listen(&mut self, written: &Opcua, others: &[ServerConfig]) -> Option<SocketAddr> {
        let (text, at) = (written.listen.get_ref(), written.listen.span().start);
        let Some(listen) = text.parse::<SocketAddr>().ok().filter(|it| it.port() != 0) else {
            let what = text::CheckListen { text }.words();
            self.say(at, what, text::CheckOpcuaListenRemedy.words());
            return None;
        };
        if let Some(other) = others.iter().find(|it| it.listen == listen) {
            let what = text::CheckServerSameLine { name: &other.name }.words();
            self.say(at, what, text::CheckServerSameLineRemedy.words());
        }
        if listen.ip().is_loopback() {
            return Some(listen);
        }
        if written.allow.is_empty() {
            let what = text::CheckOpcuaAllow { address: Shown(listen) }.words();
            self.say(at, what, text::CheckOpcuaAllowRemedy.words());
        }
        if *written.plain.get_ref() {
            let what = text::CheckOpcuaPlain { address: Shown(listen) }.words();
            self.say(written.plain.span().start, what, text::CheckOpcuaPlainRemedy.words());
        }
        if *written.anonymous.get_ref() == Level::Operator {
            let what = text::CheckOpcuaAnonymous { address: Shown(listen) }.words();
            let at = written.anonymous.span().start;
            self.say(at, what, text::CheckOpcuaAnonymousRemedy.words());
        }
        Some(listen)
    }

    /// What clients are shown as the server's host.
    fn opcua_host(&mut self, written: &Opcua, listen: Option<SocketAddr>) -> String {
        if let Some(host) = &written.host {
            if !is_host(host.get_ref()) {
                let what = text::CheckOpcuaHost { text: host.get_ref() }.words();
                self.say(host.span().start, what, text::CheckOpcuaHostRemedy.words());
            }
            return host.get_ref().clone();
        }
        let Some(listen) = listen else { return String::new() };
        if listen.ip().is_unspecified() {
            let what = text::CheckOpcuaNoHost { address: Shown(listen) }.words();
            let at = written.listen.span().start;
            self.say(at, what, text::CheckOpcuaHostRemedy.words());
        }
        listen.ip().to_string()
    }

    fn opcua_own(&mut self, written: &Opcua) -> Option<(PathBuf, PathBuf)> {
        match (&written.cert, &written.key) {
            (Some(cert), Some(key)) => {
                let path = |it: &Spanned<PathBuf>| self.folder.join(it.get_ref());
                let (cert, at, key) = (path(cert), key.span().start, path(key));
                self.secret(at, &key);
                Some((cert, key))
            }
            (None, None) => None,
            (Some(one), None) | (None, Some(one)) => {
                let what = text::CheckCertAndKey.words();
                self.say(one.span().start, what, text::CheckCertAndKeyRemedy.words());
                None
            }
        }
    }
}

#[cfg(test)]
#[path = "opcua_tests.rs"]
mod tests;
