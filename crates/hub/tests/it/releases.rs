//! The state that earlier releases wrote is used as it is; that of a later one is refused, and left alone.
//!
//! `tests/releases/VERSION` has the files of a hub that has run, as `cargo xtask dist --state PROGRAM` packs them.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use lafet_hub::store::{FORMAT, StateFile, StoreError, newer};
use lafet_hub::{Clock, Config, Hub};
use rusqlite::Connection;
use serde_json::{Value, json};

const RELEASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/releases");
/// The administrator of each.
const USER: &str = "admin";
const PASSWORD: &str = "foam over water, 27 bar";

fn releases() -> Vec<PathBuf> {
    let all: Vec<PathBuf> = fs::read_dir(RELEASES).unwrap().map(|it| it.unwrap().path()).collect();
    assert!(!all.is_empty());
    all
}

fn unpacked(release: &Path, name: &str) -> PathBuf {
    let to = std::env::temp_dir().join(format!("lafet-release-{name}-{}", std::process::id()));
    _ = fs::remove_dir_all(&to);
    fs::create_dir(&to).unwrap();
    for packed in fs::read_dir(release).unwrap().map(|it| it.unwrap().path()) {
        let mut bytes = Vec::new();
        GzDecoder::new(fs::File::open(&packed).unwrap()).read_to_end(&mut bytes).unwrap();
        fs::write(to.join(packed.file_stem().unwrap()), bytes).unwrap();
    }
    to
}

fn open(folder: &Path) -> Result<Hub, StoreError> {
    let data = Some(folder.to_owned());
    Hub::new(Config { data, ..Config::default() }, Clock::System, json!({}))
}

/// The same without numbers, as programs before the first release wrote it.
fn without_numbers(folder: &Path) {
    for name in databases() {
        let db = Connection::open(folder.join(name)).unwrap();
        db.pragma_update(None, "user_version", 0).unwrap();
    }
    let path = folder.join("site.json");
    let mut site: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    site.as_object_mut().unwrap().remove("program");
    fs::write(&path, site.to_string()).unwrap();
}

/// Rows of each table of each database.
fn rows(folder: &Path) -> BTreeMap<String, i64> {
    let mut all = BTreeMap::new();
    for name in databases() {
        let db = Connection::open(folder.join(name)).unwrap();
        let query = "SELECT name FROM sqlite_master WHERE type = 'table'";
        let mut tables = db.prepare(query).unwrap();
        let tables: Vec<String> =
            tables.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
        for table in tables {
            let count = format!("SELECT COUNT(*) FROM \"{table}\"");
            let count = db.query_row(&count, [], |row| row.get(0)).unwrap();
            all.insert(format!("{name} {table}"), count);
        }
    }
    all
}

fn databases() -> impl Iterator<Item = &'static str> {
    StateFile::ALL.into_iter().filter(|it| *it != StateFile::Site).map(StateFile::name)
}

/// Everything in a folder: names and contents.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = fs::read_dir(folder).unwrap().map(|it| it.unwrap().path());
    paths.map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

#[tokio::test]
async fn the_state_of_each_release_is_used_as_it_is() {
    for (release, numbers) in
        releases().into_iter().flat_map(|it| [(it.clone(), true), (it, false)])
    {
        let folder = unpacked(&release, "used");
        if !numbers {
            without_numbers(&folder);
        }
        let before = rows(&folder);
        for (table, least) in [("audit.db audit", 1), ("hub.db user", 1), ("history.db raw", 1)] {
            assert!(before.get(table).is_some_and(|it| *it >= least), "{table}: {before:?}");
        }
        let site = fs::read(folder.join("site.json")).unwrap();
        let site: Value = serde_json::from_slice(&site).unwrap();
        let hub = open(&folder).unwrap_or_else(|error| panic!("{}: {error}", release.display()));
        assert!(hub.integrity().losses().is_empty());
        assert_eq!(hub.access().setup_link().unwrap(), None, "there is an administrator");
        hub.access().check_password(USER, PASSWORD).unwrap();
        let verified = hub.audit().verify().await.unwrap();
        assert_eq!(verified.bad, None);
        assert!(verified.entries >= site["audit"]["n"].as_u64().unwrap(), "{verified:?}");
        drop(hub);
        let after = rows(&folder);
        for (table, count) in before {
            assert!(after[&table] >= count, "{table}: {count} rows, now {}", after[&table]);
        }
        for name in databases() {
            let db = Connection::open(folder.join(name)).unwrap();
            let format = db.pragma_query_value(None, "user_version", |row| row.get::<_, u32>(0));
            assert_eq!(format.unwrap(), FORMAT, "{name}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn a_later_state_is_refused_and_not_changed() {
    for changed in StateFile::ALL {
        let folder = unpacked(&releases()[0], changed.word());
        let (path, later) = (folder.join(changed.name()), FORMAT + 1);
        if changed == StateFile::Site {
            let mut site: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
            site["version"] = json!(later);
            site["program"] = json!("7.1.0");
            // A later program may note what this one cannot read.
            site["users"] = json!("in another form");
            fs::write(&path, site.to_string()).unwrap();
        } else {
            let db = Connection::open(&path).unwrap();
            db.pragma_update(None, "user_version", later).unwrap();
        }
        let before = contents(&folder);
        let Err(StoreError::Newer(found)) = open(&folder) else { panic!("{changed:?}") };
        assert_eq!(contents(&folder), before, "{changed:?}");
        assert_eq!(found.format, later);
        assert_eq!(newer(&folder).unwrap(), Some(found.clone()));
        let words = found.words();
        for text in [&words.en, &words.ru] {
            let own = env!("CARGO_PKG_VERSION");
            let program = changed == StateFile::Site;
            assert!(text.contains(own) && text.contains("7.1.0") == program, "{text}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn a_folder_that_is_not_there_has_no_state() {
    let folder = std::env::temp_dir().join(format!("lafet-release-none-{}", std::process::id()));
    assert_eq!(newer(&folder).unwrap(), None);
    assert!(!folder.exists());
}
