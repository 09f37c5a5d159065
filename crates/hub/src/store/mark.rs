//! What ties the files of the state together, so that a file that is missing, foreign, cut or older
//! than the others shows at the start.
//!
//! Each database holds the id of the site. `hub.db` and `site.json` hold the head of the audit log as
//! it was noted last; `audit.db` and `site.json` how often users and tokens were changed. Older
//! copies of all files together are not noticed here: the head of the audit
//! log is in the program's own log for that.

use std::path::Path;

use lafet_texts::{Lang, Shown, Text as _, hub as text};
use rusqlite::{Connection, OptionalExtension, params};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::audit::head;
use super::db::{StoreError, is_malformed, is_of_disk, open, private, replace, said_corrupt};
use super::format::{FORMAT, PROGRAM};
use crate::access::digest;
use crate::text::Both;

/// The table of the mark, in each database.
pub const TABLE: &str = "
CREATE TABLE IF NOT EXISTS site (
  one INTEGER PRIMARY KEY CHECK (one = 1), id TEXT NOT NULL, users INTEGER NOT NULL DEFAULT 0,
  set_up INTEGER NOT NULL DEFAULT 0, audit_n INTEGER NOT NULL DEFAULT 0,
  audit_hash TEXT NOT NULL DEFAULT ''
) STRICT;";

/// The file beside the databases.
const MANIFEST: &str = "site.json";

/// A file of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum StateFile {
    /// Users, sessions, tokens.
    Hub,
    /// The audit log.
    Audit,
    /// Events and alarms.
    Events,
    /// The history.
    History,
    /// The mark beside the databases.
    Site,
    /// What is revoked and not in `hub.db` yet.
    Revoked,
}

/// What is wrong with a file of the state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "fault", rename_all = "snake_case")]
#[schema(as = StateFault)]
pub enum Fault {
    /// It is not there, or empty.
    Missing,
    /// It belongs to another site, or to none.
    Foreign,
    /// It ends before what was noted of it: it was cut, or is an older copy.
    Older {
        /// Entries, or changes of users and tokens, that were noted.
        noted: u64,
        /// Entries that were found.
        found: u64,
    },
    /// This entry is not the one that was noted.
    Changed {
        /// Number of the entry.
        n: u64,
    },
    /// There were users, and there is none.
    Emptied,
    /// Users or tokens are not as the hub has left them, and its log has no entry for it.
    Altered,
    /// The disk does not let it be read: the hub works without what is in it, and leaves it as it is.
    Unread {
        /// What was found.
        error: String,
    },
    /// It cannot be read: no database, damaged, or one of another program.
    Malformed {
        /// What was found.
        error: String,
        /// Its name now; a new file has its old one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aside: Option<String>,
    },
}

/// A file of the state that is not as the others say.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Loss {
    /// The file.
    pub file: StateFile,
    /// What is wrong with it.
    #[serde(flatten)]
    pub fault: Fault,
}

/// How often users and tokens were changed, and whether there ever was a user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Users {
    /// Changes of users and tokens.
    pub changes: u64,
    /// Whether a user was ever added.
    pub set_up: bool,
}

/// An entry of the audit log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// Its number; 0: there is none.
    pub n: u64,
    /// Hash of the last entry.
    pub hash: String,
}

/// What a file says of the site.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    /// The id of the site.
    pub site: String,
    /// Changes of users and tokens.
    pub users: Users,
    /// The end of the audit log.
    pub audit: Head,
    /// Digest of users and tokens; `site.json` alone has it.
    #[serde(default)]
    pub people: String,
}

/// Contents of `site.json`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Manifest {
    /// The format of the state.
    version: u32,
    /// The version of the program that wrote it.
    #[serde(default)]
    program: String,
    /// `false`: the files are being marked for the first time.
    complete: bool,
    /// The hub has ended, and changes nothing any more.
    #[serde(default)]
    ended: bool,
    /// `history.db` is one of the files.
    history: bool,
    #[serde(flatten)]
    mark: Mark,
}

