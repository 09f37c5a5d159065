//! The monitors of a file: ids, URLs, periods of polls.

use std::collections::BTreeSet;

use lafet_client::{Endpoint, Lang};

use super::MonitorConfig;
use super::check::Check;
use super::file::{Monitor, Name};
use crate::text::both;

/// Allowed periods of polls. A monitor that is polled less often is not being watched.
const POLL_MS: std::ops::RangeInclusive<u64> = 20..=10_000;
/// On a serial line a state of 14 subsystems takes 0.1 s at 19200 baud.
pub const POLL_SERIAL_MS: u64 = 500;
const POLL_NET_MS: u64 = 200;

impl Check<'_> {
    /// The monitors, without those whose URL cannot be used.
    pub fn monitors(&mut self, read: &[toml::Spanned<Monitor>]) -> Vec<MonitorConfig> {
        if read.is_empty() {
            let what = both("There is no monitor.", "Не указан ни один ствол.");
            let remedy = both(
                "Add one: [[monitor]] with id = \"M1\" and url = \"tcp://192.168.1.50?addr=1\".",
                "Добавьте: [[monitor]], id = \"M1\", url = \"tcp://192.168.1.50?addr=1\".",
            );
            self.say(self.text.len(), what, remedy);
        }
        let (mut ids, mut places) = (BTreeSet::new(), BTreeSet::new());
        let mut monitors = Vec::new();
        for monitor in read {
            let monitor = monitor.get_ref();
            let (id, at) = (monitor.id.get_ref(), monitor.id.span().start);
            let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if id.is_empty() || id.len() > 32 || !id.chars().all(fine) {
                let what = both(format!("`{id}` is not an id."), format!("`{id}` — не id."));
                let remedy = both(
                    "Write 1…32 letters a–z, digits, - or _; what people read is name.",
                    "Допустимо 1…32 латинских букв, цифр, - и _; для людей служит name.",
                );
                self.say(at, what, remedy);
            } else if !ids.insert(id.clone()) {
                let what = both(format!("{id} is given twice."), format!("{id} указан дважды."));
                let remedy = both("Give each monitor an id of its own.", "id стволов различны.");
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
                let what =
                    both("The hub has no simulator inside.", "В сервере объекта нет имитатора.");
                let remedy = both(
                    "Run `lafet sim` and write the address that it prints.",
                    "Запустите `lafet sim` и укажите напечатанный адрес.",
                );
                self.say(at, what, remedy);
                None
            }
            Ok(endpoint) if !places.insert(endpoint.to_string()) => {
                let what = both(
                    format!("{url}: two monitors with the same URL."),
                    format!("{url}: два ствола с одним URL."),
                );
                let remedy = both(
                    "Give each its own address: ?addr=2.",
                    "Дайте каждому свой адрес: ?addr=2.",
                );
                self.say(at, what, remedy);
                None
            }
            Ok(endpoint) => Some(endpoint),
            Err(error) => {
                let what = both(error.localized(Lang::En), error.localized(Lang::Ru));
                let remedy = both(
                    "Write tcp://HOST:PORT?addr=1, udp://… or serial:///dev/ttyUSB0?baud=19200.",
                    "Напишите tcp://УЗЕЛ:ПОРТ?addr=1, udp://… или \
                     serial:///dev/ttyUSB0?baud=19200.",
                );
                self.say(at, what, remedy);
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
            None => both(id, id),
            Some(Name::One(name)) => both(name, name),
            Some(Name::Two(name)) => name.clone(),
        };
        let poll_ms = monitor.poll_ms.as_ref().map_or(usual, |poll_ms| *poll_ms.get_ref());
        MonitorConfig { id: id.clone(), name, endpoint, poll_ms }
    }
}
