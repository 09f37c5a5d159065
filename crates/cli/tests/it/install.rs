//! Completions and manual pages cover every command, in both languages.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::support::Run;

#[test]
fn completions_know_every_command() {
    let help = Run::of(&["--help"]).out;
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.len() > 25);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = Run::of(&["completions", shell]);
        assert_eq!(script.code, 0, "{script:?}");
        for command in &commands {
            assert!(script.out.contains(command), "{shell} lacks {command}");
        }
    }
    let mut bash = Command::new("bash").arg("-n").stdin(Stdio::piped()).spawn().unwrap();
    let script = Run::of(&["completions", "bash"]).out;
    std::io::Write::write_all(&mut bash.stdin.take().unwrap(), script.as_bytes()).unwrap();
    assert!(bash.wait().unwrap().success(), "bash accepts the script");
}

#[test]
fn every_command_has_a_page() {
    for (language, words) in [("en", "Search a sector"), ("ru", "сектор")] {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("man-{language}"));
        let man =
            Run::of(&["--lang", language, "--json", "man", "--out", folder.to_str().unwrap()]);
        assert_eq!(man.code, 0, "{man:?}");
        let pages = man.json()[0]["pages"].as_u64().unwrap();
        assert_eq!(pages as usize, std::fs::read_dir(&folder).unwrap().count());
        let seek = std::fs::read_to_string(folder.join("lafet-seek.1")).unwrap();
        assert!(seek.contains(words) && seek.contains("from\\-az"), "{seek}");
    }
}
