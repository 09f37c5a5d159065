//! What the hub says of itself between floods, to an administrator at another address.

use std::path::Path;

use serde_json::{Value, json};
use tokio_rustls::TlsConnector;

use crate::Fallible;
use crate::link;

/// Where it is: what the hub counts by address is not that of the floods.
const ADDRESS: &str = "127.0.0.3";

/// Asks the hub.
pub struct Watch {
    place: String,
    token: String,
    tls: Option<TlsConnector>,
    /// Tokens that it has made.
    made: u64,
}

/// The bounds of docs/hub.md that the hub has figures for, and each most.
const BOUNDS: [(&str, f64); 4] = [
    ("lafet_audit_waiting", 20_000.0),
    ("lafet_audit_lost_total", 0.0),
    ("lafet_history_lost_total", 0.0),
    ("lafet_connections", crate::floods::CONNECTIONS as f64),
];

impl Watch {
    /// `tls`: the certificate of the hub.
    pub fn new(place: &str, token: &str, tls: Option<&Path>) -> Fallible<Self> {
        let (place, token, tls) = (place.to_owned(), token.to_owned(), link::connector(tls)?);
        Ok(Self { place, token, tls, made: 0 })
    }

    /// Asks with a token.
    async fn ask(&self, token: &str, path: &str) -> Fallible<(u16, Vec<u8>)> {
        let stream = link::connect_from(ADDRESS, &self.place, self.tls.as_ref()).await?;
        let headers = link::authorization(token);
        let (status, _, body) = link::ask(stream, ("GET", path), &headers, b"").await?;
        Ok((status, body))
    }

    /// The hub knows whom this token belongs to.
    pub async fn knows(&self, token: &str) -> Fallible<()> {
        match self.ask(token, "/api/session").await?.0 {
            200 => Ok(()),
            status => Err(format!("GET /api/session: {status}").into()),
        }
    }

    /// Makes a token of a new administrator.
    pub async fn token(&mut self) -> Fallible<String> {
        self.made += 1;
        let wanted = json!({ "name": format!("flood {}", self.made), "role": "administrator" });
        let made = self.post(&self.token, "/api/tokens", &wanted).await?;
        Ok(made["token"].as_str().ok_or_else(|| format!("{made}"))?.to_owned())
    }

    /// Takes the first monitor for the user of a token: its commands go to the monitor.
    pub async fn take(&self, token: &str) -> Fallible<()> {
        let force = json!({ "action": "force", "reason": "the load" });
        self.post(token, "/api/monitors/M1/authority", &force).await.map(drop)
    }

    async fn post(&self, token: &str, path: &str, body: &Value) -> Fallible<Value> {
        let stream = link::connect_from(ADDRESS, &self.place, self.tls.as_ref()).await?;
        let (headers, body) = (link::authorization(token), body.to_string());
        let answer = link::ask(stream, ("POST", path), &headers, body.as_bytes()).await?;
        match (answer.0, serde_json::from_slice(&answer.2)?) {
            (200..=299, answer) => Ok(answer),
            (status, answer) => Err(format!("{path}: {status} {answer}").into()),
        }
    }

    /// What is beyond its bound.
    pub async fn beyond(&self) -> Fallible<Vec<String>> {
        let (status, body) = self.ask(&self.token, "/metrics").await?;
        let text = String::from_utf8(body)?;
        if status != 200 {
            return Err(format!("GET /metrics: {status}").into());
        }
        let mut beyond = Vec::new();
        for (name, most) in BOUNDS {
            let line = text.lines().find_map(|line| line.strip_prefix(name));
            let value: f64 = line.ok_or_else(|| format!("no {name}"))?.trim().parse()?;
            if value > most {
                beyond.push(format!("{name} {value}"));
            }
        }
        Ok(beyond)
    }

    /// The chain of the audit log is whole; how many entries it has.
    pub async fn verified(&self) -> Fallible<u64> {
        let (status, body) = self.ask(&self.token, "/api/audit/verify").await?;
        let answer: Value = serde_json::from_slice(&body)?;
        match answer["entries"].as_u64() {
            Some(entries) if status == 200 && answer["ok"] == true => Ok(entries),
            _ => Err(format!("GET /api/audit/verify: {status} {answer}").into()),
        }
    }
}
