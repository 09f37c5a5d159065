//! The history in a real PostgreSQL. Debian's is started for the test; where there is none, the
//! test fails unless LAFET_NO_POSTGRES is set: `cargo xtask test` installs it.

use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::support::{PATIENCE, Site, stays, until};
use lafet_hub::store::{Address, DAY_MS, History};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio_postgres::Client;

/// A server of our own, in a folder of its own.
struct Server {
    folder: PathBuf,
    port: u16,
    options: Vec<String>,
    child: Option<Child>,
}

fn programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").ok()?;
    let bin = versions.flatten().map(|it| it.path().join("bin"));
    bin.filter(|bin| bin.join("initdb").is_file()).max()
}

/// A command as a user who is not root: PostgreSQL refuses root.
fn command(program: &Path, folder: &Path) -> Command {
    let root = std::env::var("USER").is_ok_and(|it| it == "root")
        || std::fs::metadata("/proc/self").is_ok_and(|it| {
            use std::os::unix::fs::MetadataExt;
            it.uid() == 0
        });
    let mut command = if root {
        let mut command = Command::new("runuser");
        command.args(["-u", "postgres", "--"]).arg(program);
        command
    } else {
        Command::new(program)
    };
    command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

impl Server {
    fn new(bin: &Path, name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o777)).unwrap();
        let made = command(&bin.join("initdb"), &folder)
            .args(["-D", "data", "-A", "trust", "-U", "lafet", "--no-sync"])
            .status()
            .unwrap();
        assert!(made.success(), "initdb");
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        Self { folder, port, options: Vec::new(), child: None }
    }

    fn start(&mut self, bin: &Path) {
        let port = self.port.to_string();
        let child = command(&bin.join("postgres"), &self.folder)
            .args(["-D", "data", "-h", "127.0.0.1", "-k", ".", "-p", &port, "-F"])
            .args(&self.options)
            .spawn()
            .unwrap();
        self.child = Some(child);
    }

    fn stop(&mut self) {
        let file = std::fs::read_to_string(self.folder.join("data/postmaster.pid"));
        if let Some(pid) = file.ok().and_then(|text| text.lines().next().map(str::to_owned)) {
            _ = Command::new("kill").args(["-QUIT", &pid]).status();
        }
        if let Some(mut child) = self.child.take() {
            _ = child.wait();
        }
    }

    fn url(&self) -> String {
        format!("postgres://lafet@127.0.0.1:{}/postgres", self.port)
    }

    /// A certificate for `localhost`, signed by `ca.pem` beside it; the server wants one of its
    /// clients for the role `scada`, and takes `lafet` with TLS alone.
    fn with_certificates(&mut self) {
        let key = || rcgen::KeyPair::generate().unwrap();
        let authority = |name: &str| {
            let mut params = rcgen::CertificateParams::new(Vec::<String>::new()).unwrap();
            params.is_ca = rcgen::IsCa::Ca(rcgen::BasicConstraints::Unconstrained);
            params.distinguished_name.push(rcgen::DnType::CommonName, name);
            rcgen::CertifiedIssuer::self_signed(params, key()).unwrap()
        };
        let issued = |name: &str, by: &rcgen::CertifiedIssuer<'_, rcgen::KeyPair>| {
            let (mut params, key) =
                (rcgen::CertificateParams::new([name.to_owned()]).unwrap(), key());
            params.distinguished_name.push(rcgen::DnType::CommonName, name);
            (params.signed_by(&key, by).unwrap().pem(), key.serialize_pem())
        };
        let (ca, other) = (authority("site"), authority("another site"));
        let (server, client) = (issued("localhost", &ca), issued("scada", &ca));
        for (name, text) in [
            ("ca.pem", ca.pem()),
            ("other.pem", other.pem()),
            ("client.pem", client.0),
            ("client.key", client.1),
            ("data/server.crt", server.0),
            ("data/server.key", server.1),
            (
                "data/pg_hba.conf",
                "local all all trust\nhostssl all scada all cert\nhostssl all lafet all trust\n"
                    .into(),
            ),
        ] {
            let file = self.folder.join(name);
            std::fs::write(&file, text).unwrap();
            if name.starts_with("data/") {
                own_alike(&file, &self.folder.join("data"));
            }
        }
        let ca = self.folder.join("ca.pem");
        self.options =
            ["-c", "ssl=on", "-c", "log_min_messages=error", "-c"].map(str::to_owned).into();
        self.options.push(format!("ssl_ca_file={}", ca.display()));
    }

    /// Whether the hub's own way of connecting comes through, and with TLS.
    async fn takes(&self, place: &str) -> Result<bool, String> {
        let url = format!("postgres://{}", place.replace("PORT", &self.port.to_string()));
        let address = Address::parse(&url, &self.folder).map_err(|(what, _)| what.en)?;
        let client = address.client().await?;
        let row = client
            .query_one("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()", &[])
            .await
            .map_err(|error| error.to_string())?;
        Ok(row.get(0))
    }
}

