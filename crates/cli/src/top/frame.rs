//! The frame around the pages: title, keys, and Stop, which is always visible.

use lafet_proto::flags::Severity;
use lafet_texts::{Text as _, cli as text};
use ratatui::backend::TestBackend;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};
use ratatui::{Frame, Terminal};

use super::scene::{Page, Scene};
use super::words::cut;
use super::{detail, link, list};
use crate::lang::current;

/// Draws the whole screen.
pub fn render(frame: &mut Frame<'_>, scene: &Scene) {
    let area = frame.area();
    // Stop first: a terminal of one line shows only that.
    let [above, stop] = Layout::vertical([Constraint::Min(0), Constraint::Length(1)]).areas(area);
    frame.render_widget(stop_line(scene, stop.width), stop);
    let notice = u16::from(scene.notice.is_some());
    let [title, page, notices, keys] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(0),
        Constraint::Length(notice),
        Constraint::Length(1),
    ])
    .areas(above);
    frame.render_widget(title_line(scene), title);
    match scene.page {
        Page::List => list::render(frame, scene, page),
        Page::Detail => detail::render(frame, scene, page),
        Page::Link => link::render(frame, scene, page),
    }
    if let Some(text) = &scene.notice {
        let look = Style::new().add_modifier(Modifier::REVERSED);
        frame.render_widget(Line::styled(format!(" {text} "), look), notices);
    }
    frame.render_widget(Line::styled(keys_line(), Style::new().fg(Color::DarkGray)), keys);
    if scene.help {
        help(frame, page);
    }
}

/// One picture as text, without trailing blanks.
pub fn plain(scene: &Scene, width: u16, height: u16) -> String {
    // Drawing to memory cannot fail.
    let Ok(mut terminal) = Terminal::new(TestBackend::new(width, height));
    let Ok(_) = terminal.draw(|frame| render(frame, scene));
    let buffer = terminal.backend().buffer();
    let cells: Vec<&str> = buffer.content().iter().map(ratatui::buffer::Cell::symbol).collect();
    let line = |cells: &[&str]| cells.concat().trim_end().to_owned();
    let lines: Vec<String> = cells.chunks(usize::from(width.max(1))).map(line).collect();
    lines.join("\n").trim_end().to_owned()
}

fn title_line(scene: &Scene) -> Line<'static> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut spans = vec![Span::styled(" lafet top ", bold.bg(Color::Blue).fg(Color::White))];
    let pages = [
        (Page::List, text::PageList.str(current())),
        (Page::Detail, text::PageMonitor.str(current())),
        (Page::Link, text::PageLink.str(current())),
    ];
    for (page, name) in pages {
        let (text, look) = match page == scene.page {
            true => (format!("[{name}]"), bold),
            false => (format!(" {name} "), Style::new()),
        };
        spans.push(Span::raw(" "));
        spans.push(Span::styled(text, look));
    }
    let alarms = scene.monitors.iter().filter(|seen| seen.severity() == Severity::Alarm).count();
    let stale = scene.monitors.iter().filter(|seen| seen.stale || !seen.is_known()).count();
    let (count, selected) = (scene.monitors.len(), scene.selected + 1);
    spans.push(Span::raw(text::ListSelected { selected, count }.of(current())));
    if alarms > 0 {
        let text = text::ListAlarms { alarms }.of(current());
        spans.push(Span::styled(text, Style::new().fg(Color::Red)));
    }
    if stale > 0 {
        let text = text::ListStale { stale }.of(current());
        spans.push(Span::styled(text, Style::new().fg(Color::Yellow)));
    }
    Line::from(spans)
}

fn keys_line() -> &'static str {
    text::TopKeys.str(current())
}

fn stop_line(scene: &Scene, width: u16) -> Line<'static> {
    let name = scene.current().map_or("", |seen| seen.name.as_str());
    let text = text::TopStopKey { name }.of(current());
    let look = Style::new().bg(Color::Red).fg(Color::White).add_modifier(Modifier::BOLD);
    Line::styled(cut(&text, width.into()), look)
}

fn help(frame: &mut Frame<'_>, page: Rect) {
    let lines: Vec<&str> = text::KeysHelp.str(current()).lines().collect();
    let widest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let size = |wanted: usize, most: u16| u16::try_from(wanted + 2).unwrap_or(most).min(most);
    let (width, height) = (size(widest + 2, page.width), size(lines.len(), page.height));
    let area = page.centered(Constraint::Length(width), Constraint::Length(height));
    frame.render_widget(Clear, area);
    let block = Block::bordered().title(text::KeysTitle.str(current()));
    let text: Vec<Line<'_>> = lines.iter().map(|line| Line::raw(format!(" {line}"))).collect();
    frame.render_widget(Paragraph::new(text).block(block), area);
}
