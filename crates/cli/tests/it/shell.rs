//! `lafet shell`: scripts, and a pseudo-terminal.

use std::process::Stdio;

use crate::support::{Run, Running, Sim, lafet};

fn script(sim: &Sim, more: &[&str], text: &str) -> Run {
    let mut arguments = vec!["shell", sim.url()];
    arguments.extend(more);
    Run::fed(&arguments, text.as_bytes())
}

#[test]
fn a_script_runs_on_one_connection() {
    let sim = Sim::start(&["--speed", "40"]);
    let text = "# to work\ndeploy\n\nmove vertical 12°30' # up\nparam get valve1 TravelTime\n\
                send \"GetStatus Valve1\" 'GetStatus Valve2'\nstatus vertical --json\n";
    let run = script(&sim, &[], text);
    assert_eq!(run.code, 0, "{run:?}");
    let last: serde_json::Value = serde_json::from_str(run.out.lines().last().unwrap()).unwrap();
    assert_eq!(last["Vertical"]["position_arcmin"], 750, "{run:?}");
    for word in ["Deploy", "TravelTime", "GetStatus → Ok"] {
        assert!(run.out.contains(word), "{word}: {run:?}");
    }
    // `sim:` is one simulator for the whole shell.
    let run = Run::fed(&["shell", "sim:?speed=40"], b"deploy\nstatus deployer\n");
    assert!(run.code == 0 && run.out.contains("Deployed"), "{run:?}");
}

#[test]
fn a_script_ends_with_the_first_failure() {
    let sim = Sim::start(&["--speed", "40"]);
    let text = "status deployer\nmove vertical 10deg\nfly\ndeploy\n";
    let run = script(&sim, &[], text);
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.err.contains("Denied") && run.err.contains("Line 2: move"), "{run:?}");
    assert!(!run.err.contains("fly"), "{run:?}");
    let run = script(&sim, &["--keep-going"], text);
    assert_eq!(run.code, 1, "the first failure counts: {run:?}");
    assert!(run.err.contains("Line 3: fly"), "{run:?}");
    assert!(sim.flags("deployer").contains(&"Deployed".into()), "{run:?}");
    let run = script(&sim, &["--lang", "ru"], "летать\n");
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.err.contains("Строка 1") && run.err.contains("неизвестная команда"), "{run:?}");
    // What follows is not read.
    let run = script(&sim, &[], "exit\nfly\n");
    assert_eq!(run.code, 0, "{run:?}");
}

/// A line that is no text is wrong, like any other that is not understood.
#[test]
fn bytes_that_are_no_text_do_not_end_a_script() {
    let sim = Sim::start(&["--speed", "40"]);
    let text = b"status deployer\r\n\xf1\xf2\xee\xef\nstatus vertical\n";
    let run = Run::fed(&["shell", sim.url()], text);
    assert!(run.code == 2 && run.err.contains("Line 2: "), "{run:?}");
    let run = Run::fed(&["shell", sim.url(), "-k"], text);
    assert!(run.code == 2 && run.out.contains("Vertical"), "{run:?}");
}

/// `stop` in any spelling, with any arguments, ends all motion.
#[test]
fn stop_is_always_understood() {
    for stop in ["stop", "STOP", "стоп", "ыещз", "stop verticla"] {
        let sim = Sim::start(&["--speed", "4"]);
        let run = script(&sim, &["-k"], &format!("deploy --no-wait\n{stop}\n"));
        assert!(run.err.contains("Stop All") || run.out.contains("Stop → Ok"), "{stop}: {run:?}");
        let flags = sim.flags("deployer");
        let is_on = |flag: &str| flags.contains(&flag.to_owned());
        assert!(!is_on("Deploying") && !is_on("Deployed"), "{stop}: {flags:?}");
    }
}

