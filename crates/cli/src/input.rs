//! Lines of standard input.

use std::io::{self, BufRead};

use tokio::sync::mpsc;

/// Lines of standard input as they arrive, read by a thread that ends with the program. What is not
/// UTF-8 in a line is replaced: the line is wrong, and not the end of the input.
pub fn lines() -> mpsc::UnboundedReceiver<String> {
    let (sender, lines) = mpsc::unbounded_channel();
    std::thread::spawn(move || {
        for line in io::stdin().lock().split(b'\n').map_while(Result::ok) {
            let line = line.strip_suffix(b"\r").unwrap_or(&line);
            if sender.send(String::from_utf8_lossy(line).into_owned()).is_err() {
                return;
            }
        }
    });
    lines
}
