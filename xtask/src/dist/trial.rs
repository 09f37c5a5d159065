//! The test: what is made is installed, used, upgraded, removed and purged in a bare Debian, which
//! systemd-nspawn boots with a network of its own. systemd starts the service, with all that the unit forbids.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::http::Client;
use super::root::{self, Machine};
use super::{
    Arch, Built, binary, built, clear, copy, deb, image, lint, sums, tools, version, work,
};
use crate::run::{StepResult, output};

/// From the package to a monitor that is seen.
const GOAL: Duration = Duration::from_secs(60);
/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);
const ADDRESS: &str = "http://127.0.0.1:8480";
const UNIT: &str = "lafet-hub.service";
const UNIT_FILE: &str = "/usr/lib/systemd/system/lafet-hub.service";
const STATE: &str = "/var/lib/lafet";
const CONFIG: &str = "/etc/lafet/hub.toml";
/// Lines of the site in the configuration, which an upgrade must keep.
const OWN_LINES: &str = "\n[authority]\nlost_ms = 4000\n";

/// The files in a folder, each on its processor.
pub fn run(out: &Path, arches: &[&'static Arch]) -> StepResult {
    sums::trial()?;
    for &arch in arches {
        let version = version()?;
        let built = built(&out.join(format!("lafet-{version}-linux-{}", arch.name)), arch, true)?;
        let folder = work("trial")?;
        let package = format!("lafet_{version}_{}.deb", arch.name);
        copy(&out.join(&package), &folder.join(&package))?;
        if is_own(arch) {
            deb::make(&Built { version: next(&version), ..built.clone() }, &folder)?;
        }
        start(&folder, &built)?;
        let image = out.join(format!("lafet-{version}-oci-{}.tar", arch.name));
        of_image(&image, &built)?;
    }
    Ok(())
}

/// The version of the package that the first one is upgraded to.
pub fn next(version: &str) -> String {
    format!("{version}+next")
}

/// Whether this machine runs its programs.
fn is_own(arch: &Arch) -> bool {
    arch.triple.split('-').next() == Some(std::env::consts::ARCH)
}

/// The packages in a folder, of one processor.
pub fn start(folder: &Path, built: &Built) -> StepResult {
    if !is_own(built.arch) {
        return emulated(built);
    }
    tools::command("curl", "curl")?;
    let root = work("root")?;
    root::unpack(&root)?;
    let packages = root.join("packages");
    clear(&packages)?;
    copy(&built.program, &packages.join("lafet"))?;
    for (version, name) in [(built.version.clone(), "1.deb"), (next(&built.version), "2.deb")] {
        let package = format!("lafet_{version}_{}.deb", built.arch.name);
        copy(&folder.join(package), &packages.join(name))?;
    }
    let booted = Instant::now();
    let machine = Machine::boot(&root)?;
    println!("   {:5.1} s until Debian has booted", booted.elapsed().as_secs_f32());
    let cookies = folder.join("cookies");
    let client = Client::new(ADDRESS, cookies, machine.beside());
    let trial = Trial { machine, client, began: Instant::now() };
    trial.all(&next(&built.version)).map_err(|e| format!("{e}\n{}", trial.journal()))
}

struct Trial {
    machine: Machine,
    client: Client,
    began: Instant,
}

impl Trial {
    fn all(&self, upgraded: &str) -> StepResult {
        self.install_and_look()?;
        self.upgrade(upgraded)?;
        self.stays_stopped()?;
        self.remove_and_purge()?;
        self.by_hand()
    }

    /// From the package to a monitor in the API, and what was installed on the way.
    fn install_and_look(&self) -> StepResult {
        self.install("1.deb")?;
        self.note("installed and started");
        self.client.set_up(&self.link()?)?;
        self.look()?;
        self.note("until a monitor was seen");
        if self.began.elapsed() > GOAL {
            return Err(format!("the goal is {} s", GOAL.as_secs()));
        }
        self.rights()?;
        println!("{}", self.machine.said(&["lafet", "doctor", "--install"])?.trim_end());
        self.there("/etc/needrestart/conf.d/lafet.conf", true)?;
        for page in ["man/man1/lafet-serve.1.gz", "bash-completion/completions/lafet"] {
            self.there(&format!("/usr/share/{page}"), true)?;
        }
        lint::unit(&self.machine)?;
        self.note("checked");
        Ok(())
    }

    /// The second version, with what the site has changed and stored.
    fn upgrade(&self, version: &str) -> StepResult {
        let own = self.machine.read(CONFIG)? + OWN_LINES;
        self.machine.write(CONFIG, &own)?;
        let before = self.process()?;
        self.install("2.deb")?;
        let query = ["dpkg-query", "-W", "-f", "${Version}", "lafet"];
        if self.machine.said(&query)? != version {
            return Err(format!("{version} is not installed"));
        }
        if self.machine.read(CONFIG)? != own {
            return Err(format!("the upgrade has changed {CONFIG}"));
        }
        if self.process()? == before {
            return Err("the program of the former version still runs".into());
        }
        self.known()?;
        self.rights()?;
        self.note("upgraded, with its state");
        Ok(())
    }

    /// What a person has stopped is not started by a package.
    fn stays_stopped(&self) -> StepResult {
        self.machine.said(&["systemctl", "stop", UNIT])?;
        let again = ["apt-get", "install", "-qq", "-y", "--reinstall", "/packages/2.deb"];
        self.machine.said(&again)?;
        let shown =
            self.machine.said(&["systemctl", "show", UNIT, "-p", "ActiveState", "--value"])?;
        if shown.trim() != "inactive" {
            return Err(format!("a hub that was stopped is {} after an upgrade", shown.trim()));
        }
        self.machine.said(&["systemctl", "start", UNIT])?;
        self.known()?;
        self.note("upgraded while it was stopped, and started by hand");
        Ok(())
    }

    fn remove_and_purge(&self) -> StepResult {
        self.machine.said(&["apt-get", "remove", "-qq", "-y", "lafet"])?;
        self.there("/usr/bin/lafet", false)?;
        for kept in [STATE, CONFIG, "/var/lib/lafet/hub.db"] {
            self.there(kept, true)?;
        }
        self.install("2.deb")?;
        self.known()?;
        self.note("removed and installed again, with its state");
        self.purge()?;
        self.install("1.deb")?;
        self.client.set_up(&self.link()?)?;
        self.look()?;
        self.purge()?;
        self.note("purged, installed as new, purged");
        Ok(())
    }

    fn purge(&self) -> StepResult {
        self.machine.said(&["apt-get", "purge", "-qq", "-y", "lafet"])?;
        let all = [STATE, "/etc/lafet", "/etc/needrestart/conf.d/lafet.conf", UNIT_FILE];
        for gone in all {
            self.there(gone, false)?;
        }
        match self.machine.said(&["getent", "passwd", "lafet"]) {
            Err(_) => Ok(()),
            Ok(_) => Err("the user lafet is left after purge".into()),
        }
    }

    /// The program alone, as docs/install.md says.
    fn by_hand(&self) -> StepResult {
        let began = Instant::now();
        let machine = &self.machine;
        machine.said(&["install", "-m", "0755", "/packages/lafet", "/usr/local/bin/lafet"])?;
        let adduser = ["adduser", "--system", "--group", "--quiet", "--no-create-home"];
        machine.said(&[&adduser[..], &["--home", STATE, "lafet"]].concat())?;
        machine.said(&["install", "-d", "-m", "0750", "-g", "lafet", "/etc/lafet"])?;
        machine.write(CONFIG, super::files::CONFIG)?;
        machine.said(&["chgrp", "lafet", CONFIG])?;
        machine.said(&["chmod", "0640", CONFIG])?;
        let unit = machine.said(&["lafet", "serve", "--unit"])?;
        let unit = unit.replace("/usr/bin/", "/usr/local/bin/");
        machine.write("/etc/systemd/system/lafet-hub.service", &unit)?;
        machine.said(&["systemctl", "daemon-reload"])?;
        machine.said(&["systemctl", "enable", "--quiet", "--now", UNIT])?;
        self.client.set_up(&self.link()?)?;
        self.look()?;
        let seconds = began.elapsed().as_secs_f32();
        println!("   {seconds:5.1} s by hand, from the program to a monitor that is seen");
        Ok(())
    }

    fn install(&self, package: &str) -> StepResult {
        let path = format!("/packages/{package}");
        let apt = ["apt-get", "install", "-qq", "-y", &path];
        self.machine.said(&apt).map(drop)
    }

    /// A simulated monitor is in the API, for the user who has logged in.
    fn look(&self) -> StepResult {
        let sim = ["systemd-run", "--quiet", "--collect", "--unit=sim", "--uid=nobody"];
        self.machine.said(&[&sim[..], &["lafet", "sim"]].concat())?;
        let seen = until("the monitor is seen", || {
            let up = self.client.get("/health")?["monitors"]["M1"] == "up";
            Ok(up && self.client.get("/api/monitors")?["M1"].is_object())
        });
        self.machine.said(&["systemctl", "stop", "sim"])?;
        seen
    }

    /// The users of before are there, and so is the monitor.
    fn known(&self) -> StepResult {
        until("the hub answers", || self.client.get("/health").map(|_| true))?;
        self.client.log_in()?;
        self.look()
    }

    /// The one-time link, from the journal as an administrator reads it.
    fn link(&self) -> Result<String, String> {
        let mut found = None;
        until("the hub has printed its link", || {
            // A link of an earlier start is of no use.
            let show = ["systemctl", "show", UNIT, "-p", "InvocationID", "--value"];
            let of = format!("_SYSTEMD_INVOCATION_ID={}", self.machine.said(&show)?.trim());
            let said = self.machine.said(&["journalctl", "-o", "cat", &of])?;
            found = said.lines().rev().find_map(link_in);
            Ok(found.is_some())
        })?;
        found.ok_or_else(|| "no link".to_owned())
    }

    fn process(&self) -> Result<String, String> {
        self.machine.said(&["systemctl", "show", UNIT, "-p", "MainPID", "--value"])
    }

    fn journal(&self) -> String {
        let shown = self.machine.said(&["journalctl", "-u", UNIT, "-o", "cat", "-n", "30"]);
        shown.unwrap_or_else(|e| e)
    }

    /// The state is the hub's alone, and other users cannot read its configuration.
    fn rights(&self) -> StepResult {
        let stat = ["stat", "-c", "%U %G %a %n", STATE, "/var/lib/lafet/hub.db", CONFIG];
        let said = self.machine.said(&stat)?;
        let wanted = "lafet lafet 700 /var/lib/lafet\nlafet lafet 600 /var/lib/lafet/hub.db\n\
                      root lafet 640 /etc/lafet/hub.toml\n";
        if said != wanted {
            return Err(format!("rights are:\n{said}they should be:\n{wanted}"));
        }
        let groups = self.machine.said(&["id", "-nG", "lafet"])?;
        match groups.split_whitespace().any(|it| it == "dialout") {
            true => Ok(()),
            false => Err(format!("lafet is only in {}", groups.trim())),
        }
    }

    fn there(&self, path: &str, wanted: bool) -> StepResult {
        let is = if wanted { "is missing" } else { "is left" };
        if self.machine.has(path) == wanted { Ok(()) } else { Err(format!("{path} {is}")) }
    }

    fn note(&self, what: &str) {
        println!("   {:5.1} s {what}", self.began.elapsed().as_secs_f32());
    }
}

/// The link in a line of a hub's output.
fn link_in(line: &str) -> Option<String> {
    let said: Value = serde_json::from_str(line).ok()?;
    said["setup"].as_str().map(str::to_owned)
}

/// The program of another processor, without its Debian.
fn emulated(built: &Built) -> StepResult {
    let version = output(binary::command(built)?.args(["--version", "--json"]))?;
    let version: Value = serde_json::from_str(&version).map_err(|e| format!("--version: {e}"))?;
    if version["target"] != built.arch.triple {
        return Err(format!("this is not for {}: {version}", built.arch.triple));
    }
    let folder = work("emulated")?;
    let config = folder.join("hub.toml");
    let text = super::files::CONFIG.replace("8480", "18480").replace("10485", "18485");
    let text = text.replace("/var/lib/lafet", &folder.join("state").display().to_string());
    std::fs::write(&config, text).map_err(|e| e.to_string())?;
    let monitor = "tcp://127.0.0.1:18485";
    let mut sim = binary::command(built)?;
    let mut sim = Running::start(sim.args(["--json", "sim", "--listen", monitor]))?;
    sim.line()?;
    output(binary::command(built)?.args(["-c", monitor, "--timeout", "10", "status"]))?;
    let mut hub = binary::command(built)?;
    hub.args(["--json", "serve", "--no-browser", "--config"]).arg(&config);
    let mut hub = Running::start(&mut hub)?;
    let client = Client::new("http://127.0.0.1:18480", folder.join("cookies"), Vec::new());
    client.set_up(&hub.link()?)?;
    until("the monitor is seen", || Ok(client.get("/health")?["monitors"]["M1"] == "up"))?;
    hub.end()?;
    sim.end()?;
    println!("   {}: version, sim, status, serve and API, emulated", built.arch.name);
    Ok(())
}

/// `lafet serve` as the user of an image. Nothing of our environment is left, so that `chroot` is not searched for.
fn in_image(root: &Path) -> Command {
    let mut serve = Command::new("/usr/sbin/chroot");
    serve.arg("--userspec=10001:10001").arg(root).env_clear().env("STATE_DIRECTORY", STATE);
    serve.args(["/usr/bin/lafet", "serve", "--config", "/etc/lafet/hub.toml"]);
    serve
}

/// The image without an engine: its layers unpacked, its command run in them as its user.
fn of_image(path: &Path, built: &Built) -> StepResult {
    if !is_own(built.arch) {
        return Ok(());
    }
    let root = work("image-root")?;
    image::unpack(path, &root)?;
    output(in_image(&root).arg("--check"))?;
    let serve = ["--no-browser", "--json", "--port", "18481"];
    let mut hub = Running::start(in_image(&root).args(serve))?;
    hub.link()?;
    hub.end()?;
    if !root.join("var/lib/lafet/hub.db").is_file() {
        return Err("the image's user has written no state".into());
    }
    println!("   image of {}: its user serves and writes its state", built.arch.name);
    Ok(())
}

/// A program that runs until it is ended; it is killed if it is not.
pub struct Running {
    child: Child,
    lines: Receiver<String>,
}

impl Running {
    pub fn start(command: &mut Command) -> Result<Self, String> {
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut child = command.spawn().map_err(|e| format!("cannot start {command:?}: {e}"))?;
        let stdout = child.stdout.take().ok_or("a program without output")?;
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Ok(Self { child, lines })
    }

    /// The next line that it prints.
    pub fn line(&mut self) -> Result<String, String> {
        self.lines.recv_timeout(PATIENCE).map_err(|_| "a program printed nothing".to_owned())
    }

    /// The one-time link of a hub, from its first line.
    pub fn link(&mut self) -> Result<String, String> {
        let line = self.line()?;
        link_in(&line).ok_or_else(|| format!("no link in {line}"))
    }

    /// Ends it as systemd does, and waits.
    pub fn end(&mut self) -> StepResult {
        let id = self.child.id().to_string();
        output(Command::new("kill").args(["-TERM", &id]))?;
        self.wait()
    }

    /// Waits until it has ended.
    pub fn wait(&mut self) -> StepResult {
        let limit = Instant::now() + PATIENCE;
        while Instant::now() < limit {
            if let Some(status) = self.child.try_wait().map_err(|e| e.to_string())? {
                let fine = status.success() || status.code() == Some(130);
                return if fine { Ok(()) } else { Err(format!("it ended with {status}")) };
            }
            pause(Duration::from_millis(20));
        }
        Err("it does not end".into())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Lets real processes go on.
#[expect(clippy::disallowed_methods, reason = "other programs live in real time")]
pub fn pause(time: Duration) {
    std::thread::sleep(time);
}

/// Waits until something holds; its last error is the reason why it does not.
pub fn until(what: &str, mut holds: impl FnMut() -> Result<bool, String>) -> StepResult {
    let limit = Instant::now() + PATIENCE;
    let mut last = String::new();
    while Instant::now() < limit {
        match holds() {
            Ok(true) => return Ok(()),
            Ok(false) => {}
            Err(error) => last = error,
        }
        pause(Duration::from_millis(100));
    }
    Err(format!("not within {} s: {what}. {last}", PATIENCE.as_secs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_link_is_found_among_lines_of_the_log() {
        let line =
            r#"{"listening":"http://127.0.0.1:8480","setup":"http://127.0.0.1:8480/setup#a"}"#;
        assert_eq!(link_in(line).as_deref(), Some("http://127.0.0.1:8480/setup#a"));
        for other in ["Started lafet-hub.service", r#"{"setup":null}"#, ""] {
            assert_eq!(link_in(other), None, "{other}");
        }
    }

    #[test]
    fn a_program_that_fails_is_not_taken_for_one_that_was_ended() {
        let mut fails = Command::new("sh");
        fails.args(["-c", "trap 'exit 3' TERM; echo up; while :; do sleep 0.01; done"]);
        let mut running = Running::start(&mut fails).unwrap();
        assert_eq!(running.line().unwrap(), "up");
        assert!(running.end().unwrap_err().contains("3"));
        let mut running = Running::start(Command::new("echo").arg("{}")).unwrap();
        assert!(running.link().unwrap_err().contains("no link"));
    }
}
