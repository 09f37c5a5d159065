//! Output: text for users, JSON for programs; progress goes to standard error.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use serde_json::Value;
use tokio::time::Instant;

use crate::aside::Aside;
use crate::failure::{Failure, Outcome};

/// Least time between two lines of progress that do not overwrite each other.
const SELDOM: Duration = Duration::from_secs(5);

/// Output of a command and its form.
pub struct Out {
    json: bool,
    progress: Progress,
    /// When a line of progress that may be left out was last shown.
    shown: Option<Instant>,
    /// Writes everything, if nothing may wait for it.
    aside: Option<Aside>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Progress {
    /// Progress is not shown.
    Silent,
    /// One line per change.
    Lines,
    /// One line that is overwritten.
    Line { width: usize },
}

impl Out {
    /// Writes to standard output.
    pub fn new(json: bool) -> Self {
        let progress = match () {
            () if json => Progress::Silent,
            () if io::stderr().is_terminal() => Progress::Line { width: 0 },
            () => Progress::Lines,
        };
        Self { json, progress, shown: None, aside: None }
    }

    /// An output of the same form for which nothing waits: lines are left out rather than held up,
    /// and no failure to print is returned. A line of progress goes on there.
    pub fn aside(&mut self) -> Result<Self, Failure> {
        let mut out = Self::new(self.json);
        out.aside = Some(Aside::start()?);
        std::mem::swap(&mut out.progress, &mut self.progress);
        Ok(out)
    }

    /// Whether the output is JSON.
    pub const fn json(&self) -> bool {
        self.json
    }

    /// Whether progress is one line that is overwritten.
    pub const fn is_live(&self) -> bool {
        matches!(self.progress, Progress::Line { .. })
    }

    /// Prints a result: the text, or the JSON in one line.
    pub fn show(&mut self, text: impl Display, json: impl FnOnce() -> Value) -> Outcome {
        if self.json { self.value(&json()) } else { self.line(text) }
    }

    /// Prints a line of text; nothing with `--json`.
    pub fn say(&mut self, text: impl Display) -> Outcome {
        if self.json { Ok(()) } else { self.line(text) }
    }

    /// Prints JSON in one line.
    pub fn value(&mut self, json: &Value) -> Outcome {
        self.line(json)
    }

    fn line(&mut self, text: impl Display) -> Outcome {
        self.end_progress();
        if let Some(aside) = &self.aside {
            aside.out(format!("{text}\n"));
            return Ok(());
        }
        let mut stdout = io::stdout().lock();
        writeln!(stdout, "{text}")?;
        stdout.flush()?;
        Ok(())
    }

    /// Shows progress. On a terminal the line replaces the previous one.
    pub fn progress(&mut self, text: impl Display) {
        match &mut self.progress {
            Progress::Silent => {}
            Progress::Lines => self.error(format!("{text}\n")),
            Progress::Line { width } => {
                let text = text.to_string();
                let now = text.chars().count();
                let rest = width.saturating_sub(now);
                *width = now;
                self.error(format!("\r{text}{:rest$}", ""));
            }
        }
    }

    /// Writes to standard error. A failure to print must not end the command.
    fn error(&self, text: String) {
        match &self.aside {
            Some(aside) => aside.err(text),
            None => {
                let mut stderr = io::stderr().lock();
                let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
            }
        }
    }

    /// Shows progress of which each line supersedes the previous one: in a pipe or a file, only now
    /// and then.
    pub fn seldom(&mut self, text: impl Display) {
        let due = self.shown.is_none_or(|shown| shown.elapsed() >= SELDOM);
        if self.is_live() || due {
            self.shown = Some(Instant::now());
            self.progress(text);
        }
    }

    /// Prints a warning to standard error at once, even with `--json`.
    pub fn warn(&mut self, text: &str) {
        self.end_progress();
        #[cfg(test)]
        tests::note(text);
        self.error(format!("{text}\n"));
    }

    /// Ends the line of progress and leaves it on the screen.
    pub fn end_progress(&mut self) {
        if let Progress::Line { width } = &mut self.progress
            && std::mem::take(width) > 0
        {
            self.error("\n".into());
        }
    }
}

/// Prints a line to standard error. A command must not end, least of all by a panic, because the
/// terminal is gone.
pub fn complain(text: impl Display) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Prints a line to standard error on a thread of its own, which makes it as well: nothing waits for it, not
/// even the end of the program.
pub fn complain_aside(line: impl FnOnce() -> String + Send + 'static) {
    let thread = std::thread::Builder::new().name("lafet-aside".into());
    // Without a thread the line is left out.
    let _ = thread.spawn(move || complain(line()));
}

impl Drop for Out {
    fn drop(&mut self) {
        self.end_progress();
    }
}

/// Text in columns, each as wide as its widest cell; the last one is not padded.
pub fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter(|row| row.len() > column + 1).map(|row| &row[column]);
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
pub mod tests {
    use std::cell::RefCell;

    use super::*;

    thread_local! {
        static WARNED: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    }

    pub fn note(text: &str) {
        WARNED.with_borrow_mut(|warned| warned.push(text.to_owned()));
    }

    /// Warnings on this thread since the last call.
    pub fn warned() -> Vec<String> {
        WARNED.take()
    }

    #[test]
    fn columns_line_up_and_end_without_blanks() {
        let row = |cells: &[&str]| cells.iter().map(|cell| (*cell).to_owned()).collect();
        let rows = [row(&["Ствол", "1", ""]), row(&["a", "10", "что угодно"])];
        assert_eq!(columns(&rows), "Ствол  1\na      10  что угодно");
    }
}
