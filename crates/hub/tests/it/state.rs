//! Files of the state that are lost, cut, replaced or edited: none of it passes unnoticed.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{PASSWORD, Site, until};
use lafet_hub::access::Role;
use lafet_hub::store::{Fault, Loss, StateFile, StoreError};
use lafet_hub::{Clock, Config, Hub};
use rusqlite::Connection;
use serde_json::json;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lafet-state-{name}-{}", std::process::id()));
    _ = fs::remove_dir_all(&folder);
    folder
}

fn open(folder: &Path, accept_lost: &[StateFile]) -> Result<Hub, StoreError> {
    let (data, accept_lost) = (Some(folder.to_owned()), accept_lost.to_vec());
    Hub::new(Config { data, accept_lost, ..Config::default() }, Clock::System, json!({}))
}

/// A hub that has run: an administrator, some entries.
async fn fill(folder: &Path) {
    let hub = open(folder, &[]).unwrap();
    let link = hub.access().setup_link().unwrap().expect("the folder is new");
    hub.access().set_up(1, &link, "root", PASSWORD).unwrap();
    for _ in 0..5 {
        hub.audit().note(hub.record_of_end()).await.unwrap();
    }
    hub.note_state().await.unwrap();
    end(hub, folder).await;
}

/// Ends a hub, and waits until its threads have closed the databases.
async fn end(hub: Hub, folder: &Path) {
    drop(hub);
    let folder = folder.canonicalize().unwrap();
    let is_ours = |it: std::io::Result<fs::DirEntry>| {
        it.and_then(|it| fs::read_link(it.path())).is_ok_and(|file| file.starts_with(&folder))
    };
    until("the files are closed", || !fs::read_dir("/proc/self/fd").unwrap().any(is_ours)).await;
}

