//! Every command of docs/tutorial.md and docs/tutorial.ru.md is run, in the order of the page; what it has
//! the reader do in the browser is asked of the hub as the browser asks it. Of docs/overview.md and
//! docs/overview.ru.md those commands are run that need one simulated monitor and no terminal.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::support::{Run, Running, lafet};

const EN: &str = include_str!("../../../../docs/tutorial.md");
const RU: &str = include_str!("../../../../docs/tutorial.ru.md");
/// The pages whose commands to install are the same.
const INSTALL: [&str; 4] = [
    include_str!("../../../../README.md"),
    include_str!("../../../../README.ru.md"),
    OVERVIEW[0],
    OVERVIEW[1],
];
const OVERVIEW: [&str; 2] =
    [include_str!("../../../../docs/overview.md"), include_str!("../../../../docs/overview.ru.md")];
/// What the comment of a command says that the reader leaves running.
const STAYS: [&str; 2] = ["leave it running", "оставьте работать"];
const MONITOR: &str = "127.0.0.1:10485";
const HUB: &str = "127.0.0.1:8480";
/// The simulated monitor is quicker here than the reader's.
const SPEED: &str = " --speed 4";
const PASSWORD: &str = "green-otter-41-harbour";
/// Longer than anything takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

/// A block of code: its language and lines.
type Block<'a> = (&'a str, Vec<&'a str>);

fn blocks(page: &str) -> Vec<Block<'_>> {
    let mut found = Vec::new();
    let mut open: Option<Block<'_>> = None;
    for line in page.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => found.extend(open.take()),
            (Some(language), None) => open = Some((language, Vec::new())),
            (None, Some((_, lines))) => lines.push(line),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    found
}

/// A line without its comment.
fn bare(line: &str) -> &str {
    line.split(" #").next().unwrap_or(line).trim()
}

/// The reader's folder, terminals and browser.
struct Reader {
    folder: PathBuf,
    monitor: String,
    hub: String,
    exported: BTreeMap<String, String>,
    running: Vec<Running>,
    run: usize,
}

impl Reader {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("tutorial-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let free = || TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        let (monitor, hub) = (free(), free());
        let (exported, running) = (BTreeMap::new(), Vec::new());
        Self { folder, monitor, hub, exported, running, run: 0 }
    }

    /// The text with ports that no other test has.
    fn here(&self, text: &str) -> String {
        text.replace(MONITOR, &self.monitor).replace(HUB, &self.hub)
    }

    fn command(&self, line: &str) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_lafet"));
        let path = std::env::var("PATH").unwrap();
        let bin = program.parent().unwrap().display();
        // The environment of the tests, without the reader's own settings.
        let clean = lafet();
        let mut command = Command::new("sh");
        for (name, value) in clean.get_envs() {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        command.args(["-c", line]).current_dir(&self.folder).envs(&self.exported);
        command.env("PATH", format!("{bin}:{path}"));
        command
    }

    /// One line of a block, as the reader types it.
    fn type_in(&mut self, line: &str) {
        let line = self.here(line);
        self.run += 1;
        if let Some((name, value)) = line.strip_prefix("export ").and_then(|it| it.split_once('='))
        {
            self.exported.insert(name.to_owned(), bare(value).to_owned());
        } else if STAYS.iter().any(|mark| line.ends_with(mark)) {
            let kept = bare(&line);
            let speed = if kept.starts_with("lafet sim") { SPEED } else { "" };
            self.running.push(Running::stdout(&mut self.command(&format!("exec {kept}{speed}"))));
            self.wait_until_open(kept.starts_with("lafet sim"));
        } else {
            let run = Run::of_command(&mut self.command(&line));
            assert_eq!(run.code, 0, "{line}: {run:?}");
            assert!(!run.out.is_empty() || !run.err.is_empty(), "{line} prints nothing");
        }
    }

    fn wait_until_open(&self, simulator: bool) {
        let place = if simulator { &self.monitor } else { &self.hub };
        let end = Instant::now() + PATIENCE;
        while TcpStream::connect(place).is_err() {
            assert!(Instant::now() < end, "{place} does not listen");
            std::thread::park_timeout(Duration::from_millis(20));
        }
    }