impl Manifest {
    fn of_this_program() -> Self {
        Self { version: FORMAT, program: PROGRAM.to_owned(), ..Self::default() }
    }
}

impl StateFile {
    /// Those that are tied to each other, and examined before they are opened.
    pub const ALL: [Self; 5] = [Self::Hub, Self::Audit, Self::Events, Self::History, Self::Site];

    /// As it is written on the command line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Hub => "hub",
            Self::Audit => "audit",
            Self::Events => "events",
            Self::History => "history",
            Self::Site => "site",
            Self::Revoked => "revoked",
        }
    }

    /// Its name in the folder.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hub => "hub.db",
            Self::Audit => "audit.db",
            Self::Events => "events.db",
            Self::History => "history.db",
            Self::Site => MANIFEST,
            Self::Revoked => "revoked",
        }
    }

    /// The hub does not start without it; the others can be replaced by empty ones.
    const fn is_needed(self) -> bool {
        matches!(self, Self::Hub | Self::Audit)
    }
}

impl Loss {
    /// The hub does not start unless this is accepted. Users who were altered are no loss: a hub that does not
    /// start stops no water. Nor is an audit log that cannot be read: a hub whose disk fails while it runs goes on.
    pub fn is_grave(&self) -> bool {
        let is_lost = !matches!(self.fault, Fault::Altered | Fault::Unread { .. });
        self.file.is_needed() && is_lost
    }

    /// Moves the file aside if it cannot be read.
    pub fn set_aside(&mut self, folder: &Path) -> Result<(), StoreError> {
        let path = folder.join(self.file.name());
        if let Fault::Malformed { aside, .. } = &mut self.fault {
            let name = super::db::set_aside(&path)?;
            *aside = name.file_name().map(|it| it.to_string_lossy().into_owned());
        }
        Ok(())
    }

    /// The fault, in words.
    pub fn both(&self) -> Both {
        let name = self.file.name();
        match &self.fault {
            Fault::Missing => text::StateMissing { name }.words(),
            Fault::Foreign => text::StateForeign { name }.words(),
            Fault::Older { noted, found } => text::StateCut { name, found, noted }.words(),
            Fault::Changed { n } => text::StateChanged { name, n }.words(),
            Fault::Emptied => text::StateNoUsers { name }.words(),
            Fault::Altered => text::StateAltered { name }.words(),
            Fault::Unread { error } => text::StateUnread { name, error }.words(),
            Fault::Malformed { error, aside: None } => text::StateMalformed { name, error }.words(),
            Fault::Malformed { error, aside: Some(aside) } => {
                text::StateSetAside { name, error, aside }.words()
            }
        }
    }
}

/// A database that is there.
struct Found {
    connection: Connection,
    mark: Option<Mark>,
}

/// What is at the place of a file of the state.
enum Look {
    Nothing,
    Found(Found),
    Malformed(String),
    /// The disk does not let it be read.
    Unread(rusqlite::Error),
}

impl Look {
    const fn found(&self) -> Option<&Found> {
        match self {
            Self::Found(found) => Some(found),
            Self::Nothing | Self::Malformed(_) | Self::Unread(_) => None,
        }
    }
}

/// What the files were found to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Examined {
    /// The id of the site, if one was given.
    pub site: Option<String>,
    /// The folder was never used: nothing is in it, or what a first start that was cut off has left.
    pub is_new: bool,
    /// All files were marked by an earlier start.
    pub is_whole: bool,
    /// What is wrong.
    pub losses: Vec<Loss>,
}

