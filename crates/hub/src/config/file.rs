//! The file as read, before it is checked.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::path::PathBuf;

use lafet_site::config::Zone;
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::modbus_server::ModbusServer;
use super::mqtt::Mqtt;
use super::opcua::Opcua;
use super::plan::{Area, Blowing, Water};
use super::written::{Bus, Contact, Detector, KeepOut, Output, Pump};
use super::zones::Aim;
use super::{Problem, words};
use crate::access::Role;
use crate::site::{Tank, Wall};
use crate::text::Both;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct File {
    pub server: Server,
    pub tls: Option<Spanned<Tls>>,
    pub authority: Authority,
    pub history: History,
    pub metrics: Metrics,
    pub recording: Recording,
    pub monitor: Vec<Spanned<Monitor>>,
    pub tank: Vec<Spanned<Tank>>,
    pub wall: Vec<Spanned<Wall>>,
    pub keep_out: Vec<Spanned<KeepOut>>,
    pub supply: Option<Spanned<Water>>,
    pub wind: Vec<Spanned<Blowing>>,
    pub coverage: Option<Spanned<Area>>,
    pub modbus: Vec<Spanned<Bus>>,
    pub modbus_server: Vec<Spanned<ModbusServer>>,
    pub mqtt: Vec<Spanned<Mqtt>>,
    pub opcua: Vec<Spanned<Opcua>>,
    pub detector: Vec<Spanned<Detector>>,
    pub zone: Vec<Spanned<Zone>>,
    pub aim: Vec<Spanned<Aim>>,
    pub input: Vec<Spanned<Contact>>,
    pub output: Vec<Spanned<Output>>,
    pub pump: Vec<Spanned<Pump>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Server {
    pub listen: Option<Spanned<String>>,
    pub names: Vec<Spanned<String>>,
    pub origins: Vec<Spanned<String>>,
    pub proxies: Vec<IpAddr>,
    pub login: Spanned<bool>,
    pub plain_http: bool,
    pub data: Option<PathBuf>,
    pub connections_max: Spanned<usize>,
    pub simulation: bool,
}

impl Default for Server {
    fn default() -> Self {
        Self {
            listen: None,
            names: Vec::new(),
            origins: Vec::new(),
            proxies: Vec::new(),
            login: Spanned::new(0..0, true),
            plain_http: false,
            data: None,
            connections_max: Spanned::new(0..0, 2048),
            simulation: false,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tls {
    pub cert: PathBuf,
    pub key: PathBuf,
    pub client_ca: Option<PathBuf>,
    #[serde(default)]
    pub client_roles: BTreeMap<String, Role>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Authority {
    pub lost_ms: Spanned<u64>,
}

impl Default for Authority {
    fn default() -> Self {
        Self { lost_ms: Spanned::new(0..0, 3000) }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct History {
    pub url: Option<Spanned<String>>,
    pub raw_days: Spanned<u32>,
    pub minute_days: Spanned<u32>,
}

impl Default for History {
    fn default() -> Self {
        Self { url: None, raw_days: Spanned::new(0..0, 7), minute_days: Spanned::new(0..0, 400) }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recording {
    pub folder: Option<PathBuf>,
    pub alarms: bool,
    pub before_s: Spanned<u64>,
    pub after_s: Spanned<u64>,
    pub keep_days: Spanned<u32>,
    pub keep_mb: Spanned<u64>,
}

impl Default for Recording {
    fn default() -> Self {
        Self {
            folder: None,
            alarms: true,
            before_s: Spanned::new(0..0, 30),
            after_s: Spanned::new(0..0, 30),
            keep_days: Spanned::new(0..0, 90),
            keep_mb: Spanned::new(0..0, 2000),
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Metrics {
    pub open: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Monitor {
    pub id: Spanned<String>,
    pub url: Spanned<String>,
    pub name: Option<Name>,
    pub poll_ms: Option<Spanned<u64>>,
    pub at: Option<Spanned<[f64; 2]>>,
    #[serde(default)]
    pub heading: f64,
    #[serde(default)]
    pub height: f64,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "name: write \"…\", or { en = \"…\", ru = \"…\" }")]
pub enum Name {
    One(String),
    Two(Both),
}

/// More mistakes than this are not looked for: the file is not one of ours.
const PROBLEMS_MAX: usize = 100;

impl File {
    /// Reads the text as far as it can be read, and everything that is wrong with it. What is wrong is
    /// left out and the rest read again, until it fits. `false`: it is not TOML at all.
    pub fn read(file: &str, text: &str) -> (Self, bool, Vec<Problem>) {
        let remedy = text::CheckExampleRemedy.words();
        let problem = |error: &toml::de::Error| {
            let at = error.span().map_or(0, |span| span.start);
            let message = error.message().trim_end();
            Problem::at(file, text, at, words::of(message), words::meant(message, remedy.clone()))
        };
        let (mut table, wrong) = DeTable::parse_recoverable(text);
        let is_toml = wrong.is_empty();
        let mut problems: Vec<Problem> = wrong.iter().map(problem).collect();
        while problems.len() < PROBLEMS_MAX {
            match Self::deserialize(toml::Deserializer::from(table.clone())) {
                Ok(read) => return (read, is_toml, problems),
                Err(error) => {
                    let at = error.span().map(|span| span.start);
                    problems.push(problem(&error));
                    if !at.is_some_and(|at| leave_out(table.get_mut(), at)) {
                        break;
                    }
                }
            }
        }
        (Self::default(), is_toml, problems)
    }
}

/// Removes the innermost entry whose key or value begins at or around a byte of the text.
fn leave_out(table: &mut DeTable<'_>, at: usize) -> bool {
    if table.iter_mut().any(|(_, value)| leave_out_within(value, at)) {
        return true;
    }
    let mut found = None;
    for (key, value) in table.iter() {
        if key.span().contains(&at) || value.span().contains(&at) {
            found = Some(key.clone());
        }
    }
    found.is_some_and(|key| table.remove(&key).is_some())
}

fn leave_out_within(value: &mut Spanned<DeValue<'_>>, at: usize) -> bool {
    match value.get_mut() {
        DeValue::Table(table) => leave_out(table, at),
        DeValue::Array(array) => {
            if array.iter_mut().any(|it| leave_out_within(it, at)) {
                return true;
            }
            let before = array.len();
            let mut kept = DeArray::new();
            for it in array.iter().filter(|it| !it.span().contains(&at)) {
                kept.push(it.clone());
            }
            let fewer = kept.len() < before;
            *array = kept;
            fewer
        }
        _ => false,
    }
}
