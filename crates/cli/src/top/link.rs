//! Statistics of the link, from `LinkStatistics`.

use std::time::Duration;

use lafet_client::Stats;
use lafet_texts::{Text as _, cli as text};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Paragraph, Sparkline};

use super::scene::{Connected, Scene, Seen};
use super::words::{left, right, style};
use crate::lang::{current, decimal};

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
        text::ChartTitle.str(current()),
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
        Connected::Soon => (text::LinkConnecting.str(current()).to_owned(), Style::new()),
        Connected::Up => (text::LinkUp.str(current()).to_owned(), Style::new()),
        Connected::Down(why) => {
            let down = text::LinkDown.str(current());
            (format!("{down}: {why}"), style(lafet_proto::flags::Severity::Alarm))
        }
    };
    let title = vec![Span::styled(format!("{}  ", seen.url), bold), Span::styled(state, look)];
    let mut lines = vec![Line::from(title)];
    let Some(figures) = &seen.figures else {
        let wait = text::FiguresLater.str(current());
        lines.push(Line::raw(wait));
        return lines;
    };
    let heads = [text::LastSecond.fixed(), text::LinkOfAll.fixed(), text::HeadingMonitor.fixed()];
    let [last, total, own] = heads.map(|head| head.of(current()));
    lines.push(row([String::new(), last, total, own], bold));
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
    let name = text::FramesUnanswered.str(current());
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
        (text::FramesSent.str(current()), false),
        (text::FramesReceived.str(current()), false),
        (text::AnswersAccepted.str(current()), false),
        (text::FramesWithErrors.str(current()), true),
        (text::AnswersNotInTime.str(current()), true),
        (text::FramesRepeated.str(current()), true),
        (text::LateAnswers.str(current()), true),
        (text::AnswersTwice.str(current()), true),
        (text::FramesOfOthers.str(current()), false),
        (text::AnswersToNothing.str(current()), true),
        (text::Collisions.str(current()), true),
        (text::Reconnections.str(current()), true),
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
    let names = [
        text::TripLast.fixed(),
        text::TripAverage.fixed(),
        text::TripMin.fixed(),
        text::TripMax.fixed(),
    ];
    let values = [stats.rtt_last, stats.rtt_average, stats.rtt_min, stats.rtt_max];
    let parts: Vec<String> = names
        .iter()
        .zip(values)
        .map(|(name, value)| format!("{} {}", name.str(current()), time(value)))
        .collect();
    Line::raw(format!("{}  {}", text::RoundTrip.str(current()), parts.join(", ")))
}

fn time(time: Option<Duration>) -> String {
    let unit = text::UnitMs.str(current());
    time.map_or_else(
        || "-".into(),
        |time| format!("{} {unit}", decimal(time.as_secs_f64() * 1000.0, 1)),
    )
}