/// Looks at the files before anything is opened.
pub fn examine(folder: &Path, history: bool) -> Result<Examined, StoreError> {
    let manifest = manifest(folder);
    let mut files = Vec::new();
    for file in [StateFile::Hub, StateFile::Audit, StateFile::Events, StateFile::History] {
        if file != StateFile::History || history {
            files.push((file, look(folder, file)?));
        }
    }
    let mut losses = Vec::new();
    let mut say = |file, fault| losses.push(Loss { file, fault });
    for (file, it) in &files {
        match it {
            Look::Malformed(error) => {
                say(*file, Fault::Malformed { error: error.clone(), aside: None });
            }
            Look::Unread(error) => say(*file, Fault::Unread { error: error.to_string() }),
            Look::Nothing | Look::Found(_) => {}
        }
    }
    if let Err(error) = &manifest {
        say(StateFile::Site, Fault::Malformed { error: error.clone(), aside: None });
    }
    let is_gone = matches!(manifest, Ok(None));
    let manifest = manifest.ok().flatten();
    let marks = files.iter().filter_map(|(_, it)| it.found()?.mark.as_ref());
    let first = manifest.as_ref().map(|it| &it.mark).or_else(|| marks.clone().next());
    let site = first.map(|mark| mark.site.clone());
    let is_whole = manifest.as_ref().is_some_and(|it| it.complete);
    // Without its users no one is let in, and without its mark no file is missed.
    let unread = files.into_iter().map(|(file, it)| match it {
        Look::Unread(error) if file == StateFile::Hub || !is_whole => {
            Err(StoreError::File(folder.join(file.name()), error))
        }
        it => Ok((file, it)),
    });
    let files = unread.collect::<Result<Vec<_>, _>>()?;
    let is_new = site.is_none() && is_unused(&files)?;
    if is_new || manifest.as_ref().is_some_and(|it| !it.complete) {
        return Ok(Examined { site, is_new, is_whole, losses });
    }
    if is_gone && site.is_some() {
        say(StateFile::Site, Fault::Missing);
    }
    let used = |file| file != StateFile::History || manifest.as_ref().is_some_and(|it| it.history);
    for (file, it) in &files {
        match it {
            Look::Nothing if used(*file) => say(*file, Fault::Missing),
            Look::Found(it)
                if site.is_some() && it.mark.as_ref().map(|it| &it.site) != site.as_ref() =>
            {
                say(*file, Fault::Foreign);
            }
            _ => {}
        }
    }
    compare(&files, site.as_deref(), manifest.as_ref(), &mut say)?;
    Ok(Examined { site, is_new, is_whole, losses })
}

