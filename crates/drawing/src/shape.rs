//! A drawing as it was read: layers and shapes in its own coordinates.

use std::collections::{BTreeMap, HashMap};

use lafet_texts::drawing as text;

use crate::{COORDINATE_MAX, Limits, NAME_MAX, Problem, Unit};

/// What a drawing is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// DXF of AutoCAD, as text or binary.
    Dxf,
    /// GeoJSON.
    GeoJson,
    /// SVG.
    Svg,
    /// A picture.
    Png,
    /// A photograph.
    Jpeg,
}

impl Format {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dxf => "DXF",
            Self::GeoJson => "GeoJSON",
            Self::Svg => "SVG",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
        }
    }

    /// The format that a file begins like.
    ///
    /// # Errors
    ///
    /// None that is known; for some it says which it is instead.
    pub fn of(bytes: &[u8]) -> Result<Self, Problem> {
        let known: [(&[u8], Self); 3] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xff\xd8\xff", Self::Jpeg),
            (b"AutoCAD Binary DXF", Self::Dxf),
        ];
        if let Some((_, format)) = known.into_iter().find(|(start, _)| bytes.starts_with(start)) {
            return Ok(format);
        }
        let strangers: [(&[u8], &str); 5] = [
            (b"AC10", "DWG"),
            (b"%PDF", "PDF"),
            (b"\x1f\x8b", "gzip"),
            (b"PK\x03\x04", "ZIP"),
            (b"BM", "BMP"),
        ];
        if let Some((_, name)) = strangers.into_iter().find(|(start, _)| bytes.starts_with(start)) {
            return Err(Problem::new(text::OtherFormat { name }, text::FormatRemedy));
        }
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let start = bytes.trim_ascii_start();
        match start.first() {
            Some(b'{') => Ok(Self::GeoJson),
            Some(b'<') => Ok(Self::Svg),
            Some(b'0'..=b'9') => Ok(Self::Dxf),
            _ => Err(Problem::new(text::UnknownFormat, text::FormatRemedy)),
        }
    }
}

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// What it was written in.
    pub format: Format,
    /// Its layers, in the order in which they appear.
    pub layers: Vec<Layer>,
    /// Its shapes.
    pub shapes: Vec<Shape>,
    /// Its texts.
    pub labels: Vec<Label>,
    /// The unit that it names itself. Only a proposal.
    pub proposed: Option<Unit>,
    /// The reference system that it names, if that is not WGS 84.
    pub reference: Option<String>,
    /// Width and height as stated for paper or screen.
    pub paper: Option<[String; 2]>,
    /// Width and height of a picture, pixels.
    pub pixels: Option<[u32; 2]>,
    /// Whether y runs downward, as in pictures.
    pub y_down: bool,
    /// What was left out, by its name in the format, and how often.
    pub skipped: BTreeMap<String, usize>,
}

/// A layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its name.
    pub name: String,
    /// Off or frozen in the drawing.
    pub hidden: bool,
}

/// A shape in plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Index of its layer.
    pub layer: usize,
    /// Its own name.
    pub name: Option<String>,
    /// Where it is.
    pub geometry: Geometry,
    /// Its height, if the drawing has it.
    pub height: Option<Height>,
    /// Its lowest z, in units of the drawing, if the drawing has one.
    pub base: Option<f64>,
    /// Belongs to an inserted block, which has a point of its own.
    pub part: bool,
}

/// Where a shape is, in units of the drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A point; that of an inserted block is where it was inserted.
    Point([f64; 2]),
    /// A circle.
    Circle {
        /// Centre.
        at: [f64; 2],
        /// Radius.
        radius: f64,
    },
    /// A line through points; curves are many short ones.
    Path {
        /// Its points; a closed one does not repeat the first.
        points: Vec<[f64; 2]>,
        /// Whether the last point leads to the first.
        closed: bool,
    },
}

