//! What a file may say of brokers.

use std::path::{Path, PathBuf};

use crate::config::{Config, Overrides, Problem};

const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://10.0.0.1?addr=1\"\n\
    [[monitor]]\nid = \"M2\"\nurl = \"tcp://10.0.0.2:10001?addr=1\"\n";
/// The line of `[[mqtt]]`.
const FIRST: u32 = 7;
const LOCAL: &str = "name = \"site\"\nurl = \"mqtt://127.0.0.1\"\n";

fn parse_in(folder: &Path, broker: &str) -> Result<Config, Vec<Problem>> {
    let text = format!("{SITE}[[mqtt]]\n{broker}");
    Config::parse("hub.toml", &text, folder, &Overrides::default())
}

fn parse(broker: &str) -> Result<Config, Vec<Problem>> {
    parse_in(Path::new("/"), broker)
}

#[test]
fn a_broker_is_read_and_what_it_leaves_out_is_safe() {
    let config = parse(LOCAL).unwrap();
    let [broker] = &config.mqtt[..] else { panic!("{:?}", config.mqtt) };
    assert_eq!((broker.host.as_str(), broker.port), ("127.0.0.1", 1883));
    assert_eq!((broker.client_id.as_str(), broker.prefix.as_str()), ("lafet-site", "lafet"));
    assert_eq!(broker.monitors, ["M1", "M2"]);
    assert_eq!((broker.interval.as_millis(), broker.terms.alive.as_millis()), (1000, 3000));
    assert!(broker.terms.closes && !broker.terms.operates && broker.homeassistant.is_none());
    assert!(broker.tls.is_none() && broker.login.is_none() && config.warnings.is_empty());
    assert!(Config::default().mqtt.is_empty(), "without [[mqtt]] there is none");
    let all = "name = \"b\"\nurl = \"mqtt://[::1]:1884/\"\nuser = \"u\"\npassword = \"geheim\"\n\
        client_id = \"hub-1\"\nprefix = \"plant/fire\"\nmonitors = [\"M2\"]\nrole = \"operator\"\n\
        interval_ms = 250\nalive_ms = 60000\nclose_when_lost = false\nhomeassistant = \"ha\"\n";
    let config = parse(all).unwrap();
    let broker = &config.mqtt[0];
    assert_eq!(broker.url(), "mqtt://[::1]:1884");
    assert_eq!(broker.topic_of(Some(0), "state"), "plant/fire/M2/state");
    assert!(broker.terms.operates && !broker.terms.closes);
    assert!(!format!("{config:?}").contains("geheim"), "no log has the password");
    let plain = "name = \"b\"\nurl = \"mqtt://broker.site\"\nplain = true\n";
    assert_eq!(parse(plain).unwrap().mqtt[0].port, 1883);
}