/// Whether files that have no id hold nothing: a start makes the table of the mark first, in each of them, and
/// fills it when all are there. Those of programs without marks have no such table.
fn is_unused(files: &[(StateFile, Look)]) -> Result<bool, StoreError> {
    for (file, found) in files.iter().filter_map(|(file, it)| Some((file, it.found()?))) {
        let db = &found.connection;
        let holds = match file {
            StateFile::Hub => "user",
            StateFile::Audit => "audit",
            _ => "site",
        };
        let query = format!("SELECT EXISTS (SELECT 1 FROM {holds})");
        let in_use = !has(db, "site")?
            || has(db, holds)? && db.query_row(&query, [], |row| row.get::<_, bool>(0))?;
        if in_use {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Begins a folder: until all files are marked a start that is cut off is made good by the next one.
pub fn begin(folder: &Path, site: &str, history: bool) -> Result<(), StoreError> {
    let mark = Mark { site: site.to_owned(), ..Mark::default() };
    write(folder, &Manifest { history, mark, ..Manifest::of_this_program() })
}

/// Compares what the files of this site say of each other.
fn compare(
    files: &[(StateFile, Look)],
    site: Option<&str>,
    manifest: Option<&Manifest>,
    say: &mut impl FnMut(StateFile, Fault),
) -> Result<(), StoreError> {
    let ours = |file| {
        let (_, found) = files.iter().find(|(it, _)| *it == file)?;
        found.found().filter(|it| it.mark.as_ref().map(|it| it.site.as_str()) == site)
    };
    let (hub, audit) = (ours(StateFile::Hub), ours(StateFile::Audit));
    let beside = manifest.map(|it| it.mark.clone());
    let mark = |found: Option<&Found>| found.and_then(|it| it.mark.clone());
    if let Some(audit) = audit
        && let Some(noted) = [mark(hub), beside.clone()]
            .into_iter()
            .flatten()
            .map(|it| it.audit)
            .max_by_key(|it| it.n)
        && let Some(fault) = or_malformed(check_audit(&audit.connection, &noted))?
    {
        say(StateFile::Audit, fault);
    }
    if let Some(hub) = hub {
        let noted: Vec<Users> =
            [mark(audit), beside].into_iter().flatten().map(|it| it.users).collect();
        let own = hub.mark.as_ref().map(|it| it.users).unwrap_or_default();
        let fault = or_malformed(check_users(&hub.connection, own, &noted))?;
        let is_unread =
            |(file, it): &(_, Look)| *file == StateFile::Audit && matches!(it, Look::Unread(_));
        let log = audit.map(|it| &it.connection);
        let altered = match (&fault, manifest) {
            (None, Some(manifest)) if log.is_some() || files.iter().any(is_unread) => {
                or_malformed(check_people(&hub.connection, own, manifest, log))?
            }
            _ => None,
        };
        if let Some(fault) = fault.or(altered) {
            say(StateFile::Hub, fault);
        }
    }
    Ok(())
}

fn or_malformed(
    checked: Result<Option<Fault>, rusqlite::Error>,
) -> Result<Option<Fault>, StoreError> {
    match checked {
        Err(error) if is_malformed(&error) => {
            Ok(Some(Fault::Malformed { error: error.to_string(), aside: None }))
        }
        checked => Ok(checked?),
    }
}

/// Gives every file the id of the site, but those that the disk does not let be read, and notes how the others are now.
/// What `hub.db` had noted of the end of the audit log, as far as that is there, and what is noted now.
pub fn mark(
    folder: &Path,
    site: &str,
    history: bool,
    unread: &[StateFile],
) -> Result<(Head, Mark), StoreError> {
    let noted = manifest(folder).ok().flatten().filter(|it| it.complete && it.mark.site == site);
    // A start that is cut off leaves what was noted before it: the next one checks against that.
    if noted.is_none() {
        begin(folder, site, history)?;
    }
    let hub = open_marked(folder, StateFile::Hub, site)?;
    let is_there = |file| !unread.contains(&file) && (file != StateFile::History || history);
    let open = |file| match is_there(file).then(|| open_marked(folder, file, site)).transpose() {
        Err(error) if noted.is_some() && error.is_of_disk() => {
            tracing::error!(%error, "it is not marked");
            Ok(None)
        }
        opened => opened,
    };
    let audit = open(StateFile::Audit)?;
    open(StateFile::Events)?;
    open(StateFile::History)?;
    hub.execute("UPDATE site SET set_up = EXISTS (SELECT 1 FROM user)", [])?;
    let Some(audit) = audit else {
        // The log is compared with what was noted when it can be read again.
        let noted = noted.ok_or(StoreError::Unread)?.mark;
        note(folder, &noted, history, false)?;
        return Ok((noted_head(&hub)?, noted));
    };
    let mut before = noted_head(&hub)?;
    if check_audit(&audit, &before)?.is_some() {
        before = Head::default();
    }
    let (n, hash) = head(&audit)?;
    let (users, people) = (users(&hub)?, people(&hub)?);
    let mark = Mark { site: site.into(), users, audit: Head { n, hash }, people };
    note_audit(&hub, &mark.audit)?;
    note_users(&audit, mark.users)?;
    note(folder, &mark, history, false)?;
    Ok((before, mark))
}

/// Writes `site.json`; `ended`: nothing of this is changed any more.
pub fn note(folder: &Path, mark: &Mark, history: bool, ended: bool) -> Result<(), StoreError> {
    let (complete, mark) = (true, mark.clone());
    write(folder, &Manifest { complete, ended, history, mark, ..Manifest::of_this_program() })
}

/// Notes in `hub.db` where the audit log ends.
pub fn note_audit(hub: &Connection, head: &Head) -> Result<(), rusqlite::Error> {
    let n = i64::try_from(head.n).unwrap_or(i64::MAX);
    hub.execute("UPDATE site SET audit_n = ?1, audit_hash = ?2", params![n, head.hash]).map(drop)
}

/// Notes in `audit.db` how often users and tokens were changed.
pub fn note_users(audit: &Connection, users: Users) -> Result<(), rusqlite::Error> {
    let changes = i64::try_from(users.changes).unwrap_or(i64::MAX);
    let row = params![changes, users.set_up];
    audit.execute("UPDATE site SET users = ?1, set_up = ?2", row).map(drop)
}

/// How often users and tokens were changed, as `hub.db` counts it.
pub fn users(hub: &Connection) -> Result<Users, rusqlite::Error> {
    Ok(read(hub)?.map(|it| it.users).unwrap_or_default())
}

/// The end of the audit log as a database has it noted.
fn noted_head(hub: &Connection) -> Result<Head, rusqlite::Error> {
    Ok(read(hub)?.map(|it| it.audit).unwrap_or_default())
}

/// Whether an audit log that could not be read at the start is that of this site, and goes on from where it was noted.
pub fn check_late(audit: &Connection, noted: &Mark) -> Result<bool, rusqlite::Error> {
    let is_ours = read(audit)?.is_some_and(|mark| mark.site == noted.site);
    Ok(is_ours && check_audit(audit, &noted.audit)?.is_none())
}

fn check_audit(audit: &Connection, noted: &Head) -> Result<Option<Fault>, rusqlite::Error> {
    if noted.n == 0 {
        return Ok(None);
    }
    let n = i64::try_from(noted.n).unwrap_or(i64::MAX);
    let hash: Option<String> =
        audit.query_row("SELECT hash FROM audit WHERE n = ?1", [n], |row| row.get(0)).optional()?;
    Ok(match hash {
        Some(hash) if hash == noted.hash => None,
        Some(_) => Some(Fault::Changed { n: noted.n }),
        None => Some(Fault::Older { noted: noted.n, found: head(audit)?.0 }),
    })
}

fn check_users(
    hub: &Connection,
    own: Users,
    noted: &[Users],
) -> Result<Option<Fault>, rusqlite::Error> {
    let most = noted.iter().map(|it| it.changes).max().unwrap_or(0);
    let count: i64 = hub.query_row("SELECT COUNT(*) FROM user", [], |row| row.get(0))?;
    let set_up = own.set_up || noted.iter().any(|it| it.set_up);
    Ok(match () {
        () if own.changes < most => Some(Fault::Older { noted: most, found: own.changes }),
        () if set_up && count == 0 => Some(Fault::Emptied),
        () => None,
    })
}

/// Whether users and tokens are those that were noted. After a kill those that were changed since, by entries of
/// the log, may be others; none are, if it cannot be read.
fn check_people(
    hub: &Connection,
    own: Users,
    manifest: &Manifest,
    audit: Option<&Connection>,
) -> Result<Option<Fault>, rusqlite::Error> {
    let noted = &manifest.mark;
    if noted.people.is_empty() {
        return Ok(None);
    }
    let since = own.changes - noted.users.changes.min(own.changes);
    let altered = match () {
        () if manifest.ended => since > 0 || people(hub)? != noted.people,
        () if people(hub)? == noted.people => false,
        () => {
            let in_log = audit.map(|audit| changes_in_log(audit, noted.audit.n)).transpose()?;
            since == 0 || since > in_log.unwrap_or(0)
        }
    };
    Ok(altered.then_some(Fault::Altered))
}

/// How many changes of users and tokens the log has behind this entry, at most: role and password are changed
/// one by one.
fn changes_in_log(audit: &Connection, after: u64) -> Result<u64, rusqlite::Error> {
    let query = "SELECT COALESCE(SUM(CASE json_extract(act, '$.type') WHEN 'change_user' THEN 2
                   WHEN 'set_up' THEN 1 WHEN 'change_own_password' THEN 1 WHEN 'add_user' THEN 1
                   WHEN 'remove_user' THEN 1 WHEN 'add_token' THEN 1 WHEN 'remove_token' THEN 1
                   ELSE 0 END), 0)
                 FROM audit WHERE n > ?1 AND outcome = 'Ok' AND act IS NOT NULL";
    let after = i64::try_from(after).unwrap_or(i64::MAX);
    audit.query_row(query, [after], |row| row.get(0)).map(|it: i64| u64::try_from(it).unwrap_or(0))
}

/// Digest of what users and tokens may do, and of what they prove it with.
pub fn people(hub: &Connection) -> Result<String, rusqlite::Error> {
    let mut all = String::new();
    for query in [
        "SELECT json_array(name, role, password) FROM user ORDER BY name",
        "SELECT json_array(id, name, role, digest) FROM token ORDER BY id",
    ] {
        let mut query = hub.prepare(query)?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            all += &row.get::<_, String>(0)?;
            all.push('\n');
        }
        all.push('\n');
    }
    Ok(digest(&all))
}

