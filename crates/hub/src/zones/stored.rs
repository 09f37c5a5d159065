//! What survives the end of the hub: beside users and tokens, in the file without which no hub starts.

use std::path::Path;

use lafet_site::Persisted;
use lafet_texts::{Shown, Text as _, hub as text};
use rusqlite::OptionalExtension;

use crate::store::{Db, StoreError, open};

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS zones (
  one INTEGER PRIMARY KEY CHECK (one = 1), value TEXT NOT NULL
) STRICT;
PRAGMA synchronous = FULL;";

/// Where the state of the zones is stored.
#[derive(Clone, Debug)]
pub struct Stored(Db);

impl Stored {
    /// Opens it in a folder, or in memory, with what is stored there.
    pub fn open(folder: Option<&Path>) -> Result<(Self, Option<Persisted>), StoreError> {
        let db = open(folder, "hub.db", SCHEMA)?;
        let text: Option<String> =
            db.query_row("SELECT value FROM zones", [], |row| row.get(0)).optional()?;
        let persisted = text.map(|text| serde_json::from_str(&text)).transpose();
        let persisted = persisted
            .map_err(|error| StoreError::Zones(text::StoreZones { error: Shown(error) }.words()))?;
        Ok((Self(Db::new("zones", db)?), persisted))
    }

    /// Stores it; it is on the disk when this returns.
    pub async fn write(&self, persisted: &Persisted) -> Result<(), StoreError> {
        let text = serde_json::to_string(persisted).unwrap_or_default();
        let row = "INSERT OR REPLACE INTO zones VALUES (1, ?1)";
        self.0.call(move |db| db.execute(row, [text]).map(drop)).await
    }
}
