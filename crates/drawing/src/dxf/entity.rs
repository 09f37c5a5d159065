//! What is drawn: entities of DXF, in their own axes.

use std::f64::consts::TAU;

use lafet_texts::drawing as text;

use super::tags::Tag;
use super::words::{Decoder, plain};
use crate::Problem;
use crate::matrix::Vector;

/// An entity.
#[derive(Debug)]
pub struct Entity {
    pub layer: usize,
    /// The normal of the plane that it is drawn on.
    pub normal: Vector,
    pub kind: Kind,
    pub line: usize,
}

#[derive(Debug)]
pub enum Kind {
    /// Places of the world, whatever the normal.
    Line {
        ends: [Vector; 2],
        thickness: f64,
    },
    /// `spatial`: its places are those of the world.
    Path {
        vertices: Vec<Vertex>,
        closed: bool,
        spatial: bool,
        thickness: f64,
    },
    Circle {
        at: Vector,
        radius: f64,
        thickness: f64,
    },
    Arc {
        at: Vector,
        radius: f64,
        angles: [f64; 2],
        thickness: f64,
    },
    /// Places of the world.
    Ellipse {
        at: Vector,
        major: Vector,
        ratio: f64,
        angles: [f64; 2],
    },
    /// A place of the world.
    Point {
        at: Vector,
    },
    Label {
        at: Vector,
        text: String,
    },
    Insert(Insert),
}

#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    pub at: Vector,
    pub bulge: f64,
}

/// A block put somewhere, once or in rows and columns.
#[derive(Debug)]
pub struct Insert {
    pub block: String,
    pub at: Vector,
    pub scale: Vector,
    pub turn: f64,
    /// Columns and rows.
    pub counts: [i64; 2],
    pub spacing: [f64; 2],
    pub name: Option<String>,
}

impl Entity {
    pub fn vertices(&self) -> usize {
        match &self.kind {
            Kind::Path { vertices, .. } => vertices.len(),
            _ => 0,
        }
    }
}

/// The pairs of an entity. Of several of a code the first counts, except in lists of vertices.
pub struct Fields<'a> {
    line: usize,
    tags: Vec<Tag<'a>>,
}

impl<'a> Fields<'a> {
    pub const fn new(line: usize, tags: Vec<Tag<'a>>) -> Self {
        Self { line, tags }
    }

