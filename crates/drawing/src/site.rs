//! Which layer is what, and the obstacles and places that come of it.

use std::collections::{BTreeMap, BTreeSet};

use lafet_texts::{Decimal, Fixed, Text as _, Words, drawing as text};
use serde::Serialize;

use crate::curve;
use crate::placing::{FARTHEST_M, Placed};
use crate::shape::{Extent, extent};
use crate::{Geometry, Problem, Shape};

/// Points of a line are left out that are as near to it, m.
const TOLERANCE_M: f64 = 0.02;
/// No wall is shorter, m: the planner knows none.
const WALL_LEAST_M: f64 = 0.1;
/// A tank is not smaller nor larger, m.
const DIAMETERS_M: [f64; 2] = [0.2, 200.0];
/// Nothing is higher, m.
const HIGHEST_M: f64 = 300.0;
/// Most of each that are given.
pub const TANKS_MAX: usize = 1000;
/// See [`TANKS_MAX`].
pub const WALLS_MAX: usize = 5000;
/// See [`TANKS_MAX`].
pub const SPOTS_MAX: usize = 256;
/// With more tanks and walls the planner of the zones does not compute.
pub const PLANNED_MAX: usize = 256;

/// What the shapes of a layer are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Round tanks.
    Tank,
    /// Walls, also those of buildings.
    Wall,
    /// Places of monitors.
    Monitor,
    /// Places of detectors.
    Detector,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Tank, Self::Wall, Self::Monitor, Self::Detector];

    /// As it is written.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tank => "tank",
            Self::Wall => "wall",
            Self::Monitor => "monitor",
            Self::Detector => "detector",
        }
    }

    /// The role of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// A layer that is used.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Its name; capitals and small letters are the same.
    pub layer: String,
    /// What its shapes are.
    pub role: Role,
    /// Height of all of them, m; without it that of the drawing.
    pub height_m: Option<f64>,
}

/// Something that a person points at on a drawing, as on a photograph, which has no layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What it is.
    pub role: Role,
    /// Its name.
    pub name: String,
    /// Its height, m.
    pub height_m: Option<f64>,
    /// Centre and a point of the rim of a tank; the line of a wall; the place of anything else.
    pub points: Vec<[f64; 2]>,
}

/// A round tank, as `[[tank]]` of hub.toml.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tank {
    /// Its name.
    pub name: String,
    /// Centre: east and north, m.
    pub at: [f64; 2],
    /// m.
    pub diameter: f64,
    /// m.
    pub height: f64,
}

/// A wall, as `[[wall]]` of hub.toml.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wall {
    /// Its name.
    pub name: String,
    /// First end: east and north, m.
    pub from: [f64; 2],
    /// Second end.
    pub to: [f64; 2],
    /// m.
    pub height: f64,
}

/// A place of a monitor or a detector.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spot {
    /// Its name on the drawing.
    pub name: String,
    /// East and north, m.
    pub at: [f64; 2],
    /// Above the ground, m.
    pub height: Option<f64>,
}

/// What came of a drawing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// Tanks: obstacles, and what is aimed at.
    pub tanks: Vec<Tank>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Places of monitors.
    pub monitors: Vec<Spot>,
    /// Places of detectors.
    pub detectors: Vec<Spot>,
    /// South-west and north-east corner of all that, m.
    pub extent: Option<Extent>,
    /// Shapes of used layers that became nothing, by reason.
    #[serde(skip)]
    pub left_out: Vec<LeftOut>,
}

/// Shapes of a layer that became nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// The layer.
    pub layer: String,
    /// How many.
    pub count: usize,
    /// Why.
    pub why: Fixed,
}

impl LeftOut {
    /// In words.
    pub fn words(&self) -> Words {
        let Self { layer, count, why } = self;
        text::LeftOut { layer, count: *count, why: *why }.words()
    }
}

