//! `lafet jog` at a pseudo-terminal, on a simulated monitor.

use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;

use crate::support::{Run, Running, Sim, lafet, terminal};

const LEFT: &[u8] = b"\x1b[D";

struct Terminal {
    keys: File,
    /// Path of the end that the program opens.
    path: String,
}

impl Terminal {
    fn open() -> Self {
        let (keys, path) = terminal();
        let mut screen = keys.try_clone().unwrap();
        // The output of the program and the terminal's echo must be read.
        std::thread::spawn(move || {
            let mut buffer = [0; 1024];
            while let Ok(1..) = screen.read(&mut buffer) {}
        });
        Self { keys, path }
    }

    fn other_end(&self) -> File {
        File::options().read(true).write(true).open(&self.path).unwrap()
    }
}

fn position(sim: &Sim) -> i64 {
    sim.value(&["status", "horizontal"])["Horizontal"]["position_arcmin"].as_i64().unwrap()
}

fn is_moving(sim: &Sim) -> bool {
    sim.flags("horizontal").contains(&"Move".to_owned())
}

/// The barrel turns while the key repeats; it stops when the key is released and when the program
/// ends.
#[test]
fn a_held_key_moves_the_barrel() {
    // In real time: the lease is timed by the monitor's clock.
    let sim = Sim::start(&[]);
    sim.done(&["deploy"]);
    let from = position(&sim);
    let mut terminal = Terminal::open();
    let mut command = lafet();
    command.args(["-c", sim.url(), "jog", "--lease", "0.5"]).stdin(terminal.other_end());
    let mut jog = Running::stderr(&mut command);
    assert!(jog.line().contains("Stop All"));
    // Keys are paced by the state that the program shows.
    let mut turned = false;
    for _ in 0..8 {
        terminal.keys.write_all(LEFT).unwrap();
        turned |= jog.line().contains('*');
    }
    assert!(turned, "the key moves the drive");
    let began = std::time::Instant::now();
    while is_moving(&sim) {
        assert!(began.elapsed().as_secs() < 20, "no key is held");
    }
    let at = position(&sim);
    assert!(at > from, "{from} {at}: left is positive");
    terminal.keys.write_all(LEFT).unwrap();
    terminal.keys.write_all(b"q").unwrap();
    assert_eq!(jog.code(), Some(0));
    assert!(!is_moving(&sim));
}

#[test]
fn it_needs_a_keyboard() {
    for (lang, word) in [("en", "keyboard"), ("ru", "клавиатура")] {
        let mut command = lafet();
        command.args(["-c", "sim:", "--lang", lang, "jog"]).stdin(Stdio::null());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(word), "{output:?}");
    }
    let run = Run::of(&["-c", "sim:", "jog", "--lease", "5"]);
    assert_eq!(run.code, 2, "{run:?}");
}
