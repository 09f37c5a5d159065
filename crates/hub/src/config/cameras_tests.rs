//! What a file may say of cameras.

use std::path::Path;

use super::*;
use crate::config::{Config, Overrides, Problem};

const SITE: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://10.0.0.1?addr=1\"\n\
    [[monitor]]\nid = \"M2\"\nurl = \"tcp://10.0.0.2:10001?addr=1\"\n";
/// The line of `[[camera]]`.
const FIRST: u32 = 7;

fn parse(camera: &str) -> Result<Config, Vec<Problem>> {
    let text = format!("{SITE}[[camera]]\n{camera}");
    Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default())
}

#[test]
fn a_camera_is_read_and_no_log_has_its_password() {
    let short = "id = \"C1\"\nurl = \"rtsp://10.0.0.9/1\"\nmonitors = [\"M1\"]\n";
    let config = parse(short).unwrap();
    let [camera] = &config.cameras[..] else { panic!("{config:?}") };
    assert_eq!((camera.mount, &camera.name), (Mount::Fixed, &Both::same("C1")));
    assert!(camera.login.is_none() && camera.zones.is_empty() && config.warnings.is_empty());
    let all = "id = \"C1\"\nname = { en = \"West\", ru = \"Запад\" }\n\
        url = \"rtsp://[::1]:8554/cam?channel=1&key=geheim\"\nuser = \"viewer\"\n\
        password = \"geheim\"\nmonitors = [\"M2\"]\nmount = \"barrel\"\n";
    let config = parse(all).unwrap();
    let camera = &config.cameras[0];
    assert_eq!((camera.mount, &camera.monitors[..]), (Mount::Barrel, &["M2".to_owned()][..]));
    assert_eq!(camera.login.as_ref().unwrap().password().unwrap().unwrap(), "geheim");
    assert!(!format!("{config:?}").contains("geheim"));
}

/// Mistakes: the lines of a camera, the line that is named, what is said in both languages.
const MISTAKES: &[(&str, u32, &str, &str)] = &[
    ("id = \"C 1\"\nurl = \"rtsp://h/1\"\nmonitors = [\"M1\"]\n", 1, "is not an id", "не id"),
    ("id = \"C\"\nurl = \"http://h/1\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://h:0/\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://h:99999/\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://[::1/\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://[::1]x/\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://h/a b\"\nmonitors = [\"M1\"]\n", 2, "no camera", "не камера"),
    ("id = \"C\"\nurl = \"rtsp://u:p@h/\"\nmonitors = [\"M1\"]\n", 2, "a user in", "пользователь"),
    (
        "id = \"C\"\nurl = \"rtsps://h/\"\nmonitors = [\"M1\"]\n",
        2,
        "RTSP over TLS",
        "RTSP поверх TLS",
    ),
    ("id = \"C\"\nurl = \"rtsp://h/\"\n", 1, "looks at nothing", "ни на что"),
    ("id = \"C\"\nurl = \"rtsp://h/\"\nmonitors = [\"M9\"]\n", 3, "M9", "M9"),
    ("id = \"C\"\nurl = \"rtsp://h/\"\nmonitors = [\"M1\", \"M1\"]\n", 3, "twice", "дважды"),
    ("id = \"C\"\nurl = \"rtsp://h/\"\nzones = [\"hall\"]\n", 3, "no zone", "Зоны"),
    (
        "id = \"C\"\nurl = \"rtsp://h/\"\nmonitors = [\"M1\", \"M2\"]\nmount = \"barrel\"\n",
        4,
        "one barrel",
        "одном стволе",
    ),
    (
        "id = \"C\"\nurl = \"rtsp://h/\"\nmonitors = [\"M1\"]\npassword = \"p\"\n",
        4,
        "without a user",
        "без пользователя",
    ),
];

#[test]
fn mistakes_are_reported_with_their_line() {
    for (camera, line, en, ru) in MISTAKES {
        let problems = parse(camera).unwrap_err();
        let [problem] = &problems[..] else { panic!("{camera}: {problems:#?}") };
        let place = format!("hub.toml:{}", FIRST + line);
        let fits = problem.what.en.contains(en) && problem.what.ru.contains(ru);
        assert!(problem.place == place && fits, "{camera}: {problem:#?}");
        assert!(!problem.what.en.contains("u:p"), "no message repeats a password");
    }
}

#[test]
fn cameras_are_few_and_their_ids_differ() {
    let one = |id: usize| {
        format!("[[camera]]\nid = \"C{id}\"\nurl = \"rtsp://h/\"\nmonitors = [\"M1\"]\n")
    };
    let many = |ids: &mut dyn Iterator<Item = usize>| {
        let text = ids.map(one).collect::<String>();
        Config::parse("hub.toml", &format!("{SITE}{text}"), Path::new("/"), &Overrides::default())
    };
    assert_eq!(many(&mut (0..CAMERAS_MAX)).unwrap().cameras.len(), CAMERAS_MAX);
    assert!(many(&mut (0..=CAMERAS_MAX)).unwrap_err()[0].what.en.contains("too many"));
    assert!(many(&mut [1, 1].into_iter()).unwrap_err()[0].what.en.contains("twice"));
}
