//! Entities as shapes in plan, those of inserted blocks included.

use std::collections::HashMap;
use std::f64::consts::TAU;

use lafet_texts::drawing as text;

use super::Block;
use super::entity::{Entity, Insert, Kind, Vertex};
use crate::curve;
use crate::matrix::{Matrix, Vector, cross, unit};
use crate::shape::{Builder, Drawing, Geometry, Height, Shape};
use crate::{DEPTH_MAX, Limits, Problem};

/// The shapes of all entities.
pub fn expanded(
    builder: Builder<'_>,
    blocks: &HashMap<String, Block>,
    entities: &[Entity],
    limits: &Limits,
) -> Result<Drawing, Problem> {
    let zero = builder.drawing.layers.iter().position(|it| it.name == "0");
    let mut expand = Expand { builder, blocks, limits, zero, steps: 0 };
    for entity in entities {
        expand.entity(entity, &Within { map: Matrix::SAME, inserted: None, depth: 0 })?;
    }
    Ok(expand.builder.drawing)
}

struct Expand<'a> {
    builder: Builder<'a>,
    blocks: &'a HashMap<String, Block>,
    limits: &'a Limits,
    /// The layer whose entities in a block are on the layer of the block.
    zero: Option<usize>,
    steps: usize,
}

/// Where an entity is.
struct Within<'a> {
    map: Matrix,
    /// Layer and name of the innermost inserted block.
    inserted: Option<(usize, Option<&'a str>)>,
    depth: usize,
}

impl Within<'_> {
    /// How high what is as thick along a normal is, seen upright.
    fn height(&self, normal: Vector, thickness: f64) -> Option<f64> {
        let along = unit(normal)?.map(|it| it * thickness);
        let high = self.map.direction(along)[2];
        (thickness != 0.0 && high != 0.0).then_some(high)
    }
}

