//! Servers for masters on Modbus: what a file may say of them.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::ops::RangeInclusive;
use std::time::Duration;

use lafet_client::Endpoint;
use lafet_texts::{Shown, Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;

use super::check::{Check, is_name};
use super::field::UNITS;
use super::file::File;
use crate::field::line::Line;
use crate::plugs::modbus::access::{Grant, Level, Net};
use crate::plugs::modbus::desk::Terms;
use crate::plugs::modbus::layout::{COMMAND, COMMAND_LAST, MONITORS};
use crate::plugs::modbus::{Place, ServerConfig};

/// Allowed times within which the heartbeat changes, ms.
const HEARTBEAT_MS: RangeInclusive<u64> = 50..=10_000;
const HEARTBEAT_USUAL_MS: u64 = 150;
/// Beats that are farther apart move nothing by hand, ms.
const JOG_MS: u64 = 300;
/// Allowed times for a result, ms.
const ANSWER_MS: RangeInclusive<u64> = 500..=60_000;
const ANSWER_USUAL_MS: u64 = 5000;
/// Allowed times without a request, s.
const IDLE_S: RangeInclusive<u64> = 1..=3600;
const IDLE_USUAL_S: u64 = 60;
/// Allowed numbers of connections.
const CONNECTIONS: RangeInclusive<usize> = 1..=64;
const CONNECTIONS_USUAL: usize = 8;
/// Most servers, and most entries of a list.
const LIST_MAX: usize = 64;

/// A server as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModbusServer {
    pub name: Spanned<String>,
    pub listen: Spanned<String>,
    #[serde(default)]
    pub allow: Vec<Spanned<String>>,
    pub unit: Option<Spanned<u32>>,
    pub monitors: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    pub role: Level,
    #[serde(default)]
    pub client: Vec<Spanned<Client>>,
    pub heartbeat_ms: Option<Spanned<u64>>,
    pub answer_ms: Option<Spanned<u64>>,
    pub idle_s: Option<Spanned<u64>>,
    pub connections_max: Option<Spanned<usize>>,
    #[serde(default)]
    pub close_when_lost: bool,
}

/// What some masters may do, as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Client {
    pub name: Spanned<String>,
    #[serde(default)]
    pub from: Vec<Spanned<String>>,
    #[serde(default)]
    pub units: Vec<Spanned<u32>>,
    pub registers: Option<Spanned<[u16; 2]>>,
    pub role: Level,
}

fn value<T: Copy>(written: Option<&Spanned<T>>, usual: T) -> T {
    written.map_or(usual, |it| *it.get_ref())
}