fn copy(from: &Path, to: &Path) {
    _ = fs::remove_dir_all(to);
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap).filter(|it| it.path().is_file()) {
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

fn remove(folder: &Path, name: &str) {
    for end in ["", "-wal", "-shm"] {
        _ = fs::remove_file(folder.join(format!("{name}{end}")));
    }
}

fn sql(folder: &Path, name: &str, sql: &str) {
    Connection::open(folder.join(name)).unwrap().execute_batch(sql).unwrap();
}

const UNLOCK: &str = "DROP TRIGGER audit_stays; DROP TRIGGER audit_is_fixed;";

/// What only an administrator may do, done by another program.
const RAISE: &str = "UPDATE user SET role = 'administrator' WHERE name = 'anna'";

type Damage = Box<dyn Fn(&Path)>;
/// What is done to the folder, to which file of it, and what is said of that file.
type Case = (&'static str, Damage, StateFile, fn(&Fault) -> bool);

fn gone(name: &'static str) -> Damage {
    Box::new(move |to| remove(to, name))
}

fn run(name: &'static str, text: String) -> Damage {
    Box::new(move |to| sql(to, name, &text))
}

/// The file of another folder takes its place.
fn from(from: &Path, name: &'static str) -> Damage {
    let from = from.to_owned();
    Box::new(move |to: &Path| {
        remove(to, name);
        for end in ["", "-wal"] {
            _ = fs::copy(from.join(format!("{name}{end}")), to.join(format!("{name}{end}")));
        }
    })
}

fn cases(older: &Path, other: &Path) -> Vec<Case> {
    use StateFile::{Audit, Events, History, Hub, Site};
    vec![
        ("no hub.db", gone("hub.db"), Hub, |it| *it == Fault::Missing),
        (
            "hub.db emptied",
            Box::new(|to| {
                remove(to, "hub.db");
                fs::write(to.join("hub.db"), "").unwrap();
            }),
            Hub,
            |it| *it == Fault::Missing,
        ),
        ("a role raised", run("hub.db", RAISE.into()), Hub, |it| *it == Fault::Altered),
        (
            "a role raised, and not counted",
            run("hub.db", format!("DROP TRIGGER user_changed; {RAISE}")),
            Hub,
            |it| *it == Fault::Altered,
        ),
        (
            "a user added",
            run("hub.db", "INSERT INTO user VALUES ('eve', 'administrator', 'x', 1, NULL)".into()),
            Hub,
            |it| *it == Fault::Altered,
        ),
        (
            "a token added",
            run(
                "hub.db",
                "INSERT INTO token (name, role, digest, created_ms)
                 VALUES ('eve', 'administrator', 'x', 1)"
                    .into(),
            ),
            Hub,
            |it| *it == Fault::Altered,
        ),
        ("no users", run("hub.db", "DELETE FROM user".into()), Hub, |it| *it == Fault::Emptied),
        ("an older hub.db", from(older, "hub.db"), Hub, |it| matches!(it, Fault::Older { .. })),
        ("another hub.db", from(other, "hub.db"), Hub, |it| *it == Fault::Foreign),
        ("no audit.db", gone("audit.db"), Audit, |it| *it == Fault::Missing),
        ("another audit.db", from(other, "audit.db"), Audit, |it| *it == Fault::Foreign),
        ("an older audit.db", from(older, "audit.db"), Audit, |it| {
            *it == Fault::Older { noted: 8, found: 5 }
        }),
        (
            "its end cut off",
            run("audit.db", format!("{UNLOCK} DELETE FROM audit WHERE n > 7")),
            Audit,
            |it| *it == Fault::Older { noted: 8, found: 7 },
        ),
        (
            "its end replaced",
            run("audit.db", format!("{UNLOCK} UPDATE audit SET hash = 'x' WHERE n = 8")),
            Audit,
            |it| *it == Fault::Changed { n: 8 },
        ),
        ("no events.db", gone("events.db"), Events, |it| *it == Fault::Missing),
        ("no history.db", gone("history.db"), History, |it| *it == Fault::Missing),
        ("no site.json", gone("site.json"), Site, |it| *it == Fault::Missing),
    ]
}

/// Damages a copy of a good folder: the hub says so, and starts when that is accepted.
async fn shows(good: &Path, damaged: &Path, (what, damage, file, fault): Case) {
    use StateFile::{Audit, Hub};
    copy(good, damaged);
    let hub = open(damaged, &[]).unwrap_or_else(|error| panic!("undamaged: {error}"));
    end(hub, damaged).await;
    copy(good, damaged);
    damage(damaged);
    let grave = matches!(file, Hub | Audit) && !fault(&Fault::Altered);
    let hub = match open(damaged, &[]) {
        Err(StoreError::Lost(losses)) => {
            assert!(grave, "{what}: {losses:?}");
            let right = |it: &Loss| it.file == file && fault(&it.fault);
            assert!(losses.iter().any(right), "{what}: {losses:?}");
            open(damaged, &[Hub, Audit]).unwrap()
        }
        Ok(hub) => {
            assert!(!grave, "{what}: the hub starts as if nothing were amiss");
            hub
        }
        Err(error) => panic!("{what}: {error}"),
    };
    let losses = hub.integrity().losses();
    assert!(losses.iter().any(|it| it.file == file && fault(&it.fault)), "{what}: {losses:?}");
    until("all is noted", || hub.audit().waiting() == 0).await;
    let log = hub.audit().latest(None, 5, None, None).await.unwrap();
    let recorded =
        |act: &serde_json::Value| act["type"] == "state_lost" && act["file"] == file.word();
    assert!(log.iter().any(|it| it.record.act.as_ref().is_some_and(recorded)), "{what}: {log:?}");
    let users_lost = file == Hub
        && losses
            .iter()
            .all(|it| !matches!(it.fault, Fault::Older { .. } | Fault::Foreign | Fault::Altered));
    assert_eq!(hub.access().is_empty(), users_lost, "{what}");
    end(hub, damaged).await;
    let hub = open(damaged, &[]).unwrap_or_else(|error| panic!("{what}, accepted: {error}"));
    end(hub, damaged).await;
}

/// The first page of a table is lost: the schema can be read all the same.
fn page(name: &'static str, table: &'static str) -> Damage {
    Box::new(move |to| {
        let db = Connection::open(to.join(name)).unwrap();
        let query = "SELECT rootpage FROM sqlite_schema WHERE name = ?1";
        let page: u32 = db.query_row(query, [table], |row| row.get(0)).unwrap();
        let size: u32 = db.pragma_query_value(None, "page_size", |row| row.get(0)).unwrap();
        drop(db);
        let (page, size) = (page as usize, size as usize);
        let mut whole = fs::read(to.join(name)).unwrap();
        whole[(page - 1) * size..page * size].fill(0xff);
        fs::write(to.join(name), whole).unwrap();
    })
}

/// What cannot be read at all, each by another reason.
fn malformed() -> Vec<(&'static str, StateFile, Damage)> {
    use StateFile::{Audit, Events, History, Hub, Site};
    let garbage = |name: &'static str| -> Damage {
        Box::new(move |to| {
            remove(to, name);
            fs::write(to.join(name), "no state, and never was. ".repeat(400)).unwrap();
        })
    };
    let half: Damage = Box::new(|to| {
        let whole = fs::read(to.join("hub.db")).unwrap();
        remove(to, "hub.db");
        fs::write(to.join("hub.db"), &whole[..whole.len() / 2]).unwrap();
    });
    let alarm = "INSERT INTO alarm_now VALUES ('x', CAST(X'FF' AS TEXT))";
    let zones = "CREATE TABLE IF NOT EXISTS zones (one INTEGER PRIMARY KEY, value TEXT NOT NULL);
                 INSERT OR REPLACE INTO zones VALUES (1, '{')";
    vec![
        ("garbage", Hub, garbage("hub.db")),
        ("half of it", Hub, half),
        ("another program's", Hub, run("hub.db", "DROP TABLE user; CREATE TABLE user (a)".into())),
        ("zones that are none", Hub, run("hub.db", zones.into())),
        ("another site table", Hub, run("hub.db", "DROP TABLE site; CREATE TABLE site (a)".into())),
        ("garbage", Audit, garbage("audit.db")),
        (
            "another program's",
            Audit,
            run("audit.db", format!("{UNLOCK} DROP TABLE audit; CREATE TABLE audit (a)")),
        ),
        ("garbage", Events, garbage("events.db")),
        ("a damaged page", Events, page("events.db", "alarm_now")),
        ("a text that is none", Events, run("events.db", alarm.into())),
        ("garbage", History, garbage("history.db")),
        ("garbage", Site, garbage("site.json")),
    ]
}

/// A file that cannot be read is refused, or accepted once: then it is kept under another name, a new
/// one takes its place, and the audit log has both.
async fn is_set_aside(
    good: &Path,
    damaged: &Path,
    (what, file, damage): (&str, StateFile, Damage),
) {
    copy(good, damaged);
    damage(damaged);
    let before = fs::read(damaged.join(file.name())).unwrap();
    if matches!(file, StateFile::Hub | StateFile::Audit) {
        let Err(StoreError::Lost(losses)) = open(damaged, &[]) else {
            panic!("{what}, {file:?}: not refused as lost");
        };
        let is = |it: &Loss| it.file == file && matches!(it.fault, Fault::Malformed { .. });
        assert!(losses.iter().any(is), "{what}: {losses:?}");
        assert_eq!(fs::read(damaged.join(file.name())).unwrap(), before, "refused and untouched");
    }
    let hub = open(damaged, &[file]).unwrap_or_else(|error| panic!("{what}, {file:?}: {error}"));
    until("all is noted", || hub.audit().waiting() == 0).await;
    let log = hub.audit().latest(None, 5, None, None).await.unwrap();
    let act = log.iter().filter_map(|it| it.record.act.as_ref()).find(|act| {
        act["type"] == "state_lost" && act["file"] == file.word() && act["fault"] == "malformed"
    });
    let act = act.unwrap_or_else(|| panic!("{what}, {file:?}: {log:?}"));
    let aside = act["aside"].as_str().expect("where it is now");
    assert!(aside.starts_with(&format!("{}.spoilt-20", file.name())), "{aside}");
    // What other connections have written since into a database is in its log, beside it.
    assert_eq!(fs::read(damaged.join(aside)).unwrap(), before, "{what}, {file:?}: kept as it was");
    end(hub, damaged).await;
    let hub = open(damaged, &[]).unwrap_or_else(|error| panic!("{what}, accepted: {error}"));
    assert!(hub.integrity().losses().is_empty(), "{what}, {file:?}: once only");
    end(hub, damaged).await;
}

#[tokio::test]
async fn what_is_lost_or_changed_shows_at_the_start() {
    let (good, older, other) = (folder("good"), folder("older"), folder("other"));
    let damaged = folder("damaged");
    fill(&good).await;
    copy(&good, &older);
    let hub = open(&good, &[]).unwrap();
    hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    for _ in 0..3 {
        hub.audit().note(hub.record_of_end()).await.unwrap();
    }
    hub.note_state().await.unwrap();
    end(hub, &good).await;
    fill(&other).await;
    for case in cases(&older, &other) {
        shows(&good, &damaged, case).await;
    }
    // Half of it is no database any more.
    copy(&good, &damaged);
    let whole = fs::read(damaged.join("hub.db")).unwrap();
    remove(&damaged, "hub.db");
    fs::write(damaged.join("hub.db"), &whole[..whole.len() / 2]).unwrap();
    assert!(open(&damaged, &[]).is_err());
    for case in malformed() {
        is_set_aside(&good, &damaged, case).await;
    }
    for folder in [good, older, other, damaged] {
        fs::remove_dir_all(folder).unwrap();
    }
}

/// The files in the order in which a first start makes them.
const MADE: [&str; 4] = ["events.db", "audit.db", "hub.db", "history.db"];

/// A first start that was cut off before any file had its mark, without the file beside them.
#[tokio::test]
async fn a_first_start_that_was_cut_off_is_made_good() {
    let (whole, cut) = (folder("first"), folder("first-cut"));
    end(open(&whole, &[]).unwrap(), &whole).await;
    for made in 0..=MADE.len() {
        copy(&whole, &cut);
        remove(&cut, "site.json");
        for (index, name) in MADE.into_iter().enumerate() {
            match index < made {
                true => sql(&cut, name, "DELETE FROM site"),
                false => remove(&cut, name),
            }
        }
        let hub = open(&cut, &[]).unwrap_or_else(|error| panic!("{made} files: {error}"));
        assert_eq!(hub.integrity().losses(), [], "{made} files");
        end(hub, &cut).await;
        remove(&cut, "audit.db");
        assert!(matches!(open(&cut, &[]), Err(StoreError::Lost(_))), "it has an id now");
    }
    // What was in use is not taken for a first start.
    fill(&whole).await;
    remove(&whole, "site.json");
    MADE.iter().for_each(|name| sql(&whole, name, "DELETE FROM site"));
    for gone in ["hub.db", "audit.db"] {
        copy(&whole, &cut);
        remove(&cut, gone);
        assert!(matches!(open(&cut, &[]), Err(StoreError::Lost(_))), "{gone}");
    }
    for folder in [whole, cut] {
        fs::remove_dir_all(folder).unwrap();
    }
}

/// After a clean end a copy of the databases without SQLite's logs has everything.
#[tokio::test]
async fn a_clean_end_leaves_everything_in_the_files() {
    let (folder, alone) = (folder("settled"), folder("settled-alone"));
    let own = folder.clone();
    let config = Config {
        data: Some(own),
        listen: "127.0.0.1:0".parse().unwrap(),
        login: false,
        ..Config::default()
    };
    let hub = Hub::new(config, Clock::System, json!({})).unwrap();
    let (end, ending) = tokio::sync::oneshot::channel::<()>();
    let server = lafet_hub::Server::bind(hub.clone()).await.unwrap();
    let served = tokio::spawn(server.serve(async { _ = ending.await }));
    hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    hub.audit().note(hub.record_of_end()).await.unwrap();
    hub.event(None, &lafet_hub::text::Both::same("it has happened"));
    hub.history().note(hub.clock().now_ms(), "M1", "pressure", 5.0);
    drop(end);
    served.await.unwrap();
    // The hub is there and has its files open, as in a program that is about to exit.
    fs::create_dir_all(&alone).unwrap();
    let count = |name: &str, query: &str| {
        let log = fs::metadata(folder.join(format!("{name}-wal"))).map_or(0, |it| it.len());
        assert_eq!(log, 0, "{name} has a log");
        fs::copy(folder.join(name), alone.join(name)).unwrap();
        let db = Connection::open(alone.join(name)).unwrap();
        db.query_row(query, [], |row| row.get::<_, i64>(0)).unwrap()
    };
    assert_eq!(count("hub.db", "SELECT COUNT(*) FROM user"), 1);
    assert_eq!(count("audit.db", "SELECT COUNT(*) FROM audit"), 2, "what was noted, and the end");
    assert!(count("events.db", "SELECT COUNT(*) FROM event") >= 1);
    assert!(count("history.db", "SELECT COUNT(*) FROM raw") >= 1);
    drop(hub);
    _ = fs::remove_dir_all(folder);
    _ = fs::remove_dir_all(alone);
}

/// Runs a hub, does something with it, and ends it as a program does.
async fn serves(folder: &Path, work: impl AsyncFnOnce(&Hub)) {
    let config = Config {
        data: Some(folder.to_owned()),
        listen: "127.0.0.1:0".parse().unwrap(),
        ..Config::default()
    };
    let hub = Hub::new(config, Clock::System, json!({})).unwrap();
    let (go, ending) = tokio::sync::oneshot::channel::<()>();
    let server = lafet_hub::Server::bind(hub.clone()).await.unwrap();
    let served = tokio::spawn(server.serve(async { _ = ending.await }));
    work(&hub).await;
    drop(go);
    served.await.unwrap();
    end(hub, folder).await;
}

/// After a clean end nothing changes by itself; after a kill what is in the log may have.
#[tokio::test]
async fn users_that_another_program_changed_show() {
    let (good, altered) = (folder("people"), folder("people-altered"));
    let losses = |folder: &Path| open(folder, &[]).unwrap().integrity().losses();
    serves(&good, async |hub| {
        hub.access().add(1, "root", Role::Administrator, PASSWORD).unwrap();
        hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    })
    .await;
    copy(&good, &altered);
    assert_eq!(losses(&altered), [], "untouched");
    // Changed and changed back: it was counted.
    copy(&good, &altered);
    let back = "UPDATE user SET role = 'operator' WHERE name = 'anna'";
    sql(&altered, "hub.db", &format!("{RAISE}; {back}"));
    assert_eq!(losses(&altered), [Loss { file: StateFile::Hub, fault: Fault::Altered }]);
    // A hub that is killed after a change that its log has, and one whose log has none.
    for (act, fault) in [(true, None), (false, Some(Fault::Altered))] {
        copy(&good, &altered);
        let hub = open(&altered, &[]).unwrap();
        hub.access().change(2, "anna", Some(Role::Engineer), Some(PASSWORD), None).unwrap();
        let act = act.then(|| lafet_hub::store::Act::ChangeUser {
            user: "anna".into(),
            role: Some(Role::Engineer),
            password: true,
        });
        let record = hub.record_of_end();
        let record = lafet_hub::store::Record { outcome: "Ok".into(), ..record };
        hub.audit().note(act.map_or(record.clone(), |act| record.about(&act))).await.unwrap();
        end(hub, &altered).await;
        let found: Vec<Fault> = losses(&altered).into_iter().map(|it| it.fault).collect();
        assert_eq!(found, Vec::from_iter(fault));
    }
    for folder in [good, altered] {
        fs::remove_dir_all(folder).unwrap();
    }
}

#[tokio::test]
async fn a_folder_of_an_earlier_version_is_taken_over() {
    let folder = folder("earlier");
    fill(&folder).await;
    fs::remove_file(folder.join("site.json")).unwrap();
    for name in ["hub.db", "audit.db", "events.db", "history.db"] {
        sql(&folder, name, "DROP TABLE site");
    }
    let hub = open(&folder, &[]).unwrap();
    assert_eq!(hub.integrity().losses(), []);
    assert!(!hub.access().is_empty() && hub.access().changes().unwrap().set_up);
    end(hub, &folder).await;
    remove(&folder, "audit.db");
    assert!(matches!(open(&folder, &[]), Err(StoreError::Lost(_))), "it has an id now");
    fs::remove_dir_all(folder).unwrap();
}

#[tokio::test]
async fn an_edited_entry_is_found_by_the_hub_itself() {
    let folder = folder("edited");
    fill(&folder).await;
    sql(&folder, "audit.db", &format!("{UNLOCK} UPDATE audit SET user = 'boris' WHERE n = 2"));
    let own = folder.clone();
    let site = Site::with(1, |config| (config.login, config.data) = (false, Some(own))).await;
    until("it is found", || site.hub.integrity().chain().bad == Some(2)).await;
    let active = || {
        let alarms = site.hub.alarms();
        alarms.get("hub/AuditChain").is_some_and(|it| it.active)
    };
    until("it is an alarm", active).await;
    let health = site.get("", "/health").await;
    assert_eq!((health.status, &health.body["status"]), (200, &json!("degraded")));
    assert_eq!(health.body["audit_chain"]["state"], "broken");
    assert!(site.get("", "/metrics").await.text.contains("\nlafet_audit_chain_ok 0\n"));
    drop(site);
    _ = fs::remove_dir_all(folder);
}

/// The disk gives errors where a file is: SQLite cannot use a pipe as its shared memory, and says so as of a disk that has
/// failed.
#[cfg(target_os = "linux")]
fn fail(folder: &Path, file: StateFile) -> PathBuf {
    let pipe = folder.join(format!("{}-shm", file.name()));
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|it| it.success()), "{}", pipe.display());
    pipe
}

