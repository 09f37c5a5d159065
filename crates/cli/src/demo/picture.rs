//! The demonstration as a picture in the terminal.

use std::io::{self, Write};
use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{Severity, flags_of};
use lafet_proto::status::Hotbed;
use lafet_texts::{Text as _, cli as text};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line as TextLine, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use ratatui::{DefaultTerminal, Frame};

use super::plan;
use super::scene::{Kind, Line, Scene, View};
use crate::angle;
use crate::describe::tenths;
use crate::failure::Failure;
use crate::lang::current;

/// Width of the states beside the plan.
const STATES_WIDTH: u16 = 50;
/// Lines of the log below both.
const LOG_LINES: u16 = 10;

/// The terminal while the picture is shown; restored on drop.
pub struct Picture {
    terminal: DefaultTerminal,
}

impl Picture {
    /// Takes over the terminal.
    pub fn open() -> Result<Self, Failure> {
        let cannot = |error| Failure::io(text::CannotDraw.str(current()), error);
        let terminal = ratatui::try_init().map_err(cannot)?;
        Ok(Self { terminal })
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        // A terminal that is gone needs no restoring.
        let _ = ratatui::try_restore();
    }
}

impl View for Picture {
    fn line(&mut self, _: &Line) -> Result<(), Failure> {
        Ok(())
    }

    fn draw(&mut self, scene: &Scene) -> Result<(), Failure> {
        self.terminal.draw(|frame| render(frame, scene))?;
        Ok(())
    }

    fn wants_to_leave(&mut self) -> bool {
        while event::poll(Duration::ZERO).unwrap_or(false) {
            // A terminal that cannot be read is gone.
            let Ok(event) = event::read() else { return true };
            let Event::Key(key) = event else { continue };
            let control = key.modifiers.contains(KeyModifiers::CONTROL);
            let leave = match key.code {
                KeyCode::Char('q' | 'й') | KeyCode::Esc => true,
                KeyCode::Char('c' | 'с') => control,
                _ => false,
            };
            if leave && key.kind == KeyEventKind::Press {
                return true;
            }
        }
        false
    }

    fn close(&mut self, scene: &Scene, to_the_end: bool) -> Result<(), Failure> {
        self.draw(scene)?;
        // A terminal that is gone needs no restoring.
        let _ = ratatui::try_restore();
        if to_the_end {
            return Ok(());
        }
        // The log that led to the end would vanish with the picture.
        let skip = scene.log.len().saturating_sub(usize::from(LOG_LINES));
        for line in scene.log.iter().skip(skip) {
            let Line { at_ms, kind, text } = line;
            let mark = kind.mark();
            writeln!(io::stderr(), "{:7.2} {mark} {text}", *at_ms as f64 / 1000.0)?;
        }
        Ok(())
    }
}

/// Draws the whole screen.
pub fn render(frame: &mut Frame<'_>, scene: &Scene) {
    let rows = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(8),
        Constraint::Length(LOG_LINES + 2),
    ]);
    let [title, middle, log] = rows.areas(frame.area());
    let columns = Layout::horizontal([Constraint::Max(STATES_WIDTH), Constraint::Min(20)]);
    let [states, map] = columns.areas(middle);
    frame.render_widget(title_line(scene), title);
    render_states(frame, scene, states);
    plan::render(frame, scene, map);
    render_log(frame, scene, log);
}

fn title_line(scene: &Scene) -> TextLine<'static> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let now_s = scene.now_ms as f64 / 1000.0;
    TextLine::from(vec![
        Span::styled(" lafet demo ", bold.bg(Color::Blue).fg(Color::White)),
        Span::raw(format!("  {now_s:6.1} {}  ", text::UnitS.str(current()))),
        Span::styled(scene.phase, bold.fg(Color::Yellow)),
        Span::raw(format!("   {}  seed {}   ", scene.url, scene.seed)),
        Span::styled(text::QQuits.str(current()), Style::new().fg(Color::DarkGray)),
    ])
}

fn render_states(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let order = [
        SubsystemId::DEPLOYER,
        SubsystemId::HORIZONTAL,
        SubsystemId::VERTICAL,
        SubsystemId::NOZZLE,
        SubsystemId::VALVE1,
        SubsystemId::CONTROL,
        SubsystemId::DETECTOR,
        SubsystemId::GENERAL,
    ];
    let mut lines: Vec<TextLine<'_>> = order.iter().map(|who| state_line(scene, *who)).collect();
    lines.push(TextLine::default());
    for (index, hotbed) in scene.hotbeds.iter().enumerate() {
        lines.push(hotbed_line(index, hotbed));
    }
    let block = Block::bordered().title(text::PictureMonitor.str(current()));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }).block(block), area);
}