/// A database, if there is one with something in it.
fn look(folder: &Path, file: StateFile) -> Result<Look, StoreError> {
    let path = folder.join(file.name());
    if std::fs::metadata(&path).map_or(true, |it| it.len() == 0) {
        return Ok(Look::Nothing);
    }
    let read = || -> Result<Look, rusqlite::Error> {
        let connection = Connection::open(&path)?;
        connection.busy_timeout(std::time::Duration::from_secs(5))?;
        if file == StateFile::Hub {
            // It is small, and half of it would be as good as another one.
            connection.query_row("PRAGMA quick_check(1)", [], |row| {
                match row.get::<_, String>(0)? {
                    it if it == "ok" => Ok(()),
                    it => Err(said_corrupt(&it)),
                }
            })?;
        }
        let tables = "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table'";
        if connection.query_row(tables, [], |row| row.get::<_, i64>(0))? == 0 {
            return Ok(Look::Nothing);
        }
        let mark = read(&connection)?;
        for (table, query) in known(file) {
            if has(&connection, table)? {
                connection.prepare(query)?;
            }
        }
        if file == StateFile::Hub && has(&connection, "zones")? {
            let stored: Option<String> =
                connection.query_row("SELECT value FROM zones", [], |row| row.get(0)).optional()?;
            if let Some(Err(error)) =
                stored.map(|it| serde_json::from_str::<lafet_site::Persisted>(&it))
            {
                return Ok(Look::Malformed(text::StoreZones { error: Shown(error) }.of(Lang::En)));
            }
        }
        Ok(Look::Found(Found { connection, mark }))
    };
    match read() {
        Err(error) if is_malformed(&error) => Ok(Look::Malformed(error.to_string())),
        Err(error) if is_of_disk(&error) => Ok(Look::Unread(error)),
        read => read.map_err(|error| StoreError::File(path.clone(), error)),
    }
}

