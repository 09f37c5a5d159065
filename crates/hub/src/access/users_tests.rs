use super::super::known::{ENDED_MS, Entry, Known, SESSION_MS, SESSIONS_MAX, STALE_MS};
use super::*;

const PASSWORD: &str = "correct horse";
const OTHER: &str = "wrong battery staple";

fn set_up() -> Access {
    set_up_in(None, 1)
}

/// With its state in a folder, at this time.
fn set_up_in(folder: Option<&Path>, now_ms: u64) -> Access {
    let access = Access::open(folder, now_ms).unwrap();
    let link = access.setup_link().unwrap().unwrap();
    access.set_up(now_ms, &link, "root", PASSWORD).unwrap();
    assert!(matches!(access.set_up(now_ms, &link, "second", PASSWORD), Err(AccessError::Wrong)));
    access
}

#[test]
fn the_link_makes_one_administrator_once() {
    let access = Access::open(None, 1).unwrap();
    let first = access.setup_link().unwrap().unwrap();
    let link = access.setup_link().unwrap().unwrap();
    assert!(matches!(access.set_up(1, &first, "root", PASSWORD), Err(AccessError::Wrong)));
    assert!(matches!(access.set_up(1, &link, "root", "short"), Err(AccessError::Weak(_))));
    access.set_up(1, &link, "root", PASSWORD).unwrap();
    assert_eq!(access.setup_link().unwrap(), None);
    assert_eq!(access.users().unwrap()[0].role, Role::Administrator);
}

#[test]
fn sessions_begin_with_a_password_and_end() {
    let access = set_up();
    assert!(matches!(access.log_in(5, "root", "wrong"), Err(AccessError::Wrong)));
    assert!(matches!(access.log_in(5, "nobody", PASSWORD), Err(AccessError::Wrong)));
    let session = access.log_in(5, "root", PASSWORD).unwrap();
    let at = |ms| access.by_session(ms, &session.secret);
    assert_eq!(at(10).unwrap().user, "root");
    assert!(at(10 + IDLE_MS - 100).unwrap().is_good(), "it is used, so it goes on");
    let late = 2 * IDLE_MS + 1;
    assert_eq!(at(late).unwrap().standing, Standing::Expired);
    assert_eq!(at(late + STALE_MS), None);
    assert_eq!(access.by_session(10, "other"), None);
    access.log_out(&session.principal.key).unwrap();
    assert_eq!(at(10), None);
}

#[test]
fn a_new_password_or_role_ends_other_sessions() {
    let access = set_up();
    let one = access.log_in(5, "root", PASSWORD).unwrap();
    let two = access.log_in(5, "root", PASSWORD).unwrap();
    access.change(6, "root", None, Some("quite another one"), Some(&one.principal.key)).unwrap();
    assert!(access.is_valid(6, &one.principal) && !access.is_valid(6, &two.principal));
    assert!(access.log_in(6, "root", PASSWORD).is_err());
}

#[test]
fn the_last_administrator_stays() {
    let access = set_up();
    assert!(matches!(access.remove(6, "root"), Err(AccessError::Conflict)));
    let demoted = access.change(6, "root", Some(Role::Observer), None, None);
    assert!(matches!(demoted, Err(AccessError::Conflict)));
    access.add(1, "anna", Role::Administrator, PASSWORD).unwrap();
    assert!(matches!(access.add(1, "anna", Role::Observer, PASSWORD), Err(AccessError::Conflict)));
    access.remove(6, "root").unwrap();
    assert_eq!(access.users().unwrap().len(), 1);
}

#[test]
fn tokens_are_told_once_and_taken_back() {
    let access = set_up();
    let (id, secret) = access.add_token(1, "scada", Role::Operator).unwrap();
    let principal = access.by_token(2, &secret).unwrap();
    assert_eq!((principal.user.as_str(), principal.role), ("scada", Role::Operator));
    assert!(access.is_valid(3, &principal));
    access.remove_token(id).unwrap();
    assert_eq!(access.by_token(2, &secret), None);
    assert!(!access.is_valid(3, &principal));
}

