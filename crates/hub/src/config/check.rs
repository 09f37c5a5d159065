//! What a file may say, and what to do where it says something else.

use std::fmt;
use std::net::SocketAddr;
use std::path::Path;

use lafet_client::Lang;
use lafet_texts::{Shown, Text as _, hub as text};
use toml::Spanned;

use super::file::{File, Recording, Tls};
use super::{Config, LISTEN, Overrides, RecordingConfig, TlsConfig};
use crate::field::line::{self, Line};
use crate::store::Address;
use crate::text::Both;

/// Longest name.
const NAME_MAX: usize = 32;

/// What is wrong with the configuration: where, what, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// `hub.toml:12`, or the name of a variable or flag.
    pub place: String,
    /// What is wrong.
    pub what: Both,
    /// What to do.
    pub remedy: Both,
}

impl Problem {
    /// At a byte of the file's text.
    pub fn at(file: &str, text: &str, byte: usize, what: Both, remedy: Both) -> Self {
        let before = text.get(..byte).unwrap_or(text);
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        Self { place: format!("{file}:{line}"), what, remedy }
    }

    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        format!("{}: {} {}", self.place, self.what.of(lang), self.remedy.of(lang))
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.localized(Lang::En))
    }
}

/// Collects problems while it reads.
pub struct Check<'a> {
    file: &'a str,
    pub(super) text: &'a str,
    pub(super) folder: &'a Path,
    problems: Vec<Problem>,
    warnings: Vec<Problem>,
}

/// Makes a configuration of a file.
pub fn check(
    file: &str,
    text: &str,
    read: File,
    folder: &Path,
    overrides: &Overrides,
) -> Result<Config, Vec<Problem>> {
    let mut check = Check { file, text, folder, problems: Vec::new(), warnings: Vec::new() };
    let listen = check.listen(&read, overrides);
    let login = *read.server.login.get_ref();
    check.exposure(&read, listen);
    let zones = check.zones(&read);
    let modbus = check.modbus(&read);
    let modbus_servers = check.modbus_servers(&read);
    let mqtt = check.mqtt(&read);
    let opcua = check.opcua(&read);
    check.range(&read.server.connections_max, 8..=65_536, "connections_max");
    check.range(&read.authority.lost_ms, 500..=60_000, "lost_ms");
    let postgres = check.postgres(&read.history);
    check.range(&read.history.raw_days, 1..=3650, "raw_days");
    check.range(&read.history.minute_days, 1..=36_500, "minute_days");
    check.range(&read.recording.before_s, 0..=300, "before_s");
    check.range(&read.recording.after_s, 1..=3600, "after_s");
    check.range(&read.recording.keep_days, 1..=3650, "keep_days");
    check.range(&read.recording.keep_mb, 1..=10_000_000, "keep_mb");
    let site = check.site(&read);
    let plan = check.plan(&read);
    let tls = read.tls.map(|tls| check.tls(tls.span().start, tls.into_inner()));
    let monitors = check.monitors(&read.monitor);
    let names = check.names(read.server.names);
    let origins = check.origins(read.server.origins);
    let data = overrides.data.clone().or(read.server.data).map(|path| folder.join(path));
    let data = data.or_else(|| overrides.state.clone());
    let data = data.unwrap_or_else(|| folder.join("lafet-data"));
    let recording = recording(read.recording, folder, &data);
    let opcua = opcua.into_iter().map(|it| it.in_folder(&data)).collect();
    let config = Config {
        proven: lafet_client::update::PROVEN,
        listen,
        names,
        origins,
        proxies: read.server.proxies,
        login,
        data: Some(data),
        accept_lost: Vec::new(),
        recording,
        connections_max: read.server.connections_max.into_inner(),
        tls,
        metrics_open: read.metrics.open,
        lost_ms: read.authority.lost_ms.into_inner(),
        postgres,
        raw_days: read.history.raw_days.into_inner(),
        minute_days: read.history.minute_days.into_inner(),
        site,
        plan,
        zones,
        modbus,
        modbus_servers,
        mqtt,
        opcua,
        monitors,
        warnings: check.warnings.clone(),
        simulation: read.server.simulation,
        demo: false,
    };
    if check.problems.is_empty() { Ok(config) } else { Err(check.problems) }
}

