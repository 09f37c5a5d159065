//! SVG: shapes of its groups, which are its layers.

mod outline;

use std::collections::{HashMap, HashSet};
use std::str::FromStr as _;

use lafet_texts::drawing as text;
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, Transform};

use crate::matrix::Matrix;
use crate::shape::{Builder, Drawing, Format, Geometry, Shape};
use crate::{DEPTH_MAX, Limits, Problem};

const SVG: &str = "http://www.w3.org/2000/svg";
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
const XLINK: &str = "http://www.w3.org/1999/xlink";
/// Nodes of the file for a shape of it: spaces, metadata, groups.
const NODES: usize = 10;
/// Attributes for a shape.
const ATTRIBUTES: usize = 20;
/// Attributes of an element, and prefixes of names: the parser compares each with each.
const ATTRIBUTES_MAX: usize = 256;
const PREFIXES_MAX: usize = 64;
/// Bytes of attributes that take as long as a node.
const WRITTEN: usize = 200;
/// Nodes of a text, and of a shape, that are looked through for its words.
const TEXT_NODES: usize = 256;
/// Nested groups are walked by recursion.
const GROUPS_MAX: usize = 200;
/// Most bytes that entities become.
const LAUGHS_MAX: usize = 32 << 20;

pub fn read(bytes: &[u8], limits: &Limits) -> Result<Drawing, Problem> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|it| **it == b'\n').count();
        Problem::at(line, text::NotUtf8, text::NotUtf8Remedy)
    })?;
    if !is_short(text) {
        return Err(Problem::new(text::Entities, text::EntitiesRemedy));
    }
    if !is_modest(text, limits) {
        let Limits { shapes, points, .. } = *limits;
        return Err(Problem::new(text::TooMuch { shapes, points }, text::TooMuchRemedy));
    }
    let nodes_limit = u32::try_from(limits.shapes.saturating_mul(NODES)).unwrap_or(u32::MAX);
    let options = ParsingOptions { allow_dtd: true, nodes_limit, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let line = usize::try_from(error.pos().row).unwrap_or(1);
        let said = crate::shape::name(&error.to_string());
        Problem::at(line, text::NotXml { said }, text::BrokenRemedy)
    })?;
    let root = document.root_element();
    if !root.has_tag_name("svg") && !root.has_tag_name((SVG, "svg")) {
        return Err(Problem::new(text::NoSvg, text::FormatRemedy));
    }
    let mut walk = Walk {
        builder: Builder::new(Format::Svg, limits),
        document: &document,
        steps: 0,
        limits,
        ids: HashMap::new(),
    };
    for node in document.descendants() {
        if let Some(id) = node.attribute("id") {
            walk.ids.entry(id).or_insert(node);
        }
    }
    walk.builder.drawing.y_down = true;
    if let (Some(width), Some(height)) = (root.attribute("width"), root.attribute("height")) {
        let shown = [width, height].map(crate::shape::name);
        walk.builder.drawing.paper = Some(shown);
    }
    let at = At { map: Matrix::SAME, layer: None, hidden: false, uses: 0, depth: 0 };
    walk.children(root, &at)?;
    Ok(walk.builder.drawing)
}

/// Whether the entities that a text declares cannot make it much longer: each of them may be used by others
/// 255 times, and any number of times in the text.
fn is_short(text: &str) -> bool {
    let Some(start) = text.find("<!DOCTYPE").filter(|_| text.contains("<!ENTITY")) else {
        return true;
    };
    let end = text.rfind("]>").unwrap_or(text.len());
    let declared = end.saturating_sub(start);
    let known = ["amp;", "lt;", "gt;", "quot;", "apos;", "#"];
    let used =
        text.split('&').skip(1).filter(|it| !known.iter().any(|known| it.starts_with(known)));
    used.count().saturating_mul(declared).saturating_mul(255) <= LAUGHS_MAX
}