/// A file of the server's: its owner's, and no other's.
fn own_alike(file: &Path, like: &Path) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
    let like = std::fs::metadata(like).unwrap();
    std::fs::set_permissions(file, std::fs::Permissions::from_mode(0o600)).unwrap();
    chown(file, Some(like.uid()), Some(like.gid())).unwrap();
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn alarm(site: &Site) -> Option<String> {
    let value = site.hub.topics().get("alarms/hub/History")?;
    let value: Value = serde_json::from_str(value.get()).ok()?;
    Some(value["state"].as_str()?.to_owned())
}

async fn bits(site: &Site) -> Value {
    let place = "/api/history?monitor=M1&series=General.bits";
    let reply = site.get("", place).await;
    reply.body["series"]["General.bits"].clone()
}

/// A name and a reason with a zero, which PostgreSQL has in no text.
async fn what_is_never_taken_holds_nothing_up(site: &Site) {
    let now_ms = site.hub.clock().now_ms();
    site.hub.history().note(now_ms, "M1", "no\0name", 1.0);
    until("it is given up", || site.hub.history().given_up() > 0).await;
    let change = ["M1/Later", "M1", "normal", "unack"].map(str::to_owned);
    site.hub.history().alarm(now_ms, change, None, Some("why\0".into()));
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(std::time::Duration::from_millis(100));
    loop {
        ticks.tick().await;
        let log = site.get("", "/api/alarms/history?monitor=M1").await.body.to_string();
        if log.contains("why\u{fffd}") {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "{log}");
    }
}

