//! A site's drawing, bytes in, obstacles and places out (ours): no I/O, no clock.
//!
//! ```text
//! bytes ─▶ read ─▶ Drawing (layers, shapes, in the drawing's own coordinates)
//!                    │  + what a person states: unit, known points, north
//!                    ▼
//!                  placing::place ─▶ Placing (one scale, one turn, one offset) and what checks it
//!                    │  + which layer is what, with heights
//!                    ▼
//!                  site::site ─▶ Plan: tanks, walls, monitors, detectors ─▶ pieces: TOML for hub.toml
//! ```
//!
//! **Units are asked, never guessed.** A drawing that names its unit only proposes it. A stated unit that
//! differs from the proposal needs a known distance or two known points.
//!
//! Whatever is in a file is bounded by [`Limits`]; everything wrong with it is a [`Problem`] in both
//! languages: what, in which line, what to do.

mod curve;
mod dxf;
mod fit;
mod geodetic;
mod geojson;
mod matrix;
mod picture;
pub mod pieces;
pub mod placing;
mod problem;
pub mod report;
mod shape;
pub mod site;
mod svg;
mod unit;
pub mod written;

pub use geodetic::Geodetic;
pub use problem::Problem;
pub use shape::{Drawing, Format, Geometry, Height, Label, Layer, Shape};
pub use unit::{Stated, Unit};

use lafet_texts::drawing as text;

/// How much of a file is read. What goes beyond is refused in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the file.
    pub bytes: usize,
    /// Shapes, those of inserted blocks counted each time.
    pub shapes: usize,
    /// Points of all shapes.
    pub points: usize,
    /// Layers.
    pub layers: usize,
    /// Texts that may name what they are in.
    pub labels: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: 64 << 20, shapes: 200_000, points: 1_000_000, layers: 2000, labels: 20_000 }
    }
}

/// No coordinate of a drawing is farther from its zero: that of a national grid in millimetres is nearer.
pub const COORDINATE_MAX: f64 = 1e12;
/// Longest name of a layer or shape, characters.
pub const NAME_MAX: usize = 64;
/// Deepest nesting of blocks, groups and references.
pub const DEPTH_MAX: usize = 16;

/// Reads a drawing of any known format, which its first bytes show.
///
/// # Errors
///
/// What is wrong with the file, where, and what to do.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Drawing, Problem> {
    if bytes.len() > limits.bytes {
        let (bytes, most) = (bytes.len(), limits.bytes);
        return Err(Problem::new(text::TooLong { bytes, most }, text::TooMuchRemedy));
    }
    match Format::of(bytes)? {
        Format::Dxf => dxf::read(bytes, limits),
        Format::GeoJson => geojson::read(bytes, limits),
        Format::Svg => svg::read(bytes, limits),
        Format::Png | Format::Jpeg => picture::read(bytes, limits),
    }
}
