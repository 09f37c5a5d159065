use super::super::chain::verify_lines;
use super::*;
use serde_json::json;

fn record(what: &str) -> Record {
    let details = json!({ "b": 1, "a": [1.5, "ж"] });
    Record { at_ms: 5, user: "anna".into(), what: what.into(), details, ..Record::default() }
}

async fn filled() -> Audit {
    let audit = Audit::open(None).unwrap();
    for what in ["Stop All", "Open Valve1", "Close Valve1"] {
        audit.note(record(what)).await.unwrap();
    }
    audit
}

/// Of an entry that a later version has written, the words are shown; the chain covers it as it
/// is.
#[tokio::test]
async fn an_act_that_is_not_known_is_stored_and_not_shown() {
    let audit = Audit::open(None).unwrap();
    let later = json!({ "v": 2, "type": "teleport", "to": "M2" });
    let known = record("login").about(&Act::Login);
    for record in [record("old"), known, Record { act: Some(later), ..record("teleport M2") }] {
        audit.note(record).await.unwrap();
    }
    assert!(audit.verify().await.unwrap().ok);
    let entries = audit.from(1, 9).await.unwrap();
    let acts = |it: &Entry| (it.record.act.is_some(), it.clone().shown().record.act.is_some());
    let all: Vec<_> = entries.iter().map(acts).collect();
    assert_eq!(all, [(false, false), (true, true), (true, false)]);
}

#[tokio::test]
async fn entries_are_chained_and_read_back() {
    let audit = filled().await;
    let verified = audit.verify().await.unwrap();
    assert_eq!((verified.ok, verified.entries, verified.bad), (true, 3, None));
    let latest = audit.latest(None, 2, None, Some("anna".into())).await.unwrap();
    assert_eq!(latest[0].record, record("Close Valve1"));
    assert_eq!(latest[0].prev, latest[1].hash);
    assert_eq!(latest[0].hash, verified.head);
    assert!(audit.latest(None, 2, Some("M1".into()), None).await.unwrap().is_empty());
    let search = |text: &str| Search { text: Some(text.into()), limit: 1, ..Search::default() };
    let page = audit.find(search("valve1")).await.unwrap();
    assert_eq!((page.found[0].n, page.next), (3, Some(3)));
    let page = audit.find(Search { before: page.next, ..search("valve1") }).await.unwrap();
    assert_eq!((page.found[0].n, audit.last().await.unwrap()), (2, 3));
    let none = audit.find(Search { to_ms: Some(4), ..search("") }).await.unwrap();
    assert_eq!((none.found.len(), none.next), (0, None));
    assert_eq!((audit.waiting(), audit.is_failing()), (0, false));
}

/// A number of a simulation is read back as the one that was hashed.
#[tokio::test]
async fn fractions_break_no_chain() {
    let audit = Audit::open(None).unwrap();
    let mut seed = 1_u64;
    let fractions: Vec<f64> = std::iter::repeat_with(|| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        f64::from_bits((seed >> 12) | 0x3FF0_0000_0000_0000) * 1e-3
    })
    .take(2000)
    .collect();
    audit.note(Record { details: json!(fractions), ..record("sim") }).await.unwrap();
    assert!(audit.verify().await.unwrap().ok);
}

/// However many ask at once, the chain is checked twice: for the first of them, and for all others.
#[tokio::test]
async fn who_asks_meanwhile_shares_a_check() {
    let audit = filled().await;
    let go = audit.reads().unwrap().hang();
    let ask = || {
        let audit = audit.clone();
        tokio::spawn(async move { audit.verify().await.unwrap().entries })
    };
    let all: Vec<_> = (0..50).map(|_| ask()).collect();
    // Each of them has asked: one waits for the thread that reads, the others for it.
    tokio::task::yield_now().await;
    drop(go);
    for asked in all {
        assert_eq!(asked.await.unwrap(), 3);
    }
    assert_eq!(audit.checks.started.load(Ordering::SeqCst), 2);
    // For who asks later it is checked again: it may have been changed since.
    audit.note(record("Stop All")).await.unwrap();
    assert_eq!(audit.verify().await.unwrap().entries, 4);
    assert_eq!(audit.checks.started.load(Ordering::SeqCst), 3);
}

/// A page that asks and is closed, again and again, makes nothing begin again.
#[tokio::test]
async fn a_check_goes_on_when_who_has_asked_for_it_leaves() {
    let audit = filled().await;
    let go = audit.reads().unwrap().hang();
    let mut checked = Vec::new();
    for _ in 0..3 {
        let own = audit.clone();
        let asked = tokio::spawn(async move { own.verify().await });
        // It has asked, and the check, if it begins one, waits for the thread that reads.
        tokio::task::yield_now().await;
        tokio::task::yield_now().await;
        asked.abort();
        assert!(asked.await.unwrap_err().is_cancelled());
        checked.push(audit.checks.started.load(Ordering::SeqCst));
    }
    assert_eq!(checked, [1; 3], "the first one goes on");
    drop(go);
    let last = audit.checks.last.lock().await;
    let Some(Checked { number: 1, result, .. }) = &*last else { panic!("{last:?}") };
    assert!(result.ok && result.entries == 3);
}

