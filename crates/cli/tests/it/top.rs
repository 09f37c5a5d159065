//! `lafet top --once` on simulated monitors.

use std::net::TcpListener;

use crate::support::{Run, Sim};

fn top(lang: &str, urls: &[&str], more: &[&str]) -> Run {
    let mut arguments = vec!["--lang", lang, "--timeout", "0.2", "top"];
    arguments.extend(urls);
    arguments.push("--once");
    arguments.extend(more);
    Run::of(&arguments)
}

#[test]
fn one_picture_of_several_monitors() {
    let (full, mini) = (Sim::start(&[]), Sim::start(&["--profile", "mini"]));
    let urls = [full.url(), mini.url()];
    for (lang, words) in [
        ("en", ["stowed", "ready", "STOP ALL", "problems"]),
        ("ru", ["свёрнут", "готов", "СТОП ВСЕ", "что не так"]),
    ] {
        let run = top(lang, &urls, &[]);
        assert_eq!(run.code, 0, "{run:?}");
        for word in words.iter().copied().chain([full.place(), mini.place()]) {
            assert!(run.out.contains(word), "{word}: {}", run.out);
        }
        assert!(run.out.lines().all(|line| line.chars().count() <= 80), "{}", run.out);
    }
    for (page, word) in [("detail", "├"), ("link", "round trip:")] {
        let run = top("en", &urls, &["--page", page, "--size", "120x40"]);
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.out.contains(word), "{page}: {}", run.out);
    }
}

#[test]
fn a_monitor_that_does_not_answer_is_shown_and_reported() {
    let sim = Sim::start(&[]);
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let closed = format!("tcp://{closed}");
    let run = top("en", &[sim.url(), &closed], &[]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(run.out.contains("stowed") && run.out.contains("no link"), "{}", run.out);
    let run = top("en", &[sim.url(), &closed], &["--json"]);
    let json = run.json();
    assert_eq!(json[0]["connected"], true, "{run:?}");
    assert_eq!(json[0]["status"]["Deployer"]["status"], "Ok", "{run:?}");
    assert_eq!((&json[1]["connected"], &json[1]["age_s"]), (&false.into(), &().into()), "{run:?}");
    assert_eq!(json[2]["error"]["exit_code"], 3, "{run:?}");
}

#[test]
fn wrong_usage() {
    for (arguments, word) in [
        (&["top"][..], "LAFET_CONNECT"),
        (&["top", "http://h", "--once"], "http"),
        (&["top", "sim:"], "--once"),
        (&["top", "sim:?profile=huge", "--once"], "limit-switch"),
        (&["top", "sim:", "--once", "--size", "9"], "80x24"),
    ] {
        let run = Run::of(arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {run:?}");
        assert!(run.err.contains(word), "{arguments:?}: {run:?}");
    }
}

/// A Stop is seen through, and its outcome shown, however soon the screen is left.
#[cfg(unix)]
#[test]
fn a_stop_outlives_the_screen() {
    use std::fs::File;
    use std::io::{Read, Write};
    let sim = Sim::start(&[]);
    sim.done(&["deploy", "--no-wait"]);
    let (ours, path) = crate::support::terminal();
    let end = || File::options().read(true).write(true).open(&path).unwrap();
    let mut command = crate::support::lafet();
    command.args(["--lang", "en", "top", sim.url()]).env("TERM", "xterm");
    let mut top = command.stdin(end()).stdout(end()).stderr(end()).spawn().unwrap();
    drop(command);
    let (mut screen, mut keys) = (ours.try_clone().unwrap(), ours);
    let (mut seen, mut buffer) = (String::new(), [0; 4096]);
    let mut sees = |text: &str| {
        while !seen.contains(text) {
            let count = screen.read(&mut buffer).unwrap_or_else(|e| panic!("{e}: {text}: {seen}"));
            seen.push_str(&String::from_utf8_lossy(&buffer[..count]));
        }
    };
    sees("deploying");
    keys.write_all(b"sq").unwrap();
    sees("Stop All → Ok");
    assert_eq!(top.wait().unwrap().code(), Some(0));
    let flags = sim.flags("deployer");
    assert!(!flags.contains(&"Deploying".to_owned()), "{flags:?}");
}