#[test]
fn what_is_fixed_is_reported() {
    let sim = Sim::start(&[]);
    for (line, word) in [
        ("-c sim: status", "--connect"),
        ("status --timeout 3", "--timeout"),
        ("status --lang ru", "--lang"),
        ("shell sim:", "shell"),
        ("send \"Open", "quote"),
    ] {
        let run = script(&sim, &[], &format!("{line}\n"));
        assert_eq!(run.code, 2, "{line}: {run:?}");
        assert!(run.err.contains(word), "{line}: {run:?}");
    }
    let run = Run::fed(&["shell", "sim:"], b"doctor\n");
    assert!(run.code == 2 && run.err.contains("without the shell"), "{run:?}");
    let run = script(&sim, &[], "help move\n");
    assert!(run.code == 0 && run.out.contains("--no-wait"), "{run:?}");
    let run = Run::fed(&["shell", "tcp://127.0.0.1:1"], b"status\n");
    assert_eq!(run.code, 3, "{run:?}");
}

/// Ctrl-C during a motion: the drive stops, and the script ends.
#[cfg(unix)]
#[test]
fn an_interrupted_script_stops_what_moves() {
    use std::io::Write;
    let sim = Sim::start(&[]);
    let mut command = lafet();
    command.args(["shell", sim.url()]).stdin(Stdio::piped());
    let mut shell = Running::stderr(&mut command);
    let mut stdin = shell.child.stdin.take().unwrap();
    stdin.write_all(b"deploy\nstatus\n").unwrap();
    assert!(shell.line().contains("Deploying"));
    shell.signal("INT");
    let mut told = shell.line();
    while !told.contains("Stop All") {
        told = shell.line();
    }
    assert!(told.contains("Ok"), "{told}");
    assert_eq!(shell.code(), Some(130));
    let flags = sim.flags("deployer");
    assert!(!flags.contains(&"Deploying".into()), "{flags:?}");
}

