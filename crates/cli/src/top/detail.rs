//! One monitor: its axes between their limits, valves, programs, fire spots, climate.

use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{Severity, flags_of};
use lafet_proto::status::Limits;
use lafet_texts::cli as text;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::list::fault_lines;
use super::scene::{Scene, Seen};
use super::words::{BAD, GREY, age, left, position, right, style};
use crate::describe::{self, tenths};
use crate::lang::current;
use crate::out::columns;

/// Columns of an axis row without its bar.
const BESIDE_BAR: usize = 58;
const BAR_MAX: usize = 60;
/// Columns for the name of a subsystem.
const NAME: usize = 12;

/// Draws the page.
pub fn render(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let Some(seen) = scene.current() else { return };
    let lines = lines(seen, usize::from(area.width));
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    frame.render_widget(text.scroll((scene.scroll, 0)), area);
}

fn lines(seen: &Seen, width: usize) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut lines = vec![title(seen)];
    let drives = [
        SubsystemId::HORIZONTAL,
        SubsystemId::VERTICAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ];
    for who in drives {
        lines.extend(axis(seen, who, width));
    }
    let others = [
        SubsystemId::VALVE1,
        SubsystemId::VALVE2,
        SubsystemId::GENERAL,
        SubsystemId::CONTROL,
        SubsystemId::DETECTOR,
    ];
    lines.extend(others.iter().filter_map(|who| subsystem(seen, *who)));
    if !seen.hotbeds.is_empty() {
        lines.extend(hotbeds(seen));
    }
    lines.push(Line::styled(text::TopProblems.str(current()), bold));
    lines.extend(fault_lines(seen));
    lines.extend(climate(seen));
    let links = [
        SubsystemId::CLIMATICS,
        SubsystemId::EXTERNAL_CONN,
        SubsystemId::RADIO,
        SubsystemId::BUTTONS,
        SubsystemId::EXT_BUTTONS,
    ];
    lines.extend(links.iter().filter_map(|who| subsystem(seen, *who)));
    if seen.stale { lines.into_iter().map(|line| line.patch_style(GREY)).collect() } else { lines }
}

fn title(seen: &Seen) -> Line<'static> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut spans = vec![
        Span::styled(format!("{}  ", seen.name), bold),
        Span::styled(seen.condition(), style(seen.severity()).add_modifier(Modifier::BOLD)),
    ];
    if seen.is_known() {
        let old = if seen.stale { text::StaleFor.str(current()) } else { "" };
        let ago = text::StaleAgo.str(current());
        spans.push(Span::raw(format!("  {old}{} {ago}", age(seen.age))));
    }
    Line::from(spans)
}

/// A drive between its limits, and its flags.
fn axis(seen: &Seen, who: SubsystemId, width: usize) -> Vec<Line<'static>> {
    let Some((at, amperes, speed)) = seen.drive(who) else {
        return subsystem(seen, who).into_iter().collect();
    };
    let limits = seen.limits.iter().find(|(id, _)| *id == who).map(|(_, limits)| limits);
    let bar_width = width.saturating_sub(BESIDE_BAR).min(BAR_MAX);
    // Positive is left (§3.1): the bar shows the left of the monitor on the left.
    let mirrored = who == SubsystemId::HORIZONTAL;
    let (first, last, bar) = match limits {
        Some(limits) => {
            let (first, last) = match mirrored {
                true => (limits.max, limits.min),
                false => (limits.min, limits.max),
            };
            (position(who, first), position(who, last), bar(limits, at, bar_width, mirrored))
        }
        None => Default::default(),
    };
    let unit = match who {
        SubsystemId::NOZZLE => text::UnitMmps.str(current()),
        _ => text::UnitDegps.str(current()),
    };
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let bad = seen.is_bad(who, "position");
    let shown = if bad { BAD.to_owned() } else { position(who, at) };
    let amperes = format!("{} {}", tenths(amperes.into()), text::UnitA.str(current()));
    let mut lines = vec![Line::from(vec![
        Span::raw(left(&who.to_string(), NAME)),
        Span::styled(right(&shown, 8), if bad { GREY } else { bold }),
        Span::raw(format!("  {} {} ", right(&first, 8), left(&bar, bar_width))),
        Span::raw(left(&last, 8)),
        Span::raw(format!("{} {}", right(&amperes, 7), right(&format!("{speed} {unit}"), 8))),
    ])];
    let flags = flag_spans(seen, who);
    if !flags.is_empty() {
        let indent = std::iter::once(Span::raw(" ".repeat(NAME + 1)));
        lines.push(Line::from_iter(indent.chain(flags)));
    }
    lines
}