    fn find(&self, code: i32) -> Option<&Tag<'a>> {
        self.tags.iter().find(|tag| tag.code == code)
    }

    pub fn bytes(&self, code: i32) -> &'a [u8] {
        self.find(code).map_or(b"", Tag::bytes)
    }

    pub fn real(&self, code: i32, without: f64) -> Result<f64, Problem> {
        self.find(code).map_or(Ok(without), Tag::real)
    }

    pub fn whole(&self, code: i32, without: i64) -> Result<i64, Problem> {
        self.find(code).map_or(Ok(without), Tag::whole)
    }

    /// x, y and z of a code and of those 10 and 20 above it.
    pub fn place(&self, code: i32) -> Result<Vector, Problem> {
        Ok([self.real(code, 0.0)?, self.real(code + 10, 0.0)?, self.real(code + 20, 0.0)?])
    }

    pub fn normal(&self) -> Result<Vector, Problem> {
        let up = self.find(210).is_none() && self.find(230).is_none();
        if up { Ok([0.0, 0.0, 1.0]) } else { self.place(210) }
    }

    fn has(&self, code: i32, name: &str) -> Result<(), Problem> {
        if self.find(code).is_some() {
            return Ok(());
        }
        Err(Problem::at(self.line, text::NotComplete { name, code }, text::BrokenRemedy))
    }

    /// The entity of this name; none for what is no tank, wall or place.
    pub fn kind(&self, name: &str, decoder: Decoder) -> Result<Option<Kind>, Problem> {
        let thickness = self.real(39, 0.0)?;
        let degrees =
            |code: i32, without: f64| self.real(code, without).map(|it| (it % 360.0).to_radians());
        Ok(Some(match name {
            "LINE" => {
                self.has(10, name)?;
                self.has(11, name)?;
                Kind::Line { ends: [self.place(10)?, self.place(11)?], thickness }
            }
            "LWPOLYLINE" => self.light(thickness)?,
            "POLYLINE" => {
                let flags = self.whole(70, 0)?;
                // 16 and 64: surfaces.
                if flags & (16 | 64) != 0 {
                    return Ok(None);
                }
                let (closed, spatial) = (flags & 1 != 0, flags & 8 != 0);
                Kind::Path { vertices: Vec::new(), closed, spatial, thickness }
            }
            "CIRCLE" | "ARC" => {
                self.has(10, name)?;
                self.has(40, name)?;
                let (at, radius) = (self.place(10)?, self.real(40, 0.0)?);
                if name == "CIRCLE" {
                    return Ok(Some(Kind::Circle { at, radius, thickness }));
                }
                let (from, to) = (degrees(50, 0.0)?, degrees(51, 0.0)?);
                Kind::Arc { at, radius, angles: onward(from, to), thickness }
            }
            "ELLIPSE" => {
                self.has(10, name)?;
                self.has(11, name)?;
                let turn = |angle: f64| angle % (2.0 * TAU);
                let (from, to) = (self.real(41, 0.0)?, self.real(42, TAU)?);
                let whole = (to - from - TAU).abs() < 1e-9;
                let angles = if whole { [from, from + TAU] } else { onward(turn(from), turn(to)) };
                let (at, major) = (self.place(10)?, self.place(11)?);
                Kind::Ellipse { at, major, ratio: self.real(40, 1.0)?, angles }
            }
            "POINT" => Kind::Point { at: self.place(10)? },
            "TEXT" | "MTEXT" => self.label(name, decoder)?,
            "INSERT" => Kind::Insert(self.insert(decoder, degrees(50, 0.0)?)?),
            _ => return Ok(None),
        }))
    }

    fn insert(&self, decoder: Decoder, turn: f64) -> Result<Insert, Problem> {
        Ok(Insert {
            block: decoder.text(self.bytes(2)).to_lowercase(),
            at: self.place(10)?,
            scale: [self.real(41, 1.0)?, self.real(42, 1.0)?, self.real(43, 1.0)?],
            turn,
            counts: [self.whole(70, 1)?.max(1), self.whole(71, 1)?.max(1)],
            spacing: [self.real(44, 0.0)?, self.real(45, 0.0)?],
            name: None,
        })
    }

    fn label(&self, name: &str, decoder: Decoder) -> Result<Kind, Problem> {
        if name == "MTEXT" {
            let text = plain(&decoder.text(self.bytes(1)));
            return Ok(Kind::Label { at: self.place(10)?, text });
        }
        // One that is not aligned at its left end is placed by its second point.
        let aligned = self.whole(72, 0)? != 0 || self.whole(73, 0)? != 0;
        let code = if aligned && self.find(11).is_some() { 11 } else { 10 };
        Ok(Kind::Label { at: self.place(code)?, text: decoder.text(self.bytes(1)) })
    }

    /// LWPOLYLINE: its vertices are in a row.
    fn light(&self, thickness: f64) -> Result<Kind, Problem> {
        let elevation = self.real(38, 0.0)?;
        let mut vertices: Vec<Vertex> = Vec::new();
        for tag in &self.tags {
            match (tag.code, vertices.last_mut()) {
                (10, _) => vertices.push(Vertex { at: [tag.real()?, 0.0, elevation], bulge: 0.0 }),
                (20, Some(last)) => last.at[1] = tag.real()?,
                (42, Some(last)) => last.bulge = tag.real()?,
                _ => {}
            }
        }
        let closed = self.whole(70, 0)? & 1 != 0;
        Ok(Kind::Path { vertices, closed, spatial: false, thickness })
    }
}

/// From one angle on to another, counter-clockwise, a whole turn if they are the same.
fn onward(from: f64, to: f64) -> [f64; 2] {
    let span = (to - from).rem_euclid(TAU);
    [from, from + if span < 1e-9 { TAU } else { span }]
}
