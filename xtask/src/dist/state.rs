//! The state that a hub of a release leaves, packed for the tests of later versions.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use super::files::packed;
use super::http::Client;
use super::trial::{Running, pause, until};
use super::{read, work, write};
use crate::run::{StepResult, output, root};

/// The hub notes its state every 10 s; this is beyond the second time.
const RUNS: Duration = Duration::from_secs(22);
const PORT: u16 = 18_480;
const MONITOR: u16 = 18_485;

/// Lets a hub run with a simulated monitor and an administrator, and packs what it leaves.
pub fn pack(program: &Path) -> StepResult {
    let folder = work("state")?;
    let config = folder.join("hub.toml");
    let text = format!(
        "[server]\nlisten = \"127.0.0.1:{PORT}\"\n\n[[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:{MONITOR}\"\n"
    );
    write(&config, text)?;
    let mut sim = Command::new(program);
    let mut sim = Running::start(sim.args([
        "--json",
        "sim",
        "--listen",
        &format!("tcp://127.0.0.1:{MONITOR}"),
    ]))?;
    sim.line()?;
    let mut serve = Command::new(program);
    serve.args(["--json", "serve", "--no-browser", "--config"]).arg(&config);
    let mut hub = Running::start(&mut serve)?;
    let client =
        Client::new(&format!("http://127.0.0.1:{PORT}"), folder.join("cookies"), Vec::new());
    client.set_up(&hub.link()?)?;
    until("the monitor is up", || Ok(client.get("/health")?["monitors"]["M1"] == "up"))?;
    pause(RUNS);
    hub.end()?;
    sim.end()?;
    let said = output(Command::new(program).arg("-V"))?;
    let version = said.split_whitespace().nth(1).ok_or("the program has no version")?;
    let to = root().join("crates/hub/tests/releases").join(version);
    let left = folder.join("lafet-data");
    let entries = std::fs::read_dir(&left).map_err(|e| format!("{}: {e}", left.display()))?;
    let names = entries.flatten().map(|it| it.file_name().to_string_lossy().into_owned());
    // SQLite's logs are part of the databases; the rest is made again.
    let is_kept = |it: &String| [".db", ".db-wal", ".json"].iter().any(|end| it.ends_with(end));
    for name in names.filter(is_kept) {
        let bytes = packed(&read(&left.join(&name))?, &name)?;
        write(&to.join(format!("{name}.gz")), bytes)?;
    }
    println!("   {}", to.display());
    Ok(())
}