/// Mistakes: the lines of a broker, the line that is named, what is said in both languages.
const MISTAKES: &[(&str, u32, &str, &str)] = &[
    ("name = \"\"\nurl = \"mqtt://127.0.0.1\"\n", 1, "is no name", "не имя"),
    ("name = \"a/b\"\nurl = \"mqtt://127.0.0.1\"\n", 1, "is no name", "не имя"),
    ("name = \"a\"\nurl = \"tcp://127.0.0.1:1883\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1:0\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1:70000\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1:\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://u:p@127.0.0.1\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://[::1\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://[x]:1\"\n", 2, "is no broker", "не брокер"),
    ("name = \"a\"\nurl = \"mqtt://broker.site\"\n", 2, "without TLS", "без TLS"),
    ("name = \"a\"\nurl = \"mqtt://10.0.0.9\"\n", 2, "could be read", "можно прочесть"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"/a\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"a/\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"a//b\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"a+\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"a/#\"\n", 3, "prefix", "prefix"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \"$SYS\"\n", 3, "prefix", "prefix"),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nprefix = \
         \"12345678901234567890123456789012345678901234567890123456789012345\"\n",
        3,
        "prefix",
        "prefix",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nhomeassistant = \"#\"\n",
        3,
        "homeassistant",
        "homeassistant",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nclient_id = \"a b\"\n",
        3,
        "no client id",
        "не client_id",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\ninterval_ms = 249\n",
        3,
        "interval_ms = 249 is out",
        "interval_ms = 249 вне",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nalive_ms = 999\n",
        3,
        "alive_ms = 999 is out",
        "alive_ms = 999 вне",
    ),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nmonitors = []\n", 1, "not even Stop", "даже Стоп"),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nmonitors = [\"M3\"]\n",
        3,
        "no monitor M3",
        "Ствола M3 нет",
    ),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nmonitors = [\"M1\", \"M1\"]\n", 3, "M1", "M1"),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\npassword = \"x\"\n",
        3,
        "without a user",
        "без пользователя",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nuser = \"u\"\npassword = \"x\"\n\
         password_file = \"p\"\n",
        5,
        "two passwords",
        "Паролей два",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nuser = \"u\"\npassword_file = \"none\"\n",
        4,
        "/none",
        "/none",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nca = \"ca.pem\"\n",
        3,
        "mqtts:// alone",
        "только для mqtts://",
    ),
    ("name = \"a\"\nurl = \"mqtts://h\"\nca = \"none.pem\"\n", 3, "none.pem", "none.pem"),
    ("name = \"a\"\nurl = \"mqtts://h\"\ncert = \"c.pem\"\n", 3, "go together", "вместе"),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\n[[mqtt]]\nname = \"a\"\n\
         url = \"mqtt://127.0.0.1:1884\"\n",
        4,
        "given twice",
        "дважды",
    ),
    (
        "name = \"a\"\nurl = \"mqtt://127.0.0.1\"\n[[mqtt]]\nname = \"b\"\n\
         url = \"mqtt://127.0.0.1:1883\"\n",
        4,
        "is the same",
        "тот же",
    ),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nrole = \"engineer\"\n", 3, "engineer", "engineer"),
    ("name = \"a\"\nurl = \"mqtt://127.0.0.1\"\nqos = 2\n", 3, "qos", "qos"),
];

#[test]
fn mistakes_are_said_with_their_line_in_both_languages() {
    for (text, line, en, ru) in MISTAKES {
        let problems = parse(text).expect_err(text);
        let place = format!("hub.toml:{}", FIRST + line);
        let found = problems
            .iter()
            .find(|it| it.place == place && it.what.en.contains(en) && it.what.ru.contains(ru));
        assert!(found.is_some(), "{text}: {problems:#?}");
        assert!(found.is_some_and(|it| !it.remedy.en.is_empty() && !it.remedy.ru.is_empty()));
    }
}

#[test]
fn an_edge_node_is_read_and_is_none_unless_it_is_asked_for() {
    assert!(parse(LOCAL).unwrap().mqtt[0].sparkplug.is_none());
    let least = format!("{LOCAL}[mqtt.sparkplug]\ngroup = \"site\"\nnode = \"hub\"\n");
    let config = parse(&least).unwrap();
    let node = config.mqtt[0].sparkplug.clone().unwrap();
    assert_eq!((node.group.as_str(), node.node.as_str(), node.host), ("site", "hub", None));
    assert_eq!((node.history, node.history_age.as_secs()), (10_000, 3600));
    let all = format!(
        "{LOCAL}sparkplug = {{ group = \"Цех 1\", node = \"n\", primary_host = \"scada\", \
         history = 0, history_s = 60 }}\n"
    );
    let node = parse(&all).unwrap().mqtt[0].sparkplug.clone().unwrap();
    assert_eq!((node.group.as_str(), node.host.as_deref()), ("Цех 1", Some("scada")));
    assert_eq!((node.history, node.history_age.as_secs()), (0, 60));
    // Topics of the hub are none of this format.
    let text = "[[monitor]]\nid = \"alarms\"\nurl = \"tcp://h?addr=1\"\n[[mqtt]]\n".to_owned();
    let read = |text: &str| Config::parse("hub.toml", text, Path::new("/"), &Overrides::default());
    assert!(read(&(text + &least)).is_ok());
    // Two nodes of a group are two, one is not.
    let other = |node: &str| {
        format!(
            "{least}[[mqtt]]\nname = \"b\"\nurl = \"mqtt://127.0.0.1\"\n\
             [mqtt.sparkplug]\ngroup = \"site\"\nnode = \"{node}\"\n"
        )
    };
    assert!(parse(&other("other")).is_ok());
    assert!(parse(&other("hub")).unwrap_err()[0].what.en.contains("is the same"));
}