#[tokio::test]
async fn what_happened_while_the_server_was_away_is_stored_later() {
    let Some(bin) = programs() else {
        assert!(std::env::var_os("LAFET_NO_POSTGRES").is_some(), "apt-get install postgresql");
        return;
    };
    let mut server = Server::new(&bin, "postgres");
    let url = server.url();
    let site = Site::with(1, |config| {
        config.login = false;
        config.postgres = Some(Address::parse(&url, Path::new("/")).unwrap());
    })
    .await;
    // The server is not there yet: an alarm, and the hub works.
    until("it is reported", || alarm(&site).as_deref() == Some("unack")).await;
    let refused = site.get("", "/api/history?monitor=M1&series=General.bits").await;
    assert_eq!((refused.status, refused.code()), (503, "storage"));
    site.post("", "/api/monitors/M1/lockout", json!({})).await;
    assert_eq!(site.get("", "/health").await.body["history"], "failing");

    server.start(&bin);
    until("it is stored", || alarm(&site).as_deref() == Some("rtn_unack")).await;
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(std::time::Duration::from_millis(100));
    let values = loop {
        ticks.tick().await;
        let values = bits(&site).await;
        if values.as_array().is_some_and(|it| it.len() > 1) {
            break values;
        }
        assert!(began.elapsed() < PATIENCE, "{values}");
    };
    let [first, .., last] = &values.as_array().unwrap()[..] else { panic!("{values}") };
    assert_eq!(first[1], 0.0, "from before the server was there: {values}");
    assert_ne!(last[1], 0.0, "{values}");
    let log = site.get("", "/api/alarms/history?monitor=M1").await.body;
    assert!(log.to_string().contains("M1/General/LockedOut"), "{log}");
    let changes = site.get("", "/api/history/changes").await.text;
    assert!(changes.contains("LockedOut"), "{changes}");
    let parquet = site.get("", "/api/history.parquet?monitor=M1&series=General.bits").await;
    assert_eq!(parquet.status, 200);

    let now_ms = site.hub.clock().now_ms();
    let minutes = format!(
        "/api/history?monitor=M1&series=General.bits&points=600&from_ms={}&to_ms={now_ms}",
        now_ms - 86_400_000
    );
    let minutes = site.get("", &minutes).await;
    assert_eq!((minutes.status, &minutes.body["resolution_ms"]), (200, &json!(180_000)));
    site.hub.history().forget(now_ms + 2 * 86_400_000, 1, 1);
    let client = Address::parse(&url, Path::new("/")).unwrap().client().await.unwrap();
    loop {
        ticks.tick().await;
        let query = "SELECT COUNT(*) FROM lafet_raw WHERE t < $1";
        let old: i64 = client.query_one(query, &[&now_ms.cast_signed()]).await.unwrap().get(0);
        if old == 0 {
            break;
        }
        assert!(began.elapsed() < 2 * PATIENCE, "{old} old rows are still there");
    }

    what_is_never_taken_holds_nothing_up(&site).await;

    server.stop();
    until("it is reported again", || alarm(&site).as_deref() == Some("unack")).await;
    let stop = site.post("", "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(
        stop.code(),
        "refused",
        "the monitor, which is locked out, has been asked: {stop:?}"
    );
}

#[tokio::test]
async fn tls_is_as_libpq_has_it() {
    let Some(bin) = programs() else {
        assert!(std::env::var_os("LAFET_NO_POSTGRES").is_some(), "apt-get install postgresql");
        return;
    };
    let mut server = Server::new(&bin, "postgres-tls");
    server.with_certificates();
    server.start(&bin);
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(std::time::Duration::from_millis(100));
    let name = "lafet@localhost:PORT/postgres";
    while let Err(said) = server.takes(&format!("{name}?sslmode=require")).await {
        assert!(began.elapsed() < PATIENCE, "{said}");
        ticks.tick().await;
    }
    let url = format!("postgres://{}", name.replace("PORT", &server.port.to_string()));
    let client = Address::parse(&url, &server.folder).unwrap().client().await.unwrap();
    client.batch_execute("CREATE ROLE scada LOGIN").await.unwrap();
    let address = "lafet@127.0.0.1:PORT/postgres";
    for (place, taken) in [
        // pg_hba.conf takes nothing without TLS.
        (format!("{name}?sslmode=disable"), Err("no encryption")),
        (format!("{name}?sslmode=allow"), Ok(true)),
        (name.into(), Ok(true)),
        (format!("{name}?sslmode=require&sslrootcert=other.pem"), Err("UnknownIssuer")),
        (format!("{address}?sslmode=require"), Ok(true)),
        (format!("{address}?sslmode=verify-ca&sslrootcert=ca.pem"), Ok(true)),
        (format!("{address}?sslmode=verify-ca&sslrootcert=other.pem"), Err("UnknownIssuer")),
        (format!("{address}?sslmode=verify-full&sslrootcert=ca.pem"), Err("not valid for name")),
        (format!("{name}?sslmode=verify-full&sslrootcert=ca.pem"), Ok(true)),
        (format!("{name}?sslmode=verify-full&sslrootcert=data/server.crt"), Ok(true)),
        ("scada@localhost:PORT/postgres?sslmode=require".into(), Err("certificate")),
        (
            "scada@localhost:PORT/postgres?sslmode=verify-full&sslrootcert=ca.pem\
             &sslcert=client.pem&sslkey=client.key"
                .into(),
            Ok(true),
        ),
    ] {
        let came = server.takes(&place).await;
        match taken {
            Ok(tls) => assert_eq!(came, Ok(tls), "{place}"),
            Err(words) => {
                let said = came.expect_err(&place);
                assert!(said.contains(words), "{place}: {said}");
            }
        }
    }
}

