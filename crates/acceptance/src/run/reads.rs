//! Reads everything that is judged before anything moves.

use serde::de::DeserializeOwned;

use lafet_texts::{Shown, Text as _, acceptance as text};

use super::{End, Run, Step};
use crate::facts::Params;
use crate::order::Dry;
use crate::wire::{Failed, Person, Wire};

/// Pause before a read is tried once more, ms.
const AGAIN_MS: u64 = 500;

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
            Ok(value) => serde_json::from_value(value).map(Some).map_err(|error| {
                End::Lost(text::AnswerStrange { path, error: Shown(error) }.words())
            }),
            Err(Failed::Refused { .. }) => Ok(None),
            Err(Failed::Lost(why)) => Err(End::Lost(why)),
        }
    }

    pub(super) async fn read(&mut self) -> Step {
        match self.wire.get("/api/hub").await {
            Ok(_) => {}
            Err(failed) => return Err(End::Lost(failed.words().clone())),
        }
        self.facts.hub = self.get("/api/hub").await?;
        self.facts.date_ms = self.wire.date_ms();
        self.facts.health = self.get("/health").await?;
        self.facts.state = self.get("/api/hub/state").await?;
        self.facts.monitors = self.get("/api/monitors").await?;
        self.facts.zones = self.get("/api/zones").await?;
        self.facts.configured = self.get("/api/zones/configured").await?;
        self.facts.installation = self.get("/api/installation").await?;
        self.facts.buses = self.get("/api/modbus").await?;
        self.facts.alarms = self.get("/api/alarms").await?;
        let monitors: Vec<String> =
            self.facts.monitors.iter().flat_map(|it| it.keys().cloned()).collect();
        for monitor in monitors {
            let order = Dry::Read { monitor: monitor.clone() };
            let params = match self.wire.post(&order.posting()).await {
                Ok(value) => serde_json::from_value::<Params>(value).ok(),
                Err(Failed::Refused { .. }) => None,
                Err(Failed::Lost(why)) => return Err(End::Lost(why)),
            };
            self.facts.params.insert(monitor, params);
        }
        Ok(())
    }
}
