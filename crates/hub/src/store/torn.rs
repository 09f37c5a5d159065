//! What a database lacks of each series, until it is marked there as not known.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use super::history::{Key, Row};
use crate::sync::lock;

/// From when on a database lacks changes of a series, and from when on minutes; ms since 1970.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hole {
    /// The first change that it lacks.
    pub raw_ms: Option<u64>,
    /// The first minute, or gap, that it lacks.
    pub minute_ms: Option<u64>,
}

/// What is lacking, by series.
#[derive(Debug, Default)]
pub struct Torn(Mutex<HashMap<Arc<Key>, Hole>>);

impl Torn {
    /// The database does not have these rows: what came before them seems to hold there.
    pub fn lose(&self, rows: &[Row]) {
        let mut torn = lock(&self.0);
        let first =
            |before: Option<u64>, at_ms: u64| Some(before.map_or(at_ms, |it| it.min(at_ms)));
        for row in rows {
            match row {
                Row::Raw(key, at_ms, _) => {
                    let hole = torn.entry(key.clone()).or_default();
                    hole.raw_ms = first(hole.raw_ms, *at_ms);
                }
                Row::Minute(key, at_ms, _) | Row::Gap(key, at_ms) => {
                    let hole = torn.entry(key.clone()).or_default();
                    hole.minute_ms = first(hole.minute_ms, *at_ms);
                }
                Row::Known(_) => {}
            }
        }
    }

    /// What is lacking; it is the caller's to mark.
    pub fn take(&self) -> HashMap<Arc<Key>, Hole> {
        std::mem::take(&mut *lock(&self.0))
    }
}