/// A disk that takes entries again takes all that has waited, not a batch each second: a hub that ends then loses none.
#[tokio::test]
async fn what_has_waited_is_stored_without_a_pause() {
    let audit = Audit::open(None).unwrap();
    audit.hang().await;
    let numbers: Vec<_> = (0..BATCH_MAX * 20).map(|_| audit.note(record("Stop All"))).collect();
    audit.reads().unwrap().call(|db| db.execute_batch("COMMIT")).await.unwrap();
    let all = futures_util::future::join_all(numbers);
    let all = timeout(Duration::from_secs(8), all).await.expect("no batch waits for a second");
    assert_eq!(all.last(), Some(&Ok(BATCH_MAX as u64 * 20)));
}

#[tokio::test]
async fn what_was_changed_or_taken_out_shows() {
    let audit = filled().await;
    let entries = audit.from(1, 10).await.unwrap();
    let lines = |entries: &[Entry]| {
        let lines: Vec<_> =
            entries.iter().map(|it| Ok(serde_json::to_string(it).unwrap())).collect();
        verify_lines(lines.into_iter())
    };
    assert!(lines(&entries).ok);
    let mut changed = entries.clone();
    changed[1].record.user = "boris".into();
    assert_eq!(lines(&changed).bad, Some(2));
    let mut taken = entries.clone();
    taken.remove(0);
    assert_eq!(lines(&taken).bad, Some(1));
    taken = entries;
    taken[2] = Entry::new(3, record("Open Valve2"), GENESIS.into());
    assert_eq!(lines(&taken).bad, Some(3));
}

#[tokio::test]
async fn the_database_itself_refuses_changes() {
    let audit = filled().await;
    let reads = audit.reads().unwrap();
    let deleted = reads.call(|db| db.execute("DELETE FROM audit", [])).await;
    assert!(deleted.unwrap_err().to_string().contains("not deleted"));
    let changed = reads.call(|db| db.execute("UPDATE audit SET user = 'x'", [])).await;
    assert!(changed.unwrap_err().to_string().contains("not changed"));
}

/// What was noted is found by who reads afterwards, and a writer that hangs does not hold up who reads.
#[tokio::test]
async fn who_reads_finds_what_was_noted_before() {
    let audit = Audit::open(None).unwrap();
    for round in 1..=200 {
        drop(audit.note(record("Stop All")));
        assert_eq!(audit.last().await.unwrap(), round);
    }
    audit.state.noted.fetch_add(1, Ordering::Relaxed);
    let found = timeout(4 * CATCH_UP, audit.latest(None, 1, None, None)).await;
    assert_eq!(found.expect("the wait is bounded").unwrap()[0].n, 200);
}

/// What a full disk does not take waits, and is stored in its order when there is room.
#[test]
fn a_full_disk_loses_nothing() {
    let connection = open(None, "", SCHEMA).unwrap();
    let limit = |connection: &Connection, pages: u32| {
        // The pragma answers with what it is set to.
        let query = format!("PRAGMA max_page_count = {pages}");
        connection.query_row(&query, [], |row| row.get::<_, u32>(0)).unwrap();
    };
    limit(&connection, 1);
    let (reads, state) = <(Arc<OnceLock<Db>>, Arc<State>)>::default();
    let mut writer = Writer::new(connection, (0, GENESIS.into()), reads, state);
    for _ in 0..50 {
        let note = Note::new(Record { outcome: "x".repeat(500), ..record("Stop All") }, None);
        assert!(writer.state.admit(note.bytes()));
        writer.waiting.push_back(note);
    }
    assert!(writer.store().unwrap_err().to_string().contains("full"));
    assert_eq!((writer.waiting.len(), writer.head.0), (50, 0));
    limit(&writer.connection, 10_000);
    writer.store().unwrap();
    assert_eq!((writer.waiting.len(), writer.head.0), (0, 50));
    let left = [&writer.state.waiting, &writer.state.bytes].map(|it| it.load(Ordering::Relaxed));
    assert_eq!(left, [0, 0]);
}

/// More than fits is given up and counted; what waits is stored in its order.
#[tokio::test]
async fn what_waits_is_bounded() {
    let audit = Audit::open(None).unwrap();
    audit.state.waiting.store(WAITING_MAX, Ordering::Relaxed);
    assert!(audit.note(record("Stop All")).await.is_err());
    assert_eq!((audit.waiting(), audit.lost()), (WAITING_MAX, 1));
    audit.state.waiting.store(0, Ordering::Relaxed);
    let long = record(&"ж".repeat(TEXT_MAX));
    assert_eq!(audit.note(long).await.unwrap(), 1);
    let stored = audit.from(1, 1).await.unwrap();
    assert_eq!(stored[0].record.what, "ж".repeat(TEXT_MAX / 2));
}

