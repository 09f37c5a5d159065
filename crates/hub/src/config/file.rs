//! The file as it stands, before anything is checked.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::{Problem, words};
use crate::access::Role;
use crate::text::{Both, both};

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

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tank {
    pub name: String,
    pub at: [f64; 2],
    pub diameter: f64,
    pub height: f64,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    pub name: String,
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub height: f64,
}

impl File {
    /// Reads the text.
    pub fn read(file: &str, text: &str) -> Result<Self, Problem> {
        toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            Problem::at(
                file,
                text,
                at,
                words::of(error.message().trim_end()),
                both(
                    "What may stand here: lafet serve --example.",
                    "Что здесь может стоять: lafet serve --example.",
                ),
            )
        })
    }
}