/// A height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// In units of the drawing.
    Drawn(f64),
    /// In metres, whatever the unit of the drawing.
    Metres(f64),
}

/// A text of the drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Where it begins.
    pub at: [f64; 2],
    /// What it says.
    pub text: String,
}

/// South-west and north-east corner.
pub type Extent = [[f64; 2]; 2];

impl Drawing {
    /// What all shapes cover, in units of the drawing; with `layer` those of a layer.
    pub fn extent(&self, layer: Option<usize>) -> Option<Extent> {
        let of = self.shapes.iter().filter(|it| layer.is_none_or(|layer| it.layer == layer));
        let corners = of.flat_map(|it| it.geometry.corners());
        let drawn = extent(corners);
        drawn.or_else(|| {
            let [width, height] = self.pixels.filter(|_| layer.is_none())?.map(f64::from);
            Some([[0.0, 0.0], [width, height]])
        })
    }
}

impl Drawing {
    /// What nearly all shapes cover: a stray line far away does not count.
    pub(crate) fn bulk(&self) -> Option<Extent> {
        let corners: Vec<[f64; 2]> =
            self.shapes.iter().flat_map(|it| it.geometry.corners()).collect();
        let stray = corners.len() / 20;
        if stray == 0 {
            return self.extent(None);
        }
        let among = |axis: usize, rank: usize| {
            let mut values: Vec<f64> = corners.iter().map(|it| it[axis]).collect();
            *values.select_nth_unstable_by(rank, f64::total_cmp).1
        };
        let last = corners.len() - 1 - stray;
        Some([[0, 1].map(|axis| among(axis, stray)), [0, 1].map(|axis| among(axis, last))])
    }
}

impl Geometry {
    /// Corners of what it covers, or all its points.
    pub(crate) fn corners(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Point(at) => vec![*at],
            Self::Circle { at, radius } => {
                vec![at.map(|it| it - radius), at.map(|it| it + radius)]
            }
            Self::Path { points, .. } => points.clone(),
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Point(_) | Self::Circle { .. } => 1,
            Self::Path { points, .. } => points.len(),
        }
    }
}

/// What points cover.
pub(crate) fn extent(points: impl Iterator<Item = [f64; 2]>) -> Option<Extent> {
    points.fold(None, |known, at| match known {
        None => Some([at, at]),
        Some([least, most]) => {
            Some([[0, 1].map(|k| at[k].min(least[k])), [0, 1].map(|k| at[k].max(most[k]))])
        }
    })
}

/// A name that fits: without control characters, and not longer than names are.
pub(crate) fn name(text: &str) -> String {
    /// Looked at, whatever is read: blanks before a name too.
    const LONGEST: usize = 4096;
    let text = &text[..text.floor_char_boundary(LONGEST)];
    let words =
        text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|it| !it.is_empty());
    let mut name = String::new();
    for word in words {
        if !name.is_empty() {
            name.push(' ');
        }
        name.extend(word.chars().take(NAME_MAX));
        if name.len() > 4 * NAME_MAX {
            break;
        }
    }
    name.chars().take(NAME_MAX).collect()
}

/// Puts a drawing together, within bounds.
pub(crate) struct Builder<'a> {
    pub drawing: Drawing,
    limits: &'a Limits,
    points: usize,
    by_name: HashMap<String, usize>,
}

impl<'a> Builder<'a> {
    pub fn new(format: Format, limits: &'a Limits) -> Self {
        let drawing = Drawing {
            format,
            layers: Vec::new(),
            shapes: Vec::new(),
            labels: Vec::new(),
            proposed: None,
            reference: None,
            paper: None,
            pixels: None,
            y_down: false,
            skipped: BTreeMap::new(),
        };
        Self { drawing, limits, points: 0, by_name: HashMap::new() }
    }