/// Whether nodes, attributes and prefixes are not more than the parser has time and memory for.
fn is_modest(text: &str, limits: &Limits) -> bool {
    let nodes = limits.shapes.saturating_mul(2 * NODES).saturating_add(NODES);
    let attributes = limits.shapes.saturating_mul(ATTRIBUTES).saturating_add(ATTRIBUTES_MAX);
    let count = |letter: u8| text.bytes().filter(|it| *it == letter).count();
    if count(b'<') > nodes || count(b'=') > attributes {
        return false;
    }
    // Values of attributes have no `<`: all of those of an element are between two of them.
    let quoted = |it: &&str| it.trim_start().starts_with(['"', '\'']);
    let of_one = |tag: &str| tag.split('=').skip(1).filter(quoted).count();
    if text.split('<').any(|tag| of_one(tag) > ATTRIBUTES_MAX) {
        return false;
    }
    let ends = |c: char| c == '=' || c.is_ascii_whitespace();
    let declared = text.split("xmlns:").skip(1).filter_map(|it| it.split(ends).next());
    let mut prefixes = HashSet::new();
    declared.for_each(|it| {
        if prefixes.len() <= PREFIXES_MAX {
            prefixes.insert(it);
        }
    });
    prefixes.len() <= PREFIXES_MAX
}

/// Where an element is.
#[derive(Clone)]
struct At {
    map: Matrix,
    layer: Option<String>,
    hidden: bool,
    /// References followed so far.
    uses: usize,
    depth: usize,
}

struct Walk<'a, 'input> {
    builder: Builder<'a>,
    document: &'a Document<'input>,
    /// What references name.
    ids: HashMap<&'a str, Node<'a, 'input>>,
    steps: usize,
    limits: &'a Limits,
}

impl Walk<'_, '_> {
    fn children(&mut self, node: Node<'_, '_>, at: &At) -> Result<(), Problem> {
        for child in node.children() {
            self.counted(child, 1)?;
            if child.is_element() {
                self.element(child, at)?;
            }
        }
        Ok(())
    }

    /// What references repeat takes time again.
    fn counted(&mut self, node: Node<'_, '_>, steps: usize) -> Result<(), Problem> {
        self.steps += steps;
        if self.steps <= self.limits.shapes.saturating_mul(NODES) {
            return Ok(());
        }
        let Limits { shapes, points, .. } = *self.limits;
        let what = text::TooMuch { shapes, points };
        Err(Problem::at(self.line(node), what, text::TooMuchRemedy))
    }

    fn line(&self, node: Node<'_, '_>) -> usize {
        // Only for messages: it counts from the start of the text.
        self.document.text_pos_at(node.range().start).row as usize
    }

    fn element(&mut self, node: Node<'_, '_>, at: &At) -> Result<(), Problem> {
        let written: usize = node.attributes().map(|it| it.value().len()).sum();
        self.counted(node, 1 + written / WRITTEN)?;
        if at.depth > GROUPS_MAX {
            let (block, most) = (node.tag_name().name().to_owned(), GROUPS_MAX);
            let what = text::TooDeep { block, most };
            return Err(Problem::at(self.line(node), what, text::TooDeepRemedy));
        }
        let name = node.tag_name();
        if name.namespace().is_some_and(|it| it != SVG) {
            return Ok(());
        }
        let style = node.attribute("style").unwrap_or_default();
        if style.contains("transform") {
            self.builder.skip("style: transform");
            return Ok(());
        }
        let mut inner = At { depth: at.depth + 1, ..at.clone() };
        inner.hidden |= node.attribute("display") == Some("none") || is_hidden(style);
        if let Some(written) = node.attribute("transform") {
            let Ok(Transform { a, b, c, d, e, f }) = Transform::from_str(written) else {
                let shown = crate::shape::name(written);
                let what = text::NoTransform { shown };
                return Err(Problem::at(self.line(node), what, text::BrokenRemedy));
            };
            inner.map = at.map.after(&Matrix::plane([a, b, c, d, e, f]));
        }
        match name.name() {
            "g" | "a" | "switch" => {
                self.enter(node, at, &mut inner);
                self.children(node, &inner)
            }
            "use" => self.reference(node, inner),
            "text" => self.label(node, &inner),
            "path" | "line" | "polyline" | "polygon" | "rect" | "circle" | "ellipse" => {
                self.shape(node, &inner)
            }
            // What is not drawn by itself.
            "defs" | "symbol" | "clipPath" | "mask" | "marker" | "pattern" | "title" | "desc"
            | "metadata" | "style" | "script" | "linearGradient" | "radialGradient" | "filter" => {
                Ok(())
            }
            other => {
                self.builder.skip(other);
                Ok(())
            }
        }
    }