/// Whether it can be the name of a monitor, a bus or a server.
pub fn is_name(text: &str) -> bool {
    let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !text.is_empty() && text.len() <= NAME_MAX && text.chars().all(fine)
}

fn recording(read: Recording, folder: &Path, data: &Path) -> RecordingConfig {
    RecordingConfig {
        folder: Some(match read.folder {
            Some(path) => folder.join(path),
            None => data.join("recordings"),
        }),
        alarms: read.alarms,
        before_s: read.before_s.into_inner(),
        after_s: read.after_s.into_inner(),
        keep_days: read.keep_days.into_inner(),
        keep_mb: read.keep_mb.into_inner(),
    }
}

impl Check<'_> {
    /// What can be reached from other machines needs a login, and TLS.
    fn exposure(&mut self, read: &File, listen: SocketAddr) {
        if !*read.server.login.get_ref() && !listen.ip().is_loopback() {
            self.say(
                read.server.login.span().start,
                text::CheckOpenWithoutLogin { listen: Shown(listen) }.words(),
                text::CheckOpenWithoutLoginRemedy.words(),
            );
        }
        if read.tls.is_none() && !listen.ip().is_loopback() && !read.server.plain_http {
            let at = read.server.listen.as_ref().map_or(0, |listen| listen.span().start);
            self.say(
                at,
                text::CheckPlainPasswords { listen: Shown(listen) }.words(),
                text::CheckPlainPasswordsRemedy.words(),
            );
        }
    }

    /// A file with a secret that every user of this machine can read.
    pub fn secret(&mut self, byte: usize, path: &Path) {
        if !is_open(path) {
            return;
        }
        let name = path.display();
        let what = text::CheckFileReadable { name: Shown(&name) }.words();
        self.warn(byte, what, Both::same(format!("chmod o= {name}")));
    }

    /// The line of a URL.
    pub fn line(&mut self, url: &Spanned<String>) -> Option<Line> {
        let parsed = Line::parse(url.get_ref());
        parsed.map_err(|what| self.say(url.span().start, what, line::remedy())).ok()
    }

    pub fn file_name(&self) -> &Path {
        Path::new(Path::new(self.file).file_name().unwrap_or_default())
    }

    /// Something at a byte of the file does not do what it seems to.
    pub fn warn(&mut self, byte: usize, what: Both, remedy: Both) {
        self.warnings.push(Problem::at(self.file, self.text, byte, what, remedy));
    }

    /// Something is wrong at a byte of the file.
    pub fn say(&mut self, byte: usize, what: Both, remedy: Both) {
        self.problems.push(Problem::at(self.file, self.text, byte, what, remedy));
    }

    fn listen(&mut self, read: &File, overrides: &Overrides) -> SocketAddr {
        let written = read.server.listen.as_ref();
        let (text, place) = match (&overrides.listen, written) {
            (Some(text), _) => (text.clone(), None),
            (None, Some(text)) => (text.get_ref().clone(), Some(text.span().start)),
            (None, None) => (LISTEN.to_owned(), None),
        };
        let port = |mut listen: SocketAddr| {
            listen.set_port(overrides.port.unwrap_or(listen.port()));
            listen
        };
        match text.parse::<SocketAddr>() {
            Ok(listen) => port(listen),
            Err(_) => {
                let what = text::CheckListen { text }.words();
                let remedy = text::CheckListenRemedy.words();
                match place {
                    Some(byte) => self.say(byte, what, remedy),
                    None => {
                        self.problems.push(Problem { place: super::ENV[1].into(), what, remedy })
                    }
                }
                port(SocketAddr::from(([127, 0, 0, 1], 8480)))
            }
        }
    }

    fn postgres(&mut self, history: &super::file::History) -> Option<Address> {
        let url = history.url.as_ref()?;
        let (at, own) = (url.span().start, self.folder.join(self.file_name()));
        if url.get_ref().split('@').next().is_some_and(|it| it.matches(':').count() > 1) {
            self.secret(at, &own);
        }
        if let Some((_, key)) = url.get_ref().split_once("sslkey=") {
            let key = key.split('&').next().unwrap_or_default();
            self.secret(at, &self.folder.join(key));
        }
        let address = Address::parse(url.get_ref(), self.folder);
        let used = address.and_then(|address| match address.connector() {
            Ok(_) => Ok(address),
            Err(what) => Err((what, text::CheckPemFilesRemedy.words())),
        });
        match used {
            Ok(address) => Some(address),
            Err((what, remedy)) => {
                self.say(url.span().start, what, remedy);
                None
            }
        }
    }

    pub fn range<T: PartialOrd + Copy + fmt::Display>(
        &mut self,
        value: &toml::Spanned<T>,
        range: std::ops::RangeInclusive<T>,
        name: &str,
    ) {
        if !range.contains(value.get_ref()) {
            let (value, from, to, at) =
                (value.get_ref(), range.start(), range.end(), value.span().start);
            self.say(
                at,
                text::CheckOutOfRange { name, value: Shown(value) }.words(),
                text::CheckOutOfRangeRemedy { from: Shown(from), to: Shown(to) }.words(),
            );
        }
    }

    fn tls(&mut self, byte: usize, tls: Tls) -> TlsConfig {
        if tls.client_ca.is_none() && !tls.client_roles.is_empty() {
            self.say(byte, text::CheckClientRoles.words(), text::CheckClientRolesRemedy.words());
        }
        let config = TlsConfig {
            cert: self.folder.join(tls.cert),
            key: self.folder.join(tls.key),
            client_ca: tls.client_ca.map(|path| self.folder.join(path)),
            client_roles: tls.client_roles,
        };
        self.secret(byte, &config.key);
        for what in crate::server::tls::problems(&config) {
            self.say(byte, what, text::CheckPemRemedy.words());
        }
        config
    }
}