/// A server that works, and a client of it beside the hub's.
async fn started(name: &str) -> Option<(PathBuf, Server, Client)> {
    let Some(bin) = programs() else {
        assert!(std::env::var_os("LAFET_NO_POSTGRES").is_some(), "apt-get install postgresql");
        return None;
    };
    let mut server = Server::new(&bin, name);
    server.start(&bin);
    let address = Address::parse(&server.url(), Path::new("/")).unwrap();
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    loop {
        ticks.tick().await;
        match address.client().await {
            Ok(client) => return Some((bin, server, client)),
            Err(said) => assert!(began.elapsed() < PATIENCE, "{said}"),
        }
    }
}

fn history(url: &str) -> History {
    History::open_postgres(Address::parse(url, Path::new("/")).unwrap()).unwrap()
}

/// A history that has stored that a valve was closed at 1000.
async fn with_valve(url: &str) -> History {
    let mut history = history(url);
    history.note(1000, "M1", "valve", 0.0);
    history.flush();
    until_is(json!([[1000, 0.0]]), async || valve(&history).await).await;
    history
}

/// What is stored of the valve.
async fn valve(history: &History) -> Value {
    match history.base().values("M1", "valve", (0, u64::MAX), None, 100).await {
        Ok(rows) => json!(rows),
        Err(error) => json!(error.to_string()),
    }
}

fn raised(history: &History, at_ms: u64, id: &str) {
    history.alarm(at_ms, [id, "M1", "normal", "unack"].map(str::to_owned), None, None);
}

/// How many rows an alarm has.
async fn rows_of(client: &Client, id: &str) -> i64 {
    let query = "SELECT COUNT(*) FROM lafet_alarm WHERE id = $1";
    client.query_one(query, &[&id]).await.unwrap().get(0)
}

/// Waits until an answer is as wanted; for hundreds of thousands of rows that takes a while.
async fn until_is<T: PartialEq + Debug>(wanted: T, ask: impl AsyncFn() -> T) {
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    loop {
        ticks.tick().await;
        let answer = ask().await;
        if answer == wanted {
            return;
        }
        assert!(began.elapsed() < 2 * PATIENCE, "{answer:?}, not {wanted:?}");
    }
}

#[tokio::test]
async fn the_end_waits_for_what_is_not_stored_yet_but_not_for_ever() {
    let Some((_, server, client)) = started("postgres-end").await else { return };
    let mut history = with_valve(&server.url()).await;
    let lock = "BEGIN; LOCK lafet_alarm IN ACCESS EXCLUSIVE MODE";
    client.batch_execute(lock).await.unwrap();
    raised(&history, 2000, "M1/last");
    let settled = tokio::spawn(history.settle());
    let waits = stays(Duration::from_millis(500), || !settled.is_finished()).await;
    assert!(waits, "the server has not taken the alarm yet");
    client.batch_execute("COMMIT").await.unwrap();
    settled.await.unwrap().unwrap();
    assert_eq!(rows_of(&client, "M1/last").await, 1);

    client.batch_execute(lock).await.unwrap();
    raised(&history, 3000, "M1/late");
    let settled = tokio::time::timeout(Duration::from_secs(8), history.settle()).await;
    assert!(settled.is_ok(), "the hub ends without the server");
}