    /// A layer is what the editor calls so; else the outermost group that has a name.
    fn enter(&self, node: Node<'_, '_>, at: &At, inner: &mut At) {
        let label = node.attribute((INKSCAPE, "label")).or(node.attribute("id"));
        let is_layer = node.attribute((INKSCAPE, "groupmode")) == Some("layer");
        if is_layer || at.layer.is_none() {
            inner.layer = label.map(crate::shape::name).or_else(|| at.layer.clone());
        }
    }

    fn reference(&mut self, node: Node<'_, '_>, mut inner: At) -> Result<(), Problem> {
        let href = node.attribute("href").or(node.attribute((XLINK, "href")));
        let id = href.and_then(|it| it.strip_prefix('#')).unwrap_or_default();
        let target = self.ids.get(id).copied();
        let Some(target) = target.filter(|it| it.tag_name().name() != "symbol") else {
            self.builder.skip("use");
            return Ok(());
        };
        if inner.uses >= DEPTH_MAX {
            let (block, most) = (crate::shape::name(id), DEPTH_MAX);
            let what = text::TooDeep { block, most };
            return Err(Problem::at(self.line(node), what, text::TooDeepRemedy));
        }
        inner.uses += 1;
        let (x, y) = (self.number(node, "x")?, self.number(node, "y")?);
        inner.map = inner.map.after(&Matrix::moved([x, y, 0.0]));
        self.element(target, &inner)
    }

    fn label(&mut self, node: Node<'_, '_>, at: &At) -> Result<(), Problem> {
        let placed = |it: &Node<'_, '_>| it.attribute("x").is_some();
        let nodes = || node.descendants().take(TEXT_NODES);
        let Some(first) = nodes().find(placed) else { return Ok(()) };
        // A list of places has one for each letter.
        let of = |name: &str| {
            let value = first.attribute(name).unwrap_or_default();
            let value = value.split([' ', ',']).next().unwrap_or_default();
            Length::from_str(value).ok().and_then(user_units).unwrap_or(0.0)
        };
        let words = nodes().filter(Node::is_text).filter_map(|it| it.text());
        let words: Vec<String> = words.map(crate::shape::name).collect();
        let [x, y, _] = at.map.place([of("x"), of("y"), 0.0]);
        self.builder.label([x, y], &words.join(" "));
        Ok(())
    }

    /// A length in user units; 0 without it.
    fn number(&self, node: Node<'_, '_>, name: &str) -> Result<f64, Problem> {
        let Some(written) = node.attribute(name) else { return Ok(0.0) };
        let length = Length::from_str(written.trim()).ok().and_then(user_units);
        length.ok_or_else(|| {
            let shown = crate::shape::name(written);
            Problem::at(self.line(node), text::NoLength { name, shown }, text::BrokenRemedy)
        })
    }

