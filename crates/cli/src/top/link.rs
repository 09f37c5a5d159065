//! Statistics of the link, from `LinkStatistics`.

use std::time::Duration;

use lafet_client::Stats;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Paragraph, Sparkline};

use super::scene::{Connected, Scene, Seen};
use super::words::{left, right, style};
use crate::lang::pick;

/// Columns for the name of a counter.
const NAME: usize = 36;
const COUNT: usize = 12;

/// Draws the page.
pub fn render(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let Some(seen) = scene.current() else { return };
    let lines = lines(seen);
    let height = u16::try_from(lines.len()).unwrap_or(u16::MAX);
    let rows = Layout::vertical([Constraint::Length(height), Constraint::Min(0)]);
    let [counts, trips] = rows.areas(area);
    frame.render_widget(Paragraph::new(lines), counts);
    if trips.height < 2 {
        return;
    }
    let longest = seen.round_trips.iter().max().copied().unwrap_or(0);
    let title = format!(
        " {}: {} ",
        pick("round trip, a column a second; the longest", "задержка по секундам; наибольшая"),
        time(Some(Duration::from_micros(longest))),
    );
    let block = Block::new().borders(Borders::TOP).title(title);
    let room = usize::from(trips.width);
    let skip = seen.round_trips.len().saturating_sub(room);
    let line = Sparkline::default().data(&seen.round_trips[skip..]);
    frame.render_widget(line.block(block), trips);
}

fn lines(seen: &Seen) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let (state, look) = match &seen.connected {
        Connected::Soon => (pick("connecting", "соединение").to_owned(), Style::new()),
        Connected::Up => (pick("up", "есть связь").to_owned(), Style::new()),
        Connected::Down(why) => {
            let down = pick("down", "нет связи");
            (format!("{down}: {why}"), style(lafet_proto::flags::Severity::Alarm))
        }
    };
    let title = vec![Span::styled(format!("{}  ", seen.url), bold), Span::styled(state, look)];
    let mut lines = vec![Line::from(title)];
    let Some(figures) = &seen.figures else {
        let wait =
            pick("The first figures appear after a second.", "Первые цифры — через секунду.");
        lines.push(Line::raw(wait));
        return lines;
    };
    let heads = pick(["", "last second", "link", "monitor"], ["", "за секунду", "линия", "ствол"]);
    lines.push(row(heads.map(str::to_owned), bold));
    let [last, total, own] = [&figures.last, &figures.total, &seen.own].map(counts);
    for (index, (name, is_trouble)) in names().into_iter().enumerate() {
        let [last, total, own] = [last[index], total[index], own[index]];
        let look = match last {
            1.. if is_trouble => style(lafet_proto::flags::Severity::Warning),
            _ => Style::new(),
        };
        let cells = [name.to_owned(), last.to_string(), total.to_string(), own.to_string()];
        lines.push(row(cells, look));
    }
    let loss = |stats: &Stats| {
        let permille = stats.loss_permille();
        format!("{}.{} %", permille / 10, permille % 10)
    };
    let name = pick("frames sent without an answer", "запросы, оставшиеся без ответа");
    let cells = [name.into(), loss(&figures.last), loss(&figures.total), loss(&seen.own)];
    lines.push(row(cells, Style::new()));
    lines.push(round_trip(&figures.total));
    lines
}

fn row(cells: [String; 4], look: Style) -> Line<'static> {
    let [name, counts @ ..] = cells;
    let counts = counts.map(|count| right(&count, COUNT));
    Line::styled(format!("{}{}", left(&name, NAME), counts.concat()), look)
}

/// Names of the counters, and whether each indicates a problem.
fn names() -> [(&'static str, bool); 12] {
    [
        (pick("frames sent", "кадров послано"), false),
        (pick("frames received", "кадров принято"), false),
        (pick("answers accepted", "ответов принято"), false),
        (pick("frames with errors (CRC, form)", "кадров с ошибками (CRC, формат)"), true),
        (pick("answers not in time", "ответов не в срок"), true),
        (pick("frames repeated", "повторов"), true),
        (pick("late answers", "запоздалых ответов"), true),
        (pick("answers twice", "ответов повторно"), true),
        (pick("frames of other devices", "кадров других устройств"), false),
        (pick("answers to no request", "ответов без запроса"), true),
        (pick("collisions, echoes missing", "столкновений, нет эха"), true),
        (pick("reconnections", "повторных соединений"), true),
    ]
}

fn counts(stats: &Stats) -> [u64; 12] {
    [
        stats.frames_sent,
        stats.frames_received,
        stats.believed,
        stats.errors(),
        stats.timeouts,
        stats.retries,
        stats.late,
        stats.duplicates,
        stats.foreign,
        stats.unmatched,
        stats.collisions + stats.echoes_missing,
        stats.reconnects,
    ]
}

fn round_trip(stats: &Stats) -> Line<'static> {
    let names = pick(["last", "average", "min", "max"], ["последняя", "средняя", "мин", "макс"]);
    let values = [stats.rtt_last, stats.rtt_average, stats.rtt_min, stats.rtt_max];
    let parts: Vec<String> =
        names.iter().zip(values).map(|(name, value)| format!("{name} {}", time(value))).collect();
    Line::raw(format!("{}  {}", pick("round trip:", "задержка:"), parts.join(", ")))
}

fn time(time: Option<Duration>) -> String {
    let unit = pick("ms", "мс");
    time.map_or_else(|| "-".into(), |time| format!("{:.1} {unit}", time.as_secs_f64() * 1000.0))
}
