//! One moment of the demonstration as an SVG file, for documents.

use std::fmt::Write as _;
use std::path::PathBuf;

use lafet_texts::cli as text;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};

use super::picture::render;
use super::scene::{Line, Scene, View};
use crate::failure::Failure;
use crate::lang::current;

/// Size of the drawn terminal, characters.
const COLUMNS: u16 = 120;
const ROWS: u16 = 40;
/// Size of a character, px.
const CELL: (u32, u32) = (9, 19);
const MARGIN: u32 = 12;
const BACKGROUND: &str = "#14181d";
const FOREGROUND: &str = "#d5dae0";

/// Draws the scene once, at the chosen moment or at the end if that comes first.
pub struct Drawing {
    path: PathBuf,
    at_ms: u64,
    done: bool,
}

impl Drawing {
    /// Prepares to write `path` at this simulated time, ms.
    pub fn new(path: PathBuf, at_ms: u64) -> Self {
        Self { path, at_ms, done: false }
    }

    fn write(&mut self, scene: &Scene) -> Result<(), Failure> {
        self.done = true;
        let mut terminal =
            Terminal::new(TestBackend::new(COLUMNS, ROWS)).unwrap_or_else(|never| match never {});
        let drawn = terminal.draw(|frame| render(frame, scene));
        drawn.map(|_| ()).unwrap_or_else(|never| match never {});
        std::fs::write(&self.path, svg(terminal.backend().buffer())).map_err(|error| {
            let path = self.path.display();
            let what = text::CannotWritePicture.str(current());
            Failure::io(format!("{what} {path}"), error)
        })
    }
}

impl View for Drawing {
    fn line(&mut self, _: &Line) -> Result<(), Failure> {
        Ok(())
    }

    fn draw(&mut self, scene: &Scene) -> Result<(), Failure> {
        if self.done || scene.now_ms < self.at_ms { Ok(()) } else { self.write(scene) }
    }

    fn wants_to_leave(&mut self) -> bool {
        false
    }

    fn close(&mut self, scene: &Scene, _: bool) -> Result<(), Failure> {
        if self.done { Ok(()) } else { self.write(scene) }
    }
}

/// The characters as runs of one style, each placed by its column.
fn svg(buffer: &Buffer) -> String {
    let (width, height) = (u32::from(COLUMNS) * CELL.0, u32::from(ROWS) * CELL.1);
    let (full_width, full_height) = (width + 2 * MARGIN, height + 2 * MARGIN);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {full_width} {full_height}\" \
         font-family=\"'DejaVu Sans Mono','Menlo','Consolas',monospace\" font-size=\"15\">\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"{BACKGROUND}\"/>\n"
    );
    for row in 0..ROWS {
        let cells = (0..COLUMNS).map(|column| &buffer[(column, row)]);
        let cells: Vec<&Cell> = cells.collect();
        let mut start = 0;
        for run in cells.chunk_by(|left, right| look(left) == look(right)) {
            write_run(&mut out, u32::from(row), start, run);
            start += run.len() as u32;
        }
    }
    out.push_str("</svg>\n");
    out
}

type Look = (Color, Color, Modifier);

fn look(cell: &Cell) -> Look {
    (cell.fg, cell.bg, cell.modifier)
}

fn write_run(out: &mut String, row: u32, start: u32, run: &[&Cell]) {
    let Some(first) = run.first() else { return };
    let (x, y) = (MARGIN + start * CELL.0, MARGIN + row * CELL.1);
    let width = run.len() as u32 * CELL.0;
    // Writing to a String cannot fail.
    if first.bg != Color::Reset {
        let (fill, height) = (color(first.bg), CELL.1);
        let _ = writeln!(
            out,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\"/>"
        );
    }
    let text: String = run.iter().map(|cell| cell.symbol()).collect();
    if text.trim().is_empty() {
        return;
    }
    let weight = if first.modifier.contains(Modifier::BOLD) { " font-weight=\"bold\"" } else { "" };
    let baseline = y + CELL.1 - 5;
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{baseline}\" textLength=\"{width}\" lengthAdjust=\"spacingAndGlyphs\" \
         xml:space=\"preserve\" fill=\"{}\"{weight}>{}</text>",
        color(first.fg),
        escaped(&text)
    );
}

fn color(color: Color) -> &'static str {
    match color {
        Color::Black => "#0b0e12",
        Color::Red | Color::LightRed => "#ef6b62",
        Color::Green | Color::LightGreen => "#7fc97a",
        Color::Yellow | Color::LightYellow => "#e5c15d",
        Color::Blue | Color::LightBlue => "#4f8fd9",
        Color::Magenta | Color::LightMagenta => "#c08ad6",
        Color::Cyan | Color::LightCyan => "#62c4cf",
        Color::Gray => "#aab2bb",
        Color::DarkGray => "#78828d",
        Color::White => "#ffffff",
        _ => FOREGROUND,
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
