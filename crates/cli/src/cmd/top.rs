//! `lafet top`: several monitors on one screen, live.

use std::io::{self, IsTerminal};
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use lafet_client::{Endpoint, Error};
use lafet_texts::cli as text;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use serde_json::json;
use tokio::task::JoinSet;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep, timeout};

use super::status;
use crate::cli::{Global, seconds};
use crate::connect::url_of;
use crate::exchange;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::keyboard::Keys;
use crate::lang::current;
use crate::out::{Out, complain};
use crate::top::feed::Feed;
use crate::top::scene::{Connected, Page, Scene, Seen};
use crate::top::{plain, render};

/// Interval at which the screen is redrawn.
const DRAW: Duration = Duration::from_millis(200);
/// How long a notice is shown.
const NOTICE: Duration = Duration::from_secs(8);
/// Interval at which `--once` checks whether everything has arrived.
const LOOK: Duration = Duration::from_millis(10);
/// Reads are tried three times, plus one timeout for the link itself.
const TRIES: u32 = 4;
/// Lines scrolled by one key press.
const SCROLL: u16 = 5;

/// Arguments of `lafet top`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet top tcp://10.0.0.5 tcp://10.0.0.6\n  lafet top \
                        \"serial:///dev/ttyUSB0?addr=1\" \"serial:///dev/ttyUSB0?addr=2\"\n  lafet \
                        top sim: --once --page detail")]
pub struct TopArgs {
    #[arg(value_name = "URL")]
    monitors: Vec<String>,
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5, value_parser = every)]
    interval: f64,
    #[arg(long, value_name = "PAGE", value_enum, default_value_t = Page::List)]
    page: Page,
    #[arg(long)]
    once: bool,
    #[arg(long, value_name = "WxH", default_value = "80x24", value_parser = size)]
    size: (u16, u16),
}

fn every(text: &str) -> Result<f64, String> {
    seconds(text, 0.05)
}

fn size(text: &str) -> Result<(u16, u16), String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'х'])?;
        let (width, height) = (width.parse().ok()?, height.parse().ok()?);
        ((20..=1000).contains(&width) && (3..=1000).contains(&height)).then_some((width, height))
    };
    parse().ok_or_else(|| text::SizeExpected.str(current()).into())
}

/// Runs `lafet top` until q.
pub async fn run(args: TopArgs, global: &Global, out: &mut Out) -> Outcome {
    let period = Duration::from_secs_f64(args.interval);
    let shared = global.open.as_ref().filter(|_| args.monitors.is_empty());
    let endpoints = if shared.is_some() { Vec::new() } else { endpoints(&args, global)? };
    let on_screen = io::stdout().is_terminal() && io::stdin().is_terminal() && !out.json();
    if !args.once && !on_screen {
        return Err(Failure::Usage(text::TopNeedsTerminal.str(current()).into()));
    }
    let feeds = match shared {
        Some((_, open)) => vec![Feed::over(open, period)?],
        None => Feed::start(&endpoints, global, period),
    };
    if args.once {
        return once(&args, &feeds, global, out).await;
    }
    let scene = Scene { page: args.page, ..Scene::default() };
    let mut top = Top { feeds, scene, noted: None, stops: JoinSet::new() };
    let outcome = top.run().await;
    let patience = Duration::from_secs_f64(global.timeout) * TRIES;
    top.see_stops_through(patience).await.and(outcome)
}

fn endpoints(args: &TopArgs, global: &Global) -> Result<Vec<Endpoint>, Failure> {
    let urls: Vec<&str> = match args.monitors.as_slice() {
        [] => vec![url_of(global)?],
        urls => urls.iter().map(String::as_str).collect(),
    };
    let endpoint = |url| Ok(Endpoint::from_str(url).map_err(Error::from)?);
    urls.into_iter().map(endpoint).collect()
}

/// Prints one picture, once every monitor has answered or failed.
async fn once(args: &TopArgs, feeds: &[Feed], global: &Global, out: &mut Out) -> Outcome {
    let (closer, figures) = (args.page == Page::Detail, args.page == Page::Link);
    let patience = Duration::from_secs_f64(global.timeout) * TRIES + Duration::from_secs(2);
    let began = Instant::now();
    loop {
        feeds.iter().for_each(|feed| feed.look_closer(closer));
        let settled = feeds.iter().all(|feed| feed.is_settled(closer, figures));
        if settled || began.elapsed() > patience {
            break;
        }
        sleep(LOOK).await;
    }
    if let Some(failure) = feeds.iter().find_map(Feed::hopeless) {
        return Err(failure);
    }
    let monitors: Vec<Seen> = feeds.iter().map(Feed::seen).collect();
    let silent = monitors.iter().filter(|seen| !seen.is_known());
    let silent: Vec<String> = silent.map(|seen| seen.name.clone()).collect();
    if out.json() {
        for seen in &monitors {
            out.value(&to_json(seen))?;
        }
    } else {
        let scene = Scene { page: args.page, monitors, ..Scene::default() };
        out.say(plain(&scene, args.size.0, args.size.1))?;
    }
    match silent.as_slice() {
        [] => Ok(()),
        names => {
            let names = names.join(", ");
            let text = text::StateNotKnown.str(current());
            Err(Failure::Silent(format!("{names}: {text}.")))
        }
    }
}