/// What of a drawing becomes tanks, walls and places.
///
/// # Errors
///
/// A layer that there is not, a height that is not known, more than fits, or places where no site is.
pub fn site(
    placed: &Placed,
    chosen: &[Chosen],
    marks: &[Mark],
    ground: Option<f64>,
) -> Result<Plan, Problem> {
    let mut maker = Maker { placed, ground, plan: Plan::default(), left_out: BTreeMap::new() };
    for it in chosen {
        maker.layer(it)?;
    }
    for mark in marks {
        maker.mark(mark)?;
    }
    maker.names();
    let Maker { mut plan, left_out, .. } = maker;
    plan.left_out = left_out
        .into_iter()
        .map(|((layer, _), (count, why))| LeftOut { layer, count, why })
        .collect();
    plan.extent = extent(plan.corners());
    let far = plan.extent.iter().flatten().flatten().map(|it| it.abs()).fold(0.0, f64::max);
    if far > FARTHEST_M {
        let km = Decimal(far / 1000.0, 1);
        return Err(Problem::new(text::TooLarge { km }, text::TooLargeRemedy));
    }
    Ok(plan)
}

impl Plan {
    /// Nothing.
    pub const fn is_empty(&self) -> bool {
        self.tanks.is_empty()
            && self.walls.is_empty()
            && self.monitors.is_empty()
            && self.detectors.is_empty()
    }

    fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        let tanks = self.tanks.iter().flat_map(|it| {
            let radius = 0.5 * it.diameter;
            [it.at.map(|it| it - radius), it.at.map(|it| it + radius)]
        });
        let walls = self.walls.iter().flat_map(|it| [it.from, it.to]);
        let spots = self.monitors.iter().chain(&self.detectors).map(|it| it.at);
        tanks.chain(walls).chain(spots)
    }
}

struct Maker<'a> {
    placed: &'a Placed,
    /// The z of the ground, in units of the drawing.
    ground: Option<f64>,
    plan: Plan,
    left_out: BTreeMap<(String, &'static str), (usize, Fixed)>,
}

/// A shape with what it becomes.
struct Item<'a> {
    role: Role,
    layer: &'a str,
    name: Option<&'a str>,
    height: Option<f64>,
}