/// Assumed: the disk does not let a file be read when the hub starts.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_hub_starts_without_what_the_disk_does_not_let_be_read() {
    let (good, damaged) = (folder("readable"), folder("unread"));
    fill(&good).await;
    for file in [StateFile::Audit, StateFile::Events, StateFile::History] {
        copy(&good, &damaged);
        let before = fs::read(damaged.join(file.name())).unwrap();
        let pipe = fail(&damaged, file);
        let hub = open(&damaged, &[]).unwrap_or_else(|error| panic!("{file:?}: {error}"));
        let losses = hub.integrity().losses();
        let is = |it: &Loss| it.file == file && matches!(it.fault, Fault::Unread { .. });
        assert!(losses.len() == 1 && is(&losses[0]), "{losses:?}");
        hub.look_at_itself();
        let failing =
            [hub.audit().is_failing(), hub.events().is_failing(), hub.history().is_failing()];
        let expected = [StateFile::Audit, StateFile::Events, StateFile::History];
        assert_eq!(failing, expected.map(|it| it == file), "each is an alarm of its own");
        drop(hub.audit().note(hub.record_of_end()));
        assert_eq!(hub.note_state().await.is_ok(), file != StateFile::Audit);
        assert_eq!(fs::read(damaged.join(file.name())).unwrap(), before, "it is left as it is");
        // The disk is repaired, or the cable is in again.
        fs::remove_file(pipe).unwrap();
        if file == StateFile::Audit {
            until("the entries are stored", || !hub.audit().is_failing()).await;
            let verified = hub.audit().verify().await.unwrap();
            assert_eq!((verified.ok, verified.entries), (true, 7), "five, the loss, and the last");
            hub.note_state().await.unwrap();
        }
        end(hub, &damaged).await;
        let hub = open(&damaged, &[]).unwrap();
        assert_eq!(hub.integrity().losses(), [], "{file:?}: nothing is lost");
        end(hub, &damaged).await;
    }
    // No one would be let in.
    copy(&good, &damaged);
    fail(&damaged, StateFile::Hub);
    let refused = open(&damaged, &[]).unwrap_err().to_string();
    assert!(refused.contains("hub.db: disk I/O error"), "{refused}");
    for folder in [good, damaged] {
        fs::remove_dir_all(folder).unwrap();
    }
}

