//! Drawing: SVG elements, colours, widths of text.

use core::fmt::Write as _;

/// Strong ink.
pub const INK: &str = "#1c2126";
/// Soft ink.
pub const SOFT: &str = "#5b6570";
/// Faint ink.
pub const FAINT: &str = "#c9ced4";
/// Lines of a grid.
pub const GRID: &str = "#e6e8eb";
/// The paper.
pub const PAPER: &str = "#ffffff";
/// The ground of a plan.
pub const GROUND: &str = "#f7f7f4";
/// Tanks and walls.
pub const STEEL: &str = "#d9dcdf";

/// Okabe and Ito's palette, which all eyes tell apart; each also has its own dashes.
pub const MONITORS: [(&str, &str); 6] = [
    ("#0072b2", ""),
    ("#009e73", "7 3"),
    ("#a0508a", "2 3"),
    ("#56b4e9", "9 3 2 3"),
    ("#1c2126", "5 2"),
    ("#8a7a00", "3 2"),
];
/// Fires, each with dashes too.
pub const FIRES: [(&str, &str); 4] =
    [("#d55e00", ""), ("#e69f00", "7 3"), ("#8c3a00", "2 3"), ("#b98a00", "9 3 2 3")];
/// What is good.
pub const GOOD: &str = "#00785a";
/// What is bad.
pub const BAD: &str = "#c03a00";
/// A cause.
pub const CAUSE: &str = "#8b939c";
/// A report.
pub const TOLD: &str = "#e69f00";

/// Depth of water on the map, l/m², from which each shade begins.
pub const DEPTHS: [(f64, &str); 5] =
    [(0.5, "#d9ecf7"), (2.0, "#aed6ee"), (8.0, "#79b8e0"), (25.0, "#3f8fc6"), (80.0, "#14639f")];

/// An SVG in the making.
#[derive(Default)]
pub struct Canvas {
    /// The elements so far.
    pub out: String,
}

/// Where a text is relative to its point.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// How a text looks.
#[derive(Clone, Copy)]
pub struct Type {
    /// Height of the letters.
    pub size: f64,
    /// Colour.
    pub fill: &'static str,
    /// Where its point is.
    pub anchor: Anchor,
    /// Whether it is bold.
    pub bold: bool,
}

impl Type {
    /// Plain text that begins at its point.
    pub const fn new(size: f64, fill: &'static str) -> Self {
        Self { size, fill, anchor: Anchor::Start, bold: false }
    }

    /// The same in bold.
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same with another anchor.
    pub const fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
}

impl Canvas {
    /// All of it as a file of its own, on paper of this size, px.
    pub fn document(&self, width: f64, height: f64) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"'Noto Sans','Segoe UI','Helvetica Neue',Arial,'DejaVu Sans',sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n{}</svg>\n",
            self.out
        )
    }

    // Writing to a String cannot fail, here and below.
    /// A rectangle: corner, size, attributes.
    pub fn rect(&mut self, x: f64, y: f64, width: f64, height: f64, style: &str) {
        let _ = writeln!(
            self.out,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {style}/>"
        );
    }

    /// A line between two points, with attributes.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), style: &str) {
        let ((x1, y1), (x2, y2)) = (from, to);
        let _ = writeln!(
            self.out,
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {style}/>"
        );
    }

    /// A circle with attributes.
    pub fn circle(&mut self, middle: (f64, f64), radius: f64, style: &str) {
        let (x, y) = middle;
        let _ =
            writeln!(self.out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" {style}/>");
    }

    /// A path by its data, with attributes.
    pub fn path(&mut self, data: &str, style: &str) {
        let _ = writeln!(self.out, "<path d=\"{data}\" {style}/>");
    }

    /// A text at a point.
    pub fn text(&mut self, at: (f64, f64), kind: Type, text: &str) {
        self.styled_text(at, kind, "", text);
    }

    /// A text with a halo, legible on anything.
    pub fn label(&mut self, at: (f64, f64), kind: Type, text: &str) {
        let halo = "paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\" \
                    stroke-linejoin=\"round\"";
        self.styled_text(at, kind, halo, text);
    }

    fn styled_text(&mut self, (x, y): (f64, f64), kind: Type, style: &str, text: &str) {
        let Type { size, fill, anchor, bold } = kind;
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if bold { " font-weight=\"600\"" } else { "" };
        let text = escaped(text);
        let _ = writeln!(
            self.out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{fill}\"{anchor}{weight} \
             {style}>{text}</text>"
        );
    }

    /// A text in lines of a width; the baseline below the last.
    pub fn paragraph(&mut self, at: (f64, f64), width: f64, kind: Type, text: &str) -> f64 {
        let mut y = at.1;
        for line in wrapped(text, width, kind.size) {
            self.text((at.0, y), kind, &line);
            y += libm::round(kind.size * 1.35);
        }
        y
    }
}

/// About how wide a text is.
pub fn width_of(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * 0.6
}

/// A text in lines that are not wider.
pub fn wrapped(text: &str, width: f64, size: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().map_or("", |line| line.as_str());
        let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
        if width_of(&longer, size) > width && !last.is_empty() {
            lines.push(word.to_owned());
        } else if let Some(last) = lines.last_mut() {
            *last = longer;
        }
    }
    lines
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A round step that gives at most so many ticks.
pub fn tick(span: f64, most: f64) -> f64 {
    let raw = span / most;
    let power = libm::pow(10.0, libm::floor(libm::log10(raw)));
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|step| *step >= raw).unwrap_or(raw)
}