impl Expand<'_> {
    fn entity(&mut self, entity: &Entity, within: &Within<'_>) -> Result<(), Problem> {
        // Empty blocks in blocks take time as well.
        self.steps += 1;
        if self.steps > 2 * self.limits.shapes {
            let Limits { shapes, points, .. } = *self.limits;
            let what = text::TooMuch { shapes, points };
            return Err(Problem::at(entity.line, what, text::TooMuchRemedy));
        }
        let drawn = within.map.after(&Matrix::of_normal(entity.normal));
        let high = |thickness: f64| within.height(entity.normal, thickness);
        match &entity.kind {
            Kind::Line { ends, thickness } => {
                let ends = ends.map(|it| within.map.place(it));
                self.path(entity, within, &ends, false, high(*thickness))
            }
            Kind::Path { vertices, closed, spatial, thickness } => {
                let map = if *spatial { &within.map } else { &drawn };
                let points: Vec<Vector> = outline(vertices, *closed, self.limits.points)
                    .iter()
                    .map(|it| map.place(*it))
                    .collect();
                self.path(entity, within, &points, *closed, high(*thickness))
            }
            Kind::Circle { at, radius, thickness } => {
                self.circle(entity, within, &drawn, (*at, *radius), high(*thickness))
            }
            Kind::Arc { at, radius, angles, thickness } => {
                let axes = [[*radius, 0.0, 0.0], [0.0, *radius, 0.0]];
                let points = around(&drawn, *at, axes, *angles);
                self.path(entity, within, &points, false, high(*thickness))
            }
            Kind::Ellipse { at, major, ratio, angles } => {
                let normal = unit(entity.normal).unwrap_or([0.0, 0.0, 1.0]);
                let minor = cross(normal, *major).map(|it| it * ratio);
                let mut points = around(&within.map, *at, [*major, minor], *angles);
                let whole = (angles[1] - angles[0] - TAU).abs() < 1e-9;
                if whole {
                    points.pop();
                }
                self.path(entity, within, &points, whole, None)
            }
            Kind::Point { at } => {
                let at = within.map.place(*at);
                let geometry = Geometry::Point([at[0], at[1]]);
                self.add(entity, within, geometry, (at[2], None), None)
            }
            Kind::Label { at, text } => {
                let at = drawn.place(*at);
                self.builder.label([at[0], at[1]], text);
                Ok(())
            }
            Kind::Insert(insert) => self.insert(entity, insert, within, &drawn),
        }
    }

    /// A circle that is seen from above as one, else as its outline.
    fn circle(
        &mut self,
        entity: &Entity,
        within: &Within<'_>,
        drawn: &Matrix,
        (at, radius): (Vector, f64),
        high: Option<f64>,
    ) -> Result<(), Problem> {
        let Some(factor) = drawn.round() else {
            let axes = [[radius, 0.0, 0.0], [0.0, radius, 0.0]];
            let mut points = around(drawn, at, axes, [0.0, TAU]);
            points.pop();
            return self.path(entity, within, &points, true, high);
        };
        let at = drawn.place(at);
        let geometry = Geometry::Circle { at: [at[0], at[1]], radius: radius * factor };
        self.add(entity, within, geometry, (at[2], high), None)
    }

    fn path(
        &mut self,
        entity: &Entity,
        within: &Within<'_>,
        points: &[Vector],
        closed: bool,
        high: Option<f64>,
    ) -> Result<(), Problem> {
        let base = points.iter().map(|it| it[2]).fold(f64::INFINITY, f64::min);
        let base = if points.is_empty() { 0.0 } else { base };
        let points = points.iter().map(|it| [it[0], it[1]]).collect();
        self.add(entity, within, Geometry::Path { points, closed }, (base, high), None)
    }

    fn add(
        &mut self,
        entity: &Entity,
        within: &Within<'_>,
        geometry: Geometry,
        (z, high): (f64, Option<f64>),
        name: Option<&str>,
    ) -> Result<(), Problem> {
        let inserted = within.inserted.filter(|_| Some(entity.layer) == self.zero);
        let shape = Shape {
            layer: inserted.map_or(entity.layer, |(layer, _)| layer),
            name: name.or(within.inserted.and_then(|(_, name)| name)).map(str::to_owned),
            geometry,
            height: high.map(|it| Height::Drawn(it.abs())),
            base: Some(z + high.unwrap_or(0.0).min(0.0)),
            part: within.inserted.is_some(),
        };
        self.builder.add(shape, entity.line)
    }

    fn insert(
        &mut self,
        entity: &Entity,
        insert: &Insert,
        within: &Within<'_>,
        drawn: &Matrix,
    ) -> Result<(), Problem> {
        let block = self.blocks.get(&insert.block);
        let Some(block) = block.filter(|block| !block.elsewhere) else {
            self.builder.skip(if block.is_some() { "XREF" } else { "INSERT" });
            return Ok(());
        };
        if within.depth >= DEPTH_MAX {
            let (block, most) = (crate::shape::name(&insert.block), DEPTH_MAX);
            let what = text::TooDeep { block, most };
            return Err(Problem::at(entity.line, what, text::TooDeepRemedy));
        }
        let turned = Matrix::turned(insert.turn);
        let inner = turned
            .after(&Matrix::scaled(insert.scale))
            .after(&Matrix::moved(block.base.map(|it| -it)));
        let layer = within
            .inserted
            .filter(|_| Some(entity.layer) == self.zero)
            .map_or(entity.layer, |(layer, _)| layer);
        let name = insert.name.as_deref().or(within.inserted.and_then(|(_, name)| name));
        let [columns, rows] = insert.counts;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |it| (row, it))) {
            let [x, y] = insert.spacing;
            let aside = turned.place([column as f64 * x, row as f64 * y, 0.0]);
            let at = [0, 1, 2].map(|n| insert.at[n] + aside[n]);
            let place = drawn.place(at);
            let geometry = Geometry::Point([place[0], place[1]]);
            self.add(entity, within, geometry, (place[2], None), insert.name.as_deref())?;
            let map = drawn.after(&Matrix::moved(at)).after(&inner);
            let depth = within.depth + 1;
            let inside = Within { map, inserted: Some((layer, name)), depth };
            self.steps += 1;
            for entity in &block.entities {
                self.entity(entity, &inside)?;
            }
        }
        Ok(())
    }
}

/// The points of a line with its arcs; those of a closed one do not repeat the first. What follows after so
/// many is left out, for the builder refuses it.
fn outline(vertices: &[Vertex], closed: bool, most: usize) -> Vec<Vector> {
    let Some(first) = vertices.first() else { return Vec::new() };
    let mut points = vec![first.at];
    let next = vertices.iter().skip(1).chain(closed.then_some(first));
    let mut arc = Vec::new();
    for (from, to) in vertices.iter().zip(next) {
        if points.len() > most + 1 {
            break;
        }
        let [a, b] = [from.at, to.at].map(|it| [it[0], it[1]]);
        if from.bulge == 0.0 {
            points.push(to.at);
            continue;
        }
        arc.clear();
        curve::bulge(&mut arc, a, b, from.bulge);
        points.extend(arc.iter().map(|it| [it[0], it[1], from.at[2]]));
    }
    if closed {
        points.pop();
    }
    points
}

/// Points around a centre, by two half axes.
fn around(map: &Matrix, at: Vector, [x, y]: [Vector; 2], [from, to]: [f64; 2]) -> Vec<Vector> {
    let on = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        map.place([0, 1, 2].map(|n| at[n] + cos * x[n] + sin * y[n]))
    };
    curve::angles(from, to).map(on).collect()
}