/// Assumed: who alters the state makes the audit log unreadable, so that it is not compared with it.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn an_audit_log_that_cannot_be_read_hides_nothing() {
    let (good, other, damaged) = (folder("seen"), folder("seen-other"), folder("unseen"));
    fill(&good).await;
    fill(&other).await;
    copy(&good, &damaged);
    sql(&damaged, "hub.db", "INSERT INTO user VALUES ('eve', 'administrator', 'x', 1, NULL)");
    let pipe = fail(&damaged, StateFile::Audit);
    let hub = open(&damaged, &[]).unwrap();
    let altered = Loss { file: StateFile::Hub, fault: Fault::Altered };
    assert!(hub.integrity().losses().contains(&altered), "{:?}", hub.integrity().losses());
    // Another log takes its place while the hub runs.
    fs::rename(damaged.join("audit.db"), damaged.join("kept")).unwrap();
    fs::copy(other.join("audit.db"), damaged.join("audit.db")).unwrap();
    fs::remove_file(pipe).unwrap();
    tokio::time::sleep(std::time::Duration::from_secs(3)).await;
    assert!(hub.audit().is_failing(), "it is not the one that was noted");
    assert!(hub.audit().last().await.is_err());
    remove(&damaged, "audit.db");
    fs::rename(damaged.join("kept"), damaged.join("audit.db")).unwrap();
    until("its own log is taken", || !hub.audit().is_failing()).await;
    assert!(hub.audit().verify().await.unwrap().ok);
    end(hub, &damaged).await;
    for folder in [good, other, damaged] {
        fs::remove_dir_all(folder).unwrap();
    }
}