impl Check<'_> {
    /// The servers.
    pub fn modbus_servers(&mut self, read: &File) -> Vec<ServerConfig> {
        let mut servers: Vec<ServerConfig> = Vec::new();
        for written in &read.modbus_server {
            let at = written.span().start;
            if servers.len() >= LIST_MAX {
                self.say(at, text::CheckServers.words(), text::CheckServersRemedy.words());
                break;
            }
            if let Some(server) = self.modbus_server(read, written.get_ref(), &servers) {
                servers.push(server);
            }
        }
        servers
    }

    fn modbus_server(
        &mut self,
        read: &File,
        written: &ModbusServer,
        others: &[ServerConfig],
    ) -> Option<ServerConfig> {
        self.server_name(&written.name);
        let (name, at) = (written.name.get_ref(), written.name.span().start);
        if others.iter().any(|other| other.name == *name) {
            let what = text::CheckBusTwice { name }.words();
            self.say(at, what, text::CheckServerTwiceRemedy.words());
        }
        self.server_ranges(written);
        let allow = self.nets(&written.allow);
        let place = self.place(read, written, others);
        let (monitors, unit) = self.unit_and_monitors(read, written);
        let last = unit.saturating_add(monitors.len().div_ceil(MONITORS) as u8).saturating_sub(1);
        let mut grants: Vec<Grant> = Vec::new();
        let serial = matches!(place, Some(Place::Serial(_)));
        for client in &written.client {
            let grant = self.grant(client.get_ref(), unit..=last, serial);
            grants.push(grant);
        }
        if written.role != Level::None {
            grants.push(Grant {
                name: name.clone(),
                from: Vec::new(),
                units: Vec::new(),
                registers: 0..=u16::MAX,
                level: written.role,
            });
        }
        if grants.is_empty() {
            let what = text::CheckServerForNone { name }.words();
            self.say(at, what, text::CheckServerForNoneRemedy.words());
        }
        let heartbeat = value(written.heartbeat_ms.as_ref(), HEARTBEAT_USUAL_MS);
        let answer = value(written.answer_ms.as_ref(), ANSWER_USUAL_MS);
        Some(ServerConfig {
            name: name.clone(),
            place: place?,
            allow,
            unit,
            monitors,
            grants,
            terms: Terms {
                heartbeat: Duration::from_millis(heartbeat),
                answer: Duration::from_millis(answer),
                closes: written.close_when_lost,
            },
            idle: Duration::from_secs(value(written.idle_s.as_ref(), IDLE_USUAL_S)),
            connections_max: value(written.connections_max.as_ref(), CONNECTIONS_USUAL),
        })
    }

    fn server_ranges(&mut self, written: &ModbusServer) {
        if let Some(heartbeat) = &written.heartbeat_ms {
            self.range(heartbeat, HEARTBEAT_MS, "heartbeat_ms");
            if *heartbeat.get_ref() > JOG_MS && HEARTBEAT_MS.contains(heartbeat.get_ref()) {
                let what = text::CheckSlowHeartbeat { ms: *heartbeat.get_ref() }.words();
                let remedy = text::CheckSlowHeartbeatRemedy { ms: JOG_MS }.words();
                self.warn(heartbeat.span().start, what, remedy);
            }
        }
        if let Some(answer) = &written.answer_ms {
            self.range(answer, ANSWER_MS, "answer_ms");
        }
        if let Some(idle) = &written.idle_s {
            self.range(idle, IDLE_S, "idle_s");
        }
        if let Some(most) = &written.connections_max {
            self.range(most, CONNECTIONS, "connections_max");
        }
    }

    fn server_name(&mut self, name: &Spanned<String>) {
        let text = name.get_ref();
        if !is_name(text) {
            let what = text::CheckServerName { name: text }.words();
            self.say(name.span().start, what, text::CheckBusNameRemedy.words());
        }
    }

    pub(super) fn nets(&mut self, written: &[Spanned<String>]) -> Vec<Net> {
        let mut nets = Vec::new();
        for text in written.iter().take(LIST_MAX) {
            match Net::parse(text.get_ref()) {
                Some(net) => nets.push(net),
                None => {
                    let what = text::CheckNet { text: text.get_ref() }.words();
                    self.say(text.span().start, what, text::CheckNetRemedy.words());
                }
            }
        }
        if let Some(surplus) = written.get(LIST_MAX) {
            let at = surplus.span().start;
            self.say(at, text::CheckNets.words(), text::CheckNetsRemedy.words());
        }
        nets
    }

    fn place(
        &mut self,
        read: &File,
        written: &ModbusServer,
        others: &[ServerConfig],
    ) -> Option<Place> {
        let (line, at) = (self.line(&written.listen)?, written.listen.span().start);
        let place = match &line {
            Line::Tcp { host, port, framing } => {
                let Ok(ip) = host.parse() else {
                    let what = text::CheckListenName { host }.words();
                    self.say(at, what, text::CheckListenNameRemedy.words());
                    return None;
                };
                let address = SocketAddr::new(ip, *port);
                if !address.ip().is_loopback() && written.allow.is_empty() {
                    let what = text::CheckAllow { address: Shown(address) }.words();
                    self.say(at, what, text::CheckAllowRemedy.words());
                }
                Place::Tcp(address, *framing)
            }
            Line::Serial { path, .. } => {
                if let Some(first) = written.allow.first() {
                    let what = text::CheckAllowOnSerial.words();
                    self.say(first.span().start, what, text::CheckAllowOnSerialRemedy.words());
                }
                let buses = read.modbus.iter().map(|it| it.get_ref().url.get_ref());
                let mut buses = buses.filter_map(|url| Line::parse(url).ok());
                let monitors = read.monitor.iter().map(|it| it.get_ref().url.get_ref());
                let has_it = |url: &String| match url.parse() {
                    Ok(Endpoint::Serial { path: other, .. }) => other == *path,
                    _ => false,
                };
                if buses.any(|bus| bus.device() == Some(path)) || monitors.into_iter().any(has_it) {
                    let what = text::CheckServerPort.words();
                    self.say(at, what, text::CheckServerPortRemedy.words());
                }
                Place::Serial(line.clone())
            }
        };
        let same = |other: &&ServerConfig| match (&other.place, &place) {
            (Place::Tcp(own, _), Place::Tcp(other, _)) => own == other,
            (Place::Serial(own), Place::Serial(other)) => own.device() == other.device(),
            _ => false,
        };
        if let Some(other) = others.iter().find(same) {
            let what = text::CheckServerSameLine { name: &other.name }.words();
            self.say(at, what, text::CheckServerSameLineRemedy.words());
        }
        Some(place)
    }

    fn unit_and_monitors(&mut self, read: &File, written: &ModbusServer) -> (Vec<String>, u8) {
        let monitors = self.plug_monitors(read, &written.name, written.monitors.as_deref());
        let unit = value(written.unit.as_ref(), 1);
        if let Some(written) = &written.unit {
            self.range(written, UNITS, "unit");
        }
        let last = unit as usize + monitors.len().div_ceil(MONITORS).max(1) - 1;
        if last > *UNITS.end() as usize && UNITS.contains(&unit) {
            let at = written.unit.as_ref().map_or(0, |it| it.span().start);
            let what = text::CheckServerUnits { last: last as u64 }.words();
            self.say(at, what, text::CheckServerUnitsRemedy.words());
        }
        (monitors, u8::try_from(unit).unwrap_or(1))
    }

    /// The monitors that a plug of this name shows: all, or those of its list.
    pub(super) fn plug_monitors(
        &mut self,
        read: &File,
        name: &Spanned<String>,
        listed: Option<&[Spanned<String>]>,
    ) -> Vec<String> {
        let known: Vec<&str> =
            read.monitor.iter().map(|it| it.get_ref().id.get_ref().as_str()).collect();
        let Some(ids) = listed else { return known.into_iter().map(str::to_owned).collect() };
        if ids.is_empty() {
            let what = text::CheckServerEmpty { name: name.get_ref() }.words();
            self.say(name.span().start, what, text::CheckServerEmptyRemedy.words());
        }
        let mut seen = BTreeSet::new();
        for id in ids {
            let (id, at) = (id.get_ref(), id.span().start);
            if !known.contains(&id.as_str()) && !self.lacks("monitor", known.len()) {
                let what = text::CheckServerMonitor { id }.words();
                self.say(at, what, text::CheckServerMonitorRemedy.words());
            } else if !seen.insert(id) {
                let what = text::CheckBusTwice { name: id }.words();
                self.say(at, what, text::CheckServerMonitorRemedy.words());
            }
        }
        ids.iter().map(|id| id.get_ref().clone()).collect()
    }

    fn grant(&mut self, client: &Client, units: RangeInclusive<u8>, serial: bool) -> Grant {
        self.server_name(&client.name);
        let from = self.nets(&client.from);
        if let Some(first) = client.from.first().filter(|_| serial) {
            let what = text::CheckAllowOnSerial.words();
            self.say(first.span().start, what, text::CheckAllowOnSerialRemedy.words());
        }
        for unit in &client.units {
            let (from, to) = (u32::from(*units.start()), u32::from(*units.end()));
            self.range(unit, from..=to, "units");
        }
        let registers = client.registers.as_ref().map_or([0, u16::MAX], |it| *it.get_ref());
        if registers[0] > registers[1] {
            let at = client.registers.as_ref().map_or(0, |it| it.span().start);
            self.say(at, text::CheckRegisters.words(), text::CheckRegistersRemedy.words());
        } else if let Some(written) = &client.registers {
            let reached = registers[0] <= COMMAND && registers[1] >= COMMAND_LAST;
            if client.role != Level::None && !reached {
                let what = text::CheckNoStop { name: client.name.get_ref() }.words();
                let remedy = text::CheckNoStopRemedy { first: COMMAND, last: COMMAND_LAST }.words();
                self.warn(written.span().start, what, remedy);
            }
        }
        let units = client.units.iter().filter_map(|it| u8::try_from(*it.get_ref()).ok());
        Grant {
            name: client.name.get_ref().clone(),
            from,
            units: units.collect(),
            registers: registers[0]..=registers[1],
            level: client.role,
        }
    }
}

#[cfg(test)]
#[path = "modbus_server_tests.rs"]
mod tests;
