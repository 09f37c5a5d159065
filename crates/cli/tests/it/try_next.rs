//! `lafet demo`: every line that it prints to try next works, in both languages.

use std::process::Command;

use crate::support::{Running, lafet};

/// Starts a demo; returns it, its URL, and the lines to try that it prints.
fn demo(lang: &str) -> (Running, String, Vec<String>) {
    let mut command = lafet();
    command.args(["--lang", lang, "demo", "--port", "0", "--no-browser"]);
    let demo = Running::stdout(&mut command);
    let url = demo.line();
    let mut lines = Vec::new();
    loop {
        let line = demo.line();
        if line.contains("Ctrl-C") {
            return (demo, url, lines);
        }
        lines.extend(line.strip_prefix("  ").map(str::to_owned));
    }
}

#[test]
fn every_line_to_try_works() {
    let (_demo, url, lines) = demo("en");
    assert!(url.starts_with("http://127.0.0.1:"), "{url}");
    assert!(lines.len() >= 5, "{lines:?}");
    let folder = std::env::temp_dir().join(format!("lafet-try-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_lafet")).parent().unwrap().to_owned();
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", program.display());
    for line in &lines {
        let mut shell = Command::new("sh");
        let output = shell.args(["-c", line]).env("PATH", &path).current_dir(&folder).output();
        let output = output.expect("a shell");
        let told = String::from_utf8_lossy(&output.stdout);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {told} {error}");
        assert!(!told.contains("\"error\":{"), "{line}: {told}");
        let quiet = line.contains(" record ");
        assert!(quiet || !told.trim().is_empty(), "{line} says nothing");
    }
    let recorded = std::fs::metadata(folder.join("demo.pcapng")).expect("it was recorded");
    assert!(recorded.len() > 1000, "{recorded:?}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn both_languages_print_the_same_lines() {
    let plain = |lines: Vec<String>, url: &str| -> Vec<String> {
        let place = |line: &str| {
            let start = line.find("tcp://127.0.0.1:").map(|at| at + 16);
            let Some(start) = start else { return line.to_owned() };
            let end = line[start..].find('?').map_or(line.len(), |len| start + len);
            format!("{}{}", &line[..start], &line[end..])
        };
        lines.iter().map(|line| place(&line.replace(url, ""))).collect()
    };
    let (_en, url, lines) = demo("en");
    let en = plain(lines, &url);
    let (_ru, url, lines) = demo("ru");
    assert_eq!(en, plain(lines, &url));
}