#[test]
fn mistakes_of_an_edge_node_are_said() {
    for (keys, line, en, ru) in [
        ("group = \"a/b\", node = \"n\"", 3, "no name of Sparkplug", "не имя Sparkplug"),
        ("group = \"STATE\", node = \"n\"", 3, "no name of Sparkplug", "не имя Sparkplug"),
        ("group = \"g\", node = \"\"", 3, "no name of Sparkplug", "не имя Sparkplug"),
        ("group = \"g\", node = \"n+\"", 3, "no name of Sparkplug", "не имя Sparkplug"),
        ("group = \"g\", node = \"n\", primary_host = \"#\"", 3, "primary_host", "primary_host"),
        (
            "group = \"g\", node = \"n\", history = 100001",
            3,
            "history = 100001",
            "history = 100001",
        ),
        ("group = \"g\", node = \"n\", history_s = 0", 3, "history_s = 0", "history_s = 0"),
        (
            "group = \"g\", node = \"n\" }\nprefix = \"p\"\nuser = \"u",
            4,
            "prefix is not for",
            "prefix —",
        ),
        ("group = \"g\"", 3, "node", "node"),
    ] {
        let text = match keys.split_once(" }\n") {
            Some((keys, rest)) => format!("{LOCAL}sparkplug = {{ {keys} }}\n{rest}\"\n"),
            None => format!("{LOCAL}sparkplug = {{ {keys} }}\n"),
        };
        let problems = parse(&text).expect_err(&text);
        let place = format!("hub.toml:{}", FIRST + line);
        let found = problems
            .iter()
            .find(|it| it.place == place && it.what.en.contains(en) && it.what.ru.contains(ru));
        assert!(found.is_some(), "{text}: {problems:#?}");
    }
}

#[test]
fn there_are_eight_brokers_at_most() {
    let broker =
        |number: u32| format!("name = \"b{number}\"\nurl = \"mqtt://127.0.0.1:{number}\"\n");
    let all = |most: u32| (1..=most).map(broker).collect::<Vec<_>>().join("[[mqtt]]\n");
    assert_eq!(parse(&all(8)).unwrap().mqtt.len(), 8);
    assert!(parse(&all(9)).unwrap_err()[0].what.en.contains("too many brokers"));
}

#[test]
fn a_monitor_cannot_have_a_topic_of_the_hub() {
    let text =
        "[[monitor]]\nid = \"alarms\"\nurl = \"tcp://h?addr=1\"\n[[mqtt]]\n".to_owned() + LOCAL;
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    assert!(read.unwrap_err()[0].what.en.contains("one of the hub's own"));
}

#[cfg(unix)]
#[test]
fn a_password_that_everybody_can_read_is_warned_of() {
    use std::os::unix::fs::PermissionsExt;
    let folder: PathBuf = std::env::temp_dir().join(format!("lafet-mqtt-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("password");
    std::fs::write(&file, "geheim\n").unwrap();
    let text = format!("{LOCAL}user = \"u\"\npassword_file = \"password\"\n");
    for (mode, warned) in [(0o644, 1), (0o600, 0)] {
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(mode)).unwrap();
        let warnings = parse_in(&folder, &text).unwrap().warnings;
        assert_eq!(warnings.len(), warned, "{mode:o}: {warnings:#?}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
