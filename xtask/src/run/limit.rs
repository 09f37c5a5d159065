//! Ends what hangs: a step that takes too long is killed with every process that it started.

use std::collections::HashSet;
use std::io;
use std::process::{Child, Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How long what was killed may take to end before what has started since is killed too.
const AGAIN: Duration = Duration::from_secs(5);

/// The process that runs beside all steps and has limits of its own; 0 without one.
static BESIDE: AtomicU32 = AtomicU32::new(0);

/// Spares this process and what it starts.
pub fn spare(process: u32) {
    BESIDE.store(process, Ordering::Relaxed);
}

/// Runs this; after the limit, kills the processes that it has started until it returns. The second result
/// says whether that was necessary.
pub fn within<T>(limit: Duration, run: impl FnOnce() -> T) -> (T, bool) {
    watch(limit, || kill_below(std::process::id()), run)
}

/// The output of a process; after the limit it is killed with what it has started. The second result says
/// whether that was necessary.
pub fn output(child: Child, limit: Duration) -> (io::Result<Output>, bool) {
    let id = child.id();
    watch(limit, || kill(id), || child.wait_with_output())
}

fn watch<T>(limit: Duration, kill: impl Fn() + Send, run: impl FnOnce() -> T) -> (T, bool) {
    let (ended, waiting) = channel::<()>();
    std::thread::scope(|scope| {
        let watch = scope.spawn(move || {
            let mut wait = limit;
            let mut killed = false;
            while waiting.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                kill();
                (wait, killed) = (AGAIN, true);
            }
            killed
        });
        let result = run();
        drop(ended);
        (result, watch.join().unwrap_or(true))
    })
}

fn kill_below(root: u32) {
    let processes = processes();
    kill_all(&descendants(root, BESIDE.load(Ordering::Relaxed), &processes), &processes);
}

fn kill(root: u32) {
    let processes = processes();
    let mut all = descendants(root, 0, &processes);
    all.insert(root);
    kill_all(&all, &processes);
}

fn kill_all(own: &HashSet<u32>, processes: &[Process]) {
    for Process { id, line, .. } in processes.iter().filter(|it| own.contains(&it.id)) {
        println!("   too long, killed: {id} {line}");
    }
    if !own.is_empty() {
        // What has ended meanwhile is no error.
        let _ = Command::new("kill").arg("-9").args(own.iter().map(ToString::to_string)).status();
    }
}

struct Process {
    id: u32,
    parent: u32,
    line: String,
}

/// All processes of this machine; none where there is no `/proc`.
fn processes() -> Vec<Process> {
    let folders = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    folders
        .filter_map(|folder| {
            let id = folder.file_name().to_str()?.parse().ok()?;
            let stat = std::fs::read_to_string(folder.path().join("stat")).ok()?;
            // The name before it is in parentheses and may contain anything.
            let parent = stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
            let line = std::fs::read(folder.path().join("cmdline")).ok()?;
            let line = String::from_utf8_lossy(&line).replace('\0', " ");
            Some(Process { id, parent, line })
        })
        .collect()
}

fn descendants(root: u32, spared: u32, processes: &[Process]) -> HashSet<u32> {
    let mut found = HashSet::new();
    let mut parents = vec![root];
    while let Some(parent) = parents.pop() {
        let children = processes.iter().filter(|it| it.parent == parent && it.id != spared);
        for child in children {
            if found.insert(child.id) {
                parents.push(child.id);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead as _, BufReader};
    use std::process::Stdio;

    #[test]
    fn what_hangs_is_killed() {
        let command = ["-c", "sleep 600; echo killed; exec sleep 600"];
        let mut shell = Command::new("sh").args(command).stdout(Stdio::piped()).spawn().unwrap();
        let id = shell.id();
        let (printed, killed) = watch(
            Duration::from_millis(200),
            || kill_below(id),
            || {
                let mut line = String::new();
                BufReader::new(shell.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
                line
            },
        );
        shell.kill().unwrap();
        shell.wait().unwrap();
        assert!(killed);
        assert_eq!(printed, "killed\n");
    }

    #[test]
    fn what_ends_in_time_is_left_alone() {
        let (status, killed) =
            within(Duration::from_secs(60), || Command::new("true").status().unwrap());
        assert!(!killed);
        assert!(status.success());
    }

    #[test]
    fn what_runs_beside_is_spared_with_its_children() {
        let process = |id, parent| Process { id, parent, line: String::new() };
        let all = [process(2, 1), process(3, 2), process(4, 1), process(5, 4), process(6, 9)];
        assert_eq!(descendants(1, 4, &all), HashSet::from([2, 3]));
    }
}