fn state_line(scene: &Scene, who: SubsystemId) -> TextLine<'static> {
    let name = Span::styled(format!("{who:<11}"), Style::new().fg(Color::Gray));
    let answer = scene.states.get(&who).and_then(|answer| answer.decode().ok());
    let Some(answer) = answer else { return TextLine::from(name) };
    let value = match answer.data {
        Reply::Drive(status) => position(who, status.position, status.current),
        Reply::Deployer(status) => position(who, status.position, status.current),
        Reply::General(status) => {
            let pressure = tenths(i32::from(status.pressure));
            let flow = status.flowrate;
            text::PictureWater { pressure, flow }.of(current())
        }
        _ => String::new(),
    };
    let mut spans = vec![name, Span::styled(value, Style::new().add_modifier(Modifier::BOLD))];
    let bits = answer.data.flags_bits().unwrap_or(0);
    for flag in flags_of(who).set(bits) {
        spans.push(Span::raw(" "));
        spans.push(Span::styled(flag.to_string(), Style::new().fg(colour(flag.severity()))));
    }
    TextLine::from(spans)
}

fn position(who: SubsystemId, position: i16, amperes: u8) -> String {
    let position = match who {
        SubsystemId::NOZZLE => angle::show(who, i32::from(position)),
        _ => angle::degrees(i32::from(position)),
    };
    let amperes = tenths(i32::from(amperes));
    format!("{position:>8} {amperes:>4} {} ", text::UnitA.str(current()))
}

const fn colour(severity: Severity) -> Color {
    match severity {
        Severity::Info => Color::Green,
        Severity::Notice => Color::Cyan,
        Severity::Warning => Color::Yellow,
        Severity::Alarm => Color::Red,
    }
}

fn hotbed_line(index: usize, hotbed: &Hotbed) -> TextLine<'static> {
    let azimuth = angle::degrees(i32::midpoint(hotbed.x1, hotbed.x2));
    let elevation = angle::degrees(i32::midpoint(hotbed.y1, hotbed.y2));
    let (number, brightness) = (index + 1, hotbed.brightness);
    let text = text::PictureFireSpot { number, azimuth, elevation, brightness }.of(current());
    TextLine::from(Span::styled(text, Style::new().fg(Color::Red)))
}

fn render_log(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let room = usize::from(area.height.saturating_sub(2));
    let skip = scene.log.len().saturating_sub(room);
    let lines: Vec<TextLine<'_>> = scene.log.iter().skip(skip).map(log_line).collect();
    let block = Block::bordered().title(text::PictureExchange.str(current()));
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn log_line(line: &Line) -> TextLine<'_> {
    let style = match line.kind {
        Kind::Request => Style::new().fg(Color::Cyan),
        Kind::Answer => Style::new(),
        Kind::Refusal => Style::new().fg(Color::Red),
        Kind::World => Style::new().fg(Color::Yellow).add_modifier(Modifier::BOLD),
        Kind::Operator => Style::new().fg(Color::Magenta),
    };
    let time = format!("{:7.2} ", line.at_ms as f64 / 1000.0);
    TextLine::from(vec![
        Span::styled(time, Style::new().fg(Color::DarkGray)),
        Span::styled(format!("{} {}", line.kind.mark(), line.text), style),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::scene::Plan;
    use lafet_client::AnswerBuf;
    use lafet_proto::record::Record;
    use lafet_proto::{RequestId, Status};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn scene() -> Scene {
        let mut scene = Scene { phase: "quench", now_ms: 12_300, seed: 7, ..Scene::default() };
        let record = Record {
            request: RequestId::GET_STATUS,
            device: SubsystemId::HORIZONTAL,
            status: Status::OK,
            data: &[0, 0, 1, 0, 0x08, 0x07, 21, 10],
        };
        scene.learn(&[AnswerBuf::new(&record)]);
        scene.hotbeds = vec![Hotbed { x1: 1900, x2: 1700, y1: -200, y2: -20, brightness: 1400 }];
        let text = "Open Valve1".to_owned();
        scene.note(Line { at_ms: 12_250, kind: Kind::Request, text });
        scene.world = Plan {
            azimuth: 0.5,
            deployed: true,
            landing: None,
            fires: vec![((21.0, 12.0), 1.5, 1.0)],
        };
        scene
    }

    #[test]
    fn the_picture_shows_what_is_known() {
        let mut terminal = Terminal::new(TestBackend::new(110, 34)).unwrap();
        terminal.draw(|frame| render(frame, &scene())).unwrap();
        let shown = terminal.backend().to_string();
        for text in [
            "12.3 s",
            "quench",
            "Horizontal    30.0°  2.1 A",
            "Move",
            "fire spot 1: 30.0°",
            "12.25 → Open Valve1",
        ] {
            assert!(shown.contains(text), "{text}: {shown}");
        }
        let dots = |c: char| ('\u{2801}'..='\u{28FF}').contains(&c);
        assert!(shown.chars().filter(|c| dots(*c)).count() > 20, "{shown}");
    }

    #[test]
    fn a_small_terminal_is_no_trouble() {
        for (width, height) in [(1, 1), (20, 5), (60, 12), (400, 100)] {
            let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
            terminal.draw(|frame| render(frame, &scene())).unwrap();
        }
    }
}