    /// The one-time token of the link that the hub has printed.
    fn token(&self) -> String {
        let hub = self.running.last().unwrap();
        loop {
            let line = hub.line();
            if let Some((address, token)) = line.trim().split_once("/setup#") {
                assert_eq!(address, format!("http://{}", self.hub));
                return token.to_owned();
            }
        }
    }
}

/// The browser: its cookie and its CSRF token.
struct Browser {
    place: String,
    cookies: String,
    csrf: String,
}

impl Browser {
    /// Opens the link and creates the first administrator.
    fn set_up(place: &str, token: &str) -> Self {
        let mut browser =
            Self { place: place.to_owned(), cookies: String::new(), csrf: String::new() };
        let body = json!({ "token": token, "user": "anna", "password": PASSWORD });
        let (head, session) = browser.ask("POST", "/api/setup", &body);
        assert_eq!(session["role"], "administrator", "{head}");
        let set = head.lines().filter_map(|line| {
            let (name, value) = line.split_once(": ")?;
            name.eq_ignore_ascii_case("set-cookie").then(|| value.split(';').next())?
        });
        browser.cookies = set.collect::<Vec<_>>().join("; ");
        browser.csrf = session["csrf"].as_str().unwrap().to_owned();
        browser
    }

    fn ask(&self, method: &str, path: &str, body: &Value) -> (String, Value) {
        let body = if body.is_null() { String::new() } else { body.to_string() };
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nCookie: {}\r\n\
             X-CSRF-Token: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.place,
            self.cookies,
            self.csrf,
            body.len()
        );
        let mut stream = TcpStream::connect(&self.place).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, rest) = answer.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 200"), "{method} {path}: {answer}");
        // A body in chunks has the length of each on a line before it.
        let json = rest.lines().find(|line| line.starts_with(['{', '['])).unwrap_or("null");
        (head.to_owned(), serde_json::from_str(json).unwrap())
    }

    fn request(&self, text: &str) -> Value {
        self.ask("POST", "/api/monitors/M1/requests", &json!({ "request": text })).1
    }

    fn status(&self) -> Value {
        self.ask("GET", "/api/monitors/M1", &Value::Null).1
    }

    /// Whether a subsystem of the monitor has this flag.
    fn has(&self, subsystem: &str, flag: &str) -> bool {
        let status = self.status();
        let flags = &status["status"]["subsystems"][subsystem]["flags"];
        flags.as_array().unwrap_or_else(|| panic!("{status}")).iter().any(|it| it == flag)
    }

    fn wait(&self, what: &str, so: impl Fn(&Self) -> bool) {
        let end = Instant::now() + PATIENCE;
        while !so(self) {
            assert!(Instant::now() < end, "not within {PATIENCE:?}: {what}");
            std::thread::park_timeout(Duration::from_millis(200));
            // The control of a client over HTTP lapses without a command for 10 s; a page has a WebSocket.
            self.take_control();
        }
    }

    fn take_control(&self) {
        let take = json!({ "action": "take" });
        let authority = self.ask("POST", "/api/monitors/M1/authority", &take).1;
        assert_eq!(authority["state"], "held", "{authority}");
    }

    /// What the page has the reader do under "The console".
    fn extinguish(&self) {
        let authority =
            self.ask("POST", "/api/monitors/M1/authority", &json!({ "action": "take" }));
        assert_eq!(authority.1["state"], "held");
        self.request("Deploy Deployer");
        self.wait("deployed", |it| it.has("Deployer", "Deployed"));
        self.request("StartSeek Detector 0 3600 -600 600 analyse");
        // An earlier search has found the fire too: this one has to start first.
        self.wait("searching", |it| it.has("Detector", "Searching"));
        self.wait("found", |it| it.has("Detector", "Found") && !it.has("Detector", "Searching"));
        self.request("Open Valve1");
        self.wait("open", |it| it.has("Valve1", "Open"));
        self.request(
            "StartQuench Control centre=1800,-138 nozzle=60 sector=180,120 step=1 distance=25",
        );
        self.wait("extinguishing", |it| it.has("Control", "Quench"));
    }
}

