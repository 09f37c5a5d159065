//! The history in a real PostgreSQL. Debian's is started for the test; where there is none, the
//! test fails unless LAFET_NO_POSTGRES is set: `cargo xtask test` installs it.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use support::{PATIENCE, Site, until};

/// A server of our own, in a folder of its own.
struct Server {
    folder: PathBuf,
    port: u16,
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
    fn new(bin: &Path) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-postgres-{}", std::process::id()));
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
        Self { folder, port, child: None }
    }

    fn start(&mut self, bin: &Path) {
        let port = self.port.to_string();
        let child = command(&bin.join("postgres"), &self.folder)
            .args(["-D", "data", "-h", "127.0.0.1", "-k", ".", "-p", &port, "-F"])
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
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn alarm(site: &Site) -> Option<String> {
    let value = site.hub.topics.get("alarms/hub/History")?;
    let value: Value = serde_json::from_str(value.get()).ok()?;
    Some(value["state"].as_str()?.to_owned())
}

async fn bits(site: &Site) -> Value {
    let place = "/api/history?monitor=M1&series=General.bits";
    let reply = site.get("", place).await;
    reply.body["series"]["General.bits"].clone()
}

#[tokio::test]
async fn what_happened_while_the_server_was_away_is_stored_later() {
    let Some(bin) = programs() else {
        assert!(std::env::var_os("LAFET_NO_POSTGRES").is_some(), "apt-get install postgresql");
        return;
    };
    let mut server = Server::new(&bin);
    let url = server.url();
    let site = Site::with(1, |config| {
        config.login = false;
        config.history_url = Some(url);
    })
    .await;
    // The server is not there yet: an alarm, and the hub works.
    until("it is told", || alarm(&site).as_deref() == Some("unack")).await;
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

    server.stop();
    until("it is told again", || alarm(&site).as_deref() == Some("unack")).await;
    let stop = site.post("", "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(
        stop.code(),
        "refused",
        "the monitor, which is locked out, has been asked: {stop:?}"
    );
}