    /// The layer of a name; capitals and small letters are the same.
    pub fn layer(&mut self, text: &str) -> Result<usize, Problem> {
        let name = name(text);
        let name = if name.is_empty() { "0".to_owned() } else { name };
        let key = name.to_lowercase();
        if let Some(index) = self.by_name.get(&key) {
            return Ok(*index);
        }
        let index = self.drawing.layers.len();
        if index >= self.limits.layers {
            let most = self.limits.layers;
            return Err(Problem::new(text::TooManyLayers { most }, text::TooMuchRemedy));
        }
        self.drawing.layers.push(Layer { name, hidden: false });
        self.by_name.insert(key, index);
        Ok(index)
    }

    pub fn hide(&mut self, layer: usize) {
        if let Some(layer) = self.drawing.layers.get_mut(layer) {
            layer.hidden = true;
        }
    }

    /// Something that is not a tank, a wall or a place was left out.
    pub fn skip(&mut self, kind: &str) {
        const KINDS_MAX: usize = 64;
        let kind = name(kind);
        let known = self.drawing.skipped.contains_key(&kind);
        let kind =
            if known || self.drawing.skipped.len() < KINDS_MAX { kind } else { "…".into() };
        *self.drawing.skipped.entry(kind).or_insert(0) += 1;
    }

    /// Adds a shape that was read around a line of the file.
    pub fn add(&mut self, shape: Shape, line: usize) -> Result<(), Problem> {
        let geometry = &shape.geometry;
        self.points += geometry.count();
        if self.drawing.shapes.len() >= self.limits.shapes || self.points > self.limits.points {
            let (shapes, points) = (self.limits.shapes, self.limits.points);
            return Err(Problem::at(line, text::TooMuch { shapes, points }, text::TooMuchRemedy));
        }
        let fine = |it: &f64| it.abs() <= COORDINATE_MAX;
        let corners = geometry.corners();
        let heights = [shape.base, shape.height.map(Height::value)];
        let known = heights.iter().flatten().all(fine);
        if !known || !corners.iter().flatten().all(fine) {
            return Err(Problem::at(line, text::NoPlace, text::NoPlaceRemedy));
        }
        let empty = match geometry {
            Geometry::Point(_) => false,
            Geometry::Circle { radius, .. } => *radius <= 0.0,
            Geometry::Path { points, .. } => points.len() < 2,
        };
        if empty {
            self.skip("…");
        } else {
            self.drawing.shapes.push(shape);
        }
        Ok(())
    }

    /// Adds a text; more than fit are left out, for they only name things.
    pub fn label(&mut self, at: [f64; 2], text: &str) {
        let text = name(text);
        let fine = at.iter().all(|it| it.abs() <= COORDINATE_MAX);
        if fine && !text.is_empty() && self.drawing.labels.len() < self.limits.labels {
            self.drawing.labels.push(Label { at, text });
        }
    }
}

impl Height {
    const fn value(self) -> f64 {
        match self {
            Self::Drawn(value) | Self::Metres(value) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_bounded_and_of_one_line() {
        assert_eq!(name("  Tank\tfarm\n\u{7}west "), "Tank farm west");
        assert_eq!(name(&"ж".repeat(5000)).chars().count(), NAME_MAX);
        assert_eq!(name(&"a b ".repeat(5000)).chars().count(), NAME_MAX);
        assert_eq!(name(&format!("{}a", "\u{2003}".repeat(5000))), "");
    }

    #[test]
    fn formats_are_known_by_their_first_bytes() {
        for (bytes, format) in [
            (&b"  0\nSECTION\n"[..], Format::Dxf),
            (b"\xef\xbb\xbf {\"type\"", Format::GeoJson),
            (b"<?xml", Format::Svg),
        ] {
            assert_eq!(Format::of(bytes), Ok(format));
        }
        let what = |bytes: &[u8]| Format::of(bytes).unwrap_err().to_string();
        assert!(what(b"AC1032\0\0").contains("DWG"));
        assert!(what(b"hello").contains("DXF") && what(b"").contains("DXF"));
    }
}