/// Not their number alone: entries with many details are long. Of the usual ones there is room for all that may wait.
#[tokio::test]
async fn the_memory_of_what_waits_is_bounded() {
    let request = Act::Request { request: "Move".into(), to: "Horizontal".into() };
    let usual = Note::new(record("Move Horizontal 1200").about(&request), None);
    assert!(usual.bytes() * WAITING_MAX <= WAITING_BYTES, "{} bytes", usual.bytes());
    assert_eq!(usual.record(), record("Move Horizontal 1200").about(&request));
    let state = State::default();
    let states: Vec<u32> = (0..5000).collect();
    let long = Note::new(record("Stop All").with(&states), None);
    let admitted = (0..WAITING_MAX).take_while(|_| state.admit(long.bytes())).count() as u64;
    assert!((100..2000).contains(&admitted), "{admitted} of {} bytes", long.bytes());
    assert_eq!(state.waiting.load(Ordering::Relaxed), admitted);
    assert!(state.bytes.load(Ordering::Relaxed) <= WAITING_BYTES);
    state.release(long.bytes());
    assert!(state.admit(long.bytes()) && !state.admit(long.bytes()));
    // Such an entry is given up, and counted.
    let audit = Audit::open(None).unwrap();
    audit.state.bytes.store(WAITING_BYTES, Ordering::Relaxed);
    assert!(audit.note(record("Stop All")).await.is_err());
    assert_eq!((audit.waiting(), audit.lost()), (0, 1));
}

/// An export is read piece by piece, and no piece is longer than what the hub sends at once.
#[tokio::test]
async fn an_export_comes_in_pieces() {
    let audit = Audit::open(None).unwrap();
    for _ in 0..300 {
        drop(audit.note(Record { outcome: "x".repeat(1000), ..record("Stop All") }));
    }
    let (mut next, mut all, mut pieces) = (1, String::new(), 0);
    while let Some((piece, after)) = audit.lines(next).await.unwrap() {
        assert!(piece.len() < PIECE_BYTES + 2000, "{}", piece.len());
        assert!(after > next && piece.ends_with('\n'));
        (next, pieces) = (after, pieces + 1);
        all += &piece;
    }
    assert_eq!(next, 301);
    assert!((6..20).contains(&pieces), "{pieces}");
    let verified = verify_lines(all.lines().map(|line| Ok(line.to_owned())));
    assert_eq!((verified.ok, verified.entries), (true, 300));
}

/// A disk that does not answer says nothing, not even that it fails; and what was lost meanwhile is in the log
/// after it.
#[tokio::test]
async fn a_disk_that_hangs_fails_and_what_is_lost_leaves_a_trace() {
    let audit = Audit::open(None).unwrap();
    let before = Instant::now().checked_sub(HANGS + Duration::from_secs(1)).unwrap();
    *lock(&audit.state.since) = Some(before);
    assert!(audit.is_failing(), "nothing was taken for so long");
    audit.state.waiting.store(WAITING_MAX, Ordering::Relaxed);
    for at_ms in [70, 60, 90] {
        assert!(audit.note(Record { at_ms, ..record("Stop All") }).await.is_err());
    }
    *lock(&audit.state.since) = None;
    assert!(audit.is_failing(), "three entries are missing");
    audit.state.waiting.store(0, Ordering::Relaxed);
    audit.note(record("Stop All")).await.unwrap();
    let gap = loop {
        if let Some(entry) = audit.from(2, 1).await.unwrap().pop() {
            break entry.record;
        }
    };
    let act = Act::EntriesLost { entries: 3, from_ms: 60, to_ms: 90 };
    assert_eq!((gap.act, gap.at_ms, gap.outcome.as_str()), (Some(act.to_value()), 90, "lost"));
    let began = Instant::now();
    while audit.is_failing() && began.elapsed() < Duration::from_secs(30) {
        tokio::task::yield_now().await;
    }
    assert_eq!((audit.is_failing(), audit.lost(), audit.waiting()), (false, 3, 0));
    assert!(audit.verify().await.unwrap().ok);
}

/// One user's entries among those of many others are looked for piece by piece.
#[tokio::test]
async fn a_search_looks_at_so_many_entries_at_a_time() {
    let audit = Audit::open(None).unwrap();
    for n in 0..20 {
        let user = if n == 1 { "anna" } else { "boris" };
        audit.note(Record { user: user.into(), ..record("Stop All") }).await.unwrap();
    }
    let of = |before| Search { before, user: Some("anna".into()), limit: 9, ..Search::default() };
    let pages = audit.reads().unwrap().call(move |db| {
        let (mut before, mut pages) = (None, Vec::new());
        loop {
            let page = find(db, &of(before), 8)?;
            pages.push((page.found.iter().map(|it| it.n).collect::<Vec<_>>(), page.next));
            before = page.next;
            if before.is_none() {
                return Ok(pages);
            }
        }
    });
    let expected = [(vec![], Some(13)), (vec![], Some(5)), (vec![2], None)];
    assert_eq!(pages.await.unwrap(), expected);
}

#[tokio::test]
async fn the_chain_goes_on_after_a_restart() {
    let folder = std::env::temp_dir().join(format!("lafet-audit-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    for round in 1..=3 {
        let audit = Audit::open(Some(&folder)).unwrap();
        assert_eq!(audit.note(record("Stop All")).await.unwrap(), round);
        assert!(audit.verify().await.unwrap().ok);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
