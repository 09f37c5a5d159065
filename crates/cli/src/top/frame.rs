//! The frame around the pages: title, keys, and Stop, which is always visible.

use lafet_proto::flags::Severity;
use ratatui::backend::TestBackend;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};
use ratatui::{Frame, Terminal};

use super::scene::{Page, Scene};
use super::words::cut;
use super::{detail, link, list};
use crate::lang::pick;

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
        (Page::List, pick("1 list", "1 список")),
        (Page::Detail, pick("2 monitor", "2 ствол")),
        (Page::Link, pick("3 link", "3 линия")),
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
    spans.push(Span::raw(pick(
        format!("  {selected} of {count}"),
        format!("  {selected} из {count}"),
    )));
    if alarms > 0 {
        let text = pick(format!("  alarms: {alarms}"), format!("  тревога: {alarms}"));
        spans.push(Span::styled(text, Style::new().fg(Color::Red)));
    }
    if stale > 0 {
        let text = pick(format!("  stale: {stale}"), format!("  устарело: {stale}"));
        spans.push(Span::styled(text, Style::new().fg(Color::Yellow)));
    }
    Line::from(spans)
}

fn keys_line() -> &'static str {
    pick(
        " ↑↓ monitor  Tab page  1 2 3  PgUp PgDn scroll  ? keys  q quit",
        " ↑↓ ствол  Tab страница  1 2 3  PgUp PgDn прокрутка  ? клавиши  q выход",
    )
}

fn stop_line(scene: &Scene, width: u16) -> Line<'static> {
    let name = scene.current().map_or("", |seen| seen.name.as_str());
    let text = pick(format!(" s  STOP ALL: {name} "), format!(" s (ы)  СТОП ВСЕ: {name} "));
    let look = Style::new().bg(Color::Red).fg(Color::White).add_modifier(Modifier::BOLD);
    Line::styled(cut(&text, width.into()), look)
}

fn help(frame: &mut Frame<'_>, page: Rect) {
    let lines = pick(
        [
            "s            Stop All for the selected monitor, on every page",
            "↑ ↓  k j     previous, next monitor",
            "Tab Shift+Tab  next, previous page",
            "1 2 3        list, monitor, link;  Enter: monitor,  Esc: list",
            "PgUp PgDn    scroll what does not fit",
            "q  Ctrl-C    quit; this stops nothing",
            "",
            "!  warning   !! alarm   grey: stale, may have changed since",
            "Stop is the only request of this screen that changes anything.",
        ],
        [
            "s (ы)        Stop All выбранному стволу, на любой странице",
            "↑ ↓  k j     предыдущий, следующий ствол",
            "Tab Shift+Tab  следующая, предыдущая страница",
            "1 2 3        список, ствол, линия;  Enter: ствол,  Esc: список",
            "PgUp PgDn    прокрутить то, что не поместилось",
            "q  Ctrl-C    выход; этим ничего не останавливается",
            "",
            "!  предупреждение   !! тревога   серое: устарело, может быть уже не так",
            "Stop — единственный запрос этого экрана, который что-либо меняет.",
        ],
    );
    let widest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let size = |wanted: usize, most: u16| u16::try_from(wanted + 2).unwrap_or(most).min(most);
    let (width, height) = (size(widest + 2, page.width), size(lines.len(), page.height));
    let area = page.centered(Constraint::Length(width), Constraint::Length(height));
    frame.render_widget(Clear, area);
    let block = Block::bordered().title(pick(" keys ", " клавиши "));
    let text = lines.map(|line| Line::raw(format!(" {line}")));
    frame.render_widget(Paragraph::new(text.to_vec()).block(block), area);
}