#[test]
fn a_disk_that_takes_nothing_keeps_nobody_out() {
    let folder = std::env::temp_dir().join(format!("lafet-access-{}", std::process::id()));
    let access = set_up_in(Some(&folder), 1);
    let session = access.log_in(5, "root", PASSWORD).unwrap();
    let (_, token) = access.add_token(5, "scada", Role::Operator).unwrap();
    lock(&access.db).pragma_update(None, "query_only", true).unwrap();
    let later = 5 + 3_600_000;
    assert!(access.by_session(later, &session.secret).unwrap().is_good());
    assert_eq!(access.by_token(later, &token).unwrap().user, "scada");
    let second = access.log_in(later, "root", PASSWORD).unwrap();
    assert_eq!(access.by_session(later, &second.secret).unwrap().user, "root");
    assert_eq!(access.sessions(later).len(), 2);
    drop(access);

    let access = Access::open(Some(&folder), 1).unwrap();
    assert!(access.by_session(later, &session.secret).is_some(), "it was stored");
    assert!(access.by_session(later, &second.secret).is_none(), "it was not");
    assert!(access.by_token(later, &token).is_some() && !access.is_empty());
    drop(access);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_open_websocket_is_use_and_ends_with_its_session() {
    let access = set_up();
    let session = access.log_in(5, "root", PASSWORD).unwrap();
    let hour = 3_600_000;
    assert!((1..160).all(|n| access.is_valid(n * hour, &session.principal)), "a week");
    assert!(!access.is_valid(5 + SESSION_MS, &session.principal));
    assert_eq!(
        access.by_session(5 + SESSION_MS, &session.secret).unwrap().standing,
        Standing::Expired
    );
}

#[test]
fn a_session_that_was_ended_by_others_can_stop_for_a_while() {
    let access = set_up();
    let session = access.log_in(5, "root", PASSWORD).unwrap();
    access.end_session(100, &session.principal.key).unwrap();
    let at = |ms| access.by_session(ms, &session.secret);
    assert_eq!(at(101).unwrap().standing, Standing::Ended);
    assert!(!access.is_valid(101, &session.principal), "its WebSocket is closed");
    assert_eq!(at(100 + ENDED_MS), None);
    let own = access.log_in(200, "root", PASSWORD).unwrap();
    access.log_out(&own.principal.key).unwrap();
    assert_eq!(access.by_session(201, &own.secret), None, "who logs out has left");
}

/// A client that logs in for each request, and never out, ends the sessions that rest and its own, and none that is
/// in use.
#[test]
fn a_user_has_so_many_sessions() {
    let folder = std::env::temp_dir().join(format!("lafet-sessions-{}", std::process::id()));
    let access = set_up_in(Some(&folder), 1);
    let log_in = |ms| access.log_in(ms, "root", PASSWORD).unwrap();
    let (panel, rests) = (log_in(5), log_in(6));
    let hour = 3_600_000;
    assert!(access.is_valid(hour, &panel.principal), "its page is open");
    let script: Vec<_> = (1..=SESSIONS_MAX as u64).map(|it| log_in(hour + it)).collect();
    let now = hour + 1000;
    let standing = |it: &SessionInfo| access.by_session(now, &it.secret).unwrap().standing;
    assert_eq!(access.sessions(now).len(), SESSIONS_MAX);
    assert_eq!([&panel, &rests].map(standing), [Standing::Good, Standing::Ended]);
    assert_eq!([&script[0], &script[1]].map(standing), [Standing::Ended, Standing::Good]);
    drop(access);
    let access = Access::open(Some(&folder), 1).unwrap();
    assert_eq!(access.sessions(now).len(), SESSIONS_MAX, "on the disk, too");
    drop(access);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The date was set back between the start of a session and its last use, and the hub was started again.
#[test]
fn a_session_that_was_used_before_it_began_makes_room() {
    let known = Known::default();
    for number in 0..SESSIONS_MAX {
        let (key, user) = (format!("h{number}"), "anna".to_owned());
        let entry = Entry {
            key,
            user,
            role: Role::Operator,
            csrf: String::new(),
            created_ms: 9,
            used_ms: 5,
        };
        known.add_session(number.to_string(), entry);
    }
    assert_eq!(known.make_room(10, "anna").len(), 1);
    assert!(known.make_room(10, "anna").is_empty());
}

/// A disk that takes nothing: what is revoked is so at once, and is stored when there is room.
#[test]
fn revocation_needs_no_disk() {
    let folder = std::env::temp_dir().join(format!("lafet-revoked-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    let access = set_up_in(Some(&folder), 1);
    for user in ["anna", "boris"] {
        access.add(1, user, Role::Administrator, PASSWORD).unwrap();
    }
    access.add(1, "viktor", Role::Operator, PASSWORD).unwrap();
    let anna = access.log_in(5, "anna", PASSWORD).unwrap();
    let boris = access.log_in(5, "boris", PASSWORD).unwrap();
    let (id, token) = access.add_token(5, "scada", Role::Operator).unwrap();
    let takes = |access: &Access, nothing: bool| {
        lock(&access.db).pragma_update(None, "query_only", nothing).unwrap();
    };
    takes(&access, true);
    access.remove(6, "anna").unwrap();
    access.change(6, "viktor", Some(Role::Observer), Some(OTHER), None).unwrap();
    assert!(matches!(access.log_in(6, "viktor", PASSWORD), Err(AccessError::Wrong)));
    let lower = access.log_in(6, "viktor", OTHER).unwrap();
    assert_eq!(lower.principal.role, Role::Observer, "neither the old password nor the old role");
    assert!(
        access.users().unwrap().iter().all(|it| it.user != "viktor" || it.role == Role::Observer)
    );
    access.remove_token(id).unwrap();
    access.end_session(6, &boris.principal.key).unwrap();
    assert!(access.revocations_wait());
    assert!(!access.is_valid(7, &anna.principal) && !access.is_valid(7, &boris.principal));
    assert_eq!(access.by_token(7, &token), None);
    assert!(matches!(access.log_in(7, "anna", PASSWORD), Err(AccessError::Wrong)));
    assert_eq!(access.users().unwrap().len(), 3);
    assert!(access.tokens().unwrap().is_empty());
    assert!(matches!(access.remove(7, "anna"), Err(AccessError::Missing)));
    assert!(access.remove(7, "boris").is_ok());
    assert!(matches!(access.remove(7, "root"), Err(AccessError::Conflict)), "the others are gone");
    drop(access);

    // Killed before the disk had room: the list beside the database is what is left.
    let access = Access::open(Some(&folder), 8).unwrap();
    assert!(!access.revocations_wait(), "they are stored now");
    assert_eq!(access.users().unwrap().len(), 2);
    assert_eq!(access.log_in(8, "viktor", OTHER).unwrap().principal.role, Role::Observer);
    assert!(matches!(access.log_in(8, "viktor", PASSWORD), Err(AccessError::Wrong)));
    assert_eq!(access.by_session(8, &boris.secret), None);
    assert_eq!(access.by_token(8, &token), None);
    access.add(9, "anna", Role::Observer, PASSWORD).unwrap();
    assert_eq!(access.by_session(9, &anna.secret), None, "a new user of the old name");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_date_that_has_stepped_ends_no_session() {
    let folder = std::env::temp_dir().join(format!("lafet-step-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    let month = 30 * 24 * 3_600_000;
    let access = set_up_in(Some(&folder), month);
    let session = access.log_in(month, "root", PASSWORD).unwrap();
    access.stepped(i64::try_from(month).unwrap());
    assert!(access.by_session(month + 5, &session.secret).unwrap().is_good());
    assert_eq!(access.date_ms(access.sessions(month + 5)[0].created_ms), 2 * month);
    drop(access);
    // The restart believes the clock, which is a month ahead, and so is what is stored.
    let access = Access::open(Some(&folder), 2 * month + 10).unwrap();
    assert!(access.by_session(2 * month + 10, &session.secret).unwrap().is_good());
    drop(access);
    // It was set back while the hub was not running: no session lasts longer for that.
    let access = Access::open(Some(&folder), month).unwrap();
    assert_eq!(access.sessions(month)[0].expires_ms(), month + IDLE_MS);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_device_is_known_until_the_password_changes() {
    let access = set_up();
    let device = access.add_device(2, "root").unwrap();
    assert!(access.is_device("root", &device) && !access.is_device("anna", &device));
    let many: Vec<String> = (3..30).map(|ms| access.add_device(ms, "root").unwrap()).collect();
    assert!(!access.is_device("root", &device) && access.is_device("root", many.last().unwrap()));
    access.change(40, "root", None, Some("quite another one"), None).unwrap();
    assert!(many.iter().all(|it| !access.is_device("root", it)));
}

/// A connection with a token that was taken back is not good again with the next one.
#[test]
fn the_number_of_a_token_is_not_given_again() {
    let folder = std::env::temp_dir().join(format!("lafet-numbers-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    let access = Access::open(Some(&folder), 1).unwrap();
    // Changes are counted once the file is marked.
    let site = "INSERT INTO site (one, id) VALUES (1, 'site')";
    lock(&access.db).execute(site, []).unwrap();
    let (first, secret) = access.add_token(1, "scada", Role::Operator).unwrap();
    let open = access.by_token(2, &secret).unwrap();
    access.remove_token(first).unwrap();
    let (second, _) = access.add_token(3, "other", Role::Administrator).unwrap();
    assert_ne!(first, second);
    assert!(!access.is_valid(3, &open));
    let changes = access.changes().unwrap();
    // The table of an earlier version.
    let before =
        "ALTER TABLE token RENAME TO t; DROP TRIGGER token_added; DROP TRIGGER token_removed;
        CREATE TABLE token (id INTEGER PRIMARY KEY, name TEXT NOT NULL, role TEXT NOT NULL,
          digest TEXT NOT NULL UNIQUE, created_ms INTEGER NOT NULL, last_used_ms INTEGER) STRICT;
        INSERT INTO token SELECT * FROM t; DROP TABLE t;";
    lock(&access.db).execute_batch(before).unwrap();
    drop(access);

    let access = Access::open(Some(&folder), 4).unwrap();
    assert_eq!(access.changes().unwrap(), changes, "nothing was added or removed");
    assert_eq!(access.tokens().unwrap()[0].name, "other");
    access.remove_token(second).unwrap();
    let (third, secret) = access.add_token(5, "third", Role::Observer).unwrap();
    assert!(third > second, "{third}");
    assert_eq!(access.changes().unwrap().changes, changes.changes + 2);
    assert_eq!(access.by_token(6, &secret).unwrap().user, "third");
    drop(access);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Assumed: the disk hangs, so who has started to read or write holds the database.
#[test]
fn who_is_removed_is_out_before_a_disk_that_hangs_answers() {
    let access = Arc::new(set_up());
    for user in ["anna", "boris"] {
        access.add(1, user, Role::Administrator, PASSWORD).unwrap();
    }
    let anna = access.log_in(5, "anna", PASSWORD).unwrap();
    let boris = access.log_in(5, "boris", PASSWORD).unwrap();
    let root = access.log_in(5, "root", PASSWORD).unwrap();
    let (db, changed) = (access.db.clone(), std::sync::mpsc::channel());
    let hangs = lock(&db);
    type Work = fn(&Access) -> Result<(), AccessError>;
    let work: [Work; 4] = [
        |it| it.remove(6, "anna"),
        |it| it.change(6, "boris", Some(Role::Operator), None, None),
        |it| it.remove(6, "viktor"),
        |it| it.end_session(6, "none"),
    ];
    for (number, work) in work.into_iter().enumerate() {
        let (own, said) = (access.clone(), changed.0.clone());
        std::thread::spawn(move || said.send((number, work(&own).is_ok())));
    }
    let patience = std::time::Duration::from_secs(30);
    let began = std::time::Instant::now();
    while [&anna, &boris].into_iter().any(|it| access.is_valid(7, &it.principal)) {
        assert!(began.elapsed() < patience, "they wait for the disk");
        std::thread::yield_now();
    }
    assert!(access.was_ended(&anna.principal) && access.was_ended(&boris.principal));
    assert!(access.is_valid(7, &root.principal) && !access.was_ended(&root.principal));
    let mut said: Vec<_> = (0..2).map(|_| changed.1.recv_timeout(patience).unwrap()).collect();
    said.sort_unstable();
    assert_eq!(said, [(2, false), (3, false)], "what there is not is known without the disk");
    drop(hangs);
    let mut said: Vec<_> = (0..2).map(|_| changed.1.recv_timeout(patience).unwrap()).collect();
    said.sort_unstable();
    assert_eq!(said, [(0, true), (1, true)]);
    let users: Vec<_> = access.users().unwrap().into_iter().map(|it| (it.user, it.role)).collect();
    assert_eq!(
        users,
        [("boris".to_owned(), Role::Operator), ("root".to_owned(), Role::Administrator)]
    );
}

/// Two administrators remove each other while the disk hangs: one of them stays.
#[test]
fn the_last_of_two_stays_when_both_are_removed_at_once() {
    let access = Arc::new(set_up());
    access.add(1, "anna", Role::Administrator, PASSWORD).unwrap();
    let db = access.db.clone();
    let hangs = lock(&db);
    let removed = ["root", "anna"].map(|user| {
        let own = access.clone();
        std::thread::spawn(move || own.remove(6, user).is_ok())
    });
    std::thread::park_timeout(std::time::Duration::from_millis(200));
    drop(hangs);
    let removed = removed.map(|it| it.join().unwrap());
    assert_eq!(removed.into_iter().filter(|it| *it).count(), 1);
    assert_eq!(access.users().unwrap().len(), 1);
}

/// Who writes a revocation holds its lock until the disk has it.
#[test]
fn whether_revocations_wait_is_known_without_the_disk() {
    let access = Arc::new(set_up());
    let held = access.revoked.clone();
    let writes = lock(&held);
    let (own, (said, heard)) = (access.clone(), std::sync::mpsc::channel());
    std::thread::spawn(move || said.send(own.revocations_wait()));
    let patience = std::time::Duration::from_secs(30);
    assert_eq!(heard.recv_timeout(patience), Ok(false));
    drop(writes);
}