#[cfg(unix)]
#[tokio::test]
async fn the_state_is_its_owners_alone() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("modes");
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    fill(&folder).await;
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
    for name in ["hub.db", "audit.db", "site.json"] {
        fs::set_permissions(folder.join(name), fs::Permissions::from_mode(0o644)).unwrap();
    }
    end(open(&folder, &[]).unwrap(), &folder).await;
    assert_eq!(mode(&folder), 0o700);
    for entry in fs::read_dir(&folder).unwrap().map(Result::unwrap) {
        let wanted = if entry.path().is_dir() { 0o700 } else { 0o600 };
        assert_eq!(mode(&entry.path()), wanted, "{:?}", entry.path());
    }
    // A folder of another program is left as it is.
    fs::write(folder.join("letter.txt"), "").unwrap();
    for (folder_mode, starts) in [(0o755, true), (0o777, false)] {
        fs::set_permissions(&folder, fs::Permissions::from_mode(folder_mode)).unwrap();
        let opened = open(&folder, &[]);
        assert_eq!(!matches!(opened, Err(StoreError::Shared(_))), starts, "{folder_mode:o}");
        assert_eq!(mode(&folder), folder_mode);
    }
    fs::remove_dir_all(folder).unwrap();
}

/// What is revoked and not stored yet is in a file of its own: one that cannot be read is reported.
#[tokio::test]
async fn a_list_of_revocations_that_cannot_be_read_shows() {
    let folder = folder("revoked");
    fill(&folder).await;
    fs::write(folder.join("revoked"), "cut off in the mid").unwrap();
    let hub = open(&folder, &[]).unwrap();
    let losses = hub.integrity().losses();
    let is = |it: &Loss| matches!(it.fault, Fault::Malformed { .. });
    assert!(losses.len() == 1 && losses[0].file == StateFile::Revoked && is(&losses[0]));
    end(hub, &folder).await;
    let hub = open(&folder, &[]).unwrap();
    assert_eq!(hub.integrity().losses(), [], "once");
    end(hub, &folder).await;
    fs::remove_dir_all(folder).unwrap();
}
