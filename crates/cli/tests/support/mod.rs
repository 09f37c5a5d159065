//! Runs the real program, as a user would.
#![allow(dead_code, reason = "each test file uses its part")]

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use serde_json::Value;

/// Longer than anything here takes, so that a hang becomes a failure.
const PATIENCE: Duration = Duration::from_secs(60);
/// The same for a run of the program from its start to its end.
const LIMIT: Duration = Duration::from_secs(600);

/// The program in a clean environment.
pub fn lafet() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lafet"));
    for name in ["LAFET_CONNECT", "LC_ALL", "LC_MESSAGES", "LANG"] {
        command.env_remove(name);
    }
    command.env("XDG_STATE_HOME", state());
    command
}

/// The state of the programs that this process starts: what those of another process have noted of their
/// pseudo-terminals is nothing to them.
fn state() -> &'static Path {
    static STATE: LazyLock<PathBuf> = LazyLock::new(|| {
        let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("state");
        // Those of processes that have ended.
        for old in std::fs::read_dir(&all).into_iter().flatten().flatten() {
            let ended = old.file_name().to_str().is_some_and(|pid| {
                cfg!(target_os = "linux") && !Path::new("/proc").join(pid).exists()
            });
            if ended {
                // Another process may do the same.
                let _ = std::fs::remove_dir_all(old.path());
            }
        }
        let own = all.join(std::process::id().to_string());
        let _ = std::fs::remove_dir_all(&own);
        std::fs::create_dir_all(&own).unwrap();
        own
    });
    &STATE
}

/// Result of a run of the program.
#[derive(Debug)]
pub struct Run {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Run {
    /// Runs the program with these arguments.
    pub fn of(arguments: &[&str]) -> Self {
        Self::of_command(lafet().args(arguments))
    }

    /// Runs this command. One that does not end is ended, and no test waits for it for ever.
    pub fn of_command(command: &mut Command) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().expect("it starts");
        let (id, (ended, ends)) = (child.id().to_string(), channel::<()>());
        std::thread::scope(|scope| {
            scope.spawn(move || {
                if ends.recv_timeout(LIMIT) == Err(RecvTimeoutError::Timeout) {
                    _ = Command::new("kill").args(["-KILL", &id]).status();
                }
            });
            let output = child.wait_with_output();
            drop(ended);
            Self::output(output.expect("it ends"))
        })
    }

    /// Runs the program with bytes on standard input.
    pub fn fed(arguments: &[&str], input: &[u8]) -> Self {
        let mut child = lafet()
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut stdin = child.stdin.take().unwrap();
        // The program writes while it reads, so the output must be read meanwhile.
        std::thread::scope(|scope| {
            scope.spawn(move || stdin.write_all(input).expect("it reads"));
            Self::output(child.wait_with_output().expect("it ends"))
        })
    }

    fn output(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let code = output.status.code().expect("no signal ended it, and not the limit");
        Self { code, out: text(output.stdout), err: text(output.stderr) }
    }

    /// Each output line parsed as JSON.
    pub fn json(&self) -> Vec<Value> {
        let parse = |line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        self.out.lines().map(parse).collect()
    }
}

/// Every command, as the help lists them: `param get`, and `limits` beside `limits teach`.
pub fn commands() -> Vec<String> {
    let mut all = Vec::new();
    let mut groups = vec![String::new()];
    while let Some(group) = groups.pop() {
        let mut words = vec!["--lang", "en"];
        words.extend(group.split_whitespace());
        words.push("--help");
        let help = Run::of(&words).out;
        if !help.contains("<COMMAND>") {
            all.push(group.clone());
        }
        let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        let names = listed.take_while(|line| !line.is_empty());
        let names =
            names.filter_map(|line| line.strip_prefix("  ")).filter(|it| !it.starts_with(' '));
        let name = |line: &str| line.split_whitespace().next().unwrap().to_owned();
        groups.extend(names.map(|line| format!("{group} {}", name(line)).trim().to_owned()));
    }
    assert!(all.len() > 40, "{all:?}");
    all
}

/// A child process whose output is read line by line.
pub struct Running {
    /// The process.
    pub child: Child,
    lines: Receiver<String>,
}

impl Running {
    /// Starts it and reads its standard output.
    pub fn stdout(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let lines = lines(child.stdout.take().unwrap());
        Self { child, lines }
    }

    /// Starts it and reads its standard error.
    pub fn stderr(command: &mut Command) -> Self {
        let mut child =
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
        let lines = lines(child.stderr.take().unwrap());
        Self { child, lines }
    }

