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
