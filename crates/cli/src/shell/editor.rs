//! The line editor, with history and completion; it knows no commands.

use std::borrow::Cow;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, SyncSender, channel};
use std::time::Duration;

use reedline::{
    ColumnarMenu, DefaultHinter, Emacs, ExternalPrinter, FileBackedHistory, KeyCode, KeyModifiers,
    MenuBuilder, Prompt, PromptEditMode, PromptHistorySearch, Reedline, ReedlineEvent,
    ReedlineMenu, Signal, default_emacs_keybindings,
};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::time::timeout;

use super::complete::Grammar;
use crate::out::complain;
use crate::state;
use crate::top::feed::Feed;

const MENU: &str = "completion";
/// Most lines of history kept.
const HISTORY_MAX: usize = 2000;
/// The editor leaves the terminal within this time.
const PATIENCE: Duration = Duration::from_secs(1);
/// Most notices that wait until the editor shows them.
const NOTICES_MAX: usize = 32;

/// Result of reading a line.
#[derive(Debug)]
pub enum Input {
    /// A complete line.
    Line(String),
    /// Ctrl-C was pressed.
    CtrlC,
    /// Ctrl-D, or the terminal is gone.
    End,
    /// The terminal cannot be used.
    Failed(io::Error),
}

/// Edits lines on a thread of its own, one per request.
pub struct Editor {
    ask: Sender<()>,
    inputs: UnboundedReceiver<Input>,
    notices: Notices,
    over: Arc<AtomicBool>,
}

/// Shows notices above the line being typed.
#[derive(Clone)]
pub struct Notices {
    printer: SyncSender<String>,
    repaint: Arc<dyn Fn() + Send + Sync>,
    /// Whether a line is being typed.
    typing: Arc<AtomicBool>,
}

impl Notices {
    /// Shows a notice.
    pub fn tell(&self, text: String) {
        if !self.typing.load(Ordering::Acquire) {
            complain(text);
        } else if self.printer.try_send(text).is_err() {
            // The queue is full; one more notice would add nothing.
        }
    }

    /// Redraws the prompt, which has changed.
    pub fn repaint(&self) {
        (self.repaint)();
    }
}

impl Editor {
    /// An editor whose prompt shows the state of the monitor.
    pub fn start(feed: Arc<Feed>, remember: bool) -> Self {
        let printer = ExternalPrinter::new(NOTICES_MAX);
        let over = Arc::new(AtomicBool::new(false));
        let typing = Arc::new(AtomicBool::new(false));
        let sender = printer.sender();
        let mut line = reedline(remember).with_external_printer(printer);
        line = line.with_break_signal(over.clone());
        let signal = line.repaint_signal();
        let repaint = Arc::new(move || signal.request_repaint());
        let notices = Notices { printer: sender, repaint, typing: typing.clone() };
        let (ask, asked) = channel::<()>();
        let (sender, inputs) = unbounded_channel();
        std::thread::spawn(move || {
            let prompt = StatePrompt(feed);
            while asked.recv().is_ok() {
                typing.store(true, Ordering::Release);
                let input = match line.read_line(&prompt) {
                    Ok(Signal::Success(text)) => Input::Line(text),
                    Ok(Signal::CtrlC) => Input::CtrlC,
                    Ok(_) => Input::End,
                    Err(error) => Input::Failed(error),
                };
                typing.store(false, Ordering::Release);
                if sender.send(input).is_err() {
                    return;
                }
            }
        });
        Self { ask, inputs, notices, over }
    }

    /// A handle for notices.
    pub fn notices(&self) -> Notices {
        self.notices.clone()
    }

    /// Starts reading a line.
    pub fn ask(&self) {
        // `next` notices when the thread is gone.
        let _ = self.ask.send(());
    }

    /// The line started by [`Self::ask`].
    pub async fn next(&mut self) -> Input {
        self.inputs.recv().await.unwrap_or(Input::End)
    }

    /// Abandons the line being typed, and restores the terminal.
    pub async fn give_up(&mut self) {
        self.over.store(true, Ordering::Release);
        // A terminal that is gone may block the thread for ever.
        let _ = timeout(PATIENCE, self.next()).await;
    }
}

fn reedline(remember: bool) -> Reedline {
    let mut keys = default_emacs_keybindings();
    keys.add_binding(
        KeyModifiers::NONE,
        KeyCode::Tab,
        ReedlineEvent::UntilFound(vec![ReedlineEvent::Menu(MENU.into()), ReedlineEvent::MenuNext]),
    );
    keys.add_binding(KeyModifiers::SHIFT, KeyCode::BackTab, ReedlineEvent::MenuPrevious);
    let menu = ColumnarMenu::default().with_name(MENU).with_marker("> ").with_columns(1);
    let line = Reedline::create()
        .with_completer(Box::new(Grammar::new()))
        .with_quick_completions(true)
        .with_partial_completions(true)
        .with_menu(ReedlineMenu::EngineCompleter(Box::new(menu)))
        .with_hinter(Box::new(DefaultHinter::default()))
        .with_edit_mode(Box::new(Emacs::new(keys)));
    let file = history_file().filter(|_| remember);
    // Without a file, the lines of this session are still kept in memory.
    match file.and_then(|file| FileBackedHistory::with_file(HISTORY_MAX, file).ok()) {
        Some(history) => line.with_history(Box::new(history)),
        None => line,
    }
}

/// File with the lines of earlier sessions.
fn history_file() -> Option<PathBuf> {
    Some(state::folder()?.join("history"))
}

/// `10.0.0.5:10485/1 deployed> `
struct StatePrompt(Arc<Feed>);

impl Prompt for StatePrompt {
    fn render_prompt_left(&self) -> Cow<'_, str> {
        let seen = self.0.seen();
        let unknown = if seen.stale { "?" } else { "" };
        format!("{} {}{unknown}", seen.name, seen.condition()).into()
    }

    fn render_prompt_right(&self) -> Cow<'_, str> {
        "".into()
    }

    fn render_prompt_indicator(&self, _: PromptEditMode) -> Cow<'_, str> {
        "> ".into()
    }

    fn render_prompt_multiline_indicator(&self) -> Cow<'_, str> {
        "… ".into()
    }

    fn render_prompt_history_search_indicator(&self, search: PromptHistorySearch) -> Cow<'_, str> {
        format!("({}) ", search.term).into()
    }
}
