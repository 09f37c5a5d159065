//! Pieces of text and style that several pages share.

use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::flags::Severity;
use lafet_texts::cli as text;
use ratatui::style::{Color, Modifier, Style};

use super::scene::{Connected, Seen};
use crate::angle;
use crate::lang::{current, decimal};

/// Style of a severity.
pub const fn style(severity: Severity) -> Style {
    match severity {
        Severity::Info => Style::new(),
        Severity::Notice => Style::new().fg(Color::Cyan),
        Severity::Warning => Style::new().fg(Color::Yellow),
        Severity::Alarm => Style::new().fg(Color::Red).add_modifier(Modifier::BOLD),
    }
}

/// Style of stale values.
pub const GREY: Style = Style::new().fg(Color::DarkGray);

/// Mark of a severity, readable without colour.
pub const fn mark(severity: Severity) -> &'static str {
    match severity {
        Severity::Info | Severity::Notice => "",
        Severity::Warning => "!",
        Severity::Alarm => "!!",
    }
}

/// Shown instead of a value that a flag marks as invalid.
pub const BAD: &str = "??";

/// A position in its shortest clear form.
pub fn position(who: SubsystemId, position: i32) -> String {
    match who {
        SubsystemId::NOZZLE => angle::show(who, position),
        _ => angle::degrees(position),
    }
}

/// An age as text.
pub fn age(age: Duration) -> String {
    let (s, min) = (text::UnitS.str(current()), text::UnitMin.str(current()));
    let h = text::UnitH.str(current());
    match age.as_secs() {
        0..10 => format!("{} {s}", decimal(age.as_secs_f64(), 1)),
        secs @ 10..120 => format!("{secs} {s}"),
        secs @ 120..7200 => format!("{} {min}", secs / 60),
        secs => format!("{} {h}", secs / 3600),
    }
}

/// Why the monitor does not answer.
pub fn silence(seen: &Seen) -> Option<&str> {
    match (&seen.connected, &seen.error) {
        (Connected::Down(why), _) => Some(why),
        (_, Some(why)) => Some(why),
        (_, None) if seen.stale => Some(""),
        _ => None,
    }
}

/// Why the state shown is stale or missing.
pub fn trouble(seen: &Seen) -> Option<String> {
    let why = silence(seen)?;
    let stale = if seen.is_known() { text::SceneStale.str(current()) } else { "" };
    let parts: Vec<&str> = [stale, why].into_iter().filter(|part| !part.is_empty()).collect();
    Some(parts.join(": "))
}

/// Text cut to a number of columns.
pub fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(width.saturating_sub(1)).collect();
    short.push('…');
    short.chars().take(width).collect()
}

/// Text left-aligned in a number of columns.
pub fn left(text: &str, width: usize) -> String {
    format!("{:<width$}", cut(text, width))
}

/// Text right-aligned in a number of columns.
pub fn right(text: &str, width: usize) -> String {
    format!("{:>width$}", cut(text, width))
}
