//! In the place of the history in PostgreSQL where that is not built in: an address cannot be had, so
//! nothing else of it happens.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use lafet_texts::{Text as _, hub as text};

use super::db::StoreError;
use super::history::{AlarmChange, Change, Key};
use super::thin::{Piece, Point};
use super::torn::Hole;
use super::work::Work;
use crate::text::Both;

/// No address of a server.
#[derive(Clone, Debug)]
pub enum Address {}

/// What is wrong, and what to do.
pub type Wrong = (Both, Both);

impl Address {
    /// Says that PostgreSQL is not built in.
    pub fn parse(_: &str, _: &Path) -> Result<Self, Wrong> {
        Err((text::NoPostgres.words(), text::NoPostgresRemedy.words()))
    }

    /// The TLS configuration of the connection.
    pub fn connector(&self) -> Result<(), Both> {
        match *self {}
    }
}

/// In the place of the history in PostgreSQL, which this build does not have.
#[derive(Clone, Debug)]
pub enum Postgres {}

impl Postgres {
    /// Opens the history.
    pub fn open(address: Address) -> Result<Self, StoreError> {
        match address {}
    }

    /// Whether the server takes nothing.
    pub fn is_failing(&self) -> bool {
        match *self {}
    }

    /// Rows that were given up.
    pub fn lost(&self) -> u64 {
        match *self {}
    }

    /// What the server lacks of each series.
    pub fn torn(&self) -> HashMap<Arc<Key>, Hole> {
        match *self {}
    }

    /// Hands work to the thread; `false` if it takes none.
    pub fn post(&self, _: Work) -> bool {
        match *self {}
    }

    /// Like the same method of the SQLite history.
    pub async fn changes_of(
        &self,
        _: &str,
        _: &str,
        _: (u64, u64),
    ) -> Result<Vec<Point>, StoreError> {
        match *self {}
    }

    /// Like the same method of the SQLite history.
    pub async fn minutes_of(
        &self,
        _: &str,
        _: &str,
        _: (u64, u64),
    ) -> Result<Vec<Piece>, StoreError> {
        match *self {}
    }

    /// Like the same method of the SQLite history.
    pub async fn changes(
        &self,
        _: &str,
        _: (u64, u64),
        _: bool,
    ) -> Result<Vec<Change>, StoreError> {
        match *self {}
    }

    /// Like the same method of the SQLite history.
    pub async fn alarms(
        &self,
        _: Option<&str>,
        _: (u64, u64),
        _: u32,
    ) -> Result<Vec<AlarmChange>, StoreError> {
        match *self {}
    }
}