fn to_json(seen: &Seen) -> serde_json::Value {
    let known = seen.is_known();
    let down = match &seen.connected {
        Connected::Down(why) => Some(why.clone()),
        _ => None,
    };
    json!({
        "url": seen.url,
        "connected": seen.connected == Connected::Up,
        "error": down.or_else(|| seen.error.clone()),
        "age_s": known.then(|| (seen.age.as_secs_f64() * 1000.0).round() / 1000.0),
        "stale": seen.stale,
        "status": status::json(&seen.answers),
    })
}

/// The running dashboard.
struct Top {
    feeds: Vec<Feed>,
    scene: Scene,
    /// When the notice was set.
    noted: Option<Instant>,
    /// Stops that were sent, each with the notice of its outcome.
    stops: JoinSet<Stopped>,
}

/// The outcome of a Stop.
struct Stopped {
    notice: String,
    answered: bool,
}

impl Top {
    async fn run(&mut self) -> Outcome {
        let mut interrupt = Interrupt::catch()?;
        let cannot = |error| Failure::io(text::CannotDraw.str(current()), error);
        let mut terminal = ratatui::try_init().map_err(cannot)?;
        let restore = Restore;
        let mut keys = Keys::listen();
        let mut draw = interval(DRAW);
        draw.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            self.look();
            if let Some(failure) = self.feeds.iter().find_map(Feed::hopeless) {
                drop((keys, restore));
                return Err(failure);
            }
            terminal.draw(|frame| render(frame, &self.scene))?;
            tokio::select! {
                () = interrupt.wait() => return Ok(()),
                _ = draw.tick() => {}
                Some(Ok(stopped)) = self.stops.join_next() => self.note(stopped.notice),
                key = keys.next() => match key.map(|key| self.press(key.event)) {
                    None | Some(Pressed::Quit) => return Ok(()),
                    Some(Pressed::Stop) => self.stop(),
                    Some(Pressed::Other) => {}
                },
            }
        }
    }

    /// Updates the scene from the feeds.
    fn look(&mut self) {
        for (index, feed) in self.feeds.iter().enumerate() {
            feed.look_closer(self.scene.page == Page::Detail && index == self.scene.selected);
        }
        self.scene.monitors = self.feeds.iter().map(Feed::seen).collect();
        if self.noted.is_some_and(|noted| noted.elapsed() > NOTICE) {
            (self.noted, self.scene.notice) = (None, None);
        }
    }

    fn note(&mut self, notice: String) {
        (self.noted, self.scene.notice) = (Some(Instant::now()), Some(notice));
    }

    fn press(&mut self, key: KeyEvent) -> Pressed {
        press(&mut self.scene, key)
    }

    /// Sends Stop All to the selected monitor, and reports the outcome as a notice.
    fn stop(&mut self) {
        let Some(feed) = self.feeds.get(self.scene.selected) else { return };
        let name = feed.name().to_owned();
        let Some(stop) = feed.stop() else {
            let text = text::StopNotSent.str(current());
            return self.note(format!("{name}: {text}"));
        };
        self.note(format!("{name}: Stop All …"));
        self.stops.spawn(async move {
            let (text, answered) = match stop.await {
                Ok(answers) => (exchange::stop_all(&answers).replace('\n', "; "), true),
                Err(failure) => (failure.message(), false),
            };
            Stopped { notice: format!("{name}: {text}"), answered }
        });
    }

    /// Waits for the Stops that are not answered yet, and reports each.
    async fn see_stops_through(&mut self, patience: Duration) -> Outcome {
        let until = Instant::now() + patience;
        let mut outcome = Ok(());
        while !self.stops.is_empty() {
            let left = until.saturating_duration_since(Instant::now());
            let Ok(Some(stopped)) = timeout(left, self.stops.join_next()).await else {
                return Err(Failure::NotAtRest(text::StopNotAnswered.str(current()).into()));
            };
            match stopped {
                Ok(Stopped { notice, answered: true }) => complain(notice),
                Ok(Stopped { notice, .. }) => outcome = Err(Failure::NotAtRest(notice)),
                Err(error) => outcome = Err(Failure::NotAtRest(error.to_string())),
            }
        }
        outcome
    }
}