#[tokio::test]
async fn old_rows_that_cannot_be_removed_hold_nothing_up() {
    let Some((_, server, client)) = started("postgres-held").await else { return };
    let history = with_valve(&server.url()).await;
    raised(&history, 1000, "M1/old");
    until_is(1, async || rows_of(&client, "M1/old").await).await;
    client.batch_execute("BEGIN; SELECT n FROM lafet_alarm FOR UPDATE").await.unwrap();
    history.forget(10 * DAY_MS, 1, 1);
    raised(&history, 10 * DAY_MS, "M1/new");
    until_is(1, async || rows_of(&client, "M1/new").await).await;
    let query = "SELECT COUNT(*) FROM pg_stat_activity
        WHERE state = 'active' AND query LIKE 'DELETE FROM lafet%'";
    let deletes: i64 = client.query_one(query, &[]).await.unwrap().get(0);
    assert_eq!(deletes, 0, "the server does not go on with what was given up");
    assert!(!history.is_failing());
}

/// Opened and closed again while the server was away, and then more changes than wait.
#[tokio::test]
async fn what_was_lost_is_a_gap_and_no_value_that_held() {
    let Some((bin, mut server, client)) = started("postgres-lost").await else { return };
    let mut history = with_valve(&server.url()).await;
    drop(client);
    server.stop();
    until("it is reported", || history.is_failing()).await;
    for (at_ms, value) in [(2000, 1.0), (3000, 0.0)] {
        history.note(at_ms, "M1", "valve", value);
        history.flush();
    }
    let mut at_ms = 4000;
    for _ in 0..12 {
        for change in 0..50_000 {
            at_ms += 200;
            history.note(at_ms, "M1", "other", f64::from(change % 2));
        }
        history.flush();
    }
    until("the oldest are lost", || history.given_up() > 0).await;
    server.start(&bin);
    until_is(false, async || history.is_failing()).await;
    history.flush();
    let expected = json!([[1000, 0.0], [2000, null], [3000, 0.0]]);
    until_is(expected, async || valve(&history).await).await;
}

/// What was stored at later dates, before the date was put back, hides no end.
#[tokio::test]
async fn after_a_start_nothing_is_known_though_later_dates_have_values() {
    let Some((_, server, client)) = started("postgres-put-back").await else { return };
    drop(with_valve(&server.url()).await);
    let later = "INSERT INTO lafet_raw SELECT id, t, value FROM lafet_series,
          (VALUES (900000::BIGINT, 1.0::FLOAT8), (900005, NULL)) AS later (t, value);
        INSERT INTO lafet_minute SELECT id, t, 0, 0, 0 FROM lafet_series,
          (VALUES (1000::BIGINT), (900000)) AS minutes (t);
        INSERT INTO lafet_gap SELECT id, 900005 FROM lafet_series;
        UPDATE lafet_mark SET t = 500000 WHERE name = 'known'";
    client.batch_execute(later).await.unwrap();
    let expected = json!([[1000, 0.0], [500_000, null], [900_000, 1.0], [900_005, null]]);
    for _ in 0..2 {
        let history = history(&server.url());
        until_is(expected.clone(), async || valve(&history).await).await;
        let query = "SELECT ARRAY(SELECT t FROM lafet_gap ORDER BY t)";
        let gaps: Vec<i64> = client.query_one(query, &[]).await.unwrap().get(0);
        assert_eq!(gaps, [500_000, 900_005]);
    }
}

