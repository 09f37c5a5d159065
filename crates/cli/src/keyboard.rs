//! The keyboard of the terminal: single keys instead of lines, for commands that act at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{
    Event, KeyCode, KeyEvent, KeyModifiers, KeyboardEnhancementFlags, PopKeyboardEnhancementFlags,
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
        discard_typed();
        terminal::enable_raw_mode()?;
        let mut keyboard = Self { tells_release: false };
        if terminal::supports_keyboard_enhancement().unwrap_or(false) {
            let flags = KeyboardEnhancementFlags::REPORT_EVENT_TYPES
                | KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES;
            keyboard.tells_release =
                execute!(io::stderr(), PushKeyboardEnhancementFlags(flags)).is_ok();
        }
        // What was pressed meanwhile was not meant for what begins now, except to end it.
        while poll(Duration::ZERO)? {
            if let Event::Key(key) = read()?
                && key.modifiers.contains(KeyModifiers::CONTROL)
                && matches!(key.code, KeyCode::Char('c' | 'с'))
            {
                return Err(Failure::Interrupted);
            }
        }
        Ok(keyboard)
    }
}

/// Discards what was typed before: it was not meant for what begins now.
fn discard_typed() {
    #[cfg(unix)]
    {
        // Without a terminal there is nothing to discard.
        let _ = rustix::termios::tcflush(io::stdin(), rustix::termios::QueueSelector::IFlush);
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

/// A key, and when it was read.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The key.
    pub event: KeyEvent,
    /// When it was read.
    pub at: Instant,
}

/// The keys as they arrive; dropping it leaves later keys to others.
pub struct Keys {
    keys: mpsc::UnboundedReceiver<Key>,
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
                if let Event::Key(event) = event
                    && sender.send(Key { event, at: Instant::now() }).is_err()
                {
                    return;
                }
            }
        });
        Self { keys, over, ended }
    }

    /// The next key; `None` when the terminal is gone.
    pub async fn next(&mut self) -> Option<Key> {
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