/// Restores the terminal on drop.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        // A terminal that is gone needs no restoring.
        let _ = ratatui::try_restore();
    }
}

/// A key press that does more than change the view.
#[derive(Debug, PartialEq, Eq)]
enum Pressed {
    Stop,
    Quit,
    Other,
}

/// Keys of a Russian layout count as those at the same position on the keyboard.
fn press(scene: &mut Scene, key: KeyEvent) -> Pressed {
    if key.kind == KeyEventKind::Release {
        return Pressed::Other;
    }
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    let last = scene.monitors.len().saturating_sub(1);
    let (before, after) = (scene.selected, scene.page);
    match key.code {
        KeyCode::Char('c' | 'с') if control => return Pressed::Quit,
        KeyCode::Char('q' | 'Q' | 'й' | 'Й') => return Pressed::Quit,
        KeyCode::Char('s' | 'S' | 'ы' | 'Ы') => return Pressed::Stop,
        KeyCode::Char('?' | 'h' | 'р') | KeyCode::F(1) => scene.help = !scene.help,
        KeyCode::Esc if scene.help => scene.help = false,
        KeyCode::Esc | KeyCode::Char('1') => scene.page = Page::List,
        KeyCode::Enter | KeyCode::Char('2') => scene.page = Page::Detail,
        KeyCode::Char('3') => scene.page = Page::Link,
        KeyCode::Tab => scene.page = turned(scene.page, 1),
        KeyCode::BackTab => scene.page = turned(scene.page, 2),
        KeyCode::Up | KeyCode::Char('k' | 'л') => {
            scene.selected = scene.selected.saturating_sub(1);
        }
        KeyCode::Down | KeyCode::Char('j' | 'о') => {
            scene.selected = (scene.selected + 1).min(last);
        }
        KeyCode::Home => scene.selected = 0,
        KeyCode::End => scene.selected = last,
        KeyCode::PageUp => scene.scroll = scene.scroll.saturating_sub(SCROLL),
        KeyCode::PageDown => scene.scroll = scene.scroll.saturating_add(SCROLL).min(SCROLL * 20),
        _ => {}
    }
    if (before, after) != (scene.selected, scene.page) {
        scene.scroll = 0;
    }
    Pressed::Other
}

fn turned(page: Page, by: usize) -> Page {
    let pages = [Page::List, Page::Detail, Page::Link];
    pages[(page as usize + by) % pages.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let monitors = (0..3).map(|_| Seen::default()).collect();
        Scene { monitors, ..Scene::default() }
    }

    #[test]
    fn keys_turn_pages_and_choose_monitors() {
        let mut scene = scene();
        let press = |scene: &mut Scene, code| press(scene, KeyEvent::from(code));
        for (code, selected, page) in [
            (KeyCode::Down, 1, Page::List),
            (KeyCode::End, 2, Page::List),
            (KeyCode::Down, 2, Page::List),
            (KeyCode::Enter, 2, Page::Detail),
            (KeyCode::Tab, 2, Page::Link),
            (KeyCode::Tab, 2, Page::List),
            (KeyCode::BackTab, 2, Page::Link),
            (KeyCode::Char('k'), 1, Page::Link),
            (KeyCode::Esc, 1, Page::List),
        ] {
            assert_eq!(press(&mut scene, code), Pressed::Other);
            assert_eq!((scene.selected, scene.page), (selected, page), "{code:?}");
        }
        press(&mut scene, KeyCode::PageDown);
        assert_eq!(scene.scroll, SCROLL);
        press(&mut scene, KeyCode::Up);
        assert_eq!(scene.scroll, 0, "another monitor starts unscrolled");
    }

    /// `s` on every page, with the keys explained or not, in both layouts; no other key stops
    /// anything.
    #[test]
    fn one_key_stops() {
        for (page, help) in [(Page::List, false), (Page::Detail, true), (Page::Link, false)] {
            for code in (' '..='~').chain('А'..='я').map(KeyCode::Char) {
                let mut scene = Scene { page, help, ..scene() };
                let stops = press(&mut scene, KeyEvent::from(code)) == Pressed::Stop;
                let KeyCode::Char(letter) = code else { panic!() };
                assert_eq!(stops, "sSыЫ".contains(letter), "{letter}");
            }
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(size("120x40"), Ok((120, 40)));
        assert_eq!(size("120х40"), Ok((120, 40)), "a Cyrillic letter");
        for wrong in ["80", "x", "0x0", "80x", "5000x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