impl Maker<'_> {
    fn layer(&mut self, chosen: &Chosen) -> Result<(), Problem> {
        let placed = self.placed;
        let drawing = &placed.drawing;
        let wanted = chosen.layer.to_lowercase();
        let found = drawing.layers.iter().position(|it| it.name.to_lowercase() == wanted);
        let Some(index) = found else {
            let (layer, known) = (&chosen.layer, known(&drawing.layers));
            return Err(Problem::new(text::NoLayer { layer }, text::NoLayerRemedy { known }));
        };
        let layer = &drawing.layers[index].name;
        for shape in drawing.shapes.iter().filter(|it| it.layer == index) {
            let height = self.height(chosen, shape);
            let name = shape.name.as_deref();
            let item = Item { role: chosen.role, layer, name, height };
            self.shape(&item, shape)?;
        }
        Ok(())
    }

    /// The stated height, else that of the drawing: of the shape, from the ground where that is known.
    fn height(&self, chosen: &Chosen, shape: &Shape) -> Option<f64> {
        let own = || {
            let own = self.placed.placing.height(shape.height?);
            let above = self.ground.and_then(|ground| Some(shape.base? - ground));
            Some(own + above.unwrap_or(0.0) * self.placed.placing.scale)
        };
        chosen.height_m.or_else(own)
    }

    fn mark(&mut self, mark: &Mark) -> Result<(), Problem> {
        let Mark { role, name, height_m, points } = mark;
        let layer = format!("--mark {name}");
        let item = Item { role: *role, layer: &layer, name: Some(name), height: *height_m };
        let geometry = match (role, points.as_slice()) {
            (Role::Tank, [at, rim]) => {
                let radius = (at[0] - rim[0]).hypot(at[1] - rim[1]);
                Geometry::Circle { at: *at, radius }
            }
            (Role::Wall, [_, _, ..]) => Geometry::Path { points: points.clone(), closed: false },
            (Role::Monitor | Role::Detector, [at]) => Geometry::Point(*at),
            _ => return Err(Problem::new(text::MarkPoints { name }, text::MarkPointsRemedy)),
        };
        let own = Some(name.clone());
        let shape = Shape { layer: 0, name: own, geometry, height: None, base: None, part: false };
        self.shape(&item, &shape)
    }

    fn shape(&mut self, item: &Item<'_>, shape: &Shape) -> Result<(), Problem> {
        match item.role {
            Role::Tank => self.tank(item, shape),
            Role::Wall => self.wall(item, shape),
            Role::Monitor | Role::Detector => self.spot(item, shape),
        }
    }

    fn tank(&mut self, item: &Item<'_>, shape: &Shape) -> Result<(), Problem> {
        let circle = match &shape.geometry {
            Geometry::Circle { at, radius } => Some((*at, *radius)),
            Geometry::Path { points, closed } => {
                let closes = *closed || points.first() == points.last();
                curve::round(points).filter(|_| closes)
            }
            // Where a block was inserted; its circle is a shape of its own.
            Geometry::Point(_) => return Ok(()),
        };
        let Some((at, radius)) = circle else {
            self.leave(item, "round", text::WhyNotRound.fixed());
            return Ok(());
        };
        let placing = &self.placed.placing;
        let diameter = 2.0 * radius * placing.scale;
        let [least, most] = DIAMETERS_M;
        if !(least..=most).contains(&diameter) {
            let (layer, metres) = (item.layer, Decimal(diameter, 3));
            return Err(Problem::new(text::NoTank { layer, metres }, text::NoTankRemedy));
        }
        let at = placing.place(at);
        let height = checked_height(item)?;
        let same = |it: &Tank| {
            let apart = (it.at[0] - at[0]).hypot(it.at[1] - at[1]);
            apart < 0.05 && (it.diameter - diameter).abs() < 0.05
        };
        if self.plan.tanks.iter().any(same) {
            self.leave(item, "twice", text::WhyTwice.fixed());
            return Ok(());
        }
        counted(self.plan.tanks.len(), TANKS_MAX)?;
        let name = item.name.map_or_else(|| self.label(at, 0.5 * diameter), str::to_owned);
        let name = if name.is_empty() { item.layer.to_owned() } else { name };
        self.plan.tanks.push(Tank { name, at, diameter, height });
        Ok(())
    }

    /// The text that is nearest to the centre of a tank, of those in it.
    fn label(&self, at: [f64; 2], radius: f64) -> String {
        let away = |it: &crate::Label| {
            let label = self.placed.placing.place(it.at);
            (label[0] - at[0]).hypot(label[1] - at[1])
        };
        let inside = self.placed.drawing.labels.iter().map(|it| (away(it), it));
        let inside = inside.filter(|(away, _)| *away <= radius);
        let nearest = inside.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or_else(String::new, |(_, it)| it.text.clone())
    }

    fn wall(&mut self, item: &Item<'_>, shape: &Shape) -> Result<(), Problem> {
        let placing = &self.placed.placing;
        let mut points: Vec<[f64; 2]> = match &shape.geometry {
            Geometry::Path { points, closed } => {
                let mut points: Vec<_> = points.iter().map(|it| placing.place(*it)).collect();
                if *closed {
                    points.extend(points.first().copied());
                }
                points
            }
            Geometry::Circle { at, radius } => {
                let on = |angle: f64| [at[0] + radius * angle.cos(), at[1] + radius * angle.sin()];
                let angles = curve::angles(0.0, std::f64::consts::TAU);
                angles.map(|it| placing.place(on(it))).collect()
            }
            Geometry::Point(_) => return Ok(()),
        };
        points = curve::simplified(&points, TOLERANCE_M);
        let height = checked_height(item)?;
        for ends in points.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            if (from[0] - to[0]).hypot(from[1] - to[1]) < WALL_LEAST_M {
                self.leave(item, "short", text::WhyShort.fixed());
                continue;
            }
            counted(self.plan.walls.len(), WALLS_MAX)?;
            let name = item.name.unwrap_or(item.layer).to_owned();
            self.plan.walls.push(Wall { name, from, to, height });
        }
        Ok(())
    }

    fn spot(&mut self, item: &Item<'_>, shape: &Shape) -> Result<(), Problem> {
        // Lines of a symbol are no places.
        if shape.part {
            return Ok(());
        }
        let at = match &shape.geometry {
            Geometry::Point(at) | Geometry::Circle { at, .. } => *at,
            Geometry::Path { points, .. } => match curve::round(points) {
                Some((at, _)) => at,
                None => {
                    self.leave(item, "place", text::WhyNoPlace.fixed());
                    return Ok(());
                }
            },
        };
        let monitor = item.role == Role::Monitor;
        let height = match (item.height, monitor) {
            (None, true) => None,
            _ => Some(checked_height(item)?),
        };
        let at = self.placed.placing.place(at);
        let spots = if monitor { &mut self.plan.monitors } else { &mut self.plan.detectors };
        counted(spots.len(), SPOTS_MAX)?;
        spots.push(Spot { name: item.name.unwrap_or(item.layer).to_owned(), at, height });
        Ok(())
    }

    fn leave(&mut self, item: &Item<'_>, key: &'static str, why: Fixed) {
        let key = (item.layer.to_owned(), key);
        self.left_out.entry(key).or_insert_with(|| (0, why)).0 += 1;
    }

    /// Gives each its own name.
    fn names(&mut self) {
        let Plan { tanks, walls, monitors, detectors, .. } = &mut self.plan;
        unique(tanks.iter_mut().map(|it| &mut it.name));
        unique(walls.iter_mut().map(|it| &mut it.name));
        unique(monitors.iter_mut().map(|it| &mut it.name));
        unique(detectors.iter_mut().map(|it| &mut it.name));
    }
}

