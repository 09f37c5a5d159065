//! The list of monitors, and the problems of the selected one.

use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::Severity;
use lafet_texts::cli as text;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Paragraph, Wrap};

use super::scene::{Scene, Seen};
use super::words::{BAD, GREY, age, cut, left, mark, position, right, style, trouble};
use crate::describe::tenths;
use crate::lang::current;

/// Lines per monitor: its values, and its flags.
const ENTRY: usize = 2;
/// Columns of everything but the name.
const VALUES: usize = 61;
/// Least lines of the panel below.
const PANEL_MIN: u16 = 6;

/// Draws the list.
pub fn render(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let wanted = u16::try_from(1 + scene.monitors.len() * ENTRY).unwrap_or(u16::MAX);
    let most = area.height.saturating_sub(PANEL_MIN).max(area.height.min(3));
    let rows = Layout::vertical([Constraint::Length(wanted.min(most)), Constraint::Min(0)]);
    let [list, panel] = rows.areas(area);
    let width = usize::from(list.width);
    let room = (usize::from(list.height).saturating_sub(1) / ENTRY).max(1);
    // The selected one is always visible.
    let first = (scene.selected + 1).saturating_sub(room);
    let mut lines = vec![header(width)];
    for (index, seen) in scene.monitors.iter().enumerate().skip(first).take(room) {
        lines.extend(entry(seen, index == scene.selected, width));
    }
    frame.render_widget(Paragraph::new(lines), list);
    if let Some(seen) = scene.current() {
        faults(frame, scene, seen, panel);
    }
}

fn header(width: usize) -> Line<'static> {
    let cells = [
        text::HeadingMonitor.str(current()),
        text::ColumnState.str(current()),
        text::ColumnHorizontal.str(current()),
        text::ColumnVertical.str(current()),
        text::PlaceNozzle.str(current()),
        text::UnitAtm.str(current()),
        text::UnitLps.str(current()),
        text::ColumnAge.str(current()),
    ];
    let text = columns("", "", cells, width);
    Line::styled(cut(&text, width), Style::new().add_modifier(Modifier::UNDERLINED))
}

fn columns(select: &str, mark: &str, cells: [&str; 8], width: usize) -> String {
    let [name, state, horizontal, vertical, nozzle, pressure, flow, age] = cells;
    let name_width = width.saturating_sub(VALUES).max(8);
    [
        left(select, 1),
        right(mark, 2),
        left(name, name_width),
        left(state, 12),
        right(horizontal, 7),
        right(vertical, 7),
        right(nozzle, 7),
        right(pressure, 4),
        right(flow, 4),
        right(age, 8),
    ]
    .join(" ")
}

fn entry(seen: &Seen, selected: bool, width: usize) -> [Line<'static>; ENTRY] {
    // An invalid value is not shown as a number, which could be misread in passing.
    let shown = |who, field, text: String| if seen.is_bad(who, field) { BAD.into() } else { text };
    let at = |who| {
        let known = seen.drive(who);
        known.map_or_else(String::new, |(at, ..)| shown(who, "position", position(who, at)))
    };
    let general = |field, text| shown(SubsystemId::GENERAL, field, text);
    let (pressure, flow) = match seen.of(SubsystemId::GENERAL).map(|answer| answer.data) {
        Some(Reply::General(s)) => (
            general("pressure", tenths(s.pressure.into())),
            general("flowrate", s.flowrate.to_string()),
        ),
        _ => Default::default(),
    };
    let severity = seen.severity();
    let old = if seen.is_known() { age(seen.age) } else { String::new() };
    let cells = [
        seen.name.as_str(),
        seen.condition(),
        &at(SubsystemId::HORIZONTAL),
        &at(SubsystemId::VERTICAL),
        &at(SubsystemId::NOZZLE),
        &pressure,
        &flow,
        &old,
    ];
    let text = columns(if selected { "▶" } else { "" }, mark(severity), cells, width);
    let mut look = if seen.stale { GREY } else { style(severity) };
    if selected {
        look = look.add_modifier(Modifier::REVERSED);
    }
    [Line::styled(left(&text, width), look), flags(seen, width)]
}

/// The flags that are set, the worst first; or why the state is not known.
fn flags(seen: &Seen, width: usize) -> Line<'static> {
    let mut spans = vec![Span::raw("     ")];
    let mut left = width.saturating_sub(5);
    if let Some(trouble) = trouble(seen) {
        let look = if seen.is_known() { GREY } else { style(Severity::Alarm) };
        let text = format!("{} ", cut(&trouble, left));
        left = left.saturating_sub(text.chars().count());
        spans.push(Span::styled(text, look));
    }
    for (severity, text) in seen.flag_names() {
        if left == 0 {
            break;
        }
        let mark = mark(severity);
        let text = cut(&format!("{mark}{text}  "), left);
        left -= text.chars().count();
        spans.push(Span::styled(text, if seen.stale { GREY } else { style(severity) }));
    }
    Line::from(spans)
}

fn faults(frame: &mut Frame<'_>, scene: &Scene, seen: &Seen, area: Rect) {
    let title = format!(" {}: {} ", seen.name, text::ListProblems.str(current()));
    let block = Block::new().borders(Borders::TOP).title(title);
    let text = Paragraph::new(fault_lines(seen)).wrap(Wrap { trim: true });
    frame.render_widget(text.scroll((scene.scroll, 0)).block(block), area);
}

/// The faults, with what to do about them.
pub fn fault_lines(seen: &Seen) -> Vec<Line<'static>> {
    let look = |severity| if seen.stale { GREY } else { style(severity) };
    let mut lines = Vec::new();
    if let Some(trouble) = trouble(seen) {
        lines.push(Line::styled(trouble, style(Severity::Alarm)));
    }
    for (severity, text) in seen.faults() {
        lines.push(Line::styled(text, look(severity)));
    }
    if lines.is_empty() && seen.is_known() {
        let nothing = text::NoProblems.str(current());
        lines.push(Line::raw(nothing));
    }
    lines
}
