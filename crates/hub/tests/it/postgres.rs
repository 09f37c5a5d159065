//! The history in a real PostgreSQL. Debian's is started for the test; where there is none, the
//! test fails unless LAFET_NO_POSTGRES is set: `cargo xtask test` installs it.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::support::{PATIENCE, Site, until};
use lafet_hub::store::Address;
use serde_json::{Value, json};

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