/// Tables without which the hub does not start, and what is asked of them.
const fn known(file: StateFile) -> &'static [(&'static str, &'static str)] {
    match file {
        StateFile::Hub => &[
            ("user", "SELECT name, role, password, created_ms, last_login_ms FROM user"),
            ("session", "SELECT digest, id, user, csrf, created_ms, used_ms FROM session"),
            ("token", "SELECT id, name, role, digest, created_ms, last_used_ms FROM token"),
            ("setup", "SELECT digest FROM setup"),
            ("device", "SELECT digest, user, used_ms FROM device"),
            ("zones", "SELECT one, value FROM zones"),
        ],
        StateFile::Audit => &[(
            "audit",
            "SELECT n, at_ms, user, monitor, what, outcome, details, prev, hash FROM audit",
        )],
        StateFile::Events | StateFile::History | StateFile::Site | StateFile::Revoked => &[],
    }
}

fn has(db: &Connection, table: &str) -> Result<bool, rusqlite::Error> {
    let query = "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = ?1";
    db.query_row(query, [table], |row| row.get(0)).map(|count: i64| count > 0)
}

fn read(db: &Connection) -> Result<Option<Mark>, rusqlite::Error> {
    if !has(db, "site")? {
        return Ok(None);
    }
    let query = "SELECT id, users, set_up, audit_n, audit_hash FROM site";
    db.query_row(query, [], |row| {
        let number = |index| row.get(index).map(|it: i64| u64::try_from(it).unwrap_or(0));
        Ok(Mark {
            site: row.get(0)?,
            users: Users { changes: number(1)?, set_up: row.get(2)? },
            audit: Head { n: number(3)?, hash: row.get(4)? },
            people: String::new(),
        })
    })
    .optional()
}