/// Follows the page to its end; returns how many lines were typed.
fn follow(page: &str, name: &str) -> usize {
    let mut reader = Reader::new(name);
    let mut installed = None;
    let mut extinguished = false;
    for (language, lines) in blocks(page) {
        if language == "toml" {
            let text = reader.here(&lines.join("\n"));
            std::fs::write(reader.folder.join("hub.toml"), text).unwrap();
            continue;
        }
        assert_eq!(language, "sh", "{lines:?}");
        if let [line] = lines[..]
            && line.starts_with("cargo ")
        {
            installed = Some(line);
            continue;
        }
        for line in lines {
            reader.type_in(line);
            if line.starts_with("lafet serve --no-browser") {
                let browser = Browser::set_up(&reader.hub, &reader.token());
                browser.extinguish();
                extinguished = put_out(&reader);
            }
        }
    }
    let installed = installed.expect("the page says how to install");
    assert!(INSTALL.iter().all(|page| page.contains(installed)), "{installed}");
    assert!(extinguished);
    reader.run
}

/// Whether the fire is out: the monitor extinguishes until a search finds nothing.
fn put_out(reader: &Reader) -> bool {
    let lafet = |words: &str| {
        let run = Run::of_command(&mut reader.command(&format!("lafet {words}")));
        assert_eq!(run.code, 0, "{words}: {run:?}");
        run
    };
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        // A quarter of a minute and more, on the simulated clock.
        std::thread::park_timeout(Duration::from_secs(8));
        for words in ["close valve1", "stop control", "seek --from-az 0 --to-az 60"] {
            lafet(words);
        }
        let found = lafet("--json hotbeds").json();
        if found[0]["hotbeds"].as_array().is_some_and(Vec::is_empty) {
            return true;
        }
        lafet("open valve1");
        lafet("quench --centre 30deg,-2.3deg --distance 25 --sector 3deg,2deg --step 1");
    }
    false
}

/// Types those blocks of the overview that are for one simulated monitor; returns how many lines.
fn look_over(page: &str, name: &str) -> usize {
    let mut reader = Reader::new(name);
    let of_one = |block: &Block<'_>| block.1.iter().any(|line| line.contains(MONITOR));
    let mut blocks = blocks(page).into_iter().skip_while(|block| !of_one(block)).map(|it| it.1);
    let (sim, commands) = (blocks.next().unwrap(), blocks.next().unwrap());
    let service = blocks.next().unwrap();
    let by_hand = |line: &str| ["lafet jog", "lafet shell", "lafet top"].contains(&bare(line));
    for line in sim.into_iter().chain(commands).filter(|line| !by_hand(line)) {
        reader.type_in(&line.replace("--for 60", "--for 1"));
    }
    let code = |line: &str| {
        let run = Run::of_command(&mut reader.command(line));
        println!("{line}: {run:?}");
        run.code
    };
    assert_eq!(code("lafet deploy"), 1, "the block locks out");
    let (first, rest) = service.split_first().unwrap();
    assert_eq!(bare(first), "lafet lockout off");
    assert_eq!(code(first), 0);
    assert_eq!(code("lafet deploy"), 0);
    let here = |line: &&&str| line.starts_with("lafet param ");
    let saved: Vec<i32> = rest.iter().filter(here).map(|line| code(line)).collect();
    assert_eq!(saved, [0, 0]);
    reader.run
}

#[test]
fn the_overview_in_english() {
    assert!(look_over(OVERVIEW[0], "overview-en") > 12);
}

#[test]
fn the_overview_in_russian() {
    assert!(look_over(OVERVIEW[1], "overview-ru") > 12);
}

#[test]
fn in_english() {
    assert!(follow(EN, "en") > 15);
}

#[test]
fn in_russian() {
    assert!(follow(RU, "ru") > 15);
}

/// The two pages have the same commands, apart from the language that the Russian one sets.
#[test]
fn both_have_the_same_commands() {
    let plain = |page: &'static str| -> Vec<String> {
        let lines = blocks(page).into_iter().flat_map(|(_, lines)| lines);
        let bare = lines.map(|line| bare(line).to_owned());
        bare.filter(|line| !line.is_empty() && !line.starts_with("export LANG")).collect()
    };
    assert_eq!(plain(EN), plain(RU));
    assert_eq!(plain(OVERVIEW[0]), plain(OVERVIEW[1]));
}
