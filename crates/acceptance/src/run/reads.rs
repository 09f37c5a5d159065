//! Reads everything that is judged before anything moves.

use serde::de::DeserializeOwned;
use serde_json::Value;

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::{End, Run, Step};
use crate::facts::{Params, Zones};
use crate::order::Order;
use crate::wire::{Failed, Person, Wire};

/// Pause before a read is tried once more, ms.
const AGAIN_MS: u64 = 500;
/// Tries of a read that is needed.
const TRIES: usize = 2;

fn parsed<T: DeserializeOwned>(path: &str, answer: Value) -> Step<T> {
    serde_json::from_value(answer)
        .map_err(|error| End::Lost(text::AnswerStrange { path, error: Shown(error) }.words()))
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// An answer; `None`: the hub refuses.
    pub(super) async fn get<T: DeserializeOwned>(&mut self, path: &str) -> Step<Option<T>> {
        let answer = match self.wire.get(path).await {
            Err(Failed::Lost(_)) => {
                self.pause(AGAIN_MS).await?;
                self.wire.get(path).await
            }
            answer => answer,
        };
        match answer {
            Ok(value) => parsed(path, value).map(Some),
            Err(Failed::Refused { .. }) => Ok(None),
            Err(failed) => Err(End::of(failed)),
        }
    }

    /// An answer that is needed: what is not known is not safe.
    pub(super) async fn known<T: DeserializeOwned>(&mut self, path: &str) -> Step<T> {
        let mut why = None;
        for _ in 0..TRIES {
            match self.wire.get(path).await {
                Ok(value) => return parsed(path, value),
                Err(Failed::Refused { code, text }) if code != "slow_down" => {
                    return Err(End::Lost(text));
                }
                Err(Failed::Stopped) => return Err(End::Stopped),
                Err(failed) => why = Some(failed.words()),
            }
            self.pause(AGAIN_MS).await?;
        }
        Err(End::Lost(why.unwrap_or_default()))
    }

    pub(super) async fn read(&mut self) -> Step {
        // Without it there is nothing to test: that is no refusal of one request.
        self.wire.get("/api/hub").await.map_err(End::of)?;
        self.facts.hub = self.get("/api/hub").await?;
        self.facts.date_ms = self.wire.date_ms();
        self.facts.health = self.get("/health").await?;
        self.facts.state = self.get("/api/hub/state").await?;
        self.facts.monitors = self.get("/api/monitors").await?;
        // Before the zones: what is read there has come to them.
        self.facts.buses = self.get("/api/modbus").await?;
        self.facts.zones = self.zones().await?;
        self.facts.configured = self.get("/api/zones/configured").await?;
        self.facts.installation = self.get("/api/installation").await?;
        self.facts.alarms = self.get("/api/alarms").await?;
        let monitors: Vec<String> =
            self.facts.monitors.iter().flat_map(|it| it.keys().cloned()).collect();
        for monitor in monitors {
            let params = match self.wire.post(&Order::Read.posting(&monitor)).await {
                Ok(value) => serde_json::from_value::<Params>(value).ok(),
                Err(Failed::Refused { .. }) => None,
                Err(failed) => return Err(End::of(failed)),
            };
            self.facts.params.insert(monitor, params);
        }
        Ok(())
    }

    /// The zones, if there are any.
    async fn zones(&mut self) -> Step<Option<Zones>> {
        match self.wire.get("/api/zones").await {
            Err(Failed::Refused { code, .. }) if code == "no_zones" => {
                self.zoneless = true;
                Ok(None)
            }
            _ => self.get("/api/zones").await,
        }
    }
}
