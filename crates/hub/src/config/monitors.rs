//! The monitors of a file: ids, URLs, periods of polls.

use std::collections::BTreeSet;

use lafet_client::Endpoint;
use lafet_texts::{Text as _, hub as text};

use super::MonitorConfig;
use super::check::{Check, is_name};
use super::file::{Monitor, Name};
use crate::text::Both;

/// Allowed periods of polls. A monitor that is polled less often is not being watched.
const POLL_MS: std::ops::RangeInclusive<u64> = 20..=10_000;
/// On a serial line a state of 14 subsystems takes 0.1 s at 19200 baud.
pub const POLL_SERIAL_MS: u64 = 500;
const POLL_NET_MS: u64 = 200;

impl Check<'_> {
    /// The monitors, without those whose URL cannot be used.
    pub fn monitors(&mut self, read: &[toml::Spanned<Monitor>]) -> Vec<MonitorConfig> {
        if read.is_empty() {
            let what = text::CheckNoMonitor.words();
            let remedy = text::CheckNoMonitorRemedy.words();
            self.say(self.text.len(), what, remedy);
        }
        let (mut ids, mut places) = (BTreeSet::new(), BTreeSet::new());
        let mut monitors = Vec::new();
        for monitor in read {
            let monitor = monitor.get_ref();
            let (id, at) = (monitor.id.get_ref(), monitor.id.span().start);
            if !is_name(id) {
                let what = text::CheckMonitorId { id }.words();
                let remedy = text::CheckMonitorIdRemedy.words();
                self.say(at, what, remedy);
            } else if !ids.insert(id.clone()) {
                let what = text::CheckMonitorTwice { id }.words();
                let remedy = text::CheckMonitorTwiceRemedy.words();
                self.say(at, what, remedy);
            }
            if let Some(endpoint) = self.endpoint(monitor, &mut places) {
                monitors.push(self.monitor(monitor, endpoint));
            }
        }
        monitors
    }

    fn endpoint(&mut self, monitor: &Monitor, places: &mut BTreeSet<String>) -> Option<Endpoint> {
        let (url, at) = (monitor.url.get_ref(), monitor.url.span().start);
        match url.parse::<Endpoint>() {
            Ok(Endpoint::Sim { .. }) => {
                let what = text::CheckNoSimulator.words();
                let remedy = text::CheckNoSimulatorRemedy.words();
                self.say(at, what, remedy);
                None
            }
            Ok(endpoint) if !places.insert(endpoint.to_string()) => {
                let what = text::CheckSameUrl { url }.words();
                let remedy = text::CheckSameUrlRemedy.words();
                self.say(at, what, remedy);
                None
            }
            Ok(endpoint) => Some(endpoint),
            Err(error) => {
                let remedy = text::CheckUrlRemedy.words();
                self.say(at, error.words(), remedy);
                None
            }
        }
    }

    fn monitor(&mut self, monitor: &Monitor, endpoint: Endpoint) -> MonitorConfig {
        if let Some(poll_ms) = &monitor.poll_ms {
            self.range(poll_ms, POLL_MS, "poll_ms");
        }
        let usual = match endpoint {
            Endpoint::Serial { .. } => POLL_SERIAL_MS,
            _ => POLL_NET_MS,
        };
        let id = monitor.id.get_ref();
        let name = match &monitor.name {
            None => Both::same(id),
            Some(Name::One(name)) => Both::same(name),
            Some(Name::Two(name)) => name.clone(),
        };
        let poll_ms = monitor.poll_ms.as_ref().map_or(usual, |poll_ms| *poll_ms.get_ref());
        MonitorConfig { id: id.clone(), name, endpoint, poll_ms }
    }
}
