//! A site for tests and for the figures of docs/coverage.md: 100 m × 100 m, 16 winds.

use std::f64::consts::{PI, TAU};

use crate::coverage::Area;
use crate::obstacle::Body;
use crate::site::{For, KeepOut, Kept, Monitor, Site, Wind};
use crate::supply::Supply;

/// Monitors of 20 and 40 l/s around two tanks and a building, with a place for people. Two flow
/// together.
pub fn site(monitors: usize) -> (Site, Area) {
    let monitors: Vec<Monitor> = (0..monitors).map(|index| monitor(index, monitors)).collect();
    let cylinder =
        |at: [f64; 2], radius_m, top| Body::Cylinder { at, radius_m, heights: [0.0, top] };
    let building =
        Body::Box { at: [75.0, 75.0], size: [16.0, 10.0], heading: 0.5, heights: [0.0, 8.0] };
    let people =
        Body::Box { at: [20.0, 80.0], size: [6.0, 6.0], heading: 0.0, heights: [0.0, 3.0] };
    let k_sum = 2400.0 / 0.8_f64.sqrt();
    let site = Site {
        monitors,
        obstacles: vec![
            cylinder([35.0, 40.0], 8.0, 9.0),
            cylinder([62.0, 35.0], 8.0, 9.0),
            building,
        ],
        keep_outs: vec![KeepOut { of: For::People, place: Kept::Zone(people) }],
        // As good as constant, so that the site stays the same for every number of monitors.
        supply: Supply::curve(&[[0.0, 0.9], [k_sum, 0.8], [20.0 * k_sum, 0.4]])
            .unwrap_or_else(|problem| unreachable!("{problem}")),
        clearance_m: 1.0,
    };
    let wind = |index: u32| Wind {
        from: TAU * f64::from(index) / 16.0,
        speed_mps: if index.is_multiple_of(2) { 5.0 } else { 9.0 },
    };
    let area = Area {
        corner: [0.0; 2],
        size: [100.0; 2],
        cell_m: 1.0,
        plane_m: 0.0,
        winds: (0..16).map(wind).collect(),
        flowing: site.monitors.len().min(2),
    };
    (site, area)
}

/// Around the area, each looking to its middle.
fn monitor(index: usize, all: usize) -> Monitor {
    let angle = TAU * (index as f64 + 0.3) / all as f64;
    let at = [50.0 + 46.0 * angle.sin(), 50.0 + 46.0 * angle.cos()];
    let large = index.is_multiple_of(3);
    let (outlet_mm, flow_lpm) = if large { (40.0, 2400.0) } else { (28.0, 1200.0) };
    Monitor {
        name: format!("M{}", index + 1),
        at,
        height_m: if large { 5.0 } else { 2.0 },
        heading: angle - PI,
        azimuths: [-2.8, 2.8],
        elevations: [-0.26, 1.3],
        outlet_mm,
        nozzle_mm: 60.0,
        k_lpm: flow_lpm / 0.8_f64.sqrt(),
        speeds: [0.35, 0.2],
    }
}
