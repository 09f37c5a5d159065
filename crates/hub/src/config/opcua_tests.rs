//! What a file may say of OPC UA servers.

use std::path::Path;

use crate::config::{Config, Overrides, Problem};
use crate::plugs::modbus::access::Level;
use crate::plugs::opcua::Language;

const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://10.0.0.2:10001?addr=1\"\n[[opcua]]\n";
/// The line of the table.
const FIRST: u32 = 4;

fn parse(server: &str) -> Result<Config, Vec<Problem>> {
    Config::parse("hub.toml", &format!("{SITE}{server}"), Path::new("/s"), &Overrides::default())
}

#[test]
fn a_server_is_read_and_is_careful_unless_it_says_otherwise() {
    let config = parse("name = \"a\"\nlisten = \"127.0.0.1:4840\"\n").unwrap();
    let [server] = &config.opcua[..] else { panic!("{:?}", config.opcua) };
    assert_eq!((server.role, server.anonymous), (Level::Observer, Level::None));
    assert!(!server.plain && !server.terms.operates && server.terms.closes);
    assert_eq!((server.url().as_str(), server.sessions_max), ("opc.tcp://127.0.0.1:4840/", 16));
    assert_eq!(server.folder, Path::new("/s/lafet-data/opcua/a"));
    assert_eq!((server.monitors.clone(), server.language), (vec!["M1".to_owned()], Language::En));
    let config = parse(
        "name = \"a\"\nlisten = \"0.0.0.0:4840\"\nhost = \"hub.site\"\nallow = [\"10.0.0.0/24\"]\n\
         role = \"operator\"\nanonymous = \"observer\"\nlanguage = \"ru\"\nalive_ms = 5000\n\
         certificates = \"ua\"\n",
    )
    .unwrap();
    let server = &config.opcua[0];
    assert_eq!(
        (server.url().as_str(), server.language),
        ("opc.tcp://hub.site:4840/", Language::Ru)
    );
    assert!(server.terms.operates && server.folder == Path::new("/s/ua"));
}

/// Mistakes: the lines of a server, the line that is named, what is said in both languages.
const MISTAKES: &[(&str, u32, &str, &str)] = &[
    ("name = \"a b\"\nlisten = \"127.0.0.1:1\"\n", 1, "is no name", "не имя"),
    ("name = \"a\"\nlisten = \"opc.tcp://127.0.0.1:1\"\n", 2, "no place to listen", "не адрес"),
    ("name = \"a\"\nlisten = \"10.0.0.1:1\"\n", 2, "from other machines", "с других машин"),
    (
        "name = \"a\"\nlisten = \"10.0.0.1:1\"\nallow = [\"10.0.0.2\"]\nplain = true\n",
        4,
        "without security",
        "без защиты",
    ),
    (
        "name = \"a\"\nlisten = \"10.0.0.1:1\"\nallow = [\"10.0.0.2\"]\nanonymous = \"operator\"\n",
        4,
        "without a user",
        "без пользователя",
    ),
    ("name = \"a\"\nlisten = \"0.0.0.0:1\"\nallow = [\"10.0.0.2\"]\n", 2, "reach", "обращаются"),
    ("name = \"a\"\nlisten = \"127.0.0.1:1\"\nhost = \"a/b\"\n", 3, "is no host", "не узел"),
    ("name = \"a\"\nlisten = \"127.0.0.1:1\"\nalive_ms = 5\n", 3, "out of range", "вне"),
    ("name = \"a\"\nlisten = \"127.0.0.1:1\"\nsessions_max = 65\n", 3, "out of range", "вне"),
    ("name = \"a\"\nlisten = \"127.0.0.1:1\"\nkey = \"k\"\n", 3, "cert", "cert"),
    ("name = \"a\"\nlisten = \"127.0.0.1:1\"\nmonitors = [\"M9\"]\n", 3, "M9", "M9"),
];

#[test]
fn mistakes_are_named_with_their_line() {
    for (lines, line, en, ru) in MISTAKES {
        let problems = parse(lines).expect_err(lines);
        let is_it = |it: &Problem| {
            it.place == format!("hub.toml:{}", FIRST + line)
                && it.what.en.contains(en)
                && it.what.ru.contains(ru)
        };
        assert!(problems.iter().any(is_it), "{lines}: {problems:#?}");
    }
}

#[test]
fn two_servers_are_two() {
    let first = "name = \"a\"\nlisten = \"127.0.0.1:1\"\n";
    for second in
        ["name = \"a\"\nlisten = \"127.0.0.1:2\"\n", "name = \"b\"\nlisten = \"127.0.0.1:1\"\n"]
    {
        assert!(parse(&format!("{first}[[opcua]]\n{second}")).is_err(), "{second}");
    }
}