fn open_marked(folder: &Path, file: StateFile, site: &str) -> Result<Connection, StoreError> {
    let db = open(Some(folder), file.name(), "")?;
    let row = "INSERT INTO site (one, id) VALUES (1, ?1)
               ON CONFLICT (one) DO UPDATE SET id = excluded.id";
    db.execute(row, [site])?;
    Ok(db)
}

/// What `site.json` says, if it is there; `Err`: why it cannot be read.
fn manifest(folder: &Path) -> Result<Option<Manifest>, String> {
    match std::fs::read(folder.join(MANIFEST)) {
        Ok(bytes) if bytes.is_empty() => Ok(None),
        Ok(bytes) => serde_json::from_slice(&bytes).map(Some).map_err(|error| error.to_string()),
        Err(_) => Ok(None),
    }
}

/// What `site.json` has noted before this start.
pub fn noted(folder: &Path) -> Mark {
    manifest(folder).ok().flatten().map(|it| it.mark).unwrap_or_default()
}

/// Whole or not at all.
fn write(folder: &Path, manifest: &Manifest) -> Result<(), StoreError> {
    let (new, path) = (folder.join("site.json.new"), folder.join(MANIFEST));
    private(&new)?;
    let text = serde_json::to_string_pretty(manifest).unwrap_or_default();
    Ok(replace(&path, &new, text.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A start that ends before all files are marked, and loses users.
    #[test]
    fn a_start_that_is_cut_off_hides_no_loss() {
        let folder = std::env::temp_dir().join(format!("lafet-cut-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        let schemas = [
            (
                "hub.db",
                "CREATE TABLE user (name TEXT, role TEXT, password TEXT, created_ms INTEGER,
                 last_login_ms INTEGER) STRICT;
                 CREATE TABLE token (id INTEGER PRIMARY KEY, name TEXT, role TEXT, digest TEXT,
                 created_ms INTEGER, last_used_ms INTEGER) STRICT;",
            ),
            (
                "audit.db",
                "CREATE TABLE audit (n INTEGER PRIMARY KEY, at_ms INTEGER, user TEXT, monitor TEXT,
                 what TEXT, outcome TEXT, details TEXT, prev TEXT, hash TEXT) STRICT;",
            ),
        ];
        for (name, schema) in schemas {
            open(Some(&folder), name, schema).unwrap();
        }
        mark(&folder, "site", false, &[]).unwrap();
        let (site, losses) = (Some("site".into()), vec![]);
        let good = Examined { site, is_new: false, is_whole: true, losses };
        assert_eq!(examine(&folder, false).unwrap(), good);
        let (events, aside) = (folder.join("events.db"), folder.join("aside"));
        std::fs::rename(&events, &aside).unwrap();
        std::fs::create_dir(&events).unwrap();
        assert!(mark(&folder, "site", false, &[]).is_err(), "it is cut off here");
        std::fs::remove_dir(&events).unwrap();
        std::fs::rename(&aside, &events).unwrap();
        std::fs::remove_file(folder.join("hub.db")).unwrap();
        let losses = examine(&folder, false).unwrap().losses;
        assert!(
            losses.contains(&Loss { file: StateFile::Hub, fault: Fault::Missing }),
            "{losses:?}"
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