/// A name that no text can be, and a value that a rule of the site's forbids.
#[tokio::test]
async fn of_what_is_refused_the_rest_is_stored_and_a_gap_in_its_place() {
    let Some((_, server, client)) = started("postgres-refused").await else { return };
    let mut history = with_valve(&server.url()).await;
    client.batch_execute("ALTER TABLE lafet_raw ADD CHECK (value < 100)").await.unwrap();
    history.note(2000, "M1", "no\0name", 1.0);
    history.note(2000, "M1", "valve", 1.0);
    history.note(3000, "M1", "valve", 500.0);
    history.flush();
    let expected = json!([[1000, 0.0], [2000, 1.0], [3000, null]]);
    until_is(expected, async || valve(&history).await).await;
    assert_eq!((history.given_up(), history.is_failing()), (2, false));
}

/// Passes everything on, until it is armed: then it cuts the connection when the server says that it has stored a row.
async fn cutter(port: u16, armed: Arc<AtomicBool>) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let own = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        while let Ok((client, _)) = listener.accept().await {
            tokio::spawn(pass(client, port, armed.clone()));
        }
    });
    own
}

async fn pass(client: TcpStream, port: u16, armed: Arc<AtomicBool>) {
    let Ok(server) = TcpStream::connect(("127.0.0.1", port)).await else { return };
    let (mut from_client, mut to_client) = client.into_split();
    let (mut from_server, mut to_server) = server.into_split();
    let asked = tokio::io::copy(&mut from_client, &mut to_server);
    let answered = async {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = from_server.read(&mut bytes).await {
            let answer = &bytes[..count];
            let stored = answer.windows(10).any(|it| it == b"INSERT 0 1");
            let cut = stored && armed.swap(false, Ordering::Relaxed);
            if cut || to_client.write_all(answer).await.is_err() {
                return;
            }
        }
    };
    tokio::select! {
        _ = asked => {}
        () = answered => {}
    }
}

#[tokio::test]
async fn an_alarm_is_stored_once_though_the_answer_is_lost() {
    let Some((_, server, client)) = started("postgres-twice").await else { return };
    let armed = Arc::new(AtomicBool::new(false));
    let port = cutter(server.port, armed.clone()).await;
    let url = format!("postgres://lafet@127.0.0.1:{port}/postgres?sslmode=disable");
    let history = with_valve(&url).await;
    armed.store(true, Ordering::Relaxed);
    raised(&history, 2000, "M1/once");
    raised(&history, 3000, "M1/next");
    until_is(1, async || rows_of(&client, "M1/next").await).await;
    assert!(!armed.load(Ordering::Relaxed), "an answer was cut off");
    assert_eq!(rows_of(&client, "M1/once").await, 1);
}

/// Its tables are from before a row of an alarm was known by an id.
#[tokio::test]
async fn tables_of_before_are_used_on() {
    let Some((_, server, client)) = started("postgres-former").await else { return };
    let former = "CREATE TABLE lafet_alarm (
        n BIGSERIAL PRIMARY KEY, at_ms BIGINT NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL,
        before TEXT NOT NULL, after TEXT NOT NULL, by TEXT, reason TEXT);
        INSERT INTO lafet_alarm (at_ms, id, monitor, before, after)
        VALUES (1, 'M1/x', 'M1', 'normal', 'unack'), (2, 'M1/x', 'M1', 'unack', 'ack')";
    client.batch_execute(former).await.unwrap();
    let history = with_valve(&server.url()).await;
    raised(&history, 3000, "M1/x");
    until_is(3, async || rows_of(&client, "M1/x").await).await;
}

#[tokio::test]
async fn a_second_hub_waits_until_the_first_has_ended() {
    let Some((_, server, _client)) = started("postgres-two").await else { return };
    let first = with_valve(&server.url()).await;
    let second = history(&server.url());
    until("it is reported", || second.is_failing()).await;
    assert_eq!(valve(&first).await, json!([[1000, 0.0]]), "it goes on in the first");
    assert_eq!((first.is_failing(), second.given_up()), (false, 0));
    drop(first);
    until("the second takes over", || !second.is_failing()).await;
    until_is(json!([[1000, 0.0], [1001, null]]), async || valve(&second).await).await;
}