/// Position of a drive between its limits: `├──●─────┤`; mirrored with the greater limit at the
/// left.
fn bar(limits: &Limits, at: i32, width: usize, mirrored: bool) -> String {
    let inside = width.saturating_sub(2);
    let span = i64::from(limits.max) - i64::from(limits.min);
    if span <= 0 || inside == 0 {
        return String::new();
    }
    let from = (i64::from(at) - i64::from(limits.min)).clamp(0, span);
    let last = i64::try_from(inside - 1).unwrap_or(0);
    let from = if mirrored { span - from } else { from };
    let place = usize::try_from(from * last / span).unwrap_or(0);
    let cells = (0..inside).map(|cell| if cell == place { '●' } else { '─' });
    format!("├{}┤", cells.collect::<String>())
}

fn flag_spans(seen: &Seen, who: SubsystemId) -> Vec<Span<'static>> {
    let bits = seen.flags(who);
    let class = flags_of(who);
    let set = class.set(bits).map(|flag| {
        let mark = super::words::mark(flag.severity());
        Span::styled(format!("{mark}{flag} "), style(flag.severity()))
    });
    let unnamed = class.unnamed(bits);
    let unnamed = (unnamed != 0).then(|| Span::raw(format!("{unnamed:#x} ")));
    set.chain(unnamed).collect()
}

/// A subsystem in one line: its flags, then its values; `None` if it does not exist.
fn subsystem(seen: &Seen, who: SubsystemId) -> Option<Line<'static>> {
    let answer = seen.answers.iter().find(|answer| answer.from() == who)?;
    let mut spans = vec![Span::raw(left(&who.to_string(), NAME)), Span::raw(" ")];
    match seen.of(who) {
        Some(decoded) => {
            if !matches!(decoded.data, Reply::Thermo(_)) {
                let values = describe::values(&decoded);
                let gap = if values.is_empty() { "" } else { "  " };
                spans.push(Span::raw(format!("{values}{gap}")));
            }
            spans.extend(flag_spans(seen, who));
        }
        None => spans.push(Span::styled(answer.status().to_string(), style(Severity::Warning))),
    }
    Some(Line::from(spans))
}

fn hotbeds(seen: &Seen) -> Vec<Line<'static>> {
    let rows = columns(&describe::hotbed_rows(&seen.hotbeds));
    rows.lines().map(|row| Line::raw(row.to_owned())).collect()
}

fn climate(seen: &Seen) -> Option<Line<'static>> {
    let answer = seen.of(SubsystemId::CLIMATICS)?;
    Some(Line::raw(describe::values(&answer)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_shows_where_it_is() {
        let limits = Limits { min: -100, max: 100 };
        for (at, shown) in [
            (-100, "├●────┤"),
            (0, "├──●──┤"),
            (100, "├────●┤"),
            (500, "├────●┤"),
            (-500, "├●────┤"),
        ] {
            assert_eq!(bar(&limits, at, 7, false), shown, "{at}");
            let mirrored: String = shown.chars().rev().collect();
            let mirrored = mirrored.replace('┤', "x").replace('├', "┤").replace('x', "├");
            assert_eq!(bar(&limits, at, 7, true), mirrored, "{at}");
        }
        assert_eq!(bar(&limits, 0, 2, false), "");
        assert_eq!(bar(&Limits { min: 5, max: 5 }, 5, 9, false), "");
        let all = Limits { min: i32::MIN, max: i32::MAX };
        assert_eq!(bar(&all, i32::MAX, 5, false), "├──●┤");
    }
}