/// Whether every user of this machine can read a file.
#[cfg(unix)]
fn is_open(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    std::fs::metadata(path).is_ok_and(|it| it.permissions().mode() & 0o004 != 0)
}

/// Other systems have other means.
#[cfg(not(unix))]
fn is_open(_: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::config::monitors::POLL_SERIAL_MS;

    fn parse(text: &str) -> Result<Config, Vec<String>> {
        let overrides = Overrides::default();
        Config::parse("hub.toml", text, Path::new("/etc/lafet"), &overrides)
            .map_err(|problems| problems.iter().map(ToString::to_string).collect())
    }

    /// A map may be larger than what the planner computes with.
    #[test]
    fn what_the_planner_cannot_compute_with_is_warned_of() {
        let monitor = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\nheight = 2\n";
        let detector = "[[detector]]\nid = \"d\"\nkind = \"flame\"\nzones = [\"z\"]\n";
        let zone = "[[aim]]\nzone = \"z\"\nmonitor = \"M1\"\nhorizontal = 0\nvertical = 300\n\
                    nozzle = 60\n[[zone]]\nid = \"z\"\nvotes = \"1oo1\"\nwater_max_s = 60\n\
                    one_detector_releases = true\nmonitors = [\"M1\"]\n";
        let warnings = |east: u32, sees: &str, wall: f64| {
            let wall =
                format!("[[wall]]\nname = \"w\"\nfrom = [0, 9]\nto = [{wall}, 9]\nheight = 3\n");
            let at = format!("at = [{east}, 0]\n");
            let text = format!("{monitor}{at}{detector}{sees}{zone}{wall}");
            parse(&text).unwrap_or_else(|problems| panic!("{problems:#?}")).warnings.len()
        };
        let sees = "at = [0, 0, 6]\n";
        assert_eq!(warnings(0, sees, 20.0), 0);
        assert_eq!(warnings(20_000, sees, 20.0), 1);
        assert_eq!(warnings(20_000, sees, 5000.0), 2);
        assert_eq!(warnings(20_000, "", 5000.0), 0, "nothing is planned");
    }

    #[test]
    fn water_winds_and_what_is_protected() {
        let read = |text: &str| parse(&format!("{MONITOR}{text}"));
        let plan = read(
            "[supply]\nstatic = 1.0\nflow = 2400\npressure = 0.8\nflowing = 2\n\
             [[wind]]\nfrom = 270\nspeed = 6\n[coverage]\ncorner = [0, 0]\nsize = [50, 40]\n",
        )
        .unwrap()
        .plan;
        assert!((plan.supply.unwrap().pressure_mpa(2400.0) - 0.8).abs() < 2e-3);
        assert_eq!((plan.flowing, plan.winds.len(), plan.area.unwrap().cell), (Some(2), 1, 1.0));
        for (text, what) in [
            ("[supply]\npressure = 0.8\nflow = 100\n", "[supply]"),
            ("[supply]\npressure = 9\n", "2.5"),
            ("[supply]\npressure = 0.8\nflowing = 65\n", "flowing"),
            ("[[wind]]\nfrom = 270\nspeed = 60\n", "40"),
            ("[coverage]\ncorner = [0, 0]\nsize = [5000, 5000]\n", "25000000 cells"),
        ] {
            let problems = read(text).unwrap_err();
            assert!(problems.len() == 1 && problems[0].contains(what), "{text} {problems:?}");
        }
        let many = "[[wind]]\nfrom = 270\nspeed = 6\n".repeat(17);
        assert!(read(&many).unwrap_err()[0].contains("16"));
    }

    const MONITOR: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\nat = [1, 2]\n";

    #[test]
    fn a_whole_file() {
        let config = parse(
            "[server]\nlisten = \"[::1]:9000\"\ndata = \"state\"\n[metrics]\nopen = true\n\
             [[monitor]]\nid = \"M1\"\nurl = \"serial:///dev/ttyS0?addr=3\"\nat = [1, 2]\n\
             name = { en = \"West\", ru = \"Запад\" }\n\
             [[monitor]]\nid = \"M2\"\nurl = \"tcp://10.0.0.2?addr=1\"\npoll_ms = 50\n\
             [[tank]]\nname = \"T\"\nat = [0, 0]\ndiameter = 10\nheight = 6\n",
        )
        .unwrap();
        assert_eq!(config.listen.to_string(), "[::1]:9000");
        assert_eq!(config.data.as_deref(), Some(Path::new("/etc/lafet/state")));
        assert!(config.metrics_open && config.login);
        let [first, second] = &config.monitors[..] else { panic!("{config:?}") };
        assert_eq!((first.poll_ms, second.poll_ms), (POLL_SERIAL_MS, 50));
        assert_eq!((first.name.ru.as_str(), second.name.ru.as_str()), ("Запад", "M2"));
        let site = config.site.unwrap();
        assert_eq!(site.monitors["M1"].at, [1.0, 2.0]);
        assert!(!site.monitors.contains_key("M2"));
        assert_eq!(site.tanks[0].diameter, 10.0);
    }

    #[test]
    fn keep_outs_count_where_they_are_written_for() {
        let monitor = |id: &str, keys: &str| {
            format!("[[monitor]]\nid = \"{id}\"\nurl = \"tcp://{id}?addr=1\"\n{keys}\n")
        };
        let placed = monitor("M1", "at = [0, 0]\nheading = 90");
        let sector = |keys: &str| {
            format!(
                "[[keep_out]]\nname = \"stand\"\nfor = \"people\"\nbearings = [350, 10]\n{keys}\n"
            )
        };
        let site = parse(&[placed.clone(), sector("monitor = \"M1\"")].concat()).unwrap().site;
        let [stand] = &site.unwrap().keep_outs[..] else { panic!("one") };
        assert_eq!((stand.elevations, stand.monitor.as_deref()), ([-90.0, 90.0], Some("M1")));
        let aimed = "[[detector]]\nid = \"a\"\nkind = \"flame\"\nzones = [\"hall\"]\n\
                     [[detector]]\nid = \"b\"\nkind = \"heat\"\nzones = [\"hall\"]\n\
                     [[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [\"M1\"]\n\
                     [[aim]]\nzone = \"hall\"\nmonitor = \"M1\"\nhorizontal = 5400\nvertical = 300\nnozzle = 60\n";
        for (rest, told) in [
            (sector("monitor = \"M9\""), "is for monitor M9, which is not configured"),
            (sector("elevations = [20, 10]"), "is no sector"),
            (sector("elevations = [nan, 10]"), "is no sector"),
            (sector("") + &sector(""), "cannot be used"),
            (sector("") + &monitor("M2", ""), "counts for M2, which has no place"),
            (sector("") + aimed, "M1 aims at zone hall where keep-out “stand” is"),
            (
                (0..65).map(|n| sector("").replace("stand", &format!("s{n}"))).collect(),
                "more than 64",
            ),
        ] {
            let problems = parse(&(placed.clone() + &rest)).unwrap_err();
            assert!(problems.len() == 1 && problems[0].contains(told), "{told}: {problems:#?}");
        }
    }

    #[test]
    fn the_examples_are_right_and_so_is_what_they_leave_out() {
        let english = include_str!("../../hub.example.toml");
        let russian = include_str!("../../hub.example.ru.toml");
        for text in [english, russian] {
            assert_eq!(parse(text).unwrap().monitors.len(), 2);
            let setting = |line: &str| line.contains(" = ") || line.starts_with('[');
            let all: Vec<&str> = text
                .lines()
                .map(|line| line.strip_prefix("# ").filter(|it| setting(it)).unwrap_or(line))
                .collect();
            let (file, _, problems) = File::read("hub.toml", &all.join("\n"));
            assert_eq!(problems, []);
            assert!(file.tls.is_some() && file.metrics.open && file.history.url.is_some());
        }
        let bare = |text: &str| -> Vec<String> {
            let value = |line: &str| line.split(" #").next().unwrap_or_default().trim().to_owned();
            text.lines().filter(|line| line.contains(" = ")).map(value).collect()
        };
        assert_eq!(bare(english), bare(russian));
    }

    #[test]
    fn everything_wrong_is_told_with_its_line_and_a_remedy() {
        let problems = parse(
            "[server]\nlisten = \"0.0.0.0:1\"\nlogin = false\n[authority]\nlost_ms = 1\n\
             [[monitor]]\nid = \"M 1\"\nurl = \"tcp://h?addr=200\"\n\
             [[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\npoll_ms = 1\n\
             [[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\n\
             [[monitor]]\nid = \"S\"\nurl = \"sim:\"\n[tls]\ncert = \"no\"\nkey = \"no\"\n",
        )
        .unwrap_err();
        let expected = [
            ("hub.toml:3: ", "listen on 127.0.0.1"),
            ("hub.toml:5: ", "500…60000"),
            ("hub.toml:19: ", "PEM file"),
            ("hub.toml:19: ", "/etc/lafet/no: cannot be read"),
            ("hub.toml:7: ", "`M 1` is not an id"),
            ("hub.toml:8: ", "tcp://HOST"),
            ("hub.toml:12: ", "20…10000"),
            ("hub.toml:14: ", "is given twice"),
            ("hub.toml:15: ", "?addr=2"),
            ("hub.toml:18: ", "lafet sim"),
        ];
        for (place, words) in expected {
            let found = problems.iter().any(|it| it.starts_with(place) && it.contains(words));
            assert!(found, "{place} {words}: {problems:#?}");
        }
        assert_eq!(problems.len(), expected.len(), "{problems:#?}");
    }

    #[test]
    fn other_machines_need_tls_or_an_express_wish() {
        let monitor = "[[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\n";
        let open = "[server]\nlisten = \"0.0.0.0:80\"\n";
        let problems = parse(&format!("{open}{monitor}")).unwrap_err();
        assert!(problems[0].contains("in the clear"), "{problems:?}");
        assert!(parse(&format!("{open}plain_http = true\n{monitor}")).is_ok());
    }

    #[test]
    fn unknown_words_and_an_empty_file_are_problems() {
        let problems = parse("[server]\nlissen = \"x\"\n").unwrap_err();
        assert!(
            problems[0].starts_with("hub.toml:2: `lissen` is not known here; what is: `listen`"),
            "{problems:?}"
        );
        assert!(parse("").unwrap_err()[0].contains("There is no monitor"));
    }

    #[test]
    fn readers_of_toml_are_understood_in_both_languages() {
        let said = |text: &str| {
            let read = Config::parse("f", text, Path::new("/"), &Overrides::default());
            read.unwrap_err().remove(0).what
        };
        for (text, en, ru) in [
            ("[server]\nlisten = 8480", "the number `8480` where a text", "Указано: число `8480`"),
            (
                "[history]\nraw_days = -1",
                "a whole number from 0 is needed",
                "нужно: целое число от 0",
            ),
            ("[[monitor]]\nid = \"A\"", "`url` is missing", "Не хватает `url`"),
            ("[server]\nlogin = true\nlogin = true", "is given twice", "указано дважды"),
            (
                "[tls]\ncert = \"c\"\nkey = \"k\"\nclient_roles = { a = \"boss\" }",
                "`boss` is not one of `observer`, `operator`",
                "`boss` здесь недопустимо; возможно: `observer`",
            ),
            ("monitor = 1", "where a list", "нужно: список"),
            ("[server", "TOML: unclosed table", "TOML: заголовок не закрыт; нужно: `]`."),
            ("[[monitor]", "TOML: ", "TOML: заголовок не закрыт"),
            ("listen", "TOML: ", "TOML: ключ без значения; нужно: `=`."),
            ("listen = here", "TOML: ", "TOML: текст пишут в кавычках"),
            ("names = [\"a\" \"b\"]", "TOML: ", "TOML: нет запятой в списке"),
            ("names = [\"a\"", "TOML: ", "TOML: список не закрыт"),
            ("[tls]\nclient_roles = { a = 1", "TOML: ", "TOML: фигурная скобка не закрыта"),
            (
                "[[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=1\"\nname = { en = \"x\" }",
                "{ en = \"…\", ru = \"…\" }",
                "{ en = \"…\", ru = \"…\" }",
            ),
        ] {
            let what = said(text);
            assert!(what.en.contains(en) && what.ru.contains(ru), "{text}: {what:?}");
        }
    }

    #[test]
    fn names_origins_places_and_certificates_are_looked_at() {
        let problems = parse(
            "[server]\nnames = [\"http://a\"]\norigins = [\"*\", \"https://b/x\", \"https://B:1\"]\n\
             [tls]\ncert = \"hub.toml\"\nkey = \"hub.toml\"\n\
             [[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\nat = [nan, 0]\n\
             [[tank]]\nname = \"T\"\nat = [0, 0]\ndiameter = -1\nheight = 6\n\
             [[wall]]\nname = \"W\"\nfrom = [0, 0]\nto = [inf, 0]\nheight = 6\n",
        )
        .unwrap_err();
        let at = |line: &str| problems.iter().filter(|it| it.starts_with(line)).count();
        let found = ["hub.toml:2:", "hub.toml:3:", "hub.toml:4:", "hub.toml:7:"].map(at);
        assert_eq!(found, [1, 2, 2, 1], "{problems:#?}");
        assert_eq!((at("hub.toml:11:"), at("hub.toml:16:"), problems.len()), (1, 1, 8));
        let fine = "[server]\norigins = [\"https://B:1\"]\n\
                    [[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\n";
        assert_eq!(parse(fine).unwrap().origins, ["https://b:1"]);
    }

    #[test]
    fn environment_and_flags_win() {
        let text = "[[monitor]]\nid = \"A\"\nurl = \"tcp://h?addr=2\"\n";
        let environment = |name: &str| match name {
            "LAFET_HUB_LISTEN" => Some("127.0.0.1:1".to_owned()),
            "LAFET_HUB_DATA" => Some("/d".to_owned()),
            "STATE_DIRECTORY" => Some("/s".to_owned()),
            _ => None,
        };
        let overrides = Overrides { port: Some(0), ..Overrides::of_environment(environment) };
        let config = Config::parse("f", text, Path::new("/"), &overrides).unwrap();
        assert_eq!(config.listen.to_string(), "127.0.0.1:0");
        assert_eq!(config.data.as_deref(), Some(Path::new("/d")));
        // What systemd has made is used where nothing else is named: the file is not overruled by the unit.
        let overrides = Overrides { data: None, ..overrides };
        let data = |text: &str| Config::parse("f", text, Path::new("/"), &overrides).unwrap().data;
        assert_eq!(data(text).as_deref(), Some(Path::new("/s")));
        let own = format!("[server]\ndata = \"/own\"\n{text}");
        assert_eq!(data(&own).as_deref(), Some(Path::new("/own")));
        let overrides = Overrides { listen: Some("here".into()), ..Overrides::default() };
        let problems = Config::parse("f", text, Path::new("/"), &overrides).unwrap_err();
        assert_eq!(problems[0].place, "LAFET_HUB_LISTEN");
    }

    #[test]
    fn everything_that_is_wrong_is_said_at_once() {
        let text = "[server]\nlisen = \"127.0.0.1:1\"\nplain_http = 3\nconnections_max = 1\n\
                    [history]\nraw_days = \"x\"\nminute_day = 3\n[[monitor]]\nid = \"M1\"\n\
                    [[monitor]]\nid = \"a b\"\nurl = \"nonsense\"\npol_ms = 5\n[metrcs]\n";
        let told = parse(text).unwrap_err();
        let at = |line: u32, word: &str| {
            let place = format!("hub.toml:{line}: ");
            told.iter().any(|it| it.starts_with(&place) && it.contains(word))
        };
        for (line, word) in [
            (2, "Did you mean listen?"),
            (3, "true or false"),
            (4, "connections_max"),
            (6, "raw_days"),
            (7, "Did you mean minute_days?"),
            (8, "url"),
            (11, "a b"),
            (12, "nonsense"),
            (13, "Did you mean poll_ms?"),
            (14, "Did you mean metrics?"),
        ] {
            let word = if word == "raw_days" { "whole number" } else { word };
            assert!(at(line, word), "{line} {word}: {told:#?}");
        }
        assert_eq!(told.len(), 10, "{told:#?}");
    }

    #[cfg(unix)]
    #[test]
    fn a_key_that_everybody_can_read_is_warned_of() {
        use std::os::unix::fs::PermissionsExt;
        let folder = std::env::temp_dir().join(format!("lafet-key-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let made = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        std::fs::write(folder.join("hub.pem"), made.cert.pem()).unwrap();
        let key = folder.join("hub.key");
        std::fs::write(&key, made.signing_key.serialize_pem()).unwrap();
        let text = format!("{MONITOR}[tls]\ncert = \"hub.pem\"\nkey = \"hub.key\"\n");
        for (mode, open) in [(0o644, true), (0o640, false), (0o600, false)] {
            std::fs::set_permissions(&key, std::fs::Permissions::from_mode(mode)).unwrap();
            assert_eq!(is_open(&key), open, "{mode:o}");
            let warnings =
                Config::parse("hub.toml", &text, &folder, &Overrides::default()).unwrap().warnings;
            let remedies: Vec<&str> = warnings.iter().map(|it| it.remedy.of(Lang::En)).collect();
            let remedy = format!("chmod o= {}", key.display());
            let expected = if open { vec![remedy.as_str()] } else { Vec::new() };
            assert_eq!(remedies, expected, "{mode:o}: {warnings:#?}");
        }
        std::fs::remove_dir_all(folder).unwrap();
        assert!(!is_open(Path::new("/nothing/of/this/name")));
    }
}