    fn shape(&mut self, node: Node<'_, '_>, at: &At) -> Result<(), Problem> {
        let number = |name: &str| self.number(node, name);
        let outlines = match node.tag_name().name() {
            "path" => {
                let d = node.attribute("d").unwrap_or_default();
                outline::of_path(d, self.limits.points).map_err(|shown| {
                    Problem::at(self.line(node), text::NoPath { shown }, text::BrokenRemedy)
                })?
            }
            "line" => {
                let ends = [[number("x1")?, number("y1")?], [number("x2")?, number("y2")?]];
                vec![outline::Outline { points: ends.to_vec(), closed: false }]
            }
            "rect" => {
                let (x, y) = (number("x")?, number("y")?);
                let (width, height) = (number("width")?, number("height")?);
                vec![outline::rectangle([x, y], [width, height])]
            }
            "circle" | "ellipse" => {
                let (x, y) = (number("cx")?, number("cy")?);
                let radii = match node.tag_name().name() {
                    "circle" => [number("r")?; 2],
                    _ => [number("rx")?, number("ry")?],
                };
                return self.round(node, at, [x, y], radii);
            }
            name => {
                let points = node.attribute("points").unwrap_or_default();
                let points = svgtypes::PointsParser::from(points).map(|(x, y)| [x, y]);
                // One more is refused by the builder.
                let points = points.take(self.limits.points.saturating_add(1)).collect();
                vec![outline::Outline { points, closed: name == "polygon" }]
            }
        };
        for outline in outlines {
            let place = |[x, y]: [f64; 2]| {
                let [x, y, _] = at.map.place([x, y, 0.0]);
                [x, y]
            };
            let points = outline.points.into_iter().map(place).collect();
            let geometry = Geometry::Path { points, closed: outline.closed };
            self.add(node, at, geometry)?;
        }
        Ok(())
    }

    fn round(
        &mut self,
        node: Node<'_, '_>,
        at: &At,
        [x, y]: [f64; 2],
        [rx, ry]: [f64; 2],
    ) -> Result<(), Problem> {
        let map = at.map.after(&Matrix::moved([x, y, 0.0])).after(&Matrix::scaled([rx, ry, 1.0]));
        let geometry = match map.round() {
            Some(radius) => Geometry::Circle { at: [map.zero[0], map.zero[1]], radius },
            None => {
                let on = |angle: f64| {
                    let [x, y, _] = map.place([angle.cos(), angle.sin(), 0.0]);
                    [x, y]
                };
                let mut points: Vec<_> =
                    crate::curve::angles(0.0, std::f64::consts::TAU).map(on).collect();
                points.pop();
                Geometry::Path { points, closed: true }
            }
        };
        self.add(node, at, geometry)
    }

    fn add(&mut self, node: Node<'_, '_>, at: &At, geometry: Geometry) -> Result<(), Problem> {
        if at.hidden {
            self.builder.skip("display: none");
            return Ok(());
        }
        let title = node.children().take(TEXT_NODES).find(|it| it.has_tag_name((SVG, "title")));
        let name = node.attribute((INKSCAPE, "label")).or(title.and_then(|it| it.text()));
        let name = name.map(crate::shape::name).filter(|it| !it.is_empty());
        let layer = self.builder.layer(at.layer.as_deref().unwrap_or_default())?;
        let shape = Shape { layer, name, geometry, height: None, base: None, part: at.uses > 0 };
        let added = self.builder.add(shape, 0);
        added.map_err(|problem| Problem { line: Some(self.line(node)), ..problem })
    }
}

fn is_hidden(style: &str) -> bool {
    style.split(';').filter_map(|it| it.split_once(':')).any(|(key, value)| {
        (key.trim() == "display" && value.trim() == "none")
            || (key.trim() == "visibility" && value.trim() == "hidden")
    })
}

/// A length in user units, of which CSS has 96 in an inch.
fn user_units(length: Length) -> Option<f64> {
    let factor = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::Mm => 96.0 / 25.4,
        LengthUnit::Cm => 96.0 / 2.54,
        LengthUnit::In => 96.0,
        LengthUnit::Pt => 96.0 / 72.0,
        LengthUnit::Pc => 16.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return None,
    };
    Some(length.number * factor)
}
