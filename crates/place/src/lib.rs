//! The geometry of an installation of fire monitors (ours): pure functions, no I/O, no clock.
//!
//! ```text
//! bearings of stations ─▶ locate, cone, fires ─▶ Fix: place and ellipse; ghosts are never aimed at
//! monitors, supply ─▶ reach (lafet-ballistics) ─▶ planner: which monitors on which fire
//!                                              └▶ coverage: jets per square metre, by wind
//! ```
//!
//! **Units.** Metres; radians inside, degrees only in files; l/min; MPa; seconds. The site's axes are east,
//! north and up. A *bearing* is clockwise from north, an *azimuth* that of a device: positive to the
//! left of its axis, as on the wire. Every input is bounded; NaN and infinity are refused with a
//! [`Problem`] in both languages.

pub mod accuracy;
pub mod align;
pub mod cone;
pub mod coverage;
pub mod draw;
pub mod example;
pub mod fires;
pub mod flown;
mod linear;
pub mod locate;
pub mod obstacle;
pub mod planner;
pub mod reach;
pub mod site;
pub mod station;
pub mod supply;
mod text;
pub mod throws;

pub use linear::wrapped;
pub use text::Problem;

/// Most monitors of a site; a set of them is a `u64`.
pub const MONITORS_MAX: usize = 64;
/// Most fires at a time.
pub const FIRES_MAX: usize = 64;
/// Most obstacles.
pub const OBSTACLES_MAX: usize = 256;
/// Most keep-out zones and sectors.
pub const KEEP_OUTS_MAX: usize = 256;
/// Most detector stations, and most bearings that are looked at together.
pub const STATIONS_MAX: usize = 64;
/// See [`STATIONS_MAX`].
pub const BEARINGS_MAX: usize = 64;
/// Most winds of a coverage, without still air.
pub const WINDS_MAX: usize = 16;
/// Most cells of a grid.
pub const CELLS_MAX: usize = 1_000_000;
/// No place is farther than this from the origin of the site, m.
pub const FARTHEST_M: f64 = 10_000.0;

/// A place: east, north, up, m.
pub type Place = [f64; 3];