/// Adds a number to names that are there several times.
fn unique<'a>(names: impl Iterator<Item = &'a mut String>) {
    let names: Vec<&mut String> = names.collect();
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for name in &names {
        *times.entry((**name).clone()).or_insert(0) += 1;
    }
    let mut taken: BTreeSet<String> =
        times.iter().filter(|(_, count)| **count == 1).map(|(name, _)| name.clone()).collect();
    let mut next: BTreeMap<String, usize> = BTreeMap::new();
    for name in names {
        if times.get(name.as_str()).is_some_and(|it| *it == 1) {
            continue;
        }
        let number = next.entry(name.clone()).or_insert(1);
        let mut numbered = format!("{name}-{number}");
        while !taken.insert(numbered.clone()) {
            *number += 1;
            numbered = format!("{name}-{number}");
        }
        *number += 1;
        *name = numbered;
    }
}

fn checked_height(item: &Item<'_>) -> Result<f64, Problem> {
    let (layer, role) = (item.layer, item.role.name());
    let Some(height) = item.height else {
        return Err(Problem::new(text::NoHeight { layer }, text::NoHeightRemedy { layer, role }));
    };
    if height > 0.0 && height <= HIGHEST_M {
        return Ok(height);
    }
    let (metres, most) = (Decimal(height, 3), HIGHEST_M);
    Err(Problem::new(
        text::WrongHeight { layer, metres, most },
        text::NoHeightRemedy { layer, role },
    ))
}

fn counted(count: usize, most: usize) -> Result<(), Problem> {
    if count < most {
        return Ok(());
    }
    Err(Problem::new(text::TooManyFound { most }, text::TooManyFoundRemedy))
}

/// Names of layers, as many as fit in a message.
fn known(layers: &[crate::Layer]) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = layers.iter().take(SHOWN).map(|it| it.name.as_str()).collect();
    let more = if layers.len() > SHOWN { ", …" } else { "" };
    format!("{}{more}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_whatever_they_were() {
        let mut names = ["W", "T", "W", "W-1", "W", "T-1"].map(str::to_owned);
        unique(names.iter_mut());
        assert_eq!(names, ["W-2", "T", "W-3", "W-1", "W-4", "T-1"]);
    }
}
