//! The keyboard of the terminal: single keys instead of lines, for commands that act at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use ratatui::crossterm::event::{
    Event, KeyEvent, KeyboardEnhancementFlags, PopKeyboardEnhancementFlags,
    PushKeyboardEnhancementFlags, poll, read,
};
use ratatui::crossterm::{execute, terminal};
use tokio::sync::mpsc;

use crate::failure::Failure;

/// Longest wait for the keyboard thread, which a terminal that is gone may block for ever.
const PATIENCE: Duration = Duration::from_secs(1);
/// How soon the thread leaves the terminal to others when no keys are wanted any more.
const GLANCE: Duration = Duration::from_millis(50);

/// Switches the terminal to single keys instead of lines, until it is dropped.
pub struct Keyboard {
    /// Whether the terminal reports the release of a key.
    pub tells_release: bool,
}

impl Keyboard {
    /// Takes over the keyboard.
    pub fn start() -> Result<Self, Failure> {
        terminal::enable_raw_mode()?;
        let mut keyboard = Self { tells_release: false };
        if terminal::supports_keyboard_enhancement().unwrap_or(false) {
            let flags = KeyboardEnhancementFlags::REPORT_EVENT_TYPES
                | KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES;
            keyboard.tells_release =
                execute!(io::stderr(), PushKeyboardEnhancementFlags(flags)).is_ok();
        }
        Ok(keyboard)
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // A terminal that is gone needs no restoring.
        if self.tells_release {
            let _ = execute!(io::stderr(), PopKeyboardEnhancementFlags);
        }
        let _ = terminal::disable_raw_mode();
    }
}

/// The keys as they arrive; dropping it leaves later keys to others.
pub struct Keys {
    keys: mpsc::UnboundedReceiver<KeyEvent>,
    over: Arc<AtomicBool>,
    /// Closed when the thread ends.
    ended: Receiver<()>,
}

impl Keys {
    /// Starts a thread that waits for keys.
    pub fn listen() -> Self {
        let (sender, keys) = mpsc::unbounded_channel();
        let over = Arc::new(AtomicBool::new(false));
        let (running, ended) = channel();
        let wanted = over.clone();
        std::thread::spawn(move || {
            let _running = running;
            while !wanted.load(Ordering::Relaxed) {
                match poll(GLANCE) {
                    Ok(false) => continue,
                    Ok(true) => {}
                    Err(_) => return,
                }
                let Ok(event) = read() else { return };
                if let Event::Key(key) = event
                    && sender.send(key).is_err()
                {
                    return;
                }
            }
        });
        Self { keys, over, ended }
    }

    /// The next key; `None` when the terminal is gone.
    pub async fn next(&mut self) -> Option<KeyEvent> {
        self.keys.recv().await
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        // The thread must not take a key that is meant for the next reader.
        let _ = self.ended.recv_timeout(PATIENCE);
    }
}