    /// The next line of output.
    pub fn line(&self) -> String {
        self.lines.recv_timeout(PATIENCE).expect("another line")
    }

    /// Sends a signal by name.
    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([&format!("-{name}"), &id]).status();
        assert!(sent.expect("kill is there").success());
    }

    /// Waits for the end; returns the exit code.
    pub fn code(&mut self) -> Option<i32> {
        self.child.wait().expect("it ends").code()
    }
}

/// A hub of this configuration, and its address.
pub fn hub(config: &Path) -> (Running, String) {
    let mut command = lafet();
    command.args(["--json", "serve", "--no-browser", "--config"]).arg(config);
    let hub = Running::stdout(&mut command);
    let line: Value = serde_json::from_str(&hub.line()).expect("its address");
    let url = line["listening"].as_str().expect("its address").to_owned();
    (hub, url)
}

/// What is at a place, as curl gets it.
pub fn curl(arguments: &[&str]) -> String {
    let mut curl = Command::new("curl");
    let output = curl.args(["-s", "--max-time", "20"]).args(arguments).output();
    String::from_utf8(output.expect("curl is there").stdout).expect("text")
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn lines(input: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(input).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

/// A pseudo-terminal: our end, which no program that is started has, and the path of the other.
#[cfg(unix)]
fn pty() -> (File, String) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let ours = openpt(flags).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let path = ptsname(&ours, Vec::new()).unwrap().into_string().unwrap();
    (File::from(ours), path)
}

/// A pseudo-terminal of 80 × 24: our end, and the path of the other.
#[cfg(unix)]
pub fn terminal() -> (File, String) {
    use rustix::termios::{Winsize, tcsetwinsize};
    let (ours, path) = pty();
    let size = Winsize { ws_row: 24, ws_col: 80, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(&ours, size).unwrap();
    (ours, path)
}

/// A serial line as a pseudo-terminal: our end, the other end, and its path. While the other end is kept, the
/// line does not hang up between two openings.
#[cfg(unix)]
pub fn serial_line() -> (File, File, String) {
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
    let (ours, path) = pty();
    let kept = File::options().read(true).write(true).open(&path).unwrap();
    let mut settings = tcgetattr(&kept).unwrap();
    settings.make_raw();
    tcsetattr(&kept, OptionalActions::Now, &settings).unwrap();
    (ours, kept, path)
}

/// A simulated monitor in a process of its own.
pub struct Sim {
    /// The process.
    pub running: Running,
    /// URLs for clients, in the order of `--listen`.
    pub urls: Vec<String>,
}

impl Sim {
    /// Starts it on a free TCP port.
    pub fn start(arguments: &[&str]) -> Self {
        Self::listening(&["tcp://127.0.0.1:0"], arguments)
    }

    /// Starts it with these listeners.
    pub fn listening(places: &[&str], arguments: &[&str]) -> Self {
        let mut command = lafet();
        command.arg("sim").args(arguments);
        for place in places {
            command.args(["--listen", place]);
        }
        let running = Running::stdout(&mut command);
        let url = |_: &&str| {
            let line = running.line();
            line.strip_prefix("listening ").unwrap_or_else(|| panic!("{line}")).to_owned()
        };
        let urls = places.iter().map(url).collect();
        Self { running, urls }
    }

    /// The URL of its first listener.
    pub fn url(&self) -> &str {
        &self.urls[0]
    }

    /// The path of its serial port: the first listener is `pty`.
    pub fn port(&self) -> &str {
        let port = self.url().strip_prefix("serial://").expect("a serial port");
        port.split('?').next().unwrap()
    }

    /// Host and port of the first listener.
    pub fn place(&self) -> &str {
        self.url().split_once("://").unwrap().1
    }

    /// Runs a command on it.
    pub fn run(&self, arguments: &[&str]) -> Run {
        let mut all = vec!["-c", self.url()];
        all.extend(arguments);
        Run::of(&all)
    }

    /// Runs a command that has to succeed.
    pub fn done(&self, arguments: &[&str]) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {run:?}");
        run
    }

    /// Runs a command that has to succeed, and parses its only object.
    pub fn value(&self, arguments: &[&str]) -> Value {
        let mut all = vec!["--json"];
        all.extend(arguments);
        let mut values = self.done(&all).json();
        assert_eq!(values.len(), 1, "{arguments:?}");
        values.remove(0)
    }

    /// The flags of a subsystem, by name.
    pub fn flags(&self, subsystem: &str) -> Vec<String> {
        let status = self.value(&["status", subsystem]);
        let flags = status.as_object().unwrap().values().next().unwrap()["flags"].clone();
        serde_json::from_value(flags).unwrap()
    }
}