/// The terminal is gone when Ctrl-C or a hang-up arrives: what was opened is closed all the same.
#[cfg(unix)]
#[test]
fn a_terminal_that_is_gone_does_not_keep_a_valve_open() {
    use std::io::{BufRead, BufReader, Write};
    let sim = Sim::start(&["--profile", "remote"]);
    let mut command = lafet();
    command.args(["shell", sim.url()]).stdin(Stdio::piped()).stdout(Stdio::null());
    let mut shell = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = shell.stdin.take().unwrap();
    stdin.write_all(b"open\n").unwrap();
    let mut said = BufReader::new(shell.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("Opening") {
        line.clear();
        said.read_line(&mut line).unwrap();
    }
    drop(said);
    let kill = std::process::Command::new("kill").args(["-HUP", &shell.id().to_string()]).status();
    assert!(kill.unwrap().success());
    assert_eq!(shell.wait().unwrap().code(), Some(130));
    let flags = sim.flags("valve1");
    assert!(flags.contains(&"Closed".to_owned()), "{flags:?}");
}

#[cfg(unix)]
mod terminal {
    use std::fs::File;
    use std::io::{Read, Write};
    use std::process::{Child, Command};
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    use super::*;
    use crate::support::terminal;

    const PATIENCE: Duration = Duration::from_secs(60);

    /// The shell at a terminal that reports its cursor position when asked.
    struct Typed {
        keys: File,
        screen: Receiver<String>,
        shell: Child,
    }

    impl Typed {
        fn start(sim: &Sim, lang: &str) -> Self {
            let (keys, path) = terminal();
            let (mut output, mut answers) = (keys.try_clone().unwrap(), keys.try_clone().unwrap());
            let (sender, screen) = channel();
            std::thread::spawn(move || {
                let mut buffer = [0; 4096];
                while let Ok(length @ 1..) = output.read(&mut buffer) {
                    let text = String::from_utf8_lossy(&buffer[..length]).into_owned();
                    if text.contains("\x1b[6n") && answers.write_all(b"\x1b[1;1R").is_err() {
                        return;
                    }
                    if sender.send(text).is_err() {
                        return;
                    }
                }
            });
            let end = || File::options().read(true).write(true).open(&path).unwrap();
            let mut command = lafet();
            command.args(["--lang", lang, "shell", "--no-history", sim.url()]);
            command.env("TERM", "xterm").stdin(end()).stdout(end()).stderr(end());
            let shell = command.spawn().unwrap();
            Self { keys, screen, shell }
        }

        /// Waits until this is printed; returns what was printed before.
        fn sees(&self, text: &str) -> String {
            let mut seen = String::new();
            while !seen.contains(text) {
                match self.screen.recv_timeout(PATIENCE) {
                    Ok(more) => seen.push_str(&more),
                    Err(_) => panic!("`{text}` is not in {seen:?}"),
                }
            }
            seen
        }

        fn types(&mut self, text: &str) {
            self.keys.write_all(text.as_bytes()).unwrap();
        }
    }

    impl Drop for Typed {
        fn drop(&mut self) {
            // It may have ended already.
            let _ = self.shell.kill();
            let _ = self.shell.wait();
        }
    }

    /// Tab completes; Ctrl-C at the prompt stops what moves, and the shell continues.
    #[test]
    fn control_c_stops_and_returns_to_the_prompt() {
        let sim = Sim::start(&[]);
        let mut typed = Typed::start(&sim, "en");
        typed.sees("stowed");
        typed.types("depl\t--no-wait\r");
        typed.sees("Accepted");
        typed.sees("deploying");
        typed.types("\x03");
        typed.sees("Stop All was sent; at rest now.");
        let flags = sim.flags("deployer");
        assert!(!flags.contains(&"Deploying".into()), "{flags:?}");
        typed.types("exit\r");
        assert_eq!(typed.shell.wait().unwrap().code(), Some(0));
    }

    /// Stop All leaves a valve half open: it is named.
    #[test]
    fn control_c_names_a_valve_that_stays_open() {
        let sim = Sim::start(&["--profile", "remote"]);
        let mut typed = Typed::start(&sim, "en");
        typed.sees("> ");
        typed.types("open --no-wait\r");
        typed.sees("Accepted");
        typed.sees("> ");
        let began = std::time::Instant::now();
        while sim.flags("valve1").contains(&"Closed".into()) {
            assert!(began.elapsed().as_secs() < 60, "it does not open");
        }
        typed.types("\x03");
        typed.sees("Valve1 is not closed, and water may flow. To close it: lafet close valve1");
        typed.types("exit\r");
        assert_eq!(typed.shell.wait().unwrap().code(), Some(0));
    }

    #[test]
    fn a_signal_ends_it_at_the_prompt() {
        let sim = Sim::start(&[]);
        for signal in ["TERM", "HUP"] {
            let mut typed = Typed::start(&sim, "en");
            typed.sees("stowed");
            let id = typed.shell.id().to_string();
            let mut kill = std::process::Command::new("kill");
            let sent = kill.args([&format!("-{signal}"), &id]).status();
            assert!(sent.unwrap().success());
            assert_eq!(typed.shell.wait().unwrap().code(), Some(130), "{signal}");
        }
    }

    /// `stop` does not wait for the running command, and the loss of the link is reported.
    #[test]
    fn stop_is_heard_while_a_command_runs() {
        let mut sim = Sim::start(&[]);
        let mut typed = Typed::start(&sim, "ru");
        typed.sees("свёрнут");
        typed.types("deploy\r");
        typed.sees("Deploying");
        typed.types("стоп\n");
        typed.sees("Stop All → Ok");
        typed.sees("> ");
        let flags = sim.flags("deployer");
        assert!(!flags.contains(&"Deploying".into()), "{flags:?}");
        sim.running.child.kill().unwrap();
        typed.sees("не отвечает");
        typed.types("exit\r");
        assert_eq!(typed.shell.wait().unwrap().code(), Some(0));
    }

    /// What was typed before a `stop` or Ctrl-C does not run after it: it would move again.
    #[test]
    fn a_stop_revokes_what_waits_for_its_turn() {
        for interrupts in [false, true] {
            let sim = Sim::start(&[]);
            let mut typed = Typed::start(&sim, "ru");
            typed.sees("свёрнут");
            typed.types("deploy\r");
            typed.sees("Deploying");
            typed.types("deploy --no-wait\n");
            std::thread::park_timeout(Duration::from_millis(200));
            if interrupts {
                let shell = typed.shell.id().to_string();
                assert!(Command::new("kill").args(["-INT", &shell]).status().unwrap().success());
            } else {
                typed.types("стоп\n");
            }
            typed.sees("Не выполнено");
            typed.sees("> ");
            std::thread::park_timeout(Duration::from_millis(500));
            let flags = sim.flags("deployer");
            assert!(!flags.contains(&"Deploying".into()), "{interrupts} {flags:?}");
        }
    }
}
