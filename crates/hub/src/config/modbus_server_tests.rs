//! What a file may say of servers for masters on Modbus.

use std::path::Path;

use crate::config::{Config, Overrides, Problem};

const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"serial:///dev/ttyUSB0?addr=1\"\n\
    [[monitor]]\nid = \"M2\"\nurl = \"tcp://10.0.0.2:10001?addr=1\"\n";
/// The line after it.
const FIRST: u32 = 7;
const LISTENS: &str = "name = \"plc\"\nlisten = \"tcp://127.0.0.1:502\"\n";

fn parse(server: &str) -> Result<Config, Vec<Problem>> {
    let text = format!("{SITE}[[modbus_server]]\n{server}");
    Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default())
}

#[test]
fn a_server_is_read() {
    let all = format!(
        "{LISTENS}allow = [\"10.0.0.0/24\"]\nrole = \"none\"\nmonitors = [\"M2\"]\nheartbeat_ms = 300\n\
         [[modbus_server.client]]\nname = \"a\"\nfrom = [\"10.0.0.7\"]\nrole = \"operator\"\n"
    );
    let config = parse(&all).unwrap();
    assert_eq!(config.warnings.len(), 0);
    let [server] = &config.modbus_servers[..] else { panic!("{:?}", config.modbus_servers) };
    assert_eq!((server.name.as_str(), server.monitors.clone()), ("plc", vec!["M2".to_owned()]));
    assert_eq!((server.grants.len(), server.terms.heartbeat.as_millis()), (1, 300));
    assert_eq!(parse(LISTENS).unwrap().modbus_servers[0].monitors, ["M1", "M2"]);
}

/// Mistakes: the lines of a server, the line that is named, what is said in both languages.
const MISTAKES: &[(&str, u32, &str, &str)] = &[
    ("name = \"\"\nlisten = \"tcp://127.0.0.1:1\"\n", 1, "is no name", "не имя"),
    ("name = \"a b\"\nlisten = \"tcp://127.0.0.1:1\"\n", 1, "is no name", "не имя"),
    ("name = \"a\"\nlisten = \"tcp://127.0.0.1:70000\"\n", 2, "is no line", "не линия"),
    ("name = \"a\"\nlisten = \"tcp://plc:502\"\n", 2, "no IP address", "не IP-адрес"),
    ("name = \"a\"\nlisten = \"tcp://0.0.0.0:502\"\n", 2, "has no login", "входа по паролю"),
    ("name = \"a\"\nlisten = \"serial:///dev/ttyUSB0\"\n", 2, "by a monitor or a bus", "занят"),
    (
        "name = \"a\"\nlisten = \"serial:///dev/ttyS1\"\nallow = [\"10.0.0.1\"]\n",
        3,
        "has no address",
        "нет адреса",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nallow = [\"10.0.0.0/33\"]\n",
        3,
        "no address or network",
        "не адрес и не сеть",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nmonitors = []\n",
        1,
        "not even Stop",
        "даже Стоп",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nmonitors = [\"M3\"]\n",
        3,
        "no monitor M3",
        "Ствола M3 нет",
    ),
    ("name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nmonitors = [\"M1\", \"M1\"]\n", 3, "M1", "M1"),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nunit = 248\n",
        3,
        "unit = 248 is out",
        "unit = 248 вне",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nheartbeat_ms = 49\n",
        3,
        "heartbeat_ms = 49 is out",
        "heartbeat_ms = 49 вне",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nanswer_ms = 60001\n",
        3,
        "answer_ms = 60001",
        "answer_ms = 60001",
    ),
    ("name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nidle_s = 0\n", 3, "idle_s = 0", "idle_s = 0"),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nconnections_max = 65\n",
        3,
        "connections_max = 65",
        "connections_max = 65",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\nrole = \"none\"\n",
        1,
        "answer no master",
        "ни одному мастеру",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\n\
         [[modbus_server.client]]\nname = \"b\"\nrole = \"operator\"\nregisters = [9, 8]\n",
        6,
        "end before they begin",
        "раньше, чем начинаются",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\n\
         [[modbus_server]]\nname = \"a\"\nlisten = \"tcp://127.0.0.1:2\"\n",
        4,
        "a",
        "a",
    ),
    (
        "name = \"a\"\nlisten = \"tcp://127.0.0.1:1\"\n\
         [[modbus_server]]\nname = \"b\"\nlisten = \"tcp://127.0.0.1:1\"\n",
        5,
        "listens there already",
        "уже принимает подключения",
    ),
];

#[test]
fn every_mistake_is_told_with_its_line_in_both_languages() {
    for (server, line, en, ru) in MISTAKES {
        let problems = parse(server).expect_err(server);
        let [problem] = &problems[..] else { panic!("{server}\n{problems:?}") };
        assert_eq!(problem.place, format!("hub.toml:{}", FIRST + line), "{server}");
        assert!(problem.what.en.contains(en), "{server}\n{}", problem.what.en);
        assert!(problem.what.ru.contains(ru), "{server}\n{}", problem.what.ru);
        assert!(!problem.remedy.en.is_empty() && !problem.remedy.ru.is_empty(), "{server}");
    }
}

#[test]
fn what_is_allowed_and_unwise_is_a_warning() {
    let slow = format!("{LISTENS}heartbeat_ms = 301\n");
    let no_stop = format!(
        "{LISTENS}[[modbus_server.client]]\nname = \"b\"\nrole = \"observer\"\nregisters = [0, 263]\n"
    );
    for (server, en) in [(slow, "later than 500 ms"), (no_stop, "cannot even stop")] {
        let warnings = parse(&server).unwrap().warnings;
        let [warning] = &warnings[..] else { panic!("{server}\n{warnings:?}") };
        assert!(warning.what.en.contains(en), "{}", warning.what.en);
    }
}
